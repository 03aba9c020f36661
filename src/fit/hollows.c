/* hollows: which pieces of the outside of a shape lie in others.
 *
 * A closed piece that lies in an odd number of other closed ones is a hollow. A ray from a facet of a piece leaves what
 * the piece lies in: each other piece goes around the facet as often as the ray passes it out of its body more than into
 * it. Seen along the ray an edge has the same side of it for all its facets, so that a ray through an edge or node
 * passes one of them. */
#include "fit/hollows.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "topology/topology.h"

#include <stdlib.h>

/* A piece lies in another one if so many of its facets do, which are spread over it. */
enum { SAMPLES = 3, CHUNK = 16 /* pieces */ };

/** A ray passes a facet of another piece. */
typedef struct passing {
    int32_t piece;
    int16_t sample; /* of the ray */
    int16_t turn;   /* 1 or -1: out of the other piece, or into it */
} passing;

/** Passings, owned. */
typedef struct passings {
    passing *item;
    int64_t n, capacity;
} passings;

/** A search for hollows. */
typedef struct hollows {
    const planish_shape *shape;
    const pl_tree *tree;
    pl_fit_pieces *pieces;
    pl_incidence facets; /* of the pieces */
    passings *passings;  /* [threads] of the rays from a piece */
    int failed;          /* there is no memory; shared by threads */
} hollows;

/** Rays from a piece, along x. */
typedef struct rays {
    const hollows *hollows;
    int32_t piece;
    int sample;
    double from[3];
    passings *passings;
    int failed; /* there is no memory */
} rays;

/** The piece of a facet, as pl_nodes_of_fn. */
static int piece_of(const void *context, int64_t facet, int32_t node[PL_CELL_NODES]) {
    const pl_fit_pieces *pieces = context;
    node[0] = pieces->of[facet];
    return 1;
}

static int is_box_in(const pl_box3 *in, const pl_box3 *out) {
    int is_in = 1;
    for (int d = 0; d < 3; d++)
        is_in &= in->lower[d] > out->lower[d] && in->upper[d] < out->upper[d];
    return is_in;
}

/** Which way the edge from a to b passes the half line from a point along y, seen along x: 1, -1, or 0. */
static int passes(const double a[3], const double b[3], const double from[3]) {
    const int is_up = a[2] <= from[2];
    const double *low = is_up ? a : b, *high = is_up ? b : a;
    if (is_up == (b[2] <= from[2]))
        return 0;
    const int is_left =
        (high[1] - low[1]) * (from[2] - low[2]) > (from[1] - low[1]) * (high[2] - low[2]);
    return is_left ? 2 * is_up - 1 : 0;
}

/** Which way the ray from a point along x passes a facet: 1: to where its normal points; -1; 0: it does not. */
static int passes_facet(const planish_shape *s, int32_t facet, const double from[3]) {
    const int32_t *v = s->facet[facet];
    double a[3], b[3], to[3], across[3];
    int turn = 0;
    for (int k = 0; k < 3; k++)
        turn += passes(s->x[v[k]], s->x[v[(k + 1) % 3]], from);
    pl_from_to(3, s->x[v[0]], s->x[v[1]], a);
    pl_from_to(3, s->x[v[0]], s->x[v[2]], b);
    pl_from_to(3, from, s->x[v[0]], to);
    pl_cross(a, b, across);
    return turn * pl_dot(3, to, across) > 0 ? turn : 0;
}

/** Let the ray of a sample meet a facet, as pl_tree_found_fn. */
static int meet(void *context, int32_t facet) {
    rays *r = context;
    const hollows *h = r->hollows;
    const pl_fit_pieces *pieces = h->pieces;
    const int32_t other = pieces->of[facet];
    if (other < 0 || !pieces->is_closed[other] ||
        !is_box_in(&pieces->box[r->piece], &pieces->box[other]))
        return 0;
    const int turn = passes_facet(h->shape, facet, r->from);
    const passing one = {other, (int16_t)r->sample, (int16_t)turn};
    passings *all = r->passings;
    if (turn && !pl_append(&all->item, &all->n, &all->capacity, &one, sizeof one))
        r->failed = 1;
    return 0;
}

/** Send rays from the middles of facets that are spread over a piece. */
static void send_rays(rays *r) {
    const hollows *h = r->hollows;
    const planish_shape *s = h->shape;
    const int64_t begin = h->facets.offset[r->piece], n = h->facets.offset[r->piece + 1] - begin;
    for (r->sample = 0; r->sample < SAMPLES; r->sample++) {
        const int32_t *v = s->facet[h->facets.element[begin + n * r->sample / SAMPLES]];
        pl_box3 along;
        for (int d = 0; d < 3; d++)
            r->from[d] = along.lower[d] = along.upper[d] =
                (s->x[v[0]][d] + s->x[v[1]][d] + s->x[v[2]][d]) / 3;
        along.upper[0] = INFINITY;
        pl_tree_find(h->tree, &along, NULL, meet, r);
    }
}

/** Order passings by pieces, for qsort. */
static int compare(const void *a, const void *b) {
    const int32_t p = ((const passing *)a)->piece, q = ((const passing *)b)->piece;
    return (p > q) - (p < q);
}

/** Return how many pieces the piece of rays lies in. *nest: the widest one of these; -1: there is none. */
static int count_around(const rays *r, int32_t *nest) {
    const passings *all = r->passings;
    double widest = 0;
    int n = 0;
    *nest = -1;
    if (all->n > 0)
        qsort(all->item, (size_t)all->n, sizeof *all->item, compare);
    for (int64_t k = 0; k < all->n;) {
        const int32_t other = all->item[k].piece;
        const pl_box3 *box = &r->hollows->pieces->box[other];
        const double width = box->upper[0] - box->lower[0];
        int64_t around[SAMPLES] = {0}; /* how often the other piece goes around each sample */
        for (; k < all->n && all->item[k].piece == other; k++)
            around[all->item[k].sample] += all->item[k].turn;
        if (!around[0] || !around[1] || !around[2])
            continue;
        *nest = width > widest ? other : *nest;
        widest = fmax(widest, width);
        n++;
    }
    return n;
}

/** Find the nests of the pieces of a stretch, and turn those that are in an odd number of others. */
static void turn_hollows(void *context, int64_t begin, int64_t end, int thread) {
    hollows *h = context;
    pl_fit_pieces *pieces = h->pieces;
    for (int32_t i = (int32_t)begin; i < end; i++) {
        rays r = {.hollows = h, .piece = i, .passings = &h->passings[thread]};
        r.passings->n = 0;
        if (pieces->is_closed[i])
            send_rays(&r);
        if (r.failed)
            __atomic_store_n(&h->failed, 1, __ATOMIC_RELAXED);
        if (count_around(&r, &pieces->nest[i]) % 2)
            pieces->turn[i] = (int8_t)-pieces->turn[i];
    }
}

/** Make each outermost piece one of its own nest. */
static void join_outermost(pl_fit_pieces *pieces) {
    for (int32_t i = 0; i < pieces->n; i++) {
        const int32_t nest = pieces->nest[i];
        if (nest >= 0 && pieces->nest[nest] < 0)
            pieces->nest[nest] = nest;
    }
}

static void free_room(hollows *h, int threads) {
    for (int i = 0; h->passings && i < threads; i++)
        pl_free(h->passings[i].item);
    pl_free(h->passings);
    pl_incidence_destroy(&h->facets);
}

int pl_fit_turn_hollows(const planish_shape *shape, const pl_tree *facets, int threads,
                        pl_fit_pieces *pieces, planish_error *error) {
    hollows h = {.shape = shape, .tree = facets, .pieces = pieces};
    pieces->nest = pl_alloc(pieces->n, sizeof *pieces->nest);
    h.passings = pl_alloc_zero(threads, sizeof *h.passings);
    const int have = pieces->nest && h.passings &&
                     pl_items_of_nodes(pieces->n, shape->n_facets, piece_of, pieces, 1, &h.facets);
    if (have) {
        pl_parallel_for(threads, pieces->n, CHUNK, turn_hollows, &h);
        join_outermost(pieces);
    }
    free_room(&h, threads);
    return have && !h.failed ? PLANISH_OK : pl_fail_memory(error, "the pieces of a surface");
}
