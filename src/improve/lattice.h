/* lattice: displacements that are linear on the simplices of regular grids, and multigrid for them.
 *
 * Each cube of a grid is cut into six simplices along its main diagonal (Freudenthal, Annals of
 * Mathematics 43, 1942); in the plane, cubes are squares, and each is cut into two triangles.
 * Simplices of a grid of half the spacing lie within those of the other one.
 * Where elements are too large for a grid its vertices are not active, and elements and nodes belong
 * to a coarser one. The unit of coordinates is the spacing of the finest grid.
 *
 * Elements are those of the plan: of a mesh of cells their corners (geometry/corner.h).
 * Nodes that slide on planes and lines go as the projection of the displacement there.
 *
 * Terms of elements and nodes are rounded to multiples of one power of two, so that their sums are
 * exact in any order. Threads and processes therefore get the same bits. If the mesh is in parts,
 * each process has all vertices of all grids, and the elements and nodes of its part.
 *
 *   pl_lattice_create, _destroy    grids for the mesh as it is
 *   pl_lattice_sort                elements and nodes by simplices
 *   pl_lattice_solve               displacements of vertices for their forces
 *
 * lattice_stiffness.h has the forces and the Hessian.
 */
#ifndef PL_IMPROVE_LATTICE_H
#define PL_IMPROVE_LATTICE_H

#include "plan/plan.h"

enum {
    PL_LATTICE_LEVELS = 24,
    PL_LATTICE_BLOCK = 9 /* entries of the block of two vertices, by rows: at most */
};

/** Freedom of a node. */
enum {
    PL_LATTICE_HELD = 0,
    PL_LATTICE_FREE = 1,
    PL_LATTICE_ON_PLANE = PLANISH_CONSTRAINT_ON_PLANE,
    PL_LATTICE_ON_LINE = PLANISH_CONSTRAINT_ON_LINE
};

/** One grid; vertices are numbered x first. Slabs are the vertices of one last coordinate, or the
 *  cubes that begin there. Arrays are owned. */
typedef struct pl_grid {
    int64_t n[3]; /* vertices along each direction; in the plane n[2] is 1 */
    int64_t n_vertices, n_slabs, per_slab; /* vertices; slabs of vertices, vertices of each */
    int64_t first; /* number of its first simplex: (vertex at the corner) (2 or 6) + order */
    double per_spacing[3]; /* spacings of this grid per unit, along each direction */
    double *stiffness;     /* [n_vertices][2^dim][dim][dim] */
    double *inverse;       /* [n_vertices][dim][dim] of the blocks of the vertices themselves */
    double *force; /* [n_vertices][dim] of the nodes that belong to this grid, less that of total */
    double *move;  /* [n_vertices][dim] approximate solution for force: of one V-cycle */
    double *load;  /* [n_vertices][dim] force, and the residual of finer grids */
    double *residual;                   /* [n_vertices][dim] of load and move */
    double *direction, *change, *total; /* [n_vertices][dim] of conjugate gradients: the search
                                           direction, the change of force along it, the solution */
    int has_own;                        /* elements or nodes belong to it, not to finer grids */
    uint8_t *is_active;                 /* [n_vertices] */
} pl_grid;

/** Grids, the finest first; and what lies in them. */
typedef struct pl_lattice {
    const planish_plan *plan;
    double origin[3], spacing, per_unit; /* of the mesh's coordinates; of the finest grid */
    int one_in;                          /* elements in the Hessian: it stands for so many */
    int n_levels;
    pl_grid grid[PL_LATTICE_LEVELS];
    int64_t n_simplices;
    int64_t n_terms;        /* elements in the Hessian, of all processes */
    int64_t n_stars;        /* of nodes that may move, see pl_lattice_node */
    int64_t n_moving;       /* of all processes */
    uint8_t *freedom;       /* [nodes of the plan] by inner numbers: PL_LATTICE_HELD, ... */
    double *direction;      /* [nodes of the plan][dim] unit normals of planes, directions of lines;
                               NULL: no node slides */
    int is_known;           /* corner begins with [n_elements] simplices of the finest grid */
    int32_t *element;       /* [elements in the Hessian] by simplices */
    int32_t *corner;        /* [elements in the Hessian][dim + 1] their nodes, inner numbers; room
                               for the simplices of elements before */
    double *of_slab;        /* [slabs of the finest grid] */
    int64_t *element_begin; /* [n_simplices + 1] */
    int32_t *star;          /* [n_stars] by simplices */
    int32_t *simplex_of;    /* [n_stars] */
    int64_t *star_begin;    /* [n_simplices + 1] */
} pl_lattice;

/** Make grids for the mesh as it is, spacing times as wide as edges are long. One in so many of the
 *  elements with a free node, but none that slides, stands for all in the Hessian. slides: nodes on planes
 *  and lines move, too, and follow no others. stays [nodes of the plan], by inner numbers: 1: the node is
 *  held; NULL: none is. Returns 0 in all processes if one lacks
 *  memory, or if the mesh has no extent; destroy the lattice in any case. */
int pl_lattice_create(const planish_plan *plan, double spacing, int one_in, int slides,
                      const uint8_t *stays, pl_lattice *lattice);

/** Return the node of a star: of the interior's stars, then of those that slide, if these move. */
static inline int32_t pl_lattice_node(const pl_lattice *lattice, int64_t star) {
    const pl_visits *interior = &lattice->plan->interior;
    const int64_t n = interior->stars.n_stars;
    return star < n ? interior->centre[star] : lattice->plan->sliding.centre[star - n];
}

/** Free the arrays of a lattice. */
void pl_lattice_destroy(pl_lattice *lattice);

/** Put elements and nodes to the simplices that they are in. */
void pl_lattice_sort(pl_lattice *lattice);

/** Function that is asked between iterations; not 0: stop. */
typedef int pl_lattice_ask_fn(void *context);

/** Find how far the vertices must move for their forces, by conjugate gradients with a V-cycle each:
 *  until the residual has fallen to part of itself, at most n of them. Returns not 0 if ask said so. */
int pl_lattice_solve(pl_lattice *lattice, double part, int n, pl_lattice_ask_fn *ask,
                     void *context);

#endif
