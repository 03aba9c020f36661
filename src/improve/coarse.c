/* coarse: Newton's steps for displacements of the whole mesh that a lattice can express.
 *
 * Sweeps bring on by one element each what is wrong across the mesh. Here the sum of RR^2 is
 * replaced by its quadratic model for displacements that are linear on the simplices of a lattice
 * (lattice.h). Sweeps in between remove what the lattice cannot express, as the smoother of a
 * two-level method does.
 */
#include "improve/improve.h"
#include "improve/lattice.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { CHUNK = 256, STEPS = 12, TRIALS = 5 };
/* Spacing of the finest grid, by the distance of nodes. */
#define SPACING 2.5
/* A step that has brought less than this part of the RMS is the last: sweeps do as much. */
#define GAIN_LEAST 4e-5
/* One that has brought more has changed the Hessian. */
#define GAIN_OLD 5e-3
/* First shift after a step that had to be shortened, and the largest. */
#define SHIFT_FIRST   0x1p-4
#define SHIFT_LARGEST 4.0

/** Steps under way. */
typedef struct coarse_steps {
    pl_run *r;
    pl_lattice lattice;
    double *force, *move; /* [n_stars][dim] */
    double *start;        /* [n_nodes][dim] */
    double part;          /* of the way */
    pl_sum slope;         /* force . move */
    double rr2, acuteness; /* no element may become worse */
    double shift;
} coarse_steps;

static double now(void) { struct timespec t; clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t); return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec; }

static void force_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const coarse_steps *c = context;
    const planish_plan *plan = c->r->plan;
    double *scratch = pl_star_scratch_of(&c->r->problem, thread);
    pl_star_evaluate_fn *evaluate = pl_star_ratio_of(plan->kernel, &c->r->problem, plan->dim);
    for (int64_t i = begin; i < end; i++) {
        pl_star_value value;
        const int valid =
            evaluate(&c->r->problem, i, scratch, PL_GRADIENT_ALONE, &value) && value.certain;
        for (int d = 0; d < plan->dim; d++)
            c->force[i * plan->dim + d] = valid ? -value.gradient[d] : 0;
    }
}

static void slope_chunk(void *context, int64_t begin, int64_t end, int thread) {
    coarse_steps *c = context;
    pl_sum sum = {{0}, 0, 0, 0, 0};
    const int dim = c->r->plan->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        double of_node = 0;
        for (int d = 0; d < dim; d++)
            of_node += c->force[i * dim + d] * c->move[i * dim + d];
        pl_sum_add(&sum, of_node);
    }
    pl_sum_merge(&c->slope, &sum);
}

static void move_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const coarse_steps *c = context;
    const planish_plan *plan = c->r->plan;
    const int dim = plan->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int64_t at = plan->interior.centre[i] * (int64_t)dim;
        double *x = plan->scratch.coordinates + at, to[3];
        for (int d = 0; d < dim; d++)
            to[d] = c->start[at + d] + c->part * c->move[i * dim + d];
        const int fits = pl_star_admit(&c->r->problem, plan->interior.centre[i], dim, to);
        memcpy(x, fits ? to : c->start + at, (size_t)dim * sizeof *x);
    }
}

/** Find the moves for the forces where the nodes are; returns the slope of F^2's sum along them, 0 if
 *  it does not fall. */
static double find_moves(coarse_steps *c) {
    const planish_plan *plan = c->r->plan;
    const int64_t n = plan->interior.stars.n_stars;
    c->slope = (pl_sum){{0}, 0, 0, 0, 0};
    pl_parallel_for(plan->threads, n, CHUNK, force_chunk, c);
    pl_lattice_restrict(&c->lattice, c->force);
    pl_lattice_solve(&c->lattice);
    pl_lattice_prolong(&c->lattice, c->move);
    pl_parallel_for(plan->threads, n, CHUNK, slope_chunk, c);
    const double slope = -pl_sum_value(&c->slope);
    return slope < 0 ? slope : 0;
}

/** Move all nodes, or part of the way, so that F falls; returns by which part of the sum, 0 if the
 *  nodes are where they were. */
static double take_step(coarse_steps *c, double slope, pl_sweep_tally *tally) {
    pl_run *r = c->r;
    planish_plan *plan = r->plan;
    const size_t size = (size_t)plan->work.n_nodes * (size_t)plan->dim * sizeof *c->start;
    const pl_objective_sums before = r->sums;
    const double measured = r->measured_sum;
    memcpy(c->start, plan->scratch.coordinates, size);
    c->part = 1;
    for (int i = 0; i < TRIALS && !tally->stopped; i++) {
        pl_parallel_for(plan->threads, plan->interior.stars.n_stars, CHUNK, move_chunk, c);
        pl_run_measure(r);
        tally->stars.visits += plan->interior.n_all;
        tally->stopped = pl_run_ask_all(r, tally->colours, plan->interior.n_all);
        const double rise = r->sums.ratio[1] - before.ratio[1];
        if (getenv("TALK")) printf("   t %g rise %.4f slope %.4f sum %.3f inverted %g worst %g shift %g\n", c->part, rise, slope, before.ratio[1], r->sums.inverted, r->sums.radius_max, c->shift);
        if (rise < 0 && r->sums.inverted <= before.inverted &&
            pl_run_is_within(r, c->rr2, c->acuteness))
            return -rise / before.ratio[1];
        c->part *= 0.4;
    }
    memcpy(plan->scratch.coordinates, c->start, size);
    r->sums = before;
    r->measured_sum = measured;
    return 0;
}

/** Make one step, counted as a sweep. *gain: by which part the RMS fell. Returns not 0 if cut short. */
static int step(coarse_steps *c, double *gain) {
    pl_run *r = c->r;
    pl_sweep_tally tally = {.colours = pl_plan_colours(r->plan)};
    pl_run_begin_sweep(r);
    double t0 = now();
    const double slope = find_moves(c);
    double t1 = now();
    *gain = slope < 0 ? take_step(c, slope, &tally) / 2 : 0;
    if (getenv("TALK")) printf("   moves %.4f step %.4f gain %.3g\n", t1 - t0, now() - t1, *gain);
    if (*gain > 0)
        pl_run_begin_anew(r);
    return pl_run_end_sweep(r, &tally);
}

static int make_steps(coarse_steps *c, double *total) {
    pl_run *r = c->r;
    double gain = 1;
    int stopped = 0;
    for (int i = 0; i < STEPS && !stopped && pl_run_sweeps_left(r) > 2; i++) {
        int64_t visits;
        double t0 = now();
        if (gain > GAIN_OLD || c->part < 0.5)
            pl_lattice_assemble(&c->lattice, c->shift);
        if (getenv("TALK")) printf("   assemble %.4f\n", now() - t0);
        stopped = step(c, &gain);
        *total += gain;
        if (c->part < 0.5 || gain == 0)
            c->shift = c->shift > 0 ? 4 * c->shift : SHIFT_FIRST;
        else
            c->shift *= 0.25;
        if (stopped || c->shift > SHIFT_LARGEST || (gain < GAIN_LEAST && c->part == 1))
            break;
        stopped = pl_run_sweep(r, &visits);
    }
    return stopped;
}

int pl_run_coarse(pl_run *r) {
    const planish_plan *plan = r->plan;
    const pl_star_limits worst = pl_run_worst_limits(r, 1);
    const int64_t n = plan->interior.stars.n_stars;
    coarse_steps c = {.r = r,
                      .force = pl_alloc(n * plan->dim, sizeof(double)),
                      .move = pl_alloc(n * plan->dim, sizeof(double)),
                      .start = pl_alloc(plan->work.n_nodes * plan->dim, sizeof(double)),
                      .rr2 = fmax(r->problem.limits.rr2, worst.rr2),
                      .acuteness = fmax(r->problem.limits.acuteness, worst.acuteness)};
    int stopped = 0;
    double total = 0;
    double t0 = now();
    const int made = pl_lattice_create(plan, getenv("RATIO") ? atof(getenv("RATIO")) : SPACING, &c.lattice);
    if (getenv("TALK")) printf("   create %.4f nv %lld levels %d\n", now() - t0, (long long)c.lattice.grid[0].n_vertices, c.lattice.n_levels);
    if (made && c.force && c.move && c.start)
        stopped = make_steps(&c, &total);
    pl_lattice_destroy(&c.lattice);
    pl_free(c.force);
    pl_free(c.move);
    pl_free(c.start);
    return stopped;
}
