/* subset: the elements around some nodes, as a mesh of its own. The cost of work on a subset
 * depends on the subset's size, not on the mesh's.
 *
 *   pl_subset_by_marks, pl_subset_destroy                  the elements of a subset (walk.h: of few nodes)
 *   pl_submesh_create, _destroy, pl_subset_find_node       the subset as a mesh
 */
#ifndef PL_TOPOLOGY_SUBSET_H
#define PL_TOPOLOGY_SUBSET_H

#include "topology/topology.h"

/** The elements that have a selected node (the mesh's first one if none has), and their nodes. */
typedef struct pl_subset {
    int64_t n_nodes, n_elements;
    int32_t *node;        /* [n_nodes] number in the mesh, ascending */
    int32_t *element;     /* [n_elements] likewise */
    int32_t *elements;    /* [n_elements][dim + 1] nodes by their numbers here */
    uint8_t *is_selected; /* [n_nodes] */
} pl_subset;

/** Find a subset by a pass over the mesh, which is dense: selected [n_nodes], not 0 for the nodes.
 */
int pl_subset_by_marks(const planish_mesh *mesh, const uint8_t *selected, int threads,
                       pl_subset *subset, planish_error *error);

/** Free the arrays of subset. */
void pl_subset_destroy(pl_subset *subset);

/** The subset as a mesh, with the fields of the mesh for its nodes and elements, without periodic
 *  pairs. The elements belong to the subset. */
typedef struct pl_submesh {
    planish_mesh mesh;
    double *coordinates, *direction, *min_volume; /* of the mesh, or NULL */
    uint8_t *constraint;
} pl_submesh;

/** Make the mesh of a subset of whole; elements stay subset's, mesh owns the rest. Errors: those of
 *  pl_points_check, _MEMORY. */
int pl_submesh_create(const planish_mesh *whole, const pl_subset *subset, int threads,
                      pl_submesh *mesh, planish_error *error);

/** Free the arrays of mesh. */
void pl_submesh_destroy(pl_submesh *mesh);

/** Number here of a node of the mesh, or -1. */
int64_t pl_subset_find_node(const pl_subset *subset, int64_t node);

#endif
