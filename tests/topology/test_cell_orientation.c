/* Tests of src/topology/cell_orientation.c: grids of mixed types whose elements are turned over at
 * random. */
#include "topology/cells.h"

#include "support/effort.h"

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

static const double PI = 3.14159265358979323846;

enum { SIDE = 4, NODES = (SIDE + 1) * (SIDE + 1) * (SIDE + 1), MOST = 2 * SIDE * SIDE * SIDE };

/** A mesh, and whether each element is turned over. */
typedef struct turned_mesh {
    planish_cells cells;
    int dim;
    uint8_t type[MOST];
    int64_t offset[MOST + 1];
    int32_t node[8 * MOST];
    int8_t turned[MOST]; /* -1: it is, else 1 */
    double coordinates[NODES * 3];
} turned_mesh;

/** Add an element of n nodes; turned over: its two halves, or the order around, change places. */
static void add(turned_mesh *m, int type, int n, const int32_t node[], int turn) {
    const int64_t i = m->cells.n++;
    int32_t *to = m->node + m->offset[i];
    m->type[i] = (uint8_t)type;
    m->turned[i] = turn ? -1 : 1;
    for (int k = 0; k < n; k++)
        to[k] = node[!turn ? k : m->dim == 3 ? (k + n / 2) % n : n - 1 - k];
    m->offset[i + 1] = m->offset[i] + n;
}

static int32_t number(int x, int y, int z) {
    return x + (SIDE + 1) * (y + (SIDE + 1) * z);
}

/** A grid of squares and triangles, or of hexahedra and wedges, each turned over with a chance of
 *  share; its places are moved by at most push. */
static void make(turned_mesh *m, int dim, double share, double push, uint64_t *random) {
    memset(m, 0, sizeof *m);
    m->dim = dim;
    m->cells = (planish_cells){.type = m->type, .offset = m->offset, .node = m->node};
    for (int z = 0; z < (dim == 3 ? SIDE : 1); z++)
        for (int y = 0; y < SIDE; y++)
            for (int x = 0; x < SIDE; x++) {
                int32_t at[8];
                for (int k = 0; k < 8; k++)
                    at[k] = number(x + (k % 4 == 1 || k % 4 == 2), y + k % 4 / 2, z + k / 4);
                const int turn = random_unit(random) < share, split = (x + y) % 3 == 0;
                if (!split) {
                    add(m, dim == 3 ? PLANISH_CELL_HEXAHEDRON : PLANISH_CELL_QUADRILATERAL,
                        dim == 3 ? 8 : 4, at, turn);
                    continue;
                }
                const int32_t first[6] = {at[0], at[1], at[2], at[4], at[5], at[6]};
                const int32_t second[6] = {at[0], at[2], at[3], at[4], at[6], at[7]};
                const int type = dim == 3 ? PLANISH_CELL_WEDGE : PLANISH_CELL_TRIANGLE;
                add(m, type, dim == 3 ? 6 : 3, first, turn);
                add(m, type, dim == 3 ? 6 : 3, second, random_unit(random) < share);
            }
    for (int z = 0; z <= SIDE; z++)
        for (int y = 0; y <= SIDE; y++)
            for (int x = 0; x <= SIDE; x++) {
                const double place[3] = {x, y, z};
                for (int d = 0; d < dim; d++)
                    if (dim == 3 || z == 0)
                        m->coordinates[number(x, y, z) * dim + d] =
                            place[d] + push * (2 * random_unit(random) - 1);
            }
}

static void signs_are_those_of_turned_elements(void **state) {
    (void)state;
    static turned_mesh m;
    int8_t sign[MOST];
    uint64_t random = effort_seed(1);
    const int64_t n = effort(200, 20000);
    for (int64_t repeat = 0; repeat < n; repeat++) {
        make(&m, repeat % 2 ? 3 : 2, random_unit(&random), 0.2, &random);
        assert_int_equal(pl_orient_cells(&m.cells, m.dim, NODES, m.coordinates,
                                         1 + (int)(repeat % 3), sign, NULL),
                         PLANISH_OK);
        assert_memory_equal(sign, m.turned, (size_t)m.cells.n);
    }
}

/* Whatever a few nodes do, neighbours say which handedness an element has. */
static void inverted_elements_do_not_change_signs(void **state) {
    (void)state;
    static turned_mesh m;
    int8_t sign[MOST];
    uint64_t random = effort_seed(2);
    for (int repeat = 0; repeat < 100; repeat++) {
        make(&m, repeat % 2 ? 3 : 2, 0.5, 0.1, &random);
        const int32_t middle = number(SIDE / 2, SIDE / 2, m.dim == 3 ? SIDE / 2 : 0);
        m.coordinates[middle * m.dim] += 1.8;
        assert_int_equal(pl_orient_cells(&m.cells, m.dim, NODES, m.coordinates,
                                         1 + (int)(repeat % 3), sign, NULL),
                         PLANISH_OK);
        assert_memory_equal(sign, m.turned, (size_t)m.cells.n);
    }
}

static void elements_that_nothing_joins_have_the_sign_of_their_type(void **state) {
    (void)state;
    static const uint8_t type[] = {PLANISH_CELL_LINE, PLANISH_CELL_QUADRILATERAL,
                                   PLANISH_CELL_QUADRILATERAL, PLANISH_CELL_QUADRILATERAL,
                                   PLANISH_CELL_TRIANGLE};
    static const int64_t offset[] = {0, 2, 6, 10, 14, 17};
    static const int32_t node[] = {0, 1, 0, 3, 2, 1, 4, 7, 6, 5, 0, 0, 0, 0, 0, 5, 2};
    static const double coordinates[] = {0, 0, 1, 0, 1, 1, 0, 1, 2, 0, 3, 0, 3, 1, 2, 1};
    const planish_cells cells = {.n = 5, .type = type, .offset = offset, .node = node};
    int8_t sign[5];
    assert_int_equal(pl_orient_cells(&cells, 2, 8, coordinates, 1, sign, NULL), PLANISH_OK);
    for (int i = 1; i < 4; i++)
        assert_int_equal(sign[i], -1);
    assert_int_equal(sign[4], 1);
}

/* Wedges around an axis: all of their facets but the outer ones have its lower node. */
static void many_elements_may_be_around_a_node(void **state) {
    (void)state;
    enum { N = 100, RING = 2 + 2 * N };
    static uint8_t type[N];
    static int64_t offset[N + 1];
    static int32_t node[6 * N];
    static double coordinates[RING * 3];
    int8_t turned[N], sign[N];
    uint64_t random = effort_seed(3);
    for (int i = 0; i < RING; i++) { /* the axis, then pairs around it */
        coordinates[i * 3] = i < 2 ? 0 : cos(2 * PI * (i / 2) / N);
        coordinates[i * 3 + 1] = i < 2 ? 0 : sin(2 * PI * (i / 2) / N);
        coordinates[i * 3 + 2] = i % 2;
    }
    for (int i = 0; i < N; i++) {
        const int32_t a = 2 + 2 * i, b = 2 + 2 * ((i + 1) % N), at[] = {0, a, b, 1, a + 1, b + 1};
        const int turn = random_unit(&random) < 0.4;
        type[i] = PLANISH_CELL_WEDGE;
        offset[i + 1] = offset[i] + 6;
        turned[i] = turn ? -1 : 1;
        for (int k = 0; k < 6; k++)
            node[6 * i + k] = at[turn ? (k + 3) % 6 : k];
    }
    coordinates[2 * 3] = -0.5; /* two elements are inverted, and turned[] is what it was */
    const planish_cells cells = {.n = N, .type = type, .offset = offset, .node = node};
    for (int threads = 1; threads <= 3; threads++) {
        assert_int_equal(pl_orient_cells(&cells, 3, RING, coordinates, threads, sign, NULL), 0);
        assert_memory_equal(sign, turned, N);
    }
}

/* A Moebius strip has no orientation: some is found, the same for any number of threads. */
static void strips_without_orientation_are_taken(void **state) {
    (void)state;
    enum { N = 50 };
    static uint8_t type[N];
    static int64_t offset[N + 1];
    static int32_t node[4 * N];
    static double coordinates[4 * N];
    int8_t first[N], sign[N];
    for (int i = 0; i < N; i++) {
        const int next = (i + 1) % N, is_last = i + 1 == N;
        const int32_t at[] = {2 * i, 2 * next + is_last, 2 * next + !is_last, 2 * i + 1};
        type[i] = PLANISH_CELL_QUADRILATERAL;
        offset[i + 1] = offset[i] + 4;
        memcpy(node + 4 * i, at, sizeof at);
        coordinates[4 * i] = coordinates[4 * i + 2] = i;
        coordinates[4 * i + 3] = 1;
    }
    const planish_cells cells = {.n = N, .type = type, .offset = offset, .node = node};
    for (int threads = 1; threads <= 3; threads++) {
        assert_int_equal(pl_orient_cells(&cells, 2, 2 * N, coordinates, threads, sign, NULL), 0);
        if (threads == 1)
            memcpy(first, sign, sizeof first);
        assert_memory_equal(sign, first, N);
    }
    for (int i = 0; i < N - 1; i++)
        assert_int_equal(sign[i], 1);
}

/** Add element i of a mesh again: in its order (way 0), from another corner on (1), or mirrored (2). */
static void add_again(turned_mesh *m, int64_t i, int way) {
    const int n = (int)(m->offset[i + 1] - m->offset[i]);
    int32_t node[8];
    for (int k = 0; k < n; k++) {
        const int layer = m->dim == 3 ? n / 2 : n;
        const int around = (k + (way == 1)) % layer + k / layer * layer;
        const int mirrored = m->dim == 3 ? (k + n / 2) % n : n - 1 - k;
        node[k] = m->node[m->offset[i] + (way == 2 ? mirrored : around)];
    }
    add(m, m->type[i], n, node, 0);
}

/* An element that is there twice, in whatever order, is counted once, and its corners are held: also where
 * nothing else holds them, as the corner of a box. */
static void duplicates_hold_their_corners(void **state) {
    (void)state;
    static turned_mesh m;
    uint64_t random = effort_seed(4);
    for (int repeat = 0; repeat < 120; repeat++) {
        make(&m, repeat % 2 ? 3 : 2, 0.3, 0.1, &random);
        const int64_t n = m.cells.n,
                      i = repeat % 5 == 0 ? n - 1 : (int64_t)(random_unit(&random) * (double)n);
        add_again(&m, i, repeat % 3);
        pl_cell_census census;
        assert_int_equal(pl_cell_census_find(&m.cells, m.dim, NODES, m.coordinates, 1 + repeat % 3,
                                             &census, NULL),
                         PLANISH_OK);
        assert_int_equal(census.n_duplicate_elements, 1);
        for (int64_t k = 0; k <= n; k++)
            assert_int_equal(census.is_duplicate[k], k == n);
        assert_memory_equal(census.sign, m.turned, (size_t)n);
        for (int64_t k = m.offset[i]; k < m.offset[i + 1]; k++)
            assert_int_equal(census.on_boundary[m.node[k]], 1);
        pl_cell_census_destroy(&census);
    }
}

/* Hexahedra whose bottom is their top, and many duplicates around a node. */
static void flat_elements_and_hubs_of_duplicates_are_counted(void **state) {
    (void)state;
    enum { N = 200 };
    static uint8_t type[N];
    static int64_t offset[N + 1];
    static int32_t node[8 * N];
    static const double coordinates[3 * 10] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0,
                                               0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
    for (int i = 0; i < N; i++) {
        type[i] = PLANISH_CELL_HEXAHEDRON;
        offset[i + 1] = offset[i] + 8;
        for (int k = 0; k < 8; k++)
            node[8 * i + k] = k;
    }
    for (int k = 0; k < 8; k++)
        node[k] = k % 4;
    for (int n = 1; n <= N; n += N - 1) {
        const planish_cells cells = {.n = n, .type = type, .offset = offset, .node = node};
        pl_cell_census census;
        assert_int_equal(pl_cell_census_find(&cells, 3, 10, coordinates, 2, &census, NULL),
                         PLANISH_OK);
        assert_int_equal(census.n_duplicate_elements, n == 1 ? 1 : N - 1);
        for (int k = 0; k < 8; k++)
            assert_int_equal(census.on_boundary[k], n > 1 || k < 4);
        pl_cell_census_destroy(&census);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(signs_are_those_of_turned_elements),
        cmocka_unit_test(inverted_elements_do_not_change_signs),
        cmocka_unit_test(elements_that_nothing_joins_have_the_sign_of_their_type),
        cmocka_unit_test(many_elements_may_be_around_a_node),
        cmocka_unit_test(strips_without_orientation_are_taken),
        cmocka_unit_test(duplicates_hold_their_corners),
        cmocka_unit_test(flat_elements_and_hubs_of_duplicates_are_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
