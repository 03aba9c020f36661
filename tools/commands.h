/* commands: one function and one file per command of the program. */
#ifndef PL_TOOLS_COMMANDS_H
#define PL_TOOLS_COMMANDS_H

#include "options.h"

/** Each does what arguments say and returns the exit status. */
int pl_smooth_command(const pl_arguments *arguments);
int pl_quality_command(const pl_arguments *arguments);

/** Print what the options' table says as kind: man (a manual page), bash or zsh (completion). For
 *  the installation. */
int pl_generate_command(const char *kind);

#endif
