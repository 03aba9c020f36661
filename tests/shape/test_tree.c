/* tree and gaps: searches among boxes against brute force, and sheets that face one another. */
#include "shape/gaps.h"
#include "shape/nearest.h"
#include "shape/tree.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { MOST = 700 };

static double random_number(uint64_t *state) {
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (double)(*state >> 11) * 0x1p-53;
}

/** Boxes of all sizes; some are alike, some are points. */
static void make_boxes(int64_t n, uint64_t *state, pl_box3 *box) {
    for (int64_t i = 0; i < n; i++)
        for (int d = 0; d < 3; d++) {
            const double size = random_number(state);
            box[i].lower[d] = i % 7 == 3 && i > 0 ? box[i - 1].lower[d] : random_number(state);
            box[i].upper[d] = box[i].lower[d] + (i % 5 == 0 ? 0 : size * size * size * size);
        }
}

/** Items that a search has found. */
typedef struct finds {
    uint8_t found[MOST];
    int64_t n, most; /* and how many it shall find */
} finds;

static int note(void *context, int32_t item) {
    finds *f = context;
    assert_int_equal(f->found[item], 0);
    f->found[item] = 1;
    return ++f->n >= f->most;
}

static int meet(const pl_box3 *a, const pl_box3 *b) {
    for (int d = 0; d < 3; d++)
        if (a->upper[d] < b->lower[d] || b->upper[d] < a->lower[d])
            return 0;
    return 1;
}

static void test_boxes_that_meet(void **unused) {
    static const int64_t counts[] = {0, 1, 2, 4, 5, 17, 64, 65, MOST};
    uint64_t state = 1;
    (void)unused;
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
        static pl_box3 box[MOST];
        pl_tree tree;
        make_boxes(counts[c], &state, box);
        assert_int_equal(pl_tree_create(counts[c], box, 1 + (int)c % 3, &tree, NULL), 0);
        for (int k = 0; k < 50; k++) {
            finds f = {.most = MOST + 1};
            pl_box3 asked;
            make_boxes(1, &state, &asked);
            pl_tree_find(&tree, &asked, NULL, note, &f);
            for (int64_t i = 0; i < counts[c]; i++)
                assert_int_equal(f.found[i], meet(&box[i], &asked));
            finds first = {.most = 1};
            pl_tree_find(&tree, &asked, NULL, note, &first);
            assert_int_equal(first.n, f.n > 0);
        }
        pl_tree_destroy(&tree);
    }
}

/** Squared distance of the middle of a box. */
static double from_middle(const void *context, int32_t item, const double point[3]) {
    const pl_box3 *box = (const pl_box3 *)context + item;
    double square = 0;
    for (int d = 0; d < 3; d++) {
        const double off = (box->lower[d] + box->upper[d]) / 2 - point[d];
        square += off * off;
    }
    return square;
}

static void test_nearest_item(void **unused) {
    uint64_t state = 2;
    (void)unused;
    for (int64_t n = 0; n <= MOST; n = n * 2 + 1) {
        static pl_box3 box[MOST];
        pl_tree tree;
        make_boxes(n, &state, box);
        assert_int_equal(pl_tree_create(n, box, 1, &tree, NULL), 0);
        for (int k = 0; k < 50; k++) {
            const double point[3] = {random_number(&state) * 2 - 0.5, random_number(&state),
                                     random_number(&state)};
            const double most = k % 3 == 0 ? 0.01 : INFINITY;
            double square = most, least = most;
            int32_t best = -1;
            const int32_t found = pl_tree_nearest(&tree, point, from_middle, box, &square);
            for (int32_t i = 0; i < n; i++) {
                const double off = from_middle(box, i, point);
                if (off < least) {
                    least = off;
                    best = i;
                }
            }
            assert_int_equal(found, best);
            assert_true(square == least);
        }
        pl_tree_destroy(&tree);
    }
}

/* ---- nearest points ------------------------------------------------------------------------- */

/** Least distance of samples of two triangles. */
static double sampled(const double *const a[3], const double *const b[3]) {
    enum { PARTS = 24 };
    double least = INFINITY;
    for (int i = 0; i <= PARTS; i++)
        for (int j = 0; i + j <= PARTS; j++) {
            double p[3], weight[3];
            for (int d = 0; d < 3; d++)
                p[d] = (i * a[0][d] + j * a[1][d] + (PARTS - i - j) * a[2][d]) / PARTS;
            least = fmin(least, sqrt(pl_nearest_on_triangle(p, b, weight)));
        }
    return least;
}

static void test_nearest_of_triangles(void **unused) {
    uint64_t state = 3;
    (void)unused;
    for (int k = 0; k < 300; k++) {
        double x[6][3], way[3];
        for (int i = 0; i < 6; i++) /* on both sides of a plane: they do not cross */
            for (int d = 0; d < 3; d++)
                x[i][d] = (d == 2 && i >= 3 ? 1.05 : 0) + random_number(&state);
        const double *const a[3] = {x[0], x[1], x[2]}, *const b[3] = {x[3], x[4], x[5]};
        const double square = pl_nearest_triangles(a, b, way), other = sampled(a, b);
        assert_true(fabs(pl_dot(3, way, way) - square) <= 1e-12);
        assert_true(sqrt(square) <= other * (1 + 1e-12));
        assert_true(other - sqrt(square) < 0.06); /* samples are so near to one another */
    }
}

/* ---- gaps ----------------------------------------------------------------------------------- */

enum { SIDE = 6, PLATES = 2, NODES = (SIDE + 1) * (SIDE + 1), FACETS = 2 * SIDE * SIDE };

/** Two plane sheets over each other, of edges of about 1, as a shape by hand. */
typedef struct plates {
    planish_shape shape;
    double x[PLATES * NODES][3];
    float normal[PLATES * FACETS][3];
    int32_t facet[PLATES * FACETS][3];
    uint8_t is_interface[PLATES * FACETS];
} plates;

/** turned: which of the sheets look down. */
static void make_plates(plates *p, double apart, const int turned[PLATES]) {
    memset(p, 0, sizeof *p);
    for (int k = 0; k < PLATES; k++) {
        for (int i = 0; i < NODES; i++) {
            double *x = p->x[k * NODES + i];
            x[0] = i % (SIDE + 1);
            x[1] = i / (SIDE + 1);
            x[2] = k * apart;
        }
        for (int i = 0; i < SIDE * SIDE; i++) {
            const int32_t a = k * NODES + i % SIDE + i / SIDE * (SIDE + 1), c = a + SIDE + 2;
            int32_t(*f)[3] = p->facet + k * FACETS + 2 * i;
            memcpy(f[0], (int32_t[]){a, a + 1, c}, sizeof f[0]);
            memcpy(f[1], (int32_t[]){a, c, a + SIDE + 1}, sizeof f[1]);
        }
        for (int i = 0; i < FACETS; i++)
            p->normal[k * FACETS + i][2] = turned[k] ? -1 : 1;
    }
    p->shape = (planish_shape){.n_nodes = PLATES * NODES,
                               .n_facets = PLATES * FACETS,
                               .scale = 1,
                               .x = p->x,
                               .facet = p->facet,
                               .normal = p->normal,
                               .is_interface = p->is_interface};
}

/** The facets that are near; may_leave: NULL or [PLATES * FACETS]. */
static int64_t count_near_of(const plates *p, double tolerance, const uint8_t *may_leave,
                             int is_open) {
    static float each[PLATES * FACETS];
    static uint8_t is_near[PLATES * FACETS];
    int64_t n = 0;
    for (int i = 0; i < PLATES * FACETS; i++)
        each[i] = (float)tolerance;
    assert_int_equal(pl_shape_find_gaps(&p->shape, each, may_leave, is_open, 2, is_near, NULL), 0);
    for (int i = 0; i < PLATES * FACETS; i++)
        n += is_near[i];
    return n;
}

static int64_t count_near(const plates *p, double tolerance, int is_open) {
    return count_near_of(p, tolerance, NULL, is_open);
}

static void test_gaps(void **unused) {
    static plates p;
    (void)unused;
    make_plates(&p, 0.09, (int[]){0, 1}); /* a gap between two bodies */
    assert_int_equal(count_near(&p, 0.05, 0), PLATES * FACETS);
    assert_int_equal(count_near(&p, 0.044, 0), 0);
    p.is_interface[0] = 1; /* elements are on both sides of this one; others face its opposite */
    assert_int_equal(count_near(&p, 0.05, 0), PLATES * FACETS - 1);
    make_plates(&p, 0.09, (int[]){1, 0}); /* a thin plate: its elements keep both sides apart */
    assert_int_equal(count_near(&p, 0.05, 0), 0);
    assert_int_equal(count_near(&p, 0.05, 1), PLATES * FACETS); /* an open surface: nothing does */
    make_plates(&p, 0.09, (int[]){0, 0});
    assert_int_equal(count_near(&p, 0.05, 0), 0);
    make_plates(&p, 100, (int[]){0, 1}); /* neighbours in one sheet are no gap */
    assert_int_equal(count_near(&p, 3, 1), 0);
}

static void test_gaps_of_facets_that_stay(void **unused) {
    static plates p;
    static uint8_t may_leave[PLATES * FACETS];
    (void)unused;
    make_plates(&p, 0.09, (int[]){0, 1});
    assert_int_equal(count_near_of(&p, 0.05, may_leave, 0), 0);
    memset(may_leave, 1, FACETS); /* one sheet is enough, whichever it is */
    assert_int_equal(count_near_of(&p, 0.05, may_leave, 0), PLATES * FACETS);
    memset(may_leave, 0, FACETS);
    memset(may_leave + FACETS, 1, FACETS);
    assert_int_equal(count_near_of(&p, 0.05, may_leave, 0), PLATES * FACETS);
    memset(may_leave, 0, sizeof may_leave);
    may_leave[0] = 1;
    const int64_t n = count_near_of(&p, 0.05, may_leave, 0);
    assert_true(n > 1 && n < FACETS);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_boxes_that_meet),          cmocka_unit_test(test_nearest_item),
        cmocka_unit_test(test_nearest_of_triangles),     cmocka_unit_test(test_gaps),
        cmocka_unit_test(test_gaps_of_facets_that_stay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
