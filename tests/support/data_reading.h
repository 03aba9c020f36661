/* data_reading: what tests of arrays of numbers expect (planish_file_data). */
#ifndef TEST_SUPPORT_DATA_READING_H
#define TEST_SUPPORT_DATA_READING_H

#include <planish/planish_io.h>

/** Value k of the node or element that has that number in the file. */
typedef double data_value_fn(int64_t number, int k);

/** Expect an array with these values. */
void expect_data(planish_file *file, const char *name, int of_elements, int n_components,
                 data_value_fn *value);

/** Expect an error with that code, and with part in its text. */
void expect_no_data(planish_file *file, const char *name, int code, const char *part);

/** Expect these arrays: names, of nodes or (behind a '*') elements, and numbers of a value, apart by
 *  blanks. */
void expect_data_list(const planish_file *file, const char *expected);

#endif
