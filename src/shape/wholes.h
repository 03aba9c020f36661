/* wholes: facets of second order, each as triangles between its nodes.
 *
 * The surface is then one of triangles through all of its nodes. A point of the facet belongs to that of
 * a triangle with the same weights; between them is a quadratic function, known by three vectors (rises),
 * and for quadrilaterals a rest, which is bounded. Facets of first order beside them are one or two
 * triangles, and rise nowhere.
 *
 *   pl_surface_divide     all facets of a surface
 *   pl_mid_between        the mid of an edge
 *   pl_whole_parts        triangles of a facet
 *   pl_whole_rim          the triangles along an edge
 *   pl_whole_followers, pl_whole_parents    which nodes go with which
 *   pl_whole_rises, pl_whole_rest, pl_whole_bend    how far a facet is off a triangle
 *   pl_whole_way          how far its points go
 */
#ifndef PL_SHAPE_WHOLES_H
#define PL_SHAPE_WHOLES_H

#include "geometry/simplex.h"

#include <planish/planish.h>

#include <math.h>
#include <stdint.h>

enum {
    PL_WHOLE_NODES = 9,    /* of a facet, at most, */
    PL_WHOLE_PARTS = 8,    /* its triangles, */
    PL_WHOLE_FOLLOWERS = 3 /* and of its nodes those that follow one corner */
};

/** Facet whose triangles make one surface: of second order, or of first order on a surface that has
 *  others. */
typedef struct pl_whole {
    int32_t
        node[PL_WHOLE_NODES]; /* corners, one after the other; mids from each to the next; centre */
    int32_t first;            /* of its triangles, which follow each other */
    uint8_t n_corners, n_nodes, n_parts;
    uint8_t is_held; /* its edges have other nodes than it can use: all of them are to stay */
} pl_whole;

struct pl_surface;

/** Divide the facets of a surface, if some are of second order and curved: each becomes triangles between
 *  its nodes, those at its corners first. mesh: the caller's, with cells. Errors: _MEMORY. */
int pl_surface_divide(const planish_mesh *mesh, struct pl_surface *surface, planish_error *error);

/** Return the mid of the edge with ends a and b; -1: there is none. Own numbers. */
int32_t pl_mid_between(const struct pl_surface *surface, int32_t a, int32_t b);

/** Whether a facet has mids. */
static inline int pl_whole_has_mids(const pl_whole *whole) {
    return whole->n_nodes > whole->n_corners;
}

/** Return the triangles of a facet, as places in node: those of second order begin with one at each
 *  corner, which is its first node. */
static inline const uint8_t (*pl_whole_parts(const pl_whole *whole))[3] {
    static const uint8_t LINEAR[][3] = {{0, 1, 2}, {0, 2, 3}},
                         TRIANGLE6[][3] = {{0, 3, 5}, {1, 4, 3}, {2, 5, 4}, {3, 4, 5}},
                         QUADRILATERAL8[][3] = {{0, 4, 7}, {1, 5, 4}, {2, 6, 5},
                                                {3, 7, 6}, {4, 5, 6}, {4, 6, 7}},
                         QUADRILATERAL9[][3] = {{0, 4, 7}, {1, 5, 4}, {2, 6, 5}, {3, 7, 6},
                                                {4, 5, 8}, {5, 6, 8}, {6, 7, 8}, {7, 4, 8}};
    return whole->n_nodes == 9   ? QUADRILATERAL9
           : whole->n_nodes == 8 ? QUADRILATERAL8
           : whole->n_nodes == 6 ? TRIANGLE6
                                 : LINEAR;
}

/** Return the triangle of a facet that has the first (half 0) or second half of the edge after
 *  corner k. In a facet of first order it has the whole edge. */
static inline int32_t pl_whole_rim(const pl_whole *whole, int k, int half) {
    const int part = pl_whole_has_mids(whole) ? (half ? (k + 1) % whole->n_corners : k)
                     : whole->n_corners == 4  ? k / 2
                                              : 0;
    return whole->first + part;
}

/** Return the place of a node among those of a facet; -1: it has not this one. */
static inline int pl_whole_place(const pl_whole *whole, int32_t node) {
    for (int i = 0; i < whole->n_nodes; i++)
        if (whole->node[i] == node)
            return i;
    return -1;
}

/** Find the nodes of a facet that follow a corner, as places in node: the mids of the edges from
 *  and to it, and the centre. Returns how many there are. */
static inline int pl_whole_followers(const pl_whole *whole, int32_t corner,
                                     int follower[PL_WHOLE_FOLLOWERS]) {
    const int n = whole->n_corners, k = pl_whole_place(whole, corner);
    if (!pl_whole_has_mids(whole))
        return 0;
    follower[0] = n + k;
    follower[1] = n + (k + n - 1) % n;
    follower[2] = 2 * n;
    return whole->n_nodes > 2 * n ? 3 : 2;
}

/** Find the corners that a node of a facet follows, as places in node. Returns how many there are. */
static inline int pl_whole_parents(const pl_whole *whole, int place, int parent[4]) {
    const int n = whole->n_corners, is_mid = place < 2 * n;
    for (int k = 0; k < 4; k++)
        parent[k] = is_mid ? (place - n + k) % n : k;
    return is_mid ? 2 : 4;
}

/** Compute the way from the middle of the edge after corner k to its mid; x: the facet's nodes. */
static inline void pl_mid_rise(int n_corners, const double x[][3], int k, double rise[3]) {
    for (int d = 0; d < 3; d++)
        rise[d] = x[n_corners + k][d] - 0.5 * (x[k][d] + x[(k + 1) % n_corners][d]);
}

/** Compute the way from node `from` of a quadrilateral of second order to its centre: its node, or where
 *  the facet of eight nodes is there. */
static inline void pl_centre_from(const pl_whole *whole, const double x[][3], int from,
                                  double centre[3]) {
    for (int d = 0; d < 3; d++) {
        const double *const at = x[from];
        double mids = 0, corners = 0;
        for (int k = 0; k < 4; k++) {
            corners += x[k][d] - at[d];
            mids += x[4 + k][d] - at[d];
        }
        centre[d] = whole->n_nodes == 9 ? x[8][d] - at[d] : 0.5 * mids - 0.25 * corners;
    }
}

/** Compute the rise of a quadrilateral over the way from the mid after corner k to the next mid. In
 *  the middle, a quarter of the way from the corner between them to the opposite one, shape
 *  functions of lines are 3/8, 3/4 and -1/8. */
static inline void pl_rise_inside(const pl_whole *whole, const double x[][3], int k,
                                  double rise[3]) {
    const int c = (k + 1) % 4, l = (k + 2) % 4, m = (k + 3) % 4; /* corners; k and c: mids */
    double centre[3];
    pl_centre_from(whole, x, c, centre);
    for (int d = 0; d < 3; d++) {
        const double *const at = x[c];
        const double near = (x[4 + k][d] - at[d]) + (x[4 + c][d] - at[d]);
        const double far = (x[4 + l][d] - at[d]) + (x[4 + m][d] - at[d]);
        const double beside = (x[k][d] - at[d]) + (x[l][d] - at[d]);
        rise[d] = 2.25 * centre[d] - 0.875 * near - 0.375 * far - 0.1875 * beside +
                  0.0625 * (x[m][d] - at[d]);
    }
}

/** Compute the rise of a quadrilateral over the edge of a triangle between nodes a and b: four times the
 *  way from the middle of these. */
static inline void pl_rise_between(const pl_whole *whole, const double x[][3], int a, int b,
                                   double rise[3]) {
    const int low = a < b ? a : b, high = a < b ? b : a;
    if (low < 4) {
        pl_mid_rise(4, x, high - 4, rise);
    } else if (high == 8 || high - low == 2) { /* the line between opposite mids, or half of it */
        const int opposite = 4 + (low - 2) % 4;
        pl_centre_from(whole, x, low, rise);
        for (int d = 0; d < 3; d++)
            rise[d] = (high == 8 ? 1 : 4) * (rise[d] - 0.5 * (x[opposite][d] - x[low][d]));
    } else {
        pl_rise_inside(whole, x, high - low == 1 ? low - 4 : 3, rise);
    }
}

/** Compute the rises of one triangle of a facet: off the point of the triangle with weights u, v, w
 *  the facet is u v rise[0] + v w rise[1] + w u rise[2], and no more than the rest off that. x: the
 *  facet's nodes; node: which of them the corners are. */
static inline void pl_whole_rises(const pl_whole *whole, const double x[][3], const uint8_t node[3],
                                  double rise[3][3]) {
    for (int j = 0; j < 3; j++) {
        const int a = node[j], b = node[(j + 1) % 3];
        if (!pl_whole_has_mids(whole)) {
            for (int d = 0; d < 3; d++)
                rise[j][d] = 0;
        } else if (whole->n_corners == 4) {
            pl_rise_between(whole, x, a, b, rise[j]);
        } else { /* along half an edge, or beside it */
            const int edge = a < 3 ? b - 3 : b < 3 ? a - 3 : (a + b == 7 ? 2 : a + b == 9 ? 0 : 1);
            pl_mid_rise(3, x, edge, rise[j]);
        }
    }
}

/** Bound the distance of a facet from the surface that the rises of one triangle describe.
 *
 *  A quadrilateral on [-1, 1]^2 is quadratic but for A x^2 y + B x y^2 + C x^2 y^2. Quadratic
 *  functions that agree at the corners of a triangle and in the middle of its edges are off these
 *  by no more than the factors here, found by hand: s t (s - 1/2) in a triangle at a corner, for
 *  one. */
static inline double pl_whole_rest(const pl_whole *whole, const double x[][3],
                                   const uint8_t node[3]) {
    static const double CUBIC = 0.0482, CUBIC_HALF = 0.125, QUARTIC = 0.06;
    double rise[4][3], centre[3], square[3] = {0, 0, 0};
    if (whole->n_corners == 3 || !pl_whole_has_mids(whole))
        return 0;
    for (int k = 0; k < 4; k++)
        pl_mid_rise(4, x, k, rise[k]);
    pl_centre_from(whole, x, 0, centre);
    for (int d = 0; d < 3; d++) {
        double mids = 0, corners = 0;
        for (int k = 0; k < 4; k++) {
            mids += x[4 + k][d] - x[0][d];
            corners += x[k][d] - x[0][d];
        }
        const double a = 0.5 * (rise[0][d] - rise[2][d]), b = 0.5 * (rise[3][d] - rise[1][d]);
        const double c = whole->n_nodes == 9 ? centre[d] - 0.5 * mids + 0.25 * corners : 0;
        square[0] += a * a;
        square[1] += b * b;
        square[2] += c * c;
    }
    const int is_half = whole->n_nodes == 8 && node[0] > 3 && node[1] > 3 && node[2] > 3;
    return (CUBIC * sqrt(square[0]) + (is_half ? CUBIC_HALF : CUBIC) * sqrt(square[1]) +
            QUARTIC * sqrt(square[2])) *
           (1 + 0x1p-40);
}

/** Return how far a facet is off one of its triangles at most: u v + v w + w u <= 1 / 3. */
static inline double pl_whole_bend(const pl_whole *whole, const double x[][3],
                                   const uint8_t node[3]) {
    double rise[3][3], most = 0;
    pl_whole_rises(whole, x, node, rise);
    for (int k = 0; k < 3; k++)
        most = fmax(most, pl_dot(3, rise[k], rise[k]));
    return sqrt(most) / 3 * (1 + 0x1p-40) + pl_whole_rest(whole, x, node);
}

/** Return how far points of a facet go at most if its nodes go from x to y: no farther than one of its
 *  Bezier control points, which are the corners, 2 m - (a + b) / 2 for a mid m between a and b, and of a
 *  quadrilateral one inside. */
static inline double pl_whole_way(const pl_whole *whole, const double x[][3], const double y[][3]) {
    const int c = whole->n_corners;
    double most = 0, inside = 0;
    for (int i = 0; i < whole->n_nodes && i < 2 * c; i++) {
        double way[3];
        for (int d = 0; d < 3; d++) {
            way[d] = y[i][d] - x[i][d];
            if (i >= c)
                way[d] = 2 * way[d] - 0.5 * ((y[i - c][d] - x[i - c][d]) +
                                             (y[(i - c + 1) % c][d] - x[(i - c + 1) % c][d]));
        }
        most = fmax(most, pl_dot(3, way, way));
    }
    for (int d = 0; d < 3 && c == 4 && pl_whole_has_mids(whole); d++) {
        double mids = 0, corners = 0;
        for (int k = 0; k < 4; k++) {
            mids += y[4 + k][d] - x[4 + k][d];
            corners += y[k][d] - x[k][d];
        }
        const double way = whole->n_nodes == 9 ? 4 * (y[8][d] - x[8][d]) - mids + 0.25 * corners
                                               : mids - 0.75 * corners;
        inside += way * way;
    }
    return sqrt(fmax(most, inside)) * (1 + 0x1p-40);
}

#endif
