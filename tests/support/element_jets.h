/* element_jets: the measures of an element whose last vertex moves, as jets, by textbook formulas.
 *
 * Of the element with the link facet p [dim] and the node x: D by Sarrus' rule, lengths by
 * Pythagoras, areas by the cross product, the circumradius by Cramer's rule for the point that is
 * as far from all vertices; nothing of src.
 */
#ifndef TEST_SUPPORT_ELEMENT_JETS_H
#define TEST_SUPPORT_ELEMENT_JETS_H

#include "support/jets.h"

/** Vertices: those of the facet, then x; all as jets, the first ones constant. */
typedef struct element_jets {
    int dim;
    jet vertex[4][3];
} element_jets;

static inline int element_n_edges(int dim) {
    return dim == 3 ? 6 : 3;
}

static inline void jet_between(const element_jets *e, int from, int to, jet edge[3]) {
    for (int d = 0; d < e->dim; d++)
        edge[d] = jet_sum(e->vertex[to][d], -1, e->vertex[from][d]);
}

static inline jet jet_dot(int dim, const jet a[3], const jet b[3]) {
    jet sum = jet_product(a[0], b[0]);
    for (int d = 1; d < dim; d++)
        sum = jet_sum(sum, 1, jet_product(a[d], b[d]));
    return sum;
}

static inline void jet_cross(const jet a[3], const jet b[3], jet c[3]) {
    for (int d = 0; d < 3; d++) {
        const int i = (d + 1) % 3, j = (d + 2) % 3;
        c[d] = jet_sum(jet_product(a[i], b[j]), -1, jet_product(a[j], b[i]));
    }
}

/** The square of the distance of two vertices. */
static inline jet element_square(const element_jets *e, int i, int j) {
    jet edge[3];
    jet_between(e, i, j, edge);
    return jet_part(jet_dot(e->dim, edge, edge));
}

/** Twice the area of a face, squared. */
static inline jet element_area_square(const element_jets *e, int i, int j, int k) {
    jet a[3], b[3], c[3];
    jet_between(e, i, j, a);
    jet_between(e, i, k, b);
    jet_cross(a, b, c);
    return jet_part(jet_dot(3, c, c));
}

/** D, positive where x is on the positive side of the facet. */
static inline jet element_determinant(const element_jets *e) {
    jet a[3], b[3], c[3], n[3];
    jet_between(e, 0, e->dim, a);
    jet_between(e, 0, 1, b);
    if (e->dim == 2)
        return jet_part(jet_sum(jet_product(b[0], a[1]), -1, jet_product(b[1], a[0])));
    jet_between(e, 0, 2, c);
    jet_cross(b, c, n);
    return jet_part(jet_dot(3, a, n));
}

/** (2 R D)^2. */
static inline jet element_circumradius_square(const element_jets *e) {
    if (e->dim == 2)
        return jet_part(jet_product(element_square(e, 0, 1),
                                    jet_product(element_square(e, 1, 2), element_square(e, 2, 0))));
    jet u[3][3], minor[3], sum[3];
    for (int j = 0; j < 3; j++)
        jet_between(e, 3, j, u[j]);
    for (int j = 0; j < 3; j++) {
        const jet square = jet_dot(3, u[j], u[j]);
        jet_cross(u[(j + 1) % 3], u[(j + 2) % 3], minor);
        for (int d = 0; d < 3; d++) {
            const jet term = jet_product(square, minor[d]);
            sum[d] = j == 0 ? term : jet_sum(sum[d], 1, term);
        }
    }
    return jet_part(jet_dot(3, sum, sum));
}

/** Perimeter, or twice the surface. */
static inline jet element_surface(const element_jets *e) {
    jet sum = jet_constant(0);
    for (int i = 0; i <= e->dim; i++) {
        const int n = e->dim + 1, j = (i + 1) % n, k = (i + 2) % n;
        const jet square = e->dim == 3 ? element_area_square(e, i, j, k) : element_square(e, i, j);
        sum = jet_sum(sum, 1, jet_part(jet_power(square, 0.5)));
    }
    return sum;
}

/** RR^2 = (2 R D)^2 s^2 / (36 D^4), or / (16 D^4). */
static inline jet element_radius_ratio_square(const element_jets *e) {
    const jet surface = element_surface(e), d4 = jet_power(element_determinant(e), -4);
    const jet n = jet_product(element_circumradius_square(e), jet_product(surface, surface));
    return jet_scaled(1 / (quad)(e->dim == 3 ? 36 : 16), jet_product(n, d4));
}

/** The squares of all edges. */
static inline void element_squares(const element_jets *e, jet square[6]) {
    for (int i = 0, k = 0; i < e->dim; i++)
        for (int j = i + 1; j <= e->dim; j++)
            square[k++] = element_square(e, i, j);
}

/** The inverse of the mean ratio, squared: 12 (3 V)^(2/3) / E or 4 sqrt(3) A / E with D = 6 V, 2 A.
 */
static inline jet element_mean_ratio_square(const element_jets *e) {
    jet square[6], sum, d = element_determinant(e);
    element_squares(e, square);
    sum = square[0];
    for (int k = 1; k < element_n_edges(e->dim); k++)
        sum = jet_sum(sum, 1, square[k]);
    sum = jet_product(sum, sum);
    if (e->dim == 2)
        return jet_scaled(1 / (quad)12,
                          jet_product(sum, jet_product(jet_power(d, -1), jet_power(d, -1))));
    const quad root = cbrtq(d.value), value = 1 / (d.value * root),
               slope = -4 * value / 3 / d.value;
    return jet_scaled(cbrtq(16) / 144,
                      jet_product(sum, jet_function(d, value, slope, -7 * slope / 3 / d.value)));
}

/** (mean of l^64)^(1/32) (mean of l^-64)^(1/32). */
static inline jet element_edge_ratio_square(const element_jets *e) {
    const int n = element_n_edges(e->dim);
    jet square[6], large = jet_constant(0), small = jet_constant(0);
    element_squares(e, square);
    for (int k = 0; k < n; k++) {
        large = jet_sum(large, 1 / (quad)n, jet_power_32(square[k]));
        small = jet_sum(small, 1 / (quad)n, jet_power_32(jet_power(square[k], -1)));
    }
    return jet_power(jet_product(large, small), 1.0 / 32);
}

/** 1 / sin^2 of all angles: what the squares of the facets' measures come to, by D^2 and, in space,
 *  the square of the common edge. */
static inline void element_angles(const element_jets *e, jet inverse[6]) {
    const int dim = e->dim, n = dim + 1;
    const jet d = jet_power(element_determinant(e), -1), d2 = jet_product(d, d);
    jet facet[4];
    for (int i = 0; i <= dim; i++)
        facet[i] = dim == 3 ? element_area_square(e, (i + 1) % n, (i + 2) % n, (i + 3) % n)
                            : element_square(e, (i + 1) % n, (i + 2) % n);
    for (int i = 0, k = 0; i < dim; i++)
        for (int j = i + 1; j <= dim; j++, k++) {
            inverse[k] = jet_product(jet_product(facet[i], facet[j]), d2);
            if (dim == 3) {
                const int a = i > 0 ? 0 : j > 1 ? 1 : 2, b = 6 - i - j - a;
                inverse[k] = jet_product(inverse[k], jet_power(element_square(e, a, b), -1));
            }
        }
}

#endif
