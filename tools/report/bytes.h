/* bytes: numbers as bytes of a picture, the lowest byte first. */
#ifndef PL_REPORT_BYTES_H
#define PL_REPORT_BYTES_H

#include <stdint.h>

/** Write an integer of size bytes, and a float of 4; a large value becomes a float that is finite. */
void pl_bytes_put(uint32_t value, int size, uint8_t *out);
void pl_bytes_put_float(double value, uint8_t *out);

/** Read them. */
uint32_t pl_bytes_get(const uint8_t *from, int size);
double pl_bytes_get_float(const uint8_t *from);

#endif
