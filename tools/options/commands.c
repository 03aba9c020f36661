/* commands: the names of the program's commands, and the texts about them. */
#include "options/commands.h"

#include <stdio.h>
#include <string.h>

const char *const pl_program_summary =
    "Smooth and untangle meshes of tetrahedra or triangles. planish moves interior\n"
    "nodes to improve the elements, and keeps everything else as it is.";

const char *const pl_program_formats =
    "Gmsh .msh, Medit .mesh and .meshb, VTK .vtk, .vtu and .vtkhdf, TetGen .node and\n"
    ".ele, Netgen .vol, Abaqus .inp, Nastran .bdf, CGNS .cgns, MED .med, PETSc .h5,\n"
    "OFF .off, STL .stl, OBJ .obj, PLY .ply, MFEM .mesh, Exodus .exo and .e, AVS UCD\n"
    ".avs, SU2 .su2, I-DEAS .unv, XDMF .xdmf and .xmf; folders of Elmer and OpenFOAM.";

static const pl_command_text command_table[] = {
    {PL_COMMAND_SMOOTH, "smooth", "IN -o OUT", "mesh file", 0, "smooth a mesh",
     "Move the interior nodes of the mesh IN to minimise the root mean square of the\n"
     "radius ratios. Inverted elements are repaired first. Valid elements stay valid.\n"
     "By default the worst element with a movable node never gets worse, and the\n"
     "smallest angle never smaller; minimum volumes and other objectives relax this.\n"
     "Mid-side nodes of second-order elements follow their corners. The result has the\n"
     "same bits on any number of threads. OUT differs from IN in the coordinates of\n"
     "moved nodes only.",
     "0 done; 1 a usable mesh was written, but it has elements that are inverted or\n"
     "below their minimum volume, smoothing stopped early, or a report could not be\n"
     "written; 2 failed, nothing was written; 64 bad usage."},
    {PL_COMMAND_QUALITY, "quality", "FILE...", "mesh file", 1, "measure meshes",
     "Report mesh quality of elements of every type; compare several files, one row\n"
     "each. No file is changed.",
     "0 if all files were read; 2 if a file could not be read, or a report could not\n"
     "be written; 64 bad usage."},
    {PL_COMMAND_CONVERT, "convert", "IN OUT", "mesh file", 0, "convert a mesh to another format",
     "Write the mesh IN to OUT in another format, which the extension of OUT tells, or\n"
     "--to. Nodes, elements of all types, regions, named groups and arrays of data are\n"
     "converted as far as the format has these; a note lists the rest.",
     "0 if OUT was written; 2 if not; 64 bad usage."},
    {PL_COMMAND_REPORT, "report", "RESULT.json [-o FILE.html]", "result", 0,
     "create an HTML report from a JSON result",
     "Create an HTML report from RESULT.json, which smooth or quality wrote by --json.\n"
     "It has tables, histograms, the convergence of the sweeps, and a picture of the\n"
     "mesh if its files are unchanged.",
     "0 if the HTML report was written; 2 if not; 64 bad usage."},
};

enum { N_COMMANDS = sizeof command_table / sizeof command_table[0] };

const pl_command_text *pl_command_at(int i) {
    return i < N_COMMANDS ? &command_table[i] : NULL;
}

const pl_command_text *pl_command_row(pl_command command) {
    for (int i = 0; i < N_COMMANDS; i++)
        if (command_table[i].command == command)
            return &command_table[i];
    return NULL;
}

const pl_command_text *pl_command_find(const char *word) {
    for (int i = 0; i < N_COMMANDS; i++)
        if (strcmp(command_table[i].name, word) == 0)
            return &command_table[i];
    return NULL;
}

const char *pl_command_name(pl_command command) {
    return pl_command_row(command)->name;
}

const char *pl_command_list(const char *joint, const char *last, char *text, size_t size) {
    size_t used = 0;
    text[0] = '\0';
    for (int i = 0; i < N_COMMANDS && used < size; i++) {
        const char *before = i == 0 ? "" : i == N_COMMANDS - 1 ? last : joint;
        used += (size_t)snprintf(text + used, size - used, "%s%s", before, command_table[i].name);
    }
    return text;
}

/* ---- help ----------------------------------------------------------------------------------- */

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

static void put_option(const pl_option_text *option) {
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
    printf("Usage: planish COMMAND ... [OPTION]...\n%s\n\n", pl_program_summary);
    for (int i = 0; (command = pl_command_at(i)); i++)
        put_summary(command->name, command->operands, command->summary);
    put_summary("help", "[COMMAND]", "show this help, or that of a command");
    put_summary("--version", "", "show the version and exit");
    printf("\nFormats:\n");
    put_lines(pl_program_formats, 0);
}

void pl_help_print_command(const pl_command_text *command) {
    pl_option_text option;
    printf("Usage: planish %s %s [OPTION]...\n%s\n\n", command->name, command->operands,
           command->description);
    for (int i = 0; pl_option_describe(i, &option); i++)
        if (option.commands & command->command)
            put_option(&option);
    printf("\nExit status:\n");
    put_lines(command->exit_status, 0);
}
