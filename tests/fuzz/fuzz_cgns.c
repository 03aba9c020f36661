/* Any bytes as a CGNS file. */
#include "fuzz_hdf5.h"

FUZZ_HDF5(io_format_cgns)
