/* planish_mesh.metric: elements that are to be regular where lengths depend on the direction. What a metric
 * does to a mesh is what none does to the mesh's image under its root. */
#include "support/cell_meshes.h"
#include "support/effort.h"
#include "support/run.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- meshes ----------------------------------------------------------------------------------- */

enum { MOST = 6 }; /* numbers of a metric */

/** A box of side cubes, and a metric. */
typedef struct metric_box {
    cell_box *box;
    planish_mesh mesh;
    double *start;  /* [n_nodes][dim] */
    double *metric; /* [n_nodes][dim (dim + 1) / 2] */
} metric_box;

static int count_of(int dim) {
    return dim * (dim + 1) / 2;
}

static metric_box metric_box_of(cell_box_kind kind, int side, double shake) {
    cell_box *box = cell_box_create(kind, side);
    metric_box m = {.box = box};
    cell_box_shake(box, shake, 3);
    m.mesh = box->mesh;
    m.start = test_copy_of(&box->mesh);
    m.metric = calloc((size_t)m.mesh.n_nodes * MOST, sizeof *m.metric);
    assert_non_null(m.metric);
    m.mesh.metric = m.metric;
    return m;
}

static void forget(metric_box *m) {
    cell_box_destroy(m->box);
    free(m->start);
    free(m->metric);
}

/* The root of a metric, and the metric. */
static const double ROOT[3][3] = {{1.2, 0.3, -0.1}, {0, 0.9, 0.2}, {0.1, 0, 1.1}};

/** Give all nodes the metric B^T B of the first rows and columns B of ROOT. */
static void put_constant(metric_box *m) {
    const int dim = m->mesh.dim;
    for (int64_t i = 0; i < m->mesh.n_nodes; i++)
        for (int c = 0, k = 0; c < dim; c++)
            for (int r = 0; r <= c; r++, k++)
                for (int d = 0; d < dim; d++)
                    m->metric[i * count_of(dim) + k] += ROOT[d][r] * ROOT[d][c];
}

/** Give nodes thin elements around a circle, whose thickness is a tenth of their length at most. */
static void put_circle(metric_box *m, double side) {
    const int dim = m->mesh.dim;
    for (int64_t i = 0; i < m->mesh.n_nodes; i++) {
        const double *at = m->start + i * dim;
        const double x = at[0] / side - 0.5, y = at[1] / side - 0.5, r = hypot(x, y) + 1e-3;
        const double size = fmin(1, 0.1 + 2 * fabs(r - 0.25)), more = 1 / (size * size) - 1;
        double *of = m->metric + i * count_of(dim);
        of[0] = 1 + more * x * x / (r * r);
        of[1] = more * x * y / (r * r);
        of[2] = 1 + more * y * y / (r * r);
        if (dim == 3)
            of[5] = 1;
    }
}

/** Move the nodes of x [n][dim] by ROOT, or back. */
static void map(int dim, int64_t n, double *x) {
    for (int64_t i = 0; i < n; i++) {
        double y[3] = {0};
        for (int r = 0; r < dim; r++)
            for (int c = 0; c < dim; c++)
                y[r] += ROOT[r][c] * x[i * dim + c];
        memcpy(x + i * dim, y, (size_t)dim * sizeof *y);
    }
}

/* ---- tests ------------------------------------------------------------------------------------ */

/** Ratios of cells before anything has moved, and after, are those of the image; weight: of sizes. */
static void image_has_the_same(cell_box_kind kind, double shake, double weight) {
    metric_box m = metric_box_of(kind, 4, shake);
    planish_options options = test_options(1);
    planish_error error;
    planish_cell_quality q, of_image;
    const int dim = m.mesh.dim;
    double *image = test_copy_of(&m.mesh), *size = malloc((size_t)m.mesh.n_nodes * sizeof *size);
    assert_non_null(size);
    put_constant(&m);
    map(dim, m.mesh.n_nodes, image);
    planish_mesh other = m.box->mesh;
    other.coordinates = image;
    for (int64_t i = 0; i < m.mesh.n_nodes; i++)
        size[i] = 1;
    other.size = weight > 0 ? size : NULL;
    options.size_weight = weight;
    options.tolerance = 1e-9;
    options.max_sweeps = 2000;
    assert_int_equal(planish_measure_cells(&m.mesh, 0, 1, &q, NULL, &error), 0);
    assert_int_equal(planish_measure_cells(&other, 0, 1, &of_image, NULL, &error), 0);
    assert_int_equal(q.all.n_inverted, of_image.all.n_inverted);
    assert_true(q.all.n_inverted > 0 ||
                fabs(q.all.rms_aspect_ratio - of_image.all.rms_aspect_ratio) < 1e-12);
    assert_true(fabs(q.all.max_aspect_ratio - of_image.all.max_aspect_ratio) <
                1e-9 * of_image.all.max_aspect_ratio);
    const planish_result a = test_smooth_in_place(&m.mesh, m.box->x, &options);
    const planish_result b = test_smooth_in_place(&other, image, &options);
    assert_true(shake > 0.3 || fabs(a.objective_before / b.objective_before - 1) < 1e-10);
    assert_true(fabs(a.objective / b.objective - 1) < 1e-4);
    map(dim, m.mesh.n_nodes, m.box->x);
    for (int64_t i = 0; i < dim * m.mesh.n_nodes; i++)
        assert_true(fabs(m.box->x[i] - image[i]) < 2e-3);
    free(image);
    free(size);
    forget(&m);
}

static void a_metric_is_a_map(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind += effort_step(2)) {
        image_has_the_same((cell_box_kind)kind, 0.1, 0);
        image_has_the_same((cell_box_kind)kind, 0.1, 0.5);
    }
}

/** Tangled boxes come out as their images do. */
static void so_it_is_for_tangled_meshes(void **state) {
    (void)state;
    image_has_the_same(BOX_QUADRILATERALS, 0.8, 0);
    image_has_the_same(BOX_HEXAHEDRA, 0.6, 0.5);
}

/** Lengths that do not depend on the direction are sizes. */
static void equal_lengths_are_sizes(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind += effort_step(2)) {
        metric_box m = metric_box_of((cell_box_kind)kind, 5, 0.1);
        planish_options options = test_options(1);
        const int dim = m.mesh.dim;
        planish_mesh other = m.box->mesh;
        planish_size_quality of_metric, of_size;
        planish_error error;
        double *x = test_copy_of(&m.mesh), *size = malloc((size_t)m.mesh.n_nodes * sizeof *size);
        assert_non_null(size);
        for (int64_t i = 0; i < m.mesh.n_nodes; i++) {
            size[i] = 0.3 + 0.1 * m.start[i * dim];
            for (int d = 0, k = 0; d < dim; k += ++d + 1)
                m.metric[i * count_of(dim) + k] = 1 / (size[i] * size[i]);
        }
        other.size = size;
        other.coordinates = x;
        options.size_weight = 0.7;
        assert_int_equal(planish_measure_sizes(&m.mesh, 1, &of_metric, NULL, &error), 0);
        assert_int_equal(planish_measure_sizes(&other, 1, &of_size, NULL, &error), 0);
        assert_true(fabs(of_metric.rms_log - of_size.rms_log) < 1e-12);
        assert_true(fabs(of_metric.factor / of_size.factor - 1) < 1e-12);
        const planish_result a = test_smooth_in_place(&m.mesh, m.box->x, &options);
        const planish_result b = test_smooth_in_place(&other, x, &options);
        assert_true(fabs(a.objective_before / b.objective_before - 1) < 1e-12);
        assert_true(fabs(a.objective / b.objective - 1) < 1e-6);
        free(x);
        free(size);
        forget(&m);
    }
}

/** Elements of all kinds stay valid, F does not rise, at whatever sweep it ends, and the bits are those of
 *  one thread and any kernel. */
static void what_is_promised_holds(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind += effort_step(2))
        for (int sweeps = 1; sweeps <= 64; sweeps *= 8) {
            metric_box m = metric_box_of((cell_box_kind)kind, 6, 0.1);
            planish_options options = test_options(1);
            planish_cell_quality q;
            planish_error error;
            double *x = test_copy_of(&m.mesh);
            put_circle(&m, 6);
            options.size_weight = 0.5;
            options.max_sweeps = sweeps;
            const planish_result result = test_smooth_in_place(&m.mesh, m.box->x, &options);
            assert_true(result.objective <= result.objective_before * (1 + 1e-12));
            assert_int_equal(planish_measure_cells(&m.mesh, 0, 1, &q, NULL, &error), 0);
            assert_int_equal(q.all.n_inverted, 0);
            for (int way = 0; way < 3; way++) {
                planish_mesh mesh = m.mesh;
                mesh.coordinates = x;
                memcpy(x, m.start, test_bytes_of(&mesh));
                options.threads = way == 0 ? 3 : 1;
                options.isa = way == 1 ? PLANISH_ISA_PLAIN : PLANISH_ISA_VECTOR;
                test_smooth_in_place(&mesh, x, &options);
                assert_memory_equal(x, m.box->x, test_bytes_of(&mesh));
            }
            free(x);
            forget(&m);
        }
}

/** Guards, which have kernels of their own, see metrics, too. */
static void guarded_visits_see_metrics(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind += effort_step(2)) {
        double objective[2];
        for (int way = 0; way < 2; way++) {
            metric_box m = metric_box_of((cell_box_kind)kind, 5, 0.1);
            planish_options options = test_options(1);
            put_constant(&m);
            options.size_weight = 0.3;
            options.tolerance = 1e-9;
            options.max_sweeps = 2000;
            options.min_volume = way ? 1e-9 : 0;
            objective[way] = test_smooth_in_place(&m.mesh, m.box->x, &options).objective;
            forget(&m);
        }
        assert_true(fabs(objective[1] / objective[0] - 1) < 1e-5);
    }
}

static void wrong_metrics_are_refused(void **state) {
    (void)state;
    static const struct {
        double m11, m12;
        const char *text;
    } cases[] = {{0, 0, "the metric of node 5 is not positive definite"},
                 {-1, 0, "the metric of node 5 is not positive definite"},
                 {1, 1, "the metric of node 5 is not positive definite"},
                 {NAN, 0, "the metric of node 5 has an entry that is not finite"},
                 {1, INFINITY, "the metric of node 5 has an entry that is not finite"},
                 {1e26, 0, "vary by more than"},
                 {1e-26, 0, "vary by more than"}};
    metric_box m = metric_box_of(BOX_QUADRILATERALS, 4, 0);
    planish_options options = test_options(1);
    double *size = malloc((size_t)m.mesh.n_nodes * sizeof *size);
    assert_non_null(size);
    for (int64_t i = 0; i < m.mesh.n_nodes; i++)
        m.metric[3 * i] = m.metric[3 * i + 2] = size[i] = 1;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        planish_error error;
        planish_cell_quality q;
        m.metric[15] = cases[k].m11;
        m.metric[16] = cases[k].m12;
        test_expect_refusal(&m.mesh, &options, PLANISH_ERROR_MESH, cases[k].text);
        assert_int_equal(planish_measure_cells(&m.mesh, 0, 1, &q, NULL, &error),
                         PLANISH_ERROR_MESH);
    }
    m.metric[15] = 1;
    m.metric[16] = 0;
    m.mesh.size = size;
    test_expect_refusal(&m.mesh, &options, PLANISH_ERROR_ARGUMENT, "options.size_weight is 0");
    options.size_weight = 0.5;
    test_expect_refusal(&m.mesh, &options, PLANISH_ERROR_ARGUMENT, "are both given");
    m.mesh.size = NULL;
    uint8_t is_layer[16] = {1};
    m.mesh.is_layer = is_layer;
    test_expect_refusal(&m.mesh, &options, PLANISH_ERROR_ARGUMENT,
                        "mesh.metric is not possible with mesh.is_layer");
    free(size);
    forget(&m);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_metric_is_a_map),          cmocka_unit_test(so_it_is_for_tangled_meshes),
        cmocka_unit_test(equal_lengths_are_sizes),    cmocka_unit_test(what_is_promised_holds),
        cmocka_unit_test(guarded_visits_see_metrics), cmocka_unit_test(wrong_metrics_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
