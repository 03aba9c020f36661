/* guarded_avx512: the guarded kernel as vectors of four doubles and 32 registers, compiled for
 * x86-64-v4. */
#define PL_PACK 4
#include "star/guarded.h"
#include "star/untangle.h"

const pl_star_guarded pl_star_guarded_avx512 = {
    .visit = {visit_triangles, visit_tetrahedra},
    .evaluate = {evaluate_triangles, evaluate_tetrahedra},
    .optimality = {optimality_triangles, optimality_tetrahedra},
    .untangle = {untangle_triangles, untangle_tetrahedra},
    .energy = {energy_triangles, energy_tetrahedra},
};
