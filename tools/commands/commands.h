/* commands: one function and one file for each command of the program.
 *
 *     smooth.c     from mesh file to better mesh file
 *     promises.c   checks of a result before it is written
 *     quality.c    measures of one mesh or several
 *     compare.c    two states of a mesh
 *     advise.c     measures of a mesh, and what smoothing would win
 *     groups.c     the groups of a mesh file
 *     convert.c    a mesh in another format
 *     report.c     an HTML page from an earlier result
 *
 * Each function does what arguments ask for and returns the exit status of the program.
 */
#ifndef PL_TOOLS_COMMANDS_H
#define PL_TOOLS_COMMANDS_H

#include "job/engine.h"
#include "options/options.h"

/** Smooth arguments->input and write arguments->output. */
int pl_smooth_command(const pl_arguments *arguments);

/** Smooth as pl_smooth_command does, with another engine than this process. */
int pl_smooth_by(const pl_arguments *arguments, const pl_engine *engine);

/** Measure the inputs, and compare several. */
int pl_quality_command(const pl_arguments *arguments);

/** Compare the mesh arguments->input with that of arguments->output. */
int pl_compare_command(const pl_arguments *arguments);

/** Measure arguments->input, smooth it in memory in several ways, and tell what each would give. */
int pl_advise_command(const pl_arguments *arguments);

/** List the groups of arguments->input. */
int pl_groups_command(const pl_arguments *arguments);

/** Write arguments->input to arguments->output in another format. */
int pl_convert_command(const pl_arguments *arguments);

/** Make an HTML page from the JSON file arguments->input. */
int pl_report_command(const pl_arguments *arguments);

#endif
