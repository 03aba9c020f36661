/* positions: where the nodes of a run are, in the caller's numbering. */
#include "sweep/positions.h"

#include "base/parallel.h"
#include "geometry/simplex.h"

enum { CHUNK = 4096 }; /* nodes that one thread takes at a time */

/** Positions on the way to the caller. */
typedef struct filling {
    const pl_positions *from;
    pl_points to; /* of the plan's nodes */
    double *coordinates;
} filling;

static void fill_nodes(void *context, int64_t begin, int64_t end, int thread) {
    const filling *f = context;
    const planish_plan *plan = f->from->plan;
    const int dim = plan->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const double *start = f->from->given + i * dim;
        const double *now = f->from->now + (int64_t)plan->inner[i] * dim;
        const double *place = pl_distance(dim, now, start) > 0 ? now : start;
        for (int d = 0; d < dim; d++)
            f->coordinates[pl_point_at(&f->to, i, d)] = place[d];
    }
}

static void fill_mids(void *context, int64_t begin, int64_t end, int thread) {
    const filling *f = context;
    const pl_positions *from = f->from;
    const pl_mids *mids = from->mids;
    const int dim = mids->start.dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int32_t node = (int32_t)i;
        double start[3], now[3];
        if (mids->end[node][0] == PL_NO_MID)
            continue;
        for (int d = 0; d < dim; d++)
            start[d] = mids->start.x[pl_point_at(&mids->start, i, d)];
        const double *own = pl_skin_saved_own(from->skin, from->saved, node);
        pl_mid_place_by(mids, node, from->now, own ? own : pl_mid_own(mids, node), now);
        const double *place = pl_distance(dim, now, start) > 0 ? now : start;
        for (int d = 0; d < dim; d++)
            f->coordinates[pl_point_at(&mids->start, i, d)] = place[d];
    }
}

void pl_positions_fill(const void *positions, double *coordinates) {
    const pl_positions *p = positions;
    filling f = {p, pl_plan_points(p->plan, coordinates), coordinates};
    pl_parallel_for(p->plan->threads, p->plan->work.n_nodes, CHUNK, fill_nodes, &f);
    if (p->mids)
        pl_parallel_for(p->plan->threads, p->mids->start.n, CHUNK, fill_mids, &f);
}
