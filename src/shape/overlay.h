/* overlay: how far a triangle is off a shape at most, proved.
 *
 * In the frame of a triangle T the facets of the patch are clipped to T. The height of each piece
 * over T is linear, so it is largest at a corner of a piece; if the pieces cover T, as they do where
 * all turn the same way and no feature runs over T, no point of T is farther off. Beside curves T
 * may stick out: by lateral at most, and only in a strip that features run over.
 *
 *   pl_overlay_bound           of one triangle
 *   pl_overlay_most            the largest of numbers of the facets over it
 *   pl_overlay_lateral         of its edges on curves
 *   pl_overlay_bound_any       of a triangle that never was a facet
 *
 * divide.h is sharper; distance.h has whole surfaces.
 */
#ifndef PL_SHAPE_OVERLAY_H
#define PL_SHAPE_OVERLAY_H

#include "shape/curved.h"

/** A triangle that was a facet of the shape, where it is now. */
typedef struct pl_moved_facet {
    int32_t facet;     /* of the shape */
    double x[3][3];    /* where its corners are, in the shape's units */
    pl_place place[3]; /* of each corner; at -1: not known, or of a corner of the shape */
    double rise[3][3],
        rest; /* of a shape of second order: the facet is off the triangle by u v rise[0]
                                + v w rise[1] + w u rise[2] at the weights u, v, w of its corners, and by
                                no more than the rest off that */
} pl_moved_facet;

/** Set the rises and the rest of a triangle of a facet of second order with nodes x. */
static inline void pl_set_rises(const planish_shape *shape, const double x[][3],
                                pl_moved_facet *t) {
    const pl_whole *whole = pl_whole_of(shape, t->facet);
    uint8_t node[3];
    pl_find_part(shape, t->facet, node);
    pl_whole_rises(whole, x, node, t->rise);
    t->rest = pl_whole_rest(whole, x, node);
}

/** Return the largest distance, in both directions, between the facet's edges on curves and the
 *  original chains of edges, or of its corners on curves from these chains; 0: it has none;
 *  infinite: not known. */
double pl_overlay_lateral(const planish_shape *shape, const pl_moved_facet *t);

/** Return a bound of the distance of the triangle, or facet of second order, from the patch: no
 *  point of it is farther off. Return more than limit, perhaps infinity, if no bound up to limit is
 *  proved. lateral: from pl_overlay_lateral. Units: the shape's. */
double pl_overlay_bound(const planish_shape *shape, const pl_moved_facet *t, double lateral,
                        double limit);

/** Return a bound of the distance of triangle x from the patch of a facet: no point of it is
 *  farther off. Return infinity if no bound is known, for example where features run over the
 *  triangle. The triangle turns as the patch does. Units: the shape's. */
double pl_overlay_bound_any(const planish_shape *shape, const double x[3][3], int32_t facet);

/** Return the largest of the numbers [n_facets], at least 0, of the facets over the triangle;
 *  infinite: it is not proved that these are all. */
double pl_overlay_most(const planish_shape *shape, const pl_moved_facet *t, const double *number);

/** Return the mean of the edges of a facet, as it came; of second order of those between corners. */
static inline double pl_shape_own_edge(const planish_shape *shape, int32_t facet) {
    int n;
    const int32_t *node = pl_shape_corners(shape, facet, &n);
    double sum = 0;
    for (int k = 0; k < n; k++)
        sum += pl_distance(3, shape->x[node[k]], shape->x[node[(k + 1) % n]]);
    return sum / n;
}

/** Return the mean edge at a facet, as it came: the least of those of its own edges, of the facets across
 *  them, and of its nodes together. Unit: the shape's. */
static inline double pl_shape_edge(const planish_shape *shape, int32_t facet) {
    int n;
    const int32_t *node = pl_shape_corners(shape, facet, &n);
    double mean = pl_shape_own_edge(shape, facet), of_nodes = 0;
    const int32_t first = shape->whole ? pl_whole_of(shape, facet)->first : facet;
    const int n_parts = pl_shape_parts(shape, facet);
    for (int k = 0; k < n; k++)
        of_nodes += (double)pl_edges_at(shape, node[k]) * shape->edge_length[node[k]];
    for (int i = 0; i < 3 * n_parts; i++) { /* of second order across all triangles */
        const int32_t across = shape->across[first + i / 3][i % 3];
        if (across >= 0)
            mean = fmin(mean, pl_shape_own_edge(shape, across));
    }
    return fmin(mean, of_nodes / n);
}

#endif
