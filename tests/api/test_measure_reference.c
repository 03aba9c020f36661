/* planish_measure_cells with planish_mesh.reference: ratios against the shapes there, as plain loops in long
 * double have them; all other measures as without. */
#include "support/cell_meshes.h"
#include "support/faults.h"
#include "support/meshes.h"
#include "support/target_ratio.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- what is measured ------------------------------------------------------------------------- */

typedef long double real;

/** AR of an element, with nodes node, at x against the reference. */
static real ratio_of(int type, const int32_t *node, const double *x, const double *reference) {
    return sqrtl(target_square_of(type, node, x, reference, 0));
}

static void assert_near(double value, real wanted) {
    if (!(fabsl(value - wanted) <= 1e-12L * wanted))
        fail_msg("%.17g instead of %.17g", value, (double)wanted);
}

/* ---- calls ------------------------------------------------------------------------------------ */

static double *copy_of(const planish_mesh *mesh) {
    const size_t size = (size_t)(mesh->n_nodes * mesh->dim) * sizeof(double);
    double *x = malloc(size);
    assert_non_null(x);
    memcpy(x, mesh->coordinates, size);
    return x;
}

static planish_cell_quality measure(const planish_mesh *mesh, int threads,
                                    const planish_cell_values *values) {
    planish_cell_quality quality;
    planish_error error;
    if (planish_measure_cells(mesh, 0, threads, &quality, values, &error))
        fail_msg("%s", error.text);
    return quality;
}

/** Check the ratios of a valid mesh of cells against plain loops. */
static void check_ratios(const planish_mesh *mesh, const planish_cells *cells, const double *x,
                         const double *reference) {
    double *ratio = malloc((size_t)cells->n * sizeof *ratio);
    const planish_cell_values values = {.aspect_ratio = ratio};
    const planish_cell_quality q = measure(mesh, 1, &values);
    real squares = 0, sum = 0, largest = 0;
    for (int64_t i = 0; i < cells->n; i++) {
        const real wanted = ratio_of(cells->type[i], cells->node + cells->offset[i], x, reference);
        assert_near(ratio[i], wanted);
        squares += wanted * wanted;
        sum += wanted;
        largest = fmaxl(largest, wanted);
    }
    assert_near(q.all.rms_aspect_ratio, sqrtl(squares / cells->n));
    assert_near(q.all.mean_aspect_ratio, sum / cells->n);
    assert_near(q.all.max_aspect_ratio, largest);
    free(ratio);
}

/* ---- tests ------------------------------------------------------------------------------------ */

/* A box against itself, however it is moved, turned or scaled there. */
static void an_element_that_is_its_target_has_ratio_1(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++) {
        cell_box *box = cell_box_create((cell_box_kind)kind, 4);
        cell_box_shake(box, 0.1, 3);
        double *reference = copy_of(&box->mesh);
        planish_mesh mesh = box->mesh;
        mesh.reference = reference;
        for (int64_t i = 0; i < mesh.n_nodes; i++) { /* by a right angle, about the last axis */
            double *at = reference + i * mesh.dim;
            const double x = at[0];
            at[0] = -1e5 * at[1] + 3;
            at[1] = 1e5 * x;
            if (mesh.dim == 3)
                at[2] *= 1e5;
        }
        const planish_cell_quality q = measure(&mesh, 1, NULL);
        assert_true(fabs(q.all.max_aspect_ratio - 1) < 1e-9);
        assert_true(fabs(q.all.rms_aspect_ratio - 1) < 1e-9);
        free(reference);
        cell_box_destroy(box);
    }
}

static void ratios_are_those_of_plain_loops(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++) {
        cell_box *box = cell_box_create((cell_box_kind)kind, 4);
        cell_box_shake(box, 0.1, 3);
        double *reference = copy_of(&box->mesh);
        cell_box_shake(box, 0.08, 5);
        planish_mesh mesh = box->mesh;
        mesh.reference = reference;
        check_ratios(&mesh, &box->cells, box->x, reference);
        free(reference);
        cell_box_destroy(box);
    }
}

/* Simplices given as such, with coordinates one after another and by components. */
static void simplices_have_ratios_too(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        test_mesh_box(&box, dim, 4);
        test_mesh_perturb(&box, 0.1, 3);
        const int64_t n = box.mesh.n_nodes, m = box.mesh.n_elements;
        double *reference = copy_of(&box.mesh);
        test_mesh_perturb(&box, 0.05, 5);
        uint8_t *type = malloc((size_t)m);
        int64_t *offset = malloc((size_t)(m + 1) * sizeof *offset);
        memset(type, dim == 3 ? PLANISH_CELL_TETRAHEDRON : PLANISH_CELL_TRIANGLE, (size_t)m);
        for (int64_t i = 0; i <= m; i++)
            offset[i] = i * (dim + 1);
        const planish_cells cells = {m, type, offset, box.elements, {NULL}};
        planish_mesh mesh = box.mesh;
        mesh.reference = reference;
        check_ratios(&mesh, &cells, box.coordinates, reference);
        double *by_component = malloc((size_t)(2 * n * dim) * sizeof *by_component);
        for (int64_t i = 0; i < n; i++)
            for (int d = 0; d < dim; d++) {
                by_component[d * n + i] = box.coordinates[i * dim + d];
                by_component[(dim + d) * n + i] = reference[i * dim + d];
            }
        mesh.coordinates = by_component;
        mesh.reference = by_component + n * dim;
        mesh.node_stride = 1;
        mesh.component_stride = n;
        check_ratios(&mesh, &cells, box.coordinates, reference);
        free(by_component);
        free(offset);
        free(type);
        free(reference);
        test_mesh_destroy(&box);
    }
}

/* An element so flat that its sign takes exact arithmetic; and targets as thin as a boundary layer's. */
static void flat_elements_are_measured(void **state) {
    double flat[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0.25, 0.25, 0x1p-60};
    double thin[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0.25, 0.25, 0x1p-20};
    double high[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0.25, 0.5, 1};
    const double *const pairs[][2] = {{flat, high}, {thin, high}, {high, thin}, {thin, thin}};
    const int32_t node[] = {0, 1, 2, 3};
    planish_mesh mesh = {.dim = 3, .n_nodes = 4, .n_elements = 1, .elements = node};
    double ratio;
    const planish_cell_values values = {.aspect_ratio = &ratio};
    (void)state;
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
        mesh.coordinates = pairs[i][0];
        mesh.reference = pairs[i][1];
        measure(&mesh, 1, &values);
        const real wanted = ratio_of(PLANISH_CELL_TETRAHEDRON, node, pairs[i][0], pairs[i][1]);
        assert_true(fabsl(ratio - wanted) <= 1e-8L * wanted);
    }
}

/* All measures but AR are those without a reference, and the same on any number of threads. */
static void other_measures_stay(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++) {
        cell_box *box = cell_box_create((cell_box_kind)kind, 6);
        double *reference = copy_of(&box->mesh);
        cell_box_shake(box, 0.8, 5);
        const size_t n = (size_t)box->cells.n;
        double *room = malloc(6 * n * sizeof *room);
        uint8_t *flags = malloc(2 * n);
        planish_mesh mesh = box->mesh;
        planish_cell_values values = {
            .state = flags, .scaled_jacobian = room, .edge_ratio = room + n};
        const planish_cell_quality plain = measure(&mesh, 1, &values);
        mesh.reference = reference;
        values = (planish_cell_values){.state = flags + n,
                                       .scaled_jacobian = room + 2 * n,
                                       .edge_ratio = room + 3 * n,
                                       .aspect_ratio = room + 4 * n};
        planish_cell_quality q = measure(&mesh, 1, &values);
        assert_memory_equal(flags, flags + n, n);
        assert_memory_equal(room, room + 2 * n, 2 * n * sizeof *room);
        assert_true(plain.all.n_inverted > 0);
        assert_int_equal(q.all.n_inverted, plain.all.n_inverted);
        assert_int_equal(q.all.n_inverted_corners, plain.all.n_inverted_corners);
        assert_true(q.all.max_edge_ratio == plain.all.max_edge_ratio);
        values.aspect_ratio = room + 5 * n;
        const planish_cell_quality by_threads = measure(&mesh, 3, &values);
        assert_memory_equal(&q, &by_threads, sizeof q);
        assert_memory_equal(room + 4 * n, room + 5 * n, n * sizeof *room);
        free(flags);
        free(room);
        free(reference);
        cell_box_destroy(box);
    }
}

/* An element of order 2 has the AR of its corners. */
static void mids_have_no_part_in_ratios(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++) {
        cell_box *box = cell_box_create((cell_box_kind)kind, 3);
        cell_box *raised = cell_box_raise(box, 0);
        double *reference = copy_of(&raised->mesh);
        planish_mesh mesh = raised->mesh;
        const double *low = box->x;
        for (int64_t i = 0; i < box->mesh.n_nodes * mesh.dim; i++)
            assert_true(low[i] == raised->x[i]); /* corners come first */
        for (int64_t i = 0; i < mesh.n_nodes; i++) {
            reference[i * mesh.dim] *= 3;
            reference[i * mesh.dim + 1] += 0.25 * raised->x[i * mesh.dim];
        }
        mesh.reference = reference;
        const planish_cell_quality q = measure(&mesh, 1, NULL);
        mesh = box->mesh;
        mesh.reference = reference;
        const planish_cell_quality of_corners = measure(&mesh, 1, NULL);
        assert_near(q.all.rms_aspect_ratio, of_corners.all.rms_aspect_ratio);
        assert_true(q.all.rms_aspect_ratio > 1.1);
        free(reference);
        cell_box_destroy(raised);
        cell_box_destroy(box);
    }
}

/** Measure, which must be refused because of an element. */
static void expect_refused(const planish_mesh *mesh, int64_t element, const char *text) {
    planish_cell_quality quality;
    planish_error error;
    memset(&quality, 0x5a, sizeof quality);
    const planish_cell_quality before = quality;
    for (int threads = 1; threads <= 3; threads += 2) {
        assert_int_equal(planish_measure_cells(mesh, 0, threads, &quality, NULL, &error),
                         PLANISH_ERROR_MESH);
        assert_int_equal(error.element, element);
        if (!strstr(error.text, text))
            fail_msg("'%s' is not in '%s'", text, error.text);
        assert_memory_equal(&quality, &before, sizeof quality);
    }
}

static void elements_without_a_shape_are_refused(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++) {
        cell_box *box = cell_box_create((cell_box_kind)kind, 4);
        const int dim = box->mesh.dim;
        const int64_t n = box->cells.n, size = box->mesh.n_nodes * dim, some = n / 2;
        double *reference = copy_of(&box->mesh);
        const int32_t *node = box->cells.node + box->cells.offset[some];
        planish_mesh mesh = box->mesh;
        mesh.reference = reference;
        for (int64_t i = 0; i < size; i++)
            reference[i] = i % dim == 0 ? 0 : reference[i];
        expect_refused(&mesh, 0, "element 0 is flat in mesh.reference");
        for (int64_t i = 0; i < size; i++)
            reference[i] = i % dim == 0 ? -box->x[i] : box->x[i];
        expect_refused(&mesh, 0, "element 0 is inverted in mesh.reference");
        for (int is_small = 0; is_small < 2; is_small++) {
            for (int64_t i = 0; i < size; i++)
                reference[i] = box->x[i] * (is_small ? 1e-200 : 1e200);
            expect_refused(&mesh, 0,
                           is_small ? "element 0 is too small" : "element 0 is too large");
        }
        memcpy(reference, box->x, (size_t)size * sizeof *reference);
        reference[(int64_t)node[0] * dim] = NAN;
        int64_t lowest = some;
        for (int64_t i = n - 1; i >= 0; i--)
            for (int64_t k = box->cells.offset[i]; k < box->cells.offset[i + 1]; k++)
                lowest = box->cells.node[k] == node[0] ? i : lowest;
        expect_refused(&mesh, lowest, "is too large, or not finite, in mesh.reference");
        free(reference);
        cell_box_destroy(box);
    }
}

static void measure_with_faults(const void *world, faults *f) {
    const planish_mesh *mesh = world;
    planish_cell_quality q;
    planish_error error;
    int status;
    do {
        faults_mark(&q, sizeof q);
        status = planish_measure_cells(mesh, 0, 1, &q, NULL, &error);
        assert_true(!status || faults_is_marked(&q, sizeof q));
    } while (faults_refused(f, status, &error));
    faults_add(f, &q, sizeof q);
}

static void failed_allocations_are_refused(void **state) {
    test_mesh box;
    (void)state;
    test_mesh_box(&box, 3, 2);
    const int64_t n = box.mesh.n_nodes;
    double *by_component = malloc((size_t)(3 * n) * sizeof *by_component);
    for (int64_t i = 0; i < 3 * n; i++)
        by_component[i % 3 * n + i / 3] = box.coordinates[i];
    planish_mesh mesh = box.mesh;
    mesh.coordinates = mesh.reference = by_component;
    mesh.node_stride = 1;
    mesh.component_stride = n;
    assert_true(faults_try("planish_measure_cells", measure_with_faults, &mesh, 30) > 0);
    free(by_component);
    test_mesh_destroy(&box);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_element_that_is_its_target_has_ratio_1),
        cmocka_unit_test(ratios_are_those_of_plain_loops),
        cmocka_unit_test(simplices_have_ratios_too),
        cmocka_unit_test(flat_elements_are_measured),
        cmocka_unit_test(other_measures_stay),
        cmocka_unit_test(mids_have_no_part_in_ratios),
        cmocka_unit_test(elements_without_a_shape_are_refused),
        cmocka_unit_test(failed_allocations_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
