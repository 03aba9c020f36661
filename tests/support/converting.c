/* converting: meshes that are converted to other formats, for tests. */
#include "support/converting.h"

#include "support/files.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

planish_file *converting_open(const char *path) {
    planish_file *file = NULL;
    planish_error error = {.text = ""};
    if (planish_file_open(path, NULL, 1, &file, &error))
        fail_msg("%s", error.text);
    return file;
}

planish_file *converting_open_built(const char *folder, const char *name, file_builder *b) {
    char path[TEST_PATH_SIZE];
    test_write(folder, name, b->data, (size_t)b->size);
    builder_release(b);
    return converting_open(test_path(path, folder, name));
}

planish_file *converting_to(const char *folder, planish_file *file, const char *name,
                            const char *extension, char lost[512]) {
    char path[TEST_PATH_SIZE], base[64];
    planish_error error = {.text = ""};
    const planish_convert_options data = {.format = name, .lost = lost, .lost_size = 512};
    snprintf(base, sizeof base, "out-%s%s", name, extension);
    test_path(path, folder, base);
    if (planish_file_convert(file, path, planish_file_mesh(file).coordinates, &data, &error))
        fail_msg("%s", error.text);
    return converting_open(path);
}

uint8_t *converting_nodes_of(const planish_file *file, const char *tag) {
    const planish_hold hold = {.tags = &tag, .n_tags = 1};
    const int64_t n = planish_file_mesh(file).n_nodes;
    planish_error error = {.text = ""};
    uint8_t *reason = calloc((size_t)n + 1, 1);
    assert_non_null(reason);
    if (planish_file_get_held(file, &hold, reason, &error))
        fail_msg("%s", error.text);
    for (int64_t i = 0; i < n; i++)
        reason[i] = (reason[i] & PLANISH_FILE_FIX) != 0;
    return reason;
}
