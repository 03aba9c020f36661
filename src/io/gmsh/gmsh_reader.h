/* gmsh_reader: declarations that the readers of MSH 1, 2 and 4 share; for gmsh*.c only.
 *
 *   gmsh_entity, gmsh_data, gmsh_reader   the state of a reader
 *   gmsh_find_type                        element types by their numbers
 *   gmsh_node_orders                      orders of nodes
 *   gmsh_take, gmsh_skip_...              single numbers
 *   gmsh_check_count                      counts that the file can hold
 *   gmsh_make_nodes, gmsh_read_nodes      nodes of all versions
 *   gmsh_block, gmsh_read_element         elements of all versions
 *   gmsh_point, gmsh_take_points          points that may be in groups
 *   gmsh_periodic                         periodic pairs of all versions
 *
 * A reader stands with its cursor behind the name of a section and leaves it before the section's
 * end mark, which gmsh.c checks. Functions return 0 or a negative planish_status, *reader->error
 * filled in.
 */
#ifndef PL_IO_GMSH_GMSH_READER_H
#define PL_IO_GMSH_GMSH_READER_H

#include "io/core/binary.h"
#include "io/core/elements.h"
#include "io/core/records.h"

/** MSH 4: an entity of the geometry, from $Entities and $PartitionedEntities. */
typedef struct gmsh_entity {
    int dim;
    int32_t tag;
    int32_t index; /* into io_model.entity */
    int interface; /* between parts of a partition: nothing of the geometry */
} gmsh_entity;

/** A point of the geometry: its node, and the entity that it is on in the model. */
typedef struct gmsh_point {
    int32_t node, entity;
} gmsh_point;

/** A section of values, $NodeData or $ElementData. */
typedef struct gmsh_data {
    int of_elements;          /* else of nodes */
    io_slice name;            /* without quotes */
    int64_t step, width, n;   /* of time; numbers of a value; values */
    const char *values, *end; /* where they begin, and the section's end mark */
    int is_read;              /* by gmsh_read_data */
} gmsh_data;

typedef struct gmsh_reader {
    io_model *model;
    planish_error *error;
    io_cursor cursor;
    io_text text;
    int swapped; /* swapped: not this machine's byte order */
    int version; /* 10 to 22, 40, 41; 0: no header has been read */
    int have_nodes, have_elements;
    gmsh_entity *entity; /* [n_entities], owned, by dim and tag once $Entities are read */
    int64_t n_entities, entity_capacity;
    gmsh_point *point; /* [n_points], owned: those of entities that may be in groups */
    int64_t n_points, point_capacity;
    gmsh_data *data; /* [n_data], owned, in the file's order */
    int64_t n_data, data_capacity;
} gmsh_reader;

/** Elements of one type and entity, and where they go. */
typedef struct gmsh_block {
    const gmsh_reader *reader;
    const io_element_type *type;
    io_cells *cells;    /* NULL: they are others, or hold their nodes */
    int mids;           /* of an element of second order that goes into cells, for which there is
                           room; else 0 */
    int other;          /* their planish_cell_type if they are others, else 0 */
    int64_t first;      /* index of the first in cells or in the others of its dimension, */
    int64_t first_node; /* and there of its first node */
    gmsh_point *point;  /* where points go, or NULL */
    int32_t entity;
    uint8_t reason; /* why nodes are held; 0: they are not */
    int bytes;      /* of a number; 0: text */
} gmsh_block;

/** Begin a block of n elements of its type and entity, -1 if they are of several: say where they go, and
 *  make room there. */
int gmsh_begin_block(gmsh_reader *reader, gmsh_block *block, int64_t n);

/** End a block whose n elements have been read. */
void gmsh_end_block(gmsh_reader *reader, const gmsh_block *block, int64_t n);

/** Find the row of an element type by its number, borrowed. Fail at a place in the file if the type
 *  is unknown, or if planish refuses it (a triangle or tetrahedron of third order or higher). error
 *  may be NULL. */
int gmsh_find_type(const gmsh_reader *reader, int64_t number, const char *at,
                   const io_element_type **type, planish_error *error);

/** Orders of nodes that are not VTK's, for io_model.node_order. */
extern const io_node_order gmsh_node_orders[];

/** Compare two gmsh_entity by dimension and tag, for qsort and bsearch. */
int gmsh_compare_entities(const void *left, const void *right);

/** Take the reader's next number, of 4 or 8 bytes in binary files; 0: of a section that is text
 *  there, too. Numbers of 4 bytes must fit into 32 bits in text. what: for the message. */
int gmsh_take(gmsh_reader *reader, int bytes, int64_t *value, const char *what);

/** Skip n numbers as gmsh_take takes them, or n reals. */
int gmsh_skip_integers(gmsh_reader *reader, int bytes, int64_t n, const char *what);
int gmsh_skip_reals(gmsh_reader *reader, int64_t n, const char *what);

/** Skip the end of this line, behind which binary data begin. Nothing in text. */
int gmsh_end_line(gmsh_reader *reader);

/** Fail at the cursor: what was expected there. */
int gmsh_fail_expected(const gmsh_reader *reader, const char *what);

/** Refuse counts that the rest of the file cannot hold (text and binary bytes of one record), or
 *  that are too many for the library; before anything is allocated. */
int gmsh_check_count(const gmsh_reader *reader, int64_t n, int64_t text_bytes, int64_t binary_bytes,
                     const char *what);

/** Make room for n nodes and their numbers (model->node_number). */
int gmsh_make_nodes(gmsh_reader *reader, int64_t n);

/** Read a block of n nodes from index first on. extra: parametric coordinates of a node, which are
 *  passed over. */
int gmsh_read_nodes(gmsh_reader *reader, int64_t first, int64_t n, int extra);

/** Make the nodes, which have all been read, findable by their numbers. */
int gmsh_end_nodes(gmsh_reader *reader);

/** Read the nodes of the element with that number at the cursor, into element index of the block's
 *  cells or of the others; hold them if the block says so. at: where the element begins, for
 *  messages. */
int gmsh_read_element(const gmsh_block *block, io_cursor *cursor, const char *at, int64_t number,
                      int64_t index, planish_error *error);

/** Make room for n more points. NULL without memory. */
gmsh_point *gmsh_add_points(gmsh_reader *reader, int64_t n);

/** Put the nodes of points into the groups of these: model->node_entity. */
int gmsh_take_points(gmsh_reader *reader);

/** Read $Periodic of all versions: the nodes of pairs of entities are held. In MSH 2 the section is
 *  text in binary files, too. */
int gmsh_periodic(gmsh_reader *reader);

#endif
