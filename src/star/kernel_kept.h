/* kernel_kept: Hessians that stars keep from visit to visit, for Newton's direction.
 *
 *   kept_direction     the direction by the Hessian that was kept
 *   keep_hessian       keep one
 */
#ifndef PL_STAR_KERNEL_KEPT_H
#define PL_STAR_KERNEL_KEPT_H

#include "star/kernel_step.h"

/* A Hessian is kept where the step that it led to brought less than this part of the star's
 * function, and serves while that is the same but for the second part. Coarser, it serves in a few
 * visits more, and on large meshes the sweeps converge more slowly. */
#define KEEP_BELOW 0.001
#define KEEP_WHILE 0.01

/** Newton's direction by the Hessian that was kept; 0 if the star has changed too much since. */
static inline int kept_direction(const local *here, const pl_star_kept *kept, const objective *f,
                                 const derivatives *derivative, double *direction, const int dim) {
    const double *g = derivative->gradient;
    const int rescaled = exponent_of(here->s.scale) - kept->exponent;
    if (!(fabs(f->sum - (double)kept->sum) <= KEEP_WHILE * f->sum) || rescaled < -1 || rescaled > 1)
        return 0;
    const double scale = power_of_two(2 * rescaled);
    for (int i = 0; i < dim; i++) {
        double sum = 0;
        for (int j = 0; j < dim; j++)
            sum += (double)kept->inverse[i <= j ? packed(i, j, 3) : packed(j, i, 3)] * g[j];
        direction[i] = -sum * scale;
    }
    limit_length(direction, derivative->size2, dim);
    return 1;
}

/** Keep the Hessian of a star with this sum, if it is positive definite. */
static inline void keep_hessian(const local *here, pl_star_kept *kept, const double *hessian,
                                double sum) {
    double inverse[6];
    if (!invert(hessian, inverse))
        return;
    for (int i = 0; i < 6; i++)
        kept->inverse[i] = (float)inverse[i];
    kept->sum = (float)sum;
    kept->exponent = exponent_of(here->s.scale);
}

#endif
