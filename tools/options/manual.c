/* manual: the manual page and the completion of shells, from the tables of commands and options. */
#include "options/commands.h"
#include "terminal/message.h"

#include <planish/planish_io.h>

#include <stdio.h>
#include <string.h>

/* ---- man ------------------------------------------------------------------------------------ */

/** Text for troff: nothing in it is a request, a minus is one. */
static void put_troff(const char *text) {
    for (const char *c = text; *c; c++)
        if ((*c == '.' || *c == '\'') && (c == text || c[-1] == '\n'))
            printf("\\&%c", *c);
        else if (*c == '-')
            fputs("\\-", stdout);
        else if (*c == '\\')
            fputs("\\e", stdout);
        else
            putchar(*c);
}

/** "planish NAME OPERANDS [OPTION]..." */
static void put_synopsis(const pl_command_text *command) {
    printf("\\fBplanish %s\\fR \\fI", command->name);
    put_troff(command->operands);
    printf("\\fR [\\fIOPTION\\fR]...\n");
}

static void put_option(const pl_option_text *o) {
    printf(".TP\n");
    if (o->letter)
        printf("\\fB\\-%c\\fR, ", o->letter);
    printf("\\fB\\-\\-");
    put_troff(o->name);
    printf("\\fR");
    if (o->value) {
        printf(" \\fI");
        put_troff(o->value);
        printf("\\fR");
    }
    printf("\n");
    put_troff(o->help);
    printf("\n");
}

/** ".SS Options of smooth and quality", if there are any that these commands have and no others. */
static void put_options_of(unsigned commands) {
    pl_option_text option;
    const pl_command_text *command;
    int n = 0, n_names = 0;
    for (int i = 0; pl_option_describe(i, &option); i++)
        n += option.commands == commands;
    if (n == 0)
        return;
    printf(".SS \"Options of ");
    for (int i = 0; (command = pl_command_at(i)) && commands != PL_COMMANDS_ALL; i++)
        if (command->command & commands)
            printf("%s%s", n_names++ ? " and " : "", command->name);
    printf("%s\"\n", n_names ? "" : "all commands");
    for (int i = 0; pl_option_describe(i, &option); i++)
        if (option.commands == commands)
            put_option(&option);
}

static void put_options(void) {
    printf(".SH OPTIONS\n");
    for (unsigned n_commands = 3; n_commands > 0; n_commands--) /* what most have comes first */
        for (unsigned commands = 1; commands <= PL_COMMANDS_ALL; commands++)
            if ((commands & 1) + (commands >> 1 & 1) + (commands >> 2 & 1) == n_commands)
                put_options_of(commands);
}

static void put_commands(void) {
    const pl_command_text *command;
    printf(".SH COMMANDS\n");
    for (int i = 0; (command = pl_command_at(i)); i++) {
        printf(".TP\n");
        put_synopsis(command);
        put_troff(command->description);
        printf("\n");
    }
    printf(".TP\n\\fBplanish help\\fR [\\fICOMMAND\\fR]\nShow the help of the program, or of a "
           "command.\n");
}

static void put_exit_status(void) {
    const pl_command_text *command;
    printf(".SH EXIT STATUS\n");
    for (int i = 0; (command = pl_command_at(i)); i++) {
        printf(".TP\n.B %s\n", command->name);
        put_troff(command->exit_status);
        printf("\n");
    }
}

static void put_head(void) {
    const pl_command_text *command;
    printf(".TH PLANISH 1 \"\" \"planish %s\" \"User commands\"\n", planish_version());
    printf(".SH NAME\nplanish \\- smooth and untangle meshes of tetrahedra or triangles\n"
           ".SH SYNOPSIS\n");
    for (int i = 0; (command = pl_command_at(i)); i++) {
        put_synopsis(command);
        printf(".br\n");
    }
    printf("\\fBplanish help\\fR [\\fICOMMAND\\fR]\n.br\n\\fBplanish \\-\\-version\\fR\n"
           ".SH DESCRIPTION\n");
    put_troff(pl_program_summary);
    printf("\n");
}

static void put_man(void) {
    put_head();
    put_commands();
    put_options();
    printf(".SH FORMATS\n");
    put_troff(pl_program_formats);
    printf(
        "\nFiles are told by their content, then by their names, and written in the\nformat they "
        "were read in.\nIf\n.I OUT\nhas the extension .vtu or .vtk, and\n"
        ".I IN\nis of another format, it is a copy for viewing, with the elements' radius\n"
        "ratios, regions and groups.\n");
    put_exit_status();
    printf(".SH SIGNALS\n"
           "SIGINT, SIGTERM and SIGHUP end the smoothing, and the mesh is written,\nwith status 1; "
           "the second one\nends the program at once.\n"
           ".SH ENVIRONMENT\n"
           ".TP\n.B OMP_NUM_THREADS\nhow many threads there are without \\-\\-threads\n"
           ".TP\n.BR OMP_PROC_BIND \", \" OMP_PLACES \", \" GOMP_CPU_AFFINITY\nif one of them is "
           "set, planish binds no "
           "thread by itself\n"
           ".TP\n.B NO_COLOR\nif it is set, and not empty, nothing is coloured; nor is it where\n"
           "TERM is dumb, or the output\nis no terminal\n"
           ".SH EXAMPLES\n"
           ".EX\nplanish smooth in.msh \\-o out.msh \\-\\-report page.html\n"
           "planish smooth in.mesh \\-o out.mesh \\-\\-slide auto \\-\\-objective worst\n"
           "planish quality in.msh out.msh\n"
           "planish quality out.msh \\-\\-worst 20 \\-\\-json \\-\n.EE\n"
           ".SH SEE ALSO\n.BR planish (3),\n.BR gmsh (1),\n.BR tetgen (1)\n");
}

/* ---- completion ------------------------------------------------------------------------------ */

/** Whether an option before row i has the same name: that of another command, with a value of the
 *  same kind. */
static int is_repeated(int i, const char *name) {
    pl_option_text o;
    for (int j = 0; j < i && pl_option_describe(j, &o); j++)
        if (strcmp(o.name, name) == 0)
            return 1;
    return 0;
}

static void put_bash_values(void) {
    pl_option_text o;
    for (int i = 0; pl_option_describe(i, &o); i++) {
        if (!o.value || is_repeated(i, o.name))
            continue;
        printf("    --%s", o.name);
        if (o.letter)
            printf("|-%c", o.letter);
        if (!o.values)
            printf(") return ;;\n");
        else if (strcmp(o.values, "file") == 0)
            printf(") mapfile -t COMPREPLY < <(compgen -f -- \"$word\"); return ;;\n");
        else
            printf(") COMPREPLY=($(compgen -W '%s' -- \"$word\")); return ;;\n", o.values);
    }
}

static void put_bash_option(const pl_option_text *o) {
    if (o->letter)
        printf(" -%c", o->letter);
    if (o->is_doubled)
        printf(" -%c%c", o->letter, o->letter);
    printf(" --%s", o->name);
}

static void put_bash_options(void) {
    const pl_command_text *command;
    pl_option_text o;
    for (int i = 0; (command = pl_command_at(i)); i++) {
        printf("    %s) options='", command->name);
        for (int j = 0; pl_option_describe(j, &o); j++)
            if (o.commands & command->command)
                put_bash_option(&o);
        printf("' ;;\n");
    }
}

static void put_bash(void) {
    char names[128];
    pl_command_list(" ", " ", names, sizeof names);
    printf("# bash completion for planish\n_planish() {\n"
           "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} options\n"
           "    COMPREPLY=()\n"
           "    if [ \"$COMP_CWORD\" = 1 ]; then\n"
           "        COMPREPLY=($(compgen -W '%s help --help --version' -- \"$word\"))\n"
           "        return\n    fi\n"
           "    # --option=value comes as three words\n"
           "    if [ \"$word\" = = ]; then\n        word=\n"
           "    elif [ \"$before\" = = ]; then\n        before=${COMP_WORDS[COMP_CWORD-2]}\n"
           "    fi\n"
           "    case $before in\n",
           names);
    put_bash_values();
    printf("    esac\n    case ${COMP_WORDS[1]} in\n");
    put_bash_options();
    printf("    help) COMPREPLY=($(compgen -W '%s' -- \"$word\")); return ;;\n    esac\n"
           "    if [[ $word == -* ]]; then\n"
           "        COMPREPLY=($(compgen -W \"$options\" -- \"$word\"))\n"
           "    else\n"
           "        mapfile -t COMPREPLY < <(compgen -f -- \"$word\")\n"
           "    fi\n}\ncomplete -o filenames -F _planish planish\n",
           names);
}

/** One line of a help text for zsh, in single quotes and brackets. */
static void put_zsh_text(const char *text) {
    for (const char *c = text; *c; c++) {
        if (strchr("[]:\\", *c))
            putchar('\\');
        if (*c == '\'')
            fputs("'\\''", stdout);
        else
            putchar(*c == '\n' ? ' ' : *c);
    }
}

static void put_zsh_option(const pl_option_text *o) {
    printf(" \\\n        '*'");
    if (o->letter)
        printf("{-%c%s,", o->letter, o->value ? "+" : "");
    printf("--%s%s%s'[", o->name, o->value ? "=" : "", o->letter ? "}" : "");
    put_zsh_text(o->help);
    printf("]");
    if (o->value) {
        printf(":");
        put_zsh_text(o->value);
        if (!o->values)
            printf(": ");
        else if (strcmp(o->values, "file") == 0)
            printf(":_files");
        else
            printf(":(%s)", o->values);
    }
    printf("'");
}

static void put_zsh_commands(void) {
    const pl_command_text *command;
    printf("#compdef planish\n\nlocal -a commands=(\n");
    for (int i = 0; (command = pl_command_at(i)); i++) {
        printf("    '%s:", command->name);
        put_zsh_text(command->summary);
        printf("'\n");
    }
    printf(")\nif (( CURRENT == 2 )); then\n"
           "    local -a others=('help:the options of a command' '--help:what there is' "
           "'--version:show the version')\n"
           "    _describe -t commands command commands -- others\n    return\nfi\n");
}

static void put_zsh(void) {
    const pl_command_text *command;
    pl_option_text o;
    put_zsh_commands();
    printf("case $words[2] in\nhelp)\n    _describe -t commands command commands\n    ;;\n");
    for (int i = 0; (command = pl_command_at(i)); i++) {
        printf("%s)\n    shift words; (( CURRENT-- ))\n    _arguments '*:", command->name);
        put_zsh_text(command->operand);
        printf(":_files'");
        for (int j = 0; pl_option_describe(j, &o); j++)
            if (o.commands & command->command)
                put_zsh_option(&o);
        printf("\n    ;;\n");
    }
    printf("esac\n");
}

int pl_generate_command(const char *kind) {
    if (strcmp(kind, "man") == 0)
        put_man();
    else if (strcmp(kind, "bash") == 0)
        put_bash();
    else if (strcmp(kind, "zsh") == 0)
        put_zsh();
    else
        return pl_complain_usage(NULL, "--generate makes man, bash or zsh, not '%s'", kind);
    return pl_flush_stdout(PL_EXIT_DONE, PL_EXIT_FAILED);
}
