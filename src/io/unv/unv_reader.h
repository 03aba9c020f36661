/* unv_reader: declarations that the parts of the reader of universal files share.
 *
 *   unv.c            datasets, the format
 *   unv_nodes.c      unv_read_nodes, unv_field: nodes, and their coordinate systems
 *   unv_elements.c   unv_find_runs, unv_read_elements: elements
 *   unv_groups.c     unv_make_entities: regions and groups
 *
 * All functions return 0 or a negative planish_status with the error filled in, unless said
 * otherwise.
 */
#ifndef PL_IO_UNV_UNV_READER_H
#define PL_IO_UNV_UNV_READER_H

#include "io/core/runs.h"

typedef enum unv_kind {
    UNV_NODES,      /* a line of numbers and a line of coordinates for each */
    UNV_NODE_LINES, /* both in one line, coordinates in fields of 13 */
    UNV_ELEMENTS,
    UNV_GROUPS,
    UNV_SYSTEMS,
    UNV_OLD_SYSTEMS,
    UNV_REFUSED
} unv_kind;

/** Kind of dataset that is read. */
typedef struct unv_dataset {
    int number;
    unv_kind kind;
    int words;                    /* elements: in the first line of each; groups: of an entry */
    int type, property, material; /* elements: which words have these; the last is the number of
                                      nodes */
} unv_dataset;

extern const unv_dataset unv_datasets[];

/** Orders of nodes that are not VTK's, for io_model.node_order. */
extern const io_node_order unv_node_orders[];

/** A coordinate system that is another than the global one. */
typedef struct unv_system {
    int64_t number;
    int is_curved; /* cylindrical or spherical */
} unv_system;

typedef struct unv_reader {
    io_model *model;
    planish_error *error;
    io_text text;
    io_sections sections; /* keyword: row of unv_datasets; count: lines that are not empty */
    unv_system *system;   /* [n_systems] owned, by number */
    int64_t n_systems, system_capacity;
    const unv_system *common;        /* that of all nodes, borrowed; NULL: the global one */
    io_sections runs;                /* of elements; keyword: row of types */
    const unv_dataset **run_dataset; /* [runs.n] owned: of each run */
    int64_t n_run_datasets, run_capacity;
    int64_t n_of_list[IO_N_LISTS];   /* elements by list */
    int64_t material;                /* of the first element, */
    int has_material, has_materials; /* if there is one; and others have another one */
    /* Of the section or run that is read: */
    const unv_dataset *dataset;
    int64_t first; /* node */
    int row;       /* of types */
    io_run run;
    int has_orientation; /* a line between that of numbers and the nodes, of beams */
} unv_reader;

/** Note the coordinate systems that a dataset defines. */
int unv_read_systems(unv_reader *r, const io_section *s);

/** Read the nodes of all datasets. */
int unv_read_nodes(unv_reader *r);

/** Find where a coordinate stands: io_format.field. */
int unv_field(const io_model *model, io_cursor *cursor, int d, io_field *field);

/** Find the runs of elements of one type in a dataset; elements of types that are not known hold
 *  their nodes. Nodes have been read. */
int unv_find_runs(unv_reader *r, const io_section *s);

/** Read the elements of all runs: properties become their tags. */
int unv_read_elements(unv_reader *r);

/** Read the groups, and make entities of properties, materials and groups. */
int unv_make_entities(unv_reader *r);

#endif
