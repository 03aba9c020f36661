/* xdmf: declarations that the parts of the reader of XDMF files share.
 *
 *   xdmf_read_nodes, xdmf_count_nodes   points (xdmf_nodes.c)
 *   xdmf_read_cells, xdmf_count_cells   elements and sets (xdmf_cells.c)
 *   xdmf_read_attributes, _read_data    data (xdmf_data.c)
 */
#ifndef PL_IO_XDMF_XDMF_H
#define PL_IO_XDMF_XDMF_H

#include "io/xdmf/xdmf_grids.h"

/** Make nodes of the points of all geometries. Where they stand in another file, that becomes the
 *  input of the model. */
int xdmf_read_nodes(xdmf_reader *reader, xdmf_mesh *mesh);

/** Read the elements of all pieces, and the sets of nodes, cells and faces, which become groups of
 *  nodes. */
int xdmf_read_cells(xdmf_reader *reader, xdmf_mesh *mesh);

/** Find the numbers of nodes of all geometries: *n in all. */
int xdmf_count_nodes(xdmf_reader *reader, xdmf_mesh *mesh, int64_t *n);

/** Find the numbers of cells of all pieces, of a mesh that has been read before. */
int xdmf_count_cells(xdmf_reader *reader, xdmf_mesh *mesh);

/** Hold the nodes that an attribute called `fixed` marks. Read the attributes that may be regions,
 *  and note the places of all attributes. */
int xdmf_read_attributes(xdmf_reader *reader, xdmf_mesh *mesh);

/** Read the values of an attribute: io_format.read_data. */
int xdmf_read_data(io_model *model, const io_data *data, double *values, planish_error *error);

#endif
