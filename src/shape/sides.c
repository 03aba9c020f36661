/* sides: parts of columns that rise from one wall.
 *
 * Layers on both sides of a surface inside of the mesh, or of a wake, make one column, whose heights fall and
 * rise again. It is cut where they are least. The rows beside the cut may be of any height, as the surface may
 * have been moved: then one is higher by what the other one lost.
 */
#include "shape/sides.h"

#include "base/memory.h"
#include "base/status.h"

#include <math.h>

/* Heights of a side rise from the second row on by at least this factor, while each is higher than the one
 * before. Those of the two first rows sum up to what the rows after them tell, within this factor. */
static const double RISES = 1.15, SUMS_UP = 1.2;
enum { LEAST_ROWS = 4 }; /* of a side */
enum { MOST_ROWS = 16 }; /* that are looked at */

/** Column being cut. */
typedef struct side_search {
    const int32_t *upright; /* of the column */
    int64_t n;
    const double *length;
} side_search;

static double length_at(const side_search *s, int64_t place) {
    return s->length[s->upright[place]];
}

/** Whether heights rise from a place on. The last row of a column does not count, as a wall may have been moved
 *  there. */
static int do_rise(const side_search *s, int64_t place, int step) {
    const double enough = RISES * length_at(s, place);
    int64_t i = place;
    if (!(enough > 0))
        return 0;
    for (int n = 0; n < MOST_ROWS && length_at(s, i) < enough; n++, i += step)
        if (i + step <= 0 || i + step >= s->n - 1 || !(length_at(s, i + step) > length_at(s, i)))
            return 0;
    return length_at(s, i) >= enough;
}

/** Height of a first row by the two after it, from a place on. */
static double told_first(const side_search *s, int64_t place, int step) {
    const double next = length_at(s, place);
    return next * next / length_at(s, place + step);
}

/** How well a cut before a place fits: the factor by which the first rows do not sum up; INFINITY: the
 *  heights do not rise to both sides. */
static double misfit_of(const side_search *s, int64_t place) {
    if (!do_rise(s, place - 2, -1) || !do_rise(s, place + 1, 1))
        return INFINITY;
    const double told = told_first(s, place - 2, -1) + told_first(s, place + 1, 1);
    const double sum = length_at(s, place - 1) + length_at(s, place);
    const double misfit = sum > told ? sum / told : told / sum;
    return sum > 0 && misfit <= SUMS_UP ? misfit : INFINITY;
}

/** Find the first place from a place on that a column is to be cut before, the best one beside others; n: there
 *  is none. */
static int64_t next_cut(const side_search *s, int64_t from) {
    int64_t best = s->n;
    double least = INFINITY;
    for (int64_t i = from; i + LEAST_ROWS <= s->n; i++) {
        const double misfit = misfit_of(s, i);
        if (misfit < least) {
            least = misfit;
            best = i;
        } else if (!isfinite(misfit) && isfinite(least))
            break;
    }
    return best;
}

int pl_columns_find_sides(pl_columns *c, const double *length, planish_error *error) {
    c->side = pl_alloc(c->n_uprights + 1, sizeof *c->side);
    if (!c->side)
        return pl_fail_memory(error, "the columns of layers");
    c->n_sides = 0;
    for (int64_t k = 0; k < c->n_columns; k++) {
        const int64_t begin = c->begin[k];
        const side_search s = {c->upright + begin, c->begin[k + 1] - begin, length};
        c->side[c->n_sides++] = begin;
        for (int64_t i = LEAST_ROWS; (i = next_cut(&s, i)) < s.n; i += LEAST_ROWS)
            c->side[c->n_sides++] = begin + i;
    }
    c->side[c->n_sides] = c->n_uprights;
    return PLANISH_OK;
}
