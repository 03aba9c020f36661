/* rewriting: what is written of a mesh file, for tests of readers. */
#include "io/core/format.h"
#include "support/rewriting.h"

#include "io/core/text.h"
#include "support/files.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static planish_file *read_bytes(const io_format *format, const char *data, int64_t size) {
    planish_file *file = NULL;
    planish_error error = {.text = ""};
    if (io_file_from_memory(format, "test", data, size, 1, &file, &error))
        fail_msg("%s", error.text);
    return file;
}

/** What is written with these coordinates; to be freed. */
static char *write_bytes(const planish_file *file, const double *coordinates, const char *folder,
                         int64_t *size) {
    char path[TEST_PATH_SIZE], name[64];
    planish_error error;
    size_t written;
    snprintf(name, sizeof name, "written%s", file->format->extensions[0]);
    if (!planish_file_can_write(file, test_path(path, folder, name))) { /* Medit in binary */
        snprintf(name, sizeof name, "written%s", file->format->extensions[1]);
        test_path(path, folder, name);
    }
    if (planish_file_write(file, path, coordinates, &(planish_write_options){.threads = 1}, &error))
        fail_msg("%s", error.text);
    char *data = test_read(path, &written);
    unlink(path);
    *size = (int64_t)written;
    return data;
}

/** Every other coordinate, with values that floats have and that are longer and shorter as text. */
static double *move_some(const planish_file *file) {
    planish_mesh mesh = planish_file_mesh(file);
    const int64_t n = mesh.n_nodes * mesh.dim;
    double *moved = malloc(((size_t)n + 1) * sizeof *moved);
    assert_non_null(moved);
    for (int64_t i = 0; i < n; i++)
        moved[i] = i % 2 ? mesh.coordinates[i] : (double)(i % 7) + (i % 4 ? 0.000244140625 : 0);
    return moved;
}

/** The number of coordinates that may move where a node of the span stands. */
static int coordinates_at(const io_model *model, const io_span *span) {
    const int n = model->dim - span->component;
    return span->n_components > 0 && span->n_components < n ? span->n_components : n;
}

/** The file without the coordinates that may move; to be freed. */
static char *cut_coordinates(const io_model *model, int64_t *size) {
    const char *at = model->input.data, *end = at + model->input.size;
    char *rest = malloc((size_t)model->input.size + 1), *to = rest;
    assert_non_null(rest);
    for (int64_t s = 0; s < model->n_spans; s++) {
        const io_span *span = &model->span[s];
        const int width = span->encoding == IO_FLOAT32 ? 4 : 8;
        for (int64_t i = 0; i < span->n_nodes; i++) {
            const int is_text = span->encoding == IO_TEXT;
            io_cursor cursor = {model->input.data +
                                    (is_text ? io_text_place(model, span, span->first_node + i)
                                             : span->offset + i * span->stride),
                                end};
            const int n = coordinates_at(model, span);
            for (int d = 0; d < n; d++) {
                if (is_text)
                    io_skip_space_comments(&cursor, '#');
                memcpy(to, at, (size_t)(cursor.at - at));
                to += cursor.at - at;
                if (is_text)
                    io_next_word(&cursor);
                else
                    cursor.at += width;
                at = cursor.at;
            }
        }
    }
    memcpy(to, at, (size_t)(end - at));
    *size = to - rest + (end - at);
    return rest;
}

static void expect_same_rest(const io_model *a, const io_model *b) {
    int64_t size, other_size;
    char *rest = cut_coordinates(a, &size), *other = cut_coordinates(b, &other_size);
    assert_int_equal(size, other_size);
    assert_true(size < a->input.size);
    assert_memory_equal(rest, other, (size_t)size);
    free(rest);
    free(other);
}

void rewriting_keeps_the_rest(const io_format *format, const char *data, int64_t size,
                              const char *folder) {
    planish_file *file = read_bytes(format, data, size);
    planish_mesh mesh = planish_file_mesh(file);
    const size_t bytes = (size_t)(mesh.n_nodes * mesh.dim) * sizeof(double);
    int64_t same_size, moved_size;
    char *same = write_bytes(file, mesh.coordinates, folder, &same_size);
    assert_int_equal(same_size, size);
    assert_memory_equal(same, data, (size_t)size);
    double *coordinates = move_some(file);
    char *moved = write_bytes(file, coordinates, folder, &moved_size);
    planish_file *again = read_bytes(format, moved, moved_size);
    assert_int_equal(again->model.dim, mesh.dim);
    assert_int_equal(again->model.n_nodes, mesh.n_nodes);
    assert_memory_not_equal(moved, data, (size_t)(moved_size < size ? moved_size : size));
    assert_memory_equal(again->model.coordinates, coordinates, bytes);
    expect_same_rest(&file->model, &again->model);
    planish_file_close(again);
    planish_file_close(file);
    free(coordinates);
    free(same);
    free(moved);
}

static int64_t count_changes(const char *a, const char *b, int64_t size) {
    int64_t changes = 0;
    for (int64_t i = 0; i < size; i++)
        changes += a[i] != b[i];
    return changes;
}

void rewriting_in_place(const char *data, int64_t size, int is_packed, const char *folder,
                        const char *name) {
    enum { FIRST = 2, SECOND = 12 };
    char path[TEST_PATH_SIZE];
    planish_error error = {.text = ""};
    planish_file *file, *again;
    int64_t written;
    test_write(folder, name, data, (size_t)size);
    if (planish_file_open(test_path(path, folder, name), NULL, 1, &file, &error))
        fail_msg("%s", error.text);
    double *xyz = planish_file_coordinates(file);
    char *content = write_bytes(file, xyz, folder, &written);
    assert_int_equal(written, size);
    assert_memory_equal(content, data, (size_t)size);
    free(content);
    xyz[FIRST] = 8;
    xyz[SECOND] = -3;
    content = write_bytes(file, xyz, folder, &written);
    if (!is_packed) {
        assert_int_equal(written, size);
        assert_in_range(count_changes(content, data, size), 2, 2 * sizeof(double));
    }
    again = read_bytes(file->format, content, written);
    const planish_mesh mesh = planish_file_mesh(file);
    assert_memory_equal(planish_file_coordinates(again), xyz,
                        (size_t)(mesh.n_nodes * mesh.dim) * sizeof *xyz);
    free(content);
    planish_file_close(again);
    planish_file_close(file);
}

void rewriting_gives(const io_format *format, const char *text, const char *move,
                     const char *expected, const char *folder) {
    static const double moved[] = {0.125, -1.0 / 3, 123456.789};
    planish_file_info info;
    int64_t size;
    planish_file *file = read_bytes(format, text, (int64_t)strlen(text));
    planish_file_get_info(file, &info);
    double *coordinates = planish_file_coordinates(file);
    for (int d = 0; d < 3; d++)
        if (strchr(move, "xyz"[d]))
            coordinates[d] = info.precision == PLANISH_PRECISION_ROUNDED
                                 ? info.round(moved[d], info.round_user)
                                 : moved[d];
    char *written = write_bytes(file, coordinates, folder, &size);
    assert_string_equal(written, expected);
    free(written);
    planish_file *again = read_bytes(format, expected, (int64_t)strlen(expected));
    const planish_mesh mesh = planish_file_mesh(file);
    assert_memory_equal(planish_file_coordinates(again), coordinates,
                        (size_t)(mesh.n_nodes * mesh.dim) * sizeof *coordinates);
    planish_file_close(again);
    planish_file_close(file);
}
