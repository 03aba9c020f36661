/* commands: the names of the program's commands, and the texts about them. */
#include "options/commands.h"

#include <stdio.h>
#include <string.h>

const char *const pl_program_summary =
    "Smooth meshes of tetrahedra or triangles: move their interior nodes to where the\n"
    "elements are best, and leave everything else as it is.";

const char *const pl_program_formats =
    "Gmsh .msh, Medit .mesh and .meshb, VTK .vtk, .vtu and .vtkhdf, TetGen .node and\n"
    ".ele, Netgen .vol, Abaqus .inp, Nastran .bdf, CGNS, MED, PETSc's\n"
    ".h5, OFF.";

static const pl_command_text command_table[] = {
    {PL_COMMAND_SMOOTH, "smooth", "IN -o OUT", "mesh file", 0, "smooth a mesh",
     "Move the interior nodes of the mesh IN until its elements are best: until the\n"
     "root mean square of their radius ratios is least. Inverted elements are mended\n"
     "first; what is valid stays valid, and of the elements that change the worst gets\n"
     "no worse and the smallest angle no smaller, unless options ask for what costs\n"
     "that. The bits are the same on any number of threads. OUT is IN with the\n"
     "coordinates of the moved nodes replaced, and every other byte as it was.",
     "0 done; 1 a usable mesh was written, but it has elements that are inverted or\n"
     "below their least volume, smoothing was cut short, or a report could not be\n"
     "written; 2 failed, nothing was written; 64 bad usage."},
    {PL_COMMAND_QUALITY, "quality", "FILE...", "mesh file", 1, "measure meshes",
     "Measure a mesh and print what it is worth; several are compared, a row each.\n"
     "Nothing is changed.",
     "0 if the files could be read; 2 if one could not, or a report could not be\n"
     "written; 64 bad usage."},
    {PL_COMMAND_REPORT, "report", "RESULT.json [-o FILE.html]", "result", 0,
     "make a page for people of a result",
     "Make a page for a browser from RESULT.json, which smooth or quality wrote with\n"
     "--json: tables, histograms, how the sweeps converged, and the mesh if its files\n"
     "are still as they were.",
     "0 if the page was written; 2 if not; 64 bad usage."},
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
