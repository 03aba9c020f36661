/* pn: PN triangles and cubic arcs: the tangents and normals that they have at the nodes, and points
 * on them. A. Vlachos, J. Peters, C. Boyd, J. L. Mitchell, Curved PN triangles (2001). */
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "shape/features.h"

#include <string.h>

enum { CHUNK = 512 }; /* nodes that one thread takes at a time */

/* ---- tangents -------------------------------------------------------------------------------- */

/** Compute the unit tangent of a curve where two of its edges meet, towards the end of the second: that of the
 *  parabola through their nodes. */
static void tangent_between(const planish_shape *s, int32_t from, int32_t node, int32_t to,
                            double tangent[3]) {
    double in[3], out[3];
    pl_from_to(3, s->x[from], s->x[node], in);
    pl_from_to(3, s->x[node], s->x[to], out);
    const double l = pl_length(in), m = pl_length(out);
    for (int d = 0; d < 3; d++)
        in[d] = in[d] * (m / l) + out[d] * (l / m);
    pl_unit(3, in, tangent);
}

/** Compute the tangents of an edge at its nodes on curves; the chord at others. */
static void find_tangents(planish_shape *s, int32_t e) {
    for (int j = 0; j < 2; j++) {
        const int32_t node = s->edge[e][j], to = s->edge[e][!j], *at = s->edge_at[node];
        double chord[3];
        pl_from_to(3, s->x[node], s->x[to], chord);
        memset(s->tangent[e][j], 0, sizeof s->tangent[e][j]);
        pl_unit(3, chord, s->tangent[e][j]);
        if (s->node_class[node] != PL_ON_CURVE)
            continue;
        const int32_t before = at[at[0] == e];
        tangent_between(s, s->edge[before][s->edge[before][0] == node], node, to, s->tangent[e][j]);
    }
}

/** Set the tangent at the end of a curve so that its last arc is symmetric. */
static void mirror_tangent(planish_shape *s, int32_t e) {
    for (int j = 0; j < 2; j++) {
        if (s->node_class[s->edge[e][j]] == PL_ON_CURVE ||
            s->node_class[s->edge[e][!j]] != PL_ON_CURVE)
            continue;
        double chord[3];
        memcpy(chord, s->tangent[e][j], sizeof chord);
        const double *there = s->tangent[e][!j];
        const double twice = -2 * pl_dot(3, chord, there);
        for (int d = 0; d < 3; d++)
            s->tangent[e][j][d] = twice * chord[d] + there[d];
    }
}

static void bend_edges(void *context, int64_t begin, int64_t end, int thread) {
    planish_shape *s = ((pl_features *)context)->shape;
    (void)thread;
    for (int64_t e = begin; e < end; e++) {
        find_tangents(s, (int32_t)e);
        mirror_tangent(s, (int32_t)e);
    }
}

/* ---- normals at corners ----------------------------------------------------------------------- */

/** Add what a facet says of the normal at its corner k. Summed over a closed fan it is the normal of
 *  a sphere through the nodes. */
static void add_normal(const planish_shape *s, int32_t f, int k, double sum[3]) {
    const int32_t *v = s->facet[f];
    double a[3], b[3], normal[3];
    pl_from_to(3, s->x[v[k]], s->x[v[(k + 1) % 3]], a);
    pl_from_to(3, s->x[v[k]], s->x[v[(k + 2) % 3]], b);
    const double square = pl_dot(3, a, a) * pl_dot(3, b, b);
    pl_cross(a, b, normal);
    for (int d = 0; d < 3 && square > 0; d++)
        sum[d] += normal[d] / square;
}

/** Remove from a normal, at a node on a curve, what it has along that. */
static void make_square(const planish_shape *s, int32_t node, double normal[3]) {
    const int32_t e = s->edge_at[node][0];
    const double *tangent = s->tangent[e][s->edge[e][1] == node];
    const double along = pl_dot(3, normal, tangent);
    double rest[3];
    for (int d = 0; d < 3; d++)
        rest[d] = normal[d] - along * tangent[d];
    if (along * along < 0.5)
        pl_unit(3, rest, normal);
}

/** Compute the normal of the fan at a node that has facet f, and write it to all of its corners there. */
static void bend_fan(const pl_features *w, int32_t node, int32_t f) {
    planish_shape *s = w->shape;
    int32_t first = f;
    int k = pl_corner_at(s, f, node), is_closed = 0;
    while (!is_closed && pl_fan_next(w, PL_EDGE_APART, 0, &first, &k))
        is_closed = first == f;
    double sum[3] = {0}, normal[3];
    int32_t at = first;
    const int begin = k;
    do
        add_normal(s, at, k, sum);
    while (pl_fan_next(w, PL_EDGE_APART, 1, &at, &k) && at != first);
    if (!pl_unit(3, sum, normal))
        memcpy(normal, s->normal[f], sizeof normal);
    if (!is_closed && s->node_class[node] == PL_ON_CURVE)
        make_square(s, node, normal);
    at = first;
    k = begin;
    do
        memcpy(w->corner_normal[at][k], normal, sizeof normal);
    while (pl_fan_next(w, PL_EDGE_APART, 1, &at, &k) && at != first);
}

static void bend_nodes(void *context, int64_t begin, int64_t end, int thread) {
    const pl_features *w = context;
    const planish_shape *s = w->shape;
    (void)thread;
    for (int64_t node = begin; node < end; node++)
        for (int64_t i = s->offset[node]; i < s->offset[node + 1]; i++) {
            const int32_t f = s->facet_of[i];
            const double *n = w->corner_normal[f][pl_corner_at(s, f, (int32_t)node)];
            if (n[0] == 0 && n[1] == 0 && n[2] == 0)
                bend_fan(w, (int32_t)node, f);
        }
}

void pl_shape_bend(pl_features *w) {
    pl_parallel_for(w->threads, w->shape->n_edges, CHUNK, bend_edges, w);
    pl_parallel_for(w->threads, w->shape->n_nodes, CHUNK, bend_nodes, w);
}

/** Whether all facets of a node have the same normal there. */
static int has_one_normal(const pl_features *w, int32_t node) {
    const planish_shape *s = w->shape;
    const int32_t *at = s->facet_of + s->offset[node];
    const double *first = w->corner_normal[at[0]][pl_corner_at(s, at[0], node)];
    for (int64_t i = 1; i < s->offset[node + 1] - s->offset[node]; i++)
        if (memcmp(w->corner_normal[at[i]][pl_corner_at(s, at[i], node)], first,
                   3 * sizeof *first) != 0)
            return 0;
    return 1;
}

int pl_shape_pack_normals(pl_features *w, planish_error *error) {
    planish_shape *s = w->shape;
    uint32_t n = 0;
    s->normal_at = pl_alloc(s->n_nodes + 1, sizeof *s->normal_at);
    for (int32_t node = 0; s->normal_at && node < s->n_nodes; node++) {
        s->normal_at[node] = n;
        n += has_one_normal(w, node) ? 1 : (uint32_t)(s->offset[node + 1] - s->offset[node]);
    }
    s->corner_normal = s->normal_at ? pl_alloc(n, sizeof *s->corner_normal) : NULL;
    if (!s->corner_normal)
        return pl_fail_memory(error, "the shape");
    s->normal_at[s->n_nodes] = n;
    for (int32_t node = 0; node < s->n_nodes; node++)
        for (uint32_t i = 0; i < s->normal_at[node + 1] - s->normal_at[node]; i++) {
            const int32_t f = s->facet_of[s->offset[node] + i];
            memcpy(s->corner_normal[s->normal_at[node] + i],
                   w->corner_normal[f][pl_corner_at(s, f, node)], sizeof *s->corner_normal);
        }
    return PLANISH_OK;
}

/* ---- points ------------------------------------------------------------------------------------ */

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

/** Compute the inner control points of edge k of a facet, off the corners next to them. */
static void control_edge(const planish_shape *s, int32_t f, int k, double control[2][3]) {
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
    const double *n = pl_corner_normal(s, f, k), *q = pl_corner_normal(s, f, m);
    const double up = is_straight ? 0 : pl_dot(3, d, n), down = is_straight ? 0 : pl_dot(3, d, q);
    for (int i = 0; i < 3; i++) {
        control[0][i] = (d[i] - up * n[i]) / 3;
        control[1][i] = -(d[i] - down * q[i]) / 3;
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
        control_edge(s, f, k, edge[k]);
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
        memcpy(blended, s->normal[f], sizeof blended);
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
