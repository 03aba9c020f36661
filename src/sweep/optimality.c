/* optimality: how far the nodes are from a constrained optimum of their stars, all of them. */
#include "sweep/sweep.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"

enum { CHUNK = 1024 }; /* stars that one thread takes at a time */

/** The work on all stars. */
typedef struct work {
    const planish_plan *plan;
    const pl_star_problem *problem;
    pl_star_optimality *of_thread; /* [threads] */
} work;

static void look_at_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const work *w = context;
    const planish_plan *plan = w->plan;
    plan->kernel->guarded->optimality[plan->dim - 2](w->problem, begin, end,
                                                     plan->scratch + plan->scratch_stride * thread,
                                                     &w->of_thread[thread]);
}

static void add(pl_star_optimality *all, pl_star_optimality *part) {
    if (part->residual > all->residual)
        all->residual = part->residual;
    if (part->multiplier > all->multiplier)
        all->multiplier = part->multiplier;
    pl_sum_share(&all->residual2, &part->residual2);
    all->n_active += part->n_active;
    all->n_stars += part->n_stars;
}

/** Combine the figures of all processes. */
static void add_parts(pl_star_optimality *o) {
    int64_t counts[] = {o->n_active, o->n_stars};
    double most[] = {o->residual, o->multiplier};
    pl_parts_add_sums(&o->residual2, 1);
    pl_parts_add(counts, 2);
    pl_parts_largest(most, 2);
    o->n_active = counts[0];
    o->n_stars = counts[1];
    o->residual = most[0];
    o->multiplier = most[1];
}

int pl_optimality(const planish_plan *plan, const pl_visits *visits, const pl_star_problem *problem,
                  pl_star_optimality *optimality, planish_error *error) {
    work w = {plan, problem, pl_alloc_zero(plan->threads, sizeof *w.of_thread)};
    if (!w.of_thread)
        return pl_fail_memory(error, "the optimality of the stars");
    pl_parallel_for(plan->threads, visits->stars.n_stars, CHUNK, look_at_chunk, &w);
    for (int i = 1; i < plan->threads; i++)
        add(&w.of_thread[0], &w.of_thread[i]);
    add_parts(&w.of_thread[0]);
    add(optimality, &w.of_thread[0]);
    pl_free(w.of_thread);
    return PLANISH_OK;
}
