#include "support/problems.h"

#include "support/meshes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

const char *const test_wish_names[WISHES] = {[WISH_PLAIN] = "plain",
                                             [WISH_CONJUGATE] = "conjugate",
                                             [WISH_MEAN_RATIO] = "mean ratio",
                                             [WISH_EDGE_RATIO] = "edge ratio",
                                             [WISH_TANGLED] = "tangled",
                                             [WISH_HOPELESS] = "hopeless",
                                             [WISH_TANGLED_SLIDING] = "tangled, sliding",
                                             [WISH_SLIDING] = "sliding",
                                             [WISH_WORST_RATIO] = "worst ratio",
                                             [WISH_WORST_ANGLE] = "worst angle",
                                             [WISH_LEAST_VOLUME] = "minimum volume",
                                             [WISH_OWN_VOLUMES] = "own volumes",
                                             [WISH_FRACTION] = "fraction",
                                             [WISH_BOUNDS] = "bounds",
                                             [WISH_DISPLACEMENT] = "displacement",
                                             [WISH_ONLY_WORSE] = "only worse",
                                             [WISH_AROUND] = "around",
                                             [WISH_PERIODIC] = "periodic",
                                             [WISH_FLOAT] = "float",
                                             [WISH_LAPLACIAN] = "Laplacian",
                                             [WISH_AREA_LAPLACIAN] = "area Laplacian",
                                             [WISH_LENGTH_LAPLACIAN] = "length Laplacian"};

/* Of an edge: boxes stay valid; and do not. */
#define MILD 0.14
#define WILD 1.1

static void *room(int64_t n, size_t size) {
    void *array = calloc((size_t)n + 1, size);
    assert_non_null(array);
    return array;
}

/* ---- making them ----------------------------------------------------------------------------- */

/** A push of node number at of n along axis d, in -1 .. 1: the same for nodes that are one where
 *  opposite sides of the box are. */
static double push(const double *at, int dim, int cells, int d, unsigned seed) {
    for (int k = 0; k < dim; k++)
        seed = seed * 31 + (unsigned)((int)at[k] % cells);
    seed = seed * 31 + (unsigned)d;
    for (int i = 0; i < 3; i++)
        test_random(&seed);
    return 2 * test_random(&seed) - 1;
}

/** Shake the nodes, those of the sides within them and so that they can stay (or alike), and
 *  pair those of the two sides across x. */
static void shake(test_problem *p, int cells, double amount, int sides_alike, unsigned seed) {
    const int dim = p->mesh.dim;
    const double of_sides = sides_alike ? amount : MILD;
    for (int64_t i = 0; i < p->mesh.n_nodes; i++) {
        double *x = p->coordinates + i * dim, at[3] = {0, 0, 0};
        int inside = 1;
        memcpy(at, x, (size_t)dim * sizeof *x);
        for (int d = 0; d < dim; d++)
            inside &= at[d] != 0 && at[d] != cells;
        if (at[0] == cells) {
            p->periodic[2 * p->mesh.n_periodic] = (int32_t)i;
            p->periodic[2 * p->mesh.n_periodic++ + 1] = (int32_t)(i - cells);
        }
        for (int d = 0; d < dim; d++)
            if (at[d] != 0 && at[d] != cells)
                x[d] +=
                    rint(0x1p20 * (inside ? amount : of_sides) * push(at, dim, cells, d, seed)) *
                    0x1p-20;
    }
}

static void allocate(test_problem *p, const test_mesh *box) {
    const int64_t n = box->mesh.n_nodes, m = box->mesh.n_elements;
    const int dim = box->mesh.dim;
    *p = (test_problem){.mesh = box->mesh,
                        .coordinates = box->coordinates,
                        .elements = box->elements,
                        .constraint = room(n, 1),
                        .direction = room(n * dim, sizeof(double)),
                        .periodic = room(n, 2 * sizeof(int32_t)),
                        .min_volume = room(m, sizeof(double)),
                        .lower = room(n * dim, sizeof(double)),
                        .upper = room(n * dim, sizeof(double)),
                        .around = room(2, sizeof(int64_t)),
                        .node_now = room(n, sizeof(int32_t)),
                        .element_now = room(m, sizeof(int32_t))};
    for (int64_t i = 0; i < n; i++)
        p->node_now[i] = (int32_t)i;
    for (int64_t i = 0; i < m; i++)
        p->element_now[i] = (int32_t)i;
}

static void let_slide(test_problem *p) {
    assert_int_equal(
        planish_find_slides(&p->mesh, NULL, 1, p->constraint, p->direction, NULL, NULL), 0);
    p->mesh.constraint = p->constraint;
    p->mesh.direction = p->direction;
}

static void bound(test_problem *p, int cells) {
    const int dim = p->mesh.dim;
    for (int64_t i = 0; i < p->mesh.n_nodes * dim; i++) {
        p->lower[i] = p->coordinates[i] - 0.0625;
        p->upper[i] = p->coordinates[i] + 0.125;
    }
    p->options.lower = p->lower;
    p->options.upper = p->upper;
    p->options.box_lower[0] = 1;
    p->options.box_upper[dim - 1] = cells - 0.75;
}

static void want_volumes(test_problem *p, test_wish wish) {
    const double volume = p->mesh.dim == 3 ? 1.0 / 6 : 0.5;
    if (wish == WISH_LEAST_VOLUME) {
        p->options.min_volume = 0.75 * volume;
        p->options.area_weight = 0.3;
    } else if (wish == WISH_FRACTION) {
        p->options.min_volume_fraction = 0.8 / (double)p->mesh.n_elements;
    } else {
        for (int64_t i = 0; i < p->mesh.n_elements; i++)
            p->min_volume[i] = (double)(i % 4) * 0.3 * volume;
        p->mesh.min_volume = p->min_volume;
    }
}

static void ask(test_problem *p, int cells, test_wish wish) {
    planish_options *options = &p->options;
    planish_options_init(options);
    options->threads = 1;
    if (wish == WISH_CONJUGATE)
        options->search = PLANISH_SEARCH_FLETCHER_REEVES;
    if (wish == WISH_MEAN_RATIO || wish == WISH_EDGE_RATIO)
        options->objective =
            wish == WISH_MEAN_RATIO ? PLANISH_OBJECTIVE_MEAN_RATIO : PLANISH_OBJECTIVE_EDGE_RATIO;
    if (wish == WISH_WORST_RATIO || wish == WISH_WORST_ANGLE)
        options->worst =
            wish == WISH_WORST_RATIO ? PLANISH_WORST_RADIUS_RATIO : PLANISH_WORST_ANGLE;
    if (wish == WISH_SLIDING || wish == WISH_TANGLED_SLIDING || wish == WISH_PERIODIC)
        let_slide(p);
    if (wish == WISH_LEAST_VOLUME || wish == WISH_OWN_VOLUMES || wish == WISH_FRACTION)
        want_volumes(p, wish);
    if (wish == WISH_BOUNDS)
        bound(p, cells);
    if (wish == WISH_DISPLACEMENT)
        options->max_displacement = 0.09375;
    if (wish == WISH_ONLY_WORSE)
        options->only_worse_than = p->mesh.dim == 3 ? 1.5 : 1.25;
    if (wish == WISH_AROUND) {
        p->around[0] = p->mesh.n_nodes / 2;
        p->around[1] = p->mesh.n_nodes / 2 + 1;
        options->around = p->around;
        options->n_around = 2;
        options->rings = 1;
    }
    if (wish == WISH_FLOAT)
        options->precision = PLANISH_PRECISION_FLOAT;
    if (wish >= WISH_LAPLACIAN) {
        options->method = (planish_method)(PLANISH_METHOD_LAPLACIAN + (wish - WISH_LAPLACIAN));
        options->max_sweeps = 5;
    }
}

void test_problem_create(test_problem *p, int dim, int cells, test_wish wish, unsigned seed) {
    test_mesh box;
    const int is_tangled = wish >= WISH_TANGLED && wish <= WISH_TANGLED_SLIDING;
    test_mesh_box(&box, dim, cells);
    allocate(p, &box);
    shake(p, cells, is_tangled ? WILD : MILD, wish == WISH_HOPELESS, seed);
    p->mesh.periodic = p->periodic;
    if (wish != WISH_PERIODIC)
        p->mesh.n_periodic = 0;
    ask(p, cells, wish);
}

void test_problem_destroy(test_problem *p) {
    void *const arrays[] = {p->coordinates, p->elements,   p->constraint, p->direction,
                            p->periodic,    p->min_volume, p->lower,      p->upper,
                            p->around,      p->node_now,   p->element_now};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        free(arrays[i]);
    *p = (test_problem){0};
}

/* ---- solving them ---------------------------------------------------------------------------- */

static void expect(int status, const planish_error *error) {
    if (status)
        fail_msg("%s", error->text);
}

/** By the numbers that elements were made with. */
static double *ratios(const test_problem *p, const planish_plan *plan, const double *x) {
    planish_error error;
    double *now = room(p->mesh.n_elements, sizeof *now);
    double *made = room(p->mesh.n_elements, sizeof *made);
    expect(planish_measure_elements(plan, x, now, &error), &error);
    for (int64_t i = 0; i < p->mesh.n_elements; i++)
        made[i] = now[p->element_now[i]];
    free(now);
    return made;
}

test_outcome test_problem_solve(const test_problem *p) {
    const int dim = p->mesh.dim;
    const int64_t n = p->mesh.n_nodes;
    planish_plan *plan;
    planish_error error;
    test_outcome o = {.coordinates = room(n * dim, sizeof(double))};
    double *x = room(n * dim, sizeof *x);
    memcpy(x, p->coordinates, (size_t)(n * dim) * sizeof *x);
    expect(planish_plan_create(&p->mesh, &p->options, &plan, &error), &error);
    planish_plan_get_info(plan, &o.info);
    expect(planish_measure(plan, x, &o.before, &error), &error);
    o.ratio_before = ratios(p, plan, x);
    expect(planish_find_infeasible(plan, x, NULL, NULL, &o.unfixable, NULL, &error), &error);
    expect(planish_smooth(plan, x, &p->options, &o.result, &error), &error);
    expect(planish_measure(plan, x, &o.after, &error), &error);
    o.ratio = ratios(p, plan, x);
    expect(planish_check_volumes(plan, x, &p->options, NULL, &o.below, NULL, &error), &error);
    planish_plan_destroy(plan);
    for (int64_t i = 0; i < n; i++)
        memcpy(o.coordinates + i * dim, x + p->node_now[i] * dim, (size_t)dim * sizeof *x);
    free(x);
    return o;
}

void test_outcome_destroy(test_outcome *o) {
    free(o->coordinates);
    free(o->ratio_before);
    free(o->ratio);
    *o = (test_outcome){0};
}
