/* mids: nodes in the middle of edges: their ends, places, and the way to the caller. */
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

void pl_mids_note(pl_mids *m, int64_t element, const pl_cell_type *type) {
    const planish_plan *plan = m->plan;
    const int corners = plan->dim + 1;
    const int32_t *corner = plan->work.elements + element * corners;
    const int32_t *node = plan->cells.node + plan->cells.offset[pl_plan_element(plan, element)];
    for (int i = corners; i < type->n_nodes; i++) {
        const int32_t a = corner[type->between[i][0]], b = corner[type->between[i][1]];
        if (node[i] < 0)
            continue;
        __atomic_store_n(&m->end[node[i]][0], a < b ? a : b, __ATOMIC_RELAXED);
        __atomic_store_n(&m->end[node[i]][1], a < b ? b : a, __ATOMIC_RELAXED);
    }
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
    pl_free(mids->own);
    mids->end = NULL;
    mids->own = NULL;
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

void pl_mid_place(const pl_mids *m, int32_t node, double *x) {
    const planish_plan *plan = m->plan;
    const int dim = plan->dim;
    const int32_t *end = m->end[node];
    start_of(m, node, x);
    if (end[0] < 0)
        return;
    double way[2][3];
    for (int k = 0; k < 2; k++)
        for (int d = 0; d < dim; d++)
            way[k][d] = plan->scratch.coordinates[(int64_t)plan->inner[end[k]] * dim + d] -
                        m->given[(int64_t)end[k] * dim + d];
    for (int d = 0; d < dim; d++)
        x[d] = pl_mid_coordinate(m, node, d, way[0][d], way[1][d]);
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
        if (m->end[i][0] < 0)
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
