/* exodus_mesh: blocks, sets and data of a mesh that is written as an Exodus file.
 *
 *   exodus_mesh, exodus_mesh_make, _release    blocks, sets and components of data
 *   exodus_next_cell, _next_number             elements of a block
 *   exodus_name_block, exodus_has_values       its name, and whether it has data
 */
#ifndef PL_IO_EXODUS_EXODUS_MESH_H
#define PL_IO_EXODUS_EXODUS_MESH_H

#include "io/exodus/exodus_groups.h"

/* Room for a name, as the Exodus library says, and for that of a type. */
enum {
    EXODUS_MOST_NAME = 256, /* bytes of a name with what is added to it, */
    EXODUS_CUT_NAME = 240,  /* and of the name itself: longer ones are cut */
    EXODUS_TYPE_NAME = 16
};

/** A block that is written. */
typedef struct exodus_out_block {
    const io_view_block *of;
    const io_view_type *type;
    char type_name[EXODUS_TYPE_NAME];
    int64_t n;     /* elements: all of the block, but facets that are sides */
    int64_t facet; /* index of its first facet; -1: it is none of facets */
    int32_t group; /* that it is called by, or -1, */
    int is_first;  /* which no block before it is */
    int32_t id;
    int dim; /* of the file: its elements */
} exodus_out_block;

/** A component of a field, which is a variable. */
typedef struct exodus_component {
    const io_view_field *field;
    int at;             /* of the values */
    const char *suffix; /* of its name */
} exodus_component;

/** Blocks, sets and components of a view as they are written. */
typedef struct exodus_mesh {
    const io_view *view;
    io_view_blocks blocks;
    exodus_facets facets;
    exodus_groups sets[2];   /* of nodes; of sides */
    exodus_out_block *block; /* [n_blocks] owned */
    int64_t n_blocks;
    int64_t n_elements;
    exodus_component *component[2]; /* of nodes; of elements: [n_components] owned */
    int64_t n_components[2];
    int64_t component_capacity[2];
    int columns;        /* coordinates of a node: 2 in the plane of x and y, else 3 */
    int has_numbers[2]; /* nodes, elements: other ones than 1, 2, ... */
    int64_t name_size;  /* bytes of each name */
    int are_cut;        /* some names are */
} exodus_mesh;

/** Find the blocks, sets and components of a view, which must stay. To be released in any case. Error: _MEMORY. */
int exodus_mesh_make(const io_view *view, exodus_mesh *mesh, planish_error *error);
void exodus_mesh_release(exodus_mesh *mesh);

/** Find the next cell of a block that is an element of the file, from cell *i on. Returns 0 at the end. */
int exodus_next_cell(const exodus_mesh *mesh, const exodus_out_block *block, int64_t *i,
                     io_view_cell *cell);

/** Return the number of the next element of a block as exodus_next_cell finds it; 0 at the end. */
int64_t exodus_next_number(const exodus_mesh *mesh, const exodus_out_block *block, int64_t *i);

/** Make the name of a block: its group's, with its id if another block has that name; "" without. */
void exodus_name_block(const exodus_mesh *mesh, const exodus_out_block *block,
                       char name[EXODUS_MOST_NAME + 1]);

/** Return whether a block has values of elements: those of the mesh's dimension have. */
int exodus_has_values(const exodus_mesh *mesh, int64_t block);

#endif
