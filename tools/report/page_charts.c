/* page_charts: the histograms of a page, and how the smoothing converged. */
#include "report/chart.h"
#include "report/page_parts.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- histograms ----------------------------------------------------------------------------- */

enum { MOST_BINS = 64 };

/** The bins of one histogram, in the states that there are. */
typedef struct bins {
    int n;
    double edges[MOST_BINS + 1];
    double count[2][MOST_BINS];
} bins;

/** Read them; 0 if a state has none, or others than the first. */
static int read_bins(const pl_figures *figures, const char *key, bins *b) {
    *b = (bins){0};
    for (int s = 0; s < figures->n_states; s++) {
        const cJSON *histogram = cJSON_GetObjectItemCaseSensitive(figures->state[s], key);
        const int n = pl_figure_list(histogram, "counts", b->count[s], MOST_BINS);
        if (n < 1 || n > MOST_BINS || (s > 0 && n != b->n) ||
            pl_figure_list(histogram, "edges", b->edges, MOST_BINS + 1) != n + 1)
            return 0;
        b->n = n;
        for (int i = 0; i < n; i++)
            if (!isfinite(b->edges[i]))
                return 0;
    }
    if (!isfinite(b->edges[b->n])) /* null is how JSON says infinite */
        b->edges[b->n] = INFINITY;
    return 1;
}

/* Degrees: no triangle has a larger smallest angle. */
static const double LARGEST_IN_TRIANGLE = 60;

/** Let the bins end at a value: elements of later bins, to which rounding took them, are of the last. */
static void end_bins(bins *b, double end) {
    while (b->n > 1 && b->edges[b->n - 1] >= end) {
        b->n--;
        for (int s = 0; s < 2; s++)
            b->count[s][b->n - 1] += b->count[s][b->n];
    }
}

/** Put the bins as a table. */
static void put_bins_table(pl_markup *page, const pl_figures *figures, const bins *b) {
    pl_markup_put(page,
                  "<details><summary>Numbers</summary><div class=\"scroll\"><table><thead><tr><th "
                  "scope=\"col\">from</th><th scope=\"col\">to</th>");
    for (int s = 0; s < figures->n_states; s++)
        pl_markup_put(page, "<th scope=\"col\">%s</th>", figures->name[s]);
    pl_markup_put(page, "</tr></thead><tbody>\n");
    for (int i = 0; i < b->n; i++) {
        pl_markup_put(page, "<tr><th scope=\"row\">%.6g</th><td>", b->edges[i]);
        pl_markup_put_digits(page, b->edges[i + 1], 6);
        pl_markup_put(page, "</td>");
        for (int s = 0; s < figures->n_states; s++) {
            pl_markup_put(page, "<td>");
            pl_markup_put_count(page, pl_figure_whole(b->count[s][i]));
            pl_markup_put(page, "</td>");
        }
        pl_markup_put(page, "</tr>\n");
    }
    pl_markup_put(page, "</tbody></table></div></details>\n");
}

/** Put what the viewer needs to show the elements of bins. */
static void put_brush_data(pl_markup *page, const pl_figures *figures, const char *key,
                           const bins *b) {
    const pl_chart_frame frame = pl_chart_frame_of_bins();
    pl_markup_put(page, " data-measure=\"%s\" data-frame=\"%d,%d\" data-counts=\"", key, frame.from,
                  frame.to);
    for (int s = 0; s < figures->n_states; s++)
        for (int i = 0; i < b->n; i++)
            pl_markup_put(page, "%s%" PRId64,
                          i   ? ","
                          : s ? ";"
                              : "",
                          pl_figure_whole(b->count[s][i]));
    pl_markup_put(page, "\"");
}

/** Put the lists by which bins are chosen, which the viewer fills. */
static void put_brush(pl_markup *page, const char *title) {
    pl_markup_put(
        page,
        "<div class=\"controls brush\" hidden>show elements from <select "
        "aria-label=\"%s from\"></select> to <select aria-label=\"%s to\"></select> in the "
        "picture <button type=\"button\" disabled>all</button></div>\n",
        title, title);
}

static void put_histogram(pl_markup *page, const pl_figures *figures, const char *key,
                          const char *title, const char *axis) {
    bins b;
    if (!read_bins(figures, key, &b))
        return;
    if (!figures->is_solid && strcmp(key, "angle_histogram") == 0)
        end_bins(&b, LARGEST_IN_TRIANGLE);
    const pl_histogram histogram = {.title = title,
                                    .axis = axis,
                                    .edges = b.edges,
                                    .n_bins = b.n,
                                    .n_series = figures->n_states,
                                    .count = {b.count[0], b.count[1]},
                                    .name = {figures->name[0], figures->name[1]}};
    pl_markup_put(page, "<figure%s", figures->n_states == 1 ? " class=\"only\"" : "");
    put_brush_data(page, figures, key, &b);
    pl_markup_put(page, "><h3>%s</h3>\n", title);
    pl_chart_histogram(page, &histogram);
    put_brush(page, title);
    put_bins_table(page, figures, &b);
    pl_markup_put(page, "</figure>\n");
}

void pl_page_put_histograms(pl_markup *page, const pl_figures *all) {
    const int is_of_types = all->has_types && all->n_states == 2;
    const pl_figures alone = pl_figures_simplices(all), *figures = is_of_types ? all : &alone;
    if (figures->n_states == 0)
        return;
    pl_markup_put(page, "<section id=\"histograms\"><h2>%s by quality</h2>\n",
                  !all->has_types || is_of_types ? "Elements"
                  : figures->is_solid            ? "Straight tetrahedra"
                                                 : "Straight triangles");
    pl_markup_put(page, "<p class=\"quiet\">The axis for the numbers of elements is logarithmic, "
                        "so that a few bad elements are visible beside many good ones. Inverted "
                        "elements have no quality and are not counted.</p>\n"
                        "<div class=\"charts\">\n");
    put_histogram(page, figures, "aspect_histogram", "Aspect ratio", "aspect ratio AR (ideal: 1)");
    put_histogram(page, figures, "histogram", "Radius ratio",
                  figures->is_solid ? "radius ratio R/(3r) (regular: 1)"
                                    : "radius ratio R/(2r) (regular: 1)");
    put_histogram(page, figures, "angle_histogram",
                  figures->is_solid ? "Smallest dihedral angle" : "Smallest angle",
                  figures->is_solid ? "smallest dihedral angle, degrees (regular: 70.5)"
                                    : "smallest angle, degrees (regular: 60)");
    pl_markup_put(page, "</div></section>\n");
}

/* ---- convergence ---------------------------------------------------------------------------- */

/* What stands for no element on a logarithmic axis, below one. */
static const double NONE_INVERTED = 0.5;

/** The sweeps as points of curves; the first one is the state before. */
typedef struct history {
    int64_t n;
    double *sweep, *time, *rms, *movable, *inverted; /* [n] each, of one block */
    const char **phase;                              /* [n] */
    int any_inverted;
} history;

/** Read the sweeps, 1 of h->n and up, of the state before and after each; 0 without memory. */
static int read_history(const pl_figures *figures, const cJSON *sweeps, history *h) {
    const cJSON *before = figures->state[0], *sweep;
    const cJSON *objective = cJSON_GetObjectItemCaseSensitive(figures->result, "objective");
    const char *name = pl_figure_text(objective, "name");
    const int has_types = figures->has_types;
    /* What sweeps minimise is the measure of the table only if that is the objective, and no element was
     * inverted inside: sweeps look at corners. */
    const int known =
        (name[0] == '\0' || strcmp(name, has_types ? "mean-ratio" : "radius-ratio") == 0) &&
        !(has_types && pl_figure(before, "inverted_inside") > 0);
    const char *rms = has_types ? "rms_aspect_ratio" : "rms_radius_ratio";
    const char *movable = has_types ? "rms_aspect_ratio_movable" : "rms_radius_ratio_movable";
    const int64_t n = (int64_t)cJSON_GetArraySize(sweeps) + 1;
    double *block = malloc((size_t)(5 * n) * sizeof *block);
    const char **phase = malloc((size_t)n * sizeof *phase);
    int64_t i = 1;
    *h = (history){.n = n, .phase = phase, .sweep = block};
    if (!block || !phase)
        return 0;
    h->time = block + n;
    h->rms = block + 2 * n;
    h->movable = block + 3 * n;
    h->inverted = block + 4 * n;
    h->sweep[0] = h->time[0] = 0;
    h->rms[0] = known ? pl_figure(before, rms) : NAN;
    h->movable[0] = known ? pl_figure(before, movable) : NAN;
    h->inverted[0] = pl_figure(before, "inverted");
    cJSON_ArrayForEach(sweep, sweeps) {
        const double seconds = pl_figure(sweep, "seconds");
        h->sweep[i] = (double)i;
        h->time[i] = h->time[i - 1] + (seconds > 0 ? seconds : 0);
        h->rms[i] = pl_figure(sweep, "rms");
        h->movable[i] = pl_figure(sweep, "rms_movable");
        h->inverted[i] = pl_figure(sweep, "inverted");
        h->phase[i] = pl_figure_text(sweep, "phase");
        i++;
    }
    h->phase[0] = h->phase[1];
    for (i = 0; i < n; i++) {
        h->any_inverted |= h->inverted[i] > 0;
        h->inverted[i] = fmax(h->inverted[i], NONE_INVERTED);
    }
    return 1;
}

static void put_curves(pl_markup *page, const history *h, int over_time) {
    const pl_curves curves = {.title = over_time
                                           ? "RMS of the ratio that is minimised, over time"
                                           : "RMS of the ratio that is minimised, after each sweep",
                              .x_axis = over_time ? "seconds within sweeps" : "sweeps",
                              .n = h->n,
                              .x = over_time ? h->time : h->sweep,
                              .n_series = 2,
                              .y = {h->rms, h->movable},
                              .name = {"all elements", "elements with a movable node"},
                              .phase = h->phase,
                              .x_step = over_time ? 0 : 1};
    pl_markup_put(page, "<figure><h3>%s</h3>\n", over_time ? "Over time" : "By sweep");
    pl_chart_curves(page, &curves);
    pl_markup_put(page, "</figure>\n");
}

static void put_inverted(pl_markup *page, const history *h) {
    const pl_curves curves = {.title = "Inverted elements after each sweep",
                              .x_axis = "sweeps",
                              .n = h->n,
                              .x = h->sweep,
                              .n_series = 1,
                              .y = {h->inverted},
                              .name = {"inverted elements"},
                              .phase = h->phase,
                              .floor = NONE_INVERTED,
                              .x_step = 1,
                              .y_step = 1};
    if (!h->any_inverted)
        return;
    pl_markup_put(page, "<figure><h3>Inverted elements (bottom: none)</h3>\n");
    pl_chart_curves(page, &curves);
    pl_markup_put(page, "</figure>\n");
}

/** Put the sweeps as a table; of many sweeps every second or third, and the last. */
static void put_history_table(pl_markup *page, const history *h) {
    enum { MOST_ROWS = 200 };
    const int64_t stride = h->n / MOST_ROWS + 1;
    pl_markup_put(
        page,
        "<details><summary>Numbers</summary><div class=\"scroll\"><table class=\"many\"><thead>"
        "<tr><th scope=\"col\">sweep</th><th scope=\"col\" class=\"word\">phase"
        "</th><th scope=\"col\">seconds</th><th scope=\"col\">RMS</th><th "
        "scope=\"col\">RMS, movable</th><th scope=\"col\">inverted</th></tr>"
        "</thead><tbody>\n");
    for (int64_t i = 0; i < h->n; i++) {
        if (i % stride != 0 && i != h->n - 1)
            continue;
        pl_markup_put(page, "<tr><th scope=\"row\">%.0f</th><td class=\"word\">", h->sweep[i]);
        pl_markup_put_text(page, i == 0 ? "before" : h->phase[i]);
        pl_markup_put(page, "</td><td>");
        pl_markup_put_real(page, h->time[i]);
        pl_markup_put(page, "</td><td>");
        pl_markup_put_digits(page, h->rms[i], 8);
        pl_markup_put(page, "</td><td>");
        pl_markup_put_digits(page, h->movable[i], 8);
        pl_markup_put(page, "</td><td>");
        pl_markup_put_count(page, pl_figure_whole(h->inverted[i]));
        pl_markup_put(page, "</td></tr>\n");
    }
    pl_markup_put(page, "</tbody></table></div></details>\n");
}

void pl_page_put_convergence(pl_markup *page, const pl_figures *figures) {
    const cJSON *sweeps = cJSON_GetObjectItemCaseSensitive(figures->result, "sweeps");
    const int has_sweeps = cJSON_IsArray(sweeps) && cJSON_GetArraySize(sweeps) > 0;
    history h = {.n = 0};
    if (figures->n_states < 2 || figures->is_compared)
        return;
    pl_markup_put(page, "<section id=\"convergence\"><h2>Convergence</h2>\n");
    if (!has_sweeps) {
        pl_markup_put(page, "<p>There were no sweeps.</p>\n");
    } else if (!read_history(figures, sweeps, &h)) {
        page->failed = 1;
    } else {
        pl_markup_put(page, "<p class=\"quiet\">Root mean square of the ratio that is minimised, "
                            "over the valid elements. Sweeps that untangle the mesh or improve the "
                            "worst elements are shaded.</p>\n<div class=\"charts\">\n");
        put_curves(page, &h, 0);
        put_curves(page, &h, 1);
        put_inverted(page, &h);
        pl_markup_put(page, "</div>\n");
        put_history_table(page, &h);
    }
    free(h.sweep);
    free(h.phase);
    pl_markup_put(page, "</section>\n");
}
