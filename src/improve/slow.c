/* slow: meshes that are far from their optimum on a large scale.
 *
 * Sweeps even out what is wrong within a few elements, and bring on by one element each what is
 * wrong across the mesh. Two things that move all nodes at once help: to put every node at the mean
 * of its neighbours, part of the way, and L-BFGS for the sum of RR^2.
 */
#include "improve/improve.h"
#include "improve/lbfgs.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/parts.h"

#include <math.h>
#include <string.h>

enum { CHUNK = 256 }; /* stars that one thread takes at a time */
/* Parts of the way to the centred mesh that are tried: 1, 1/2, ...; and the sweeps after which it
 * must be better. */
enum { PARTS = 8, SWEEPS_OF_TRIAL = 4 };
/* Evaluations after which L-BFGS must have brought more than as many sweeps. */
enum { EVALUATIONS_OF_TRIAL = 30 };

/** The sum of RR^2 as a function of all free nodes but those whose stars are not valid. */
typedef struct objective_of_all {
    pl_run *run;
    uint8_t *in_patch;    /* [n_nodes] owned; 1: of stars that were valid beyond doubt at first */
    double rr2_limit;     /* no element may become worse, as its stars see it */
    double rr2_measured;  /* or as the mesh is measured, */
    double acuteness;     /* and so for the angles */
    double cell_ratio;    /* and AR^2 of cells; infinite: of none */
    pl_star_slope *slope; /* of the stars under way */
    int refused;          /* by one of the stars */
} objective_of_all;

static void slope_chunk(void *context, int64_t begin, int64_t end, int thread) {
    objective_of_all *f = context;
    const planish_plan *plan = f->run->plan;
    double *scratch = pl_star_scratch_of(&f->run->problem, thread);
    for (int64_t i = begin; i < end; i++) {
        pl_star_value value;
        if (!f->in_patch[plan->interior.centre[i]])
            continue;
        pl_star_ratio_of(plan->kernel, &f->run->problem, plan->dim)(&f->run->problem, i, scratch, 1,
                                                                    &value);
        memcpy(f->slope[i].gradient, value.gradient, sizeof value.gradient);
        memcpy(f->slope[i].hessian, value.hessian, sizeof value.hessian);
        if (!value.certain || !(value.max * (1 + value.error) <= f->rr2_limit))
            __atomic_store_n(&f->refused, 1, __ATOMIC_RELAXED);
    }
}

/** Measure the mesh where the nodes are; INFINITY unless every element is surely positive and
 *  good enough. The run's figures of the mesh change only if the value is at most enough. */
static double evaluate(void *context, double enough, pl_star_slope *slope) {
    objective_of_all *f = context;
    pl_run *r = f->run;
    const pl_objective_sums before = r->sums;
    const double measured = r->measured_sum;
    pl_run_measure(r);
    const int worse = r->sums.inverted > before.inverted ||
                      !pl_run_is_within(r, f->rr2_measured, f->acuteness) ||
                      r->sums.radius_max > f->cell_ratio;
    double value = worse ? INFINITY : r->sums.ratio[1];
    if (value <= enough) {
        f->slope = slope;
        f->refused = 0;
        pl_parallel_for(r->plan->threads, r->plan->interior.stars.n_stars, CHUNK, slope_chunk, f);
        value = pl_parts_any(f->refused) ? INFINITY : value;
    }
    if (!(value <= enough)) {
        r->sums = before;
        r->measured_sum = measured;
    }
    return value;
}

/** Centre the mesh, as far as it stays valid, and sweep it some times. A trial: the mesh that
 * stands stays the one that is seen, and comes back unless the other is better. Not 0 if cut short.
 */
static int try_centring(pl_lbfgs *m) {
    pl_run *r = m->p.run;
    double *start = pl_alloc(r->plan->work.n_nodes * r->plan->dim, sizeof *start);
    pl_sweep_tally tally = {.colours = pl_plan_colours(r->plan)};
    pl_trial trial;
    if (!start)
        return 0;
    pl_trial_begin(r, 1, start, &trial);
    r->problem.limits = pl_star_no_limits();
    pl_run_begin_anew(r);
    pl_run_begin_sweep(r);
    pl_patch_centre(&m->p, &tally);
    pl_patch_take(&m->p, m->start, start);
    pl_patch_take(&m->p, m->direction, r->plan->scratch.coordinates);
    pl_patch_combine(&m->p, m->direction, m->direction, -1, m->start);
    for (int i = 0; i < PARTS && !tally.stopped; i++) {
        pl_patch_combine(&m->p, m->position, m->start, ldexp(1, -i), m->direction);
        pl_patch_admit(&m->p, m->position, m->start);
        pl_run_measure(r);
        if (r->sums.inverted <= trial.standing.inverted)
            break;
    }
    tally.stars.visits = 0; /* no local problem was solved */
    int stopped = pl_run_end_sweep(r, &tally);
    for (int i = 0; i < SWEEPS_OF_TRIAL && !stopped; i++) {
        int64_t visits;
        stopped = pl_run_sweep(r, &visits);
    }
    pl_run_measure(r);
    const pl_objective_sums *before = &trial.standing, *now = &r->sums;
    pl_trial_end(&trial,
                 !stopped && now->inverted <= before->inverted &&
                     now->radius_max <= before->radius_max &&
                     now->corner_max <= before->corner_max &&
                     now->acuteness <= fmax(before->acuteness, trial.problem.limits.acuteness) &&
                     now->ratio[1] < before->ratio[1]);
    pl_free(start);
    return stopped;
}

/** Use L-BFGS for as long as it brings more than sweeps, which bring the RMS down by the part fall
 * of itself each; each evaluation counts as a sweep. Not 0 if cut short. */
static int try_descent(pl_lbfgs *m, double fall) {
    pl_run *r = m->p.run;
    int stopped = 0, moved = 1;
    while (moved && !stopped && pl_run_sweeps_left(r) > 0) {
        const double before = m->value;
        const int64_t first = m->evaluations;
        while (moved && m->evaluations < first + EVALUATIONS_OF_TRIAL && !stopped &&
               pl_run_sweeps_left(r) > 0) {
            pl_sweep_tally tally = {.colours = pl_plan_colours(r->plan)};
            pl_run_begin_sweep(r);
            moved = pl_lbfgs_iterate(m, &tally);
            tally.stars.evaluations = tally.stars.visits;
            stopped = pl_run_end_sweep(r, &tally);
        }
        const double n = (double)(m->evaluations - first);
        if (!(1 - sqrt(m->value / before) > n * fall))
            break;
    }
    return stopped;
}

static int try_acceleration(pl_run *r, pl_acceleration acceleration, double fall) {
    const planish_plan *plan = r->plan;
    pl_run_measure_inverted(r);
    const pl_star_limits worst = pl_run_worst_limits(r, 1);
    objective_of_all f = {.run = r,
                          .in_patch = pl_alloc_zero(plan->work.n_nodes, 1),
                          .rr2_limit = r->problem.limits.rr2,
                          .rr2_measured = fmax(r->problem.limits.rr2, worst.rr2),
                          .acuteness = fmax(r->problem.limits.acuteness, worst.acuteness),
                          .cell_ratio = plan->work.corner ? r->sums.radius_max : INFINITY};
    pl_lbfgs m;
    int stopped = 0;
    if (!f.in_patch)
        return 0;
    /* Nodes whose stars are valid move; an element may be as bad as the worst of the input, or as
     * the worst there is. */
    for (int64_t i = 0; i < plan->interior.stars.n_stars; i++) {
        pl_star_value value;
        pl_star_ratio_of(plan->kernel, &r->problem, plan->dim)(&r->problem, i, r->problem.scratch,
                                                               1, &value);
        const int32_t node = plan->interior.centre[i];
        f.in_patch[node] = value.certain && !pl_watch_has_invalid(&r->watch, node);
        if (value.certain)
            f.rr2_limit = fmax(f.rr2_limit, value.max * (1 + value.error));
    }
    pl_parts_largest(&f.rr2_limit, 1);
    if (pl_lbfgs_create(r, &r->problem, f.in_patch, evaluate, &f, &m)) {
        pl_lbfgs_begin(&m);
        if (m.value < INFINITY)
            stopped = acceleration == PL_CENTRING ? try_centring(&m) : try_descent(&m, fall);
        pl_run_begin_anew(r);
    }
    pl_lbfgs_destroy(&m);
    pl_free(f.in_patch);
    return stopped;
}

/** Multiply all coordinates, and see to it that they are measured as before. */
static void rescale(pl_run *r, double factor) {
    for (int64_t i = 0; i < r->plan->work.n_nodes * r->plan->dim; i++)
        r->plan->scratch.coordinates[i] *= factor;
    r->measure_scale /= factor;
}

/* L-BFGS keeps 31 vectors over the free nodes: 2 GB for so many in space. */
enum { LARGEST = 1 << 21 };
/* Squares and cubes of lengths in units beyond this, or its inverse, could overflow: then the mesh
 * is brought to a size of 1 for the time of the help, if nothing of it is lost on the way back.
 * There is no help where that would not do: nodes that slide are where they slide in the size that
 * it has, and so is what coordinates are rounded to. */
#define EXTREME 0x1p200
#define TINY    0x1p900

int pl_run_accelerate(pl_run *r, pl_acceleration acceleration, double fall) {
    const double unit = r->measure_scale;
    const int is_extreme = unit > EXTREME || unit < 1 / EXTREME;
    const int has_size = r->plan->sliding.n_all > 0 || pl_watch_is_on(&r->watch) ||
                         r->options->precision != PLANISH_PRECISION_DOUBLE;
    if (acceleration == PL_COARSE) /* with a unit of its own */
        return pl_run_coarse(r);
    if (r->plan->interior.n_all > LARGEST || unit > TINY || (is_extreme && has_size) ||
        (acceleration == PL_CENTRING &&
         pl_run_sweeps_left(r) <= SWEEPS_OF_TRIAL + 1)) /* one to show it */
        return 0;
    pl_log(PLANISH_LOG_DETAIL, "sweeps are slow: %s",
           acceleration == PL_CENTRING ? "nodes to the mean of their neighbours" : "L-BFGS");
    if (!is_extreme)
        return try_acceleration(r, acceleration, fall);
    rescale(r, unit);
    const int stopped = try_acceleration(r, acceleration, fall);
    rescale(r, 1 / unit);
    return stopped;
}
