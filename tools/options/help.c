/* help: the help of the program and of its commands. */
#include "options/help.h"
#include "options/table.h"

#include <stdio.h>

enum { OPTION_COLUMN = 27, SUMMARY_COLUMN = 37 };

/** Lines, each but the first with column blanks before it. */
static void put_lines(const char *lines, int column) {
    for (const char *c = lines; *c; c++)
        if (*c == '\n')
            printf("\n%*s", column, "");
        else
            putchar(*c);
    putchar('\n');
}

static void put_option(const pl_option *option) {
    char left[64];
    const int has_letter = option->letter != 0;
    const int width =
        snprintf(left, sizeof left, "  %c%c%s --%s%s%s", has_letter ? '-' : ' ',
                 has_letter ? option->letter : ' ', has_letter ? "," : " ", option->name,
                 option->value ? " " : "", option->value ? option->value : "");
    printf("%-*s", OPTION_COLUMN, left);
    if (width >= OPTION_COLUMN)
        printf("\n%*s", OPTION_COLUMN, "");
    put_lines(option->help, OPTION_COLUMN);
}

static void put_summary(const char *name, const char *operands, const char *summary) {
    const int width = printf("  %s %s", name, operands);
    printf("%*s%s\n", SUMMARY_COLUMN - width, "", summary);
}

void pl_help_print(void) {
    const pl_command_text *command;
    printf("Usage: planish COMMAND ... [OPTION]...\n       planish IN (same as planish advise "
           "IN)\n%s\n\n",
           pl_program_summary);
    for (int i = 0; (command = pl_command_at(i)); i++)
        put_summary(command->name, command->operands, command->summary);
    put_summary("help", "[COMMAND]", "show this help, or the help of a command");
    put_summary("--version", "", "show the version and exit");
    printf("\nFormats:\n");
    put_lines(pl_program_formats, 0);
}

/** Put the options of a command below the titles of their sections. */
static void put_options(const pl_command_text *command) {
    const pl_option *option, *before = NULL;
    for (int i = 0; (option = pl_option_at(i)); i++) {
        if (!(option->commands & command->command))
            continue;
        if (!before || before->section != option->section)
            printf("\n%s:\n", pl_section_title(option->section));
        put_option(option);
        before = option;
    }
}

void pl_help_print_command(const pl_command_text *command) {
    printf("Usage: planish %s %s [OPTION]...\n%s\n", command->name, command->operands,
           command->description);
    put_options(command);
    printf("\nExit status:\n");
    put_lines(command->exit_status, 0);
    printf("\nExamples:\n  ");
    put_lines(command->examples, 2);
}
