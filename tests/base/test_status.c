/* Messages: what does not fit is left out of their middle, for what is wrong stands at the end. */
#include "base/status.h"

#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void long_paths_leave_room_for_the_reason(void **state) {
    enum { LONGEST = 5000 };
    (void)state;
    char *path = malloc(LONGEST + 1);
    for (int length = 380; length <= LONGEST; length += length < 600 ? 1 : 97) {
        planish_error error;
        memset(path, 'x', (size_t)length);
        memcpy(path, "begin/", 6);
        path[length] = '\0';
        errno = EACCES;
        assert_int_equal(pl_fail_errno(&error, path, "cannot be opened"), PLANISH_ERROR_FILE);
        assert_true(strlen(error.text) < sizeof error.text);
        assert_memory_equal(error.text, "begin/", 6);
        const char *reason = strstr(error.text, "x: cannot be opened: ");
        assert_non_null(reason);
        assert_string_equal(reason + strlen("x: cannot be opened: "), strerror(EACCES));
        if (length > 500)
            assert_non_null(strstr(error.text, " ... "));
    }
    free(path);
}

/** No character of UTF-8 is cut in two. */
static void characters_stay_whole(void **state) {
    char path[2000];
    (void)state;
    for (int shift = 0; shift < 3; shift++) {
        planish_error error;
        int n = 0;
        while (n < shift)
            path[n++] = 'x';
        while (n < 1900) {
            memcpy(path + n, "\xe2\x82\xac", 3);
            n += 3;
        }
        path[n] = '\0';
        pl_fail(&error, PLANISH_ERROR_FILE, "%s: no", path);
        const char *at = error.text + shift;
        while (strncmp(at, "\xe2\x82\xac", 3) == 0)
            at += 3;
        assert_memory_equal(at, " ... ", 5);
        at += 5;
        while (strncmp(at, "\xe2\x82\xac", 3) == 0)
            at += 3;
        assert_string_equal(at, ": no");
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(long_paths_leave_room_for_the_reason),
        cmocka_unit_test(characters_stay_whole),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
