/* manual: the manual page and the completion of shells, from the options' table. */
#include "commands.h"
#include "message.h"

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
    if (o->commands == PL_COMMAND_SMOOTH)
        printf("(smooth)\n");
}

static void put_man(void) {
    pl_option_text o;
    printf(".TH PLANISH 1 \"\" \"planish %s\" \"User commands\"\n", planish_version());
    printf(".SH NAME\nplanish \\- smooth and untangle meshes of tetrahedra or triangles\n"
           ".SH SYNOPSIS\n"
           ".B planish smooth\n.I IN\n.B \\-o\n.I OUT\n[\\fIOPTION\\fR]...\n.br\n"
           ".B planish quality\n.I FILE\n[\\fIOPTION\\fR]...\n.br\n"
           ".B planish\n.RB [ \\-\\-help | \\-\\-version ]\n"
           ".SH DESCRIPTION\n"
           ".B planish smooth\nmoves the interior nodes of the mesh\n.I IN\nuntil its elements are "
           "best: until the root mean square of their radius ratios is least. It untangles\n"
           "inverted elements first, never makes the mesh worse or invalid, and gives the same "
           "bits on any number\nof threads.\n.I OUT\nis\n.I IN\nwith the coordinates of the moved "
           "nodes replaced, and every other byte as it was.\n.PP\n"
           ".B planish quality\nmeasures a mesh and changes nothing.\n.PP\n"
           "Formats: Gmsh MSH 2.2 and 4.1, Medit .mesh and .meshb, VTK .vtk, .vtu and .vtkhdf, "
           "TetGen .node and .ele,\nNetgen .vol, Abaqus .inp, Nastran bulk data, CGNS, MED, OFF; "
           "found by content, then by name. If\n.I OUT\nhas the extension .vtu or .vtk, and\n"
           ".I IN\nis of another format, it is a copy for viewing, with the elements' radius "
           "ratios, regions and groups.\n");
    printf(".SH OPTIONS\n");
    for (int i = 0; pl_option_describe(i, &o); i++)
        put_option(&o);
    printf(
        ".SH EXIT STATUS\n"
        ".TP\n.B 0\ndone\n"
        ".TP\n.B 1\na usable mesh was written, but something asked for was not reached: elements "
        "are inverted or below\ntheir least volume, or a limit of time or a signal cut it "
        "short\n"
        ".TP\n.B 2\nfailed; nothing was written, and one line says what, where and what to do\n"
        ".TP\n.B 64\nthe command line makes no sense\n"
        ".SH SIGNALS\n"
        "SIGINT, SIGTERM and SIGHUP end the smoothing, and the mesh is written, with status 1; "
        "the second one\nends the program at once.\n"
        ".SH ENVIRONMENT\n"
        ".TP\n.B OMP_NUM_THREADS\nhow many threads there are without \\-\\-threads\n"
        ".TP\n.BR OMP_PROC_BIND \", \" OMP_PLACES\nif one of them is set, planish binds no "
        "thread by itself\n"
        ".SH EXAMPLES\n"
        ".EX\nplanish smooth in.msh \\-o out.msh\n"
        "planish smooth in.mesh \\-o out.mesh \\-\\-slide auto \\-\\-objective worst\n"
        "planish quality out.msh \\-\\-json \\-\n.EE\n"
        ".SH SEE ALSO\n.BR planish (3),\n.BR gmsh (1),\n.BR tetgen (1)\n");
}

/* ---- completion ------------------------------------------------------------------------------ */

static void put_bash_values(void) {
    pl_option_text o;
    for (int i = 0; pl_option_describe(i, &o); i++) {
        if (!o.value)
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

static void put_bash_names(pl_command command) {
    pl_option_text o;
    for (int i = 0; pl_option_describe(i, &o); i++)
        if (o.commands & command)
            printf(" --%s", o.name);
}

static void put_bash(void) {
    printf("# bash completion for planish\n_planish() {\n"
           "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} options\n"
           "    COMPREPLY=()\n"
           "    if [ \"$COMP_CWORD\" = 1 ]; then\n"
           "        COMPREPLY=($(compgen -W 'smooth quality --help --version' -- \"$word\"))\n"
           "        return\n    fi\n"
           "    case $before in\n");
    put_bash_values();
    printf("    esac\n    case ${COMP_WORDS[1]} in\n    smooth) options='");
    put_bash_names(PL_COMMAND_SMOOTH);
    printf("' ;;\n    quality) options='");
    put_bash_names(PL_COMMAND_QUALITY);
    printf("' ;;\n    esac\n"
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

static void put_zsh_option(const pl_option_text *o) {
    printf(" \\\n        '*--%s%s[", o->name, o->value ? "=" : "");
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

static void put_zsh(void) {
    pl_option_text o;
    printf("#compdef planish\n\nif (( CURRENT == 2 )); then\n"
           "    _values command smooth quality --help --version\n    return\nfi\n"
           "case $words[2] in\n");
    for (int command = PL_COMMAND_SMOOTH; command <= PL_COMMAND_QUALITY; command++) {
        printf("%s)\n    shift words; (( CURRENT-- ))\n    _arguments '*:mesh:_files'",
               pl_command_name((pl_command)command));
        for (int i = 0; pl_option_describe(i, &o); i++)
            if (o.commands & (unsigned)command)
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
