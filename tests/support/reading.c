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

void reading_refuses(const io_format *format, const reading_refusal *cases, size_t n) {
    for (size_t i = 0; i < n; i++)
        reading_fails(format, cases[i].text, cases[i].word);
}

void reading_tells(const io_format *format, const char *const *texts, size_t n, int is_told) {
    for (size_t i = 0; i < n; i++) {
        const size_t size = strlen(texts[i]);
        char *copy = malloc(size ? size : 1); /* so that a sanitizer sees any look behind */
        assert_non_null(copy);
        memcpy(copy, texts[i], size);
        if (!format->recognise(copy, (int64_t)size) != !is_told)
            fail_msg("%s: told: %d, expected: %d", texts[i], !is_told, is_told);
        free(copy);
    }
}

void reading_gave(const planish_file *file, const io_format *format, const reading_facts *facts) {
    const planish_mesh mesh = planish_file_mesh(file);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_string_equal(info.format, format->name);
    assert_int_equal(mesh.dim, facts->dim);
    assert_int_equal(mesh.n_nodes, facts->n_nodes);
    assert_int_equal(mesh.n_elements, facts->n_elements);
    assert_int_equal(info.n_regions, facts->n_regions);
    assert_int_equal(info.n_other_elements, facts->n_other);
    assert_int_equal(info.n_lower_elements, facts->n_lower);
    assert_int_equal(info.precision, facts->precision);
}

int reading_tag(const planish_file *file, const int32_t *entity, int64_t i) {
    return file->model.entity[entity[i]].tag;
}

void reading_group_is(const planish_file *file, int i, const char *name, int dim, int tag) {
    const io_group *group = &file->model.group[i];
    assert_string_equal(group->name, name);
    assert_int_equal(group->dim, dim);
    assert_int_equal(group->tag, tag);
}

void reading_holds(const planish_file *file, const char *tag, unsigned how, const char *expected) {
    const int64_t n = planish_file_mesh(file).n_nodes;
    uint8_t *constraint = malloc((size_t)n + 1);
    char *found = calloc((size_t)n + 1, 1);
    planish_error error = {.text = ""};
    const planish_hold hold = {.tags = &tag,
                               .n_tags = tag != NULL,
                               .ignore_regions = !(how & READING_REGIONS),
                               .slide = (how & READING_SLIDE) != 0};
    assert_true(constraint && found);
    if (planish_file_constraints(file, &hold, constraint, &error))
        fail_msg("%s", error.text);
    for (int64_t i = 0; i < n; i++)
        found[i] = (char)('0' + constraint[i]);
    assert_string_equal(found, expected);
    free(constraint);
    free(found);
}

void reading_text_holds(const io_format *format, const char *text, const char *tag, unsigned how,
                        const char *expected) {
    planish_file *file = reading_text(format, text);
    reading_holds(file, tag, how, expected);
    planish_file_close(file);
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
