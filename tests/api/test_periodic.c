/* Periodic nodes: they move by the same, to where the elements around all of them are best. */
#include "support/allocations.h"
#include "support/both.h"
#include "support/meshes.h"
#include "support/run.h"

#include "geometry/simplex.h"
#include "quality/certificate.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { CELLS = 5 };

/** A box whose opposite sides are periodic in the first n_directions directions, its nodes shaken:
 *  those of a side and of the opposite one alike. All arrays are owned. */
typedef struct periodic_box {
    test_mesh box;
    planish_mesh mesh;
    uint8_t *constraint;
    double *direction;
    int32_t *pair;
} periodic_box;

static int64_t node_at(int dim, const int64_t *at) {
    int64_t node = 0; /* lexicographic: the last coordinate varies fastest, or the first */
    for (int d = 0; d < dim; d++)
        node = node * (CELLS + 1) + at[dim - 1 - d];
    return node;
}

/** Lattice place of a node: from its coordinates, which are whole numbers. */
static void place_of(const double *x, int dim, int64_t *at) {
    for (int d = 0; d < dim; d++)
        at[d] = (int64_t)x[d];
}

/** The same push for all nodes that periodicity in all directions makes one. */
static double push(const int64_t *at, int dim, int d, double amount) {
    unsigned seed = 77;
    for (int k = 0; k < dim; k++)
        seed = seed * 31 + (unsigned)(at[k] % CELLS);
    seed = seed * 31 + (unsigned)d;
    test_random(&seed);
    return amount * (2 * test_random(&seed) - 1);
}

static void create(periodic_box *p, int dim, int n_directions, double amount) {
    test_mesh_box(&p->box, dim, CELLS);
    const int64_t n = p->box.mesh.n_nodes;
    p->pair = malloc((size_t)(n * dim) * 2 * sizeof *p->pair);
    p->constraint = malloc((size_t)n);
    p->direction = malloc((size_t)(n * dim) * sizeof *p->direction);
    int64_t n_pairs = 0;
    double *x = malloc((size_t)(n * dim) * sizeof *x);
    memcpy(x, p->box.coordinates, (size_t)(n * dim) * sizeof *x);
    for (int64_t i = 0; i < n; i++) {
        int64_t at[3];
        place_of(x + i * dim, dim, at);
        assert_int_equal(node_at(dim, at), i);
        for (int d = 0; d < dim; d++) {
            if (at[d] != 0 && at[d] != CELLS)
                p->box.coordinates[i * dim + d] += push(at, dim, d, amount);
            if (d < n_directions && at[d] == CELLS) {
                int64_t opposite[3] = {at[0], at[1], dim == 3 ? at[2] : 0};
                opposite[d] = 0;
                p->pair[2 * n_pairs] = (int32_t)i;
                p->pair[2 * n_pairs++ + 1] = (int32_t)node_at(dim, opposite);
            }
        }
    }
    free(x);
    assert_int_equal(
        planish_find_slides(&p->box.mesh, NULL, 1, p->constraint, p->direction, NULL, NULL), 0);
    p->mesh = p->box.mesh;
    p->mesh.constraint = p->constraint;
    p->mesh.direction = p->direction;
    p->mesh.n_periodic = n_pairs;
    p->mesh.periodic = p->pair;
}

static void destroy(periodic_box *p) {
    free(p->constraint);
    free(p->direction);
    free(p->pair);
    test_mesh_destroy(&p->box);
}

typedef struct run {
    double *coordinates; /* owned */
    planish_plan_info info;
    planish_result result;
    planish_quality before, after;
} run;

static run smooth(const planish_mesh *mesh, const planish_options *options) {
    run r;
    planish_plan *plan;
    planish_error error = {.text = ""};
    const size_t bytes = (size_t)(mesh->n_nodes * mesh->dim) * sizeof(double);
    r.coordinates = malloc(bytes);
    memcpy(r.coordinates, mesh->coordinates, bytes);
    assert_int_equal(planish_plan_create(mesh, options, &plan, &error), 0);
    planish_plan_get_info(plan, &r.info);
    assert_int_equal(planish_measure(plan, r.coordinates, &r.before, NULL), 0);
    assert_int_equal(planish_smooth(plan, r.coordinates, options, &r.result, NULL), 0);
    assert_int_equal(planish_measure(plan, r.coordinates, &r.after, NULL), 0);
    planish_plan_destroy(plan);
    return r;
}

/** Largest difference between the ways that the nodes of a pair have gone; *moved: the pairs that
 *  have gone any. */
static double mismatch(const planish_mesh *mesh, const double *x, int64_t *moved) {
    const int dim = mesh->dim;
    double largest = 0;
    *moved = 0;
    for (int64_t i = 0; i < mesh->n_periodic; i++) {
        int any = 0;
        for (int d = 0; d < dim; d++) {
            const int64_t a = (int64_t)mesh->periodic[2 * i] * dim + d;
            const int64_t b = (int64_t)mesh->periodic[2 * i + 1] * dim + d;
            const double of_a = x[a] - mesh->coordinates[a], of_b = x[b] - mesh->coordinates[b];
            largest = fmax(largest, fabs(of_a - of_b));
            any |= of_a != 0 || of_b != 0;
        }
        *moved += any;
    }
    return largest;
}

/** Nodes of the walls are on them. */
static void expect_walls(const planish_mesh *mesh, const double *x) {
    for (int64_t i = 0; i < mesh->n_nodes * mesh->dim; i++)
        if (mesh->coordinates[i] == 0 || mesh->coordinates[i] == CELLS)
            assert_true(x[i] == mesh->coordinates[i]);
}

static void expect_together(const planish_mesh *mesh, const run *r) {
    int64_t moved;
    assert_int_equal(r->after.n_inverted, 0);
    assert_true(mismatch(mesh, r->coordinates, &moved) < 1e-14 * CELLS);
    assert_true(moved > mesh->n_periodic / 3);
    expect_walls(mesh, r->coordinates);
    assert_true(r->after.max_radius_ratio <= r->before.max_radius_ratio);
    assert_true(fabs(r->after.total_volume / r->before.total_volume - 1) < 1e-13);
}

static void pairs_move_together(void **state) {
    const int dim = *(int *)*state;
    for (int n = 1; n <= dim; n++) {
        periodic_box p;
        const planish_options options = test_options(1);
        int64_t moved;
        create(&p, dim, n, 0.13);
        run r = smooth(&p.mesh, &options);
        expect_together(&p.mesh, &r);
        assert_int_equal(r.result.stop, PLANISH_STOP_CONVERGED);
        assert_true(r.after.rms_radius_ratio < r.before.rms_radius_ratio);
        planish_mesh alone = p.mesh;
        alone.n_periodic = 0;
        run without = smooth(&alone, &options);
        if (n < dim || dim == 3) /* the last corners' edges are alike anyway */
            assert_true(mismatch(&p.mesh, without.coordinates, &moved) > 1e-3);
        assert_int_equal(r.info.n_sliding, without.info.n_sliding);
        free(r.coordinates);
        free(without.coordinates);
        destroy(&p);
    }
}

/** Sum of AR^2 by mean ratio over the elements around a node. */
static double sum_around(const planish_mesh *mesh, const double *x, int32_t node) {
    const int dim = mesh->dim;
    double sum = 0;
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        const int32_t *corner = mesh->elements + i * (dim + 1);
        const double *vertex[4] = {NULL};
        int has = 0;
        for (int j = 0; j <= dim; j++) {
            has |= corner[j] == node;
            vertex[j] = x + (int64_t)corner[j] * dim;
        }
        const double ratio = has ? 1 / pl_mean_ratio(dim, vertex) : 0;
        sum += ratio * ratio;
    }
    return sum;
}

/** Where a pair ends no common way is downhill for the elements around both; for those around one
 *  alone it is. */
static void pairs_end_at_their_common_optimum(void **state) {
    const int dim = *(int *)*state;
    periodic_box p;
    planish_options options = test_options(1);
    options.tolerance = 1e-10;
    options.objective =
        PLANISH_OBJECTIVE_MEAN_RATIO; /* by RR the smallest angle would be a limit */
    create(&p, dim, 1, 0.13);
    unsigned seed = 5;
    for (int64_t i = 0; i < p.mesh.n_nodes; i++) /* or all would be even in the end */
        if (p.constraint[i] == PLANISH_CONSTRAINT_FREE && test_random(&seed) < 0.4)
            p.constraint[i] = PLANISH_CONSTRAINT_FIXED;
    run r = smooth(&p.mesh, &options);
    int checked = 0;
    double alone = 0;
    for (int64_t i = 0; i < p.mesh.n_periodic; i++) {
        const int32_t a = p.pair[2 * i], b = p.pair[2 * i + 1];
        if (p.constraint[a] !=
            (dim == 3 ? PLANISH_CONSTRAINT_ON_PLANE : PLANISH_CONSTRAINT_ON_LINE))
            continue; /* corners and edges */
        for (int d = 1; d < dim; d++) {
            const double h = 1e-5;
            double f[3], of_a[3];
            for (int k = -1; k <= 1; k++) {
                r.coordinates[a * dim + d] += k * h;
                r.coordinates[b * dim + d] += k * h;
                of_a[k + 1] = sum_around(&p.mesh, r.coordinates, a);
                f[k + 1] = of_a[k + 1] + sum_around(&p.mesh, r.coordinates, b);
                r.coordinates[a * dim + d] -= k * h;
                r.coordinates[b * dim + d] -= k * h;
            }
            const double slope = (f[2] - f[0]) / (2 * h), bend = (f[2] - 2 * f[1] + f[0]) / (h * h);
            assert_true(bend > 0 && fabs(slope / bend) < 2e-3);
            alone = fmax(alone, fabs((of_a[2] - of_a[0]) / (2 * h) / bend));
            checked++;
        }
    }
    assert_true(checked > 3 && alone > 0.02);
    free(r.coordinates);
    destroy(&p);
}

static void bits_do_not_depend_on_threads_or_scale(void **state) {
    const int dim = *(int *)*state;
    periodic_box p;
    planish_options options = test_options(1);
    create(&p, dim, dim, 0.13);
    const size_t bytes = (size_t)(p.mesh.n_nodes * dim) * sizeof(double);
    run r = smooth(&p.mesh, &options);
    for (int i = 0; i < 5; i++) {
        options.threads = i < 3 ? i + 1 : 1;
        options.isa = i == 3 ? PLANISH_ISA_PLAIN : PLANISH_ISA_AUTO;
        if (i == 4)
            test_mesh_transform(&p.box, 0x1p-30, 0);
        run other = smooth(&p.mesh, &options);
        for (int64_t k = 0; i == 4 && k < p.mesh.n_nodes * dim; k++)
            other.coordinates[k] *= 0x1p30;
        assert_memory_equal(r.coordinates, other.coordinates, bytes);
        free(other.coordinates);
    }
    free(r.coordinates);
    destroy(&p);
}

/** Nodes of no element, wherever they are, change nothing. */
static void strangers_change_nothing(void **state) {
    const int dim = *(int *)*state;
    periodic_box p;
    planish_options options = test_options(1);
    create(&p, dim, dim, 0.13);
    run alone = smooth(&p.mesh, &options);
    const int64_t n = p.mesh.n_nodes;
    double *x = calloc((size_t)((n + 1) * dim), sizeof *x);
    uint8_t *constraint = calloc((size_t)(n + 1), 1);
    double *direction = calloc((size_t)((n + 1) * dim), sizeof *direction);
    memcpy(x, p.mesh.coordinates, (size_t)(n * dim) * sizeof *x);
    memcpy(constraint, p.constraint, (size_t)n);
    memcpy(direction, p.direction, (size_t)(n * dim) * sizeof *direction);
    x[n * dim] = 1e11;
    planish_mesh strange = p.mesh;
    strange.n_nodes = n + 1;
    strange.coordinates = x;
    strange.constraint = constraint;
    strange.direction = direction;
    run other = smooth(&strange, &options);
    assert_int_equal(other.result.n_moved_nodes, alone.result.n_moved_nodes);
    for (int64_t i = 0; i < n * dim; i++)
        assert_true(fabs(other.coordinates[i] - alone.coordinates[i]) < 1e-3);
    assert_true(fabs(other.after.rms_radius_ratio / alone.after.rms_radius_ratio - 1) < 1e-6);
    free(x);
    free(constraint);
    free(direction);
    free(alone.coordinates);
    free(other.coordinates);
    destroy(&p);
}

/** A group is chosen as a whole, in whatever order its pairs are given: around one bad element in
 *  the corner of a strip whose nodes are joined in a long chain. */
static void long_groups_are_chosen_whole(void **state) {
    enum { LONG = 40 };
    (void)state;
    double x[2 * (LONG + 1) * 3];
    int32_t elements[LONG * 4 * 3], pair[2 * LONG];
    uint8_t constraint[(LONG + 1) * 3];
    double direction[2 * (LONG + 1) * 3] = {0};
    int64_t m = 0;
    for (int i = 0; i <= LONG; i++)
        for (int j = 0; j < 3; j++) {
            x[2 * (3 * i + j)] = i;
            x[2 * (3 * i + j) + 1] = j;
            constraint[3 * i + j] = j == 0 ? PLANISH_CONSTRAINT_ON_LINE : PLANISH_CONSTRAINT_FIXED;
            direction[2 * (3 * i + j)] = 1;
        }
    for (int i = 0; i < LONG; i++)
        for (int j = 0; j < 2; j++) {
            const int32_t a = 3 * i + j, b = a + 3;
            const int32_t both[] = {a, b, b + 1, a, b + 1, a + 1};
            memcpy(elements + 3 * m, both, sizeof both);
            m += 2;
        }
    planish_mesh mesh = {.dim = 2,
                         .n_nodes = 3 * (LONG + 1),
                         .n_elements = m,
                         .coordinates = x,
                         .elements = elements,
                         .constraint = constraint,
                         .direction = direction,
                         .n_periodic = 20,
                         .periodic = pair};
    x[0] = -3; /* the only bad elements are at the first of the chain */
    int64_t n_sliding[2];
    for (int order = 0; order < 2; order++) {
        planish_options options = test_options(1);
        planish_plan *plan;
        planish_plan_info info;
        for (int k = 0; k < 20; k++) {
            const int at = order ? 19 - k : k;
            pair[2 * k] = 3 * (2 * at);
            pair[2 * k + 1] = 3 * (2 * at + 2);
        }
        options.only_worse_than = 1.5;
        assert_int_equal(planish_plan_create(&mesh, &options, &plan, NULL), 0);
        planish_plan_get_info(plan, &info);
        n_sliding[order] = info.n_sliding;
        planish_plan_destroy(plan);
    }
    assert_int_equal(n_sliding[0], n_sliding[1]);
}

static void other_options_hold(void **state) {
    enum { WORST, SELECTIVE, VOLUME, BOX, DISTANCE, MEAN_RATIO, FLOATS, CASES };
    const int dim = *(int *)*state;
    for (int which = 0; which < CASES; which++) {
        periodic_box p;
        planish_options options = test_options(1);
        int64_t moved;
        create(&p, dim, dim, 0.13);
        if (which == WORST)
            options.worst = PLANISH_WORST_ANGLE;
        if (which == SELECTIVE)
            options.only_worse_than = dim == 3 ? 1.7 : 1.3;
        if (which == VOLUME)
            options.min_volume = dim == 3 ? 0.1 : 0.3;
        if (which == BOX) /* half of the pairs have a node outside, and stay */
            options.box_upper[0] = CELLS - 0.5;
        if (which == DISTANCE)
            options.max_displacement = 0.05;
        if (which == MEAN_RATIO)
            options.objective = PLANISH_OBJECTIVE_MEAN_RATIO;
        if (which == FLOATS) {
            options.precision = PLANISH_PRECISION_FLOAT;
            for (int64_t i = 0; i < p.mesh.n_nodes * dim; i++)
                p.box.coordinates[i] = (float)p.box.coordinates[i];
        }
        run r = smooth(&p.mesh, &options);
        assert_int_equal(r.after.n_inverted, 0);
        assert_true(mismatch(&p.mesh, r.coordinates, &moved) < (which == FLOATS ? 1e-6 : 1e-13));
        assert_true(moved > 0);
        expect_walls(&p.mesh, r.coordinates);
        assert_true(r.after.max_radius_ratio <= r.before.max_radius_ratio);
        for (int64_t i = 0; i < p.mesh.n_nodes; i++) {
            const double *x = r.coordinates + i * dim, *start = p.mesh.coordinates + i * dim;
            if (which == BOX && start[0] > CELLS - 0.5)
                assert_memory_equal(x, start, (size_t)dim * sizeof *x);
            if (which == DISTANCE)
                assert_true(pl_distance(dim, x, start) <= 0.05 * (1 + 1e-12));
        }
        free(r.coordinates);
        destroy(&p);
    }
}

/** To whole multiples of user. */
static double to_multiple(double value, void *user) {
    const double unit = *(const double *)user;
    return rint(value / unit) * unit;
}

/** Turn the mesh, and the directions that its nodes slide in, by angle in the first two. */
static void turn(const periodic_box *p, double angle) {
    const double c = cos(angle), s = sin(angle);
    for (int64_t i = 0; i < p->mesh.n_nodes; i++) {
        double *turned[] = {p->box.coordinates + i * p->mesh.dim, p->direction + i * p->mesh.dim};
        for (int k = 0; k < 2; k++) {
            const double x = turned[k][0], y = turned[k][1];
            turned[k][0] = c * x - s * y;
            turned[k][1] = s * x + c * y;
        }
    }
}

/** Where coordinates are rounded, the elements around a node that follows another one are not what
 *  those around that one are: they have to be looked at. */
static void rounding_harms_no_follower(void **state) {
    const int dim = *(int *)*state;
    static const planish_objective objectives[] = {PLANISH_OBJECTIVE_RADIUS_RATIO,
                                                   PLANISH_OBJECTIVE_MEAN_RATIO};
    int64_t moved = 0;
    for (int i = 0; i < 20; i++) {
        periodic_box p;
        planish_options options = test_options(1);
        double unit = i % 4 < 2 ? 0.3 : 0.05;
        create(&p, dim, dim, 0.13);
        turn(&p, 0.05 + 0.07 * i);
        options.objective = objectives[i % 2];
        options.precision = PLANISH_PRECISION_ROUNDED;
        options.round = to_multiple;
        options.round_user = &unit;
        run r = smooth(&p.mesh, &options);
        assert_int_equal(r.before.n_inverted, 0);
        assert_int_equal(r.after.n_inverted, 0);
        assert_true(r.after.max_radius_ratio <= r.before.max_radius_ratio);
        assert_true(r.result.objective <= r.result.objective_before);
        moved += r.result.n_moved_nodes;
        free(r.coordinates);
        destroy(&p);
    }
    assert_true(moved > 0);
}

/** Every node has bounds of its own, near where it is, and sums of ways are rounded: no follower
 * goes beyond its bounds by a bit, where those of the node that it follows let that go. */
static void followers_stay_within_their_bounds(void **state) {
    const int dim = *(int *)*state;
    int64_t at_bound = 0;
    for (int i = 0; i < 40; i++) {
        periodic_box p;
        planish_options options = test_options(1);
        unsigned seed = (unsigned)i + 1;
        create(&p, dim, dim, 0.13);
        turn(&p, 0.05 + 0.07 * i);
        const int64_t n = p.mesh.n_nodes * dim;
        double *lower = malloc((size_t)n * sizeof *lower),
               *upper = malloc((size_t)n * sizeof *upper);
        for (int64_t k = 0; k < n; k++) {
            lower[k] = p.mesh.coordinates[k] - 0.05 * test_random(&seed);
            upper[k] = p.mesh.coordinates[k] + 0.05 * test_random(&seed);
        }
        options.lower = lower;
        options.upper = upper;
        run r = smooth(&p.mesh, &options);
        for (int64_t k = 0; k < n; k++) {
            assert_true(lower[k] <= r.coordinates[k] && r.coordinates[k] <= upper[k]);
            at_bound += lower[k] == r.coordinates[k] || r.coordinates[k] == upper[k];
        }
        free(lower);
        free(upper);
        free(r.coordinates);
        destroy(&p);
    }
    assert_true(at_bound > 40);
}

static int is_positive(const planish_mesh *mesh, int64_t element) {
    const double *vertex[4];
    for (int j = 0; j <= mesh->dim; j++)
        vertex[j] =
            mesh->coordinates + (int64_t)mesh->elements[element * (mesh->dim + 1) + j] * mesh->dim;
    return pl_measure_sign(mesh->dim, vertex) > 0;
}

/** A node of some element, at inside, comes to lie where the node at side of the same one is. */
static void flatten(const periodic_box *p, int64_t element, int side, int inside) {
    const int dim = p->mesh.dim;
    const int32_t *node = p->mesh.elements + element * (dim + 1);
    for (int d = 0; d < dim; d++)
        p->box.coordinates[(int64_t)node[inside] * dim + d] =
            p->box.coordinates[(int64_t)node[side] * dim + d];
}

/** Where an edge at a follower has no length its elements are flat, though their copies next to the
 * leader may not be, by a bit: they are left alone if that is asked for. */
static void flat_elements_are_left_alone(void **state) {
    const int dim = *(int *)*state;
    int64_t kept = 0, moved = 0;
    for (int i = 0; i < 60; i++) {
        periodic_box p;
        planish_options options = test_options(1);
        create(&p, dim, 1, 0.13);
        turn(&p, 0.05 + 0.07 * i);
        int64_t n = 0; /* every so many of the elements with an edge from a side to the inside */
        for (int64_t k = 0; k < p.mesh.n_elements; k++) {
            const int32_t *node = p.mesh.elements + k * (dim + 1);
            for (int j = 0; j < dim; j++)
                if ((p.constraint[node[j]] == PLANISH_CONSTRAINT_FREE) !=
                        (p.constraint[node[j + 1]] == PLANISH_CONSTRAINT_FREE) &&
                    n++ % 37 == i % 37)
                    flatten(&p, k, j + (p.constraint[node[j]] == PLANISH_CONSTRAINT_FREE),
                            j + (p.constraint[node[j]] != PLANISH_CONSTRAINT_FREE));
        }
        options.untangle = 0;
        run r = smooth(&p.mesh, &options);
        for (int64_t k = 0; k < p.mesh.n_elements; k++)
            for (int j = 0; j <= dim && !is_positive(&p.mesh, k); j++, kept++)
                for (int d = 0; d < dim; d++) {
                    const int64_t at = (int64_t)p.mesh.elements[k * (dim + 1) + j] * dim + d;
                    assert_true(r.coordinates[at] == p.mesh.coordinates[at]);
                }
        moved += r.result.n_moved_nodes;
        free(r.coordinates);
        destroy(&p);
    }
    assert_true(kept > 0 && moved > 0);
}

/** What cannot move together is held: nodes that slide otherwise, or not at all; rotations; a
 *  translation of one pair; and any nonsense does no harm. */
static void what_is_not_alike_is_held(void **state) {
    enum { HELD, TURNED, ROTATED, LONELY, SURFACE, NONSENSE, CASES };
    const int dim = *(int *)*state;
    for (int which = 0; which < CASES; which++) {
        periodic_box p;
        const planish_options options = test_options(1);
        create(&p, dim, 1, 0.13);
        for (int64_t i = 0; i < p.mesh.n_periodic; i++) {
            const int32_t a = p.pair[2 * i];
            if (which == HELD)
                p.constraint[a] = PLANISH_CONSTRAINT_FIXED;
            if (which == TURNED && p.constraint[a] == PLANISH_CONSTRAINT_ON_PLANE) {
                p.direction[a * dim] = 1; /* of another plane: wrong, but not to be moved by */
                p.direction[a * dim + 1] = 1;
            }
            if (which == NONSENSE)
                p.pair[2 * i + 1] = (int32_t)((a * 7919 + i * i) % p.mesh.n_nodes);
        }
        for (int64_t i = 0; which == SURFACE && i < p.mesh.n_nodes; i++)
            if (p.constraint[i] >= PLANISH_CONSTRAINT_ON_PLANE)
                p.constraint[i] = PLANISH_CONSTRAINT_ON_SURFACE;
        if (which == SURFACE)
            p.mesh.direction = NULL;
        if (which == ROTATED) /* the side is joined to itself upside down */
            for (int64_t i = 0; i < p.mesh.n_periodic / 2; i++) {
                const int64_t k = 2 * i + 1, other = 2 * (p.mesh.n_periodic - 1 - i) + 1;
                const int32_t swap = p.pair[k];
                p.pair[k] = p.pair[other];
                p.pair[other] = swap;
            }
        if (which == LONELY) {
            p.pair[0] = p.pair[2 * (p.mesh.n_periodic / 2)];
            p.pair[1] = p.pair[2 * (p.mesh.n_periodic / 2) + 1];
            p.mesh.n_periodic = 1;
        }
        run r = smooth(&p.mesh, &options);
        assert_int_equal(r.after.n_inverted, 0);
        assert_true(r.result.n_moved_nodes > 0);
        for (int64_t i = 0; i < p.mesh.n_periodic; i++)
            for (int j = 0; j < 2 && which != ROTATED && which != NONSENSE; j++) {
                const int64_t node = p.pair[2 * i + j];
                if (which != TURNED || p.constraint[node] == PLANISH_CONSTRAINT_ON_PLANE)
                    assert_memory_equal(r.coordinates + node * dim, p.mesh.coordinates + node * dim,
                                        (size_t)dim * sizeof(double));
            }
        free(r.coordinates);
        destroy(&p);
    }
}

/** Interior nodes of pairs stay, and so do pairs in one element. */
static void pairs_inside_are_held(void **state) {
    const int dim = *(int *)*state;
    periodic_box p;
    const planish_options options = test_options(1);
    create(&p, dim, 1, 0.13);
    int64_t n = 0;
    for (int64_t i = 0; i < p.mesh.n_nodes; i++)
        if (p.constraint[i] == PLANISH_CONSTRAINT_FREE && n < p.mesh.n_periodic)
            p.pair[n++] = (int32_t)i;
    p.mesh.n_periodic = n / 2;
    run r = smooth(&p.mesh, &options);
    assert_true(n > 3 && r.result.n_moved_nodes > 0);
    for (int64_t i = 0; i < 2 * p.mesh.n_periodic; i++)
        assert_memory_equal(r.coordinates + (int64_t)p.pair[i] * dim,
                            p.mesh.coordinates + (int64_t)p.pair[i] * dim,
                            (size_t)dim * sizeof(double));
    free(r.coordinates);
    destroy(&p);
}

/** Where elements reach from a side to its opposite one nodes cannot move together. */
static void thin_meshes_are_held(void **state) {
    (void)state;
    const double strip[] = {0, 0, 1, 0, 0, 1.2, 1, 1.2, 0, 1.9, 1, 1.9, 0, 3, 1, 3};
    const int32_t triangles[] = {0, 1, 3, 0, 3, 2, 2, 3, 5, 2, 5, 4, 4, 5, 7, 4, 7, 6};
    const int32_t pairs[] = {1, 0, 3, 2, 5, 4, 7, 6};
    uint8_t constraint[8];
    double direction[16];
    test_mesh box;
    const planish_options options = test_options(1);
    test_mesh_create(&box, 2, 8, strip, 6, triangles);
    planish_mesh mesh = box.mesh;
    assert_int_equal(planish_find_slides(&mesh, NULL, 1, constraint, direction, NULL, NULL), 0);
    mesh.constraint = constraint;
    mesh.direction = direction;
    run alone = smooth(&mesh, &options);
    assert_true(alone.result.n_moved_nodes > 0);
    mesh.n_periodic = 4;
    mesh.periodic = pairs;
    run r = smooth(&mesh, &options);
    assert_int_equal(r.result.n_moved_nodes, 0);
    free(alone.coordinates);
    free(r.coordinates);
    test_mesh_destroy(&box);
}

static void pairs_are_checked(void **state) {
    (void)state;
    periodic_box p;
    planish_plan *plan;
    planish_error error;
    create(&p, 2, 1, 0.1);
    p.pair[3] = (int32_t)p.mesh.n_nodes;
    assert_int_equal(planish_plan_create(&p.mesh, NULL, &plan, &error), PLANISH_ERROR_MESH);
    assert_non_null(strstr(error.text, "pair 1 of mesh.periodic"));
    p.pair[3] = -1;
    assert_int_equal(planish_plan_create(&p.mesh, NULL, &plan, &error), PLANISH_ERROR_MESH);
    p.mesh.periodic = NULL;
    assert_int_equal(planish_plan_create(&p.mesh, NULL, &plan, &error), PLANISH_ERROR_ARGUMENT);
    p.mesh.n_periodic = -1;
    assert_int_equal(planish_plan_create(&p.mesh, NULL, &plan, &error), PLANISH_ERROR_ARGUMENT);
    destroy(&p);
}

static void memory_may_run_out(void **state) {
    (void)state;
    periodic_box p;
    const planish_options options = test_options(1);
    create(&p, 3, 3, 0.1);
    int failures = 0, status = PLANISH_ERROR_MEMORY;
    for (; status == PLANISH_ERROR_MEMORY; failures++) {
        planish_plan *plan = NULL;
        allocations_permit(failures);
        status = planish_plan_create(&p.mesh, &options, &plan, NULL);
        allocations_permit(-1);
        planish_plan_destroy(plan);
    }
    assert_int_equal(status, 0);
    assert_true(failures > 30);
    destroy(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        BOTH(pairs_move_together),
        BOTH(pairs_end_at_their_common_optimum),
        BOTH(bits_do_not_depend_on_threads_or_scale),
        BOTH(strangers_change_nothing),
        cmocka_unit_test(long_groups_are_chosen_whole),
        BOTH(other_options_hold),
        BOTH(rounding_harms_no_follower),
        BOTH(followers_stay_within_their_bounds),
        BOTH(flat_elements_are_left_alone),
        BOTH(what_is_not_alike_is_held),
        BOTH(pairs_inside_are_held),
        cmocka_unit_test(thin_meshes_are_held),
        cmocka_unit_test(pairs_are_checked),
        cmocka_unit_test(memory_may_run_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
