/* Tests of src/quality/validity.c and src/geometry/jacobian.c against shape functions that are
 * written down here by type, and against samples of det J. */
#include "quality/validity.h"

#include "planish/planish.h"
#include "support/effort.h"

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <stdio.h>
#include <cmocka.h>

static const int TYPES[] = {
    PLANISH_CELL_TRIANGLE,       PLANISH_CELL_TRIANGLE6,      PLANISH_CELL_QUADRILATERAL,
    PLANISH_CELL_QUADRILATERAL8, PLANISH_CELL_QUADRILATERAL9, PLANISH_CELL_TETRAHEDRON,
    PLANISH_CELL_TETRAHEDRON10,  PLANISH_CELL_HEXAHEDRON,     PLANISH_CELL_HEXAHEDRON20,
    PLANISH_CELL_HEXAHEDRON27,   PLANISH_CELL_WEDGE,          PLANISH_CELL_WEDGE15,
    PLANISH_CELL_WEDGE18,        PLANISH_CELL_PYRAMID,
};
enum { N_TYPES = sizeof TYPES / sizeof *TYPES, NODES = PL_CELL_NODES };

typedef double points[NODES][3];

/* ---- Reference elements, by VTK's figures ---------------------------------------------------- */

static const double TRIANGLE[][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {.5, 0, 0}, {.5, .5, 0}, {0, .5, 0}};
static const double QUADRILATERAL[][3] = {{0, 0, 0},  {1, 0, 0},  {1, 1, 0},  {0, 1, 0}, {.5, 0, 0},
                                          {1, .5, 0}, {.5, 1, 0}, {0, .5, 0}, {.5, .5, 0}};
static const double TETRAHEDRON[][3] = {{0, 0, 0},   {1, 0, 0},  {0, 1, 0},  {0, 0, 1},   {.5, 0, 0},
                                        {.5, .5, 0}, {0, .5, 0}, {0, 0, .5}, {.5, 0, .5}, {0, .5, .5}};
static const double HEXAHEDRON[][3] = {
    {0, 0, 0},   {1, 0, 0},   {1, 1, 0},   {0, 1, 0},   {0, 0, 1},   {1, 0, 1},   {1, 1, 1},
    {0, 1, 1},   {.5, 0, 0},  {1, .5, 0},  {.5, 1, 0},  {0, .5, 0},  {.5, 0, 1},  {1, .5, 1},
    {.5, 1, 1},  {0, .5, 1},  {0, 0, .5},  {1, 0, .5},  {1, 1, .5},  {0, 1, .5},  {0, .5, .5},
    {1, .5, .5}, {.5, 0, .5}, {.5, 1, .5}, {.5, .5, 0}, {.5, .5, 1}, {.5, .5, .5}};
static const double WEDGE[][3] = {{0, 0, 0},  {1, 0, 0},  {0, 1, 0},   {0, 0, 1},   {1, 0, 1},  {0, 1, 1},
                                  {.5, 0, 0}, {.5, .5, 0}, {0, .5, 0}, {.5, 0, 1},  {.5, .5, 1}, {0, .5, 1},
                                  {0, 0, .5}, {1, 0, .5}, {0, 1, .5},  {.5, 0, .5}, {.5, .5, .5}, {0, .5, .5}};
static const double PYRAMID[][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {.5, .5, .7}};

static const double (*reference(int type))[3] {
    switch (pl_cell_type_of(type)->shape->n_corners) {
    case 3:
        return TRIANGLE;
    case 4:
        return pl_cell_type_of(type)->shape->dim == 2 ? QUADRILATERAL : TETRAHEDRON;
    case 5:
        return PYRAMID;
    case 6:
        return WEDGE;
    default:
        return HEXAHEDRON;
    }
}

/** Lagrange's polynomial on the line that is 1 at the place at (0, 1/2, 1) and 0 at the others. */
static double on_line(int order, double at, double t) {
    if (order == 1)
        return at > 0.5 ? t : 1 - t;
    return at < 0.25 ? (1 - t) * (1 - 2 * t) : at < 0.75 ? 4 * t * (1 - t) : t * (2 * t - 1);
}

/** The same on a simplex; at and t have dim components. */
static double on_simplex(int order, int dim, const double at[], const double t[]) {
    double first = 1, first_at = 1, product = 1;
    for (int d = 0; d < dim; d++) {
        first -= t[d];
        first_at -= at[d];
    }
    for (int d = -1; d < dim; d++) {
        const double lambda = d < 0 ? first : t[d], place = d < 0 ? first_at : at[d];
        if (place > 0.75)
            product *= order == 1 ? lambda : lambda * (2 * lambda - 1);
        else if (place > 0.25)
            product *= 2 * lambda;
    }
    return product;
}

/** Serendipity quadrilaterals and hexahedra, in -1 .. 1. */
static double serendipity(int dim, const double at[], const double t[]) {
    double product = 1, sum = 0;
    int n_middle = 0;
    for (int d = 0; d < dim; d++) {
        const double x = 2 * t[d] - 1, place = 2 * at[d] - 1;
        const int is_middle = place == 0;
        n_middle += is_middle;
        product *= is_middle ? 1 - x * x : (1 + x * place) / 2;
        sum += x * place;
    }
    return n_middle > 0 ? product : product * (sum - (dim - 1));
}

static double shape_function(int type, int node, const double t[3]) {
    const double *at = reference(type)[node];
    const int order = pl_cell_type_of(type)->order;
    switch (type) {
    case PLANISH_CELL_TRIANGLE:
    case PLANISH_CELL_TRIANGLE6:
        return on_simplex(order, 2, at, t);
    case PLANISH_CELL_TETRAHEDRON:
    case PLANISH_CELL_TETRAHEDRON10:
        return on_simplex(order, 3, at, t);
    case PLANISH_CELL_QUADRILATERAL8:
        return serendipity(2, at, t);
    case PLANISH_CELL_HEXAHEDRON20:
        return serendipity(3, at, t);
    case PLANISH_CELL_QUADRILATERAL:
    case PLANISH_CELL_QUADRILATERAL9:
        return on_line(order, at[0], t[0]) * on_line(order, at[1], t[1]);
    case PLANISH_CELL_WEDGE:
    case PLANISH_CELL_WEDGE18:
        return on_simplex(order, 2, at, t) * on_line(order, at[2], t[2]);
    case PLANISH_CELL_WEDGE15: {
        const double flat[2] = {at[0], at[1]}, z = 2 * t[2] - 1, side = 2 * at[2] - 1;
        const double lambda = on_simplex(1, 2, flat, t);
        if (side == 0)
            return lambda * (1 - z * z);
        if (node >= 6)
            return on_simplex(2, 2, at, t) * (1 + side * z) / 2;
        return lambda * (1 + side * z) * (2 * lambda - 1) / 2 - lambda * (1 - z * z) / 2;
    }
    case PLANISH_CELL_PYRAMID: { /* collapsed: z is the share of the apex */
        if (node == 4)
            return t[2];
        return on_line(1, at[0], t[0]) * on_line(1, at[1], t[1]) * (1 - t[2]);
    }
    default:
        return on_line(order, at[0], t[0]) * on_line(order, at[1], t[1]) * on_line(order, at[2], t[2]);
    }
}

/** det J at t. Shape functions have degree 2 in each variable at most, so that differences over a
 *  step are exact. */
static double determinant_at(int type, const points x, const double t[3]) {
    const pl_cell_type *of = pl_cell_type_of(type);
    const int dim = of->shape->dim, n = type == PLANISH_CELL_PYRAMID ? 5 : of->n_nodes;
    double j[3][3] = {{0}, {0}, {0, 0, dim == 2}};
    for (int m = 0; m < dim; m++) {
        double after[3] = {t[0], t[1], t[2]}, before[3] = {t[0], t[1], t[2]};
        after[m] += 0.25;
        before[m] -= 0.25;
        for (int i = 0; i < n; i++) {
            const double slope = 2 * (shape_function(type, i, after) - shape_function(type, i, before));
            for (int d = 0; d < dim; d++)
                j[m][d] += slope * x[i][d];
        }
    }
    return j[0][0] * (j[1][1] * j[2][2] - j[1][2] * j[2][1]) -
           j[0][1] * (j[1][0] * j[2][2] - j[1][2] * j[2][0]) +
           j[0][2] * (j[1][0] * j[2][1] - j[1][1] * j[2][0]);
}

/* ---- Elements -------------------------------------------------------------------------------- */

static pl_jacobian_rule *rule_of(int type) {
    pl_jacobian_rule *rule = malloc(sizeof *rule);
    assert_non_null(rule);
    pl_jacobian_rule_make(pl_cell_type_of(type), rule);
    return rule;
}

/** The reference element with its nodes pushed about. */
static void random_element(int type, double push, uint64_t *state, points x) {
    const pl_cell_type *of = pl_cell_type_of(type);
    for (int i = 0; i < of->n_nodes; i++)
        for (int d = 0; d < 3; d++)
            x[i][d] = d < of->shape->dim
                          ? reference(type)[i][d] + push * (2 * random_unit(state) - 1)
                          : 0;
}

static void fill_block(const pl_jacobian_rule *rule, int l, const points x, pl_jacobian_block *b) {
    for (int i = 0; i < rule->n_nodes; i++)
        for (int d = 0; d < 3; d++)
            b->x[i][d][l] = x[i][d] - (rule->type->order == 2 ? x[0][d] : 0);
}

static const double POSITIVE[PL_JACOBIAN_LANES] = {1, 1, 1, 1, 1, 1, 1, 1};

static pl_validity validity_of(const pl_jacobian_rule *rule, const points x, pl_jacobian_block *b) {
    const int dim = rule->type->shape->dim;
    double coordinates[NODES * 3];
    int32_t node[NODES];
    for (int i = 0; i < rule->n_nodes; i++) {
        node[i] = i;
        for (int d = 0; d < dim; d++)
            coordinates[i * dim + d] = x[i][d];
    }
    for (int l = 0; l < PL_JACOBIAN_LANES; l++)
        fill_block(rule, l, x, b);
    pl_jacobian_evaluate(rule, POSITIVE, b);
    return pl_validity_of_lane(rule, b, 3, node, coordinates, 1);
}

static void shape_functions_are_those_of_the_nodes(void **state) {
    (void)state;
    for (int k = 0; k < N_TYPES; k++) {
        const pl_cell_type *of = pl_cell_type_of(TYPES[k]);
        for (int i = 0; TYPES[k] != PLANISH_CELL_PYRAMID && i < of->n_nodes; i++)
            for (int j = 0; j < of->n_nodes; j++)
                assert_true(fabs(shape_function(TYPES[k], i, reference(TYPES[k])[j]) - (i == j)) < 1e-12);
    }
}


static void coefficients_enclose_the_determinant(void **state) {
    (void)state;
    pl_jacobian_block b;
    uint64_t random = 1;
    for (int k = 0; k < N_TYPES; k++) {
        pl_jacobian_rule *rule = rule_of(TYPES[k]);
        const int dim = rule->type->shape->dim;
        const double scale = rule->common * pow(rule->n_control_terms ? 4.0 * (1 << rule->type->shape->n_simplices) : 1, dim) / (rule->type->order == 2 ? 1 << dim : 1);
        for (int repeat = 0; repeat < 200; repeat++) {
            points x;
            random_element(TYPES[k], 0.2, &random, x);
            validity_of(rule, x, &b);
            double least = INFINITY, largest = -INFINITY;
            for (int c = 0; c < rule->n_coefficients; c++) {
                least = fmin(least, b.coefficient[c][0]);
                largest = fmax(largest, b.coefficient[c][0]);
            }
            assert_true(b.least[0] == least);
            for (int c = 0; c < rule->n_corners; c++)
                assert_true(fabs(b.coefficient[rule->corner[c]][0] - scale * determinant_at(TYPES[k], x, reference(TYPES[k])[c])) < 1e-9 * scale);
            for (int i = 0; i < 50; i++) {
                double t[3];
                do
                    for (int d = 0; d < 3; d++)
                        t[d] = random_unit(&random);
                while (rule->type->shape->n_vertices[0] > 2 && t[0] + t[1] + (rule->type->shape->n_vertices[0] > 3 ? t[2] : 0) > 1);
                if (TYPES[k] == PLANISH_CELL_PYRAMID)
                    t[2] = 0;
                const double value = scale * determinant_at(TYPES[k], x, t);
                assert_true(value > least - 1e-9 * scale && value < largest + 1e-9 * scale);
            }
        }
        free(rule);
    }
}

static void verdicts(void **state) {
    (void)state;
    pl_jacobian_block b;
    uint64_t random = 2;
    for (int k = 0; k < N_TYPES; k++) {
        pl_jacobian_rule *rule = rule_of(TYPES[k]);
        int count[3] = {0}, wrong = 0, unseen = 0;
        for (int repeat = 0; repeat < 20000; repeat++) {
            points x;
            random_element(TYPES[k], 0.05 + 0.3 * random_unit(&random), &random, x);
            const pl_validity v = validity_of(rule, x, &b);
            count[v]++;
            double low = INFINITY;
            enum { N = 8 };
            for (int i = 0; i <= N; i++) for (int j = 0; j <= N; j++) for (int m = 0; m <= N; m++) {
                const double t[3] = {i / (double)N, j / (double)N, TYPES[k] == PLANISH_CELL_PYRAMID ? 0 : m / (double)N};
                if (rule->type->shape->n_vertices[0] > 2 && t[0] + t[1] + (rule->type->shape->n_vertices[0] > 3 ? t[2] : 0) > 1) continue;
                low = fmin(low, determinant_at(TYPES[k], x, t));
            }
            if (v == PL_VALID && low <= -1e-12) wrong++;
            if (v == PL_INVALID && low > 0) unseen++;
        }
        printf("%-28s invalid %5d valid %5d open %d, sample contradicts %d, not seen by samples %d\n", rule->type->name, count[0], count[1], count[2], wrong, unseen);
        free(rule);
    }
}

#include <time.h>
static void speed(void **state) {
    (void)state;
    static pl_jacobian_block b;
    uint64_t random = 2;
    for (int k = 0; k < N_TYPES; k++) {
        pl_jacobian_rule *rule = rule_of(TYPES[k]);
        points x;
        for (int l = 0; l < 8; l++) { random_element(TYPES[k], 0.05, &random, x); fill_block(rule, l, x, &b);}
        clock_t t = clock();
        for (int i = 0; i < 100000; i++) pl_jacobian_evaluate(rule, POSITIVE, &b);
        printf("%-28s %.2f M/s\n", rule->type->name, 0.8e6 / ((double)(clock() - t) / (double)CLOCKS_PER_SEC) / 1e6);
        free(rule);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shape_functions_are_those_of_the_nodes),
        cmocka_unit_test(coefficients_enclose_the_determinant),
        cmocka_unit_test(verdicts),
        cmocka_unit_test(speed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
