/* The list of formats: its names are those of the readers, and tests have a file of each. */
#include "support/data_files.h"
#include "support/files.h"

#include "io/file/file.h"

#include <planish/planish_io.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/** Number of names before the i-th that are the same as that. */
static int count_earlier(const char *const *names, int i) {
    int n = 0;
    for (int k = 0; k < i; k++)
        n += strcmp(names[k], names[i]) == 0;
    return n;
}

static void each_name_is_of_one_format(void **state) {
    (void)state;
    const char *const *names = planish_file_formats();
    for (int i = 0; names[i]; i++) {
        const io_format *format = io_format_by_name(names[i]);
        assert_non_null(format);
        assert_string_equal(format->name, names[i]);
        assert_int_equal(count_earlier(names, i), 0);
        for (const char *const *dot = format->extensions; *dot; dot++)
            assert_int_equal(**dot, '.');
    }
}

static void each_format_has_a_file_in_the_data(void **state) {
    (void)state;
    for (const char *const *name = planish_file_formats(); *name; name++) {
        int n = 0;
        for (const test_data_file *data = test_data_files; data->name; data++)
            n += strcmp(data->format, *name) == 0;
        if (n == 0)
            fail_msg("tests/support/data_files.c has no file of the format %s", *name);
    }
}

/** TetGen's tables of numbers are recognised by their names alone. */
static void each_file_of_the_data_is_recognised_by_its_content(void **state) {
    (void)state;
    for (const test_data_file *data = test_data_files; data->name; data++) {
        char path[TEST_PATH_SIZE];
        size_t size;
        if (!test_data_path(path, data))
            continue;
        char *bytes = test_read(path, &size);
        const char *name = strcmp(data->format, "tetgen") == 0 ? data->name : "name";
        const io_format *format = io_format_find(name, bytes, (int64_t)size);
        if (!format || strcmp(format->name, data->format) != 0)
            fail_msg("%s is read as %s", data->name, format ? format->name : "no format");
        free(bytes);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_name_is_of_one_format),
        cmocka_unit_test(each_format_has_a_file_in_the_data),
        cmocka_unit_test(each_file_of_the_data_is_recognised_by_its_content),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
