/* ucd: AVS UCD, a format that is told from others but not read. */
#ifndef PL_IO_ABAQUS_UCD_H
#define PL_IO_ABAQUS_UCD_H

#include <stdint.h>

/** Whether data [size] are a text file of AVS UCD: 1 or 0. */
int io_is_ucd(const char *data, int64_t size);

#endif
