/* main: the program planish; finds the command and hands over. */
#include "commands/commands.h"
#include "options/parse.h"
#include "options/commands.h"
#include "options/help.h"
#include "terminal/message.h"
#include "terminal/platform.h"
#include "terminal/signals.h"
#include "terminal/text.h"

#include "base/nearer.h"
#include "base/system.h"

#include <stdio.h>
#include <string.h>

static const char *with(planish_feature feature) {
    return planish_has_feature(feature) ? "with" : "without";
}

static int print_version(void) {
    printf("planish %s\nSmooths meshes of solids, of plane elements and of surfaces.\nBSD 3-clause "
           "licence; there "
           "is no warranty.\nBuilt %s OpenMP, %s hwloc, %s kernels for AVX2 and AVX-512.\n",
           planish_version(), with(PLANISH_FEATURE_OPENMP), with(PLANISH_FEATURE_HWLOC),
           with(PLANISH_FEATURE_X86_KERNELS));
    return pl_flush_stdout(PL_EXIT_DONE, PL_EXIT_FAILED);
}

/** Message for a word that names no command. */
static int complain_command(const char *word) {
    char names[128];
    const char *nearest = NULL;
    const pl_command_text *command;
    pl_command_list(", ", " or ", names, sizeof names);
    if (word[0] == '-')
        return pl_complain_usage(NULL, "unexpected option '%s'; name a command first: %s", word,
                                 names);
    for (int i = 0; (command = pl_command_at(i)); i++)
        nearest = pl_nearer(word, nearest, command->name);
    if (nearest)
        return pl_complain_usage(NULL, "unknown command '%s'; did you mean %s?", word, nearest);
    return pl_complain_usage(NULL, "unknown command '%s'; it must be %s", word, names);
}

/** The help of command, or of the program (NULL). */
static int print_help(const pl_command_text *command) {
    if (command)
        pl_help_print_command(command);
    else
        pl_help_print();
    return pl_flush_stdout(PL_EXIT_DONE, PL_EXIT_FAILED);
}

/** `planish help [COMMAND]`. */
static int run_help(int argc, char **argv) {
    const int names_one = argc > 1 && strcmp(argv[1], "help") != 0; /* "help help" is this help */
    const pl_command_text *command = names_one ? pl_command_find(argv[1]) : NULL;
    if (argc > 2)
        return pl_complain_usage(NULL, "unexpected argument '%s': help takes one command", argv[2]);
    if (names_one && !command)
        return complain_command(argv[1]);
    return print_help(command);
}

static const struct {
    pl_command command;
    int (*run)(const pl_arguments *arguments);
} functions[] = {
    {PL_COMMAND_SMOOTH, pl_smooth_command},   {PL_COMMAND_QUALITY, pl_quality_command},
    {PL_COMMAND_COMPARE, pl_compare_command}, {PL_COMMAND_ADVISE, pl_advise_command},
    {PL_COMMAND_GROUPS, pl_groups_command},   {PL_COMMAND_CONVERT, pl_convert_command},
    {PL_COMMAND_REPORT, pl_report_command},
};

/** Run command on argv, argv[0] its name; return the exit status. */
static int run_command(const pl_command_text *command, int argc, char **argv) {
    pl_arguments arguments;
    int status = pl_arguments_parse(&arguments, command->command, argc, argv);
    const int is_work = !status && !arguments.help && !arguments.version;
    if (!status && arguments.help)
        status = print_help(command);
    else if (!status && arguments.version)
        status = print_version();
    for (size_t i = 0; i < sizeof functions / sizeof *functions && is_work; i++)
        if (functions[i].command == command->command)
            status = functions[i].run(&arguments);
    pl_arguments_free(&arguments);
    return status;
}

/** `planish IN`, the same as `planish advise IN`. */
static int advise_file(int argc, char **argv) {
    static char name[] = "advise";
    argv[0] = name;
    return run_command(pl_command_row(PL_COMMAND_ADVISE), argc, argv);
}

static int run(int argc, char **argv) {
    const char *word = argc > 1 ? argv[1] : NULL;
    char names[128];
    if (!word)
        return pl_complain_usage(NULL, "no command is named: %s",
                                 pl_command_list(", ", " or ", names, sizeof names));
    const pl_command_text *command = pl_command_find(word);
    if (command)
        return run_command(command, argc - 1, argv + 1);
    if (strcmp(word, "help") == 0)
        return run_help(argc - 1, argv + 1);
    if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0)
        return print_help(NULL);
    if (strcmp(word, "--version") == 0)
        return print_version();
    if (strcmp(word, "--generate") == 0)
        return pl_generate_command(argc == 3 ? argv[2] : "");
    if (pl_file_exists(word))
        return advise_file(argc, argv);
    if (word[0] != '-' && strpbrk(word, "./\\"))
        return pl_complain_usage(NULL, "'%s' is neither a file nor a command", word);
    return complain_command(word);
}

int main(int argc, char **argv) {
    argv = pl_platform_begin(argc, argv);
    if (!argv)
        return PL_EXIT_FAILED;
    pl_signals_install();
    return pl_signals_done(run(argc, argv));
}
