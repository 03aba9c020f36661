/* foam_list: lists of numbers: text, or binary in a row; lists of entries.
 *
 *   foam_begin_list, _end_list             any list
 *   foam_labels, foam_label_set, foam_read_points, foam_field    numbers
 *   foam_begin_entries, foam_next_entry    NAME { ... }
 */
#ifndef PL_IO_FOAM_FOAM_LIST_H
#define PL_IO_FOAM_FOAM_LIST_H

#include "io/foam/foam_file.h"

/** Take the number of items of a list and its '('. Check that size bytes are left for each item
 *  behind it (in text, with blanks between numbers, for 2 items). An empty list ends with this. */
int foam_begin_list(foam_file *f, const char *what, int64_t size, int64_t *n, planish_error *error);

/** Take the ')' of a list. */
int foam_end_list(foam_file *f, const char *what, planish_error *error);

/** Read a list of labels, each one of first .. last: *labels [n] is owned. */
int foam_labels(foam_file *f, const char *what, int64_t first, int64_t last, int32_t **labels,
                int64_t *n, planish_error *error);

/** Read a list of labels of which each counts once: of equal labels, which take a few bytes of a file
 *  however many they are (65536{0}), there is one in *labels. */
int foam_label_set(foam_file *f, const char *what, int64_t first, int64_t last, int32_t **labels,
                   int64_t *n, planish_error *error);

/** Read the points of the mesh, its nodes, from the model's input. */
int foam_read_points(io_model *model, planish_error *error);

/** Find a coordinate in text: io_format.field. */
int foam_field(const io_model *model, io_cursor *cursor, int d, io_field *field);

/** Begin a list of entries, NAME { ... }, behind its number, if it has one: *n is that, or -1. */
int foam_begin_entries(foam_file *f, const char *what, int64_t *n, planish_error *error);

/** Take the name of entry i of such a list. Return 1, 0: the list has ended, or a negative status. */
int foam_next_entry(foam_file *f, const char *what, int64_t n, int64_t i, io_slice *name,
                    planish_error *error);

#endif
