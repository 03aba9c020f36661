/* MED: elements of every type, with the order of nodes of MED's document: solid elements are
 * mirrored to VTK's. */
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

#define MESH "/ENS_MAA/part"

#define WEDGE15      WEDGE " 12 23 31 45 56 64 14 25 36"
#define HEXAHEDRON20 HEXAHEDRON EDGES4 " 56 67 78 85 15 26 37 48"

/* Codes are indices into names. */
static const char names[][4] = {"TR3", "TR6", "QU4", "QU8", "QU9", "TE4", "T10", "PY5",
                                "P13", "PE6", "P15", "P18", "HE8", "H20", "H27"};

static const unit_element elements[] = {
    {PLANISH_CELL_TRIANGLE, 0, TRIANGLE},
    {PLANISH_CELL_TRIANGLE6, 1, TRIANGLE6},
    {PLANISH_CELL_QUADRILATERAL, 2, QUADRILATERAL},
    {PLANISH_CELL_QUADRILATERAL8, 3, QUADRILATERAL EDGES4},
    {PLANISH_CELL_QUADRILATERAL9, 4, QUADRILATERAL EDGES4 " 1234"},
    {PLANISH_CELL_TETRAHEDRON, 5, TETRAHEDRON},
    {PLANISH_CELL_TETRAHEDRON10, 6, TETRAHEDRON10},
    {PLANISH_CELL_PYRAMID, 7, PYRAMID},
    {PLANISH_CELL_PYRAMID13, 8, PYRAMID13},
    {PLANISH_CELL_WEDGE, 9, WEDGE},
    {PLANISH_CELL_WEDGE15, 10, WEDGE15},
    {PLANISH_CELL_WEDGE18, 11, WEDGE15 " 1254 2365 3146"},
    {PLANISH_CELL_HEXAHEDRON, 12, HEXAHEDRON},
    {PLANISH_CELL_HEXAHEDRON20, 13, HEXAHEDRON20},
    {PLANISH_CELL_HEXAHEDRON27, 14, HEXAHEDRON20 " 1234 1265 2376 3487 4158 5678 12345678"},
};

enum { N_TYPES = sizeof elements / sizeof *elements };

/** Begin a file of n nodes: all x stand before all y. */
static void begin(hdf5_builder *b, int dim, int n, const double x[][3]) {
    double columns[3 * UNIT_NODES];
    for (int node = 0; node < n; node++)
        for (int d = 0; d < dim; d++)
            columns[d * n + node] = x[node][d];
    hdf5_begin(b, 0);
    hdf5_group(b, MESH "/NOE");
    hdf5_attribute(b, MESH, "DIM", dim);
    hdf5_attribute(b, MESH, "REP", 0);
    hdf5_attribute(b, MESH, "TYP", 0);
    hdf5_reals(b, MESH "/NOE/COO", (hsize_t)(dim * n), columns);
    hdf5_attribute(b, MESH "/NOE/COO", "NBR", n);
}

/** Make a file of two elements of row i with the same n nodes; the first nodes of all elements stand
 *  before the second. n_said: elements that the file says it has; surplus: nodes too many. */
static file_builder make_wrong(int i, int n, double x[UNIT_NODES][3], int with_numbers, int n_said,
                               int surplus) {
    const int dim = unit_dim(elements[i].type);
    const char *name = names[elements[i].code];
    hdf5_builder b;
    int list[2 * UNIT_NODES + 1];
    char path[128];
    for (int node = 0; node < n; node++)
        list[2 * node] = list[2 * node + 1] = node + 1;
    list[2 * n] = 1;
    begin(&b, dim, n, x);
    snprintf(path, sizeof path, MESH "/MAI/%s", name);
    hdf5_group(&b, path);
    snprintf(path, sizeof path, MESH "/MAI/%s/NOD", name);
    hdf5_integers(&b, path, (hsize_t)(2 * n + surplus), list);
    hdf5_attribute(&b, path, "NBR", n_said);
    snprintf(path, sizeof path, MESH "/MAI/%s/NUM", name);
    if (with_numbers)
        hdf5_integers(&b, path, 2, (const int[]){70, 80});
    return hdf5_end(&b);
}

static file_builder make(int i, int n, double x[UNIT_NODES][3], int with_numbers, int64_t *second) {
    *second = with_numbers ? 80 : 2;
    return make_wrong(i, n, x, with_numbers, 2, 0);
}

static void elements_of_every_type_are_read(void **state) {
    (void)state;
    unit_expect_types(&io_format_med, elements, N_TYPES, make);
}

/** Put an element of a family, with a number if it is not 0. */
static void put_element(const hdf5_builder *b, const char *name, int n, const int *nodes,
                        int family, int number) {
    char path[128];
    snprintf(path, sizeof path, MESH "/MAI/%s", name);
    hdf5_group(b, path);
    snprintf(path, sizeof path, MESH "/MAI/%s/NOD", name);
    hdf5_integers(b, path, (hsize_t)n, nodes);
    hdf5_attribute(b, path, "NBR", 1);
    snprintf(path, sizeof path, MESH "/MAI/%s/FAM", name);
    hdf5_integers(b, path, 1, &family);
    snprintf(path, sizeof path, MESH "/MAI/%s/NUM", name);
    if (number)
        hdf5_integers(b, path, 1, &number);
}

/** Make a file of unit_expect_both_orders. Families: the straight tetrahedron -1, the other -2, the
 *  triangle -3, the line -4. Numbers of tetrahedra; 0: they have none. */
static file_builder make_both_orders(const char *curved_name, int curved_number,
                                     int straight_number) {
    static const int straight[] = {1, 2, 3, 4}, curved[] = {2, 3, 4, 5, 6, 7, 8, 9, 10, 11},
                     triangle[] = {3, 4, 5, 7, 11, 10}, line[] = {4, 5, 11};
    hdf5_builder b;
    begin(&b, 3, UNIT_BOTH_NODES, unit_both_places);
    put_element(&b, curved_name, 10, curved, -2, curved_number);
    put_element(&b, "TE4", 4, straight, -1, straight_number);
    put_element(&b, "TR6", 6, triangle, -3, 0);
    put_element(&b, "SE3", 3, line, -4, 0);
    return hdf5_end(&b);
}

static void both_orders_may_be_in_a_file(void **state) {
    (void)state;
    for (int i = 0; i < 8; i++) {
        const int curved_number = i & 1 ? 5 : 0, straight_number = i & 2 ? 7 : 0;
        file_builder b = make_both_orders(i & 4 ? "TE10" : "T10", curved_number, straight_number);
        planish_file *file = builder_file(&b, &io_format_med);
        unit_expect_both_orders(file, 1);
        unit_expect_held(file, NULL, "00111010011");
        unit_expect_held(file, "3:-2", "01111111111");
        unit_expect_held(file, "3:-1", "11111010011");
        unit_expect_held(file, "1:-4", "00111010011");
        const io_cells *cells = &file->model.tetrahedron;
        const int is_first = cells->nodes[0] == 1;
        assert_int_equal(io_cell_number(cells, !is_first), curved_number ? curved_number : 1);
        assert_int_equal(io_cell_number(cells, is_first), straight_number ? straight_number : 1);
        planish_file_close(file);
        builder_let_allocations_fail(&b, &io_format_med);
        builder_release(&b);
    }
}

/** Hexahedra and quadrilaterals have families, which are regions and groups. */
static void bricks_have_families(void **state) {
    static const int n_nodes = 16, nodes[] = {1, 2, 4, 5, 5, 6, 2, 3, 7, 8, 10, 11, 11, 12, 8, 9};
    static const int facet[] = {1, 2, 5, 4};
    hdf5_builder b;
    begin(&b, 3, UNIT_BRICK_NODES, unit_brick_places);
    put_element(&b, "QU4", 4, facet, -3, 0);
    hdf5_group(&b, MESH "/MAI/HE8");
    hdf5_integers(&b, MESH "/MAI/HE8/NOD", (hsize_t)n_nodes, nodes); /* first nodes first */
    hdf5_attribute(&b, MESH "/MAI/HE8/NOD", "NBR", 2);
    hdf5_integers(&b, MESH "/MAI/HE8/FAM", 2, (const int[]){-1, -2});
    hdf5_group(&b, "/FAS/part/ELEME/right");
    hdf5_attribute(&b, "/FAS/part/ELEME/right", "NUM", -2);
    file_builder made = hdf5_end(&b);
    planish_file *file = builder_file(&made, &io_format_med);
    unit_expect_bricks(file, "2:-3", "3:-2");
    planish_file_close(file);
    builder_let_allocations_fail(&made, &io_format_med);
    rewriting_in_place(made.data, made.size, 0, *state, "in.med");
    builder_release(&made);
}

/** A moved mid is written: node 5 of T10. */
static void mids_come_back(void **state) {
    double x[UNIT_NODES][3];
    const int i = 6, n = unit_places(elements[i].type, elements[i].nodes, x);
    assert_int_equal(elements[i].type, PLANISH_CELL_TETRAHEDRON10);
    file_builder b = make_wrong(i, n, x, 0, 2, 0);
    rewriting_in_place(b.data, b.size, 0, *state, "in.med");
    builder_release(&b);
}

static void wrong_counts_are_refused(void **state) {
    (void)state;
    for (int i = 0; i < N_TYPES; i++) {
        double x[UNIT_NODES][3];
        const int n = unit_places(elements[i].type, elements[i].nodes, x);
        file_builder b = make_wrong(i, n, x, 0, 3, 0);
        builder_expect_error(&b, &io_format_med, "another number of elements");
        builder_release(&b);
        b = make_wrong(i, n, x, 0, 2, 1);
        builder_expect_error(&b, &io_format_med, "do not make elements of");
        builder_release(&b);
    }
}

static void nothing_breaks_it(void **state) {
    (void)state;
    double x[UNIT_NODES][3];
    const unit_element *last = &elements[N_TYPES - 1];
    const int n = unit_places(last->type, last->nodes, x);
    unit_mirror(n, x);
    file_builder b = make_wrong(N_TYPES - 1, n, x, 1, 2, 0);
    builder_expect_same_on_threads(&b, &io_format_med);
    builder_let_allocations_fail(&b, &io_format_med);
    builder_release(&b);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elements_of_every_type_are_read),
        cmocka_unit_test(wrong_counts_are_refused),
        cmocka_unit_test(both_orders_may_be_in_a_file),
        cmocka_unit_test_setup_teardown(bricks_have_families, test_folder_create,
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
