/* Minimum volumes that are absurd, and meshes that are nearly flat or of extreme size: nothing is
 * broken for their sake. At the end the Laplacian methods, beside which planish is measured. */
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

enum { CELLS = 6 };

/** A plan and a copy of the coordinates to smooth. */
typedef struct work {
    planish_plan *plan;
    planish_options options;
    double *coordinates;
    size_t size;
} work;

static void start(work *w, const planish_mesh *mesh) {
    planish_options_init(&w->options);
    w->options.threads = 1;
    w->size = (size_t)mesh->n_nodes * (size_t)mesh->dim * sizeof(double);
    w->coordinates = malloc(w->size);
    memcpy(w->coordinates, mesh->coordinates, w->size);
    assert_int_equal(planish_plan_create(mesh, &w->options, &w->plan, NULL), 0);
}

static void smooth(work *w, planish_result *result, planish_quality *quality) {
    assert_int_equal(planish_smooth(w->plan, w->coordinates, &w->options, result, NULL), 0);
    assert_int_equal(planish_measure(w->plan, w->coordinates, quality, NULL), 0);
}

static void finish(work *w) {
    planish_plan_destroy(w->plan);
    free(w->coordinates);
}

static void bad_box(test_mesh *mesh, int dim) {
    test_mesh_box(mesh, dim, CELLS);
    test_mesh_perturb(mesh, 0.14, 3);
}

/** Three elements in ten are to be larger than the mean: the others must not be pressed flat. */
static void what_cannot_be_met_destroys_nothing(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    work w;
    planish_result result;
    planish_quality quality;
    unsigned random = 11;
    bad_box(&mesh, dim);
    double *least = calloc((size_t)mesh.mesh.n_elements, sizeof *least);
    for (int64_t i = 0; i < mesh.mesh.n_elements; i++)
        if (test_random(&random) < 0.3)
            least[i] = 1.3 / (dim == 3 ? 6 : 2);
    mesh.mesh.min_volume = least;
    start(&w, &mesh.mesh);
    smooth(&w, &result, &quality);
    assert_int_equal(quality.n_inverted, 0);
    assert_true(dim == 2 || result.n_below_min_volume > 0);
    assert_true(quality.max_radius_ratio < 5000 && result.objective < 200);
    finish(&w);
    free(least);
    test_mesh_destroy(&mesh);
}

/** A node within rounding of its link, and a delta beside which its elements are as nothing. */
static void elements_next_to_nothing_stay_positive(void **state) {
    int dim = *(int *)*state;
    for (int step = 1; step < 40; step++) {
        test_mesh mesh;
        work w;
        planish_result result;
        planish_quality quality;
        test_mesh_box(&mesh, dim, 2);
        int64_t centre = dim == 3 ? 13 : 4;
        mesh.coordinates[centre * dim] = ldexp(1, -step - 12);
        double *least = calloc((size_t)mesh.mesh.n_elements, sizeof *least);
        for (int64_t i = 0; i < mesh.mesh.n_elements; i++)
            least[i] = 1e3 * (double)(i % 3);
        mesh.mesh.min_volume = least;
        start(&w, &mesh.mesh);
        assert_int_equal(planish_measure(w.plan, w.coordinates, &quality, NULL), 0);
        assert_int_equal(quality.n_inverted, 0);
        smooth(&w, &result, &quality);
        assert_int_equal(quality.n_inverted, 0);
        finish(&w);
        free(least);
        test_mesh_destroy(&mesh);
    }
}

/** Deltas that over- or underflow in the star's scale are small or large, and no more. */
static void any_delta_has_a_meaning(void **state) {
    int dim = *(int *)*state;
    static const double deltas[] = {1e-308, 1e-200, 1e-160, 1e-30, 1e30, 1e160, 1e300};
    for (size_t i = 0; i < sizeof deltas / sizeof *deltas; i++)
        for (int weight = 0; weight < 2; weight++) {
            test_mesh mesh;
            work w;
            planish_result result;
            planish_quality quality;
            bad_box(&mesh, dim);
            start(&w, &mesh.mesh);
            w.options.min_volume = deltas[i];
            w.options.area_weight = 0.5 * weight;
            if (weight && deltas[i] < 1) {
                assert_int_equal(planish_smooth(w.plan, w.coordinates, &w.options, &result, NULL),
                                 PLANISH_ERROR_ARGUMENT); /* g^2 of 1e60 and more */
            } else {
                smooth(&w, &result, &quality);
                assert_int_equal(quality.n_inverted, 0);
                assert_true(isfinite(result.objective));
                assert_true(isfinite(result.kkt_rms) == (deltas[i] < 1));
                assert_int_equal(result.n_below_min_volume,
                                 deltas[i] > 1 ? mesh.mesh.n_elements : 0);
                if (deltas[i] < 1)
                    assert_true(quality.rms_radius_ratio < (dim == 3 ? 1.4 : 1.21));
            }
            finish(&w);
            test_mesh_destroy(&mesh);
        }
}

static int check_meanwhile(const planish_progress *progress, void *user) {
    const work *w = user;
    int64_t n_below;
    planish_quality quality;
    (void)progress;
    assert_int_equal(
        planish_check_volumes(w->plan, w->coordinates, &w->options, NULL, &n_below, NULL, NULL), 0);
    assert_true(n_below > 0);
    assert_int_equal(planish_measure(w->plan, w->coordinates, &quality, NULL), 0);
    return 0;
}

/** What may be called while smoothing is under way does not disturb it. */
static void looking_changes_nothing(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    work w, watched;
    planish_result result;
    planish_quality quality;
    bad_box(&mesh, dim);
    start(&w, &mesh.mesh);
    start(&watched, &mesh.mesh);
    w.options.min_volume = watched.options.min_volume = 0.9 / (dim == 3 ? 6 : 2);
    smooth(&w, &result, &quality);
    watched.options.progress = check_meanwhile;
    watched.options.progress_user = &watched;
    smooth(&watched, &result, &quality);
    assert_memory_equal(w.coordinates, watched.coordinates, w.size);
    finish(&w);
    finish(&watched);
    test_mesh_destroy(&mesh);
}

/** The averages, too, move nodes of meshes of any size, and to the same places. */
static void averages_have_no_size(void **state) {
    int dim = *(int *)*state;
    for (int method = PLANISH_METHOD_LAPLACIAN; method <= PLANISH_METHOD_LENGTH_LAPLACIAN; method++)
        for (int exponent = -900; exponent <= 900; exponent += 300) {
            test_mesh mesh, scaled;
            work w, other;
            planish_result result;
            planish_quality quality;
            bad_box(&mesh, dim);
            bad_box(&scaled, dim);
            test_mesh_transform(&scaled, ldexp(1, exponent), 0);
            start(&w, &mesh.mesh);
            start(&other, &scaled.mesh);
            w.options.method = other.options.method = (planish_method)method;
            w.options.max_sweeps = other.options.max_sweeps = 3;
            smooth(&w, &result, &quality);
            smooth(&other, &result, &quality);
            assert_true(result.n_moved_nodes > 0);
            for (size_t i = 0; i < w.size / sizeof(double); i++)
                assert_true(other.coordinates[i] == ldexp(w.coordinates[i], exponent));
            finish(&w);
            finish(&other);
            test_mesh_destroy(&mesh);
            test_mesh_destroy(&scaled);
        }
}

/** A minimum volume decides only what of an average's result is reported as below. */
static void averages_do_not_care_for_volumes(void **state) {
    int dim = *(int *)*state;
    for (int max_sweeps = 1; max_sweeps < 200; max_sweeps *= 4) {
        test_mesh mesh;
        work w, with;
        planish_result result;
        planish_quality quality;
        bad_box(&mesh, dim);
        start(&w, &mesh.mesh);
        start(&with, &mesh.mesh);
        w.options.method = with.options.method = PLANISH_METHOD_LAPLACIAN;
        w.options.max_sweeps = with.options.max_sweeps = max_sweeps;
        with.options.min_volume = 1; /* more than any has */
        smooth(&w, &result, &quality);
        smooth(&with, &result, &quality);
        assert_true(result.n_moved_nodes > 0);
        assert_int_equal(result.n_below_min_volume, mesh.mesh.n_elements);
        assert_memory_equal(w.coordinates, with.coordinates, w.size);
        finish(&w);
        finish(&with);
        test_mesh_destroy(&mesh);
    }
}

/* ---- the Laplacian methods ---------------------------------------------------------------------- */

/* ---- the rivals ---------------------------------------------------------------------------- */

/** The mean that the method moves the node to, from the facets of its elements; node 0 is the
 *  centre, first in every element. */
static void expected_mean(const planish_mesh *mesh, planish_method method, double *to) {
    const int dim = mesh->dim;
    const double *x = mesh->coordinates;
    double weights = 0;
    for (int d = 0; d < dim; d++)
        to[d] = 0;
    for (int64_t i = 1; i < mesh->n_nodes && method != PLANISH_METHOD_AREA_LAPLACIAN; i++) {
        double length = test_distance(x, x + i * dim, dim);
        double weight = method == PLANISH_METHOD_LENGTH_LAPLACIAN ? length : 1;
        weights += weight;
        for (int d = 0; d < dim; d++)
            to[d] += weight * x[i * dim + d];
    }
    for (int64_t i = 0; i < mesh->n_elements && method == PLANISH_METHOD_AREA_LAPLACIAN; i++) {
        double weight = test_measure_of(mesh, x, i);
        weights += weight;
        for (int d = 0; d < dim; d++)
            for (int j = 0; j <= dim; j++)
                to[d] += weight * x[mesh->elements[i * (dim + 1) + j] * dim + d] / (dim + 1);
    }
    for (int d = 0; d < dim; d++)
        to[d] /= weights;
}

/** A node in an uneven square, or octahedron. */
static void one_star(test_mesh *mesh, int dim) {
    static const double square[] = {0.3, -0.2, 2, 0, 0, 1, -1, 0, 0, -3};
    static const int32_t triangles[] = {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1};
    static const double octahedron[] = {0.2, 0.1, -0.1, 2, 0, 0, 0, 1, 0, -1, 0,
                                        0,   0,   -3,   0, 0, 0, 1, 0, 0, -2};
    static const int32_t tetrahedra[] = {0, 1, 2, 5, 0, 2, 3, 5, 0, 3, 4, 5, 0, 4, 1, 5,
                                         0, 2, 1, 6, 0, 3, 2, 6, 0, 4, 3, 6, 0, 1, 4, 6};
    if (dim == 3)
        test_mesh_create(mesh, 3, 7, octahedron, 8, tetrahedra);
    else
        test_mesh_create(mesh, 2, 5, square, 4, triangles);
}

static void averages_are_those_that_they_are_called(void **state) {
    int dim = *(int *)*state;
    for (int method = 1; method < 4; method++) {
        test_mesh mesh;
        test_run s;
        double to[3];
        one_star(&mesh, dim);
        planish_options options = test_options(1);
        options.method = (planish_method)method;
        options.max_sweeps = 1;
        expected_mean(&mesh.mesh, options.method, to);
        s = test_smooth(&mesh.mesh, &options);
        assert_int_equal(s.result.n_moved_nodes, 1);
        for (int d = 0; d < dim; d++)
            assert_true(fabs(s.coordinates[d] - to[d]) < 1e-14);
        free(s.coordinates);
        test_mesh_destroy(&mesh);
    }
}

/** The plain mean by numbers that need no code. */
static void the_plain_mean_is_known(void **state) {
    (void)state;
    test_mesh mesh;
    test_run s;
    one_star(&mesh, 2);
    planish_options options = test_options(1);
    options.method = PLANISH_METHOD_LAPLACIAN;
    s = test_smooth(&mesh.mesh, &options);
    assert_true(fabs(s.coordinates[0] - 0.25) < 1e-15 && fabs(s.coordinates[1] + 0.5) < 1e-15);
    assert_int_equal(s.result.stop, PLANISH_STOP_CONVERGED);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

static void averages_converge_on_convex_boxes(void **state) {
    int dim = *(int *)*state;
    for (int method = 1; method < 4; method++) {
        test_mesh mesh;
        test_run s;
        test_bad_box(&mesh, dim, 5, 1);
        planish_options options = test_options(1);
        options.method = (planish_method)method;
        s = test_smooth(&mesh.mesh, &options);
        assert_int_equal(s.result.stop, PLANISH_STOP_CONVERGED);
        assert_int_equal(s.after.n_inverted, 0);
        assert_true(s.after.rms_radius_ratio < s.before.rms_radius_ratio);
        free(s.coordinates);
        test_mesh_destroy(&mesh);
    }
}

/** The mean of an L's corners is outside of it. */
static void averages_invert_at_reentrant_corners(void **state) {
    (void)state;
    static const double corners[] = {0.5, 0.5, 0, 0, 10, 0, 10, 1, 1, 1, 1, 10, 0, 10};
    static const int32_t triangles[] = {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5, 0, 5, 6, 0, 6, 1};
    test_mesh mesh;
    test_run s;
    test_mesh_create(&mesh, 2, 7, corners, 6, triangles);
    planish_options options = test_options(1);
    options.method = PLANISH_METHOD_LAPLACIAN;
    s = test_smooth(&mesh.mesh, &options);
    assert_int_equal(s.before.n_inverted, 0);
    assert_int_equal(s.after.n_inverted, 2);
    assert_true(fabs(s.coordinates[0] - 22.0 / 6) < 1e-14);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        BOTH(what_cannot_be_met_destroys_nothing),
        BOTH(elements_next_to_nothing_stay_positive),
        BOTH(any_delta_has_a_meaning),
        BOTH(looking_changes_nothing),
        BOTH(averages_have_no_size),
        BOTH(averages_do_not_care_for_volumes),
        BOTH(averages_are_those_that_they_are_called),
        cmocka_unit_test(the_plain_mean_is_known),
        BOTH(averages_converge_on_convex_boxes),
        cmocka_unit_test(averages_invert_at_reentrant_corners),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
