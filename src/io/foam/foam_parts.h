/* foam_parts: what the files of this folder share.
 *
 *   foam_file, foam_open, foam_close    a file of the mesh, behind its header
 *   foam_skip, foam_word, foam_value    tokens of a file
 *   foam_begin_list, foam_labels        lists
 *   foam_mesh, foam_make_cells          faces, and the elements that they enclose
 *   foam_sets, foam_read_patches ...    patches and zones
 */
#ifndef PL_IO_FOAM_FOAM_PARTS_H
#define PL_IO_FOAM_FOAM_PARTS_H

#include "io/core/folder.h"
#include "io/core/number.h"
#include "io/core/records.h"

/** A file: its bytes, and what its header says of them. */
typedef struct foam_file {
    io_folder_file of; /* of.view: for messages */
    io_cursor cursor;
    int swapped, label_size, scalar_size; /* of binary numbers, in bytes; */
    int is_label_known, is_scalar_known;  /* 0: usual ones, where the header does not say */
    io_slice class;                       /* of the list, as the file names it */
} foam_file;

/** The faces of the mesh. Owned arrays. */
typedef struct foam_mesh {
    io_model *model;
    int dim; /* 3, or 2 of a layer (foam_flatten) */
    int64_t n_faces, n_cells;
    int64_t *start;     /* [n_faces + 1] where the nodes of a face begin */
    int32_t *node;      /* their points: the face's normal leaves its owner */
    int32_t *owner;     /* [n_faces] cells */
    int32_t *neighbour; /* [n_faces]; -1: a face of the boundary */
    int32_t *thing;     /* [n_cells] element that a cell has become: index among the simplices, or
                           behind them among the others; -1: it holds its nodes */
    int32_t *base;      /* [n_cells] of two dimensions: face of a cell on the side whose points are
                           the nodes; else NULL */
} foam_mesh;

/** Return the node that a point is a place of. */
static inline int32_t foam_node(const foam_mesh *mesh, int32_t point) {
    return mesh->model->place_node ? mesh->model->place_node[point] : point;
}

/** Sets of faces, cells or points: patches, groups of patches, zones. */
typedef enum foam_things { FOAM_POINTS, FOAM_FACES, FOAM_CELLS, FOAM_N_THINGS } foam_things;

typedef struct foam_set {
    char *name; /* owned */
    foam_things things;
    int64_t first, n; /* these faces, */
    int32_t *member;  /* or [n] owned ones */
} foam_set;

/** A patch, as the file says. */
typedef struct foam_patch {
    io_slice name, type, neighbour; /* of the other side, if it is cyclic */
    io_slice groups;                /* the value of inGroups */
    int64_t first, n;               /* faces; -1: not said */
    const char *at;
} foam_patch;

typedef struct foam_patches {
    foam_file file;
    foam_patch *patch; /* [n] owned */
    int64_t n, capacity;
    int64_t n_behind; /* faces up to the last of the last patch */
} foam_patches;

typedef struct foam_sets {
    foam_set *set; /* [n] */
    int64_t n, capacity;
} foam_sets;

/* ---- files and tokens (foam_file.c) --------------------------------------------------------- */

/** Open the file called name and read its header, behind which the cursor stands. Without it (no data)
 *  it is an error if needed. */
int foam_open(io_model *model, const char *name, int needed, foam_file *f, planish_error *error);

/** Read the header at the cursor of f, whose view is there. */
int foam_read_header(foam_file *f, planish_error *error);

/** Release what the file has of its own. */
void foam_close(foam_file *f);

/** Skip white space and comments. */
void foam_skip(io_cursor *cursor);

/** Skip the same, fast where the next character is none of these. */
static inline void foam_skip_few(io_cursor *cursor) {
    while (cursor->at < cursor->end && *cursor->at == ' ')
        cursor->at++;
    if (cursor->at < cursor->end && (io_is_space(*cursor->at) || *cursor->at == '/'))
        foam_skip(cursor);
}

/** Take a whole number as io_parse_integer does, fast where it has no sign. */
static inline int foam_integer(io_cursor *cursor, int64_t *value) {
    enum { MOST_DIGITS = 18 };
    const char *at = cursor->at;
    int64_t number = 0;
    for (; at < cursor->end && *at >= '0' && *at <= '9'; at++) {
        if (at - cursor->at == MOST_DIGITS)
            return io_parse_integer(&cursor->at, cursor->end, value);
        number = 10 * number + (*at - '0');
    }
    if (at == cursor->at)
        return io_parse_integer(&cursor->at, cursor->end, value);
    cursor->at = at;
    *value = number;
    return 0;
}

/** Take the next token: one of ; { } ( ), a text in quotes, without these, or a word up to any of these. Empty at the
 *  end. */
io_slice foam_word(io_cursor *cursor);

/** Take a token that is to be text. Error: it is not. */
int foam_expect(foam_file *f, const char *text, planish_error *error);

/** Fail if a word begins a directive or names a macro, which are not read. */
int foam_check_word(const foam_file *f, io_slice word, planish_error *error);

/** Begin a list of entries, NAME { ... }, behind its number, if it has one: *n is that, or -1. */
int foam_begin_entries(foam_file *f, const char *what, int64_t *n, planish_error *error);

/** Take the name of entry i of such a list. Return 1, 0: the list has ended, or a negative status. */
int foam_next_entry(foam_file *f, const char *what, int64_t n, int64_t i, io_slice *name,
                    planish_error *error);

/** Skip a value of an entry: up to its ';', or the end of its block. */
int foam_skip_value(foam_file *f, planish_error *error);

/* ---- lists (foam_list.c) -------------------------------------------------------------------- */

/** Take the number of a list of things and its '(', behind which size bytes each are left at least (in
 *  text, where numbers are apart, as many for 2). Lists without any thing end with this. */
int foam_begin_list(foam_file *f, const char *what, int64_t size, int64_t *n, planish_error *error);

/** Take the ')' of a list. */
int foam_end_list(foam_file *f, const char *what, planish_error *error);

/** Read a list of labels, each one of first .. last: *labels [n] is owned. */
int foam_labels(foam_file *f, const char *what, int64_t first, int64_t last, int32_t **labels,
                int64_t *n, planish_error *error);

/** Read the points of the mesh, its nodes, from the model's input. */
int foam_read_points(io_model *model, planish_error *error);

/** Find a coordinate in text: io_format.field. */
int foam_field(const io_model *model, io_cursor *cursor, int d, io_field *field);

/* ---- faces and cells ------------------------------------------------------------------------ */

/** Read faces, owner and neighbour. mesh is to be released in any case. */
int foam_read_faces(foam_mesh *mesh, planish_error *error);

/** Release the arrays. */
void foam_release_mesh(foam_mesh *mesh);

/** Make elements of the cells that have the faces of one. Others hold their nodes. */
int foam_make_cells(foam_mesh *mesh, planish_error *error);

/** Make a mesh of two dimensions of one that is a layer of cells between empty patches: the points of
 *  both sides become nodes of one, and mesh->dim is 2. Else it stays as it is. */
int foam_flatten(foam_mesh *mesh, const foam_patches *patches, planish_error *error);

/* ---- patches and zones ---------------------------------------------------------------------- */

/** Read the patches of the boundary. To be released in any case. */
int foam_read_patches(const foam_mesh *mesh, foam_patches *patches, planish_error *error);

/** Hold the nodes of patches that must not move, add the sets of faces. */
int foam_use_patches(const foam_mesh *mesh, const foam_patches *patches, foam_sets *sets,
                     planish_error *error);

/** Release the patches. */
void foam_release_patches(foam_patches *patches);

/** Read the zones that are there. */
int foam_read_zones(const foam_mesh *mesh, foam_sets *sets, planish_error *error);

/** Make facets of the faces of the boundary and of zones; entities and groups of the sets. */
int foam_make_groups(const foam_mesh *mesh, const foam_sets *sets, planish_error *error);

/** Add a set behind the others, whose name is copied and whose members are taken over, on failure, too. */
int foam_add_set(foam_sets *sets, io_slice name, foam_set set, planish_error *error);

/** Release the sets. */
void foam_release_sets(foam_sets *sets);

#endif
