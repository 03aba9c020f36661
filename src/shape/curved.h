/* curved: the shape that a mesh's surface has by its triangles, and places on it.
 *
 * The surface as it came is cut by its features into patches, and the features into curves between
 * corners. Between the triangles' corners the shape is that of PN triangles (Vlachos et al. 2001),
 * along curves that of cubic arcs. A node of a patch or curve goes from place to place; how far the
 * triangles that it takes along are off those that came is bounded (overlay.h).
 *
 * Facets of second order are several triangles each, between their nodes (wholes.h); bend says how far
 * the curved facet is off them.
 *
 *   here         pl_is_hub                         nodes of very many facets
 *                pl_corner_at, pl_edge_of          corners and edges of facets
 *                pl_shape_star                     facets that change with a node
 *                pl_facet_normal, pl_kept_normal   the normal of a facet, exact or as it is kept
 *                pl_whole_of, pl_find_part         a triangle and its facet of second order
 *   create.h     pl_shape_create, _destroy         all of it
 *   pn.h         pl_shape_point                    a place in space
 *   walk.h       pl_shape_walk                     the place that is nearest
 *                pl_shape_first_place              the place where a node was first
 */
#ifndef PL_SHAPE_CURVED_H
#define PL_SHAPE_CURVED_H

#include "shape/surface.h"
#include "shape/wholes.h"

/** Class of a node of a shape. */
enum { PL_CORNER = 0, PL_ON_PATCH = 1, PL_ON_CURVE = 2 };

/** Shape of a surface in space. Nodes, facets and curve edges have own numbers; lengths are in the
 *  shape's units, scale times the mesh's. All arrays are owned. */
struct planish_shape {
    int64_t n_mesh;        /* nodes of the mesh */
    int64_t n_nodes;       /* of the surface */
    int64_t n_facets;      /* triangles */
    int64_t n_edges;       /* edges of features */
    double scale;          /* a power of two */
    double size;           /* diagonal of the bounding box */
    int32_t *number;       /* [n_mesh] own number of each node; -1: not of the surface */
    int32_t *node;         /* [n_nodes] the mesh's number */
    double (*x)[3];        /* [n_nodes] where they were first */
    float *edge_length;    /* [n_nodes] mean length of the surface's edges at each, rounded down */
    uint8_t *node_class;   /* [n_nodes] PL_CORNER, PL_ON_PATCH, PL_ON_CURVE */
    int32_t (*facet)[3];   /* [n_facets] nodes; within a patch all turn the same way round */
    float (*normal)[3];    /* [n_facets] of unit length, rounded; 0 of a triangle without area */
    int32_t (*across)[3];  /* [n_facets] facet of the same patch across the edge from corner k to
                              corner (k + 1) % 3; -1: the edge is a feature */
    int32_t *patch;        /* [n_facets] number of its patch, by the lowest facet */
    uint8_t *is_interface; /* [n_facets] 1: between two regions, or inside of one */
    uint8_t *half;         /* [n_facets] as pl_surface.half; NULL: all are whole */
    uint32_t *offset;      /* [n_nodes + 1] into facet_of */
    int32_t *facet_of;     /* facets of each node, ascending */
    int32_t (*edge)[2];    /* [n_edges] nodes, ascending */
    int32_t (*edge_facet)[2]; /* [n_edges] two facets at it; -1: there is none */
    int32_t (*edge_at)[2];    /* [n_nodes] both edges of a node on a curve; else -1, or one */
    uint32_t *normal_at;      /* [n_nodes + 1] into corner_normal: each node has one for all of its
                                      facets, or one for each in the order of facet_of */
    double (*corner_normal)[3]; /* unit normals of the shape at corners of facets */
    double (*tangent)[2][3];    /* [n_edges] unit tangents at both ends, towards the other end */
    pl_whole *whole;            /* [n_wholes] facets of second order; NULL: there are none */
    int64_t n_wholes;
    int32_t *whole_of; /* [n_facets] with whole: the facet that each triangle is of */
    double *bend;      /* [n_facets] with whole: no point of the curved facet over the triangle is
                             farther off the point of the triangle with its weights */
    int64_t *star_offset; /* [n_nodes + 1] with whole: into star */
    int32_t *star; /* all triangles of each facet of second order at a corner; of mids none */
};

/** Whether a node has very many facets: loops over pairs of them do not pay. */
static inline int pl_is_hub(const planish_shape *shape, int64_t node) {
    static const uint32_t MANY_FACETS = 64;
    return shape->offset[node + 1] - shape->offset[node] > MANY_FACETS;
}

/** Return how many of list [n], which ascends, are below value: where value is, if it is there. */
static inline int64_t pl_find_ascending(const int32_t *list, int64_t n, int32_t value) {
    int64_t begin = 0;
    while (n > 0) {
        const int64_t half = n / 2;
        const int is_above = list[begin + half] < value;
        begin = is_above ? begin + half + 1 : begin;
        n = is_above ? n - half - 1 : half;
    }
    return begin;
}

/** Return the unit normal of the shape at corner k of a facet. */
static inline const double *pl_corner_normal(const planish_shape *shape, int32_t facet, int k) {
    const int32_t node = shape->facet[facet][k];
    const uint32_t first = shape->normal_at[node];
    const int32_t *at = shape->facet_of + shape->offset[node];
    if (shape->normal_at[node + 1] - first == 1)
        return shape->corner_normal[first];
    int64_t i = 0;
    if (pl_is_hub(shape, node))
        i = pl_find_ascending(at, shape->offset[node + 1] - shape->offset[node], facet);
    while (at[i] != facet)
        i++;
    return shape->corner_normal[first + i];
}

/** Return the corner of a facet at node. */
static inline int pl_corner_at(const planish_shape *shape, int32_t facet, int32_t node) {
    const int32_t *v = shape->facet[facet];
    return v[0] == node ? 0 : v[1] == node ? 1 : 2;
}

/** Return where the edge with nodes a and b of a facet [3] begins. */
static inline int pl_edge_of(const int32_t *facet, int32_t a, int32_t b) {
    return facet[0] != a && facet[0] != b ? 1 : facet[1] != a && facet[1] != b ? 2 : 0;
}

/** Compute the unit normal of a facet from its corners; 0 of a triangle without area. */
static inline void pl_facet_normal(const planish_shape *shape, int32_t facet, double normal[3]) {
    const int32_t *v = shape->facet[facet];
    double a[3], b[3], across[3];
    pl_from_to(3, shape->x[v[0]], shape->x[v[1]], a);
    pl_from_to(3, shape->x[v[0]], shape->x[v[2]], b);
    pl_cross(a, b, across);
    if (!pl_unit(3, across, normal))
        normal[0] = normal[1] = normal[2] = 0;
}

/** How far a kept normal is from that of the facet at most: it has the 24 bits of floats. */
#define PL_KEPT_NORMAL_OFF 0x1p-24

/** Set normal to the kept one of a facet. */
static inline void pl_kept_normal(const planish_shape *shape, int32_t facet, double normal[3]) {
    for (int d = 0; d < 3; d++)
        normal[d] = (double)shape->normal[facet][d];
}

/** Return the facets that change when a node moves, with its mids if it is a corner of facets of second
 *  order: *n of them. */
static inline const int32_t *pl_shape_star(const planish_shape *shape, int32_t node, int64_t *n) {
    if (!shape->whole) {
        *n = shape->offset[node + 1] - shape->offset[node];
        return shape->facet_of + shape->offset[node];
    }
    *n = shape->star_offset[node + 1] - shape->star_offset[node];
    return shape->star + shape->star_offset[node];
}

/** Return the facet of second order that a triangle is of. */
static inline const pl_whole *pl_whole_of(const planish_shape *shape, int32_t facet) {
    return &shape->whole[shape->whole_of[facet]];
}

/** Return how many triangles the facet of a triangle has: 1 where none is of second order. */
static inline int pl_shape_parts(const planish_shape *shape, int32_t facet) {
    return shape->whole ? pl_whole_of(shape, facet)->n_parts : 1;
}

/** Return the corners of the facet of a triangle, *n of them. */
static inline const int32_t *pl_shape_corners(const planish_shape *shape, int32_t facet, int *n) {
    *n = shape->whole ? pl_whole_of(shape, facet)->n_corners : 3;
    return shape->whole ? pl_whole_of(shape, facet)->node : shape->facet[facet];
}

/** Return how many edges of the surface's triangles an edge at a corner is: 2 where that has a mid. */
static inline int pl_edges_at(const planish_shape *shape, int32_t corner) {
    return shape->whole &&
                   pl_whole_has_mids(pl_whole_of(shape, shape->star[shape->star_offset[corner]]))
               ? 2
               : 1;
}

/** Set x to the nodes of a facet of second order, where the shape has them. */
static inline void pl_whole_nodes(const planish_shape *shape, const pl_whole *whole,
                                  double x[PL_WHOLE_NODES][3]) {
    for (int k = 0; k < whole->n_nodes; k++)
        for (int d = 0; d < 3; d++)
            x[k][d] = shape->x[whole->node[k]][d];
}

/** Find which nodes of its facet of second order the corners of a triangle are. */
static inline void pl_find_part(const planish_shape *shape, int32_t facet, uint8_t node[3]) {
    const pl_whole *whole = pl_whole_of(shape, facet);
    for (int j = 0; j < 3; j++)
        node[j] = (uint8_t)pl_whole_place(whole, shape->facet[facet][j]);
}

/** A place on a shape: of a node on a patch a facet, of one on a curve an edge. */
typedef struct pl_place {
    int32_t at;       /* facet, or edge */
    double weight[3]; /* of its corners, at least 0, together 1; of an edge the first two */
} pl_place;

#endif
