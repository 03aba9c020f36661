/* kernel_link_edges: the edges of the link of a star of tetrahedra.
 *
 * An edge and the node span a face that two tetrahedra share: its area |m| / 2, m = e x r with the
 * edge e from p and r = x - p, is computed once for both. e, m and the slope u = grad |m| =
 * m / |m| x e are orthogonal to each other, hence
 *
 *     hess |m| = (|e|^2 I - e e^T - u u^T) / |m| = |e|^2 m m^T / |m|^3
 *
 *   gather_edges              constants of the edges
 *   find_areas, sum_areas     areas of the faces at x
 *   find_slopes, add_bends    gradients and Hessians of these
 */
#ifndef PL_STAR_KERNEL_LINK_EDGES_H
#define PL_STAR_KERNEL_LINK_EDGES_H

#include "star/kernel_facets.h"

/** Columns of edges. */
enum {
    EX,
    EY,
    EZ, /* e */
    QX,
    QY,
    QZ, /* p */
    EE, /* |e|^2 */
    INVERSE_AREA,
    MX,
    MY,
    MZ, /* m */
    EDGE_COLUMNS
};

/** Load the pack at edge i from a column. */
PL_INLINE lanes load_edge(const star *s, int column, int64_t i) {
    return lanes_load(pack_in_block(s->edge, EDGE_COLUMNS, column, i));
}

/** Store a pack at edge i in a column. */
PL_INLINE void store_edge(const star *s, int column, int64_t i, lanes a) {
    lanes_store(pack_in_block(s->edge, EDGE_COLUMNS, column, i), a);
}

/** Load the pack at edge i from three columns from cx on. */
PL_INLINE vec3 load_edge_vec3(const star *s, int cx, int64_t i) {
    return (vec3){load_edge(s, cx, i), load_edge(s, cx + 1, i), load_edge(s, cx + 2, i)};
}

/** Compute the constants of a pack of edges; their nodes are points of ring [.][PL_ROW]. */
PL_INLINE void gather_edges(const star *s, const uint32_t *node, const double *ring, int64_t i) {
    lanes p[PL_ROW], q[PL_ROW], e[3];
    points_to_columns(ring, node + 2 * i, 2, p);
    points_to_columns(ring, node + 2 * i + 1, 2, q);
    for (int d = 0; d < 3; d++) {
        e[d] = q[d] - p[d];
        store_edge(s, EX + d, i, e[d]);
        store_edge(s, QX + d, i, p[d]);
    }
    store_edge(s, EE, i, e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
}

/** Return m = e x r of the pack at edge i, with the node at x, and e. */
PL_INLINE vec3 face_normal(const star *s, int64_t i, vec3 x, vec3 *e) {
    *e = load_edge_vec3(s, EX, i);
    return vec3_cross(*e, vec3_minus(x, load_edge_vec3(s, QX, i)));
}

/** Find the areas of all faces at x, times two. */
PL_INLINE void find_areas(const star *s, vec3 x) {
    for (int64_t i = 0; i < s->padded_edges; i += PL_PACK) {
        vec3 e, m = face_normal(s, i, x, &e);
        lanes_store(s->area + i, lanes_sqrt(vec3_dot(m, m)));
    }
}

/** Sum of the areas of the faces at x of a pack of tetrahedra, times two. */
PL_INLINE lanes sum_areas(const star *s, int64_t i) {
    const uint32_t *edge = s->facet_edge + 3 * i;
    return (numbers_of_rows(s->area, edge, 3) + numbers_of_rows(s->area, edge + 1, 3)) +
           numbers_of_rows(s->area, edge + 2, 3);
}

/** Find the slopes and areas of all faces at x, as rows, and their sums over the faces of each
 *  tetrahedron; and for add_bends the faces' normals and inverse areas, and weights of 0. */
PL_INLINE void find_slopes(const star *s, vec3 x, const int with_bends) {
    for (int64_t i = 0; i < s->padded_edges; i += PL_PACK) {
        vec3 e, m = face_normal(s, i, x, &e);
        lanes area = lanes_sqrt(vec3_dot(m, m)), inverse = lanes_of(1) / area;
        vec3 u = vec3_scaled(vec3_cross(m, e), inverse);
        const lanes columns[PL_ROW] = {u.x, u.y, u.z, area};
        point_row rows[PL_PACK];
        columns_to_rows(columns, rows);
        for (int k = 0; k < PL_PACK; k++)
            row_store(s->edge_row + PL_ROW * (i + k), rows[k]);
        if (!with_bends)
            continue;
        store_edge(s, MX, i, m.x);
        store_edge(s, MY, i, m.y);
        store_edge(s, MZ, i, m.z);
        store_edge(s, INVERSE_AREA, i, inverse);
        lanes_store(s->shared + i, lanes_of(0));
    }
    for (int64_t i = 0; i < s->padded; i += PL_PACK) {
        point_row rows[PL_PACK];
        lanes sum[PL_ROW];
        for (int k = 0; k < PL_PACK; k++) {
            const uint32_t *edge = s->facet_edge + 3 * (i + k);
            rows[k] =
                row_plus(row_plus(row_load(s->edge_row + edge[0]), row_load(s->edge_row + edge[1])),
                         row_load(s->edge_row + edge[2]));
        }
        rows_to_columns(rows, sum);
        vec3_store(s, SX, i, (vec3){sum[0], sum[1], sum[2]});
        store(s, AREAS, i, sum[3]);
    }
}

/** Add the sum of the Hessians of the areas to h, weighted by the surfaces of the tetrahedra. */
PL_INLINE void add_bends(const star *s, lanes h[6][PL_PACKS]) {
    for (int64_t i = 0; i < s->n_facets; i++) {
        const double weight = *entry(s, OF_S, i);
        for (int c = 0; c < 3; c++)
            *number_of_row(s->shared, s->facet_edge[3 * i + c]) += weight;
    }
    for (int64_t i = 0; i < s->padded_edges; i += PL_LANES)
        for (int k = 0; k < PL_PACKS; k++) {
            int64_t j = i + k * PL_PACK;
            vec3 m = load_edge_vec3(s, MX, j);
            lanes inverse = load_edge(s, INVERSE_AREA, j);
            lanes bend = load_edge(s, EE, j) * inverse * (inverse * inverse);
            vec3 v = vec3_scaled(m, lanes_load(s->shared + j) * bend);
            h[0][k] += m.x * v.x;
            h[1][k] += m.x * v.y;
            h[2][k] += m.x * v.z;
            h[3][k] += m.y * v.y;
            h[4][k] += m.y * v.z;
            h[5][k] += m.z * v.z;
        }
}

#endif
