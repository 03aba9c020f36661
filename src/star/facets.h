/* facets: gather a star and what stays constant while its node moves.
 *
 * One visit works on columns (structure of arrays) of the star's link facets, padded to a multiple
 * of PL_LANES with copies of facet 0 of weight 0. All columns of a star lie together in scratch.
 */
#ifndef PL_STAR_FACETS_H
#define PL_STAR_FACETS_H

#include "star/lanes.h"

#include <string.h>

/** Columns; in 2-D those with Z, C, N, W are not used. Symbols as in docs/algorithm.md. */
enum {
    P0X,
    P0Y,
    P1X,
    P1Y,      /* the facet's nodes */
    LENGTH,   /* 3-D: twice the facet's area |n|; 2-D: its length L */
    ROUNDING, /* D is certain to be positive where D^2 > ROUNDING * |x - p0|^2 */
    WEIGHT,   /* 1, or 0 for padding */
    RATE,     /* 1 / D, see blocking_rate in step.h */
    /* The next four are for the guarded kernel alone. */
    FLOOR,         /* the least D that is asked for; 0: only positive */
    INVERSE_FLOOR, /* 1 / floor, or 0 */
    GVALUE,        /* g = 1 - D / floor */
    SHIFT,         /* lambda / penalty, see pl_star_guard */
    /* The next three are for untangling alone. */
    INVERSE_TARGET, /* 1 / the D that is wanted */
    INVERSE_EDGE2,  /* 1 / the square of its edges */
    SHARE,          /* PL_SHARES / nodes of the element that are in the patch */
    COLUMNS_2D,
    P0Z = COLUMNS_2D,
    P1Z,
    P2X,
    P2Y,
    P2Z,
    NX,
    NY,
    NZ, /* n = (p1 - p0) x (p2 - p0) */
    WX,
    WY,
    WZ, /* w = |b|^2 c - |c|^2 b, b = p1 - p0, c = p2 - p0 */
    COLUMNS_3D
};

/** A gathered star. Its coordinates are those of the mesh times a power of two, which brings the
 * star to a size of about 1: no bit of any result depends on it, and nothing over- or underflows.
 */
typedef struct star {
    double *column; /* [COLUMNS][padded] */
    int64_t padded; /* facets, padded to a multiple of PL_LANES */
    int64_t n_facets;
    const int32_t *ring; /* [n_ring] */
    int64_t n_ring;
    double scale, unscale; /* coordinates here / in the mesh, and the inverse */
    double *spare;         /* [SPARE_ROWS + padded][4] for the rows of constraints */
} star;

/* Rows of constraints besides the facets': two bounds per coordinate, and the distance moved. */
enum { SPARE_ROWS = 7, ROW_LENGTH = 4 };

static inline lanes load(const star *s, int column, int64_t i) {
    return lanes_load(s->column + column * s->padded + i);
}
static inline void store(const star *s, int column, int64_t i, lanes a) {
    lanes_store(s->column + column * s->padded + i, a);
}

typedef struct vec3 {
    lanes x, y, z;
} vec3;

static inline vec3 vec3_load(const star *s, int cx, int cy, int cz, int64_t i) {
    return (vec3){load(s, cx, i), load(s, cy, i), load(s, cz, i)};
}
static inline vec3 vec3_minus(vec3 a, vec3 b) {
    return (vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline vec3 vec3_scaled(vec3 a, lanes f) {
    return (vec3){a.x * f, a.y * f, a.z * f};
}
static inline vec3 vec3_plus(vec3 a, vec3 b) {
    return (vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline lanes vec3_dot(vec3 a, vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline vec3 vec3_cross(vec3 a, vec3 b) {
    return (vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/** Sum of the absolute values of the components. */
static inline lanes vec3_norm1(vec3 a) {
    return lanes_abs(a.x) + lanes_abs(a.y) + lanes_abs(a.z);
}

/* Rounding error of D = (x - p0) . ((p1 - p0) x (p2 - p0)), all as computed: at most (7 + 56u) u
 * times its permanent, u = 2^-53 (Shewchuk 1997), and the permanent is at most
 * sqrt(3) |x - p0| |b|_1 |c|_1. 8 for 7 pays for the rounding of the bound itself. In 2-D
 * (3 + 16u) u and sqrt(2) |x - p0| |b|_1. */
#define ROUNDING_3D (3 * 64 * 0x1p-106)
#define ROUNDING_2D (2 * 16 * 0x1p-106)

/** n, w, |n| and ROUNDING of the facets from their nodes. */
static inline void facet_constants_3d(const star *s) {
    for (int64_t i = 0; i < s->padded; i += PL_PACK) {
        vec3 p0 = vec3_load(s, P0X, P0Y, P0Z, i);
        vec3 b = vec3_minus(vec3_load(s, P1X, P1Y, P1Z, i), p0);
        vec3 c = vec3_minus(vec3_load(s, P2X, P2Y, P2Z, i), p0);
        vec3 n = vec3_cross(b, c);
        vec3 w = vec3_minus(vec3_scaled(c, vec3_dot(b, b)), vec3_scaled(b, vec3_dot(c, c)));
        lanes permanent = vec3_norm1(b) * vec3_norm1(c);
        store(s, NX, i, n.x);
        store(s, NY, i, n.y);
        store(s, NZ, i, n.z);
        store(s, WX, i, w.x);
        store(s, WY, i, w.y);
        store(s, WZ, i, w.z);
        store(s, LENGTH, i, lanes_sqrt(vec3_dot(n, n)));
        store(s, ROUNDING, i, lanes_of(ROUNDING_3D) * (permanent * permanent));
    }
}

/** Lengths and ROUNDING of the facets (edges) from their nodes. */
static inline void facet_constants_2d(const star *s) {
    for (int64_t i = 0; i < s->padded; i += PL_PACK) {
        lanes bx = load(s, P1X, i) - load(s, P0X, i);
        lanes by = load(s, P1Y, i) - load(s, P0Y, i);
        lanes permanent = lanes_abs(bx) + lanes_abs(by);
        store(s, LENGTH, i, lanes_sqrt(bx * bx + by * by));
        store(s, ROUNDING, i, lanes_of(ROUNDING_2D) * (permanent * permanent));
    }
}

/** Copy one facet's nodes to row i of the columns. */
static inline void facet_row(const star *s, int64_t i, const uint16_t *facet,
                             const double *ring_xyz, const int dim) {
    static const uint8_t columns[3][3] = {{P0X, P0Y, P0Z}, {P1X, P1Y, P1Z}, {P2X, P2Y, P2Z}};
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            s->column[columns[j][d] * s->padded + i] = ring_xyz[facet[j] * dim + d];
}

/** Copy the coordinates of the facets' nodes from the ring's into the columns, padding included. */
static inline void facet_nodes(const star *s, const uint16_t *link, const double *ring_xyz,
                               const int dim) {
    double *weight = s->column + WEIGHT * s->padded;
    for (int64_t i = 0; i < s->n_facets; i++) {
        facet_row(s, i, link + i * dim, ring_xyz, dim);
        weight[i] = 1;
    }
    for (int64_t i = s->n_facets; i < s->padded; i++) {
        facet_row(s, i, link, ring_xyz, dim);
        weight[i] = 0;
    }
}

/* Exponents of the scale are kept within this, so that it and its inverse are doubles. */
enum { SCALE_LIMIT = 1000 };

/** 2^exponent, for exponents of normal doubles. */
static inline double power_of_two(int exponent) {
    uint64_t bits = (uint64_t)(exponent + 1023) << 52;
    double power;
    memcpy(&power, &bits, sizeof power);
    return power;
}

/** Choose the scale from extent, half of the largest difference of a coordinate in the star. */
static inline void choose_scale(star *s, double extent) {
    uint64_t bits;
    memcpy(&bits, &extent, sizeof bits);
    int exponent = (int)(bits >> 52 & 0x7ff) - 1023;
    if (exponent > SCALE_LIMIT)
        exponent = SCALE_LIMIT;
    if (exponent < -SCALE_LIMIT)
        exponent = -SCALE_LIMIT;
    s->scale = power_of_two(-exponent);
    s->unscale = power_of_two(exponent);
}

/** Copy the ring's coordinates to ring_xyz [n_ring][dim], scaled. */
static inline void gather_ring(const pl_star_problem *problem, star *s, const double *x,
                               double *ring_xyz, const int dim) {
    double extent = 0;
    for (int64_t i = 0; i < s->n_ring; i++)
        for (int d = 0; d < dim; d++) {
            double p = problem->coordinates[(int64_t)s->ring[i] * dim + d];
            double half = fabs(0.5 * p - 0.5 * x[d]); /* the whole could overflow */
            extent = half > extent ? half : extent;
            ring_xyz[i * dim + d] = p;
        }
    choose_scale(s, extent);
    for (int64_t i = 0; i < s->n_ring * dim; i++)
        ring_xyz[i] *= s->scale;
}

/* Floors are kept within this and its inverse, of stars of a size of about 1: nothing over- or
 * underflows, and which elements are above and below is the same. */
#define FLOOR_LEAST 1e-100

/** The least D of an element with its own least volume, or else the general one. Times scale dim
 *  times, one by one: the volume is of the size of the star. */
static inline double floor_of(const pl_star_problem *problem, const star *s, double own,
                              const int dim) {
    double volume = own > 0 ? own : problem->guard->min_volume, least = volume;
    for (int d = 0; d < dim; d++)
        least *= s->scale;
    least *= dim == 3 ? 6 : 2;
    if (!(volume > 0))
        return 0;
    least = least > FLOOR_LEAST ? least : FLOOR_LEAST;
    return least < 1 / FLOOR_LEAST ? least : 1 / FLOOR_LEAST;
}

/** Fill in the columns FLOOR and INVERSE_FLOOR; first: the star's first link facet of all. */
static inline void gather_floors(const pl_star_problem *problem, const star *s, int64_t first,
                                 const int dim) {
    const double *own = problem->guard->link_min_volume;
    double *column = s->column + FLOOR * s->padded,
           *inverse = s->column + INVERSE_FLOOR * s->padded;
    double floor = floor_of(problem, s, own ? own[first] : 0, dim);
    double inverse_floor = floor > 0 ? 1 / floor : 0;
    for (int64_t i = 0; i < s->padded; i++) {
        column[i] = floor; /* of all, or of facet 0 and the padding */
        inverse[i] = inverse_floor;
    }
    for (int64_t i = 1; own && i < s->n_facets; i++) {
        column[i] = floor_of(problem, s, own[first + i], dim);
        inverse[i] = column[i] > 0 ? 1 / column[i] : 0;
    }
    if (problem->guard->penalty > 0) {
        double *shift = s->column + SHIFT * s->padded;
        for (int64_t i = 0; i < s->padded; i++)
            shift[i] = problem->guard->link_shift[first + (i < s->n_facets ? i : 0)];
    }
}

/** Gather star index of problem, with its node at x (as in the mesh), into scratch. */
static inline star gather(const pl_star_problem *problem, int64_t index, const double *x,
                          double *scratch, const int guarded, const int dim) {
    star s;
    int64_t first = problem->link_offset[index];
    s.n_facets = problem->link_offset[index + 1] - first;
    s.padded = (s.n_facets + PL_LANES - 1) / PL_LANES * PL_LANES;
    s.ring = problem->ring + problem->ring_offset[index];
    s.n_ring = problem->ring_offset[index + 1] - problem->ring_offset[index];
    s.column = scratch;
    s.spare = scratch + s.padded * (dim == 3 ? COLUMNS_3D : COLUMNS_2D);
    double *ring_xyz = s.spare; /* no longer needed once the columns are filled */
    gather_ring(problem, &s, x, ring_xyz, dim);
    facet_nodes(&s, problem->link + first * dim, ring_xyz, dim);
    if (dim == 3)
        facet_constants_3d(&s);
    else
        facet_constants_2d(&s);
    if (guarded)
        gather_floors(problem, &s, first, dim);
    return s;
}

#endif
