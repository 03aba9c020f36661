/* Any bytes as a Medit mesh. */
#include "fuzz_reader.h"

FUZZ_READER(io_format_medit)
