/* page_picture: the picture of a page, its controls, and the script that draws it. */
#include "report/page_parts.h"

#include "report/assets.h"
#include "report/picture_take.h"

int pl_page_can_draw(void) {
    return pl_asset_three_js.size > 0 && pl_asset_controls_js.size > 0;
}

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

void pl_page_put_picture(pl_markup *page, const pl_figures *figures, const pl_picture *picture,
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

static void put_asset(pl_markup *page, const pl_asset *asset) {
    pl_markup_put_bytes(page, (const char *)asset->bytes, asset->size);
}

void pl_page_put_viewer(pl_markup *page, const pl_picture *picture) {
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
