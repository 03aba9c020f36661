/* Sizes of the command line's options: arrays of a file, files of solutions, the input's own. */
#include "job/sizes.h"
#include "support/files.h"
#include "support/reading.h"
#include "terminal/message.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { N_NODES = 5 };

/* A square of 2 by 2 in two triangles, and a node of no element. */
#define FLAT                                                                                       \
    "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n"       \
    "0 0 0 2 0 0 2 2 0 0 2 0 9 9 0\nCELLS 2 8\n3 0 1 2\n3 0 2 3\nCELL_TYPES 2\n5 5\n"
#define HEAD  "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET UNSTRUCTURED_GRID\n"
#define NODES "POINT_DATA 5\n"
#define CELLS "CELL_DATA 2\n"

/** Read the sizes of text as arguments ask; returns what pl_sizes_read returns. */
static int read_sizes(const char *text, pl_arguments *arguments, pl_sizes *sizes) {
    planish_file *file = reading_text(&io_format_vtk, text);
    const planish_mesh mesh = planish_file_mesh(file);
    arguments->input = "mesh.vtk";
    const int status = pl_sizes_read(arguments, file, 1, &mesh, sizes);
    planish_file_close(file);
    return status;
}

static int read_array(const char *text, pl_sizes *sizes) {
    pl_arguments arguments = {.typed = PL_COMMAND_SMOOTH, .size = "h", .library.size_weight = 0.5};
    return read_sizes(text, &arguments, sizes);
}

static void expect_near(double a, double b) {
    assert_true(fabs(a - b) <= 1e-12 * fabs(b));
}

static void expect_refused(const char *text) {
    pl_sizes sizes;
    assert_int_equal(read_array(text, &sizes), PL_EXIT_FAILED);
    pl_sizes_free(&sizes);
}

static void sizes_of_nodes(void **state) {
    pl_sizes sizes;
    (void)state;
    /* The size of the node of no element does not matter. */
    assert_int_equal(read_array(FLAT NODES "SCALARS h double\n1 4 4 16 -1\n", &sizes), 0);
    assert_true(sizes.size[0] == 1 && sizes.size[1] == 4 && sizes.size[3] == 16);
    expect_near(sizes.size[4], 4);
    pl_sizes_free(&sizes);
}

static void sizes_of_elements(void **state) {
    pl_sizes sizes;
    (void)state;
    assert_int_equal(read_array(FLAT CELLS "SCALARS h double\n1 4\n", &sizes), 0);
    const double expected[N_NODES] = {2, 1, 2, 4, 2};
    for (int i = 0; i < N_NODES; i++)
        expect_near(sizes.size[i], expected[i]);
    pl_sizes_free(&sizes);
}

static void sizes_that_are_none(void **state) {
    (void)state;
    expect_refused(FLAT NODES "SCALARS h double\n1 0 4 16 1\n");
    expect_refused(FLAT NODES "SCALARS h double\n1 -2 4 16 1\n");
    expect_refused(FLAT NODES "SCALARS h double\n1 nan 4 16 1\n");
    expect_refused(FLAT NODES "SCALARS h double\n1 2e12 4 16 1\n");
    expect_refused(FLAT CELLS "SCALARS h double\n1 0\n");
    pl_sizes none;
    assert_int_equal(read_array(FLAT CELLS "SCALARS g double\n1 1\n", &none), PL_EXIT_USAGE);
    pl_sizes_free(&none);
    expect_refused(FLAT NODES "FIELD f 1\nh 2 5 double\n1 1 1 1 1 1 1 1 1 1\n");
    expect_refused(FLAT NODES "VECTORS h double\n1 1 1 1 1 1 1 1 1 1 1 1 1 1 1\n");
}

#define ONE "1 0 0 0 1 0 0 0 1\n"

static void metrics_of_nodes(void **state) {
    pl_sizes sizes;
    (void)state;
    assert_int_equal(read_array(FLAT NODES "TENSORS h double\n4 1 0 1 9 0 0 0 1\n" ONE ONE
                                           "2 0 0 0 2 0 0 0 1\n0 0 0 0 0 0 0 0 0\n",
                                &sizes),
                     0);
    assert_null(sizes.size);
    static const double expected[] = {4, 1, 9, 1, 0, 1, 1, 0, 1, 2, 0, 2, 2, 0.25, 3.25};
    for (int i = 0; i < 15; i++)
        assert_true(sizes.metric[i] == expected[i]);
    pl_sizes_free(&sizes);
    assert_null(sizes.metric);
}

static void metrics_of_elements(void **state) {
    pl_sizes sizes;
    (void)state;
    /* VTK has the diagonal first: xx, yy, zz, xy, yz, xz. */
    assert_int_equal(
        read_array(FLAT CELLS "FIELD f 1\nh 6 2 double\n4 9 1 1 0 0\n2 3 1 0 0 0\n", &sizes), 0);
    static const double expected[] = {3, 0.5, 6, 4, 1, 9, 3, 0.5, 6, 2, 0, 3, 3, 0.5, 6};
    for (int i = 0; i < 15; i++)
        expect_near(sizes.metric[i], expected[i]);
    pl_sizes_free(&sizes);
}

static void metrics_that_are_none(void **state) {
    (void)state;
    expect_refused(FLAT NODES "TENSORS h double\n4 1 0 0.9 9 0 0 0 1\n" ONE ONE ONE ONE);
    expect_refused(FLAT NODES "TENSORS h double\n0 0 0 0 9 0 0 0 1\n" ONE ONE ONE ONE);
    expect_refused(FLAT NODES "TENSORS h double\n1 2 0 2 1 0 0 0 1\n" ONE ONE ONE ONE);
    expect_refused(FLAT NODES "TENSORS h double\n-1 0 0 0 -1 0 0 0 1\n" ONE ONE ONE ONE);
    expect_refused(FLAT CELLS "TENSORS h double\n-1 0 0 0 1 0 0 0 1\n" ONE);
}

static void a_weight_of_nothing(void **state) {
    (void)state;
    for (int is_metric = 0; is_metric < 2; is_metric++) {
        pl_arguments arguments = {.size = is_metric ? "m" : "h", .library.size_weight = 0};
        pl_sizes sizes;
        const int status = read_sizes(
            FLAT NODES "SCALARS h double\n1 1 1 1 1\nTENSORS m double\n" ONE ONE ONE ONE ONE,
            &arguments, &sizes);
        assert_int_equal(status, is_metric ? 0 : PL_EXIT_FAILED);
        pl_sizes_free(&sizes);
    }
}

static void solutions_of_another_file(void **state) {
    static const char sizes_text[] = "MeshVersionFormatted 2\nDimension 2\nSolAtVertices\n5\n1 1\n"
                                     "4 1 9 2 3\nEnd\n";
    static const char metrics[] = "MeshVersionFormatted 2\nDimension 2\nSolAtVertices\n5\n1 3\n"
                                  "4 1 9\n4 1 9\n4 1 9\n4 1 9\n4 1 9\nEnd\n";
    char path[TEST_PATH_SIZE];
    pl_sizes sizes;
    test_write(*state, "a.sol", sizes_text, strlen(sizes_text));
    test_write(*state, "m.sol", metrics, strlen(metrics));
    pl_arguments arguments = {.size_from = test_path(path, *state, "a.sol"),
                              .library.size_weight = 0.5};
    assert_int_equal(read_sizes(FLAT, &arguments, &sizes), 0);
    assert_true(sizes.size[0] == 4 && sizes.size[1] == 1 && sizes.size[2] == 9 &&
                sizes.size[3] == 2);
    pl_sizes_free(&sizes);
    arguments.size_from = test_path(path, *state, "m.sol");
    assert_int_equal(read_sizes(FLAT, &arguments, &sizes), 0);
    assert_true(sizes.metric[0] == 4 && sizes.metric[1] == 1 && sizes.metric[2] == 9);
    pl_sizes_free(&sizes);
    arguments.size_from = test_path(path, *state, "none.sol");
    assert_int_equal(read_sizes(FLAT, &arguments, &sizes), PL_EXIT_FAILED);
    pl_sizes_free(&sizes);
}

/** Elements with edges of 2, each of its own type: all nodes have the size 2. */
static void sizes_that_are_kept(void **state) {
    static const char *const texts[] = {
        HEAD "POINTS 4 double\n0 0 0 2 0 0 2 2 0 0 2 0\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n9\n",
        HEAD "POINTS 3 double\n0 0 0 2 0 0 1 1.7320508075688772 0\nCELLS 1 4\n3 0 1 2\n"
             "CELL_TYPES 1\n5\n",
        HEAD "POINTS 4 double\n0 0 0 2 0 0 1 1.7320508075688772 0 1 0.57735026918962573 "
             "1.6329931618554521\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n",
        HEAD "POINTS 5 double\n0 0 0 2 0 0 2 2 0 0 2 0 1 1 1.4142135623730951\nCELLS 1 6\n"
             "5 0 1 2 3 4\nCELL_TYPES 1\n14\n",
        HEAD "POINTS 6 double\n0 0 0 1 1.7320508075688772 0 2 0 0 0 0 2 1 1.7320508075688772 2 "
             "2 0 2\nCELLS 1 7\n6 0 1 2 3 4 5\nCELL_TYPES 1\n13\n",
        HEAD "POINTS 8 double\n0 0 0 2 0 0 2 2 0 0 2 0 0 0 2 2 0 2 2 2 2 0 2 2\nCELLS 1 9\n"
             "8 0 1 2 3 4 5 6 7\nCELL_TYPES 1\n12\n"};
    (void)state;
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        pl_arguments arguments = {.keep_sizes = 1};
        pl_sizes sizes;
        assert_int_equal(read_sizes(texts[i], &arguments, &sizes), 0);
        for (int k = 0; k < 3; k++)
            expect_near(sizes.size[k], 2);
        pl_sizes_free(&sizes);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sizes_of_nodes),
        cmocka_unit_test(sizes_of_elements),
        cmocka_unit_test(sizes_that_are_none),
        cmocka_unit_test(metrics_of_nodes),
        cmocka_unit_test(metrics_of_elements),
        cmocka_unit_test(metrics_that_are_none),
        cmocka_unit_test(a_weight_of_nothing),
        cmocka_unit_test_setup_teardown(solutions_of_another_file, test_folder_create,
                                        test_folder_remove),
        cmocka_unit_test(sizes_that_are_kept),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
