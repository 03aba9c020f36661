/* distance: how far a surface that has moved is off the first one, and the first one off it.
 *
 * Both ways it is the overlay of each facet. For the way back the roles are swapped: the new surface
 * is a shape of the same facets, and places on it are walked to. Where the overlay says nothing, as
 * at folds, a facet is divided: the distance from one triangle is convex, so that a part of the facet
 * is no farther off it than the part's corners. That takes a hundred times as long. */
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "shape/nearest.h"
#include "shape/overlay.h"
#include "shape/tree.h"

#include <string.h>

enum { FACETS = 64, /* of a chunk */ DEEPEST = 6 /* division of a facet */ };

/* A bound that is this much above the distance of one point is good enough. */
#define GOOD 1.05

/* ---- one facet by division ---------------------------------------------------------------- */

/** Distance of x from a point of the triangle, the nearest one up to rounding. */
static double off_triangle(const double *const corner[3], const double x[3]) {
    double weight[3] = {1, 0, 0}, off[3];
    pl_nearest_on_triangle(x, corner, weight);
    for (int d = 0; d < 3; d++)
        off[d] = weight[0] * (corner[0][d] - x[d]) + weight[1] * (corner[1][d] - x[d]) +
                 weight[2] * (corner[2][d] - x[d]);
    return sqrt(pl_dot(3, off, off));
}

/** Largest distance of the corners x from a facet: no point of their triangle is farther off. */
static double off_facet(const planish_shape *s, int32_t facet, const double x[3][3]) {
    const double *corner[3];
    double most = 0;
    for (int k = 0; k < 3; k++)
        corner[k] = s->x[s->facet[facet][k]];
    for (int k = 0; k < 3; k++)
        most = fmax(most, off_triangle(corner, x[k]));
    return most;
}

/** A patch to which distances are found. */
typedef struct pl_target {
    const planish_shape *shape;
    const pl_tree *tree; /* of its facets; NULL: the nearest is walked to */
    int32_t patch;
} pl_target;

/** Squared distance of a facet of the patch from a point. */
static double square_off(const void *context, int32_t facet, const double point[3]) {
    const pl_target *t = context;
    const int32_t *node = t->shape->facet[facet];
    const double *const corner[3] = {t->shape->x[node[0]], t->shape->x[node[1]],
                                     t->shape->x[node[2]]};
    double weight[3] = {1, 0, 0};
    return t->shape->patch[facet] == t->patch ? pl_nearest_on_triangle(point, corner, weight)
                                              : INFINITY;
}

/** Find the facet of a patch that is nearest to a point, or one that is about as near; near: one to begin
 *  with. Sets the square of its distance. */
static int32_t find_near(const pl_target *t, const double point[3], int32_t near, double *square) {
    if (!t->tree) {
        pl_place place = {near, {1. / 3, 1. / 3, 1. / 3}};
        const double off = pl_shape_walk(t->shape, PL_ON_PATCH, point, &place);
        *square = off * off;
        return place.at;
    }
    *square = square_off(t, near, point);
    const int32_t nearer = pl_tree_nearest(t->tree, point, square_off, t, square);
    return nearer >= 0 ? nearer : near;
}

/** Bound the distance of a triangle from a patch; known, if that is more. near: a facet of the patch. */
static double divide(const pl_target *t, const double x[3][3], int32_t near, double known,
                     int depth) {
    const planish_shape *s = t->shape;
    double middle[3], part[4][3][3], square;
    for (int d = 0; d < 3; d++)
        middle[d] = (x[0][d] + x[1][d] + x[2][d]) / 3;
    near = find_near(t, middle, near, &square);
    double bound = off_facet(s, near, x);
    for (int k = 0; k < 3; k++)
        if (s->across[near][k] >= 0)
            bound = fmin(bound, off_facet(s, s->across[near][k], x));
    if (bound <= known || bound <= GOOD * sqrt(square) || depth == 0)
        return fmax(bound, known);
    for (int k = 0; k < 3; k++)
        for (int d = 0; d < 3; d++) {
            part[k][k][d] = x[k][d];
            part[k][(k + 1) % 3][d] = part[(k + 1) % 3][k][d] = part[3][k][d] =
                (x[k][d] + x[(k + 1) % 3][d]) / 2;
        }
    for (int i = 0; i < 4; i++)
        known = divide(t, (const double(*)[3])part[i], near, known, depth - 1);
    return known;
}

/* ---- all facets --------------------------------------------------------------------------- */

enum { THERE, BACK, WAYS };

typedef struct pl_measuring {
    /* The new surface is a shape of the same facets, by its x and normal. */
    planish_shape surface[WAYS]; /* from which distances are: the first one, the new one */
    pl_tree tree[WAYS];          /* their facets */
    const pl_place *place;
    double (*bound)[WAYS]; /* [n_facets] */
    double bend;           /* 1 - the least cosine */
    int64_t n_open[WAYS];  /* facets about which the overlay says nothing */
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
    return t;
}

/** Bound the distances of facets by overlays. */
static void overlay_facets(void *context, int64_t begin, int64_t end, int thread) {
    (void)thread;
    pl_measuring *m = context;
    for (int64_t i = begin; i < end; i++)
        for (int way = 0; way < WAYS; way++) {
            const planish_shape *s = &m->surface[way];
            const pl_moved_facet t = facet_of(m, way, i);
            const double bound = pl_overlay_bound(s, &t, pl_overlay_lateral(s, &t), INFINITY);
            m->bound[i][way] = bound;
            if (bound == INFINITY) {
                __atomic_fetch_add(&m->n_open[way], 1, __ATOMIC_RELAXED);
            } else if (bound > 0) {
                pl_raise_double(&m->most[way], bound);
                pl_raise_double(&m->most_h[way],
                                bound / pl_shape_edge(&m->surface[THERE], t.facet));
            }
        }
}

/** Divide facets that have no bound, as far as they are beyond the largest ones. */
static void divide_facets(void *context, int64_t begin, int64_t end, int thread) {
    (void)thread;
    pl_measuring *m = context;
    for (int64_t i = begin; i < end; i++)
        for (int way = 0; way < WAYS; way++) {
            const planish_shape *s = &m->surface[way];
            const pl_target target = {s, &m->tree[way], s->patch[i]};
            const pl_moved_facet t = facet_of(m, way, i);
            const double h = pl_shape_edge(&m->surface[THERE], t.facet);
            const double known = fmin(m->most[way], m->most_h[way] * h);
            if (m->bound[i][way] == INFINITY)
                m->bound[i][way] = divide(&target, t.x, t.facet, known, DEEPEST);
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

/** Bound the distance of all facets, both ways. Errors: _MEMORY. */
static int bound_facets(pl_measuring *m, int threads, planish_error *error) {
    const int64_t n = m->surface[THERE].n_facets;
    pl_parallel_for(threads, n, FACETS, overlay_facets, m);
    if (m->n_open[THERE] == 0 && m->n_open[BACK] == 0)
        return PLANISH_OK;
    int status = 0;
    for (int way = 0; way < WAYS && !status; way++)
        status = plant(&m->surface[way], threads, &m->tree[way], error);
    if (!status)
        pl_parallel_for(threads, n, FACETS, divide_facets, m);
    for (int way = 0; way < WAYS; way++)
        pl_tree_destroy(&m->tree[way]);
    return status;
}

/** Sharpen the largest bounds, in units of length or edges: an overlay is above the distance by some
 *  percent, where facets are steep over one another by more. */
static void sharpen(pl_measuring *m, int way, int by_edges) {
    enum { MOST = 64 };
    const planish_shape *s = &m->surface[way];
    int64_t before = -1;
    for (int n = 0; n < MOST; n++) {
        int64_t at = -1;
        double most = 0;
        for (int64_t i = 0; i < s->n_facets; i++) {
            const double h = by_edges ? pl_shape_edge(&m->surface[THERE], (int32_t)i) : 1;
            if (m->bound[i][way] / h > most) {
                most = m->bound[i][way] / h;
                at = i;
            }
        }
        if (at < 0 || at == before || !(most < INFINITY))
            return;
        const pl_target target = {s, NULL, s->patch[at]};
        const pl_moved_facet t = facet_of(m, way, at);
        double *bound = &m->bound[at][way];
        *bound = fmin(*bound, divide(&target, t.x, t.facet, *bound / 2, DEEPEST));
        before = at;
    }
}

/** Take the bounds of all facets together. */
static void sum_up(const pl_measuring *m, pl_shape_distance *distance) {
    const planish_shape *s = &m->surface[THERE];
    for (int64_t i = 0; i < s->n_facets; i++) {
        const double h = pl_shape_edge(s, (int32_t)i), *bound = m->bound[i];
        distance->there = fmax(distance->there, bound[THERE]);
        distance->back = fmax(distance->back, bound[BACK]);
        if (bound[THERE] > 0)
            distance->there_h = fmax(distance->there_h, bound[THERE] / h);
        if (bound[BACK] > 0)
            distance->back_h = fmax(distance->back_h, bound[BACK] / h);
        distance->n_unproved += !(bound[THERE] < INFINITY) + !(bound[BACK] < INFINITY);
    }
    distance->sharpest = 1 - m->bend;
}

/** Compute the new normals. */
static void compute_normals(void *context, int64_t begin, int64_t end, int thread) {
    (void)thread;
    planish_shape *s = &((pl_measuring *)context)->surface[BACK];
    for (int64_t i = begin; i < end; i++) {
        const int32_t *node = s->facet[i];
        double u[3], v[3], normal[3];
        pl_subtract(3, s->x[node[1]], s->x[node[0]], u);
        pl_subtract(3, s->x[node[2]], s->x[node[0]], v);
        pl_cross(u, v, normal);
        if (!pl_unit(3, normal, s->normal[i]))
            memset(s->normal[i], 0, sizeof s->normal[i]);
    }
}

/** Find the sharpest smooth edge. */
static void measure_bends(void *context, int64_t begin, int64_t end, int thread) {
    (void)thread;
    pl_measuring *m = context;
    const planish_shape *s = &m->surface[BACK];
    for (int64_t i = begin; i < end; i++)
        for (int k = 0; k < 3; k++)
            if (s->across[i][k] > i)
                pl_raise_double(&m->bend, 1 - pl_dot(3, s->normal[i], s->normal[s->across[i][k]]));
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
    now->normal = pl_alloc(n, sizeof *now->normal);
    m.bound = pl_alloc(n, sizeof *m.bound);
    *distance = (pl_shape_distance){.there = 0};
    int status = 0;
    if (!now->x || !now->normal || !m.bound) {
        status = pl_fail_memory(error, "the distance of surfaces");
    } else if (!are_finite(x, shape->n_nodes)) {
        *distance = (pl_shape_distance){INFINITY, INFINITY, INFINITY, INFINITY, 2 * n, -1};
    } else {
        memcpy(now->x, x, (size_t)shape->n_nodes * sizeof *x);
        pl_parallel_for(threads, n, FACETS, compute_normals, &m);
        pl_parallel_for(threads, n, FACETS, measure_bends, &m);
        status = bound_facets(&m, threads, error);
        for (int way = 0; way < WAYS; way++)
            for (int by_edges = 0; by_edges < 2; by_edges++)
                sharpen(&m, way, by_edges);
        sum_up(&m, distance);
    }
    pl_free(now->x);
    pl_free(now->normal);
    pl_free(m.bound);
    return status;
}
