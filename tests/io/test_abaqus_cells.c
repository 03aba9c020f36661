/* Abaqus input files: elements of every type, with the order of nodes of the manuals. */
#include "support/files.h"
#include "support/reading.h"
#include "support/rewriting.h"
#include "support/unit_elements.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static const io_format *const format = &io_format_abaqus;

/** Nodes of elements, as the manuals of Abaqus and CalculiX number them. */
static const struct {
    const char *nodes;
    int type;
    const char *names[16];
} types[] = {
    {"1 2 3 4",
     PLANISH_CELL_QUADRILATERAL,
     {"CPS4", "CPE4R", "CAX4", "S4", "S4R", "M3D4", "R3D4", "cpe4h", "DC2D4", "CGAX4R", "CPEG4",
      "DCAX4", "AC2D4", "SFM3D4", "S4R5"}},
    {"1 2 3 12 23 31",
     PLANISH_CELL_TRIANGLE6,
     {"CPS6", "CPE6M", "CAX6M", "STRI65", "S6", "M3D6", "DC2D6", "cpe6h"}},
    {"1 2 3 4 12 23 34 41",
     PLANISH_CELL_QUADRILATERAL8,
     {"CPS8", "CPE8R", "CAX8", "S8R", "S8R5", "DC2D8", "M3D8R", "S8"}},
    {"1 2 3 4 12 23 34 41 1234", PLANISH_CELL_QUADRILATERAL9, {"S9R5", "M3D9", "M3D9R"}},
    {"1 2 3 4 12 23 31 14 24 34",
     PLANISH_CELL_TETRAHEDRON10,
     {"C3D10", "C3D10M", "C3D10HS", "DC3D10", "C3D10T", "AC3D10", "c3d10mh"}},
    {"1 2 3 4 5", PLANISH_CELL_PYRAMID, {"C3D5", "AC3D5"}},
    {"1 2 3 4 5 6", PLANISH_CELL_WEDGE, {"C3D6", "DC3D6", "F3D6", "SC6R", "C3D6E"}},
    {"1 2 3 4 5 6 7 8",
     PLANISH_CELL_HEXAHEDRON,
     {"C3D8", "C3D8R", "C3D8I", "C3D8IH", "DC3D8", "DCC3D8", "F3D8", "SC8R", "AC3D8R", "EMC3D8"}},
    {"1 2 3 4 5 6 12 23 31 45 56 64 14 25 36",
     PLANISH_CELL_WEDGE15,
     {"C3D15", "DC3D15", "C3D15H", "C3D15V"}},
    {"1 2 3 4 5 6 12 23 31 45 56 64 14 25 36 1254 2365 3146",
     PLANISH_CELL_WEDGE18,
     {"C3D15V", "C3D15VH"}},
    {"1 2 3 4 5 6 7 8 12 23 34 41 56 67 78 85 15 26 37 48",
     PLANISH_CELL_HEXAHEDRON20,
     {"C3D20", "C3D20R", "DC3D20", "C3D20RHT", "AC3D20"}},
    {"1 2 3 4 5 6 7 8 12 23 34 41 56 67 78 85 15 26 37 48 12345678 1234 5876 1562 2673 3784 4851",
     PLANISH_CELL_HEXAHEDRON27,
     {"C3D27", "C3D27RH"}},
};

/** Write an element of number 7 with the last nodes left out, 15 nodes in the first line. */
static void write_element(char *text, size_t size, const char *name, int n, double x[UNIT_NODES][3],
                          int n_left_out) {
    int length = snprintf(text, size, "*NODE\n");
    for (int i = 0; i < n; i++)
        length += snprintf(text + length, size - (size_t)length, "%d, %.8f, %.8f, %.8f\n", i + 1,
                           x[i][0], x[i][1], x[i][2]);
    length += snprintf(text + length, size - (size_t)length, "*ELEMENT, TYPE=%s\n7", name);
    for (int i = 0; i < n - n_left_out; i++)
        length += snprintf(text + length, size - (size_t)length, i == 15 ? ",\n%d" : ", %d", i + 1);
    snprintf(text + length, size - (size_t)length, "\n");
}

static void elements_of_every_type_are_read(void **state) {
    (void)state;
    char text[4096];
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        for (int j = 0; j < 16 && types[i].names[j]; j++)
            for (int swapped = 0; swapped < 2; swapped++) {
                double x[UNIT_NODES][3];
                const int n = unit_places(types[i].type, types[i].nodes, x);
                if (swapped)
                    unit_swap(types[i].type, n, x);
                write_element(text, sizeof text, types[i].names[j], n, x, 0);
                planish_file *file = reading_text(format, text);
                if (!swapped)
                    unit_expect(file, 0, types[i].type);
                unit_expect_alone(file, types[i].type, 7, unit_is_smoothed(types[i].type) ? 0 : n,
                                  !swapped);
                reading_every_beginning(format, text, j == 0 ? (int64_t)strlen(text) : 0);
            }
}

/** Write the nodes of the facet or line that a file has beside its element: numbers in the file, and 0 for
 *  those that it lacks. */
static void nodes_beside(const io_model *model, char *text, size_t size) {
    const int lists[] = {1, 2, IO_FLAT_LIST};
    text[0] = '\0';
    for (int k = 0; k < 3 && !text[0]; k++) {
        const io_list list = io_model_list(model, lists[k]);
        int32_t node[IO_CELL_NODES];
        const int n = list.n > 0 ? io_list_all_nodes(&list, 0, node, NULL) : 0;
        for (int i = 0; i < n; i++)
            snprintf(text + strlen(text), size - strlen(text), i ? " %d" : "%d", node[i] + 1);
    }
}

/** Write an element of a type, complete, as write_element does. */
static void write_type(char *text, size_t size, int type, const char *name) {
    for (size_t k = 0; k < sizeof types / sizeof *types; k++) {
        double x[UNIT_NODES][3];
        if (types[k].type != type)
            continue;
        const int n = unit_places(type, types[k].nodes, x);
        write_element(text, size, name, n, x, 0);
    }
}

/** Lines and facets that have corners alone get the mids of the elements, in the order of their own. */
static void corners_get_the_mids_of_elements(void **state) {
    (void)state;
    static const struct {
        int type;
        const char *name, *beside, *nodes, *held;
    } cases[] = {
        {PLANISH_CELL_HEXAHEDRON27, "C3D27", "S4\n8,2,6,7,3\n", "2 6 7 3 18 14 19 10 25",
         "011001100100010001100000100"},
        {PLANISH_CELL_HEXAHEDRON27, "C3D27", "S4\n8,3,7,6,2\n", "3 7 6 2 19 14 18 10 25",
         "011001100100010001100000100"},
        {PLANISH_CELL_HEXAHEDRON27, "C3D27", "S8R\n8,2,6,7,3,18,14,19,10\n",
         "2 6 7 3 18 14 19 10 25", "011001100100010001100000100"},
        {PLANISH_CELL_HEXAHEDRON27, "C3D27", "S4\n8,1,2,8,7\n", "1 2 8 7 9 0 15 0",
         "110000111000001000000000000"},
        {PLANISH_CELL_HEXAHEDRON20, "C3D20", "S4\n8,2,6,7,3\n", "2 6 7 3 18 14 19 10",
         "01100110010001000110"},
        {PLANISH_CELL_HEXAHEDRON20, "C3D20", "S4\n8,1,3,7,5\n", "1 3 7 5 0 19 0 17",
         "10101010000000001010"},
        {PLANISH_CELL_HEXAHEDRON20, "C3D20", "S4\n8,1,6,3,8\n", "1 6 3 8", "10100101000000000000"},
        {PLANISH_CELL_WEDGE18, "C3D15V", "S3R\n8,3,2,1\n", "3 2 1 8 7 9", "111000111000000000"},
        {PLANISH_CELL_TETRAHEDRON10, "C3D10", "T3D2\n8,3,2\n", "3 2 6", "0110010000"},
        {PLANISH_CELL_TRIANGLE6, "CPS6", "T3D2\n8,3,1\n", "3 1 6", "101001"},
        {PLANISH_CELL_HEXAHEDRON, "C3D8", "S4\n8,2,6,7,3\n", "2 6 7 3", "01100110"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[4096], nodes[64];
        write_type(text, sizeof text, cases[i].type, cases[i].name);
        const size_t length = strlen(text);
        snprintf(text + length, sizeof text - length, "*ELEMENT,TYPE=%s", cases[i].beside);
        planish_file *file = reading_text(format, text);
        nodes_beside(&file->model, nodes, sizeof nodes);
        assert_string_equal(nodes, cases[i].nodes);
        reading_holds(file, NULL, READING_REGIONS, cases[i].held);
        planish_file_close(file);
    }
}

/** Surfaces have the mids of their facets, and the middle of faces. */
static void surfaces_have_all_nodes_of_facets(void **state) {
    (void)state;
    static const struct {
        const char *name, *facet, *held;
        int type;
    } cases[] = {
        {"C3D20", "S1", "11110000111100000000", PLANISH_CELL_HEXAHEDRON20},
        {"C3D27", "S1", "111100001111000000000100000", PLANISH_CELL_HEXAHEDRON27},
        {"C3D27", "S4", "011001100100010001100000100", PLANISH_CELL_HEXAHEDRON27},
        {"C3D15V", "S3", "110110100100110100", PLANISH_CELL_WEDGE18},
        {"C3D15V", "S2", "000111000111000000", PLANISH_CELL_WEDGE18},
        {"S9R5", "SPOS", "111111111", PLANISH_CELL_QUADRILATERAL9},
        {"CPS8", "S2", "01100100", PLANISH_CELL_QUADRILATERAL8},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[4096];
        write_type(text, sizeof text, cases[i].type, cases[i].name);
        const size_t length = strlen(text);
        snprintf(text + length, sizeof text - length, "*SURFACE,NAME=S\n7,%s\n", cases[i].facet);
        reading_text_holds(format, text, "S", READING_REGIONS, cases[i].held);
    }
}

/* Tetrahedra of both orders, a triangle and a line: unit_expect_both_orders. */
#define MIDS                                                                                       \
    "1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1\n6,.5,.5,0\n7,0,.5,.5\n8,.5,0,.5\n"               \
    "9,1,.5,.5\n10,.5,1,.5\n11,.5,.5,1\n"
#define ORDERS                                                                                     \
    "*ELEMENT,TYPE=C3D10,ELSET=B\n2,2,3,4,5,6,7,8,\n9,10,11\n*ELEMENT,TYPE=C3D4,ELSET=A\n"         \
    "1,1,2,3,4\n*ELEMENT,TYPE=STRI65,ELSET=T\n3,3,4,5,7,11,10\n"
#define BOTH_ORDERS "*NODE\n" MIDS ORDERS "*ELEMENT,TYPE=B32,ELSET=L\n4,4,11,5\n"

static void both_orders_may_be_in_a_file(void **state) {
    /* The mid of a line is its second node, or its third; behind these there may be another. */
    static const char *const lines[] = {"B32\n4,4,11,5\n", "T3D3\n4,4,5,11\n", "B32\n4,4,11,5,1\n"};
    static const struct {
        const char *text, *tag, *held;
    } cases[] = {
        {BOTH_ORDERS, NULL, "00111010011"},
        {BOTH_ORDERS, "L", "00111010011"},
        {BOTH_ORDERS, "B", "01111111111"},
        {BOTH_ORDERS, "A", "11111010011"},
        {BOTH_ORDERS "*NSET,NSET=N,ELSET=B\n", "N", "01111111111"},
        {BOTH_ORDERS "*NSET,NSET=N,ELSET=L\n", "N", "00111010011"},
        {BOTH_ORDERS "*NSET,NSET=N\n6,9\n", "N", "00111110111"},
        {BOTH_ORDERS "*SURFACE,NAME=S\n2,S1\n", "S", "01111111011"},
        {BOTH_ORDERS "*SURFACE,NAME=S\n2,S2\n", "S", "01111110111"},
        {BOTH_ORDERS "*SURFACE,NAME=S\n1,S2\n", "S", "11111010011"},
        {BOTH_ORDERS "*EQUATION\n2\n9,1,1.,6,1,1.\n", NULL, "00111110111"},
    };
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        char text[1024];
        snprintf(text, sizeof text, "*NODE\n" MIDS ORDERS "*ELEMENT,TYPE=%s", lines[i]);
        planish_file *file = reading_text(format, text);
        unit_expect_both_orders(file, 1);
        assert_int_equal(planish_file_element_number(file, 0), 2);
        planish_file_close(file);
    }
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        planish_file *file = reading_text(format, cases[i].text);
        unit_expect_held(file, cases[i].tag, cases[i].held);
        planish_file_close(file);
    }
    /* Node 12 is a mid, and the first node. */
    rewriting_gives(
        format, "*NODE\n12, .5, 0., .01 \n" MIDS "*ELEMENT,TYPE=C3D10\n1,1,2,3,4,12,6,3,4,8,7\n",
        "xyz",
        "*NODE\n12, .125, -.3333333333333333, 123456.789 \n" MIDS
        "*ELEMENT,TYPE=C3D10\n1,1,2,3,4,12,6,3,4,8,7\n",
        *state);
}

static void mids_must_be_there(void **state) {
    (void)state;
    char text[4096];
    double x[UNIT_NODES][3];
    const int n = unit_places(PLANISH_CELL_TETRAHEDRON10, "1 2 3 4 12 23 31 14 24 34", x);
    write_element(text, sizeof text, "C3D10", n, x, 1);
    reading_fails(format, text, "where the number of a node was expected");
}

/** C3D27 may have no nodes of faces; that of the inside says nothing then. */
static void nodes_of_faces_may_be_missing(void **state) {
    (void)state;
    char text[4096];
    double x[UNIT_NODES][3];
    const int n = unit_places(PLANISH_CELL_HEXAHEDRON20,
                              "1 2 3 4 5 6 7 8 12 23 34 41 56 67 78 85 15 26 37 48 12345678", x);
    write_element(text, sizeof text, "C3D27R", n, x, 0);
    unit_expect_alone(reading_text(format, text), PLANISH_CELL_HEXAHEDRON20, 7, 0, 1);
    snprintf(text + strlen(text) - 1, 32, ",0,0,0,0,0,0\n");
    unit_expect_alone(reading_text(format, text), PLANISH_CELL_HEXAHEDRON20, 7, 0, 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elements_of_every_type_are_read),
        cmocka_unit_test(surfaces_have_all_nodes_of_facets),
        cmocka_unit_test(corners_get_the_mids_of_elements),
        cmocka_unit_test_setup_teardown(both_orders_may_be_in_a_file, test_folder_create,
                                        test_folder_remove),
        cmocka_unit_test(mids_must_be_there),
        cmocka_unit_test(nodes_of_faces_may_be_missing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
