/* Curved surfaces of second order: random small bodies of quadratic tetrahedra are smoothed on the shape
 * of their surface, and judged by samples of their curved facets. PLANISH_CASE=NUMBER does one case
 * alone. */
#include "support/effort.h"
#include "support/run.h"
#include "support/sheets.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { MOST = 7, MOST_CORNERS = MOST * MOST * MOST, MOST_NODES = 9 * MOST_CORNERS };
enum { FINE = 5, SAMPLES = 4, RUNS = 4 };

/* ---- bodies --------------------------------------------------------------------------------- */

enum { BODY_BALL, BODY_ROD, BODY_BUMPS, BODY_CREASE, BODY_KINDS };

/** A grid of cubes, each of six quadratic tetrahedra. */
typedef struct body {
    int kind, n[3];
    double wave[4];
    double (*grid)[3]; /* [n_nodes] places in the grid, and in space */
    double *x;
    int32_t (*edge)[2]; /* [n_nodes] corners of each mid */
    int32_t *node;      /* [n_cells][10] */
    int64_t *offset;
    uint8_t *type;
    planish_cells cells;
    planish_mesh mesh;
    int32_t n_corners;
} body;

static int32_t corner_at(const body *b, int i, int j, int k) {
    return (int32_t)((i * (b->n[1] + 1) + j) * (b->n[2] + 1) + k);
}

/** The mid between two corners, new or not. */
static int32_t mid_of(body *b, int32_t p, int32_t q) {
    const int32_t low = p < q ? p : q, high = p < q ? q : p;
    for (int32_t i = b->n_corners; i < b->mesh.n_nodes; i++)
        if (b->edge[i][0] == low && b->edge[i][1] == high)
            return i;
    const int32_t mid = (int32_t)b->mesh.n_nodes++;
    b->edge[mid][0] = low;
    b->edge[mid][1] = high;
    for (int d = 0; d < 3; d++)
        b->grid[mid][d] = 0.5 * (b->grid[p][d] + b->grid[q][d]);
    return mid;
}

/** Add the tetrahedra of a cube: along its diagonal, one for each order of the directions. */
static void add_cube(body *b, int i, int j, int k) {
    static const int ORDER[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                    {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    static const int ENDS[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
    for (int t = 0; t < 6; t++) {
        int at[3] = {i, j, k};
        int32_t *node = b->node + 10 * b->cells.n;
        node[0] = corner_at(b, i, j, k);
        for (int step = 0; step < 3; step++) {
            at[ORDER[t][step]]++;
            node[step + 1] = corner_at(b, at[0], at[1], at[2]);
        }
        if (t >= 3) {
            const int32_t last = node[3];
            node[3] = node[2];
            node[2] = last;
        }
        for (int e = 0; e < 6; e++)
            node[4 + e] = mid_of(b, node[ENDS[e][0]], node[ENDS[e][1]]);
        b->type[b->cells.n] = PLANISH_CELL_TETRAHEDRON10;
        b->cells.n++;
        b->offset[b->cells.n] = 10 * b->cells.n;
    }
}

/** Take a place in the grid to its place in space. */
static void to_space(const body *b, const double g[3], double x[3]) {
    double u[3], s[3];
    for (int d = 0; d < 3; d++) {
        u[d] = 2 * g[d] / b->n[d] - 1;
        s[d] = u[d] * u[d];
    }
    memcpy(x, g, 3 * sizeof *x);
    if (b->kind == BODY_BALL) {
        for (int d = 0; d < 3; d++) {
            const double p = s[(d + 1) % 3], q = s[(d + 2) % 3];
            x[d] = b->n[d] / 2. * u[d] * sqrt(1 - p / 2 - q / 2 + p * q / 3);
        }
    } else if (b->kind == BODY_ROD) {
        const double a = 0.25 * g[0], r = 5 + u[1] * sqrt(1 - s[2] / 2);
        x[0] = r * cos(a);
        x[1] = r * sin(a);
        x[2] = u[2] * sqrt(1 - s[1] / 2);
    } else if (b->kind == BODY_BUMPS) {
        x[2] += g[2] / b->n[2] * b->wave[0] * sin(b->wave[1] * g[0]) * cos(b->wave[2] * g[1]);
    } else { /* a roof of two hollow sides */
        const double far = fabs(g[0] - b->n[0] / 2);
        x[2] += g[2] / b->n[2] * b->wave[3] * (far + 0.1 * far * far);
    }
}

static body make_body(uint64_t *state) {
    body b = {.kind = (int)random_below(state, BODY_KINDS)};
    const double amount = random_between(state, 0, 0.3);
    for (int d = 0; d < 3; d++)
        b.n[d] = b.kind == BODY_BALL ? 4 : 2 + (int)random_below(state, 3);
    for (int i = 0; i < 4; i++)
        b.wave[i] = random_between(state, 0.1, 0.6);
    b.n_corners = (b.n[0] + 1) * (b.n[1] + 1) * (b.n[2] + 1);
    b.grid = malloc(MOST_NODES * sizeof *b.grid);
    b.edge = malloc(MOST_NODES * sizeof *b.edge);
    b.node = malloc(60 * MOST_CORNERS * sizeof *b.node);
    b.offset = calloc(6 * MOST_CORNERS + 1, sizeof *b.offset);
    b.type = malloc(6 * MOST_CORNERS);
    for (int i = 0; i <= b.n[0]; i++)
        for (int j = 0; j <= b.n[1]; j++)
            for (int k = 0; k <= b.n[2]; k++) {
                double *g = b.grid[corner_at(&b, i, j, k)];
                const int at[3] = {i, j, k};
                for (int d = 0; d < 3; d++) {
                    const double by = amount * random_between(state, -1, 1);
                    const int is_crease = b.kind == BODY_CREASE && d == 0 && at[0] == b.n[0] / 2;
                    g[d] = at[d] + (at[d] > 0 && at[d] < b.n[d] && !is_crease ? by : 0);
                }
            }
    b.mesh.n_nodes = b.n_corners;
    for (int i = 0; i < b.n[0]; i++)
        for (int j = 0; j < b.n[1]; j++)
            for (int k = 0; k < b.n[2]; k++)
                add_cube(&b, i, j, k);
    b.x = malloc((size_t)b.mesh.n_nodes * 3 * sizeof *b.x);
    for (int64_t i = 0; i < b.mesh.n_nodes; i++)
        to_space(&b, b.grid[i], b.x + 3 * i);
    b.cells.type = b.type;
    b.cells.offset = b.offset;
    b.cells.node = b.node;
    b.mesh.dim = 3;
    b.mesh.coordinates = b.x;
    b.mesh.n_elements = b.cells.n;
    return b;
}

static void free_body(body *b) {
    free(b->grid);
    free(b->edge);
    free(b->node);
    free(b->offset);
    free(b->type);
    free(b->x);
}

/* ---- a case --------------------------------------------------------------------------------- */

/** A body, its shape, and what was asked for. */
typedef struct trial {
    int64_t number;
    body body;
    planish_shape *shape;
    uint8_t *constraint;
    double *direction;
    planish_options options;
    double *x[RUNS]; /* of 1, 2 and 3 threads; stopped on the way */
    int n_calls;     /* of the progress function before it stops */
} trial;

static void check_that(const trial *t, int condition, const char *promise) {
    if (!condition)
        fail_msg("PLANISH_CASE=%lld: %s (kind %d)", (long long)t->number, promise, t->body.kind);
}

static int stop_late(const planish_progress *progress, void *user) {
    (void)progress;
    return --*(int *)user < 0;
}

static void smooth(trial *t, int threads, double *x) {
    planish_plan *plan;
    planish_result result;
    planish_error error = {.text = ""};
    planish_mesh mesh = t->body.mesh;
    planish_options options = t->options;
    mesh.cells = &t->body.cells;
    mesh.constraint = t->constraint;
    mesh.direction = t->direction;
    options.threads = threads;
    memcpy(x, t->body.x, (size_t)mesh.n_nodes * 3 * sizeof *x);
    mesh.coordinates = x;
    if (planish_plan_create(&mesh, &options, &plan, &error) ||
        planish_smooth(plan, x, &options, &result, &error))
        check_that(t, 0, error.text);
    planish_plan_destroy(plan);
}

static void prepare(trial *t, int64_t number) {
    uint64_t state = effort_seed((uint64_t)number + 7000);
    planish_error error = {.text = ""};
    planish_slide_info info;
    planish_shape_info of_shape;
    planish_surface surface = {.n_facets = 0};
    *t = (trial){.number = number, .body = make_body(&state)};
    t->body.mesh.cells = &t->body.cells;
    const planish_mesh *mesh = &t->body.mesh;
    if (planish_shape_create(mesh, &surface, 1, &t->shape, &of_shape, &error))
        check_that(t, 0, error.text);
    check_that(t, of_shape.n_mids > 0, "the shape has mids");
    surface.shape = t->shape;
    t->constraint = malloc((size_t)mesh->n_nodes);
    t->direction = malloc((size_t)mesh->n_nodes * 3 * sizeof *t->direction);
    if (planish_find_slides(mesh, &surface, 1, t->constraint, t->direction, &info, &error))
        check_that(t, 0, error.text);
    planish_options_init(&t->options);
    t->options.shape = t->shape;
    if (random_below(&state, 3) == 0)
        t->options.precision = PLANISH_PRECISION_FLOAT;
    if (random_below(&state, 3) > 0) {
        t->options.surface_tolerance = random_below(&state, 2) ? 0.002 : 0.2;
        t->options.surface_tolerance_unit = PLANISH_UNIT_EDGE;
    }
    for (int i = 0; i < RUNS; i++) {
        t->x[i] = malloc((size_t)mesh->n_nodes * 3 * sizeof *t->x[i]);
        t->n_calls = (int)random_below(&state, 30);
        if (i == RUNS - 1) {
            t->options.progress = stop_late;
            t->options.progress_user = &t->n_calls;
        }
        smooth(t, i == RUNS - 1 ? 1 : i + 1, t->x[i]);
    }
}

static void finish(trial *t) {
    for (int i = 0; i < RUNS; i++)
        free(t->x[i]);
    planish_shape_destroy(t->shape);
    free(t->constraint);
    free(t->direction);
    free_body(&t->body);
}

/* ---- promises ------------------------------------------------------------------------------- */

static void find_states(const trial *t, const double *x, uint8_t *state) {
    planish_mesh mesh = t->body.mesh;
    planish_cell_quality quality;
    planish_error error = {.text = ""};
    const planish_cell_values values = {.state = state};
    mesh.cells = &t->body.cells;
    mesh.coordinates = x;
    if (planish_measure_cells(&mesh, 0, 1, &quality, &values, &error))
        check_that(t, 0, error.text);
}

static int has_moved(const trial *t, const double *x, int64_t node) {
    return memcmp(x + 3 * node, t->body.x + 3 * node, 3 * sizeof *x) != 0;
}

/** Valid elements stay valid; nodes that are held stay, and mids between them. Returns how many mids of
 *  the surface moved. */
static int64_t check_mesh(const trial *t, const double *x) {
    const body *b = &t->body;
    uint8_t *before = malloc((size_t)b->cells.n), *after = malloc((size_t)b->cells.n);
    int64_t n = 0;
    find_states(t, b->x, before);
    find_states(t, x, after);
    for (int64_t e = 0; e < b->cells.n; e++)
        check_that(t, before[e] != PLANISH_CELL_STATE_VALID || after[e] == PLANISH_CELL_STATE_VALID,
                   "valid elements stay valid");
    for (int32_t i = 0; i < b->mesh.n_nodes; i++) {
        const int is_mid = i >= b->n_corners, on_surface = t->shape->number[i] >= 0;
        const int moves = has_moved(t, x, i);
        n += moves && is_mid && on_surface;
        if (!is_mid)
            check_that(t, !moves || t->constraint[i] != PLANISH_CONSTRAINT_FIXED,
                       "held nodes stay");
        else if (on_surface)
            check_that(t,
                       !moves || has_moved(t, x, b->edge[i][0]) || has_moved(t, x, b->edge[i][1]),
                       "mids stay if their ends do");
    }
    free(before);
    free(after);
    return n;
}

/** The point of a curved facet of weights u, v and the rest, in the shape's units. */
static void point_of(const trial *t, const double *x, const int32_t whole[6], double u, double v,
                     double at[3]) {
    const double w = 1 - u - v;
    const double by[6] = {u * (2 * u - 1), v * (2 * v - 1), w * (2 * w - 1),
                          4 * u * v,       4 * v * w,       4 * w * u};
    for (int d = 0; d < 3; d++) {
        at[d] = 0;
        for (int i = 0; i < 6; i++)
            at[d] += by[i] * x[3 * t->shape->node[whole[i]] + d] * t->shape->scale;
    }
}

/** Make a judge of the curved facets, each divided into FINE^2 triangles. */
static sheet_judge judge_create(const trial *t, const double *x) {
    const planish_shape *s = t->shape;
    const int64_t n = s->n_facets / 4 * FINE * FINE;
    double(*at)[3] = malloc((size_t)n * 3 * sizeof *at);
    planish_shape fine = {.n_facets = n};
    fine.facet = malloc((size_t)n * sizeof *fine.facet);
    fine.patch = malloc((size_t)n * sizeof *fine.patch);
    int32_t f = 0;
    for (int64_t whole = 0; whole < s->n_facets / 4; whole++)
        for (int i = 0; i < FINE; i++)
            for (int j = 0; i + j < FINE; j++)
                for (int half = 0; half < 2 && i + j + half < FINE; half++, f++) {
                    static const int BY[2][3][2] = {{{0, 0}, {1, 0}, {0, 1}},
                                                    {{1, 1}, {0, 1}, {1, 0}}};
                    for (int k = 0; k < 3; k++) {
                        fine.facet[f][k] = 3 * f + k;
                        point_of(t, x, s->whole[whole], (double)(i + BY[half][k][0]) / FINE,
                                 (double)(j + BY[half][k][1]) / FINE, at[3 * f + k]);
                    }
                    fine.patch[f] = s->patch[4 * whole];
                }
    assert_int_equal(f, n);
    sheet_judge judge = sheet_judge_create(&fine, (const double(*)[3])at);
    judge.patch = NULL;
    free(fine.facet);
    free(fine.patch);
    free(at);
    return judge;
}

/** Largest distance of samples of a curved facet. */
static double sample(const trial *t, const sheet_judge *judge, const double *x, int64_t whole) {
    double most = 0, at[3];
    for (int i = 0; i <= SAMPLES; i++)
        for (int j = 0; i + j <= SAMPLES; j++) {
            point_of(t, x, t->shape->whole[whole], (double)i / SAMPLES, (double)j / SAMPLES, at);
            most = fmax(most, sheet_judge_distance(judge, -1, at));
        }
    return most;
}

static double tolerance_of(const trial *t, int64_t whole) {
    const planish_shape *s = t->shape;
    double mean = 0;
    for (int k = 0; k < 3; k++)
        mean += pl_distance(3, s->x[s->whole[whole][k]], s->x[s->whole[whole][(k + 1) % 3]]) / 3;
    return (t->options.surface_tolerance > 0 ? t->options.surface_tolerance : 0.05) * mean;
}

/** How far the judge's triangles are off a curved facet. */
static double slack_of(const trial *t, const double *x) {
    double most = 0;
    for (int64_t w = 0; w < t->shape->n_facets / 4; w++)
        for (int k = 0; k < 3; k++) {
            const int32_t *whole = t->shape->whole[w];
            double a[3], b[3], m[3];
            static const double U[3][2] = {{1, 0}, {0, 1}, {0, 0}},
                                MID[3][2] = {{.5, .5}, {0, .5}, {.5, 0}};
            point_of(t, x, whole, U[k][0], U[k][1], a);
            point_of(t, x, whole, U[(k + 1) % 3][0], U[(k + 1) % 3][1], b);
            point_of(t, x, whole, MID[k][0], MID[k][1], m);
            for (int d = 0; d < 3; d++)
                m[d] -= 0.5 * (a[d] + b[d]);
            most = fmax(most, sqrt(pl_dot(3, m, m)));
        }
    return 4. / 3 * most / (FINE * FINE);
}

/** No point of a curved facet is farther off than the tolerance, and than what was proved. */
static void check_distance(const trial *t, const double *x, double *worth) {
    const planish_shape *s = t->shape;
    planish_mesh mesh = t->body.mesh;
    planish_shape_distance d;
    planish_error error = {.text = ""};
    mesh.coordinates = x;
    if (planish_measure_shape(s, &mesh, 1, &d, &error))
        check_that(t, 0, error.text);
    sheet_judge first = judge_create(t, t->body.x), now = judge_create(t, x);
    const double slack = fmax(slack_of(t, x), slack_of(t, t->body.x)) + 2e-7 * s->size;
    double there = 0, back = 0;
    for (int64_t w = 0; w < s->n_facets / 4; w++) {
        const double off = sample(t, &first, x, w);
        check_that(t, off <= tolerance_of(t, w) + slack, "no sample is beyond the tolerance");
        there = fmax(there, off);
        back = fmax(back, sample(t, &now, t->body.x, w));
    }
    check_that(t, there <= d.distance * s->scale + slack, "the measure holds there");
    check_that(t, back <= d.distance_back * s->scale + slack, "the measure holds back");
    check_that(t, d.n_unproved == 0, "every facet has a bound");
    /* What a run proves on the way may be less than what is proved at the end. */
    const double given = t->options.surface_tolerance > 0 ? t->options.surface_tolerance : 0.05;
    check_that(t, d.in_edges <= 1.5 * given, "little more than the tolerance is proved");
    *worth = d.in_edges;
    sheet_judge_destroy(&first);
    sheet_judge_destroy(&now);
}

static void bodies_keep_their_shape(void **unused) {
    (void)unused;
    const char *one = getenv("PLANISH_CASE");
    const int64_t n = one ? 1 : effort(8, 1000);
    int64_t n_moved = 0, n_bodies = 0;
    double most = 0;
    for (int64_t i = 0; i < n; i += effort_step(3)) {
        trial t;
        double worth;
        prepare(&t, one ? strtoll(one, NULL, 10) : i);
        const size_t bytes = (size_t)t.body.mesh.n_nodes * 3 * sizeof(double);
        check_that(&t, !memcmp(t.x[0], t.x[1], bytes), "2 threads give the bits of 1");
        check_that(&t, !memcmp(t.x[0], t.x[2], bytes), "3 threads give the bits of 1");
        for (int k = 0; k < RUNS; k += RUNS - 1) {
            const int64_t moved = check_mesh(&t, t.x[k]);
            check_distance(&t, t.x[k], &worth);
            most = fmax(most, worth);
            n_moved += moved;
            n_bodies += k == 0 && moved > 0;
        }
        finish(&t);
    }
    figure("%lld bodies of second order on curved surfaces: %lld mids moved in %lld of them, by up "
           "to %.3f "
           "edges off",
           (long long)n, (long long)n_moved, (long long)n_bodies, most);
    assert_true(one || n_moved > 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bodies_keep_their_shape),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
