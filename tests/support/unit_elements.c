/* unit_elements: one element of each type, deformed so that a wrong order of its nodes shows. */
#include "support/unit_elements.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define TRIANGLE      "0 1 2"
#define QUADRILATERAL "0 1 2 3"
#define TETRAHEDRON   "0 1 2 3"
#define PYRAMID       "0 1 2 3 4"
#define WEDGE         "0 1 2 3 4 5"
#define HEXAHEDRON    "0 1 2 3 4 5 6 7"
#define HEXAHEDRON20  HEXAHEDRON " 01 12 23 30 45 56 67 74 04 15 26 37"
#define WEDGE15       WEDGE " 01 12 20 34 45 53 03 14 25"
#define PYRAMID13     PYRAMID " 01 12 23 30 04 14 24 34"

static const double quadrilateral[][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
static const double tetrahedron[][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
static const double pyramid[][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 0.75}};
static const double wedge[][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
static const double hexahedron[][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                       {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};

/** VTK's types, from its documentation. */
static const struct {
    int type, dim;
    const double (*corner)[3];
    const char *nodes;
} vtk_types[] = {
    {PLANISH_CELL_TRIANGLE, 2, tetrahedron, TRIANGLE},
    {PLANISH_CELL_TRIANGLE6, 2, tetrahedron, TRIANGLE " 01 12 20"},
    {PLANISH_CELL_QUADRILATERAL, 2, quadrilateral, QUADRILATERAL},
    {PLANISH_CELL_QUADRILATERAL8, 2, quadrilateral, QUADRILATERAL " 01 12 23 30"},
    {PLANISH_CELL_QUADRILATERAL9, 2, quadrilateral, QUADRILATERAL " 01 12 23 30 0123"},
    {PLANISH_CELL_TETRAHEDRON, 3, tetrahedron, TETRAHEDRON},
    {PLANISH_CELL_TETRAHEDRON10, 3, tetrahedron, TETRAHEDRON " 01 12 20 03 13 23"},
    {PLANISH_CELL_PYRAMID, 3, pyramid, PYRAMID},
    {PLANISH_CELL_PYRAMID13, 3, pyramid, PYRAMID13},
    {PLANISH_CELL_PYRAMID14, 3, pyramid, PYRAMID13 " 0123"},
    {PLANISH_CELL_WEDGE, 3, wedge, WEDGE},
    {PLANISH_CELL_WEDGE15, 3, wedge, WEDGE15},
    {PLANISH_CELL_WEDGE18, 3, wedge, WEDGE15 " 0143 1254 2035"},
    {PLANISH_CELL_HEXAHEDRON, 3, hexahedron, HEXAHEDRON},
    {PLANISH_CELL_HEXAHEDRON20, 3, hexahedron, HEXAHEDRON20},
    {PLANISH_CELL_HEXAHEDRON27, 3, hexahedron,
     HEXAHEDRON20 " 0473 1265 0154 3762 0123 4567 01234567"},
};

static int row_of(int type) {
    for (size_t i = 0; i < sizeof vtk_types / sizeof *vtk_types; i++)
        if (vtk_types[i].type == type)
            return (int)i;
    fail_msg("no type %d", type);
    return 0;
}

const char *unit_vtk_nodes(int type) {
    return vtk_types[row_of(type)].nodes;
}

int unit_dim(int type) {
    return vtk_types[row_of(type)].dim;
}

/** Bend space by so little that every element stays valid; planes of constant z stay planes where
 *  dim is 2. */
static void bend(int dim, const double at[3], double x[3]) {
    x[0] = at[0] + 0.1 * at[1] * at[1] + (dim == 3 ? 0.05 * at[2] : 0);
    x[1] = at[1] - 0.06 * at[0] * at[0] + (dim == 3 ? 0.1 * at[2] * at[2] : 0);
    x[2] = dim == 3 ? at[2] + 0.08 * at[0] * at[0] : 0;
}

int unit_places(int type, const char *nodes, double x[UNIT_NODES][3]) {
    const int row = row_of(type);
    int n = 0;
    for (const char *at = nodes; *at; at += strspn(at, " "), n++) {
        const size_t length = strcspn(at, " ");
        double middle[3] = {0, 0, 0};
        for (size_t i = 0; i < length; i++)
            for (int d = 0; d < 3; d++)
                middle[d] += vtk_types[row].corner[at[i] - '0'][d] / (double)length;
        assert_true(n < UNIT_NODES);
        bend(vtk_types[row].dim, middle, x[n]);
        at += length;
    }
    return n;
}

void unit_expect(planish_file *file, int64_t i, int type) {
    double expected[UNIT_NODES][3];
    const int n = unit_places(type, unit_vtk_nodes(type), expected);
    const planish_mesh mesh = planish_file_mesh(file);
    planish_cells cells;
    assert_int_equal(planish_file_cells(file, &cells, NULL), PLANISH_OK);
    assert_true(i < cells.n);
    assert_int_equal(cells.type[i], type);
    assert_int_equal(cells.offset[i + 1] - cells.offset[i], n);
    for (int k = 0; k < n; k++) {
        const int32_t node = cells.node[cells.offset[i] + k];
        for (int d = 0; node >= 0 && d < mesh.dim; d++)
            if (!(fabs(mesh.coordinates[mesh.dim * node + d] - expected[k][d]) < 1e-6))
                fail_msg("type %d: node %d is not where VTK has it", type, k);
    }
}

void unit_expect_valid(planish_file *file, int64_t n) {
    const planish_mesh mesh = planish_file_mesh(file);
    planish_cells cells;
    planish_cell_quality quality;
    planish_error error = {.text = ""};
    assert_int_equal(planish_file_cells(file, &cells, NULL), PLANISH_OK);
    assert_int_equal(cells.n, n);
    planish_mesh all = mesh;
    all.elements = NULL;
    all.cells = &cells;
    all.n_elements = all.cells->n;
    if (planish_measure_cells(&all, 0, 1, &quality, NULL, &error))
        fail_msg("%s", error.text);
    assert_int_equal(quality.all.n_elements, n);
    assert_int_equal(quality.all.n_inverted, 0);
    assert_int_equal(quality.all.n_uncertified, 0);
}
