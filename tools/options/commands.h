/* commands: the names of the program's commands, and the texts about them.
 *
 * Help, manual page and completion (help.h) are made from this table and that of the options
 * (options.c). A new command is a row here, and one in main.c.
 *
 *     pl_command_at, _row, _find, _list           the table
 */
#ifndef PL_TOOLS_OPTIONS_COMMANDS_H
#define PL_TOOLS_OPTIONS_COMMANDS_H

#include "options/options.h"

#include <stddef.h>

/** Row of the table of commands. Texts are lines of 80 columns at most, separated by '\n'. */
typedef struct pl_command_text {
    pl_command command;
    const char *name;
    const char *operands;    /* "IN -o OUT" */
    const char *operand;     /* what an operand is */
    int takes_many;          /* more than one of them */
    int takes_output;        /* OUT may stand behind it */
    const char *summary;     /* a few words */
    const char *description; /* what it does */
    const char *exit_status; /* what its exit statuses mean */
    const char *examples;    /* command lines */
} pl_command_text;

/** Row i, 0 and up, or NULL if there is none. */
const pl_command_text *pl_command_at(int i);

/** The row of command, and that of the word for it (NULL: there is none). */
const pl_command_text *pl_command_row(pl_command command);
const pl_command_text *pl_command_find(const char *word);

/** The names of all commands with joint between them and last before the last one: "smooth, quality
 *  or report". text [size] is filled in and returned. */
const char *pl_command_list(const char *joint, const char *last, char *text, size_t size);

/** Texts on the program and on the formats that it reads; lines as above. */
extern const char *const pl_program_summary;
extern const char *const pl_program_formats;

#endif
