/* kernel_facets: a star in scratch, and the constants of its facets while its node moves.
 *
 * One visit works on columns of the star's link facets and of their edges (kernel_link_edges.h),
 * padded to a multiple of PL_LANES with copies of the first; those of facets have weight 0. All
 * columns of PL_LANES facets lie together (an array of structures of packs). All of a star lies
 * together in scratch.
 *
 *   star, has_forms, node_of_facet                    a star, and the nodes of its facets
 *   in_block, pack_in_block, entry, load, store       entries of columns, one or a pack
 *   vec3_*                                            packs of vectors
 *   form_row, forms_3d, form_2d                       forms of the facets of corners
 *   store_point, facets_3d, circles_3d, facets_2d     fill the columns
 */
#ifndef PL_STAR_KERNEL_FACETS_H
#define PL_STAR_KERNEL_FACETS_H

#include "star/kernel_rows.h"

#include <string.h>

/** Columns of facets; in 2-D those from P0Z on are not used. In 3-D P1 and P2 are for the
 *  guarded kernel. Symbols as in docs/algorithm.md. */
enum {
    P0X,
    P0Y,
    P1X,
    P1Y,      /* the facet's nodes */
    LENGTH,   /* 3-D: twice the facet's area |n|; 2-D: its length L */
    ROUNDING, /* D is certain to be positive where D^2 > ROUNDING * |x - p0|^2 */
    WEIGHT,   /* 1, or 0 for padding */
    RATE,     /* 1 / D, see limiting_rate in kernel_step.h */
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
    OX,
    OY,
    OZ, /* p0 - o, o the facet's circumcentre */
    NN, /* |n|^2 */
    WW, /* 4 rho^2, rho the facet's circumradius */
    /* The rest is for derivatives, from one pass over the facets to the next
     * (kernel_radius_ratio.h).
     */
    CX,
    CY,
    CZ, /* x - o */
    SX,
    SY,
    SZ,    /* grad s, then grad s / s */
    AREAS, /* sum of the areas of the faces at x, times two */
    RR2,   /* RR^2 times the weight */
    OF_S,  /* 2 RR2 / s, the weight of hess s */
    OF_C,
    OF_N,
    OF_CC,
    OF_CN,
    OF_NN,  /* see coefficients in kernel_tetrahedra.h */
    UNIT,   /* of corners with targets: 1 / det W, */
    WANTED, /* and det W */
    COLUMNS_3D
};

/** Columns of facets with forms (geometry/corner.h), instead of others. OX, OY, OZ are p0 - o. */
enum {
    FORM_C = NN,  /* E = c |x - o|^2 + e0, c */
    FORM_E0 = WW, /* and e0 */
    BASE = CX,    /* D = base + n . (x - p0): 0, but of further rows */
    IS_FACET =
        OF_NN, /* 1, or 0 for padding and further rows, which have no part in the star's size */
    DETERMINANT =
        INVERSE_TARGET,   /* D and, in space, D^(-1/3), from one pass over the facets to the */
    ROOT = INVERSE_EDGE2, /* next */
    /* The rest is for the guarded kernel alone. */
    IS_EDGE = CY,               /* six: 1 if the element has the edge, else 0; those at x first */
    EDGE_SHARE = IS_EDGE + 6,   /* 1 / its edges */
    IS_CORNER = EDGE_SHARE + 1, /* four: 1 if x, or p_i, is a corner of the element, else 0 */
    JACOBIAN = IS_CORNER + 4,   /* SJ^-2 of one is this times the squares of its edges / D^2 */
    FORM_COLUMNS_END = JACOBIAN + 1,
    METRIC = IS_EDGE /* six, with a metric: its L. Objectives of edges are without targets */
};
_Static_assert((int)FORM_COLUMNS_END <= (int)IS_FACET, "columns of forms have room");

/** Gathered star. Its coordinates are those of the mesh times a power of two, which brings the
 * star to a size of about 1: no bit of any result depends on it, and nothing over- or underflows.
 */
typedef struct star {
    double *column; /* [padded / PL_LANES][COLUMNS_3D][PL_LANES] */
    int64_t padded; /* facets, padded to a multiple of PL_LANES */
    int64_t n_facets;
    int64_t n_more;        /* further rows: columns of facets after those of the facets */
    double *edge;          /* [padded_edges / PL_LANES][EDGE_COLUMNS][PL_LANES], 3-D; not for the
                              guarded kernel */
    double *area, *shared; /* [padded_edges] of the faces at x, and the weights of their Hessians */
    double *edge_row;      /* [padded_edges][PL_ROW] likewise, while derivatives are computed */
    int64_t padded_edges;  /* edges, padded to PL_LANES */
    const uint32_t *facet; /* [padded][dim] its nodes, as rows of the ring */
    const uint32_t *facet_edge; /* [padded][3] its edges, as rows of edges, 3-D; without forms */
    const uint32_t *form;       /* [padded] its form, as a row of forms; NULL: all are simplices */
    const pl_corner_form *forms;
    double weight;       /* sum of the facets' */
    double size_weight;  /* as of the problem, 0 without targets */
    int has_metric;      /* 1: the columns METRIC count */
    const int32_t *ring; /* [n_ring] */
    int64_t n_ring;
    double scale, unscale; /* coordinates here / in the mesh, and the inverse */
    double *spare;         /* [SPARE_ROWS + padded][4] for the rows of constraints */
} star;

/* Rows of constraints besides the facets': two bounds per coordinate, and the distance moved. */
enum { SPARE_ROWS = 7, ROW_LENGTH = 4 };

/** Whether the facets have forms, and their ratios are mean ratios. */
PL_INLINE int has_forms(const star *s) {
    return PL_KERNEL == PL_GUARDED ? s->form != NULL : PL_KERNEL == PL_MEAN;
}

/** Node j of facet i, by its inner number. */
PL_INLINE int32_t node_of_facet(const star *s, int64_t i, int j, int dim) {
    return s->ring[s->facet[i * dim + j] / PL_ROW];
}

/** Entry i of a column, in a block [.][n_columns][PL_LANES]: what belongs to PL_LANES facets lies
 *  together, at places that are known beforehand but for one pointer. */
PL_INLINE double *in_block(double *block, const int n_columns, int column, int64_t i) {
    const int64_t lane = i & (PL_LANES - 1);
    return block + (i - lane) * n_columns + (column * PL_LANES + lane);
}

/** Entries of a column, in a block as for in_block, of the pack that begins with facet i. */
PL_INLINE double *pack_in_block(double *block, const int n_columns, int column, int64_t i) {
    return PL_PACK == PL_LANES ? block + i * n_columns + column * PL_LANES
                               : in_block(block, n_columns, column, i);
}

/** Entry of facet i in a column of the star. */
PL_INLINE double *entry(const star *s, int column, int64_t i) {
    return in_block(s->column, COLUMNS_3D, column, i);
}

/** Load the pack at facet i from a column. */
PL_INLINE lanes load(const star *s, int column, int64_t i) {
    return lanes_load(pack_in_block(s->column, COLUMNS_3D, column, i));
}

/** Store a pack at facet i in a column. */
PL_INLINE void store(const star *s, int column, int64_t i, lanes a) {
    lanes_store(pack_in_block(s->column, COLUMNS_3D, column, i), a);
}

typedef struct vec3 {
    lanes x, y, z;
} vec3;

/** Load the pack at facet i from three columns. */
PL_INLINE vec3 vec3_load(const star *s, int cx, int cy, int cz, int64_t i) {
    return (vec3){load(s, cx, i), load(s, cy, i), load(s, cz, i)};
}

/** Store the pack at facet i in three columns from cx on. */
PL_INLINE void vec3_store(const star *s, int cx, int64_t i, vec3 a) {
    store(s, cx, i, a.x);
    store(s, cx + 1, i, a.y);
    store(s, cx + 2, i, a.z);
}

/** Difference a - b. */
PL_INLINE vec3 vec3_minus(vec3 a, vec3 b) {
    return (vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}

/** Vector a times f. */
PL_INLINE vec3 vec3_scaled(vec3 a, lanes f) {
    return (vec3){a.x * f, a.y * f, a.z * f};
}

/** Sum a + b. */
PL_INLINE vec3 vec3_plus(vec3 a, vec3 b) {
    return (vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}

/** Scalar product of a and b. */
PL_INLINE lanes vec3_dot(vec3 a, vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/** Vector product of a and b. */
PL_INLINE vec3 vec3_cross(vec3 a, vec3 b) {
    return (vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/* The sign of D = (x - p0) . (b x c), b = p1 - p0, c = p2 - p0, all as computed, is certain where
 * |D| is above (7 + 56u) u times its permanent, u = 2^-53 (Shewchuk 1997; the last addition,
 * another u |D|, changes no sign). The permanent is sum_i |x_i - p0_i| v_i <= |x - p0| |v| with
 * v_i = |b_j c_k| + |b_k c_j|, and
 *
 *     |v|^2 = |b|^2 |c|^2 + q^2 - 2 sum t_i^2,  t_i = |b_i c_i|, q = sum t_i, sum t_i^2 >= q^2 / 3
 *          <= |b|^2 |c|^2 + q^2 / 3 <= 4/3 |b|^2 |c|^2
 *
 * 8 for 7 pays for the rounding of the bound itself. In 2-D (3 + 16u) u and |x - p0| |b|. */
#define ROUNDING_3D (4.0 / 3 * 64 * 0x1p-106)
#define ROUNDING_2D (16 * 0x1p-106)

/* AR^2 of the mean ratio is E^2 D^(-4/3), E the sum of the squared edges times this; in the plane
 * E^2 D^-2. */
#define ROOT_OF_FACTOR_3D 0.13228342099734996 /* 2^(2/3) / 12 */
#define ROOT_OF_FACTOR_2D 0.28867513459481288 /* 1 / sqrt(12) */

/** The columns of one corner. */
PL_INLINE void store_point(const star *s, int cx, int cy, int cz, int64_t i, const lanes *p,
                           const int dim) {
    store(s, cx, i, p[0]);
    store(s, cy, i, p[1]);
    if (dim == 3)
        store(s, cz, i, p[2]);
}

/* ---- forms --------------------------------------------------------------------------------- */

/** Rows of the forms of a pack, as columns. */
typedef struct form_row {
    lanes column[8];
} form_row;

/** Row of the only form of simplices: the mean ratio of one counts all edges alike. */
PL_INLINE form_row simplex_row(const int dim) {
    const lanes zero = lanes_of(0), third = lanes_of(1.0 / 3), half = lanes_of(0.5);
    const double c = dim == 3 ? 3 * ROOT_OF_FACTOR_3D : 2 * ROOT_OF_FACTOR_2D;
    const lanes of = lanes_of(dim == 3 ? 4 * ROOT_OF_FACTOR_3D / 3 : 3 * ROOT_OF_FACTOR_2D / 2);
    return (form_row){{dim == 3 ? third : half, dim == 3 ? third : zero, lanes_of(c), lanes_of(1),
                       of, dim == 3 ? of : zero, dim == 3 ? of : zero, zero}};
}

/** Load the rows of the pack at facet i. */
PL_INLINE form_row form_row_load(const star *s, int64_t i, const int dim) {
    form_row r;
    if (!s->form)
        return simplex_row(dim);
    const double *row[PL_PACK];
    for (int k = 0; k < PL_PACK; k++)
        row[k] = s->forms[s->form[i + k]].row;
#if PL_PACK == 4 && defined(__AVX__)
    for (int half = 0; half < 8; half += 4) {
        lanes in[4];
        for (int k = 0; k < 4; k++)
            in[k] = _mm256_loadu_pd(row[k] + half);
        exchange(in, r.column + half);
    }
#else
    for (int c = 0; c < 8; c++)
        for (int k = 0; k < PL_PACK; k++)
            ((double *)&r.column[c])[k] = row[k][c];
#endif
    return r;
}

/** Compute the constants of the forms of a pack of facets from b = p1 - p0 and c = p2 - p0. */
PL_INLINE void forms_3d(const star *s, int64_t i, vec3 b, vec3 c) {
    const form_row r = form_row_load(s, i, 3);
    const vec3 e = vec3_minus(c, b);
    const lanes zero = lanes_of(0);
    vec3_store(s, OX, i,
               (vec3){zero - (r.column[0] * b.x + r.column[1] * c.x),
                      zero - (r.column[0] * b.y + r.column[1] * c.y),
                      zero - (r.column[0] * b.z + r.column[1] * c.z)});
    store(s, FORM_C, i, r.column[2]);
    store(s, FORM_E0, i,
          r.column[4] * vec3_dot(b, b) + r.column[5] * vec3_dot(c, c) +
              r.column[6] * vec3_dot(e, e));
    store(s, WEIGHT, i, r.column[3]);
    store(s, BASE, i, zero);
    store(s, IS_FACET, i, lanes_of(1));
}

/** Compute the constants of the forms of a pack of edges b. */
PL_INLINE void form_2d(const star *s, int64_t i, lanes bx, lanes by, lanes bb) {
    const form_row r = form_row_load(s, i, 2);
    store(s, OX, i, lanes_of(0) - r.column[0] * bx);
    store(s, OY, i, lanes_of(0) - r.column[0] * by);
    store(s, FORM_C, i, r.column[2]);
    store(s, FORM_E0, i, r.column[4] * bb);
    store(s, WEIGHT, i, r.column[3]);
    store(s, BASE, i, lanes_of(0));
    store(s, IS_FACET, i, lanes_of(1));
}

/* ---- facets -------------------------------------------------------------------------------- */

/** Compute the constants of the facets of a star of tetrahedra, except circles_3d, from their
 *  nodes in ring [.][PL_ROW]; OX, OY, OZ are w until then. */
PL_INLINE void facets_3d(const star *s, const double *ring, const int guarded,
                         const int of_corners) {
    for (int64_t i = 0; i < s->padded; i += PL_PACK) {
        lanes p0[PL_ROW], p1[PL_ROW], p2[PL_ROW];
        points_to_columns(ring, s->facet + 3 * i, 3, p0);
        points_to_columns(ring, s->facet + 3 * i + 1, 3, p1);
        points_to_columns(ring, s->facet + 3 * i + 2, 3, p2);
        store_point(s, P0X, P0Y, P0Z, i, p0, 3);
        if (guarded) {
            store_point(s, P1X, P1Y, P1Z, i, p1, 3);
            store_point(s, P2X, P2Y, P2Z, i, p2, 3);
        }
        vec3 b = {p1[0] - p0[0], p1[1] - p0[1], p1[2] - p0[2]};
        vec3 c = {p2[0] - p0[0], p2[1] - p0[1], p2[2] - p0[2]};
        lanes bb = vec3_dot(b, b), cc = vec3_dot(c, c);
        vec3_store(s, NX, i, vec3_cross(b, c));
        if (of_corners)
            forms_3d(s, i, b, c);
        else
            vec3_store(s, OX, i, vec3_minus(vec3_scaled(c, bb), vec3_scaled(b, cc)));
        store(s, ROUNDING, i, lanes_of(ROUNDING_3D) * (bb * cc));
    }
}

/** The rest of it for a pack: areas and circumcircles. w is orthogonal to n and |w| = 2 rho |n|. */
PL_INLINE void circles_3d(const star *s, int64_t i) {
    vec3 n = vec3_load(s, NX, NY, NZ, i), w = vec3_load(s, OX, OY, OZ, i);
    lanes nn = vec3_dot(n, n), inverse = lanes_of(1) / nn;
    vec3_store(s, OX, i, vec3_scaled(vec3_cross(n, w), lanes_of(0.5) * inverse));
    store(s, NN, i, nn);
    store(s, WW, i, vec3_dot(w, w) * inverse);
    store(s, LENGTH, i, lanes_sqrt(nn));
}

/** Compute the constants of the facets of a star of triangles; these facets are edges. */
PL_INLINE void facets_2d(const star *s, const double *ring, const int of_corners) {
    for (int64_t i = 0; i < s->padded; i += PL_PACK) {
        lanes p[PL_ROW], q[PL_ROW];
        points_to_columns(ring, s->facet + 2 * i, 2, p);
        points_to_columns(ring, s->facet + 2 * i + 1, 2, q);
        store_point(s, P0X, P0Y, P0Z, i, p, 2);
        store_point(s, P1X, P1Y, P1Z, i, q, 2);
        lanes bx = q[0] - p[0], by = q[1] - p[1];
        lanes bb = bx * bx + by * by;
        store(s, LENGTH, i, lanes_sqrt(bb));
        store(s, ROUNDING, i, lanes_of(ROUNDING_2D) * bb);
        if (of_corners)
            form_2d(s, i, bx, by, bb);
    }
}

#endif
