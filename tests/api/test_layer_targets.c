/* planish_mesh.is_layer: layers that keep their heights while nodes move along them. Boxes are squeezed to
 * layers whose heights grow; heights are judged by distances of nodes above each other. */
#include "support/cell_meshes.h"
#include "support/meshes.h"
#include "support/run.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { N = 10, TRIANGLES = N_BOX_KINDS, TETRAHEDRA };
static const double FIRST = 0.03, GROWTH = 1.25;
static const int kinds[] = {BOX_QUADRILATERALS, BOX_HEXAHEDRA, BOX_WEDGES, TRIANGLES, TETRAHEDRA};
enum { N_KINDS = sizeof kinds / sizeof *kinds };

/* ---- meshes ---------------------------------------------------------------------------------- */

/** Box of layers, as it is to be. */
typedef struct layers {
    cell_box *box;
    int32_t *simplices; /* or NULL */
    planish_mesh mesh;
    uint8_t *is_layer; /* all */
    double *x;         /* [n_nodes][dim] to be smoothed; as it is to be: box->x */
} layers;

static void *allocate(int64_t count, size_t size) {
    void *array = calloc((size_t)count + 1, size);
    assert_non_null(array);
    return array;
}

/** Split the squares or cubes of a box in 2 triangles or 6 tetrahedra each. */
static void split(layers *l) {
    static const int of_square[2][3] = {{0, 1, 2}, {0, 2, 3}};
    static const int of_cube[6][4] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6},
                                      {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
    const int dim = l->mesh.dim, n = dim == 3 ? 6 : 2;
    const planish_cells *cells = l->mesh.cells;
    l->simplices = allocate(cells->n * n * (dim + 1), sizeof *l->simplices);
    for (int64_t i = 0; i < cells->n * n; i++)
        for (int j = 0; j <= dim; j++)
            l->simplices[i * (dim + 1) + j] =
                cells->node[cells->offset[i / n] +
                            (dim == 3 ? of_cube[i % n][j] : of_square[i % n][j])];
    l->mesh.cells = NULL;
    l->mesh.elements = l->simplices;
    l->mesh.n_elements = cells->n * n;
}

static layers make_layers(int kind) {
    layers l = {.box = cell_box_create(kind == TRIANGLES    ? BOX_QUADRILATERALS
                                       : kind == TETRAHEDRA ? BOX_HEXAHEDRA
                                                            : (cell_box_kind)kind,
                                       N)};
    l.mesh = l.box->mesh;
    if (kind >= TRIANGLES)
        split(&l);
    const int dim = l.mesh.dim;
    const int64_t n = l.mesh.n_nodes;
    for (int64_t i = 0; i < n; i++)
        l.box->x[i * dim + dim - 1] =
            FIRST * (pow(GROWTH, l.box->x[i * dim + dim - 1]) - 1) / (GROWTH - 1);
    l.is_layer = allocate(l.mesh.n_elements, 1);
    memset(l.is_layer, 1, (size_t)l.mesh.n_elements);
    l.x = allocate(n * dim, sizeof *l.x);
    memcpy(l.x, l.box->x, (size_t)(n * dim) * sizeof *l.x);
    l.mesh.coordinates = l.x;
    l.mesh.is_layer = l.is_layer;
    return l;
}

static void forget(layers *l) {
    cell_box_destroy(l->box);
    free(l->simplices);
    free(l->is_layer);
    free(l->x);
}

/** Whether node i is on the boundary of the box. */
static int is_outside(const layers *l, int64_t i) {
    const int dim = l->mesh.dim;
    const double top = FIRST * (pow(GROWTH, N) - 1) / (GROWTH - 1);
    for (int d = 0; d < dim; d++) {
        const double c = l->box->x[i * dim + d], last = d == dim - 1 ? top : N;
        if (c < 1e-9 || c > last - 1e-9)
            return 1;
    }
    return 0;
}

/** Whether node i is on a side of the box. */
static int is_beside(const layers *l, int64_t i) {
    const double *p = l->box->x + i * l->mesh.dim;
    int found = 0;
    for (int d = 0; d < l->mesh.dim - 1; d++)
        found |= p[d] < 1e-9 || p[d] > N - 1e-9;
    return found;
}

/** Push the nodes inside along the layer by up to amount; those of a column together, or each one. */
static void push_along(layers *l, double amount, int together) {
    const int dim = l->mesh.dim;
    for (int64_t i = 0; i < l->mesh.n_nodes; i++) {
        const double *p = l->box->x + i * dim;
        uint64_t seed = (uint64_t)(together ? (int64_t)p[0] * 97 + (dim == 3) * (int64_t)p[1] : i);
        for (int d = 0; d < dim - 1; d++) {
            for (int k = 0; k < 3; k++)
                seed = seed * 6364136223846793005u + 1442695040888963407u;
            if (!is_outside(l, i))
                l->x[i * dim + d] += amount * ((double)(seed >> 11) / 4503599627370496.0 - 1);
        }
    }
}

/** Move the wall into its layers: by depth first heights in the middle. */
static void move_wall(layers *l, double depth) {
    const int dim = l->mesh.dim;
    for (int64_t i = 0; i < l->mesh.n_nodes; i++) {
        const double *p = l->box->x + i * dim;
        if (p[dim - 1] < 1e-9)
            l->x[i * dim + dim - 1] += depth * FIRST * sin(p[0] * 3.14159265358979 / N) *
                                       (dim == 3 ? sin(p[1] * 3.14159265358979 / N) : 1);
    }
}

/* ---- smoothing and judging --------------------------------------------------------------------- */

/** The largest part by which a height of the first rows is off what it is to be: the distance of nodes
 *  that are above each other in the box. */
static double worst_height(const layers *l, int rows) {
    const int dim = l->mesh.dim;
    const double top = FIRST * (pow(GROWTH, rows) - 1) / (GROWTH - 1) + 1e-9;
    double worst = 0;
    for (int64_t i = 0; i < l->mesh.n_nodes; i++)
        for (int64_t j = 0; j < l->mesh.n_nodes; j++) {
            const double *p = l->box->x + i * dim, *q = l->box->x + j * dim;
            const double height = q[dim - 1] - p[dim - 1];
            if (!(height > 0 && q[dim - 1] < top && p[0] == q[0] && (dim == 2 || p[1] == q[1]) &&
                  height < FIRST + (GROWTH - 1) * p[dim - 1] + 1e-9))
                continue;
            const double is = l->x[j * dim + dim - 1] - l->x[i * dim + dim - 1];
            worst = fmax(worst, fabs(is / height - 1));
        }
    return worst;
}

/** RMS of how far the nodes inside are off their places along the layer. */
static double off_along(const layers *l) {
    const int dim = l->mesh.dim;
    double sum = 0, n = 0;
    for (int64_t i = 0; i < l->mesh.n_nodes; i++)
        for (int d = 0; d < dim - 1; d++) {
            const double off = l->x[i * dim + d] - l->box->x[i * dim + d];
            sum += off * off;
            n += !is_outside(l, i);
        }
    return sqrt(sum / n);
}

static int64_t n_inverted(const layers *l) {
    planish_mesh mesh = l->mesh;
    planish_cell_quality quality;
    planish_error error;
    mesh.is_layer = NULL;
    mesh.reference = NULL;
    assert_int_equal(planish_measure_cells(&mesh, 0, 1, &quality, NULL, &error), 0);
    return quality.all.n_inverted;
}

/* Nodes that were pushed along the layer come back, each one or a column together, and the heights stay.
 * Tetrahedra whose nodes are pushed one by one have no edges across. */
static void layers_become_regular_along(void **state) {
    (void)state;
    for (int k = 0; k < N_KINDS; k++)
        for (int together = kinds[k] == TETRAHEDRA; together < 2; together++) {
            layers l = make_layers(kinds[k]);
            const planish_options options = test_options(1);
            push_along(&l, 0.25, together);
            const double before = off_along(&l);
            test_smooth_in_place(&l.mesh, l.x, &options);
            assert_true(off_along(&l) < 0.05 * before);
            assert_true(worst_height(&l, N) < 0.1);
            assert_int_equal(n_inverted(&l), 0);
            forget(&l);
        }
}

/* Walls whose elements are longer one way than the other do not let the layers grow. */
static void layers_on_stretched_walls_keep_their_heights(void **state) {
    (void)state;
    for (int k = 0; k < N_KINDS; k++) {
        layers l = make_layers(kinds[k]);
        const planish_options options = test_options(1);
        for (int64_t i = 0; i < l.mesh.n_nodes * l.mesh.dim; i += l.mesh.dim)
            l.x[i] *= 3;
        test_smooth_in_place(&l.mesh, l.x, &options);
        assert_true(worst_height(&l, N) < 0.1);
        forget(&l);
    }
}

/** Let the elements count as layers whose lowest node is above one height and below another one. */
static void mark_between(layers *l, double low, double high) {
    for (int64_t i = 0; l->mesh.cells && i < l->mesh.n_elements; i++) {
        double lowest = INFINITY;
        for (int64_t j = l->box->offset[i]; j < l->box->offset[i + 1]; j++)
            lowest = fmin(lowest, l->box->x[(int64_t)(l->box->node[j] + 1) * l->mesh.dim - 1]);
        l->is_layer[i] = lowest > low && lowest < high;
    }
}

/* First heights are what they were after a wall was moved through rows, or into the first one. Elements
 * that are not valid then are found by themselves, also where uprights across the wall's way are longer
 * than those of all rows, or than other edges. */
static void moved_walls_get_their_spacing_back(void **state) {
    (void)state;
    static const double depths[] = {0.6, 1.4, 3, 9, 13, -9};
    for (int k = 0; k < N_KINDS; k++)
        for (int depth = 0; depth < (kinds[k] >= TRIANGLES ? 3 : 6); depth++) {
            layers l = make_layers(kinds[k]);
            const planish_options options = test_options(1);
            move_wall(&l, depths[depth]);
            mark_between(&l, depths[depth] < 0 ? -INFINITY : 1e-9, INFINITY);
            test_smooth_in_place(&l.mesh, l.x, &options);
            assert_int_equal(n_inverted(&l), 0);
            /* Far moves leave less room for all rows. */
            assert_true(worst_height(&l, 1) < (fabs(depths[depth]) < 4 ? 0.1 : 0.25));
            forget(&l);
        }
}

/* Elements that are in no layer are regular, and no larger than they are: untangling wants the sizes of all
 * elements, whatever the unit of the coordinates. Without that it makes layers collapse, or grow. */
static void layers_under_other_elements_are_untangled(void **state) {
    (void)state;
    enum { ROWS = 4 };
    const double top = FIRST * (pow(GROWTH, ROWS) - 1) / (GROWTH - 1);
    for (int k = 0; k < N_KINDS && kinds[k] < TRIANGLES; k++)
        for (int run = 0; run < 2; run++) {
            layers l = make_layers(kinds[k]);
            const planish_options options = test_options(1);
            const int dim = l.mesh.dim;
            for (int64_t i = 0; i < l.mesh.n_nodes; i++) { /* higher ones above */
                double *z = &l.box->x[i * dim + dim - 1];
                *z = *z > top + 1e-9 ? top + 4 * (*z - top) : *z;
                l.x[i * dim + dim - 1] = *z;
            }
            mark_between(&l, -1, top - 1e-9);
            for (int64_t i = 0; i < l.mesh.n_nodes; i++) /* the whole wall, by half of the layer */
                if (l.box->x[i * dim + dim - 1] < 1e-9 && !is_beside(&l, i))
                    l.x[i * dim + dim - 1] += top / 2;
            const double unit = run ? 1e-3 : 1e3;
            for (int64_t i = 0; i < l.mesh.n_nodes * dim; i++)
                l.x[i] *= unit;
            const planish_result result = test_smooth_in_place(&l.mesh, l.x, &options);
            for (int64_t i = 0; i < l.mesh.n_nodes * dim; i++)
                l.x[i] /= unit;
            assert_int_equal(n_inverted(&l), 0);
            assert_true(result.untangling_sweeps < 40);
            assert_true(worst_height(&l, 1) < 0.5);
            forget(&l);
        }
}

/* ---- measures, bits, errors --------------------------------------------------------------------- */

/* What is measured before and after is against the layers as they were, and F does not rise. Plan and
 * planish_measure_cells agree. */
static void measures_are_against_the_layers(void **state) {
    (void)state;
    for (int k = 0; k < N_KINDS; k++) {
        layers l = make_layers(kinds[k]);
        const planish_options options = test_options(1);
        push_along(&l, 0.2, 1);
        const int64_t n = l.mesh.n_nodes * l.mesh.dim;
        double *was = allocate(n, sizeof *was);
        memcpy(was, l.x, (size_t)n * sizeof *was);
        planish_mesh mesh = l.mesh;
        planish_cell_quality quality;
        planish_error error;
        assert_int_equal(planish_measure_cells(&mesh, 0, 1, &quality, NULL, &error), 0);
        const double before = quality.all.rms_aspect_ratio;
        mesh.coordinates = was;
        const planish_result result = test_smooth_in_place(&mesh, l.x, &options);
        mesh.coordinates = l.x;
        mesh.reference = was;
        assert_int_equal(planish_measure_cells(&mesh, 0, 1, &quality, NULL, &error), 0);
        assert_true(fabs(result.objective_before / before - 1) < 1e-12);
        assert_true(quality.all.rms_aspect_ratio < before);
        assert_true(fabs(result.rms / quality.all.rms_aspect_ratio - 1) < 1e-12);
        free(was);
        forget(&l);
    }
}

static void bits_are_the_same(void **state) {
    (void)state;
    static const planish_isa sets[] = {PLANISH_ISA_PLAIN, PLANISH_ISA_VECTOR, PLANISH_ISA_AVX2};
    for (int k = 0; k < N_KINDS; k++) {
        layers l = make_layers(kinds[k]);
        planish_options options = test_options(1);
        move_wall(&l, 1.4);
        push_along(&l, 0.1, 1);
        const size_t size = (size_t)(l.mesh.n_nodes * l.mesh.dim) * sizeof *l.x;
        double *first = allocate((int64_t)size, 1), *x = allocate((int64_t)size, 1);
        memcpy(first, l.x, size);
        test_smooth_in_place(&l.mesh, first, &options);
        for (int run = 0; run < 4; run++) {
            options.threads = run == 3 ? 3 : 1;
            options.isa = run == 3 ? PLANISH_ISA_AUTO : sets[run];
            planish_plan *plan;
            planish_error error;
            if (planish_plan_create(&l.mesh, &options, &plan, &error))
                continue; /* the CPU has not this one */
            memcpy(x, l.x, size);
            assert_int_equal(planish_smooth(plan, x, &options, NULL, &error), 0);
            assert_memory_equal(x, first, size);
            planish_plan_destroy(plan);
        }
        free(first);
        free(x);
        forget(&l);
    }
}

/** Measure the heights of l->x against those at before. */
static planish_layer_heights heights_of(const layers *l, const double *before) {
    planish_mesh mesh = l->mesh;
    planish_layer_heights heights;
    planish_error error;
    mesh.reference = before;
    assert_int_equal(planish_measure_layers(&mesh, 2, &heights, NULL, &error), 0);
    return heights;
}

static void expect_row(const planish_layer_row *row, int64_t n, double least, double median,
                       double most) {
    assert_int_equal(row->n, n);
    assert_true(fabs(row->min - least) < 1e-9);
    assert_true(fabs(row->median - median) < 1e-9);
    assert_true(fabs(row->max - most) < 1e-9);
}

/* Rows are stretched by 1 %, 2 %, ... */
static void heights_are_measured_by_rows(void **state) {
    (void)state;
    for (int k = 0; k < N_KINDS; k++) {
        layers l = make_layers(kinds[k]);
        const int dim = l.mesh.dim;
        const int64_t in_row = dim == 3 ? (N + 1) * (N + 1) : N + 1;
        for (int64_t i = 0; i < l.mesh.n_nodes; i++) {
            double z = 0;
            for (int row = 0; row < N; row++)
                if (l.box->x[i * dim + dim - 1] >
                    FIRST * (pow(GROWTH, row) - 1) / (GROWTH - 1) + 1e-9)
                    z += FIRST * pow(GROWTH, row) * (1 + 0.01 * (row + 1));
            l.x[i * dim + dim - 1] = z;
        }
        planish_layer_heights heights = heights_of(&l, l.box->x);
        assert_int_equal(heights.n_rows, N);
        assert_int_equal(heights.n_told, 0);
        expect_row(&heights.reference, N * in_row, 1, 1, 1);
        expect_row(&heights.all, N * in_row, 1.01, 1.055, 1.01 + 0.01 * (N - 1));
        for (int row = 0; row < N; row++)
            expect_row(&heights.row[row], in_row, 1.01 + 0.01 * row, 1.01 + 0.01 * row,
                       1.01 + 0.01 * row);
        heights = heights_of(&l, NULL); /* against itself */
        expect_row(&heights.all, N * in_row, 1, 1, 1);
        forget(&l);
    }
}

/* Ratios of heights are numbers as long as they can be, whatever the mesh's size. */
static void heights_are_measured_at_any_scale(void **state) {
    (void)state;
    static const double scales[][2] = {{1e300, 1}, {1, 1e300}, {1e150, 1e-150}, {1e-150, 1e150}};
    for (int k = 0; k < N_KINDS; k++)
        for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
            layers l = make_layers(kinds[k]);
            double *before = test_copy_of(&l.mesh);
            for (int64_t j = 0; j < l.mesh.n_nodes * l.mesh.dim; j++) {
                before[j] *= scales[i][0];
                l.x[j] *= scales[i][1];
            }
            const planish_layer_heights heights = heights_of(&l, before);
            const double ratio = scales[i][1] / scales[i][0];
            assert_int_equal(heights.n_rows, N);
            assert_int_equal(heights.all.n, heights.reference.n);
            assert_true(fabs(heights.all.min / ratio - 1) < 1e-9);
            assert_true(fabs(heights.all.max / ratio - 1) < 1e-9);
            free(before);
            forget(&l);
        }
}

/* A wall that was moved in, or away: the heights that are wanted are told by the rows inside. */
static void heights_are_measured_under_moved_walls(void **state) {
    (void)state;
    for (int k = 0; k < N_KINDS; k++)
        for (int away = 0; away < 2; away++) {
            layers l = make_layers(kinds[k]);
            move_wall(&l, away ? -3 : 3);
            double *moved = allocate(l.mesh.n_nodes * l.mesh.dim, sizeof *moved);
            memcpy(moved, l.x, (size_t)(l.mesh.n_nodes * l.mesh.dim) * sizeof *moved);
            memcpy(l.x, l.box->x, (size_t)(l.mesh.n_nodes * l.mesh.dim) * sizeof *moved);
            const planish_layer_heights heights = heights_of(&l, moved);
            assert_true(heights.n_told > N / 2);
            assert_int_equal(heights.n_at_moved_walls, heights.n_told);
            assert_true(away ? heights.reference.max > 3 : heights.reference.min < -1);
            assert_true(fabs(heights.all.min - 1) < 0.02 && fabs(heights.all.max - 1) < 0.02);
            free(moved);
            forget(&l);
        }
}

/* A node inside that was displaced through another one, up or down: no wall was moved, and the rows there share
 * their heights. */
static void displaced_nodes_are_no_moved_walls(void **state) {
    (void)state;
    static const struct {
        int level;
        double by; /* of the height over it */
    } cases[] = {{1, -1.5}, {1, -4}, {1, 1.5}, {2, -2.5}, {3, -1.5}, {3, 1.2}, {N - 2, -1.2}};
    for (int k = 0; k < N_KINDS; k++)
        for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
            layers l = make_layers(kinds[k]);
            const int dim = l.mesh.dim, level = cases[i].level;
            double *moved = test_copy_of(&l.mesh);
            for (int64_t j = 0; j < l.mesh.n_nodes; j++) {
                const double *p = l.box->x + j * dim;
                const double z = FIRST * (pow(GROWTH, level) - 1) / (GROWTH - 1);
                if (fabs(p[0] - N / 2) < 1e-9 && (dim == 2 || fabs(p[1] - N / 2) < 1e-9) &&
                    fabs(p[dim - 1] - z) < 1e-9)
                    moved[j * dim + dim - 1] += cases[i].by * FIRST * pow(GROWTH, level);
            }
            const planish_layer_heights heights = heights_of(&l, moved);
            assert_int_equal(heights.n_told, 2);
            assert_int_equal(heights.n_at_moved_walls, 0);
            assert_true(heights.reference.min < 0 && heights.reference.max > 1.5);
            assert_true(fabs(heights.all.min - 1) < 0.03 && fabs(heights.all.max - 1) < 0.03);
            free(moved);
            forget(&l);
        }
}

/** Let layers rise from the middle of the box to both sides, on a surface that is wavy; nodes are pushed along
 *  by up to amount. */
static void make_two_sided(layers *l, double amount) {
    const int dim = l->mesh.dim;
    push_along(l, amount, 1);
    for (int64_t i = 0; i < l->mesh.n_nodes; i++) {
        const double z = l->box->x[i * dim + dim - 1];
        const int level = (int)lround(log(z * (GROWTH - 1) / FIRST + 1) / log(GROWTH)) - N / 2;
        const double height = FIRST * (pow(GROWTH, abs(level)) - 1) / (GROWTH - 1);
        l->box->x[i * dim + dim - 1] = level < 0 ? -height : height;
        l->x[i * dim + dim - 1] = l->box->x[i * dim + dim - 1] + 0.2 * sin(0.6 * l->x[i * dim]);
    }
}

/* Layers on both sides of a surface: nothing was moved, though heights fall and rise again. */
static void surfaces_between_layers_are_no_moved_walls(void **state) {
    (void)state;
    for (int k = 0; k < N_KINDS; k++) {
        layers l = make_layers(kinds[k]);
        make_two_sided(&l, 0.03);
        const planish_layer_heights heights = heights_of(&l, NULL);
        assert_int_equal(heights.n_told, 0);
        expect_row(&heights.all, heights.all.n, 1, 1, 1);
        forget(&l);
    }
}

/* Their rows are counted from there. */
static void rows_are_counted_from_surfaces_between_layers(void **state) {
    (void)state;
    for (int k = 0; k < N_KINDS; k++) {
        layers l = make_layers(kinds[k]);
        const int dim = l.mesh.dim;
        const int64_t in_row = dim == 3 ? (N + 1) * (N + 1) : N + 1;
        make_two_sided(&l, 0);
        for (int64_t i = 0; i < l.mesh.n_nodes; i++) {
            const double z = l.box->x[i * dim + dim - 1];
            double height = 0;
            for (int row = 0; row < N / 2; row++)
                if (fabs(z) > FIRST * (pow(GROWTH, row) - 1) / (GROWTH - 1) + 1e-9)
                    height += FIRST * pow(GROWTH, row) * (1 + 0.01 * (row + 1));
            l.x[i * dim + dim - 1] = z < 0 ? -height : height;
        }
        const planish_layer_heights heights = heights_of(&l, l.box->x);
        assert_int_equal(heights.n_rows, N / 2);
        for (int row = 0; row < N / 2; row++)
            expect_row(&heights.row[row], 2 * in_row, 1.01 + 0.01 * row, 1.01 + 0.01 * row,
                       1.01 + 0.01 * row);
        forget(&l);
    }
}

/* A surface between layers was moved, also through a row: both of its rows are told what they were. */
static void moved_surfaces_between_layers_tell_both_sides(void **state) {
    (void)state;
    static const double depths[] = {0.6, -0.6, 1.4, -1.4};
    for (int k = 0; kinds[k] < TRIANGLES; k++)
        for (int depth = 0; depth < 4; depth++) {
            layers l = make_layers(kinds[k]);
            const int dim = l.mesh.dim;
            make_two_sided(&l, 0);
            memcpy(l.x, l.box->x, (size_t)(l.mesh.n_nodes * dim) * sizeof *l.x);
            double *moved = test_copy_of(&l.mesh);
            for (int64_t i = 0; i < l.mesh.n_nodes; i++)
                if (fabs(l.x[i * dim + dim - 1]) < 1e-9)
                    moved[i * dim + dim - 1] +=
                        depths[depth] * FIRST * sin(l.x[i * dim] * 3.14159265358979 / N);
            const planish_layer_heights heights = heights_of(&l, moved);
            assert_true(heights.n_told >= 2 * (N - 3));
            assert_true(fabs(heights.all.min - 1) < 0.1 && fabs(heights.all.max - 1) < 0.1);
            free(moved);
            forget(&l);
        }
}

/* First heights that differ by some percent are uneven. */
static void uneven_heights_are_no_moved_walls(void **state) {
    (void)state;
    for (int k = 0; k < N_KINDS; k++) {
        layers l = make_layers(kinds[k]);
        const int dim = l.mesh.dim;
        for (int64_t i = 0; i < l.mesh.n_nodes; i++)
            if (l.x[i * dim + dim - 1] < 1e-9)
                l.x[i * dim + dim - 1] += (i % 2 ? 0.1 : -0.1) * FIRST;
        assert_int_equal(heights_of(&l, NULL).n_told, 0);
        forget(&l);
    }
}

/* Over a wall that was moved by a part of the first height other heights are to stay: off tells of them. */
static void rows_over_moved_walls_may_be_off(void **state) {
    (void)state;
    for (int k = 0; k < N_KINDS; k++)
        for (int is_far = 0; is_far < 2; is_far++) {
            layers l = make_layers(kinds[k]);
            const int dim = l.mesh.dim;
            double *off = allocate(l.mesh.n_nodes, sizeof *off), worst = 0;
            planish_layer_heights heights;
            planish_error error;
            move_wall(&l, is_far ? 0.6 : 0.25);
            double *moved = test_copy_of(&l.mesh);
            for (int64_t i = 0; i < l.mesh.n_nodes; i++) /* the fifth row grows by a quarter */
                if (l.box->x[i * dim + dim - 1] > FIRST * (pow(GROWTH, 4.5) - 1) / (GROWTH - 1))
                    l.x[i * dim + dim - 1] += 0.25 * FIRST * pow(GROWTH, 4);
            l.mesh.reference = moved;
            assert_int_equal(planish_measure_layers(&l.mesh, 1, &heights, off, &error), 0);
            assert_true(heights.n_told > 0);
            for (int64_t i = 0; i < l.mesh.n_nodes; i++)
                if (fabs(l.box->x[i * dim] - N / 2) < 1e-9 &&
                    (dim == 2 || fabs(l.box->x[i * dim + 1] - N / 2) < 1e-9))
                    worst = fmax(worst, off[i]);
            assert_true(is_far ? worst == 0 : fabs(worst - 0.25) < 1e-6);
            free(moved);
            free(off);
            forget(&l);
        }
}

/* A corner that is turned over cancels the height of the only element at an upright, but for rounding: none is
 * wanted then. */
static void cancelled_heights_are_not_wanted(void **state) {
    enum { SHIFTS = 20 };
    (void)state;
    for (int k = 0; k < SHIFTS; k++) {
        layers l = make_layers(BOX_HEXAHEDRA);
        memset(l.is_layer, 0, (size_t)l.mesh.n_elements);
        for (int row = 0; row < N; row++) /* the first column */
            l.is_layer[row * N * N] = 1;
        for (int axis = 0; axis < 2; axis++) /* over the diagonal of its square */
            l.box->x[3 * (N + 1) * (N + 1) + axis] += (0.07 + 0.003 * k) * (axis + 7);
        const planish_layer_heights heights = heights_of(&l, l.box->x);
        assert_true(heights.all.n >= 4 * N - 2);
        assert_true(heights.all.max < 10);
        forget(&l);
    }
}

/* A wall that came through its only row, as elements above are no layer: nothing tells its heights, and off
 * says nothing of them. */
static void heights_of_one_turned_row_are_not_told(void **state) {
    (void)state;
    for (int k = 0; kinds[k] < TRIANGLES; k++) {
        layers l = make_layers(kinds[k]);
        const int dim = l.mesh.dim;
        double *off = allocate(l.mesh.n_nodes, sizeof *off);
        planish_layer_heights heights;
        planish_error error;
        mark_between(&l, -1, 0.5 * FIRST);
        for (int64_t i = dim - 1; i < l.mesh.n_nodes * dim; i += dim)
            l.x[i] = fmin(l.x[i], FIRST) + fmax(l.x[i] - FIRST, 0) / (GROWTH * FIRST);
        double *moved = test_copy_of(&l.mesh);
        for (int64_t i = dim - 1; i < l.mesh.n_nodes * dim; i += dim)
            moved[i] += moved[i] < 1e-9 ? 1.5 * FIRST : 0;
        l.mesh.reference = moved;
        assert_int_equal(planish_measure_layers(&l.mesh, 1, &heights, off, &error), 0);
        expect_row(&heights.reference, dim == 3 ? (N + 1) * (N + 1) : N + 1, -1, -1, -1);
        expect_row(&heights.all, heights.reference.n, 2, 2, 2);
        assert_int_equal(heights.n_rows, 1);
        assert_int_equal(heights.n_told, 0);
        for (int64_t i = 0; i < l.mesh.n_nodes; i++)
            assert_true(off[i] == 0);
        free(moved);
        free(off);
        forget(&l);
    }
}

/** Expect a refusal of planish_measure_layers: heights become 0, and off stays. */
static void expect_no_heights(const planish_mesh *mesh, int threads, int status,
                              planish_error *error) {
    static const planish_layer_heights none = {.n_rows = 0};
    planish_layer_heights heights;
    double *off = calloc((size_t)mesh->n_nodes, sizeof *off);
    assert_non_null(off);
    memset(&heights, 1, sizeof heights);
    off[0] = off[mesh->n_nodes - 1] = 7;
    assert_int_equal(planish_measure_layers(mesh, threads, &heights, off, error), status);
    assert_memory_equal(&heights, &none, sizeof none);
    assert_true(off[0] == 7 && off[mesh->n_nodes - 1] == 7);
    free(off);
}

static void heights_need_marks(void **state) {
    (void)state;
    layers l = make_layers(BOX_QUADRILATERALS);
    planish_layer_heights heights;
    planish_error error;
    expect_no_heights(&l.mesh, PLANISH_LAYER_ROWS * 1000, PLANISH_ERROR_ARGUMENT, &error);
    memset(l.is_layer, 0, (size_t)l.mesh.n_elements);
    assert_int_equal(planish_measure_layers(&l.mesh, 1, &heights, NULL, &error), 0);
    assert_int_equal(heights.all.n, 0);
    assert_int_equal(heights.n_rows, 0);
    l.mesh.is_layer = NULL;
    expect_no_heights(&l.mesh, 1, PLANISH_ERROR_ARGUMENT, &error);
    assert_non_null(strstr(error.text, "is_layer"));
    forget(&l);
}

/* Heights are asked of the reference, so that its coordinates are numbers. */
static void a_reference_that_is_not_finite_is_refused(void **state) {
    (void)state;
    for (int k = 0; k < N_KINDS; k++) {
        layers l = make_layers(kinds[k]);
        planish_cell_quality quality;
        planish_error error;
        double *reference = test_copy_of(&l.mesh);
        const int64_t node = l.mesh.n_nodes / 2;
        const planish_options options = test_options(1);
        reference[node * l.mesh.dim + 1] = k % 2 ? NAN : -INFINITY;
        l.mesh.reference = reference;
        expect_no_heights(&l.mesh, 1, PLANISH_ERROR_MESH, &error);
        assert_int_equal(error.node, node);
        assert_int_equal(planish_measure_cells(&l.mesh, 0, 1, &quality, NULL, &error),
                         PLANISH_ERROR_MESH);
        assert_int_equal(error.node, node);
        test_expect_refusal(&l.mesh, &options, PLANISH_ERROR_MESH, "finite");
        free(reference);
        forget(&l);
    }
}

/* Without a mark there is no target, whatever the reference. */
static void no_layers_are_no_targets(void **state) {
    (void)state;
    for (int k = 0; k < N_KINDS; k++) {
        layers l = make_layers(kinds[k]);
        const planish_options options = test_options(1);
        const size_t size = (size_t)(l.mesh.n_nodes * l.mesh.dim) * sizeof *l.x;
        double *x = allocate((int64_t)size, 1), *y = allocate((int64_t)size, 1);
        push_along(&l, 0.2, 0);
        memcpy(x, l.x, size);
        memcpy(y, l.x, size);
        memset(l.is_layer, 0, (size_t)l.mesh.n_elements);
        l.mesh.reference = l.box->x;
        test_smooth_in_place(&l.mesh, x, &options);
        l.mesh.reference = NULL;
        l.mesh.is_layer = NULL;
        test_smooth_in_place(&l.mesh, y, &options);
        assert_memory_equal(x, y, size);
        free(x);
        free(y);
        forget(&l);
    }
}

/* A channel that is periodic along the layer: nodes of both sides move up and down together, and heights are
 * kept there, too. */
static void periodic_layers_keep_their_heights(void **state) {
    (void)state;
    for (int k = 0; k < N_KINDS; k++) {
        layers l = make_layers(kinds[k]);
        const int dim = l.mesh.dim;
        const int64_t n = l.mesh.n_nodes;
        uint8_t *constraint = allocate(n, 1);
        double *direction = allocate(n * dim, sizeof *direction);
        int32_t *pair = allocate(2 * n, sizeof *pair);
        const double top = FIRST * (pow(GROWTH, N) - 1) / (GROWTH - 1);
        for (int64_t i = 0; i < n; i++) {
            const double *p = l.box->x + i * dim, z = p[dim - 1];
            const int is_side = p[0] < 1e-9 || p[0] > N - 1e-9;
            if (!is_side || z < 1e-9 || z > top - 1e-9 ||
                (dim == 3 && (p[1] < 1e-9 || p[1] > N - 1e-9)))
                continue;
            constraint[i] = dim == 3 ? PLANISH_CONSTRAINT_ON_PLANE : PLANISH_CONSTRAINT_ON_LINE;
            direction[i * dim + (dim == 3 ? 0 : 1)] = 1;
            for (int64_t j = 0; j < n && p[0] < 1e-9; j++) { /* the node on the other side */
                const double *q = l.box->x + j * dim;
                if (fabs(q[0] - N) < 1e-9 && fabs(q[dim - 1] - z) < 1e-9 &&
                    (dim == 2 || fabs(q[1] - p[1]) < 1e-9)) {
                    pair[2 * l.mesh.n_periodic] = (int32_t)i;
                    pair[2 * l.mesh.n_periodic++ + 1] = (int32_t)j;
                }
            }
            l.x[i * dim + dim - 1] += 0.08 * z; /* of both sides alike */
        }
        assert_true(l.mesh.n_periodic >= N - 1);
        l.mesh.constraint = constraint;
        l.mesh.direction = direction;
        l.mesh.periodic = pair;
        l.mesh.reference = l.box->x;
        const double before = worst_height(&l, N);
        const planish_options options = test_options(1);
        test_smooth_in_place(&l.mesh, l.x, &options);
        assert_true(worst_height(&l, N) < 0.3 * before);
        assert_int_equal(n_inverted(&l), 0);
        for (int64_t i = 0; i < l.mesh.n_periodic; i++)
            for (int d = 0; d < dim; d++)
                assert_true(fabs(l.x[(int64_t)pair[2 * i + 1] * dim + d] -
                                 l.x[(int64_t)pair[2 * i] * dim + d] - (d == 0 ? N : 0)) < 1e-12);
        free(constraint);
        free(direction);
        free(pair);
        forget(&l);
    }
}

/* Whatever is marked, of whatever mesh: measures are numbers, and smoothing makes nothing worse. */
static void any_marks_are_taken(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++)
        for (int run = 0; run < 8; run++) {
            cell_box *first = cell_box_create((cell_box_kind)kind, 3);
            cell_box_shake(first, run < 4 ? 0.3 : 1.2, (uint64_t)run);
            for (int64_t i = 0; run % 4 == 1 && i < first->mesh.n_nodes; i++)
                first->x[(i + 1) * first->mesh.dim - 1] *= 0.02;
            if (run % 4 == 2) /* an edge without length */
                memcpy(first->x, first->x + first->mesh.dim,
                       (size_t)first->mesh.dim * sizeof *first->x);
            cell_box *box = run % 2 ? cell_box_raise(first, run % 4 == 1) : first;
            planish_options options = test_options(1);
            planish_mesh mesh = box->mesh;
            uint8_t *is_layer = allocate(mesh.n_elements, 1);
            for (int64_t i = 0; i < mesh.n_elements; i++)
                is_layer[i] = (uint8_t)(i * 7 % 5 > run % 3);
            mesh.is_layer = is_layer;
            options.max_sweeps = 8;
            planish_cell_quality was, is;
            planish_error error;
            assert_int_equal(planish_measure_cells(&mesh, 0, 1, &was, NULL, &error), 0);
            const planish_result result = test_smooth_in_place(&mesh, box->x, &options);
            mesh.is_layer = NULL;
            assert_int_equal(planish_measure_cells(&mesh, 0, 1, &is, NULL, &error), 0);
            assert_true(is.all.n_inverted <= was.all.n_inverted);
            assert_true(is.all.n_inverted == is.all.n_elements || isfinite(result.rms));
            free(is_layer);
            if (box != first)
                cell_box_destroy(box);
            cell_box_destroy(first);
        }
}

static void what_does_not_fit_is_refused(void **state) {
    (void)state;
    layers l = make_layers(BOX_HEXAHEDRA);
    planish_options options = test_options(1);
    options.size_weight = 0.5;
    test_expect_refusal(&l.mesh, &options, PLANISH_ERROR_ARGUMENT, "size_weight");
    forget(&l);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(layers_become_regular_along),
        cmocka_unit_test(layers_on_stretched_walls_keep_their_heights),
        cmocka_unit_test(moved_walls_get_their_spacing_back),
        cmocka_unit_test(layers_under_other_elements_are_untangled),
        cmocka_unit_test(measures_are_against_the_layers),
        cmocka_unit_test(heights_are_measured_by_rows),
        cmocka_unit_test(heights_are_measured_at_any_scale),
        cmocka_unit_test(heights_are_measured_under_moved_walls),
        cmocka_unit_test(displaced_nodes_are_no_moved_walls),
        cmocka_unit_test(surfaces_between_layers_are_no_moved_walls),
        cmocka_unit_test(rows_are_counted_from_surfaces_between_layers),
        cmocka_unit_test(moved_surfaces_between_layers_tell_both_sides),
        cmocka_unit_test(uneven_heights_are_no_moved_walls),
        cmocka_unit_test(rows_over_moved_walls_may_be_off),
        cmocka_unit_test(cancelled_heights_are_not_wanted),
        cmocka_unit_test(heights_of_one_turned_row_are_not_told),
        cmocka_unit_test(heights_need_marks),
        cmocka_unit_test(a_reference_that_is_not_finite_is_refused),
        cmocka_unit_test(bits_are_the_same),
        cmocka_unit_test(periodic_layers_keep_their_heights),
        cmocka_unit_test(any_marks_are_taken),
        cmocka_unit_test(no_layers_are_no_targets),
        cmocka_unit_test(what_does_not_fit_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
