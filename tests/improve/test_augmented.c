/* Minimum volumes that several nodes share: the trial by augmented Lagrangian wins what single
 * nodes cannot, and nobody sees it before it has. */
#include "support/meshes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { CELLS = 4, MOST_SWEEPS = 400 };

/** F after each sweep, and where to stop. */
typedef struct history {
    double objective[MOST_SWEEPS];
    int n_sweeps, stop_at; /* stop in the middle of this sweep; 0: do not */
} history;

static int record(const planish_progress *progress, void *user) {
    history *h = user;
    if (progress->sweep_done) {
        assert_true(progress->sweep <= MOST_SWEEPS);
        h->objective[progress->sweep - 1] = progress->objective;
        h->n_sweeps = progress->sweep;
    }
    return h->stop_at > 0 && progress->sweep == h->stop_at && progress->colour > 1;
}

/** A box that is graded, so that the same delta is far away for some elements and not for others.
 */
static void graded_box(test_mesh *mesh, int dim) {
    test_mesh_box(mesh, dim, CELLS);
    test_mesh_perturb(mesh, 0.14, 5);
    for (int64_t i = 0; i < mesh->mesh.n_nodes * dim; i++)
        mesh->coordinates[i] *= 0.5 + 0.5 * mesh->coordinates[i] / CELLS;
}

/** Smooth a copy of the mesh with many elements on their minimum volume; returns its coordinates.
 */
static double *smooth(const test_mesh *mesh, int max_sweeps, history *h, planish_result *result) {
    planish_plan *plan;
    planish_options options;
    size_t size = (size_t)mesh->mesh.n_nodes * (size_t)mesh->mesh.dim * sizeof(double);
    double *coordinates = malloc(size);
    memcpy(coordinates, mesh->coordinates, size);
    planish_options_init(&options);
    options.threads = 1;
    options.max_sweeps = max_sweeps;
    options.min_volume_fraction = mesh->mesh.dim == 3 ? 0.0012 : 0.02;
    options.progress = record;
    options.progress_user = h;
    assert_int_equal(planish_plan_create(&mesh->mesh, &options, &plan, NULL), 0);
    assert_int_equal(planish_smooth(plan, coordinates, &options, result, NULL), 0);
    planish_plan_destroy(plan);
    return coordinates;
}

/** The first sweep of the trial: F then stays as it is for several. */
static int trial_begins(const history *h) {
    for (int i = 1; i + 2 < h->n_sweeps; i++)
        if (h->objective[i] == h->objective[i - 1] && h->objective[i + 2] == h->objective[i])
            return i + 1;
    return 0;
}

static void the_trial_wins(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    history h = {.stop_at = 0};
    planish_result result;
    graded_box(&mesh, dim);
    free(smooth(&mesh, MOST_SWEEPS, &h, &result));
    int trial = trial_begins(&h);
    assert_true(trial > 1);
    assert_int_equal(result.stop, PLANISH_STOP_CONVERGED);
    assert_int_equal(result.n_below_min_volume, 0);
    assert_true(result.n_active > 0 && result.max_multiplier > 0);
    assert_true(result.objective < h.objective[trial - 1] * (1 - 1e-5));
    assert_true(h.objective[h.n_sweeps - 1] == result.objective ||
                fabs(h.objective[h.n_sweeps - 1] / result.objective - 1) < 1e-12);
    test_mesh_destroy(&mesh);
}

/** Stopped in the middle of the trial, or with no sweeps left for it, the mesh is the one before.
 */
static void a_trial_cut_short_leaves_no_trace(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    history whole = {.stop_at = 0}, shorter = whole;
    planish_result result, before;
    graded_box(&mesh, dim);
    size_t size = (size_t)mesh.mesh.n_nodes * (size_t)dim * sizeof(double);
    free(smooth(&mesh, MOST_SWEEPS, &whole, &result));
    int trial = trial_begins(&whole);
    double *standing = smooth(&mesh, trial - 1, &shorter, &before);
    for (int later = 0; later < 3; later++) {
        history h = {.stop_at = trial + later};
        double *coordinates = smooth(&mesh, MOST_SWEEPS, &h, &result);
        assert_int_equal(result.stop, PLANISH_STOP_INTERRUPTED);
        assert_memory_equal(coordinates, standing, size);
        assert_true(result.objective == before.objective);
        free(coordinates);
        coordinates = smooth(&mesh, trial + later, &shorter, &result);
        assert_memory_equal(coordinates, standing, size);
        free(coordinates);
    }
    free(standing);
    test_mesh_destroy(&mesh);
}

int main(void) {
    static int two = 2, three = 3;
    const struct CMUnitTest tests[] = {
        {"the trial wins 2-D", the_trial_wins, NULL, NULL, &two},
        {"the trial wins 3-D", the_trial_wins, NULL, NULL, &three},
        {"cut short 2-D", a_trial_cut_short_leaves_no_trace, NULL, NULL, &two},
        {"cut short 3-D", a_trial_cut_short_leaves_no_trace, NULL, NULL, &three},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
