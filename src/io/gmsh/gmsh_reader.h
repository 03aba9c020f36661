/* gmsh_reader: what the readers of MSH 1, 2 and 4 share; for gmsh*.c only.
 *
 *   gmsh_reader, gmsh_place, gmsh_data   the state of a reader
 *   gmsh_find_type                       element types by their numbers
 *   gmsh_fail_expected, gmsh_take_...    errors and single numbers
 *   gmsh_make_nodes, gmsh_hold_pairs ... nodes and periodic pairs
 *   gmsh_names.c                         names of groups
 *   gmsh_data.c                          values of elements that may tell regions
 *   gmsh2.c, gmsh_copies.c, gmsh4.c      sections of MSH 1 and 2, and of MSH 4
 *
 * A reader stands with its cursor behind the name of a section and leaves it before the section's
 * end mark, which gmsh.c checks. Functions return 0 or a negative planish_status, *reader->error
 * filled in.
 */
#ifndef PL_IO_GMSH_GMSH_READER_H
#define PL_IO_GMSH_GMSH_READER_H

#include "io/core/elements.h"
#include "io/core/records.h"

/** MSH 4: an entity of the geometry, from $Entities and $PartitionedEntities. */
typedef struct gmsh_place {
    int dim;
    int32_t tag;
    int32_t entity; /* index into io_model.entity */
    int interface;  /* between parts of a partition: nothing of the geometry */
} gmsh_place;

/** A section $ElementData of one number per element. */
typedef struct gmsh_data {
    const char *name; /* [length] in the file, without quotes */
    int64_t length;
    int64_t step, n;          /* of time; values */
    const char *values, *end; /* where they begin, and the section's end mark */
} gmsh_data;

typedef struct gmsh_reader {
    io_model *model;
    planish_error *error;
    io_cursor cursor;
    io_text text;
    int swapped; /* swapped: not this machine's byte order */
    int version; /* 10 to 22, 40, 41; 0: no header has been read */
    int have_nodes, have_elements;
    io_numbers *numbers; /* of the nodes, or NULL: consecutive */
    gmsh_place *place;   /* [n_places], owned, by dim and tag once $Entities are read */
    int64_t n_places, place_capacity;
    gmsh_data *data; /* [n_data], owned: what may tell regions, in the file's order */
    int64_t n_data, data_capacity;
} gmsh_reader;

/** Find the row of an element type by its number, borrowed. Fail at a place in the file if the type
 *  is unknown, or if planish refuses it (a triangle or tetrahedron of higher order). error may be
 *  NULL. */
int gmsh_find_type(const gmsh_reader *reader, int64_t number, const char *at,
                   const io_element_type **type, planish_error *error);

/** Fail at the cursor: what was expected there. */
int gmsh_fail_expected(const gmsh_reader *reader, const char *what);

/** The next number: text or binary (int32; size_t of 8 bytes; double). what: for the message. */
int gmsh_take_int(gmsh_reader *reader, int32_t *value, const char *what);
int gmsh_take_size(gmsh_reader *reader, int64_t *value, const char *what);
int gmsh_skip_reals(gmsh_reader *reader, int64_t n, const char *what);

/** The next number of a section that is text in binary files, too. */
int gmsh_take_text(gmsh_reader *reader, int64_t *value, const char *what);

/** Binary: the data begin behind the end of this line. */
int gmsh_end_line(gmsh_reader *reader);

/** Refuse counts that the rest of the file cannot hold (text and binary bytes of one record), or
 *  that are too many for the library; before anything is allocated. */
int gmsh_check_count(const gmsh_reader *reader, int64_t n, int64_t text_bytes, int64_t binary_bytes,
                     const char *what);

/** Room for n nodes and their numbers (model->node_number), and the span of a text file. */
int gmsh_make_nodes(gmsh_reader *reader, int64_t n, int64_t text_bytes, int64_t binary_bytes);

/** The coordinates of node from the three doubles at a place of a binary file. */
int gmsh_load_point(const gmsh_reader *reader, const char *at, int64_t node, planish_error *error);

/** Nodes are read, their numbers in model->node_number: make them findable. */
int gmsh_index_nodes(gmsh_reader *reader);

/** Hold both nodes of n periodic pairs, numbers of so many bytes; 0: text. */
int gmsh_hold_pairs(gmsh_reader *reader, int64_t n, int size);

/** Text: over the line with the transform of a periodic pair, where there is one. */
void gmsh_skip_affine(gmsh_reader *reader);

/** $PhysicalNames, and what becomes of names without a dimension when all is read. */
int gmsh_names(gmsh_reader *reader);
int gmsh_settle_names(gmsh_reader *reader);

/** Binary: over the values of $NodeData and the like, by their count. with_nodes: each value is
 *  of as many nodes as it says. 0, or -1: they are not what they should be; the cursor has not
 * moved then. */
int gmsh_skip_data(gmsh_reader *reader, int with_nodes);

/** Keep in mind the section $ElementData behind whose name head is, and whose end mark is at end,
 * if it may tell regions. Only a lack of memory is an error. */
int gmsh_note_data(gmsh_reader *reader, const char *head, const char *end);

/** When all has been read and the elements' numbers are settled: make arrays (arrays.h) of the
 *  sections that gmsh_note_data has kept. What is malformed is passed over. */
int gmsh_read_data(gmsh_reader *reader);

/** Sections of MSH 1 and 2, and of MSH 4; gmsh2_merge_copies follows the elements of MSH 2. */
int gmsh2_nodes(gmsh_reader *reader);
int gmsh2_elements(gmsh_reader *reader);
int gmsh2_merge_copies(gmsh_reader *reader);
int gmsh2_periodic(gmsh_reader *reader);
int gmsh4_entities(gmsh_reader *reader);
int gmsh4_partitioned_entities(gmsh_reader *reader);
int gmsh4_nodes(gmsh_reader *reader);
int gmsh4_elements(gmsh_reader *reader);
int gmsh4_periodic(gmsh_reader *reader);

#endif
