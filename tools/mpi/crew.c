/* crew: the processes of planish-mpi, and how they act together. */
#include "mpi/crew.h"

#include "terminal/message.h"
#include "terminal/signals.h"

#include "base/clock.h"

#include <stdio.h>
#include <time.h>

/* Whether a failed process may wait for the others so long before it ends them, seconds. */
static const double PATIENCE = 10, FOREVER = 1e300;

void pl_crew_create(pl_crew *crew, int threads, int bind) {
    *crew = (pl_crew){.threads = threads, .bind = bind};
    MPI_Comm_dup(MPI_COMM_WORLD, &crew->comm);
    MPI_Comm_dup(MPI_COMM_WORLD, &crew->exchange_comm);
    MPI_Comm_rank(crew->comm, &crew->rank);
    MPI_Comm_size(crew->comm, &crew->n_ranks);
}

void pl_crew_destroy_plan(pl_crew *crew) {
    planish_plan_destroy(crew->plan);
    crew->plan = NULL;
    if (!crew->is_large)
        pl_share_destroy(&crew->share);
}

void pl_crew_destroy(pl_crew *crew, int status) {
    /* What there is to say has been said by then. */
    MPI_Allreduce(MPI_IN_PLACE, &crew->is_broken, 1, MPI_INT, MPI_MAX, crew->comm);
    if (crew->is_broken) {
        pl_signals_done(status);
        MPI_Abort(MPI_COMM_WORLD, status);
    }
    pl_crew_destroy_plan(crew);
    if (crew->is_large) {
        pl_share_destroy(&crew->share);
        pl_plexfile_close(&crew->file);
    }
    MPI_Comm_free(&crew->comm);
    MPI_Comm_free(&crew->exchange_comm);
}

/** Wait without heating the core: others may work for minutes. 0, or -1 after so many seconds. */
static int wait_gently(MPI_Request *request, double seconds) {
    const double begin = pl_seconds();
    struct timespec pause = {.tv_nsec = 1000};
    enum { LONGEST = 1000000 };
    for (int done = 0;; pause.tv_nsec = pause.tv_nsec < LONGEST ? 2 * pause.tv_nsec : LONGEST) {
        MPI_Test(request, &done, MPI_STATUS_IGNORE);
        if (done)
            return 0;
        if (pl_seconds() - begin > seconds)
            return -1;
        nanosleep(&pause, NULL);
    }
}

void pl_crew_tell(const pl_crew *crew, int order) {
    MPI_Request request;
    MPI_Ibcast(&order, 1, MPI_INT, 0, crew->comm, &request);
    MPI_Wait(&request, MPI_STATUS_IGNORE);
}

int pl_crew_listen(const pl_crew *crew) {
    int order = 0;
    MPI_Request request;
    MPI_Ibcast(&order, 1, MPI_INT, 0, crew->comm, &request);
    wait_gently(&request, FOREVER);
    return order;
}

int pl_crew_agree(const pl_crew *crew, int code, planish_error *error) {
    struct {
        int code, rank;
    } worst = {code, crew->rank};
    MPI_Request request;
    MPI_Ibarrier(crew->comm, &request);
    if (wait_gently(&request, code ? PATIENCE : FOREVER)) {
        /* This one fails alone: the others wait for it in the midst of their work. */
        pl_complain(PL_EXIT_FAILED, "process %d of %d: %s", crew->rank, crew->n_ranks, error->text);
        pl_signals_clean_up();
        pl_signals_done(PL_EXIT_FAILED);
        MPI_Abort(MPI_COMM_WORLD, PL_EXIT_FAILED);
    }
    MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_2INT, MPI_MINLOC, crew->comm);
    if (worst.code)
        MPI_Bcast(error, sizeof *error, MPI_BYTE, worst.rank, crew->comm);
    return worst.code;
}

planish_options pl_crew_options(const pl_crew *crew, const planish_options *options) {
    planish_options mine = *options;
    MPI_Bcast(&mine, sizeof mine, MPI_BYTE, 0, crew->comm);
    if (crew->rank > 0) { /* what it points to is not here */
        mine.progress = NULL;
        mine.project = NULL;
        mine.parallel = NULL;
        mine.log = NULL;
        mine.round = NULL;
        mine.allocator = NULL;
        mine.progress_user = mine.project_user = mine.parallel_user = NULL;
        mine.log_user = mine.round_user = NULL;
    }
    mine.threads = crew->threads;
    mine.bind = mine.bind && crew->bind;
    return mine;
}

void pl_crew_path(const pl_crew *crew, const char *from, char *path) {
    snprintf(path, PATH_MAX, "%s", from ? from : "");
    MPI_Bcast(path, PATH_MAX, MPI_BYTE, 0, crew->comm);
}
