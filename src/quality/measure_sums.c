/* measure_sums: lanes become chunks, and chunks the mesh, in an order that is always the same. */
#include "quality/measure_sums.h"

#include <string.h>

static pl_full_sums no_sums(void) {
    pl_full_sums none = {.smallest_volume = INFINITY,
                         .largest_volume = -INFINITY,
                         .worst_element = -1,
                         .movable_angle = INFINITY};
    for (int m = 0; m < PL_N_MEASURES; m++) {
        none.min[m] = INFINITY;
        none.max[m] = -INFINITY;
    }
    return none;
}

void pl_clear_full(pl_full_lanes *lanes) {
    const pl_full_sums none = no_sums();
    memset(lanes, 0, sizeof *lanes);
    for (int l = 0; l < PL_SUM_LANES; l++) {
        lanes->smallest_volume[l] = none.smallest_volume;
        lanes->largest_volume[l] = none.largest_volume;
        lanes->movable_angle[l] = none.movable_angle;
        for (int m = 0; m < PL_N_MEASURES; m++) {
            lanes->min[m][l] = none.min[m];
            lanes->max[m][l] = none.max[m];
        }
    }
}

void pl_reduce_basic(const pl_basic_lanes *lanes, pl_ratio_sums *sums) {
    memset(sums, 0, sizeof *sums);
    for (int l = 0; l < PL_SUM_LANES; l++) {
        sums->max = pl_larger(lanes->max[l], sums->max);
        sums->n_movable += (int64_t)lanes->n_movable[l];
        sums->n_fixed += (int64_t)lanes->n_fixed[l];
        sums->inverted += (int64_t)lanes->inverted[l];
    }
}

static void add_sums(const pl_full_sums *part, pl_full_sums *sums) {
    sums->n_unmovable += part->n_unmovable;
    sums->n_positive += part->n_positive;
    sums->n_negative += part->n_negative;
    sums->volume_sum += part->volume_sum;
    sums->smallest_volume = pl_smaller(part->smallest_volume, sums->smallest_volume);
    sums->largest_volume = pl_larger(part->largest_volume, sums->largest_volume);
    for (int m = 0; m < PL_N_MEASURES; m++) {
        sums->sum[m] += part->sum[m];
        sums->min[m] = pl_smaller(part->min[m], sums->min[m]);
        sums->max[m] = pl_larger(part->max[m], sums->max[m]);
    }
    if (part->worst_ratio > sums->worst_ratio ||
        (part->worst_ratio == sums->worst_ratio && part->worst_element < sums->worst_element))
        sums->worst_element = part->worst_element; /* the lowest element wins a tie */
    sums->worst_ratio = pl_larger(part->worst_ratio, sums->worst_ratio);
    sums->worst_fixed_ratio = pl_larger(part->worst_fixed_ratio, sums->worst_fixed_ratio);
    sums->movable_ratio = pl_larger(part->movable_ratio, sums->movable_ratio);
    sums->movable_angle = pl_smaller(part->movable_angle, sums->movable_angle);
    for (int i = 1; i < PLANISH_HISTOGRAM_BINS; i++)
        sums->at_least[i] += part->at_least[i];
    for (int i = 0; i < PLANISH_ANGLE_BINS; i++)
        sums->by_angle[i] += part->by_angle[i];
}

void pl_reduce_full(const pl_full_lanes *lanes, pl_full_sums *sums) {
    *sums = no_sums();
    for (int l = 0; l < PL_SUM_LANES; l++) {
        pl_full_sums lane = {.n_unmovable = (int64_t)lanes->n_unmovable[l],
                             .n_positive = (int64_t)lanes->n_positive[l],
                             .n_negative = (int64_t)lanes->n_negative[l],
                             .volume_sum = lanes->volume_sum[l],
                             .smallest_volume = lanes->smallest_volume[l],
                             .largest_volume = lanes->largest_volume[l],
                             .worst_ratio = lanes->worst_ratio[l],
                             .worst_fixed_ratio = lanes->worst_fixed_ratio[l],
                             .movable_ratio = lanes->movable_ratio[l],
                             .movable_angle = lanes->movable_angle[l],
                             .worst_element = (int64_t)lanes->worst_element[l]};
        for (int m = 0; m < PL_N_MEASURES; m++) {
            lane.sum[m] = lanes->sum[m][l];
            lane.min[m] = lanes->min[m][l];
            lane.max[m] = lanes->max[m][l];
        }
        for (int i = 1; i < PLANISH_HISTOGRAM_BINS; i++)
            lane.at_least[i] = (int64_t)lanes->at_least[i][l];
        for (int i = 0; i < PLANISH_ANGLE_BINS; i++)
            lane.by_angle[i] = (int64_t)lanes->by_angle[i][l];
        add_sums(&lane, sums);
    }
}

pl_full_sums pl_total_full(int64_t n_chunks, const pl_full_sums *part) {
    pl_full_sums total = no_sums();
    for (int64_t i = 0; i < n_chunks; i++)
        add_sums(&part[i], &total);
    return total;
}
