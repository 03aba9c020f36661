/* view: the content of a mesh file that planish understands, for the writers of other formats.
 *
 *   io_view, io_view_begin, io_view_end    the mesh
 *   io_view_cell, io_view_cell_at          its cells, one by one,
 *   io_view_distinct_region                and their regions
 *   io_view_fit_cell                       cells as a format has them
 *   io_view_place                          its nodes
 *   io_view_node_number, _cell_number      numbers that a file can have,
 *   io_view_are_numbers                    and whether it can have these
 *   io_view_fill_numbers, _distinct_...    free numbers
 *   io_view_find_type                      types of elements that a format has
 *   io_view_first_group, _next_group ...   named groups (view_groups.c)
 *   io_view_field                          arrays of numbers of nodes and elements
 *   io_losses_add, io_view_lose_...        what a writer leaves out
 *
 * Cells stand in this order: tetrahedra, triangles, lines, other solids, other flat elements.
 * A format that can be written has a function io_format.write, which gets a view.
 */
#ifndef PL_IO_VIEW_VIEW_H
#define PL_IO_VIEW_VIEW_H

#include "io/core/model.h"

enum {
    IO_VIEW_KINDS = 5,
    IO_VIEW_LOST_SIZE = 512,
    IO_VIEW_MOST_NAME = 256,       /* bytes of a name where each set of elements has it again */
    IO_VIEW_MOST_NUMBER = 99999999 /* the largest number of a node, element or property that all
                                      formats have room for */
};

/** An array of numbers that the file has for nodes or for elements. */
typedef struct io_view_field {
    const char *name;
    int of_elements;
    int width;      /* numbers of a value, 1 .. 9: as planish_data.n_components */
    int is_integer; /* values are whole numbers by their type, */
    int is_narrow;  /* and have 32 bits */
} io_view_field;

/** Read the values of a field: planish_data_free. */
typedef int io_view_load(void *file, const io_view_field *field, planish_data *data,
                         planish_error *error);

/** Number of a group. */
typedef struct io_view_key {
    int dim;
    int32_t tag, group;
} io_view_key;

/** A mesh to be written. Arrays are borrowed but for those of io_view_begin. */
typedef struct io_view {
    const io_model *model;
    const double *coordinates;              /* [n_nodes][written] */
    const planish_convert_options *options; /* its arrays may be NULL */
    int64_t first[IO_VIEW_KINDS + 1]; /* index of the first cell of each kind, and number of all */
    int64_t n_cells;
    int has_numbers[2];     /* nodes, cells: those of the file are distinct, and from 1 up */
    uint8_t shares_tags[4]; /* by dimension: regions are entities, and two have one tag */
    uint8_t is_mirrored[PLANISH_CELL_PYRAMID14 + 1]; /* by planish_cell_type: most solids of a type
                                                        have a negative volume */
    uint8_t *is_physical; /* [n_groups] entities have the group's tag among their physical ones, not
                             as their own; owned */
    io_view_key *key;     /* [n_groups] in the order of their numbers; owned */
    const io_view_field *field; /* [n_fields] */
    int n_fields;
    io_view_load *load;
    void *file; /* for load */
} io_view;

/** Begin a view of a mesh. To be ended in any case. Error: _MEMORY. */
int io_view_begin(const io_model *model, const double *coordinates,
                  const planish_convert_options *options, io_view *view, planish_error *error);
/** Release the memory of io_view_begin. */
void io_view_end(io_view *view);

/** A cell. */
typedef struct io_view_cell {
    int dim, type; /* planish_cell_type; elements without one of their mids are straight */
    int n_nodes;
    int loses_mids;              /* it has some, but not all */
    int32_t node[IO_CELL_NODES]; /* indices, in VTK's order */
    int32_t entity;              /* index, or -1 */
    int64_t region;              /* number that tells it: of the entity, or of regions by arrays */
    int64_t number;              /* the file's */
    int64_t element;             /* index in planish_file_cells; -1: it is of a lower dimension */
} io_view_cell;

/** Find cell index, 0 .. n_cells - 1. */
void io_view_cell_at(const io_view *view, int64_t index, io_view_cell *cell);

/** Return the number of a cell's region; where regions share numbers, that of its entity from 1 (none: 0). */
int64_t io_view_distinct_region(const io_view *view, const io_view_cell *cell);

/** Find the place of a node, in space. */
void io_view_place(const io_view *view, int64_t node, double place[3]);

/** Return a number of a node, and of cell index, for formats that number from 1: the file's, or else
 *  in their order. */
int64_t io_view_node_number(const io_view *view, int64_t node);
int64_t io_view_cell_number(const io_view *view, int64_t index, const io_view_cell *cell);

/** Return whether numbers [n], which are sorted for that, are distinct and within 1 ..
 *  IO_VIEW_MOST_NUMBER. */
int io_view_are_numbers(int64_t *number, int64_t n);

/** Replace each 0 among numbers [n] by the smallest positive number that is none of them yet. Error:
 *  _MEMORY. */
int io_view_fill_numbers(int64_t *number, int64_t n, planish_error *error);

/** Replace numbers [n] that are not within 1 .. most by free ones; of several that are equal the first
 *  stays. Error: _MEMORY. */
int io_view_distinct_numbers(int64_t *number, int64_t n, int64_t most, planish_error *error);

/** Make what finds groups, for io_view_begin, and release it. Error: _MEMORY. */
int io_view_groups_begin(io_view *view, planish_error *error);
void io_view_groups_end(io_view *view);

/** Return the first group of a number, or -1. Several may have it. */
int32_t io_view_first_group(const io_view *view, int dim, int64_t tag);

/** Return the next group of the number of a group, or -1. */
int32_t io_view_next_of_number(const io_view *view, int32_t group);

/** Return how many numbers an entity (-1: none) may be in groups by, and the first group of number k of
 *  these, which it is in, or -1. */
int io_view_n_numbers(const io_view *view, int32_t entity);
int32_t io_view_group_at(const io_view *view, int32_t entity, int k);

/** Return the first group behind group after (-1: of all) that the cells or nodes of an entity (-1: none)
 *  are in, or -1. */
int32_t io_view_next_group(const io_view *view, int32_t entity, int32_t after);

/** Set the bytes of all groups that an entity is in. Bytes of groups of one number are to be equal. */
void io_view_mark_groups(const io_view *view, int32_t entity, uint8_t *mark);

/** Find the first group of the name of each: *first [n_groups], owned in any case. Error: _MEMORY. */
int io_view_find_names(const io_view *view, int32_t **first, planish_error *error);

/** Return how many bytes of a name to write where at most so many fit: no character of UTF-8 is cut. */
int io_view_name_length(const char *name, int most);

/** Write the group as "DIM:TAG NAME"; return snprintf's. */
int io_view_group_text(const io_model *model, int32_t group, char *text, size_t size);

/** Name and number of a type of elements in a format. */
typedef struct io_view_type {
    int type; /* planish_cell_type; 0: end of a table */
    const char *name;
    int number;
} io_view_type;

/** Make a cell one of a format: a solid of positive volume, if most of its type are either; the type
 *  that type (of io_view_find_type) says, without the other nodes; and the format's order of nodes,
 *  orders as io_model.node_order, or NULL. */
void io_view_fit_cell(const io_view *view, const io_view_type *type, const io_node_order *orders,
                      io_view_cell *cell);

/** List, in words, of data that a format cannot store. */
typedef struct io_losses {
    char text[IO_VIEW_LOST_SIZE];
    size_t length;
} io_losses;

/** Add to the list. */
void io_losses_add(io_losses *losses, const char *format, ...) PL_PRINTF(2, 3);

/** Note data that formats cannot store: names of groups and all but the first number of each element;
 *  the ends of names behind IO_VIEW_MOST_NAME; what '_' stands for in names of
 *  groups of a dimension and above; references of nodes in no named group; where elements have one
 *  number: these, groups of nodes and further groups; where they have one name: all these and ends;
 *  numbers of nodes and elements, where they are other ones than their
 *  order; arrays of numbers. */
void io_view_lose_groups(const io_view *view, io_losses *losses);
void io_view_lose_ends(const io_model *model, io_losses *losses);
void io_view_lose_quotes(const io_model *model, int first_dim, io_losses *losses);
void io_view_lose_references(const io_view *view, io_losses *losses);
void io_view_lose_further(const io_view *view, io_losses *losses);
void io_view_lose_others(const io_view *view, io_losses *losses);
void io_view_lose_numbers(const io_view *view, io_losses *losses);
void io_view_lose_fields(const io_view *view, io_losses *losses);

/** Return the row of a type in a format's table; if it has none, that of the type without nodes of
 *  faces, or that of the corners alone; NULL: the format has none of these. */
const io_view_type *io_view_find_type(const io_view_type *table, int type);

#endif
