/* exodus_write: a mesh as an Exodus II file. */
#ifndef PL_IO_EXODUS_EXODUS_WRITE_H
#define PL_IO_EXODUS_EXODUS_WRITE_H

#include "io/core/format.h"

/** Exodus II in classic netCDF. */
extern const io_target exodus_targets[];

#endif
