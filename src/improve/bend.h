/* bend: Hessian of RR^2 of four tetrahedra at a time by their edges from the first node.
 *
 * Formulas: docs/algorithm.md. With edges e_i from node 0, n_i the normals of the faces at it,
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

/** Set the blocks of four tetrahedra with these edges. */
PL_INLINE void bend_tetrahedra(const bend_vector e[3], bend_block h[BEND_BLOCKS]) {
    static const int I[] = {0, 0, 0, 1, 1, 2}, J[] = {0, 1, 2, 1, 2, 2};
    const bend_vector n[3] = {bend_cross(e[1], e[2]), bend_cross(e[2], e[0]),
                              bend_cross(e[0], e[1])};
    const bend_vector opposite = bend_sum(n[0], bend_sum(n[1], n[2]));
    const bend_pack square[3] = {bend_dot(e[0], e[0]), bend_dot(e[1], e[1]), bend_dot(e[2], e[2])};
    const bend_vector alpha =
        bend_sum(bend_scaled(square[0], n[0]),
                 bend_sum(bend_scaled(square[1], n[1]), bend_scaled(square[2], n[2])));
    const bend_pack D = bend_dot(e[0], n[0]), N = bend_dot(alpha, alpha);
    const bend_pack area[4] = {bend_sqrt(bend_dot(n[0], n[0])), bend_sqrt(bend_dot(n[1], n[1])),
                               bend_sqrt(bend_dot(n[2], n[2])),
                               bend_sqrt(bend_dot(opposite, opposite))};
    const bend_pack s = (area[0] + area[1]) + (area[2] + area[3]);
    const bend_pack inverse_d = 1 / D, inverse_s = 1 / s, of_n = 2 / N, of_s = 2 * inverse_s;
    const bend_pack s_d2 = s * inverse_d * inverse_d, rr2 = N * s_d2 * s_d2 * (1.0 / 36);
    bend_pack per_area[4];
    bend_vector u[4], slope_n[3], slope_s[3], slope_d[3], slope[3], w[3];
    for (int f = 0; f < 4; f++) {
        per_area[f] = 1 / area[f];
        u[f] = bend_scaled(per_area[f], f < 3 ? n[f] : opposite);
        per_area[f] *= of_s;
    }
    const bend_vector a = bend_difference(e[1], e[0]), b = bend_difference(e[2], e[0]);
    const bend_vector by_a = bend_cross(b, u[3]), by_b = bend_cross(u[3], a);
    slope_s[0] = bend_difference(bend_sum(bend_cross(e[1], u[2]), bend_cross(u[1], e[2])),
                                 bend_sum(by_a, by_b));
    slope_s[1] = bend_sum(bend_sum(bend_cross(e[2], u[0]), bend_cross(u[2], e[0])), by_a);
    slope_s[2] = bend_sum(bend_sum(bend_cross(e[0], u[1]), bend_cross(u[0], e[1])), by_b);
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        w[i] = bend_difference(bend_scaled(square[j], e[k]), bend_scaled(square[k], e[j]));
        slope_n[i] = bend_scaled(
            of_n, bend_sum(bend_scaled(2 * bend_dot(n[i], alpha), e[i]), bend_cross(alpha, w[i])));
        slope_s[i] = bend_scaled(inverse_s, slope_s[i]);
        slope_d[i] = bend_scaled(inverse_d, n[i]);
        slope[i] = bend_sum(slope_n[i], bend_difference(bend_scaled(bend_of(2), slope_s[i]),
                                                        bend_scaled(bend_of(4), slope_d[i])));
    }
    for (int q = 0; q < BEND_BLOCKS; q++) {
        const int i = I[q], j = J[q];
        bend_pack *block = h[q];
        for (int c = 0; c < 9; c++)
            block[c] = bend_of(0);
        bend_add_product(block, slope[i], slope[j]);
        bend_add_product(block, bend_scaled(bend_of(-1), slope_n[i]), slope_n[j]);
        bend_add_product(block, bend_scaled(bend_of(-2), slope_s[i]), slope_s[j]);
        bend_add_product(block, bend_scaled(bend_of(4), slope_d[i]), slope_d[j]);
        bend_add_identity(block, of_n * bend_dot(w[i], w[j]));
        bend_add_product(block, bend_scaled(-of_n, w[j]), w[i]);
        bend_add_product(block, bend_scaled(of_n, e[i]),
                         bend_sum(bend_scaled(4 * bend_dot(n[i], n[j]), e[j]),
                                  bend_scaled(bend_of(2), bend_cross(n[i], w[j]))));
        bend_add_product(block, bend_scaled(2 * of_n, bend_cross(n[j], w[i])), e[j]);
    }
    /* The bends of the faces: those of n[f] have the edges next to f. */
    const bend_pack ab = bend_dot(a, b), aa = bend_dot(a, a), bb = bend_dot(b, b);
    const bend_pack far = per_area[3];
    const bend_pack dot01 = bend_dot(e[0], e[1]), dot12 = bend_dot(e[1], e[2]),
                    dot02 = bend_dot(e[0], e[2]);
#define FACE(q, f, factor) bend_add_product(h[q], bend_scaled(factor, u[f]), u[f])
    FACE(0, 1, square[2] * per_area[1]);
    FACE(0, 2, square[1] * per_area[2]);
    FACE(0, 3, (aa + bb - 2 * ab) * far);
    FACE(1, 2, -dot01 * per_area[2]);
    FACE(1, 3, (ab - bb) * far);
    FACE(2, 1, -dot02 * per_area[1]);
    FACE(2, 3, (ab - aa) * far);
    FACE(3, 0, square[2] * per_area[0]);
    FACE(3, 2, square[0] * per_area[2]);
    FACE(3, 3, bb * far);
    FACE(4, 0, -dot12 * per_area[0]);
    FACE(4, 3, -ab * far);
    FACE(5, 0, square[1] * per_area[0]);
    FACE(5, 1, square[0] * per_area[1]);
    FACE(5, 3, aa * far);
#undef FACE
    bend_add_identity(h[0], 2 * of_n * bend_dot(n[0], alpha));
    bend_add_identity(h[3], 2 * of_n * bend_dot(n[1], alpha));
    bend_add_identity(h[5], 2 * of_n * bend_dot(n[2], alpha));
    const bend_vector c0 = bend_cross(e[0], alpha), c1 = bend_cross(e[1], alpha),
                      c2 = bend_cross(e[2], alpha);
    bend_add_product(h[1], bend_scaled(2 * of_n, e[0]), c2);
    bend_add_product(h[1], bend_scaled(-2 * of_n, c2), e[1]);
    bend_add_product(h[4], bend_scaled(2 * of_n, e[1]), c0);
    bend_add_product(h[4], bend_scaled(-2 * of_n, c0), e[2]);
    bend_add_product(h[2], bend_scaled(2 * of_n, c1), e[2]);
    bend_add_product(h[2], bend_scaled(-2 * of_n, e[0]), c1);
    const bend_pack of_d = 4 * inverse_d;
    bend_vector skew[3]; /* of blocks 23, 31, 12 */
    for (int i = 0; i < 3; i++)
        skew[i] = bend_difference(
            bend_difference(bend_scaled(of_d, e[i]), bend_scaled(of_n * square[i], alpha)),
            bend_scaled(of_s, bend_sum(u[i], u[3])));
    bend_add_skew(h[4], skew[0]);
    bend_add_skew(h[2], bend_scaled(bend_of(-1), skew[1]));
    bend_add_skew(h[1], skew[2]);
    for (int q = 0; q < BEND_BLOCKS; q++)
        for (int c = 0; c < 9; c++)
            h[q][c] *= rr2;
}

#endif
