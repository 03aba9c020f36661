/* result_quality: measures of a mesh as JSON. */
#include "report/result_quality.h"

#include "job/held.h"

#include <math.h>

static void add_spread(pl_json *json, cJSON *quality, const char *name, const planish_spread *s) {
    cJSON *spread = pl_json_object(json, quality, name);
    pl_json_real(json, spread, "min", s->min);
    pl_json_real(json, spread, "mean", s->mean);
    pl_json_real(json, spread, "max", s->max);
}

/** edge [n + 1], count [n]. */
static void add_histogram(pl_json *json, cJSON *quality, const char *name, int n,
                          const double *edge, const int64_t *count) {
    cJSON *histogram = pl_json_object(json, quality, name);
    cJSON *edges = pl_json_array(json, histogram, "edges");
    cJSON *counts = pl_json_array(json, histogram, "counts");
    for (int i = 0; i <= n; i++)
        pl_json_real(json, edges, NULL, edge[i]);
    for (int i = 0; i < n; i++)
        pl_json_integer(json, counts, NULL, count[i]);
}

/** Null: not looked for, as this process has not all of the mesh. */
static void add_worst_elements(pl_json *json, cJSON *quality, const pl_job *job,
                               const pl_worst *worst) {
    if (!job->mesh.coordinates) {
        pl_json_add(json, quality, "worst_elements", cJSON_CreateNull());
        return;
    }
    cJSON *list = pl_json_array(json, quality, "worst_elements");
    for (int64_t i = 0; i < worst->n && !json->failed; i++) {
        const pl_bad_element *bad = &worst->bad[i];
        const double ratio = bad->ratio > 0 ? bad->ratio : NAN;
        cJSON *element = pl_json_object(json, list, NULL);
        pl_json_integer(json, element, "element", bad->number);
        if (worst->is_aspect_ratio) {
            pl_json_text(json, element, "type", pl_cell_type_name(bad->type));
            pl_json_real(json, element, "aspect_ratio", ratio);
        }
        pl_json_real(json, element, "radius_ratio", worst->is_aspect_ratio ? NAN : ratio);
        pl_json_real(json, element, "min_angle_deg", bad->smallest_angle_deg);
        pl_json_real(json, element, "max_angle_deg", bad->largest_angle_deg);
        cJSON *place = pl_json_array(json, element, "place");
        for (int d = 0; d < worst->columns; d++)
            pl_json_real(json, place, NULL, bad->place[d]);
        cJSON *nodes = pl_json_array(json, element, "nodes");
        for (int k = 0; k < bad->n_nodes; k++)
            pl_json_integer(json, nodes, NULL, bad->node[k]);
        if (bad->region)
            pl_json_text(json, element, "region", bad->region);
        else
            pl_json_add(json, element, "region", cJSON_CreateNull());
        pl_json_add(json, element, "movable",
                    bad->is_movable < 0 ? cJSON_CreateNull() : cJSON_CreateBool(bad->is_movable));
        if (bad->held_by)
            pl_json_text(json, element, "held", pl_held_name_in_run(bad->held_by));
        else
            pl_json_add(json, element, "held", cJSON_CreateNull());
    }
}

/** Add the measures of simplices to quality. */
static void add_measures(pl_json *json, cJSON *quality, const planish_quality *q,
                         int64_t n_inverted, int64_t below_min_volume) {
    pl_json_integer(json, quality, "inverted", n_inverted);
    pl_json_integer(json, quality, "reversed_elements", q->n_reversed);
    pl_json_integer(json, quality, "below_min_volume", below_min_volume);
    pl_json_real(json, quality, "min_volume", q->min_volume);
    pl_json_real(json, quality, "max_volume", q->max_volume);
    pl_json_real(json, quality, "total_volume", q->total_volume);
    pl_json_real(json, quality, "rms_radius_ratio", q->rms_radius_ratio);
    pl_json_real(json, quality, "rms_radius_ratio_movable", q->rms_radius_ratio_movable);
    pl_json_real(json, quality, "mean_radius_ratio", q->mean_radius_ratio);
    pl_json_real(json, quality, "max_radius_ratio", q->max_radius_ratio);
    pl_json_real(json, quality, "min_dihedral_deg", q->min_angle_deg);
    pl_json_real(json, quality, "max_dihedral_deg", q->max_angle_deg);
    pl_json_real(json, quality, "max_radius_ratio_movable", q->max_radius_ratio_movable);
    pl_json_real(json, quality, "min_dihedral_movable_deg", q->min_angle_deg_movable);
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
static void add_cell_measures(pl_json *json, cJSON *to, const planish_cell_measures *of) {
    pl_json_integer(json, to, "corner_inverted", of->n_inverted_corners);
    pl_json_integer(json, to, "uncertified", of->n_uncertified);
    pl_json_integer(json, to, "curved", of->n_curved);
    pl_json_real(json, to, "rms_aspect_ratio", of->rms_aspect_ratio);
    pl_json_real(json, to, "mean_aspect_ratio", of->mean_aspect_ratio);
    pl_json_real(json, to, "max_aspect_ratio", of->max_aspect_ratio);
    pl_json_real(json, to, "min_scaled_jacobian", of->min_scaled_jacobian);
    pl_json_real(json, to, "min_jacobian_ratio", of->min_jacobian_ratio);
    pl_json_real(json, to, "max_edge_ratio", of->max_edge_ratio);
}

/** Add the number of elements of each type, and their measures. */
static void add_types(pl_json *json, cJSON *quality, const planish_cell_quality *q) {
    cJSON *counts = pl_json_object(json, quality, "counts");
    for (int i = 0; i < q->n_types; i++)
        pl_json_integer(json, counts, pl_cell_type_name(q->type[i]), q->by_type[i].n_elements);
    add_cell_measures(json, quality, &q->all);
    cJSON *by_type = pl_json_object(json, quality, "by_type");
    for (int i = 0; i < q->n_types; i++) {
        cJSON *of = pl_json_object(json, by_type, pl_cell_type_name(q->type[i]));
        pl_json_integer(json, of, "inverted", q->by_type[i].n_inverted);
        add_cell_measures(json, of, &q->by_type[i]);
    }
}

/** Add the sizes of elements against those that are wanted, if sizes are asked for. */
static void add_sizes(pl_json *json, cJSON *quality, const pl_job *job,
                      const planish_size_quality *sizes) {
    if (!pl_like_has_sizes(&job->like))
        return;
    cJSON *to = pl_json_object(json, quality, "sizes");
    pl_json_real(json, to, "factor", sizes->factor);
    pl_json_real(json, to, "rms_log", sizes->rms_log);
    pl_json_real(json, to, "min", sizes->min);
    pl_json_real(json, to, "max", sizes->max);
    pl_json_known(json, to, "smallest_element",
                  sizes->smallest < 0 ? -1 : pl_job_element_number(job, sizes->smallest));
    pl_json_known(json, to, "largest_element",
                  sizes->largest < 0 ? -1 : pl_job_element_number(job, sizes->largest));
}

void pl_result_add_quality(pl_json *json, cJSON *root, const char *name, const pl_job *job,
                           const planish_quality *q, const pl_cells_validity *validity,
                           int64_t below_min_volume, const pl_worst *worst) {
    cJSON *quality = pl_json_object(json, root, name);
    add_measures(json, quality, q,
                 validity->is_known ? validity->quality.all.n_inverted : q->n_inverted,
                 below_min_volume);
    if (validity->is_known) {
        add_types(json, quality, &validity->quality);
        pl_json_integer(json, quality, "inverted_inside", validity->n_inside);
    }
    add_worst_elements(json, quality, job, worst);
}

void pl_result_add_smoothed_cells(pl_json *json, cJSON *root, const char *name, const pl_job *job,
                                  const planish_quality *q, const pl_cells_validity *validity,
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
    cJSON *quality = pl_json_object(json, root, name);
    pl_json_integer(json, quality, "inverted", pl_cells_validity_faults(validity, q));
    add_types(json, quality, &validity->quality);
    add_sizes(json, quality, job, &validity->sizes);
    pl_json_integer(json, quality, "inverted_inside", validity->n_inside);
    pl_json_real(json, quality, "rms_aspect_ratio_movable", q->rms_radius_ratio_movable);
    pl_json_real(json, quality, "max_aspect_ratio_movable", q->max_radius_ratio_movable);
    add_histogram(json, quality, "aspect_histogram", PLANISH_HISTOGRAM_BINS, q->histogram_edges,
                  q->histogram_counts);
    pl_json_integer(json, quality, "reversed_elements", q->n_reversed);
    pl_json_integer(json, quality, "below_min_volume", below_min_volume);
    pl_json_real(json, quality, "min_volume", q->min_volume);
    pl_json_real(json, quality, "max_volume", q->max_volume);
    pl_json_real(json, quality, "total_volume", q->total_volume);
    for (size_t i = 0; i < sizeof of_simplices / sizeof *of_simplices; i++)
        pl_json_add(json, quality, of_simplices[i], cJSON_CreateNull());
    add_worst_elements(json, quality, job, worst);
}

void pl_result_add_cells(pl_json *json, cJSON *root, const pl_job *job,
                         const pl_measured *measured) {
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
    cJSON *quality = pl_json_object(json, root, "quality");
    pl_json_integer(json, quality, "inverted", q->all.n_inverted);
    add_types(json, quality, q);
    add_sizes(json, quality, job, &measured->cells.sizes);
    for (size_t i = 0; i < sizeof of_simplices / sizeof *of_simplices; i++)
        pl_json_add(json, quality, of_simplices[i], cJSON_CreateNull());
    if (job->mesh.n_elements > 0)
        add_measures(json, pl_json_object(json, quality, "simplices"), &measured->quality,
                     measured->quality.n_inverted, measured->volumes.n_below);
    else
        pl_json_add(json, quality, "simplices", cJSON_CreateNull());
    add_worst_elements(json, quality, job, &measured->worst);
}
