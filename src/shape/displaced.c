/* displaced: nodes that are not where their columns want them.
 *
 * A node inside a column that was displaced makes one row lower by as much as it makes the next one higher: the
 * sum of both is what the other rows tell. A wall that was moved changes this sum. If the node has gone
 * through others, a row points the other way. The sum is then shared as the other rows tell.
 */
#include "shape/displaced.h"

#include <math.h>

/* Rows beside each other that are looked at: few, as the rows beside these tell their heights less well. */
enum { MOST_ROWS = 4 };
/* Rows sum up to what is told if that is off by no more than this part of what one of them is off. */
static const double SUMS_UP = 0.5;
/* No row is higher or lower than the next one by more than this factor if it is guessed from others. */
static const double MOST_GROWTH = 2;
/* A second row is as told within this factor if only the wall was moved. */
static const double AS_TOLD = 1.5;

/** Side of a column. */
typedef struct part {
    const int32_t *upright; /* [n] */
    int64_t n;
    const double *length;
} part;

/** Rows of a side beside each other, and their heights as the rows at one end of them tell. */
typedef struct rows {
    int64_t begin;
    int n;
    double told[MOST_ROWS];
    double sum, told_sum;
} rows;

static double length_at(const part *s, int64_t place) {
    return place < 0 || place >= s->n ? 0 : s->length[s->upright[place]];
}

/** Number of rows, up to 3, that may tell those before them: from a place on. */
static int count_telling(const part *s, int64_t place, int step) {
    int n = 0;
    while (n < 3 && length_at(s, place + step * n) > 0)
        n++;
    return n;
}

/** Growth over n rows from a place on, n > 0. */
static double growth_from(const part *s, int64_t place, int step, int n) {
    const double next = length_at(s, place);
    const double growth = n > 2   ? sqrt(length_at(s, place + 2 * step) / next)
                          : n > 1 ? length_at(s, place + step) / next
                                  : 1;
    return fmin(fmax(growth, 1 / MOST_GROWTH), MOST_GROWTH);
}

/** Find what n rows from a place on should be by the rows at that end of them where more are known, or these
 *  are higher. Return whether any are known. */
static int find_rows(const part *s, int64_t begin, int n, rows *r) {
    const int n_up = count_telling(s, begin + n, 1), n_down = count_telling(s, begin - 1, -1);
    const int is_up =
        n_up != n_down ? n_up > n_down : length_at(s, begin + n) >= length_at(s, begin - 1);
    const int64_t next = is_up ? begin + n : begin - 1;
    *r = (rows){.begin = begin, .n = n};
    if (n_up == 0 && n_down == 0)
        return 0;
    const double growth = growth_from(s, next, is_up ? 1 : -1, is_up ? n_up : n_down);
    double told = length_at(s, next);
    for (int k = 0; k < n; k++) {
        const int at = is_up ? n - 1 - k : k;
        r->told[at] = told /= growth;
        r->told_sum += told;
        r->sum += length_at(s, begin + at);
    }
    return 1;
}

/** By how much rows do not sum up, in parts of what the row at a place is off. */
static double misfit_of(const part *s, const rows *r, int64_t place) {
    return fabs(r->sum - r->told_sum) / fabs(length_at(s, place) - r->told[place - r->begin]);
}

/** Find the fewest rows that one at a place sums up with, the best ones of as many. Return whether there are
 *  such rows. */
static int find_shared(const part *s, int64_t place, rows *best) {
    double least = SUMS_UP;
    best->n = 0;
    for (int n = 2; n <= MOST_ROWS && best->n == 0; n++)
        for (int64_t begin = place - n + 1; begin <= place; begin++) {
            rows r;
            if (begin < 0 || begin + n > s->n || !find_rows(s, begin, n, &r))
                continue;
            const double misfit = misfit_of(s, &r, place);
            if (r.sum > 0 && misfit <= least) {
                least = misfit;
                *best = r;
            }
        }
    return best->n > 0;
}

void pl_displaced_share(const pl_columns *c, double *length, uint8_t *is_shared) {
    for (int64_t k = 0; k < c->n_sides; k++) {
        const part s = {c->upright + c->side[k], c->side[k + 1] - c->side[k], length};
        for (int64_t i = 0; i < s.n; i++) {
            rows r;
            if (length_at(&s, i) > 0 || !find_shared(&s, i, &r))
                continue;
            for (int j = 0; j < r.n; j++) {
                const int32_t u = s.upright[r.begin + j];
                length[u] = r.told[j] * (r.sum / r.told_sum);
                is_shared[u] = 1;
            }
        }
    }
}

int pl_displaced_wall(const pl_columns *c, const double *length, int64_t side, int64_t place,
                      int step, int is_turned) {
    const part s = {c->upright + c->side[side], c->side[side + 1] - c->side[side], length};
    const int64_t first = place - c->side[side];
    const int at = step > 0 ? 0 : 1; /* of the first row */
    rows r;
    if (!find_rows(&s, first - at, 2, &r))
        return 0;
    const double off = (is_turned ? -1 : 1) * length_at(&s, first) - r.told[at];
    const double next = length_at(&s, first + step), next_off = next - r.told[!at];
    return next <= AS_TOLD * r.told[!at] && r.told[!at] <= AS_TOLD * next &&
           fabs(off + next_off) > SUMS_UP * fabs(off);
}
