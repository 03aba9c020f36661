/* measure_block: the measures of a few elements at once.
 *
 * Elements are taken in blocks of PL_SUM_LANES. A block gathers its vertices and evaluates all
 * lanes at once by the plain formulas of geometry/simplex.h, which the compiler turns into vectors.
 * Elements whose orientation rounding could hide, or whose size could over- or underflow, are not
 * certain. measure_block.c evaluates these one by one, scaled and with the exact sign.
 *
 * Corners of elements of every type (geometry/corner.h) come in blocks of their own.
 *
 *   pl_block_gather, _evaluate, _resolve      fill a block
 *   pl_block_acuteness                        read a block
 *   pl_corners_evaluate                       fill a block of corners
 *   pl_corner_edges, _edge_ratio_square       read it
 *   pl_cells_visit                            go through cells by such blocks
 */
#ifndef PL_QUALITY_MEASURE_BLOCK_H
#define PL_QUALITY_MEASURE_BLOCK_H

#include "geometry/angle.h"
#include "geometry/corner.h"
#include "geometry/simplex.h"
#include "quality/view.h"

#include <stdint.h>

enum { PL_SUM_LANES = 8 }; /* accumulators of a chunk: part of what fixes the bits of a sum */

/* |D| above this multiple of |e_1|_1 |e_2|_1 .. is certain to have the right sign: Shewchuk's bound
 * (certificate.c) with 8 for 7 and 4 for 3, which pays for the rounding of the product itself. */
static const double PL_ERROR_2D = 4 * 0x1p-53;
static const double PL_ERROR_3D = 8 * 0x1p-53;

/* Range where no intermediate result over- or underflows: with the norms below LARGEST_NORM, N S^2
 * is below 2^980 and a product of three squared edges below 2^490; with the norms' product above
 * SMALLEST_PRODUCT and |D| above 2^-51 of it, D^4 is above 2^-930, and so is N S^2 because RR >= 1;
 * squared edges are above 2^-790, as D is at most the product of an edge and the norms of two. */
static const double PL_LARGEST_NORM = 0x1p80;
static const double PL_SMALLEST_PRODUCT = 0x1p-180;

/** The measures of an element besides its volume, in the order of planish_quality's spreads. */
enum {
    PL_MEASURE_RADIUS_RATIO,
    PL_MEASURE_CIRCUMRADIUS_TO_EDGE,
    PL_MEASURE_EDGE_TO_INRADIUS,
    PL_MEASURE_EDGE_RATIO,
    PL_MEASURE_MEAN_RATIO,
    PL_MEASURE_SCALED_JACOBIAN,
    PL_N_RATIOS,
    PL_MEASURE_SMALLEST_ANGLE = PL_N_RATIOS,
    PL_MEASURE_LARGEST_ANGLE,
    PL_N_MEASURES
};

/** A mesh and where its nodes are. */
typedef struct pl_mesh_state {
    const pl_view *of;
    const double *coordinates; /* [n][dim] */
} pl_mesh_state;

/** Block of PL_SUM_LANES elements, one per lane; lanes past the last element, and those of elements
 * that another process counts, are not present. */
typedef struct pl_block {
    double x[4][3][PL_SUM_LANES];    /* [dim + 1][dim] the vertices' coordinates */
    double sign[PL_SUM_LANES];       /* of the elements' orientation */
    double is_movable[PL_SUM_LANES]; /* 1: has a movable node */
    double present[PL_SUM_LANES];    /* 1, or 0 past the last element */
    double certain[PL_SUM_LANES];    /* 1: what follows is right as it is */
    double valid[PL_SUM_LANES];      /* 1: positive measure */
    double square[PL_SUM_LANES];     /* RR^2; the rest is for pl_measure only */
    double listed[PL_SUM_LANES]; /* +1, 0, -1: sign of the measure in the listed order of the nodes;
                                0 if not present */
    double volume[PL_SUM_LANES]; /* signed measure in the mesh's orientation */
    double measure[PL_N_MEASURES][PL_SUM_LANES]; /* angles in radians */
} pl_block;

/** Larger of a and b; b if either is NaN. */
static inline double pl_larger(double a, double b) {
    return a > b ? a : b;
}

/** Smaller of a and b; b if either is NaN. */
static inline double pl_smaller(double a, double b) {
    return a < b ? a : b;
}

/** Sign of value: +1, 0 or -1. */
static inline double pl_sign_of(double value) {
    return value > 0 ? 1 : value < 0 ? -1 : 0;
}

/** Gather elements first .. first + count - 1; the other lanes repeat the first. Not inlined: with
 *  it in one function, clang makes no vectors of the rest. */
void pl_block_gather(const pl_mesh_state *mesh, int64_t first, int count, pl_block *b);

/** Product of the edges' sums of absolute components, an upper bound of D's permanent; infinite
 *  where the plain formulas could over- or underflow. */
PL_INLINE double pl_permanent_bound(const int dim, const double edges[3][3]) {
    double product = 1, longest = 0;
    for (int j = 0; j < dim; j++) {
        double norm = fabs(edges[j][0]) + fabs(edges[j][1]);
        norm = dim == 3 ? norm + fabs(edges[j][2]) : norm;
        product *= norm;
        longest = pl_larger(longest, norm);
    }
    product = longest < PL_LARGEST_NORM ? product : INFINITY;
    return product > PL_SMALLEST_PRODUCT ? product : INFINITY;
}

/** Radius ratio and angles of lane l. */
PL_INLINE void pl_block_put_shape(pl_block *b, int l, const pl_shape *shape, const int dim) {
    b->measure[PL_MEASURE_RADIUS_RATIO][l] = pl_radius_ratio_of_shape(dim, shape);
    b->measure[PL_MEASURE_SMALLEST_ANGLE][l] = pl_smallest_angle(shape);
    b->measure[PL_MEASURE_LARGEST_ANGLE][l] = pl_largest_angle(shape);
}

/** Evaluate all lanes; full: what pl_measure wants as well. */
PL_INLINE void pl_block_evaluate(pl_block *b, const int dim, const int full) {
    for (int l = 0; l < PL_SUM_LANES; l++) {
        double edges[3][3];
        for (int j = 0; j < dim; j++)
            for (int d = 0; d < dim; d++)
                edges[j][d] = b->x[j + 1][d][l] - b->x[0][d][l];
        pl_shape shape = pl_shape_of_edges(dim, edges);
        double error = (dim == 3 ? PL_ERROR_3D : PL_ERROR_2D) * pl_permanent_bound(dim, edges);
        double oriented = b->sign[l] * shape.determinant;
        b->certain[l] = fabs(oriented) > error ? 1 : 0;
        b->valid[l] = oriented > 0 ? b->present[l] : 0;
        b->square[l] = pl_radius_ratio_square_of_shape(dim, &shape);
        if (full) {
            double x[4][3];
            for (int j = 0; j <= dim; j++)
                for (int d = 0; d < dim; d++)
                    x[j][d] = b->x[j][d][l];
            pl_edge_squares squares = pl_edge_squares_of(dim, x);
            double determinant = fabs(shape.determinant), longest = sqrt(squares.longest);
            b->volume[l] = oriented / (dim == 3 ? 6 : 2);
            b->listed[l] = pl_sign_of(shape.determinant) * b->present[l];
            pl_block_put_shape(b, l, &shape, dim);
            b->measure[PL_MEASURE_CIRCUMRADIUS_TO_EDGE][l] =
                pl_circumradius_to_edge(dim, &shape, longest);
            b->measure[PL_MEASURE_EDGE_TO_INRADIUS][l] = pl_edge_to_inradius(dim, &shape, longest);
            b->measure[PL_MEASURE_EDGE_RATIO][l] = sqrt(squares.longest / squares.shortest);
            b->measure[PL_MEASURE_MEAN_RATIO][l] = pl_mean_ratio_of(dim, determinant, squares.sum);
            b->measure[PL_MEASURE_SCALED_JACOBIAN][l] =
                pl_scaled_jacobian_of(dim, determinant, squares.corner);
        }
    }
}

/** Evaluate the uncertain ones of elements first .. first + count - 1 anew. */
void pl_block_resolve(const pl_mesh_state *mesh, int64_t first, int count, pl_block *b);

/** Acuteness of the smallest angle of lane l, of a valid element. */
double pl_block_acuteness(const pl_block *b, int l, int dim);

/* ---- corners --------------------------------------------------------------------------------- */

/** Block of PL_SUM_LANES corners of a mesh whose elements are corners. */
typedef struct pl_corner_block {
    pl_block of;                    /* places; then certain, valid, listed, volume: that of an
                                       element with such corners; square: mu^2 */
    double weight[6][PL_SUM_LANES]; /* of the edges to the neighbours, and of those between them; or
                                       v of the targets */
    double determinant[PL_SUM_LANES]; /* of the ideal corner */
    double target_unit[PL_SUM_LANES]; /* of the target, in the scale of the lane */
    double metric[6][PL_SUM_LANES];   /* with a metric, its L */
    double size_weight;               /* with targets, as of the view */
    double unit[PL_SUM_LANES];        /* volume of an element whose corners have D = 1 */
    double is_simplex[PL_SUM_LANES];  /* 1: all its vertices are corners */
    double edge[6][PL_SUM_LANES];     /* squares of the edges, each lane in a scale of its own */
    double acuteness[PL_SUM_LANES];   /* 1 / SJ^2, SJ the scaled Jacobian */
} pl_corner_block;

/** Gather and evaluate corners first .. first + count - 1 of a mesh with corners, the uncertain ones
 *  exactly. form [PL_N_FORMS]: of its dimension. Values but volumes are the same bits at every scale
 *  that is a power of two. */
void pl_corners_evaluate(const pl_mesh_state *mesh, const pl_corner_form *form, int64_t first,
                         int count, pl_corner_block *b);

/** Extremes of the real edges of a corner of that code in lane l, squared: the base of a pyramid has
 *  a diagonal that is none. Returns their number; real [6] is which (pl_corner_block.edge). */
int pl_corner_edges(const pl_corner_block *b, int l, int dim, uint8_t code, int real[6],
                    double *shortest, double *longest);

/** Square of the smoothed ratio of these edges (pl_smoothed_edge_ratio). */
double pl_corner_edge_ratio_square(const pl_corner_block *b, int l, int dim, uint8_t code);

/** Take corner index, in lane l of b. */
typedef void pl_take_corner_fn(void *user, const pl_corner_block *b, int l, int64_t index);

/** End a cell, whose n corners, from first on, have been taken. */
typedef void pl_end_cell_fn(void *user, int64_t cell, int64_t first, int n);

/** Take the corners of cells begin .. end - 1, in their order. */
PL_INLINE void pl_cells_visit(const pl_mesh_state *mesh, const pl_corner_form *form, int64_t begin,
                              int64_t end, pl_take_corner_fn *take, pl_end_cell_fn *end_cell,
                              void *user) {
    const int32_t *first_of = mesh->of->cell_begin;
    const int64_t last = first_of[end];
    pl_corner_block b;
    for (int64_t first = first_of[begin]; first < last; first += PL_SUM_LANES) {
        const int count = last - first < PL_SUM_LANES ? (int)(last - first) : PL_SUM_LANES;
        pl_corners_evaluate(mesh, form, first, count, &b);
        for (int l = 0; l < count; l++) {
            take(user, &b, l, first + l);
            if (first + l + 1 < first_of[begin + 1])
                continue;
            end_cell(user, begin, first_of[begin], first_of[begin + 1] - first_of[begin]);
            begin++;
        }
    }
}

#endif
