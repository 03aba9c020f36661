/* planish_options: the version, features, and default options. */
#include <planish/planish.h>

#include <math.h>
#include <string.h>

#define DEFAULT_TOLERANCE     1e-5 /* relative fall of the RMS per sweep that is not worth a sweep */
#define DEFAULT_WORST_RISE    0.01
#define DEFAULT_CURVE_QUALITY 0.3
enum { DEFAULT_MAX_SWEEPS = 200 };

const char *planish_version(void) {
    return PLANISH_VERSION;
}

int planish_has_feature(planish_feature feature) {
    int has = 0;
    (void)feature;
#ifdef _OPENMP
    has |= feature == PLANISH_FEATURE_OPENMP;
#endif
#ifdef PL_HWLOC
    has |= feature == PLANISH_FEATURE_HWLOC;
#endif
#ifdef PL_X86_KERNELS
    has |= feature == PLANISH_FEATURE_X86_KERNELS;
#endif
    return has;
}

void planish_options_init_sized(planish_options *options, size_t size) {
    const planish_options defaults = {.struct_size = size,
                                      .max_sweeps = DEFAULT_MAX_SWEEPS,
                                      .tolerance = DEFAULT_TOLERANCE,
                                      .untangle = 1,
                                      .worst_rise = DEFAULT_WORST_RISE,
                                      .curve_quality = DEFAULT_CURVE_QUALITY,
                                      .box_lower = {-INFINITY, -INFINITY, -INFINITY},
                                      .box_upper = {INFINITY, INFINITY, INFINITY}};
    if (!options)
        return;
    memset(options, 0, size); /* what a later header has beyond this one */
    memcpy(options, &defaults, size < sizeof defaults ? size : sizeof defaults);
}
