/* curved: the shape that a mesh's surface has by its triangles, and places on it.
 *
 * The surface as it came is cut by its features into patches, and the features into curves between
 * corners. Between the triangles' corners the shape is that of PN triangles (Vlachos et al. 2001),
 * along curves that of cubic arcs. A node of a patch or curve goes from place to place; how far the
 * triangles that it takes along are off those that came is bounded (overlay.h).
 *
 * Facets of second order are four triangles each, between corners and mids; bend says how far the
 * curved facet is off them.
 *
 *   here         pl_corner_at, pl_edge_of          corners and edges of facets
 *                pl_shape_star                     facets that change with a node
 *                pl_bend_of, pl_whole_way          how far a facet of second order is off its triangles;
 *                                                  how far its points go
 *   create.h     pl_shape_create, _destroy         all of it
 *   pn.h         pl_shape_point                    a place in space
 *   walk.h       pl_shape_walk                     the place that is nearest
 *                pl_shape_first_place              the place where a node was first
 */
#ifndef PL_SHAPE_CURVED_H
#define PL_SHAPE_CURVED_H

#include "shape/surface.h"

/** Class of a node of a shape. */
enum { PL_CORNER = 0, PL_ON_PATCH = 1, PL_ON_CURVE = 2 };

/** Shape of a surface in space. Nodes, facets and curve edges have own numbers; lengths are in the
 *  shape's units, scale times the mesh's. All arrays are owned. */
struct planish_shape {
    int64_t n_mesh;           /* nodes of the mesh */
    int64_t n_nodes;          /* of the surface */
    int64_t n_facets;         /* triangles */
    int64_t n_edges;          /* edges of features */
    double scale;             /* a power of two */
    double size;              /* diagonal of the bounding box */
    int32_t *number;          /* [n_mesh] own number of each node; -1: not of the surface */
    int32_t *node;            /* [n_nodes] the mesh's number */
    double (*x)[3];           /* [n_nodes] where they were first */
    double *edge_length;      /* [n_nodes] mean length of the surface's edges at each */
    uint8_t *node_class;      /* [n_nodes] PL_CORNER, PL_ON_PATCH, PL_ON_CURVE */
    int32_t (*facet)[3];      /* [n_facets] nodes; within a patch all turn the same way round */
    double (*normal)[3];      /* [n_facets] of unit length; 0 of a triangle without area */
    int32_t (*across)[3];     /* [n_facets] facet of the same patch across the edge from corner k to
                              corner (k + 1) % 3; -1: the edge is a feature */
    int32_t *patch;           /* [n_facets] number of its patch, by the lowest facet */
    uint8_t *is_interface;    /* [n_facets] 1: between two regions, or inside of one */
    uint8_t *half;            /* [n_facets] as pl_surface.half; NULL: all are whole */
    int64_t *offset;          /* [n_nodes + 1] into facet_of */
    int32_t *facet_of;        /* facets of each node, ascending */
    int32_t (*edge)[2];       /* [n_edges] nodes, ascending */
    int32_t (*edge_facet)[2]; /* [n_edges] two facets at it; -1: there is none */
    int32_t (*edge_at)[2];    /* [n_nodes] both edges of a node on a curve; else -1, or one */
    uint32_t *normal_at;      /* [n_nodes + 1] into corner_normal: each node has one for all of its
                                      facets, or one for each in the order of facet_of */
    double (*corner_normal)[3]; /* unit normals of the shape at corners of facets */
    double (*tangent)[2][3];    /* [n_edges] unit tangents at both ends, towards the other end */
    int32_t (*whole)[6]; /* [n_facets / 4] facets of second order, each of the next four facets: its
                             corners, and the mids from each to the next one; NULL: there are none */
    double *bend;        /* [n_facets] with whole: no point of the curved facet over the triangle is
                             farther off the point of the triangle with its weights */
    int64_t *star_offset; /* [n_nodes + 1] with whole: into star */
    int32_t *star; /* all four facets of each facet of second order at a corner; of mids none */
};

/** Return the unit normal of the shape at corner k of a facet. */
static inline const double *pl_corner_normal(const planish_shape *shape, int32_t facet, int k) {
    const int32_t node = shape->facet[facet][k];
    const uint32_t first = shape->normal_at[node];
    const int32_t *at = shape->facet_of + shape->offset[node];
    if (shape->normal_at[node + 1] - first == 1)
        return shape->corner_normal[first];
    int64_t i = 0;
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

/** Return the facets that change when a node moves, with its mids if it is a corner of facets of second
 *  order: *n of them. */
static inline const int32_t *pl_shape_star(const planish_shape *shape, int32_t node, int64_t *n) {
    const int64_t *offset = shape->whole ? shape->star_offset : shape->offset;
    *n = offset[node + 1] - offset[node];
    return (shape->whole ? shape->star : shape->facet_of) + offset[node];
}

/** Return how far a facet of second order with these corners and mids [6] is off its four triangles.
 *
 *  Over the triangles' edges the facet rises as parabolas do: with D the way from the middle of two
 *  corners to their mid, a point of weights u, v, w in one triangle is off by u v D1 + v w D2 + w u D3,
 *  and u v + v w + w u <= 1 / 3. */
static inline double pl_bend_of(const double x[6][3]) {
    double most = 0;
    for (int k = 0; k < 3; k++) {
        double off[3];
        for (int d = 0; d < 3; d++)
            off[d] = x[3 + k][d] - 0.5 * (x[k][d] + x[(k + 1) % 3][d]);
        most = fmax(most, pl_dot(3, off, off));
    }
    return sqrt(most) / 3 * (1 + 0x1p-40);
}

/** Return how far points of a facet of second order go at most if its corners and mids go from x to y
 *  [6]: no farther than one of its Bezier control points, which are the corners, and 2 m - (a + b) / 2 for
 *  a mid m between a and b. */
static inline double pl_whole_way(const double x[6][3], const double y[6][3]) {
    double most = 0;
    for (int i = 0; i < 6; i++) {
        double way[3];
        for (int d = 0; d < 3; d++) {
            way[d] = y[i][d] - x[i][d];
            if (i >= 3)
                way[d] = 2 * way[d] - 0.5 * ((y[i - 3][d] - x[i - 3][d]) +
                                             (y[(i - 2) % 3][d] - x[(i - 2) % 3][d]));
        }
        most = fmax(most, pl_dot(3, way, way));
    }
    return sqrt(most) * (1 + 0x1p-40);
}

/** A place on a shape: of a node on a patch a facet, of one on a curve an edge. */
typedef struct pl_place {
    int32_t at;       /* facet, or edge */
    double weight[3]; /* of its corners, at least 0, together 1; of an edge the first two */
} pl_place;

#endif
