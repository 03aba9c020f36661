/* optimality: how far the nodes are from a constrained optimum of their stars, all of them. */
#include "sweep/sweep.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"

enum { CHUNK = 1024 }; /* stars whose sums are added together */

/** The work on all stars. */
typedef struct work {
    const planish_plan *plan;
    const pl_star_problem *problem;
    pl_star_optimality *partial; /* [chunks] */
} work;

static void look_at_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const work *w = context;
    const planish_plan *plan = w->plan;
    plan->kernel->guarded->optimality[plan->dim - 2](w->problem, begin, end,
                                                     plan->scratch + plan->scratch_stride * thread,
                                                     &w->partial[begin / CHUNK]);
}

int pl_optimality(const planish_plan *plan, const pl_visits *visits, const pl_star_problem *problem,
                  pl_star_optimality *optimality, planish_error *error) {
    const int64_t n = visits->stars.n_stars, chunks = (n + CHUNK - 1) / CHUNK;
    work w = {plan, problem, pl_alloc_zero(chunks + 1, sizeof *w.partial)};
    if (!w.partial)
        return pl_fail_memory(error, "the optimality of the stars");
    pl_parallel_for(plan->threads, n, CHUNK, look_at_chunk, &w);
    for (int64_t i = 0; i < chunks; i++) {
        const pl_star_optimality *part = &w.partial[i];
        if (part->residual > optimality->residual)
            optimality->residual = part->residual;
        if (part->multiplier > optimality->multiplier)
            optimality->multiplier = part->multiplier;
        optimality->residual2 += part->residual2;
        optimality->n_active += part->n_active;
        optimality->n_stars += part->n_stars;
    }
    pl_free(w.partial);
    return PLANISH_OK;
}
