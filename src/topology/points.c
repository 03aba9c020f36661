/* points: coordinates as the caller has them: any stride, all nodes or some; and rows of arrays. */
#include "topology/points.h"

#include "base/hash.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

enum { CHUNK = 4096 }; /* points or rows that one thread takes at a time */

pl_points pl_points_of(const planish_mesh *mesh, const double *x) {
    return (pl_points){.x = x,
                       .n = mesh->n_nodes,
                       .dim = mesh->dim,
                       .step = mesh->node_stride ? mesh->node_stride : mesh->dim,
                       .apart = mesh->component_stride ? mesh->component_stride : 1};
}

/** A pass over all points. */
typedef struct points_pass {
    const pl_points *p;
    double *dense;
    int64_t lowest; /* point that is not finite, or INT64_MAX; shared */
} points_pass;

static void gather_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const points_pass *pass = context;
    const pl_points *p = pass->p;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int d = 0; d < p->dim; d++)
            pass->dense[i * p->dim + d] = p->x[pl_point_at(p, i, d)];
}

void pl_points_gather(const pl_points *p, int threads, double *dense) {
    points_pass pass = {p, dense, 0};
    pl_parallel_for(threads, p->n, CHUNK, gather_chunk, &pass);
}

static void check_chunk(void *context, int64_t begin, int64_t end, int thread) {
    points_pass *pass = context;
    const pl_points *p = pass->p;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        int finite = 1;
        for (int d = 0; d < p->dim; d++)
            finite &= isfinite(p->x[pl_point_at(p, i, d)]) != 0;
        if (!finite) {
            pl_lower_to(&pass->lowest, i);
            return;
        }
    }
}

int pl_points_check(const pl_points *p, int threads, planish_error *error) {
    points_pass pass = {.p = p, .lowest = INT64_MAX};
    pl_parallel_for(threads, p->n, CHUNK, check_chunk, &pass);
    if (pass.lowest == INT64_MAX)
        return PLANISH_OK;
    const int64_t node = p->node_of ? p->node_of[pass.lowest] : pass.lowest;
    int d = 0;
    while (d < p->dim - 1 && isfinite(p->x[pl_point_at(p, pass.lowest, d)]))
        d++;
    return pl_fail_at(error, PLANISH_ERROR_MESH, -1, node,
                      "node %" PRId64 " has the coordinate %c = %g; all must be finite numbers",
                      node, "xyz"[d], p -> x[pl_point_at(p, pass.lowest, d)]);
}

/* ---- points at the same place ------------------------------------------------------------------
 */

/** A number for the bits of a place; -0 and 0 are the same. */
static uint64_t place_hash(pl_hash hash, const pl_points *p, int64_t i) {
    for (int d = 0; d < p->dim; d++) {
        const double coordinate = p->x[pl_point_at(p, i, d)] + 0.0;
        uint64_t bits;
        memcpy(&bits, &coordinate, sizeof bits);
        pl_hash_add(&hash, bits);
    }
    return pl_hash_end(hash);
}

static int same_place(const pl_points *p, int64_t a, int64_t b) {
    for (int d = 0; d < p->dim; d++)
        if (p->x[pl_point_at(p, a, d)] != p->x[pl_point_at(p, b, d)])
            return 0;
    return 1;
}

int pl_points_find_doubled(const pl_points *points, uint8_t *is_doubled, planish_error *error) {
    int64_t n_slots = 16;
    while (n_slots < 2 * points->n)
        n_slots *= 2;
    int32_t *slot = pl_alloc(n_slots, sizeof *slot);
    if (!slot)
        return pl_fail_memory(error, "the places of nodes");
    memset(slot, -1, (size_t)n_slots * sizeof *slot);
    memset(is_doubled, 0, (size_t)points->n);
    const pl_hash hash = pl_hash_draw(slot);
    for (int32_t i = 0; i < points->n; i++) {
        int64_t at = (int64_t)(place_hash(hash, points, i) & (uint64_t)(n_slots - 1));
        while (slot[at] >= 0 && !same_place(points, slot[at], i))
            at = (at + 1) & (n_slots - 1);
        if (slot[at] >= 0)
            is_doubled[slot[at]] = is_doubled[i] = 1;
        else
            slot[at] = i;
    }
    pl_free(slot);
    return PLANISH_OK;
}

/* ---- rows of arrays ------------------------------------------------------------------------ */

/** Rows of size bytes on their way from one array to another. */
typedef struct copying {
    const int32_t *row;
    const char *from;
    char *to;
    size_t size;
} copying;

static void take_rows(void *context, int64_t begin, int64_t end, int thread) {
    const copying *c = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        memcpy(c->to + (size_t)i * c->size, c->from + (size_t)c->row[i] * c->size, c->size);
}

static void put_rows(void *context, int64_t begin, int64_t end, int thread) {
    const copying *c = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        memcpy(c->to + (size_t)c->row[i] * c->size, c->from + (size_t)i * c->size, c->size);
}

void pl_rows_put(const void *from, const int32_t *row, int64_t n, size_t size, int threads,
                 void *to) {
    copying c = {row, from, to, size};
    if (row)
        pl_parallel_for(pl_paying_threads(threads, n), n, CHUNK, put_rows, &c);
    else
        memcpy(to, from, (size_t)n * size);
}

void *pl_rows_take(const void *from, const int32_t *row, int64_t n, size_t size, int threads,
                   int *failed) {
    if (!from)
        return NULL;
    copying c = {row, from, pl_alloc(n, size), size};
    if (c.to)
        pl_parallel_for(threads, n, CHUNK, take_rows, &c);
    *failed |= !c.to;
    return c.to;
}
