/* UNV: what is read, held, refused and written. */
#include "io/core/number.h"
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

#define END               "    -1\n"
#define NODE(number, xyz) "         " number "         1         1        11\n" xyz "\n"
#define FOUR                                                                                       \
    END "  2411\n" NODE(                                                                           \
        "1", "   0.0000000000000000D+00   0.0000000000000000D+00   0.0000000000000000D+00")        \
        NODE("2", "   1.0000000000000000D+00   0.0000000000000000D+00   0.0000000000000000D+00")   \
            NODE("3",                                                                              \
                 "   0.0000000000000000D+00   1.0000000000000000D+00   0.0000000000000000D+00")    \
                NODE(                                                                              \
                    "4",                                                                           \
                    "   0.0000000000000000D+00   0.0000000000000000D+00   1.0000000000000000D+00") \
                    END
#define TET END "  2412\n 1 111 1 1 7 4\n 1 2 3 4\n" END

/* All that a file may have: units, nodes in several datasets and in columns without blanks, elements
 * of every kind, groups of both kinds, unknown datasets. */
static const char solid[] =
    "\n" END "   151\nname\n-1.0\n" END END
    "   164\n         1  SI: Meters\n  1.0D+00  1.0D+00\n" END END
    "  2411\n" NODE("7", "0.0  0.0 0\n")
        NODE("3", "   1.0000000000000000D+00   0.0000000000000000E+00   0.0000000000000000D+00")
            NODE("2", "-0.0000000000000000D+0000 1.0000000000000000D+0000-0.0000000000000000D+0000")
                NODE("9", "0 0 1.") END END
    "   781\n" NODE(
        "90", "                      1.0                     1.D0                   1.50D0   ")
        NODE("5", "                      5                       5                        5")
            END END
    "  2412\n"
    "        11       111         3         1         7         4\n 7 3 2 9\n"
    "        19       122         6         1         7         9\n 7 3 2 9 7 3 2 9\n 7\n"
    "        13       111         4         1         7         4\n 3 2 9 90\n"
    "        14        91         5         1         7         3\n 7 3 2\n"
    "        15        21         6         1         7         2\n 0 1 1\n 7 3\n"
    "        16        11         6         1         7         2\n 3 2\n"
    "        17        24         6         1         7         3\n 0 0 0\n 7 3 2\n"
    "        18       161         6         1         7         1\n 5\n" END END "  2467\n"
    "         1         0         0         0         0         0         0         3\nin ner  \n"
    "         8        11         0         0         8        14         0         0\n"
    "         7        90         0         0\n"
    "         4         0         0         0         0         0         0         0\nempty\n\n"
    "         5         0         0         0         0         0         0         3\nspots\n"
    " 7 5 0 0 7 7 0 0\n 8 777 0 0\n" END END "  2430\n"
    "         0         0         0         0         0         0         0         1\nold\n"
    " 8 13\n" END END "  9999\nanything\n -1 0\n" END;

static void a_solid_is_read(void **state) {
    (void)state;
    static const int32_t nodes[] = {0, 1, 2, 3, 1, 2, 3, 4};
    static const double third[] = {-0.0, 1, -0.0};
    static const reading_facts facts = {.dim = 3,
                                        .n_nodes = 6,
                                        .n_elements = 2,
                                        .n_regions = 2,
                                        .n_other = 1,
                                        .n_lower = 5,
                                        .precision = PLANISH_PRECISION_DOUBLE};
    planish_file *file = reading_text(&io_format_unv, solid);
    reading_gave(file, &io_format_unv, &facts);
    const io_model *model = &file->model;
    const planish_mesh mesh = planish_file_mesh(file);
    assert_memory_equal(mesh.elements, nodes, sizeof nodes);
    assert_memory_equal(mesh.coordinates + 6, third, sizeof third);
    assert_true(mesh.coordinates[14] == 1.5);
    assert_int_equal(planish_file_node_number(file, 4), 90);
    assert_int_equal(planish_file_element_number(file, 1), 13);
    assert_int_equal(reading_tag(file, model->tetrahedron.entity, 0), 3);
    assert_int_equal(reading_tag(file, model->tetrahedron.entity, 1), 4);
    assert_int_equal(reading_tag(file, model->triangle.entity, 0), 5);
    assert_int_equal(model->line.n, 3);
    assert_int_equal(model->line.mid[2], 1); /* between 7 and 2 */
    assert_int_equal(model->line.mid[0], -1);
    assert_int_equal(model->hold[5], IO_HELD_BY_POINT);
    assert_int_equal(model->hold[3] & IO_HELD_BY_OTHER, IO_HELD_BY_OTHER);
    unit_expect_held(file, NULL, "111101");
    unit_expect_held(file, "in ner", "111111");
    unit_expect_held(file, "0:5", "111101");
    unit_expect_held(file, "old", "111111");
    unit_expect_held(file, "3:4", "111111"); /* a property; group 4 is empty */
    planish_file_close(file);
}

#define NUMBERED(number, count, name, entries)                                                     \
    "         " number                                                                             \
    "         0         0         0         0         0         0         " count "\n" name        \
    "\n" entries "\n"

/** Gmsh numbers the groups of each dimension from 1, and writes the nodes of all. */
static void names_of_one_number_are_groups(void **state) {
    (void)state;
    static const struct {
        const char *tag, *held;
    } cases[] = {{"wall", "1000"}, {"out", "0110"}, {"edge", "0001"}, {"0:1", "1110"},
                 {"1", "1111"},    {"0:9", "0001"}, {"9", "0001"},    {"solid", "1111"}};
    planish_file *file =
        reading_text(&io_format_unv, FOUR TET END "  2467\n" NUMBERED("1", "1", "wall", "7 1 0 0")
                                         NUMBERED("1", "2", "out", "7 2 0 0 7 3 0 0")
                                             NUMBERED("1", "1", "solid", "8 1 0 0")
                                                 NUMBERED("9", "1", "edge", "7 4 0 0") END);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        unit_expect_held(file, cases[i].tag, cases[i].held);
    for (int number = 2; number <= 11; number++) { /* none of planish's own numbers is a tag */
        uint8_t constraint[4];
        char tag[16];
        snprintf(tag, sizeof tag, "0:%d", number);
        const char *const tags[] = {tag};
        const planish_hold hold = {.tags = tags, .n_tags = 1};
        assert_int_equal(planish_file_constraints(file, &hold, constraint, NULL),
                         number == 9 ? 0 : PLANISH_ERROR_ARGUMENT);
    }
    planish_file_close(file);
}

/* Orders of nodes as Salome and Gmsh read and write them: most in rings. */
static const unit_element elements[] = {
    {PLANISH_CELL_TRIANGLE, 91, "0 1 2"},
    {PLANISH_CELL_TRIANGLE, 74, "0 1 2"},
    {PLANISH_CELL_TRIANGLE6, 92, "0 01 1 12 2 02"},
    {PLANISH_CELL_TRIANGLE6, 72, "0 01 1 12 2 02"},
    {PLANISH_CELL_QUADRILATERAL, 44, "0 1 2 3"},
    {PLANISH_CELL_QUADRILATERAL, 71, "0 1 2 3"},
    {PLANISH_CELL_QUADRILATERAL8, 95, "0 01 1 12 2 23 3 03"},
    {PLANISH_CELL_QUADRILATERAL9, 45, "0 01 1 12 2 23 3 03 0123"},
    {PLANISH_CELL_TETRAHEDRON, 111, "0 1 2 3"},
    {PLANISH_CELL_TETRAHEDRON10, 118, "0 01 1 12 2 02 03 13 23 3"},
    {PLANISH_CELL_WEDGE, 112, "0 1 2 3 4 5"},
    {PLANISH_CELL_WEDGE15, 113, "0 01 1 12 2 02 03 14 25 3 34 4 45 5 35"},
    {PLANISH_CELL_HEXAHEDRON, 115, "0 1 2 3 4 5 6 7"},
    {PLANISH_CELL_HEXAHEDRON, 104, "0 1 2 3 4 5 6 7"},
    {PLANISH_CELL_HEXAHEDRON20, 116, "0 01 1 12 2 23 3 03 04 15 26 37 4 45 5 56 6 67 7 47"},
    {PLANISH_CELL_PYRAMID, 312, "0 1 2 3 4"},
    {PLANISH_CELL_PYRAMID13, 312, "0 01 1 12 2 23 3 03 04 14 24 34 4"},
    {PLANISH_CELL_QUADRILATERAL9, 94, "0 1 2 3 01 12 23 03 0123"}, /* Gmsh's, as the following */
    {PLANISH_CELL_WEDGE18, 112, "0 1 2 3 4 5 01 02 03 12 14 25 34 35 45 0134 0235 1245"},
    {PLANISH_CELL_HEXAHEDRON27, 115,
     "0 1 2 3 4 5 6 7 01 03 04 12 15 23 26 37 45 47 56 67 0123 0145 0347 1256 2367 4567 01234567"},
};
enum { N_ELEMENTS = sizeof elements / sizeof *elements };

/** variant: the datasets of before, 781 and 780. */
static file_builder make(int i, int n, double x[UNIT_NODES][3], int variant, int64_t *second) {
    file_builder b = {0};
    *second = 80;
    builder_text(&b, END "%6d\n", variant ? 781 : 2411);
    for (int k = 0; k < n; k++)
        builder_text(&b, "%10d%10d%10d%10d\n%25.16E%25.16E%25.16E\n", k + 5, 0, 0, 1, x[k][0],
                     x[k][1], x[k][2]);
    builder_text(&b, END END "%6d\n", variant ? 780 : 2412);
    for (int e = 0; e < 2; e++) {
        builder_text(&b, "%10d%10d", e ? 80 : 1, elements[i].code);
        builder_text(&b, variant ? "%10d%10d%10d%10d%10d%10d" : "%10d%10d%10d%10d", 1, 1, 1, n, 1,
                     n);
        for (int k = 0; k < n; k++)
            builder_text(&b, "%s%10d", k % 8 ? "" : "\n", k + 5);
        builder_text(&b, "\n");
    }
    builder_text(&b, END);
    return b;
}

static void elements_of_every_type_are_read(void **state) {
    (void)state;
    unit_expect_types(&io_format_unv, elements, N_ELEMENTS, make);
}

static void both_orders_are_read(void **state) {
    (void)state;
    for (int is_last = 0; is_last < 2; is_last++) { /* the straight tetrahedron */
        static const char straight[] = "1 111 1 1 7 4\n1 2 3 4\n";
        file_builder b = {0};
        builder_text(&b, END "  2411\n");
        for (int i = 0; i < UNIT_BOTH_NODES; i++)
            builder_text(&b, "%d 1 1 11\n%g %g %g\n", i + 1, unit_both_places[i][0],
                         unit_both_places[i][1], unit_both_places[i][2]);
        builder_text(&b, END END "  2412\n%s", is_last ? "" : straight);
        builder_text(&b, "2 118 1 1 7 10\n2 6 3 7 4 8 9 10\n11 5\n%s", is_last ? straight : "");
        builder_text(&b, "3 92 1 1 7 6\n3 7 4 11 5 10\n4 24 1 1 7 3\n0 0 0\n4 11 5\n" END);
        planish_file *file = builder_file(&b, &io_format_unv);
        if (!is_last)
            unit_expect_both_orders(file, 1);
        const io_cells *cells = &file->model.tetrahedron;
        assert_int_equal(cells->n, 2);
        for (int k = 0; k < 6; k++)
            assert_int_equal(cells->mid[6 * is_last + k], -1);
        planish_file_close(file);
        builder_release(&b);
    }
}

static void properties_are_regions(void **state) {
    (void)state;
    for (int kind = 0; kind < 3; kind++) { /* properties, groups, materials differ */
        file_builder b = {0};
        planish_file_info info;
        builder_text(&b, END "  2411\n");
        for (int i = 0; i < UNIT_BRICK_NODES; i++)
            builder_text(&b, "%10d 1 1 11\n%25.16E%25.16E%25.16E\n", i + 1, unit_brick_places[i][0],
                         unit_brick_places[i][1], unit_brick_places[i][2]);
        builder_text(&b, END END "  2412\n1 115 4 1 7 8\n1 2 5 4 7 8 11 10\n");
        builder_text(&b, "2 115 %d %d 7 8\n2 3 6 5 8 9 12 11\n3 94 9 1 7 4\n1 2 5 4\n" END,
                     kind == 0 ? 7 : 4, kind == 2 ? 2 : 1);
        if (kind == 1)
            builder_text(&b, END "  2477\n7 0 0 0 0 0 0 1\nright\n8 2 0 0\n" END);
        planish_file *file = builder_file(&b, &io_format_unv);
        planish_file_get_info(file, &info);
        assert_int_equal(info.n_regions, 2);
        if (kind < 2)
            unit_expect_bricks(file, "2:9", kind == 0 ? "3:7" : "right");
        else
            assert_int_equal(planish_file_surface(file, NULL).region[0] !=
                                 planish_file_surface(file, NULL).region[1],
                             1);
        planish_file_close(file);
        builder_release(&b);
    }
}

/** Regions are pairs of a property and a material, not materials alone. */
static void materials_split_properties(void **state) {
    (void)state;
    planish_file_info info;
    planish_file *file = reading_text(&io_format_unv, FOUR END
                                      "  2412\n1 111 1 1 7 4\n1 2 3 4\n2 111 2 1 7 4\n1 2 3 4\n"
                                      "3 111 2 2 7 4\n1 2 3 4\n" END);
    planish_file_get_info(file, &info);
    assert_int_equal(info.n_regions, 3);
    planish_file_close(file);
}

/** Beams have a line more, which some programs leave out. */
static void lines_of_beams(void **state) {
    (void)state;
    static const struct {
        const char *text;
        int n, mid;
    } cases[] = {{"5 21 1 1 7 2\n0 0 0\n1 2\n", 1, -1},
                 {"5 11 1 1 7 2\n1 2\n", 1, -1},
                 {"5 22 1 1 7 2\n1 2\n6 21 1 1 7 2\n0 0 0\n2 3\n", 2, -1},
                 {"5 24 1 1 7 3\n0 0 0\n1 2 3\n", 1, 1},
                 {"5 24 1 1 7 3\n1 2 3\n", 1, 1},
                 {"5 24 1 1 7 3\n1 2 3\n6 24 1 1 7 3\n1 2 3\n", 2, 1}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[2048];
        snprintf(text, sizeof text, FOUR END "  2412\n 1 111 1 1 7 4\n 1 2 3 4\n%s" END,
                 cases[i].text);
        planish_file *file = reading_text(&io_format_unv, text);
        const io_cells *lines = &file->model.line;
        assert_int_equal(lines->n, cases[i].n);
        assert_int_equal(lines->nodes[0], 0);
        assert_int_equal(lines->nodes[1], cases[i].mid < 0 ? 1 : 2);
        if (cases[i].mid >= 0)
            assert_int_equal(lines->mid[0], cases[i].mid);
        planish_file_close(file);
    }
}

#define SYSTEM(number, type, matrix)                                                               \
    END "  2420\n 1\npart\n " number " " type " 8\nname\n" matrix "\n" END
#define IDENTITY "1 0 0\n0 1 0\n0 0 1\n0 0 0"
#define SHIFTED  "1 0 0\n0 1 0\n0 0 1\n0 0 5.D0"
#define NODES_IN(a, b)                                                                             \
    END "  2411\n1 " a " 1 11\n0 0 0\n2 " a " 1 11\n1 0 0\n3 " a " 1 11\n0 1 0\n4 " b              \
        " 1 11\n0 0 1\n" END

static void coordinate_systems(void **state) {
    (void)state;
    static const struct {
        const char *text, *word; /* NULL: it is read */
    } cases[] = {
        {NODES_IN("1", "2") TET, NULL},
        {SYSTEM("2", "0", IDENTITY) NODES_IN("1", "2") TET, NULL},
        {SYSTEM("2", "0", SHIFTED) NODES_IN("2", "2") TET, NULL},
        {SYSTEM("2", "0", SHIFTED) NODES_IN("1", "1") TET, NULL},
        {SYSTEM("2", "1", IDENTITY) NODES_IN("1", "1") TET, NULL},
        {SYSTEM("2", "0", SHIFTED) NODES_IN("1", "2") TET, "others are in another one"},
        {SYSTEM("2", "0", SHIFTED) NODES_IN("2", "1") TET, "others are in another one"},
        {SYSTEM("2", "1", IDENTITY) NODES_IN("1", "2") TET, "node 4 is in coordinate system 2"},
        {SYSTEM("2", "2", IDENTITY) NODES_IN("2", "2") TET, "spherical"},
        {SYSTEM("2", "0", "1 0 0") NODES_IN("1", "1") TET, "a matrix"},
        {SYSTEM("2", "x", IDENTITY) NODES_IN("1", "1") TET, "a coordinate system expected"},
        {END "    18\n 2 1 0 8 1\nname\n0 0 0 1 0 0\n1 0 1\n" END NODES_IN("1", "2") TET,
         "cylindrical"},
        {END "    18\n 2 0 0 8 1\nname\n0 0 0 1 0 0\n1 0 1\n" END NODES_IN("2", "2") TET, NULL},
        {END "    18\n 2 0 0 8 1\nname\n0 0 0 1 0 0\n1 0\n" END NODES_IN("2", "2") TET,
         "nine coordinates"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        if (cases[i].word)
            reading_fails(&io_format_unv, cases[i].text, cases[i].word);
        else
            planish_file_close(reading_text(&io_format_unv, cases[i].text));
    }
}

#define GROUP(rest) FOUR TET END "  2467\n" rest END

static void wrong_files_are_refused(void **state) {
    (void)state;
    static const reading_refusal cases[] = {
        {"", "no nodes"},
        {"x\n", "test:1: a line of -1"},
        {FOUR "x\n" TET, "a line of -1"},
        {TET, "no nodes"},
        {FOUR, "nothing to smooth"},
        {END "  2411\n1 1 1 1\n0 0 0\n", "dataset 2411 has no line of -1"},
        {FOUR TET END "  2467\n", "dataset 2467 has no"},
        {END "  2411\n1 1 1 1\n0 0 0\n2 1 1 1\n" END TET, "there are 3 lines"},
        {END "  2411\n1 1 1\n0 0 0\n" END TET, "four whole numbers"},
        {END "  2411\n1 1 1 1\n0 0\n" END TET, "node 1: three coordinates"},
        {END "  2411\n1 1 1 1\n0 0 0 0\n" END TET, "node 1: three coordinates"},
        {END "  2411\n1 1 1 1\n0 0 nan\n" END TET, "not finite"},
        {END "  2411\n1 1 1 1\n0 0 1D999\n" END TET, "not finite"},
        {END "  2411\n1 1 1 1\n0 0 x\n" END TET, "'x' is not a coordinate"},
        {END "  2411\n1 1 1 1\n0 0 0\n1 1 1 1\n1 0 0\n" END TET, "occurs twice, at"},
        {FOUR END "    15\n1 1 1 1 0 0 0\n" END TET, "dataset 15 beside"},
        /* What stands before columns is no part of a coordinate: it would be one without blanks. */
        {END
         "    15\n"
         "         1         1 1 1           9         1.00000E+00  2.00000E+00  3.00000E+00\n" END
             TET,
         "node 1: three coordinates"},
        {FOUR END "    71\n1 1 111 1 1 7 4\n1 2 3 4\n" END, "test:13: elements of dataset 71"},
        {FOUR END "  2412\n1 111 1 1 7 4\n1 2 3 5\n" END, "element 1: there is no node 5"},
        {FOUR END "  2412\n1 111 1 1 7 4\n1 2 3 -4\n" END, "no node -4"},
        {FOUR END "  2412\n1 111 1 1 7 4\n1 2 3\n" END, "4 nodes expected"},
        {FOUR END "  2412\n1 111 1 1 7 4\n1 2 3 x\n" END, "4 nodes expected"},
        {FOUR END "  2412\n1 111 1 1 7 4\n1 2 3 4 1\n" END, "line of 6 whole"},
        {FOUR END "  2412\n1 111 1 1 7\n1 2 3 4\n" END, "whole numbers expected"},
        {FOUR END "  2412\n1 111 1 1 7 0\n1 2 3 4\n" END, "cannot have 0 nodes"},
        {FOUR END "  2412\n1 111 1 1 7 4611686018427387904\n1 2 3 4\n" END, "cannot have"},
        {FOUR END "  2412\n1 111 2147483648 1 7 4\n1 2 3 4\n" END, "beyond 32 bits"},
        {FOUR END "  2412\n1 111 1 2147483648 7 4\n1 2 3 4\n" END, "beyond 32 bits"},
        {FOUR END "  2412\n1 93 1 1 7 9\n1 2 3 4 1 2 3 4 1\n" END, "third order"},
        {FOUR END "  2412\n1 122 1 1 7 4\n1 2 3 9\n" END, "no node 9"},
        {FOUR END "  2412\n1 115 1 1 7 4\n1 2 3 4\n" END, "nothing to smooth"},
        {GROUP("1 0 0 0 0 0 0\nname\n8 1 0 0\n"), "eight whole numbers"},
        {GROUP("1 0 0 0 0 0 0 2\nname\n8 1 0 0\n8 1 x 0\n"), "group 1: 2 entries"},
        {GROUP("1 0 0 0 0 0 0 -2\nname\n8 1 0 0\n"), "cannot be in"},
        {GROUP("1 0 0 0 0 0 0 4611686018427387904\nname\n8 1 0 0\n"), "cannot be in"},
        {GROUP("-1 0 0 0 0 0 0 1\nname\n8 1 0 0\n"), "out of range"},
        {FOUR TET "\n" TET END "  2467\n1 0 0 0 0 0 0 1\nname\n8 1 0 0\n" END,
         "element number 1 occurs"},
    };
    reading_refuses(&io_format_unv, cases, sizeof cases / sizeof *cases);
}

static void files_are_told(void **state) {
    (void)state;
    static const char *const texts[] = {solid, TET, "-1\n58b  1 2 11 4\n",
                                        "\r\n    -1\r\n   151\r\n"};
    reading_tells(&io_format_unv, texts, sizeof texts / sizeof *texts, 1);
    static const char *const others[] = {"",          "-1",       "-1 2\n5\n",
                                         "1\n2411\n", "-1\n-1\n", "-1\n2.5\n"};
    reading_tells(&io_format_unv, others, sizeof others / sizeof *others, 0);
}

static void files_are_cut_anywhere(void **state) {
    (void)state;
    const file_builder b = builder_of(solid);
    builder_try_to_break(&b, &io_format_unv);
    /* A file is whole only behind a dataset. */
    for (int64_t size = 1; size < b.size; size++) {
        planish_file *file = NULL;
        planish_error error;
        int64_t end = size;
        while (end > 0 && (solid[end - 1] == '\n' || solid[end - 1] == ' '))
            end--;
        if (io_file_from_memory(&io_format_unv, "test", solid, size, 1, &file, &error) == 0)
            assert_memory_equal(solid + end - 2, "-1", 2);
        planish_file_close(file);
    }
}

#define ZERO25 "   0.0000000000000000D+00"

/** Exponents stay: Fortran reads numbers without one as others (1PD25.16). */
static void numbers_keep_their_columns(void **state) {
    static const struct {
        const char *before, *after;
    } cases[] = {
        {NODE("1", ZERO25 ZERO25 ZERO25),
         NODE("1", "                  1.25D-1" ZERO25 "             1.23456789D5")},
        {NODE("1", "0.0000000000000000000D+00" ZERO25 "0.0000000000000000000D+00"),
         NODE("1", "                  1.25D-1" ZERO25 "             1.23456789D5")},
        {NODE("1", ZERO25 ZERO25 "   0.0"),
         NODE("1", "                  1.25D-1" ZERO25 " 1.23456789D5")},
        {NODE("1", " 0.0  0 0"), NODE("1", " 0.125  0 123456.789")},
        {NODE("1", ZERO25 "   1.0000000000000000-105   0.0000000000000000+000"),
         NODE("1", "                  1.25D-1   1.0000000000000000-105             1.23456789D5")},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char before[2048], after[2048];
        const char *const rest = strstr(FOUR, "         2         1");
        snprintf(before, sizeof before, END "  2411\n%s%s" TET, cases[i].before, rest);
        snprintf(after, sizeof after, END "  2411\n%s%s" TET, cases[i].after, rest);
        rewriting_gives(&io_format_unv, before, "xz", after, *state);
    }
}

#define ZERO13            "  0.00000E+00"
#define LINE(number, xyz) "         " number "         0         0        11" xyz "\n"

static void numbers_of_13_columns(void **state) {
    static const char rest[] = LINE("2", "  1.00000E+00" ZERO13 ZERO13)
        LINE("3", ZERO13 "  1.00000E+00" ZERO13) LINE("4", ZERO13 ZERO13 "  1.00000E+00") END;
    static const struct {
        const char *before, *after;
    } cases[] = {
        {LINE("1", ZERO13 ZERO13 ZERO13), LINE("1", "      1.25E-1"
                                                    " -.33333333E0"
                                                    " 1.23456789E5")},
        {LINE("1", ZERO13 "  0.00000E+00-0.000000E+00"), LINE("1", "      1.25E-1"
                                                                   " -.33333333E0"
                                                                   " 1.23456789E5")},
        {"         1         0         0        111 0.00000E+00" ZERO13 ZERO13
         "\n", /* a colour too long */
         "         1         0         0        111 1.25E-1  -.33333333E0  1.23456789E5\n"},
        {LINE("1", " 0 0 0"), LINE("1", " 1.25E-1 -.33333333E0 1.23456789E5")},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char before[2048], after[2048];
        planish_file_info info;
        snprintf(before, sizeof before, END "    15\n%s%s" TET, cases[i].before, rest);
        snprintf(after, sizeof after, END "    15\n%s%s" TET, cases[i].after, rest);
        planish_file *file = reading_text(&io_format_unv, before);
        planish_file_get_info(file, &info);
        assert_int_equal(info.precision, PLANISH_PRECISION_ROUNDED);
        planish_file_close(file);
        rewriting_gives(&io_format_unv, before, "xyz", after, *state);
    }
    /* Any white space parts numbers, also where a new number fills its column to the next one. */
    static const char begin[] = END "    15\n         1         0         0      11 \v";
    char before[2048], after[2048];
    snprintf(before, sizeof before, "%s0.00000E+00  0.00000E+00    0.00000E+00\n%s" TET, begin,
             rest);
    snprintf(after, sizeof after, "%s      1.25E-10.00000E+00   1.23456789E5\n%s" TET, begin, rest);
    rewriting_gives(&io_format_unv, before, "xz", after, *state);
    planish_file_close(reading_text(&io_format_unv, after));
}

static void nothing_but_coordinates_changes(void **state) {
    static const char text[] =
        "\n" END "  2411\n" NODE("7", "0.0  0.0 0") NODE("3", " 1.D+00 0 \t0") END END
        "   164\n1\n" END END "  2412\n 1 111 1 1 7 4\n 7 3 5 4\n" END END
        "  2411\n" NODE("5", "0 1 0") NODE("4", "0 0 1.50") END;
    static const char line[] = END "    15\n 1 1 1 1 0 0 0\n2 1 1 1 1 0 0\n3 1 1 1 0 1 0\n" END END
                                   "  2412\n 1 91 1 1 7 3\n 1 2 3\n" END;
    rewriting_keeps_the_rest(&io_format_unv, text, sizeof text - 1, *state);
    rewriting_gives(&io_format_unv, line, "x",
                    END "    15\n 1 1 1 1 .125 0 0\n2 1 1 1 1 0 0\n3 1 1 1 0 1 0\n" END END
                        "  2412\n 1 91 1 1 7 3\n 1 2 3\n" END,
                    *state);
}

/** All digits of a double have room in a column of 25, with a blank before them. */
static void columns_hold_every_double(void **state) {
    (void)state;
    uint64_t bits = 0x123456789abcdef;
    for (int i = 0; i < 20000; i++) {
        double value, found;
        char text[IO_REAL_SIZE];
        bits = bits * 6364136223846793005u + 1442695040888963407u;
        memcpy(&value, &bits, sizeof value);
        if (!isfinite(value))
            continue;
        for (int kind = IO_EXPONENT_NEEDED; kind <= IO_EXPONENT_ALWAYS;
             kind += IO_EXPONENT_ALWAYS) {
            const char *at = text, *end = text + io_format_field(text, value, 24, kind);
            assert_true(end - text <= 24 && memchr(text, '.', (size_t)(end - text)));
            assert_int_equal(io_parse_real(&at, end, &found), 0);
            assert_true(at == end && found == value);
        }
    }
}

/** Datasets worth threads, of two types; where is_joined, one node has no blanks between
 *  coordinates. */
static void threads_read_the_same(void **state) {
    (void)state;
    enum { N = 20000 };
    for (int is_joined = 0; is_joined < 2; is_joined++) {
        file_builder b = {0};
        builder_text(&b, END "  2411\n");
        for (int i = 0; i < N; i++)
            builder_text(&b, "%10d         1         1        11\n%25.16E%25.*E%25.16E\n", i + 1,
                         i / 2 + .1, is_joined && i == N / 2 ? 19 : 16, i % 2 * 1., i % 7 * 1.);
        builder_text(&b, END END "  2412\n");
        for (int i = 0; i < N - 4; i++)
            builder_text(&b, "%10d       111%10d         1         7         4\n%10d%10d%10d%10d\n",
                         i + 1, i / 100, i + 1, i + 2, i + 3, i + 4);
        for (int i = 0; i < N - 6; i++)
            builder_text(&b,
                         "%10d       112         7%10d         7         6\n"
                         "%10d%10d%10d%10d%10d%10d\n",
                         N + i, i / 1000, i + 1, i + 2, i + 3, i + 4, i + 5, i + 6);
        builder_text(&b, END);
        builder_expect_same_on_threads(&b, &io_format_unv);
        builder_release(&b);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_solid_is_read),
        cmocka_unit_test(names_of_one_number_are_groups),
        cmocka_unit_test(elements_of_every_type_are_read),
        cmocka_unit_test(both_orders_are_read),
        cmocka_unit_test(properties_are_regions),
        cmocka_unit_test(materials_split_properties),
        cmocka_unit_test(lines_of_beams),
        cmocka_unit_test(coordinate_systems),
        cmocka_unit_test(wrong_files_are_refused),
        cmocka_unit_test(files_are_told),
        cmocka_unit_test(files_are_cut_anywhere),
        cmocka_unit_test(numbers_keep_their_columns),
        cmocka_unit_test(numbers_of_13_columns),
        cmocka_unit_test(nothing_but_coordinates_changes),
        cmocka_unit_test(columns_hold_every_double),
        cmocka_unit_test(threads_read_the_same),
    };
    return cmocka_run_group_tests(tests, test_folder_create, test_folder_remove);
}
