/* bytes: numbers as bytes of a picture. */
#include "report/bytes.h"

#include <math.h>
#include <string.h>

void pl_bytes_put(uint32_t value, int size, uint8_t *out) {
    for (int i = 0; i < size; i++)
        out[i] = (uint8_t)(value >> (8 * i));
}

void pl_bytes_put_float(double value, uint8_t *out) {
    const double largest = 1e38; /* that a float holds */
    const float rounded = (float)fmin(value, largest);
    uint32_t bits;
    memcpy(&bits, &rounded, sizeof bits);
    pl_bytes_put(bits, 4, out);
}

uint32_t pl_bytes_get(const uint8_t *from, int size) {
    uint32_t value = 0;
    for (int i = 0; i < size; i++)
        value |= (uint32_t)from[i] << (8 * i);
    return value;
}

double pl_bytes_get_float(const uint8_t *from) {
    const uint32_t bits = pl_bytes_get(from, 4);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}
