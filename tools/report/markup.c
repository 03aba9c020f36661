/* markup: text that grows, for pages and the drawings in them. */
#include "report/markup.h"

#include "io/base64.h"

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

static const char *escape_of(unsigned char c) {
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
        return c < ' ' || c == 127 ? "\xEF\xBF\xBD" : NULL;
    }
}

void pl_markup_put_text(pl_markup *markup, const char *text) {
    for (const char *c = text; *c; c++) {
        const char *escape = escape_of((unsigned char)*c);
        if (escape)
            pl_markup_put_bytes(markup, escape, strlen(escape));
        else
            pl_markup_put_bytes(markup, c, 1);
    }
}

void pl_markup_put_base64(pl_markup *markup, const void *bytes, int64_t n) {
    const int64_t length = io_base64_length(n);
    if (!reserve(markup, (size_t)length))
        return;
    io_base64_write(bytes, n, markup->text + markup->length);
    markup->length += (size_t)length;
}

void pl_markup_put_real(pl_markup *markup, double value) {
    if (isfinite(value))
        pl_markup_put(markup, "%.4g", value);
    else
        pl_markup_put(markup, "\xE2\x80\x93");
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
