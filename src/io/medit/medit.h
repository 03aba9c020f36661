/* medit: what the parts of the reader of Medit's files share; for medit.c, medit_text.c and
 * medit_binary.c.
 *
 * A walk over the file (of text or of binary) notes where the sections that mean something are;
 * medit.c then reads their records, number by number, with the functions of the encoding. All
 * functions return 0 or a negative planish_status with the error filled in.
 */
#ifndef PL_IO_MEDIT_MEDIT_H
#define PL_IO_MEDIT_MEDIT_H

#include "io/core/records.h"

typedef enum medit_kind {
    MEDIT_VERTICES,
    MEDIT_CELLS,    /* edges, triangles, tetrahedra: kept */
    MEDIT_ELEMENTS, /* others: nodes are held */
    MEDIT_MARKED,   /* indices of vertices, edges, triangles, tetrahedra: their nodes are held */
    MEDIT_PAIRS,    /* of periodic vertices */
    MEDIT_REFUSED,
} medit_kind;

typedef struct medit_keyword {
    const char *name; /* in text */
    int code;         /* in binary */
    medit_kind kind;
    int nodes; /* of one record */
    int dim;   /* of what is meant */
} medit_keyword;

/** Where a section's records are. */
typedef struct medit_section {
    const medit_keyword *keyword;
    int64_t count;
    const char *data, *end; /* end: text: where the next keyword is; binary: behind the records */
} medit_section;

typedef struct medit_reader {
    io_model *model;
    planish_error *error;
    io_text text;
    int swapped;      /* not this machine's byte order */
    int real_size;    /* bytes of a coordinate, */
    int integer_size; /* of an index, a reference and a count, */
    int position_size;
    int version, dim;
    medit_section *sections; /* [n_sections] owned */
    int64_t n_sections, capacity;
    const medit_section *current;
    int64_t first_cell; /* of the current section in its io_cells */
} medit_reader;

/* ---- medit.c ------------------------------------------------------------------------------- */

/** The keyword of that name or code, or NULL: it means nothing to planish. */
const medit_keyword *medit_find_name(const char *word, int64_t length);
const medit_keyword *medit_find_code(int64_t code);

/** Refuse a version or dimension that is unknown, or note it. */
int medit_set_version(medit_reader *reader, const char *at, int64_t version);
int medit_set_dimension(medit_reader *reader, const char *at, int64_t dim);

/** Note a section; refuses keywords that are not smoothed and those that stand too early. at: the
 *  keyword. */
int medit_check_keyword(const medit_reader *reader, const char *at, const medit_keyword *keyword);
int medit_add_section(medit_reader *reader, const medit_keyword *keyword, int64_t count,
                      const char *data, const char *end);

/** Numbers of a record: vertices have dim reals, all have integers. */
int medit_integers_of(const medit_keyword *keyword);

/* ---- medit_text.c -------------------------------------------------------------------------- */

int medit_text_walk(medit_reader *reader);

/* ---- medit_binary.c ------------------------------------------------------------------------ */

/** Whether the file begins as Medit's binary files do. */
int medit_binary_recognise(const char *data, int64_t size);

int medit_binary_walk(medit_reader *reader);

/** Bytes of a record. */
int64_t medit_binary_size(const medit_reader *reader, const medit_keyword *keyword);

#endif
