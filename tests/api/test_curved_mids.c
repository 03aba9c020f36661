/* Curved surfaces of second order: random small bodies of elements of every type are smoothed on the shape
 * of their surface, and judged by samples of their curved facets. PLANISH_CASE=NUMBER does one case
 * alone. */
#include "shape/overlay.h"
#include "support/effort.h"
#include "support/facet_functions.h"
#include "support/run.h"
#include "support/sheets.h"
#include "support/snapshots.h"

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

/** Elements of cubes: six quadratic tetrahedra; hexahedra of 20 or 27 nodes; two wedges of 15 or 18; columns
 *  of either; columns of first and second order. */
enum { OF_TETS, OF_HEX20, OF_HEX27, OF_WEDGE15, OF_WEDGE18, OF_BOTH, OF_ORDERS, CELL_KINDS };

/** A grid of cubes. */
typedef struct body {
    int kind, of, n[3];
    double wave[4];
    double (*grid)[3]; /* [n_nodes] places in the grid, and in space */
    double *x;
    int32_t (*edge)[4]; /* [n_nodes] corners that each mid or centre is between; -1 behind two */
    int32_t *node;
    int64_t *offset;
    uint8_t *type;
    planish_cells cells;
    planish_mesh mesh;
    int32_t n_corners;
} body;

static int32_t corner_at(const body *b, int i, int j, int k) {
    return (int32_t)((i * (b->n[1] + 1) + j) * (b->n[2] + 1) + k);
}

/** The node between n corners, new or not: 2 of an edge, 4 of a face, 8 of a cube (then it is new). */
static int32_t node_between(body *b, int n, const int32_t *corner) {
    int32_t end[4] = {-1, -1, -1, -1};
    for (int i = 0; i < 4 && i < n; i++) {
        int at = i;
        for (; at > 0 && end[at - 1] > corner[i]; at--)
            end[at] = end[at - 1];
        end[at] = corner[i];
    }
    for (int32_t i = b->n_corners; i < b->mesh.n_nodes && n < 8; i++)
        if (!memcmp(b->edge[i], end, sizeof end))
            return i;
    const int32_t mid = (int32_t)b->mesh.n_nodes++;
    memcpy(b->edge[mid], end, sizeof end);
    for (int d = 0; d < 3; d++) {
        b->grid[mid][d] = 0;
        for (int i = 0; i < n; i++)
            b->grid[mid][d] += b->grid[corner[i]][d] / n;
    }
    return mid;
}

static int32_t mid_of(body *b, int32_t p, int32_t q) {
    return node_between(b, 2, (int32_t[]){p, q});
}

/** End an element of n nodes. */
static void end_cell(body *b, int type, int n) {
    b->type[b->cells.n] = (uint8_t)type;
    b->offset[b->cells.n + 1] = b->offset[b->cells.n] + n;
    b->cells.n++;
}

/** Add the tetrahedra of a cube: along its diagonal, one for each order of the directions. */
static void add_tets(body *b, int i, int j, int k) {
    static const int ORDER[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                    {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    static const int ENDS[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
    for (int t = 0; t < 6; t++) {
        int at[3] = {i, j, k};
        int32_t *node = b->node + b->offset[b->cells.n];
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
        end_cell(b, PLANISH_CELL_TETRAHEDRON10, 10);
    }
}

/** Add a hexahedron of 8, 20 or 27 nodes. */
static void add_hex(body *b, int n_nodes, int i, int j, int k) {
    static const int AT[8][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    static const int EDGE[12][2] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                                    {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
    static const int FACE[6][4] = {{0, 3, 7, 4}, {1, 2, 6, 5}, {0, 1, 5, 4},
                                   {3, 2, 6, 7}, {0, 1, 2, 3}, {4, 5, 6, 7}};
    int32_t *node = b->node + b->offset[b->cells.n];
    for (int c = 0; c < 8; c++)
        node[c] = corner_at(b, i + AT[c % 4][0], j + AT[c % 4][1], k + c / 4);
    for (int e = 0; e < 12 && n_nodes > 8; e++)
        node[8 + e] = mid_of(b, node[EDGE[e][0]], node[EDGE[e][1]]);
    for (int f = 0; f < 6 && n_nodes > 20; f++) {
        int32_t corner[4];
        for (int c = 0; c < 4; c++)
            corner[c] = node[FACE[f][c]];
        node[20 + f] = node_between(b, 4, corner);
    }
    if (n_nodes > 20)
        node[26] = node_between(b, 8, node);
    end_cell(b,
             n_nodes == 8    ? PLANISH_CELL_HEXAHEDRON
             : n_nodes == 20 ? PLANISH_CELL_HEXAHEDRON20
                             : PLANISH_CELL_HEXAHEDRON27,
             n_nodes);
}

/** Add two wedges of 6, 15 or 18 nodes. */
static void add_wedges(body *b, int n_nodes, int i, int j, int k) {
    static const int AT[2][3][2] = {{{0, 0}, {1, 0}, {1, 1}}, {{0, 0}, {1, 1}, {0, 1}}};
    static const int EDGE[9][2] = {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5},
                                   {5, 3}, {0, 3}, {1, 4}, {2, 5}};
    static const int FACE[3][4] = {{0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}};
    for (int half = 0; half < 2; half++) {
        int32_t *node = b->node + b->offset[b->cells.n];
        for (int c = 0; c < 6; c++)
            node[c] = corner_at(b, i + AT[half][c % 3][0], j + AT[half][c % 3][1], k + c / 3);
        for (int e = 0; e < 9 && n_nodes > 6; e++)
            node[6 + e] = mid_of(b, node[EDGE[e][0]], node[EDGE[e][1]]);
        for (int f = 0; f < 3 && n_nodes > 15; f++) {
            int32_t corner[4];
            for (int c = 0; c < 4; c++)
                corner[c] = node[FACE[f][c]];
            node[15 + f] = node_between(b, 4, corner);
        }
        end_cell(b,
                 n_nodes == 6    ? PLANISH_CELL_WEDGE
                 : n_nodes == 15 ? PLANISH_CELL_WEDGE15
                                 : PLANISH_CELL_WEDGE18,
                 n_nodes);
    }
}

static void add_cube(body *b, int i, int j, int k) {
    const int is_odd = (i + 2 * j) % 3 == 1; /* column */
    if (b->of == OF_TETS)
        add_tets(b, i, j, k);
    else if (b->of == OF_WEDGE15 || b->of == OF_WEDGE18 || (b->of == OF_BOTH && is_odd))
        add_wedges(b, b->of == OF_WEDGE18 ? 18 : 15, i, j, k);
    else
        add_hex(b, b->of == OF_HEX27 ? 27 : b->of == OF_ORDERS && i == 0 ? 8 : 20, i, j, k);
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

static body make_body(int of, uint64_t *state) {
    body b = {.kind = (int)random_below(state, BODY_KINDS), .of = of};
    const double amount = random_between(state, 0, 0.3);
    for (int d = 0; d < 3; d++)
        b.n[d] = b.kind == BODY_BALL ? 4 : 2 + (int)random_below(state, 3);
    for (int i = 0; i < 4; i++)
        b.wave[i] = random_between(state, 0.1, 0.6);
    b.n_corners = (b.n[0] + 1) * (b.n[1] + 1) * (b.n[2] + 1);
    b.grid = malloc(MOST_NODES * sizeof *b.grid);
    b.edge = malloc(MOST_NODES * sizeof *b.edge);
    b.node = malloc(60 * MOST_CORNERS * sizeof *b.node); /* six times ten, or up to twice 18 */
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
    planish_result result; /* of the last run */
    double *x[RUNS];       /* of 1, 2 and 3 threads; stopped on the way */
    int n_calls;           /* of the progress function before it stops */
} trial;

static void check_that(const trial *t, int condition, const char *promise) {
    if (!condition)
        fail_msg("PLANISH_CASE=%lld: %s (kind %d, elements %d)", (long long)t->number, promise,
                 t->body.kind, t->body.of);
}

static int stop_late(const planish_progress *progress, void *user) {
    (void)progress;
    return --*(int *)user < 0;
}

static void smooth(trial *t, int threads, double *x) {
    planish_plan *plan;
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
        planish_smooth(plan, x, &options, &t->result, &error))
        check_that(t, 0, error.text);
    planish_plan_destroy(plan);
}

static void prepare(trial *t, int64_t number) {
    uint64_t state = effort_seed((uint64_t)number + 7000);
    planish_error error = {.text = ""};
    planish_slide_info info;
    planish_shape_info of_shape;
    planish_surface surface = {.n_facets = 0};
    *t = (trial){.number = number, .body = make_body((int)(number % CELL_KINDS), &state)};
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

/** Whether one of the corners that a mid is between has moved. */
static int any_has_moved(const trial *t, const double *x, const int32_t corner[4]) {
    int any = 0;
    for (int k = 0; k < 4 && corner[k] >= 0; k++)
        any |= has_moved(t, x, corner[k]);
    return any;
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
            check_that(t, !moves || any_has_moved(t, x, b->edge[i]), "mids stay if their ends do");
    }
    free(before);
    free(after);
    return n;
}

/** The point of a curved facet at u, v, in the shape's units. */
static void point_of(const trial *t, const double *x, const pl_whole *whole, double u, double v,
                     double at[3]) {
    double by[9];
    facet_functions(whole->n_nodes, u, v, by);
    for (int d = 0; d < 3; d++) {
        at[d] = 0;
        for (int i = 0; i < whole->n_nodes; i++)
            at[d] += by[i] * x[3 * t->shape->node[whole->node[i]] + d] * t->shape->scale;
    }
}

/** Triangle i of FINE^2 or twice as many of a facet: its corners' u and v, in units of FINE. Returns 0 beyond
 *  the last one. */
static int fine_triangle(const pl_whole *whole, int i, int uv[3][2]) {
    static const int OF_TRIANGLE[2][3][2] = {{{0, 0}, {1, 0}, {0, 1}}, {{1, 1}, {0, 1}, {1, 0}}},
                     OF_SQUARE[2][3][2] = {{{0, 0}, {1, 0}, {1, 1}}, {{0, 0}, {1, 1}, {0, 1}}};
    const int is_square = whole->n_corners == 4;
    int u = i / 2 / FINE, v = i / 2 % FINE, half = i % 2;
    if (!is_square && u + v + half >= FINE) /* outside: the first one once more */
        u = v = half = 0;
    for (int k = 0; k < 3; k++) {
        const int *by = (is_square ? OF_SQUARE : OF_TRIANGLE)[half][k];
        uv[k][0] = u + by[0];
        uv[k][1] = v + by[1];
    }
    return i < 2 * FINE * FINE;
}

/** Make a judge of the curved facets, each divided into triangles. */
static sheet_judge judge_create(const trial *t, const double *x) {
    const planish_shape *s = t->shape;
    const int64_t n = s->n_wholes * 2 * FINE * FINE;
    double(*at)[3] = malloc((size_t)n * 3 * sizeof *at);
    planish_shape fine = {.n_facets = n};
    fine.facet = malloc((size_t)n * sizeof *fine.facet);
    fine.patch = malloc((size_t)n * sizeof *fine.patch);
    int32_t f = 0;
    for (const pl_whole *whole = s->whole; whole < s->whole + s->n_wholes; whole++) {
        int uv[3][2];
        for (int i = 0; fine_triangle(whole, i, uv); i++, f++) {
            for (int k = 0; k < 3; k++) {
                fine.facet[f][k] = 3 * f + k;
                point_of(t, x, whole, (double)uv[k][0] / FINE, (double)uv[k][1] / FINE,
                         at[3 * f + k]);
            }
            fine.patch[f] = s->patch[whole->first];
        }
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
static double sample(const trial *t, const sheet_judge *judge, const double *x,
                     const pl_whole *whole) {
    double most = 0, at[3];
    for (int i = 0; i <= SAMPLES; i++)
        for (int j = 0; j <= SAMPLES && (whole->n_corners == 4 || i + j <= SAMPLES); j++) {
            point_of(t, x, whole, (double)i / SAMPLES, (double)j / SAMPLES, at);
            most = fmax(most, sheet_judge_distance(judge, -1, at));
        }
    return most;
}

static double tolerance_of(const trial *t, const pl_whole *whole) {
    const planish_shape *s = t->shape;
    const int n = whole->n_corners;
    double mean = 0;
    for (int k = 0; k < n; k++)
        mean += pl_distance(3, s->x[whole->node[k]], s->x[whole->node[(k + 1) % n]]) / n;
    return (t->options.surface_tolerance > 0 ? t->options.surface_tolerance : 0.05) * mean;
}

/** How far the judge's triangles are off the curved facets: 4 / 3 of what they are in the middle of their
 *  edges, where facets are quadratic, and about that elsewhere. */
static double slack_of(const trial *t, const double *x) {
    const planish_shape *s = t->shape;
    double most = 0;
    for (const pl_whole *whole = s->whole; whole < s->whole + s->n_wholes; whole++) {
        int uv[3][2];
        for (int i = 0; fine_triangle(whole, i, uv); i++)
            for (int k = 0; k < 3; k++) {
                const int *p = uv[k], *q = uv[(k + 1) % 3];
                double a[3], b[3], m[3];
                point_of(t, x, whole, (double)p[0] / FINE, (double)p[1] / FINE, a);
                point_of(t, x, whole, (double)q[0] / FINE, (double)q[1] / FINE, b);
                point_of(t, x, whole, 0.5 * (p[0] + q[0]) / FINE, 0.5 * (p[1] + q[1]) / FINE, m);
                for (int d = 0; d < 3; d++)
                    m[d] -= 0.5 * (a[d] + b[d]);
                most = fmax(most, sqrt(pl_dot(3, m, m)));
            }
    }
    return 1.5 * most;
}

/** The largest rest of a facet, as it came, in edges: it is in what is proved of a facet on another one
 *  twice. */
static double rest_of(const trial *t) {
    const planish_shape *s = t->shape;
    double most = 0;
    for (const pl_whole *whole = s->whole; whole < s->whole + s->n_wholes; whole++) {
        double x[PL_WHOLE_NODES][3];
        pl_whole_nodes(s, whole, x);
        for (int part = 0; part < whole->n_parts; part++)
            most = fmax(most,
                        pl_whole_rest(whole, (const double(*)[3])x, pl_whole_parts(whole)[part]) /
                            pl_shape_edge(s, whole->first));
    }
    return most;
}

/** No point of a curved facet is farther off than the tolerance, and than what was proved. */
static void check_distance(const trial *t, const double *x, double *worth) {
    const planish_shape *s = t->shape;
    planish_mesh mesh = t->body.mesh;
    planish_shape_distance d;
    planish_error error = {.text = ""};
    mesh.coordinates = x;
    if (planish_shape_measure(s, &mesh, 1, &d, &error))
        check_that(t, 0, error.text);
    sheet_judge first = judge_create(t, t->body.x), now = judge_create(t, x);
    const double slack = fmax(slack_of(t, x), slack_of(t, t->body.x)) + 2e-7 * s->size;
    double there = 0, back = 0;
    for (const pl_whole *w = s->whole; w < s->whole + s->n_wholes; w++) {
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
    check_that(t, d.in_edges <= 2 * given + 2.5 * rest_of(t),
               "no more than twice the tolerance is proved");
    *worth = d.in_edges;
    sheet_judge_destroy(&first);
    sheet_judge_destroy(&now);
}

static void bodies_keep_their_shape(void **unused) {
    (void)unused;
    static const char *const OF[] = {"tetrahedra",
                                     "hexahedra of 20 nodes",
                                     "hexahedra of 27 nodes",
                                     "wedges of 15 nodes",
                                     "wedges of 18 nodes",
                                     "hexahedra and wedges",
                                     "hexahedra of both orders"};
    const char *one = getenv("PLANISH_CASE");
    const int64_t n = one ? 1 : effort(4, 300) * CELL_KINDS;
    int64_t n_moved[CELL_KINDS] = {0};
    double most[CELL_KINDS] = {0};
    for (int64_t i = 0; i < n; i += effort_step(3)) {
        trial t;
        double worth;
        prepare(&t, one ? strtoll(one, NULL, 10) : i);
        const size_t bytes = (size_t)t.body.mesh.n_nodes * 3 * sizeof(double);
        check_that(&t, !memcmp(t.x[0], t.x[1], bytes), "2 threads give the bits of 1");
        check_that(&t, !memcmp(t.x[0], t.x[2], bytes), "3 threads give the bits of 1");
        for (int k = 0; k < RUNS; k += RUNS - 1) {
            n_moved[t.body.of] += check_mesh(&t, t.x[k]);
            check_distance(&t, t.x[k], &worth);
            most[t.body.of] = fmax(most[t.body.of], worth);
        }
        finish(&t);
    }
    for (int of = 0; of < CELL_KINDS; of++) {
        figure("bodies of %s on curved surfaces: %lld mids moved, by up to %.3f edges off", OF[of],
               (long long)n_moved[of], most[of]);
        assert_true(one || effort_step(3) > 1 || n_moved[of] > 0);
    }
}

/** Snapshots of mids keep what a mesh must keep. While the worst elements are improved, corners and mids move
 *  on trial: the snapshots have the mesh that stands, with its mids. */
static void snapshots_have_their_mids(void **unused) {
    (void)unused;
    enum { CHECKED = 8 }; /* one snapshot of so many: that takes long */
    int n_stand = 0;
    for (int64_t i = 0; i < CELL_KINDS; i++) {
        trial t;
        prepare(&t, i);
        const size_t bytes = (size_t)t.body.mesh.n_nodes * 3 * sizeof(double);
        memcpy(t.x[0], t.body.x, bytes);
        snapshots taken = snapshots_begin(t.x[0], bytes / sizeof(double));
        t.options.worst =
            t.body.of == OF_TETS ? PLANISH_WORST_RADIUS_RATIO : PLANISH_WORST_ASPECT_RATIO;
        t.options.progress = snapshots_take;
        t.options.progress_user = &taken;
        smooth(&t, 2, t.x[0]);
        for (int k = 0; k < taken.n; k++) {
            const int begins = k > 0 && taken.figures[k].phase == PLANISH_PHASE_WORST &&
                               taken.figures[k - 1].phase != PLANISH_PHASE_WORST;
            if (begins || k % CHECKED == 0)
                check_mesh(&t, taken.x[k]);
            if (begins && t.result.n_put_back == 0) {
                check_that(&t, !memcmp(taken.x[k], taken.x[k - 1], bytes), "what stands is shown");
                n_stand++;
            }
        }
        snapshots_free(&taken);
        finish(&t);
    }
    assert_true(n_stand >= CELL_KINDS / 2);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bodies_keep_their_shape),
        cmocka_unit_test(snapshots_have_their_mids),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
