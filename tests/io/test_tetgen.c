/* TetGen and Triangle: files beside one another, numbers from 0 or 1, what markers hold. */
#include "support/file_builder.h"
#include "support/files.h"
#include "support/reading.h"
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

/* Two tetrahedra on the triangle 1 2 3 of five nodes numbered from 0. */
static const char nodes_from_0[] = "# nodes\n5 3 2 1\n0  0 0 0  0.5 9  1\n1  1 0 0  0.5 9  0\n"
                                   "2  0 1 0  0.5 9  0 # here\n\n3  0 0 1  0.5 9  0\n"
                                   "4  1 1 1.5  0.5 9  -3\n# end\n";
static const char elements_from_0[] = "2 4 1\n0  0 1 2 3  7\n1  1 2 3 4  8\n";
static const char nodes_from_1[] = "5 3\r\n1 0 0 0\r\n2 1 0 0\r\n3 0 1 0\r\n4 0 0 1\r\n5 1 1 1.5";
static const char elements_from_1[] = "2 4\r\n1 1 2 3 4\r\n2 2 3 4 5";

static void put(void **state, const char *name, const char *text) {
    test_write(*state, name, text, strlen(text));
}

/** Open a mesh of that folder; it must succeed. */
static planish_file *open_mesh(void **state, const char *name) {
    char path[TEST_PATH_SIZE];
    planish_file *file = NULL;
    planish_error error;
    if (planish_file_open(test_path(path, *state, name), NULL, 1, &file, &error))
        fail_msg("%s", error.text);
    return file;
}

/** Opening must fail with a message that has word in it, and about that file. */
static void open_fails(void **state, const char *name, const char *about, const char *word) {
    char path[TEST_PATH_SIZE];
    planish_file *file = NULL;
    planish_error error;
    assert_true(planish_file_open(test_path(path, *state, name), NULL, 1, &file, &error) < 0);
    assert_null(file);
    if (!strstr(error.text, about) || !strstr(error.text, word))
        fail_msg("'%s' is not about %s and '%s'", error.text, about, word);
}

static void check_two_tetrahedra(const planish_file *file) {
    static const int32_t elements[] = {0, 1, 2, 3, 1, 2, 3, 4};
    planish_mesh mesh = planish_file_mesh(file);
    assert_int_equal(mesh.dim, 3);
    assert_int_equal(mesh.n_nodes, 5);
    assert_int_equal(mesh.n_elements, 2);
    assert_memory_equal(mesh.elements, elements, sizeof elements);
    assert_true(mesh.coordinates[12] == 1 && mesh.coordinates[14] == 1.5);
}

static void either_file_may_be_named(void **state) {
    static const char *const names[] = {"a.node", "a.ele"};
    put(state, "a.node", nodes_from_0);
    put(state, "a.ele", elements_from_0);
    for (int i = 0; i < 2; i++) {
        planish_file *file = open_mesh(state, names[i]);
        planish_file_info info;
        planish_file_get_info(file, &info);
        check_two_tetrahedra(file);
        assert_string_equal(info.format, "tetgen");
        assert_int_equal(info.n_regions, 2);
        assert_int_equal(info.bytes, strlen(nodes_from_0));
        assert_int_equal(planish_file_node_number(file, 4), 4);
        assert_int_equal(planish_file_element_number(file, 1), 1);
        reading_holds(file, NULL, READING_REGIONS, "01110"); /* between the regions */
        reading_holds(file, "3:8", READING_REGIONS, "01111");
        reading_holds(file, "-3", READING_REGIONS, "01111"); /* a node's marker */
        planish_file_close(file);
    }
}

static void numbers_may_begin_with_1(void **state) {
    put(state, "a.node", nodes_from_1);
    put(state, "a.ele", elements_from_1);
    planish_file *file = open_mesh(state, "a.ele");
    check_two_tetrahedra(file);
    assert_int_equal(planish_file_node_number(file, 4), 5);
    assert_int_equal(planish_file_element_number(file, 1), 2);
    reading_holds(file, NULL, READING_REGIONS, "00000");
    planish_file_close(file);
}

static void marked_faces_and_edges_hold(void **state) {
    put(state, "a.node", nodes_from_1);
    put(state, "a.ele", elements_from_1);
    put(state, "a.face",
        "7 1\n1 1 2 3 0\n2 1 2 4 5\n3 2 3 4 0\n4 1 3 4 0\n5 2 3 5 0\n6 2 4 5 0\n7 3 4 5 0\n");
    put(state, "a.edge", "3 1\n1 4 5 -1\n2 3 2 0\n3 3 1 0\n");
    planish_file *file = open_mesh(state, "a.node");
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(info.n_lower_elements, 10);
    reading_holds(file, NULL, READING_REGIONS, "11011");
    reading_holds(file, "2:5", READING_REGIONS, "11011"); /* a known tag */
    planish_file_close(file);
}

/** A file that does not list all faces or edges has those of constraints, of whatever marker. What stands behind
 *  them without markers is none. */
static void constraints_hold_without_markers(void **state) {
    static const struct {
        const char *face, *edge, *held;
    } cases[] = {{"1 1\n1 1 2 3 0\n", "0 1\n", "11100"},
                 {"1 0\n1 1 2 3 4 5\n", "0 1\n", "11100"},
                 {"0 1\n", "2 1\n1 3 2 0\n2 3 1 0\n", "11100"},
                 {"0 1\n", "3 1\n1 3 2 0\n2 3 1 0\n3 4 5 1\n", "00011"}};
    put(state, "a.node", nodes_from_1);
    put(state, "a.ele", elements_from_1);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        put(state, "a.face", cases[i].face);
        put(state, "a.edge", cases[i].edge);
        planish_file *file = open_mesh(state, "a.node");
        reading_holds(file, NULL, READING_REGIONS, cases[i].held);
        for (int64_t k = 0; k < file->model.triangle.n; k++)
            assert_int_equal(file->model.entity[file->model.triangle.entity[k]].tag, 0);
        planish_file_close(file);
    }
}

static void attributes_that_are_no_integers_make_no_regions(void **state) {
    put(state, "a.node", nodes_from_1);
    put(state, "a.ele", "2 4 1\n1 1 2 3 4 0.25\n2 2 3 4 5 1\n");
    planish_file *file = open_mesh(state, "a.node");
    check_two_tetrahedra(file);
    reading_holds(file, NULL, READING_REGIONS, "00000");
    planish_file_close(file);
}

/** Where a line has fewer words than were promised, threads begin in the middle of lines; the
 *  second attributes that they take for the first ones, which make regions, are none. */
static void threads_see_the_same_regions(void **state) {
    enum { N = 80000 };
    char path[TEST_PATH_SIZE];
    file_builder nodes = {.data = NULL}, elements = {.data = NULL};
    builder_text(&nodes, "%d 3\n", N + 3);
    for (int i = 1; i <= N + 3; i++)
        builder_text(&nodes, "%d %d %d %d\n", i, i, i * 7 % 1000, i * 11 % 100);
    builder_text(&elements, "%d 4 2\n1 1 2 3 4 1\n", N);
    for (int i = 2; i <= N; i++)
        builder_text(&elements, "%d %d %d %d %d %d .5\n", i, i, i + 1, i + 2, i + 3, 1 + i % 2);
    test_write(*state, "a.node", nodes.data, (size_t)nodes.size);
    test_write(*state, "a.ele", elements.data, (size_t)elements.size);
    for (int threads = 1; threads <= 8; threads += 7) {
        planish_file *file = NULL;
        planish_error error;
        planish_file_info info;
        if (planish_file_open(test_path(path, *state, "a.node"), NULL, threads, &file, &error))
            fail_msg("%s", error.text);
        planish_file_get_info(file, &info);
        assert_int_equal(info.n_regions, 2);
        planish_file_close(file);
    }
    builder_release(&nodes);
    builder_release(&elements);
}

static void triangles_in_the_plane(void **state) {
    put(state, "a.1.node", "4 2 0 1\n1 0 0 1\n2 1 0 1\n3 1 1 0\n4 0 1 1\n");
    put(state, "a.1.ele", "2 3 0\n1 1 2 3\n2 1 3 4\n");
    put(state, "a.1.edge", "5 1\n1 1 2 1\n2 1 3 0\n3 2 3 0\n4 3 4 0\n5 4 1 0\n");
    planish_file *file = open_mesh(state, "a.1.ele");
    planish_mesh mesh = planish_file_mesh(file);
    static const int32_t elements[] = {0, 1, 2, 0, 2, 3};
    assert_int_equal(mesh.dim, 2);
    assert_memory_equal(mesh.elements, elements, sizeof elements);
    assert_true(mesh.coordinates[2 * 2] == 1 && mesh.coordinates[2 * 2 + 1] == 1);
    reading_holds(file, NULL, READING_REGIONS, "1100");
    planish_file_close(file);
    /* The segments of a .poly without nodes hold theirs, and edges are not read then. */
    put(state, "a.1.poly", "# Triangle's\n0 2 0 1\n2 1\n1  1 3  0\n2  3 4  7\n0\n");
    file = open_mesh(state, "a.1.ele");
    reading_holds(file, NULL, READING_REGIONS, "1011");
    reading_holds(file, "1:7", READING_REGIONS, "1011");
    assert_int_equal(file->model.line.n, 2);
    planish_file_close(file);
    put(state, "a.1.poly", "0 2 0 1\n2 1\n1  1 3  0\n2  3 5  7\n0\n");
    open_fails(state, "a.1.ele", "a.1.poly:4", "segment 2 has node 5");
    put(state, "a.1.poly", "0 2 0 1");
    open_fails(state, "a.1.ele", "a.1.poly", "counts");
    put(state, "a.1.poly", "3 2 0 1\n"); /* has nodes of its own: it is the source */
    file = open_mesh(state, "a.1.ele");
    reading_holds(file, NULL, READING_REGIONS, "1100");
    planish_file_close(file);
}

static void bad_files_are_refused(void **state) {
    static const struct {
        const char *node, *ele;
        const char *about, *word; /* NULL node or ele: as they should be */
    } cases[] = {
        {NULL, "2 10 0\n1 1 2 3 4 1 2 3 4 5 1\n2 1 2 3 4 1 2 3 4 5 6\n", "a.ele:3", "node 6"},
        {NULL, "2 10 0\n1 1 2 3 4 1 2 3 4 5 1\n2 1 2 3 4 1 2 3 4 5\n", "a.ele:3", "a node of"},
        {NULL, "2 20 0\n1 1 2 3 4 1 2 3 4 5 1\n2 1 2 3 4 1 2 3 4 5 1\n", "a.ele:1", "20 nodes"},
        {NULL, "2 5 0\n1 1 2 3 4 5\n2 1 2 3 4 5\n", "a.ele:1", "nodes"},
        {NULL, "2 4 0\n1 1 2 3 4\n2 1 2 3 6\n", "a.ele:3", "node 6"},
        {NULL, "2 4 0\n1 1 2 3 4\n2 1 2 3 0\n", "a.ele:3", "node 0"},
        {NULL, "2 4 0\n1 1 2 3     4\n2 1 2 3\n", "a.ele:3", "node"},
        {NULL, "2 4 0\n1 1 2 3 4\n3 1 2 3 4\n", "a.ele:3", "number 2"},
        {NULL, "2 4 0\n1 1 2 3 4\n# 2 1 2 3 5\n", "a.ele:4", "cut short"},
        {NULL, "4611686018427387904 4 0\n1 1 2 3 4\n", "a.ele:1", "too short"},
        {NULL, "1 4 4611686018427387904\n1 1 2 3 4\n", "a.ele:1", "more than a line can have"},
        {NULL, "-1 4 0\n", "a.ele:1", "count"},
        {NULL, "0 4 0\n", "a.node", "nothing to smooth"},
        {NULL, "1 4 1\n1 1 2 3 4 x\n", "a.ele:2", "attribute (a number) was expected, not 'x'"},
        {"4611686018427387904 3 0 0\n1 0 0 0\n", NULL, "a.node:1", "too short"},
        {"1 3 4611686018427387904 0\n1 0 0 0\n", NULL, "a.node:1", "more than a line can have"},
        {"1 4 0 0\n1 0 0 0 0\n", NULL, "a.node:1", "dimension 4"},
        {"2 3 0 0\n1 0 0 0\n2 0 nan 0\n", NULL, "a.node:3", "finite"},
        {"2 3 0 0\n1 0 0 0\n2 0 1e999 0\n", NULL, "a.node:3", "finite"},
        {"2 3 0 0\n1 0 0\n2 0 0 0\n", NULL, "a.node:2", "coordinate"},
        {"2 3 0 1\n1 0 0 0 99999999999\n2 0 0 0 0\n", NULL, "a.node:2", "marker"},
        {"2 3 0 0\n1 0 0 0\n1 0 0 0\n", NULL, "a.node:3", "number 2"},
        {"2 3 0 1\n1 0 0 0 x\n2 0 0 0 0\n", NULL, "a.node:2", "marker (a whole number)"},
        {"2 3 0 1\n1 0 0 0 1\n2 0 0 0  1.5 6\n", NULL, "a.node:3", "not '1.5'"},
        {"2 3 0 0\n9223372036854775807 0 0 0\n-9223372036854775808 0 0 0\n", NULL, "a.node:2",
         "9223372036854775807 is out of range"},
        {"1 3 9223372036854775807 0\n1 0 0 0\n", NULL, "a.node:1", "more than a line can have"},
        {"hello\n", NULL, "a.node:1", "counts"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        put(state, "a.node", cases[i].node ? cases[i].node : nodes_from_1);
        put(state, "a.ele", cases[i].ele ? cases[i].ele : elements_from_1);
        open_fails(state, "a.node", cases[i].about, cases[i].word);
        open_fails(state, "a.ele", cases[i].about, cases[i].word);
    }
}

/* Files of tetgen -o2: 2 tetrahedra. */
static const char nodes_of_second_order[] =
    "14  3  0  0\n   1    0  0  0\n   2    1  0  0\n   3    0  1  0\n   4    0  0  1\n"
    "   5    1  1  1.3\n   6    0.5  0  0.5\n   7    0.5  0  0\n   8    0  0.5  0\n"
    "   9    0  0.5  0.5\n  10    0.5  0.5  0\n  11    0  0  0.5\n  12    1  0.5  0.65\n"
    "  13    0.5  1  0.65\n  14    0.5  0.5  1.15\n# Generated by tetgen -o2 a.node\n";
static const char elements_of_second_order[] =
    "2  10  0\n    1       1     3     4     2      6     7     8     9    10    11\n"
    "    2       4     3     5     2     12     6     9    13    10    14\n"
    "# Generated by tetgen -o2 a.node\n";

/** Mids are in the middle of their edges if their order is understood. */
static void tetrahedra_of_second_order(void **state) {
    put(state, "a.node", nodes_of_second_order);
    put(state, "a.ele", elements_of_second_order);
    /* The last word of a face or edge is its marker, be there mids or not. */
    put(state, "a.face",
        "5 1\n1  3 4 5  13 14 9  0\n2  1 3 2  10 7 8  4\n3  1 3 4  9 6 8  0\n4  2 4 3  9 10 11  0\n"
        "5  1 2 4  11 6 7  0\n");
    put(state, "a.edge", "3 1\n1  3 4  9 0\n2  3 1  8 2\n3  1 4  6 0\n");
    put(state, "a.vol", "2\n1 0.5\n2 -1\n");
    planish_file *file = open_mesh(state, "a.node");
    const planish_mesh mesh = planish_file_mesh(file);
    planish_cells cells;
    planish_cell_quality quality;
    assert_int_equal(mesh.n_elements, 2);
    assert_int_equal(mesh.cells->type[0], PLANISH_CELL_TETRAHEDRON10);
    assert_int_equal(file->model.n_other, 0);
    assert_int_equal(file->model.triangle.n, 1);
    assert_int_equal(file->model.triangle.nodes[0], 0);
    assert_int_equal(file->model.entity[file->model.triangle.entity[0]].tag, 4);
    assert_int_equal(file->model.entity[file->model.line.entity[0]].tag, 2);
    assert_int_equal(file->model.n_companions, 4);
    /* The face and the edge that bear markers, 1 3 2 and 3 1, with the mids that elements have there. */
    for (int i = 0; i < 14; i++)
        assert_int_equal(file->model.hold[i],
                         ("10100001000000"[i] == '1' ? IO_HELD_BY_LINE : 0) |
                             ("11100011010000"[i] == '1' ? IO_HELD_BY_FACE : 0));
    unit_expect_valid(file, 2);
    assert_int_equal(planish_file_cells(file, &cells, NULL), PLANISH_OK);
    planish_mesh all = mesh;
    all.elements = NULL;
    all.cells = &cells;
    all.n_elements = all.cells->n;
    assert_int_equal(planish_measure_cells(&all, 0, 1, &quality, NULL, NULL), PLANISH_OK);
    assert_int_equal(quality.all.n_curved, 0);
    assert_int_equal(planish_file_element_number(file, 1), 2);
    planish_file_close(file);
    put(state, "a.face", "5 1\n1  3 4 5  0\n2  1 3 2  4\n3  1 3 4  0\n4  2 4 3  0\n5  1 2 4  0\n");
    put(state, "a.ele",
        "2  10  1\n 1  1 3 4 2  6 7 8 9 10 11  7\n 2  4 3 5 2  12 6 9 13 10 14  8\n");
    file = open_mesh(state, "a.ele");
    assert_int_equal(file->n_regions, 2);
    assert_int_equal(file->model.triangle.n, 1);
    assert_int_equal(file->model.entity[file->model.triangle.entity[0]].tag, 4);
    planish_file_close(file);
}

/** Write times elements of a type, each with its own nodes, as a.node and a.ele. */
static void put_elements(void **state, const unit_element *element, int times) {
    double x[UNIT_NODES][3];
    const int n = unit_places(element->type, element->nodes, x), dim = unit_dim(element->type);
    file_builder nodes = {0}, list = {0};
    builder_text(&nodes, "%d %d 0 0\n", times * n, dim);
    builder_text(&list, "%d %d 1\n", times, n);
    for (int i = 0; i < times; i++) {
        builder_text(&list, "%d", i + 1);
        for (int k = 0; k < n; k++) {
            builder_text(&nodes, dim == 3 ? "%d %.17g %.17g %.17g\n" : "%d %.17g %.17g\n",
                         i * n + k + 1, x[k][0], x[k][1], x[k][2]);
            builder_text(&list, " %d", i * n + k + 1);
        }
        builder_text(&list, "  7.5\n");
    }
    test_write(*state, "a.node", nodes.data, (size_t)nodes.size);
    test_write(*state, "a.ele", list.data, (size_t)list.size);
    builder_release(&nodes);
    builder_release(&list);
}

static void nodes_of_second_order_are_in_order(void **state) {
    /* The first as tetgen -o2 writes it, the second as Triangle does (its manual: a mid is opposite
     * its corner). */
    static const unit_element elements[] = {
        {PLANISH_CELL_TETRAHEDRON10, 10, "0 1 2 3 23 03 01 12 13 02"},
        {PLANISH_CELL_TRIANGLE6, 6, "0 1 2 12 20 01"},
    };
    for (int i = 0; i < 2; i++) {
        put_elements(state, &elements[i], 3);
        planish_file *file = open_mesh(state, "a.node");
        for (int k = 0; k < 3; k++)
            unit_expect(file, k, elements[i].type);
        unit_expect_valid(file, 3);
        unit_expect_others(file, 0, 0);
        planish_file_close(file);
        put_elements(state, &elements[i], 30000); /* threads */
        planish_file *on[2];
        char path[TEST_PATH_SIZE];
        for (int k = 0; k < 2; k++)
            assert_int_equal(
                planish_file_open(test_path(path, *state, "a.ele"), NULL, 1 + 2 * k, &on[k], NULL),
                PLANISH_OK);
        const planish_mesh a = planish_file_mesh(on[0]), b = planish_file_mesh(on[1]);
        assert_int_equal(a.n_elements, 30000);
        assert_int_equal(b.n_elements, 30000);
        assert_memory_equal(a.cells->type, b.cells->type, 30000);
        assert_memory_equal(a.cells->node, b.cells->node,
                            (size_t)a.cells->offset[30000] * sizeof *a.cells->node);
        planish_file_close(on[0]);
        planish_file_close(on[1]);
    }
}

static void missing_files_are_named(void **state) {
    put(state, "a.node", nodes_from_1);
    open_fails(state, "a.node", "a.ele", "beside");
    put(state, "b.ele", elements_from_1);
    open_fails(state, "b.ele", "b.node", "beside");
}

/** Cut each file at every byte: a mesh or an error, whichever is named. */
static void truncation(void **state) {
    static const char *const names[] = {"a.node", "a.ele", "a.face"};
    static const char *const texts[] = {nodes_from_0, elements_from_0,
                                        "2 1\n0 0 1 2 1\n1 1 2 3 0\n"};
    for (int cut = 0; cut < 3; cut++)
        for (size_t size = 0; size < strlen(texts[cut]); size++) {
            for (int i = 0; i < 3; i++)
                test_write(*state, names[i], texts[i], i == cut ? size : strlen(texts[i]));
            for (int named = 0; named < 2; named++) {
                char path[TEST_PATH_SIZE];
                planish_file *file = NULL;
                planish_error error = {.code = 0};
                int status = planish_file_open(test_path(path, *state, names[named]), NULL, 1,
                                               &file, &error);
                if (status)
                    assert_true(error.code == status && error.text[0]);
                else
                    assert_int_equal(planish_file_mesh(file).n_elements, 2);
                planish_file_close(file);
            }
        }
}

/** Write text and what is beside it to b, with the last coordinate of node 4 moved. */
static void written_with_all_its_files(void **state) {
    static const char *const outputs[] = {"b.node", "b.ele"};
    char path[TEST_PATH_SIZE], expected[sizeof nodes_from_0];
    planish_error error;
    put(state, "a.node", nodes_from_0);
    put(state, "a.ele", elements_from_0);
    put(state, "a.face", "0 1\n");
    strcpy(expected, nodes_from_0);
    memcpy(strstr(expected, "1.5"), "2.5", 3);
    for (int i = 0; i < 2; i++) {
        planish_file *file = open_mesh(state, "a.node");
        planish_file_coordinates(file)[14] = 2.5;
        test_path(path, *state, outputs[i]);
        assert_true(planish_file_can_write(file, path));
        if (planish_file_write(file, path, planish_file_coordinates(file),
                               &(planish_write_options){.threads = 1}, &error))
            fail_msg("%s", error.text);
        planish_file_close(file);
        static const char *const names[] = {"b.node", "b.ele", "b.face"};
        const char *const texts[] = {expected, elements_from_0, "0 1\n"};
        for (int j = 0; j < 3; j++) {
            char *written = test_read(test_path(path, *state, names[j]), NULL);
            assert_string_equal(written, texts[j]);
            free(written);
            unlink(path);
        }
    }
    assert_int_equal(test_count_files(*state), 3);
}

static void written_over_itself(void **state) {
    char path[TEST_PATH_SIZE];
    planish_error error;
    put(state, "a.node", nodes_from_1);
    put(state, "a.ele", elements_from_1);
    planish_file *file = open_mesh(state, "a.ele");
    planish_file_coordinates(file)[14] = 0.1;
    test_path(path, *state, "a.ele");
    if (planish_file_write(file, path, planish_file_coordinates(file),
                           &(planish_write_options){.threads = 1}, &error))
        fail_msg("%s", error.text);
    planish_file_close(file);
    file = open_mesh(state, "a.ele");
    assert_true(planish_file_mesh(file).coordinates[14] == 0.1);
    planish_file_close(file);
    assert_int_equal(test_count_files(*state), 2);
}

/** Write the mesh a to NAME.node; what planish_file_write returns. */
static int write_as(void **state, const char *name, planish_error *error) {
    char path[TEST_PATH_SIZE];
    planish_file *file = open_mesh(state, "a.node");
    planish_file_coordinates(file)[14] = 2.5;
    int status =
        planish_file_write(file, test_path(path, *state, name), planish_file_coordinates(file),
                           &(planish_write_options){.threads = 1}, error);
    planish_file_close(file);
    return status;
}

/** Lines may lack attributes that were promised, also where coordinates become shorter. */
static void promised_attributes_may_be_missing(void **state) {
    static const double where[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
    char path[TEST_PATH_SIZE];
    file_builder nodes = {.data = NULL};
    builder_text(&nodes, "5 3 300\n");
    for (int i = 0; i < 5; i++)
        builder_text(&nodes, "%d %.20f %.20f %.20f\n", i + 1, where[3 * i] / 7,
                     where[3 * i + 1] / 7, where[3 * i + 2] / 7);
    test_write(*state, "a.node", nodes.data, (size_t)nodes.size);
    put(state, "a.ele", elements_from_1);
    planish_file *file = open_mesh(state, "a.node");
    assert_int_equal(planish_file_write(file, test_path(path, *state, "b.node"), where,
                                        &(planish_write_options){.threads = 1}, NULL),
                     0);
    planish_file_close(file);
    file = open_mesh(state, "b.node");
    assert_memory_equal(planish_file_mesh(file).coordinates, where, sizeof where);
    planish_file_close(file);
    builder_release(&nodes);
}

/** The content of a file, or NULL: there is none. */
static void check_file(void **state, const char *name, const char *expected) {
    char path[TEST_PATH_SIZE];
    test_path(path, *state, name);
    if (!expected) {
        assert_int_not_equal(access(path, F_OK), 0);
        return;
    }
    char *content = test_read(path, NULL);
    assert_string_equal(content, expected);
    free(content);
}

static void files_that_stay_right_are_written_along(void **state) {
    static const struct {
        const char *extension, *text;
        int written;
    } others[] = {
        {".neigh", "2 4\n0 1 -1 -1 -1\n1 0 -1 -1 -1\n", 1},
        {".t2f", "0 1 2 3 4\n", 1},
        {".mtr", "5 1\n1\n1\n1\n1\n1\n", 1},
        {".vol", "# of TetGen\n2\n0 0.5\n1 -1\n", 1},
        {".vol", "3\n0 0.5\n1 -1\n2 -1\n", 0}, /* three elements */
        {".vol", "mesh3d\ndimension\n3\n", 0}, /* Netgen's */
        {".poly", "# of Triangle or TetGen\n0 3 0 1\n0 1\n0\n", 1},
        {".poly", "4 3 0 0\n1 0 0 0\n", 0}, /* has nodes: it is a source */
        {".smesh", "0 3 0 0\n0\n0\n", 1},
        {".smesh", "x", 0},
        {".neigh", "", 0},
        {".vtk", "2\n", 0},
    };
    planish_error error = {.text = ""};
    put(state, "a.node", nodes_from_0);
    put(state, "a.ele", elements_from_0);
    put(state, "a.face", "1 1\n0 0 1 2 1\n"); /* a triangle is no element */
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        char path[TEST_PATH_SIZE], from[16], to[16];
        snprintf(from, sizeof from, "a%s", others[i].extension);
        snprintf(to, sizeof to, "b%s", others[i].extension);
        put(state, from, others[i].text);
        if (write_as(state, "b.node", &error))
            fail_msg("%s", error.text);
        check_file(state, to, others[i].written ? others[i].text : NULL);
        check_file(state, "b.ele", elements_from_0);
        unlink(test_path(path, *state, from));
        unlink(test_path(path, *state, to));
    }
}

static void files_of_others_are_not_taken_for_ours(void **state) {
    static const char of_two[] = "2\n0 0.5\n1 -1\n", source[] = "4 3 0 0\n1 0 0 0\n";
    static const char netgen[] = "mesh3d\n", boundary[] = "0 3 0 1\n0 1\n0\n";
    char path[TEST_PATH_SIZE];
    planish_error error = {.text = ""};
    put(state, "a.node", nodes_from_0);
    put(state, "a.ele", elements_from_0);
    /* What would be read along with the output: */
    put(state, "b.vol", of_two);
    assert_int_equal(write_as(state, "b.node", &error), PLANISH_ERROR_FILE);
    assert_non_null(strstr(error.text, "b.vol: belongs to another mesh"));
    unlink(test_path(path, *state, "b.vol"));
    put(state, "b.neigh", "7 4\n");
    assert_int_equal(write_as(state, "b.node", &error), PLANISH_ERROR_FILE);
    assert_non_null(strstr(error.text, "b.neigh: belongs to another mesh"));
    unlink(test_path(path, *state, "b.neigh"));
    /* What would not, stays: */
    put(state, "b.vol", netgen);
    put(state, "b.poly", source);
    put(state, "b.smesh", "");
    assert_int_equal(write_as(state, "b.node", &error), 0);
    check_file(state, "b.vol", netgen);
    check_file(state, "b.poly", source);
    /* and is not overwritten. */
    put(state, "a.poly", boundary);
    assert_int_equal(write_as(state, "b.node", &error), PLANISH_ERROR_FILE);
    assert_non_null(strstr(error.text, "b.poly: is not a file of this mesh"));
    check_file(state, "b.poly", source);
    put(state, "b.poly", "0 7 7 7\n");
    assert_int_equal(write_as(state, "b.node", &error), 0);
    check_file(state, "b.poly", boundary);
    assert_int_equal(write_as(state, "a.node", &error), 0); /* in place */
    check_file(state, "a.poly", boundary);
}

/** What is named is what is written, and files beside it are called likewise. */
static void names(void **state) {
    static const struct {
        const char *output, *nodes, *elements;
    } cases[] = {{"b.node", "b.node", "b.ele"}, {"b.ele", "b.node", "b.ele"},
                 {"b.NODE", "b.NODE", "b.ELE"}, {"B.ELE", "B.NODE", "B.ELE"},
                 {"b.Node", "b.Node", "b.ele"}, {"b.c.node", "b.c.node", "b.c.ele"}};
    static const char *const sources[][2] = {
        {"a.node", "a.ele"}, {"A.NODE", "A.ELE"}, {"d.NODE", "d.ele"}};
    char path[TEST_PATH_SIZE];
    for (size_t s = 0; s < sizeof sources / sizeof *sources; s++) {
        put(state, sources[s][0], nodes_from_0);
        put(state, sources[s][1], elements_from_0);
        for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
            planish_file *file = open_mesh(state, sources[s][0]);
            planish_error error;
            test_path(path, *state, cases[i].output);
            assert_int_equal(planish_file_check_output(file, path, &error), 0);
            assert_int_equal(planish_file_write(file, path, planish_file_coordinates(file),
                                                &(planish_write_options){.threads = 1}, &error),
                             0);
            check_file(state, cases[i].nodes, nodes_from_0);
            check_file(state, cases[i].elements, elements_from_0);
            planish_file_close(file);
            planish_file_close(open_mesh(state, cases[i].output));
            unlink(test_path(path, *state, cases[i].nodes));
            unlink(test_path(path, *state, cases[i].elements));
        }
    }
    /* In place: no second file of another case. */
    planish_file *file = open_mesh(state, "d.NODE");
    test_path(path, *state, "d.NODE");
    assert_int_equal(planish_file_write(file, path, planish_file_coordinates(file),
                                        &(planish_write_options){.threads = 1}, NULL),
                     0);
    planish_file_close(file);
    assert_int_not_equal(access(test_path(path, *state, "d.ELE"), F_OK), 0);
}

/** Elements that somebody else has changed meanwhile do not go with new coordinates. */
static void changed_elements_are_refused(void **state) {
    static const char *const outputs[] = {"a.node", "b.node", "a.ele"};
    for (size_t i = 0; i < sizeof outputs / sizeof *outputs; i++) {
        char path[TEST_PATH_SIZE];
        planish_error error = {.text = ""};
        put(state, "a.node", nodes_from_0);
        put(state, "a.ele", elements_from_0);
        planish_file *file = open_mesh(state, "a.node");
        put(state, "a.ele", "1 4 1\n0  0 1 2 3  7\n");
        assert_true(planish_file_write(file, test_path(path, *state, outputs[i]),
                                       planish_file_coordinates(file),
                                       &(planish_write_options){.threads = 1}, &error) < 0);
        assert_non_null(strstr(error.text, "a.ele"));
        check_file(state, "a.node", nodes_from_0);
        check_file(state, "b.node", NULL);
        planish_file_close(file);
    }
}

/** Any name, if the format is told: the others' are longer by their extensions. */
static void names_without_the_extension(void **state) {
    char path[TEST_PATH_SIZE];
    planish_file *file;
    put(state, "a.txt", nodes_from_0);
    put(state, "a.txt.ele", elements_from_0);
    put(state, "a.ele", "of another mesh");
    assert_int_equal(planish_file_open(test_path(path, *state, "a.txt"), "tetgen", 1, &file, NULL),
                     0);
    test_path(path, *state, "b.txt");
    assert_int_equal(planish_file_write(file, path, planish_file_coordinates(file),
                                        &(planish_write_options){.threads = 1}, NULL),
                     0);
    planish_file_close(file);
    check_file(state, "b.txt", nodes_from_0);
    check_file(state, "b.txt.ele", elements_from_0);
}

/** An empty file beside is as good as none, whether read or written beside. */
static void empty_files_beside(void **state) {
    planish_error error = {.text = ""};
    put(state, "a.node", nodes_from_0);
    put(state, "a.ele", elements_from_0);
    put(state, "a.face", "");
    put(state, "b.edge", "");
    assert_int_equal(write_as(state, "b.node", &error), 0);
    planish_file_close(open_mesh(state, "b.node"));
    put(state, "a.ele", "");
    open_fails(state, "a.node", "a.ele", "empty");
}

static void open_ends_are_named(void **state) {
    put(state, "a.node", nodes_from_0);
    put(state, "a.mtr", "not read");
    put(state, "b.node", nodes_from_0);
    put(state, "b.ele", elements_from_0);
    put(state, "b.mtr", "not read");
    put(state, "a.ele", "2 4 1\n0  0 1 2 3  7\n1  1 2 3 4  8");
    planish_file *file = open_mesh(state, "a.node");
    assert_non_null(strstr(planish_file_unterminated_path(file), "a.ele"));
    planish_file_close(file);
    file = open_mesh(state, "b.node");
    assert_null(planish_file_unterminated_path(file));
    planish_file_close(file);
}

static void a_real_mesh(void **state) {
    char path[TEST_PATH_SIZE];
    planish_file *file = NULL;
    planish_error error;
    (void)state;
    test_path_from(path, "PLANISH_MESHES", "stellar_house2.ele");
    if (planish_file_open(path, NULL, 1, &file, &error))
        fail_msg("%s", error.text);
    planish_mesh mesh = planish_file_mesh(file);
    assert_int_equal(mesh.n_nodes, 400);
    assert_int_equal(mesh.n_elements, 1389);
    planish_file_close(file);
}

#define IN_A_FOLDER(test)                                                                          \
    cmocka_unit_test_setup_teardown(test, test_folder_create, test_folder_remove)

int main(void) {
    const struct CMUnitTest tests[] = {
        IN_A_FOLDER(either_file_may_be_named),
        IN_A_FOLDER(numbers_may_begin_with_1),
        IN_A_FOLDER(marked_faces_and_edges_hold),
        IN_A_FOLDER(constraints_hold_without_markers),
        IN_A_FOLDER(attributes_that_are_no_integers_make_no_regions),
        IN_A_FOLDER(promised_attributes_may_be_missing),
        IN_A_FOLDER(threads_see_the_same_regions),
        IN_A_FOLDER(triangles_in_the_plane),
        IN_A_FOLDER(bad_files_are_refused),
        IN_A_FOLDER(tetrahedra_of_second_order),
        IN_A_FOLDER(nodes_of_second_order_are_in_order),
        IN_A_FOLDER(missing_files_are_named),
        IN_A_FOLDER(truncation),
        IN_A_FOLDER(written_with_all_its_files),
        IN_A_FOLDER(written_over_itself),
        IN_A_FOLDER(files_that_stay_right_are_written_along),
        IN_A_FOLDER(files_of_others_are_not_taken_for_ours),
        IN_A_FOLDER(names),
        IN_A_FOLDER(changed_elements_are_refused),
        IN_A_FOLDER(names_without_the_extension),
        IN_A_FOLDER(empty_files_beside),
        IN_A_FOLDER(open_ends_are_named),
        cmocka_unit_test(a_real_mesh),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
