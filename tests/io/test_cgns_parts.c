/* CGNS: each part of a file missing, of another shape or of another type, and connections of zones.
 *
 * A file of two tetrahedra is made, and before it is closed one of its parts is removed or
 * replaced.
 */
#include "support/file_builder.h"
#include "support/hdf5_builder.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#ifdef PL_HDF5

enum { N = 5 };
#define ZONE       "/Base/Zone"
#define CONNECTION ZONE "/ZoneGridConnectivity/Other"

static void put_coordinates(const hdf5_builder *b) {
    static const double values[3][N] = {{0, 1, 0, 0, 1}, {0, 0, 1, 0, 1}, {0, 0, 0, 1, 1}};
    char path[64];
    cgns_put_node(b, ZONE "/GridCoordinates", "GridCoordinates_t");
    for (int d = 0; d < 3; d++) {
        snprintf(path, sizeof path, ZONE "/GridCoordinates/Coordinate%c", "XYZ"[d]);
        cgns_put_node(b, path, "DataArray_t");
        strcat(path, "/ data");
        hdf5_reals(b, path, N, values[d]);
    }
}

/** Elements 1 and 2: tetrahedra of a section without offsets; 3 and 4: triangles of one with. */
static void put_sections(const hdf5_builder *b) {
    cgns_put_integers(b, ZONE "/solid", "Elements_t", 2, (const int[]){10, 0});
    cgns_put_integers(b, ZONE "/solid/ElementRange", "IndexRange_t", 2, (const int[]){1, 2});
    cgns_put_integers(b, ZONE "/solid/ElementConnectivity", "DataArray_t", 8,
                      (const int[]){1, 2, 3, 4, 2, 3, 4, 5});
    cgns_put_integers(b, ZONE "/wall", "Elements_t", 2, (const int[]){20, 0});
    cgns_put_integers(b, ZONE "/wall/ElementRange", "IndexRange_t", 2, (const int[]){3, 4});
    cgns_put_integers(b, ZONE "/wall/ElementConnectivity", "DataArray_t", 8,
                      (const int[]){5, 1, 2, 3, 5, 1, 2, 4});
    cgns_put_integers(b, ZONE "/wall/ElementStartOffset", "DataArray_t", 3, (const int[]){0, 4, 8});
}

static void put_condition(const hdf5_builder *b) {
    cgns_put_node(b, ZONE "/ZoneBC", "ZoneBC_t");
    cgns_put_text(b, ZONE "/ZoneBC/some", "BC_t", "BCWall");
    cgns_put_integers(b, ZONE "/ZoneBC/some/PointRange", "IndexRange_t", 2, (const int[]){3, 4});
    cgns_put_text(b, ZONE "/ZoneBC/some/GridLocation", "GridLocation_t", "FaceCenter  ");
}

static hdf5_builder begin(void) {
    hdf5_builder b;
    hdf5_begin(&b, 0);
    cgns_put_node(&b, "/CGNSLibraryVersion", "CGNSLibraryVersion_t");
    cgns_put_integers(&b, "/Base", "CGNSBase_t", 2, (const int[]){3, 3});
    cgns_put_integers(&b, ZONE, "Zone_t", 3, (const int[]){N, 4, 0});
    cgns_put_text(&b, ZONE "/ZoneType", "ZoneType_t", "Unstructured");
    put_coordinates(&b);
    put_sections(&b);
    put_condition(&b);
    return b;
}

static planish_file *read_file(hdf5_builder *b) {
    file_builder file = hdf5_end(b);
    planish_file *read;
    planish_error error = {.text = ""};
    if (builder_read(&file, &io_format_cgns, 1, &read, &error))
        fail_msg("%s", error.text);
    builder_release(&file);
    return read;
}

/* ---- what is refused ----------------------------------------------------------------------- */

typedef enum kind { REMOVED, INTEGERS, REALS, TEXT, CUBE } kind;

/** What stands at a path instead, and what is told of it. */
typedef struct damage {
    const char *path;
    kind kind;
    int n, values[5];
    const char *told;
} damage;

static void put_cube(const hdf5_builder *b, const char *path) {
    const hsize_t dims[3] = {1, 1, 2};
    hid_t space = H5Screate_simple(3, dims, NULL);
    H5Dclose(
        H5Dcreate2(b->file, path, H5T_STD_I32LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    H5Sclose(space);
}

static void refuse(const damage *d) {
    const double reals[] = {1, 2, 3, 4, 5};
    hdf5_builder b = begin();
    assert_true(H5Ldelete(b.file, d->path, H5P_DEFAULT) >= 0);
    if (d->kind == INTEGERS)
        hdf5_integers(&b, d->path, (hsize_t)d->n, d->values);
    else if (d->kind == REALS)
        hdf5_reals(&b, d->path, (hsize_t)d->n, reals);
    else if (d->kind == TEXT)
        hdf5_array(&b, d->path, H5T_STD_I8LE, H5T_NATIVE_CHAR, 5, 0, "three");
    else if (d->kind == CUBE)
        put_cube(&b, d->path);
    file_builder file = hdf5_end(&b);
    builder_expect_error(&file, &io_format_cgns, d->told);
    builder_release(&file);
}

static void damaged_parts_are_refused(void **state) {
    (void)state;
    static const damage all[] = {
        {"/Base", REMOVED, 0, {0}, "there is no base"},
        {"/Base/ data", INTEGERS, 1, {3}, "two dimensions were expected"},
        {"/Base/ data", INTEGERS, 2, {3, 4}, "a mesh in 4 dimensions"},
        {"/Base/ data", REALS, 2, {0}, "whole numbers were expected"},
        {"/Base/ data", CUBE, 0, {0}, "one or two dimensions was expected"},
        {ZONE, REMOVED, 0, {0}, "there is no zone"},
        {ZONE "/ data", INTEGERS, 2, {N, 2}, "its size was expected"},
        {ZONE "/ data", INTEGERS, 3, {-1, 2, 0}, "its size was expected"},
        {ZONE "/ZoneType/ data", REALS, 2, {0}, "text was expected"},
        {ZONE "/GridCoordinates", REMOVED, 0, {0}, "there are no GridCoordinates"},
        {ZONE "/GridCoordinates/CoordinateZ/ data", INTEGERS, N, {0}, "4 or 8 bytes"},
        {ZONE "/GridCoordinates/CoordinateZ/ data", REALS, 4, {0}, "4 coordinates for 5 nodes"},
        {ZONE "/solid/ data", INTEGERS, 0, {0}, "type and range of its elements"},
        {ZONE "/solid/ElementRange/ data",
         INTEGERS,
         3,
         {1, 2, 3},
         "type and range of its elements"},
        {ZONE "/solid/ElementRange/ data", INTEGERS, 2, {0, 2}, "elements 0 to 2 are not a range"},
        {ZONE "/solid/ElementRange/ data", INTEGERS, 2, {3, 1}, "elements 3 to 1 are not a range"},
        {ZONE "/solid/ElementConnectivity/ data", TEXT, 0, {0}, "5 numbers for 2 elements"},
        {ZONE "/wall/ElementStartOffset/ data", INTEGERS, 2, {0, 4}, "2 offsets for 2 elements"},
        {ZONE "/wall/ElementConnectivity/ data",
         INTEGERS,
         3,
         {5, 1, 2},
         "ends within element 1 of 2"},
        {ZONE "/ZoneBC/some/PointRange/ data", INTEGERS, 3, {1, 2, 3}, "two numbers were expected"},
        {ZONE "/ZoneBC/some/PointRange/ data", INTEGERS, 2, {4, 1}, "4 to 1 is not a range"},
        {ZONE "/ZoneBC/some/PointRange/ data", INTEGERS, 2, {1, 2000000000}, "the file is damaged"},
        {ZONE "/ZoneBC/some/GridLocation/ data", INTEGERS, 1, {1}, "text was expected"},
    };
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++)
        refuse(&all[i]);
}

/* ---- connections --------------------------------------------------------------------------- */

/** Whether nodes 1 .. N are held because another zone is connected there, as digits. */
static void expect_connected(const char *location, const char *list, int n, const int *numbers,
                             const char *expected) {
    hdf5_builder b = begin();
    cgns_put_node(&b, ZONE "/ZoneGridConnectivity", "ZoneGridConnectivity_t");
    cgns_put_text(&b, CONNECTION, "GridConnectivity_t", "Elsewhere");
    cgns_put_text(&b, CONNECTION "/GridLocation", "GridLocation_t", location);
    char path[128];
    snprintf(path, sizeof path, CONNECTION "/%s", list);
    cgns_put_integers(&b, path, "IndexArray_t", n, numbers);
    planish_file *file = read_file(&b);
    for (int i = 0; i < N; i++)
        if ((file->model.hold[i] & IO_HELD_REQUIRED) != (expected[i] == '1' ? IO_HELD_REQUIRED : 0))
            fail_msg("%s of %s: node %d", list, location, i + 1);
    planish_file_close(file);
}

static void connected_nodes_are_held(void **state) {
    (void)state;
    expect_connected("Vertex", "PointList", 2, (const int[]){5, 2}, "01001");
    expect_connected("Vertex", "PointRange", 2, (const int[]){2, 4}, "01110");
    expect_connected("FaceCenter", "PointList", 1, (const int[]){4}, "11010");
    expect_connected("CellCenter", "PointList", 1, (const int[]){2}, "01111");
    /* No element of this file. */
    expect_connected("FaceCenter", "PointList", 1, (const int[]){99}, "00000");
}

static void a_connection_of_no_node_is_refused(void **state) {
    (void)state;
    for (int wrong = 0; wrong <= N + 1; wrong += N + 1) {
        hdf5_builder b = begin();
        cgns_put_node(&b, ZONE "/ZoneGridConnectivity", "ZoneGridConnectivity_t");
        cgns_put_text(&b, CONNECTION, "GridConnectivity_t", "Elsewhere");
        cgns_put_integers(&b, CONNECTION "/PointList", "IndexArray_t", 1, &wrong);
        file_builder file = hdf5_end(&b);
        builder_expect_error(&file, &io_format_cgns, "is not in 1 .. 5");
        builder_release(&file);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(damaged_parts_are_refused),
        cmocka_unit_test(connected_nodes_are_held),
        cmocka_unit_test(a_connection_of_no_node_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#else

int main(void) {
    return 0; /* test_vtkhdf.c sees that HDF5 is asked for */
}

#endif
