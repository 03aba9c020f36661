/* A mesh that several processes have: the same bits as in one. */
#include "support/allocations.h"
#include "support/effort.h"
#include "support/meshes.h"
#include "support/processes.h"
#include "support/snapshots.h"

#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- ways to smooth ------------------------------------------------------------------------- */

typedef struct way {
    const char *name;
    planish_options options;
} way;

enum {
    PLAIN,
    FLETCHER_REEVES,
    MEAN_RATIO,
    EDGE_RATIO,
    MIN_VOLUME,
    WEIGHT,
    BOUNDS,
    NEAR,
    FLOAT,
    LAPLACIAN,
    FEW_SWEEPS,
    WORST_RATIO,
    WORST_SMALLEST,
    BAD,
    VERY_BAD,
    BAD_OR_BELOW,
    N_WAYS
};

static const char *const names[] = {
    "plain",       "fletcher-reeves", "mean-ratio",  "edge-ratio", "min-volume",
    "weight",      "bounds",          "near",        "float",      "laplacian",
    "few-sweeps",  "worst ratio",     "worst angle", "bad",        "very bad",
    "bad or below"};

static planish_options options_of(int which) {
    planish_options o;
    planish_options_init(&o);
    o.threads = 1;
    switch (which) {
    case FLETCHER_REEVES:
        o.search = PLANISH_SEARCH_FLETCHER_REEVES;
        break;
    case MEAN_RATIO:
        o.objective = PLANISH_OBJECTIVE_MEAN_RATIO;
        break;
    case EDGE_RATIO:
        o.objective = PLANISH_OBJECTIVE_EDGE_RATIO;
        break;
    case MIN_VOLUME:
        o.min_volume = 0.12;
        break;
    case WEIGHT:
        o.min_volume = 0.1;
        o.area_weight = 0.3;
        break;
    case BOUNDS:
        for (int d = 0; d < 3; d++) {
            o.box_lower[d] = 1.03;
            o.box_upper[d] = 4.01;
        }
        break;
    case NEAR:
        o.max_displacement = 0.03;
        break;
    case FLOAT:
        o.precision = PLANISH_PRECISION_FLOAT;
        break;
    case LAPLACIAN:
        o.method = PLANISH_METHOD_LAPLACIAN;
        break;
    case FEW_SWEEPS:
        o.max_sweeps = 2;
        break;
    case WORST_RATIO:
        o.worst = PLANISH_WORST_RADIUS_RATIO;
        break;
    case WORST_SMALLEST:
        o.worst = PLANISH_WORST_ANGLE;
        break;
    case BAD:
        o.only_worse_than = 1.5;
        break;
    case VERY_BAD: /* so few that one process does not look at the others */
        o.only_worse_than = 2.2;
        o.rings = 0;
        break;
    case BAD_OR_BELOW:
        o.only_worse_than = 1.8;
        o.min_volume_fraction = 0.5;
        break;
    default:
        break;
    }
    return o;
}

/* ---- alone and together --------------------------------------------------------------------- */

typedef struct outcome {
    int status, is_smoothed;
    int is_overwritten; /* measuring failed, and has changed what it was to fill */
    planish_result result;
    planish_plan_info info;
    planish_quality quality;
    int64_t n_below;
    planish_error error;
} outcome;

/** Measure coordinates; see whether a failure changes anything. */
static void measure(const planish_mesh *mesh, const planish_plan *plan, const double *coordinates,
                    outcome *o) {
    double *ratio = malloc((size_t)mesh->n_elements * sizeof *ratio);
    o->quality = (planish_quality){.n_inverted = -7};
    for (int64_t i = 0; i < mesh->n_elements; i++)
        ratio[i] = -7;
    o->status = planish_measure_elements(plan, coordinates, ratio, &o->error);
    for (int64_t i = 0; o->status && i < mesh->n_elements; i++)
        o->is_overwritten |= ratio[i] != -7;
    if (!o->status)
        o->status = planish_measure(plan, coordinates, &o->quality, &o->error);
    o->is_overwritten |= o->status && o->quality.n_inverted != -7;
    free(ratio);
}

/** Plan mesh, and smooth coordinates; if start (of the whole mesh, in which the nodes have these
 *  numbers, NULL: their own) is not NULL from there. */
static outcome smooth(const planish_mesh *mesh, const planish_options *options, const double *start,
                      const int64_t *node_number, double *coordinates) {
    planish_plan *plan = NULL;
    outcome o = {.status = planish_plan_create(mesh, options, &plan, &o.error)};
    if (!o.status) {
        planish_plan_get_info(plan, &o.info);
        for (int64_t i = 0; start && i < mesh->n_nodes; i++)
            memcpy(coordinates + i * mesh->dim,
                   start + (node_number ? node_number[i] : i) * mesh->dim,
                   (size_t)mesh->dim * sizeof *coordinates);
        o.status = planish_smooth(plan, coordinates, options, &o.result, &o.error);
    }
    o.is_smoothed = !o.status;
    if (o.is_smoothed)
        measure(mesh, plan, coordinates, &o);
    if (!o.status)
        o.status =
            planish_check_volumes(plan, coordinates, options, NULL, &o.n_below, NULL, &o.error);
    planish_plan_destroy(plan);
    return o;
}

typedef struct job {
    const planish_options *options;
    const double *start; /* as in smooth */
    outcome outcome[8];
} job;

static void smooth_part(process *part, void *user) {
    job *j = user;
    j->outcome[part->rank] =
        smooth(&part->mesh, j->options, j->start, part->node_number, part->coordinates);
}

static void assert_same(double a, double b) {
    assert_memory_equal(&a, &b, sizeof a);
}

static void assert_same_result(const planish_result *a, const planish_result *b) {
    assert_int_equal(a->stop, b->stop);
    assert_int_equal(a->sweeps, b->sweeps);
    assert_int_equal(a->visits, b->visits);
    assert_int_equal(a->evaluations, b->evaluations);
    assert_int_equal(a->n_moved_nodes, b->n_moved_nodes);
    assert_int_equal(a->n_inverted, b->n_inverted);
    assert_int_equal(a->n_below_min_volume, b->n_below_min_volume);
    assert_int_equal(a->n_held_outside, b->n_held_outside);
    assert_int_equal(a->n_active, b->n_active);
    assert_int_equal(a->worst_sweeps, b->worst_sweeps);
    assert_same(a->worst_before, b->worst_before);
    assert_same(a->worst_after, b->worst_after);
    assert_same(a->objective_of_worst, b->objective_of_worst);
    assert_same(a->rms, b->rms);
    assert_same(a->rms_movable, b->rms_movable);
    assert_same(a->objective, b->objective);
    assert_same(a->objective_before, b->objective_before);
    assert_same(a->max_displacement, b->max_displacement);
    assert_same(a->min_volume, b->min_volume);
    if (a->kkt_residual == a->kkt_residual) {
        assert_same(a->kkt_residual, b->kkt_residual);
        assert_same(a->kkt_rms, b->kkt_rms);
    }
}

static void assert_same_info(const planish_plan_info *a, const planish_plan_info *b) {
    assert_int_equal(a->n_free, b->n_free);
    assert_int_equal(a->n_sliding, b->n_sliding);
    assert_int_equal(a->n_fixed_elements, b->n_fixed_elements);
    assert_int_equal(a->n_colours, b->n_colours);
    assert_int_equal(a->n_boundary_facets, b->n_boundary_facets);
    assert_int_equal(a->n_nonmanifold_facets, b->n_nonmanifold_facets);
    assert_int_equal(a->n_duplicate_elements, b->n_duplicate_elements);
    assert_int_equal(a->n_negative_order, b->n_negative_order);
    assert_int_equal(a->n_components, b->n_components);
    assert_int_equal(a->n_unused, b->n_unused);
}

static int is_near(double a, double b) {
    return fabs(a - b) <= 1e-14 * fabs(b);
}

/** Means are sums of the processes' sums: they may differ by rounding. */
static void assert_same_quality(const planish_quality *a, const planish_quality *b) {
    assert_int_equal(a->n_elements, b->n_elements);
    assert_int_equal(a->n_inverted, b->n_inverted);
    assert_int_equal(a->n_reversed, b->n_reversed);
    assert_int_equal(a->n_fixed_elements, b->n_fixed_elements);
    assert_same(a->rms_radius_ratio, b->rms_radius_ratio);
    assert_same(a->rms_radius_ratio_movable, b->rms_radius_ratio_movable);
    assert_same(a->max_radius_ratio, b->max_radius_ratio);
    assert_same(a->min_angle_deg, b->min_angle_deg);
    assert_same(a->max_angle_deg, b->max_angle_deg);
    assert_same(a->min_volume, b->min_volume);
    assert_same(a->max_volume, b->max_volume);
    assert_same(a->edge_ratio.min, b->edge_ratio.min);
    assert_same(a->edge_ratio.max, b->edge_ratio.max);
    assert_memory_equal(a->histogram_counts, b->histogram_counts, sizeof a->histogram_counts);
    assert_memory_equal(a->angle_counts, b->angle_counts, sizeof a->angle_counts);
    assert_true(is_near(a->mean_radius_ratio, b->mean_radius_ratio));
    assert_true(is_near(a->total_volume, b->total_volume));
}

/** Elements a and b are one, or equally bad at x. */
static void assert_as_bad(const planish_mesh *mesh, const double *x, int64_t a, int64_t b) {
    planish_plan *plan;
    if (a == b)
        return;
    double *ratio = malloc((size_t)mesh->n_elements * sizeof *ratio);
    assert_int_equal(planish_plan_create(mesh, NULL, &plan, NULL), 0);
    assert_int_equal(planish_measure_elements(plan, x, ratio, NULL), 0);
    assert_same(ratio[a], ratio[b]);
    planish_plan_destroy(plan);
    free(ratio);
}

/** Smooth mesh (from start, if that is not NULL) in one process, and in n that own its nodes as
 * owner says. Returns what one comes to. */
static outcome compare_from(const planish_mesh *mesh, const double *start,
                            const planish_options *options, int n, const int *owner) {
    const size_t values = (size_t)mesh->n_nodes * (size_t)mesh->dim;
    double *alone = malloc(values * sizeof *alone), *together = malloc(values * sizeof *together);
    processes w;
    job j = {.options = options, .start = start};
    memcpy(alone, mesh->coordinates, values * sizeof *alone);
    const outcome expected = smooth(mesh, options, start, NULL, alone);
    int n_worst = 0; /* processes that have the worst element */
    assert_int_equal(expected.status, 0);
    processes_create(&w, mesh, n, owner);
    processes_run(&w, smooth_part, &j);
    for (int k = 0; k < n; k++) {
        if (j.outcome[k].status)
            fail_msg("process %d: %s", k, j.outcome[k].error.text);
        assert_same_info(&j.outcome[k].info, &expected.info);
        assert_same_result(&j.outcome[k].result, &expected.result);
        assert_same_quality(&j.outcome[k].quality, &expected.quality);
        const int64_t worst = j.outcome[k].quality.worst_element;
        if (worst >= 0) {
            assert_true(w.parts[k].is_counted[worst]);
            assert_as_bad(mesh, alone, w.parts[k].element_number[worst],
                          expected.quality.worst_element);
            n_worst++;
        }
    }
    assert_int_equal(n_worst > 0, expected.quality.worst_element >= 0);
    processes_gather(&w, mesh->dim, together);
    assert_memory_equal(together, alone, values * sizeof *alone);
    processes_destroy(&w);
    free(alone);
    free(together);
    return expected;
}

static void compare(const planish_mesh *mesh, const planish_options *options, int n,
                    const int *owner) {
    compare_from(mesh, NULL, options, n, owner);
}

/* ---- who owns what -------------------------------------------------------------------------- */

/** All ways, with the boundary held and sliding. */
static void check(test_mesh *m, int n, int owning, uint64_t seed) {
    const size_t nodes = (size_t)m->mesh.n_nodes;
    int *owner = malloc(nodes * sizeof *owner);
    uint8_t *constraint = malloc(nodes);
    double *direction = calloc(3 * nodes, sizeof *direction);
    planish_mesh slides = m->mesh;
    processes_own(&m->mesh, owning, n, seed, owner);
    assert_int_equal(planish_find_slides(&m->mesh, NULL, 1, constraint, direction, NULL, NULL), 0);
    slides.constraint = constraint;
    slides.direction = direction;
    for (int i = n % effort_step(3); i < N_WAYS; i += effort_step(3)) {
        const planish_options options = options_of(i);
        print_message("%d-D, %d processes, owning %d: %s\n", m->mesh.dim, n, owning, names[i]);
        compare(&m->mesh, &options, n, owner);
        compare(&slides, &options, n, owner);
    }
    free(constraint);
    free(direction);
    free(owner);
}

static void the_bits_are_those_of_one_process(void **state) {
    static const struct {
        int n, owning;
    } cases[] = {{1, SLABS}, {2, SLABS},     {2, SCATTERED}, {2, ONE_HAS_ALL},
                 {3, SLABS}, {3, SCATTERED}, {4, SCATTERED}};
    const int dim = *(int *)*state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const int n = cases[k].n, owning = cases[k].owning;
        test_mesh m;
        test_mesh_box(&m, dim, dim == 3 ? 5 : 9);
        test_mesh_perturb(&m, 0.14, (unsigned)(n + 10 * owning));
        if (owning == SCATTERED)
            test_mesh_renumber(&m, (unsigned)n, NULL);
        check(&m, n, owning, (uint64_t)n);
        test_mesh_destroy(&m);
    }
}

/** Each process may have several threads, and enough nodes for all of them. */
static void threads_do_not_change_them(void **state) {
    (void)state;
    const int owning[] = {SLABS, SCATTERED};
    planish_options options = options_of(FEW_SWEEPS);
    options.threads = 3;
    for (int k = 0; k < 2; k++) {
        test_mesh m;
        test_mesh_box(&m, 3, 17);
        test_mesh_perturb(&m, 0.14, 3);
        int *owner = malloc((size_t)m.mesh.n_nodes * sizeof *owner);
        processes_own(&m.mesh, owning[k], 2, 1, owner);
        compare(&m.mesh, &options, 2, owner);
        free(owner);
        test_mesh_destroy(&m);
    }
}

/* ---- patches of several processes ----------------------------------------------------------- */

enum { N_PATCH_WAYS = 8 };

/** Options for the worst elements, with all that a gathered star brings along. */
static planish_options options_of_patches(int which) {
    planish_options o = options_of(which % 2 ? WORST_RATIO : WORST_SMALLEST);
    o.worst_rise = 10;
    if (which / 2 == 1)
        o.max_displacement = 0.2;
    for (int d = 0; which / 2 == 2 && d < 3; d++) {
        o.box_lower[d] = 0.9;
        o.box_upper[d] = 3.2;
    }
    if (which / 2 == 3)
        o.min_volume = 0.09;
    return o;
}

/** Patches whose nodes belong to several processes are those of one process, and so are their steps,
 *  with bounds, minimum volumes and nodes that slide. */
static void patches_cross_processes(void **state) {
    const int dim = *(int *)*state;
    int n_improved = 0;
    for (int which = 0; which < N_PATCH_WAYS; which++)
        for (int slides = 0; slides < 2; slides++) {
            const planish_options options = options_of_patches(which);
            test_mesh m;
            int owner[1000];
            uint8_t constraint[1000];
            double direction[3000] = {0};
            test_mesh_box(&m, dim, dim == 3 ? 4 : 8);
            test_mesh_perturb(&m, 0.14, (unsigned)which + 1);
            processes_own(&m.mesh, SCATTERED, 3, (uint64_t)which, owner);
            planish_mesh mesh = m.mesh;
            assert_int_equal(planish_find_slides(&mesh, NULL, 1, constraint, direction, NULL, NULL),
                             0);
            mesh.constraint = slides ? constraint : NULL;
            mesh.direction = slides ? direction : NULL;
            const outcome o = compare_from(&mesh, NULL, &options, 3, owner);
            n_improved += o.result.worst_after != o.result.worst_before;
            test_mesh_destroy(&m);
        }
    assert_true(n_improved >= N_PATCH_WAYS);
}

/** Processes that take snapshots. */
typedef struct snapshot_job {
    const planish_options *options;
    snapshots taken[3];
} snapshot_job;

static void take_in_part(process *part, void *user) {
    snapshot_job *j = user;
    planish_options options = *j->options;
    options.progress = snapshots_take;
    options.progress_user = &j->taken[part->rank];
    assert_int_equal(
        smooth(&part->mesh, &options, NULL, part->node_number, part->coordinates).status, 0);
}

/** In each snapshot the nodes that a process moves are where they are in one process. */
static void snapshots_are_those_of_one_process(void **state) {
    const int dim = *(int *)*state, ways[] = {PLAIN, WORST_RATIO, FEW_SWEEPS};
    test_mesh m;
    int owner[1000];
    test_mesh_box(&m, dim, dim == 3 ? 5 : 12);
    test_mesh_perturb(&m, 0.14, 5);
    processes_own(&m.mesh, SCATTERED, 3, 0, owner);
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        planish_options options = options_of(ways[i]), alone = options;
        const size_t length = (size_t)(m.mesh.n_nodes * dim);
        double *x = malloc(length * sizeof *x);
        processes w;
        snapshot_job j = {.options = &options};
        memcpy(x, m.coordinates, length * sizeof *x);
        snapshots one = snapshots_begin(x, length);
        alone.progress = snapshots_take;
        alone.progress_user = &one;
        assert_int_equal(smooth(&m.mesh, &alone, NULL, NULL, x).status, 0);
        processes_create(&w, &m.mesh, 3, owner);
        for (int k = 0; k < 3; k++)
            j.taken[k] =
                snapshots_begin(w.parts[k].coordinates, (size_t)(w.parts[k].mesh.n_nodes * dim));
        processes_run(&w, take_in_part, &j);
        for (int k = 0; k < 3; k++) {
            const process *part = &w.parts[k];
            assert_true(j.taken[k].n == one.n && one.n > 1);
            for (int sweep = 0; sweep < one.n; sweep++)
                for (int64_t node = 0; node < part->mesh.n_nodes; node++)
                    if (part->node_role[node] != PLANISH_ROLE_GHOST)
                        assert_memory_equal(j.taken[k].x[sweep] + node * dim,
                                            one.x[sweep] + part->node_number[node] * dim,
                                            (size_t)dim * sizeof *x);
            snapshots_free(&j.taken[k]);
        }
        processes_destroy(&w);
        snapshots_free(&one);
        free(x);
    }
    test_mesh_destroy(&m);
}

/** Allocations that succeed after a sweep of smoothing, before one fails. */
static int64_t permitted;

static int fail_later(const planish_progress *progress, void *user) {
    (void)user;
    if (progress->phase == PLANISH_PHASE_SMOOTH && progress->sweep_done)
        allocations_fail_one(permitted);
    return 0;
}

/** One process lacks memory once while it improves the worst elements: every call ends, and where none fails
 *  the mesh is as good as is promised. */
static void without_memory_for_patches_all_end(void **state) {
    const int dim = *(int *)*state;
    test_mesh m;
    int owner[1000], n_failed = 0, n_fine = 0;
    planish_options options = options_of(WORST_SMALLEST);
    options.progress = fail_later;
    test_mesh_box(&m, dim, dim == 3 ? 3 : 5);
    test_mesh_perturb(&m, 0.14, 5);
    processes_own(&m.mesh, SCATTERED, 3, 0, owner);
    int has_failed = 1;
    for (permitted = 0; has_failed; permitted += effort_step(3)) {
        processes w;
        job j = {.options = &options};
        processes_create(&w, &m.mesh, 3, owner);
        processes_run(&w, smooth_part, &j);
        has_failed = allocations_failed();
        for (int k = 0; k < 3; k++) {
            const outcome *o = &j.outcome[k];
            assert_true(o->status == PLANISH_OK || o->status == PLANISH_ERROR_MEMORY ||
                        o->status == PLANISH_ERROR_PROCESS);
            assert_true(has_failed || o->status == PLANISH_OK);
            n_failed += o->status != PLANISH_OK;
            n_fine += has_failed && o->status == PLANISH_OK;
            if (o->status == PLANISH_OK)
                assert_true(o->quality.n_inverted == 0 &&
                            o->result.worst_after >= o->result.worst_before);
        }
        processes_destroy(&w);
    }
    figure("%d calls failed, %d went on without", n_failed, n_fine);
    assert_true(n_fine > 0);
    test_mesh_destroy(&m);
}

/** Steps of the whole mesh (improve/coarse.c) are those of one process. */
static void slow_meshes_are_helped_together(void **state) {
    static const struct {
        int n, owning, threads, dim;
    } cases[] = {{2, SLABS, 1, 3},
                 {3, SCATTERED, 2, 2},
                 {3, SCATTERED, 2, 3},
                 {2, ONE_HAS_ALL, 1, 3},
                 {2, SLABS, 1, 2}};
    planish_options options = options_of(PLAIN);
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k += (size_t)effort_step(2)) {
        test_mesh m;
        test_mesh_squeezed_box(&m, cases[k].dim, cases[k].dim == 3 ? 12 : 30);
        int *owner = malloc((size_t)m.mesh.n_nodes * sizeof *owner);
        processes_own(&m.mesh, cases[k].owning, cases[k].n, 1, owner);
        options.threads = cases[k].threads;
        compare(&m.mesh, &options, cases[k].n, owner);
        free(owner);
        test_mesh_destroy(&m);
    }
}

/** So they are where nodes slide: the box is drawn to a corner, with its surface. */
static void slow_meshes_slide_together(void **state) {
    const int dim = *(int *)*state, cells = dim == 3 ? 12 : 30;
    const planish_options options = options_of(PLAIN);
    test_mesh m;
    test_mesh_box(&m, dim, cells);
    for (int64_t i = 0; i < m.mesh.n_nodes * dim; i++)
        m.coordinates[i] = cells * pow(m.coordinates[i] / cells, 1.5);
    uint8_t *constraint = malloc((size_t)m.mesh.n_nodes);
    double *direction = malloc((size_t)(m.mesh.n_nodes * dim) * sizeof *direction);
    int *owner = malloc((size_t)m.mesh.n_nodes * sizeof *owner);
    planish_mesh slides = m.mesh;
    assert_int_equal(planish_find_slides(&m.mesh, NULL, 1, constraint, direction, NULL, NULL), 0);
    slides.constraint = constraint;
    slides.direction = direction;
    processes_own(&slides, SCATTERED, 3, 1, owner);
    compare(&slides, &options, 3, owner);
    free(constraint);
    free(direction);
    free(owner);
    test_mesh_destroy(&m);
}

/* ---- what is wrong --------------------------------------------------------------------------- */

/** One of the calls for others fails, the one of this number: the call fails in all processes, none
 *  waits, and no node has moved if it is planish_smooth's. Returns 0 if there are not so many calls;
 *  *n_later: counts processes that had smoothed. */
static int lose_at(int call, const test_mesh *m, const planish_options *options, int n,
                   const int *owner, int *n_later) {
    const int dim = m->mesh.dim;
    processes w;
    job j = {.options = options};
    processes_create(&w, &m->mesh, n, owner);
    w.fails_at = call;
    processes_run(&w, smooth_part, &j);
    const int is_reached = w.fails_at < 0, status = j.outcome[0].status;
    for (int k = 0; k < n; k++) {
        assert_int_equal(j.outcome[k].status, status);
        assert_int_equal(j.outcome[k].is_smoothed, j.outcome[0].is_smoothed);
        assert_false(j.outcome[k].is_overwritten);
        *n_later += j.outcome[k].is_smoothed && status;
        for (int64_t i = 0; !j.outcome[k].is_smoothed && i < w.parts[k].mesh.n_nodes * dim; i++)
            assert_true(w.parts[k].coordinates[i] ==
                        m->coordinates[w.parts[k].node_number[i / dim] * dim + i % dim]);
    }
    processes_destroy(&w);
    assert_int_equal(status, is_reached ? PLANISH_ERROR_PROCESS : PLANISH_OK);
    return is_reached;
}

static void processes_that_are_lost_end_the_call(void **state) {
    const int dim = *(int *)*state;
    const planish_options options = options_of(PLAIN);
    test_mesh m;
    int owner[1000], n_failed = 0, n_later = 0;
    test_mesh_box(&m, dim, 3);
    test_mesh_perturb(&m, 0.14, 5);
    processes_own(&m.mesh, SLABS, 3, 0, owner);
    while (lose_at(n_failed, &m, &options, 3, owner, &n_later))
        n_failed++;
    assert_true(n_failed > 50);
    assert_true(n_later > 3 * 5); /* in what follows, which changes nothing */
    test_mesh_destroy(&m);
}

/** Steps of the whole mesh make many calls of their own: some of them fail. */
static void and_where_slow_meshes_are_helped(void **state) {
    (void)state;
    const planish_options options = options_of(PLAIN);
    test_mesh m;
    int owner[1000], n_later = 0, call = 0;
    test_mesh_squeezed_box(&m, 3, 9);
    processes_own(&m.mesh, SLABS, 2, 0, owner);
    while (lose_at(call, &m, &options, 2, owner, &n_later))
        call += 7 * effort_step(4);
    assert_true(call > 100);
    test_mesh_destroy(&m);
}

static void parts_that_are_none_are_refused(void **state) {
    (void)state;
    const planish_options options = options_of(PLAIN);
    const int owner[9] = {0};
    test_mesh m;
    processes w;
    test_mesh_box(&m, 2, 2);
    processes_create(&w, &m.mesh, 1, owner);
    process *p = &w.parts[0];
    static const struct {
        int which, status;
        const char *text;
    } faults[] = {
        {0, PLANISH_ERROR_ARGUMENT, "functions"},  {1, PLANISH_ERROR_ARGUMENT, "node_role"},
        {2, PLANISH_ERROR_ARGUMENT, "is_counted"}, {3, PLANISH_ERROR_MESH, "ascending"},
        {4, PLANISH_ERROR_MESH, "2^32"},           {5, PLANISH_ERROR_MESH, "planish_role"},
        {6, PLANISH_ERROR_MESH, "GHOSTs only"},    {7, PLANISH_ERROR_MESH, "both GHOST and OWN"}};
    for (size_t i = 0; i < sizeof faults / sizeof *faults; i++) {
        planish_part part = p->part;
        int64_t number[9];
        uint8_t role[9];
        memcpy(number, p->node_number, sizeof number);
        memcpy(role, p->node_role, sizeof role);
        part.node_number = number;
        part.node_role = role;
        if (faults[i].which == 0)
            part.receive = NULL;
        if (faults[i].which == 1)
            part.node_role = NULL;
        if (faults[i].which == 2)
            part.is_counted = NULL;
        if (faults[i].which == 3)
            number[4] = number[3];
        if (faults[i].which == 4)
            number[8] = INT64_C(1) << 32;
        if (faults[i].which == 5)
            role[2] = 3;
        if (faults[i].which == 6)
            memset(role, PLANISH_ROLE_GHOST, sizeof role);
        if (faults[i].which == 7)
            role[4] = PLANISH_ROLE_GHOST;
        p->mesh.part = &part;
        const outcome o = smooth(&p->mesh, &options, NULL, NULL, p->coordinates);
        assert_int_equal(o.status, faults[i].status);
        assert_non_null(strstr(o.error.text, faults[i].text));
    }
    processes_destroy(&w);
    test_mesh_destroy(&m);
}

/* ---- untangling ----------------------------------------------------------------------------- */

enum { SHAKEN, BOUNDARY_TOO, HOPELESS, COLLAPSED, PUSHED, N_TANGLES };

/** Coordinates [n_nodes][dim] of the box m, tangled. */
static void tangle(const test_mesh *m, int how, unsigned seed, double *x) {
    const planish_mesh *mesh = &m->mesh;
    const int dim = mesh->dim;
    double low[3], high[3];
    for (int d = 0; d < dim; d++)
        low[d] = high[d] = m->coordinates[d];
    for (int64_t i = 0; i < mesh->n_nodes * dim; i++) {
        low[i % dim] = fmin(low[i % dim], m->coordinates[i]);
        high[i % dim] = fmax(high[i % dim], m->coordinates[i]);
    }
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        const double *from = m->coordinates + i * dim;
        int inside = 1;
        for (int d = 0; d < dim; d++)
            inside &= from[d] > low[d] && from[d] < high[d];
        for (int d = 0; d < dim; d++) {
            const double shake = 1.7 * (test_random(&seed) - 0.5);
            double *to = &x[i * dim + d];
            *to = from[d];
            if (how == SHAKEN && inside)
                *to += shake;
            if (how == BOUNDARY_TOO)
                *to += inside ? shake : 0.55 * shake;
            if (how == HOPELESS) /* of a small box: elements contradict others around a node */
                *to += shake;
            if (how == COLLAPSED && inside)
                *to = low[d] + 0.1 * (from[d] - low[d]);
            if (how == PUSHED && inside)
                *to += 0.6 * (high[d] - low[d]);
        }
    }
}

/** Tangled meshes, whatever is tangled, and elements to be brought above a volume. */
static void tangled_meshes_have_those_bits_too(void **state) {
    const int dim = *(int *)*state;
    int64_t left = 0, sweeps = 0, raised = 0;
    for (int how = 0; how < N_TANGLES; how++)
        for (int i = 0; i < 8; i += effort_step(2)) {
            planish_options options;
            test_mesh m;
            int owner[1000];
            const int n = 1 + i % 4;
            planish_options_init(&options);
            options.threads = 1;
            options.min_volume = i % 3 == 2 ? (dim == 3 ? 0.13 : 0.45) : 0;
            options.only_worse_than = i > 5 ? 2 : 0;
            test_mesh_box(&m, dim, how == HOPELESS ? 3 : dim == 3 ? 5 : 12);
            double *x = malloc((size_t)(m.mesh.n_nodes * dim) * sizeof *x);
            tangle(&m, how, (unsigned)i + 1, x);
            processes_own(&m.mesh, i < 4 ? SLABS : SCATTERED, n, (uint64_t)i, owner);
            const int from_the_start = i % 2;
            if (from_the_start)
                memcpy(m.coordinates, x, (size_t)(m.mesh.n_nodes * dim) * sizeof *x);
            const outcome o = compare_from(&m.mesh, from_the_start ? NULL : x, &options, n, owner);
            sweeps += o.result.untangling_sweeps;
            left += o.quality.n_inverted;
            raised += options.min_volume > 0 && o.result.n_below_min_volume == 0;
            free(x);
            test_mesh_destroy(&m);
        }
    assert_true(sweeps > 0 && left > 0 && raised > 0);
    figure("%lld untangling sweeps, %lld elements left inverted, %lld times all above a volume",
           (long long)sweeps, (long long)left, (long long)raised);
}

/** Several copies of a box side by side, every other one in the opposite order; joined: neighbours
 *  have one node in common. Arrays are owned. */
static planish_mesh bodies_of(const test_mesh *box, int n_bodies, int joined) {
    const int dim = box->mesh.dim, corners = dim + 1;
    const int64_t n = box->mesh.n_nodes, m = box->mesh.n_elements;
    double *x = malloc((size_t)(n * n_bodies * dim) * sizeof *x);
    int32_t *elements = malloc((size_t)(m * n_bodies * corners) * sizeof *elements);
    for (int64_t k = 0; k < n_bodies; k++) {
        for (int64_t i = 0; i < n * dim; i++)
            x[k * n * dim + i] = box->coordinates[i] + (i % dim == 0 ? 100.0 * (double)k : 0);
        for (int64_t i = 0; i < m; i++)
            for (int j = 0; j < corners; j++) {
                const int from = k % 2 && j < 2 ? 1 - j : j;
                const int32_t node = box->elements[i * corners + from];
                elements[(k * m + i) * corners + j] =
                    (int32_t)(joined && k > 0 && node == 0 ? k * n - 1 : k * n + node);
            }
    }
    return (planish_mesh){.dim = dim,
                          .n_nodes = n * n_bodies,
                          .n_elements = m * n_bodies,
                          .coordinates = x,
                          .elements = elements};
}

static void bodies_have_signs_of_their_own(void **state) {
    const int dim = *(int *)*state;
    const planish_options options = options_of(PLAIN);
    enum { BODIES = 3 };
    for (int n = 2; n <= 4; n++)
        for (int owning = 0; owning < N_OWNINGS; owning++) {
            test_mesh box;
            int owner[1000];
            test_mesh_box(&box, dim, dim == 3 ? 3 : 6);
            test_mesh_perturb(&box, 0.14, (unsigned)n);
            const planish_mesh mesh = bodies_of(&box, BODIES, 0);
            processes_own(&mesh, owning, n, (uint64_t)n, owner);
            const outcome o = compare_from(&mesh, NULL, &options, n, owner);
            assert_int_equal(o.info.n_components, BODIES);
            assert_int_equal(o.info.n_negative_order, box.mesh.n_elements);
            assert_int_equal(o.quality.n_inverted, 0);
            free((void *)(uintptr_t)mesh.coordinates);
            free((void *)(uintptr_t)mesh.elements);
            test_mesh_destroy(&box);
        }
}

/* ---- orders of elements --------------------------------------------------------------------- */

enum { MIXED, TOUCHING, TWINS, FLAT, SHEARED, MANY, ONE_SIDED, MIXED_TANGLED, N_DISORDERS };

static void turn(int32_t *node) {
    const int32_t first = node[0];
    node[0] = node[1];
    node[1] = first;
}

/** Elements [*n_elements], with room for 8 more, and coordinates of a mesh that has been in order.
 */
static void disturb(int how, const planish_mesh *mesh, uint64_t *seed, double *x, int32_t *elements,
                    int64_t *n_elements) {
    const int dim = mesh->dim, corners = dim + 1;
    for (int64_t i = 0; i < *n_elements; i++)
        if (how != TOUCHING && random_below(seed, 3) == 0)
            turn(elements + i * corners);
    if (how == TWINS)
        for (int k = 0; k < 8; k++, ++*n_elements) {
            int32_t *copy = elements + *n_elements * corners;
            memcpy(copy, elements + random_below(seed, (int)*n_elements) * corners,
                   (size_t)corners * sizeof *copy);
            if (k % 2)
                turn(copy);
        }
    if (how == FLAT) /* of the first body nothing is left but a line */
        for (int64_t i = 0; i < mesh->n_nodes / 2; i++)
            for (int d = 1; d < dim; d++)
                x[i * dim + d] = 0;
    for (int64_t i = 0; how == SHEARED && i < mesh->n_nodes; i++) { /* flat but for rounding */
        double *last = &x[i * dim + dim - 1];
        *last = x[i * dim] + ldexp(*last, -48);
    }
    if (how == MIXED_TANGLED)
        for (int64_t i = 0; i < mesh->n_nodes * dim; i++)
            x[i] += 0.9 * ((double)random_below(seed, 1000) / 1000 - 0.5);
}

/** A strip of triangles, of one side alone: its ends are joined after half a turn. */
static void make_one_sided(int n, double *x, int32_t *elements) {
    for (int i = 0; i < n; i++)
        for (int k = 0; k < 2; k++) {
            x[2 * (2 * i + k)] = cos(6.28 * i / n) * (1 + k);
            x[2 * (2 * i + k) + 1] = sin(6.28 * i / n) * (1 + k);
        }
    for (int i = 0; i < n; i++) {
        const int32_t a = 2 * i, b = 2 * i + 1, last = i == n - 1;
        const int32_t c = last ? 1 : a + 2, d = last ? 0 : b + 2;
        const int32_t two[2][3] = {{a, b, c}, {b, d, c}};
        memcpy(elements + 6 * i, two, sizeof two);
    }
}

/** The order of elements is found as in one process, whatever is in disorder. */
static void disorder_is_seen_together(void **state) {
    const int dim = *(int *)*state;
    int64_t n_components = 0, n_reversed = 0, n_held = 0;
    const int step = effort_step(N_OWNINGS);
    for (int how = 0; how < N_DISORDERS; how++)
        for (int owning = how % step; owning < N_OWNINGS; owning += step) {
            const int n = 2 + owning;
            planish_options options = options_of(FEW_SWEEPS);
            uint64_t seed = effort_seed((uint64_t)(100 * how + 10 * owning + n));
            test_mesh box;
            test_mesh_box(&box, dim, how == MANY ? 1 : dim == 3 ? 3 : 5);
            if (how != MANY)
                test_mesh_perturb(&box, 0.14, (unsigned)n);
            const int n_bodies = how == MANY ? 150 : how == TOUCHING || how == FLAT ? 2 : 1;
            planish_mesh mesh = bodies_of(&box, n_bodies, how == TOUCHING);
            double *x = (double *)(uintptr_t)mesh.coordinates;
            int32_t *elements = malloc((size_t)(mesh.n_elements + 200) * 4 * sizeof *elements);
            memcpy(elements, mesh.elements,
                   (size_t)(mesh.n_elements * (dim + 1)) * sizeof *elements);
            free((void *)(uintptr_t)mesh.elements);
            disturb(how, &mesh, &seed, x, elements, &mesh.n_elements);
            if (how == ONE_SIDED && dim == 2) {
                mesh.n_nodes = 30;
                mesh.n_elements = 30;
                make_one_sided(15, x, elements);
            }
            mesh.elements = elements;
            int *owner = malloc((size_t)mesh.n_nodes * sizeof *owner);
            processes_own(&mesh, owning, n, (uint64_t)n, owner);
            options.untangle = how != MANY && how != FLAT; /* what encloses nothing is given up
                                                              where the whole mesh is known */
            const outcome o = compare_from(&mesh, NULL, &options, n, owner);
            n_components += o.info.n_components > 0 ? o.info.n_components : 0;
            n_reversed += o.info.n_negative_order;
            n_held += how == ONE_SIDED && o.info.n_free == 0;
            free(owner);
            free(x);
            free(elements);
            test_mesh_destroy(&box);
        }
    assert_true(n_components > 150 * N_OWNINGS / step && n_reversed > 0 &&
                (dim == 3 || n_held > 0));
}

/** What is only possible in one process is refused in all. */
static void what_is_not_possible_in_parts_is_refused(void **state) {
    (void)state;
    const int64_t centre = 0;
    planish_options options = options_of(PLAIN);
    test_mesh m;
    int owner[1000];
    processes w;
    job j = {.options = &options};
    options.around = &centre;
    options.n_around = 1;
    test_mesh_box(&m, 3, 4);
    processes_own(&m.mesh, SLABS, 2, 0, owner);
    processes_create(&w, &m.mesh, 2, owner);
    processes_run(&w, smooth_part, &j);
    for (int k = 0; k < 2; k++) {
        assert_int_equal(j.outcome[k].status, PLANISH_ERROR_PARTS);
        assert_non_null(strstr(j.outcome[k].error.text, "around"));
    }
    processes_destroy(&w);
    test_mesh_destroy(&m);
}

/* ---- states of elements ---------------------------------------------------------------------- */

/** States of the elements of a mesh, as planish_check_volumes, planish_find_infeasible and
 *  planish_find_reversed say. */
typedef struct states {
    const double *spoilt;       /* coordinates, of the whole mesh */
    uint8_t *below, *unfixable; /* [n_elements], of the whole mesh */
    uint8_t *reversed;          /* [n_elements] likewise */
    int64_t n_reversed;
    planish_options options;
} states;

/** Of mesh, whose nodes and elements have these numbers (NULL: their own): the worst that is known
 *  of each element. */
static void find_states(const planish_mesh *mesh, const int64_t *node_number,
                        const int64_t *element_number, states *s) {
    const int dim = mesh->dim;
    double *x = malloc((size_t)mesh->n_nodes * (size_t)dim * sizeof *x);
    uint8_t *below = malloc((size_t)mesh->n_elements),
            *unfixable = malloc((size_t)mesh->n_elements),
            *reversed = malloc((size_t)mesh->n_elements);
    planish_plan *plan;
    int64_t n, n_undecided = -1;
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        memcpy(x + i * dim, s->spoilt + (node_number ? node_number[i] : i) * dim,
               (size_t)dim * sizeof *x);
    assert_int_equal(planish_plan_create(mesh, &s->options, &plan, NULL), 0);
    assert_int_equal(planish_check_volumes(plan, x, &s->options, below, &n, NULL, NULL), 0);
    assert_int_equal(
        planish_find_infeasible(plan, x, &s->options, unfixable, &n, &n_undecided, NULL), 0);
    assert_int_equal(n_undecided, 0);
    assert_int_equal(planish_find_reversed(plan, x, reversed, &s->n_reversed, NULL), 0);
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        const int64_t at = element_number ? element_number[i] : i;
        s->reversed[at] |= reversed[i];
        if (below[i] > s->below[at])
            s->below[at] = below[i];
        if (unfixable[i] > s->unfixable[at])
            s->unfixable[at] = unfixable[i];
    }
    planish_plan_destroy(plan);
    free(x);
    free(below);
    free(unfixable);
    free(reversed);
}

static int go_on(const planish_progress *progress, void *user) {
    (void)progress;
    (void)user;
    return 0;
}

/** Find the states of a part. As with planish-mpi only one process has a callback: all search with
 *  a limit all the same, or they would wait for each other for ever. */
static void find_states_of_part(process *part, void *user) {
    static pthread_mutex_t turn = PTHREAD_MUTEX_INITIALIZER;
    states *all = user, mine = *all;
    const size_t n = 100000; /* more than there are */
    mine.below = calloc(n, 1);
    mine.unfixable = calloc(n, 1);
    mine.reversed = calloc(n, 1);
    mine.options.progress = part->rank == 0 ? go_on : NULL;
    find_states(&part->mesh, part->node_number, part->element_number, &mine);
    pthread_mutex_lock(&turn);
    for (int64_t i = 0; i < part->mesh.n_elements; i++) {
        const int64_t at = part->element_number[i];
        all->below[at] = mine.below[at] > all->below[at] ? mine.below[at] : all->below[at];
        all->unfixable[at] |= mine.unfixable[at];
        all->reversed[at] |= mine.reversed[at];
    }
    all->n_reversed = mine.n_reversed; /* every process counts those of all */
    pthread_mutex_unlock(&turn);
    free(mine.below);
    free(mine.unfixable);
    free(mine.reversed);
}

/** What all processes together know of elements that are inverted, or below their minimum volume,
 * is what one knows that has them all. */
static void bad_elements_are_found_together(void **state) {
    const int dim = *(int *)*state;
    int64_t n_infeasible = 0, n_unfixable = 0, n_reversed = 0;
    for (int i = 0; i < 4; i++) {
        test_mesh m;
        int owner[1000];
        processes w;
        unsigned seed = (unsigned)i + 1;
        test_mesh_box(&m, dim, dim == 3 ? 4 : 9);
        const int64_t values = m.mesh.n_nodes * dim;
        double *spoilt = malloc((size_t)values * sizeof *spoilt);
        for (int64_t k = 0; k < values; k++)
            spoilt[k] = m.coordinates[k] + (dim == 3 ? 0.8 : 1.6) * (test_random(&seed) - 0.5);
        states whole = {.spoilt = spoilt}, parts = {.spoilt = spoilt};
        planish_options_init(&whole.options);
        whole.options.threads = 1;
        whole.options.min_volume = 0.3;
        parts.options = whole.options;
        uint8_t *state_of[6];
        for (int k = 0; k < 6; k++)
            state_of[k] = calloc((size_t)m.mesh.n_elements, 1);
        whole.below = state_of[0], whole.unfixable = state_of[1];
        parts.below = state_of[2], parts.unfixable = state_of[3];
        whole.reversed = state_of[4], parts.reversed = state_of[5];
        find_states(&m.mesh, NULL, NULL, &whole);
        processes_own(&m.mesh, SCATTERED, 3, 0, owner);
        processes_create(&w, &m.mesh, 3, owner);
        processes_run(&w, find_states_of_part, &parts);
        assert_memory_equal(whole.below, parts.below, (size_t)m.mesh.n_elements);
        assert_memory_equal(whole.unfixable, parts.unfixable, (size_t)m.mesh.n_elements);
        assert_memory_equal(whole.reversed, parts.reversed, (size_t)m.mesh.n_elements);
        assert_int_equal(whole.n_reversed, parts.n_reversed);
        n_reversed += whole.n_reversed;
        for (int64_t k = 0; k < m.mesh.n_elements; k++) {
            n_infeasible += whole.below[k] == PLANISH_VOLUME_INFEASIBLE;
            n_unfixable += whole.unfixable[k];
        }
        for (int k = 0; k < 6; k++)
            free(state_of[k]);
        processes_destroy(&w);
        test_mesh_destroy(&m);
        free(spoilt);
    }
    assert_true(n_infeasible > 0 && n_unfixable > 0 && n_reversed > 0);
}

int main(void) {
    static int dims[] = {2, 3};
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate(the_bits_are_those_of_one_process, &dims[0]),
        cmocka_unit_test_prestate(the_bits_are_those_of_one_process, &dims[1]),
        cmocka_unit_test(threads_do_not_change_them),
        cmocka_unit_test_prestate(patches_cross_processes, &dims[0]),
        cmocka_unit_test_prestate(patches_cross_processes, &dims[1]),
        cmocka_unit_test_prestate(snapshots_are_those_of_one_process, &dims[0]),
        cmocka_unit_test_prestate(snapshots_are_those_of_one_process, &dims[1]),
        cmocka_unit_test_prestate(without_memory_for_patches_all_end, &dims[0]),
        cmocka_unit_test_prestate(without_memory_for_patches_all_end, &dims[1]),
        cmocka_unit_test(slow_meshes_are_helped_together),
        cmocka_unit_test_prestate(slow_meshes_slide_together, &dims[0]),
        cmocka_unit_test_prestate(slow_meshes_slide_together, &dims[1]),
        cmocka_unit_test_prestate(processes_that_are_lost_end_the_call, &dims[0]),
        cmocka_unit_test_prestate(processes_that_are_lost_end_the_call, &dims[1]),
        cmocka_unit_test(and_where_slow_meshes_are_helped),
        cmocka_unit_test(parts_that_are_none_are_refused),
        cmocka_unit_test_prestate(tangled_meshes_have_those_bits_too, &dims[0]),
        cmocka_unit_test_prestate(tangled_meshes_have_those_bits_too, &dims[1]),
        cmocka_unit_test_prestate(bodies_have_signs_of_their_own, &dims[0]),
        cmocka_unit_test_prestate(bodies_have_signs_of_their_own, &dims[1]),
        cmocka_unit_test_prestate(disorder_is_seen_together, &dims[0]),
        cmocka_unit_test_prestate(disorder_is_seen_together, &dims[1]),
        cmocka_unit_test(what_is_not_possible_in_parts_is_refused),
        cmocka_unit_test_prestate(bad_elements_are_found_together, &dims[0]),
        cmocka_unit_test_prestate(bad_elements_are_found_together, &dims[1]),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
