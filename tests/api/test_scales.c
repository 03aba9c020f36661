/* Meshes of any size: scaled by a power of two they give the same bits, all results included, by
 * whichever kernel; and at the ends of what a double holds they are what they are elsewhere. */
#include "support/effort.h"
#include "support/meshes.h"
#include "support/problems.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- powers of two ----------------------------------------------------------------------------
 */

/** Not 0 if the two are the same number, or both none. */
static int same(double a, double b) {
    return a == b || (isnan(a) && isnan(b));
}

static void expect(double a, double b, const char *what, const test_problem *p, int exponent) {
    if (!same(a, b))
        fail_msg("%d-D, 2^%d, %s: %.17g, not %.17g", p->mesh.dim, exponent, what, b, a);
}

/** What has no unit. */
static void expect_same_quality(const test_problem *p, const planish_quality *a,
                                const planish_quality *b, int exponent) {
    planish_quality copy = *b;
    const int k = p->mesh.dim * exponent;
    expect(ldexp(a->min_volume, k), b->min_volume, "min_volume", p, exponent);
    expect(ldexp(a->max_volume, k), b->max_volume, "max_volume", p, exponent);
    /* of volumes that are infinite there may be none; of subnormal ones the sum is rounded */
    if (abs(k) < DBL_MAX_EXP - 24)
        expect(ldexp(a->total_volume, k), b->total_volume, "total_volume", p, exponent);
    copy.min_volume = a->min_volume;
    copy.max_volume = a->max_volume;
    copy.total_volume = a->total_volume;
    if (memcmp(a, &copy, sizeof copy) != 0)
        fail_msg("%d-D, 2^%d: another quality", p->mesh.dim, exponent);
}

static void expect_same_result(const test_problem *p, const planish_result *a,
                               const planish_result *b, int exponent) {
    planish_result copy = *b;
    expect(ldexp(a->max_displacement, exponent), b->max_displacement, "displacement", p, exponent);
    expect(ldexp(a->min_volume, p->mesh.dim * exponent), b->min_volume, "delta", p, exponent);
    copy.max_displacement = a->max_displacement;
    copy.min_volume = a->min_volume;
    copy.seconds = a->seconds;
    if (memcmp(a, &copy, sizeof copy) != 0)
        fail_msg("%d-D, 2^%d: another result (RMS %.17g, not %.17g; %d sweeps, not %d)",
                 p->mesh.dim, exponent, b->rms, a->rms, b->sweeps, a->sweeps);
}

static void expect_scaled(const test_problem *p, const test_outcome *a, const test_outcome *b,
                          int exponent) {
    for (int64_t i = 0; i < p->mesh.n_nodes * p->mesh.dim; i++)
        expect(ldexp(a->coordinates[i], exponent), b->coordinates[i], "coordinate", p, exponent);
    for (int64_t i = 0; i < p->mesh.n_elements; i++) {
        expect(a->ratio_before[i], b->ratio_before[i], "RR before", p, exponent);
        expect(a->ratio[i], b->ratio[i], "RR", p, exponent);
    }
    expect_same_quality(p, &a->before, &b->before, exponent);
    expect_same_quality(p, &a->after, &b->after, exponent);
    expect_same_result(p, &a->result, &b->result, exponent);
    assert_int_equal(a->unfixable, b->unfixable);
    assert_int_equal(a->below, b->below);
}

/** How far the promise goes: volumes that are asked for, or that push-offs ask for, and squares of
 *  lengths where all nodes are moved together, are to be numbers; floats have their own range. */
static int largest_exponent(test_wish wish, int dim) {
    if (wish == WISH_LEAST_VOLUME || wish == WISH_OWN_VOLUMES || wish == WISH_FRACTION)
        return 950 / dim;
    if (wish == WISH_HOPELESS)
        return 300;
    return wish == WISH_FLOAT ? 100 : 990;
}

static void make(test_problem *p, int dim, test_wish wish, unsigned seed) {
    test_problem_create(p, dim, dim == 3 ? 3 : 5, wish, seed);
}

/** The kernel of this turn, if the CPU has it. */
static planish_isa kernel_of(const test_problem *p, unsigned turn) {
    planish_options options = p->options;
    planish_plan *plan = NULL;
    options.isa = (planish_isa)(turn % 5);
    const int status = planish_plan_create(&p->mesh, &options, &plan, NULL);
    planish_plan_destroy(plan);
    return status ? PLANISH_ISA_AUTO : options.isa;
}

/** One mesh at one size after the other, each by another kernel. Returns the number of sizes. */
static int scale_one(int dim, test_wish wish, unsigned seed, int step) {
    test_problem p;
    const int most = largest_exponent(wish, dim);
    int sizes = 0;
    make(&p, dim, wish, seed);
    p.options.isa = PLANISH_ISA_PLAIN;
    test_outcome one = test_problem_solve(&p);
    assert_true(one.result.n_moved_nodes > 0);
    for (int exponent = -most; exponent <= most; exponent += step, sizes++) {
        test_problem scaled;
        make(&scaled, dim, wish, seed);
        test_problem_scale(&scaled, exponent);
        scaled.options.isa = kernel_of(&scaled, (unsigned)sizes);
        test_outcome o = test_problem_solve(&scaled);
        expect_scaled(&p, &one, &o, exponent);
        test_outcome_destroy(&o);
        test_problem_destroy(&scaled);
    }
    test_outcome_destroy(&one);
    test_problem_destroy(&p);
    return sizes;
}

static void powers_of_two_change_no_bit(void **state) {
    const int dim = *(int *)*state;
    uint64_t random = effort_seed(41 + (uint64_t)dim);
    int sizes = 0;
    for (int i = 0; i < effort(1, 20); i++)
        for (int wish = 0; wish < WISHES; wish++) {
            const int few = wish == WISH_HOPELESS ? 3 : 1;
            const int step = (int)random_below(&random, 40) + (int)effort(130, 30);
            sizes += scale_one(dim, (test_wish)wish, (unsigned)random_bits(&random), few * step);
        }
    figure("%d-D: %d meshes and options at other sizes, up to 2^990, all bits the same", dim,
           sizes);
}

/* ---- the ends ---------------------------------------------------------------------------------
 */

/** By a factor that is no power of two: rounding is all that differs. */
static void the_largest_and_smallest_are_as_others(void **state) {
    const int dim = *(int *)*state;
    static const double sizes[] = {1e-300, 1e-100, 1e100, 1e300};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        test_problem p, scaled;
        make(&p, dim, WISH_TANGLED, 3);
        make(&scaled, dim, WISH_TANGLED, 3);
        p.options.tolerance = scaled.options.tolerance = 1e-12;
        test_problem_move(&scaled, sizes[i], 0);
        test_outcome a = test_problem_solve(&p), b = test_problem_solve(&scaled);
        assert_int_equal(a.before.n_inverted, b.before.n_inverted);
        assert_int_equal(b.after.n_inverted, 0);
        assert_true(fabs(b.after.rms_radius_ratio / a.after.rms_radius_ratio - 1) < 1e-8);
        test_outcome_destroy(&a);
        test_outcome_destroy(&b);
        test_problem_destroy(&p);
        test_problem_destroy(&scaled);
    }
}

/** Coordinates of a few bits, subnormal ones: measured, they are what they are in a size where they
 *  are not, bit for bit; smoothed, they keep the promises. */
static void subnormal_meshes_are_measured_exactly(void **state) {
    enum { SMALL = -1071 };
    const int dim = *(int *)*state;
    for (unsigned seed = 0; seed < effort(10, 500); seed++)
        for (int exponent = SMALL; exponent < SMALL + 30; exponent += 7) {
            test_problem small, large;
            make(&small, dim, seed % 2 ? WISH_PLAIN : WISH_TANGLED, seed);
            make(&large, dim, seed % 2 ? WISH_PLAIN : WISH_TANGLED, seed);
            test_problem_scale(&small, exponent); /* rounds */
            for (int64_t i = 0; i < small.mesh.n_nodes * dim; i++)
                large.coordinates[i] = ldexp(small.coordinates[i], -exponent);
            test_outcome a = test_problem_solve(&large), b = test_problem_solve(&small);
            for (int64_t i = 0; i < small.mesh.n_elements; i++)
                expect(a.ratio_before[i], b.ratio_before[i], "RR before", &small, exponent);
            assert_int_equal(a.before.n_inverted, b.before.n_inverted);
            assert_true(b.after.n_inverted <= b.before.n_inverted);
            if (b.before.n_inverted == 0) {
                assert_true(b.after.max_radius_ratio <= b.before.max_radius_ratio);
                assert_true(b.after.rms_radius_ratio <= b.before.rms_radius_ratio);
            }
            test_outcome_destroy(&a);
            test_outcome_destroy(&b);
            test_problem_destroy(&small);
            test_problem_destroy(&large);
        }
}

/** A node between others whose coordinates are numbers, but not their differences. */
static void pyramid(test_problem *p, int exponent) {
    test_mesh mesh;
    make(p, 3, WISH_PLAIN, 1);
    test_mesh_double_pyramid(&mesh, 3);
    memcpy(p->coordinates, mesh.coordinates, (size_t)mesh.mesh.n_nodes * 3 * sizeof(double));
    memcpy(p->elements, mesh.elements, (size_t)mesh.mesh.n_elements * 4 * sizeof(int32_t));
    p->coordinates[0] = 0.25;
    p->coordinates[2] = -0.5;
    p->mesh.n_nodes = mesh.mesh.n_nodes;
    p->mesh.n_elements = mesh.mesh.n_elements;
    test_problem_move(p, 1.25, 0);
    test_problem_scale(p, exponent);
    test_mesh_destroy(&mesh);
}

static void differences_may_overflow(void **state) {
    test_problem p, large;
    (void)state;
    pyramid(&p, 0);
    pyramid(&large, 1023);
    assert_true(isinf(large.coordinates[3 * 1 + 2] - large.coordinates[3 * 2 + 2]));
    assert_true(isinf(large.coordinates[3 * 4 + 1] - large.coordinates[3 * 5 + 1]));
    test_outcome a = test_problem_solve(&p), b = test_problem_solve(&large);
    assert_int_equal(a.result.n_moved_nodes, 1);
    expect_scaled(&p, &a, &b, 1023);
    test_outcome_destroy(&a);
    test_outcome_destroy(&b);
    test_problem_destroy(&p);
    test_problem_destroy(&large);
}

/** Boxes of sizes that have nothing in common, in one mesh: each element is measured as in a mesh
 *  of its own, and the mesh is smoothed. */
static void sizes_may_be_mixed(void **state) {
    const int dim = *(int *)*state;
    static const int exponents[] = {-900, -300, 0, 900};
    enum { N = sizeof exponents / sizeof *exponents };
    test_problem one;
    test_mesh box, all = {0};
    make(&one, dim, WISH_PLAIN, 3);
    const int64_t m = one.mesh.n_elements;
    for (int i = 0; i < N; i++) {
        test_mesh_create(&box, dim, one.mesh.n_nodes, one.coordinates, m, one.elements);
        test_mesh_transform(&box, ldexp(1, exponents[i]), 0);
        if (i == 0) {
            all = box;
            continue;
        }
        test_mesh_append(&all, &box, 0);
        test_mesh_destroy(&box);
    }
    planish_plan *plan;
    planish_quality before, after;
    double *ratio = malloc((size_t)(N * m) * sizeof *ratio);
    assert_int_equal(planish_plan_create(&all.mesh, &one.options, &plan, NULL), 0);
    assert_int_equal(planish_measure_elements(plan, all.coordinates, ratio, NULL), 0);
    test_outcome alone = test_problem_solve(&one);
    for (int64_t i = 0; i < N * m; i++)
        expect(alone.ratio_before[i % m], ratio[i], "RR", &one, exponents[i / m]);
    assert_int_equal(planish_measure(plan, all.coordinates, &before, NULL), 0);
    assert_int_equal(planish_smooth(plan, all.coordinates, &one.options, NULL, NULL), 0);
    assert_int_equal(planish_measure(plan, all.coordinates, &after, NULL), 0);
    assert_int_equal(before.n_inverted + after.n_inverted, 0);
    assert_true(fabs(after.rms_radius_ratio / alone.after.rms_radius_ratio - 1) < 1e-4);
    planish_plan_destroy(plan);
    free(ratio);
    test_mesh_destroy(&all);
    test_outcome_destroy(&alone);
    test_problem_destroy(&one);
}

int main(void) {
    static int two = 2, three = 3;
    const struct CMUnitTest tests[] = {
        {"powers of two 2-D", powers_of_two_change_no_bit, NULL, NULL, &two},
        {"powers of two 3-D", powers_of_two_change_no_bit, NULL, NULL, &three},
        {"ends 2-D", the_largest_and_smallest_are_as_others, NULL, NULL, &two},
        {"ends 3-D", the_largest_and_smallest_are_as_others, NULL, NULL, &three},
        {"subnormal 2-D", subnormal_meshes_are_measured_exactly, NULL, NULL, &two},
        {"subnormal 3-D", subnormal_meshes_are_measured_exactly, NULL, NULL, &three},
        cmocka_unit_test(differences_may_overflow),
        {"mixed 2-D", sizes_may_be_mixed, NULL, NULL, &two},
        {"mixed 3-D", sizes_may_be_mixed, NULL, NULL, &three},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
