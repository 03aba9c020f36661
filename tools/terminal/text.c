/* text: names and sentences in lines of a given width. */
#include "terminal/text.h"

#include <stdint.h>
#include <string.h>

/** A character of a text. */
typedef struct character {
    int length; /* bytes */
    int columns;
    int is_control;
} character;

/** A range of characters. */
typedef struct range {
    uint32_t first, last;
} range;

/* Characters that take no column of their own: accents of what they follow, and joiners. */
static const range narrow[] = {
    {0x0300, 0x036F}, {0x200B, 0x200F}, {0x20D0, 0x20FF}, {0xFE00, 0xFE0F}, {0xFE20, 0xFE2F},
};

/* Characters that take two (Unicode's EastAsianWidth W and F, in blocks). */
static const range wide[] = {
    {0x1100, 0x115F},   {0x2E80, 0x303E},   {0x3041, 0x4DBF},   {0x4E00, 0xA4CF},
    {0xA960, 0xA97F},   {0xAC00, 0xD7A3},   {0xF900, 0xFAFF},   {0xFE30, 0xFE6F},
    {0xFF01, 0xFF60},   {0xFFE0, 0xFFE6},   {0x16FE0, 0x18DFF}, {0x1AFF0, 0x1B2FF},
    {0x1F300, 0x1F64F}, {0x1F680, 0x1F6FF}, {0x1F900, 0x1F9FF}, {0x1FA70, 0x1FAFF},
    {0x20000, 0x3FFFD},
};

/* Characters that a terminal obeys, or that change the direction of what follows: names may not. */
static const range controls[] = {
    {0x00, 0x1F},     {0x7F, 0x9F},     {0x061C, 0x061C},
    {0x200E, 0x200F}, {0x2028, 0x202E}, {0x2066, 0x2069},
};

static int is_among(const range *ranges, size_t n, uint32_t code) {
    for (size_t i = 0; i < n; i++)
        if (code >= ranges[i].first && code <= ranges[i].last)
            return 1;
    return 0;
}

/** The code that text begins with, and its bytes in *length; a byte outside of UTF-8 is
 *  taken for one of Latin-1. */
static uint32_t decode(const char *text, int *length) {
    static const uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
    const unsigned char *byte = (const unsigned char *)text;
    const int n = byte[0] < 0xC2 || byte[0] > 0xF4 ? 1
                  : byte[0] < 0xE0                 ? 2
                  : byte[0] < 0xF0                 ? 3
                                                   : 4;
    uint32_t code = n > 1 ? byte[0] & (0x7Fu >> n) : byte[0];
    *length = n;
    for (int i = 1; i < n && *length == n; i++) {
        code = code << 6 | (byte[i] & 0x3Fu);
        if ((byte[i] & 0xC0) != 0x80) /* also where the text ends */
            *length = 1;
    }
    if (code < least[n] || code > 0x10FFFF || (code >= 0xD800 && code <= 0xDFFF))
        *length = 1;
    return *length == n ? code : byte[0];
}

static character character_at(const char *text) {
    character c;
    const uint32_t code = decode(text, &c.length);
    c.is_control = is_among(controls, sizeof controls / sizeof *controls, code);
    c.columns = c.is_control || c.length == 1                            ? 1
                : is_among(narrow, sizeof narrow / sizeof *narrow, code) ? 0
                : is_among(wide, sizeof wide / sizeof *wide, code)       ? 2
                                                                         : 1;
    return c;
}

int pl_text_control(const char *text, uint32_t *code) {
    const character c = character_at(text);
    int length;
    *code = decode(text, &length);
    return c.is_control ? length : 0;
}

int pl_text_columns(const char *text) {
    int columns = 0;
    for (const char *c = text; *c; c += character_at(c).length)
        columns += character_at(c).columns;
    return columns;
}

void pl_text_clean(char *text) {
    char *to = text;
    for (const char *from = text; *from;) {
        const character c = character_at(from);
        if (c.is_control)
            *to++ = '?';
        else
            for (int i = 0; i < c.length; i++)
                *to++ = from[i];
        from += c.length;
    }
    *to = '\0';
}

void pl_text_put(FILE *stream, const char *text) {
    for (const char *from = text; *from;) {
        const character c = character_at(from);
        fwrite(c.is_control ? "?" : from, 1, c.is_control ? 1 : (size_t)c.length, stream);
        from += c.length;
    }
}

static int has_controls(const char *text) {
    for (const char *c = text; *c; c += character_at(c).length)
        if (character_at(c).is_control)
            return 1;
    return 0;
}

void pl_text_put_word(FILE *stream, const char *text) {
    const size_t plain = strspn(text, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                      "0123456789._/+-");
    const int has_escapes = has_controls(text);
    if (plain > 0 && text[plain] == '\0') {
        fputs(text, stream);
        return;
    }
    fputs(has_escapes ? "$'" : "'", stream);
    for (const char *from = text; *from;) {
        const character c = character_at(from);
        for (int i = 0; i < c.length; i++)
            if (c.is_control)
                fprintf(stream, "\\%03o", (unsigned)(unsigned char)from[i]);
            else if (from[i] == '\'' || (from[i] == '\\' && has_escapes))
                fputs(from[i] == '\\' ? "\\\\" : has_escapes ? "\\'" : "'\\''", stream);
            else
                fputc(from[i], stream);
        from += c.length;
    }
    fputc('\'', stream);
}

/** Append what of name is in the columns first .. last - 1 to text [size]; a character that is only
 *  half in them is left out. */
static void append(const char *name, int first, int last, char *text, size_t size) {
    size_t used = strlen(text);
    int column = 0;
    for (const char *from = name; *from;) {
        const character c = character_at(from);
        const size_t length = c.is_control ? 1 : (size_t)c.length;
        const int begin = column - (c.columns == 0); /* an accent goes with what is before it */
        column += c.columns;
        if (begin >= first && column <= last && used + length < size) {
            memcpy(text + used, c.is_control ? "?" : from, length);
            used += length;
        }
        from += c.length;
    }
    text[used] = '\0';
}

const char *pl_text_fit(const char *name, int columns, char *text, size_t size) {
    static const char dots[] = "...";
    const int length = pl_text_columns(name), n_dots = (int)strlen(dots);
    text[0] = '\0';
    if (length <= columns || columns <= n_dots) {
        append(name, 0, columns, text, size);
        return text;
    }
    const int head = (columns - n_dots) / 2, tail = columns - n_dots - head; /* the end says more */
    append(name, 0, head, text, size);
    append(dots, 0, n_dots, text, size);
    append(name, length - tail, length, text, size);
    return text;
}

int pl_utf8_length(const char *text) {
    const unsigned char *byte = (const unsigned char *)text;
    const unsigned char lead = byte[0];
    const int length = lead < 0x80 ? 1 : lead < 0xC2 ? 0 : lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
    if (lead > 0xF4)
        return 0;
    for (int i = 1; i < length; i++)
        if ((byte[i] & 0xC0) != 0x80)
            return 0;
    if (length < 3)
        return length;
    const int overlong = (lead == 0xE0 && byte[1] < 0xA0) || (lead == 0xF0 && byte[1] < 0x90);
    const int no_character = (lead == 0xED && byte[1] > 0x9F) || (lead == 0xF4 && byte[1] > 0x8F);
    return overlong || no_character ? 0 : length;
}
