/* pn: points on PN triangles and cubic arcs. A. Vlachos, J. Peters, C. Boyd, J. L. Mitchell, Curved PN
 * triangles (2001). */
#include "shape/pn.h"

#include <string.h>

/** Compute where the cubic from a to b along d = b - a has its inner control points, off its ends, if it
 *  begins along t and ends against u, unit vectors towards the other ends. */
static void control_by_tangents(const double d[3], const double t[3], const double u[3],
                                double control[2][3]) {
    const double third = pl_length(d) / 3;
    for (int i = 0; i < 3; i++) {
        control[0][i] = third * t[i];
        control[1][i] = third * u[i];
    }
}

/** The edge of a curve that has nodes a and b, one of which lies inside of the curve; -1: none does. */
static int32_t curve_edge(const planish_shape *s, int32_t a, int32_t b) {
    const int at_a = s->node_class[a] == PL_ON_CURVE;
    if (!at_a && s->node_class[b] != PL_ON_CURVE)
        return -1;
    const int32_t *at = s->edge_at[at_a ? a : b], other = at_a ? b : a;
    return at[s->edge[at[0]][0] != other && s->edge[at[0]][1] != other];
}

/** Compute the inner control points of edge k of a facet, off the corners next to them. up: the normals of
 *  its corners. */
static void control_edge(const planish_shape *s, int32_t f, int k, const double *const up[3],
                         double control[2][3]) {
    const int m = (k + 1) % 3;
    const int32_t a = s->facet[f][k], b = s->facet[f][m];
    double d[3];
    pl_from_to(3, s->x[a], s->x[b], d);
    const int32_t e = s->across[f][k] < 0 ? curve_edge(s, a, b) : -1;
    if (e >= 0) {
        const int turned = s->edge[e][0] == b;
        control_by_tangents(d, s->tangent[e][turned], s->tangent[e][!turned], control);
        return;
    }
    const int is_straight = s->across[f][k] < 0;
    const double rise = is_straight ? 0 : pl_dot(3, d, up[k]);
    const double fall = is_straight ? 0 : pl_dot(3, d, up[m]);
    for (int i = 0; i < 3; i++) {
        control[0][i] = (d[i] - rise * up[k][i]) / 3;
        control[1][i] = -(d[i] - fall * up[m][i]) / 3;
    }
}

/** Compute the point and normal of a facet's PN triangle. */
static void point_on_patch(const planish_shape *s, const pl_place *place, double point[3],
                           double normal[3]) {
    const int32_t f = place->at, *v = s->facet[f];
    const double *const x[3] = {s->x[v[0]], s->x[v[1]], s->x[v[2]]};
    const double a = place->weight[0], b = place->weight[1], c = place->weight[2];
    const double *const up[3] = {pl_corner_normal(s, f, 0), pl_corner_normal(s, f, 1),
                                 pl_corner_normal(s, f, 2)};
    double edge[3][2][3], ab[3], ac[3], straight[3];
    for (int k = 0; k < 3; k++)
        control_edge(s, f, k, up, edge[k]);
    for (int d = 0; d < 3; d++) {
        /* all relative to the first corner: what is plane stays so to the last digits */
        const double q = x[1][d] - x[0][d], r = x[2][d] - x[0][d];
        const double p01 = edge[0][0][d], p10 = q + edge[0][1][d];
        const double p12 = q + edge[1][0][d], p21 = r + edge[1][1][d];
        const double p20 = r + edge[2][0][d], p02 = edge[2][1][d];
        const double mean = (p01 + p10 + p12 + p21 + p20 + p02) / 6;
        const double middle = mean + (mean - (q + r) / 3) / 2;
        point[d] = x[0][d] + (q * b * b * b + r * c * c * c +
                              3 * (a * b * (p01 * a + p10 * b) + b * c * (p12 * b + p21 * c) +
                                   c * a * (p20 * c + p02 * a)) +
                              6 * middle * a * b * c);
        const double du = 2 * a * (p01 * b + p02 * c) + p10 * b * b + p20 * c * c;
        const double dv = q * b * b + p01 * a * a + 2 * b * (p10 * a + p12 * c) + p21 * c * c;
        const double dw = r * c * c + p12 * b * b + 2 * c * (p21 * b + p20 * a) + p02 * a * a;
        ab[d] = dv + 2 * middle * a * c - du - 2 * middle * b * c;
        ac[d] = dw + 2 * middle * a * b - du - 2 * middle * b * c;
        straight[d] = up[0][d] * a + up[1][d] * b + up[2][d] * c;
    }
    double across[3], blended[3];
    pl_cross(ab, ac, across);
    if (!pl_unit(3, straight, blended))
        pl_facet_normal(s, f, blended);
    if (!pl_unit(3, across, normal) || !(pl_dot(3, normal, blended) > 0.5))
        memcpy(normal, blended, sizeof blended);
}

/** Compute the point and tangent of an edge's cubic arc. */
static void point_on_curve(const planish_shape *s, const pl_place *place, double point[3],
                           double tangent[3]) {
    const int32_t e = place->at;
    const double a = place->weight[0], b = place->weight[1];
    double chord[3], control[2][3], along[3];
    pl_from_to(3, s->x[s->edge[e][0]], s->x[s->edge[e][1]], chord);
    control_by_tangents(chord, s->tangent[e][0], s->tangent[e][1], control);
    for (int d = 0; d < 3; d++) {
        const double p = control[0][d], q = chord[d] + control[1][d];
        point[d] = s->x[s->edge[e][0]][d] + (3 * a * b * (p * a + q * b) + chord[d] * b * b * b);
        along[d] = p * a * a + 2 * (q - p) * a * b + (chord[d] - q) * b * b;
    }
    if (!pl_unit(3, along, tangent))
        pl_unit(3, chord, tangent);
}

void pl_shape_point(const planish_shape *shape, int node_class, const pl_place *place,
                    double point[3], double direction[3]) {
    if (node_class == PL_ON_CURVE)
        point_on_curve(shape, place, point, direction);
    else
        point_on_patch(shape, place, point, direction);
}
