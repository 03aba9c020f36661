/* Any bytes as a VTKHDF file. */
#include "io/core/format.h"
#include "fuzz_hdf5.h"

FUZZ_HDF5(io_format_vtkhdf)
