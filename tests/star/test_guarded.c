/* The guarded kernel: its function against textbook formulas in long double, the variants against
 * the plain one, its optima against searches, and what it says of feasibility against the vertices
 * of the polytope. */
#define PL_PACK 1
#include "star/kernel_lanes.h"
#include "support/both.h"
#include "support/guarded_star.h"
#include "support/halfspaces.h"
#include "support/hand_star.h"
#include "support/meshes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static const planish_isa variants[] = {PLANISH_ISA_VECTOR, PLANISH_ISA_AVX2, PLANISH_ISA_AVX512};

/* Objectives, and the two of pl_star_worst with a limit that most stars are above. */
enum { MEASURES = PL_WORST_ANGLE + 1 };
#define WORST_LIMIT 1.5

/* A volume counts as reached to this, as g. */
#define MET 0.003

/* ---- the function -------------------------------------------------------------------------- */

static void inverse_cube_roots_are_accurate(void **state) {
    (void)state;
    unsigned seed = 1;
    for (int exponent = -1022; exponent <= 1023; exponent++)
        for (int i = 0; i < 20; i++) {
            double a = ldexp(1 + test_random(&seed), exponent);
            long double wanted = 1 / cbrtl((long double)a);
            assert_true(fabsl(lanes_inverse_cube_root(a) / wanted - 1) < 4 * 0x1p-53L);
        }
}

/** Central differences in long double, extrapolated once, along direction e_i (+ e_j). */
static long double difference(const guarded_star *g, int i, int j, int second) {
    long double result[2];
    for (int level = 0; level < 2; level++) {
        long double h = level ? 1e-5L : 2e-5L, f[3];
        for (int k = 0; k < 3; k++) {
            long double x[3];
            guarded_position(g, x);
            for (int d = 0; d < g->s.dim; d++)
                x[d] += (k - 1) * h * ((d == i) + (d == j));
            f[k] = hand_star_function(&g->s, x);
        }
        result[level] = second ? (f[0] - 2 * f[1] + f[2]) / (h * h) : (f[2] - f[0]) / (2 * h);
    }
    return (4 * result[1] - result[0]) / 3;
}

static void check_derivatives(guarded_star *g) {
    pl_star_value value, alone;
    const int dim = g->s.dim;
    long double x[3], second[3][3], size = 0;
    guarded_position(g, x);
    long double f = hand_star_function(&g->s, x);
    assert_true(guarded_evaluate(g, PLANISH_ISA_PLAIN, 1, &value));
    assert_true(guarded_evaluate(g, PLANISH_ISA_PLAIN, 0, &alone));
    assert_true(value.sum == alone.sum && value.max == alone.max);
    assert_true(fabsl(value.sum - f) < 1e-12L * f);
    for (int i = 0; i < dim; i++)
        size += fabsl(second[i][i] = difference(g, i, -1, 1));
    for (int i = 0, k = 0; i < dim; i++)
        for (int j = i; j < dim; j++, k++) {
            /* along e_i + e_j the second difference is H_ii + 2 H_ij + H_jj */
            long double wanted =
                i == j ? second[i][i] : (difference(g, i, j, 1) - second[i][i] - second[j][j]) / 2;
            assert_true(fabsl(value.hessian[k] - wanted) < 1e-7L * size);
        }
    for (int i = 0; i < dim; i++)
        assert_true(fabsl(value.gradient[i] - difference(g, i, -1, 0)) < 1e-9L * size);
}

static void derivatives_match_differences(void **state) {
    enum { STARS = 25 };
    int dim = *(int *)*state;
    for (int objective = 0; objective < MEASURES; objective++)
        for (unsigned seed = 0; seed < STARS; seed++) {
            guarded_star g;
            unsigned random = test_mixed_seed(seed);
            guarded_create(&g, dim, 0.4 * seed / STARS, seed);
            g.guard.objective = objective;
            g.guard.ratio_weight = 0.3 + test_random(&random);
            check_derivatives(&g);
            guarded_random_floors(&g, &random);
            check_derivatives(&g);
            g.guard.volume_weight = 2 * test_random(&random);
            check_derivatives(&g);
            guarded_destroy(&g);
        }
}

static void radius_ratio_is_that_of_the_plain_kernel(void **state) {
    int dim = *(int *)*state;
    for (unsigned seed = 0; seed < 200; seed++) {
        guarded_star g;
        pl_star_value a, b;
        guarded_create(&g, dim, 0.5 * seed / 200, seed);
        pl_star_kernel_select(PLANISH_ISA_PLAIN)
            ->evaluate[dim - 2](&g.s.problem, 0, g.s.scratch, 1, &a);
        guarded_evaluate(&g, PLANISH_ISA_PLAIN, 1, &b);
        double trace = 0;
        for (int k = 0; k < 6; k++)
            trace += fabs(a.hessian[k]);
        assert_true(fabs(a.sum - b.sum) < 1e-12 * a.sum && fabs(a.max - b.max) < 1e-12 * a.max);
        for (int k = 0; k < 6; k++)
            assert_true(fabs(a.hessian[k] - b.hessian[k]) < 1e-12 * trace);
        for (int k = 0; k < 3; k++)
            assert_true(fabs(a.gradient[k] - b.gradient[k]) < 1e-12 * trace);
        guarded_destroy(&g);
    }
}

/* ---- the variants -------------------------------------------------------------------------- */

enum { FREE, ACTIVE, VIOLATED, INVERTED, SOME_VIOLATED, BOXED, WITHIN_RADIUS, TO_FLOAT, SCENES };

/** Half of the elements want more than they have, the others nothing. */
static void ask_of_some(guarded_star *g, unsigned seed) {
    unsigned random = test_mixed_seed(seed);
    g->guard.min_volume = 0;
    g->guard.link_min_volume = g->floors;
    for (int64_t f = 0; f < guarded_facets(g); f++)
        g->floors[f] = test_random(&random) < 0.5 ? 3 * (double)guarded_measure(g, f) : 0;
}

/** Set a star up in the way that scene says. */
static void set_scene(guarded_star *g, int scene, unsigned seed) {
    const int dim = g->s.dim;
    g->guard.objective = (int)(seed % MEASURES);
    g->guard.volume_weight = seed % 2 ? 0.1 : 0;
    g->s.problem.search = seed / 2 % 2 ? PLANISH_SEARCH_NEWTON : PLANISH_SEARCH_FLETCHER_REEVES;
    g->guard.min_volume = (double)guarded_mean_measure(g) * (scene == ACTIVE ? 0.7 : 0.3);
    if (scene == VIOLATED || scene == INVERTED)
        g->s.coordinates[0] += scene == INVERTED ? 1.2 : 0.6;
    if (scene == SOME_VIOLATED)
        ask_of_some(g, seed);
    if (scene == BOXED) {
        g->guard.lower = g->lower;
        g->guard.upper = g->upper;
        for (int d = 0; d < dim; d++) {
            g->lower[d] = g->s.coordinates[d] - 0.02;
            g->upper[d] = g->s.coordinates[d] + 0.01;
        }
    }
    if (scene == WITHIN_RADIUS) {
        g->guard.start = g->start;
        g->guard.radius = g->radius;
        memcpy(g->start, g->s.coordinates, sizeof g->start);
        g->radius[0] = 0.02;
    }
    g->s.problem.storage.precision =
        scene == TO_FLOAT ? PLANISH_PRECISION_FLOAT : PLANISH_PRECISION_DOUBLE;
}

static void compare_variant(planish_isa isa, int dim, int scene, unsigned seed) {
    guarded_star plain, other;
    pl_star_value a, b;
    guarded_create(&plain, dim, 0.4, seed);
    guarded_create(&other, dim, 0.4, seed);
    set_scene(&plain, scene, seed);
    set_scene(&other, scene, seed);
    for (int i = 0; i < 5; i++) {
        assert_int_equal(guarded_evaluate(&plain, PLANISH_ISA_PLAIN, 1, &a),
                         guarded_evaluate(&other, isa, 1, &b));
        assert_memory_equal(&a, &b, sizeof a);
        pl_star_tally p = guarded_visit(&plain, PLANISH_ISA_PLAIN), q = guarded_visit(&other, isa);
        assert_memory_equal(&p, &q, sizeof p);
        assert_memory_equal(plain.s.coordinates, other.s.coordinates, sizeof plain.s.coordinates);
        assert_memory_equal(plain.s.changed, other.s.changed, sizeof plain.s.changed);
        pl_star_optimality o = guarded_optimality(&plain, PLANISH_ISA_PLAIN);
        pl_star_optimality r = guarded_optimality(&other, isa);
        assert_memory_equal(&o, &r, sizeof o);
    }
    guarded_destroy(&plain);
    guarded_destroy(&other);
}

static void variants_give_the_same_bits(void **state) {
    int dim = *(int *)*state;
    for (size_t v = 0; v < sizeof variants / sizeof *variants; v++)
        for (int scene = 0; scene < SCENES && pl_star_kernel_select(variants[v]); scene++)
            for (unsigned seed = 0; seed < 60; seed++)
                compare_variant(variants[v], dim, scene, seed);
}

/* ---- optima -------------------------------------------------------------------------------- */

/** Whether x keeps all floors, exactly, and is inside the star. */
static int is_feasible(const guarded_star *g, const long double *x) {
    int feasible = 1;
    for (int64_t f = 0; feasible && f < guarded_facets(g); f++) {
        long double v = hand_star_measure(&g->s, f, x);
        feasible = v > 0 && v >= hand_star_floor(&g->s, f);
    }
    return feasible;
}

/** The best feasible point of a grid around centre; its value. */
static long double search_grid(const guarded_star *g, long double *centre, long double size) {
    enum { HALF = 4, SIDE = 2 * HALF + 1 };
    const int dim = g->s.dim;
    long double best = INFINITY, at[3] = {0, 0, 0};
    for (int i = 0; i < (dim == 3 ? SIDE * SIDE * SIDE : SIDE * SIDE); i++) {
        const int step[3] = {i % SIDE - HALF, i / SIDE % SIDE - HALF, i / SIDE / SIDE - HALF};
        long double x[3];
        for (int d = 0; d < dim; d++)
            x[d] = centre[d] + size / HALF * step[d];
        long double f = is_feasible(g, x) ? hand_star_function(&g->s, x) : INFINITY;
        if (f < best) {
            best = f;
            memcpy(at, x, sizeof at);
        }
    }
    memcpy(centre, at, sizeof at);
    return best;
}

/** Least value of the star's function over its feasible positions, by grids that become finer: the
 *  first reaches as far as size. */
static long double search_all(const guarded_star *g, long double *x, long double size) {
    long double best = INFINITY;
    for (; size > 1e-7L; size *= 0.65L)
        best = fminl(best, search_grid(g, x, size));
    return best;
}

/** Give most of the facets whose elements lose volume on the way from where the star is to its
 * optimum floors half way; returns how many. The star stays where it is. */
static int forbid_the_optimum(guarded_star *g, int most) {
    double from[3];
    long double before[HAND_STAR_MAX_FACETS];
    int n = 0;
    memcpy(from, g->s.coordinates, sizeof from);
    for (int64_t f = 0; f < guarded_facets(g); f++)
        before[f] = guarded_measure(g, f);
    guarded_visits(g, 60);
    for (int64_t f = 0; f < guarded_facets(g) && n < most; f++) {
        long double after = guarded_measure(g, f);
        g->floors[f] = after < 0.95L * before[f] ? (double)(0.5L * (before[f] + after)) : 0;
        n += g->floors[f] > 0;
    }
    g->guard.link_min_volume = g->floors;
    memcpy(g->s.coordinates, from, (size_t)g->s.dim * sizeof *from);
    return n;
}

/** A star away from its optimum, which floors of at most as many elements forbid; with a volume
 * weight all have floors. Returns how many forbid. */
static int create_forbidden(guarded_star *g, int dim, int objective, int most, double volume_weight,
                            unsigned seed) {
    guarded_create(g, dim, 0.25, seed);
    unsigned random = test_mixed_seed(seed);
    for (int d = 0; d < dim; d++)
        g->s.coordinates[d] += 0.5 * (test_random(&random) - 0.5);
    g->guard.objective = objective;
    g->guard.volume_weight = volume_weight;
    g->guard.min_volume = volume_weight > 0 ? 0.3 * (double)guarded_mean_measure(g) : 0;
    return forbid_the_optimum(g, most);
}

static void check_optimum(guarded_star *g, planish_search direction, long double best) {
    double from[3];
    long double x[3];
    memcpy(from, g->s.coordinates, sizeof from);
    g->s.problem.search = direction;
    guarded_visits(g, 300);
    guarded_position(g, x);
    pl_star_optimality o = guarded_optimality(g, PLANISH_ISA_AUTO);
    assert_true(guarded_worst(g) <= 1e-6L);
    assert_int_equal(o.n_stars, 1);
    assert_true(o.residual < 1e-4);
    assert_true(o.n_active > 0);
    assert_true(o.multiplier > 0);
    /* No worse than the grids' best, and no better than grids can miss along an edge. */
    assert_true(hand_star_function(&g->s, x) < (1 + 1e-7L) * best);
    assert_true(hand_star_function(&g->s, x) > (1 - 1e-3L) * best);
    memcpy(g->s.coordinates, from, (size_t)g->s.dim * sizeof *from);
}

static void visits_reach_the_constrained_optimum(void **state) {
    int dim = *(int *)*state;
    for (int objective = 0; objective < 3; objective++)
        for (unsigned seed = 0; seed < 4; seed++) {
            guarded_star g;
            long double x[3] = {0, 0, 0};
            double volume_weight = seed == 3 ? 0.01 : 0;
            assert_true(create_forbidden(&g, dim, objective, dim, volume_weight, seed) > 0);
            long double best = search_all(&g, x, 1);
            check_optimum(&g, PLANISH_SEARCH_NEWTON, best);
            check_optimum(&g, PLANISH_SEARCH_FLETCHER_REEVES, best);
            guarded_destroy(&g);
        }
}

/** Norm of the gradient of g of one facet's element, which is affine. */
static long double steepness(const guarded_star *g, int64_t facet) {
    long double square = 0, x[3];
    guarded_position(g, x);
    long double here = hand_star_measure(&g->s, facet, x);
    for (int d = 0; d < g->s.dim; d++) {
        x[d] += 1;
        long double slope = (hand_star_measure(&g->s, facet, x) - here) / g->floors[facet];
        square += slope * slope;
        x[d] -= 1;
    }
    return sqrtl(square);
}

/** With one constraint in force, multiplier * |grad g| = |grad f|. */
static void the_multiplier_balances_the_gradient(void **state) {
    int dim = *(int *)*state, checked = 0;
    for (unsigned seed = 0; seed < 30; seed++) {
        guarded_star g;
        int n = create_forbidden(&g, dim, (int)seed % 3, 1, 0, seed);
        guarded_visits(&g, n ? 300 : 0);
        pl_star_optimality o = guarded_optimality(&g, PLANISH_ISA_AUTO);
        for (int64_t f = 0; f < guarded_facets(&g) && n; f++) {
            long double square = 0;
            for (int d = 0; g.floors[f] > 0 && d < dim; d++)
                square += difference(&g, d, -1, 0) * difference(&g, d, -1, 0);
            if (!(g.floors[f] > 0))
                continue;
            assert_int_equal(o.n_active, 1);
            assert_true(fabsl(1 - guarded_measure(&g, f) / g.floors[f]) < 1e-6L);
            assert_true(fabsl(o.multiplier * steepness(&g, f) / sqrtl(square) - 1) < 1e-3L);
            checked++;
        }
        guarded_destroy(&g);
    }
    assert_true(checked > 20);
}

/* ---- feasibility --------------------------------------------------------------------------- */

/** The half-spaces of the star's floors, of those facets that wanted (NULL: all) has. Box: the
 * bounds of the node, too. */
static void polytope(const guarded_star *g, const uint8_t *wanted, int box, long double part,
                     int positive, halfspaces *h) {
    const int dim = g->s.dim;
    halfspaces_start(h, dim, 1e6L);
    for (int64_t f = 0; f < guarded_facets(g); f++) {
        long double at[3] = {0, 0, 0}, normal[3] = {0, 0, 0};
        if ((wanted && !wanted[f]) || !(positive || hand_star_floor(&g->s, f) > 0))
            continue;
        long double constant = hand_star_measure(&g->s, f, at);
        for (int d = 0; d < dim; d++) {
            at[d] = 1;
            normal[d] = hand_star_measure(&g->s, f, at) - constant;
            at[d] = 0;
        }
        halfspaces_add(h, normal, part * hand_star_floor(&g->s, f) - constant);
    }
    for (int d = 0; box && d < dim; d++) {
        long double unit[3] = {0, 0, 0};
        unit[d] = 1;
        halfspaces_add(h, unit, g->lower[d]);
        unit[d] = -1;
        halfspaces_add(h, unit, -g->upper[d]);
    }
}

/* A point this deep inside of all half-spaces makes a star clearly feasible; none that is less than
 * this outside of some, clearly infeasible. */
#define CLEAR 1e-3L

/** A star with a floor for every element, of a random part of the largest that could be, its node
 * somewhere: perhaps inside, perhaps outside. */
static void create_lost(guarded_star *g, int dim, unsigned seed, double part) {
    unsigned random = test_mixed_seed(seed);
    guarded_create(g, dim, 0.4, seed);
    g->guard.objective = (int)(seed % MEASURES);
    g->s.problem.search = seed / 3 % 2 ? PLANISH_SEARCH_NEWTON : PLANISH_SEARCH_FLETCHER_REEVES;
    g->guard.link_min_volume = g->floors;
    for (int64_t f = 0; f < guarded_facets(g); f++)
        g->floors[f] = (double)guarded_mean_measure(g) * part * (0.5 + test_random(&random));
    for (int d = 0; d < dim; d++)
        g->s.coordinates[d] += 3 * (test_random(&random) - 0.5);
}

/** Visit; no element that was positive may become less. Returns whether elements were restored. */
static int64_t visit_and_watch(guarded_star *g, planish_isa isa) {
    long double before[HAND_STAR_MAX_FACETS];
    for (int64_t f = 0; f < guarded_facets(g); f++)
        before[f] = guarded_measure(g, f);
    pl_star_tally tally = guarded_visit(g, isa);
    for (int64_t f = 0; f < guarded_facets(g); f++)
        assert_true(!(before[f] > 0) || guarded_measure(g, f) > 0);
    return tally.restored;
}

static void feasible_stars_are_restored(void **state) {
    int dim = *(int *)*state, feasible = 0, outside = 0;
    for (unsigned seed = 0; seed < 300; seed++) {
        guarded_star g;
        halfspaces h;
        create_lost(&g, dim, seed, 0.1 + 0.9 * seed / 300);
        polytope(&g, NULL, 0, 1, 0, &h);
        int can_be = halfspaces_meet(&h, CLEAR, NULL);
        outside += guarded_worst(&g) > 1;
        for (int i = 0; i < 20; i++)
            visit_and_watch(&g, i % 2 ? PLANISH_ISA_AUTO : PLANISH_ISA_PLAIN);
        assert_true(!can_be || guarded_worst(&g) <= MET);
        feasible += can_be;
        guarded_destroy(&g);
    }
    assert_true(feasible > 100 && feasible < 300 && outside > 100);
}

/** Elements without a floor of their own must not pay for those with one. */
static void elements_without_floors_stay_positive(void **state) {
    int dim = *(int *)*state, restored = 0;
    for (unsigned seed = 0; seed < 100; seed++) {
        guarded_star g;
        guarded_create(&g, dim, 0.3, seed);
        ask_of_some(&g, seed);
        for (int i = 0; i < 10; i++)
            restored += visit_and_watch(&g, i % 2 ? PLANISH_ISA_AUTO : PLANISH_ISA_PLAIN) > 0;
        guarded_destroy(&g);
    }
    assert_true(restored > 100);
}

/** As for feasible_stars_are_restored, in a box that the feasible places must share. */
static void feasible_stars_are_restored_within_bounds(void **state) {
    int dim = *(int *)*state, feasible = 0;
    for (unsigned seed = 0; seed < 300; seed++) {
        guarded_star g;
        halfspaces h;
        unsigned random = test_mixed_seed(seed);
        create_lost(&g, dim, seed, 0.05 + 0.4 * seed / 300);
        g.guard.lower = g.lower;
        g.guard.upper = g.upper;
        for (int d = 0; d < dim; d++) {
            g.lower[d] = g.s.coordinates[d] - 1.5 * test_random(&random);
            g.upper[d] = g.s.coordinates[d] + 1.5 * test_random(&random);
        }
        polytope(&g, NULL, 1, 1, 0, &h);
        int can_be = halfspaces_meet(&h, CLEAR, NULL);
        for (int i = 0; i < 20; i++) {
            visit_and_watch(&g, PLANISH_ISA_AUTO);
            for (int d = 0; d < dim; d++)
                assert_true(g.s.coordinates[d] >= g.lower[d] && g.s.coordinates[d] <= g.upper[d]);
        }
        assert_true(!can_be || guarded_worst(&g) <= MET);
        feasible += can_be;
        guarded_destroy(&g);
    }
    assert_true(feasible > 30 && feasible < 270);
}

/** What the library says of the star with these fixed nodes must be what the vertices say of the
 *  facets that have no free node, and its proof must be one. */
static int check_proof(guarded_star *g, const uint8_t *is_fixed) {
    uint8_t of_fixed[HAND_STAR_MAX_FACETS], part[HAND_STAR_MAX_FACETS];
    uint8_t rest[HAND_STAR_MAX_FACETS];
    halfspaces h;
    const int dim = g->s.dim;
    for (int64_t f = 0; f < guarded_facets(g); f++) {
        of_fixed[f] = 1;
        for (int j = 0; j < dim; j++)
            of_fixed[f] &= is_fixed[g->s.ring[g->s.link[f * dim + j]]];
    }
    polytope(g, of_fixed, 0, 1 - PLANISH_VOLUME_TOLERANCE, 1, &h);
    int feasible = halfspaces_meet(&h, CLEAR, NULL);
    int infeasible = !halfspaces_meet(&h, -CLEAR, NULL);
    int given_up =
        (int)pl_star_infeasible(&g->s.problem, 0, dim, is_fixed, g->s.scratch, part, NULL);
    int proof = given_up > 0;
    assert_true(!(proof && feasible) && !(!proof && infeasible));
    int n = 0;
    for (int64_t f = 0; f < guarded_facets(g); f++) {
        assert_true(part[f] == PL_PROOF_NONE || of_fixed[f]);
        rest[f] = of_fixed[f] && part[f] != PL_PROOF_GIVEN_UP;
        n += part[f] != PL_PROOF_NONE;
        given_up -= part[f] == PL_PROOF_GIVEN_UP;
    }
    assert_true(proof ? n >= 2 : n == 0);
    assert_int_equal(given_up, 0);
    polytope(g, part, 0, 1 - PLANISH_VOLUME_TOLERANCE, 1, &h);
    assert_true(!proof || !halfspaces_meet(&h, 0, NULL));
    polytope(g, rest, 0, 1 - PLANISH_VOLUME_TOLERANCE, 1, &h);
    assert_true(!proof || halfspaces_meet(&h, -CLEAR, NULL));
    return proof;
}

static void infeasible_stars_are_proven(void **state) {
    int dim = *(int *)*state, proven = 0, without = 0;
    for (unsigned seed = 0; seed < 300; seed++) {
        guarded_star g;
        uint8_t is_fixed[HAND_STAR_MAX_NODES];
        unsigned random = test_mixed_seed(seed);
        create_lost(&g, dim, seed, 0.3 + 1.2 * seed / 300);
        for (int64_t f = 0; f < guarded_facets(&g); f++)
            if (test_random(&random) < 0.2)
                g.floors[f] = 0;
        memset(is_fixed, 1, sizeof is_fixed);
        is_fixed[0] = 0;
        int all_fixed = check_proof(&g, is_fixed);
        is_fixed[1 + seed % 5] = 0;
        without += all_fixed > check_proof(&g, is_fixed);
        memset(is_fixed, 0, sizeof is_fixed);
        assert_false(check_proof(&g, is_fixed));
        proven += all_fixed;
        guarded_destroy(&g);
    }
    assert_true(proven > 50 && proven < 250 && without > 5);
}

/* ---- bounds -------------------------------------------------------------------------------- */

/** A star away from its optimum, which goes to optimum. */
static void create_away(guarded_star *g, int dim, unsigned seed, double *optimum) {
    double from[3];
    unsigned random = test_mixed_seed(seed);
    guarded_create(g, dim, 0.2, seed);
    g->guard.objective = seed % 2 ? PLANISH_OBJECTIVE_MEAN_RATIO : PLANISH_OBJECTIVE_RADIUS_RATIO;
    g->s.problem.search = seed / 2 % 2 ? PLANISH_SEARCH_NEWTON : PLANISH_SEARCH_FLETCHER_REEVES;
    for (int d = 0; d < dim; d++)
        from[d] = g->s.coordinates[d] += 0.6 * (test_random(&random) - 0.5);
    guarded_visits(g, 100);
    memcpy(optimum, g->s.coordinates, (size_t)dim * sizeof *optimum);
    memcpy(g->s.coordinates, from, (size_t)dim * sizeof *from);
}

static void bounds_are_kept_and_reached(void **state) {
    int dim = *(int *)*state, checked = 0;
    for (unsigned seed = 0; seed < 100; seed++) {
        guarded_star g;
        double optimum[3];
        const int d = (int)seed % dim;
        create_away(&g, dim, seed, optimum);
        if (fabs(g.s.coordinates[d] - optimum[d]) < 0.01) {
            guarded_destroy(&g);
            continue;
        }
        double bound = 0.5 * (g.s.coordinates[d] + optimum[d]);
        int is_upper = optimum[d] > g.s.coordinates[d];
        (is_upper ? g.upper : g.lower)[d] = bound;
        g.guard.lower = g.lower;
        g.guard.upper = g.upper;
        for (int i = 0; i < 100; i++) {
            visit_and_watch(&g, PLANISH_ISA_AUTO);
            assert_true(is_upper ? g.s.coordinates[d] <= bound : g.s.coordinates[d] >= bound);
        }
        assert_true(fabs(g.s.coordinates[d] - bound) < 1e-6);
        pl_star_optimality o = guarded_optimality(&g, PLANISH_ISA_AUTO);
        assert_true(o.residual < 1e-4 && o.n_active == 1);
        assert_true(o.multiplier == 0); /* of volumes: there are none */
        checked++;
        guarded_destroy(&g);
    }
    assert_true(checked > 80);
}

static void a_node_without_room_is_held(void **state) {
    int dim = *(int *)*state;
    guarded_star g;
    double optimum[3], from[3];
    create_away(&g, dim, 5, optimum);
    memcpy(from, g.s.coordinates, sizeof from);
    for (int d = 0; d < dim; d++)
        g.lower[d] = g.upper[d] = from[d];
    g.guard.lower = g.lower;
    g.guard.upper = g.upper;
    pl_star_tally tally = guarded_visit(&g, PLANISH_ISA_AUTO);
    assert_int_equal(tally.visits, 0);
    assert_int_equal(guarded_optimality(&g, PLANISH_ISA_AUTO).n_stars, 0);
    assert_memory_equal(g.s.coordinates, from, (size_t)dim * sizeof *from);
    guarded_destroy(&g);
}

static long double distance(const double *x, const double *y, int dim) {
    long double square = 0;
    for (int d = 0; d < dim; d++)
        square += ((long double)x[d] - y[d]) * ((long double)x[d] - y[d]);
    return sqrtl(square);
}

/** Put the node on the sphere, aside of where the way to the optimum crosses it. */
static void put_aside(guarded_star *g, const double *optimum, unsigned seed) {
    const int dim = g->s.dim;
    unsigned random = test_mixed_seed(seed);
    double aside[3], length = 0;
    memcpy(g->start, g->s.coordinates, sizeof g->start);
    g->radius[0] = 0.5 * (double)distance(g->start, optimum, dim);
    g->guard.start = g->start;
    g->guard.radius = g->radius;
    for (int d = 0; d < dim; d++) {
        aside[d] = optimum[d] - g->start[d] + 2 * g->radius[0] * (2 * test_random(&random) - 1);
        length += aside[d] * aside[d];
    }
    for (int d = 0; d < dim; d++)
        g->s.coordinates[d] = g->start[d] + aside[d] / sqrt(length) * g->radius[0] * (1 - 0x1p-30);
}

/** No point of the ball next to the node is better. */
static void check_ball(const guarded_star *g, unsigned seed) {
    unsigned random = test_mixed_seed(seed);
    long double x[3];
    guarded_position(g, x);
    long double here = hand_star_function(&g->s, x);
    for (int i = 0; i < 200; i++) {
        double y[3];
        long double there[3];
        for (int d = 0; d < g->s.dim; d++)
            there[d] = y[d] =
                g->s.coordinates[d] + 0.2 * g->radius[0] * (2 * test_random(&random) - 1);
        if (distance(y, g->start, g->s.dim) <= g->radius[0])
            assert_true(hand_star_function(&g->s, there) > here * (1 - 1e-6L));
    }
}

static void nodes_move_along_the_sphere(void **state) {
    int dim = *(int *)*state;
    for (unsigned seed = 0; seed < 60; seed++) {
        guarded_star g;
        double optimum[3];
        create_away(&g, dim, seed, optimum);
        put_aside(&g, optimum, seed);
        for (int i = 0; i < 200; i++) {
            visit_and_watch(&g, PLANISH_ISA_AUTO);
            assert_true((double)distance(g.s.coordinates, g.start, dim) <= g.radius[0]);
        }
        assert_true(distance(g.s.coordinates, g.start, dim) > (1 - 1e-4L) * g.radius[0]);
        /* Fletcher-Reeves goes along constraints by steepest descent, which takes longer. */
        assert_true(guarded_optimality(&g, PLANISH_ISA_AUTO).residual <
                    (g.s.problem.search == PLANISH_SEARCH_NEWTON ? 1e-3 : 1e-2));
        check_ball(&g, seed);
        guarded_destroy(&g);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(inverse_cube_roots_are_accurate),
        BOTH(derivatives_match_differences),
        BOTH(radius_ratio_is_that_of_the_plain_kernel),
        BOTH(variants_give_the_same_bits),
        BOTH(visits_reach_the_constrained_optimum),
        BOTH(the_multiplier_balances_the_gradient),
        BOTH(feasible_stars_are_restored),
        BOTH(elements_without_floors_stay_positive),
        BOTH(feasible_stars_are_restored_within_bounds),
        BOTH(infeasible_stars_are_proven),
        BOTH(bounds_are_kept_and_reached),
        BOTH(a_node_without_room_is_held),
        BOTH(nodes_move_along_the_sphere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
