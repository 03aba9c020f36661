/* sweep: one pass over the colours of a plan. Nodes of one colour share no element, so they are
 * visited in parallel, each reading its neighbours and writing only itself. */
#include "sweep/sweep.h"

#include "base/parallel.h"
#include "base/parts.h"

/** One colour under way. */
typedef struct colour_pass {
    const planish_plan *plan;
    const pl_star_problem *problem;
    planish_method method;
    int64_t first;       /* star */
    pl_star_tally tally; /* shared */
} colour_pass;

static pl_star_tally visit(const colour_pass *pass, int64_t begin, int64_t end, double *scratch) {
    const planish_plan *plan = pass->plan;
    if (pass->problem->untangling)
        return plan->kernel->guarded->untangle[plan->dim - 2](pass->problem, begin, end, scratch);
    if (pass->method != PLANISH_METHOD_PLANISH)
        return pl_star_average(pass->problem, pass->method, plan->dim, begin, end, scratch);
    if (pass->problem->guard)
        return plan->kernel->guarded->visit[plan->dim - 2](pass->problem, begin, end, scratch);
    return plan->kernel->visit[plan->dim - 2](pass->problem, begin, end, scratch);
}

static void visit_chunk(void *context, int64_t begin, int64_t end, int thread) {
    colour_pass *pass = context;
    const planish_plan *plan = pass->plan;
    pl_star_tally tally = visit(pass, pass->first + begin, pass->first + end,
                                plan->scratch + plan->scratch_stride * thread);
    pl_sum_share(&pass->tally.decrease, &tally.decrease);
    __atomic_fetch_add(&pass->tally.visits, tally.visits, __ATOMIC_RELAXED);
    __atomic_fetch_add(&pass->tally.evaluations, tally.evaluations, __ATOMIC_RELAXED);
    __atomic_fetch_add(&pass->tally.improved, tally.improved, __ATOMIC_RELAXED);
    __atomic_fetch_add(&pass->tally.restored, tally.restored, __ATOMIC_RELAXED);
}

/** Where a follower is. What it follows may not have moved: then it is where it was, as it was. */
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
        place_follower(plan, f, f->node < plan->n_nodes ? &problem->storage : NULL);
        uint8_t *changed = &plan->changed[f->of];
        *changed |= plan->changed[f->node];
        if (plan->changed[f->node] & PL_CHANGED)
            *changed &= (uint8_t)~PL_TOLD; /* a star around has moved since */
        plan->changed[f->node] = PL_BAD; /* so that it is told */
    }
}

/** Visit a range of stars of a colour. */
static void visit_stars(colour_pass *pass, int64_t begin, int64_t end) {
    pass->first = begin;
    pl_parallel_for(pass->plan->threads, end - begin, PL_CHUNK_STARS, visit_chunk, pass);
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

/** What the processes have done, and said, together. */
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
    pl_sweep_tally mine = {.stopped = 0};
    if (tally->stopped)
        return;
    if (visits->n_followers > 0)
        pl_follow(plan, problem);
    for (int c = 0; c < visits->n_colours && (!mine.stopped || together); c++) {
        colour_pass pass = {.plan = plan, .problem = problem, .method = method};
        visit_colour(&pass, visits, c);
        pl_sum_share(&mine.decrease, &pass.tally.decrease);
        mine.visits += pass.tally.visits;
        mine.evaluations += pass.tally.evaluations;
        mine.improved += pass.tally.improved;
        mine.restored += pass.tally.restored;
        tally->colours++;
        if (visits->n_followers > 0)
            pl_follow(plan, problem);
        const int said = after_colour(context, tally->colours, pass.tally.visits);
        mine.stopped = said > mine.stopped ? said : mine.stopped;
    }
    add_parts(&mine);
    add(tally, &mine);
}
