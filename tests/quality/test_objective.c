/* F's sums and the minimum volumes of random meshes against brute force in long double. */
#include "quality/objective.h"
#include "support/both.h"
#include "support/meshes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { NODES = 400, ELEMENTS = 9000 };

/* ---- one element by the textbook ----------------------------------------------------------- */

typedef struct element {
    int dim;
    long double x[4][3], measure;
} element;

static long double distance(const element *e, int i, int j) {
    long double square = 0;
    for (int d = 0; d < e->dim; d++)
        square += (e->x[i][d] - e->x[j][d]) * (e->x[i][d] - e->x[j][d]);
    return sqrtl(square);
}

/** Signed, the mesh's orientation included. */
static long double measure_of(const element *e, int sign) {
    long double v[3][3] = {{0}};
    for (int j = 0; j < e->dim; j++)
        for (int d = 0; d < e->dim; d++)
            v[j][d] = e->x[j + 1][d] - e->x[0][d];
    if (e->dim == 2)
        return sign * (v[0][0] * v[1][1] - v[0][1] * v[1][0]) / 2;
    return sign *
           (v[0][0] * (v[1][1] * v[2][2] - v[1][2] * v[2][1]) +
            v[0][1] * (v[1][2] * v[2][0] - v[1][0] * v[2][2]) +
            v[0][2] * (v[1][0] * v[2][1] - v[1][1] * v[2][0])) /
           6;
}

static long double area(const element *e, int i, int j, int k) {
    long double square = 0, u[3] = {0, 0, 0}, v[3] = {0, 0, 0};
    for (int d = 0; d < e->dim; d++) {
        u[d] = e->x[j][d] - e->x[i][d];
        v[d] = e->x[k][d] - e->x[i][d];
    }
    for (int d = 0; d < 3; d++) {
        int a = (d + 1) % 3, b = (d + 2) % 3;
        long double component = u[a] * v[b] - u[b] * v[a];
        square += component * component;
    }
    return sqrtl(square) / 2;
}

/** 16 area^2 of the triangle of these sides, which may be degenerate, is 4 of the product of the
 *  half perimeter and what it exceeds the sides by. */
static long double heron(long double a, long double b, long double c) {
    long double p = (a + b + c) / 2;
    return sqrtl(fmaxl(p * (p - a) * (p - b) * (p - c), 0));
}

/** R / (dim r), by R = abc / 4A, or Crelle's formula. */
static long double radius_ratio(const element *e) {
    if (e->dim == 2) {
        long double a = distance(e, 0, 1), b = distance(e, 1, 2), c = distance(e, 2, 0);
        return a * b * c / (4 * e->measure) * (a + b + c) / (4 * e->measure);
    }
    long double surface = area(e, 0, 1, 2) + area(e, 0, 1, 3) + area(e, 0, 2, 3) + area(e, 1, 2, 3);
    long double products =
        heron(distance(e, 0, 1) * distance(e, 2, 3), distance(e, 0, 2) * distance(e, 1, 3),
              distance(e, 0, 3) * distance(e, 1, 2));
    return products / (6 * e->measure) * surface / (9 * e->measure);
}

static long double mean_ratio(const element *e) {
    long double squares = 0;
    for (int i = 0; i < e->dim; i++)
        for (int j = i + 1; j <= e->dim; j++)
            squares += distance(e, i, j) * distance(e, i, j);
    if (e->dim == 2)
        return squares / (4 * sqrtl(3) * e->measure);
    return squares / 6 / powl(6 * sqrtl(2) * e->measure, 2.0L / 3);
}

static long double smoothed_edge_ratio(const element *e) {
    long double large = 0, small = 0, n = e->dim == 3 ? 6 : 3;
    for (int i = 0; i < e->dim; i++)
        for (int j = i + 1; j <= e->dim; j++) {
            large += powl(distance(e, i, j), 64) / n;
            small += powl(distance(e, i, j), -64) / n;
        }
    return powl(large * small, 1.0L / 64);
}

static long double aspect(const element *e, planish_objective objective) {
    return objective == PLANISH_OBJECTIVE_RADIUS_RATIO ? radius_ratio(e)
           : objective == PLANISH_OBJECTIVE_MEAN_RATIO ? mean_ratio(e)
                                                       : smoothed_edge_ratio(e);
}

/* ---- a random mesh and its sums ------------------------------------------------------------ */

typedef struct sample {
    test_mesh mesh;
    int8_t sign[ELEMENTS];
    uint8_t is_free[NODES];
    double own[ELEMENTS];
    pl_objective_problem problem;
} sample;

/** Random elements, about half of them inverted, signs of both kinds, own minimum volumes for some;
 * the size is 2^exponent. */
static void create(sample *s, int dim, unsigned seed, int exponent) {
    unsigned random = seed * 2654435761u + 7;
    test_mesh_garbage(&s->mesh, dim, NODES, ELEMENTS, seed);
    test_mesh_transform(&s->mesh, ldexp(1, exponent), 0);
    const double volume = dim == 3 ? 0.01 : 0.05;
    for (int i = 0; i < ELEMENTS; i++) {
        s->sign[i] = test_random(&random) < 0.3 ? -1 : 1;
        s->own[i] = test_random(&random) < 0.5
                        ? 0
                        : ldexp(volume * (0.1 + test_random(&random)), dim * exponent);
    }
    for (int i = 0; i < NODES; i++)
        s->is_free[i] = test_random(&random) < 0.3;
    s->problem = (pl_objective_problem){.mesh.dim = dim,
                                        .mesh.n_elements = ELEMENTS,
                                        .mesh.elements = s->mesh.elements,
                                        .mesh.sign = s->sign,
                                        .mesh.mobility = s->is_free,
                                        .coordinates = s->mesh.coordinates,
                                        .objective = (planish_objective)(seed % 3),
                                        .min_volume = ldexp(volume, dim * exponent),
                                        .mesh.min_volume = s->own,
                                        .threads = 1};
}

static element element_of(const pl_objective_problem *p, int64_t index) {
    element e = {.dim = p->mesh.dim};
    for (int j = 0; j <= p->mesh.dim; j++)
        for (int d = 0; d < p->mesh.dim; d++)
            e.x[j][d] =
                p->coordinates[p->mesh.elements[index * (p->mesh.dim + 1) + j] * p->mesh.dim + d];
    e.measure = measure_of(&e, p->mesh.sign ? p->mesh.sign[index] : 1);
    return e;
}

/** g, or -infinity. */
static long double constraint(const pl_objective_problem *p, int64_t index, const element *e) {
    double own = p->mesh.min_volume ? p->mesh.min_volume[index] : 0;
    double least = own > 0 ? own : p->min_volume;
    return least > 0 ? 1 - e->measure / least : -INFINITY;
}

typedef struct reference {
    long double ratio[2], radius[2], volume[2], n[2];
    long double radius_max, inverted, below, shortfall, domain;
} reference;

static void add_element(const pl_objective_problem *p, int64_t index, reference *sums) {
    element e = element_of(p, index);
    long double g = constraint(p, index, &e);
    int movable = 0;
    for (int j = 0; j <= p->mesh.dim; j++)
        movable |= p->mesh.mobility[p->mesh.elements[index * (p->mesh.dim + 1) + j]];
    sums->domain += e.measure;
    sums->below += g > PLANISH_VOLUME_TOLERANCE;
    sums->shortfall += g > 0 ? g * g : 0;
    if (!(e.measure > 0)) {
        sums->inverted++;
        return;
    }
    long double radius = radius_ratio(&e), ratio = aspect(&e, p->objective);
    sums->n[movable]++;
    sums->ratio[movable] += ratio * ratio;
    sums->radius[movable] += radius * radius;
    if (movable)
        sums->radius_max = fmaxl(sums->radius_max, radius * radius);
    sums->volume[movable] += g > -INFINITY ? g * g : 0;
}

static void close_to(double found, long double wanted) {
    assert_true(fabsl(found - wanted) <= 1e-11L * fabsl(wanted));
}

static void check_sums(const pl_objective_problem *p) {
    reference wanted = {.domain = 0};
    pl_objective_sums found;
    for (int64_t i = 0; i < p->mesh.n_elements; i++)
        add_element(p, i, &wanted);
    pl_sum_objective(p, &found);
    for (int movable = 0; movable < 2; movable++) {
        close_to(found.ratio[movable], wanted.ratio[movable]);
        close_to(found.radius[movable], wanted.radius[movable]);
        close_to(found.volume[movable], wanted.volume[movable]);
        assert_true(found.n[movable] == wanted.n[movable]);
    }
    close_to(found.radius_max, wanted.radius_max);
    close_to(found.shortfall, wanted.shortfall);
    close_to(found.domain, wanted.domain);
    assert_true(found.inverted == wanted.inverted && found.below == wanted.below);
}

/* ---- tests --------------------------------------------------------------------------------- */

static void sums_match_brute_force(void **state) {
    int dim = *(int *)*state;
    for (unsigned seed = 0; seed < 6; seed++) {
        sample s;
        create(&s, dim, seed, 0);
        check_sums(&s.problem);
        s.problem.mesh.sign = NULL;
        check_sums(&s.problem);
        s.problem.mesh.min_volume = NULL;
        check_sums(&s.problem);
        s.problem.min_volume = 0;
        check_sums(&s.problem);
        s.problem.mesh.min_volume = s.own;
        check_sums(&s.problem);
        test_mesh_destroy(&s.mesh);
    }
}

static void reversed_elements_are_the_same(void **state) {
    int dim = *(int *)*state;
    sample s, reversed;
    pl_objective_sums a, b;
    create(&s, dim, 3, 0);
    create(&reversed, dim, 3, 0);
    for (int64_t i = 0; i < ELEMENTS; i += 2) {
        test_mesh_reverse(&reversed.mesh, i);
        reversed.sign[i] = (int8_t)-reversed.sign[i];
    }
    pl_sum_objective(&s.problem, &a);
    pl_sum_objective(&reversed.problem, &b);
    assert_true(a.n[0] == b.n[0] && a.n[1] == b.n[1] && a.inverted == b.inverted);
    close_to(a.ratio[1], b.ratio[1]);
    close_to(a.volume[1], b.volume[1]);
    close_to(a.domain, b.domain);
    test_mesh_destroy(&s.mesh);
    test_mesh_destroy(&reversed.mesh);
}

static void sizes_change_no_bit(void **state) {
    int dim = *(int *)*state;
    static const int exponents[] = {-300, -150, -1, 13, 200, 300};
    for (unsigned seed = 0; seed < 3; seed++) {
        sample s;
        pl_objective_sums plain;
        create(&s, dim, seed, 0);
        pl_sum_objective(&s.problem, &plain);
        test_mesh_destroy(&s.mesh);
        for (size_t i = 0; i < sizeof exponents / sizeof *exponents; i++) {
            pl_objective_sums sums;
            create(&s, dim, seed, exponents[i]);
            pl_sum_objective(&s.problem, &sums);
            assert_true(sums.domain == ldexp(plain.domain, dim * exponents[i]));
            sums.domain = plain.domain;
            assert_memory_equal(&sums, &plain, sizeof sums);
            test_mesh_destroy(&s.mesh);
        }
    }
}

static void threads_change_no_bit(void **state) {
    int dim = *(int *)*state;
    static uint8_t first[ELEMENTS], other[ELEMENTS];
    static const int threads[] = {2, 3, 5};
    sample s;
    pl_objective_sums a, b;
    create(&s, dim, 5, 0);
    pl_sum_objective(&s.problem, &a);
    int64_t n_below = pl_find_below(&s.problem, first);
    for (size_t i = 0; i < sizeof threads / sizeof *threads; i++) {
        s.problem.threads = threads[i];
        memset(other, 99, sizeof other);
        pl_sum_objective(&s.problem, &b);
        assert_memory_equal(&a, &b, sizeof a);
        assert_int_equal(pl_find_below(&s.problem, other), n_below);
        assert_memory_equal(first, other, sizeof first);
    }
    test_mesh_destroy(&s.mesh);
}

static void elements_below_are_found(void **state) {
    int dim = *(int *)*state;
    static uint8_t found[ELEMENTS];
    for (int exponent = -300; exponent <= 300; exponent += 150) {
        sample s;
        create(&s, dim, 8, exponent);
        int64_t n = 0, n_found = pl_find_below(&s.problem, found);
        for (int64_t i = 0; i < ELEMENTS; i++) {
            element e = element_of(&s.problem, i);
            long double g = constraint(&s.problem, i, &e);
            assert_true(fabsl(g - PLANISH_VOLUME_TOLERANCE) > 1e-12L); /* clear */
            assert_int_equal(found[i], g > PLANISH_VOLUME_TOLERANCE ? PLANISH_VOLUME_BELOW
                                                                    : PLANISH_VOLUME_MET);
            n += g > PLANISH_VOLUME_TOLERANCE;
        }
        assert_int_equal(n, n_found);
        s.problem.mesh.min_volume = NULL;
        s.problem.min_volume = 0;
        assert_int_equal(pl_find_below(&s.problem, found), 0);
        test_mesh_destroy(&s.mesh);
    }
}

/** A coordinate in units of 2^-53. */
static __int128 integer(double x) {
    return (__int128)ldexp(x, 53);
}

enum { SIDE = 64 };

/** Check triangles whose first corner is some units in the last place from the line of q and r:
 *  which are positive is decided as by integers. */
static void check_nearly_flat(const double *q, const double *r) {
    static double coordinates[2 * (SIDE * SIDE + 2)];
    static int32_t elements[3 * SIDE * SIDE];
    static const uint8_t is_free[SIDE * SIDE + 2];
    static uint8_t wanted[SIDE * SIDE], found[SIDE * SIDE];
    const int n = SIDE * SIDE;
    int inverted = 0;
    for (int i = 0; i < n; i++) {
        const double *p = coordinates + 2 * i;
        coordinates[2 * i] = 0.5 + i % SIDE * 0x1p-53;
        coordinates[2 * i + 1] = 0.5 + i / SIDE * 0x1p-53;
        elements[3 * i] = i;
        elements[3 * i + 1] = n;
        elements[3 * i + 2] = n + 1;
        int positive = (integer(q[0]) - integer(p[0])) * (integer(r[1]) - integer(p[1])) >
                       (integer(q[1]) - integer(p[1])) * (integer(r[0]) - integer(p[0]));
        wanted[i] = positive ? PLANISH_VOLUME_MET : PLANISH_VOLUME_BELOW;
        inverted += !positive;
    }
    memcpy(coordinates + 2 * n, q, 2 * sizeof *q);
    memcpy(coordinates + 2 * n + 2, r, 2 * sizeof *r);
    const pl_objective_problem problem = {.mesh.dim = 2,
                                          .mesh.n_elements = n,
                                          .mesh.elements = elements,
                                          .mesh.mobility = is_free,
                                          .coordinates = coordinates,
                                          .min_volume = 1e-300, /* positive is enough */
                                          .threads = 1};
    pl_objective_sums sums;
    pl_sum_objective(&problem, &sums);
    assert_int_equal(pl_find_below(&problem, found), inverted);
    assert_memory_equal(found, wanted, sizeof found);
    assert_true(inverted > n / 8 && inverted < n - n / 8);
    assert_true(sums.inverted == inverted);
    assert_true(sums.n[0] == n - inverted && sums.n[1] == 0);
}

/** The examples of Kettner et al. (2008), where rounded determinants have wrong signs. */
static void nearly_flat_triangles_are_decided_exactly(void **state) {
    (void)state;
    static const double q[][2] = {{12, 12}, {17.300000000000001, 17.300000000000001}};
    static const double r[][2] = {{24, 24}, {24.00000000000005, 24.00000000000005}};
    for (int i = 0; i < 2; i++) {
        check_nearly_flat(q[i], r[i]);
        check_nearly_flat(r[i], q[i]);
    }
}

/** Triangles so thin that in their own scale the measure underflows, wholly or in part: it is known
 *  to its last digits all the same. */
static void underflow_takes_nothing_from_volumes(void **state) {
    (void)state;
    static const int32_t elements[] = {0, 1, 2};
    static const uint8_t is_free[3];
    static const double needles[][6] = {{0, 0, 0x1p700, 0, 0, 0x1p-500},
                                        {0, 0, 0x1.3333333333333p520, 0x1.999999999999ap521,
                                         0x1.999999999999ap-556, 0x1.6666666666666p-554}};
    for (int i = 0; i < 2; i++) {
        const double *x = needles[i];
        uint8_t state_of;
        const double area = (double)(((long double)x[2] * x[5] - (long double)x[3] * x[4]) / 2);
        pl_objective_problem problem = {.mesh.dim = 2,
                                        .mesh.n_elements = 1,
                                        .mesh.elements = elements,
                                        .mesh.mobility = is_free,
                                        .coordinates = x,
                                        .min_volume = area,
                                        .threads = 1};
        assert_int_equal(pl_find_below(&problem, &state_of), 0);
        problem.min_volume = 1.01 * area;
        assert_int_equal(pl_find_below(&problem, &state_of), 1);
    }
}

/** All in one plane, or on one point: nothing is valid, nothing is counted as it were. */
static void flat_elements_are_not_valid(void **state) {
    int dim = *(int *)*state;
    sample s;
    pl_objective_sums sums;
    create(&s, dim, 2, 0);
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < NODES * dim; i++)
            if (pass == 1 || i % dim == dim - 1)
                s.mesh.coordinates[i] = 0.75;
        pl_sum_objective(&s.problem, &sums);
        assert_true(sums.inverted == ELEMENTS && sums.below == ELEMENTS);
        assert_true(sums.n[0] == 0 && sums.n[1] == 0 && sums.radius_max == 0);
        assert_true(sums.ratio[0] == 0 && sums.ratio[1] == 0 && sums.domain == 0);
        assert_true(sums.shortfall == ELEMENTS);
    }
    test_mesh_destroy(&s.mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        BOTH(sums_match_brute_force),
        BOTH(reversed_elements_are_the_same),
        BOTH(sizes_change_no_bit),
        BOTH(threads_change_no_bit),
        BOTH(elements_below_are_found),
        cmocka_unit_test(nearly_flat_triangles_are_decided_exactly),
        cmocka_unit_test(underflow_takes_nothing_from_volumes),
        BOTH(flat_elements_are_not_valid),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
