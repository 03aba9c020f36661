/* Any bytes as a file of the format that the build names: FUZZ_FORMAT is its io_format. */
#ifdef FUZZ_IN_HDF5
#include "fuzz_hdf5.h" /* first: it asks the system for dladdr */

#include "io/core/format.h"

FUZZ_HDF5(FUZZ_FORMAT)
#else
#include "fuzz_reader.h"

FUZZ_READER(FUZZ_FORMAT)
#endif
