/* check_options: the ranges of planish_options. */
#include "plan/plan.h"

#include "base/parallel.h"
#include "base/status.h"

#include <float.h>
#include <math.h>

enum { MOST_RINGS = 100 }; /* select.c numbers them by bytes */

/* The largest double below 1. */
#define BELOW_1 (1 - 0x1p-53)

/** Check each option by itself. */
static int check_ranges(const planish_options *o, planish_error *error) {
    const struct {
        const char *name;
        int value, last;
    } choices[] = {
        {"method", (int)o->method, PLANISH_METHOD_LENGTH_LAPLACIAN},
        {"objective", (int)o->objective, PLANISH_OBJECTIVE_EDGE_RATIO},
        {"worst", (int)o->worst, PLANISH_WORST_SCALED_JACOBIAN},
        {"search", (int)o->search, PLANISH_SEARCH_FLETCHER_REEVES},
        {"precision", (int)o->precision, PLANISH_PRECISION_ROUNDED},
        {"displacement_unit", (int)o->displacement_unit, PLANISH_UNIT_EDGE},
        {"surface_tolerance_unit", (int)o->surface_tolerance_unit, PLANISH_UNIT_EDGE},
    };
    const struct {
        const char *name;
        double value, most;
        const char *advice;
    } numbers[] = {
        {"min_volume", o->min_volume, DBL_MAX, "a finite volume, or 0 for none"},
        {"min_volume_fraction", o->min_volume_fraction, BELOW_1, "0 (none) or more, below 1"},
        {"area_weight", o->area_weight, 1, "0 to 1"},
        {"max_displacement", o->max_displacement, DBL_MAX, "a finite length, or 0 for none"},
        {"surface_tolerance", o->surface_tolerance, DBL_MAX,
         "a finite length, or 0 for 0.05 edges"},
        {"rounding", o->rounding, DBL_MAX, "a finite length, or 0 for that of doubles"},
        {"tolerance", o->tolerance, BELOW_1, "0 or more, below 1"},
        {"time_limit", o->time_limit, INFINITY, "seconds, or 0 for none"},
        {"worst_rise", o->worst_rise, DBL_MAX, "a finite fraction, 0 or more"},
        {"curve_quality", o->curve_quality, 1, "0 (none) to 1"},
        {"size_weight", o->size_weight, 1, "0 (shapes alone) to 1 (sizes alone)"},
        {"only_worse_than", o->only_worse_than, INFINITY, "a radius ratio, or 0 for all stars"},
        {"threads", o->threads, PL_MAX_THREADS, "0 (automatic) to 1024"},
        {"max_sweeps", o->max_sweeps, INFINITY, "0 or more"},
        {"rings", o->rings, MOST_RINGS, "a number of rings, 0 to 100"},
    };
    _Static_assert(PL_MAX_THREADS == 1024 && MOST_RINGS == 100, "as the texts say");
    for (size_t i = 0; i < sizeof choices / sizeof *choices; i++)
        if (choices[i].value < 0 || choices[i].value > choices[i].last)
            return pl_fail(error, PLANISH_ERROR_ARGUMENT, "options.%s %d is unknown",
                           choices[i].name, choices[i].value);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        if (!(numbers[i].value >= 0 && numbers[i].value <= numbers[i].most))
            return pl_fail(error, PLANISH_ERROR_ARGUMENT, "options.%s is %.10g; give %s",
                           numbers[i].name, numbers[i].value, numbers[i].advice);
    return PLANISH_OK;
}

int pl_options_check(const planish_options *options, planish_error *error) {
    if (options->struct_size != sizeof *options)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.struct_size is %zu, not %zu: call planish_options_init first, "
                       "with the header of the library that is linked",
                       options->struct_size, sizeof *options);
    int status =
        pl_check_reserved("planish_options", options->reserved, sizeof options->reserved, error);
    if (!status)
        status = check_ranges(options, error);
    if (status)
        return status;
    if (options->worst != PLANISH_WORST_NONE && options->method != PLANISH_METHOD_PLANISH)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.worst needs the method PLANISH_METHOD_PLANISH");
    if (options->precision == PLANISH_PRECISION_ROUNDED && !options->round)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.precision is PLANISH_PRECISION_ROUNDED: give options.round");
    if (options->min_volume > 0 && options->min_volume_fraction > 0)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.min_volume and min_volume_fraction are both set; give one of them");
    for (int d = 0; d < 3; d++)
        if (!(options->box_lower[d] <= options->box_upper[d]))
            return pl_fail(
                error, PLANISH_ERROR_ARGUMENT,
                "options.box_lower[%d] is %g and box_upper[%d] is %g; give a lower bound "
                "that is not above the upper one",
                d, options->box_lower[d], d, options->box_upper[d]);
    if (options->allocator && (!options->allocator->allocate || !options->allocator->release))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.allocator lacks a function; give both, or no allocator");
    return PLANISH_OK;
}
