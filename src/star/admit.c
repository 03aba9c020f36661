/* admit: where bounds, and what can be stored, let a node be. */
#define PL_PACK 1
#include "star/kernel_local.h"

int pl_star_admit(const pl_star_problem *problem, int32_t node, int dim, double *x) {
    const bounds none = {.any = 0};
    const bounds b = problem->guard ? bounds_of(problem, node, 1, dim) : none;
    clamp(&b, x, dim);
    for (int d = 0; d < dim; d++)
        x[d] = pl_store(&problem->storage, x[d]);
    return within_bounds(&b, x, dim); /* rounding may have left them */
}
