/* vtk_write: a mesh as a legacy VTK file, or (vtu_write.c) as VTK's XML. */
#ifndef PL_IO_VTK_VTK_WRITE_H
#define PL_IO_VTK_VTK_WRITE_H

#include "io/core/format.h"

/** Write a file: io_target.write. */
int vtk_write(const struct io_view *view, pl_output *output, struct io_losses *losses,
              planish_error *error);
int vtu_write(const struct io_view *view, pl_output *output, struct io_losses *losses,
              planish_error *error);

#endif
