/* foam_builder: OpenFOAM meshes from elements: their faces, in every encoding. */
#ifndef TEST_SUPPORT_FOAM_BUILDER_H
#define TEST_SUPPORT_FOAM_BUILDER_H

#include <stdint.h>

enum { FOAM_MOST = 4096 }; /* cells, points */

/** A mesh of elements in VTK's order. */
typedef struct foam_cells {
    int n_points, n_cells;
    double x[FOAM_MOST][3];
    int type[FOAM_MOST]; /* planish_cell_type of first order */
    int node[FOAM_MOST][8];
    int merged[FOAM_MOST]; /* not 0: the cell is one with the cell before it: a polyhedron */
} foam_cells;

/** How files are written. */
typedef struct foam_form {
    int binary, swapped;
    int label_size, scalar_size; /* 4, 8 */
    int single_faces;            /* binary: a face is a list of its own */
    int has_no_arch;             /* the header says nothing of sizes */
} foam_form;

/** Return the number of the patch that a face of the boundary is on, by its middle; patches follow each
 *  other by these numbers. */
typedef int foam_patch_of(const double *middle);

/** Write points, faces, owner, neighbour and boundary to folder. patches: text of each patch but its
 *  faces, "NAME TYPE ENTRIES", NULL at the end. */
void foam_build(const char *folder, const foam_cells *cells, const foam_form *form,
                const char *const *patches, foam_patch_of *patch_of);

/** Make nx * ny * nz hexahedra of edges 1, whose inner points are a little off. */
void foam_make_bricks(foam_cells *cells, int nx, int ny, int nz);

/** Split the hexahedron i into two wedges, which stand along z: the second is the last cell. */
void foam_split_brick(foam_cells *cells, int i);

#endif
