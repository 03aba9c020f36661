/* Any bytes as a Gmsh mesh. */
#include "fuzz_reader.h"

FUZZ_READER(io_format_gmsh)
