/* commands: one function and one file per command of the program, and the table of them: what each
 * is called, takes and does. Help, manual page and completion are made from it and the options'
 * table (options.c): a new command is a row here.
 */
#ifndef PL_TOOLS_COMMANDS_H
#define PL_TOOLS_COMMANDS_H

#include "engine.h"
#include "options.h"

#include <stddef.h>

/** Each does what arguments say and returns the exit status. */
int pl_smooth_command(const pl_arguments *arguments);
int pl_quality_command(const pl_arguments *arguments);
int pl_report_command(const pl_arguments *arguments);

/** pl_smooth_command, with another engine than this process. */
int pl_smooth_by(const pl_arguments *arguments, const pl_engine *engine);

/** Print what the tables say as kind: man (a manual page), bash or zsh (completion). For the
 *  installation. */
int pl_generate_command(const char *kind);

/** What the table says of a command. Texts are lines of 80 columns at most, separated by '\n'. */
typedef struct pl_command_text {
    pl_command command;
    const char *name;
    const char *operands;    /* "IN -o OUT" */
    const char *operand;     /* what an operand is */
    int takes_many;          /* more than one of them */
    const char *summary;     /* a few words */
    const char *description; /* what it does */
    const char *exit_status; /* what its exit statuses mean */
    int (*run)(const pl_arguments *arguments);
} pl_command_text;

/** Row i, 0 and up, or NULL if there is none. */
const pl_command_text *pl_command_at(int i);

/** The row of command, and that of the word for it (NULL: there is none). */
const pl_command_text *pl_command_row(pl_command command);
const pl_command_text *pl_command_find(const char *word);

/** The names of all commands with joint between them and last before the last one: "smooth, quality
 *  or report". text [size] is filled in and returned. */
const char *pl_command_list(const char *joint, const char *last, char *text, size_t size);

/** What the program is, and what it reads; lines as above. */
extern const char *const pl_program_summary;
extern const char *const pl_program_formats;

#endif
