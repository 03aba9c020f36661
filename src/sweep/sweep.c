/* sweep: one pass over the colours of a plan. Nodes of one colour share no element, so they are
 * visited in parallel, each reading its neighbours and writing only itself. */
#include "sweep/sweep.h"

#include "base/parallel.h"
#include "base/parts.h"

#include <string.h>

/** Some stars of a colour under way. */
typedef struct colour_pass {
    const planish_plan *plan;
    const pl_star_problem *problem;
    planish_method method;
    int64_t first; /* star */
} colour_pass;

static void visit_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const colour_pass *pass = context;
    const planish_plan *plan = pass->plan;
    const pl_star_problem *problem = pass->problem;
    double *scratch = plan->scratch + plan->scratch_stride * thread;
    pl_star_tally *tally = &plan->tally[thread].of;
    const pl_star_guarded *guarded = plan->kernel->guarded;
    pl_star_visit_fn *visit =
        problem->guard ? guarded->visit[plan->dim - 2] : plan->kernel->visit[plan->dim - 2];
    begin += pass->first;
    end += pass->first;
    if (problem->untangling)
        guarded->untangle[plan->dim - 2](problem, begin, end, scratch, tally);
    else if (pass->method != PLANISH_METHOD_PLANISH)
        pl_star_average(problem, pass->method, plan->dim, begin, end, scratch, tally);
    else
        visit(problem, begin, end, scratch, tally);
}

/** Place a follower. If the node that it follows has not moved, the follower keeps its first
 *  coordinates, unrounded. */
static void place_follower(const planish_plan *plan, const pl_follower *f,
                           const pl_storage *storage) {
    const double *of = plan->coordinates + (int64_t)f->of * plan->dim;
    double *x = plan->coordinates + (int64_t)f->node * plan->dim;
    for (int d = 0; d < plan->dim; d++) {
        const double way = of[d] - f->origin[d], place = f->start[d] + way;
        x[d] = way != 0 && storage ? pl_store(storage, place) : place;
    }
}

void pl_follow(const planish_plan *plan, const pl_star_problem *problem) {
    for (int64_t k = 0; k < plan->sliding.n_followers; k++) {
        const pl_follower *f = &plan->sliding.follower[k];
        place_follower(plan, f, f->node < plan->work.n_nodes ? &problem->storage : NULL);
        uint8_t *changed = &plan->changed[f->of];
        *changed |= plan->changed[f->node];
        if (plan->changed[f->node] & PL_CHANGED)
            *changed &= (uint8_t)~PL_TOLD; /* a star around has moved since */
        plan->changed[f->node] = PL_BAD;   /* so that it is told */
    }
}

/** How many of n stars a thread takes at a time: of few fewer, so that all threads end together;
 *  but one takes all if to wake the others would cost more than they save. */
static int64_t chunk_of(int64_t n, int threads) {
    enum { FEWEST = 4, CHUNKS_EACH = 8 };
    const int64_t chunk = n / CHUNKS_EACH / threads;
    if (n <= PL_CHUNK_STARS || chunk > PL_CHUNK_STARS)
        return PL_CHUNK_STARS;
    return chunk < FEWEST ? FEWEST : chunk;
}

/** Visit a range of stars of a colour. */
static void visit_stars(colour_pass *pass, int64_t begin, int64_t end) {
    const int threads = pass->plan->threads;
    pass->first = begin;
    pl_parallel_for(threads, end - begin, chunk_of(end - begin, threads), visit_chunk, pass);
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

/** Nodes that all threads have visited in this sweep. */
static int64_t count_visits(const planish_plan *plan) {
    int64_t visits = 0;
    for (int t = 0; t < plan->threads; t++)
        visits += plan->tally[t].of.visits;
    return visits;
}

/** Add up the tallies of the threads. */
static void add_threads(const planish_plan *plan, pl_sweep_tally *tally) {
    for (int t = 0; t < plan->threads; t++) {
        pl_star_tally *part = &plan->tally[t].of;
        pl_sum_share(&tally->decrease, &part->decrease);
        tally->visits += part->visits;
        tally->evaluations += part->evaluations;
        tally->improved += part->improved;
        tally->restored += part->restored;
    }
}

/** Combine the tallies and answers of all processes. */
static void add_parts(pl_sweep_tally *tally) {
    int64_t counts[] = {tally->visits, tally->evaluations, tally->improved, tally->restored};
    double stopped = tally->stopped;
    pl_parts_add_sums(&tally->decrease, 1);
    pl_parts_add(counts, sizeof counts / sizeof *counts);
    pl_parts_largest(&stopped, 1);
    tally->visits = counts[0];
    tally->evaluations = counts[1];
    tally->improved = counts[2];
    tally->restored = counts[3];
    tally->stopped = (int)stopped;
}

static void add(pl_sweep_tally *tally, pl_sweep_tally *part) {
    pl_sum_share(&tally->decrease, &part->decrease);
    tally->visits += part->visits;
    tally->evaluations += part->evaluations;
    tally->improved += part->improved;
    tally->restored += part->restored;
    tally->stopped = part->stopped;
}

void pl_sweep(const planish_plan *plan, const pl_visits *visits, const pl_star_problem *problem,
              planish_method method, pl_after_colour_fn *after_colour, void *context,
              pl_sweep_tally *tally) {
    const int together = plan->context->part != NULL; /* none stops alone */
    colour_pass pass = {.plan = plan, .problem = problem, .method = method};
    pl_sweep_tally mine = {.stopped = 0};
    int64_t visited = 0;
    if (tally->stopped)
        return;
    memset(plan->tally, 0, (size_t)plan->threads * sizeof *plan->tally);
    if (visits->n_followers > 0)
        pl_follow(plan, problem);
    for (int c = 0; c < visits->n_colours && (!mine.stopped || together); c++) {
        const int64_t before = visited;
        visit_colour(&pass, visits, c);
        visited = count_visits(plan);
        tally->colours++;
        if (visits->n_followers > 0)
            pl_follow(plan, problem);
        const int said = after_colour(context, tally->colours, visited - before);
        mine.stopped = said > mine.stopped ? said : mine.stopped;
    }
    add_threads(plan, &mine);
    add_parts(&mine);
    add(tally, &mine);
}
