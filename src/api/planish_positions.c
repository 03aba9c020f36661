/* planish_positions: where the nodes are at the end of a sweep, for progress functions. */
#include "base/positions.h"

#include "base/status.h"

int planish_progress_get_coordinates(const planish_progress *progress, double *coordinates,
                                     planish_error *error) {
    if (!progress || !coordinates)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "progress and coordinates must not be NULL");
    const struct planish_positions *positions = progress->positions;
    if (!positions)
        return pl_fail(
            error, PLANISH_ERROR_ARGUMENT,
            "progress has no positions of nodes; ask where progress.sweep_done is not 0");
    if (coordinates == positions->given)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "coordinates are those that are smoothed; give another array");
    const pl_outside outside = pl_call_enter(positions->context);
    positions->fill(positions->from, coordinates);
    pl_call_leave(&outside);
    return PLANISH_OK;
}
