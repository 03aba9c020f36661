/* data_reading: what tests of arrays of numbers expect. */
#include "support/data_reading.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

void expect_data(planish_file *file, const char *name, int of_elements, int n_components,
                 data_value_fn *value) {
    planish_data data;
    planish_error error = {.text = ""};
    planish_cells cells;
    if (planish_file_data(file, name, &data, &error))
        fail_msg("%s", error.text);
    assert_int_equal(planish_file_cells(file, &cells, NULL), 0);
    assert_int_equal(data.of_elements, of_elements);
    assert_int_equal(data.n_components, n_components);
    assert_int_equal(data.n, of_elements ? cells.n : planish_file_mesh(file).n_nodes);
    for (int64_t i = 0; i < data.n; i++) {
        const int64_t number =
            of_elements ? planish_file_element_number(file, i) : planish_file_node_number(file, i);
        for (int k = 0; k < n_components; k++)
            assert_true(data.values[i * n_components + k] == value(number, k));
    }
    planish_data_free(&data);
    assert_null(data.values);
}

void expect_no_data(planish_file *file, const char *name, int code, const char *part) {
    planish_data data;
    planish_error error = {.text = ""};
    assert_int_equal(planish_file_data(file, name, &data, &error), code);
    assert_int_equal(error.code, code);
    assert_null(data.values);
    if (!strstr(error.text, part))
        fail_msg("'%s' is not in: %s", part, error.text);
    assert_null(strchr(error.text, '\n'));
}

void expect_data_list(const planish_file *file, const char *expected) {
    char text[512] = "";
    planish_data_info info;
    for (int64_t i = 0; planish_file_data_info(file, i, &info); i++) {
        const size_t used = strlen(text);
        snprintf(text + used, sizeof text - used, "%s%s%s:%d", i ? " " : "",
                 info.of_elements ? "*" : "", info.name, info.n_components);
    }
    assert_string_equal(text, expected);
}
