/* Tests of src/topology/validate.c. */
#include "topology/topology.h"

#include "support/meshes.h"

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <string.h>
#include <cmocka.h>

static int validate(const planish_mesh *mesh, int threads, planish_error *error) {
    pl_dense dense;
    const int status = pl_dense_create(mesh, threads, &dense, error);
    if (!status)
        pl_dense_destroy(&dense);
    return status;
}

static void accepts_meshes(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        test_mesh_box(&box, dim, 3);
        assert_int_equal(validate(&box.mesh, 2, NULL), PLANISH_OK);
        test_mesh_destroy(&box);
    }
}

/** Validate mesh and expect this error there. */
static void expect(const planish_mesh *mesh, int code, int64_t element, int64_t node,
                   const char *text) {
    for (int threads = 1; threads <= 5; threads += 2) {
        planish_error error = {0};
        assert_int_equal(validate(mesh, threads, &error), code);
        assert_int_equal(error.code, code);
        assert_int_equal(error.element, element);
        assert_int_equal(error.node, node);
        assert_non_null(strstr(error.text, text));
    }
}

/** Change to a box of one cell that makes it no mesh, and what is said about it. */
typedef struct refusal {
    enum { DIM, NODES, ELEMENTS, NO_ELEMENTS, BOTH_ELEMENTS, NO_COORDINATES, STRIDE, STEP } field;
    int64_t value;
    int code;
    int64_t element, node;
    const char *words;
} refusal;

static const refusal REFUSALS[] = {
    {DIM, 4, PLANISH_ERROR_ARGUMENT, -1, -1, "mesh.dim is 4"},
    {DIM, 1, PLANISH_ERROR_ARGUMENT, -1, -1, "mesh.dim is 1"},
    {NODES, -1, PLANISH_ERROR_ARGUMENT, -1, -1, "n_nodes is -1"},
    {NODES, INT64_C(1) << 31, PLANISH_ERROR_ARGUMENT, -1, -1, "n_nodes is 2147483648"},
    {NODES, 0, PLANISH_ERROR_MESH, 0, 0, "has node 0, but the mesh has no nodes; correct"},
    {NODES, 7, PLANISH_ERROR_MESH, 0, 7, "nodes 0 to 6"},
    {ELEMENTS, INT64_MAX, PLANISH_ERROR_ARGUMENT, -1, -1, "n_elements"},
    {ELEMENTS, -1, PLANISH_ERROR_ARGUMENT, -1, -1, "n_elements is -1"},
    {ELEMENTS, 0, PLANISH_ERROR_MESH, -1, -1, "no elements"},
    {NO_ELEMENTS, 0, PLANISH_ERROR_ARGUMENT, -1, -1, "mesh.elements"},
    {BOTH_ELEMENTS, 0, PLANISH_ERROR_ARGUMENT, -1, -1, "both set"},
    {NO_COORDINATES, 0, PLANISH_ERROR_ARGUMENT, -1, -1, "mesh.coordinates"},
    {STRIDE, -3, PLANISH_ERROR_ARGUMENT, -1, -1, "node_stride is -3"},
    {STRIDE, 2, PLANISH_ERROR_ARGUMENT, -1, -1, "overlap"},
    {STEP, 2, PLANISH_ERROR_ARGUMENT, -1, -1, "component_stride 2"},
};

static void refuses_arguments(void **state) {
    (void)state;
    const int64_t wide[24] = {0};
    test_mesh box;
    test_mesh_box(&box, 3, 1);
    for (size_t i = 0; i < sizeof REFUSALS / sizeof *REFUSALS; i++) {
        const refusal *r = &REFUSALS[i];
        planish_mesh mesh = box.mesh;
        mesh.dim = r->field == DIM ? (int)r->value : mesh.dim;
        mesh.n_nodes = r->field == NODES ? r->value : mesh.n_nodes;
        mesh.n_elements = r->field == ELEMENTS ? r->value : mesh.n_elements;
        mesh.elements = r->field == NO_ELEMENTS ? NULL : mesh.elements;
        mesh.elements64 = r->field == BOTH_ELEMENTS ? wide : NULL;
        mesh.coordinates = r->field == NO_COORDINATES ? NULL : mesh.coordinates;
        mesh.node_stride = r->field == STRIDE ? r->value : 0;
        mesh.component_stride = r->field == STEP ? r->value : 0;
        expect(&mesh, r->code, r->element, r->node, r->words);
    }
    assert_int_equal(validate(NULL, 1, NULL), PLANISH_ERROR_ARGUMENT);
    test_mesh_destroy(&box);
}

/** Several offenders in several chunks: the lowest is named. */
static void names_the_lowest_element(void **state) {
    (void)state;
    test_mesh box;
    test_mesh_box(&box, 3, 20);
    int64_t last = box.mesh.n_elements - 1;
    assert_true(last > 40000);
    box.elements[4 * last + 3] = -7;
    expect(&box.mesh, PLANISH_ERROR_MESH, last, -7, "has node -7");
    box.elements[4 * 30000 + 1] = (int32_t)box.mesh.n_nodes;
    expect(&box.mesh, PLANISH_ERROR_MESH, 30000, box.mesh.n_nodes, "the nodes 0 to 9260");
    expect(&box.mesh, PLANISH_ERROR_MESH, 30000, box.mesh.n_nodes, "are nodes counted from 1?");
    int32_t node = box.elements[4 * 20000];
    box.elements[4 * 20000 + 3] = node;
    expect(&box.mesh, PLANISH_ERROR_MESH, 20000, node, "twice");
    test_mesh_destroy(&box);
}

static void names_the_lowest_node(void **state) {
    (void)state;
    test_mesh box;
    test_mesh_box(&box, 2, 200);
    box.coordinates[2 * 40000] = NAN;
    expect(&box.mesh, PLANISH_ERROR_MESH, -1, 40000, "x = ");
    box.coordinates[2 * 17 + 1] = -INFINITY;
    expect(&box.mesh, PLANISH_ERROR_MESH, -1, 17, "y = -inf");
    test_mesh_destroy(&box);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(accepts_meshes),
        cmocka_unit_test(refuses_arguments),
        cmocka_unit_test(names_the_lowest_element),
        cmocka_unit_test(names_the_lowest_node),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
