/* Nodes that slide: on planes, lines and surfaces, by the public functions. */
#include "support/meshes.h"
#include "support/run.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { CELLS = 5 };

/** A box whose boundary nodes slide, and what it was before it was smoothed. */
typedef struct sliding_box {
    test_mesh base;
    planish_mesh mesh;
    uint8_t *constraint; /* [n] */
    double *direction;   /* [n][dim] */
    double *coordinates; /* [n][dim] smoothed */
    planish_quality before, after;
    planish_result result;
    planish_plan_info info;
} sliding_box;

/** How many sides of the box x is on; side is one of the directions they stand in. */
static int sides_of(const double *x, int dim, int *side, int *rest) {
    int sides = 0;
    for (int d = 0; d < dim; d++) {
        const int on = x[d] == 0 || x[d] == CELLS;
        sides += on;
        *(on ? side : rest) = d;
    }
    return sides;
}

/** Let the nodes slide on the sides and edges; lengths of directions are anything but 1. */
static void constrain(sliding_box *b) {
    const int dim = b->mesh.dim;
    for (int64_t i = 0; i < b->mesh.n_nodes; i++) {
        int side = 0, rest = 0;
        const int sides = sides_of(b->base.coordinates + i * dim, dim, &side, &rest);
        b->constraint[i] = sides == 0     ? PLANISH_CONSTRAINT_FREE
                           : sides == dim ? PLANISH_CONSTRAINT_FIXED
                           : sides == 1   ? PLANISH_CONSTRAINT_ON_PLANE
                                          : PLANISH_CONSTRAINT_ON_LINE;
        if (b->constraint[i] == PLANISH_CONSTRAINT_ON_PLANE)
            b->direction[i * dim + side] = -3;
        if (b->constraint[i] == PLANISH_CONSTRAINT_ON_LINE)
            b->direction[i * dim + rest] = 0.7;
    }
}

/** Move the nodes of the sides along them, as the others: the mesh stays valid. */
static void perturb_sides(sliding_box *b, double amount) {
    const int dim = b->mesh.dim;
    unsigned state = 77;
    for (int64_t i = 0; i < b->mesh.n_nodes; i++)
        for (int d = 0; d < dim; d++) {
            const double x = b->base.coordinates[i * dim + d];
            int side, rest;
            const int is_side = sides_of(b->base.coordinates + i * dim, dim, &side, &rest) > 0;
            const double move = amount * (2 * test_random(&state) - 1);
            if (is_side && x != 0 && x != CELLS)
                b->base.coordinates[i * dim + d] = x + move;
        }
}

static void box_create(sliding_box *b, int dim) {
    *b = (sliding_box){.constraint = NULL};
    test_mesh_box(&b->base, dim, CELLS);
    test_mesh_perturb(&b->base, 0.1, 5);
    b->mesh = b->base.mesh;
    const size_t n = (size_t)b->mesh.n_nodes;
    b->constraint = calloc(n, 1);
    b->direction = calloc(n * (size_t)dim, sizeof(double));
    constrain(b);
    perturb_sides(b, 0.1);
    b->mesh.constraint = b->constraint;
    b->mesh.direction = b->direction;
    b->coordinates = malloc(n * (size_t)dim * sizeof(double));
}

static void box_destroy(sliding_box *b) {
    test_mesh_destroy(&b->base);
    free(b->constraint);
    free(b->direction);
    free(b->coordinates);
}

static size_t bytes_of(const sliding_box *b) {
    return (size_t)b->mesh.n_nodes * (size_t)b->mesh.dim * sizeof(double);
}

static void smooth(sliding_box *b, const planish_options *options) {
    planish_plan *plan;
    planish_error error = {.text = ""};
    memcpy(b->coordinates, b->base.coordinates, bytes_of(b));
    assert_int_equal(planish_plan_create(&b->mesh, options, &plan, &error), 0);
    planish_plan_get_info(plan, &b->info);
    assert_int_equal(planish_measure(plan, b->coordinates, &b->before, &error), 0);
    assert_int_equal(planish_smooth(plan, b->coordinates, options, &b->result, &error), 0);
    assert_int_equal(planish_measure(plan, b->coordinates, &b->after, &error), 0);
    planish_plan_destroy(plan);
}

static void assert_never_worse(const sliding_box *b) {
    assert_int_equal(b->before.n_inverted, 0);
    assert_int_equal(b->after.n_inverted, 0);
    assert_true(b->after.max_radius_ratio <= b->before.max_radius_ratio);
    assert_true(b->after.rms_radius_ratio < b->before.rms_radius_ratio);
    assert_true(fabs(b->after.total_volume / b->before.total_volume - 1) < 1e-13);
}

/** The coordinates in whose direction a node of a side must not go have their bits; those along it
 *  do move, and the mesh is better than with its boundary held. */
static void sides_keep_their_place(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        sliding_box b;
        const planish_options options = test_options(1);
        box_create(&b, dim);
        smooth(&b, &options);
        assert_never_worse(&b);
        int64_t moved = 0, sliding = 0;
        for (int64_t i = 0; i < b.mesh.n_nodes; i++) {
            int same = 1;
            for (int d = 0; d < dim; d++) {
                const double x = b.base.coordinates[i * dim + d], y = b.coordinates[i * dim + d];
                if (x == 0 || x == CELLS)
                    assert_memory_equal(&x, &y, sizeof x);
                same &= x == y;
            }
            sliding += b.constraint[i] >= PLANISH_CONSTRAINT_ON_PLANE;
            moved += b.constraint[i] >= PLANISH_CONSTRAINT_ON_PLANE && !same;
        }
        assert_int_equal(b.info.n_sliding, sliding);
        assert_true(moved > sliding / 2);
        const double slid = b.after.rms_radius_ratio;
        b.mesh.constraint = NULL;
        smooth(&b, &options);
        assert_int_equal(b.info.n_sliding, 0);
        assert_true(slid < b.after.rms_radius_ratio);
        box_destroy(&b);
    }
}

/** Turn the box, so that no side stands along an axis. */
static void turn(sliding_box *b) {
    static const double q[3][3] = {
        {2.0 / 3, -2.0 / 3, 1.0 / 3}, {1.0 / 3, 2.0 / 3, 2.0 / 3}, {-2.0 / 3, -1.0 / 3, 2.0 / 3}};
    double *arrays[] = {b->base.coordinates, b->direction};
    for (int k = 0; k < 2; k++)
        for (int64_t i = 0; i < b->mesh.n_nodes; i++) {
            double y[3] = {0, 0, 0}, *x = arrays[k] + 3 * i;
            for (int r = 0; r < 3; r++)
                for (int c = 0; c < 3; c++)
                    y[r] += q[r][c] * x[c];
            memcpy(x, y, sizeof y);
        }
}

/** How far the node has left its plane or line. */
static double distance_left(const sliding_box *b, int64_t i) {
    const double *from = b->base.coordinates + 3 * i, *to = b->coordinates + 3 * i;
    const double *direction = b->direction + 3 * i;
    double length = 0, along = 0, square = 0;
    for (int d = 0; d < 3; d++)
        length += direction[d] * direction[d];
    for (int d = 0; d < 3; d++)
        along += (to[d] - from[d]) * direction[d] / sqrt(length);
    for (int d = 0; d < 3; d++) {
        const double off = to[d] - from[d] - along * direction[d] / sqrt(length);
        square += off * off;
    }
    return b->constraint[i] == PLANISH_CONSTRAINT_ON_PLANE ? fabs(along) : sqrt(square);
}

static void slanting_sides_are_left_by_rounding_only(void **state) {
    (void)state;
    sliding_box b;
    const planish_options options = test_options(1);
    box_create(&b, 3);
    turn(&b);
    smooth(&b, &options);
    assert_never_worse(&b);
    assert_true(b.result.n_moved_nodes > b.mesh.n_nodes / 2);
    for (int64_t i = 0; i < b.mesh.n_nodes; i++)
        if (b.constraint[i] == PLANISH_CONSTRAINT_ON_PLANE ||
            b.constraint[i] == PLANISH_CONSTRAINT_ON_LINE)
            assert_true(distance_left(&b, i) <= 4 * 0x1p-52 * CELLS);
    box_destroy(&b);
}

static void bits_do_not_depend_on_threads_or_kernels(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int least = 0; least < 2; least++) {
            sliding_box b;
            planish_options options = test_options(1);
            options.min_volume = least ? 0.08 : 0;
            box_create(&b, dim);
            smooth(&b, &options);
            double *first = malloc(bytes_of(&b));
            memcpy(first, b.coordinates, bytes_of(&b));
            for (int isa = PLANISH_ISA_PLAIN; isa <= PLANISH_ISA_AVX512; isa++)
                for (int threads = 1; threads <= 3; threads++) {
                    planish_plan *plan;
                    options.isa = (planish_isa)isa;
                    options.threads = threads;
                    if (planish_plan_create(&b.mesh, &options, &plan, NULL) != 0)
                        continue; /* not for this CPU */
                    planish_plan_destroy(plan);
                    smooth(&b, &options);
                    assert_memory_equal(b.coordinates, first, bytes_of(&b));
                }
            free(first);
            box_destroy(&b);
        }
}

/** Every combination of the other options keeps what is promised. */
static void other_options_go_with_it(void **state) {
    (void)state;
    for (int which = 0; which < 7; which++) {
        sliding_box b;
        planish_options options = test_options(1);
        box_create(&b, 3);
        if (which == 1)
            options.min_volume = 0.09;
        if (which == 2)
            options.objective = PLANISH_OBJECTIVE_MEAN_RATIO;
        if (which == 3)
            options.search = PLANISH_SEARCH_FLETCHER_REEVES;
        if (which == 4)
            options.max_displacement = 0.03;
        if (which == 5)
            options.box_upper[0] = 2.5;
        if (which == 6) {
            options.precision = PLANISH_PRECISION_FLOAT;
            for (int64_t i = 0; i < 3 * b.mesh.n_nodes; i++)
                b.base.coordinates[i] = (double)(float)b.base.coordinates[i];
        }
        smooth(&b, &options);
        assert_int_equal(b.after.n_inverted, 0);
        assert_true(b.result.objective <= b.result.objective_before * (1 + 1e-12) || which == 1);
        assert_true(b.result.n_moved_nodes > 0);
        for (int64_t i = 0; i < b.mesh.n_nodes; i++) {
            const double *from = b.base.coordinates + 3 * i, *to = b.coordinates + 3 * i;
            double square = 0;
            for (int d = 0; d < 3; d++) {
                if (from[d] == 0 || from[d] == CELLS)
                    assert_true(from[d] == to[d]);
                if (which == 6)
                    assert_true(to[d] == (double)(float)to[d]);
                square += (to[d] - from[d]) * (to[d] - from[d]);
            }
            if (which == 4)
                assert_true(sqrt(square) <= 0.03 * (1 + 1e-12));
            if (which == 5 && from[0] <= 2.5)
                assert_true(to[0] <= 2.5);
            if (which == 5 && from[0] > 2.5)
                assert_true(square == 0);
        }
        box_destroy(&b);
    }
}

/** A mesh without any interior node. */
static void sides_slide_alone(void **state) {
    (void)state;
    sliding_box b;
    const planish_options options = test_options(1);
    box_create(&b, 3);
    for (int64_t i = 0; i < b.mesh.n_nodes; i++)
        if (b.constraint[i] == PLANISH_CONSTRAINT_FREE)
            b.constraint[i] = PLANISH_CONSTRAINT_FIXED;
    smooth(&b, &options);
    assert_int_equal(b.info.n_free, 0);
    assert_never_worse(&b);
    box_destroy(&b);
}

/** A tangled interior is repaired while the sides are held, and these slide afterwards. */
static void tangled_meshes_are_mended(void **state) {
    (void)state;
    sliding_box b;
    const planish_options options = test_options(1);
    unsigned random = 9;
    box_create(&b, 3);
    for (int64_t i = 0; i < b.mesh.n_nodes; i++)
        for (int d = 0; b.constraint[i] == PLANISH_CONSTRAINT_FREE && d < 3; d++)
            b.base.coordinates[3 * i + d] += 1.6 * (test_random(&random) - 0.5);
    smooth(&b, &options);
    assert_true(b.before.n_inverted > 0);
    assert_int_equal(b.after.n_inverted, 0);
    assert_true(fabs(b.after.total_volume - CELLS * CELLS * CELLS) < 1e-10);
    box_destroy(&b);
}

/* ---- a surface of the caller's ------------------------------------------------------------- */

/** A roof over the box, z = height(x, y); its eaves are curves. */
typedef struct roof {
    const uint8_t *constraint; /* [n] of the flat box: nodes on lines stay on the eaves */
    const double *direction;   /* [n][3] likewise */
    int refuses;
} roof;

static double height(double x, double y) {
    return CELLS + 0.4 * sin(x) * cos(1.3 * y);
}

static planish_constraint on_roof(int64_t node, double *point, double *direction, void *user) {
    const roof *r = user;
    const double dx = 0.4 * cos(point[0]) * cos(1.3 * point[1]);
    const double dy = -0.4 * 1.3 * sin(point[0]) * sin(1.3 * point[1]);
    if (r->refuses)
        return PLANISH_CONSTRAINT_FIXED;
    point[2] = height(point[0], point[1]);
    if (r->constraint[node] == PLANISH_CONSTRAINT_ON_LINE) {
        const int along = r->direction[3 * node] != 0 ? 0 : 1;
        direction[along] = 5; /* not of unit length */
        direction[2] = 5 * (along == 0 ? dx : dy);
        return PLANISH_CONSTRAINT_ON_LINE;
    }
    direction[0] = -dx;
    direction[1] = -dy;
    direction[2] = 1;
    return PLANISH_CONSTRAINT_ON_PLANE;
}

/** Raise the roof; its nodes slide on it, but for the corners, and those of the other sides stay.
 */
static void raise_roof(sliding_box *b) {
    for (int64_t i = 0; i < b->mesh.n_nodes; i++) {
        double *x = b->base.coordinates + 3 * i;
        if (x[2] == CELLS && b->constraint[i] != PLANISH_CONSTRAINT_FIXED)
            b->constraint[i] = PLANISH_CONSTRAINT_ON_SURFACE;
        else if (b->constraint[i] != PLANISH_CONSTRAINT_FREE)
            b->constraint[i] = PLANISH_CONSTRAINT_FIXED;
        x[2] *= height(x[0], x[1]) / CELLS;
    }
}

static void a_surface_is_asked_for(void **state) {
    (void)state;
    sliding_box b;
    planish_options options = test_options(1);
    box_create(&b, 3);
    const size_t n = (size_t)b.mesh.n_nodes;
    uint8_t *flat = malloc(n);
    memcpy(flat, b.constraint, n);
    roof user = {flat, b.direction, 0};
    raise_roof(&b);
    b.mesh.direction = NULL;
    options.project = on_roof;
    options.project_user = &user;
    smooth(&b, &options);
    assert_int_equal(b.before.n_inverted, 0);
    assert_int_equal(b.after.n_inverted, 0);
    assert_true(b.after.max_radius_ratio <= b.before.max_radius_ratio);
    int64_t moved[2] = {0, 0}, all[2] = {0, 0};
    for (size_t i = 0; i < n; i++) {
        const double *x = b.coordinates + 3 * i, *from = b.base.coordinates + 3 * i;
        if (b.constraint[i] != PLANISH_CONSTRAINT_ON_SURFACE)
            continue;
        const int eaves = flat[i] == PLANISH_CONSTRAINT_ON_LINE;
        all[eaves]++;
        moved[eaves] += memcmp(x, from, 3 * sizeof *x) != 0;
        assert_true(fabs(x[2] - height(x[0], x[1])) < 1e-14);
        for (int d = 0; d < 2; d++)
            assert_true((from[d] != 0 && from[d] != CELLS) || x[d] == from[d]);
    }
    assert_true(moved[0] > all[0] / 2 && moved[1] > all[1] / 2);
    const double slid = b.after.rms_radius_ratio;
    user.refuses = 1;
    smooth(&b, &options);
    assert_true(b.after.rms_radius_ratio > slid);
    for (size_t i = 0; i < n; i++)
        if (b.constraint[i] == PLANISH_CONSTRAINT_ON_SURFACE)
            assert_memory_equal(b.coordinates + 3 * i, b.base.coordinates + 3 * i,
                                3 * sizeof(double));
    double *refused = malloc(bytes_of(&b));
    memcpy(refused, b.coordinates, bytes_of(&b));
    options.project = NULL; /* the same */
    smooth(&b, &options);
    assert_memory_equal(refused, b.coordinates, bytes_of(&b));
    free(refused);
    free(flat);
    box_destroy(&b);
}

/** Where nodes began, by their numbers in the mesh. */
typedef struct roll {
    const double *start; /* [n_nodes][3] of the box */
    double length;       /* of the directions that are told */
    _Atomic int calls, strangers;
} roll;

static planish_constraint on_side(int64_t node, double *point, double *direction, void *user) {
    roll *r = user;
    const double *start = r->start + 3 * node;
    double far = 0;
    r->calls++;
    for (int d = 0; d < 3; d++)
        far += fabs(point[d] - start[d]);
    r->strangers += far > 2;
    for (int d = 0; d < 3; d++)
        if (start[d] == 0 || start[d] == CELLS) {
            direction[d] = r->length;
            point[d] = start[d];
            return PLANISH_CONSTRAINT_ON_PLANE;
        }
    return PLANISH_CONSTRAINT_FIXED;
}

/** A box whose sides only the caller knows; edges stay. */
static void box_of_surfaces(sliding_box *b) {
    box_create(b, 3);
    for (int64_t i = 0; i < b->mesh.n_nodes; i++)
        b->constraint[i] = b->constraint[i] == PLANISH_CONSTRAINT_ON_PLANE
                               ? PLANISH_CONSTRAINT_ON_SURFACE
                           : b->constraint[i] != PLANISH_CONSTRAINT_FREE ? PLANISH_CONSTRAINT_FIXED
                                                                         : PLANISH_CONSTRAINT_FREE;
    b->mesh.direction = NULL;
}

/** A node is named by its number in the mesh, in plans of a part of it too. */
static void surfaces_are_asked_for_by_number(void **state) {
    (void)state;
    sliding_box b;
    box_of_surfaces(&b);
    roll user = {.start = b.base.coordinates, .length = 1};
    const int64_t middle = (CELLS + 1) * (CELLS + 1) * 2 + (CELLS + 1) * 2;
    assert_int_equal(b.constraint[middle], PLANISH_CONSTRAINT_ON_SURFACE);
    for (int which = 0; which < 3; which++) {
        planish_options options = test_options(1);
        options.project = on_side;
        options.project_user = &user;
        options.rings = which == 1;
        options.around = which == 1 ? &middle : NULL;
        options.n_around = which == 1;
        options.only_worse_than = which == 2 ? 1.5 : 0;
        user.calls = 0;
        smooth(&b, &options);
        assert_true(user.calls > 0);
        assert_int_equal(user.strangers, 0);
        int moved = 0;
        for (int64_t i = 0; i < b.mesh.n_nodes; i++)
            moved +=
                b.constraint[i] == PLANISH_CONSTRAINT_ON_SURFACE &&
                memcmp(b.coordinates + 3 * i, b.base.coordinates + 3 * i, 3 * sizeof(double)) != 0;
        if (moved == 0)
            fail_msg("plan %d: %d nodes slide, none moved", which, (int)b.info.n_sliding);
    }
    box_destroy(&b);
}

/** Directions are of any length but 0. */
static void lengths_of_normals_do_not_matter(void **state) {
    (void)state;
    static const double lengths[] = {1, 0x1p-60, 0x1p600, 0x1p-600, 0x1p-1074};
    sliding_box b;
    box_of_surfaces(&b);
    double *first = malloc(bytes_of(&b));
    for (size_t k = 0; k < sizeof lengths / sizeof *lengths; k++) {
        planish_options options = test_options(1);
        roll user = {.start = b.base.coordinates, .length = lengths[k]};
        options.project = on_side;
        options.project_user = &user;
        smooth(&b, &options);
        if (k == 0)
            memcpy(first, b.coordinates, bytes_of(&b));
        assert_true(b.after.rms_radius_ratio < b.before.rms_radius_ratio);
        assert_true(b.result.n_moved_nodes > b.info.n_free + b.info.n_sliding / 2);
        assert_memory_equal(first, b.coordinates, bytes_of(&b));
    }
    free(first);
    box_destroy(&b);
}

/** A fan of n triangles: all around node 0, or on one side of it. */
static void limits_on_elements_of_a_node(void **state) {
    (void)state;
    static const struct {
        int n, is_closed, moves;
    } fans[] = {{21845, 0, 1}, {21846, 0, 0}, {43690, 1, 1}, {43691, 1, 0}};
    for (size_t k = 0; k < sizeof fans / sizeof *fans; k++) {
        const int n = fans[k].n;
        const size_t n_nodes = (size_t)n + 2;
        double *x = calloc(2 * n_nodes, sizeof *x), *direction = calloc(2 * n_nodes, sizeof *x);
        int32_t *elements = malloc(3 * (size_t)n * sizeof *elements);
        uint8_t *constraint = malloc(n_nodes);
        memset(constraint, PLANISH_CONSTRAINT_FIXED, n_nodes);
        constraint[0] = fans[k].is_closed ? PLANISH_CONSTRAINT_FREE : PLANISH_CONSTRAINT_ON_LINE;
        direction[0] = 1;
        for (int i = 0; i <= n; i++) {
            const double angle = 3.141592653589793 * (fans[k].is_closed + 1) * i / n;
            x[2 * (i + 1)] = cos(angle);
            x[2 * (i + 1) + 1] = i == n && !fans[k].is_closed ? 0 : sin(angle);
            if (i < n) {
                elements[3 * i] = 0;
                elements[3 * i + 1] = i + 1;
                elements[3 * i + 2] = i + 1 == n && fans[k].is_closed ? 1 : i + 2;
            }
        }
        const planish_mesh mesh = {.dim = 2,
                                   .n_nodes = (int64_t)n_nodes - fans[k].is_closed,
                                   .n_elements = n,
                                   .coordinates = x,
                                   .elements = elements,
                                   .constraint = constraint,
                                   .direction = direction};
        planish_plan *plan;
        planish_plan_info info;
        assert_int_equal(planish_plan_create(&mesh, NULL, &plan, NULL), 0);
        planish_plan_get_info(plan, &info);
        assert_int_equal(info.n_free + info.n_sliding, fans[k].moves);
        planish_plan_destroy(plan);
        free(x);
        free(direction);
        free(elements);
        free(constraint);
    }
}

/** Many pieces that share no more than a node on a line: its ring has more nodes than its link has
 *  facets, and more than a byte can number before the link itself is that large. */
static void separate_pieces_are_one_star(void **state) {
    (void)state;
    static const int pieces[] = {60, 85, 86, 100, 128, 129, 140, 170, 171, 200};
    const planish_options options = test_options(1);
    for (size_t k = 0; k < sizeof pieces / sizeof *pieces; k++) {
        const int n = pieces[k];
        const size_t n_nodes = 1 + 2 * (size_t)n;
        double *x = calloc(2 * n_nodes, sizeof *x), direction[2] = {1, 0};
        double *directions = calloc(2 * n_nodes, sizeof *x);
        int32_t *elements = malloc(3 * (size_t)n * sizeof *elements);
        uint8_t *constraint = malloc(n_nodes);
        memset(constraint, PLANISH_CONSTRAINT_FIXED, n_nodes);
        constraint[0] = PLANISH_CONSTRAINT_ON_LINE;
        memcpy(directions, direction, sizeof direction);
        x[0] = -0.5;
        for (int i = 0; i < n; i++) {
            for (int j = 0; j < 2; j++) {
                const double angle = 6.283185307179586 * (i + 0.6 * j) / n;
                x[2 * (1 + 2 * i + j)] = cos(angle);
                x[2 * (1 + 2 * i + j) + 1] = sin(angle);
                elements[3 * i + 1 + j] = 1 + 2 * i + j;
            }
            elements[3 * i] = 0;
        }
        /* The last piece is in the way to the middle. */
        const double gate[] = {-0.2, -0.05, -0.2, 0.05};
        memcpy(x + 2 * n_nodes - 4, gate, sizeof gate);
        const planish_mesh mesh = {.dim = 2,
                                   .n_nodes = (int64_t)n_nodes,
                                   .n_elements = n,
                                   .coordinates = x,
                                   .elements = elements,
                                   .constraint = constraint,
                                   .direction = directions};
        planish_plan *plan;
        planish_plan_info info;
        planish_result result;
        assert_int_equal(planish_plan_create(&mesh, &options, &plan, NULL), 0);
        planish_plan_get_info(plan, &info);
        assert_int_equal(info.n_sliding, 1);
        assert_int_equal(planish_smooth(plan, x, &options, &result, NULL), 0);
        assert_int_equal(result.n_inverted, 0);
        assert_true(x[0] > -0.45 && x[0] < -0.2 && x[1] == 0);
        planish_plan_destroy(plan);
        free(x);
        free(directions);
        free(elements);
        free(constraint);
    }
}

/** While an element is not positive the node stays, minimum volume or not. */
static void nodes_of_inverted_elements_stay(void **state) {
    (void)state;
    static const double valid[] = {-1, 0, 1, 0, 0, 2, -3, 2, 3, 2, 0, -1};
    static const int32_t elements[] = {0, 1, 2, 0, 2, 3, 1, 4, 2, 5, 1, 0};
    static const uint8_t constraint[] = {1, 1, 1, 1, 1, PLANISH_CONSTRAINT_ON_LINE};
    static const double direction[12] = {[11] = 1};
    const planish_mesh mesh = {.dim = 2,
                               .n_nodes = 6,
                               .n_elements = 4,
                               .coordinates = valid,
                               .elements = elements,
                               .constraint = constraint,
                               .direction = direction};
    for (int least = 0; least < 2; least++) {
        planish_options options = test_options(1);
        planish_plan *plan;
        planish_result result;
        double x[12];
        options.min_volume = least ? 0.01 : 0;
        memcpy(x, valid, sizeof x);
        x[11] = 0.5;
        assert_int_equal(planish_plan_create(&mesh, &options, &plan, NULL), 0);
        assert_int_equal(planish_smooth(plan, x, &options, &result, NULL), 0);
        assert_int_equal(result.n_inverted, 1);
        assert_true(x[10] == 0 && x[11] == 0.5);
        planish_plan_destroy(plan);
    }
}

/* ---- what cannot slide --------------------------------------------------------------------- */

/** A node with a facet of more than two elements stays. */
static void nonmanifold_nodes_stay(void **state) {
    (void)state;
    static const double x[][3] = {{0, 0, 0}, {1, 0, 0},  {0, 1, 0},
                                  {0, 0, 1}, {0, 0, -1}, {1, 1, 1}};
    static const int32_t elements[][4] = {{0, 1, 2, 3}, {0, 2, 1, 4}, {0, 1, 2, 5}};
    test_mesh base;
    planish_plan *plan;
    planish_plan_info info;
    const planish_options options = test_options(1);
    uint8_t constraint[6];
    double direction[6][3];
    test_mesh_create(&base, 3, 6, &x[0][0], 3, &elements[0][0]);
    for (int i = 0; i < 6; i++) {
        constraint[i] = PLANISH_CONSTRAINT_ON_PLANE;
        direction[i][0] = direction[i][1] = direction[i][2] = 1;
    }
    planish_mesh mesh = base.mesh;
    mesh.constraint = constraint;
    mesh.direction = &direction[0][0];
    assert_int_equal(planish_plan_create(&mesh, &options, &plan, NULL), 0);
    planish_plan_get_info(plan, &info);
    assert_int_equal(info.n_sliding, 3); /* the tips; three nodes share the facet */
    planish_plan_destroy(plan);
    test_mesh_destroy(&base);
}

static void wrong_constraints_are_refused(void **state) {
    (void)state;
    sliding_box b;
    planish_plan *plan;
    planish_error error;
    const planish_options options = test_options(1);
    box_create(&b, 3);
    int64_t node = 0;
    while (b.constraint[node] != PLANISH_CONSTRAINT_ON_LINE)
        node++;
    double *direction = b.direction + 3 * node;
    const double wrong[][3] = {{0, 0, 0}, {NAN, 1, 0}, {INFINITY, 0, 0}};
    for (int i = 0; i < 3; i++) {
        memcpy(direction, wrong[i], sizeof wrong[i]);
        assert_int_equal(planish_plan_create(&b.mesh, &options, &plan, &error),
                         PLANISH_ERROR_ARGUMENT);
        assert_int_equal(error.node, node);
    }
    direction[0] = 1e-300; /* a direction all the same */
    direction[1] = direction[2] = 0;
    assert_int_equal(planish_plan_create(&b.mesh, &options, &plan, &error), 0);
    planish_plan_destroy(plan);
    b.mesh.direction = NULL;
    assert_int_equal(planish_plan_create(&b.mesh, &options, &plan, &error), PLANISH_ERROR_ARGUMENT);
    b.mesh.direction = b.direction;
    b.constraint[3] = PLANISH_CONSTRAINT_ON_CURVE + 1;
    assert_int_equal(planish_plan_create(&b.mesh, &options, &plan, &error), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(error.node, 3);
    box_destroy(&b);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sides_keep_their_place),
        cmocka_unit_test(slanting_sides_are_left_by_rounding_only),
        cmocka_unit_test(bits_do_not_depend_on_threads_or_kernels),
        cmocka_unit_test(other_options_go_with_it),
        cmocka_unit_test(sides_slide_alone),
        cmocka_unit_test(tangled_meshes_are_mended),
        cmocka_unit_test(a_surface_is_asked_for),
        cmocka_unit_test(surfaces_are_asked_for_by_number),
        cmocka_unit_test(lengths_of_normals_do_not_matter),
        cmocka_unit_test(limits_on_elements_of_a_node),
        cmocka_unit_test(separate_pieces_are_one_star),
        cmocka_unit_test(nodes_of_inverted_elements_stay),
        cmocka_unit_test(nonmanifold_nodes_stay),
        cmocka_unit_test(wrong_constraints_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
