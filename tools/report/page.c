/* page: the report as one HTML page that needs nothing else: its head, what was done in a sentence,
 * the picture; the other parts are in page_tables.c, page_charts.c and page_run.c. */
#include "report/page.h"

#include "job/layers.h"
#include "job/output.h"
#include "report/assets.h"
#include "terminal/message.h"
#include "terminal/signals.h"

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

/** Name of the input without its folder. */
static const char *input_of(const pl_figures *figures) {
    const char *input = pl_figure_text(figures->result, "input");
    const char *name = pl_path_name(input);
    return name[0] ? name : input[0] ? input : "a mesh";
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

static void put_summary(pl_markup *page, const pl_figures *figures) {
    const cJSON *mesh = cJSON_GetObjectItemCaseSensitive(figures->result, "mesh");
    const cJSON *last = pl_figures_last(figures);
    const int64_t n_inverted = pl_figure_count(last, "inverted");
    const int valid = n_inverted == 0 && pl_figure_count(last, "uncertified") == 0;
    pl_markup_put(page, "<header>\n<h1>");
    pl_markup_put_text(page, input_of(figures));
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

/* ---- the picture ---------------------------------------------------------------------------- */

/** Put what a state of the picture shows, for those who do not see it. */
static void put_label(pl_markup *page, const pl_figures *figures, const char *name) {
    const cJSON *state = cJSON_GetObjectItemCaseSensitive(figures->result, name);
    const char *ratio = figures->has_types ? "aspect" : "radius";
    state = state ? state : pl_figures_last(figures);
    pl_markup_put(page, "%s: worst %s ratio ", figures->n_states == 2 ? name : "mesh", ratio);
    pl_markup_put_real(
        page, pl_figure(state, figures->has_types ? "max_aspect_ratio" : "max_radius_ratio"));
    pl_markup_put(page, ", RMS ");
    pl_markup_put_real(
        page, pl_figure(state, figures->has_types ? "rms_aspect_ratio" : "rms_radius_ratio"));
    pl_markup_put(page, ", inverted ");
    pl_markup_put_count(page, pl_figure_count(state, "inverted"));
    pl_markup_put(page, ". ");
}

/** Put the place of the view, with still pictures until the viewer takes it. */
static void put_view(pl_markup *page, const pl_figures *figures, const pl_picture *picture) {
    const int n = pl_picture_n_states(picture);
    const cJSON *mesh = cJSON_GetObjectItemCaseSensitive(figures->result, "mesh");
    const int wraps = pl_figure(mesh, "wrapped_elements") > 0;
    pl_markup_put(page, "<figure class=\"mesh\"><div class=\"view\"%s data-label=\"%s. ",
                  wraps ? " data-wraps" : "",
                  figures->is_solid ? "The surface of the mesh and elements inside"
                                    : "The elements of the mesh");
    for (int s = 0; s < n; s++)
        put_label(page, figures, pl_picture_state_name(picture, s));
    pl_markup_put(page, "\">\n<div class=\"stills\">");
    for (int s = 0; s < n; s++)
        pl_picture_put_still(page, picture, s, wraps,
                             n == 2 ? pl_picture_state_name(picture, s) : "the mesh");
    pl_markup_put(page, "</div>\n");
    if (n == 2)
        pl_markup_put(page,
                      "<span class=\"on-view left\" hidden>%s</span>"
                      "<span class=\"on-view right\" hidden>%s</span>"
                      "<div class=\"on-view divider-line\" hidden></div>"
                      "<input type=\"range\" class=\"on-view divider\" min=\"0\" max=\"100\" "
                      "value=\"50\" aria-label=\"divider between %s (left) and %s (right)\" "
                      "hidden>\n",
                      pl_picture_state_name(picture, 0), pl_picture_state_name(picture, 1),
                      pl_picture_state_name(picture, 0), pl_picture_state_name(picture, 1));
    pl_markup_put(page, "</div>\n<p class=\"fallback quiet\">The picture is a still one: one that "
                        "turns needs JavaScript and WebGL.</p><figcaption hidden>");
    for (int s = 0; s < n; s++)
        pl_markup_put(page, "<p>%s%s<span class=\"count\"></span></p>",
                      figures->n_states == 2 ? pl_picture_state_name(picture, s) : "",
                      figures->n_states == 2 ? ": " : "");
    pl_markup_put(page, "</figcaption></figure>\n");
}

/** Put what the steps between before and after show. */
static void put_help_of_steps(pl_markup *page, const pl_picture *picture) {
    const int64_t n_bad = pl_picture_brief_bad(picture);
    int n_sweeps;
    const int n = pl_picture_n_steps(picture, &n_sweeps);
    if (n == 0)
        return;
    pl_markup_put(
        page,
        "<p>Play shows the mesh after %d of the %d sweeps, in place of the mesh after all "
        "of them. Space does so, too, when the picture is chosen.",
        n, n_sweeps);
    if (n_bad > 0)
        pl_markup_put(page, " After each sweep it draws the %d worst elements%s.", (int)n_bad,
                      pl_picture_stride(picture) > 1 ? ", and no colours on a cut" : "");
    pl_markup_put(page, "</p>");
}

/** Put the controls that play the steps. */
static void put_play(pl_markup *page, const pl_picture *picture) {
    int n_sweeps;
    const int n = pl_picture_n_steps(picture, &n_sweeps);
    if (n == 0)
        return;
    pl_markup_put(
        page,
        "<div class=\"controls\" role=\"group\" aria-label=\"the mesh from sweep to sweep\" "
        "hidden>\n<button type=\"button\" class=\"play\">play</button>\n<label>state "
        "<input type=\"range\" class=\"step\" min=\"0\" max=\"%d\" value=\"%d\"> "
        "<output class=\"step-text\"></output></label>\n</div>\n",
        n + 1, n + 1);
}

static void put_help(pl_markup *page, const pl_figures *figures, const pl_picture *picture) {
    int64_t n_all, n_drawn;
    pl_markup_put(page, "<details class=\"help\" hidden><summary>How to use the picture</summary>"
                        "<p id=\"picture-help\">");
    pl_markup_put(
        page, "%s",
        figures->is_solid
            ? "Drag to turn the mesh; drag with the right button to move it; click it and "
              "use the wheel to zoom. On a touch screen tap it first: one finger turns, "
              "two move and zoom. Keys: arrows, + and \xE2\x88\x92; 0 shows all."
            : "Drag to move the mesh; click it and use the wheel to zoom. On a touch "
              "screen tap it first, then move and zoom it with fingers. Keys: arrows, + "
              "and \xE2\x88\x92; 0 shows all.");
    pl_markup_put(page, " Drag over a histogram to see its elements here.</p>");
    put_help_of_steps(page, picture);
    pl_markup_put(page, "<p>");
    if (pl_figures_have_mids(figures))
        pl_markup_put(page, "The picture has no mid-side nodes. ");
    pl_picture_count(picture, &n_all, &n_drawn);
    if (n_drawn < n_all) {
        pl_markup_put(page, "The picture is simplified: it has ");
        pl_markup_put_count(page, n_drawn);
        pl_markup_put(page, " of %s ", figures->is_solid ? "the surface's" : "all");
        pl_markup_put_count(page, n_all);
        pl_markup_put(page, " triangles. Bad elements are drawn exactly.");
    }
    pl_markup_put(page, "</p></details>\n");
}

/** Put the controls of the cut, and what it shows. */
static void put_cut(pl_markup *page, const pl_picture *picture) {
    const int64_t stride = pl_picture_stride(picture);
    if (stride == 0)
        return;
    pl_markup_put(page,
                  "<label>cut across <select class=\"cut-axis\"><option value=\"\">nothing"
                  "</option></select></label><input type=\"range\" class=\"cut-place\" min=\"0\" "
                  "max=\"200\" value=\"100\" aria-label=\"place of the cut\" hidden>"
                  "<span class=\"cut-text\" hidden></span>\n<p class=\"cut-note quiet\" hidden>");
    if (stride == 1)
        pl_markup_put(page, "The cut shows the elements that it goes through.");
    else {
        pl_markup_put(page, "The cut shows cubes, each in the colour of the worst element in it. "
                            "Histograms show bad elements, and of all others 1 of ");
        pl_markup_put_count(page, stride);
        pl_markup_put(page, ".");
    }
    pl_markup_put(page, "</p>\n");
}

static void put_controls(pl_markup *page, const pl_picture *picture) {
    const int is_pair = pl_picture_n_states(picture) == 2;
    pl_markup_put(
        page,
        "<div class=\"controls\" hidden>\n<label>elements worse than <input "
        "type=\"range\" class=\"worse\" min=\"0\" max=\"100\" step=\"0.5\"> <output "
        "class=\"worse-text\"></output></label>\n"
        "<label>colour by <select class=\"measure\"></select></label>\n"
        "<label><input type=\"checkbox\" class=\"lines\"> mesh lines</label>\n%s%s"
        "<button type=\"button\" class=\"whole\">whole mesh</button>\n",
        is_pair ? "<label><input type=\"checkbox\" class=\"apart\"> side by side</label>\n" : "",
        pl_picture_has_features(picture)
            ? "<label><input type=\"checkbox\" class=\"features\"> patches in colours, "
              "<i class=\"curve\"></i>curves, <i class=\"corner\"></i>corners</label>\n"
            : "");
    put_cut(page, picture);
    pl_markup_put(page, "</div>\n");
}

static void put_views(pl_markup *page, const pl_figures *figures, const pl_picture *picture) {
    put_controls(page, picture);
    put_view(page, figures, picture);
    put_play(page, picture);
    pl_markup_put(page, "<p class=\"colours\" hidden></p>\n");
    put_help(page, figures, picture);
    pl_markup_put(page, "<script type=\"application/json\" id=\"picture-data\">\n");
    pl_picture_put(page, picture);
    pl_markup_put(page, "\n</script>\n");
}

static void put_picture(pl_markup *page, const pl_figures *figures, const pl_picture *picture,
                        const char *no_picture) {
    pl_markup_put(page, "<section id=\"picture\"><h2>The mesh</h2>\n");
    if (!pl_page_can_draw())
        no_picture = "This planish draws no picture: it was built without three.js.";
    else if (pl_picture_n_states(picture) > 0)
        put_views(page, figures, picture);
    else if (!no_picture)
        no_picture = "There is no picture: the coordinates are too large.";
    if (no_picture && no_picture[0]) {
        pl_markup_put(page, "<p class=\"quiet\">");
        pl_markup_put_text(page, no_picture);
        pl_markup_put(page, "</p>\n");
    }
    pl_markup_put(page, "</section>\n");
}

/** Put the script that draws it, with the licence of three.js. */
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
    pl_page_put_histograms(page, figures);
    pl_page_put_worst(page, figures);
    pl_page_put_convergence(page, figures);
    pl_page_put_layers(page, figures);
    pl_page_put_surface(page, figures);
    pl_page_put_run(page, figures);
    pl_page_put_certificate(page, figures);
    put_footer(page, figures);
    put_viewer(page, picture);
    pl_markup_put(page, "</body>\n</html>\n");
}

/* ---- files ---------------------------------------------------------------------------------- */

static const char *shown(const char *path) {
    return strcmp(path, "-") == 0 ? "standard output" : path;
}

int pl_page_write(const char *path, const pl_figures *figures, const pl_picture *picture,
                  const char *no_picture, int failed) {
    planish_error error;
    pl_markup page = {0};
    int status = 0;
    pl_page_make(&page, figures, picture, no_picture);
    if (page.failed)
        status = pl_complain(failed, "the HTML report: %s: out of memory", shown(path));
    else if (pl_output_write_text(path, PL_TEMPORARY_PAGE, page.text, page.length, &error))
        status = pl_complain(failed, "the HTML report: %s", error.text);
    pl_markup_free(&page);
    return status;
}

int pl_reports_write(const pl_arguments *arguments, const char *json, const pl_picture *picture,
                     int failed) {
    planish_error error;
    int status = 0, page = 0;
    if (!json)
        return pl_complain(failed, "%s: out of memory for the report",
                           shown(arguments->json ? arguments->json : arguments->report));
    if (arguments->json &&
        pl_output_write_text(arguments->json, PL_TEMPORARY_REPORT, json, strlen(json), &error))
        status = pl_complain(failed, "the JSON report: %s", error.text);
    if (arguments->report) {
        pl_figures figures;
        cJSON *result = cJSON_Parse(json);
        if (!result || pl_figures_find(result, &figures)) /* it is ours: only memory can be short */
            page =
                pl_complain(failed, "the HTML report: %s: out of memory", shown(arguments->report));
        else
            page = pl_page_write(arguments->report, &figures, picture, NULL, failed);
        cJSON_Delete(result);
    }
    return status ? status : page;
}

int pl_report_draw(const pl_job *job, const char *name, pl_picture **picture) {
    pl_job whole = *job;
    if (!job->arguments->report || !pl_page_can_draw())
        return 0;
    if (job->simplices.type) /* the command quality has a plan of these alone */
        pl_job_take_all(&whole);
    if (whole.file && whole.mesh.n_elements == 0)
        return 0;
    const int status = *picture ? 0 : pl_picture_begin(&whole, picture);
    return status ? status : pl_picture_take(*picture, &whole, name);
}
