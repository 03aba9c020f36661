/* Any bytes as a VTK legacy mesh. */
#include "fuzz_reader.h"

FUZZ_READER(io_format_vtk)
