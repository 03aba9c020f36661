/* text: walk the bytes of an ASCII mesh file. */
#include "io/core/text.h"

#include "io/core/number.h"

#include <string.h>

io_cursor io_begin_text(const char *data, int64_t size) {
    static const char mark[] = "\xef\xbb\xbf";
    const int64_t length = sizeof mark - 1;
    const int is_marked = size >= length && memcmp(data, mark, (size_t)length) == 0;
    return (io_cursor){data + (is_marked ? length : 0), data + size};
}

void io_skip_space(io_cursor *cursor) {
    while (cursor->at < cursor->end && io_is_space(*cursor->at))
        cursor->at++;
}

void io_skip_space_comments(io_cursor *cursor, char mark) {
    io_skip_space(cursor);
    while (cursor->at < cursor->end && *cursor->at == mark) {
        io_skip_line(cursor);
        io_skip_space(cursor);
    }
}

void io_skip_line(io_cursor *cursor) {
    while (cursor->at < cursor->end && *cursor->at != '\n' && *cursor->at != '\r')
        cursor->at++;
    int carriage_return = cursor->at < cursor->end && *cursor->at == '\r';
    cursor->at += carriage_return;
    if (cursor->at < cursor->end && *cursor->at == '\n')
        cursor->at++;
}

io_slice io_next_line(io_cursor *cursor) {
    /* By stretches: in a file whose lines end in \r alone, \n is looked for in vain. */
    enum { STRETCH = 256 };
    io_slice line = {cursor->at, NULL};
    while (!line.end && cursor->at < cursor->end) {
        const int64_t left = cursor->end - cursor->at, length = left < STRETCH ? left : STRETCH;
        const char *feed = memchr(cursor->at, '\n', (size_t)length);
        const char *carriage =
            memchr(cursor->at, '\r', (size_t)(feed ? feed - cursor->at : length));
        line.end = carriage ? carriage : feed;
        cursor->at = line.end ? line.end : cursor->at + length;
    }
    line.end = cursor->at;
    io_skip_line(cursor);
    return line;
}

io_slice io_next_word(io_cursor *cursor) {
    io_skip_space(cursor);
    io_slice word = {cursor->at, NULL};
    while (cursor->at < cursor->end && !io_is_space(*cursor->at))
        cursor->at++;
    word.end = cursor->at;
    return word;
}

io_slice io_first_word(const char *data, int64_t size) {
    io_cursor cursor = io_begin_text(data, size);
    io_skip_space_comments(&cursor, '#');
    return io_next_word(&cursor);
}

int io_slice_is(io_slice s, const char *name, int fold) {
    const int64_t length = io_slice_length(s);
    for (int64_t i = 0; i < length; i++) {
        const char c = s.begin[i], d = name[i];
        if (d == '\0' || (fold ? io_upper(c) != io_upper(d) : c != d))
            return 0;
    }
    return name[length] == '\0';
}

int io_slice_integer(io_slice s, int64_t *value) {
    io_cursor cursor = {s.begin, s.end};
    return io_integer(&cursor, value) || cursor.at != s.end ? -1 : 0;
}

int io_slice_real(io_slice s, int implied_exponent, double *value) {
    enum { LONGEST = 64 };
    const char *at = s.begin;
    if (io_parse_real(&at, s.end, value) == 0 && at == s.end)
        return 0;
    if (!implied_exponent || io_slice_length(s) > LONGEST)
        return -1;
    char copy[LONGEST + 1];
    int n = 0, marks = 0;
    for (const char *c = s.begin; c < s.end; c++) {
        const int is_sign = *c == '+' || *c == '-';
        if (is_sign && c > s.begin && strchr("0123456789.", c[-1]) && marks++ == 0)
            copy[n++] = 'e';
        copy[n++] = *c;
    }
    at = copy;
    return marks == 1 && io_parse_real(&at, copy + n, value) == 0 && at == copy + n ? 0 : -1;
}

/** Return whether a number that ends at at is whole: white space or the end must follow. */
static int ends_here(const io_cursor *cursor, const char *at) {
    return at == cursor->end || io_is_space(*at);
}

int io_integer(io_cursor *cursor, int64_t *value) {
    io_skip_space(cursor);
    const char *at = cursor->at;
    if (io_parse_integer(&at, cursor->end, value) || !ends_here(cursor, at))
        return -1;
    cursor->at = at;
    return 0;
}

int io_real(io_cursor *cursor, double *value) {
    io_skip_space(cursor);
    const char *at = cursor->at;
    if (io_parse_real(&at, cursor->end, value) || !ends_here(cursor, at))
        return -1;
    cursor->at = at;
    return 0;
}

const char *io_find_line(const char *from, const char *end, const char *name) {
    size_t length = strlen(name);
    while (from < end) {
        if ((size_t)(end - from) >= length && memcmp(from, name, length) == 0)
            return from;
        const char *next = memchr(from, '\n', (size_t)(end - from));
        if (!next)
            return end;
        from = next + 1;
    }
    return end;
}

void io_skip_numbers(io_cursor *cursor) {
    enum { BLOCK = 64 };
    while (cursor->at < cursor->end) {
        const char *begin = cursor->at;
        /* Blocks of nothing but numbers and white space first. */
        for (int other = 0; cursor->end - cursor->at >= BLOCK && !other;) {
            for (int i = 0; i < BLOCK; i++) /* also bytes that are negative where char is signed */
                other |= ((unsigned char)cursor->at[i] >= 'A') | (cursor->at[i] == '#');
            cursor->at += other ? 0 : BLOCK;
        }
        while (cursor->at > begin && cursor->at < cursor->end && !io_is_space(*cursor->at) &&
               !io_is_space(cursor->at[-1]))
            cursor->at++; /* the rest of a number */
        io_skip_space_comments(cursor, '#');
        const io_cursor before = *cursor;
        const io_slice word = io_next_word(cursor);
        const char first = word.begin < word.end ? io_upper(*word.begin) : '0';
        if (first >= 'A' && first <= 'Z' && !io_slice_is(word, "nan", 1) &&
            !io_slice_is(word, "inf", 1)) {
            *cursor = before;
            return;
        }
    }
}
