/* Every function of planish_io.h, with a file of every format: whichever allocation fails, the call
 * says so and leaves everything as it was, no file included, or gives what it would have given, and
 * so does the next call. */
#include "support/data_files.h"
#include "support/effort.h"
#include "support/faults.h"
#include "support/files.h"
#include "support/hdf5_builder.h"

#include <planish/planish_io.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

/** A mesh file, and an empty folder for what is made of it. */
typedef struct case_of {
    const char *path, *folder;
    const char *extension; /* of what is written */
} case_of;

/* ---- what is asked of a file ------------------------------------------------------------------
 */

/** Regions as text, and the first that has one, as a tag. */
static void add_regions(faults *f, const planish_file *file, char *tag, size_t size) {
    const planish_mesh mesh = planish_file_mesh(file);
    tag[0] = '\0';
    for (int64_t e = 0; e < mesh.n_elements; e += 50) {
        char text[64];
        const int length = planish_file_element_region(file, e, text, sizeof text);
        assert_true(length >= 0);
        faults_add(f, text, strlen(text));
        if (!tag[0])
            snprintf(tag, size, "%s", text);
    }
}

static void add_info(faults *f, const planish_file *file) {
    const planish_mesh mesh = planish_file_mesh(file);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_true(info.n_regions > 0);
    faults_add(f, &info.n_regions, sizeof info.n_regions);
    faults_add(f, &info.is_unterminated, sizeof info.is_unterminated);
    faults_add(f, mesh.elements, (size_t)(mesh.n_elements * (mesh.dim + 1)) * sizeof(int32_t));
    faults_add(f, mesh.coordinates, (size_t)(mesh.n_nodes * mesh.dim) * sizeof(double));
    for (int64_t i = 0; i < mesh.n_nodes; i += 10) {
        const int64_t number = planish_file_node_number(file, i);
        faults_add(f, &number, sizeof number);
    }
    const int64_t number = planish_file_element_number(file, mesh.n_elements - 1);
    faults_add(f, &number, sizeof number);
}

/** planish_file_constraints, _marks, _surface. */
static void hold(faults *f, const planish_file *file, const char *tag) {
    const planish_mesh mesh = planish_file_mesh(file);
    const size_t n = (size_t)mesh.n_nodes;
    const planish_hold holds[] = {{.slide = 1}, {.tags = &tag, .n_tags = tag[0] != '\0'}};
    uint8_t *constraint = malloc(n);
    planish_error error;
    for (int i = 0; i < 2; i++) {
        int status;
        do {
            faults_mark(constraint, n);
            status = planish_file_constraints(file, &holds[i], constraint, &error);
            assert_true(!status || faults_is_marked(constraint, n));
        } while (faults_refused(f, status, &error));
        faults_add(f, constraint, n);
    }
    const int64_t marked = planish_file_get_marked(file, constraint);
    const planish_surface surface = planish_file_surface(file, &holds[0]);
    faults_add(f, &marked, sizeof marked);
    faults_add(f, constraint, n);
    faults_add(f, &surface.n_facets, sizeof surface.n_facets);
    faults_add(f, &surface.n_edges, sizeof surface.n_edges);
    free(constraint);
}

static void ask_min_volumes(faults *f, const planish_file *file, const char *tag) {
    const size_t bytes = (size_t)planish_file_mesh(file).n_elements * sizeof(double);
    const double least = 0.5;
    double *volumes = malloc(bytes);
    planish_error error;
    int status;
    do {
        faults_mark(volumes, bytes);
        status = planish_file_min_volumes(file, &tag, &least, tag[0] != '\0', volumes, &error);
        assert_true(!status || faults_is_marked(volumes, bytes));
    } while (faults_refused(f, status, &error));
    faults_add(f, volumes, bytes);
    free(volumes);
}

/* ---- what is written ---------------------------------------------------------------------------
 */

/** Add what has been written under path, a file or a folder with the one that has the coordinates, and
 *  remove it. */
static void take_file(faults *f, const char *path) {
    static const char *const inner[] = {"mesh.nodes", "constant/polyMesh/points"};
    size_t size;
    for (int i = 0; i < 2; i++) {
        char within[TEST_PATH_SIZE];
        if (access(test_path(within, path, inner[i]), F_OK) == 0) {
            void *folder = strdup(path);
            char *points = test_read(within, &size);
            faults_add(f, points, size);
            free(points);
            assert_int_equal(test_folder_remove(&folder), 0);
            return;
        }
    }
    char *data = test_read(path, &size);
    assert_true(size > 0);
    faults_add(f, data, size);
    free(data);
    unlink(path);
}

/** planish_file_write, or planish_file_convert, to a file of this extension. */
static void write_to(faults *f, const case_of *c, planish_file *file, const double *x,
                     const char *extension) {
    char path[TEST_PATH_SIZE], name[64], temporary[1024] = "", lost[256] = "";
    planish_error error;
    int status;
    snprintf(name, sizeof name, "out%s", extension);
    test_path(path, c->folder, name);
    const int is_own = planish_file_can_write(file, path);
    assert_true(is_own || planish_file_can_convert(file, path));
    do {
        status =
            is_own
                ? planish_file_write(file, path, x,
                                     &(planish_write_options){.threads = 1,
                                                              .temporary = temporary,
                                                              .temporary_size = sizeof temporary},
                                     &error)
                : planish_file_convert(
                      file, path, x,
                      &(planish_convert_options){.temporary = temporary,
                                                 .temporary_size = sizeof temporary,
                                                 .lost = lost,
                                                 .lost_size = sizeof lost},
                      &error);
        assert_true(temporary[0] == '\0');
        assert_true(!status || test_count_files(c->folder) == 0);
    } while (faults_refused(f, status, &error));
    take_file(f, path);
    faults_add(f, lost, strlen(lost));
    if (strcmp(extension, ".node") == 0)
        take_file(f, test_path(path, c->folder, "out.ele"));
    assert_int_equal(test_count_files(c->folder), 0);
}

static void write_all(faults *f, const case_of *c, planish_file *file) {
    static const char *const views[] = {".vtu", ".vtk", ".msh", ".inp", ".e"};
    const planish_mesh mesh = planish_file_mesh(file);
    const int64_t n = mesh.n_nodes * mesh.dim;
    double *x = malloc((size_t)n * sizeof *x);
    for (int64_t i = 0; i < n; i++)
        x[i] = mesh.coordinates[i] * 1.0625;
    write_to(f, c, file, x, c->extension);
    for (int i = 0; i < 5; i++)
        if (planish_file_can_convert(file, views[i]))
            write_to(f, c, file, x, views[i]);
    free(x);
}

static void call_all(const void *world, faults *f) {
    const case_of *c = world;
    planish_file *file = NULL;
    planish_error error;
    char tag[64];
    int status;
    do {
        status = planish_file_open(c->path, NULL, 1, &file, &error);
        assert_true(!status || file == NULL);
    } while (faults_refused(f, status, &error));
    add_info(f, file);
    add_regions(f, file, tag, sizeof tag);
    hold(f, file, tag);
    ask_min_volumes(f, file, tag);
    write_all(f, c, file);
    planish_file_close(file);
}

/* ---- files -------------------------------------------------------------------------------------
 */

enum { SOME = 40 };

static int64_t try_file(const char *name, const char *path, const char *folder) {
    const char *dot = strrchr(name, '.');
    const case_of c = {path, folder, dot ? dot : ""};
    return faults_try(name, call_all, &c, SOME);
}

static void every_allocation_fails_once(void **state) {
    int64_t runs = 0;
    int n = 0;
    for (const test_data_file *data = test_data_files; data->name; data++) {
        char path[TEST_PATH_SIZE];
        if (!test_data_path(path, data))
            continue;
        runs += try_file(data->name, path, *state);
        n++;
    }
    figure("%d files, %d runs without some memory", n, (int)runs);
}

#ifdef PL_HDF5

/** A file of its own in a folder of its own. */
static void try_bytes(const char *name, const char *data, size_t size, const char *folder) {
    void *place;
    char path[TEST_PATH_SIZE];
    assert_int_equal(test_folder_create(&place), 0);
    test_write(place, name, data, size);
    try_file(name, test_path(path, place, name), folder);
    test_folder_remove(&place);
}

/** cube.vtkhdf with its coordinates packed: HDF5 itself changes the copy that is written. */
static void packed_coordinates(void **state) {
    char path[TEST_PATH_SIZE], copy[TEST_PATH_SIZE];
    const hsize_t chunk[] = {32, 3};
    size_t size;
    char *data = test_read(test_path_from(path, "PLANISH_TEST_DATA", "cube.vtkhdf"), &size);
    test_write(*state, "packed.vtkhdf", data, size);
    free(data);
    const hid_t file = H5Fopen(test_path(copy, *state, "packed.vtkhdf"), H5F_ACC_RDWR, H5P_DEFAULT);
    const hid_t plain = H5Dopen2(file, "/VTKHDF/Points", H5P_DEFAULT), type = H5Dget_type(plain);
    const hid_t space = H5Dget_space(plain), how = H5Pcreate(H5P_DATASET_CREATE);
    double *x = malloc((size_t)H5Sget_simple_extent_npoints(space) * sizeof *x);
    assert_true(H5Dread(plain, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, x) >= 0);
    assert_true(H5Ldelete(file, "/VTKHDF/Points", H5P_DEFAULT) >= 0);
    H5Pset_chunk(how, 2, chunk);
    H5Pset_deflate(how, 6);
    const hid_t packed =
        H5Dcreate2(file, "/VTKHDF/Points", type, space, H5P_DEFAULT, how, H5P_DEFAULT);
    assert_true(H5Dwrite(packed, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, x) >= 0);
    free(x);
    H5Dclose(packed), H5Dclose(plain), H5Tclose(type), H5Sclose(space), H5Pclose(how);
    assert_true(H5Fclose(file) >= 0);
    data = test_read(copy, &size);
    unlink(copy);
    try_bytes("packed.vtkhdf", data, size, *state);
    free(data);
}

#endif

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(every_allocation_fails_once, test_folder_create,
                                        test_folder_remove),
#ifdef PL_HDF5
        cmocka_unit_test_setup_teardown(packed_coordinates, test_folder_create, test_folder_remove),
#endif
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
