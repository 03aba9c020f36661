/* crossings: facets that have come to go through others.
 *
 * Sheets that face one another across a gap are held from the start (shape/gaps.h). That does not
 * prove that no facets meet: a border may be near to a sheet that it does not face, and a facet that slides
 * to where facets are smaller keeps its own tolerance. So what has moved is looked at in the end, by
 * exact signs.
 */
#include "surface/crossings.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "quality/certificate.h"
#include "shape/tree.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

enum { CHUNK = 256 };

typedef struct crossing_search {
    const pl_surface_run *run;
    pl_tree tree;
    pl_box3 *box;     /* [n_facets] where they are */
    uint8_t *has_met; /* [n_facets] 1: it goes through another one, and did not at the start */
} crossing_search;

/** A search from one facet. */
typedef struct look {
    const crossing_search *search;
    int32_t facet;
} look;

static int has_moved(const pl_surface_run *r, int32_t facet) {
    const int32_t *v = r->shape->facet[facet];
    for (int k = 0; k < 3; k++)
        if (!pl_skin_is_at(r->x[v[k]], r->start[v[k]]))
            return 1;
    return 0;
}

static int sign(const double *a, const double *b, const double *c, const double *d) {
    return pl_measure_sign(3, (const double *const[]){a, b, c, d});
}

/** Whether the segment from p to q goes through the inside of a facet of x. */
static int goes_through(const double *p, const double *q, const double *const x[3]) {
    const int from = sign(x[0], x[1], x[2], p), to = sign(x[0], x[1], x[2], q);
    if (from * to >= 0)
        return 0;
    const int side = sign(p, q, x[0], x[1]);
    return side != 0 && sign(p, q, x[1], x[2]) == side && sign(p, q, x[2], x[0]) == side;
}

/** Whether an edge of a that has no node of b goes through b. */
static int edges_go_through(const planish_shape *s, const double (*at)[3], int32_t a, int32_t b) {
    const int32_t *v = s->facet[a], *w = s->facet[b];
    const double *const x[3] = {at[w[0]], at[w[1]], at[w[2]]};
    for (int k = 0; k < 3; k++) {
        const int32_t from = v[k], to = v[(k + 1) % 3];
        int shared = 0;
        for (int j = 0; j < 3; j++)
            shared |= w[j] == from || w[j] == to;
        if (!shared && goes_through(at[from], at[to], x))
            return 1;
    }
    return 0;
}

static int cross(const planish_shape *s, const double (*at)[3], int32_t a, int32_t b) {
    return edges_go_through(s, at, a, b) || edges_go_through(s, at, b, a);
}

/** Whether the edge after corner k of a facet meets the box of another one. */
static int edge_meets(const crossing_search *c, int32_t facet, int k, int32_t other) {
    const pl_box3 *box = &c->box[other];
    const int32_t *v = c->run->shape->facet[facet];
    const double *p = c->run->x[v[k]], *q = c->run->x[v[(k + 1) % 3]];
    int meets = 1;
    for (int d = 0; d < 3; d++)
        meets &= (p[d] <= box->upper[d] || q[d] <= box->upper[d]) &&
                 (p[d] >= box->lower[d] || q[d] >= box->lower[d]);
    return meets;
}

/** Whether facets whose boxes meet may cross: of two that share a node only the edges opposite to it go through
 *  the other one, and if they share two nodes none does. */
static int may_cross(const crossing_search *c, int32_t a, int32_t b) {
    const int32_t *v = c->run->shape->facet[a], *w = c->run->shape->facet[b];
    for (int k = 0; k < 3; k++)
        for (int j = 0; j < 3; j++)
            if (v[k] == w[j])
                return edge_meets(c, a, (k + 1) % 3, b) || edge_meets(c, b, (j + 1) % 3, a);
    return 1;
}

static int look_at_facet(void *context, int32_t other) {
    const look *l = context;
    const pl_surface_run *r = l->search->run;
    const int is_seen = other == l->facet || (other < l->facet && has_moved(r, other));
    if (is_seen || !may_cross(l->search, l->facet, other) ||
        !cross(r->shape, (const double(*)[3])r->x, l->facet, other) ||
        cross(r->shape, (const double(*)[3])r->start, l->facet, other))
        return 0;
    pl_set_flag(&l->search->has_met[l->facet], 1);
    pl_set_flag(&l->search->has_met[other], 1);
    return 0;
}

static void find_box(void *context, int64_t begin, int64_t end, int thread) {
    const crossing_search *c = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int32_t *v = c->run->shape->facet[i];
        const double(*x)[3] = (const double(*)[3])c->run->x;
        for (int d = 0; d < 3; d++) {
            c->box[i].lower[d] = fmin(x[v[0]][d], fmin(x[v[1]][d], x[v[2]][d]));
            c->box[i].upper[d] = fmax(x[v[0]][d], fmax(x[v[1]][d], x[v[2]][d]));
        }
    }
}

static void search_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const crossing_search *c = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        look l = {c, (int32_t)i};
        if (has_moved(c->run, (int32_t)i))
            pl_tree_find(&c->tree, &c->box[i], NULL, look_at_facet, &l);
    }
}

/** Find the facets that have come to cross others. Errors: _MEMORY. */
static int find_crossings(const pl_surface_run *r, uint8_t *has_met, planish_error *error) {
    const int64_t n = r->shape->n_facets;
    crossing_search c = {.run = r, .has_met = has_met};
    c.box = pl_alloc(n, sizeof *c.box);
    if (!c.box)
        return pl_fail_memory(error, "the surface of a mesh");
    pl_parallel_for(r->threads, n, CHUNK, find_box, &c);
    const int status = pl_tree_create(n, c.box, r->threads, &c.tree, error);
    if (!status)
        pl_parallel_for(r->threads, n, CHUNK, search_chunk, &c);
    pl_tree_destroy(&c.tree);
    pl_free(c.box);
    return status;
}

int pl_surface_hold_crossings(const pl_surface_run *r, uint8_t *held, int64_t *n_held,
                              planish_error *error) {
    const planish_shape *s = r->shape;
    uint8_t *has_met = pl_alloc_zero(s->n_facets, sizeof *has_met);
    const int status = has_met ? find_crossings(r, has_met, error)
                               : pl_fail_memory(error, "the surface of a mesh");
    *n_held = 0;
    for (int64_t t = 0; !status && t < s->n_facets; t++)
        for (int k = 0; has_met[t] && k < 3; k++) {
            const int32_t node = s->facet[t][k];
            *n_held += !held[node];
            held[node] = 1;
        }
    pl_free(has_met);
    if (*n_held > 0)
        pl_log(PLANISH_LOG_NOTE,
               "%" PRId64 " nodes are held from now on, because facets there crossed others; the "
               "run begins again",
               *n_held);
    return status;
}
