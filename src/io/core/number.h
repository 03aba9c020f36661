/* number: numbers from text and back, independent of the locale, exact.
 *
 *   io_parse_real, io_parse_integer      read a number
 *   io_format_real                       write the shortest text
 *   io_format_field, io_round_to_field   write a field of few characters; its value
 *
 * Implemented in number.cpp and field.cpp with <charconv> of the C++ standard library (correctly
 * rounded reading, shortest text that restores the value); the only C++ of the project.
 */
#ifndef PL_IO_CORE_NUMBER_H
#define PL_IO_CORE_NUMBER_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Read a real number at *at (no white space before it), advance *at behind it. "+1", "1.", ".5",
 *  "1d-3" (Fortran) are numbers; "nan" and "inf" are read as such. 0, or -1 if there is none (then
 *  *at is unchanged). Values too large give infinity, too small ones 0 or the nearest subnormal. */
int io_parse_real(const char **at, const char *end, double *value);

/** Read a decimal integer with an optional sign as io_parse_real does; -1 also if it does not fit.
 */
int io_parse_integer(const char **at, const char *end, int64_t *value);

enum { IO_REAL_SIZE = 32 };

/** Write the shortest text that reads back as value (is_float: as the float); return its length, at
 *  most IO_REAL_SIZE; no terminator. */
int io_format_real(char *text, double value, int is_float);

/** Exponents of numbers in fields. */
typedef enum io_exponent {
    IO_EXPONENT_NEEDED,  /* where the number is nearer with one */
    IO_EXPONENT_IMPLIED, /* likewise, behind the mantissa without an e (Nastran's 1.5-3) */
    IO_EXPONENT_ALWAYS   /* a Fortran format with a scale factor (1PE13.5) takes 1.5 as 0.15 */
} io_exponent;

/** Write the text of at most width characters (8 or more, less than IO_REAL_SIZE) that is nearest
 *  to value, with a point in it. Return its length, or 0: value is not finite. -0 is written as 0. */
int io_format_field(char *text, double value, int width, io_exponent kind);

/** Return the value of that text: the nearest of the numbers that a field can hold. value itself if
 *  it is not finite. Much faster than to write and to read it. */
double io_round_to_field(double value, int width, io_exponent kind);

#ifdef __cplusplus
}
#endif
#endif
