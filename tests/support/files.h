/* files: a folder of files for a test, removed afterwards. */
#ifndef TEST_SUPPORT_FILES_H
#define TEST_SUPPORT_FILES_H

#include <stddef.h>

enum { TEST_PATH_SIZE = 512 };

/** Make an empty folder; setup and teardown of cmocka: *state is its path. */
int test_folder_create(void **state);
int test_folder_remove(void **state);

/** Path of name in folder, in text [TEST_PATH_SIZE]; returns text. */
const char *test_path(char *text, const char *folder, const char *name);

/** Make a folder called name in folder; its path, in text [TEST_PATH_SIZE]. */
const char *test_folder_in(char *text, const char *folder, const char *name);

/** Write size bytes to name in folder. */
void test_write(const char *folder, const char *name, const char *data, size_t size);

/** The content of the file at path, a '\0' behind it, to be freed; *size (may be NULL) without. */
char *test_read(const char *path, size_t *size);

/** Number of files and folders in folder. */
int test_count_files(const char *folder);

/** Path of name in the folder of the environment's variable, in text; skips the test if the
 *  variable is unset. */
const char *test_path_from(char *text, const char *variable, const char *name);

#endif
