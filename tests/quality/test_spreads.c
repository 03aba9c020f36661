/* Tests of the spreads that src/quality/measure.c fills in: against textbook formulas, element by
 * element; extreme elements; and the promises about threads, scale and place. */
#include "base/parallel.h"
#include "quality/measure.h"

#include "geometry/reference.h"
#include "support/meshes.h"

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

enum { N_SPREADS = 8 };

static planish_quality measure(const planish_mesh *mesh, int threads) {
    uint8_t *is_free = malloc((size_t)mesh->n_nodes);
    planish_quality q;
    assert_non_null(is_free);
    memset(is_free, 1, (size_t)mesh->n_nodes);
    memset(&q, 0, sizeof q);
    const pl_view view = {.dim = mesh->dim,
                          .n_nodes = mesh->n_nodes,
                          .n_elements = mesh->n_elements,
                          .elements = mesh->elements,
                          .mobility = is_free};
    assert_int_equal(pl_measure(&view, mesh->coordinates, pl_thread_count(threads), &q, NULL),
                     PLANISH_OK);
    free(is_free);
    return q;
}

static planish_quality measure_one(int dim, const double *coordinates) {
    static const int32_t element[] = {0, 1, 2, 3};
    test_mesh one;
    test_mesh_create(&one, dim, dim + 1, coordinates, 1, element);
    const planish_quality q = measure(&one.mesh, 1);
    test_mesh_destroy(&one);
    return q;
}

/** The spreads of q in their order. */
static void list(const planish_quality *q, planish_spread spread[N_SPREADS]) {
    const planish_spread all[N_SPREADS] = {
        q->radius_ratio, q->circumradius_to_edge, q->edge_to_inradius,   q->edge_ratio,
        q->mean_ratio,   q->scaled_jacobian,      q->smallest_angle_deg, q->largest_angle_deg};
    memcpy(spread, all, sizeof all);
}

static void list_reference(const reference *r, real value[N_SPREADS]) {
    const real all[N_SPREADS] = {r->radius_ratio,   r->circumradius_to_edge, r->edge_to_inradius,
                                 r->edge_ratio,     r->mean_ratio,           r->scaled_jacobian,
                                 r->smallest_angle, r->largest_angle};
    memcpy(value, all, sizeof all);
}

static void assert_near(double a, real b, double tolerance) {
    assert_true(fabsl((real)a - b) <= (real)tolerance * fabsl(b));
}

static void vertices_of(const test_mesh *mesh, int64_t element, const double *v[4]) {
    const int dim = mesh->mesh.dim;
    for (int j = 0; j <= dim; j++)
        v[j] = mesh->coordinates + (int64_t)mesh->elements[element * (dim + 1) + j] * dim;
}

/* ---- Brute force ---------------------------------------------------------------------------- */

/** Over a mesh some of whose elements are reversed, which do not count. */
static void spreads_are_those_of_the_textbook(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        test_mesh_box(&box, dim, 9);
        test_mesh_perturb(&box, 0.14, 4);
        const int64_t n = box.mesh.n_elements;
        int64_t bins[PLANISH_ANGLE_BINS] = {0};
        real sum[N_SPREADS] = {0}, min[N_SPREADS], max[N_SPREADS] = {0}, n_valid = 0;
        for (int m = 0; m < N_SPREADS; m++)
            min[m] = INFINITY;
        for (int64_t e = 0; e < n; e++) {
            const double *v[4];
            real value[N_SPREADS];
            vertices_of(&box, e, v);
            const reference r = reference_of(dim, v);
            list_reference(&r, value);
            if (e % 7 == 3) {
                test_mesh_reverse(&box, e);
                continue;
            }
            n_valid++;
            bins[(int)(r.smallest_angle / 5)]++;
            for (int m = 0; m < N_SPREADS; m++) {
                sum[m] += value[m];
                min[m] = fminl(min[m], value[m]);
                max[m] = fmaxl(max[m], value[m]);
            }
        }
        const planish_quality q = measure(&box.mesh, 2);
        planish_spread spread[N_SPREADS];
        list(&q, spread);
        assert_true((real)(n - q.n_inverted) == n_valid && q.n_inverted > n / 8);
        for (int m = 0; m < N_SPREADS; m++) {
            assert_true(min[m] < sum[m] / n_valid && sum[m] / n_valid < max[m]);
            assert_near(spread[m].min, min[m], 1e-13);
            assert_near(spread[m].mean, sum[m] / n_valid, 1e-13);
            assert_near(spread[m].max, max[m], 1e-13);
        }
        assert_memory_equal(q.angle_counts, bins, sizeof bins);
        for (int i = 0; i <= PLANISH_ANGLE_BINS; i++)
            assert_true(q.angle_edges_deg[i] == 5 * i);
        test_mesh_destroy(&box);
    }
}

/** What is said twice is said alike. */
static void spreads_agree_with_the_other_figures(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        test_mesh_box(&box, dim, 6);
        test_mesh_perturb(&box, 0.14, 9);
        const planish_quality q = measure(&box.mesh, 1);
        assert_true(q.radius_ratio.mean == q.mean_radius_ratio);
        assert_true(q.radius_ratio.max == q.max_radius_ratio);
        assert_true(q.smallest_angle_deg.min == q.min_angle_deg);
        assert_true(q.largest_angle_deg.max == q.max_angle_deg);
        test_mesh_destroy(&box);
    }
}

static void nothing_is_over_no_valid_element(void **state) {
    (void)state;
    static const double reversed[] = {0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1};
    const planish_spread none = {0, 0, 0};
    const planish_quality q = measure_one(3, reversed);
    planish_spread spread[N_SPREADS];
    list(&q, spread);
    assert_int_equal(q.n_inverted, 1);
    for (int m = 0; m < N_SPREADS; m++)
        assert_memory_equal(&spread[m], &none, sizeof none);
}

/* ---- Extreme elements: those that are looked at one by one ---------------------------------- */

/** A flat tetrahedron whose sign only exact arithmetic tells, by the textbook in long double: its
 *  coordinates are such that nothing cancels there. */
static void nearly_flat_elements_are_right(void **state) {
    (void)state;
    for (int exponent = -30; exponent >= -140; exponent -= 10) {
        const double h = ldexp(1, exponent);
        const double x[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0.25, 0.375, h};
        const double *const v[4] = {x, x + 3, x + 6, x + 9};
        const planish_quality q = measure_one(3, x);
        assert_int_equal(q.n_inverted, 0);
        const real edges = sqrtl(2) / reference_distance(3, v[0], v[3]);
        assert_near(q.edge_ratio.mean, edges, 1e-14);
        assert_near(q.mean_ratio.mean, reference_mean_ratio(3, v), 1e-14);
        assert_near(q.scaled_jacobian.mean, reference_scaled_jacobian(3, v), 1e-14);
        /* S = 1 without h; the centre is over (1/2, 1/2) at (h^2 + 0.25^2 + 0.375^2 - 0.625) / 2h
         */
        const real z = ((real)h * h + 0.0625L + 0.140625L - 0.625L) / (2 * h);
        const real circumradius = sqrtl(0.5L + z * z);
        assert_near(q.circumradius_to_edge.mean, circumradius / sqrtl(2) * 4 / sqrtl(6), 1e-8);
        assert_near(q.edge_to_inradius.mean, sqrtl(2) / (h * sqrtl(6)), 1e-8);
        assert_near(q.radius_ratio.mean, circumradius / (3 * (real)h / 2), 1e-8);
        assert_true(q.smallest_angle_deg.max < 1e-6 && q.largest_angle_deg.min > 180 - 1e-6);
    }
}

/** Two vertices that are 2^-100 and less from one another; faces below 2^-500 have no angles left.
 */
static void short_edges_are_right(void **state) {
    (void)state;
    for (int exponent = -100; exponent >= -900; exponent -= 100) {
        const double h = ldexp(1, exponent);
        const double x[] = {0, 0, 0, h, 0, 0, 0, 1, 0, 0, 0, 1};
        const planish_quality q = measure_one(3, x);
        planish_spread spread[N_SPREADS];
        list(&q, spread);
        assert_int_equal(q.n_inverted, 0);
        assert_near(q.edge_ratio.mean, sqrtl(2) / h, 1e-14);
        /* D = h; edges 1, 1, sqrt(2) are left of the sum; sqrt(2) D / product at the far vertices
         */
        assert_near(q.mean_ratio.mean, 12 * cbrtl((real)h * h / 4) / 6, 1e-14);
        assert_near(q.scaled_jacobian.mean, h, 1e-14);
        assert_true(q.circumradius_to_edge.mean >= 0.81 && q.circumradius_to_edge.mean < 1);
        assert_true(q.edge_to_inradius.mean > 0.4 / h && q.edge_to_inradius.mean < 2 / h);
        if (exponent >= -500)
            assert_near(q.largest_angle_deg.mean, 90, 1e-14);
        for (int m = 0; m < N_SPREADS; m++)
            assert_false(isnan(spread[m].min) || isnan(spread[m].mean) || isnan(spread[m].max));
    }
}

/** Down to where a double ends, no measure is lost to NaN or leaves its range. */
static void whatever_is_valid_has_measures(void **state) {
    (void)state;
    unsigned seed = 31;
    int valid = 0;
    for (int dim = 2; dim <= 3; dim++)
        for (int repeat = 0; repeat < 20000; repeat++) {
            double x[12];
            for (int i = 0; i < dim * (dim + 1); i++)
                x[i] = ldexp(test_random(&seed) - 0.5, -(int)(test_random(&seed) * 600));
            const planish_quality q = measure_one(dim, x);
            planish_spread spread[N_SPREADS];
            list(&q, spread);
            valid += q.n_inverted == 0;
            if (q.n_inverted != 0)
                continue;
            for (int m = 0; m < 4; m++)
                assert_true(spread[m].mean >= (m == 1 ? 0.81 : 1 - 1e-10));
            for (int m = 4; m < 6; m++)
                assert_true(spread[m].mean >= 0 && spread[m].mean <= 1 + 1e-10);
            assert_true(q.smallest_angle_deg.mean >= 0 && q.largest_angle_deg.mean <= 180);
            assert_true(q.smallest_angle_deg.mean <= q.largest_angle_deg.mean);
        }
    assert_true(valid > 15000);
}

/* ---- Threads, scale, place ------------------------------------------------------------------ */

static void assert_same_bits(const planish_quality *p, const planish_quality *q) {
    planish_spread a[N_SPREADS], b[N_SPREADS];
    list(p, a);
    list(q, b);
    assert_memory_equal(a, b, sizeof a);
}

static void threads_do_not_change_the_bits(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        test_mesh_box(&box, dim, dim == 3 ? 15 : 90);
        test_mesh_perturb(&box, 0.14, 5);
        test_mesh_reverse_some(&box, 50, 1);
        const planish_quality q = measure(&box.mesh, 1);
        for (int threads = 2; threads <= 5; threads++) {
            const planish_quality p = measure(&box.mesh, threads);
            assert_same_bits(&p, &q);
        }
        test_mesh_destroy(&box);
    }
}

static void powers_of_two_keep_the_bits(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        test_mesh_box(&box, dim, 5);
        test_mesh_perturb(&box, 0.14, 6);
        const planish_quality q = measure(&box.mesh, 1);
        for (int exponent = -40; exponent <= 40; exponent += 8) {
            test_mesh scaled;
            test_mesh_create(&scaled, dim, box.mesh.n_nodes, box.coordinates, box.mesh.n_elements,
                             box.elements);
            test_mesh_transform(&scaled, ldexp(1, exponent), 0);
            const planish_quality p = measure(&scaled.mesh, 1);
            assert_same_bits(&p, &q);
            test_mesh_destroy(&scaled);
        }
        test_mesh_destroy(&box);
    }
}

/** At the ends of what a double holds, where all elements are looked at one by one. */
static void any_scale_is_measured(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        test_mesh_box(&box, dim, 4);
        test_mesh_perturb(&box, 0.14, 6);
        const planish_quality q = measure(&box.mesh, 1);
        planish_spread here[N_SPREADS], there[N_SPREADS];
        list(&q, here);
        for (int exponent = -960; exponent <= 1020; exponent += 90) {
            test_mesh scaled;
            test_mesh_create(&scaled, dim, box.mesh.n_nodes, box.coordinates, box.mesh.n_elements,
                             box.elements);
            test_mesh_transform(&scaled, ldexp(1, exponent), 0);
            const planish_quality p = measure(&scaled.mesh, 1);
            list(&p, there);
            for (int m = 0; m < N_SPREADS; m++) {
                assert_near(there[m].min, here[m].min, 1e-13);
                assert_near(there[m].mean, here[m].mean, 1e-13);
                assert_near(there[m].max, here[m].max, 1e-13);
            }
            test_mesh_destroy(&scaled);
        }
        test_mesh_destroy(&box);
    }
}

/** On a grid of 2^-30, moved by 2^20. */
static void translation_keeps_the_bits(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        test_mesh_box(&box, dim, 5);
        test_mesh_perturb(&box, 0.14, 8);
        for (int64_t i = 0; i < box.mesh.n_nodes * dim; i++)
            box.coordinates[i] = rint(box.coordinates[i] * 0x1p30) * 0x1p-30;
        const planish_quality q = measure(&box.mesh, 1);
        test_mesh_transform(&box, 1, 0x1p20);
        const planish_quality p = measure(&box.mesh, 1);
        assert_same_bits(&p, &q);
        test_mesh_destroy(&box);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spreads_are_those_of_the_textbook),
        cmocka_unit_test(spreads_agree_with_the_other_figures),
        cmocka_unit_test(nothing_is_over_no_valid_element),
        cmocka_unit_test(nearly_flat_elements_are_right),
        cmocka_unit_test(short_edges_are_right),
        cmocka_unit_test(whatever_is_valid_has_measures),
        cmocka_unit_test(threads_do_not_change_the_bits),
        cmocka_unit_test(powers_of_two_keep_the_bits),
        cmocka_unit_test(any_scale_is_measured),
        cmocka_unit_test(translation_keeps_the_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
