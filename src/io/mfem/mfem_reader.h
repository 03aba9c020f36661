/* mfem_reader: declarations that the parts of the reader of MFEM's meshes share.
 *
 *   mfem.c            mfem_read: the sections, one after the other, and what is refused
 *   mfem_geometry.c   geometries of elements, and the orders of their nodes
 *   mfem_elements.c   lists of elements: mfem_read_list, mfem_add_elements
 *   mfem_nodes.c      curved meshes: mfem_read_space, mfem_read_nodes
 *
 * All functions return 0 or a negative planish_status with the error filled in, unless they say
 * something else.
 */
#ifndef PL_IO_MFEM_MFEM_READER_H
#define PL_IO_MFEM_MFEM_READER_H

#include "io/core/elements.h"
#include "io/core/part_numbers.h"
#include "io/core/records.h"

enum {
    MFEM_N_GEOMETRIES = 8,
    MFEM_MOST_CORNERS = 8,
    MFEM_MOST_EDGES = 12,
    MFEM_MOST_PARTS = 18, /* edges and quadrilaterals of a hexahedron */
    MFEM_NO_NODE = -1,
    MFEM_SEVERAL_NODES = -2 /* of a vertex: it has a node on each side of a seam */
};

/** A geometry of MFEM's. Nodes of second order stand in the order of this table: corners, edges,
 *  quadrilaterals, the inside. */
typedef struct mfem_geometry {
    uint8_t shape; /* io_shape */
    uint8_t dim, corners, n_edges, n_quadrilaterals;
    uint8_t n_inside; /* nodes inside an element of second order */
    uint8_t edge[MFEM_MOST_EDGES][2], quadrilateral[6][4];
} mfem_geometry;

/** Geometries by MFEM's numbers. */
extern const mfem_geometry mfem_geometries[MFEM_N_GEOMETRIES];

/** Return the number of nodes of a geometry in elements of that order. */
int mfem_count_nodes(const mfem_geometry *g, int order);

/** Order of nodes that is not VTK's, for io_model.node_order. */
extern const io_node_order mfem_node_orders[];

/** Elements, or boundary elements, as the file has them. */
typedef struct mfem_list {
    int64_t n;
    int dim;
    int stride;         /* vertices in each row: those of all elements, or MFEM_MOST_CORNERS */
    uint8_t *geometry;  /* [n] owned */
    int32_t *attribute; /* [n] owned */
    int32_t *vertex;    /* [n][stride] owned */
} mfem_list;

/** How the values of `nodes` belong to elements. */
typedef enum mfem_space {
    MFEM_STRAIGHT,      /* there are none: vertices are the nodes */
    MFEM_CONTINUOUS,    /* H1: a value for each vertex; of second order for edges, ... too */
    MFEM_DISCONTINUOUS, /* L2: each element has its own, in the order of a lattice */
    MFEM_BY_ELEMENT     /* each element has its own, in the order of mfem_geometry */
} mfem_space;

typedef struct mfem_reader {
    io_model *model;
    planish_error *error;
    io_text text;
    io_cursor cursor;
    int version, dim, columns; /* 10: v1.0 */
    int64_t named;             /* bytes of the names of all groups so far */
    mfem_list elements, boundary;
    int64_t n_vertices;
    int32_t *vertex_node; /* [n_vertices] owned: node, MFEM_NO_NODE or MFEM_SEVERAL_NODES. NULL: the
                             vertices are the nodes */
    mfem_space space;
    int order;           /* 1, 2 */
    int is_by_component; /* all x stand before all y */
    int pyramid_inside;  /* nodes inside a pyramid of second order */
    io_part_numbers edges, quadrilaterals;
    int32_t *part; /* [elements.n][MFEM_MOST_PARTS or fewer] owned: its edges and quadrilaterals, */
    int part_stride;
    int64_t n_used; /* vertices with a node */
} mfem_reader;

/** Nodes of the elements before one, of those that each element has of its own. */
typedef struct mfem_walk {
    int64_t inside; /* continuous: */
    int64_t own;    /* by element: all of them */
} mfem_walk;

/* ---- lists ---------------------------------------------------------------------------------- */

/** Read the records of a section of elements of dimension list->dim into a list. what: for messages. */
int mfem_read_list(mfem_reader *r, const io_section *section, const char *what, mfem_list *list);

/** Add the elements, or (is_boundary) the boundary elements, to the model. */
int mfem_add_elements(mfem_reader *r, const mfem_list *list, int is_boundary);

/** Release a list. */
void mfem_list_release(mfem_list *list);

/* ---- nodes ---------------------------------------------------------------------------------- */

/** Read the coordinates of n nodes in the order that r->is_by_component says; the cursor ends behind
 *  them. */
int mfem_read_coordinates(mfem_reader *r, int64_t n, const char *what);

/** Read the head of `nodes`, up to its values. */
int mfem_read_space(mfem_reader *r);

/** Read the nodes of a curved mesh, whose lists have been read. */
int mfem_read_nodes(mfem_reader *r);

/** Find the nodes of element i, one after the other, in the order of mfem_geometry. Return how many. */
int mfem_element_nodes(const mfem_reader *r, int64_t i, mfem_walk *walk, int32_t *nodes);

/** Find the nodes of boundary element i. Return how many, or 0: some corner has several nodes. */
int mfem_boundary_nodes(const mfem_reader *r, int64_t i, int32_t *nodes);

/** Hold the nodes on edges and quadrilaterals of elements whose corners are all held in the file. */
void mfem_hold_mids(mfem_reader *r);

#endif
