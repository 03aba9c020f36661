/* Measures of elements and their derivatives: against the reference formulas, and against differences of
 * values. */
#include "geometry/slope.h"
#include "support/meshes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

enum { ANGLE, RATIO, MEAN, JACOBIAN, KINDS, CASES = 200 };

/* Central differences with this step are right within this of derivatives of about 1. */
#define STEP 1e-5
#define NEAR 1e-7

static pl_corner_form forms[PL_N_FORMS];

static int measures(int dim, int kind, uint8_t form, double x[4][3], int derive, pl_slope *slope) {
    const double(*at)[3] = (const double(*)[3])x;
    if (kind == ANGLE)
        return pl_angle_slopes(dim, at, derive, slope);
    if (kind == JACOBIAN)
        return pl_jacobian_slopes(dim, at, &forms[form], pl_corner_kind(form) == PL_KIND_SIMPLEX,
                                  derive, slope);
    if (kind == MEAN)
        pl_mean_slope(dim, at, &forms[form], derive, slope);
    else
        pl_ratio_slope(dim, at, derive, slope);
    return 1;
}

/** Random vertices in a positive order, of an element that is not flat. */
static void random_vertices(int dim, unsigned *seed, double x[4][3]) {
    double edge[3][3];
    const double *vertex[4] = {x[0], x[1], x[2], x[3]};
    do {
        for (int v = 0; v <= dim; v++)
            for (int d = 0; d < dim; d++)
                x[v][d] = test_random(seed);
        pl_edges(dim, vertex, edge);
    } while (!(pl_determinant_of_edges(dim, (const double(*)[3])edge) > 0.1));
}

/** All derivatives are those of the values. */
static void derivatives_are_differences(void **state) {
    const int dim = *(int *)*state;
    unsigned seed = 3;
    pl_corner_forms_make(dim, forms);
    for (int i = 0; i < CASES; i++) {
        double x[4][3];
        random_vertices(dim, &seed, x);
        const int brick = i % 2, place = i % (dim + 1);
        const uint8_t form = pl_form_code(
            pl_corner_code(brick ? PL_KIND_BRICK : PL_KIND_SIMPLEX, 0), place, i % 3 == 0);
        for (int kind = 0; kind < KINDS; kind++) {
            pl_slope slope[PL_MOST_SLOPES], up[PL_MOST_SLOPES], down[PL_MOST_SLOPES];
            const int n = measures(dim, kind, form, x, 1, slope);
            for (int v = 0; v <= dim; v++)
                for (int d = 0; d < dim; d++) {
                    const double was = x[v][d];
                    x[v][d] = was + STEP;
                    measures(dim, kind, form, x, 0, up);
                    x[v][d] = was - STEP;
                    measures(dim, kind, form, x, 0, down);
                    x[v][d] = was;
                    for (int k = 0; k < n; k++)
                        assert_true(
                            fabs((up[k].value - down[k].value) / (2 * STEP) - slope[k].by[v][d]) <=
                            NEAR * (1 + fabs(slope[k].by[v][d])) * 100);
                }
        }
    }
}

/** The values are those of the reference. */
static void values_are_those_of_the_reference(void **state) {
    const int dim = *(int *)*state;
    unsigned seed = 4;
    pl_corner_forms_make(dim, forms);
    for (int i = 0; i < CASES; i++) {
        double x[4][3], edge[3][3], least = INFINITY, largest = 0;
        const double *vertex[4] = {x[0], x[1], x[2], x[3]};
        pl_slope slope[PL_MOST_SLOPES];
        random_vertices(dim, &seed, x);
        pl_edges(dim, vertex, edge);
        const pl_shape shape = pl_shape_of_edges(dim, (const double(*)[3])edge);
        const int n = measures(dim, ANGLE, 0, x, 0, slope);
        assert_int_equal(n, dim == 3 ? 6 : 3);
        for (int k = 0; k < n; k++) {
            least = fmin(least, slope[k].value);
            largest = fmax(largest, slope[k].value);
        }
        assert_true(fabs(least - pl_smallest_angle(&shape)) < 1e-12);
        assert_true(fabs(largest - pl_largest_angle(&shape)) < 1e-12);
        measures(dim, RATIO, 0, x, 0, slope);
        assert_true(fabs(slope->value * sqrt(pl_radius_ratio_square(dim, vertex)) - 1) < 1e-12);
        const uint8_t simplex = pl_form_code(pl_corner_code(PL_KIND_SIMPLEX, 0), dim, 0);
        measures(dim, MEAN, simplex, x, 0, slope);
        assert_true(fabs(slope->value / pl_mean_ratio(dim, vertex) - 1) < 1e-12);
        assert_int_equal(measures(dim, JACOBIAN, simplex, x, 0, slope), dim + 1);
    }
}

/** A flat element has no measure but angles of 0 and 180 degrees. */
static void flat_elements_have_none(void **state) {
    (void)state;
    double x[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    pl_slope slope[PL_MOST_SLOPES];
    pl_corner_forms_make(3, forms);
    for (int kind = RATIO; kind < KINDS; kind++) {
        measures(3, kind, pl_form_code(pl_corner_code(PL_KIND_BRICK, 0), 0, 0), x, 0, slope);
        assert_true(slope->value == 0);
    }
}

int main(void) {
    static int dims[] = {2, 3};
    const struct CMUnitTest tests[] = {
        {"derivatives_are_differences 2-D", derivatives_are_differences, NULL, NULL, &dims[0]},
        {"derivatives_are_differences 3-D", derivatives_are_differences, NULL, NULL, &dims[1]},
        {"values_are_those_of_the_reference 2-D", values_are_those_of_the_reference, NULL, NULL,
         &dims[0]},
        {"values_are_those_of_the_reference 3-D", values_are_those_of_the_reference, NULL, NULL,
         &dims[1]},
        cmocka_unit_test(flat_elements_have_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
