/* Tests of src/geometry/simplex.h: known elements, invariance, and derivatives against finite
 * differences of an independent formula in higher precision. */
#include "geometry/simplex.h"

#include "geometry/derivatives.h"
#include "support/meshes.h"

#include <float.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <string.h>
#include <cmocka.h>

#ifdef PLANISH_HAVE_QUADMATH
#include <quadmath.h>
typedef __float128 wide;
static wide wide_sqrt(wide a) {
    return sqrtq(a);
}
static const double WIDE_EPSILON = 1.9e-34;
#else
typedef long double wide;
static wide wide_sqrt(wide a) {
    return sqrtl(a);
}
static const double WIDE_EPSILON = (double)LDBL_EPSILON;
#endif

/** Vertices of one element. */
typedef struct simplex {
    double x[4][3];
    const double *vertex[4];
} simplex;

static void point_at(simplex *s) {
    for (int j = 0; j < 4; j++)
        s->vertex[j] = s->x[j];
}

/** Its first three vertices are an equilateral triangle. */
static simplex regular(void) {
    simplex s = {{{0, 0, 0}, {1, 0, 0}, {0.5, sqrt(3) / 2, 0}, {0.5, sqrt(3) / 6, sqrt(6) / 3}},
                 {NULL}};
    return s;
}

/* ---- The independent formula: RR = R / (dim r) from lengths and measures only --------------- */

static wide wide_distance(int dim, const wide a[3], const wide b[3]) {
    wide sum = 0;
    for (int d = 0; d < dim; d++)
        sum += (a[d] - b[d]) * (a[d] - b[d]);
    return wide_sqrt(sum);
}

/** Area of the triangle a b c in the plane or in space: half of |ab x ac| by Lagrange. */
static wide wide_area(int dim, const wide a[3], const wide b[3], const wide c[3]) {
    wide bb = 0, cc = 0, bc = 0;
    for (int d = 0; d < dim; d++) {
        bb += (b[d] - a[d]) * (b[d] - a[d]);
        cc += (c[d] - a[d]) * (c[d] - a[d]);
        bc += (b[d] - a[d]) * (c[d] - a[d]);
    }
    return wide_sqrt(bb * cc - bc * bc) / 2;
}

/** Volume by the rule of Sarrus. */
static wide wide_volume(const wide x[4][3]) {
    wide e[3][3];
    for (int j = 0; j < 3; j++)
        for (int d = 0; d < 3; d++)
            e[j][d] = x[j + 1][d] - x[0][d];
    wide plus =
        e[0][0] * e[1][1] * e[2][2] + e[0][1] * e[1][2] * e[2][0] + e[0][2] * e[1][0] * e[2][1];
    wide minus =
        e[0][2] * e[1][1] * e[2][0] + e[0][1] * e[1][0] * e[2][2] + e[0][0] * e[1][2] * e[2][1];
    return (plus - minus) / 6;
}

/** 6 R V is the area of the triangle whose sides are the products of opposite edges (Crelle), by
 *  Heron. */
static wide wide_crelle(const wide x[4][3]) {
    wide a = wide_distance(3, x[0], x[1]) * wide_distance(3, x[2], x[3]);
    wide b = wide_distance(3, x[0], x[2]) * wide_distance(3, x[1], x[3]);
    wide c = wide_distance(3, x[0], x[3]) * wide_distance(3, x[1], x[2]);
    wide s = (a + b + c) / 2;
    return wide_sqrt(s * (s - a) * (s - b) * (s - c));
}

static wide wide_radius_ratio_square(int dim, const wide x[4][3]) {
    wide ratio;
    if (dim == 2) {
        wide a = wide_distance(2, x[0], x[1]), b = wide_distance(2, x[1], x[2]);
        wide c = wide_distance(2, x[2], x[0]), area = wide_area(2, x[0], x[1], x[2]);
        ratio = a * b * c / (4 * area) / (2 * (2 * area / (a + b + c)));
    } else {
        wide volume = wide_volume(x);
        wide surface = wide_area(3, x[0], x[1], x[2]) + wide_area(3, x[0], x[1], x[3]) +
                       wide_area(3, x[0], x[2], x[3]) + wide_area(3, x[1], x[2], x[3]);
        ratio = wide_crelle(x) / (6 * volume) / (3 * (3 * volume / surface));
    }
    return ratio * ratio;
}

static void widen(const simplex *s, wide x[4][3]) {
    for (int j = 0; j < 4; j++)
        for (int d = 0; d < 3; d++)
            x[j][d] = s->x[j][d];
}

/** RR^2 with vertex dim moved by step along direction i and by other along j. */
static wide moved(int dim, const simplex *s, int i, wide step, int j, wide other) {
    wide x[4][3];
    widen(s, x);
    x[dim][i] += step;
    x[dim][j] += other;
    return wide_radius_ratio_square(dim, x);
}

/** Central difference of f along i; second: of second order along i and j. */
static wide difference(int dim, const simplex *s, int i, int j, int second, wide h) {
    if (!second)
        return (moved(dim, s, i, h, i, 0) - moved(dim, s, i, -h, i, 0)) / (2 * h);
    return (moved(dim, s, i, h, j, h) - moved(dim, s, i, h, j, -h) - moved(dim, s, i, -h, j, h) +
            moved(dim, s, i, -h, j, -h)) /
           (4 * h * h);
}

/** Richardson's extrapolation of it twice: the error is of order (h / height)^6. */
static double extrapolated(int dim, const simplex *s, int i, int j, int second, double height) {
    wide h = height * (second ? 2e-4 : 1e-4), a[3];
    if (WIDE_EPSILON > 1e-25)
        h *= 30; /* long double: balance rounding */
    for (int k = 0; k < 3; k++, h /= 2)
        a[k] = difference(dim, s, i, j, second, h);
    wide first = (4 * a[1] - a[0]) / 3, then = (4 * a[2] - a[1]) / 3;
    return (double)((16 * then - first) / 15);
}

/** A perturbed regular element, positive, squeezed to flatness along the last direction. */
static void random_simplex(int dim, double flatness, unsigned *seed, simplex *s) {
    *s = regular();
    point_at(s);
    for (int j = 0; j <= dim; j++)
        for (int d = 0; d < dim; d++)
            s->x[j][d] += 0.4 * (test_random(seed) - 0.5);
    for (int j = 0; j <= dim; j++)
        s->x[j][dim - 1] *= flatness;
    assert_true(pl_simplex_measure(dim, s->vertex) > 0.01 * flatness);
}

/** Make a random simplex twice. */
static void random_twins(int dim, double flatness, unsigned *seed, simplex *s, simplex *t) {
    random_simplex(dim, flatness, seed, s);
    point_at(s);
    *t = *s;
    point_at(t);
}

static void rotate(double x[3], int i, int j, double angle) {
    double xi = x[i], xj = x[j];
    x[i] = cos(angle) * xi - sin(angle) * xj;
    x[j] = sin(angle) * xi + cos(angle) * xj;
}

/* ---- Derivatives ---------------------------------------------------------------------------- */

/** Largest error of value, gradient and Hessian, each relative to its largest entry, or to the
 *  value where that is larger (sizes are about 1). Vertex dim moves, the others are its facet. */
static double derivative_error(int dim, const simplex *s, double height) {
    pl_derivatives rr = pl_radius_ratio_derivatives(dim, s->x[dim], s->vertex);
    double value = (double)moved(dim, s, 0, 0, 0, 0);
    double g_scale = value, h_scale = value, g_error = 0, h_error = 0;
    for (int i = 0; i < dim; i++) {
        double g = extrapolated(dim, s, i, i, 0, height);
        g_scale = fmax(g_scale, fabs(g));
        g_error = fmax(g_error, fabs(g - rr.gradient[i]));
        for (int j = 0; j < dim; j++) {
            double h = extrapolated(dim, s, i, j, 1, height);
            h_scale = fmax(h_scale, fabs(h));
            h_error = fmax(h_error, fabs(h - rr.hessian[i][j]));
            assert_true(rr.hessian[i][j] == rr.hessian[j][i]);
        }
    }
    double v_error = fabs(rr.value / value - 1);
    v_error = fmax(v_error, fabs(pl_radius_ratio_square(dim, s->vertex) / value - 1));
    return fmax(v_error, fmax(g_error / g_scale, h_error / h_scale));
}

/** Squeezed along an axis, coordinates keep their relative precision and so do all results. Turned
 *  out of the axes, the rounding error of D relative to D, and with it that of all derivatives,
 *  grows like 1 / flatness, and so does that of the differences. */
static void derivatives_are_those_of_the_definition(void **state) {
    (void)state;
    static const double flatness[] = {1, 0.1, 1e-2, 1e-4, 1e-6};
    const int quad = WIDE_EPSILON < 1e-25;
    const int levels =
        quad ? 5 : 3; /* less precise differences of flatter elements are worthless */
    const double tolerance = quad ? 2e-14 : 1e-8;
    unsigned seed = 3;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < levels; k++)
            for (int repeat = 0; repeat < 40; repeat++) {
                simplex s;
                random_simplex(dim, flatness[k], &seed, &s);
                point_at(&s);
                for (int j = 0; j <= dim && repeat % 2; j++)
                    rotate(s.x[j], 0, dim - 1, 0.7);
                double error = derivative_error(dim, &s, flatness[k] / 2);
                double loss = quad && repeat % 2 == 0 ? 1 : flatness[k];
                assert_true(error < tolerance / loss);
            }
}

static void regular_is_stationary(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        simplex s = regular();
        point_at(&s);
        pl_derivatives rr = pl_radius_ratio_derivatives(dim, s.x[dim], s.vertex);
        assert_true(fabs(rr.value - 1) < 1e-15 * 8);
        for (int i = 0; i < dim; i++) {
            assert_true(fabs(rr.gradient[i]) < 1e-13);
            assert_true(rr.hessian[i][i] > 1);
        }
    }
}

/* ---- Values --------------------------------------------------------------------------------- */

static void knows_the_regular_elements(void **state) {
    (void)state;
    simplex s = regular();
    point_at(&s);
    double low, high;
    assert_true(fabs(pl_simplex_measure(2, s.vertex) - sqrt(3) / 4) < 1e-15);
    assert_true(fabs(pl_simplex_measure(3, s.vertex) - sqrt(2) / 12) < 1e-15);
    for (int dim = 2; dim <= 3; dim++) {
        assert_true(fabs(pl_radius_ratio_square(dim, s.vertex) - 1) < 1e-14);
        assert_true(fabs(pl_edge_ratio(dim, s.vertex) - 1) < 1e-15);
        pl_angle_cosines(dim, s.vertex, &low, &high);
        assert_true(fabs(low - 1.0 / dim) < 1e-15 && fabs(high - 1.0 / dim) < 1e-15);
    }
}

/** The corner of a cube: three right dihedral angles, three of cosine 1 / sqrt(3); R = sqrt(3) / 2,
 *  r = 1 / (3 + sqrt(3)). */
static void knows_the_corner(void **state) {
    (void)state;
    simplex s = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {NULL}};
    point_at(&s);
    double low, high, ratio = sqrt(3) / 2 * (3 + sqrt(3)) / 3;
    pl_angle_cosines(3, s.vertex, &low, &high);
    assert_true(fabs(low) < 1e-15 && fabs(high - 1 / sqrt(3)) < 1e-15);
    assert_true(fabs(pl_radius_ratio_square(3, s.vertex) - ratio * ratio) < 1e-14);
    assert_true(fabs(pl_edge_ratio(3, s.vertex) - sqrt(2)) < 1e-15);
    /* In the plane, R = sqrt(2) / 2 and r = 1 - sqrt(2) / 2. */
    ratio = sqrt(2) / 4 / (1 - sqrt(2) / 2);
    pl_angle_cosines(2, s.vertex, &low, &high);
    assert_true(fabs(low) < 1e-15 && fabs(high - sqrt(2) / 2) < 1e-15);
    assert_true(fabs(pl_radius_ratio_square(2, s.vertex) - ratio * ratio) < 1e-14);
}

/** An obtuse angle of 120 degrees, and a flat dihedral angle of 2 atan(10). */
static void knows_obtuse_angles(void **state) {
    (void)state;
    simplex triangle = {{{0, 0}, {2, 0}, {1, sqrt(3) / 3}}, {NULL}};
    point_at(&triangle);
    double low, high;
    pl_angle_cosines(2, triangle.vertex, &low, &high);
    assert_true(fabs(low + 0.5) < 1e-15 && fabs(high - sqrt(3) / 2) < 1e-15);
    simplex flat = {{{0, -1, 0}, {10, 0, 1}, {-10, 0, 1}, {0, 1, 0}}, {NULL}};
    point_at(&flat);
    pl_angle_cosines(3, flat.vertex, &low, &high);
    assert_true(fabs(acos(low) - 2 * atan(10)) < 1e-13);
}

static void degenerate_elements_are_infinite(void **state) {
    (void)state;
    simplex s = {{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}}, {NULL}};
    point_at(&s);
    assert_true(pl_simplex_measure(2, s.vertex) == 0 && pl_simplex_measure(3, s.vertex) == 0);
    assert_true(!(pl_radius_ratio_square(2, s.vertex) < INFINITY));
    assert_true(!(pl_radius_ratio_square(3, s.vertex) < INFINITY));
    memcpy(s.x[1], s.x[0], sizeof s.x[0]);
    assert_true(isinf(pl_edge_ratio(2, s.vertex)));
}

/* ---- Invariance ----------------------------------------------------------------------------- */

static void powers_of_two_keep_the_bits(void **state) {
    (void)state;
    unsigned seed = 7;
    for (int dim = 2; dim <= 3; dim++)
        for (int repeat = 0; repeat < 50; repeat++) {
            simplex s, t;
            random_twins(dim, 0.3, &seed, &s, &t);
            for (int j = 0; j <= dim; j++)
                for (int d = 0; d < dim; d++)
                    t.x[j][d] *= 0x1p-40;
            pl_derivatives a = pl_radius_ratio_derivatives(dim, s.x[dim], s.vertex);
            pl_derivatives b = pl_radius_ratio_derivatives(dim, t.x[dim], t.vertex);
            assert_true(pl_radius_ratio_square(dim, s.vertex) ==
                        pl_radius_ratio_square(dim, t.vertex));
            assert_true(a.value == b.value);
            for (int i = 0; i < dim; i++) {
                assert_true(a.gradient[i] == b.gradient[i] * 0x1p-40);
                for (int j = 0; j < dim; j++)
                    assert_true(a.hessian[i][j] == b.hessian[i][j] * 0x1p-80);
            }
        }
}

/** Elements of 2^-10 at 2^20 on a grid of 2^-32: the differences stay what they were. */
static void translation_keeps_the_bits(void **state) {
    (void)state;
    unsigned seed = 8;
    for (int dim = 2; dim <= 3; dim++)
        for (int repeat = 0; repeat < 50; repeat++) {
            simplex s, t;
            random_twins(dim, 0.5, &seed, &s, &t);
            for (int j = 0; j <= dim; j++)
                for (int d = 0; d < dim; d++) {
                    s.x[j][d] = rint(s.x[j][d] * 0x1p22) * 0x1p-32;
                    t.x[j][d] = s.x[j][d] + 0x1p20;
                }
            pl_derivatives a = pl_radius_ratio_derivatives(dim, s.x[dim], s.vertex);
            pl_derivatives b = pl_radius_ratio_derivatives(dim, t.x[dim], t.vertex);
            assert_true(pl_radius_ratio_square(dim, s.vertex) ==
                        pl_radius_ratio_square(dim, t.vertex));
            assert_memory_equal(&a, &b, sizeof a);
        }
}

static void rotation_changes_nothing(void **state) {
    (void)state;
    unsigned seed = 9;
    for (int dim = 2; dim <= 3; dim++)
        for (int repeat = 0; repeat < 50; repeat++) {
            simplex s, t;
            random_twins(dim, 0.5, &seed, &s, &t);
            for (int j = 0; j <= dim; j++) {
                rotate(t.x[j], 0, 1, 0.7);
                if (dim == 3)
                    rotate(t.x[j], 1, 2, 1.9);
            }
            double low, high, t_low, t_high;
            pl_angle_cosines(dim, s.vertex, &low, &high);
            pl_angle_cosines(dim, t.vertex, &t_low, &t_high);
            assert_true(fabs(low - t_low) < 1e-13 && fabs(high - t_high) < 1e-13);
            double rr = pl_radius_ratio_square(dim, s.vertex);
            assert_true(fabs(pl_radius_ratio_square(dim, t.vertex) - rr) < 1e-12 * rr);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(derivatives_are_those_of_the_definition),
        cmocka_unit_test(regular_is_stationary),
        cmocka_unit_test(knows_the_regular_elements),
        cmocka_unit_test(knows_the_corner),
        cmocka_unit_test(knows_obtuse_angles),
        cmocka_unit_test(degenerate_elements_are_infinite),
        cmocka_unit_test(powers_of_two_keep_the_bits),
        cmocka_unit_test(translation_keeps_the_bits),
        cmocka_unit_test(rotation_changes_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
