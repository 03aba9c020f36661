/* progress: what is told while a command works: on standard error, and kept for the report. */
#include "job/progress.h"
#include "options/combinations.h"

#include "terminal/signals.h"
#include "terminal/terminal.h"

#include "base/clock.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void pl_progress_init(pl_progress *progress, const pl_arguments *arguments) {
    const pl_verbosity verbosity = arguments->verbosity;
    memset(progress, 0, sizeof *progress);
    progress->arguments = arguments;
    progress->plain = arguments->library.objective == PLANISH_OBJECTIVE_RADIUS_RATIO &&
                      arguments->library.area_weight == 0 && arguments->library.size_weight == 0;
    progress->has_volumes = pl_arguments_bound_volumes(arguments);
    progress->begin = pl_seconds();
    progress->last_shown = -1;
    if (verbosity >= PL_VERBOSE)
        progress->show = verbosity == PL_VERBOSE ? PL_SHOW_SWEEPS : PL_SHOW_COLOURS;
    else if (verbosity == PL_NORMAL && pl_terminal_is(stderr))
        progress->show = PL_SHOW_BAR;
}

static const char *const phase_names[] = {[PLANISH_PHASE_SMOOTH] = "smoothing",
                                          [PLANISH_PHASE_UNTANGLE] = "untangling",
                                          [PLANISH_PHASE_WORST] = "worst"};

static void keep_sweep(pl_progress *progress, const planish_progress *step) {
    enum { FIRST_CAPACITY = 64 };
    if (progress->n_sweeps == progress->capacity) {
        const int64_t capacity = progress->capacity ? 2 * progress->capacity : FIRST_CAPACITY;
        pl_sweep *sweep = realloc(progress->sweep, (size_t)capacity * sizeof *sweep);
        if (!sweep) {
            progress->out_of_memory = 1;
            return;
        }
        progress->sweep = sweep;
        progress->capacity = capacity;
    }
    progress->sweep[progress->n_sweeps++] = (pl_sweep){.rms = step->rms,
                                                       .rms_movable = step->rms_movable,
                                                       .objective = step->objective,
                                                       .seconds = step->seconds,
                                                       .inverted = step->n_inverted,
                                                       .below_min_volume = step->n_below_min_volume,
                                                       .visits = step->visits,
                                                       .phase = step->phase};
}

/* ---- lines per sweep and colour: columns of 5, 12, 12, 9, (9,) 11 and 9 characters ---------- */

/** Show a line for each sweep that is done, and if asked for each colour, under the names of the
 *  columns. */
static void show_lines(pl_progress *progress, const planish_progress *step) {
    if (!progress->has_head)
        fprintf(stderr, "%s%5s%12s%12s%9s%s%11s%9s  phase%s\n",
                pl_style_begin(stderr, PL_STYLE_HEADING), "sweep", "RMS",
                progress->plain ? "movable" : "F", "inverted",
                progress->has_volumes ? "    below" : "", "visits", "seconds",
                pl_style_end(stderr, PL_STYLE_HEADING));
    progress->has_head = 1;
    if (!step->sweep_done && step->colour > 0 && progress->show == PL_SHOW_COLOURS) {
        const int is_next = step->colour == progress->last_colour + 1;
        char name[64];
        if (is_next)
            snprintf(name, sizeof name, "colour %d/%d", step->colour, step->n_colours);
        else /* many nodes that move together are of no colour */
            snprintf(name, sizeof name, "step %d", ++progress->n_together);
        if (is_next)
            progress->last_colour = step->colour;
        fprintf(stderr, "%5s  %-*s%11" PRId64 "%9.3f\n", "", progress->has_volumes ? 40 : 31, name,
                step->colour_visits, step->seconds - progress->colour_seconds);
        progress->colour_seconds = step->seconds;
    }
    if (!step->sweep_done)
        return;
    fprintf(stderr, "%5d%12.6g%12.6g%9" PRId64, step->sweep, step->rms,
            progress->plain ? step->rms_movable : step->objective, step->n_inverted);
    if (progress->has_volumes)
        fprintf(stderr, "%9" PRId64, step->n_below_min_volume);
    fprintf(stderr, "%11" PRId64 "%9.3f  %s\n", step->visits, step->seconds,
            phase_names[step->phase]);
    progress->colour_seconds = 0;
    progress->last_colour = progress->n_together = 0;
}

/* ---- the bar: one line that is written over ------------------------------------------------- */

/* How much of the whole may be done when a stage begins, as long as no sweep has told more. */
static const struct {
    const char *name;
    double smooth, quality;
} stages[] = {
    [PL_STAGE_READING] = {"reading", 0, 0},         [PL_STAGE_PLANNING] = {"planning", 0.1, 0.4},
    [PL_STAGE_MEASURING] = {"measuring", 0.2, 0.7}, [PL_STAGE_SMOOTHING] = {"smoothing", 0.25, 1},
    [PL_STAGE_CHECKING] = {"checking", 0.9, 1},     [PL_STAGE_WRITING] = {"writing", 0.93, 1},
};

/** Parts of the line, most important first; the bar comes behind the second. Empty: nothing. */
typedef struct bar_line {
    char part[4][64]; /* stage, count, value, time left */
} bar_line;

/** Show "stage, count [####......]  40 %, value, left", of which the last parts are left out where
 *  the terminal has no room; the bar has the same length in all lines. */
static void show_bar(pl_progress *progress, bar_line *l, double share) {
    enum {
        LONGEST = 20,    /* columns of the bar at most, */
        SHORTEST = 5,    /* and at least, if there is one */
        FRAME = 9,       /* of brackets and per cent around it */
        USUAL_TEXT = 54, /* of the text if all of it is there */
        SHORT_TEXT = 25  /* of the first parts, beside which a bar must have room */
    };
    char bar[64] = "", line[sizeof *l + sizeof bar];
    int room = pl_terminal_columns(stderr) - 1, length = room - FRAME - USUAL_TEXT;
    length = length < SHORTEST ? SHORTEST : length > LONGEST ? LONGEST : length;
    if (room - FRAME < SHORT_TEXT + SHORTEST)
        length = 0;
    progress->share = fmax(progress->share, fmin(share, 1));
    const int filled = (int)(progress->share * length);
    if (length > 0)
        snprintf(bar, sizeof bar, " [%.*s%.*s] %3d %%", filled, "####################",
                 length - filled, "....................", (int)(100 * progress->share));
    room -= (int)strlen(bar);
    for (int i = 0; i < 4; i++) {
        room -= (int)strlen(l->part[i]);
        if (room < 0)
            l->part[i][0] = '\0';
    }
    snprintf(line, sizeof line, "%s%s%s%s%s", l->part[0], l->part[1], bar, l->part[2], l->part[3]);
    pl_line_show(line);
}

/** Sweeps that are left in this stage, by how their relative falls of F shrink, or as many as are
 *  usual; *is_known: by more than a guess. */
static double sweeps_left(const pl_progress *progress, const planish_progress *step,
                          int *is_known) {
    enum { USUAL = 12, USUAL_WORST = 25, FEWEST = 3, CALM = 3 /* sweeps that end them */ };
    const planish_options *options = &progress->arguments->library;
    const int usual = step->phase == PLANISH_PHASE_WORST ? USUAL_WORST : USUAL;
    const int is_smooth = step->phase == PLANISH_PHASE_SMOOTH;
    double fall[2] = {0}, value[3] = {0};
    int done = 0, in_a_row = 0;
    for (int64_t i = 0; i < progress->n_sweeps; i++) {
        const pl_sweep *sweep = &progress->sweep[i];
        done += (sweep->phase == PLANISH_PHASE_WORST) == (step->phase == PLANISH_PHASE_WORST);
        in_a_row = sweep->phase == PLANISH_PHASE_SMOOTH ? in_a_row + 1 : 0;
        value[i % 3] = progress->plain ? sweep->rms_movable : sweep->objective;
    }
    for (int k = 0; k < 2 && in_a_row > FEWEST; k++) {
        const double before = value[(progress->n_sweeps + k) % 3];
        const double after = value[(progress->n_sweeps + k + 1) % 3];
        fall[k] = before > 0 ? (before - after) / before : 0;
    }
    const double most = fmax(0, (double)(options->max_sweeps - in_a_row));
    const double shrinking = fall[0] > 0 ? fall[1] / fall[0] : 1, tolerance = options->tolerance;
    /* Falls that hardly shrink say nothing of their end: such meshes are helped meanwhile. */
    *is_known = is_smooth && in_a_row > FEWEST && fall[1] > 0 && shrinking < 0.95;
    if (*is_known && tolerance > 0)
        return fmin(most, fall[1] <= tolerance
                              ? CALM - 1
                              : ceil(log(tolerance / fall[1]) / log(shrinking)) + CALM - 1);
    *is_known = tolerance == 0 && is_smooth; /* their number alone ends them */
    return *is_known ? most
                     : fmin(done + FEWEST < usual ? usual - done : FEWEST, options->max_sweeps);
}

/** Seconds that the sweeps are still going to take; *is_known: by more than a guess. */
static double seconds_left(const pl_progress *progress, const planish_progress *step,
                           int *is_known) {
    enum { RECENT = 3, WORST_SWEEPS = 25, DEARER = 5 /* than others */ };
    const planish_options *options = &progress->arguments->library;
    const double part = fmin(1, (double)step->colour / fmax(1, step->n_colours));
    const int64_t n = progress->n_sweeps < RECENT ? progress->n_sweeps : RECENT;
    double seconds = n == 0 && part > 0 ? step->seconds / part : 0; /* of a sweep */
    for (int64_t i = progress->n_sweeps - n; i < progress->n_sweeps; i++)
        seconds += progress->sweep[i].seconds / (double)n;
    const double sweeps = sweeps_left(progress, step, is_known);
    double left = fmax(0, sweeps - (step->sweep_done ? 0 : part)) * seconds;
    if (options->worst && step->phase != PLANISH_PHASE_WORST) {
        left += WORST_SWEEPS * DEARER * seconds;
        *is_known = 0;
    }
    if (options->time_limit > 0)
        left = fmin(left, fmax(0, options->time_limit - step->elapsed));
    return left;
}

/** Show how far the sweeps are; now and then, as more often is not seen. */
static void show_step(pl_progress *progress, const planish_progress *step) {
    static const double INTERVAL = 0.1, MOST_GUESSED = 0.5; /* seconds; share of the whole */
    bar_line l = {.part = {""}};
    int is_known;
    if (progress->last_shown >= 0 && step->elapsed - progress->last_shown < INTERVAL)
        return;
    progress->last_shown = step->elapsed;
    const double left = seconds_left(progress, step, &is_known) + progress->write_seconds;
    const double spent = pl_seconds() - progress->begin;
    const long long whole = (long long)ceil(left);
    const int is_long = whole >= 3600;
    snprintf(l.part[0], sizeof l.part[0], "%s%s", phase_names[step->phase],
             step->phase == PLANISH_PHASE_WORST ? " elements" : "");
    snprintf(l.part[1], sizeof l.part[1], ", sweep %d", step->sweep);
    if (step->n_inverted > 0 && step->phase == PLANISH_PHASE_UNTANGLE) {
        /* the RMS would be that of the others */
        snprintf(l.part[2], sizeof l.part[2], ", %" PRId64 " inverted", step->n_inverted);
    } else {
        snprintf(l.part[2], sizeof l.part[2], ", RMS %.6g", step->rms);
        if (is_known && whole < 60)
            snprintf(l.part[3], sizeof l.part[3], ", about %lld s left", whole);
        else if (is_known)
            snprintf(l.part[3], sizeof l.part[3], ", about %lld:%02lld %s left",
                     whole / (is_long ? 3600 : 60), is_long ? whole / 60 % 60 : whole % 60,
                     is_long ? "h" : "min");
    }
    const double share = spent / (spent + left);
    show_bar(progress, &l,
             is_known || step->phase == PLANISH_PHASE_WORST ? share : fmin(share, MOST_GUESSED));
}

/* ---- what the others call ------------------------------------------------------------------- */

void pl_progress_stage(pl_progress *progress, pl_stage stage) {
    const pl_arguments *arguments = progress->arguments;
    const int n = arguments->n_inputs, is_smooth = arguments->command == PL_COMMAND_SMOOTH;
    bar_line l = {.part = {""}};
    if (stage == PL_STAGE_PLANNING)
        progress->write_seconds = pl_seconds() - progress->begin;
    if (progress->show != PL_SHOW_BAR)
        return;
    snprintf(l.part[0], sizeof l.part[0], "%s", stages[stage].name);
    if (n > 1)
        snprintf(l.part[1], sizeof l.part[1], ", file %d of %d", progress->file + 1, n);
    show_bar(progress, &l,
             (progress->file + (is_smooth ? stages[stage].smooth : stages[stage].quality)) / n);
}

int pl_progress_step(const planish_progress *step, void *user) {
    pl_progress *progress = user;
    if (step->sweep_done)
        keep_sweep(progress, step);
    if (progress->show >= PL_SHOW_SWEEPS)
        show_lines(progress, step);
    else if (progress->show == PL_SHOW_BAR)
        show_step(progress, step);
    return pl_signals_stop_asked();
}

void pl_progress_clear(pl_progress *progress) {
    if (progress->show == PL_SHOW_BAR)
        pl_line_clear();
}

void pl_progress_free(pl_progress *progress) {
    pl_progress_clear(progress);
    free(progress->sweep);
    progress->sweep = NULL;
}
