/* The Hessians of RR^2 by the edges of tetrahedra and triangles (improve/bend.h), and of mu^2 by those
 * of corners (improve/bend_mean.h), against differences of the reference formulas
 * (geometry/simplex.h, corner.h); and their positive parts. */
#pragma GCC diagnostic ignored "-Wpsabi" /* nothing is passed: all is inlined */

#include "geometry/corner.h"
#include "geometry/simplex.h"
#include "improve/bend_mean.h"
#include "support/both.h"
#include "support/meshes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

enum { EDGES = 3, LANES = 4, MOVES = 4 }; /* at most; moves: of the edges of a triangle */

/** Edges of four elements, as numbers and as packs. */
typedef struct four_elements {
    double e[LANES][EDGES][3];
    bend_vector edges[EDGES];
} four_elements;

/** What a corner of a shape adds to the AR^2 of its element: mu^2 by the number of corners. */
static double share_at(const pl_cell_shape *shape, double e[EDGES][3]) {
    const int dim = shape->dim;
    double E = 0;
    for (int i = 0, pair = 0; i < dim; i++) {
        E += shape->to_corner[i] * pl_dot(dim, e[i], e[i]);
        for (int j = i + 1; j < dim; j++) {
            double apart[3];
            pl_subtract(dim, e[j], e[i], apart);
            E += shape->between[pair++] * pl_dot(dim, apart, apart);
        }
    }
    const double ideal = fabs(pl_determinant_of_edges(dim, e)) / shape->determinant;
    const int n = pl_kind_of_shape(shape) == PL_KIND_SIMPLEX ? 1 : shape->n_measured;
    return pl_mean_square(dim, E, ideal) / n;
}

/** RR^2 of the element with these edges from its first node; of a shape's corner its share. */
static double ratio_at(int dim, const pl_cell_shape *shape, double e[EDGES][3]) {
    static const double ORIGIN[3] = {0, 0, 0};
    const double *vertex[] = {ORIGIN, e[0], e[1], e[2]};
    return shape ? share_at(shape, e) : pl_radius_ratio_square(dim, vertex);
}

/** Second difference for coordinate r of edge i and c of edge j. */
static double difference_at(int dim, const pl_cell_shape *shape, double e[EDGES][3], int i, int r,
                            int j, int c) {
    const double step = 0x1p-12;
    double sum = 0;
    for (int k = 0; k < 4; k++) {
        const double a = k & 1 ? step : -step, b = k & 2 ? step : -step;
        double moved[EDGES][3];
        memcpy(moved, e, sizeof moved);
        moved[i][r] += a;
        moved[j][c] += b;
        sum += (a * b > 0 ? 1 : -1) * ratio_at(dim, shape, moved);
    }
    return sum / (4 * step * step);
}

/** Edges of an element that is not flat. */
static void random_edges(int dim, unsigned *seed, double e[EDGES][3]) {
    double measure = 0;
    while (measure < (dim == 3 ? 0.05 : 0.2)) {
        memset(e, 0, EDGES * sizeof *e);
        for (int q = 0; q < dim * dim; q++)
            e[q / dim][q % dim] = 2 * test_random(seed) - 1;
        measure = fabs(pl_determinant_of_edges(dim, e));
    }
}

static void pack_edges(four_elements *f) {
    for (int lane = 0; lane < LANES; lane++)
        for (int i = 0; i < EDGES; i++) {
            f->edges[i].x[lane] = f->e[lane][i][0];
            f->edges[i].y[lane] = f->e[lane][i][1];
            f->edges[i].z[lane] = f->e[lane][i][2];
        }
}

/** The shapes of the lanes' elements; all NULL: simplices measured by RR^2. */
typedef const pl_cell_shape *lane_shapes[LANES];

/** Corners of all kinds, one in each lane; in the plane two kinds twice. */
static void list_shapes(int dim, lane_shapes shape) {
    for (int lane = 0; lane < LANES; lane++)
        shape[lane] = pl_shape_of_kind(dim, dim == 3 ? lane : lane % 2);
}

/** Forms of the shapes' corners. */
static void pack_forms(int dim, const lane_shapes shape, bend_form *to) {
    pl_corner_form form[PL_N_FORMS];
    pl_corner_forms_make(dim, form);
    for (int lane = 0; lane < LANES; lane++) {
        const uint8_t corner = pl_corner_code(pl_kind_of_shape(shape[lane]), 0);
        const pl_corner_form *of = &form[pl_form_code(corner, 0, 0)];
        to->factor[lane] = of->factor * of->share;
        for (int k = 0; k < 6; k++)
            to->weight[k][lane] = of->weight[k];
    }
}

/** Set the blocks of the four elements. */
static void find_blocks(int dim, const lane_shapes shape, const four_elements *f,
                        bend_block h[BEND_BLOCKS]) {
    bend_form form;
    if (shape[0]) {
        pack_forms(dim, shape, &form);
        if (dim == 3)
            bend_corners(f->edges, &form, h, 3);
        else
            bend_corners(f->edges, &form, h, 2);
    } else if (dim == 3) {
        bend_tetrahedra(f->edges, h);
    } else {
        bend_triangles(f->edges, h);
    }
}

static void check_blocks(int dim, const lane_shapes shape) {
    static const int I[2][BEND_BLOCKS] = {{0, 0, 1}, {0, 0, 0, 1, 1, 2}};
    static const int J[2][BEND_BLOCKS] = {{0, 1, 1}, {0, 1, 2, 1, 2, 2}};
    const int n_blocks = dim * (dim + 1) / 2, size = dim * dim;
    unsigned seed = 5;
    for (int k = 0; k < 100; k++) {
        four_elements f;
        bend_block h[BEND_BLOCKS];
        for (int lane = 0; lane < LANES; lane++)
            random_edges(dim, &seed, f.e[lane]);
        pack_edges(&f);
        find_blocks(dim, shape, &f, h);
        for (int lane = 0; lane < LANES; lane++) {
            double largest = 0;
            for (int q = 0; q < n_blocks * size; q++)
                largest = fmax(largest, fabs(h[q / size][q % size][lane]));
            for (int q = 0; q < n_blocks * size; q++) {
                const int block = q / size, entry = q % size;
                const double expected =
                    difference_at(dim, shape[lane], f.e[lane], I[dim - 2][block], entry / dim,
                                  J[dim - 2][block], entry % dim);
                assert_true(fabs(h[block][entry][lane] - expected) < 1e-3 * largest);
            }
        }
    }
}

static void blocks_are_second_derivatives(void **state) {
    const lane_shapes none = {NULL, NULL, NULL, NULL};
    check_blocks(*(int *)*state, none);
}

static void blocks_of_corners_are_second_derivatives(void **state) {
    lane_shapes shape;
    list_shapes(*(int *)*state, shape);
    check_blocks(*(int *)*state, shape);
}

/** Set matrix to the blocks of one triangle. */
static void unpack_matrix(bend_block h[BEND_BLOCKS], int lane, double matrix[MOVES][MOVES]) {
    for (int r = 0; r < MOVES; r++)
        for (int c = r; c < MOVES; c++)
            matrix[r][c] = matrix[c][r] = h[r / 2 + c / 2][r % 2 * 2 + c % 2][lane];
}

/** Return x.Mx for a random x. */
static double random_form(double matrix[MOVES][MOVES], unsigned *seed) {
    double x[MOVES], sum = 0;
    for (int r = 0; r < MOVES; r++)
        x[r] = 2 * test_random(seed) - 1;
    for (int q = 0; q < MOVES * MOVES; q++)
        sum += x[q / MOVES] * matrix[q / MOVES][q % MOVES] * x[q % MOVES];
    return sum;
}

/** P is the positive part of H: P and P - H have no negative eigenvalue, and P (P - H) is 0. */
static void check_positive_part(double P[MOVES][MOVES], double H[MOVES][MOVES], unsigned *seed) {
    double rest[MOVES][MOVES], size = 0;
    for (int q = 0; q < MOVES * MOVES; q++) {
        rest[q / MOVES][q % MOVES] = P[q / MOVES][q % MOVES] - H[q / MOVES][q % MOVES];
        size = fmax(size, fabs(H[q / MOVES][q % MOVES]));
    }
    for (int q = 0; q < MOVES * MOVES; q++) {
        double product = 0;
        for (int k = 0; k < MOVES; k++)
            product += P[q / MOVES][k] * rest[k][q % MOVES];
        assert_true(fabs(product) < 1e-10 * size * size);
    }
    for (int k = 0; k < 20; k++) {
        assert_true(random_form(P, seed) > -1e-10 * size);
        assert_true(random_form(rest, seed) > -1e-10 * size);
    }
}

/** The positive part is that of the Hessian, and all of it for the edges equal of lane 0. */
static void check_positive_parts(const lane_shapes shape, double equal[EDGES][3]) {
    unsigned seed = 6;
    for (int k = 0; k < 100; k++) {
        four_elements f;
        bend_block h[BEND_BLOCKS], positive[BEND_BLOCKS];
        for (int lane = 0; lane < LANES; lane++)
            random_edges(2, &seed, f.e[lane]);
        memcpy(f.e[0], equal, sizeof f.e[0]);
        pack_edges(&f);
        find_blocks(2, shape, &f, h);
        memcpy(positive, h, sizeof h);
        bend_keep_positive(f.edges, positive);
        for (int lane = 0; lane < LANES; lane++) {
            double H[MOVES][MOVES], P[MOVES][MOVES];
            unpack_matrix(h, lane, H);
            unpack_matrix(positive, lane, P);
            check_positive_part(P, H, &seed);
            for (int q = 0; lane == 0 && q < MOVES * MOVES; q++)
                assert_true(fabs(P[q / MOVES][q % MOVES] - H[q / MOVES][q % MOVES]) < 1e-9);
        }
    }
}

static void the_positive_part_is_kept(void **state) {
    const lane_shapes none = {NULL, NULL, NULL, NULL};
    double equal[EDGES][3] = {{1, 0, 0}, {0.5, 0.86602540378443864676, 0}};
    (void)state;
    check_positive_parts(none, equal);
}

/** Lane 0 is a triangle, lane 1 a quadrilateral. */
static void the_positive_part_of_corners_is_kept(void **state) {
    double equal[EDGES][3] = {{1, 0, 0}, {0.5, 0.86602540378443864676, 0}};
    lane_shapes shape;
    (void)state;
    list_shapes(2, shape);
    check_positive_parts(shape, equal);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        BOTH(blocks_are_second_derivatives),
        BOTH(blocks_of_corners_are_second_derivatives),
        cmocka_unit_test(the_positive_part_is_kept),
        cmocka_unit_test(the_positive_part_of_corners_is_kept),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
