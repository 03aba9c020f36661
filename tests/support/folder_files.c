/* folder_files: mesh files in a folder, for tests of readers that open files by their names. */
#include "support/folder_files.h"

#include "support/files.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

void folder_write(const char *folder, const char *name, const char *text) {
    test_write(folder, name, text, strlen(text));
}

planish_file *folder_open(const char *folder, const char *name) {
    char path[TEST_PATH_SIZE];
    planish_file *file = NULL;
    planish_error error = {.text = ""};
    if (planish_file_open_with(test_path(path, folder, name),
                               &(planish_open_options){.threads = 1, .isolated = 1}, &file, &error))
        fail_msg("%s", error.text);
    return file;
}

void folder_open_fails(const char *folder, const char *name, const char *word) {
    char path[TEST_PATH_SIZE];
    test_path(path, folder, name);
    for (int is_isolated = 0; is_isolated < 2; is_isolated++) {
        planish_file *file = NULL;
        planish_error error = {.text = ""};
        const int status =
            is_isolated
                ? planish_file_open_with(path, &(planish_open_options){.threads = 1, .isolated = 1},
                                         &file, &error)
                : planish_file_open(path, NULL, 1, &file, &error);
        assert_int_not_equal(status, 0);
        if (!strstr(error.text, word) || strchr(error.text, '\n'))
            fail_msg("one line with '%s' was expected: %s", word, error.text);
    }
}
