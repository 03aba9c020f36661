/* base64: text of bytes, in groups of four characters for three bytes. */
#include "base/base64.h"

static const char alphabet[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

int64_t pl_base64_length(int64_t n) {
    return (n + 2) / 3 * 4;
}

int64_t pl_base64_write(const char *data, int64_t n, char *out) {
    const unsigned char *bytes = (const unsigned char *)data;
    char *to = out;
    for (int64_t i = 0; i < n; i += 3, to += 4) {
        const unsigned char first = bytes[i];
        const unsigned char second = i + 1 < n ? bytes[i + 1] : 0;
        const unsigned char third = i + 2 < n ? bytes[i + 2] : 0;
        to[0] = alphabet[first >> 2];
        to[1] = alphabet[(first << 4 | second >> 4) & 63];
        to[2] = i + 1 < n ? alphabet[(second << 2 | third >> 6) & 63] : '=';
        to[3] = i + 2 < n ? alphabet[third & 63] : '=';
    }
    return to - out;
}
