/* making: a shape while it is made. Internal to shape.
 *
 *   create.c     pl_shape_create                    in the order of this list
 *   features.c   pl_features_match                  which facets meet at edges
 *                pl_features_orient                 facets turn the same way round
 *                pl_features_find                   features, patches, curves
 *   creases.c    pl_is_crease                       features by their bend
 *   bend.c       pl_shape_bend                      tangents and normals
 *   features.c   pl_features_settle                 nodes of patches
 *   bend.c       pl_shape_pack_normals              the normals that the shape keeps
 *   features.c   pl_features_count                  what is odd about it
 */
#ifndef PL_SHAPE_MAKING_H
#define PL_SHAPE_MAKING_H

#include "shape/curved.h"

/** Properties of an edge of a facet, from corner k to (k + 1) % 3. */
enum {
    PL_EDGE_FEATURE = 1,  /* of curves */
    PL_EDGE_APART = 2,    /* the shape's normals on both sides have nothing to do with each other */
    PL_EDGE_CREASE = 4,   /* a feature by its bend alone */
    PL_EDGE_CONFLICT = 8, /* its facets turn different ways round: a Moebius strip's */
    PL_EDGE_DIAGONAL = 16 /* of a quadrilateral */
};

/** A node of very many facets: those of pl_features.hub_facet from first to where the next hub's begin
 *  have all normals there. */
typedef struct pl_hub {
    int32_t node;
    int64_t first;
} pl_hub;

/** A shape under work. */
typedef struct pl_features {
    planish_shape *shape;
    const pl_surface *surface; /* what shape has not taken of it */
    const planish_surface *tags;
    int threads;
    int32_t (*beside)[3]; /* [n_facets] the other facet at each edge; -1: not exactly one */
    uint8_t (*kind)[3];   /* [n_facets] PL_EDGE_.. of each edge */
    uint8_t *stays;       /* [n_nodes] 1: it is a corner in any case */
    int32_t *n_ends;      /* [n_nodes] edges at each node */
    int64_t *n_features;  /* [n_nodes] feature edges at each node */
    pl_hub *hub;          /* [n_hubs + 1] ascending */
    int64_t n_hubs;
    int32_t *hub_facet;
    double (*normal)[3]; /* [n_facets] of unit length; 0 of a triangle without area */
    double (
        *corner_normal)[3][3]; /* [n_facets] unit normals at the corners; until they are packed */
    uint64_t *likeness; /* [n_edges] the same for feature edges of the same tags and regions */
} pl_features;

/** The corner of a facet where its edge with nodes a and b begins. Two facets may share several edges. */
static inline int pl_edge_with(const planish_shape *shape, int32_t facet, int32_t a, int32_t b) {
    return pl_edge_of(shape->facet[facet], a, b);
}

/** The corner of the facet beside edge k of f where that edge begins. */
static inline int pl_edge_beside(const pl_features *w, int32_t f, int k) {
    const int32_t *v = w->shape->facet[f];
    return pl_edge_with(w->shape, w->beside[f][k], v[k], v[(k + 1) % 3]);
}

/** Go around a node from corner *k of facet *f across edges without bits of apart, forwards or not. Returns
 *  0 at the last facet. */
static inline int pl_fan_next(const pl_features *w, int apart, int forwards, int32_t *f, int *k) {
    const int edge = forwards ? *k : (*k + 2) % 3;
    const int32_t from = *f, to = w->beside[from][edge];
    if (to < 0 || w->kind[from][edge] & apart)
        return 0;
    const int32_t node = w->shape->facet[from][*k];
    *f = to;
    *k = pl_corner_at(w->shape, to, node);
    return 1;
}

#endif
