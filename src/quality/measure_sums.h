/* measure_sums: sums of measures over the elements of a chunk, and of the mesh.
 *
 * The sums of RR^2 are rounded once (base/sum.h). Every other sum has one accumulator per lane
 * within a chunk; then the lanes are added in their order, and the chunks in theirs.
 *
 *   pl_add_basic, _full                       add a block
 *   pl_clear_full, pl_reduce_basic, _full     begin and end a chunk
 *   pl_total_full                             add up the chunks
 */
#ifndef PL_QUALITY_MEASURE_SUMS_H
#define PL_QUALITY_MEASURE_SUMS_H

#include "base/sum.h"
#include "quality/measure.h"
#include "quality/measure_block.h"

static const double PL_HISTOGRAM_EDGES[PLANISH_HISTOGRAM_BINS + 1] = {
    1, 1.25, 1.5, 2, 2.5, 3, 4, 6, 10, 30, 100, 1000, INFINITY};

static const double PL_ANGLE_BIN_DEGREES = 5;

/* Angles that many bins below an edge count as being on it: elements that are alike but for
 * rounding, as in a structured mesh, are in one bin. */
static const double PL_ANGLE_BIN_ROUNDING = 1e-9;

/** Accumulators of both passes, one column per lane. */
typedef struct pl_basic_lanes {
    double max[PL_SUM_LANES]; /* see pl_ratio_sums */
    double n_movable[PL_SUM_LANES], n_fixed[PL_SUM_LANES], inverted[PL_SUM_LANES];
} pl_basic_lanes;

/** Further accumulators of pl_measure. */
typedef struct pl_full_lanes {
    double n_unmovable[PL_SUM_LANES]; /* elements without a free node, valid or not */
    double n_positive[PL_SUM_LANES],
        n_negative[PL_SUM_LANES]; /* in the listed order of their nodes */
    double volume_sum[PL_SUM_LANES], smallest_volume[PL_SUM_LANES], largest_volume[PL_SUM_LANES];
    double sum[PL_N_MEASURES][PL_SUM_LANES]; /* of angles in radians, here and below */
    double min[PL_N_MEASURES][PL_SUM_LANES];
    double max[PL_N_MEASURES][PL_SUM_LANES];
    double worst_ratio[PL_SUM_LANES], worst_fixed_ratio[PL_SUM_LANES];
    double movable_ratio[PL_SUM_LANES]; /* largest with a free node, */
    double movable_angle[PL_SUM_LANES]; /* and smallest */
    double worst_element[PL_SUM_LANES]; /* exact: element numbers are below 2^53 */
    double at_least[PLANISH_HISTOGRAM_BINS][PL_SUM_LANES]; /* elements of RR >= each edge */
    double by_angle[PLANISH_ANGLE_BINS][PL_SUM_LANES];     /* elements by their smallest angle */
} pl_full_lanes;

/** Sums of a chunk, or of the mesh, besides pl_ratio_sums. */
typedef struct pl_full_sums {
    int64_t n_unmovable;
    int64_t n_positive, n_negative; /* in the listed order of their nodes */
    double volume_sum, smallest_volume, largest_volume;
    double sum[PL_N_MEASURES], min[PL_N_MEASURES], max[PL_N_MEASURES]; /* as those of the lanes */
    double worst_ratio, worst_fixed_ratio, movable_ratio, movable_angle;
    int64_t worst_element; /* -1: none */
    int64_t at_least[PLANISH_HISTOGRAM_BINS];
    int64_t by_angle[PLANISH_ANGLE_BINS];
} pl_full_sums;

/** Add the elements of a block to the sums of both passes, and RR^2 of the valid ones to movable or
 *  fixed. */
PL_INLINE void pl_add_basic(const pl_block *b, pl_basic_lanes *sums, pl_sum *movable,
                            pl_sum *fixed) {
    for (int l = 0; l < PL_SUM_LANES; l++) {
        double square = b->valid[l] != 0 ? b->square[l] : 0;
        sums->max[l] = pl_larger(b->is_free[l] != 0 ? square : 0, sums->max[l]);
        sums->n_movable[l] += b->is_free[l] != 0 ? b->valid[l] : 0;
        sums->n_fixed[l] += b->is_free[l] != 0 ? 0 : b->valid[l];
        sums->inverted[l] += b->present[l] - b->valid[l];
    }
    for (int l = 0; l < PL_SUM_LANES; l++)
        if (b->valid[l] != 0)
            pl_sum_add(b->is_free[l] != 0 ? movable : fixed, b->square[l]);
}

/** Add the elements of a block, from first on, to the further sums of pl_measure. */
PL_INLINE void pl_add_full(const pl_block *b, int64_t first, pl_full_lanes *sums) {
    static const double BINS_PER_RADIAN = 11.4591559026164641754; /* 36 / pi */
    static const double LAST = PLANISH_ANGLE_BINS - 1;
    const double *ratios = b->measure[PL_RADIUS_RATIO], *angles = b->measure[PL_SMALLEST_ANGLE];
    for (int l = 0; l < PL_SUM_LANES; l++) { /* the volumes, of elements that are valid or not */
        double present = b->present[l];
        double low = present != 0 ? b->volume[l] : INFINITY;
        double high = present != 0 ? b->volume[l] : -INFINITY;
        sums->n_unmovable[l] += b->is_free[l] != 0 ? 0 : present;
        sums->n_positive[l] += b->listed[l] > 0 ? 1 : 0;
        sums->n_negative[l] += b->listed[l] < 0 ? 1 : 0;
        sums->volume_sum[l] += present != 0 ? b->volume[l] : 0;
        sums->smallest_volume[l] = pl_smaller(low, sums->smallest_volume[l]);
        sums->largest_volume[l] = pl_larger(high, sums->largest_volume[l]);
    }
    for (int m = 0; m < PL_N_MEASURES; m++)
        for (int l = 0; l < PL_SUM_LANES; l++) {
            double low = b->valid[l] != 0 ? b->measure[m][l] : INFINITY;
            double high = b->valid[l] != 0 ? b->measure[m][l] : -INFINITY;
            sums->sum[m][l] += b->valid[l] != 0 ? b->measure[m][l] : 0;
            sums->min[m][l] = pl_smaller(low, sums->min[m][l]);
            sums->max[m][l] = pl_larger(high, sums->max[m][l]);
        }
    for (int l = 0; l < PL_SUM_LANES; l++) { /* the largest RR and its element */
        double ratio = b->valid[l] != 0 ? ratios[l] : 0;
        double fixed_ratio = b->is_free[l] != 0 ? 0 : ratio;
        double element = (double)(first + l);
        int is_worst = ratio > sums->worst_ratio[l];
        sums->worst_element[l] = is_worst ? element : sums->worst_element[l];
        sums->worst_ratio[l] = is_worst ? ratio : sums->worst_ratio[l];
        sums->worst_fixed_ratio[l] = pl_larger(fixed_ratio, sums->worst_fixed_ratio[l]);
        const int counts = b->valid[l] != 0 && b->is_free[l] != 0;
        sums->movable_ratio[l] = pl_larger(counts ? ratio : 0, sums->movable_ratio[l]);
        sums->movable_angle[l] = pl_smaller(counts ? angles[l] : INFINITY, sums->movable_angle[l]);
    }
    for (int i = 1; i < PLANISH_HISTOGRAM_BINS; i++)
        for (int l = 0; l < PL_SUM_LANES; l++)
            sums->at_least[i][l] += ratios[l] >= PL_HISTOGRAM_EDGES[i] ? b->valid[l] : 0;
    int bin[PL_SUM_LANES]; /* adding to one is less work than comparing with all edges */
    for (int l = 0; l < PL_SUM_LANES; l++) {
        const double place = angles[l] * BINS_PER_RADIAN + PL_ANGLE_BIN_ROUNDING;
        bin[l] = (int)pl_smaller(b->valid[l] != 0 ? place : 0, LAST);
    }
    for (int l = 0; l < PL_SUM_LANES; l++)
        sums->by_angle[bin[l]][l] += b->valid[l];
}

/** Set the accumulators to their values without any element. */
void pl_clear_full(pl_full_lanes *lanes);

/** Add up the lanes, in their order. */
void pl_reduce_basic(const pl_basic_lanes *lanes, pl_ratio_sums *sums);

/** Add up the lanes of pl_measure, in their order. */
void pl_reduce_full(const pl_full_lanes *lanes, pl_full_sums *sums);

/** Return the sums of pl_measure over the chunks part [n_chunks]. */
pl_full_sums pl_total_full(int64_t n_chunks, const pl_full_sums *part);

#endif
