/* Tests of the measures of src/geometry/simplex.h besides the radius ratio: known elements,
 * textbook formulas, and what must not matter. */
#include "geometry/simplex.h"

#include "geometry/reference.h"
#include "support/meshes.h"

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <string.h>
#include <cmocka.h>

/** Vertices of one element. */
typedef struct simplex {
    double x[4][3];
} simplex;

static const simplex CORNER = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

/** Its first three vertices are an equilateral triangle. */
static simplex regular(void) {
    return (simplex){
        {{0, 0, 0}, {1, 0, 0}, {0.5, sqrt(3) / 2, 0}, {0.5, sqrt(3) / 6, sqrt(6) / 3}}};
}

enum { CIRCUMRADIUS, INRADIUS, EDGES, MEAN, JACOBIAN, N_MEASURES };

static void measure(int dim, const simplex *s, double m[N_MEASURES]) {
    const double *const vertex[4] = {s->x[0], s->x[1], s->x[2], s->x[3]};
    double edges[3][3];
    pl_edges(dim, vertex, edges);
    const pl_shape shape = pl_shape_of_edges(dim, edges);
    const pl_edge_squares squares = pl_edge_squares_of(dim, s->x);
    m[CIRCUMRADIUS] = pl_circumradius_to_edge(dim, &shape, sqrt(squares.longest));
    m[INRADIUS] = pl_edge_to_inradius(dim, &shape, sqrt(squares.longest));
    m[EDGES] = pl_edge_ratio(dim, vertex);
    m[MEAN] = pl_mean_ratio(dim, vertex);
    m[JACOBIAN] = pl_scaled_jacobian_of(dim, shape.determinant, squares.corner);
}

static void expect(int dim, const simplex *s, const double expected[N_MEASURES]) {
    double m[N_MEASURES];
    measure(dim, s, m);
    for (int i = 0; i < N_MEASURES; i++)
        assert_true(fabs(m[i] - expected[i]) <= 4e-15 * fabs(expected[i]));
}

/** A perturbed regular element, positive, squeezed along the last direction. */
static simplex random_simplex(int dim, double flatness, unsigned *seed) {
    simplex s = regular();
    for (int j = 0; j <= dim; j++)
        for (int d = 0; d < dim; d++)
            s.x[j][d] += 0.4 * (test_random(seed) - 0.5);
    for (int j = 0; j <= dim; j++)
        s.x[j][dim - 1] *= flatness;
    return s;
}

/* ---- Known elements ------------------------------------------------------------------------- */

static void the_regular_element_is_1(void **state) {
    (void)state;
    const simplex s = regular();
    for (int dim = 2; dim <= 3; dim++)
        expect(dim, &s, (const double[]){1, 1, 1, 1, 1});
}

/** R = sqrt(3)/2 and r = 1/(3 + sqrt(3)); in the plane sqrt(2)/2 and 1 - sqrt(2)/2. The scaled
 *  Jacobian is that of the vertices with one edge of 1 and two of sqrt(2). */
static void knows_the_corner_of_a_cube(void **state) {
    (void)state;
    expect(3, &CORNER,
           (const double[]){1, (3 + sqrt(3)) / sqrt(12), sqrt(2), 12 * cbrt(0.25) / 9, sqrt(0.5)});
    expect(2, &CORNER,
           (const double[]){sqrt(3) / 2, (1 + sqrt(2)) / sqrt(3), sqrt(2), sqrt(3) / 2,
                            sqrt(2.0 / 3)});
}

/** A square folded by h along its diagonal, the sliver: all edges stay good, R / h is even best,
 * and the others see it. */
static void knows_the_sliver(void **state) {
    (void)state;
    const double h = 1e-8, tiny = 4 * h; /* D */
    const simplex s = {{{-1, 0, 0}, {0, -1, h}, {1, 0, 0}, {0, 1, h}}};
    double m[N_MEASURES];
    measure(3, &s, m);
    assert_true(fabs(m[EDGES] - sqrt(2)) < 1e-14);
    assert_true(fabs(m[CIRCUMRADIUS] - sqrt(2.0 / 3)) < 1e-14);
    /* S = 4, the longest edge 2 */
    assert_true(fabs(m[INRADIUS] * tiny * sqrt(6) / (2 * 4) - 1) < 1e-14);
    assert_true(fabs(m[MEAN] / (12 * cbrt(tiny * tiny / 4) / 16) - 1) < 1e-14);
    assert_true(fabs(m[JACOBIAN] / (sqrt(2) * tiny / 4) - 1) < 1e-14);
}

/** A small face and a far tip, the needle, which all of them but R / h see; in the plane, too. */
static void knows_the_needle(void **state) {
    (void)state;
    const double t = 1e-6;
    for (int dim = 2; dim <= 3; dim++) {
        simplex s = regular();
        double m[N_MEASURES];
        for (int j = 0; j <= dim; j++)
            for (int d = 0; d < dim - 1; d++)
                s.x[j][d] *= t;
        measure(dim, &s, m);
        const double height = dim == 3 ? sqrt(6) / 3 : sqrt(3) / 2;
        assert_true(fabs(m[EDGES] * t / height - 1) < 1e-11);
        assert_true(fabs(m[CIRCUMRADIUS] * (dim == 3 ? sqrt(6) / 2 : 2 / sqrt(3)) - 1) < 1e-11);
        assert_true(m[INRADIUS] > 0.1 / t && m[MEAN] < 20 * t);
        /* at the tip, where edges are nearly parallel */
        const double tip = dim == 3 ? 0.75 * sqrt(6) * t * t : t * 4 / 3;
        assert_true(fabs(m[JACOBIAN] / tip - 1) < 1e-11);
    }
}

static void flat_elements_have_no_quality(void **state) {
    (void)state;
    const simplex s = {{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}}};
    for (int dim = 2; dim <= 3; dim++) {
        double m[N_MEASURES];
        measure(dim, &s, m);
        assert_true(m[MEAN] == 0 && m[JACOBIAN] == 0 && !(m[INRADIUS] < INFINITY));
    }
}

static void reversed_elements_are_negative(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        simplex s = CORNER;
        double m[N_MEASURES], r[N_MEASURES];
        measure(dim, &s, m);
        memcpy(s.x[0], CORNER.x[1], sizeof s.x[0]);
        memcpy(s.x[1], CORNER.x[0], sizeof s.x[0]);
        measure(dim, &s, r);
        assert_true(fabs(r[MEAN] + m[MEAN]) < 1e-15 && fabs(r[JACOBIAN] + m[JACOBIAN]) < 1e-15);
        assert_true(fabs(r[INRADIUS] - m[INRADIUS]) < 1e-14);
        assert_true(fabs(r[CIRCUMRADIUS] - m[CIRCUMRADIUS]) < 1e-14);
    }
}

/* ---- Textbook formulas ---------------------------------------------------------------------- */

static void agree_with_the_textbook(void **state) {
    (void)state;
    static const double flatness[] = {1, 0.1, 1e-2, 1e-4};
    unsigned seed = 21;
    for (int dim = 2; dim <= 3; dim++)
        for (int k = 0; k < 4; k++)
            for (int repeat = 0; repeat < 500; repeat++) {
                const simplex s = random_simplex(dim, flatness[k], &seed);
                const double *const v[4] = {s.x[0], s.x[1], s.x[2], s.x[3]};
                const reference r = reference_of(dim, v);
                const double expected[N_MEASURES] = {
                    (double)r.circumradius_to_edge, (double)r.edge_to_inradius,
                    (double)r.edge_ratio, (double)r.mean_ratio, (double)r.scaled_jacobian};
                double m[N_MEASURES];
                measure(dim, &s, m);
                for (int i = 0; i < N_MEASURES; i++)
                    assert_true(fabs(m[i] - expected[i]) <= 1e-13 * expected[i]);
            }
}

/** Every vertex may be first, and is by some even permutation. */
static void numbering_does_not_matter(void **state) {
    (void)state;
    static const int order[2][4][4] = {{{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 2, 0}},
                                       {{1, 0, 3, 2}, {2, 3, 0, 1}, {3, 2, 1, 0}, {0, 2, 3, 1}}};
    unsigned seed = 22;
    for (int dim = 2; dim <= 3; dim++)
        for (int repeat = 0; repeat < 400; repeat++) {
            const simplex s = random_simplex(dim, 0.3, &seed);
            simplex t = s;
            double m[N_MEASURES];
            for (int j = 0; j <= dim; j++)
                memcpy(t.x[j], s.x[order[dim - 2][repeat % 4][j]], sizeof t.x[j]);
            measure(dim, &s, m);
            double n[N_MEASURES];
            measure(dim, &t, n);
            for (int i = 0; i < N_MEASURES; i++)
                assert_true(fabs(m[i] - n[i]) <= 1e-13 * m[i]);
        }
}

/* ---- Invariance ----------------------------------------------------------------------------- */

/** On a grid of 2^-32, moved by 2^20 and scaled by powers of two: the same bits. */
static void translation_and_scale_keep_the_bits(void **state) {
    (void)state;
    unsigned seed = 23;
    for (int dim = 2; dim <= 3; dim++)
        for (int repeat = 0; repeat < 300; repeat++) {
            simplex s = random_simplex(dim, 0.5, &seed), moved, scaled;
            double m[N_MEASURES], n[N_MEASURES], p[N_MEASURES];
            moved = scaled = s;
            for (int j = 0; j <= dim; j++)
                for (int d = 0; d < dim; d++) {
                    s.x[j][d] = rint(s.x[j][d] * 0x1p22) * 0x1p-32;
                    moved.x[j][d] = s.x[j][d] + 0x1p20;
                    scaled.x[j][d] = ldexp(s.x[j][d], repeat % 80 - 40);
                }
            measure(dim, &s, m);
            measure(dim, &moved, n);
            measure(dim, &scaled, p);
            assert_memory_equal(m, n, sizeof m);
            assert_memory_equal(m, p, sizeof m);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_regular_element_is_1),
        cmocka_unit_test(knows_the_corner_of_a_cube),
        cmocka_unit_test(knows_the_sliver),
        cmocka_unit_test(knows_the_needle),
        cmocka_unit_test(flat_elements_have_no_quality),
        cmocka_unit_test(reversed_elements_are_negative),
        cmocka_unit_test(agree_with_the_textbook),
        cmocka_unit_test(numbering_does_not_matter),
        cmocka_unit_test(translation_and_scale_keep_the_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
