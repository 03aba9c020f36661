/* Medit: what is read, what is held, what is refused. */
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
    assert_int_equal(info.precision, PLANISH_PRECISION_DOUBLE);
    assert_int_equal(planish_file_element_number(file, 1), 2);
    assert_int_equal(planish_file_node_number(file, 5), 6);
    assert_int_equal(file->model.hold[0], IO_HELD_BY_LINE | IO_HELD_BY_FACE);
    assert_int_equal(file->model.hold[5], IO_HELD_REQUIRED);
    assert_int_equal(file->model.hold[4], 0);
    assert_memory_equal(solid + file->model.text_offset[4], "1 1 1.5e0", 9);
    planish_file_close(file);
}

static void nodes_are_held(void **state) {
    (void)state;
    planish_file *file = reading_text(&io_format_medit, solid);
    reading_holds(file, NULL, READING_REGIONS, "111101"); /* 1 2 3: also between regions */
    reading_holds(file, NULL, 0, "111001");
    reading_holds(file, "8", 0, "111111");
    reading_holds(file, "3:8", 0, "111111");
    reading_holds(file, "0:3", 0, "111011");
    uint8_t constraint[6];
    planish_error error;
    const char *unknown = "2:8";
    const planish_hold hold = {.tags = &unknown, .n_tags = 1};
    assert_int_equal(planish_file_constraints(file, &hold, constraint, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "3:7"));
    planish_file_close(file);
}

/** Programs that do not heed versions write 0, and doubles. */
static void a_text_may_have_version_0(void **state) {
    (void)state;
    planish_file *file =
        reading_text(&io_format_medit, "MeshVersionFormatted 0 Dimension 2 Vertices 3 0 0 0 "
                                       "1 0 0 0.1 1 0 Triangles 1 1 2 3 1 End");
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(info.precision, PLANISH_PRECISION_DOUBLE);
    assert_true(planish_file_mesh(file).coordinates[4] == 0.1);
    planish_file_close(file);
    reading_fails(&io_format_medit, "MeshVersionFormatted -1 Dimension 2 End", "-1 is unknown");
    reading_fails(&io_format_medit, "MeshVersionFormatted 5 Dimension 2 End", "5 is unknown");
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
    assert_int_equal(mesh.n_elements, 3);
    assert_int_equal(info.precision, PLANISH_PRECISION_FLOAT); /* version 1 */
    volatile float tenth = 0.1f;
    assert_true(mesh.coordinates[6] == tenth);
    assert_int_equal(info.n_other_elements, 0);
    assert_int_equal(file->model.hold[1], 0);
    assert_int_equal(file->model.hold[3], IO_HELD_REQUIRED);
    planish_file_close(file);
}

/** Planes may be as rough as digits are few, but no more than 1e-5. */
static void digits_tell_how_rough_planes_may_be(void **state) {
    (void)state;
    static const struct {
        const char *x;
        double tolerance; /* 0: the library's own */
    } cases[] = {{"1.25", 1e-5},      {"1.23456", 1e-5},    {"1.234567", 1e-6},
                 {"1.2345678", 1e-7}, {"1.23456789", 1e-8}, {"1.2345678912", 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[256];
        snprintf(text, sizeof text,
                 "MeshVersionFormatted 2 Dimension 2 Vertices 3 0 0 0 %s 0 0 0 1 0 "
                 "Triangles 1 1 2 3 0 End",
                 cases[i].x);
        planish_file *file = reading_text(&io_format_medit, text);
        const double found = planish_file_surface(file, NULL).tolerance;
        if (!(fabs(found - cases[i].tolerance) <= 1e-9 * cases[i].tolerance))
            fail_msg("%s: tolerance %g", cases[i].x, found);
        planish_file_close(file);
    }
}

/** What is required holds its nodes, of every dimension. */
static void required_elements_hold_their_nodes(void **state) {
    (void)state;
    static const char mesh[] =
        "MeshVersionFormatted 2 Dimension 3 Vertices 5 0 0 0 0 1 0 0 0 0 1 0 0 "
        "0 0 1 0 1 1 1 0 Tetrahedra 2 1 2 3 4 0 2 3 4 5 0 Triangles 1 2 3 5 0 "
        "Edges 2 1 2 0 4 5 0 Quadrilaterals 2 1 2 3 4 0 1 2 4 5 0 %s 1 %d End";
    static const struct {
        const char *section;
        int number, held[5];
    } cases[] = {
        {"RequiredVertices", 3, {0, 0, 1, 0, 0}},       {"Corners", 5, {0, 0, 0, 0, 1}},
        {"RequiredEdges", 2, {0, 0, 0, 1, 1}},          {"RequiredTriangles", 1, {0, 1, 1, 0, 1}},
        {"RequiredQuadrilaterals", 2, {1, 1, 0, 1, 1}}, {"RequiredTetrahedra", 2, {0, 1, 1, 1, 1}}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[512];
        snprintf(text, sizeof text, mesh, cases[i].section, cases[i].number);
        planish_file *file = reading_text(&io_format_medit, text);
        for (int k = 0; k < 5; k++)
            assert_int_equal((file->model.hold[k] & IO_HELD_REQUIRED) != 0, cases[i].held[k]);
        planish_file_close(file);
    }
}

/** TetGen lists all facets: those inside say nothing. A surface is fewer, and may well have
 *  reference 0. */
static void all_facets_are_no_surface(void **state) {
    (void)state;
    static const char mesh[] =
        "MeshVersionFormatted 2 Dimension 3 Vertices 5 0 0 0 0 1 0 0 0 0 1 0 0 "
        "0 0 1 0 1 1 1 0 Tetrahedra 2 1 2 3 4 0 2 3 4 5 0 RequiredTriangles 1 2 "
        "Triangles %s End";
    static const struct {
        const char *triangles;
        int held_1, n;
    } cases[] = {
        {"7 1 2 3 0 2 3 4 0 1 2 4 0 1 3 4 0 2 3 5 4 2 4 5 4 3 4 5 4", IO_HELD_BY_FACE, 6},
        {"4 1 2 3 0 2 3 4 0 1 2 4 0 1 3 4 0", IO_HELD_BY_FACE, 4},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[512];
        planish_file_info info;
        snprintf(text, sizeof text, mesh, cases[i].triangles);
        planish_file *file = reading_text(&io_format_medit, text);
        assert_int_equal(file->model.hold[0], cases[i].held_1);
        assert_int_equal(file->model.hold[1], IO_HELD_BY_FACE | IO_HELD_REQUIRED);
        assert_int_equal(file->model.hold[4], i == 0 ? IO_HELD_BY_FACE : 0);
        assert_int_equal(planish_file_surface(file, NULL).n_facets, cases[i].n);
        planish_file_get_info(file, &info);
        assert_int_equal(info.n_lower_elements, i == 0 ? 7 : 4);
        planish_file_close(file);
    }
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

/** Nodes of elements that hold theirs and of those of second order, and the same order as an ..Ordering says it. */
static const struct {
    const char *name, *nodes;
    int type;
    const char *ordering;
} others[] = {
    {"Quadrilaterals", "1 2 3 4", PLANISH_CELL_QUADRILATERAL, NULL},
    {"Pyramids", "1 2 3 4 5", PLANISH_CELL_PYRAMID, NULL},
    {"Prisms", "1 2 3 4 5 6", PLANISH_CELL_WEDGE, NULL},
    {"Hexahedra", "1 2 3 4 5 6 7 8", PLANISH_CELL_HEXAHEDRON, NULL},
    {"TrianglesP2", "1 2 3 12 23 31", PLANISH_CELL_TRIANGLE6, NULL},
    {"TrianglesP2", "1 12 2 23 3 31", PLANISH_CELL_TRIANGLE6, "200 110 020 011 002 101"},
    {"QuadrilateralsQ2", "1 2 3 4 12 23 34 41 1234", PLANISH_CELL_QUADRILATERAL9, NULL},
    {"QuadrilateralsQ2", "1 12 2 41 1234 23 4 34 3", PLANISH_CELL_QUADRILATERAL9,
     "00 10 20 01 11 21 02 12 22"},
    {"TetrahedraP2", "1 2 3 4 12 23 31 14 24 34", PLANISH_CELL_TETRAHEDRON10, NULL},
    {"TetrahedraP2", "1 2 3 4 12 23 31 14 34 24", PLANISH_CELL_TETRAHEDRON10,
     "2000 0200 0020 0002 1100 0110 1010 1001 0011 0101"},
    {"HexahedraQ2",
     "1 2 3 4 5 6 7 8 12 23 34 41 56 67 78 85 15 26 37 48 1234 1265 2376 3487 4158 5678 12345678",
     PLANISH_CELL_HEXAHEDRON27, NULL},
    {"HexahedraQ2",
     "1 2 3 4 5 6 7 8 12 23 34 41 56 67 78 85 15 26 37 48 1234 5678 1265 2376 3487 4158 12345678",
     PLANISH_CELL_HEXAHEDRON27,
     "000 200 220 020 002 202 222 022 100 210 120 010 102 212 122 012 001 201 221 021 110 112 101 "
     "211 "
     "121 011 111"},
    {"PrismsP2", "1 2 3 4 5 6 12 23 31 45 56 64 14 25 36 1254 2365 3146", PLANISH_CELL_WEDGE18,
     NULL},
    {"PrismsP2", "1 2 3 12 23 31 14 25 36 1254 2365 3146 4 5 6 45 56 64", PLANISH_CELL_WEDGE18,
     "2000 0200 0020 1100 0110 1010 2001 0201 0021 1101 0111 1011 2002 0202 0022 1102 0112 1012"},
    {"PyramidsP2", "1 2 3 4 5 12 23 34 41 15 25 35 45 1234", PLANISH_CELL_PYRAMID14, NULL},
};

/** Write a file of one element. */
static void write_element(char *text, size_t size, size_t i, int n, double x[UNIT_NODES][3]) {
    const int dim = unit_dim(others[i].type);
    int length =
        snprintf(text, size, "MeshVersionFormatted 2\nDimension %d\n%s\n1\n", dim, others[i].name);
    for (int j = 0; j < n; j++)
        length += snprintf(text + length, size - (size_t)length, "%d ", j + 1);
    length += snprintf(text + length, size - (size_t)length, "5\nVertices\n%d\n", n);
    for (int j = 0; j < n; j++)
        for (int d = 0; d <= dim; d++)
            length += snprintf(text + length, size - (size_t)length, d < dim ? "%.8f " : "1\n",
                               x[j][d % 3]);
    if (others[i].ordering) {
        length +=
            snprintf(text + length, size - (size_t)length, "%sOrdering\n%d\n", others[i].name, n);
        for (const char *c = others[i].ordering; *c; c++)
            length += snprintf(text + length, size - (size_t)length, *c == ' ' ? "\n" : "%c ", *c);
    }
    snprintf(text + length, size - (size_t)length, "\nEnd\n");
}

static void every_type_has_its_nodes_in_order(void **state) {
    (void)state;
    char text[4096];
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        for (int swapped = 0; swapped < 2; swapped++) {
            double x[UNIT_NODES][3];
            const int n = unit_places(others[i].type, others[i].nodes, x);
            if (swapped)
                unit_swap(others[i].type, n, x);
            write_element(text, sizeof text, i, n, x);
            unit_expect_alone(reading_text(&io_format_medit, text), others[i].type, 1,
                              unit_is_smoothed(others[i].type) ? 0 : n, !swapped);
            reading_every_beginning(&io_format_medit, text, (int64_t)strlen(text));
        }
}

/** Places that no node has, or two have, and edges of second order. */
static void orders_are_checked(void **state) {
    (void)state;
    const io_format *f = &io_format_medit;
    reading_fails(f, HEAD NODES "TrianglesP2Ordering 5 2 0 0 0 2 0 0 0 2 1 1 0 0 1 1\n",
                  "5 places, but the elements have 6 nodes");
    reading_fails(f, HEAD NODES "TrianglesP2Ordering 6 2 0 0 0 2 0 0 0 2 1 1 0 0 1 1 1 1 0\n",
                  "TrianglesP2Ordering 6: there is a node at that place already");
    reading_fails(f, HEAD NODES "TrianglesP2Ordering 6 2 0 0 0 2 0 0 0 2 1 1 0 0 1 1 1 1 1\n",
                  "TrianglesP2Ordering 6: there is no node at that place");
    reading_fails(f, HEAD NODES "TrianglesP2Ordering 6 2 0 0 0 2 0 0 0 2 1 1 0 0 1 1 1 0 3\n",
                  "number 3 is not in 0 .. 2");
    for (int is_said = 0; is_said < 2; is_said++) {
        planish_file *file = reading_text(
            f, is_said ? HEAD NODES
                   "Tetrahedra 1 1 2 3 4 0 EdgesP2 1 1 3 2 0 EdgesP2Ordering 3 2 1 0 End"
                       : HEAD NODES "Tetrahedra 1 1 2 3 4 0 EdgesP2 1 1 2 3 0 End");
        assert_int_equal(file->model.line.nodes[0] + file->model.line.nodes[1], 1);
        assert_int_equal(file->model.line.mid[0], 2);
        assert_int_equal(file->model.hold[2], IO_HELD_BY_LINE);
        assert_int_equal(file->model.hold[3], 0);
        planish_file_close(file);
    }
}

#define TEN                                                                                        \
    HEAD "Vertices\n10\n0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 0 .5 0 0 0 .5 .5 0 0 0 .5 0 0 0 0 .5 0 "     \
         ".5 0 .5 0 0 .5 .5 0\nTetrahedraP2 1 1 2 3 4 5 6 7 8 9 10 0\n"

/** Required elements of second order hold mids; indices are of elements of first order where there are
 *  any, wherever these stand. */
static void required_elements_have_mids(void **state) {
    (void)state;
    static const struct {
        const char *text, *held;
        uint8_t bit;
    } cases[] = {{TEN "RequiredTetrahedra 1 1 End", "1111111111", IO_HELD_REQUIRED},
                 {TEN "RequiredTriangles 1 1 TrianglesP2 1 2 3 4 6 10 9 0 Triangles 1 1 2 3 0 End",
                  "1110000000", IO_HELD_REQUIRED},
                 {TEN "TrianglesP2 1 1 2 3 5 6 7 0 End", "1110111000", IO_HELD_BY_FACE}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        planish_file *file = reading_text(&io_format_medit, cases[i].text);
        for (int k = 0; cases[i].held[k]; k++)
            assert_int_equal((file->model.hold[k] & cases[i].bit) != 0, cases[i].held[k] == '1');
        planish_file_close(file);
    }
}

static void mids_are_written_as_other_nodes(void **state) {
    static const char text[] = TEN "TrianglesP2 1 1 2 3 5 6 7 0 End\n";
    rewriting_keeps_the_rest(&io_format_medit, text, sizeof text - 1, *state);
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
    reading_fails(f,
                  "MeshVersionFormatted 2\nVertices\n5\n0 0 0 0\n1 0 0 0\n0 1 0 0\nDimension 3\n",
                  "5 Vertices cannot be in the 37 bytes");
    reading_fails(f, HEAD "Vertices\n2\n0 0 nan 0 0 0 0 0 Tetrahedra 0", "not finite");
    reading_fails(f, HEAD "Vertices\n1\n0 0 1e999 0\n", "not finite");
    reading_fails(f, HEAD NODES NODES, "second time");
    reading_fails(f, HEAD NODES "TetrahedraP2 1 1 2 3 4 1 2 3 4 1 5 0\n", "not in 1 .. 4");
    reading_fails(f, HEAD NODES "TetrahedraP2 1 1 2 3 4 1 2 3 4 1 1 0 2\n", "more than 1");
    reading_fails(f, HEAD "TetrahedraP3 1 1\n", "first or second order");
    reading_fails(f, "MeshVersionFormatted 9\n", "unknown");
    reading_fails(f, "MeshVersionFormatted 2\nDimension 4\n", "unknown");
    reading_fails(f, HEAD, "no Vertices");
    reading_gives_surface(f, HEAD
                          "Vertices 4 0 0 0 0 1 0 0 0 0 1 1 0 1 1 0 0 Triangles 2 1 2 3 0 2 4 3 0");
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

/* ---- binary ------------------------------------------------------------------------------- */

/** A binary file of some version. */
typedef struct meshb {
    file_builder b;
    int version;
} meshb;

static int integer_size(const meshb *m) {
    return m->version < 4 ? 4 : 8;
}

static int position_size(const meshb *m) {
    return m->version < 3 ? 4 : 8;
}

static int real_size(const meshb *m) {
    return m->version == 1 ? 4 : 8;
}

static void meshb_begin(meshb *m, int version, int swapped, int dim) {
    *m = (meshb){.b = {.binary = 1, .swapped = swapped}, .version = version};
    builder_integer(&m->b, 1, 4);
    builder_integer(&m->b, version, 4);
    builder_integer(&m->b, 3, 4);
    builder_integer(&m->b, builder_place(&m->b) + position_size(m) + 4, position_size(m));
    builder_integer(&m->b, dim, 4);
}

/** A keyword with count records of size bytes: the next is at where this ends and gap further. */
static void meshb_keyword(meshb *m, int code, int64_t count, int64_t size, int64_t gap) {
    builder_integer(&m->b, code, 4);
    builder_integer(&m->b,
                    builder_place(&m->b) + position_size(m) + integer_size(m) + count * size + gap,
                    position_size(m));
    builder_integer(&m->b, count, integer_size(m));
}

static void meshb_vertices(meshb *m, int64_t n, int dim, const double *xyz) {
    meshb_keyword(m, 4, n, dim * real_size(m) + integer_size(m), 0);
    for (int64_t i = 0; i < n; i++) {
        for (int d = 0; d < dim; d++)
            builder_real(&m->b, xyz[dim * i + d], real_size(m));
        builder_integer(&m->b, i % 3 - 1, integer_size(m));
    }
}

static void meshb_integers(meshb *m, int code, int64_t n, int width, const int *numbers) {
    meshb_keyword(m, code, n, width * integer_size(m), 0);
    for (int64_t i = 0; i < n * width; i++)
        builder_integer(&m->b, numbers[i], integer_size(m));
}

static void meshb_end(meshb *m) {
    builder_integer(&m->b, 54, 4);
    builder_integer(&m->b, 0, position_size(m));
}

static const double points[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0,   0, 1, 1, 1, 1.5,
                                9, 9, 9, 8, 8, 8, 7, 7, 7, 0.1, 6, 6, 5, 5, 5};
enum { N_POINTS = 10 };

/** Everything: tetrahedra before vertices, regions, an unknown keyword, bytes between sections. */
static void build_solid(meshb *m, int version, int swapped) {
    static const int tetrahedra[] = {1, 2, 3, 4, 7, 2, 3, 4, 5, -8}, triangle[] = {1, 2, 3, 4};
    static const int edge[] = {1, 2, 0}, required[] = {6}, of_tetrahedra[] = {2}, corner[] = {7};
    static const int pyramid[] = {5, 6, 7, 8, 9, 1}, pair[] = {9, 10}, ridge[] = {1};
    meshb_begin(m, version, swapped, 3);
    meshb_integers(m, 8, 2, 5, tetrahedra);
    meshb_vertices(m, N_POINTS, 3, points);
    meshb_integers(m, 6, 1, 4, triangle);
    meshb_keyword(m, 60, 1, 12, 5); /* normals, and what nobody knows of */
    builder_text(&m->b, "twelve bytesabcde");
    meshb_integers(m, 5, 1, 3, edge);
    meshb_integers(m, 14, 1, 1, ridge);
    meshb_integers(m, 15, 1, 1, required);
    meshb_integers(m, 12, 1, 1, of_tetrahedra);
    meshb_integers(m, 13, 1, 1, corner);
    meshb_integers(m, 49, 1, 6, pyramid);
    meshb_integers(m, 82, 1, 2, pair);
    meshb_end(m);
}

static void check_solid(const planish_file *file, int version) {
    static const int32_t elements[] = {0, 1, 2, 3, 1, 2, 3, 4};
    static const uint8_t held[N_POINTS] = {IO_HELD_BY_LINE | IO_HELD_BY_FACE,
                                           IO_HELD_BY_LINE | IO_HELD_BY_FACE | IO_HELD_REQUIRED,
                                           IO_HELD_BY_FACE | IO_HELD_REQUIRED,
                                           IO_HELD_REQUIRED,
                                           IO_HELD_REQUIRED,
                                           IO_HELD_REQUIRED,
                                           IO_HELD_REQUIRED,
                                           0,
                                           IO_HELD_PERIODIC,
                                           IO_HELD_PERIODIC};
    planish_mesh mesh = planish_file_mesh(file);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(mesh.dim, 3);
    assert_int_equal(mesh.n_nodes, N_POINTS);
    assert_int_equal(mesh.n_elements, 3);
    assert_memory_equal(mesh.cells->node, elements, sizeof elements);
    for (int i = 0; i < 3 * N_POINTS; i++) {
        volatile float single = (float)points[i];
        assert_true(mesh.coordinates[i] == (version == 1 ? (double)single : points[i]));
    }
    assert_memory_equal(file->model.hold, held, sizeof held);
    assert_int_equal(info.precision,
                     version == 1 ? PLANISH_PRECISION_FLOAT : PLANISH_PRECISION_DOUBLE);
    assert_int_equal(info.n_regions, 3);
    assert_int_equal(info.n_lower_elements, 2);
    assert_int_equal(info.n_other_elements, 0);
    assert_int_equal(mesh.n_periodic, 1);
    assert_int_equal(mesh.periodic[0], 8);
    assert_int_equal(mesh.periodic[1], 9);
    assert_int_equal(file->model.entity[file->model.tetrahedron.entity[1]].tag, -8);
    assert_int_equal(file->model.entity[file->model.node_entity[3]].tag, -1);
    assert_int_equal(planish_file_node_number(file, 5), 6);
    static const char *const lost[] = {"Normals", "Ridges", "RequiredTetrahedra", "Corners"};
    assert_int_equal(file->model.not_carried.n, 4);
    for (int i = 0; i < 4; i++)
        assert_string_equal(file->model.not_carried.name[i], lost[i]);
}

static void binary_files_are_read_and_written(void **state) {
    for (int version = 1; version <= 4; version++)
        for (int swapped = 0; swapped < 2; swapped++) {
            meshb m;
            build_solid(&m, version, swapped);
            assert_true(io_format_medit.recognise(m.b.data, m.b.size));
            planish_file *file = builder_file(&m.b, &io_format_medit);
            check_solid(file, version);
            planish_file_close(file);
            builder_try_to_break(&m.b, &io_format_medit);
            rewriting_keeps_the_rest(&io_format_medit, m.b.data, m.b.size, *state);
            builder_release(&m.b);
        }
}

static void a_binary_plane_is_read_and_written(void **state) {
    static const double square[] = {0, 0, 1, 0, 1, 1, 0, 1};
    static const int triangles[] = {1, 2, 3, 1, 1, 3, 4, 1};
    for (int version = 1; version <= 4; version++) {
        meshb m;
        meshb_begin(&m, version, 0, 2);
        meshb_vertices(&m, 4, 2, square);
        meshb_integers(&m, 6, 2, 4, triangles);
        planish_file *file = builder_file(&m.b, &io_format_medit); /* no End */
        assert_int_equal(planish_file_mesh(file).dim, 2);
        assert_memory_equal(planish_file_mesh(file).coordinates, square, sizeof square);
        planish_file_close(file);
        rewriting_keeps_the_rest(&io_format_medit, m.b.data, m.b.size, *state);
        builder_release(&m.b);
    }
}

/** Other programs go by the extension. */
static void text_and_binary_have_their_names(void **state) {
    (void)state;
    meshb m;
    planish_file *binary, *text = reading_text(&io_format_medit, solid);
    planish_error error;
    build_solid(&m, 2, 0);
    assert_int_equal(builder_read(&m.b, &io_format_medit, 1, &binary, &error), 0);
    assert_true(planish_file_can_write(text, "out.mesh"));
    assert_false(planish_file_can_write(text, "out.meshb"));
    assert_true(planish_file_can_write(binary, "out.MESHB"));
    assert_false(planish_file_can_write(binary, "out.mesh"));
    planish_file_close(text);
    planish_file_close(binary);
    builder_release(&m.b);
}

static void the_last_section_may_point_nowhere(void **state) {
    (void)state;
    static const int tetrahedron[] = {1, 2, 3, 4, 0};
    meshb m;
    meshb_begin(&m, 2, 0, 3);
    meshb_vertices(&m, 4, 3, points);
    builder_integer(&m.b, 8, 4);
    builder_integer(&m.b, 0, 4);
    builder_integer(&m.b, 1, 4);
    for (int i = 0; i < 5; i++)
        builder_integer(&m.b, tetrahedron[i], 4);
    planish_file *file = builder_file(&m.b, &io_format_medit);
    assert_int_equal(planish_file_mesh(file).n_elements, 1);
    planish_file_close(file);
    builder_release(&m.b);
}

/** A file of four vertices, and what is added to it, is refused. */
static void refused(int version, int code, int64_t next, int64_t count, const char *word) {
    meshb m;
    meshb_begin(&m, version, 0, 3);
    meshb_vertices(&m, 4, 3, points);
    builder_integer(&m.b, code, 4);
    const int64_t size = position_size(&m) + integer_size(&m) + 40;
    builder_integer(&m.b,
                    next < 0 ? next
                    : next   ? next
                             : builder_place(&m.b) + size,
                    position_size(&m));
    builder_integer(&m.b, count, integer_size(&m));
    for (int i = 0; i < 10; i++)
        builder_integer(&m.b, i + 1, 4);
    meshb_end(&m);
    builder_expect_error(&m.b, &io_format_medit, word);
    builder_release(&m.b);
}

static void wrong_binary_files_are_refused(void **state) {
    (void)state;
    refused(2, 8, 0, 2, "byte 176: Tetrahedra 2: number 6 is not in 1 .. 4");
    refused(2, 8, 0, 3, "3 Tetrahedra cannot be in the 40 bytes");
    refused(2, 8, 0, -1, "cannot be in");
    refused(2, 8, 0, INT32_MAX, "cannot be in");
    refused(4, 8, 0, INT64_MAX, "cannot be in");
    refused(4, 8, 0, INT64_MIN, "cannot be in");
    refused(4, 8, INT64_MAX, 1, "behind the end");
    refused(4, 8, INT64_MIN, 1, "not behind this one");
    refused(2, 8, 1000000, 1, "behind the end");
    refused(2, 8, 20, 1, "not behind this one");  /* round and round */
    refused(2, 60, 20, 1, "not behind this one"); /* and by what is passed over */
    refused(2, 60, -1, 1, "not behind this one");
    refused(2, 4, 0, 1, "second time");
    refused(2, 30, 0, 1, "1 TetrahedraP2 cannot be in");
    refused(2, 96, 0, 1, "first or second order");
    refused(2, 97, 0, 1, "TetrahedraP4");
    refused(2, 54, 0, 1, "nothing to smooth");
    refused(2, 99999, 0, 1, "nothing to smooth");
    /* Two numbers of 32 bits as one. */
    refused(4, 13, 0, 1,
            io_machine_is_little() ? "Corners 1: number 8589934593 is not in 1 .. 4"
                                   : "Corners 1: number 4294967298 is not in 1 .. 4");
}

static void binary_values_that_cannot_be(void **state) {
    (void)state;
    static const double not_finite[] = {0, 0, 0, 1, NAN, 0, 0, 1, 0, 0, 0, 1};
    meshb m;
    meshb_begin(&m, 1, 1, 3);
    meshb_vertices(&m, 4, 3, not_finite);
    meshb_end(&m);
    /* 20 bytes of the header, 12 of the keyword, a vertex of 16 and a coordinate */
    builder_expect_error(&m.b, &io_format_medit, "file: byte 52: node 2");
    builder_release(&m.b);
    meshb_begin(&m, 4, 0, 3);
    meshb_keyword(&m, 4, 1, 32, 0);
    for (int i = 0; i < 3; i++)
        builder_real(&m.b, 0, 8);
    builder_integer(&m.b, INT64_C(1) << 40, 8);
    meshb_end(&m);
    builder_expect_error(&m.b, &io_format_medit, "is not in -2147483648 .. 2147483647");
    builder_release(&m.b);
    meshb_begin(&m, 2, 0, 4);
    builder_expect_error(&m.b, &io_format_medit, "Dimension 4");
    builder_release(&m.b);
    meshb_begin(&m, 5, 0, 3);
    assert_false(io_format_medit.recognise(m.b.data, m.b.size));
    builder_release(&m.b);
}

/** Large enough for the parallel path. */
static void threads_read_binary_files(void **state) {
    (void)state;
    enum { N = 120000 };
    double *xyz = malloc(3 * N * sizeof *xyz);
    int *nodes = malloc(5 * N * sizeof *nodes);
    meshb m;
    for (int i = 0; i < 3 * N; i++)
        xyz[i] = i * 7 % 1000 + 0.1 * (i % 13);
    for (int i = 0; i < 5 * N; i++)
        nodes[i] = i % 5 == 4 ? 1 + i % 3 : 1 + (i / 5 + i % 5) % N;
    for (int version = 1; version <= 4; version += 3) {
        meshb_begin(&m, version, version == 1, 3);
        meshb_vertices(&m, N, 3, xyz);
        meshb_integers(&m, 8, N, 5, nodes);
        meshb_integers(&m, 6, N, 4, nodes);
        meshb_integers(&m, 10, N / 2, 9, nodes);
        meshb_integers(&m, 9, N / 2, 7, nodes);
        meshb_end(&m);
        builder_expect_same_on_threads(&m.b, &io_format_medit);
        builder_release(&m.b);
    }
    free(xyz);
    free(nodes);
}

static void text_is_written(void **state) {
    rewriting_keeps_the_rest(&io_format_medit, solid, (int64_t)strlen(solid), *state);
}

static void elements_and_pairs_that_text_holds(void **state) {
    (void)state;
    planish_file *file =
        reading_text(&io_format_medit, HEAD NODES "Tetrahedra 1 1 2 3 4 0 PeriodicVertices 1 1 2 "
                                                  "QuadrilateralsQ2 1 3 3 3 3 3 3 3 3 3 5 End");
    assert_int_equal(file->model.n_periodic, 1);
    assert_int_equal(file->model.hold[0], IO_HELD_PERIODIC);
    assert_int_equal(file->model.hold[2], IO_HELD_BY_FACE);
    assert_int_equal(file->model.hold[3], 0);
    planish_file_close(file);
    reading_fails(&io_format_medit, HEAD NODES "PeriodicVertices 1 1 5 End", "not in 1 .. 4");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_solid_is_read),
        cmocka_unit_test(nodes_are_held),
        cmocka_unit_test(a_text_may_have_version_0),
        cmocka_unit_test(a_plane_is_read),
        cmocka_unit_test(digits_tell_how_rough_planes_may_be),
        cmocka_unit_test(required_elements_hold_their_nodes),
        cmocka_unit_test(all_facets_are_no_surface),
        cmocka_unit_test(sections_may_stand_in_any_order),
        cmocka_unit_test(comments_are_no_keywords),
        cmocka_unit_test(every_type_has_its_nodes_in_order),
        cmocka_unit_test(orders_are_checked),
        cmocka_unit_test(required_elements_have_mids),
        cmocka_unit_test(mids_are_written_as_other_nodes),
        cmocka_unit_test(wrong_files_are_refused),
        cmocka_unit_test(every_beginning_is_survived),
        cmocka_unit_test(many_threads_read_the_same),
        cmocka_unit_test(comments_do_not_misplace_records),
        cmocka_unit_test(binary_files_are_read_and_written),
        cmocka_unit_test(a_binary_plane_is_read_and_written),
        cmocka_unit_test(text_and_binary_have_their_names),
        cmocka_unit_test(the_last_section_may_point_nowhere),
        cmocka_unit_test(wrong_binary_files_are_refused),
        cmocka_unit_test(binary_values_that_cannot_be),
        cmocka_unit_test(threads_read_binary_files),
        cmocka_unit_test(text_is_written),
        cmocka_unit_test(elements_and_pairs_that_text_holds),
    };
    return cmocka_run_group_tests(tests, test_folder_create, test_folder_remove);
}
