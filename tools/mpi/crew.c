/* crew: the work of planish-mpi in all its processes. */
#include "mpi/crew.h"

#include "mpi/plexfile.h"

#include "commands/commands.h"
#include "terminal/message.h"
#include "terminal/signals.h"

#include "base/clock.h"
#include "topology/topology.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/** What the first process tells the others to do with it. */
typedef enum order {
    CREATE,
    DESTROY,
    GET_FREE,
    MEASURE,
    MEASURE_ELEMENTS,
    CHECK_VOLUMES,
    FIND_UNFIXABLE,
    FIND_REVERSED,
    SMOOTH,
    WRITE,
    END
} order;

/* ---- waiting -------------------------------------------------------------------------------- */

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

static void tell(const pl_crew *crew, order what) {
    int number = (int)what;
    MPI_Request request;
    MPI_Ibcast(&number, 1, MPI_INT, 0, crew->comm, &request);
    MPI_Wait(&request, MPI_STATUS_IGNORE);
}

static order listen(const pl_crew *crew) {
    int number = END;
    MPI_Request request;
    MPI_Ibcast(&number, 1, MPI_INT, 0, crew->comm, &request);
    wait_gently(&request, 1e300);
    return (order)number;
}

/** A process that fails alone ends all of them: the others wait for it in the midst of their work.
 */
static void end_all(const pl_crew *crew, const planish_error *error) {
    pl_complain(PL_EXIT_FAILED, "process %d of %d: %s", crew->rank, crew->n_ranks, error->text);
    pl_signals_clean_up();
    pl_signals_done(PL_EXIT_FAILED);
    MPI_Abort(MPI_COMM_WORLD, PL_EXIT_FAILED);
}

int pl_crew_agree(const pl_crew *crew, int code, planish_error *error) {
    struct {
        int code, rank;
    } worst = {code, crew->rank};
    MPI_Request request;
    MPI_Ibarrier(crew->comm, &request);
    if (wait_gently(&request, code ? PL_CREW_PATIENCE : 1e300))
        end_all(crew, error);
    MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_2INT, MPI_MINLOC, crew->comm);
    if (worst.code)
        MPI_Bcast(error, sizeof *error, MPI_BYTE, worst.rank, crew->comm);
    return worst.code;
}

static int fail_memory(planish_error *error) {
    *error = (planish_error){PLANISH_ERROR_MEMORY, -1, -1, "out of memory for what is collected"};
    return PLANISH_ERROR_MEMORY;
}

/** Collect values in the first process, if code says that there are any: PLANISH_OK in all
 * processes, or the same error. */
static int collect(const pl_crew *crew, int code, const pl_collection *c, const void *values,
                   int size, void *whole, planish_error *error) {
    const int64_t n = pl_collected(c);
    void *room = code ? NULL : pl_new_array(n, (size_t)size);
    if (!code && !room)
        code = fail_memory(error);
    code = pl_crew_agree(crew, code, error);
    if (!code)
        pl_collect(c, values, size, room, whole);
    free(room);
    return code;
}

/* ---- what each process does, all of them at the same time; whole, of the whole mesh, is of the
 * ---- first one, and NULL in the others ------------------------------------------------------- */

planish_options pl_crew_options(const pl_crew *crew, const planish_options *options) {
    planish_options mine;
    planish_options_init(&mine);
    if (options)
        mine = *options;
    MPI_Bcast(&mine, sizeof mine, MPI_BYTE, 0, crew->comm);
    if (!options) { /* what it points to is not here */
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

/** What the functions of planish_part cannot do. */
static int check_options(const planish_options *options, planish_error *error) {
    if (options->precision != PLANISH_ROUNDED)
        return PLANISH_OK;
    *error = (planish_error){PLANISH_ERROR_PARTS, -1, -1,
                             "the file has fields of text whose digits only the process knows that "
                             "has read it"};
    return error->code;
}

void pl_crew_destroy_plan(pl_crew *crew) {
    planish_plan_destroy(crew->plan);
    crew->plan = NULL;
    pl_share_destroy(&crew->share);
}

int pl_crew_plan(pl_crew *crew, const planish_options *options, planish_error *error) {
    const pl_share *share = &crew->share;
    return pl_share_explain(share, planish_plan_create(&share->mesh, options, &crew->plan, error),
                            error);
}

static int create_plan(pl_crew *crew, const planish_mesh *whole, const planish_options *options,
                       planish_error *error) {
    const planish_options mine = pl_crew_options(crew, options);
    int code = pl_crew_agree(crew, check_options(&mine, error), error);
    if (!code)
        code = pl_crew_agree(crew, pl_share_create(&crew->share, crew->exchange_comm, whole, error),
                             error);
    if (!code)
        code = pl_crew_agree(crew, pl_crew_plan(crew, &mine, error), error);
    if (code)
        pl_crew_destroy_plan(crew);
    return code;
}

static int get_free(const pl_crew *crew, uint8_t *whole, planish_error *error) {
    uint8_t *mine = pl_new_array(crew->share.mesh.n_nodes, 1),
            *own = pl_new_array(crew->share.own_nodes.n, 1);
    int code = mine && own ? PLANISH_OK : fail_memory(error);
    int64_t n = 0;
    if (!code)
        planish_plan_get_free(crew->plan, mine);
    for (int64_t i = 0; !code && i < crew->share.mesh.n_nodes; i++)
        if (crew->share.role[i] != PLANISH_GHOST)
            own[n++] = mine[i];
    code = collect(crew, code, &crew->share.own_nodes, own, 1, whole, error);
    free(mine);
    free(own);
    return code;
}

int pl_crew_measure(const pl_crew *crew, planish_quality *quality, planish_error *error) {
    const pl_share *share = &crew->share;
    const int code =
        pl_crew_agree(crew, planish_measure(crew->plan, share->coordinates, quality, error), error);
    if (code)
        return code;
    int64_t worst =
        quality->worst_element >= 0 ? share->element_number[quality->worst_element] : INT64_MAX;
    MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_INT64_T, MPI_MIN, crew->comm);
    quality->worst_element = worst < INT64_MAX ? worst : -1;
    return PLANISH_OK;
}

static int measure_elements(const pl_crew *crew, double *whole, planish_error *error) {
    const pl_share *share = &crew->share;
    double *ratio = pl_new_array(share->mesh.n_elements, sizeof *ratio);
    int code = ratio ? planish_measure_elements(crew->plan, share->coordinates, ratio, error)
                     : fail_memory(error);
    int64_t n = 0;
    for (int64_t i = 0; !code && i < share->mesh.n_elements; i++)
        if (share->is_counted[i])
            ratio[n++] = ratio[i];
    code = collect(crew, code, &share->counted_elements, ratio, sizeof *ratio, whole, error);
    free(ratio);
    return code;
}

/** States of the elements: the worst that any process knows of each, as some see more of what is
 *  around them. */
static int collect_states(const pl_crew *crew, int code, const uint8_t *state, uint8_t *whole,
                          planish_error *error) {
    return collect(crew, code, &crew->share.all_elements, state, 1, whole, error);
}

/** planish_check_volumes_until, or planish_find_unfixable_until. */
typedef int look_until(const planish_plan *plan, const double *coordinates,
                       const planish_options *options, uint8_t *state, int64_t *n,
                       int64_t *n_undecided, planish_error *error);

/** What look says of the elements; *n_undecided: those of all processes, some of them counted
 *  twice. */
static int find_states(const pl_crew *crew, look_until *look, const planish_options *options,
                       uint8_t *whole, int64_t *n_undecided, planish_error *error) {
    const planish_options mine = pl_crew_options(crew, options);
    uint8_t *state = pl_new_array(crew->share.mesh.n_elements, 1);
    int64_t n;
    *n_undecided = 0;
    int code = state
                   ? look(crew->plan, crew->share.coordinates, &mine, state, &n, n_undecided, error)
                   : fail_memory(error);
    code = collect_states(crew, code, state, whole, error);
    if (!code)
        MPI_Allreduce(MPI_IN_PLACE, n_undecided, 1, MPI_INT64_T, MPI_SUM, crew->comm);
    free(state);
    return code;
}

static int find_reversed(const pl_crew *crew, uint8_t *whole, planish_error *error) {
    uint8_t *state = pl_new_array(crew->share.mesh.n_elements, 1);
    int64_t n;
    int code = state ? planish_find_reversed(crew->plan, crew->share.coordinates, state, &n, error)
                     : fail_memory(error);
    code = collect_states(crew, code, state, whole, error);
    free(state);
    return code;
}

/** Coordinates of the nodes that each process moves, to whole. */
static int collect_coordinates(pl_crew *crew, double *whole, planish_error *error) {
    const pl_share *share = &crew->share;
    const int dim = share->mesh.dim;
    double *own = pl_new_array((int64_t)share->own_nodes.n * dim, sizeof *own);
    int64_t n = 0;
    for (int64_t i = 0; own && i < share->mesh.n_nodes; i++)
        if (share->role[i] != PLANISH_GHOST)
            memcpy(own + dim * n++, share->coordinates + dim * i, (size_t)dim * sizeof *own);
    const int code = collect(crew, own ? PLANISH_OK : fail_memory(error), &share->own_nodes, own,
                             dim * (int)sizeof *own, whole, error);
    free(own);
    return code;
}

/** What all processes have sent since the last call, in the first one. */
static void add_up_traffic(pl_crew *crew, pl_traffic *traffic) {
    pl_traffic *mine = &crew->share.exchange.traffic;
    int64_t sums[] = {mine->messages, mine->nodes, mine->bytes};
    double wait = mine->wait_seconds;
    MPI_Allreduce(MPI_IN_PLACE, sums, 3, MPI_INT64_T, MPI_SUM, crew->comm);
    MPI_Allreduce(MPI_IN_PLACE, &wait, 1, MPI_DOUBLE, MPI_MAX, crew->comm);
    *mine = (pl_traffic){0};
    *traffic = (pl_traffic){crew->n_ranks, 1, sums[0], sums[1], sums[2], wait};
}

int pl_crew_smooth(pl_crew *crew, const planish_options *options, planish_result *result,
                   pl_traffic *traffic, planish_error *error) {
    crew->share.exchange.traffic = (pl_traffic){0}; /* of smoothing alone */
    const int code = pl_crew_agree(
        crew, planish_smooth(crew->plan, crew->share.coordinates, options, result, error), error);
    add_up_traffic(crew, traffic);
    return code;
}

static int smooth(pl_crew *crew, const planish_options *options, double *whole,
                  planish_result *result, pl_traffic *traffic, planish_error *error) {
    const planish_options mine = pl_crew_options(crew, options);
    const int code = pl_crew_smooth(crew, &mine, result, traffic, error);
    return code ? code : collect_coordinates(crew, whole, error);
}

/** Write whole as PETSc does, to path. */
static int write_plex(pl_crew *crew, const planish_mesh *whole, const int32_t *region,
                      const char *path, planish_error *error) {
    char *name = pl_new_array(PL_TEMPORARY_SIZE, 1);
    int code = name ? PLANISH_OK : fail_memory(error);
    if (!code && path)
        snprintf(name, PL_TEMPORARY_SIZE, "%s", path);
    code = pl_crew_agree(crew, code, error);
    if (!code) {
        MPI_Bcast(name, PL_TEMPORARY_SIZE, MPI_BYTE, 0, crew->comm);
        pl_plexout out;
        code = pl_crew_agree(
            crew, pl_plexfile_convert(crew->exchange_comm, whole, region, name, &out, error),
            error);
        crew->is_broken = code != 0;
        code = pl_crew_agree(crew, pl_plexfile_finish(&out, code, error), error);
    }
    free(name);
    return code;
}

/* ---- the engine of the first process -------------------------------------------------------- */

static pl_crew *crew_of(const pl_job *job) {
    return (pl_crew *)(uintptr_t)job->engine;
}

/** Let the others wait, and do it all here. */
static int work_alone(pl_job *job, const planish_error *why, planish_error *error) {
    pl_crew *crew = crew_of(job);
    if (crew->n_ranks > 1 && job->arguments->verbosity != PL_QUIET)
        pl_note(stderr, "%s: one process of %d does it all: %s", job->arguments->input,
                crew->n_ranks, why->text);
    tell(crew, DESTROY);
    pl_crew_destroy_plan(crew);
    crew->is_alone = 1;
    crew->engine.get_held = pl_engine_here.get_held; /* in parts nobody has all reasons */
    job->traffic = (pl_traffic){.n_processes = crew->n_ranks};
    return pl_engine_here.plan_create(job, error);
}

/** By their numbers in the file, which the processes will not know. */
static int check_elements(const planish_mesh *mesh, planish_error *error) {
    int code = PLANISH_OK;
    for (int64_t i = 0; i < mesh->n_elements && !code; i++)
        code = pl_check_element(mesh, i, error);
    return code;
}

static int lead_get_free(const pl_job *job, uint8_t *is_free, planish_error *error) {
    pl_crew *crew = crew_of(job);
    if (crew->is_alone)
        return pl_engine_here.get_free(job, is_free, error);
    memset(is_free, 0, (size_t)job->mesh.n_nodes);
    tell(crew, GET_FREE);
    return get_free(crew, is_free, error);
}

/** Each part is smoothed as if it had no periodic nodes: those must not move. */
static int check_periodic(const pl_job *job, planish_error *error) {
    const planish_mesh *mesh = &job->mesh;
    if (mesh->n_periodic == 0)
        return PLANISH_OK;
    uint8_t *is_free = pl_new_array(mesh->n_nodes, 1);
    if (!is_free)
        return fail_memory(error);
    int code = lead_get_free(job, is_free, error);
    for (int64_t i = 0; !code && i < 2 * mesh->n_periodic; i++) {
        const int32_t node = mesh->periodic[i];
        if (is_free[node] || (mesh->constraint && mesh->constraint[node] >= PLANISH_ON_PLANE)) {
            *error = (planish_error){PLANISH_ERROR_PARTS, -1, -1, "its periodic sides can move"};
            code = error->code;
        }
    }
    free(is_free);
    return code;
}

static int lead_create(pl_job *job, planish_error *error) {
    pl_crew *crew = crew_of(job);
    if (check_elements(&job->mesh, error))
        return error->code;
    tell(crew, CREATE);
    int code = create_plan(crew, &job->mesh, &job->options, error);
    if (!code) {
        planish_plan_get_info(crew->plan, &job->plan_info);
        code = check_periodic(job, error);
    }
    if (code != PLANISH_ERROR_PARTS)
        return code;
    const planish_error why = *error;
    return work_alone(job, &why, error);
}

static void lead_destroy(pl_job *job) {
    pl_crew *crew = crew_of(job);
    pl_engine_here.plan_destroy(job);
    if (!crew->plan)
        return;
    tell(crew, DESTROY);
    pl_crew_destroy_plan(crew);
}

static int lead_measure(const pl_job *job, planish_quality *quality, planish_error *error) {
    pl_crew *crew = crew_of(job);
    if (crew->is_alone)
        return pl_engine_here.measure(job, quality, error);
    tell(crew, MEASURE);
    return pl_crew_measure(crew, quality, error);
}

static int lead_measure_elements(const pl_job *job, double *ratio, planish_error *error) {
    pl_crew *crew = crew_of(job);
    if (crew->is_alone)
        return pl_engine_here.measure_elements(job, ratio, error);
    tell(crew, MEASURE_ELEMENTS);
    return measure_elements(crew, ratio, error);
}

static int count_states(const pl_job *job, const uint8_t *state, int64_t *n) {
    *n = 0;
    for (int64_t i = 0; i < job->mesh.n_elements; i++)
        *n += state[i] != 0;
    return PLANISH_OK;
}

static int lead_check_volumes(const pl_job *job, const planish_options *options, uint8_t *state,
                              int64_t *n_below, int64_t *n_undecided, planish_error *error) {
    pl_crew *crew = crew_of(job);
    if (crew->is_alone)
        return pl_engine_here.check_volumes(job, options, state, n_below, n_undecided, error);
    uint8_t *all = state ? state : pl_new_array(job->mesh.n_elements, 1);
    if (!all)
        return fail_memory(error);
    memset(all, 0, (size_t)job->mesh.n_elements);
    tell(crew, CHECK_VOLUMES);
    const int code =
        find_states(crew, planish_check_volumes_until, options, all, n_undecided, error);
    if (!code)
        count_states(job, all, n_below);
    if (!state)
        free(all);
    return code;
}

static int lead_find_unfixable(const pl_job *job, const planish_options *options, uint8_t *state,
                               int64_t *n, int64_t *n_undecided, planish_error *error) {
    pl_crew *crew = crew_of(job);
    if (crew->is_alone)
        return pl_engine_here.find_unfixable(job, options, state, n, n_undecided, error);
    memset(state, 0, (size_t)job->mesh.n_elements);
    tell(crew, FIND_UNFIXABLE);
    const int code =
        find_states(crew, planish_find_unfixable_until, options, state, n_undecided, error);
    return code ? code : count_states(job, state, n);
}

static int lead_find_reversed(const pl_job *job, uint8_t *state, int64_t *n, planish_error *error) {
    pl_crew *crew = crew_of(job);
    if (crew->is_alone)
        return pl_engine_here.find_reversed(job, state, n, error);
    memset(state, 0, (size_t)job->mesh.n_elements);
    tell(crew, FIND_REVERSED);
    const int code = find_reversed(crew, state, error);
    return code ? code : count_states(job, state, n);
}

static int lead_smooth(pl_job *job, planish_result *result, planish_error *error) {
    pl_crew *crew = crew_of(job);
    if (crew->is_alone)
        return pl_engine_here.smooth(job, result, error);
    tell(crew, SMOOTH);
    return smooth(crew, &job->options, planish_file_coordinates(job->file), result, &job->traffic,
                  error);
}

static int lead_write(const pl_job *job, const char *path, planish_error *error) {
    if (job->arguments->verbosity != PL_QUIET)
        pl_note(stderr,
                "%s: PETSc's file has elements, their regions and nodes; other groups, and what "
                "the file held, "
                "are left out of it",
                path);
    tell(crew_of(job), WRITE);
    return write_plex(crew_of(job), &job->mesh, planish_file_surface(job->file, NULL).region, path,
                      error);
}

/* ---- the crew ------------------------------------------------------------------------------- */

void pl_crew_create(pl_crew *crew, int threads, int bind) {
    *crew = (pl_crew){.engine = {.plan_create = lead_create,
                                 .plan_destroy = lead_destroy,
                                 .get_free = lead_get_free,
                                 .measure = lead_measure,
                                 .measure_elements = lead_measure_elements,
                                 .check_volumes = lead_check_volumes,
                                 .find_unfixable = lead_find_unfixable,
                                 .find_reversed = lead_find_reversed,
                                 .smooth = lead_smooth,
                                 .can_write = pl_plexfile_is,
                                 .write = lead_write},
                      .threads = threads,
                      .bind = bind};
    MPI_Comm_dup(MPI_COMM_WORLD, &crew->comm);
    MPI_Comm_dup(MPI_COMM_WORLD, &crew->exchange_comm);
    MPI_Comm_rank(crew->comm, &crew->rank);
    MPI_Comm_size(crew->comm, &crew->n_ranks);
}

void pl_crew_destroy(pl_crew *crew, int status) {
    /* What there is to say has been said by then. */
    MPI_Allreduce(MPI_IN_PLACE, &crew->is_broken, 1, MPI_INT, MPI_MAX, crew->comm);
    if (crew->is_broken) {
        pl_signals_done(status);
        MPI_Abort(MPI_COMM_WORLD, status);
    }
    pl_crew_destroy_plan(crew);
    MPI_Comm_free(&crew->comm);
    MPI_Comm_free(&crew->exchange_comm);
}

int pl_crew_lead(pl_crew *crew, const pl_arguments *arguments) {
    int status = pl_smooth_by(arguments, &crew->engine);
    tell(crew, END);
    MPI_Bcast(&status, 1, MPI_INT, 0, crew->comm);
    return status;
}

int pl_crew_follow(pl_crew *crew) {
    planish_error error;
    planish_quality quality;
    planish_result result;
    pl_traffic traffic;
    int64_t n_undecided;
    int status = PL_EXIT_FAILED;
    /* Errors are those of all processes by now, and the first one tells of them. */
    for (;;)
        switch (listen(crew)) {
        case CREATE:
            create_plan(crew, NULL, NULL, &error);
            break;
        case DESTROY:
            pl_crew_destroy_plan(crew);
            break;
        case GET_FREE:
            get_free(crew, NULL, &error);
            break;
        case MEASURE:
            pl_crew_measure(crew, &quality, &error);
            break;
        case MEASURE_ELEMENTS:
            measure_elements(crew, NULL, &error);
            break;
        case CHECK_VOLUMES:
            find_states(crew, planish_check_volumes_until, NULL, NULL, &n_undecided, &error);
            break;
        case FIND_UNFIXABLE:
            find_states(crew, planish_find_unfixable_until, NULL, NULL, &n_undecided, &error);
            break;
        case FIND_REVERSED:
            find_reversed(crew, NULL, &error);
            break;
        case SMOOTH:
            smooth(crew, NULL, NULL, &result, &traffic, &error);
            break;
        case WRITE:
            write_plex(crew, NULL, NULL, NULL, &error);
            break;
        case END:
            MPI_Bcast(&status, 1, MPI_INT, 0, crew->comm);
            return status;
        }
}
