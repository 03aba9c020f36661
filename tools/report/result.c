/* result: what a run has come to, and its report as JSON.
 *
 * Real numbers are written with the fewest digits that restore them, those that are not finite as
 * null. The keys are a contract: they are only ever added.
 */
#include "report/result.h"
#include "options/combinations.h"

#include "job/held.h"
#include "job/sizes.h"
#include "terminal/platform.h"
#include "terminal/text.h"

#include <cjson/cJSON.h>

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/** A document that is being made. cJSON calls may fail for want of memory; failed remembers. */
typedef struct document {
    int failed;
} document;

/** Add item to parent, which may be NULL for want of memory; item, or NULL if it was released. */
static cJSON *add(document *json, cJSON *parent, const char *name, cJSON *item) {
    const int done =
        name ? cJSON_AddItemToObject(parent, name, item) : cJSON_AddItemToArray(parent, item);
    if (done)
        return item;
    cJSON_Delete(item);
    json->failed = 1;
    return NULL;
}

static cJSON *new_object(document *json, cJSON *parent, const char *name) {
    return add(json, parent, name, cJSON_CreateObject());
}

static cJSON *new_array(document *json, cJSON *parent, const char *name) {
    return add(json, parent, name, cJSON_CreateArray());
}

static void add_integer(document *json, cJSON *parent, const char *name, int64_t value) {
    char text[32]; /* as text: a double would lose digits above 2^53 */
    snprintf(text, sizeof text, "%" PRId64, value);
    add(json, parent, name, cJSON_CreateRaw(text));
}

static void add_real(document *json, cJSON *parent, const char *name, double value) {
    char text[32];
    if (!isfinite(value)) {
        add(json, parent, name, cJSON_CreateNull());
        return;
    }
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value)
            break;
    }
    add(json, parent, name, cJSON_CreateRaw(text));
}

/** Add text to JSON, which is UTF-8: other bytes, in names of files, become U+FFFD. */
static void add_text(document *json, cJSON *parent, const char *name, const char *text) {
    char *clean = malloc(3 * strlen(text) + 1), *to = clean;
    if (!clean) {
        json->failed = 1;
        return;
    }
    for (const char *from = text; *from;) {
        const int length = pl_utf8_length(from);
        const int n = length ? length : 3;
        memcpy(to, length ? from : PL_UTF8_REPLACEMENT, (size_t)n);
        to += n;
        from += length ? length : 1;
    }
    *to = '\0';
    add(json, parent, name, cJSON_CreateString(clean));
    free(clean);
}

/** Add an integer, or null if it is negative: not looked for. */
static void add_known(document *json, cJSON *parent, const char *name, int64_t value) {
    if (value >= 0)
        add_integer(json, parent, name, value);
    else
        add(json, parent, name, cJSON_CreateNull());
}

static void add_vector(document *json, cJSON *to, const char *name, const double *vector) {
    cJSON *array = new_array(json, to, name);
    for (int d = 0; d < 3; d++)
        add_real(json, array, NULL, vector[d]);
}

/** The plane of triangles; null: that of x and y, or tetrahedra. */
static void add_plane(document *json, cJSON *mesh, const pl_job *job) {
    planish_plane plane;
    if (!job->file || !planish_file_plane(job->file, &plane)) {
        add(json, mesh, "plane", cJSON_CreateNull());
        return;
    }
    cJSON *of = new_object(json, mesh, "plane");
    add_vector(json, of, "normal", plane.normal);
    add_vector(json, of, "origin", plane.origin);
    cJSON *directions = new_array(json, of, "directions");
    for (int d = 0; d < 2; d++)
        add_vector(json, directions, NULL, plane.direction[d]);
    add(json, of, "tilted", cJSON_CreateBool(plane.is_tilted));
    add_real(json, of, "off", plane.off);
}

/** n_reversed: as measured of the input. */
static void add_mesh(document *json, cJSON *root, const pl_job *job, int64_t n_reversed) {
    const pl_held *held = &job->held;
    const pl_layers *layers = &job->layers;
    cJSON *mesh = new_object(json, root, "mesh");
    add_integer(json, mesh, "dimension", pl_job_element_dim(job));
    add(json, mesh, "in_space", cJSON_CreateBool(job->is_surface));
    add_plane(json, mesh, job);
    add_integer(json, mesh, "nodes", job->mesh.n_nodes);
    add_integer(json, mesh, "elements", job->mesh.n_elements);
    add_integer(json, mesh, "free_nodes", job->plan_info.n_free);
    add_integer(json, mesh, "sliding_nodes", job->plan_info.n_sliding);
    add_known(json, mesh, "could_slide", job->could_slide);
    if (held->is_known) {
        cJSON *reasons = new_object(json, mesh, "held");
        for (int i = 0; i < PL_N_HELD_BY; i++)
            add_integer(json, reasons, pl_held_name(i), held->n[i]);
    } else {
        add(json, mesh, "held", cJSON_CreateNull());
    }
    add_known(json, mesh, "mid_side_nodes", held->is_known ? held->n_mids : -1);
    add_known(json, mesh, "unused_nodes", held->is_known ? held->n_unused : -1);
    add_known(json, mesh, "doubled_nodes", held->is_known ? held->n_doubled : -1);
    add_known(json, mesh, "layer_elements", layers->n);
    add_known(json, mesh, "free_layer_elements", layers->n >= 0 ? layers->n_loose : -1);
    add_known(json, mesh, "held_layer_elements", layers->n >= 0 ? layers->n_held : -1);
    add_known(json, mesh, "kept_layer_elements", layers->n >= 0 ? layers->n_kept : -1);
    if (layers->n_held > 0 && layers->not_kept[0])
        add_text(json, mesh, "layers_not_kept_with", layers->not_kept);
    else
        add(json, mesh, "layers_not_kept_with", cJSON_CreateNull());
    add_integer(json, mesh, "fixed_elements", job->plan_info.n_fixed_elements);
    add_integer(json, mesh, "colours", job->plan_info.n_colours);
    add_integer(json, mesh, "nodes_with_parameters", job->n_with_parameters);
    add_integer(json, mesh, "reversed_elements", n_reversed);
    cJSON *arrays = new_array(json, mesh, "region_arrays");
    for (const char *const *name = pl_job_region_arrays(job); *name; name++)
        add_text(json, arrays, NULL, *name);
    add_integer(json, mesh, "wrapped_elements", job->plan_info.n_wrapped);
}

static void add_spread(document *json, cJSON *quality, const char *name, const planish_spread *s) {
    cJSON *spread = new_object(json, quality, name);
    add_real(json, spread, "min", s->min);
    add_real(json, spread, "mean", s->mean);
    add_real(json, spread, "max", s->max);
}

/** edge [n + 1], count [n]. */
static void add_histogram(document *json, cJSON *quality, const char *name, int n,
                          const double *edge, const int64_t *count) {
    cJSON *histogram = new_object(json, quality, name);
    cJSON *edges = new_array(json, histogram, "edges");
    cJSON *counts = new_array(json, histogram, "counts");
    for (int i = 0; i <= n; i++)
        add_real(json, edges, NULL, edge[i]);
    for (int i = 0; i < n; i++)
        add_integer(json, counts, NULL, count[i]);
}

/** Null: not looked for, as this process has not all of the mesh. */
static void add_worst_elements(document *json, cJSON *quality, const pl_job *job,
                               const pl_worst *worst) {
    if (!job->mesh.coordinates) {
        add(json, quality, "worst_elements", cJSON_CreateNull());
        return;
    }
    cJSON *list = new_array(json, quality, "worst_elements");
    for (int64_t i = 0; i < worst->n && !json->failed; i++) {
        const pl_bad_element *bad = &worst->bad[i];
        const double ratio = bad->ratio > 0 ? bad->ratio : NAN;
        cJSON *element = new_object(json, list, NULL);
        add_integer(json, element, "element", bad->number);
        if (worst->is_aspect_ratio) {
            add_text(json, element, "type", pl_cell_type_name(bad->type));
            add_real(json, element, "aspect_ratio", ratio);
        }
        add_real(json, element, "radius_ratio", worst->is_aspect_ratio ? NAN : ratio);
        add_real(json, element, "min_angle_deg", bad->smallest_angle_deg);
        add_real(json, element, "max_angle_deg", bad->largest_angle_deg);
        cJSON *place = new_array(json, element, "place");
        for (int d = 0; d < worst->columns; d++)
            add_real(json, place, NULL, bad->place[d]);
        cJSON *nodes = new_array(json, element, "nodes");
        for (int k = 0; k < bad->n_nodes; k++)
            add_integer(json, nodes, NULL, bad->node[k]);
        if (bad->region)
            add_text(json, element, "region", bad->region);
        else
            add(json, element, "region", cJSON_CreateNull());
        add(json, element, "movable", cJSON_CreateBool(bad->is_movable));
    }
}

/** Add the measures of simplices to quality. */
static void add_measures(document *json, cJSON *quality, const planish_quality *q,
                         int64_t n_inverted, int64_t below_min_volume) {
    add_integer(json, quality, "inverted", n_inverted);
    add_integer(json, quality, "reversed_elements", q->n_reversed);
    add_integer(json, quality, "below_min_volume", below_min_volume);
    add_real(json, quality, "min_volume", q->min_volume);
    add_real(json, quality, "max_volume", q->max_volume);
    add_real(json, quality, "total_volume", q->total_volume);
    add_real(json, quality, "rms_radius_ratio", q->rms_radius_ratio);
    add_real(json, quality, "rms_radius_ratio_movable", q->rms_radius_ratio_movable);
    add_real(json, quality, "mean_radius_ratio", q->mean_radius_ratio);
    add_real(json, quality, "max_radius_ratio", q->max_radius_ratio);
    add_real(json, quality, "min_dihedral_deg", q->min_angle_deg);
    add_real(json, quality, "max_dihedral_deg", q->max_angle_deg);
    add_real(json, quality, "max_radius_ratio_movable", q->max_radius_ratio_movable);
    add_real(json, quality, "min_dihedral_movable_deg", q->min_angle_deg_movable);
    add_spread(json, quality, "radius_ratio", &q->radius_ratio);
    add_spread(json, quality, "circumradius_to_edge", &q->circumradius_to_edge);
    add_spread(json, quality, "edge_to_inradius", &q->edge_to_inradius);
    add_spread(json, quality, "edge_ratio", &q->edge_ratio);
    add_spread(json, quality, "mean_ratio", &q->mean_ratio);
    add_spread(json, quality, "scaled_jacobian", &q->scaled_jacobian);
    add_spread(json, quality, "smallest_angle_deg", &q->smallest_angle_deg);
    add_spread(json, quality, "largest_angle_deg", &q->largest_angle_deg);
    add_histogram(json, quality, "histogram", PLANISH_HISTOGRAM_BINS, q->histogram_edges,
                  q->histogram_counts);
    add_histogram(json, quality, "angle_histogram", PLANISH_ANGLE_BINS, q->angle_edges_deg,
                  q->angle_counts);
}

/** Add the measures of elements of any type beside the number of inverted ones. */
static void add_cell_measures(document *json, cJSON *to, const planish_cell_measures *of) {
    add_integer(json, to, "corner_inverted", of->n_inverted_corners);
    add_integer(json, to, "uncertified", of->n_uncertified);
    add_integer(json, to, "curved", of->n_curved);
    add_real(json, to, "rms_aspect_ratio", of->rms_aspect_ratio);
    add_real(json, to, "mean_aspect_ratio", of->mean_aspect_ratio);
    add_real(json, to, "max_aspect_ratio", of->max_aspect_ratio);
    add_real(json, to, "min_scaled_jacobian", of->min_scaled_jacobian);
    add_real(json, to, "min_jacobian_ratio", of->min_jacobian_ratio);
    add_real(json, to, "max_edge_ratio", of->max_edge_ratio);
}

/** Add the number of elements of each type, and their measures. */
static void add_types(document *json, cJSON *quality, const planish_cell_quality *q) {
    cJSON *counts = new_object(json, quality, "counts");
    for (int i = 0; i < q->n_types; i++)
        add_integer(json, counts, pl_cell_type_name(q->type[i]), q->by_type[i].n_elements);
    add_cell_measures(json, quality, &q->all);
    cJSON *by_type = new_object(json, quality, "by_type");
    for (int i = 0; i < q->n_types; i++) {
        cJSON *of = new_object(json, by_type, pl_cell_type_name(q->type[i]));
        add_integer(json, of, "inverted", q->by_type[i].n_inverted);
        add_cell_measures(json, of, &q->by_type[i]);
    }
}

/** Add the sizes of elements against those that are wanted, if sizes are asked for. */
static void add_sizes(document *json, cJSON *quality, const pl_job *job,
                      const planish_size_quality *sizes) {
    if (!pl_like_has_sizes(&job->like))
        return;
    cJSON *to = new_object(json, quality, "sizes");
    add_real(json, to, "factor", sizes->factor);
    add_real(json, to, "rms_log", sizes->rms_log);
    add_real(json, to, "least", sizes->least);
    add_real(json, to, "most", sizes->most);
    add_known(json, to, "smallest_element",
              sizes->smallest < 0 ? -1 : pl_job_element_number(job, sizes->smallest));
    add_known(json, to, "largest_element",
              sizes->largest < 0 ? -1 : pl_job_element_number(job, sizes->largest));
}

/** Add the quality of simplices: by their corners, and where validity is known also by their
 *  mid-side nodes. edge_ratio and scaled_jacobian are those of the corners. */
static void add_quality(document *json, cJSON *root, const char *name, const pl_job *job,
                        const planish_quality *q, const pl_validity *validity,
                        int64_t below_min_volume, const pl_worst *worst) {
    cJSON *quality = new_object(json, root, name);
    add_measures(json, quality, q,
                 validity->is_known ? validity->quality.all.n_inverted : q->n_inverted,
                 below_min_volume);
    if (validity->is_known) {
        add_types(json, quality, &validity->quality);
        add_integer(json, quality, "inverted_inside", validity->n_inside);
    }
    add_worst_elements(json, quality, job, worst);
}

/** Add the quality of a mesh with elements of other types before or after smoothing: by cells, and
 *  what the plan knows of their nodes. The keys of radius ratios and angles are null. */
static void add_smoothed_cells(document *json, cJSON *root, const char *name, const pl_job *job,
                               const planish_quality *q, const pl_validity *validity,
                               int64_t below_min_volume, const pl_worst *worst) {
    static const char *const of_simplices[] = {"rms_radius_ratio",
                                               "rms_radius_ratio_movable",
                                               "mean_radius_ratio",
                                               "max_radius_ratio",
                                               "max_radius_ratio_movable",
                                               "min_dihedral_deg",
                                               "max_dihedral_deg",
                                               "min_dihedral_movable_deg",
                                               "radius_ratio",
                                               "edge_to_inradius",
                                               "circumradius_to_edge",
                                               "edge_ratio",
                                               "mean_ratio",
                                               "scaled_jacobian",
                                               "smallest_angle_deg",
                                               "largest_angle_deg",
                                               "histogram",
                                               "angle_histogram"};
    cJSON *quality = new_object(json, root, name);
    add_integer(json, quality, "inverted", pl_validity_faults(validity, q));
    add_types(json, quality, &validity->quality);
    add_sizes(json, quality, job, &validity->sizes);
    add_integer(json, quality, "inverted_inside", validity->n_inside);
    add_real(json, quality, "rms_aspect_ratio_movable", q->rms_radius_ratio_movable);
    add_real(json, quality, "max_aspect_ratio_movable", q->max_radius_ratio_movable);
    add_histogram(json, quality, "aspect_histogram", PLANISH_HISTOGRAM_BINS, q->histogram_edges,
                  q->histogram_counts);
    add_integer(json, quality, "reversed_elements", q->n_reversed);
    add_integer(json, quality, "below_min_volume", below_min_volume);
    add_real(json, quality, "min_volume", q->min_volume);
    add_real(json, quality, "max_volume", q->max_volume);
    add_real(json, quality, "total_volume", q->total_volume);
    for (size_t i = 0; i < sizeof of_simplices / sizeof *of_simplices; i++)
        add(json, quality, of_simplices[i], cJSON_CreateNull());
    add_worst_elements(json, quality, job, worst);
}

/** Add the quality of a mesh with elements of other types. The keys of simplices are null, as these
 *  measures do not exist of all elements; the object `simplices` has them. */
static void add_cells(document *json, cJSON *root, const pl_job *job, const pl_measured *measured) {
    static const char *const of_simplices[] = {"reversed_elements",
                                               "below_min_volume",
                                               "min_volume",
                                               "max_volume",
                                               "total_volume",
                                               "rms_radius_ratio",
                                               "rms_radius_ratio_movable",
                                               "mean_radius_ratio",
                                               "max_radius_ratio",
                                               "min_dihedral_deg",
                                               "max_dihedral_deg",
                                               "max_radius_ratio_movable",
                                               "min_dihedral_movable_deg",
                                               "radius_ratio",
                                               "circumradius_to_edge",
                                               "edge_to_inradius",
                                               "edge_ratio",
                                               "mean_ratio",
                                               "scaled_jacobian",
                                               "smallest_angle_deg",
                                               "largest_angle_deg",
                                               "histogram",
                                               "angle_histogram"};
    const planish_cell_quality *q = &measured->cells.quality;
    cJSON *quality = new_object(json, root, "quality");
    add_integer(json, quality, "inverted", q->all.n_inverted);
    add_types(json, quality, q);
    add_sizes(json, quality, job, &measured->cells.sizes);
    for (size_t i = 0; i < sizeof of_simplices / sizeof *of_simplices; i++)
        add(json, quality, of_simplices[i], cJSON_CreateNull());
    if (job->mesh.n_elements > 0)
        add_measures(json, new_object(json, quality, "simplices"), &measured->quality,
                     measured->quality.n_inverted, measured->volumes.n_below);
    else
        add(json, quality, "simplices", cJSON_CreateNull());
    add_worst_elements(json, quality, job, &measured->worst);
}

static void add_sweeps(document *json, cJSON *root, const pl_progress *progress) {
    static const char *const phases[] = {[PLANISH_PHASE_SMOOTH] = "smooth",
                                         [PLANISH_PHASE_UNTANGLE] = "untangle",
                                         [PLANISH_PHASE_WORST] = "worst"};
    cJSON *sweeps = new_array(json, root, "sweeps");
    for (int64_t i = 0; i < progress->n_sweeps; i++) {
        const pl_sweep *done = &progress->sweep[i];
        cJSON *sweep = new_object(json, sweeps, NULL);
        add_text(json, sweep, "phase", phases[done->phase]);
        add_real(json, sweep, "rms", done->rms);
        add_real(json, sweep, "rms_movable", done->rms_movable);
        add_real(json, sweep, "objective", done->objective);
        add_integer(json, sweep, "inverted", done->inverted);
        add_integer(json, sweep, "below_min_volume", done->below_min_volume);
        add_integer(json, sweep, "visits", done->visits);
        add_real(json, sweep, "seconds", done->seconds);
    }
}

static const char *const stop_names[] = {[PLANISH_STOP_CONVERGED] = "converged",
                                         [PLANISH_STOP_MAX_SWEEPS] = "max-sweeps",
                                         [PLANISH_STOP_TIME_LIMIT] = "time-limit",
                                         [PLANISH_STOP_INTERRUPTED] = "interrupted",
                                         [PLANISH_STOP_INFEASIBLE] = "infeasible"};

/** Add how it was done: threads, processes and seconds. */
static void add_run(document *json, cJSON *root, const pl_job *job, const pl_result *result) {
    const pl_traffic *traffic = &job->traffic;
    add_integer(json, root, "threads", job->plan_info.threads);
    add_text(json, root, "binding", job->plan_info.binding);
    add_text(json, root, "isa", job->plan_info.isa);
    if (traffic->n_processes > 0) {
        cJSON *processes = new_object(json, root, "processes");
        add_integer(json, processes, "count", traffic->n_processes);
        add(json, processes, "in_parts", cJSON_CreateBool(traffic->in_parts));
        add_integer(json, processes, "messages", traffic->messages);
        add_integer(json, processes, "node_values", traffic->nodes);
        add_integer(json, processes, "bytes", traffic->bytes);
        add_real(json, processes, "longest_wait_seconds", traffic->wait_seconds);
    }
    cJSON *seconds = new_object(json, root, "seconds");
    add_real(json, seconds, "read", job->read_seconds);
    add_real(json, seconds, "shape", job->shape_seconds);
    add_real(json, seconds, "setup", job->setup_seconds);
    add_real(json, seconds, "smooth", result->smooth_seconds);
    add_real(json, seconds, "write", result->write_seconds);
    add_real(json, seconds, "total", result->total_seconds);
}

/** Add the objective. F over no valid element is 0, and has no value. */
static void add_objective(document *json, cJSON *root, const pl_job *job,
                          const planish_result *smooth) {
    const double before = smooth->objective_before, after = smooth->objective;
    cJSON *objective = new_object(json, root, "objective");
    add_text(json, objective, "name", pl_objective_name(pl_job_objective(job)));
    add_text(json, objective, "measure", job->has_types ? "aspect-ratio" : "radius-ratio");
    add_real(json, objective, "area_weight", job->options.area_weight);
    add_real(json, objective, "size_weight", job->options.size_weight);
    add_real(json, objective, "before", before > 0 ? before : NAN);
    add_real(json, objective, "after", after > 0 ? after : NAN);
}

/** Add the checksum of coordinates as written or read: in full, whatever the format's digits. */
static void add_checksum(document *json, cJSON *root, const char *name, uint64_t checksum) {
    char text[17];
    snprintf(text, sizeof text, "%016" PRIx64, checksum);
    add_text(json, root, name, text);
}

/** Add what elements are measured against: regular ones, layers as they were, or those of another file,
 *  with the checksum of its coordinates. */
static void add_target(document *json, cJSON *root, const pl_job *job) {
    add_text(json, root, "target",
             job->like.sizes.metric ? "metric"
             : job->like.sizes.size ? "sizes"
             : job->like.is_layer   ? "layers"
             : job->like.place      ? "like"
                                    : "regular");
    if (pl_like_has_sizes(&job->like))
        add_text(json, root, "sizes_of", pl_sizes_source(job->arguments));
    if (!job->arguments->like || !job->like.place)
        return;
    add_text(json, root, "like", job->arguments->like);
    add_checksum(json, root, "like_checksum", job->like.checksum);
}

/** Add what heights of a row of a layer are, over those that are wanted. */
static void add_layer_row(document *json, cJSON *to, const planish_layer_row *row) {
    add_integer(json, to, "edges", row->n);
    add_real(json, to, "least", row->least);
    add_real(json, to, "median", row->median);
    add_real(json, to, "most", row->most);
}

/** Add the heights of layers, over those that are wanted; null: there are none, or nobody asked. */
static void add_heights(document *json, cJSON *root, const pl_job *job, const pl_heights *heights) {
    const planish_layer_heights *of = &heights->of;
    if (!heights->is_known) {
        add(json, root, "layer_heights", cJSON_CreateNull());
        return;
    }
    cJSON *to = new_object(json, root, "layer_heights");
    add_text(json, to, "wanted", job->arguments->like ? "like" : "before");
    add_integer(json, to, "told_by_rows_inside", of->n_told);
    add_integer(json, to, "held_nodes", job->wanted.n_held);
    add_layer_row(json, to, &of->all);
    add_layer_row(json, new_object(json, to, "before"), &of->reference);
    cJSON *rows = new_array(json, to, "rows");
    for (int i = 0; i < of->n_rows; i++)
        add_layer_row(json, new_object(json, rows, NULL), &of->row[i]);
}

/** Add the gain of the worst elements; null: not asked for. */
static void add_worst(document *json, cJSON *root, const pl_job *job,
                      const planish_result *smooth) {
    if (smooth->worst_sweeps == 0) {
        add(json, root, "worst", cJSON_CreateNull());
        return;
    }
    cJSON *worst = new_object(json, root, "worst");
    add_text(json, worst, "measure", pl_worst_name(job->options.worst));
    add_integer(json, worst, "sweeps", smooth->worst_sweeps);
    add_real(json, worst, "before", smooth->worst_before);
    add_real(json, worst, "after", smooth->worst_after);
    add_real(json, worst, "objective_before", smooth->objective_of_worst);
    add_real(json, worst, "objective_after", smooth->objective);
    add_real(json, worst, "most_rise", job->options.worst_rise);
}

int pl_result_has_optimality(const pl_job *job) {
    const pl_arguments *arguments = job->arguments;
    return job->options.method == PLANISH_METHOD_PLANISH &&
           (pl_job_changes_objective(job) || pl_arguments_bound_volumes(arguments) ||
            arguments->n_box > 0 || job->options.max_displacement > 0);
}

static void add_optimality(document *json, cJSON *root, const pl_job *job,
                           const planish_result *smooth) {
    if (!pl_result_has_optimality(job)) {
        add(json, root, "kkt", cJSON_CreateNull());
        return;
    }
    cJSON *kkt = new_object(json, root, "kkt");
    add_real(json, kkt, "residual", smooth->kkt_residual);
    add_real(json, kkt, "rms", smooth->kkt_rms);
    add_real(json, kkt, "max_multiplier", smooth->max_multiplier);
    add_integer(json, kkt, "active", smooth->n_active);
}

/** The file's numbers of the elements whose state is at least least, or whose second state is not
 *  0; either may be NULL. */
static void add_elements(document *json, cJSON *root, const char *name, const pl_job *job,
                         const uint8_t *state, int least, const uint8_t *second) {
    cJSON *list = new_array(json, root, name);
    for (int64_t i = 0; (state || second) && i < job->mesh.n_elements && !json->failed; i++)
        if ((state && state[i] >= least) || (second && second[i]))
            add_integer(json, list, NULL, pl_job_element_number(job, i));
}

/** unfixable [n_elements]: inverted elements that cannot be repaired, or NULL. */
static void add_volumes(document *json, cJSON *root, const pl_job *job, const pl_volumes *volumes,
                        const uint8_t *unfixable) {
    const uint8_t *state = volumes->state;
    add_real(json, root, "min_volume", volumes->least > 0 ? volumes->least : NAN);
    add_elements(json, root, "unfixable", job, state, PLANISH_VOLUME_INFEASIBLE, unfixable);
    add_elements(json, root, "below_min", job, state, PLANISH_VOLUME_BELOW, NULL);
}

/** Add the ratios of elements that cannot change. */
static void add_fixed(document *json, cJSON *fixed, const pl_job *job,
                      const planish_quality *after) {
    const double rms = after->fixed_rms_radius_ratio, max = after->fixed_max_radius_ratio;
    add_real(json, fixed, "rms_radius_ratio", job->has_types ? NAN : rms);
    add_real(json, fixed, "max_radius_ratio", job->has_types ? NAN : max);
    if (job->has_types) {
        add_real(json, fixed, "rms_aspect_ratio", rms);
        add_real(json, fixed, "max_aspect_ratio", max);
    }
}

/** A copy of JSON text with a line end, in which characters that a terminal may not get are written
 *  by their numbers: cJSON does so with those below ' ' alone. NULL without memory. */
static char *escape_controls(const char *text) {
    enum { LENGTH = 6 }; /* of an escape */
    uint32_t code;
    size_t size = strlen(text) + 2;
    for (const char *from = text; *from; from++)
        size += pl_text_control(from, &code) ? LENGTH : 0;
    char *line = malloc(size), *to = line;
    for (const char *from = text; line && *from;) {
        const int length = (unsigned char)*from > '~' ? pl_text_control(from, &code) : 0;
        if (length > 0)
            to += snprintf(to, LENGTH + 1, "\\u%04x", (unsigned)code);
        else
            *to++ = *from;
        from += length > 0 ? length : 1;
    }
    if (line)
        memcpy(to, "\n", 2);
    return line;
}

/** The text of root with a line end, or NULL; root is released. */
static char *finish(document *json, cJSON *root) {
    char *text = json->failed ? NULL : cJSON_Print(root);
    cJSON_Delete(root);
    if (!text)
        return NULL;
    char *line = escape_controls(text);
    cJSON_free(text);
    return line;
}

/** Add the tolerance of the surface, in the unit that it was given in. */
static void add_surface_tolerance(document *json, cJSON *to, const planish_options *options) {
    const double usual = 0.05, given = options->surface_tolerance;
    const int is_of_mesh = given > 0 && options->surface_tolerance_unit == PLANISH_UNIT_MESH;
    add_real(json, to, "tolerance", given > 0 ? given : usual);
    add_text(json, to, "tolerance_unit", is_of_mesh ? "mesh" : "h");
}

/** Add proved distances between the surface and the original one, both ways. */
static void add_distance(document *json, cJSON *to, const planish_shape_distance *d) {
    add_real(json, to, "distance", d->distance);
    add_real(json, to, "distance_in_edges", d->in_edges);
    add_real(json, to, "distance_back", d->distance_back);
    add_real(json, to, "distance_back_in_edges", d->back_in_edges);
    add_integer(json, to, "unproved_facets", d->n_unproved);
    add_real(json, to, "max_bend_deg", d->max_bend);
    add_real(json, to, "max_bend_before_deg", d->max_bend_before);
}

/** Add the volumes of regions by tags: those that the file gives elements. */
static void add_region_volumes(document *json, cJSON *to, const pl_job *job,
                               const pl_surface_state *state) {
    cJSON *list = new_array(json, to, "volumes");
    for (int64_t i = 0; i < state->n_regions && !json->failed; i++) {
        const pl_region_volume *of = &state->region[i];
        char tag[256];
        if (of->before == 0 && of->after == 0) /* no element */
            continue;
        cJSON *region = new_object(json, list, NULL);
        planish_file_element_region(job->file, of->element, tag, sizeof tag);
        if (tag[0])
            add_text(json, region, "region", tag);
        else
            add(json, region, "region", cJSON_CreateNull());
        add_real(json, region, "before", of->before);
        add_real(json, region, "after", of->after);
    }
}

/** Add how the surface was fitted to another one. */
static void add_onto(document *json, cJSON *root, const pl_job *job) {
    const planish_fit_info *before = &job->onto.before, *after = &job->onto.after;
    const planish_shape_distance *d = &job->onto.distance;
    cJSON *surface = new_object(json, root, "surface");
    add_text(json, surface, "onto", job->arguments->onto);
    add_real(json, surface, "crease_angle", job->arguments->crease_angle);
    add_integer(json, surface, "nodes", before->n_nodes);
    add_integer(json, surface, "on_patches", before->n_on_patch);
    add_integer(json, surface, "on_curves", before->n_on_curve);
    add_integer(json, surface, "on_corners", before->n_on_corner);
    add_integer(json, surface, "out_of_reach", before->n_out_of_reach);
    add_integer(json, surface, "held", before->n_held);
    add_integer(json, surface, "off_before", before->n_off);
    add_real(json, surface, "farthest_before", before->farthest);
    add_integer(json, surface, "off", after->n_off);
    add_real(json, surface, "farthest", after->farthest);
    add_real(json, surface, "worst_ratio_of_input", job->onto.worst_before);
    add_real(json, surface, "fit_seconds", job->onto.seconds);
    add_real(json, surface, "distance", d->distance);
    add_real(json, surface, "distance_in_edges", d->in_edges);
    add_real(json, surface, "distance_back", d->distance_back);
    add_real(json, surface, "distance_back_in_edges", d->back_in_edges);
    add_integer(json, surface, "unproved_facets", d->n_unproved);
}

/** Add the surface: its features, the nodes that slide on it, and how far it has moved; null: nobody
 *  asked for its shape. smooth: NULL of the command quality. */
static void add_surface(document *json, cJSON *root, const pl_job *job,
                        const pl_surface_state *state, const planish_result *smooth) {
    const planish_shape_info *info = &job->curved.info;
    const int64_t *n = job->curved.n;
    if (job->onto.fit) {
        add_onto(json, root, job);
        return;
    }
    if (!job->curved.shape) {
        add(json, root, "surface", cJSON_CreateNull());
        return;
    }
    cJSON *surface = new_object(json, root, "surface");
    if (job->arguments->surface_of)
        add_text(json, surface, "original", job->arguments->surface_of);
    else
        add(json, surface, "original", cJSON_CreateNull());
    add_real(json, surface, "crease_angle", job->arguments->crease_angle);
    add(json, surface, "ignores_regions", cJSON_CreateBool(job->arguments->ignore_regions));
    add_integer(json, surface, "nodes", info->n_nodes);
    add_integer(json, surface, "patches", info->n_patches);
    add_integer(json, surface, "feature_edges", info->n_edges);
    add_integer(json, surface, "creases", info->n_creases);
    add_integer(json, surface, "corners", info->n_corners);
    add_real(json, surface, "edge_length", info->edge_length);
    add_integer(json, surface, "open_edges", info->n_open_edges);
    add_integer(json, surface, "nonmanifold_edges", info->n_nonmanifold_edges);
    add_integer(json, surface, "conflict_edges", info->n_conflict_edges);
    add_integer(json, surface, "turned_elements", info->n_turned);
    add_integer(json, surface, "flat_facets", info->n_flat);
    if (smooth) {
        add_integer(json, surface, "on_planes", n[PLANISH_CONSTRAINT_ON_PLANE]);
        add_integer(json, surface, "on_lines", n[PLANISH_CONSTRAINT_ON_LINE]);
        add_integer(json, surface, "on_patches", n[PLANISH_CONSTRAINT_ON_PATCH]);
        add_integer(json, surface, "on_curves", n[PLANISH_CONSTRAINT_ON_CURVE]);
        add_surface_tolerance(json, surface, &job->options);
        add_integer(json, surface, "refused_moves", smooth->n_off_shape);
    }
    if (!state->is_known)
        return;
    add_distance(json, surface, &state->after);
    if (!smooth)
        return;
    if (job->arguments->surface_of)
        add_distance(json, new_object(json, surface, "input"), &state->before);
    add_region_volumes(json, surface, job, state);
}

char *pl_result_smooth_json(const pl_job *job, const pl_result *result,
                            const pl_progress *progress) {
    const int is_run = job->arguments->command == PL_COMMAND_SMOOTH;
    document json = {0};
    cJSON *root = cJSON_CreateObject();
    add_text(&json, root, "planish", planish_version());
    add_text(&json, root, "input", job->arguments->input);
    add_text(&json, root, "output", job->arguments->output);
    add_text(&json, root, "format", job->file_info.format);
    add_mesh(&json, root, job, result->before.n_reversed);
    add_text(&json, root, "method", is_run ? pl_method_name(job->options.method) : "none");
    if (!is_run)
        add(&json, root, "compared", cJSON_CreateTrue());
    add_target(&json, root, job);
    add_heights(&json, root, job, &result->heights);
    add_objective(&json, root, job, &result->smooth);
    void (*const add_state)(document *, cJSON *, const char *, const pl_job *,
                            const planish_quality *, const pl_validity *, int64_t,
                            const pl_worst *) = job->has_types ? add_smoothed_cells : add_quality;
    add_state(&json, root, "before", job, &result->before, &result->validity_before,
              result->below_before, &result->worst_before);
    add_state(&json, root, "after", job, &result->after, &result->validity_after,
              result->volumes.n_below, &result->worst_after);
    add_sweeps(&json, root, progress);
    add_integer(&json, root, "untangling_sweeps", result->smooth.untangling_sweeps);
    if (is_run)
        add_text(&json, root, "stop", stop_names[result->smooth.stop]);
    else
        add(&json, root, "stop", cJSON_CreateNull());
    add(&json, root, "certified",
        cJSON_CreateBool(pl_validity_faults(&result->validity_after, &result->after) == 0));
    add_checksum(&json, root, "input_checksum", result->input_checksum);
    add_checksum(&json, root, "checksum", result->checksum);
    add_real(&json, root, "max_displacement", result->smooth.max_displacement);
    add_integer(&json, root, "put_back", result->smooth.n_put_back);
    add_integer(&json, root, "moved_nodes", result->smooth.n_moved_nodes);
    add_integer(&json, root, "returned_nodes", result->returned_nodes);
    add_integer(&json, root, "node_visits", result->smooth.visits);
    add_integer(&json, root, "evaluations", result->smooth.evaluations);
    add_integer(&json, root, "held_outside", result->smooth.n_held_outside);
    if (result->validity_after.is_known) {
        add_integer(&json, root, "refused_moves", result->smooth.n_refused);
        add_integer(&json, root, "released_mids", result->smooth.n_released_mids);
        add_integer(&json, root, "hopeless_curved", result->smooth.n_hopeless);
        add_elements(&json, root, "inverted_inside", job, result->validity_after.state,
                     PL_INVERTED_INSIDE, NULL);
    }
    add_worst(&json, root, job, &result->smooth);
    add_optimality(&json, root, job, &result->smooth);
    add_run(&json, root, job, result);
    cJSON *fixed = new_object(&json, root, "fixed");
    add_integer(&json, fixed, "count", result->after.n_fixed_elements);
    add_fixed(&json, fixed, job, &result->after);
    add_surface(&json, root, job, &result->surface, &result->smooth);
    add_volumes(&json, root, job, &result->volumes, result->unfixable.state);
    add_elements(&json, root, "reversed", job, NULL, PLANISH_VOLUME_MET, result->reversed.state);
    add_elements(&json, root, "wrapped", job, NULL, PLANISH_VOLUME_MET, job->wrapped);
    cJSON *held = new_object(&json, root, "inverted_held"); /* and stay so */
    add_integer(&json, held, "fix_layers", result->unfixable.n_held[PL_HOLDER_LAYERS]);
    add_integer(&json, held, "fix", result->unfixable.n_held[PL_HOLDER_FIX]);
    add_integer(&json, held, "regions", result->unfixable.n_held[PL_HOLDER_REGIONS]);
    add_text(&json, root, "reason", result->reason);
    add_integer(&json, root, "peak_memory_bytes", pl_peak_memory_bytes());
    return finish(&json, root);
}

void pl_quality_report_begin(pl_quality_report *report) {
    *report = (pl_quality_report){.meshes = cJSON_CreateArray()};
}

void pl_quality_report_add(pl_quality_report *report, const pl_job *job,
                           const pl_measured *measured) {
    document json = {report->failed};
    const pl_validity none = {.is_known = 0};
    cJSON *mesh = new_object(&json, report->meshes, NULL);
    add_text(&json, mesh, "planish", planish_version());
    add_text(&json, mesh, "input", job->arguments->input);
    add_text(&json, mesh, "format", job->file_info.format);
    add_mesh(&json, mesh, job, measured->quality.n_reversed);
    add_target(&json, mesh, job);
    add_heights(&json, mesh, job, &measured->heights);
    if (measured->cells.has_others)
        add_cells(&json, mesh, job, measured);
    else
        add_quality(&json, mesh, "quality", job, &measured->quality, &none,
                    measured->volumes.n_below, &measured->worst);
    add_checksum(&json, mesh, "checksum", pl_job_checksum(job));
    add_surface(&json, mesh, job, &measured->surface, NULL);
    add_volumes(&json, mesh, job, &measured->volumes, NULL);
    add_elements(&json, mesh, "reversed", job, NULL, PLANISH_VOLUME_MET, measured->reversed);
    add_elements(&json, mesh, "wrapped", job, NULL, PLANISH_VOLUME_MET, job->wrapped);
    report->failed = json.failed;
}

char *pl_quality_report_finish(pl_quality_report *report, int is_list) {
    document json = {report->failed};
    cJSON *root = NULL;
    if (is_list) {
        root = cJSON_CreateObject();
        add(&json, root, "meshes", report->meshes);
        report->meshes = NULL;
    } else {
        root = cJSON_DetachItemFromArray(report->meshes, 0);
    }
    return finish(&json, root);
}

void pl_quality_report_free(pl_quality_report *report) {
    cJSON_Delete(report->meshes);
    report->meshes = NULL;
}
