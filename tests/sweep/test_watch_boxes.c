/* Tests of a watch in planish_smooth, of boxes of cells: whenever a call ends they are valid, and none
 * is worse than the worst was. */
#include "support/cell_meshes.h"
#include "support/meshes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/** Ask for the end at the call that user counts down to. */
static int stop_at(const planish_progress *progress, void *user) {
    int *left = user;
    (void)progress;
    return --*left <= 0;
}

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
            box->x[i * dim + d] += 0.3 * (2 * test_random(&seed) - 1);
    cell_box_destroy(plain);
    return box;
}

/** Smooth a copy of the box's coordinates until the progress function has been called so often. */
static double *smooth_box(const cell_box *box, int calls, planish_result *result) {
    const size_t size = (size_t)(box->mesh.n_nodes * box->mesh.dim) * sizeof(double);
    planish_options o;
    planish_plan *plan = NULL;
    planish_error error;
    double *x = malloc(size);
    planish_options_init(&o);
    o.threads = 1;
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

/** The worst aspect ratio of a box at x; 0: not all of its cells are valid. */
static double worst_ratio(const cell_box *box, const double *x) {
    planish_mesh mesh = box->mesh;
    planish_cell_quality quality;
    planish_error error;
    mesh.coordinates = x;
    if (planish_measure_cells(&mesh, 0, 1, &quality, NULL, &error))
        fail_msg("%s", error.text);
    return quality.all.n_inverted == 0 ? quality.all.max_aspect_ratio : 0;
}

/** The star of a node has half of the corners of a hexahedron, two thirds of those of a wedge. Where the
 *  others are bad, and held by the boundary, the cell may get worse though no corner that the star has
 *  is as bad as the worst cell. Sweeps see to it, so that nothing is put back at the end. */
static void corners_beyond_a_star_count(void **state) {
    enum { MESHES = 200 };
    static const cell_box_kind kinds[] = {BOX_HEXAHEDRA, BOX_WEDGES};
    (void)state;
    for (int k = 0; k < 4; k++) {
        unsigned seed = 3;
        int n = 0;
        for (int i = 0; i < MESHES; i++) {
            cell_box *box = cell_box_create(kinds[k % 2], 2 + k / 2);
            for (int64_t c = 0; c < box->mesh.n_nodes * 3; c++)
                box->x[c] += 0.3 * (2 * test_random(&seed) - 1);
            const double before = worst_ratio(box, box->x);
            if (before > 0) {
                planish_result result;
                double *x = smooth_box(box, 20, &result);
                const double after = worst_ratio(box, x);
                assert_true(after > 0 && after <= before * (1 + 1e-12));
                assert_int_equal(result.n_put_back, 0);
                n += result.n_moved_nodes > 0;
                free(x);
            }
            cell_box_destroy(box);
        }
        assert_true(n > MESHES / 4);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_stop_leaves_a_cell_invalid),
        cmocka_unit_test(corners_beyond_a_star_count),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
