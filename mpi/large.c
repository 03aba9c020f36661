/* large: `planish smooth` on a mesh in PETSc's file, of which the program has no copy.
 *
 * The steps are those of tools/smooth.c; all processes take them, and the first one tells of them.
 */
#include "large.h"

#include "plexfile.h"
#include "surface.h"

#include "message.h"
#include "output.h"
#include "progress.h"
#include "signals.h"
#include "smooth.h"
#include "text.h"

#include "base/clock.h"

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
    pl_plexfile file;
    pl_job job;
    pl_result result;
    pl_progress progress;
    planish_error error;
    int is_usage; /* error is one of the command line */
} work;

/* ---- the command line ----------------------------------------------------------------------- */

/** What needs names of groups, or looks at all of the mesh; NULL: nothing. */
static const char *impossible(const pl_arguments *a) {
    return a->n_fix > 0 || a->fix_layers ? "--fix"
           : a->n_slide_tags > 0         ? "--slide with names"
           : a->n_min_volumes > 0        ? "--min-volume of a group"
           : a->n_worst > 0              ? "--worst"
           : a->report                   ? "--report"
           : a->format                   ? "--format"
                                         : NULL;
}

static int check_arguments(const pl_arguments *a) {
    if (impossible(a))
        return pl_complain_usage("smooth", "%s is not possible with a file of PETSc, '%s'",
                                 impossible(a), a->input);
    if (!pl_plexfile_is(a->output))
        return pl_complain_usage(
            "smooth", "'%s' does not have the extension of the input's format, .h5", a->output);
    return pl_output_check_all(a);
}

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
        w->job.options.bind = !a->leave_unbound;
        w->job.options.progress = pl_progress_step;
        w->job.options.progress_user = &w->progress;
    }
    w->options = pl_crew_options(w->crew, a ? &w->job.options : NULL);
    if (a)
        w->job.options = w->options;
}

/** What else the command line says, in all processes: the box, once the dimension is known. */
static int take_rest(work *w) {
    double box[10] = {0}; /* how many numbers it has, whether regions are ignored; what slides */
    const int dim = w->file.dim;
    if (w->arguments) {
        memcpy(box, w->arguments->box, sizeof w->arguments->box);
        box[6] = w->arguments->n_box;
        box[7] = w->arguments->ignore_regions;
        box[8] = w->arguments->slide;
        box[9] = w->arguments->slide_tolerance;
    }
    MPI_Bcast(box, 10, MPI_DOUBLE, 0, w->crew->comm);
    w->file.ignore_regions = box[7] != 0;
    w->file.slides = box[8] != 0;
    w->slide_tolerance = box[9];
    if (box[6] == 0)
        return PLANISH_OK;
    for (int d = 0; d < dim; d++) {
        w->options.box_lower[d] = box[d];
        w->options.box_upper[d] = box[dim + d];
    }
    if ((int)box[6] == 2 * dim)
        return PLANISH_OK;
    w->is_usage = 1;
    w->error = (planish_error){PLANISH_ERROR_ARGUMENT, -1, -1, ""};
    snprintf(w->error.text, sizeof w->error.text, "--box has %d numbers, and a mesh of %s needs %d",
             (int)box[6], dim == 3 ? "tetrahedra" : "triangles", 2 * dim);
    return w->error.code;
}

/* ---- the steps: each returns a planish_status, the same in all processes, with w->error ------ */

static int read_mesh(work *w) {
    const double begin = pl_seconds();
    int code = pl_plexfile_read(&w->file, w->crew->exchange_comm, w->input, &w->error);
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

/** Elements below their least volume, of all processes. */
static int count_below(work *w, int64_t *n_below) {
    const pl_share *share = &w->crew->share;
    const planish_options *o = &w->options;
    int64_t n;
    *n_below = 0;
    if (!(o->min_volume > 0) && !(o->min_volume_fraction > 0))
        return PLANISH_OK;
    uint8_t *state = pl_new_array(share->mesh.n_elements, 1);
    int code = PLANISH_ERROR_MEMORY;
    w->error = (planish_error){code, -1, -1, "out of memory for the states of elements"};
    if (state)
        code = planish_check_volumes(w->crew->plan, share->coordinates, o, state, &n, &w->error);
    for (int64_t i = 0; !code && i < share->mesh.n_elements; i++)
        *n_below += share->is_counted[i] && state[i] != PLANISH_VOLUME_MET;
    free(state);
    code = pl_crew_agree(w->crew, code, &w->error);
    if (!code)
        MPI_Allreduce(MPI_IN_PLACE, n_below, 1, MPI_INT64_T, MPI_SUM, w->crew->comm);
    return code;
}

static int smooth(work *w) {
    const double begin = pl_seconds();
    if (w->arguments)
        pl_signals_install_stop();
    const int code =
        pl_crew_smooth(w->crew, &w->options, &w->result.smooth, &w->job.traffic, &w->error);
    w->result.volumes = (pl_volumes){.least = w->result.smooth.min_volume,
                                     .n_below = w->result.smooth.below_min_volume};
    w->result.smooth_seconds = pl_seconds() - begin;
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
    int code = pl_crew_agree(crew, pl_plexfile_write(&w->file, &crew->share, w->output, &w->error),
                             &w->error);
    crew->is_broken = code != 0;
    code =
        pl_crew_agree(crew, pl_plexfile_finish(crew->rank, w->output, code, &w->error), &w->error);
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
    if ((code = smooth(w)))
        return code;
    if (w->arguments)
        pl_smooth_tell_end(&w->job, &w->result.smooth);
    enter(w, PL_PHASE_CHECKING);
    if ((code = measure(w, &w->result.after)))
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
    int status = arguments ? check_arguments(arguments) : 0;
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
    pl_progress_free(&w.progress);
    free(w.input);
    free(w.output);
    MPI_Bcast(&status, 1, MPI_INT, 0, crew->comm);
    return status;
}
