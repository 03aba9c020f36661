/* distance: how far a surface that has moved is off the first one, and the first one off it.
 *
 * Both ways it is the overlay of each facet. For the way back the roles are swapped: the new surface
 * is a shape of the same facets, and places on it are walked to. Where the overlay says nothing, as
 * at folds, a facet is divided: the distance from one triangle is convex, so that a part of the facet
 * is no farther off it than the part's corners. That needs no frame, and takes a hundred times as long. */
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "shape/nearest.h"
#include "shape/overlay.h"

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

/** Bound the distance of a triangle from the patch around facet near; known, if that is more. */
static double divide(const planish_shape *s, const double x[3][3], int32_t near, double known,
                     int depth) {
    double middle[3], part[4][3][3];
    for (int d = 0; d < 3; d++)
        middle[d] = (x[0][d] + x[1][d] + x[2][d]) / 3;
    pl_place place = {near, {1. / 3, 1. / 3, 1. / 3}};
    const double least = pl_shape_walk(s, PL_ON_PATCH, middle, &place);
    double bound = off_facet(s, place.at, x);
    for (int k = 0; k < 3; k++)
        if (s->across[place.at][k] >= 0)
            bound = fmin(bound, off_facet(s, s->across[place.at][k], x));
    if (bound <= known || bound <= GOOD * least || depth == 0)
        return fmax(bound, known);
    for (int k = 0; k < 3; k++)
        for (int d = 0; d < 3; d++) {
            part[k][k][d] = x[k][d];
            part[k][(k + 1) % 3][d] = part[(k + 1) % 3][k][d] = part[3][k][d] =
                (x[k][d] + x[(k + 1) % 3][d]) / 2;
        }
    for (int i = 0; i < 4; i++)
        known = divide(s, (const double(*)[3])part[i], place.at, known, depth - 1);
    return known;
}

/* ---- all facets --------------------------------------------------------------------------- */

typedef struct pl_measuring {
    const planish_shape *shape;
    planish_shape moved; /* the new surface, by its x and normal; all else is that of shape */
    const pl_place *place;
    pl_shape_distance *distance;
    double bend; /* 1 - the least cosine */
} pl_measuring;

/** Bound how far facets with these corners are off a shape; infinite: not known. */
static double bound_of(const planish_shape *s, const pl_moved_facet *t) {
    const double lateral = pl_overlay_lateral(s, t);
    double bound = pl_overlay_bound(s, t, lateral, INFINITY);
    if (bound < INFINITY)
        return bound;
    bound = divide(s, t->x, t->facet, 0, DEEPEST);
    return bound < INFINITY ? bound : INFINITY;
}

/** Take a bound of a facet into the largest ones, absolute and in mean edges. */
static void take(pl_measuring *m, double bound, double h, double *most, double *most_h) {
    pl_raise_double(most, bound);
    pl_raise_double(most_h, bound / h);
    if (!(bound < INFINITY))
        __atomic_fetch_add(&m->distance->n_unproved, 1, __ATOMIC_RELAXED);
}

static void measure_facets(void *context, int64_t begin, int64_t end, int thread) {
    (void)thread;
    pl_measuring *m = context;
    const planish_shape *s = m->shape, *moved = &m->moved;
    for (int64_t i = begin; i < end; i++) {
        pl_moved_facet there = {.facet = (int32_t)i}, back = there;
        for (int k = 0; k < 3; k++) {
            const int32_t node = s->facet[i][k];
            memcpy(there.x[k], moved->x[node], sizeof there.x[k]);
            memcpy(back.x[k], s->x[node], sizeof back.x[k]);
            there.place[k] = m->place[node];
            back.place[k].at = -1;
        }
        if (memcmp(there.x, back.x, sizeof back.x) == 0)
            continue;
        const double h = pl_shape_edge(s, (int32_t)i);
        take(m, bound_of(s, &there), h, &m->distance->there, &m->distance->there_h);
        take(m, bound_of(moved, &back), h, &m->distance->back, &m->distance->back_h);
    }
}

/** Compute the new normals. */
static void compute_normals(void *context, int64_t begin, int64_t end, int thread) {
    (void)thread;
    planish_shape *s = &((pl_measuring *)context)->moved;
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
    const planish_shape *s = &m->moved;
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
    pl_measuring m = {.shape = shape, .moved = *shape, .place = place, .distance = distance};
    const int64_t n = shape->n_facets;
    m.moved.x = pl_alloc(shape->n_nodes, sizeof *m.moved.x);
    m.moved.normal = pl_alloc(n, sizeof *m.moved.normal);
    memset(distance, 0, sizeof *distance);
    int status = 0;
    if (!are_finite(x, shape->n_nodes)) {
        *distance = (pl_shape_distance){INFINITY, INFINITY, INFINITY, INFINITY, 2 * n, -1};
    } else if (m.moved.x && m.moved.normal) {
        memcpy(m.moved.x, x, (size_t)shape->n_nodes * sizeof *x);
        pl_parallel_for(threads, n, FACETS, compute_normals, &m);
        pl_parallel_for(threads, n, FACETS, measure_bends, &m);
        pl_parallel_for(threads, n, FACETS, measure_facets, &m);
        distance->sharpest = 1 - m.bend;
    } else {
        status = pl_fail_memory(error, "the distance of surfaces");
    }
    pl_free(m.moved.x);
    pl_free(m.moved.normal);
    return status;
}
