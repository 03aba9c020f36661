/* kernel_entry: the functions of the kernel's table for one instruction set, and the table.
 *
 *   visit_range, evaluate     stars of either kernel
 *   PL_ENTRIES                the functions of the table for one dimension
 *
 * CMakeLists.txt writes a source for each kernel and instruction set, from kernel.c.in. It includes
 * this file once and defines before: PL_PACK, lanes of a pack; PL_ISA, the name of the instruction
 * set; and PL_KERNEL, the kernel (kernel_lanes.h). Their compiler flags are in CMakeLists.txt.
 */
#include "star/kernel_lanes.h"

#if PL_KERNEL == PL_GUARDED
#include "star/kernel_guarded.h"
#include "star/kernel_untangle.h"
#else
#include "star/kernel_visit.h"
#endif

enum { IS_GUARDED = PL_KERNEL == PL_GUARDED };

/** Visit stars begin .. end - 1. */
static inline void visit_range(const pl_star_problem *problem, int64_t begin, int64_t end,
                               double *scratch, pl_star_tally *tally, const int dim) {
    for (int64_t i = begin; i < begin + AHEAD; i++)
        fetch_ahead(problem, i, end, dim);
    for (int64_t i = begin; i < end; i++) {
        fetch_ahead(problem, i + AHEAD, end, dim);
        const int flags = claim(problem, i);
        if (!flags || (IS_GUARDED && pl_star_is_held(problem->guard, problem->node[i], dim)))
            continue;
        visit_star(problem, i, flags, scratch, tally, dim);
        tally->visits++;
    }
}

/** Evaluate the star of index where its node is. */
static inline int evaluate(const pl_star_problem *problem, int64_t index, double *scratch,
                           int with_derivatives, pl_star_value *value, const int dim) {
    const double *place = problem->coordinates + (int64_t)problem->node[index] * dim;
    int64_t evaluations = 0;
    local here;
    local_init(&here, problem, index, place, NULL, scratch, &evaluations, IS_GUARDED, dim);
    double x[3];
    to_star(&here, place, x, dim);
    derivatives derivative = {{0}, {0}, 0};
    const objective f = evaluate_at(&here, x, with_derivatives, &derivative, dim);
    value->sum = f.sum;
    value->max = f.max;
    value->error = f.error;
    value->certain = f.certain;
    value->size = sqrt(derivative.size2) * here.s.unscale;
    to_mesh(&here, &derivative, value->gradient, value->hessian);
    return f.positive;
}

#define PL_JOIN_(a, b) a##b
#define PL_JOIN(a, b)  PL_JOIN_(a, b)
#define PL_TEXT_(a)    #a
#define PL_TEXT(a)     PL_TEXT_(a)

/* Functions of a table for stars of one dimension, which is a constant in them. */
#define PL_ENTRIES(stars, dim)                                                                     \
    static void visit_##stars(const pl_star_problem *problem, int64_t begin, int64_t end,          \
                              double *scratch, pl_star_tally *tally) {                             \
        visit_range(problem, begin, end, scratch, tally, dim);                                     \
    }                                                                                              \
    static int evaluate_##stars(const pl_star_problem *problem, int64_t index, double *scratch,    \
                                int with_derivatives, pl_star_value *value) {                      \
        return evaluate(problem, index, scratch, with_derivatives, value, dim);                    \
    }

PL_ENTRIES(triangles, 2)
PL_ENTRIES(tetrahedra, 3)

#if PL_KERNEL == PL_GUARDED

#define PL_GUARDED_ENTRIES(stars, dim)                                                             \
    static void optimality_##stars(const pl_star_problem *problem, int64_t begin, int64_t end,     \
                                   double *scratch, pl_star_optimality *optimality) {              \
        optimality_range(problem, begin, end, scratch, optimality, dim);                           \
    }                                                                                              \
    static void untangle_##stars(const pl_star_problem *problem, int64_t begin, int64_t end,       \
                                 double *scratch, pl_star_tally *tally) {                          \
        untangle_range(problem, begin, end, scratch, tally, dim);                                  \
    }                                                                                              \
    static pl_star_energy energy_##stars(const pl_star_problem *problem, int64_t begin,            \
                                         int64_t end, double *scratch, pl_star_slope *slope) {     \
        return energy_range(problem, begin, end, scratch, slope, dim);                             \
    }

PL_GUARDED_ENTRIES(triangles, 2)
PL_GUARDED_ENTRIES(tetrahedra, 3)

const pl_star_guarded PL_JOIN(pl_star_guarded_, PL_ISA) = {
    .visit = {visit_triangles, visit_tetrahedra},
    .evaluate = {evaluate_triangles, evaluate_tetrahedra},
    .optimality = {optimality_triangles, optimality_tetrahedra},
    .untangle = {untangle_triangles, untangle_tetrahedra},
    .energy = {energy_triangles, energy_tetrahedra},
};

#elif PL_KERNEL == PL_MEAN

const pl_star_mean PL_JOIN(pl_star_mean_, PL_ISA) = {
    .visit = {visit_triangles, visit_tetrahedra},
    .evaluate = {evaluate_triangles, evaluate_tetrahedra},
};

#else

const pl_star_kernel PL_JOIN(pl_star_kernel_, PL_ISA) = {
    .name = PL_TEXT(PL_ISA),
    .visit = {visit_triangles, visit_tetrahedra},
    .evaluate = {evaluate_triangles, evaluate_tetrahedra},
    .mean = &PL_JOIN(pl_star_mean_, PL_ISA),
    .guarded = &PL_JOIN(pl_star_guarded_, PL_ISA),
};

#endif
