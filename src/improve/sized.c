/* sized: sweeps of a mesh whose elements are to have sizes that depend on where they are.
 *
 * Sweeps know targets that stay. So targets are made anew after each sweep, until F against those where the
 * elements are falls no more. It may rise at first: elements shrink before others come after them. A sweep
 * is a step towards a mesh that it leaves as it is, and slow on large meshes, so steps are mixed (mixing.h)
 * where that lowers F. What stands in the end is the mesh of the least F on the way.
 */
#include "improve/improve.h"
#include "improve/mixing.h"

#include "base/memory.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

/* Sweeps in a row that may let F rise, or fall by next to nothing. */
enum { PATIENCE = 20 };

/** Sweeps under way, and the mesh that stands. */
typedef struct sized {
    pl_run *run;
    int64_t n;      /* numbers of all coordinates */
    double *before; /* [n] room of trial */
    double *from;   /* [n] where a sweep began */
    double *swept;  /* [n] where it ended */
    pl_trial trial;
    pl_mixing mixing;
    double latest; /* F */
} sized;

/** F of the mesh that stands. */
static double least_of(const sized *s) {
    return pl_objective_of_movable(s->run->options, &s->trial.standing);
}

/** Prepare for a sweep. Elements may be as bad as the worst of the mesh as it came: the limits that the mesh
 *  has now would be narrower. */
static void prepare(pl_run *r) {
    pl_run_prepare(r);
    if (!(r->worst_at_start < INFINITY))
        return;
    r->problem.limits.rr2 = fmax(r->problem.limits.rr2, r->limits_at_start.rr2 * PL_LIMIT_MARGIN);
    pl_watch_limit(&r->watch, fmax(r->watch.worst_ar2, r->worst_at_start * PL_LIMIT_MARGIN));
}

/** Measure against the targets where the elements are now, by which sweeps go on. */
static void measure_anew(sized *s) {
    pl_run *r = s->run;
    pl_plan_fit_sizes(r->plan, r->plan->scratch.coordinates, r->plan->inner);
    pl_run_measure(r);
    prepare(r);
    s->latest = pl_objective_of_movable(r->options, &r->sums);
}

/** Whether the mesh, as measured, is no worse than the one that stands, or as it came, by what is promised
 *  beside F. */
static int is_sound(const sized *s) {
    return s->run->sums.inverted <= s->trial.standing.inverted &&
           s->run->sums.radius_max <= s->run->worst_at_start;
}

/** Let the mesh as it is now stand if it is better than the one that does. */
static void take_better(sized *s) {
    if (!is_sound(s) || !(s->latest < least_of(s)))
        return;
    pl_trial_end(&s->trial, 1);
    prepare(s->run);
    pl_trial_begin(s->run, 0, s->before, &s->trial);
}

/** Go where the steps lead, if F is lower there than before the last one; the mesh is measured. */
static void mix(sized *s) {
    double *x = s->run->plan->scratch.coordinates;
    const size_t bytes = (size_t)s->n * sizeof *x;
    const double before = s->latest;
    memcpy(s->swept, x, bytes);
    if (pl_mixing_mix(&s->mixing, s->from, x)) {
        measure_anew(s);
        if (is_sound(s) && s->latest < before)
            return;
        memcpy(x, s->swept, bytes);
        pl_mixing_forget(&s->mixing);
    }
    measure_anew(s);
}

/** Sweep, each time with new targets, until F does not fall. */
static void follow(sized *s) {
    pl_run *r = s->run;
    const double tolerance = r->options->tolerance;
    int64_t visits = 1;
    r->stop = PLANISH_STOP_MAX_SWEEPS;
    for (int idle = 0; pl_run_sweeps_left(r) > 0;) {
        const double before = s->latest;
        memcpy(s->from, r->plan->scratch.coordinates, (size_t)s->n * sizeof *s->from);
        const int is_cut = pl_run_sweep(r, &visits);
        if (is_cut)
            measure_anew(s);
        else
            mix(s);
        take_better(s);
        if (is_cut)
            return;
        idle = s->latest < before * (1 - tolerance) ? 0 : idle + 1;
        if (visits == 0 || idle == PATIENCE) {
            r->stop = PLANISH_STOP_CONVERGED;
            return;
        }
    }
}

int pl_run_sized_sweeps(pl_run *r, planish_error *error) {
    sized s = {.run = r, .n = r->plan->work.n_nodes * r->plan->dim};
    s.before = pl_alloc(3 * s.n, sizeof *s.before);
    s.from = s.before ? s.before + s.n : NULL;
    s.swept = s.before ? s.from + s.n : NULL;
    int status = PLANISH_OK;
    if (s.before && pl_mixing_create(s.n, r->plan->threads, &s.mixing)) {
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
    return status;
}
