/* What readers build on: numbers of nodes, entities, the mesh that comes of it. */
#include "io/core/model.h"
#include "io/core/records.h"
#include "io/file/file.h"

#include "base/memory.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { N = 1000 };

/** Numbers spread by stride, in a shuffled order, are all found; what is between them is not. */
static void check_numbers(int64_t first, int64_t stride) {
    int64_t numbers[N];
    for (int64_t i = 0; i < N; i++)
        numbers[i] = first + (i * 7919 % N) * stride;
    io_numbers *table = NULL;
    planish_error error;
    assert_int_equal(io_numbers_create("mesh", "node", numbers, N, &table, &error), PLANISH_OK);
    for (int64_t i = 0; i < N; i++) {
        assert_int_equal(io_numbers_find(table, numbers[i]), i);
        if (stride > 1)
            assert_int_equal(io_numbers_find(table, numbers[i] + 1), -1);
    }
    assert_int_equal(io_numbers_find(table, first - 1), -1);
    assert_int_equal(io_numbers_find(table, first + N * stride), -1);
    assert_int_equal(io_numbers_find(table, INT64_MIN), -1);
    assert_int_equal(io_numbers_find(table, INT64_MAX), -1);
    io_numbers_destroy(table);
}

static void numbers_close_together(void **state) {
    (void)state;
    check_numbers(1, 1);
    check_numbers(-500, 3);
}

static void numbers_far_apart(void **state) {
    (void)state;
    check_numbers(1, 1000003);
    check_numbers(-4000000000000000000, 8000000000000000);
}

static void numbers_at_the_limits(void **state) {
    (void)state;
    static const int64_t numbers[] = {INT64_MAX, 0, INT64_MIN};
    io_numbers *table = NULL;
    assert_int_equal(io_numbers_create("mesh", "node", numbers, 3, &table, NULL), PLANISH_OK);
    for (int64_t i = 0; i < 3; i++)
        assert_int_equal(io_numbers_find(table, numbers[i]), i);
    assert_int_equal(io_numbers_find(table, 1), -1);
    io_numbers_destroy(table);
    assert_int_equal(io_numbers_create("mesh", "node", numbers, 0, &table, NULL), PLANISH_OK);
    assert_int_equal(io_numbers_find(table, 0), -1);
    io_numbers_destroy(table);
}

static void numbers_that_occur_twice(void **state) {
    (void)state;
    static const int64_t close[] = {4, 2, 17, 2}, far[] = {4, 1000000000000, 17, 1000000000000};
    io_numbers *table = NULL;
    planish_error error;
    assert_int_equal(io_numbers_create("mesh", "node", close, 4, &table, &error),
                     PLANISH_ERROR_FORMAT);
    assert_non_null(strstr(error.text, " 2 "));
    assert_int_equal(io_numbers_create("mesh", "node", far, 4, &table, &error),
                     PLANISH_ERROR_FORMAT);
    assert_non_null(strstr(error.text, "1000000000000"));
}

static void entities_are_told_apart(void **state) {
    (void)state;
    io_model model = {.n_nodes = 0};
    static const int32_t physical[] = {5, 6};
    int32_t first = io_model_entity(&model, 3, 1, 2, physical, NULL);
    assert_int_equal(first, 0);
    assert_int_equal(io_model_entity(&model, 2, 1, 2, physical, NULL), 1);
    assert_int_equal(io_model_entity(&model, 3, 1, 1, physical, NULL), 2);
    assert_int_equal(io_model_entity(&model, 3, 1, 0, NULL, NULL), 3);
    assert_int_equal(io_model_entity(&model, 3, 1, 2, physical, NULL), first);
    for (int32_t i = 0; i < 100000; i++) /* by a search of all of them this would take minutes */
        assert_int_equal(io_model_entity(&model, 0, i, 0, NULL, NULL), 4 + i);
    for (int32_t i = 0; i < 100000; i++)
        assert_int_equal(io_model_entity(&model, 0, i, 0, NULL, NULL), 4 + i);
    io_model_destroy(&model);
}

/** A model of n nodes at (i, i^2, z_i) and one simplex of dimension dim on the first of them. */
static void make_model(io_model *model, int columns, int dim, const double *z) {
    memset(model, 0, sizeof *model);
    model->threads = 1;
    model->columns = columns;
    io_cells *cells = dim == 3 ? &model->tetrahedron : &model->triangle;
    assert_int_equal(io_model_alloc_nodes(model, 4, 1, NULL), PLANISH_OK);
    assert_int_equal(io_cells_reserve(model, dim, 1, 0, 0, NULL), PLANISH_OK);
    for (int i = 0; i < 4; i++) {
        model->xyz[3 * i] = i;
        model->xyz[3 * i + 1] = i * i;
        model->xyz[3 * i + 2] = z[i];
    }
    for (int i = 0; i <= dim; i++)
        cells->nodes[i] = i;
    cells->n = 1;
}

/** Mids of edges come from the format's order, by the corners that the edges are between, and only
 *  edges that have one get one. */
static void mids_are_those_of_the_edges(void **state) {
    (void)state;
    /* Corners 0 and 1 are swapped, and mids stand in the reverse order. */
    static const io_node_order orders[] = {
        {PLANISH_CELL_TETRAHEDRON10, {1, 0, 2, 3, 9, 8, 7, 6, 5, 4}}, {0, {0}}};
    static const int32_t straight[] = {0, 1, 2, 3};
    static const int32_t nodes[] = {20, 21, 22, 23, 4,
                                    5,  6,  -1, 8,  9}; /* of VTK: 21 20 22 23 ... */
    static const int32_t mids[] = {9, -1, 8,
                                   5, 6,  4}; /* 01 12 20 03 13 23, of the cell's corners */
    io_model model = {.node_order = orders};
    const io_cells *cells = &model.tetrahedron;
    assert_int_equal(io_model_add_simplex(&model, PLANISH_CELL_TETRAHEDRON, straight, 0, 1, NULL),
                     0);
    assert_null(cells->mid);
    for (int i = 0; i < 100; i++) { /* beyond what there was room for at first */
        const int type = i % 2 ? PLANISH_CELL_TETRAHEDRON : PLANISH_CELL_TETRAHEDRON10;
        assert_int_equal(io_model_add_simplex(&model, type, nodes, 0, 2, NULL), 0);
    }
    assert_int_equal(cells->n, 101);
    for (int i = 0; i < 101; i++)
        for (int k = 0; k < 6; k++)
            assert_int_equal(cells->mid[6 * i + k], i % 2 ? mids[k] : -1);
    assert_memory_equal(cells->nodes + 4, nodes, 4 * sizeof *nodes);
    static const int32_t triangle[] = {1, 2, 3, 4, 5, 6}, line[] = {1, 2, 3};
    assert_int_equal(io_model_add_simplex(&model, PLANISH_CELL_TRIANGLE6, triangle, 0, 1, NULL), 0);
    assert_int_equal(io_model_add_simplex(&model, PLANISH_CELL_LINE3, line, 0, 1, NULL), 0);
    assert_memory_equal(model.triangle.mid, triangle + 3, 3 * sizeof *triangle); /* VTK's order */
    assert_int_equal(model.line.mid[0], 3);
    /* Corners may stand among mids. */
    static const io_node_order around[] = {{PLANISH_CELL_TRIANGLE6, {0, 2, 4, 1, 3, 5}}, {0, {0}}};
    static const int32_t corners[] = {1, 3, 5}, between[] = {2, 4, 6};
    model.node_order = around;
    assert_int_equal(io_model_add_simplex(&model, PLANISH_CELL_TRIANGLE6, triangle, 0, 2, NULL), 0);
    assert_memory_equal(model.triangle.nodes + 3, corners, sizeof corners);
    assert_memory_equal(model.triangle.mid + 3, between, sizeof between);
    io_model_destroy(&model);
}

static void dimension_is_that_of_the_cells(void **state) {
    (void)state;
    static const double flat[] = {2, 2, 2, 5};
    io_model model;
    make_model(&model, 3, 3, flat);
    assert_int_equal(io_model_finish(&model, NULL, NULL), PLANISH_OK);
    assert_int_equal(model.dim, 3);
    assert_ptr_equal(model.coordinates, model.xyz);
    io_model_destroy(&model);
    make_model(&model, 3, 2, flat); /* the node that is off the plane is none of the triangle's */
    assert_int_equal(io_model_finish(&model, NULL, NULL), PLANISH_OK);
    assert_int_equal(model.dim, 2);
    for (int i = 0; i < 4; i++)
        assert_true(model.coordinates[2 * i] == i && model.coordinates[2 * i + 1] == i * i);
    assert_int_equal(model.hold[0], 0); /* triangles hold in 3-D only */
    io_model_destroy(&model);
}

static void lines_and_triangles_hold(void **state) {
    (void)state;
    static const double z[] = {0, 0, 0, 1};
    io_model model;
    make_model(&model, 3, 3, z);
    assert_int_equal(io_cells_reserve(&model, 2, 1, 0, 0, NULL), PLANISH_OK);
    memcpy(model.triangle.nodes, (int32_t[]){1, 2, 3}, 3 * sizeof(int32_t));
    model.triangle.n = 1;
    assert_int_equal(io_cells_reserve(&model, 1, 1, 0, 0, NULL), PLANISH_OK);
    memcpy(model.line.nodes, (int32_t[]){3, 1}, 2 * sizeof(int32_t));
    model.line.n = 1;
    assert_int_equal(io_model_finish(&model, NULL, NULL), PLANISH_OK);
    assert_int_equal(model.n_lower, 2);
    assert_int_equal(model.hold[0], 0);
    assert_int_equal(model.hold[1], IO_HELD_BY_FACE | IO_HELD_BY_LINE);
    assert_int_equal(model.hold[2], IO_HELD_BY_FACE);
    assert_int_equal(model.hold[3], IO_HELD_BY_FACE | IO_HELD_BY_LINE);
    io_model_destroy(&model);
}

/** Triangles in no plane are a surface in space, with the file's own coordinates. */
static void triangles_may_be_a_surface(void **state) {
    (void)state;
    static const double bent[] = {0, 0, 1, 0};
    io_model model;
    make_model(&model, 3, 2, bent);
    assert_int_equal(io_cells_reserve(&model, 2, 1, 0, 0, NULL), PLANISH_OK);
    memcpy(model.triangle.nodes + 3, (int32_t[]){1, 2, 3}, 3 * sizeof(int32_t));
    model.triangle.n = 2;
    assert_int_equal(io_model_finish(&model, NULL, NULL), PLANISH_OK);
    assert_true(io_model_is_surface(&model));
    assert_int_equal(model.dim, 3);
    assert_int_equal(model.written, 3);
    assert_ptr_equal(model.coordinates, model.xyz);
    io_model_destroy(&model);
}

static void what_cannot_be_smoothed_is_refused(void **state) {
    (void)state;
    static const double flat[] = {0, 0, 0, 0};
    io_model model;
    planish_error error;
    make_model(&model, 2, 3, flat); /* tetrahedra without a third coordinate */
    assert_int_equal(io_model_finish(&model, NULL, &error), PLANISH_ERROR_FORMAT);
    io_model_destroy(&model);
    make_model(&model, 3, 2, flat);
    model.triangle.n = 0;
    assert_int_equal(io_model_finish(&model, NULL, &error), PLANISH_ERROR_FORMAT);
    io_model_destroy(&model);
}

static void counts_beyond_int32_are_refused(void **state) {
    (void)state;
    io_model model = {.n_nodes = 0};
    planish_error error;
    assert_int_equal(io_model_alloc_nodes(&model, (int64_t)INT32_MAX + 1, 0, &error),
                     PLANISH_ERROR_FORMAT);
    assert_int_equal(io_cells_reserve(&model, 2, (int64_t)INT32_MAX + 1, 0, 0, &error),
                     PLANISH_ERROR_FORMAT);
    model.triangle.n = 5;
    assert_int_equal(io_cells_reserve(&model, 2, INT64_MAX - 2, 0, 0, &error),
                     PLANISH_ERROR_FORMAT);
    model.triangle.n = 0;
    io_model_destroy(&model);
}

static void errors_name_the_place(void **state) {
    (void)state;
    static const char text[] = "a\nb\r\nc\rd";
    char path[] = "mesh";
    io_model model = {.input = {.path = path, .data = text, .size = (int64_t)strlen(text)}};
    planish_error error;
    assert_int_equal(io_fail_at(&model, strchr(text, 'd'), &error, "bad %d", 7),
                     PLANISH_ERROR_FORMAT);
    assert_string_equal(error.text, "mesh:4: bad 7");
    io_fail_at(&model, text, &error, "bad");
    assert_string_equal(error.text, "mesh:1: bad");
    assert_int_equal(io_fail_at(&model, text, NULL, "bad"), PLANISH_ERROR_FORMAT);
    model.is_binary = 1;
    io_fail_at(&model, text + 3, &error, "bad");
    assert_string_equal(error.text, "mesh: byte 3: bad");
}

static void counts_are_compared_with_the_bytes(void **state) {
    (void)state;
    static const char text[] = "1 2 3";
    char path[] = "mesh";
    io_model model = {.input = {.path = path, .data = text, .size = (int64_t)strlen(text)}};
    const io_cursor rest = {text, io_input_end(&model)};
    planish_error error;
    assert_int_equal(io_check_count(&model, rest, 3, 2, "nodes", &error), PLANISH_OK);
    assert_int_equal(io_check_count(&model, rest, 4, 2, "nodes", &error), PLANISH_ERROR_FORMAT);
    assert_non_null(strstr(error.text, "mesh:1: 4 nodes cannot be in the 5 bytes"));
    assert_int_equal(io_check_room(&model, rest, -1, 2, "nodes", &error), PLANISH_ERROR_FORMAT);
    assert_int_equal(io_check_room(&model, rest, INT64_MAX, 1, "a", NULL), PLANISH_ERROR_FORMAT);
    model.is_binary = 1;
    assert_int_equal(io_check_count(&model, rest, 3, 2, "nodes", &error), PLANISH_ERROR_FORMAT);
    assert_int_equal(io_check_count(&model, rest, 2, 2, "nodes", &error), PLANISH_OK);
    model.input.size = (int64_t)INT32_MAX + 2;
    const io_cursor all = {text, (const char *)((uintptr_t)text + (uintptr_t)INT32_MAX + 2)};
    assert_int_equal(io_check_room(&model, all, model.input.size, 1, "nodes", &error), PLANISH_OK);
    assert_int_equal(io_check_count(&model, all, model.input.size, 1, "nodes", &error),
                     PLANISH_ERROR_FORMAT);
    assert_non_null(strstr(error.text, "more than planish can number"));
}

static void coordinates_are_finite(void **state) {
    (void)state;
    static const float xyz[] = {1, 2, 3, 4, NAN, 6};
    double room[6];
    char path[] = "mesh";
    const char *data = (const char *)xyz;
    const io_model model = {.input = {.path = path, .data = data, .size = sizeof xyz},
                            .is_binary = 1,
                            .first_number = 7,
                            .xyz = room};
    planish_error error;
    assert_int_equal(io_load_node(&model, data, 4, 0, 0, &error), PLANISH_OK);
    assert_true(room[2] == 3);
    assert_int_equal(io_load_node(&model, data + 12, 4, 0, 1, &error), PLANISH_ERROR_FORMAT);
    assert_string_equal(error.text, "mesh: byte 16: node 8 has a coordinate that is not finite");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_close_together),
        cmocka_unit_test(numbers_far_apart),
        cmocka_unit_test(numbers_at_the_limits),
        cmocka_unit_test(numbers_that_occur_twice),
        cmocka_unit_test(entities_are_told_apart),
        cmocka_unit_test(mids_are_those_of_the_edges),
        cmocka_unit_test(dimension_is_that_of_the_cells),
        cmocka_unit_test(lines_and_triangles_hold),
        cmocka_unit_test(triangles_may_be_a_surface),
        cmocka_unit_test(what_cannot_be_smoothed_is_refused),
        cmocka_unit_test(counts_beyond_int32_are_refused),
        cmocka_unit_test(errors_name_the_place),
        cmocka_unit_test(counts_are_compared_with_the_bytes),
        cmocka_unit_test(coordinates_are_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
