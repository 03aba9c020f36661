/* kernel_vector: the star kernel as vectors of two doubles, which every 64-bit instruction set has.
 */
#define PL_PACK 2
#include "star/visit.h"

const pl_star_kernel pl_star_kernel_vector = {
    .name = "vector",
    .visit = {visit_triangles, visit_tetrahedra},
    .evaluate = {evaluate_triangles, evaluate_tetrahedra},
    .guarded = &pl_star_guarded_vector,
};
