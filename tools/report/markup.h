/* markup: text that grows, for pages and the drawings in them.
 *
 *     pl_markup_put, _put_bytes, _put_base64             text as it is
 *     pl_markup_put_text                                 text that is escaped
 *     pl_markup_put_real, _digits, _percent, _angle, _count, _number_of    numbers as people read them
 */
#ifndef PL_REPORT_MARKUP_H
#define PL_REPORT_MARKUP_H

#include "base/printf.h"

#include <stddef.h>
#include <stdint.h>

/** A text under construction. Once memory is short it stays as it is, and failed remembers. */
typedef struct pl_markup {
    char *text; /* [length], owned */
    size_t length, capacity;
    int failed;
} pl_markup;

/** Add text as printf does; nothing is escaped. */
void pl_markup_put(pl_markup *markup, const char *format, ...) PL_PRINTF(2, 3);

/** Add size bytes as they are. */
void pl_markup_put_bytes(pl_markup *markup, const char *bytes, size_t size);

/** Add text so that it reads as itself in HTML, in attributes as well: <, >, &, " and ' are
 *  escaped; bytes that are not UTF-8, control characters and those that turn the direction of writing
 * become U+FFFD. */
void pl_markup_put_text(pl_markup *markup, const char *text);

/** Add n bytes as base64. */
void pl_markup_put_base64(pl_markup *markup, const void *bytes, int64_t n);

/** Add a number as people read it: four significant digits, zeros too, or those of a number from 10^4 to
 *  10^7 before its point, as pl_markup_put_count; an en dash where it is not finite. */
void pl_markup_put_real(pl_markup *markup, double value);

/** Add a number with up to that many significant digits, whatever its size. */
void pl_markup_put_digits(pl_markup *markup, double value, int digits);

/** Add how many there are of something, and a word for that: one for 1, else several. */
void pl_markup_put_number_of(pl_markup *markup, int64_t n, const char *one, const char *several);

/** Add a change in percent, with its sign and three significant digits. */
void pl_markup_put_percent(pl_markup *markup, double percent);

/** Add an angle in degrees; one of almost 180 is rounded down, as 180 would be flat. */
void pl_markup_put_angle(pl_markup *markup, double degrees);

/** Add an integer with thin spaces between groups of three digits; a negative one as 0. */
void pl_markup_put_count(pl_markup *markup, int64_t value);

void pl_markup_free(pl_markup *markup);

#endif
