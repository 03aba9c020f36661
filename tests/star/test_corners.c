/* Stars of the corners of cells of every type, against the definition of their measures in long
 * double: forms, values, derivatives, visits with and without a guard; and all variants of the kernels
 * against the plain one, bit for bit. Further rows, and the energy of untangling. */
#include "star/laplacian.h"
#include "support/cell_star.h"

#include "support/effort.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static const planish_isa variants[] = {PLANISH_ISA_VECTOR, PLANISH_ISA_AVX2, PLANISH_ISA_AVX512};
static const planish_cell_type TYPES[] = {PLANISH_CELL_TRIANGLE,    PLANISH_CELL_QUADRILATERAL,
                                          PLANISH_CELL_TETRAHEDRON, PLANISH_CELL_HEXAHEDRON,
                                          PLANISH_CELL_WEDGE,       PLANISH_CELL_PYRAMID};
enum { N_TYPES = sizeof TYPES / sizeof *TYPES };

/** What is evaluated: without a guard, and with one. */
enum { PLAIN, MEAN, EDGE, WORST_RATIO, WORST_JACOBIAN, FUNCTIONS };
static const int objective_of[FUNCTIONS] = {0, PLANISH_OBJECTIVE_MEAN_RATIO,
                                            PLANISH_OBJECTIVE_EDGE_RATIO, PL_WORST_RATIO,
                                            PL_WORST_JACOBIAN};

static const pl_cell_shape *shape_of(int type) {
    return pl_cell_type_of((int)TYPES[type])->shape;
}

static void ask(cell_star *s, int function) {
    s->guard.objective = objective_of[function];
    s->problem.guard = function == PLAIN ? NULL : &s->guard;
}

static int evaluate(cell_star *s, planish_isa isa, int with_derivatives, pl_star_value *value) {
    memset(value, 0, sizeof *value); /* padding, too, which is compared */
    pl_star_evaluate_fn *of = pl_star_evaluate_of(pl_star_kernel_select(isa), &s->problem, s->dim);
    return of(&s->problem, 0, s->scratch, with_derivatives, value);
}

static pl_star_tally visit(cell_star *s, planish_isa isa) {
    pl_star_tally tally;
    memset(&tally, 0, sizeof tally);
    s->changed[0] = 1;
    pl_star_visit_of(pl_star_kernel_select(isa), &s->problem, s->dim)(&s->problem, 0, 1, s->scratch,
                                                                      &tally);
    return tally;
}

static void position(const cell_star *s, long double *x) {
    for (int d = 0; d < s->dim; d++)
        x[d] = s->coordinates[d];
}

/* ---- the functions by definition ------------------------------------------------------------- */

static long double part_of(const cell_star *s, int facet, int function, const long double *x) {
    const cell_corner c = cell_star_corner(s, facet, x);
    long double sum = 0;
    switch (function) {
    case EDGE:
        return c.edges;
    case WORST_RATIO:
        return powl(c.mu2 / s->guard.worst_limit, 32);
    case WORST_JACOBIAN:
        for (int k = 0; k < c.n_jacobians; k++)
            sum += powl(c.jacobians[k] / s->guard.worst_limit, 32);
        return sum;
    default:
        return c.mu2;
    }
}

static long double function_at(const cell_star *s, int function, const long double *x) {
    long double sum = 0;
    for (int f = 0; f < s->n_facets; f++)
        sum += part_of(s, f, function, x) / cell_star_corners(s, f);
    return sum;
}

/** Central differences, extrapolated once, along e_i (+ e_j). */
static long double difference(const cell_star *s, int function, int i, int j, int second) {
    const long double step = function == MEAN || function == PLAIN ? 1e-4L : 2e-5L;
    long double result[2];
    for (int level = 0; level < 2; level++) {
        const long double h = level ? step / 2 : step;
        long double f[3];
        for (int k = 0; k < 3; k++) {
            long double x[3];
            for (int d = 0; d < s->dim; d++)
                x[d] = s->coordinates[d] + (k - 1) * h * ((d == i) + (d == j));
            f[k] = function_at(s, function, x);
        }
        result[level] = second ? (f[0] - 2 * f[1] + f[2]) / (h * h) : (f[2] - f[0]) / (2 * h);
    }
    return (4 * result[1] - result[0]) / 3;
}

static void check_derivatives(const cell_star *s, int function, const pl_star_value *value) {
    const int dim = s->dim, is_mean = function == PLAIN || function == MEAN;
    long double size = 0, second[3][3];
    for (int i = 0; i < dim; i++)
        size += fabsl(second[i][i] = difference(s, function, i, -1, 1));
    for (int i = 0, k = 0; i < dim; i++)
        for (int j = i; j < dim; j++, k++) {
            /* along e_i + e_j the second difference is H_ii + 2 H_ij + H_jj */
            const long double wanted =
                i == j ? second[i][i]
                       : (difference(s, function, i, j, 1) - second[i][i] - second[j][j]) / 2;
            assert_true(fabsl(value->hessian[k] - wanted) < (is_mean ? 1e-6L : 1e-4L) * size);
        }
    for (int i = 0; i < dim; i++)
        assert_true(fabsl(value->gradient[i] - difference(s, function, i, -1, 0)) <
                    (is_mean ? 1e-8L : 1e-6L) * size);
}

static void check_star(cell_star *s, int function) {
    pl_star_value value, alone;
    long double x[3], largest = 0;
    position(s, x);
    ask(s, function);
    const long double sum = function_at(s, function, x);
    for (int f = 0; f < s->n_facets; f++)
        largest = fmaxl(largest, part_of(s, f, function, x));
    assert_true(evaluate(s, PLANISH_ISA_PLAIN, 1, &value));
    assert_true(value.certain);
    assert_true(fabsl(value.sum - sum) < 1e-10L * sum);
    assert_true(fabsl(value.max - largest) < 1e-10L * largest);
    check_derivatives(s, function, &value);
    if (function != PLAIN)
        return;
    assert_true(evaluate(s, PLANISH_ISA_PLAIN, PL_GRADIENT_ALONE, &alone));
    assert_memory_equal(alone.gradient, value.gradient, sizeof alone.gradient);
    assert_true(alone.sum == value.sum && alone.max == value.max);
}

static void derivatives_are_those_of_the_definition(void **state) {
    uint64_t random = effort_seed(1);
    (void)state;
    for (int type = 0; type < N_TYPES; type++)
        for (int function = 0; function < FUNCTIONS; function++)
            for (int64_t i = 0; i < effort(40, 400); i++) {
                cell_star s;
                cell_star_create(&s, shape_of(type)->dim, shape_of(type), 1 + (int)(i % 3), 0.3,
                                 &random);
                s.guard.worst_limit = 2;
                check_star(&s, function);
                cell_star_destroy(&s);
            }
}

/* ---- forms ----------------------------------------------------------------------------------- */

/** The corner of an ideal element is 1, wherever the star's node is in it. */
static void an_ideal_element_is_1(void **state) {
    (void)state;
    for (int type = 0; type < N_TYPES; type++) {
        uint64_t random = effort_seed(2);
        for (int i = 0; i < 60; i++) {
            cell_star s;
            const pl_cell_shape *shape = shape_of(type);
            double ideal[8][3];
            int own = 0;
            cell_star_create(&s, shape->dim, shape, 1, 0, &random);
            cell_star_ideal(shape, ideal);
            for (int k = 0; k < shape->n_corners; k++)
                for (int d = 0; d < s.dim; d++)
                    s.coordinates[s.node[0][k] * s.dim + d] = 3 * ideal[k][d];
            for (int k = 0; k < shape->n_corners; k++)
                own = s.node[0][k] == 0 ? k : own;
            pl_star_value value;
            assert_true(evaluate(&s, PLANISH_ISA_PLAIN, 1, &value));
            const double corners = s.n_facets / (double)cell_star_corners(&s, 0);
            assert_true(fabs(value.max - 1) < 1e-14 && fabs(value.sum - corners) < 1e-14);
            for (int d = 0; d < s.dim; d++) /* each corner is at its minimum, so the element is */
                assert_true(fabs(value.gradient[d]) < 1e-13);
            assert_int_equal(s.n_facets, shape->n_simplices == 1               ? 1
                                         : shape->n_corners == 5 && own == 4   ? 4
                                         : shape->n_corners == 5 || s.dim == 2 ? 3
                                                                               : 4);
            cell_star_destroy(&s);
        }
    }
}

/** E of a form from its weights and from its row, and D times volume. */
static void forms_agree_with_their_rows(void **state) {
    uint64_t random = effort_seed(3);
    (void)state;
    for (int64_t i = 0; i < effort(200, 2000); i++) {
        cell_star s;
        const int dim = 2 + (int)(i % 2);
        cell_star_create(&s, dim, NULL, 4, 0.3, &random);
        long double x[3];
        position(&s, x);
        for (int f = 0; f < s.n_facets; f++) {
            const pl_corner_form *form = &s.form[s.code[f]];
            const cell_corner c = cell_star_corner(&s, f, x);
            long double at[4][3] = {{0}}, E = 0;
            for (int j = 0; j <= dim; j++)
                for (int d = 0; d < dim; d++)
                    at[j][d] = j == dim ? x[d] : s.coordinates[s.facet[f][j] * dim + d];
            for (int j = 0, pair = dim; j < dim; j++) {
                for (int d = 0; d < dim; d++)
                    E += form->weight[j] * (at[dim][d] - at[j][d]) * (at[dim][d] - at[j][d]);
                for (int k = j + 1; k < dim; k++, pair++)
                    for (int d = 0; d < dim; d++)
                        E += form->weight[pair] * (at[k][d] - at[j][d]) * (at[k][d] - at[j][d]);
            }
            assert_true(fabsl(E - c.squares) < 1e-13L * E);
            assert_true(fabsl(form->determinant - c.ideal_determinant) < 1e-15L);
            const long double power = dim == 3 ? 4.0L / 3 : 2;
            assert_true(fabsl(form->factor * E * E * powl(c.D, -power) - c.mu2) < 1e-13L * c.mu2);
            assert_true(fabs(form->share * cell_star_corners(&s, f) - 1) < 1e-15);
        }
        cell_star_destroy(&s);
    }
}

/* ---- variants -------------------------------------------------------------------------------- */

static void variants_give_the_same_bits(void **state) {
    uint64_t random = effort_seed(4);
    (void)state;
    for (size_t v = 0; v < sizeof variants / sizeof *variants; v++) {
        if (!pl_star_kernel_select(variants[v]))
            continue;
        for (int64_t i = 0; i < effort(300, 3000); i++) {
            cell_star plain, other;
            pl_star_value a, b;
            uint64_t again = random;
            const int dim = 2 + (int)(i % 2), n = 1 + (int)(i % CELL_STAR_MAX_CELLS);
            cell_star_create(&plain, dim, NULL, n, 0.3, &random);
            cell_star_create(&other, dim, NULL, n, 0.3, &again);
            for (int function = 0; function < FUNCTIONS; function++) {
                ask(&plain, function);
                ask(&other, function);
                plain.problem.search = other.problem.search =
                    i % 3 ? PLANISH_SEARCH_NEWTON : PLANISH_SEARCH_FLETCHER_REEVES;
                for (int derive = 0; derive < 3; derive++) {
                    evaluate(&plain, PLANISH_ISA_PLAIN, derive, &a);
                    evaluate(&other, variants[v], derive, &b);
                    if (derive == PL_GRADIENT_ALONE)
                        memset(a.hessian, 0, sizeof a.hessian),
                            memset(b.hessian, 0, sizeof b.hessian);
                    assert_memory_equal(&a, &b, sizeof a);
                }
                const pl_star_tally p = visit(&plain, PLANISH_ISA_PLAIN);
                const pl_star_tally q = visit(&other, variants[v]);
                assert_memory_equal(&p, &q, sizeof p);
                assert_memory_equal(plain.coordinates, other.coordinates, sizeof plain.coordinates);
            }
            cell_star_destroy(&plain);
            cell_star_destroy(&other);
        }
    }
}

/* ---- visits ---------------------------------------------------------------------------------- */

static int is_definite(const double *h, int dim) {
    if (dim == 2)
        return h[0] > 0 && h[0] * h[2] > h[1] * h[1];
    const double det = h[0] * (h[3] * h[5] - h[4] * h[4]) - h[1] * (h[1] * h[5] - h[4] * h[2]) +
                       h[2] * (h[1] * h[4] - h[3] * h[2]);
    return h[0] > 0 && h[0] * h[3] > h[1] * h[1] && det > 0;
}

/** The function is convex, so visits come to its only minimum, and none raises it. */
static void visits_come_to_the_minimum(void **state) {
    uint64_t random = effort_seed(5);
    (void)state;
    for (int64_t i = 0; i < effort(300, 3000); i++) {
        cell_star s;
        const int dim = 2 + (int)(i % 2);
        pl_star_value value;
        cell_star_create(&s, dim, NULL, 3 + (int)(i % 5), 0.3, &random);
        ask(&s, i % 4 < 2 ? PLAIN : MEAN);
        evaluate(&s, PLANISH_ISA_AUTO, 1, &value);
        for (int k = 0; k < 40; k++) {
            const double before = value.sum;
            const pl_star_tally tally = visit(&s, PLANISH_ISA_AUTO);
            assert_true(evaluate(&s, PLANISH_ISA_AUTO, 1, &value));
            assert_true(value.sum <= before && is_definite(value.hessian, dim));
            assert_true(tally.largest == value.max);
            assert_true(fabs(pl_sum_value(&tally.decrease) - (before - value.sum)) < 1e-9 * before);
        }
        const double trace =
            value.hessian[0] + (dim == 3 ? value.hessian[3] + value.hessian[5] : value.hessian[2]);
        for (int d = 0; d < dim; d++)
            assert_true(fabs(value.gradient[d]) < 1e-5 * trace);
        cell_star_destroy(&s);
    }
}

/** Limits on mu^2 and the scaled Jacobian hold, whatever the objective; tally.largest tells. */
static void visits_keep_limits(void **state) {
    uint64_t random = effort_seed(6);
    int moved = 0, stopped = 0;
    (void)state;
    for (int64_t i = 0; i < effort(600, 6000); i++) {
        cell_star s;
        long double x[3], rr2 = 0, jacobian = 0;
        const int function = i % 3 == 0 ? PLAIN : i % 3 == 1 ? MEAN : EDGE;
        cell_star_create(&s, 2 + (int)(i % 2), NULL, 2 + (int)(i % 6), 0.3, &random);
        ask(&s, function);
        position(&s, x);
        for (int f = 0; f < s.n_facets; f++) {
            const cell_corner c = cell_star_corner(&s, f, x);
            rr2 = fmaxl(rr2, c.mu2);
            jacobian = fmaxl(jacobian, c.jacobian);
        }
        s.problem.limits =
            (pl_star_limits){(double)(rr2 * (1 + 1e-9L)), (double)(jacobian * (1 + 1e-9L)), 1};
        const double before = s.coordinates[0];
        for (int k = 0; k < 6; k++) {
            const pl_star_tally tally = visit(&s, PLANISH_ISA_AUTO);
            long double largest = 0;
            position(&s, x);
            for (int f = 0; f < s.n_facets; f++) {
                const cell_corner c = cell_star_corner(&s, f, x);
                largest = fmaxl(largest, c.mu2);
                assert_true(c.D > 0 && c.jacobian <= jacobian * (1 + 2e-9L));
            }
            assert_true(largest <= rr2 * (1 + 2e-9L));
            assert_true(fabsl(tally.largest - largest) < 1e-10L * largest);
        }
        moved += s.coordinates[0] != before;
        s.problem.limits = pl_star_no_limits();
        for (int k = 0; k < 6; k++)
            visit(&s, PLANISH_ISA_AUTO);
        position(&s, x);
        long double after = 0;
        for (int f = 0; f < s.n_facets; f++)
            after = fmaxl(after, cell_star_corner(&s, f, x).jacobian);
        stopped += after > jacobian * 1.001L;
        cell_star_destroy(&s);
    }
    assert_true(moved > 50 && stopped > 10);
}

/** Minimum volumes are in units of volume: form.volume times D. */
static void minimum_volumes_are_volumes(void **state) {
    uint64_t random = effort_seed(7);
    int reached = 0;
    (void)state;
    for (int64_t i = 0; i < effort(300, 3000); i++) {
        cell_star s;
        long double x[3], least = INFINITY, lowest = INFINITY;
        cell_star_create(&s, 2 + (int)(i % 2), NULL, 2 + (int)(i % 3), 0.3, &random);
        ask(&s, MEAN);
        position(&s, x);
        for (int f = 0; f < s.n_facets; f++)
            least = fminl(least, cell_star_corner(&s, f, x).D * s.form[s.code[f]].volume);
        s.guard.min_volume = (double)least;
        for (int k = 0; k < 10; k++)
            visit(&s, PLANISH_ISA_AUTO);
        position(&s, x);
        for (int f = 0; f < s.n_facets; f++)
            lowest = fminl(lowest, cell_star_corner(&s, f, x).D * s.form[s.code[f]].volume);
        assert_true(lowest >= least * (1 - 1e-5L));
        reached += lowest < least * 1.01L;
        s.guard.min_volume = (double)(least * 1.05L); /* restored, if it can be */
        for (int k = 0; k < 10; k++)
            visit(&s, PLANISH_ISA_AUTO);
        cell_star_destroy(&s);
    }
    assert_true(reached > 10);
}

/* ---- further rows ---------------------------------------------------------------------------- */

/** A row that is a facet once more adds what the facet adds. */
static void rows_add_what_facets_add(void **state) {
    uint64_t random = effort_seed(8);
    (void)state;
    for (int64_t i = 0; i < effort(600, 6000); i++) {
        cell_star s;
        pl_star_value once, twice;
        const int dim = 2 + (int)(i % 2), function = i % 4 < 2 ? PLAIN : MEAN;
        cell_star_create(&s, dim, NULL, 1 + (int)(i % 2), 0.3, &random);
        for (int d = 0; d < (i % 5 ? 0 : 3 * CELL_STAR_MAX_NODES); d++)
            s.coordinates[d] = ldexp(s.coordinates[d], -20); /* another scale */
        ask(&s, function);
        for (int f = 0; f < s.n_facets; f++)
            s.row[f] = cell_star_row(&s, f);
        assert_true(evaluate(&s, PLANISH_ISA_PLAIN, 1, &once));
        cell_star_use_rows(&s, s.n_facets);
        assert_true(evaluate(&s, PLANISH_ISA_PLAIN, 1, &twice));
        const int last = dim == 3 ? 5 : 2;
        const double size = twice.hessian[0] + twice.hessian[last];
        assert_true(twice.certain && fabs(twice.sum - 2 * once.sum) < 1e-10 * once.sum);
        assert_true(fabs(twice.max - once.max) < 1e-10 * once.max);
        for (int k = 0; k <= last; k++)
            assert_true(fabs(twice.hessian[k] - 2 * once.hessian[k]) < 1e-9 * size);
        for (int d = 0; d < dim; d++)
            assert_true(fabs(twice.gradient[d] - 2 * once.gradient[d]) <
                        1e-9 * sqrt(size * once.sum));
        /* without weight it changes nothing */
        for (int f = 0; f < s.n_facets; f++)
            s.row[f].weight = 0;
        assert_true(evaluate(&s, PLANISH_ISA_PLAIN, 1, &twice));
        assert_true(twice.sum == once.sum && twice.max == once.max);
        assert_memory_equal(twice.gradient, once.gradient, sizeof once.gradient);
        s.row[0].D0 = -s.row[0].D0; /* but it has to be positive */
        assert_false(evaluate(&s, PLANISH_ISA_PLAIN, 1, &twice));
        cell_star_destroy(&s);
    }
}

/** Visits keep rows without weight positive, and stop where they would not. */
static void visits_keep_rows_positive(void **state) {
    uint64_t random = effort_seed(9);
    int stopped = 0;
    (void)state;
    for (int64_t i = 0; i < effort(600, 6000); i++) {
        cell_star s, free;
        uint64_t again = random;
        double moved[3], D = 1;
        const int dim = 2 + (int)(i % 2), n = 2 + (int)(i % 3);
        static const int functions[] = {PLAIN, MEAN, EDGE};
        cell_star_create(&s, dim, NULL, n, 0.3, &random);
        cell_star_create(&free, dim, NULL, n, 0.3, &again);
        ask(&s, functions[i % 3]);
        ask(&free, functions[i % 3]);
        visit(&free, PLANISH_ISA_AUTO);
        s.row[0] = (pl_star_row){.factor = 0.1, .D0 = 1};
        for (int d = 0; d < dim; d++) { /* D falls to 0 half of the way that a visit goes */
            moved[d] = free.coordinates[d] - s.coordinates[d];
            D += moved[d] * moved[d];
        }
        for (int d = 0; d < dim; d++)
            s.row[0].slope_d[d] = D > 1 ? -2 * moved[d] / (D - 1) : 0;
        cell_star_use_rows(&s, 1);
        const pl_star_tally tally = visit(&s, PLANISH_ISA_AUTO);
        double after = 1;
        for (int d = 0; d < dim; d++)
            after += s.row[0].slope_d[d] * s.coordinates[d];
        assert_true(after > 0 && pl_sum_value(&tally.decrease) >= 0);
        stopped += after < 0.5;
        cell_star_destroy(&s);
        cell_star_destroy(&free);
    }
    assert_true(stopped > 50);
}

/* ---- untangling ------------------------------------------------------------------------------ */

/** All that untangling asks of a star. */
typedef struct asked_star {
    double size[CELL_STAR_MAX_NODES];
    uint8_t in_patch[CELL_STAR_MAX_NODES];
    pl_star_untangling asked;
} asked_star;

static void ask_untangling(cell_star *s, asked_star *a, uint64_t *random) {
    memset(a, 0, sizeof *a);
    for (int i = 0; i < CELL_STAR_MAX_NODES; i++)
        a->size[i] = random_between(random, 0.5, 2);
    a->in_patch[0] = 1;
    a->asked = (pl_star_untangling){.in_patch = a->in_patch, .size = a->size, .epsilon = 0.3};
    ask(s, MEAN);
    s->problem.untangling = &a->asked;
}

/** The energy by definition: T = E / (dim h^2), u = D / (w h^dim), f as in kernel_foldover.h. */
static long double energy_at(const cell_star *s, const asked_star *a, const long double *x) {
    long double sum = 0;
    for (int f = 0; f < s->n_facets; f++) {
        const cell_corner c = cell_star_corner(s, f, x);
        long double h = a->size[0];
        for (int j = 0; j < s->dim; j++)
            h += a->size[s->facet[f][j]];
        h /= s->dim + 1;
        const long double u = c.D / (c.ideal_determinant * powl(h, s->dim));
        const long double T = c.squares / (s->dim * h * h), e = a->asked.epsilon;
        const long double chi = (u + sqrtl(u * u + e * e)) / 2;
        sum += (T * powl(chi, -2.0L / s->dim) + (1 + u * u) / (2 * chi)) / cell_star_corners(s, f);
    }
    return sum;
}

static pl_star_energy energy_of(cell_star *s, planish_isa isa, pl_star_slope *slope) {
    memset(slope, 0, sizeof *slope);
    return pl_star_kernel_select(isa)->guarded->energy[s->dim - 2](&s->problem, 0, 1, s->scratch,
                                                                   slope);
}

static void the_energy_is_that_of_the_definition(void **state) {
    uint64_t random = effort_seed(10);
    (void)state;
    for (int64_t i = 0; i < effort(300, 3000); i++) {
        cell_star s;
        asked_star a;
        pl_star_slope slope, twice;
        long double x[3], f[2];
        cell_star_create(&s, 2 + (int)(i % 2), NULL, 2, 0.3, &random);
        ask_untangling(&s, &a, &random);
        for (int d = 0; d < s.dim; d++) /* some corners are inverted */
            s.coordinates[d] = random_between(&random, -0.8, 0.8);
        pl_star_energy energy = energy_of(&s, PLANISH_ISA_PLAIN, &slope);
        position(&s, x);
        const long double wanted = energy_at(&s, &a, x);
        assert_true(fabsl(pl_sum_value(&energy.sum) - wanted) < 1e-10L * wanted);
        for (int d = 0; d < s.dim; d++) {
            const long double h = 1e-6L, at = x[d];
            for (int side = 0; side < 2; side++) {
                x[d] = at + (side ? h : -h);
                f[side] = energy_at(&s, &a, x);
            }
            x[d] = at;
            assert_true(fabsl(slope.gradient[d] - (f[1] - f[0]) / (2 * h)) <
                        1e-6L * (wanted + fabsl(f[1] - f[0]) / h));
        }
        /* rows that are the facets double it */
        for (int j = 0; j < s.n_facets; j++) {
            s.row[j] = cell_star_row(&s, j);
            s.row[j].size = a.size[0] / (s.dim + 1);
            for (int k = 0; k < s.dim; k++)
                s.row[j].size += a.size[s.facet[j][k]] / (s.dim + 1);
        }
        cell_star_use_rows(&s, s.n_facets);
        energy = energy_of(&s, PLANISH_ISA_PLAIN, &twice);
        assert_true(fabsl(pl_sum_value(&energy.sum) - 2 * wanted) < 1e-10L * wanted);
        const double size = twice.hessian[0] + twice.hessian[s.dim == 3 ? 5 : 2] + (double)wanted;
        for (int d = 0; d < s.dim; d++)
            assert_true(fabs(twice.gradient[d] - 2 * slope.gradient[d]) < 1e-9 * size);
        for (int k = 0; k < (s.dim == 3 ? 6 : 3); k++)
            assert_true(fabs(twice.hessian[k] - 2 * slope.hessian[k]) < 1e-8 * size);
        cell_star_destroy(&s);
    }
}

/** With rows, and untangling. */
static void variants_with_rows_give_the_same_bits(void **state) {
    uint64_t random = effort_seed(11);
    (void)state;
    for (size_t v = 0; v < sizeof variants / sizeof *variants; v++) {
        if (!pl_star_kernel_select(variants[v]))
            continue;
        for (int64_t i = 0; i < effort(200, 2000); i++) {
            cell_star star[2];
            asked_star asked[2];
            pl_star_value value[2];
            pl_star_slope slope[2];
            pl_star_energy energy[2];
            pl_star_tally tally[2];
            const uint64_t start = random;
            const planish_isa isa[2] = {PLANISH_ISA_PLAIN, variants[v]};
            for (int k = 0; k < 2; k++) {
                cell_star *s = &star[k];
                random = start;
                cell_star_create(s, 2 + (int)(i % 2), NULL, 1 + (int)(i % 2), 0.3, &random);
                for (int f = 0; f < s->n_facets; f++) {
                    s->row[f] = cell_star_row(s, f);
                    s->row[f].weight *= (double)random_below(&random, 3);
                    s->row[f].D0 *= random_between(&random, 0.5, 1.5);
                }
                cell_star_use_rows(s, s->n_facets);
                for (int function = 0; function < FUNCTIONS; function++) {
                    ask(s, function);
                    visit(s, isa[k]);
                }
                evaluate(s, isa[k], 1, &value[k]);
                ask_untangling(s, &asked[k], &random);
                memset(&energy[k], 0, sizeof energy[k]);
                memset(&tally[k], 0, sizeof tally[k]);
                energy[k] = energy_of(s, isa[k], &slope[k]);
                pl_star_kernel_select(isa[k])->guarded->untangle[s->dim - 2](&s->problem, 0, 1,
                                                                             s->scratch, &tally[k]);
            }
            assert_memory_equal(&value[0], &value[1], sizeof value[0]);
            assert_memory_equal(&slope[0], &slope[1], sizeof slope[0]);
            assert_true(pl_sum_value(&energy[0].sum) == pl_sum_value(&energy[1].sum));
            assert_memory_equal(star[0].coordinates, star[1].coordinates,
                                sizeof star[0].coordinates);
            for (int k = 0; k < 2; k++)
                cell_star_destroy(&star[k]);
        }
    }
}

/* ---- averages -------------------------------------------------------------------------------- */

static int are_joined(const pl_cell_shape *shape, int a, int b) {
    int found = 0;
    for (int i = 0; i < shape->n_edges; i++)
        found |= (shape->edge[i][0] == a && shape->edge[i][1] == b) ||
                 (shape->edge[i][0] == b && shape->edge[i][1] == a);
    return found;
}

/** Mean of the nodes that edges join to the star's: as the cells share only that, each once. */
static void mean_of_neighbours(const cell_star *s, double *mean) {
    int n = 0;
    for (int d = 0; d < s->dim; d++)
        mean[d] = 0;
    for (int c = 0; c < s->n_cells; c++)
        for (int i = 0; i < s->shape[c]->n_corners; i++)
            for (int j = 0; j < s->shape[c]->n_corners; j++) {
                if (s->node[c][i] != 0 || !are_joined(s->shape[c], i, j))
                    continue;
                n++;
                for (int d = 0; d < s->dim; d++)
                    mean[d] += s->coordinates[s->node[c][j] * s->dim + d];
            }
    for (int d = 0; d < s->dim; d++)
        mean[d] /= n;
}

/** Mean of the centroids of the corners at the star's node, by their volume. */
static void mean_of_centroids(const cell_star *s, double *mean) {
    long double x[3], sum[3] = {0}, volume = 0;
    position(s, x);
    for (int f = 0; f < s->n_facets; f++) {
        const pl_cell_shape *shape = s->shape[s->cell[f]];
        const int is_apex = shape->n_corners == 5 && s->node[s->cell[f]][4] == 0;
        if (s->node[s->cell[f]][s->corner[f]] != 0 && shape->n_simplices != 1 && !is_apex)
            continue;
        const long double D = cell_star_corner(s, f, x).D;
        volume += D;
        for (int d = 0; d < s->dim; d++) {
            long double centroid = x[d];
            for (int j = 0; j < s->dim; j++)
                centroid += s->coordinates[s->facet[f][j] * s->dim + d];
            sum[d] += D * centroid / (s->dim + 1);
        }
    }
    for (int d = 0; d < s->dim; d++)
        mean[d] = (double)(sum[d] / volume);
}

static void averages_are_of_edges_and_corners(void **state) {
    uint64_t random = effort_seed(12);
    (void)state;
    for (int64_t i = 0; i < effort(400, 4000); i++) {
        cell_star s;
        double wanted[3];
        pl_star_tally tally = {.visits = 0};
        const planish_method method =
            i % 4 < 2 ? PLANISH_METHOD_LAPLACIAN : PLANISH_METHOD_AREA_LAPLACIAN;
        cell_star_create(&s, 2 + (int)(i % 2), NULL, 1 + (int)(i % 3), 0.3, &random);
        ask(&s, i % 8 < 4 ? PLAIN : MEAN);
        if (method == PLANISH_METHOD_LAPLACIAN)
            mean_of_neighbours(&s, wanted);
        else
            mean_of_centroids(&s, wanted);
        pl_star_average(&s.problem, method, s.dim, 0, 1, s.scratch, &tally);
        assert_int_equal(tally.visits, 1);
        for (int d = 0; d < s.dim; d++)
            assert_true(fabs(s.coordinates[d] - wanted[d]) < 1e-13);
        cell_star_destroy(&s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(forms_agree_with_their_rows),
        cmocka_unit_test(an_ideal_element_is_1),
        cmocka_unit_test(derivatives_are_those_of_the_definition),
        cmocka_unit_test(variants_give_the_same_bits),
        cmocka_unit_test(visits_come_to_the_minimum),
        cmocka_unit_test(visits_keep_limits),
        cmocka_unit_test(minimum_volumes_are_volumes),
        cmocka_unit_test(rows_add_what_facets_add),
        cmocka_unit_test(visits_keep_rows_positive),
        cmocka_unit_test(the_energy_is_that_of_the_definition),
        cmocka_unit_test(variants_with_rows_give_the_same_bits),
        cmocka_unit_test(averages_are_of_edges_and_corners),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
