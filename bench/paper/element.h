/* element: RR^2 and the measure of one triangle or tetrahedron with their derivatives with respect
 * to all of its vertices at once. The library needs those of one vertex only; a solver that moves
 * all nodes together also needs what couples the vertices.
 *
 * All is made from the edges e_i = v_{i+1} - v_0 by log RR^2 = log N + 2 log S - 4 log D - log c
 * (names as in src/geometry/simplex.h, formulas in docs/paper.md). order is 0 for values, 1 for
 * gradients, 2 for Hessians as well, and constant where a call is inlined, as is dim.
 */
#ifndef PAPER_ELEMENT_H
#define PAPER_ELEMENT_H

#include "geometry/simplex.h"

enum { EDGE_VARIABLES = 9, VERTEX_VARIABLES = 12 };

/** A function of the edges; block i of the variables is e_i. */
typedef struct of_edges {
    double value;
    double gradient[EDGE_VARIABLES];
    double hessian[EDGE_VARIABLES][EDGE_VARIABLES];
} of_edges;

/** A function of the vertices; block i of the variables is v_i. */
typedef struct of_vertices {
    double value;
    double gradient[VERTEX_VARIABLES];
    double hessian[VERTEX_VARIABLES][VERTEX_VARIABLES];
} of_vertices;

/** A vector made of the edges, with its Jacobian. */
typedef struct edge_vector {
    double value[3];
    double jacobian[3][EDGE_VARIABLES];
} edge_vector;

/* ---- Pieces -------------------------------------------------------------------------------- */

/** block (i, j) of matrix += factor [w]x, the matrix of w x. */
PL_INLINE void add_cross(double factor, const double w[3], int row, int column,
                         double matrix[][EDGE_VARIABLES]) {
    for (int d = 0; d < 3; d++) {
        int next = (d + 1) % 3, last = (d + 2) % 3;
        matrix[row + d][column + next] -= factor * w[last];
        matrix[row + d][column + last] += factor * w[next];
    }
}

/** m . m, up to the part of its Hessian that comes from the second derivatives of m. */
PL_INLINE of_edges square_norm(int dim, int order, const edge_vector *m) {
    of_edges f = {.value = pl_dot(dim, m->value, m->value)};
    int n = dim * dim;
    for (int c = 0; c < n && order > 0; c++) {
        for (int d = 0; d < dim; d++)
            f.gradient[c] += 2 * m->jacobian[d][c] * m->value[d];
        for (int r = 0; r < n && order > 1; r++)
            for (int d = 0; d < dim; d++)
                f.hessian[r][c] += 2 * m->jacobian[d][r] * m->jacobian[d][c];
    }
    return f;
}

/** sum += weight sqrt(q): sqrt has the gradient g = grad q / (2 sqrt(q)) and the Hessian
 *  (hess q / 2 - g g^T) / sqrt(q). */
PL_INLINE void add_root(int dim, int order, double weight, const of_edges *q, of_edges *sum) {
    int n = dim * dim;
    double root = sqrt(q->value), g[EDGE_VARIABLES];
    sum->value += weight * root;
    for (int c = 0; c < n && order > 0; c++) {
        g[c] = q->gradient[c] / (2 * root);
        sum->gradient[c] += weight * g[c];
    }
    for (int r = 0; r < n && order > 1; r++)
        for (int c = 0; c < n; c++)
            sum->hessian[r][c] += weight / root * (q->hessian[r][c] / 2 - g[r] * g[c]);
}

/** Derivatives of sum += those of weight log f; its value is left alone. */
PL_INLINE void add_log(int dim, int order, double weight, const of_edges *f, of_edges *sum) {
    int n = dim * dim;
    double g[EDGE_VARIABLES];
    for (int c = 0; c < n && order > 0; c++) {
        g[c] = f->gradient[c] / f->value;
        sum->gradient[c] += weight * g[c];
    }
    for (int r = 0; r < n && order > 1; r++)
        for (int c = 0; c < n; c++)
            sum->hessian[r][c] += weight * (f->hessian[r][c] / f->value - g[r] * g[c]);
}

/** sum of a_m e_m */
PL_INLINE edge_vector combine(int dim, double edges[3][3], const double a[3]) {
    edge_vector u = {{0}, {{0}}};
    for (int m = 0; m < dim; m++)
        for (int d = 0; d < dim; d++) {
            u.value[d] += a[m] * edges[m][d];
            u.jacobian[d][dim * m + d] = a[m];
        }
    return u;
}

/* ---- D ------------------------------------------------------------------------------------- */

PL_INLINE of_edges determinant(int dim, int order, double edges[3][3]) {
    double normals[4][3];
    pl_cofactor_normals(dim, edges, normals);
    of_edges f = {.value = pl_determinant_of_edges(dim, edges)};
    for (int i = 0; i < dim && order > 0; i++)
        for (int d = 0; d < dim; d++)
            f.gradient[dim * i + d] = normals[i + 1][d];
    if (order > 1 && dim == 2) {
        f.hessian[0][3] = f.hessian[3][0] = 1;
        f.hessian[1][2] = f.hessian[2][1] = -1;
    }
    for (int i = 0; i < 3 && order > 1 && dim == 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        add_cross(-1, edges[k], 3 * i, 3 * j, f.hessian);
        add_cross(1, edges[k], 3 * j, 3 * i, f.hessian);
    }
    return f;
}

/* ---- S ------------------------------------------------------------------------------------- */

/** Square of u x v, twice the area of a face: m = u x v, d^2 m = 2 du x dv. */
PL_INLINE of_edges face_square(int order, double edges[3][3], const double a[3],
                               const double b[3]) {
    const edge_vector u = combine(3, edges, a), v = combine(3, edges, b);
    edge_vector m = {{0}, {{0}}};
    pl_cross(u.value, v.value, m.value);
    for (int i = 0; i < 3 && order > 0; i++) {
        add_cross(-a[i], v.value, 0, 3 * i, m.jacobian);
        add_cross(b[i], u.value, 0, 3 * i, m.jacobian);
    }
    of_edges q = square_norm(3, order, &m);
    for (int i = 0; i < 3 && order > 1; i++)
        for (int j = 0; j < 3; j++)
            add_cross(-2 * (a[i] * b[j] - b[i] * a[j]), m.value, 3 * i, 3 * j, q.hessian);
    return q;
}

PL_INLINE of_edges surface(int dim, int order, double edges[3][3]) {
    static const double of_u[4][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 1, 0}};
    static const double of_v[4][3] = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {-1, 0, 1}};
    static const double side[3][3] = {{1, 0, 0}, {0, 1, 0}, {-1, 1, 0}};
    of_edges sum = {0};
    for (int i = 0; i <= dim; i++) {
        of_edges q;
        if (dim == 3) {
            q = face_square(order, edges, of_u[i], of_v[i]);
        } else {
            const edge_vector u = combine(2, edges, side[i]);
            q = square_norm(2, order, &u);
        }
        add_root(dim, order, dim == 3 ? 0.5 : 1, &q, &sum);
    }
    return sum;
}

/* ---- N ------------------------------------------------------------------------------------- */

/** alpha = sum |e_i|^2 n_i with n_i = e_j x e_k, and its Jacobian. */
PL_INLINE edge_vector circumcentre_vector(int order, double edges[3][3], double normals[4][3]) {
    edge_vector alpha = {{0}, {{0}}};
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        const double *n = normals[i + 1];
        double li = pl_dot(3, edges[i], edges[i]);
        for (int d = 0; d < 3; d++) {
            alpha.value[d] += li * n[d];
            for (int c = 0; c < 3 && order > 0; c++)
                alpha.jacobian[d][3 * i + c] += 2 * n[d] * edges[i][c];
        }
        if (order > 0) {
            add_cross(pl_dot(3, edges[j], edges[j]), edges[k], 0, 3 * i, alpha.jacobian);
            add_cross(-pl_dot(3, edges[k], edges[k]), edges[j], 0, 3 * i, alpha.jacobian);
        }
    }
    return alpha;
}

/** hessian += 2 times that of w . alpha, w = alpha taken as constant. */
PL_INLINE void add_curvature(double edges[3][3], double normals[4][3], const double w[3],
                             double hessian[EDGE_VARIABLES][EDGE_VARIABLES]) {
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        double turned[3], block[3][EDGE_VARIABLES] = {{0}};
        pl_cross(edges[k], w, turned);
        add_cross(-pl_dot(3, edges[k], edges[k]), w, 0, 0, block);
        for (int r = 0; r < 3; r++) {
            hessian[3 * i + r][3 * i + r] += 4 * pl_dot(3, w, normals[i + 1]);
            for (int c = 0; c < 3; c++) {
                double entry =
                    block[r][c] + 2 * (edges[i][r] * turned[c] - turned[r] * edges[j][c]);
                hessian[3 * i + r][3 * j + c] += 2 * entry;
                hessian[3 * j + c][3 * i + r] += 2 * entry;
            }
        }
    }
}

PL_INLINE of_edges circumradius_square(int order, double edges[3][3]) {
    double normals[4][3];
    pl_cofactor_normals(3, edges, normals);
    const edge_vector alpha = circumcentre_vector(order, edges, normals);
    of_edges f = square_norm(3, order, &alpha);
    if (order > 1)
        add_curvature(edges, normals, alpha.value, f.hessian);
    return f;
}

/** Add log N; in the plane N is the product of the squares of the sides. Returns N. */
PL_INLINE double add_log_circumradius(int dim, int order, double edges[3][3], of_edges *sum) {
    static const double side[3][3] = {{1, 0, 0}, {0, 1, 0}, {-1, 1, 0}};
    if (dim == 3) {
        const of_edges n = circumradius_square(order, edges);
        add_log(3, order, 1, &n, sum);
        return n.value;
    }
    double product = 1;
    for (int i = 0; i < 3; i++) {
        const edge_vector u = combine(2, edges, side[i]);
        const of_edges q = square_norm(2, order, &u);
        add_log(2, order, 1, &q, sum);
        product *= q.value;
    }
    return product;
}

/* ---- RR^2 ---------------------------------------------------------------------------------- */

/** The same function of the vertices: v_0 has minus the sum of the edges' derivatives. */
PL_INLINE of_vertices to_vertices(int dim, int order, const of_edges *f) {
    of_vertices g = {.value = f->value};
    for (int r = 0; r < dim * dim && order > 0; r++) {
        int r0 = r % dim;
        g.gradient[dim + r] = f->gradient[r];
        g.gradient[r0] -= f->gradient[r];
        for (int c = 0; c < dim * dim && order > 1; c++) {
            int c0 = c % dim;
            double h = f->hessian[r][c];
            g.hessian[dim + r][dim + c] = h;
            g.hessian[r0][dim + c] -= h;
            g.hessian[dim + r][c0] -= h;
            g.hessian[r0][c0] += h;
        }
    }
    return g;
}

/** RR^2; D must be positive. */
PL_INLINE of_vertices element_ratio(int dim, int order, const double *const vertex[]) {
    double edges[3][3];
    pl_edges(dim, vertex, edges);
    of_edges log = {0};
    const of_edges d = determinant(dim, order, edges), s = surface(dim, order, edges);
    double n = add_log_circumradius(dim, order, edges, &log);
    add_log(dim, order, 2, &s, &log);
    add_log(dim, order, -4, &d, &log);
    double d2 = d.value * d.value;
    of_edges f = {.value = n * s.value * s.value / ((dim == 3 ? 9 : 16) * d2 * d2)};
    for (int r = 0; r < dim * dim && order > 0; r++) {
        f.gradient[r] = f.value * log.gradient[r];
        for (int c = 0; c < dim * dim && order > 1; c++)
            f.hessian[r][c] = f.value * (log.hessian[r][c] + log.gradient[r] * log.gradient[c]);
    }
    return to_vertices(dim, order, &f);
}

/** D, dim! times the measure. */
PL_INLINE of_vertices element_determinant(int dim, int order, const double *const vertex[]) {
    double edges[3][3];
    pl_edges(dim, vertex, edges);
    const of_edges d = determinant(dim, order, edges);
    return to_vertices(dim, order, &d);
}

#endif
