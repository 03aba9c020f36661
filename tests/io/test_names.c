/* Lists of names for messages: each once, in their order, and not so many that a search takes long. */
#include "io/core/names.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void add(io_names *names, const char *text) {
    assert_true(io_names_add(names, text, (int64_t)strlen(text)));
}

static void each_is_there_once(void **state) {
    (void)state;
    io_names names = {.n = 0};
    assert_null(io_names_list(&names)[0]);
    add(&names, "*STEP");
    add(&names, "*STEP 2");
    add(&names, "*STEP");
    assert_int_equal(names.n, 2);
    const char *const *list = io_names_list(&names);
    assert_string_equal(list[0], "*STEP");
    assert_string_equal(list[1], "*STEP 2");
    assert_null(list[2]);
    io_names_release(&names);
}

/** A name of a file may have zeros in it: what is behind the first is not looked at. */
static void zeros_end_names(void **state) {
    (void)state;
    enum { LENGTH = 64 << 20 };
    io_names names = {.n = 0};
    char *text = calloc(LENGTH, 1);
    assert_non_null(text);
    memcpy(text, "ab", 2);
    add(&names, "ab");
    assert_true(io_names_add(&names, text, LENGTH));
    assert_true(io_names_add(&names, text, 3));
    assert_int_equal(names.n, 1);
    text[0] = 'c';
    assert_true(io_names_add(&names, text, LENGTH));
    assert_int_equal(names.n, 2);
    assert_string_equal(io_names_list(&names)[1], "cb");
    io_names_release(&names);
    free(text);
}

static void there_is_a_most(void **state) {
    (void)state;
    io_names names = {.n = 0};
    char text[32];
    for (int i = 0; i < IO_MOST_NAMES + 5; i++) {
        snprintf(text, sizeof text, "name %d", i);
        add(&names, text);
    }
    assert_int_equal(names.n, IO_MOST_NAMES);
    assert_string_equal(io_names_list(&names)[IO_MOST_NAMES - 1], "name 999");
    io_names_release(&names);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_is_there_once),
        cmocka_unit_test(zeros_end_names),
        cmocka_unit_test(there_is_a_most),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
