/* advise: the command `planish advise`, and `planish IN`: what a mesh is worth, and what smoothing could
 * win. The mesh is smoothed in memory, in several ways; nothing is written. */
#include "commands/commands.h"

#include "commands/steps.h"
#include "options/combinations.h"
#include "job/cells.h"
#include "job/job.h"
#include "job/layers.h"
#include "job/states.h"
#include "terminal/message.h"
#include "terminal/signals.h"
#include "terminal/terminal.h"
#include "terminal/text.h"

#include "base/clock.h"
#include "base/system.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/** Way of smoothing, and what came of it. */
typedef struct way {
    const char *options; /* as they are typed; "": none */
    int slides, is_best, keeps;
    int is_done;    /* the figures are there, */
    int is_stopped; /* but MOST_SECONDS ended it */
    int64_t inverted;
    double worst, least, rms; /* ratio; angle or scaled Jacobian; ratio */
    double seconds;
    int64_t n_supported; /* nodes with boundary conditions that may move */
    int has_sets;        /* the file has sets of nodes */
    int has_tolerance;   /* --slide-tolerance has an effect */
} way;

/** The layers of the mesh, which all ways are measured against: else one that destroys layers would look
 *  better than one that keeps them. */
typedef struct advised_layers {
    int is_looked_for;
    uint8_t *
        is_layer; /* [elements as of pl_job_find_layers] owned, or NULL: there are none, or something
                          else is asked for */
    double *place; /* [n_nodes][dim] of the input, owned */
    int are_kept;  /* smooth keeps them by default */
} advised_layers;

/* No way is tried longer: it is an advice. */
static const double MOST_SECONDS = 30;

/* Part of a figure (of ratios: of what is above 1) that is worth a slower way. */
static const double WORTH = 0.1;

/* Smaller changes of a figure are not: ratio, degrees, or scaled Jacobian. */
static const double LEAST = 1e-3;

static pl_arguments arguments_of(const pl_arguments *arguments, const way *w) {
    pl_arguments made = *arguments;
    made.command = PL_COMMAND_SMOOTH;
    made.output = made.input; /* messages name it; it is not written */
    made.verbosity = PL_QUIET;
    made.slide = made.slide_given = w->slides || w->is_best;
    made.layers = w->keeps ? PL_LAYERS_KEPT : made.layers;
    made.slide_curved = made.curved_if_any = made.worst = w->is_best;
    made.objective_given = w->is_best ? "--best" : NULL;
    made.library.worst = w->is_best ? PLANISH_WORST_ANGLE : PLANISH_WORST_NONE;
    made.library.time_limit = MOST_SECONDS;
    return made;
}

/** Take the figures of the mesh before or after smoothing. */
static void take_figures(way *w, const pl_job *job, const planish_quality *quality,
                         const pl_cells_validity *validity) {
    const planish_cell_measures *all = &validity->quality.all;
    w->is_done = 1;
    w->inverted = pl_cells_validity_faults(validity, quality);
    w->worst = job->has_types ? all->max_aspect_ratio : quality->max_radius_ratio;
    w->least = job->has_types ? all->min_scaled_jacobian : quality->min_angle_deg;
    w->rms = job->has_types ? all->rms_aspect_ratio : quality->rms_radius_ratio;
}

/** Take the figures of the mesh at places against the layers of the input. */
static int take_figures_of_layers(way *w, const pl_job *job, const advised_layers *layers,
                                  const double *place) {
    planish_mesh mesh;
    planish_cells cells;
    planish_cell_quality quality;
    planish_error error;
    const int status = pl_job_layer_mesh(job, &cells, &mesh);
    if (status)
        return status;
    mesh.is_layer = layers->is_layer;
    mesh.reference = layers->place;
    mesh.coordinates = place;
    mesh.size = mesh.metric = NULL;
    if (planish_measure_cells(&mesh, pl_cells_rounding(job), job->options.threads, &quality, NULL,
                              &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    w->is_done = 1;
    w->inverted = quality.all.n_inverted + quality.all.n_uncertified;
    w->worst = quality.all.max_aspect_ratio;
    w->least = quality.all.min_scaled_jacobian;
    w->rms = quality.all.rms_aspect_ratio;
    return 0;
}

/** Find the layers that ways are measured against: those that are kept, and without an option also others
 *  if they are many. */
static int find_layers(const pl_job *job, advised_layers *layers) {
    const pl_layers_asked asked = job->arguments->layers;
    const size_t size = (size_t)(job->mesh.n_nodes * job->mesh.dim) * sizeof *layers->place;
    planish_mesh mesh;
    planish_cells cells;
    int64_t n = 0;
    layers->is_looked_for = 1;
    layers->are_kept = job->like.is_layer != NULL;
    if (!job->file || job->is_surface || (!layers->are_kept && job->like.place) ||
        (asked != PL_LAYERS_BY_TYPE && asked != PL_LAYERS_KEPT))
        return 0;
    int status = pl_job_find_layers(job, &layers->is_layer, &n);
    if (!status)
        status = pl_job_layer_mesh(job, &cells, &mesh);
    layers->place = status ? NULL : malloc(size + 1);
    if (!status && !layers->place)
        status = pl_job_complain_memory(job, "places of nodes");
    if (!status)
        memcpy(layers->place, job->mesh.coordinates, size);
    if (!status && !layers->are_kept && !pl_layers_are_many(n, mesh.n_elements)) {
        free(layers->is_layer);
        layers->is_layer = NULL;
    }
    return status;
}

/** Whether the file has sets of nodes, which loads and supports are often of. */
static int has_node_sets(const pl_job *job) {
    const planish_group *group;
    planish_error error;
    int64_t n;
    if (!job->file || planish_file_groups(job->file, &group, &n, &error))
        return 0;
    for (int64_t i = 0; i < n; i++)
        if (group[i].dim == 0)
            return 1;
    return 0;
}

/** Whether the mesh lies in a tilted plane. */
static int is_tilted(const pl_job *job) {
    planish_plane plane = {.is_tilted = 0};
    if (job->file)
        planish_file_plane(job->file, &plane);
    return plane.is_tilted;
}

/** Take the figures of the mesh after smoothing, and before (NULL: they are known). */
static int take_all_figures(const pl_job *job, const pl_result *result,
                            const advised_layers *layers, way *before, way *w) {
    int status = 0;
    if (layers->is_layer) {
        if (before)
            status = take_figures_of_layers(before, job, layers, layers->place);
        return status ? status : take_figures_of_layers(w, job, layers, job->mesh.coordinates);
    }
    if (before)
        take_figures(before, job, &result->before, &result->validity_before);
    take_figures(w, job, &result->after, &result->validity_after);
    return 0;
}

/** Smooth in way w; before is filled in, too, unless it is NULL. *has_types is set to whether the figures
 *  are aspect ratios and scaled Jacobians. */
static int try_way(const pl_arguments *arguments, way *w, way *before, int *has_types,
                   advised_layers *layers) {
    const pl_arguments of_way = arguments_of(arguments, w);
    pl_result result = {.reason = ""};
    pl_progress progress;
    pl_job job;
    const double begin = pl_seconds();
    pl_progress_init(&progress, arguments);
    pl_progress_stage(&progress, PL_STAGE_READING);
    int status = pl_job_read(&job, &of_way, &pl_engine_here);
    if (!status)
        status = pl_steps_check(&job);
    if (!status && !layers->is_looked_for)
        status = find_layers(&job, layers);
    if (!status)
        status = pl_steps_smooth(&job, &result, &progress);
    if (!status)
        status = take_all_figures(&job, &result, layers, before, w);
    if (!status) {
        w->is_stopped = result.smooth.stop == PLANISH_STOP_TIME_LIMIT;
        w->n_supported = job.n_supported;
        w->has_sets = has_node_sets(&job);
        w->has_tolerance = of_way.slide || is_tilted(&job);
        *has_types = job.has_types || layers->is_layer;
    }
    pl_progress_clear(&progress);
    w->seconds = pl_seconds() - begin;
    pl_progress_free(&progress);
    pl_steps_free(&result);
    pl_job_close(&job);
    return status;
}

enum { LABEL = 25, COLUMN = 12 };

static int is_narrow(void) {
    return pl_terminal_text_width(stdout) < PL_TEXT_WIDTH;
}

static void put_number(double value) {
    if (isfinite(value))
        printf("%*.4g", COLUMN, value);
    else
        printf("%*s", COLUMN, "-");
}

static void put_way(const way *w, const char *label, int is_tried) {
    printf("%-*s%*" PRId64, LABEL, label, COLUMN - 2, w->inverted);
    put_number(w->worst);
    put_number(w->least);
    if (!is_narrow())
        put_number(w->rms);
    if (is_tried && !is_narrow())
        printf("%*.3f", COLUMN - 3, w->seconds);
    putchar('\n');
    if (w->is_stopped)
        printf("  stopped after %g s: a full run takes longer and improves more\n", MOST_SECONDS);
    fflush(stdout);
}

static void put_head(int has_types) {
    const char *columns[] = {"inverted", has_types ? "worst AR" : "worst RR",
                             has_types ? "least SJ" : "least angle", "RMS", "seconds"};
    const int width[] = {COLUMN - 2, COLUMN, COLUMN, COLUMN, COLUMN - 3};
    printf("\n%s%-*s", pl_style_begin(stdout, PL_STYLE_HEADING), LABEL,
           "what smoothing would give");
    const size_t n = sizeof columns / sizeof *columns - (is_narrow() ? 2 : 0);
    for (size_t i = 0; i < n; i++)
        printf("%*s", width[i], columns[i]);
    printf("%s\n", pl_style_end(stdout, PL_STYLE_HEADING));
}

/** Whether a is so far below b that it is worth a slower run. */
static int is_far_below(double a, double b) {
    return a < b && (isinf(b) || b - a > fmax(WORTH * fabs(b), LEAST));
}

/** Whether a is better than b by so much that it is worth a slower run: in one figure, and in none worse
 *  by as much. */
static int is_worth(const way *a, const way *b) {
    const double of_a[] = {a->worst - 1, a->rms - 1, -a->least};
    const double of_b[] = {b->worst - 1, b->rms - 1, -b->least};
    int n_better = 0, n_worse = 0;
    if (a->inverted != b->inverted)
        return a->inverted < b->inverted;
    for (size_t i = 0; i < sizeof of_a / sizeof *of_a; i++) {
        n_better += is_far_below(of_a[i], of_b[i]);
        n_worse += is_far_below(of_b[i], of_a[i]);
    }
    return n_better > 0 && n_worse == 0;
}

/** Put an option that was given, and its value (NULL: none). */
static void put_option(const char *name, const char *value) {
    printf(" --%s", name);
    if (!value)
        return;
    putchar(' ');
    pl_text_put_word(stdout, value);
}

/** Put the options that change what smoothing gives in a way. */
static void put_options(const pl_arguments *arguments, const way *w) {
    static const char *const layers[] = {
        [PL_LAYERS_HELD] = "hold", [PL_LAYERS_KEPT] = "keep", [PL_LAYERS_IGNORED] = "ignore"};
    char tolerance[32];
    if (arguments->format)
        put_option("format", arguments->format);
    if (arguments->like)
        put_option("like", arguments->like);
    for (int i = 0; i < arguments->n_fix; i++)
        put_option("fix", arguments->fix[i]);
    for (int i = 0; i < arguments->n_regions; i++)
        put_option("regions", arguments->regions[i]);
    if (arguments->ignore_regions)
        put_option("ignore-regions", NULL);
    if (arguments->layers != PL_LAYERS_BY_TYPE)
        put_option("layers", layers[arguments->layers]);
    snprintf(tolerance, sizeof tolerance, "%.15g", arguments->slide_tolerance);
    if (arguments->slide_tolerance > 0 && w->has_tolerance)
        put_option("slide-tolerance", tolerance);
}

/** Put what remains to be done after a way. */
static void put_remarks(const pl_arguments *arguments, const way *w) {
    if (w->inverted > 0)
        printf("%" PRId64 " element%s inverted then.\n", w->inverted,
               w->inverted == 1 ? " stays" : "s stay");
    if (w->n_supported > 0)
        printf("%" PRId64 " node%s with boundary conditions may move: ", w->n_supported,
               w->n_supported == 1 ? "" : "s");
    if (w->n_supported > 0 || (w->has_sets && arguments->n_fix == 0)) {
        printf("--fix SET holds nodes (planish groups %s", arguments->input[0] == '-' ? "-- " : "");
        pl_text_put_word(stdout, arguments->input);
        printf(").\n");
    }
}

/** Put what to run: the first way that no slower one is worth more than. */
static void put_advice(const pl_arguments *arguments, const way *before, const way *ways, int n) {
    const way *best = before;
    for (int i = 0; i < n; i++)
        if (ways[i].is_done && is_worth(&ways[i], best))
            best = &ways[i];
    if (best == before) {
        printf("Smoothing would improve this mesh little.\n");
        put_remarks(arguments, before);
        return;
    }
    printf("Run: planish smooth %s", arguments->input[0] == '-' ? "./" : "");
    pl_text_put_word(stdout, arguments->input);
    printf(" OUT%s%s", best->options[0] ? " " : "", best->options);
    put_options(arguments, best);
    putchar('\n');
    put_remarks(arguments, best);
}

/** Whether a way makes no sense: of what minimises another objective than --like and kept layers, and of
 *  keeping layers where there are none, or where they are kept without. */
static int is_left_out(const pl_arguments *arguments, const way *w, const advised_layers *layers) {
    return (w->is_best && pl_arguments_target(arguments)) ||
           (w->keeps && (!layers->is_layer || layers->are_kept));
}

/** Try all ways, and print a row for each. */
static int try_ways(const pl_arguments *arguments) {
    way ways[] = {{.options = ""},
                  {.options = "--slide auto", .slides = 1},
                  {.options = "--layers keep", .keeps = 1},
                  {.options = "--best", .is_best = 1}};
    enum { N_WAYS = sizeof ways / sizeof *ways };
    way before = {.options = ""};
    advised_layers layers = {.is_looked_for = 0};
    int has_types = 0, status = 0;
    for (int i = 0; i < N_WAYS && !status && !pl_signals_stop_asked(); i++) {
        char label[LABEL + 1];
        if (is_left_out(arguments, &ways[i], &layers))
            continue;
        status = try_way(arguments, &ways[i], i == 0 ? &before : NULL, &has_types, &layers);
        if (status || pl_signals_stop_asked()) /* of an error the message is there */
            break;
        if (i == 0) {
            put_head(has_types);
            put_way(&before, "as it is", 0);
        }
        snprintf(label, sizeof label, "%s%s", i == 0 ? "smoothed" : "  with ", ways[i].options);
        put_way(&ways[i], label, 1);
    }
    const int has_layers = layers.is_layer != NULL;
    free(layers.is_layer);
    free(layers.place);
    if (pl_signals_stop_asked())
        return pl_complain(PL_EXIT_FAILED, "%s: a signal stopped the trial", arguments->input);
    if (has_layers && before.is_done)
        pl_terminal_wrap(stdout, "All figures are against the layers of the mesh: AR is 1 for an "
                                 "element with its height.");
    if (before.is_done)
        put_advice(arguments, &before, ways, N_WAYS);
    return status;
}

int pl_advise_command(const pl_arguments *arguments) {
    pl_file_status found;
    if (pl_file_find(arguments->input, &found) == 0 && found.kind != PL_FILE_REGULAR &&
        found.kind != PL_FILE_FOLDER)
        return pl_complain(
            PL_EXIT_FAILED,
            "%s: is not a regular file: save it as one, because advise reads it again "
            "for each trial",
            arguments->input);
    pl_arguments measured = *arguments;
    measured.command = PL_COMMAND_QUALITY;
    const int status = pl_quality_command(&measured);
    return status ? status : pl_flush_stdout(try_ways(arguments), PL_EXIT_FAILED);
}
