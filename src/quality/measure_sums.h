/* measure_sums: sums of measures over the elements of a chunk, and of the mesh.
 *
 * The sums of RR^2 are rounded once (base/sum.h). Every other sum has one accumulator per lane
 * within a chunk; then the lanes are added in their order, and the chunks in theirs.
 *
 *   pl_add_basic, pl_add_full                       add a block
 *   pl_merge_basic, pl_clear_full, _reduce_full     begin and end a chunk
 *   pl_no_sums, pl_add_sums                         add up the chunks
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

/** Quantities of which pl_measure wants the sum, and the smallest and the largest value: the
 *  measures of a block, over the valid elements (angles in radians), and the volume, over all. */
enum { PL_VOLUME = PL_N_MEASURES, PL_N_QUANTITIES };

/** Counts of elements. */
enum {
    PL_UNMOVABLE,                                       /* without a free node, valid or not */
    PL_POSITIVE,                                        /* in the listed order of their nodes, */
    PL_NEGATIVE,                                        /* likewise */
    PL_AT_LEAST,                                        /* of RR >= each edge of the histogram */
    PL_BY_ANGLE = PL_AT_LEAST + PLANISH_HISTOGRAM_BINS, /* by the smallest angle */
    PL_N_COUNTS = PL_BY_ANGLE + PLANISH_ANGLE_BINS
};

/** Further accumulators of pl_measure. */
typedef struct pl_full_lanes {
    double count[PL_N_COUNTS][PL_SUM_LANES];
    double sum[PL_N_QUANTITIES][PL_SUM_LANES];
    double min[PL_N_QUANTITIES][PL_SUM_LANES];
    double max[PL_N_QUANTITIES][PL_SUM_LANES];
    double worst_ratio[PL_SUM_LANES], worst_fixed_ratio[PL_SUM_LANES];
    double movable_ratio[PL_SUM_LANES]; /* largest with a free node, */
    double movable_angle[PL_SUM_LANES]; /* and smallest */
    double worst_element[PL_SUM_LANES]; /* exact: element numbers are below 2^53 */
} pl_full_lanes;

/** Sums of a chunk, or of the mesh, besides pl_ratio_sums. */
typedef struct pl_full_sums {
    int64_t count[PL_N_COUNTS];
    double sum[PL_N_QUANTITIES], min[PL_N_QUANTITIES], max[PL_N_QUANTITIES];
    double worst_ratio, worst_fixed_ratio, movable_ratio, movable_angle; /* as those of the lanes */
    int64_t worst_element;                                               /* -1: none */
} pl_full_sums;

/** Add the elements of a block to the sums of both passes, and RR^2 of the valid ones to movable or
 *  fixed. */
PL_INLINE void pl_add_basic(const pl_block *b, pl_basic_lanes *sums, pl_sum *movable,
                            pl_sum *fixed) {
    for (int l = 0; l < PL_SUM_LANES; l++) {
        double square = b->valid[l] != 0 ? b->square[l] : 0;
        sums->max[l] = pl_larger(b->is_movable[l] != 0 ? square : 0, sums->max[l]);
        sums->n_movable[l] += b->is_movable[l] != 0 ? b->valid[l] : 0;
        sums->n_fixed[l] += b->is_movable[l] != 0 ? 0 : b->valid[l];
        sums->inverted[l] += b->present[l] - b->valid[l];
    }
    for (int l = 0; l < PL_SUM_LANES; l++)
        if (b->valid[l] != 0)
            pl_sum_add(b->is_movable[l] != 0 ? movable : fixed, b->square[l]);
}

/** Add the elements of a block, from first on, to the further sums of pl_measure. */
PL_INLINE void pl_add_full(const pl_block *b, int64_t first, pl_full_lanes *sums) {
    static const double BINS_PER_RADIAN = 11.4591559026164641754; /* 36 / pi */
    static const double LAST = PLANISH_ANGLE_BINS - 1;
    const double *ratios = b->measure[PL_MEASURE_RADIUS_RATIO],
                 *angles = b->measure[PL_MEASURE_SMALLEST_ANGLE];
    for (int l = 0; l < PL_SUM_LANES; l++) { /* the volumes, of elements that are valid or not */
        double present = b->present[l];
        double low = present != 0 ? b->volume[l] : INFINITY;
        double high = present != 0 ? b->volume[l] : -INFINITY;
        sums->count[PL_UNMOVABLE][l] += b->is_movable[l] != 0 ? 0 : present;
        sums->count[PL_POSITIVE][l] += b->listed[l] > 0 ? 1 : 0;
        sums->count[PL_NEGATIVE][l] += b->listed[l] < 0 ? 1 : 0;
        sums->sum[PL_VOLUME][l] += present != 0 ? b->volume[l] : 0;
        sums->min[PL_VOLUME][l] = pl_smaller(low, sums->min[PL_VOLUME][l]);
        sums->max[PL_VOLUME][l] = pl_larger(high, sums->max[PL_VOLUME][l]);
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
        double fixed_ratio = b->is_movable[l] != 0 ? 0 : ratio;
        double element = (double)(first + l);
        int is_worst = ratio > sums->worst_ratio[l];
        sums->worst_element[l] = is_worst ? element : sums->worst_element[l];
        sums->worst_ratio[l] = is_worst ? ratio : sums->worst_ratio[l];
        sums->worst_fixed_ratio[l] = pl_larger(fixed_ratio, sums->worst_fixed_ratio[l]);
        const int counts = b->valid[l] != 0 && b->is_movable[l] != 0;
        sums->movable_ratio[l] = pl_larger(counts ? ratio : 0, sums->movable_ratio[l]);
        sums->movable_angle[l] = pl_smaller(counts ? angles[l] : INFINITY, sums->movable_angle[l]);
    }
    for (int i = 1; i < PLANISH_HISTOGRAM_BINS; i++)
        for (int l = 0; l < PL_SUM_LANES; l++)
            sums->count[PL_AT_LEAST + i][l] += ratios[l] >= PL_HISTOGRAM_EDGES[i] ? b->valid[l] : 0;
    int bin[PL_SUM_LANES]; /* adding to one is less work than comparing with all edges */
    for (int l = 0; l < PL_SUM_LANES; l++) {
        const double place = angles[l] * BINS_PER_RADIAN + PL_ANGLE_BIN_ROUNDING;
        bin[l] = (int)pl_smaller(b->valid[l] != 0 ? place : 0, LAST);
    }
    for (int l = 0; l < PL_SUM_LANES; l++)
        sums->count[PL_BY_ANGLE + bin[l]][l] += b->valid[l];
}

/** Add the lanes of a chunk to the sums that all chunks share. */
void pl_merge_basic(const pl_basic_lanes *lanes, pl_ratio_sums *shared);

/** Set the accumulators to their values without any element. */
void pl_clear_full(pl_full_lanes *lanes);

/** Add up the lanes of pl_measure, in their order. */
void pl_reduce_full(const pl_full_lanes *lanes, pl_full_sums *sums);

/** Sums without any element. */
pl_full_sums pl_no_sums(void);

/** Add the sums of a part to sums. */
void pl_add_sums(const pl_full_sums *part, pl_full_sums *sums);

#endif
