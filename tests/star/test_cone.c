/* The projection on a cone: the conditions that make it one, on a million random and degenerate
 * problems. Compared with exact solutions it is in test_cone_exact.c. */
#include "support/cone_problems.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

enum { PROBLEMS = 1000000 };

/* ---- what must hold -------------------------------------------------------------------------- */

/** The conditions that make the point the projection, whatever the way it was found. */
static void conditions_hold(const cone_problem *q, const cone_point *found, double size) {
    double rest[CONE_DIM];
    assert_true(found->n_active >= 0 && found->n_active <= q->n);
    for (int d = 0; d < q->n; d++)
        rest[d] = q->p[d] - found->point[d];
    double weight = 1;
    for (int i = 0; i < found->n_active; i++) {
        const double *a = q->rows[found->active[i]];
        assert_true(found->multiplier[i] > 0);
        assert_in_range(found->active[i], 0, q->m - 1);
        weight += found->multiplier[i] * sqrt(cone_dot(a, a, q->n));
        for (int d = 0; d < q->n; d++)
            rest[d] -= found->multiplier[i] * a[d];
    }
    for (int d = 0; d < q->n; d++)
        assert_true(fabs(rest[d]) <= 1e-13 * weight);
    for (int j = 0; j < q->m; j++) {
        double length = sqrt(cone_dot(q->rows[j], q->rows[j], q->n));
        assert_true(cone_dot(q->rows[j], found->point, q->n) <= 2e-12 * length * size);
    }
    for (int i = 0; i < found->n_active; i++) {
        const double *a = q->rows[found->active[i]];
        double length = sqrt(cone_dot(a, a, q->n));
        assert_true(fabs(cone_dot(a, found->point, q->n)) <= 1e-12 * length * size);
    }
}

static void projections_are_right(void **state) {
    uint64_t seed = effort_seed(1);
    int64_t vanished = 0, constrained = 0;
    (void)state;
    for (int i = 0; i < PROBLEMS; i++) {
        cone_problem q = {{{0}}, {0}, 0, 0, 1e-3};
        cone_point found;
        cone_problem_make(&q, &seed);
        assert_true(cone_project((const double(*)[CONE_DIM])q.rows, q.m, q.p, q.n, &found));
        conditions_hold(&q, &found, sqrt(cone_dot(q.p, q.p, q.n)));
        constrained += found.n_active > 0;
        vanished += cone_dot(found.point, found.point, q.n) < 1e-20;
    }
    assert_true(constrained > PROBLEMS / 4 && vanished > PROBLEMS / 40); /* of both kinds enough */
}

/** Rows that are as good as parallel. */
static void nearly_parallel_rows(void **state) {
    uint64_t seed = effort_seed(2);
    (void)state;
    for (int i = 0; i < PROBLEMS / 5; i++) {
        cone_problem q = {{{0}}, {0}, 0, 0, ldexp(1, -10 - i % 40)};
        cone_point found;
        cone_problem_make(&q, &seed);
        assert_true(cone_project((const double(*)[CONE_DIM])q.rows, q.m, q.p, q.n, &found));
        conditions_hold(&q, &found, sqrt(cone_dot(q.p, q.p, q.n)));
    }
}

/** How often the active set alone is enough: always, or the enumeration would hide its faults. */
static void active_set_seldom_gives_up(void **state) {
    uint64_t seed = effort_seed(3);
    int64_t given_up = 0;
    (void)state;
    for (int i = 0; i < PROBLEMS / 10; i++) {
        cone_problem q = {{{0}}, {0}, 0, 0, 1e-3};
        cone_point found;
        cone_problem_make(&q, &seed);
        const cone c = {(const double(*)[CONE_DIM])q.rows, q.m, q.p, q.n};
        given_up += !cone_active_set(&c, CONE_VIOLATED * sqrt(cone_dot(q.p, q.p, q.n)), &found);
    }
    assert_true(given_up < PROBLEMS / 10 / 100);
}

/** Stars have more rows than a test can enumerate: the conditions alone decide. */
static void many_rows(void **state) {
    enum { ROWS = 60 };
    uint64_t seed = effort_seed(4);
    (void)state;
    for (int i = 0; i < 20000; i++) {
        double rows[ROWS][CONE_DIM] = {{0}}, p[CONE_DIM] = {0}, largest = 0;
        cone_point found;
        int n = 2 + i % 3;
        for (int d = 0; d < n; d++)
            p[d] = random_between(&seed, -1, 1);
        for (int j = 0; j < ROWS; j++)
            for (int d = 0; d < n; d++) /* towards one side, so that something is left */
                rows[j][d] = random_between(&seed, -1, 1) + (d == 0 ? 1 + i % 2 : 0);
        assert_true(cone_project((const double(*)[CONE_DIM])rows, ROWS, p, n, &found));
        for (int j = 0; j < ROWS; j++) {
            double excess = cone_dot(rows[j], found.point, n);
            largest = excess > largest ? excess : largest;
        }
        assert_true(largest <= 1e-11);
        double fall = cone_dot(p, found.point, n), square = cone_dot(found.point, found.point, n);
        assert_true(fabs(fall - square) <= 1e-12); /* P . (p - P) = 0 */
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(projections_are_right),
        cmocka_unit_test(nearly_parallel_rows),
        cmocka_unit_test(active_set_seldom_gives_up),
        cmocka_unit_test(many_rows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
