/* distance: how far the surface of a mesh and another one are apart, proved.
 *
 * Both ways it is the overlay of each facet from the facet of the other surface nearest to its middle.
 * Where the overlay says nothing, as where a feature runs over the facet or it is over too many others, the
 * facet is divided. Of a small part it is enough that no corner of it is far from one facet: the distance
 * from a triangle is convex. */
#include "fit/distance.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "shape/nearest.h"
#include "shape/overlay.h"

#include <string.h>

enum { CHUNK = 16, /* facets */ DEEPEST = 9 /* division of a facet */ };

/* A bound that is this much above the distance of one point is good enough; or that is below so many mean
 * edges of the mesh's surface. */
#define GOOD 1.05
#define FINE 0.002

enum { THERE, BACK, WAYS };

typedef struct measuring {
    const planish_fit *fit;
    planish_shape now;    /* the mesh's surface as it is: its x and normal are owned */
    pl_tree facets;       /* of it */
    double(*bound[WAYS]); /* [facets of now], [facets of onto] */
    double(*edge[WAYS]);  /* mean edge of the mesh's surface there */
    /* Distances of middles, a little more, in onto's unit and in edges: what is below counts for nothing. */
    double most[WAYS], most_h[WAYS];
} measuring;

/** A surface from which distances are. */
typedef struct target {
    const planish_shape *shape;
    const pl_tree *tree;
    const int8_t *turn; /* of its patches, or NULL */
    double edge;        /* of the facet whose distance is asked for */
} target;

static target target_of(const measuring *m, int way) {
    return way == THERE ? (target){m->fit->onto, &m->fit->facets, m->fit->turn, 0}
                        : (target){&m->now, &m->facets, NULL, 0};
}

static double square_of(const void *context, int32_t facet, const double point[3]) {
    const planish_shape *s = ((const target *)context)->shape;
    const int32_t *node = s->facet[facet];
    const double *const x[3] = {s->x[node[0]], s->x[node[1]], s->x[node[2]]};
    double weight[3] = {1, 0, 0};
    return s->is_interface[facet] ? INFINITY : pl_nearest_on_triangle(point, x, weight);
}

/** Return the facet nearest to the middle of a triangle, and the square of its distance; -1: there is none. */
static int32_t nearest_to(const target *t, const double x[3][3], double *square) {
    double middle[3];
    for (int d = 0; d < 3; d++)
        middle[d] = (x[0][d] + x[1][d] + x[2][d]) / 3;
    *square = INFINITY;
    return pl_tree_nearest(t->tree, middle, square_of, t, square);
}

/** Bound the distance of a triangle by an overlay. */
static double overlay(const target *t, const double x[3][3], int32_t near, int turn) {
    double turned[3][3];
    if (t->turn)
        turn *= t->turn[t->shape->patch[near]];
    for (int k = 0; k < 3; k++)
        memcpy(turned[k], x[turn < 0 ? 2 - k : k], sizeof turned[k]);
    return pl_overlay_bound_any(t->shape, (const double(*)[3])turned, near);
}

/** Largest distance of the corners x from a facet: no point of their triangle is farther off. */
static double off_facet(const target *t, int32_t facet, const double x[3][3]) {
    double most = 0;
    for (int k = 0; k < 3; k++)
        most = fmax(most, square_of(t, facet, x[k]));
    return sqrt(most);
}

/** Bound the distance of a triangle; known, if that is more. turn: -1: it turns into the mesh. */
static double divide(const target *t, const double x[3][3], int turn, double known, int depth) {
    double part[4][3][3], square;
    const int32_t near = nearest_to(t, x, &square);
    if (near < 0)
        return INFINITY;
    const double enough = fmax(known, GOOD * sqrt(square));
    double bound = off_facet(t, near, x);
    if (bound > enough)
        bound = fmin(bound, overlay(t, x, near, turn));
    for (int k = 0; k < 3 && bound > enough; k++)
        if (t->shape->across[near][k] >= 0)
            bound = fmin(bound, off_facet(t, t->shape->across[near][k], x));
    if (bound <= fmax(enough, FINE * t->edge) || depth == 0)
        return fmax(bound, known);
    pl_quarter_triangle(x, part);
    for (int i = 0; i < 4; i++)
        known = divide(t, (const double(*)[3])part[i], turn, known, depth - 1);
    return known;
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

/** Bound the distances of facets by overlays. */
static void overlay_facets(measuring *m, int way, int64_t begin, int64_t end) {
    const target t = target_of(m, way);
    const planish_shape *from = way == THERE ? &m->now : m->fit->onto;
    for (int64_t i = begin; i < end; i++) {
        double x[3][3], square;
        const int turn = facet_of(m, way, i, x);
        const int32_t near =
            from->is_interface[i] ? -1 : nearest_to(&t, (const double(*)[3])x, &square);
        double other[3][3];
        m->bound[way][i] = from->is_interface[i] ? 0 : INFINITY;
        m->edge[way][i] = INFINITY;
        if (near < 0)
            continue;
        if (way == BACK)
            facet_of(m, THERE, near, other);
        const double edge = mean_edge((const double(*)[3])(way == BACK ? other : x));
        const double bound = overlay(&t, (const double(*)[3])x, near, turn);
        m->bound[way][i] = bound;
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
    target t = target_of(m, way);
    for (int64_t i = begin; i < end; i++) {
        double x[3][3];
        t.edge = m->edge[way][i];
        const double known = fmin(m->most[way], m->most_h[way] * t.edge);
        if (m->bound[way][i] <= known)
            continue;
        const int turn = facet_of(m, way, i, x);
        m->bound[way][i] =
            fmin(m->bound[way][i], divide(&t, (const double(*)[3])x, turn, known, DEEPEST));
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
    s->normal = pl_alloc(s->n_facets, sizeof *s->normal);
    pl_box3 *box = pl_alloc(s->n_facets, sizeof *box);
    int status =
        s->x && s->normal && box ? PLANISH_OK : pl_fail_memory(error, "the distance of surfaces");
    for (int64_t i = 0; !status && i < s->n_nodes; i++)
        pl_fit_at(points, s->node[i], fit->onto->scale, s->x[i]);
    for (int64_t i = 0; !status && i < s->n_facets; i++) {
        double u[3], v[3], normal[3];
        const double *a = s->x[s->facet[i][0]], *b = s->x[s->facet[i][1]],
                     *c = s->x[s->facet[i][2]];
        pl_from_to(3, a, b, u);
        pl_from_to(3, a, c, v);
        pl_cross(u, v, normal);
        if (!pl_unit(3, normal, s->normal[i]))
            memset(s->normal[i], 0, sizeof s->normal[i]);
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
        if (!status && (!m.bound[way] || !m.edge[way]))
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
    }
    pl_tree_destroy(&m.facets);
    pl_free(m.now.x);
    pl_free(m.now.normal);
    return status;
}
