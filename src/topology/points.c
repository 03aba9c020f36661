/* points: coordinates as the caller has them: any stride, all nodes or some. */
#include "topology/points.h"

#include "base/parallel.h"
#include "base/status.h"

#include <inttypes.h>
#include <math.h>

enum { CHUNK = 4096 }; /* points that one thread takes at a time */

pl_points pl_points_of(const planish_mesh *mesh, const double *x) {
    return (pl_points){.x = x,
                       .n = mesh->n_nodes,
                       .dim = mesh->dim,
                       .step = mesh->node_stride ? mesh->node_stride : mesh->dim,
                       .apart = mesh->component_stride ? mesh->component_stride : 1};
}

int pl_points_are_dense(const pl_points *p) {
    return !p->node_of && p->step == p->dim && p->apart == 1;
}

/** The work on all points. */
typedef struct work {
    const pl_points *p;
    double *dense;
    int64_t lowest; /* point that is not finite, or INT64_MAX; shared */
} work;

static void gather_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const work *w = context;
    const pl_points *p = w->p;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int d = 0; d < p->dim; d++)
            w->dense[i * p->dim + d] = p->x[pl_point_at(p, i, d)];
}

void pl_points_gather(const pl_points *p, int threads, double *dense) {
    work w = {p, dense, 0};
    pl_parallel_for(threads, p->n, CHUNK, gather_chunk, &w);
}

static int is_finite(const pl_points *p, int64_t i) {
    int finite = 1;
    for (int d = 0; d < p->dim; d++)
        finite &= isfinite(p->x[pl_point_at(p, i, d)]) != 0;
    return finite;
}

static void check_chunk(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        if (!is_finite(w->p, i)) {
            pl_lower_to(&w->lowest, i);
            return;
        }
}

int pl_points_check(const pl_points *p, int threads, planish_error *error) {
    work w = {.p = p, .lowest = INT64_MAX};
    pl_parallel_for(threads, p->n, CHUNK, check_chunk, &w);
    if (w.lowest == INT64_MAX)
        return PLANISH_OK;
    const int64_t node = p->node_of ? p->node_of[w.lowest] : w.lowest;
    int d = 0;
    while (d < p->dim - 1 && isfinite(p->x[pl_point_at(p, w.lowest, d)]))
        d++;
    return pl_fail_at(error, PLANISH_ERROR_MESH, -1, node,
                      "node %" PRId64 " has the coordinate %c = %g; all must be finite numbers",
                      node, "xyz"[d], p -> x[pl_point_at(p, w.lowest, d)]);
}
