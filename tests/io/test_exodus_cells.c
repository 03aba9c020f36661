/* Exodus: elements of every type, with the orders of nodes and sides of the Exodus II manual. */
#include "support/files.h"
#include "support/netcdf_builder.h"
#include "support/rewriting.h"
#include "support/unit_elements.h"
#include "support/unit_orders.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#define WEDGE15      WEDGE " 12 23 31 14 25 36 45 56 64"
#define HEXAHEDRON20 HEXAHEDRON EDGES4 " 15 26 37 48 56 67 78 85"

/* Codes are indices into these names, in all letter cases, and the sides of each: their corners. */
static const struct {
    char name[12];
    int first_side; /* of the sides below: of shells 3 */
    const char *side[7];
} types[] = {{"TRI", 1, {"12", "23", "31"}},
             {"tri6", 1, {"12", "23", "31"}},
             {"QUAD4", 1, {"12", "23", "34", "41"}},
             {"Shell8", 3, {"12", "23", "34", "41"}},
             {"SHELL9", 3, {"12", "23", "34", "41"}},
             {"tetra", 1, {"124", "234", "143", "132"}},
             {"TETRA10", 1, {"124", "234", "143", "132"}},
             {"PYRAMID", 1, {"125", "235", "345", "154", "1432"}},
             {"PYRAMID13", 1, {"125", "235", "345", "154", "1432"}},
             {"Pyramid14", 1, {"125", "235", "345", "154", "1432"}},
             {"WEDGE", 1, {"1254", "2365", "1463", "132", "456"}},
             {"wedge15", 1, {"1254", "2365", "1463", "132", "456"}},
             {"WEDGE18", 1, {"1254", "2365", "1463", "132", "456"}},
             {"HEX", 1, {"1265", "2376", "3487", "1584", "1432", "5678"}},
             {"HEX20", 1, {"1265", "2376", "3487", "1584", "1432", "5678"}},
             {"hexahedron", 1, {"1265", "2376", "3487", "1584", "1432", "5678"}}};

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
    {PLANISH_CELL_PYRAMID14, 9, PYRAMID13 " 1234"},
    {PLANISH_CELL_WEDGE, 10, WEDGE},
    {PLANISH_CELL_WEDGE15, 11, WEDGE15},
    {PLANISH_CELL_WEDGE18, 12, WEDGE15 " 1254 2365 3146"},
    {PLANISH_CELL_HEXAHEDRON, 13, HEXAHEDRON},
    {PLANISH_CELL_HEXAHEDRON20, 14, HEXAHEDRON20},
    {PLANISH_CELL_HEXAHEDRON27, 15, HEXAHEDRON20 " 12345678 1234 5678 4158 2376 1265 3487"},
};
enum { N_TYPES = sizeof elements / sizeof *elements };

/** Begin a file of n nodes. */
static void begin(netcdf_builder *b, int kind, int dim, int n, double x[UNIT_NODES][3]) {
    double columns[3 * UNIT_NODES];
    *b = (netcdf_builder){.kind = kind};
    for (int node = 0; node < n; node++)
        for (int d = 0; d < dim; d++)
            columns[d * n + node] = x[node][d];
    netcdf_put_reals(b, "coord", NETCDF_AS_DOUBLE, dim, n, columns);
}

/** Put a block of n elements of width nodes each. */
static void put_block(netcdf_builder *b, int k, const char *type, int n, int width,
                      const int *nodes) {
    char name[32];
    snprintf(name, sizeof name, "connect%d", k);
    netcdf_part *part = netcdf_put_integers(b, name, n, width, nodes);
    snprintf(part->text, sizeof part->text, "%s", type);
}

/** Make a file of two elements of row i with the same nodes. */
static file_builder make(int i, int n, double x[UNIT_NODES][3], int variant, int64_t *second) {
    netcdf_builder b;
    int list[2 * UNIT_NODES];
    for (int node = 0; node < 2 * n; node++)
        list[node] = node % n + 1;
    begin(&b, variant ? 4 : 2, unit_dim(elements[i].type), n, x);
    netcdf_put_integers(&b, "eb_prop1", 1, 0, (const int[]){1});
    put_block(&b, 1, types[elements[i].code].name, 2, n, list);
    if (variant)
        netcdf_put_integers(&b, "elem_num_map", 2, 0, (const int[]){70, 80});
    *second = variant ? 80 : 2;
    return netcdf_end_file(&b);
}

static void elements_of_every_type_are_read(void **state) {
    (void)state;
    unit_expect_types(&io_format_exodus, elements, N_TYPES, make);
}

/* ---- sides ---------------------------------------------------------------------------------- */

/** Read a file of one element of row i with a side set (7) of its side number side, and (8) of the
 *  first corner of a mesh that this may be. */
static planish_file *read_side(int i, int side, int *n) {
    double x[UNIT_NODES][3];
    netcdf_builder b;
    planish_file *file;
    planish_error error = {.text = ""};
    int list[UNIT_NODES];
    *n = unit_places(elements[i].type, elements[i].nodes, x);
    for (int node = 0; node < *n; node++)
        list[node] = node + 1;
    begin(&b, 5, unit_dim(elements[i].type), *n, x);
    netcdf_put_integers(&b, "eb_prop1", 1, 0, (const int[]){1});
    put_block(&b, 1, types[elements[i].code].name, 1, *n, list);
    netcdf_put_integers(&b, "ss_prop1", 1, 0, (const int[]){7});
    netcdf_put_integers(&b, "elem_ss1", 1, 0, (const int[]){1});
    netcdf_put_integers(&b, "side_ss1", 1, 0, &side);
    file_builder made = netcdf_end_file(&b);
    const int status = builder_read(&made, &io_format_exodus, 1, &file, &error);
    if (status)
        assert_non_null(strstr(error.text, "has no side"));
    builder_release(&made);
    return status ? NULL : file;
}

/** Say which of the nodes of an element are corners of a side, mids of its edges, or in its middle. */
static void find_side(const char *nodes, const char *corners, char *expected) {
    for (; *nodes; expected++) {
        const size_t n = strcspn(nodes, " ");
        *expected = strspn(nodes, corners) >= n ? '1' : '0';
        nodes += n + (nodes[n] == ' ');
    }
    *expected = '\0';
}

static void sides_are_facets(void **state) {
    (void)state;
    for (int i = 0; i < N_TYPES; i++) {
        const int code = elements[i].code, first = types[code].first_side;
        int n, side = 0;
        for (; types[code].side[side]; side++) {
            char expected[UNIT_NODES + 1];
            planish_file *file = read_side(i, first + side, &n);
            assert_non_null(file);
            find_side(elements[i].nodes, types[code].side[side], expected);
            if (unit_is_smoothed(elements[i].type))
                unit_expect_held(file, "7", expected);
            const io_model *model = &file->model;
            const int corners = (int)strlen(types[code].side[side]);
            assert_int_equal(model->line.n, corners == 2);
            if (unit_dim(elements[i].type) == 3) {
                assert_int_equal(model->triangle.n, corners == 3);
                assert_int_equal(model->flat.n, corners == 4);
            }
            planish_file_close(file);
        }
        assert_null(read_side(i, first + side, &n));
        assert_null(read_side(i, 0, &n));
    }
}

/** Read a surface in space, or beside a hexahedron, whose side set (7) has a side of each of two
 *  shells. */
static planish_file *read_shells(int with_solid, int side) {
    static const int hexahedron[] = {1, 2, 5, 4, 7, 8, 11, 10}, triangle[] = {2, 3, 6};
    static const int four[] = {1, 2, 5, 4};
    double x[UNIT_NODES][3];
    netcdf_builder b;
    memcpy(x, unit_brick_places, sizeof unit_brick_places);
    x[2][2] = 0.5; /* no plane */
    begin(&b, 1, 3, UNIT_BRICK_NODES, x);
    netcdf_put_integers(&b, "eb_prop1", 2 + with_solid, 0, (const int[]){1, 2, 3});
    put_block(&b, 1, "SHELL", 1, 4, four);
    put_block(&b, 2, "TRI3", 1, 3, triangle);
    put_block(&b, 3, "HEX8", 1, 8, hexahedron);
    netcdf_put_integers(&b, "ss_prop1", 1, 0, (const int[]){7});
    netcdf_put_texts(&b, "ss_names", 1, (const char *const[]){"side"});
    netcdf_put_integers(&b, "elem_ss1", 2, 0, (const int[]){1, 2});
    netcdf_put_integers(&b, "side_ss1", 2, 0, (const int[]){side, side});
    file_builder made = netcdf_end_file(&b);
    planish_file *file = builder_file(&made, &io_format_exodus);
    builder_release(&made);
    return file;
}

static void shells_have_faces_and_edges(void **state) {
    (void)state;
    for (int side = 1; side <= 2; side++) {
        planish_file *file = read_shells(0, side);
        assert_int_equal(file->model.line.n, 0);
        unit_expect_held(file, "side", "111111000000");
        planish_file_close(file);
    }
    planish_file *file = read_shells(0, 4); /* 2-5 and 3-6 */
    assert_int_equal(file->model.line.n, 2);
    unit_expect_held(file, "side", "011011000000");
    planish_file_close(file);
    /* Beside solids: shells hold their nodes, and their edges are no facets. */
    file = read_shells(1, 4);
    assert_int_equal(file->model.line.n, 0);
    assert_int_equal(file->model.triangle.n, 1);
    unit_expect_held(file, NULL, "111111000000");
    const char *const tag = "side";
    const planish_hold hold = {.tags = &tag, .n_tags = 1, .slide = 1};
    uint8_t constraint[UNIT_BRICK_NODES];
    planish_error error;
    assert_int_equal(planish_file_constraints(file, &hold, constraint, &error), 0);
    for (int i = 0; i < UNIT_BRICK_NODES; i++)
        assert_int_equal(constraint[i] == PLANISH_CONSTRAINT_FIXED, "011011000000"[i] == '1');
    planish_file_close(file);
}

/** Straight shells and lines on edges and faces of quadratic elements hold the mids there. */
static void straight_blocks_hold_mids(void **state) {
    static const int solid[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}, shell[] = {1, 2, 3},
                     line[] = {3, 4};
    double x[UNIT_NODES][3];
    netcdf_builder b;
    (void)state;
    assert_int_equal(unit_places(PLANISH_CELL_TETRAHEDRON10, TETRAHEDRON10, x), 10);
    begin(&b, 2, 3, 10, x);
    netcdf_put_integers(&b, "eb_prop1", 3, 0, (const int[]){1, 2, 3});
    put_block(&b, 1, "TETRA10", 1, 10, solid);
    put_block(&b, 2, "SHELL3", 1, 3, shell);
    put_block(&b, 3, "BEAM2", 1, 2, line);
    file_builder made = netcdf_end_file(&b);
    planish_file *file = builder_file(&made, &io_format_exodus);
    for (int i = 0; i < 10; i++) { /* 5, 6, 7: of the shell; 10: of the line */
        const int on_shell = i < 3 || (i >= 4 && i < 7), on_line = i == 2 || i == 3 || i == 9;
        assert_int_equal(file->model.hold[i],
                         (on_shell ? IO_HELD_BY_FACE : 0) | (on_line ? IO_HELD_BY_LINE : 0));
    }
    planish_file_close(file);
    builder_release(&made);
}

/* ---- blocks --------------------------------------------------------------------------------- */

static file_builder make_bricks(int kind, int dim) {
    static const int solid[2][8] = {{1, 2, 5, 4, 7, 8, 11, 10}, {2, 3, 6, 5, 8, 9, 12, 11}};
    static const int flat[2][4] = {{1, 2, 5, 4}, {2, 3, 6, 5}};
    double x[UNIT_NODES][3];
    netcdf_builder b;
    memcpy(x, unit_brick_places, sizeof unit_brick_places);
    begin(&b, kind, dim, dim == 3 ? UNIT_BRICK_NODES : 6, x);
    netcdf_put_integers(&b, "eb_prop1", 3, 0, (const int[]){70, -2, 30});
    netcdf_put_texts(&b, "eb_names", 3, (const char *const[]){"first", "second", "facet"});
    for (int k = 0; k < 2; k++)
        put_block(&b, k + 1, dim == 3 ? "HEX8" : "QUAD", 1, dim == 3 ? 8 : 4,
                  dim == 3 ? solid[k] : flat[k]);
    put_block(&b, 3, dim == 3 ? "SHELL4" : "BAR2", 1, dim == 3 ? 4 : 2, flat[0]);
    return netcdf_end_file(&b);
}

static void blocks_are_regions(void **state) {
    for (int i = 0; i < 4; i++) {
        file_builder b = make_bricks(i < 2 ? 2 : 4, 2 + i % 2);
        planish_file *file = builder_file(&b, &io_format_exodus);
        unit_expect_bricks(file, i < 2 ? "facet" : i % 2 ? "2:30" : "1:30", "second");
        planish_file_close(file);
        rewriting_keeps_the_rest(&io_format_exodus, b.data, b.size, *state);
        builder_release(&b);
    }
}

/** Read one element of a type that is not smoothed beside a tetrahedron; the error, if any, has part
 *  in it. */
static planish_file *read_other(const char *type, int width, const char *part) {
    static const int tetrahedron[] = {1, 2, 3, 4};
    double x[UNIT_NODES][3] = {{0}};
    int list[UNIT_NODES];
    netcdf_builder b;
    planish_file *file = NULL;
    planish_error error = {.text = ""};
    for (int i = 0; i < UNIT_NODES; i++)
        list[i] = i + 1;
    x[1][0] = x[2][1] = x[3][2] = 1;
    begin(&b, 1, 3, UNIT_NODES, x);
    netcdf_put_integers(&b, "eb_prop1", 2, 0, (const int[]){1, 2});
    put_block(&b, 1, type, 1, width, list);
    put_block(&b, 2, "TET4", 1, 4, tetrahedron);
    netcdf_put_integers(&b, "ss_prop1", 1, 0, (const int[]){1}); /* a side of no facet */
    netcdf_put_integers(&b, "elem_ss1", 1, 0, (const int[]){1});
    netcdf_put_integers(&b, "side_ss1", 1, 0, (const int[]){1});
    file_builder made = netcdf_end_file(&b);
    if (builder_read(&made, &io_format_exodus, 1, &file, &error))
        assert_non_null(strstr(error.text, part));
    builder_release(&made);
    return file;
}

static void other_types_hold_their_nodes(void **state) {
    static const struct {
        const char *type;
        int width, reason;
    } others[] = {{"SPHERE", 1, IO_HELD_BY_POINT},   {"CIRCLE", 1, IO_HELD_BY_POINT},
                  {"TRUSS2", 2, IO_HELD_BY_LINE},    {"Beam3", 3, IO_HELD_BY_LINE},
                  {"EDGE4", 4, IO_HELD_BY_OTHER},    {"TETRA8", 8, IO_HELD_BY_OTHER},
                  {"TETRA14", 14, IO_HELD_BY_OTHER}, {"TRI7", 7, IO_HELD_BY_OTHER},
                  {"TRI4", 4, IO_HELD_BY_OTHER},     {"QUAD5", 5, IO_HELD_BY_OTHER},
                  {"WEDGE21", 21, IO_HELD_BY_OTHER}, {"PYRAMID18", 18, IO_HELD_BY_OTHER},
                  {"HEX9", 9, IO_HELD_BY_OTHER},     {"HEXSHELL", 8, IO_HELD_BY_OTHER},
                  {"HEX", 3, IO_HELD_BY_OTHER},      {"SUPER", 12, IO_HELD_BY_OTHER},
                  {"TRI", 2, IO_HELD_BY_OTHER},      {"", 5, IO_HELD_BY_OTHER}};
    (void)state;
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        planish_file *file = read_other(others[i].type, others[i].width, "nothing");
        if (!file)
            fail_msg("%s %d", others[i].type, others[i].width);
        for (int node = 0; node < UNIT_NODES; node++)
            assert_int_equal(file->model.hold[node], node < others[i].width ? others[i].reason : 0);
        assert_int_equal(planish_file_element_number(file, 0), 2);
        planish_file_close(file);
    }
    assert_null(read_other("TRI10", 10, "third order"));
    assert_null(read_other("TETRA20", 20, "third order"));
    assert_null(read_other("BEX_HEX", 27, "Bezier"));
}

static void polygons_and_polyhedra_hold_their_nodes(void **state) {
    static const int tetrahedron[] = {1, 2, 3, 4}, nodes[] = {5, 6, 7, 6, 7, 8};
    (void)state;
    for (int solid = 0; solid < 2; solid++) {
        double x[UNIT_NODES][3] = {{0}};
        netcdf_builder b;
        x[1][0] = x[2][1] = x[3][2] = 1;
        begin(&b, 2, 3, 10, x);
        netcdf_put_integers(&b, "eb_prop1", 2, 0, (const int[]){1, 2});
        netcdf_put_integers(&b, "ebepecnt1", 2, 0, (const int[]){3, 3});
        if (solid) {
            netcdf_put_integers(&b, "fa_prop1", 1, 0, (const int[]){1});
            netcdf_put_integers(&b, "fbconn1", 6, 0, nodes);
            netcdf_put_integers(&b, "facconn1", 4, 0, (const int[]){1, 2, 1, 2});
        } else {
            put_block(&b, 1, "nsided", 6, 0, nodes);
        }
        put_block(&b, 2, "TET4", 1, 4, tetrahedron);
        file_builder made = netcdf_end_file(&b);
        planish_file *file = builder_file(&made, &io_format_exodus);
        for (int node = 0; node < 10; node++)
            assert_int_equal(file->model.hold[node], node > 3 && node < 8 ? IO_HELD_BY_OTHER : 0);
        assert_int_equal(planish_file_element_number(file, 0), 3);
        planish_file_close(file);
        builder_release(&made);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elements_of_every_type_are_read),
        cmocka_unit_test(sides_are_facets),
        cmocka_unit_test(shells_have_faces_and_edges),
        cmocka_unit_test(straight_blocks_hold_mids),
        cmocka_unit_test_setup_teardown(blocks_are_regions, test_folder_create, test_folder_remove),
        cmocka_unit_test(other_types_hold_their_nodes),
        cmocka_unit_test(polygons_and_polyhedra_hold_their_nodes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
