/* main: the program planish; finds the command and hands over. */
#include "commands.h"
#include "message.h"
#include "signals.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char *with(planish_feature feature) {
    return planish_has(feature) ? "with" : "without";
}

static int print_version(void) {
    printf("planish %s\nSmooths meshes of tetrahedra and triangles. BSD 3-clause licence; there is "
           "no warranty.\nBuilt %s OpenMP, %s hwloc, %s kernels for AVX2 and AVX-512.\n",
           planish_version(), with(PLANISH_FEATURE_OPENMP), with(PLANISH_FEATURE_HWLOC),
           with(PLANISH_FEATURE_X86_KERNELS));
    return pl_flush_stdout(PL_EXIT_DONE, PL_EXIT_FAILED);
}

static int print_help(void) {
    printf("Usage: planish COMMAND ...\n"
           "Smooth meshes of tetrahedra or triangles: move their interior nodes to where the\n"
           "elements are best, and leave everything else as it is.\n\n"
           "  planish smooth IN -o OUT [OPTION]...    smooth IN and write OUT\n"
           "  planish quality FILE [OPTION]...        measure FILE\n"
           "  planish COMMAND --help                  options of a command\n"
           "  planish --help, planish --version\n\n"
           "Formats: Gmsh .msh, Medit .mesh and .meshb, VTK .vtk, .vtu and .vtkhdf, TetGen\n"
           ".node/.ele, Netgen .vol, Abaqus .inp, Nastran .bdf, CGNS, MED, OFF.\n");
    return pl_flush_stdout(PL_EXIT_DONE, PL_EXIT_FAILED);
}

static int run_command(pl_command command, int argc, char **argv) {
    pl_arguments arguments;
    int status = pl_arguments_parse(&arguments, command, argc, argv);
    if (!status && arguments.help) {
        pl_help_print(command);
        status = pl_flush_stdout(PL_EXIT_DONE, PL_EXIT_FAILED);
    } else if (!status && arguments.version) {
        status = print_version();
    } else if (!status) {
        status = command == PL_COMMAND_SMOOTH ? pl_smooth_command(&arguments)
                                              : pl_quality_command(&arguments);
    }
    pl_arguments_free(&arguments);
    return status;
}

/** A closed standard stream would give its number to the next file opened, and messages would then
 *  go into a mesh. A closed standard output stays an error for what is meant for it. */
static void open_standard_streams(void) {
    for (int descriptor = 0; descriptor <= 2; descriptor++)
        if (fcntl(descriptor, F_GETFD) == -1 &&
            open("/dev/null", descriptor == STDOUT_FILENO ? O_RDONLY : O_RDWR) != descriptor)
            _exit(PL_EXIT_FAILED);
}

int main(int argc, char **argv) {
    open_standard_streams();
    pl_signals_install();
    /* hwloc would print what it does not find on odd machines; placement copes without. */
    setenv("HWLOC_HIDE_ERRORS", "2", 0);
    const char *word = argc > 1 ? argv[1] : NULL;
    if (!word)
        return pl_complain_usage(NULL, "no command is named (smooth or quality)");
    if (strcmp(word, "smooth") == 0)
        return run_command(PL_COMMAND_SMOOTH, argc - 1, argv + 1);
    if (strcmp(word, "quality") == 0)
        return run_command(PL_COMMAND_QUALITY, argc - 1, argv + 1);
    if (strcmp(word, "--help") == 0)
        return print_help();
    if (strcmp(word, "--version") == 0)
        return print_version();
    if (strcmp(word, "--generate") == 0 && argc == 3)
        return pl_generate_command(argv[2]);
    return pl_complain_usage(NULL, "'%s' is neither smooth nor quality", word);
}
