/* What planish_smooth promises with minimum volumes, other objectives, bounds and the rivals, and
 * what planish_check_volumes says: all by the public functions. */
#include "support/allocations.h"
#include "support/effort.h"
#include "support/meshes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* A minimum volume counts as reached at this fraction of it. */
#define MET 0.997

typedef struct smoothed {
    double *coordinates; /* [n_nodes][dim] owned */
    planish_quality before, after;
    planish_result result;
} smoothed;

static planish_options defaults(void) {
    planish_options options;
    planish_options_init(&options);
    options.threads = 1;
    return options;
}

static size_t bytes_of(const planish_mesh *mesh) {
    return (size_t)mesh->n_nodes * (size_t)mesh->dim * sizeof(double);
}

static void smooth(const planish_mesh *mesh, const planish_options *options, smoothed *s) {
    planish_plan *plan;
    planish_error error = {.text = ""};
    s->coordinates = malloc(bytes_of(mesh));
    memcpy(s->coordinates, mesh->coordinates, bytes_of(mesh));
    assert_int_equal(planish_plan_create(mesh, options, &plan, &error), 0);
    assert_int_equal(planish_measure(plan, s->coordinates, &s->before, &error), 0);
    assert_int_equal(planish_smooth(plan, s->coordinates, options, &s->result, &error), 0);
    assert_int_equal(planish_measure(plan, s->coordinates, &s->after, &error), 0);
    assert_int_equal(s->result.inverted, s->after.inverted);
    planish_plan_destroy(plan);
}

/** Volume of the elements of a box of unit cells before it was perturbed. */
static double regular_volume(int dim) {
    return dim == 3 ? 1.0 / 6 : 0.5;
}

static void bad_box(test_mesh *mesh, int dim, int cells, unsigned seed) {
    test_mesh_box(mesh, dim, cells);
    test_mesh_perturb(mesh, 0.14, seed * 2654435761u + 1);
}

static int is_inside(const double *x, int dim, int cells) {
    int inside = 1;
    for (int d = 0; d < dim; d++)
        inside &= x[d] != 0 && x[d] != cells;
    return inside;
}

static double measure(const planish_mesh *mesh, const double *coordinates, int64_t element) {
    const int dim = mesh->dim;
    const int32_t *node = mesh->elements + element * (dim + 1);
    double e[3][3] = {{0}};
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            e[j][d] = coordinates[node[j + 1] * dim + d] - coordinates[node[0] * dim + d];
    if (dim == 2)
        return (e[0][0] * e[1][1] - e[0][1] * e[1][0]) / 2;
    return (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
            e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
            e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) /
           6;
}

/** Elements of positive volumes below MET of least, or of their own. */
static int64_t count_below(const planish_mesh *mesh, const double *coordinates, double least) {
    int64_t n = 0;
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        double own = mesh->min_volume && mesh->min_volume[i] > 0 ? mesh->min_volume[i] : least;
        n += measure(mesh, coordinates, i) < MET * (1 - 1e-12) * own;
    }
    return n;
}

/** Fill state (may be NULL) by planish_check_volumes; returns how many are below. */
static int64_t check_volumes(const planish_mesh *mesh, const double *coordinates,
                             const planish_options *options, uint8_t *state) {
    planish_plan *plan;
    int64_t n_below = -1;
    assert_int_equal(planish_plan_create(mesh, options, &plan, NULL), 0);
    assert_int_equal(planish_check_volumes(plan, coordinates, options, state, &n_below, NULL), 0);
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
    if (w->sweeps > 0 && !progress->restoring)
        assert_true(progress->objective <= w->last);
    w->last = progress->objective;
    w->sweeps++;
    w->restoring += progress->restoring != 0;
    return 0;
}

static void f_never_rises(void **state) {
    int dim = *(int *)*state;
    for (int objective = 0; objective < 3; objective++)
        for (int weight = 0; weight < 3; weight++)
            for (int direction = 0; direction < 2; direction++) {
                test_mesh mesh;
                smoothed s;
                watch w = {0, 0, 0};
                bad_box(&mesh, dim, dim == 3 ? 5 : 8, (unsigned)(3 * objective + weight));
                planish_options options = defaults();
                options.objective = (planish_objective)objective;
                options.area_weight = 0.5 * weight;
                options.direction = (planish_direction)direction;
                options.min_volume = 0.75 * regular_volume(dim);
                options.progress = f_falls;
                options.progress_user = &w;
                smooth(&mesh.mesh, &options, &s);
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
            smoothed s;
            planish_options options = defaults();
            bad_box(&mesh, dim, dim == 3 ? 3 : 4, seed);
            options.min_volume = (0.9 + 0.05 * (seed % 5)) * regular_volume(dim);
            options.max_sweeps = sweeps;
            const int64_t before = count_below(&mesh.mesh, mesh.coordinates, options.min_volume);
            smooth(&mesh.mesh, &options, &s);
            const int64_t after = count_below(&mesh.mesh, s.coordinates, options.min_volume);
            assert_true(after <= before);
            n_back += s.result.moved_nodes == 0;
            free(s.coordinates);
            test_mesh_destroy(&mesh);
        }
    figure("%d-D: %d of 200 runs went back to the start", dim, n_back);
}

/** Without restoring, F at the end is below that at the start, and is what it is said to be. */
static void f_is_the_weighted_sum(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    smoothed s;
    bad_box(&mesh, dim, 4, 1);
    planish_options options = defaults();
    options.area_weight = 0.25;
    options.min_volume = 0.1 * regular_volume(dim);
    smooth(&mesh.mesh, &options, &s);
    double squares = 0;
    for (int64_t i = 0; i < mesh.mesh.n_elements; i++) {
        double g = 1 - measure(&mesh.mesh, s.coordinates, i) / options.min_volume;
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
    double volume = part * regular_volume(mesh->mesh.dim), total = 0;
    for (int64_t i = 0; i < mesh->mesh.n_elements; i++) {
        own[i] = i % 3 ? volume : 0.5 * volume;
        total += measure(&mesh->mesh, mesh->coordinates, i);
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
            smoothed s;
            bad_box(&mesh, dim, dim == 3 ? 4 : 8, (unsigned)objective);
            double *own = malloc((size_t)mesh.mesh.n_elements * sizeof *own);
            planish_options options = defaults();
            options.objective = (planish_objective)objective;
            ask_for_volume(&mesh, &options, kind, 0.7, own);
            double volume = 0.7 * regular_volume(dim);
            assert_true(check_volumes(&mesh.mesh, mesh.coordinates, &options, NULL) > 0);
            smooth(&mesh.mesh, &options, &s);
            assert_int_equal(s.result.stop, PLANISH_STOP_CONVERGED);
            assert_int_equal(s.result.below_min_volume, 0);
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
    bad_box(&mesh, dim, 4, 3);
    uint8_t *found = malloc((size_t)mesh.mesh.n_elements);
    planish_options options = defaults();
    assert_int_equal(check_volumes(&mesh.mesh, mesh.coordinates, &options, found), 0);
    options.min_volume = 0.8 * regular_volume(dim);
    int64_t n = check_volumes(&mesh.mesh, mesh.coordinates, &options, found);
    assert_int_equal(n, count_below(&mesh.mesh, mesh.coordinates, options.min_volume));
    for (int64_t i = 0; i < mesh.mesh.n_elements; i++) {
        int below = measure(&mesh.mesh, mesh.coordinates, i) < MET * options.min_volume;
        assert_int_equal(found[i], below ? PLANISH_VOLUME_BELOW : PLANISH_VOLUME_MET);
    }
    free(found);
    test_mesh_destroy(&mesh);
}

/** A corner's element has no free node. */
static void fixed_elements_are_infeasible(void **state) {
    int dim = *(int *)*state, n_fixed = 0;
    test_mesh mesh;
    smoothed s;
    bad_box(&mesh, dim, 4, 2);
    double *own = calloc((size_t)mesh.mesh.n_elements, sizeof *own);
    uint8_t *found = malloc((size_t)mesh.mesh.n_elements);
    mesh.mesh.min_volume = own;
    for (int64_t i = 0; i < mesh.mesh.n_elements; i++) {
        int fixed = 1;
        for (int j = 0; j <= dim; j++)
            fixed &= !is_inside(mesh.coordinates + mesh.elements[i * (dim + 1) + j] * dim, dim, 4);
        own[i] = fixed ? 1.1 * regular_volume(dim) : 0;
        n_fixed += fixed;
    }
    planish_options options = defaults();
    assert_true(n_fixed > 0);
    assert_int_equal(check_volumes(&mesh.mesh, mesh.coordinates, &options, found), n_fixed);
    for (int64_t i = 0; i < mesh.mesh.n_elements; i++)
        assert_int_equal(found[i], own[i] > 0 ? PLANISH_VOLUME_INFEASIBLE : PLANISH_VOLUME_MET);
    smooth(&mesh.mesh, &options, &s);
    assert_int_equal(s.result.stop, PLANISH_STOP_INFEASIBLE);
    assert_int_equal(s.result.below_min_volume, n_fixed);
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
    smoothed s;
    bad_box(&mesh, dim, 2, 2);
    uint8_t *found = malloc((size_t)mesh.mesh.n_elements);
    planish_options options = defaults();
    options.min_volume = 0.9 * regular_volume(dim);
    check_volumes(&mesh.mesh, mesh.coordinates, &options, found);
    for (int64_t i = 0; i < mesh.mesh.n_elements; i++)
        assert_int_not_equal(found[i], PLANISH_VOLUME_INFEASIBLE);
    smooth(&mesh.mesh, &options, &s);
    assert_int_equal(s.result.stop, PLANISH_STOP_CONVERGED);
    assert_int_equal(s.result.below_min_volume, 0);
    free(s.coordinates);

    options.min_volume = 1.1 * regular_volume(dim);
    int64_t n = check_volumes(&mesh.mesh, mesh.coordinates, &options, found);
    for (int64_t i = 0; i < mesh.mesh.n_elements; i++) {
        int inner = 0;
        for (int j = 0; j <= dim; j++)
            inner |= is_inside(mesh.coordinates + mesh.elements[i * (dim + 1) + j] * dim, dim, 2);
        if (!inner)
            assert_int_equal(found[i], PLANISH_VOLUME_INFEASIBLE);
        n_proof += inner && found[i] == PLANISH_VOLUME_INFEASIBLE;
    }
    assert_true(n_proof > 1);
    assert_true(n >= n_proof);
    smooth(&mesh.mesh, &options, &s);
    assert_int_equal(s.result.stop, PLANISH_STOP_INFEASIBLE);
    free(s.coordinates);
    free(found);
    test_mesh_destroy(&mesh);
}

/** With free neighbours there is no proof, however much is asked for. */
static void elements_with_free_neighbours_are_not_infeasible(void **state) {
    int dim = *(int *)*state, several = 0;
    test_mesh mesh;
    bad_box(&mesh, dim, 4, 2);
    uint8_t *found = malloc((size_t)mesh.mesh.n_elements);
    planish_options options = defaults();
    options.min_volume = 2 * regular_volume(dim);
    check_volumes(&mesh.mesh, mesh.coordinates, &options, found);
    for (int64_t i = 0; i < mesh.mesh.n_elements; i++) {
        int n_free = 0;
        for (int j = 0; j <= dim; j++)
            n_free += is_inside(mesh.coordinates + mesh.elements[i * (dim + 1) + j] * dim, dim, 4);
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
            smoothed s;
            unsigned random = seed * 2654435761u;
            bad_box(&mesh, dim, 4, seed);
            for (int64_t i = 0; i < mesh.mesh.n_nodes; i++)
                if (is_inside(mesh.coordinates + i * dim, dim, 4) &&
                    (i == mesh.mesh.n_nodes / 2 || test_random(&random) < 0.15))
                    mesh.coordinates[i * dim + (int64_t)(seed % 2)] += seed % 3 ? 1.7 : -1.4;
            planish_options options = defaults();
            options.objective = (planish_objective)objective;
            options.min_volume = 0.2 * regular_volume(dim);
            smooth(&mesh.mesh, &options, &s);
            assert_true(s.before.inverted > 0);
            assert_int_equal(s.after.inverted, 0);
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
        smoothed s;
        planish_options options = defaults();
        bad_box(&mesh, dim, dim == 3 ? 4 : 8, seed);
        options.objective = (planish_objective)(seed % 3);
        options.direction = (planish_direction)(seed / 3 % 2);
        options.min_volume = 0.3 * (seed / 6 % 3) * regular_volume(dim);
        options.area_weight = options.min_volume > 0 ? 0.5 * (seed / 18) : 0;
        options.precision = seed % 5 == 0 ? PLANISH_FLOAT : PLANISH_DOUBLE;
        for (int64_t i = 0; i < mesh.mesh.n_nodes * dim; i++)
            mesh.coordinates[i] = (double)(float)mesh.coordinates[i];
        smooth(&mesh.mesh, &options, &s);
        assert_int_equal(s.before.inverted, 0);
        assert_int_equal(s.after.inverted, 0);
        if (count_below(&mesh.mesh, mesh.coordinates, options.min_volume) == 0) {
            assert_true(s.after.max_radius_ratio <= s.before.max_radius_ratio);
            limited++;
        }
        assert_true(s.result.moved_nodes > 0);
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
        smoothed s;
        bad_box(&mesh, dim, 6, 4);
        for (int64_t i = 0; i < mesh.mesh.n_nodes; i++) {
            int central = 1;
            for (int d = 0; d < dim; d++)
                central &= fabs(mesh.coordinates[i * dim + d] - 3) < 0.5;
            mesh.coordinates[i * dim] += central ? 1.6 : 0;
        }
        planish_options options = defaults();
        options.objective = (planish_objective)objective;
        options.untangle = 0;
        smooth(&mesh.mesh, &options, &s);
        assert_true(s.before.inverted > 0);
        assert_int_equal(s.after.inverted, s.before.inverted);
        assert_true(s.after.max_radius_ratio <= s.before.max_radius_ratio);
        free(s.coordinates);
        test_mesh_destroy(&mesh);
    }
}

/* ---- bounds -------------------------------------------------------------------------------- */

enum { NO_BOUNDS, BOX, PER_NODE, DISTANCE, EDGES, ALL_BOUNDS, BOUNDS };

/** The bounds of a run; arrays [n_nodes][dim] are owned. */
typedef struct bounded {
    double *lower, *upper;
} bounded;

/** Bounds of the kind. Of the nodes' own ones, some leave out where the node is. */
static bounded set_bounds(const test_mesh *mesh, int kind, planish_options *options) {
    const int dim = mesh->mesh.dim;
    bounded b = {malloc(bytes_of(&mesh->mesh)), malloc(bytes_of(&mesh->mesh))};
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
    if (outside || !is_inside(x, dim, 4))
        assert_memory_equal(x, y, (size_t)dim * sizeof *x);
    else
        assert_true(inside);
    return outside && is_inside(x, dim, 4) ? -1 : at;
}

static double moved(const double *x, const double *y, int dim) {
    long double square = 0;
    for (int d = 0; d < dim; d++)
        square += ((long double)x[d] - y[d]) * ((long double)x[d] - y[d]);
    return (double)sqrtl(square);
}

/** Check a result against its bounds; returns how many bounds nodes have come to. */
static int check_bounds(const test_mesh *mesh, const planish_options *options, const smoothed *s) {
    const int dim = mesh->mesh.dim;
    int64_t held = 0;
    int reached = 0;
    for (int64_t i = 0; i < mesh->mesh.n_nodes; i++) {
        const double *y = s->coordinates + i * dim;
        double far = moved(mesh->coordinates + i * dim, y, dim), most = options->max_displacement;
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
    assert_int_equal(s->result.held_outside, held);
    return reached;
}

static void bounds_are_kept(void **state) {
    int dim = *(int *)*state;
    for (int kind = BOX; kind < BOUNDS; kind++) {
        int reached = 0;
        for (unsigned i = 0; i < 24; i++) {
            test_mesh mesh;
            smoothed s;
            bad_box(&mesh, dim, 4, i);
            planish_options options = defaults();
            bounded b = set_bounds(&mesh, kind, &options);
            options.method = i % 4 < 2 ? PLANISH_METHOD_PLANISH : (planish_method)(1 + i % 3);
            options.objective = (planish_objective)(i / 2 % 3);
            options.direction = (planish_direction)(i % 2);
            options.precision = i / 12 ? PLANISH_FLOAT : PLANISH_DOUBLE;
            options.min_volume = i % 3 ? 0 : 0.5 * regular_volume(dim);
            smooth(&mesh.mesh, &options, &s);
            reached += check_bounds(&mesh, &options, &s);
            release_bounds(&b);
            free(s.coordinates);
            test_mesh_destroy(&mesh);
        }
        assert_true(reached > 0);
    }
}

/* ---- the same bits ------------------------------------------------------------------------- */

static void compare(const planish_mesh *mesh, const smoothed *a, const smoothed *b) {
    assert_memory_equal(a->coordinates, b->coordinates, bytes_of(mesh));
    assert_true(a->result.objective == b->result.objective);
    assert_true(a->result.kkt_residual == b->result.kkt_residual);
    assert_true(a->result.kkt_rms == b->result.kkt_rms);
    assert_true(a->result.max_multiplier == b->result.max_multiplier);
    assert_int_equal(a->result.n_active, b->result.n_active);
    assert_int_equal(a->result.evaluations, b->result.evaluations);
    assert_int_equal(a->result.below_min_volume, b->result.below_min_volume);
    assert_int_equal(a->result.held_outside, b->result.held_outside);
}

static void compare_teams(const test_mesh *mesh, planish_options options) {
    static const planish_isa isas[] = {PLANISH_ISA_VECTOR, PLANISH_ISA_AVX2, PLANISH_ISA_AVX512};
    static const int threads[] = {2, 3, 5};
    smoothed first, other;
    options.isa = PLANISH_ISA_PLAIN;
    smooth(&mesh->mesh, &options, &first);
    assert_true(first.result.moved_nodes > 0);
    for (int i = 0; i < 3; i++) {
        planish_plan *plan;
        options.threads = threads[i];
        options.isa = isas[i];
        if (planish_plan_create(&mesh->mesh, &options, &plan, NULL) != 0)
            options.isa = PLANISH_ISA_AUTO; /* this CPU has no such instructions */
        else
            planish_plan_destroy(plan);
        smooth(&mesh->mesh, &options, &other);
        compare(&mesh->mesh, &first, &other);
        free(other.coordinates);
    }
    free(first.coordinates);
}

static void bits_do_not_depend_on_threads_or_kernel(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    bad_box(&mesh, dim, dim == 3 ? 8 : 16, 1);
    for (int method = 0; method < 4; method++)
        for (int kind = 0; kind < BOUNDS; kind++)
            for (int objective = 0; objective < (method == 0 && kind < BOX + 1 ? 3 : 1);
                 objective++) {
                planish_options options = defaults();
                bounded b = set_bounds(&mesh, kind, &options);
                options.method = (planish_method)method;
                options.objective = (planish_objective)((objective + kind) % 3);
                options.direction = (planish_direction)(kind % 2);
                options.area_weight = kind % 3 == 1 ? 0.3 : 0;
                options.min_volume = 0.6 * regular_volume(dim);
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

static void smooth_scaled(int dim, int kind, int i, int exponent, smoothed *s) {
    test_mesh mesh;
    bad_box(&mesh, dim, 4, 1);
    planish_options options = defaults();
    bounded b = set_bounds(&mesh, kind, &options);
    options.objective = (planish_objective)(i % 3);
    options.method = i == 3 ? PLANISH_METHOD_LENGTH_LAPLACIAN : PLANISH_METHOD_PLANISH;
    options.area_weight = i == 2 ? 0.5 : 0;
    if (i == 1)
        options.min_volume_fraction = 0.6 / (double)mesh.mesh.n_elements;
    else
        options.min_volume = 0.6 * regular_volume(dim);
    scale_everything(&mesh, &options, &b, exponent);
    smooth(&mesh.mesh, &options, s);
    release_bounds(&b);
    test_mesh_destroy(&mesh);
}

static void powers_of_two_change_no_bit(void **state) {
    int dim = *(int *)*state;
    static const int exponents[] = {-300, -1, 7, 300};
    for (int kind = 0; kind < BOUNDS; kind++)
        for (int i = 0; i < 4; i++) {
            smoothed plain, scaled;
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

/* ---- optimality ---------------------------------------------------------------------------- */

static void optimality_is_reported(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    smoothed s;
    bad_box(&mesh, dim, 4, 6);
    double *own = malloc((size_t)mesh.mesh.n_elements * sizeof *own);
    planish_options options = defaults();
    smooth(&mesh.mesh, &options, &s);
    assert_true(s.result.kkt_residual == 0 && s.result.kkt_rms == 0);
    assert_true(s.result.max_multiplier == 0 && s.result.n_active == 0);
    free(s.coordinates);
    for (int64_t i = 0; i < mesh.mesh.n_elements; i++)
        own[i] = (i % 11 == 5 ? 1.15 : 0.1) * regular_volume(dim);
    mesh.mesh.min_volume = own;
    for (int direction = 0; direction < 2; direction++) {
        options.direction = (planish_direction)direction;
        options.tolerance = 1e-10;
        options.max_sweeps = 2000;
        smooth(&mesh.mesh, &options, &s);
        assert_true(s.result.max_multiplier > 0 && s.result.n_active > 0);
        assert_true(s.result.kkt_residual < 1e-3 && s.result.kkt_rms <= s.result.kkt_residual);
        free(s.coordinates);
    }
    free(own);
    test_mesh_destroy(&mesh);
}

/** F of the mesh with its coordinates as they are. */
static double objective_at(const planish_mesh *mesh, const planish_options *options) {
    smoothed s;
    planish_options still = *options;
    still.max_sweeps = 0;
    smooth(mesh, &still, &s);
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
            smoothed s;
            test_mesh_box(&mesh, dim, 2);
            const int64_t centre = dim == 3 ? 13 : 4;
            const int64_t element = first_element_of(&mesh.mesh, centre);
            double *own = malloc((size_t)mesh.mesh.n_elements * sizeof *own);
            for (int64_t i = 0; i < mesh.mesh.n_elements; i++)
                own[i] = (i == element ? 1.2 : 0.2) * regular_volume(dim);
            mesh.mesh.min_volume = own;
            planish_options options = defaults();
            options.objective = (planish_objective)objective;
            options.area_weight = 0.1 * weight;
            options.tolerance = 0;
            options.max_sweeps = 500;
            smooth(&mesh.mesh, &options, &s);
            assert_int_equal(s.result.n_active, 1);
            for (int d = 0; d < dim; d++) {
                double f[2], g[2];
                for (int side = 0; side < 2; side++) {
                    memcpy(mesh.coordinates, s.coordinates, bytes_of(&mesh.mesh));
                    mesh.coordinates[centre * dim + d] += side ? h : -h;
                    f[side] = objective_at(&mesh.mesh, &options);
                    g[side] = 1 - measure(&mesh.mesh, mesh.coordinates, element) / own[element];
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
        double length = moved(x, x + i * dim, dim);
        double weight = method == PLANISH_METHOD_LENGTH_LAPLACIAN ? length : 1;
        weights += weight;
        for (int d = 0; d < dim; d++)
            to[d] += weight * x[i * dim + d];
    }
    for (int64_t i = 0; i < mesh->n_elements && method == PLANISH_METHOD_AREA_LAPLACIAN; i++) {
        double weight = measure(mesh, x, i);
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
        smoothed s;
        double to[3];
        one_star(&mesh, dim);
        planish_options options = defaults();
        options.method = (planish_method)method;
        options.max_sweeps = 1;
        expected_mean(&mesh.mesh, options.method, to);
        smooth(&mesh.mesh, &options, &s);
        assert_int_equal(s.result.moved_nodes, 1);
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
    smoothed s;
    one_star(&mesh, 2);
    planish_options options = defaults();
    options.method = PLANISH_METHOD_LAPLACIAN;
    smooth(&mesh.mesh, &options, &s);
    assert_true(fabs(s.coordinates[0] - 0.25) < 1e-15 && fabs(s.coordinates[1] + 0.5) < 1e-15);
    assert_int_equal(s.result.stop, PLANISH_STOP_CONVERGED);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

static void averages_converge_on_convex_boxes(void **state) {
    int dim = *(int *)*state;
    for (int method = 1; method < 4; method++) {
        test_mesh mesh;
        smoothed s;
        bad_box(&mesh, dim, 5, 1);
        planish_options options = defaults();
        options.method = (planish_method)method;
        smooth(&mesh.mesh, &options, &s);
        assert_int_equal(s.result.stop, PLANISH_STOP_CONVERGED);
        assert_int_equal(s.after.inverted, 0);
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
    smoothed s;
    test_mesh_create(&mesh, 2, 7, corners, 6, triangles);
    planish_options options = defaults();
    options.method = PLANISH_METHOD_LAPLACIAN;
    smooth(&mesh.mesh, &options, &s);
    assert_int_equal(s.before.inverted, 0);
    assert_int_equal(s.after.inverted, 2);
    assert_true(fabs(s.coordinates[0] - 22.0 / 6) < 1e-14);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

/* ---- what is refused ----------------------------------------------------------------------- */

/** What is wrong, and a word of the message. */
typedef struct wrong {
    const char *word;
    void (*spoil)(planish_options *options);
} wrong;

#define SPOIL(name, statement)                                                                     \
    static void name(planish_options *options) {                                                   \
        options->statement;                                                                        \
    }
SPOIL(method_large, method = (planish_method)4)
SPOIL(method_small, method = (planish_method)-1)
SPOIL(objective_large, objective = (planish_objective)3)
SPOIL(objective_small, objective = (planish_objective)-1)
SPOIL(direction_large, direction = (planish_direction)2)
SPOIL(precision_large, precision = (planish_precision)3)
SPOIL(precision_without_round, precision = PLANISH_ROUNDED)
SPOIL(unit_large, displacement_unit = (planish_length_unit)2)
SPOIL(volume_negative, min_volume = -1)
SPOIL(volume_nan, min_volume = NAN)
SPOIL(volume_infinite, min_volume = INFINITY)
SPOIL(fraction_negative, min_volume_fraction = -0.1)
SPOIL(fraction_nan, min_volume_fraction = NAN)
SPOIL(fraction_one, min_volume_fraction = 1)
SPOIL(weight_negative, area_weight = -0.1)
SPOIL(weight_large, area_weight = 1.1)
SPOIL(weight_nan, area_weight = NAN)
SPOIL(weight_without_volume, area_weight = 0.5)
SPOIL(box_nan, box_lower[1] = NAN)
SPOIL(box_empty, box_upper[0] = -INFINITY; options->box_lower[0] = 0)
SPOIL(distance_negative, max_displacement = -1)
SPOIL(distance_nan, max_displacement = NAN)
SPOIL(distance_infinite, max_displacement = INFINITY)
SPOIL(both_volumes, min_volume = 0.1; options->min_volume_fraction = 0.1)
SPOIL(size_wrong, struct_size -= 1)

static void wrong_options_are_refused(void **state) {
    int dim = *(int *)*state;
    static const wrong all[] = {
        {"method", method_large},
        {"method", method_small},
        {"objective", objective_large},
        {"objective", objective_small},
        {"direction", direction_large},
        {"precision", precision_large},
        {"round", precision_without_round},
        {"unit", unit_large},
        {"min_volume", volume_negative},
        {"min_volume", volume_nan},
        {"min_volume", volume_infinite},
        {"fraction", fraction_negative},
        {"fraction", fraction_nan},
        {"fraction", fraction_one},
        {"area_weight", weight_negative},
        {"area_weight", weight_large},
        {"area_weight", weight_nan},
        {"minimum volume", weight_without_volume},
        {"box_lower", box_nan},
        {"box", box_empty},
        {"max_displacement", distance_negative},
        {"max_displacement", distance_nan},
        {"max_displacement", distance_infinite},
        {"both", both_volumes},
        {"struct_size", size_wrong},
    };
    test_mesh mesh;
    planish_plan *plan;
    bad_box(&mesh, dim, 3, 1);
    double *copy = malloc(bytes_of(&mesh.mesh));
    memcpy(copy, mesh.coordinates, bytes_of(&mesh.mesh));
    assert_int_equal(planish_plan_create(&mesh.mesh, NULL, &plan, NULL), 0);
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        planish_options options = defaults();
        planish_error error = {.text = ""};
        all[i].spoil(&options);
        assert_int_equal(planish_smooth(plan, copy, &options, NULL, &error),
                         PLANISH_ERROR_ARGUMENT);
        assert_int_equal(error.code, PLANISH_ERROR_ARGUMENT);
        assert_non_null(strstr(error.text, all[i].word));
        assert_memory_equal(copy, mesh.coordinates, bytes_of(&mesh.mesh));
    }
    planish_plan_destroy(plan);
    free(copy);
    test_mesh_destroy(&mesh);
}

static void bounds_that_are_no_numbers_are_refused(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    planish_plan *plan;
    planish_error error;
    bad_box(&mesh, dim, 3, 1);
    planish_options options = defaults();
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

/** Elements without a minimum volume cannot have a weight; the message says which. */
static void weights_need_volumes(void **state) {
    int dim = *(int *)*state;
    test_mesh mesh;
    planish_plan *plan;
    planish_error error;
    bad_box(&mesh, dim, 3, 1);
    double *own = malloc((size_t)mesh.mesh.n_elements * sizeof *own);
    for (int64_t i = 0; i < mesh.mesh.n_elements; i++)
        own[i] = i == 7 ? 0 : 0.1 * regular_volume(dim);
    mesh.mesh.min_volume = own;
    planish_options options = defaults();
    options.area_weight = 0.5;
    assert_int_equal(planish_plan_create(&mesh.mesh, NULL, &plan, NULL), 0);
    assert_int_equal(planish_smooth(plan, mesh.coordinates, &options, NULL, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(error.element, 7);
    options.min_volume = 0.1 * regular_volume(dim);
    assert_int_equal(planish_smooth(plan, mesh.coordinates, &options, NULL, &error), 0);
    planish_plan_destroy(plan);
    free(own);
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
        planish_options options = defaults();
        test_mesh_box(&mesh, dim, 3);
        test_mesh_perturb(&mesh, 1.2, 7);
        test_mesh_transform(&mesh, ldexp(1, exponents[k]), 0);
        options.max_displacement = ldexp(0.25, exponents[k]);
        double *x = malloc(bytes_of(&mesh.mesh)), farthest = 0;
        memcpy(x, mesh.coordinates, bytes_of(&mesh.mesh));
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
        moved[k] = result.moved_nodes;
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
    bad_box(&mesh, dim, 3, 1);
    planish_options options = defaults();
    bounded b = set_bounds(&mesh, ALL_BOUNDS, &options);
    options.min_volume = 1.5 * regular_volume(dim);
    double *copy = malloc(bytes_of(&mesh.mesh));
    /* A plan keeps the memory of its last call: each has its own. */
    for (int permitted = 0; status == PLANISH_ERROR_MEMORY; permitted++) {
        memcpy(copy, mesh.coordinates, bytes_of(&mesh.mesh));
        assert_int_equal(planish_plan_create(&mesh.mesh, &options, &plan, NULL), 0);
        allocations_permit(permitted);
        status = planish_smooth(plan, copy, &options, NULL, &error);
        allocations_permit(-1);
        planish_plan_destroy(plan);
        if (status == PLANISH_ERROR_MEMORY)
            assert_memory_equal(copy, mesh.coordinates, bytes_of(&mesh.mesh));
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
        status = planish_check_volumes(plan, mesh.coordinates, &options, below, &n_below, &error);
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
        smoothed s;
        planish_plan *plan;
        planish_options options = defaults();
        const int dim = 2 + i % 2;
        double unit = i % 4 < 2 ? 0.1 : 0.03;
        bad_box(&box, dim, 6, (unsigned)i);
        options.untangle = 0;
        options.min_volume = 0.95 * regular_volume(dim);
        options.precision = PLANISH_ROUNDED;
        options.round = to_multiple;
        options.round_user = &unit;
        smooth(&box.mesh, &options, &s);
        uint8_t *before = malloc((size_t)box.mesh.n_elements);
        uint8_t *after = malloc((size_t)box.mesh.n_elements);
        int64_t n;
        assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
        assert_int_equal(planish_check_volumes(plan, box.coordinates, &options, before, &n, NULL),
                         0);
        assert_int_equal(planish_check_volumes(plan, s.coordinates, &options, after, &n, NULL), 0);
        for (int64_t k = 0; k < box.mesh.n_elements; k++) {
            assert_true(before[k] != PLANISH_VOLUME_MET || after[k] == PLANISH_VOLUME_MET);
            kept += before[k] != PLANISH_VOLUME_MET;
        }
        moved += s.result.moved_nodes;
        planish_plan_destroy(plan);
        free(before);
        free(after);
        free(s.coordinates);
        test_mesh_destroy(&box);
    }
    assert_true(moved > 0 && kept > 0);
}

int main(void) {
    static int dims[] = {2, 3};
#define BOTH(test)                                                                                 \
    {#test " 2-D", test, NULL, NULL, &dims[0]}, {                                                  \
#test " 3-D", test, NULL, NULL, &dims[1]                                                   \
    }
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
        BOTH(bounds_are_kept),
        BOTH(bits_do_not_depend_on_threads_or_kernel),
        BOTH(powers_of_two_change_no_bit),
        BOTH(optimality_is_reported),
        BOTH(the_multiplier_is_that_of_f),
        BOTH(averages_are_those_that_they_are_called),
        cmocka_unit_test(the_plain_mean_is_known),
        BOTH(averages_converge_on_convex_boxes),
        cmocka_unit_test(averages_invert_at_reentrant_corners),
        BOTH(wrong_options_are_refused),
        BOTH(bounds_that_are_no_numbers_are_refused),
        BOTH(weights_need_volumes),
        BOTH(a_largest_displacement_holds_at_every_size),
        BOTH(without_memory_nothing_changes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
