/* cgns_reader: declarations that the parts of the reader of CGNS files share; for cgns*.c only.
 *
 *   cgns_child, _children, _integers, _text    nodes of CGNS and their data (cgns_node.c)
 *   cgns_read_elements                         sections of elements
 *   cgns_read_groups                           boundary conditions, connections
 *
 * A node of CGNS is a group of HDF5 with a label that tells what it is; its data are the array
 * " data" in it. All functions return 0 or a negative planish_status, *reader->error filled in.
 */
#ifndef PL_IO_CGNS_CGNS_READER_H
#define PL_IO_CGNS_CGNS_READER_H

#include "io/hdf5/hdf5.h"
#include "io/core/records.h"

/** Elements of consecutive numbers. */
typedef struct cgns_section {
    const char *name;           /* in the zone */
    int64_t start, end;         /* numbers of the first and the last element */
    int type;                   /* of all elements, or MIXED */
    int64_t first[IO_N_LISTS];  /* by list: elements of this section in it, */
    int64_t behind[IO_N_LISTS]; /* up to this one */
} cgns_section;

typedef struct cgns_reader {
    io_model *model;
    io_hdf5 *file;
    planish_error *error;
    io_hdf5_path base, zone;
    cgns_section *section; /* [n_sections] owned, in the order of their elements' numbers */
    int64_t n_sections, capacity;
    int64_t n_elements;
} cgns_reader;

/* ---- cgns_node.c --------------------------------------------------------------------------- */

/** Return the path of the child called name of the node at path parent. */
io_hdf5_path cgns_child(cgns_reader *r, const io_hdf5_path *parent, const char *name);

/** List the names of the nodes in a node that have the label. */
int cgns_children(cgns_reader *r, const io_hdf5_path *path, const char *label,
                  io_hdf5_names *names);

/** Read the whole numbers of the node at path. Release in any case. */
int cgns_integers(cgns_reader *r, const io_hdf5_path *path, io_hdf5_integers *integers);

/** Read the text of the node called child in the node at path, without blanks at its end; "" if
 *  there is no such node. */
int cgns_text(cgns_reader *r, const io_hdf5_path *path, const char *child, char *text, size_t size);

/* ---- cgns_elements.c ----------------------------------------------------------------------- */

/** Read all sections of the zone: elements with their numbers, and as entity the index of their
 *  section. */
int cgns_read_elements(cgns_reader *r);

/* ---- cgns_groups.c ------------------------------------------------------------------------- */

/** Make entities and groups of sections and boundary conditions; hold the nodes where the zone is
 *  connected with itself. */
int cgns_read_groups(cgns_reader *r);

#endif
