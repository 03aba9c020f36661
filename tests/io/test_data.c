/* Arrays of numbers of legacy VTK files, text and binary, and how arrays are found by their names. */
#include "support/data_reading.h"
#include "support/file_builder.h"
#include "support/files.h"
#include "support/reading.h"

#include "io/core/binary.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

enum { N_NODES = 6, N_CELLS = 4 };

/* A line, a quadrilateral and two triangles: the elements are cells 2, 3 and 1. */
#define MESH                                                                                       \
    "POINTS 6 double\n0 0 0 1 0 0 2 0 0 0 1 0 1 1 0 2 1 0\n"                                       \
    "CELLS 4 16\n2 0 1\n4 0 1 4 3\n3 1 2 5\n3 1 5 4\nCELL_TYPES 4\n3\n9\n5\n5\n"
#define TEXT "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET UNSTRUCTURED_GRID\n" MESH

/** How the numbers of an array are written. */
typedef struct variant {
    int binary, size, is_real;
    const char *type;
} variant;

static const variant variants[] = {
    {0, 8, 1, "double"}, {0, 4, 1, "float"}, {0, 4, 0, "int"},           {1, 8, 1, "double"},
    {1, 4, 1, "float"},  {1, 4, 0, "int"},   {1, 1, 0, "unsigned_char"}, {1, 8, 0, "vtktypeint64"}};
enum { N_VARIANTS = sizeof variants / sizeof *variants };

static void put_list(file_builder *builder, int n, const int *numbers) {
    for (int i = 0; i < n; i++)
        builder_integer(builder, numbers[i], 4);
    builder_text(builder, "\n");
}

static file_builder make_mesh(const variant *v) {
    static const int cells[] = {2, 0, 1, 4, 0, 1, 4, 3, 3, 1, 2, 5, 3, 1, 5, 4};
    static const int types[] = {3, 9, 5, 5};
    file_builder builder = {.binary = v->binary, .swapped = io_machine_is_little()};
    builder_text(&builder, "# vtk DataFile Version 3.0\ntitle\n%s\nDATASET UNSTRUCTURED_GRID\n",
                 v->binary ? "BINARY" : "ASCII");
    builder_text(&builder, "POINTS %d double\n", N_NODES);
    for (int i = 0; i < N_NODES; i++)
        for (int d = 0; d < 3; d++)
            builder_real(&builder, d == 0 ? i % 3 : d == 1 ? i / 3 : 0, 8);
    builder_text(&builder, "\nCELLS 4 16\n");
    put_list(&builder, 16, cells);
    builder_text(&builder, "CELL_TYPES 4\n");
    put_list(&builder, 4, types);
    return builder;
}

/* Whole numbers that fit all types; those of nodes and elements differ. */
static double node_value(int64_t number, int k) {
    return (double)(1 + number + 10 * k);
}

static double cell_value(int64_t number, int k) {
    return (double)(7 + 3 * number + 10 * k);
}

/** Value in the file that comes out as component k of symmetric tensors: xx, yy, zz, xy, yz, xz. */
static double in_vtk_order(data_value_fn *value, int64_t number, int k) {
    static const int component[] = {0, 2, 5, 1, 4, 3};
    return value(number, component[k]);
}

static void put_values(file_builder *builder, const variant *v, int n, int width,
                       data_value_fn *value) {
    for (int i = 0; i < n; i++)
        for (int k = 0; k < width; k++) {
            const double number = width == 6 ? in_vtk_order(value, i, k) : value(i, k);
            if (v->is_real)
                builder_real(builder, number, v->size);
            else
                builder_integer(builder, (int64_t)number, v->size);
        }
    builder_text(builder, "\n");
}

/** Attributes of every kind that has numbers, of nodes or cells. */
static void put_attributes(file_builder *builder, const variant *v, int n, data_value_fn *value) {
    builder_text(builder, "SCALARS h %s\nLOOKUP_TABLE default\n", v->type);
    put_values(builder, v, n, 1, value);
    builder_text(builder, "TENSORS full %s\n", v->type);
    put_values(builder, v, n, 9, value);
    builder_text(builder, "TENSORS6 half %s\n", v->type);
    put_values(builder, v, n, 6, value);
    builder_text(builder, "FIELD FieldData 2\nof%%20two 2 %d %s\n", n, v->type);
    put_values(builder, v, n, 2, value);
    builder_text(builder, "flat 4 %d %s\n", n, v->type);
    put_values(builder, v, n, 4, value);
}

static planish_file *read_builder(const file_builder *builder) {
    planish_file *file;
    planish_error error = {.text = ""};
    if (builder_read(builder, &io_format_vtk, 2, &file, &error))
        fail_msg("%s", error.text);
    return file;
}

/* ---- tests -------------------------------------------------------------------------------- */

static void attributes_of_nodes(void **state) {
    (void)state;
    for (int i = 0; i < N_VARIANTS; i++) {
        file_builder builder = make_mesh(&variants[i]);
        builder_text(&builder, "POINT_DATA %d\n", N_NODES);
        put_attributes(&builder, &variants[i], N_NODES, node_value);
        planish_file *file = read_builder(&builder);
        expect_data_list(file, "h:1 full:9 half:6 of two:2 flat:4");
        expect_data(file, "h", 0, 1, node_value);
        expect_data(file, "full", 0, 9, node_value);
        expect_data(file, "half", 0, 6, node_value);
        expect_data(file, "of two", 0, 2, node_value);
        expect_data(file, "flat", 0, 4, node_value);
        expect_data(file, "h", 0, 1, node_value);
        planish_file_close(file);
        builder_try_to_break(&builder, &io_format_vtk);
        builder_release(&builder);
    }
}

static void attributes_of_elements(void **state) {
    (void)state;
    for (int i = 0; i < N_VARIANTS; i++) {
        file_builder builder = make_mesh(&variants[i]);
        builder_text(&builder, "CELL_DATA %d\n", N_CELLS);
        put_attributes(&builder, &variants[i], N_CELLS, cell_value);
        planish_file *file = read_builder(&builder);
        expect_data_list(file, "*h:1 *full:9 *half:6 *of two:2 *flat:4");
        expect_data(file, "h", 1, 1, cell_value);
        expect_data(file, "full", 1, 9, cell_value);
        expect_data(file, "half", 1, 6, cell_value);
        expect_data(file, "flat", 1, 4, cell_value);
        planish_file_close(file);
        builder_try_to_break(&builder, &io_format_vtk);
        builder_release(&builder);
    }
}

/** Of one name the array of nodes counts, of one kind the first. */
static void names_that_occur_twice(void **state) {
    (void)state;
    planish_file *file = reading_text(&io_format_vtk, TEXT "CELL_DATA 4\nSCALARS h int 1\n"
                                                           "LOOKUP_TABLE default\n7 10 13 16\n"
                                                           "SCALARS a int 1\n7 10 13 16\n"
                                                           "POINT_DATA 6\nSCALARS h int\n"
                                                           "1 2 3 4 5 6\nSCALARS h int\n"
                                                           "9 9 9 9 9 9\n");
    expect_data_list(file, "*h:1 *a:1 h:1");
    expect_data(file, "h", 0, 1, node_value);
    expect_data(file, "a", 1, 1, cell_value);
    planish_file_close(file);
}

static void arrays_that_are_not_there(void **state) {
    (void)state;
    planish_file *file = reading_text(&io_format_vtk, TEXT);
    expect_no_data(file, "h", PLANISH_ERROR_ARGUMENT, "the file has: none");
    planish_file_close(file);
    file = reading_text(&io_format_vtk,
                        TEXT "FIELD FieldData 1\nh 1 6 int\n1 2 3 4 5 6\nPOINT_DATA 6\n"
                             "SCALARS size double\n1 2 3 4 5 6\n"
                             "CELL_DATA 4\nSCALARS id int\n1 2 3 4\n");
    expect_no_data(file, "h", PLANISH_ERROR_ARGUMENT, "the file has: size (nodes), id (elements)");
    expect_no_data(file, "", PLANISH_ERROR_ARGUMENT, "no array ''");
    planish_file_close(file);
}

static void long_lists_are_cut(void **state) {
    (void)state;
    char text[4096] = TEXT "POINT_DATA 6\nFIELD f 12\n";
    for (int i = 0; i < 12; i++) {
        const size_t used = strlen(text);
        snprintf(text + used, sizeof text - used, "a%d 1 6 int 1 2 3 4 5 6\n", i);
    }
    /* Values stand behind the line of their array. */
    for (char *at = strstr(text, "int 1"); at; at = strstr(at, "int 1"))
        at[3] = '\n';
    planish_file *file = reading_text(&io_format_vtk, text);
    expect_data(file, "a11", 0, 1, node_value);
    expect_no_data(file, "h", PLANISH_ERROR_ARGUMENT, "a8 (nodes), a9 (nodes), ...");
    planish_file_close(file);
}

/** Expect the error part for the array h of a file with these attributes. */
static void expect_wrong(const char *attributes, const char *part) {
    char text[1024];
    snprintf(text, sizeof text, "%s%s", TEXT, attributes);
    planish_file *file = reading_text(&io_format_vtk, text);
    expect_no_data(file, "h", PLANISH_ERROR_FORMAT, part);
    planish_file_close(file);
}

static void wrong_arrays(void **state) {
    (void)state;
    expect_wrong("POINT_DATA 6\nFIELD f 1\nh 1 5 int\n1 2 3 4 5\n",
                 "array 'h': it has 5 values for 6 points");
    expect_wrong("CELL_DATA 4\nFIELD f 1\nh 1 3 int\n1 2 3\n",
                 "array 'h': it has 3 values for 4 cells");
    expect_wrong("POINT_DATA 6\nFIELD f 1\nh 10 6 int\n1 2 3 4 5 6 7 8 9 10 1 2 3 4 5 6 7 8 9 10 "
                 "1 2 3 4 5 6 7 8 9 10 1 2 3 4 5 6 7 8 9 10 1 2 3 4 5 6 7 8 9 10 "
                 "1 2 3 4 5 6 7 8 9 10\n",
                 "has 10 numbers for each of its values; arrays of 1 to 9 are read");
    expect_wrong("POINT_DATA 6\nFIELD f 1\nh 0 6 int\n", "has 0 numbers for each");
    expect_wrong("POINT_DATA 6\nSCALARS h double\n1 2 nan 4 5 6\n",
                 "the array 'h' has the value nan, which is not finite, for node 2");
    expect_wrong("POINT_DATA 6\nSCALARS h double\n1 2 3 4 5 1e999\n", "not finite, for node 5");
    expect_wrong("CELL_DATA 4\nSCALARS h double\n1 2 -inf 4\n", "not finite, for element 2");
    expect_wrong("POINT_DATA 6\nSCALARS h double\n1 2 three 4 5 6\n",
                 "h: a number expected (the file may be cut short)");
    expect_wrong("CELL_DATA 4\nSCALARS h double\n1 2 3 x\n", ":19: h: a number expected");
}

/** What other cells than elements have does not matter. */
static void cells_that_are_no_elements(void **state) {
    (void)state;
    planish_file *file = reading_text(&io_format_vtk, TEXT "CELL_DATA 4\nSCALARS h double\n"
                                                           "nan 10 13 16\n");
    expect_data(file, "h", 1, 1, cell_value);
    planish_file_close(file);
}

static void formats_without_data(void **state) {
    (void)state;
    planish_file *file =
        reading_text(&io_format_medit, "MeshVersionFormatted 2\nDimension 2\nVertices 3\n0 0 0\n"
                                       "1 0 0\n0 1 0\nTriangles 1\n1 2 3 0\nEnd\n");
    expect_data_list(file, "");
    expect_no_data(file, "h", PLANISH_ERROR_ARGUMENT, "Medit keeps sizes in NAME.sol");
    planish_file_close(file);
    file = reading_text(&io_format_off, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    expect_no_data(file, "h", PLANISH_ERROR_ARGUMENT,
                   "only from files of VTK, Gmsh, Exodus and XDMF, not from off");
    planish_file_close(file);
}

static void files_that_change(void **state) {
    static const char text[] = TEXT "POINT_DATA 6\nSCALARS h double\n1 2 3 4 5 6\n";
    char path[TEST_PATH_SIZE];
    planish_file *file = NULL;
    test_write(*state, "mesh.vtk", text, strlen(text));
    assert_int_equal(planish_file_open(test_path(path, *state, "mesh.vtk"), NULL, 1, &file, NULL),
                     0);
    expect_data(file, "h", 0, 1, node_value);
    test_write(*state, "mesh.vtk", text, strlen(text) - 2);
    expect_no_data(file, "h", PLANISH_ERROR_FILE, "mesh.vtk");
    planish_file_close(file);
}

static void arguments_are_checked(void **state) {
    (void)state;
    planish_file *file = reading_text(&io_format_vtk, TEXT);
    double other = 0;
    planish_data data = {.n = 1, .values = &other};
    planish_data_info info;
    assert_int_equal(planish_file_data(NULL, "h", &data, NULL), PLANISH_ERROR_ARGUMENT);
    assert_null(data.values);
    assert_int_equal(planish_file_data(file, NULL, &data, NULL), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_data(file, "h", NULL, NULL), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_data_info(NULL, 0, &info), 0);
    assert_int_equal(planish_file_data_info(file, 0, NULL), 0);
    assert_int_equal(planish_file_data_info(file, -1, &info), 0);
    planish_data_free(NULL);
    planish_file_close(file);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(attributes_of_nodes),
        cmocka_unit_test(attributes_of_elements),
        cmocka_unit_test(names_that_occur_twice),
        cmocka_unit_test(arrays_that_are_not_there),
        cmocka_unit_test(long_lists_are_cut),
        cmocka_unit_test(wrong_arrays),
        cmocka_unit_test(cells_that_are_no_elements),
        cmocka_unit_test(formats_without_data),
        cmocka_unit_test_setup_teardown(files_that_change, test_folder_create, test_folder_remove),
        cmocka_unit_test(arguments_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
