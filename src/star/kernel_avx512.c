/* kernel_avx512: the star kernel as vectors of four doubles and 32 registers, compiled for
 * x86-64-v4. */
#define PL_PACK 4
#include "star/visit.h"

const pl_star_kernel pl_star_kernel_avx512 = {
    .name = "avx512",
    .visit = {visit_triangles, visit_tetrahedra},
    .evaluate = {evaluate_triangles, evaluate_tetrahedra},
    .guarded = &pl_star_guarded_avx512,
};
