/* Any bytes as an Abaqus input file. */
#include "fuzz_reader.h"

FUZZ_READER(io_format_abaqus)
