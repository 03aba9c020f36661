/* Medit: what is read, what is held, what is refused. */
#include "support/reading.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const char solid[] = "# a comment\nMeshVersionFormatted 2\nDimension 3\n\nVertices\n6\n"
                            "0 0 0 1\n1 0 0 1\n0 1 0 2\n0 0 1 2 # another\n1 1 1.5e0 3 2 2 2 9\n"
                            "Tetrahedra\n2\n1 2 3 4 7\n2 3 4 5 8\n"
                            "Triangles\n1\n1 2 3 4\n"
                            "Normals\n1\n0 0 1\nEdges 1 1 2 0\n"
                            "RequiredVertices 1 6 End\n";

static void a_solid_is_read(void **state) {
    (void)state;
    planish_file *file = reading_text(&io_format_medit, solid);
    planish_mesh mesh = planish_file_mesh(file);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(mesh.dim, 3);
    assert_int_equal(mesh.n_nodes, 6);
    assert_int_equal(mesh.n_elements, 2);
    assert_true(mesh.coordinates[14] == 1.5 && mesh.coordinates[15] == 2);
    static const int32_t elements[] = {0, 1, 2, 3, 1, 2, 3, 4};
    assert_memory_equal(mesh.elements, elements, sizeof elements);
    assert_int_equal(info.n_regions, 2);
    assert_int_equal(info.n_lower_elements, 2);
    assert_int_equal(info.precision, PLANISH_DOUBLE);
    assert_int_equal(planish_file_element_number(file, 1), 2);
    assert_int_equal(planish_file_node_number(file, 5), 6);
    assert_int_equal(file->model.hold[0], IO_HELD_BY_LINE | IO_HELD_BY_TRIANGLE);
    assert_int_equal(file->model.hold[5], IO_HELD_REQUIRED);
    assert_int_equal(file->model.hold[4], 0);
    assert_memory_equal(solid + file->model.text_offset[4], "1 1 1.5e0", 9);
    planish_file_close(file);
}

/** Constraints: 0 free, 1 fixed, of the six nodes as digits. */
static int constraints_are(const planish_file *file, const char *tag, int ignore_regions,
                           const char *expected) {
    uint8_t constraint[6];
    planish_error error;
    const planish_hold hold = {
        .tags = &tag, .n_tags = tag != NULL, .ignore_regions = ignore_regions};
    assert_int_equal(planish_file_constraints(file, &hold, constraint, &error), 0);
    int same = 1;
    for (int i = 0; i < 6; i++)
        same &= constraint[i] == expected[i] - '0';
    return same;
}

static void nodes_are_held(void **state) {
    (void)state;
    planish_file *file = reading_text(&io_format_medit, solid);
    assert_true(constraints_are(file, NULL, 0, "111101")); /* 1 2 3: also between regions */
    assert_true(constraints_are(file, NULL, 1, "111001"));
    assert_true(constraints_are(file, "8", 1, "111111"));
    assert_true(constraints_are(file, "3:8", 1, "111111"));
    assert_true(constraints_are(file, "0:3", 1, "111011"));
    uint8_t constraint[6];
    planish_error error;
    const char *unknown = "2:8";
    const planish_hold hold = {.tags = &unknown, .n_tags = 1};
    assert_int_equal(planish_file_constraints(file, &hold, constraint, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "3:7"));
    planish_file_close(file);
}

static void a_plane_is_read(void **state) {
    (void)state;
    planish_file *file =
        reading_text(&io_format_medit, "MeshVersionFormatted 1 Dimension 2 Vertices 4 0 0 0 "
                                       "1 0 0 1 1 0 0.1 1 0 Triangles 2 1 2 3 1 1 3 4 1 "
                                       "Quadrilaterals 1 1 2 3 4 5 RequiredTriangles 1 2 End");
    planish_mesh mesh = planish_file_mesh(file);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(mesh.dim, 2);
    assert_int_equal(mesh.n_elements, 2);
    assert_int_equal(info.precision, PLANISH_FLOAT); /* version 1 */
    volatile float tenth = 0.1f;
    assert_true(mesh.coordinates[6] == tenth);
    assert_int_equal(info.n_other_elements, 1);
    assert_int_equal(file->model.hold[1], IO_HELD_BY_OTHER);
    assert_int_equal(file->model.hold[3], IO_HELD_BY_OTHER | IO_HELD_REQUIRED);
    planish_file_close(file);
}

static void sections_may_stand_in_any_order(void **state) {
    (void)state;
    planish_file *file =
        reading_text(&io_format_medit, "MeshVersionFormatted 2 Dimension 3 Corners 1 4 "
                                       "Tetrahedra 1 1 2 3 4 0 Vertices 4 0 0 0 0 1 0 0 0 "
                                       "0 1 0 0 0 0 1 0 End");
    assert_int_equal(planish_file_mesh(file).n_elements, 1);
    assert_int_equal(file->model.hold[3], IO_HELD_REQUIRED);
    planish_file_close(file);
}

#define HEAD  "MeshVersionFormatted 2\nDimension 3\n"
#define NODES "Vertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n"

static void comments_are_no_keywords(void **state) {
    (void)state;
    planish_file *file =
        reading_text(&io_format_medit, "MeshVersionFormatted 2\n# Vertices 5\nDimension 3\n"
                                       "# RequiredVertices 1 1\n" NODES
                                       "# Corners 1 2\nTetrahedra\n1\n1 2 3 4 0\nEnd\n");
    assert_int_equal(planish_file_mesh(file).n_nodes, 4);
    assert_int_equal(file->model.hold[0] | file->model.hold[1], 0);
    planish_file_close(file);
}

static void wrong_files_are_refused(void **state) {
    (void)state;
    const io_format *f = &io_format_medit;
    reading_fails(f, HEAD NODES, "nothing to smooth");
    reading_fails(f, HEAD NODES "Tetrahedra\n1\n1 2 3 5 0\n", "test:11");
    reading_fails(f, HEAD NODES "Tetrahedra\n1\n0 2 3 4 0\n", "not in 1 .. 4");
    reading_fails(f, HEAD NODES "Tetrahedra\n1\n1 2 3 x 0\n", "whole number");
    reading_fails(f, HEAD NODES "Tetrahedra\n2\n1 2 3 4 0\n", "cannot be in");
    reading_fails(f, HEAD NODES "Tetrahedra\n1\n1 2 3 4 0\n1 2 3 4 0\n", "more than 1");
    reading_fails(f, HEAD "Vertices\n4611686018427387904\n0 0 0 0\n", "cannot be in");
    reading_fails(f, HEAD "Vertices\n-1\n", "cannot be in");
    reading_fails(f, HEAD "Vertices\n2\n0 0 nan 0 0 0 0 0 Tetrahedra 0", "not finite");
    reading_fails(f, HEAD "Vertices\n1\n0 0 1e999 0\n", "not finite");
    reading_fails(f, HEAD NODES NODES, "second time");
    reading_fails(f, HEAD "TetrahedraP2 1 1\n", "first order");
    reading_fails(f, "MeshVersionFormatted 9\n", "unknown");
    reading_fails(f, "MeshVersionFormatted 2\nDimension 4\n", "unknown");
    reading_fails(f, HEAD, "no Vertices");
    reading_fails(f, HEAD "Vertices 3 0 0 0 0 1 0 0 0 0 1 1 0 Triangles 1 1 2 3 0",
                  "triangles in space");
}

static void every_beginning_is_survived(void **state) {
    (void)state;
    reading_every_beginning(&io_format_medit, solid, (int64_t)strlen(solid));
}

/** Large enough for the parallel path; the same with a comment in it, which needs the serial one.
 */
static void many_threads_read_the_same(void **state) {
    (void)state;
    enum { N = 60000 };
    size_t size = N * 40 + N * 40, used = 0;
    char *text = malloc(size);
    used += (size_t)sprintf(text + used, HEAD "Vertices %d\n", N);
    for (int i = 0; i < N; i++)
        used += (size_t)sprintf(text + used, "%d.5 %d 1e-%d %d\n", i, i * 7 % 1000, i % 20, i % 3);
    size_t comment = used;
    used += (size_t)sprintf(text + used, "         \nTetrahedra %d\n", N - 3);
    for (int i = 0; i < N - 3; i++)
        used += (size_t)sprintf(text + used, "%d %d %d %d 1\n", i + 1, i + 2, i + 3, i + 4);
    for (int commented = 0; commented < 2; commented++) {
        planish_file *one = NULL, *four = NULL;
        planish_error error = {.text = ""};
        if (commented)
            memcpy(text + comment, "# 1 2 3 ", 8);
        assert_int_equal(
            io_file_from_memory(&io_format_medit, "test", text, (int64_t)used, 1, &one, &error), 0);
        assert_int_equal(
            io_file_from_memory(&io_format_medit, "test", text, (int64_t)used, 4, &four, &error),
            0);
        assert_memory_equal(one->model.xyz, four->model.xyz, N * 3 * sizeof(double));
        assert_memory_equal(one->model.text_offset, four->model.text_offset, N * sizeof(int64_t));
        assert_memory_equal(one->model.tetrahedron.nodes, four->model.tetrahedron.nodes,
                            (N - 3) * 4 * sizeof(int32_t));
        assert_true(one->model.xyz[3 * (N - 1)] == N - 0.5);
        planish_file_close(one);
        planish_file_close(four);
    }
    free(text);
}

/** A comment among many edges: threads must hold the nodes that one thread holds. */
static void comments_do_not_misplace_records(void **state) {
    (void)state;
    enum { N = 300000 };
    char *text = malloc((size_t)N * 6 + 1000);
    size_t used = (size_t)sprintf(text,
                                  HEAD "Vertices 9 0 0 0 5 1 0 0 5 0 1 0 5 0 0 1 5 2 2 2 5 "
                                       "3 3 3 5 4 4 4 5 5 5 5 5 6 6 6 5\n"
                                       "Tetrahedra 1 1 2 3 4 5\nEdges %d\n# 1\n",
                                  N);
    for (int i = 0; i < N; i++)
        used += (size_t)sprintf(text + used, "1 2 5\n");
    planish_file *one = NULL, *four = NULL;
    planish_error error = {.text = ""};
    assert_int_equal(
        io_file_from_memory(&io_format_medit, "test", text, (int64_t)used, 1, &one, &error), 0);
    assert_int_equal(
        io_file_from_memory(&io_format_medit, "test", text, (int64_t)used, 4, &four, &error), 0);
    static const uint8_t held[9] = {IO_HELD_BY_LINE, IO_HELD_BY_LINE};
    assert_memory_equal(one->model.hold, held, sizeof held);
    assert_memory_equal(four->model.hold, held, sizeof held);
    planish_file_close(one);
    planish_file_close(four);
    free(text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_solid_is_read),
        cmocka_unit_test(nodes_are_held),
        cmocka_unit_test(a_plane_is_read),
        cmocka_unit_test(sections_may_stand_in_any_order),
        cmocka_unit_test(comments_are_no_keywords),
        cmocka_unit_test(wrong_files_are_refused),
        cmocka_unit_test(every_beginning_is_survived),
        cmocka_unit_test(many_threads_read_the_same),
        cmocka_unit_test(comments_do_not_misplace_records),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
