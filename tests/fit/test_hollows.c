/* pl_fit_turn_hollows: cubes and octahedra in one another, whose edges and nodes lie in lines along the axes. */
#include "fit/hollows.h"
#include "fit/pieces.h"

#include "base/context.h"
#include "support/effort.h"
#include "support/run.h"
#include "support/sheets.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <cmocka.h>

/** A surface of shells; how many others each one lies in. */
typedef struct shells {
    int64_t n_nodes, n_facets;
    double (*x)[3];
    int32_t (*facet)[3];
    int n;
    int32_t *first; /* facet of each shell */
    int *depth;
    int *nest; /* the outermost shell around it, or in which others are; -1: there is none */
} shells;

enum { MOST_FACETS = 400000, MOST_SHELLS = 4000 };

static shells shells_create(void) {
    return (shells){.x = malloc(3 * MOST_FACETS * sizeof(double[3])),
                    .facet = malloc(MOST_FACETS * sizeof(int32_t[3])),
                    .first = malloc(MOST_SHELLS * sizeof(int32_t)),
                    .depth = malloc(MOST_SHELLS * sizeof(int)),
                    .nest = malloc(MOST_SHELLS * sizeof(int))};
}

static void shells_destroy(shells *s) {
    free(s->x);
    free(s->facet);
    free(s->first);
    free(s->depth);
    free(s->nest);
}

/** Return the node at a place of a grid on a shell; number: 0, or the node plus 1. */
static int32_t node_at(shells *s, int32_t *number, const int at[3], int n, int is_octahedron,
                       const double middle[3], double size) {
    int32_t *here = &number[(at[0] * (n + 1) + at[1]) * (n + 1) + at[2]];
    double p[3], sum = 0;
    if (*here > 0)
        return *here - 1;
    for (int d = 0; d < 3; d++)
        sum += fabs(p[d] = 2. * at[d] / n - 1);
    for (int d = 0; d < 3; d++)
        s->x[s->n_nodes][d] = middle[d] + size * p[d] / (is_octahedron ? sum : 1);
    *here = (int32_t)++s->n_nodes;
    return *here - 1;
}

/** Add a cube or octahedron of n by n squares on each of six sides, whose facets turn outwards or inwards. */
static void add_shell(shells *s, int n, int is_octahedron, const double middle[3], double size,
                      int is_turned, int depth, int nest) {
    static const int CORNER[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const size_t per_side = (size_t)n + 1;
    int32_t *number = calloc(per_side * per_side * per_side, sizeof *number);
    s->first[s->n] = (int32_t)s->n_facets;
    s->nest[s->n] = nest;
    if (nest >= 0)
        s->nest[nest] = nest;
    s->depth[s->n++] = depth;
    for (int i = 0; i < 6 * n * n; i++) {
        const int side = i / (n * n), axis = side / 2;
        int32_t v[4];
        for (int k = 0; k < 4; k++) {
            int at[3];
            at[axis] = side % 2 ? n : 0;
            at[(axis + 1) % 3] = i / n % n + CORNER[k][0];
            at[(axis + 2) % 3] = i % n + CORNER[k][1];
            v[k] = node_at(s, number, at, n, is_octahedron, middle, size);
        }
        const int flips = (side % 2 == 0) != is_turned;
        for (int k = 0; k < 2; k++) {
            int32_t *f = s->facet[s->n_facets++];
            f[0] = v[0];
            f[1] = v[1 + k + flips];
            f[2] = v[2 + k - flips];
        }
    }
    free(number);
}

/** Find the pieces of the shells and turn the hollows. Returns the seconds of both. */
static void find(const shells *s, int threads, planish_shape **shape, pl_fit_pieces *pieces,
                 double seconds[2]) {
    pl_tree tree;
    *shape = sheet_of(s->n_nodes, (const double(*)[3])s->x, s->n_facets,
                      (const int32_t(*)[3])s->facet, 0, NULL);
    pl_box3 *box = malloc((size_t)s->n_facets * sizeof *box);
    for (int64_t f = 0; f < s->n_facets; f++)
        for (int d = 0; d < 3; d++) {
            const int32_t *v = (*shape)->facet[f];
            const double a = (*shape)->x[v[0]][d], b = (*shape)->x[v[1]][d],
                         c = (*shape)->x[v[2]][d];
            box[f].lower[d] = fmin(a, fmin(b, c));
            box[f].upper[d] = fmax(a, fmax(b, c));
        }
    assert_int_equal(pl_tree_create(s->n_facets, box, 1, &tree, NULL), 0);
    free(box);
    const clock_t begin = clock();
    assert_int_equal(pl_fit_find_pieces(*shape, pieces, NULL), 0);
    const clock_t middle = clock();
    assert_int_equal(pl_fit_turn_hollows(*shape, &tree, threads, pieces, NULL), 0);
    seconds[0] = (double)(middle - begin) / CLOCKS_PER_SEC;
    seconds[1] = (double)(clock() - middle) / CLOCKS_PER_SEC;
    pl_tree_destroy(&tree);
}

/** Whether the pieces are the shells, with their nests, and those in an odd number of others are turned. */
static void expect_hollows(const shells *s, const pl_fit_pieces *pieces) {
    assert_int_equal(pieces->n, s->n);
    for (int i = 0; i < s->n; i++) {
        const int32_t piece = pieces->of[s->first[i]];
        assert_true(pieces->is_closed[piece]);
        assert_int_equal(pieces->turn[piece], pieces->outward[piece] * (s->depth[i] % 2 ? -1 : 1));
    }
}

/** Add up to four cubes in one another around a place of a grid, which is in a number of others. */
static void add_nest(shells *s, const double at[3], int depth, int nest, uint64_t *random) {
    const int first = s->n, n = (int)random_below(random, 5);
    for (int k = 0; k < n; k++)
        add_shell(s, 1 + (int)random_below(random, 3), 0, at, 0.5 - 0.125 * k,
                  (int)random_below(random, 2), depth + k, nest >= 0 || k == 0 ? nest : first);
}

/** Cubes around and in an octahedron, and in others beside it whose boxes are in its box. */
static void test_nests(void **state) {
    (void)state;
    for (int64_t i = 0; i < effort(6, 300); i++) {
        uint64_t random = effort_seed((uint64_t)i + 1);
        const double none[3] = {0, 0, 0}, size = 8;
        shells s = shells_create();
        planish_shape *shape;
        pl_fit_pieces pieces;
        double seconds[2];
        const int is_around = (int)random_below(&random, 2);
        if (is_around)
            add_shell(&s, 1, 0, none, size + 1, 0, 0, -1);
        add_shell(&s, 2 * (1 + (int)random_below(&random, 3)), 1, none, size,
                  (int)random_below(&random, 2), is_around, is_around - 1);
        for (int k = 0; k < 5 * 5 * 5; k++) {
            const double at[3] = {k % 5 * 2 - 4, k / 5 % 5 * 2 - 4, k / 25 * 2 - 4};
            const double off = fabs(at[0]) + fabs(at[1]) + fabs(at[2]) - size;
            if (fabs(off) > 1.5)
                add_nest(&s, at, is_around + (off < 0), is_around || off < 0 ? 0 : -1, &random);
        }
        find(&s, 1 + (int)(i % 2), &shape, &pieces, seconds);
        expect_hollows(&s, &pieces);
        pl_fit_free_pieces(&pieces);
        planish_shape_destroy(shape);
        shells_destroy(&s);
    }
}

/** Many pores in a piece of many facets take no longer than it takes to find the pieces, about. */
static void test_many(void **state) {
    (void)state;
    enum { PORES = 10 };
    const double none[3] = {0, 0, 0};
    shells s = shells_create();
    planish_shape *shape;
    pl_fit_pieces pieces;
    double seconds[2];
    add_shell(&s, 120, 1, none, 4 * PORES, 0, 0, -1);
    for (int k = 0; k < PORES * PORES * PORES; k++) {
        const double at[3] = {k % PORES - 4.5, k / PORES % PORES - 4.5, k / PORES / PORES - 4.5};
        add_shell(&s, 1, 0, at, 0.25, k % 2, 1, 0);
    }
    find(&s, 1, &shape, &pieces, seconds);
    figure("%d pores in %d facets: pieces in %.3g s, hollows in %.3g s", PORES * PORES * PORES,
           (int)s.n_facets, seconds[0], seconds[1]);
    expect_hollows(&s, &pieces);
    assert_true(seconds[1] < 10 * seconds[0] + 0.1);
    pl_fit_free_pieces(&pieces);
    planish_shape_destroy(shape);
    shells_destroy(&s);
}

static void *count_bytes(size_t bytes, void *user) {
    __atomic_fetch_add((int64_t *)user, (int64_t)bytes, __ATOMIC_RELAXED);
    return malloc(bytes);
}

static void give_back(void *block, void *user) {
    (void)user;
    free(block);
}

/** Bytes that a search for the hollows of shells asks for. */
static int64_t bytes_of(const shells *s, int threads) {
    int64_t bytes = 0;
    const planish_allocator allocator = {count_bytes, give_back, &bytes};
    planish_options options;
    planish_shape *shape;
    pl_fit_pieces pieces;
    double seconds[2];
    planish_options_init(&options);
    options.allocator = &allocator;
    pl_context *context = pl_context_create(&options);
    assert_non_null(context);
    pl_context *before = pl_context_enter(context);
    find(s, threads, &shape, &pieces, seconds);
    expect_hollows(s, &pieces);
    pl_fit_free_pieces(&pieces);
    planish_shape_destroy(shape);
    pl_context_enter(before);
    pl_context_destroy(context);
    return bytes;
}

/** Threads need no room for each piece. */
static void test_bytes(void **state) {
    (void)state;
    enum { PORES = 10, THREADS = 64, BYTES = 64 /* of a piece, for all threads */ };
    const double none[3] = {0, 0, 0};
    shells s = shells_create();
    add_shell(&s, 2, 1, none, 4 * PORES, 0, 0, -1);
    for (int k = 0; k < PORES * PORES * PORES; k++) {
        const double at[3] = {k % PORES - 4.5, k / PORES % PORES - 4.5, k / PORES / PORES - 4.5};
        add_shell(&s, 1, 0, at, 0.25, k % 2, 1, 0);
    }
    const int64_t one = bytes_of(&s, 1), many = bytes_of(&s, THREADS);
    assert_true(one > 0);
    assert_true(many - one < BYTES * PORES * PORES * PORES);
    shells_destroy(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_nests),
        cmocka_unit_test(test_many),
        cmocka_unit_test(test_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
