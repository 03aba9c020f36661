/* exodus_reader: declarations that the parts of the reader of Exodus II files share; for exodus*.c only.
 *
 *   exodus_reader, exodus_block    a file while it is read, and its blocks of elements
 *   exodus_take_node, _fail_node   numbers of nodes (exodus_labels.c)
 *   exodus_labels_...              numbers and names of blocks and sets (exodus_labels.c)
 *   exodus_read_blocks             elements (exodus_blocks.c)
 *   exodus_read_sets               node sets and side sets (exodus_sets.c)
 *   exodus_note_data, _read_data   variables (exodus_data.c)
 *
 * Blocks, sets, elements and nodes have a place, from 1, by which the file refers to them, and a
 * number ("id") for people.
 */
#ifndef PL_IO_EXODUS_READER_H
#define PL_IO_EXODUS_READER_H

#include "io/exodus/exodus_format.h"
#include "io/netcdf/netcdf.h"

/** Elements of one type, one after another. */
typedef struct exodus_block {
    int64_t first, n; /* the first element, from 0, and how many there are */
    int dim;
    int list;     /* of the model that they are in; 0: in none, they hold their nodes */
    int64_t at;   /* where the first one is there */
    int is_shell; /* sides 1 and 2 are its faces, the others its edges */
} exodus_block;

/** Numbers and names of blocks, or of sets of one kind. */
typedef struct exodus_labels {
    int64_t n;
    int32_t *number; /* [n] owned */
    netcdf_texts names;
} exodus_labels;

typedef struct exodus_reader {
    io_model *model;
    netcdf *file;
    planish_error *error;
    exodus_block *block; /* [n_blocks] owned */
    int64_t n_blocks, block_capacity;
    exodus_labels labels; /* of the blocks */
    int64_t n_elements;
    io_hdf5_integers numbers; /* [n_elements] of elements, or none: their places */
} exodus_reader;

/** Fail as exodus_take_node does. */
int exodus_fail_node(exodus_reader *r, const char *name, int64_t i, int64_t place,
                     planish_error *error);

/** Take number i of a list: the index of a node. Fails as a reader of records does. */
static inline int exodus_take_node(exodus_reader *r, const char *name, const io_hdf5_integers *list,
                                   int64_t i, int32_t *node, planish_error *error) {
    const int64_t place = io_hdf5_integer(list, i);
    *node = (int32_t)(place - 1);
    return place >= 1 && place <= r->model->n_nodes ? PLANISH_OK
                                                    : exodus_fail_node(r, name, i, place, error);
}

/** Read labels. Release in any case. */
int exodus_labels_read(exodus_reader *r, const char *numbers, const char *names,
                       exodus_labels *labels);
void exodus_labels_release(exodus_labels *labels);

/** Name the group of number i in a dimension, if it has a name. */
int exodus_labels_name(exodus_reader *r, const exodus_labels *labels, int64_t i, int dim);

/** Read all elements. */
int exodus_read_blocks(exodus_reader *r);

/** Read node sets and side sets, after the elements. */
int exodus_read_sets(exodus_reader *r);

/** Note the variables of nodes and elements, after all else. */
int exodus_note_data(exodus_reader *r);

/** Read the values of a variable at the first time step: for io_format. */
int exodus_read_data(io_model *model, const io_data *data, double *values, planish_error *error);

#endif
