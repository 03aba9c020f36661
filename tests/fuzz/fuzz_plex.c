/* Any bytes as a DMPlex file. */
#include "fuzz_hdf5.h"

FUZZ_HDF5(io_format_plex)
