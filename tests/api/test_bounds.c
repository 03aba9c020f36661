/* Bounds of the nodes of every kind: planish_smooth keeps them, with the same bits on any number of
 * threads and at any size. */
#include "support/allocations.h"
#include "support/both.h"
#include "support/effort.h"
#include "support/meshes.h"
#include "support/run.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- bounds -------------------------------------------------------------------------------- */

enum { NO_BOUNDS, BOX, PER_NODE, DISTANCE, EDGES, ALL_BOUNDS, BOUNDS };

/** The bounds of a run; arrays [n_nodes][dim] are owned. */
typedef struct bounded {
    double *lower, *upper;
} bounded;

/** Bounds of the kind. Of the nodes' own ones, some leave out where the node is. */
static bounded set_bounds(const test_mesh *mesh, int kind, planish_options *options) {
    const int dim = mesh->mesh.dim;
    bounded b = {malloc(test_bytes_of(&mesh->mesh)), malloc(test_bytes_of(&mesh->mesh))};
    unsigned random = 77;
    for (int64_t i = 0; i < mesh->mesh.n_nodes * dim; i++) {
        int outside = i / dim % 7 == 0 && i % dim == 0;
        b.lower[i] = mesh->coordinates[i] + (outside ? 0.01 : -0.05 * test_random(&random));
        b.upper[i] = mesh->coordinates[i] + 0.05 * (outside + test_random(&random));
    }
    if (kind == BOX || kind == ALL_BOUNDS) {
        options->box_lower[0] = 0.97;
        options->box_upper[dim - 1] = 2.97;
    }
    if (kind == PER_NODE || kind == ALL_BOUNDS) {
        options->lower = b.lower;
        options->upper = b.upper;
    }
    if (kind == DISTANCE || kind == ALL_BOUNDS)
        options->max_displacement = 0.03;
    if (kind == EDGES) {
        options->max_displacement = 0.03;
        options->displacement_unit = PLANISH_UNIT_EDGE;
    }
    return b;
}

static void release_bounds(bounded *b) {
    free(b->lower);
    free(b->upper);
}

/** Mean length of the node's edges, each counted once. */
static double mean_edge(const planish_mesh *mesh, int64_t node) {
    const int dim = mesh->dim;
    uint8_t *seen = calloc((size_t)mesh->n_nodes, 1);
    double sum = 0, n = 0;
    seen[node] = 1;
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        const int32_t *element = mesh->elements + i * (dim + 1);
        int has = 0;
        for (int j = 0; j <= dim; j++)
            has |= element[j] == node;
        for (int j = 0; has && j <= dim; j++) {
            double square = 0;
            for (int d = 0; d < dim; d++) {
                double e =
                    mesh->coordinates[element[j] * dim + d] - mesh->coordinates[node * dim + d];
                square += e * e;
            }
            sum += seen[element[j]] ? 0 : sqrt(square);
            n += !seen[element[j]];
            seen[element[j]] = 1;
        }
    }
    free(seen);
    return sum / n;
}

/** Bounds of coordinate d of a node. */
static void bounds_of(const planish_options *options, int64_t node, int dim, int d, double *lower,
                      double *upper) {
    *lower = options->box_lower[d];
    *upper = options->box_upper[d];
    if (options->lower)
        *lower = fmax(*lower, options->lower[node * dim + d]);
    if (options->upper)
        *upper = fmin(*upper, options->upper[node * dim + d]);
}

/** How many bounds the node stands at, or -1: it started outside. */
static int check_box(const test_mesh *mesh, const planish_options *options, const double *y,
                     int64_t node) {
    const int dim = mesh->mesh.dim;
    const double *x = mesh->coordinates + node * dim;
    int outside = 0, inside = 1, at = 0;
    for (int d = 0; d < dim; d++) {
        double lower, upper;
        bounds_of(options, node, dim, d, &lower, &upper);
        outside |= !(x[d] >= lower && x[d] <= upper);
        inside &= y[d] >= lower && y[d] <= upper;
        at += y[d] == lower || y[d] == upper;
    }
    if (outside || !test_is_inside_box(x, dim, 4))
        assert_memory_equal(x, y, (size_t)dim * sizeof *x);
    else
        assert_true(inside);
    return outside && test_is_inside_box(x, dim, 4) ? -1 : at;
}

/** Check a result against its bounds; returns how many bounds nodes have come to. */
static int check_bounds(const test_mesh *mesh, const planish_options *options, const test_run *s) {
    const int dim = mesh->mesh.dim;
    int64_t held = 0;
    int reached = 0;
    for (int64_t i = 0; i < mesh->mesh.n_nodes; i++) {
        const double *y = s->coordinates + i * dim;
        double far = test_distance(mesh->coordinates + i * dim, y, dim),
               most = options->max_displacement;
        int at = check_box(mesh, options, y, i);
        held += at < 0;
        reached += at > 0 ? at : 0;
        if (options->displacement_unit == PLANISH_UNIT_EDGE)
            most *= mean_edge(&mesh->mesh, i) * (1 + 1e-15);
        if (options->max_displacement > 0) {
            assert_true(far <= most);
            reached += far > 0.9999 * most;
        }
    }
    assert_int_equal(s->result.n_held_outside, held);
    return reached;
}

/** The RMS of the elements with a movable node is that of a measure, though bounds hold nodes. */
static void check_rms_of_movable(const planish_mesh *mesh, const planish_options *options,
                                 const test_run *s) {
    planish_plan *plan;
    planish_quality quality;
    assert_int_equal(planish_plan_create(mesh, options, &plan, NULL), 0);
    assert_int_equal(planish_measure(plan, s->coordinates, &quality, NULL), 0);
    assert_true(fabs(quality.rms_radius_ratio_movable - s->result.rms_movable) <=
                1e-9 * quality.rms_radius_ratio_movable);
    planish_plan_destroy(plan);
}

static void bounds_are_kept(void **state) {
    int dim = *(int *)*state;
    for (int kind = BOX; kind < BOUNDS; kind++) {
        int reached = 0;
        for (unsigned i = 0; i < 24; i++) {
            test_mesh mesh;
            test_run s;
            test_bad_box(&mesh, dim, 4, i);
            planish_options options = test_options(1);
            bounded b = set_bounds(&mesh, kind, &options);
            options.method = i % 4 < 2 ? PLANISH_METHOD_PLANISH : (planish_method)(1 + i % 3);
            options.objective = (planish_objective)(i / 2 % 3);
            options.search = (planish_search)(i % 2);
            options.precision = i / 12 ? PLANISH_PRECISION_FLOAT : PLANISH_PRECISION_DOUBLE;
            options.min_volume = i % 3 ? 0 : 0.5 * test_regular_volume(dim);
            s = test_smooth(&mesh.mesh, &options);
            reached += check_bounds(&mesh, &options, &s);
            if (options.objective == PLANISH_OBJECTIVE_RADIUS_RATIO)
                check_rms_of_movable(&mesh.mesh, &options, &s);
            release_bounds(&b);
            free(s.coordinates);
            test_mesh_destroy(&mesh);
        }
        assert_true(reached > 0);
    }
}

/* ---- the same bits ------------------------------------------------------------------------- */

static void compare(const planish_mesh *mesh, const test_run *a, const test_run *b) {
    assert_memory_equal(a->coordinates, b->coordinates, test_bytes_of(mesh));
    assert_true(a->result.objective == b->result.objective);
    assert_true(a->result.kkt_residual == b->result.kkt_residual);
    assert_true(a->result.kkt_rms == b->result.kkt_rms);
    assert_true(a->result.max_multiplier == b->result.max_multiplier);
    assert_int_equal(a->result.n_active, b->result.n_active);
    assert_int_equal(a->result.evaluations, b->result.evaluations);
    assert_int_equal(a->result.n_below_min_volume, b->result.n_below_min_volume);
    assert_int_equal(a->result.n_held_outside, b->result.n_held_outside);
}

static void compare_teams(const test_mesh *mesh, planish_options options) {
    static const planish_isa isas[] = {PLANISH_ISA_VECTOR, PLANISH_ISA_AVX2, PLANISH_ISA_AVX512};
    static const int threads[] = {2, 3, 5};
    test_run first, other;
    options.isa = PLANISH_ISA_PLAIN;
    first = test_smooth(&mesh->mesh, &options);
    assert_true(first.result.n_moved_nodes > 0);
    for (int i = 0; i < 3; i++) {
        options.threads = threads[i];
        options.isa = test_has_isa((int)isas[i]) ? isas[i] : PLANISH_ISA_AUTO;
        other = test_smooth(&mesh->mesh, &options);
        compare(&mesh->mesh, &first, &other);
        free(other.coordinates);
    }
    free(first.coordinates);
}

static void bits_do_not_depend_on_threads_or_kernel(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    test_bad_box(&mesh, dim, dim == 3 ? 8 : 16, 1);
    for (int method = 0; method < 4; method++)
        for (int kind = 0; kind < BOUNDS; kind++)
            for (int objective = 0; objective < (method == 0 && kind < BOX + 1 ? 3 : 1);
                 objective++) {
                planish_options options = test_options(1);
                bounded b = set_bounds(&mesh, kind, &options);
                options.method = (planish_method)method;
                options.objective = (planish_objective)((objective + kind) % 3);
                options.search = (planish_search)(kind % 2);
                options.area_weight = kind % 3 == 1 ? 0.3 : 0;
                options.min_volume = 0.6 * test_regular_volume(dim);
                options.max_sweeps = 3;
                compare_teams(&mesh, options);
                release_bounds(&b);
            }
    test_mesh_destroy(&mesh);
}

/** Everything that has a unit of length, times 2^exponent. */
static void scale_everything(test_mesh *mesh, planish_options *options, bounded *b, int exponent) {
    const int dim = mesh->mesh.dim;
    test_mesh_transform(mesh, ldexp(1, exponent), 0);
    for (int64_t i = 0; i < mesh->mesh.n_nodes * dim; i++) {
        b->lower[i] = ldexp(b->lower[i], exponent);
        b->upper[i] = ldexp(b->upper[i], exponent);
    }
    for (int d = 0; d < 3; d++) {
        options->box_lower[d] = ldexp(options->box_lower[d], exponent);
        options->box_upper[d] = ldexp(options->box_upper[d], exponent);
    }
    options->min_volume = ldexp(options->min_volume, dim * exponent);
    if (options->displacement_unit == PLANISH_UNIT_MESH)
        options->max_displacement = ldexp(options->max_displacement, exponent);
}

static void smooth_scaled(int dim, int kind, int i, int exponent, test_run *s) {
    test_mesh mesh;
    test_bad_box(&mesh, dim, 4, 1);
    planish_options options = test_options(1);
    bounded b = set_bounds(&mesh, kind, &options);
    options.objective = (planish_objective)(i % 3);
    options.method = i == 3 ? PLANISH_METHOD_LENGTH_LAPLACIAN : PLANISH_METHOD_PLANISH;
    options.area_weight = i == 2 ? 0.5 : 0;
    if (i == 1)
        options.min_volume_fraction = 0.6 / (double)mesh.mesh.n_elements;
    else
        options.min_volume = 0.6 * test_regular_volume(dim);
    scale_everything(&mesh, &options, &b, exponent);
    *s = test_smooth(&mesh.mesh, &options);
    release_bounds(&b);
    test_mesh_destroy(&mesh);
}

static void powers_of_two_change_no_bit(void **state) {
    int dim = *(int *)*state;
    static const int exponents[] = {-300, -1, 7, 300};
    for (int kind = 0; kind < BOUNDS; kind++)
        for (int i = 0; i < 4; i++) {
            test_run plain, scaled;
            smooth_scaled(dim, kind, i, 0, &plain);
            for (size_t e = 0; e < sizeof exponents / sizeof *exponents; e++) {
                smooth_scaled(dim, kind, i, exponents[e], &scaled);
                for (int64_t k = 0; k < (dim == 3 ? 125 : 25) * dim; k++)
                    assert_true(scaled.coordinates[k] == ldexp(plain.coordinates[k], exponents[e]));
                assert_true(scaled.result.objective == plain.result.objective);
                assert_true(scaled.result.max_multiplier == plain.result.max_multiplier);
                assert_true(scaled.result.kkt_residual == plain.result.kkt_residual);
                free(scaled.coordinates);
            }
            free(plain.coordinates);
        }
}

/* ---- refusals, sizes, memory ---------------------------------------------------------------- */

static void bounds_that_are_no_numbers_are_refused(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    planish_plan *plan;
    planish_error error;
    test_bad_box(&mesh, dim, 3, 1);
    planish_options options = test_options(1);
    bounded b = set_bounds(&mesh, PER_NODE, &options);
    assert_int_equal(planish_plan_create(&mesh.mesh, NULL, &plan, NULL), 0);
    b.upper[5 * dim] = NAN;
    assert_int_equal(planish_smooth(plan, mesh.coordinates, &options, NULL, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(error.node, 5);
    planish_plan_destroy(plan);
    release_bounds(&b);
    test_mesh_destroy(&mesh);
}

/** A largest displacement holds where its square is no number of doubles, also while a mesh is
 *  untangled, and the result tells the displacement there is. */
static void a_largest_displacement_holds_at_every_size(void **state) {
    static const int exponents[] = {-700, -530, 0, 530, 700};
    const int dim = *(int *)*state;
    int64_t moved[5];
    for (int k = 0; k < 5; k++) {
        test_mesh mesh;
        planish_result result;
        planish_options options = test_options(1);
        test_mesh_box(&mesh, dim, 3);
        test_mesh_perturb(&mesh, 1.2, 7);
        test_mesh_transform(&mesh, ldexp(1, exponents[k]), 0);
        options.max_displacement = ldexp(0.25, exponents[k]);
        double *x = malloc(test_bytes_of(&mesh.mesh)), farthest = 0;
        memcpy(x, mesh.coordinates, test_bytes_of(&mesh.mesh));
        planish_plan *plan;
        assert_int_equal(planish_plan_create(&mesh.mesh, &options, &plan, NULL), 0);
        assert_int_equal(planish_smooth(plan, x, &options, &result, NULL), 0);
        for (int64_t i = 0; i < mesh.mesh.n_nodes; i++) {
            double square = 0;
            for (int d = 0; d < dim; d++) {
                const double way = x[i * dim + d] - mesh.coordinates[i * dim + d];
                square += ldexp(way, -exponents[k]) * ldexp(way, -exponents[k]);
            }
            farthest = fmax(farthest, sqrt(square));
        }
        assert_true(farthest > 0 && farthest <= 0.25);
        assert_true(fabs(ldexp(result.max_displacement, -exponents[k]) - farthest) < 1e-14);
        moved[k] = result.n_moved_nodes;
        assert_int_equal(moved[k], moved[0]);
        planish_plan_destroy(plan);
        free(x);
        test_mesh_destroy(&mesh);
    }
}

/** Bounds of every kind and infeasible elements: all memory that a call can want. */
static void without_memory_nothing_changes(void **state) {
    int dim = *(int *)*state, failures = 0, status = PLANISH_ERROR_MEMORY;
    test_mesh mesh;
    planish_plan *plan;
    planish_error error;
    test_bad_box(&mesh, dim, 3, 1);
    planish_options options = test_options(1);
    bounded b = set_bounds(&mesh, ALL_BOUNDS, &options);
    options.min_volume = 1.5 * test_regular_volume(dim);
    double *copy = malloc(test_bytes_of(&mesh.mesh));
    /* A plan keeps the memory of its last call: each has its own. */
    for (int permitted = 0; status == PLANISH_ERROR_MEMORY; permitted++) {
        memcpy(copy, mesh.coordinates, test_bytes_of(&mesh.mesh));
        assert_int_equal(planish_plan_create(&mesh.mesh, &options, &plan, NULL), 0);
        allocations_permit(permitted);
        status = planish_smooth(plan, copy, &options, NULL, &error);
        allocations_permit(-1);
        planish_plan_destroy(plan);
        if (status == PLANISH_ERROR_MEMORY)
            assert_memory_equal(copy, mesh.coordinates, test_bytes_of(&mesh.mesh));
        failures += status == PLANISH_ERROR_MEMORY;
    }
    assert_int_equal(status, 0);
    assert_true(failures > 10);
    int64_t n_below;
    uint8_t *below = malloc((size_t)mesh.mesh.n_elements);
    status = PLANISH_ERROR_MEMORY;
    for (failures = 0; status == PLANISH_ERROR_MEMORY; failures++) {
        assert_int_equal(planish_plan_create(&mesh.mesh, &options, &plan, NULL), 0);
        allocations_permit(failures);
        status =
            planish_check_volumes(plan, mesh.coordinates, &options, below, &n_below, NULL, &error);
        allocations_permit(-1);
        planish_plan_destroy(plan);
    }
    assert_int_equal(status, 0);
    assert_true(failures > 5);
    free(below);
    free(copy);
    release_bounds(&b);
    test_mesh_destroy(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        BOTH(bounds_are_kept),
        BOTH(bits_do_not_depend_on_threads_or_kernel),
        BOTH(powers_of_two_change_no_bit),
        BOTH(bounds_that_are_no_numbers_are_refused),
        BOTH(a_largest_displacement_holds_at_every_size),
        BOTH(without_memory_nothing_changes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
