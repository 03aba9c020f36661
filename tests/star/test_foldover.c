/* The regularised energy of untangling against its formulas in long double, its visits, and the
 * sums over patches of several nodes. */
#include "support/both.h"
#include "support/hand_star.h"
#include "support/meshes.h"
#include "support/tangled_star.h"
#include "sweep/sweep.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const planish_isa variants[] = {PLANISH_ISA_VECTOR, PLANISH_ISA_AVX2, PLANISH_ISA_AVX512};
enum { N_VARIANTS = sizeof variants / sizeof *variants };

static const double epsilons[] = {1e-6, 1e-3, 0.1, 1, 10};
enum { N_EPSILONS = sizeof epsilons / sizeof *epsilons };

/* ---- the formulas -------------------------------------------------------------------------- */

/** u, D / D* and T of an element, and what it is worth. */
typedef struct element {
    long double u, measure, T, target; /* target: D* */
} element;

static long double power(long double x, int n) {
    return n == 0 ? 1 : x * power(x, n - 1);
}

/** measure, floor: volumes (areas). */
static element element_of(int dim, long double corner[4][3], long double measure, long double floor,
                          long double h) {
    const long double per_volume = dim == 3 ? 6 : 2, edges = dim == 3 ? 6 : 3;
    long double squares = 0;
    for (int i = 0; i < dim; i++)
        for (int j = i + 1; j <= dim; j++)
            for (int d = 0; d < dim; d++)
                squares += power(corner[i][d] - corner[j][d], 2);
    const long double target = (dim == 3 ? sqrtl(2) / 2 : sqrtl(3) / 2) * power(h, dim);
    return (element){.u = (measure - floor) * per_volume / target,
                     .measure = measure * per_volume / target,
                     .T = squares / (edges * h * h),
                     .target = target};
}

/** f of the element, moved along u by du. */
static long double function_of(const element *e, long double du, long double epsilon, int dim) {
    const long double u = e->u + du, q = 1 + power(e->measure + du, 2);
    const long double s = sqrtl(u * u + epsilon * epsilon);
    const long double chi = u > 0 ? (u + s) / 2 : epsilon * epsilon / (s - u) / 2; /* the same */
    return e->T * powl(chi, -2.0L / dim) + q / (2 * chi);
}

static element element_at(const tangled_star *t, int64_t facet, const long double *x) {
    const int dim = t->s.dim;
    long double corner[4][3], h = t->size[0] / (dim + 1);
    for (int j = 0; j <= dim; j++) {
        const int node = j < dim ? 1 + t->s.link[facet * dim + j] : 0;
        for (int d = 0; d < dim; d++)
            corner[j][d] = j < dim ? (long double)t->s.coordinates[node * dim + d] : x[d];
        h += j < dim ? (long double)t->size[node] / (dim + 1) : 0;
    }
    return element_of(dim, corner, hand_star_measure(&t->s, facet, x),
                      hand_star_floor(&t->s, facet), h);
}

static int counts(const tangled_star *t, int64_t facet) {
    return !t->asked.link_skip || !t->asked.link_skip[facet];
}

/** 1 / nodes of the facet's element that are in the patch. */
static long double share(const tangled_star *t, int64_t facet) {
    int movers = 1;
    for (int j = 0; j < t->s.dim; j++)
        movers += t->in_patch[1 + t->s.link[facet * t->s.dim + j]];
    return 1.0L / movers;
}

/** The star's share of the patch's energy with its node at x. */
static long double sum_at(const tangled_star *t, const long double *x) {
    long double sum = 0;
    for (int64_t f = 0; f < tangled_facets(t); f++) {
        const element e = element_at(t, f, x);
        sum += counts(t, f) * share(t, f) * function_of(&e, 0, t->asked.epsilon, t->s.dim);
    }
    return sum;
}

/** Gradient of u of an element: u is affine. */
static void gradient_of_u(const tangled_star *t, int64_t facet, long double *gradient) {
    long double x[3] = {0, 0, 0};
    const element zero = element_at(t, facet, x);
    for (int d = 0; d < t->s.dim; d++) {
        x[d] = 1;
        gradient[d] = element_at(t, facet, x).u - zero.u;
        x[d] = 0;
    }
}

/** sqrt(u^2 + epsilon^2). */
static long double slope_length(long double u, const tangled_star *t) {
    return hypotl(u, t->asked.epsilon);
}

static long double length(const long double *v, int dim) {
    long double sum = 0;
    for (int d = 0; d < dim; d++)
        sum += v[d] * v[d];
    return sqrtl(sum);
}

/* ---- the energy ---------------------------------------------------------------------------- */

static void check_energy(tangled_star *t) {
    long double x[3], least = INFINITY;
    int64_t tangled = 0;
    tangled_position(t, x);
    for (int64_t f = 0; f < tangled_facets(t); f++) {
        const element e = element_at(t, f, x);
        if (!counts(t, f))
            continue;
        least = fminl(least, e.u);
        if (e.u <= 0 || e.measure <= 0)
            tangled += lrintl(PL_SHARES * share(t, f));
    }
    const pl_star_energy now = tangled_energy(t, PLANISH_ISA_PLAIN, NULL);
    const long double sum = sum_at(t, x);
    assert_true(fabsl(pl_sum_value(&now.sum) - sum) < 1e-12L * sum);
    assert_true(fabsl(now.least - least) < 1e-13L * (1 + fabsl(least)));
    assert_int_equal(now.tangled, tangled);
}

static void the_energy_is_that_of_the_formulas(void **state) {
    int dim = *(int *)*state;
    for (unsigned seed = 0; seed < 200; seed++)
        for (int i = 0; i < N_EPSILONS; i++) {
            tangled_star t;
            tangled_create(&t, dim, seed);
            t.asked.epsilon = epsilons[i];
            check_energy(&t);
            tangled_ask_for_more(&t, seed);
            check_energy(&t);
            tangled_destroy(&t);
        }
}

/** The length over which an element changes: u by sqrt(u^2 + epsilon^2), but no more than 1. */
static long double reach(const tangled_star *t, int64_t facet) {
    long double x[3], g[3];
    tangled_position(t, x);
    gradient_of_u(t, facet, g);
    const long double rate = length(g, t->s.dim) / slope_length(element_at(t, facet, x).u, t);
    return 1 / (1 + rate);
}

/** Central differences of an element's f, extrapolated once, along direction e_i (+ e_j). */
static long double difference(const tangled_star *t, int64_t facet, int i, int j, int second) {
    /* Powers of two: coordinates and measures remain exact. */
    long double result[2], h = exp2l(floorl(log2l(2e-3L * reach(t, facet))));
    for (int level = 0; level < 2; level++, h /= 2) {
        long double f[3], x[3];
        for (int k = 0; k < 3; k++) {
            tangled_position(t, x);
            for (int d = 0; d < t->s.dim; d++)
                x[d] += (k - 1) * h * ((d == i) + (d == j));
            const element e = element_at(t, facet, x);
            f[k] = function_of(&e, 0, t->asked.epsilon, t->s.dim);
        }
        result[level] = second ? (f[0] - 2 * f[1] + f[2]) / (h * h) : (f[2] - f[0]) / (2 * h);
    }
    return (4 * result[1] - result[0]) / 3;
}

/** Curvature of f along u, by differences. */
static long double bend_of(const element *e, const tangled_star *t) {
    const long double epsilon = t->asked.epsilon;
    long double result[2], h = 1e-3L * slope_length(e->u, t);
    for (int level = 0; level < 2; level++, h /= 2)
        result[level] =
            (function_of(e, h, epsilon, t->s.dim) - 2 * function_of(e, 0, epsilon, t->s.dim) +
             function_of(e, -h, epsilon, t->s.dim)) /
            (h * h);
    return (4 * result[1] - result[0]) / 3;
}

/** Gradient and Hessian of a star as they should be, and what they are as large as. */
typedef struct slopes {
    long double gradient[3], hessian[3][3], gradient_size, hessian_size;
    int n_clipped; /* elements whose curvature along u is negative: it is left out */
} slopes;

static void add_element(const tangled_star *t, int64_t facet, slopes *s) {
    const int dim = t->s.dim;
    long double x[3], g[3], second[3][3];
    tangled_position(t, x);
    const element e = element_at(t, facet, x);
    const long double value = function_of(&e, 0, t->asked.epsilon, dim), far = reach(t, facet);
    const long double left_out = fminl(bend_of(&e, t), 0);
    gradient_of_u(t, facet, g);
    for (int i = 0; i < dim; i++)
        second[i][i] = difference(t, facet, i, -1, 1);
    for (int i = 0; i < dim; i++)
        for (int j = i; j < dim; j++) {
            if (j > i) /* along e_i + e_j it is H_ii + 2 H_ij + H_jj */
                second[i][j] = (difference(t, facet, i, j, 1) - second[i][i] - second[j][j]) / 2;
            s->hessian[i][j] += second[i][j] - left_out * g[i] * g[j];
        }
    for (int i = 0; i < dim; i++)
        s->gradient[i] += difference(t, facet, i, -1, 0);
    s->n_clipped += left_out < 0;
    s->gradient_size += value / far;
    s->hessian_size += value / far / far;
}

/** Returns how many elements' curvature was left out. */
static int check_slope(tangled_star *t) {
    slopes wanted = {{0}, {{0}}, 0, 0, 0};
    pl_star_slope slope;
    const pl_star_energy with = tangled_energy(t, PLANISH_ISA_PLAIN, &slope);
    const pl_star_energy without = tangled_energy(t, PLANISH_ISA_PLAIN, NULL);
    assert_memory_equal(&with, &without, sizeof with);
    for (int64_t f = 0; f < tangled_facets(t); f++)
        if (counts(t, f))
            add_element(t, f, &wanted);
    for (int i = 0, k = 0; i < t->s.dim; i++)
        for (int j = i; j < t->s.dim; j++, k++)
            assert_true(fabsl(slope.hessian[k] - wanted.hessian[i][j]) <
                        1e-6L * wanted.hessian_size);
    for (int i = 0; i < t->s.dim; i++)
        assert_true(fabsl(slope.gradient[i] - wanted.gradient[i]) < 1e-9L * wanted.gradient_size);
    return wanted.n_clipped;
}

static void slopes_match_differences(void **state) {
    int dim = *(int *)*state, n_clipped = 0, n_whole = 0;
    for (unsigned seed = 0; seed < 50; seed++)
        for (int i = 0; i < N_EPSILONS; i++) {
            tangled_star t;
            tangled_create(&t, dim, seed);
            t.asked.epsilon = epsilons[i];
            int n = check_slope(&t);
            tangled_ask_for_more(&t, seed);
            n += check_slope(&t);
            n_clipped += n > 0;
            n_whole += n == 0;
            tangled_destroy(&t);
        }
    assert_true(n_whole > 0);
    if (dim == 3)
        assert_true(n_clipped > 0);
}

/* ---- one element --------------------------------------------------------------------------- */

/** A star of the one facet whose element with the node is regular, with edges of edge. */
static void create_regular(tangled_star *t, int dim, double edge) {
    static const double corner[2][4][3] = {
        {{0.5, 0.86602540378443865}, {0, 0}, {1, 0}},
        {{1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}},
    };
    const double factor = dim == 3 ? edge / sqrt(8) : edge;
    tangled_create(t, dim, 0);
    t->s.ring_offset[1] = dim;
    t->s.link_offset[1] = 1;
    for (int j = 0; j <= dim; j++) {
        for (int d = 0; d < dim; d++)
            t->s.coordinates[j * dim + d] = factor * corner[dim - 2][j][d];
        t->size[j] = edge;
    }
    for (int j = 0; j < dim; j++)
        t->s.link[j] = (uint16_t)j;
    const long double x[3] = {t->s.coordinates[0], t->s.coordinates[1], t->s.coordinates[2]};
    if (hand_star_measure(&t->s, 0, x) < 0) {
        t->s.link[0] = 1;
        t->s.link[1] = 0;
    }
    hand_star_pack_link(&t->s);
}

/** The regular element of the wanted size has u = 1, f = 2, and there is no better place. */
static void the_wanted_element_is_the_best(void **state) {
    int dim = *(int *)*state;
    static const double edges[] = {1e-3, 1, 7, 1e4};
    for (size_t i = 0; i < sizeof edges / sizeof *edges; i++) {
        tangled_star t;
        pl_star_slope slope;
        unsigned random = (unsigned)i;
        create_regular(&t, dim, edges[i]);
        t.asked.epsilon = 1e-9;
        const pl_star_energy best = tangled_energy(&t, PLANISH_ISA_PLAIN, &slope);
        assert_true(fabs(best.least - 1) < 1e-14);
        assert_true(fabs(pl_sum_value(&best.sum) - 2) < 1e-14);
        assert_int_equal(best.tangled, 0);
        double from[3];
        memcpy(from, t.s.coordinates, sizeof from);
        for (int d = 0; d < dim; d++)
            assert_true(fabs(slope.gradient[d]) * edges[i] < 1e-13);
        for (int k = 0; k < 1000; k++) {
            const double far = edges[i] * ldexp(1, -(k % 20));
            for (int d = 0; d < dim; d++)
                t.s.coordinates[d] = from[d] + far * (2 * test_random(&random) - 1);
            assert_true(tangled_energy_sum(&t, PLANISH_ISA_PLAIN) > pl_sum_value(&best.sum));
        }
        tangled_destroy(&t);
    }
}

/* ---- bits ---------------------------------------------------------------------------------- */

static void powers_of_two_change_no_bit(void **state) {
    int dim = *(int *)*state;
    static const int exponents[] = {-300, -31, 1, 40, 300};
    for (size_t k = 0; k < sizeof exponents / sizeof *exponents; k++)
        for (unsigned seed = 0; seed < 60; seed++) {
            const int e = exponents[k];
            tangled_star a, b;
            pl_star_slope p, q;
            tangled_create(&a, dim, seed);
            tangled_create(&b, dim, seed);
            for (int i = 0; i < HAND_STAR_MAX_NODES * dim; i++)
                b.s.coordinates[i] = ldexp(a.s.coordinates[i], e);
            for (int i = 0; i < HAND_STAR_MAX_NODES; i++)
                b.size[i] = ldexp(a.size[i], e);
            a.asked.epsilon = b.asked.epsilon = epsilons[seed % N_EPSILONS];
            const pl_star_energy of_a = tangled_energy(&a, PLANISH_ISA_AUTO, &p);
            const pl_star_energy of_b = tangled_energy(&b, PLANISH_ISA_AUTO, &q);
            assert_memory_equal(&of_a, &of_b, sizeof of_a);
            for (int d = 0; d < dim; d++)
                assert_true(ldexp(q.gradient[d], e) == p.gradient[d]);
            for (int d = 0; d < dim * (dim + 1) / 2; d++)
                assert_true(ldexp(q.hessian[d], 2 * e) == p.hessian[d]);
            for (int i = 0; i < 5; i++) {
                assert_true(tangled_decrease(&a) == tangled_decrease(&b));
                for (int d = 0; d < dim; d++)
                    assert_true(ldexp(a.s.coordinates[d], e) == b.s.coordinates[d]);
            }
            tangled_destroy(&a);
            tangled_destroy(&b);
        }
}

/** The bounds of every kind that seed asks for. */
static void bound(tangled_star *t, unsigned seed) {
    const int dim = t->s.dim;
    const double room = seed % 2 ? 0.05 : 0.4;
    memcpy(t->start, t->s.coordinates, sizeof t->start);
    for (int d = 0; d < dim; d++) {
        t->lower[d] = t->s.coordinates[d] - room;
        t->upper[d] = t->s.coordinates[d] + (d ? room : 0);
    }
    t->radius[0] = room;
    if (seed & 2) {
        t->guard.lower = t->lower;
        t->guard.upper = t->upper;
    }
    if (seed & 4) {
        t->guard.start = t->start;
        t->guard.radius = t->radius;
    }
}

static void compare_variant(planish_isa isa, int dim, unsigned seed) {
    tangled_star plain, other;
    pl_star_slope p = {{0}, {0}}, q = {{0}, {0}};
    tangled_star *const both[] = {&plain, &other};
    for (int i = 0; i < 2; i++) {
        tangled_create(both[i], dim, seed);
        both[i]->asked.epsilon = epsilons[seed / PLACES % N_EPSILONS];
        if (seed & 1)
            tangled_ask_for_more(both[i], seed);
        bound(both[i], seed / 3);
        both[i]->s.problem.storage.precision =
            seed % 7 == 0 ? PLANISH_PRECISION_FLOAT : PLANISH_PRECISION_DOUBLE;
    }
    for (int i = 0; i < 5; i++) {
        const pl_star_energy a = tangled_energy(&plain, PLANISH_ISA_PLAIN, &p),
                             b = tangled_energy(&other, isa, &q);
        assert_memory_equal(&a, &b, sizeof a);
        assert_memory_equal(&p, &q, sizeof p);
        const pl_star_tally v = tangled_visit(&plain, PLANISH_ISA_PLAIN),
                            w = tangled_visit(&other, isa);
        assert_memory_equal(&v, &w, sizeof v);
        assert_memory_equal(plain.s.coordinates, other.s.coordinates, sizeof plain.s.coordinates);
        assert_memory_equal(plain.s.changed, other.s.changed, sizeof plain.s.changed);
    }
    tangled_destroy(&plain);
    tangled_destroy(&other);
}

static void variants_give_the_same_bits(void **state) {
    int dim = *(int *)*state;
    for (int v = 0; v < N_VARIANTS; v++)
        for (unsigned seed = 0; seed < 300 && pl_star_kernel_select(variants[v]); seed++)
            compare_variant(variants[v], dim, seed);
}

/* ---- visits -------------------------------------------------------------------------------- */

/** The energy never rises and falls by what the visit says; nothing but the node moves. */
static void check_visit(tangled_star *t) {
    const tangled_star before = *t;
    const double was = tangled_energy_sum(t, PLANISH_ISA_AUTO);
    const pl_star_tally tally = tangled_visit(t, PLANISH_ISA_AUTO);
    const double now = tangled_energy_sum(t, PLANISH_ISA_AUTO),
                 fall = pl_sum_value(&tally.decrease);
    const size_t node = (size_t)t->s.dim;
    assert_int_equal(tally.visits, 1);
    assert_true(now <= was * (1 + 1e-15) && fall >= 0); /* shares are rounded */
    assert_true(fabs(was - now - fall) <= 1e-12 * was);
    assert_memory_equal(t->s.coordinates + node, before.s.coordinates + node,
                        sizeof t->s.coordinates - node * sizeof(double));
    if (fall == 0)
        assert_memory_equal(t->s.coordinates, before.s.coordinates, sizeof t->s.coordinates);
}

static void visits_lower_the_energy(void **state) {
    int dim = *(int *)*state, n_mended = 0, n_tangled = 0;
    for (unsigned seed = 0; seed < 200; seed++) {
        tangled_star t;
        tangled_create(&t, dim, seed);
        t.asked.epsilon = epsilons[seed % N_EPSILONS];
        n_tangled += tangled_energy(&t, PLANISH_ISA_AUTO, NULL).tangled > 0;
        for (int i = 0; i < 30; i++)
            check_visit(&t);
        n_mended += tangled_energy(&t, PLANISH_ISA_AUTO, NULL).tangled == 0;
        tangled_destroy(&t);
    }
    /* Epsilons of all sizes, and no schedule: that most are repaired will do here. */
    assert_true(n_tangled >= 120);
    assert_true(n_mended > 120);
}

static void nodes_outside_of_the_patch_stay(void **state) {
    int dim = *(int *)*state;
    for (unsigned seed = 0; seed < 20; seed++) {
        tangled_star t;
        tangled_create(&t, dim, seed);
        pl_star_slope slope = {{7, 7, 7}, {7, 7, 7, 7, 7, 7}};
        const pl_star_slope same = slope;
        const tangled_star before = t;
        t.in_patch[0] = 0;
        t.in_patch[1] = 1;
        const pl_star_energy nothing = tangled_energy(&t, PLANISH_ISA_AUTO, &slope);
        assert_true(pl_sum_value(&nothing.sum) == 0 && nothing.tangled == 0 &&
                    nothing.least == INFINITY);
        assert_memory_equal(&slope, &same, sizeof slope);
        assert_int_equal(tangled_visit(&t, PLANISH_ISA_AUTO).visits, 0);
        assert_memory_equal(t.s.coordinates, before.s.coordinates, sizeof t.s.coordinates);
        tangled_destroy(&t);
    }
}

/** Whether the node is within what bound() asked for. */
static int is_bounded(const tangled_star *t) {
    double far = 0;
    int inside = 1;
    for (int d = 0; d < t->s.dim; d++) {
        const double x = t->s.coordinates[d];
        inside &= !t->guard.lower || (x >= t->lower[d] && x <= t->upper[d]);
        far = hypot(far, x - t->start[d]);
    }
    return inside && (!t->guard.radius || far <= t->radius[0] * (1 + 1e-15));
}

static void bounds_are_kept(void **state) {
    int dim = *(int *)*state, moved = 0, met = 0;
    for (unsigned seed = 0; seed < 200; seed++) {
        tangled_star t;
        tangled_create(&t, dim, seed);
        t.asked.epsilon = epsilons[seed % N_EPSILONS];
        bound(&t, 2 + seed % 6);
        t.s.problem.storage.precision =
            seed % 3 == 0 ? PLANISH_PRECISION_FLOAT
                          : PLANISH_PRECISION_DOUBLE; /* the bounds are no floats */
        const tangled_star before = t;
        for (int i = 0; i < 10; i++) {
            check_visit(&t);
            assert_true(is_bounded(&t));
        }
        moved += memcmp(t.s.coordinates, before.s.coordinates, sizeof(double)) != 0;
        for (int d = 0; d < dim; d++)
            met += t.s.coordinates[d] == t.lower[d] || t.s.coordinates[d] == t.upper[d];
        tangled_destroy(&t);
    }
    assert_true(moved > 50 && met > 50);
}

static int are_floats(const double *x, int n) {
    int all = 1;
    for (int i = 0; i < n; i++) {
        volatile float rounded = (float)x[i];
        all &= x[i] == rounded;
    }
    return all;
}

static void positions_are_floats_where_asked(void **state) {
    int dim = *(int *)*state, moved = 0;
    for (unsigned seed = 0; seed < 100; seed++) {
        tangled_star t;
        tangled_create(&t, dim, seed);
        t.asked.epsilon = epsilons[seed % N_EPSILONS];
        t.s.problem.storage.precision = PLANISH_PRECISION_FLOAT;
        assert_true(are_floats(t.s.coordinates, dim));
        for (int i = 0; i < 10; i++) {
            check_visit(&t);
            moved += t.s.coordinates[0] != test_few_bits(t.s.coordinates[0]);
            assert_true(are_floats(t.s.coordinates, dim));
        }
        tangled_destroy(&t);
    }
    assert_true(moved > 500);
}

/** A place is brought within the bounds; where floats cannot be, the node has to stay. */
static void places_are_admitted(void **state) {
    int dim = *(int *)*state;
    tangled_star t;
    tangled_create(&t, dim, 0);
    double x[3] = {9, 9, 9};
    assert_true(pl_star_admit(&t.s.problem, 0, dim, x));
    for (int d = 0; d < dim; d++)
        assert_true(x[d] == 9);
    bound(&t, 2);
    assert_true(pl_star_admit(&t.s.problem, 0, dim, x));
    for (int d = 0; d < dim; d++)
        assert_true(x[d] == t.upper[d]);
    t.s.problem.storage.precision = PLANISH_PRECISION_FLOAT;
    for (int d = 0; d < dim; d++) {
        t.lower[d] = 1 + 0x1p-40;
        t.upper[d] = 1 + 0x1p-39;
    }
    assert_false(pl_star_admit(&t.s.problem, 0, dim, x));
    tangled_destroy(&t);
}

/* ---- patches of several nodes -------------------------------------------------------------- */

/** A tangled box with its plan, and a patch in it. Arrays over nodes are by inner numbers. */
typedef struct patch {
    test_mesh box;
    planish_plan *plan;
    pl_star_problem problem;
    pl_star_guard guard;
    pl_star_untangling asked;
    uint8_t *in_patch;
    double *size;
} patch;

static void patch_create(patch *p, int dim, unsigned seed) {
    const unsigned every = 1 + seed % 4;
    test_mesh_box(&p->box, dim, dim == 3 ? 4 : 7);
    test_mesh_perturb(&p->box, 0.6, seed);
    assert_int_equal(planish_plan_create(&p->box.mesh, NULL, &p->plan, NULL), 0);
    const int64_t n = p->box.mesh.n_nodes;
    p->in_patch = calloc((size_t)n, sizeof *p->in_patch);
    p->size = malloc((size_t)n * sizeof *p->size);
    for (int64_t i = 0; i < n; i++) {
        p->in_patch[p->plan->inner[i]] =
            p->plan->work.mobility[i] && test_random(&seed) * every < 1;
        p->size[p->plan->inner[i]] = 0.5 + test_random(&seed);
    }
    pl_plan_order(p->plan, p->box.coordinates, p->plan->scratch.coordinates);
    p->guard = (pl_star_guard){.ratio_weight = 1, .min_volume = seed % 2 ? 0.05 : 0};
    p->asked = (pl_star_untangling){.in_patch = p->in_patch, .size = p->size, .epsilon = 0.1};
    p->problem = pl_plan_problem(p->plan, &p->plan->interior);
    p->problem.guard = &p->guard;
    p->problem.untangling = &p->asked;
}

static void patch_destroy(patch *p) {
    free(p->in_patch);
    free(p->size);
    planish_plan_destroy(p->plan);
    test_mesh_destroy(&p->box);
}

/** D of an element, over 6 or 2. */
static long double measure_of(int dim, long double p[4][3]) {
    long double e[3][3];
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            e[j][d] = p[j + 1][d] - p[0][d];
    if (dim == 2)
        return (e[0][0] * e[1][1] - e[0][1] * e[1][0]) / 2;
    return (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
            e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
            e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) /
           6;
}

/** The elements with a node of the patch, each once. */
static pl_star_energy plain_energy(const patch *p) {
    const int dim = p->box.mesh.dim;
    pl_star_energy all = {.least = INFINITY};
    for (int64_t i = 0; i < p->box.mesh.n_elements; i++) {
        long double corner[4][3], h = 0;
        int touched = 0;
        for (int j = 0; j <= dim; j++) {
            const int32_t node = p->box.elements[i * (dim + 1) + j];
            for (int d = 0; d < dim; d++)
                corner[j][d] = p->box.coordinates[node * dim + d];
            h += (long double)p->size[p->plan->inner[node]] / (dim + 1);
            touched |= p->in_patch[p->plan->inner[node]];
        }
        const long double measure = measure_of(dim, corner);
        const element e = element_of(dim, corner, measure, p->guard.min_volume, h);
        if (!touched)
            continue;
        pl_sum_add(&all.sum, (double)function_of(&e, 0, p->asked.epsilon, dim));
        all.least = fmin(all.least, (double)e.u);
        all.tangled += (e.u <= 0 || measure <= 0) * PL_SHARES;
    }
    return all;
}

static pl_star_energy energy_of_stars(const patch *p, int64_t begin, int64_t end) {
    return p->plan->kernel->guarded->energy[p->box.mesh.dim - 2](&p->problem, begin, end,
                                                                 p->plan->scratch.kernels, NULL);
}

static void patches_count_each_element_once(void **state) {
    int dim = *(int *)*state, n_tangled = 0;
    for (unsigned seed = 0; seed < 40; seed++) {
        patch p;
        patch_create(&p, dim, seed);
        const int64_t n = p.plan->interior.stars.n_stars;
        const pl_star_energy wanted = plain_energy(&p), found = energy_of_stars(&p, 0, n);
        pl_star_energy a = energy_of_stars(&p, 0, n / 3), b = energy_of_stars(&p, n / 3, n);
        n_tangled += wanted.tangled > 0;
        assert_true(fabs(pl_sum_value(&found.sum) / pl_sum_value(&wanted.sum) - 1) < 1e-10);
        assert_true(fabs(found.least - wanted.least) < 1e-10);
        assert_int_equal(found.tangled, wanted.tangled);
        assert_int_equal(a.tangled + b.tangled, found.tangled);
        assert_true(fmin(a.least, b.least) == found.least);
        pl_sum_merge(&a.sum, &b.sum);
        assert_true(pl_sum_value(&a.sum) == pl_sum_value(&found.sum));
        patch_destroy(&p);
    }
    assert_true(n_tangled > 30);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        BOTH(the_energy_is_that_of_the_formulas), BOTH(slopes_match_differences),
        BOTH(the_wanted_element_is_the_best),     BOTH(powers_of_two_change_no_bit),
        BOTH(variants_give_the_same_bits),        BOTH(visits_lower_the_energy),
        BOTH(nodes_outside_of_the_patch_stay),    BOTH(bounds_are_kept),
        BOTH(positions_are_floats_where_asked),   BOTH(places_are_admitted),
        BOTH(patches_count_each_element_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
