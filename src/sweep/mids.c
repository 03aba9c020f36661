/* mids: nodes of order 2, which follow corners: their parents, places, and the way to the caller. */
#include "sweep/watch.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "geometry/simplex.h"

#include <math.h>
#include <string.h>

enum { CHUNK = 4096 }; /* nodes that one thread takes at a time */

static const double *start_of(const pl_mids *m, int32_t node, double *room) {
    for (int d = 0; d < m->start.dim; d++)
        room[d] = m->start.x[pl_point_at(&m->start, node, d)];
    return room;
}

int pl_plan_cell_corners(const planish_plan *plan, int64_t cell, int32_t corner[PL_CELL_CORNERS]) {
    const int64_t first = pl_first_of_cell(&plan->work, cell);
    const int dim = plan->dim;
    const int32_t *of_first = plan->work.elements + first * (dim + 1);
    const int kind = plan->work.corner ? pl_corner_kind(plan->work.corner[first]) : PL_KIND_SIMPLEX;
    if (kind == PL_KIND_SIMPLEX) {
        for (int j = 0; j <= dim; j++)
            corner[j] = of_first[j];
        return dim + 1;
    }
    int n = 0; /* each corner's simplex begins with it */
    for (int64_t e = first; e < plan->work.cell_begin[cell + 1]; e++)
        corner[n++] = plan->work.elements[e * (dim + 1)];
    if (kind == PL_KIND_PYRAMID)
        corner[n++] = of_first[dim];
    return n;
}

static void set(int32_t *to, int32_t node) {
    __atomic_store_n(to, node, __ATOMIC_RELAXED);
}

/** Set parents to the corners in a mask, ascending, -1 after the last. */
static void note_parents(const int32_t *corner, uint8_t mask, int32_t *parents) {
    int32_t sorted[PL_CELL_CORNERS] = {0};
    int n = 0;
    for (int c = 0; c < PL_CELL_CORNERS; c++) {
        int at = n;
        if (!(mask >> c & 1))
            continue;
        for (n++; at > 0 && sorted[at - 1] > corner[c]; at--)
            sorted[at] = sorted[at - 1];
        sorted[at] = corner[c];
    }
    for (int i = 0; i < PL_CELL_CORNERS; i++)
        set(&parents[i], i < n ? sorted[i] : -1);
}

void pl_mids_note(pl_mids *m, int64_t cell, const pl_cell_type *type, int numbered) {
    const planish_plan *plan = m->plan;
    int32_t corner[PL_CELL_CORNERS];
    const int64_t of_caller = pl_plan_element(plan, pl_first_of_cell(&plan->work, cell));
    const int32_t *node = plan->cells.node + plan->cells.offset[of_caller];
    pl_plan_cell_corners(plan, cell, corner);
    for (int i = type->shape->n_corners; i < type->n_nodes; i++) {
        const int32_t a = corner[type->between[i][0]], b = corner[type->between[i][1]];
        if (node[i] < 0)
            continue;
        const uint8_t parents = pl_cell_parents(type, i);
        int32_t *end = m->end[node[i]];
        const int is_edge = __builtin_popcount(parents) == 2;
        if (numbered && !is_edge && end[0] == PL_OF_MORE)
            note_parents(corner, parents, m->more[end[1]]);
        if (numbered)
            continue;
        set(&end[0], !is_edge ? PL_OF_MORE : a < b ? a : b);
        if (is_edge)
            set(&end[1], a < b ? b : a);
    }
}

int pl_mids_number(pl_mids *m, planish_error *error) {
    for (int64_t i = 0; i < m->start.n; i++)
        if (m->end[i][0] == PL_OF_MORE)
            m->end[i][1] = (int32_t)m->n_more++;
    if (m->n_more > 0)
        m->more = pl_alloc(m->n_more, sizeof *m->more);
    return m->n_more > 0 && !m->more ? pl_fail_memory(error, "the nodes of elements of order 2")
                                     : PLANISH_OK;
}

int pl_mids_create(const planish_plan *plan, const planish_options *options, const double *given,
                   const double *start, pl_mids *mids, planish_error *error) {
    const int64_t n = plan->whole.n_nodes;
    *mids = (pl_mids){.plan = plan,
                      .given = given,
                      .start = {.x = start,
                                .n = n,
                                .dim = plan->dim,
                                .step = plan->node_stride,
                                .apart = plan->component_stride},
                      .storage = pl_storage_of(options),
                      .end = pl_alloc(n, sizeof *mids->end)};
    if (!mids->end)
        return pl_fail_memory(error, "the mids of edges");
    memset(mids->end, -1, (size_t)n * sizeof *mids->end);
    return PLANISH_OK;
}

void pl_mids_destroy(pl_mids *mids) {
    pl_free(mids->end);
    pl_free(mids->more);
    pl_free(mids->own);
    *mids = (pl_mids){.n_more = 0};
}

int pl_mids_release(pl_mids *mids, planish_error *error) {
    if (!mids->own)
        mids->own = pl_alloc_zero(mids->start.n * mids->start.dim, sizeof *mids->own);
    return mids->own ? PLANISH_OK : pl_fail_memory(error, "the mids of edges");
}

int64_t pl_mids_put_back(const pl_mids *m, int64_t element) {
    const planish_cells *cells = &m->plan->cells;
    const int64_t cell = pl_plan_element(m->plan, element);
    int64_t n = 0;
    for (int64_t k = cells->offset[cell]; k < cells->offset[cell + 1]; k++) {
        const int32_t node = cells->node[k];
        if (node < 0 || !pl_mid_has_moved(m, node))
            continue;
        n++;
        for (int d = 0; d < m->start.dim; d++)
            m->own[(int64_t)node * m->start.dim + d] = 0;
    }
    return n;
}

/** Direction d of the way of a node of the plan since the run began, to where it is at now. */
static double way_of(const pl_mids *m, const double *now, int32_t node, int d) {
    const int dim = m->plan->dim;
    return now[(int64_t)m->plan->inner[node] * dim + d] - m->given[(int64_t)node * dim + d];
}

int pl_mid_parents(const pl_mids *m, int32_t node, const int32_t **parent) {
    const int32_t *end = m->end[node];
    *parent = end[0] == PL_OF_MORE ? m->more[end[1]] : end;
    if (end[0] == PL_NO_MID)
        return 0;
    int n = 2;
    while (end[0] == PL_OF_MORE && n < PL_CELL_CORNERS && (*parent)[n] >= 0)
        n++;
    return n;
}

void pl_mid_place_by(const pl_mids *m, int32_t node, const double *now, const double *own,
                     double *x) {
    const int dim = m->plan->dim;
    const int32_t *parent;
    const int n = pl_mid_parents(m, node, &parent);
    start_of(m, node, x);
    if (n == 0)
        return;
    for (int d = 0; d < dim; d++) {
        double way = way_of(m, now, parent[0], d);
        for (int k = 1; k < n; k++)
            way += way_of(m, now, parent[k], d);
        x[d] = pl_mid_coordinate_by(m, node, d, way / n, own ? own[d] : 0);
    }
}

void pl_mid_place(const pl_mids *m, int32_t node, double *x) {
    pl_mid_place_by(m, node, m->plan->scratch.coordinates, pl_mid_own(m, node), x);
}

/** Mids on the way to the caller. */
typedef struct transfer {
    const pl_mids *mids;
    double *coordinates; /* NULL: only look */
    int64_t moved;
    double farthest;
} transfer;

static void write_chunk(void *context, int64_t begin, int64_t end, int thread) {
    transfer *t = context;
    const pl_mids *m = t->mids;
    int64_t moved = 0;
    double farthest = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        double before[3], now[3];
        if (m->end[i][0] == PL_NO_MID)
            continue;
        start_of(m, (int32_t)i, before);
        pl_mid_place(m, (int32_t)i, now);
        const double far = pl_distance(m->start.dim, now, before);
        moved += far > 0;
        farthest = fmax(farthest, far);
        for (int d = 0; d < m->start.dim && far > 0 && t->coordinates; d++)
            t->coordinates[pl_point_at(&m->start, i, d)] = now[d];
    }
    pl_raise_double(&t->farthest, farthest);
    __atomic_fetch_add(&t->moved, moved, __ATOMIC_RELAXED);
}

void pl_mids_write(const pl_mids *mids, int writes, double *coordinates, int64_t *moved,
                   double *farthest) {
    transfer t = {.mids = mids, .coordinates = writes ? coordinates : NULL};
    pl_parallel_for(mids->plan->threads, mids->start.n, CHUNK, write_chunk, &t);
    *moved += t.moved;
    *farthest = fmax(*farthest, t.farthest);
}
