/* What planish_smooth promises with minimum volumes and other objectives, and what
 * planish_check_volumes says: all by the public functions. */
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

/* A minimum volume counts as reached at this fraction of it. */
#define MET 0.997

/** Elements of positive volumes below MET of least, or of their own. */
static int64_t count_below(const planish_mesh *mesh, const double *coordinates, double least) {
    int64_t n = 0;
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        double own = mesh->min_volume && mesh->min_volume[i] > 0 ? mesh->min_volume[i] : least;
        n += test_measure_of(mesh, coordinates, i) < MET * (1 - 1e-12) * own;
    }
    return n;
}

/** Fill state (may be NULL) by planish_check_volumes; returns how many are below. */
static int64_t check_volumes(const planish_mesh *mesh, const double *coordinates,
                             const planish_options *options, uint8_t *state) {
    planish_plan *plan;
    int64_t n_below = -1;
    assert_int_equal(planish_plan_create(mesh, options, &plan, NULL), 0);
    assert_int_equal(planish_check_volumes(plan, coordinates, options, state, &n_below, NULL, NULL),
                     0);
    planish_plan_destroy(plan);
    return n_below;
}

/* ---- F ------------------------------------------------------------------------------------- */

/** What a run's progress must not do. */
typedef struct watch {
    double last; /* F */
    int sweeps, restoring;
} watch;

static int f_falls(const planish_progress *progress, void *user) {
    watch *w = user;
    if (!progress->sweep_done)
        return 0;
    if (w->sweeps > 0 && progress->phase != PLANISH_PHASE_UNTANGLE)
        assert_true(progress->objective <= w->last);
    w->last = progress->objective;
    w->sweeps++;
    w->restoring += progress->phase == PLANISH_PHASE_UNTANGLE;
    return 0;
}

static void f_never_rises(void **state) {
    int dim = *(int *)*state;
    for (int objective = 0; objective < 3; objective++)
        for (int weight = 0; weight < 3; weight++)
            for (int direction = 0; direction < 2; direction++) {
                test_mesh mesh;
                test_run s;
                watch w = {0, 0, 0};
                test_bad_box(&mesh, dim, dim == 3 ? 5 : 8, (unsigned)(3 * objective + weight));
                planish_options options = test_options(1);
                options.objective = (planish_objective)objective;
                options.area_weight = 0.5 * weight;
                options.search = (planish_search)direction;
                options.min_volume = 0.75 * test_regular_volume(dim);
                options.progress = f_falls;
                options.progress_user = &w;
                s = test_smooth(&mesh.mesh, &options);
                assert_true(w.sweeps > 2 && w.restoring < w.sweeps);
                assert_true(w.restoring > 0);
                assert_true(fabs(s.result.objective - w.last) <= 1e-12 * w.last);
                free(s.coordinates);
                test_mesh_destroy(&mesh);
            }
}

/** However soon it ends, no more elements are below their minimum volume than there were: many are,
 * in meshes with nodes far off their places, and sweeps bring up some at the cost of others. */
static void fewer_are_below_whenever_it_ends(void **state) {
    int dim = *(int *)*state, n_back = 0;
    for (unsigned seed = 0; seed < 40; seed++)
        for (int sweeps = 1; sweeps < 6; sweeps++) {
            test_mesh mesh;
            test_run s;
            planish_options options = test_options(1);
            test_bad_box(&mesh, dim, dim == 3 ? 3 : 4, seed);
            options.min_volume = (0.9 + 0.05 * (seed % 5)) * test_regular_volume(dim);
            options.max_sweeps = sweeps;
            const int64_t before = count_below(&mesh.mesh, mesh.coordinates, options.min_volume);
            s = test_smooth(&mesh.mesh, &options);
            const int64_t after = count_below(&mesh.mesh, s.coordinates, options.min_volume);
            assert_true(after <= before);
            n_back += s.result.n_moved_nodes == 0;
            free(s.coordinates);
            test_mesh_destroy(&mesh);
        }
    figure("%d-D: %d of 200 runs went back to the start", dim, n_back);
}

/** Without restoring, F at the end is below that at the start, and is what it is said to be. */
static void f_is_the_weighted_sum(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    test_run s;
    test_bad_box(&mesh, dim, 4, 1);
    planish_options options = test_options(1);
    options.area_weight = 0.25;
    options.min_volume = 0.1 * test_regular_volume(dim);
    s = test_smooth(&mesh.mesh, &options);
    double squares = 0;
    for (int64_t i = 0; i < mesh.mesh.n_elements; i++) {
        double g = 1 - test_measure_of(&mesh.mesh, s.coordinates, i) / options.min_volume;
        squares += g * g / (double)mesh.mesh.n_elements;
    }
    double f = 0.75 * s.after.rms_radius_ratio + 0.25 * sqrt(squares);
    assert_true(fabs(s.result.objective / f - 1) < 1e-12);
    assert_true(s.result.objective < s.result.objective_before);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

/* ---- minimum volumes ------------------------------------------------------------------------- */

enum { FOR_ALL, FRACTION, OWN, KINDS };

/** Ask for a minimum volume of about part of the regular one, in one of the ways that there are;
 * own [n_elements]. */
static void ask_for_volume(test_mesh *mesh, planish_options *options, int kind, double part,
                           double *own) {
    double volume = part * test_regular_volume(mesh->mesh.dim), total = 0;
    for (int64_t i = 0; i < mesh->mesh.n_elements; i++) {
        own[i] = i % 3 ? volume : 0.5 * volume;
        total += test_measure_of(&mesh->mesh, mesh->coordinates, i);
    }
    if (kind == FOR_ALL)
        options->min_volume = volume;
    if (kind == FRACTION)
        options->min_volume_fraction = volume / total;
    if (kind == OWN)
        mesh->mesh.min_volume = own;
}

static void minimum_volumes_are_reached(void **state) {
    int dim = *(int *)*state;
    for (int kind = 0; kind < KINDS; kind++)
        for (int objective = 0; objective < 3; objective++) {
            test_mesh mesh;
            test_run s;
            test_bad_box(&mesh, dim, dim == 3 ? 4 : 8, (unsigned)objective);
            double *own = malloc((size_t)mesh.mesh.n_elements * sizeof *own);
            planish_options options = test_options(1);
            options.objective = (planish_objective)objective;
            ask_for_volume(&mesh, &options, kind, 0.7, own);
            double volume = 0.7 * test_regular_volume(dim);
            assert_true(check_volumes(&mesh.mesh, mesh.coordinates, &options, NULL) > 0);
            s = test_smooth(&mesh.mesh, &options);
            assert_int_equal(s.result.stop, PLANISH_STOP_CONVERGED);
            assert_int_equal(s.result.n_below_min_volume, 0);
            assert_int_equal(count_below(&mesh.mesh, s.coordinates, volume), 0);
            assert_int_equal(check_volumes(&mesh.mesh, s.coordinates, &options, NULL), 0);
            assert_true(fabs(s.result.min_volume - (kind == OWN ? 0 : volume)) < 1e-12 * volume);
            free(own);
            free(s.coordinates);
            test_mesh_destroy(&mesh);
        }
}

static void the_check_agrees_with_the_volumes(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    test_bad_box(&mesh, dim, 4, 3);
    uint8_t *found = malloc((size_t)mesh.mesh.n_elements);
    planish_options options = test_options(1);
    assert_int_equal(check_volumes(&mesh.mesh, mesh.coordinates, &options, found), 0);
    options.min_volume = 0.8 * test_regular_volume(dim);
    int64_t n = check_volumes(&mesh.mesh, mesh.coordinates, &options, found);
    assert_int_equal(n, count_below(&mesh.mesh, mesh.coordinates, options.min_volume));
    for (int64_t i = 0; i < mesh.mesh.n_elements; i++) {
        int below = test_measure_of(&mesh.mesh, mesh.coordinates, i) < MET * options.min_volume;
        assert_int_equal(found[i], below ? PLANISH_VOLUME_BELOW : PLANISH_VOLUME_MET);
    }
    free(found);
    test_mesh_destroy(&mesh);
}

/** A corner's element has no free node. */
static void fixed_elements_are_infeasible(void **state) {
    int dim = *(int *)*state, n_fixed = 0;
    test_mesh mesh;
    test_run s;
    test_bad_box(&mesh, dim, 4, 2);
    double *own = calloc((size_t)mesh.mesh.n_elements, sizeof *own);
    uint8_t *found = malloc((size_t)mesh.mesh.n_elements);
    mesh.mesh.min_volume = own;
    for (int64_t i = 0; i < mesh.mesh.n_elements; i++) {
        int fixed = 1;
        for (int j = 0; j <= dim; j++)
            fixed &= !test_is_inside_box(mesh.coordinates + mesh.elements[i * (dim + 1) + j] * dim,
                                         dim, 4);
        own[i] = fixed ? 1.1 * test_regular_volume(dim) : 0;
        n_fixed += fixed;
    }
    planish_options options = test_options(1);
    assert_true(n_fixed > 0);
    assert_int_equal(check_volumes(&mesh.mesh, mesh.coordinates, &options, found), n_fixed);
    for (int64_t i = 0; i < mesh.mesh.n_elements; i++)
        assert_int_equal(found[i], own[i] > 0 ? PLANISH_VOLUME_INFEASIBLE : PLANISH_VOLUME_MET);
    s = test_smooth(&mesh.mesh, &options);
    assert_int_equal(s.result.stop, PLANISH_STOP_INFEASIBLE);
    assert_int_equal(s.result.n_below_min_volume, n_fixed);
    assert_true(s.after.rms_radius_ratio < s.before.rms_radius_ratio);
    free(found);
    free(own);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

/** All elements around the one free node of a small box want more than there is; the proof needs at
 *  most dim + 1 of them. */
static void crowded_stars_are_infeasible(void **state) {
    int dim = *(int *)*state, n_proof = 0;
    test_mesh mesh;
    test_run s;
    test_bad_box(&mesh, dim, 2, 2);
    uint8_t *found = malloc((size_t)mesh.mesh.n_elements);
    planish_options options = test_options(1);
    options.min_volume = 0.9 * test_regular_volume(dim);
    check_volumes(&mesh.mesh, mesh.coordinates, &options, found);
    for (int64_t i = 0; i < mesh.mesh.n_elements; i++)
        assert_int_not_equal(found[i], PLANISH_VOLUME_INFEASIBLE);
    s = test_smooth(&mesh.mesh, &options);
    assert_int_equal(s.result.stop, PLANISH_STOP_CONVERGED);
    assert_int_equal(s.result.n_below_min_volume, 0);
    free(s.coordinates);

    options.min_volume = 1.1 * test_regular_volume(dim);
    int64_t n = check_volumes(&mesh.mesh, mesh.coordinates, &options, found);
    for (int64_t i = 0; i < mesh.mesh.n_elements; i++) {
        int inner = 0;
        for (int j = 0; j <= dim; j++)
            inner |= test_is_inside_box(mesh.coordinates + mesh.elements[i * (dim + 1) + j] * dim,
                                        dim, 2);
        if (!inner)
            assert_int_equal(found[i], PLANISH_VOLUME_INFEASIBLE);
        n_proof += inner && found[i] == PLANISH_VOLUME_INFEASIBLE;
    }
    assert_true(n_proof > 1);
    assert_true(n >= n_proof);
    s = test_smooth(&mesh.mesh, &options);
    assert_int_equal(s.result.stop, PLANISH_STOP_INFEASIBLE);
    free(s.coordinates);
    free(found);
    test_mesh_destroy(&mesh);
}

/** With free neighbours there is no proof, however much is asked for. */
static void elements_with_free_neighbours_are_not_infeasible(void **state) {
    int dim = *(int *)*state, several = 0;
    test_mesh mesh;
    test_bad_box(&mesh, dim, 4, 2);
    uint8_t *found = malloc((size_t)mesh.mesh.n_elements);
    planish_options options = test_options(1);
    options.min_volume = 2 * test_regular_volume(dim);
    check_volumes(&mesh.mesh, mesh.coordinates, &options, found);
    for (int64_t i = 0; i < mesh.mesh.n_elements; i++) {
        int n_free = 0;
        for (int j = 0; j <= dim; j++)
            n_free += test_is_inside_box(mesh.coordinates + mesh.elements[i * (dim + 1) + j] * dim,
                                         dim, 4);
        if (n_free > 1)
            assert_int_equal(found[i], PLANISH_VOLUME_BELOW);
        if (n_free == 0)
            assert_int_equal(found[i], PLANISH_VOLUME_INFEASIBLE);
        several += n_free > 1;
    }
    assert_true(several > 0);
    free(found);
    test_mesh_destroy(&mesh);
}

/** Nodes put far outside of their stars come back. */
static void tangled_boxes_become_valid(void **state) {
    int dim = *(int *)*state;
    for (int objective = 0; objective < 3; objective++)
        for (unsigned seed = 0; seed < 5; seed++) {
            test_mesh mesh;
            test_run s;
            unsigned random = seed * 2654435761u;
            test_bad_box(&mesh, dim, 4, seed);
            for (int64_t i = 0; i < mesh.mesh.n_nodes; i++)
                if (test_is_inside_box(mesh.coordinates + i * dim, dim, 4) &&
                    (i == mesh.mesh.n_nodes / 2 || test_random(&random) < 0.15))
                    mesh.coordinates[i * dim + (int64_t)(seed % 2)] += seed % 3 ? 1.7 : -1.4;
            planish_options options = test_options(1);
            options.objective = (planish_objective)objective;
            options.min_volume = 0.2 * test_regular_volume(dim);
            s = test_smooth(&mesh.mesh, &options);
            assert_true(s.before.n_inverted > 0);
            assert_int_equal(s.after.n_inverted, 0);
            assert_int_equal(count_below(&mesh.mesh, s.coordinates, options.min_volume), 0);
            free(s.coordinates);
            test_mesh_destroy(&mesh);
        }
}

/* ---- never worse --------------------------------------------------------------------------- */

static void nothing_becomes_worse(void **state) {
    int dim = *(int *)*state, limited = 0;
    for (unsigned seed = 0; seed < 36; seed++) {
        test_mesh mesh;
        test_run s;
        planish_options options = test_options(1);
        test_bad_box(&mesh, dim, dim == 3 ? 4 : 8, seed);
        options.objective = (planish_objective)(seed % 3);
        options.search = (planish_search)(seed / 3 % 2);
        options.min_volume = 0.3 * (seed / 6 % 3) * test_regular_volume(dim);
        options.area_weight = options.min_volume > 0 ? 0.5 * (seed / 18) : 0;
        options.precision = seed % 5 == 0 ? PLANISH_PRECISION_FLOAT : PLANISH_PRECISION_DOUBLE;
        for (int64_t i = 0; i < mesh.mesh.n_nodes * dim; i++)
            mesh.coordinates[i] = (double)(float)mesh.coordinates[i];
        s = test_smooth(&mesh.mesh, &options);
        assert_int_equal(s.before.n_inverted, 0);
        assert_int_equal(s.after.n_inverted, 0);
        if (count_below(&mesh.mesh, mesh.coordinates, options.min_volume) == 0) {
            assert_true(s.after.max_radius_ratio <= s.before.max_radius_ratio);
            limited++;
        }
        assert_true(s.result.n_moved_nodes > 0);
        for (int64_t i = 0; seed % 5 == 0 && i < mesh.mesh.n_nodes * dim; i++)
            assert_true(s.coordinates[i] == (double)(float)s.coordinates[i]);
        free(s.coordinates);
        test_mesh_destroy(&mesh);
    }
    assert_true(limited > 12);
}

/** An inverted star that is left alone is no licence for the others. */
static void an_inverted_star_excuses_nobody(void **state) {
    int dim = *(int *)*state;
    for (int objective = 0; objective < 3; objective++) {
        test_mesh mesh;
        test_run s;
        test_bad_box(&mesh, dim, 6, 4);
        for (int64_t i = 0; i < mesh.mesh.n_nodes; i++) {
            int central = 1;
            for (int d = 0; d < dim; d++)
                central &= fabs(mesh.coordinates[i * dim + d] - 3) < 0.5;
            mesh.coordinates[i * dim] += central ? 1.6 : 0;
        }
        planish_options options = test_options(1);
        options.objective = (planish_objective)objective;
        options.untangle = 0;
        s = test_smooth(&mesh.mesh, &options);
        assert_true(s.before.n_inverted > 0);
        assert_int_equal(s.after.n_inverted, s.before.n_inverted);
        assert_true(s.after.max_radius_ratio <= s.before.max_radius_ratio);
        free(s.coordinates);
        test_mesh_destroy(&mesh);
    }
}

/** Without untangling nothing is raised, so there is nothing to undo: the sweeps run once. */
static void what_is_left_below_is_swept_once(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    test_run s;
    test_bad_box(&mesh, dim, 4, 6);
    planish_options options = test_options(1);
    options.untangle = 0;
    options.min_volume = 3; /* of cells whose volume is 1 */
    s = test_smooth(&mesh.mesh, &options);
    assert_int_equal(s.result.n_below_min_volume, mesh.mesh.n_elements);
    assert_int_equal(s.result.n_moved_nodes, 0);
    assert_int_equal(s.result.sweeps, 2);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

/* ---- optimality ---------------------------------------------------------------------------- */

static void optimality_is_reported(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    test_run s;
    test_bad_box(&mesh, dim, 4, 6);
    double *own = malloc((size_t)mesh.mesh.n_elements * sizeof *own);
    planish_options options = test_options(1);
    s = test_smooth(&mesh.mesh, &options);
    assert_true(s.result.kkt_residual == 0 && s.result.kkt_rms == 0);
    assert_true(s.result.max_multiplier == 0 && s.result.n_active == 0);
    free(s.coordinates);
    for (int64_t i = 0; i < mesh.mesh.n_elements; i++)
        own[i] = (i % 11 == 5 ? 1.15 : 0.1) * test_regular_volume(dim);
    mesh.mesh.min_volume = own;
    for (int direction = 0; direction < 2; direction++) {
        options.search = (planish_search)direction;
        options.tolerance = 1e-10;
        options.max_sweeps = 2000;
        s = test_smooth(&mesh.mesh, &options);
        assert_true(s.result.max_multiplier > 0 && s.result.n_active > 0);
        assert_true(s.result.kkt_residual < 1e-3 && s.result.kkt_rms <= s.result.kkt_residual);
        free(s.coordinates);
    }
    free(own);
    test_mesh_destroy(&mesh);
}

/** F of the mesh with its coordinates as they are. */
static double objective_at(const planish_mesh *mesh, const planish_options *options) {
    test_run s;
    planish_options still = *options;
    still.max_sweeps = 0;
    s = test_smooth(mesh, &still);
    free(s.coordinates);
    return s.result.objective;
}

/** An element around the free node. */
static int64_t first_element_of(const planish_mesh *mesh, int64_t node) {
    for (int64_t i = 0; i < mesh->n_elements; i++)
        for (int j = 0; j <= mesh->dim; j++)
            if (mesh->elements[i * (mesh->dim + 1) + j] == node)
                return i;
    return -1;
}

/** One free node, one constraint in force: grad F = -lambda grad g, by differences of F. */
static void the_multiplier_is_that_of_f(void **state) {
    int dim = *(int *)*state;
    const double h = 1e-5;
    for (int weight = 0; weight < 2; weight++)
        for (int objective = 0; objective < 3; objective++) {
            test_mesh mesh;
            test_run s;
            test_mesh_box(&mesh, dim, 2);
            const int64_t centre = dim == 3 ? 13 : 4;
            const int64_t element = first_element_of(&mesh.mesh, centre);
            double *own = malloc((size_t)mesh.mesh.n_elements * sizeof *own);
            for (int64_t i = 0; i < mesh.mesh.n_elements; i++)
                own[i] = (i == element ? 1.2 : 0.2) * test_regular_volume(dim);
            mesh.mesh.min_volume = own;
            planish_options options = test_options(1);
            options.objective = (planish_objective)objective;
            options.area_weight = 0.1 * weight;
            options.tolerance = 0;
            options.max_sweeps = 500;
            s = test_smooth(&mesh.mesh, &options);
            assert_int_equal(s.result.n_active, 1);
            for (int d = 0; d < dim; d++) {
                double f[2], g[2];
                for (int side = 0; side < 2; side++) {
                    memcpy(mesh.coordinates, s.coordinates, test_bytes_of(&mesh.mesh));
                    mesh.coordinates[centre * dim + d] += side ? h : -h;
                    f[side] = objective_at(&mesh.mesh, &options);
                    g[side] =
                        1 - test_measure_of(&mesh.mesh, mesh.coordinates, element) / own[element];
                }
                double slope = (f[1] - f[0]) / (2 * h), bend = (g[1] - g[0]) / (2 * h);
                assert_true(fabs(slope + s.result.max_multiplier * bend) < 1e-5);
            }
            assert_true(s.result.max_multiplier > 1e-3);
            free(own);
            free(s.coordinates);
            test_mesh_destroy(&mesh);
        }
}

/* ---- what is refused ----------------------------------------------------------------------- */

/** Elements without a minimum volume cannot have a weight; the message says which. */
static void weights_need_volumes(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    planish_plan *plan;
    planish_error error;
    test_bad_box(&mesh, dim, 3, 1);
    double *own = malloc((size_t)mesh.mesh.n_elements * sizeof *own);
    for (int64_t i = 0; i < mesh.mesh.n_elements; i++)
        own[i] = i == 7 ? 0 : 0.1 * test_regular_volume(dim);
    mesh.mesh.min_volume = own;
    planish_options options = test_options(1);
    options.area_weight = 0.5;
    assert_int_equal(planish_plan_create(&mesh.mesh, NULL, &plan, NULL), 0);
    assert_int_equal(planish_smooth(plan, mesh.coordinates, &options, NULL, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(error.element, 7);
    options.min_volume = 0.1 * test_regular_volume(dim);
    assert_int_equal(planish_smooth(plan, mesh.coordinates, &options, NULL, &error), 0);
    planish_plan_destroy(plan);
    free(own);
    test_mesh_destroy(&mesh);
}

static double to_multiple(double value, void *user) {
    const double unit = *(const double *)user;
    return rint(value / unit) * unit;
}

/** Where elements below their minimum volume are left alone no other one comes below, whatever
 *  coordinates are rounded to. */
static void none_comes_below(void **state) {
    (void)state;
    int64_t moved = 0, kept = 0;
    for (int i = 0; i < 40; i++) {
        test_mesh box;
        test_run s;
        planish_plan *plan;
        planish_options options = test_options(1);
        const int dim = 2 + i % 2;
        double unit = i % 4 < 2 ? 0.1 : 0.03;
        test_bad_box(&box, dim, 6, (unsigned)i);
        options.untangle = 0;
        options.min_volume = 0.95 * test_regular_volume(dim);
        options.precision = PLANISH_PRECISION_ROUNDED;
        options.round = to_multiple;
        options.round_user = &unit;
        s = test_smooth(&box.mesh, &options);
        uint8_t *before = malloc((size_t)box.mesh.n_elements);
        uint8_t *after = malloc((size_t)box.mesh.n_elements);
        int64_t n;
        assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
        assert_int_equal(
            planish_check_volumes(plan, box.coordinates, &options, before, &n, NULL, NULL), 0);
        assert_int_equal(
            planish_check_volumes(plan, s.coordinates, &options, after, &n, NULL, NULL), 0);
        for (int64_t k = 0; k < box.mesh.n_elements; k++) {
            assert_true(before[k] != PLANISH_VOLUME_MET || after[k] == PLANISH_VOLUME_MET);
            kept += before[k] != PLANISH_VOLUME_MET;
        }
        moved += s.result.n_moved_nodes;
        planish_plan_destroy(plan);
        free(before);
        free(after);
        free(s.coordinates);
        test_mesh_destroy(&box);
    }
    assert_true(moved > 0 && kept > 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(none_comes_below),
        BOTH(f_never_rises),
        BOTH(fewer_are_below_whenever_it_ends),
        BOTH(f_is_the_weighted_sum),
        BOTH(minimum_volumes_are_reached),
        BOTH(the_check_agrees_with_the_volumes),
        BOTH(fixed_elements_are_infeasible),
        BOTH(crowded_stars_are_infeasible),
        BOTH(elements_with_free_neighbours_are_not_infeasible),
        BOTH(tangled_boxes_become_valid),
        BOTH(nothing_becomes_worse),
        BOTH(an_inverted_star_excuses_nobody),
        BOTH(what_is_left_below_is_swept_once),
        BOTH(optimality_is_reported),
        BOTH(the_multiplier_is_that_of_f),
        BOTH(weights_need_volumes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
