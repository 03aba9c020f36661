/* text: walk the bytes of an ASCII mesh file. */
#include "io/core/text.h"

#include "io/core/number.h"

#include <string.h>

static int is_space(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f';
}

static char lower(char c) {
    return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c;
}

io_cursor io_begin_text(const char *data, int64_t size) {
    static const char mark[] = "\xef\xbb\xbf";
    const int64_t length = sizeof mark - 1;
    const int is_marked = size >= length && memcmp(data, mark, (size_t)length) == 0;
    return (io_cursor){data + (is_marked ? length : 0), data + size};
}

void io_skip_space(io_cursor *cursor) {
    while (cursor->at < cursor->end && is_space(*cursor->at))
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

/** The first line end of length bytes at at, or NULL. */
static const char *find_line_end(const char *at, int64_t length) {
    const char *feed = memchr(at, '\n', (size_t)length);
    const char *carriage = memchr(at, '\r', (size_t)(feed ? feed - at : length));
    return carriage ? carriage : feed;
}

const char *io_line(io_cursor *cursor, const char **end) {
    /* By stretches: in a file whose lines end in \r alone, \n is looked for in vain. */
    enum { STRETCH = 256 };
    const char *line = cursor->at, *found = NULL;
    while (!found && cursor->at < cursor->end) {
        const int64_t left = cursor->end - cursor->at, length = left < STRETCH ? left : STRETCH;
        found = find_line_end(cursor->at, length);
        cursor->at = found ? found : cursor->at + length;
    }
    *end = cursor->at;
    io_skip_line(cursor);
    return line;
}

io_slice io_next_line(io_cursor *cursor) {
    io_slice line;
    line.begin = io_line(cursor, &line.end);
    return line;
}

io_slice io_next_word(io_cursor *cursor) {
    int64_t length;
    const char *word = io_word(cursor, &length);
    return (io_slice){word, word + length};
}

io_slice io_first_word(const char *data, int64_t size) {
    io_cursor cursor = io_begin_text(data, size);
    io_skip_space_comments(&cursor, '#');
    return io_next_word(&cursor);
}

const char *io_word(io_cursor *cursor, int64_t *length) {
    io_skip_space(cursor);
    const char *word = cursor->at;
    while (cursor->at < cursor->end && !is_space(*cursor->at))
        cursor->at++;
    *length = cursor->at - word;
    return word;
}

int io_word_is(const char *word, int64_t length, const char *name, int fold) {
    for (int64_t i = 0; i < length; i++)
        if (name[i] == '\0' || (fold ? lower(word[i]) != lower(name[i]) : word[i] != name[i]))
            return 0;
    return name[length] == '\0';
}

int io_slice_is(io_slice s, const char *name, int fold) {
    return io_word_is(s.begin, s.end - s.begin, name, fold);
}

int io_slice_integer(io_slice s, int64_t *value) {
    io_cursor cursor = {s.begin, s.end};
    return io_integer(&cursor, value) || cursor.at != s.end ? -1 : 0;
}

/** What follows a number must be white space or the end. */
static int ends_here(const io_cursor *cursor, const char *at) {
    return at == cursor->end || is_space(*at);
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

static int is_letter(char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
}

/** Skip blocks of bytes that hold nothing but numbers and white space. */
static void skip_number_blocks(io_cursor *cursor) {
    enum { BLOCK = 64 };
    while (cursor->end - cursor->at >= BLOCK) {
        int other = 0;
        for (int i = 0; i < BLOCK; i++) /* also bytes that are negative where char is signed */
            other |= ((unsigned char)cursor->at[i] >= 'A') | (cursor->at[i] == '#');
        if (other)
            return;
        cursor->at += BLOCK;
    }
}

void io_skip_numbers(io_cursor *cursor) {
    while (cursor->at < cursor->end) {
        int64_t length;
        const char *block = cursor->at;
        skip_number_blocks(cursor);
        while (cursor->at > block && cursor->at < cursor->end && !is_space(*cursor->at) &&
               !is_space(cursor->at[-1]))
            cursor->at++; /* the rest of a number */
        io_skip_space_comments(cursor, '#');
        io_cursor before = *cursor;
        const char *word = io_word(cursor, &length);
        if (length && is_letter(*word) && !io_word_is(word, length, "nan", 1) &&
            !io_word_is(word, length, "inf", 1)) {
            *cursor = before;
            return;
        }
    }
}
