/* result: what a run has come to, and its report as JSON.
 *
 * The keys are a contract: they are only ever added.
 */
#include "report/result.h"
#include "options/combinations.h"

#include "job/held.h"
#include "job/sizes.h"
#include "report/result_quality.h"
#include "report/result_surface.h"
#include "terminal/platform.h"

#include <math.h>

static void add_vector(pl_json *json, cJSON *to, const char *name, const double *vector) {
    cJSON *array = pl_json_array(json, to, name);
    for (int d = 0; d < 3; d++)
        pl_json_real(json, array, NULL, vector[d]);
}

/** The plane of triangles; null: that of x and y, or tetrahedra. */
static void add_plane(pl_json *json, cJSON *mesh, const pl_job *job) {
    planish_plane plane;
    if (!job->file || !planish_file_plane(job->file, &plane)) {
        pl_json_add(json, mesh, "plane", cJSON_CreateNull());
        return;
    }
    cJSON *of = pl_json_object(json, mesh, "plane");
    add_vector(json, of, "normal", plane.normal);
    add_vector(json, of, "origin", plane.origin);
    cJSON *directions = pl_json_array(json, of, "directions");
    for (int d = 0; d < 2; d++)
        add_vector(json, directions, NULL, plane.direction[d]);
    pl_json_add(json, of, "tilted", cJSON_CreateBool(plane.is_tilted));
    pl_json_real(json, of, "off", plane.off);
}

/** n_reversed: as measured of the input. */
static void add_mesh(pl_json *json, cJSON *root, const pl_job *job, int64_t n_reversed) {
    const pl_held *held = &job->held;
    const pl_layers *layers = &job->layers;
    cJSON *mesh = pl_json_object(json, root, "mesh");
    pl_json_integer(json, mesh, "dimension", pl_job_element_dim(job));
    pl_json_add(json, mesh, "in_space", cJSON_CreateBool(job->is_surface));
    add_plane(json, mesh, job);
    pl_json_integer(json, mesh, "nodes", job->mesh.n_nodes);
    pl_json_integer(json, mesh, "elements", job->mesh.n_elements);
    pl_json_integer(json, mesh, "free_nodes", job->plan_info.n_free);
    pl_json_integer(json, mesh, "sliding_nodes", job->plan_info.n_sliding);
    pl_json_known(json, mesh, "could_slide", job->could_slide);
    if (held->is_known) {
        cJSON *reasons = pl_json_object(json, mesh, "held");
        for (int i = 0; i < PL_N_CAUSES; i++)
            pl_json_integer(json, reasons, pl_held_name(i), held->n[i]);
    } else {
        pl_json_add(json, mesh, "held", cJSON_CreateNull());
    }
    pl_json_known(json, mesh, "mid_side_nodes", held->is_known ? held->n_mids : -1);
    pl_json_known(json, mesh, "unused_nodes", held->is_known ? held->n_unused : -1);
    pl_json_known(json, mesh, "doubled_nodes", held->is_known ? held->n_doubled : -1);
    pl_json_known(json, mesh, "layer_elements", layers->n);
    pl_json_known(json, mesh, "free_layer_elements", layers->n >= 0 ? layers->n_loose : -1);
    pl_json_known(json, mesh, "held_layer_elements", layers->n >= 0 ? layers->n_held : -1);
    pl_json_known(json, mesh, "kept_layer_elements", layers->n >= 0 ? layers->n_kept : -1);
    if (layers->n_held > 0 && layers->not_kept[0])
        pl_json_text(json, mesh, "layers_not_kept_with", layers->not_kept);
    else
        pl_json_add(json, mesh, "layers_not_kept_with", cJSON_CreateNull());
    pl_json_integer(json, mesh, "fixed_elements", job->plan_info.n_fixed_elements);
    pl_json_integer(json, mesh, "colours", job->plan_info.n_colours);
    pl_json_integer(json, mesh, "nodes_with_parameters", job->n_with_parameters);
    pl_json_integer(json, mesh, "reversed_elements", n_reversed);
    cJSON *arrays = pl_json_array(json, mesh, "region_arrays");
    for (const char *const *name = pl_job_region_arrays(job); *name; name++)
        pl_json_text(json, arrays, NULL, *name);
    pl_json_integer(json, mesh, "wrapped_elements", job->plan_info.n_wrapped);
}

static void add_sweeps(pl_json *json, cJSON *root, const pl_progress *progress) {
    static const char *const phases[] = {[PLANISH_PHASE_SMOOTH] = "smooth",
                                         [PLANISH_PHASE_UNTANGLE] = "untangle",
                                         [PLANISH_PHASE_WORST] = "worst"};
    cJSON *sweeps = pl_json_array(json, root, "sweeps");
    for (int64_t i = 0; i < progress->n_sweeps; i++) {
        const pl_sweep *done = &progress->sweep[i];
        cJSON *sweep = pl_json_object(json, sweeps, NULL);
        pl_json_text(json, sweep, "phase", phases[done->phase]);
        pl_json_real(json, sweep, "rms", done->rms);
        pl_json_real(json, sweep, "rms_movable", done->rms_movable);
        pl_json_real(json, sweep, "objective", done->objective);
        pl_json_integer(json, sweep, "inverted", done->inverted);
        pl_json_integer(json, sweep, "below_min_volume", done->below_min_volume);
        pl_json_integer(json, sweep, "visits", done->visits);
        pl_json_real(json, sweep, "seconds", done->seconds);
    }
}

static const char *const stop_names[] = {[PLANISH_STOP_CONVERGED] = "converged",
                                         [PLANISH_STOP_MAX_SWEEPS] = "max-sweeps",
                                         [PLANISH_STOP_TIME_LIMIT] = "time-limit",
                                         [PLANISH_STOP_INTERRUPTED] = "interrupted",
                                         [PLANISH_STOP_INFEASIBLE] = "infeasible"};

/** Add how it was done: threads, processes and seconds. */
static void add_run(pl_json *json, cJSON *root, const pl_job *job, const pl_result *result) {
    const pl_traffic *traffic = &job->traffic;
    pl_json_integer(json, root, "threads", job->plan_info.threads);
    pl_json_text(json, root, "binding", job->plan_info.binding);
    pl_json_text(json, root, "isa", job->plan_info.isa);
    if (traffic->n_processes > 0) {
        cJSON *processes = pl_json_object(json, root, "processes");
        pl_json_integer(json, processes, "count", traffic->n_processes);
        pl_json_add(json, processes, "in_parts", cJSON_CreateBool(traffic->in_parts));
        pl_json_integer(json, processes, "messages", traffic->messages);
        pl_json_integer(json, processes, "node_values", traffic->nodes);
        pl_json_integer(json, processes, "bytes", traffic->bytes);
        pl_json_real(json, processes, "longest_wait_seconds", traffic->wait_seconds);
    }
    cJSON *seconds = pl_json_object(json, root, "seconds");
    pl_json_real(json, seconds, "read", job->read_seconds);
    pl_json_real(json, seconds, "shape", job->shape_seconds);
    pl_json_real(json, seconds, "setup", job->setup_seconds);
    pl_json_real(json, seconds, "smooth", result->smooth_seconds);
    pl_json_real(json, seconds, "write", result->write_seconds);
    pl_json_real(json, seconds, "total", result->total_seconds);
}

/** Add the objective. F over no valid element is 0, and has no value. */
static void add_objective(pl_json *json, cJSON *root, const pl_job *job,
                          const planish_result *smooth) {
    const double before = smooth->objective_before, after = smooth->objective;
    cJSON *objective = pl_json_object(json, root, "objective");
    pl_json_text(json, objective, "name", pl_objective_name(pl_job_objective(job)));
    pl_json_text(json, objective, "measure", job->has_types ? "aspect-ratio" : "radius-ratio");
    pl_json_real(json, objective, "area_weight", job->options.area_weight);
    pl_json_real(json, objective, "size_weight", job->options.size_weight);
    pl_json_real(json, objective, "before", before > 0 ? before : NAN);
    pl_json_real(json, objective, "after", after > 0 ? after : NAN);
}

/** Add what elements are measured against: regular ones, layers as they were, or those of another file,
 *  with the checksum of its coordinates. */
static void add_target(pl_json *json, cJSON *root, const pl_job *job) {
    pl_json_text(json, root, "target",
                 job->like.sizes.metric ? "metric"
                 : job->like.sizes.size ? "sizes"
                 : job->like.is_layer   ? "layers"
                 : job->like.place      ? "like"
                                        : "regular");
    if (pl_like_has_sizes(&job->like))
        pl_json_text(json, root, "sizes_of", pl_sizes_source(job->arguments));
    if (!job->arguments->like || !job->like.place)
        return;
    pl_json_text(json, root, "like", job->arguments->like);
    pl_json_checksum(json, root, "like_checksum", job->like.checksum);
}

/** Add what heights of a row of a layer are, over those that are wanted. */
static void add_layer_row(pl_json *json, cJSON *to, const planish_layer_row *row) {
    pl_json_integer(json, to, "edges", row->n);
    pl_json_real(json, to, "min", row->min);
    pl_json_real(json, to, "median", row->median);
    pl_json_real(json, to, "max", row->max);
}

/** Add the heights of layers, over those that are wanted; null: there are none, or nobody asked. */
static void add_heights(pl_json *json, cJSON *root, const pl_job *job, const pl_heights *heights) {
    const planish_layer_heights *of = &heights->of;
    if (!heights->is_known) {
        pl_json_add(json, root, "layer_heights", cJSON_CreateNull());
        return;
    }
    cJSON *to = pl_json_object(json, root, "layer_heights");
    pl_json_text(json, to, "wanted", job->arguments->like ? "like" : "before");
    pl_json_integer(json, to, "told_by_rows_inside", of->n_told);
    pl_json_integer(json, to, "at_moved_walls", of->n_at_moved_walls);
    pl_json_integer(json, to, "held_nodes", job->wanted.n_held);
    add_layer_row(json, to, &of->all);
    add_layer_row(json, pl_json_object(json, to, "before"), &of->reference);
    cJSON *rows = pl_json_array(json, to, "rows");
    for (int i = 0; i < of->n_rows; i++)
        add_layer_row(json, pl_json_object(json, rows, NULL), &of->row[i]);
}

/** Add the gain of the worst elements; null: not asked for. */
static void add_worst(pl_json *json, cJSON *root, const pl_job *job, const planish_result *smooth) {
    if (smooth->worst_sweeps == 0) {
        pl_json_add(json, root, "worst", cJSON_CreateNull());
        return;
    }
    cJSON *worst = pl_json_object(json, root, "worst");
    pl_json_text(json, worst, "measure", pl_worst_name(job->options.worst));
    pl_json_integer(json, worst, "sweeps", smooth->worst_sweeps);
    pl_json_real(json, worst, "before", smooth->worst_before);
    pl_json_real(json, worst, "after", smooth->worst_after);
    pl_json_real(json, worst, "objective_before", smooth->objective_of_worst);
    pl_json_real(json, worst, "objective_after", smooth->objective);
    pl_json_real(json, worst, "most_rise", job->options.worst_rise);
}

int pl_result_has_optimality(const pl_job *job) {
    const pl_arguments *arguments = job->arguments;
    return job->options.method == PLANISH_METHOD_PLANISH &&
           (pl_job_changes_objective(job) || pl_arguments_bound_volumes(arguments) ||
            arguments->n_box > 0 || job->options.max_displacement > 0);
}

static void add_optimality(pl_json *json, cJSON *root, const pl_job *job,
                           const planish_result *smooth) {
    if (!pl_result_has_optimality(job)) {
        pl_json_add(json, root, "kkt", cJSON_CreateNull());
        return;
    }
    cJSON *kkt = pl_json_object(json, root, "kkt");
    pl_json_real(json, kkt, "residual", smooth->kkt_residual);
    pl_json_real(json, kkt, "rms", smooth->kkt_rms);
    pl_json_real(json, kkt, "max_multiplier", smooth->max_multiplier);
    pl_json_integer(json, kkt, "active", smooth->n_active);
}

/** The file's numbers of the elements whose state is at least least, or whose second state is not
 *  0; either may be NULL. */
static void add_elements(pl_json *json, cJSON *root, const char *name, const pl_job *job,
                         const uint8_t *state, int least, const uint8_t *second) {
    cJSON *list = pl_json_array(json, root, name);
    for (int64_t i = 0; (state || second) && i < job->mesh.n_elements && !json->failed; i++)
        if ((state && state[i] >= least) || (second && second[i]))
            pl_json_integer(json, list, NULL, pl_job_element_number(job, i));
}

/** unfixable [n_elements]: inverted elements that cannot be repaired, or NULL. */
static void add_volumes(pl_json *json, cJSON *root, const pl_job *job, const pl_volumes *volumes,
                        const uint8_t *unfixable) {
    const uint8_t *state = volumes->state;
    pl_json_real(json, root, "min_volume", volumes->least > 0 ? volumes->least : NAN);
    add_elements(json, root, "unfixable", job, state, PLANISH_VOLUME_INFEASIBLE, unfixable);
    add_elements(json, root, "below_min", job, state, PLANISH_VOLUME_BELOW, NULL);
}

/** Add the ratios of elements that cannot change. */
static void add_fixed(pl_json *json, cJSON *fixed, const pl_job *job,
                      const planish_quality *after) {
    const double rms = after->fixed_rms_radius_ratio, max = after->fixed_max_radius_ratio;
    pl_json_real(json, fixed, "rms_radius_ratio", job->has_types ? NAN : rms);
    pl_json_real(json, fixed, "max_radius_ratio", job->has_types ? NAN : max);
    if (job->has_types) {
        pl_json_real(json, fixed, "rms_aspect_ratio", rms);
        pl_json_real(json, fixed, "max_aspect_ratio", max);
    }
}

char *pl_result_smooth_json(const pl_job *job, const pl_result *result,
                            const pl_progress *progress) {
    const int is_run = job->arguments->command == PL_COMMAND_SMOOTH;
    pl_json json = {0};
    cJSON *root = cJSON_CreateObject();
    pl_json_text(&json, root, "planish", planish_version());
    pl_json_text(&json, root, "input", job->arguments->input);
    pl_json_text(&json, root, "output", job->arguments->output);
    pl_json_text(&json, root, "format", job->file_info.format);
    add_mesh(&json, root, job, result->before.n_reversed);
    pl_json_text(&json, root, "method", is_run ? pl_method_name(job->options.method) : "none");
    if (!is_run)
        pl_json_add(&json, root, "compared", cJSON_CreateTrue());
    add_target(&json, root, job);
    add_heights(&json, root, job, &result->heights);
    add_objective(&json, root, job, &result->smooth);
    void (*const add_state)(pl_json *, cJSON *, const char *, const pl_job *,
                            const planish_quality *, const pl_cells_validity *, int64_t,
                            const pl_worst *) =
        job->has_types ? pl_result_add_smoothed_cells : pl_result_add_quality;
    add_state(&json, root, "before", job, &result->before, &result->validity_before,
              result->below_before, &result->worst_before);
    add_state(&json, root, "after", job, &result->after, &result->validity_after,
              result->volumes.n_below, &result->worst_after);
    add_sweeps(&json, root, progress);
    pl_json_integer(&json, root, "untangling_sweeps", result->smooth.untangling_sweeps);
    if (is_run)
        pl_json_text(&json, root, "stop", stop_names[result->smooth.stop]);
    else
        pl_json_add(&json, root, "stop", cJSON_CreateNull());
    pl_json_add(
        &json, root, "certified",
        cJSON_CreateBool(pl_cells_validity_faults(&result->validity_after, &result->after) == 0));
    pl_json_checksum(&json, root, "input_checksum", result->input_checksum);
    pl_json_checksum(&json, root, "checksum", result->checksum);
    pl_json_real(&json, root, "max_displacement", result->smooth.max_displacement);
    pl_json_integer(&json, root, "put_back", result->smooth.n_put_back);
    pl_json_integer(&json, root, "moved_nodes", result->smooth.n_moved_nodes);
    pl_json_integer(&json, root, "returned_nodes", result->returned_nodes);
    pl_json_integer(&json, root, "node_visits", result->smooth.visits);
    pl_json_integer(&json, root, "evaluations", result->smooth.evaluations);
    pl_json_integer(&json, root, "held_outside", result->smooth.n_held_outside);
    if (result->validity_after.is_known) {
        pl_json_integer(&json, root, "refused_moves", result->smooth.n_refused);
        pl_json_integer(&json, root, "released_mids", result->smooth.n_released_mids);
        pl_json_integer(&json, root, "infeasible_curved", result->smooth.n_infeasible_curved);
        add_elements(&json, root, "inverted_inside", job, result->validity_after.state,
                     PL_INVERTED_INSIDE, NULL);
    }
    add_worst(&json, root, job, &result->smooth);
    add_optimality(&json, root, job, &result->smooth);
    add_run(&json, root, job, result);
    cJSON *fixed = pl_json_object(&json, root, "fixed");
    pl_json_integer(&json, fixed, "count", result->after.n_fixed_elements);
    add_fixed(&json, fixed, job, &result->after);
    pl_result_add_surface(&json, root, job, &result->surface, &result->smooth);
    add_volumes(&json, root, job, &result->volumes, result->unfixable.state);
    add_elements(&json, root, "reversed", job, NULL, PLANISH_VOLUME_MET, result->reversed.state);
    add_elements(&json, root, "wrapped", job, NULL, PLANISH_VOLUME_MET, job->wrapped);
    cJSON *held = pl_json_object(&json, root, "inverted_held"); /* and stay so */
    pl_json_integer(&json, held, "fix_layers", result->unfixable.n_held[PL_HOLDER_LAYERS]);
    pl_json_integer(&json, held, "fix", result->unfixable.n_held[PL_HOLDER_FIX]);
    pl_json_integer(&json, held, "regions", result->unfixable.n_held[PL_HOLDER_REGIONS]);
    pl_json_text(&json, root, "reason", result->reason);
    pl_json_integer(&json, root, "peak_memory_bytes", pl_peak_memory_bytes());
    return pl_json_finish(&json, root);
}

void pl_quality_report_begin(pl_quality_report *report) {
    *report = (pl_quality_report){.meshes = cJSON_CreateArray()};
}

void pl_quality_report_add(pl_quality_report *report, const pl_job *job,
                           const pl_measured *measured) {
    pl_json json = {report->failed};
    const pl_cells_validity none = {.is_known = 0};
    cJSON *mesh = pl_json_object(&json, report->meshes, NULL);
    pl_json_text(&json, mesh, "planish", planish_version());
    pl_json_text(&json, mesh, "input", job->arguments->input);
    pl_json_text(&json, mesh, "format", job->file_info.format);
    add_mesh(&json, mesh, job, measured->quality.n_reversed);
    add_target(&json, mesh, job);
    add_heights(&json, mesh, job, &measured->heights);
    if (measured->cells.has_others)
        pl_result_add_cells(&json, mesh, job, measured);
    else
        pl_result_add_quality(&json, mesh, "quality", job, &measured->quality, &none,
                              measured->volumes.n_below, &measured->worst);
    pl_json_checksum(&json, mesh, "checksum", pl_job_checksum(job));
    pl_result_add_surface(&json, mesh, job, &measured->surface, NULL);
    add_volumes(&json, mesh, job, &measured->volumes, NULL);
    add_elements(&json, mesh, "reversed", job, NULL, PLANISH_VOLUME_MET, measured->reversed);
    add_elements(&json, mesh, "wrapped", job, NULL, PLANISH_VOLUME_MET, job->wrapped);
    report->failed = json.failed;
}

char *pl_quality_report_finish(pl_quality_report *report, int is_list) {
    pl_json json = {report->failed};
    cJSON *root = NULL;
    if (is_list) {
        root = cJSON_CreateObject();
        pl_json_add(&json, root, "meshes", report->meshes);
        report->meshes = NULL;
    } else {
        root = cJSON_DetachItemFromArray(report->meshes, 0);
    }
    return pl_json_finish(&json, root);
}

void pl_quality_report_free(pl_quality_report *report) {
    cJSON_Delete(report->meshes);
    report->meshes = NULL;
}
