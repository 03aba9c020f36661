/* nastran_card: declarations that nastran.c and nastran_card.c share: lines, cards and fields of
 * bulk data.
 *
 *   nastran_line, nastran_card, ...        lines and cards
 *   nastran_take_field, nastran_line_field fields of a card
 *   nastran_take_name, nastran_line_begins words
 *   nastran_field                          places of coordinates, for writing
 */
#ifndef PL_IO_NASTRAN_NASTRAN_CARD_H
#define PL_IO_NASTRAN_NASTRAN_CARD_H

#include "io/core/format.h"
#include "io/core/text.h"

#include <string.h>

enum {
    NASTRAN_NAME_COLUMNS = 8,
    NASTRAN_NAME_SIZE = NASTRAN_NAME_COLUMNS + 1,
    NASTRAN_SHORT_FIELD = 8,
    NASTRAN_LONG_FIELD = 16,
    NASTRAN_SHORT_FIELDS = 8,    /* of a line; it is a row, to which fields belong by their place */
    NASTRAN_FIRST_COORDINATE = 2 /* field of a GRID, from 0: number, system, coordinates */
};

/** Why cards of = and == and fields of *(1) are refused. */
static const char nastran_no_replication[] =
    "replication of the card before (=, *(1)) is not read; have the preprocessor write every card "
    "in full";

/** A line of bulk data. */
typedef struct nastran_line {
    io_slice text; /* before a comment and the continuation's mark */
    io_slice name; /* its first field, with the star */
    int is_free, is_long;
    int n_fields, width; /* of its fields, behind the name */
} nastran_line;

/** A card while its fields are taken one after the other. They are numbered from 0, the one behind
 *  the name. */
typedef struct nastran_card {
    io_cursor rest; /* the lines behind the current one */
    nastran_line line;
    const char *at; /* free: where the next field begins, or NULL: the line has no more */
    int n_of_line;  /* fields taken from the line */
    int64_t n;      /* fields taken */
    char name[NASTRAN_NAME_SIZE]; /* in capitals, without the star */
    const char *wrong;    /* why the fields taken cannot be what the lines say, or NULL: nothing */
    const char *wrong_at; /* and where */
} nastran_card;

/** Take the line at the cursor, which goes behind it. */
nastran_line nastran_take_line(io_cursor *cursor);

/** Copy the beginning of s in capitals, up to a blank, a star, a comma or NASTRAN_NAME_COLUMNS. */
void nastran_take_name(io_slice s, char name[NASTRAN_NAME_SIZE]);

/** Take the card at the cursor, which goes behind its first line. Return 0 at a comment, an empty
 *  line, or one that goes on with a card that is passed over. */
int nastran_take_card(io_cursor *cursor, nastran_card *c);

/** Return the next field of the current line, blanks and all; where the line ends before, its
 *  end. */
io_slice nastran_line_field(const nastran_card *c);

/** Take the next field without the blanks around it, on the lines that follow, too. Return 0 where
 *  the card ends. */
int nastran_take_field(nastran_card *c, io_slice *field);

/** Return whether the text begins with that word, in any letter case, behind blanks. */
int nastran_line_begins(io_slice text, const char *name);

/** Find where coordinate d of a GRID stands: io_format.field. */
int nastran_field(const io_model *model, io_cursor *cursor, int d, io_field *field);

#endif
