/* netgen_reader: declarations that the parts of the reader of Netgen's files share.
 *
 *   netgen.c        keywords; where the sections are
 *   netgen_mesh.c   netgen_read_section: what they say
 *
 * All functions return 0 or a negative planish_status with the error filled in.
 */
#ifndef PL_IO_NETGEN_NETGEN_READER_H
#define PL_IO_NETGEN_NETGEN_READER_H

#include "io/core/elements.h"
#include "io/core/records.h"

typedef enum netgen_kind {
    NETGEN_POINTS,
    NETGEN_ELEMENTS,
    NETGEN_SEGMENTS,
    NETGEN_POINT_ELEMENTS,
    NETGEN_PAIR_TYPES,
    NETGEN_PAIRS,
    NETGEN_SINGULAR_POINTS,
    NETGEN_SINGULAR_SEGMENTS,
    NETGEN_N_READ,                /* all before: read when the walk is over, in this order */
    NETGEN_NAMES = NETGEN_N_READ, /* lines of a number and a name */
    NETGEN_LINES,                 /* that may have any words: passed over */
    NETGEN_REFUSED
} netgen_kind;

typedef struct netgen_keyword {
    const char *name;
    netgen_kind kind;
    int dim;          /* of elements and segments */
    int words;        /* of a record; of elements those before the nodes */
    int group;        /* elements and segments: which word has it; NETGEN_NAMES: codimension */
    int extra;        /* elements: words for each node that stand behind the nodes */
    int corner;       /* segments: which word is the first node */
    int parameter[2]; /* segments: which words are the nodes' parameters on their curve, or 0.
                         Elements: not 0: the extra words are parameters */
} netgen_keyword;

enum {
    NETGEN_LEAST_CORNERS = 3, /* of an element; 0 in the file means 3, too */
    NETGEN_MOST_CORNERS = 32
};

/** Orders of nodes that are not VTK's, for io_model.node_order. */
extern const io_node_order netgen_node_orders[];

/** Keywords by the numbers of io_section. */
extern const netgen_keyword netgen_keywords[];

typedef struct netgen_reader {
    io_model *model;
    planish_error *error;
    io_text text;
    int dim;
    io_sections sections;
    const netgen_keyword *current; /* of the section that is read, */
    io_record_kind kind;           /* and its records */
    int corners;           /* nodes of all elements of the current section; 0: they differ */
    int64_t first_cell;    /* of the current section in its io_cells */
    int64_t first_number;  /* of its elements: those of a dimension are counted from 1 */
    int64_t n_elements[4]; /* by dimension, of the sections before */
    int64_t n_kept;        /* of them, where they differ */
    int8_t *is_periodic;   /* [n_types] owned: by number of identification, from 1 */
    int64_t n_types;
} netgen_reader;

/** Read a section; points come first, then elements and segments, then what refers to them. */
int netgen_read_section(netgen_reader *reader, const io_section *section);

#endif
