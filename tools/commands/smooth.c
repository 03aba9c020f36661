/* smooth: the command `planish smooth`, from mesh file to better mesh file.
 *
 *     options -> read -> plan -> measure -> smooth -> measure -> write -> report
 *
 * Every step returns 0, or an exit status after a message; the first that fails ends the run.
 */
#include "commands/commands.h"

#include "commands/promises.h"
#include "job/cells.h"
#include "job/curved.h"
#include "job/held.h"
#include "job/job.h"
#include "job/layers.h"
#include "job/onto.h"
#include "terminal/message.h"
#include "job/output.h"
#include "job/progress.h"
#include "report/page.h"
#include "report/result.h"
#include "terminal/signals.h"
#include "report/table.h"
#include "terminal/text.h"
#include "job/states.h"

#include "base/clock.h"
#include "base/printf.h"
#include "base/status.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- the mesh that is written --------------------------------------------------------------- */

/** Whether the engine writes the output: of a mesh that it has read, or one that no format of
 *  planish_io writes, of coordinates as they are and elements of first order. */
static int engine_writes(const pl_job *job) {
    const char *output = job->arguments->output;
    return !job->file || (!planish_file_can_write(job->file, output) && !job->mesh.cells &&
                          job->engine->can_write && job->engine->can_write(output) &&
                          !planish_file_plane(job->file, NULL));
}

/** Check before the work what can be known of writing. Another extension than the input's asks for
 * a conversion. */
static int check_output(const pl_job *job) {
    const char *output = job->arguments->output;
    planish_error error;
    if (engine_writes(job))
        return 0;
    if (planish_file_can_write(job->file, output))
        return planish_file_check_output(job->file, output, &error)
                   ? pl_job_complain(job, PL_EXIT_FAILED, &error)
                   : 0;
    if (planish_file_can_convert(job->file, output))
        return 0;
    if (strcmp(output, "-") == 0)
        return pl_complain_usage("smooth", "'-' is not a file; standard output is /dev/stdout");
    planish_file_check_output(job->file, output, &error); /* tells the extensions */
    return pl_complain_usage("smooth", "%s, nor that of a format that planish converts to",
                             error.text);
}

static int write_mesh(pl_job *job, pl_result *result) {
    const char *output = job->arguments->output;
    uint64_t checksums[] = {result->input_checksum, result->checksum};
    planish_error error;
    int status;
    const double begin = pl_seconds();
    const int by_engine = engine_writes(job);
    if (!by_engine && !planish_file_can_write(job->file, output)) {
        status = pl_cells_convert(job, output);
    } else {
        /* Its memory is better used for the file's pages: what is written to fresh ones takes
         * longer. */
        job->engine->plan_destroy(job);
        const int code = by_engine ? job->engine->write(job, output, checksums, &error)
                                   : planish_file_write(job->file, output, job->mesh.coordinates,
                                                        job->options.threads,
                                                        pl_signals_temporary(PL_TEMPORARY_MESH),
                                                        PL_TEMPORARY_SIZE, &error);
        status = code ? pl_job_complain(job, PL_EXIT_FAILED, &error) : 0;
    }
    result->input_checksum = checksums[0];
    result->checksum = checksums[1];
    result->write_seconds = pl_seconds() - begin;
    return status;
}

/* ---- whether all was reached ---------------------------------------------------------------- */

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

/** Add why inverted elements are left. */
static void judge_inverted(const pl_job *job, pl_result *result) {
    const pl_unfixable *unfixable = &result->unfixable;
    const pl_validity *validity = &result->validity_after;
    const int64_t inverted = pl_validity_faults(validity, &result->after);
    const int64_t n_others = unfixable->n - pl_unfixable_held(unfixable);
    const planish_method method = job->options.method;
    if (inverted == 0)
        return;
    if (job->is_surface) {
        add_reason(result,
                   "%" PRId64 " element%s without area, or turned over against the surface: %s as "
                   "%s",
                   inverted, is_or_are(inverted), inverted == 1 ? "it stays" : "they stay",
                   inverted == 1 ? "it was" : "they were");
        return;
    }
    if (method != PLANISH_METHOD_PLANISH)
        add_reason(
            result,
            "%" PRId64 " element%s inverted, %" PRId64 " before: the method %s may invert elements",
            inverted, is_or_are(inverted),
            pl_validity_faults(&result->validity_before, &result->before), pl_method_name(method));
    else
        add_reason(result, "%" PRId64 " inverted element%s left", inverted, is_or_are(inverted));
    judge_holders(job, result);
    if (n_others > 0)
        add_reason(result, "%" PRId64 " of these cannot be made valid by moving free nodes",
                   n_others);
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
        add_reason(result, "there was no time to check all inverted elements for that");
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
        add_reason(result, "there was no time to check all elements below it for that");
    if (n > 0)
        add_reason(
            result,
            "%" PRId64 " element%s reversed now: the file lists %s nodes in the wrong order, and a "
            "solver may reject %s. planish does not renumber elements, because loads and surfaces "
            "refer to their faces by number. Swap two nodes of each in the program that made the "
            "mesh, or mesh that region again",
            n, is_or_are(n), n == 1 ? "its" : "their", n == 1 ? "it" : "them");
}

/** Find out whether all that was asked for was reached, and if not (or if there was nothing to do)
 *  why. */
static int judge(const pl_job *job, pl_result *result) {
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
                       : ": elements would be inverted, or nearly so");
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

/* ---- what is told --------------------------------------------------------------------------- */

/** Print the table, the elements that fall short, and the reason; the table gives way to standard
 *  error if standard output carries data. */
static void print_table(const pl_job *job, const pl_result *result, int status) {
    const pl_arguments *arguments = job->arguments;
    if (arguments->verbosity != PL_QUIET) {
        pl_table_smooth(pl_output_takes_stdout(arguments) ? stderr : stdout, job, result);
        pl_volumes_print(stderr, job, &result->volumes);
        pl_unfixable_print(stderr, job, &result->unfixable);
        pl_inside_print(stderr, job, &result->validity_after);
        pl_curved_note_result(stderr, job, &result->surface);
        pl_reversed_print(stderr, job, result->reversed.state, result->after.n_reversed);
        if (result->reversed.n_new == 0)
            pl_table_reversed(stderr, &result->after);
    }
    if (result->reason[0] && status)
        pl_complain(status, "%s: %s", arguments->output, result->reason);
    else if (result->reason[0] && arguments->verbosity != PL_QUIET)
        pl_note(stderr, "%s: %s", arguments->output, result->reason);
}

/** Print what is odd about the mesh, and with -v how it is worked on. */
static void print_plan(const pl_job *job) {
    const planish_plan_info *info = &job->plan_info;
    char text[512];
    if (job->arguments->verbosity != PL_QUIET)
        pl_table_oddities(stderr, job);
    if (job->arguments->verbosity != PL_QUIET && job->n_with_parameters > 0)
        pl_note(stderr,
                "%" PRId64 " movable %s geometry parameters (u, v) in the "
                "file, which planish does not update. Remove them before you refine or curve the "
                "mesh (docs/formats.md)",
                job->n_with_parameters, job->n_with_parameters == 1 ? "node has" : "nodes have");
    if (job->arguments->verbosity != PL_QUIET && job->file_info.has_normals &&
        info->n_free + info->n_sliding > 0)
        pl_note(stderr,
                "the file has normals of nodes, which stay as they are: those of moved nodes "
                "are out of date (docs/formats.md)");
    if (job->arguments->verbosity < PL_VERBOSE)
        return;
    if (job->is_surface) {
        snprintf(text, sizeof text, "%d thread%s", info->threads, info->threads == 1 ? "" : "s");
        pl_text_wrap(stderr, text);
        pl_held_print(stderr, job);
        return;
    }
    snprintf(text, sizeof text, "%d thread%s (%s), kernel %s, %d colour%s, plan of %.1f MB",
             info->threads, info->threads == 1 ? "" : "s", info->binding, info->isa,
             info->n_colours, info->n_colours == 1 ? "" : "s", (double)info->bytes / 1e6);
    pl_text_wrap(stderr, text);
    pl_held_print(stderr, job);
}

/** Collect for the reports the mesh as it is now, called name. */
static int take_for_reports(const pl_job *job, const char *name, const pl_validity *validity,
                            uint64_t *checksum, pl_worst *worst, pl_picture **picture) {
    pl_cells cells = {.has_others = job->has_types};
    if (!job->mesh.coordinates)
        return 0; /* the engine has the mesh */
    if (job->arguments->json || job->arguments->report)
        *checksum = pl_job_checksum(job);
    if (job->has_types) {
        cells.cells = *job->mesh.cells;
        cells.aspect_ratio = validity->aspect_ratio;
    }
    const int status = pl_worst_find_asked(job, &cells, worst);
    return status ? status : pl_report_draw(job, name, picture);
}

/* ---- the steps ------------------------------------------------------------------------------ */

/** Measure the surface and the volumes of regions, before or after. */
static int measure_surface(const pl_job *job, int is_after, pl_result *result) {
    pl_surface_state *state = &result->surface;
    int status = 0;
    if (is_after || job->arguments->surface_of)
        status = pl_curved_measure(job, is_after ? &state->after : &state->before);
    state->is_known = !status && is_after;
    return status ? status : pl_volumes_of_regions(job, is_after, state);
}

/** From the mesh that was read to the sweeps: plan and measure. */
static int prepare(pl_job *job, pl_result *result, pl_progress *progress) {
    const int is_told = pl_job_is_told(job);
    int status;
    pl_progress_stage(progress, PL_STAGE_PLANNING);
    if (job->mesh.cells && !job->is_surface)
        job->options.rounding = pl_cells_rounding(job);
    if ((status = pl_onto_fit(job)))
        return status;
    if ((status = pl_job_find_slides(job)))
        return status;
    if ((status = pl_job_plan(job)))
        return status;
    pl_progress_stage(progress, PL_STAGE_MEASURING);
    if ((status = pl_job_count_parameters(job)))
        return status;
    if ((status = pl_held_count(job)))
        return status;
    print_plan(job);
    if (is_told && (status = pl_job_count_slides(job)))
        return status;
    if ((status = pl_job_measure(job, &result->before)))
        return status;
    if ((status = pl_validity_find(job, &result->validity_before)))
        return status;
    if (is_told && (status = pl_layers_count(job, &result->before)))
        return status;
    if (job->arguments->verbosity != PL_QUIET) {
        pl_layers_print(stderr, job);
        pl_curved_note_held(stderr, job, result->validity_before.quality.all.n_curved,
                            result->before.n_inverted);
        pl_onto_note(stderr, job, result->before.max_radius_ratio);
    }
    if (job->curved.shape && (status = measure_surface(job, 0, result)))
        return status;
    if ((status = pl_volumes_count(job, &result->below_before)))
        return status;
    if ((status = pl_reversed_find(job, result->before.n_reversed, &result->reversed.before)))
        return status;
    status = take_for_reports(job, "before", &result->validity_before, &result->input_checksum,
                              &result->worst_before, &result->picture);
    if (job->onto.fit) /* the file's, not that of the mesh as it was fitted */
        result->input_checksum = job->onto.input_checksum;
    return status;
}

static int run_sweeps(pl_job *job, pl_result *result, pl_progress *progress) {
    const planish_result *smooth = &result->smooth;
    planish_error error;
    char text[256];
    const double begin = pl_seconds();
    pl_signals_install_stop(); /* before, there is nothing to save: a signal just ends the program
                                */
    job->options.progress = pl_progress_step;
    job->options.progress_user = progress;
    const int code = job->engine->smooth(job, &result->smooth, &error);
    result->smooth_seconds = pl_seconds() - begin;
    if (code)
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    pl_progress_clear(progress);
    if (progress->out_of_memory) /* no reason to lose the mesh */
        pl_note(stderr,
                "%s: out of memory for the history of the sweeps; the report lacks some sweeps",
                job->arguments->output);
    if (job->arguments->verbosity >= PL_VERBOSE && pl_result_has_optimality(job)) {
        snprintf(text, sizeof text,
                 "KKT residual: largest %.3g, RMS %.3g; %" PRId64
                 " active constraints, largest multiplier %.3g",
                 smooth->kkt_residual, smooth->kkt_rms, smooth->n_active, smooth->max_multiplier);
        pl_text_wrap(stderr, text);
    }
    return 0;
}

/** Find out what came of the sweeps, and whether it may be written. */
static int check_result(pl_job *job, pl_result *result) {
    const planish_result *smooth = &result->smooth;
    int status;
    if ((status = pl_promises_keep(job, result)))
        return status;
    if ((status = pl_job_measure(job, &result->after)))
        return status;
    if ((status = pl_validity_find(job, &result->validity_after)))
        return status;
    if ((status = pl_volumes_find(job, smooth->min_volume, smooth, &result->volumes)))
        return status;
    const int64_t n_inverted = job->has_types
                                   ? pl_validity_faults(&result->validity_after, &result->after)
                                   : result->after.n_inverted;
    if ((status = pl_unfixable_find(job, n_inverted, smooth, &result->unfixable)))
        return status;
    if ((status = pl_unfixable_add_inside(job, &result->validity_after, smooth->n_hopeless,
                                          &result->unfixable)))
        return status;
    if ((status = pl_reversed_compare(job, &result->after, &result->reversed)))
        return status;
    if (job->curved.shape && (status = measure_surface(job, 1, result)))
        return status;
    if ((status = pl_onto_measure(job)))
        return status;
    return pl_promises_check(job, result);
}

/** Tell what came of it, once the mesh is written: table, JSON and page. report: 0, or the exit
 *  status if what they need is not there. */
static int report_result(const pl_job *job, pl_result *result, const pl_progress *progress,
                         int report) {
    const pl_arguments *arguments = job->arguments;
    result->total_seconds = pl_seconds() - job->begin;
    const int status = judge(job, result);
    print_table(job, result, status);
    /* The mesh is already written, so a failure makes the run a partial one. */
    if (!report && (arguments->json || arguments->report)) {
        char *text = pl_result_smooth_json(job, result, progress);
        report = pl_reports_write(arguments, text, result->picture, PL_EXIT_PARTLY);
        free(text);
    }
    return pl_flush_stdout(status ? status : report, PL_EXIT_PARTLY);
}

/** Complain of a mesh without any element that is smoothed, and say what it has. */
static int complain_of_types(const pl_job *job) {
    planish_error error;
    planish_cells cells;
    char counts[256];
    if (planish_file_cells(job->file, &cells, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    pl_cells_count(&cells, counts, sizeof counts);
    return pl_complain(PL_EXIT_FAILED,
                       "%s: %s: 'planish quality' measures these elements, but planish does not "
                       "smooth them; their nodes stay",
                       job->arguments->input, counts);
}

/** Whether an element of the mesh is of a type that is smoothed. */
static int has_smoothed(const pl_job *job) {
    const planish_cells *cells = job->mesh.cells;
    int has_simplex = !cells && job->mesh.n_elements > 0;
    for (int64_t i = 0; cells && i < cells->n && !has_simplex; i++)
        has_simplex = pl_cell_is_simplex((planish_cell_type)cells->type[i]);
    return has_simplex || job->has_types;
}

static int smooth_job(pl_job *job, pl_result *result, pl_progress *progress) {
    int status;
    if (job->file && !has_smoothed(job))
        return complain_of_types(job);
    if ((status = check_output(job)))
        return status;
    if ((status = prepare(job, result, progress)))
        return status;
    if ((status = run_sweeps(job, result, progress)))
        return status;
    pl_progress_stage(progress, PL_STAGE_CHECKING);
    if ((status = check_result(job, result)))
        return status;
    /* That takes no more memory than it did before the sweeps, and is no reason to lose the mesh.
     */
    const int report = take_for_reports(job, "after", &result->validity_after, &result->checksum,
                                        &result->worst_after, &result->picture)
                           ? PL_EXIT_PARTLY
                           : 0;
    pl_progress_stage(progress, PL_STAGE_WRITING);
    if ((status = write_mesh(job, result)))
        return status;
    pl_signals_set_written();
    pl_progress_clear(progress);
    return report_result(job, result, progress, report);
}

int pl_smooth_by(const pl_arguments *arguments, const pl_engine *engine) {
    pl_job job;
    pl_result result = {.reason = ""};
    pl_progress progress;
    int status = pl_output_check_all(arguments);
    if (status)
        return status;
    pl_progress_init(&progress, arguments);
    pl_progress_stage(&progress, PL_STAGE_READING);
    status = pl_job_read(&job, arguments, engine);
    if (!status)
        status = smooth_job(&job, &result, &progress);
    pl_progress_free(&progress);
    pl_validity_free(&result.validity_before);
    pl_validity_free(&result.validity_after);
    pl_volumes_free(&result.volumes);
    pl_unfixable_free(&result.unfixable);
    pl_reversed_free(&result.reversed);
    pl_surface_state_free(&result.surface);
    pl_worst_free(&result.worst_before);
    pl_worst_free(&result.worst_after);
    pl_picture_free(result.picture);
    pl_job_close(&job);
    return status;
}

int pl_smooth_command(const pl_arguments *arguments) {
    return pl_smooth_by(arguments, &pl_engine_here);
}
