/* markup: text that grows, for pages and the drawings in them. */
#include "report/markup.h"

#include "terminal/text.h"

#include "base/base64.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FIRST_CAPACITY = 1 << 16 };

/** Room for size more bytes and a '\0'; 0 without memory. */
static int reserve(pl_markup *markup, size_t size) {
    const size_t wanted = markup->length + size + 1;
    if (markup->failed || wanted < size)
        return !(markup->failed = 1);
    if (wanted <= markup->capacity)
        return 1;
    size_t capacity = markup->capacity ? markup->capacity : FIRST_CAPACITY;
    while (capacity < wanted)
        capacity += capacity / 2;
    char *text = realloc(markup->text, capacity);
    if (!text)
        return !(markup->failed = 1);
    markup->text = text;
    markup->capacity = capacity;
    return 1;
}

void pl_markup_put(pl_markup *markup, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    const int size = vsnprintf(NULL, 0, format, arguments);
    va_end(arguments);
    if (size < 0 || !reserve(markup, (size_t)size))
        return;
    va_start(arguments, format);
    vsnprintf(markup->text + markup->length, (size_t)size + 1, format, arguments);
    va_end(arguments);
    markup->length += (size_t)size;
}

void pl_markup_put_bytes(pl_markup *markup, const char *bytes, size_t size) {
    if (!reserve(markup, size))
        return;
    memcpy(markup->text + markup->length, bytes, size);
    markup->length += size;
}

static const char *escape_of(char c) {
    switch (c) {
    case '<':
        return "&lt;";
    case '>':
        return "&gt;";
    case '&':
        return "&amp;";
    case '"':
        return "&quot;";
    case '\'':
        return "&#39;";
    default:
        return NULL;
    }
}

/** Whether the character of length bytes at text, or what is none (length 0), is not to be shown:
 *  controls up to U+009F, and U+202A .. U+202E, U+2066 .. U+2069, which turn what follows. */
static int is_unfit(const char *text, int length) {
    const unsigned char *c = (const unsigned char *)text;
    if (length == 3 && c[0] == 0xE2)
        return (c[1] == 0x80 && c[2] >= 0xAA && c[2] <= 0xAE) ||
               (c[1] == 0x81 && c[2] >= 0xA6 && c[2] <= 0xA9);
    return length == 0 || c[0] < ' ' || c[0] == 127 || (c[0] == 0xC2 && c[1] < 0xA0);
}

void pl_markup_put_text(pl_markup *markup, const char *text) {
    while (*text) {
        const int length = pl_utf8_length(text);
        const char *escape = escape_of(*text);
        if (escape)
            pl_markup_put(markup, "%s", escape);
        else if (is_unfit(text, length))
            pl_markup_put(markup, PL_UTF8_REPLACEMENT);
        else
            pl_markup_put_bytes(markup, text, (size_t)length);
        text += length ? length : 1;
    }
}

void pl_markup_put_base64(pl_markup *markup, const void *bytes, int64_t n) {
    const int64_t length = pl_base64_length(n);
    if (!reserve(markup, (size_t)length))
        return;
    pl_base64_write(bytes, n, markup->text + markup->length);
    markup->length += (size_t)length;
}

void pl_markup_put_real(pl_markup *markup, double value) {
    const double long_from = 9999.5,
                 long_to = 1e7; /* longer in digits than in powers, but clearer */
    char text[32];
    if (value == 0 || !isfinite(value)) {
        pl_markup_put_digits(markup, value, 1);
    } else if (fabs(value) >= long_from && fabs(value) < long_to) {
        pl_markup_put(markup, value < 0 ? "-" : "");
        pl_markup_put_count(markup, (int64_t)llround(fabs(value)));
    } else {
        const int length = snprintf(text, sizeof text, "%#.4g", value);
        text[length - (text[length - 1] == '.')] = '\0';
        pl_markup_put(markup, "%s", text);
    }
}

void pl_markup_put_percent(pl_markup *markup, double percent) {
    const double long_from = 99.95; /* no point behind three digits */
    if (isfinite(percent))
        pl_markup_put(markup, fabs(percent) < long_from ? "%+#.3g&#8239;%%" : "%+.0f&#8239;%%",
                      percent);
    else
        pl_markup_put_digits(markup, percent, 1);
}

void pl_markup_put_angle(pl_markup *markup, double degrees) {
    const double wide = 179, hundredths = 100;
    if (degrees > wide && degrees < 180)
        pl_markup_put(markup, "%.2f", floor(hundredths * degrees) / hundredths);
    else
        pl_markup_put_real(markup, degrees);
}

void pl_markup_put_digits(pl_markup *markup, double value, int digits) {
    if (isfinite(value))
        pl_markup_put(markup, "%.*g", digits, value);
    else
        pl_markup_put(markup, "\xE2\x80\x93");
}

void pl_markup_put_number_of(pl_markup *markup, int64_t n, const char *one, const char *several) {
    pl_markup_put_count(markup, n);
    pl_markup_put(markup, " %s", n == 1 ? one : several);
}

void pl_markup_put_count(pl_markup *markup, int64_t value) {
    char digits[32];
    snprintf(digits, sizeof digits, "%" PRId64, value < 0 ? 0 : value);
    for (const char *c = digits; *c; c++) {
        pl_markup_put_bytes(markup, c, 1);
        if (c[1] && strlen(c + 1) % 3 == 0)
            pl_markup_put(markup, "\xE2\x80\xAF"); /* narrow, and no place to break the line */
    }
}

void pl_markup_free(pl_markup *markup) {
    free(markup->text);
    *markup = (pl_markup){0};
}
