/* medit_reader: declarations that the parts of the reader of Medit's files share.
 *
 *   medit.c        keywords of meshes; where the sections are, in text and in binary
 *   medit_mesh.c   medit_read_section: what they say
 *   medit_sol.c    the solution at vertices of another file
 *
 * All functions return 0 or a negative planish_status with the error filled in.
 */
#ifndef PL_IO_MEDIT_MEDIT_READER_H
#define PL_IO_MEDIT_MEDIT_READER_H

#include "io/core/elements.h"
#include "io/core/format.h"
#include "io/core/records.h"

/** Kinds of sections, in the order in which they are read. */
typedef enum medit_kind {
    MEDIT_VERTICES,
    MEDIT_ORDERING, /* places of the nodes of elements of second order */
    MEDIT_ELEMENTS,
    MEDIT_CURVED, /* of second order, behind those of first order, whose indices others have */
    MEDIT_MARKED, /* indices of vertices, edges, triangles, tetrahedra: their nodes are held */
    MEDIT_PAIRS,  /* of periodic vertices */
    MEDIT_N_KINDS,
    MEDIT_SOLUTION = MEDIT_N_KINDS /* of a file that is no mesh: values of vertices */
} medit_kind;

typedef struct medit_keyword {
    io_element_type type; /* with the name in text; nodes: indices of a record */
    int code;             /* in binary */
    medit_kind kind;
} medit_keyword;

enum { MEDIT_N_ORDERS = 6 }; /* of types whose order of nodes an ..Ordering may say */

typedef struct medit_reader {
    io_model *model;
    planish_error *error;
    const medit_keyword
        *keywords; /* [n_keywords] by the numbers of io_section: others are passed over */
    int n_keywords;
    io_text text;
    int swapped;      /* not this machine's byte order */
    int real_size;    /* bytes of a coordinate, */
    int integer_size; /* of an index, a reference and a count; text: of any of them, at least */
    int version, dim;
    io_sections sections;
    const medit_keyword *current; /* of the section that is read, */
    io_record_kind kind;          /* its records, */
    io_cells *cells;              /* what its elements become, or NULL: nodes are held, */
    int64_t first_cell;           /* and where they begin, in cells or in the others, */
    int64_t first_node;           /* with the nodes of the first */
    io_node_order order[MEDIT_N_ORDERS + 1]; /* what model->node_order is meanwhile */
    int n_orders;
} medit_reader;

/** Return the bytes of a record; in text at least. */
int64_t medit_record_size(const medit_reader *r, const medit_keyword *k);

/** Find the sections of the keywords: fill in the reader's numbers, version, dimension and
 *  sections. model, error and keywords are there. */
int medit_find_sections(medit_reader *reader);

/** Read a section: vertices come first, then orders of nodes, elements, and what refers to them. */
int medit_read_section(medit_reader *reader, const io_section *section);

#endif
