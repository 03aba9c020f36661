/* page_summary: what a page says first: what was done, whether the mesh is valid, and remarks. */
#include "report/page_parts.h"

#include "job/layers.h"

#include <math.h>
#include <string.h>

static void put_mesh(pl_markup *page, const pl_figures *figures) {
    const int is_solid = figures->is_solid, has_types = figures->has_types;
    pl_markup_put_number_of(page, pl_figures_elements(figures),
                            has_types  ? "element"
                            : is_solid ? "tetrahedron"
                                       : "triangle",
                            has_types  ? "elements"
                            : is_solid ? "tetrahedra"
                                       : "triangles");
    if (pl_figures_have_mids(figures))
        pl_markup_put(page, " with mid-side nodes");
}

/** Put how many nodes are elsewhere after than before, and by how much. */
static void put_moved(pl_markup *page, const pl_figures *figures, const cJSON *mesh) {
    pl_markup_put(page, figures->is_compared ? "" : "planish moved ");
    pl_markup_put_count(page, pl_figure_count(figures->result, "moved_nodes"));
    pl_markup_put(page, " of ");
    pl_markup_put_count(page, pl_figure_count(mesh, "nodes"));
    pl_markup_put(page, figures->is_compared ? " nodes differ, by up to " : " nodes by up to ");
    pl_markup_put_real(page, pl_figure(figures->result, "max_displacement"));
    pl_markup_put(page, " (units of the file)");
}

/** Put what smoothing took. */
static void put_work(pl_markup *page, const cJSON *result) {
    const cJSON *seconds = cJSON_GetObjectItemCaseSensitive(result, "seconds");
    const int sweeps = cJSON_GetArraySize(cJSON_GetObjectItemCaseSensitive(result, "sweeps"));
    pl_markup_put(page, ", in %d sweep%s and ", sweeps, sweeps == 1 ? "" : "s");
    pl_markup_put_real(page, pl_figure(seconds, "total"));
    pl_markup_put(page, " s on ");
    pl_markup_put_number_of(page, pl_figure_count(result, "threads"), "thread", "threads");
}

/** Put who moved, how far, and what that brought. */
static void put_change(pl_markup *page, const pl_figures *figures, const cJSON *mesh) {
    const char *key = figures->has_types ? "rms_aspect_ratio" : "rms_radius_ratio";
    const char *ratios = figures->has_types ? "aspect" : "radius";
    const double before = pl_figure(figures->state[0], key);
    const double after = pl_figure(figures->state[1], key);
    const int64_t inverted = pl_figure_count(figures->state[0], "inverted");
    const int64_t left = pl_figure_count(figures->state[1], "inverted");
    put_moved(page, figures, mesh);
    if (!figures->is_compared)
        put_work(page, figures->result);
    pl_markup_put(page, ". ");
    if (before == after)
        pl_markup_put(page, "The RMS of the %s ratios stayed at ", ratios);
    else if (isfinite(before) && isfinite(after)) {
        pl_markup_put(page, "The RMS of the %s ratios %s from ", ratios,
                      after < before ? "fell" : "rose");
        pl_markup_put_real(page, before);
        pl_markup_put(page, " to ");
    }
    if (isfinite(before) && isfinite(after)) {
        pl_markup_put_real(page, after);
        pl_markup_put(page, ".");
    }
    if (inverted > 0) {
        pl_markup_put(page, inverted == 1 ? " There was " : " There were ");
        pl_markup_put_number_of(page, inverted, "inverted element", "inverted elements");
        pl_markup_put(page, " before; now there %s ", left == 1 ? "is" : "are");
        if (left > 0)
            pl_markup_put_count(page, left);
        pl_markup_put(page, left > 0 ? "." : "none.");
    }
}

/** Put what the elements are to be like, if it is not the regular element. */
static void put_target(pl_markup *page, const pl_figures *figures, const cJSON *mesh) {
    if (figures->like[0]) {
        pl_markup_put(page, "<p id=\"target\">The target of each element is its shape in <code>");
        pl_markup_put_text(page, figures->like);
        pl_markup_put(page, "</code>: an aspect ratio of 1 means the same shape.</p>\n");
    } else if (figures->of_sizes || figures->of_metric) {
        pl_markup_put(page, "<p id=\"target\">The elements should have the %s in <code>",
                      figures->of_metric ? "metric" : "sizes");
        pl_markup_put_text(page, pl_figure_text(figures->result, "sizes_of"));
        pl_markup_put(page, "</code>, relative to one another. Aspect ratios %s.</p>\n",
                      figures->of_metric ? "measure lengths by the metric"
                                         : "compare elements with regular ones");
    } else if (figures->has_targets) {
        pl_markup_put(
            page,
            "<p id=\"target\">The layers should keep their heights. Aspect ratios compare their ");
        pl_markup_put_count(page, pl_figure_count(mesh, "kept_layer_elements"));
        pl_markup_put(
            page,
            " elements with their former heights, and other elements with regular ones.</p>\n");
    }
}

/** Put what became of boundary layers. */
static void put_layers(pl_markup *page, const cJSON *mesh) {
    const int64_t thin = pl_figure_count(mesh, "free_layer_elements");
    if (pl_figure_text(mesh, "layers_not_kept_with")[0]) {
        pl_markup_put(page, "<p class=\"quiet\">");
        pl_markup_put_count(page, pl_figure_count(mesh, "held_layer_elements"));
        pl_markup_put(page, " elements are thin in layers. planish held their nodes, because it "
                            "cannot keep heights with ");
        pl_markup_put_text(page, pl_figure_text(mesh, "layers_not_kept_with"));
        pl_markup_put(page, ".</p>\n");
    }
    if (pl_layers_are_many(thin, pl_figure_count(mesh, "elements"))) {
        pl_markup_put(page, "<p class=\"quiet\">");
        pl_markup_put_count(page, thin);
        pl_markup_put(page, " movable elements were thin in layers, as in a boundary layer. "
                            "Smoothing makes them regular; <code>--fix-layers</code> holds "
                            "them.</p>\n");
    }
}

/** Put the arrays that tell regions. */
static void put_region_arrays(pl_markup *page, const cJSON *mesh) {
    const cJSON *names = cJSON_GetObjectItemCaseSensitive(mesh, "region_arrays"), *name;
    const char *between = cJSON_GetArraySize(names) == 1 ? " " : "s ";
    if (cJSON_GetArraySize(names) == 0)
        return;
    pl_markup_put(page, "<p class=\"quiet\">Nodes stay on the interfaces between the values of "
                        "array");
    cJSON_ArrayForEach(name, names) {
        pl_markup_put(page, "%s<code>", between);
        pl_markup_put_text(page, cJSON_IsString(name) ? name->valuestring : "");
        pl_markup_put(page, "</code>");
        between = ", ";
    }
    pl_markup_put(page, ".</p>\n");
}

/** Put why not all was reached, and what a reader should know of nodes and elements. */
static void put_remarks(pl_markup *page, const pl_figures *figures, const cJSON *mesh) {
    const char *reason = pl_figure_text(figures->result, "reason");
    const int64_t back = pl_figure_count(figures->result, "put_back");
    const int64_t outside = pl_figure_count(figures->result, "held_outside");
    put_target(page, figures, mesh);
    put_layers(page, mesh);
    put_region_arrays(page, mesh);
    if (reason[0]) {
        pl_markup_put(page, "<p class=\"verdict bad\">");
        pl_markup_put_text(page, reason);
        pl_markup_put(page, "%s</p>\n", reason[strlen(reason) - 1] == '.' ? "" : ".");
    }
    if (back > 0) {
        pl_markup_put(page, "<p class=\"quiet\">planish put a node back ");
        pl_markup_put_number_of(page, back, "time", "times");
        pl_markup_put(page, ", because the %s.</p>\n",
                      figures->has_targets ? "worst aspect ratio became larger"
                                           : "smallest angle of the mesh became smaller");
    }
    if (outside > 0) {
        pl_markup_put(page, "<p class=\"quiet\">");
        pl_markup_put_number_of(page, outside, "node was", "nodes were");
        pl_markup_put(page, " outside the bounds and stayed there.</p>\n");
    }
}

void pl_page_put_summary(pl_markup *page, const pl_figures *figures) {
    const cJSON *mesh = cJSON_GetObjectItemCaseSensitive(figures->result, "mesh");
    const cJSON *last = pl_figures_last(figures);
    const int64_t n_inverted = pl_figure_count(last, "inverted");
    const int valid = n_inverted == 0 && pl_figure_count(last, "uncertified") == 0;
    pl_markup_put(page, "<header>\n<h1>");
    pl_markup_put_text(page, pl_figures_input(figures));
    pl_markup_put(page, "</h1>\n<p class=\"lead\">");
    if (figures->n_states == 2) {
        put_change(page, figures, mesh);
    } else {
        pl_markup_put(page, "Quality of a mesh of ");
        put_mesh(page, figures);
        pl_markup_put(page, " and ");
        pl_markup_put_number_of(page, pl_figure_count(mesh, "nodes"), "node.", "nodes.");
    }
    pl_markup_put(page, "</p>\n<p class=\"verdict%s\">%s: ", valid ? "" : " bad",
                  valid ? "Valid" : "Not valid");
    put_mesh(page, figures);
    pl_markup_put(page, valid            ? ", all positive (decided exactly)."
                        : n_inverted > 0 ? ", some inverted."
                                         : ", some undecided.");
    pl_markup_put(page, "</p>\n");
    put_remarks(page, figures, mesh);
    pl_markup_put(page, "</header>\n");
}
