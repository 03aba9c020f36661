/* vtk_arrays: a mesh that is written as the arrays that both of VTK's formats have.
 *
 *   vtk_out_array, vtk_out_arrays        the arrays
 *   vtk_arrays_begin, vtk_arrays_end     those of a view
 *   vtk_arrays_set_groups                other numbers of groups
 *   vtk_put_array                        write the values of one
 */
#ifndef PL_IO_VTK_VTK_ARRAYS_H
#define PL_IO_VTK_VTK_ARRAYS_H

#include "io/view/view.h"
#include "io/view/writer.h"

typedef enum vtk_out_type {
    VTK_OUT_U8,
    VTK_OUT_I32,
    VTK_OUT_I64,
    VTK_OUT_F32,
    VTK_OUT_F64
} vtk_out_type;

/** Meaning of the values of an array. */
typedef enum vtk_out_values {
    VTK_OUT_COORDINATES, /* of nodes, as FIXED and NODE_NUMBERS */
    VTK_OUT_FIXED,
    VTK_OUT_NODE_NUMBERS,
    VTK_OUT_RADIUS_RATIOS, /* of cells, as all that follow: view->options */
    VTK_OUT_ASPECT_RATIOS,
    VTK_OUT_SCALED_JACOBIANS,
    VTK_OUT_JACOBIAN_RATIOS,
    VTK_OUT_EDGE_RATIOS,
    VTK_OUT_STATES,
    VTK_OUT_CURVED,
    VTK_OUT_NODES,         /* of all cells, one cell after another, */
    VTK_OUT_COUNTED_NODES, /* or led by how many a cell has */
    VTK_OUT_ENDS,          /* where the nodes of each cell end */
    VTK_OUT_TYPES,         /* VTK's */
    VTK_OUT_REGIONS,
    VTK_OUT_GROUPS,
    VTK_OUT_CELL_NUMBERS,
    VTK_OUT_FIELD /* of the file */
} vtk_out_values;

typedef struct vtk_out_array {
    const char *name;
    vtk_out_values values;
    vtk_out_type type;
    int64_t n;                  /* nodes or cells; NODES, COUNTED_NODES: values */
    int width;                  /* numbers of each */
    const io_view_field *field; /* of FIELD */
    const int32_t *number;      /* of GROUPS: [n_entities] or NULL */
} vtk_out_array;

/** All arrays of a view. */
typedef struct vtk_out_arrays {
    vtk_out_array points, connectivity, offsets, types;
    vtk_out_array counted,
        wide_types; /* as legacy VTK has them: cells led by their number of nodes;
                                          types of 32 bits */
    vtk_out_array *point_data, *cell_data; /* [n_point_data], [n_cell_data] owned */
    int n_point_data, n_cell_data;
} vtk_out_arrays;

/** Find the arrays of a view, which must stay while they are used, and what they lack. To be ended in any
 *  case. */
int vtk_arrays_begin(const io_view *view, io_losses *losses, vtk_out_arrays *arrays,
                     planish_error *error);
/** Return whether there is an array of groups, or can be. */
int vtk_arrays_can_have_groups(const vtk_out_arrays *arrays);
/** Let cells have these numbers [n_entities] of groups, which must stay. */
void vtk_arrays_set_groups(const io_view *view, const int32_t *number, vtk_out_arrays *arrays);

/** Release the lists of arrays. */
void vtk_arrays_end(vtk_out_arrays *arrays);

/** Return the bytes of an array. */
int64_t vtk_array_bytes(const vtk_out_array *array);

/** Put an array's values, in the other byte order if swapped. */
void vtk_put_array(io_writer *writer, const io_view *view, const vtk_out_array *array, int swapped);

#endif
