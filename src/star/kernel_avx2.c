/* kernel_avx2: the star kernel as vectors of four doubles, compiled for x86-64-v3. */
#define PL_PACK 4
#include "star/visit.h"

const pl_star_kernel pl_star_kernel_avx2 = {
    .name = "avx2",
    .visit = {visit_triangles, visit_tetrahedra},
    .evaluate = {evaluate_triangles, evaluate_tetrahedra},
    .guarded = &pl_star_guarded_avx2,
};
