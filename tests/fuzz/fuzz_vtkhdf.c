/* Any bytes as a VTKHDF file. */
#include "fuzz_hdf5.h" /* first: it asks the system for dladdr */

#include "io/core/format.h"

FUZZ_HDF5(io_format_vtkhdf)
