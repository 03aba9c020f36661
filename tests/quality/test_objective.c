/* F's sums and the minimum volumes of random meshes against brute force in long double; of simplices,
 * and of cells of every type by their corners. */
#include "geometry/corner.h"
#include "quality/certificate.h"
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

/* ---- cells by their corners ------------------------------------------------------------------ */

enum { CELLS = 700, MOST_CORNERS = CELLS * PL_CELL_CORNERS };

/** A mesh of cells, each with nodes of its own: ideal ones, pushed about, stretched and turned over. */
typedef struct cell_sample {
    double x[MOST_CORNERS * 3];
    int32_t elements[MOST_CORNERS * 4], cell_begin[CELLS + 1];
    uint8_t corner[MOST_CORNERS], mobility[MOST_CORNERS];
    int8_t sign[MOST_CORNERS];
    double own[MOST_CORNERS];
    int n_nodes, type[CELLS], first_node[CELLS];
    pl_objective_problem problem;
} cell_sample;

static const int CELL_TYPES[2][4] = {
    {PLANISH_CELL_TRIANGLE, PLANISH_CELL_QUADRILATERAL, PLANISH_CELL_QUADRILATERAL,
     PLANISH_CELL_TRIANGLE},
    {PLANISH_CELL_TETRAHEDRON, PLANISH_CELL_HEXAHEDRON, PLANISH_CELL_WEDGE, PLANISH_CELL_PYRAMID}};

/** The ideal corner of a type: column i is the edge to neighbour i. */
static void ideal_corner(int type, long double w[3][3]) {
    const long double h = sqrtl(3) / 2;
    memset(w, 0, 9 * sizeof w[0][0]);
    w[0][0] = w[1][1] = w[2][2] = 1;
    if (type == PLANISH_CELL_TRIANGLE || type == PLANISH_CELL_TETRAHEDRON ||
        type == PLANISH_CELL_WEDGE) {
        w[0][1] = 0.5L;
        w[1][1] = h;
    }
    if (type == PLANISH_CELL_TETRAHEDRON) {
        w[0][2] = 0.5L;
        w[1][2] = h / 3;
        w[2][2] = sqrtl(2.0L / 3);
    } else if (type == PLANISH_CELL_PYRAMID) {
        w[0][2] = w[1][2] = 0.5L;
        w[2][2] = sqrtl(0.5L);
    }
}

/** Place i of an ideal element of that type. */
static void ideal_place(int type, int i, double x[3]) {
    static const double CUBE[8][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1},
                                      {0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const double h = sqrt(3) / 2;
    const double triangle[3][2] = {{0, 0}, {1, 0}, {0.5, h}};
    const int is_wedge = type == PLANISH_CELL_WEDGE;
    x[2] = 0;
    if (type == PLANISH_CELL_TRIANGLE || is_wedge || type == PLANISH_CELL_TETRAHEDRON) {
        x[0] = i == 3 && !is_wedge ? 0.5 : triangle[i % 3][0];
        x[1] = i == 3 && !is_wedge ? h / 3 : triangle[i % 3][1];
        x[2] = i < 3 ? 0 : is_wedge ? 1 : sqrt(2.0 / 3);
        return;
    }
    x[0] = type == PLANISH_CELL_PYRAMID && i == 4 ? 0.5 : CUBE[i][0];
    x[1] = type == PLANISH_CELL_PYRAMID && i == 4 ? 0.5 : CUBE[i][1];
    x[2] = i < 4 ? 0 : type == PLANISH_CELL_PYRAMID ? sqrt(0.5) : 1;
}

static void place_cell(cell_sample *s, int cell, int dim, unsigned *random, int exponent) {
    const pl_cell_shape *shape = pl_cell_type_of(s->type[cell])->shape;
    const double noise = test_random(random) * test_random(random) * 1.5;
    const double mirror = test_random(random) < 0.3 ? -1 : 1;
    const double stretch = test_random(random) < 0.3 ? 40 * test_random(random) : 1;
    const int moves = test_random(random) < 0.6;
    s->first_node[cell] = s->n_nodes;
    for (int i = 0; i < shape->n_corners; i++, s->n_nodes++) {
        double x[3];
        ideal_place(s->type[cell], i, x);
        for (int d = 0; d < dim; d++)
            x[d] += noise * (2 * test_random(random) - 1);
        x[0] *= mirror;
        x[1] *= stretch;
        s->mobility[s->n_nodes] = moves && test_random(random) < 0.3;
        for (int d = 0; d < dim; d++)
            s->x[s->n_nodes * dim + d] = ldexp(x[d] + cell % 5, exponent);
    }
    const double own = test_random(random) < 0.5 ? 0 : ldexp(test_random(random), dim * exponent);
    const int first = s->cell_begin[cell];
    const int n = shape->n_simplices == 1 ? 1 : shape->n_measured;
    for (int c = 0; c < n; c++) {
        int32_t *node = s->elements + (int64_t)(first + c) * (dim + 1);
        node[0] = s->first_node[cell] + c;
        for (int j = 0; j < dim; j++)
            node[j + 1] = s->first_node[cell] + shape->neighbour[c][j];
        s->corner[first + c] = pl_corner_code(pl_kind_of_shape(shape), c);
        s->sign[first + c] = (int8_t)mirror;
        s->own[first + c] = own;
    }
    s->cell_begin[cell + 1] = first + n;
}

/** types: one of CELL_TYPES, or 4 for all of them. */
static void create_cells(cell_sample *s, int dim, int types, unsigned seed, int exponent) {
    unsigned random = seed * 2654435761u + 11;
    s->n_nodes = s->cell_begin[0] = 0;
    for (int i = 0; i < CELLS; i++) {
        s->type[i] = CELL_TYPES[dim - 2][types < 4 ? types : (int)(4 * test_random(&random)) % 4];
        place_cell(s, i, dim, &random, exponent);
    }
    s->problem = (pl_objective_problem){.mesh.dim = dim,
                                        .mesh.n_nodes = s->n_nodes,
                                        .mesh.n_elements = s->cell_begin[CELLS],
                                        .mesh.elements = s->elements,
                                        .mesh.corner = s->corner,
                                        .mesh.n_cells = CELLS,
                                        .mesh.cell_begin = s->cell_begin,
                                        .mesh.sign = s->sign,
                                        .mesh.mobility = s->mobility,
                                        .mesh.min_volume = s->own,
                                        .coordinates = s->x,
                                        .objective = (planish_objective)(seed % 3),
                                        .min_volume = ldexp(0.4, dim * exponent),
                                        .threads = 1};
}

static long double determinant_of(int dim, long double a[3][3]) {
    if (dim == 2)
        return a[0][0] * a[1][1] - a[0][1] * a[1][0];
    return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
           a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
           a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
}

/** Set x to the solution of x w = j, w upper triangular: T = J W^-1. */
static void divide_by(int dim, long double j[3][3], long double w[3][3], long double x[3][3]) {
    for (int row = 0; row < dim; row++)
        for (int k = 0; k < dim; k++) {
            x[row][k] = j[row][k];
            for (int m = 0; m < k; m++)
                x[row][k] -= x[row][m] * w[m][k];
            x[row][k] /= w[k][k];
        }
}

/** Measures of corner c of a cell by the textbook. */
typedef struct corner_reference {
    long double D, square, acuteness, edge2;
} corner_reference;

static long double distance2(const double *a, const double *b, int dim) {
    long double square = 0;
    for (int d = 0; d < dim; d++)
        square += ((long double)a[d] - b[d]) * ((long double)a[d] - b[d]);
    return square;
}

/** Square of the smoothed ratio of the edges between the nodes of a corner. */
static long double edges_of(const cell_sample *s, int cell, const int *node, int dim) {
    const pl_cell_shape *shape = pl_cell_type_of(s->type[cell])->shape;
    long double large = 0, small = 0;
    int n = 0;
    for (int e = 0; e < shape->n_edges; e++) {
        int ends = 0;
        for (int j = 0; j <= dim; j++)
            ends += node[j] == shape->edge[e][0] || node[j] == shape->edge[e][1];
        if (ends < 2)
            continue;
        const long double square =
            distance2(s->x + (s->first_node[cell] + shape->edge[e][0]) * dim,
                      s->x + (s->first_node[cell] + shape->edge[e][1]) * dim, dim);
        large += powl(square, 32);
        small += powl(square, -32);
        n++;
    }
    return powl(large / n * (small / n), 1.0L / 32);
}

static corner_reference measure_corner(const cell_sample *s, int cell, int c, int dim) {
    const pl_cell_shape *shape = pl_cell_type_of(s->type[cell])->shape;
    const double *x = s->x + s->first_node[cell] * dim;
    int node[4] = {c};
    long double j[3][3] = {{0}}, w[3][3], t[3][3] = {{0}}, norm = 0, lengths2 = 1;
    for (int i = 0; i < dim; i++) {
        node[i + 1] = shape->neighbour[c][i];
        for (int d = 0; d < dim; d++)
            j[d][i] = (long double)x[node[i + 1] * dim + d] - x[c * dim + d];
        lengths2 *= distance2(x + node[i + 1] * dim, x + c * dim, dim);
    }
    ideal_corner(s->type[cell], w);
    divide_by(dim, j, w, t);
    const long double sign = s->sign[s->cell_begin[cell]];
    const long double det = sign * determinant_of(dim, t), D = sign * determinant_of(dim, j);
    for (int a = 0; a < dim * dim; a++)
        norm += t[a / dim][a % dim] * t[a / dim][a % dim];
    const long double mu = norm / (dim * powl(fabsl(det), 2.0L / dim));
    return (corner_reference){D, mu * mu, lengths2 / (det * det), edges_of(s, cell, node, dim)};
}

typedef struct cell_reference {
    reference sums;
    long double corner_max, acuteness;
} cell_reference;

static void add_reference_cell(const cell_sample *s, int cell, cell_reference *all) {
    static const long double VOLUME[2][4] = {{0.5L, 1, 0, 0}, {1.0L / 6, 1, 0.5L, 1.0L / 3}};
    const pl_objective_problem *p = &s->problem;
    const int dim = p->mesh.dim, first = s->cell_begin[cell], n = s->cell_begin[cell + 1] - first;
    const pl_cell_shape *shape = pl_cell_type_of(s->type[cell])->shape;
    const double own = p->mesh.min_volume ? s->own[first] : 0,
                 least = own > 0 ? own : p->min_volume;
    long double square = 0, edge2 = 0, most = 0, acuteness = 0, g2 = 0, excess2 = 0;
    int n_positive = 0, is_below = 0, movable = 0;
    for (int i = 0; i < shape->n_corners; i++)
        movable |= s->mobility[s->first_node[cell] + i];
    for (int c = 0; c < n; c++) {
        const corner_reference of = measure_corner(s, cell, c, dim);
        const long double volume = of.D * VOLUME[dim - 2][pl_kind_of_shape(shape)];
        const long double g = least > 0 ? 1 - volume / least : 0;
        n_positive += of.D > 0;
        is_below |= g > PLANISH_VOLUME_TOLERANCE;
        g2 += g * g / n;
        excess2 += g > 0 ? g * g / n : 0;
        square += of.square / n;
        edge2 += of.edge2 / n;
        most = fmaxl(of.square, most);
        acuteness = fmaxl(of.acuteness, acuteness);
        all->sums.domain += volume / n;
    }
    for (int c = n; n == 1 && c < shape->n_measured; c++) /* simplices: the other vertices */
        acuteness = fmaxl(measure_corner(s, cell, c, dim).acuteness, acuteness);
    all->sums.below += is_below;
    all->sums.shortfall += excess2;
    if (n_positive < n) {
        all->sums.inverted++;
        return;
    }
    all->sums.n[movable]++;
    all->sums.radius[movable] += square;
    all->sums.ratio[movable] += p->objective == PLANISH_OBJECTIVE_EDGE_RATIO ? edge2 : square;
    all->sums.volume[movable] += g2;
    if (!movable)
        return;
    all->sums.radius_max = fmaxl(square, all->sums.radius_max);
    all->corner_max = fmaxl(most, all->corner_max);
    all->acuteness = fmaxl(acuteness, all->acuteness);
}

/** Check the sums; at_least: cells of each sort that there are. */
static void check_cell_sums(const cell_sample *s, int at_least) {
    cell_reference wanted = {.sums = {.domain = 0}};
    pl_objective_sums found;
    for (int i = 0; i < CELLS; i++)
        add_reference_cell(s, i, &wanted);
    pl_sum_objective(&s->problem, &found);
    for (int movable = 0; movable < 2; movable++) {
        close_to(found.ratio[movable], wanted.sums.ratio[movable]);
        close_to(found.radius[movable], wanted.sums.radius[movable]);
        close_to(found.volume[movable], wanted.sums.volume[movable]);
        assert_true(found.n[movable] == wanted.sums.n[movable] && found.n[movable] >= at_least);
    }
    close_to(found.radius_max, wanted.sums.radius_max);
    close_to(found.corner_max, wanted.corner_max);
    close_to(found.acuteness, wanted.acuteness);
    close_to(found.shortfall, wanted.sums.shortfall);
    close_to(found.domain, wanted.sums.domain);
    assert_true(found.inverted == wanted.sums.inverted && found.inverted >= at_least);
    assert_true(found.below == wanted.sums.below);
}

static void sums_of_cells_match_brute_force(void **state) {
    const int dim = *(int *)*state;
    static cell_sample s;
    for (unsigned seed = 0; seed < 3; seed++)
        for (int types = 0; types < 5; types++) {
            create_cells(&s, dim, types, seed, 0);
            check_cell_sums(&s, 20);
            s.problem.mesh.min_volume = NULL;
            check_cell_sums(&s, 20);
            s.problem.min_volume = 0;
            check_cell_sums(&s, 20);
        }
}

static void sizes_of_cells_change_no_bit(void **state) {
    const int dim = *(int *)*state;
    static const int exponents[] = {-300, -150, -1, 13, 200, 300};
    static cell_sample s;
    for (unsigned seed = 0; seed < 3; seed++) {
        pl_objective_sums plain;
        create_cells(&s, dim, 4, seed, 0);
        pl_sum_objective(&s.problem, &plain);
        for (size_t i = 0; i < sizeof exponents / sizeof *exponents; i++) {
            pl_objective_sums sums;
            create_cells(&s, dim, 4, seed, exponents[i]);
            pl_sum_objective(&s.problem, &sums);
            assert_true(sums.domain == ldexp(plain.domain, dim * exponents[i]));
            sums.domain = plain.domain;
            assert_memory_equal(&sums, &plain, sizeof sums);
        }
    }
}

static void threads_change_no_bit_of_cells(void **state) {
    const int dim = *(int *)*state;
    static cell_sample s;
    pl_objective_sums a, b;
    create_cells(&s, dim, 4, 5, 0);
    pl_sum_objective(&s.problem, &a);
    for (int threads = 2; threads < 6; threads++) {
        s.problem.threads = threads;
        pl_sum_objective(&s.problem, &b);
        assert_memory_equal(&a, &b, sizeof a);
    }
}

/** Corners are below by volumes of cells, and as many cells have one as the sums say. */
static void corners_below_are_found(void **state) {
    const int dim = *(int *)*state;
    static cell_sample s;
    static uint8_t found[MOST_CORNERS];
    for (int exponent = -300; exponent <= 300; exponent += 150) {
        pl_objective_sums sums;
        double n = 0, n_inverted = 0;
        create_cells(&s, dim, 4, 7, exponent);
        pl_sum_objective(&s.problem, &sums);
        pl_find_below(&s.problem, found);
        for (int i = 0; i < CELLS; i++) {
            int any = 0;
            for (int k = s.cell_begin[i]; k < s.cell_begin[i + 1]; k++)
                any |= found[k] == PLANISH_VOLUME_BELOW;
            n += any;
        }
        assert_true(n == sums.below && n > 20);
        s.problem.min_volume = 0;
        s.problem.mesh.min_volume = NULL;
        pl_find_inverted(&s.problem, found);
        for (int i = 0; i < CELLS; i++) {
            int any = 0;
            for (int k = s.cell_begin[i]; k < s.cell_begin[i + 1]; k++)
                any |= found[k] == PLANISH_VOLUME_BELOW;
            n_inverted += any;
        }
        assert_true(n_inverted == sums.inverted && n_inverted > 20);
    }
}

/** Coordinates on a lattice, so that many corners are flat: signs are exact. */
static void flat_corners_are_decided_exactly(void **state) {
    const int dim = *(int *)*state;
    static cell_sample s;
    int n_flat = 0;
    for (unsigned seed = 0; seed < 4; seed++) {
        pl_objective_sums sums;
        double inverted = 0;
        create_cells(&s, dim, 4, seed, 0);
        for (int i = 0; i < s.n_nodes * dim; i++)
            s.x[i] = rint(2 * s.x[i]) / 10 + 0x1p-53 * (i % 3); /* tenths are rounded */
        for (int i = 0; i < CELLS; i++) {
            int any = 0;
            for (int k = s.cell_begin[i]; k < s.cell_begin[i + 1]; k++) {
                const double *vertex[4];
                for (int j = 0; j <= dim; j++)
                    vertex[j] = s.x + s.elements[k * (dim + 1) + j] * dim;
                const int sign = pl_measure_sign(dim, vertex) * s.sign[k];
                long double D = measure_corner(&s, i, k - s.cell_begin[i], dim).D;
                n_flat += fabsl(D) < 1e-14L;
                any |= sign <= 0;
            }
            inverted += any;
        }
        pl_sum_objective(&s.problem, &sums);
        assert_true(sums.inverted == inverted);
    }
    assert_true(n_flat > 50);
}

/** No corner with a mu^2 up to pl_blunt_mean_square is sharper than that says, and some come near. */
static void blunt_corners_are_not_sharp(void **state) {
    const int dim = *(int *)*state;
    static cell_sample s;
    for (int types = 0; types < 4; types++) {
        long double nearest = 0;
        for (unsigned seed = 0; seed < 3; seed++) {
            create_cells(&s, dim, types, seed, 0);
            for (int i = 0; i < CELLS; i++) {
                const pl_cell_shape *shape = pl_cell_type_of(s.type[i])->shape;
                const unsigned kinds = 1U << pl_kind_of_shape(shape);
                for (int c = 0; c < shape->n_measured; c++) {
                    const corner_reference of = measure_corner(&s, i, c, dim);
                    const double blunt = pl_blunt_mean_square(dim, kinds, (double)of.acuteness);
                    assert_true(blunt < of.square);
                    nearest = fmaxl(nearest, blunt / of.square);
                }
            }
        }
        assert_true(nearest > 0.97L);
    }
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
        BOTH(sums_of_cells_match_brute_force),
        BOTH(sizes_of_cells_change_no_bit),
        BOTH(threads_change_no_bit_of_cells),
        BOTH(corners_below_are_found),
        BOTH(flat_corners_are_decided_exactly),
        BOTH(blunt_corners_are_not_sharp),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
