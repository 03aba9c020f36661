/* surface: the facets of a mesh that its shape is made of. Internal to shape: planes.h and lines.h
 * have what they make.
 *
 *   surface.c   pl_surface_create, _destroy           the facets
 *               pl_tags_sort, pl_tags_find            facets or edges that the caller has tagged
 *   wholes.c    facets of second order: wholes.h
 *   below       pl_same_label, pl_from_to, pl_length
 */
#ifndef PL_SHAPE_SURFACE_H
#define PL_SHAPE_SURFACE_H

#include "geometry/simplex.h"

#include <planish/planish.h>

#include <math.h>
#include <stdint.h>

/* ---- the facets --------------------------------------------------------------------------- */

/** Facet or edge that the caller has tagged. */
typedef struct pl_tagged {
    int32_t node[4]; /* ascending; -1 at the end if there are fewer */
    int32_t tag;
    uint8_t is_met; /* the surface has it */
} pl_tagged;

typedef struct pl_tags {
    pl_tagged *item; /* [n] ascending by nodes */
    int64_t n;
} pl_tags;

/** Sort the nodes of every item, then the items. An item with two tags keeps the lower one. */
void pl_tags_sort(pl_tags *tags);

/** Find the item with these nodes [4]; NULL: there is none. */
pl_tagged *pl_tags_find(const pl_tags *tags, const int32_t *node);

/** Regions on both sides of a facet, and its tag: the shape has an edge where these change. */
typedef struct pl_label {
    int32_t n_elements; /* 1: of the boundary, 2: between elements, more: of a tangle; 0: it is an
                           element itself, of a mesh without solids */
    int32_t region[2];  /* of the first two elements, ascending; the same twice on the boundary */
    int32_t is_tagged, tag;
} pl_label;

/** Facets: triangles of solid elements, or edges of flat ones; quadrilaterals are two triangles. Their
 *  nodes have own numbers, 0 .. n_nodes - 1, ascending with the mesh's numbers. */
typedef struct pl_surface {
    int dim;
    int64_t n_nodes, n_facets;
    int32_t *node;   /* [n_nodes] the mesh's numbers */
    double *x;       /* [n_nodes][dim] their coordinates, scaled by a power of two to about 1 */
    int32_t *facet;  /* [n_facets][dim] by own numbers, ascending */
    pl_label *label; /* [n_facets] */
    int32_t *apex; /* [n_facets] in 3-D: another node (the mesh's number) of an element at it, which
                        is that of the lower region, of ~apex that of the higher one; of a facet that is
                        an element 1: its nodes are listed the other way round, 0: as in facet */
    uint8_t *half; /* [n_facets] 1 and then 2: halves of a quadrilateral; 0: whole. NULL: all are */
    int64_t *offset;   /* [n_nodes + 1] into facet_of */
    int32_t *facet_of; /* the facets of each node, ascending */
    double size;       /* diagonal of the bounding box */
    double scale;      /* of x: x is that times the mesh's coordinates */
    int32_t *number;   /* [nodes of the mesh] own number, -1: not on the surface */
    struct pl_whole
        *whole; /* [n_wholes] if some facets are of second order all of them, divided (wholes.h);
                               else NULL */
    int64_t n_wholes;
    int64_t n_mids;
    int32_t (*mid)[3]; /* [n_mids] of these facets' edges both ends and the mid, ascending */
} pl_surface;

/** Whether cells has elements of dimension dim - 1, and none of dimension dim. */
int pl_is_of_faces(const planish_cells *cells, int dim);

/** Why a node of the surface is fixed. */
enum {
    PL_FIXED_ALWAYS = 1, /* in any case */
    PL_FIXED_UNLESS_CURVED =
        2 /* it may slide on a curved shape only: of a quadrilateral that is not planar */
};

/** Find the facets of one element, those between regions, and the tagged ones. cells: elements, and
 *  tags->region goes by them; NULL: those of mesh. is_fixed [nodes of the mesh] becomes
 *  PL_FIXED_ALWAYS for corners of tagged facets that the mesh has not. Errors: _MEMORY. */
int pl_surface_create(const planish_mesh *mesh, const planish_cells *cells,
                      const planish_surface *tags, int threads, pl_surface *surface,
                      uint8_t *is_fixed, planish_error *error);

/** Free the arrays of surface. */
void pl_surface_destroy(pl_surface *surface);

/** Whether two facets have the same label. */
static inline int pl_same_label(const pl_label *a, const pl_label *b) {
    return a->n_elements == b->n_elements && a->region[0] == b->region[0] &&
           a->region[1] == b->region[1] && a->is_tagged == b->is_tagged && a->tag == b->tag;
}

/* ---- vectors ------------------------------------------------------------------------------- */

/** Compute b - a of dim numbers, the third 0 in 2-D. */
static inline void pl_from_to(int dim, const double *a, const double *b, double *v) {
    for (int d = 0; d < 3; d++)
        v[d] = d < dim ? b[d] - a[d] : 0;
}

/** Length of v [3]. */
static inline double pl_length(const double *v) {
    return sqrt(pl_dot(3, v, v));
}

#endif
