/* heights: how high the rows of layers are to be.
 *
 * A height is that of its upright across the layer in the input, averaged along its row. Where a wall was moved the
 * first heights are not what they were, but the columns tell: rows grow evenly. An upright that points
 * against its column, or is a first one and off the growth of its side while others of its row are off by
 * another factor, gets the height by which the side goes on from the rows inside. If a node inside the side was
 * displaced, the rows there share their heights (displaced.h).
 */
#include "shape/heights.h"

#include "base/memory.h"
#include "base/status.h"
#include "shape/displaced.h"
#include "shape/sides.h"
#include "shape/upright_means.h"
#include "topology/cells.h"

#include <math.h>

/* Growth is steady if its factors from row to row are within this part of each other. An upright is off
 * it if it is so much longer or shorter than the growth says, and a row varies if two uprights beside each
 * other are off it by factors that differ so much. */
static const double STEADY = 1.05, OFF = 1.05, VARIES = 1.02;
/* One of uprights beside each other that are off is off by more than this: else the row is uneven. */
static const double MOVED = 1.25;
/* No row is higher or lower than the next one by more than this factor if it is guessed from others. */
static const double MOST_GROWTH = 2;
/* An upright that differs from the median of those beside it by this factor becomes the median. */
static const double OUTLIER = 1.5;
/* An upright leans for good if it is so much less high than long, and the mean cosine between it and the
 * edges along the layer is so far from 0: these point one way, as at a sharp edge of a wall. */
static const double LEANS = 0.3, ONE_WAY = 0.4;
enum { ROUNDS = 2 };          /* of averages along the rows */
enum { MOST_LOOKED_AT = 24 }; /* uprights beside one */
enum { STEADY_ROWS = 4 };     /* that are needed to call their growth steady */

/** Heights being found. */
typedef struct search {
    pl_columns *c;
    double *length; /* [n_uprights] in the input, */
    double *off;    /* [n_uprights] and by how much it is longer than the growth says; 0: unknown */
    uint8_t *is_off; /* [n_uprights] see below */
    int64_t *first;  /* [n_uprights + 2] in cell */
    int32_t *cell;   /* elements at each upright */
    int32_t *queue;  /* [n_uprights] */
} search;

/* What is known of an upright: it is off the growth; it points elsewhere; it gets another height; it is off
 * by far, though the rows are too few to call their growth steady; a wall was moved there; it shares the
 * height of a row beside it; a corner at it is inverted. */
enum {
    IS_OFF = 1,
    IS_TURNED = 2,
    IS_WILD = 4,
    IS_FAR = 8,
    IS_MOVED = 16,
    IS_SHARED = 32,
    IS_INVERTED = 64
};

/* ---- columns ---------------------------------------------------------------------------------- */

static double ratio_of(double a, double b) {
    return a > b ? a / b : b / a;
}

/** Find how high the uprights are across the layer, and which of these point the other way: these are negative. Those of
 *  simplices whose levels are not known are as high as long. */
static int find_lengths(const search *s, planish_error *error) {
    const pl_columns *c = s->c;
    double *sum = pl_columns_sum_heights(c);
    if (!sum)
        return pl_fail_memory(error, "the heights of layers");
    for (int64_t u = 0; u < c->n_uprights; u++) {
        const double *of = sum + PL_UPRIGHT_SUMS * u;
        const double n = of[PL_UPRIGHT_CORNERS];
        double edge[3];
        pl_columns_edge(c, c->end[2 * u], c->end[2 * u + 1], edge);
        const double length = sqrt(pl_dot(3, edge, edge));
        s->length[u] = n > 0 ? of[PL_UPRIGHT_HEIGHTS] / n : length;
        s->is_off[u] = (n > 0 && !(of[PL_UPRIGHT_HEIGHTS] > 0) ? IS_TURNED : 0) |
                       (of[PL_UPRIGHT_INVERTED] > 0 ? IS_INVERTED : 0);
        c->leans[u] = !(s->is_off[u] & IS_TURNED) && s->length[u] < LEANS * length &&
                      fabs(of[PL_UPRIGHT_COSINES]) >= ONE_WAY * n * (c->mesh->dim - 1);
    }
    pl_free(sum);
    return PLANISH_OK;
}

/** Whether uprights from a place on grow steadily, and none of them is known to be wrong. */
static int are_steady(const search *s, int64_t place) {
    const pl_columns *c = s->c;
    double least = INFINITY, most = 0;
    for (int n = 0; n < STEADY_ROWS; n++) {
        const int32_t u = c->upright[place + n];
        if ((s->is_off[u] & (IS_TURNED | IS_WILD)) || !(s->length[u] > 0))
            return 0;
        const double growth = n > 0 ? s->length[u] / s->length[c->upright[place + n - 1]] : 1;
        least = n > 0 ? fmin(least, growth) : least;
        most = n > 0 ? fmax(most, growth) : most;
    }
    return most <= STEADY * least;
}

/** Place in a side that heights are known best at: the longest upright of those that grow steadily, or
 *  else of those that are not known to be wrong, or else of all. An upright that a wall has stretched, or
 *  turned by much, is long, too. */
static int64_t anchor_of(const search *s, int64_t side) {
    const pl_columns *c = s->c;
    const int64_t end = c->side[side + 1];
    int64_t best = c->side[side];
    int best_rank = -1;
    int64_t steady_until = 0;
    for (int64_t i = c->side[side]; i < end; i++) {
        if (i + STEADY_ROWS <= end && are_steady(s, i))
            steady_until = i + STEADY_ROWS;
        const int32_t u = c->upright[i];
        const int rank = i < steady_until ? 2 : !(s->is_off[u] & (IS_TURNED | IS_WILD));
        if (rank > best_rank || (rank == best_rank && s->length[u] > s->length[c->upright[best]])) {
            best = i;
            best_rank = rank;
        }
    }
    return best;
}

/** Height n uprights from a place on, in steps of step. */
static double height_at(const pl_columns *c, int64_t place, int step, int n) {
    return c->height[c->upright[place + step * n]];
}

/** Height of the upright at a place as those between it and the anchor tell: the growth over the next
 *  three goes on. n_known: their number, > 0. */
static double go_on(const pl_columns *c, int64_t place, int step, int64_t n_known) {
    const double next = height_at(c, place, step, 1);
    const double growth = n_known > 2   ? sqrt(height_at(c, place, step, 3) / next)
                          : n_known > 1 ? height_at(c, place, step, 2) / next
                                        : 1;
    return next / fmin(fmax(growth, 1 / MOST_GROWTH), MOST_GROWTH);
}

/** Whether the rows inside of a place grow steadily. */
static int is_steady(const pl_columns *c, int64_t place, int step, int64_t n_known) {
    double least = INFINITY, most = 0;
    for (int n = 1; n_known >= STEADY_ROWS && n < STEADY_ROWS; n++) {
        const double growth = height_at(c, place, step, n + 1) / height_at(c, place, step, n);
        least = fmin(least, growth);
        most = fmax(most, growth);
    }
    return n_known >= STEADY_ROWS && most <= STEADY * least;
}

/** Judge an upright by the height that rows inside tell. Growth is that of a layer only towards a wall: the last
 *  upright is off it, if heights do not rise to there. */
static void judge(const search *s, int32_t u, double told, double next, int is_last) {
    if (!is_last || told > STEADY * next)
        return;
    if (s->off[u] > 0 && ratio_of(s->off[u], 1) > OFF)
        s->is_off[u] |= IS_OFF;
    if (!(ratio_of(s->length[u], told) <= OUTLIER))
        s->is_off[u] |= IS_FAR;
}

/** Find the heights of a side from the anchor to an end: lengths, but of those that are turned or wild
 *  what the rows inside tell. */
static void find_heights(const search *s, int64_t side, int64_t anchor, int step) {
    const pl_columns *c = s->c;
    const int64_t begin = c->side[side], end = c->side[side + 1];
    int64_t n_known = 1;
    for (int64_t i = anchor - step; i >= begin && i < end; i -= step) {
        const int32_t u = c->upright[i];
        const double told = go_on(c, i, step, n_known);
        s->off[u] = is_steady(c, i, step, n_known) ? s->length[u] / told : 0;
        if (n_known > 1)
            judge(s, u, told, height_at(c, i, step, 1), i == (step > 0 ? begin : end - 1));
        c->height[u] = (s->is_off[u] & (IS_TURNED | IS_WILD)) ? told : s->length[u];
        n_known++;
    }
}

/** Whether the surface between two sides was moved: one first row has lost what the other one has got. */
static int is_between_moved(const search *s, int32_t a, int32_t b) {
    const int any = IS_OFF | IS_FAR | IS_TURNED;
    const int is_low_a = s->is_off[a] & IS_TURNED || s->length[a] < s->length[b];
    const int is_low_b = s->is_off[b] & IS_TURNED || s->length[b] < s->length[a];
    return s->is_off[a] & any && s->is_off[b] & any && is_low_a != is_low_b;
}

/** Let first uprights beside a surface between two sides be off only if it was moved. */
static void check_between(const search *s) {
    const pl_columns *c = s->c;
    for (int64_t k = 1; k < c->n_sides; k++) {
        const int32_t a = c->upright[c->side[k] - 1], b = c->upright[c->side[k]];
        if (c->column[a] == c->column[b] && !is_between_moved(s, a, b)) {
            s->is_off[a] &= (uint8_t) ~(IS_OFF | IS_FAR);
            s->is_off[b] &= (uint8_t) ~(IS_OFF | IS_FAR);
        }
    }
}

static void find_columns(const search *s) {
    const pl_columns *c = s->c;
    for (int64_t k = 0; k < c->n_sides; k++) {
        const int64_t anchor = anchor_of(s, k);
        c->height[c->upright[anchor]] = s->length[c->upright[anchor]];
        find_heights(s, k, anchor, 1);
        find_heights(s, k, anchor, -1);
    }
    check_between(s);
}

/* ---- rows ------------------------------------------------------------------------------------- */

/** List the elements at each upright. */
static void list_cells(search *s) {
    const pl_columns *c = s->c;
    int64_t *first = s->first + 1; /* counts end up at the beginning of the next one */
    for (int64_t i = 0; i < c->n_cells; i++)
        for (int k = 0; k < c->cell[i].n_uprights; k++)
            first[c->cell[i].upright[k] + 1]++;
    for (int64_t u = 0; u < c->n_uprights; u++)
        first[u + 1] += first[u];
    for (int64_t i = 0; i < c->n_cells; i++)
        for (int k = 0; k < c->cell[i].n_uprights; k++)
            s->cell[first[c->cell[i].upright[k]]++] = (int32_t)i;
}

/** List uprights beside one, itself first; return their number. */
static int beside(const search *s, int64_t u, int32_t found[MOST_LOOKED_AT]) {
    int n = 0;
    found[n++] = (int32_t)u;
    for (int64_t i = s->first[u]; i < s->first[u + 1]; i++) {
        const pl_layer_cell *cell = &s->c->cell[s->cell[i]];
        for (int k = 0; k < cell->n_uprights; k++) {
            int is_new = n < MOST_LOOKED_AT;
            for (int j = 0; j < n; j++)
                is_new &= found[j] != cell->upright[k];
            if (is_new)
                found[n++] = cell->upright[k];
        }
    }
    return n;
}

/** Whether an upright is off the growth by another factor than one beside it, or is turned. */
static int is_wild(const search *s, int64_t u) {
    int32_t found[MOST_LOOKED_AT];
    const int n = s->is_off[u] & IS_OFF ? beside(s, u, found) : 0;
    for (int k = 1; k < n; k++)
        if (s->is_off[found[k]] & IS_TURNED ||
            (s->off[found[k]] > 0 && ratio_of(s->off[u], s->off[found[k]]) > VARIES))
            return 1;
    return (s->is_off[u] & IS_TURNED) != 0;
}

/** Whether an upright is off by so much that a wall was moved. */
static int is_moved(const search *s, int64_t u) {
    return s->is_off[u] & (IS_TURNED | IS_FAR) || (s->off[u] > 0 && ratio_of(s->off[u], 1) > MOVED);
}

/** Mark the n uprights of the queue, and those beside marked ones of which any of others is known. */
static void spread(const search *s, int64_t n, uint8_t mark, uint8_t others) {
    for (int64_t k = 0; k < n; k++)
        s->is_off[s->queue[k]] |= mark;
    for (int64_t k = 0; k < n; k++) {
        int32_t found[MOST_LOOKED_AT];
        for (int j = beside(s, s->queue[k], found); j-- > 1;)
            if (!(s->is_off[found[j]] & mark) && s->is_off[found[j]] & others) {
                s->is_off[found[j]] |= mark;
                s->queue[n++] = found[j];
            }
    }
}

/** Find wild uprights, and those of their rows that are off the growth, too: where a wall was moved. */
static void find_wild(const search *s) {
    const int64_t n_uprights = s->c->n_uprights;
    int64_t n = 0;
    for (int64_t u = 0; u < n_uprights; u++)
        if (is_wild(s, u))
            s->queue[n++] = (int32_t)u;
    spread(s, n, IS_WILD, IS_OFF | IS_FAR);
    n = 0;
    for (int64_t u = 0; u < n_uprights; u++)
        if (s->is_off[u] & IS_WILD && is_moved(s, u))
            s->queue[n++] = (int32_t)u;
    spread(s, n, IS_MOVED, IS_WILD);
    for (int64_t u = 0; u < n_uprights; u++)
        if (!(s->is_off[u] & IS_MOVED))
            s->is_off[u] &= (uint8_t)~IS_WILD;
}

/** Return the height of an upright, or the median of it and those beside it if it is far off. */
static double robust_height(const search *s, int64_t u) {
    int32_t found[MOST_LOOKED_AT];
    const double own = s->c->height[u];
    double sorted[MOST_LOOKED_AT] = {own};
    const int n = beside(s, u, found);
    for (int k = 0; k < n; k++) {
        const double height = s->c->height[found[k]];
        int at = k;
        for (; at > 0 && sorted[at - 1] > height; at--)
            sorted[at] = sorted[at - 1];
        sorted[at] = height;
    }
    const double median = sorted[n / 2];
    return n > 2 && median > 0 && !(ratio_of(own, median) <= OUTLIER) ? median : own;
}

/* ---- all of it -------------------------------------------------------------------------------- */

/** Whether the wall at an upright was moved so far that other rows may have to make room. */
static int is_far(const search *s, int32_t u) {
    const double told = s->c->height[u];
    return s->is_off[u] & IS_TURNED ||
           (s->is_off[u] & IS_WILD && !(ratio_of(s->length[u], told) <= OUTLIER));
}

/** Let rows share their heights where a node between them was displaced: they no longer point elsewhere. */
static int share(search *s, planish_error *error) {
    const pl_columns *c = s->c;
    uint8_t *is_shared = pl_alloc_zero(c->n_uprights, 1);
    if (!is_shared)
        return pl_fail_memory(error, "the heights of layers");
    pl_displaced_share(c, s->length, is_shared);
    for (int64_t u = 0; u < c->n_uprights; u++)
        if (is_shared[u])
            s->is_off[u] = (uint8_t)(s->is_off[u] & ~IS_TURNED) | IS_SHARED;
    pl_free(is_shared);
    return PLANISH_OK;
}

/** Whether an upright is told: not the anchor, which has its own height, unless it shares one. */
static int is_told(const search *s, int64_t place, int64_t anchor) {
    const int mark = s->is_off[s->c->upright[place]];
    return mark & IS_SHARED || (place != anchor && mark & (IS_TURNED | IS_WILD));
}

/** Mark sides whose walls were moved far, and uprights whose heights others have told. */
static void mark_told(const search *s) {
    const pl_columns *c = s->c;
    for (int64_t k = 0; k < c->n_sides; k++) {
        const int64_t anchor = anchor_of(s, k);
        for (int64_t i = c->side[k]; i < c->side[k + 1]; i++) {
            c->is_moved[k] |= (uint8_t)is_far(s, c->upright[i]);
            c->told[c->upright[i]] = is_told(s, i, anchor) ? PL_TOLD : 0;
        }
    }
}

/** Whether an upright is at an end of its column, and nothing is wrong with the next one. */
static int is_next_sound(const search *s, int32_t u) {
    const pl_columns *c = s->c;
    const int64_t place = c->place[u], begin = c->begin[c->column[u]];
    const int64_t last = c->begin[c->column[u] + 1] - 1;
    if (begin == last || (place != begin && place != last))
        return 0;
    const int32_t next = c->upright[place == begin ? place + 1 : place - 1];
    return !c->told[next] && !(s->is_off[next] & IS_INVERTED);
}

/** Whether nothing is wrong with the second uprights of all elements at a first one. */
static int are_next_sound(const search *s, int32_t u) {
    int is_sound = is_next_sound(s, u);
    for (int64_t i = s->first[u]; i < s->first[u + 1]; i++) {
        const pl_layer_cell *cell = &s->c->cell[s->cell[i]];
        for (int k = 0; k < cell->n_uprights && is_sound; k++)
            is_sound = is_next_sound(s, cell->upright[k]);
    }
    return is_sound;
}

/** Whether the first upright of a column, in a side from place on in steps of step, is told as its end was
 *  moved: the side is thinnest there, and no other nodes explain that. */
static int is_end_moved(const search *s, int64_t side, int64_t place, int step) {
    const pl_columns *c = s->c;
    const int32_t u = c->upright[place];
    const int64_t other = place + step;
    const int mark = s->is_off[u];
    return c->told[u] && !(mark & IS_SHARED) && other >= c->side[side] &&
           other < c->side[side + 1] &&
           height_at(c, place, step, 0) <= STEADY * height_at(c, place, step, 1) &&
           are_next_sound(s, u) &&
           pl_displaced_wall(c, s->length, side, place, step, (mark & IS_TURNED) != 0);
}

/** Mark first uprights at walls that were moved. on_boundary [n_nodes]: NULL: count them, but for what is on
 *  the boundary. Returns how many there are. */
static int64_t mark_walls(const search *s, const uint8_t *on_boundary) {
    const pl_columns *c = s->c;
    int64_t n = 0;
    for (int64_t k = 0; k < c->n_sides; k++)
        for (int is_last = 0; is_last < 2 && c->side[k] < c->side[k + 1]; is_last++) {
            const int64_t place = is_last ? c->side[k + 1] - 1 : c->side[k];
            const int32_t u = c->upright[place];
            if (!is_end_moved(s, k, place, is_last ? -1 : 1))
                continue;
            if (on_boundary && on_boundary[c->node[place + c->column[u] + is_last]])
                c->told[u] = PL_TOLD_AT_WALL;
            n++;
        }
    return n;
}

/** Find the first uprights at walls that were moved: at the boundary, which is looked for if it matters. */
static int find_walls(const search *s, planish_error *error) {
    const planish_mesh *mesh = s->c->mesh;
    pl_cell_census census = {.on_boundary = NULL};
    if (mark_walls(s, NULL) == 0)
        return PLANISH_OK;
    const int status = pl_cell_census_find(mesh->cells, mesh->dim, mesh->n_nodes, mesh->coordinates,
                                           s->c->threads, &census, error);
    if (!status)
        mark_walls(s, census.on_boundary);
    pl_cell_census_destroy(&census);
    return status;
}

/** Find heights as the input and the growth tell, and which are told by the growth. */
static int find_told(search *s, planish_error *error) {
    list_cells(s);
    pl_columns *c = s->c;
    int status = find_lengths(s, error);
    if (!status)
        status = pl_columns_find_sides(c, s->length, error);
    if (!status)
        status = share(s, error);
    for (int64_t u = 0; u < c->n_uprights; u++)
        s->length[u] = fabs(s->length[u]);
    c->is_moved = status ? NULL : pl_alloc_zero(c->n_sides, sizeof *c->is_moved);
    if (status || !c->is_moved)
        return status ? status : pl_fail_memory(error, "the heights of layers");
    find_columns(s);
    find_wild(s);
    find_columns(s);
    mark_told(s);
    return PLANISH_OK;
}

/** Smooth heights along the rows. */
static int smooth_all(search *s, planish_error *error) {
    pl_columns *c = s->c;
    double *of_cell = pl_alloc(c->n_cells, sizeof *of_cell);
    if (!of_cell)
        return pl_fail_memory(error, "the heights of layers");
    for (int64_t u = 0; u < c->n_uprights; u++)
        s->length[u] = robust_height(s, u);
    for (int64_t u = 0; u < c->n_uprights; u++)
        c->height[u] = s->length[u];
    const int status = pl_columns_average(c, ROUNDS, c->height, of_cell, error);
    pl_free(of_cell);
    return status;
}

int pl_columns_find_heights(pl_columns *c, int is_smooth, planish_error *error) {
    const int64_t n = c->n_uprights;
    int64_t n_at = 0;
    for (int64_t i = 0; i < c->n_cells; i++)
        n_at += c->cell[i].n_uprights;
    search s = {.c = c};
    c->height = pl_alloc_zero(n, sizeof *c->height);
    c->leans = pl_alloc_zero(n, sizeof *c->leans);
    c->told = pl_alloc_zero(n, sizeof *c->told);
    s.length = pl_alloc(n, sizeof *s.length);
    s.off = pl_alloc_zero(n, sizeof *s.off);
    s.is_off = pl_alloc_zero(n, sizeof *s.is_off);
    s.first = pl_alloc_zero(n + 2, sizeof *s.first);
    s.cell = pl_alloc(n_at, sizeof *s.cell);
    s.queue = pl_alloc(n, sizeof *s.queue);
    const int is_there = c->height && c->leans && c->told && s.length && s.off && s.is_off &&
                         s.first && s.cell && s.queue;
    int status = is_there ? find_told(&s, error) : pl_fail_memory(error, "the heights of layers");
    if (!status)
        status = is_smooth ? smooth_all(&s, error) : find_walls(&s, error);
    pl_free(s.length);
    pl_free(s.off);
    pl_free(s.is_off);
    pl_free(s.first);
    pl_free(s.cell);
    pl_free(s.queue);
    return status;
}
