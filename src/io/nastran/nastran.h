/* nastran: lines, cards and fields of bulk data, for nastran.c, nastran_card.c and nastran_field.c.
 */
#ifndef PL_IO_NASTRAN_NASTRAN_H
#define PL_IO_NASTRAN_NASTRAN_H

#include "io/core/format.h"
#include "io/core/text.h"

#include <string.h>

enum {
    NAME_COLUMNS = 8,
    NAME_SIZE = NAME_COLUMNS + 1,
    SHORT_FIELD = 8,
    LONG_FIELD = 16,
    SHORT_FIELDS = 8,    /* of a line; it is a row, to which fields belong by their place */
    LONG_FIELDS = 4,     /* two such lines are a row */
    LAST_COLUMN = 72,    /* behind it stands the mark of the continuation */
    COMMA_BEFORE = 10,   /* a line with a comma in its first columns is of free fields */
    FIRST_COORDINATE = 2 /* field of a GRID, from 0: number, system, coordinates */
};

typedef struct span {
    const char *begin, *end;
} span;

/** A line of bulk data. */
typedef struct line {
    span text; /* before a comment and the continuation's mark */
    span name; /* its first field, with the star */
    int is_free, is_long;
} line;

/** A card while its fields are taken one after the other. They are numbered from 0, the one behind
 *  the name. */
typedef struct card {
    io_cursor rest; /* the lines behind the current one */
    line line;
    const char *at;       /* free: where the next field begins, or NULL: the line has no more */
    int n_of_line;        /* fields taken from the line */
    int64_t n;            /* fields taken */
    char name[NAME_SIZE]; /* in capitals, without the star */
    const char *wrong;    /* why the fields taken cannot be what the lines say, or NULL: nothing */
    const char *wrong_at; /* and where */
} card;

static inline span nastran_trim(span s) {
    while (s.begin < s.end && io_is_blank(*s.begin))
        s.begin++;
    while (s.begin < s.end && io_is_blank(s.end[-1]))
        s.end--;
    return s;
}

/** The first place of what, or the end. */
static inline const char *find_character(span s, char what) {
    const char *found = s.begin < s.end ? memchr(s.begin, what, (size_t)(s.end - s.begin)) : NULL;
    return found ? found : s.end;
}

/** At most the first n bytes. */
static inline span leading_part(span s, int64_t n) {
    return s.end - s.begin > n ? (span){s.begin, s.begin + n} : s;
}

static inline int fields_of(const line *l) {
    return l->is_long ? LONG_FIELDS : SHORT_FIELDS;
}

static inline int width_of(const line *l) {
    return l->is_long ? LONG_FIELD : SHORT_FIELD;
}

static inline int is_empty_field(span s) {
    return s.begin == s.end;
}

/** The line at the cursor, which goes behind it. */
line nastran_take_line(io_cursor *cursor);

/** The card at the cursor, which goes behind its first line. 0: a comment, an empty line, or one
 *  that goes on with a card that is passed over. */
int nastran_take_card(io_cursor *cursor, card *c);

/** Go to the line that the card goes on with; 0: there is none. */
int nastran_continue_card(card *c);

/** The field at hand, blanks and all, of the current line. */
span nastran_line_field(const card *c);

/** Whether the current line has the field at hand. */
int nastran_has_field(const card *c);

/** The next field without the blanks around it, on the lines that follow, too; 0: there is none. */
int nastran_take_field(card *c, span *field);

/** The lines between BEGIN BULK, if there is one, and ENDDATA. */
io_cursor nastran_find_bulk(const char *data, int64_t size);

/** Whether the text begins with that word, in any letter case. */
int nastran_line_begins(span text, const char *name);

/** Where coordinate d of a GRID stands: io_format.field. */
int nastran_field(const io_model *model, io_cursor *cursor, int d, io_field *field);

#endif
