/* measure_sums: lanes become chunks, and chunks the mesh, in an order that is always the same.
 *
 * In a file of its own: where compilers see that nobody else reads the lanes of a chunk, they keep
 * them one by one, and make no vectors of the sums. That takes a fifth more instructions.
 */
#include "quality/measure_sums.h"

#include "base/parallel.h"

#include <string.h>

void pl_merge_basic(const pl_basic_lanes *lanes, pl_ratio_sums *shared) {
    double max = 0, n_movable = 0, n_fixed = 0, inverted = 0;
    for (int l = 0; l < PL_SUM_LANES; l++) {
        max = pl_larger(lanes->max[l], max);
        n_movable += lanes->n_movable[l];
        n_fixed += lanes->n_fixed[l];
        inverted += lanes->inverted[l];
    }
    pl_raise_double(&shared->max, max);
    __atomic_fetch_add(&shared->n_movable, (int64_t)n_movable, __ATOMIC_RELAXED);
    __atomic_fetch_add(&shared->n_fixed, (int64_t)n_fixed, __ATOMIC_RELAXED);
    __atomic_fetch_add(&shared->inverted, (int64_t)inverted, __ATOMIC_RELAXED);
}

pl_full_sums pl_no_sums(void) {
    pl_full_sums none = {.worst_element = -1, .movable_angle = INFINITY};
    for (int k = 0; k < PL_N_QUANTITIES; k++) {
        none.min[k] = INFINITY;
        none.max[k] = -INFINITY;
    }
    return none;
}

void pl_clear_full(pl_full_lanes *lanes) {
    memset(lanes, 0, sizeof *lanes);
    for (int l = 0; l < PL_SUM_LANES; l++) {
        lanes->movable_angle[l] = INFINITY;
        for (int k = 0; k < PL_N_QUANTITIES; k++) {
            lanes->min[k][l] = INFINITY;
            lanes->max[k][l] = -INFINITY;
        }
    }
}

void pl_add_sums(const pl_full_sums *part, pl_full_sums *sums) {
    for (int i = 0; i < PL_N_COUNTS; i++)
        sums->count[i] += part->count[i];
    for (int k = 0; k < PL_N_QUANTITIES; k++) {
        sums->sum[k] += part->sum[k];
        sums->min[k] = pl_smaller(part->min[k], sums->min[k]);
        sums->max[k] = pl_larger(part->max[k], sums->max[k]);
    }
    if (part->worst_ratio > sums->worst_ratio ||
        (part->worst_ratio == sums->worst_ratio && part->worst_element < sums->worst_element))
        sums->worst_element = part->worst_element; /* the lowest element wins a tie */
    sums->worst_ratio = pl_larger(part->worst_ratio, sums->worst_ratio);
    sums->worst_fixed_ratio = pl_larger(part->worst_fixed_ratio, sums->worst_fixed_ratio);
    sums->movable_ratio = pl_larger(part->movable_ratio, sums->movable_ratio);
    sums->movable_angle = pl_smaller(part->movable_angle, sums->movable_angle);
}

void pl_reduce_full(const pl_full_lanes *lanes, pl_full_sums *sums) {
    *sums = pl_no_sums();
    for (int l = 0; l < PL_SUM_LANES; l++) {
        pl_full_sums lane = {.worst_ratio = lanes->worst_ratio[l],
                             .worst_fixed_ratio = lanes->worst_fixed_ratio[l],
                             .movable_ratio = lanes->movable_ratio[l],
                             .movable_angle = lanes->movable_angle[l],
                             .worst_element = (int64_t)lanes->worst_element[l]};
        for (int i = 0; i < PL_N_COUNTS; i++)
            lane.count[i] = (int64_t)lanes->count[i][l];
        for (int k = 0; k < PL_N_QUANTITIES; k++) {
            lane.sum[k] = lanes->sum[k][l];
            lane.min[k] = lanes->min[k][l];
            lane.max[k] = lanes->max[k][l];
        }
        pl_add_sums(&lane, sums);
    }
}
