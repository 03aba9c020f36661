/* history: states of a mesh while it is smoothed, for the picture of a page. */
#include "report/history.h"

#include "report/assets.h"
#include "report/picture_take.h"
#include "terminal/message.h"

#include <stdlib.h>
#include <string.h>

/* Characters of a page with a history; and of tables, drawings and the viewer, at most. */
enum { MOST_OF_PAGE = 3000000, MOST_OF_OTHERS = 150000 };

/* States that are taken for each that is kept in the end: with 2 these are as far apart as one may wish. */
enum { TAKEN_FOR_EACH = 2 };

struct pl_history {
    pl_job job; /* a copy, whose mesh is that after a sweep: */
    double *x;  /* [n_nodes][dim] owned */
    const pl_picture *picture;
    pl_drawn_state *step; /* [room] owned */
    int n, room;
    int most;   /* steps that are kept in the end */
    int stride; /* a state is taken after every stride-th sweep */
    int last_sweep;
    uint64_t start, last; /* checksums of the mesh before all sweeps, and of the last state */
    int status;           /* exit status of a failure, or 0 */
};

int pl_history_begin(const pl_job *job, const pl_picture *picture, pl_history **history) {
    const size_t n = (size_t)(job->mesh.n_nodes * job->mesh.dim);
    *history = NULL;
    if (job->arguments->history == 0 || pl_picture_n_states(picture) == 0)
        return 0;
    pl_history *h = *history = calloc(1, sizeof *h);
    if (!h)
        return pl_job_complain_memory(job, "the history");
    h->job = *job;
    h->picture = picture;
    h->most = job->arguments->history - pl_picture_n_states(picture) - 1;
    h->room = TAKEN_FOR_EACH * h->most;
    h->stride = 1;
    h->x = malloc((n + 1) * sizeof *h->x);
    h->step = calloc((size_t)h->room, sizeof *h->step);
    if (!h->x || !h->step)
        return pl_job_complain_memory(job, "the history");
    memcpy(h->x, job->mesh.coordinates, n * sizeof *h->x);
    h->job.mesh.coordinates = h->x;
    h->start = h->last = planish_checksum(&h->job.mesh);
    return 0;
}

/** Forget the steps after sweeps that stride does not divide, and from sweep end on. */
static void forget(pl_history *h, int stride, int end) {
    int n = 0;
    for (int i = 0; i < h->n; i++) {
        pl_drawn_state step = h->step[i];
        if (step.sweep % stride == 0 && step.sweep < end)
            h->step[n++] = step;
        else
            pl_drawn_state_free(&step);
    }
    h->n = n;
}

/** Make room for a step. */
static void make_room(pl_history *h) {
    while (h->n == h->room) {
        h->stride *= 2;
        forget(h, h->stride, INT32_MAX);
    }
}

/** Take the mesh at h->x. */
static void take(pl_history *h, int sweep) {
    pl_drawn_state *step = &h->step[h->n++];
    *step = (pl_drawn_state){.sweep = sweep};
    h->status = pl_picture_take_brief(h->picture, &h->job, step);
}

void pl_history_take(pl_history *h, const planish_progress *progress) {
    planish_error error;
    if (!h || h->status || !progress->sweep_done)
        return;
    if (progress->sweep <= h->last_sweep) { /* the run began anew */
        forget(h, 1, 0);
        h->stride = 1;
        h->last = h->start;
    }
    h->last_sweep = progress->sweep;
    if (progress->sweep % h->stride != 0)
        return;
    if (planish_progress_get_coordinates(progress, h->x, &error)) {
        h->status = pl_job_complain(&h->job, PL_EXIT_FAILED, &error);
        return;
    }
    const uint64_t now = planish_checksum(&h->job.mesh);
    if (now == h->last) /* a trial, which is not accepted yet */
        return;
    make_room(h);
    if (progress->sweep % h->stride != 0)
        return;
    h->last = now;
    take(h, progress->sweep);
}

/** Number of steps for which a page has room. */
static int64_t room_of_page(const pl_history *h, const pl_picture *picture) {
    const int64_t of_script =
        (int64_t)(pl_asset_three_js.size + pl_asset_controls_js.size + pl_asset_viewer_js.size);
    const int64_t left = MOST_OF_PAGE - MOST_OF_OTHERS - of_script - pl_picture_length(picture);
    int64_t longest = 1;
    for (int i = 0; i < h->n; i++) {
        const int64_t length = pl_picture_step_length(picture, &h->step[i]);
        longest = length > longest ? length : longest;
    }
    return left > 0 ? left / longest : 0;
}

/** Keep n of the steps, evenly. */
static void choose(pl_history *h, int n) {
    for (int i = 0, kept = 0; i < h->n; i++) {
        if (kept < n && i == (2 * kept + 1) * h->n / (2 * n)) {
            h->step[kept++] = h->step[i];
        } else
            pl_drawn_state_free(&h->step[i]);
    }
    h->n = n < h->n ? n : h->n;
}

int pl_history_end(pl_history *h, pl_picture *picture, const planish_result *result) {
    if (!h || h->status)
        return h ? h->status : 0;
    forget(h, 1, result->n_moved_nodes > 0 ? result->sweeps : 0); /* the last one is the result */
    const int wanted = h->n < h->most ? h->n : h->most;
    const int64_t room = room_of_page(h, picture);
    choose(h, wanted < room ? wanted : (int)room);
    if (h->n < wanted && h->job.arguments->verbosity != PL_QUIET)
        pl_note(stderr, "%s has %d of the %d states of --history, so that it stays below %d MB",
                h->job.arguments->report, h->n + 2, wanted + 2, MOST_OF_PAGE / 1000000);
    picture->step = h->step;
    picture->n_steps = h->n;
    picture->n_sweeps = result->sweeps;
    h->step = NULL;
    h->n = 0;
    return 0;
}

void pl_history_free(pl_history *h) {
    if (!h)
        return;
    for (int i = 0; i < h->n; i++)
        pl_drawn_state_free(&h->step[i]);
    free(h->step);
    free(h->x);
    free(h);
}
