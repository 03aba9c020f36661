/* kernel_entry: the kernel's table of functions for one instruction set.
 *
 * Each of kernel_*.c and guarded_*.c includes this file once. It defines before: PL_PACK, lanes of
 * a pack; PL_ISA, the name of the instruction set; and PL_GUARDED in guarded_*.c. Their compiler
 * flags are in CMakeLists.txt.
 */
#define PL_JOIN_(a, b) a##b
#define PL_JOIN(a, b)  PL_JOIN_(a, b)
#define PL_TEXT_(a)    #a
#define PL_TEXT(a)     PL_TEXT_(a)

#ifdef PL_GUARDED
#include "star/kernel_guarded.h"
#include "star/kernel_untangle.h"

const pl_star_guarded PL_JOIN(pl_star_guarded_, PL_ISA) = {
    .visit = {visit_triangles, visit_tetrahedra},
    .evaluate = {evaluate_triangles, evaluate_tetrahedra},
    .optimality = {optimality_triangles, optimality_tetrahedra},
    .untangle = {untangle_triangles, untangle_tetrahedra},
    .energy = {energy_triangles, energy_tetrahedra},
};
#else
#include "star/kernel_visit.h"

const pl_star_kernel PL_JOIN(pl_star_kernel_, PL_ISA) = {
    .name = PL_TEXT(PL_ISA),
    .visit = {visit_triangles, visit_tetrahedra},
    .evaluate = {evaluate_triangles, evaluate_tetrahedra},
    .guarded = &PL_JOIN(pl_star_guarded_, PL_ISA),
};
#endif
