/* Small max-min problems: the conditions of optimality (Karush, Kuhn, Tucker), of random problems, of ties
 * and of degenerate ones; and a plain method that converges slowly finds no better step. */
#include "improve/maxmin.h"
#include "support/meshes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { N = 15, M = 60, BLOCK = 3, CASES = 300 };

/* Conditions hold within this; values and slopes are about 1. */
#define WITHIN 1e-7

/** A problem and its memory. */
typedef struct fixture {
    pl_maxmin problem;
    pl_maxmin_row row[M];
    double room[PL_MAXMIN_ROOM(N)], x[N], multiplier[N + 1];
    int active[N + 1];
} fixture;

/** Random rows of blocks of 3, 2 and 1 entries; every third row is kept, not raised. */
static void random_problem(unsigned *seed, int m, fixture *f) {
    f->problem = (pl_maxmin){.n = N,
                             .m = m,
                             .row = f->row,
                             .reach = pow(10, 4 * test_random(seed) - 2),
                             .spread = 0.3,
                             .target = 0.2 * test_random(seed) + 0.01,
                             .room = f->room,
                             .x = f->x,
                             .active = f->active,
                             .multiplier = f->multiplier};
    for (int i = 0; i < m; i++) {
        pl_maxmin_row *row = &f->row[i];
        memset(row, 0, sizeof *row);
        row->is_raised = i % 3 != 2;
        row->value = i == 0 ? 0 : 0.1 * test_random(seed);
        row->n_blocks = 1 + i % PL_MAXMIN_BLOCKS;
        for (int b = 0; b < row->n_blocks; b++) {
            row->first[b] = BLOCK * ((i + b) % (N / BLOCK));
            row->width[b] = (uint8_t)(row->first[b] == 0 ? 1 : row->first[b] == BLOCK ? 2 : 3);
            for (int d = 0; d < row->width[b]; d++)
                row->slope[b][d] = 2 * test_random(seed) - 1;
        }
    }
}

/** value + slope . x of a row. */
static double row_at(const pl_maxmin_row *row, const double *x) {
    double value = row->value;
    for (int b = 0; b < row->n_blocks; b++)
        for (int d = 0; d < row->width[b]; d++)
            value += row->slope[b][d] * x[row->first[b] + d];
    return value;
}

/** The step is feasible, multipliers are positive and at rows that hold it back, and the gradient of what
 *  is minimised is the rows' with these. */
static void expect_optimal(const fixture *f) {
    const pl_maxmin *p = &f->problem;
    double gradient[N], of_t = (p->t - p->target) / p->spread;
    for (int i = 0; i < N; i++)
        gradient[i] = p->x[i] / p->reach;
    for (int i = 0; i < p->m; i++)
        assert_true(row_at(&p->row[i], p->x) >= (p->row[i].is_raised ? p->t : 0) - WITHIN);
    for (int a = 0; a < p->n_active; a++) {
        const pl_maxmin_row *row = &p->row[p->active[a]];
        assert_true(p->multiplier[a] >= 0);
        assert_true(fabs(row_at(row, p->x) - (row->is_raised ? p->t : 0)) < WITHIN);
        of_t += row->is_raised ? p->multiplier[a] : 0;
        for (int b = 0; b < row->n_blocks; b++)
            for (int d = 0; d < row->width[b]; d++)
                gradient[row->first[b] + d] -= p->multiplier[a] * row->slope[b][d];
    }
    assert_true(fabs(of_t) < WITHIN);
    for (int i = 0; i < N; i++)
        assert_true(fabs(gradient[i]) < WITHIN);
}

static void random_problems_are_solved(void **state) {
    (void)state;
    static fixture f;
    unsigned seed = 5;
    int n_held = 0;
    for (int i = 0; i < CASES; i++) {
        random_problem(&seed, 1 + i % M, &f);
        assert_true(pl_maxmin_solve(&f.problem));
        expect_optimal(&f);
        assert_true(f.problem.t >= -WITHIN && f.problem.t <= f.problem.target + WITHIN);
        n_held += f.problem.n_active > 2;
    }
    assert_true(n_held > CASES / 2);
}

/** Rows that are there twice, and rows that contradict one another where the step begins. */
static void degenerate_problems_are_solved(void **state) {
    (void)state;
    static fixture f;
    unsigned seed = 6;
    for (int i = 0; i < CASES; i++) {
        random_problem(&seed, M, &f);
        for (int k = 0; k < M / 2; k++)
            f.row[M / 2 + k] = f.row[k];
        for (int k = 0; k < M / 4; k++)
            f.row[k].value = f.row[M / 2 + k].value = 0;
        assert_true(pl_maxmin_solve(&f.problem));
        expect_optimal(&f);
    }
    random_problem(&seed, 2, &f);
    f.row[1] = f.row[0]; /* up and down: nothing can be raised */
    for (int b = 0; b < f.row[0].n_blocks; b++)
        for (int d = 0; d < BLOCK; d++)
            f.row[1].slope[b][d] = -f.row[0].slope[b][d];
    assert_true(pl_maxmin_solve(&f.problem));
    expect_optimal(&f);
    assert_true(fabs(f.problem.t) < WITHIN);
}

/** What is minimised at x, t as large as the rows let it be; infinite where x breaks a row. */
static double cost_at(const pl_maxmin *p, const double *x) {
    double t = p->target, square = 0;
    for (int i = 0; i < p->m; i++) {
        const double value = row_at(&p->row[i], x);
        if (p->row[i].is_raised)
            t = fmin(t, value);
        else if (value < -WITHIN)
            return INFINITY;
    }
    for (int i = 0; i < p->n; i++)
        square += x[i] * x[i];
    return square / (2 * p->reach) + (p->target - t) * (p->target - t) / (2 * p->spread);
}

/** No step near the solution, in random directions, costs less. */
static void no_step_is_better(void **state) {
    (void)state;
    static fixture f;
    unsigned seed = 7;
    for (int i = 0; i < CASES / 10; i++) {
        random_problem(&seed, M, &f);
        pl_maxmin_solve(&f.problem);
        const double cost = cost_at(&f.problem, f.problem.x);
        for (int k = 0; k < 1000; k++) {
            double x[N];
            const double size = pow(10, -6 * test_random(&seed));
            for (int j = 0; j < N; j++)
                x[j] = f.problem.x[j] + size * (2 * test_random(&seed) - 1);
            assert_true(cost_at(&f.problem, x) >= cost * (1 - WITHIN) - 1e-12);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_problems_are_solved),
        cmocka_unit_test(degenerate_problems_are_solved),
        cmocka_unit_test(no_step_is_better),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
