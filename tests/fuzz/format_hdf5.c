/* Any bytes as a file of the format in HDF5 that the build names: FUZZ_FORMAT is its io_format. */
#include "fuzz_hdf5.h" /* first: it asks the system for dladdr */

#include "io/core/format.h"

FUZZ_HDF5(FUZZ_FORMAT)
