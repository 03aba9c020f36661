/* lattice_places: places in the grids of a lattice, loops over their slabs, and terms of exact sums.
 * Private to lattice.c, lattice_stiffness.c and lattice_solve.c.
 *
 *   pl_simplices_of, pl_unit_place, pl_cube_at, pl_simplex_at, pl_simplex_of, pl_weights_at
 *                                                                             where a point is
 *   pl_stride_of, pl_offset_of, pl_vertex_by, pl_find_coordinates             numbers of vertices
 *   pl_visit_slabs                                      a loop whose result no threads change
 *   pl_terms_up_to, pl_round_term, pl_add_over_parts    sums whose order does not matter
 */
#ifndef PL_IMPROVE_LATTICE_PLACES_H
#define PL_IMPROVE_LATTICE_PLACES_H

#include "base/parallel.h"
#include "base/parts.h"
#include "geometry/inline.h"
#include "improve/lattice.h"

#include <math.h>

enum { PL_CORNERS = 4 }; /* of a simplex, at most */

/* Directions in which a simplex goes from its first vertex to its last. In the plane there are two
 * orders: the first two without direction 2. */
static const int PL_ORDERS[][3] = {{0, 1, 2}, {1, 0, 2}, {0, 2, 1},
                                   {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};

/** Simplices of a cube. */
PL_INLINE int pl_simplices_of(int dim) {
    return dim == 3 ? 6 : 2;
}

/* ---- places -------------------------------------------------------------------------------- */

static inline int64_t pl_stride_of(const pl_grid *g, int direction) {
    return direction == 0 ? 1 : direction == 1 ? g->n[0] : g->n[0] * g->n[1];
}

/** Number of the vertex at offset bits from the first. */
static inline int64_t pl_offset_of(const pl_grid *g, int bits) {
    return (bits & 1) + (bits >> 1 & 1) * g->n[0] + (bits >> 2 & 1) * g->n[0] * g->n[1];
}

/** Coordinates of vertex number of a grid. */
static inline void pl_find_coordinates(const pl_grid *g, int64_t number, int64_t at[3]) {
    at[0] = number % g->n[0];
    at[1] = number / g->n[0] % g->n[1];
    at[2] = number / g->n[0] / g->n[1];
}

/** Coordinates of a node in the unit of the lattice. */
PL_INLINE void pl_unit_place(const pl_lattice *l, int64_t inner, double *x, int dim) {
    const double *from = l->plan->scratch.coordinates + inner * dim;
    for (int d = 0; d < dim; d++)
        x[d] = (from[d] - l->origin[d]) * l->per_unit;
}

/** Place in a cube: which, and how far along each direction. */
typedef struct pl_cube_place {
    int64_t vertex;
    double along[3];
} pl_cube_place;

PL_INLINE pl_cube_place pl_cube_at(const pl_grid *g, const double *x, int dim) {
    pl_cube_place p = {0, {0, 0, 0}};
    for (int d = 0; d < dim; d++) {
        const double t = x[d] * g->per_spacing[d], last = (double)(g->n[d] - 2);
        const int64_t i = (int64_t)(t > 0 ? t < last ? t : last : 0);
        p.along[d] = t - (double)i;
        p.vertex += i * pl_stride_of(g, d);
    }
    return p;
}

/** Row of PL_ORDERS of the simplex at a place in a cube. */
PL_INLINE int pl_find_order(const double f[3], int dim) {
    if (dim == 2)
        return f[0] >= f[1] ? 0 : 1;
    if (f[0] >= f[1])
        return f[1] >= f[2] ? 0 : f[0] >= f[2] ? 2 : 4;
    return f[0] >= f[2] ? 1 : f[1] >= f[2] ? 3 : 5;
}

/** Number of the simplex at x, of the finest grid that is active there. */
PL_INLINE int64_t pl_simplex_at(const pl_lattice *l, const double *x, int dim) {
    for (int level = 0;; level++) {
        const pl_grid *g = &l->grid[level];
        const pl_cube_place p = pl_cube_at(g, x, dim);
        const int order = pl_find_order(p.along, dim), *way = PL_ORDERS[order];
        int64_t vertex = p.vertex;
        int active = g->is_active[vertex];
        for (int d = 0; d < dim; d++)
            active |= g->is_active[vertex += pl_stride_of(g, way[d])];
        if (active || level == l->n_levels - 1)
            return g->first + p.vertex * pl_simplices_of(dim) + order;
    }
}

/** A simplex. */
typedef struct pl_simplex {
    const pl_grid *g;
    const int *way;
    int64_t vertex[PL_CORNERS];
    int bits[PL_CORNERS]; /* offsets of these from the first */
    double corner[3];     /* place of the first, in spacings */
} pl_simplex;

PL_INLINE pl_simplex pl_simplex_of(const pl_grid *g, int64_t number, int dim) {
    const int64_t of_grid = number - g->first;
    pl_simplex s = {.g = g, .way = PL_ORDERS[of_grid % pl_simplices_of(dim)]};
    int64_t at[3];
    s.vertex[0] = of_grid / pl_simplices_of(dim);
    pl_find_coordinates(g, s.vertex[0], at);
    for (int d = 0; d < dim; d++)
        s.corner[d] = (double)at[d];
    for (int d = 0; d < dim; d++) {
        s.bits[d + 1] = s.bits[d] | 1 << s.way[d];
        s.vertex[d + 1] = s.vertex[d] + pl_stride_of(g, s.way[d]);
    }
    return s;
}

/** Weights of the vertices of a simplex at x, which may be outside. */
PL_INLINE void pl_weights_at(const pl_simplex *s, const double *x, double *weight, int dim) {
    double along[3] = {0};
    for (int d = 0; d < dim; d++)
        along[d] = x[d] * s->g->per_spacing[d] - s->corner[d];
    weight[0] = 1 - along[s->way[0]];
    for (int d = 1; d < dim; d++)
        weight[d] = along[s->way[d - 1]] - along[s->way[d]];
    weight[dim] = along[s->way[dim - 1]];
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

/* ---- terms of exact sums ---------------------------------------------------------------------- */

/** Terms of sums: multiples of unit, so few that every sum of them is a double. */
typedef struct pl_terms {
    double unit;
    double shift; /* what is added to a term and taken off again is rounded to multiples of unit */
} pl_terms;

/** Rounding of n terms of at most largest. */
static inline pl_terms pl_terms_up_to(double largest, int64_t n) {
    enum { BITS = 52 }; /* of the largest sum, in units */
    int exponent, doublings = 2;
    frexp(largest, &exponent);
    while (((int64_t)1 << doublings) < n)
        doublings++;
    const double unit = ldexp(1, exponent + doublings - BITS);
    return (pl_terms){unit, 1.5 * 0x1p52 * unit};
}

/** Round x. */
static inline double pl_round_term(pl_terms terms, double x) {
    return (x + terms.shift) - terms.shift;
}

/** Set sums [n] of such terms to those of all processes. */
static inline void pl_add_over_parts(pl_terms terms, double *sums, int64_t n) {
    enum { AT_ONCE = 4096 };
    int64_t units[AT_ONCE];
    if (!pl_part_here())
        return;
    for (int64_t begin = 0; begin < n; begin += AT_ONCE) {
        const int count = (int)(n - begin < AT_ONCE ? n - begin : AT_ONCE);
        for (int i = 0; i < count; i++)
            units[i] = (int64_t)(sums[begin + i] / terms.unit);
        pl_parts_add(units, count);
        for (int i = 0; i < count; i++)
            sums[begin + i] = (double)units[i] * terms.unit;
    }
}

/* ---- loops ---------------------------------------------------------------------------------- */

/** Work on the slabs of a grid along its last direction: those of one parity share no vertices that
 *  are written. */
typedef struct pl_slab_pass {
    pl_lattice *l;
    const pl_grid *g;
    void (*body)(const struct pl_slab_pass *pass, int64_t slab);
    int64_t parity;
    int is_backward;
    const double *from; /* [n_stars][dim] */
    double *to;         /* [n_stars][dim] */
    const double *b, *x;
    double *y; /* [n_vertices][dim] */
    double factor;
    pl_terms terms;
} pl_slab_pass;

static inline void pl_slab_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const pl_slab_pass *p = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        p->body(p, 2 * i + p->parity);
}

/** Visit n slabs: those of one parity, then the others. */
static inline void pl_visit_slabs(pl_slab_pass *p, int64_t n) {
    const int threads = pl_paying_threads(p->l->plan->threads, p->g->n_vertices * 16);
    for (int k = 0; k < 2; k++) {
        p->parity = k ^ p->is_backward;
        pl_parallel_for(threads, (n + 1 - p->parity) / 2, 1, pl_slab_chunk, p);
    }
}

#endif
