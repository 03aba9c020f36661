/* The projection on a cone against rational arithmetic: its result must be the exact solution of a
 * problem that differs from the given one by rounding, whatever its rows are, and near the exact
 * solution of the given one as far as that depends on such differences.
 *
 * All is judged by exact values of what was returned; only lengths, as scales, are rounded.
 */
#include "support/cone_problems.h"
#include "support/rational.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#ifdef PLANISH_HAVE_GMP

/* p - y - sum lambda_j a_j, each component by |p| + sum lambda_j |a_j|. */
#define STATIONARY 1e-14
/* a_j . y by |a_j| |p|: what kernel_cone.h calls violated, and rounding. */
#define VIOLATED 1.001e-12
/* |a_j . y| of rows with a multiplier, by |p| + sum lambda_i |a_i| and |a_j|. */
#define COMPLEMENTARY 1e-14
/* The point is this near to the exact one, by |p|, where rows are not nearly parallel and the exact
 * multipliers, sum L_j |a_j| by |p|, are moderate. Else it is as near as what it violates permits:
 * rows of doubles can say no more of a wedge that is nearly flat. */
#define NEAR     1e-9
#define MODERATE 1e4

/** What the exact conditions of a result leave. */
typedef struct flaws {
    double size;       /* |p| */
    double weight;     /* |p| + sum lambda_j |a_j| */
    double stationary; /* the rest's length, */
    double violated;   /* largest a_j . y / |a_j|, */
    double gap;        /* sum of lambda_j max(0, -a_j . y) */
    double distance;   /* of y from the exact projection */
    double allowed;    /* what the other flaws permit it to be */
    double exact;      /* sum of the exact multipliers times the rows' lengths */
} flaws;

static double length_of(const double *a, int n) {
    return sqrt(cone_dot(a, a, n));
}

/** What p - y leaves of the rows with multipliers. */
static void look_at_rest(rational_cone *c, const cone_point *found, flaws *f) {
    mpq_t number, rest;
    mpq_inits(number, rest, NULL);
    for (int d = 0; d < c->n; d++) {
        mpq_set_d(number, found->point[d]);
        mpq_sub(rest, c->p[d], number);
        for (int i = 0; i < found->n_active; i++) {
            mpq_set_d(number, -found->multiplier[i]);
            rational_add_product(rest, number, c->row[found->active[i]][d]);
        }
        f->stationary = hypot(f->stationary, mpq_get_d(rest));
    }
    mpq_clears(number, rest, NULL);
}

/** Exact a_j . y. */
static double product(rational_cone *c, int64_t row, const double *y) {
    mpq_t number;
    mpq_init(number);
    mpq_set_ui(c->t[0], 0, 1);
    for (int d = 0; d < c->n; d++) {
        mpq_set_d(number, y[d]);
        rational_add_product(c->t[0], number, c->row[row][d]);
    }
    mpq_clear(number);
    return mpq_get_d(c->t[0]);
}

/** How far y is from the exact projection, which is in c, and may be. With P that, L its
 *  multipliers, r the rest:  |y - P|^2 <= sum L_j max(0, a_j . y) + gap + |r| |y - P|. */
static void look_at_distance(rational_cone *c, const double *y, flaws *f) {
    double drift = f->gap;
    mpq_t number;
    mpq_init(number);
    for (int d = 0; d < c->n; d++) {
        mpq_set_d(number, y[d]);
        mpq_sub(number, number, c->y[d]);
        f->distance = hypot(f->distance, mpq_get_d(number));
    }
    for (int i = 0; i < c->n_set; i++) {
        const double multiplier = mpq_get_d(c->multiplier[i]);
        rational_dot(number, c->row[c->set[i]], c->row[c->set[i]], c->n);
        f->exact += multiplier * sqrt(mpq_get_d(number));
        drift += multiplier * fmax(0, product(c, c->set[i], y));
    }
    f->allowed = f->stationary + sqrt(drift);
    mpq_clear(number);
}

static flaws look_at(const cone_problem *q, const cone_point *found, rational_cone *c) {
    flaws f = {.size = length_of(q->p, q->n)};
    f.weight = f.size;
    for (int i = 0; i < found->n_active; i++)
        f.weight += found->multiplier[i] * length_of(q->rows[found->active[i]], q->n);
    look_at_rest(c, found, &f);
    for (int j = 0; j < q->m; j++) {
        const double length = length_of(q->rows[j], q->n), above = product(c, j, found->point);
        f.violated = length > 0 ? fmax(f.violated, above / length) : f.violated;
    }
    for (int i = 0; i < found->n_active; i++)
        f.gap += found->multiplier[i] * fmax(0, -product(c, found->active[i], found->point));
    look_at_distance(c, found->point, &f);
    return f;
}

static void is_right(const cone_problem *q, const cone_point *found, const flaws *f,
                     int can_be_near) {
    assert_in_range(found->n_active, 0, q->n);
    for (int i = 0; i < found->n_active; i++)
        assert_true(found->multiplier[i] > 0 && found->active[i] < q->m);
    assert_true(f->stationary <= STATIONARY * f->weight);
    assert_true(f->violated <= VIOLATED * f->size);
    assert_true(f->gap <= COMPLEMENTARY * f->weight * f->weight);
    assert_true(f->distance <= f->allowed * (1 + 1e-9));
    if (can_be_near && f->exact <= MODERATE * f->size)
        assert_true(f->distance <= NEAR * f->size);
}

typedef struct summary {
    int64_t problems, by_set, moderate;
    double stationary, violated, gap, distance; /* the largest; the last of moderate ones */
} summary;

static void add(summary *s, const flaws *f) {
    const int is_moderate = f->exact <= MODERATE * f->size;
    s->problems++;
    s->moderate += is_moderate;
    if (!(f->size > 0))
        return;
    s->stationary = fmax(s->stationary, f->stationary / f->weight);
    s->violated = fmax(s->violated, f->violated / f->size);
    s->gap = fmax(s->gap, f->gap / f->weight / f->weight);
    s->distance = is_moderate ? fmax(s->distance, f->distance / f->size) : s->distance;
}

static void tell(const summary *s, const char *what) {
    figure("%s: %lld problems; %lld with exactly these active rows; rest %.1e, violated %.1e, "
           "gap %.1e; distance from the exact point %.1e in %lld of moderate multipliers",
           what, (long long)s->problems, (long long)s->by_set, s->stationary, s->violated, s->gap,
           s->distance, (long long)s->moderate);
}

enum { ORDINARY, NEARLY_PARALLEL, SCALED, BY_ENUMERATION };
static const char *const kind_names[] = {"ordinary rows", "nearly parallel rows", "scaled rows",
                                         "by enumeration alone"};

static int project(const cone_problem *q, cone_point *found) {
    return cone_project((const double(*)[CONE_DIM])q->rows, q->m, q->p, q->n, found);
}

/** What decides where the active set fails, which is too seldom to rely on. */
static int enumerate(const cone_problem *q, cone_point *found) {
    const cone c = {(const double(*)[CONE_DIM])q->rows, q->m, q->p, q->n};
    return cone_enumerate(&c, CONE_VIOLATED * length_of(q->p, q->n), found);
}

static void projections_are_exact(void **state) {
    const int kind = *(int *)*state;
    const int64_t n = effort(20000, 400000);
    uint64_t random = effort_seed(20 + (uint64_t)kind);
    summary s = {0};
    rational_cone c;
    rational_cone_init(&c);
    for (int64_t i = 0; i < n; i++) {
        cone_problem q = {.nearly = kind == NEARLY_PARALLEL ? ldexp(1, -5 - (int)(i % 50)) : 1e-3};
        cone_point found;
        cone_problem_make(&q, &random);
        if (kind == SCALED)
            cone_problem_scale(&q, &random);
        assert_true(kind == BY_ENUMERATION ? enumerate(&q, &found) : project(&q, &found));
        rational_cone_set(&c, (const double(*)[CONE_DIM])q.rows, q.m, q.p, q.n);
        s.by_set += rational_cone_project(&c, found.active, found.n_active);
        const flaws f = look_at(&q, &found, &c);
        add(&s, &f);
        is_right(&q, &found, &f, kind != NEARLY_PARALLEL);
    }
    rational_cone_clear(&c);
    tell(&s, kind_names[kind]);
}

int main(void) {
    static int kinds[] = {ORDINARY, NEARLY_PARALLEL, SCALED, BY_ENUMERATION};
    const struct CMUnitTest tests[] = {
        {"ordinary rows", projections_are_exact, NULL, NULL, &kinds[ORDINARY]},
        {"nearly parallel rows", projections_are_exact, NULL, NULL, &kinds[NEARLY_PARALLEL]},
        {"scaled rows", projections_are_exact, NULL, NULL, &kinds[SCALED]},
        {"by enumeration alone", projections_are_exact, NULL, NULL, &kinds[BY_ENUMERATION]},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#else

int main(void) {
    print_message("built without GMP (libgmp-dev): skipped\n");
    return 0;
}

#endif
