/* Overlays: bounds of distances against dense samples and brute force. */
#include "support/effort.h"
#include "support/sheets.h"

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

/** Largest distance from a patch of points of a triangle. */
static double sample(const sheet_judge *judge, int32_t patch, const double corner[3][3]) {
    double most = 0;
    for (int i = 0; i <= DIVISIONS; i++)
        for (int j = 0; i + j <= DIVISIONS; j++) {
            double p[3];
            for (int d = 0; d < 3; d++)
                p[d] = (i * corner[0][d] + j * corner[1][d] + (DIVISIONS - i - j) * corner[2][d]) /
                       DIVISIONS;
            most = fmax(most, sheet_judge_distance(judge, patch, p));
        }
    return most;
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
    const double most = sample(&m->first, s->patch[facet], (const double(*)[3])t.x);
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
        moved m = move_sheet(sheet_create(kind, &state), far * random_unit(&state),
                             off * random_unit(&state), share, &state);
        for (int32_t f = 0; f < m.shape->n_facets; f++)
            check_facet(&m, f, &state, &w);
        release(&m);
    }
    qsort(w.ratio, (size_t)w.n_ratios, sizeof *w.ratio, compare_doubles);
    return w;
}

static void samples_are_never_beyond_the_bound(void **unused) {
    (void)unused;
    for (int kind = 0; kind < SHEET_KINDS; kind++)
        for (int far = 0; far < 2; far++) {
            worth w = check_kind(kind, effort(20, 500), far ? 2 : 0.5, far ? 0.3 : 0.05);
            figure("sheets of kind %d, moved %s: %lld of %lld facets bounded, bound / samples %.3f",
                   kind, far ? "far" : "near", (long long)w.n_bounded, (long long)w.n,
                   w.n_ratios ? w.ratio[w.n_ratios / 2] : 1);
            free(w.ratio);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_are_never_beyond_the_bound),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
