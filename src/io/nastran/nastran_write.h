/* nastran_write: a mesh as bulk data of Nastran. */
#ifndef PL_IO_NASTRAN_NASTRAN_WRITE_H
#define PL_IO_NASTRAN_NASTRAN_WRITE_H

#include "io/core/format.h"

/** Orders of nodes that are not VTK's. */
extern const io_node_order nastran_node_orders[];

/** Formats that the writer has; a row without a name ends them. */
extern const io_target nastran_targets[];

#endif
