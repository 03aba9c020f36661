/* sweep: one pass over the colours of a plan, and when another one pays. Nodes of one colour share
 * no element, so they are visited in parallel, each reading its neighbours and writing only itself.
 */
#include "star/laplacian.h"
#include "sweep/sweep.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"
#include "geometry/fetch.h"
#include "geometry/simplex.h"
#include "plan/ghosts.h"
#include "sweep/skin.h"
#include "sweep/watch_late.h"

#include <math.h>
#include <string.h>

/* ---- one pass over the colours ------------------------------------------------------------- */

/** Some stars of a colour under way. */
typedef struct colour_pass {
    const planish_plan *plan;
    const pl_star_problem *problem;
    planish_method method;
    int64_t first, end;   /* stars */
    pl_skin_visit *visit; /* of the skin, whose project is the problem's; or NULL */
} colour_pass;

/** Visit stars begin .. end - 1, whatever becomes of watched cells. */
static void visit_straight(const colour_pass *pass, int64_t begin, int64_t end, double *scratch,
                           pl_star_tally *tally) {
    if (begin < end)
        pl_star_visit_of(pass->plan->kernel, pass->problem, pass->plan->dim)(pass->problem, begin,
                                                                             end, scratch, tally);
}

/** Evaluate a star where its node is: RR by *ratio, and the star's function by *sum. 0 if an element is
 *  not positive. */
static int evaluate_star(const colour_pass *pass, int64_t star, double *scratch,
                         pl_star_value *ratio, double *sum) {
    const int dim = pass->plan->dim;
    pl_star_evaluate_fn *of_ratio = pl_star_ratio_of(pass->plan->kernel, pass->problem, dim);
    pl_star_evaluate_fn *of_visits = pl_star_evaluate_of(pass->plan->kernel, pass->problem, dim);
    pl_star_value function;
    if (!of_ratio(pass->problem, star, scratch, 0, ratio))
        return 0;
    *sum = ratio->sum;
    if (of_visits == of_ratio)
        return 1;
    const int is_positive = of_visits(pass->problem, star, scratch, 0, &function);
    *sum = function.sum;
    return is_positive;
}

/** Whether a part of the way of a star's node is a place for it, too. */
static int may_shorten(const colour_pass *pass, int64_t star) {
    const pl_star_problem *problem = pass->problem;
    if (pass->visit && pass->visit->wholes)
        return !(problem->limits.acuteness < INFINITY);
    if (pass->plan->work.corner)
        return !problem->slide || problem->slide[star].kind != PLANISH_CONSTRAINT_ON_SURFACE;
    return !problem->slide && !(problem->limits.acuteness < INFINITY);
}

/** Bring follower k to where its leader is, but for their way. */
static void follow(const planish_plan *plan, const pl_storage *storage, int64_t k) {
    const pl_follower *f = &plan->sliding.follower[k];
    const pl_follower_places *places = &plan->scratch.places[k];
    const int dim = plan->dim,
              is_stored = f->node < plan->work.n_nodes; /* images are in no result */
    const double *of = plan->scratch.coordinates + (int64_t)f->of * dim;
    double *x = plan->scratch.coordinates + (int64_t)f->node * dim;
    const double was[3] = {x[0], x[1], x[dim - 1]};
    /* If the node that it follows has not moved, it keeps its first coordinates, unrounded. */
    for (int d = 0; d < dim; d++) {
        const double way = of[d] - places->origin[d], place = places->start[d] + way;
        x[d] = way != 0 && is_stored ? pl_store(storage, place) : place;
    }
    if (plan->scratch.watch && is_stored &&
        (x[0] != was[0] || x[1] != was[1] || x[dim - 1] != was[dim - 1]))
        pl_watch_forget(plan->scratch.watch, f->node);
}

/** Bring the nodes that follow the node of a star to where they are to be. No other star of its colour sees
 *  them. */
static void move_followers(const colour_pass *pass, int32_t node) {
    const pl_incidence *of = &pass->plan->scratch.watch->follower;
    for (int64_t i = of->offset ? of->offset[node] : 0; of->offset && i < of->offset[node + 1]; i++)
        follow(pass->plan, &pass->problem->storage, of->element[i]);
}

/** Likewise, and on the shape the mids at the node. */
static void move_others(const colour_pass *pass, int32_t node) {
    move_followers(pass, node);
    if (pass->visit && pl_skin_move_mids(pass->visit))
        pl_watch_forget(pass->plan->scratch.watch, node);
}

/** Note that cells of a star's ring, which is all of their nodes, have a large corner. */
static void note_large(const colour_pass *pass, int64_t star) {
    const pl_star_problem *problem = pass->problem;
    uint8_t *has_large = pass->plan->scratch.watch->has_large;
    pl_set_flag(&has_large[problem->node[star]], 1);
    for (int64_t i = problem->ring_offset[star]; i < problem->ring_offset[star + 1]; i++)
        pl_set_flag(&has_large[problem->ring[i]], 1);
}

/** Whether the cells at the node of a star, which has moved from before [dim], have no worse aspect ratio
 *  than they may, or than they had; ratio: the largest mu^2 of the star's corners. A cell's AR^2 is a mean
 *  of its corners, of which the star may not have all. *is_fine (may be NULL): the node has no large one any
 *  more, if it stays there. */
static int keeps_ratios(const colour_pass *pass, int64_t star, const double *before, double ratio,
                        uint8_t *is_fine) {
    const pl_watch *watch = pass->plan->scratch.watch;
    const int32_t node = pass->problem->node[star];
    const int dim = pass->plan->dim;
    double *x = pass->problem->coordinates + (int64_t)node * dim, after[3];
    const int is_large = ratio > watch->worst_ar2;
    if (!watch->has_large || !(is_large || watch->has_large[node]))
        return 1;
    if (is_large)
        note_large(pass, star);
    const pl_worst_cell now = pl_watch_worst(watch, node, watch->worst_ar2);
    if (is_fine)
        *is_fine = now.mu2 <= watch->worst_ar2;
    if (now.ar2 <= watch->worst_ar2)
        return 1;
    memcpy(after, x, (size_t)dim * sizeof *x);
    memcpy(x, before, (size_t)dim * sizeof *x);
    move_followers(pass, node);
    const double was = pl_watch_worst(watch, node, watch->worst_ar2).ar2;
    memcpy(x, after, (size_t)dim * sizeof *x);
    move_followers(pass, node);
    return now.ar2 < was;
}

static double way_from(const colour_pass *pass, int32_t node, const double *before) {
    const int dim = pass->plan->dim;
    const double *x = pass->problem->coordinates + (int64_t)node * dim;
    return dim == 3 ? pl_watch_distance(3, before, x) : pl_watch_distance(2, before, x);
}

/** Bring the node of a star, on the shape, from where it is on trial to where it may be. Returns 0 if that
 *  is where it began. */
static int go_to_shape(const colour_pass *pass, int64_t star, const double *before, double *x) {
    double direction[3];
    if (!pass->visit)
        return 1;
    pl_skin_project(star, x, direction, pass->visit);
    return !pl_skin_is_at(x, before);
}

/** Try shorter moves of a star whose watched cells refuse the one from before [dim] to where its
 *  node is. Where none is admitted the node is at before then. Returns by how much the star's
 *  function fell. */
static double shorten(const colour_pass *pass, int64_t star, const double *before,
                      double *scratch) {
    enum { HALVINGS = 4 };
    const pl_star_problem *problem = pass->problem;
    const pl_watch *watch = pass->plan->scratch.watch;
    const int dim = pass->plan->dim;
    const int32_t node = problem->node[star];
    const size_t size = (size_t)dim * sizeof *before;
    double *x = problem->coordinates + (int64_t)node * dim, after[3], start, now;
    pl_star_value ratio;
    memcpy(after, x, size);
    memcpy(x, before, size);
    move_others(pass, node);
    if (!may_shorten(pass, star) || !evaluate_star(pass, star, scratch, &ratio, &start))
        return 0;
    const double worst = fmax(problem->limits.rr2, ratio.max);
    const double acuteness =
        problem->limits.acuteness < INFINITY
            ? fmax(problem->limits.acuteness, pl_watch_worst(watch, node, 0).acuteness)
            : INFINITY;
    for (int k = 1; k <= HALVINGS; k++) {
        for (int d = 0; d < dim; d++)
            x[d] = before[d] + ldexp(after[d] - before[d], -k);
        if (!go_to_shape(pass, star, before, x) || !pl_star_admit(problem, node, dim, x))
            break;
        move_others(pass, node);
        if (evaluate_star(pass, star, scratch, &ratio, &now) && ratio.certain && now < start &&
            ratio.max * (1 + ratio.error) <= worst &&
            (!(acuteness < INFINITY) || pl_watch_worst(watch, node, 0).acuteness <= acuteness) &&
            keeps_ratios(pass, star, before, ratio.max, NULL) &&
            pl_watch_admit(pass->plan->scratch.watch, node, way_from(pass, node, before)))
            return start - now;
    }
    memcpy(x, before, size);
    move_others(pass, node);
    return 0;
}

/** Stars of one colour that are visited together, and then judged together. */
typedef struct watched_visits {
    double before[PL_CHUNK_STARS][3];
    pl_star_gain gain[PL_CHUNK_STARS];
    pl_watch_move move[PL_CHUNK_STARS];
    int64_t star[PL_CHUNK_STARS];    /* of each move */
    uint8_t is_fine[PL_CHUNK_STARS]; /* likewise: see keeps_ratios */
} watched_visits;

/** Note the moves of stars begin .. end - 1 with watched cells; returns how many. */
static int note_moves(const colour_pass *pass, int64_t begin, int64_t end, watched_visits *v) {
    pl_watch *watch = pass->plan->scratch.watch;
    int n = 0;
    for (int64_t i = begin; i < end; i++) {
        const int32_t node = pass->problem->node[i];
        const double way = way_from(pass, node, v->before[i - begin]);
        if (way == 0 || !pl_watch_has(watch, node) || !(watch->decides || watch->has_large))
            continue;
        v->star[n] = i;
        v->is_fine[n] = 0;
        const int keeps =
            keeps_ratios(pass, i, v->before[i - begin], v->gain[i - begin].ratio, &v->is_fine[n]);
        if (watch->late.is_on) {
            pl_watch_note_move(watch, i, node, v->before[i - begin], way, &v->gain[i - begin]);
            if (keeps && !v->is_fine[n] && !watch->late.has_at_once[node])
                continue;
        }
        v->move[n++] = (pl_watch_move){.node = node, .way = way, .is_refused = !keeps};
    }
    return n;
}

/** Take back the gain of a star whose move was refused, and try shorter ones. */
static void refuse(const colour_pass *pass, int64_t star, const double *before,
                   const pl_star_gain *gain, double *scratch, pl_star_tally *tally) {
    pl_watch *watch = pass->plan->scratch.watch;
    const double fall = shorten(pass, star, before, scratch);
    if (watch->late.is_on)
        pl_watch_note_move(watch, star, pass->problem->node[star], before,
                           way_from(pass, pass->problem->node[star], before),
                           &(pl_star_gain){.fall = fall});
    pl_sum_add(&tally->decrease, -gain->fall);
    pl_sum_add(&tally->decrease, fall);
    tally->improved -= gain->improved;
    tally->restored -= gain->restored;
    if (!(fall > 0))
        __atomic_fetch_add(&watch->n_refused, 1, __ATOMIC_RELAXED);
}

/** Ask for the rooms of cells at stars begin .. end - 1, and for the lists of the stars that this thread
 *  visits next, most likely. */
PL_AT_ONCE void fetch_watched(const colour_pass *pass, int64_t begin, int64_t end) {
    const pl_watch *watch = pass->plan->scratch.watch;
    const int32_t *node = pass->problem->node;
    const int64_t n = end - begin;
    if (!watch->decides || watch->late.is_on)
        return;
    for (int64_t i = begin; i < end; i++) {
        if (i + 2 * n < pass->end)
            pl_watch_fetch_begin(watch, node[i + 2 * n]);
        if (i + n < pass->end)
            pl_watch_fetch_list(watch, node[i + n]);
        pl_watch_fetch_rooms(watch, node[i]);
    }
}

/** Visit stars begin .. end - 1, PL_CHUNK_STARS at most, of a mesh with watched cells. A move that
 *  would make one invalid, or worse than it may be, is shortened, or refused. Stars of one colour
 *  share no cell, so all are moved first, and then judged in full blocks. */
static void visit_watched(const colour_pass *pass, int64_t begin, int64_t end, double *scratch,
                          pl_star_tally *tally) {
    const pl_star_problem *problem = pass->problem;
    pl_watch *watch = pass->plan->scratch.watch;
    const int dim = pass->plan->dim;
    watched_visits v;
    memset(v.gain, 0, sizeof v.gain);
    for (int64_t i = begin; i < end; i++) {
        const double *x = problem->coordinates + (int64_t)problem->node[i] * dim;
        double *before = v.before[i - begin];
        before[0] = x[0];
        before[1] = x[1];
        before[2] = x[dim - 1];
    }
    fetch_watched(pass, begin, end);
    tally->gain = v.gain;
    tally->first = begin;
    visit_straight(pass, begin, end, scratch, tally);
    tally->gain = NULL;
    for (int64_t i = begin; i < end && (pass->visit || watch->follower.offset); i++)
        move_others(pass, problem->node[i]);
    const int n = note_moves(pass, begin, end, &v);
    if (watch->decides)
        pl_watch_judge(watch, n, v.move);
    for (int m = 0; m < n; m++)
        if (!v.move[m].is_refused && v.is_fine[m])
            watch->has_large[v.move[m].node] = 0;
        else if (v.move[m].is_refused)
            refuse(pass, v.star[m], v.before[v.star[m] - begin], &v.gain[v.star[m] - begin],
                   scratch, tally);
}

/** Visit stars begin .. end - 1, none of which is of the skin unless the problem is its visit's. */
static void visit_range(const colour_pass *pass, int64_t begin, int64_t end, double *scratch,
                        pl_star_tally *tally) {
    if (pass->plan->scratch.watch)
        visit_watched(pass, begin, end, scratch, tally);
    else
        visit_straight(pass, begin, end, scratch, tally);
}

/* So many stars ahead memory is asked for, in visits one at a time: each step reads what the one before
 * has asked for. */
enum { NODE_AHEAD = 7, LIST_AHEAD = 5, FACETS_AHEAD = 3 };

/** Ask for what the visits of stars after i will read, i being next. The chunk after this one is that of
 *  this thread, most likely. */
PL_AT_ONCE void fetch_surface(const colour_pass *pass, int64_t i) {
    const pl_star_problem *problem = pass->problem;
    const pl_skin *skin = pass->plan->scratch.skin;
    const int64_t left = pass->end - i;
    if (left > NODE_AHEAD)
        pl_skin_fetch_node(skin, i + NODE_AHEAD);
    if (left > LIST_AHEAD)
        pl_skin_fetch_list(skin, i + LIST_AHEAD);
    if (left > FACETS_AHEAD)
        pl_skin_fetch_facets(skin, i + FACETS_AHEAD);
    if (left <= 1)
        return;
    pl_skin_fetch_corners(skin, i + 1);
    for (int64_t k = problem->ring_offset[i + 1]; k < problem->ring_offset[i + 2]; k++) {
        pl_fetch_node(pass->plan->dim, problem->coordinates, problem->ring[k]);
        pl_fetch_to_write(&problem->changed[problem->ring[k]]);
    }
}

/** Visit stars begin .. end - 1 of nodes that slide, some of them on the shape. */
static void visit_surface(const colour_pass *pass, int64_t begin, int64_t end, int thread,
                          double *scratch, pl_star_tally *tally) {
    pl_skin *skin = pass->plan->scratch.skin;
    pl_skin_visit visit;
    pl_star_problem problem = *pass->problem;
    colour_pass on_skin = *pass;
    pl_skin_prepare(skin, thread, &visit);
    problem.project = pl_skin_project;
    problem.project_user = &visit;
    on_skin.problem = &problem;
    on_skin.visit = &visit;
    for (int64_t i = begin; i < end; i++) {
        fetch_surface(pass, i);
        if (skin->node[i] < 0)
            continue;
        visit_range(pass, begin, i, scratch, tally);
        begin = i + 1;
        if (!(problem.changed[problem.node[i]] & PL_CHANGED) && !pass->plan->scratch.watch)
            continue; /* as the kernel would */
        const pl_star_tally was = *tally;
        pl_skin_begin_visit(&visit, i);
        visit_range(&on_skin, i, i + 1, scratch, tally);
        if (pl_skin_end_visit(&visit))
            continue;
        tally->decrease = was.decrease;
        tally->improved = was.improved;
        tally->restored = was.restored;
    }
    visit_range(pass, begin, end, scratch, tally);
}

static void visit_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const colour_pass *pass = context;
    const planish_plan *plan = pass->plan;
    const pl_star_problem *problem = pass->problem;
    double *scratch = pl_star_scratch_of(problem, thread);
    pl_star_tally *tally = &plan->scratch.tally[thread].of;
    begin += pass->first;
    end += pass->first;
    if (problem->untangling)
        plan->kernel->guarded->untangle[plan->dim - 2](problem, begin, end, scratch, tally);
    else if (pass->method != PLANISH_METHOD_PLANISH)
        pl_star_average(problem, pass->method, plan->dim, begin, end, scratch, tally);
    else if (plan->scratch.skin && problem->slide)
        visit_surface(pass, begin, end, thread, scratch, tally);
    else
        visit_range(pass, begin, end, scratch, tally);
}

void pl_follow(const planish_plan *plan, const pl_star_problem *problem) {
    for (int64_t k = 0; k < plan->sliding.n_followers; k++) {
        const pl_follower *f = &plan->sliding.follower[k];
        follow(plan, &problem->storage, k);
        uint8_t *has_large = plan->scratch.watch ? plan->scratch.watch->has_large : NULL;
        if (has_large) { /* the node that it follows is asked, and cleared once there is none */
            has_large[f->of] |= has_large[f->node];
            has_large[f->node] = 0;
        }
        uint8_t *changed = &plan->scratch.changed[f->of];
        *changed |= plan->scratch.changed[f->node];
        if (plan->scratch.changed[f->node] & PL_CHANGED)
            *changed &= (uint8_t)~PL_TOLD;       /* a star around has moved since */
        plan->scratch.changed[f->node] = PL_BAD; /* so that it is told */
    }
}

/** Visit a range of stars of a colour. A thread takes so many at a time: few of few, so that all
 *  threads end together; but one takes all if to wake the others would cost more than they save. */
static void visit_stars(colour_pass *pass, int64_t begin, int64_t end) {
    enum { FEWEST = 4, CHUNKS_EACH = 8 };
    const int threads = pass->plan->threads;
    const int64_t n = end - begin;
    int64_t chunk = n / CHUNKS_EACH / threads;
    if (n <= PL_CHUNK_STARS || chunk > PL_CHUNK_STARS)
        chunk = PL_CHUNK_STARS;
    else if (chunk < FEWEST)
        chunk = FEWEST;
    pass->first = begin;
    pass->end = end;
    pl_parallel_for(threads, n, chunk, visit_chunk, pass);
}

/** Visit a colour; while the others hear of the nodes that they wait for, those inside. */
static void visit_colour(colour_pass *pass, const pl_visits *visits, int colour) {
    const planish_plan *plan = pass->plan;
    const int64_t begin = visits->colour_begin[colour], inside = visits->inside_begin[colour];
    const int64_t end = visits->colour_begin[colour + 1];
    if (plan->context->part) {
        pl_ghosts_note(plan, visits, begin, inside);
        visit_stars(pass, begin, inside);
        pl_ghosts_send(plan, visits, begin, inside);
    }
    visit_stars(pass, inside, end);
    if (plan->context->part)
        pl_ghosts_receive(plan);
}

static void add_tally(pl_star_tally *all, pl_star_tally *part) {
    pl_sum_merge(&all->decrease, &part->decrease);
    all->visits += part->visits;
    all->evaluations += part->evaluations;
    all->improved += part->improved;
    all->restored += part->restored;
    all->largest = fmax(all->largest, part->largest);
}

/** Whether moves of a sweep may be judged at its end: nothing else than its visits moves with its nodes,
 *  and a look at all cells pays. */
static int may_wait(const planish_plan *plan, const pl_visits *visits,
                    const pl_star_problem *problem, planish_method method) {
    enum { CELLS_EACH = 32 }; /* most cells for a star */
    return method == PLANISH_METHOD_PLANISH && !problem->untangling && !plan->scratch.skin &&
           !plan->context->part && visits->stars.n_stars * CELLS_EACH >= plan->scratch.watch->n;
}

void pl_sweep(const planish_plan *plan, const pl_visits *visits, const pl_star_problem *problem,
              planish_method method, pl_after_colour_fn *after_colour, void *context,
              pl_sweep_tally *tally) {
    const int together = plan->context->part != NULL; /* none stops alone */
    pl_watch *watch = plan->scratch.watch;
    colour_pass pass = {.plan = plan, .problem = problem, .method = method};
    pl_star_tally mine = {.visits = 0};
    double stopped = 0;
    int64_t visited = 0;
    if (tally->stopped)
        return;
    memset(plan->scratch.tally, 0, (size_t)plan->threads * sizeof *plan->scratch.tally);
    if (watch)
        pl_watch_begin_sweep(watch, may_wait(plan, visits, problem, method));
    if (visits->n_followers > 0)
        pl_follow(plan, problem);
    for (int c = 0; c < visits->n_colours && (!(stopped > 0) || together); c++) {
        const int64_t before = visited;
        visit_colour(&pass, visits, c);
        visited = 0;
        for (int t = 0; t < plan->threads; t++)
            visited += plan->scratch.tally[t].of.visits;
        tally->colours++;
        if (visits->n_followers > 0)
            pl_follow(plan, problem);
        stopped = fmax(stopped, after_colour(context, tally->colours, visited - before));
    }
    if (watch)
        pl_watch_end_sweep(watch, problem, visits->stars.n_stars, &plan->scratch.tally[0].of);
    for (int t = 0; t < plan->threads; t++)
        add_tally(&mine, &plan->scratch.tally[t].of);
    int64_t counts[] = {mine.visits, mine.evaluations, mine.improved, mine.restored};
    pl_parts_add_sums(&mine.decrease, 1);
    pl_parts_add(counts, sizeof counts / sizeof *counts);
    pl_parts_largest(&stopped, 1);
    mine.visits = counts[0];
    mine.evaluations = counts[1];
    mine.improved = counts[2];
    mine.restored = counts[3];
    add_tally(&tally->stars, &mine);
    tally->stopped = (int)stopped;
}

/* ---- optimality ---------------------------------------------------------------------------- */

enum { CHUNK = 1024 }; /* stars that one thread takes at a time */

/** A look at all stars. */
typedef struct optimality_pass {
    const planish_plan *plan;
    const pl_star_problem *problem;
    pl_star_optimality *of_thread; /* [threads] */
} optimality_pass;

/** Add the optimality of stars begin .. end - 1 without constraints. */
static void judge_plain(const optimality_pass *pass, int64_t begin, int64_t end, double *scratch,
                        pl_star_optimality *sum) {
    const planish_plan *plan = pass->plan;
    pl_star_evaluate_fn *evaluate = pl_star_evaluate_of(plan->kernel, pass->problem, plan->dim);
    for (int64_t i = begin; i < end; i++) {
        pl_star_value value;
        if (!evaluate(pass->problem, i, scratch, PL_GRADIENT_ALONE, &value) ||
            !(value.sum < INFINITY))
            continue;
        double square = 0;
        for (int d = 0; d < plan->dim; d++) {
            const double slope = value.gradient[d] * value.size; /* without a unit */
            square += slope * slope;
        }
        const double residual = sqrt(square) / value.sum;
        sum->residual = fmax(sum->residual, residual);
        pl_sum_add(&sum->residual2, residual * residual);
        sum->n_stars++;
    }
}

static void judge_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const optimality_pass *pass = context;
    const planish_plan *plan = pass->plan;
    if (!pass->problem->guard) {
        judge_plain(pass, begin, end, pl_star_scratch_of(pass->problem, thread),
                    &pass->of_thread[thread]);
        return;
    }
    plan->kernel->guarded->optimality[plan->dim - 2](pass->problem, begin, end,
                                                     pl_star_scratch_of(pass->problem, thread),
                                                     &pass->of_thread[thread]);
}

static void add_optimality(pl_star_optimality *all, pl_star_optimality *part) {
    all->residual = fmax(all->residual, part->residual);
    all->multiplier = fmax(all->multiplier, part->multiplier);
    pl_sum_merge(&all->residual2, &part->residual2);
    all->n_active += part->n_active;
    all->n_stars += part->n_stars;
}

int pl_optimality(const planish_plan *plan, const pl_visits *visits, const pl_star_problem *problem,
                  pl_star_optimality *optimality, planish_error *error) {
    optimality_pass pass = {plan, problem, pl_alloc_zero(plan->threads, sizeof *pass.of_thread)};
    pl_star_optimality *mine = pass.of_thread;
    if (!mine)
        return pl_fail_memory(error, "the optimality of the stars");
    pl_parallel_for(plan->threads, visits->stars.n_stars, CHUNK, judge_chunk, &pass);
    for (int i = 1; i < plan->threads; i++)
        add_optimality(mine, &mine[i]);
    int64_t counts[] = {mine->n_active, mine->n_stars};
    double most[] = {mine->residual, mine->multiplier};
    pl_parts_add_sums(&mine->residual2, 1);
    pl_parts_add(counts, 2);
    pl_parts_largest(most, 2);
    mine->n_active = counts[0];
    mine->n_stars = counts[1];
    mine->residual = most[0];
    mine->multiplier = most[1];
    add_optimality(optimality, mine);
    pl_free(mine);
    return PLANISH_OK;
}

/* ---- convergence --------------------------------------------------------------------------- */

/* The fall that is still to come, by extrapolation, must be below this fraction of the RMS. */
#define REMAINDER 0.01

double pl_remainder(const pl_convergence *convergence) {
    double first = convergence->fall[0], last = convergence->fall[PL_CALM_SWEEPS - 1];
    if (!(last > 0))
        return 0;
    if (!(first > last))
        return INFINITY;
    double ratio = sqrt(last / first);
    return last * ratio / (1 - ratio);
}

double pl_left_after(const pl_convergence *convergence, int sweeps) {
    const double first = convergence->fall[0], last = convergence->fall[PL_CALM_SWEEPS - 1];
    const int n = convergence->n_falls;
    if (!(last > 0))
        return 0;
    if (!(first > last))
        return INFINITY;
    /* With fall k of c k^-p, ratios of falls are about (2 k - 1 - p) / (2 k - 1 + p). */
    const double ratio = sqrt(last / first), p = (2 * n - 2) * (1 - ratio) / (1 + ratio);
    double fall = last;
    for (int k = n + 1; k <= n + sweeps; k++)
        fall *= (2 * k - 1 - p) / (2 * k - 1 + p);
    return p > 1 ? fall * (n + sweeps) / (p - 1) : INFINITY;
}

int pl_converged(pl_convergence *convergence, double before, double after, double tolerance) {
    for (int i = 1; i < PL_CALM_SWEEPS; i++)
        convergence->fall[i - 1] = convergence->fall[i];
    convergence->fall[PL_CALM_SWEEPS - 1] = before > 0 ? (before - after) / before : 0;
    if (++convergence->n_falls < PL_CALM_SWEEPS)
        return 0;
    for (int i = 0; i < PL_CALM_SWEEPS; i++)
        if (convergence->fall[i] > tolerance)
            return 0;
    return pl_remainder(convergence) < REMAINDER;
}
