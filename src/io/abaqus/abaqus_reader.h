/* abaqus_reader: declarations that the files of the reader of Abaqus input files share; for
 * abaqus*.c only.
 *
 *   abaqus_reader                            a file while it is read
 *   abaqus_line, abaqus_item, ...            lines, items and blocks (abaqus_blocks.c)
 *   abaqus_read_sets, abaqus_find_set        sets of nodes and of elements (abaqus_sets.c)
 *   abaqus_make_groups                       what sets become in the model (abaqus_groups.c)
 */
#ifndef PL_IO_ABAQUS_ABAQUS_READER_H
#define PL_IO_ABAQUS_ABAQUS_READER_H

#include "base/hash.h"

#include "io/core/format.h"
#include "io/core/text.h"

enum { ABAQUS_NAME_SIZE = 32 };

/** Meaning of a keyword; blocks are kept of those up to ABAQUS_LAST_KEPT. */
typedef enum abaqus_keyword {
    ABAQUS_NODE,
    ABAQUS_ELEMENT,
    ABAQUS_NSET,
    ABAQUS_ELSET,
    ABAQUS_SECTION, /* gives a material to an ELSET */
    ABAQUS_EQUATION,
    ABAQUS_MPC,
    ABAQUS_BOUNDARY,
    ABAQUS_SURFACE,
    ABAQUS_LAST_KEPT = ABAQUS_SURFACE,
    ABAQUS_IN_PART,    /* a part or instance begins, */
    ABAQUS_IN_OTHERS,  /* the assembly begins, or an instance in it ends, */
    ABAQUS_IN_NO_PART, /* a part or the assembly ends */
    ABAQUS_INCLUDE,
    ABAQUS_SYSTEM,
    ABAQUS_RULE, /* makes nodes or elements */
    ABAQUS_OTHER
} abaqus_keyword;

/** Scope of numbers and names: 0 outside of parts, in a part or instance 1, 2, ..., or: */
enum { ABAQUS_IN_ASSEMBLY = -1 };

/** A keyword line, which may be several, and its data lines. */
typedef struct abaqus_block {
    abaqus_keyword keyword;
    io_slice parameters;
    io_cursor data;
    int32_t scope;
    int has_instance; /* INSTANCE= says whose numbers they are */
} abaqus_block;

/** Elements of one list of the model that an *ELEMENT puts into an ELSET. */
typedef struct abaqus_range {
    int list;           /* 0: they are in none */
    int64_t begin, end; /* in the list */
    io_slice set;       /* name as it stands there, empty: none */
} abaqus_range;

/** Things that sets have: nodes; or elements, list by list. */
typedef enum abaqus_things { ABAQUS_NODES, ABAQUS_ELEMENTS } abaqus_things;

typedef struct abaqus_set {
    abaqus_things things;
    int32_t scope; /* of the name */
    io_slice name;
    int32_t *member; /* [n] owned */
    int64_t n, capacity;
    int32_t last_into;                        /* 1 + the set that this one was put into last, */
    int64_t last_n;                           /* and its number of members then */
    int is_held, is_of_section, is_supported; /* its members have been told so */
} abaqus_set;

typedef struct abaqus_reader {
    io_model *model;
    planish_error *error;
    abaqus_block *block; /* [n_blocks] */
    int64_t n_blocks, block_capacity;
    abaqus_range *range; /* [n_ranges] */
    int64_t n_ranges, range_capacity;
    int32_t scope;    /* of the mesh */
    int has_cavities; /* *FLUID PROPERTY is there: what F3D4 is (abaqus.c) */
    /* Of abaqus_read_sets: */
    abaqus_set *set; /* [n_sets] */
    int64_t n_sets, set_capacity;
    int32_t *slot[2]; /* [n_slots] hash tables of the names: index or -1; of names with fold the
                         first set that has it */
    int64_t n_slots;
    pl_hash hash;
    int64_t n[2];                   /* nodes, elements */
    int64_t first_cell[IO_N_LISTS]; /* of each list among the elements */
    int32_t *stamp[2];              /* [n] 1 + the set that had the thing last */
    io_numbers *elements; /* numbers of elements; NULL until a set is read that names them, */
    int has_doubled;      /* and if surfaces have found that one occurs twice */
    int64_t n_asked; /* members that sequences and sets of sets asked for, those included that were
                        there already */
} abaqus_reader;

/* ---- lines, items and blocks --------------------------------------------------------------- */

/** Take the next line of data that is neither empty nor a comment, without blanks around it; return
 *  0 at the end. */
int abaqus_line(io_cursor *cursor, io_slice *line);

/** Take the next item of a line, up to a comma that is not between quotes, without blanks around
 *  it; line->begin is NULL behind the last. Return 0 at the end. */
int abaqus_item(io_slice *line, io_slice *item);

/** Find the value of a parameter of a keyword line, as it stands there; return 0 if there is no
 *  parameter of that name. */
int abaqus_parameter(const abaqus_block *block, const char *name, io_slice *value);

/** Return whether a name is in quotes, which keep the case of its letters. */
int abaqus_is_quoted(io_slice name);

/** Return a name without its quotes. */
io_slice abaqus_unquoted(io_slice name);

/** Strip the instance from an item of a block: INSTANCE.NAME. Return 0 if numbers there are of
 *  another numbering than the mesh's. */
int abaqus_local(const abaqus_reader *reader, const abaqus_block *block, io_slice *item);

/** Copy the item in capitals without blanks; "" if it is too long for any name that is known. */
void abaqus_squeeze(io_slice item, char name[ABAQUS_NAME_SIZE]);

/** Find the blocks of the file. Error: a keyword that planish does not read. */
int abaqus_find_blocks(abaqus_reader *r);

/** Fail at a block: "FILE:LINE: text". */
int abaqus_fail(const abaqus_reader *r, const abaqus_block *b, const char *text);

/** Fail at an item: "FILE:LINE: 'item' text". */
int abaqus_fail_item(const abaqus_reader *r, io_slice item, const char *text);

/* ---- sets ----------------------------------------------------------------------------------- */

/** Read sets of elements and nodes, and hold nodes of equations. Everything else has been read. */
int abaqus_read_sets(abaqus_reader *r);

/** Return the index of the set of that name in a scope, or of one that differs by the case of its
 *  letters; or -1. */
int32_t abaqus_find_set(const abaqus_reader *r, abaqus_things things, int32_t scope, io_slice name);

/** Return the list that an element is in; *local: its index there. */
io_list abaqus_list_of(const abaqus_reader *r, int64_t cell, int64_t *local);

/** Make entities of elements and nodes, by the sets that each is in, regions of elements, and a group of
 *  each set. Sets have been read. */
int abaqus_make_groups(abaqus_reader *r);

#endif
