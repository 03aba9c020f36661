/* options: their defaults and their ranges; the version. */
#include "sweep/sweep.h"

#include "base/parallel.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

#define DEFAULT_TOLERANCE 1e-5 /* relative fall of the RMS per sweep that is not worth a sweep */
enum { DEFAULT_MAX_SWEEPS = 200 };

const char *planish_version(void) {
    return PLANISH_VERSION;
}

void planish_options_init(planish_options *options) {
    memset(options, 0, sizeof *options);
    options->struct_size = sizeof *options;
    options->max_sweeps = DEFAULT_MAX_SWEEPS;
    options->tolerance = DEFAULT_TOLERANCE;
}

int pl_options_check(const planish_options *options, planish_error *error) {
    if (options->struct_size != sizeof *options)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.struct_size is %zu, not %zu: call planish_options_init first, "
                       "with the header of the library that is linked",
                       options->struct_size, sizeof *options);
    if (options->threads < 0 || options->threads > PL_MAX_THREADS)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.threads is %d; give 0 (automatic) to %d", options->threads,
                       PL_MAX_THREADS);
    if (options->direction != PLANISH_NEWTON && options->direction != PLANISH_FLETCHER_REEVES)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "options.direction %d is unknown",
                       (int)options->direction);
    if (options->precision != PLANISH_DOUBLE && options->precision != PLANISH_FLOAT)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "options.precision %d is unknown",
                       (int)options->precision);
    if (options->max_sweeps < 0)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "options.max_sweeps is %d; give 0 or more",
                       options->max_sweeps);
    if (!(options->tolerance >= 0) || !(options->tolerance < 1))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.tolerance is %g; give 0 or more, below 1", options->tolerance);
    if (!(options->time_limit >= 0))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.time_limit is %g; give seconds, or 0 for none",
                       options->time_limit);
    if (!(options->only_worse_than >= 0))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.only_worse_than is %g; give a radius ratio, or 0 for all stars",
                       options->only_worse_than);
    return PLANISH_OK;
}
