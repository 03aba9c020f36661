/* model: the structure that every reader fills in and the one writer uses.
 *
 *   io_model                            a file that is read: its input, nodes, cells, groups
 *   io_cursor, io_bytes                 places in the input, and its bytes
 *   io_span, io_field, io_edit          places of coordinates, and their replacement
 *   io_cells, io_others                 simplices of order 1 and 2, and other elements
 *   io_model_add_simplex, _add_other    elements by their types, one by one
 *   io_list_...                         all elements, in lists by dimension
 *   io_entity, io_group                 regions and names
 *   io_array, io_data                   whole numbers that may tell regions; data for whoever asks
 *   io_model_make_nodes, _span ...      what readers call to fill it in
 *   io_numbers, io_reduce_...           the file's numbers of nodes and cells
 *   io_fail_at, io_check_...            errors at a place, and checks
 *   io_model_threads                    how many threads may work on it
 *
 * A reader walks the bytes of its format once and tells the model: the nodes (value and place of
 * their coordinates in the file), the triangles and tetrahedra, which nodes other things in the
 * file hold, and the names of groups. Nothing else of the file is kept, because the writer copies
 * the file's own bytes around the coordinates it replaces.
 *
 * Functions of src/io report in one of four ways; a docstring says which where it is not clear:
 *
 *   a status          0, or a negative planish_status with *error filled in. The caller returns it
 *                     as it is. Functions that fail or check, and all that have an error to fill in
 *   0 or -1           -1 without an error: io_parse_..., io_integer, io_real, io_slice_real. The
 *                     caller knows what was expected, and says so by io_fail_at
 *   1 or 0            0 at the end: functions that take the next item of a line or card
 *   an index or -1    io_..._find, io_node_index; of a table a pointer or NULL. io_model_entity: an
 *                     index or a negative status
 *
 * A function that reads records (records.h) fills in its parameter error, which may be NULL, and
 * never the error of the reader: several threads call it at the same time.
 */
#ifndef PL_IO_CORE_MODEL_H
#define PL_IO_CORE_MODEL_H

#include "base/hash.h"
#include "base/printf.h"
#include "io/core/cell_types.h"
#include "io/core/names.h"
#include "io/core/number.h"
#include "io/core/order.h"

#include <planish/planish_io.h>

#include "base/output.h"

#include <math.h>

/** A position in the file; every function stops at end and never reads behind it. */
typedef struct io_cursor {
    const char *at, *end;
} io_cursor;

/** The bytes of a file: read, or mapped where it is large (bytes.h). */
typedef struct io_bytes {
    char *path;
    const char *data; /* [size] */
    int64_t size;
    int mapped;
    int fd;           /* of a regular file, else -1 */
    int64_t modified; /* when it was last, in ns */
} io_bytes;

typedef enum io_encoding {
    IO_TEXT,    /* text; io_format.field says how */
    IO_FLOAT32, /* binary, in the byte order of swapped */
    IO_FLOAT64
} io_encoding;

/** A run of nodes whose coordinates stand in the file at a constant distance (binary), or
 *  each at its own place (text: io_model.text_offset). Spans are in the file's order. */
typedef struct io_span {
    int64_t first_node, n_nodes;
    io_encoding encoding;
    int swapped;      /* binary: not this machine's byte order */
    int64_t offset;   /* binary: byte of the first node's first coordinate */
    int64_t stride;   /* binary: bytes from node to node */
    int component;    /* the first coordinate there, most often 0, */
    int n_components; /* and how many stand side by side; 0: all */
} io_span;

/** Place of a coordinate in text, and of the number that replaces it. Three kinds:
 *
 *   numbers apart by white space   begin .. end is the number, all else 0
 *   fixed columns (Nastran)        begin .. end is the field with its blanks; width, is_fixed
 *   items apart by commas (Abaqus) begin .. end is the item without blanks; width
 *
 *  Where the line ends before a field, begin and end are its end, and lead is what belongs between.
 */
typedef struct io_field {
    const char *begin, *end; /* its characters; blanks around it are some of these where fields
                                have a fixed width */
    double value;            /* 0 where the field is empty */
    int width;               /* characters that a number may have there, no fewer than
                                io_model.field_width: values are rounded to that before they are
                                judged, and a narrower field would change them; 0: any number */
    int is_fixed;            /* numbers stand left in begin .. end, and blanks fill it up */
    const char *lead;        /* [n_lead] what must stand before a number where the file has no field
                                for it, behind the fields before it in full width; NULL: the field
                                is there. With n_lead 0: it is missing, and needs nothing before */
    int n_lead;              /* IO_LEAD_SIZE at most */
    char made[12];           /* may be the lead, where it differs from field to field */
} io_field;

enum { IO_LEAD_SIZE = 64 };

/** Bytes of the input that others take the place of. */
typedef struct io_edit {
    int64_t begin, end; /* in the input */
    char *text;         /* [length] owned; NULL with length 0 */
    int64_t length;
} io_edit;

/** Edits in the file's order, none within another. */
typedef struct io_edits {
    io_edit *edit; /* [n] */
    int64_t n, capacity;
} io_edits;

/** Simplices of one dimension, of order 1 or 2, in the file's order. */
typedef struct io_cells {
    int64_t n, capacity;
    int32_t *nodes;  /* [n][dim + 1] corners, indices of nodes (not the file's numbers) */
    int32_t *mid;    /* [n][edges: 1, 3, 6] mids of the edges between corners 01 12 20 03 13 23;
                        -1: the edge has none. NULL: no edge has, of any cell */
    int32_t *entity; /* [n] index into io_model.entity, or NULL: the file has none. A reader may
                        put the file's tags here first, for io_model_index_tags */
    int64_t *number; /* [n] the file's element numbers, or NULL: 1, 2, 3 ... from first_number */
    int64_t first_number;
    int32_t *region; /* [n] which region each is of, where entities say more than that; or NULL: the
                        entity. A reader that wants it allocates it */
    int64_t n_plain; /* the last of them say nothing of their nodes (finish.c) */
} io_cells;

/** Elements of one dimension that are no simplices of order 1 or 2, in the file's order. */
typedef struct io_others {
    int64_t n, capacity;
    uint8_t *type;   /* [n] planish_cell_type */
    int64_t *number; /* [n] the file's element numbers */
    int64_t *offset; /* [n + 1] where their nodes begin; NULL while there is no room for any */
    int32_t *entity; /* [n] as io_cells.entity */
    int32_t *region; /* [n] as io_cells.region */
    int64_t n_nodes, node_capacity;
    int32_t *node;   /* [n_nodes] indices of nodes in VTK's order; -1: a mid that is missing */
    int64_t n_plain; /* as io_cells.n_plain */
} io_others;

/** Order of the nodes of a type in a format, where it is not VTK's: node i of VTK is the format's
 *  node at[i]. */
typedef struct io_node_order {
    uint8_t type; /* planish_cell_type; 0: end of a table */
    uint8_t at[27];
} io_node_order;

/** Return the number of cells that say something of their nodes: the first ones. */
static inline int64_t io_cells_telling(const io_cells *cells) {
    return cells->n - cells->n_plain;
}

static inline int64_t io_others_telling(const io_others *others) {
    return others->n - others->n_plain;
}

/** Return the numbers [n] that tell the regions of cells apart, or NULL: there is one. */
static inline const int32_t *io_cells_regions(const io_cells *cells) {
    return cells->region ? cells->region : cells->entity;
}

/** A region or surface, line, point that cells belong to: cells of different tags are of different
 *  entities. tag: Gmsh's elementary entity, Medit's reference, TetGen's attribute. */
typedef struct io_entity {
    int dim;
    int32_t tag;
    int n_physical;
    int32_t *physical; /* [n_physical] Gmsh's physical groups, owned */
} io_entity;

/** A named group: all entities of dim with that tag among their physical tags (or their tag, where
 *  the format has no physical groups). */
typedef struct io_group {
    int dim;
    int32_t tag;
    char *name;       /* owned */
    int ignores_case; /* of letters of the name (Abaqus' without quotes) */
} io_group;

/** Name of a type of elements in the file. */
typedef struct io_type_name {
    int type; /* planish_cell_type */
    char name[32];
} io_type_name;

/** An array of one whole number per cell of the file (arrays.h). */
typedef struct io_array {
    char *name;      /* owned */
    int64_t n;       /* cells of the file */
    int32_t *narrow; /* [n] owned values by the number of the cell, from 0; 0 where a cell that is
                        no element has no whole number */
    int64_t *wide;   /* [n] owned, in place of narrow where 32 bits do not do */
    int by_element;  /* values are [n] of the elements, in their order, instead */
    int is_region;   /* it tells regions */
} io_array;

/** Place of an array of numbers that the file has for nodes or elements (data.h). */
typedef struct io_data {
    char *name;         /* owned */
    int of_elements;    /* else of nodes */
    int is_more;        /* continues an array of that name before it */
    int64_t width;      /* numbers of a value */
    int64_t n;          /* values that it has; the format knows how many there should be */
    int64_t n_cells;    /* cells of the file, where its elements are numbered by cells from 0 */
    int64_t begin, end; /* bytes of the values; end: of Gmsh's sections */
    int swapped;        /* not this machine's byte order */
    int is_integer;     /* numbers are whole by their type */
    const void *type;   /* the format's own, of the numbers */
} io_data;

/** What the file says of a node, bits of io_model.hold: why the node is held, or that it has
 *  parameters. */
enum {
    IO_HELD_BY_POINT = 1,   /* on an element that is a point */
    IO_HELD_BY_OTHER = 2,   /* on an element of a type that is not smoothed, or a line of more
                                 than three nodes */
    IO_HELD_REQUIRED = 4,   /* marked in the file */
    IO_HELD_PERIODIC = 8,   /* one of a periodic pair */
    IO_HELD_BY_LINE = 16,   /* on a line, */
    IO_HELD_BY_FACE = 32,   /* on a facet of a mesh of solid elements */
    IO_HELD_MARKED = 64,    /* marked in a file that may mean no more than that it is on the
                                 boundary (VTK) */
    IO_HAS_PARAMETERS = 128 /* is not held by that: parameters of the geometry go with its place */
};

/** The plane of a mesh of triangles. Seen along the column across, a node is at (x, y) from the
 *  origin, with coordinates u = xu x + yu y, v = yv y of an orthonormal frame, if it is tilted;
 *  else these are x and y. */
typedef struct io_plane {
    int axis[3]; /* the columns that coordinates in it go along, and the one across */
    int is_tilted;
    double origin[3]; /* in the order of axis, */
    double slope[2];  /* that of the column across with x and y: at most 1, but for roundings */
    double xu, yu, yv;
    double size; /* the diagonal of the box of its nodes, */
    double off;  /* and how far off it they are at most */
} io_plane;

typedef struct io_model {
    io_bytes input;      /* holds the coordinates */
    io_bytes *companion; /* files beside the input, written along with it as they are (TetGen) */
    int n_companions, n_read; /* the first of these are read, too */
    io_bytes *included;       /* [n_included] files that it names, while it is read (include.h) */
    int n_included;
    int64_t included_capacity;
    char *folder;      /* of a mesh that is a folder: its path as it was given, owned; NULL: */
    char *inner;       /* it is files. And where in it these are, "" or a path; owned */
    io_bytes document; /* the file that was opened, if it is not the input but names that as the one
                             with the coordinates (XDMF); data NULL: the input is it */
    char **beside;     /* [n_beside] names of other files that the file that was opened has, from
                             its folder; the input is the first where there is a document. Owned */
    int64_t n_beside, beside_capacity;
    io_edits input_names; /* places in the document where it names the input, without text */
    io_bytes packed;      /* the input as the folder has it, packed by gzip; data NULL: as it is */
    int64_t largest_copy; /* files of more bytes are mapped (bytes.h) */
    int is_binary;        /* errors name bytes, not lines (io_fail_at) */
    int threads;          /* ask io_model_threads */
    long process;         /* the process that has them (pl_process_number); 0: any */
    double flatness; /* how far off their plane nodes may be, of the diagonal; 0: by the digits */
    int is_isolated; /* the HDF5 library is to be called where its crash does no harm (child.h) */
    planish_precision
        precision;        /* PLANISH_PRECISION_FLOAT: values are rounded to float; _ROUNDED: to
                                    field_width characters */
    int field_width;      /* of the narrowest field of a coordinate */
    io_exponent exponent; /* of coordinates in such fields; */
    char exponent_letter; /* its letter, if all have one */
    int columns;          /* coordinates of a node in the file: 2, or 3 by default */
    int64_t n_nodes;
    double *xyz;          /* [n_nodes][3] (z = 0 where columns is 2); NULL once it is known that the
                             mesh is in the plane of x and y */
    double *z;            /* [n_nodes] of such a mesh, or NULL: 0 */
    int64_t *node_number; /* [n_nodes] the file's numbers, or NULL: consecutive */
    int64_t first_number; /* of the nodes if node_number is NULL; 0 by default */
    struct io_numbers *numbers; /* from node_number to indices while the file is read, or NULL */
    io_span *span;              /* [n_spans] */
    int64_t n_spans, span_capacity;
    int64_t *text_offset; /* [n_nodes] byte of the first coordinate of nodes of text spans; or NULL:
                             there are none. Where components stand apart (io_span.component):
                             [columns][n_nodes], see io_text_place */
    int32_t *place_node; /* [n_places] node of each place in the file; NULL: nodes are places. Spans
                            and text_offset are of places */
    int64_t n_places;    /* with place_node */
    double
        *place_across; /* [n_places] of a mesh in a plane: the coordinate across it, where places of
                             one node differ in that; else NULL */
    uint8_t *hold;     /* [n_nodes] bits IO_HELD_... */
    int32_t *node_entity; /* [n_nodes] entity of the node (Medit: reference), or NULL. First it may
                             hold tags, as io_cells.entity may */
    int32_t *periodic;    /* [n_periodic][2] pairs of periodic nodes, indices */
    int64_t n_periodic, periodic_capacity;
    io_cells line, triangle, tetrahedron; /* in no order that means anything */
    io_entity *entity;                    /* [n_entities] */
    int32_t n_entities;
    int64_t entity_capacity;
    int32_t *entity_slot; /* [n_slots] hash table of the entities: index or -1 */
    int32_t n_slots;      /* a power of two, or 0 */
    pl_hash entity_hash;
    io_group *group; /* [n_groups] */
    int64_t n_groups, group_capacity;
    int groups_by_name; /* numbers of entities and groups are none of the file's (Abaqus) */
    int32_t *twin;      /* [n_twins] the file's numbers of groups that have planish's (twins.h), */
    int64_t n_twins, twin_capacity, first_twin; /* which go from first_twin on */
    io_names
        strange_groups; /* names in the file that are no groups, though they look so (*SURFACE) */
    uint8_t *supported; /* [n_nodes] 1: a boundary condition names the node, and holds it not; NULL:
                                none does */
    io_names supported_group; /* names of the groups that boundary conditions name */
    io_names included_name;   /* of the files in included, as the input names them */
    io_names not_carried;     /* what no conversion carries over: keywords, cards */
    io_type_name *type_name;  /* [n_type_names] each once, of the elements that are read (Abaqus) */
    int64_t n_type_names, type_name_capacity;
    int has_normals;                 /* the file has normals of nodes, which stay as they are */
    io_others flat, solid;           /* of two and of three dimensions */
    const io_node_order *node_order; /* of the format, ended by a row of type 0; NULL: VTK's */
    int64_t n_other, n_lower;        /* elements that are not kept; lines, points and facets */
    int lower_are_held; /* elements of lower dimension hold their nodes already, as far as they do */
    io_array *array;    /* [n_arrays] arrays that may tell regions, in the file's order */
    int n_arrays;
    int64_t array_capacity;
    io_data *data; /* [n_data] arrays of data, in the file's order */
    int64_t n_data, data_capacity;
    io_order data_order;      /* of those that are not more of others */
    int has_entities;         /* of the elements: the file's own, which arrays add to */
    int arrays_are_gone;      /* their values have been released */
    const char **array_name;  /* [n_arrays + 1] their names, and NULL; owned, or NULL */
    const char **region_name; /* [n_arrays + 1] names of those that tell regions, and NULL; owned,
                                 or NULL */
    void *of_format; /* own state of the format that has read it, or NULL: how coordinates stand in
                        the file where no span says so. io_format.field, encode and amend may use
                        it; release frees it */
    /* Set by io_model_finish: */
    int dim;             /* 3 of solids, and of flat elements that lie in no plane: a surface */
    double *coordinates; /* [n_nodes][dim] as read; in 3-D this is xyz itself */
    io_plane plane;      /* in 2-D */
    double *uv_read;     /* [n_nodes][2] coordinates as read, in a tilted plane, else NULL */
    int32_t *corner; /* [n_corners][3] there, of a mesh with quadrilaterals: triangles, and those
                            of the corners of quadrilaterals; else NULL */
    int64_t n_corners;
    int written; /* columns that are written: 2 in the plane of x and y, else 3 */
} io_model;

/** Return where the coordinates of a node (a place, with place_node) that stand in a text span begin:
 *  a byte of the input. */
static inline int64_t io_text_place(const io_model *model, const io_span *span, int64_t node) {
    const int64_t n = model->place_node ? model->n_places : model->n_nodes;
    return model->text_offset[span->component * n + node];
}

/** Return how many coordinates of each node a span has that are written. */
static inline int io_span_written(const io_model *model, const io_span *span) {
    const int n = model->written > span->component ? model->written - span->component : 0;
    return span->n_components > 0 && span->n_components < n ? span->n_components : n;
}

/** Whether the model is from before a fork: this process has none of its threads. */
int io_model_is_inherited(const io_model *model);

/** Return the number of threads to use: one after a fork, as libgomp would wait for those that are no
 *  more. */
int io_model_threads(const io_model *model);

/* ---- for the readers (what they return: see the top of this file) --------------------------- */

/** Note how many threads may work on the model, in this process. */
void io_model_set_threads(io_model *model, int threads);

/** Allocate the arrays of n_nodes nodes: xyz, hold (zeroed), text_offset if text. The reader has
 *  already checked that the file is large enough for that many. */
int io_model_alloc_nodes(io_model *model, int64_t n_nodes, int text, planish_error *error);

/** Note a run of nodes behind the others. */
int io_model_span(io_model *model, io_span span, planish_error *error);

/** Put the runs in the order of the file. */
void io_model_sort_spans(io_model *model);

/** Make n nodes whose coordinates stand at at, size bytes (4, 8) each, a node every stride bytes;
 *  note their place and their precision. Binary if model->is_binary (set it first), else text: then
 *  stride, swapped and at do not matter. size 4: values are floats, in text too. */
int io_model_make_nodes(io_model *model, int64_t n, int size, int64_t stride, int swapped,
                        const char *at, planish_error *error);

/** Note a pair of periodic nodes. */
int io_model_pair(io_model *model, const int32_t pair[2], planish_error *error);

/** Return the cells of that dimension, 1 .. 3. */
static inline io_cells *io_model_cells(io_model *model, int dim) {
    return dim == 3 ? &model->tetrahedron : dim == 2 ? &model->triangle : &model->line;
}

/** Return the other elements of that dimension, 2 or 3. */
static inline io_others *io_model_others(io_model *model, int dim) {
    return dim == 3 ? &model->solid : &model->flat;
}

/** Return the dimension of the elements that are smoothed: 3 where there is a solid one, else 2. All
 *  have been read. */
static inline int io_model_dim(const io_model *model) {
    return model->tetrahedron.n > 0 || model->solid.n > 0 ? 3 : 2;
}

/** Whether a finished model is a surface in space: flat elements that lie in no plane. */
static inline int io_model_is_surface(const io_model *model) {
    return model->dim == 3 && io_model_dim(model) == 2;
}

/** The elements that are smoothed are the simplices of their dimension, and behind them the others.
 *  Return the simplices, */
static inline const io_cells *io_model_elements(const io_model *model) {
    return io_model_dim(model) == 3 ? &model->tetrahedron : &model->triangle;
}

/** the others, */
static inline const io_others *io_model_other_elements(const io_model *model) {
    return io_model_dim(model) == 3 ? &model->solid : &model->flat;
}

/** and the number of both. */
static inline int64_t io_model_n_elements(const io_model *model) {
    return io_model_elements(model)->n + io_model_other_elements(model)->n;
}

/** Return the number in the file of an element, of both. */
int64_t io_element_number(const io_model *model, int64_t element);

/* Lists of elements: lines, triangles and tetrahedra by their dimension, then other elements of two
 * and of three dimensions. */
enum { IO_FIRST_LIST = 1, IO_FLAT_LIST = 4, IO_SOLID_LIST = 5, IO_N_LISTS = 6 };

/** The arrays of a list, as far as lists have the same; of cells or of others. */
typedef struct io_list {
    int dim;
    int64_t n;
    int32_t *entity, *region;
    const io_cells *cells;   /* or NULL */
    const io_others *others; /* or NULL */
} io_list;

/** Return the list of that number; its arrays are borrowed. */
io_list io_model_list(const io_model *model, int list);

/** Return where the regions of the list of that number are: [n] owned, or NULL. */
int32_t **io_model_regions(io_model *model, int list);

/** Let the lines, and in a mesh of solid elements (dim 3) the facets, hold their nodes. A reader calls
 *  it where facets that it adds later hold none (lower_are_held); else it is called in the end. */
void io_model_hold_lower(io_model *model, int dim);

/** Return the number of the list that has the other elements of a dimension, 2 or 3. */
static inline int io_others_list(int dim) {
    return dim == 3 ? IO_SOLID_LIST : IO_FLAT_LIST;
}

/** Return the number in the file of element i of a list. */
int64_t io_list_number(const io_list *list, int64_t i);

/** Find the nodes of element i of a list in VTK's order, -1: a mid that is missing. Else as
 *  io_list_nodes. */
int io_list_all_nodes(const io_list *list, int64_t i, int32_t *node, int *corners);

/** Find the nodes of element i of a list, mids that are there among them: node [IO_CELL_NODES].
 *  Return how many; *corners (may be NULL): the first of them are corners. */
int io_list_nodes(const io_list *list, int64_t i, int32_t *node, int *corners);

/** Make room for n more cells of a dimension; the reader then writes nodes, entity, number at index
 *  cells->n ...; and raises cells->n. with_entity and with_number must be the same in every call
 *  for the same cells. Errors: _FORMAT (too many), _MEMORY. */
int io_cells_reserve(io_model *model, int dim, int64_t n, int with_entity, int with_number,
                     planish_error *error);

/** Add a cell of nodes [dim + 1] behind the others, which have entities and numbers. Errors: as
 *  io_cells_reserve. */
int io_cells_add(io_model *model, int dim, const int32_t *nodes, int32_t entity, int64_t number,
                 planish_error *error);

/** Make room for the mids of all cells of a dimension that io_cells_reserve has made room for. They
 *  are missing until io_cells_set_mids is called. Errors: _MEMORY. */
int io_cells_reserve_mids(io_model *model, int dim, planish_error *error);

/** Set the mids of a cell, for which there is room, from all nodes [corners + mids] of an element of
 *  second order: indices in the format's order (model->node_order), the corners as cells->nodes has
 *  them; a mid of -1 is missing. Where corners are not the first nodes they are set, too. Threads may
 *  set different cells at the same time. */
void io_cells_set_mids(io_model *model, int dim, int64_t cell, const int32_t *nodes);

/** Add an element of a type behind the cells of its dimension: its nodes as for io_cells_add, with
 *  mids as for io_cells_set_mids. type: PLANISH_CELL_LINE, _LINE3 .. _TETRAHEDRON10. Errors: as
 *  io_cells_reserve. */
int io_model_add_simplex(io_model *model, int type, const int32_t *nodes, int32_t entity,
                         int64_t number, planish_error *error);

/** Add an element of a type to the others of its dimension: its nodes, indices in the format's order,
 *  and its entity, or IO_NO_ENTITY: none of the list has one. Types below two dimensions, and 0, are
 *  passed over. Errors: _FORMAT (too many), _MEMORY. */
int io_model_add_other(io_model *model, int type, const int32_t *nodes, int32_t entity,
                       int64_t number, planish_error *error);

enum { IO_NO_ENTITY = -1 };

/** Make room for n more other elements of a dimension, of n_nodes nodes together; the reader then
 *  sets them by io_others_set, and entity where with_entity, and raises n and n_nodes. Errors: as
 *  io_model_add_other. */
int io_others_reserve(io_model *model, int dim, int64_t n, int64_t n_nodes, int with_entity,
                      planish_error *error);

/** Set element i of the others of its type's dimension, as io_model_add_other does, but for its
 *  entity; its nodes begin at node[begin], behind those of the element before. Threads may set
 *  different elements at the same time. */
void io_others_set(io_model *model, int64_t i, int64_t begin, int type, const int32_t *nodes,
                   int64_t number);

/** Find the index of the entity (dim, tag, physical[n]), made if new; negative on failure. */
int32_t io_model_entity(io_model *model, int dim, int32_t tag, int n_physical,
                        const int32_t *physical, planish_error *error);

/** Forget the entities of elements. Those of nodes, which come first, stay. */
void io_model_clear_entities(io_model *model);

/** Return whether there is an entity of dim and tag without physical groups. */
int io_model_has_entity(const io_model *model, int dim, int32_t tag);

/** Replace tags [n], which io_cells.entity or node_entity holds until then, by the entities of dim
 *  that have them, made if new. */
int io_model_index_tags(io_model *model, int dim, int32_t *tags, int64_t n, planish_error *error);

/** Replace tags in the same way, but none by -1: it has no entity. */
int io_model_index_tags_but(io_model *model, int dim, int64_t none, int32_t *tags, int64_t n,
                            planish_error *error);

/** Note what no conversion carries over, if is_there. */
int io_model_note_lost(io_model *model, int is_there, const char *what, planish_error *error);

/** Note a named group behind the others. */
int io_model_group(io_model *model, int dim, int32_t tag, const char *name, int64_t length,
                   planish_error *error);

/** Return the file's number of groups that the model knows by a number. */
static inline int32_t io_model_file_number(const io_model *model, int32_t number) {
    const int64_t i = number - model->first_twin;
    return i >= 0 && i < model->n_twins ? model->twin[i] : number;
}

/** Note an edit behind all others; text is taken over, and released on failure, too. */
int io_edits_add(io_edits *edits, io_edit edit, planish_error *error);
/** Release all edits. */
void io_edits_destroy(io_edits *edits);

/** Table from the file's node numbers to indices, for files whose numbers are not 1 .. n. */
typedef struct io_numbers io_numbers;
/** Make a table of numbers [n], of nodes or other things, in the file at path; any order, any
 *  gaps. Fail with _FORMAT on a number that occurs twice. */
int io_numbers_create(const char *path, const char *what, const int64_t *numbers, int64_t n,
                      io_numbers **table, planish_error *error);
/** Keep the numbers that nodes have been given only where they say more than the first: not if each
 * is one more than that before. Make the table of those that are kept, for io_node_index. A node
 * that is given again with the same coordinates becomes one (place_node), at other ones it is an
 * error; no array of nodes but xyz, hold and node_number may be there yet. */
int io_reduce_node_numbers(io_model *model, planish_error *error);
/** Make one node of each place that first [n_nodes] (taken over) has for itself, and of all that have
 *  that place, which stand behind it: place_node. No array of nodes but xyz, hold and node_number may be
 *  there yet. */
void io_unite_places(io_model *model, int32_t *first);
/** Make one node of all that stand at the same place (place_node), for files that give each element
 *  its points; no array of nodes but xyz and hold may be there yet. Error: _MEMORY. */
int io_weld_nodes(io_model *model, planish_error *error);
/** Keep the numbers of cells in the same way, without a table. */
void io_reduce_cell_numbers(io_cells *cells);
/** Return the index of number, or -1. */
int64_t io_numbers_find(const io_numbers *table, int64_t number);
/** Release the table; NULL is none. */
void io_numbers_destroy(io_numbers *table);

/** Return the number in the file of node i. */
static inline int64_t io_node_number(const io_model *model, int64_t i) {
    return model->node_number ? model->node_number[i] : model->first_number + i;
}
/** Return the number in the file of cell i. */
static inline int64_t io_cell_number(const io_cells *cells, int64_t i) {
    return cells->number ? cells->number[i] : cells->first_number + i;
}

/** Return the index of the node with that number in the file, or -1. Where nodes have numbers of
 *  their own these are reduced. */
static inline int64_t io_node_index(const io_model *model, int64_t number) {
    if (model->numbers)
        return io_numbers_find(model->numbers, number);
    /* unsigned: a number far below first_number must not overflow */
    const uint64_t index = (uint64_t)number - (uint64_t)model->first_number;
    return index < (uint64_t)model->n_nodes ? (int64_t)index : -1;
}

/** Return the file that was opened: the input, or the document that names it. */
static inline const io_bytes *io_model_opened(const io_model *model) {
    return model->document.data ? &model->document : &model->input;
}

/** Return the end of the input: behind its last byte. */
static inline const char *io_input_end(const io_model *model) {
    return model->input.data + model->input.size;
}

/** Release the arrays of cells; NULL then. */
void io_cells_release(io_cells *cells);

/** Release the arrays of others; there are none then. */
void io_others_release(io_others *others);

/** Release all that the model owns. */
void io_model_destroy(io_model *model);

/* ---- checks and errors --------------------------------------------------------------------- */

/** Fail with _FORMAT at a place of the file: "FILE:LINE: text", lines counted from the start, or
 *  "FILE: byte N: text" where model->is_binary. error may be NULL: then nothing is written. */
int io_fail_at(const io_model *model, const char *at, planish_error *error, const char *format, ...)
    PL_PRINTF(4, 5);
#ifdef __clang_analyzer__ /* as for pl_fail */
#define io_fail_at(...) ((io_fail_at)(__VA_ARGS__), PLANISH_ERROR_FORMAT)
#endif

/** Check a declared count before anything is allocated: n things of size bytes each at least must
 *  fit into rest, where the first of them stands. In text the last byte of the last thing may be
 *  missing, as nothing need follow its last number. what: the things, for the message. For nodes
 *  and elements call io_check_count. */
int io_check_room(const io_model *model, io_cursor rest, int64_t n, int64_t size, const char *what,
                  planish_error *error);

/** Check the same as io_check_room, and that n is at most INT32_MAX, as planish numbers nodes and
 *  elements by 32 bits: the error names the place of the count. */
int io_check_count(const io_model *model, io_cursor rest, int64_t n, int64_t size, const char *what,
                   planish_error *error);

/** Fail with _FORMAT at a place: element, which the format calls what, has a node of that number,
 *  and the file has none such. */
int io_fail_no_node(const io_model *model, const char *at, const char *what, int64_t element,
                    int64_t node, planish_error *error);

/** Why elements of third order are refused, as a format string without arguments. */
#define IO_OF_THIRD_ORDER                                                                          \
    "elements of third order or higher cannot be smoothed; export the mesh with elements of "      \
    "first or second order"

/** Fail with _FORMAT at a place: what is an element of third order or higher, of which planish
 *  would move the corners alone. remedy: " (how to do so)", or "". */
int io_fail_order(const io_model *model, const char *at, const char *what, const char *remedy,
                  planish_error *error);

/** Fail as io_check_finite does. */
int io_fail_infinite(const io_model *model, int64_t node, const char *at, planish_error *error);

/** Check that a coordinate of node, which stands at at, is finite: the error names the node by its
 *  number, and the place. */
static inline int io_check_finite(const io_model *model, double value, int64_t node, const char *at,
                                  planish_error *error) {
    return isfinite(value) ? PLANISH_OK : io_fail_infinite(model, node, at, error);
}

#endif
