/* Arguments of planish_io.h that are refused whatever the file is. */
#include "support/data_files.h"
#include "support/files.h"

#include <planish/planish_io.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/** Set the last reserved field of a structure. */
#define SPOIL_RESERVED(s) memset((unsigned char *)(s)->reserved + sizeof(s)->reserved - 1, 1, 1)

static void expect_refusal(int status, const planish_error *error, const char *word) {
    assert_int_equal(status, PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error->text, word));
}

/** What cannot be opened leaves no file behind. */
static void no_file_is_null(void **state) {
    (void)state;
    planish_file *file = (planish_file *)&state;
    assert_int_equal(planish_file_open("nowhere", NULL, 1, &file, NULL), PLANISH_ERROR_FILE);
    assert_null(file);
    file = (planish_file *)&state;
    assert_int_equal(planish_file_open(NULL, NULL, 1, &file, NULL), PLANISH_ERROR_ARGUMENT);
    assert_null(file);
    planish_file_close(file);
}

/** What is not 0 in a reserved field is refused: a later version may give it a meaning. */
static void reserved_fields_are_refused(void **state) {
    (void)state;
    char path[TEST_PATH_SIZE];
    planish_open_options how = {.threads = 1};
    planish_hold hold = {.n_tags = 0};
    planish_convert_options conversion = {.format = "vtu"};
    planish_write_options writing = {.threads = 1};
    planish_file *file;
    planish_error error;
    assert_true(test_data_path(path, &(test_data_file){"medit.mesh", "medit", 1}));
    assert_int_equal(planish_file_open_with(path, &how, &file, NULL), 0);
    const double *x = planish_file_coordinates(file);
    uint8_t *flag = malloc((size_t)planish_file_mesh(file).n_nodes);
    assert_int_equal(planish_file_constraints(file, &hold, flag, NULL), 0);
    assert_int_equal(planish_file_get_held(file, &hold, flag, NULL), 0);
    SPOIL_RESERVED(&hold);
    SPOIL_RESERVED(&conversion);
    SPOIL_RESERVED(&writing);
    expect_refusal(planish_file_constraints(file, &hold, flag, &error), &error, "planish_hold");
    expect_refusal(planish_file_get_held(file, &hold, flag, &error), &error, "planish_hold");
    expect_refusal(planish_file_convert(file, "nowhere.vtu", x, &conversion, &error), &error,
                   "planish_convert_options");
    expect_refusal(planish_file_write(file, "nowhere.mesh", x, &writing, &error), &error,
                   "planish_write_options");
    conversion = (planish_convert_options){.format = "vtu"};
    SPOIL_RESERVED(&conversion.cells);
    expect_refusal(planish_file_convert(file, "nowhere.vtu", x, &conversion, &error), &error,
                   "planish_cell_values");
    planish_file_close(file);
    free(flag);
    SPOIL_RESERVED(&how);
    expect_refusal(planish_file_open_with(path, &how, &file, &error), &error,
                   "planish_open_options");
}

static void lists_need_their_results(void **state) {
    (void)state;
    char path[TEST_PATH_SIZE];
    planish_file *file;
    planish_error error;
    const planish_group *groups;
    int64_t n = 7;
    assert_true(test_data_path(path, &(test_data_file){"medit.mesh", "medit", 1}));
    assert_int_equal(planish_file_open(path, NULL, 1, &file, NULL), 0);
    expect_refusal(planish_file_groups(file, NULL, &n, &error), &error, "groups");
    assert_int_equal(n, 0);
    expect_refusal(planish_file_groups(file, &groups, NULL, &error), &error, "groups");
    planish_file_close(file);
    expect_refusal(planish_file_groups(NULL, &groups, &n, &error), &error, "file");
}

static void the_version_is_that_of_both_libraries(void **state) {
    (void)state;
    assert_string_equal(planish_io_version(), PLANISH_VERSION);
    assert_string_equal(planish_io_version(), planish_version());
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_file_is_null),
        cmocka_unit_test(reserved_fields_are_refused),
        cmocka_unit_test(lists_need_their_results),
        cmocka_unit_test(the_version_is_that_of_both_libraries),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
