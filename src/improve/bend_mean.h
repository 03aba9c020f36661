/* bend_mean: Hessian of mu^2, the squared mean ratio, of four corners at a time by their edges from the
 * corner.
 *
 * With edges e_i, E = sum Q_ij e_i.e_j a weighted sum of the squared edges of the corner's simplex
 * (geometry/corner.h), q_i = sum Q_ij e_j, D their determinant and n_i = d D / d e_i:
 *
 *   log mu^2 = 2 log E - k log D + const,  k = 4/3, in the plane 2
 *   a_i = 4 q_i / E,  b_i = k n_i / D
 *   block ij / mu^2 = (a_i - b_i) (a_j - b_j)^T - a_i a_j^T / 2 + b_i b_j^T / k + 4 Q_ij / E I
 *                     - k / D d n_i / d e_j
 *
 * No sign of D matters. mu^2 stays as it is if a corner turns or grows, as RR^2 of a triangle does.
 *
 *   bend_corners     blocks of edges (i, j), i <= j
 */
#ifndef PL_IMPROVE_BEND_MEAN_H
#define PL_IMPROVE_BEND_MEAN_H

#include "geometry/cube_root.h"
#include "improve/bend.h"

/** Forms of four corners: weights in E of their edges, then of those between the edges' ends, as in
 *  pl_corner_form; mu^2 counts as factor E^2 D^-k. */
typedef struct bend_form {
    bend_pack weight[6], factor;
} bend_form;

/** Weight of the edge between the ends of edges i and j. */
PL_INLINE bend_pack bend_weight_between(const bend_form *form, int i, int j, const int dim) {
    return form->weight[dim + i + j - 1];
}

/** Add factor a b^T. */
PL_INLINE void bend_add_outer(bend_pack *h, bend_pack factor, bend_vector a, bend_vector b,
                              const int dim) {
    if (dim == 3)
        bend_add_product(h, bend_scaled(factor, a), b);
    else
        bend_add_plane(h, factor, a, b);
}

/** Return E; q [dim]: as above. */
PL_INLINE bend_pack bend_find_pulls(const bend_vector e[3], const bend_form *form, bend_vector q[3],
                                    const int dim) {
    bend_pack E = bend_of(0);
    for (int i = 0; i < dim; i++)
        q[i] = bend_scaled(form->weight[i], e[i]);
    for (int i = 0; i < dim; i++)
        for (int j = i + 1; j < dim; j++) {
            const bend_vector pull =
                bend_scaled(bend_weight_between(form, i, j, dim), bend_difference(e[j], e[i]));
            q[i] = bend_difference(q[i], pull);
            q[j] = bend_sum(q[j], pull);
        }
    for (int i = 0; i < dim; i++)
        E += bend_dot(e[i], q[i]);
    return E;
}

/** Return D; n [dim]: as above. */
PL_INLINE bend_pack bend_find_normals(const bend_vector e[3], bend_vector n[3], const int dim) {
    for (int i = 0; i < dim && dim == 3; i++)
        n[i] = bend_cross(e[(i + 1) % 3], e[(i + 2) % 3]);
    if (dim == 2) {
        n[0] = (bend_vector){e[1].y, -e[1].x, bend_of(0)};
        n[1] = (bend_vector){-e[0].y, e[0].x, bend_of(0)};
    }
    return bend_dot(e[0], n[0]);
}

/** Return the k-th power of 1 / |D|. */
PL_INLINE bend_pack bend_inverse_power(bend_pack D, const int dim) {
    const bend_pack square = D * D;
    if (dim == 2)
        return 1 / square;
    const bend_pack root = {pl_cube_root(square[0]), pl_cube_root(square[1]),
                            pl_cube_root(square[2]), pl_cube_root(square[3])};
    return 1 / (root * root);
}

/** Q_ij. */
PL_INLINE bend_pack bend_weight_of(const bend_form *form, int i, int j, const int dim) {
    if (i != j)
        return -bend_weight_between(form, i, j, dim);
    bend_pack sum = form->weight[i];
    for (int k = 0; k < dim; k++)
        if (k != i)
            sum += bend_weight_between(form, i, k, dim);
    return sum;
}

/** Add -of_d d n_i / d e_j of all edges. */
PL_INLINE void bend_turn_normals(const bend_vector e[3], bend_pack of_d, bend_block h[BEND_BLOCKS],
                                 const int dim) {
    if (dim == 2) {
        h[1][1] -= of_d;
        h[1][2] += of_d;
        return;
    }
    bend_add_skew(h[1], bend_scaled(of_d, e[2]));
    bend_add_skew(h[2], bend_scaled(-of_d, e[1]));
    bend_add_skew(h[4], bend_scaled(of_d, e[0]));
}

/** Set the blocks of four corners with these edges. */
PL_INLINE void bend_corners(const bend_vector e[3], const bend_form *form,
                            bend_block h[BEND_BLOCKS], const int dim) {
    const double k = dim == 3 ? 4.0 / 3 : 2;
    bend_vector q[3], n[3], a[3], b[3], slope[3];
    const bend_pack E = bend_find_pulls(e, form, q, dim), D = bend_find_normals(e, n, dim);
    const bend_pack of_e = 4 / E, of_d = k / D;
    const bend_pack mu2 = form->factor * (E * E) * bend_inverse_power(D, dim);
    for (int i = 0; i < dim; i++) {
        a[i] = bend_scaled(of_e, q[i]);
        b[i] = bend_scaled(of_d, n[i]);
        slope[i] = bend_difference(a[i], b[i]);
    }
    for (int i = 0, at = 0; i < dim; i++)
        for (int j = i; j < dim; j++, at++) {
            const bend_pack diagonal = of_e * bend_weight_of(form, i, j, dim);
            for (int c = 0; c < dim * dim; c++)
                h[at][c] = c % (dim + 1) == 0 ? diagonal : bend_of(0);
            bend_add_outer(h[at], bend_of(1), slope[i], slope[j], dim);
            bend_add_outer(h[at], bend_of(-0.5), a[i], a[j], dim);
            bend_add_outer(h[at], bend_of(1 / k), b[i], b[j], dim);
        }
    bend_turn_normals(e, of_d, h, dim);
    for (int at = 0; at < dim * (dim + 1) / 2; at++)
        for (int c = 0; c < dim * dim; c++)
            h[at][c] *= mu2;
}

#endif
