/* Arrays of one number per cell: which tell regions when a file is opened, which the caller
 * chooses, what element regions, groups and slides make of them; damaged files and short memory. */
#include "support/square.h"
#include "support/file_builder.h"

#include "io/file/file.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { SIDE = 4, N_NODES = (SIDE + 1) * (SIDE + 1), N_TRIANGLES = 2 * SIDE * SIDE, N_LINES = 2 };

/** Value of a triangle in a column and row of the square. */
typedef int64_t value_fn(int column, int row, int index);

static int64_t halves(int column, int row, int index) {
    (void)row;
    (void)index;
    return column < SIDE / 2 ? 3 : 7;
}

static int64_t wide_halves(int column, int row, int index) {
    return halves(column, row, index) * 10000000000;
}

static int64_t rows(int column, int row, int index) {
    (void)column;
    (void)index;
    return row < SIDE / 2 ? -1 : 1;
}

static int64_t number(int column, int row, int index) {
    (void)column;
    (void)row;
    return index;
}

static void put_array(file_builder *builder, const char *name, const char *type, int size,
                      value_fn *value) {
    builder_text(builder, "SCALARS %s %s\nLOOKUP_TABLE default\n", name, type);
    for (int i = 0; i < N_LINES; i++)
        builder_integer(builder, 99, size);
    for (int i = 0; i < N_TRIANGLES; i++)
        builder_integer(builder, value(i / 2 % SIDE, i / 2 / SIDE, i), size);
    builder_text(builder, "\n");
}

/** A square of triangles behind two lines at its lower side, to which arrays may be added. */
static file_builder make_square(int binary) {
    static const int corner[2][3] = {{0, 1, SIDE + 2}, {0, SIDE + 2, SIDE + 1}};
    file_builder builder = {.binary = binary, .swapped = 1};
    const int n = N_LINES + N_TRIANGLES;
    builder_text(&builder, "# vtk DataFile Version 3.0\nsquare\n%s\nDATASET UNSTRUCTURED_GRID\n",
                 binary ? "BINARY" : "ASCII");
    builder_text(&builder, "POINTS %d double\n", N_NODES);
    for (int i = 0; i < N_NODES; i++) {
        builder_real(&builder, i % (SIDE + 1), 8);
        builder_real(&builder, i / (SIDE + 1), 8);
        builder_real(&builder, 0, 8);
    }
    builder_text(&builder, "\nCELLS %d %d\n", n, 3 * N_LINES + 4 * N_TRIANGLES);
    for (int i = 0; i < N_LINES; i++) {
        builder_integer(&builder, 2, 4);
        builder_integer(&builder, i, 4);
        builder_integer(&builder, i + 1, 4);
    }
    for (int i = 0; i < N_TRIANGLES; i++) {
        builder_integer(&builder, 3, 4);
        for (int k = 0; k < 3; k++)
            builder_integer(&builder, i / 2 / SIDE * (SIDE + 1) + i / 2 % SIDE + corner[i % 2][k],
                            4);
    }
    builder_text(&builder, "\nCELL_TYPES %d\n", n);
    for (int i = 0; i < n; i++)
        builder_integer(&builder, i < N_LINES ? 3 : 5, 4);
    builder_text(&builder, "\nCELL_DATA %d\n", n);
    return builder;
}

static planish_file *read_square(const file_builder *builder) {
    planish_file *file = NULL;
    planish_error error = {.text = ""};
    if (builder_read(builder, &io_format_vtk, 1, &file, &error))
        fail_msg("%s", error.text);
    return file;
}

static void expect_region(const planish_file *file, int64_t element, const char *expected) {
    char text[64];
    assert_true(planish_file_element_region(file, element, text, sizeof text) >= 0);
    assert_string_equal(text, expected);
}

static int choose(planish_file *file, const char *first, const char *second, planish_error *error) {
    const char *const names[] = {first, second};
    return planish_file_choose_regions(file, names, second ? 2 : first ? 1 : 0, error);
}

static int64_t count_regions(const planish_file *file) {
    planish_file_info info;
    planish_file_get_info(file, &info);
    return info.n_regions;
}

static void arrays_are_found(void **state) {
    (void)state;
    for (int binary = 0; binary <= 1; binary++) {
        file_builder builder = make_square(binary);
        put_array(&builder, "Zone%20Id", "int", 4, halves);
        put_array(&builder, "number", "vtktypeint64", 8, number);
        put_array(&builder, "rank", "short", 2, halves);
        put_array(&builder, "layer", "signed_char", 1, rows);
        planish_file *file = read_square(&builder);
        expect_names(planish_file_cell_arrays(file), "Zone Id number rank layer");
        expect_names(planish_file_region_arrays(file), "Zone Id layer");
        expect_held(file, 1, 1);
        assert_int_equal(count_regions(file), 4);
        expect_region(file, 0, "2:3");
        expect_region(file, N_TRIANGLES - 1, "2:7");
        const planish_surface surface = planish_file_surface(file, NULL);
        assert_non_null(surface.region);
        assert_int_equal(surface.region[0], surface.region[2]);
        assert_true(surface.region[0] != surface.region[N_TRIANGLES - 1]);
        planish_file_close(file);
        builder_expect_same_on_threads(&builder, &io_format_vtk);
        builder_release(&builder);
    }
}

static void arrays_are_chosen(void **state) {
    (void)state;
    planish_error error = {.text = ""};
    file_builder builder = make_square(0);
    put_array(&builder, "zone", "int", 4, halves);
    put_array(&builder, "rank", "int", 4, rows);
    planish_file *file = read_square(&builder);
    assert_int_equal(choose(file, "zone", "nothing", &error), PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "there is no array 'nothing'"));
    assert_non_null(strstr(error.text, "the file has: zone, rank"));
    expect_held(file, 1, 0);
    assert_int_equal(choose(file, "rank", "zone", &error), PLANISH_OK);
    expect_names(planish_file_region_arrays(file), "zone rank");
    expect_held(file, 1, 1);
    expect_region(file, 0, "2:-1");
    assert_int_equal(choose(file, "zone", NULL, &error), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(choose(file, NULL, NULL, &error), PLANISH_OK);
    expect_held(file, 1, 1);
    planish_file_close(file);

    file = read_square(&builder);
    assert_int_equal(choose(file, "rank", NULL, &error), PLANISH_OK);
    expect_names(planish_file_region_arrays(file), "rank");
    expect_held(file, 0, 1);
    assert_int_equal(count_regions(file), 2);
    planish_file_close(file);

    file = read_square(&builder);
    assert_int_equal(choose(file, NULL, NULL, &error), PLANISH_OK);
    expect_names(planish_file_region_arrays(file), "zone");
    expect_names(planish_file_cell_arrays(file), "zone rank");
    expect_held(file, 1, 0);
    planish_file_close(file);
    assert_int_equal(planish_file_choose_regions(NULL, NULL, 0, &error), PLANISH_ERROR_ARGUMENT);
    assert_null(*planish_file_region_arrays(NULL));
    assert_null(*planish_file_cell_arrays(NULL));
    builder_release(&builder);
}

/** Put numbers of the edges of the square, 8 where an edge is marked and on its middle column, and then of
 *  its triangles. */
static void put_marks(file_builder *builder, const char *name, int is_marked) {
    static const int step[3][2] = {{1, 0}, {0, 1}, {1, 1}};
    builder_text(builder, "SCALARS %s int\nLOOKUP_TABLE default\n", name);
    for (int i = 0; i < 3 * N_NODES; i++) {
        const int x = i / 3 % (SIDE + 1), y = i / 3 / (SIDE + 1), k = i % 3;
        if (x + step[k][0] <= SIDE && y + step[k][1] <= SIDE)
            builder_text(builder, "%d ", is_marked && k == 1 && x == SIDE / 2 ? 8 : 0);
    }
    for (int i = 0; i < N_TRIANGLES; i++)
        builder_text(builder, "1 ");
    builder_text(builder, "\n");
}

/** A square of triangles behind all of their edges. Of its arrays one marks the edges in the middle. */
static file_builder make_edges(int first_marks) {
    enum { N_EDGES = 2 * SIDE * (SIDE + 1) + SIDE * SIDE, N = N_EDGES + N_TRIANGLES };
    const int row = SIDE + 1, next[3] = {1, row, row + 1};
    file_builder builder = {.binary = 0};
    builder_text(&builder, "# vtk DataFile Version 3.0\nedges\nASCII\nDATASET UNSTRUCTURED_GRID\n");
    builder_text(&builder, "POINTS %d double\n", N_NODES);
    for (int i = 0; i < N_NODES; i++)
        builder_text(&builder, "%d %d 0\n", i % row, i / row);
    builder_text(&builder, "CELLS %d %d\n", N, 3 * N_EDGES + 4 * N_TRIANGLES);
    for (int i = 0; i < 3 * N_NODES; i++) {
        const int x = i / 3 % row, y = i / 3 / row, k = i % 3;
        if (x + (k != 1) <= SIDE && y + (k != 0) <= SIDE)
            builder_text(&builder, "2 %d %d\n", i / 3, i / 3 + next[k]);
    }
    for (int i = 0; i < N_TRIANGLES; i++) {
        const int a = i / 2 / SIDE * row + i / 2 % SIDE;
        builder_text(&builder, "3 %d %d %d\n", a, i % 2 ? a + row + 1 : a + 1,
                     i % 2 ? a + row : a + row + 1);
    }
    builder_text(&builder, "CELL_TYPES %d\n", N);
    for (int i = 0; i < N; i++)
        builder_text(&builder, "%d\n", i < N_EDGES ? 3 : 5);
    builder_text(&builder, "CELL_DATA %d\n", N);
    put_marks(&builder, "MaterialIDs", first_marks);
    put_marks(&builder, "other", !first_marks);
    return builder;
}

/** Expect that of the nodes inside just those on the middle column are held, or none. */
static void expect_middle_held(const planish_file *file, int is_held) {
    uint8_t constraint[N_NODES];
    assert_int_equal(planish_file_constraints(file, NULL, constraint, NULL), PLANISH_OK);
    for (int i = 0; i < N_NODES; i++) {
        const int x = i % (SIDE + 1), y = i / (SIDE + 1);
        if (x > 0 && x < SIDE && y > 0 && y < SIDE)
            assert_int_equal(constraint[i] != PLANISH_CONSTRAINT_FREE, is_held && x == SIDE / 2);
    }
}

/** Which of all edges hold their nodes is decided by the array that is chosen. */
static void chosen_arrays_decide_on_lists(void **state) {
    (void)state;
    for (int first_marks = 0; first_marks < 2; first_marks++) {
        const planish_group *group;
        planish_error error = {.text = ""};
        int64_t n_before, n;
        file_builder builder = make_edges(first_marks);
        planish_file *file = read_square(&builder);
        expect_middle_held(file, first_marks);
        assert_int_equal(planish_file_groups(file, &group, &n_before, &error), PLANISH_OK);
        assert_int_equal(choose(file, "other", NULL, &error), PLANISH_OK);
        expect_middle_held(file, !first_marks);
        assert_int_equal(planish_file_groups(file, &group, &n, &error), PLANISH_OK);
        assert_int_equal(n - n_before, first_marks ? -1 : 1);
        planish_file_close(file);
        builder_release(&builder);
    }
}

/** Numbers of 64 bits make regions, but no tags. */
static void wide_numbers_are_regions(void **state) {
    (void)state;
    for (int binary = 0; binary <= 1; binary++) {
        planish_error error = {.text = ""};
        file_builder builder = make_square(binary);
        put_array(&builder, "zone", "vtktypeint64", 8, wide_halves);
        put_array(&builder, "rank", "vtktypeint64", 8, rows);
        planish_file *file = read_square(&builder);
        expect_names(planish_file_region_arrays(file), "zone");
        expect_held(file, 1, 0);
        expect_region(file, 0, "");
        assert_int_equal(choose(file, "zone", "rank", &error), PLANISH_OK);
        expect_held(file, 1, 1);
        planish_file_close(file);
        builder_try_to_break(&builder, &io_format_vtk);
        builder_release(&builder);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arrays_are_found),
        cmocka_unit_test(arrays_are_chosen),
        cmocka_unit_test(chosen_arrays_decide_on_lists),
        cmocka_unit_test(wide_numbers_are_regions),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
