/* vtk_cells: the cells of VTK's grids, whatever file they stand in: simplices go to the model, all
 * others hold their nodes. Cells and points are numbered from 0, as VTK does.
 */
#ifndef PL_IO_VTK_VTK_CELLS_H
#define PL_IO_VTK_VTK_CELLS_H

#include "io/core/model.h"
#include "io/core/text.h"

/** Cells as a file lists them, or those of a piece of it. */
typedef struct vtk_grid {
    int64_t n;             /* cells */
    int32_t *connectivity; /* [n_connectivity] nodes of the cells, one after the other; without
                              offset each cell's are led by their count */
    int64_t n_connectivity;
    int64_t *offset;     /* [n + 1] first node of each cell in connectivity, or NULL */
    const int32_t *type; /* [n] VTK's cell types */
    int64_t n_points;    /* nodes are 0 .. n_points - 1, */
    int64_t first_point; /* which are the model's from this one on */
    int64_t first_cell;  /* number of the first cell */
    int is_piece;        /* there are more pieces */
    int has_streams;     /* a polyhedron's nodes are a stream of its faces (vtk_faces_hold) */
} vtk_grid;

/** Store the lines, triangles and tetrahedra, hold the nodes of all other cells, of whatever type.
 * Called for each piece of a file. Error: _FORMAT, names the cell. */
int vtk_cells_store(io_model *model, const vtk_grid *cells, planish_error *error);

/** Hold nodes [n] of the grid. 0; -1: one is not among its points. */
int vtk_nodes_hold(io_model *model, const vtk_grid *cells, const int32_t *nodes, int64_t n);

/** Hold the nodes of a polyhedron's faces, stream [n]: how many faces, and of each how many nodes
 * it has, and which. 0; -1: that is not what the stream is. */
int vtk_faces_hold(io_model *model, const vtk_grid *cells, const int32_t *stream, int64_t n);

#endif
