/* layer_heights: how high layers are, row by row, beside what they are to be. */
#include "shape/layer_heights.h"

#include "base/memory.h"
#include "base/status.h"
#include "shape/heights.h"
#include "shape/levels.h"
#include "shape/upright_means.h"

#include <math.h>
#include <stdlib.h>

/* Heights that differ by no more than this part are equally high. */
static const double AS_HIGH = 0.01;

/* Uprights that are less high than this part of their length have no height: it is about that of rounding. */
static const double FLAT = 1e-9;

/** Uprights of rows. */
typedef struct row_search {
    const pl_columns *c;
    const double *height; /* [n_uprights] as they are, NAN: not known */
    int32_t *row;         /* [n_uprights] */
    double *ratio;        /* [n_uprights] of one row */
} row_search;

/** Find the place in a side of the highest upright; of those that are as high the last one. */
static int64_t highest_of(const pl_columns *c, int64_t begin, int64_t end) {
    int64_t best = begin;
    for (int64_t i = begin; i < end; i++)
        if (c->height[c->upright[i]] > c->height[c->upright[best]])
            best = i;
    const double enough = (1 - AS_HIGH) * c->height[c->upright[best]];
    return c->height[c->upright[end - 1]] >= enough ? end - 1 : best;
}

/** Number the rows: from both ends of each side, which are thin, to the highest upright. */
static void number_rows(const row_search *s) {
    const pl_columns *c = s->c;
    for (int64_t k = 0; k < c->n_sides; k++) {
        const int64_t begin = c->side[k], end = c->side[k + 1], top = highest_of(c, begin, end);
        for (int64_t i = begin; i < end; i++) {
            const int64_t up = i - begin, down = end - 1 - i;
            const int64_t row = i < top ? up : i > top ? down : up > down ? up : down;
            const int64_t last = PLANISH_LAYER_ROWS - 1;
            s->row[c->upright[i]] = (int32_t)(row < last ? row : last);
        }
    }
}

static int compare(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/** Compare the heights of a row, -1: of all rows, with those that are wanted. */
static planish_layer_row measure_row(const row_search *s, int row) {
    planish_layer_row found = {.n = 0};
    for (int64_t u = 0; u < s->c->n_uprights; u++)
        if ((row < 0 || s->row[u] == row) && s->c->height[u] > 0 && isfinite(s->height[u]))
            s->ratio[found.n++] = s->height[u] / s->c->height[u];
    if (found.n == 0)
        return found;
    qsort(s->ratio, (size_t)found.n, sizeof *s->ratio, compare);
    found.min = s->ratio[0];
    found.max = s->ratio[found.n - 1];
    found.median = 0.5 * (s->ratio[(found.n - 1) / 2] + s->ratio[found.n / 2]);
    return found;
}

/** Find how far the heights at each node are off: not those that are told, nor under walls that were moved far. */
static void find_off(const row_search *s, double *off) {
    const pl_columns *c = s->c;
    for (int64_t i = 0; i < c->mesh->n_nodes; i++)
        off[i] = 0;
    for (int64_t k = 0; k < c->n_sides; k++)
        for (int64_t i = c->side[k]; i < c->side[k + 1] && !c->is_moved[k]; i++) {
            const int32_t u = c->upright[i];
            const double by = c->told[u] ? 0 : fabs(s->height[u] / c->height[u] - 1);
            for (int end = 0; end < 2 && isfinite(by); end++)
                off[c->end[2 * u + end]] = fmax(off[c->end[2 * u + end]], by);
        }
}

/** The power of two that a unit of lengths of a frame is. */
static int unit_of(const pl_frame *frame) {
    return -ilogb(frame->shrink) - ilogb(frame->scale[0]) - ilogb(frame->scale[1]);
}

/** Measure the heights at now, in the columns' unit: in a frame of its own, as now may be far larger or
 *  smaller. */
static int measure_now(const pl_columns *c, const double *now, int threads, double *height,
                       planish_error *error) {
    pl_columns at_now = *c;
    planish_mesh mesh = *c->mesh;
    mesh.coordinates = now;
    at_now.mesh = &mesh;
    int status = pl_frame_create(&mesh, NULL, threads, &at_now.frame, error);
    if (!status)
        status = pl_columns_measure_heights(&at_now, height, error);
    const int unit = unit_of(&at_now.frame) - unit_of(&c->frame);
    for (int64_t u = 0; !status && u < c->n_uprights; u++)
        height[u] = ldexp(height[u], unit);
    return status;
}

/** Let uprights that are flat want no height. */
static void drop_flat(pl_columns *c) {
    for (int64_t u = 0; u < c->n_uprights; u++) {
        double edge[3];
        pl_columns_edge(c, c->end[2 * u], c->end[2 * u + 1], edge);
        if (c->height[u] < FLAT * sqrt(pl_dot(3, edge, edge)))
            c->height[u] = 0;
    }
}

/** Measure at the columns' coordinates and at now. height [n_uprights]. */
static int measure(row_search *s, const double *now, int threads, double *height,
                   planish_layer_heights *found, planish_error *error) {
    const pl_columns *c = s->c;
    s->height = height;
    number_rows(s);
    int status = pl_columns_measure_heights(c, height, error);
    if (status)
        return status;
    found->reference = measure_row(s, -1);
    status = measure_now(c, now, threads, height, error);
    for (int64_t u = 0; !status && u < c->n_uprights; u++)
        if (c->told[u] && c->height[u] > 0 && isfinite(height[u])) {
            found->n_told++;
            found->n_at_moved_walls += c->told[u] == PL_TOLD_AT_WALL;
        }
    found->all = measure_row(s, -1);
    for (int row = 0; !status && row < PLANISH_LAYER_ROWS; row++) {
        found->row[row] = measure_row(s, row);
        if (found->row[row].n > 0)
            found->n_rows = row + 1;
    }
    return status;
}

int pl_layer_heights_find(const planish_mesh *mesh, const uint8_t *is_layer, const double *now,
                          int threads, planish_layer_heights *found, double *off,
                          planish_error *error) {
    pl_columns c;
    *found = (planish_layer_heights){.n_rows = 0};
    int status = pl_columns_find(mesh, is_layer, threads, &c, error);
    if (!status)
        status = pl_columns_find_levels(&c, error);
    if (!status)
        status = pl_columns_find_heights(&c, 0, error);
    if (!status)
        drop_flat(&c);
    row_search s = {.c = &c};
    double *height = status ? NULL : pl_alloc(c.n_uprights, sizeof *height);
    s.row = status ? NULL : pl_alloc(c.n_uprights, sizeof *s.row);
    s.ratio = status ? NULL : pl_alloc(c.n_uprights, sizeof *s.ratio);
    if (!status)
        status = height && s.row && s.ratio ? measure(&s, now, threads, height, found, error)
                                            : pl_fail_memory(error, "the heights of layers");
    if (status)
        *found = (planish_layer_heights){.n_rows = 0};
    else if (off)
        find_off(&s, off);
    pl_free(height);
    pl_free(s.row);
    pl_free(s.ratio);
    pl_columns_destroy(&c);
    return status;
}
