/* Any bytes as Nastran bulk data. */
#include "fuzz_reader.h"

FUZZ_READER(io_format_nastran)
