/* combinations: options that together have a meaning, or exclude each other. */
#ifndef PL_TOOLS_COMBINATIONS_H
#define PL_TOOLS_COMBINATIONS_H

#include "options/options.h"

/** Whether some elements have a minimum volume. */
int pl_arguments_bound_volumes(const pl_arguments *arguments);

/** Whether an option asks for sizes. */
int pl_arguments_have_sizes(const pl_arguments *arguments);

/** Return the option that says what elements are to become like, or NULL: there is none. */
const char *pl_arguments_target(const pl_arguments *arguments);

/** Check options that exclude or need one another; 0, or an exit status after a message. */
int pl_arguments_check(const pl_arguments *arguments);

#endif
