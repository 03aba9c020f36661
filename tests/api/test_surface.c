/* planish_smooth_surface: triangles and quadrilaterals in space on their own shape. */
#include "support/allocations.h"
#include "support/effort.h"
#include "support/sheets.h"
#include "support/snapshots.h"

#include "surface/surface_mesh.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { AROUND = 72, ACROSS = 24, NODES = AROUND * ACROSS, MOST = 2 * NODES };

/** A closed or open surface over a grid of AROUND by ACROSS nodes. */
typedef struct patchwork {
    planish_mesh mesh;
    planish_cells cells;
    double x[NODES][3], given[NODES][3];
    int32_t node[4 * MOST];
    int64_t offset[MOST + 1];
    uint8_t type[MOST];
    planish_shape *shape;
    planish_options options;
    double apart; /* of SHEETS */
} patchwork;

enum {
    TORUS,
    PLANE,
    TUBE,
    SHEETS, /* two tubes, one in the other */
    SHAFT   /* a tube through the hole of a plane sheet */
};

/** Row of a shaft that is in the plane of the sheet. */
enum { IN_PLANE = 6 };

static int is_two(int kind) {
    return kind == SHEETS || kind == SHAFT;
}

/** Whether the row v is at a border, and whether it is the last one of a sheet. */
static int is_last(int kind, int v) {
    return v == ACROSS - 1 || (is_two(kind) && v == ACROSS / 2 - 1);
}

static int is_border(int kind, int v) {
    return kind != TORUS && (v == 0 || is_last(kind, v) || (is_two(kind) && v == ACROSS / 2));
}

static double random_number(uint64_t *state) {
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (double)(*state >> 11) * 0x1p-53 - 0.5;
}

/** Place of parameters u, v, in nodes along and across. */
static void place(int kind, double apart, double u, double v, double x[3]) {
    const double pi = 3.14159265358979323846, a = 2 * pi * u / AROUND, b = 2 * pi * v / ACROSS;
    const int second = is_two(kind) && v > ACROSS / 2 - 0.5;
    const double r = kind == TORUS ? 3 + cos(b) : second ? 3 + apart : 3;
    if (kind == SHAFT) {
        const double far = second ? r + 0.3 * (v - ACROSS / 2) : r;
        x[0] = far * cos(a);
        x[1] = far * sin(a);
        x[2] = second ? 0 : 0.3 * (v - IN_PLANE);
        return;
    }
    x[0] = kind == PLANE ? u : r * cos(a);
    x[1] = kind == PLANE ? 0.6 * v : r * sin(a);
    x[2] = kind == PLANE ? 0.8 * v : kind == TORUS ? sin(b) : 0.4 * (second ? v - ACROSS / 2 : v);
}

/** Make a surface with nodes thrown about by up to far cells, as quadrilaterals or triangles. */
static void make(patchwork *p, int kind, int has_quads, double far) {
    uint64_t state = 7;
    int64_t n = 0, at = 0;
    const int ends = kind == TORUS ? ACROSS : ACROSS - 1;
    const int columns = kind == PLANE ? AROUND - 1 : AROUND;
    const double apart = p->apart;
    memset(p, 0, sizeof *p);
    p->apart = apart;
    for (int i = 0; i < NODES; i++) {
        const int u = i / ACROSS, v = i % ACROSS;
        const int in_phase = kind == SHAFT && (v == IN_PLANE || v == ACROSS / 2);
        const int edge_u = in_phase || (kind == PLANE && (u == 0 || u == AROUND - 1));
        const int edge_v = in_phase || is_border(kind, v);
        const double shift_v = edge_v ? 0 : far * random_number(&state);
        const double shift_u = edge_u ? 0 : far * random_number(&state);
        place(kind, p->apart, u + shift_u, v + shift_v, p->x[i]);
    }
    for (int u = 0; u < columns; u++)
        for (int v = 0; v < ends; v++) {
            if (is_two(kind) && is_last(kind, v))
                continue;
            const int32_t a = u * ACROSS + v, b = (u + 1) % AROUND * ACROSS + v;
            const int32_t c = (u + 1) % AROUND * ACROSS + (v + 1) % ACROSS;
            const int32_t d = u * ACROSS + (v + 1) % ACROSS;
            const int32_t quad[] = {a, b, c, d}, two[] = {a, b, c, a, c, d};
            memcpy(p->node + at, has_quads ? quad : two, has_quads ? sizeof quad : sizeof two);
            for (int k = 0; k < (has_quads ? 1 : 2); k++) {
                p->type[n] = has_quads ? PLANISH_CELL_QUADRILATERAL : PLANISH_CELL_TRIANGLE;
                at += has_quads ? 4 : 3;
                p->offset[++n] = at;
            }
        }
    memcpy(p->given, p->x, sizeof p->x);
    p->cells = (planish_cells){.n = n, .type = p->type, .offset = p->offset, .node = p->node};
    p->mesh = (planish_mesh){
        .dim = 3, .n_nodes = NODES, .n_elements = n, .coordinates = p->x[0], .cells = &p->cells};
    assert_int_equal(planish_shape_create(&p->mesh, NULL, 2, &p->shape, NULL, NULL), 0);
    planish_options_init(&p->options);
    p->options.shape = p->shape;
    p->options.threads = 1;
}

static void destroy(patchwork *p) {
    planish_shape_destroy(p->shape);
}

/* ---- an independent look -------------------------------------------------------------------- */

/** Worst of a surface by plain formulas: largest RR, smallest angle; of quadrilaterals only the angle. */
typedef struct worst {
    double ratio, angle;
} worst;

static double between(const double *a, const double *b, const double *c) {
    double u[3], v[3], uu = 0, vv = 0, uv = 0;
    for (int d = 0; d < 3; d++) {
        u[d] = b[d] - a[d];
        v[d] = c[d] - a[d];
        uu += u[d] * u[d];
        vv += v[d] * v[d];
        uv += u[d] * v[d];
    }
    return acos(fmax(-1, fmin(1, uv / sqrt(uu * vv))));
}

static worst look(const patchwork *p, const double (*x)[3]) {
    worst w = {0, 4};
    for (int64_t i = 0; i < p->cells.n; i++) {
        const int32_t *v = p->node + p->offset[i];
        const int n = (int)(p->offset[i + 1] - p->offset[i]);
        double sine = 0;
        for (int k = 0; k < n; k++) {
            const double angle = between(x[v[k]], x[v[(k + 1) % n]], x[v[(k + n - 1) % n]]);
            w.angle = fmin(w.angle, fmin(angle, n == 4 ? 3.14159265358979323846 - angle : angle));
            sine += sin(angle);
        }
        /* R / (2 r) = (sum of sines) / (8 times the product of sines) times 2 */
        if (n == 3) {
            double product = 1;
            for (int k = 0; k < 3; k++)
                product *= sin(between(x[v[k]], x[v[(k + 1) % 3]], x[v[(k + 2) % 3]]));
            w.ratio = fmax(w.ratio, sine / (4 * product));
        }
    }
    return w;
}

/** Smooth, and check what is promised. */
static planish_result smooth(patchwork *p) {
    planish_result r;
    planish_error e;
    planish_shape_distance d;
    planish_quality quality;
    const worst before = look(p, (const double(*)[3])p->x);
    if (planish_smooth_surface(&p->mesh, p->x[0], &p->options, &r, &e))
        fail_msg("%s", e.text);
    const worst after = look(p, (const double(*)[3])p->x);
    assert_true(after.ratio <= before.ratio * (1 + 1e-9));
    assert_true(after.angle >= before.angle * (1 - 1e-9));
    assert_true(r.objective <= r.objective_before);
    assert_int_equal(r.n_inverted, 0);
    assert_int_equal(planish_shape_measure(p->shape, &p->mesh, 1, &d, NULL), 0);
    assert_int_equal(
        planish_measure_surface(p->shape, &p->mesh, 1, &quality, NULL, NULL, NULL, NULL), 0);
    assert_true(fabs(quality.rms_radius_ratio / r.rms - 1) < 1e-9);
    assert_true(fabs(quality.rms_radius_ratio_movable - r.rms_movable) <= 1e-9 * r.rms_movable);
    assert_int_equal(d.n_unproved, 0);
    assert_true(d.in_edges <= PLANISH_SURFACE_TOLERANCE * (1 + 1e-6));
    assert_true(d.max_bend <= fmax(40.001, d.max_bend_before * (1 + 1e-9)));
    return r;
}

/** Find what holds nodes. */
static const uint8_t *find_held(const patchwork *p) {
    static uint8_t held[NODES];
    planish_error e;
    memset(held, 77, sizeof held);
    if (planish_find_held_on_surface(&p->mesh, &p->options, held, &e))
        fail_msg("%s", e.text);
    return held;
}

/** The mean and, of triangles, the smallest angle improve. On a tube a wave through all of it remains for
 *  long. */
static void test_quality(void **unused) {
    static const struct {
        int kind, has_quads;
        double factor; /* of the smallest angle, by which it grows at least */
    } cases[] = {{TORUS, 0, 2}, {TORUS, 1, 1}, {TUBE, 0, 2}, {TUBE, 1, 1}};
    static patchwork p;
    (void)unused;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        make(&p, cases[i].kind, cases[i].has_quads, 0.5);
        const worst before = look(&p, (const double(*)[3])p.x);
        const planish_result r = smooth(&p);
        const worst after = look(&p, (const double(*)[3])p.x);
        assert_true(r.stop == PLANISH_STOP_CONVERGED || cases[i].kind == TUBE);
        assert_true(r.n_moved_nodes > NODES / 2);
        assert_true(r.objective - 1 < 0.5 * (r.objective_before - 1));
        assert_true(after.angle >= cases[i].factor * before.angle * (1 - 1e-9));
        destroy(&p);
    }
}

/** A plane sheet stays in its plane to rounding, and its border straight. */
static void test_plane(void **unused) {
    static patchwork p;
    planish_slide_info info;
    static uint8_t constraint[NODES];
    static double direction[NODES][3];
    (void)unused;
    make(&p, PLANE, 0, 0.6);
    const planish_surface surface = {.shape = p.shape};
    assert_int_equal(
        planish_find_slides(&p.mesh, &surface, 1, constraint, direction[0], &info, NULL), 0);
    assert_true(info.n_on_plane == (AROUND - 2) * (ACROSS - 2));
    assert_int_equal(info.n_on_line, 2 * (AROUND - 2) + 2 * (ACROSS - 2));
    p.mesh.constraint = constraint;
    p.mesh.direction = direction[0];
    const worst before = look(&p, (const double(*)[3])p.x);
    smooth(&p);
    assert_true(look(&p, (const double(*)[3])p.x).angle > 2 * before.angle);
    for (int i = 0; i < NODES; i++) {
        assert_true(fabs(p.x[i][1] * 0.8 - p.x[i][2] * 0.6) < 1e-12);
        if (i < ACROSS)
            assert_true(p.x[i][0] == p.given[i][0]);
    }
    destroy(&p);
}

static void test_same_bits(void **unused) {
    static const int threads[] = {2, 3, 5, 8};
    static patchwork p;
    (void)unused;
    for (int has_quads = 0; has_quads < 2; has_quads++) {
        make(&p, TORUS, has_quads, 0.5);
        p.options.worst = has_quads ? PLANISH_WORST_SCALED_JACOBIAN : PLANISH_WORST_ANGLE;
        smooth(&p);
        const uint64_t bits = planish_checksum(&p.mesh);
        for (size_t i = 0; i < sizeof threads / sizeof *threads; i++) {
            memcpy(p.x, p.given, sizeof p.x);
            p.options.threads = threads[i];
            smooth(&p);
            assert_int_equal(planish_checksum(&p.mesh), bits);
        }
        destroy(&p);
    }
}

/** A visit reads the nodes across the edges opposite to its own: they have other colours. */
static void test_colours(void **unused) {
    static patchwork p;
    (void)unused;
    for (int has_quads = 0; has_quads < 2; has_quads++) {
        make(&p, TORUS, has_quads, 0.5);
        const planish_shape *s = p.shape;
        static uint8_t moves[NODES];
        static int colour[NODES];
        pl_surface_mesh mesh = {.shape = s, .by_radius = !has_quads};
        for (int64_t i = 0; i < s->n_nodes; i++)
            moves[i] = s->node_class[i] != PL_CORNER;
        assert_int_equal(pl_surface_mesh_create(s, moves, 2, &mesh, NULL), 0);
        memset(colour, -1, sizeof colour);
        for (int c = 0; c < mesh.n_colours; c++)
            for (int64_t k = mesh.colour_begin[c]; k < mesh.colour_begin[c + 1]; k++)
                colour[mesh.node[k]] = c;
        int64_t n = 0;
        for (int64_t t = 0; t < s->n_facets; t++)
            for (int k = 0; k < 3; k++) {
                const int32_t *f = s->facet[t], g = s->across[t][k], v = f[(k + 2) % 3];
                assert_true(colour[f[k]] != colour[f[(k + 1) % 3]]);
                for (int j = 0; g >= 0 && j < 3; j++) {
                    const int32_t w = s->facet[g][j];
                    if (w == f[k] || w == f[(k + 1) % 3])
                        continue;
                    assert_true(colour[v] < 0 || colour[v] != colour[w]);
                    n++;
                }
            }
        assert_true(n > 2 * NODES);
        pl_surface_mesh_destroy(&mesh);
        destroy(&p);
    }
}

/** The worst phase improves the worst, at a price of F that is allowed. */
static void test_worst(void **unused) {
    static const planish_worst measures[] = {PLANISH_WORST_RADIUS_RATIO, PLANISH_WORST_ANGLE};
    static patchwork p;
    (void)unused;
    make(&p, TORUS, 0, 0.5);
    smooth(&p);
    const worst plain = look(&p, (const double(*)[3])p.x);
    for (int i = 0; i < 2; i++) {
        memcpy(p.x, p.given, sizeof p.x);
        p.options.worst = measures[i];
        p.options.worst_rise = 0.1;
        const planish_result r = smooth(&p);
        const worst now = look(&p, (const double(*)[3])p.x);
        assert_true(r.worst_sweeps > 0);
        assert_true(i == 0 ? now.ratio < plain.ratio : now.angle > plain.angle);
        assert_true(r.objective <= r.objective_of_worst * 1.1);
        assert_true(i == 0 ? r.worst_after < r.worst_before : r.worst_after > r.worst_before);
        assert_true(fabs((i == 0 ? now.ratio : now.angle * 180 / 3.14159265358979323846) -
                         r.worst_after) < 1e-6);
    }
    /* max_sweeps does not count its rounds, and they come all the same. */
    memcpy(p.x, p.given, sizeof p.x);
    p.options.max_sweeps = 2;
    const planish_result early = smooth(&p);
    assert_int_equal(early.stop, PLANISH_STOP_MAX_SWEEPS);
    assert_true(early.worst_sweeps > 0 && early.worst_after > early.worst_before);
    destroy(&p);
}

/** A ring is of elements: all four corners of a quadrilateral are in it, however it is cut. */
static void test_rings(void **unused) {
    enum { U = 6, V = 7 };
    static patchwork p;
    (void)unused;
    for (int rings = 0; rings < 3; rings++) {
        make(&p, PLANE, 1, 0);
        double *x = p.x[U * ACROSS + V];
        x[0] += 0.4;
        x[1] += 0.6 * 0.3;
        x[2] += 0.8 * 0.3;
        memcpy(p.given, p.x, sizeof p.x);
        p.options.only_worse_than = 1.01;
        p.options.rings = rings;
        smooth(&p);
        for (int i = 0; i < NODES; i++) {
            const int u = abs(i / ACROSS - U), v = abs(i % ACROSS - V), last = rings + 1;
            const int moves = memcmp(p.x[i], p.given[i], sizeof p.x[i]) != 0;
            assert_true(!moves || (u <= last && v <= last));
            assert_true(moves || u != last || v != last);
        }
        destroy(&p);
    }
}

/** Fixed nodes, bounds and ways are kept; only nodes of bad elements move if so asked. */
static void test_limits(void **unused) {
    static patchwork p;
    static uint8_t constraint[NODES], node_class[NODES];
    (void)unused;
    make(&p, TORUS, 0, 0.5);
    planish_shape_get_classes(p.shape, node_class);
    p.mesh.constraint = constraint;
    for (int i = 0; i < NODES; i += 3)
        constraint[i] = PLANISH_CONSTRAINT_FIXED;
    p.options.box_upper[2] = 0.5;
    p.options.max_displacement = 0.05;
    const uint8_t *held = find_held(&p);
    const planish_result r = smooth(&p);
    int64_t n_outside = 0;
    for (int i = 0; i < NODES; i++) {
        double square = 0;
        for (int d = 0; d < 3; d++)
            square += (p.x[i][d] - p.given[i][d]) * (p.x[i][d] - p.given[i][d]);
        assert_true(sqrt(square) <= 0.05);
        assert_true(i % 3 != 0 || square == 0);
        assert_true(p.x[i][2] <= 0.5 || square == 0);
        const int is_outside =
            p.given[i][2] > 0.5 && i % 3 != 0 && node_class[i] != PLANISH_SHAPE_CORNER;
        n_outside += is_outside;
        assert_int_equal(held[i], is_outside ? PLANISH_HELD_BY_BOUNDS : PLANISH_HELD_BY_NONE);
    }
    assert_int_equal(r.n_held_outside, n_outside);
    assert_true(r.max_displacement <= 0.05 && r.max_displacement > 0.04);
    destroy(&p);

    make(&p, TORUS, 0, 0.5);
    p.options.only_worse_than = 2;
    const planish_result few = smooth(&p);
    assert_true(few.n_moved_nodes > 0 && few.n_moved_nodes < NODES / 2);
    destroy(&p);
}

/** Counts of the caller's, who stops the run. */
typedef struct stopper {
    int calls, most;
    double objective;
    int rises;
} stopper;

static int note_progress(const planish_progress *progress, void *user) {
    stopper *s = user;
    if (progress->sweep_done) {
        s->rises += s->objective > 0 && progress->objective > s->objective;
        s->objective = progress->objective;
    }
    return ++s->calls >= s->most;
}

static void test_stops(void **unused) {
    static patchwork p;
    (void)unused;
    make(&p, TORUS, 0, 0.5);
    for (int most = 1; most < 40; most += 4) {
        stopper s = {.most = most};
        memcpy(p.x, p.given, sizeof p.x);
        p.options.progress = note_progress;
        p.options.progress_user = &s;
        assert_int_equal(smooth(&p).stop, PLANISH_STOP_INTERRUPTED);
        assert_int_equal(s.calls, most);
        assert_int_equal(s.rises, 0);
    }
    p.options.progress = NULL;
    p.options.time_limit = 1e-9;
    assert_int_equal(smooth(&p).stop, PLANISH_STOP_TIME_LIMIT);
    p.options.time_limit = 0;
    p.options.max_sweeps = 2;
    assert_int_equal(smooth(&p).stop, PLANISH_STOP_MAX_SWEEPS);
    destroy(&p);
}

/** Sheets that both could reach one another stay; others move. */
static void test_sheets(void **unused) {
    static patchwork p;
    (void)unused;
    for (int k = 0; k < 2; k++) {
        p.apart = k ? 0.2 : 0.005;
        make(&p, SHEETS, 0, 0.3);
        const uint8_t *held = find_held(&p);
        for (int i = 0; i < NODES; i++)
            assert_int_equal(held[i], k ? PLANISH_HELD_BY_NONE : PLANISH_HELD_BY_SHEET);
        const planish_result r = smooth(&p);
        assert_true(k ? r.n_moved_nodes > NODES / 2 : r.n_moved_nodes == 0);
        destroy(&p);
    }
}

static int64_t count_crossings(const patchwork *p) {
    const planish_shape *s = p->shape;
    int64_t n = 0;
    double(*x)[3] = malloc((size_t)s->n_nodes * sizeof *x);
    for (int64_t i = 0; i < s->n_nodes; i++)
        for (int d = 0; d < 3; d++)
            x[i][d] = p->x[s->node[i]][d] * s->scale;
    sheet_judge judge = sheet_judge_create(s, (const double(*)[3])x);
    for (int64_t a = 0; a < judge.n; a++)
        for (int64_t b = 0; b < a; b++)
            n += sheet_cross(&judge, s, a, b);
    sheet_judge_destroy(&judge);
    free(x);
    return n;
}

/** Sheets that do not face one another are not held; where they would cross they are. */
static void test_crossings(void **unused) {
    static patchwork p;
    (void)unused;
    p.apart = 3e-4;
    make(&p, SHAFT, 0, 0.5);
    assert_int_equal(count_crossings(&p), 0);
    const planish_result r = smooth(&p);
    assert_true(r.n_moved_nodes > NODES / 2 && r.stop == PLANISH_STOP_CONVERGED);
    assert_int_equal(count_crossings(&p), 0);
    const uint64_t bits = planish_checksum(&p.mesh);
    memcpy(p.x, p.given, sizeof p.x);
    p.options.threads = 3;
    smooth(&p);
    assert_int_equal(planish_checksum(&p.mesh), bits);
    stopper s = {.most = 50}; /* there is no time to begin anew: all stay */
    memcpy(p.x, p.given, sizeof p.x);
    p.options.progress = note_progress;
    p.options.progress_user = &s;
    const planish_result stopped = smooth(&p);
    assert_true(s.calls == 50 && stopped.stop == PLANISH_STOP_INTERRUPTED);
    assert_true(stopped.n_moved_nodes == 0 && stopped.max_displacement == 0);
    assert_memory_equal(p.x, p.given, sizeof p.x);
    destroy(&p);
}

/** Smooth with snapshots. */
static snapshots take_snapshots(patchwork *p, int threads, planish_result *result) {
    memcpy(p->x, p->given, sizeof p->x);
    snapshots taken = snapshots_begin(p->x[0], 3 * NODES);
    p->options.threads = threads;
    p->options.progress = snapshots_take;
    p->options.progress_user = &taken;
    *result = smooth(p);
    return taken;
}

/** Snapshots have the figures of progress, the last one is the result, and threads do not change them. */
static void test_snapshots(void **unused) {
    static patchwork p;
    (void)unused;
    for (int k = 0; k < 4; k++) {
        planish_result r, other;
        make(&p, k / 2 ? TUBE : TORUS, k % 2, 0.5);
        p.options.worst = k == 0 ? PLANISH_WORST_RADIUS_RATIO : PLANISH_WORST_NONE;
        snapshots one = take_snapshots(&p, 1, &r), more = take_snapshots(&p, 3, &other);
        snapshots_assert_same(&one, &more);
        assert_true(one.n == r.sweeps && one.n > 2 && one.n_refused > 0);
        for (int i = 0; i < one.n; i++) {
            planish_mesh mesh = p.mesh;
            planish_quality quality;
            mesh.coordinates = one.x[i];
            assert_int_equal(
                planish_measure_surface(p.shape, &mesh, 1, &quality, NULL, NULL, NULL, NULL), 0);
            assert_int_equal(quality.n_inverted, 0);
            assert_true(fabs(quality.rms_radius_ratio / one.figures[i].rms - 1) < 1e-9);
        }
        if (k > 0)
            assert_memory_equal(one.x[one.n - 1], p.x, sizeof p.x);
        snapshots_free(&one);
        snapshots_free(&more);
        destroy(&p);
    }
}

/** Where a run begins anew, the snapshots of its last sweeps lead to the result; they have the nodes that it
 *  holds back at their start. */
static void test_snapshots_of_runs(void **unused) {
    static patchwork p;
    (void)unused;
    planish_result r;
    p.apart = 3e-4;
    make(&p, SHAFT, 0, 0.5);
    snapshots taken = take_snapshots(&p, 1, &r);
    int n_begun = 0;
    for (int i = 1; i < taken.n; i++)
        n_begun += taken.figures[i].sweep < taken.figures[i - 1].sweep;
    assert_true(n_begun > 0);
    assert_int_equal(taken.figures[taken.n - 1].sweep, r.sweeps);
    assert_memory_equal(taken.x[taken.n - 1], p.x, sizeof p.x);
    snapshots_free(&taken);
    destroy(&p);
}

/** Nodes at a facet that starts too far off stay, and a node on a plane stays in it. */
static void test_held(void **unused) {
    static patchwork p;
    static uint8_t constraint[NODES], is_beside[NODES];
    enum { OUT = 5 * ACROSS + 5, LEVEL = 40 * ACROSS + 5 };
    (void)unused;
    make(&p, TORUS, 0, 0.3);
    p.mesh.constraint = constraint;
    static double direction[NODES][3];
    constraint[LEVEL] = PLANISH_CONSTRAINT_ON_PLANE;
    direction[LEVEL][2] = 1;
    p.mesh.direction = direction[0];
    p.x[OUT][2] += 0.3;
    memset(is_beside, 0, sizeof is_beside);
    for (int64_t f = 0; f < p.cells.n; f++) {
        const int32_t *v = p.node + 3 * f;
        if (v[0] == OUT || v[1] == OUT || v[2] == OUT)
            is_beside[v[0]] = is_beside[v[1]] = is_beside[v[2]] = 1;
    }
    memcpy(p.given, p.x, sizeof p.x);
    const uint8_t *held = find_held(&p);
    assert_memory_equal(p.x, p.given, sizeof p.x);
    for (int i = 0; i < NODES; i++)
        assert_int_equal(held[i], is_beside[i] ? PLANISH_HELD_BY_TOLERANCE : PLANISH_HELD_BY_NONE);
    planish_result r;
    assert_int_equal(planish_smooth_surface(&p.mesh, p.x[0], &p.options, &r, NULL), 0);
    assert_true(r.n_moved_nodes > NODES / 2);
    for (int i = 0; i < NODES; i++)
        assert_true(!held[i] || !memcmp(p.x[i], p.given[i], sizeof *p.x));
    assert_true(fabs(p.x[LEVEL][2] - p.given[LEVEL][2]) < 1e-12);
    destroy(&p);
}

/** Nodes of a facet that is there twice, that is the third at an edge, or that has no area stay; others
 *  move. */
static void test_bad_facets(void **unused) {
    static patchwork p;
    (void)unused;
    for (int kind = 0; kind < 3; kind++) {
        make(&p, TUBE, 0, 0.3);
        planish_shape_destroy(p.shape);
        const int64_t n = p.mesh.n_elements, middle = 3 * (n / 2);
        const int32_t *facet = p.node + middle;
        const int32_t held[3] = {facet[0], facet[1],
                                 kind == 1 ? (facet[2] + NODES / 2) % NODES : facet[2]};
        if (kind == 2) /* its third node is between the others */
            for (int d = 0; d < 3; d++)
                p.x[held[2]][d] = (p.x[held[0]][d] + p.x[held[1]][d]) / 2;
        else {
            memcpy(p.node + 3 * n, held, sizeof held);
            p.type[n] = PLANISH_CELL_TRIANGLE;
            p.offset[n + 1] = 3 * (n + 1);
            p.mesh.n_elements = p.cells.n = n + 1;
        }
        memcpy(p.given, p.x, sizeof p.x);
        assert_int_equal(planish_shape_create(&p.mesh, NULL, 1, &p.shape, NULL, NULL), 0);
        p.options.shape = p.shape;
        planish_result r;
        planish_error e = {.text = ""};
        if (planish_smooth_surface(&p.mesh, p.x[0], &p.options, &r, &e))
            fail_msg("%s", e.text);
        assert_true(r.n_moved_nodes > NODES / 2);
        for (int k = 0; k < 3; k++)
            assert_memory_equal(p.x[held[k]], p.given[held[k]], sizeof *p.x);
        destroy(&p);
    }
}

/** Moved coordinates of a kind of surface are floats. */
static void expect_floats(int kind) {
    static patchwork p;
    static uint8_t constraint[NODES];
    static double direction[NODES][3];
    planish_slide_info info;
    int n_moved = 0;
    make(&p, kind, 0, 0.5);
    for (int i = 0; i < NODES; i++)
        for (int d = 0; d < 3; d++)
            p.x[i][d] = p.given[i][d] = kind == PLANE && d == 2 ? 0 : (float)p.given[i][d];
    planish_shape_destroy(p.shape);
    assert_int_equal(planish_shape_create(&p.mesh, NULL, 1, &p.shape, NULL, NULL), 0);
    const planish_surface surface = {.shape = p.shape};
    assert_int_equal(
        planish_find_slides(&p.mesh, &surface, 1, constraint, direction[0], &info, NULL), 0);
    assert_int_equal(info.n_on_plane > 0, kind == PLANE);
    p.mesh.constraint = constraint;
    p.mesh.direction = direction[0];
    p.options.shape = p.shape;
    p.options.precision = PLANISH_PRECISION_FLOAT;
    smooth(&p);
    for (int i = 0; i < NODES; i++)
        for (int d = 0; d < 3; d++) {
            const volatile float narrow = (float)p.x[i][d];
            assert_true(p.x[i][d] == (double)narrow || p.x[i][d] == p.given[i][d]);
            n_moved += p.x[i][d] != p.given[i][d];
        }
    assert_true(n_moved > NODES / 2);
    destroy(&p);
}

/** So they are on curved patches, and on planes and lines. */
static void test_floats(void **unused) {
    (void)unused;
    expect_floats(TORUS);
    expect_floats(PLANE);
}

/* ---- refusals ------------------------------------------------------------------------------- */

static void refuse(const patchwork *p, const planish_mesh *mesh, const planish_options *options,
                   const char *part) {
    static double x[NODES][3];
    planish_error e = {0};
    memcpy(x, p->given, sizeof x);
    const int status = planish_smooth_surface(mesh, x[0], options, NULL, &e);
    assert_int_not_equal(status, PLANISH_OK);
    if (!strstr(e.text, part))
        fail_msg("'%s' lacks '%s'", e.text, part);
    assert_memory_equal(x, p->given, sizeof x);
    static uint8_t held[NODES], marked[NODES];
    memset(held, 77, sizeof held);
    memset(marked, 77, sizeof marked);
    planish_mesh here = *mesh;
    here.coordinates = x[0];
    assert_int_equal(planish_find_held_on_surface(&here, options, held, &e), status);
    assert_non_null(strstr(e.text, part));
    assert_memory_equal(held, marked, sizeof held);
}

/** Refuse what says where a node may go, but is not heard or lacks a direction. */
static void refuse_sliding(const patchwork *p, planish_mesh *mesh, uint8_t *constraint) {
    static double direction[NODES][3];
    planish_options o = p->options;
    o.project = planish_fit_project;
    refuse(p, &p->mesh, &o, "options.project");
    constraint[9] = PLANISH_CONSTRAINT_ON_PLANE;
    refuse(p, mesh, &p->options, "node 9 slides, but mesh.direction has none");
    constraint[9] = PLANISH_CONSTRAINT_ON_LINE;
    mesh->direction = direction[0];
    refuse(p, mesh, &p->options, "node 9 slides, but mesh.direction has none");
}

/** Refuse a shape of other elements between the same nodes, and of more. */
static void refuse_others(patchwork *p) {
    planish_mesh mesh = p->mesh;
    planish_cells cells = p->cells;
    const int32_t first = p->node[6];
    p->node[6] = p->node[40];
    refuse(p, &mesh, &p->options, "it has other ones from element 2 on");
    p->node[6] = first;
    cells.n = mesh.n_elements = p->cells.n - 1;
    mesh.cells = &cells;
    refuse(p, &mesh, &p->options, "it has more of them");
}

static void test_refusals(void **unused) {
    static patchwork p, other;
    (void)unused;
    make(&p, TORUS, 0, 0.5);
    refuse(&p, &p.mesh, NULL, "options.shape is the surface");
    planish_options o = p.options;
    o.shape = NULL;
    refuse(&p, &p.mesh, &o, "planish_shape_create");
    o = p.options;
    o.method = PLANISH_METHOD_LAPLACIAN;
    refuse(&p, &p.mesh, &o, "options.method");
    o = p.options;
    o.objective = PLANISH_OBJECTIVE_EDGE_RATIO;
    refuse(&p, &p.mesh, &o, "EDGE_RATIO");
    o = p.options;
    o.min_volume = 1;
    refuse(&p, &p.mesh, &o, "min_volume");
    o = p.options;
    o.worst = PLANISH_WORST_SCALED_JACOBIAN;
    refuse(&p, &p.mesh, &o, "RADIUS_RATIO or _ANGLE");
    o = p.options;
    o.threads = -1;
    refuse(&p, &p.mesh, &o, "options.threads");
    static double upper[NODES][3];
    upper[7][2] = NAN;
    o = p.options;
    o.upper = upper[0];
    refuse(&p, &p.mesh, &o, "options.upper of node 7");
    static uint8_t constraint[NODES];
    constraint[9] = 7;
    planish_mesh mesh = p.mesh;
    mesh.constraint = constraint;
    refuse(&p, &mesh, &p.options, "mesh.constraint of node 9");
    refuse_sliding(&p, &mesh, constraint);
    refuse_others(&p);
    mesh = p.mesh;
    mesh.n_nodes = NODES - 1;
    refuse(&p, &mesh, &p.options, "node");
    mesh = p.mesh;
    mesh.cells = NULL;
    refuse(&p, &mesh, &p.options, "mesh");
    make(&other, TORUS, 1, 0.5);
    o = other.options;
    o.worst = PLANISH_WORST_ANGLE;
    refuse(&other, &other.mesh, &o, "SCALED_JACOBIAN");
    p.given[5][1] = NAN;
    refuse(&p, &p.mesh, &p.options, "5");
    const double *const target = p.mesh.coordinates;
    const uint8_t is_layer = 1;
    mesh = p.mesh;
    mesh.size = target;
    refuse(&p, &mesh, &p.options, "leave out mesh.size");
    mesh.size = NULL;
    mesh.metric = target;
    refuse(&p, &mesh, &p.options, "leave out mesh.metric");
    mesh.metric = NULL;
    mesh.reference = target;
    refuse(&p, &mesh, &p.options, "leave out mesh.reference");
    mesh.is_layer = &is_layer;
    refuse(&p, &mesh, &p.options, "leave out mesh.is_layer");
    destroy(&other);
    destroy(&p);
}

/** A call that lacks memory, wherever that is, leaves the coordinates as they were. */
static void test_memory(void **unused) {
    static patchwork p;
    int64_t n = 0;
    (void)unused;
    make(&p, TORUS, 0, 0.5);
    p.options.max_sweeps = 2;
    p.options.worst = PLANISH_WORST_ANGLE;
    for (int status = PLANISH_ERROR_MEMORY; status; n += effort_step(7)) {
        planish_error e;
        memcpy(p.x, p.given, sizeof p.x);
        allocations_permit(n);
        status = planish_smooth_surface(&p.mesh, p.x[0], &p.options, NULL, &e);
        allocations_permit(-1);
        assert_true(status == PLANISH_OK || status == PLANISH_ERROR_MEMORY);
        if (status)
            assert_memory_equal(p.x, p.given, sizeof p.x);
    }
    assert_true(n > 20);
    memcpy(p.x, p.given, sizeof p.x);
    n = 0;
    for (int status = PLANISH_ERROR_MEMORY; status; n += effort_step(7)) {
        static uint8_t held[NODES];
        memset(held, 77, sizeof held);
        allocations_permit(n);
        status = planish_find_held_on_surface(&p.mesh, &p.options, held, NULL);
        allocations_permit(-1);
        assert_true(status == PLANISH_OK || status == PLANISH_ERROR_MEMORY);
        for (int i = 0; i < NODES; i++)
            assert_int_equal(held[i], status ? 77 : PLANISH_HELD_BY_NONE);
    }
    assert_true(n > 20);
    destroy(&p);
}

/** Measures are those of plain formulas; elements that turn over are inverted, and nothing else is measured. */
static void surfaces_are_measured(void **state) {
    static patchwork p;
    planish_quality quality;
    planish_cell_quality cells;
    static double ratio[MOST];
    static uint8_t states[MOST];
    const planish_cell_values values = {.state = states};
    (void)state;
    for (int has_quads = 0; has_quads < 2; has_quads++) {
        make(&p, TUBE, has_quads, 0.4);
        const worst w = look(&p, (const double(*)[3])p.x);
        planish_error e;
        if (planish_measure_surface(p.shape, &p.mesh, 2, &quality, ratio, &cells, &values, &e))
            fail_msg("%s", e.text);
        double most = 0;
        for (int64_t i = 0; i < p.cells.n; i++) {
            most = fmax(most, ratio[i]);
            assert_int_equal(states[i], PLANISH_CELL_STATE_VALID);
        }
        assert_int_equal(quality.n_inverted, 0);
        assert_true(most == ratio[quality.worst_element]);
        assert_true(fabs(quality.max_radius_ratio / most - 1) < 1e-14);
        assert_true(quality.n_fixed_elements == 0 && quality.total_volume > 0);
        assert_int_equal(cells.all.n_elements, p.cells.n);
        assert_int_equal(cells.n_types, 1);
        if (!has_quads) {
            assert_true(fabs(quality.max_radius_ratio / w.ratio - 1) < 1e-9);
            assert_true(fabs(quality.min_angle_deg - w.angle * (180 / 3.14159265358979323846)) <
                        1e-9);
        } else {
            assert_true(fabs(cells.all.min_scaled_jacobian - sin(w.angle)) < 1e-9);
            assert_true(fabs(cells.all.max_aspect_ratio / most - 1) < 1e-12);
        }
        /* A node beyond the far side of its elements turns some over. */
        for (int d = 0; d < 3; d++)
            p.x[5 * ACROSS + 5][d] += 3 * (p.x[5 * ACROSS + 6][d] - p.x[5 * ACROSS + 5][d]);
        assert_int_equal(
            planish_measure_surface(p.shape, &p.mesh, 1, &quality, ratio, &cells, &values, &e), 0);
        assert_true(quality.n_inverted > 0 && quality.n_inverted == cells.all.n_inverted);
        int64_t n = 0;
        for (int64_t i = 0; i < p.cells.n; i++) {
            n += states[i] == PLANISH_CELL_STATE_INVERTED;
            assert_int_equal(states[i] == PLANISH_CELL_STATE_INVERTED, ratio[i] == 0);
        }
        assert_int_equal(n, quality.n_inverted);
        assert_int_equal(planish_measure_surface(NULL, &p.mesh, 1, &quality, NULL, NULL, NULL, &e),
                         PLANISH_ERROR_ARGUMENT);
        const int32_t first = p.node[0];
        p.node[0] = p.node[40];
        assert_int_equal(
            planish_measure_surface(p.shape, &p.mesh, 1, &quality, NULL, NULL, NULL, &e),
            PLANISH_ERROR_ARGUMENT);
        p.node[0] = first;
        destroy(&p);
    }
}

/** Whichever allocation of a measurement fails, the call says so, and without failure nothing is different. */
static void measurement_without_memory_says_so(void **state) {
    static patchwork p;
    planish_quality quality, same;
    planish_cell_quality cells;
    planish_error e;
    int n = 0;
    (void)state;
    make(&p, TUBE, 1, 0.4);
    assert_int_equal(planish_measure_surface(p.shape, &p.mesh, 1, &quality, NULL, &cells, NULL, &e),
                     0);
    for (int status = 1; status; n++) {
        allocations_fail_one(n);
        status = planish_measure_surface(p.shape, &p.mesh, 1, &same, NULL, &cells, NULL, &e);
        assert_int_equal(status, allocations_failed() ? PLANISH_ERROR_MEMORY : 0);
    }
    allocations_permit(-1);
    assert_true(n > 10);
    assert_true(same.total_volume == quality.total_volume);
    assert_true(same.max_radius_ratio == quality.max_radius_ratio);
    destroy(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surfaces_are_measured),
        cmocka_unit_test(measurement_without_memory_says_so),
        cmocka_unit_test(test_quality),
        cmocka_unit_test(test_plane),
        cmocka_unit_test(test_same_bits),
        cmocka_unit_test(test_worst),
        cmocka_unit_test(test_rings),
        cmocka_unit_test(test_colours),
        cmocka_unit_test(test_limits),
        cmocka_unit_test(test_stops),
        cmocka_unit_test(test_sheets),
        cmocka_unit_test(test_crossings),
        cmocka_unit_test(test_snapshots),
        cmocka_unit_test(test_snapshots_of_runs),
        cmocka_unit_test(test_held),
        cmocka_unit_test(test_bad_facets),
        cmocka_unit_test(test_floats),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
