/* square: what tests of cell arrays expect of a square of SQUARE_SIDE x SQUARE_SIDE cells, whose
 * nodes are numbered row by row. */
#ifndef PL_TESTS_SQUARE_H
#define PL_TESTS_SQUARE_H

#include <planish/planish_io.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

enum { SQUARE_SIDE = 4, SQUARE_NODES = (SQUARE_SIDE + 1) * (SQUARE_SIDE + 1) };

/** Value of a cell, or triangle of one, in a column and row of the square. */
typedef double square_value_fn(int column, int row, int index);

/** Left and right half. */
static inline double square_halves(int column, int row, int index) {
    (void)row;
    (void)index;
    return column < SQUARE_SIDE / 2 ? 3 : 7;
}

/** Lower and upper half. */
static inline double square_rows(int column, int row, int index) {
    (void)column;
    (void)index;
    return row < SQUARE_SIDE / 2 ? -1 : 1;
}

/** Number of the cell. */
static inline double square_number(int column, int row, int index) {
    (void)column;
    (void)row;
    return index;
}

/** Names, NULL-terminated, are these, apart by blanks. */
static inline void expect_names(const char *const *names, const char *expected) {
    char text[256] = "";
    for (; *names; names++) {
        strcat(text, text[0] ? " " : "");
        strcat(text, *names);
    }
    assert_string_equal(text, expected);
}

/** Nodes off the boundary that are held: those of the middle column, of the middle row. */
static inline void expect_held_with(const planish_file *file, const planish_hold *hold, int column,
                                    int row) {
    uint8_t constraint[SQUARE_NODES];
    assert_int_equal(planish_file_constraints(file, hold, constraint, NULL), PLANISH_OK);
    for (int y = 1; y < SQUARE_SIDE; y++)
        for (int x = 1; x < SQUARE_SIDE; x++)
            assert_int_equal(constraint[y * (SQUARE_SIDE + 1) + x] == PLANISH_CONSTRAINT_FIXED,
                             (column && x == SQUARE_SIDE / 2) || (row && y == SQUARE_SIDE / 2));
}

static inline void expect_held(const planish_file *file, int column, int row) {
    expect_held_with(file, NULL, column, row);
}

#endif
