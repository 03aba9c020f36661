/* Curved surfaces: random small bodies are smoothed on the shape of their surface, and judged by
 * samples and brute force. PLANISH_CASE=NUMBER does one case alone. */
#include "support/bodies.h"
#include "support/effort.h"
#include "support/run.h"
#include "support/sheets.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { DIVISIONS = 4 };

/* ---- a case --------------------------------------------------------------------------------- */

/** A body, its shape, and what was asked for. */
typedef struct trial {
    int64_t number;
    body body;
    planish_shape *shape;
    planish_surface surface;
    uint8_t *constraint;
    double *direction;
    planish_options options;
    int n_runs;   /* in a row, from the result of the one before */
    double *x[3]; /* results of 1, 2 and 3 threads */
    sheet_judge first, now;
    const char *asks;
} trial;

static void check_that(const trial *t, int condition, const char *promise) {
    if (!condition)
        fail_msg("PLANISH_CASE=%lld: %s (kind %d of %d, %s)", (long long)t->number, promise,
                 t->body.kind, t->body.of, t->asks);
}

/** Draw options. */
static void draw_options(trial *t, uint64_t *state) {
    static const planish_worst WORST[2][2] = {
        {PLANISH_WORST_RADIUS_RATIO, PLANISH_WORST_ANGLE},
        {PLANISH_WORST_ASPECT_RATIO, PLANISH_WORST_SCALED_JACOBIAN}};
    const int of_cells = t->body.of != OF_TETRAHEDRA;
    planish_options *o = &t->options;
    planish_options_init(o);
    o->shape = t->shape;
    t->asks = "defaults";
    switch (random_below(state, 12)) {
    case 0:
        o->surface_tolerance = 0.01;
        o->surface_tolerance_unit = PLANISH_UNIT_EDGE;
        t->asks = "0.01 edges";
        break;
    case 1:
        o->surface_tolerance = 0.3;
        o->surface_tolerance_unit = PLANISH_UNIT_EDGE;
        t->asks = "0.3 edges";
        break;
    case 2:
        o->surface_tolerance = 0.02 * t->shape->size / t->shape->scale;
        t->asks = "an absolute tolerance";
        break;
    case 3:
        o->objective = of_cells ? o->objective : PLANISH_OBJECTIVE_MEAN_RATIO;
        t->asks = "mean ratios";
        break;
    case 4:
        o->objective = of_cells ? o->objective : PLANISH_OBJECTIVE_EDGE_RATIO;
        t->asks = "edge ratios";
        break;
    case 5:
        o->precision = PLANISH_PRECISION_FLOAT;
        t->asks = "floats";
        break;
    case 6:
        o->worst = WORST[of_cells][random_below(state, 2)];
        t->asks = "the worst";
        break;
    case 7:
        o->max_displacement = 0.2;
        o->displacement_unit = PLANISH_UNIT_EDGE;
        t->asks = "bounds";
        break;
    case 8:
        o->only_worse_than = 1.5;
        t->asks = "the worse ones only";
        break;
    case 9:
        o->max_sweeps = 2;
        t->asks = "two sweeps";
        break;
    default:
        break;
    }
}

/** Check that nodes stay from before to x that were said to; held: of before. */
static void check_held(const trial *t, const uint8_t *held, const double *before, const double *x) {
    for (int64_t i = 0; i < t->body.mesh.n_nodes; i++)
        if (held[i])
            check_that(t, !memcmp(x + 3 * i, before + 3 * i, 3 * sizeof *x),
                       "what is held from the start stays");
}

static void smooth(trial *t, int threads, double *x) {
    planish_plan *plan;
    planish_result result;
    planish_error error = {.text = ""};
    planish_mesh mesh = t->body.mesh;
    mesh.constraint = t->constraint;
    mesh.direction = t->direction;
    planish_options options = t->options;
    options.threads = threads;
    memcpy(x, t->body.x, (size_t)mesh.n_nodes * 3 * sizeof *x);
    mesh.coordinates = x;
    uint8_t *held = malloc((size_t)mesh.n_nodes);
    for (int i = 0; i < t->n_runs; i++) {
        double *before = test_copy_of(&mesh);
        if (planish_plan_create(&mesh, &options, &plan, &error) ||
            planish_find_held(plan, x, &options, held, &error) ||
            planish_smooth(plan, x, &options, &result, &error))
            check_that(t, 0, error.text);
        planish_plan_destroy(plan);
        check_held(t, held, before, x);
        free(before);
    }
    free(held);
}

static double (*scaled(const trial *t, const double *x))[3] {
    const planish_shape *s = t->shape;
    double(*own)[3] = malloc((size_t)s->n_nodes * sizeof *own);
    for (int64_t i = 0; i < s->n_nodes; i++)
        for (int d = 0; d < 3; d++)
            own[i][d] = x[3 * s->node[i] + d] * s->scale;
    return own;
}

/** Smooth the body of a case. tolerance: in edges; 0: it and all else is drawn. */
static void prepare(trial *t, int64_t number, double tolerance) {
    uint64_t state = effort_seed((uint64_t)number + 1000);
    planish_error error = {.text = ""};
    planish_slide_info info;
    *t = (trial){.number = number, .body = body_create(&state)};
    if (t->body.of != OF_TETRAHEDRA)
        t->body.mesh.cells = &t->body.cells;
    const planish_mesh *mesh = &t->body.mesh;
    t->surface.region = t->body.region;
    t->surface.slide_interfaces = (int)random_below(&state, 2);
    t->surface.crease_angle = random_below(&state, 4) ? 0 : 30;
    t->asks = "the shape";
    if (planish_shape_create(mesh, &t->surface, 1, &t->shape, NULL, &error))
        check_that(t, 0, error.text);
    t->surface.shape = t->shape;
    t->constraint = malloc((size_t)mesh->n_nodes);
    t->direction = malloc((size_t)mesh->n_nodes * 3 * sizeof *t->direction);
    if (planish_find_slides(mesh, &t->surface, 1, t->constraint, t->direction, &info, &error))
        check_that(t, 0, error.text);
    draw_options(t, &state);
    if (tolerance > 0) {
        planish_options_init(&t->options);
        t->options.shape = t->shape;
        t->options.surface_tolerance = tolerance;
        t->options.surface_tolerance_unit = PLANISH_UNIT_EDGE;
        t->asks = "a tolerance";
    }
    t->n_runs = 1 + (int)random_below(&state, 2);
    for (int i = 0; i < 3; i++) {
        t->x[i] = test_copy_of(mesh);
        smooth(t, i + 1, t->x[i]);
    }
    double(*now)[3] = scaled(t, t->x[0]);
    t->first = sheet_judge_create(t->shape, (const double(*)[3])t->shape->x);
    t->now = sheet_judge_create(t->shape, (const double(*)[3])now);
    free(now);
}

static void finish(trial *t) {
    for (int i = 0; i < 3; i++)
        free(t->x[i]);
    sheet_judge_destroy(&t->first);
    sheet_judge_destroy(&t->now);
    planish_shape_destroy(t->shape);
    free(t->constraint);
    free(t->direction);
    body_destroy(&t->body);
}

/* ---- promises ------------------------------------------------------------------------------- */

/** Moved coordinates are floats, if that is asked for. */
static void check_floats(const trial *t) {
    for (int64_t i = 0; t->options.precision && i < 3 * t->body.mesh.n_nodes; i++) {
        const volatile float narrow = (float)t->x[0][i];
        check_that(t, t->x[0][i] == (double)narrow || t->x[0][i] == t->body.x[i],
                   "moved coordinates are floats");
    }
}

/** Valid elements stay valid, and nodes that are held stay. Returns how many nodes moved. */
static int64_t check_mesh(const trial *t) {
    const planish_mesh *mesh = &t->body.mesh;
    const size_t bytes = (size_t)mesh->n_nodes * 3 * sizeof(double);
    int64_t n = 0;
    int was_valid = 1;
    check_that(t, !memcmp(t->x[0], t->x[1], bytes), "2 threads give the bits of 1");
    check_that(t, !memcmp(t->x[0], t->x[2], bytes), "3 threads give the bits of 1");
    for (int64_t e = 0; e < mesh->n_elements; e++)
        was_valid &= body_least_corner(&t->body, t->body.x, e) > 0;
    for (int64_t e = 0; was_valid && e < mesh->n_elements; e++)
        check_that(t, body_least_corner(&t->body, t->x[0], e) > 0, "no element is inverted");
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        const int has_moved = memcmp(t->x[0] + 3 * i, t->body.x + 3 * i, 3 * sizeof(double)) != 0;
        n += has_moved && t->shape->number[i] >= 0;
        check_that(t, !has_moved || t->constraint[i] != PLANISH_CONSTRAINT_FIXED,
                   "held nodes stay");
    }
    return n;
}

/** The tolerance of a facet, in the shape's units. */
static double tolerance_of(const trial *t, int32_t facet) {
    const planish_options *o = &t->options;
    if (o->surface_tolerance > 0 && o->surface_tolerance_unit == PLANISH_UNIT_MESH)
        return o->surface_tolerance * t->shape->scale;
    double mean = 0;
    for (int k = 0; k < 3; k++)
        mean += pl_distance(3, t->first.corner[facet][k], t->first.corner[facet][(k + 1) % 3]) / 3;
    return (o->surface_tolerance > 0 ? o->surface_tolerance : 0.05) * mean;
}

static planish_shape_distance measure(const trial *t) {
    planish_mesh mesh = t->body.mesh;
    planish_shape_distance d;
    planish_error error = {.text = ""};
    mesh.coordinates = t->x[0];
    if (planish_shape_measure(t->shape, &mesh, 1, &d, &error))
        check_that(t, 0, error.text);
    return d;
}

/** Whether the whole surface is proved to be within the tolerance. */
static int is_proved(const trial *t, const planish_shape_distance *d, double rounding) {
    const planish_options *o = &t->options;
    const double tolerance = o->surface_tolerance > 0 ? o->surface_tolerance : 0.05;
    return o->surface_tolerance > 0 && o->surface_tolerance_unit == PLANISH_UNIT_MESH
               ? d->distance * t->shape->scale <= tolerance * t->shape->scale + rounding
               : d->in_edges <= tolerance * (1 + 1e-9) + (o->precision ? 1e-5 : 1e-9);
}

/** No point of the surface is farther off than the tolerance, and than what was proved. */
static void check_distance(const trial *t, double *worth) {
    const planish_shape *s = t->shape;
    const planish_shape_distance d = measure(t);
    const double rounding = (t->options.precision ? 2e-7 : 1e-12) * s->size;
    double there = 0, back = 0;
    for (int32_t f = 0; f < s->n_facets; f++) {
        const double now = sheet_judge_sample(&t->first, s->patch[f],
                                              (const double(*)[3])t->now.corner[f], DIVISIONS);
        const double was = sheet_judge_sample(&t->now, s->patch[f],
                                              (const double(*)[3])t->first.corner[f], DIVISIONS);
        check_that(t, now <= tolerance_of(t, f) * (1 + 1e-9) + rounding,
                   "no sample is beyond the tolerance");
        there = fmax(there, now);
        back = fmax(back, was);
    }
    check_that(t, there <= d.distance * s->scale * (1 + 1e-9) + rounding,
               "the measure holds there");
    check_that(t, back <= d.distance_back * s->scale * (1 + 1e-9) + rounding,
               "the measure holds back");
    check_that(t, d.n_unproved == 0, "every facet has a bound");
    check_that(t, is_proved(t, &d, rounding), "the surface is proved to be within the tolerance");
    check_that(t, d.max_bend <= fmax(40, d.max_bend_before) + 1e-5, "no smooth edge becomes sharp");
    *worth = there > 1e-6 * s->size ? d.distance * s->scale / there : 0;
}

/** No facet turns over, and features stay where they are. */
static void check_features(const trial *t) {
    const planish_shape *s = t->shape;
    double(*now)[3] = scaled(t, t->x[0]);
    for (int32_t f = 0; f < s->n_facets; f++) {
        double u[3], v[3], normal[3], first[3];
        pl_facet_normal(s, f, first);
        pl_subtract(3, t->now.corner[f][1], t->now.corner[f][0], u);
        pl_subtract(3, t->now.corner[f][2], t->now.corner[f][0], v);
        pl_cross(u, v, normal);
        check_that(t, pl_dot(3, normal, first) >= 0.5 * pl_length(normal) * (1 - 1e-6),
                   "no facet turns over");
    }
    for (int64_t e = 0; e < s->n_edges; e++)
        for (int i = 0; i <= DIVISIONS; i++) {
            double p[3], least = INFINITY;
            for (int d = 0; d < 3; d++)
                p[d] = (i * now[s->edge[e][0]][d] + (DIVISIONS - i) * now[s->edge[e][1]][d]) /
                       DIVISIONS;
            for (int64_t other = 0; other < s->n_edges; other++)
                least = fmin(
                    least, sheet_from_segment(s->x[s->edge[other][0]], s->x[s->edge[other][1]], p));
            double most = 0;
            for (int j = 0; j < 2; j++)
                if (s->edge_facet[e][j] >= 0)
                    most = fmax(most, tolerance_of(t, s->edge_facet[e][j]));
            check_that(t, least <= most * (1 + 1e-9) + 2e-7 * s->size,
                       "features stay within the tolerance");
        }
    free(now);
}

/** How many pairs of facets cross. */
static int64_t count_crossings(const planish_shape *s, const sheet_judge *judge) {
    int64_t n = 0;
    for (int64_t a = 0; a < judge->n; a++)
        for (int64_t b = 0; b < a; b++)
            n += sheet_cross(judge, s, a, b);
    return n;
}

/** A surface that does not cross itself does not come to: neither two sheets across a gap, nor one that
 *  folds. */
static void check_crossings(const trial *t) {
    if (count_crossings(t->shape, &t->now) > 0)
        check_that(t, count_crossings(t->shape, &t->first) > 0, "no facets come to cross");
}

static void bodies_keep_their_shape(void **unused) {
    (void)unused;
    const char *one = getenv("PLANISH_CASE");
    const int64_t n = one ? 1 : effort(100, 10000);
    int64_t n_moved = 0, n_bodies = 0;
    double sum = 0, n_worth = 0;
    for (int64_t i = 0; i < n; i++) {
        trial t;
        double worth;
        prepare(&t, one ? strtoll(one, NULL, 10) : i, 0);
        const int64_t moved = check_mesh(&t);
        check_floats(&t);
        check_distance(&t, &worth);
        check_features(&t);
        check_crossings(&t);
        n_moved += moved;
        n_bodies += moved > 0;
        sum += worth;
        n_worth += worth > 0;
        finish(&t);
    }
    figure(
        "%lld bodies on curved surfaces: %lld nodes moved in %lld of them, proved / sampled %.3f",
        (long long)n, (long long)n_moved, (long long)n_bodies, n_worth > 0 ? sum / n_worth : 1);
    assert_true(one || 2 * n_bodies > n);
}

/** The last proof says no more than the tolerance, however small that is. */
/** Smooth a node of the surface of a case alone, to x: by a plan of its surroundings, or of the whole mesh, in which
 *  all others are fixed. */
static void smooth_one(const trial *t, int64_t node, int in_part, double *x) {
    planish_plan *plan;
    planish_error error = {.text = ""};
    planish_mesh mesh = t->body.mesh;
    uint8_t *constraint = calloc((size_t)mesh.n_nodes, 1);
    planish_options options;
    planish_options_init(&options);
    options.shape = t->shape;
    options.max_sweeps = 1;
    options.around = in_part ? &node : NULL;
    options.n_around = in_part;
    memset(constraint, PLANISH_CONSTRAINT_FIXED, (size_t)mesh.n_nodes);
    constraint[node] = t->constraint[node];
    mesh.constraint = in_part ? t->constraint : constraint;
    mesh.direction = t->direction;
    memcpy(x, t->body.x, (size_t)mesh.n_nodes * 3 * sizeof *x);
    if (planish_plan_create(&mesh, &options, &plan, &error) ||
        planish_smooth(plan, x, &options, NULL, &error))
        check_that(t, 0, error.text);
    planish_plan_destroy(plan);
    free(constraint);
}

/** A plan of a part knows where the surface around it is: its nodes go where they go if all others are fixed. */
static void parts_know_the_surface_around_them(void **unused) {
    (void)unused;
    int64_t n_moved = 0;
    for (int64_t i = 0; i < 30; i++) {
        trial t;
        prepare(&t, i, 0.3);
        for (int64_t node = 0; node < t.body.mesh.n_nodes; node++) {
            if (t.constraint[node] != PLANISH_CONSTRAINT_ON_PATCH)
                continue;
            smooth_one(&t, node, 0, t.x[0]);
            smooth_one(&t, node, 1, t.x[1]);
            for (int d = 0; d < 3; d++)
                check_that(&t, fabs(t.x[0][3 * node + d] - t.x[1][3 * node + d]) <= 1e-9,
                           "a part has the places of the whole mesh");
            n_moved += memcmp(t.x[1] + 3 * node, t.body.x + 3 * node, 3 * sizeof(double)) != 0;
            break;
        }
        finish(&t);
    }
    assert_true(n_moved > 10);
}

static void tolerances_are_proved(void **unused) {
    (void)unused;
    static const double TOLERANCES[] = {0.05, 0.01, 0.005, 0.002};
    int64_t n = 0;
    for (int64_t i = 0; i < effort(16, 400); i++)
        for (size_t k = 0; k < sizeof TOLERANCES / sizeof *TOLERANCES; k++) {
            trial t;
            double worth;
            prepare(&t, i, TOLERANCES[k]);
            n += check_mesh(&t);
            check_distance(&t, &worth);
            finish(&t);
        }
    assert_true(n > 0);
}

/* ---- surfaces in space ---------------------------------------------------------------------- */

/** Largest radius ratio of the facets at x that have a node that is not a corner. */
static double worst_facet(const planish_shape *s, const double (*x)[3]) {
    double worst = 0;
    for (int64_t f = 0; f < s->n_facets; f++) {
        const int32_t *node = s->facet[f];
        double u[3], v[3], normal[3], side[3];
        int moves = 0;
        for (int k = 0; k < 3; k++) {
            side[k] = pl_distance(3, x[node[k]], x[node[(k + 1) % 3]]);
            moves |= s->node_class[node[k]] != PL_CORNER;
        }
        pl_subtract(3, x[node[1]], x[node[0]], u);
        pl_subtract(3, x[node[2]], x[node[0]], v);
        pl_cross(u, v, normal);
        if (moves)
            worst = fmax(worst, side[0] * side[1] * side[2] * (side[0] + side[1] + side[2]) /
                                    (4 * pl_dot(3, normal, normal)));
    }
    return worst;
}

/** Join the triangles a and b, one after the other, to a quadrilateral. Returns 0 if they share no edge, or are
 *  turned against each other. */
static int join(const int32_t *a, const int32_t *b, int32_t *quadrilateral) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            if (a[(i + 1) % 3] == b[(j + 2) % 3] && a[(i + 2) % 3] == b[(j + 1) % 3]) {
                const int32_t joined[] = {a[i], a[(i + 1) % 3], b[j], a[(i + 2) % 3]};
                memcpy(quadrilateral, joined, sizeof joined);
                return 1;
            }
    return 0;
}

/** Join three quarters of the pairs of triangles that follow each other; arrays have room for all. Returns how many
 *  cells there are then. */
static int64_t join_pairs(int64_t n, uint8_t *type, int64_t *offset, int32_t *node,
                          uint64_t *state) {
    int64_t cells = 0, at = 0;
    for (int64_t f = 0; f < n; f++) {
        int32_t own[4] = {node[3 * f], node[3 * f + 1], node[3 * f + 2]};
        const int is_joined =
            f + 1 < n && random_below(state, 4) && join(node + 3 * f, node + 3 * f + 3, own);
        f += is_joined;
        memcpy(node + at, own, (size_t)(3 + is_joined) * sizeof *node);
        type[cells] = is_joined ? PLANISH_CELL_QUADRILATERAL : PLANISH_CELL_TRIANGLE;
        offset[cells++] = at;
        at += 3 + is_joined;
    }
    offset[cells] = at;
    return cells;
}

/** Smooth the sheet of a case, which becomes the trial's surface: half of them have quadrilaterals. */
static void prepare_sheet(trial *t, int64_t number) {
    uint64_t state = effort_seed((uint64_t)number + 500000);
    planish_error error = {.text = ""};
    *t = (trial){.number = number};
    t->body.kind = (int)(number % SHEET_KINDS);
    t->shape = sheet_create(t->body.kind, &state);
    const planish_shape *s = t->shape;
    uint8_t *type = malloc((size_t)s->n_facets);
    int64_t *offset = malloc((size_t)(s->n_facets + 1) * sizeof *offset);
    int32_t *node = malloc((size_t)s->n_facets * 3 * sizeof *node);
    double *given = malloc((size_t)s->n_mesh * 3 * sizeof *given);
    for (int64_t f = 0; f <= s->n_facets; f++)
        offset[f] = 3 * f;
    for (int64_t i = 0; i < 3 * s->n_facets; i++) {
        type[i / 3] = PLANISH_CELL_TRIANGLE;
        node[i] = s->node[s->facet[i / 3][i % 3]];
    }
    memset(given, 0, (size_t)s->n_mesh * 3 * sizeof *given);
    for (int64_t i = 0; i < s->n_nodes; i++)
        for (int d = 0; d < 3; d++)
            given[3 * s->node[i] + d] = s->x[i][d] / s->scale;
    planish_cells cells = {.n = s->n_facets, .type = type, .offset = offset, .node = node};
    t->body.mesh = (planish_mesh){.dim = 3,
                                  .n_nodes = s->n_mesh,
                                  .n_elements = s->n_facets,
                                  .coordinates = given,
                                  .cells = &cells};
    if (number / SHEET_KINDS % 2) {
        t->body.of = OF_HEXAHEDRA; /* other elements than simplices */
        t->body.mesh.n_elements = cells.n = join_pairs(cells.n, type, offset, node, &state);
        planish_shape_destroy(t->shape);
        if (planish_shape_create(&t->body.mesh, NULL, 1, &t->shape, NULL, &error))
            check_that(t, 0, error.text);
        s = t->shape;
    }
    t->surface.shape = t->shape;
    t->constraint = malloc((size_t)s->n_mesh);
    t->direction = malloc((size_t)s->n_mesh * 3 * sizeof *t->direction);
    if (random_below(&state, 2)) { /* planes and lines first */
        if (planish_find_slides(&t->body.mesh, &t->surface, 1, t->constraint, t->direction, NULL,
                                &error))
            check_that(t, 0, error.text);
        t->body.mesh.constraint = t->constraint;
        t->body.mesh.direction = t->direction;
    }
    draw_options(t, &state);
    if (t->options.objective == PLANISH_OBJECTIVE_EDGE_RATIO)
        t->options.objective = PLANISH_OBJECTIVE_RADIUS_RATIO;
    uint8_t *held = malloc((size_t)s->n_mesh);
    for (int i = 0; i < 3; i++) {
        planish_result result;
        t->x[i] = test_copy_of(&t->body.mesh);
        t->options.threads = i + 1;
        if (planish_find_held_on_surface(&t->body.mesh, &t->options, held, &error) ||
            planish_smooth_surface(&t->body.mesh, t->x[i], &t->options, &result, &error))
            check_that(t, 0, error.text);
        check_held(t, held, given, t->x[i]);
    }
    free(held);
    double(*now)[3] = scaled(t, t->x[0]);
    t->first = sheet_judge_create(s, (const double(*)[3])s->x);
    t->now = sheet_judge_create(s, (const double(*)[3])now);
    if (t->options.objective == PLANISH_OBJECTIVE_RADIUS_RATIO && !t->options.precision &&
        t->body.of == OF_TETRAHEDRA)
        check_that(t,
                   worst_facet(s, (const double(*)[3])now) <=
                       worst_facet(s, (const double(*)[3])s->x) * (1 + 1e-9),
                   "the worst facet does not become worse");
    free(now);
    free(type);
    free(offset);
    free(node);
    t->body.mesh.cells = NULL;
    t->body.x = given;
}

static int64_t check_sheet(const trial *t) {
    const planish_shape *s = t->shape;
    const size_t bytes = (size_t)s->n_mesh * 3 * sizeof(double);
    int64_t n = 0;
    check_that(t, !memcmp(t->x[0], t->x[1], bytes), "2 threads give the bits of 1");
    check_that(t, !memcmp(t->x[0], t->x[2], bytes), "3 threads give the bits of 1");
    for (int64_t i = 0; i < s->n_nodes; i++) {
        const int64_t at = 3 * (int64_t)s->node[i];
        const int has_moved = memcmp(t->x[0] + at, t->body.x + at, 3 * sizeof(double)) != 0;
        n += has_moved;
        check_that(t, !has_moved || s->node_class[i] != PL_CORNER, "corners stay");
    }
    return n;
}

static void sheets_keep_their_shape(void **unused) {
    (void)unused;
    const char *one = getenv("PLANISH_CASE");
    const int64_t n = one ? 1 : effort(100, 10000);
    int64_t n_moved = 0;
    for (int64_t i = 0; i < n; i++) {
        trial t;
        double worth;
        prepare_sheet(&t, one ? strtoll(one, NULL, 10) : i);
        n_moved += check_sheet(&t);
        check_floats(&t);
        check_distance(&t, &worth);
        check_features(&t);
        check_crossings(&t);
        finish(&t);
    }
    figure("%lld sheets smoothed in space: %lld nodes moved", (long long)n, (long long)n_moved);
    assert_true(one || n_moved > 10 * n);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bodies_keep_their_shape),
        cmocka_unit_test(parts_know_the_surface_around_them),
        cmocka_unit_test(tolerances_are_proved),
        cmocka_unit_test(sheets_keep_their_shape),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
