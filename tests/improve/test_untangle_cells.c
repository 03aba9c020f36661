/* What planish_smooth promises of tangled meshes of cells of every type. */
#include "support/allocations.h"
#include "support/cell_meshes.h"
#include "support/effort.h"
#include "support/run.h"

#include "geometry/cell.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* The RMS of a mesh that was untangled may be larger than that of the test_run original by
 * this factor: both are local optima. */
#define AS_GOOD 1.02

enum { BOX = 4 }; /* cubes along a side */

/** A box smoothed: its quality before and after, and the result. */
typedef struct cell_run {
    planish_cell_quality before, after;
    planish_result result;
    double *x; /* to be freed */
} cell_run;

static cell_run smooth_box(const cell_box *box, const planish_options *options) {
    cell_run r;
    planish_plan *plan;
    planish_mesh mesh = box->mesh;
    r.x = test_copy_of(&mesh);
    assert_int_equal(planish_plan_create(&mesh, options, &plan, NULL), 0);
    assert_int_equal(planish_measure_cells(&mesh, 0, 1, &r.before, NULL, NULL), 0);
    assert_int_equal(planish_smooth(plan, r.x, options, &r.result, NULL), 0);
    mesh.coordinates = r.x;
    assert_int_equal(planish_measure_cells(&mesh, 0, 1, &r.after, NULL, NULL), 0);
    assert_int_equal(r.result.n_inverted, r.after.all.n_inverted);
    planish_plan_destroy(plan);
    return r;
}

/** Nodes on the box's sides stay. */
static void expect_sides(const cell_box *box, int n, const double *x) {
    const int dim = box->mesh.dim;
    for (int64_t i = 0; i < box->mesh.n_nodes; i++) {
        const double *at = box->x + i * dim;
        int is_outside = 0;
        for (int d = 0; d < dim; d++)
            is_outside |= !(at[d] > 0 && at[d] < n);
        if (is_outside)
            assert_memory_equal(x + i * dim, at, (size_t)dim * sizeof *x);
    }
}

static void cells_of_every_type_are_untangled(void **state) {
    enum { SEEDS = 4 };
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++)
        for (uint64_t seed = 1; seed <= SEEDS; seed += (uint64_t)effort_step(3)) {
            planish_options options = test_options(1);
            cell_box *box = cell_box_create((cell_box_kind)kind, BOX);
            cell_box *start = cell_box_create((cell_box_kind)kind, BOX);
            cell_box_shake(box, seed % 2 ? 0.8 : 2.5, seed);
            options.max_sweeps = 50;
            const cell_run s = smooth_box(box, &options);
            assert_true(s.before.all.n_inverted > 0);
            assert_int_equal(s.after.all.n_inverted, 0);
            assert_int_equal(s.result.n_inverted, 0);
            assert_true(s.result.untangling_sweeps > 0);
            const cell_run valid = smooth_box(start, &options);
            assert_true(s.after.all.rms_aspect_ratio < AS_GOOD * valid.after.all.rms_aspect_ratio);
            expect_sides(start, BOX, s.x);
            free(s.x);
            free(valid.x);
            cell_box_destroy(box);
            cell_box_destroy(start);
        }
}

/** Elements of order 2: nodes of edges follow. */
static void cells_of_order_2_are_untangled(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++) {
        planish_options options = test_options(1);
        cell_box *box = cell_box_create((cell_box_kind)kind, BOX);
        cell_box_shake(box, 0.8, 7);
        cell_box *raised = cell_box_raise(box, 0);
        options.max_sweeps = 50;
        const cell_run s = smooth_box(raised, &options);
        assert_true(s.before.all.n_inverted > 0);
        assert_int_equal(s.after.all.n_inverted, 0);
        free(s.x);
        cell_box_destroy(raised);
        cell_box_destroy(box);
    }
}

/** A call that is stopped anywhere leaves no more inverted than there were. */
static int stop_later(const planish_progress *progress, void *user) {
    int64_t *left = user;
    (void)progress;
    return --*left < 0;
}

static void cells_may_be_stopped_at_any_call(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++)
        for (int64_t calls = 0; calls < 60; calls += 1 + calls / 4) {
            planish_options options = test_options(1);
            cell_box *box = cell_box_create((cell_box_kind)kind, BOX);
            cell_box_shake(box, 1.5, 11);
            int64_t left = calls;
            options.progress = stop_later;
            options.progress_user = &left;
            const cell_run s = smooth_box(box, &options);
            assert_true(s.after.all.n_inverted <= s.before.all.n_inverted);
            assert_true(left >= 0 || s.result.stop == PLANISH_STOP_INTERRUPTED);
            free(s.x);
            cell_box_destroy(box);
        }
}

/** Make a high box of hexahedra with positive corners and one that is invalid inside: between flat
 *  rectangles that are turned against one another. */
static cell_box *create_turned(void) {
    enum { N = 3 };
    static const double COSINE = 0.5, SINE = 0.86602540378443865, HEIGHT = 5, FLAT = 0.15;
    cell_box *box = cell_box_create(BOX_HEXAHEDRA, N);
    for (int64_t i = 0; i < box->mesh.n_nodes; i++) {
        double *x = box->x + i * 3;
        const int is_upper = x[2] > 1.5;
        int is_inside = 1;
        for (int d = 0; d < 3; d++)
            is_inside &= x[d] > 0 && x[d] < N;
        x[2] *= HEIGHT;
        if (!is_inside)
            continue;
        const double u = (x[0] - 1.5) * (is_upper ? FLAT : 1) * 0.5;
        const double v = (x[1] - 1.5) * (is_upper ? 1 : FLAT) * 0.5;
        const double sine = is_upper ? -SINE : SINE;
        x[0] = 1.5 + COSINE * u - sine * v;
        x[1] = 1.5 + sine * u + COSINE * v;
    }
    return box;
}

/** Coefficients decide and mend what corners do not show. */
static void cells_invalid_inside_are_mended(void **state) {
    planish_options options = test_options(1);
    cell_box *box = create_turned();
    (void)state;
    options.max_sweeps = 0;
    const cell_run s = smooth_box(box, &options);
    assert_int_equal(s.before.all.n_inverted, 1);
    assert_int_equal(s.before.all.n_inverted_corners, 0);
    assert_int_equal(s.after.all.n_inverted, 0);
    assert_true(s.result.untangling_sweeps > 0);
    options.untangle = 0;
    const cell_run as_it_is = smooth_box(box, &options);
    assert_int_equal(as_it_is.after.all.n_inverted, 1);
    free(s.x);
    free(as_it_is.x);
    cell_box_destroy(box);
}

/** Smooth a box with an allocation that fails; returns whether it did. */
static int without_one_of_cells(const cell_box *box, int64_t permitted, int64_t inverted) {
    planish_options options = test_options(1);
    planish_mesh mesh = box->mesh;
    planish_cell_quality after;
    planish_plan *plan;
    double *x = test_copy_of(&mesh);
    options.max_sweeps = 1;
    assert_int_equal(planish_plan_create(&mesh, &options, &plan, NULL), 0);
    allocations_fail_one(permitted);
    const int status = planish_smooth(plan, x, &options, NULL, NULL);
    allocations_permit(-1);
    const int failed = allocations_failed();
    planish_plan_destroy(plan);
    assert_true(status == PLANISH_OK || status == PLANISH_ERROR_MEMORY);
    mesh.coordinates = x;
    assert_int_equal(planish_measure_cells(&mesh, 0, 1, &after, NULL, NULL), 0);
    assert_true(after.all.n_inverted <= inverted);
    if (status == PLANISH_ERROR_MEMORY)
        assert_memory_equal(x, box->x, test_bytes_of(&mesh));
    free(x);
    return failed;
}

static void without_memory_cells_are_not_spoilt(void **state) {
    (void)state;
    for (int kind = 0; kind <= N_BOX_KINDS; kind++) {
        cell_box *box =
            kind < N_BOX_KINDS ? cell_box_create((cell_box_kind)kind, 3) : create_turned();
        planish_cell_quality before;
        int64_t n = 0;
        if (kind < N_BOX_KINDS)
            cell_box_shake(box, 2, 9);
        assert_int_equal(planish_measure_cells(&box->mesh, 0, 1, &before, NULL, NULL), 0);
        while (without_one_of_cells(box, n, before.all.n_inverted))
            n += effort_step(3);
        assert_true(n > 10);
        cell_box_destroy(box);
    }
}

/** A corner of the box whose fixed nodes alone invert it: its cell is named, all else is mended. */
static void hopeless_cells_are_named(void **state) {
    static const cell_box_kind kinds[] = {BOX_QUADRILATERALS, BOX_HEXAHEDRA, BOX_WEDGES};
    (void)state;
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        planish_options options = test_options(1);
        cell_box *box = cell_box_create(kinds[k], BOX);
        const int dim = box->mesh.dim;
        uint8_t *found = calloc((size_t)box->cells.n, 1);
        planish_plan *plan;
        int64_t n = 0;
        cell_box_shake(box, 0.8, 3);
        for (int d = 0; d < dim; d++)
            box->x[d] = 0.8;
        const cell_run s = smooth_box(box, &options);
        assert_int_equal(planish_plan_create(&box->mesh, &options, &plan, NULL), 0);
        assert_int_equal(planish_find_infeasible(plan, s.x, NULL, found, &n, NULL, NULL), 0);
        assert_true(n > 0);
        assert_int_equal(s.after.all.n_inverted, n);
        for (int64_t c = 0; c < box->cells.n; c++) {
            int has_it = 0;
            for (int64_t i = box->offset[c]; i < box->offset[c + 1]; i++)
                has_it |= box->node[i] == 0;
            assert_true(!found[c] || has_it);
        }
        planish_plan_destroy(plan);
        free(found);
        free(s.x);
        cell_box_destroy(box);
    }
}

static void bits_of_cells_do_not_depend_on_threads_or_kernel(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++) {
        planish_options options = test_options(1);
        cell_box *box = cell_box_create((cell_box_kind)kind, BOX);
        cell_box_shake(box, 1, 5);
        options.isa = PLANISH_ISA_PLAIN;
        options.max_sweeps = 3;
        const cell_run first = smooth_box(box, &options);
        assert_true(first.result.untangling_sweeps > 0);
        for (int k = PLANISH_ISA_AUTO; k <= PLANISH_ISA_AVX512; k++) {
            options.isa = (planish_isa)k;
            options.threads = 1 + k % 3;
            if (!test_has_isa((int)options.isa))
                continue;
            const cell_run other = smooth_box(box, &options);
            assert_memory_equal(first.x, other.x, test_bytes_of(&box->mesh));
            assert_int_equal(first.result.visits, other.result.visits);
            free(other.x);
        }
        free(first.x);
        cell_box_destroy(box);
    }
}

/* ---- periodic cells that are valid though straight corners are turned ----------------------------- */

enum { SIDE = 3, CORNERS = (SIDE + 1) * (SIDE + 1) * (SIDE + 1), N_DRAWN = 40 };

static double draw(uint64_t *seed) {
    *seed = *seed * 6364136223846793005U + 1442695040888963407U;
    return (double)(*seed >> 11) * 0x1p-53;
}

static int32_t corner_at(int i, int j, int k) {
    return (int32_t)(i + (SIDE + 1) * (j + (SIDE + 1) * k));
}

/** Add part of a way to a corner's mids, which are those of edges. */
static void move_mids(cell_box *box, int32_t corner, const double way[3], double part,
                      uint8_t *is_moved) {
    memset(is_moved, 0, (size_t)box->mesh.n_nodes);
    for (int64_t c = 0; c < box->cells.n; c++)
        for (int j = 8; j < 20; j++) {
            const uint8_t *pair = pl_cell_type_of(PLANISH_CELL_HEXAHEDRON20)->between[j];
            const int32_t *node = box->node + box->offset[c];
            if ((node[pair[0]] != corner && node[pair[1]] != corner) || is_moved[node[j]])
                continue;
            is_moved[node[j]] = 1;
            for (int d = 0; d < 3; d++)
                box->x[3 * (int64_t)node[j] + d] += part * way[d];
        }
}

static int is_inside(const double *x) {
    return x[0] > 0 && x[1] > 0 && x[2] > 0 && x[0] < SIDE && x[1] < SIDE && x[2] < SIDE;
}

/** Push mids near the face of largest x about, so that cells become nearly invalid, but none does. */
static void push_mids(cell_box *box, uint64_t *seed) {
    enum { TRIES = 300 };
    double now[SIDE * SIDE * SIDE], tried[SIDE * SIDE * SIDE];
    planish_cell_quality quality;
    const planish_cell_values first = {.jacobian_ratio = now}, then = {.jacobian_ratio = tried};
    assert_int_equal(planish_measure_cells(&box->mesh, 0, 1, &quality, &first, NULL), 0);
    for (int t = 0; t < TRIES; t++) {
        const int64_t mid = CORNERS + (int64_t)(draw(seed) * (double)(box->mesh.n_nodes - CORNERS));
        double *x = box->x + 3 * mid, old[3], sum = 0, least = 1;
        if (!is_inside(x) || x[0] < SIDE - 1.1)
            continue;
        memcpy(old, x, sizeof old);
        for (int d = 0; d < 3; d++)
            x[d] += 0.4 * (2 * draw(seed) - 1);
        assert_int_equal(planish_measure_cells(&box->mesh, 0, 1, &quality, &then, NULL), 0);
        for (int c = 0; c < SIDE * SIDE * SIDE; c++) {
            sum += tried[c] - now[c];
            least = tried[c] != now[c] && tried[c] < least ? tried[c] : least;
        }
        if (sum < 0 && least > 0.005)
            memcpy(now, tried, sizeof now);
        else
            memcpy(x, old, sizeof old);
    }
}

/** A box of hexahedra of order 2, periodic along x: corners inside are drawn so far that straight cells would be
 *  inverted, and their mids after them. */
static cell_box *periodic_box(uint64_t seed, int32_t (*pair)[2], uint8_t *constraint,
                              double *direction) {
    cell_box *straight = cell_box_create(BOX_HEXAHEDRA, SIDE);
    cell_box *box = cell_box_raise(straight, 0);
    uint8_t *is_moved = malloc((size_t)box->mesh.n_nodes);
    int n = 0;
    cell_box_destroy(straight);
    for (int t = 1 + (int)(3 * draw(&seed)); t > 0; t--) {
        const int32_t v =
            corner_at(1 + (draw(&seed) < 0.5), 1 + (draw(&seed) < 0.5), 1 + (draw(&seed) < 0.5));
        double way[3];
        for (int d = 0; d < 3; d++) {
            way[d] = (draw(&seed) < 0.5 ? 1 : -1) * (0.3 + 0.1 * draw(&seed));
            box->x[3 * v + d] += way[d];
        }
        move_mids(box, v, way, 0.75, is_moved);
    }
    for (int j = 0; j <= SIDE; j++)
        for (int k = 0; k <= SIDE; k++, n++) {
            const double way[3] = {0, draw(&seed) - 0.5, draw(&seed) - 0.5};
            for (int end = 0; end < 2; end++) {
                const int32_t v = pair[n][end] = corner_at(end * SIDE, j, k);
                if (j == 0 || k == 0 || j == SIDE || k == SIDE)
                    continue;
                constraint[v] = PLANISH_CONSTRAINT_ON_PLANE;
                direction[3 * v] = 1;
                for (int d = 0; d < 3; d++)
                    box->x[3 * v + d] += way[d];
                move_mids(box, v, way, 0.5, is_moved);
            }
        }
    push_mids(box, &seed);
    free(is_moved);
    return box;
}

/** Smooth a periodic box: no cell that was valid is not in the end, unless fewer are invalid. */
static void check_periodic_box(uint64_t seed) {
    enum { N_CELLS = SIDE * SIDE * SIDE, MOST_NODES = CORNERS + 3 * CORNERS };
    static uint8_t constraint[MOST_NODES];
    static double direction[3 * MOST_NODES];
    int32_t pair[(SIDE + 1) * (SIDE + 1)][2];
    uint8_t before[N_CELLS], after[N_CELLS];
    const planish_cell_values of[] = {{.state = before}, {.state = after}};
    planish_options options = test_options(1);
    memset(constraint, 0, sizeof constraint);
    memset(direction, 0, sizeof direction);
    cell_box *box = periodic_box(seed, pair, constraint, direction);
    box->mesh.periodic = pair[0];
    box->mesh.n_periodic = sizeof pair / sizeof *pair;
    box->mesh.constraint = constraint;
    box->mesh.direction = direction;
    options.max_sweeps = 80;
    cell_run r = smooth_box(box, &options);
    planish_mesh mesh = box->mesh;
    int64_t n_broken = 0;
    assert_int_equal(planish_measure_cells(&mesh, 0, 1, &r.before, &of[0], NULL), 0);
    mesh.coordinates = r.x;
    assert_int_equal(planish_measure_cells(&mesh, 0, 1, &r.after, &of[1], NULL), 0);
    for (int c = 0; c < N_CELLS; c++)
        n_broken += before[c] == PLANISH_CELL_STATE_VALID && after[c] != PLANISH_CELL_STATE_VALID;
    if (n_broken > 0 && r.after.all.n_inverted >= r.before.all.n_inverted)
        fail_msg("seed %d: %d cells", (int)seed, (int)n_broken);
    free(r.x);
    cell_box_destroy(box);
}

static void periodic_cells_that_are_valid_stay_so(void **state) {
    (void)state;
    for (uint64_t seed = 1; seed <= N_DRAWN; seed += (uint64_t)effort_step(4))
        check_periodic_box(seed);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cells_of_every_type_are_untangled),
        cmocka_unit_test(cells_of_order_2_are_untangled),
        cmocka_unit_test(cells_may_be_stopped_at_any_call),
        cmocka_unit_test(cells_invalid_inside_are_mended),
        cmocka_unit_test(without_memory_cells_are_not_spoilt),
        cmocka_unit_test(hopeless_cells_are_named),
        cmocka_unit_test(bits_of_cells_do_not_depend_on_threads_or_kernel),
        cmocka_unit_test(periodic_cells_that_are_valid_stay_so),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
