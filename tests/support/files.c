/* files: a folder of files for a test, removed afterwards. */
#include "support/files.h"

#include <dirent.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

int test_folder_create(void **state) {
    char pattern[] = "/tmp/planish-test-XXXXXX";
    *state = mkdtemp(pattern) ? strdup(pattern) : NULL;
    return *state ? 0 : -1;
}

/** Call visit (may be NULL) for the path of every file in folder; returns their number. */
static int each_file(const char *folder, int (*visit)(const char *path)) {
    char path[TEST_PATH_SIZE];
    int count = 0;
    DIR *list = opendir(folder);
    assert_non_null(list);
    for (struct dirent *entry = readdir(list); entry; entry = readdir(list)) {
        if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0)
            continue;
        count++;
        if (visit)
            visit(test_path(path, folder, entry->d_name));
    }
    closedir(list);
    return count;
}

/** Remove a file, or a folder with all that is in it. */
static int remove_all(const char *path) {
    if (unlink(path) == 0)
        return 0;
    each_file(path, remove_all);
    return rmdir(path);
}

int test_folder_remove(void **state) {
    int failed = remove_all(*state);
    free(*state);
    return failed;
}

int test_count_files(const char *folder) {
    return each_file(folder, NULL);
}

const char *test_path(char *text, const char *folder, const char *name) {
    int length = snprintf(text, TEST_PATH_SIZE, "%s/%s", folder, name);
    assert_in_range(length, 1, TEST_PATH_SIZE - 1);
    return text;
}

const char *test_folder_in(char *text, const char *folder, const char *name) {
    assert_int_equal(mkdir(test_path(text, folder, name), 0777), 0);
    return text;
}

void test_write(const char *folder, const char *name, const char *data, size_t size) {
    char path[TEST_PATH_SIZE];
    FILE *file = fopen(test_path(path, folder, name), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

char *test_read(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    size_t length = 0, capacity = 1 << 16;
    char *data = malloc(capacity + 1);
    assert_non_null(data);
    for (size_t got = 1; got > 0; length += got) {
        if (length == capacity) {
            capacity *= 2;
            data = realloc(data, capacity + 1);
            assert_non_null(data);
        }
        got = fread(data + length, 1, capacity - length, file);
    }
    fclose(file);
    data[length] = '\0';
    if (size)
        *size = length;
    return data;
}

const char *test_path_from(char *text, const char *variable, const char *name) {
    const char *folder = getenv(variable);
    if (!folder)
        skip();
    return test_path(text, folder, name);
}
