/* ucd: AVS UCD, a format that is told from others but not read. */
#ifndef PL_IO_ABAQUS_UCD_H
#define PL_IO_ABAQUS_UCD_H

#include <stdint.h>

/** Return whether data [size] are a text file of AVS UCD. */
int io_is_ucd(const char *data, int64_t size);

#endif
