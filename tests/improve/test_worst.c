/* The worst elements: what options.worst brings and what it may cost, and that no smoothing makes
 * the worst RR or the smallest angle of a mesh worse. */
#include "support/allocations.h"
#include "support/both.h"
#include "support/effort.h"
#include "support/meshes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { CELLS = 6 };

/* RR that rounding may add to an element that has not moved, relative; and degrees that the arc
 * cosine may take off. */
#define RATIO_ROUNDING 1e-12
#define ANGLE_ROUNDING 1e-10

static planish_options defaults(planish_worst worst) {
    planish_options options;
    planish_options_init(&options);
    options.threads = 1;
    options.worst = worst;
    return options;
}

/** A run with a plan of its own. */
typedef struct run {
    double *coordinates; /* [n][dim] owned */
    planish_result result;
    planish_quality before, after;
} run;

static size_t bytes_of(const planish_mesh *mesh) {
    return (size_t)(mesh->n_nodes * mesh->dim) * sizeof(double);
}

static run smooth(const planish_mesh *mesh, const planish_options *options) {
    run r;
    planish_plan *plan;
    r.coordinates = malloc(bytes_of(mesh));
    memcpy(r.coordinates, mesh->coordinates, bytes_of(mesh));
    assert_int_equal(planish_plan_create(mesh, options, &plan, NULL), 0);
    assert_int_equal(planish_measure(plan, r.coordinates, &r.before, NULL), 0);
    assert_int_equal(planish_smooth(plan, r.coordinates, options, &r.result, NULL), 0);
    assert_int_equal(planish_measure(plan, r.coordinates, &r.after, NULL), 0);
    planish_plan_destroy(plan);
    return r;
}

static void release(run *r) {
    free(r->coordinates);
}

static void expect_no_worse(const planish_quality *before, const planish_quality *after) {
    assert_int_equal(after->n_inverted, 0);
    assert_true(after->max_radius_ratio <= before->max_radius_ratio * (1 + RATIO_ROUNDING));
    assert_true(after->min_angle_deg >= before->min_angle_deg - ANGLE_ROUNDING);
    assert_true(after->max_radius_ratio_movable <=
                before->max_radius_ratio_movable * (1 + RATIO_ROUNDING));
    assert_true(after->min_angle_deg_movable >= before->min_angle_deg_movable - ANGLE_ROUNDING);
}

static int is_outside(const double *x, int dim) {
    int outside = 0;
    for (int d = 0; d < dim; d++)
        outside |= x[d] == 0 || x[d] == CELLS;
    return outside;
}

/** All nodes inside anywhere near where they were. */
static void shake(test_mesh *mesh, double amount, unsigned seed) {
    const int dim = mesh->mesh.dim;
    for (int64_t i = 0; i < mesh->mesh.n_nodes; i++) {
        double *x = mesh->coordinates + i * dim;
        const double most = is_outside(x, dim) ? 0 : amount;
        for (int d = 0; d < dim; d++)
            x[d] += most * (2 * test_random(&seed) - 1);
    }
}

/** A box whose nodes inside were shaken; some of them stay where it is, so that good elements
 *  are not to be had everywhere. Its constraints are the mesh's own. */
static void uneven_box_of(test_mesh *mesh, int dim, double amount, double held, unsigned seed) {
    test_mesh_box(mesh, dim, CELLS);
    shake(mesh, amount, seed);
    uint8_t *constraint = calloc((size_t)mesh->mesh.n_nodes, 1);
    for (int64_t i = 0; i < mesh->mesh.n_nodes; i++)
        constraint[i] =
            test_random(&seed) < held ? PLANISH_CONSTRAINT_FIXED : PLANISH_CONSTRAINT_FREE;
    mesh->mesh.constraint = constraint;
}

static void uneven_box(test_mesh *mesh, int dim, unsigned seed) {
    uneven_box_of(mesh, dim, 0.14, 0.15, seed);
}

static void destroy(test_mesh *mesh) {
    free((void *)(uintptr_t)mesh->mesh.constraint);
    test_mesh_destroy(mesh);
}

/* ---- the phase for the worst --------------------------------------------------------------- */

static double worst_of(planish_worst worst, const planish_quality *q) {
    return worst == PLANISH_WORST_ANGLE ? q->min_angle_deg_movable : q->max_radius_ratio_movable;
}

/** The measure that is not asked for becomes no worse than the worst of the input, and no angle larger than
 *  the largest of the input and of the smoothed mesh. Return whether it is no worse than the worst of the
 *  smoothed mesh, either: only where that is in the way of the worst element it is given up. */
static int is_other_kept(int worst, const planish_quality *before, const planish_quality *smoothed,
                         const planish_quality *after) {
    expect_no_worse(before, after);
    if (worst != PLANISH_WORST_ANGLE)
        return after->min_angle_deg_movable >= smoothed->min_angle_deg_movable - ANGLE_ROUNDING;
    assert_true(after->max_angle_deg <=
                fmax(before->max_angle_deg, smoothed->max_angle_deg) + ANGLE_ROUNDING);
    return after->max_radius_ratio_movable <=
           smoothed->max_radius_ratio_movable * (1 + RATIO_ROUNDING);
}

/** The worst becomes better than by the RMS alone, in the measure that is asked for; F rises by no
 *  more than it may, and all of that is said. */
static void the_worst_becomes_better(void **state) {
    enum { SEEDS = 6 };
    const int dim = *(int *)*state;
    int n_better[3] = {0}, n_same[3] = {0}, n_kept = 0;
    for (unsigned seed = 1; seed <= SEEDS; seed++) {
        test_mesh box;
        uneven_box(&box, dim, seed);
        planish_options options = defaults(PLANISH_WORST_NONE);
        run plain = smooth(&box.mesh, &options);
        assert_true(plain.result.worst_sweeps == 0 && plain.result.objective_of_worst == 0);
        for (int worst = PLANISH_WORST_RADIUS_RATIO; worst <= PLANISH_WORST_ANGLE; worst++) {
            options = defaults((planish_worst)worst);
            options.worst_rise = 0.03;
            run r = smooth(&box.mesh, &options);
            const double better = worst_of(options.worst, &r.after),
                         was = worst_of(options.worst, &plain.after);
            n_better[worst] +=
                worst == PLANISH_WORST_ANGLE ? better > was + 0.3 : better < was - 0.01;
            n_same[worst] += better == was;
            assert_true(worst == PLANISH_WORST_ANGLE ? better >= was : better <= was);
            n_kept += is_other_kept(worst, &r.before, &plain.after, &r.after);
            assert_int_equal(r.result.stop, PLANISH_STOP_CONVERGED);
            assert_true(r.result.worst_sweeps > 0 &&
                        r.result.sweeps == plain.result.sweeps + r.result.worst_sweeps);
            assert_true(r.result.objective_of_worst == plain.result.objective);
            assert_true((r.result.objective > plain.result.objective) == (better != was));
            assert_true(r.result.objective <= plain.result.objective * 1.03);
            assert_true(fabs(r.result.worst_before / was - 1) < 1e-9);
            assert_true(fabs(r.result.worst_after / better - 1) < 1e-9);
            release(&r);
        }
        release(&plain);
        destroy(&box);
    }
    for (int worst = PLANISH_WORST_RADIUS_RATIO; worst <= PLANISH_WORST_ANGLE; worst++)
        assert_true(n_better[worst] >= SEEDS / 2 && n_same[worst] <= 1);
    assert_true(n_kept >= SEEDS);
}

/* Steps of patches end this near to the limit of the whole mesh: degrees. */
#define OF_LIMIT 0.3

/** Steps of patches reach the limit of the whole mesh, which sequential linear programs over all nodes
 *  found for boxes in space. */
static void the_limit_is_reached(void **state) {
    (void)state;
    static const double limits[] = {39.188, 39.804, 39.601, 39.574, 39.720, 39.242};
    for (unsigned seed = 1; seed <= sizeof limits / sizeof *limits; seed++) {
        test_mesh box;
        uneven_box(&box, 3, seed);
        planish_options options = defaults(PLANISH_WORST_ANGLE);
        options.worst_rise = 10;
        run r = smooth(&box.mesh, &options);
        assert_true(r.after.min_angle_deg_movable > limits[seed - 1] - OF_LIMIT);
        assert_true(r.after.max_angle_deg <= r.before.max_angle_deg + ANGLE_ROUNDING);
        release(&r);
        destroy(&box);
    }
}

/** A node with more elements than a patch has room for is moved by no patch: the mesh keeps all that is
 *  promised, and its other nodes become better. */
static void a_node_of_very_many_elements_is_left(void **state) {
    (void)state;
    enum { RIM = 1500, RINGS = 3, NODES = 1 + RIM * RINGS, TRIANGLES = RIM * (2 * RINGS - 1) };
    double *x = malloc(2 * NODES * sizeof *x);
    int32_t *triangle = malloc(3 * TRIANGLES * sizeof *triangle), *to = triangle;
    unsigned seed = 4;
    x[0] = x[1] = 0;
    for (int i = 0; i < RIM; i++) {
        const int32_t next = (i + 1) % RIM;
        for (int k = 0; k < RINGS; k++) {
            const int32_t a = 1 + RIM * k + i, b = 1 + RIM * k + next;
            const double turn = i + (k == RINGS - 1 ? 0 : 0.5 * test_random(&seed));
            const double radius = 1 + 0.005 * k;
            x[2 * a] = radius * cos(turn * 2 * 3.14159265358979 / RIM);
            x[2 * a + 1] = radius * sin(turn * 2 * 3.14159265358979 / RIM);
            const int32_t inner[3] = {k == 0 ? 0 : a - RIM, a, b};
            memcpy(to, inner, sizeof inner);
            to += 3;
            if (k > 0) {
                const int32_t outer[3] = {a - RIM, b, b - RIM};
                memcpy(to, outer, sizeof outer);
                to += 3;
            }
        }
    }
    test_mesh hub;
    test_mesh_create(&hub, 2, NODES, x, TRIANGLES, triangle);
    planish_options options = defaults(PLANISH_WORST_RADIUS_RATIO);
    options.worst_rise = 10;
    run r = smooth(&hub.mesh, &options);
    expect_no_worse(&r.before, &r.after);
    assert_true(r.result.worst_sweeps > 0);
    release(&r);
    test_mesh_destroy(&hub);
    free(x);
    free(triangle);
}

/* What may rise farther may end at the same place, and then differs by where sweeps end: degrees.
 */
#define SAME_ANGLE 1e-5

/** The more F may rise, the better; where it may not, it does not. */
static void the_rise_is_bounded(void **state) {
    const int dim = *(int *)*state;
    test_mesh box;
    uneven_box(&box, dim, 5);
    double last = 0;
    for (int i = 0; i < 4; i++) {
        planish_options options = defaults(PLANISH_WORST_ANGLE);
        options.worst_rise = i == 0 ? 0 : pow(10, i - 4.0);
        run r = smooth(&box.mesh, &options);
        assert_true(r.result.objective <=
                    r.result.objective_of_worst * (1 + options.worst_rise + 1e-14));
        assert_true(r.after.min_angle_deg_movable >= last - SAME_ANGLE);
        last = r.after.min_angle_deg_movable;
        release(&r);
    }
    destroy(&box);
}

static void expect_same_bits(const planish_mesh *mesh, const run *a, const run *b) {
    assert_memory_equal(a->coordinates, b->coordinates, bytes_of(mesh));
    assert_int_equal(a->result.worst_sweeps, b->result.worst_sweeps);
}

static void bits_do_not_depend_on_threads_or_kernel(void **state) {
    static const planish_isa isas[] = {PLANISH_ISA_PLAIN, PLANISH_ISA_VECTOR, PLANISH_ISA_AVX2,
                                       PLANISH_ISA_AVX512};
    const int dim = *(int *)*state;
    test_mesh box;
    uneven_box(&box, dim, 7);
    for (int worst = PLANISH_WORST_RADIUS_RATIO; worst <= PLANISH_WORST_ANGLE; worst++) {
        planish_options options = defaults((planish_worst)worst);
        run r = smooth(&box.mesh, &options);
        assert_true(r.result.worst_sweeps > 0);
        for (int i = 0; i < 7; i++) {
            planish_plan *plan;
            options.threads = i < 4 ? 1 : i - 2;
            options.isa = i < 4 ? isas[i] : PLANISH_ISA_AUTO;
            if (planish_plan_create(&box.mesh, &options, &plan, NULL) != 0)
                continue; /* the CPU lacks it */
            planish_plan_destroy(plan);
            run other = smooth(&box.mesh, &options);
            expect_same_bits(&box.mesh, &r, &other);
            release(&other);
        }
        release(&r);
    }
    destroy(&box);
}

static void powers_of_two_change_no_bit(void **state) {
    const int dim = *(int *)*state;
    test_mesh box;
    uneven_box(&box, dim, 8);
    const planish_options options = defaults(PLANISH_WORST_ANGLE);
    run r = smooth(&box.mesh, &options);
    test_mesh_transform(&box, 0x1p-40, 0);
    run small = smooth(&box.mesh, &options);
    for (int64_t i = 0; i < box.mesh.n_nodes * dim; i++)
        small.coordinates[i] *= 0x1p40;
    expect_same_bits(&box.mesh, &r, &small);
    release(&r);
    release(&small);
    destroy(&box);
}

/** Other options hold in this phase, too: bounds, minimum volumes, other objectives' RR and angles,
 *  floats, nodes that slide, a selective plan. */
static void other_options_hold(void **state) {
    enum { BOX, VOLUME, MEAN_RATIO, FLOATS, SLIDING, SELECTIVE, CASES };
    const int dim = *(int *)*state;
    for (int which = 0; which < CASES; which++) {
        test_mesh box;
        uneven_box(&box, dim, 9);
        planish_mesh mesh = box.mesh;
        planish_options options = defaults(PLANISH_WORST_RADIUS_RATIO);
        uint8_t *constraint = malloc((size_t)mesh.n_nodes);
        double *direction = malloc(bytes_of(&mesh));
        double least = 0;
        if (which == BOX) {
            options.box_lower[0] = 1.5;
            options.box_upper[0] = CELLS - 1.5;
        }
        if (which == VOLUME)
            least = options.min_volume = dim == 3 ? 0.1 : 0.35;
        if (which == MEAN_RATIO)
            options.objective = PLANISH_OBJECTIVE_MEAN_RATIO;
        if (which == FLOATS) {
            options.precision = PLANISH_PRECISION_FLOAT;
            for (int64_t i = 0; i < mesh.n_nodes * dim; i++)
                box.coordinates[i] = (float)box.coordinates[i];
        }
        if (which == SLIDING) {
            assert_int_equal(planish_find_slides(&mesh, NULL, 1, constraint, direction, NULL, NULL),
                             0);
            mesh.constraint = constraint;
            mesh.direction = direction;
        }
        if (which == SELECTIVE)
            options.only_worse_than = dim == 3 ? 1.6 : 1.2;
        run r = smooth(&mesh, &options);
        assert_true(r.result.worst_sweeps > 0);
        assert_int_equal(r.after.n_inverted, 0);
        assert_true(r.after.max_radius_ratio <= r.before.max_radius_ratio);
        if (which != MEAN_RATIO)
            assert_true(r.after.min_angle_deg >= r.before.min_angle_deg - ANGLE_ROUNDING);
        if (which != BOX) /* there other elements can move */
            assert_true(r.after.max_radius_ratio_movable <= r.result.worst_before);
        assert_true(fabs(r.after.total_volume / r.before.total_volume - 1) < 1e-12);
        assert_true(r.after.min_volume >= (1 - PLANISH_VOLUME_TOLERANCE) * least);
        for (int64_t i = 0; i < mesh.n_nodes * dim; i++) {
            const double x = r.coordinates[i], start = mesh.coordinates[i];
            if (which == BOX && i % dim == 0 && x != start)
                assert_true(x >= 1.5 && x <= CELLS - 1.5);
            if (which == FLOATS)
                assert_true(x == (float)x);
        }
        release(&r);
        free(constraint);
        free(direction);
        destroy(&box);
    }
}

typedef struct stop {
    int calls, at;
    double last; /* F of the last sweep that was told */
} stop;

static int stop_there(const planish_progress *progress, void *user) {
    stop *s = user;
    if (progress->sweep_done)
        s->last = progress->objective;
    return ++s->calls == s->at;
}

/** Whenever it is stopped, all holds that is promised. */
static void any_call_can_stop(void **state) {
    const int dim = *(int *)*state;
    test_mesh box;
    uneven_box(&box, dim, 10);
    planish_options options = defaults(PLANISH_WORST_ANGLE);
    stop all = {0};
    options.progress = stop_there;
    options.progress_user = &all;
    run r = smooth(&box.mesh, &options);
    const int calls = all.calls;
    const double converged = r.result.objective_of_worst;
    assert_true(fabs(all.last / r.result.objective - 1) < options.worst_rise);
    release(&r);
    for (int at = 1; at <= calls; at += effort_step(3) * (1 + calls / 97)) {
        stop s = {.at = at};
        options.progress_user = &s;
        r = smooth(&box.mesh, &options);
        expect_no_worse(&r.before, &r.after);
        assert_true(r.result.objective <=
                    fmax(r.result.objective_before, converged * (1 + options.worst_rise + 1e-14)));
        assert_true(at == calls || r.result.stop == PLANISH_STOP_INTERRUPTED);
        release(&r);
    }
    destroy(&box);
}

/** An element that nothing can repair, as bad as can be said, does not keep the phase from its end,
 * and without any sweep nothing is told. */
static void what_cannot_be_mended_is_no_end(void **state) {
    (void)state;
    for (int worst = PLANISH_WORST_RADIUS_RATIO; worst <= PLANISH_WORST_ANGLE; worst++)
        for (int exponent = -30; exponent >= -170; exponent -= 35) {
            static const int32_t triangle[3] = {0, 1, 2};
            const double corners[6] = {20, 0, 21, 0, 20.5, pow(10, exponent)};
            test_mesh box, flat;
            const planish_options options = defaults((planish_worst)worst);
            test_mesh_create(&flat, 2, 3, corners, 1, triangle);
            test_mesh_box(&box, 2, CELLS);
            test_mesh_perturb(&box, 0.14, 3);
            test_mesh_append(&box, &flat, 0);
            run r = smooth(&box.mesh, &options);
            assert_int_equal(r.result.stop, PLANISH_STOP_CONVERGED);
            assert_true(r.result.worst_sweeps < 1000);
            assert_true(r.after.max_radius_ratio_movable <= r.before.max_radius_ratio_movable);
            release(&r);
            test_mesh_destroy(&flat);
            test_mesh_destroy(&box);
        }
    static const int32_t fan[18] = {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5, 0, 5, 6, 0, 6, 1};
    double hexagon[14] = {0, 0};
    for (int i = 0; i < 6; i++) {
        hexagon[2 * i + 2] = i % 3 == 0 ? 1 - i / 1.5 : (i == 1 || i == 5 ? 0.5 : -0.5);
        hexagon[2 * i + 3] = i % 3 == 0 ? 0 : (i < 3 ? 1 : -1) * sqrt(0.75);
    }
    test_mesh even;
    const planish_options options = defaults(PLANISH_WORST_ANGLE);
    test_mesh_create(&even, 2, 7, hexagon, 6, fan);
    run r = smooth(&even.mesh, &options);
    assert_true(r.result.worst_sweeps == 0 && r.result.objective_of_worst == 0);
    assert_true(r.result.worst_before == 0 && r.result.worst_after == 0);
    release(&r);
    test_mesh_destroy(&even);
}

static void without_memory_nothing_is_spoilt(void **state) {
    const int dim = *(int *)*state;
    test_mesh box;
    planish_plan *plan;
    const planish_options options = defaults(PLANISH_WORST_ANGLE);
    uneven_box(&box, dim, 11);
    double *x = malloc(bytes_of(&box.mesh));
    memcpy(x, box.coordinates, bytes_of(&box.mesh));
    assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
    int failures = 0;
    for (;; failures++) {
        allocations_permit(failures);
        const int status = planish_smooth(plan, x, &options, NULL, NULL);
        allocations_permit(-1);
        if (status == 0)
            break;
        assert_int_equal(status, PLANISH_ERROR_MEMORY);
        assert_memory_equal(x, box.coordinates, bytes_of(&box.mesh));
    }
    assert_true(failures > 0);
    planish_plan_destroy(plan);
    free(x);
    destroy(&box);
}

static void options_are_checked(void **state) {
    (void)state;
    test_mesh box;
    planish_plan *plan;
    planish_error error;
    uneven_box(&box, 2, 1);
    for (int i = 0; i < 6; i++) {
        planish_options options =
            defaults(i == 0   ? (planish_worst)-1
                     : i == 1 ? (planish_worst)(PLANISH_WORST_SCALED_JACOBIAN + 1)
                              : PLANISH_WORST_ANGLE);
        const double rises[] = {-1e-9, INFINITY, NAN};
        if (i == 5)
            options.method = PLANISH_METHOD_LAPLACIAN;
        else if (i >= 2)
            options.worst_rise = rises[i - 2];
        assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, &error),
                         PLANISH_ERROR_ARGUMENT);
        assert_non_null(
            strstr(error.text, i < 2 || i == 5 ? "options.worst " : "options.worst_rise"));
    }
    destroy(&box);
}

/* ---- the smallest angle, always ------------------------------------------------------------ */

static void no_angle_becomes_smaller_than_the_smallest(void **state) {
    enum { MESHES = 1000 };
    const int dim = *(int *)*state;
    int put_back = 0, valid = 0;
    const planish_options options = defaults(PLANISH_WORST_NONE);
    for (unsigned seed = 1; seed <= MESHES; seed++) {
        test_mesh box;
        uneven_box_of(&box, dim, 0.14 + 0.2 * seed / MESHES, 0.5, seed);
        run r = smooth(&box.mesh, &options);
        if (r.before.n_inverted == 0) {
            valid++;
            put_back += r.result.n_put_back > 0;
            expect_no_worse(&r.before, &r.after);
            assert_true(r.after.rms_radius_ratio <= r.before.rms_radius_ratio);
        }
        release(&r);
        destroy(&box);
    }
    assert_true(put_back >= 3 && valid > MESHES / 2);
}

/** Without untangling no node of an inverted element moves, however obtuse or negative its angles are. */
static void inverted_elements_stay(void **state) {
    (void)state;
    enum { SEEDS = 12, APART = 37 };
    int64_t n_inverted = 0;
    for (unsigned seed = 1; seed <= SEEDS; seed++) {
        const int dim = 2 + (int)(seed % 3 == 0);
        test_mesh mesh;
        uneven_box(&mesh, dim, seed);
        for (int64_t i = seed; i < mesh.mesh.n_elements;
             i += APART) { /* some nodes over their neighbours */
            const int32_t *node = mesh.elements + i * (dim + 1);
            double *x = mesh.coordinates + node[0] * dim;
            for (int d = 0; d < dim; d++)
                x[d] += 2 * (mesh.coordinates[node[1] * dim + d] - x[d]);
        }
        for (int w = 0; w < 2; w++) {
            planish_options options =
                defaults(w ? PLANISH_WORST_ANGLE : PLANISH_WORST_RADIUS_RATIO);
            options.untangle = 0;
            run r = smooth(&mesh.mesh, &options);
            for (int64_t i = 0; i < mesh.mesh.n_elements; i++) {
                const int32_t *node = mesh.elements + i * (dim + 1);
                if (test_measure_of(&mesh.mesh, mesh.coordinates, i) > 0)
                    continue;
                n_inverted++;
                for (int j = 0; j <= dim; j++)
                    assert_memory_equal(r.coordinates + node[j] * dim,
                                        mesh.coordinates + node[j] * dim,
                                        (size_t)dim * sizeof(double));
            }
            release(&r);
        }
        destroy(&mesh);
    }
    assert_true(n_inverted > 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        BOTH(the_worst_becomes_better),
        BOTH(the_rise_is_bounded),
        BOTH(bits_do_not_depend_on_threads_or_kernel),
        BOTH(powers_of_two_change_no_bit),
        BOTH(other_options_hold),
        BOTH(any_call_can_stop),
        BOTH(without_memory_nothing_is_spoilt),
        cmocka_unit_test(the_limit_is_reached),
        cmocka_unit_test(a_node_of_very_many_elements_is_left),
        cmocka_unit_test(options_are_checked),
        cmocka_unit_test(what_cannot_be_mended_is_no_end),
        cmocka_unit_test(inverted_elements_stay),
        BOTH(no_angle_becomes_smaller_than_the_smallest),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
