/* main: planish-mpi, the program for meshes that MPI processes share. */
#define _GNU_SOURCE /* affinity */
#include "mpi/lead.h"
#include "options/parse.h"

#include "options/commands.h"
#include "options/help.h"
#include "terminal/message.h"
#include "terminal/platform.h"
#include "terminal/signals.h"
#include "terminal/threads.h"

#include "base/parallel.h"
#include "base/system.h"

#include <petscsys.h>

#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/** Message of the first process to the others before there is a crew. */
typedef struct start {
    int status;  /* of a command line that asks for no work, else -1 */
    int threads; /* that the command line asks for, for each process, or 0 */
} start;

static int print_version(void) {
    int major, minor;
    MPI_Get_version(&major, &minor);
    printf("planish-mpi %s\nSmooths a mesh by several processes.\nMPI %d.%d, PETSc "
           "%d.%d.%d.\n",
           planish_version(), major, minor, PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR,
           PETSC_VERSION_SUBMINOR);
    return pl_flush_stdout(PL_EXIT_DONE, PL_EXIT_FAILED);
}

static int print_help(void) {
    printf("Run 'planish smooth' by several processes (docs/distributed.md):\n\n"
           "    mpirun -n 4 planish-mpi IN -o OUT [OPTION...]\n\n"
           "The options are those of 'planish smooth'. -j sets the threads of each process.\n"
           "planish-mpi also writes OUT.h5, PETSc's own file, for any IN.\n\n");
    pl_help_print_command(pl_command_row(PL_COMMAND_SMOOTH));
    return pl_flush_stdout(PL_EXIT_DONE, PL_EXIT_FAILED);
}

/** Understand the command line, in the first process. */
static start read_arguments(int argc, char **argv, pl_arguments *arguments) {
    static char command[] = "smooth"; /* whose options these are */
    argv[0] = command;
    start s = {.status = pl_arguments_parse(arguments, PL_COMMAND_SMOOTH, argc, argv)};
    if (!s.status && arguments->help)
        s.status = print_help();
    else if (!s.status && arguments->version)
        s.status = print_version();
    else if (!s.status && !arguments->output)
        s.status = pl_complain_usage("smooth", "planish-mpi smooths one mesh: give -o OUT");
    else if (!s.status && arguments->history > 0)
        s.status =
            pl_complain_usage("smooth", "planish-mpi keeps no --history: run planish smooth");
    else if (!s.status)
        s.status = -1;
    pl_file_status about;
    if (s.status < 0 && pl_file_find(arguments->input, &about) == 0 && about.kind == PL_FILE_FOLDER)
        s.status = pl_complain(
            PL_EXIT_FAILED, "%s: is a folder, which planish-mpi does not read; run planish smooth",
            arguments->input);
    s.threads = arguments->library.threads;
    return s;
}

/** Threads of this process: those of the command line or of OpenMP's variable, else the cores that
 *  it may use, shared with those processes of its machine that may use them, too; as far as they
 *  start. *bind: there are none of these processes. */
static int choose_threads(const start *s, int *bind) {
    MPI_Comm machine;
    cpu_set_t mine, common;
    int n_here, n_sharing = 0;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
    MPI_Comm_size(machine, &n_here);
    cpu_set_t *all = calloc((size_t)n_here, sizeof *all);
    CPU_ZERO(&mine);
    sched_getaffinity(0, sizeof mine, &mine);
    if (!all)
        MPI_Abort(MPI_COMM_WORLD, PL_EXIT_FAILED);
    MPI_Allgather(&mine, sizeof mine, MPI_BYTE, all, sizeof mine, MPI_BYTE, machine);
    for (int k = 0; k < n_here; k++) {
        CPU_AND(&common, &mine, &all[k]);
        n_sharing += CPU_COUNT(&common) > 0;
    }
    free(all);
    MPI_Comm_free(&machine);
    *bind = n_sharing == 1;
    const int shared = n_sharing > 0 ? CPU_COUNT(&mine) / n_sharing : 1;
    const char *told = getenv("OMP_NUM_THREADS");
    const int wanted = s->threads > 0 ? s->threads : told && told[0] ? 0 : shared > 0 ? shared : 1;
    const int threads = pl_threads_to_use(wanted);
    return threads > 0 ? threads : pl_thread_count(0);
}

static int work(int rank, const start *s, pl_arguments *arguments) {
    pl_crew crew;
    int bind;
    const int threads = choose_threads(s, &bind);
    pl_crew_create(&crew, threads, bind);
    arguments->library.threads = crew.threads;
    arguments->leave_unbound |= !bind;
    const int status = rank == 0 ? pl_crew_lead(&crew, arguments) : pl_crew_follow(&crew);
    pl_crew_destroy(&crew, status);
    return status;
}

static int run(int argc, char **argv) {
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP, SIGPIPE};
    int rank;
    pl_arguments arguments = {.input = NULL};
    start s = {.status = -1};
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    pl_signals_install();
    if (rank == 0)
        s = read_arguments(argc, argv, &arguments);
    for (size_t i = 0; rank > 0 && i < sizeof signals / sizeof *signals; i++)
        signal(signals[i], SIG_IGN); /* the first process is told to stop, and tells the others */
    MPI_Bcast(&s, sizeof s, MPI_BYTE, 0, MPI_COMM_WORLD);
    const int status = s.status >= 0 ? s.status : work(rank, &s, &arguments);
    if (rank == 0)
        pl_arguments_free(&arguments);
    return status;
}

int main(int argc, char **argv) {
    int provided;
    setenv("NO_COLOR", "1", 0); /* Open MPI takes what is printed for a terminal's */
    argv = pl_platform_begin(argc, argv);
    if (!argv || MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &provided))
        return PL_EXIT_FAILED;
    /* Errors are told by us, as they are of planish; options of PETSc may be in PETSC_OPTIONS. */
    PetscOptionsSetValue(NULL, "-no_signal_handler", "true");
    if (PetscInitializeNoArguments())
        MPI_Abort(MPI_COMM_WORLD, PL_EXIT_FAILED);
    PetscPushErrorHandler(PetscReturnErrorHandler, NULL);
    const int status = run(argc, argv);
    PetscFinalize();
    MPI_Finalize();
    return pl_signals_done(status);
}
