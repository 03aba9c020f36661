/* Any bytes as a file of the format that the build names: FUZZ_FORMAT is its io_format. */
#include "fuzz_reader.h"

FUZZ_READER(FUZZ_FORMAT)
