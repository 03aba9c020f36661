/* foam_file: files of OpenFOAM's: their header, and the tokens of dictionaries.
 *
 *   foam_file, foam_open, foam_close      a file of the mesh, behind its header
 *   foam_skip, foam_integer, foam_word    tokens
 *   foam_expect, foam_check_word, foam_skip_value
 */
#ifndef PL_IO_FOAM_FOAM_FILE_H
#define PL_IO_FOAM_FOAM_FILE_H

#include "io/core/folder.h"
#include "io/core/number.h"
#include "io/core/records.h"

/** A file: its bytes, and what its header says of them. */
typedef struct foam_file {
    io_folder_file of; /* of.view: for messages */
    io_cursor cursor;
    int swapped, label_size, scalar_size; /* of binary numbers, in bytes; */
    int is_label_known, is_scalar_known;  /* 0: usual ones, where the header does not say */
    io_slice class;                       /* of the list, as the file names it */
} foam_file;

/** Open the file called name and read its header, behind which the cursor stands. Without it (no data)
 *  it is an error if needed. */
int foam_open(io_model *model, const char *name, int needed, foam_file *f, planish_error *error);

/** Read the header at the cursor of f, whose view is there. */
int foam_read_header(foam_file *f, planish_error *error);

/** Release the memory of the file. */
void foam_close(foam_file *f);

/** Skip white space and comments. */
void foam_skip(io_cursor *cursor);

/** Skip these characters; fast if the next character is another one. */
static inline void foam_skip_few(io_cursor *cursor) {
    while (cursor->at < cursor->end && *cursor->at == ' ')
        cursor->at++;
    if (cursor->at < cursor->end && (io_is_space(*cursor->at) || *cursor->at == '/'))
        foam_skip(cursor);
}

/** Take a whole number as io_parse_integer does, fast where it has no sign. */
static inline int foam_integer(io_cursor *cursor, int64_t *value) {
    enum { MOST_DIGITS = 18 };
    const char *at = cursor->at;
    int64_t number = 0;
    for (; at < cursor->end && *at >= '0' && *at <= '9'; at++) {
        if (at - cursor->at == MOST_DIGITS)
            return io_parse_integer(&cursor->at, cursor->end, value);
        number = 10 * number + (*at - '0');
    }
    if (at == cursor->at)
        return io_parse_integer(&cursor->at, cursor->end, value);
    cursor->at = at;
    *value = number;
    return 0;
}

/** Take the next token: one of ; { } ( ), a text in quotes, without these, or a word up to any of
 *  these. Empty at the end. */
io_slice foam_word(io_cursor *cursor);

/** Take a token that is to be text. Error: it is not. */
int foam_expect(foam_file *f, const char *text, planish_error *error);

/** Fail if a word begins a directive or names a macro, which are not read. */
int foam_check_word(const foam_file *f, io_slice word, planish_error *error);

/** Skip a value of an entry: up to its ';', or the end of its block. */
int foam_skip_value(foam_file *f, planish_error *error);

#endif
