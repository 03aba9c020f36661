/* The projection on a cone against enumeration, on a million random and degenerate problems. */
#include "star/cone.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

enum { PROBLEMS = 1000000, MAX_ROWS = 12, FULL_ROWS = 7 };

typedef struct problem {
    double rows[MAX_ROWS][CONE_DIM], p[CONE_DIM];
    int n, m;
    double nearly; /* by what nearly parallel rows differ */
} problem;

/* ---- random problems ------------------------------------------------------------------------ */

static uint64_t random_bits(uint64_t *state) {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state;
}

static double uniform(uint64_t *state) {
    return (double)(random_bits(state) >> 11) * 0x1p-52 - 1;
}

static int below(uint64_t *state, int n) {
    return (int)(random_bits(state) >> 33) % n;
}

/** A row that stands in some relation to the ones before it. */
static void make_row(problem *q, int row, uint64_t *state) {
    double *a = q->rows[row];
    const double *other = q->rows[row > 0 ? below(state, row) : 0];
    int kind = row > 0 ? below(state, 9) : 8;
    double length = row > 0 ? sqrt(cone_dot(other, other, q->n)) : 0;
    double factor = ldexp(1, below(state, 9) - 4); /* exact multiples */
    for (int d = 0; d < q->n; d++) {
        double fresh = below(state, 4) ? uniform(state) : 0;
        switch (kind) {
        case 0: /* the same */
            a[d] = other[d];
            break;
        case 1: /* parallel */
            a[d] = factor * other[d];
            break;
        case 2: /* opposed */
            a[d] = -factor * other[d];
            break;
        case 3: /* nearly parallel */
            a[d] = other[d] + q->nearly * length * uniform(state);
            break;
        case 4: /* nearly opposed */
            a[d] = -other[d] + q->nearly * length * uniform(state);
            break;
        case 5: /* in the plane of two others */
            a[d] = other[d] - factor * q->rows[0][d];
            break;
        case 6: /* small whole numbers: many coincidences */
            a[d] = below(state, 3) - 1;
            break;
        default:
            a[d] = fresh;
        }
    }
}

static void make_problem(problem *q, uint64_t *state) {
    q->n = 2 + below(state, 3);
    q->m = below(state, below(state, 20) ? FULL_ROWS : MAX_ROWS + 1);
    int lattice = below(state, 4) == 0;
    for (int d = 0; d < CONE_DIM; d++)
        q->p[d] = lattice ? below(state, 3) - 1 : uniform(state);
    for (int row = 0; row < q->m; row++)
        make_row(q, row, state);
    if (q->m > 0 && below(state, 16) == 0) /* p along a row: it vanishes */
        for (int d = 0; d < q->n; d++)
            q->p[d] = q->rows[0][d];
}

/* ---- enumeration, in a way of its own -------------------------------------------------------- */

static long double length_of(const problem *q, int row) {
    long double square = 0;
    for (int d = 0; d < q->n; d++)
        square += (long double)q->rows[row][d] * q->rows[row][d];
    return sqrtl(square);
}

/** Solve the k normal equations of the rows in set, of unit length, by elimination with pivoting; 0
 *  if singular. */
static int normal_equations(const problem *q, const int *set, int k, long double *lambda) {
    long double a[CONE_DIM][CONE_DIM + 1];
    for (int i = 0; i < k; i++) {
        for (int j = 0; j <= k; j++) {
            const double *other = j < k ? q->rows[set[j]] : q->p;
            long double scale = length_of(q, set[i]) * (j < k ? length_of(q, set[j]) : 1);
            a[i][j] = 0;
            for (int d = 0; d < q->n; d++)
                a[i][j] += (long double)q->rows[set[i]][d] * other[d] / scale;
        }
    }
    for (int c = 0; c < k; c++) {
        int pivot = c;
        for (int r = c + 1; r < k; r++)
            if (fabsl(a[r][c]) > fabsl(a[pivot][c]))
                pivot = r;
        if (!(fabsl(a[pivot][c]) > 1e-17L))
            return 0;
        for (int j = 0; j <= k; j++) {
            long double t = a[c][j];
            a[c][j] = a[pivot][j];
            a[pivot][j] = t;
        }
        for (int r = 0; r < k; r++) {
            long double f = r == c ? 0 : a[r][c] / a[c][c];
            for (int j = c; j <= k; j++)
                a[r][j] -= f * a[c][j];
        }
    }
    for (int i = 0; i < k; i++)
        lambda[i] = a[i][k] / a[i][i];
    return 1;
}

/** The nearest feasible point that the rows of some set give: the projection is one of them. */
static void try_sets(const problem *q, int *set, int k, int first, long double *best,
                     long double *point) {
    long double lambda[CONE_DIM], y[CONE_DIM], distance2 = 0;
    int good = normal_equations(q, set, k, lambda);
    for (int d = 0; good && d < q->n; d++) {
        y[d] = q->p[d];
        for (int i = 0; i < k; i++)
            y[d] -= lambda[i] * q->rows[set[i]][d] / length_of(q, set[i]);
        distance2 += (y[d] - q->p[d]) * (y[d] - q->p[d]);
    }
    for (int j = 0; good && j < q->m; j++) {
        long double excess = 0;
        for (int d = 0; d < q->n; d++)
            excess += q->rows[j][d] * y[d];
        good = excess <= 1e-13L * length_of(q, j);
    }
    if (good && distance2 < *best) {
        *best = distance2;
        for (int d = 0; d < q->n; d++)
            point[d] = y[d];
    }
    for (int i = first; k < q->n && i < q->m; i++) {
        set[k] = i;
        try_sets(q, set, k + 1, i + 1, best, point);
    }
}

/** The projection; 0 is always feasible. */
static void enumerate(const problem *q, long double *point) {
    int set[CONE_DIM];
    long double best = 0;
    for (int d = 0; d < q->n; d++) {
        point[d] = 0;
        best += (long double)q->p[d] * q->p[d];
    }
    try_sets(q, set, 0, 0, &best, point);
}

/* ---- what must hold -------------------------------------------------------------------------- */

/** The conditions that make the point the projection, whatever the way it was found. */
static void conditions_hold(const problem *q, const cone_point *found, double size) {
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

static void agrees_with_enumeration(const problem *q, const cone_point *found, double size) {
    long double point[CONE_DIM], difference = 0;
    enumerate(q, point);
    for (int d = 0; d < q->n; d++)
        difference += fabsl(point[d] - found->point[d]);
    assert_true(difference <= 1e-5L * size);
    long double of_point = 0, of_found = 0;
    for (int d = 0; d < q->n; d++) {
        of_point += point[d] * q->p[d];
        of_found += (long double)found->point[d] * q->p[d];
    }
    assert_true(fabsl(of_point - of_found) <= 1e-5L * size * size);
}

static void projections_are_right(void **state) {
    int by_enumeration = *(int *)*state;
    uint64_t seed = 88172645463325252u;
    int64_t vanished = 0, constrained = 0;
    for (int i = 0; i < (by_enumeration ? PROBLEMS / 10 : PROBLEMS); i++) {
        problem q = {{{0}}, {0}, 0, 0, 1e-3};
        cone_point found;
        make_problem(&q, &seed);
        const cone c = {(const double(*)[CONE_DIM])q.rows, q.m, q.p, q.n};
        double size = sqrt(cone_dot(q.p, q.p, q.n)), tolerance = CONE_VIOLATED * size;
        assert_true(by_enumeration ? cone_enumerate(&c, tolerance, &found)
                                   : cone_project(c.rows, c.m, c.p, c.n, &found));
        if (!by_enumeration)
            conditions_hold(&q, &found, size);
        agrees_with_enumeration(&q, &found, size);
        constrained += found.n_active > 0;
        vanished += cone_dot(found.point, found.point, q.n) < 1e-20;
    }
    assert_true(constrained > PROBLEMS / 40 &&
                vanished > PROBLEMS / 400); /* of both kinds enough */
}

/** Rows nearer to parallel than enumeration by normal equations can tell: the conditions decide. */
static void nearly_parallel_rows(void **state) {
    uint64_t seed = 1181783497276652981u;
    (void)state;
    for (int i = 0; i < PROBLEMS / 5; i++) {
        problem q = {{{0}}, {0}, 0, 0, ldexp(1, -10 - i % 40)};
        cone_point found;
        make_problem(&q, &seed);
        assert_true(cone_project((const double(*)[CONE_DIM])q.rows, q.m, q.p, q.n, &found));
        conditions_hold(&q, &found, sqrt(cone_dot(q.p, q.p, q.n)));
    }
}

/** How often the active set alone is enough: always, or the enumeration would hide its faults. */
static void active_set_seldom_gives_up(void **state) {
    uint64_t seed = 362436069;
    int64_t given_up = 0;
    (void)state;
    for (int i = 0; i < PROBLEMS / 10; i++) {
        problem q = {{{0}}, {0}, 0, 0, 1e-3};
        cone_point found;
        make_problem(&q, &seed);
        const cone c = {(const double(*)[CONE_DIM])q.rows, q.m, q.p, q.n};
        given_up += !cone_active_set(&c, CONE_VIOLATED * sqrt(cone_dot(q.p, q.p, q.n)), &found);
    }
    assert_true(given_up < PROBLEMS / 10 / 100);
}

/** Stars have more rows than a test can enumerate: the conditions alone decide. */
static void many_rows(void **state) {
    enum { ROWS = 60 };
    uint64_t seed = 521288629;
    (void)state;
    for (int i = 0; i < 20000; i++) {
        double rows[ROWS][CONE_DIM] = {{0}}, p[CONE_DIM] = {0}, largest = 0;
        cone_point found;
        int n = 2 + i % 3;
        for (int d = 0; d < n; d++)
            p[d] = uniform(&seed);
        for (int j = 0; j < ROWS; j++)
            for (int d = 0; d < n; d++) /* towards one side, so that something is left */
                rows[j][d] = uniform(&seed) + (d == 0 ? 1 + i % 2 : 0);
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
    static int active_set = 0, enumeration = 1;
    const struct CMUnitTest tests[] = {
        {"a million projections", projections_are_right, NULL, NULL, &active_set},
        {"by enumeration alone", projections_are_right, NULL, NULL, &enumeration},
        cmocka_unit_test(nearly_parallel_rows),
        cmocka_unit_test(active_set_seldom_gives_up),
        cmocka_unit_test(many_rows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
