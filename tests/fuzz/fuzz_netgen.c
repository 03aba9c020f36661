/* Any bytes as a mesh of Netgen's. */
#include "fuzz_reader.h"

FUZZ_READER(io_format_netgen)
