/* surface: the facets of a mesh that its shape is made of. Internal to shape.
 *
 * Nodes are numbered by themselves, 0 .. n_nodes - 1, ascending with the mesh's numbers. A facet is
 * a triangle of tetrahedra or an edge of triangles.
 */
#ifndef PL_SHAPE_SURFACE_H
#define PL_SHAPE_SURFACE_H

#include <planish/planish.h>

/** Regions on both sides of a facet, and its tag: the shape has an edge where these change. */
typedef struct pl_label {
    int32_t n_elements; /* 1: of the boundary, 2: between elements, more: of a tangle */
    int32_t region[2];  /* of the first two elements, ascending; the same twice on the boundary */
    int32_t is_tagged, tag;
} pl_label;

typedef struct pl_surface {
    int dim;
    int64_t n_nodes, n_facets;
    int32_t *node;     /* [n_nodes] the mesh's numbers */
    double *x;         /* [n_nodes][dim] their coordinates, scaled by a power of two to about 1 */
    int32_t *facet;    /* [n_facets][dim] by own numbers, ascending */
    pl_label *label;   /* [n_facets] */
    int64_t *offset;   /* [n_nodes + 1] into facet_of */
    int32_t *facet_of; /* the facets of each node, ascending */
    double size;       /* diagonal of the bounding box */
    int32_t *number;   /* [nodes of the mesh] own number, -1: not on the surface */
} pl_surface;

/** The facets of one element, those between regions, and the tagged ones. is_fixed [nodes of the
 *  mesh] becomes 1 for nodes of tagged facets that the mesh has not. Errors: _MEMORY. */
int pl_surface_create(const planish_mesh *mesh, const planish_surface *tags, int threads,
                      pl_surface *surface, uint8_t *is_fixed, planish_error *error);

/** Free the arrays of surface. */
void pl_surface_destroy(pl_surface *surface);

/** Whether two facets have the same label. */
static inline int pl_same_label(const pl_label *a, const pl_label *b) {
    return a->n_elements == b->n_elements && a->region[0] == b->region[0] &&
           a->region[1] == b->region[1] && a->is_tagged == b->is_tagged && a->tag == b->tag;
}

#endif
