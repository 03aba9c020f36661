/* DMPlex: elements by their points, with the corners in PETSc's order; labels; all three forms. */
#include "support/files.h"
#include "support/hdf5_builder.h"
#include "support/plex_builder.h"
#include "support/reading.h"

#include "io/core/bytes.h"
#include "io/plex/plex.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#ifdef PL_HDF5

/* ---- what is read -------------------------------------------------------------------------- */

static void check_mesh(planish_file *file) {
    planish_mesh mesh = planish_file_mesh(file);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(mesh.dim, 3);
    assert_int_equal(mesh.n_nodes, N_NODES);
    assert_int_equal(mesh.n_elements, N_ELEMENTS);
    assert_memory_equal(mesh.elements, plex_corners, sizeof plex_corners);
    assert_memory_equal(mesh.coordinates, plex_places, sizeof plex_places);
    assert_int_equal(info.n_regions, 2);
    assert_int_equal(info.n_other_elements, 0);
    assert_int_equal(planish_file_node_number(file, 3), 3);
    assert_int_equal(planish_file_element_number(file, 5), 5);
}

static void all_forms_are_read(void **state) {
    (void)state;
    for (int version = 1; version <= 3; version++)
        for (int how = 0; how < 8; how++) {
            plex p = plex_right;
            p.version = version;
            p.is_permuted = version < 3 && (how & 1);
            p.is_one_chunk = how >> 1 & 1;
            p.has_user_block = how >> 2;
            planish_file *file = plex_read(&p);
            check_mesh(file);
            planish_file_close(file);
        }
}

/** Firedrake's group of mixed meshes is no mesh; labels may be many, and of nothing. */
static void other_groups_are_no_meshes(void **state) {
    (void)state;
    plex p = plex_right;
    p.version = 3;
    p.meshes = 3;
    planish_file *file = plex_read(&p);
    check_mesh(file);
    planish_file_close(file);
}

static int count_held(planish_file *file, const planish_hold *hold, uint8_t *constraint) {
    planish_error error = {.text = ""};
    int n = 0;
    if (planish_file_constraints(file, hold, constraint, &error))
        return -1;
    for (int i = 0; i < N_NODES; i++)
        n += constraint[i] == PLANISH_CONSTRAINT_FIXED;
    return n;
}

/** The corners, in any sense. */
static void check_triangle(const int32_t *nodes, const int32_t *expected) {
    for (int i = 0; i < 3; i++) {
        int found = 0;
        for (int j = 0; j < 3; j++)
            found += nodes[j] == expected[i];
        assert_int_equal(found, 1);
    }
}

/** Of the sets of facets and edges these hold their nodes, of the others a name may. */
static void labels_are_surfaces_lines_and_groups(void **state) {
    (void)state;
    planish_file *file = plex_read(&plex_right);
    const io_model *model = &file->model;
    static const int32_t faces[] = {0, 1, 2, 1, 2, 3, 0, 2, 5}, edge[] = {3, 4};
    uint8_t constraint[N_NODES];
    assert_int_equal(model->triangle.n, 3);
    for (int i = 0; i < 3; i++)
        check_triangle(model->triangle.nodes + 3 * i, faces + 3 * i);
    assert_int_equal(model->line.n, 1);
    assert_memory_equal(model->line.nodes, edge, sizeof edge);
    assert_true(model->triangle.entity[0] == model->triangle.entity[1] &&
                model->triangle.entity[0] != model->triangle.entity[2]);
    const char *tip[] = {"tip"}, *wall[] = {"wall:1"}, *cells[] = {"Cell Sets:8"}, *no[] = {"x"};
    planish_hold hold = {.ignore_regions = 1};
    assert_int_equal(count_held(file, &hold, constraint), 6); /* not 6 and 7 */
    hold.slide = 1;
    assert_int_equal(count_held(file, &hold, constraint), 0);
    hold.tags = tip;
    hold.n_tags = 1;
    assert_int_equal(count_held(file, &hold, constraint), 1);
    assert_int_equal(constraint[6], PLANISH_CONSTRAINT_FIXED);
    hold.tags = wall;
    assert_int_equal(count_held(file, &hold, constraint), 3);
    assert_true(constraint[0] && constraint[2] && constraint[5]);
    hold.tags = cells;
    assert_int_equal(count_held(file, &hold, constraint), 6); /* not 5 and 6 */
    assert_true(!constraint[5] && !constraint[6]);
    hold.tags = no;
    assert_int_equal(count_held(file, &hold, constraint), -1);
    planish_surface surface = planish_file_surface(file, &hold);
    assert_int_equal(surface.n_facets, 3);
    assert_int_equal(surface.n_edges, 1);
    char region[32];
    planish_file_element_region(file, 1, region, sizeof region);
    assert_string_equal(region, "Cell Sets:8");
    planish_file_close(file);
}

static void other_elements_are_read(void **state) {
    (void)state;
    plex p = plex_right;
    p.is_flat = 1;
    planish_file *file = plex_read(&p);
    planish_mesh mesh = planish_file_mesh(file);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(mesh.n_elements, N_ELEMENTS);
    assert_memory_equal(mesh.cells->node, plex_corners, 5 * 4 * sizeof *plex_corners);
    assert_int_equal(info.n_other_elements, 0);
    for (int i = 0; i < N_NODES; i++)
        assert_int_equal(file->model.hold[i], 0);
    planish_file_close(file);
}

static void an_outline_says_what_there_is(void **state) {
    char path[TEST_PATH_SIZE];
    io_plex_outline outline;
    planish_error error = {.text = ""};
    plex p = plex_right;
    p.version = 2;
    file_builder b = plex_make(&p);
    test_write(*state, "in.h5", b.data, (size_t)b.size);
    assert_int_equal(io_plex_outline_of(test_path(path, *state, "in.h5"), &outline, &error), 0);
    assert_int_equal(outline.version, 2);
    assert_string_equal(outline.name, "mine");
    assert_string_equal(outline.coordinates, "/topologies/mine/dms/where/vecs/x/x");
    assert_true(outline.dim == 3 && outline.columns == 3 && outline.n_nodes == N_NODES);
    assert_true(outline.has_simplices_alone && !outline.has_regions_alone);
    builder_release(&b);
    p = plex_right;
    p.is_flat = 1; /* its one label is that of regions */
    b = plex_make(&p);
    test_write(*state, "in.h5", b.data, (size_t)b.size);
    assert_int_equal(io_plex_outline_of(path, &outline, &error), 0);
    assert_true(outline.version == 1 && outline.name[0] == '\0' && outline.has_regions_alone);
    assert_false(outline.has_simplices_alone);
    assert_string_equal(outline.coordinates, "/geometry/vertices");
    builder_release(&b);
    p.labelled = 1; /* an element of two regions */
    b = plex_make(&p);
    test_write(*state, "in.h5", b.data, (size_t)b.size);
    assert_int_equal(io_plex_outline_of(path, &outline, &error), 0);
    assert_false(outline.has_regions_alone);
    builder_release(&b);
    p = plex_right;
    p.cone = 3; /* an element that bounds another one */
    b = plex_make(&p);
    test_write(*state, "in.h5", b.data, (size_t)b.size);
    assert_int_equal(io_plex_outline_of(path, &outline, &error), 0);
    assert_false(outline.has_simplices_alone);
    builder_release(&b);
    assert_int_not_equal(io_plex_outline_of("/nowhere.h5", &outline, &error), 0);
}

/* ---- what is refused ----------------------------------------------------------------------- */

static void refuse(const plex *p, const char *part) {
    file_builder b = plex_make(p);
    builder_expect_error(&b, &io_format_plex, part);
    builder_release(&b);
}

static void wrong_files_are_refused(void **state) {
    (void)state;
    plex p;
    for (int version = 1; version <= 3; version++) {
        p = plex_right;
        p.version = version;
        plex q;
        refuse(((void)(q = p, q.dim = 1), &q), "elements of dimension 1");
        refuse(((void)(q = p, q.cone = 51), &q), "of the wrong kind");
        refuse(((void)(q = p, q.cone = version < 3 ? 3 : 20), &q), "of the wrong kind");
        refuse(((void)(q = p, q.size = 2), &q), "in all");
        refuse(((void)(q = p, q.size = 100), &q), "bounded by 100 others");
        refuse(((void)(q = p, q.labelled = N_POINTS), &q), "point 51 is not in 0 .. 50");
        refuse(((void)(q = p, q.rows = N_NODES - 1), &q),
               "21 coordinates in rows of 3 for 8 nodes");
        refuse(((void)(q = p, q.x = 0.0 / 0.0), &q), "not finite");
    }
    p = plex_right;
    refuse(((void)(p = plex_right, p.is_dangling = 1), &p), "/labels/gone: cannot be looked at");
    refuse(((void)(p = plex_right, p.order = 2), &p), "twice");
    refuse(((void)(p = plex_right, p.has_nodes_last = 1), &p),
           "numbered between elements and nodes");
    refuse(((void)(p = plex_right, p.order = N_POINTS), &p), "point 51");
    refuse(((void)(p = plex_right, p.version = 2, p.row = 7), &p), "one place for each node");
    refuse(((void)(p = plex_right, p.version = 2, p.meshes = 2), &p),
           "one mesh: 2 (mine, other, ...)");
    p = plex_right;
    p.version = 3;
    p.has_no_copy = 1;
    refuse(((void)(p.copies = FUNCTION), &p), "coordinates of 'm', too, but not the same values");
    refuse(((void)(p.copies = VIEWED), &p), "/viz/geometry/vertices: these are coordinates");
    p.has_no_copy = 0;
    p.is_reversed = 1;
    refuse(((void)(p.copies = FUNCTION), &p), "coordinates of 'm', too, but not the same values");
    refuse(((void)(p.copies = FUNCTION_ALONE), &p), "one place for each node, in their order");
    p = plex_right;
    p.version = 2;
    refuse(((void)(p.is_extruded = 1), &p), "another mesh ('e') with coordinates of its own");
    reading_fails(&io_format_plex, "no HDF5", "not an HDF5 file");
}

static void nothing_breaks_it(void **state) {
    (void)state;
    for (int version = 1; version <= 3; version++) {
        plex p = plex_right;
        p.version = version;
        file_builder b = plex_make(&p);
        builder_try_to_break(&b, &io_format_plex);
        builder_expect_same_on_threads(&b, &io_format_plex);
        builder_release(&b);
    }
}

static void nothing_breaks_copies(void **state) {
    (void)state;
    plex p = plex_right;
    p.version = 3;
    p.copies = FUNCTION | VECTOR | VIEWED;
    file_builder b = plex_make(&p);
    builder_try_to_break(&b, &io_format_plex);
    builder_release(&b);
}

/* ---- writing ------------------------------------------------------------------------------- */

static void check_writing(const char *folder, const plex *p) {
    char in[TEST_PATH_SIZE], out[TEST_PATH_SIZE];
    planish_error error = {.text = ""};
    planish_file *file, *again;
    size_t n_copies = 1;
    for (int bit = FUNCTION; bit <= VIEWED && !p->has_no_copy; bit *= 2)
        n_copies += p->copies & bit ? 1 : 0;
    file_builder b = plex_make(p);
    test_write(folder, "in.h5", b.data, (size_t)b.size);
    assert_int_equal(planish_file_open(test_path(in, folder, "in.h5"), NULL, 1, &file, &error), 0);
    double *xyz = planish_file_coordinates(file);
    xyz[20] = -1.5;
    test_path(out, folder, "out.h5");
    assert_int_equal(
        planish_file_write(file, out, xyz, &(planish_write_options){.threads = 1}, &error), 0);
    assert_int_equal(planish_file_open(out, NULL, 1, &again, &error), 0);
    assert_memory_equal(planish_file_coordinates(again), xyz, sizeof plex_places);
    if (!p->is_packed) {
        size_t size, changed = 0;
        char *content = test_read(out, &size);
        assert_int_equal(size, b.size);
        for (size_t i = 0; i < size; i++)
            changed += content[i] != b.data[i];
        assert_in_range(changed, n_copies, 8 * n_copies);
        assert_int_equal(changed % n_copies, 0);
        free(content);
    }
    planish_file_close(file);
    planish_file_close(again);
    builder_release(&b);
}

static void coordinates_come_back(void **state) {
    for (int version = 1; version <= 3; version++)
        for (int how = 0; how < 16 * HDF5_SUPERBLOCKS; how++) {
            plex p = plex_right;
            hdf5_superblock = hdf5_superblocks[how / 16];
            p.version = version;
            p.chunk = how % 4 > 0 ? 3 : 0;
            p.is_packed = how % 4 > 1;
            p.is_float = how % 4 == 3;
            p.is_one_chunk = how >> 2 & 1;
            p.has_user_block = how >> 3 & 1;
            check_writing(*state, &p);
        }
    hdf5_superblock = 0;
}

/** The value at 8 bytes a number of a dataset. */
static double value_of(const char *path, const char *dataset, int i) {
    double values[3 * N_NODES];
    hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    hid_t data = H5Dopen2(file, dataset, H5P_DEFAULT);
    assert_true(H5Dread(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
    H5Dclose(data);
    H5Fclose(file);
    return values[i];
}

/** All that are the same move together; what is another field stays. */
static void copies_move_together(void **state) {
    static const int cases[] = {FUNCTION,       VECTOR, VIEWED, FUNCTION | VECTOR | VIEWED,
                                FUNCTION_ALONE, LINK};
    for (int version = 2; version <= 3; version++)
        for (int how = 0; how < 4; how++)
            for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
                plex p = plex_right;
                p.version = version;
                p.chunk = how > 0 && cases[i] != LINK ? 4 : 0;
                p.is_packed = how > 1 && cases[i] != LINK;
                p.is_float = how == 3;
                p.copies = cases[i];
                check_writing(*state, &p);
                char path[TEST_PATH_SIZE];
                test_path(path, *state, "out.h5");
                if (p.copies & (FUNCTION | FUNCTION_ALONE))
                    assert_true(value_of(path,
                                         "/topologies/mine/dms/firedrake_dm/vecs/its "
                                         "coordinates/its coordinates",
                                         20) == -1.5);
                if (p.copies & VECTOR)
                    assert_true(value_of(path,
                                         "/topologies/mine/dms/another/vecs/position/position",
                                         20) == -1.5);
                if (p.copies & VIEWED)
                    assert_true(value_of(path, "/viz/geometry/vertices", 20) == -1.5);
            }
    plex p = plex_right;
    p.version = 3;
    p.copies = VECTOR;
    p.has_no_copy = 1;
    check_writing(*state, &p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_forms_are_read),
        cmocka_unit_test(labels_are_surfaces_lines_and_groups),
        cmocka_unit_test(other_elements_are_read),
        cmocka_unit_test_setup_teardown(an_outline_says_what_there_is, test_folder_create,
                                        test_folder_remove),
        cmocka_unit_test(wrong_files_are_refused),
        cmocka_unit_test(nothing_breaks_it),
        cmocka_unit_test(nothing_breaks_copies),
        cmocka_unit_test(other_groups_are_no_meshes),
        cmocka_unit_test_setup_teardown(copies_move_together, test_folder_create,
                                        test_folder_remove),
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
