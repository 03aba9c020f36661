/* CGNS: what is read, held and refused, sections and boundary conditions. */
#include "support/files.h"
#include "support/rewriting.h"
#include "support/hdf5_builder.h"
#include "support/reading.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#ifdef PL_HDF5

enum { N = 6, MIXED = 20 };
#define ZONE "/Base/Zone"

/** Two sections of one tetrahedron, one of triangles; or one section of all, MIXED. */
typedef struct mesh {
    int is_mixed, has_offsets, is_float, is_packed, is_plane, n_nodes, node, type, start;
    int second_zone, second_base, offset, last, cylindrical, bad_condition, is_link;
    const char *zone_type;
    double x;
} mesh;

static const mesh right = {
    .zone_type = "Unstructured", .n_nodes = N, .node = 5, .type = 10, .start = 2, .last = 4};

static void put_condition(const hdf5_builder *b, const char *name, const char *location,
                          const char *list, int n, const int *numbers, const char *family) {
    char path[200], place[256];
    snprintf(path, sizeof path, ZONE "/ZoneBC/%s", name);
    cgns_put_text(b, path, "BC_t", "BCWall");
    snprintf(place, sizeof place, "%s/%s", path, list);
    cgns_put_integers(b, place, "IndexArray_t", n, numbers);
    if (location) {
        snprintf(place, sizeof place, "%s/GridLocation", path);
        cgns_put_text(b, place, "GridLocation_t", location);
    }
    if (family) {
        snprintf(place, sizeof place, "%s/FamilyName", path);
        cgns_put_text(b, place, "FamilyName_t", family);
    }
}

static void put_coordinates(hdf5_builder *b, const mesh *m) {
    double x[] = {0, 1, 0, 0, 1, 2}, y[] = {0, 0, 1, 0, 1, 2}, z[] = {0, 0, 0, 1, 1.5, 2};
    const double *const values[] = {x, y, z};
    char path[256];
    x[1] += m->x;
    cgns_put_node(b, ZONE "/GridCoordinates", "GridCoordinates_t");
    for (int d = 0; d < (m->is_plane ? 2 : 3); d++) {
        snprintf(path, sizeof path, ZONE "/GridCoordinates/Coordinate%c",
                 (m->cylindrical ? "XRT" : "XYZ")[d]);
        cgns_put_node(b, path, "DataArray_t");
        strcat(path, "/ data");
        b->chunk[0] = m->is_packed ? 4 : 0;
        b->is_packed = 1;
        hdf5_array(b, path, m->is_float ? H5T_IEEE_F32LE : H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, N, 0,
                   values[d]);
        b->chunk[0] = 0;
    }
}

/** Elements 1 lower, 2 upper, 3 and 4 the wall of a triangle and a quadrilateral. */
static void put_elements(const hdf5_builder *b, const mesh *m) {
    const int lower[] = {1, 2, 3, 4}, upper[] = {2, 3, 4, m->node};
    static const int wall[] = {5, 1, 2, 3, 7, 1, 2, 3, 6}, offsets[] = {0, 4, 9};
    const int all[] = {10, 1, 2, 3, 4, 10, 2, 3, 4, m->node, 5, 1, 2, 3, 7, 1, 2, 3, 6};
    const int all_offsets[] = {0, 5 + m->offset, 10, 14, 19};
    if (m->is_mixed) {
        cgns_put_section(b, ZONE "/all", MIXED, 1, m->last, 19, all);
        if (m->has_offsets)
            cgns_put_integers(b, ZONE "/all/ElementStartOffset", "DataArray_t", 5, all_offsets);
        return;
    }
    if (!m->is_plane) {
        cgns_put_section(b, ZONE "/upper", m->type, m->start, m->start, 4, upper);
        cgns_put_section(b, ZONE "/lower", 10, 1, 1, 4, lower);
    }
    cgns_put_section(b, ZONE "/wall", MIXED, 3, m->last, 9, wall);
    if (m->has_offsets)
        cgns_put_integers(b, ZONE "/wall/ElementStartOffset", "DataArray_t", 3, offsets);
}

static file_builder make(const mesh *m) {
    hdf5_builder b;
    const int dim = m->is_plane ? 2 : 3;
    hdf5_begin(&b, 0);
    cgns_put_node(&b, "/CGNSLibraryVersion", "CGNSLibraryVersion_t");
    cgns_put_integers(&b, "/Base", "CGNSBase_t", 2, (const int[]){dim, dim});
    if (m->second_base)
        cgns_put_node(&b, "/Another", "CGNSBase_t");
    cgns_put_integers(&b, ZONE, "Zone_t", 3, (const int[]){m->n_nodes, 4, 0});
    if (m->second_zone)
        cgns_put_node(&b, "/Base/Another", "Zone_t");
    cgns_put_text(&b, ZONE "/ZoneType", "ZoneType_t", m->zone_type);
    put_coordinates(&b, m);
    put_elements(&b, m);
    cgns_put_node(&b, ZONE "/ZoneBC", "ZoneBC_t");
    put_condition(&b, "faces", "FaceCenter", "PointList", 3, (const int[]){3, 4, 3}, "Walls");
    put_condition(&b, "touched", "CellCenter", "PointRange", 2, (const int[]){2, 3}, NULL);
    put_condition(&b, "points", NULL, "PointList", 2,
                  (const int[]){4, m->bad_condition ? N + 1 : 6}, NULL);
    put_condition(&b, "more points", "Vertex", "PointList", 1, (const int[]){4}, "Walls");
    put_condition(&b, "old", NULL, "ElementList", 1, (const int[]){1}, NULL);
    if (m->is_link) {
        hdf5_group(&b, ZONE "/linked");
        hdf5_text_attribute(&b, ZONE "/linked", "label", "Elements_t");
        hdf5_text_attribute(&b, ZONE "/linked", "type", "LK");
    }
    if (m->is_link > 1)
        H5Lcreate_external("other.cgns", "/Base", b.file, ZONE "/linked too", H5P_DEFAULT,
                           H5P_DEFAULT);
    return hdf5_end(&b);
}

static planish_file *read_mesh(const mesh *m) {
    file_builder b = make(m);
    planish_file *file = builder_file(&b, &io_format_cgns);
    builder_release(&b);
    return file;
}

/* ---- what is read -------------------------------------------------------------------------- */

static void check_solid(const planish_file *file, int n_regions, int precision) {
    planish_mesh got = planish_file_mesh(file);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(got.dim, 3);
    assert_int_equal(got.n_nodes, N);
    assert_int_equal(got.n_elements, 2);
    static const int32_t nodes[] = {0, 1, 2, 3, 1, 2, 3, 4};
    assert_memory_equal(got.elements, nodes, sizeof nodes);
    assert_true(got.coordinates[3] == 1 && got.coordinates[14] == 1.5 && got.coordinates[16] == 2);
    assert_int_equal(info.n_regions, n_regions);
    assert_int_equal(info.n_lower_elements, 2);
    assert_int_equal(info.n_other_elements, 0);
    assert_int_equal(info.precision, precision);
    assert_int_equal(file->model.hold[5], IO_HELD_BY_FACE);
    assert_int_equal(file->model.hold[3], 0);
    assert_int_equal(planish_file_element_number(file, 1), 2);
    assert_int_equal(planish_file_node_number(file, 5), 6);
    assert_int_equal(file->model.triangle.number[0], 3);
}

static void a_mesh_is_read(void **state) {
    (void)state;
    mesh m = right;
    file_builder b = make(&m);
    assert_int_equal(io_format_cgns.recognise(b.data, b.size), 1);
    assert_int_equal(io_format_med.recognise(b.data, b.size), 0);
    builder_release(&b);
    for (int i = 0; i < 8; i++) {
        m.is_mixed = i & 1;
        m.has_offsets = i >> 1 & 1;
        m.is_float = i >> 2;
        m.is_packed = m.is_float;
        planish_file *file = read_mesh(&m);
        check_solid(file, 2, m.is_float ? PLANISH_PRECISION_FLOAT : PLANISH_PRECISION_DOUBLE);
        planish_file_close(file);
    }
}

static void a_plane_is_read(void **state) {
    (void)state;
    mesh m = right;
    m.is_plane = 1;
    planish_file *file = read_mesh(&m);
    planish_mesh plane = planish_file_mesh(file);
    assert_int_equal(plane.dim, 2);
    assert_int_equal(plane.n_elements, 2);
    assert_true(plane.coordinates[10] == 2);
    planish_file_close(file);
}

static void groups_have_names(void **state) {
    (void)state;
    planish_file *file = read_mesh(&right);
    reading_holds(file, NULL, 0, "111001");
    reading_holds(file, "points", 0, "111101");
    reading_holds(file, "more points", 0, "111101");
    reading_holds(file, "Walls", 0, "111101");
    reading_holds(file, "wall", 0, "111001");
    reading_holds(file, "faces", 0, "111001");
    reading_holds(file, "upper", 0, "111111");
    reading_holds(file, "lower", 0, "111101");
    reading_holds(file, "old", 0, "111101");
    reading_holds(file, "touched", 0, "111111");
    uint8_t constraint[N];
    planish_error error;
    const char *unknown = "nothing";
    const planish_hold hold = {.tags = &unknown, .n_tags = 1};
    assert_int_equal(planish_file_constraints(file, &hold, constraint, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "more points"));
    /* A triangle of section and two conditions is one entity. */
    const char *const slide[] = {"faces"};
    const planish_hold sliding = {.slide = 1, .slide_tags = slide, .n_slide_tags = 1};
    assert_int_equal(planish_file_constraints(file, &sliding, constraint, &error), 0);
    planish_file_close(file);
}

/* ---- what is refused ----------------------------------------------------------------------- */

static void refuse(mesh m, const char *part) {
    file_builder b = make(&m);
    builder_expect_error(&b, &io_format_cgns, part);
    builder_release(&b);
}

static void wrong_files_are_refused(void **state) {
    (void)state;
    mesh m = right;
    refuse(((void)(m.zone_type = "Structured"), m), "'Structured'");
    m = right;
    refuse(((void)(m.second_zone = 1), m), "one zone");
    m = right;
    refuse(((void)(m.second_base = 1), m), "one base");
    m = right;
    refuse(((void)(m.n_nodes = 7), m), "6 coordinates for 7 nodes");
    m = right;
    refuse(((void)(m.cylindrical = 1), m), "CoordinateY");
    m = right;
    refuse(((void)(m.node = 7), m), "element 2: node 7 is not in 1 .. 6");
    m = right;
    refuse(((void)(m.start = 1), m), "element 1 is in two sections");
    m = right;
    refuse(((void)(m.type = 5), m), "4 numbers for 1 elements of 3");
    m = right;
    refuse(((void)(m.type = 11), m), "4 numbers for 1 elements of 10");
    m = right;
    refuse(((void)(m.type = 30), m), "or higher"); /* third order */
    m = right;
    refuse(((void)(m.type = 22), m), "NGON_n");
    m = right;
    refuse(((void)(m.type = 99), m), "unknown");
    m = right;
    refuse(((void)(m.x = 1e308 * 10), m), "not finite");
    m = right;
    refuse(((void)(m.bad_condition = 1), m), "points/PointList: node 7");
    m = right;
    refuse(((void)(m.is_link = 1), m), "link of CGNS");
    m = right;
    refuse(((void)(m.is_link = 2), m), "link to another file");
    m = right;
    m.is_mixed = 1;
    refuse(((void)(m.last = 5), m), "ends before element 5");
    refuse(((void)(m.last = 3), m), "are left behind");
    refuse(((void)(m.last = 4, m.has_offsets = 1, m.offset = 1), m), "ElementStartOffset says 6");
    refuse(((void)(m.last = 4, m.offset = 0, m.node = 0), m), "node 0");
    reading_fails(&io_format_cgns, "\300\250\243\251ADF Database Version A02011>", "adf2hdf");
}

static void nothing_breaks_it(void **state) {
    (void)state;
    mesh m = right;
    m.has_offsets = 1;
    file_builder b = make(&m);
    file_builder cut = b;
    builder_expect_same_on_threads(&b, &io_format_cgns);
    /* All beginnings would take long: HDF5 refuses every one that is shorter than it says. */
    cut.size = 1024;
    cut.data = malloc(1024);
    memcpy(cut.data, b.data, 1024);
    reading_every_beginning(&io_format_cgns, cut.data, cut.size);
    for (cut.size = b.size - 64; cut.size < b.size; cut.size++) {
        cut.data = realloc(cut.data, (size_t)cut.size);
        memcpy(cut.data, b.data, (size_t)cut.size);
        builder_expect_error(&cut, &io_format_cgns, "HDF5");
    }
    free(cut.data);
    builder_let_allocations_fail(&b, &io_format_cgns);
    builder_release(&b);
}

/* ---- writing ------------------------------------------------------------------------------- */

static void check_writing(const char *folder, const mesh *m) {
    file_builder b = make(m);
    rewriting_in_place(b.data, b.size, m->is_packed, folder, "in.cgns");
    builder_release(&b);
}

static void coordinates_come_back(void **state) {
    for (int i = 0; i < HDF5_SUPERBLOCKS; i++) {
        mesh m = right;
        hdf5_superblock = hdf5_superblocks[i];
        check_writing(*state, &m);
        m.is_float = 1;
        check_writing(*state, &m);
        m.is_packed = 1;
        check_writing(*state, &m);
    }
    hdf5_superblock = 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_mesh_is_read),
        cmocka_unit_test(a_plane_is_read),
        cmocka_unit_test(groups_have_names),
        cmocka_unit_test(wrong_files_are_refused),
        cmocka_unit_test(nothing_breaks_it),
        cmocka_unit_test_setup_teardown(coordinates_come_back, test_folder_create,
                                        test_folder_remove),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#else

int main(void) {
    return 0; /* test_vtkhdf.c sees that HDF5 is asked for */
}

#endif
