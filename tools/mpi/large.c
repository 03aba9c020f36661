/* large: `planish smooth` on a mesh in PETSc's file, of which the program has no copy.
 *
 * The steps are those of tools/commands/smooth.c; all processes take them, and the first one tells
 * of them.
 */
#include "mpi/large.h"

#include "mpi/plexfile.h"
#include "mpi/plexrows.h"
#include "mpi/surface.h"

#include "terminal/message.h"
#include "job/output.h"
#include "job/progress.h"
#include "terminal/signals.h"
#include "commands/smooth.h"
#include "terminal/text.h"

#include "base/clock.h"
#include "base/system.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/** The work under way. job, result and progress are told of by the first process. */
typedef struct work {
    pl_crew *crew;
    const pl_arguments *arguments; /* NULL: not the first process */
    char *input, *output;          /* paths, owned */
    planish_options options;
    double slide_tolerance;
    int wants_checksums;
    pl_plexfile file;
    pl_job job;
    pl_result result;
    uint8_t *reversed_before; /* this process's elements, owned, or NULL: none in any process */
    pl_progress progress;
    planish_error error;
    int is_usage; /* error is one of the command line */
} work;

/* ---- the command line ----------------------------------------------------------------------- */

/** What needs names of groups, or looks at all of the mesh. */
static int asks_for_all(const pl_arguments *a) {
    return a->n_fix > 0 || a->fix_layers || a->n_slide_tags > 0 || a->n_min_volumes > 0 ||
           a->n_regions > 0 || a->report || (a->format && strcmp(a->format, "dmplex") != 0);
}

/** Whether the mesh is too large for the first process; or what PETSC_OPTIONS say. */
static int wants_parts(const char *path) {
    enum { SHARE = 8 }; /* of the memory: a mesh takes two to four times its file there */
    PetscBool wants = PETSC_FALSE, is_given = PETSC_FALSE;
    pl_file_status status;
    PetscOptionsGetBool(NULL, NULL, "-planish_load_in_parts", &wants, &is_given);
    return is_given ? wants == PETSC_TRUE
                    : pl_file_find(path, &status) == 0 && status.size > pl_system_memory() / SHARE;
}

int pl_large_can(const pl_arguments *a) {
    pl_plexform form;
    if (!pl_plexfile_is(a->input) || !wants_parts(a->input))
        return 0;
    const char *why = !pl_plexfile_is(a->output) ? "what is written is no .h5"
                      : asks_for_all(a) ? "options name groups, or want a page or another format"
                                        : pl_plexrows_refusal(a->input, &form);
    if (why && why[0] && a->verbosity != PL_QUIET)
        pl_note(stderr, "%s: one process has all of the mesh: %s", a->input, why);
    return !why;
}

/* ---- what the first process says ------------------------------------------------------------ */

/** The first process's text, in all; owned. */
static char *share_text(const pl_crew *crew, const char *text) {
    int64_t length = text ? (int64_t)strlen(text) : 0;
    MPI_Bcast(&length, 1, MPI_INT64_T, 0, crew->comm);
    char *mine = pl_new_array(length, 1);
    if (!mine) { /* the others wait for this one */
        pl_complain(PL_EXIT_FAILED, "out of memory for the name of a file");
        MPI_Abort(MPI_COMM_WORLD, PL_EXIT_FAILED);
    }
    if (text)
        memcpy(mine, text, (size_t)length);
    MPI_Bcast(mine, (int)length, MPI_BYTE, 0, crew->comm);
    return mine;
}

static void share_arguments(work *w) {
    const pl_arguments *a = w->arguments;
    w->input = share_text(w->crew, a ? a->input : NULL);
    w->output = share_text(w->crew, a ? a->output : NULL);
    if (a) {
        w->job.options = a->library;
        w->job.options.bind = pl_job_binds(a);
        w->job.options.progress = pl_progress_step;
        w->job.options.progress_user = &w->progress;
    }
    w->options = pl_crew_options(w->crew, a ? &w->job.options : NULL);
    if (a)
        w->job.options = w->options;
}

/** What else the command line says. */
typedef struct rest {
    double box[6], slide_tolerance;
    int n_box, ignore_regions, slides, wants_checksums;
} rest;

static rest rest_of(const pl_arguments *a) {
    rest r = {.slide_tolerance = a->slide_tolerance,
              .n_box = a->n_box,
              .ignore_regions = a->ignore_regions,
              .slides = a->slide,
              .wants_checksums = a->json != NULL};
    memcpy(r.box, a->box, sizeof a->box);
    return r;
}

/** The same in all processes, once the dimension is known. */
static int take_rest(work *w) {
    const int dim = w->file.dim;
    rest r = {.n_box = 0};
    if (w->arguments)
        r = rest_of(w->arguments);
    MPI_Bcast(&r, sizeof r, MPI_BYTE, 0, w->crew->comm);
    w->file.ignore_regions = r.ignore_regions;
    w->file.slides = r.slides;
    w->slide_tolerance = r.slide_tolerance;
    w->wants_checksums = r.wants_checksums;
    if (r.n_box == 0)
        return PLANISH_OK;
    for (int d = 0; d < dim; d++) {
        w->options.box_lower[d] = r.box[d];
        w->options.box_upper[d] = r.box[dim + d];
    }
    if (r.n_box == 2 * dim)
        return PLANISH_OK;
    w->is_usage = 1;
    w->error = (planish_error){PLANISH_ERROR_ARGUMENT, -1, -1, ""};
    snprintf(w->error.text, sizeof w->error.text, "--box has %d numbers, and a mesh of %s needs %d",
             r.n_box, dim == 3 ? "tetrahedra" : "triangles", 2 * dim);
    return w->error.code;
}

/* ---- the steps: each returns a planish_status, the same in all processes, with w->error ------ */

static int read_mesh(work *w) {
    const double begin = pl_seconds();
    pl_plexform form = {.name = ""};
    const int can = !w->arguments || !pl_plexrows_refusal(w->input, &form);
    w->error = (planish_error){PLANISH_ERROR_FILE, -1, -1, ""};
    snprintf(w->error.text, sizeof w->error.text, "%s: has been changed meanwhile", w->input);
    int code = pl_crew_agree(w->crew, can ? PLANISH_OK : PLANISH_ERROR_FILE, &w->error);
    if (code)
        return code;
    MPI_Bcast(&form, sizeof form, MPI_BYTE, 0, w->crew->comm);
    code = pl_plexfile_read(&w->file, w->crew->exchange_comm, w->input, &form, &w->error);
    w->crew->is_broken = w->file.is_broken;
    code = pl_crew_agree(w->crew, code, &w->error);
    if (!code)
        code = pl_crew_agree(w->crew, take_rest(w), &w->error);
    w->job.mesh = (planish_mesh){
        .dim = w->file.dim, .n_nodes = w->file.n_nodes, .n_elements = w->file.n_elements};
    w->job.file_info.format = "dmplex";
    w->job.read_seconds = pl_seconds() - begin;
    return code;
}

static int make_plan(work *w) {
    const double begin = pl_seconds();
    pl_crew *crew = w->crew;
    pl_piece piece;
    int code = pl_crew_agree(crew, pl_plexfile_cut(&w->file, &piece, &w->error), &w->error);
    if (!code)
        code = pl_crew_agree(
            crew, pl_share_take(&crew->share, crew->exchange_comm, &piece, &w->error), &w->error);
    pl_piece_destroy(&piece);
    if (!code && w->file.slides)
        code = pl_surface_slide(crew, w->slide_tolerance, &w->error);
    if (!code)
        code = pl_crew_agree(crew, pl_crew_plan(crew, &w->options, &w->error), &w->error);
    if (!code)
        planish_plan_get_info(crew->plan, &w->job.plan_info);
    w->job.setup_seconds = pl_seconds() - begin;
    return code;
}

static int measure(work *w, planish_quality *quality) {
    const int code = pl_crew_measure(w->crew, quality, &w->error);
    if (!code)
        pl_job_forget(quality);
    return code;
}

/** Room for states of this process's elements; NULL with w->error. */
static uint8_t *make_states(work *w) {
    w->error =
        (planish_error){PLANISH_ERROR_MEMORY, -1, -1, "out of memory for the states of elements"};
    return pl_new_array(w->crew->share.mesh.n_elements, 1);
}

/** States of this process's elements, owned by the caller; NULL: no minimum volume was asked for.
 *  *n_undecided: of this process. */
static int check_volumes(work *w, const planish_options *o, uint8_t **state, int64_t *n_undecided) {
    const pl_share *share = &w->crew->share;
    int64_t n;
    *state = NULL;
    *n_undecided = 0;
    if (!(o->min_volume > 0) && !(o->min_volume_fraction > 0))
        return PLANISH_OK;
    *state = make_states(w);
    const int code = *state ? planish_check_volumes_until(w->crew->plan, share->coordinates, o,
                                                          *state, &n, n_undecided, &w->error)
                            : PLANISH_ERROR_MEMORY;
    return pl_crew_agree(w->crew, code, &w->error);
}

/** Elements below their minimum volume, of all processes. */
static int count_below(work *w, int64_t *n_below) {
    const pl_share *share = &w->crew->share;
    uint8_t *state;
    int64_t n_undecided;
    const int code = check_volumes(w, &w->options, &state, &n_undecided);
    *n_below = 0;
    for (int64_t i = 0; !code && state && i < share->mesh.n_elements; i++)
        *n_below += share->is_counted[i] && state[i] != PLANISH_VOLUME_MET;
    free(state);
    MPI_Allreduce(MPI_IN_PLACE, n_below, 1, MPI_INT64_T, MPI_SUM, w->crew->comm);
    return code;
}

/** One element that a process has something to say of. */
typedef struct said {
    int64_t number;
    int64_t state;
} said;

static void note_said(const said *list, int n, uint8_t *state) {
    for (int i = 0; i < n; i++)
        if (list[i].state > state[list[i].number])
            state[list[i].number] = (uint8_t)list[i].state;
}

/** What the processes say of elements, n each, most at the most, goes into the first one's state:
 *  one process after the other, for what all say may be more than messages count. room [most]. */
static void bring_said(const pl_crew *crew, const said *from, int n, int most, said *room,
                       uint8_t *state) {
    enum { TAG = 1 };
    MPI_Datatype type;
    MPI_Type_contiguous(2, MPI_INT64_T, &type);
    MPI_Type_commit(&type);
    if (crew->rank > 0)
        MPI_Send(from, n, type, 0, TAG, crew->comm);
    else
        note_said(from, n, state);
    for (int k = 1; crew->rank == 0 && k < crew->n_ranks; k++) {
        MPI_Status status;
        int n_theirs;
        MPI_Recv(room, most, type, k, TAG, crew->comm, &status);
        MPI_Get_count(&status, type, &n_theirs);
        note_said(room, n_theirs, state);
    }
    MPI_Type_free(&type);
}

/** What the processes say of elements, in the first one: state [n_elements] of all, or NULL: all
 *  are 0. mine: of this process's part; of what several say the largest is right. */
static int gather_states(work *w, const uint8_t *mine, uint8_t **state) {
    const pl_crew *crew = w->crew;
    const pl_share *share = &crew->share;
    const int is_first = crew->rank == 0;
    int n = 0, most;
    said *from = pl_new_array(share->mesh.n_elements, sizeof *from), *room = NULL;
    const planish_error no_memory = {PLANISH_ERROR_MEMORY, -1, -1,
                                     "out of memory for the states of elements"};
    *state = NULL;
    w->error = no_memory;
    int code = pl_crew_agree(crew, from ? PLANISH_OK : PLANISH_ERROR_MEMORY, &w->error);
    for (int64_t i = 0; !code && i < share->mesh.n_elements; i++)
        if (mine[i])
            from[n++] = (said){share->element_number[i], mine[i]};
    most = n;
    MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_INT, MPI_MAX, crew->comm);
    if (!code && most > 0) {
        room = pl_new_array(is_first ? most : 0, sizeof *room);
        *state = is_first ? pl_new_array(w->file.n_elements, 1) : NULL;
        w->error = no_memory;
        code = pl_crew_agree(
            crew, room && (!is_first || *state) ? PLANISH_OK : PLANISH_ERROR_MEMORY, &w->error);
        if (!code)
            bring_said(crew, from, n, most, room, *state);
    }
    free(from);
    free(room);
    return code;
}

static int smooth(work *w) {
    const double begin = pl_seconds();
    if (w->arguments)
        pl_signals_install_stop();
    const int code =
        pl_crew_smooth(w->crew, &w->options, &w->result.smooth, &w->job.traffic, &w->error);
    w->result.smooth_seconds = pl_seconds() - begin;
    return code;
}

/** Which elements are below their minimum volume in the end, as pl_volumes_find has it. */
static int find_volumes(work *w) {
    pl_volumes *volumes = &w->result.volumes;
    planish_options options = pl_options_after(&w->options, &w->result.smooth);
    uint8_t *state;
    *volumes = (pl_volumes){.least = w->result.smooth.min_volume};
    if (!(options.min_volume > 0) && !(options.min_volume_fraction > 0))
        return PLANISH_OK;
    options.min_volume = volumes->least; /* the fraction was of the volume before */
    options.min_volume_fraction = 0;
    int code = check_volumes(w, &options, &state, &volumes->n_undecided);
    MPI_Allreduce(MPI_IN_PLACE, &volumes->n_undecided, 1, MPI_INT64_T, MPI_SUM, w->crew->comm);
    if (!code && state)
        code = gather_states(w, state, &volumes->state);
    for (int64_t i = 0; volumes->state && i < w->file.n_elements; i++) {
        volumes->n_below += volumes->state[i] != PLANISH_VOLUME_MET;
        volumes->n_infeasible += volumes->state[i] == PLANISH_VOLUME_INFEASIBLE;
    }
    free(state);
    return code;
}

/** Which inverted elements nothing can repair, as pl_unfixable_find has it. */
static int find_unfixable(work *w) {
    pl_unfixable *unfixable = &w->result.unfixable;
    const pl_crew *crew = w->crew;
    const planish_options options = pl_options_after(&w->options, &w->result.smooth);
    int64_t n;
    *unfixable = (pl_unfixable){0};
    if (w->result.after.inverted == 0)
        return PLANISH_OK;
    uint8_t *state = make_states(w);
    int code = state ? planish_find_unfixable_until(crew->plan, crew->share.coordinates, &options,
                                                    state, &n, &unfixable->n_undecided, &w->error)
                     : PLANISH_ERROR_MEMORY;
    code = pl_crew_agree(crew, code, &w->error);
    MPI_Allreduce(MPI_IN_PLACE, &unfixable->n_undecided, 1, MPI_INT64_T, MPI_SUM, crew->comm);
    if (!code)
        code = gather_states(w, state, &unfixable->state);
    for (int64_t i = 0; unfixable->state && i < w->file.n_elements; i++)
        unfixable->n += unfixable->state[i] != 0;
    free(state);
    return code;
}

/** The reversed elements of this process as they are now, owned by the caller; NULL: n, those of
 *  all processes, are none. */
static int find_reversed(work *w, int64_t n, uint8_t **state) {
    const pl_share *share = &w->crew->share;
    *state = NULL;
    if (n == 0)
        return PLANISH_OK;
    *state = make_states(w);
    const int code =
        *state ? planish_find_reversed(w->crew->plan, share->coordinates, *state, NULL, &w->error)
               : PLANISH_ERROR_MEMORY;
    return pl_crew_agree(w->crew, code, &w->error);
}

/** Radius ratios of this process's elements, owned by the caller; NULL: all are valid. */
static int find_ratios(work *w, double **ratio) {
    const pl_share *share = &w->crew->share;
    *ratio = NULL;
    if (w->result.after.inverted == 0)
        return PLANISH_OK;
    w->error =
        (planish_error){PLANISH_ERROR_MEMORY, -1, -1, "out of memory for the ratios of elements"};
    *ratio = pl_new_array(share->mesh.n_elements, sizeof **ratio);
    const int code =
        *ratio ? planish_measure_elements(w->crew->plan, share->coordinates, *ratio, &w->error)
               : PLANISH_ERROR_MEMORY;
    return pl_crew_agree(w->crew, code, &w->error);
}

/** Which elements are reversed in the end, and which of them are new, as pl_reversed_compare has
 *  it; before: this process's of the input, or NULL. */
static int compare_reversed(work *w, const uint8_t *before) {
    pl_reversed *reversed = &w->result.reversed;
    uint8_t *state;
    double *ratio = NULL;
    int code = find_reversed(w, w->result.after.reversed, &state);
    if (!code && w->result.after.reversed > 0)
        code = find_ratios(w, &ratio);
    if (!code && state) {
        pl_reversed_mark_new(w->crew->share.mesh.n_elements, before, ratio, state);
        code = gather_states(w, state, &reversed->state);
    }
    for (int64_t i = 0; reversed->state && i < w->file.n_elements; i++)
        reversed->n_new += reversed->state[i] == PL_REVERSED_NEW;
    free(state);
    free(ratio);
    return code;
}

/** The first process judges, and all heed that: 0, or an exit status. */
static int check_promises(work *w) {
    int status = w->arguments ? pl_smooth_check(&w->job, &w->result) : 0;
    MPI_Bcast(&status, 1, MPI_INT, 0, w->crew->comm);
    return status;
}

static int write_mesh(work *w) {
    const double begin = pl_seconds();
    pl_crew *crew = w->crew;
    uint64_t checksums[2] = {0};
    pl_plexout out;
    int code = pl_crew_agree(crew,
                             pl_plexfile_write(&w->file, &crew->share, w->output, &out,
                                               w->wants_checksums ? checksums : NULL, &w->error),
                             &w->error);
    w->result.input_checksum = checksums[0];
    w->result.checksum = checksums[1];
    code = pl_crew_agree(crew, pl_plexfile_finish(&out, code, &w->error), &w->error);
    w->result.write_seconds = pl_seconds() - begin;
    return code;
}

static void enter(work *w, pl_phase phase) {
    if (w->arguments)
        pl_progress_phase(&w->progress, phase);
}

/** All steps up to the written mesh; *status is that of a broken promise. */
static int do_steps(work *w, int *status) {
    int code;
    enter(w, PL_PHASE_READING);
    if ((code = read_mesh(w)))
        return code;
    enter(w, PL_PHASE_PLANNING);
    if ((code = make_plan(w)))
        return code;
    enter(w, PL_PHASE_MEASURING);
    if (w->arguments)
        pl_smooth_tell_plan(&w->job);
    if ((code = measure(w, &w->result.before)) || (code = count_below(w, &w->result.below_before)))
        return code;
    if ((code = find_reversed(w, w->result.before.reversed, &w->reversed_before)))
        return code;
    if ((code = smooth(w)))
        return code;
    if (w->arguments)
        pl_smooth_tell_end(&w->job, &w->result.smooth);
    enter(w, PL_PHASE_CHECKING);
    if ((code = measure(w, &w->result.after)))
        return code;
    if ((code = find_volumes(w)) || (code = find_unfixable(w)) ||
        (code = compare_reversed(w, w->reversed_before)))
        return code;
    if ((*status = check_promises(w)))
        return PLANISH_OK;
    enter(w, PL_PHASE_WRITING);
    return write_mesh(w);
}

/** What came of it, told by the first process; returns the exit status. */
static int tell(work *w, int code, int status) {
    pl_progress_clear(&w->progress);
    if (status)
        return status;
    if (w->is_usage)
        return pl_complain_usage("smooth", "%s", w->error.text);
    if (code == PLANISH_ERROR_FILE || code == PLANISH_ERROR_FORMAT)
        return pl_complain(PL_EXIT_FAILED, "%s", w->error.text);
    if (code)
        return pl_complain(PL_EXIT_FAILED, "%s: %s", w->input, w->error.text);
    pl_signals_set_written();
    return pl_smooth_tell(&w->job, &w->result, &w->progress, 0);
}

int pl_large_smooth(pl_crew *crew, const pl_arguments *arguments) {
    work w = {.crew = crew, .arguments = arguments, .job = {.arguments = arguments}};
    int status = arguments ? pl_output_check_all(arguments) : 0;
    MPI_Bcast(&status, 1, MPI_INT, 0, crew->comm);
    if (status)
        return status;
    w.job.begin = pl_seconds();
    w.job.could_slide = w.job.layers.n = -1;
    if (arguments)
        pl_progress_init(&w.progress, arguments);
    share_arguments(&w);
    const int code = do_steps(&w, &status);
    if (arguments)
        status = tell(&w, code, status);
    pl_plexfile_close(&w.file);
    pl_volumes_free(&w.result.volumes);
    pl_unfixable_free(&w.result.unfixable);
    pl_reversed_free(&w.result.reversed);
    free(w.reversed_before);
    pl_progress_free(&w.progress);
    free(w.input);
    free(w.output);
    MPI_Bcast(&status, 1, MPI_INT, 0, crew->comm);
    return status;
}
