/* optimality: how far the nodes are from a constrained optimum of their stars, all of them. */
#include "sweep/sweep.h"

#include "base/memory.h"
#include "base/parallel.h"
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

int pl_optimality(const planish_plan *plan, const pl_visits *visits, const pl_star_problem *problem,
                  pl_star_optimality *optimality, planish_error *error) {
    work w = {plan, problem, pl_alloc_zero(plan->threads, sizeof *w.of_thread)};
    if (!w.of_thread)
        return pl_fail_memory(error, "the optimality of the stars");
    pl_parallel_for(plan->threads, visits->stars.n_stars, CHUNK, look_at_chunk, &w);
    for (int i = 0; i < plan->threads; i++) {
        pl_star_optimality *part = &w.of_thread[i];
        if (part->residual > optimality->residual)
            optimality->residual = part->residual;
        if (part->multiplier > optimality->multiplier)
            optimality->multiplier = part->multiplier;
        pl_sum_share(&optimality->residual2, &part->residual2);
        optimality->n_active += part->n_active;
        optimality->n_stars += part->n_stars;
    }
    pl_free(w.of_thread);
    return PLANISH_OK;
}
