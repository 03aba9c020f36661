/* planish_find_reversed and planish_quality.n_reversed: elements that are numbered the other way
 * round than most, against signs by the textbook's determinant. */
#include "support/both.h"
#include "support/meshes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/** Twice the area, or six times the volume, of an element at x. */
static double determinant(const planish_mesh *mesh, const double *x, int64_t element) {
    const int dim = mesh->dim;
    const int32_t *node = mesh->elements + element * (dim + 1);
    double e[3][3] = {{0}};
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            e[j][d] = x[node[j + 1] * dim + d] - x[node[0] * dim + d];
    if (dim == 2)
        return e[0][0] * e[1][1] - e[0][1] * e[1][0];
    return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
           e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
           e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
}

/** reversed [n_elements], and their number. */
static int64_t expect(const planish_mesh *mesh, const double *x, uint8_t *reversed) {
    int64_t n_positive = 0, n_negative = 0, n = 0;
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        n_positive += determinant(mesh, x, i) > 0;
        n_negative += determinant(mesh, x, i) < 0;
    }
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        const double d = determinant(mesh, x, i);
        reversed[i] = n_positive >= n_negative ? d < 0 : d > 0;
        n += reversed[i];
    }
    return n;
}

/** Compare what the library finds at x with what is expected; returns the number. */
static int64_t check(const planish_mesh *mesh, const double *x) {
    uint8_t *expected = malloc((size_t)mesh->n_elements), *found = malloc((size_t)mesh->n_elements);
    const int64_t n_expected = expect(mesh, x, expected);
    planish_plan *plan;
    planish_quality quality;
    int64_t n = -1;
    assert_int_equal(planish_plan_create(mesh, NULL, &plan, NULL), 0);
    assert_int_equal(planish_find_reversed(plan, x, found, &n, NULL), 0);
    assert_int_equal(n, n_expected);
    assert_memory_equal(found, expected, (size_t)mesh->n_elements);
    n = -1;
    assert_int_equal(planish_find_reversed(plan, x, NULL, &n, NULL), 0);
    assert_int_equal(n, n_expected);
    assert_int_equal(planish_measure(plan, x, &quality, NULL), 0);
    assert_int_equal(quality.n_reversed, n_expected);
    planish_plan_destroy(plan);
    free(expected);
    free(found);
    return n_expected;
}

static void mirror(test_mesh *m) {
    for (int64_t i = 0; i < m->mesh.n_elements; i++)
        test_mesh_reverse(m, i);
}

/** Valid meshes with elements of the other order, mirrored as a whole or not, of any size. */
static void elements_of_the_other_order_are_found(void **state) {
    static const double scales[] = {1, 1e-200, 1e150};
    const int dim = *(int *)*state;
    for (int i = 0; i < 12; i++) {
        test_mesh m;
        test_mesh_box(&m, dim, dim == 3 ? 5 : 12);
        test_mesh_perturb(&m, 0.1, (unsigned)i + 1);
        if (i % 2)
            mirror(&m);
        assert_int_equal(check(&m.mesh, m.coordinates), 0);
        test_mesh_reverse_some(&m, 7, (unsigned)i + 1);
        assert_true(check(&m.mesh, m.coordinates) > 0);
        uint8_t *expected = malloc((size_t)m.mesh.n_elements),
                *found = malloc((size_t)m.mesh.n_elements);
        expect(&m.mesh, m.coordinates, expected);
        test_mesh_transform(&m, scales[i % 3], 0);
        planish_plan *plan;
        assert_int_equal(planish_plan_create(&m.mesh, NULL, &plan, NULL), 0);
        assert_int_equal(planish_find_reversed(plan, m.coordinates, found, NULL, NULL), 0);
        assert_memory_equal(found, expected, (size_t)m.mesh.n_elements);
        planish_plan_destroy(plan);
        free(expected);
        free(found);
        test_mesh_destroy(&m);
    }
}

/** Tangled meshes: signs of measures decide, whatever the plan takes for the orientation. */
static void inverted_elements_count_as_they_are_listed(void **state) {
    const int dim = *(int *)*state;
    int64_t n = 0;
    for (int i = 0; i < 8; i++) {
        test_mesh m;
        test_mesh_box(&m, dim, dim == 3 ? 4 : 9);
        test_mesh_perturb(&m, 1.2, (unsigned)i + 1);
        if (i % 2)
            test_mesh_reverse_some(&m, 3, (unsigned)i + 1);
        n += check(&m.mesh, m.coordinates);
        test_mesh_destroy(&m);
    }
    assert_true(n > 0);
}

/** In a tie most are positive; flat elements are neither. */
static void ties_and_flat_elements(void **state) {
    static const double square[] = {0, 0, 1, 0, 1, 1, 0, 1, 2, 0};
    static const int32_t pair[] = {0, 1, 2, 0, 3, 2}, with_flat[] = {0, 1, 2, 0, 2, 3, 0, 1, 4};
    test_mesh m;
    (void)state;
    test_mesh_create(&m, 2, 4, square, 2, pair);
    assert_int_equal(check(&m.mesh, m.coordinates), 1);
    test_mesh_destroy(&m);
    test_mesh_create(&m, 2, 5, square, 3, with_flat);
    assert_int_equal(check(&m.mesh, m.coordinates), 0);
    test_mesh_destroy(&m);
}

/** Folded elements that were renumbered so that each is positive: repaired, they are reversed. */
static void repaired_elements_are_reversed(void **state) {
    const int dim = *(int *)*state;
    test_mesh m;
    uint8_t *reversed;
    planish_result result;
    planish_plan *plan;
    int64_t n_folded = 0, n = -1;
    test_mesh_box(&m, dim, 4);
    const int64_t middle = dim == 3 ? (5 * 5 + 5 + 1) * 2 : 2 * 5 + 2;
    for (int d = 0; d < dim; d++)
        m.coordinates[middle * dim + d] += d == 0 ? 1.3 : 0.1;
    uint8_t *folded = calloc((size_t)m.mesh.n_elements, 1);
    for (int64_t i = 0; i < m.mesh.n_elements; i++)
        if (determinant(&m.mesh, m.coordinates, i) < 0) {
            test_mesh_reverse(&m, i);
            folded[i] = 1;
            n_folded++;
        }
    assert_true(n_folded > 0);
    assert_int_equal(check(&m.mesh, m.coordinates), 0);
    assert_int_equal(planish_plan_create(&m.mesh, NULL, &plan, NULL), 0);
    assert_int_equal(planish_smooth(plan, m.coordinates, NULL, &result, NULL), 0);
    assert_int_equal(result.n_inverted, 0);
    reversed = malloc((size_t)m.mesh.n_elements);
    assert_int_equal(planish_find_reversed(plan, m.coordinates, reversed, &n, NULL), 0);
    assert_int_equal(n, n_folded);
    assert_memory_equal(reversed, folded, (size_t)m.mesh.n_elements);
    planish_plan_destroy(plan);
    free(reversed);
    free(folded);
    test_mesh_destroy(&m);
}

/** A plan for some elements counts these; a selective one counts all; strides do not matter. */
static void parts_and_strides(void **state) {
    const int dim = *(int *)*state;
    test_mesh m;
    planish_options options;
    planish_plan *plan;
    int64_t n = -1, n_all, n_around = 0;
    test_mesh_box(&m, dim, 6);
    test_mesh_perturb(&m, 0.14, 5);
    test_mesh_reverse_some(&m, 3, 5);
    uint8_t *expected = malloc((size_t)m.mesh.n_elements),
            *found = malloc((size_t)m.mesh.n_elements);
    n_all = expect(&m.mesh, m.coordinates, expected);
    planish_options_init(&options);
    options.only_worse_than = 2;
    assert_int_equal(planish_plan_create(&m.mesh, &options, &plan, NULL), 0);
    assert_int_equal(planish_find_reversed(plan, m.coordinates, found, &n, NULL), 0);
    assert_int_equal(n, n_all);
    assert_memory_equal(found, expected, (size_t)m.mesh.n_elements);
    planish_plan_destroy(plan);

    const int64_t middle = dim == 3 ? (7 * 7 + 7 + 1) * 3 : 3 * 7 + 3;
    planish_options_init(&options);
    options.around = &middle;
    options.n_around = 1;
    assert_int_equal(planish_plan_create(&m.mesh, &options, &plan, NULL), 0);
    assert_int_equal(planish_find_reversed(plan, m.coordinates, found, &n, NULL), 0);
    for (int64_t i = 0; i < m.mesh.n_elements; i++) {
        int has = 0;
        for (int j = 0; j <= dim; j++)
            has |= m.mesh.elements[i * (dim + 1) + j] == middle;
        assert_int_equal(found[i], has && expected[i]);
        n_around += found[i];
    }
    assert_true(n_around > 0);
    assert_int_equal(n, n_around);
    planish_plan_destroy(plan);

    double *apart = malloc((size_t)(m.mesh.n_nodes * dim) * sizeof *apart);
    for (int64_t i = 0; i < m.mesh.n_nodes; i++)
        for (int d = 0; d < dim; d++)
            apart[d * m.mesh.n_nodes + i] = m.coordinates[i * dim + d];
    planish_mesh strided = m.mesh;
    strided.coordinates = apart;
    strided.node_stride = 1;
    strided.component_stride = m.mesh.n_nodes;
    assert_int_equal(planish_plan_create(&strided, NULL, &plan, NULL), 0);
    assert_int_equal(planish_find_reversed(plan, apart, found, &n, NULL), 0);
    assert_int_equal(n, n_all);
    assert_memory_equal(found, expected, (size_t)m.mesh.n_elements);
    planish_plan_destroy(plan);
    free(apart);
    free(expected);
    free(found);
    test_mesh_destroy(&m);
}

static void errors_leave_everything(void **state) {
    test_mesh m;
    planish_plan *plan;
    planish_error error;
    uint8_t found[6] = {7, 7, 7, 7, 7, 7};
    int64_t n = -1;
    (void)state;
    test_mesh_box(&m, 3, 1);
    assert_int_equal(planish_plan_create(&m.mesh, NULL, &plan, NULL), 0);
    assert_int_equal(planish_find_reversed(NULL, m.coordinates, found, &n, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_find_reversed(plan, NULL, found, &n, &error), PLANISH_ERROR_ARGUMENT);
    m.coordinates[4] = (double)NAN;
    assert_int_equal(planish_find_reversed(plan, m.coordinates, found, &n, &error),
                     PLANISH_ERROR_MESH);
    assert_int_equal(n, -1);
    for (int i = 0; i < 6; i++)
        assert_int_equal(found[i], 7);
    planish_plan_destroy(plan);
    test_mesh_destroy(&m);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        BOTH(elements_of_the_other_order_are_found),
        BOTH(inverted_elements_count_as_they_are_listed),
        cmocka_unit_test(ties_and_flat_elements),
        BOTH(repaired_elements_are_reversed),
        BOTH(parts_and_strides),
        cmocka_unit_test(errors_leave_everything),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
