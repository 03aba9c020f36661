/* view: what planish understands of a mesh file, as arrays for another file that shows it: points,
 * the cells that it keeps (tetrahedra, triangles, lines, other elements of three and of
 * two dimensions, in this order), and data of
 * both.
 *
 *   io_view, io_view_of                the mesh
 *   io_view_array, io_view_arrays_of   its arrays
 *   io_view_write, io_view_group       write an array; the text of a group
 *   io_view_write_vtu, _vtk            write a file (view_vtu.c, view_vtk.c)
 */
#ifndef PL_IO_VIEW_VIEW_H
#define PL_IO_VIEW_VIEW_H

#include "io/core/model.h"
#include "base/output.h"

/** A mesh to be shown. */
typedef struct io_view {
    const io_model *model;
    const double *coordinates; /* [n_nodes][written] */
    const uint8_t *constraint; /* [n_nodes] of planish_constraint, or NULL */
    planish_view_data data;    /* all NULL: none */
    int64_t n_cells;
} io_view;

typedef enum io_view_type {
    IO_VIEW_U8,
    IO_VIEW_I32,
    IO_VIEW_I64,
    IO_VIEW_F32,
    IO_VIEW_F64
} io_view_type;

/** Meaning of the values of an array. */
typedef enum io_view_values {
    IO_VIEW_COORDINATES,   /* real, three of each node */
    IO_VIEW_RADIUS_RATIOS, /* real, as the others of elements: view->data */
    IO_VIEW_ASPECT_RATIOS,
    IO_VIEW_SCALED_JACOBIANS,
    IO_VIEW_JACOBIAN_RATIOS,
    IO_VIEW_EDGE_RATIOS,
    IO_VIEW_STATES, /* view->data, as is */
    IO_VIEW_CURVED,
    IO_VIEW_FIXED,
    IO_VIEW_NODE_NUMBERS,
    IO_VIEW_NODES,         /* of all cells, one cell after another, */
    IO_VIEW_COUNTED_NODES, /* or led by how many a cell has */
    IO_VIEW_ENDS,          /* where the nodes of each cell end */
    IO_VIEW_TYPES,         /* VTK's */
    IO_VIEW_REGIONS,
    IO_VIEW_GROUPS,
    IO_VIEW_CELL_NUMBERS
} io_view_values;

/** An array of a view. */
typedef struct io_view_array {
    const char *name;
    io_view_values values;
    io_view_type type;
    int64_t n;        /* values in all */
    int n_components; /* of a point or cell */
} io_view_array;

enum { IO_VIEW_MOST_DATA = 10 };

/** All arrays of a view; data that there is not is left out. */
typedef struct io_view_arrays {
    io_view_array points, connectivity, offsets, types;
    io_view_array counted, wide_types; /* cells as legacy VTK has them: each led by its number of
                                          nodes; types of 32 bits */
    io_view_array point_data[IO_VIEW_MOST_DATA], cell_data[IO_VIEW_MOST_DATA];
    int n_point_data, n_cell_data;
} io_view_arrays;

/** Return a view of a mesh; all arrays are borrowed. data may be NULL. */
io_view io_view_of(const io_model *model, const double *coordinates, const uint8_t *constraint,
                   const planish_view_data *data);
/** Return the arrays of a view, which must stay while they are used. */
io_view_arrays io_view_arrays_of(const io_view *view);

/** Return the bytes of a value. */
int io_view_type_size(io_view_type type);

/** Write an array's values, in the other byte order if swapped. */
int io_view_write(const io_view *view, const io_view_array *array, int swapped, pl_output *output,
                  planish_error *error);

/** Write the named group number i of the model as "DIM:TAG NAME"; return snprintf's. */
int io_view_group(const io_model *model, int32_t i, char *text, size_t size);

/** Write a file. *lost: what else is left out, or NULL. */
int io_view_write_vtu(const io_view *view, pl_output *output, const char **lost,
                      planish_error *error);
int io_view_write_vtk(const io_view *view, pl_output *output, const char **lost,
                      planish_error *error);

#endif
