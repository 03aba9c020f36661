/* Tests of elements of order 2 in planish_smooth: mids follow their ends, and curved elements stay
 * valid. Boxes get mids, some of them off the middle of their edges, inside and on the boundary. */
#include "support/both.h"
#include "support/effort.h"
#include "support/faults.h"
#include "support/meshes.h"
#include "geometry/simplex.h"
#include "quality/certificate.h"
#include "sweep/watch.h"

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
    for (int seed = 1; seed <= SEEDS; seed += effort_step(SEEDS))
        for (int way = 0; way < N_WAYS; way++) {
            curved_box b;
            planish_options o = usual();
            planish_result result;
            make_box(&b, dim, 4, 0.2, (unsigned)seed);
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
    assert_true(faults_try("planish_smooth of curved elements", smooth_with_faults, &b,
                           30 / effort_step(3)) > 10);
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
        assert_int_equal(result.n_infeasible_curved, 0);
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
    assert_in_range(result.n_infeasible_curved, 1, n_folded);
    assert_in_range(result.n_inverted, result.n_infeasible_curved, n_folded);
    assert_int_equal(count_broken(&b, b.x, x), 0);
    assert_int_equal(count_infeasible(&b, b.x), result.n_infeasible_curved);
    assert_int_equal(count_infeasible(&b, x), result.n_infeasible_curved);
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
    assert_true(result.n_infeasible_curved > 0 && result.n_infeasible_curved == result.n_inverted);
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

int main(void) {
    const struct CMUnitTest tests[] = {
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
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
