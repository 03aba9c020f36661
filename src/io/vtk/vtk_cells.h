/* vtk_cells: the cells of VTK's grids, whatever file they stand in.
 *
 *   vtk_grid, vtk_grid_release         cells as a file lists them
 *   vtk_cells_store                    cells go to the model, or hold their nodes
 *   vtk_nodes_hold, vtk_faces_hold     nodes of polyhedra
 *
 * Cells and points are numbered from 0, as VTK does.
 */
#ifndef PL_IO_VTK_VTK_CELLS_H
#define PL_IO_VTK_VTK_CELLS_H

#include "io/core/model.h"

enum {
    VTK_VERTEX = 1,
    VTK_POLY_VERTEX = 2,
    VTK_LINE = 3,
    VTK_POLY_LINE = 4,
    VTK_TRIANGLE = 5,
    VTK_TRIANGLE_STRIP = 6,
    VTK_POLYGON = 7,
    VTK_PIXEL = 8,
    VTK_TETRAHEDRON = 10,
    VTK_VOXEL = 11,
    VTK_POLYHEDRON = 42,
    VTK_LAGRANGE_CURVE = 68,
    VTK_LAGRANGE_TRIANGLE = 69,
    VTK_LAGRANGE_TETRAHEDRON = 71,
    VTK_LAGRANGE_WEDGE = 73,
    VTK_LAST_TYPE = 255 /* VTK keeps types in bytes */
};

/** Cells as a file lists them, or those of a piece of it. */
typedef struct vtk_grid {
    int64_t n;             /* cells */
    int32_t *connectivity; /* [n_connectivity] owned: nodes of the cells, one after the other;
                              without offset each cell's are led by their count */
    int64_t n_connectivity;
    int64_t *offset;     /* [n + 1] owned: first node of each cell in connectivity, or NULL */
    int32_t *type;       /* [n] owned: VTK's cell types */
    int64_t n_points;    /* nodes are 0 .. n_points - 1, */
    int64_t first_point; /* which are the model's from this one on */
    int64_t first_cell;  /* number of the first cell */
    int is_piece;        /* there are more pieces */
    int has_streams;     /* a polyhedron's nodes are a stream of its faces (vtk_faces_hold) */
} vtk_grid;

/** Release the lists of a grid; NULL then. */
void vtk_grid_release(vtk_grid *grid);

/** Store the cells that a planish_cell_type stands for, and lines; hold the nodes of all others, of
 *  whatever type. Called for each piece of a file.
 *  Error: _FORMAT, names the cell; offsets are checked, too. */
int vtk_cells_store(io_model *model, const vtk_grid *grid, planish_error *error);

/** Hold nodes [n] of the grid. 0; -1: one is not among its points. */
int vtk_nodes_hold(io_model *model, const vtk_grid *grid, const int32_t *nodes, int64_t n);

/** Hold the nodes of a polyhedron's faces, stream [n]: how many faces, and of each how many nodes
 *  it has, and which. 0; -1: that is not what the stream is. */
int vtk_faces_hold(io_model *model, const vtk_grid *grid, const int32_t *stream, int64_t n);

#endif
