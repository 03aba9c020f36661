/* Elmer's meshes: folders of text files. */
#include "support/file_builder.h"
#include "support/files.h"
#include "support/unit_elements.h"

#include "io/file/file.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static void put_bytes(void **state, const char *name, const char *text, size_t size) {
    char path[TEST_PATH_SIZE];
    unlink(
        test_path(path, *state, name)); /* the system may wait for the disk where it is emptied */
    test_write(*state, name, text, size);
}

static void put(void **state, const char *name, const char *text) {
    put_bytes(state, name, text, strlen(text));
}

static planish_file *open_folder(void **state, int threads) {
    planish_file *file = NULL;
    planish_error error;
    if (planish_file_open(*state, NULL, threads, &file, &error))
        fail_msg("%s", error.text);
    return file;
}

/* Two tetrahedra of bodies 7 and 8 on the triangle 2 3 5, and a hexahedron that a bubble makes none. */
static const char header[] = "5 2 3\n3\n504 2\n303 2\n101 1\n";
static const char nodes[] = "1 -1 0 0 0\n2 -1 1.0 0 0\n3 -1 0 1 0\n5 -1 0 0 1\n9 -1 1 1 1.5\n";
static const char elements[] = "1 7 504 1 2 3 5\n2 8 504 2 3 5 9\n";
static const char boundary[] = "1 4 1 0 303 1 2 3\n2 7 1 2 303 2 3 5\n3 4 0 0 101 9\n";
static const char names[] = "! ----- names for bodies -----\n$ left = 7\n$ right = 8\n$ none = 9\n"
                            "! ----- names for boundaries -----\n$ below = 4\n$ between = 7\n";

static void put_all(void **state) {
    put(state, "mesh.header", header);
    put(state, "mesh.nodes", nodes);
    put(state, "mesh.elements", elements);
    put(state, "mesh.boundary", boundary);
    put(state, "mesh.names", names);
}

/* ---- reading -------------------------------------------------------------------------------- */

static void bodies_are_regions_and_boundaries_groups(void **state) {
    char tag[32];
    planish_file_info info;
    put_all(state);
    for (int threads = 1; threads < 3; threads++) {
        planish_file *file = open_folder(state, threads);
        planish_file_get_info(file, &info);
        assert_string_equal(info.format, "elmer");
        assert_int_equal(info.n_regions, 2);
        assert_int_equal(info.n_lower_elements, 3);
        assert_int_equal(info.precision, PLANISH_PRECISION_DOUBLE);
        const planish_mesh mesh = planish_file_mesh(file);
        static const int32_t expected[] = {0, 1, 2, 3, 1, 2, 3, 4};
        assert_int_equal(mesh.n_elements, 2);
        assert_memory_equal(mesh.elements, expected, sizeof expected);
        assert_int_equal(planish_file_node_number(file, 4), 9);
        assert_int_equal(planish_file_element_number(file, 1), 2);
        planish_file_element_region(file, 1, tag, sizeof tag);
        assert_string_equal(tag, "right");
        unit_expect_held(file, NULL, "11111");
        assert_int_equal(file->model.hold[4], IO_HELD_BY_POINT);
        assert_int_equal(file->model.hold[3], IO_HELD_BY_FACE);
        planish_file_close(file);
    }
    put(state, "mesh.header", "5 2 0\n1\n504 2\n");
    put(state, "mesh.boundary", "");
    planish_file *file = open_folder(state, 1);
    unit_expect_held(file, NULL, "00000");
    unit_expect_held(file, "left", "11110");
    unit_expect_held(file, "3:8", "01111");
    planish_file_close(file);
}

static void groups_have_names(void **state) {
    put_all(state);
    put(state, "mesh.boundary", "1 4 1 0 303 1 2 3\n2 7 2 0 303 2 3 9\n3 4 0 0 202 2 3\n");
    planish_file *file = open_folder(state, 1);
    unit_expect_held(file, NULL, "11101");
    unit_expect_held(file, "right", "11111");
    const char *none = "none";
    planish_error error;
    uint8_t constraint[5];
    const planish_hold hold = {.tags = &none, .n_tags = 1};
    assert_int_equal(planish_file_constraints(file, &hold, constraint, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "left, right, below, between"));
    planish_file_close(file);
}

static void two_bricks(void **state) {
    for (int dim = 2; dim <= 3; dim++) {
        file_builder b = {0};
        const int n = dim == 3 ? UNIT_BRICK_NODES : 6;
        for (int i = 0; i < n; i++)
            builder_text(&b, "%d -1 %g %g %g\n", i + 1, unit_brick_places[i][0],
                         unit_brick_places[i][1], unit_brick_places[i][2]);
        test_write(*state, "mesh.nodes", b.data, (size_t)b.size);
        builder_release(&b);
        put(state, "mesh.header", dim == 3 ? "12 2 1\n" : "6 2 1\n");
        put(state, "mesh.elements",
            dim == 3 ? "1 7 808 1 2 5 4 7 8 11 10\n2 8 808 2 3 6 5 8 9 12 11\n"
                     : "1/1 7 404 1 2 5 4\n2/1 8 404 2 3 6 5\n");
        put(state, "mesh.boundary", dim == 3 ? "3 5 1 0 404 1 2 5 4\n" : "3/1 5 1 0 202 1 2\n");
        put(state, "mesh.names", "$ bottom = 5\n$ right = 8\n");
        planish_file *file = open_folder(state, 1);
        unit_expect_bricks(file, "bottom", "right");
        planish_file_close(file);
    }
}

/** Write times elements of a type, each with nodes of its own or (shared) all with the same. */
static void put_elements(void **state, const unit_element *element, int times, int shared) {
    double x[UNIT_NODES][3];
    const int n = unit_places(element->type, element->nodes, x);
    file_builder places = {0}, list = {0}, head = {0};
    builder_text(&head, "%d %d 0\n", (shared ? 1 : times) * n, times);
    for (int i = 0; i < times; i++) {
        builder_text(&list, "%d 1 %d", 10 + i, element->code);
        for (int k = 0; k < n; k++) {
            if (i == 0 || !shared)
                builder_text(&places, "%d -1 %.17g %.17g %.17g\n", i * n + k + 1, x[k][0], x[k][1],
                             unit_dim(element->type) == 3 ? x[k][2] : 0);
            builder_text(&list, " %d", (shared ? 0 : i * n) + k + 1);
        }
        builder_text(&list, "\n");
    }
    test_write(*state, "mesh.header", head.data, (size_t)head.size);
    test_write(*state, "mesh.nodes", places.data, (size_t)places.size);
    test_write(*state, "mesh.elements", list.data, (size_t)list.size);
    put(state, "mesh.boundary", "");
    unlink("mesh.names");
    builder_release(&head);
    builder_release(&places);
    builder_release(&list);
}

/* Of elements.def of ElmerSolver, by the corners that each node is between. */
static const unit_element types[] = {
    {PLANISH_CELL_TRIANGLE, 303, "0 1 2"},
    {PLANISH_CELL_TRIANGLE6, 306, "0 1 2 01 12 20"},
    {PLANISH_CELL_QUADRILATERAL, 404, "0 1 2 3"},
    {PLANISH_CELL_QUADRILATERAL8, 408, "0 1 2 3 01 12 23 30"},
    {PLANISH_CELL_QUADRILATERAL9, 409, "0 1 2 3 01 12 23 30 0123"},
    {PLANISH_CELL_TETRAHEDRON, 504, "0 1 2 3"},
    {PLANISH_CELL_TETRAHEDRON10, 510, "0 1 2 3 01 12 20 03 13 23"},
    {PLANISH_CELL_PYRAMID, 605, "0 1 2 3 4"},
    {PLANISH_CELL_PYRAMID13, 613, "0 1 2 3 4 01 12 23 30 04 14 24 34"},
    {PLANISH_CELL_WEDGE, 706, "0 1 2 3 4 5"},
    {PLANISH_CELL_WEDGE15, 715, "0 1 2 3 4 5 01 12 20 34 45 53 03 14 25"},
    {PLANISH_CELL_HEXAHEDRON, 808, "0 1 2 3 4 5 6 7"},
    {PLANISH_CELL_HEXAHEDRON20, 820, "0 1 2 3 4 5 6 7 01 12 23 30 04 15 26 37 45 56 67 74"},
    {PLANISH_CELL_HEXAHEDRON27, 827,
     "0 1 2 3 4 5 6 7 01 12 23 30 04 15 26 37 45 56 67 74 0154 1265 2376 3047 0123 4567 01234567"},
};

static void all_types_are_in_order(void **state) {
    for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
        put_elements(state, &types[i], 2, 0);
        planish_file *file = open_folder(state, 1);
        for (int k = 0; k < 2; k++)
            unit_expect(file, k, types[i].type);
        unit_expect_valid(file, 2);
        assert_int_equal(planish_file_element_number(file, 1), 11);
        planish_file_close(file);
    }
}

static void threads_read_the_same(void **state) {
    enum { N = 45000 }; /* more than a megabyte of numbers */
    const unit_element *const chosen[] = {&types[6], &types[12]};
    for (int i = 0; i < 2; i++) {
        put_elements(state, chosen[i], N, 1);
        planish_file *on[2];
        for (int k = 0; k < 2; k++)
            on[k] = open_folder(state, 1 + k);
        const planish_mesh a = planish_file_mesh(on[0]), b = planish_file_mesh(on[1]);
        assert_int_equal(a.n_elements, N);
        assert_int_equal(b.n_elements, N);
        assert_memory_equal(a.cells->node, b.cells->node,
                            (size_t)a.cells->offset[N] * sizeof *a.cells->node);
        assert_memory_equal(a.coordinates, b.coordinates, 3 * (size_t)a.n_nodes * sizeof(double));
        for (int k = 0; k < 2; k++)
            planish_file_close(on[k]);
    }
}

/** Elements of types that are not smoothed hold their nodes. */
static void other_types_hold_nodes(void **state) {
    put_all(state);
    put(state, "mesh.header", "5 2 1\n");
    put(state, "mesh.elements", "1 7 504 1 2 3 5\n2 7 204 2 3 5 9\n");
    put(state, "mesh.boundary", "1 7 0 0 304 1 2 3 5\n");
    planish_file *file = open_folder(state, 1);
    assert_int_equal(file->model.n_other, 1);
    for (int i = 0; i < 5; i++)
        assert_int_equal(file->model.hold[i], IO_HELD_BY_OTHER);
    planish_file_close(file);
}

static void bad_files_are_refused(void **state) {
    static const struct {
        const char *name, *text, *about, *word;
    } cases[] = {
        {"mesh.header", "5 2\n", "mesh.header:1", "numbers of nodes"},
        {"mesh.header", "5 -2 0\n", "mesh.header:1", "numbers of nodes"},
        {"mesh.header", "", "mesh.header", "empty"},
        {"mesh.header", "4611686018427387904 2 3\n", "mesh.nodes", "4611686018427387904 nodes"},
        {"mesh.header", "5 4611686018427387904 3\n", "mesh.elements",
         "4611686018427387904 element"},
        {"mesh.header", "5 2 4611686018427387904\n", "mesh.boundary",
         "4611686018427387904 boundary"},
        {"mesh.header", "6 2 3\n", "mesh.nodes:6", "node 6"},
        {"mesh.header", "4 2 3\n", "mesh.nodes:5", "more follows"},
        {"mesh.header", "5 1 3\n", "mesh.elements:2", "more follows"},
        {"mesh.header", "5 3 3\n", "mesh.elements:3", "element 3"},
        {"mesh.nodes", "1 -1 0 0 0\n2 -1 1 0 0\n3 -1 0 1 0\n5 -1 0 0 1\n9 -1 1 1 nan\n",
         "mesh.nodes:5", "finite"},
        {"mesh.nodes", "1 -1 0 0 0\n2 -1 1 0 0\n3 -1 0 1 0\n5 -1 0 0 1\n9 -1 1 1\n", "mesh.nodes:6",
         "coordinate expected"},
        {"mesh.nodes", "1 -1 0 0 0\n2 -1 1 0 0\n3 -1 0 1 0\n5 -1 0 0 1\n5 -1 1 1 1\n", "mesh.nodes",
         "occurs twice"},
        {"mesh.elements", "1 7 504 1 2 3 5\n2 8 504 2 3 5 4\n", "mesh.elements:2", "no node 4"},
        {"mesh.elements", "1 7 504 1 2 3 5\n2 8 504 2 3 5\n", "mesh.elements:3", "node 4 of 4"},
        {"mesh.elements", "1 7 504 1 2 3 5\n2 8 904 2 3 5 9\n", "mesh.elements:2", "no type 904"},
        {"mesh.elements", "1 7 504 1 2 3 5\n2 8 600 2 3 5 9\n", "mesh.elements:2", "no type 600"},
        {"mesh.elements", "1 7 504 1 2 3 5\n2 8 310 2 3 5 9 1 2 3 5 9 1\n", "mesh.elements:2",
         "third order"},
        {"mesh.elements", "1 7 520 1 2 3 5 1 2 3 5 1 2 3 5 1 2 3 5 1 2 3 5\n2 8 504 2 3 5 9\n",
         "mesh.elements:1", "third order"},
        {"mesh.elements", "1 x 504 1 2 3 5\n2 8 504 2 3 5 9\n", "mesh.elements:1", "whole number"},
        {"mesh.elements", "x 7 504 1 2 3 5\n2 8 504 2 3 5 9\n", "mesh.elements:1",
         "number expected"},
        {"mesh.elements", "1 99999999999 504 1 2 3 5\n2 8 504 2 3 5 9\n", "mesh.elements:1",
         "99999999999"},
        {"mesh.boundary", "1 4 1 0 303 1 2 3\n2 7 1 2 303 2 3 6\n3 4 0 0 101 9\n",
         "mesh.boundary:2", "no node 6"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        planish_file *file = NULL;
        planish_error error;
        put_all(state);
        put(state, cases[i].name, cases[i].text);
        assert_true(planish_file_open(*state, NULL, 1, &file, &error) < 0);
        assert_null(file);
        if (!strstr(error.text, cases[i].about) || !strstr(error.text, cases[i].word))
            fail_msg("case %zu: '%s' is not about %s and '%s'", i, error.text, cases[i].about,
                     cases[i].word);
    }
}

/** Files that are cut short anywhere are an error or a mesh. */
static void every_beginning_is_safe(void **state) {
    static const char *const files[] = {"mesh.header", "mesh.nodes", "mesh.elements",
                                        "mesh.boundary", "mesh.names"};
    static const char *const texts[] = {header, nodes, elements, boundary, names};
    int n_read = 0;
    for (int i = 0; i < 5; i++) {
        put_all(state);
        for (size_t size = 0; size < strlen(texts[i]); size++) {
            planish_file *file = NULL;
            planish_error error;
            put_bytes(state, files[i], texts[i], size);
            const int status = planish_file_open(*state, NULL, 1, &file, &error);
            assert_true(status == PLANISH_OK || error.text[0]);
            n_read += status == PLANISH_OK;
            planish_file_close(file);
        }
    }
    assert_in_range(n_read, strlen(names), strlen(names) + 30);
}

static void what_is_no_mesh_is_refused(void **state) {
    char path[TEST_PATH_SIZE];
    planish_file *file = NULL;
    planish_error error;
    assert_int_equal(planish_file_open(*state, NULL, 1, &file, &error), PLANISH_ERROR_FILE);
    assert_non_null(strstr(error.text, "is a folder without a mesh"));
    put_all(state);
    unlink(test_path(path, *state, "mesh.boundary"));
    assert_int_equal(planish_file_open(*state, NULL, 1, &file, &error), PLANISH_ERROR_FILE);
    assert_non_null(strstr(error.text, "no file mesh.boundary"));
    put_all(state);
    assert_int_equal(planish_file_open(*state, "gmsh", 1, &file, &error), PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "'gmsh' are files"));
    assert_int_equal(planish_file_open(*state, "nothing", 1, &file, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_open(*state, "openfoam", 1, &file, &error), PLANISH_ERROR_FILE);
    assert_int_equal(
        planish_file_open(test_path(path, *state, "mesh.nodes"), NULL, 1, &file, &error),
        PLANISH_ERROR_FORMAT);
    assert_non_null(strstr(error.text, "give the folder"));
    assert_null(file);
}

static void a_number_at_the_end_may_be_cut(void **state) {
    put_all(state);
    test_write(*state, "mesh.nodes", nodes, strlen(nodes) - 1);
    planish_file *file = open_folder(state, 1);
    assert_non_null(strstr(planish_file_unterminated_path(file), "mesh.nodes"));
    planish_file_close(file);
}

/* ---- writing -------------------------------------------------------------------------------- */

static void expect_file(const char *folder, const char *name, const char *expected) {
    char path[TEST_PATH_SIZE];
    char *text = test_read(test_path(path, folder, name), NULL);
    assert_string_equal(text, expected);
    free(text);
}

/** Move a node of the file and write it to path: what planish_file_write returns. */
static int write_moved(const planish_file *file, const char *path, planish_error *error) {
    double x[15];
    const planish_mesh mesh = planish_file_mesh(file);
    memcpy(x, mesh.coordinates, sizeof x);
    x[3] = 0.125; /* of the second node */
    x[14] = -1.0 / 3;
    return planish_file_write(file, path, x, &(planish_write_options){.threads = 1}, error);
}

static const char moved[] = "1 -1 0 0 0\n2 -1 0.125 0 0\n3 -1 0 1 0\n5 -1 0 0 1\n"
                            "9 -1 1 1 -0.3333333333333333\n";

static void a_new_folder_has_all_files_of_the_mesh(void **state) {
    char in[TEST_PATH_SIZE], out[TEST_PATH_SIZE];
    void *folder = (void *)(uintptr_t)test_folder_in(in, *state, "in");
    planish_error error;
    put_all(&folder);
    put(&folder, "mesh.director", "anything");
    put(&folder, "result.vtu", "of the old coordinates");
    planish_file *file = open_folder(&folder, 1);
    test_path(out, *state, "out");
    assert_int_equal(planish_file_can_write(file, out), 1);
    assert_int_equal(planish_file_check_output(file, out, &error), PLANISH_OK);
    if (write_moved(file, out, &error))
        fail_msg("%s", error.text);
    assert_int_equal(test_count_files(out), 6);
    assert_int_equal(test_count_files(*state), 2);
    expect_file(out, "mesh.nodes", moved);
    expect_file(out, "mesh.header", header);
    expect_file(out, "mesh.elements", elements);
    expect_file(out, "mesh.boundary", boundary);
    expect_file(out, "mesh.names", names);
    expect_file(out, "mesh.director", "anything");
    expect_file(in, "mesh.nodes", nodes);
    /* It is there now. */
    assert_int_equal(planish_file_check_output(file, out, &error), PLANISH_ERROR_FILE);
    assert_non_null(strstr(error.text, "exists already"));
    assert_int_equal(write_moved(file, out, &error), PLANISH_ERROR_FILE);
    /* Unchanged, all bytes are the same; a separator at the end is no name. */
    assert_true(strlen(out) + 3 < sizeof out);
    strcat(out, "2/");
    if (planish_file_write(file, out, planish_file_mesh(file).coordinates,
                           &(planish_write_options){.threads = 1}, &error))
        fail_msg("%s", error.text);
    expect_file(out, "mesh.nodes", nodes);
    planish_file_close(file);
}

static void the_input_is_replaced_in_place(void **state) {
    char path[TEST_PATH_SIZE];
    planish_error error;
    put_all(state);
    planish_file *file = open_folder(state, 1);
    assert_int_equal(planish_file_can_write(file, *state), 1);
    if (write_moved(file, *state, &error))
        fail_msg("%s", error.text);
    expect_file(*state, "mesh.nodes", moved);
    assert_int_equal(test_count_files(*state), 5);
    planish_file_close(file);
    /* A partition has coordinates, too. */
    test_folder_in(path, *state, "partitioning.2");
    file = open_folder(state, 1);
    assert_int_equal(planish_file_check_output(file, *state, &error), PLANISH_ERROR_FILE);
    assert_non_null(strstr(error.text, "partitioning.2"));
    assert_int_equal(write_moved(file, *state, &error), PLANISH_ERROR_FILE);
    planish_file_close(file);
}

static void names_of_files_are_no_folders(void **state) {
    static const char *const others[] = {"out.msh", "out.vtu", "out.node", "/dev/null", "-"};
    planish_error error;
    put_all(state);
    planish_file *file = open_folder(state, 1);
    for (int i = 0; i < 5; i++) {
        assert_int_equal(planish_file_can_write(file, others[i]), 0);
        assert_int_equal(planish_file_check_output(file, others[i], &error),
                         PLANISH_ERROR_ARGUMENT);
        assert_int_equal(write_moved(file, others[i], &error), PLANISH_ERROR_ARGUMENT);
    }
    assert_int_equal(planish_file_can_convert(file, "out.vtu"), 1);
    planish_file_close(file);
}

/** The list of temporary paths has folders before what is in them, and is empty at the end. */
static void a_changed_input_leaves_nothing(void **state) {
    char in[TEST_PATH_SIZE], out[TEST_PATH_SIZE], temporary[4096] = "";
    void *folder = (void *)(uintptr_t)test_folder_in(in, *state, "in");
    planish_error error;
    put_all(&folder);
    planish_file *file = open_folder(&folder, 1);
    test_write(in, "mesh.elements", "changed", 7);
    const planish_mesh mesh = planish_file_mesh(file);
    assert_int_equal(
        planish_file_write(file, test_path(out, *state, "out"), mesh.coordinates,
                           &(planish_write_options){.threads = 1,
                                                    .temporary = temporary,
                                                    .temporary_size = sizeof temporary},
                           &error),
        PLANISH_ERROR_FILE);
    assert_non_null(strstr(error.text, "mesh.elements"));
    assert_int_equal(test_count_files(*state), 1);
    assert_int_equal(temporary[0], 0);
    planish_file_close(file);
}

int main(void) {
#define TEST(name) cmocka_unit_test_setup_teardown(name, test_folder_create, test_folder_remove)
    const struct CMUnitTest tests[] = {
        TEST(bodies_are_regions_and_boundaries_groups),
        TEST(groups_have_names),
        TEST(two_bricks),
        TEST(all_types_are_in_order),
        TEST(threads_read_the_same),
        TEST(other_types_hold_nodes),
        TEST(bad_files_are_refused),
        TEST(every_beginning_is_safe),
        TEST(what_is_no_mesh_is_refused),
        TEST(a_number_at_the_end_may_be_cut),
        TEST(a_new_folder_has_all_files_of_the_mesh),
        TEST(the_input_is_replaced_in_place),
        TEST(names_of_files_are_no_folders),
        TEST(a_changed_input_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
