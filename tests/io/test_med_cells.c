/* MED: elements of every type, with the order of nodes of MED's document: solid elements are
 * mirrored to VTK's. */
#include "support/hdf5_builder.h"
#include "support/reading.h"
#include "support/unit_cells.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#ifdef PL_HDF5

#define MESH "/ENS_MAA/part"

#define TRIANGLE6      "12 23 31"
#define QUADRILATERAL8 "12 23 34 41"
#define TETRAHEDRON10  TRIANGLE6 " 14 24 34"
#define PYRAMID13      QUADRILATERAL8 " 15 25 35 45"
#define WEDGE15        TRIANGLE6 " 45 56 64 14 25 36"
#define HEXAHEDRON20   QUADRILATERAL8 " 56 67 78 85 15 26 37 48"

static const unit_cell cells[] = {
    {"TR3", 0, PLANISH_CELL_TRIANGLE, ""},
    {"TR6", 0, PLANISH_CELL_TRIANGLE6, TRIANGLE6},
    {"QU4", 0, PLANISH_CELL_QUADRILATERAL, ""},
    {"QU8", 0, PLANISH_CELL_QUADRILATERAL8, QUADRILATERAL8},
    {"QU9", 0, PLANISH_CELL_QUADRILATERAL9, QUADRILATERAL8 " 13"},
    {"TE4", 0, PLANISH_CELL_TETRAHEDRON, ""},
    {"T10", 0, PLANISH_CELL_TETRAHEDRON10, TETRAHEDRON10},
    {"PY5", 0, PLANISH_CELL_PYRAMID, ""},
    {"P13", 0, PLANISH_CELL_PYRAMID13, PYRAMID13},
    {"PE6", 0, PLANISH_CELL_WEDGE, ""},
    {"P15", 0, PLANISH_CELL_WEDGE15, WEDGE15},
    {"P18", 0, PLANISH_CELL_WEDGE18, WEDGE15 " 15 26 34"},
    {"HE8", 0, PLANISH_CELL_HEXAHEDRON, ""},
    {"H20", 0, PLANISH_CELL_HEXAHEDRON20, HEXAHEDRON20},
    {"H27", 0, PLANISH_CELL_HEXAHEDRON27, HEXAHEDRON20 " 13 16 27 38 18 57 17"},
};

enum { N_TYPES = sizeof cells / sizeof *cells };

/** Make a file of two elements with the same nodes; all x stand before all y, and the first nodes of
 *  all elements before the second. n_said: elements that the file says it has; surplus: nodes
 *  too many. */
static file_builder make(const unit_cell *cell, int is_mirrored, int with_numbers, int n_said,
                         int surplus) {
    hdf5_builder b;
    double xyz[3 * UNIT_NODES], columns[3 * UNIT_NODES];
    int list[2 * UNIT_NODES + 1] = {1};
    char path[128];
    const int n = unit_cell_places(cell, is_mirrored, xyz), dim = unit_cell_dim(cell);
    for (int i = 0; i < n; i++) {
        for (int d = 0; d < dim; d++)
            columns[d * n + i] = xyz[3 * i + d];
        list[2 * i] = list[2 * i + 1] = i + 1;
    }
    list[2 * n] = 1;
    hdf5_begin(&b, 0);
    hdf5_group(&b, MESH "/NOE");
    hdf5_attribute(&b, MESH, "DIM", dim);
    hdf5_attribute(&b, MESH, "REP", 0);
    hdf5_attribute(&b, MESH, "TYP", 0);
    hdf5_reals(&b, MESH "/NOE/COO", (hsize_t)(dim * n), columns);
    hdf5_attribute(&b, MESH "/NOE/COO", "NBR", n);
    snprintf(path, sizeof path, MESH "/MAI/%s", cell->name);
    hdf5_group(&b, path);
    snprintf(path, sizeof path, MESH "/MAI/%s/NOD", cell->name);
    hdf5_integers(&b, path, (hsize_t)(2 * n + surplus), list);
    hdf5_attribute(&b, path, "NBR", n_said);
    if (with_numbers) {
        snprintf(path, sizeof path, MESH "/MAI/%s/NUM", cell->name);
        hdf5_integers(&b, path, 2, (const int[]){70, 80});
    }
    return hdf5_end(&b);
}

static void elements_of_every_type_are_read(void **state) {
    (void)state;
    for (int i = 0; i < 4 * N_TYPES; i++) {
        const unit_cell *cell = &cells[i / 4];
        planish_file *file;
        planish_file_info info;
        planish_error error = {.text = ""};
        const int with_numbers = i >> 1 & 1;
        file_builder b = make(cell, i & 1, with_numbers, 2, 0);
        if (builder_read(&b, &io_format_med, 1, &file, &error))
            fail_msg("%s: %s", cell->name, error.text);
        unit_cell_check(file, cell, 2);
        assert_int_equal(planish_file_element_number(file, 1), with_numbers ? 80 : 2);
        planish_file_get_info(file, &info);
        const int is_kept = unit_cell_is_kept(cell);
        assert_int_equal(info.n_other_elements, is_kept ? 0 : 2);
        assert_int_equal(file->model.hold[0], is_kept ? 0 : IO_HELD_BY_OTHER);
        planish_file_close(file);
        builder_release(&b);
    }
}

static void wrong_counts_are_refused(void **state) {
    (void)state;
    for (int i = 0; i < N_TYPES; i++) {
        file_builder b = make(&cells[i], 0, 0, 3, 0);
        builder_expect_error(&b, &io_format_med, "another number of elements");
        builder_release(&b);
        b = make(&cells[i], 0, 0, 2, 1);
        builder_expect_error(&b, &io_format_med, "are no elements of");
        builder_release(&b);
    }
}

static void nothing_breaks_it(void **state) {
    (void)state;
    file_builder b = make(&cells[N_TYPES - 1], 1, 1, 2, 0);
    builder_expect_same_on_threads(&b, &io_format_med);
    builder_let_allocations_fail(&b, &io_format_med);
    builder_release(&b);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elements_of_every_type_are_read),
        cmocka_unit_test(wrong_counts_are_refused),
        cmocka_unit_test(nothing_breaks_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#else

int main(void) {
    return 0; /* test_vtkhdf.c sees that HDF5 is asked for */
}

#endif
