/* OpenFOAM's meshes of two dimensions: a layer of cells between empty patches. */
#include "support/files.h"
#include "support/foam_builder.h"
#include "support/unit_elements.h"

#include "io/file/file.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const foam_form ascii = {.label_size = 4, .scalar_size = 8};
static const char *const patches[] = {"sides empty", "end patch", "other wall", NULL};
static int axis; /* across the layer */

static int by_axis(const double *middle) {
    return fabs(middle[axis] - round(middle[axis])) < 1e-6 ? 0
           : middle[(axis + 1) % 3] == 0                   ? 1
                                                           : 2;
}

static planish_file *open_at(const char *folder) {
    planish_file *file = NULL;
    planish_error error;
    if (planish_file_open(folder, NULL, 1, &file, &error))
        fail_msg("%s", error.text);
    return file;
}

/** 4 * 4 bricks in a layer across the axis, two of them wedges; its inner points, if it is across z, move by
 *  pairs. */
static foam_cells *make_layer(void) {
    foam_cells *cells = malloc(sizeof *cells);
    assert_non_null(cells);
    foam_make_bricks(cells, 4, 4, 1);
    foam_split_brick(cells, 5);
    for (int i = 0; i < cells->n_points; i++) {
        double x[3];
        memcpy(x, cells->x[i], sizeof x);
        if (i % 25 == 12) { /* the middle, and a point beside */
            x[0] += 0.3;
            x[1] -= 0.1;
        }
        for (int d = 0; d < 3; d++) /* z goes across */
            cells->x[i][(axis + 1 + d) % 3] = x[d];
    }
    return cells;
}

static void a_layer_is_a_mesh_of_two_dimensions(void **state) {
    for (axis = 0; axis < 3; axis++) {
        foam_cells *cells = make_layer();
        foam_build(*state, cells, &ascii, patches, by_axis);
        planish_file *file = open_at(*state);
        const planish_mesh mesh = planish_file_mesh(file);
        planish_plane plane;
        assert_int_equal(mesh.dim, 2);
        assert_int_equal(mesh.n_nodes, 25);
        assert_int_equal(mesh.n_elements, 17);
        assert_int_equal(planish_file_plane(file, &plane), axis != 2);
        assert_int_equal(plane.axis[2], axis);
        assert_int_equal(planish_file_node_number(file, 24), 24);
        unit_expect_valid(file, 17);
        unit_expect_held(file, NULL, "1111110001100011000111111");
        assert_int_equal(file->model.line.n, 16);
        planish_file_close(file);
        free(cells);
    }
}

/** Both places of a node that moves are written, and the coordinate across stays theirs. */
static void both_sides_are_written(void **state) {
    for (int k = 0; k < 6; k++) {
        char in[TEST_PATH_SIZE], out[TEST_PATH_SIZE], path[TEST_PATH_SIZE];
        planish_error error;
        const foam_form form = {.binary = k > 2, .label_size = 4, .scalar_size = 8};
        axis = k % 3;
        foam_cells *cells = make_layer();
        test_folder_in(in, *state, "in");
        foam_build(in, cells, &form, patches, by_axis);
        planish_file *file = open_at(in);
        double *x = planish_file_coordinates(file);
        x[2 * 12] = 2.125;
        x[2 * 12 + 1] = 1.875;
        if (planish_file_write(file, test_path(out, *state, "out"), x,
                               &(planish_write_options){.threads = 1}, &error))
            fail_msg("%s", error.text);
        planish_file_close(file);
        cells->x[12][(axis + 1) % 3] = cells->x[37][(axis + 1) % 3] = 2.125;
        cells->x[12][(axis + 2) % 3] = cells->x[37][(axis + 2) % 3] = 1.875;
        foam_build(in, cells, &form, patches, by_axis);
        size_t size, wanted_size;
        char *found = test_read(test_path(path, out, "points"), &size);
        char *wanted = test_read(test_path(path, in, "points"), &wanted_size);
        assert_int_equal(size, wanted_size);
        assert_memory_equal(found, wanted, size);
        free(found);
        free(wanted);
        free(cells);
        void *made[] = {strdup(in), strdup(out)};
        for (int i = 0; i < 2; i++)
            assert_int_equal(test_folder_remove(&made[i]), 0);
    }
}

/** A pair whose places differ by roundings is held. */
static void roundings_hold_a_node(void **state) {
    axis = 2;
    foam_cells *cells = make_layer();
    cells->x[25 + 7][0] += 1e-9;
    foam_build(*state, cells, &ascii, patches, by_axis);
    planish_file *file = open_at(*state);
    assert_int_equal(planish_file_mesh(file).dim, 2);
    assert_int_equal(planish_file_mesh(file).n_nodes, 26);
    unit_expect_held(file, NULL, "11111101011000110001111111");
    planish_file_close(file);
    free(cells);
}

/** What is no such layer stays a mesh of three dimensions, with all nodes of empty patches held. */
static void other_meshes_stay_solid(void **state) {
    for (int k = 0; k < 4; k++) {
        axis = 2;
        foam_cells *cells = make_layer();
        const char *const others[] = {k == 0 ? "sides wall" : "sides empty", "end patch",
                                      "other wall", NULL};
        if (k == 1)
            cells->x[25 + 7][0] += 0.01; /* not across */
        if (k == 2)
            cells->x[25 + 7][2] += 1e-9; /* not in the plane */
        if (k == 3)
            foam_make_bricks(cells, 4, 4, 2); /* two layers, the sides of which are not all empty */
        foam_build(*state, cells, &ascii, others, by_axis);
        planish_file *file = open_at(*state);
        assert_int_equal(planish_file_mesh(file).dim, 3);
        for (int i = 0; i < cells->n_points; i++)
            assert_int_equal((file->model.hold[i] & IO_HELD_REQUIRED) != 0,
                             k > 0 && (k < 3 || i < 25 || i >= 50));
        planish_file_close(file);
        free(cells);
    }
}

int main(void) {
#define TEST(name) cmocka_unit_test_setup_teardown(name, test_folder_create, test_folder_remove)
    const struct CMUnitTest tests[] = {
        TEST(a_layer_is_a_mesh_of_two_dimensions),
        TEST(both_sides_are_written),
        TEST(roundings_hold_a_node),
        TEST(other_meshes_stay_solid),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
