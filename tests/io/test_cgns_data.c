/* CGNS: values of cells in solutions, which of them tell regions beside the sections; what cannot
 * be read is passed over. */
#include "support/square.h"
#include "support/hdf5_builder.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#ifdef PL_HDF5

enum { SIDE = 4, N_NODES = (SIDE + 1) * (SIDE + 1), N = 2 * SIDE * SIDE };
#define ZONE "/Base/Zone"

static double one_is_not_whole(int column, int row, int index) {
    return index == N - 1 ? (double)NAN : square_halves(column, row, index);
}

/* ---- files -------------------------------------------------------------------------------- */

static void put_coordinates(const hdf5_builder *b) {
    static const char *const paths[] = {ZONE "/GridCoordinates/CoordinateX",
                                        ZONE "/GridCoordinates/CoordinateY"};
    double values[N_NODES];
    char place[300];
    cgns_put_node(b, ZONE "/GridCoordinates", "GridCoordinates_t");
    for (int d = 0; d < 2; d++) {
        for (int i = 0; i < N_NODES; i++)
            values[i] = d ? i / (SIDE + 1) : i % (SIDE + 1);
        cgns_put_node(b, paths[d], "DataArray_t");
        snprintf(place, sizeof place, "%s/ data", paths[d]);
        hdf5_reals(b, place, N_NODES, values);
    }
}

/** Triangles first .. behind - 1, from 0. */
static void put_section(const hdf5_builder *b, const char *name, int first, int behind) {
    static const int corner[2][3] = {{1, 2, SIDE + 3}, {1, SIDE + 3, SIDE + 2}};
    char path[128];
    int nodes[3 * N];
    for (int t = first; t < behind; t++)
        for (int k = 0; k < 3; k++)
            nodes[3 * (t - first) + k] =
                t / 2 / SIDE * (SIDE + 1) + t / 2 % SIDE + corner[t % 2][k];
    snprintf(path, sizeof path, ZONE "/%s", name);
    cgns_put_section(b, path, 5, first + 1, behind, 3 * (behind - first), nodes);
}

/** A square in one section, or a lower and an upper one; the zone says n_cells. */
static hdf5_builder begin(int n_sections, int n_cells) {
    hdf5_builder b;
    hdf5_begin(&b, 0);
    cgns_put_node(&b, "/CGNSLibraryVersion", "CGNSLibraryVersion_t");
    cgns_put_integers(&b, "/Base", "CGNSBase_t", 2, (const int[]){2, 2});
    cgns_put_integers(&b, ZONE, "Zone_t", 3, (const int[]){N_NODES, n_cells, 0});
    cgns_put_text(&b, ZONE "/ZoneType", "ZoneType_t", "Unstructured");
    put_coordinates(&b);
    /* By name the upper one comes first. */
    put_section(&b, "z lower", 0, n_sections > 1 ? N / 2 : N);
    if (n_sections > 1)
        put_section(&b, "a upper", N / 2, N);
    return b;
}

static void put_solution(const hdf5_builder *b, const char *name, const char *location) {
    char path[128], place[256];
    snprintf(path, sizeof path, ZONE "/%s", name);
    cgns_put_node(b, path, "FlowSolution_t");
    snprintf(place, sizeof place, "%s/GridLocation", path);
    if (location)
        cgns_put_text(b, place, "GridLocation_t", location);
}

/** An array of n values in a solution, of type file_type. */
static void put_array(const hdf5_builder *b, const char *name, hid_t file_type,
                      square_value_fn *value, int n) {
    char path[128], place[256];
    double values[N + 1];
    for (int i = 0; i < n; i++)
        values[i] = value(i / 2 % SIDE, i / 2 / SIDE, i);
    snprintf(path, sizeof path, ZONE "/%s", name);
    cgns_put_node(b, path, "DataArray_t");
    snprintf(place, sizeof place, "%s/ data", path);
    hdf5_array(b, place, file_type, H5T_NATIVE_DOUBLE, (hsize_t)n, 0, values);
}

/* ---- what is expected --------------------------------------------------------------------- */

static planish_file *read_square(const file_builder *builder) {
    planish_file *file = NULL;
    planish_error error = {.text = ""};
    if (builder_read(builder, &io_format_cgns, 1, &file, &error))
        fail_msg("%s", error.text);
    return file;
}

/** Names of all arrays, of those that tell regions, what is held; b is closed. */
static void expect_file(hdf5_builder *b, const char *all, const char *regions, int column,
                        int row) {
    file_builder builder = hdf5_end(b);
    planish_file *file = read_square(&builder);
    expect_names(planish_file_cell_arrays(file), all);
    expect_names(planish_file_region_arrays(file), regions);
    expect_held(file, column, row);
    planish_file_close(file);
    builder_release(&builder);
}

/* ---- tests -------------------------------------------------------------------------------- */

static void data_tell_regions(void **state) {
    (void)state;
    const hid_t types[] = {H5T_STD_I32LE, H5T_STD_I64BE, H5T_STD_I8LE, H5T_IEEE_F32LE,
                           H5T_IEEE_F64BE};
    for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
        hdf5_builder b = begin(1, N);
        put_solution(&b, "Solution", "CellCenter");
        put_array(&b, "Solution/number", types[i], square_number, N);
        put_array(&b, "Solution/zone", types[i], square_halves, N);
        put_array(&b, "Solution/T", H5T_IEEE_F64LE, one_is_not_whole, N);
        expect_file(&b, "number zone", "zone", 1, 0);
    }
}

static void data_add_to_sections(void **state) {
    (void)state;
    hdf5_builder b = begin(2, N);
    expect_file(&b, "", "", 0, 1);
    b = begin(2, N);
    put_solution(&b, "Solution", "CellCenter");
    put_array(&b, "Solution/zone", H5T_STD_I32LE, square_halves, N);
    file_builder builder = hdf5_end(&b);
    planish_file *file = read_square(&builder);
    char text[64];
    assert_true(planish_file_element_region(file, N - 1, text, sizeof text) > 0);
    assert_string_equal(text, "a upper");
    expect_held(file, 1, 1);
    planish_file_close(file);
    builder_expect_same_on_threads(&builder, &io_format_cgns);
    builder_let_allocations_fail(&builder, &io_format_cgns);
    builder_release(&builder);
}

static void some_data_are_no_regions(void **state) {
    (void)state;
    hdf5_builder b = begin(1, N);
    put_solution(&b, "At nodes", "Vertex");
    put_array(&b, "At nodes/a", H5T_STD_I32LE, square_halves, N);
    put_solution(&b, "By default", NULL);
    put_array(&b, "By default/b", H5T_STD_I32LE, square_halves, N);
    put_solution(&b, "With rind", "CellCenter");
    put_array(&b, "With rind/c", H5T_STD_I32LE, square_halves, N + 1);
    put_array(&b, "With rind/d", H5T_STD_I32LE, square_halves, N - 1);
    cgns_put_text(&b, ZONE "/With rind/e", "DataArray_t", "CellCenter");
    cgns_put_node(&b, ZONE "/With rind/f", "DataArray_t");
    expect_file(&b, "", "", 0, 0);
    /* The zone has other cells, too, it says: which cell a value is of is not known. */
    b = begin(1, N + 1);
    put_solution(&b, "Solution", "CellCenter");
    put_array(&b, "Solution/a", H5T_STD_I32LE, square_halves, N);
    put_array(&b, "Solution/b", H5T_STD_I32LE, square_halves, N + 1);
    expect_file(&b, "", "", 0, 0);
}

/** Of arrays of one name the first counts. */
static void steps_and_links(void **state) {
    (void)state;
    hdf5_builder b = begin(1, N);
    put_solution(&b, "Step 1", "CellCenter");
    put_array(&b, "Step 1/zone", H5T_STD_I32LE, square_halves, N);
    put_solution(&b, "Step 2", "CellCenter");
    put_array(&b, "Step 2/zone", H5T_STD_I32LE, square_rows, N);
    expect_file(&b, "zone", "zone", 1, 0);
    b = begin(1, N);
    put_solution(&b, "Linked", "CellCenter");
    hdf5_group(&b, ZONE "/Linked/zone");
    hdf5_text_attribute(&b, ZONE "/Linked/zone", "label", "DataArray_t");
    hdf5_text_attribute(&b, ZONE "/Linked/zone", "type", "LK");
    put_solution(&b, "Outside", "CellCenter");
    H5Lcreate_external("other.cgns", "/Base", b.file, ZONE "/Outside/zone", H5P_DEFAULT,
                       H5P_DEFAULT);
    put_solution(&b, "Whole", "CellCenter");
    put_array(&b, "Whole/zone", H5T_STD_I32LE, square_rows, N);
    expect_file(&b, "zone", "zone", 0, 1);
}

static double two_in_the_middle(int column, int row, int index) {
    (void)column;
    (void)row;
    return index == 1 || index == 2 ? 6 : 5;
}

/** Values of triangles and quadrilaterals that stand in any order are each one's own. */
static void data_of_mixed_elements_go_by_number(void **state) {
    (void)state;
    static const int nodes[] = {7, 1, 2, 7, 6, 5, 2, 3, 8, 5, 2, 8, 7, 7, 3, 4, 9, 8};
    hdf5_builder b;
    hdf5_begin(&b, 0);
    cgns_put_node(&b, "/CGNSLibraryVersion", "CGNSLibraryVersion_t");
    cgns_put_integers(&b, "/Base", "CGNSBase_t", 2, (const int[]){2, 2});
    cgns_put_integers(&b, ZONE, "Zone_t", 3, (const int[]){N_NODES, 4, 0});
    cgns_put_text(&b, ZONE "/ZoneType", "ZoneType_t", "Unstructured");
    put_coordinates(&b);
    cgns_put_integers(&b, ZONE "/all", "Elements_t", 2, (const int[]){20, 0});
    cgns_put_integers(&b, ZONE "/all/ElementRange", "IndexRange_t", 2, (const int[]){1, 4});
    cgns_put_integers(&b, ZONE "/all/ElementConnectivity", "DataArray_t",
                      sizeof nodes / sizeof *nodes, nodes);
    put_solution(&b, "Solution", "CellCenter");
    put_array(&b, "Solution/region", H5T_STD_I32LE, two_in_the_middle, 4);
    file_builder builder = hdf5_end(&b);
    planish_file *file = read_square(&builder);
    const int32_t *region = planish_file_surface(file, NULL).region; /* triangles come first */
    static const int numbers[] = {2, 3, 1, 4};
    for (int i = 0; i < 4; i++)
        assert_int_equal(planish_file_element_number(file, i), numbers[i]);
    assert_non_null(region);
    assert_int_equal(region[0], region[1]);
    assert_int_equal(region[2], region[3]);
    assert_int_not_equal(region[0], region[2]);
    planish_file_close(file);
    builder_let_allocations_fail(&builder, &io_format_cgns);
    builder_release(&builder);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(data_of_mixed_elements_go_by_number),
        cmocka_unit_test(data_tell_regions),
        cmocka_unit_test(data_add_to_sections),
        cmocka_unit_test(some_data_are_no_regions),
        cmocka_unit_test(steps_and_links),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#else

int main(void) {
    return 0; /* test_vtkhdf.c sees that HDF5 is asked for */
}

#endif
