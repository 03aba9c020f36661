/* Files that were opened before a fork: calls on them in the child, which has no threads, return. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "planish/planish_io.h"
#include "support/files.h"

enum { N = 300 }; /* nodes of a side: enough for threads */

/** Write a square of triangles in a tilted plane, and a number of each node. */
static void write_square(const char *path) {
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    fprintf(out, "# vtk DataFile Version 3.0\nsquare\nASCII\nDATASET UNSTRUCTURED_GRID\n");
    fprintf(out, "POINTS %d double\n", N * N);
    for (int i = 0; i < N * N; i++)
        fprintf(out, "%d %d %g\n", i % N, i / N, 0.5 * (i % N));
    const int n = 2 * (N - 1) * (N - 1);
    fprintf(out, "CELLS %d %d\n", n, 4 * n);
    for (int y = 0; y < N - 1; y++)
        for (int i = y * N; i < y * N + N - 1; i++)
            fprintf(out, "3 %d %d %d\n3 %d %d %d\n", i, i + 1, i + N + 1, i, i + N + 1, i + N);
    fprintf(out, "CELL_TYPES %d\n", n);
    for (int i = 0; i < n; i++)
        fprintf(out, "5\n");
    fprintf(out, "POINT_DATA %d\nSCALARS height double\nLOOKUP_TABLE default\n", N * N);
    for (int i = 0; i < N * N; i++)
        fprintf(out, "%d\n", i % 7);
    assert_int_equal(fclose(out), 0);
}

/** Call what works with threads: 0, or the call that failed. */
static int call_all(planish_file *file, const char *folder) {
    char written[TEST_PATH_SIZE], converted[TEST_PATH_SIZE];
    double *xy = planish_file_coordinates(file);
    uint8_t *constraint = malloc(N * N);
    int64_t n;
    planish_data data;
    planish_error error;
    if (!constraint || planish_file_constraints(file, NULL, constraint, &error))
        return 1;
    free(constraint);
    if (planish_file_data(file, "height", &data, &error))
        return 2;
    planish_data_free(&data);
    xy[2 * (N + 1)] += 0.125; /* a node inside */
    if (planish_file_round_in_plane(file, xy, NULL, &n, &error))
        return 3;
    if (planish_file_write(file, test_path(written, folder, "written.vtk"), xy, NULL, &error))
        return 4;
    if (planish_file_convert(file, test_path(converted, folder, "converted.msh"), xy, NULL, &error))
        return 5;
    return 0;
}

static void children_use_one_thread(void **state) {
    char path[TEST_PATH_SIZE];
    planish_file *file;
    planish_error error;
    int status;
    write_square(test_path(path, *state, "in.vtk"));
    assert_int_equal(planish_file_open(path, NULL, 3, &file, &error), PLANISH_OK);
    fflush(NULL);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        alarm(60);
        _exit(call_all(file, *state));
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0); /* SIGALRM: it waited for threads */
    assert_int_equal(call_all(file, *state), 0);
    planish_file_close(file);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(children_use_one_thread, test_folder_create,
                                        test_folder_remove),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
