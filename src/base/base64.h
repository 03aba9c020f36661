/* base64: text of bytes, in groups of four characters for three bytes. */
#ifndef PL_BASE_BASE64_H
#define PL_BASE_BASE64_H

#include <stdint.h>

/** Number of characters that n bytes become. */
int64_t pl_base64_length(int64_t n);

/** Write the text of n bytes at data to out, without an end of a string; returns its length. */
int64_t pl_base64_write(const char *data, int64_t n, char *out);

#endif
