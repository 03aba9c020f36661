/* Any bytes as a VTK XML mesh. */
#include "fuzz_reader.h"

FUZZ_READER(io_format_vtu)
