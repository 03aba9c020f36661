/* options: their ranges, and how many threads they ask for. */
#include "plan/options.h"

#include "base/parallel.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

enum { MOST_RINGS = 100 }; /* select.c numbers them by bytes */

static int check_choices(const planish_options *options, planish_error *error) {
    if (options->method < PLANISH_METHOD_PLANISH ||
        options->method > PLANISH_METHOD_LENGTH_LAPLACIAN)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "options.method %d is unknown",
                       (int)options->method);
    if (options->objective < PLANISH_RADIUS_RATIO || options->objective > PLANISH_EDGE_RATIO)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "options.objective %d is unknown",
                       (int)options->objective);
    if (options->worst < PLANISH_WORST_NONE || options->worst > PLANISH_WORST_ANGLE)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "options.worst %d is unknown",
                       (int)options->worst);
    if (options->worst != PLANISH_WORST_NONE && options->method != PLANISH_METHOD_PLANISH)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.worst is for the method PLANISH_METHOD_PLANISH alone");
    if (options->direction != PLANISH_NEWTON && options->direction != PLANISH_FLETCHER_REEVES)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "options.direction %d is unknown",
                       (int)options->direction);
    if (options->precision < PLANISH_DOUBLE || options->precision > PLANISH_ROUNDED)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "options.precision %d is unknown",
                       (int)options->precision);
    if (options->precision == PLANISH_ROUNDED && !options->round)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.precision is PLANISH_ROUNDED: give options.round");
    if (options->displacement_unit != PLANISH_UNIT_MESH &&
        options->displacement_unit != PLANISH_UNIT_EDGE)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "options.displacement_unit %d is unknown",
                       (int)options->displacement_unit);
    return PLANISH_OK;
}

static int check_volumes(const planish_options *options, planish_error *error) {
    if (!(options->min_volume >= 0) || !isfinite(options->min_volume))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.min_volume is %g; give a finite volume, or 0 for none",
                       options->min_volume);
    if (!(options->min_volume_fraction >= 0) || !(options->min_volume_fraction < 1))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.min_volume_fraction is %g; give 0 (none) or more, below 1",
                       options->min_volume_fraction);
    if (options->min_volume > 0 && options->min_volume_fraction > 0)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.min_volume and min_volume_fraction are both set; give one of them");
    if (!(options->area_weight >= 0) || !(options->area_weight <= 1))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "options.area_weight is %g; give 0 to 1",
                       options->area_weight);
    return PLANISH_OK;
}

static int check_bounds(const planish_options *options, planish_error *error) {
    for (int d = 0; d < 3; d++)
        if (!(options->box_lower[d] <= options->box_upper[d]))
            return pl_fail(
                error, PLANISH_ERROR_ARGUMENT,
                "options.box_lower[%d] is %g and box_upper[%d] is %g; give a lower bound "
                "that is not above the upper one",
                d, options->box_lower[d], d, options->box_upper[d]);
    if (!(options->max_displacement >= 0) || !isfinite(options->max_displacement))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.max_displacement is %g; give a finite length, or 0 for none",
                       options->max_displacement);
    return PLANISH_OK;
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
    int status = check_choices(options, error);
    if (!status)
        status = check_volumes(options, error);
    if (!status)
        status = check_bounds(options, error);
    if (status)
        return status;
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
    if (!(options->worst_rise >= 0) || !isfinite(options->worst_rise))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.worst_rise is %g; give a finite fraction, 0 or more",
                       options->worst_rise);
    if (options->allocator && (!options->allocator->allocate || !options->allocator->release))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.allocator lacks a function; give both, or no allocator");
    if (options->rings < 0 || options->rings > MOST_RINGS)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.rings is %d; give a number of rings, 0 to %d", options->rings,
                       MOST_RINGS);
    if (!(options->only_worse_than >= 0))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.only_worse_than is %g; give a radius ratio, or 0 for all stars",
                       options->only_worse_than);
    return PLANISH_OK;
}

/** About how many elements a plan will be for. */
static int64_t elements_for(const planish_mesh *mesh, const planish_options *options) {
    enum { OF_A_NODE = 24 };
    const double wide = options->rings + 1.0; /* its cube may be beyond 64 bits */
    const int walks = options->around_elements && (mesh->neighbours || mesh->neighbours64);
    if (!options->around || !walks || options->n_around < 1 ||
        options->n_around > mesh->n_elements / OF_A_NODE)
        return mesh->n_elements;
    const double n = (double)options->n_around * OF_A_NODE * wide * wide * wide;
    return n < (double)mesh->n_elements ? (int64_t)n : mesh->n_elements;
}

int pl_threads_for(const planish_mesh *mesh, const planish_options *options) {
    enum { ELEMENTS_PER_THREAD = 2000 };
    if (options->threads != 0)
        return options->threads;
    const int64_t enough = elements_for(mesh, options) / ELEMENTS_PER_THREAD + 1;
    return enough < pl_thread_count(0) ? (int)enough : 0;
}
