/* planish_smooth and the calls around it on meshes of elements of every type: what planish.h promises.
 * Elements are judged by planish_measure_cells, which has code of its own. */
#include "support/cell_meshes.h"
#include "support/effort.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Of ratios that planish and the judge compute differently. */
#define NOISE 1e-9

/* ---- meshes and their judge ------------------------------------------------------------------ */

/** Orders of elements: 2 of 8 and 20 nodes, or of 9, 18 and 27. */
enum { LINEAR, QUADRATIC, FULL, N_ORDERS };

static cell_box *box_of(int kind, int n, int order, double shake, uint64_t seed) {
    cell_box *box = cell_box_create((cell_box_kind)kind, n);
    cell_box_shake(box, shake, seed);
    if (order == LINEAR)
        return box;
    cell_box *raised = cell_box_raise(box, order == FULL);
    cell_box_destroy(box);
    return raised;
}

/** Values of the elements, and the mesh's. Arrays are owned. */
typedef struct judged {
    planish_cell_quality quality;
    uint8_t *state;
    double *ratio, *jacobian;
} judged;

static judged judge(const cell_box *box) {
    const size_t n = (size_t)box->cells.n;
    judged j = {.state = malloc(n),
                .ratio = malloc(n * sizeof *j.ratio),
                .jacobian = malloc(n * sizeof *j.jacobian)};
    const planish_cell_values values = {
        .state = j.state, .aspect_ratio = j.ratio, .scaled_jacobian = j.jacobian};
    assert_true(j.state && j.ratio && j.jacobian);
    assert_int_equal(planish_measure_cells(&box->mesh, 0, 1, &j.quality, &values, NULL), 0);
    return j;
}

static void forget(judged *j) {
    free(j->state);
    free(j->ratio);
    free(j->jacobian);
}

static planish_plan *plan_of(const cell_box *box, const planish_options *options) {
    planish_plan *plan;
    planish_error error;
    if (planish_plan_create(&box->mesh, options, &plan, &error))
        fail_msg("%s", error.text);
    return plan;
}

static planish_options defaults(void) {
    planish_options options;
    planish_options_init(&options);
    options.threads = 1;
    return options;
}

/** Bytes of the coordinates. */
static size_t size_of(const cell_box *box) {
    return (size_t)(box->mesh.n_nodes * box->mesh.dim) * sizeof *box->x;
}

static double *copy_of(const cell_box *box) {
    double *x = malloc(size_of(box));
    assert_non_null(x);
    memcpy(x, box->x, size_of(box));
    return x;
}

static planish_result smooth(planish_plan *plan, cell_box *box, const planish_options *options) {
    planish_result result;
    planish_error error;
    if (planish_smooth(plan, box->x, options, &result, &error))
        fail_msg("%s", error.text);
    return result;
}

static int is_same_place(const cell_box *box, const double *x, int64_t node) {
    const size_t size = (size_t)box->mesh.dim * sizeof *x;
    return memcmp(x + node * box->mesh.dim, box->x + node * box->mesh.dim, size) == 0;
}

/** Whether the node is inside the box. */
static int is_inside(const cell_box *box, const double *x, int64_t node) {
    double largest = 0;
    int inside = 1;
    for (int64_t i = 0; i < box->mesh.n_nodes * box->mesh.dim; i++)
        largest = fmax(largest, x[i]);
    for (int d = 0; d < box->mesh.dim; d++)
        inside &= x[node * box->mesh.dim + d] > 0 && x[node * box->mesh.dim + d] < largest;
    return inside;
}

/** Check what holds for every call on a mesh that was valid: before x. */
static void check_kept(const cell_box *box, const double *x, const judged *before) {
    const judged after = judge(box);
    const planish_cell_measures *was = &before->quality.all, *is = &after.quality.all;
    assert_int_equal(was->n_inverted + was->n_uncertified, 0);
    assert_int_equal(is->n_inverted + is->n_uncertified, 0);
    assert_true(is->max_aspect_ratio <= was->max_aspect_ratio * (1 + NOISE));
    assert_true(is->min_scaled_jacobian >= was->min_scaled_jacobian * (1 - NOISE));
    for (int64_t i = 0; i < box->mesh.n_nodes; i++)
        assert_true(is_same_place(box, x, i) || is_inside(box, x, i));
    judged gone = after;
    forget(&gone);
}

static void check_result(const cell_box *box, const planish_result *r, const judged *before) {
    judged after = judge(box);
    const double rms = after.quality.all.rms_aspect_ratio;
    assert_true(fabs(r->rms - rms) <= NOISE * rms);
    assert_true(r->objective == r->rms && r->objective <= r->objective_before);
    assert_true(fabs(r->objective_before - before->quality.all.rms_aspect_ratio) <= NOISE * rms);
    assert_int_equal(r->n_inverted, 0);
    assert_int_equal(r->n_inverted_inside, 0);
    forget(&after);
}

/* ---- measures --------------------------------------------------------------------------------- */

static void near_to(double found, double wanted) {
    assert_true(fabs(found - wanted) <= 1e-12 * fabs(wanted));
}

/** planish_measure and planish_measure_elements say what planish_measure_cells says. */
static void measures_agree(void **state) {
    (void)state;
    int n_inverted = 0;
    for (int kind = 0; kind < N_BOX_KINDS; kind++)
        for (int step = 0; step < 9; step++) {
            cell_box *box = box_of(kind, 4, step % 3, 0.04 * step, (uint64_t)step + 1);
            const planish_options options = defaults();
            planish_plan *plan = plan_of(box, &options);
            planish_quality q;
            judged j = judge(box);
            const planish_cell_measures *all = &j.quality.all;
            double *ratio = malloc((size_t)box->cells.n * sizeof *ratio);
            assert_int_equal(planish_measure(plan, box->x, &q, NULL), 0);
            assert_int_equal(planish_measure_elements(plan, box->x, ratio, NULL), 0);
            for (int64_t i = 0; i < box->cells.n; i++)
                if (j.state[i] == PLANISH_CELL_STATE_VALID)
                    near_to(ratio[i], j.ratio[i]);
            assert_int_equal(q.n_elements, box->cells.n);
            const double volume =
                box->mesh.dim == 3 ? 64 : 16; /* of corners in space not exactly */
            assert_true(fabs(q.total_volume - volume) <=
                        (box->mesh.dim == 3 && kind != BOX_PYRAMIDS ? 0.5 : 1e-10));
            n_inverted += q.n_inverted > 0;
            if (q.n_inverted == all->n_inverted && q.n_inverted == 0) {
                near_to(q.rms_radius_ratio, all->rms_aspect_ratio);
                near_to(q.mean_radius_ratio, all->mean_aspect_ratio);
                near_to(q.max_radius_ratio, all->max_aspect_ratio);
                near_to(q.scaled_jacobian.min, all->min_scaled_jacobian);
                near_to(q.edge_ratio.max, all->max_edge_ratio);
                assert_true(ratio[q.worst_element] == q.max_radius_ratio);
                assert_int_equal(q.n_reversed, 0);
            }
            free(ratio);
            forget(&j);
            planish_plan_destroy(plan);
            cell_box_destroy(box);
        }
    assert_true(n_inverted > 2);
}

/** An element whose nodes are listed the other way round, as seen from most of its shape. */
static void mirrored_elements_are_reversed(void **state) {
    (void)state;
    cell_box *box = box_of(BOX_MIXED, 3, LINEAR, 0.1, 3);
    const planish_options options = defaults();
    uint8_t *reversed = malloc((size_t)box->cells.n);
    int64_t n, wrong = 0;
    while (box->type[wrong] != PLANISH_CELL_WEDGE)
        wrong++;
    int32_t *node = box->node + box->offset[wrong];
    for (int k = 0; k < 3; k++) {
        const int32_t kept = node[k];
        node[k] = node[k + 3];
        node[k + 3] = kept;
    }
    planish_plan *plan = plan_of(box, &options);
    planish_quality q;
    assert_int_equal(planish_find_reversed(plan, box->x, reversed, &n, NULL), 0);
    assert_int_equal(n, 1);
    for (int64_t i = 0; i < box->cells.n; i++)
        assert_int_equal(reversed[i], i == wrong);
    assert_int_equal(planish_measure(plan, box->x, &q, NULL), 0);
    assert_int_equal(q.n_reversed, 1);
    assert_int_equal(q.n_inverted, 0);
    free(reversed);
    planish_plan_destroy(plan);
    cell_box_destroy(box);
}

/* ---- promises --------------------------------------------------------------------------------- */

/** Amount of noise with which boxes of that kind stay valid. */
static double noise_of(int kind) {
    return kind == BOX_PYRAMIDS || kind == BOX_MIXED ? 0.14 : kind == BOX_MIXED_2D ? 0.18 : 0.2;
}

/** Boxes of all kinds and orders become better, and nothing that is promised worse. */
static void boxes_become_better(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++)
        for (int order = 0; order < N_ORDERS; order++)
            for (uint64_t seed = 1; seed < (uint64_t)effort(3, 12); seed++) {
                /* A node of a face is in the middle of one of its diagonals. */
                const double noise = noise_of(kind) * (order == FULL ? 0.6 : 1);
                cell_box *box = box_of(kind, 4, order, noise, seed);
                const planish_options options = defaults();
                planish_plan *plan = plan_of(box, &options);
                judged before = judge(box);
                double *x = copy_of(box);
                const planish_result result = smooth(plan, box, &options);
                assert_int_equal(result.stop, PLANISH_STOP_CONVERGED);
                check_kept(box, x, &before);
                check_result(box, &result, &before);
                assert_true(result.objective < result.objective_before - 1e-3);
                free(x);
                forget(&before);
                planish_plan_destroy(plan);
                cell_box_destroy(box);
            }
}

/** Every objective and measure of the worst. */
static void objectives_fall(void **state) {
    (void)state;
    static const planish_worst WORST[] = {PLANISH_WORST_NONE, PLANISH_WORST_ASPECT_RATIO,
                                          PLANISH_WORST_SCALED_JACOBIAN};
    int n_better = 0;
    for (int kind = 0; kind < N_BOX_KINDS; kind++)
        for (int k = 0; k < 9; k++) {
            cell_box *box = box_of(kind, 4, LINEAR, noise_of(kind), 7);
            planish_options options = defaults();
            options.objective = (planish_objective)(k % 3);
            options.worst = WORST[k / 3];
            planish_plan *plan = plan_of(box, &options);
            judged before = judge(box);
            double *x = copy_of(box);
            const planish_result r = smooth(plan, box, &options);
            const int by_edges = options.objective == PLANISH_OBJECTIVE_EDGE_RATIO;
            assert_true(r.objective < r.objective_before);
            assert_int_equal(r.n_inverted, 0);
            if (!by_edges) {
                check_kept(box, x, &before);
                if (options.worst == PLANISH_WORST_NONE)
                    check_result(box, &r, &before);
            }
            if (r.worst_sweeps > 0) {
                const int of_jacobian = options.worst == PLANISH_WORST_SCALED_JACOBIAN;
                assert_true(of_jacobian ? r.worst_after >= r.worst_before
                                        : r.worst_after <= r.worst_before);
                n_better +=
                    of_jacobian ? r.worst_after > r.worst_before : r.worst_after < r.worst_before;
                assert_true(r.objective <= r.objective_of_worst * 1.0100001);
            }
            free(x);
            forget(&before);
            planish_plan_destroy(plan);
            cell_box_destroy(box);
        }
    assert_true(n_better > N_BOX_KINDS);
}

/** The bits are those of one thread and of the plain kernels, with any options. */
static void threads_and_kernels_change_no_bit(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++)
        for (int how = 0; how < 4; how++) {
            cell_box *box = box_of(kind, 5, how % N_ORDERS, noise_of(kind), 11);
            double *start = copy_of(box), *wanted = NULL;
            for (int threads = 1; threads <= 3; threads++)
                for (planish_isa isa = PLANISH_ISA_PLAIN; isa <= PLANISH_ISA_AVX512; isa++) {
                    planish_options options = defaults();
                    planish_plan *plan = NULL;
                    options.threads = threads;
                    options.isa = isa;
                    options.max_sweeps = 6;
                    options.min_volume_fraction = how == 1 ? 1e-4 : 0;
                    options.max_displacement = how == 2 ? 0.1 : 0;
                    options.objective = how == 3 ? PLANISH_OBJECTIVE_EDGE_RATIO : 0;
                    if (planish_plan_create(&box->mesh, &options, &plan, NULL))
                        continue; /* the CPU has no such kernel */
                    memcpy(box->x, start, size_of(box));
                    smooth(plan, box, &options);
                    if (!wanted)
                        wanted = copy_of(box);
                    assert_memory_equal(box->x, wanted, size_of(box));
                    planish_plan_destroy(plan);
                }
            free(start);
            free(wanted);
            cell_box_destroy(box);
        }
}

/* ---- options ---------------------------------------------------------------------------------- */

/** Nodes stay within their bounds, and within the distance that they may go. */
static void bounds_hold(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++)
        for (int by_edge = 0; by_edge < 2; by_edge++) {
            cell_box *box = box_of(kind, 4, LINEAR, noise_of(kind), 5);
            const int dim = box->mesh.dim;
            planish_options options = defaults();
            double *x = copy_of(box), farthest = 0;
            judged before = judge(box);
            options.max_displacement = 0.05;
            options.displacement_unit = by_edge ? PLANISH_UNIT_EDGE : PLANISH_UNIT_MESH;
            options.box_upper[0] = 2.5;
            planish_plan *plan = plan_of(box, &options);
            const planish_result result = smooth(plan, box, &options);
            assert_true(result.n_moved_nodes > 0);
            check_kept(box, x, &before);
            for (int64_t i = 0; i < box->mesh.n_nodes; i++) {
                double square = 0;
                for (int d = 0; d < dim; d++)
                    square += pow(box->x[i * dim + d] - x[i * dim + d], 2);
                farthest = fmax(farthest, sqrt(square));
                assert_true(box->x[i * dim] <= 2.5 || is_same_place(box, x, i));
            }
            /* Edges of boxes are 1 long, but for the noise, and those to the apex of pyramids. */
            assert_true(farthest <= (by_edge ? 0.07 : 0.05 * (1 + NOISE)) && farthest > 0.03);
            free(x);
            forget(&before);
            planish_plan_destroy(plan);
            cell_box_destroy(box);
        }
}

/** Volume of an element of a box that has not been shaken. */
static double volume_of(int type) {
    return type == PLANISH_CELL_PYRAMID                                  ? 1.0 / 6
           : type == PLANISH_CELL_WEDGE || type == PLANISH_CELL_TRIANGLE ? 0.5
                                                                         : 1;
}

/** Minimum volumes that most elements have are kept, and brought about where they are not. */
static void minimum_volumes_are_met(void **state) {
    (void)state;
    int n_raised = 0;
    for (int kind = 0; kind < N_BOX_KINDS; kind++) {
        cell_box *box = box_of(kind, 4, LINEAR, noise_of(kind), 6);
        const int64_t n = box->cells.n;
        double *least = malloc((size_t)n * sizeof *least);
        planish_options options = defaults();
        uint8_t *states = malloc((size_t)n);
        int64_t before, after, marked = 0;
        for (int64_t i = 0; i < n; i++)
            least[i] = 0.65 * volume_of(box->type[i]);
        box->mesh.min_volume = least;
        planish_plan *plan = plan_of(box, &options);
        assert_int_equal(planish_check_volumes(plan, box->x, &options, states, &before, NULL, NULL),
                         0);
        for (int64_t i = 0; i < n; i++)
            marked += states[i] != PLANISH_VOLUME_MET;
        assert_int_equal(marked, before);
        const planish_result result = smooth(plan, box, &options);
        assert_int_equal(planish_check_volumes(plan, box->x, &options, states, &after, NULL, NULL),
                         0);
        assert_int_equal(result.n_below_min_volume, after);
        assert_true(after <= before && result.n_inverted == 0);
        n_raised += before > 0 && after == 0;
        free(states);
        free(least);
        planish_plan_destroy(plan);
        cell_box_destroy(box);
    }
    assert_true(n_raised >= 3);
}

/** Whether a node of element i is that node. */
static int has_node(const cell_box *box, int64_t i, int64_t node) {
    int has = 0;
    for (int64_t k = box->offset[i]; k < box->offset[i + 1]; k++)
        has |= box->node[k] == node;
    return has;
}

/** Elements that fixed nodes make impossible are told as such, and why their nodes stay. */
static void infeasible_elements_are_found(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++) {
        cell_box *box = box_of(kind, 4, LINEAR, 0.05, 2);
        const int64_t n = box->cells.n, n_nodes = box->mesh.n_nodes;
        const planish_options options = defaults();
        uint8_t *fixed = calloc((size_t)n_nodes, 1), *is_free = malloc((size_t)n_nodes);
        uint8_t *reason = malloc((size_t)n_nodes), *infeasible = malloc((size_t)n);
        double *ratio = malloc((size_t)n * sizeof *ratio);
        int64_t node = 0, n_infeasible, n_found = 0;
        while (!is_inside(box, box->x, node))
            node++;
        for (int64_t i = 0; i < n; i++)
            for (int64_t k = box->offset[i]; has_node(box, i, node) && k < box->offset[i + 1]; k++)
                fixed[box->node[k]] = PLANISH_CONSTRAINT_FIXED;
        box->x[node * box->mesh.dim] += 1.5;
        box->mesh.constraint = fixed;
        planish_plan *plan = plan_of(box, &options);
        assert_int_equal(planish_measure_elements(plan, box->x, ratio, NULL), 0);
        assert_int_equal(
            planish_find_infeasible(plan, box->x, &options, infeasible, &n_infeasible, NULL, NULL),
            0);
        for (int64_t i = 0; i < n; i++) {
            n_found += infeasible[i];
            assert_true(!infeasible[i] || (has_node(box, i, node) && ratio[i] == 0));
            assert_true(infeasible[i] || ratio[i] > 0 || !has_node(box, i, node));
        }
        assert_true(n_found == n_infeasible && n_found > 0);
        planish_plan_get_free(plan, is_free);
        assert_int_equal(planish_plan_get_held(plan, box->x, reason, NULL), 0);
        for (int64_t i = 0; i < n_nodes; i++) {
            const int on_boundary = !is_inside(box, box->x, i) && i != node;
            int is_used = 0;
            for (int64_t c = 0; c < n; c++)
                is_used |= has_node(box, c, i);
            assert_int_equal(is_free[i], is_used && !on_boundary && !fixed[i]);
            assert_int_equal(reason[i], !is_used ? PLANISH_HELD_UNUSED
                                                 : (on_boundary ? PLANISH_HELD_BOUNDARY : 0) |
                                                       (fixed[i] ? PLANISH_HELD_FIXED : 0));
        }
        free(fixed);
        free(is_free);
        free(reason);
        free(infeasible);
        free(ratio);
        planish_plan_destroy(plan);
        cell_box_destroy(box);
    }
}

/** With only_worse_than nodes of good elements stay. */
static void only_bad_elements_move(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++)
        for (int in_plan = 0; in_plan < 2; in_plan++) {
            cell_box *box = box_of(kind, 5, LINEAR, noise_of(kind), 8);
            planish_options options = defaults();
            double *x = copy_of(box);
            judged before = judge(box);
            uint8_t *is_bad = calloc((size_t)box->mesh.n_nodes, 1);
            const planish_cell_measures *all = &before.quality.all;
            options.only_worse_than = 0.5 * (all->max_aspect_ratio + all->mean_aspect_ratio);
            for (int64_t i = 0; i < box->cells.n; i++)
                for (int64_t k = box->offset[i]; k < box->offset[i + 1]; k++)
                    is_bad[box->node[k]] |= before.ratio[i] > options.only_worse_than;
            planish_plan *plan = plan_of(box, in_plan ? &options : NULL);
            const planish_result result = smooth(plan, box, &options);
            check_kept(box, x, &before);
            assert_true(result.n_moved_nodes > 0 && result.objective < result.objective_before);
            for (int64_t i = 0; in_plan && i < box->mesh.n_nodes; i++)
                assert_true(is_bad[i] || is_same_place(box, x, i));
            free(is_bad);
            free(x);
            forget(&before);
            planish_plan_destroy(plan);
            cell_box_destroy(box);
        }
}

/** The quantities that options.worst may mean go by the elements that there are. */
static void worst_measures_are_checked(void **state) {
    (void)state;
    static const struct {
        int kind;
        planish_worst worst;
        const char *word;
    } cases[] = {{BOX_HEXAHEDRA, PLANISH_WORST_RADIUS_RATIO, "PLANISH_WORST_ASPECT_RATIO"},
                 {BOX_MIXED_2D, PLANISH_WORST_ANGLE, "_SCALED_JACOBIAN"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        cell_box *box = box_of(cases[i].kind, 3, LINEAR, 0.1, 1);
        planish_options options = defaults();
        planish_plan *plan = plan_of(box, &options);
        planish_error error;
        double *x = copy_of(box);
        options.worst = cases[i].worst;
        assert_int_equal(planish_smooth(plan, box->x, &options, NULL, &error),
                         PLANISH_ERROR_ARGUMENT);
        assert_non_null(strstr(error.text, cases[i].word));
        assert_memory_equal(x, box->x, size_of(box));
        free(x);
        planish_plan_destroy(plan);
        cell_box_destroy(box);
    }
    const double x[] = {0, 0, 1, 0, 0, 1, 1, 1};
    const int32_t elements[] = {0, 1, 2, 1, 3, 2};
    double out[8];
    const planish_mesh mesh = {
        .dim = 2, .n_nodes = 4, .n_elements = 2, .coordinates = x, .elements = elements};
    for (planish_worst worst = PLANISH_WORST_ASPECT_RATIO; worst <= PLANISH_WORST_SCALED_JACOBIAN;
         worst++) {
        planish_options options = defaults();
        planish_plan *plan;
        planish_error error;
        options.worst = worst;
        memcpy(out, x, sizeof x);
        assert_int_equal(planish_plan_create(&mesh, &options, &plan, NULL), 0);
        assert_int_equal(planish_smooth(plan, out, &options, NULL, &error), PLANISH_ERROR_ARGUMENT);
        assert_non_null(strstr(error.text, "PLANISH_WORST_RADIUS_RATIO"));
        planish_plan_destroy(plan);
    }
}

/* ---- at any time ------------------------------------------------------------------------------ */

/** Progress that stops after so many calls. */
static int stop_after(const planish_progress *progress, void *user) {
    int *left = user;
    assert_true(progress->rms >= 1 && progress->n_inverted == 0);
    return --*left < 0;
}

/** A call that is stopped after any colour leaves a mesh that is valid and no worse. */
static void calls_stop_at_any_time(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++) {
        cell_box *box = box_of(kind, 4, kind % N_ORDERS, noise_of(kind), 9);
        planish_options options = defaults();
        planish_plan *plan = plan_of(box, &options);
        judged before = judge(box);
        double *x = copy_of(box);
        for (int calls = 0; calls < 40; calls += 3) {
            int left = calls;
            options.progress = stop_after;
            options.progress_user = &left;
            memcpy(box->x, x, size_of(box));
            const planish_result result = smooth(plan, box, &options);
            assert_true(result.stop == PLANISH_STOP_INTERRUPTED || left >= 0);
            check_kept(box, x, &before);
            check_result(box, &result, &before);
        }
        free(x);
        forget(&before);
        planish_plan_destroy(plan);
        cell_box_destroy(box);
    }
}

static int64_t n_allocations;

static void *allocate(size_t bytes, void *user) {
    (void)user;
    n_allocations++;
    return malloc(bytes);
}

static void release(void *block, void *user) {
    (void)user;
    free(block);
}

/** The second of two calls that are alike allocates nothing, and gives the same bits. */
static void repeated_calls_allocate_nothing(void **state) {
    (void)state;
    const planish_allocator allocator = {allocate, release, NULL};
    for (int kind = 0; kind < N_BOX_KINDS; kind++)
        for (int with_options = 0; with_options < 2; with_options++) {
            cell_box *box = box_of(kind, 4, kind % N_ORDERS, noise_of(kind), 10);
            planish_options options = defaults();
            options.allocator = &allocator;
            options.max_displacement = with_options ? 0.3 : 0;
            options.displacement_unit = PLANISH_UNIT_EDGE;
            options.worst = with_options ? PLANISH_WORST_SCALED_JACOBIAN : PLANISH_WORST_NONE;
            planish_plan *plan = plan_of(box, &options);
            double *x = copy_of(box);
            smooth(plan, box, &options);
            double *first = copy_of(box);
            memcpy(box->x, x, size_of(box));
            n_allocations = 0;
            smooth(plan, box, &options);
            assert_int_equal(n_allocations, 0);
            assert_memory_equal(first, box->x, size_of(box));
            free(first);
            free(x);
            planish_plan_destroy(plan);
            cell_box_destroy(box);
        }
}

/* ---- scales ----------------------------------------------------------------------------------- */

/** A mesh that is larger by a power of two is smoothed to the same bits, times that power. */
static void sizes_change_no_bit(void **state) {
    (void)state;
    static const int EXPONENTS[] = {-200, -30, 40, 200};
    for (int kind = 0; kind < N_BOX_KINDS; kind++) {
        cell_box *box = box_of(kind, 4, LINEAR, noise_of(kind), 12);
        const planish_options options = defaults();
        double *x = copy_of(box);
        planish_plan *plan = plan_of(box, &options);
        smooth(plan, box, &options);
        double *wanted = copy_of(box);
        planish_plan_destroy(plan);
        for (size_t k = 0; k < sizeof EXPONENTS / sizeof *EXPONENTS; k++) {
            for (int64_t i = 0; i < box->mesh.n_nodes * box->mesh.dim; i++)
                box->x[i] = ldexp(x[i], EXPONENTS[k]);
            plan = plan_of(box, &options);
            smooth(plan, box, &options);
            planish_plan_destroy(plan);
            for (int64_t i = 0; i < box->mesh.n_nodes * box->mesh.dim; i++)
                assert_true(box->x[i] == ldexp(wanted[i], EXPONENTS[k]));
        }
        free(wanted);
        free(x);
        cell_box_destroy(box);
    }
}

/** What the log tells of help: Newton's steps on a lattice, or others. */
typedef struct help {
    int lattice, others;
} help;

static void note_help(planish_log_level level, const char *text, void *user) {
    help *told = user;
    (void)level;
    told->lattice += strstr(text, "Newton's steps") != NULL;
    told->others += strstr(text, "sweeps are slow") != NULL;
}

/** Smooth a grid of n cells along each edge that is bent as a whole; it becomes regular. */
static help straighten(cell_box_kind kind, int n) {
    cell_box *box = box_of((int)kind, n, LINEAR, 0, 1);
    const int dim = box->mesh.dim;
    planish_options options = defaults();
    help told = {0, 0};
    options.log = note_help;
    options.log_user = &told;
    for (int64_t i = 0; i < box->mesh.n_nodes; i++) {
        double *x = box->x + i * dim, bend = dim == 3 ? 0.2 : 0.23;
        for (int d = 0; d < dim; d++)
            bend *= 4 * x[d] / n * (1 - x[d] / n);
        for (int d = 0; d < dim; d++)
            x[d] += bend * n * (d == 0 ? 1 : -0.6);
    }
    judged before = judge(box);
    double *x = copy_of(box);
    planish_plan *plan = plan_of(box, &options);
    const planish_result result = smooth(plan, box, &options);
    assert_int_equal(result.stop, PLANISH_STOP_CONVERGED);
    assert_true(result.objective_before > 1.05 && result.objective < 1.0001);
    check_kept(box, x, &before);
    free(x);
    forget(&before);
    planish_plan_destroy(plan);
    cell_box_destroy(box);
    return told;
}

/** Grids that are bent as a whole become regular: sweeps are helped (improve/coarse.c, and where there are
 *  few nodes slow.c). */
static void slow_meshes_are_helped(void **state) {
    (void)state;
    assert_true(straighten(BOX_HEXAHEDRA, 20).lattice > 0);
    assert_true(straighten(BOX_QUADRILATERALS, 70).lattice > 0);
    assert_true(straighten(BOX_QUADRILATERALS, 22).others > 0);
}

/* ---- drawn calls ------------------------------------------------------------------------------ */

/** A call that is drawn. Arrays are owned. */
typedef struct drawn {
    cell_box *box;
    planish_options options;
    int options_in_plan; /* the plan is made with them, not with defaults */
    uint8_t *constraint;
    double *direction, *least;
    int64_t around; /* the node of options.n_around, which is 1 or 0 */
} drawn;

static int draw(uint64_t *random, double chance) {
    return random_unit(random) < chance;
}

static void draw_options(drawn *c, uint64_t *random) {
    planish_options *o = &c->options;
    const int dim = c->box->mesh.dim;
    *o = defaults();
    o->max_sweeps = draw(random, 0.3) ? (int)random_below(random, 6) : 200;
    o->objective = (planish_objective)(draw(random, 0.4) ? random_below(random, 3) : 0);
    o->search = (planish_search)draw(random, 0.1);
    if (draw(random, 0.1)) {
        o->method = (planish_method)random_below(random, 4);
    } else if (draw(random, 0.2)) {
        o->worst = draw(random, 0.5) ? PLANISH_WORST_ASPECT_RATIO : PLANISH_WORST_SCALED_JACOBIAN;
        o->worst_rise = random_unit(random) * 0.1;
    }
    if (o->method != PLANISH_METHOD_PLANISH)
        o->worst = PLANISH_WORST_NONE;
    o->untangle = draw(random, 0.85);
    if (draw(random, 0.2)) {
        o->max_displacement = random_between(random, 0.01, 0.6);
        o->displacement_unit = (planish_length_unit)draw(random, 0.5);
    }
    for (int d = 0; d < dim && draw(random, 0.2); d++)
        o->box_upper[d] = random_between(random, 2, 4);
    if (draw(random, 0.2))
        o->min_volume_fraction = random_between(random, 1e-5, 0.01);
    o->area_weight = o->min_volume_fraction > 0 && draw(random, 0.3) ? random_unit(random) : 0;
    o->only_worse_than = draw(random, 0.25) ? random_between(random, 1, 1.4) : 0;
    o->rings = (int)random_below(random, 3);
    c->options_in_plan = draw(random, 0.5);
    if (c->options_in_plan && !(o->only_worse_than > 0) && !(o->min_volume_fraction > 0) &&
        draw(random, 0.3)) {
        c->around = c->box->node[random_below(random, c->box->offset[c->box->cells.n])];
        o->n_around = 1;
    }
}

static drawn draw_call(uint64_t seed) {
    uint64_t random = effort_seed(seed);
    drawn c = {.around = 0};
    const int kind = (int)random_below(&random, N_BOX_KINDS), n = 2 + (int)random_below(&random, 3);
    const int order = draw(&random, 0.3) ? 1 + (int)random_below(&random, 2) : LINEAR;
    const double shake = draw(&random, 0.3) ? random_between(&random, 0.2, 0.7)
                                            : noise_of(kind) * random_unit(&random);
    c.box = box_of(kind, n, order, shake, random_bits(&random));
    const int64_t n_nodes = c.box->mesh.n_nodes, n_cells = c.box->cells.n;
    draw_options(&c, &random);
    c.constraint = calloc((size_t)n_nodes, 1);
    c.direction = calloc((size_t)(n_nodes * 3), sizeof *c.direction);
    c.least = calloc((size_t)n_cells, sizeof *c.least);
    for (int64_t i = 0; i < n_nodes; i++)
        c.constraint[i] = draw(&random, 0.05) ? PLANISH_CONSTRAINT_FIXED : 0;
    if (draw(&random, 0.5)) {
        c.box->mesh.constraint = c.constraint;
        if (draw(&random, 0.7))
            assert_int_equal(
                planish_find_slides(&c.box->mesh, NULL, 1, c.constraint, c.direction, NULL, NULL),
                0);
        c.box->mesh.direction = c.direction;
    }
    for (int64_t i = 0; i < n_cells; i++)
        c.least[i] = draw(&random, 0.3) ? random_unit(&random) * volume_of(c.box->type[i]) : 0;
    if (draw(&random, 0.15))
        c.box->mesh.min_volume = c.least;
    c.options.precision = draw(&random, 0.15) ? PLANISH_PRECISION_FLOAT : PLANISH_PRECISION_DOUBLE;
    for (int64_t i = 0; c.options.precision && i < n_nodes * c.box->mesh.dim; i++)
        c.box->x[i] = (float)c.box->x[i];
    return c;
}

static void release_call(drawn *c) {
    cell_box_destroy(c->box);
    free(c->constraint);
    free(c->direction);
    free(c->least);
}

/** Check what a call has made of x; returns whether anything moved. */
static void check_call(const drawn *c, const double *x, const judged *before,
                       const planish_result *r, int64_t n_below) {
    const cell_box *box = c->box;
    const planish_options *o = &c->options;
    judged after = judge(box);
    const planish_cell_measures *was = &before->quality.all, *is = &after.quality.all;
    const int was_valid = was->n_inverted + was->n_uncertified == 0;
    const int has_volumes = o->min_volume_fraction > 0 || box->mesh.min_volume;
    for (int64_t i = 0; i < box->mesh.n_nodes; i++)
        if (c->box->mesh.constraint && c->constraint[i] == PLANISH_CONSTRAINT_FIXED)
            assert_true(is_same_place(box, x, i));
    if (o->method == PLANISH_METHOD_PLANISH) {
        assert_true(is->n_inverted + is->n_uncertified <= was->n_inverted + was->n_uncertified);
        for (int64_t i = 0; i < box->cells.n; i++)
            assert_true(was->n_inverted > 0 || before->state[i] != PLANISH_CELL_STATE_VALID ||
                        after.state[i] == PLANISH_CELL_STATE_VALID);
        assert_true(r->n_below_min_volume <= n_below || !was_valid);
    }
    if (o->method == PLANISH_METHOD_PLANISH && was_valid && n_below == 0) {
        const double rise = r->worst_sweeps > 0 ? 1 + o->worst_rise : 1;
        assert_true(r->objective <= r->objective_before * rise * (1 + NOISE));
        if (o->objective != PLANISH_OBJECTIVE_EDGE_RATIO && !(o->area_weight > 0)) {
            assert_true(is->max_aspect_ratio <= was->max_aspect_ratio * (1 + NOISE));
            assert_true(is->min_scaled_jacobian >= was->min_scaled_jacobian * (1 - NOISE));
        }
    }
    if (!has_volumes)
        assert_int_equal(r->n_below_min_volume, 0);
    forget(&after);
}

/** Calls that are drawn keep their promises, with the same bits on any threads and kernels. */
static void drawn_calls_keep_promises(void **state) {
    (void)state;
    int64_t n = 0;
    const int64_t most = effort(120, 20000);
    for (uint64_t seed = 0; n < most; seed++, n++) {

        drawn c = draw_call(seed);
        double *x = copy_of(c.box);
        c.options.around = c.options.n_around > 0 ? &c.around : NULL;
        judged before = judge(c.box);
        planish_plan *plan = plan_of(c.box, c.options_in_plan ? &c.options : NULL);
        planish_options options = c.options;
        int64_t n_below = 0;
        planish_error error;
        planish_result result;
        options.n_around = 0;
        options.around = NULL;
        assert_int_equal(planish_check_volumes(plan, x, &options, NULL, &n_below, NULL, NULL), 0);
        const int status = planish_smooth(plan, c.box->x, &options, &result, &error);
        if (status == PLANISH_ERROR_ARGUMENT && options.area_weight > 0) {
            planish_plan_destroy(plan); /* volumes far from their minimum */
        } else {
            assert_int_equal(status, 0);
            check_call(&c, x, &before, &result, n_below);
            double *first = copy_of(c.box);
            planish_plan_destroy(plan);
            memcpy(c.box->x, x, size_of(c.box));
            c.options.threads = options.threads = 3;
            c.options.isa = options.isa = PLANISH_ISA_PLAIN;
            plan = plan_of(c.box, c.options_in_plan ? &c.options : NULL);
            smooth(plan, c.box, &options);
            assert_memory_equal(first, c.box->x, size_of(c.box));
            planish_plan_destroy(plan);
            free(first);
        }
        free(x);
        forget(&before);
        release_call(&c);
    }
    figure("%d drawn calls on meshes of every type", (int)n);
}

/** The corner of a box stays, also if its element is there twice: then each of its facets is of two. */
static void duplicates_stay(void **state) {
    static const int kinds[] = {BOX_QUADRILATERALS, BOX_HEXAHEDRA};
    (void)state;
    for (int k = 0; k < 2; k++) {
        const planish_options options = defaults();
        cell_box *box = box_of(kinds[k], 3, LINEAR, 0.2, 1);
        const int64_t n = box->cells.n, each = box->offset[1];
        int32_t *node = malloc((size_t)(each * (n + 1)) * sizeof *node), *own = box->node;
        int64_t *offset = malloc((size_t)(n + 2) * sizeof *offset);
        uint8_t *type = malloc((size_t)(n + 1)), *reason = malloc((size_t)box->mesh.n_nodes);
        assert_true(node && offset && type && reason);
        memcpy(node, own, (size_t)(each * n) * sizeof *node);
        memcpy(node + each * n, own, (size_t)each * sizeof *node);
        memset(type, box->type[0], (size_t)(n + 1));
        for (int64_t i = 0; i <= n + 1; i++)
            offset[i] = i * each;
        const planish_cells cells = {.n = n + 1, .type = type, .offset = offset, .node = node};
        box->mesh.cells = &cells;
        box->mesh.n_elements = n + 1;
        planish_plan *plan = plan_of(box, &options);
        planish_plan_info info;
        planish_plan_get_info(plan, &info);
        assert_int_equal(info.n_duplicate_elements, 1);
        assert_int_equal(planish_plan_get_held(plan, box->x, reason, NULL), 0);
        double *x = copy_of(box);
        smooth(plan, box, &options);
        for (int64_t i = 0; i < box->mesh.n_nodes; i++)
            assert_true(is_same_place(box, x, i) || is_inside(box, x, i));
        for (int64_t i = 0; i < each; i++) {
            assert_true(is_same_place(box, x, node[i]));
            assert_true(reason[node[i]] & PLANISH_HELD_NONMANIFOLD);
        }
        planish_plan_destroy(plan);
        free(x);
        free(node);
        free(offset);
        free(type);
        free(reason);
        cell_box_destroy(box);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(measures_agree),
        cmocka_unit_test(mirrored_elements_are_reversed),
        cmocka_unit_test(boxes_become_better),
        cmocka_unit_test(objectives_fall),
        cmocka_unit_test(threads_and_kernels_change_no_bit),
        cmocka_unit_test(bounds_hold),
        cmocka_unit_test(minimum_volumes_are_met),
        cmocka_unit_test(infeasible_elements_are_found),
        cmocka_unit_test(only_bad_elements_move),
        cmocka_unit_test(worst_measures_are_checked),
        cmocka_unit_test(calls_stop_at_any_time),
        cmocka_unit_test(repeated_calls_allocate_nothing),
        cmocka_unit_test(sizes_change_no_bit),
        cmocka_unit_test(slow_meshes_are_helped),
        cmocka_unit_test(drawn_calls_keep_promises),
        cmocka_unit_test(duplicates_stay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
