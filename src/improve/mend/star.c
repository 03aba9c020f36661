/* star: the rows of a star, its energy and mean ratios, and a visit. */
#include "improve/mend/star.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/cube_root.h"
#include "star/kernel_direction.h"

#include <math.h>
#include <string.h>

enum {
    STEPS = 3, /* Newton steps of a visit */
    HALVINGS = 12
};

/* Rows of elements that are given up pull a little, by their energy with so much regularisation. */
#define SOFT_WEIGHT  0.05
#define SOFT_EPSILON 0.5
/* A visit goes so far to where a coefficient becomes 0, as a part. */
#define FRACTION 0.9

/* ---- rows ------------------------------------------------------------------------------------ */

int pl_mend_star_create(pl_mend *c, pl_mend_star *s, planish_error *error) {
    *s =
        (pl_mend_star){.curve = c, .target = pl_alloc(c->plan->work.n_elements, sizeof *s->target)};
    return s->target ? PLANISH_OK : pl_fail_memory(error, "curved elements");
}

void pl_mend_star_destroy(pl_mend_star *s) {
    pl_free(s->target);
    pl_free(s->row);
    pl_free(s->scale);
    pl_free(s->is_soft);
}

double pl_mend_straight(const pl_mend *c, int64_t element) {
    double x[PL_CELL_NODES * 3], D;
    pl_places_of_element(c->watch, element, x, NULL);
    pl_row_coefficients(c->rule[0], x, pl_mend_sign(c, element), &D);
    return D;
}

/** Make room for n rows. */
static int grow_rows(pl_mend_star *s, int64_t n) {
    int64_t room[3] = {s->capacity, s->capacity, s->capacity};
    if (n <= s->capacity)
        return 1;
    pl_star_row *row = pl_grow(s->row, s->n, n, &room[0], sizeof *row);
    s->row = row ? row : s->row;
    double *scale = pl_grow(s->scale, 2 * s->n, 2 * n, &room[1], sizeof *scale);
    s->scale = scale ? scale : s->scale;
    uint8_t *is_soft = pl_grow(s->is_soft, s->n, n, &room[2], 1);
    s->is_soft = is_soft ? is_soft : s->is_soft;
    if (!row || !scale || !is_soft) {
        s->curve->lacks_memory = 1;
        return 0;
    }
    s->capacity = n;
    return 1;
}

/** Add the rows of an element for the handle h: of its coefficients, and if a corner moves those of
 *  the straight element. */
static void add_rows(pl_mend_star *s, int64_t element, const pl_handle *h) {
    pl_mend *c = s->curve;
    const int order = pl_mend_order(c, element), place = pl_mend_place(c, element, h->node);
    const double wanted = s->target[element], sign = pl_mend_sign(c, element);
    double x[PL_CELL_NODES * 3], rate[PL_CELL_NODES] = {0};
    pl_star_row row[2 * PL_CELL_NODES];
    pl_places_of_element(c->watch, element, x, NULL);
    pl_row_handle(c->rule[order - 1], place, rate);
    int n = pl_rows_of_element(c->rule[order - 1], x, sign, rate, 1, row, NULL);
    if (order == 2 && h->inner >= 0) {
        double straight[PL_CELL_NODES] = {0};
        straight[place] = 1;
        n += pl_rows_of_element(c->rule[0], x, sign, straight,
                                1.0 / c->rule[1]->jacobian.n_coefficients, row + n, NULL);
    }
    if (!grow_rows(s, s->n + n))
        return;
    const double root = c->dim == 3 ? pl_cube_root(wanted) : 1;
    for (int i = 0; i < n; i++) {
        const int64_t k = s->n++;
        s->row[k] = row[i];
        s->scale[2 * k] = 1 / wanted;
        s->scale[2 * k + 1] = sqrt(row[i].factor) / (c->dim == 3 ? root * root : wanted);
        s->is_soft[k] = c->is_given_up[element];
    }
}

/** Gather the star of a node. */
static void gather(pl_mend_star *s, const pl_handle *h) {
    const pl_mend *c = s->curve;
    s->n = 0;
    for (int64_t k = c->begin[h->node]; k < c->begin[h->node + 1]; k++)
        add_rows(s, c->at[k], h);
}

/* ---- the function ---------------------------------------------------------------------------- */

/** Value of a star where its node has moved, and derivatives. */
typedef struct value {
    double f, least; /* least: D / the wanted one, of rows that are not soft */
    double gradient[3], hessian[6];
} value;

/** A function of T = E / E* and u = D / D*, and its derivatives by these. */
typedef struct slopes {
    double f, of_t, of_u, of_tt, of_tu, of_uu;
} slopes;

/** The regularised energy. Curvature along u that is negative is left out. */
PL_INLINE slopes energy_of(double T, double u, double epsilon, const int dim) {
    const double p = 2.0 / dim, s = sqrt(u * u + epsilon * epsilon);
    const double chi = u > 0 ? 0.5 * (u + s) : 0.5 * epsilon * epsilon / (s - u);
    const double root = dim == 3 ? pl_cube_root(chi) : chi, inverse = 1 / chi, i = 1 / s;
    const double power = dim == 3 ? 1 / (root * root) : inverse, q = 1 + u * u, slant = u * i;
    const double bend = T * power * p * (p + slant) * i * i +
                        0.5 * inverse * (2 - 4 * u * i + q * (1 + slant) * i * i);
    return (slopes){.f = T * power + 0.5 * q * inverse,
                    .of_t = power,
                    .of_u = 0.5 * inverse * (2 * u - q * i) - T * power * p * i,
                    .of_tu = -power * p * i,
                    .of_uu = bend > 0 ? bend : 0};
}

/** The squared mean ratio T^2 u^-k. */
PL_INLINE slopes ratio_of(double T, double u, const int dim) {
    const double k = dim == 3 ? 4.0 / 3 : 2, inverse = 1 / u;
    const double root = dim == 3 ? 1 / pl_cube_root(u) : inverse;
    const double power = dim == 3 ? root * root * root * root : inverse * inverse;
    const double f = T * T * power;
    return (slopes){.f = f,
                    .of_t = 2 * T * power,
                    .of_u = -k * f * inverse,
                    .of_tt = 2 * power,
                    .of_tu = -2 * k * T * power * inverse,
                    .of_uu = k * (k + 1) * f * inverse * inverse};
}

/** Find the value of the star with its node moved by d. epsilon of the energy; 0: of the mean
 *  ratios, infinite where a row is not positive. */
PL_INLINE value find_value(const pl_mend_star *s, const double *d, double epsilon, const int dim) {
    value v = {.least = INFINITY};
    for (int64_t i = 0; i < s->n; i++) {
        const pl_star_row *row = &s->row[i];
        const double to_u = s->scale[2 * i], to_t = s->scale[2 * i + 1];
        double E = row->e, D = row->D0, gt[3] = {0}, gu[3] = {0};
        for (int a = 0; a < dim; a++) {
            E += (2 * row->slope_e[a] + row->c * d[a]) * d[a];
            D += row->slope_d[a] * d[a];
            gt[a] = 2 * to_t * (row->slope_e[a] + row->c * d[a]);
            gu[a] = to_u * row->slope_d[a];
        }
        const double T = E * to_t, u = D * to_u;
        const double weight = s->is_soft[i] ? SOFT_WEIGHT * row->weight : row->weight;
        if (!s->is_soft[i])
            v.least = u < v.least ? u : v.least;
        if (!s->is_soft[i] && !(epsilon > 0) && !(u > 0)) {
            v.f = INFINITY;
            return v;
        }
        const slopes f = s->is_soft[i] ? energy_of(T, u, SOFT_EPSILON, dim)
                         : epsilon > 0 ? energy_of(T, u, epsilon, dim)
                                       : ratio_of(T, u, dim);
        v.f += weight * f.f;
        for (int a = 0; a < dim; a++) {
            v.gradient[a] += weight * (f.of_t * gt[a] + f.of_u * gu[a]);
            for (int b = a; b < dim; b++)
                v.hessian[packed(a, b, dim)] +=
                    weight * (f.of_tt * gt[a] * gt[b] + f.of_tu * (gt[a] * gu[b] + gu[a] * gt[b]) +
                              f.of_uu * gu[a] * gu[b] + (a == b ? 2 * to_t * row->c * f.of_t : 0));
        }
    }
    return v;
}

static value value_at(const pl_mend_star *s, const double *d, double epsilon) {
    return s->curve->dim == 3 ? find_value(s, d, epsilon, 3) : find_value(s, d, epsilon, 2);
}

double pl_mend_star_energy(pl_mend_star *s, const pl_handle *h, double epsilon, double *least) {
    static const double still[3] = {0, 0, 0};
    gather(s, h);
    const value v = value_at(s, still, epsilon);
    *least = v.least;
    return v.f;
}

/* ---- visits ---------------------------------------------------------------------------------- */

/** Largest step along direction from d, as a multiple of it, that leaves the rows positive. */
static double largest_step(const pl_mend_star *s, const double *d, const double *direction) {
    const int dim = s->curve->dim;
    double rate = 0;
    for (int64_t i = 0; i < s->n; i++) {
        const pl_star_row *row = &s->row[i];
        const double D = row->D0 + dot(row->slope_d, d, dim);
        const double fall = -dot(row->slope_d, direction, dim);
        if (!s->is_soft[i] && fall > rate * D)
            rate = fall / D;
    }
    return rate > 0 ? FRACTION / rate : INFINITY;
}

/** One step from d, where the value is *v: both are changed. Returns whether it went. */
static int go_one_step(const pl_mend_star *s, double *d, value *v, double epsilon) {
    const int dim = s->curve->dim;
    double direction[3] = {0}, at[3] = {0};
    if (!newton_direction(v->gradient, v->hessian, direction, dim))
        return 0;
    const double slope = dot(v->gradient, direction, dim);
    double step = epsilon > 0 ? 1 : fmin(1, largest_step(s, d, direction));
    if (!(slope < 0))
        return 0;
    for (int i = 0; i < HALVINGS; i++) {
        for (int a = 0; a < dim; a++)
            at[a] = d[a] + step * direction[a];
        const value next = value_at(s, at, epsilon);
        if (next.f <= v->f + 1e-4 * step * slope && next.f < v->f) {
            memcpy(d, at, sizeof at);
            *v = next;
            return 1;
        }
        step *= i < 3 ? 0.5 : 0.2;
    }
    return 0;
}

/** In a star whose mean ratios are to be minimised: elements with a row that is not positive count
 *  as given up. */
static void soften(pl_mend_star *s) {
    for (int64_t i = 0; i < s->n; i++)
        s->is_soft[i] = s->is_soft[i] || !(s->row[i].D0 > 0);
}

/** Find a way d [3] of the node by Newton's method, from where it is; *v: the value there, and then at
 *  d. */
static void find_way(const pl_mend_star *s, double epsilon, double *d, value *v) {
    for (int i = 0; i < STEPS; i++) {
        const double f = v->f;
        if (!go_one_step(s, d, v, epsilon) || !(f - v->f > 0.1 * f))
            return;
    }
}

double pl_mend_star_visit(pl_mend_star *s, pl_handle *h, double epsilon) {
    const pl_mend *c = s->curve;
    double d[3] = {0}, place[3] = {0}, now[3] = {0}, to[3] = {0};
    gather(s, h);
    if (!(epsilon > 0))
        soften(s);
    const value before = value_at(s, d, epsilon);
    value v = before;
    find_way(s, epsilon, d, &v);
    if (!(v.f < before.f) || c->lacks_memory)
        return 0;
    pl_handle kept = *h;
    pl_handle_save(c, &kept);
    pl_handle_place(c, h, place);
    for (int a = 0; a < c->dim; a++)
        to[a] = place[a] + d[a];
    if (pl_handle_put(c, h, to)) {
        pl_handle_place(c, h, now);
        for (int a = 0; a < c->dim; a++)
            d[a] = now[a] - place[a];
        const double f = value_at(s, d, epsilon).f;
        if (f < before.f)
            return (before.f - f) / before.f;
    }
    pl_handle_restore(c, &kept);
    return 0;
}
