/* held: why nodes do not move: what the plan, the file and the options say, put together.
 *
 * A node may have several reasons. It is counted once, by the first of them in the order of
 * pl_hold_cause.
 */
#include "job/held.h"

#include "terminal/message.h"
#include "terminal/terminal.h"
#include "terminal/text.h"

#include "base/clock.h"
#include "geometry/cell.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

static const char *const names[PL_N_CAUSES] = {
    "boundary",  "lines_and_points", "faces_inside",   "interface",   "other_elements", "periodic",
    "fix",       "required",         "doubled_points", "nonmanifold", "layers",         "wrapped",
    "not_chosen"};

/** Behind a number of nodes. */
static const char *const words[PL_N_CAUSES] = {"on the boundary",
                                               "on lines or points of the file",
                                               "on faces that the file lists inside the mesh",
                                               "between regions",
                                               "on elements of other types",
                                               "on periodic sides",
                                               "in groups of --fix",
                                               "required by the file",
                                               "at the place of other nodes",
                                               "where the mesh is not manifold",
                                               "on thin layers",
                                               "on elements that wrap around the domain",
                                               "not chosen by --only-worse-than"};

const char *pl_held_name(int reason) {
    return names[reason];
}

const char *pl_held_text(int reason) {
    return words[reason];
}

/* ---- finding -------------------------------------------------------------------------------- */

/** The bits of one source for bits of the program. */
typedef struct translation {
    uint8_t from;
    uint16_t to;
} translation;

static const translation of_plan[] = {{PLANISH_HELD_BOUNDARY, 1 << PL_CAUSE_BOUNDARY},
                                      {PLANISH_HELD_PERIODIC, 1 << PL_CAUSE_PERIODIC},
                                      {PLANISH_HELD_DOUBLED, 1 << PL_CAUSE_DOUBLED},
                                      {PLANISH_HELD_NONMANIFOLD, 1 << PL_CAUSE_NONMANIFOLD},
                                      {PLANISH_HELD_WRAPPED, 1 << PL_CAUSE_WRAPPED},
                                      {PLANISH_HELD_NOT_CHOSEN, 1 << PL_CAUSE_NOT_CHOSEN},
                                      {PLANISH_HELD_UNUSED, PL_HELD_NOT_USED}};

static const translation of_file[] = {{PLANISH_FILE_LINE_OR_POINT, 1 << PL_CAUSE_LINE},
                                      {PLANISH_FILE_FACE, 1 << PL_CAUSE_FACE},
                                      {PLANISH_FILE_INTERFACE, 1 << PL_CAUSE_INTERFACE},
                                      {PLANISH_FILE_OTHER_ELEMENT, 1 << PL_CAUSE_OTHER},
                                      {PLANISH_FILE_PERIODIC, 1 << PL_CAUSE_PERIODIC},
                                      {PLANISH_FILE_FIX, 1 << PL_CAUSE_FIX},
                                      {PLANISH_FILE_REQUIRED, 1 << PL_CAUSE_REQUIRED}};

static uint16_t translate(const translation *table, size_t n, uint8_t bits) {
    uint16_t result = 0;
    for (size_t i = 0; i < n; i++)
        result |= bits & table[i].from ? table[i].to : 0;
    return result;
}

/** Mark the mid-side nodes that nothing holds. One that is also a corner is none. */
static void mark_mids(const pl_job *job, uint16_t *bits) {
    const planish_cells *cells = job->mesh.cells;
    int corners;
    for (int64_t i = 0; cells && i < cells->n; i++) {
        pl_job_corners(job, i, &corners);
        for (int64_t k = cells->offset[i] + corners; k < cells->offset[i + 1]; k++) {
            const int32_t mid = cells->node[k];
            if (mid >= 0 && bits[mid] == 0)
                bits[mid] = PL_HELD_FOLLOWS;
        }
    }
    for (int64_t i = 0; cells && i < cells->n; i++) {
        const int32_t *corner = pl_job_corners(job, i, &corners);
        for (int j = 0; j < corners; j++)
            bits[corner[j]] &= (uint16_t)~PL_HELD_FOLLOWS;
    }
}

/** Give mids of order 2 that are fixed, nobody says why, the reasons of their ends. */
static void give_reasons_of_ends(const pl_job *job, uint16_t *bits) {
    const planish_cells *cells = job->mesh.cells;
    const uint16_t all = (1 << PL_N_CAUSES) - 1;
    for (int64_t i = 0; cells && i < cells->n; i++) {
        const pl_cell_type *type = pl_cell_type_of(cells->type[i]);
        const int32_t *node = cells->node + cells->offset[i];
        for (int j = type ? type->shape->n_corners : 0; type && j < type->n_nodes; j++) {
            const uint16_t a = bits[node[type->between[j][0]]], b = bits[node[type->between[j][1]]];
            if (node[j] >= 0 && (bits[node[j]] & PL_HELD_TOLD) && !(bits[node[j]] & all) &&
                (a & all) && (b & all))
                bits[node[j]] |= (a | b) & all;
        }
    }
}

/** Fill bits with all reasons; scratch [n_nodes]. */
static int find_reasons(const pl_job *job, uint8_t *scratch, uint16_t *bits) {
    const planish_hold hold = pl_job_hold(job);
    const uint16_t all = (1 << PL_N_CAUSES) - 1;
    const int64_t n = job->mesh.n_nodes;
    planish_error error;
    /* Those of the plan; a node that it was told to fix has a mark, until others say why. */
    if (job->engine->get_held(job, scratch, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    for (int64_t i = 0; i < n; i++) {
        bits[i] = translate(of_plan, sizeof of_plan / sizeof *of_plan, scratch[i]);
        if (scratch[i] & PLANISH_HELD_FIXED)
            bits[i] |= PL_HELD_TOLD;
    }
    /* Those of the file, and of layers, for nodes that the plan holds. */
    if (planish_file_get_held(job->file, &hold, scratch, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    for (int64_t i = 0; i < n; i++)
        if (bits[i])
            bits[i] |= translate(of_file, sizeof of_file / sizeof *of_file, scratch[i]);
    for (int64_t i = 0; i < n; i++)
        scratch[i] = PLANISH_CONSTRAINT_FREE;
    pl_job_hold_layers(job, scratch);
    for (int64_t i = 0; i < n; i++)
        if (bits[i] && scratch[i] == PLANISH_CONSTRAINT_FIXED)
            bits[i] |= 1 << PL_CAUSE_LAYERS;
    give_reasons_of_ends(job, bits);
    for (int64_t i = 0; i < n; i++) {
        /* The slides hold some that nobody has a reason for. */
        if ((bits[i] & PL_HELD_TOLD) && !(bits[i] & all))
            bits[i] |= 1 << PL_CAUSE_REQUIRED;
        if (bits[i] & PL_HELD_NOT_USED)
            bits[i] = PL_HELD_NOT_USED;
        bits[i] &= (uint16_t)~PL_HELD_TOLD;
    }
    mark_mids(job, bits);
    return 0;
}

int pl_held_find(const pl_job *job, uint16_t **bits) {
    const size_t n = (size_t)job->mesh.n_nodes;
    *bits = NULL;
    if (!job->engine->get_held)
        return 0;
    uint16_t *found = calloc(n + 1, sizeof *found);
    uint8_t *scratch = malloc(n + 1);
    const int status = found && scratch ? find_reasons(job, scratch, found)
                                        : pl_job_complain_memory(job, "values of nodes");
    free(scratch);
    if (status)
        free(found);
    else
        *bits = found;
    return status;
}

/* ---- counting ------------------------------------------------------------------------------- */

int pl_held_count(pl_job *job) {
    const double begin = pl_seconds();
    uint16_t *bits;
    const pl_arguments *arguments = job->arguments;
    const int is_asked = arguments->json || arguments->report ||
                         arguments->verbosity >= PL_VERBOSE || job->layers.n_held > 0 ||
                         job->plan_info.n_free + job->plan_info.n_sliding == 0;
    pl_held *held = &job->held;
    *held = (pl_held){.is_known = 0};
    if (!is_asked)
        return 0;
    int status = pl_held_find(job, &bits);
    if (!status && job->layers.n_held > 0)
        status = pl_job_need_released_by(job);
    for (int64_t i = 0; !status && bits && i < job->mesh.n_nodes; i++) {
        if (job->layers.n_held > 0 && bits[i] == 1 << PL_CAUSE_LAYERS)
            job->released_by[i] |= PL_RELEASED_BY_LAYERS;
        int reason = 0;
        while (reason < PL_N_CAUSES && !(bits[i] >> reason & 1))
            reason++;
        held->n_mids += (bits[i] & PL_HELD_FOLLOWS) != 0;
        held->n_unused += (bits[i] & PL_HELD_NOT_USED) != 0;
        if (reason == PL_N_CAUSES) /* it moves, or is of no element */
            continue;
        held->n[reason]++;
        held->n_held++;
        held->n_doubled += bits[i] >> PL_CAUSE_DOUBLED & 1;
    }
    held->is_known = bits != NULL;
    free(bits);
    job->shape_seconds += pl_seconds() - begin;
    return status;
}

/* ---- movable nodes that smoothing holds ------------------------------------------------------ */

/** By planish_held_by. */
static const struct {
    const char *name, *text;
} in_run[] = {{NULL, NULL},
              {"bounds", "held outside of the bounds"},
              {"tolerance", "held by the surface's tolerance"},
              {"sheet", "held near another sheet of the surface"},
              {"surface", "held by the surface"}};

const char *pl_held_name_in_run(planish_held_by reason) {
    return in_run[reason].name;
}

const char *pl_held_text_in_run(const char *name) {
    for (size_t i = 1; i < sizeof in_run / sizeof *in_run; i++)
        if (strcmp(in_run[i].name, name) == 0)
            return in_run[i].text;
    return "held";
}

/** Whether the options bound nodes, or let them slide along a shape. */
static int may_hold(const planish_options *options) {
    int may = options->shape != NULL;
    for (int d = 0; d < 3; d++)
        may |= options->box_lower[d] > -INFINITY || options->box_upper[d] < INFINITY;
    return may;
}

int pl_held_find_in_run(pl_job *job) {
    const pl_arguments *arguments = job->arguments;
    const int is_asked = arguments->json || arguments->report || arguments->n_worst > 0;
    planish_error error;
    if (!is_asked || !job->engine->find_held || !may_hold(&job->options))
        return 0;
    job->held_in_run = malloc((size_t)job->mesh.n_nodes + 1);
    if (!job->held_in_run)
        return pl_job_complain_memory(job, "values of nodes");
    pl_job all = *job; /* the command quality has left out elements of other types */
    pl_job_take_all(&all);
    return job->engine->find_held(&all, job->held_in_run, &error)
               ? pl_job_complain(job, PL_EXIT_FAILED, &error)
               : 0;
}

/* ---- saying --------------------------------------------------------------------------------- */

static void append(char *text, size_t size, const char *format, ...) PL_PRINTF(3, 4);
static void append(char *text, size_t size, const char *format, ...) {
    const size_t used = strlen(text);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text + used, size - used, format, arguments);
    va_end(arguments);
}

/** "240 nodes are on the boundary, 12 between regions" behind text. */
static void add_counts(const pl_job *job, char *text, size_t size) {
    const pl_held *held = &job->held;
    int listed = 0;
    for (int i = 0; i < PL_N_CAUSES; i++)
        if (held->n[i] > 0) {
            append(text, size, "%s%" PRId64 "%s %s", listed ? ", " : "", held->n[i],
                   listed           ? ""
                   : held->n[i] > 1 ? " nodes are"
                                    : " node is",
                   i == PL_CAUSE_BOUNDARY && job->is_surface ? "at corners" : words[i]);
            listed++;
        }
}

static void add_doubled(const pl_job *job, char *text, size_t size) {
    const int64_t n = job->held.n_doubled, n_used = job->mesh.n_nodes - job->held.n_unused;
    if (n > 0 && n != job->held.n[PL_CAUSE_DOUBLED])
        append(text, size, "; %" PRId64 " of them %s at the place of other nodes%s", n,
               n == 1 ? "is" : "are",
               n_used == job->mesh.n_elements * (pl_job_element_dim(job) + 1)
                   ? " (each element has its own points)"
                   : "");
}

void pl_held_print(FILE *stream, const pl_job *job) {
    char text[1024] = "held: ";
    if (!job->held.is_known)
        return;
    if (job->held.n_held == 0)
        append(text, sizeof text, "no node");
    add_counts(job, text, sizeof text);
    add_doubled(job, text, sizeof text);
    if (job->held.n_mids > 0)
        append(text, sizeof text, "; %" PRId64 " mid-side %s", job->held.n_mids,
               job->held.n_mids == 1 ? "node follows" : "nodes follow");
    if (job->held.n_unused > 0)
        append(text, sizeof text, "; %" PRId64 " more %s in no element", job->held.n_unused,
               job->held.n_unused == 1 ? "node is" : "nodes are");
    pl_terminal_wrap(stream, text);
}

void pl_held_explain(const pl_job *job, char *text, size_t size) {
    const pl_held *held = &job->held;
    text[0] = '\0';
    if (!held->is_known || held->n_held == 0)
        return;
    add_counts(job, text, size);
    add_doubled(job, text, size);
    /* What would let nodes move. */
    if (held->n_doubled > held->n_held / 2)
        append(text, size, ": merge equal points first");
    else if (job->could_slide > 0)
        append(text, size, ": --slide auto lets %" PRId64 " of them slide", job->could_slide);
    else if (held->n[PL_CAUSE_LAYERS] > 0)
        append(text, size, ": --layers ignore lets those on thin layers move");
    else if (held->n[PL_CAUSE_FIX] > 0)
        append(text, size, ": name fewer groups in --fix");
    else if (held->n[PL_CAUSE_INTERFACE] > 0)
        append(text, size, ": --ignore-regions lets nodes between regions move");
}

void pl_held_note(FILE *stream, const pl_job *job) {
    char text[512];
    /* The command quality makes no plan of elements of other types. */
    if (job->plan_info.n_free + job->plan_info.n_sliding > 0 || pl_job_lacks_types(job))
        return;
    pl_held_explain(job, text, sizeof text);
    pl_note(stream, "no node is free to move%s%s", text[0] ? ": " : "", text);
}
