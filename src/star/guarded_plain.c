/* guarded_plain: the guarded kernel as scalar C, the reference for all the others. */
#define PL_PACK 1
#include "star/guarded.h"
#include "star/untangle.h"

const pl_star_guarded pl_star_guarded_plain = {
    .visit = {visit_triangles, visit_tetrahedra},
    .evaluate = {evaluate_triangles, evaluate_tetrahedra},
    .optimality = {optimality_triangles, optimality_tetrahedra},
    .untangle = {untangle_triangles, untangle_tetrahedra},
    .energy = {energy_triangles, energy_tetrahedra},
};
