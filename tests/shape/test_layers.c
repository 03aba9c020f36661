/* planish_find_layers: layers of known meshes, to the element; nothing in meshes that are bad by
 * chance. */
#include "support/allocations.h"
#include "support/meshes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { CELLS = 10 };

/** Marks [n_elements], to be freed; *n (may be NULL) are ones. */
static uint8_t *find(const planish_mesh *mesh, int threads, int64_t *n) {
    uint8_t *is_layer = malloc((size_t)mesh->n_elements + 1);
    int64_t count = -1, ones = 0;
    planish_error error = {.text = ""};
    assert_non_null(is_layer);
    memset(is_layer, 7, (size_t)mesh->n_elements + 1);
    if (planish_find_layers(mesh, threads, is_layer, &count, &error))
        fail_msg("%s", error.text);
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        assert_true(is_layer[i] <= 1);
        ones += is_layer[i];
    }
    assert_int_equal(is_layer[mesh->n_elements], 7);
    assert_int_equal(count, ones);
    if (n)
        *n = count;
    return is_layer;
}

static int64_t count(const planish_mesh *mesh) {
    int64_t n;
    free(find(mesh, 1, &n));
    return n;
}

/* ---- boxes with layers ---------------------------------------------------------------------- */

/** Which cell of the box of unit cells, in direction d, an element is in. */
static int cell_of(const test_mesh *box, int64_t element, int d) {
    const int dim = box->mesh.dim;
    double lowest = CELLS;
    for (int j = 0; j <= dim; j++)
        lowest = fmin(lowest, box->coordinates[box->elements[element * (dim + 1) + j] * dim + d]);
    return (int)lowest;
}

/** Give the cells of direction d the heights [CELLS]. */
static void set_heights(test_mesh *box, int d, const double *height) {
    double level[CELLS + 1] = {0};
    for (int k = 0; k < CELLS; k++)
        level[k + 1] = level[k] + height[k];
    for (int64_t i = 0; i < box->mesh.n_nodes; i++) {
        double *x = &box->coordinates[i * box->mesh.dim + d];
        *x = level[(int)*x];
    }
}

/** Heights of n layers that grow, and of cubes. */
static void fill_heights(double *height, int n, double first, double growth) {
    for (int k = 0; k < CELLS; k++)
        height[k] = k < n ? fmin(first * pow(growth, k), 1) : 1;
}

/** Whether an element of a cell of that height, 1 wide, has edges in a ratio of 4: its longest is
 *  the cell's diagonal. */
static int is_thin(int dim, double height) {
    return sqrt(dim - 1 + height * height) >= 4 * height;
}

/** Whether rows of that height go on from those that are thin, among which is the first. */
static int is_row(double height) {
    return 1 >= 1.2 * height;
}

/** Fails the test unless exactly the elements of the cells of the last direction that are thin, or
 *  of rows that go on, are found. */
static void check_heights(int dim, const double *height) {
    const int has_rows = is_thin(dim, height[0]);
    test_mesh box;
    test_mesh_box(&box, dim, CELLS);
    const int64_t n = box.mesh.n_elements;
    uint8_t *expected = malloc((size_t)n);
    for (int64_t i = 0; i < n; i++)
        expected[i] = (uint8_t)(has_rows && is_row(height[cell_of(&box, i, dim - 1)]));
    set_heights(&box, dim - 1, height);
    uint8_t *is_layer = find(&box.mesh, 1, NULL);
    assert_memory_equal(is_layer, expected, (size_t)n);
    free(is_layer);
    free(expected);
    test_mesh_destroy(&box);
}

/** One layer, several, as many as there are; thin and thinner; none that is thin. */
static void layers_on_a_wall_are_found(void **state) {
    (void)state;
    static const int numbers[] = {1, 2, 3, 5, CELLS};
    static const double firsts[] = {0.3, 0.2, 0.05, 1e-3, 1e-9};
    double height[CELLS];
    for (int dim = 2; dim <= 3; dim++)
        for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
            for (size_t k = 0; k < sizeof firsts / sizeof *firsts; k++) {
                fill_heights(height, numbers[i], firsts[k], 1);
                check_heights(dim, height);
            }
}

/** All rows up to the one that is about as high as wide, of which most are not thin. */
static void layers_may_grow(void **state) {
    (void)state;
    static const double growths[] = {1.2, 1.3, 1.5, 2}, firsts[] = {0.01, 0.1, 0.2};
    double height[CELLS];
    for (int dim = 2; dim <= 3; dim++)
        for (size_t i = 0; i < sizeof growths / sizeof *growths; i++)
            for (size_t k = 0; k < sizeof firsts / sizeof *firsts; k++) {
                fill_heights(height, CELLS, firsts[k], growths[i]);
                check_heights(dim, height);
            }
    assert_true(is_row(height[2]) && !is_thin(3, height[2]) && !is_row(height[3]));
}

/** From the thin rows in the middle to both sides, as far as they go along. */
static void rows_go_on_to_both_sides(void **state) {
    (void)state;
    static const double height[CELLS] = {1, 0.3, 0.8, 0.6, 0.4, 0.2, 0.2, 0.4, 1.1, 0.5};
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        test_mesh_box(&box, dim, CELLS);
        const int64_t n = box.mesh.n_elements;
        uint8_t *expected = malloc((size_t)n);
        for (int64_t i = 0; i < n; i++) {
            const int cell = cell_of(&box, i, dim - 1);
            expected[i] = (cell >= 2 && cell <= 7) || is_thin(dim, height[cell]);
        }
        set_heights(&box, dim - 1, height);
        uint8_t *is_layer = find(&box.mesh, 1, NULL);
        for (int64_t i = 0; i < n; i++)
            assert_int_equal(is_layer[i], expected[i]);
        free(is_layer);
        free(expected);
        test_mesh_destroy(&box);
    }
}

/** On two walls at right angles: all elements that are thin in one direction only, but for some at
 *  the block of small cubes where the layers meet. */
static void corners_have_layers(void **state) {
    (void)state;
    enum { LAYERS = 3 };
    double height[CELLS];
    fill_heights(height, LAYERS, 0.1, 1);
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        test_mesh_box(&box, dim, CELLS);
        const int64_t n = box.mesh.n_elements;
        int *n_thin = calloc((size_t)n, sizeof *n_thin);
        uint8_t *is_near = calloc((size_t)n, 1);
        for (int64_t i = 0; i < n; i++) {
            const int cell[2] = {cell_of(&box, i, 0), cell_of(&box, i, 1)};
            n_thin[i] = (cell[0] < LAYERS) + (cell[1] < LAYERS);
            is_near[i] = cell[0] <= LAYERS && cell[1] <= LAYERS;
        }
        for (int d = 0; d < 2; d++)
            set_heights(&box, d, height);
        uint8_t *is_layer = find(&box.mesh, 1, NULL);
        for (int64_t i = 0; i < n; i++)
            if (!is_near[i])
                assert_int_equal(is_layer[i], n_thin[i]);
        free(is_layer);
        free(is_near);
        free(n_thin);
        test_mesh_destroy(&box);
    }
}

/** Bend the box to so much of a ring of layers, whose inner wall has edges about 1 long. */
static void bend(test_mesh *box, double whole_angle) {
    const int dim = box->mesh.dim;
    for (int64_t i = 0; i < box->mesh.n_nodes; i++) {
        double *x = box->coordinates + i * dim;
        const double angle = x[0] * whole_angle / CELLS, radius = CELLS / whole_angle + x[dim - 1];
        x[0] = radius * cos(angle);
        x[dim - 1] = radius * sin(angle);
    }
}

/** The box bent to a half of a ring: the layers' directions turn. Then to a ring of ten corners, as
 *  a coarse mesh has them: by 36 degrees from edge to edge. Thin layers, and those that grow. */
static void walls_may_be_curved(void **state) {
    (void)state;
    static const double PI = 3.14159265358979323846, growths[] = {1, 1.3};
    double height[CELLS];
    for (int dim = 2; dim <= 3; dim++)
        for (int turns = 1; turns <= 2; turns++)
            for (int i = 0; i < 2; i++) {
                test_mesh box;
                test_mesh_box(&box, dim, CELLS);
                fill_heights(height, CELLS, 0.06, growths[i]);
                set_heights(&box, dim - 1, height);
                bend(&box, turns * PI);
                assert_int_equal(count(&box.mesh), box.mesh.n_elements);
                test_mesh_destroy(&box);
            }
}

/** Whether the mesh has elements whose edges differ by the factor. */
static int has_edge_ratio(const planish_mesh *mesh, double ratio) {
    planish_quality quality;
    planish_options options;
    planish_options_init(&options);
    options.threads = 1;
    assert_int_equal(planish_measure_mesh(mesh, &options, &quality, NULL), 0);
    return quality.edge_ratio.max >= ratio;
}

/** A mesh without edges across that is stretched as a whole, in any direction: all of its elements
 *  are thin. The same mesh before is not. */
static void stretched_meshes_are_layers_throughout(void **state) {
    (void)state;
    static const double factors[] = {1, 0.05, 1e-3, 1e-6}, turns[] = {0, 0.7, 1.5};
    for (int dim = 2; dim <= 3; dim++)
        for (size_t i = 0; i < 4; i++)
            for (size_t k = 0; k < 3; k++) {
                test_mesh box;
                test_mesh_box(&box, dim, CELLS);
                test_mesh_perturb(&box, 0.14, 7);
                for (int64_t j = 0; j < box.mesh.n_nodes; j++) {
                    double *x = box.coordinates + j * dim;
                    /* a general linear map of the box: none of its edges goes across */
                    const double a = x[0], b = x[dim - 1];
                    const double z = factors[i] * (0.62 * a + 0.78 * b), y = 0.78 * a - 0.62 * b;
                    x[0] = cos(turns[k]) * y - sin(turns[k]) * z;
                    x[dim - 1] = sin(turns[k]) * y + cos(turns[k]) * z;
                }
                const int64_t n = count(&box.mesh);
                if (i == 0)
                    assert_int_equal(n, 0);
                else
                    assert_true((double)n >= 0.9 * (double)box.mesh.n_elements);
                test_mesh_destroy(&box);
            }
}

/** Slices around an axis: their short edges are one chain around it. */
static void chains_of_short_edges_are_no_layers(void **state) {
    (void)state;
    static const int32_t numbers[] = {30, 100, 1000};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        test_mesh pyramid;
        test_mesh_double_pyramid(&pyramid, numbers[i]);
        assert_true(has_edge_ratio(&pyramid.mesh, 4));
        assert_int_equal(count(&pyramid.mesh), 0);
        test_mesh_destroy(&pyramid);
    }
}

/* ---- other meshes --------------------------------------------------------------------------- */

/** Nodes that have come near to one of their neighbours, here and there: short edges that have no
 *  company. */
static void short_edges_alone_are_no_layers(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        test_mesh_box(&box, dim, CELLS);
        for (int64_t i = 0; i < box.mesh.n_nodes; i++) {
            double *x = box.coordinates + i * dim;
            int is_chosen = 1;
            for (int d = 0; d < dim; d++)
                is_chosen &= x[d] > 0 && x[d] < CELLS && (int)x[d] % 3 == 1;
            x[0] += is_chosen ? 0.9 : 0;
        }
        assert_true(has_edge_ratio(&box.mesh, 10));
        assert_int_equal(count(&box.mesh), 0);
        test_mesh_destroy(&box);
    }
}

/** Of random meshes, tangled ones among them, many elements are thin but next to none in layers. */
static void chance_makes_no_layers(void **state) {
    (void)state;
    static const double amounts[] = {0.15, 0.3, 0.6, 1, 2};
    for (int dim = 2; dim <= 3; dim++)
        for (size_t i = 0; i < sizeof amounts / sizeof *amounts; i++) {
            test_mesh box;
            test_mesh_box(&box, dim, dim == 3 ? 14 : 60);
            test_mesh_perturb(&box, amounts[i], 3);
            assert_true(i < 2 || has_edge_ratio(&box.mesh, 8));
            const int64_t n = count(&box.mesh);
            assert_true((double)n <= (i < 2 ? 0 : 0.01) * (double)box.mesh.n_elements);
            test_mesh_destroy(&box);
        }
}

/** Four nodes near a circle's quarters, flat, and their neighbours over and under them. */
static void slivers_are_no_layers(void **state) {
    (void)state;
    static const double x[] = {1, 0,  1e-3,  0, 1, -1e-3, -1, 0, 1e-3,
                               0, -1, -1e-3, 0, 0, 1,     0,  0, -1};
    static const int32_t elements[] = {0, 1, 2, 3, 0, 1, 2, 4, 0, 2, 3, 4, 0, 1, 3, 5, 1, 2, 3, 5};
    test_mesh slivers, more;
    test_mesh_create(&slivers, 3, 6, x, 5, elements);
    for (int i = 1; i < 20; i++) {
        test_mesh_create(&more, 3, 6, x, 5, elements);
        test_mesh_append(&slivers, &more, i);
        test_mesh_destroy(&more);
    }
    assert_int_equal(count(&slivers.mesh), 0);
    test_mesh_destroy(&slivers);
}

/** Isotropic cells that grow towards a corner in all directions. */
static void grading_makes_no_layers(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        test_mesh_box(&box, dim, CELLS);
        for (int64_t i = 0; i < box.mesh.n_nodes; i++) {
            double *x = box.coordinates + i * dim, farthest = 0, factor;
            for (int d = 0; d < dim; d++)
                farthest = fmax(farthest, x[d]);
            factor = farthest > 0 ? pow(1.3, farthest) / farthest : 0;
            for (int d = 0; d < dim; d++)
                x[d] *= factor;
        }
        assert_int_equal(count(&box.mesh), 0);
        test_mesh_destroy(&box);
    }
}

/** Edges without a length have no direction; nodes at one place say nothing of others. */
static void collapsed_elements_are_none(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        test_mesh_box(&box, dim, 4);
        for (int64_t i = 0; i < box.mesh.n_nodes; i++)
            box.coordinates[i * dim] = 0;
        (void)count(&box.mesh);
        for (int64_t i = 0; i < box.mesh.n_nodes * dim; i++)
            box.coordinates[i] = 0;
        assert_int_equal(count(&box.mesh), 0);
        test_mesh_destroy(&box);
    }
}

/* ---- promises ------------------------------------------------------------------------------- */

/** A box with layers that are a little uneven and grow, some of whose elements are found. */
static void create_uneven(test_mesh *box, int dim) {
    enum { LAYERS = 4 };
    const double first = 0.15, growth = 1.3;
    const double top = first * (pow(growth, LAYERS) - 1) / (growth - 1);
    test_mesh_box(box, dim, CELLS);
    test_mesh_perturb(box, 0.1, 2);
    for (int64_t i = 0; i < box->mesh.n_nodes; i++) {
        double *x = &box->coordinates[i * dim + dim - 1];
        *x = *x < LAYERS ? first * (pow(growth, *x) - 1) / (growth - 1) : *x - LAYERS + top;
    }
    test_mesh_renumber(box, 5, NULL);
}

static void threads_do_not_change_the_marks(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        int64_t n, other_n;
        create_uneven(&box, dim);
        uint8_t *is_layer = find(&box.mesh, 1, &n);
        assert_true(n > box.mesh.n_elements / 10 && n < box.mesh.n_elements / 2);
        for (int threads = 2; threads <= 7; threads++) {
            uint8_t *other = find(&box.mesh, threads, &other_n);
            assert_memory_equal(is_layer, other, (size_t)box.mesh.n_elements);
            free(other);
        }
        free(is_layer);
        test_mesh_destroy(&box);
    }
}

/** Nor does the unit of length, as far as doubles go. */
static void scale_does_not_matter(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        create_uneven(&box, dim);
        uint8_t *is_layer = find(&box.mesh, 1, NULL);
        for (int exponent = -1000; exponent <= 1000; exponent += 250) {
            test_mesh_transform(&box, ldexp(1, exponent), 0);
            uint8_t *other = find(&box.mesh, 1, NULL);
            assert_memory_equal(is_layer, other, (size_t)box.mesh.n_elements);
            free(other);
            test_mesh_transform(&box, ldexp(1, -exponent), 0);
        }
        free(is_layer);
        test_mesh_destroy(&box);
    }
}

/** Coordinates with gaps, components apart, elements of 64 bits. */
static void arrays_may_have_other_forms(void **state) {
    (void)state;
    enum { STRIDE = 5 };
    test_mesh box;
    create_uneven(&box, 3);
    planish_mesh mesh = box.mesh;
    uint8_t *is_layer = find(&mesh, 1, NULL);
    const int64_t n = mesh.n_nodes, corners = mesh.n_elements * 4;
    double *wide = calloc((size_t)(n * STRIDE), sizeof *wide);
    int64_t *elements = calloc((size_t)corners, sizeof *elements);
    for (int64_t i = 0; i < corners; i++)
        elements[i] = box.elements[i];
    mesh.elements = NULL;
    mesh.elements64 = elements;
    mesh.coordinates = wide;
    for (int apart = 0; apart < 2; apart++) {
        mesh.node_stride = apart ? 1 : STRIDE;
        mesh.component_stride = apart ? n : 1;
        for (int64_t i = 0; i < n; i++)
            for (int d = 0; d < 3; d++)
                wide[i * mesh.node_stride + d * mesh.component_stride] = box.coordinates[i * 3 + d];
        uint8_t *other = find(&mesh, 1, NULL);
        assert_memory_equal(is_layer, other, (size_t)mesh.n_elements);
        free(other);
    }
    free(elements);
    free(wide);
    free(is_layer);
    test_mesh_destroy(&box);
}

/** Thousands of elements at the ends of one edge, which all are thin: they are told all the same.
 */
static void nodes_may_have_many_elements(void **state) {
    (void)state;
    test_mesh pyramid;
    test_mesh_double_pyramid(&pyramid, 5000);
    int64_t n, other_n;
    uint8_t *is_layer = find(&pyramid.mesh, 1, &n);
    uint8_t *other = find(&pyramid.mesh, 3, &other_n);
    assert_int_equal(n, 0); /* slices, whose short edges are one chain */
    assert_memory_equal(is_layer, other, (size_t)n);
    free(other);
    free(is_layer);
    test_mesh_destroy(&pyramid);
}

/* ---- elements of any types ------------------------------------------------------------------ */

static const int layer_types[] = {PLANISH_CELL_QUADRILATERAL, PLANISH_CELL_QUADRILATERAL8,
                                  PLANISH_CELL_HEXAHEDRON,    PLANISH_CELL_HEXAHEDRON20,
                                  PLANISH_CELL_WEDGE,         PLANISH_CELL_WEDGE15};
enum { N_LAYER_TYPES = sizeof layer_types / sizeof *layer_types };

static uint8_t *find_in_cells(const test_cells *m, int threads, int64_t *n) {
    planish_mesh mesh = m->mesh;
    mesh.cells = &m->cells;
    return find(&mesh, threads, n);
}

/** Give the rows heights, as set_heights does for simplices. */
static void set_rows(test_cells *m, int d, const double *height) {
    test_mesh box = {.mesh = m->mesh, .coordinates = m->coordinates};
    set_heights(&box, d, height);
}

/** Whether a row is in the layer: one begins with those at most a quarter as high as wide. */
static int is_in_layer(const double *height, int row) {
    return row < CELLS && 4 * height[0] <= 1 && is_row(height[row]);
}

/** Layers that grow, and stay alike, of any number of rows, with simplices behind or without. */
static void layers_of_other_elements_are_found(void **state) {
    (void)state;
    static const double firsts[] = {0.26, 0.2, 0.02, 1e-7}, growths[] = {1, 1.5};
    double height[CELLS];
    for (int t = 0; t < N_LAYER_TYPES; t++)
        for (int i = 0; i < 4; i++)
            for (int k = 0; k < 2; k++)
                for (int n_rows = 1; n_rows <= CELLS; n_rows += 3) {
                    test_cells m;
                    test_cells_box(&m, CELLS, layer_types[t], n_rows);
                    fill_heights(height, n_rows, firsts[i], growths[k]);
                    set_rows(&m, m.mesh.dim - 1, height);
                    uint8_t *is_layer = find_in_cells(&m, 1, NULL);
                    for (int64_t e = 0; e < m.cells.n; e++)
                        assert_int_equal(is_layer[e], is_in_layer(height, m.row[e]));
                    free(is_layer);
                    test_cells_destroy(&m);
                }
}

/** Rows go on from elements with uprights into simplices, whose shortest edges go along. */
static void rows_go_on_into_simplices(void **state) {
    (void)state;
    double height[CELLS];
    for (int t = 0; t < N_LAYER_TYPES; t++) {
        test_cells m;
        test_cells_box(&m, CELLS, layer_types[t], 2);
        fill_heights(height, CELLS, 0.1, 1.3);
        set_rows(&m, m.mesh.dim - 1, height);
        uint8_t *is_layer = find_in_cells(&m, 1, NULL);
        for (int64_t e = 0; e < m.cells.n; e++)
            assert_int_equal(is_layer[e], is_in_layer(height, m.row[e]));
        free(is_layer);
        test_cells_destroy(&m);
    }
}

/** The directions of layers turn, by 18 and 36 degrees from cell to cell, and at a right angle. */
static void layers_of_other_elements_go_around_corners(void **state) {
    (void)state;
    enum { LAYERS = 3 };
    static const double PI = 3.14159265358979323846;
    double height[CELLS];
    for (int t = 0; t < N_LAYER_TYPES; t++)
        for (int turns = 1; turns <= 2; turns++) {
            test_cells m;
            int64_t n;
            test_cells_box(&m, CELLS, layer_types[t], CELLS);
            fill_heights(height, CELLS, 0.06, 1.2);
            set_rows(&m, m.mesh.dim - 1, height);
            test_mesh box = {.mesh = m.mesh, .coordinates = m.coordinates};
            bend(&box, turns * PI);
            free(find_in_cells(&m, 1, &n));
            assert_int_equal(n, m.cells.n - 1); /* but the line */
            test_cells_destroy(&m);
        }
    fill_heights(height, LAYERS, 0.1, 1);
    for (int dim = 2; dim <= 3; dim++) {
        test_cells m;
        test_cells_box(&m, CELLS, dim == 3 ? PLANISH_CELL_HEXAHEDRON : PLANISH_CELL_QUADRILATERAL,
                       CELLS);
        for (int d = 0; d < dim; d += dim - 1)
            set_rows(&m, d, height);
        uint8_t *is_layer = find_in_cells(&m, 1, NULL);
        for (int64_t e = 1; e < m.cells.n; e++)
            assert_int_equal(is_layer[e], ((e - 1) % CELLS < LAYERS) != (m.row[e] < LAYERS));
        free(is_layer);
        test_cells_destroy(&m);
    }
}

/** Move the inner nodes at random, by amount of a unit in each direction. */
static void perturb_cells(test_cells *m, double amount, double amount_across, unsigned seed) {
    const int dim = m->mesh.dim;
    for (int64_t i = 0; i < m->mesh.n_nodes; i++)
        for (int d = 0; d < dim; d++)
            m->coordinates[i * dim + d] +=
                (d == dim - 1 ? amount_across : amount) * (2 * test_random(&seed) - 1);
}

/** Thin elements of a tangled layer, of a sheared one, and of a bad mesh: by chance. */
static void badly_shaped_elements_are_in_no_layers(void **state) {
    (void)state;
    double height[CELLS];
    fill_heights(height, CELLS, 0.1, 1);
    for (int t = 0; t < N_LAYER_TYPES; t++)
        for (int how = 0; how < 8; how++) {
            test_cells m;
            int64_t n;
            test_cells_box(&m, CELLS, layer_types[t], CELLS);
            const int dim = m.mesh.dim;
            if (how < 2) {
                set_rows(&m, dim - 1, height);
                free(find_in_cells(&m, 1, &n));
                assert_int_equal(n, m.cells.n - 1);
            }
            if (how == 0)
                perturb_cells(&m, 0, 0.2, 5);
            for (int64_t i = 0; how == 1 && i < m.mesh.n_nodes; i++)
                m.coordinates[i * dim] += 5 * m.coordinates[i * dim + dim - 1];
            if (how > 1)
                perturb_cells(&m, 0.25 * how, 0.25 * how, 3 + (unsigned)how);
            free(find_in_cells(&m, 1, &n));
            assert_int_equal(n, 0);
            test_cells_destroy(&m);
        }
}

/** Four thin squares are none, nine are. */
static void a_layer_has_some_elements(void **state) {
    (void)state;
    for (int cells = 2; cells <= 3; cells++) {
        test_cells m;
        int64_t n;
        test_cells_box(&m, cells, PLANISH_CELL_QUADRILATERAL, cells);
        for (int64_t i = 0; i < m.mesh.n_nodes; i++)
            m.coordinates[i * 2 + 1] *= 0.1;
        free(find_in_cells(&m, 1, &n));
        assert_int_equal(n, cells == 3 ? 9 : 0);
        test_cells_destroy(&m);
    }
}

/** A badly shaped element of a layer is not in it; others are. */
static void one_bad_element_leaves_a_layer(void **state) {
    (void)state;
    double height[CELLS];
    fill_heights(height, CELLS, 0.1, 1);
    test_cells m;
    test_cells_box(&m, CELLS, PLANISH_CELL_HEXAHEDRON, CELLS);
    set_rows(&m, 2, height);
    const int64_t middle = 5 * CELLS * CELLS + 5 * CELLS + 5 + 1;
    const int32_t node = m.node[m.offset[middle] + 6];
    m.coordinates[node * 3 + 2] -= 0.12; /* below its lower face, and so in the one above */
    int64_t n;
    uint8_t *is_layer = find_in_cells(&m, 1, &n);
    assert_int_equal(is_layer[middle], 0);
    assert_true(n >= m.cells.n - 1 - 8 && n < m.cells.n - 1);
    free(is_layer);
    test_cells_destroy(&m);
}

enum { COLUMNS = 19, ROWS = 10, N_PLANE = (COLUMNS + 1) * (ROWS + 1) + 1 };

/** Rows of quadrilaterals ten times as long as high, and triangles from their ends to one node, drawn to
 *  hexahedra and wedges of a thickness. */
typedef struct drawn_layer {
    planish_mesh mesh;
    planish_cells cells;
    double x[(2 * N_PLANE + 1) * 3]; /* the last node is in no element */
    int32_t node[COLUMNS * ROWS * 8 + ROWS * 6];
    int64_t offset[COLUMNS * ROWS + ROWS + 1];
    uint8_t type[COLUMNS * ROWS + ROWS];
} drawn_layer;

static void place_nodes(drawn_layer *m, double thickness, double height) {
    for (int i = 0; i < 2 * N_PLANE; i++) {
        const int in_plane = i % N_PLANE, is_tip = in_plane == N_PLANE - 1;
        m->x[3 * i] = is_tip ? COLUMNS + 1 : in_plane / (ROWS + 1);
        m->x[3 * i + 1] = is_tip ? 0.5 : height * (in_plane % (ROWS + 1));
        m->x[3 * i + 2] = i / N_PLANE * thickness * (1 + 1e-9 * (i % 7)); /* as if it was rounded */
        m->x[3 * i + 2] += i % 5 * 1e-9 * thickness;
    }
    m->x[2 * N_PLANE * 3 + 2] = 5;
}

static void create_drawn(drawn_layer *m, double thickness) {
    memset(m, 0, sizeof *m);
    place_nodes(m, thickness, 0.1);
    for (int i = 0; i < (COLUMNS + 1) * ROWS; i++) {
        const int at = i / ROWS * (ROWS + 1) + i % ROWS, is_end = i / ROWS == COLUMNS;
        const int around[] = {at, at + ROWS + 1, at + ROWS + 2, at + 1};
        const int to_tip[] = {at, N_PLANE - 1, at + 1};
        const int corners = is_end ? 3 : 4;
        for (int j = 0; j < 2 * corners; j++)
            m->node[m->offset[i] + j] =
                (is_end ? to_tip : around)[j % corners] + (j >= corners ? N_PLANE : 0);
        m->type[i] = is_end ? PLANISH_CELL_WEDGE : PLANISH_CELL_HEXAHEDRON;
        m->offset[i + 1] = m->offset[i] + 2 * corners;
    }
    m->cells = (planish_cells){
        .n = COLUMNS * ROWS + ROWS, .type = m->type, .offset = m->offset, .node = m->node};
    m->mesh = (planish_mesh){.dim = 3,
                             .n_nodes = 2 * N_PLANE + 1,
                             .n_elements = m->cells.n,
                             .coordinates = m->x,
                             .cells = &m->cells};
}

/** Valid slivers at the end of a layer leave it as it is, though they are one for each row. */
static void slivers_at_the_end_leave_a_layer(void **state) {
    (void)state;
    static drawn_layer m;
    create_drawn(&m, 1);
    uint8_t *is_layer = find(&m.mesh, 1, NULL);
    for (int64_t i = 0; i < m.cells.n; i++)
        assert_int_equal(is_layer[i], m.type[i] == PLANISH_CELL_HEXAHEDRON);
    free(is_layer);
}

/** A drawn mesh has the layers and heights of its plane mesh, however thin it is. */
static void drawn_meshes_have_the_layers_of_the_plane(void **state) {
    (void)state;
    static const double thicknesses[] = {1, 0.3, 0.1, 0.05, 0.01, 1e-4};
    static drawn_layer m;
    for (size_t t = 0; t < sizeof thicknesses / sizeof *thicknesses; t++) {
        static double given[(2 * N_PLANE + 1) * 3];
        planish_layer_heights heights;
        create_drawn(&m, thicknesses[t]);
        uint8_t *is_layer = find(&m.mesh, 1, NULL);
        for (int64_t i = 0; i < m.cells.n; i++)
            assert_int_equal(is_layer[i], m.type[i] == PLANISH_CELL_HEXAHEDRON);
        memcpy(given, m.x, sizeof given);
        place_nodes(&m, thicknesses[t], 0.105);
        m.mesh.reference = given;
        m.mesh.is_layer = is_layer;
        assert_int_equal(planish_measure_layers(&m.mesh, 1, &heights, NULL, NULL), 0);
        assert_int_equal(heights.all.n, (COLUMNS + 1) * ROWS * 2);
        assert_true(fabs(heights.all.min - 1.05) < 1e-6 && fabs(heights.all.max - 1.05) < 1e-6);
        free(is_layer);
    }
}

/** Rows of wedges between two planes, whose triangles go from one to the other, are layers like those of the
 *  hexahedra beside them. */
static void wedges_across_the_planes_have_layers(void **state) {
    (void)state;
    enum { LONG = 20, HIGH = 10, N_SIDE = (LONG + 1) * (HIGH + 1), N_CELLS = LONG / 2 * HIGH * 3 };
    static const int wedge[2][6] = {{0, 1, 2, 4, 5, 6}, {0, 2, 3, 4, 6, 7}};
    static double x[2 * N_SIDE * 3];
    static int32_t node[LONG / 2 * HIGH * (8 + 12)];
    static int64_t offset[N_CELLS + 1];
    static uint8_t type[N_CELLS];
    int n = 0;
    for (int i = 0; i < 2 * N_SIDE; i++) {
        x[3 * i] = i / N_SIDE;
        x[3 * i + 1] = i % N_SIDE / (HIGH + 1);
        x[3 * i + 2] = 0.1 * (i % (HIGH + 1));
    }
    for (int i = 0; i < LONG * HIGH; i++) {
        const int at = i / HIGH * (HIGH + 1) + i % HIGH, is_split = i / HIGH >= LONG / 2;
        const int low[] = {at, at + N_SIDE, at + N_SIDE + HIGH + 1, at + HIGH + 1};
        for (int part = 0; part <= is_split; part++, n++) {
            type[n] = is_split ? PLANISH_CELL_WEDGE : PLANISH_CELL_HEXAHEDRON;
            offset[n + 1] = offset[n] + (is_split ? 6 : 8);
            for (int j = 0; j < (is_split ? 6 : 8); j++) {
                const int corner = is_split ? wedge[part][j] : j;
                node[offset[n] + j] = low[corner % 4] + corner / 4;
            }
        }
    }
    const planish_cells cells = {.n = N_CELLS, .type = type, .offset = offset, .node = node};
    const planish_mesh mesh = {
        .dim = 3, .n_nodes = 2 * N_SIDE, .n_elements = N_CELLS, .coordinates = x, .cells = &cells};
    int64_t n_layer;
    free(find(&mesh, 1, &n_layer));
    assert_int_equal(n_layer, N_CELLS);
}

/** Rows above a wall that was moved through the first one are found, few as they are. */
static void moved_walls_leave_layers(void **state) {
    (void)state;
    double height[CELLS];
    fill_heights(height, CELLS, 0.1, 1);
    for (int t = 0; t < N_LAYER_TYPES; t++) {
        test_cells m;
        test_cells_box(&m, CELLS, layer_types[t], CELLS);
        set_rows(&m, m.mesh.dim - 1, height);
        for (int64_t i = 0; i < m.mesh.n_nodes; i++) {
            double *x = m.coordinates + i * m.mesh.dim, *last = x + m.mesh.dim - 1;
            const int is_inside =
                x[0] > 0 && x[0] < CELLS && (m.mesh.dim == 2 || (x[1] > 0 && x[1] < CELLS));
            *last += is_inside && *last == 0 ? 0.15 : 0;
        }
        uint8_t *is_layer = find_in_cells(&m, 1, NULL);
        int64_t n_out = 0;
        for (int64_t e = 1; e < m.cells.n; e++) { /* the first one is of another type */
            assert_true(is_layer[e] || m.row[e] == 0);
            n_out += !is_layer[e];
        }
        assert_true(n_out > CELLS / 2); /* more than one in 20 */
        free(is_layer);
        test_cells_destroy(&m);
    }
}

/** Rows go on where nodes are close along the wall. */
static void rows_go_on_along_walls(void **state) {
    (void)state;
    double height[CELLS], along[CELLS];
    fill_heights(height, CELLS, 0.1, 1);
    for (int k = 0; k < CELLS; k++)
        along[k] = k < 3 ? 0.2 : 1;
    for (int t = 0; t < N_LAYER_TYPES; t++) {
        test_cells m;
        int64_t n;
        test_cells_box(&m, CELLS, layer_types[t], CELLS);
        set_rows(&m, m.mesh.dim - 1, height);
        set_rows(&m, 0, along);
        free(find_in_cells(&m, 1, &n));
        assert_int_equal(n, m.cells.n - 1);
        test_cells_destroy(&m);
    }
}

/** Reverse the handedness of every third element, or all; rotate and scale; more threads. */
static void cells_are_judged_alike_in_any_place(void **state) {
    (void)state;
    static const int hexahedron[] = {4, 5, 6, 7, 0, 1, 2, 3}, wedge[] = {3, 4, 5, 0, 1, 2},
                     quadrilateral[] = {3, 2, 1, 0};
    double height[CELLS];
    fill_heights(height, 4, 0.15, 1.3);
    for (int t = 0; t < N_LAYER_TYPES; t += 2)
        for (int how = 0; how < 6; how++) {
            test_cells m;
            int64_t n, n_before;
            test_cells_box(&m, CELLS, layer_types[t], 6);
            const int dim = m.mesh.dim;
            set_rows(&m, dim - 1, height);
            perturb_cells(&m, 0.02, 0.01, 2);
            uint8_t *before = find_in_cells(&m, 1, &n_before);
            assert_true(n_before > m.cells.n / 10 && n_before < m.cells.n / 2);
            const int *order = dim == 2                                    ? quadrilateral
                               : layer_types[t] == PLANISH_CELL_HEXAHEDRON ? hexahedron
                                                                           : wedge;
            for (int64_t i = 1; i < m.cells.n && how < 2; i++) {
                int32_t old[8];
                const int size = (int)(m.offset[i + 1] - m.offset[i]);
                memcpy(old, m.node + m.offset[i], (size_t)size * sizeof *old);
                for (int j = 0; j < size && m.type[i] == layer_types[t] && i % (how + 1) == 0; j++)
                    m.node[m.offset[i] + j] = old[order[j]];
            }
            test_mesh box = {.mesh = m.mesh, .coordinates = m.coordinates};
            if (how == 2 || how == 3)
                test_mesh_transform(&box, ldexp(1, how == 2 ? -900 : 900), 0);
            for (int64_t i = 0; i < m.mesh.n_nodes && how == 4; i++) { /* turned, and mirrored */
                double *x = m.coordinates + i * dim, a = x[0], b = x[dim - 1];
                x[0] = 0.6 * a + 0.8 * b;
                x[dim - 1] = 0.8 * a - 0.6 * b;
            }
            uint8_t *after = find_in_cells(&m, how == 5 ? 3 : 1, &n);
            assert_memory_equal(before, after, (size_t)m.cells.n);
            free(before);
            free(after);
            test_cells_destroy(&m);
        }
}

/** Simplices as cells, of order 1 and 2, are what they are as elements. */
static void simplices_may_be_cells(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int order = 1; order <= 2; order++) {
            test_mesh box;
            create_uneven(&box, dim);
            const int64_t n = box.mesh.n_elements;
            test_cells m;
            test_cells_of_simplices(&m, &box, order);
            uint8_t *is_layer = find(&box.mesh, 1, NULL), *other = find_in_cells(&m, 2, NULL);
            assert_memory_equal(is_layer, other, (size_t)n);
            free(is_layer);
            free(other);
            test_cells_destroy(&m);
            test_mesh_destroy(&box);
        }
}

/* ---- arguments ------------------------------------------------------------------------------ */

static void refuse(const planish_mesh *mesh, int threads, int code) {
    uint8_t is_layer[64];
    int64_t n = -5;
    planish_error error = {.text = ""};
    memset(is_layer, 9, sizeof is_layer);
    assert_int_equal(planish_find_layers(mesh, threads, is_layer, &n, &error), code);
    assert_int_equal(error.code, code);
    assert_true(error.text[0] != '\0');
    assert_int_equal(n, -5);
    for (size_t i = 0; i < sizeof is_layer; i++)
        assert_int_equal(is_layer[i], 9);
}

static void wrong_arguments_are_refused(void **state) {
    (void)state;
    test_mesh box;
    test_mesh_box(&box, 3, 1);
    assert_int_equal(planish_find_layers(&box.mesh, 1, NULL, NULL, NULL), PLANISH_ERROR_ARGUMENT);
    refuse(NULL, 1, PLANISH_ERROR_ARGUMENT);
    refuse(&box.mesh, -1, PLANISH_ERROR_ARGUMENT);
    planish_mesh mesh = box.mesh;
    mesh.dim = 4;
    refuse(&mesh, 1, PLANISH_ERROR_ARGUMENT);
    mesh = box.mesh;
    mesh.n_elements = 0;
    refuse(&mesh, 1, PLANISH_ERROR_MESH);
    mesh = box.mesh;
    mesh.component_stride = 2;
    refuse(&mesh, 1, PLANISH_ERROR_ARGUMENT);
    box.elements[5] = 8;
    refuse(&box.mesh, 1, PLANISH_ERROR_MESH);
    box.elements[5] = box.elements[4];
    refuse(&box.mesh, 1, PLANISH_ERROR_MESH);
    test_mesh_destroy(&box);
    test_mesh_box(&box, 3, 1);
    box.coordinates[7] = NAN;
    refuse(&box.mesh, 1, PLANISH_ERROR_MESH);
    test_mesh_destroy(&box);
    const int32_t node[] = {0, 1, 2, 4};
    const int64_t offset[] = {0, 4};
    const uint8_t type[] = {PLANISH_CELL_QUADRILATERAL};
    const double x[8] = {0, 0, 1, 0, 1, 1, 0, 1};
    const planish_cells cells = {.n = 1, .type = type, .offset = offset, .node = node};
    mesh =
        (planish_mesh){.dim = 2, .n_nodes = 4, .n_elements = 1, .coordinates = x, .cells = &cells};
    refuse(&mesh, 1, PLANISH_ERROR_MESH);
    refuse(&mesh, -1, PLANISH_ERROR_ARGUMENT);
    mesh.n_elements = 2;
    refuse(&mesh, 1, PLANISH_ERROR_ARGUMENT);
}

/** Find layers without the first block of memory, the second, ... */
static void find_without_memory(const planish_mesh *mesh) {
    uint8_t *is_layer = malloc((size_t)mesh->n_elements);
    int status = PLANISH_ERROR_MEMORY, permitted = 0;
    for (; status; permitted++) {
        int64_t n = -5;
        memset(is_layer, 9, (size_t)mesh->n_elements);
        allocations_permit(permitted);
        status = planish_find_layers(mesh, 1, is_layer, &n, NULL);
        allocations_permit(-1);
        assert_true(status == 0 || status == PLANISH_ERROR_MEMORY);
        assert_true(status == 0 || (n == -5 && is_layer[0] == 9));
    }
    assert_true(permitted > 4);
    free(is_layer);
}

static void no_memory_is_an_error(void **state) {
    (void)state;
    double height[CELLS];
    test_mesh box;
    test_cells m;
    create_uneven(&box, 3);
    find_without_memory(&box.mesh);
    test_mesh_destroy(&box);
    test_cells_box(&m, CELLS, PLANISH_CELL_HEXAHEDRON, CELLS);
    fill_heights(height, CELLS, 0.1, 1);
    set_rows(&m, 2, height);
    m.coordinates[m.mesh.n_nodes * 3 - 1] = 0; /* the last element is tangled */
    planish_mesh mesh = m.mesh;
    mesh.cells = &m.cells;
    find_without_memory(&mesh);
    test_cells_destroy(&m);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(layers_on_a_wall_are_found),
        cmocka_unit_test(layers_may_grow),
        cmocka_unit_test(rows_go_on_to_both_sides),
        cmocka_unit_test(corners_have_layers),
        cmocka_unit_test(walls_may_be_curved),
        cmocka_unit_test(stretched_meshes_are_layers_throughout),
        cmocka_unit_test(chains_of_short_edges_are_no_layers),
        cmocka_unit_test(short_edges_alone_are_no_layers),
        cmocka_unit_test(chance_makes_no_layers),
        cmocka_unit_test(slivers_are_no_layers),
        cmocka_unit_test(grading_makes_no_layers),
        cmocka_unit_test(collapsed_elements_are_none),
        cmocka_unit_test(threads_do_not_change_the_marks),
        cmocka_unit_test(scale_does_not_matter),
        cmocka_unit_test(arrays_may_have_other_forms),
        cmocka_unit_test(nodes_may_have_many_elements),
        cmocka_unit_test(layers_of_other_elements_are_found),
        cmocka_unit_test(rows_go_on_into_simplices),
        cmocka_unit_test(layers_of_other_elements_go_around_corners),
        cmocka_unit_test(badly_shaped_elements_are_in_no_layers),
        cmocka_unit_test(a_layer_has_some_elements),
        cmocka_unit_test(one_bad_element_leaves_a_layer),
        cmocka_unit_test(slivers_at_the_end_leave_a_layer),
        cmocka_unit_test(drawn_meshes_have_the_layers_of_the_plane),
        cmocka_unit_test(wedges_across_the_planes_have_layers),
        cmocka_unit_test(moved_walls_leave_layers),
        cmocka_unit_test(rows_go_on_along_walls),
        cmocka_unit_test(cells_are_judged_alike_in_any_place),
        cmocka_unit_test(simplices_may_be_cells),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(no_memory_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
