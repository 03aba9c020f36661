/* Any bytes as a CGNS file. */
#include "io/core/format.h"
#include "fuzz_hdf5.h"

FUZZ_HDF5(io_format_cgns)
