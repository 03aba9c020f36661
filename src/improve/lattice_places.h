/* lattice_places: places in the grids of a lattice, and loops over their layers. Private to lattice.c,
 * lattice_stiffness.c and lattice_solve.c.
 *
 *   pl_cube_at, pl_simplex_at, pl_simplex_of, pl_weights_at    where a point is
 *   pl_stride_of, pl_offset_of, pl_vertex_by                   numbers of vertices
 *   pl_visit_layers                                            a loop whose result no threads change
 */
#ifndef PL_IMPROVE_LATTICE_PLACES_H
#define PL_IMPROVE_LATTICE_PLACES_H

#include "base/parallel.h"
#include "geometry/inline.h"
#include "improve/lattice.h"

enum { PL_MAX_CORNERS = 4 };

/* Directions in which a simplex goes from its first vertex to its last. */
static const int PL_ORDERS[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                    {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};

/* ---- places -------------------------------------------------------------------------------- */

static inline int pl_orders_of(int dim) {
    return dim == 3 ? 6 : 2;
}

/** Order of directions for dim 2 is that of 3-D's 0 and 2: their last direction is the third. */
static inline const int *pl_order_of(int dim, int64_t order) {
    return PL_ORDERS[dim == 3 ? order : 2 * order];
}

static inline int64_t pl_stride_of(const pl_grid *g, int direction) {
    return direction == 0 ? 1 : direction == 1 ? g->n[0] : g->n[0] * g->n[1];
}

/** Number of the vertex at offset bits from the first. */
static inline int64_t pl_offset_of(const pl_grid *g, int bits) {
    return (bits & 1) + (bits >> 1 & 1) * g->n[0] + (bits >> 2 & 1) * g->n[0] * g->n[1];
}

/** Coordinates of a node in the unit of the lattice. */
PL_INLINE void pl_unit_place(const pl_lattice *l, int64_t inner, double *x, const int dim) {
    const double *from = l->plan->scratch.coordinates + inner * dim;
    for (int d = 0; d < dim; d++)
        x[d] = (from[d] - l->origin[d]) * l->per_unit;
}

/** Place in a cube: which, and how far along each direction. */
typedef struct pl_cube_place {
    int64_t vertex;
    double along[3];
} pl_cube_place;

PL_INLINE pl_cube_place pl_cube_at(const pl_grid *g, const double *x, const int dim) {
    pl_cube_place p = {0, {0, 0, 0}};
    for (int d = 0; d < dim; d++) {
        const double t = x[d] * g->per_spacing;
        int64_t i = (int64_t)t;
        i = i < 0 ? 0 : i > g->n[d] - 2 ? g->n[d] - 2 : i;
        p.along[d] = t - (double)i;
        p.vertex += i * pl_stride_of(g, d);
    }
    return p;
}

static inline int pl_find_order(const double f[3], int dim) {
    if (dim == 2)
        return f[0] < f[1];
    if (f[0] >= f[1])
        return f[1] >= f[2] ? 0 : f[0] >= f[2] ? 1 : 4;
    return f[0] >= f[2] ? 2 : f[1] >= f[2] ? 3 : 5;
}

/** Number of the simplex at x, of the finest grid that is active there; and its level. */
PL_INLINE int64_t pl_simplex_at(const pl_lattice *l, const double *x, const int dim) {
    for (int level = 0;; level++) {
        const pl_grid *g = &l->grid[level];
        const pl_cube_place p = pl_cube_at(g, x, dim);
        const int order = pl_find_order(p.along, dim), *way = pl_order_of(dim, order);
        int64_t vertex = p.vertex;
        int active = g->is_active[vertex];
        for (int d = 0; d < dim; d++)
            active |= g->is_active[vertex += pl_stride_of(g, way[d])];
        if (active || level == l->n_levels - 1)
            return g->first + p.vertex * pl_orders_of(dim) + order;
    }
}

/** A simplex. */
typedef struct pl_simplex {
    const pl_grid *g;
    const int *way;
    int64_t vertex[PL_MAX_CORNERS];
    int bits[PL_MAX_CORNERS]; /* offsets of these from the first */
    double corner[3];         /* place of the first, in spacings */
} pl_simplex;

PL_INLINE pl_simplex pl_simplex_of(const pl_grid *g, int64_t number, const int dim) {
    const int64_t of_grid = number - g->first;
    pl_simplex s = {.g = g, .way = pl_order_of(dim, of_grid % pl_orders_of(dim))};
    const int64_t first = of_grid / pl_orders_of(dim);
    s.vertex[0] = first;
    s.corner[0] = (double)(first % g->n[0]);
    s.corner[1] = (double)(first / g->n[0] % g->n[1]);
    s.corner[2] = (double)(first / g->n[0] / g->n[1]);
    for (int d = 0; d < dim; d++) {
        s.bits[d + 1] = s.bits[d] | 1 << s.way[d];
        s.vertex[d + 1] = s.vertex[d] + pl_stride_of(g, s.way[d]);
    }
    return s;
}

/** Weights of the vertices of a simplex at x, which may be outside. */
PL_INLINE void pl_weights_at(const pl_simplex *s, const double *x, double *weight, const int dim) {
    double along[3] = {0};
    for (int d = 0; d < dim; d++)
        along[d] = x[d] * s->g->per_spacing - s->corner[d];
    weight[0] = 1 - along[s->way[0]];
    for (int d = 1; d < dim; d++)
        weight[d] = along[s->way[d - 1]] - along[s->way[d]];
    weight[dim] = along[s->way[dim - 1]];
}

/* ---- loops ---------------------------------------------------------------------------------- */

/** Work on the layers of a grid along its last direction: those of one parity share no vertices that
 *  are written. */
typedef struct pl_layer_pass {
    pl_lattice *l;
    const pl_grid *g;
    void (*body)(const struct pl_layer_pass *pass, int64_t layer);
    int64_t parity;
    int is_backward;
    const double *from; /* [n_stars][dim] */
    double *to;         /* [n_stars][dim] */
    const double *b, *x;
    double *y; /* [n_vertices][dim] */
    double factor;
} pl_layer_pass;

static inline void pl_layer_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const pl_layer_pass *p = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        p->body(p, 2 * i + p->parity);
}

/** Visit n layers: those of one parity, then the others. */
static inline void pl_visit_layers(pl_layer_pass *p, int64_t n) {
    const int threads = pl_paying_threads(p->l->plan->threads, p->g->n_vertices * 16);
    for (int k = 0; k < 2; k++) {
        p->parity = k ^ p->is_backward;
        pl_parallel_for(threads, (n + 1 - p->parity) / 2, 1, pl_layer_chunk, p);
    }
}

/** Vertex of a finer grid, or of this one, by coordinates. */
typedef struct pl_vertex_at {
    int64_t at[3], number; /* number is -1 outside of the grid */
} pl_vertex_at;

static inline pl_vertex_at pl_vertex_by(const pl_grid *g, const int64_t at[3], int bits, int sign) {
    pl_vertex_at v = {.number = 0};
    for (int d = 0; d < 3; d++) {
        v.at[d] = at[d] + sign * (bits >> d & 1);
        if (v.at[d] < 0 || v.at[d] >= g->n[d])
            return (pl_vertex_at){.number = -1};
        v.number += v.at[d] * pl_stride_of(g, d);
    }
    return v;
}

/** Coordinates of vertex number of a grid. */
static inline void pl_find_coordinates(const pl_grid *g, int64_t number, int64_t at[3]) {
    at[0] = number % g->n[0];
    at[1] = number / g->n[0] % g->n[1];
    at[2] = number / g->n[0] / g->n[1];
}

#endif
