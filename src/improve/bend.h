/* bend: Hessian of RR^2 of four elements at a time by their edges from the first node.
 *
 * Of tetrahedra, with edges e_i from node 0, n_i the normals of the faces at it,
 * alpha = sum |e_i|^2 n_i, w_i = the edges' part of d alpha / d e_i, N = |alpha|^2, s the sum of all
 * faces and u_f their unit normals:
 *
 *   log RR^2 = log N + 2 log s - 4 log D + const
 *   hess |a x b| = (|b|^2, -a.b; -a.b, |a|^2) u u^T / |a x b|, and the skew parts of u
 *
 * Of triangles, with s the sum of the edges' lengths |e| and u = e / |e|:
 *
 *   log RR^2 = sum log |e|^2 + 2 log s - 4 log D + const
 *   hess log |e|^2 = 2 (I - 2 u u^T) / |e|^2,  hess |e| = (I - u u^T) / |e|
 *
 *   bend_tetrahedra, bend_triangles     blocks of edges (i, j), i <= j
 *   bend_keep_positive                  their positive part, of triangles
 */
#ifndef PL_IMPROVE_BEND_H
#define PL_IMPROVE_BEND_H

#include "geometry/inline.h"

#include <math.h>
#include <stdint.h>

/* Added where 0 may be divided by 0. */
#define BEND_TINY 1e-300

/** Four doubles, one of each tetrahedron; the compiler splits them where the CPU has less. */
typedef double bend_pack __attribute__((vector_size(32)));

/** Result of a comparison of these: all bits of a lane, or none. */
typedef int64_t bend_mask __attribute__((vector_size(32)));

/** Vectors of four tetrahedra. */
typedef struct bend_vector {
    bend_pack x, y, z;
} bend_vector;

enum { BEND_BLOCKS = 6 }; /* 11 12 13 22 23 33; in the plane 3: 11 12 22 */

/** Blocks [dim][dim] by rows. */
typedef bend_pack bend_block[9];

PL_INLINE bend_pack bend_of(double x) {
    return (bend_pack){x, x, x, x};
}

/** Return a where is_a, else b. */
PL_INLINE bend_pack bend_choose(bend_mask is_a, bend_pack a, bend_pack b) {
    return (bend_pack)((is_a & (bend_mask)a) | (~is_a & (bend_mask)b));
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

/** Set the block of edges i and j to the products of slopes plus the common part of the bend of N. */
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

/* ---- triangles ------------------------------------------------------------------------------- */

/** Add factor a b^T, in the plane. */
PL_INLINE void bend_add_plane(bend_pack *h, bend_pack factor, bend_vector a, bend_vector b) {
    h[0] += factor * a.x * b.x;
    h[1] += factor * a.x * b.y;
    h[2] += factor * a.y * b.x;
    h[3] += factor * a.y * b.y;
}

/** Set the blocks of four triangles with these edges, whose z is 0. */
PL_INLINE void bend_triangles(const bend_vector e[2], bend_block h[BEND_BLOCKS]) {
    static const int I[] = {0, 0, 1}, J[] = {0, 1, 1};
    const bend_vector edge[] = {e[0], e[1], bend_difference(e[1], e[0])};
    const bend_pack inverse_d = 1 / (e[0].x * e[1].y - e[0].y * e[1].x), of_d = 4 * inverse_d;
    const bend_vector slope_d[] = {{inverse_d * e[1].y, -inverse_d * e[1].x, bend_of(0)},
                                   {-inverse_d * e[0].y, inverse_d * e[0].x, bend_of(0)}};
    bend_pack square[3], length[3], s = bend_of(0), rr2 = inverse_d * inverse_d * 0.25;
    bend_vector u[3], along[3]; /* along: slopes of log |e|^2 + 2 log s by each edge */
    bend_block own[3];          /* what each edge adds to the blocks that it is in */
    for (int k = 0; k < 3; k++) {
        square[k] = bend_dot(edge[k], edge[k]);
        length[k] = bend_sqrt(square[k]);
        s += length[k];
    }
    rr2 = rr2 * rr2 * (square[0] * square[1]) * (square[2] * (s * s));
    for (int k = 0; k < 3; k++) {
        const bend_pack of_square = 2 / square[k], of_s = 2 / (s * length[k]);
        u[k] = bend_scaled(1 / length[k], edge[k]);
        along[k] = bend_scaled(of_square + of_s, edge[k]);
        for (int c = 0; c < 4; c++)
            own[k][c] = c == 0 || c == 3 ? of_square + of_s : bend_of(0);
        bend_add_plane(own[k], -(2 * of_square + of_s), u[k], u[k]);
    }
    const bend_vector slope_s[] = {bend_difference(u[0], u[2]), bend_sum(u[1], u[2])};
    const bend_vector slope[] = {
        bend_difference(bend_difference(along[0], along[2]), bend_scaled(bend_of(4), slope_d[0])),
        bend_difference(bend_sum(along[1], along[2]), bend_scaled(bend_of(4), slope_d[1]))};
    for (int c = 0; c < 4; c++) {
        h[0][c] = own[0][c] + own[2][c];
        h[1][c] = -own[2][c];
        h[2][c] = own[1][c] + own[2][c];
    }
    h[1][1] -= of_d;
    h[1][2] += of_d;
    for (int q = 0; q < 3; q++) {
        bend_add_plane(h[q], bend_of(1), slope[I[q]], slope[J[q]]);
        bend_add_plane(h[q], -2 / (s * s), slope_s[I[q]], slope_s[J[q]]);
        bend_add_plane(h[q], bend_of(4), slope_d[I[q]], slope_d[J[q]]);
        for (int c = 0; c < 4; c++)
            h[q][c] *= rr2;
    }
}

/** Displacements of the edges of four triangles: x and y of the first, x and y of the second. */
typedef struct bend_move {
    bend_pack c[4];
} bend_move;

PL_INLINE bend_pack bend_move_dot(const bend_move *a, const bend_move *b) {
    return (a->c[0] * b->c[0] + a->c[1] * b->c[1]) + (a->c[2] * b->c[2] + a->c[3] * b->c[3]);
}

/** Return p a + q b. */
PL_INLINE bend_move bend_mix(bend_pack p, const bend_move *a, bend_pack q, const bend_move *b) {
    return (bend_move){{p * a->c[0] + q * b->c[0], p * a->c[1] + q * b->c[1],
                        p * a->c[2] + q * b->c[2], p * a->c[3] + q * b->c[3]}};
}

/** Return the blocks of four triangles times a displacement. */
PL_INLINE bend_move bend_apply(bend_block h[BEND_BLOCKS], const bend_move *x) {
    const bend_pack *c = x->c;
    return (bend_move){{(h[0][0] * c[0] + h[0][1] * c[1]) + (h[1][0] * c[2] + h[1][1] * c[3]),
                        (h[0][2] * c[0] + h[0][3] * c[1]) + (h[1][2] * c[2] + h[1][3] * c[3]),
                        (h[1][0] * c[0] + h[1][2] * c[1]) + (h[2][0] * c[2] + h[2][1] * c[3]),
                        (h[1][1] * c[0] + h[1][3] * c[1]) + (h[2][2] * c[2] + h[2][3] * c[3])}};
}

/** Set h to l w w^T, for the eigenvector w with the positive eigenvalue l that belongs to the unit
 *  vector u, or add it. hu: h u; c: u.hu. See bend_keep_positive. */
PL_INLINE void bend_add_positive(const bend_move *u, const bend_move *hu, bend_pack c,
                                 bend_block h[BEND_BLOCKS]) {
    const bend_move gs = bend_mix(bend_of(1), hu, -c, u);
    const bend_pack l = 0.5 * (c + bend_sqrt(c * c + 4 * bend_move_dot(&gs, &gs)));
    const bend_move w = bend_mix(bend_of(1), &gs, l, u);
    const bend_pack factor = l / (bend_move_dot(&w, &w) + BEND_TINY);
    const bend_vector first = {w.c[0], w.c[1], bend_of(0)}, second = {w.c[2], w.c[3], bend_of(0)};
    bend_add_plane(h[0], factor, first, first);
    bend_add_plane(h[1], factor, first, second);
    bend_add_plane(h[2], factor, second, second);
}

/** Keep the part of the blocks of four triangles with these edges that has positive eigenvalues.
 *
 *  RR^2 stays as it is if a triangle turns or grows. So x.Hx = 0 for displacements x of this kind.
 *  There are an orthonormal basis s_1, s_2 of these and u_1, u_2 of the others with
 *  H u_i = c_i u_i + g s_i and H s_i = g u_i. For each i one eigenvalue is not negative:
 *  l_i = (c_i + sqrt(c_i^2 + 4 g^2)) / 2, with the eigenvector g s_i + l_i u_i. */
PL_INLINE void bend_keep_positive(const bend_vector e[2], bend_block h[BEND_BLOCKS]) {
    const bend_pack scale = 1 / bend_sqrt(bend_dot(e[0], e[0]) + bend_dot(e[1], e[1]));
    /* Orthogonal to the edges, and to the edges after a quarter turn; and b is a after one. */
    const bend_move a = {{-scale * e[1].x, scale * e[1].y, scale * e[0].x, -scale * e[0].y}};
    const bend_move b = {{-a.c[1], a.c[0], -a.c[3], a.c[2]}};
    const bend_move ha = bend_apply(h, &a), hb = bend_apply(h, &b);
    const bend_pack aa = bend_move_dot(&a, &ha), ab = bend_move_dot(&a, &hb);
    const bend_pack bb = bend_move_dot(&b, &hb), half = 0.5 * (aa - bb);
    const bend_pack root = bend_sqrt(half * half + ab * ab) + BEND_TINY;
    const bend_pack tangent = ab / (half + bend_choose(half < 0, -root, root));
    const bend_pack cosine = 1 / bend_sqrt(1 + tangent * tangent), sine = tangent * cosine;
    const bend_move u[] = {bend_mix(cosine, &a, sine, &b), bend_mix(-sine, &a, cosine, &b)};
    const bend_move hu[] = {bend_mix(cosine, &ha, sine, &hb), bend_mix(-sine, &ha, cosine, &hb)};
    for (int q = 0; q < 3; q++)
        for (int c = 0; c < 4; c++)
            h[q][c] = bend_of(0);
    bend_add_positive(&u[0], &hu[0], aa + tangent * ab, h);
    bend_add_positive(&u[1], &hu[1], bb - tangent * ab, h);
}

#endif
