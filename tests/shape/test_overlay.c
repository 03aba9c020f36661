/* Overlays: bounds of distances against dense samples and brute force. */
#include "support/effort.h"
#include "support/sheets.h"

#include "shape/disc.h"
#include "shape/distance.h"
#include "shape/fan.h"
#include "shape/overlay.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { DIVISIONS = 8, MOST_RATIOS = 1 << 16 };

/** A sheet whose nodes have moved. */
typedef struct moved {
    planish_shape *shape;
    double (*x)[3];
    pl_place *place;
    sheet_judge first, now;
} moved;

static moved move_sheet(planish_shape *shape, double far, double off, double share,
                        uint64_t *state) {
    moved m = {.shape = shape};
    m.x = malloc((size_t)shape->n_nodes * sizeof *m.x);
    m.place = malloc((size_t)shape->n_nodes * sizeof *m.place);
    sheet_move(shape, far, off, share, state, m.x, m.place);
    m.first = sheet_judge_create(shape, (const double(*)[3])shape->x);
    m.now = sheet_judge_create(shape, (const double(*)[3])m.x);
    return m;
}

static void release(moved *m) {
    sheet_judge_destroy(&m->first);
    sheet_judge_destroy(&m->now);
    planish_shape_destroy(m->shape);
    free(m->x);
    free(m->place);
}

static pl_moved_facet facet_of(const moved *m, int32_t facet) {
    pl_moved_facet t = {.facet = facet};
    for (int k = 0; k < 3; k++) {
        const int32_t node = m->shape->facet[facet][k];
        memcpy(t.x[k], m->x[node], sizeof t.x[k]);
        t.place[k] = m->place[node];
    }
    return t;
}

static int compare_doubles(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

/* ---- random sheets -------------------------------------------------------------------------- */

/** What the bounds of facets were worth. */
typedef struct worth {
    int64_t n, n_bounded, n_ratios;
    double *ratio; /* [n_ratios] of the bound and the largest sample */
} worth;

/** Check the bound of one facet. */
static void check_facet(const moved *m, int32_t facet, uint64_t *state, worth *w) {
    const planish_shape *s = m->shape;
    pl_moved_facet t = facet_of(m, facet);
    for (int k = 0; k < 3; k++)
        if (random_unit(state) < 0.2)
            t.place[k].at = -1;
    const double lateral = pl_overlay_lateral(s, &t);
    const double bound = pl_overlay_bound(s, &t, lateral, INFINITY);
    const double most =
        sheet_judge_sample(&m->first, s->patch[facet], (const double(*)[3])t.x, DIVISIONS);
    w->n++;
    if (!(bound < INFINITY))
        return;
    w->n_bounded++;
    if (most > bound * (1 + 1e-12) + 1e-14 * (1 + s->size)) /* the samples' rounding */
        fail_msg("facet %d: %.17g off, bound %.17g", facet, most, bound);
    if (most > 1e-4 * s->edge_length[s->facet[facet][0]] && w->n_ratios < MOST_RATIOS)
        w->ratio[w->n_ratios++] = bound / most;
    /* A limit changes nothing but what is above it. */
    assert_true(pl_overlay_bound(s, &t, lateral, bound) == bound);
    assert_true(pl_overlay_bound(s, &t, lateral, bound * 0.9) >= bound * 0.9);
}

static worth check_kind(int kind, int64_t n, double far, double off) {
    uint64_t state = effort_seed((uint64_t)(kind + 1));
    worth w = {.ratio = malloc(MOST_RATIOS * sizeof(double))};
    for (int64_t i = 0; i < n; i++) {
        const double share = i % 3 ? 1 : 0.3;
        const double up = off * random_unit(&state), along = far * random_unit(&state);
        moved m = move_sheet(sheet_create(kind, &state), along, up, share, &state);
        for (int32_t f = 0; f < m.shape->n_facets; f++)
            check_facet(&m, f, &state, &w);
        release(&m);
    }
    qsort(w.ratio, (size_t)w.n_ratios, sizeof *w.ratio, compare_doubles);
    return w;
}

/** Whether bounds are worth something: of nodes that moved little most facets have one, and it is near
 *  the largest sample where the sheet is smooth. */
static void check_worth(int kind, const worth *w) {
    const int is_smooth = kind == SHEET_BUMPS || kind == SHEET_SPHERE || kind == SHEET_TUBE;
    assert_true((double)w->n_bounded >= (is_smooth ? 0.95 : 0.6) * (double)w->n);
    assert_true(w->n_ratios > 0);
    assert_true(w->ratio[w->n_ratios / 2] <= (is_smooth ? 1.1 : 1.2));
}

static void samples_are_never_beyond_the_bound(void **unused) {
    (void)unused;
    for (int kind = 0; kind < SHEET_KINDS; kind++)
        for (int far = 0; far < 2; far++) {
            worth w = check_kind(kind, effort(20, 500), far ? 2 : 0.5, far ? 0.3 : 0.05);
            figure("sheets of kind %d, moved %s: %lld of %lld facets bounded, bound / samples %.3f",
                   kind, far ? "far" : "near", (long long)w.n_bounded, (long long)w.n,
                   w.n_ratios ? w.ratio[w.n_ratios / 2] : 1);
            if (!far)
                check_worth(kind, &w);
            free(w.ratio);
        }
}

/* ---- discs ---------------------------------------------------------------------------------- */

/** Bound a facet by the disc of a node; infinite: it does not tell. */
static double disc_bound(const planish_shape *s, int32_t node, const pl_disc *disc,
                         const pl_moved_facet *t) {
    pl_disc_frame frame;
    pl_disc_point p[3];
    pl_disc_set_frame(s, node, disc, &frame);
    for (int k = 0; k < 3; k++)
        if (!pl_disc_see(&frame, t->x[k], &p[k]))
            return INFINITY;
    return pl_disc_bound(&frame, &p[0], &p[1], &p[2]);
}

/** Check a bound of a facet, infinite if there is none, and take it into the worth in units of edge. */
static void check_sample(const moved *m, const pl_moved_facet *t, double bound, double edge,
                         worth *w) {
    const planish_shape *s = m->shape;
    w->n++;
    if (!(bound < INFINITY))
        return;
    const double most =
        sheet_judge_sample(&m->first, s->patch[t->facet], (const double(*)[3])t->x, DIVISIONS);
    w->n_bounded++;
    if (most > bound * (1 + 1e-12) + 1e-14 * (1 + s->size))
        fail_msg("facet %d: %.17g off, bound %.17g", t->facet, most, bound);
    if (w->n_ratios < MOST_RATIOS)
        w->ratio[w->n_ratios++] = bound / edge;
}

/** Check the facets at a node by its disc. */
static void check_disc(const moved *m, int32_t node, worth *w) {
    const planish_shape *s = m->shape;
    pl_disc disc;
    pl_disc_find(s, node, &disc);
    for (int64_t i = s->offset[node]; i < s->offset[node + 1]; i++) {
        const int32_t f = s->facet_of[i];
        const pl_moved_facet t = facet_of(m, f);
        const double bound = disc.radius2 > 0 ? disc_bound(s, node, &disc, &t) : INFINITY;
        check_sample(m, &t, bound, s->edge_length[node], w);
    }
}

static void samples_are_never_beyond_the_bound_of_a_disc(void **unused) {
    (void)unused;
    for (int kind = 0; kind < SHEET_KINDS; kind++) {
        uint64_t state = effort_seed((uint64_t)(kind + 101));
        worth w = {.ratio = malloc(MOST_RATIOS * sizeof(double))};
        for (int64_t i = 0; i < effort(20, 500); i++) {
            const double off = 0.1 * random_unit(&state), far = 0.5 * random_unit(&state);
            moved m = move_sheet(sheet_create(kind, &state), far, off, 1, &state);
            for (int32_t node = 0; node < m.shape->n_nodes; node++)
                if (m.shape->node_class[node] == PL_ON_PATCH)
                    check_disc(&m, node, &w);
            release(&m);
        }
        qsort(w.ratio, (size_t)w.n_ratios, sizeof *w.ratio, compare_doubles);
        figure("sheets of kind %d: %lld of %lld facets bounded by discs, half of them within "
               "%.3f edges",
               kind, (long long)w.n_bounded, (long long)w.n,
               w.n_ratios ? w.ratio[w.n_ratios / 2] : 0);
        if (kind == SHEET_BUMPS) {
            assert_true(3 * w.n_bounded >= w.n);
            assert_true(w.ratio[w.n_ratios / 2] <= 0.1);
        }
        free(w.ratio);
    }
}

/* ---- fans ----------------------------------------------------------------------------------- */

/** Check the facets of a sheet by the fans of their corners. */
static void check_fans(const moved *m, worth *w) {
    const planish_shape *s = m->shape;
    pl_fan *fan = malloc((size_t)s->n_nodes * sizeof *fan);
    for (int32_t node = 0; node < s->n_nodes; node++)
        pl_fan_find(s, node, &fan[node]);
    for (int32_t f = 0; f < s->n_facets; f++) {
        const pl_moved_facet t = facet_of(m, f);
        const double bound = pl_fan_bound(s, fan, &t);
        check_sample(m, &t, bound, s->edge_length[s->facet[f][0]], w);
    }
    free(fan);
}

static void samples_are_never_beyond_the_bound_of_fans(void **unused) {
    (void)unused;
    for (int kind = 0; kind < SHEET_KINDS; kind++) {
        uint64_t state = effort_seed((uint64_t)(kind + 201));
        worth w = {.ratio = malloc(MOST_RATIOS * sizeof(double))};
        for (int64_t i = 0; i < effort(40, 1000); i++) {
            const double off = i % 2 ? 0 : 0.1 * random_unit(&state);
            moved m = move_sheet(sheet_create(kind, &state), random_unit(&state), off, 1, &state);
            check_fans(&m, &w);
            release(&m);
        }
        qsort(w.ratio, (size_t)w.n_ratios, sizeof *w.ratio, compare_doubles);
        figure("sheets of kind %d: %lld of %lld facets bounded by fans, half of them within %.1e "
               "edges",
               kind, (long long)w.n_bounded, (long long)w.n,
               w.n_ratios ? w.ratio[w.n_ratios / 2] : 0);
        if (kind == SHEET_PLANE || kind == SHEET_BUMPS)
            assert_true(20 * w.n_bounded >= w.n);
        if (kind == SHEET_PLANE) /* half of them move within it */
            assert_true(w.ratio[w.n_ratios / 3] <= 1e-6);
        free(w.ratio);
    }
}

/* ---- curves --------------------------------------------------------------------------------- */

/** Distance of a point from the features, whose nodes are at x. */
static double from_features(const planish_shape *s, const double (*x)[3], const double p[3]) {
    double least = INFINITY;
    for (int64_t e = 0; e < s->n_edges; e++)
        least = fmin(least, sheet_from_segment(x[s->edge[e][0]], x[s->edge[e][1]], p));
    return least;
}

/** Largest distance of points between a and b from the features. */
static double sample_edge(const planish_shape *s, const double (*x)[3], const double a[3],
                          const double b[3]) {
    double most = 0, p[3];
    for (int i = 0; i <= DIVISIONS; i++) {
        for (int d = 0; d < 3; d++)
            p[d] = (i * a[d] + (DIVISIONS - i) * b[d]) / DIVISIONS;
        most = fmax(most, from_features(s, x, p));
    }
    return most;
}

static void edges_on_curves_are_no_farther_off_than_lateral(void **unused) {
    (void)unused;
    static const int KIND[] = {SHEET_PLANE, SHEET_CREASE, SHEET_TUBE, SHEET_MOEBIUS};
    uint64_t state = effort_seed(77);
    int64_t n_curves = 0;
    for (int64_t i = 0; i < effort(60, 2000); i++) {
        const double off = 0.05 * random_unit(&state), far = 0.5 * random_unit(&state);
        moved m = move_sheet(sheet_create(KIND[i % 4], &state), far, off, 1, &state);
        const planish_shape *s = m.shape;
        double laterals = 0, chords = 0, chains = 0;
        for (int32_t f = 0; f < s->n_facets; f++) {
            pl_moved_facet t = facet_of(&m, f);
            double most = 0;
            for (int k = 0; k < 3; k++) {
                if (s->across[f][k] < 0)
                    most = fmax(most,
                                sample_edge(s, (const double(*)[3])s->x, t.x[k], t.x[(k + 1) % 3]));
                if (s->node_class[s->facet[f][k]] == PL_ON_CURVE)
                    most = fmax(most, from_features(s, (const double(*)[3])s->x, t.x[k]));
            }
            const double lateral = pl_overlay_lateral(s, &t);
            assert_true(lateral < INFINITY);
            assert_true(most <= lateral * (1 + 1e-12) + 1e-14 * (1 + s->size));
            t.place[i % 3].at = -1;
            assert_true(most <= pl_overlay_lateral(s, &t) * (1 + 1e-12) + 1e-14 * (1 + s->size));
            laterals = fmax(laterals, lateral);
            chords = fmax(chords, most);
        }
        for (int64_t e = 0; e < s->n_edges; e++)
            chains = fmax(chains, sample_edge(s, (const double(*)[3])m.x, s->x[s->edge[e][0]],
                                              s->x[s->edge[e][1]]));
        assert_true(chains <= laterals * (1 + 1e-12) + 1e-14 * (1 + s->size));
        assert_true(laterals <= 3 * fmax(chains, chords) + 1e-14 * (1 + s->size));
        n_curves += laterals > 0;
        release(&m);
    }
    assert_true(n_curves >= effort(60, 2000) / 2);
}

/* ---- surfaces that do not cover ------------------------------------------------------------- */

enum { ROW = 5 };

/** A sheet of rows of edges, y = -2 .. 2, along a line of n points in the plane of x and z. */
static planish_shape *sheet_along(int n, const double (*point)[2]) {
    double x[128][3];
    int32_t facet[256][3];
    int n_facets = 0;
    for (int i = 0; i < ROW * n; i++) {
        x[i][0] = point[i / ROW][0];
        x[i][1] = i % ROW - 2;
        x[i][2] = point[i / ROW][1];
    }
    for (int i = 0; i + 1 < n; i++)
        for (int j = 0; j + 1 < ROW; j++) {
            const int32_t a = ROW * i + j;
            const int32_t node[2][3] = {{a, a + ROW, a + ROW + 1}, {a, a + ROW + 1, a + 1}};
            memcpy(facet[n_facets], node, sizeof node);
            n_facets += 2;
        }
    return sheet_of(ROW * n, (const double(*)[3])x, n_facets, (const int32_t(*)[3])facet, 0, NULL);
}

/** The bound of a facet without features when its corners are at x, in the units that the shape was
 *  made in. */
static double bound_at(const planish_shape *s, const double (*x)[3]) {
    pl_moved_facet t = {.facet = 0, .place = {{-1, {0}}, {-1, {0}}, {-1, {0}}}};
    for (int32_t f = 0, n = 0; n < 3; t.facet = f++) {
        assert_true(f < s->n_facets);
        for (n = 0; n < 3 && s->node_class[s->facet[f][n]] == PL_ON_PATCH; n++)
            ;
    }
    for (int k = 0; k < 3; k++)
        for (int d = 0; d < 3; d++)
            t.x[k][d] = x[k][d] * s->scale;
    return pl_overlay_bound(s, &t, 0, INFINITY) / s->scale;
}

/** The same, at a height where the facet is a right angle of sides of 0.75 around x and y. */
static double bound_over(const planish_shape *s, double x, double y, double z) {
    const double corner[3][3] = {
        {x - 0.25, y - 0.25, z}, {x + 0.5, y - 0.25, z}, {x - 0.25, y + 0.5, z}};
    return bound_at(s, corner);
}

static void a_border_under_a_triangle_is_noticed(void **unused) {
    (void)unused;
    const double flat[4][2] = {{0, 0}, {1, 0}, {2, 0}, {3, 0}};
    planish_shape *s = sheet_along(4, flat);
    assert_true(fabs(bound_over(s, 0.5, 0, 0.125) - 0.125) < 1e-12);
    assert_true(fabs(bound_over(s, 2.4, 0, 0.125) - 0.125) < 1e-12); /* far from where it was */
    assert_true(bound_over(s, 0.1, 0, 0.125) == INFINITY);
    assert_true(bound_over(s, 2.6, 0, 0.125) == INFINITY);
    assert_true(bound_over(s, 1, 1.6, 0.125) == INFINITY);
    planish_shape_destroy(s);
}

static void a_disc_ends_at_a_border(void **unused) {
    (void)unused;
    const double flat[5][2] = {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}};
    planish_shape *s = sheet_along(5, flat);
    for (int32_t node = 0; node < s->n_nodes; node++) {
        pl_disc disc;
        if (s->node_class[node] != PL_ON_PATCH)
            continue;
        pl_disc_find(s, node, &disc);
        const double x = s->x[node][0] / s->scale, y = s->x[node][1] / s->scale;
        const double to_border = fmin(fmin(x, 4 - x), fmin(y + 2, 2 - y));
        const double radius = sqrt((double)disc.radius2) / s->scale;
        assert_true(radius <= to_border && radius >= fmin(to_border, 1.5) * (1 - 1e-5));
        assert_true(disc.highest - disc.lowest < 1e-9 * s->scale);
    }
    planish_shape_destroy(s);
}

static void a_fold_under_a_triangle_is_noticed(void **unused) {
    (void)unused;
    enum { FLAT = 3, BENDS = 8 };
    double line[FLAT + BENDS + 3][2];
    for (int i = 0; i < FLAT; i++) {
        line[i][0] = i;
        line[i][1] = 0;
    }
    for (int i = 1; i <= BENDS; i++) { /* half a circle, and back underneath */
        const double a = acos(-1.) * i / BENDS;
        line[FLAT - 1 + i][0] = 2 + 0.4 * sin(a);
        line[FLAT - 1 + i][1] = 0.4 * cos(a) - 0.4;
    }
    for (int i = 0; i < 3; i++) {
        line[FLAT + BENDS + i][0] = 1 - i;
        line[FLAT + BENDS + i][1] = -0.8;
    }
    planish_shape *s = sheet_along(FLAT + BENDS + 3, (const double(*)[2])line);
    assert_true(s->patch[0] == s->patch[s->n_facets - 1]);
    assert_true(fabs(bound_over(s, 0.5, 0, 0.125) - 0.125) < 1e-12);
    assert_true(bound_over(s, 1.8, 0, 0) < 0.4); /* the round end begins below */
    assert_true(bound_over(s, 2, 0, 0) == INFINITY);
    assert_true(bound_over(s, 2.2, 0, -0.8) == INFINITY);
    pl_disc disc;
    pl_disc_find(s, 2 * ROW + 2,
                 &disc); /* at x = 2, y = 0 the sheet goes on to 2.4, and back below */
    const double radius = sqrt((double)disc.radius2) / s->scale;
    assert_true(radius > 0.1 && radius < 0.5);
    planish_shape_destroy(s);
}

static void a_steep_triangle_has_no_bound(void **unused) {
    (void)unused;
    const double flat[4][2] = {{0, 0}, {1, 0}, {2, 0}, {3, 0}};
    planish_shape *s = sheet_along(4, flat);
    const double slope[2] = {4, 6}; /* cosines 0.24 and 0.16 */
    for (int i = 0; i < 2; i++) {
        const double corner[3][3] = {
            {1, -0.2, -slope[i] * 0.01}, {1.02, -0.2, slope[i] * 0.01}, {1.01, 0.2, 0}};
        assert_true((bound_at(s, corner) < INFINITY) == (i == 0));
    }
    planish_shape_destroy(s);
}

/** A fan goes around its node twice, so that each sheet of it may hide what the other one lacks. */
static void two_sheets_over_a_triangle_are_noticed(void **unused) {
    (void)unused;
    enum { N = 12 };
    double x[2 * N + 1][3] = {{0}};
    int32_t facet[3 * N][3];
    for (int i = 0; i < N; i++)
        for (int j = 0; j < 2; j++) {
            const double a = 4 * acos(-1.) * i / N;
            double *p = x[1 + 2 * i + j];
            p[0] = (j + 1) * cos(a);
            p[1] = (j + 1) * sin(a);
            p[2] = (j + 1) * 0.05 * sin(a / 2);
        }
    for (int i = 0; i < N; i++) {
        const int32_t a = 1 + 2 * i, b = 1 + 2 * ((i + 1) % N);
        const int32_t node[3][3] = {{0, a, b}, {a, a + 1, b + 1}, {a, b + 1, b}};
        memcpy(facet[3 * i], node, sizeof node);
    }
    planish_shape *s =
        sheet_of(2 * N + 1, (const double(*)[3])x, 3 * N, (const int32_t(*)[3])facet, 0, NULL);
    const double near[3][3] = {{-0.3, -0.2, 0}, {0.5, 0, 0}, {0.3, 0.4, 0}};
    assert_true(bound_at(s, near) == INFINITY);
    planish_shape_destroy(s);
}

static void corners_that_moved_are_off(void **unused) {
    (void)unused;
    const double flat[4][2] = {{0, 0}, {1, 0}, {2, 0}, {3, 0}};
    planish_shape *s = sheet_along(4, flat);
    pl_moved_facet t = {.facet = 0, .place = {{-1, {0}}, {-1, {0}}, {-1, {0}}}};
    for (int k = 0; k < 3; k++)
        memcpy(t.x[k], s->x[s->facet[0][k]], sizeof t.x[k]);
    assert_true(pl_overlay_lateral(s, &t) == 0);
    assert_true(pl_overlay_bound(s, &t, 0, INFINITY) == 0);
    t.x[0][2] += 0.125; /* the first node is a corner */
    assert_true(pl_overlay_lateral(s, &t) == 0.125);
    planish_shape_destroy(s);
}

/* ---- planes --------------------------------------------------------------------------------- */

static void facets_in_a_plane_are_exact(void **unused) {
    (void)unused;
    uint64_t state = effort_seed(5);
    int64_t n = 0;
    for (int64_t i = 0; i < effort(40, 1000); i++) {
        moved m = move_sheet(sheet_create(SHEET_PLANE, &state), 0.4, 0, 1, &state);
        const planish_shape *s = m.shape;
        for (int32_t f = 0; f < s->n_facets; f++) {
            int is_inside = 1;
            for (int k = 0; k < 3; k++)
                is_inside &= s->node_class[s->facet[f][k]] == PL_ON_PATCH;
            const pl_moved_facet t = facet_of(&m, f);
            const double bound = pl_overlay_bound(s, &t, 0, INFINITY);
            if (!is_inside || bound == INFINITY)
                continue;
            double v[2][3], normal[3], longest = 0;
            for (int k = 0; k < 3; k++)
                longest = fmax(longest, pl_distance(3, t.x[k], t.x[(k + 1) % 3]));
            pl_subtract(3, t.x[1], t.x[0], v[0]);
            pl_subtract(3, t.x[2], t.x[0], v[1]);
            pl_cross(v[0], v[1], normal);
            assert_true(bound * pl_length(normal) <= 1e-12 * s->size * longest * longest);
            n++;
        }
        release(&m);
    }
    assert_true(n > effort(40, 1000));
}

/* ---- whole surfaces ------------------------------------------------------------------------- */

/** Check the measure of a moved sheet. Returns the larger one of both ways, in units of the largest
 *  sample; 0: there is none. */
static double check_measure(const moved *m) {
    const planish_shape *s = m->shape;
    const double rounding = 1e-14 * (1 + s->size);
    pl_shape_distance d, other;
    planish_error error;
    double there = 0, back = 0, sharpest = 1;
    assert_int_equal(pl_shape_measure(s, (const double(*)[3])m->x, m->place, 1, &d, &error), 0);
    for (int threads = 2; threads <= 3; threads++) {
        assert_int_equal(
            pl_shape_measure(s, (const double(*)[3])m->x, m->place, threads, &other, &error), 0);
        assert_memory_equal(&d, &other, sizeof d);
    }
    assert_int_equal(d.n_unproved, 0);
    for (int32_t f = 0; f < s->n_facets; f++) {
        const double h = pl_shape_edge(s, f);
        const double now = sheet_judge_sample(&m->first, s->patch[f],
                                              (const double(*)[3])m->now.corner[f], DIVISIONS);
        const double was = sheet_judge_sample(&m->now, s->patch[f],
                                              (const double(*)[3])m->first.corner[f], DIVISIONS);
        assert_true(now <= d.there_h * h * (1 + 1e-12) + rounding);
        assert_true(was <= d.back_h * h * (1 + 1e-12) + rounding);
        there = fmax(there, now);
        back = fmax(back, was);
        for (int k = 0; k < 3; k++)
            if (s->across[f][k] >= 0)
                sharpest = fmin(sharpest, sheet_cosine(&m->now, f, s->across[f][k]));
    }
    assert_true(there <= d.there * (1 + 1e-12) + rounding);
    assert_true(back <= d.back * (1 + 1e-12) + rounding);
    assert_true(fabs(sharpest - d.sharpest) < 1e-9);
    const double most = fmax(there, back);
    return most > 1e-6 * s->size ? fmax(d.there, d.back) / most : 0;
}

static void a_measure_holds_both_ways(void **unused) {
    (void)unused;
    uint64_t state = effort_seed(6);
    const int64_t n = effort(100, 2000);
    double *ratio = malloc((size_t)n * sizeof *ratio);
    int64_t n_ratios = 0;
    for (int64_t i = 0; i < n; i++) {
        const int kind = (int)(i % SHEET_KINDS);
        moved m = move_sheet(sheet_create(kind, &state), (i / SHEET_KINDS % 2 ? 0.3 : 1.5), 0.05,
                             random_unit(&state), &state);
        if (i % 4 == 0)
            for (int64_t node = 0; node < m.shape->n_nodes; node++)
                m.place[node].at = -1;
        const double r = check_measure(&m);
        if (r > 0)
            ratio[n_ratios++] = r;
        release(&m);
    }
    qsort(ratio, (size_t)n_ratios, sizeof *ratio, compare_doubles);
    figure("surfaces both ways: bound / samples %.3f in the middle, %.3f at most",
           ratio[n_ratios / 2], ratio[n_ratios - 1]);
    assert_true(n_ratios > n / 2);
    assert_true(ratio[n_ratios / 2] < 1.1);
    free(ratio);
}

static void a_surface_that_stays_is_not_off(void **unused) {
    (void)unused;
    uint64_t state = effort_seed(8);
    moved m = move_sheet(sheet_create(SHEET_BUMPS, &state), 0, 0, 0, &state);
    pl_shape_distance d;
    planish_error error;
    assert_int_equal(pl_shape_measure(m.shape, (const double(*)[3])m.x, m.place, 1, &d, &error), 0);
    assert_true(d.there == 0 && d.back == 0 && d.there_h == 0 && d.back_h == 0);
    assert_int_equal(d.n_unproved, 0);
    m.x[3][1] = NAN;
    assert_int_equal(pl_shape_measure(m.shape, (const double(*)[3])m.x, m.place, 1, &d, &error), 0);
    assert_true(d.there == INFINITY && d.back == INFINITY);
    assert_int_equal(d.n_unproved, 2 * m.shape->n_facets);
    release(&m);
}

/** The surface of a mesh in units of its own, with gaps between its coordinates. */
static void a_mesh_is_measured_in_its_own_units(void **unused) {
    (void)unused;
    uint64_t state = effort_seed(9);
    moved m = move_sheet(sheet_create(SHEET_SPHERE, &state), 0.2, 0.02, 1, &state);
    const int64_t n = m.shape->n_nodes;
    const planish_mesh mesh = {.dim = 3, .n_nodes = n, .node_stride = 1, .component_stride = n};
    double *x = malloc((size_t)n * 3 * sizeof *x);
    for (int64_t i = 0; i < n; i++)
        for (int d = 0; d < 3; d++) {
            m.place[i].at = -1;
            x[m.shape->node[i] + d * n] = m.x[i][d] / m.shape->scale;
        }
    planish_mesh given = mesh;
    given.coordinates = x;
    planish_shape_distance public = {.distance = 0};
    pl_shape_distance d;
    planish_error error;
    assert_int_equal(pl_shape_measure(m.shape, (const double(*)[3])m.x, m.place, 1, &d, &error), 0);
    assert_int_equal(planish_shape_measure(m.shape, &given, 2, &public, &error), 0);
    assert_true(public.distance == d.there / m.shape->scale && public.in_edges == d.there_h);
    assert_true(public.distance_back == d.back / m.shape->scale);
    assert_true(public.back_in_edges == d.back_h && public.n_unproved == 0);
    assert_true(fabs(cos(public.max_bend * acos(-1.) / 180) - d.sharpest) < 1e-12);
    assert_true(public.max_bend_before > 0 && public.max_bend_before <= 40);
    given.n_nodes--;
    assert_int_equal(planish_shape_measure(m.shape, &given, 2, &public, &error),
                     PLANISH_ERROR_ARGUMENT);
    given.n_nodes++;
    x[4] = INFINITY;
    assert_int_equal(planish_shape_measure(m.shape, &given, 2, &public, &error),
                     PLANISH_ERROR_MESH);
    assert_int_equal(planish_shape_measure(NULL, &given, 2, &public, &error),
                     PLANISH_ERROR_ARGUMENT);
    free(x);
    release(&m);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_are_never_beyond_the_bound),
        cmocka_unit_test(edges_on_curves_are_no_farther_off_than_lateral),
        cmocka_unit_test(samples_are_never_beyond_the_bound_of_a_disc),
        cmocka_unit_test(samples_are_never_beyond_the_bound_of_fans),
        cmocka_unit_test(a_border_under_a_triangle_is_noticed),
        cmocka_unit_test(a_disc_ends_at_a_border),
        cmocka_unit_test(a_fold_under_a_triangle_is_noticed),
        cmocka_unit_test(a_steep_triangle_has_no_bound),
        cmocka_unit_test(two_sheets_over_a_triangle_are_noticed),
        cmocka_unit_test(corners_that_moved_are_off),
        cmocka_unit_test(facets_in_a_plane_are_exact),
        cmocka_unit_test(a_measure_holds_both_ways),
        cmocka_unit_test(a_surface_that_stays_is_not_off),
        cmocka_unit_test(a_mesh_is_measured_in_its_own_units),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
