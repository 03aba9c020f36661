/* CGNS: elements of every type, with the order of nodes of the SIDS (conventions for unstructured
 * grids). */
#include "support/files.h"
#include "support/hdf5_builder.h"
#include "support/rewriting.h"
#include "support/unit_elements.h"
#include "support/unit_orders.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#ifdef PL_HDF5

#define ZONE "/Base/Zone"

#define WEDGE15      WEDGE " 12 23 31 14 25 36 45 56 64"
#define HEXAHEDRON20 HEXAHEDRON EDGES4 " 15 26 37 48 56 67 78 85"

static const unit_element elements[] = {
    {PLANISH_CELL_TRIANGLE, 5, TRIANGLE},
    {PLANISH_CELL_TRIANGLE6, 6, TRIANGLE6},
    {PLANISH_CELL_QUADRILATERAL, 7, QUADRILATERAL},
    {PLANISH_CELL_QUADRILATERAL8, 8, QUADRILATERAL EDGES4},
    {PLANISH_CELL_QUADRILATERAL9, 9, QUADRILATERAL EDGES4 " 1234"},
    {PLANISH_CELL_TETRAHEDRON, 10, TETRAHEDRON},
    {PLANISH_CELL_TETRAHEDRON10, 11, TETRAHEDRON10},
    {PLANISH_CELL_PYRAMID, 12, PYRAMID},
    {PLANISH_CELL_PYRAMID13, 21, PYRAMID13},
    {PLANISH_CELL_PYRAMID14, 13, PYRAMID13 " 1234"},
    {PLANISH_CELL_WEDGE, 14, WEDGE},
    {PLANISH_CELL_WEDGE15, 15, WEDGE15},
    {PLANISH_CELL_WEDGE18, 16, WEDGE15 " 1254 2365 3146"},
    {PLANISH_CELL_HEXAHEDRON, 17, HEXAHEDRON},
    {PLANISH_CELL_HEXAHEDRON20, 18, HEXAHEDRON20},
    {PLANISH_CELL_HEXAHEDRON27, 19, HEXAHEDRON20 " 1234 1265 2376 3487 4158 5678 12345678"},
};

enum { MIXED = 20, N_TYPES = sizeof elements / sizeof *elements };

static void put_nodes(hdf5_builder *b, int dim, int n, const double places[][3]) {
    double x[UNIT_NODES];
    char path[128];
    cgns_put_integers(b, "/Base", "CGNSBase_t", 2, (const int[]){dim, dim});
    cgns_put_integers(b, ZONE, "Zone_t", 3, (const int[]){n, 2, 0});
    cgns_put_text(b, ZONE "/ZoneType", "ZoneType_t", "Unstructured");
    cgns_put_node(b, ZONE "/GridCoordinates", "GridCoordinates_t");
    for (int d = 0; d < dim; d++) {
        for (int i = 0; i < n; i++)
            x[i] = places[i][d];
        snprintf(path, sizeof path, ZONE "/GridCoordinates/Coordinate%c", "XYZ"[d]);
        cgns_put_node(b, path, "DataArray_t");
        snprintf(path, sizeof path, ZONE "/GridCoordinates/Coordinate%c/ data", "XYZ"[d]);
        hdf5_reals(b, path, (hsize_t)n, x);
    }
}

/** Make a file of two elements with the same nodes, in a section of their type or a mixed one. */
static file_builder make(int i, int n, double x[UNIT_NODES][3], int is_mixed, int64_t *second) {
    const int code = elements[i].code;
    hdf5_builder b;
    int list[2 * (UNIT_NODES + 1)], size = 0;
    *second = 8;
    hdf5_begin(&b, 0);
    cgns_put_node(&b, "/CGNSLibraryVersion", "CGNSLibraryVersion_t");
    put_nodes(&b, unit_dim(elements[i].type), n, x);
    for (int k = 0; k < 2; k++) {
        if (is_mixed)
            list[size++] = code;
        for (int node = 1; node <= n; node++)
            list[size++] = node;
    }
    cgns_put_integers(&b, ZONE "/all", "Elements_t", 2, (const int[]){is_mixed ? MIXED : code, 0});
    cgns_put_integers(&b, ZONE "/all/ElementRange", "IndexRange_t", 2, (const int[]){7, 8});
    cgns_put_integers(&b, ZONE "/all/ElementConnectivity", "DataArray_t", size, list);
    return hdf5_end(&b);
}

static void elements_of_every_type_are_read(void **state) {
    (void)state;
    unit_expect_types(&io_format_cgns, elements, N_TYPES, make);
}

/** Make a file of tetrahedra of both orders, a triangle and a line, in sections of their own or in
 *  a mixed one; the triangle is a boundary condition, too, and joins another zone. */
static file_builder make_both_orders(int is_mixed) {
    static const int straight[] = {1, 2, 3, 4}, curved[] = {2, 3, 4, 5, 6, 7, 8, 9, 10, 11},
                     triangle[] = {3, 4, 5, 7, 11, 10}, line[] = {4, 5, 11};
    static const int mixed[] = {11, 2, 3,  4,  5,  6, 7, 8, 9, 10, 11, 6, 3, 4,
                                5,  7, 11, 10, 10, 1, 2, 3, 4, 4,  4,  5, 11};
    hdf5_builder b;
    hdf5_begin(&b, 0);
    cgns_put_node(&b, "/CGNSLibraryVersion", "CGNSLibraryVersion_t");
    put_nodes(&b, 3, UNIT_BOTH_NODES, unit_both_places);
    if (is_mixed) {
        cgns_put_section(&b, ZONE "/all", MIXED, 1, 4, sizeof mixed / sizeof *mixed, mixed);
    } else {
        cgns_put_section(&b, ZONE "/b", 11, 1, 1, 10, curved);
        cgns_put_section(&b, ZONE "/t", 6, 2, 2, 6, triangle);
        cgns_put_section(&b, ZONE "/a", 10, 3, 3, 4, straight);
        cgns_put_section(&b, ZONE "/l", 4, 4, 4, 3, line);
    }
    cgns_put_node(&b, ZONE "/ZoneBC", "ZoneBC_t");
    cgns_put_text(&b, ZONE "/ZoneBC/wall", "BC_t", "BCWall");
    cgns_put_text(&b, ZONE "/ZoneBC/wall/GridLocation", "GridLocation_t", "FaceCenter");
    cgns_put_integers(&b, ZONE "/ZoneBC/wall/PointList", "IndexArray_t", 1, (const int[]){2});
    cgns_put_node(&b, ZONE "/ZoneGridConnectivity", "ZoneGridConnectivity_t");
    cgns_put_text(&b, ZONE "/ZoneGridConnectivity/j", "GridConnectivity_t", "Elsewhere");
    cgns_put_text(&b, ZONE "/ZoneGridConnectivity/j/GridLocation", "GridLocation_t", "FaceCenter");
    cgns_put_integers(&b, ZONE "/ZoneGridConnectivity/j/PointList", "IndexArray_t", 1,
                      (const int[]){2});
    return hdf5_end(&b);
}

/** Sections of hexahedra are regions, and quadrilaterals and elements of boundary conditions groups. */
static void bricks_have_sections_and_conditions(void **state) {
    static const int left[] = {1, 2, 5, 4, 7, 8, 11, 10}, right[] = {2, 3, 6, 5, 8, 9, 12, 11};
    static const int wall[] = {7, 1, 2, 5, 4};
    hdf5_builder b;
    hdf5_begin(&b, 0);
    cgns_put_node(&b, "/CGNSLibraryVersion", "CGNSLibraryVersion_t");
    put_nodes(&b, 3, UNIT_BRICK_NODES, unit_brick_places);
    cgns_put_section(&b, ZONE "/left", 17, 1, 1, 8, left);
    cgns_put_section(&b, ZONE "/right", 17, 2, 2, 8, right);
    cgns_put_section(&b, ZONE "/faces", MIXED, 3, 3, 5, wall);
    cgns_put_node(&b, ZONE "/ZoneBC", "ZoneBC_t");
    cgns_put_text(&b, ZONE "/ZoneBC/bottom", "BC_t", "BCWall");
    cgns_put_text(&b, ZONE "/ZoneBC/bottom/GridLocation", "GridLocation_t", "FaceCenter");
    cgns_put_integers(&b, ZONE "/ZoneBC/bottom/PointList", "IndexArray_t", 1, (const int[]){3});
    file_builder made = hdf5_end(&b);
    planish_file *file = builder_file(&made, &io_format_cgns);
    unit_expect_bricks(file, "bottom", "right");
    unit_expect_held(file, "faces", "110110000000");
    planish_file_close(file);
    builder_let_allocations_fail(&made, &io_format_cgns);
    rewriting_in_place(made.data, made.size, 0, *state, "in.cgns");
    builder_release(&made);
}

static void both_orders_may_be_in_a_file(void **state) {
    (void)state;
    for (int is_mixed = 0; is_mixed < 2; is_mixed++) {
        file_builder b = make_both_orders(is_mixed);
        planish_file *file = builder_file(&b, &io_format_cgns);
        unit_expect_both_orders(file, 1);
        unit_expect_held(file, NULL, "00111010011");
        unit_expect_held(file, "wall", "00111010011");
        if (!is_mixed)
            unit_expect_held(file, "b", "01111111111");
        for (int node = 0; node < UNIT_BOTH_NODES; node++) /* mids of the triangle, too */
            assert_int_equal((file->model.hold[node] & IO_HELD_REQUIRED) != 0,
                             "00111010011"[node] == '1');
        assert_int_equal(planish_file_element_number(file, 1), 3);
        planish_file_close(file);
        builder_let_allocations_fail(&b, &io_format_cgns);
        builder_release(&b);
    }
}

/** A moved mid is written: node 5 of TETRA_10. */
static void mids_come_back(void **state) {
    double x[UNIT_NODES][3];
    int64_t second;
    for (int i = 0; i < N_TYPES; i++) {
        if (elements[i].type != PLANISH_CELL_TETRAHEDRON10)
            continue;
        file_builder b =
            make(i, unit_places(elements[i].type, elements[i].nodes, x), x, 0, &second);
        rewriting_in_place(b.data, b.size, 0, *state, "in.cgns");
        builder_release(&b);
    }
}

static void nothing_breaks_it(void **state) {
    (void)state;
    double x[UNIT_NODES][3];
    int64_t second;
    const unit_element *last = &elements[N_TYPES - 1];
    const int n = unit_places(last->type, last->nodes, x);
    for (int is_mixed = 0; is_mixed < 2; is_mixed++) {
        file_builder b = make(N_TYPES - 1, n, x, is_mixed, &second);
        builder_expect_same_on_threads(&b, &io_format_cgns);
        builder_let_allocations_fail(&b, &io_format_cgns);
        builder_release(&b);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elements_of_every_type_are_read),
        cmocka_unit_test(both_orders_may_be_in_a_file),
        cmocka_unit_test_setup_teardown(bricks_have_sections_and_conditions, test_folder_create,
                                        test_folder_remove),
        cmocka_unit_test_setup_teardown(mids_come_back, test_folder_create, test_folder_remove),
        cmocka_unit_test(nothing_breaks_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#else

int main(void) {
    return 0; /* test_vtkhdf.c sees that HDF5 is asked for */
}

#endif
