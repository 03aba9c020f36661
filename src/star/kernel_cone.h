/* kernel_cone: project a vector p on the cone {y : a_j . y <= 0 for all rows a_j}, in at most 4
 * dimensions.
 *
 * All direction finding with constraints is this one problem (docs/algorithm.md). The projection is
 * P = p - sum lambda_j a_j with lambda >= 0 the minimiser of |p - sum lambda_j a_j|: non-negative
 * least squares, solved by Lawson and Hanson's active set (1974); no more rows than dimensions
 * carry weight. Should rounding make that cycle, enumeration of the sets of rows decides: it is
 * finite whatever the rows are. Rows may be parallel, the same, opposed, or zero (ignored).
 *
 *   cone_project                                 the projection
 *   cone_active_set, cone_settle                 Lawson and Hanson's method
 *   cone_enumerate, cone_extend, cone_judge      sets of rows, one after another
 *   cone_least_squares, cone_orthogonalise       weights of the rows of one set
 *   cone_most_violated, cone_excess, cone_dot    rows against a point
 */
#ifndef PL_STAR_KERNEL_CONE_H
#define PL_STAR_KERNEL_CONE_H

#include <math.h>
#include <stdint.h>
#include <string.h>

enum {
    CONE_DIM = 4,
    CONE_ITERATIONS = 64, /* many more than rows of 4 dimensions take */
    CONE_WORKING = 24     /* rows that the enumeration looks at together */
};

/* A row is violated if it stands above this fraction of |p|; dependent on others if less than this
 * fraction of it is new: both some thousand times what rounding leaves. */
#define CONE_VIOLATED  1e-12
#define CONE_DEPENDENT 1e-12

/** The projection, and the rows that carry weight in it. */
typedef struct cone_point {
    double point[CONE_DIM];
    int n_active;
    int64_t active[CONE_DIM];    /* rows */
    double multiplier[CONE_DIM]; /* lambda > 0 of these rows */
} cone_point;

/** The problem: m rows of n <= CONE_DIM numbers. */
typedef struct cone {
    const double (*rows)[CONE_DIM];
    int64_t m;
    const double *p;
    int n;
} cone;

/** Scalar product of a and b [n]. */
static inline double cone_dot(const double *a, const double *b, int n) {
    double sum = a[0] * b[0];
    for (int i = 1; i < n; i++)
        sum += a[i] * b[i];
    return sum;
}

/** Return how far the row is above 0 at y: the distance of y from the half-space, negative inside.
 */
static inline double cone_excess(const cone *c, int64_t row, const double *y) {
    const double *a = c->rows[row];
    double length2 = cone_dot(a, a, c->n);
    return length2 > 0 ? cone_dot(a, y, c->n) / sqrt(length2) : 0;
}

/** Subtract from y what lies along the k orthonormal q; twice, so that rounding of the first time
 *  does not matter. along (may be NULL) [k] gets what there was. */
static inline void cone_orthogonalise(const double q[][CONE_DIM], int k, int n, double *y,
                                      double *along) {
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < k; i++) {
            double component = cone_dot(q[i], y, n);
            for (int d = 0; d < n; d++)
                y[d] -= component * q[i][d];
            if (along)
                along[i] = pass ? along[i] + component : component;
        }
}

/** Least squares over the k rows of set: lambda [k], and the residual p - sum lambda_j a_j. 0 if
 *  the rows are dependent. */
static inline int cone_least_squares(const cone *c, const int64_t *set, int k, double *lambda,
                                     double *residual) {
    double q[CONE_DIM][CONE_DIM], r[CONE_DIM][CONE_DIM], along[CONE_DIM] = {0};
    for (int i = 0; i < k; i++) {
        const double *a = c->rows[set[i]];
        memcpy(q[i], a, (size_t)c->n * sizeof *a);
        cone_orthogonalise((const double(*)[CONE_DIM])q, i, c->n, q[i], r[i]);
        r[i][i] = sqrt(cone_dot(q[i], q[i], c->n));
        if (!(r[i][i] > CONE_DEPENDENT * sqrt(cone_dot(a, a, c->n))))
            return 0;
        for (int d = 0; d < c->n; d++)
            q[i][d] /= r[i][i];
    }
    memcpy(residual, c->p, (size_t)c->n * sizeof *residual);
    cone_orthogonalise((const double(*)[CONE_DIM])q, k, c->n, residual, along);
    for (int i = k - 1; i >= 0; i--) {
        lambda[i] = along[i];
        for (int j = i + 1; j < k; j++)
            lambda[i] -= r[j][i] * lambda[j];
        lambda[i] /= r[i][i];
    }
    return 1;
}

/** The row that y violates most, or -1 if none is above tolerance. */
static inline int64_t cone_most_violated(const cone *c, const double *y, double tolerance) {
    int64_t worst = -1;
    for (int64_t j = 0; j < c->m; j++) {
        double excess = cone_excess(c, j, y);
        if (excess > tolerance) {
            tolerance = excess;
            worst = j;
        }
    }
    return worst;
}

/* ---- active set --------------------------------------------------------------------------- */

/** Make the multipliers of the set those of least squares; where some of these are not positive, go
 *  only as far as the first becomes 0, drop it, and try again. 0 if rows are dependent. */
static inline int cone_settle(const cone *c, cone_point *out) {
    double lambda[CONE_DIM] = {0};
    for (;;) {
        if (!cone_least_squares(c, out->active, out->n_active, lambda, out->point))
            return 0;
        int first = -1;
        double part = 1;
        for (int i = 0; i < out->n_active; i++) {
            double now = out->multiplier[i];
            double t = now > 0 ? now / (now - lambda[i]) : 0;
            if (!(lambda[i] > 0) && (first < 0 || t < part)) {
                part = t;
                first = i;
            }
        }
        for (int i = 0; i < out->n_active; i++)
            out->multiplier[i] = first < 0
                                     ? lambda[i]
                                     : out->multiplier[i] + part * (lambda[i] - out->multiplier[i]);
        if (first < 0)
            return 1;
        out->n_active--;
        for (int i = first; i < out->n_active; i++) {
            out->active[i] = out->active[i + 1];
            out->multiplier[i] = out->multiplier[i + 1];
        }
    }
}

/** Project by Lawson and Hanson's active set. Returns not 0 if the set was found. */
static inline int cone_active_set(const cone *c, double tolerance, cone_point *out) {
    out->n_active = 0;
    memcpy(out->point, c->p, (size_t)c->n * sizeof *c->p);
    for (int i = 0; i < CONE_ITERATIONS; i++) {
        int64_t row = cone_most_violated(c, out->point, tolerance);
        if (row < 0)
            return 1;
        if (out->n_active == c->n)
            return 0;
        out->active[out->n_active] = row;
        out->multiplier[out->n_active++] = 0;
        if (!cone_settle(c, out))
            return 0;
    }
    return 0;
}

/* ---- enumeration -------------------------------------------------------------------------- */

/** The search for the set of rows, among some, whose projection breaks the conditions least. */
typedef struct cone_search {
    const cone *c;
    int64_t working[CONE_WORKING]; /* rows looked at */
    int n_working;
    int64_t set[CONE_DIM];
    double broken; /* by the best so far */
    cone_point best;
} cone_search;

/** Judge the set of k rows. */
static inline void cone_judge(cone_search *search, int k) {
    double lambda[CONE_DIM], residual[CONE_DIM], broken = 0;
    if (!cone_least_squares(search->c, search->set, k, lambda, residual))
        return;
    for (int i = 0; i < k; i++) {
        const double *a = search->c->rows[search->set[i]];
        double negative = -lambda[i] * sqrt(cone_dot(a, a, search->c->n));
        broken = negative > broken ? negative : broken;
    }
    for (int i = 0; i < search->n_working; i++) {
        double excess = cone_excess(search->c, search->working[i], residual);
        broken = excess > broken ? excess : broken;
    }
    if (!(broken < search->broken))
        return;
    search->broken = broken;
    cone_point *best = &search->best;
    best->n_active = 0;
    memcpy(best->point, residual, sizeof residual);
    for (int i = 0; i < k; i++)
        if (lambda[i] > 0) { /* others are of rounding, and no part of a proof */
            best->active[best->n_active] = search->set[i];
            best->multiplier[best->n_active++] = lambda[i];
        }
}

/** Judge all sets that extend the first k rows by working rows from number first on. */
static inline void cone_extend(cone_search *search, int k, int first) {
    cone_judge(search, k);
    if (k >= search->c->n || k >= CONE_DIM)
        return;
    for (int i = first; i < search->n_working; i++) {
        search->set[k] = search->working[i];
        cone_extend(search, k + 1, i + 1);
    }
}

/** Enumerate over working rows, and add the row that the result violates most until there is none:
 *  each is new, so this ends. 0 if the working rows run out. */
static inline int cone_enumerate(const cone *c, double tolerance, cone_point *out) {
    cone_search search = {.c = c};
    for (;;) {
        search.broken = INFINITY;
        cone_extend(&search, 0, 0);
        *out = search.best;
        int64_t row = cone_most_violated(c, out->point, tolerance);
        for (int i = 0; i < search.n_working; i++)
            if (search.working[i] == row)
                row = -1; /* as near as rounding allows */
        if (row < 0)
            return 1;
        if (search.n_working == CONE_WORKING)
            return 0;
        search.working[search.n_working++] = row;
    }
}

/** Project p [n] on the cone of m rows; 0 if that could not be done (out is then not to be used).
 *  p and rows are finite, and 0 or of lengths between 1e-150 and 1e150, so that squares are exact
 *  enough. */
static inline int cone_project(const double (*rows)[CONE_DIM], int64_t m, const double *p, int n,
                               cone_point *out) {
    const cone c = {rows, m, p, n};
    double tolerance = CONE_VIOLATED * sqrt(cone_dot(p, p, n));
    return cone_active_set(&c, tolerance, out) || cone_enumerate(&c, tolerance, out);
}

#endif
