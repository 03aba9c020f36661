/* multipliers: those of the least volumes, between the sweeps of the augmented Lagrangian. Every
 * star keeps those of its own elements; as all stars see the same volumes, they agree. */
#define PL_PACK 1
#include "star/local.h"

/* A change of lambda / rho below this changes nothing for the star. */
#define SHIFT_STILL 1e-4
/* A least volume is in force with g above minus this. */
#define IN_FORCE 0.003

static double update_star(const pl_star_problem *problem, int64_t index, int wake, double *scratch,
                          const int dim) {
    const double *place = problem->coordinates + (int64_t)problem->node[index] * dim;
    const star s = gather(problem, index, place, scratch, 1, dim);
    const int64_t first = problem->link_offset[index];
    double *shift = problem->guard->link_shift + first, largest = 0, closest = NEVER_ACTIVE;
    double x[3] = {0, 0, 0};
    for (int d = 0; d < dim; d++)
        x[d] = place[d] * s.scale;
    for (int64_t i = 0; i < s.n_facets; i++) {
        aspect a;
        measure_at(&s, i, x, &a, dim);
        double g = volume_constraint(&s, i, a.D);
        double next = shift[i] + g > 0 ? shift[i] + g : 0, change = fabs(next - shift[i]);
        shift[i] = next;
        largest = change > largest ? change : largest;
        closest = g > closest ? g : closest;
    }
    if (largest > SHIFT_STILL || (wake && closest > -IN_FORCE))
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
