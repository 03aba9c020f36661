/* xdmf_grids: the one mesh that the grids of an XDMF file are: pieces, of one or several geometries.
 *
 *   xdmf_geometry, xdmf_piece, xdmf_mesh
 *   xdmf_mesh_find, xdmf_mesh_release
 *
 * Grids of a spatial collection, and those beside one another in a domain, are pieces. Grids with the
 * same numbers as topology and geometry are one piece. Of a series in time all steps must be the
 * pieces of the first one.
 */
#ifndef PL_IO_XDMF_XDMF_GRIDS_H
#define PL_IO_XDMF_XDMF_GRIDS_H

#include "io/xdmf/xdmf_items.h"

/** Points, of one piece or several. */
typedef struct xdmf_geometry {
    int64_t element;
    int columns;                     /* coordinates of a node */
    int n_items;                     /* 1, or one for each component */
    xdmf_item item[XDMF_MOST_ITEMS]; /* [n_items] */
    int64_t first_node, n_nodes;     /* xdmf_nodes.c */
} xdmf_geometry;

typedef struct xdmf_piece {
    int64_t topology; /* element */
    int has_item;     /* it has a list of nodes: */
    xdmf_item item;
    int64_t geometry;
    xdmf_list grids;    /* elements that have it; owned */
    int64_t n;          /* cells that it lists (xdmf_cells.c); */
    int64_t first_cell; /* the number of the first one, or, if all are of a piece before it, */
    int64_t *map;       /* [n] numbers of all, owned; else NULL */
    int64_t n_of[4];    /* cells by dimension that are kept, without a map */
} xdmf_piece;

typedef struct xdmf_mesh {
    xdmf_geometry *geometry; /* [n_geometries] owned */
    int64_t n_geometries, geometry_capacity;
    xdmf_piece *piece; /* [n_pieces] owned */
    int64_t n_pieces, piece_capacity;
    int64_t n_cells; /* of all pieces */
} xdmf_mesh;

/** Find the pieces of the mesh, at least one. Release in any case. */
int xdmf_mesh_find(xdmf_reader *reader, xdmf_mesh *mesh);
void xdmf_mesh_release(xdmf_mesh *mesh);

#endif
