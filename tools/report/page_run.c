/* page_run: what a page says of the run: its time and machine, heights of layers, and what is certified. */
#include "report/page_parts.h"

#include <math.h>
#include <string.h>

/* ---- time and machine ----------------------------------------------------------------------- */

/** Put the row of a step. */
static void put_time(pl_markup *page, const char *name, double seconds, double total) {
    pl_markup_put(page, "<tr><th scope=\"row\"><i></i>%s</th><td>", name);
    pl_markup_put_real(page, seconds);
    pl_markup_put(page, " s</td><td>%.0f&#8239;%%</td></tr>\n", 100 * seconds / total);
}

/** Put a bar and a table of the steps that took time; the last one is what remains of the total. */
static void put_times(pl_markup *page, const cJSON *seconds) {
    static const char *const keys[] = {"read", "shape", "setup", "smooth", "write", NULL};
    static const char *const names[] = {"read",  "find what slides", "set up", "smooth",
                                        "write", "measure and check"};
    enum { N = sizeof names / sizeof *names };
    const double total = pl_figure(seconds, "total");
    double time[N], rest = total;
    if (!(total > 0))
        return;
    for (int i = 0; i < N; i++) {
        time[i] = keys[i] ? pl_figure(seconds, keys[i]) : rest;
        rest -= time[i] > 0 ? time[i] : 0;
    }
    pl_markup_put(page, "<div class=\"times\" aria-hidden=\"true\">");
    for (int i = 0; i < N; i++)
        if (time[i] > 0)
            pl_markup_put(page, "<span style=\"flex:%.6g\" title=\"%s\"></span>",
                          100 * time[i] / total, names[i]);
    pl_markup_put(page, "</div>\n<div class=\"scroll\"><table><thead><tr><th scope=\"col\">phase"
                        "</th><th scope=\"col\">time</th><th scope=\"col\">share</th></tr>"
                        "</thead><tbody>\n");
    for (int i = 0; i < N; i++)
        if (time[i] > 0)
            put_time(page, names[i], time[i], total);
    pl_markup_put(page, "<tr class=\"main\"><th scope=\"row\">total</th><td>");
    pl_markup_put_real(page, total);
    pl_markup_put(page, " s</td><td></td></tr>\n</tbody></table></div>\n");
}

/** Put a row, if there is a value. */
static void put_fact(pl_markup *page, const char *name, const char *value) {
    if (!value[0])
        return;
    pl_markup_put(page, "<tr><th scope=\"row\">%s</th><td class=\"wrap\">", name);
    pl_markup_put_text(page, value);
    pl_markup_put(page, "</td></tr>\n");
}

static void put_counted(pl_markup *page, const char *name, const cJSON *object, const char *key) {
    if (!isfinite(pl_figure(object, key)))
        return;
    pl_markup_put(page, "<tr><th scope=\"row\">%s</th><td class=\"wrap\">", name);
    pl_markup_put_count(page, pl_figure_count(object, key));
    pl_markup_put(page, "</td></tr>\n");
}

void pl_page_put_run(pl_markup *page, const pl_figures *figures) {
    const cJSON *result = figures->result;
    const cJSON *mesh = cJSON_GetObjectItemCaseSensitive(result, "mesh");
    const double memory = pl_figure(result, "peak_memory_bytes");
    if (figures->n_states < 2 || figures->is_compared)
        return;
    pl_markup_put(page, "<section id=\"run\" class=\"whole\"><h2>Time and machine</h2>\n");
    put_times(page, cJSON_GetObjectItemCaseSensitive(result, "seconds"));
    pl_markup_put(page, "<div class=\"scroll\"><table><tbody>\n");
    put_counted(page, "threads", result, "threads");
    put_fact(page, "placement", pl_figure_text(result, "binding"));
    if (!cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(mesh, "in_space"))) {
        put_fact(page, "instruction set", pl_figure_text(result, "isa"));
        put_counted(page, "colours", mesh, "colours");
    }
    put_counted(page, "node visits", result, "node_visits");
    put_counted(page, "nodes moved", result, "moved_nodes");
    if (isfinite(memory))
        pl_markup_put(
            page, "<tr><th scope=\"row\">most memory</th><td class=\"wrap\">%.1f MB</td></tr>\n",
            memory / 1e6);
    put_fact(page, "method", pl_figure_text(result, "method"));
    put_fact(page, "objective",
             pl_figure_text(cJSON_GetObjectItemCaseSensitive(result, "objective"), "name"));
    put_fact(page, "targets of the elements",
             figures->of_sizes                           ? "sizes"
             : figures->of_metric                        ? "a metric"
             : figures->has_targets && !figures->like[0] ? "former heights of the layers"
                                                         : figures->like);
    put_fact(page, "ended", pl_figure_text(result, "stop"));
    pl_markup_put(page, "</tbody></table></div></section>\n");
}

/* ---- heights of layers ---------------------------------------------------------------------- */

/** Put a row: by how much heights are off, in percent. */
static void put_heights(pl_markup *page, const char *name, int number, const cJSON *of) {
    static const char *const keys[] = {"min", "median", "max"};
    pl_markup_put(page, "<tr><th scope=\"row\">%s", name);
    if (number > 0)
        pl_markup_put(page, " %d", number);
    pl_markup_put(page, "</th><td>");
    pl_markup_put_count(page, pl_figure_count(of, "edges"));
    pl_markup_put(page, "</td>");
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        const double off = 100 * (pl_figure(of, keys[i]) - 1);
        pl_markup_put(page, "<td>");
        if (isfinite(off))
            pl_markup_put(page, "%+.3g&#8239;%%", off);
        else
            pl_markup_put_digits(page, off, 1);
        pl_markup_put(page, "</td>");
    }
    pl_markup_put(page, "</tr>\n");
}

void pl_page_put_layers(pl_markup *page, const pl_figures *figures) {
    const cJSON *heights = cJSON_GetObjectItemCaseSensitive(figures->result, "layer_heights"), *row;
    const int is_like = strcmp(pl_figure_text(heights, "wanted"), "like") == 0;
    const int is_run = figures->n_states == 2;
    const int64_t n_told = pl_figure_count(heights, "told_by_rows_inside");
    int number = 0;
    if (!cJSON_IsObject(heights) || (!is_run && !is_like && n_told == 0))
        return;
    pl_markup_put(page, "<section id=\"layers\" class=\"whole\"><h2>Heights of layers</h2>\n"
                        "<p class=\"quiet\">By how much heights are off ");
    pl_markup_put(page, "%s. Rows are counted from the thin end.",
                  is_like ? "those of the mesh that elements should be like" : "those before");
    if (n_told > 0) {
        const int is_wall = pl_figure_count(heights, "at_moved_walls") > 0;
        pl_markup_put(page, is_wall ? " A wall was moved: " : " Nodes of layers were displaced: ");
        pl_markup_put_number_of(page, n_told, "wanted height is", "wanted heights are");
        pl_markup_put(page, is_wall ? " told by the rows inside." : " told by other rows.");
    }
    pl_markup_put(page,
                  "</p>\n<div class=\"scroll\"><table class=\"many\"><thead><tr><th scope=\"col\">"
                  "</th><th scope=\"col\">heights</th><th scope=\"col\">least</th>"
                  "<th scope=\"col\">median</th><th scope=\"col\">most</th></tr></thead><tbody>\n");
    if (n_told > 0)
        put_heights(page, is_like ? "all, there" : "all, before", 0,
                    cJSON_GetObjectItemCaseSensitive(heights, "before"));
    put_heights(page, "all", 0, heights);
    cJSON_ArrayForEach(row, cJSON_GetObjectItemCaseSensitive(heights, "rows")) {
        put_heights(page, "row", ++number, row);
    }
    pl_markup_put(page, "</tbody></table></div></section>\n");
}

/* ---- what is certified ---------------------------------------------------------------------- */

/* By how much of itself a value may be worse for the rounding of sums and angles. */
static const double ROUNDING = 1e-9;

/** A claim of the form "not worse than before", shown with its two figures. */
static void put_claim(pl_markup *page, const pl_figures *figures, const char *claim,
                      const char *key, int less_is_better) {
    const double before = pl_figure(figures->state[0], key);
    const double after = pl_figure(figures->state[1], key);
    const double slack = ROUNDING * fabs(before);
    /* Of other valid elements than before nothing is claimed. */
    const int same =
        strcmp(key, "inverted") == 0 || pl_figure_count(figures->state[0], "inverted") ==
                                            pl_figure_count(figures->state[1], "inverted");
    const int holds = less_is_better ? after <= before + slack : after >= before - slack;
    if (!isfinite(before) || !isfinite(after))
        return;
    pl_markup_put(page,
                  "<tr><th scope=\"row\">%s</th><td>%.8g</td><td>%.8g</td><td class=\"word "
                  "%s\">%s</td></tr>\n",
                  claim, before, after,
                  !same   ? ""
                  : holds ? "good"
                          : "bad",
                  !same   ? "other elements"
                  : holds ? "holds"
                          : "does not hold");
}

/** Lists of elements that fall short: the first of them. */
static void put_list(pl_markup *page, const pl_figures *figures, const char *key, const char *one,
                     const char *several) {
    enum { MOST = 20, ALL = 17 }; /* elements, and digits of their numbers */
    double number[MOST];
    const int n = pl_figure_list(figures->result, key, number, MOST);
    if (n == 0)
        return;
    pl_markup_put(page, "<p><strong>");
    pl_markup_put_number_of(page, n, one, several);
    pl_markup_put(page, ":</strong>");
    for (int i = 0; i < n && i < MOST; i++) {
        pl_markup_put(page, i ? ", " : " ");
        pl_markup_put_digits(page, number[i], ALL);
    }
    pl_markup_put(page, "%s</p>\n", n > MOST ? " ..." : ".");
}

/* ---- the surface --------------------------------------------------------------------------- */

/** Put a proved distance, absolute and in edges. */
static void put_distance(pl_markup *page, const char *name, const cJSON *surface, const char *key,
                         const char *key_in_edges) {
    const double distance = pl_figure(surface, key);
    if (!cJSON_HasObjectItem(surface, key))
        return;
    pl_markup_put(page, "<tr><th scope=\"row\">%s</th><td class=\"wrap\">", name);
    if (isfinite(distance)) {
        pl_markup_put(page, "at most ");
        pl_markup_put_real(page, distance);
        pl_markup_put(page, " (");
        pl_markup_put_real(page, pl_figure(surface, key_in_edges));
        pl_markup_put(page, " mean edges)");
    } else {
        pl_markup_put(page, "not proved");
    }
    pl_markup_put(page, "</td></tr>\n");
}

/** Put the change of the volume of each region. */
static void put_volumes(pl_markup *page, const cJSON *surface) {
    enum { MOST_ROWS = 100 };
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(surface, "volumes"), *region;
    int n = 0;
    if (cJSON_GetArraySize(list) == 0)
        return;
    pl_markup_put(page, "<div class=\"scroll\"><table><thead><tr><th scope=\"col\">region</th>"
                        "<th scope=\"col\">volume before</th><th scope=\"col\">after</th>"
                        "<th scope=\"col\">change</th></tr></thead><tbody>\n");
    cJSON_ArrayForEach(region, list) {
        const double before = pl_figure(region, "before"), after = pl_figure(region, "after");
        if (n++ >= MOST_ROWS)
            continue;
        pl_markup_put(page, "<tr><th scope=\"row\">");
        pl_markup_put_text(page, pl_figure_text(region, "region"));
        pl_markup_put(page, "</th><td>");
        pl_markup_put_digits(page, before, 8);
        pl_markup_put(page, "</td><td>");
        pl_markup_put_digits(page, after, 8);
        pl_markup_put(page, "</td><td>");
        pl_markup_put_percent(page, 100 * (after / before - 1));
        pl_markup_put(page, "</td></tr>\n");
    }
    pl_markup_put(page, "</tbody></table></div>\n");
    if (n > MOST_ROWS)
        pl_markup_put(page, "<p class=\"quiet\">These are the first %d of %d regions.</p>\n",
                      MOST_ROWS, n);
}

void pl_page_put_surface(pl_markup *page, const pl_figures *figures) {
    static const char *const counts[][2] = {
        {"nodes in planes", "on_planes"},
        {"nodes on lines", "on_lines"},
        {"nodes on patches", "on_patches"},
        {"nodes on curves", "on_curves"},
        {"nodes at corners", "on_corners"},
        {"nodes out of reach", "out_of_reach"},
        {"nodes that are held", "held"},
        {"nodes off the other surface, before", "off_before"},
        {"nodes off the other surface, after", "off"},
        {"corners", "corners"},
        {"patches", "patches"},
        {"edges between them", "feature_edges"},
        {"found as creases", "creases"},
        {"moves shortened or refused", "refused_moves"},
        {"facets without a proved distance", "unproved_facets"}};
    const cJSON *surface = cJSON_GetObjectItemCaseSensitive(figures->result, "surface");
    const double bend = pl_figure(surface, "max_bend_deg");
    if (!cJSON_IsObject(surface))
        return;
    pl_markup_put(page, "<section id=\"surface\" class=\"whole\"><h2>The surface</h2>\n"
                        "<div class=\"scroll\"><table><tbody>\n");
    const int is_fitted = pl_figure_text(surface, "onto")[0] != '\0';
    put_distance(
        page, is_fitted ? "distance from the other surface" : "distance from the original surface",
        surface, "distance", "distance_in_edges");
    put_distance(page,
                 is_fitted ? "distance of the other surface from this one"
                           : "distance of the original surface from this one",
                 surface, "distance_back", "distance_back_in_edges");
    if (isfinite(bend)) {
        pl_markup_put(page, "<tr><th scope=\"row\">sharpest edge within patches</th>"
                            "<td class=\"wrap\">");
        pl_markup_put_real(page, bend);
        pl_markup_put(page, "°, before ");
        pl_markup_put_real(page, pl_figure(surface, "max_bend_before_deg"));
        pl_markup_put(page, "°</td></tr>\n");
    }
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
        put_counted(page, counts[i][0], surface, counts[i][1]);
    put_fact(page, "original surface", pl_figure_text(surface, "original"));
    put_fact(page, "other surface", pl_figure_text(surface, "onto"));
    pl_markup_put(page, "</tbody></table></div>\n");
    if (isfinite(pl_figure(surface, "distance")))
        pl_markup_put(page, "<p class=\"quiet\">planish proved these distances for every point; "
                            "they are not sampled.</p>\n");
    put_volumes(page, surface);
    pl_markup_put(page, "</section>\n");
}

/** Put what is not worse than before of elements of every type. With weights of sizes ratios count these. */
static void put_claims_of_types(pl_markup *page, const pl_figures *figures) {
    put_claim(page, figures,
              figures->has_sizes ? "worst aspect ratio with sizes of elements with a movable node"
                                 : "worst aspect ratio of elements with a movable node",
              "max_aspect_ratio_movable", 1);
    if (!figures->has_targets)
        put_claim(page, figures, "least scaled Jacobian", "min_scaled_jacobian", 0);
    if (figures->has_sizes)
        put_claim(page, figures, "RMS aspect ratio with sizes of elements with a movable node",
                  "rms_aspect_ratio_movable", 1);
    else
        put_claim(page, figures, "RMS aspect ratio", "rms_aspect_ratio", 1);
}

/** Put what is not worse than before. */
static void put_claims(pl_markup *page, const pl_figures *figures) {
    pl_markup_put(
        page,
        "<div class=\"scroll\"><table class=\"many\"><thead><tr><th scope=\"col\">measure that "
        "must not get worse</th><th scope=\"col\">before</th><th scope=\"col\">after</th><th "
        "scope=\"col\" class=\"word\">promise</th></tr></thead><tbody>\n");
    put_claim(page, figures, "inverted elements", "inverted", 1);
    put_claim(page, figures, "worst radius ratio of elements with a movable node",
              "max_radius_ratio_movable", 1);
    put_claim(page, figures, "smallest angle of elements with a movable node",
              "min_dihedral_movable_deg", 0);
    put_claim(page, figures, "RMS radius ratio", "rms_radius_ratio", 1);
    if (figures->has_types) /* these have no radius ratios and angles */
        put_claims_of_types(page, figures);
    pl_markup_put(page, "</tbody></table></div>\n<p class=\"quiet\">%s</p>\n",
                  strcmp(pl_figure_text(figures->result, "method"), "planish") == 0
                      ? "For a valid mesh and the default objective planish promises all of these. "
                        "Untangling, minimum volumes and other objectives may break the last three."
                  : figures->is_compared
                      ? "planish did not make the second mesh, and promises nothing about it."
                      : "This method is for comparison only; planish promises nothing about it.");
}

void pl_page_put_certificate(pl_markup *page, const pl_figures *figures) {
    const cJSON *result = figures->result;
    const int64_t inverted = pl_figure_count(pl_figures_last(figures), "inverted");
    const int64_t undecided = pl_figure_count(pl_figures_last(figures), "uncertified");
    pl_markup_put(page, "<section id=\"certificate\" class=\"whole\"><h2>Certificate</h2>\n<p>");
    if (inverted == 0 && undecided == 0) {
        pl_markup_put(page, "Every element is positive: none is inverted or flat.");
    } else {
        pl_markup_put_number_of(page, inverted, "element is", "elements are");
        pl_markup_put(page, " inverted or flat%s.", figures->has_types ? " somewhere" : "");
    }
    if (undecided > 0) {
        pl_markup_put(page, " planish could not decide the sign of ");
        pl_markup_put_number_of(page, undecided, "element.", "elements.");
    } else {
        pl_markup_put(page, " planish decided each sign exactly, from the coordinates %s.",
                      figures->n_states == 2 ? "as written" : "in the file");
    }
    pl_markup_put(page, "</p>\n");
    if (figures->n_states == 2)
        put_claims(page, figures);
    put_list(page, figures, "unfixable", "element cannot be repaired, wherever the free nodes go",
             "elements cannot be repaired, wherever the free nodes go");
    put_list(page, figures, "below_min", "element is below its minimum volume",
             "elements are below their minimum volume");
    pl_markup_put(page, "<div class=\"scroll\"><table><tbody>\n");
    put_fact(page, "checksum of the coordinates read", pl_figure_text(result, "input_checksum"));
    put_fact(page,
             figures->n_states == 2 ? "checksum of the coordinates written"
                                    : "checksum of the coordinates",
             pl_figure_text(result, "checksum"));
    pl_markup_put(
        page,
        "</tbody></table></div>\n"
        "<p class=\"quiet\">The checksum covers the bits of all coordinates. It is the same on any "
        "number of threads. <code>planish quality FILE --json -</code> prints it.</p>\n"
        "</section>\n");
}
