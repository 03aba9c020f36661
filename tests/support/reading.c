/* reading: mesh files from memory, for tests of readers. */
#include "support/reading.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

planish_file *reading_text(const io_format *format, const char *text) {
    planish_file *file = NULL;
    planish_error error = {.text = ""};
    int status = io_file_from_memory(format, "test", text, (int64_t)strlen(text), 1, &file, &error);
    if (status)
        print_error("%s\n", error.text);
    assert_int_equal(status, 0);
    return file;
}

void reading_fails(const io_format *format, const char *text, const char *word) {
    planish_file *file = NULL;
    planish_error error = {.text = ""};
    int status = io_file_from_memory(format, "test", text, (int64_t)strlen(text), 1, &file, &error);
    planish_file_close(file);
    assert_true(status < 0);
    if (!strstr(error.text, word))
        print_error("'%s' is not in: %s\n", word, error.text);
    assert_non_null(strstr(error.text, word));
    assert_null(strchr(error.text, '\n'));
}

void reading_gives_surface(const io_format *format, const char *text) {
    planish_file *file;
    planish_error error;
    if (io_file_from_memory(format, "test", text, (int64_t)strlen(text), 1, &file, &error))
        fail_msg("%s", error.text);
    const planish_mesh mesh = planish_file_mesh(file);
    assert_int_equal(mesh.dim, 3);
    assert_non_null(mesh.cells);
    assert_null(mesh.elements);
    assert_int_equal(planish_file_plane(file, NULL), 0);
    for (int64_t i = 0; i < mesh.n_elements; i++)
        assert_true(mesh.cells->type[i] == PLANISH_CELL_TRIANGLE ||
                    mesh.cells->type[i] == PLANISH_CELL_QUADRILATERAL);
    planish_file_close(file);
}

void reading_gave_four(const planish_mesh *mesh) {
    static const double xyz[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, .25, .25, .25};
    static const int32_t elements[] = {0, 1, 2, 4, 0, 1, 3, 4, 0, 2, 3, 4, 1, 2, 3, 4};
    assert_int_equal(mesh->dim, 3);
    assert_int_equal(mesh->n_nodes, 5);
    assert_int_equal(mesh->n_elements, 4);
    assert_memory_equal(mesh->coordinates, xyz, sizeof xyz);
    assert_memory_equal(mesh->elements, elements, sizeof elements);
}

void reading_every_beginning(const io_format *format, const char *data, int64_t size) {
    for (int64_t length = 0; length <= size; length++) {
        planish_file *file = NULL;
        planish_error error = {.text = ""};
        char *copy = malloc(length ? (size_t)length : 1);
        memcpy(copy, data, (size_t)length);
        int status = io_file_from_memory(format, "test", copy, length, 1, &file, &error);
        assert_true(status ? error.text[0] != '\0' : file != NULL);
        planish_file_close(file);
        free(copy);
    }
}

int reading_knows_vtu(void) {
    static const char text[] = "<VTKFile>";
    planish_file *file = NULL;
    planish_error error = {.text = ""};
    assert_int_not_equal(
        io_file_from_memory(&io_format_vtu, "test", text, (int64_t)strlen(text), 1, &file, &error),
        0);
    return strstr(error.text, "libexpat1-dev") == NULL;
}
