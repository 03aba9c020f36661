/* CGNS: elements of every type, with the order of nodes of the SIDS (conventions for unstructured
 * grids). */
#include "support/hdf5_builder.h"
#include "support/reading.h"
#include "support/unit_cells.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#ifdef PL_HDF5

#define ZONE "/Base/Zone"

#define TRIANGLE6      "12 23 31"
#define QUADRILATERAL8 "12 23 34 41"
#define TETRAHEDRON10  TRIANGLE6 " 14 24 34"
#define PYRAMID13      QUADRILATERAL8 " 15 25 35 45"
#define WEDGE15        TRIANGLE6 " 14 25 36 45 56 64"
#define HEXAHEDRON20   QUADRILATERAL8 " 15 26 37 48 56 67 78 85"

static const unit_cell cells[] = {
    {"TRI_3", 5, PLANISH_CELL_TRIANGLE, ""},
    {"TRI_6", 6, PLANISH_CELL_TRIANGLE6, TRIANGLE6},
    {"QUAD_4", 7, PLANISH_CELL_QUADRILATERAL, ""},
    {"QUAD_8", 8, PLANISH_CELL_QUADRILATERAL8, QUADRILATERAL8},
    {"QUAD_9", 9, PLANISH_CELL_QUADRILATERAL9, QUADRILATERAL8 " 13"},
    {"TETRA_4", 10, PLANISH_CELL_TETRAHEDRON, ""},
    {"TETRA_10", 11, PLANISH_CELL_TETRAHEDRON10, TETRAHEDRON10},
    {"PYRA_5", 12, PLANISH_CELL_PYRAMID, ""},
    {"PYRA_13", 21, PLANISH_CELL_PYRAMID13, PYRAMID13},
    {"PYRA_14", 13, PLANISH_CELL_PYRAMID14, PYRAMID13 " 13"},
    {"PENTA_6", 14, PLANISH_CELL_WEDGE, ""},
    {"PENTA_15", 15, PLANISH_CELL_WEDGE15, WEDGE15},
    {"PENTA_18", 16, PLANISH_CELL_WEDGE18, WEDGE15 " 15 26 34"},
    {"HEXA_8", 17, PLANISH_CELL_HEXAHEDRON, ""},
    {"HEXA_20", 18, PLANISH_CELL_HEXAHEDRON20, HEXAHEDRON20},
    {"HEXA_27", 19, PLANISH_CELL_HEXAHEDRON27, HEXAHEDRON20 " 13 16 27 38 18 57 17"},
};

enum { MIXED = 20, N_TYPES = sizeof cells / sizeof *cells };

static void put_nodes(hdf5_builder *b, const unit_cell *cell, int is_mirrored) {
    double xyz[3 * UNIT_NODES], x[UNIT_NODES];
    char path[128];
    const int n = unit_cell_places(cell, is_mirrored, xyz), dim = unit_cell_dim(cell);
    cgns_put_integers(b, "/Base", "CGNSBase_t", 2, (const int[]){dim, dim});
    cgns_put_integers(b, ZONE, "Zone_t", 3, (const int[]){n, 2, 0});
    cgns_put_text(b, ZONE "/ZoneType", "ZoneType_t", "Unstructured");
    cgns_put_node(b, ZONE "/GridCoordinates", "GridCoordinates_t");
    for (int d = 0; d < dim; d++) {
        for (int i = 0; i < n; i++)
            x[i] = xyz[3 * i + d];
        snprintf(path, sizeof path, ZONE "/GridCoordinates/Coordinate%c", "XYZ"[d]);
        cgns_put_node(b, path, "DataArray_t");
        snprintf(path, sizeof path, ZONE "/GridCoordinates/Coordinate%c/ data", "XYZ"[d]);
        hdf5_reals(b, path, (hsize_t)n, x);
    }
}

/** Make a file of two elements with the same nodes, in a section of their type or a mixed one. */
static file_builder make(const unit_cell *cell, int is_mixed, int is_mirrored) {
    hdf5_builder b;
    int list[2 * (UNIT_NODES + 1)], n = 0;
    hdf5_begin(&b, 0);
    cgns_put_node(&b, "/CGNSLibraryVersion", "CGNSLibraryVersion_t");
    put_nodes(&b, cell, is_mirrored);
    for (int k = 0; k < 2; k++) {
        if (is_mixed)
            list[n++] = cell->number;
        for (int i = 1; i <= unit_cell_nodes(cell); i++)
            list[n++] = i;
    }
    cgns_put_integers(&b, ZONE "/all", "Elements_t", 2,
                      (const int[]){is_mixed ? MIXED : cell->number, 0});
    cgns_put_integers(&b, ZONE "/all/ElementRange", "IndexRange_t", 2, (const int[]){7, 8});
    cgns_put_integers(&b, ZONE "/all/ElementConnectivity", "DataArray_t", n, list);
    return hdf5_end(&b);
}

static void elements_of_every_type_are_read(void **state) {
    (void)state;
    for (int i = 0; i < 4 * N_TYPES; i++) {
        const unit_cell *cell = &cells[i / 4];
        planish_file *file;
        planish_file_info info;
        planish_error error = {.text = ""};
        file_builder b = make(cell, i & 1, i >> 1 & 1);
        if (builder_read(&b, &io_format_cgns, 1, &file, &error))
            fail_msg("%s: %s", cell->name, error.text);
        unit_cell_check(file, cell, 2);
        assert_int_equal(planish_file_element_number(file, 1), 8);
        planish_file_get_info(file, &info);
        const int is_kept = unit_cell_is_kept(cell);
        assert_int_equal(info.n_other_elements, is_kept ? 0 : 2);
        assert_int_equal(file->model.hold[0], is_kept ? 0 : IO_HELD_BY_OTHER);
        planish_file_close(file);
        builder_release(&b);
    }
}

static void nothing_breaks_it(void **state) {
    (void)state;
    for (int is_mixed = 0; is_mixed < 2; is_mixed++) {
        file_builder b = make(&cells[N_TYPES - 1], is_mixed, 0);
        builder_expect_same_on_threads(&b, &io_format_cgns);
        builder_let_allocations_fail(&b, &io_format_cgns);
        builder_release(&b);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elements_of_every_type_are_read),
        cmocka_unit_test(nothing_breaks_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#else

int main(void) {
    return 0; /* test_vtkhdf.c sees that HDF5 is asked for */
}

#endif
