/* facet_terms: the change of the facets around a node of a surface in space as the node moves.
 *
 * A term is a triangle at the node, or a corner of a quadrilateral: at the node itself, or at the
 * other end of an edge from the node. Its ratio is, with squared edges l, s the sum of edges, n = 2
 * x the area's normal,
 *
 *     RR^2 = l_a l_b l_c s^2 / (16 |n|^4)              of a triangle
 *     mu^2 = (l_a + l_b + l_c)^2 / (12 |n|^2)          of a triangle
 *     mu^2 = (l_a + l_b)^2 / (4 |n|^2)                 of a corner
 *
 * The logarithms of all factors, and so their derivatives, add up. With x the node n is n_0 + x x e, e
 * constant, so that |n|^2 is a quadratic: its gradient is 2 e x n, its Hessian 2 (|e|^2 I - e e^T).
 *
 *   pl_facet_term_value          ratio, and acuteness of angles
 *   pl_facet_term_add            a power of the ratio, or of what angles have, with derivatives
 */
#ifndef PL_SURFACE_FACET_TERMS_H
#define PL_SURFACE_FACET_TERMS_H

#include "geometry/simplex.h"

#include <stdint.h>
#include <string.h>

/** Role of the node in its term. */
typedef enum pl_term_role {
    PL_TERM_TRIANGLE, /* a corner of a triangle, p and q the next and the one before */
    PL_TERM_OWN,      /* the corner itself, p and q likewise */
    PL_TERM_NEXT,     /* the next one of corner p, whose one before is q */
    PL_TERM_BEFORE    /* the one before of corner p, whose next one is q */
} pl_term_role;

/** One term of a node; nodes and facets are numbered as in the shape. */
typedef struct pl_facet_term {
    int32_t p, q;
    int32_t facet; /* of which the normal must not turn over */
    uint8_t role;  /* pl_term_role */
} pl_facet_term;

/** Measure of a star's terms that is summed. */
typedef enum pl_facet_measure { PL_FACET_RR, PL_FACET_MEAN, PL_FACET_ACUTENESS } pl_facet_measure;

/** Sum over a star with derivatives in the basis of the node's directions: two unit vectors, of a node
 *  on a curve the second one 0. */
typedef struct pl_facet_sum {
    double sum;
    double gradient[2];
    double hessian[3]; /* 00, 01, 11 */
} pl_facet_sum;

/** A term with its node at x. */
typedef struct pl_facet_vectors {
    double a[3], b[3], c[3]; /* x to p, x to q, p to q */
    double n[3], e[3];
    double la, lb, lc, nn; /* squares */
} pl_facet_vectors;

static inline void pl_facet_vectors_of(pl_term_role role, const double *x, const double *p,
                                       const double *q, pl_facet_vectors *v) {
    pl_subtract(3, p, x, v->a);
    pl_subtract(3, q, x, v->b);
    pl_subtract(3, q, p, v->c);
    for (int d = 0; d < 3; d++)
        v->e[d] = role == PL_TERM_NEXT ? v->c[d] : -v->c[d];
    if (role == PL_TERM_NEXT)
        pl_cross(v->c, v->a, v->n); /* (x - p) x (q - p) */
    else if (role == PL_TERM_BEFORE)
        pl_cross(v->a, v->c, v->n);
    else
        pl_cross(v->a, v->b, v->n);
    v->la = pl_dot(3, v->a, v->a);
    v->lb = pl_dot(3, v->b, v->b);
    v->lc = pl_dot(3, v->c, v->c);
    v->nn = pl_dot(3, v->n, v->n);
}

/** Squared edges that meet at the corner of a term of a quadrilateral. */
static inline double pl_facet_other_edge(pl_term_role role, const pl_facet_vectors *v) {
    return role == PL_TERM_OWN ? v->lb : v->lc;
}

/** Ratio of a term: RR^2, or mu^2. */
static inline double pl_facet_ratio(pl_term_role role, int by_radius, const pl_facet_vectors *v) {
    if (role != PL_TERM_TRIANGLE) {
        const double both = v->la + pl_facet_other_edge(role, v);
        return both * both / (4 * v->nn);
    }
    if (!by_radius) {
        const double all = v->la + v->lb + v->lc;
        return all * all / (12 * v->nn);
    }
    const double s = sqrt(v->la) + sqrt(v->lb) + sqrt(v->lc);
    return v->la * v->lb * (v->lc * s * s) / (16 * v->nn * v->nn);
}

/** Largest 1 / sin^2 of the angles of a triangle, 1 / SJ^2 of a corner. */
static inline double pl_facet_acuteness(pl_term_role role, const pl_facet_vectors *v) {
    if (role != PL_TERM_TRIANGLE)
        return v->la * pl_facet_other_edge(role, v) / v->nn;
    return fmax(v->la * v->lb, v->lc * fmax(v->la, v->lb)) / v->nn;
}

/* ---- derivatives ---------------------------------------------------------------------------- */

/** Derivatives of a logarithm in the basis. */
typedef struct pl_log_slopes {
    double g[2], h[3];
} pl_log_slopes;

/** Add those of value^power; gradient and Hessian are those of value. */
static inline void pl_log_add(pl_log_slopes *s, double power, double value,
                              const double gradient[2], const double hessian[3]) {
    const double part = power / value, again = part / value;
    for (int i = 0; i < 2; i++)
        s->g[i] += part * gradient[i];
    s->h[0] += part * hessian[0] - again * gradient[0] * gradient[0];
    s->h[1] += part * hessian[1] - again * gradient[0] * gradient[1];
    s->h[2] += part * hessian[2] - again * gradient[1] * gradient[1];
}

/** Components of v in the basis. */
static inline void pl_in_basis(const double (*basis)[3], const double *v, double out[2]) {
    out[0] = pl_dot(3, basis[0], v);
    out[1] = pl_dot(3, basis[1], v);
}

/** Gradient -2 a and Hessian 2 I of the squared edge from the node to a place a away. */
static inline void pl_edge_slopes(const double a[2], double gradient[2], double hessian[3]) {
    gradient[0] = -2 * a[0];
    gradient[1] = -2 * a[1];
    hessian[0] = hessian[2] = 2;
    hessian[1] = 0;
}

/** Slopes of the length of that edge, length its own, added to those of a sum. */
static inline void pl_add_length(const double a[2], double length, double gradient[2],
                                 double hessian[3]) {
    const double u[2] = {a[0] / length, a[1] / length};
    gradient[0] -= u[0];
    gradient[1] -= u[1];
    hessian[0] += (1 - u[0] * u[0]) / length;
    hessian[1] -= u[0] * u[1] / length;
    hessian[2] += (1 - u[1] * u[1]) / length;
}

/** Slopes of the logarithm of |n|^-2, power times. */
static inline void pl_add_area(const pl_facet_vectors *v, const double (*basis)[3], double power,
                               pl_log_slopes *s) {
    double turn[3], g[2], e[2];
    pl_cross(v->e, v->n, turn);
    pl_in_basis(basis, turn, g);
    pl_in_basis(basis, v->e, e);
    const double ee = pl_dot(3, v->e, v->e);
    const double gradient[2] = {2 * g[0], 2 * g[1]};
    const double hessian[3] = {2 * (ee - e[0] * e[0]), -2 * e[0] * e[1], 2 * (ee - e[1] * e[1])};
    pl_log_add(s, -power, v->nn, gradient, hessian);
}

/** Add value^power, whose logarithm has these slopes, to a sum. */
static inline void pl_add_power(pl_facet_sum *sum, double value, double power,
                                const pl_log_slopes *s) {
    sum->sum += value;
    const double f = value * power;
    for (int i = 0; i < 2; i++)
        sum->gradient[i] += f * s->g[i];
    sum->hessian[0] += f * (s->h[0] + power * s->g[0] * s->g[0]);
    sum->hessian[1] += f * (s->h[1] + power * s->g[0] * s->g[1]);
    sum->hessian[2] += f * (s->h[2] + power * s->g[1] * s->g[1]);
}

/** Return base^8. */
static inline double pl_eighth_power(double base) {
    const double second = base * base, fourth = second * second;
    return fourth * fourth;
}

/** Return (value / limit)^8, or value if limit is 0. */
static inline double pl_facet_power(double value, double limit) {
    return limit > 0 ? pl_eighth_power(value / limit) : value;
}

/** Return a term's summand: its measure, or if limit is not 0 (measure / limit)^8. */
static inline double pl_facet_term_value(pl_term_role role, pl_facet_measure measure, double limit,
                                         const pl_facet_vectors *v) {
    if (measure != PL_FACET_ACUTENESS)
        return pl_facet_power(pl_facet_ratio(role, measure == PL_FACET_RR, v), limit);
    if (role != PL_TERM_TRIANGLE)
        return pl_facet_power(pl_facet_acuteness(role, v), limit);
    return pl_facet_power(v->la * v->lb / v->nn, limit) +
           pl_facet_power(v->lc * v->la / v->nn, limit) +
           pl_facet_power(v->lc * v->lb / v->nn, limit);
}

/** Add (value / limit)^8, or value if limit is 0. */
static inline void pl_add_measure(pl_facet_sum *sum, double value, double limit,
                                  const pl_log_slopes *s) {
    if (limit > 0)
        pl_add_power(sum, pl_eighth_power(value / limit), 8, s);
    else
        pl_add_power(sum, value, 1, s);
}

/** Slopes of the logarithm of a term's ratio. a, b: in the basis. */
static inline pl_log_slopes pl_ratio_slopes(pl_term_role role, int by_radius,
                                            const pl_facet_vectors *v, const double (*basis)[3],
                                            const double a[2], const double b[2]) {
    pl_log_slopes s = {{0}, {0}};
    double gradient[2], hessian[3];
    if (role == PL_TERM_TRIANGLE && by_radius) {
        const double ra = sqrt(v->la), rb = sqrt(v->lb);
        double of_sum[2] = {0, 0}, bend_of_sum[3] = {0, 0, 0};
        pl_edge_slopes(a, gradient, hessian);
        pl_log_add(&s, 1, v->la, gradient, hessian);
        pl_edge_slopes(b, gradient, hessian);
        pl_log_add(&s, 1, v->lb, gradient, hessian);
        pl_add_length(a, ra, of_sum, bend_of_sum);
        pl_add_length(b, rb, of_sum, bend_of_sum);
        pl_log_add(&s, 2, ra + rb + sqrt(v->lc), of_sum, bend_of_sum);
        pl_add_area(v, basis, 2, &s);
        return s;
    }
    const int of_both = role == PL_TERM_TRIANGLE || role == PL_TERM_OWN;
    const double edges = v->la + (of_both ? v->lb : 0) + (role == PL_TERM_OWN ? 0 : v->lc);
    pl_edge_slopes(a, gradient, hessian);
    for (int i = 0; of_both && i < 2; i++) {
        gradient[i] -= 2 * b[i];
        hessian[2 * i] += 2;
    }
    pl_log_add(&s, 2, edges, gradient, hessian);
    pl_add_area(v, basis, 1, &s);
    return s;
}

/** Add the angles of a term, or its scaled Jacobian, by their acuteness. */
static inline void pl_add_acuteness(pl_term_role role, const pl_facet_vectors *v, double limit,
                                    const double (*basis)[3], const double a[2], const double b[2],
                                    pl_facet_sum *sum) {
    const int ends[3][2] = {{1, 1}, {1, 0}, {0, 1}}; /* whether a and b are edges of the angle */
    const double opposite[3] = {1, v->lc, v->lc};
    const int first = role == PL_TERM_NEXT || role == PL_TERM_BEFORE;
    const int end = role == PL_TERM_TRIANGLE ? 3 : first + 1;
    for (int k = first; k < end; k++) {
        pl_log_slopes s = {{0}, {0}};
        double gradient[2], hessian[3], value = opposite[k] / v->nn;
        if (ends[k][0]) {
            pl_edge_slopes(a, gradient, hessian);
            pl_log_add(&s, 1, v->la, gradient, hessian);
            value *= v->la;
        }
        if (ends[k][1]) {
            pl_edge_slopes(b, gradient, hessian);
            pl_log_add(&s, 1, v->lb, gradient, hessian);
            value *= v->lb;
        }
        pl_add_area(v, basis, 1, &s);
        pl_add_measure(sum, value, limit, &s);
    }
}

/** Add a term with its derivatives: its measure, or if limit is not 0 (measure / limit)^8. */
static inline void pl_facet_term_add(pl_term_role role, pl_facet_measure measure, double limit,
                                     double weight, const pl_facet_vectors *v,
                                     const double (*basis)[3], pl_facet_sum *sum) {
    pl_facet_sum part = {0};
    double a[2], b[2];
    pl_in_basis(basis, v->a, a);
    pl_in_basis(basis, v->b, b);
    if (measure == PL_FACET_ACUTENESS) {
        pl_add_acuteness(role, v, limit, basis, a, b, &part);
    } else {
        const int by_radius = measure == PL_FACET_RR;
        const pl_log_slopes s = pl_ratio_slopes(role, by_radius, v, basis, a, b);
        pl_add_measure(&part, pl_facet_ratio(role, by_radius, v), limit, &s);
    }
    sum->sum += weight * part.sum;
    for (int i = 0; i < 2; i++)
        sum->gradient[i] += weight * part.gradient[i];
    for (int i = 0; i < 3; i++)
        sum->hessian[i] += weight * part.hessian[i];
}

#endif
