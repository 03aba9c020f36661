/* medit_write: a mesh as a text of Medit's. */
#ifndef PL_IO_MEDIT_MEDIT_WRITE_H
#define PL_IO_MEDIT_MEDIT_WRITE_H

#include "io/core/format.h"

/** Orders of nodes that are not VTK's. */
extern const io_node_order medit_usual_order[];

/** Formats that the writer has; a row without a name ends them. */
extern const io_target medit_targets[];

#endif
