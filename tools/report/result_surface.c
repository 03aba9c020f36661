/* result_surface: the surface of a mesh as JSON: its features, and how far it has moved. */
#include "report/result_surface.h"

/** Add the tolerance of the surface, in the unit that it was given in. */
static void add_surface_tolerance(pl_json *json, cJSON *to, const planish_options *options) {
    const double usual = 0.05, given = options->surface_tolerance;
    const int is_of_mesh = given > 0 && options->surface_tolerance_unit == PLANISH_UNIT_MESH;
    pl_json_real(json, to, "tolerance", given > 0 ? given : usual);
    pl_json_text(json, to, "tolerance_unit", is_of_mesh ? "mesh" : "h");
}

/** Add proved distances between the surface and the original one, both ways. */
static void add_distance(pl_json *json, cJSON *to, const planish_shape_distance *d) {
    pl_json_real(json, to, "distance", d->distance);
    pl_json_real(json, to, "distance_in_edges", d->in_edges);
    pl_json_real(json, to, "distance_back", d->distance_back);
    pl_json_real(json, to, "distance_back_in_edges", d->back_in_edges);
    pl_json_integer(json, to, "unproved_facets", d->n_unproved);
    pl_json_real(json, to, "max_bend_deg", d->max_bend);
    pl_json_real(json, to, "max_bend_before_deg", d->max_bend_before);
}

/** Add the volumes of regions by tags: those that the file gives elements. */
static void add_region_volumes(pl_json *json, cJSON *to, const pl_job *job,
                               const pl_surface_state *state) {
    cJSON *list = pl_json_array(json, to, "volumes");
    for (int64_t i = 0; i < state->n_regions && !json->failed; i++) {
        const pl_region_volume *of = &state->region[i];
        char tag[256];
        if (of->before == 0 && of->after == 0) /* no element */
            continue;
        cJSON *region = pl_json_object(json, list, NULL);
        planish_file_element_region(job->file, of->element, tag, sizeof tag);
        if (tag[0])
            pl_json_text(json, region, "region", tag);
        else
            pl_json_add(json, region, "region", cJSON_CreateNull());
        pl_json_real(json, region, "before", of->before);
        pl_json_real(json, region, "after", of->after);
    }
}

/** Add how the surface was fitted to another one. */
static void add_onto(pl_json *json, cJSON *root, const pl_job *job) {
    const planish_fit_info *before = &job->onto.before, *after = &job->onto.after;
    const planish_shape_distance *d = &job->onto.distance;
    cJSON *surface = pl_json_object(json, root, "surface");
    pl_json_text(json, surface, "onto", job->arguments->onto);
    pl_json_real(json, surface, "crease_angle", job->arguments->crease_angle);
    pl_json_integer(json, surface, "nodes", before->n_nodes);
    pl_json_integer(json, surface, "on_patches", before->n_on_patch);
    pl_json_integer(json, surface, "on_curves", before->n_on_curve);
    pl_json_integer(json, surface, "on_corners", before->n_on_corner);
    pl_json_integer(json, surface, "cut_corners", before->n_cut);
    pl_json_integer(json, surface, "out_of_reach", before->n_out_of_reach);
    pl_json_integer(json, surface, "unclear", before->n_unclear);
    pl_json_integer(json, surface, "unused_pieces", before->n_unused);
    pl_json_integer(json, surface, "held", before->n_held);
    pl_json_integer(json, surface, "off_before", before->n_off);
    pl_json_real(json, surface, "farthest_before", before->farthest);
    pl_json_integer(json, surface, "off", after->n_off);
    pl_json_real(json, surface, "farthest", after->farthest);
    pl_json_real(json, surface, "worst_ratio_of_input", job->onto.worst_before);
    pl_json_real(json, surface, "fit_seconds", job->onto.seconds);
    pl_json_real(json, surface, "distance", d->distance);
    pl_json_real(json, surface, "distance_in_edges", d->in_edges);
    pl_json_real(json, surface, "distance_back", d->distance_back);
    pl_json_real(json, surface, "distance_back_in_edges", d->back_in_edges);
    pl_json_integer(json, surface, "unproved_facets", d->n_unproved);
}

void pl_result_add_surface(pl_json *json, cJSON *root, const pl_job *job,
                           const pl_surface_state *state, const planish_result *smooth) {
    const planish_shape_info *info = &job->curved.info;
    const int64_t *n = job->curved.n;
    if (job->onto.fit) {
        add_onto(json, root, job);
        return;
    }
    if (!job->curved.shape) {
        pl_json_add(json, root, "surface", cJSON_CreateNull());
        return;
    }
    cJSON *surface = pl_json_object(json, root, "surface");
    if (job->arguments->surface_of)
        pl_json_text(json, surface, "original", job->arguments->surface_of);
    else
        pl_json_add(json, surface, "original", cJSON_CreateNull());
    pl_json_real(json, surface, "crease_angle", job->arguments->crease_angle);
    pl_json_add(json, surface, "ignores_regions", cJSON_CreateBool(job->arguments->ignore_regions));
    pl_json_integer(json, surface, "nodes", info->n_nodes);
    pl_json_integer(json, surface, "patches", info->n_patches);
    pl_json_integer(json, surface, "feature_edges", info->n_edges);
    pl_json_integer(json, surface, "creases", info->n_creases);
    pl_json_integer(json, surface, "corners", info->n_corners);
    pl_json_real(json, surface, "edge_length", info->edge_length);
    pl_json_integer(json, surface, "open_edges", info->n_open_edges);
    pl_json_integer(json, surface, "nonmanifold_edges", info->n_nonmanifold_edges);
    pl_json_integer(json, surface, "conflict_edges", info->n_conflict_edges);
    pl_json_integer(json, surface, "turned_elements", info->n_turned);
    pl_json_integer(json, surface, "flat_facets", info->n_flat);
    if (smooth) {
        pl_json_integer(json, surface, "on_planes", n[PLANISH_CONSTRAINT_ON_PLANE]);
        pl_json_integer(json, surface, "on_lines", n[PLANISH_CONSTRAINT_ON_LINE]);
        pl_json_integer(json, surface, "on_patches", n[PLANISH_CONSTRAINT_ON_PATCH]);
        pl_json_integer(json, surface, "on_curves", n[PLANISH_CONSTRAINT_ON_CURVE]);
        add_surface_tolerance(json, surface, &job->options);
        pl_json_integer(json, surface, "refused_moves", smooth->n_off_shape);
    }
    if (!state->is_known)
        return;
    add_distance(json, surface, &state->after);
    if (!smooth)
        return;
    if (job->arguments->surface_of)
        add_distance(json, pl_json_object(json, surface, "input"), &state->before);
    add_region_volumes(json, surface, job, state);
}
