/* OFF: what is read, what is held, what is refused, what is written. */
#include "io/core/binary.h"
#include "support/file_builder.h"
#include "support/files.h"
#include "support/reading.h"
#include "support/rewriting.h"
#include "support/unit_elements.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define SQUARE "0 0 0\n1 0 0\n1 1 0\n0 1.0 0\n"

/* Two triangles, a line, a quadrilateral and a point, with colours and comments. */
static const char mixed[] = "# a comment\nOFF # of Geomview\n# 5 5 5\n10 5 0 # vertices, faces\n"
                            "0 0 0\n1 0 0 # here\n\n1 1.50 0\n0 1 0\n3 3 0\n4 3 0\n4 4 0\n3 4 0\n"
                            "5 5 0\n0.5 0.5 0\n"
                            "3 0 1 9\n2 0 1 1\n4 4 5 6 7 # no colour\n 3 1 2 9 255 0 0 128\n"
                            "1 8 0.5 0.5 0.5\n# the end";

static void a_file_is_read(void **state) {
    (void)state;
    static const int32_t elements[] = {0, 1, 9, 1, 2, 9};
    static const reading_facts facts = {.dim = 2,
                                        .n_nodes = 10,
                                        .n_elements = 3,
                                        .n_regions = 1,
                                        .n_other = 0,
                                        .n_lower = 2,
                                        .precision = PLANISH_PRECISION_DOUBLE};
    planish_file *file = reading_text(&io_format_off, mixed);
    reading_gave(file, &io_format_off, &facts);
    planish_mesh mesh = planish_file_mesh(file);
    assert_memory_equal(mesh.cells->node, elements, sizeof elements);
    assert_true(mesh.coordinates[5] == 1.5);
    assert_int_equal(planish_file_node_number(file, 4), 4);
    assert_int_equal(planish_file_element_number(file, 0), 0);
    assert_int_equal(planish_file_element_number(file, 1), 3); /* of the faces */
    assert_int_equal(file->model.hold[0], IO_HELD_BY_LINE);
    assert_int_equal(file->model.hold[1], IO_HELD_BY_LINE);
    assert_int_equal(file->model.hold[2], 0);
    assert_int_equal(file->model.hold[6], 0);
    assert_int_equal(file->model.hold[8], IO_HELD_BY_POINT);
    assert_int_equal(file->model.hold[9], 0);
    planish_file_close(file);
}

static void first_lines_of_every_kind(void **state) {
    static const char *const texts[] = {
        "OFF\n4 2 0\n" SQUARE "3 0 1 2\n3 0 2 3\n",
        "OFF 4 2 5\n" SQUARE "3 0 1 2\n3 0 2 3\n",
        "OFF\n4\n2\n0\n" SQUARE "3 0 1 2\n3 0 2 3",
        "OFF\r\n4 2 0\r\n0 0 0\r\n1 0 0\r\n1 1 0\r\n0 1 0\r\n3 0 1 2\r\n3 0 2 3\r\n",
        "OFF\r4 2 0\r0 0 0\r1 0 0\r1 1 0\r0 1 0\r3 0 1 2\r3 0 2 3\r",
        "COFF\n4 2 0\n0 0 0 255 0 0 255\n1 0 0 0 0 0 0\n1 1 0 1 1 1\n0 1 0 2\n3 0 1 2 7\n3 0 2 3\n",
        "NOFF\n4 2 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n3 0 2 3\n",
        "CNOFF 4 2 0\n0 0 0 0 0 1 1 1 1 1\n1 0 0 0\n1 1 0 0\n0 1 0 0\n3 0 1 2\n3 0 2 3\n",
        "STOFF 4 2 0\n0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n3 0 1 2\n3 0 2 3\n",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        static const double square[] = {0, 0, 1, 0, 1, 1, 0, 1};
        static const int32_t elements[] = {0, 1, 2, 0, 2, 3};
        assert_true(io_format_off.recognise(texts[i], (int64_t)strlen(texts[i])));
        planish_file *file = reading_text(&io_format_off, texts[i]);
        planish_mesh mesh = planish_file_mesh(file);
        assert_int_equal(mesh.n_elements, 2);
        assert_memory_equal(mesh.coordinates, square, sizeof square);
        assert_memory_equal(mesh.elements, elements, sizeof elements);
        assert_int_equal(planish_file_element_number(file, 1), 1);
        planish_file_close(file);
        rewriting_keeps_the_rest(&io_format_off, texts[i], (int64_t)strlen(texts[i]), *state);
    }
    rewriting_keeps_the_rest(&io_format_off, mixed, sizeof mixed - 1, *state);
}

static void quadrilaterals_are_measured(void **state) {
    (void)state;
    unit_expect_alone(reading_text(&io_format_off, "OFF\n4 1 0\n" SQUARE "4 0 1 2 3\n"),
                      PLANISH_CELL_QUADRILATERAL, 0, 0, 1);
    unit_expect_alone(reading_text(&io_format_off, "OFF\n4 1 0\n" SQUARE "4 0 1 3 2\n"),
                      PLANISH_CELL_QUADRILATERAL, 0, 0, 0);
    planish_file *file = reading_text(&io_format_off, mixed);
    static const int32_t nodes[] = {0, 1, 9, 1, 2, 9, 4, 5, 6, 7};
    planish_cells cells;
    planish_error error;
    assert_int_equal(planish_file_cells(file, &cells, &error), 0);
    assert_int_equal(cells.n, 3);
    assert_int_equal(cells.type[2], PLANISH_CELL_QUADRILATERAL);
    assert_memory_equal(cells.node, nodes, sizeof nodes);
    assert_int_equal(planish_file_element_number(file, 2), 2);
    planish_file_close(file);
    /* Polygons hold their nodes, and nothing measures them. */
    reading_fails(&io_format_off, "OFF\n5 1 0\n" SQUARE "2 2 0\n5 0 1 2 4 3\n",
                  "nothing to smooth");
}

static void wrong_files_are_refused(void **state) {
    (void)state;
    const io_format *f = &io_format_off;
    reading_fails(f, "PLY\n", "no OFF");
    reading_fails(f, "4OFF\n4 2 0\n", "4OFF");
    reading_fails(f, "C4nOFF\n2 4 2 0\n", "nOFF");
    reading_fails(f, "OFF\nx 2 0\n", "numbers of vertices");
    reading_fails(f, "OFF\n4", "numbers of vertices");
    reading_fails(f, "OFF\n4 2\n0.5 0 0\n", "faces and edges");
    reading_fails(f, "OFF\n4 0 0\n" SQUARE, "nothing to smooth");
    reading_fails(f, "OFF\n-4 1 0\n" SQUARE, "cannot be in");
    reading_fails(f, "OFF\n4611686018427387904 1 0\n" SQUARE, "cannot be in");
    reading_fails(f, "OFF\n4 4611686018427387904 0\n" SQUARE "3 0 1 2\n", "cannot be in");
    reading_fails(f, "OFF\n4 -1 0\n" SQUARE "3 0 1 2\n", "cannot be in");
    reading_fails(f, "OFF\n4 1 0\n" SQUARE "3 0 1 4\n",
                  "test:7: face 0: number 4 is not in 0 .. 3");
    reading_fails(f, "OFF\n4 1 0\n" SQUARE "3 0 1 -1\n", "number -1 is not in");
    reading_fails(f, "OFF\n4 1 0\n" SQUARE "3 0 1\n", "whole number");
    reading_fails(f, "OFF\n4 1 0\n" SQUARE "-3 0 1 2\n", "cannot have -3");
    reading_fails(f, "OFF\n4 1 0\n" SQUARE "9999 0 1 2\n", "cannot have 9999");
    reading_fails(f, "OFF\n4 1 0\n" SQUARE "3 0 1 2\n3 0 2 3\n", "more follows");
    reading_fails(f, "OFF\n4 2 0\n" SQUARE "3 0 1 2\n# 3 0 2 3\n", "whole number");
    reading_fails(f, "OFF\n4 1 0\n0 0 0\n1 0\n1 1 0\n0 1 0\n3 0 1 2\n", "test:4: vertex 1");
    reading_fails(f, "OFF\n3 1 0\n0 0 0\n1 nan 0\n1 1 0\n3 0 1 2\n", "test:4");
    reading_fails(f, "OFF\n3 1 0\n0 0 0\n1 1e999 0\n1 1 0\n3 0 1 2\n", "not finite");
    reading_gives_surface(f, "OFF\n4 2 0\n0 0 0\n1 1 1\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n");
    assert_false(io_format_off.recognise("OFFICE\n", 7));
    assert_false(io_format_off.recognise("CONOFF\n", 7));
}

/** Two triangles and a quadrilateral with colours. */
static void build_binary(file_builder *b, const char *first, int extra) {
    static const float xy[] = {0, 0, 1, 0, 1, 1, 0, 1, 3, 3, 4, 3, 4, 4, 0.1f, 4};
    static const int faces[] = {3, 0, 1, 2, 0, 4, 4, 5, 6, 7, 1, 9, 3, 0, 2, 3, 0};
    *b = (file_builder){.binary = 1, .swapped = io_machine_is_little()};
    builder_text(b, "%s", first);
    builder_integer(b, 8, 4);
    builder_integer(b, 3, 4);
    builder_integer(b, 0, 4);
    for (int i = 0; i < 8; i++) {
        builder_real(b, xy[2 * i], 4);
        builder_real(b, xy[2 * i + 1], 4);
        builder_real(b, 0, 4);
        for (int j = 0; j < extra; j++)
            builder_real(b, j, 4);
    }
    for (size_t i = 0; i < sizeof faces / sizeof *faces; i++)
        builder_integer(b, faces[i], 4);
}

static void binary_files_are_read_and_written(void **state) {
    static const struct {
        const char *first;
        int extra;
    } kinds[] = {{"OFF BINARY\n", 0}, {"NOFF BINARY\n", 3}, {"STCNOFF BINARY\r\n", 9}};
    static const int32_t elements[] = {0, 1, 2, 0, 2, 3};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        file_builder b;
        planish_error error;
        build_binary(&b, kinds[i].first, kinds[i].extra);
        planish_file *file = builder_file(&b, &io_format_off);
        planish_mesh mesh = planish_file_mesh(file);
        planish_file_info info;
        planish_file_get_info(file, &info);
        assert_int_equal(info.precision, PLANISH_PRECISION_FLOAT);
        assert_int_equal(info.n_other_elements, 0);
        assert_int_equal(mesh.n_elements, 3);
        assert_memory_equal(mesh.cells->node, elements, sizeof elements);
        assert_true(mesh.coordinates[14] == (double)0.1f);
        assert_int_equal(planish_file_element_number(file, 1), 2);
        planish_file_close(file);
        builder_try_to_break(&b, &io_format_off);
        rewriting_keeps_the_rest(&io_format_off, b.data, b.size, *state);
        /* The whole file is read, so that no beginning is one. */
        for (b.size--; b.size > 0; b.size--) {
            assert_true(builder_read(&b, &io_format_off, 1, &file, &error) < 0);
            assert_null(file);
        }
        builder_release(&b);
    }
}

static void binary_values_that_cannot_be(void **state) {
    (void)state;
    static const struct {
        int64_t at; /* behind the first line */
        int32_t value;
        const char *word;
    } cases[] = {
        {0, -1, "cannot be in"},
        {0, INT32_MAX, "cannot be in"},
        {4, -1, "cannot be in"},
        {4, INT32_MAX, "cannot be in"},
        {4, 4, "face 3"},
        {12, 0x7fc00000, "not finite"},
        {108, -3, "-3 vertices"},
        {108, INT32_MAX, "cannot have"},
        {112, 8, "face 0: number 8 is not in 0 .. 7"},
        {112, -1, "number -1 is not in"},
        {124, INT32_MAX, "a colour"},
        {124, -1, "a colour"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        file_builder b;
        build_binary(&b, "OFF BINARY\n", 0);
        for (int j = 0; j < 4; j++)
            b.data[11 + cases[i].at + j] = (char)((uint32_t)cases[i].value >> (24 - 8 * j));
        builder_expect_error(&b, &io_format_off, cases[i].word);
        builder_release(&b);
    }
}

static void files_are_cut_anywhere(void **state) {
    (void)state;
    file_builder b = builder_of(mixed);
    builder_try_to_break(&b, &io_format_off);
}

/** Large enough for the parallel path; with faces of another kind in the middle, which need the
 *  serial one. */
static void threads_read_the_same(void **state) {
    (void)state;
    enum { N = 120000 };
    for (int kind = 0; kind < 3; kind++) {
        file_builder b = {0};
        planish_file *file;
        planish_error error;
        builder_text(&b, "%s\n%d %d 0\n", kind == 2 ? "COFF" : "OFF", N, N - 2);
        for (int i = 0; i < N; i++)
            builder_text(&b, "%d.5 1e-%d 0%s\n", i, i % 20, kind == 2 ? " 255 0 0 128" : "");
        for (int i = 0; i < N - 2; i++)
            if (kind == 1 && i == N / 2)
                builder_text(&b, "2 0 1\n");
            else
                builder_text(&b, "3 %d %d %d%s\n", i, i + 1, i + 2, kind == 2 ? " 1 0 0" : "");
        builder_expect_same_on_threads(&b, &io_format_off);
        assert_int_equal(builder_read(&b, &io_format_off, 3, &file, &error), 0);
        assert_int_equal(planish_file_mesh(file).n_elements, N - 2 - (kind == 1));
        assert_int_equal(planish_file_element_number(file, N - 4), N - 4 + (kind == 1));
        assert_true(planish_file_mesh(file).coordinates[2 * (N - 1)] == N - 0.5);
        planish_file_close(file);
        builder_release(&b);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_is_read),
        cmocka_unit_test(first_lines_of_every_kind),
        cmocka_unit_test(quadrilaterals_are_measured),
        cmocka_unit_test(wrong_files_are_refused),
        cmocka_unit_test(binary_files_are_read_and_written),
        cmocka_unit_test(binary_values_that_cannot_be),
        cmocka_unit_test(files_are_cut_anywhere),
        cmocka_unit_test(threads_read_the_same),
    };
    return cmocka_run_group_tests(tests, test_folder_create, test_folder_remove);
}
