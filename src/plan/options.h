/* options: what every call checks before it works. */
#ifndef PL_PLAN_OPTIONS_H
#define PL_PLAN_OPTIONS_H

#include <planish/planish.h>

/** Check struct_size and the ranges of all fields. */
int pl_options_check(const planish_options *options, planish_error *error);

/** options->threads; instead of 0 fewer than OpenMP would use, if mesh is too small for these. */
int pl_threads_for(const planish_mesh *mesh, const planish_options *options);

#endif
