/* commands: the names of the program's commands, and the texts about them. */
#include "options/commands.h"

#include <stdio.h>
#include <string.h>

const char *const pl_program_summary =
    "Smooth and untangle meshes of tetrahedra, triangles and other elements. planish\n"
    "moves interior nodes to improve the elements, and changes nothing else.";

const char *const pl_program_formats =
    "Gmsh .msh, Medit .mesh and .meshb, VTK .vtk, .vtu and .vtkhdf, TetGen .node and\n"
    ".ele, Netgen .vol, Abaqus .inp, Nastran .bdf, CGNS .cgns, MED .med, PETSc .h5,\n"
    "OFF .off, STL .stl, OBJ .obj, PLY .ply, MFEM .mesh, Exodus .exo and .e, AVS UCD\n"
    ".avs, SU2 .su2, I-DEAS .unv, XDMF .xdmf and .xmf; folders of Elmer and OpenFOAM.";

static const pl_command_text command_table[] = {
    {PL_COMMAND_SMOOTH, "smooth", "IN OUT", "mesh file", 0, 1, "smooth a mesh",
     "Move the interior nodes of the mesh IN to minimise the root mean square (RMS) of\n"
     "the radius ratios, which are 1 for regular elements and larger for others.\n"
     "planish first repairs inverted elements. A valid mesh stays valid. By default\n"
     "the worst element with a movable node never gets worse, and the smallest angle\n"
     "never gets smaller; sizes, minimum volumes and other objectives relax this.\n"
     "Mid-side nodes of second-order elements follow their corners. The result has the\n"
     "same bits on any number of threads. OUT differs from IN only in the coordinates\n"
     "of moved nodes. Without -o, OUT must not exist yet; -o OUT replaces the file.",
     "0 done; 1 planish wrote a usable mesh, but some elements are inverted, reversed\n"
     "or below their minimum volume, nodes are off the surface of --onto, smoothing\n"
     "stopped early, or a report could not be written; 2 failed, planish wrote\n"
     "nothing; 64 bad usage. For several meshes planish returns the highest status.",
     "planish smooth in.msh out.msh --slide auto\n"
     "planish smooth in.vtu out.vtu --best --report page.html\n"
     "planish smooth deck.inp out.inp --fix LOAD --fix SUPPORT\n"
     "planish smooth deformed.vtk out.vtk --like before.vtk\n"
     "planish smooth *.mesh --output-dir smoothed"},
    {PL_COMMAND_QUALITY, "quality", "FILE...", "mesh file", 1, 0, "measure meshes",
     "Report mesh quality of elements of every type; compare several files, one row\n"
     "each. No file is changed.",
     "0 if all files were read; 2 if a file could not be read, or a report could not\n"
     "be written; 64 bad usage.",
     "planish quality in.msh\n"
     "planish quality in.msh out.msh\n"
     "planish quality out.msh --worst 20 --json -\n"
     "planish quality out.msh -o view.vtu"},
    {PL_COMMAND_COMPARE, "compare", "BEFORE AFTER", "mesh file", 0, 1,
     "compare two states of a mesh",
     "Compare the quality of two states of a mesh: BEFORE and AFTER have the same\n"
     "elements but different coordinates. Each may have any format. The tables and the\n"
     "HTML report are the same as those of smooth. 'planish quality A B' compares\n"
     "meshes with different elements.",
     "0 if they were compared; 2 if not; 64 bad usage.",
     "planish compare in.msh out.msh\n"
     "planish compare in.vtu other-smoother.vtk --report page.html"},
    {PL_COMMAND_ADVISE, "advise", "IN", "mesh file", 0, 0, "measure a mesh and try to smooth it",
     "Report the quality of the mesh IN, smooth it in memory in several ways, and\n"
     "print the command that helps most. No file is changed. 'planish IN' does the\n"
     "same. Each trial smooths for at most half a minute.",
     "0 if the trials were made; 2 if not; 64 bad usage.",
     "planish advise in.msh\n"
     "planish in.msh --fix LOAD"},
    {PL_COMMAND_GROUPS, "groups", "FILE", "mesh file", 0, 0, "list the groups of a mesh",
     "List the groups of the mesh FILE, one per line: what the group contains (solids,\n"
     "faces, lines or nodes), how many of these, and its tag. --fix, --slide and\n"
     "--min-volume take tags.",
     "0 if the file was read; 2 if not; 64 bad usage.", "planish groups deck.inp"},
    {PL_COMMAND_CONVERT, "convert", "IN OUT", "mesh file", 0, 1, "convert a mesh to another format",
     "Write the mesh IN to OUT in another format. The extension of OUT, or --to, names\n"
     "the format. planish converts nodes, elements of all types, regions, named groups\n"
     "and arrays of data as far as the format can hold them; a note lists the rest.\n"
     "Without -o, OUT must not exist yet; -o OUT replaces the file.",
     "0 if OUT was written; 2 if not; 64 bad usage.",
     "planish convert in.med out.vtu\n"
     "planish convert in.cgns -o out.msh --to gmsh22"},
    {PL_COMMAND_REPORT, "report", "RESULT.json [-o FILE.html]", "result", 0, 0,
     "create an HTML report from a JSON result",
     "Create an HTML report from RESULT.json, which smooth, compare or quality wrote\n"
     "by --json. The report has tables, histograms, the convergence of the sweeps, and\n"
     "a picture of the mesh if the mesh files have not changed.",
     "0 if the HTML report was written; 2 if not; 64 bad usage.",
     "planish smooth in.msh out.msh --json result.json\n"
     "planish report result.json -o page.html"},
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
