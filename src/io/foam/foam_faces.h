/* foam_faces: faces, and the cells on their sides. */
#ifndef PL_IO_FOAM_FOAM_FACES_H
#define PL_IO_FOAM_FOAM_FACES_H

#include "io/core/records.h"

/** The faces of the mesh. Owned arrays. */
typedef struct foam_mesh {
    io_model *model;
    int dim; /* 3, or 2 of a layer (foam_flatten) */
    int64_t n_faces, n_cells;
    int32_t *start;     /* [n_faces + 1] where the nodes of a face begin */
    int32_t *node;      /* their points: the face's normal leaves its owner */
    int32_t *owner;     /* [n_faces] cells */
    int32_t *neighbour; /* [n_listed], see foam_neighbour */
    int64_t n_listed;
    int32_t *thing; /* [n_cells] element that a cell has become: index among the simplices, or
                           behind them among the others; -1: it holds its nodes */
    int32_t *base;  /* [n_cells] of two dimensions: face of a cell on the side whose points are
                           the nodes; else NULL */
} foam_mesh;

/** Return the cell on the other side of a face; -1: it is of the boundary, as the last faces are, which
 *  only old files list as such. */
static inline int32_t foam_neighbour(const foam_mesh *mesh, int64_t face) {
    return face < mesh->n_listed ? mesh->neighbour[face] : -1;
}

/** Return the node that a point is a place of. */
static inline int32_t foam_node(const foam_mesh *mesh, int32_t point) {
    return mesh->model->place_node ? mesh->model->place_node[point] : point;
}

/** Read faces, owner and neighbour. mesh is to be released in any case. */
int foam_read_faces(foam_mesh *mesh, planish_error *error);

/** Release the arrays. */
void foam_release_mesh(foam_mesh *mesh);

#endif
