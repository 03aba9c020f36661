/* page: the report as one HTML page that needs nothing else: its head, what was done in a sentence,
 * the picture; the other parts are in page_tables.c, page_charts.c and page_run.c. */
#include "report/page.h"

#include "job/layers.h"
#include "report/assets.h"

#include "base/system.h"

#include <math.h>
#include <string.h>

static void put_asset(pl_markup *page, const pl_asset *asset) {
    pl_markup_put_bytes(page, (const char *)asset->bytes, asset->size);
}

int pl_page_can_draw(void) {
    return pl_asset_three_js.size > 0 && pl_asset_controls_js.size > 0;
}

/* ---- head ----------------------------------------------------------------------------------- */

/** The last part of a path. */
static const char *name_of(const char *path) {
    const char *name = pl_path_name(path);
    return name[0] ? name : path;
}

static const char *input_of(const pl_figures *figures) {
    const char *input = pl_figure_text(figures->result, "input");
    return input[0] ? name_of(input) : "a mesh";
}

/** Nothing from elsewhere is ever loaded: the policy forbids it. */
static void put_head(pl_markup *page, const pl_figures *figures) {
    pl_markup_put(page,
                  "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
                  "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
                  "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
                  "style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n"
                  "<meta name=\"generator\" content=\"planish\">\n<title>planish: ");
    pl_markup_put_text(page, input_of(figures));
    pl_markup_put(page, "</title>\n<style>\n");
    put_asset(page, &pl_asset_page_css);
    pl_markup_put(page, "</style>\n</head>\n<body>\n<main>\n");
}

/* ---- what was done -------------------------------------------------------------------------- */

static void put_mesh(pl_markup *page, const pl_figures *figures, const cJSON *mesh) {
    pl_markup_put_number_of(page, pl_figure_count(mesh, "elements"),
                            figures->is_solid ? "tetrahedron" : "triangle",
                            figures->is_solid ? "tetrahedra" : "triangles");
}

static void put_movement(pl_markup *page, const pl_figures *figures, const cJSON *mesh) {
    const cJSON *result = figures->result;
    const int64_t threads = pl_figure_count(result, "threads");
    const int sweeps = cJSON_GetArraySize(cJSON_GetObjectItemCaseSensitive(result, "sweeps"));
    pl_markup_put(page, "planish moved ");
    pl_markup_put_count(page, pl_figure_count(result, "moved_nodes"));
    pl_markup_put(page, " of ");
    pl_markup_put_count(page, pl_figure_count(mesh, "nodes"));
    pl_markup_put(page, " nodes by up to ");
    pl_markup_put_real(page, pl_figure(result, "max_displacement"));
    pl_markup_put(page, ", in %d sweep%s and ", sweeps, sweeps == 1 ? "" : "s");
    pl_markup_put_real(page,
                       pl_figure(cJSON_GetObjectItemCaseSensitive(result, "seconds"), "total"));
    pl_markup_put(page, " s on ");
    pl_markup_put_number_of(page, threads, "thread. ", "threads. ");
}

static void put_gain(pl_markup *page, const pl_figures *figures) {
    const double before = pl_figure(figures->state[0], "rms_radius_ratio");
    const double after = pl_figure(figures->state[1], "rms_radius_ratio");
    const int64_t inverted = pl_figure_count(figures->state[0], "inverted");
    const int64_t left = pl_figure_count(figures->state[1], "inverted");
    if (before == after)
        pl_markup_put(page, "The RMS of the radius ratios stayed at %.5g.", after);
    else if (isfinite(before) && isfinite(after))
        pl_markup_put(page, "The RMS of the radius ratios %s from %.5g to %.5g.",
                      after < before ? "fell" : "rose", before, after);
    if (inverted > 0) {
        pl_markup_put(page, inverted == 1 ? " There was " : " There were ");
        pl_markup_put_number_of(page, inverted, "inverted element", "inverted elements");
        pl_markup_put(page, " before, and now there %s ", left == 1 ? "is" : "are");
        if (left > 0)
            pl_markup_put_count(page, left);
        pl_markup_put(page, left > 0 ? "." : "none.");
    }
}

/** Layers that smoothing makes regular: their elements, if they are many. */
static void put_layers(pl_markup *page, const cJSON *mesh) {
    const int64_t n = pl_figure_count(mesh, "free_layer_elements");
    if (!pl_layers_are_many(n, pl_figure_count(mesh, "elements")))
        return;
    pl_markup_put(page, "<p class=\"quiet\">");
    pl_markup_put_count(page, n);
    pl_markup_put(page, " elements were thin in layers, as in a boundary layer, and free to move: "
                        "smoothing makes them regular, unless <code>--fix-layers</code> holds "
                        "them.</p>\n");
}

/** Which arrays tell regions. */
static void put_regions(pl_markup *page, const cJSON *mesh) {
    const cJSON *names = cJSON_GetObjectItemCaseSensitive(mesh, "region_arrays"), *name;
    const int n = cJSON_GetArraySize(names);
    if (n == 0)
        return;
    int i = 0;
    pl_markup_put(page, "<p class=\"quiet\">Regions are told by the array%s ", n == 1 ? "" : "s");
    cJSON_ArrayForEach(name, names) {
        pl_markup_put(page, i++ ? ", <code>" : "<code>");
        pl_markup_put_text(page, cJSON_IsString(name) ? name->valuestring : "");
        pl_markup_put(page, "</code>");
    }
    pl_markup_put(page, ": nodes between different values stay on the interfaces.</p>\n");
}

/** What an end that is not the plain one needs to be said of. */
static void put_remarks(pl_markup *page, const pl_figures *figures) {
    const char *reason = pl_figure_text(figures->result, "reason");
    const int64_t back = pl_figure_count(figures->result, "put_back");
    const int64_t outside = pl_figure_count(figures->result, "held_outside");
    if (reason[0]) {
        pl_markup_put(page, "<p class=\"verdict bad\">");
        pl_markup_put_text(page, reason);
        pl_markup_put(page, "</p>\n");
    }
    if (back > 0) {
        pl_markup_put(page, "<p class=\"quiet\">");
        pl_markup_put_number_of(page, back, "time", "times");
        pl_markup_put(page, " a node was put back, because the smallest angle of the mesh was "
                            "getting smaller.</p>\n");
    }
    if (outside > 0) {
        pl_markup_put(page, "<p class=\"quiet\">");
        pl_markup_put_number_of(page, outside, "node was", "nodes were");
        pl_markup_put(page, " outside of the bounds and stayed there.</p>\n");
    }
}

static void put_summary(pl_markup *page, const pl_figures *figures) {
    const cJSON *mesh = cJSON_GetObjectItemCaseSensitive(figures->result, "mesh");
    const int valid = pl_figure_count(pl_figures_last(figures), "inverted") == 0;
    pl_markup_put(page, "<header>\n<h1>");
    pl_markup_put_text(page, input_of(figures));
    pl_markup_put(page, "</h1>\n<p class=\"lead\">");
    if (figures->n_states == 2) {
        put_movement(page, figures, mesh);
        put_gain(page, figures);
    } else {
        pl_markup_put(page, "The quality of a mesh of ");
        put_mesh(page, figures, mesh);
        pl_markup_put(page, " and ");
        pl_markup_put_number_of(page, pl_figure_count(mesh, "nodes"), "node.", "nodes.");
    }
    pl_markup_put(page, "</p>\n<p class=\"verdict%s\">%s: ", valid ? "" : " bad",
                  valid ? "Valid" : "Not valid");
    put_mesh(page, figures, mesh);
    pl_markup_put(page, valid ? ", each of them positive, decided exactly." : ", some inverted.");
    pl_markup_put(page, "</p>\n");
    put_layers(page, mesh);
    put_regions(page, mesh);
    put_remarks(page, figures);
    pl_markup_put(page, "</header>\n");
}

/* ---- the picture ---------------------------------------------------------------------------- */

/** What a view shows, for those who do not see it; state: its figures, or NULL. */
static void put_label(pl_markup *page, const pl_figures *figures, const char *name,
                      const cJSON *state) {
    pl_markup_put(page, "%s the mesh%s%s: worst radius ratio ",
                  figures->is_solid ? "The surface and the bad elements of" : "The triangles of",
                  figures->n_states == 2 ? " " : "", figures->n_states == 2 ? name : "");
    pl_markup_put_real(page, pl_figure(state, "max_radius_ratio"));
    pl_markup_put(page, ", RMS ");
    pl_markup_put_real(page, pl_figure(state, "rms_radius_ratio"));
    pl_markup_put(page, ", inverted ");
    pl_markup_put_count(page, pl_figure_count(state, "inverted"));
}

static void put_view(pl_markup *page, const pl_figures *figures, const char *name) {
    const cJSON *state = cJSON_GetObjectItemCaseSensitive(figures->result, name);
    pl_markup_put(page, "<figure><div class=\"view\" data-label=\"");
    put_label(page, figures, name, state ? state : pl_figures_last(figures));
    pl_markup_put(page,
                  "\"><p class=\"fallback\">The picture needs JavaScript and WebGL.</p></div>"
                  "<figcaption>%s%s<span class=\"count\"></span></figcaption></figure>\n",
                  figures->n_states == 2 ? name : "", figures->n_states == 2 ? ": " : "");
}

static void put_coarseness(pl_markup *page, const pl_figures *figures, const pl_picture *picture) {
    int64_t n_all, n_drawn;
    pl_picture_count(picture, &n_all, &n_drawn);
    if (n_drawn >= n_all)
        return;
    pl_markup_put(page, " It is drawn coarsely, with ");
    pl_markup_put_count(page, n_drawn);
    pl_markup_put(page, " of %s ", figures->is_solid ? "the surface's" : "all");
    pl_markup_put_count(page, n_all);
    pl_markup_put(page, " triangles; bad elements are drawn as they are.");
}

static void put_views(pl_markup *page, const pl_figures *figures, const pl_picture *picture) {
    pl_markup_put(
        page, "<p class=\"quiet help\" id=\"picture-help\" hidden>%s",
        figures->is_solid
            ? "The surface of the mesh, and in it the elements that are worse than a "
              "radius ratio of your choice. Drag to turn it, drag with the right button "
              "to move it; after a click the wheel zooms. Or tap it first, and turn it with "
              "one finger, move and zoom it with two; or by the arrow keys, + and "
              "\xE2\x88\x92, and 0 for all of it."
            : "Each triangle in the colour of its radius ratio. Drag to move it; after a "
              "click the wheel zooms. Or tap it first, and move and zoom it with fingers; or "
              "by the arrow keys, + and \xE2\x88\x92, and 0 for all of it.");
    put_coarseness(page, figures, picture);
    pl_markup_put(page,
                  "</p>\n<div class=\"controls\" hidden>\n<label>elements worse than <input "
                  "type=\"range\" min=\"0\" max=\"100\" step=\"0.5\"> <output></output></label>\n"
                  "<label><input type=\"checkbox\"> mesh lines</label>\n"
                  "<button type=\"button\">whole mesh</button>\n</div>\n<div class=\"views\">\n");
    for (int s = 0; s < pl_picture_n_states(picture); s++)
        put_view(page, figures, pl_picture_state_name(picture, s));
    pl_markup_put(page, "</div>\n<p class=\"colours\" hidden>radius ratio: </p>\n"
                        "<script type=\"application/json\" id=\"picture-data\">\n");
    pl_picture_put(page, picture);
    pl_markup_put(page, "\n</script>\n");
}

static void put_picture(pl_markup *page, const pl_figures *figures, const pl_picture *picture,
                        const char *no_picture) {
    pl_markup_put(page, "<section id=\"picture\"><h2>The mesh</h2>\n");
    if (!pl_page_can_draw())
        no_picture = "There is no picture: this planish was built without three.js.";
    else if (pl_picture_n_states(picture) > 0)
        put_views(page, figures, picture);
    else if (!no_picture)
        no_picture = "There is no picture: the mesh is too large for its numbers.";
    if (no_picture && no_picture[0]) {
        pl_markup_put(page, "<p class=\"quiet\">");
        pl_markup_put_text(page, no_picture);
        pl_markup_put(page, "</p>\n");
    }
    pl_markup_put(page, "</section>\n");
}

/** What draws it; the licence of three.js asks to come along. */
static void put_viewer(pl_markup *page, const pl_picture *picture) {
    if (!pl_page_can_draw() || pl_picture_n_states(picture) == 0)
        return;
    pl_markup_put(page, "<!--\n");
    put_asset(page, &pl_asset_three_licence);
    pl_markup_put(page, "-->\n<script>\n");
    put_asset(page, &pl_asset_three_js);
    pl_markup_put(page, "\n</script>\n<script>\n");
    put_asset(page, &pl_asset_controls_js);
    pl_markup_put(page, "\n</script>\n<script>\n");
    put_asset(page, &pl_asset_viewer_js);
    pl_markup_put(page, "</script>\n");
}

/* ---- all of it ------------------------------------------------------------------------------ */

static void put_footer(pl_markup *page, const pl_figures *figures) {
    const char *version = pl_figure_text(figures->result, "planish");
    const char *output = pl_figure_text(figures->result, "output");
    pl_markup_put(page, "</main>\n<footer><p>Made by planish ");
    pl_markup_put_text(page, version[0] ? version : planish_version());
    pl_markup_put(page, " from <code>");
    pl_markup_put_text(page, pl_figure_text(figures->result, "input"));
    pl_markup_put(page, "</code>");
    if (output[0]) {
        pl_markup_put(page, "; the result is <code>");
        pl_markup_put_text(page, output);
        pl_markup_put(page, "</code>");
    }
    pl_markup_put(page,
                  ". The measures are defined in docs/measures.md of planish.</p></footer>\n");
}

void pl_page_make(pl_markup *page, const pl_figures *figures, const pl_picture *picture,
                  const char *no_picture) {
    put_head(page, figures);
    put_summary(page, figures);
    pl_page_put_measures(page, figures);
    put_picture(page, figures, picture, no_picture);
    pl_page_put_worst(page, figures);
    pl_page_put_histograms(page, figures);
    pl_page_put_convergence(page, figures);
    pl_page_put_run(page, figures);
    pl_page_put_certificate(page, figures);
    put_footer(page, figures);
    put_viewer(page, picture);
    pl_markup_put(page, "</body>\n</html>\n");
}
