/* Tests of src/quality/measure.c: known meshes, a naive evaluation in long double, and the promises
 * about threads, scale and validity. */
#include "base/parallel.h"
#include "quality/measure.h"
#include "quality/certificate.h"

#include "support/allocations.h"
#include "support/meshes.h"

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

/* ---- Meshes and calls ----------------------------------------------------------------------- */

/** A mesh with what measuring wants besides. */
typedef struct measured_mesh {
    test_mesh box;
    uint8_t *is_free; /* [n_nodes] */
} measured_mesh;

static void fill_is_free(measured_mesh *m, uint8_t value) {
    m->is_free = malloc((size_t)m->box.mesh.n_nodes + 1);
    assert_non_null(m->is_free);
    memset(m->is_free, value, (size_t)m->box.mesh.n_nodes);
}

/** A perturbed box; its nodes with a coordinate 0 are fixed, so a few elements are. */
static void create_box(measured_mesh *m, int dim, int cells) {
    test_mesh_box(&m->box, dim, cells);
    fill_is_free(m, 1);
    for (int64_t i = 0; i < m->box.mesh.n_nodes; i++)
        for (int d = 0; d < dim; d++)
            if (m->box.coordinates[i * dim + d] <= 1)
                m->is_free[i] = 0;
    test_mesh_perturb(&m->box, 0.12, 4);
}

static void create_one(measured_mesh *m, int dim, const double *coordinates) {
    static const int32_t element[] = {0, 1, 2, 3};
    test_mesh_create(&m->box, dim, dim + 1, coordinates, 1, element);
    fill_is_free(m, 1);
}

static void destroy(measured_mesh *m) {
    test_mesh_destroy(&m->box);
    free(m->is_free);
}

static pl_view view_of(const planish_mesh *mesh, const int8_t *sign, const uint8_t *is_free) {
    return (pl_view){.dim = mesh->dim,
                     .n_nodes = mesh->n_nodes,
                     .n_elements = mesh->n_elements,
                     .elements = mesh->elements,
                     .sign = sign,
                     .mobility = is_free};
}

static planish_quality measure(const measured_mesh *m, const int8_t *sign, int threads) {
    const planish_mesh *mesh = &m->box.mesh;
    planish_quality q;
    memset(&q, 0, sizeof q);
    const pl_view view = view_of(mesh, sign, m->is_free);
    assert_int_equal(pl_measure(&view, mesh->coordinates, pl_thread_count(threads), &q, NULL),
                     PLANISH_OK);
    return q;
}

static pl_ratio_sums sum(const measured_mesh *m, const int8_t *sign, int threads) {
    const planish_mesh *mesh = &m->box.mesh;
    pl_ratio_sums s;
    memset(&s, 0, sizeof s);
    const pl_view view = view_of(mesh, sign, m->is_free);
    pl_sum_radius_ratio(&view, mesh->coordinates, pl_thread_count(threads), &s);
    return s;
}

static int near(double a, double b, double tolerance) {
    return fabs(a - b) <= tolerance * fabs(b);
}

static int64_t histogram_total(const planish_quality *q) {
    int64_t total = 0;
    for (int i = 0; i < PLANISH_HISTOGRAM_BINS; i++)
        total += q->histogram_counts[i];
    return total;
}

static int64_t angles_total(const planish_quality *q) {
    int64_t total = 0;
    for (int i = 0; i < PLANISH_ANGLE_BINS; i++)
        total += q->angle_counts[i];
    return total;
}

/** The sums say of the mesh what its quality says. */
static void assert_agreement(const planish_quality *q, const pl_ratio_sums *s) {
    int64_t n = s->n_movable + s->n_fixed;
    assert_int_equal(s->inverted, q->n_inverted);
    assert_int_equal(n + s->inverted, q->n_elements);
    assert_int_equal(histogram_total(q), n);
    assert_int_equal(angles_total(q), n);
    double rms = n ? sqrt((s->movable + s->fixed) / (double)n) : 0;
    double movable = s->n_movable ? sqrt(s->movable / (double)s->n_movable) : 0;
    double fixed = s->n_fixed ? sqrt(s->fixed / (double)s->n_fixed) : 0;
    assert_true(q->rms_radius_ratio == rms);
    assert_true(q->rms_radius_ratio_movable == movable);
    assert_true(q->fixed_rms_radius_ratio == fixed);
    const double max = q->max_radius_ratio_movable, angle = q->min_angle_deg_movable;
    if (s->max < INFINITY)
        assert_true(near(max * max, s->max, 1e-13));
    if (s->n_movable > 0 && angle > 1e-3)
        assert_true(near(asin(1 / sqrt(s->acuteness)) * 57.295779513082320877, angle, 1e-6));
    assert_true(fmax(max, q->fixed_max_radius_ratio) == q->max_radius_ratio);
    assert_true(s->n_movable == 0 || angle >= q->min_angle_deg);
}

/* ---- A naive evaluation --------------------------------------------------------------------- */

static long double distance(const double *a, const double *b, int dim) {
    long double square = 0;
    for (int d = 0; d < dim; d++)
        square += ((long double)a[d] - b[d]) * ((long double)a[d] - b[d]);
    return sqrtl(square);
}

/** Heron. */
static long double area(const double *a, const double *b, const double *c, int dim) {
    long double x = distance(a, b, dim), y = distance(b, c, dim), z = distance(c, a, dim);
    long double s = (x + y + z) / 2;
    return sqrtl(s * (s - x) * (s - y) * (s - z));
}

static long double volume(const double *const v[4]) {
    long double e[3][3];
    for (int j = 0; j < 3; j++)
        for (int d = 0; d < 3; d++)
            e[j][d] = (long double)v[j + 1][d] - v[0][d];
    return (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
            e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
            e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) /
           6;
}

/** R by Crelle's formula or as the product of the edges over 4 A. */
static long double radius_ratio(const double *const v[4], int dim) {
    if (dim == 2) {
        long double a = distance(v[0], v[1], 2), b = distance(v[1], v[2], 2);
        long double c = distance(v[2], v[0], 2), s = area(v[0], v[1], v[2], 2);
        return a * b * c / (4 * s) * (a + b + c) / (4 * s);
    }
    long double a = distance(v[0], v[1], 3) * distance(v[2], v[3], 3);
    long double b = distance(v[0], v[2], 3) * distance(v[1], v[3], 3);
    long double c = distance(v[0], v[3], 3) * distance(v[1], v[2], 3);
    long double s = (a + b + c) / 2, vol = fabsl(volume(v));
    long double surface = area(v[0], v[1], v[2], 3) + area(v[0], v[1], v[3], 3) +
                          area(v[0], v[2], v[3], 3) + area(v[1], v[2], v[3], 3);
    long double circumradius = sqrtl(s * (s - a) * (s - b) * (s - c)) / (6 * vol);
    return circumradius / (3 * (3 * vol / surface));
}

static void agrees_with_a_naive_evaluation(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        measured_mesh m;
        create_box(&m, dim, 9);
        const planish_mesh *mesh = &m.box.mesh;
        long double square[2] = {0}, total = 0, measure_sum = 0, worst = 0, worst_fixed = 0;
        int64_t count[2] = {0}, worst_element = -1;
        int64_t bins[PLANISH_HISTOGRAM_BINS] = {0};
        planish_quality q = measure(&m, NULL, 1);
        for (int64_t e = 0; e < mesh->n_elements; e++) {
            const double *v[4];
            int is_free = 0;
            for (int j = 0; j <= dim; j++) {
                int32_t node = mesh->elements[e * (dim + 1) + j];
                v[j] = mesh->coordinates + (int64_t)node * dim;
                is_free |= m.is_free[node];
            }
            long double ratio = radius_ratio(v, dim);
            square[is_free] += ratio * ratio;
            count[is_free]++;
            total += ratio;
            measure_sum += dim == 3 ? volume(v) : area(v[0], v[1], v[2], 2);
            worst_element = ratio > worst ? e : worst_element;
            worst = ratio > worst ? ratio : worst;
            worst_fixed = !is_free && ratio > worst_fixed ? ratio : worst_fixed;
            int bin = 0;
            while (ratio >= q.histogram_edges[bin + 1])
                bin++;
            bins[bin]++;
        }
        long double n = (long double)mesh->n_elements;
        assert_int_equal(q.n_inverted, 0);
        assert_int_equal(q.n_fixed_elements, count[0]);
        assert_true(count[0] > 0 && count[1] > 0);
        assert_true(near(q.rms_radius_ratio, (double)sqrtl((square[0] + square[1]) / n), 1e-13));
        assert_true(near(q.rms_radius_ratio_movable,
                         (double)sqrtl(square[1] / (long double)count[1]), 1e-13));
        assert_true(near(q.fixed_rms_radius_ratio, (double)sqrtl(square[0] / (long double)count[0]),
                         1e-13));
        assert_true(near(q.mean_radius_ratio, (double)(total / n), 1e-13));
        assert_true(near(q.max_radius_ratio, (double)worst, 1e-13));
        assert_true(near(q.fixed_max_radius_ratio, (double)worst_fixed, 1e-13));
        assert_int_equal(q.worst_element, worst_element);
        assert_true(near(q.total_volume, (double)measure_sum, 1e-13));
        assert_memory_equal(q.histogram_counts, bins, sizeof bins);
        destroy(&m);
    }
}

/* ---- Known meshes --------------------------------------------------------------------------- */

static void knows_a_regular_tetrahedron(void **state) {
    (void)state;
    static const double x[] = {1, 1, 1, -1, 1, -1, 1, -1, -1, -1, -1, 1};
    measured_mesh m;
    create_one(&m, 3, x);
    planish_quality q = measure(&m, NULL, 1);
    assert_int_equal(q.n_inverted, 0);
    assert_true(near(q.rms_radius_ratio, 1, 1e-15) && near(q.max_radius_ratio, 1, 1e-15));
    assert_true(near(q.mean_radius_ratio, 1, 1e-15));
    assert_true(near(q.min_volume, 8.0 / 3, 1e-15) && q.max_volume == q.min_volume);
    assert_true(near(q.min_angle_deg, 70.528779365509308, 1e-14));
    assert_true(near(q.max_angle_deg, 70.528779365509308, 1e-14));
    assert_int_equal(q.worst_element, 0);
    assert_int_equal(q.histogram_counts[0], 1);
    assert_int_equal(q.angle_counts[PLANISH_ANGLE_BINS - 1], 1);
    assert_true(q.angle_edges_deg[PLANISH_ANGLE_BINS - 1] == 70);
    assert_int_equal(q.n_fixed_elements, 0);
    destroy(&m);
}

/** Cubes in 6: all tetrahedra congruent, dihedral angles 45, 60 and 90 degrees; squares in 2. */
static void knows_the_box(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        measured_mesh m;
        test_mesh_box(&m.box, dim, 4);
        fill_is_free(&m, 0);
        planish_quality q = measure(&m, NULL, 1);
        int64_t n = m.box.mesh.n_elements;
        double size = dim == 3 ? 1.0 / 6 : 0.5;
        assert_int_equal(q.n_inverted, 0);
        assert_int_equal(q.n_fixed_elements, n);
        assert_true(near(q.min_volume, size, 1e-15) && near(q.max_volume, size, 1e-15));
        assert_true(near(q.total_volume, dim == 3 ? 64 : 16, 1e-14));
        assert_true(near(q.min_angle_deg, 45, 1e-14) && near(q.max_angle_deg, 90, 1e-14));
        assert_true(q.rms_radius_ratio_movable == 0);
        assert_true(near(q.fixed_rms_radius_ratio, q.max_radius_ratio, 1e-14));
        assert_true(q.fixed_max_radius_ratio == q.max_radius_ratio);
        destroy(&m);
    }
}

/** Angles of 45 degrees but for rounding, on both sides: all are in the bin that begins there. */
static void angles_on_an_edge_are_above_it(void **state) {
    (void)state;
    enum { AT_45 = 9 };
    for (int dim = 2; dim <= 3; dim++) {
        measured_mesh m;
        test_mesh_box(&m.box, dim, 6);
        test_mesh_transform(&m.box, 1.0 / 3, 0.1);
        fill_is_free(&m, 1);
        planish_quality q = measure(&m, NULL, 1);
        assert_true(q.min_angle_deg < 45 && q.smallest_angle_deg.max > 45);
        assert_true(q.angle_edges_deg[AT_45] == 45);
        assert_int_equal(q.angle_counts[AT_45], q.n_elements);
        destroy(&m);
    }
}

static void knows_nothing_of_an_empty_mesh(void **state) {
    (void)state;
    measured_mesh m;
    memset(&m, 0, sizeof m);
    m.box.mesh.dim = 3;
    planish_quality q = measure(&m, NULL, 2);
    pl_ratio_sums s = sum(&m, NULL, 2);
    assert_agreement(&q, &s);
    assert_true(q.rms_radius_ratio == 0 && q.min_volume == 0 && q.max_angle_deg == 0);
    assert_int_equal(q.worst_element, -1);
}

/* ---- Validity ------------------------------------------------------------------------------- */

/** Reversed elements are inverted unless their sign says otherwise. */
static void counts_inverted_elements(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        measured_mesh m;
        create_box(&m, dim, 7);
        planish_quality straight = measure(&m, NULL, 1);
        int64_t n = m.box.mesh.n_elements;
        int8_t *sign = malloc((size_t)n);
        assert_non_null(sign);
        for (int64_t e = 0; e < n; e++) {
            sign[e] = e % 5 == 1 ? -1 : 1;
            if (sign[e] < 0)
                test_mesh_reverse(&m.box, e);
        }
        planish_quality q = measure(&m, NULL, 1);
        pl_ratio_sums s = sum(&m, NULL, 1);
        assert_int_equal(q.n_inverted, (n + 3) / 5);
        assert_int_equal(q.n_fixed_elements, straight.n_fixed_elements);
        assert_true(q.min_volume < 0);
        assert_agreement(&q, &s);
        q = measure(&m, sign, 1);
        s = sum(&m, sign, 1);
        assert_int_equal(q.n_inverted, 0);
        assert_true(near(q.rms_radius_ratio, straight.rms_radius_ratio, 1e-14));
        assert_true(near(q.total_volume, straight.total_volume, 1e-14));
        assert_agreement(&q, &s);
        free(sign);
        destroy(&m);
    }
}

/** An element that is flat, or one unit in the last place from it, far from the origin. */
static void validity_is_exact(void **state) {
    (void)state;
    static const double flat[] = {1e6, 1e6,     1e6, 1e6 + 1,    1e6,       1e6,
                                  1e6, 1e6 + 1, 1e6, 1e6 + 0.25, 1e6 + 0.5, 1e6};
    measured_mesh m;
    create_one(&m, 3, flat);
    double *z = &m.box.coordinates[11];
    planish_quality q = measure(&m, NULL, 1);
    assert_int_equal(q.n_inverted, 1);
    assert_true(q.max_volume == 0 && q.max_radius_ratio == 0 && q.worst_element == -1);
    *z = nextafter(1e6, 0);
    q = measure(&m, NULL, 1);
    assert_int_equal(q.n_inverted, 1);
    assert_true(q.max_volume < 0);
    *z = nextafter(1e6, INFINITY);
    q = measure(&m, NULL, 1);
    pl_ratio_sums s = sum(&m, NULL, 1);
    assert_int_equal(q.n_inverted, 0);
    assert_true(near(q.min_volume, 0x1p-33 / 6, 1e-15));
    const double *x = m.box.coordinates;
    const double *const vertex[4] = {x, x + 3, x + 6, x + 9};
    assert_true(near(q.max_radius_ratio, (double)radius_ratio(vertex, 3), 1e-12));
    assert_agreement(&q, &s);
    destroy(&m);
}

/** Elements within rounding of flat: those that the certificate calls positive are valid. */
static void nearly_flat_elements_are_certified(void **state) {
    (void)state;
    measured_mesh m;
    unsigned seed = 11;
    create_box(&m, 3, 6);
    for (int64_t i = 0; i < m.box.mesh.n_nodes; i++) {
        double *x = m.box.coordinates + 3 * i;
        x[2] = (x[0] + x[1]) / 3 + 1e-16 * test_random(&seed);
    }
    int64_t inverted = 0, n = m.box.mesh.n_elements;
    for (int64_t e = 0; e < n; e++) {
        const double *v[4];
        for (int j = 0; j < 4; j++)
            v[j] = m.box.coordinates + 3 * m.box.elements[4 * e + j];
        inverted += pl_measure_sign(3, v) <= 0;
    }
    planish_quality q = measure(&m, NULL, 1);
    pl_ratio_sums s = sum(&m, NULL, 1);
    assert_int_equal(q.n_inverted, inverted);
    assert_true(inverted > n / 10 && inverted < n - n / 10);
    assert_true(q.rms_radius_ratio > 1e3 && q.rms_radius_ratio < INFINITY);
    assert_agreement(&q, &s);
    destroy(&m);
}

static void not_finite_is_inverted(void **state) {
    (void)state;
    measured_mesh m;
    create_box(&m, 3, 3);
    m.box.coordinates[3 * 21 + 1] = NAN;
    m.box.coordinates[3 * 42 + 1] = INFINITY;
    planish_quality q = measure(&m, NULL, 1);
    pl_ratio_sums s = sum(&m, NULL, 1);
    assert_true(q.n_inverted > 0 && q.n_inverted < q.n_elements);
    assert_true(q.rms_radius_ratio < 3 && q.max_angle_deg < 180);
    assert_agreement(&q, &s);
    destroy(&m);
}

/* ---- Ties, threads, scale, memory ----------------------------------------------------------- */

/** Worst twice, far apart and in several lanes: the first is named. */
static void the_first_of_the_worst_is_named(void **state) {
    (void)state;
    enum { CELLS = 12, WORST = 4099 };
    measured_mesh m;
    test_mesh_box(&m.box, 3, CELLS);
    fill_is_free(&m, 1);
    static const double needle[] = {0, 0, 0, 9, 0, 0, 0, 1, 0, 0, 0, 1};
    static const int32_t element[] = {0, 1, 2, 3};
    int64_t n = m.box.mesh.n_nodes;
    test_mesh other;
    test_mesh_create(&other, 3, 4, needle, 1, element);
    test_mesh_append(&m.box, &other, 0);
    test_mesh_destroy(&other);
    free(m.is_free);
    fill_is_free(&m, 1);
    for (int64_t e = WORST; e < m.box.mesh.n_elements; e += 1003)
        for (int j = 0; j < 4; j++)
            m.box.elements[4 * e + j] = (int32_t)(n + j);
    for (int threads = 1; threads <= 3; threads++)
        assert_int_equal(measure(&m, NULL, threads).worst_element, WORST);
    destroy(&m);
}

static void threads_do_not_change_the_bits(void **state) {
    (void)state;
    static const int counts[] = {2, 3, 7};
    for (int dim = 2; dim <= 3; dim++) {
        measured_mesh m;
        create_box(&m, dim, dim == 3 ? 17 : 101);
        test_mesh_reverse_some(&m.box, 50, 1);
        planish_quality q = measure(&m, NULL, 1);
        pl_ratio_sums s = sum(&m, NULL, 1);
        assert_agreement(&q, &s);
        for (int k = 0; k < 3; k++) {
            planish_quality other_q = measure(&m, NULL, counts[k]);
            pl_ratio_sums other_s = sum(&m, NULL, counts[k]);
            assert_memory_equal(&q, &other_q, sizeof q);
            assert_memory_equal(&s, &other_s, sizeof s);
        }
        destroy(&m);
    }
}

/** A scaled mesh has the same ratios, up to the ends of what its volumes allow and beyond. */
static void any_scale_is_measured(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        measured_mesh m;
        create_box(&m, dim, 4);
        planish_quality q = measure(&m, NULL, 1);
        for (int exponent = -980; exponent <= 1020; exponent += 100) {
            measured_mesh scaled;
            create_box(&scaled, dim, 4);
            test_mesh_transform(&scaled.box, ldexp(1, exponent), 0);
            planish_quality p = measure(&scaled, NULL, 1);
            pl_ratio_sums s = sum(&scaled, NULL, 1);
            assert_int_equal(p.n_inverted, 0);
            assert_true(near(p.rms_radius_ratio, q.rms_radius_ratio, 1e-14));
            assert_true(near(p.max_radius_ratio, q.max_radius_ratio, 1e-14));
            assert_true(near(p.min_angle_deg, q.min_angle_deg, 1e-13));
            assert_true(p.min_volume == ldexp(q.min_volume, dim * exponent));
            assert_true(p.total_volume == ldexp(q.total_volume, dim * exponent));
            assert_agreement(&p, &s);
            destroy(&scaled);
        }
        destroy(&m);
    }
}

/** A ratio that a double holds is reported even if its square is too large. */
static void extreme_ratios_are_measured(void **state) {
    (void)state;
    const double height = 1e-90; /* RR is nearly R / (3 r), r height / 2, R 1 / (6 height) */
    const double x[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0.3, 0.3, height};
    measured_mesh m;
    create_one(&m, 3, x);
    planish_quality q = measure(&m, NULL, 1);
    assert_int_equal(q.n_inverted, 0);
    assert_true(q.max_radius_ratio > 1e178 && q.max_radius_ratio < 1e182);
    assert_true(isinf(q.rms_radius_ratio));
    assert_int_equal(q.histogram_counts[PLANISH_HISTOGRAM_BINS - 1], 1);
    assert_int_equal(q.angle_counts[0], 1);
    assert_true(near(q.min_volume, height / 6, 1e-15));
    destroy(&m);
}

static void no_memory_is_an_error(void **state) {
    (void)state;
    measured_mesh m;
    create_box(&m, 3, 2);
    const planish_mesh *mesh = &m.box.mesh;
    planish_quality q = {.n_elements = -7};
    planish_error error;
    allocations_permit(0);
    const pl_view view = view_of(mesh, NULL, m.is_free);
    int status = pl_measure(&view, mesh->coordinates, 1, &q, &error);
    allocations_permit(-1);
    assert_int_equal(status, PLANISH_ERROR_MEMORY);
    assert_int_equal(error.code, PLANISH_ERROR_MEMORY);
    assert_int_equal(q.n_elements, -7);
    destroy(&m);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(agrees_with_a_naive_evaluation),
        cmocka_unit_test(knows_a_regular_tetrahedron),
        cmocka_unit_test(knows_the_box),
        cmocka_unit_test(angles_on_an_edge_are_above_it),
        cmocka_unit_test(knows_nothing_of_an_empty_mesh),
        cmocka_unit_test(counts_inverted_elements),
        cmocka_unit_test(validity_is_exact),
        cmocka_unit_test(nearly_flat_elements_are_certified),
        cmocka_unit_test(not_finite_is_inverted),
        cmocka_unit_test(the_first_of_the_worst_is_named),
        cmocka_unit_test(threads_do_not_change_the_bits),
        cmocka_unit_test(any_scale_is_measured),
        cmocka_unit_test(extreme_ratios_are_measured),
        cmocka_unit_test(no_memory_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
