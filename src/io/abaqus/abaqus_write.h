/* abaqus_write: a mesh as an Abaqus input file. */
#ifndef PL_IO_ABAQUS_ABAQUS_WRITE_H
#define PL_IO_ABAQUS_ABAQUS_WRITE_H

#include "io/core/format.h"

/** Orders of nodes that are not VTK's. */
extern const io_node_order abaqus_node_orders[];

/** Formats that the writer has; a row without a name ends them. */
extern const io_target abaqus_targets[];

#endif
