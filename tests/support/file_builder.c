/* file_builder: mesh files in memory, the same numbers as text or as binary of either byte order.
 */
#include "support/file_builder.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/allocations.h"
#include "support/effort.h"

void builder_release(file_builder *builder) {
    free(builder->data);
    builder->data = NULL;
    builder->size = builder->capacity = 0;
}

static void append(file_builder *builder, const char *data, int64_t size) {
    if (builder->size + size > builder->capacity) {
        builder->capacity = 2 * builder->capacity + size;
        builder->data = realloc(builder->data, (size_t)builder->capacity);
        assert_non_null(builder->data);
    }
    memcpy(builder->data + builder->size, data, (size_t)size);
    builder->size += size;
}

void builder_text(file_builder *builder, const char *format, ...) {
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    assert_in_range(length, 0, sizeof text - 1);
    append(builder, text, length);
    builder->on_line = 0;
}

/* The number's bytes, in the other order if the file is swapped. */
static void append_bytes(file_builder *builder, const void *value, int size) {
    char bytes[8];
    memcpy(bytes, value, (size_t)size);
    for (int i = 0; builder->swapped && i < size / 2; i++) {
        char first = bytes[i];
        bytes[i] = bytes[size - 1 - i];
        bytes[size - 1 - i] = first;
    }
    append(builder, bytes, size);
}

static void append_number(file_builder *builder, const char *text) {
    append(builder, text, (int64_t)strlen(text));
    builder->on_line++;
    if (builder->wrap > 0 && builder->on_line == builder->wrap) {
        append(builder, "\n", 1);
        builder->on_line = 0;
    } else {
        append(builder, " ", 1);
    }
}

void builder_integer(file_builder *builder, int64_t value, int size) {
    char text[32];
    int8_t byte = (int8_t)value;
    int16_t two = (int16_t)value;
    int32_t four = (int32_t)value;
    snprintf(text, sizeof text, "%lld", (long long)value);
    if (!builder->binary)
        append_number(builder, text);
    else
        append_bytes(builder,
                     size == 1   ? (const void *)&byte
                     : size == 2 ? (const void *)&two
                     : size == 4 ? (const void *)&four
                                 : (const void *)&value,
                     size);
}

void builder_real(file_builder *builder, double value, int size) {
    char text[40];
    float single = (float)value;
    snprintf(text, sizeof text, "%.17g", value);
    if (!builder->binary)
        append_number(builder, text);
    else
        append_bytes(builder, size == 4 ? (const void *)&single : (const void *)&value, size);
}

void builder_line(file_builder *builder) {
    if (!builder->binary && builder->wrap == 0)
        append(builder, "\n", 1);
    builder->on_line = 0;
}

int64_t builder_place(const file_builder *builder) {
    return builder->size;
}

int builder_read(const file_builder *builder, const io_format *format, int threads,
                 planish_file **file, planish_error *error) {
    *file = NULL;
    return io_file_from_memory(format, "file", builder->data, builder->size, threads, file, error);
}

file_builder builder_of(const char *text) {
    return (file_builder){.data = (char *)(uintptr_t)text, .size = (int64_t)strlen(text)};
}

planish_file *builder_file(const file_builder *builder, const io_format *format) {
    planish_file *file;
    planish_error error = {.text = ""};
    if (builder_read(builder, format, 1, &file, &error))
        fail_msg("%s", error.text);
    return file;
}

void builder_expect_error(const file_builder *builder, const io_format *format, const char *part) {
    planish_file *file;
    planish_error error;
    int status = builder_read(builder, format, 1, &file, &error);
    planish_file_close(file);
    if (status >= 0 || strstr(error.text, part) == NULL)
        fail_msg("error with \"%s\" expected, found %d \"%s\"", part, status,
                 status < 0 ? error.text : "");
    assert_null(strchr(error.text, '\n'));
}

/** Read all data of a file: the first failure for lack of memory, or 0. */
static int read_data(planish_file *file) {
    planish_data_info info;
    planish_error error = {.text = ""};
    int status = 0;
    for (int64_t i = 0; status != PLANISH_ERROR_MEMORY && planish_file_data_info(file, i, &info);
         i++) {
        planish_data data;
        status = planish_file_data(file, info.name, &data, &error);
        assert_true(status == 0 || (error.code == status && error.text[0]));
        assert_true(status == 0 || !data.values);
        planish_data_free(&data);
    }
    return status == PLANISH_ERROR_MEMORY ? status : 0;
}

void builder_try_to_break(const file_builder *builder, const io_format *format) {
    /* A long file is one of HDF5, which compares its length before anything behind that. */
    enum { EVERY = 4096, STRIDE = 29 };
    const int step = effort_step(3);
    planish_file *file;
    planish_error error;
    for (int64_t size = 0; size < builder->size; size += (size < EVERY ? 1 : STRIDE) * step) {
        file_builder cut = *builder;
        cut.size = size;
        cut.data = malloc((size_t)size + (size == 0));
        assert_non_null(cut.data);
        memcpy(cut.data, builder->data, (size_t)size);
        builder_read(&cut, format, 1, &file, &error);
        read_data(file);
        planish_file_close(file);
        free(cut.data);
    }
    builder_let_allocations_fail(builder, format);
}

void builder_let_allocations_fail(const file_builder *builder, const io_format *format) {
    planish_file *file;
    planish_error error;
    int status = PLANISH_ERROR_MEMORY;
    for (int permitted = 0; status == PLANISH_ERROR_MEMORY; permitted += effort_step(3)) {
        allocations_permit(permitted);
        status = builder_read(builder, format, 1, &file, &error);
        if (!status)
            status = read_data(file);
        allocations_permit(-1);
        planish_file_close(file);
    }
    assert_int_equal(status, 0);
}

static void expect_same_cells(const io_cells *a, const io_cells *b, int dim) {
    assert_int_equal(a->n, b->n);
    size_t n = (size_t)a->n;
    if (n == 0)
        return;
    assert_memory_equal(a->nodes, b->nodes, n * (size_t)(dim + 1) * sizeof *a->nodes);
    assert_int_equal(a->mid == NULL, b->mid == NULL);
    if (a->mid != NULL)
        assert_memory_equal(a->mid, b->mid, n * (size_t)(dim * (dim + 1) / 2) * sizeof *a->mid);
    assert_int_equal(a->entity == NULL, b->entity == NULL);
    if (a->entity != NULL)
        assert_memory_equal(a->entity, b->entity, n * sizeof *a->entity);
    assert_int_equal(a->region == NULL, b->region == NULL);
    if (a->region != NULL)
        assert_memory_equal(a->region, b->region, n * sizeof *a->region);
    assert_int_equal(a->number == NULL, b->number == NULL);
    if (a->number != NULL)
        assert_memory_equal(a->number, b->number, n * sizeof *a->number);
    assert_int_equal(a->first_number, b->first_number);
}

/** Check that others are the same in both. */
static void expect_same_others(const io_others *a, const io_others *b) {
    assert_int_equal(a->n, b->n);
    if (a->n == 0)
        return;
    const size_t n = (size_t)a->n, n_nodes = (size_t)a->n_nodes;
    assert_memory_equal(a->type, b->type, n);
    assert_memory_equal(a->number, b->number, n * sizeof *a->number);
    assert_memory_equal(a->offset, b->offset, (n + 1) * sizeof *a->offset);
    assert_memory_equal(a->node, b->node, n_nodes * sizeof *a->node);
    assert_int_equal(a->entity == NULL, b->entity == NULL);
    if (a->entity)
        assert_memory_equal(a->entity, b->entity, n * sizeof *a->entity);
}

void builder_expect_same_on_threads(const file_builder *builder, const io_format *format) {
    planish_file *one, *three;
    planish_error error;
    assert_int_equal(builder_read(builder, format, 1, &one, &error), 0);
    assert_int_equal(builder_read(builder, format, 3, &three, &error), 0);
    const io_model *a = &one->model, *b = &three->model;
    assert_int_equal(a->n_nodes, b->n_nodes);
    assert_int_equal(a->dim, b->dim);
    assert_int_equal(a->n_lower, b->n_lower);
    size_t n = (size_t)a->n_nodes;
    assert_memory_equal(a->coordinates, b->coordinates, n * (size_t)a->dim * sizeof(double));
    assert_memory_equal(a->hold, b->hold, n);
    if (a->text_offset != NULL)
        assert_memory_equal(a->text_offset, b->text_offset, n * sizeof *a->text_offset);
    assert_int_equal(a->node_number == NULL, b->node_number == NULL);
    if (a->node_number != NULL)
        assert_memory_equal(a->node_number, b->node_number, n * sizeof *a->node_number);
    expect_same_cells(&a->line, &b->line, 1);
    expect_same_cells(&a->triangle, &b->triangle, 2);
    expect_same_cells(&a->tetrahedron, &b->tetrahedron, 3);
    assert_int_equal(a->n_other, b->n_other);
    expect_same_others(&a->flat, &b->flat);
    expect_same_others(&a->solid, &b->solid);
    assert_int_equal(a->n_entities, b->n_entities);
    planish_file_close(one);
    planish_file_close(three);
}
