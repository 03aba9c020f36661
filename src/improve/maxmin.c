/* maxmin: the dual active set. */
#include "improve/maxmin.h"

#include <math.h>
#include <string.h>

/* Rows count as met within this, relative to target and value; as dependent if no more than this part of
 * one is new. */
#define MET       1e-10
#define DEPENDENT 1e-9
enum { STEPS_PER_VARIABLE = 8, STEPS = 100 };
/* Multiplications of a step for each row, and for each entry of the active ones. */
enum { PER_ROW = 12, PER_ENTRY = 5 };

/** A solution under way; k = n + 1 variables, the last one of t. */
typedef struct active_set {
    pl_maxmin *p;
    int k;
    double root_reach, root_spread;
    double *y;     /* [k] */
    double *q;     /* [n_active][k] orthonormal */
    double *r;     /* [column][k] q r: the active rows */
    double *along; /* [k] */
    double *rest;  /* [k] */
    double *ratio; /* [k] */
} active_set;

/** a . y, a the row as a constraint a . y <= value. */
static double row_product(const active_set *s, const pl_maxmin_row *row, const double *y) {
    double sum = 0;
    for (int b = 0; b < row->n_blocks; b++)
        for (int d = 0; d < row->width[b]; d++)
            sum += row->slope[b][d] * y[row->first[b] + d];
    return (row->is_raised ? s->root_spread * y[s->p->n] : 0) - s->root_reach * sum;
}

/** Write the row as a [k]; return |a|^2. */
static double spread_row(const active_set *s, const pl_maxmin_row *row, double *a) {
    double square = 0;
    memset(a, 0, (size_t)s->k * sizeof *a);
    for (int b = 0; b < row->n_blocks; b++)
        for (int d = 0; d < row->width[b]; d++)
            a[row->first[b] + d] -= s->root_reach * row->slope[b][d];
    a[s->p->n] = row->is_raised ? s->root_spread : 0;
    for (int i = 0; i < s->k; i++)
        square += a[i] * a[i];
    return square;
}

/** Return the row that y violates most, or -1; *by: how much. */
static int most_violated(const active_set *s, double *by) {
    int worst = -1;
    *by = MET * (1 + fabs(s->p->target));
    for (int i = 0; i < s->p->m; i++) {
        const double excess = row_product(s, &s->p->row[i], s->y) - s->p->row[i].value;
        if (excess > *by) {
            *by = excess;
            worst = i;
        }
    }
    return worst;
}

/** Split a row, in rest: along [n_active] gets its components along q, rest [k] the remainder. Twice,
 *  so that rounding of the first time does not matter. */
static void split_row(const active_set *s) {
    const int n = s->p->n_active, k = s->k;
    for (int pass = 0; pass < 2; pass++)
        for (int j = 0; j < n; j++) {
            const double *q = s->q + (int64_t)j * k;
            double component = 0;
            for (int i = 0; i < k; i++)
                component += q[i] * s->rest[i];
            for (int i = 0; i < k; i++)
                s->rest[i] -= component * q[i];
            s->along[j] = pass ? s->along[j] + component : component;
        }
}

/** ratio [n_active]: how the multipliers fall as that of the new row rises, r^-1 along. */
static void find_ratios(const active_set *s) {
    for (int j = s->p->n_active - 1; j >= 0; j--) {
        double sum = s->along[j];
        for (int i = j + 1; i < s->p->n_active; i++)
            sum -= s->r[(int64_t)i * s->k + j] * s->ratio[i];
        s->ratio[j] = sum / s->r[(int64_t)j * s->k + j];
    }
}

/** Drop active row number d: turn the rows of r, and q, so that r is triangular again. */
static void drop_row(active_set *s, int d) {
    pl_maxmin *p = s->p;
    const int k = s->k, n = --p->n_active;
    for (int j = d; j < n; j++) {
        p->active[j] = p->active[j + 1];
        p->multiplier[j] = p->multiplier[j + 1];
        memcpy(s->r + (int64_t)j * k, s->r + (int64_t)(j + 1) * k, (size_t)k * sizeof *s->r);
    }
    for (int j = d; j < n; j++) {
        double *column = s->r + (int64_t)j * k;
        const double length = sqrt(column[j] * column[j] + column[j + 1] * column[j + 1]);
        const double c = column[j] / length, sine = column[j + 1] / length;
        for (int i = j; i < n; i++) {
            double *at = s->r + (int64_t)i * k + j;
            const double a = at[0], b = at[1];
            at[0] = c * a + sine * b;
            at[1] = c * b - sine * a;
        }
        double *q0 = s->q + (int64_t)j * k, *q1 = q0 + k;
        for (int i = 0; i < k; i++) {
            const double a = q0[i], b = q1[i];
            q0[i] = c * a + sine * b;
            q1[i] = c * b - sine * a;
        }
    }
}

/** Make the row active, whose split is at hand; length: of rest. */
static void add_row(active_set *s, int row, double multiplier, double length) {
    pl_maxmin *p = s->p;
    const int n = p->n_active++, k = s->k;
    for (int i = 0; i < k; i++)
        s->q[(int64_t)n * k + i] = s->rest[i] / length;
    memcpy(s->r + (int64_t)n * k, s->along, (size_t)n * sizeof *s->r);
    s->r[(int64_t)n * k + n] = length;
    p->active[n] = row;
    p->multiplier[n] = multiplier;
}

/** Meet a row that is violated; returns how many steps that took, 0 if it cannot be met. */
static int meet_row(active_set *s, int row, double by) {
    pl_maxmin *p = s->p;
    double multiplier = 0;
    for (int steps = 1;; steps++) {
        const double square = spread_row(s, &p->row[row], s->rest);
        p->work += (int64_t)PER_ROW * p->m + (int64_t)PER_ENTRY * s->k * p->n_active;
        split_row(s);
        find_ratios(s);
        double length2 = 0, part = INFINITY;
        int first = -1;
        for (int i = 0; i < s->k; i++)
            length2 += s->rest[i] * s->rest[i];
        for (int j = 0; j < p->n_active; j++)
            if (s->ratio[j] > 0 && p->multiplier[j] / s->ratio[j] < part) {
                part = p->multiplier[j] / s->ratio[j];
                first = j;
            }
        const int is_new = length2 > DEPENDENT * DEPENDENT * square && p->n_active < s->k;
        const double whole = is_new ? by / length2 : INFINITY;
        const double step = whole < part ? whole : part;
        if (!(step < INFINITY))
            return 0;
        for (int i = 0; is_new && i < s->k; i++)
            s->y[i] -= step * s->rest[i];
        for (int j = 0; j < p->n_active; j++)
            p->multiplier[j] -= step * s->ratio[j];
        multiplier += step;
        if (whole <= part) {
            add_row(s, row, multiplier, sqrt(length2));
            return steps;
        }
        by -= is_new ? step * length2 : 0;
        drop_row(s, first);
    }
}

int pl_maxmin_solve(pl_maxmin *p) {
    const int k = p->n + 1;
    double *room = p->room;
    active_set s = {.p = p, .k = k, .root_reach = sqrt(p->reach), .root_spread = sqrt(p->spread)};
    s.q = room;
    s.r = s.q + (int64_t)k * k;
    s.y = s.r + (int64_t)k * k;
    s.along = s.y + k;
    s.rest = s.along + k;
    s.ratio = s.rest + k;
    memset(s.y, 0, (size_t)k * sizeof *s.y);
    s.y[p->n] = p->target / s.root_spread;
    p->n_active = 0;
    double by;
    int row, left = STEPS + STEPS_PER_VARIABLE * k;
    while ((row = most_violated(&s, &by)) >= 0 && left > 0) {
        const int steps = meet_row(&s, row, by);
        if (steps == 0)
            break;
        left -= steps;
    }
    for (int i = 0; i < p->n; i++)
        p->x[i] = s.root_reach * s.y[i];
    p->t = s.root_spread * s.y[p->n];
    return row < 0;
}
