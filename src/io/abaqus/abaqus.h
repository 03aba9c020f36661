/* abaqus: what the reader of Abaqus input files and its sets share. */
#ifndef PL_IO_ABAQUS_ABAQUS_H
#define PL_IO_ABAQUS_ABAQUS_H

#include "io/core/model.h"
#include "io/core/text.h"

typedef struct abaqus_span {
    const char *begin, *end;
} abaqus_span;

enum { ABAQUS_NAME_SIZE = 32 };

typedef enum abaqus_keyword {
    ABAQUS_NODE,
    ABAQUS_ELEMENT,
    ABAQUS_NSET,
    ABAQUS_ELSET,
    ABAQUS_SECTION, /* gives a material to an ELSET */
    ABAQUS_EQUATION,
    ABAQUS_MPC,
    ABAQUS_PART,
    ABAQUS_END_PART,
    ABAQUS_INSTANCE,
    ABAQUS_END_INSTANCE,
    ABAQUS_ASSEMBLY,
    ABAQUS_END_ASSEMBLY,
    ABAQUS_REFUSED,
    ABAQUS_OTHER
} abaqus_keyword;

/** Where nodes and elements are numbered: outside of parts, in a part or instance (1, 2, ..), or:
 */
enum { ABAQUS_IN_ASSEMBLY = -1 };

/** A keyword line, which may be several, and its data lines. */
typedef struct abaqus_block {
    abaqus_keyword keyword;
    abaqus_span parameters, data;
    int32_t scope;
    int has_instance; /* INSTANCE= says whose numbers they are */
} abaqus_block;

/** Cells of one dimension that an *ELEMENT puts into an ELSET. */
typedef struct abaqus_range {
    int dim;
    int64_t begin, end; /* in the cells of dim */
    abaqus_span set;    /* name as it stands there, empty: none */
} abaqus_range;

typedef struct abaqus_reader {
    io_model *model;
    planish_error *error;
    abaqus_block *block; /* [n_blocks] */
    int64_t n_blocks, block_capacity;
    abaqus_range *range; /* [n_ranges] */
    int64_t n_ranges, range_capacity;
    int64_t n_counted;   /* nodes that there is room for */
    int32_t scope;       /* of the mesh */
    int has_cavities;    /* *FLUID PROPERTY is there: what F3D4 is (abaqus.c) */
    io_numbers *numbers; /* of nodes; NULL: consecutive */
} abaqus_reader;

/** The next line of data that is neither empty nor a comment, without blanks around it; 0 at the
 *  end. */
int abaqus_line(io_cursor *cursor, abaqus_span *line);
/** The next item of a line, up to a comma that is not between quotes, without blanks around it;
 *  line->begin is NULL behind the last. 0 at the end. */
int abaqus_item(abaqus_span *line, abaqus_span *item);
/** The value of the parameter name of a keyword line, as it stands there; 0 if it has none of that
 *  name. */
int abaqus_parameter(const abaqus_block *block, const char *name, abaqus_span *value);
/** Whether a name is in quotes, which keep the case of its letters. */
int abaqus_is_quoted(abaqus_span name);
abaqus_span abaqus_unquoted(abaqus_span name);
/** A whole number that is all of the item. 0 or -1. */
int abaqus_integer(abaqus_span item, int64_t *value);
/** What an item of a block names: INSTANCE.NAME without its instance. 0 if numbers there are of
 *  another numbering than the mesh's. */
int abaqus_local(const abaqus_reader *reader, const abaqus_block *block, abaqus_span *item);

static inline int64_t abaqus_length(abaqus_span s) {
    return s.end - s.begin;
}

/** Without blanks around it. */
abaqus_span abaqus_trim(abaqus_span s);
/** The item in capitals without blanks in it; "" if it is too long for any name that is known. */
void abaqus_squeeze(abaqus_span item, char name[ABAQUS_NAME_SIZE]);
/** The blocks of the file; what cannot be read is an error. */
int abaqus_find_blocks(abaqus_reader *r);
/** Refuse a block that takes its data from another file. */
int abaqus_check_input(const abaqus_reader *r, const abaqus_block *b);
/** "FILE:LINE: text" about a block. */
int abaqus_fail(const abaqus_reader *r, const abaqus_block *b, const char *text);

/** Sets of elements and nodes: entities, regions and groups of the model; nodes of equations are
 *  held. Everything else has been read. */
int abaqus_read_sets(abaqus_reader *reader);

#endif
