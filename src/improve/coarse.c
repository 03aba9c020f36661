/* coarse: Newton's steps for smooth displacements of the whole mesh.
 *
 * A sweep carries a correction by one element. Here the sum of RR^2, or of the cells' AR^2, is
 * replaced by its quadratic model for displacements that are linear on the simplices of a lattice
 * (lattice.h). Sweeps between the steps remove the errors that the lattice cannot express. So steps
 * and sweeps together are a two-level method, and their number hardly depends on the size of the
 * mesh.
 */
#include "improve/improve.h"
#include "improve/lattice.h"
#include "improve/lattice_stiffness.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "plan/ghosts.h"

#include <math.h>
#include <string.h>

enum {
    CHUNK = 256,     /* stars that one thread takes at a time */
    STEPS = 32,      /* at most */
    TRIALS = 5,      /* lengths that are tried in each step */
    ITERATIONS = 20, /* of conjugate gradients in each step, at most */
    /* Free nodes; between fewer of them sweeps carry a correction soon. */
    FEWEST_IN_PLANE = 512,
    FEWEST_IN_SPACE = 1000
};

/* Spacing of the finest grid, by the mean length of edges. */
#define SPACING 2.5
/* In space one in so many elements stands for all in the Hessian: some twenty tetrahedra, or corners of
 * hexahedra, are in a simplex of this spacing. With one in four some steps are shorter. In the plane
 * all are in it: seven triangles are in a simplex. */
#define ONE_IN 2
/* Part to which conjugate gradients reduce the residual. */
#define SOLVED 0.1
/* Next part of the way that is tried. */
#define SHORTER 0.4
/* A step that lowers the RMS by less than this part is the last. */
#define GAIN_LEAST 3e-4
/* A shortened first step that lowers it by less is undone. */
#define GAIN_SHORT 3e-3
/* A step that lowers it by more changes the Hessian too much to keep it. */
#define GAIN_LARGE 1e-2
/* As does one that lowers it by more than this part of what the step before did. */
#define GAIN_SLOW 0.3

/** Steps under way. */
typedef struct coarse_steps {
    pl_run *r;
    pl_lattice lattice;
    pl_star_problem sliding; /* of the nodes that slide */
    double *force, *move;    /* [lattice.n_stars][dim] */
    double *start;           /* [n_nodes][dim] coordinates before the step */
    double part;             /* of the way, in this trial */
    double excess;           /* pl_run_excess before the step: what gains are parts of */
    int is_first;            /* step */
    /* No element may become worse: */
    double rr2, acuteness; /* with corners mu^2 of one, and 1 / SJ^2, */
    double cell_ratio;     /* and AR^2 of cells; infinite: of none */
    pl_sum work;           /* force . move */
} coarse_steps;

static void force_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const coarse_steps *c = context;
    const planish_plan *plan = c->r->plan;
    const int dim = plan->dim;
    const int64_t n = plan->interior.stars.n_stars;
    pl_star_evaluate_fn *of_interior = pl_star_ratio_of(plan->kernel, &c->r->problem, dim);
    pl_star_evaluate_fn *of_sliding = pl_star_evaluate_of(plan->kernel, &c->sliding, dim);
    double *scratch = pl_star_scratch_of(&c->r->problem, thread);
    for (int64_t i = begin; i < end; i++) {
        pl_star_value value;
        const int is_sure =
            c->lattice.freedom[pl_lattice_node(&c->lattice, i)] != PL_LATTICE_HELD &&
            (i < n ? of_interior(&c->r->problem, i, scratch, PL_GRADIENT_ALONE, &value)
                   : of_sliding(&c->sliding, i - n, scratch, PL_GRADIENT_ALONE, &value)) &&
            value.certain;
        for (int d = 0; d < dim; d++)
            c->force[i * dim + d] = is_sure && isfinite(value.gradient[d]) ? -value.gradient[d] : 0;
    }
}

static void work_chunk(void *context, int64_t begin, int64_t end, int thread) {
    coarse_steps *c = context;
    const int dim = c->r->plan->dim;
    pl_sum sum = {{0}, 0, 0, 0, 0};
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        double of_node = 0;
        for (int d = 0; d < dim; d++)
            of_node += c->force[i * dim + d] * c->move[i * dim + d];
        pl_sum_add(&sum, of_node);
    }
    pl_sum_merge(&c->work, &sum);
}

/** Ask whether the run is to end, in all processes. */
static int ask_all(coarse_steps *c, pl_sweep_tally *tally) {
    tally->stopped = pl_run_ask_all(c->r, tally->colours, 0);
    return tally->stopped;
}

/** A step that asks between its parts. */
typedef struct asking {
    coarse_steps *c;
    pl_sweep_tally *tally;
} asking;

static int ask_in_solution(void *context) {
    const asking *a = context;
    return ask_all(a->c, a->tally);
}

/** Find the moves of Newton's step, with a new Hessian or the last one. Return 0 if they do not lower
 *  F, or the work was cut short. */
static int find_moves(coarse_steps *c, int is_anew, pl_sweep_tally *tally) {
    const planish_plan *plan = c->r->plan;
    const int64_t n = c->lattice.n_stars;
    asking a = {c, tally};
    if (is_anew) {
        pl_lattice_sort(&c->lattice);
        pl_lattice_assemble(&c->lattice);
        if (ask_all(c, tally))
            return 0;
    }
    pl_parallel_for(plan->threads, n, CHUNK, force_chunk, c);
    if (!pl_lattice_restrict(&c->lattice, c->force) ||
        pl_lattice_solve(&c->lattice, SOLVED, ITERATIONS, ask_in_solution, &a))
        return 0;
    pl_lattice_prolong(&c->lattice, c->move);
    c->work = (pl_sum){{0}, 0, 0, 0, 0};
    pl_parallel_for(plan->threads, n, CHUNK, work_chunk, c);
    pl_parts_add_sums(&c->work, 1);
    return pl_sum_value(&c->work) > 0;
}

static void move_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const coarse_steps *c = context;
    const planish_plan *plan = c->r->plan;
    const int dim = plan->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int32_t node = pl_lattice_node(&c->lattice, i);
        const double *start = c->start + (int64_t)node * dim;
        double x[3];
        for (int d = 0; d < dim; d++)
            x[d] = start[d] + c->part * c->move[i * dim + d];
        if (c->lattice.freedom[node] > PL_LATTICE_FREE)
            pl_star_slide_to(&plan->slide[i - plan->interior.stars.n_stars], dim, x);
        const int fits = c->lattice.freedom[node] != PL_LATTICE_HELD &&
                         pl_star_admit(&c->r->problem, node, dim, x);
        memcpy(plan->scratch.coordinates + (int64_t)node * dim, fits ? x : start,
               (size_t)dim * sizeof *x);
    }
}

/** Part of F that may be left by this trial: less than before by what is asked of a first step, or at
 *  all. */
static double most_left(const coarse_steps *c) {
    const double gain = !c->is_first ? 0 : c->part == 1 ? GAIN_LEAST : GAIN_SHORT;
    const double rms = 1 - gain * c->excess;
    return rms * rms;
}

/** Whether the mesh as measured now may stand: no element is worse than the worst was, none has become
 *  inverted, and F is lower than before by enough. */
static int is_better(const coarse_steps *c, const pl_objective_sums *before) {
    const pl_objective_sums *now = &c->r->sums;
    return now->ratio[1] < before->ratio[1] * most_left(c) && now->inverted <= before->inverted &&
           now->radius_max <= c->cell_ratio && pl_run_is_within(c->r, c->rr2, c->acuteness);
}

/** Whether F can fall by enough: by no more than it does at first along the moves. */
static int may_be_better(const coarse_steps *c, const pl_objective_sums *before) {
    return c->part * pl_sum_value(&c->work) >= before->ratio[1] * (1 - most_left(c));
}

/** Move all nodes, or part of the way, so that F falls and no element becomes worse than the worst.
 *  Return the part of the excess by which the RMS fell; 0 if the nodes are where they were. */
static double take_moves(coarse_steps *c, pl_sweep_tally *tally) {
    pl_run *r = c->r;
    const planish_plan *plan = r->plan;
    double *x = plan->scratch.coordinates;
    const size_t size = (size_t)(plan->work.n_nodes * plan->dim) * sizeof *x;
    const pl_objective_sums before = r->sums;
    const double measured = r->measured_sum;
    memcpy(c->start, x, size);
    c->part = 1;
    for (int i = 0; i < TRIALS && !tally->stopped && may_be_better(c, &before); i++) {
        pl_parallel_for(plan->threads, c->lattice.n_stars, CHUNK, move_chunk, c);
        pl_ghosts_update(plan, x, plan->dim * (int64_t)sizeof *x);
        pl_run_measure(r);
        tally->stars.visits += c->lattice.n_moving;
        ask_all(c, tally);
        if (is_better(c, &before))
            return (1 - sqrt(r->sums.ratio[1] / before.ratio[1])) / c->excess;
        c->part *= SHORTER;
    }
    memcpy(x, c->start, size);
    if (plan->work.corner)
        pl_run_measure(r); /* for the watch */
    r->sums = before;
    r->measured_sum = measured;
    return 0;
}

/** Note a step that has lowered the RMS by gain of its excess. */
static void note_step(pl_run *r, double gain, double excess) {
    if (gain * excess > GAIN_LARGE)
        pl_run_begin_anew(r);
    else if (gain > 0)
        memset(r->plan->scratch.changed, PL_CHANGED, (size_t)r->plan->work.n_nodes);
    if (r->plan->work.corner)
        pl_watch_limit(&r->watch, r->watch.worst_ar2);
}

/** Make one step, counted as a sweep. *gain: part of its excess by which the RMS fell. Return not 0 if the work was
 *  cut short. */
static int make_step(coarse_steps *c, int is_anew, double *gain) {
    pl_run *r = c->r;
    pl_sweep_tally tally = {.colours = pl_plan_colours(r->plan)};
    pl_run_begin_sweep(r);
    c->excess = pl_run_excess(r);
    *gain = find_moves(c, is_anew, &tally) ? take_moves(c, &tally) : 0;
    tally.stars.evaluations = tally.stars.visits;
    note_step(r, *gain, c->excess);
    return pl_run_end_sweep(r, &tally);
}

/** Make steps and sweeps in turns while steps pay. Return not 0 if the work was cut short. */
static int make_steps(coarse_steps *c) {
    enum { NEEDED = 2 }; /* sweeps of a step and of the sweep after it */
    double gain = 1, last = 1;
    for (int i = 0; i < STEPS && pl_run_sweeps_left(c->r) >= NEEDED; i++) {
        const int is_anew = gain * c->excess > GAIN_LARGE || gain > GAIN_SLOW * last;
        int64_t visits;
        last = gain;
        c->is_first = i == 0;
        if (make_step(c, is_anew, &gain))
            return 1;
        if (gain < GAIN_LEAST)
            return 0;
        if (pl_run_sweep(c->r, &visits))
            return 1;
    }
    return 0;
}

/** Whether the mesh is one of linear elements whose free nodes go by themselves. */
static int is_suitable(const pl_run *r) {
    const planish_plan *plan = r->plan;
    const int has_others =
        plan->work.corner ? pl_watch_has_mids(&r->watch) : pl_watch_is_on(&r->watch);
    const int fewest = plan->dim == 2 ? FEWEST_IN_PLANE : FEWEST_IN_SPACE;
    return plan->interior.n_all >= fewest && r->plain && !has_others &&
           plan->work.size_weight == 0 && !plan->sizes && plan->sliding.n_followers == 0 &&
           plan->interior.n_followers == 0 && plan->n_images == 0;
}

/** Whether nodes on planes and lines take part. While all elements are positive no facet of a plane can
 *  fold over (docs/algorithm.md). With a shape they stay: nothing here bounds how far its facets go. */
static int may_slide(const pl_run *r) {
    return r->plan->sliding.n_all > 0 && !pl_parts_any(r->skin.shape != NULL) &&
           !(r->sums.inverted > 0);
}

/** Nodes that stay. */
typedef struct staying {
    const pl_run *run;
    uint8_t *stays; /* [n_nodes] by inner numbers */
} staying;

static void mark_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const staying *s = context;
    const pl_run *r = s->run;
    double *scratch = pl_star_scratch_of(&r->problem, thread);
    for (int64_t i = begin; i < end; i++) {
        pl_star_value value;
        pl_star_ratio_of(r->plan->kernel, &r->problem, r->plan->dim)(&r->problem, i, scratch, 1,
                                                                     &value);
        const int32_t node = r->plan->interior.centre[i];
        s->stays[node] = !value.certain || pl_watch_has_invalid(&r->watch, node);
    }
}

/** Mark the nodes of elements that are not surely valid, if there are any. No element is then repaired at the
 *  cost of a valid one: those that are inverted stay. Return 0 if there is no memory. */
static int mark_invalid(const pl_run *r, uint8_t **stays) {
    staying s = {r, NULL};
    *stays = NULL;
    if (!(r->sums.inverted > 0))
        return 1;
    *stays = s.stays = pl_alloc_zero(r->plan->work.n_nodes, 1);
    if (s.stays)
        pl_parallel_for(r->plan->threads, r->plan->interior.stars.n_stars, CHUNK, mark_chunk, &s);
    return s.stays != NULL;
}

int pl_run_coarse(pl_run *r) {
    const planish_plan *plan = r->plan;
    const int64_t n = (plan->interior.stars.n_stars + plan->sliding.stars.n_stars) * plan->dim;
    int stopped = 0;
    if (!is_suitable(r))
        return 0;
    pl_run_measure_inverted(r);
    pl_log(PLANISH_LOG_DETAIL, "sweeps would be slow: Newton's steps on a lattice");
    const pl_star_limits worst = pl_run_worst_limits(r, 1);
    const int slides = may_slide(r);
    coarse_steps c = {.r = r,
                      .excess = 1,
                      .sliding = pl_run_sliding_problem(r),
                      .force = pl_alloc(n, sizeof *c.force),
                      .move = pl_alloc(n, sizeof *c.move),
                      .start = pl_alloc(plan->work.n_nodes * plan->dim, sizeof *c.start),
                      .rr2 = fmax(r->problem.limits.rr2, worst.rr2),
                      .acuteness = fmax(r->problem.limits.acuteness, worst.acuteness),
                      .cell_ratio = plan->work.corner ? r->sums.radius_max : INFINITY};
    uint8_t *stays;
    const int ready = mark_invalid(r, &stays) && c.force && c.move && c.start;
    if (!pl_parts_any(!ready) && ready &&
        pl_lattice_create(plan, SPACING, plan->dim == 3 ? ONE_IN : 1, slides, stays, &c.lattice))
        stopped = make_steps(&c);
    pl_lattice_destroy(&c.lattice);
    pl_free(stays);
    pl_free(c.force);
    pl_free(c.move);
    pl_free(c.start);
    return stopped;
}
