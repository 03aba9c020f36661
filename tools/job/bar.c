/* bar: one line on the terminal: what is done, how much of the whole, and how long it will take. */
#include "job/bar.h"

#include "terminal/terminal.h"

#include "base/clock.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    LONGEST = 20,            /* columns of the bar at most, */
    SHORTEST = 5,            /* and at least, if there is one */
    FRAME = 9,               /* columns of brackets and per cent around it */
    USUAL_TEXT = 54,         /* columns of the text if all of it is there */
    SHORT_TEXT = 25,         /* and of what is told first, beside which a bar must have room */
    USUAL_SWEEPS = 12,       /* to convergence, as long as nothing is known */
    USUAL_WORST_SWEEPS = 25, /* and for the worst elements, */
    DEARER_WORST = 5,        /* each of which takes about so many times as long */
    FEWEST_LEFT = 3          /* when more sweeps have been done than are usual */
};

/* Seconds between two updates of the bar: more often is not seen and only costs. */
static const double INTERVAL = 0.1;

/* The most that may be done by what is no more than a guess. */
static const double MOST_GUESSED = 0.5;

/* How much of the whole may be done when a phase begins, as long as no sweep has told more. */
static const double share_of_smooth[] = {
    [PL_PHASE_READING] = 0,      [PL_PHASE_PLANNING] = 0.1, [PL_PHASE_MEASURING] = 0.2,
    [PL_PHASE_SMOOTHING] = 0.25, [PL_PHASE_CHECKING] = 0.9, [PL_PHASE_WRITING] = 0.93,
};
static const double share_of_quality[] = {
    [PL_PHASE_READING] = 0,
    [PL_PHASE_PLANNING] = 0.4,
    [PL_PHASE_MEASURING] = 0.7,
};

static const char *const phase_names[] = {
    [PL_PHASE_READING] = "reading",     [PL_PHASE_PLANNING] = "planning",
    [PL_PHASE_MEASURING] = "measuring", [PL_PHASE_SMOOTHING] = "smoothing",
    [PL_PHASE_CHECKING] = "checking",   [PL_PHASE_WRITING] = "writing",
};

/** What a line tells, most important first; the bar comes behind the second. Empty: nothing. */
typedef struct parts {
    char phase[32], count[64], value[64], left[64];
} parts;

/** Columns of the bar on a terminal of so many, whatever stands beside it: 0 for none. */
static int bar_length(int terminal) {
    const int room = terminal - 1 - FRAME;
    if (room < SHORT_TEXT + SHORTEST)
        return 0;
    const int length = room - USUAL_TEXT;
    return length < SHORTEST ? SHORTEST : length > LONGEST ? LONGEST : length;
}

/** Empty the parts, the last ones first, that the room has no place for. */
static void fit(parts *p, int room) {
    char *const part[] = {p->phase, p->count, p->value, p->left};
    for (int i = 0; i < 4; i++) {
        room -= (int)strlen(part[i]);
        if (room < 0)
            part[i][0] = '\0';
    }
}

/** "phase, count [####......]  40 %, value, left". */
static void show(pl_progress *progress, parts *p, double share) {
    char bar[64] = "", line[sizeof *p + sizeof bar];
    const int terminal = pl_terminal_columns(stderr), length = bar_length(terminal);
    progress->share = fmax(progress->share, fmin(share, 1));
    const int filled = (int)(progress->share * length);
    fit(p, terminal - 1 - (length > 0 ? FRAME + length : 0));
    if (length > 0)
        snprintf(bar, sizeof bar, " [%.*s%.*s] %3d %%", filled, "####################",
                 length - filled, "....................", (int)(100 * progress->share));
    snprintf(line, sizeof line, "%s%s%s%s%s", p->phase, p->count, bar, p->value, p->left);
    pl_line_show(line);
}

void pl_bar_phase(pl_progress *progress, pl_phase phase) {
    parts p = {.phase = ""};
    const pl_arguments *arguments = progress->arguments;
    const int n = arguments->n_inputs, is_smooth = arguments->command == PL_COMMAND_SMOOTH;
    const double share = is_smooth ? share_of_smooth[phase] : share_of_quality[phase];
    snprintf(p.phase, sizeof p.phase, "%s", phase_names[phase]);
    if (n > 1)
        snprintf(p.count, sizeof p.count, ", file %d of %d", progress->file + 1, n);
    show(progress, &p, (progress->file + share) / n);
}

/** Seconds for people: "about 12 s left", "about 3:05 min left", "about 2:10 h left". */
static void print_left(double seconds, char *text, size_t size) {
    const int64_t whole = (int64_t)ceil(seconds);
    if (whole < 60)
        snprintf(text, size, ", about %" PRId64 " s left", whole);
    else if (whole < 3600)
        snprintf(text, size, ", about %" PRId64 ":%02d min left", whole / 60, (int)(whole % 60));
    else
        snprintf(text, size, ", about %" PRId64 ":%02d h left", whole / 3600,
                 (int)(whole / 60 % 60));
}

/** Sweeps of one kind that may be left where nothing is known: usual ones but those done. */
static double guess_sweeps(const pl_progress *progress, int worst, int usual) {
    int64_t done = 0;
    for (int64_t i = 0; i < progress->n_sweeps; i++)
        done += progress->sweep[i].worst == worst;
    return (double)(done + FEWEST_LEFT < usual ? usual - done : FEWEST_LEFT);
}

/** Sweeps that are left in this phase; *is_known: by more than a guess. */
static double sweeps_left(const pl_progress *progress, const planish_progress *step,
                          int *is_known) {
    const planish_options *options = &progress->arguments->library;
    *is_known = 0;
    if (step->worst)
        return guess_sweeps(progress, 1, USUAL_WORST_SWEEPS);
    const double estimated =
        step->restoring
            ? -1
            : pl_estimate_sweeps(progress->sweep, progress->n_sweeps, options, progress->plain);
    *is_known = estimated >= 0;
    return estimated >= 0 ? estimated
                          : fmin(guess_sweeps(progress, 0, USUAL_SWEEPS), options->max_sweeps);
}

/** Seconds that the sweeps are still going to take; *is_known: by more than a guess. */
static double seconds_left(const pl_progress *progress, const planish_progress *step,
                           int *is_known) {
    const planish_options *options = &progress->arguments->library;
    const double part = fmin(1, (double)step->colour / fmax(1, step->n_colours));
    double seconds = pl_estimate_sweep_seconds(progress->sweep, progress->n_sweeps);
    if (progress->n_sweeps == 0)
        seconds = part > 0 ? step->seconds / part : 0;
    const double sweeps = sweeps_left(progress, step, is_known);
    double left = fmax(0, sweeps - (step->sweep_done ? 0 : part)) * seconds;
    if (options->worst && !step->worst) {
        left += USUAL_WORST_SWEEPS * DEARER_WORST * seconds;
        *is_known = 0;
    }
    if (options->time_limit > 0)
        left = fmin(left, fmax(0, options->time_limit - step->elapsed));
    return left;
}

void pl_bar_step(pl_progress *progress, const planish_progress *step) {
    parts p = {.phase = ""};
    int is_known;
    if (progress->last_shown >= 0 && step->elapsed - progress->last_shown < INTERVAL)
        return;
    progress->last_shown = step->elapsed;
    const double left = seconds_left(progress, step, &is_known) + progress->write_seconds;
    const double spent = pl_seconds() - progress->begin;
    snprintf(p.phase, sizeof p.phase, "%s",
             step->restoring ? "untangling"
             : step->worst   ? "worst elements"
                             : phase_names[PL_PHASE_SMOOTHING]);
    snprintf(p.count, sizeof p.count, ", sweep %d", step->sweep);
    if (step->inverted > 0 && step->restoring) { /* the RMS would be that of the others */
        snprintf(p.value, sizeof p.value, ", %" PRId64 " inverted", step->inverted);
    } else {
        snprintf(p.value, sizeof p.value, ", RMS %.6g", step->rms);
        if (is_known)
            print_left(left, p.left, sizeof p.left);
    }
    const double share = spent / (spent + left);
    show(progress, &p, is_known || step->worst ? share : fmin(share, MOST_GUESSED));
}
