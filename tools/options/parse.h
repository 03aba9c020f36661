/* parse: a command line of one of the commands, by the table of options. */
#ifndef PL_TOOLS_PARSE_H
#define PL_TOOLS_PARSE_H

#include "options/options.h"

/** Understand argv (argv[0] is the command's name). Returns 0, or an exit status after a message.
 *  To be released by pl_arguments_free in any case. */
int pl_arguments_parse(pl_arguments *arguments, pl_command command, int argc, char **argv);
void pl_arguments_free(pl_arguments *arguments);

#endif
