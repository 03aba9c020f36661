/* help: help and manual, from the tables of commands and options.
 *
 *     pl_help_print, pl_help_print_command        help (help.c)
 *     pl_generate_command                         manual page and completion (manual.c)
 */
#ifndef PL_TOOLS_OPTIONS_HELP_H
#define PL_TOOLS_OPTIONS_HELP_H

#include "options/commands.h"

/** Print the help of the program, or of a command, on standard output. */
void pl_help_print(void);
void pl_help_print_command(const pl_command_text *command);

/** Print what the tables say as kind: man (a manual page), bash or zsh (completion), for the
 *  installation; formats (the table of docs/formats.md). */
int pl_generate_command(const char *kind);

#endif
