/* help: what --help says of the program and of its commands. */
#ifndef PL_TOOLS_HELP_H
#define PL_TOOLS_HELP_H

#include "options/commands.h"

/** Print the help of the program, or of a command, on standard output. */
void pl_help_print(void);
void pl_help_print_command(const pl_command_text *command);

#endif
