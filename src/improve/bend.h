/* bend: Hessian of RR^2 of four tetrahedra at a time by their edges from the first node.
 *
 * With edges e_i from node 0, n_i the normals of the faces at it,
 * alpha = sum |e_i|^2 n_i, w_i = the edges' part of d alpha / d e_i, N = |alpha|^2, s the sum of all
 * faces and u_f their unit normals:
 *
 *   log RR^2 = log N + 2 log s - 4 log D + const
 *   hess |a x b| = (|b|^2, -a.b; -a.b, |a|^2) u u^T / |a x b|, and the skew parts of u
 *
 *   bend_tetrahedra     blocks of edges (i, j), i <= j
 */
#ifndef PL_IMPROVE_BEND_H
#define PL_IMPROVE_BEND_H

#include "geometry/inline.h"

#include <math.h>

/** Four doubles, one of each tetrahedron; the compiler splits them where the CPU has less. */
typedef double bend_pack __attribute__((vector_size(32)));

/** Vectors of four tetrahedra. */
typedef struct bend_vector {
    bend_pack x, y, z;
} bend_vector;

enum { BEND_BLOCKS = 6 }; /* 11 12 13 22 23 33 */

/** Blocks [3][3] by rows. */
typedef bend_pack bend_block[9];

PL_INLINE bend_pack bend_of(double x) {
    return (bend_pack){x, x, x, x};
}

PL_INLINE bend_pack bend_sqrt(bend_pack a) {
    return (bend_pack){sqrt(a[0]), sqrt(a[1]), sqrt(a[2]), sqrt(a[3])};
}

PL_INLINE bend_vector bend_cross(bend_vector a, bend_vector b) {
    return (bend_vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

PL_INLINE bend_pack bend_dot(bend_vector a, bend_vector b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

PL_INLINE bend_vector bend_scaled(bend_pack s, bend_vector a) {
    return (bend_vector){s * a.x, s * a.y, s * a.z};
}

PL_INLINE bend_vector bend_sum(bend_vector a, bend_vector b) {
    return (bend_vector){a.x + b.x, a.y + b.y, a.z + b.z};
}

PL_INLINE bend_vector bend_difference(bend_vector a, bend_vector b) {
    return (bend_vector){a.x - b.x, a.y - b.y, a.z - b.z};
}

/** Add a b^T. */
PL_INLINE void bend_add_product(bend_pack *h, bend_vector a, bend_vector b) {
    h[0] += a.x * b.x;
    h[1] += a.x * b.y;
    h[2] += a.x * b.z;
    h[3] += a.y * b.x;
    h[4] += a.y * b.y;
    h[5] += a.y * b.z;
    h[6] += a.z * b.x;
    h[7] += a.z * b.y;
    h[8] += a.z * b.z;
}

/** Add the matrix of v x. */
PL_INLINE void bend_add_skew(bend_pack *h, bend_vector v) {
    h[1] -= v.z;
    h[2] += v.y;
    h[3] += v.z;
    h[5] -= v.x;
    h[6] -= v.y;
    h[7] += v.x;
}

PL_INLINE void bend_add_identity(bend_pack *h, bend_pack a) {
    h[0] += a;
    h[4] += a;
    h[8] += a;
}

/** Intermediate values of four tetrahedra: the symbols above, and parts of them. */
typedef struct bend_tetrahedron {
    bend_vector e[3], n[3],
        opposite;     /* edges, normals of the faces at node 0 and of the last one */
    bend_vector a, b; /* edges of that face from the end of e[0] */
    bend_vector alpha, w[3], u[4];
    bend_pack square[3], rr2;                                 /* |e_i|^2 */
    bend_pack inverse_d, inverse_s;                           /* 1 / D, 1 / s, */
    bend_pack of_n, of_s, per_area[4];                        /* 2 / N, 2 / s, 2 / (s |n_f|) */
    bend_vector slope_n[3], slope_s[3], slope_d[3], slope[3]; /* of log N, log s, log D, log RR^2 */
} bend_tetrahedron;

/** Set all but the slopes from the edges. */
PL_INLINE void bend_measure(const bend_vector e[3], bend_tetrahedron *t) {
    bend_pack area[4];
    t->alpha = (bend_vector){bend_of(0), bend_of(0), bend_of(0)};
    for (int i = 0; i < 3; i++) {
        t->e[i] = e[i];
        t->n[i] = bend_cross(e[(i + 1) % 3], e[(i + 2) % 3]);
        t->square[i] = bend_dot(e[i], e[i]);
        t->alpha = bend_sum(t->alpha, bend_scaled(t->square[i], t->n[i]));
        area[i] = bend_sqrt(bend_dot(t->n[i], t->n[i]));
    }
    t->a = bend_difference(e[1], e[0]);
    t->b = bend_difference(e[2], e[0]);
    t->opposite = bend_sum(t->n[0], bend_sum(t->n[1], t->n[2]));
    area[3] = bend_sqrt(bend_dot(t->opposite, t->opposite));
    const bend_pack D = bend_dot(e[0], t->n[0]), N = bend_dot(t->alpha, t->alpha);
    const bend_pack s = (area[0] + area[1]) + (area[2] + area[3]);
    t->inverse_d = 1 / D;
    t->inverse_s = 1 / s;
    t->of_n = 2 / N;
    t->of_s = 2 * t->inverse_s;
    const bend_pack s_d2 = s * t->inverse_d * t->inverse_d;
    t->rr2 = N * s_d2 * s_d2 * (1.0 / 36);
    for (int f = 0; f < 4; f++) {
        const bend_pack inverse = 1 / area[f];
        t->u[f] = bend_scaled(inverse, f < 3 ? t->n[f] : t->opposite);
        t->per_area[f] = inverse * t->of_s;
    }
}

/** Set the slopes. */
PL_INLINE void bend_find_slopes(bend_tetrahedron *t) {
    const bend_vector by_a = bend_cross(t->b, t->u[3]), by_b = bend_cross(t->u[3], t->a);
    const bend_vector far[3] = {bend_scaled(bend_of(-1), bend_sum(by_a, by_b)), by_a, by_b};
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const bend_vector near =
            bend_sum(bend_cross(t->e[j], t->u[k]), bend_cross(t->u[j], t->e[k]));
        t->w[i] =
            bend_difference(bend_scaled(t->square[j], t->e[k]), bend_scaled(t->square[k], t->e[j]));
        t->slope_n[i] =
            bend_scaled(t->of_n, bend_sum(bend_scaled(2 * bend_dot(t->n[i], t->alpha), t->e[i]),
                                          bend_cross(t->alpha, t->w[i])));
        t->slope_s[i] = bend_scaled(t->inverse_s, bend_sum(near, far[i]));
        t->slope_d[i] = bend_scaled(t->inverse_d, t->n[i]);
        t->slope[i] =
            bend_sum(t->slope_n[i], bend_difference(bend_scaled(bend_of(2), t->slope_s[i]),
                                                    bend_scaled(bend_of(4), t->slope_d[i])));
    }
}

/** Set the block of edges i and j to the products of slopes, and the part of the bend of N that all
 *  pairs have. */
PL_INLINE void bend_pair(const bend_tetrahedron *t, int i, int j, bend_pack *block) {
    for (int c = 0; c < 9; c++)
        block[c] = bend_of(0);
    bend_add_product(block, t->slope[i], t->slope[j]);
    bend_add_product(block, bend_scaled(bend_of(-1), t->slope_n[i]), t->slope_n[j]);
    bend_add_product(block, bend_scaled(bend_of(-2), t->slope_s[i]), t->slope_s[j]);
    bend_add_product(block, bend_scaled(bend_of(4), t->slope_d[i]), t->slope_d[j]);
    bend_add_identity(block, t->of_n * bend_dot(t->w[i], t->w[j]));
    bend_add_product(block, bend_scaled(-t->of_n, t->w[j]), t->w[i]);
    bend_add_product(block, bend_scaled(t->of_n, t->e[i]),
                     bend_sum(bend_scaled(4 * bend_dot(t->n[i], t->n[j]), t->e[j]),
                              bend_scaled(bend_of(2), bend_cross(t->n[i], t->w[j]))));
    bend_add_product(block, bend_scaled(2 * t->of_n, bend_cross(t->n[j], t->w[i])), t->e[j]);
}

/** Add the bend of face f, times factor. */
PL_INLINE void bend_add_face(const bend_tetrahedron *t, int f, bend_pack factor, bend_pack *block) {
    bend_add_product(block, bend_scaled(factor * t->per_area[f], t->u[f]), t->u[f]);
}

/** Add the symmetric bends of all faces: that of n[f] belongs to the edges next to f. */
PL_INLINE void bend_add_faces(const bend_tetrahedron *t, bend_block h[BEND_BLOCKS]) {
    const bend_pack ab = bend_dot(t->a, t->b), aa = bend_dot(t->a, t->a), bb = bend_dot(t->b, t->b);
    bend_add_face(t, 1, t->square[2], h[0]);
    bend_add_face(t, 2, t->square[1], h[0]);
    bend_add_face(t, 3, aa + bb - 2 * ab, h[0]);
    bend_add_face(t, 2, -bend_dot(t->e[0], t->e[1]), h[1]);
    bend_add_face(t, 3, ab - bb, h[1]);
    bend_add_face(t, 1, -bend_dot(t->e[0], t->e[2]), h[2]);
    bend_add_face(t, 3, ab - aa, h[2]);
    bend_add_face(t, 0, t->square[2], h[3]);
    bend_add_face(t, 2, t->square[0], h[3]);
    bend_add_face(t, 3, bb, h[3]);
    bend_add_face(t, 0, -bend_dot(t->e[1], t->e[2]), h[4]);
    bend_add_face(t, 3, -ab, h[4]);
    bend_add_face(t, 0, t->square[1], h[5]);
    bend_add_face(t, 1, t->square[0], h[5]);
    bend_add_face(t, 3, aa, h[5]);
}

/** Add what turns edges: the rest of the bend of N, and the skew parts of all. */
PL_INLINE void bend_add_turns(const bend_tetrahedron *t, bend_block h[BEND_BLOCKS]) {
    static const int DIAGONAL[] = {0, 3, 5};
    const bend_pack of_d = 4 * t->inverse_d, twice = 2 * t->of_n, minus = bend_of(-1);
    bend_vector c[3], skew[3]; /* of blocks 23, 31, 12 */
    for (int i = 0; i < 3; i++) {
        bend_add_identity(h[DIAGONAL[i]], twice * bend_dot(t->n[i], t->alpha));
        c[i] = bend_cross(t->e[i], t->alpha);
        skew[i] = bend_difference(bend_difference(bend_scaled(of_d, t->e[i]),
                                                  bend_scaled(t->of_n * t->square[i], t->alpha)),
                                  bend_scaled(t->of_s, bend_sum(t->u[i], t->u[3])));
    }
    bend_add_product(h[1], bend_scaled(twice, t->e[0]), c[2]);
    bend_add_product(h[1], bend_scaled(-twice, c[2]), t->e[1]);
    bend_add_product(h[4], bend_scaled(twice, t->e[1]), c[0]);
    bend_add_product(h[4], bend_scaled(-twice, c[0]), t->e[2]);
    bend_add_product(h[2], bend_scaled(twice, c[1]), t->e[2]);
    bend_add_product(h[2], bend_scaled(-twice, t->e[0]), c[1]);
    bend_add_skew(h[4], skew[0]);
    bend_add_skew(h[2], bend_scaled(minus, skew[1]));
    bend_add_skew(h[1], skew[2]);
}

/** Set the blocks of four tetrahedra with these edges. */
PL_INLINE void bend_tetrahedra(const bend_vector e[3], bend_block h[BEND_BLOCKS]) {
    static const int I[] = {0, 0, 0, 1, 1, 2}, J[] = {0, 1, 2, 1, 2, 2};
    bend_tetrahedron t;
    bend_measure(e, &t);
    bend_find_slopes(&t);
    for (int q = 0; q < BEND_BLOCKS; q++)
        bend_pair(&t, I[q], J[q], h[q]);
    bend_add_faces(&t, h);
    bend_add_turns(&t, h);
    for (int q = 0; q < BEND_BLOCKS; q++)
        for (int c = 0; c < 9; c++)
            h[q][c] *= t.rr2;
}

#endif
