/* gmsh_write: a mesh as a file of Gmsh's. */
#ifndef PL_IO_GMSH_GMSH_WRITE_H
#define PL_IO_GMSH_GMSH_WRITE_H

#include "io/core/format.h"

/** MSH 4.1 and 2.2, text. */
extern const io_target gmsh_targets[];

#endif
