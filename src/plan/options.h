/* options: checks that every call makes before it works.
 *
 *   pl_options_check     the values of planish_options
 *   pl_threads_for       number of threads
 */
#ifndef PL_PLAN_OPTIONS_H
#define PL_PLAN_OPTIONS_H

#include <planish/planish.h>

/** Check struct_size and the ranges of all fields. */
int pl_options_check(const planish_options *options, planish_error *error);

/** options->threads; instead of 0 fewer than OpenMP would use, if mesh is too small for these. */
int pl_threads_for(const planish_mesh *mesh, const planish_options *options);

#endif
