/* Tests of coefficients as rows of a star. */
#include "support/meshes.h"
#include "geometry/simplex.h"
#include "sweep/rows.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const int ROW_TYPES[] = {
    PLANISH_CELL_TRIANGLE,       PLANISH_CELL_TRIANGLE6,      PLANISH_CELL_QUADRILATERAL,
    PLANISH_CELL_QUADRILATERAL8, PLANISH_CELL_QUADRILATERAL9, PLANISH_CELL_TETRAHEDRON,
    PLANISH_CELL_TETRAHEDRON10,  PLANISH_CELL_HEXAHEDRON,     PLANISH_CELL_HEXAHEDRON20,
    PLANISH_CELL_HEXAHEDRON27,   PLANISH_CELL_WEDGE,          PLANISH_CELL_WEDGE15,
    PLANISH_CELL_WEDGE18,
};
enum { N_ROW_TYPES = sizeof ROW_TYPES / sizeof *ROW_TYPES };

static void assert_near(double a, double b, double tolerance) {
    assert_true(fabs(a - b) <= tolerance);
}

static double noise(uint64_t *state) {
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) * 0x1p-52 - 1;
}

/** Make an element with corners at random, and nodes off their middle by bend: x [n_nodes][dim]. */
static void make_element(const pl_row_rule *rule, double bend, uint64_t *state, double *x) {
    const pl_cell_type *type = rule->jacobian.type;
    const pl_cell_shape *shape = type->shape;
    const int dim = shape->dim;
    for (int i = 0; i < type->n_nodes; i++) {
        double place[3] = {0};
        int n = 0;
        for (int c = 0; c < shape->n_corners; c++) {
            if (!(rule->jacobian.straight[i] >> c & 1))
                continue;
            n++;
            for (int d = 0; d < dim; d++) {
                int first = 0, s = 0; /* direction d is in simplex s, whose first one is first */
                while (d >= first + shape->n_vertices[s] - 1)
                    first += shape->n_vertices[s++] - 1;
                place[d] +=
                    i < shape->n_corners ? shape->vertex[c][s] == d - first + 1 : x[c * dim + d];
            }
        }
        for (int d = 0; d < dim; d++)
            x[i * dim + d] = place[d] / n + (i < shape->n_corners ? 0.2 : bend) * noise(state);
    }
}

/** The rows are the coefficients of validity.h, and what they become where the handle has moved. */
static void rows_tell_what_a_move_does(void **unused) {
    uint64_t state = 7;
    (void)unused;
    for (int t = 0; t < N_ROW_TYPES; t++) {
        pl_row_rule *rule = pl_row_rule_make(pl_cell_type_of(ROW_TYPES[t]));
        const int n_nodes = rule->jacobian.n_nodes, dim = rule->jacobian.type->shape->dim;
        for (int handle = 0; handle < n_nodes; handle++) {
            double x[PL_CELL_NODES * 3], rate[PL_CELL_NODES] = {0}, way[3] = {0};
            double coefficient[PL_JACOBIAN_COEFFICIENTS], ones[PL_JACOBIAN_LANES];
            pl_star_row row[PL_JACOBIAN_COEFFICIENTS], moved[PL_JACOBIAN_COEFFICIENTS];
            uint8_t index[PL_JACOBIAN_COEFFICIENTS];
            make_element(rule, 0.1, &state, x);
            pl_row_handle(rule, handle, rate);
            const int n = pl_rows_of_element(rule, x, 1, rate, 1, row, index);
            pl_row_coefficients(rule, x, 1, coefficient);
            static pl_jacobian_block b;
            for (int l = 0; l < PL_JACOBIAN_LANES; l++) {
                ones[l] = 1;
                for (int i = 0; i < n_nodes * dim; i++)
                    b.x[i / dim][i % dim][l] = x[i] - x[i % dim];
            }
            pl_jacobian_evaluate(&rule->jacobian, ones, &b);
            for (int c = 0; c < rule->jacobian.n_coefficients; c++)
                assert_near(coefficient[c] * rule->unit, b.coefficient[c][0], 1e-12 * rule->unit);
            for (int d = 0; d < dim; d++)
                way[d] = noise(&state);
            for (int i = 0; i < n_nodes * dim; i++)
                x[i] += rate[i / dim] * way[i % dim];
            assert_int_equal(pl_rows_of_element(rule, x, 1, rate, 1, moved, NULL), n);
            for (int i = 0; i < n; i++) {
                double e = row[i].e, D = row[i].D0;
                assert_near(row[i].D0, coefficient[index[i]], 1e-13);
                for (int d = 0; d < dim; d++) {
                    e += (2 * row[i].slope_e[d] + row[i].c * way[d]) * way[d];
                    D += row[i].slope_d[d] * way[d];
                }
                assert_near(moved[i].e, e, 1e-11);
                assert_near(moved[i].D0, D, 1e-11);
            }
            /* coefficients without a row stay */
            double after[PL_JACOBIAN_COEFFICIENTS];
            pl_row_coefficients(rule, x, 1, after);
            for (int c = 0, i = 0; c < rule->jacobian.n_coefficients; c++) {
                if (i < n && index[i] == c)
                    i++;
                else
                    assert_near(after[c], coefficient[c], 1e-12);
            }
        }
        pl_row_rule_free(rule);
    }
}

/** Rows of straight simplices, and those at corners of linear elements, are mean ratios. */
static void rows_are_mean_ratios_of_corners(void **unused) {
    uint64_t state = 11;
    (void)unused;
    for (int t = 0; t < N_ROW_TYPES; t++) {
        pl_row_rule *rule = pl_row_rule_make(pl_cell_type_of(ROW_TYPES[t]));
        const pl_cell_type *type = rule->jacobian.type;
        const pl_cell_shape *shape = type->shape;
        const int dim = shape->dim, is_simplex = shape->n_corners == dim + 1;
        if (type->order == 2 && !is_simplex) {
            pl_row_rule_free(rule);
            continue;
        }
        double x[PL_CELL_NODES * 3], rate[PL_CELL_NODES] = {0};
        pl_star_row row[PL_JACOBIAN_COEFFICIENTS];
        pl_corner_form form[PL_N_FORMS];
        pl_corner_forms_make(dim, form);
        make_element(rule, 0, &state, x);
        for (int i = 0; i < type->n_nodes; i++)
            rate[i] = 1 + i; /* so that every row depends on it */
        const int n = pl_rows_of_element(rule, x, 1, rate, 1, row, NULL);
        assert_int_equal(n, rule->jacobian.n_coefficients);
        const uint8_t code =
            pl_form_code(pl_corner_code(pl_kind_of_shape(shape), 0), 0, 0); /* x is the corner */
        for (int c = 0; c < shape->n_corners; c++) {
            const double *p = x + c * dim, *q[3] = {0};
            double edge[3][3] = {{0}}, E = 0, D;
            for (int k = 0; k < dim; k++) {
                q[k] = x + shape->neighbour[c][k] * dim;
                for (int d = 0; d < dim; d++)
                    edge[k][d] = q[k][d] - p[d];
            }
            edge[2][2] = dim == 2 ? 1 : edge[2][2];
            D = 0;
            for (int d = 0; d < 3; d++)
                D += edge[0][d] * (edge[1][(d + 1) % 3] * edge[2][(d + 2) % 3] -
                                   edge[1][(d + 2) % 3] * edge[2][(d + 1) % 3]);
            for (int k = 0, pair = dim; k < dim; k++) {
                E += form[code].weight[k] * (edge[k][0] * edge[k][0] + edge[k][1] * edge[k][1] +
                                             (dim == 3 ? edge[k][2] * edge[k][2] : 0));
                for (int m = k + 1; m < dim; m++, pair++)
                    for (int d = 0; d < dim; d++)
                        E += form[code].weight[pair] * (q[m][d] - q[k][d]) * (q[m][d] - q[k][d]);
            }
            for (int i = 0; i < n; i++)
                if (is_simplex || i == rule->jacobian.corner[c]) {
                    assert_near(row[i].D0, D, 1e-12);
                    assert_near(row[i].e, E, 1e-12);
                    assert_near(row[i].factor, form[code].factor, 1e-15);
                }
        }
        pl_row_rule_free(rule);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_tell_what_a_move_does),
        cmocka_unit_test(rows_are_mean_ratios_of_corners),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
