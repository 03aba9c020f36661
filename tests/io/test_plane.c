/* Planes of triangles: what embedders see of them, and exact turns. */
#include "base/exact.h"
#include "io/file/file.h"
#include "io/file/plane.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { N = 5, NODES = N * N };

static int has_quadrilaterals; /* grids are of them, in the place of triangles */

/** OFF of a grid whose node at (x, y) is x u + y v from origin, and of what else is given. */
static planish_file *read_grid(const double u[3], const double v[3], double origin,
                               const char *more_nodes, int n_more) {
    static char text[1 << 14];
    int used = sprintf(text, "OFF\n%d %d 0\n", NODES + n_more,
                       (2 - has_quadrilaterals) * (N - 1) * (N - 1));
    for (int i = 0; i < NODES; i++) {
        for (int d = 0; d < 3; d++) /* the middle is moved */
            used += sprintf(text + used, "%.17g ",
                            origin + ((i % N) + (i == NODES / 2) * 0.25) * u[d] + i / N * v[d]);
        used += sprintf(text + used, "\n");
    }
    used += sprintf(text + used, "%s", more_nodes);
    for (int y = 0; y + 1 < N; y++)
        for (int x = 0; x + 1 < N; x++) {
            const int a = y * N + x;
            if (has_quadrilaterals)
                used += sprintf(text + used, "4 %d %d %d %d\n", a, a + 1, a + N + 1, a + N);
            else
                used += sprintf(text + used, "3 %d %d %d\n3 %d %d %d\n", a, a + 1, a + N + 1, a,
                                a + N + 1, a + N);
        }
    planish_file *file;
    planish_error error;
    if (io_file_from_memory(&io_format_off, "test", text, used, 2, &file, &error))
        fail_msg("%s", error.text);
    return file;
}

/* Six triangles of second order with corners A B C D P Q, tilted by z = x / 2 + y / 4. */
static const char curved[] =
    "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 17 double\n"
    "0 0 0 4 0 2 4 4 3 0 4 1 1 2 1 3 2 2 2 0 1 2.5 1 1.5 .5 1 .5 3.5 1 2 2 2 1.5 4 2 2.5\n"
    "3.5 3 2.5 2.5 3 2 2 4 2 .5 3 1 0 2 .5\n";
static const char curved_cells[] =
    "CELLS 6 42\n6 0 1 4 6 7 8\n6 1 5 4 9 10 7\n6 1 2 5 11 12 9\n6 2 4 5 13 10 12\n"
    "6 2 3 4 14 15 13\n6 3 0 4 16 8 15\nCELL_TYPES 6\n22 22 22 22 22 22\n";

/** Where a corner goes back, mids of its edges are half the way of the other end from their places. */
static void mids_follow_a_corner_that_goes_back(void **state) {
    (void)state;
    enum { B = 1, P = 4, Q = 5, NODES_HERE = 17, MID_BP = 7, MID_BQ = 9, MID_PQ = 10 };
    char text[1024];
    planish_file *file;
    planish_error error;
    uint8_t back[NODES_HERE] = {0};
    double start[2 * NODES_HERE], way[2] = {0.0625, 0.125};
    int64_t n = 0;
    const int length = snprintf(text, sizeof text, "%s%s", curved, curved_cells);
    if (io_file_from_memory(&io_format_vtk, "test", text, length, 1, &file, &error))
        fail_msg("%s", error.text);
    double *uv = planish_file_coordinates(file);
    const planish_mesh mesh = planish_file_mesh(file);
    assert_true(mesh.dim == 2 && file->model.plane.is_tilted);
    memcpy(start, uv, sizeof start);
    for (int d = 0; d < 2; d++) {
        uv[2 * P + d] += way[d];
        uv[2 * Q + d] += way[d];
        for (int mid = MID_BP; mid < NODES_HERE; mid++) { /* as planish_smooth does */
            const int n_moved = mid == MID_PQ ? 2 : mid != 11 && mid != 14 && mid != 16;
            uv[2 * mid + d] += n_moved * way[d] / 2;
        }
    }
    back[P] = 1;
    assert_int_equal(planish_file_round_in_plane(file, uv, back, &n, &error), PLANISH_OK);
    assert_int_equal(n, 1);
    for (int d = 0; d < 2; d++) {
        const double q = uv[2 * Q + d] - start[2 * Q + d];
        assert_true(q != 0);
        assert_true(uv[2 * P + d] == start[2 * P + d]);
        assert_true(uv[2 * MID_BP + d] == start[2 * MID_BP + d]);
        assert_true(uv[2 * MID_PQ + d] == start[2 * MID_PQ + d] + q / 2);
        assert_true(fabs(uv[2 * MID_BQ + d] - start[2 * MID_BQ + d] - way[d] / 2) < 1e-12);
    }
    planish_file_close(file);
}

/** The same of mids and middles of quadrilaterals: two of nine nodes each, side by side. */
static void middles_follow_corners_that_go_back(void **state) {
    (void)state;
    enum { WIDTH = 5, NODES_HERE = 15 };
    static const char cells[] = "CELLS 2 20\n9 0 2 12 10 1 7 11 5 6\n9 2 4 14 12 3 9 13 7 8\n"
                                "CELL_TYPES 2\n28 28\n";
    /* How far a node has gone when corners 2 and 12 move, and how far it stays when 2 goes back. */
    static const double gone[NODES_HERE] = {0, .5, 1, .5, 0, 0, .5, 1, .5, 0, 0, .5, 1, .5, 0};
    static const double left[NODES_HERE] = {0, 0, 0, 0, 0, 0, .25, .5, .25, 0, 0, .5, 1, .5, 0};
    char text[2048];
    int used = snprintf(text, sizeof text,
                        "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                        "POINTS 15 double\n");
    for (int i = 0; i < NODES_HERE; i++)
        used += snprintf(text + used, sizeof text - (size_t)used, "%d %d %g\n", i % WIDTH,
                         i / WIDTH, i % WIDTH / 2.0 + i / WIDTH / 4.0);
    used += snprintf(text + used, sizeof text - (size_t)used, "%s", cells);
    planish_file *file;
    planish_error error;
    if (io_file_from_memory(&io_format_vtk, "test", text, used, 1, &file, &error))
        fail_msg("%s", error.text);
    double *uv = planish_file_coordinates(file), start[2 * NODES_HERE];
    uint8_t back[NODES_HERE] = {0};
    int64_t n = 0;
    assert_true(planish_file_mesh(file).dim == 2 && file->model.plane.is_tilted);
    memcpy(start, uv, sizeof start);
    for (int i = 0; i < 2 * NODES_HERE; i++)
        uv[i] += gone[i / 2] * 0.125;
    back[2] = 1;
    assert_int_equal(planish_file_round_in_plane(file, uv, back, &n, &error), PLANISH_OK);
    assert_int_equal(n, 1);
    for (int i = 0; i < 2 * NODES_HERE; i++)
        assert_true(fabs(uv[i] - start[i] - left[i / 2] * 0.125) < 1e-12);
    planish_file_close(file);
}

static void turns_are_exact(void **state) {
    (void)state;
    const double a[2] = {0.1, 0.1}, b[2] = {0.7, 0.7}, c[2] = {0.3, 0.3};
    const double up[2] = {0.3, nextafter(0.3, 1)}, down[2] = {0.3, nextafter(0.3, 0)};
    assert_int_equal(pl_exact_turn(a, b, c), 0);
    assert_int_equal(pl_exact_turn(a, b, up), 1);
    assert_int_equal(pl_exact_turn(a, b, down), -1);
    const double tiny[3][2] = {{0, 0}, {5e-324, 0}, {0, 5e-324}},
                 huge[3][2] = {{-1.7e308, 0}, {1.7e308, 0}, {0, 1.7e308}};
    assert_int_equal(pl_exact_turn(tiny[0], tiny[1], tiny[2]), 1);
    assert_int_equal(pl_exact_turn(tiny[0], tiny[2], tiny[1]), -1);
    assert_int_equal(pl_exact_turn(huge[0], huge[1], huge[2]), 1);
    assert_int_equal(pl_exact_turn(tiny[0], tiny[0], tiny[0]), 0);
}

/** Coordinates are of an orthonormal frame, and lead back to the file; those that changed lead to
 *  the plane. */
static void check_frame(const double u[3], const double v[3], double origin, double length) {
    planish_file *file = read_grid(u, v, origin, "", 0);
    planish_plane plane;
    assert_int_equal(planish_file_plane(file, &plane), 1);
    assert_true(plane.is_tilted);
    const planish_mesh mesh = planish_file_mesh(file);
    double xyz[3 * NODES];
    assert_int_equal(mesh.dim, 2);
    assert_int_equal(planish_file_space_coordinates(file, 0, NODES, mesh.coordinates, xyz, NULL),
                     PLANISH_OK);
    assert_memory_equal(xyz, file->model.xyz, sizeof xyz);
    const double *first = mesh.coordinates, *right = first + 2, *up = first + 2 * N;
    assert_true(fabs(hypot(right[0] - first[0], right[1] - first[1]) - length) < 1e-9 * length);
    assert_true(fabs(hypot(up[0] - first[0], up[1] - first[1]) - length) < 1e-9 * length);
    const double moved[2] = {first[0] + 0.25 * length, first[1] - 0.125 * length};
    assert_int_equal(planish_file_space_coordinates(file, 3, 1, moved, xyz, NULL), PLANISH_OK);
    double off = 0;
    for (int d = 0; d < 3; d++) {
        const double wanted =
            plane.origin[d] + moved[0] * plane.direction[0][d] + moved[1] * plane.direction[1][d];
        assert_true(fabs(xyz[d] - wanted) < 1e-9 * length);
        off += (xyz[d] - file->model.xyz[d]) * plane.normal[d];
    }
    assert_true(fabs(off) < 1e-9 * length);
    planish_file_close(file);
}

static void frames_are_orthonormal(void **state) {
    (void)state;
    check_frame((const double[]){15, 12, 16}, (const double[]){-20, 9, 12}, 0, 25);
    check_frame((const double[]){15, 12, 16}, (const double[]){-20, 9, 12}, 1e6, 25);
    check_frame((const double[]){3, 0, -4}, (const double[]){0, 5, 0}, -7, 5);
    check_frame((const double[]){15e-200, 12e-200, 16e-200},
                (const double[]){-20e-200, 9e-200, 12e-200}, 0, 25e-200);
}

static void nodes_of_no_triangle_are_elsewhere(void **state) {
    (void)state;
    planish_file *file =
        read_grid((const double[]){15, 12, 16}, (const double[]){-20, 9, 12}, 0, "1e3 0 0\n", 1);
    double xyz[3];
    const planish_mesh mesh = planish_file_mesh(file);
    assert_int_equal(planish_file_space_coordinates(
                         file, NODES, 1, mesh.coordinates + 2 * (int64_t)NODES, xyz, NULL),
                     0);
    assert_true(xyz[0] == 1e3 && xyz[1] == 0 && xyz[2] == 0);
    planish_file_close(file);
}

static void axes_are_told(void **state) {
    (void)state;
    static const double e[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int axis = 0; axis < 3; axis++) {
        planish_file *file = read_grid(e[(axis + 1) % 3], e[(axis + 2) % 3], 0.5, "", 0);
        planish_plane plane;
        assert_int_equal(planish_file_plane(file, &plane), axis != 2);
        assert_int_equal(plane.is_tilted, 0);
        assert_int_equal(plane.axis[2], axis);
        assert_true(plane.normal[axis] == 1 && plane.direction[0][(axis + 1) % 3] == 1);
        assert_true(plane.origin[axis] == 0.5);
        planish_file_close(file);
    }
}

/** A node that inverts triangles as it is placed goes back, and so does one that is told to. */
static void take_back(void) {
    planish_file *file =
        read_grid((const double[]){15, 12, 16}, (const double[]){-20, 9, 12}, 0, "", 0);
    double *uv = planish_file_coordinates(file), before[2 * NODES];
    uint8_t back[NODES] = {0};
    int64_t n = -1;
    memcpy(before, uv, sizeof before);
    uv[2 * (NODES / 2)] -= 1;
    assert_int_equal(planish_file_round_in_plane(file, uv, NULL, &n, NULL), PLANISH_OK);
    assert_int_equal(n, 0);
    assert_true(uv[2 * (NODES / 2)] != before[2 * (NODES / 2)]);
    back[NODES / 2] = 1;
    assert_int_equal(planish_file_round_in_plane(file, uv, back, &n, NULL), PLANISH_OK);
    assert_int_equal(n, 1);
    assert_memory_equal(uv, before, sizeof before);
    /* Triangles so thin that many have another sign in floats. */
    file->model.precision = PLANISH_PRECISION_FLOAT;
    const double *a = uv + 2 * (NODES / 2 - N - 1), *b = uv + 2 * (NODES / 2 - N);
    double *moved = uv + 2 * (NODES / 2), place[3];
    int64_t n_back = 0;
    const int sign = pl_exact_turn(a, b, moved);
    const int32_t p = file->model.plane.axis[0], q = file->model.plane.axis[1];
    for (int i = 1; i < 20; i++) {
        const double t = i / 20.0;
        moved[0] = (1 - t) * a[0] + t * b[0] - sign * 1e-12 * (b[1] - a[1]);
        moved[1] = (1 - t) * a[1] + t * b[1] + sign * 1e-12 * (b[0] - a[0]);
        assert_int_equal(pl_exact_turn(a, b, moved), sign);
        assert_int_equal(planish_file_round_in_plane(file, uv, NULL, &n, NULL), PLANISH_OK);
        n_back += n;
        planish_file_space_coordinates(file, NODES / 2, 1, moved, place, NULL);
        const double *of_a = file->model.xyz + 3 * (NODES / 2 - N - 1), *of_b = of_a + 3;
        assert_int_equal(pl_exact_turn((double[]){of_a[p], of_a[q]}, (double[]){of_b[p], of_b[q]},
                                       (double[]){place[p], place[q]}),
                         sign);
        if (n > 0)
            assert_memory_equal(uv, before, sizeof before);
    }
    assert_true(n_back > 0);
    planish_file_close(file);
}

static void rounding_takes_nodes_back(void **state) {
    (void)state;
    for (has_quadrilaterals = 1; has_quadrilaterals >= 0; has_quadrilaterals--)
        take_back();
    has_quadrilaterals = 0;
}

static void wrong_arguments(void **state) {
    (void)state;
    planish_file *file =
        read_grid((const double[]){15, 12, 16}, (const double[]){-20, 9, 12}, 0, "", 0);
    planish_error error;
    double xyz[3], uv[2] = {0, 0};
    assert_int_equal(planish_file_space_coordinates(file, NODES, 1, uv, xyz, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_space_coordinates(file, -1, 1, uv, xyz, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_space_coordinates(file, 0, INT64_MAX, uv, xyz, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_space_coordinates(NULL, 0, 1, uv, xyz, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_round_in_plane(file, NULL, NULL, NULL, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_plane(NULL, NULL), 0);
    planish_file_close(file);
    const planish_open_options options = {.plane_tolerance = 2e-3};
    assert_int_equal(planish_file_open_with("nowhere", &options, &file, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_open_with("nowhere", NULL, &file, &error), PLANISH_ERROR_FILE);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mids_follow_a_corner_that_goes_back),
        cmocka_unit_test(middles_follow_corners_that_go_back),
        cmocka_unit_test(turns_are_exact),
        cmocka_unit_test(frames_are_orthonormal),
        cmocka_unit_test(nodes_of_no_triangle_are_elsewhere),
        cmocka_unit_test(axes_are_told),
        cmocka_unit_test(rounding_takes_nodes_back),
        cmocka_unit_test(wrong_arguments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
