/* multipliers: those of the minimum volumes, between the sweeps of the augmented Lagrangian. Every
 * star keeps those of its own elements; as all stars see the same volumes, they agree. */
#define PL_PACK 1
#include "star/kernel_local.h"

/* A change of lambda / rho below this changes nothing for the star. */
#define SHIFT_STILL 1e-4
/* The shift of an element that was below its minimum volume to begin with: it keeps the penalty, or
 * it would sink, but the multiplier of what cannot be met would grow for ever. */
#define GIVEN_UP (-0x1p-1000)
/* Below by as much as this after everything else was tried: it cannot be met. */
#define OUT_OF_REACH (4 * PLANISH_VOLUME_TOLERANCE)

static double update_star(const pl_star_problem *problem, int64_t index, int wake, double *scratch,
                          const int dim) {
    const double *place = problem->coordinates + (int64_t)problem->node[index] * dim;
    const star s = gather(problem, index, place, NULL, scratch, 1, dim);
    const int64_t first = problem->link_offset[index];
    double *shift = problem->guard->link_shift + first, largest = 0, closest = NEVER_ACTIVE;
    double x[3] = {0, 0, 0};
    for (int d = 0; d < dim; d++)
        x[d] = place[d] * s.scale;
    for (int64_t i = 0; i < s.n_facets; i++) {
        aspect a;
        measure_at(&s, i, x, &a, dim);
        double g = volume_constraint(&s, i, a.D);
        closest = g > closest ? g : closest;
        if (wake && g > OUT_OF_REACH)
            shift[i] = GIVEN_UP;
        if (shift[i] < 0)
            continue;
        double next = shift[i] + g > 0 ? shift[i] + g : 0, change = fabs(next - shift[i]);
        shift[i] = next;
        largest = change > largest ? change : largest;
    }
    if (largest > SHIFT_STILL || (wake && closest > -PLANISH_VOLUME_TOLERANCE))
        problem->changed[problem->node[index]] = 1;
    return largest;
}

double pl_star_update_shifts(const pl_star_problem *problem, int dim, int wake, int64_t begin,
                             int64_t end, double *scratch) {
    double largest = 0;
    for (int64_t i = begin; i < end; i++) {
        double change = dim == 3 ? update_star(problem, i, wake, scratch, 3)
                                 : update_star(problem, i, wake, scratch, 2);
        largest = change > largest ? change : largest;
    }
    return largest;
}
