/* abaqus_sets: what sets of nodes and elements are, for abaqus_sets.c and abaqus_groups.c. */
#ifndef PL_IO_ABAQUS_ABAQUS_SETS_H
#define PL_IO_ABAQUS_ABAQUS_SETS_H

#include "io/abaqus/abaqus.h"

/** Things that sets have: nodes; or cells, first lines, then triangles, then tetrahedra. */
typedef enum set_kind { NODES, ELEMENTS } set_kind;

typedef struct named_set {
    set_kind things;
    int32_t scope; /* that the name is of, as of blocks */
    abaqus_span name;
    int32_t *member; /* [n] owned */
    int64_t n, capacity;
    int32_t last_into;          /* 1 + the set that it was put into last, */
    int64_t last_n;             /* and with how many members */
    int is_held, is_of_section; /* its members have been told so */
} named_set;

typedef struct sets {
    abaqus_reader *reader;
    named_set *set; /* [n_sets] */
    int64_t n_sets, capacity;
    int32_t *slot[2]; /* [n_slots] hash tables of the names: index or -1; of names with fold the
                         first set that has it */
    int64_t n_slots;
    int64_t n[2];          /* things: nodes, cells */
    int64_t first_cell[4]; /* of each dimension among the cells */
    int32_t *stamp[2];     /* [n] 1 + the set that had the thing last */
    io_numbers *elements;  /* the numbers of cells, made when they are wanted */
    int64_t n_asked; /* members that sequences and sets of sets asked for, those included that were
                        there already */
} sets;

/** Index of the set of that name in a scope, or of one that differs by the case of its letters; or
 *  -1. */
int32_t abaqus_find_set(const sets *s, set_kind things, int32_t scope, abaqus_span name);

/** Dimension of a cell; *local: its index among those. */
int abaqus_dim_of(const sets *s, int64_t cell, int64_t *local);

/** Entities of the things of a kind, by the sets that each is in; regions of cells. */
int abaqus_make_entities(sets *s, set_kind things);

/** A set is a group of each dimension that its members have. */
int abaqus_make_groups(sets *s);

#endif
