/* estimate: what is still to come of the sweeps, from those that were done.
 *
 * Sweeps end when CALM of them in a row have brought a relative fall of less than the tolerance
 * (src/sweep/convergence.c), and the falls shrink by about the same factor from sweep to sweep.
 */
#include "job/estimate.h"

#include <math.h>

enum { CALM = 3, RECENT = 3, FEWEST = 3 };

/* Falls that shrink by less than this from sweep to sweep say nothing of their end: such meshes are
 * helped from within the sweeps. */
static const double SLOWEST_SHRINKING = 0.95;

static double value_of(const pl_sweep *sweep, int plain) {
    return plain ? sweep->rms_movable : sweep->objective;
}

/** Sweeps of smoothing at the end of sweep [n]. */
static int64_t count_smoothing(const pl_sweep *sweep, int64_t n) {
    int64_t count = 0;
    while (count < n && !sweep[n - 1 - count].restoring && !sweep[n - 1 - count].worst)
        count++;
    return count;
}

/** The relative fall that the last sweep but back brought. */
static double fall_of(const pl_sweep *sweep, int64_t n, int64_t back, int plain) {
    const double before = value_of(&sweep[n - 2 - back], plain);
    return before > 0 ? (before - value_of(&sweep[n - 1 - back], plain)) / before : 0;
}

/** Sweeps until they are calm, by n_falls at the end of sweep [n]; negative: unknown. */
static double until_calm(const pl_sweep *sweep, int64_t n, int64_t n_falls, double tolerance,
                         int plain) {
    const int64_t recent = n_falls < RECENT ? n_falls : RECENT;
    const double first = fall_of(sweep, n, recent - 1, plain), last = fall_of(sweep, n, 0, plain);
    int64_t calm = 0;
    while (calm < recent && fall_of(sweep, n, calm, plain) <= tolerance)
        calm++;
    if (last <= 0) /* a trial, that repeats the value of the mesh that stands */
        return -1;
    if (calm > 0)
        return calm < CALM ? (double)(CALM - calm) : 1;
    const double shrinking = pow(last / first, 1 / (double)(recent - 1));
    if (!(tolerance > 0 && first > 0 && shrinking < SLOWEST_SHRINKING))
        return -1;
    return ceil(log(tolerance / last) / log(shrinking)) + CALM - 1;
}

double pl_estimate_sweeps(const pl_sweep *sweep, int64_t n, const planish_options *options,
                          int plain) {
    const int64_t done = count_smoothing(sweep, n);
    if (done < FEWEST)
        return -1;
    const double calm = until_calm(sweep, n, done - 1, options->tolerance, plain);
    const double most = fmax(0, (double)(options->max_sweeps - done));
    if (calm < 0 && options->tolerance == 0) /* they end by their number alone */
        return most;
    return fmin(calm, most);
}

double pl_estimate_sweep_seconds(const pl_sweep *sweep, int64_t n) {
    double sum = 0;
    const int64_t count = n < RECENT ? n : RECENT;
    for (int64_t i = n - count; i < n; i++)
        sum += sweep[i].seconds;
    return count > 0 ? sum / (double)count : 0;
}
