/* MED: what is read, held and refused, families and groups. */
#include "support/converting.h"
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

enum { N = 6, NAME = 80 };
#define STEP "-0000000000000000001-0000000000000000001"

/** Two tetrahedra of different families, a triangle, an edge, a point, a quadrilateral. */
typedef struct mesh {
    int version; /* 2: no steps */
    int dim;     /* of space; 2: triangles alone */
    int axis, structured, second_mesh, second_step, descending, nodes_said, elements_said, node;
    int has_numbers, is_packed;
    int is_chunked;    /* without packing; a chunk has coordinates of two directions */
    const char *extra; /* a type of elements besides */
    double x;
} mesh;

static const mesh right = {
    .version = 4, .dim = 3, .node = 5, .nodes_said = N, .elements_said = 2, .has_numbers = 1};

static void put_family(const hdf5_builder *b, const char *path, int number, const char *first,
                       const char *second) {
    char place[256], names[2 * NAME] = "";
    hdf5_group(b, path);
    hdf5_attribute(b, path, "NUM", number);
    if (!first)
        return;
    strcpy(names, first);
    memset(names + NAME, ' ', NAME); /* some fill up with blanks */
    memcpy(names + NAME, second ? second : "", second ? strlen(second) : 0);
    hid_t type = H5Tarray_create2(H5T_STD_I8LE, 1, (const hsize_t[]){NAME});
    snprintf(place, sizeof place, "%s/GRO", path);
    hdf5_group(b, place);
    snprintf(place, sizeof place, "%s/GRO/NOM", path);
    hdf5_array(b, place, type, type, second ? 2 : 1, 0, names);
    H5Tclose(type);
}

static void put_elements(const hdf5_builder *b, const char *step, const char *name, int n,
                         int nodes, const int *list, const int *families, const mesh *m) {
    char group[256], path[300];
    snprintf(group, sizeof group, "%s/MAI/%s", step, name);
    hdf5_group(b, group);
    snprintf(path, sizeof path, "%s/%s", group, m->descending ? "DES" : "NOD");
    hdf5_integers(b, path, (hsize_t)(n * nodes), list);
    hdf5_attribute(b, path, "NBR", strcmp(name, "TE4") == 0 ? m->elements_said : n);
    if (!families)
        return;
    snprintf(path, sizeof path, "%s/FAM", group);
    hdf5_integers(b, path, (hsize_t)n, families);
}

static void put_mesh(hdf5_builder *b, const mesh *m, const char *step) {
    static const double x[] = {0, 1, 0, 0, 1, 2}, y[] = {0, 0, 1, 0, 1, 2},
                        z[] = {0, 0, 0, 1, 1.5, 2};
    static const int numbers[] = {10, 20, 30, 40, 50, 60}, families[] = {0, 0, 3, 0, 0, 3};
    static const int element_numbers[] = {101, 102};
    char path[256];
    double xyz[3 * N];
    memcpy(xyz, x, sizeof x);
    memcpy(xyz + N, y, sizeof y);
    memcpy(xyz + 2 * N, z, sizeof z);
    xyz[1] += m->x;
    snprintf(path, sizeof path, "%s/NOE", step);
    hdf5_group(b, path);
    snprintf(path, sizeof path, "%s/NOE/COO", step);
    b->chunk[0] = m->is_packed || m->is_chunked ? 4 : 0;
    b->is_packed = m->is_packed;
    hdf5_reals(b, path, (hsize_t)(m->dim * N), xyz);
    b->chunk[0] = 0;
    hdf5_attribute(b, path, "NBR", m->nodes_said);
    snprintf(path, sizeof path, "%s/NOE/FAM", step);
    hdf5_integers(b, path, N, families);
    const int tetrahedra[] = {1, 2, 2, 3, 3, 4, 4, m->node};
    static const int triangle[] = {1, 2, 3}, edge[] = {5, 6}, four[] = {1, 2, 3, 6};
    if (m->has_numbers) {
        snprintf(path, sizeof path, "%s/NOE/NUM", step);
        hdf5_integers(b, path, N, numbers);
    }
    if (m->dim == 3)
        put_elements(b, step, "TE4", 2, 4, tetrahedra, (const int[]){-1, -2}, m);
    put_elements(b, step, "TR3", 1, 3, triangle, (const int[]){-4}, m);
    put_elements(b, step, "SE2", 1, 2, edge, NULL, m);
    put_elements(b, step, "PO1", 1, 1, edge + 1, NULL, m);
    if (m->extra)
        put_elements(b, step, m->extra, 1, 4, four, NULL, m);
    if (m->has_numbers && m->dim == 3) {
        snprintf(path, sizeof path, "%s/MAI/TE4/NUM", step);
        hdf5_integers(b, path, 2, element_numbers);
    }
}

static file_builder make(const mesh *m) {
    hdf5_builder b;
    const char *step = m->version == 2 ? "/ENS_MAA/part" : "/ENS_MAA/part/" STEP;
    hdf5_begin(&b, 0);
    hdf5_group(&b, "/ENS_MAA/part");
    if (m->version > 2)
        hdf5_group(&b, step);
    if (m->second_mesh)
        hdf5_group(&b, "/ENS_MAA/other");
    if (m->second_step)
        hdf5_group(&b, "/ENS_MAA/part/later");
    hdf5_attribute(&b, "/ENS_MAA/part", "DIM", m->dim);
    if (m->version > 2)
        hdf5_attribute(&b, "/ENS_MAA/part", "ESP", m->dim);
    hdf5_attribute(&b, "/ENS_MAA/part", "REP", m->axis);
    hdf5_attribute(&b, "/ENS_MAA/part", "TYP", m->structured);
    put_mesh(&b, m, step);
    put_family(&b, "/FAS/part/FAMILLE_ZERO", 0, NULL, NULL);
    put_family(&b, "/FAS/part/ELEME/FAM_-1", -1, "all", "lower");
    put_family(&b, "/FAS/part/ELEME/FAM_-2", -2, "all", "upper");
    put_family(&b, "/FAS/part/ELEME/FAM_-4", -4, "face", NULL);
    put_family(&b, "/FAS/part/ELEME/FAM_-9", -9, "unused", NULL);
    put_family(&b, "/FAS/part/NOEUD/FAM_3", 3, "pinned", NULL);
    return hdf5_end(&b);
}

static planish_file *read_mesh(const mesh *m) {
    file_builder b = make(m);
    planish_file *file = builder_file(&b, &io_format_med);
    builder_release(&b); /* what is asked for later is in the model */
    return file;
}

/* ---- what is read -------------------------------------------------------------------------- */

static void check_solid(const planish_file *file) {
    planish_mesh got = planish_file_mesh(file);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(got.dim, 3);
    assert_int_equal(got.n_nodes, N);
    assert_int_equal(got.n_elements, 2);
    static const int32_t nodes[] = {0, 1, 2, 3, 1, 2, 3, 4};
    assert_memory_equal(got.elements, nodes, sizeof nodes);
    assert_true(got.coordinates[3] == 1 && got.coordinates[14] == 1.5 && got.coordinates[16] == 2);
    assert_int_equal(info.n_regions, 2);
    assert_int_equal(info.n_lower_elements, 3);
    assert_int_equal(file->model.hold[0], IO_HELD_BY_FACE);
    assert_int_equal(file->model.hold[4], IO_HELD_BY_LINE);
    assert_int_equal(file->model.hold[5], IO_HELD_BY_LINE | IO_HELD_BY_POINT);
    assert_int_equal(file->model.hold[3], 0);
}

static void a_mesh_is_read(void **state) {
    (void)state;
    file_builder b = make(&right);
    assert_int_equal(io_format_med.recognise(b.data, b.size), 1);
    assert_int_equal(io_format_vtkhdf.recognise(b.data, b.size), 0);
    builder_release(&b);
    planish_file *file = read_mesh(&right);
    check_solid(file);
    assert_int_equal(planish_file_node_number(file, 5), 60);
    assert_int_equal(planish_file_element_number(file, 1), 102);
    planish_file_close(file);
    mesh m = right;
    m.version = 2;
    m.has_numbers = 0;
    file = read_mesh(&m);
    check_solid(file);
    assert_int_equal(planish_file_node_number(file, 5), 6);
    assert_int_equal(planish_file_element_number(file, 1), 2);
    planish_file_close(file);
    m.is_packed = 1;
    file = read_mesh(&m);
    check_solid(file);
    planish_file_close(file);
}

static void a_plane_is_read(void **state) {
    (void)state;
    mesh m = right;
    m.dim = 2;
    planish_file *file = read_mesh(&m);
    planish_mesh plane = planish_file_mesh(file);
    assert_int_equal(plane.dim, 2);
    assert_int_equal(plane.n_elements, 1);
    assert_true(plane.coordinates[8] == 1 && plane.coordinates[9] == 1);
    planish_file_close(file);
}

static void other_elements_hold_their_nodes(void **state) {
    (void)state;
    mesh m = right;
    m.extra = "POG"; /* and any type that is not known */
    planish_file *file = read_mesh(&m);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(info.n_other_elements, 1);
    assert_int_equal(file->model.hold[1] & IO_HELD_BY_OTHER, IO_HELD_BY_OTHER);
    assert_int_equal(file->model.hold[3] & IO_HELD_BY_OTHER, 0);
    planish_file_close(file);
}

static void groups_have_names(void **state) {
    (void)state;
    planish_file *file = read_mesh(&right);
    reading_holds(file, NULL, 0, "111011");
    reading_holds(file, "lower", 0, "111111");
    reading_holds(file, "all", 0, "111111");
    reading_holds(file, "face", 0, "111011");
    reading_holds(file, "pinned", 0, "111011");
    reading_holds(file, "3:-1", 0, "111111");
    uint8_t constraint[N];
    planish_error error;
    const char *unknown = "unused";
    const planish_hold hold = {.tags = &unknown, .n_tags = 1};
    assert_int_equal(planish_file_constraints(file, &hold, constraint, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "upper"));
    const char *const slide[] = {"face"};
    const planish_hold sliding = {.slide = 1, .slide_tags = slide, .n_slide_tags = 1};
    assert_int_equal(planish_file_constraints(file, &sliding, constraint, &error), 0);
    const char *const volume[] = {"upper"};
    const double least = 0.25;
    double volumes[2];
    assert_int_equal(planish_file_min_volumes(file, volume, &least, 1, volumes, &error), 0);
    assert_true(volumes[0] == 0 && volumes[1] == 0.25);
    planish_file_close(file);
}

/** Groups of elements are in Gmsh's files, though numbers of families are negative. */
static void groups_are_converted(void **state) {
    char path[TEST_PATH_SIZE], lost[512];
    file_builder b = make(&right);
    planish_file *file = converting_open_built(*state, "part.med", &b);
    planish_file_close(converting_to(*state, file, "gmsh", ".msh", lost));
    char *text = test_read(test_path(path, *state, "out-gmsh.msh"), NULL);
    assert_non_null(strstr(text, "$PhysicalNames\n4\n3 1 \"all\"\n3 2 \"lower\"\n3 3 \"upper\"\n"
                                 "2 4 \"face\"\n$EndPhysicalNames\n"));
    assert_non_null(strstr(lost, "groups of nodes"));
    assert_null(strstr(lost, "numbers of groups"));
    free(text);
    planish_file_close(file);
}

/* ---- what is refused ----------------------------------------------------------------------- */

static void refuse(mesh m, const char *part) {
    file_builder b = make(&m);
    builder_expect_error(&b, &io_format_med, part);
    builder_release(&b);
}

static void wrong_files_are_refused(void **state) {
    (void)state;
    mesh m = right;
    refuse(((void)(m.axis = 1), m), "cylindrical");
    m = right;
    refuse(((void)(m.structured = 1), m), "structured");
    m = right;
    refuse(((void)(m.second_mesh = 1), m), "one mesh");
    m = right;
    refuse(((void)(m.second_step = 1), m), "one step");
    m = right;
    refuse(((void)(m.descending = 1), m), "descending");
    m = right;
    refuse(((void)(m.nodes_said = 5), m), "COO: its attribute NBR");
    m = right;
    refuse(((void)(m.elements_said = 3), m), "TE4/NOD: its attribute NBR");
    m = right;
    refuse(((void)(m.node = 7), m), "element 2: node 7 is not in 1 .. 6");
    m = right;
    refuse(((void)(m.node = 0), m), "not in 1 .. 6");
    m = right;
    refuse(((void)(m.extra = "T10"), m), "4 numbers do not make elements of 10 nodes");
    m = right;
    refuse(((void)(m.x = 1e308 * 10), m), "not finite");
    m = right;
    m.dim = 1;
    refuse(m, "1 dimensions");
}

static void nothing_breaks_it(void **state) {
    (void)state;
    mesh m = right;
    m.extra = "QU4";
    file_builder b = make(&m);
    builder_try_to_break(&b, &io_format_med);
    builder_expect_same_on_threads(&b, &io_format_med);
    builder_release(&b);
}

/* ---- writing ------------------------------------------------------------------------------- */

static void check_writing(const char *folder, const mesh *m) {
    file_builder b = make(m);
    rewriting_in_place(b.data, b.size, m->is_packed, folder, "in.med");
    builder_release(&b);
}

static void coordinates_come_back(void **state) {
    for (int i = 0; i < HDF5_SUPERBLOCKS; i++) {
        mesh m = right;
        hdf5_superblock = hdf5_superblocks[i];
        check_writing(*state, &m);
        m.is_chunked = 1;
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
        cmocka_unit_test(other_elements_hold_their_nodes),
        cmocka_unit_test(groups_have_names),
        cmocka_unit_test_setup_teardown(groups_are_converted, test_folder_create,
                                        test_folder_remove),
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
