/* lead: the work of planish-mpi in all its processes. */
#include "mpi/lead.h"

#include "mpi/large.h"

#include "commands/commands.h"
#include "job/curved.h"
#include "terminal/message.h"

#include "base/status.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/** Orders of the first process: steps of pl_engine. */
typedef enum order {
    READ,
    CREATE_PLAN,
    DESTROY_PLAN,
    GET_FREE,
    MEASURE,
    MEASURE_ELEMENTS,
    FIND_STATES,
    SMOOTH,
    WRITE,
    END
} order;

static pl_crew *crew_of(const pl_job *job) {
    return (pl_crew *)(uintptr_t)job->engine;
}

/** Begin a step: the first process gives the order for it, which the others have received. */
static pl_crew *begin_step(const pl_job *job, order step) {
    pl_crew *crew = crew_of(job);
    if (crew->rank == 0)
        pl_crew_tell(crew, (int)step);
    return crew;
}

/* ---- steps, which all processes take at the same time ----------------------------------------
 *
 * The first process takes them as its engine, with its job; the others when it gives the order, with
 * a job that has an engine alone, and NULL for what the first one alone gets.
 */

static int read_mesh(pl_job *job, planish_error *error) {
    pl_crew *crew = begin_step(job, READ);
    const pl_plexfile *file = &crew->file;
    const int code = pl_large_read(crew, job->arguments ? job->arguments->input : NULL, error);
    job->mesh =
        (planish_mesh){.dim = file->dim, .n_nodes = file->n_nodes, .n_elements = file->n_elements};
    job->file_info.format = "dmplex";
    return code;
}

static int create_plan(pl_job *job, planish_error *error) {
    pl_crew *crew = begin_step(job, CREATE_PLAN);
    const pl_share *share = &crew->share;
    const planish_options mine = pl_crew_options(crew, &job->options);
    int code = PLANISH_OK;
    if (!crew->is_large && mine.precision == PLANISH_PRECISION_ROUNDED)
        /* The functions of planish_part cannot do that. */
        return pl_fail(error, PLANISH_ERROR_PARTS,
                       "only the process that read the file knows the digits of its text fields");
    if (crew->is_large)
        code = pl_large_share(crew, job->arguments, error);
    else
        code = pl_crew_agree(crew,
                             pl_share_create(&crew->share, crew->exchange_comm,
                                             crew->rank == 0 ? &job->mesh : NULL, error),
                             error);
    if (!code) {
        code = planish_plan_create(&share->mesh, &mine, &crew->plan, error);
        code = pl_crew_agree(crew, pl_share_explain(share, code, error), error);
    }
    if (code)
        pl_crew_destroy_plan(crew);
    return code;
}

static void destroy_plan(pl_job *job) {
    if (crew_of(job)->plan)
        pl_crew_destroy_plan(begin_step(job, DESTROY_PLAN));
}

/** Collect values in whole, which the first process has, if code says that there are any:
 * PLANISH_OK in all processes, or the same error. */
static int collect(const pl_crew *crew, int code, const pl_collection *c, const void *values,
                   int size, void *whole, planish_error *error) {
    void *room = code ? NULL : pl_new_array(c->gathering.n_all, (size_t)size);
    if (!code && !room)
        code = pl_fail_memory(error, "values of the whole mesh");
    code = pl_crew_agree(crew, code, error);
    if (!code)
        pl_collect(c, values, size, room, whole);
    free(room);
    return code;
}

static int get_free(const pl_job *job, uint8_t *is_free, planish_error *error) {
    const pl_crew *crew = begin_step(job, GET_FREE);
    uint8_t *mine = pl_new_array(crew->share.mesh.n_nodes, 1),
            *own = pl_new_array(crew->share.own_nodes.gathering.n, 1);
    int code = mine && own ? PLANISH_OK : pl_fail_memory(error, "values of the whole mesh");
    int64_t n = 0;
    if (!code)
        planish_plan_get_free(crew->plan, mine);
    for (int64_t i = 0; !code && i < crew->share.mesh.n_nodes; i++)
        if (crew->share.role[i] != PLANISH_ROLE_GHOST)
            own[n++] = mine[i];
    code = collect(crew, code, &crew->share.own_nodes, own, 1, is_free, error);
    free(mine);
    free(own);
    return code;
}

static int measure(const pl_job *job, planish_quality *quality, planish_error *error) {
    const pl_crew *crew = begin_step(job, MEASURE);
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

static int measure_elements(const pl_job *job, double *ratio, planish_error *error) {
    const pl_crew *crew = begin_step(job, MEASURE_ELEMENTS);
    const pl_share *share = &crew->share;
    double *mine = pl_new_array(share->mesh.n_elements, sizeof *mine);
    int code = mine ? planish_measure_elements(crew->plan, share->coordinates, mine, error)
                    : pl_fail_memory(error, "values of the whole mesh");
    int64_t n = 0;
    for (int64_t i = 0; !code && i < share->mesh.n_elements; i++)
        if (share->is_counted[i])
            mine[n++] = mine[i];
    code = collect(crew, code, &share->counted_elements, mine, sizeof *mine, ratio, error);
    free(mine);
    return code;
}

/** An element whose state is not 0. */
typedef struct found_element {
    int64_t number, state;
} found_element;

/** Take the largest of what processes say of an element: some see more of what is around it. */
static void take_found(const found_element *list, int n, uint8_t *state) {
    for (int i = 0; i < n; i++)
        if (list[i].state > state[list[i].number])
            state[list[i].number] = (uint8_t)list[i].state;
}

/** Gather the states that are not 0 in the first process: found->state [n_all], NULL if there are
 *  none, and found->n; mine: of this process's elements. One process after the other, for all of
 *  them may be more than messages count. */
static int gather_states(const pl_crew *crew, const uint8_t *mine, int64_t n_all, pl_states *found,
                         planish_error *error) {
    enum { TAG = 1 };
    const pl_share *share = &crew->share;
    const int is_first = crew->rank == 0;
    MPI_Datatype type;
    int n = 0, most;
    for (int64_t i = 0; i < share->mesh.n_elements; i++)
        n += mine[i] != 0;
    MPI_Allreduce(&n, &most, 1, MPI_INT, MPI_MAX, crew->comm);
    if (most == 0)
        return PLANISH_OK;
    found_element *list = pl_new_array(is_first ? most : n, sizeof *list);
    uint8_t *state = pl_new_array(is_first ? n_all : 0, 1);
    const int code = pl_crew_agree(
        crew, list && state ? PLANISH_OK : pl_fail_memory(error, "values of the whole mesh"),
        error);
    n = 0;
    for (int64_t i = 0; !code && i < share->mesh.n_elements; i++)
        if (mine[i])
            list[n++] = (found_element){share->element_number[i], mine[i]};
    MPI_Type_contiguous(2, MPI_INT64_T, &type);
    MPI_Type_commit(&type);
    if (!code && !is_first)
        MPI_Send(list, n, type, 0, TAG, crew->comm);
    if (!code && is_first)
        take_found(list, n, state);
    for (int k = 1; !code && is_first && k < crew->n_ranks; k++) {
        MPI_Status status;
        MPI_Recv(list, most, type, k, TAG, crew->comm, &status);
        MPI_Get_count(&status, type, &n);
        take_found(list, n, state);
    }
    MPI_Type_free(&type);
    free(list);
    if (!code && is_first)
        found->state = state;
    else
        free(state);
    for (int64_t i = 0; found->state && i < n_all; i++)
        found->n += state[i] != 0;
    return code;
}

/** n_undecided is that of all processes, some elements counted twice. */
static int find_states(const pl_job *job, pl_state_kind kind, const planish_options *options,
                       int with_state, pl_states *found, planish_error *error) {
    const pl_crew *crew = begin_step(job, FIND_STATES);
    const pl_share *share = &crew->share;
    int what[] = {(int)kind, with_state};
    MPI_Bcast(what, 2, MPI_INT, 0, crew->comm);
    const planish_options mine = pl_crew_options(crew, options);
    *found = (pl_states){.state = NULL};
    uint8_t *state = pl_new_array(share->mesh.n_elements, 1);
    int code = state ? pl_states_find(crew->plan, &share->mesh, (pl_state_kind)what[0], &mine,
                                      state, found, error)
                     : pl_fail_memory(error, "values of the whole mesh");
    code = pl_crew_agree(crew, code, error);
    found->n = 0;
    if (!code && what[1])
        code = gather_states(crew, state, job->mesh.n_elements, found, error);
    for (int64_t i = 0; !code && !what[1] && i < share->mesh.n_elements; i++)
        found->n += share->is_counted[i] && state[i];
    int64_t sums[] = {found->n, found->n_undecided};
    if (!code)
        MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_INT64_T, MPI_SUM, crew->comm);
    found->n = sums[0];
    found->n_undecided = sums[1];
    free(state);
    return code;
}

/** Coordinates of the nodes that each process moves, to whole. */
static int collect_coordinates(const pl_crew *crew, double *whole, planish_error *error) {
    const pl_share *share = &crew->share;
    const int dim = share->mesh.dim;
    double *own = pl_new_array((int64_t)share->own_nodes.gathering.n * dim, sizeof *own);
    int64_t n = 0;
    for (int64_t i = 0; own && i < share->mesh.n_nodes; i++)
        if (share->role[i] != PLANISH_ROLE_GHOST)
            memcpy(own + dim * n++, share->coordinates + dim * i, (size_t)dim * sizeof *own);
    const int code =
        collect(crew, own ? PLANISH_OK : pl_fail_memory(error, "values of the whole mesh"),
                &share->own_nodes, own, dim * (int)sizeof *own, whole, error);
    free(own);
    return code;
}

static int smooth(pl_job *job, planish_result *result, planish_error *error) {
    pl_crew *crew = begin_step(job, SMOOTH);
    const planish_options mine = pl_crew_options(crew, &job->options);
    pl_traffic *traffic = &crew->share.exchange.traffic;
    *traffic = (pl_traffic){0}; /* of smoothing alone */
    const int code = pl_crew_agree(
        crew, planish_smooth(crew->plan, crew->share.coordinates, &mine, result, error), error);
    /* What all processes have sent. */
    int64_t sums[] = {traffic->messages, traffic->nodes, traffic->bytes};
    double wait = traffic->wait_seconds;
    MPI_Allreduce(MPI_IN_PLACE, sums, 3, MPI_INT64_T, MPI_SUM, crew->comm);
    MPI_Allreduce(MPI_IN_PLACE, &wait, 1, MPI_DOUBLE, MPI_MAX, crew->comm);
    *traffic = (pl_traffic){0};
    job->traffic = (pl_traffic){crew->n_ranks, 1, sums[0], sums[1], sums[2], wait};
    if (code || crew->is_large)
        return code;
    return collect_coordinates(crew, job->file ? planish_file_coordinates(job->file) : NULL, error);
}

/** Write the whole mesh as PETSc does; of a large one the coordinates alone change. */
static int write_mesh(const pl_job *job, const char *output, uint64_t *checksums,
                      planish_error *error) {
    pl_crew *crew = begin_step(job, WRITE);
    const int is_first = crew->rank == 0;
    char path[PATH_MAX];
    pl_plexout out;
    if (is_first && job->file && job->arguments->verbosity != PL_QUIET)
        pl_note(stderr,
                "%s: PETSc's file keeps nodes, elements and their regions; other groups and "
                "fixed nodes are lost",
                output);
    pl_crew_path(crew, output, path);
    if (crew->is_large)
        return pl_large_write(crew, path, is_first && job->arguments->json ? checksums : NULL,
                              error);
    int code = pl_crew_agree(
        crew,
        pl_plexfile_convert(crew->exchange_comm, is_first ? &job->mesh : NULL,
                            is_first ? planish_file_surface(job->file, NULL).region : NULL, path,
                            &out, error),
        error);
    crew->is_broken = code != 0;
    return pl_crew_agree(crew, pl_plexfile_finish(&out, code, error), error);
}

/* ---- the first process ---------------------------------------------------------------------- */

/** Whether processes can share the mesh: each part is smoothed as if it had no periodic nodes, so
 *  those must not move. */
static int check_periodic(const pl_job *job, planish_error *error) {
    const planish_mesh *mesh = &job->mesh;
    if (mesh->n_periodic == 0)
        return PLANISH_OK;
    uint8_t *is_free = pl_new_array(mesh->n_nodes, 1);
    if (!is_free)
        return pl_fail_memory(error, "values of the whole mesh");
    int code = get_free(job, is_free, error);
    for (int64_t i = 0; !code && i < 2 * mesh->n_periodic; i++) {
        const int32_t node = mesh->periodic[i];
        if (is_free[node] ||
            (mesh->constraint && mesh->constraint[node] >= PLANISH_CONSTRAINT_ON_PLANE))
            code = pl_fail(error, PLANISH_ERROR_PARTS, "its periodic sides can move");
    }
    free(is_free);
    return code;
}

/** Find an element that has a node twice; here its number in the file is known. */
static int find_collapsed(const planish_mesh *mesh, planish_error *error) {
    const int corners = mesh->dim + 1;
    for (int64_t i = 0; mesh->elements && i < mesh->n_elements; i++)
        for (int j = 0; j < corners; j++)
            for (int k = 0; k < j; k++)
                if (mesh->elements[i * corners + j] == mesh->elements[i * corners + k])
                    return pl_fail_at(error, PLANISH_ERROR_MESH, i, mesh->elements[i * corners + j],
                                      "an element has a node twice");
    return PLANISH_OK;
}

/** Let this process do it all, while the others wait. why: they cannot share the mesh. */
static void work_alone(pl_job *job, const char *why) {
    pl_crew *crew = crew_of(job);
    if (crew->n_ranks > 1 && job->arguments->verbosity != PL_QUIET)
        pl_note(stderr, "%s: one process of %d does it all: %s", job->arguments->input,
                crew->n_ranks, why);
    crew->engine = pl_engine_here;
    crew->engine.can_write = pl_plexfile_is;
    crew->engine.write = write_mesh;
    job->traffic = (pl_traffic){.n_processes = crew->n_ranks};
}

/** Work alone if it is known from the options, or the elements, that processes cannot share the mesh. */
static void choose(pl_job *job) {
    if (job->is_surface) /* is refused */
        return;
    if (job->mesh.cells)
        work_alone(job, "its elements are not all straight simplices");
    else if (pl_curved_is_asked(job))
        work_alone(job, job->arguments->curved_if_any
                            ? "--best lets nodes slide on curved surfaces; with --best --slide "
                              "auto all processes share the mesh"
                            : "nodes slide on curved surfaces");
}

/** Make the plan by all processes, or by this one alone if they cannot share the mesh. */
static int lead_create(pl_job *job, planish_error *error) {
    pl_crew *crew = crew_of(job);
    if (find_collapsed(&job->mesh, error))
        return error->code;
    int code = create_plan(job, error);
    if (!code) {
        planish_plan_get_info(crew->plan, &job->plan_info);
        code = check_periodic(job, error);
    }
    if (code != PLANISH_ERROR_PARTS || crew->is_large)
        return code;
    destroy_plan(job);
    work_alone(job, error->text);
    return pl_engine_here.plan_create(job, error);
}

/** Ignore signals once all is told: mpirun ends this process when another one has ended with an error. */
static void ignore_signals(void) {
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP, SIGPIPE};
    for (size_t i = 0; i < sizeof signals / sizeof *signals; i++)
        signal(signals[i], SIG_IGN);
}

int pl_crew_lead(pl_crew *crew, const pl_arguments *arguments) {
    crew->engine = (pl_engine){.read = pl_large_can(arguments) ? read_mesh : NULL,
                               .choose = choose,
                               .plan_create = lead_create,
                               .plan_destroy = destroy_plan,
                               .get_free = get_free,
                               .measure = measure,
                               .measure_elements = measure_elements,
                               .find_states = find_states,
                               .smooth = smooth,
                               .can_write = pl_plexfile_is,
                               .write = write_mesh};
    int status = pl_smooth_by(arguments, &crew->engine);
    ignore_signals();
    pl_crew_tell(crew, END);
    MPI_Bcast(&status, 1, MPI_INT, 0, crew->comm);
    return status;
}

/* ---- the others ----------------------------------------------------------------------------- */

int pl_crew_follow(pl_crew *crew) {
    pl_job job = {.engine = &crew->engine};
    planish_quality quality;
    planish_result result;
    pl_states states;
    planish_error error; /* is that of all processes, and the first one tells of it */
    int status = PL_EXIT_FAILED;
    planish_options_init(&job.options); /* those of the first process take their place */
    for (int step; (step = pl_crew_listen(crew)) != END;)
        switch ((order)step) {
        case READ:
            read_mesh(&job, &error);
            break;
        case CREATE_PLAN:
            create_plan(&job, &error);
            break;
        case DESTROY_PLAN:
            destroy_plan(&job);
            break;
        case GET_FREE:
            get_free(&job, NULL, &error);
            break;
        case MEASURE:
            measure(&job, &quality, &error);
            break;
        case MEASURE_ELEMENTS:
            measure_elements(&job, NULL, &error);
            break;
        case FIND_STATES:
            find_states(&job, PL_STATE_VOLUME, &job.options, 0, &states, &error);
            break;
        case SMOOTH:
            smooth(&job, &result, &error);
            break;
        case WRITE:
            write_mesh(&job, NULL, NULL, &error);
            break;
        case END:
            break;
        }
    MPI_Bcast(&status, 1, MPI_INT, 0, crew->comm);
    return status;
}
