/* text: walk the bytes of an ASCII mesh file.
 *
 *   io_slice, io_slice_...          some bytes of the file: a name, a field, a line
 *   io_is_blank, _is_space, _upper  characters
 *   io_begin_text, io_first_word    the beginning of a text
 *   io_skip_...                     skip white space, comments, a line, numbers
 *   io_next_line, _take_line, _next_word    take a line or a word
 *   io_integer, io_real             take a number
 *   io_find_line                    find a line
 *
 * A cursor (model.h) stands in a text; functions that take something leave it behind that.
 */
#ifndef PL_IO_CORE_TEXT_H
#define PL_IO_CORE_TEXT_H

#include "io/core/model.h"

#include <string.h>

/** Return whether c is a blank or a tab. */
static inline int io_is_blank(char c) {
    return c == ' ' || c == '\t';
}

/** Return whether c is white space. Without branches, as the index of tokens asks for each byte. */
static inline int io_is_space(char c) {
    return (c == ' ') | ((unsigned char)(c - '\t') <= '\r' - '\t');
}

/** Return the letter c as a capital, in ASCII; any other byte as it is. */
static inline char io_upper(char c) {
    return c >= 'a' && c <= 'z' ? (char)(c - 'a' + 'A') : c;
}

/** Bytes of the file from begin to before end, borrowed: a name, a field, a line. */
typedef struct io_slice {
    const char *begin, *end;
} io_slice;

/** Return the number of bytes. */
static inline int64_t io_slice_length(io_slice s) {
    return s.end - s.begin;
}

/** The arguments of %.*s for s, or its beginning, in messages. */
#define IO_QUOTED(s) (int)(io_slice_length(s) < 32 ? io_slice_length(s) : 32), (s).begin

/** Return s without the blanks and tabs around it. */
static inline io_slice io_slice_trim(io_slice s) {
    while (s.begin < s.end && io_is_blank(*s.begin))
        s.begin++;
    while (s.begin < s.end && io_is_blank(s.end[-1]))
        s.end--;
    return s;
}

/** Return the first place of a character in s, or its end. */
static inline const char *io_slice_find(io_slice s, char what) {
    const char *found = s.begin < s.end ? memchr(s.begin, what, (size_t)io_slice_length(s)) : NULL;
    return found ? found : s.end;
}

/** Return whether s is name, letter case ignored if fold. */
int io_slice_is(io_slice s, const char *name, int fold);

/** Read the number that all of s is: 0 or -1. An integer may have white space before it, the
 *  exponent of a real one may stand without an e (Nastran's 1.5-3) if it is implied. */
int io_slice_integer(io_slice s, int64_t *value);
int io_slice_real(io_slice s, int implied_exponent, double *value);

/** Return a text of size bytes from behind the mark of UTF-8 that some editors put before it. */
io_cursor io_begin_text(const char *data, int64_t size);

/** Return the first word of a file, behind that mark, white space and comments ('#'): the word that
 *  tells the format. Empty if there is none. */
io_slice io_first_word(const char *data, int64_t size);

/** Skip blanks, tabs, line ends (\n, \r\n, \r). */
void io_skip_space(io_cursor *cursor);

/** Skip white space and comments that run from mark ('#') to the end of the line. */
void io_skip_space_comments(io_cursor *cursor, char mark);

/** Skip to the beginning of the next line (or the end). */
void io_skip_line(io_cursor *cursor);

/** Skip to the next word that begins with a letter (nan and inf are numbers), over comments ('#').
 *  The cursor stands behind a word. */
void io_skip_numbers(io_cursor *cursor);

/** Take the line at the cursor, without its end (\n, \r\n or \r), behind which the cursor goes. */
io_slice io_next_line(io_cursor *cursor);

/** Take the next line that is not empty, from its first word on, as a text of its own. */
static inline io_cursor io_take_line(io_cursor *cursor) {
    io_skip_space(cursor);
    const char *begin = cursor->at;
    return (io_cursor){begin, io_next_line(cursor).end};
}

/** Take the next word (no white space in it) after white space; empty at the end of the text. */
io_slice io_next_word(io_cursor *cursor);

/** Take the next integer or real after white space; 0 or -1 (nothing is skipped then but white
 *  space). White space or the end must follow. */
int io_integer(io_cursor *cursor, int64_t *value);
int io_real(io_cursor *cursor, double *value);

/** Find the first place at or after from that begins a line with name (a section's end), or end.
 *  Lines end with \n here: \r alone, which io_next_line knows, ends none. */
const char *io_find_line(const char *from, const char *end, const char *name);

#endif
