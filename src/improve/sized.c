/* sized: sweeps of a mesh whose elements are to have sizes that depend on where they are.
 *
 * Sweeps know targets that stay. So targets are made anew after each sweep, until F against those where the
 * elements are falls no more. It may rise at first: elements shrink before others come after them. A sweep
 * is a step towards a mesh that it leaves as it is, and slow on large meshes, so steps are mixed (mixing.h)
 * where that lowers F. What stands in the end is the mesh of the least F on the way whose worst element is
 * no worse than that of the start: where targets have made some worse, their nodes go back.
 */
#include "improve/improve.h"
#include "improve/mixing.h"

#include "base/memory.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

/* Sweeps in a row that may let F rise, or fall by next to nothing; rounds in which nodes go back. */
enum { PATIENCE = 20, ROUNDS = 20 };

/* A mesh that is not sound is mended, which takes some looks at all elements, where it would lower F by this
 * part; and the last one. */
#define WORTH_MENDING 1e-3

/** Sweeps under way, and the mesh that stands. */
typedef struct sized {
    pl_run *run;
    int64_t n;      /* numbers of all coordinates */
    double *before; /* [n] room of trial */
    double *from;   /* [n] where a sweep began */
    double *swept;  /* [n] where it ended, or before it was mended */
    pl_trial trial;
    pl_mixing mixing;
    uint8_t *state;          /* [elements] room */
    double latest;           /* F */
    double recent[PATIENCE]; /* after the last sweeps */
    int n_swept;
} sized;

/** F of the mesh that stands. */
static double least_of(const sized *s) {
    return pl_objective_of_movable(s->run->options, &s->trial.standing);
}

/** Measure against the targets where the elements are now, by which sweeps go on. */
static void measure_anew(sized *s) {
    pl_run *r = s->run;
    pl_plan_fit_sizes(r->plan, r->plan->scratch.coordinates, r->plan->inner);
    pl_run_measure(r);
    pl_run_prepare(r);
    s->latest = pl_objective_of_movable(r->options, &r->sums);
}

/** Whether the mesh, as measured, is no worse than the one that stands, or as it came, by what is promised
 *  beside F. */
static int is_sound(const sized *s) {
    return s->run->sums.inverted <= s->trial.standing.inverted &&
           s->run->sums.below <= s->trial.standing.below &&
           s->run->sums.radius_max <= s->run->worst_at_start &&
           s->run->sums.corner_max <= s->run->limits_at_start.rr2;
}

/** Put the nodes of an element back to where they stand. */
static int64_t put_back_nodes(const sized *s, int64_t element) {
    const planish_plan *plan = s->run->plan;
    const size_t bytes = (size_t)plan->dim * sizeof *s->before;
    int64_t n = 0;
    for (int j = 0; j <= plan->dim; j++) {
        const int64_t at = (int64_t)pl_plan_inner(plan, element, j) * plan->dim;
        n += memcmp(plan->scratch.coordinates + at, s->before + at, bytes) != 0;
        memcpy(plan->scratch.coordinates + at, s->before + at, bytes);
    }
    return n;
}

/** Put back the nodes of elements that are worse than they may be; how many had moved. */
static int64_t put_back_bad(sized *s) {
    const pl_run *r = s->run;
    const pl_view all = pl_view_of_all_elements(&r->plan->work);
    int64_t n = 0;
    pl_find_worse_corners(&all, r->plan->scratch.to_measure, sqrt(r->limits_at_start.rr2), INFINITY,
                          sqrt(r->worst_at_start), r->plan->threads, s->state);
    for (int64_t i = 0; i < r->plan->work.n_elements; i++)
        if (s->state[i] != PL_FINE)
            n += put_back_nodes(s, i);
    return n;
}

/** Mend a mesh that is not sound. An element whose nodes are where they stand has the target that it has
 *  there, so this ends. */
static void mend(sized *s) {
    for (int i = 0; i < ROUNDS && !is_sound(s) && put_back_bad(s) > 0; i++) {
        pl_follow(s->run->plan, &s->run->problem);
        measure_anew(s);
    }
}

/** Let the mesh as it is now stand if it is better than the one that does. */
static void take_better(sized *s) {
    if (!is_sound(s) || !(s->latest < least_of(s)))
        return;
    pl_trial_end(&s->trial, 1);
    pl_run_prepare(s->run);
    pl_trial_begin(s->run, 0, s->before, &s->trial);
}

/** Let the mesh as it is now, or a mended one, stand if its F is lower by that part. Sweeps go on from what is
 *  not mended. */
static void take_mended(sized *s, double part) {
    double *x = s->run->plan->scratch.coordinates;
    if (is_sound(s) || !(s->latest < least_of(s) * (1 - part))) {
        take_better(s);
        return;
    }
    memcpy(s->swept, x, (size_t)s->n * sizeof *x);
    mend(s);
    take_better(s);
    memcpy(x, s->swept, (size_t)s->n * sizeof *x);
    measure_anew(s);
}

/** Bring free nodes to places that they may have and that can be stored; where there is none, and nodes that
 *  slide, back to where the sweep has left them. */
static void admit(const sized *s) {
    const planish_plan *plan = s->run->plan;
    const pl_star_problem *problem = &s->run->problem;
    const size_t bytes = (size_t)plan->dim * sizeof *s->swept;
    double *x = plan->scratch.coordinates;
    for (int64_t i = 0; i < plan->interior.stars.n_stars; i++) {
        const int64_t node = plan->interior.centre[i], at = node * plan->dim;
        if (memcmp(x + at, s->swept + at, bytes) != 0 &&
            !pl_star_admit(problem, (int32_t)node, plan->dim, x + at))
            memcpy(x + at, s->swept + at, bytes);
    }
    for (int64_t i = 0; i < plan->sliding.stars.n_stars; i++) {
        const int64_t at = plan->sliding.centre[i] * (int64_t)plan->dim;
        memcpy(x + at, s->swept + at, bytes);
    }
    pl_follow(plan, problem);
}

/** Whether no element is inverted or below its minimum volume: they are only counted, and one could be repaired
 *  at the cost of another one. */
static int may_mix(const sized *s) {
    return s->trial.standing.inverted == 0 && s->trial.standing.below == 0;
}

/** Go where the steps lead, if F is lower there than before the last one; the mesh is measured. */
static void mix(sized *s) {
    double *x = s->run->plan->scratch.coordinates;
    const size_t bytes = (size_t)s->n * sizeof *x;
    const double before = s->latest;
    memcpy(s->swept, x, bytes);
    if (may_mix(s) && pl_mixing_mix(&s->mixing, s->from, x)) {
        admit(s);
        measure_anew(s);
        if (is_sound(s) && s->latest < before)
            return;
        memcpy(x, s->swept, bytes);
        pl_mixing_forget(&s->mixing);
    }
    measure_anew(s);
}

/** Take note of F. Whether it is lower than after each of the last sweeps, by more than the tolerance. */
static int has_fallen(sized *s) {
    double lowest = INFINITY;
    for (int i = 0; i < PATIENCE; i++)
        lowest = fmin(lowest, s->recent[i]);
    s->recent[s->n_swept++ % PATIENCE] = s->latest;
    return s->latest < lowest * (1 - s->run->options->tolerance);
}

/** Sweep, each time with new targets, until F does not fall. */
static void follow(sized *s) {
    pl_run *r = s->run;
    int64_t visits = 1;
    r->stop = PLANISH_STOP_MAX_SWEEPS;
    for (int i = 0; i < PATIENCE; i++)
        s->recent[i] = INFINITY;
    for (int idle = 0; pl_run_sweeps_left(r) > 0;) {
        memcpy(s->from, r->plan->scratch.coordinates, (size_t)s->n * sizeof *s->from);
        const int is_cut = pl_run_sweep(r, &visits);
        if (is_cut) {
            measure_anew(s);
            take_better(s);
            return;
        }
        mix(s);
        idle = has_fallen(s) ? 0 : idle + 1;
        take_mended(s, WORTH_MENDING);
        if (visits == 0 || idle == PATIENCE) {
            r->stop = PLANISH_STOP_CONVERGED;
            break;
        }
    }
    take_mended(s, 0);
}

int pl_run_sized_sweeps(pl_run *r, planish_error *error) {
    sized s = {.run = r, .n = r->plan->work.n_nodes * r->plan->dim};
    s.before = pl_alloc(3 * s.n, sizeof *s.before);
    s.from = s.before ? s.before + s.n : NULL;
    s.swept = s.before ? s.from + s.n : NULL;
    s.state = pl_alloc(r->plan->work.n_elements, sizeof *s.state);
    int status = PLANISH_OK;
    if (s.before && s.state && pl_mixing_create(s.n, r->plan->threads, &s.mixing)) {
        s.latest = pl_objective_of_movable(r->options, &r->sums);
        pl_trial_begin(r, 0, s.before, &s.trial);
        follow(&s);
        pl_trial_end(&s.trial, 0);
        measure_anew(&s);
    } else {
        status = pl_fail_memory(error, "sweeps towards sizes");
    }
    pl_mixing_destroy(&s.mixing);
    pl_free(s.before);
    pl_free(s.state);
    return status;
}
