/* Tests of src/quality/validity.c and src/geometry/jacobian.c against shape functions that are
 * written down here by type, samples of det J, quad precision, and exact decisions. */
#include "quality/validity.h"

#include "base/exact.h"
#include "support/effort.h"
#include "support/loose_cells.h"
#include "support/shape_functions.h"

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>
#include <planish/planish.h>

static const int TYPES[] = {
    PLANISH_CELL_TRIANGLE,       PLANISH_CELL_TRIANGLE6,      PLANISH_CELL_QUADRILATERAL,
    PLANISH_CELL_QUADRILATERAL8, PLANISH_CELL_QUADRILATERAL9, PLANISH_CELL_TETRAHEDRON,
    PLANISH_CELL_TETRAHEDRON10,  PLANISH_CELL_HEXAHEDRON,     PLANISH_CELL_HEXAHEDRON20,
    PLANISH_CELL_HEXAHEDRON27,   PLANISH_CELL_WEDGE,          PLANISH_CELL_WEDGE15,
    PLANISH_CELL_WEDGE18,        PLANISH_CELL_PYRAMID,
};
enum { N_TYPES = sizeof TYPES / sizeof *TYPES, NODES = SHAPE_NODES };

typedef double points[NODES][3];

static double determinant_of(int type, const points x, const double slope[NODES][3]) {
    const pl_cell_type *of = pl_cell_type_of(type);
    const int dim = of->shape->dim;
    double j[3][3] = {{0}, {0}, {0, 0, dim == 2}};
    for (int i = 0; i < of->n_nodes; i++)
        for (int m = 0; m < dim; m++)
            for (int d = 0; d < dim; d++)
                j[m][d] += slope[i][m] * x[i][d];
    return j[0][0] * (j[1][1] * j[2][2] - j[1][2] * j[2][1]) -
           j[0][1] * (j[1][0] * j[2][2] - j[1][2] * j[2][0]) +
           j[0][2] * (j[1][0] * j[2][1] - j[1][1] * j[2][0]);
}

static double determinant_at(int type, const points x, const double t[3]) {
    double slope[NODES][3];
    shape_slopes(type, t, slope);
    return determinant_of(type, x, slope);
}

/** Whether t is in the reference shape, of a pyramid in its base. */
static int is_inside(int type, const double t[3]) {
    const pl_cell_shape *shape = pl_cell_type_of(type)->shape;
    if (type == PLANISH_CELL_PYRAMID || shape->dim == 2) /* what stands in for one plane */
        return t[2] == 0 && (shape->n_corners != 3 || t[0] + t[1] <= 1);
    if (shape->n_corners == 4)
        return t[0] + t[1] + t[2] <= 1;
    return shape->n_corners != 6 || t[0] + t[1] <= 1;
}

/* ---- Elements -------------------------------------------------------------------------------- */

static const double POSITIVE[PL_JACOBIAN_LANES] = {1, 1, 1, 1, 1, 1, 1, 1};
static const double NEGATIVE[PL_JACOBIAN_LANES] = {-1, -1, -1, -1, -1, -1, -1, -1};

static pl_jacobian_rule *rule_of(int type) {
    pl_jacobian_rule *rule = malloc(sizeof *rule);
    assert_non_null(rule);
    pl_jacobian_rule_make(pl_cell_type_of(type), rule);
    return rule;
}

/** Coefficients are det J times this. */
static double scale_of(const pl_jacobian_rule *rule) {
    const int dim = rule->type->shape->dim, n_simplices = rule->type->shape->n_simplices;
    if (rule->n_control_terms == 0)
        return rule->common;
    return rule->common * pow(4.0 * (1 << n_simplices) / 2, dim); /* det J has a 2 per direction */
}

/** The reference element with its nodes pushed about. */
static void random_element(int type, double push, uint64_t *state, points x) {
    const pl_cell_type *of = pl_cell_type_of(type);
    for (int i = 0; i < of->n_nodes; i++)
        for (int d = 0; d < 3; d++)
            x[i][d] = d < of->shape->dim
                          ? shape_place(type)[i][d] + push * (2 * random_unit(state) - 1)
                          : 0;
}

/** An element as the mesh has it. */
typedef struct element {
    const pl_jacobian_rule *rule;
    int32_t node[NODES];
    double coordinates[NODES * 3];
    pl_jacobian_block block;
} element;

/** Evaluate the element at x in all lanes; bit i of missing: node i is not there. */
static void evaluate(element *e, const pl_jacobian_rule *rule, const points x, unsigned missing,
                     const double sign[]) {
    const int dim = rule->type->shape->dim;
    e->rule = rule;
    for (int i = 0; i < rule->n_nodes; i++) {
        const int is_missing = missing >> i & 1;
        const uint8_t *pair = rule->type->between[i];
        e->node[i] = is_missing ? -1 : i;
        for (int d = 0; d < dim; d++) {
            const double first = rule->n_control_terms > 0 ? x[0][d] : 0;
            e->coordinates[i * dim + d] = x[i][d];
            for (int l = 0; l < PL_JACOBIAN_LANES; l++)
                e->block.x[i][d][l] =
                    is_missing ? 0.5 * (e->block.x[pair[0]][d][l] + e->block.x[pair[1]][d][l])
                               : x[i][d] - first;
        }
    }
    pl_jacobian_evaluate(rule, sign, &e->block);
}

static pl_validity decide(const element *e, double sign) {
    return pl_validity_of_lane(e->rule, &e->block, 3, e->node, e->coordinates, sign);
}

static pl_validity validity_of(const pl_jacobian_rule *rule, const points x) {
    element e;
    evaluate(&e, rule, x, 0, POSITIVE);
    return decide(&e, 1);
}

static unsigned random_missing(const pl_cell_type *type, uint64_t *random) {
    unsigned missing = 0;
    for (int i = 0; type->order == 2 && i < type->shape->n_edges; i++)
        missing |= (unsigned)random_below(random, 2) << (type->shape->n_corners + i);
    return missing;
}

/** The reference element. */
static void take_reference(int type, points x) {
    memcpy(x, shape_place(type), (size_t)pl_cell_type_of(type)->n_nodes * sizeof *x);
}

/* ---- Rules ----------------------------------------------------------------------------------- */

static void shape_functions_are_those_of_the_nodes(void **state) {
    (void)state;
    for (int k = 0; k < N_TYPES; k++) {
        const pl_cell_type *of = pl_cell_type_of(TYPES[k]);
        for (int i = 0; TYPES[k] != PLANISH_CELL_PYRAMID && i < of->n_nodes; i++)
            for (int j = 0; j < of->n_nodes; j++)
                assert_true(fabs(shape_value(TYPES[k], i, shape_place(TYPES[k])[j]) - (i == j)) <
                            1e-12);
    }
}

static void types_are_found_by_their_numbers(void **state) {
    (void)state;
    int n = 0;
    for (int number = -1; number <= UINT8_MAX + 1; number++) {
        const pl_cell_type *type = pl_cell_type_of(number);
        if (!type)
            continue;
        n++;
        assert_int_equal(type->type, number);
    }
    assert_int_equal(n, PLANISH_N_CELL_TYPES);
}

static void products_of_a_coefficient_add_up_to_a_mean(void **state) {
    (void)state;
    for (int k = 0; k < N_TYPES; k++) {
        pl_jacobian_rule *rule = rule_of(TYPES[k]);
        int sum[PL_JACOBIAN_COEFFICIENTS] = {0}, n[PL_JACOBIAN_COEFFICIENTS] = {0};
        for (int p = 0; p < rule->n_products; p++) {
            const int c = rule->product[p].coefficient;
            sum[c] += rule->product[p].weight * rule->factor[c];
            n[c]++;
        }
        for (int c = 0; c < rule->n_coefficients; c++) {
            assert_int_equal(sum[c], rule->common);
            assert_in_range(n[c], 1, rule->n_products_each);
        }
        free(rule);
    }
}

/** Halves of a polynomial are means, of at most 6 coefficients. */
static void halves_are_means(void **state) {
    (void)state;
    for (int k = 0; k < N_TYPES; k++) {
        pl_jacobian_rule *rule = rule_of(TYPES[k]);
        for (int s = 0; s < rule->type->shape->n_simplices; s++)
            for (int half = 0; half < 2; half++) {
                int sum[PL_JACOBIAN_COEFFICIENTS] = {0}, n[PL_JACOBIAN_COEFFICIENTS] = {0};
                for (int t = 0; t < rule->n_half_terms[s][half]; t++) {
                    const pl_jacobian_term *term = &rule->half_term[s][half][t];
                    assert_true(term->weight > 0 && term->from < rule->n_coefficients);
                    sum[term->to] += term->weight;
                    n[term->to]++;
                }
                for (int c = 0; c < rule->n_coefficients; c++) {
                    assert_int_equal(sum[c], 1 << rule->half_shift[s]);
                    assert_in_range(n[c], 1, 6);
                }
            }
        free(rule);
    }
}

/** The largest integers of an exact decision have room, whatever the coordinates. */
static void limbs_suffice(void **state) {
    (void)state;
    for (int k = 0; k < N_TYPES; k++) {
        pl_jacobian_rule *rule = rule_of(TYPES[k]);
        const int dim = rule->type->shape->dim;
        const double weight = rule->n_control_terms > 0 ? rule->control_weight : 1;
        double bits = dim * (2099 + 1 + log2(weight) + 1); /* twice a difference; of two controls */
        bits += log2((dim == 3 ? 6 : 2) * rule->common);
        for (int depth = 0; depth < PL_VALIDITY_DEPTH && rule->n_turns > 0; depth++)
            bits += rule->half_shift[rule->turn[depth % rule->n_turns]];
        /* A product has room for the limbs of both factors, each of which may be filled by a bit. */
        assert_true(ceil(bits / 32) + 2 <= PL_EXACT_LIMBS);
        free(rule);
    }
}

/* ---- Coefficients ---------------------------------------------------------------------------- */

static void coefficients_enclose_the_determinant(void **state) {
    (void)state;
    element e;
    uint64_t random = effort_seed(1);
    for (int k = 0; k < N_TYPES; k++) {
        pl_jacobian_rule *rule = rule_of(TYPES[k]);
        const double scale = scale_of(rule);
        for (int64_t repeat = effort(50, 1000); repeat > 0; repeat--) {
            points x;
            random_element(TYPES[k], 0.2, &random, x);
            evaluate(&e, rule, x, 0, POSITIVE);
            double least = INFINITY, largest = -INFINITY;
            for (int c = 0; c < rule->n_coefficients; c++) {
                least = fmin(least, e.block.coefficient[c][0]);
                largest = fmax(largest, e.block.coefficient[c][0]);
            }
            assert_true(e.block.least[0] == least);
            for (int c = 0; c < rule->n_corners; c++) {
                const double value = determinant_at(TYPES[k], x, shape_place(TYPES[k])[c]);
                assert_true(fabs(e.block.coefficient[rule->corner[c]][0] - scale * value) <
                            1e-9 * scale);
            }
            for (int i = 0; i < 50; i++) {
                double t[3];
                do
                    for (int d = 0; d < 3; d++)
                        t[d] = d < 2 || (rule->type->shape->dim == 3 &&
                                         TYPES[k] != PLANISH_CELL_PYRAMID)
                                   ? random_unit(&random)
                                   : 0;
                while (!is_inside(TYPES[k], t));
                const double value = scale * determinant_at(TYPES[k], x, t);
                assert_true(value > least - 1e-9 * scale && value < largest + 1e-9 * scale);
            }
        }
        free(rule);
    }
}

/** Place of a vertex of half a simplex whose first and last vertex are parted at the middle. */
static void place_in_half(const pl_cell_shape *shape, int s, int half, int vertex, double t[3]) {
    int first = 0; /* direction of the simplex */
    const int last = shape->n_vertices[s] - 1;
    for (int before = 0; before < s; before++)
        first += shape->n_vertices[before] - 1;
    for (int v = 1; v <= last; v++)
        t[first + v - 1] = 0;
    if (vertex == 0 && half == 1)
        t[first + last - 1] = 1;
    if (vertex == 1)
        t[first + last - 1] = 0.5;
    if (vertex > 1)
        t[first + vertex - 2] = 1;
}

static void halves_have_the_determinant_at_their_corners(void **state) {
    (void)state;
    element e;
    uint64_t random = effort_seed(2);
    for (int k = 0; k < N_TYPES; k++) {
        pl_jacobian_rule *rule = rule_of(TYPES[k]);
        const pl_cell_shape *shape = rule->type->shape;
        for (int s = 0; s < shape->n_simplices; s++)
            for (int half = 0; half < 2; half++) {
                points x;
                random_element(TYPES[k], 0.3, &random, x);
                evaluate(&e, rule, x, 0, POSITIVE);
                double b[PL_JACOBIAN_COEFFICIENTS] = {0};
                for (int i = 0; i < rule->n_half_terms[s][half]; i++) {
                    const pl_jacobian_term *term = &rule->half_term[s][half][i];
                    b[term->to] += ldexp(term->weight * e.block.coefficient[term->from][0],
                                         -rule->half_shift[s]);
                }
                for (int c = 0; c < shape->n_corners; c++) {
                    double t[3];
                    memcpy(t, shape_place(TYPES[k])[c], sizeof t);
                    place_in_half(shape, s, half, shape->vertex[c][s], t);
                    const double value = scale_of(rule) * determinant_at(TYPES[k], x, t);
                    assert_true(fabs(b[rule->corner[c]] - value) < 1e-9 * scale_of(rule));
                }
            }
        free(rule);
    }
}

__extension__ typedef __float128 quad;

/** Coefficients by the rule, in quad precision, of the element's exact places. */
static void find_quad_coefficients(const element *e, quad b[]) {
    const pl_jacobian_rule *rule = e->rule;
    const int dim = rule->type->shape->dim;
    static quad x[NODES][3], control[NODES][3], derivative[3][PL_JACOBIAN_DERIVATIVES][3];
    for (int i = 0; i < rule->n_nodes; i++)
        for (int d = 0; d < dim; d++) {
            const uint8_t *pair = rule->type->between[i];
            x[i][d] = e->node[i] >= 0 ? (quad)e->coordinates[i * dim + d]
                                      : (x[pair[0]][d] + x[pair[1]][d]) / 2;
        }
    memcpy(control, x, sizeof x);
    if (rule->n_control_terms > 0)
        memset(control, 0, sizeof control);
    for (int t = 0; t < rule->n_control_terms; t++)
        for (int d = 0; d < dim; d++)
            control[rule->control_term[t].to][d] +=
                rule->control_term[t].weight * x[rule->control_term[t].from][d];
    for (int m = 0; m < dim; m++)
        for (int i = 0; i < rule->n_derivatives[m]; i++)
            for (int d = 0; d < dim; d++)
                derivative[m][i][d] = control[rule->derivative[m][i].plus][d] -
                                      control[rule->derivative[m][i].minus][d];
    for (int c = 0; c < rule->n_coefficients; c++)
        b[c] = 0;
    for (int p = 0; p < rule->n_products; p++) {
        const pl_jacobian_product *product = &rule->product[p];
        const quad *u = derivative[0][product->i], *v = derivative[1][product->j];
        const quad *w = derivative[2][product->k];
        const quad determinant = dim == 2 ? u[0] * v[1] - u[1] * v[0]
                                          : u[0] * (v[1] * w[2] - v[2] * w[1]) +
                                                u[1] * (v[2] * w[0] - v[0] * w[2]) +
                                                u[2] * (v[0] * w[1] - v[1] * w[0]);
        b[product->coefficient] +=
            product->weight * rule->factor[product->coefficient] * determinant;
    }
}

static void error_bounds_hold(void **state) {
    (void)state;
    element e;
    static quad b[PL_JACOBIAN_COEFFICIENTS];
    uint64_t random = effort_seed(3);
    for (int k = 0; k < N_TYPES; k++) {
        pl_jacobian_rule *rule = rule_of(TYPES[k]);
        for (int64_t repeat = effort(40, 4000); repeat > 0; repeat--) {
            static const double OFFSETS[] = {0, 1, 1e8, -3e12};
            const double offset = OFFSETS[random_below(&random, 4)];
            const int exponent = (int)random_below(&random, 100) - 50;
            points x;
            random_element(TYPES[k], random_unit(&random), &random, x);
            for (int i = 0; i < rule->n_nodes; i++)
                for (int d = 0; d < 3; d++)
                    x[i][d] = ldexp(x[i][d] + offset, exponent);
            evaluate(&e, rule, x, random_missing(rule->type, &random), POSITIVE);
            find_quad_coefficients(&e, b);
            for (int c = 0; c < rule->n_coefficients; c++) {
                const quad off = (quad)e.block.coefficient[c][5] - b[c];
                assert_true((off < 0 ? -off : off) <= (quad)e.block.error[5]);
            }
        }
        free(rule);
    }
}

/* ---- Verdicts -------------------------------------------------------------------------------- */

/** Slopes at the points of a grid. */
typedef struct samples {
    int n;
    double slope[1000][NODES][3];
} samples;

static samples *samples_of(int type) {
    enum { N = 6 };
    samples *s = malloc(sizeof *s);
    assert_non_null(s);
    s->n = 0;
    for (int i = 0; i < (N + 1) * (N + 1) * (N + 1); i++) {
        const double t[3] = {i % (N + 1) / (double)N, i / (N + 1) % (N + 1) / (double)N,
                             i / (N + 1) / (N + 1) / (double)N};
        if (is_inside(type, t))
            shape_slopes(type, t, s->slope[s->n++]);
    }
    return s;
}

static void verdicts_agree_with_samples(void **state) {
    (void)state;
    uint64_t random = effort_seed(4);
    for (int k = 0; k < N_TYPES; k++) {
        pl_jacobian_rule *rule = rule_of(TYPES[k]);
        samples *s = samples_of(TYPES[k]);
        int64_t n_uncertified = 0, n_of[4] = {0};
        for (int64_t repeat = effort(300, 1000000); repeat > 0; repeat--) {
            points x;
            random_element(TYPES[k], 0.05 + 0.3 * random_unit(&random), &random, x);
            const pl_validity verdict = validity_of(rule, x);
            double least = INFINITY;
            for (int i = 0; i < s->n; i++)
                least = fmin(least, determinant_of(TYPES[k], x, s->slope[i]));
            n_of[verdict]++;
            n_uncertified += verdict == PL_UNCERTIFIED;
            assert_int_not_equal(verdict, PL_OUT_OF_MEMORY);
            if (verdict == PL_VALID)
                assert_true(least > -1e-12);
            if (least <= -1e-12)
                assert_int_equal(verdict, PL_INVALID);
        }
        assert_int_equal(n_uncertified, 0);
        figure("%s: %d valid, %d invalid", rule->type->name, (int)n_of[PL_VALID],
               (int)n_of[PL_INVALID]);
        free(s);
        free(rule);
    }
}

/** Random elements with nodes at few places, so that many determinants are exactly 0; and some that
 *  differ from these by rounding. */
static void doubles_and_integers_agree(void **state) {
    (void)state;
    element e;
    uint64_t random = effort_seed(5);
    for (int k = 0; k < N_TYPES; k++) {
        pl_jacobian_rule *rule = rule_of(TYPES[k]);
        const int is_large = rule->n_coefficients > 50;
        for (int64_t repeat = is_large ? effort(4, 200) : effort(100, 5000); repeat > 0; repeat--) {
            const int steps = 1 << random_below(&random, 4), kind = (int)random_below(&random, 3);
            points x;
            random_element(TYPES[k], 0.3 * random_unit(&random), &random, x);
            for (int i = 0; i < rule->n_nodes; i++)
                for (int d = 0; d < 3; d++) {
                    const double place = round(steps * x[i][d]) / steps;
                    x[i][d] = kind == 0 ? x[i][d] : kind == 1 ? place : 1.0 / 3 + 0.1 * place;
                }
            const double sign = random_below(&random, 2) ? 1 : -1;
            evaluate(&e, rule, x, random_missing(rule->type, &random),
                     sign > 0 ? POSITIVE : NEGATIVE);
            const pl_validity verdict = decide(&e, sign);
            assert_int_equal(verdict, pl_validity_exactly(rule, e.node, e.coordinates, sign));
        }
        free(rule);
    }
}

/** Assert the verdict, and that it is the same at other places, in other sizes, mirrored. */
static void expect(int type, const points x, pl_validity verdict) {
    static const struct {
        double factor, offset;
    } FORMS[] = {{1, 0},      {0x1p-664, 0},  {0x1p664, 0}, {0x1p-30, 0},
                 {1, 0x1p26}, {0x1p-1060, 0}, {0x1p1010, 0}};
    pl_jacobian_rule *rule = rule_of(type);
    element e;
    for (size_t form = 0; form < sizeof FORMS / sizeof *FORMS; form++)
        for (int mirror = 0; mirror < 2; mirror++) {
            points other;
            memcpy(other, x, sizeof other);
            for (int i = 0; i < rule->n_nodes; i++)
                for (int d = 0; d < 3; d++) {
                    const double side = mirror && d == 0 ? -1 : 1;
                    other[i][d] = side * x[i][d] * FORMS[form].factor + FORMS[form].offset;
                }
            evaluate(&e, rule, other, 0, mirror ? NEGATIVE : POSITIVE);
            assert_int_equal(decide(&e, mirror ? -1 : 1), verdict);
        }
    free(rule);
}

static void set(points x, int i, double a, double b, double c) {
    x[i][0] = a;
    x[i][1] = b;
    x[i][2] = c;
}

static void reference_elements_are_valid(void **state) {
    (void)state;
    for (int k = 0; k < N_TYPES; k++) {
        points x;
        uint64_t random = 1;
        random_element(TYPES[k], 0, &random, x);
        for (int i = 0; i < NODES; i++) /* of whole eighths, so that offsets change no place */
            x[i][2] = TYPES[k] == PLANISH_CELL_PYRAMID && i == 4 ? 0.75 : x[i][2];
        expect(TYPES[k], x, PL_VALID);
    }
}

static void elements_of_no_size_are_invalid(void **state) {
    (void)state;
    static const double SOMEWHERE[] = {0, 0.1, 1e300};
    for (int k = 0; k < N_TYPES; k++)
        for (int i = 0; i < 3; i++) {
            points x;
            pl_jacobian_rule *rule = rule_of(TYPES[k]);
            for (int node = 0; node < NODES; node++)
                set(x, node, SOMEWHERE[i], SOMEWHERE[i], SOMEWHERE[i]);
            assert_int_equal(validity_of(rule, x), PL_INVALID);
            free(rule);
        }
}

/** A corner whose det J is exactly 0, though all others are positive. */
static void flat_corners_are_invalid(void **state) {
    (void)state;
    points x;
    take_reference(PLANISH_CELL_HEXAHEDRON, x);
    set(x, 6, 0.5, 0.5, 1); /* in the plane of its neighbours 5, 7 and the corner between */
    expect(PLANISH_CELL_HEXAHEDRON, x, PL_INVALID);
    take_reference(PLANISH_CELL_QUADRILATERAL, x);
    set(x, 2, 0.5, 0.5, 0);
    expect(PLANISH_CELL_QUADRILATERAL, x, PL_INVALID);
    set(x, 2, 0.5625, 0.5625, 0);
    expect(PLANISH_CELL_QUADRILATERAL, x, PL_VALID);
    take_reference(PLANISH_CELL_TETRAHEDRON10, x);
    set(x, 4, 0.25, 0, 0); /* the derivative at corner 0 is 4 times this less the edge */
    expect(PLANISH_CELL_TETRAHEDRON10, x, PL_INVALID);
    set(x, 4, 0.28125, 0, 0);
    expect(PLANISH_CELL_TETRAHEDRON10, x, PL_VALID);
}

/** A hexahedron that is collapsed to a wedge, and one to a tetrahedron. */
static void collapsed_hexahedra_are_invalid(void **state) {
    (void)state;
    points x;
    take_reference(PLANISH_CELL_HEXAHEDRON, x);
    memcpy(x[3], x[2], sizeof x[3]);
    memcpy(x[7], x[6], sizeof x[7]);
    expect(PLANISH_CELL_HEXAHEDRON, x, PL_INVALID);
    for (int i = 5; i < 8; i++)
        memcpy(x[i], x[4], sizeof x[i]);
    expect(PLANISH_CELL_HEXAHEDRON, x, PL_INVALID);
}

/** Bottom 1 x 1/2, top 1/2 x 1 turned by 180 degrees: all corners are fine, the middle is not. */
static void a_twisted_hexahedron_is_invalid(void **state) {
    (void)state;
    static const double SIDE[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    points x = {{0}};
    element e;
    for (int i = 0; i < 4; i++) {
        set(x, i, SIDE[i][0] / 2, SIDE[i][1] / 4, 0);
        set(x, i + 4, -SIDE[i][0] / 4, -SIDE[i][1] / 2, 100);
    }
    pl_jacobian_rule *rule = rule_of(PLANISH_CELL_HEXAHEDRON);
    evaluate(&e, rule, x, 0, POSITIVE);
    for (int c = 0; c < rule->n_corners; c++)
        assert_true(e.block.coefficient[rule->corner[c]][0] > e.block.error[0]);
    expect(PLANISH_CELL_HEXAHEDRON, x, PL_INVALID);
    free(rule);
}

/** det J is (2 t - 1)^2 along the line in the middle of a wedge or hexahedron: 0 at one place. */
static void touching_zero_is_not_valid(void **state) {
    (void)state;
    points x;
    pl_jacobian_rule *rule = rule_of(PLANISH_CELL_HEXAHEDRON);
    take_reference(PLANISH_CELL_HEXAHEDRON, x); /* turned by 180 degrees: det J = (1 - 2 t)^2 */
    for (int i = 4; i < 8; i++)
        set(x, i, 1 - shape_place(PLANISH_CELL_HEXAHEDRON)[i][0],
            1 - shape_place(PLANISH_CELL_HEXAHEDRON)[i][1], 1);
    assert_int_not_equal(validity_of(rule, x), PL_VALID);
    x[6][0] += 0x1p-40; /* a little less than that, somewhere */
    assert_int_not_equal(validity_of(rule, x), PL_VALID);
    free(rule);
    rule =
        rule_of(PLANISH_CELL_TRIANGLE6); /* a mid on the opposite side of a line: det J touches 0 */
    take_reference(PLANISH_CELL_TRIANGLE6, x);
    set(x, 4, 0.25, 0.25, 0);
    assert_int_not_equal(validity_of(rule, x), PL_VALID);
    free(rule);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shape_functions_are_those_of_the_nodes),
        cmocka_unit_test(types_are_found_by_their_numbers),
        cmocka_unit_test(products_of_a_coefficient_add_up_to_a_mean),
        cmocka_unit_test(halves_are_means),
        cmocka_unit_test(limbs_suffice),
        cmocka_unit_test(coefficients_enclose_the_determinant),
        cmocka_unit_test(halves_have_the_determinant_at_their_corners),
        cmocka_unit_test(error_bounds_hold),
        cmocka_unit_test(verdicts_agree_with_samples),
        cmocka_unit_test(doubles_and_integers_agree),
        cmocka_unit_test(reference_elements_are_valid),
        cmocka_unit_test(elements_of_no_size_are_invalid),
        cmocka_unit_test(flat_corners_are_invalid),
        cmocka_unit_test(collapsed_hexahedra_are_invalid),
        cmocka_unit_test(a_twisted_hexahedron_is_invalid),
        cmocka_unit_test(touching_zero_is_not_valid),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
