/* AVS UCD: what is told from others, read, held, refused and written. */
#include "io/core/binary.h"
#include "support/file_builder.h"
#include "support/files.h"
#include "support/reading.h"
#include "support/rewriting.h"
#include "support/unit_elements.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void ucd_is_told(void **state) {
    (void)state;
    static const char *const texts[] = {
        "3 1 0 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n1 0 tri 1 2 3\n",
        "# a comment\n#\n3 1 0 1 0\r\n1 0 0 0\r\n2 1 0 0\r\n3 0 1 0\r\n1 5 tri 1 2 3\r\n",
        "  1  1 2 0 0\n 0 1e-3 0 0\n 1 1 hex 1 1 1 1 1 1 1 1",
        "3 1 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n1 0 tri 1 2 3\n", /* LaGriT's */
        "3 0 0 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n",
        "3000 1 0 0 0\n1 0 0 0\n2 1 0 0\n", /* its beginning */
    };
    reading_tells(&io_format_ucd, texts, sizeof texts / sizeof *texts, 1);
}

static void others_are_not(void **state) {
    (void)state;
    static const char *const texts[] = {
        "",
        "3 1 0 0 0",
        "3 1 0 0 0\n1 0 0\n2 1 0 0\n3 0 1 0\n",
        "3 1 0 0 0\n1 0 0 0 0\n2 1 0 0\n3 0 1 0\n",
        "3 1 0 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n1 0 tria 1 2 3\n",
        "3 2 0 0\n1 0 0\n2 1 0\n3 0 1\n", /* four counts: TetGen's */
        "3 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n",
        "3 3 0 0\n1 0 0 0\n2 1 0 0\n",
        "3 1 0 0 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n1 0 tri 1 2 3\n",
        "3 1 0 0 -1\n1 0 0 0\n2 1 0 0\n3 0 1 0\n1 0 tri 1 2 3\n",
        "3 -1 0 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n1 0 tri 1 2 3\n",
        "*NODE\n1, 0, 0, 0\n",
        "\7abc",
        "\7abcdefghijklmnopqrstuvwxyzabcdefghijklmnopqrstuvwxyz",
    };
    reading_tells(&io_format_ucd, texts, sizeof texts / sizeof *texts, 0);
}

#define NODES "7 0 0 0\n3 1 0 0\n2 0 1 0\n1 0 0 1\n90 1 1 1.50\n5 4 4 4\n"

/* Numbers in no order, all kinds of cells that hold, data. */
static const char solid[] = "# by hand\n  # more\n6 7 1 2 0\n" NODES
                            "11 3 tet 7 3 2 1\n13 -4 tet 3 2 1 90\n12 5 tri 7 3 2\n1 6 line 7 3\n"
                            "2 7 pt 5\n3 7 tri2 7 3 2 7 3 2\n4 9 tri 3 2 1\n"
                            "1 1\nsize, none\n7 1\n3 1\n2 1\n1 1\n90 1\n5 tet\n1 1\n";

static void a_solid_is_read(void **state) {
    (void)state;
    static const int32_t nodes[] = {0, 1, 2, 3, 1, 2, 3, 4};
    static const reading_facts facts = {.dim = 3,
                                        .n_nodes = 6,
                                        .n_elements = 2,
                                        .n_regions = 2,
                                        .n_other = 1,
                                        .n_lower = 4,
                                        .precision = PLANISH_PRECISION_DOUBLE};
    planish_file *file = reading_text(&io_format_ucd, solid);
    reading_gave(file, &io_format_ucd, &facts);
    const io_model *model = &file->model;
    const planish_mesh mesh = planish_file_mesh(file);
    assert_memory_equal(mesh.elements, nodes, sizeof nodes);
    assert_true(mesh.coordinates[14] == 1.5);
    assert_int_equal(planish_file_node_number(file, 4), 90);
    assert_int_equal(planish_file_element_number(file, 0), 11);
    assert_int_equal(planish_file_element_number(file, 1), 13);
    assert_int_equal(model->entity[model->tetrahedron.entity[1]].tag, -4);
    assert_int_equal(model->entity[model->triangle.entity[1]].tag, 9);
    assert_int_equal(model->hold[0] & IO_HELD_BY_OTHER, IO_HELD_BY_OTHER);
    assert_int_equal(model->hold[5], IO_HELD_BY_POINT);
    unit_expect_held(file, NULL, "111101");
    unit_expect_held(file, "-4", "111111");
    unit_expect_held(file, "3:3", "111101");
    planish_file_close(file);
}

/* Nodes in VTK's order; see at_place. */
static const unit_element elements[] = {
    {PLANISH_CELL_TRIANGLE, 2, "0 1 2"},      {PLANISH_CELL_QUADRILATERAL, 3, "0 1 2 3"},
    {PLANISH_CELL_TETRAHEDRON, 4, "0 1 2 3"}, {PLANISH_CELL_PYRAMID, 5, "0 1 2 3 4"},
    {PLANISH_CELL_WEDGE, 6, "0 1 2 3 4 5"},   {PLANISH_CELL_HEXAHEDRON, 7, "0 1 2 3 4 5 6 7"},
};
enum { N_ELEMENTS = sizeof elements / sizeof *elements };

/** Return which of the nodes of row i stands at place k in the file. LaGriT, meshio and VTK put the tips
 *  of pyramids first; LaGriT and meshio also the upper sides of prisms and hexahedra. */
static int at_place(int i, int k) {
    static const uint8_t at[][8] = {
        [3] = {4, 0, 1, 2, 3}, [4] = {3, 4, 5, 0, 1, 2}, [5] = {4, 5, 6, 7, 0, 1, 2, 3}};
    return i < 3 ? k : at[i][k];
}

static const char *const names[] = {"pt", "line", "tri", "quad", "tet", "pyr", "prism", "hex"};

static file_builder make_text(int i, int n, double x[UNIT_NODES][3], int variant, int64_t *second) {
    file_builder b = {0};
    *second = variant ? 80 : 2;
    builder_text(&b, "%d 2 0 0 0\n", n);
    for (int k = 0; k < n; k++)
        builder_text(&b, "%d %.17g %.17g %.17g\n", k + variant, x[k][0], x[k][1], x[k][2]);
    for (int e = 0; e < 2; e++) {
        builder_text(&b, "%d 1 %s", e ? (int)*second : 1, names[elements[i].code]);
        for (int k = 0; k < n; k++)
            builder_text(&b, " %d", at_place(i, k) + variant);
        builder_text(&b, "\n");
    }
    return b;
}

/** A binary file; variant: its byte order is big-endian. */
static file_builder make_binary(int i, int n, double x[UNIT_NODES][3], int variant,
                                int64_t *second) {
    file_builder b = {.binary = 1, .swapped = io_machine_is_little() == variant};
    const int head[] = {n, 2, 0, 0, 0, 2 * n};
    *second = 80;
    builder_text(&b, "\7");
    for (int k = 0; k < 6; k++)
        builder_integer(&b, head[k], 4);
    for (int e = 0; e < 2; e++) {
        const int cell[] = {e ? 80 : 1, 1, n, elements[i].code};
        for (int k = 0; k < 4; k++)
            builder_integer(&b, cell[k], 4);
    }
    for (int k = 0; k < 2 * n; k++)
        builder_integer(&b, at_place(i, k % n) + 1, 4);
    for (int d = 0; d < 3; d++)
        for (int k = 0; k < n; k++)
            builder_real(&b, x[k][d], 4);
    return b;
}

static void elements_of_every_type_are_read(void **state) {
    (void)state;
    unit_expect_types(&io_format_ucd, elements, N_ELEMENTS, make_text);
    unit_expect_types(&io_format_ucd, elements, N_ELEMENTS, make_binary);
}

static void materials_are_regions_and_groups(void **state) {
    (void)state;
    file_builder b = {0};
    builder_text(&b, "12 3 0 0 0\n");
    for (int i = 0; i < UNIT_BRICK_NODES; i++)
        builder_text(&b, "%d %g %g %g\n", i + 1, unit_brick_places[i][0], unit_brick_places[i][1],
                     unit_brick_places[i][2]);
    builder_text(&b, "1 4 hex 1 2 5 4 7 8 11 10\n2 7 hex 2 3 6 5 8 9 12 11\n3 9 quad 1 2 5 4\n");
    planish_file *file = builder_file(&b, &io_format_ucd);
    unit_expect_bricks(file, "2:9", "3:7");
    planish_file_close(file);
    builder_release(&b);
}

#define HEAD "4 1 0 0 0\n"
#define FOUR "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
#define TET  "1 1 tet 1 2 3 4\n"

static void wrong_files_are_refused(void **state) {
    (void)state;
    static const reading_refusal cases[] = {
        {"", "five counts"},
        {"4 1 0\n" FOUR TET, "five counts"},
        {"4 1 0 0 0 0\n" FOUR TET, "five counts"},
        {"4 0 0 0 0\n" FOUR, "nothing to smooth"},
        {"4 9 0 0 0\n" FOUR TET, "cannot be in"},
        {"4 2 0 0 0\n" FOUR TET, "cell 2 of 2"},
        {"9 1 0 0 0\n" FOUR TET, "9 nodes cannot be in"},
        {"6 1 0 0 0\n" FOUR "\n\n\n\n\n" TET "6 0 0 0 0", "test:11: node 1: coordinate"},
        {"4 4611686018427387904 0 0 0\n" FOUR TET, "cannot be in"},
        {"4611686018427387904 1 0 0 0\n" FOUR TET, "cannot be in"},
        {"5 1 0 0 0\n" FOUR TET, "test:6: node 1: coordinate"},
        {HEAD "1 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n" TET, "test:2: node 1: coordinate"},
        {HEAD "1 0 0 0 5\n2 1 0 0\n3 0 1 0\n4 0 0 1\n" TET, "three coordinates expected"},
        {HEAD "1 0 0 nan\n2 1 0 0\n3 0 1 0\n4 0 0 1\n" TET, "not finite"},
        {HEAD "1 0 0 1e999\n2 1 0 0\n3 0 1 0\n4 0 0 1\n" TET, "not finite"},
        {HEAD "1 0 0 0\n1 1 0 0\n3 0 1 0\n4 0 0 1\n" TET, "node number 1 occurs twice"},
        {HEAD FOUR "1 1 tet 1 2 3 5\n", "test:6: cell 1: there is no node 5"},
        {HEAD FOUR "1 1 tet 1 2 3 -4\n", "no node -4"},
        {HEAD FOUR "1 1 tet 1 2 3\n", "4 nodes in one line"},
        {HEAD FOUR "1 1 tet 1 2 3 4 1\n", "at most 4"},
        {HEAD FOUR "1 1 hexe 1 2 3 4 1\n", "'hexe' is not a type"},
        {HEAD FOUR "1 1.5 tet 1 2 3 4\n", "its material"},
        {HEAD FOUR "1 2147483648 tet 1 2 3 4\n", "its material"},
        {HEAD FOUR TET TET, "more follows"},
        {HEAD FOUR "1 1 tet2 1 2 3 4 1 2 3 4 1 2\n", "its elements (1) are all of types"},
    };
    reading_refuses(&io_format_ucd, cases, sizeof cases / sizeof *cases);
}

static void binary_files_are_refused(void **state) {
    (void)state;
    static const struct {
        int word; /* of 4 bytes, behind the first byte */
        int64_t value;
        const char *text;
    } cases[] = {{0, 9, "cannot be in"},
                 {1, 2, "no more"},
                 {5, 1 << 20, "cannot be in"},
                 {5, 5, "more nodes than the cells"},
                 {8, 5, "more nodes than the 4"},
                 {8, 3, "cannot have 3 nodes"},
                 {8, 21, "cannot have 21 nodes"},
                 {9, 8, "type 8, which is unknown"},
                 {9, -1, "type -1, which is unknown"},
                 {10, 0, "no node 0"},
                 {13, 5, "no node 5"},
                 {14, 0x7fc00000, "not finite"}};
    double x[UNIT_NODES][3];
    int64_t second;
    const int n = unit_places(PLANISH_CELL_TETRAHEDRON, "0 1 2 3", x);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        file_builder b = {.binary = 1};
        const int head[] = {n, 1, 0, 0, 0, n, 1, 1, n, 4, 1, 2, 3, 4};
        builder_text(&b, "\7");
        for (int k = 0; k < 14; k++)
            builder_integer(&b, cases[i].word == k ? cases[i].value : head[k], 4);
        for (int k = 0; k < 3 * n + (cases[i].word == 5); k++) {
            if (cases[i].word == 14 && k == 0)
                builder_integer(&b, cases[i].value, 4);
            else
                builder_real(&b, x[k % n][k / n % 3], 4);
        }
        if (cases[i].word != 1) /* whose cells are read from what follows */
            builder_expect_error(&b, &io_format_ucd, cases[i].text);
        builder_release(&b);
    }
    file_builder b = make_binary(2, n, x, 0, &second);
    planish_file *file;
    planish_error error;
    for (b.size--; b.size > 0; b.size--)
        assert_true(builder_read(&b, &io_format_ucd, 1, &file, &error) < 0);
    builder_release(&b);
}

static void files_are_cut_anywhere(void **state) {
    (void)state;
    double x[UNIT_NODES][3];
    int64_t second;
    file_builder text = builder_of(solid);
    builder_try_to_break(&text, &io_format_ucd);
    file_builder b =
        make_binary(5, unit_places(PLANISH_CELL_HEXAHEDRON, elements[5].nodes, x), x, 1, &second);
    builder_try_to_break(&b, &io_format_ucd);
    builder_release(&b);
}

static void nothing_but_coordinates_changes(void **state) {
    rewriting_keeps_the_rest(&io_format_ucd, solid, sizeof solid - 1, *state);
    for (int variant = 0; variant < 2; variant++) {
        double x[UNIT_NODES][3];
        int64_t second;
        file_builder b = make_binary(5, unit_places(PLANISH_CELL_HEXAHEDRON, elements[5].nodes, x),
                                     x, variant, &second);
        builder_text(&b, "data");
        rewriting_keeps_the_rest(&io_format_ucd, b.data, b.size, *state);
        builder_release(&b);
        /* In a plane only x and y are written. */
        b = make_binary(0, unit_places(PLANISH_CELL_TRIANGLE, elements[0].nodes, x), x, variant,
                        &second);
        rewriting_keeps_the_rest(&io_format_ucd, b.data, b.size, *state);
        builder_release(&b);
    }
    rewriting_gives(&io_format_ucd, HEAD "\n1  0 0.0 0 \n2 1 0 0\n3 0 1 0\n\n4 0 0 1\n" TET, "xz",
                    HEAD "\n1  0.125 0.0 123456.789 \n2 1 0 0\n3 0 1 0\n\n4 0 0 1\n" TET, *state);
}

/** Runs of two types, each worth threads. */
static void threads_read_the_same(void **state) {
    (void)state;
    enum { N = 30000 };
    file_builder b = {0};
    builder_text(&b, "%d %d 0 0 0\n", 2 * N, 2 * N - 8);
    for (int i = 0; i < 2 * N; i++)
        builder_text(&b, "%d %d.25 %d %d\n", i + 1, i / 2, i % 2, i % 7);
    for (int i = 0; i < N - 4; i++)
        builder_text(&b, "%d %d tet %d %d %d %d\n", i + 1, i / 100, i + 1, i + 2, i + 3, i + 4);
    for (int i = 0; i < N - 4; i++)
        builder_text(&b, "%d 7 pyr %d %d %d %d %d\n", N + i, i + 1, i + 2, i + 3, i + 4, i + 5);
    builder_expect_same_on_threads(&b, &io_format_ucd);
    builder_release(&b);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ucd_is_told),
        cmocka_unit_test(others_are_not),
        cmocka_unit_test(a_solid_is_read),
        cmocka_unit_test(elements_of_every_type_are_read),
        cmocka_unit_test(materials_are_regions_and_groups),
        cmocka_unit_test(wrong_files_are_refused),
        cmocka_unit_test(binary_files_are_refused),
        cmocka_unit_test(files_are_cut_anywhere),
        cmocka_unit_test(nothing_but_coordinates_changes),
        cmocka_unit_test(threads_read_the_same),
    };
    return cmocka_run_group_tests(tests, test_folder_create, test_folder_remove);
}
