/* Metrics: sizes and triangles against products of matrices. */
#include "geometry/metric.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

/** A number from -1 to 1. */
static double draw(uint64_t *state) {
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) * 0x1p-52 - 1;
}

/** Fill axes with an orthonormal frame. */
static void draw_frame(int dim, uint64_t *state, double axes[3][3]) {
    for (int i = 0; i < dim; i++) {
        double square = 0;
        for (int d = 0; d < dim; d++)
            axes[i][d] = draw(state);
        for (int j = 0; j < 2 * i; j++) { /* twice, for those that are nearly parallel */
            double along = 0;
            for (int d = 0; d < dim; d++)
                along += axes[i][d] * axes[j % i][d];
            for (int d = 0; d < dim; d++)
                axes[i][d] -= along * axes[j % i][d];
        }
        for (int d = 0; d < dim; d++)
            square += axes[i][d] * axes[i][d];
        for (int d = 0; d < dim; d++)
            axes[i][d] /= sqrt(square);
    }
}

/** Fill m with the sum of value[i] axis axis^T. */
static void compose(int dim, double axes[3][3], const double *value, double *m) {
    for (int r = 0; r < dim; r++)
        for (int c = r; c < dim; c++) {
            double sum = 0;
            for (int i = 0; i < dim; i++)
                sum += value[i] * axes[i][r] * axes[i][c];
            m[pl_symmetric_at(c, r)] = sum;
        }
}

static void places_are_those_of_medit(void **state) {
    (void)state;
    static const int place[3][3] = {{0, 1, 3}, {1, 2, 4}, {3, 4, 5}};
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            assert_int_equal(pl_symmetric_at(r, c), place[r][c]);
}

/** Sizes are the roots of 1 / M along its axes, and what is long in units of these is long in L. */
static void sizes_and_triangles_are_right(void **state) {
    (void)state;
    uint64_t seed = 5;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 2000; k++) {
            double axes[3][3] = {{0}}, of_m[3], size[3], m[6], h[6], expected[6], least, most;
            double det = 1, squares = 0;
            pl_metric metric;
            draw_frame(dim, &seed, axes);
            for (int i = 0; i < dim; i++) {
                size[i] = pow(10, (k % 4) * draw(&seed)); /* ratios up to 1e6 */
                of_m[i] = 1 / (size[i] * size[i]);
                det *= size[i];
            }
            const double error = 1e-15 * pow(10, 4 * (k % 4));
            compose(dim, axes, of_m, m);
            compose(dim, axes, size, expected);
            assert_true(pl_metric_sizes(dim, m, h, &least, &most));
            for (int i = 0; i < pl_symmetric_count(dim); i++)
                assert_true(fabs(h[i] - expected[i]) < 100 * error * most);
            for (int i = 0; i < dim; i++)
                assert_true(size[i] > least * (1 - 1e-3) && size[i] < most * (1 + 1e-3));
            assert_true(fabs(pl_metric_make(dim, expected, &metric) / det - 1) < 1e-8);
            const double edges[3][3] = {{axes[0][0], axes[0][1], axes[0][2]},
                                        {axes[1][0], axes[1][1], axes[1][2]},
                                        {axes[2][0], axes[2][1], axes[2][2]}};
            double y[3][3];
            pl_metric_apply(dim, metric.l, edges, y);
            for (int i = 0; i < dim; i++) {
                squares =
                    y[i][0] * y[i][0] + y[i][1] * y[i][1] + (dim == 3 ? y[i][2] * y[i][2] : 0);
                const double wanted = pow(det, 1.0 / dim) / size[i];
                assert_true(fabs(sqrt(squares) / wanted - 1) < 1e-3 * error / 1e-15);
                assert_true(k % 4 > 1 || fabs(sqrt(squares) / wanted - 1) < 1e-10);
            }
        }
}

/** The same metric in other units has the same bits, but for the power of two. */
static void scale_does_not_matter(void **state) {
    (void)state;
    static const double M[6] = {3, 0.5, 2, -0.25, 0.125, 7};
    for (int dim = 2; dim <= 3; dim++)
        for (int exponent = -900; exponent <= 900; exponent += 300) {
            double m[6], a[6], b[6], least, most;
            for (int k = 0; k < 6; k++)
                m[k] = ldexp(M[k], exponent);
            assert_true(pl_metric_sizes(dim, M, a, &least, &most));
            assert_true(pl_metric_sizes(dim, m, b, &least, &most));
            for (int k = 0; k < pl_symmetric_count(dim); k++)
                assert_true(ldexp(b[k], exponent / 2) == a[k]);
        }
}

static void what_is_no_metric_is_refused(void **state) {
    (void)state;
    static const double cases[][6] = {{0},
                                      {1, 0, 0, 0, 0, 1},
                                      {1, 2, 1, 0, 0, 1},
                                      {-1, 0, 1, 0, 0, 1},
                                      {NAN, 0, 1, 0, 0, 1},
                                      {1, NAN, 1, 0, 0, 1},
                                      {INFINITY, 0, 1, 0, 0, 1}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++)
        for (int dim = 2; dim <= 3; dim++) {
            double h[6], least, most;
            assert_false(pl_metric_sizes(dim, cases[k], h, &least, &most));
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(places_are_those_of_medit),
        cmocka_unit_test(sizes_and_triangles_are_right),
        cmocka_unit_test(scale_does_not_matter),
        cmocka_unit_test(what_is_no_metric_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
