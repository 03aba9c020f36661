/* Any bytes as an OFF file. */
#include "fuzz_reader.h"

FUZZ_READER(io_format_off)
