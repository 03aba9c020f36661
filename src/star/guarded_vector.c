/* guarded_vector: the guarded kernel as vectors of two doubles, which every 64-bit instruction set
 * has.
 */
#define PL_PACK 2
#include "star/guarded.h"
#include "star/untangle.h"

const pl_star_guarded pl_star_guarded_vector = {
    .visit = {visit_triangles, visit_tetrahedra},
    .evaluate = {evaluate_triangles, evaluate_tetrahedra},
    .optimality = {optimality_triangles, optimality_tetrahedra},
    .untangle = {untangle_triangles, untangle_tetrahedra},
    .energy = {energy_triangles, energy_tetrahedra},
};
