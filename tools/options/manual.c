/* manual: the manual page and the completion of shells, from the tables of commands and options. */
#include "options/help.h"
#include "options/table.h"
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

static void put_option(const pl_option *o) {
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

static int count_bits(unsigned bits) {
    int n = 0;
    for (; bits; bits >>= 1)
        n += (int)(bits & 1);
    return n;
}

/** Put ".SS Options of smooth, quality and convert", if there are any that these commands have and no
 * others. */
static void put_options_of(unsigned commands) {
    const pl_option *option;
    const pl_command_text *command;
    int n = 0, n_left = commands == PL_COMMANDS_ALL ? 0 : count_bits(commands);
    for (int i = 0; (option = pl_option_at(i)); i++)
        n += (option->commands & PL_COMMANDS_ALL) == commands;
    if (n == 0)
        return;
    printf(".SS \"Options of %s", n_left ? "" : "all commands");
    for (int i = 0; n_left && (command = pl_command_at(i)); i++)
        if (command->command & commands)
            printf("%s%s", command->name, --n_left > 1 ? ", " : n_left ? " and " : "");
    printf("\"\n");
    for (int i = 0; (option = pl_option_at(i)); i++)
        if ((option->commands & PL_COMMANDS_ALL) == commands)
            put_option(option);
}

/** Put the sections on options: those that most commands have come first. */
static void put_man_options(void) {
    printf(".SH OPTIONS\n");
    for (int n = PL_COMMANDS_ALL; n > 0; n--)
        for (unsigned commands = 1; commands <= PL_COMMANDS_ALL; commands++)
            if (count_bits(commands) == n)
                put_options_of(commands);
}

/** Put the sections that the tables know nothing of. */
static void put_man_end(void) {
    const pl_command_text *command;
    printf(".SH SIGNALS\n"
           "SIGINT, SIGTERM and SIGHUP end the smoothing. planish then writes the mesh and exits "
           "with\n"
           "status 1. A second signal ends planish at once.\n"
           ".SH ENVIRONMENT\n"
           ".TP\n"
           ".B OMP_NUM_THREADS\n"
           "number of threads if there is no \\-\\-threads\n"
           ".TP\n"
           ".BR OMP_PROC_BIND \", \" OMP_PLACES \", \" GOMP_CPU_AFFINITY\n"
           "if one of them is set, planish binds no thread\n"
           ".TP\n"
           ".B NO_COLOR\n"
           "if it is set and not empty, planish prints no colours; planish also prints no\n"
           "colours if TERM is dumb or the output is not a terminal\n"
           ".SH EXAMPLES\n"
           ".EX\n");
    for (int i = 0; (command = pl_command_at(i)); i++) {
        put_troff(command->examples);
        printf("\n");
    }
    printf(".EE\n"
           ".SH SEE ALSO\n.BR planish (3),\n.BR gmsh (1),\n.BR tetgen (1)\n");
}

static void put_man(void) {
    const pl_command_text *command;
    printf(".TH PLANISH 1 \"\" \"planish %s\" \"User commands\"\n", planish_version());
    printf(".SH NAME\n"
           "planish \\- smooth and untangle meshes of tetrahedra, triangles and other elements\n"
           ".SH SYNOPSIS\n");
    for (int i = 0; (command = pl_command_at(i)); i++) {
        put_synopsis(command);
        printf(".br\n");
    }
    printf("\\fBplanish\\fR \\fIIN\\fR\n.br\n"
           "\\fBplanish help\\fR [\\fICOMMAND\\fR]\n.br\n\\fBplanish \\-\\-version\\fR\n"
           ".SH DESCRIPTION\n");
    put_troff(pl_program_summary);
    printf("\n.SH COMMANDS\n");
    for (int i = 0; (command = pl_command_at(i)); i++) {
        printf(".TP\n");
        put_synopsis(command);
        put_troff(command->description);
        printf("\n");
    }
    printf(".TP\n\\fBplanish help\\fR [\\fICOMMAND\\fR]\nShow the help of the program, or of a "
           "command.\n");
    put_man_options();
    printf(".SH FORMATS\n");
    put_troff(pl_program_formats);
    printf("\n"
           "planish detects the format of a file by its content, then by its name, and writes the\n"
           "format that it has read.\n"
           "If\n"
           ".I OUT\n"
           "has the extension of another format that\n"
           ".B planish convert\n"
           "writes, planish converts the mesh.\n"
           ".SH EXIT STATUS\n");
    for (int i = 0; (command = pl_command_at(i)); i++) {
        printf(".TP\n.B %s\n", command->name);
        put_troff(command->exit_status);
        printf("\n");
    }
    put_man_end();
}

/* ---- completion ------------------------------------------------------------------------------ */

/** Find how long words are without "group" at their end; *has_group: whether it is there. */
static int length_of_words(const char *values, int *has_group) {
    const char *group = strstr(values, "group");
    *has_group = group != NULL;
    return (int)(group ? (size_t)(group - values) : strlen(values));
}

/** Put that bash completes words, "group" among them for the groups of the mesh. */
static void put_bash_words(const char *values) {
    int has_group;
    const int length = length_of_words(values, &has_group);
    if (has_group)
        printf(") mapfile -t COMPREPLY < <(_planish_tags \"$tag\" %.*s); return ;;\n", length,
               values);
    else
        printf(") COMPREPLY=($(compgen -W '%s' -- \"$word\")); return ;;\n", values);
}

/** Put what bash completes behind an option with a value; of options of one name, which are those
 * of several commands, values are of the same kind. */
static void put_bash_values(void) {
    const pl_option *o, *before;
    for (int i = 0; (o = pl_option_at(i)); i++) {
        int is_repeated = 0;
        for (int j = 0; j < i && (before = pl_option_at(j)); j++)
            is_repeated |= strcmp(before->name, o->name) == 0;
        if (!o->value || is_repeated)
            continue;
        printf("    --%s", o->name);
        if (o->letter)
            printf("|-%c", o->letter);
        if (!o->values)
            printf(") return ;;\n");
        else if (strcmp(o->values, "file") == 0)
            printf(") mapfile -t COMPREPLY < <(compgen -f -- \"$word\"); return ;;\n");
        else
            put_bash_words(o->values);
    }
}

/** Put the options of command, for bash to offer where the command is pattern. */
static void put_bash_options(const pl_command_text *command, const char *pattern) {
    const pl_option *o;
    printf("    %s) options='", pattern);
    for (int i = 0; (o = pl_option_at(i)); i++) {
        if (!(o->commands & command->command))
            continue;
        if (o->letter)
            printf(" -%c", o->letter);
        if (o->commands & PL_OPTION_DOUBLED)
            printf(" -%c%c", o->letter, o->letter);
        printf(" --%s", o->name);
    }
    printf("' ;;\n");
}

static void put_bash(void) {
    const pl_command_text *command;
    char names[128];
    pl_command_list(" ", " ", names, sizeof names);
    printf(
        "# bash completion for planish\n"
        "# _planish_groups: the groups of the mesh, a file or folder: nothing waits for a pipe\n"
        "_planish_groups() {\n"
        "    local file\n"
        "    for file in \"${COMP_WORDS[@]:2}\" \"${COMP_WORDS[1]}\"; do\n"
        "        file=${file//\\\\/} # before a blank, say\n"
        "        [ -f \"$file\" ] || [ -d \"$file\" ] || continue\n"
        "        \"${COMP_WORDS[0]}\" groups -- \"$file\" 2>/dev/null && break\n"
        "    done | cut -c 20-\n"
        "}\n"
        "# _planish_tags WORD TAG...: tags that begin with WORD, the groups of the mesh among "
        "them, without $colon\n"
        "_planish_tags() {\n"
        "    local word=${1//[\\\\\\\"\\']/} tag\n"
        "    shift\n"
        "    { printf '%%s\\n' \"$@\"; _planish_groups; } |\n"
        "        while read -r tag; do\n"
        "            [[ -z $tag || $tag != \"$word\"* ]] || printf '%%s\\n' \"${tag#\"$colon\"}\"\n"
        "        done\n"
        "}\n_planish() {\n"
        "    local word=${COMP_WORDS[COMP_CWORD]} at=$COMP_CWORD colon= options\n"
        "    local tag=$word before\n"
        "    # a colon that nothing quotes is a word: those around it are one tag, which readline "
        "has up to there\n"
        "    while [ \"$at\" -gt 2 ] && [[ ${COMP_WORDS[at]} == : || ${COMP_WORDS[at-1]} == : ]]; "
        "do\n"
        "        tag=${COMP_WORDS[--at]}$tag\n"
        "    done\n"
        "    [ \"$at\" = \"$COMP_CWORD\" ] || colon=${tag%%\"${tag##*:}\"}\n"
        "    before=${COMP_WORDS[at-1]}\n"
        "    COMPREPLY=()\n"
        "    if [ \"$COMP_CWORD\" = 1 ]; then\n"
        "        mapfile -t COMPREPLY < <(compgen -W '%s help --help --version' -- \"$word\"\n"
        "            compgen -f -- \"$word\")\n"
        "        return\n    fi\n"
        "    # --option=value comes as three words\n"
        "    if [ \"$word\" = = ]; then\n        word= tag=\n"
        "    elif [ \"$before\" = = ]; then\n        before=${COMP_WORDS[at-2]}\n"
        "    fi\n"
        "    case $before in\n",
        names);
    put_bash_values();
    printf("    esac\n    case ${COMP_WORDS[1]} in\n");
    for (int i = 0; (command = pl_command_at(i)); i++)
        put_bash_options(command, command->name);
    printf("    help) COMPREPLY=($(compgen -W '%s' -- \"$word\")); return ;;\n", names);
    put_bash_options(pl_command_row(PL_COMMAND_ADVISE), "*");
    printf("    esac\n"
           "    if [[ $word == -* ]]; then\n"
           "        COMPREPLY=($(compgen -W \"$options\" -- \"$word\"))\n"
           "    else\n"
           "        mapfile -t COMPREPLY < <(compgen -f -- \"$word\")\n"
           "    fi\n}\ncomplete -o filenames -F _planish planish\n");
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

static void put_zsh_option(const pl_option *o) {
    int has_group;
    const int length = length_of_words(o->values ? o->values : "", &has_group);
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
        else if (has_group)
            printf(": _planish_tags %.*s", length, o->values);
        else
            printf(":(%s)", o->values);
    }
    printf("'");
}

/** Put what zsh completes behind command. */
static void put_zsh_options(const pl_command_text *command) {
    const pl_option *o;
    printf("    _arguments '*:");
    put_zsh_text(command->operand);
    printf(":_files'");
    for (int i = 0; (o = pl_option_at(i)); i++)
        if (o->commands & command->command)
            put_zsh_option(o);
    printf("\n    ;;\n");
}

static void put_zsh(void) {
    const pl_command_text *command;
    printf("#compdef planish\n\n"
           "# tags, and the groups of the mesh\n"
           "_planish_tags() {\n"
           "    local file\n"
           "    local -a tags\n"
           "    for file in ${(Q)words[2,-1]}; do # nothing waits for a pipe\n"
           "        [[ -f $file || -d $file ]] || continue\n"
           "        tags=(${(f)\"$(planish groups -- $file 2>/dev/null | cut -c 20-)\"})\n"
           "        (( $#tags )) && break\n"
           "    done\n"
           "    compadd -- $@ $tags\n}\n\nlocal -a commands=(\n");
    for (int i = 0; (command = pl_command_at(i)); i++) {
        printf("    '%s:", command->name);
        put_zsh_text(command->summary);
        printf("'\n");
    }
    printf(")\nif (( CURRENT == 2 )); then\n"
           "    local -a others=('help:show the options of a command' '--help:show the commands' "
           "'--version:show the version')\n"
           "    _describe -t commands command commands -- others\n    _files\n    return\nfi\n"
           "case $words[2] in\nhelp)\n    _describe -t commands command commands\n    ;;\n");
    for (int i = 0; (command = pl_command_at(i)); i++) {
        printf("%s)\n    shift words; (( CURRENT-- ))\n", command->name);
        put_zsh_options(command);
    }
    printf("*)\n");
    put_zsh_options(pl_command_row(PL_COMMAND_ADVISE));
    printf("esac\n");
}

/* ---- the table of formats in docs/formats.md --------------------------------------------------- */

/** Put the names that mesh files are converted to which are of a format. */
static void put_targets(const planish_format_info *info) {
    const char *target, *before = "";
    const size_t n = strlen(info->name);
    for (int i = 0; (target = planish_file_target(i)); i++)
        if (strncmp(target, info->name, n) == 0 &&
            strspn(target + n, "0123456789") == strlen(target + n)) {
            printf("%s`%s`", before, target);
            before = ", ";
        }
}

static void put_formats(void) {
    planish_format_info info;
    printf(
        "| format | `--format` | extensions | read | `--to` |\n| --- | --- | --- | --- | --- |\n");
    for (int i = 0; planish_file_format_info(i, &info); i++) {
        const char *before = "";
        printf("| %s | `%s` | ", info.title, info.name);
        const int is_folder = info.note[0] == '[';
        for (const char *const *e = info.extensions; *e && !is_folder; e++, before = ", ")
            printf("%s%s", before, *e);
        printf("%s%s | %s | ", *before && info.note[0] ? "; " : "", info.note, info.reads);
        put_targets(&info);
        printf(" |\n");
    }
}

int pl_generate_command(const char *kind) {
    if (strcmp(kind, "man") == 0)
        put_man();
    else if (strcmp(kind, "bash") == 0)
        put_bash();
    else if (strcmp(kind, "zsh") == 0)
        put_zsh();
    else if (strcmp(kind, "formats") == 0)
        put_formats();
    else
        return pl_complain_usage(NULL, "--generate makes man, bash, zsh or formats, not '%s'",
                                 kind);
    return pl_flush_stdout(PL_EXIT_DONE, PL_EXIT_FAILED);
}
