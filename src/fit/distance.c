/* distance: how far the surface of a mesh and another one are apart, proved.
 *
 * Both ways it is the overlay of each facet from the facet of the other surface nearest to its middle.
 * Where the overlay says nothing, as where a feature runs over the facet or it is over too many others, the
 * facet is divided (shape/divide.h). */
#include "fit/distance.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "shape/divide.h"

#include <string.h>

enum { CHUNK = 16, /* facets */ DEEPEST = 9 /* division of a facet */ };

/* A bound that is this much above the distance of one point is good enough; or that is below so many mean
 * edges of the mesh's surface. */
#define GOOD 1.05
#define FINE 0.002

enum { THERE, BACK, WAYS };

typedef struct measuring {
    const planish_fit *fit;
    planish_shape now;    /* the mesh's surface as it is: its x is owned */
    pl_tree facets;       /* of it */
    double(*bound[WAYS]); /* [facets of now], [facets of onto] */
    double(*edge[WAYS]);  /* mean edge of the mesh's surface there */
    int32_t *near[WAYS];  /* facet of the other one nearest to the middle; -1: there is none */
    /* Distances of middles, a little more, in onto's unit and in edges: what is below counts for nothing. */
    double most[WAYS], most_h[WAYS];
} measuring;

/** Prepare the division of a facet at a mean edge of the mesh's surface, which turns into the mesh (-1) or not. */
static pl_division division_of(const measuring *m, int way, int turns, double edge, double known) {
    return (pl_division){.shape = way == THERE ? m->fit->onto : &m->now,
                         .tree = way == THERE ? &m->fit->facets : &m->facets,
                         .patch = -1,
                         .turns = turns,
                         .turn = way == THERE ? m->fit->turn : NULL,
                         .close = GOOD,
                         .fine = FINE * edge,
                         .known = known,
                         .most_pieces = INT64_MAX};
}

/* ---- all facets ------------------------------------------------------------------------------ */

/** Facet i of the surface that is not the target: its corners, and which way it turns. */
static int facet_of(const measuring *m, int way, int64_t i, double x[3][3]) {
    const planish_shape *s = way == THERE ? &m->now : m->fit->onto;
    for (int k = 0; k < 3; k++)
        memcpy(x[k], s->x[s->facet[i][k]], sizeof x[k]);
    return way == THERE ? 1 : m->fit->turn[s->patch[i]];
}

static double mean_edge(const double x[3][3]) {
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        double way[3];
        pl_from_to(3, x[k], x[(k + 1) % 3], way);
        sum += pl_length(way);
    }
    return sum / 3;
}

/** How far a facet of second order is off its triangle. */
static double extra_of(const measuring *m, int way, int64_t i) {
    return way == BACK && m->fit->onto->whole ? m->fit->onto->bend[i] : 0;
}

/** Bound the distances of facets by overlays. */
static void overlay_facets(measuring *m, int way, int64_t begin, int64_t end) {
    const planish_shape *from = way == THERE ? &m->now : m->fit->onto;
    for (int64_t i = begin; i < end; i++) {
        double x[3][3], middle[3], other[3][3], square;
        const pl_division q = division_of(m, way, facet_of(m, way, i, x), 0, 0);
        m->bound[way][i] = from->is_interface[i] ? 0 : INFINITY;
        m->edge[way][i] = INFINITY;
        if (from->is_interface[i])
            continue;
        for (int d = 0; d < 3; d++)
            middle[d] = (x[0][d] + x[1][d] + x[2][d]) / 3;
        m->near[way][i] = pl_division_find(&q, middle, &square);
        if (m->near[way][i] < 0)
            continue;
        if (way == BACK)
            facet_of(m, THERE, m->near[way][i], other);
        const double edge = mean_edge((const double(*)[3])(way == BACK ? other : x));
        m->bound[way][i] =
            pl_division_overlay(&q, (const double(*)[3])x, m->near[way][i]) + extra_of(m, way, i);
        m->edge[way][i] = edge;
        pl_raise_double(&m->most[way], GOOD * sqrt(square));
        pl_raise_double(&m->most_h[way], GOOD * sqrt(square) / edge);
    }
}

static void overlay_there(void *context, int64_t begin, int64_t end, int thread) {
    (void)thread;
    overlay_facets(context, THERE, begin, end);
}

static void overlay_back(void *context, int64_t begin, int64_t end, int thread) {
    (void)thread;
    overlay_facets(context, BACK, begin, end);
}

/** Divide facets that have no bound, or a larger one than counts: an overlay is above the distance where facets are
 *  steep over one another. */
static void divide_facets(measuring *m, int way, int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; i++) {
        double x[3][3];
        const double edge = m->edge[way][i], extra = extra_of(m, way, i);
        const double known = fmin(m->most[way], m->most_h[way] * edge);
        if (m->bound[way][i] <= known || m->near[way][i] < 0)
            continue;
        const int turns = facet_of(m, way, i, x);
        pl_division q = division_of(m, way, turns, edge, fmax(known - extra, 0));
        const double bound = pl_divide(&q, (const double(*)[3])x, m->near[way][i], DEEPEST);
        m->bound[way][i] = fmin(m->bound[way][i], bound + extra);
    }
}

static void divide_there(void *context, int64_t begin, int64_t end, int thread) {
    (void)thread;
    divide_facets(context, THERE, begin, end);
}

static void divide_back(void *context, int64_t begin, int64_t end, int thread) {
    (void)thread;
    divide_facets(context, BACK, begin, end);
}

/** Make the mesh's surface as it is, in onto's unit. Errors: _MEMORY. */
static int make_present(measuring *m, const pl_points *points, planish_error *error) {
    const planish_fit *fit = m->fit;
    planish_shape *s = &m->now;
    *s = *fit->own;
    s->x = pl_alloc(s->n_nodes, sizeof *s->x);
    pl_box3 *box = pl_alloc(s->n_facets, sizeof *box);
    int status = s->x && box ? PLANISH_OK : pl_fail_memory(error, "the distance of surfaces");
    for (int64_t i = 0; !status && i < s->n_nodes; i++)
        pl_fit_at(points, s->node[i], fit->onto->scale, s->x[i]);
    for (int64_t i = 0; !status && i < s->n_facets; i++) {
        const double *a = s->x[s->facet[i][0]], *b = s->x[s->facet[i][1]],
                     *c = s->x[s->facet[i][2]];
        for (int d = 0; d < 3; d++) {
            box[i].lower[d] = fmin(fmin(a[d], b[d]), c[d]);
            box[i].upper[d] = fmax(fmax(a[d], b[d]), c[d]);
        }
    }
    if (!status)
        status = pl_tree_create(s->n_facets, box, fit->threads, &m->facets, error);
    pl_free(box);
    return status;
}

/** Take the bounds of all facets together. */
static void sum_up(const measuring *m, pl_fit_distance *distance) {
    double most[WAYS] = {0, 0}, most_h[WAYS] = {0, 0};
    for (int way = 0; way < WAYS; way++) {
        const int64_t n = way == THERE ? m->now.n_facets : m->fit->onto->n_facets;
        for (int64_t i = 0; i < n; i++) {
            const double bound = m->bound[way][i];
            most[way] = fmax(most[way], bound);
            most_h[way] = fmax(most_h[way], bound > 0 ? bound / m->edge[way][i] : 0);
            distance->n_unproved += !(bound < INFINITY);
        }
    }
    distance->there = most[THERE] / m->fit->onto->scale;
    distance->back = most[BACK] / m->fit->onto->scale;
    distance->there_h = most_h[THERE];
    distance->back_h = most_h[BACK];
}

int pl_fit_measure(const planish_fit *fit, const pl_points *points, pl_fit_distance *distance,
                   planish_error *error) {
    measuring m = {.fit = fit};
    const int64_t n[WAYS] = {fit->own->n_facets, fit->onto->n_facets};
    int status = make_present(&m, points, error);
    *distance = (pl_fit_distance){.there = 0};
    for (int way = 0; way < WAYS; way++) {
        m.bound[way] = pl_alloc(n[way], sizeof **m.bound);
        m.edge[way] = pl_alloc(n[way], sizeof **m.edge);
        m.near[way] = pl_alloc(n[way], sizeof **m.near);
        if (!status && (!m.bound[way] || !m.edge[way] || !m.near[way]))
            status = pl_fail_memory(error, "the distance of surfaces");
    }
    if (!status) {
        pl_parallel_for(fit->threads, n[THERE], CHUNK, overlay_there, &m);
        pl_parallel_for(fit->threads, n[BACK], CHUNK, overlay_back, &m);
        pl_parallel_for(fit->threads, n[THERE], CHUNK, divide_there, &m);
        pl_parallel_for(fit->threads, n[BACK], CHUNK, divide_back, &m);
        sum_up(&m, distance);
    }
    for (int way = 0; way < WAYS; way++) {
        pl_free(m.bound[way]);
        pl_free(m.edge[way]);
        pl_free(m.near[way]);
    }
    pl_tree_destroy(&m.facets);
    pl_free(m.now.x);
    return status;
}
