/* VTKHDF: what is read, held and refused, and how coordinates come back however they are stored. */
#include "support/converting.h"
#include "support/files.h"
#include "support/hdf5_builder.h"
#include "support/reading.h"

#include "io/core/bytes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#ifdef PL_HDF5

enum { N_POINTS = 7, N_CELLS = 4 };

/** Two tetrahedra, a triangle and a pyramid (held nodes), in one partition or two. */
typedef struct grid {
    int is_float, is_big, is_packed, is_compact, chunk, columns_apart, partitions;
    hsize_t user_block;
    int points, cells, node, type, offset, steps; /* what is wrong, as a value; -1: nothing */
    int has_data, has_faces; /* a polyhedron's faces: the last node is number 5 + has_faces */
    const char *kind;
    double x; /* of the second point */
} grid;

static const grid right = {.partitions = 1,
                           .points = -1,
                           .cells = -1,
                           .node = -1,
                           .type = -1,
                           .offset = -1,
                           .steps = -1,
                           .kind = "UnstructuredGrid",
                           .x = 1};

static void put_points(hdf5_builder *b, const grid *g) {
    double xyz[N_POINTS * 3] = {0, 0, 0, 1,   0, 0, 0, 1,   0,   0,  0,
                                1, 1, 1, 1.5, 2, 2, 2, 0.1, 0.2, 0.3};
    const hid_t types[] = {H5T_IEEE_F64LE, H5T_IEEE_F64BE, H5T_IEEE_F32LE, H5T_IEEE_F32BE};
    xyz[3] = g->x;
    b->is_compact = g->is_compact;
    b->is_packed = g->is_packed;
    b->chunk[0] = (hsize_t)g->chunk;
    b->chunk[1] = g->columns_apart ? 1 : 3;
    hdf5_array(b, "/VTKHDF/Points", types[2 * g->is_float + g->is_big], H5T_NATIVE_DOUBLE, N_POINTS,
               3, xyz);
    b->chunk[0] = 0;
    b->is_compact = 0;
}

static void put_cells(hdf5_builder *b, const grid *g) {
    int one[] = {0, 1, 2, 3, 1, 2, 3, 4, 0, 1, 2, 0, 1, 2, 3, 5};
    int two[] = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 0, 1, 2, 3, 0};
    int offsets[] = {0, 4, 8, 11, 16}, split[] = {0, 4, 0, 4, 7, 12};
    int types[] = {10, 10, 5, 14}, counts[] = {16, 0}, points[] = {N_POINTS, 0}, cells[] = {4, 0};
    hsize_t n = (hsize_t)g->partitions;
    if (n == 2) {
        counts[0] = 4, counts[1] = 12;
        points[0] = points[1] = 4;
        points[0] = 3 + 1, points[1] = 3;
        two[3] = 3, two[7] = 2, two[15] = 1, two[14] = 0;
        cells[0] = 1, cells[1] = 3;
        two[4] = 0, two[5] = 1, two[6] = 2, two[7] = 1;
    }
    int *ids = n == 2 ? two : one;
    if (g->node >= 0)
        ids[5] = g->node;
    if (g->type >= 0)
        types[1] = g->type;
    if (g->offset >= 0)
        offsets[2] = g->offset;
    if (g->points >= 0)
        points[0] = g->points;
    if (g->cells >= 0)
        cells[0] = g->cells;
    hdf5_integers(b, "/VTKHDF/NumberOfPoints", n, points);
    hdf5_integers(b, "/VTKHDF/NumberOfCells", n, cells);
    hdf5_integers(b, "/VTKHDF/NumberOfConnectivityIds", n, counts);
    hdf5_array(b, "/VTKHDF/Connectivity", H5T_STD_I64LE, H5T_NATIVE_INT, 16, 0, ids);
    hdf5_array(b, "/VTKHDF/Offsets", H5T_STD_I64LE, H5T_NATIVE_INT, n == 2 ? 6 : 5, 0,
               n == 2 ? split : offsets);
    if (g->has_faces) {
        const int nodes[] = {1, 2, 3, 1, 2, 5 + g->has_faces}, n_nodes[] = {6, 0};
        hdf5_integers(b, "/VTKHDF/NumberOfFaceConnectivityIds", n, n_nodes);
        hdf5_integers(b, "/VTKHDF/FaceConnectivity", 6, nodes);
    }
    hdf5_array(b, "/VTKHDF/Types", H5T_STD_U8LE, H5T_NATIVE_INT, N_CELLS, 0, types);
}

/** Put arrays of points and cells: numbers, too few, and text. */
static void put_data(hdf5_builder *b) {
    static const double heat[N_POINTS] = {0, .5, 1, 1.5, 2, 2.5, 3},
                        stress[N_CELLS * 6] = {1, 2, 3, 4, 5, 6, 11, 12, 13, 14, 15, 16};
    hdf5_group(b, "/VTKHDF/FieldData");
    hdf5_array(b, "/VTKHDF/PointData/heat", H5T_IEEE_F32BE, H5T_NATIVE_DOUBLE, N_POINTS, 0, heat);
    hdf5_array(b, "/VTKHDF/PointData/short", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 3, 0, heat);
    hdf5_array(b, "/VTKHDF/CellData/stress", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, N_CELLS, 6, stress);
    hdf5_array(b, "/VTKHDF/FieldData/time", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 1, 0, heat);
    hdf5_group(b, "/VTKHDF/CellData/words");
}

static file_builder make(const grid *g) {
    static const int fixed[N_POINTS] = {0, 0, 0, 0, 0, 0, 3}, region[N_CELLS] = {7, 8, 1, 1};
    hdf5_builder b;
    hdf5_begin(&b, g->user_block);
    hdf5_group(&b, "/VTKHDF/PointData");
    hdf5_group(&b, "/VTKHDF/CellData");
    hdf5_text_attribute(&b, "/VTKHDF", "Type", g->kind);
    put_points(&b, g);
    put_cells(&b, g);
    hdf5_integers(&b, "/VTKHDF/PointData/fixed", N_POINTS, fixed);
    hdf5_integers(&b, "/VTKHDF/CellData/MaterialIDs", N_CELLS, region);
    if (g->has_data)
        put_data(&b);
    if (g->steps >= 0) {
        hdf5_group(&b, "/VTKHDF/Steps");
        hdf5_attribute(&b, "/VTKHDF/Steps", "NSteps", g->steps);
    }
    return hdf5_end(&b);
}

static planish_file *read_grid(const file_builder *b) {
    planish_file *file;
    planish_error error = {.text = ""};
    if (builder_read(b, &io_format_vtkhdf, 1, &file, &error))
        fail_msg("%s", error.text);
    return file;
}

/* ---- what is read -------------------------------------------------------------------------- */

static void a_grid_is_read(void **state) {
    (void)state;
    file_builder b = make(&right);
    assert_int_equal(io_format_vtkhdf.recognise(b.data, b.size), 1);
    assert_int_equal(io_format_med.recognise(b.data, b.size), 0);
    assert_int_equal(io_format_cgns.recognise(b.data, b.size), 0);
    planish_file *file = read_grid(&b);
    planish_mesh mesh = planish_file_mesh(file);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(mesh.dim, 3);
    assert_int_equal(mesh.n_nodes, N_POINTS);
    static const int32_t nodes[] = {0, 1, 2, 3, 1, 2, 3, 4};
    assert_int_equal(mesh.n_elements, 3);
    assert_memory_equal(mesh.cells->node, nodes, sizeof nodes);
    assert_true(mesh.coordinates[14] == 1.5 && mesh.coordinates[20] == 0.3);
    assert_int_equal(info.n_regions, 3);
    assert_int_equal(info.n_other_elements, 0);
    assert_int_equal(info.n_lower_elements, 1);
    assert_int_equal(info.precision, PLANISH_PRECISION_DOUBLE);
    assert_int_equal(planish_file_node_number(file, 6), 6);
    assert_int_equal(file->model.hold[5], 0);
    assert_int_equal(file->model.hold[6], IO_HELD_MARKED);
    assert_int_equal(file->model.hold[4], 0);
    planish_file_close(file);
    builder_release(&b);
}

/** Arrays of numbers are read, and go into other formats; what is lost is told. */
static void arrays_are_read(void **state) {
    grid g = right;
    char lost[512];
    planish_data data;
    g.has_data = 1;
    file_builder b = make(&g);
    planish_file *file = converting_open_built(*state, "data.vtkhdf", &b);
    planish_file *copy = converting_to(*state, file, "vtk", ".vtk", lost);
    assert_string_equal(lost,
                        "the array 'short', positive volumes of 1 solids (they keep the order of "
                        "their nodes), the array 'words', field data, data of elements of lower "
                        "dimensions, parameters and comments");
    for (int k = 0; k < 2; k++) {
        planish_file *of = k ? copy : file;
        assert_int_equal(planish_file_data(of, "heat", &data, NULL), 0);
        assert_true(data.n == N_POINTS && data.n_components == 1 && data.values[5] == 2.5);
        planish_data_free(&data);
        static const double second[] = {11, 14, 12, 16, 15, 13}; /* 11, 12, 22, 13, 23, 33 */
        assert_int_equal(planish_file_data(of, "stress", &data, NULL), 0);
        assert_true(data.n == 3 && data.n_components == 6 && data.of_elements);
        assert_memory_equal(data.values + 6, second, sizeof second);
        planish_data_free(&data);
    }
    assert_int_equal(planish_file_data(file, "short", &data, NULL), PLANISH_ERROR_FORMAT);
    assert_int_equal(planish_file_data(file, "fixed", &data, NULL), PLANISH_ERROR_ARGUMENT);
    planish_file_close(copy);
    planish_file_close(file);
}

static void partitions_follow_each_other(void **state) {
    (void)state;
    grid g = right;
    g.partitions = 2;
    g.type = 5; /* the second partition begins with a triangle of 4 numbers */
    file_builder b = make(&g);
    builder_expect_error(&b, &io_format_vtkhdf, "does not fit its type");
    builder_release(&b);
    g.type = 9; /* a quadrilateral */
    b = make(&g);
    planish_file *file = read_grid(&b);
    planish_mesh mesh = planish_file_mesh(file);
    assert_int_equal(mesh.n_elements, 2);
    assert_int_equal(file->model.flat.n, 1);
    assert_int_equal(file->model.triangle.n, 1);
    static const int32_t nodes[] = {4, 5, 6};
    assert_memory_equal(file->model.triangle.nodes, nodes, sizeof nodes);
    assert_int_equal(file->model.triangle.number[0], 2);
    assert_int_equal(file->model.hold[4] & IO_HELD_BY_FACE, IO_HELD_BY_FACE);
    planish_file_close(file);
    builder_release(&b);
}

static void refuse(const grid *g, const char *part) {
    file_builder b = make(g);
    builder_expect_error(&b, &io_format_vtkhdf, part);
    builder_release(&b);
}

/** Cells of any type hold their nodes; polyhedra those of their faces, too. */
static void other_cells_hold_their_nodes(void **state) {
    (void)state;
    grid g = right;
    g.type = 99;
    file_builder b = make(&g);
    planish_file *file = read_grid(&b);
    assert_int_equal(file->model.n_other, 1);
    assert_int_equal(file->model.solid.n, 1);
    assert_int_equal(file->model.hold[4], IO_HELD_BY_OTHER);
    assert_int_equal(file->model.hold[6], IO_HELD_MARKED);
    planish_file_close(file);
    builder_release(&b);
    g.type = 42;
    g.has_faces = 1;
    b = make(&g);
    file = read_grid(&b);
    assert_int_equal(file->model.hold[6], IO_HELD_MARKED | IO_HELD_BY_OTHER);
    planish_file_close(file);
    builder_release(&b);
    g.has_faces = N_POINTS;
    refuse(&g, "FaceConnectivity: a node");
}

/* ---- what is refused ----------------------------------------------------------------------- */

static void wrong_files_are_refused(void **state) {
    (void)state;
    grid g = right;
    refuse(((void)(g = right, g.node = N_POINTS), &g), "not among the points");
    refuse(((void)(g = right, g.type = 64), &g), "third order or higher");
    refuse(((void)(g = right, g.offset = 2), &g), "rise");
    refuse(((void)(g = right, g.offset = 17), &g), "rise");
    refuse(((void)(g = right, g.points = 8), &g), "NumberOfPoints");
    refuse(((void)(g = right, g.points = 6), &g), "NumberOfPoints");
    refuse(((void)(g = right, g.cells = 3), &g), "NumberOfCells");
    refuse(((void)(g = right, g.cells = 5), &g), "NumberOfCells");
    refuse(((void)(g = right, g.steps = 2), &g), "2 time steps");
    refuse(((void)(g = right, g.kind = "ImageData"), &g), "'ImageData'");
    refuse(((void)(g = right, g.x = 0.0 / 0.0), &g), "not finite");
    refuse(((void)(g = right, g.x = 0.0 / 0.0, g.chunk = 3, g.is_packed = 1), &g), "not finite");
    reading_fails(&io_format_vtkhdf, "no HDF5", "not an HDF5 file");
}

static void nothing_breaks_it(void **state) {
    (void)state;
    grid g = right;
    file_builder b = make(&g);
    builder_try_to_break(&b, &io_format_vtkhdf);
    builder_expect_same_on_threads(&b, &io_format_vtkhdf);
    builder_release(&b);
    g.chunk = 3;
    g.is_packed = 1;
    b = make(&g);
    builder_try_to_break(&b, &io_format_vtkhdf);
    builder_release(&b);
}

/* ---- writing ------------------------------------------------------------------------------- */

static planish_file *open_path(const char *path) {
    planish_file *file;
    planish_error error = {.text = ""};
    if (planish_file_open(path, NULL, 1, &file, &error))
        fail_msg("%s", error.text);
    return file;
}

static void write_path(const planish_file *file, const char *path, const double *coordinates) {
    planish_error error = {.text = ""};
    if (planish_file_write(file, path, coordinates, &(planish_write_options){.threads = 1}, &error))
        fail_msg("%s", error.text);
}

/** Bytes that differ, of those that both have. */
static size_t count_changes(const char *a, const char *b, size_t size) {
    size_t n = 0;
    for (size_t i = 0; i < size; i++)
        n += a[i] != b[i];
    return n;
}

/** Unchanged: the same bytes. Two coordinates changed: these are read again, and where they stand
 *  plainly nothing else has changed. */
static void check_writing(const char *folder, const grid *g, int is_plain) {
    char in[TEST_PATH_SIZE], out[TEST_PATH_SIZE];
    file_builder b = make(g);
    test_write(folder, "in.vtkhdf", b.data, (size_t)b.size);
    planish_file *file = open_path(test_path(in, folder, "in.vtkhdf"));
    test_path(out, folder, "out.vtkhdf");
    double *xyz = planish_file_coordinates(file), before[3 * N_POINTS];
    memcpy(before, xyz, sizeof before);
    write_path(file, out, xyz);
    size_t size;
    char *content = test_read(out, &size);
    assert_int_equal(size, b.size);
    assert_memory_equal(content, b.data, size);
    free(content);
    xyz[5] = -0.625; /* in place: what the file says is in the file alone */
    xyz[18] = 1024;
    write_path(file, out, xyz);
    content = test_read(out, &size);
    if (is_plain) {
        assert_int_equal(size, b.size);
        assert_in_range(count_changes(content, b.data, size), 2, 16);
    }
    free(content);
    planish_file *again = open_path(out);
    before[5] = -0.625;
    before[18] = 1024;
    assert_memory_equal(planish_file_coordinates(again), before, sizeof before);
    assert_int_equal(again->model.hold[6], IO_HELD_MARKED);
    planish_file_close(again);
    assert_int_equal(test_count_files(folder), 2);
    planish_error error = {.text = ""};
    int status =
        planish_file_write(file, "/dev/null", xyz, &(planish_write_options){.threads = 1}, &error);
    assert_int_equal(status, is_plain ? 0 : PLANISH_ERROR_FILE);
    if (!is_plain)
        assert_non_null(strstr(error.text, "cannot be written to a pipe"));
    planish_file_close(file);
    builder_release(&b);
}

static void coordinates_come_back(void **state) {
    grid g = right;
    for (int i = 0; i < 4 * HDF5_SUPERBLOCKS; i++) {
        hdf5_superblock = hdf5_superblocks[i / 4];
        g.is_float = i & 1;
        g.is_big = i >> 1 & 1;
        g.chunk = g.is_packed = g.is_compact = 0;
        check_writing(*state, &g, 1);
        g.user_block = 512;
        check_writing(*state, &g, 1);
        g.chunk = 3;
        check_writing(*state, &g, 0); /* the library does not tell where such chunks are */
        g.user_block = 0;
        check_writing(*state, &g, 1);
        g.columns_apart = 1;
        check_writing(*state, &g, 0);
        g.columns_apart = 0;
        g.is_packed = 1;
        check_writing(*state, &g, 0);
        g.is_compact = 1;
        g.chunk = 0;
        check_writing(*state, &g, 0);
    }
    hdf5_superblock = 0;
}

/** The library writes where free space is as it closes the file. */
static void free_space_may_be_kept(void **state) {
    grid g = right;
    hdf5_has_pages = 1;
    g.chunk = 3;
    g.is_packed = 1;
    for (int i = 0; i < 2; i++) {
        hdf5_superblock = 3 * i;
        check_writing(*state, &g, 0);
    }
    hdf5_has_pages = hdf5_superblock = 0;
}

/** Why the library does not open a file is said: here its superblock is damaged. */
static void reasons_of_the_library_are_told(void **state) {
    (void)state;
    hdf5_superblock = 3;
    file_builder b = make(&right);
    hdf5_superblock = 0;
    b.data[20] ^= 1;
    builder_expect_error(&b, &io_format_vtkhdf, "cannot be opened (HDF5: incorrect");
    builder_release(&b);
}

static void the_input_may_be_replaced(void **state) {
    char path[TEST_PATH_SIZE];
    grid g = right;
    g.chunk = 3;
    g.is_packed = 1;
    file_builder b = make(&g);
    test_write(*state, "in.vtkhdf", b.data, (size_t)b.size);
    planish_file *file = open_path(test_path(path, *state, "in.vtkhdf"));
    planish_file_coordinates(file)[5] = -0.625;
    write_path(file, path, planish_file_coordinates(file));
    planish_file_close(file);
    file = open_path(path);
    assert_true(planish_file_coordinates(file)[5] == -0.625);
    planish_file_close(file);
    assert_int_equal(test_count_files(*state), 1);
    builder_release(&b);
}

/** A compact array stands behind its number of bytes, which is damaged here. */
static void values_without_bytes_are_refused(void **state) {
    (void)state;
    grid g = right;
    g.is_compact = 1;
    file_builder b = make(&g);
    /* 0, 0, 0, 1 in little-endian order, and what comes before: version, class, bytes. */
    const unsigned char first[4 * sizeof(double)] = {[30] = 0xf0, [31] = 0x3f};
    const unsigned char head[] = {3, 0, N_POINTS * 3 * sizeof(double), 0};
    char array[sizeof head + sizeof first];
    memcpy(array, head, sizeof head);
    memcpy(array + sizeof head, first, sizeof first);
    int64_t at = 0;
    while (at + (int64_t)sizeof array < b.size && memcmp(b.data + at, array, sizeof array) != 0)
        at++;
    assert_true(at + (int64_t)sizeof array < b.size);
    b.data[at + 2] = 0;
    builder_expect_error(&b, &io_format_vtkhdf, "values are not where they should be");
    builder_release(&b);
}

/** How the library tells of errors is the caller's. */
static herr_t listener(hid_t stack, void *data) {
    (void)stack;
    ++*(int *)data;
    return 0;
}

static void errors_are_told_as_before(void **state) {
    (void)state;
    int heard = 0;
    file_builder b = make(&right);
    b.size -= 100;
    H5Eset_auto2(H5E_DEFAULT, listener, &heard);
    builder_expect_error(&b, &io_format_vtkhdf, "HDF5");
    assert_int_equal(heard, 0);
    assert_true(H5Gopen2(-1, "nowhere", H5P_DEFAULT) < 0);
    assert_int_equal(heard, 1);
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    builder_release(&b);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_grid_is_read),
        cmocka_unit_test_setup_teardown(arrays_are_read, test_folder_create, test_folder_remove),
        cmocka_unit_test(partitions_follow_each_other),
        cmocka_unit_test(other_cells_hold_their_nodes),
        cmocka_unit_test(wrong_files_are_refused),
        cmocka_unit_test(values_without_bytes_are_refused),
        cmocka_unit_test(nothing_breaks_it),
        cmocka_unit_test_setup_teardown(coordinates_come_back, test_folder_create,
                                        test_folder_remove),
        cmocka_unit_test_setup_teardown(free_space_may_be_kept, test_folder_create,
                                        test_folder_remove),
        cmocka_unit_test(reasons_of_the_library_are_told),
        cmocka_unit_test_setup_teardown(the_input_may_be_replaced, test_folder_create,
                                        test_folder_remove),
        cmocka_unit_test(errors_are_told_as_before),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#else

static void the_library_is_asked_for(void **state) {
    (void)state;
    reading_fails(&io_format_vtkhdf, "anything", "built without HDF5, which vtkhdf files need");
    reading_fails(&io_format_med, "anything", "built without HDF5, which med files need");
    reading_fails(&io_format_cgns, "anything", "built without HDF5, which cgns files need");
    reading_fails(&io_format_plex, "anything", "built without HDF5, which dmplex files need");
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_library_is_asked_for)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#endif
