/* unit_elements: one element of each type, deformed so that a wrong order of its nodes shows. */
#include "support/unit_elements.h"

#include "support/reading.h"

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

int unit_is_simplex(int type) {
    return vtk_types[row_of(type)].corner == tetrahedron;
}

int unit_is_smoothed(int type) {
    return type != PLANISH_CELL_PYRAMID13 && type != PLANISH_CELL_PYRAMID14;
}

/** Bend space by so little that every element stays valid; planes of constant z stay planes where
 *  dim is 2. */
static void bend(int dim, const double at[3], double x[3]) {
    x[0] = at[0] + 0.1 * at[1] * at[1] + 0.15 * at[1] * at[2];
    x[1] = at[1] + 0.1 * at[0] * at[0] + 0.1 * at[0] * at[2];
    x[2] = at[2] + (dim == 3 ? 0.15 * at[0] * at[1] : 0);
}

int unit_places(int type, const char *nodes, double x[UNIT_NODES][3]) {
    const int row = row_of(type);
    const char first = *nodes;
    int n = 0;
    assert_true(first == '0' || first == '1');
    for (const char *at = nodes; *at; at += strspn(at, " "), n++) {
        const size_t length = strcspn(at, " ");
        double middle[3] = {0, 0, 0};
        for (size_t i = 0; i < length; i++)
            for (int d = 0; d < 3; d++)
                middle[d] += vtk_types[row].corner[at[i] - first][d] / (double)length;
        assert_true(n < UNIT_NODES);
        bend(vtk_types[row].dim, middle, x[n]);
        at += length;
    }
    return n;
}

void unit_swap(int type, int n, double x[UNIT_NODES][3]) {
    const int is_pyramid = vtk_types[row_of(type)].corner == pyramid;
    double *a = is_pyramid ? x[2] : x[n - 2], *b = is_pyramid ? x[3] : x[n - 1];
    for (int d = 0; d < 3; d++) {
        const double kept = a[d];
        a[d] = b[d];
        b[d] = kept;
    }
}

void unit_mirror(int n, double x[UNIT_NODES][3]) {
    for (int i = 0; i < n; i++)
        x[i][0] = -x[i][0];
}

/** Return the first of n nodes that is not at its place x, or n. */
static int misplaced(const planish_mesh *mesh, const int32_t *nodes, int n,
                     double x[UNIT_NODES][3]) {
    for (int k = 0; k < n; k++)
        for (int d = 0; nodes[k] >= 0 && d < mesh->dim; d++)
            if (!(fabs(mesh->coordinates[mesh->dim * nodes[k] + d] - x[k][d]) < 1e-6))
                return k;
    return n;
}

void unit_expect(planish_file *file, int64_t i, int type) {
    double expected[UNIT_NODES][3];
    const int n = unit_places(type, unit_vtk_nodes(type), expected);
    const planish_mesh mesh = planish_file_mesh(file);
    planish_cells cells;
    assert_int_equal(planish_file_cells(file, &cells, NULL), PLANISH_OK);
    assert_int_equal(mesh.dim, unit_dim(type));
    assert_true(i < cells.n);
    assert_int_equal(cells.type[i], type);
    assert_int_equal(cells.offset[i + 1] - cells.offset[i], n);
    const int32_t *nodes = cells.node + cells.offset[i];
    const int node = misplaced(&mesh, nodes, n, expected);
    unit_mirror(n, expected);
    if (node < n && misplaced(&mesh, nodes, n, expected) < n)
        fail_msg("type %d: node %d is not where VTK has it", type, node);
}

planish_cell_quality unit_measure(planish_file *file, int64_t n) {
    planish_mesh all = planish_file_mesh(file);
    planish_cells cells;
    planish_cell_quality quality;
    planish_error error = {.text = ""};
    assert_int_equal(planish_file_cells(file, &cells, NULL), PLANISH_OK);
    assert_int_equal(cells.n, n);
    all.elements = NULL;
    all.cells = &cells;
    all.n_elements = cells.n;
    if (planish_measure_cells(&all, 0, 1, &quality, NULL, &error))
        fail_msg("%s", error.text);
    assert_int_equal(quality.all.n_elements, n);
    assert_int_equal(quality.all.n_uncertified, 0);
    return quality;
}

void unit_expect_valid(planish_file *file, int64_t n) {
    assert_int_equal(unit_measure(file, n).all.n_inverted, 0);
}

void unit_expect_others(planish_file *file, int64_t n, int64_t n_held) {
    const planish_mesh mesh = planish_file_mesh(file);
    planish_cells cells;
    planish_file_info info;
    int64_t held = 0;
    planish_file_get_info(file, &info);
    assert_int_equal(planish_file_cells(file, &cells, NULL), PLANISH_OK);
    assert_int_equal(info.n_other_elements, n);
    assert_int_equal(mesh.n_elements, cells.n);
    for (int64_t i = 0; i < mesh.n_nodes; i++)
        held += file->model.hold[i] == IO_HELD_BY_OTHER;
    assert_int_equal(held, n_held);
}

void unit_expect_alone(planish_file *file, int type, int64_t number, int n_held, int is_valid) {
    planish_cells cells;
    assert_int_equal(unit_measure(file, 1).all.n_inverted, !is_valid);
    assert_int_equal(planish_file_cells(file, &cells, NULL), PLANISH_OK);
    assert_int_equal(cells.type[0], type);
    assert_int_equal(planish_file_element_number(file, 0), number);
    unit_expect_others(file, n_held > 0, n_held);
    planish_file_close(file);
}

static void expect_cell(const io_cells *cells, int dim, int64_t i, const int32_t *corners,
                        const int32_t *mids) {
    const int n_mids = dim * (dim + 1) / 2;
    assert_non_null(cells->mid);
    assert_memory_equal(cells->nodes + i * (dim + 1), corners, (size_t)(dim + 1) * sizeof *corners);
    assert_memory_equal(cells->mid + i * n_mids, mids, (size_t)n_mids * sizeof *mids);
}

const double unit_both_places[UNIT_BOTH_NODES][3] = {
    {0, 0, 0},   {1, 0, 0},   {0, 1, 0},   {0, 0, 1},   {1, 1, 1},  {.5, .5, 0},
    {0, .5, .5}, {.5, 0, .5}, {1, .5, .5}, {.5, 1, .5}, {.5, .5, 1}};

void unit_expect_held(const planish_file *file, const char *tag, const char *expected) {
    reading_holds(file, tag, 0, expected);
}

const double unit_brick_places[UNIT_BRICK_NODES][3] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0},
                                                       {1, 1, 0}, {2, 1, 0}, {0, 0, 1}, {1, 0, 1},
                                                       {2, 0, 1}, {0, 1, 1}, {1, 1, 1}, {2, 1, 1}};

/** Check the groups of the bricks. */
static void expect_brick_groups(planish_file *file, int dim, const char *facet,
                                const char *second) {
    static const char *const held[2][4] = {
        {"110010", "111011", "110010", "110000"},
        {"110110010010", "111111011011", "110110010010", "110110000000"}};
    double volume[2] = {-1, -1};
    const double least = 3;
    char region[64];
    planish_error error = {.text = ""};
    const char *const *const expected = held[dim - 2];
    reading_holds(file, NULL, READING_REGIONS, expected[0]);
    reading_holds(file, second, READING_REGIONS, expected[1]);
    reading_holds(file, facet, READING_REGIONS, expected[2]);
    reading_holds(file, facet, READING_REGIONS | READING_SLIDE, expected[3]);
    if (planish_file_min_volumes(file, &second, &least, 1, volume, &error))
        fail_msg("%s", error.text);
    assert_true(volume[0] == 0 && volume[1] == least);
    assert_true(planish_file_element_region(file, 1, region, sizeof region) > 0);
    assert_string_equal(region, second);
    const planish_hold slide = {.slide = 1, .slide_tags = &facet, .n_slide_tags = 1};
    const planish_surface surface = planish_file_surface(file, &slide);
    assert_true(surface.region && surface.region[0] != surface.region[1]);
    assert_true(surface.facet_tag && surface.tagged_only);
}

void unit_expect_bricks(planish_file *file, const char *facet, const char *second) {
    static const int32_t corner[2][8] = {{0, 1, 4, 3, 6, 7, 10, 9}, {1, 2, 5, 4, 7, 8, 11, 10}};
    const planish_mesh mesh = planish_file_mesh(file);
    const int dim = mesh.dim, n = dim == 3 ? 8 : 4, n_facet = dim == 3 ? 4 : 2;
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(mesh.n_elements, 2);
    assert_non_null(mesh.cells);
    assert_int_equal(info.n_other_elements, 0);
    assert_int_equal(info.n_lower_elements, facet != NULL);
    assert_int_equal(info.n_regions, second ? 2 : 1);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(mesh.cells->type[i],
                         dim == 3 ? PLANISH_CELL_HEXAHEDRON : PLANISH_CELL_QUADRILATERAL);
        assert_int_equal(mesh.cells->offset[i + 1] - mesh.cells->offset[i], n);
        for (int j = 0; j < n; j++) {
            int is_there = 0; /* in any order that is valid */
            for (int k = 0; k < n; k++)
                is_there |= mesh.cells->node[n * i + k] == corner[i][j];
            assert_true(is_there);
        }
    }
    unit_expect_valid(file, 2);
    if (!facet)
        return;
    expect_brick_groups(file, dim, facet, second);
    const planish_surface surface = planish_file_surface(file, NULL);
    assert_int_equal(surface.n_facets, 1);
    assert_int_equal(surface.facet_offset ? surface.facet_offset[1] : dim, n_facet);
    for (int j = 0; j < n_facet; j++) {
        int is_there = 0;
        for (int k = 0; k < n_facet; k++)
            is_there |= surface.facets[k] == corner[0][j];
        assert_true(is_there);
    }
}

void unit_expect_both_orders(const planish_file *file, int has_line) {
    static const int32_t straight[] = {0, 1, 2, 3}, none[] = {-1, -1, -1, -1, -1, -1},
                         curved[] = {1, 2, 3, 4}, mids[] = {5, 6, 7, 8, 9, 10},
                         triangle[] = {2, 3, 4}, triangle_mids[] = {6, 10, 9}, line[] = {3, 4},
                         line_mid[] = {10};
    const io_model *model = &file->model;
    const planish_mesh mesh = planish_file_mesh(file);
    assert_int_equal(mesh.n_nodes, 11);
    assert_int_equal(mesh.n_elements, 2);
    assert_non_null(mesh.cells);
    assert_int_equal(model->tetrahedron.n, 2);
    assert_int_equal(model->triangle.n, 1);
    assert_int_equal(model->line.n, has_line);
    const int is_first = model->tetrahedron.nodes[0] == 1; /* the one of second order */
    expect_cell(&model->tetrahedron, 3, is_first, straight, none);
    expect_cell(&model->tetrahedron, 3, !is_first, curved, mids);
    expect_cell(&model->triangle, 2, 0, triangle, triangle_mids);
    if (has_line)
        expect_cell(&model->line, 1, 0, line, line_mid);
    assert_int_equal(mesh.cells->type[is_first], PLANISH_CELL_TETRAHEDRON);
    assert_int_equal(mesh.cells->type[!is_first], PLANISH_CELL_TETRAHEDRON10);
}

void unit_expect_types(const io_format *format, const unit_element *elements, int n,
                       unit_make *make) {
    for (int i = 0; i < 4 * n; i++) {
        const int type = elements[i / 4].type, is_other = !unit_is_smoothed(type);
        double x[UNIT_NODES][3];
        planish_file *file;
        planish_error error = {.text = ""};
        int64_t number = -1;
        const int m = unit_places(type, elements[i / 4].nodes, x);
        if (i & 1)
            unit_mirror(m, x);
        file_builder b = make(i / 4, m, x, i >> 1 & 1, &number);
        if (builder_read(&b, format, 1, &file, &error))
            fail_msg("type %d: %s", type, error.text);
        for (int k = 0; k < 2; k++)
            unit_expect(file, k, type);
        unit_expect_valid(file, 2);
        unit_expect_others(file, is_other ? 2 : 0, is_other ? m : 0);
        assert_int_equal(planish_file_element_number(file, 1), number);
        planish_file_close(file);
        builder_release(&b);
    }
}
