/* Values of elements in MSH files ($ElementData): which of them tell regions, beside the entities
 * that the file has; what is malformed is passed over. */
#include "support/square.h"
#include "support/file_builder.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Lines on the lower side come before the triangles of a square. */
enum { SIDE = 4, N_NODES = (SIDE + 1) * (SIDE + 1), N_TRIANGLES = 2 * SIDE * SIDE, N_LINES = 2 };

/** How a file is written. */
typedef struct variant {
    int is_4, binary, swapped;
    int sparse;       /* numbers of elements fall, with gaps; else 1, 2, 3, ... */
    int two_entities; /* below and above the middle */
} variant;

static int64_t number_of(const variant *v, int64_t element) {
    return v->sparse ? 1000000 - 7 * element : element + 1;
}

static double wide_halves(int column, int row, int index) {
    return square_halves(column, row, index) * 10000000000;
}

static double wide_behind_others(int column, int row, int index) {
    return row < SIDE / 2 ? square_halves(column, row, index) : 70000000000;
}

static double one_is_no_number(int column, int row, int index) {
    return index == 5 ? (double)NAN : square_halves(column, row, index);
}

static double one_is_not_whole(int column, int row, int index) {
    return index == N_TRIANGLES - 1 ? 7.5 : square_halves(column, row, index);
}

static double value_at(square_value_fn *value, int triangle) {
    return value(triangle / 2 % SIDE, triangle / 2 / SIDE, triangle);
}

/* ---- files -------------------------------------------------------------------------------- */

static void put_numbers(file_builder *builder, int size, int n, const int64_t *numbers) {
    for (int i = 0; i < n; i++)
        builder_integer(builder, numbers[i], size);
    builder_line(builder);
}

static void put_node_block(file_builder *builder, const variant *v) {
    if (v->is_4) {
        put_numbers(builder, 8, 4, (const int64_t[]){1, N_NODES, 1, N_NODES});
        put_numbers(builder, 4, 3, (const int64_t[]){2, 1, 0});
        put_numbers(builder, 8, 1, (const int64_t[]){N_NODES});
    }
    for (int64_t i = 0; i < N_NODES && v->is_4; i++)
        put_numbers(builder, 8, 1, (const int64_t[]){i + 1});
    for (int64_t i = 0; i < N_NODES; i++) {
        if (!v->is_4)
            builder_integer(builder, i + 1, 4);
        builder_real(builder, (double)(i % (SIDE + 1)), 8);
        builder_real(builder, (double)(i / (SIDE + 1)), 8);
        builder_real(builder, 0, 8);
        builder_line(builder);
    }
}

/** Nodes of an element of index i; returns how many. */
static int nodes_of(int i, int64_t *nodes) {
    static const int corner[2][3] = {{0, 1, SIDE + 2}, {0, SIDE + 2, SIDE + 1}};
    const int t = i - N_LINES;
    const int n = t < 0 ? 2 : 3;
    for (int k = 0; k < n; k++)
        nodes[k] =
            1 + (t < 0 ? i + k : t / 2 / SIDE * (SIDE + 1) + t / 2 % SIDE + corner[t % 2][k]);
    return n;
}

static int entity_of(const variant *v, int i) {
    return v->two_entities && i >= N_LINES + N_TRIANGLES / 2 ? 2 : 1;
}

static void put_elements2(file_builder *builder, const variant *v) {
    for (int i = 0; i < N_LINES + N_TRIANGLES; i++) {
        int64_t nodes[3];
        const int n = nodes_of(i, nodes), entity = entity_of(v, i);
        if (v->binary)
            put_numbers(builder, 4, 3, (const int64_t[]){n - 1, 1, 2});
        builder_integer(builder, number_of(v, i), 4);
        if (!v->binary)
            put_numbers(builder, 4, 2, (const int64_t[]){n - 1, 2});
        put_numbers(builder, 4, 2, (const int64_t[]){10 * entity, entity});
        put_numbers(builder, 4, n, nodes);
    }
}

static void put_block4(file_builder *builder, const variant *v, int first, int behind) {
    int64_t nodes[3];
    const int dim = nodes_of(first, nodes) - 1;
    put_numbers(builder, 4, 3, (const int64_t[]){dim, entity_of(v, first), dim});
    put_numbers(builder, 8, 1, (const int64_t[]){behind - first});
    for (int i = first; i < behind; i++) {
        builder_integer(builder, number_of(v, i), 8);
        put_numbers(builder, 8, nodes_of(i, nodes), nodes);
    }
}

static void put_elements4(file_builder *builder, const variant *v) {
    const int n = N_LINES + N_TRIANGLES, middle = N_LINES + N_TRIANGLES / 2;
    put_numbers(builder, 8, 4, (const int64_t[]){3, n, 1, 1000000});
    put_block4(builder, v, 0, N_LINES);
    put_block4(builder, v, N_LINES, middle);
    put_block4(builder, v, middle, n);
}

static void put_entities4(file_builder *builder) {
    builder_text(builder, "$Entities\n");
    put_numbers(builder, 8, 4, (const int64_t[]){0, 1, 2, 0});
    for (int i = 0; i < 3; i++) {
        put_numbers(builder, 4, 1, (const int64_t[]){i > 1 ? 2 : 1});
        for (int k = 0; k < 6; k++)
            builder_real(builder, 0, 8);
        put_numbers(builder, 8, 1, (const int64_t[]){1});
        put_numbers(builder, 4, 1, (const int64_t[]){i > 1 ? 20 : 10});
        put_numbers(builder, 8, 1, (const int64_t[]){0});
    }
    builder_text(builder, "\n$EndEntities\n");
}

static file_builder begin_file(const variant *v) {
    file_builder builder = {.binary = v->binary, .swapped = v->swapped};
    builder_text(&builder, "$MeshFormat\n%s %d 8\n", v->is_4 ? "4.1" : "2.2", v->binary);
    if (v->binary) {
        builder_integer(&builder, 1, 4);
        builder_text(&builder, "\n");
    }
    builder_text(&builder, "$EndMeshFormat\n$PhysicalNames\n2\n2 10 \"lower\"\n2 20 \"upper\"\n"
                           "$EndPhysicalNames\n");
    return builder;
}

static void put_mesh(file_builder *builder, const variant *v) {
    if (v->is_4)
        put_entities4(builder);
    builder_text(builder, "$Nodes\n");
    if (!v->is_4)
        builder_text(builder, "%d\n", N_NODES);
    put_node_block(builder, v);
    builder_text(builder, "\n$EndNodes\n$Elements\n");
    if (!v->is_4)
        builder_text(builder, "%d\n", N_LINES + N_TRIANGLES);
    if (v->is_4)
        put_elements4(builder, v);
    else
        put_elements2(builder, v);
    builder_text(builder, "\n$EndElements\n");
}

static file_builder make_square(const variant *v) {
    file_builder builder = begin_file(v);
    put_mesh(&builder, v);
    return builder;
}

/** A section of n values before which step, width and count stand. */
static void begin_data(file_builder *builder, const char *name, int step, int width, int n) {
    builder_text(builder, "$ElementData\n1\n%s\n1\n0.5\n3\n%d\n%d\n%d\n", name, step, width, n);
}

static void end_data(file_builder *builder) {
    builder_text(builder, "\n$EndElementData\n");
}

static void put_value(file_builder *builder, int64_t element_number, double value) {
    builder_integer(builder, element_number, 4);
    builder_real(builder, value, 8);
    builder_line(builder);
}

/** Values of triangles first .. behind - 1. */
static void put_triangles(file_builder *builder, const variant *v, square_value_fn *value,
                          int first, int behind) {
    for (int i = first; i < behind; i++)
        put_value(builder, number_of(v, N_LINES + i), value_at(value, i));
}

/** A section with values of all elements; those of lines are not whole, and one is of an element
 *  that is not there. */
static void put_data(file_builder *builder, const variant *v, const char *name,
                     square_value_fn *value) {
    begin_data(builder, name, 0, 1, N_LINES + 1 + N_TRIANGLES);
    for (int i = 0; i < N_LINES; i++)
        put_value(builder, number_of(v, i), 0.5);
    put_value(builder, 77777777, 0.25);
    put_triangles(builder, v, value, 0, N_TRIANGLES);
    end_data(builder);
}

/* ---- what is expected --------------------------------------------------------------------- */

static planish_file *read_square(const file_builder *builder) {
    planish_file *file = NULL;
    planish_error error = {.text = ""};
    if (builder_read(builder, &io_format_gmsh, 1, &file, &error))
        fail_msg("%s", error.text);
    return file;
}

static void expect_regions(const planish_file *file, int n) {
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(info.n_regions, n);
}

static void expect_region(const planish_file *file, int64_t element, const char *expected) {
    char text[64];
    assert_true(planish_file_element_region(file, element, text, sizeof text) >= 0);
    assert_string_equal(text, expected);
}

/** What the file says of regions: names of all arrays, of those that tell regions, what is held. */
static void expect_file(const file_builder *builder, const char *all, const char *regions,
                        int column, int row) {
    planish_file *file = read_square(builder);
    expect_names(planish_file_cell_arrays(file), all);
    expect_names(planish_file_region_arrays(file), regions);
    expect_held(file, column, row);
    planish_file_close(file);
}

/* ---- tests -------------------------------------------------------------------------------- */

static const variant variants[] = {{.is_4 = 0},
                                   {.is_4 = 1},
                                   {.is_4 = 0, .binary = 1},
                                   {.is_4 = 1, .binary = 1},
                                   {.is_4 = 0, .binary = 1, .swapped = 1},
                                   {.is_4 = 1, .binary = 1, .swapped = 1},
                                   {.is_4 = 0, .sparse = 1},
                                   {.is_4 = 1, .binary = 1, .sparse = 1}};
enum { N_VARIANTS = sizeof variants / sizeof *variants };

static void data_tell_regions(void **state) {
    (void)state;
    for (int i = 0; i < N_VARIANTS; i++) {
        file_builder builder = make_square(&variants[i]);
        expect_file(&builder, "", "", 0, 0);
        put_data(&builder, &variants[i], "\"my color\"", square_halves);
        put_data(&builder, &variants[i], "\"numbers\"", square_number);
        put_data(&builder, &variants[i], "\"stress\"", one_is_not_whole);
        planish_file *file = read_square(&builder);
        expect_names(planish_file_cell_arrays(file), "my color numbers");
        expect_names(planish_file_region_arrays(file), "my color");
        expect_held(file, 1, 0);
        expect_regions(file, 2);
        expect_region(file, 0, "lower");
        expect_region(file, N_TRIANGLES - 1, "lower");
        planish_file_close(file);
        builder_expect_same_on_threads(&builder, &io_format_gmsh);
        builder_try_to_break(&builder, &io_format_gmsh);
        builder_release(&builder);
    }
}

static int choose(planish_file *file, const char *name, planish_error *error) {
    return planish_file_choose_regions(file, &name, 1, error);
}

/** The file's own entities hold as they do without data, keep their names, and stay when arrays are
 *  chosen. */
static void data_add_to_entities(void **state) {
    (void)state;
    for (int i = 0; i < N_VARIANTS; i++) {
        variant v = variants[i];
        v.two_entities = 1;
        file_builder builder = make_square(&v);
        expect_file(&builder, "", "", 0, 1);
        put_data(&builder, &v, "\"numbers\"", square_number);
        expect_file(&builder, "numbers", "", 0, 1);
        put_data(&builder, &v, "\"color\"", square_halves);
        expect_file(&builder, "numbers color", "color", 1, 1);

        planish_file *file = read_square(&builder);
        planish_error error = {.text = ""};
        const planish_hold none = {.ignore_regions = 1};
        const char *const upper[] = {"upper"};
        const planish_hold fix = {.ignore_regions = 1, .tags = upper, .n_tags = 1};
        uint8_t constraint[N_NODES];
        expect_regions(file, 4);
        expect_region(file, 0, "lower");
        expect_region(file, N_TRIANGLES - 1, "upper");
        expect_held_with(file, &none, 0, 0);
        assert_int_equal(planish_file_constraints(file, &fix, constraint, NULL), PLANISH_OK);
        assert_int_equal(constraint[SIDE + 2], PLANISH_CONSTRAINT_FREE);
        assert_int_equal(constraint[N_NODES - SIDE - 3], PLANISH_CONSTRAINT_FIXED);
        assert_int_equal(choose(file, "nothing", &error), PLANISH_ERROR_ARGUMENT);
        assert_non_null(strstr(error.text, "the file has: numbers, color"));
        assert_int_equal(choose(file, "color", &error), PLANISH_OK);
        expect_names(planish_file_region_arrays(file), "color");
        expect_held(file, 1, 1);
        expect_regions(file, 4);
        planish_file_close(file);
        builder_release(&builder);
    }
}

static void arrays_are_chosen(void **state) {
    (void)state;
    const variant v = {.two_entities = 1};
    file_builder builder = make_square(&v);
    planish_error error = {.text = ""};
    put_data(&builder, &v, "\"color\"", square_halves);
    put_data(&builder, &v, "\"partition\"", square_rows);
    expect_file(&builder, "color partition", "color", 1, 1);
    planish_file *file = read_square(&builder);
    assert_int_equal(choose(file, "partition", &error), PLANISH_OK);
    expect_names(planish_file_region_arrays(file), "partition");
    expect_held(file, 0, 1);
    expect_regions(file, 2);
    expect_region(file, 0, "lower");
    planish_file_close(file);
    builder_release(&builder);
}

static void some_data_are_no_regions(void **state) {
    (void)state;
    for (int i = 0; i < N_VARIANTS; i++) {
        const variant *v = &variants[i];
        file_builder builder = make_square(v);
        put_data(&builder, v, "\"no number\"", one_is_no_number);
        put_data(&builder, v, "\"not whole\"", one_is_not_whole);
        begin_data(&builder, "\"one is missing\"", 0, 1, N_TRIANGLES - 1);
        put_triangles(&builder, v, square_halves, 1, N_TRIANGLES);
        end_data(&builder);
        begin_data(&builder, "\"vectors\"", 0, 3, N_TRIANGLES);
        for (int t = 0; t < N_TRIANGLES; t++) {
            put_value(&builder, number_of(v, N_LINES + t), value_at(square_halves, t));
            builder_real(&builder, 0, 8);
            builder_real(&builder, 0, 8);
        }
        end_data(&builder);
        builder_text(&builder, "$ElementNodeData\n1\n\"x\"\n0\n3\n0\n1\n0\n$EndElementNodeData\n");
        expect_file(&builder, "", "", 0, 0);
        builder_release(&builder);
    }
}

/** Numbers beyond 32 bits, first and behind others. */
static void wide_values(void **state) {
    (void)state;
    for (int i = 0; i < N_VARIANTS; i++) {
        file_builder builder = make_square(&variants[i]);
        put_data(&builder, &variants[i], "\"wide\"", wide_halves);
        expect_file(&builder, "wide", "wide", 1, 0);
        builder_release(&builder);

        builder = make_square(&variants[i]);
        put_data(&builder, &variants[i], "\"wide\"", wide_behind_others);
        planish_file *file = read_square(&builder);
        expect_regions(file, 3);
        planish_file_close(file);
        builder_release(&builder);
    }
}

/** Of several steps the first counts; sections of one step complement one another, and what comes
 *  behind a full one is an array of its own. */
static void steps_and_parts(void **state) {
    (void)state;
    for (int i = 0; i < N_VARIANTS; i++) {
        const variant *v = &variants[i];
        file_builder builder = make_square(v);
        begin_data(&builder, "\"color\"", 3, 1, 20);
        put_triangles(&builder, v, square_halves, 0, 20);
        end_data(&builder);
        put_data(&builder, v, "\"color\"", square_rows); /* another step */
        expect_file(&builder, "", "", 0, 0);
        begin_data(&builder, "\"color\"", 3, 1, N_TRIANGLES - 18);
        put_triangles(&builder, v, square_halves, 18, N_TRIANGLES);
        end_data(&builder);
        expect_file(&builder, "color", "color", 1, 0);
        begin_data(&builder, "\"color\"", 3, 1, N_TRIANGLES);
        put_triangles(&builder, v, square_rows, 0, N_TRIANGLES);
        end_data(&builder);
        expect_file(&builder, "color color", "color color", 1, 1);
        builder_release(&builder);
    }
}

/** Gmsh takes the last of several values, and a name without quotes or none. */
static void odd_data(void **state) {
    (void)state;
    const variant v = {.is_4 = 0};
    file_builder builder = make_square(&v);
    begin_data(&builder, " a b ", 0, 1, 2 * N_TRIANGLES);
    put_triangles(&builder, &v, square_rows, 0, N_TRIANGLES);
    put_triangles(&builder, &v, square_halves, 0, N_TRIANGLES);
    end_data(&builder);
    expect_file(&builder, "a b", "a b", 1, 0);
    builder_text(&builder, "$ElementData\n0\n0\n3\n0\n1\n%d\n", N_TRIANGLES);
    put_triangles(&builder, &v, square_rows, 0, N_TRIANGLES);
    end_data(&builder);
    expect_file(&builder, "a b ElementData", "a b ElementData", 1, 1);
    builder_release(&builder);
}

static void data_before_the_mesh(void **state) {
    (void)state;
    for (int i = 0; i < N_VARIANTS; i++) {
        file_builder builder = begin_file(&variants[i]);
        put_data(&builder, &variants[i], "\"color\"", square_halves);
        put_mesh(&builder, &variants[i]);
        expect_file(&builder, "color", "color", 1, 0);
        builder_release(&builder);
    }
}

/** Files stay readable, and other sections count. */
static void malformed_text_is_passed_over(void **state) {
    (void)state;
    static const char *const sections[] = {
        "",
        "1\n",
        "-1\n",
        "99999999999\n",
        "1\n\"x\"\n1\n0\n2\n0\n1\n",
        "1\n\"x\"\n1\nzero\n3\n0\n1\n1\n3 1\n",
        "1\n\"x\"\n1\n0\n3\n0\n1\n-5\n3 1\n",
        "1\n\"x\"\n1\n0\n3\n0\n-1\n1\n3 1\n",
        "1\n\"x\"\n1\n0\n3\n0\n1\n9223372036854775807\n3 1\n",
        "1\n\"x\"\n1\n0\n3\n0\n1\n3\n3 1\n4 1\n",
        "1\n\"x\"\n1\n0\n3\n0\n1\n2\n3 1\n4 many\n",
        "1\n\"x\"\n1\n0\n3\n0\n1\n2\n3 1\n4.5 1\n",
        "1\n\"x\n1\n0\n3\n0\n1\n2\n3 1\n",
        "1\n\"x\"\n1\n0\n3\n0\n1\n0\n",
    };
    for (size_t i = 0; i < sizeof sections / sizeof *sections; i++)
        for (int is_4 = 0; is_4 < 2; is_4++) {
            const variant v = {.is_4 = is_4};
            file_builder builder = make_square(&v);
            builder_text(&builder, "$ElementData\n%s$EndElementData\n", sections[i]);
            expect_file(&builder, "", "", 0, 0);
            put_data(&builder, &v, "\"color\"", square_halves);
            expect_file(&builder, "color", "color", 1, 0);
            builder_release(&builder);
        }
}

static void malformed_binary_is_passed_over(void **state) {
    (void)state;
    static const int counts[] = {0, 1, N_TRIANGLES - 1, N_TRIANGLES + 1, INT32_MAX, -1};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
        for (int is_4 = 0; is_4 < 2; is_4++) {
            const variant v = {.is_4 = is_4, .binary = 1};
            file_builder builder = make_square(&v);
            begin_data(&builder, "\"x\"", 0, 1, counts[i]);
            put_triangles(&builder, &v, square_halves, 0, N_TRIANGLES);
            end_data(&builder);
            expect_file(&builder, "", "", 0, 0);
            put_data(&builder, &v, "\"color\"", square_halves);
            expect_file(&builder, "color", "color", 1, 0);
            builder_release(&builder);
        }
}

/** More sections than are kept. */
static void many_sections(void **state) {
    (void)state;
    const variant v = {.is_4 = 1};
    file_builder builder = make_square(&v);
    for (int i = 0; i < 300; i++) {
        char name[32];
        snprintf(name, sizeof name, "\"%d\"", i);
        put_data(&builder, &v, name, square_halves);
    }
    planish_file *file = read_square(&builder);
    int n = 0;
    while (planish_file_region_arrays(file)[n])
        n++;
    assert_int_equal(n, 256);
    expect_held(file, 1, 0);
    planish_file_close(file);
    builder_release(&builder);
}

/* ---- several threads ---------------------------------------------------------------------- */

enum { LARGE = 370 }; /* nodes along a side: values enough for threads */

static file_builder make_large(int binary, int is_broken) {
    file_builder builder = {.binary = binary};
    const int n = 2 * (LARGE - 1) * (LARGE - 1);
    builder_text(&builder, "$MeshFormat\n2.2 %d 8\n", binary);
    if (binary) {
        builder_integer(&builder, 1, 4);
        builder_text(&builder, "\n");
    }
    builder_text(&builder, "$EndMeshFormat\n$Nodes\n%d\n", LARGE * LARGE);
    for (int i = 0; i < LARGE * LARGE; i++) {
        builder_integer(&builder, i + 1, 4);
        builder_real(&builder, i % LARGE, 8);
        builder_real(&builder, i / LARGE, 8);
        builder_real(&builder, 0, 8);
        builder_line(&builder);
    }
    builder_text(&builder, "\n$EndNodes\n$Elements\n%d\n", n);
    if (binary)
        put_numbers(&builder, 4, 3, (const int64_t[]){2, n, 0});
    for (int t = 0; t < n; t++) {
        const int cell = t / 2, corner = cell / (LARGE - 1) * LARGE + cell % (LARGE - 1) + 1;
        const int second = t % 2 ? LARGE + 1 : 1, third = t % 2 ? LARGE : LARGE + 1;
        builder_integer(&builder, 3 * t, 4);
        if (!binary)
            put_numbers(&builder, 4, 2, (const int64_t[]){2, 0});
        put_numbers(&builder, 4, 3, (const int64_t[]){corner, corner + second, corner + third});
    }
    builder_text(&builder, "\n$EndElements\n");
    begin_data(&builder, "\"color\"", 0, 1, n);
    for (int t = n - 1; t >= 0; t--)
        put_value(&builder, 3 * t, is_broken && t == 5 ? 0.5 : t < n / 3);
    end_data(&builder);
    return builder;
}

static void large_data_on_threads(void **state) {
    (void)state;
    for (int i = 0; i < 4; i++) {
        file_builder builder = make_large(i / 2, i % 2);
        for (int threads = 1; threads <= 3; threads += 2) {
            planish_file *file;
            planish_error error = {.text = ""};
            if (builder_read(&builder, &io_format_gmsh, threads, &file, &error))
                fail_msg("%s", error.text);
            expect_names(planish_file_region_arrays(file), i % 2 ? "" : "color");
            expect_regions(file, i % 2 ? 1 : 2);
            planish_file_close(file);
        }
        builder_expect_same_on_threads(&builder, &io_format_gmsh);
        builder_release(&builder);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(data_tell_regions),
        cmocka_unit_test(data_add_to_entities),
        cmocka_unit_test(arrays_are_chosen),
        cmocka_unit_test(some_data_are_no_regions),
        cmocka_unit_test(wide_values),
        cmocka_unit_test(steps_and_parts),
        cmocka_unit_test(odd_data),
        cmocka_unit_test(data_before_the_mesh),
        cmocka_unit_test(malformed_text_is_passed_over),
        cmocka_unit_test(malformed_binary_is_passed_over),
        cmocka_unit_test(many_sections),
        cmocka_unit_test(large_data_on_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
