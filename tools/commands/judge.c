/* judge: whether a run has reached all that was asked for, and why not. */
#include "commands/judge.h"

#include "job/held.h"
#include "job/job.h"
#include "job/states.h"
#include "terminal/message.h"

#include "base/printf.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/** Add a part to the reason, after "; " if it is not the first. */
static void add_reason(pl_result *result, const char *format, ...) PL_PRINTF(2, 3);
static void add_reason(pl_result *result, const char *format, ...) {
    const size_t used = strlen(result->reason), size = sizeof result->reason;
    const char *joint = used ? "; " : "";
    const size_t begin = used + strlen(joint);
    if (begin >= size)
        return;
    memcpy(result->reason + used, joint, strlen(joint) + 1);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(result->reason + begin, size - begin, format, arguments);
    va_end(arguments);
}

static const char *is_or_are(int64_t n) {
    return n == 1 ? " is" : "s are";
}

/** Add which options hold inverted elements. */
static void judge_holders(const pl_job *job, pl_result *result) {
    static const char *const advice[PL_N_HOLDERS] = {"run without it to repair them",
                                                     "hold fewer groups to repair them",
                                                     "--ignore-regions lets them move"};
    const int64_t *n_held = result->unfixable.n_held;
    const int is_default = job->arguments->layers == PL_LAYERS_BY_TYPE;
    for (int i = 0; i < PL_N_HOLDERS; i++)
        if (n_held[i] > 0)
            add_reason(result, "%" PRId64 " of these stay%s inverted because %s %s nodes: %s",
                       n_held[i], n_held[i] == 1 ? "s" : "", pl_holder_option(job, (pl_holder)i),
                       i == PL_HOLDER_REGIONS ? "hold their" : "holds their",
                       i == PL_HOLDER_LAYERS && is_default ? "--layers ignore lets them move"
                                                           : advice[i]);
}

/** Return what may help elements that the free nodes cannot. */
static const char *next_step(const pl_job *job) {
    const pl_arguments *arguments = job->arguments;
    if (job->mesh.dim == 3 && !arguments->slide_curved)
        return "try --slide curved, or mesh them again";
    if (!arguments->slide)
        return "try --slide auto, or mesh them again";
    return arguments->n_fix > 0 ? "hold fewer groups, or mesh them again" : "mesh them again";
}

/** Add the inverted elements that no option holds and no place of the free nodes makes valid. */
static void judge_unfixable(const pl_job *job, pl_result *result) {
    const pl_unfixable *unfixable = &result->unfixable;
    const int64_t n = unfixable->n - pl_unfixable_held(unfixable);
    char list[PL_ELEMENTS_SIZE];
    if (n == 0)
        return;
    pl_unfixable_name(job, unfixable, list);
    const int is_hopeless = result->smooth.n_not_enclosed > 0 || job->plan_info.n_wrapped > 0;
    add_reason(result, "%" PRId64 " of these cannot be made valid by moving free nodes (%s)%s%s", n,
               list, is_hopeless ? "" : ": ", is_hopeless ? "" : next_step(job));
}

/** Add why inverted elements are left. */
static void judge_inverted(const pl_job *job, pl_result *result) {
    const pl_unfixable *unfixable = &result->unfixable;
    const pl_cells_validity *validity = &result->validity_after;
    const int64_t inverted = pl_cells_validity_faults(validity, &result->after);
    const planish_method method = job->options.method;
    if (inverted == 0)
        return;
    if (job->is_surface) {
        add_reason(result,
                   "%" PRId64
                   " element%s without area or turned over against the surface: %s as %s",
                   inverted, is_or_are(inverted), inverted == 1 ? "it stays" : "they stay",
                   inverted == 1 ? "it was" : "they were");
        return;
    }
    if (method != PLANISH_METHOD_PLANISH)
        add_reason(result,
                   "%" PRId64 " element%s inverted, %" PRId64
                   " before: the method %s may invert elements",
                   inverted, is_or_are(inverted),
                   pl_cells_validity_faults(&result->validity_before, &result->before),
                   pl_method_name(method));
    else
        add_reason(result, "%" PRId64 " inverted element%s left", inverted, is_or_are(inverted));
    judge_holders(job, result);
    judge_unfixable(job, result);
    if (validity->n_inside > 0)
        add_reason(result,
                   "%" PRId64 " of these %s inverted inside%s, though the corners are right",
                   validity->n_inside, validity->n_inside == 1 ? "is" : "are",
                   job->has_types ? "" : " by mid-side nodes");
    if (job->plan_info.n_wrapped > 0)
        add_reason(result,
                   "elements that wrap around a periodic domain (%" PRId64 ") look inverted",
                   job->plan_info.n_wrapped);
    if (unfixable->n_undecided > 0)
        add_reason(result, "planish had no time to check this for all inverted elements");
    if (result->smooth.n_not_enclosed > 0)
        add_reason(result, "%" PRId64 " are in components whose boundary encloses no positive %s",
                   result->smooth.n_not_enclosed, job->mesh.dim == 3 ? "volume" : "area");
    if (!job->options.untangle)
        add_reason(result, "untangling was switched off by --no-untangle");
}

/** Add how many elements are below their minimum volume, and how many are newly reversed: repaired
 *  ones whose nodes are listed in the wrong order are negative to a solver. */
static void judge_others(pl_result *result) {
    const pl_volumes *volumes = &result->volumes;
    const int64_t n = result->reversed.n_new;
    if (volumes->n_below > 0)
        add_reason(result, "%" PRId64 " element%s below the minimum volume", volumes->n_below,
                   is_or_are(volumes->n_below));
    if (volumes->n_infeasible > 0)
        add_reason(result, "%" PRId64 " of these cannot reach it by moving free nodes",
                   volumes->n_infeasible);
    if (volumes->n_below > 0 && volumes->n_undecided > 0)
        add_reason(result, "planish had no time to check this for all elements below it");
    if (n > 0)
        add_reason(
            result,
            "%" PRId64 " element%s reversed now: the file lists %s nodes in the wrong order, and a "
            "solver may reject %s. planish does not renumber elements, because loads and surfaces "
            "refer to their faces by number. Swap two nodes of each in the program that made the "
            "mesh, or mesh that region again",
            n, is_or_are(n), n == 1 ? "its" : "their", n == 1 ? "it" : "them");
}

int pl_judge(const pl_job *job, pl_result *result) {
    char text[sizeof result->reason];
    judge_inverted(job, result);
    judge_others(result);
    if (result->smooth.stop == PLANISH_STOP_TIME_LIMIT)
        add_reason(result, "stopped by the time limit of %g s before convergence",
                   job->arguments->library.time_limit);
    if (job->onto.after.n_off > 0)
        add_reason(result, "%" PRId64 " node%s not on %s yet, up to %.3g off%s",
                   job->onto.after.n_off, is_or_are(job->onto.after.n_off), job->arguments->onto,
                   job->onto.after.farthest,
                   result->smooth.stop == PLANISH_STOP_TIME_LIMIT ||
                           result->smooth.stop == PLANISH_STOP_INTERRUPTED
                       ? ""
                       : ": the move would invert elements, or nearly invert them");
    if (job->onto.after.n_out_of_reach > 0)
        add_reason(result, "%" PRId64 " node%s of the surface %s no place on %s",
                   job->onto.after.n_out_of_reach, job->onto.after.n_out_of_reach == 1 ? "" : "s",
                   job->onto.after.n_out_of_reach == 1 ? "has" : "have", job->arguments->onto);
    if (result->smooth.stop == PLANISH_STOP_INTERRUPTED)
        add_reason(result, "interrupted by a signal before convergence");
    if (result->reason[0])
        return PL_EXIT_PARTLY;
    if (job->plan_info.n_free + job->plan_info.n_sliding == 0) {
        pl_held_explain(job, text, sizeof text);
        add_reason(result, "no node is free to move%s%s; the mesh is unchanged",
                   text[0] ? ": " : "", text);
    }
    return PL_EXIT_DONE;
}
