/* Solutions at vertices beside Medit's meshes: .sol and .solb of all versions. */
#include "support/file_builder.h"
#include "support/files.h"

#include <planish/planish_io.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

enum { N = 4, CODE_DIMENSION = 3, CODE_SOLUTION = 62, CODE_END = 54 };

/** Component k of vertex i in solution s. */
static double value_of(int i, int s, int k) {
    return 0.5 + i + 100 * s + 10 * k;
}

static int reals_of(int type, int dim) {
    return type == 1 ? 1 : type == 2 ? dim : type == 3 ? dim * (dim + 1) / 2 : dim * dim;
}

static void put_values(file_builder *builder, int dim, int n_types, const int *types, int size) {
    for (int i = 0; i < N; i++) {
        for (int s = 0; s < n_types; s++)
            for (int k = 0; k < reals_of(types[s], dim); k++)
                builder_real(builder, value_of(i, s, k), size);
        builder_line(builder);
    }
}

static file_builder make_text(int version, int dim, int n_types, const int *types) {
    file_builder builder = {0};
    builder_text(&builder, "# a comment\nMeshVersionFormatted %d\n\nDimension\n%d\n", version, dim);
    builder_text(&builder, "SolAtVertices # of sizes\n%d\n%d ", N, n_types);
    for (int s = 0; s < n_types; s++)
        builder_text(&builder, " %d", types[s]);
    builder_text(&builder, "\n# values\n");
    put_values(&builder, dim, n_types, types, 8);
    builder_text(&builder, "End\n");
    return builder;
}

static file_builder make_binary(int version, int swapped, int dim, int n_types, const int *types) {
    file_builder builder = {.binary = 1, .swapped = swapped};
    const int position = version < 3 ? 4 : 8, count = version < 4 ? 4 : 8;
    const int size = version == 1 ? 4 : 8;
    int n_reals = 0;
    for (int s = 0; s < n_types; s++)
        n_reals += reals_of(types[s], dim);
    builder_integer(&builder, 1, 4);
    builder_integer(&builder, version, 4);
    builder_integer(&builder, CODE_DIMENSION, 4);
    builder_integer(&builder, builder.size + position + 4, position);
    builder_integer(&builder, dim, 4);
    builder_integer(&builder, CODE_SOLUTION, 4);
    builder_integer(
        &builder, builder.size + position + count + 4 + 4 * n_types + N * n_reals * size, position);
    builder_integer(&builder, N, count);
    builder_integer(&builder, n_types, 4);
    for (int s = 0; s < n_types; s++)
        builder_integer(&builder, types[s], 4);
    put_values(&builder, dim, n_types, types, size);
    builder_integer(&builder, CODE_END, 4);
    builder_integer(&builder, 0, position);
    return builder;
}

static int read_bytes(const char *folder, const char *data, int64_t size, int dim, int64_t n,
                      planish_data *out, planish_error *error) {
    char path[TEST_PATH_SIZE];
    test_write(folder, "a.sol", data, (size_t)size);
    return planish_sol_read(test_path(path, folder, "a.sol"), dim, n, out, error);
}

/** Expect the solution number `taken` of a file, which is released; and no crash on its beginnings. */
static void expect_solution(const char *folder, file_builder builder, int dim, int mesh_dim,
                            int taken, int type) {
    planish_data data;
    planish_error error = {.text = ""};
    const int width = reals_of(type, dim);
    if (read_bytes(folder, builder.data, builder.size, mesh_dim, N, &data, &error))
        fail_msg("%s", error.text);
    assert_int_equal(data.n, N);
    assert_int_equal(data.of_elements, 0);
    assert_int_equal(data.n_components, width);
    for (int i = 0; i < N; i++)
        for (int k = 0; k < width; k++)
            assert_true(data.values[i * width + k] == value_of(i, taken, k));
    planish_data_free(&data);
    for (int64_t size = 1; size < builder.size; size += 7) {
        const int status = read_bytes(folder, builder.data, size, mesh_dim, N, &data, &error);
        assert_true(status == 0 || (error.code == status && error.text[0] && !data.values));
        planish_data_free(&data);
    }
    builder_release(&builder);
}

/** Solutions of a file, and which of them is taken. */
typedef struct solutions {
    int dim, n, types[4], taken;
} solutions;

static const solutions files[] = {
    {3, 1, {1}, 0},          {2, 1, {1}, 0},       {3, 1, {3}, 0},          {2, 1, {3}, 0},
    {3, 4, {2, 4, 3, 1}, 2}, {2, 3, {2, 1, 3}, 1}, {3, 4, {4, 2, 1, 1}, 2},
};
enum { N_FILES = sizeof files / sizeof *files };

static void texts_are_read(void **state) {
    for (int i = 0; i < N_FILES; i++) {
        const solutions *f = &files[i];
        for (int version = 1; version <= 3; version++)
            expect_solution(*state, make_text(version, f->dim, f->n, f->types), f->dim, f->dim,
                            f->taken, f->types[f->taken]);
    }
}

static void binary_files_are_read(void **state) {
    for (int i = 0; i < N_FILES; i++) {
        const solutions *f = &files[i];
        for (int how = 0; how < 8; how++)
            expect_solution(*state, make_binary(1 + how / 2, how % 2, f->dim, f->n, f->types),
                            f->dim, f->dim, f->taken, f->types[f->taken]);
    }
}

static void space_beside_a_flat_mesh(void **state) {
    expect_solution(*state, make_text(2, 3, 1, (const int[]){3}), 3, 2, 0, 3);
}

static void expect_wrong(const char *folder, const char *text, int dim, const char *part) {
    planish_data data;
    planish_error error = {.text = ""};
    assert_int_equal(read_bytes(folder, text, (int64_t)strlen(text), dim, N, &data, &error),
                     PLANISH_ERROR_FORMAT);
    if (!strstr(error.text, part))
        fail_msg("'%s' is not in: %s", part, error.text);
    assert_null(strchr(error.text, '\n'));
    assert_null(data.values);
}

#define BEGIN "MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n"

static void wrong_files(void **state) {
    const char *folder = *state;
    expect_wrong(folder, BEGIN "4\n1 1\n1 2 3 nan\nEnd\n", 3,
                 "a.sol:6: SolAtVertices: the value "
                 "of vertex 4 is not finite");
    expect_wrong(folder, BEGIN "4\n1 1\n1 2 3\nEnd\n", 3, "a number expected for vertex 4");
    expect_wrong(folder, BEGIN "4\n1 1\n1 2 3 4 5\nEnd\n", 3, "more than 4 solutions follow");
    expect_wrong(folder, BEGIN "3\n1 1\n1 2 3\nEnd\n", 3,
                 "there are solutions of 3 vertices, and the mesh has 4 nodes");
    expect_wrong(folder, BEGIN "2147483647\n1 1\n1 2 3\nEnd\n", 3, "cannot be in the");
    expect_wrong(folder, BEGIN "-1\n1 1\n1 2 3\nEnd\n", 3, "cannot be in the");
    expect_wrong(folder, BEGIN "4\n1 2\n1 2 3\n1 2 3\n1 2 3\n1 2 3\nEnd\n", 3,
                 "none of the solutions is a scalar (type 1) or a symmetric tensor (type 3)");
    expect_wrong(folder, BEGIN "4\n1 7\n1 2 3 4\nEnd\n", 3,
                 "solution 1: number 7 is not in 1 .. 4");
    expect_wrong(folder, BEGIN "4\n0\n1 2 3 4\nEnd\n", 3, "solution 0: number 0 is not in");
    expect_wrong(folder, BEGIN "4\n1000000 1\n1 2 3 4\nEnd\n", 3, "number 1000000 is not in");
    expect_wrong(folder, "MeshVersionFormatted 2\nDimension 2\nSolAtVertices\n4\n1 1\n1 2 3 4\n", 3,
                 "Dimension is 2, and the mesh is in 3 dimensions");
    expect_wrong(folder, "MeshVersionFormatted 2\nDimension 3\nEnd\n", 3,
                 "there is no SolAtVertices");
    expect_wrong(folder, "SolAtVertices\n4\n1 1\n1 2 3 4\n", 3, "SolAtVertices before Dimension");
    expect_wrong(folder, "nothing of the kind\n", 3, "no MeshVersionFormatted");
}

static void arguments_are_checked(void **state) {
    double other = 0;
    planish_data data = {.n = 1, .values = &other};
    char path[TEST_PATH_SIZE];
    test_path(path, *state, "none.sol");
    assert_int_equal(planish_sol_read(path, 7, N, &data, NULL), PLANISH_ERROR_ARGUMENT);
    assert_null(data.values);
    assert_int_equal(planish_sol_read(path, 3, N, &data, NULL), PLANISH_ERROR_FILE);
    assert_int_equal(planish_sol_read(NULL, 3, N, &data, NULL), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_sol_read(path, 4, N, &data, NULL), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_sol_read(path, 3, -1, &data, NULL), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_sol_read(path, 3, N, NULL, NULL), PLANISH_ERROR_ARGUMENT);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(texts_are_read, test_folder_create, test_folder_remove),
        cmocka_unit_test_setup_teardown(binary_files_are_read, test_folder_create,
                                        test_folder_remove),
        cmocka_unit_test_setup_teardown(space_beside_a_flat_mesh, test_folder_create,
                                        test_folder_remove),
        cmocka_unit_test_setup_teardown(wrong_files, test_folder_create, test_folder_remove),
        cmocka_unit_test_setup_teardown(arguments_are_checked, test_folder_create,
                                        test_folder_remove),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
