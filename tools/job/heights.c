/* heights: what becomes of the heights of layers. */
#include "job/heights.h"

#include "options/combinations.h"
#include "terminal/message.h"
#include "terminal/terminal.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Changes above this part are much: of kept layers they are undone. Then nodes are held from the second
 * part on: those beside would change more. */
static const double MUCH = 0.1, HELD_FROM = 0.05;

/* Rings of elements around those that are not valid whose nodes are not held: rows beside a height that
 * grows have to make room. */
enum { RELEASED_RINGS = 4 };

/* Changes are as percentages up to this many times the height. */
static const double MOST_PERCENT = 10;

/** Whether elements are to be like those of another mesh. */
static int is_like(const pl_job *job) {
    return job->arguments->like && job->like.place && !job->like.sizes.size &&
           !job->like.sizes.metric;
}

/** Find the layers of the mesh of --like. */
static int find_layers_there(pl_job *job) {
    planish_mesh mesh;
    planish_cells cells;
    planish_error error;
    int64_t n = 0;
    int status = pl_job_layer_mesh(job, &cells, &mesh);
    if (status)
        return status;
    uint8_t *mark = malloc((size_t)mesh.n_elements + 1);
    if (!mark)
        return pl_job_complain_memory(job, "values of elements");
    mesh.coordinates = job->like.place;
    if (mesh.n_elements > 0 && planish_find_layers(&mesh, job->options.threads, mark, &n, &error))
        status = pl_job_complain(job, PL_EXIT_FAILED, &error);
    if (n > 0)
        job->wanted.is_layer = mark;
    else
        free(mark);
    return status;
}

int pl_heights_begin(pl_job *job) {
    const size_t size = (size_t)(job->mesh.n_nodes * job->mesh.dim) * sizeof *job->wanted.place;
    if (!job->file || job->is_surface || !job->mesh.coordinates)
        return 0;
    if (is_like(job))
        return find_layers_there(job);
    if (!job->wanted.is_layer)
        return 0;
    job->wanted.place = malloc(size);
    if (!job->wanted.place)
        return pl_job_complain_memory(job, "places of nodes");
    memcpy(job->wanted.place, job->mesh.coordinates, size);
    return 0;
}

/** Compare heights; off [n_nodes]: as of planish_measure_layers. */
static int measure(const pl_job *job, planish_layer_heights *heights, double *off) {
    planish_mesh mesh;
    planish_cells cells;
    planish_error error;
    const int status = pl_job_layer_mesh(job, &cells, &mesh);
    if (status)
        return status;
    mesh.is_layer = job->wanted.is_layer ? job->wanted.is_layer : job->like.is_layer;
    mesh.reference = job->wanted.place ? job->wanted.place : job->like.place;
    mesh.size = mesh.metric = NULL;
    return planish_measure_layers(&mesh, job->options.threads, heights, off, &error)
               ? pl_job_complain(job, PL_EXIT_FAILED, &error)
               : 0;
}

int pl_heights_measure(const pl_job *job, pl_heights *heights) {
    *heights = (pl_heights){.is_known = 0};
    if (!job->file || job->is_surface || (!job->wanted.place && !job->like.place) ||
        (!job->wanted.is_layer && !job->like.is_layer))
        return 0;
    const int status = measure(job, &heights->of, NULL);
    heights->is_known = !status && heights->of.all.n > 0;
    return status;
}

/** Let all nodes of layers be off by much. */
static void spread_off(const pl_job *job, double *off) {
    int corners;
    for (int64_t i = 0; i < job->mesh.n_elements; i++) {
        const int32_t *corner = pl_job_corners(job, i, &corners);
        for (int j = 0; job->like.is_layer[i] && j < corners; j++)
            off[corner[j]] = INFINITY;
    }
}

/** Find how much heights at each node are off: off [n_nodes], 0 at nodes that were released. *worst: the
 *  largest of these. */
static int find_off(const pl_job *job, double *off, double *worst) {
    planish_layer_heights heights;
    const int status = measure(job, &heights, off);
    *worst = 0;
    for (int64_t i = 0; !status && i < job->mesh.n_nodes; i++) {
        off[i] = job->wanted.is_released[i] ? 0 : off[i];
        *worst = fmax(*worst, off[i]);
    }
    return status;
}

/** Add the nodes that are off to those held, where the one that is off most is so by much; return how many are
 *  new. */
static int64_t add_nodes(const pl_job *job, int of_all, double worst, double *off,
                         uint8_t *in_layer) {
    const int64_t n_nodes = job->mesh.n_nodes;
    int64_t n = 0;
    if (worst > MUCH && of_all)
        spread_off(job, off);
    for (int64_t i = 0; worst > MUCH && i < n_nodes; i++)
        if (off[i] > HELD_FROM && job->constraint[i] != PLANISH_CONSTRAINT_FIXED &&
            !job->wanted.is_released[i]) {
            in_layer[i] = 1;
            n++;
        }
    return n;
}

/** Make room for what holding nodes needs, and begin with those that are held now: in_layer. */
static int begin_choice(pl_job *job, uint8_t *in_layer) {
    const size_t n = (size_t)job->mesh.n_nodes + 1;
    pl_wanted_heights *wanted = &job->wanted;
    if (!job->in_layer)
        job->in_layer = calloc(n, 1);
    if (!wanted->is_released)
        wanted->is_released = calloc(n, 1);
    if (!wanted->constraint) {
        wanted->constraint = malloc(n);
        if (wanted->constraint)
            memcpy(wanted->constraint, job->constraint, n - 1);
    }
    if (!job->in_layer || !wanted->is_released || !wanted->constraint)
        return pl_job_complain_memory(job, "heights of layers");
    memcpy(in_layer, job->in_layer, n - 1);
    return 0;
}

int pl_heights_choose(pl_job *job, int of_all, uint8_t *in_layer, int64_t *n, double *worst) {
    *n = 0;
    *worst = 0;
    if (!job->like.is_layer || !job->like.place)
        return 0;
    int status = begin_choice(job, in_layer);
    double *off = malloc(((size_t)job->mesh.n_nodes + 1) * sizeof *off);
    if (!status && !off)
        status = pl_job_complain_memory(job, "heights of layers");
    if (!status && off)
        status = find_off(job, off, worst);
    if (!status && off)
        *n = add_nodes(job, of_all, *worst, off, in_layer);
    free(off);
    return status;
}

int pl_heights_find_worst(const pl_job *job, double *worst) {
    double *off = malloc(((size_t)job->mesh.n_nodes + 1) * sizeof *off);
    const int status =
        off ? find_off(job, off, worst) : pl_job_complain_memory(job, "heights of layers");
    free(off);
    return status;
}

/** Mark all nodes of marked elements, */
static void mark_nodes(const pl_job *job, const uint8_t *is_marked, uint8_t *node) {
    int corners;
    for (int64_t i = 0; i < job->mesh.n_elements; i++) {
        const int32_t *corner = pl_job_corners(job, i, &corners);
        for (int j = 0; is_marked[i] && j < corners; j++)
            node[corner[j]] = 1;
    }
}

/** and all elements of marked nodes. */
static void mark_elements(const pl_job *job, const uint8_t *node, uint8_t *is_marked) {
    int corners;
    for (int64_t i = 0; i < job->mesh.n_elements; i++) {
        const int32_t *corner = pl_job_corners(job, i, &corners);
        for (int j = 0; j < corners; j++)
            is_marked[i] |= node[corner[j]];
    }
}

int64_t pl_heights_release(pl_job *job, uint8_t *is_faulty, uint8_t *in_layer) {
    uint8_t *is_released = job->wanted.is_released;
    int64_t n = 0;
    mark_nodes(job, is_faulty, is_released);
    for (int i = 0; i < RELEASED_RINGS; i++) {
        mark_elements(job, is_released, is_faulty);
        mark_nodes(job, is_faulty, is_released);
    }
    for (int64_t i = 0; i < job->mesh.n_nodes; i++) {
        in_layer[i] = job->in_layer[i] && !is_released[i];
        n += job->in_layer[i] != in_layer[i];
    }
    return n;
}

void pl_heights_hold(pl_job *job, const uint8_t *in_layer) {
    const uint8_t *before = job->wanted.constraint;
    job->wanted.n_held = 0;
    for (int64_t i = 0; i < job->mesh.n_nodes; i++) {
        job->in_layer[i] = in_layer[i];
        job->constraint[i] = in_layer[i] ? PLANISH_CONSTRAINT_FIXED : before[i];
        job->wanted.n_held += job->constraint[i] != before[i];
    }
}

/** Write by how much a height is off: "+7.3 %", "x 14". */
static void put_change(double ratio, char *text, size_t size) {
    const double percent = 100 * (ratio - 1);
    if (fabs(ratio) >= MOST_PERCENT)
        snprintf(text, size, "x %.3g", ratio);
    else
        snprintf(text, size, fabs(percent) < 9.95 ? "%+.1f %%" : "%+.0f %%", percent);
}

/** Write by how much heights of a row are off: "-2 % .. +7.3 %". */
static void put_row(const planish_layer_row *row, char *text, size_t size) {
    char least[32], most[32];
    put_change(row->min, least, sizeof least);
    put_change(row->max, most, sizeof most);
    snprintf(text, size, "%s .. %s", least, most);
}

/** Name of the mesh that heights are compared with. */
static const char *compared_with(const pl_job *job, const pl_heights *heights) {
    return is_like(job)             ? "those in the mesh of --like"
           : heights->of.n_told > 0 ? "those wanted"
                                    : "those before";
}

/** Say by how much heights are off. */
static void put_off(FILE *stream, const pl_job *job, const pl_heights *heights) {
    char all[80], first[80], median[32], text[400];
    put_row(&heights->of.all, all, sizeof all);
    put_row(&heights->of.row[0], first, sizeof first);
    put_change(heights->of.all.median, median, sizeof median);
    snprintf(text, sizeof text, "heights of layers: %s off %s, median %s; first row %s", all,
             compared_with(job, heights), median, first);
    pl_terminal_wrap(stream, text);
}

/** Say how many nodes are held for their heights. */
static void put_held(FILE *stream, int64_t n) {
    char text[400];
    snprintf(text, sizeof text,
             "%" PRId64 " %s held, as heights would change by more than %.0f %%.", n,
             n == 1 ? "node of layers is" : "nodes of layers are", 100 * MUCH);
    pl_terminal_wrap(stream, text);
}

/** Say how many heights other rows tell, and why. */
static void put_told(FILE *stream, const pl_job *job, const planish_layer_heights *of) {
    char reference[80], text[400];
    const int is_wall = of->n_at_moved_walls > 0;
    put_row(&of->reference, reference, sizeof reference);
    snprintf(text, sizeof text,
             "%s: %" PRId64 " of %" PRId64 " heights are told by %s; %s they were %s off.",
             is_wall ? "A wall was moved" : "Nodes of layers were displaced", of->n_told, of->all.n,
             is_wall ? "the rows inside" : "other rows", is_like(job) ? "in that mesh" : "before",
             reference);
    pl_terminal_wrap(stream, text);
}

void pl_heights_put(FILE *stream, const pl_job *job, const pl_heights *heights) {
    const int64_t n_told = heights->of.n_told;
    const int is_asked = job->arguments->command != PL_COMMAND_QUALITY || is_like(job);
    if (!heights->is_known || (!is_asked && n_told == 0))
        return;
    put_off(stream, job, heights);
    if (job->wanted.n_held > 0)
        put_held(stream, job->wanted.n_held);
    if (n_told > 0 && is_asked)
        put_told(stream, job, &heights->of);
}

/** Find the row that is off most: by how much, and its number *row from 1. */
static double find_worst(const planish_layer_heights *of, int *row) {
    double worst = 0;
    *row = 1;
    for (int i = 0; i < of->n_rows; i++) {
        const double off = fmax(1 - of->row[i].min, of->row[i].max - 1);
        if (of->row[i].n > 0 && off > worst) {
            worst = off;
            *row = i + 1;
        }
    }
    return worst;
}

/** What keeps heights better; holding layers would keep inverted elements, too. is_valid: there were none. */
static const char *advice(const pl_job *job, const planish_layer_heights *of, int is_valid) {
    /* Sweeps are not repeated there, and a surface whose layers are held would not be fitted. */
    if (job->onto.fit)
        return ": with --onto they may change; --like IN keeps them better";
    if (of->n_at_moved_walls > 0)
        return is_valid ? ": --like FILE, the mesh before its wall moved, keeps them better, and "
                          "--layers hold keeps them as they are"
                        : ": --like FILE, the mesh before its wall moved, keeps them better";
    if (of->n_told > 0)
        return is_valid ? ": --like FILE, the mesh before nodes were displaced, keeps them "
                          "better, and --layers hold keeps them as they are"
                        : ": --like FILE, the mesh before nodes were displaced, keeps them better";
    if (job->layers.n_kept == 0)
        return is_valid ? ": --layers keep, or --fix-layers, keeps them"
                        : ": --layers keep keeps them";
    return is_valid ? ": --layers hold keeps them all" : "";
}

void pl_heights_note(FILE *stream, const pl_job *job, const pl_heights *heights, int is_valid) {
    char all[80], why[160];
    int row;
    if (!heights->is_known || !(find_worst(&heights->of, &row) > MUCH))
        return;
    put_row(&heights->of.all, all, sizeof all);
    snprintf(why, sizeof why,
             ": with their nodes held %" PRId64 " more element%s would stay inverted",
             job->wanted.n_faults, job->wanted.n_faults == 1 ? "" : "s");
    pl_note(stream, "heights of layers are %s off %s, most in row %d%s%s", all,
            compared_with(job, heights), row, row == PLANISH_LAYER_ROWS ? " or above" : "",
            is_like(job)               ? ""
            : job->wanted.n_faults > 0 ? why
                                       : advice(job, &heights->of, is_valid));
}
