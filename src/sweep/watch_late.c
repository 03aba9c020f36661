/* watch_late: watched cells that are decided once, at the end of a sweep, where each visit would decide
 * most of them anew. Curved ones, which refuse many moves, those that refused one before, or were not valid,
 * are decided after each visit (watch.c). Where a cell turns out not to be valid, moves are undone.
 *
 * Undone are the last move of the cell's nodes, and then each later one of a node that shares an element
 * with an undone one. Other nodes have seen nothing of that: when such a node was visited, those around it
 * that are undone had not moved yet. So the mesh is as if the undone visits had not been, and each of the
 * others has brought what its visit counted. As cells may now have other nodes than they had at any time,
 * all cells at undone nodes are decided again. In the end nothing has moved, and all cells are as they
 * were when the sweep began.
 */
#include "sweep/watch_late.h"

#include "base/parallel.h"

#include <string.h>

enum {
    CHUNK = PL_WATCH_CELLS, /* cells that one thread takes at a time, */
    CHUNK_NODES = 4096,     /* or nodes */
    MANY = 8                /* no cell waits if one in so many may not */
};

/** A look at all cells or nodes. */
typedef struct look {
    pl_watch *watch;
    int64_t n; /* cells found; shared */
} look;

/* ---- the sweep ------------------------------------------------------------------------------ */

static void clear_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const look *s = context;
    pl_watch_late *late = &s->watch->late;
    (void)thread;
    memset(late->way + begin + 1, 0, (size_t)(end - begin) * sizeof *late->way);
    memset(late->has_at_once + begin, 0, (size_t)(end - begin));
}

static int is_curved(const pl_watch *w, int64_t i) {
    return w->rule[w->type[i]]->jacobian.type->order > 1;
}

static void mark_chunk(void *context, int64_t begin, int64_t end, int thread) {
    look *s = context;
    const pl_watch *w = s->watch;
    int64_t n = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int is_valid = w->state[i] & PL_WATCH_VALID;
        w->late.when[i] = PL_WATCH_WAITS;
        if (!w->type[i] || (is_valid && w->n_refused_of[i] == 0 && !is_curved(w, i)))
            continue;
        w->late.when[i] = is_valid ? PL_WATCH_AT_ONCE : PL_WATCH_AT_ONCE_BAD;
        n++;
        for (int j = 0; j < PL_CELL_CORNERS && w->node[i][j] >= 0; j++)
            pl_set_flag(&w->late.has_at_once[w->node[i][j]], 1);
    }
    __atomic_fetch_add(&s->n, n, __ATOMIC_RELAXED);
}

void pl_watch_begin_sweep(pl_watch *w, int may_wait) {
    look s = {.watch = w};
    w->late.is_on = 0;
    if (!may_wait || !w->late.way || !w->decides)
        return;
    w->late.way[0] = (pl_watch_way){0, -1};
    pl_parallel_for(w->plan->threads, w->plan->work.n_nodes, CHUNK_NODES, clear_chunk, &s);
    pl_parallel_for(w->plan->threads, w->n, CHUNK, mark_chunk, &s);
    w->late.is_on = s.n * MANY <= w->n;
}

void pl_watch_note_move(pl_watch *w, int64_t star, int32_t node, const double *before, double way,
                        const pl_star_gain *gain) {
    pl_watch_record *record = &w->late.record[star];
    const float more = way > 0x1p-100 ? (float)(way * (1 + 0x1p-22)) : 0x1p-100F;
    w->late.way[node + 1] = (pl_watch_way){way > 0 ? more : 0, (int32_t)star};
    for (int d = 0; d < 3; d++)
        record->before[d] = before[d];
    record->fall = gain->fall;
    record->improved = gain->improved;
    record->restored = gain->restored;
}

/* ---- its end -------------------------------------------------------------------------------- */

/** Decide n cells, which were valid, and mark those that are so no more. Returns their number. */
static int64_t decide(pl_watch *w, int n, const int32_t cell[]) {
    uint8_t is_valid[PL_WATCH_CELLS];
    int64_t n_broken = 0;
    pl_watch_decide_all(w, n, cell, is_valid);
    for (int k = 0; k < n; k++)
        if (!is_valid[k]) {
            w->late.when[cell[k]] |= PL_WATCH_BROKEN;
            n_broken++;
        }
    return n_broken;
}

static void late_chunk(void *context, int64_t begin, int64_t end, int thread) {
    look *s = context;
    pl_watch *w = s->watch;
    const pl_watch_way *way = w->late.way + 1; /* node -1, which is none, has gone no way */
    int32_t cell[PL_WATCH_CELLS];
    int n = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int32_t *node = w->node[i];
        double sum = 0;
        if (!w->type[i] || w->late.when[i] != PL_WATCH_WAITS)
            continue;
        for (int j = 0; j < PL_CELL_CORNERS; j++)
            sum += (double)way[node[j]].length;
        const double room = w->room[i] - sum;
        if (room > 0)
            w->room[i] = pl_watch_room_below(room);
        else if (sum > 0)
            cell[n++] = (int32_t)i;
    }
    const int64_t n_broken = n > 0 ? decide(w, n, cell) : 0;
    if (n_broken > 0)
        __atomic_fetch_add(&s->n, n_broken, __ATOMIC_RELAXED);
}

/** Have the last move of each broken cell undone. Returns the first star of these, or n_stars. */
static int64_t find_first(pl_watch *w, int64_t n_stars) {
    int64_t first = n_stars;
    for (int64_t i = 0; i < w->n; i++) {
        pl_watch_way *last = &w->late.way[0];
        if (!(w->late.when[i] & PL_WATCH_BROKEN))
            continue;
        w->late.when[i] &= (uint8_t)~PL_WATCH_BROKEN;
        if (w->n_refused_of[i] < UINT8_MAX)
            w->n_refused_of[i]++;
        for (int j = 0; j < PL_CELL_CORNERS && w->node[i][j] >= 0; j++) {
            pl_watch_way *way = &w->late.way[w->node[i][j] + 1];
            if (way->length != 0 && way->star > last->star)
                last = way;
        }
        if (last->star < 0)
            continue;
        last->length = last->length > 0 ? -last->length : last->length;
        first = last->star < first ? last->star : first;
    }
    return first;
}

/** Undo the move of a star, and have later ones around it undone. */
static void undo(pl_watch *w, const pl_star_problem *problem, int64_t star, pl_star_tally *tally) {
    const int32_t node = problem->node[star];
    const pl_watch_record *record = &w->late.record[star];
    const int dim = w->plan->dim;
    memcpy(problem->coordinates + (int64_t)node * dim, record->before,
           (size_t)dim * sizeof *record->before);
    pl_watch_forget(w, node);
    problem->changed[node] = PL_CHANGED;
    if (w->has_large)
        w->has_large[node] = 1;
    for (int64_t k = problem->ring_offset[star]; k < problem->ring_offset[star + 1]; k++) {
        const int32_t other = problem->ring[k];
        pl_watch_way *way = &w->late.way[other + 1];
        if (way->length > 0 && way->star > star)
            way->length = -way->length;
        problem->changed[other] = PL_CHANGED;
        if (w->has_large)
            w->has_large[other] = 1;
    }
    pl_sum_add(&tally->decrease, -record->fall);
    tally->improved -= record->improved;
    tally->restored -= record->restored;
    w->n_refused++;
}

/** Decide the cells at a node whose move was undone. Returns the number of those that are broken. */
static int64_t decide_again(pl_watch *w, int32_t node) {
    int32_t cell[PL_WATCH_CELLS];
    int64_t n_broken = 0;
    int n = 0;
    for (int64_t k = w->begin[node]; k < w->begin[node + 1]; k++) {
        const int32_t i = w->watched[k];
        if (w->late.when[i] == PL_WATCH_AT_ONCE_BAD)
            w->state[i] = 0;
        else if (w->type[i])
            cell[n++] = i;
        if (n == PL_WATCH_CELLS) {
            n_broken += decide(w, n, cell);
            n = 0;
        }
    }
    n_broken += n > 0 ? decide(w, n, cell) : 0;
    pl_watch_look_again(w, node);
    return n_broken;
}

void pl_watch_end_sweep(pl_watch *w, const pl_star_problem *problem, int64_t n_stars,
                        pl_star_tally *tally) {
    look s = {.watch = w};
    if (!w->late.is_on)
        return;
    w->late.is_on = 0;
    pl_parallel_for(w->plan->threads, w->n, CHUNK, late_chunk, &s);
    while (s.n > 0) {
        const int64_t first = find_first(w, n_stars);
        s.n = 0;
        for (int64_t star = first; star < n_stars; star++)
            if (w->late.way[problem->node[star] + 1].length < 0)
                undo(w, problem, star, tally);
        for (int64_t star = first; star < n_stars; star++) {
            pl_watch_way *way = &w->late.way[problem->node[star] + 1];
            if (!(way->length < 0))
                continue;
            way->length = 0;
            s.n += decide_again(w, problem->node[star]);
        }
    }
}
