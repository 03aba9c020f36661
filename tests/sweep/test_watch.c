/* Tests of elements of order 2 in planish_smooth: mids follow their ends, and curved elements stay
 * valid. Boxes get mids, some of them off the middle of their edges, inside and on the boundary. */
#include "support/both.h"
#include "support/cell_meshes.h"
#include "support/faults.h"
#include "support/meshes.h"
#include "geometry/simplex.h"
#include "quality/certificate.h"
#include "sweep/watch.h"
#include "sweep/rows.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { SEEDS = 6 };

/** A box of elements of order 2. */
typedef struct curved_box {
    test_mesh box; /* its corners */
    planish_cells cells;
    planish_mesh mesh;
    double *x; /* [n_nodes][dim] corners, then mids */
    uint8_t *type;
    int64_t *offset;
    int32_t *node;
    int32_t (*end)[2]; /* [n_nodes] of mids; -1 of corners */
} curved_box;

static const int EDGE[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};

/** Return the mid of an edge, which is made if there is none. */
static int32_t mid_of(curved_box *b, int32_t p, int32_t q) {
    const int32_t low = p < q ? p : q, high = p < q ? q : p;
    for (int64_t i = b->box.mesh.n_nodes; i < b->mesh.n_nodes; i++)
        if (b->end[i][0] == low && b->end[i][1] == high)
            return (int32_t)i;
    const int64_t i = b->mesh.n_nodes++;
    const int dim = b->mesh.dim;
    b->end[i][0] = low;
    b->end[i][1] = high;
    for (int d = 0; d < dim; d++)
        b->x[i * dim + d] = 0.5 * (b->x[(int64_t)p * dim + d] + b->x[(int64_t)q * dim + d]);
    return (int32_t)i;
}

/** Give the box, which b owns from now on, mids. */
static void add_mids(curved_box *b) {
    const planish_mesh *box = &b->box.mesh;
    const int dim = box->dim, corners = dim + 1, edges = dim == 3 ? 6 : 3, n = corners + edges;
    const int64_t m = box->n_elements, most = box->n_nodes + m * edges;
    b->mesh = (planish_mesh){.dim = dim, .n_nodes = box->n_nodes, .n_elements = m};
    b->x = malloc((size_t)(most * dim) * sizeof *b->x);
    b->end = malloc((size_t)most * sizeof *b->end);
    b->type = malloc((size_t)m);
    b->offset = malloc((size_t)(m + 1) * sizeof *b->offset);
    b->node = malloc((size_t)(m * n) * sizeof *b->node);
    memset(b->end, -1, (size_t)most * sizeof *b->end);
    memcpy(b->x, box->coordinates, (size_t)(box->n_nodes * dim) * sizeof *b->x);
    for (int64_t e = 0; e < m; e++) {
        const int32_t *corner = box->elements + e * corners;
        b->type[e] = dim == 3 ? PLANISH_CELL_TETRAHEDRON10 : PLANISH_CELL_TRIANGLE6;
        b->offset[e] = e * n;
        for (int i = 0; i < corners; i++)
            b->node[e * n + i] = corner[i];
        for (int i = 0; i < edges; i++)
            b->node[e * n + corners + i] = mid_of(b, corner[EDGE[i][0]], corner[EDGE[i][1]]);
    }
    b->offset[m] = m * n;
    b->cells = (planish_cells){.n = m, .type = b->type, .offset = b->offset, .node = b->node};
    b->mesh.cells = &b->cells;
    b->mesh.coordinates = b->x;
}

static void destroy(curved_box *b) {
    test_mesh_destroy(&b->box);
    free(b->x);
    free(b->end);
    free(b->type);
    free(b->offset);
    free(b->node);
}

/** Make a perturbed box in which one mid in so many is up to bend off its middle, in each direction.
 */
static void make_box(curved_box *b, int dim, unsigned one_in, double bend, unsigned seed) {
    test_bad_box(&b->box, dim, dim == 3 ? 4 : 8, seed);
    add_mids(b);
    for (int64_t i = b->box.mesh.n_nodes; i < b->mesh.n_nodes; i++)
        for (int d = 0; one_in && test_random(&seed) * one_in < 1 && d < dim; d++)
            b->x[i * dim + d] += bend * (2 * test_random(&seed) - 1);
}

/** Whether each element is valid at x. */
static void judge(const curved_box *b, const double *x, uint8_t *is_valid) {
    planish_mesh mesh = b->mesh;
    planish_cell_quality quality;
    const planish_cell_values values = {.state = is_valid};
    planish_error error;
    mesh.coordinates = x;
    if (planish_measure_cells(&mesh, 0, 1, &quality, &values, &error))
        fail_msg("%s", error.text);
    assert_int_equal(quality.all.n_uncertified, 0);
    for (int64_t e = 0; e < mesh.n_elements; e++)
        is_valid[e] = is_valid[e] == PLANISH_CELL_STATE_VALID;
}

/** Return how many elements are valid at x and not at y. */
static int64_t count_broken(const curved_box *b, const double *x, const double *y) {
    uint8_t *before = malloc((size_t)b->mesh.n_elements),
            *after = malloc((size_t)b->mesh.n_elements);
    int64_t n = 0;
    judge(b, x, before);
    judge(b, y, after);
    for (int64_t e = 0; e < b->mesh.n_elements; e++)
        n += before[e] && !after[e];
    free(before);
    free(after);
    return n;
}

/** Smooth a copy of the box's coordinates, which the caller frees. */
static double *smooth(const curved_box *b, const planish_options *options, planish_result *result) {
    const size_t size = (size_t)(b->mesh.n_nodes * b->mesh.dim) * sizeof(double);
    double *x = malloc(size);
    planish_plan *plan = NULL;
    planish_error error;
    memcpy(x, b->x, size);
    if (planish_plan_create(&b->mesh, options, &plan, &error) ||
        planish_smooth(plan, x, options, result, &error))
        fail_msg("%s", error.text);
    planish_plan_destroy(plan);
    return x;
}

/** Put each mid where it follows its ends from the box's coordinates to x. */
static void follow(const curved_box *b, double *x) {
    const int dim = b->mesh.dim;
    for (int64_t i = b->box.mesh.n_nodes; i < b->mesh.n_nodes; i++)
        for (int d = 0; d < dim; d++) {
            double way = 0;
            for (int k = 0; k < 2; k++) {
                const int64_t end = (int64_t)b->end[i][k] * dim + d;
                way += 0.5 * (x[end] - b->x[end]);
            }
            x[i * dim + d] = b->x[i * dim + d] + way;
        }
}

static planish_options usual(void) {
    planish_options o;
    planish_options_init(&o);
    o.threads = 1;
    return o;
}

static void straight_elements_move_as_those_of_order_1(void **state) {
    const int dim = **(int **)state;
    const planish_options o = usual();
    for (unsigned seed = 1; seed <= SEEDS; seed++) {
        curved_box b;
        planish_result result, linear;
        planish_plan *plan = NULL;
        make_box(&b, dim, 0, 0, seed);
        double *x = smooth(&b, &o, &result);
        const size_t corners = (size_t)(b.box.mesh.n_nodes * dim) * sizeof *x;
        double *y = malloc((size_t)(b.mesh.n_nodes * dim) * sizeof *y);
        memcpy(y, b.x, corners);
        assert_int_equal(planish_plan_create(&b.box.mesh, &o, &plan, NULL), PLANISH_OK);
        assert_int_equal(planish_smooth(plan, y, &o, &linear, NULL), PLANISH_OK);
        assert_memory_equal(x, y, corners);
        assert_true(linear.n_moved_nodes > 0 && result.n_moved_nodes > linear.n_moved_nodes);
        assert_true(result.rms == linear.rms && result.sweeps == linear.sweeps);
        assert_int_equal(result.n_curved, 0);
        assert_int_equal(result.n_refused, 0);
        follow(&b, y);
        for (int64_t i = 0; i < b.mesh.n_nodes * dim; i++)
            assert_true(fabs(x[i] - y[i]) < 1e-13);
        assert_int_equal(count_broken(&b, b.x, x), 0);
        planish_plan_destroy(plan);
        free(x);
        free(y);
        destroy(&b);
    }
}

/** Corners alone would invert curved elements of these boxes. */
static void curved_elements_stay_valid(void **state) {
    const int dim = **(int **)state;
    planish_options o = usual();
    o.curve_quality = 0; /* mids follow */
    int64_t n_broken = 0, n_refused = 0;
    for (unsigned seed = 1; seed <= SEEDS; seed++) {
        curved_box b;
        planish_result result, linear;
        planish_plan *plan = NULL;
        make_box(&b, dim, 4, 0.2, seed);
        double *x = smooth(&b, &o, &result);
        double *y = malloc((size_t)(b.mesh.n_nodes * dim) * sizeof *y);
        memcpy(y, b.x, (size_t)(b.mesh.n_nodes * dim) * sizeof *y);
        assert_int_equal(planish_plan_create(&b.box.mesh, &o, &plan, NULL), PLANISH_OK);
        assert_int_equal(planish_smooth(plan, y, &o, &linear, NULL), PLANISH_OK);
        follow(&b, y);
        n_broken += count_broken(&b, b.x, y);
        n_refused += result.n_refused;
        assert_int_equal(count_broken(&b, b.x, x), 0);
        assert_true(result.n_curved > b.mesh.n_elements / 4);
        assert_true(result.n_moved_nodes > 0 && result.objective < result.objective_before);
        memcpy(y, x, (size_t)(b.mesh.n_nodes * dim) * sizeof *y);
        follow(&b, y);
        for (int64_t i = 0; i < b.mesh.n_nodes * dim; i++)
            assert_true(fabs(x[i] - y[i]) < 1e-13);
        planish_plan_destroy(plan);
        free(x);
        free(y);
        destroy(&b);
    }
    assert_true(n_broken > 0);
    assert_true(n_refused > 0);
}

static double same(double value, void *user) {
    (void)user;
    return value;
}

/** Bounds save certificates and change nothing: with a rounding of the caller's every move is
 *  decided. */
static void bits_are_the_same_however_they_are_found(void **state) {
    const int dim = **(int **)state;
    for (unsigned seed = 1; seed <= SEEDS; seed++) {
        curved_box b;
        planish_result result, other;
        planish_options o = usual();
        make_box(&b, dim, 5, 0.2, seed);
        double *x = smooth(&b, &o, &result);
        const size_t size = (size_t)(b.mesh.n_nodes * dim) * sizeof *x;
        for (int way = 0; way < 4; way++) {
            o = usual();
            o.threads = way < 2 ? 2 + 3 * way : 1;
            o.isa = way == 2 ? PLANISH_ISA_PLAIN : PLANISH_ISA_AUTO;
            o.precision = way == 3 ? PLANISH_PRECISION_ROUNDED : PLANISH_PRECISION_DOUBLE;
            o.round = same;
            double *y = smooth(&b, &o, &other);
            assert_memory_equal(x, y, size);
            assert_int_equal(result.n_refused, other.n_refused);
            free(y);
        }
        free(x);
        destroy(&b);
    }
}

/** Ask for the end at the call that user counts down to. */
static int stop_at(const planish_progress *progress, void *user) {
    int *left = user;
    (void)progress;
    return --*left <= 0;
}

static void stopped_meshes_are_valid(void **state) {
    const int dim = **(int **)state;
    curved_box b;
    make_box(&b, dim, 4, 0.2, 1);
    for (int calls = 1; calls < 60; calls += 7) {
        planish_options o = usual();
        planish_result result;
        int left = calls;
        o.progress = stop_at;
        o.progress_user = &left;
        double *x = smooth(&b, &o, &result);
        assert_int_equal(count_broken(&b, b.x, x), 0);
        free(x);
    }
    destroy(&b);
}

/** Largest radius ratio of the corners of an element with a movable node. */
static double worst_ratio(const curved_box *b, const double *x) {
    planish_mesh mesh = b->mesh;
    planish_quality quality;
    mesh.coordinates = x;
    assert_int_equal(planish_measure_mesh(&mesh, NULL, &quality, NULL), PLANISH_OK);
    return quality.max_radius_ratio_movable;
}

static void every_option_keeps_elements_valid(void **state) {
    const int dim = **(int **)state;
    enum { N_WAYS = 6 };
    for (unsigned seed = 1; seed <= SEEDS; seed++)
        for (int way = 0; way < N_WAYS; way++) {
            curved_box b;
            planish_options o = usual();
            planish_result result;
            make_box(&b, dim, 4, 0.2, seed);
            if (way == 0)
                o.objective = PLANISH_OBJECTIVE_MEAN_RATIO;
            if (way == 1)
                o.worst = PLANISH_WORST_ANGLE;
            if (way == 2)
                o.min_volume = 0.2 * test_regular_volume(dim);
            if (way == 3)
                o.precision = PLANISH_PRECISION_FLOAT;
            for (int64_t i = 0; way == 3 && i < b.mesh.n_nodes * dim; i++)
                b.x[i] = (double)(float)b.x[i];
            if (way == 4)
                o.max_displacement = 0.05;
            if (way == 5)
                o.only_worse_than = 1.5;
            double *x = smooth(&b, &o, &result);
            for (int64_t i = 0; way == 3 && i < b.mesh.n_nodes * dim; i++)
                assert_true(x[i] == (double)(float)x[i]);
            if (way != 2) /* minimum volumes may cost it */
                assert_true(worst_ratio(&b, x) <= worst_ratio(&b, b.x) * (1 + 1e-9));
            assert_int_equal(count_broken(&b, b.x, x), 0);
            free(x);
            destroy(&b);
        }
}

/** Untangling works on corners; no more elements are inverted afterwards. */
static void tangled_corners_come_first(void **state) {
    const int dim = **(int **)state;
    for (unsigned seed = 1; seed <= SEEDS; seed++) {
        curved_box b;
        const planish_options o = usual();
        planish_result result;
        planish_cell_quality before, after;
        test_mesh_box(&b.box, dim, dim == 3 ? 4 : 8);
        test_mesh_perturb(&b.box, dim == 3 ? 0.6 : 0.9, seed);
        add_mids(&b);
        unsigned random = seed;
        for (int64_t i = b.box.mesh.n_nodes; i < b.mesh.n_nodes; i++)
            for (int d = 0; test_random(&random) < 0.05 && d < dim; d++)
                b.x[i * dim + d] += 0.1 * (2 * test_random(&random) - 1);
        assert_int_equal(planish_measure_cells(&b.mesh, 0, 1, &before, NULL, NULL), PLANISH_OK);
        double *x = smooth(&b, &o, &result);
        planish_mesh mesh = b.mesh;
        mesh.coordinates = x;
        assert_int_equal(planish_measure_cells(&mesh, 0, 1, &after, NULL, NULL), PLANISH_OK);
        assert_true(before.all.n_inverted > 5);
        assert_true(after.all.n_inverted < before.all.n_inverted / 2);
        assert_int_equal(result.n_inverted, after.all.n_inverted);
        assert_true(result.n_inverted_inside <= result.n_inverted);
        free(x);
        destroy(&b);
    }
}

/** A straight tetrahedron or triangle with one free corner and a mid that is far away. */
static void invalid_elements_are_told(void **state) {
    const int dim = **(int **)state;
    curved_box b;
    const planish_options o = usual();
    planish_result result;
    make_box(&b, dim, 0, 0, 1);
    const int corners = dim + 1;
    b.x[(int64_t)b.node[corners] * dim] += 3;
    double *x = smooth(&b, &o, &result);
    assert_true(result.n_curved > 0);
    assert_true(result.n_inverted > 0);
    assert_int_equal(result.n_inverted_inside, result.n_inverted);
    assert_int_equal(count_broken(&b, b.x, x), 0);
    free(x);
    b.x[(int64_t)b.node[corners] * dim] = NAN;
    planish_plan *plan = NULL;
    planish_error error;
    double *y = malloc((size_t)(b.mesh.n_nodes * dim) * sizeof *y);
    memcpy(y, b.x, (size_t)(b.mesh.n_nodes * dim) * sizeof *y);
    b.x[(int64_t)b.node[corners] * dim] = 0;
    assert_int_equal(planish_plan_create(&b.mesh, &o, &plan, NULL), PLANISH_OK);
    assert_int_equal(planish_smooth(plan, y, &o, &result, &error), PLANISH_ERROR_MESH);
    assert_int_equal(error.node, b.node[corners]);
    planish_plan_destroy(plan);
    free(y);
    destroy(&b);
}

/** A node that is the mid of two edges: of one it is in the middle, of the other it is not. Which
 *  elements are curved does not depend on their order. */
static void mids_of_several_edges_are_judged_by_each(void **state) {
    const int dim = **(int **)state;
    curved_box b;
    const planish_options o = usual();
    planish_result result;
    make_box(&b, dim, 0, 0, 1);
    const int64_t last = b.mesh.n_elements - 1;
    const int corners = dim + 1;
    for (int way = 0; way < 2; way++) {
        const int64_t own = way ? last : 0, other = way ? 0 : last;
        int32_t *mid = &b.node[b.offset[other] + corners], before = *mid;
        *mid = b.node[b.offset[own] + corners];
        double *x = smooth(&b, &o, &result);
        assert_int_equal(result.n_curved, 1);
        free(x);
        *mid = before;
    }
    destroy(&b);
}

static void smooth_with_faults(const void *world, faults *f) {
    const curved_box *b = world;
    const planish_options o = usual();
    const size_t size = (size_t)(b->mesh.n_nodes * b->mesh.dim) * sizeof(double);
    double *x = malloc(size);
    planish_plan *plan = NULL;
    planish_error error;
    int status;
    do {
        status = planish_plan_create(&b->mesh, &o, &plan, &error);
    } while (faults_refused(f, status, &error));
    do {
        memcpy(x, b->x, size);
        status = planish_smooth(plan, x, &o, NULL, &error);
        assert_true(!status || memcmp(x, b->x, size) == 0);
    } while (faults_refused(f, status, &error));
    faults_add(f, x, size);
    planish_plan_destroy(plan);
    free(x);
}

static void failed_allocations_are_refused(void **state) {
    const int dim = **(int **)state;
    curved_box b;
    make_box(&b, dim, 4, 0.2, 1);
    assert_true(faults_try("planish_smooth of curved elements", smooth_with_faults, &b, 30) > 10);
    destroy(&b);
}

/* ---- mids that move by themselves ----------------------------------------------------------- */

/** Whether a mid is on the boundary of the box, as both of its ends are on one side of it. */
static int is_outer(const curved_box *b, int64_t mid) {
    const int dim = b->mesh.dim;
    int outer = 0;
    for (int d = 0; d < dim; d++) {
        double low = INFINITY, high = -INFINITY;
        for (int64_t i = 0; i < b->box.mesh.n_nodes; i++) {
            low = fmin(low, b->x[i * dim + d]);
            high = fmax(high, b->x[i * dim + d]);
        }
        const double p = b->x[(int64_t)b->end[mid][0] * dim + d];
        const double q = b->x[(int64_t)b->end[mid][1] * dim + d];
        outer |= p == q && (p == low || p == high);
    }
    return outer;
}

/** Push about one inner mid in so many by up to size. */
static void push_mids(curved_box *b, unsigned one_in, double size, unsigned seed) {
    const int dim = b->mesh.dim;
    for (int64_t i = b->box.mesh.n_nodes; i < b->mesh.n_nodes; i++)
        for (int d = 0; test_random(&seed) * one_in < 1 && !is_outer(b, i) && d < dim; d++)
            b->x[i * dim + d] += size * (2 * test_random(&seed) - 1);
}

static planish_cell_measures measures_of(const curved_box *b, const double *x) {
    planish_mesh mesh = b->mesh;
    planish_cell_quality quality;
    mesh.coordinates = x;
    assert_int_equal(planish_measure_cells(&mesh, 0, 1, &quality, NULL, NULL), PLANISH_OK);
    return quality.all;
}

static void mids_mend_invalid_elements(void **state) {
    const int dim = **(int **)state;
    for (unsigned seed = 1; seed <= SEEDS; seed++) {
        curved_box b;
        planish_options o = usual();
        planish_result result;
        test_mesh_box(&b.box, dim, dim == 3 ? 4 : 8);
        add_mids(&b);
        push_mids(&b, dim == 3 ? 20 : 6, 1.5, seed);
        assert_true(measures_of(&b, b.x).n_inverted > 5);
        double *x = smooth(&b, &o, &result);
        const planish_cell_measures after = measures_of(&b, x);
        assert_int_equal(after.n_inverted, 0);
        assert_int_equal(result.n_inverted, 0);
        assert_int_equal(result.n_hopeless, 0);
        assert_true(result.n_released_mids > 0);
        assert_true(after.min_jacobian_ratio > 0.1);
        for (int64_t i = b.box.mesh.n_nodes; i < b.mesh.n_nodes; i++)
            assert_true(!is_outer(&b, i) ||
                        memcmp(&x[i * dim], &b.x[i * dim], (size_t)dim * sizeof *x) == 0);
        o.threads = 3;
        double *y = smooth(&b, &o, &result);
        assert_memory_equal(x, y, (size_t)(b.mesh.n_nodes * dim) * sizeof *x);
        free(y);
        o.untangle = 0;
        y = smooth(&b, &o, &result);
        assert_int_equal(count_broken(&b, b.x, y), 0);
        free(y);
        free(x);
        destroy(&b);
    }
}

/** Valid elements of little quality get more, and no corner moves otherwise than without. */
static void mids_improve_poor_elements(void **state) {
    const int dim = **(int **)state;
    int n_poor = 0;
    for (unsigned seed = 1; seed <= SEEDS; seed++) {
        curved_box b;
        planish_options o = usual();
        planish_result result, other;
        test_mesh_box(&b.box, dim, dim == 3 ? 4 : 8);
        add_mids(&b);
        push_mids(&b, dim == 3 ? 30 : 8, dim == 3 ? 0.3 : 0.2, seed);
        o.curve_quality = 0;
        double *x = smooth(&b, &o, &other);
        o.curve_quality = dim == 3 ? 0.5 : 0.8;
        double *y = smooth(&b, &o, &result);
        if (other.n_inverted == 0 && result.n_released_mids > 0) {
            n_poor++;
            assert_true(measures_of(&b, x).min_jacobian_ratio < o.curve_quality);
            assert_true(measures_of(&b, y).min_jacobian_ratio >
                        measures_of(&b, x).min_jacobian_ratio);
            assert_memory_equal(x, y, (size_t)(b.box.mesh.n_nodes * dim) * sizeof *x);
        }
        assert_int_equal(count_broken(&b, x, y), 0);
        free(x);
        free(y);
        destroy(&b);
    }
    assert_true(n_poor > 1);
}

/** Fold an element at a corner whose edges are all on the boundary, by one of their mids. */
static void fold(curved_box *b) {
    const int dim = b->mesh.dim, corners = dim + 1, edges = dim == 3 ? 6 : 3;
    for (int64_t e = 0; e < b->mesh.n_elements; e++)
        for (int c = 0; c < corners; c++) {
            const int32_t *node = b->node + b->offset[e];
            int n_outer = 0, mid = 0, end = 0;
            for (int k = 0; k < edges; k++) {
                if ((EDGE[k][0] != c && EDGE[k][1] != c) || !is_outer(b, node[corners + k]))
                    continue;
                n_outer++;
                mid = node[corners + k];
                end = node[EDGE[k][0] == c ? EDGE[k][1] : EDGE[k][0]];
            }
            if (n_outer < dim)
                continue;
            for (int d = 0; d < dim; d++) /* the edge begins the other way */
                b->x[mid * dim + d] =
                    1.5 * b->x[node[c] * dim + d] - 0.5 * b->x[(int64_t)end * dim + d];
            return;
        }
}

/** Find the infeasible elements at x, all of which are invalid. */
static int64_t count_infeasible(const curved_box *b, const double *x) {
    const planish_options o = usual();
    planish_plan *plan = NULL;
    const size_t m = (size_t)b->mesh.n_elements;
    uint8_t *infeasible = malloc(m), *is_valid = malloc(m);
    int64_t n, n_listed = 0;
    judge(b, x, is_valid);
    assert_int_equal(planish_plan_create(&b->mesh, &o, &plan, NULL), PLANISH_OK);
    assert_int_equal(planish_find_infeasible(plan, x, &o, infeasible, &n, NULL, NULL), PLANISH_OK);
    for (size_t e = 0; e < m; e++) {
        n_listed += infeasible[e];
        assert_true(!infeasible[e] || !is_valid[e]);
    }
    assert_int_equal(n_listed, n);
    planish_plan_destroy(plan);
    free(infeasible);
    free(is_valid);
    return n;
}

/** An element that its boundary folds stays folded: that is proved. Others are mended around it. */
static void hopeless_elements_are_proved(void **state) {
    const int dim = **(int **)state;
    curved_box b;
    const planish_options o = usual();
    planish_result result;
    test_mesh_box(&b.box, dim, dim == 3 ? 4 : 8);
    add_mids(&b);
    fold(&b);
    const int64_t n_folded = measures_of(&b, b.x).n_inverted;
    assert_true(n_folded > 0);
    double *x = smooth(&b, &o, &result);
    assert_in_range(result.n_hopeless, 1, n_folded);
    assert_in_range(result.n_inverted, result.n_hopeless, n_folded);
    assert_int_equal(count_broken(&b, b.x, x), 0);
    assert_int_equal(count_infeasible(&b, b.x), result.n_hopeless);
    assert_int_equal(count_infeasible(&b, x), result.n_hopeless);
    free(x);
    push_mids(&b, dim == 3 ? 40 : 10, 1.5, 3);
    assert_true(measures_of(&b, b.x).n_inverted > n_folded);
    x = smooth(&b, &o, &result);
    assert_in_range(result.n_inverted, 1, n_folded);
    assert_int_equal(count_broken(&b, b.x, x), 0);
    free(x);
    destroy(&b);
}

/** Mids that the caller holds, and bounds. */
static void held_mids_stay(void **state) {
    const int dim = **(int **)state;
    curved_box b;
    planish_options o = usual();
    planish_result result;
    test_mesh_box(&b.box, dim, dim == 3 ? 4 : 8);
    add_mids(&b);
    push_mids(&b, dim == 3 ? 20 : 6, 1.5, 1);
    uint8_t *constraint = calloc((size_t)b.mesh.n_nodes, 1);
    for (int64_t i = b.box.mesh.n_nodes; i < b.mesh.n_nodes; i++)
        constraint[i] = PLANISH_CONSTRAINT_FIXED;
    b.mesh.constraint = constraint;
    double *x = smooth(&b, &o, &result);
    assert_memory_equal(x, b.x, (size_t)(b.mesh.n_nodes * dim) * sizeof *x);
    assert_int_equal(result.n_released_mids, 0);
    assert_true(result.n_hopeless > 0 && result.n_hopeless == result.n_inverted);
    free(x);
    b.mesh.constraint = NULL;
    o.max_displacement = 0.05;
    x = smooth(&b, &o, &result);
    assert_true(result.n_released_mids > 0);
    for (int64_t i = 0; i < b.mesh.n_nodes; i++) {
        double square = 0;
        for (int d = 0; d < dim; d++)
            square += (x[i * dim + d] - b.x[i * dim + d]) * (x[i * dim + d] - b.x[i * dim + d]);
        assert_true(sqrt(square) <= 0.05 * (1 + 1e-12));
    }
    assert_int_equal(count_broken(&b, b.x, x), 0);
    free(x);
    free(constraint);
    destroy(&b);
}

/* ---- rows of coefficients ------------------------------------------------------------------- */

static const int ROW_TYPES[] = {
    PLANISH_CELL_TRIANGLE,       PLANISH_CELL_TRIANGLE6,      PLANISH_CELL_QUADRILATERAL,
    PLANISH_CELL_QUADRILATERAL8, PLANISH_CELL_QUADRILATERAL9, PLANISH_CELL_TETRAHEDRON,
    PLANISH_CELL_TETRAHEDRON10,  PLANISH_CELL_HEXAHEDRON,     PLANISH_CELL_HEXAHEDRON20,
    PLANISH_CELL_HEXAHEDRON27,   PLANISH_CELL_WEDGE,          PLANISH_CELL_WEDGE15,
    PLANISH_CELL_WEDGE18,
};
enum { N_ROW_TYPES = sizeof ROW_TYPES / sizeof *ROW_TYPES };

static void assert_near(double a, double b, double tolerance) {
    assert_true(fabs(a - b) <= tolerance);
}

static double noise(uint64_t *state) {
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) * 0x1p-52 - 1;
}

/** Make an element with corners at random, and nodes off their middle by bend: x [n_nodes][dim]. */
static void make_element(const pl_row_rule *rule, double bend, uint64_t *state, double *x) {
    const pl_cell_type *type = rule->jacobian.type;
    const pl_cell_shape *shape = type->shape;
    const int dim = shape->dim;
    for (int i = 0; i < type->n_nodes; i++) {
        double place[3] = {0};
        int n = 0;
        for (int c = 0; c < shape->n_corners; c++) {
            if (!(rule->jacobian.straight[i] >> c & 1))
                continue;
            n++;
            for (int d = 0; d < dim; d++) {
                int first = 0, s = 0; /* direction d is in simplex s, whose first one is first */
                while (d >= first + shape->n_vertices[s] - 1)
                    first += shape->n_vertices[s++] - 1;
                place[d] +=
                    i < shape->n_corners ? shape->vertex[c][s] == d - first + 1 : x[c * dim + d];
            }
        }
        for (int d = 0; d < dim; d++)
            x[i * dim + d] = place[d] / n + (i < shape->n_corners ? 0.2 : bend) * noise(state);
    }
}

/** The rows are the coefficients of validity.h, and what they become where the handle has moved. */
static void rows_tell_what_a_move_does(void **unused) {
    uint64_t state = 7;
    (void)unused;
    for (int t = 0; t < N_ROW_TYPES; t++) {
        pl_row_rule *rule = pl_row_rule_make(pl_cell_type_of(ROW_TYPES[t]));
        const int n_nodes = rule->jacobian.n_nodes, dim = rule->jacobian.type->shape->dim;
        for (int handle = 0; handle < n_nodes; handle++) {
            double x[PL_CELL_NODES * 3], rate[PL_CELL_NODES] = {0}, way[3] = {0};
            double coefficient[PL_JACOBIAN_COEFFICIENTS], ones[PL_JACOBIAN_LANES];
            pl_star_row row[PL_JACOBIAN_COEFFICIENTS], moved[PL_JACOBIAN_COEFFICIENTS];
            uint8_t index[PL_JACOBIAN_COEFFICIENTS];
            make_element(rule, 0.1, &state, x);
            pl_row_handle(rule, handle, rate);
            const int n = pl_rows_of_element(rule, x, 1, rate, 1, row, index);
            pl_row_coefficients(rule, x, 1, coefficient);
            static pl_jacobian_block b;
            for (int l = 0; l < PL_JACOBIAN_LANES; l++) {
                ones[l] = 1;
                for (int i = 0; i < n_nodes * dim; i++)
                    b.x[i / dim][i % dim][l] = x[i] - x[i % dim];
            }
            pl_jacobian_evaluate(&rule->jacobian, ones, &b);
            for (int c = 0; c < rule->jacobian.n_coefficients; c++)
                assert_near(coefficient[c] * rule->unit, b.coefficient[c][0], 1e-12 * rule->unit);
            for (int d = 0; d < dim; d++)
                way[d] = noise(&state);
            for (int i = 0; i < n_nodes * dim; i++)
                x[i] += rate[i / dim] * way[i % dim];
            assert_int_equal(pl_rows_of_element(rule, x, 1, rate, 1, moved, NULL), n);
            for (int i = 0; i < n; i++) {
                double e = row[i].e, D = row[i].D0;
                assert_near(row[i].D0, coefficient[index[i]], 1e-13);
                for (int d = 0; d < dim; d++) {
                    e += (2 * row[i].slope_e[d] + row[i].c * way[d]) * way[d];
                    D += row[i].slope_d[d] * way[d];
                }
                assert_near(moved[i].e, e, 1e-11);
                assert_near(moved[i].D0, D, 1e-11);
            }
            /* coefficients without a row stay */
            double after[PL_JACOBIAN_COEFFICIENTS];
            pl_row_coefficients(rule, x, 1, after);
            for (int c = 0, i = 0; c < rule->jacobian.n_coefficients; c++) {
                if (i < n && index[i] == c)
                    i++;
                else
                    assert_near(after[c], coefficient[c], 1e-12);
            }
        }
        pl_row_rule_free(rule);
    }
}

/** Rows of straight simplices, and those at corners of linear elements, are mean ratios. */
static void rows_are_mean_ratios_of_corners(void **unused) {
    uint64_t state = 11;
    (void)unused;
    for (int t = 0; t < N_ROW_TYPES; t++) {
        pl_row_rule *rule = pl_row_rule_make(pl_cell_type_of(ROW_TYPES[t]));
        const pl_cell_type *type = rule->jacobian.type;
        const pl_cell_shape *shape = type->shape;
        const int dim = shape->dim, is_simplex = shape->n_corners == dim + 1;
        if (type->order == 2 && !is_simplex) {
            pl_row_rule_free(rule);
            continue;
        }
        double x[PL_CELL_NODES * 3], rate[PL_CELL_NODES] = {0};
        pl_star_row row[PL_JACOBIAN_COEFFICIENTS];
        pl_corner_form form[PL_N_FORMS];
        pl_corner_forms_make(dim, form);
        make_element(rule, 0, &state, x);
        for (int i = 0; i < type->n_nodes; i++)
            rate[i] = 1 + i; /* so that every row depends on it */
        const int n = pl_rows_of_element(rule, x, 1, rate, 1, row, NULL);
        assert_int_equal(n, rule->jacobian.n_coefficients);
        const uint8_t code =
            pl_form_code(pl_corner_code(pl_kind_of_shape(shape), 0), 0, 0); /* x is the corner */
        for (int c = 0; c < shape->n_corners; c++) {
            const double *p = x + c * dim, *q[3] = {0};
            double edge[3][3] = {{0}}, E = 0, D;
            for (int k = 0; k < dim; k++) {
                q[k] = x + shape->neighbour[c][k] * dim;
                for (int d = 0; d < dim; d++)
                    edge[k][d] = q[k][d] - p[d];
            }
            edge[2][2] = dim == 2 ? 1 : edge[2][2];
            D = 0;
            for (int d = 0; d < 3; d++)
                D += edge[0][d] * (edge[1][(d + 1) % 3] * edge[2][(d + 2) % 3] -
                                   edge[1][(d + 2) % 3] * edge[2][(d + 1) % 3]);
            for (int k = 0, pair = dim; k < dim; k++) {
                E += form[code].weight[k] * (edge[k][0] * edge[k][0] + edge[k][1] * edge[k][1] +
                                             (dim == 3 ? edge[k][2] * edge[k][2] : 0));
                for (int m = k + 1; m < dim; m++, pair++)
                    for (int d = 0; d < dim; d++)
                        E += form[code].weight[pair] * (q[m][d] - q[k][d]) * (q[m][d] - q[k][d]);
            }
            for (int i = 0; i < n; i++)
                if (is_simplex || i == rule->jacobian.corner[c]) {
                    assert_near(row[i].D0, D, 1e-12);
                    assert_near(row[i].e, E, 1e-12);
                    assert_near(row[i].factor, form[code].factor, 1e-15);
                }
        }
        pl_row_rule_free(rule);
    }
}

/* ---- one cell of any type -------------------------------------------------------------------- */

static const int TYPES[] = {5, 22, 9, 23, 28, 10, 24, 12, 25, 29, 13, 26, 32, 14};
enum { N_TYPES = sizeof TYPES / sizeof *TYPES, TRIALS = 30, MOVES = 60 };

/** A plan of a single cell, which has as much of a plan as the watch reads. */
typedef struct lone_cell {
    const pl_cell_type *type;
    planish_plan plan;
    planish_options options;
    pl_watch watch;
    int64_t offset[2];
    uint8_t of_type, mobility[PL_CELL_NODES], role[PL_CELL_NODES], corner[PL_CELL_CORNERS];
    int8_t sign[PL_CELL_CORNERS];
    int32_t node[PL_CELL_NODES], cell_of[PL_CELL_CORNERS], cell_begin[2];
    int32_t elements[PL_CELL_CORNERS * 4];
    double x[PL_CELL_NODES * 3], start[PL_CELL_NODES * 3];
    pl_jacobian_rule rule;
    int is_mirrored; /* it is numbered the other way round */
} lone_cell;

/** Corners of the ideal cell. */
static void place_corners(lone_cell *c) {
    const pl_cell_shape *shape = c->type->shape;
    const int dim = shape->dim;
    for (int j = 0; j < shape->n_corners; j++)
        for (int s = 0, d = 0; s < shape->n_simplices; s++)
            for (int v = 1; v < shape->n_vertices[s]; v++, d++)
                c->x[j * dim + d] = shape->vertex[j][s] == v;
    static const double pyramid[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.5, 0.5, 0.7};
    if (shape->n_simplices == 0)
        memcpy(c->x, pyramid, sizeof pyramid);
}

/** Put the nodes of order 2 in the middle of their corners, off by up to bend. */
static void place_mids(lone_cell *c, double bend, unsigned *seed) {
    const int dim = c->type->shape->dim;
    for (int i = c->type->shape->n_corners; i < c->type->n_nodes; i++) {
        const unsigned parents = pl_cell_parents(c->type, i);
        for (int d = 0; d < dim; d++) {
            double sum = 0;
            for (int k = 0; k < c->type->shape->n_corners; k++)
                sum += parents >> k & 1 ? c->x[k * dim + d] : 0;
            c->x[i * dim + d] =
                sum / __builtin_popcount(parents) + bend * (2 * test_random(seed) - 1);
        }
    }
}

/** Make the plan and its watch, for nodes where c->x has them. */
static void watch_cell(lone_cell *c, double min_volume) {
    const pl_cell_shape *shape = c->type->shape;
    const int dim = shape->dim, is_simplex = shape->n_simplices == 1;
    const int kind = pl_kind_of_shape(shape), n = is_simplex ? 1 : shape->n_measured;
    planish_plan *plan = &c->plan;
    planish_error error;
    memset(plan, 0, sizeof *plan);
    for (int i = 0; i < c->type->n_nodes * dim; i += dim)
        c->x[i] *= c->is_mirrored ? -1 : 1;
    for (int i = 0; i < c->type->n_nodes; i++) {
        c->node[i] = i;
        c->mobility[i] = i < shape->n_corners;
        c->role[i] = 0;
    }
    for (int e = 0; e < n; e++) {
        c->corner[e] = pl_corner_code(kind, e);
        c->sign[e] = c->is_mirrored ? -1 : 1;
        c->cell_of[e] = 0;
        for (int j = 0; j <= dim; j++)
            c->elements[e * (dim + 1) + j] = is_simplex ? j
                                             : j == 0   ? e
                                                        : shape->neighbour[e][j - 1];
    }
    c->cell_begin[0] = 0;
    c->cell_begin[1] = n;
    c->of_type = c->type->type;
    c->offset[0] = 0;
    c->offset[1] = c->type->n_nodes;
    plan->dim = plan->work.dim = dim;
    plan->work.n_nodes = plan->whole.n_nodes = c->type->n_nodes;
    plan->work.n_elements = n;
    plan->work.elements = c->elements;
    plan->work.corner = c->corner;
    plan->work.n_cells = 1;
    plan->work.cell_begin = c->cell_begin;
    plan->work.sign = c->sign;
    plan->work.mobility = c->mobility;
    plan->all = &plan->work;
    plan->inner = c->node;
    plan->cells =
        (planish_cells){.n = 1, .type = &c->of_type, .offset = c->offset, .node = c->node};
    plan->cell_of = c->cell_of;
    plan->role = c->role;
    plan->node_stride = dim;
    plan->component_stride = 1;
    plan->threads = 1;
    plan->scratch.coordinates = c->x;
    pl_corner_forms_make(dim, plan->form);
    memcpy(c->start, c->x, sizeof c->x);
    planish_options_init(&c->options);
    if (pl_watch_create(plan, &c->options, c->start, c->start, min_volume, &c->watch, &error))
        fail_msg("%s", error.text);
    pl_jacobian_rule_make(c->type, &c->rule);
}

static void init_cell(lone_cell *c, int type) {
    memset(c, 0, sizeof *c);
    c->type = pl_cell_type_of(type);
    place_corners(c);
}

/** Validity of the cell, nodes of order 2 following; *least: its least
 *  coefficient, as a volume. */
static int is_cell_valid(const lone_cell *c, double *least) {
    const int dim = c->type->shape->dim;
    static pl_jacobian_block b;
    double x[PL_CELL_NODES * 3], sign[PL_JACOBIAN_LANES];
    memcpy(x, c->x, sizeof x);
    for (int i = c->type->shape->n_corners; i < c->type->n_nodes; i++)
        pl_mid_place(&c->watch.mids, i, x + i * dim);
    memset(&b, 0, sizeof b);
    for (int i = 0; i < c->type->n_nodes; i++)
        for (int d = 0; d < dim; d++)
            b.x[i][d][0] = x[i * dim + d] - x[d];
    for (int l = 0; l < PL_JACOBIAN_LANES; l++)
        sign[l] = c->sign[0];
    pl_jacobian_evaluate(&c->rule, sign, &b);
    double unit = c->rule.common;
    for (int d = 0; d < dim && c->type->order > 1; d++)
        unit *= 0.5 * c->rule.control_term[0].weight;
    *least = b.least[0] / unit * c->plan.form[pl_form_code(c->corner[0], 0, 0)].volume;
    return pl_validity_of_lane(&c->rule, &b, 0, c->node, x, sign[0]) == PL_VALID;
}

static int has_positive_corners(const lone_cell *c) {
    const int dim = c->type->shape->dim;
    for (int e = 0; e < c->cell_begin[1]; e++) {
        const double *vertex[4];
        for (int j = 0; j <= dim; j++)
            vertex[j] = c->x + c->elements[e * (dim + 1) + j] * dim;
        if (pl_measure_sign(dim, vertex) * c->sign[e] <= 0)
            return 0;
    }
    return 1;
}

/** What a walk of a cell's corners has met. */
typedef struct walk {
    int admitted, refused, with_room, of_valid;
} walk;

/** Move a corner by a random way of a random length, and back if it is not admitted. Visits keep
 *  corners of linear cells positive: where they would not the corner goes back. */
static void step(lone_cell *c, double min_volume, unsigned *seed, walk *w) {
    const int dim = c->type->shape->dim, corners = c->type->shape->n_corners;
    const int node = (int)(test_random(seed) * corners) % corners;
    const double length = pow(10, -4 * test_random(seed));
    double *x = c->x + node * dim, before[3], least, least_before;
    const int was = is_cell_valid(c, &least_before);
    for (int d = 0; d < dim; d++) {
        before[d] = x[d];
        x[d] += length * (2 * test_random(seed) - 1);
    }
    const int decides = c->watch.type[0]; /* by what: 0: corners */
    const int is_linear = !decides || pl_cell_type_of(decides)->order == 1;
    const int is_valid = is_cell_valid(c, &least);
    const int keeps = is_valid && (!(min_volume > 0) || !(least_before > min_volume * (1 + 1e-9)) ||
                                   least > min_volume * (1 - 1e-9));
    int goes = !is_linear || has_positive_corners(c);
    if (goes) {
        const double way = pl_distance(dim, x, before);
        const int has_room = c->watch.room[0] > way;
        goes = pl_watch_admit(&c->watch, node, way);
        w->with_room += has_room && decides;
        if (goes && was && decides)
            assert_true(keeps);
        if (!goes)
            assert_true(was && (!is_valid || (min_volume > 0 && least < min_volume * (1 + 1e-9))));
        w->of_valid += was;
        *(goes ? &w->admitted : &w->refused) += 1;
    }
    for (int d = 0; d < dim && !goes; d++)
        x[d] = before[d];
}

/** Whether a cell that has refused so many moves counts as one that keeps refusing them: if all its
 *  coefficients are positive, which can be constraints then. */
static int64_t check_refuser(const lone_cell *c, int refused) {
    uint8_t mark[PL_CELL_CORNERS] = {0};
    double least;
    is_cell_valid(c, &least);
    const int64_t n = pl_watch_find_refusers(&c->watch, mark);
    assert_int_equal(n, mark[0]);
    assert_int_equal(n, pl_watch_find_refusers(&c->watch, NULL));
    if (n > 0)
        assert_true(refused >= 3 && least > -1e-12);
    else if (c->watch.type[0] == c->type->type)
        assert_true(refused < 3 || least < 1e-12);
    return n;
}

/** Rooms admit no move that the certificate would refuse; what is refused is invalid. */
static void moves_of_valid_cells_are_decided(void **state) {
    (void)state;
    int64_t n_all = 0;
    for (int t = 0; t < N_TYPES; t++) {
        static lone_cell c;
        walk w = {0, 0, 0, 0};
        unsigned seed = 7 + (unsigned)t;
        int64_t n_refusers = 0;
        const int is_linear_one =
            TYPES[t] == PLANISH_CELL_HEXAHEDRON || TYPES[t] == PLANISH_CELL_WEDGE;
        const int trials = is_linear_one ? 10 * TRIALS : TRIALS; /* few are invalid inside alone */
        for (int trial = 0; trial < trials; trial++) {
            init_cell(&c, TYPES[t]);
            const int n = c.type->shape->n_corners * c.type->shape->dim;
            for (int i = 0; i < n; i++)
                c.x[i] += (is_linear_one ? 0.4 : 0.2) * (2 * test_random(&seed) - 1);
            place_mids(&c, trial % 3 ? 0.08 : 0, &seed);
            c.is_mirrored = trial % 2;
            watch_cell(&c, 0);
            pl_watch_measure(&c.watch);
            const int before = w.refused;
            for (int m = 0; m < MOVES; m++)
                step(&c, 0, &seed, &w);
            n_refusers += check_refuser(&c, w.refused - before);
            pl_watch_destroy(&c.watch);
        }
        const int is_watched = TYPES[t] != PLANISH_CELL_TRIANGLE && TYPES[t] != 10 &&
                               TYPES[t] != PLANISH_CELL_QUADRILATERAL &&
                               TYPES[t] != PLANISH_CELL_PYRAMID;
        assert_true(w.admitted > MOVES && w.of_valid > MOVES);
        assert_true(!is_watched == (w.refused == 0));
        assert_true(!is_watched || w.with_room > MOVES);
        assert_true(is_watched || n_refusers == 0);
        n_all += n_refusers;
    }
    assert_true(n_all > 10);
}

/** Cells that are above their minimum volume stay there, by their least coefficient. */
static void minimum_volumes_hold_inside(void **state) {
    (void)state;
    static const double part = 0.4;
    for (int t = 0; t < N_TYPES; t++) {
        static lone_cell c;
        walk w = {0, 0, 0, 0};
        unsigned seed = 70 + (unsigned)t;
        for (int trial = 0; trial < TRIALS; trial++) {
            double least;
            init_cell(&c, TYPES[t]);
            place_mids(&c, 0.04, &seed);
            watch_cell(&c, 0);
            is_cell_valid(&c, &least);
            const double min_volume = (trial % 2 ? 1.2 : part) * least;
            pl_watch_destroy(&c.watch);
            if (!(least > 0))
                continue;
            watch_cell(&c, min_volume);
            pl_watch_measure(&c.watch);
            for (int m = 0; m < MOVES && (c.type->order > 1 || c.watch.type[0] == 0); m++)
                step(&c, min_volume, &seed, &w);
            pl_watch_destroy(&c.watch);
        }
        assert_true(c.type->order == 1 || w.admitted > MOVES);
    }
}

/** Of what a corner moves by, a mid moves by 1/2, a node of a face by 1/4, of the cell by 1/8. */
static void nodes_follow_corners(void **state) {
    (void)state;
    for (int t = 0; t < N_TYPES; t++) {
        static lone_cell c;
        unsigned seed = 3;
        init_cell(&c, TYPES[t]);
        const int dim = c.type->shape->dim;
        place_mids(&c, 0.05, &seed);
        c.is_mirrored = t % 2;
        watch_cell(&c, 0);
        const pl_worst_cell worst = pl_watch_worst(&c.watch, 0);
        const int is_ideal = c.type->shape->n_corners == (dim == 3 ? 8 : 4);
        assert_true(is_ideal ? fabs(worst.ar2 - 1) < 1e-15 && fabs(worst.acuteness - 1) < 1e-15
                             : worst.ar2 > 1 && worst.ar2 < 4 && worst.acuteness < 4);
        for (int corner = 0; corner < c.type->shape->n_corners; corner++) {
            c.x[corner * dim] += 0.25;
            for (int i = c.type->shape->n_corners; i < c.type->n_nodes; i++) {
                const unsigned parents = pl_cell_parents(c.type, i);
                double x[3];
                assert_int_equal(parents, c.rule.straight[i]);
                pl_mid_place(&c.watch.mids, i, x);
                const double rate = parents >> corner & 1 ? 1.0 / __builtin_popcount(parents) : 0;
                assert_true(fabs(x[0] - c.start[i * dim] - 0.25 * rate) < 1e-15);
                assert_true(x[1] == c.start[i * dim + 1]);
            }
            c.x[corner * dim] = c.start[corner * dim];
        }
        pl_watch_destroy(&c.watch);
    }
}

/** The top of a high cell is turned against its bottom: no corner shows it. */
static void cells_may_be_tangled_inside(void **state) {
    (void)state;
    static const double brick[] = {-0.5, -0.25, 0,     0.5,  -0.25, 0,    0.5,  0.25,
                                   0,    -0.5,  0.25,  0,    0.25,  0.5,  100,  -0.25,
                                   0.5,  100,   -0.25, -0.5, 100,   0.25, -0.5, 100};
    static lone_cell c;
    init_cell(&c, PLANISH_CELL_HEXAHEDRON);
    memcpy(c.x, brick, sizeof brick);
    watch_cell(&c, 0);
    assert_true(has_positive_corners(&c));
    assert_int_equal(pl_watch_measure(&c.watch), 1);
    assert_false(pl_watch_is_valid(&c.watch, 0));
    pl_watch_destroy(&c.watch);
    init_cell(&c, PLANISH_CELL_WEDGE);
    for (int j = 0; j < 6; j++) { /* a triangle, and the same turned by 180 degrees */
        const double angle = 2 * acos(-1) * (j % 3) / 3 + (j < 3 ? 0 : acos(-1));
        c.x[j * 3] = cos(angle);
        c.x[j * 3 + 1] = sin(angle);
        c.x[j * 3 + 2] = j < 3 ? 0 : 100;
    }
    watch_cell(&c, 0);
    assert_true(has_positive_corners(&c));
    assert_int_equal(pl_watch_measure(&c.watch), 1);
    for (int j = 0; j < 3; j++) { /* and by nothing */
        c.x[j * 3 + 9] = c.x[j * 3];
        c.x[j * 3 + 10] = c.x[j * 3 + 1];
    }
    assert_int_equal(pl_watch_measure(&c.watch), 0);
    assert_true(c.watch.room[0] > 0.01);
    pl_watch_destroy(&c.watch);
}

/* ---- boxes of cells --------------------------------------------------------------------------- */

/** State of each cell of a box at x. */
static uint8_t *states_of(const cell_box *box, const double *x) {
    planish_mesh mesh = box->mesh;
    planish_cell_quality quality;
    planish_error error;
    uint8_t *state = malloc((size_t)box->cells.n);
    const planish_cell_values values = {.state = state};
    mesh.coordinates = x;
    if (planish_measure_cells(&mesh, 0, 1, &quality, &values, &error))
        fail_msg("%s", error.text);
    return state;
}

/** Make a box of order 1, or 2 (is_full: with nodes in faces and cells), of which nodes inside are
 *  pushed about, and of order 2 some nodes between corners bent. */
static cell_box *make_shaken(cell_box_kind kind, int order, int is_full, unsigned seed) {
    cell_box *plain = cell_box_create(kind, kind < BOX_HEXAHEDRA ? 6 : order == 1 ? 4 : 3);
    cell_box_shake(plain, order == 1 ? 0.3 : 0.15, seed);
    if (order == 1)
        return plain;
    cell_box *box = cell_box_raise(plain, is_full);
    const int dim = box->mesh.dim;
    for (int64_t i = plain->mesh.n_nodes; i < box->mesh.n_nodes; i++)
        for (int d = 0; test_random(&seed) < 0.2 && d < dim; d++)
            box->x[i * dim + d] += 0.15 * (2 * test_random(&seed) - 1);
    cell_box_destroy(plain);
    return box;
}

/** Smooth a copy of the box's coordinates until the progress function has been called so often. */
static double *smooth_box(const cell_box *box, int calls, planish_result *result) {
    const size_t size = (size_t)(box->mesh.n_nodes * box->mesh.dim) * sizeof(double);
    planish_options o = usual();
    planish_plan *plan = NULL;
    planish_error error;
    double *x = malloc(size);
    o.progress = stop_at;
    o.progress_user = &calls;
    o.untangle = 0;
    memcpy(x, box->x, size);
    if (planish_plan_create(&box->mesh, &o, &plan, &error) ||
        planish_smooth(plan, x, &o, result, &error))
        fail_msg("%s", error.text);
    planish_plan_destroy(plan);
    return x;
}

/** Whenever a call ends, no cell is invalid that was valid. */
static void no_stop_leaves_a_cell_invalid(void **state) {
    (void)state;
    int64_t n_refused = 0, n_moved = 0;
    for (int kind = 0; kind < N_BOX_KINDS; kind++)
        for (int way = 0; way < 3; way++) {
            cell_box *box = make_shaken((cell_box_kind)kind, way > 0 ? 2 : 1, way == 2, 5);
            uint8_t *before = states_of(box, box->x);
            for (int calls = 1; calls < 100; calls = calls * 4 + 1) {
                planish_result result;
                double *x = smooth_box(box, calls, &result);
                uint8_t *after = states_of(box, x);
                for (int64_t e = 0; e < box->cells.n; e++)
                    assert_true(before[e] != PLANISH_CELL_STATE_VALID ||
                                after[e] == PLANISH_CELL_STATE_VALID);
                n_refused += result.n_refused;
                n_moved += result.n_moved_nodes;
                free(after);
                free(x);
            }
            free(before);
            cell_box_destroy(box);
        }
    assert_true(n_refused > 0 && n_moved > 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_tell_what_a_move_does),
        cmocka_unit_test(rows_are_mean_ratios_of_corners),
        BOTH(mids_mend_invalid_elements),
        BOTH(mids_improve_poor_elements),
        BOTH(hopeless_elements_are_proved),
        BOTH(held_mids_stay),
        BOTH(straight_elements_move_as_those_of_order_1),
        BOTH(curved_elements_stay_valid),
        BOTH(bits_are_the_same_however_they_are_found),
        BOTH(stopped_meshes_are_valid),
        BOTH(every_option_keeps_elements_valid),
        BOTH(tangled_corners_come_first),
        BOTH(invalid_elements_are_told),
        BOTH(mids_of_several_edges_are_judged_by_each),
        BOTH(failed_allocations_are_refused),
        cmocka_unit_test(moves_of_valid_cells_are_decided),
        cmocka_unit_test(minimum_volumes_hold_inside),
        cmocka_unit_test(nodes_follow_corners),
        cmocka_unit_test(cells_may_be_tangled_inside),
        cmocka_unit_test(no_stop_leaves_a_cell_invalid),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
