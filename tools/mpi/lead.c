/* lead: the work of planish-mpi in all its processes. */
#include "mpi/lead.h"

#include "mpi/large.h"

#include "commands/commands.h"
#include "terminal/message.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/** Orders of the first process. */
typedef enum order_kind {
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
} order_kind;

/** An order with its data: pointers are those of the first process, NULL in the others, but for
 * error. */
typedef struct order {
    const pl_job *job;
    const planish_options *options;
    pl_state_kind kind;
    int with_state;
    const char *path;
    void *whole; /* values of all nodes or elements */
    uint64_t *checksums;
    pl_states states;
    planish_quality quality;
    planish_result result;
    pl_traffic traffic;
    planish_error *error;
} order;

static int fail_memory(planish_error *error) {
    *error = (planish_error){PLANISH_ERROR_MEMORY, -1, -1, "out of memory for what is collected"};
    return PLANISH_ERROR_MEMORY;
}

/* ---- what each process does, all of them at the same time ------------------------------------ */

static int read_mesh(pl_crew *crew, order *o) {
    return pl_large_read(crew, o->path, o->error);
}

static int create_plan(pl_crew *crew, order *o) {
    const pl_share *share = &crew->share;
    const planish_options mine = pl_crew_options(crew, o->options);
    int code = PLANISH_OK;
    if (!crew->is_large && mine.precision == PLANISH_ROUNDED) {
        /* The functions of planish_part cannot do that. */
        *o->error = (planish_error){
            PLANISH_ERROR_PARTS, -1, -1,
            "only the process that read the file knows the digits of its text fields"};
        return PLANISH_ERROR_PARTS;
    }
    if (crew->is_large)
        code = pl_large_share(crew, o->job ? o->job->arguments : NULL, o->error);
    else
        code = pl_crew_agree(crew,
                             pl_share_create(&crew->share, crew->exchange_comm,
                                             o->job ? &o->job->mesh : NULL, o->error),
                             o->error);
    if (!code) {
        code = planish_plan_create(&share->mesh, &mine, &crew->plan, o->error);
        code = pl_crew_agree(crew, pl_share_explain(share, code, o->error), o->error);
    }
    if (code)
        pl_crew_destroy_plan(crew);
    return code;
}

static int destroy_plan(pl_crew *crew, order *o) {
    (void)o;
    pl_crew_destroy_plan(crew);
    return PLANISH_OK;
}

/** Collect values in the first process, if code says that there are any: PLANISH_OK in all
 * processes, or the same error. */
static int collect(const pl_crew *crew, int code, const pl_collection *c, const void *values,
                   int size, order *o) {
    void *room = code ? NULL : pl_new_array(pl_collected(c), (size_t)size);
    if (!code && !room)
        code = fail_memory(o->error);
    code = pl_crew_agree(crew, code, o->error);
    if (!code)
        pl_collect(c, values, size, room, o->whole);
    free(room);
    return code;
}

static int get_free(pl_crew *crew, order *o) {
    uint8_t *mine = pl_new_array(crew->share.mesh.n_nodes, 1),
            *own = pl_new_array(crew->share.own_nodes.n, 1);
    int code = mine && own ? PLANISH_OK : fail_memory(o->error);
    int64_t n = 0;
    if (!code)
        planish_plan_get_free(crew->plan, mine);
    for (int64_t i = 0; !code && i < crew->share.mesh.n_nodes; i++)
        if (crew->share.role[i] != PLANISH_GHOST)
            own[n++] = mine[i];
    code = collect(crew, code, &crew->share.own_nodes, own, 1, o);
    free(mine);
    free(own);
    return code;
}

static int measure(pl_crew *crew, order *o) {
    const pl_share *share = &crew->share;
    planish_quality *quality = &o->quality;
    const int code = pl_crew_agree(
        crew, planish_measure(crew->plan, share->coordinates, quality, o->error), o->error);
    if (code)
        return code;
    int64_t worst =
        quality->worst_element >= 0 ? share->element_number[quality->worst_element] : INT64_MAX;
    MPI_Allreduce(MPI_IN_PLACE, &worst, 1, MPI_INT64_T, MPI_MIN, crew->comm);
    quality->worst_element = worst < INT64_MAX ? worst : -1;
    return PLANISH_OK;
}

static int measure_elements(pl_crew *crew, order *o) {
    const pl_share *share = &crew->share;
    double *ratio = pl_new_array(share->mesh.n_elements, sizeof *ratio);
    int code = ratio ? planish_measure_elements(crew->plan, share->coordinates, ratio, o->error)
                     : fail_memory(o->error);
    int64_t n = 0;
    for (int64_t i = 0; !code && i < share->mesh.n_elements; i++)
        if (share->is_counted[i])
            ratio[n++] = ratio[i];
    code = collect(crew, code, &share->counted_elements, ratio, sizeof *ratio, o);
    free(ratio);
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

/** Gather the states that are not 0 in the first process: o->states.state, NULL if there are none;
 *  mine: of this process's elements. One process after the other, for all of them may be more than
 *  messages count. */
static int gather_states(const pl_crew *crew, const uint8_t *mine, order *o) {
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
    const int64_t n_all = is_first ? o->job->mesh.n_elements : 0;
    found_element *list = pl_new_array(is_first ? most : n, sizeof *list);
    uint8_t *state = pl_new_array(n_all, 1);
    const int code =
        pl_crew_agree(crew, list && state ? PLANISH_OK : fail_memory(o->error), o->error);
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
        o->states.state = state;
    else
        free(state);
    for (int64_t i = 0; o->states.state && i < n_all; i++)
        o->states.n += state[i] != 0;
    return code;
}

/** n_undecided is that of all processes, some elements counted twice. */
static int find_states(pl_crew *crew, order *o) {
    const pl_share *share = &crew->share;
    int what[] = {(int)o->kind, o->with_state};
    MPI_Bcast(what, 2, MPI_INT, 0, crew->comm);
    const planish_options mine = pl_crew_options(crew, o->options);
    uint8_t *state = pl_new_array(share->mesh.n_elements, 1);
    int code = state ? pl_states_find(crew->plan, &share->mesh, (pl_state_kind)what[0], &mine,
                                      state, &o->states, o->error)
                     : fail_memory(o->error);
    code = pl_crew_agree(crew, code, o->error);
    o->states.n = 0;
    if (!code && what[1])
        code = gather_states(crew, state, o);
    for (int64_t i = 0; !code && !what[1] && i < share->mesh.n_elements; i++)
        o->states.n += share->is_counted[i] && state[i];
    int64_t sums[] = {o->states.n, o->states.n_undecided};
    if (!code)
        MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_INT64_T, MPI_SUM, crew->comm);
    o->states.n = sums[0];
    o->states.n_undecided = sums[1];
    free(state);
    return code;
}

/** Coordinates of the nodes that each process moves, to whole. */
static int collect_coordinates(pl_crew *crew, order *o) {
    const pl_share *share = &crew->share;
    const int dim = share->mesh.dim;
    double *own = pl_new_array((int64_t)share->own_nodes.n * dim, sizeof *own);
    int64_t n = 0;
    for (int64_t i = 0; own && i < share->mesh.n_nodes; i++)
        if (share->role[i] != PLANISH_GHOST)
            memcpy(own + dim * n++, share->coordinates + dim * i, (size_t)dim * sizeof *own);
    const int code = collect(crew, own ? PLANISH_OK : fail_memory(o->error), &share->own_nodes, own,
                             dim * (int)sizeof *own, o);
    free(own);
    return code;
}

static int smooth(pl_crew *crew, order *o) {
    const planish_options mine = pl_crew_options(crew, o->options);
    pl_traffic *traffic = &crew->share.exchange.traffic;
    *traffic = (pl_traffic){0}; /* of smoothing alone */
    const int code = pl_crew_agree(
        crew, planish_smooth(crew->plan, crew->share.coordinates, &mine, &o->result, o->error),
        o->error);
    /* What all processes have sent. */
    int64_t sums[] = {traffic->messages, traffic->nodes, traffic->bytes};
    double wait = traffic->wait_seconds;
    MPI_Allreduce(MPI_IN_PLACE, sums, 3, MPI_INT64_T, MPI_SUM, crew->comm);
    MPI_Allreduce(MPI_IN_PLACE, &wait, 1, MPI_DOUBLE, MPI_MAX, crew->comm);
    *traffic = (pl_traffic){0};
    o->traffic = (pl_traffic){crew->n_ranks, 1, sums[0], sums[1], sums[2], wait};
    return code || crew->is_large ? code : collect_coordinates(crew, o);
}

/** Write the whole mesh as PETSc does; of a large one the coordinates alone change. */
static int write_mesh(pl_crew *crew, order *o) {
    const pl_job *job = o->job;
    char path[PATH_MAX];
    pl_plexout out;
    pl_crew_path(crew, o->path, path);
    if (crew->is_large)
        return pl_large_write(crew, path, o->checksums, o->error);
    int code =
        pl_crew_agree(crew,
                      pl_plexfile_convert(crew->exchange_comm, job ? &job->mesh : NULL,
                                          job ? planish_file_surface(job->file, NULL).region : NULL,
                                          path, &out, o->error),
                      o->error);
    crew->is_broken = code != 0;
    return pl_crew_agree(crew, pl_plexfile_finish(&out, code, o->error), o->error);
}

static int (*const carry_out[])(pl_crew *crew, order *o) = {
    [READ] = read_mesh,          [CREATE_PLAN] = create_plan, [DESTROY_PLAN] = destroy_plan,
    [GET_FREE] = get_free,       [MEASURE] = measure,         [MEASURE_ELEMENTS] = measure_elements,
    [FIND_STATES] = find_states, [SMOOTH] = smooth,           [WRITE] = write_mesh};

/* ---- the engine of the first process -------------------------------------------------------- */

static pl_crew *crew_of(const pl_job *job) {
    return (pl_crew *)(uintptr_t)job->engine;
}

/** Give the order, and carry it out here. */
static int give_order(const pl_job *job, order_kind kind, order *o) {
    pl_crew *crew = crew_of(job);
    o->job = job;
    pl_crew_tell(crew, (int)kind);
    return carry_out[kind](crew, o);
}

static int lead_read(pl_job *job, planish_error *error) {
    order o = {.path = job->arguments->input, .error = error};
    const int code = give_order(job, READ, &o);
    const pl_plexfile *file = &crew_of(job)->file;
    job->mesh =
        (planish_mesh){.dim = file->dim, .n_nodes = file->n_nodes, .n_elements = file->n_elements};
    job->file_info.format = "dmplex";
    return code;
}

static int lead_get_free(const pl_job *job, uint8_t *is_free, planish_error *error) {
    order o = {.whole = is_free, .error = error};
    memset(is_free, 0, (size_t)job->mesh.n_nodes);
    return give_order(job, GET_FREE, &o);
}

/** Whether processes can share the mesh: each part is smoothed as if it had no periodic nodes, so
 *  those must not move. */
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

/** Find an element that has a node twice; here its number in the file is known. */
static int find_collapsed(const planish_mesh *mesh, planish_error *error) {
    const int corners = mesh->dim + 1;
    for (int64_t i = 0; mesh->elements && i < mesh->n_elements; i++)
        for (int j = 0; j < corners; j++)
            for (int k = 0; k < j; k++)
                if (mesh->elements[i * corners + j] == mesh->elements[i * corners + k]) {
                    *error = (planish_error){PLANISH_ERROR_MESH, i, mesh->elements[i * corners + j],
                                             "an element has a node twice"};
                    return error->code;
                }
    return PLANISH_OK;
}

static void lead_destroy(pl_job *job) {
    order o = {.error = NULL};
    if (crew_of(job)->plan)
        give_order(job, DESTROY_PLAN, &o);
}

static int lead_write(const pl_job *job, const char *path, uint64_t *checksums,
                      planish_error *error) {
    order o = {.path = path, .error = error};
    if (!job->file && job->arguments->json)
        o.checksums = checksums;
    if (job->file && job->arguments->verbosity != PL_QUIET)
        pl_note(stderr,
                "%s: PETSc's file keeps nodes, elements and their regions; other groups and "
                "fixed nodes are lost",
                path);
    return give_order(job, WRITE, &o);
}

static int lead_create(pl_job *job, planish_error *error) {
    pl_crew *crew = crew_of(job);
    order o = {.options = &job->options, .error = error};
    if (find_collapsed(&job->mesh, error))
        return error->code;
    int code = give_order(job, CREATE_PLAN, &o);
    if (!code) {
        planish_plan_get_info(crew->plan, &job->plan_info);
        code = check_periodic(job, error);
    }
    if (code != PLANISH_ERROR_PARTS || crew->is_large)
        return code;
    /* The others wait, and this one does it all. */
    if (crew->n_ranks > 1 && job->arguments->verbosity != PL_QUIET)
        pl_note(stderr, "%s: one process of %d does it all: %s", job->arguments->input,
                crew->n_ranks, error->text);
    lead_destroy(job);
    crew->engine = pl_engine_here;
    crew->engine.can_write = pl_plexfile_is;
    crew->engine.write = lead_write;
    job->traffic = (pl_traffic){.n_processes = crew->n_ranks};
    return pl_engine_here.plan_create(job, error);
}

static int lead_measure(const pl_job *job, planish_quality *quality, planish_error *error) {
    order o = {.error = error};
    const int code = give_order(job, MEASURE, &o);
    *quality = o.quality;
    return code;
}

static int lead_measure_elements(const pl_job *job, double *ratio, planish_error *error) {
    order o = {.whole = ratio, .error = error};
    return give_order(job, MEASURE_ELEMENTS, &o);
}

static int lead_find_states(const pl_job *job, pl_state_kind kind, const planish_options *options,
                            int with_state, pl_states *found, planish_error *error) {
    order o = {.kind = kind, .options = options, .with_state = with_state, .error = error};
    const int code = give_order(job, FIND_STATES, &o);
    *found = o.states;
    return code;
}

static int lead_smooth(pl_job *job, planish_result *result, planish_error *error) {
    order o = {.options = &job->options, .error = error};
    o.whole = job->file ? planish_file_coordinates(job->file) : NULL;
    const int code = give_order(job, SMOOTH, &o);
    *result = o.result;
    job->traffic = o.traffic;
    return code;
}

int pl_crew_lead(pl_crew *crew, const pl_arguments *arguments) {
    crew->engine = (pl_engine){.read = pl_large_can(arguments) ? lead_read : NULL,
                               .plan_create = lead_create,
                               .plan_destroy = lead_destroy,
                               .get_free = lead_get_free,
                               .measure = lead_measure,
                               .measure_elements = lead_measure_elements,
                               .find_states = lead_find_states,
                               .smooth = lead_smooth,
                               .can_write = pl_plexfile_is,
                               .write = lead_write};
    int status = pl_smooth_by(arguments, &crew->engine);
    pl_crew_tell(crew, END);
    MPI_Bcast(&status, 1, MPI_INT, 0, crew->comm);
    return status;
}

int pl_crew_follow(pl_crew *crew) {
    int status = PL_EXIT_FAILED;
    for (int kind; (kind = pl_crew_listen(crew)) != END;) {
        /* An error is that of all processes by now, and the first one tells of it. */
        planish_error error;
        order o = {.error = &error};
        carry_out[kind](crew, &o);
    }
    MPI_Bcast(&status, 1, MPI_INT, 0, crew->comm);
    return status;
}
