/* kernel_plain: the star kernel as scalar C, the reference for all the others. */
#define PL_PACK 1
#include "star/visit.h"

const pl_star_kernel pl_star_kernel_plain = {
    .name = "plain",
    .visit = {visit_triangles, visit_tetrahedra},
    .evaluate = {evaluate_triangles, evaluate_tetrahedra},
    .guarded = &pl_star_guarded_plain,
};
