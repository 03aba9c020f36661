/* distance: how far a surface that has moved is off the first one, and the first one off it.
 *
 * Both ways it is the overlay of each facet. For the way back the roles are swapped: the new surface
 * is a shape of the same facets, and places on it are walked to. Where the overlay says nothing, as
 * at folds, a facet is divided (divide.h). That takes a hundred times as long. The largest bounds are sharpened that
 * way in the end: they are what is reported. */
#include "shape/distance.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "shape/divide.h"
#include "shape/overlay.h"

#include <string.h>

enum { FACETS = 64, /* of a chunk */ DEEP = 6 /* division of a facet */ };

/* Parts of a facet, and of all facets, that are looked at to sharpen bounds. */
enum { MOST_OF_FACET = 1 << 13, MOST_PIECES = 1 << 18 };

/* A bound that is this much above the distance of one point is good enough, */
#define GOOD 1.05
/* and this much the largest ones. */
#define CLOSE 1.0001

/* A patch is planar if its nodes are off by no more than this, in mean edges. */
#define FLAT 1e-3

/* ---- all facets --------------------------------------------------------------------------- */

enum { THERE, BACK, WAYS };

typedef struct pl_measuring {
    /* The new surface is a shape of the same facets, by its x. */
    planish_shape surface[WAYS]; /* from which distances are: the first one, the new one */
    pl_tree tree[WAYS];          /* their facets */
    const pl_place *place;
    double (*bound)[WAYS]; /* [n_facets] */
    double *h;             /* [n_facets] mean edge there */
    double (*extra)
        [WAYS]; /* [n_facets] of second order: how far the facet itself is off its triangle; else
                              NULL */
    double *most_of; /* [n_facets] likewise: another bound, both ways */
    double *
        edge; /* [n_facets] likewise: how far an edge of a planar patch is off where it was, with how
                     far the patch is from a plane; infinite: it is none */
    int64_t n_open[WAYS]; /* facets about which the overlay says nothing */
    double most[WAYS],
        most_h[WAYS]; /* largest bounds of the others, in units of length and edges */
} pl_measuring;

/** Facet i of the surface that is not the target. */
static pl_moved_facet facet_of(const pl_measuring *m, int way, int64_t i) {
    pl_moved_facet t = {.facet = (int32_t)i};
    for (int k = 0; k < 3; k++) {
        const int32_t node = m->surface[way].facet[i][k];
        memcpy(t.x[k], m->surface[!way].x[node], sizeof t.x[k]);
        t.place[k] = m->place[node];
        if (way == BACK)
            t.place[k].at = -1;
    }
    if (m->surface[way].whole) {
        double x[PL_WHOLE_NODES][3];
        pl_whole_nodes(&m->surface[!way], pl_whole_of(&m->surface[way], t.facet), x);
        pl_set_rises(&m->surface[way], (const double(*)[3])x, &t);
    }
    return t;
}

/** The unit of bounds of facet i: a length, or its mean edge. */
static double unit_at(const pl_measuring *m, int by_edges, int64_t i) {
    return by_edges ? m->h[i] : 1;
}

/** How far a facet is off its triangle. */
static double extra_of(const pl_measuring *m, int way, int64_t i) {
    return m->extra ? m->extra[i][way] : 0;
}

/** The lowest one of a bound of a facet and others that are known. A planar patch and what it has become
 *  are the same but for what edges go over: those of the facet itself, and those of facets over it. */
static double capped(const pl_measuring *m, int way, const pl_moved_facet *t, double bound) {
    if (!m->most_of)
        return bound;
    bound = fmin(bound, m->most_of[t->facet]);
    if (!(m->edge[t->facet] < bound))
        return bound;
    const double over = pl_overlay_most(&m->surface[way], t, m->edge);
    return fmin(bound, fmax(over, m->edge[t->facet]) * (1 + 0x1p-40));
}

/** Bound the distances of facets by overlays. */
static void overlay_facets(void *context, int64_t begin, int64_t end, int thread) {
    (void)thread;
    pl_measuring *m = context;
    for (int64_t i = begin; i < end; i++) {
        m->h[i] = pl_shape_edge(&m->surface[THERE], (int32_t)i);
        for (int way = 0; way < WAYS; way++) {
            const planish_shape *s = &m->surface[way];
            const pl_moved_facet t = facet_of(m, way, i);
            const double bound = pl_overlay_bound(s, &t, pl_overlay_lateral(s, &t), INFINITY);
            m->bound[i][way] = bound < INFINITY ? capped(m, way, &t, bound) : bound;
            if (bound == INFINITY) {
                __atomic_fetch_add(&m->n_open[way], 1, __ATOMIC_RELAXED);
            } else if (m->bound[i][way] > 0) {
                pl_raise_double(&m->most[way], m->bound[i][way]);
                pl_raise_double(&m->most_h[way], m->bound[i][way] / m->h[i]);
            }
        }
    }
}

/** Whether a corner of a facet is a node of very many facets: near to it a tree leads to all of these. */
static int is_at_hub(const planish_shape *s, int64_t facet) {
    const int32_t *v = s->facet[facet];
    return pl_is_hub(s, v[0]) || pl_is_hub(s, v[1]) || pl_is_hub(s, v[2]);
}

/** Prepare the division of a facet. */
static pl_division division_of(const pl_measuring *m, int way, int64_t i, double close,
                               double known) {
    const planish_shape *s = &m->surface[way];
    return (pl_division){.shape = s,
                         .tree = is_at_hub(s, i) ? NULL : &m->tree[way],
                         .patch = s->patch[i],
                         .turns = 1,
                         .close = close,
                         .known = known,
                         .most_pieces = MOST_OF_FACET};
}

/** Divide facets that have no bound, as far as they are beyond the largest ones. */
static void divide_facets(void *context, int64_t begin, int64_t end, int thread) {
    (void)thread;
    pl_measuring *m = context;
    for (int64_t i = begin; i < end; i++)
        for (int way = 0; way < WAYS; way++) {
            if (m->bound[i][way] < INFINITY)
                continue;
            const pl_moved_facet t = facet_of(m, way, i);
            const double known = fmin(m->most[way], m->most_h[way] * m->h[i]);
            const double extra = extra_of(m, way, i);
            pl_division q = division_of(m, way, i, GOOD, fmax(known - extra, 0));
            m->bound[i][way] = capped(m, way, &t, pl_divide(&q, t.x, t.facet, DEEP) + extra);
        }
}

/** Make the tree of a surface's facets. Errors: _MEMORY. */
static int plant(const planish_shape *s, int threads, pl_tree *tree, planish_error *error) {
    pl_box3 *box = pl_alloc(s->n_facets, sizeof *box);
    if (!box)
        return pl_fail_memory(error, "the distance of surfaces");
    for (int64_t i = 0; i < s->n_facets; i++)
        for (int d = 0; d < 3; d++) {
            const double a = s->x[s->facet[i][0]][d], b = s->x[s->facet[i][1]][d];
            const double c = s->x[s->facet[i][2]][d];
            box[i].lower[d] = fmin(fmin(a, b), c);
            box[i].upper[d] = fmax(fmax(a, b), c);
        }
    const int status = pl_tree_create(s->n_facets, box, threads, tree, error);
    pl_free(box);
    return status;
}

/** Plant the trees of both surfaces unless there are some. Errors: _MEMORY. */
static int plant_both(pl_measuring *m, int threads, planish_error *error) {
    int status = PLANISH_OK;
    for (int way = 0; way < WAYS && !status; way++)
        if (m->tree[way].n == 0)
            status = plant(&m->surface[way], threads, &m->tree[way], error);
    return status;
}

/** Bound the distance of all facets, both ways. Errors: _MEMORY. */
static int bound_facets(pl_measuring *m, int threads, planish_error *error) {
    const int64_t n = m->surface[THERE].n_facets;
    pl_parallel_for(threads, n, FACETS, overlay_facets, m);
    if (m->n_open[THERE] == 0 && m->n_open[BACK] == 0)
        return PLANISH_OK;
    const int status = plant_both(m, threads, error);
    if (!status)
        pl_parallel_for(threads, n, FACETS, divide_facets, m);
    return status;
}

/** Return the number of the facet with the largest bound, in units of length or edges: *most; -1: all are 0. */
static int64_t find_largest(const pl_measuring *m, int way, int by_edges, double *most) {
    int64_t at = -1;
    *most = 0;
    for (int64_t i = 0; i < m->surface[way].n_facets; i++) {
        const double bound = m->bound[i][way] / unit_at(m, by_edges, i);
        if (bound > *most) {
            *most = bound;
            at = i;
        }
    }
    return at;
}

/** Sharpen the bound of a facet until it is close to the distance of a point, or to what is known. Each time
 *  that it is divided deeper, more is known. */
static void sharpen(pl_measuring *m, int way, int64_t i, pl_division *q) {
    enum { DEEPER = 2, DEEPEST = 18 };
    const pl_moved_facet t = facet_of(m, way, i);
    const double extra = extra_of(m, way, i);
    double *bound = &m->bound[i][way];
    for (int n = DEEPER; n <= DEEPEST && *bound > q->known + extra; n += DEEPER)
        *bound = fmin(*bound, pl_divide(q, t.x, t.facet, n) + extra);
}

/** Sharpen the largest bounds, in units of length or edges, until the largest one is close to the distance of a
 *  point, or is of a facet at a node of very many, which would take long. An overlay is above the distance by
 *  some percent, where facets are steep over one another by more. */
static void sharpen_largest(pl_measuring *m, int way, int by_edges) {
    enum { MOST = 1024 };
    double most, known = 0; /* of facets that were divided; in the unit */
    int64_t n_pieces = 0;
    for (int n = 0; n < MOST && n_pieces < MOST_PIECES; n++) {
        const int64_t at = find_largest(m, way, by_edges, &most);
        if (at < 0 || !(most < INFINITY) || most <= known || is_at_hub(&m->surface[way], at))
            return;
        const double unit = unit_at(m, by_edges, at), extra = extra_of(m, way, at);
        pl_division q = division_of(m, way, at, CLOSE, fmax(known * unit - extra, 0));
        sharpen(m, way, at, &q);
        n_pieces += q.n_pieces;
        known = fmax(known, m->bound[at][way] / unit);
    }
}

/** Take the bounds of all facets together. */
static void sum_up(const pl_measuring *m, pl_shape_distance *distance) {
    const planish_shape *s = &m->surface[THERE];
    for (int64_t i = 0; i < s->n_facets; i++) {
        const double h = m->h[i], *bound = m->bound[i];
        distance->there = fmax(distance->there, bound[THERE]);
        distance->back = fmax(distance->back, bound[BACK]);
        if (bound[THERE] > 0)
            distance->there_h = fmax(distance->there_h, bound[THERE] / h);
        if (bound[BACK] > 0)
            distance->back_h = fmax(distance->back_h, bound[BACK] / h);
        distance->n_unproved += !(bound[THERE] < INFINITY) + !(bound[BACK] < INFINITY);
    }
}

/* ---- bends ------------------------------------------------------------------------------------ */

/** Facets between which the sharpest smooth edge is sought. */
typedef struct pl_bends {
    const planish_shape *shape;
    double most; /* 1 - the least cosine */
} pl_bends;

static void look_at_bends(void *context, int64_t begin, int64_t end, int thread) {
    (void)thread;
    pl_bends *b = context;
    const planish_shape *s = b->shape;
    for (int32_t i = (int32_t)begin; i < end; i++) {
        double normal[3], other[3];
        pl_facet_normal(s, i, normal);
        for (int k = 0; k < 3; k++) {
            if (s->across[i][k] <= i)
                continue;
            pl_facet_normal(s, s->across[i][k], other);
            pl_raise_double(&b->most, 1 - pl_dot(3, normal, other));
        }
    }
}

double pl_shape_sharpest(const planish_shape *shape, int threads) {
    pl_bends b = {.shape = shape, .most = 0};
    pl_parallel_for(threads, shape->n_facets, FACETS, look_at_bends, &b);
    return 1 - b.most;
}

/* ---- facets of second order ------------------------------------------------------------------- */

/** A patch that may be planar before and after. */
typedef struct pl_flat_patch {
    int32_t first; /* facet; -1: none yet */
    double off
        [WAYS]; /* how far nodes are off the plane of the first facet; infinite: it is not planar */
    double bend; /* how far an edge, as it came, is off its halves */
} pl_flat_patch;

/** How far points of the edge after corner k go. */
static double way_of_edge(const pl_whole *whole, const double x[][3], const double y[][3], int k) {
    const int n = whole->n_corners;
    double most = 0;
    for (int i = 0; i < (pl_whole_has_mids(whole) ? 3 : 2); i++) {
        const int at = i == 0 ? k : i == 1 ? (k + 1) % n : n + k;
        double way[3];
        for (int d = 0; d < 3; d++) {
            way[d] = y[at][d] - x[at][d];
            if (i == 2)
                way[d] = 2 * way[d] -
                         0.5 * ((y[k][d] - x[k][d]) + (y[(k + 1) % n][d] - x[(k + 1) % n][d]));
        }
        most = fmax(most, pl_dot(3, way, way));
    }
    return sqrt(most) * (1 + 0x1p-40);
}

/** How far the edge after corner k is off its halves. */
static double bend_of_edge(const pl_whole *whole, const double x[][3], int k) {
    double off[3];
    if (!pl_whole_has_mids(whole))
        return 0;
    pl_mid_rise(whole->n_corners, x, k, off);
    return sqrt(pl_dot(3, off, off)) / 4 * (1 + 0x1p-40);
}

/** Take a facet of second order into its patch: how far its nodes are off the plane. Of a quadrilateral
 *  points may be off by three times that. */
static void add_to_plane(const pl_measuring *m, const pl_whole *whole, pl_flat_patch *patch) {
    const planish_shape *s = &m->surface[THERE];
    if (patch->first < 0)
        patch->first = whole->first;
    const double *origin = s->x[s->facet[patch->first][0]];
    const double times = whole->n_nodes >= 8 ? 3 : 1;
    double normal[3];
    pl_facet_normal(s, patch->first, normal);
    for (int way = 0; way < WAYS; way++) {
        double x[PL_WHOLE_NODES][3], to[3];
        pl_whole_nodes(&m->surface[way], whole, x);
        for (int k = 0; k < whole->n_nodes; k++) {
            pl_subtract(3, x[k], origin, to);
            patch->off[way] = fmax(patch->off[way], times * fabs(pl_dot(3, normal, to)));
        }
        for (int32_t f = whole->first; f < whole->first + whole->n_parts; f++) {
            pl_facet_normal(&m->surface[way], f, to);
            if (s->patch[f] != s->patch[whole->first] || !(pl_dot(3, normal, to) > 0.5))
                patch->off[way] = INFINITY;
        }
    }
}

/** Whether the edge after corner k of a facet of second order is a feature. */
static int is_rim(const planish_shape *s, const pl_whole *whole, int k) {
    const int n = whole->n_corners;
    const int32_t f = pl_whole_rim(whole, k, 0);
    const int32_t to = whole->node[pl_whole_has_mids(whole) ? n + k : (k + 1) % n];
    return s->across[f][pl_edge_of(s->facet[f], whole->node[k], to)] < 0;
}

/** Take the edges of a facet of a planar patch: bends first, then how far they are off. */
static void add_edges(pl_measuring *m, const pl_whole *whole, int takes_bends,
                      pl_flat_patch *patch) {
    const planish_shape *s = &m->surface[THERE];
    double x[WAYS][PL_WHOLE_NODES][3];
    pl_whole_nodes(&m->surface[THERE], whole, x[THERE]);
    pl_whole_nodes(&m->surface[BACK], whole, x[BACK]);
    for (int k = 0; k < whole->n_corners; k++) {
        const double(*first)[3] = (const double(*)[3])x[THERE];
        const double(*now)[3] = (const double(*)[3])x[BACK];
        if (!is_rim(s, whole, k))
            continue;
        if (takes_bends) {
            patch->bend = fmax(patch->bend, bend_of_edge(whole, first, k));
            continue;
        }
        double off = way_of_edge(whole, first, now, k), lateral = 0;
        for (int half = 0; half < 2 && off > 0; half++) {
            const pl_moved_facet t = facet_of(m, THERE, pl_whole_rim(whole, k, half));
            lateral = fmax(lateral, pl_overlay_lateral(s, &t));
        }
        off = fmin(off, lateral + bend_of_edge(whole, now, k) + patch->bend);
        double *edge = &m->edge[whole->first];
        *edge = fmax(*edge, off + patch->off[THERE] + patch->off[BACK]);
    }
}

/** Bound distances of facets of second order without overlays: by how far their points have gone, or the
 *  edges of their plane. */
static void find_other_bounds(pl_measuring *m, pl_flat_patch *patch) {
    const planish_shape *s = &m->surface[THERE];
    for (int64_t p = 0; p < s->n_facets; p++)
        patch[p] = (pl_flat_patch){.first = -1};
    for (const pl_whole *w = s->whole; w < s->whole + s->n_wholes; w++)
        add_to_plane(m, w, &patch[s->patch[w->first]]);
    for (const pl_whole *w = s->whole; w < s->whole + s->n_wholes; w++) {
        pl_flat_patch *of = &patch[s->patch[w->first]];
        if (!(of->off[THERE] + of->off[BACK] <= FLAT * pl_shape_edge(s, w->first)))
            of->off[THERE] = INFINITY;
    }
    for (int takes_bends = 1; takes_bends >= 0; takes_bends--)
        for (const pl_whole *w = s->whole; w < s->whole + s->n_wholes; w++) {
            pl_flat_patch *of = &patch[s->patch[w->first]];
            m->edge[w->first] = of->off[THERE] + of->off[BACK];
            if (m->edge[w->first] < INFINITY)
                add_edges(m, w, takes_bends, of);
        }
    for (int64_t i = 0; i < s->n_facets; i++) {
        const pl_whole *whole = pl_whole_of(s, (int32_t)i);
        double x[WAYS][PL_WHOLE_NODES][3];
        pl_whole_nodes(&m->surface[THERE], whole, x[THERE]);
        pl_whole_nodes(&m->surface[BACK], whole, x[BACK]);
        m->most_of[i] =
            pl_whole_way(whole, (const double(*)[3])x[THERE], (const double(*)[3])x[BACK]);
        m->edge[i] = m->edge[whole->first];
    }
}

/** Find how far the facets of second order of both surfaces are off their triangles. Errors: _MEMORY. */
static int find_bends(pl_measuring *m, planish_error *error) {
    const planish_shape *first = &m->surface[THERE];
    planish_shape *now = &m->surface[BACK];
    if (!first->whole)
        return PLANISH_OK;
    now->bend = pl_alloc(first->n_facets, sizeof *now->bend);
    m->extra = pl_alloc(first->n_facets, sizeof *m->extra);
    m->most_of = pl_alloc(first->n_facets, sizeof *m->most_of);
    m->edge = pl_alloc(first->n_facets, sizeof *m->edge);
    pl_flat_patch *patch = pl_alloc(first->n_facets, sizeof *patch);
    const int done = now->bend && m->extra && m->most_of && m->edge && patch;
    if (done)
        find_other_bounds(m, patch);
    pl_free(patch);
    if (!done)
        return pl_fail_memory(error, "the distance of surfaces");
    for (int32_t i = 0; i < first->n_facets; i++) {
        double x[PL_WHOLE_NODES][3];
        uint8_t node[3];
        pl_whole_nodes(now, pl_whole_of(first, i), x);
        pl_find_part(first, i, node);
        now->bend[i] = pl_whole_bend(pl_whole_of(first, i), (const double(*)[3])x, node);
        m->extra[i][THERE] = now->bend[i];
        m->extra[i][BACK] = first->bend[i];
    }
    return PLANISH_OK;
}

/** Whether all coordinates are finite. */
static int are_finite(const double (*x)[3], int64_t n) {
    for (int64_t i = 0; i < n; i++)
        if (!isfinite(x[i][0]) || !isfinite(x[i][1]) || !isfinite(x[i][2]))
            return 0;
    return 1;
}

int pl_shape_measure(const planish_shape *shape, const double (*x)[3], const pl_place *place,
                     int threads, pl_shape_distance *distance, planish_error *error) {
    pl_measuring m = {.surface = {*shape, *shape}, .place = place};
    planish_shape *now = &m.surface[BACK];
    const int64_t n = shape->n_facets;
    now->x = pl_alloc(shape->n_nodes, sizeof *now->x);
    now->bend = NULL;
    m.bound = pl_alloc(n, sizeof *m.bound);
    m.h = pl_alloc(n, sizeof *m.h);
    *distance = (pl_shape_distance){.there = 0};
    int status = 0;
    if (!now->x || !m.bound || !m.h) {
        status = pl_fail_memory(error, "the distance of surfaces");
    } else if (!are_finite(x, shape->n_nodes)) {
        *distance = (pl_shape_distance){INFINITY, INFINITY, INFINITY, INFINITY, 2 * n, -1};
    } else {
        memcpy(now->x, x, (size_t)shape->n_nodes * sizeof *x);
        status = find_bends(&m, error);
        if (!status)
            status = bound_facets(&m, threads, error);
        if (!status)
            status = plant_both(&m, threads, error);
        for (int way = 0; !status && way < WAYS; way++)
            for (int by_edges = 0; by_edges < 2; by_edges++)
                sharpen_largest(&m, way, by_edges);
        if (!status) {
            sum_up(&m, distance);
            distance->sharpest = pl_shape_sharpest(now, threads);
        }
    }
    for (int way = 0; way < WAYS; way++)
        pl_tree_destroy(&m.tree[way]);
    pl_free(now->x);
    pl_free(now->bend);
    pl_free(m.extra);
    pl_free(m.most_of);
    pl_free(m.edge);
    pl_free(m.bound);
    pl_free(m.h);
    return status;
}
