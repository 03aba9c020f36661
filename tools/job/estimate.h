/* estimate: what is still to come of the sweeps, from those that were done. */
#ifndef PL_TOOLS_ESTIMATE_H
#define PL_TOOLS_ESTIMATE_H

#include <planish/planish.h>

/** A sweep that was done. */
typedef struct pl_sweep {
    double rms, rms_movable, objective, seconds;
    int64_t inverted, below_min_volume, visits;
    int restoring, worst; /* as in planish_progress */
} pl_sweep;

/** How many sweeps of smoothing are still to come after sweep [n], by how their relative falls of F
 *  shrink; negative where that tells nothing: after fewer than three sweeps, while elements are
 *  repaired, and where the falls do not shrink. plain: F is the RMS, of which the movable part
 *  counts. */
double pl_estimate_sweeps(const pl_sweep *sweep, int64_t n, const planish_options *options,
                          int plain);

/** Seconds that one sweep takes, by the last ones of smoothing or of untangling; 0 without any. */
double pl_estimate_sweep_seconds(const pl_sweep *sweep, int64_t n);

#endif
