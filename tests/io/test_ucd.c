/* Tests of telling files of AVS UCD from others, which are read. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "io/core/format.h"

/** The text in memory of its own size, so that a sanitizer sees any look behind its end. */
static int is_ucd(const char *text) {
    const size_t size = strlen(text);
    char *copy = malloc(size ? size : 1);
    assert_non_null(copy);
    memcpy(copy, text, size);
    const int is = io_is_ucd(copy, (int64_t)size);
    free(copy);
    return is;
}

static void ucd_is_told(void **state) {
    (void)state;
    assert_true(is_ucd("3 1 0 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n1 0 tri 1 2 3\n"));
    assert_true(is_ucd("# a comment\n# another\n3 1 0 1 0\r\n1 0 0 0\r\n2 1 0 0\r\n3 0 1 0\r\n"
                       "1 5 tri 1 2 3\r\n"));
    assert_true(is_ucd("  1  1 2 0 0\n 0 1e-3 0 0\n 1 1 hex 1 1 1 1 1 1 1 1"));
}

static void others_are_not(void **state) {
    (void)state;
    static const char *const texts[] = {
        "",
        "3 1 0 0 0",
        "3 1 0 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n",
        "3 1 0 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n1 0 tria 1 2 3\n",
        "3 1 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n1 0 tri 1 2 3\n", /* four counts: TetGen's */
        "3 1 0 0 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n1 0 tri 1 2 3\n",
        "3 -1 0 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n1 0 tri 1 2 3\n",
        "9223372036854775807 1 0 0 0\n1 0 0 0\n1 0 tri 1 1 1\n",
        "*NODE\n1, 0, 0, 0\n",
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        assert_false(is_ucd(texts[i]));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ucd_is_told),
        cmocka_unit_test(others_are_not),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
