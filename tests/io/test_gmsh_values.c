/* Values of $NodeData and $ElementData of Gmsh's files, text and binary, in all versions. */
#include "support/data_reading.h"
#include "support/gmsh_builder.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

typedef struct variant variant;

static const variant variants[] = {
    {0}, {.sparse = 1}, {.binary = 1}, {.binary = 1, .sparse = 1}, {.binary = 1, .swapped = 1}};
enum { N_VARIANTS = sizeof variants / sizeof *variants };

static file_builder make_mesh(const variant *v, int is_4) {
    int64_t place[N_NODES];
    return is_4 ? gmsh_make_msh4(v, place) : gmsh_make_msh2(v, place);
}

/** Begin a section of n values. */
static void begin_data(file_builder *builder, const char *kind, const char *name, int step,
                       int width, int n) {
    builder_text(builder, "$%s\n1\n\"%s\"\n1\n0.5\n3\n%d\n%d\n%d\n", kind, name, step, width, n);
}

static void end_data(file_builder *builder, const char *kind) {
    builder_text(builder, "\n$End%s\n", kind);
}

static double value_of(int64_t number, int k) {
    return 0.25 + (double)number + 10000.0 * k;
}

static void put_value(file_builder *builder, int64_t number, int width) {
    builder_integer(builder, number, 4);
    for (int k = 0; k < width; k++)
        builder_real(builder, value_of(number, k), 8);
    builder_line(builder);
}

/** Values of nodes first .. behind - 1, the last of them first, and of a node that is not there. */
static void put_nodes(file_builder *builder, const variant *v, const char *name, int width,
                      int first, int behind) {
    begin_data(builder, "NodeData", name, 0, width, behind - first + 1);
    for (int i = behind - 1; i >= first; i--)
        put_value(builder, gmsh_node_tag(v, i), width);
    put_value(builder, 123456, width);
    end_data(builder, "NodeData");
}

/** Values of all elements, and of the line that comes before them. */
static void put_elements(file_builder *builder, const char *name, int width) {
    static const int numbers[] = {2, 10, 11, 14, 19};
    begin_data(builder, "ElementData", name, 0, width, 5);
    for (int i = 0; i < 5; i++)
        put_value(builder, numbers[i], width);
    end_data(builder, "ElementData");
}

static planish_file *read_builder(const file_builder *builder) {
    planish_file *file;
    planish_error error = {.text = ""};
    if (builder_read(builder, &io_format_gmsh, 2, &file, &error))
        fail_msg("%s", error.text);
    return file;
}

/** Call visit with every way to write the mesh, to which it adds data. */
static void each_file(void (*visit)(file_builder *builder, const variant *v)) {
    for (int i = 0; i < 2 * N_VARIANTS; i++) {
        const variant *v = &variants[i / 2];
        file_builder builder = make_mesh(v, i % 2);
        visit(&builder, v);
        builder_release(&builder);
    }
}

/* ---- tests -------------------------------------------------------------------------------- */

static void read_all(file_builder *builder, const variant *v) {
    put_nodes(builder, v, "h", 1, 0, N_NODES);
    put_elements(builder, "c", 1);
    put_nodes(builder, v, "metric", 9, 0, N_NODES);
    put_elements(builder, "metric", 9);
    put_nodes(builder, v, "speed", 3, 0, N_NODES);
    planish_file *file = read_builder(builder);
    expect_data_list(file, "h:1 *c:1 metric:9 *metric:9 speed:3");
    for (int i = 0; i < 2; i++) {
        expect_data(file, "h", 0, 1, value_of);
        expect_data(file, "c", 1, 1, value_of);
        expect_data(file, "metric", 0, 9, value_of);
        expect_data(file, "speed", 0, 3, value_of);
    }
    planish_file_close(file);
    builder_try_to_break(builder, &io_format_gmsh);
    builder_expect_same_on_threads(builder, &io_format_gmsh);
}

static void every_encoding_is_read(void **state) {
    (void)state;
    each_file(read_all);
}

/** Parts of one array, and later times, which do not count. */
static void read_parts(file_builder *builder, const variant *v) {
    put_nodes(builder, v, "h", 1, 0, 2);
    put_nodes(builder, v, "h", 1, 1, N_NODES);
    begin_data(builder, "NodeData", "h", 1, 1, 1);
    put_value(builder, 77, 1);
    end_data(builder, "NodeData");
    planish_file *file = read_builder(builder);
    expect_data_list(file, "h:1");
    expect_data(file, "h", 0, 1, value_of);
    planish_file_close(file);
}

static void parts_are_one_array(void **state) {
    (void)state;
    each_file(read_parts);
}

static void miss_values(file_builder *builder, const variant *v) {
    char part[128];
    put_nodes(builder, v, "h", 1, 0, 2);
    put_elements(builder, "c", 1);
    begin_data(builder, "ElementData", "d", 0, 1, 1);
    put_value(builder, 11, 1);
    end_data(builder, "ElementData");
    planish_file *file = read_builder(builder);
    snprintf(part, sizeof part,
             "the array 'h' has no value for 4 of the 6 nodes, the first is node %d",
             (int)gmsh_node_tag(v, 2));
    expect_no_data(file, "h", PLANISH_ERROR_FORMAT, part);
    expect_no_data(file, "d", PLANISH_ERROR_FORMAT, "no value for 3 of the 4 elements");
    expect_no_data(file, "x", PLANISH_ERROR_ARGUMENT,
                   "the file has: h (nodes), c (elements), d (elements)");
    planish_file_close(file);
}

static void missing_values(void **state) {
    (void)state;
    each_file(miss_values);
}

static void lie(file_builder *builder, const variant *v) {
    begin_data(builder, "NodeData", "huge", 0, 1, 2147483647);
    put_value(builder, gmsh_node_tag(v, 0), 1);
    end_data(builder, "NodeData");
    begin_data(builder, "NodeData", "wide", 0, 2147483647, 1);
    put_value(builder, gmsh_node_tag(v, 0), 1);
    end_data(builder, "NodeData");
    begin_data(builder, "NodeData", "few", 0, 1, 3);
    put_value(builder, gmsh_node_tag(v, 0), 1);
    put_value(builder, gmsh_node_tag(v, 1), 1);
    end_data(builder, "NodeData");
    planish_file *file = read_builder(builder);
    expect_no_data(file, "huge", PLANISH_ERROR_FORMAT, "2147483647 huge cannot be in the ");
    expect_no_data(file, "wide", PLANISH_ERROR_FORMAT, "has 2147483647 numbers for each");
    expect_no_data(file, "few", PLANISH_ERROR_FORMAT, "file");
    planish_file_close(file);
}

static void counts_that_lie(void **state) {
    (void)state;
    each_file(lie);
}

static void wrong_text(void **state) {
    (void)state;
    file_builder builder = make_mesh(&variants[0], 1);
    builder_text(&builder, "$NodeData\n1\n\"many\"\n1\n0\n3\n0\n1\n2\n1 1\n2 1\n3 1\n$EndNodeData\n"
                           "$NodeData\n1\n\"words\"\n1\n0\n3\n0\n1\n2\n1 1\n2 two\n$EndNodeData\n"
                           "$NodeData\n1\n\"nan\"\n1\n0\n3\n0\n1\n6\n1 1\n2 nan\n3 1\n4 1\n5 1\n"
                           "6 1\n$EndNodeData\n"
                           "$NodeData\n0\n1\n0\n3\n0\n1\n1\n1 1\n$EndNodeData\n"
                           "$NodeData\nnone\n$EndNodeData\n");
    planish_file *file = read_builder(&builder);
    expect_data_list(file, "many:1 words:1 nan:1 NodeData:1");
    expect_no_data(file, "many", PLANISH_ERROR_FORMAT,
                   "array 'many': there are more values than their count says");
    expect_no_data(file, "words", PLANISH_ERROR_FORMAT, "array 'words': a number expected");
    expect_no_data(file, "nan", PLANISH_ERROR_FORMAT, "not finite, for node 2");
    planish_file_close(file);
    builder_release(&builder);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_encoding_is_read),
        cmocka_unit_test(parts_are_one_array),
        cmocka_unit_test(missing_values),
        cmocka_unit_test(counts_that_lie),
        cmocka_unit_test(wrong_text),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
