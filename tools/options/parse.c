/* parse: a command line of one of the commands, by the table of options. */
#include "options/parse.h"

#include "options/combinations.h"
#include "options/commands.h"
#include "options/table.h"
#include "terminal/message.h"
#include "terminal/text.h"

#include "base/nearer.h"

#include <getopt.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/** Code that getopt_long returns for row i: its letter, or a number beyond all characters. */
static int option_code(int i) {
    return pl_option_at(i)->letter ? pl_option_at(i)->letter : UCHAR_MAX + 1 + i;
}

/** The rows of command in getopt's terms: letters [3 * PL_MOST_OPTIONS + 2], rows [PL_MOST_OPTIONS + 1]. */
static void make_getopt_table(pl_command command, char *letters, struct option *rows) {
    *letters++ = ':'; /* tells a missing value from an unknown option */
    for (int i = 0; pl_option_at(i); i++) {
        const pl_option *row = pl_option_at(i);
        if (!(row->commands & command))
            continue;
        *rows++ = (struct option){row->name, row->value ? required_argument : no_argument, NULL,
                                  option_code(i)};
        if (row->letter) {
            *letters++ = (char)row->letter;
            if (row->value)
                *letters++ = ':';
        }
    }
    *letters = '\0';
    *rows = (struct option){NULL, 0, NULL, 0};
}

static const pl_option *find_row(pl_command command, int code) {
    for (int i = 0; pl_option_at(i); i++)
        if (option_code(i) == code && (pl_option_at(i)->commands & command))
            return pl_option_at(i);
    return NULL;
}

/** Write the options of command that begin with typed, "--a, --b or --c". */
static void list_longer(pl_command command, const char *typed, char *text, size_t size) {
    const pl_option *longer[PL_MOST_OPTIONS];
    size_t used = 0;
    int n = 0;
    for (int i = 0; typed[0] && pl_option_at(i); i++)
        if ((pl_option_at(i)->commands & command) &&
            strncmp(pl_option_at(i)->name, typed, strlen(typed)) == 0)
            longer[n++] = pl_option_at(i);
    text[0] = '\0';
    for (int i = 0; i < n && used < size; i++)
        used += (size_t)snprintf(text + used, size - used, "%s--%s",
                                 i == 0       ? ""
                                 : i == n - 1 ? " or "
                                              : ", ",
                                 longer[i]->name);
}

/** Message for an option --word (which may have "=VALUE" behind it) that is none of command's. The beginning
 *  of a name is none: what it stands for would depend on the command, and change with new options. */
static int complain_unknown(pl_command command, const char *name, const char *word) {
    char typed[64], longer[256];
    snprintf(typed, sizeof typed, "%.*s", (int)strcspn(word, "="), word);
    const char *nearest = NULL;
    const pl_option *elsewhere = NULL;
    for (int i = 0; pl_option_at(i); i++) {
        const pl_option *row = pl_option_at(i);
        if (row->commands & command)
            nearest = pl_nearer(typed, nearest, row->name);
        else if (strcmp(row->name, typed) == 0)
            elsewhere = row;
    }
    list_longer(command, typed, longer, sizeof longer);
    if (elsewhere)
        return pl_complain_usage(name, "planish %s has no option --%s", name, typed);
    if (longer[0])
        return pl_complain_usage(name, "unknown option '--%s'; did you mean %s?", typed, longer);
    if (nearest)
        return pl_complain_usage(name, "unknown option '--%s'; did you mean --%s?", typed, nearest);
    return pl_complain_usage(name, "unknown option '--%s'", typed);
}

/** Whether a word is --name, which may have "=VALUE" behind it. */
static int is_whole(const char *word, const char *name) {
    const size_t n = strlen(name);
    return strncmp(word, "--", 2) == 0 && strncmp(word + 2, name, n) == 0 &&
           (word[2 + n] == '\0' || word[2 + n] == '=');
}

/** Message for a value that a setter has refused, as it must be wanted; "": one of the row's words.
 */
static int complain_value(const char *name, const pl_option *row, const char *value,
                          const char *wanted) {
    char list[256] = "must be ";
    size_t used = strlen(list);
    for (const char *word = row->values; !wanted[0] && *word && used < sizeof list;) {
        const size_t n = strcspn(word, " "), next = n + strspn(word + n, " ");
        const char *joint = !word[next] ? "" : strchr(word + next, ' ') ? ", " : " or ";
        used += (size_t)snprintf(list + used, sizeof list - used, "%.*s%s", (int)n, word, joint);
        word += next;
    }
    return pl_complain_usage(name, "--%s '%s' %s", row->name, value, wanted[0] ? wanted : list);
}

/** Message for what getopt refused; word: the argument it was looking at. */
static int complain_option(pl_command command, const char *name, int refusal, int code,
                           const char *word) {
    const pl_option *row = find_row(command, code);
    if (row && strncmp(word, "--", 2) == 0 && !is_whole(word, row->name))
        return complain_unknown(command, name, word + 2);
    if (refusal == ':' && row)
        return pl_complain_usage(name, "option --%s needs a value (%s)", row->name, row->value);
    if (row)
        return pl_complain_usage(name, "option --%s takes no value", row->name);
    if (code)
        return pl_complain_usage(name, "unknown option '-%c'", code);
    return complain_unknown(command, name, word + strspn(word, "-"));
}

/** Whether the command line may name several meshes to read. */
static int takes_many(const pl_arguments *arguments, const pl_command_text *command) {
    return command->takes_many || arguments->in_place || arguments->output_dir;
}

/** Message for operands that are too many: the second one, and the third or NULL. */
static int complain_of_many(const pl_arguments *arguments, const pl_command_text *command,
                            const char *second, const char *third) {
    if (command->takes_output && !arguments->output && !second[0])
        return pl_complain_usage(command->name, "the name of the %s file is empty",
                                 arguments->command == PL_COMMAND_COMPARE ? "second mesh"
                                                                          : "output");
    if (arguments->command == PL_COMMAND_SMOOTH && !arguments->output)
        return pl_complain_usage(command->name,
                                 "unexpected argument '%s': to smooth several meshes, give "
                                 "--output-dir DIR or --in-place",
                                 second);
    if (command->takes_output && !arguments->output)
        return pl_complain_usage(command->name, "unexpected argument '%s': give %s", third,
                                 arguments->command == PL_COMMAND_COMPARE ? "BEFORE and AFTER"
                                                                          : "IN and OUT");
    return pl_complain_usage(command->name, "unexpected argument '%s': give one %s", second,
                             command->operand);
}

/** Take the operands that stand at argv[optind ...] and check that all is there. */
static int take_operands(pl_arguments *arguments, int argc, char **argv) {
    const pl_command_text *command = pl_command_row(arguments->command);
    const int n = argc - optind, has_place = arguments->output || takes_many(arguments, command);
    if (n == 0)
        return pl_complain_usage(command->name, "no %s is named", command->operand);
    if (n == 2 && !has_place && command->takes_output && argv[argc - 1][0]) {
        arguments->output = argv[--argc];
        arguments->output_is_operand = 1;
    } else if (n > 1 && !takes_many(arguments, command)) {
        return complain_of_many(arguments, command, argv[optind + 1],
                                n > 2 ? argv[optind + 2] : NULL);
    }
    for (int i = optind; i < argc; i++) {
        if (argv[i][0] == '\0')
            return pl_complain_usage(command->name, "the name of the %s is empty",
                                     command->operand);
        arguments->inputs[arguments->n_inputs++] = argv[i];
    }
    arguments->input = arguments->inputs[0];
    if (!arguments->output && arguments->command == PL_COMMAND_CONVERT)
        return pl_complain_usage(command->name, "no output file is named: give IN and OUT");
    if (!arguments->output && arguments->command == PL_COMMAND_COMPARE)
        return pl_complain_usage(command->name,
                                 "no second mesh file is named: give BEFORE and AFTER");
    return 0;
}

/** Room for as many tags as there are words. */
static int make_room(pl_arguments *arguments, int argc) {
    const size_t n = (size_t)argc;
    arguments->inputs = calloc(n, sizeof *arguments->inputs);
    arguments->fix = calloc(n, sizeof *arguments->fix);
    arguments->slide_tag = calloc(n, sizeof *arguments->slide_tag);
    arguments->regions = calloc(n, sizeof *arguments->regions);
    arguments->min_volume_tag = calloc(n, sizeof *arguments->min_volume_tag);
    arguments->min_volume_value = calloc(n, sizeof *arguments->min_volume_value);
    if (arguments->inputs && arguments->fix && arguments->slide_tag && arguments->regions &&
        arguments->min_volume_tag && arguments->min_volume_value)
        return 0;
    return pl_complain(PL_EXIT_FAILED, "out of memory for the command line");
}

/* A size weight that no option gives; and what it is with sizes. */
#define NOT_GIVEN       (-1.0)
#define WEIGHT_OF_SIZES 0.9

/** Choose the size weight where no option gives it. */
static void take_size_weight(pl_arguments *arguments) {
    double *weight = &arguments->library.size_weight;
    if (*weight < 0)
        *weight = pl_arguments_have_sizes(arguments) ? WEIGHT_OF_SIZES : 0;
}

enum { NO_NAME = -1 }; /* getopt has read a letter */

int pl_arguments_parse(pl_arguments *arguments, pl_command command, int argc, char **argv) {
    memset(arguments, 0, sizeof *arguments);
    arguments->command = arguments->typed = command;
    planish_options_init(&arguments->library);
    arguments->library.size_weight = NOT_GIVEN;
    int status = make_room(arguments, argc);
    if (status)
        return status;

    char letters[3 * PL_MOST_OPTIONS + 2];
    struct option rows[PL_MOST_OPTIONS + 1];
    make_getopt_table(command, letters, rows);
    opterr = 0;
    optind = 1;
    int code, at = NO_NAME;
    for (; (code = getopt_long(argc, argv, letters, rows, &at)) != -1; at = NO_NAME) {
        if (code == '?' || code == ':')
            return complain_option(command, argv[0], code, optopt, argv[optind - 1]);
        const pl_option *row = find_row(command, code);
        const char *word = argv[optind - (argv[optind - 1] == optarg ? 2 : 1)];
        if (at != NO_NAME && !is_whole(word, row->name))
            return complain_unknown(command, argv[0], word + 2);
        const char *wanted = row->set(arguments, row, optarg);
        if (wanted)
            return complain_value(argv[0], row, optarg, wanted);
        if (row->commands & PL_OPTION_OF_WORST)
            arguments->of_worst = row->name;
        if (row->commands & PL_OPTION_OF_CURVED)
            arguments->of_curved = row->name;
        if (row->commands & PL_OPTION_OPTIMISES)
            arguments->optimiser = row->name;
        if (arguments->help || arguments->version)
            return 0;
    }
    take_size_weight(arguments);
    status = take_operands(arguments, argc, argv);
    if (!status)
        status = pl_arguments_check(arguments);
    if (arguments->fix_layers)
        arguments->layers = PL_LAYERS_HELD;
    if (arguments->worst)
        arguments->library.worst = arguments->worst_measure != PLANISH_WORST_NONE
                                       ? arguments->worst_measure
                                       : PLANISH_WORST_ANGLE;
    return status;
}

void pl_arguments_free(pl_arguments *arguments) {
    for (int i = 0; i < arguments->n_min_volumes; i++)
        free(arguments->min_volume_tag[i]);
    free(arguments->min_volume_tag);
    free(arguments->min_volume_value);
    free(arguments->regions);
    free(arguments->slide_tag);
    free(arguments->fix);
    free(arguments->inputs);
}
