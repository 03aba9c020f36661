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
static int read_sizes(const char *text, pl_arguments *arguments, double **size) {
    planish_file *file = reading_text(&io_format_vtk, text);
    const planish_mesh mesh = planish_file_mesh(file);
    arguments->input = "mesh.vtk";
    const int status = pl_sizes_read(arguments, file, 1, &mesh, size);
    planish_file_close(file);
    return status;
}

static int read_array(const char *text, double **size) {
    pl_arguments arguments = {.size = "h"};
    return read_sizes(text, &arguments, size);
}

static void expect_near(double a, double b) {
    assert_true(fabs(a - b) <= 1e-12 * fabs(b));
}

static void expect_refused(const char *text) {
    double *size;
    assert_int_equal(read_array(text, &size), PL_EXIT_FAILED);
    free(size);
}

static void sizes_of_nodes(void **state) {
    double *size;
    (void)state;
    /* The size of the node of no element does not matter. */
    assert_int_equal(read_array(FLAT NODES "SCALARS h double\n1 4 4 16 -1\n", &size), 0);
    assert_true(size[0] == 1 && size[1] == 4 && size[3] == 16);
    expect_near(size[4], 4);
    free(size);
}

static void sizes_of_elements(void **state) {
    double *size;
    (void)state;
    assert_int_equal(read_array(FLAT CELLS "SCALARS h double\n1 4\n", &size), 0);
    const double expected[N_NODES] = {2, 1, 2, 4, 2};
    for (int i = 0; i < N_NODES; i++)
        expect_near(size[i], expected[i]);
    free(size);
}

static void sizes_that_are_none(void **state) {
    (void)state;
    expect_refused(FLAT NODES "SCALARS h double\n1 0 4 16 1\n");
    expect_refused(FLAT NODES "SCALARS h double\n1 -2 4 16 1\n");
    expect_refused(FLAT NODES "SCALARS h double\n1 nan 4 16 1\n");
    expect_refused(FLAT NODES "SCALARS h double\n1 2e12 4 16 1\n");
    expect_refused(FLAT CELLS "SCALARS h double\n1 0\n");
    expect_refused(FLAT CELLS "SCALARS g double\n1 1\n");
    expect_refused(FLAT NODES "FIELD f 1\nh 2 5 double\n1 1 1 1 1 1 1 1 1 1\n");
}

static void solutions_of_another_file(void **state) {
    static const char sizes_text[] = "MeshVersionFormatted 2\nDimension 2\nSolAtVertices\n5\n1 1\n"
                                     "4 1 9 2 3\nEnd\n";
    static const char metrics[] = "MeshVersionFormatted 2\nDimension 2\nSolAtVertices\n5\n1 3\n"
                                  "4 1 9\n4 1 9\n4 1 9\n4 1 9\n4 1 9\nEnd\n";
    char path[TEST_PATH_SIZE];
    double *size;
    test_write(*state, "a.sol", sizes_text, strlen(sizes_text));
    test_write(*state, "m.sol", metrics, strlen(metrics));
    pl_arguments arguments = {.size_from = test_path(path, *state, "a.sol")};
    assert_int_equal(read_sizes(FLAT, &arguments, &size), 0);
    assert_true(size[0] == 4 && size[1] == 1 && size[2] == 9 && size[3] == 2);
    free(size);
    for (int wrong = 0; wrong < 2; wrong++) {
        arguments.size_from = test_path(path, *state, wrong ? "m.sol" : "none.sol");
        assert_int_equal(read_sizes(FLAT, &arguments, &size), PL_EXIT_FAILED);
        free(size);
    }
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
        double *size;
        assert_int_equal(read_sizes(texts[i], &arguments, &size), 0);
        for (int k = 0; k < 3; k++)
            expect_near(size[k], 2);
        free(size);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sizes_of_nodes),
        cmocka_unit_test(sizes_of_elements),
        cmocka_unit_test(sizes_that_are_none),
        cmocka_unit_test_setup_teardown(solutions_of_another_file, test_folder_create,
                                        test_folder_remove),
        cmocka_unit_test(sizes_that_are_kept),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
