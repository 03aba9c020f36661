/* Mesh files read and written by callers that round upwards, flush subnormals or trap: the same
 * coordinates, the same bytes. */
#include "support/arithmetic.h"
#include "support/files.h"

#include <planish/planish_io.h>

#include <inttypes.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { NODES = 300, TEXT = 64 * NODES };

/** A triangle, and nodes at numbers that no double is, a few of them subnormal. */
static void write_mesh(const char *folder) {
    char *text = malloc(TEXT);
    size_t n = (size_t)snprintf(text, TEXT, "MeshVersionFormatted 2\nDimension 2\nVertices\n%d\n",
                                (int)NODES);
    for (int i = 0; i < NODES; i++)
        n += (size_t)snprintf(text + n, TEXT - n, "0.%d1e%d 1.%d3 0\n", 7919 * i + 1,
                              i % 10 ? i % 7 - 3 : -310, 104729 * i);
    n += (size_t)snprintf(text + n, TEXT - n, "Triangles\n1\n1 2 3 0\nEnd\n");
    test_write(folder, "in.mesh", text, n);
    free(text);
}

/** Read in.mesh, and write it to out.mesh with coordinates exchanged. */
static uint64_t read_and_write(const char *folder, int threads) {
    char in[TEST_PATH_SIZE], out[TEST_PATH_SIZE], temporary[TEST_PATH_SIZE];
    planish_file *file = NULL;
    int status = planish_file_open(test_path(in, folder, "in.mesh"), NULL, threads, &file, NULL);
    assert_int_equal(status, 0);
    const planish_mesh mesh = planish_file_mesh(file);
    const uint64_t sum = planish_checksum(&mesh);
    double *x = planish_file_coordinates(file);
    double copy[2 * NODES];
    memcpy(copy, x, sizeof copy);
    for (int i = 0; i < NODES; i++) /* others, without arithmetic of the caller's */
        copy[i] = x[2 * NODES - 1 - i];
    status = planish_file_write(file, test_path(out, folder, "out.mesh"), copy,
                                &(planish_write_options){.threads = threads,
                                                         .temporary = temporary,
                                                         .temporary_size = sizeof temporary},
                                NULL);
    assert_int_equal(status, 0);
    memset(copy, 0xff, sizeof *copy); /* not a number: refused, whatever that traps outside */
    assert_int_equal(
        planish_file_write(file, out, copy, &(planish_write_options){.threads = threads}, NULL),
        PLANISH_ERROR_ARGUMENT);
    planish_file_close(file);
    return sum;
}

static char *read_out(const char *folder) {
    char path[TEST_PATH_SIZE];
    return test_read(test_path(path, folder, "out.mesh"), NULL);
}

static void files_do_not_depend_on_the_callers(void **state) {
    const char *folder = *state;
    write_mesh(folder);
    test_arithmetic_reset();
    const uint64_t expected = read_and_write(folder, 1);
    char *bytes = read_out(folder);
    for (const test_arithmetic *a = test_arithmetics; a->name; a++)
        for (int threads = 1; threads <= 2; threads++) {
            a->set();
            const test_arithmetic_state before = test_arithmetic_now();
            const uint64_t sum = read_and_write(folder, threads);
            const test_arithmetic_state after = test_arithmetic_now();
            test_arithmetic_reset();
            char *other = read_out(folder);
            if (sum != expected || strcmp(bytes, other) != 0)
                fail_msg("%s, %d threads: another mesh", a->name, threads);
            assert_memory_equal(&before, &after, sizeof before);
            free(other);
        }
    free(bytes);
}

/** Tolerances of digits, and minimum volumes next to nothing. */
static void groups_do_not_depend_on_the_callers(void **state) {
    const char *folder = *state;
    static const char text[] = "MeshVersionFormatted 2\nDimension 2\nVertices\n3\n0 0 1\n"
                               "1.123456 0 1\n0 1 1\nTriangles\n1\n1 2 3 7\nEnd\n";
    char path[TEST_PATH_SIZE];
    planish_file *file = NULL;
    const char *tag = "7";
    double tiny, expected = 0, volume;
    test_write(folder, "small.mesh", text, sizeof text - 1);
    memset(&tiny, 0, sizeof tiny);
    memset(&tiny, 1, 2); /* subnormal */
    assert_int_equal(planish_file_open(test_path(path, folder, "small.mesh"), NULL, 1, &file, NULL),
                     0);
    test_arithmetic_reset();
    const double tolerance = planish_file_surface(file, NULL).tolerance;
    assert_true(tolerance > 0);
    assert_int_equal(planish_file_min_volumes(file, &tag, &tiny, 1, &expected, NULL), 0);
    for (const test_arithmetic *a = test_arithmetics; a->name; a++) {
        a->set();
        const test_arithmetic_state before = test_arithmetic_now();
        const planish_surface surface = planish_file_surface(file, NULL);
        const int status = planish_file_min_volumes(file, &tag, &tiny, 1, &volume, NULL);
        const test_arithmetic_state after = test_arithmetic_now();
        test_arithmetic_reset();
        if (status || memcmp(&volume, &expected, sizeof volume) != 0 ||
            memcmp(&surface.tolerance, &tolerance, sizeof tolerance) != 0)
            fail_msg("%s: another tolerance or volume", a->name);
        assert_memory_equal(&before, &after, sizeof before);
    }
    planish_file_close(file);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(files_do_not_depend_on_the_callers, test_folder_create,
                                        test_folder_remove),
        cmocka_unit_test_setup_teardown(groups_do_not_depend_on_the_callers, test_folder_create,
                                        test_folder_remove),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
