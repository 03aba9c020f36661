/* large_meshes: lattices of as many elements as wanted, their inner nodes pushed at random.
 *
 *   large_mesh_create, _destroy
 */
#ifndef TEST_SUPPORT_LARGE_MESHES_H
#define TEST_SUPPORT_LARGE_MESHES_H

#include <planish/planish.h>

/** What lattices are made of. */
typedef enum large_kind {
    LARGE_TETRAHEDRA, /* mesh.elements, in a cube */
    LARGE_HEXAHEDRA,  /* mesh.cells, as the others */
    LARGE_QUADRATIC,  /* tetrahedra with straight mids */
    LARGE_BALL,       /* hexahedra in a ball, whose surface slides on its shape */
    N_LARGE_KINDS
} large_kind;

/** A mesh with its arrays. mesh.coordinates is x. */
typedef struct large_mesh {
    planish_mesh mesh;
    planish_cells cells;
    double *x; /* [n_nodes][3], owned as the others */
    int32_t *node;
    int64_t *offset;
    uint8_t *type, *constraint;
    double *direction;
    planish_shape *shape; /* of a ball, for planish_options.shape; else NULL */
    int side; /* nodes along a side of the lattice; node i + side (j + side k) is at i, j, k */
} large_mesh;

/** Make a mesh of about n elements, to be destroyed in the end. */
large_mesh *large_mesh_create(large_kind kind, int64_t n);
void large_mesh_destroy(large_mesh *mesh);

#endif
