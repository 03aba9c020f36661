/* page_worst: where the worst elements of a mesh are. */
#include "report/page_parts.h"

#include "job/held.h"

#include <math.h>

/** Put an angle with its unit. */
static void put_degrees(pl_markup *page, double degrees) {
    pl_markup_put_angle(page, degrees);
    pl_markup_put(page, isfinite(degrees) ? "°" : "");
}

/** A list of numbers, at most those of the largest element, with that many significant digits; between: what stands between
 *  two. */
static void put_numbers(pl_markup *page, const cJSON *object, const char *key, int digits,
                        const char *between) {
    enum { MOST = 27 };
    double number[MOST];
    const int listed = pl_figure_list(object, key, number, MOST);
    for (int i = 0; i < listed && i < MOST; i++) {
        pl_markup_put(page, "%s", i ? between : "");
        pl_markup_put_digits(page, number[i], digits);
    }
}

/** Put whether an element has a movable node, and what holds all of these. */
static void put_movable(pl_markup *page, const cJSON *element) {
    const cJSON *movable = cJSON_GetObjectItemCaseSensitive(element, "movable");
    const char *held = pl_figure_text(element, "held");
    pl_markup_put(page, "</td><td class=\"%s wide\">%s%s", held[0] ? "wrap" : "word",
                  cJSON_IsFalse(movable) ? "no" : "yes", held[0] ? ", but " : "");
    pl_markup_put_text(page, held[0] ? pl_held_text_in_run(held) : "");
    pl_markup_put(page, "</td>");
}

static void put_element(pl_markup *page, const cJSON *element, int has_types, int has_regions) {
    enum { SOME = 5, ALL = 17 }; /* digits */
    const char *ratio = has_types ? "aspect_ratio" : "radius_ratio";
    const int is_inverted = cJSON_IsNull(cJSON_GetObjectItemCaseSensitive(element, ratio));
    const double number = pl_figure(element, "element");
    pl_markup_put(page, "<tr><th scope=\"row\">");
    pl_markup_put_digits(page, number, ALL);
    if (has_types) {
        pl_markup_put(page, "</th><td class=\"word\">");
        pl_markup_put_text(page, pl_figure_text(element, "type"));
        pl_markup_put(page, "</td>");
    } else {
        pl_markup_put(page, "</th>");
    }
    pl_markup_put(page,
                  "<td class=\"show\"><button type=\"button\" hidden aria-label=\"show element ");
    pl_markup_put_digits(page, number, ALL);
    pl_markup_put(page, "\" data-place=\"");
    put_numbers(page, element, "place", ALL, ",");
    pl_markup_put(page, "\">show</button></td><td>");
    if (is_inverted)
        pl_markup_put(page, "inverted");
    else
        pl_markup_put_real(page, pl_figure(element, ratio));
    if (!has_types) {
        pl_markup_put(page, "</td><td>");
        put_degrees(page, pl_figure(element, "min_angle_deg"));
        pl_markup_put(page, "</td><td>");
        put_degrees(page, pl_figure(element, "max_angle_deg"));
    }
    put_movable(page, element);
    pl_markup_put(page, "<td class=\"word wide\">");
    put_numbers(page, element, "place", SOME, ", ");
    pl_markup_put(page, "</td><td class=\"wrap wide\">");
    put_numbers(page, element, "nodes", ALL, " ");
    pl_markup_put(page, has_regions ? "</td><td class=\"word wide\">" : "");
    pl_markup_put_text(page, pl_figure_text(element, "region"));
    pl_markup_put(page, "</td></tr>\n");
}

static void put_bad_elements(pl_markup *page, const cJSON *state, int has_types) {
    enum { MOST_ROWS = 1000 };
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(state, "worst_elements"), *element;
    int n = 0, has_regions = 0;
    cJSON_ArrayForEach(element, list) {
        has_regions |= pl_figure_text(element, "region")[0] != '\0';
    }
    pl_markup_put(page,
                  "<div class=\"scroll\"><table><thead><tr><th scope=\"col\">element</th>"
                  "%s<th scope=\"col\" class=\"show\">picture</th>%s",
                  has_types ? "<th scope=\"col\" class=\"word\">type</th>" : "",
                  has_types ? "<th scope=\"col\">aspect ratio</th>"
                            : "<th scope=\"col\">radius ratio</th><th scope=\"col\">smallest "
                              "angle</th><th scope=\"col\">largest</th>");
    pl_markup_put(page,
                  "<th scope=\"col\" class=\"word wide\">movable node</th><th scope=\"col\" "
                  "class=\"word wide\">middle</th><th scope=\"col\" "
                  "class=\"word wide\">nodes</th>%s</tr></thead><tbody>\n",
                  has_regions ? "<th scope=\"col\" class=\"word wide\">region</th>" : "");
    cJSON_ArrayForEach(element, list) {
        if (n++ < MOST_ROWS)
            put_element(page, element, has_types, has_regions);
    }
    pl_markup_put(page, "</tbody></table></div>\n");
    if (n > MOST_ROWS)
        pl_markup_put(page, "<p class=\"quiet\">These are the first %d of %d.</p>\n", MOST_ROWS, n);
}

static int lists_elements(const cJSON *state) {
    return cJSON_GetArraySize(cJSON_GetObjectItemCaseSensitive(state, "worst_elements")) > 0;
}

void pl_page_put_worst(pl_markup *page, const pl_figures *figures) {
    const cJSON *last = pl_figures_last(figures);
    if (!lists_elements(last))
        return;
    pl_markup_put(page, "<section id=\"worst\"><h2>Where the worst elements are</h2>\n"
                        "<p class=\"quiet\">Numbers of elements and nodes are those of the file, "
                        "and middles are in its units.<span class=\"narrow\"> A wider window "
                        "shows more columns.</span></p>\n");
    put_bad_elements(page, last, figures->has_types);
    if (figures->n_states == 2 && lists_elements(figures->state[0])) {
        pl_markup_put(page, "<details><summary>The worst before</summary>\n");
        put_bad_elements(page, figures->state[0], figures->has_types);
        pl_markup_put(page, "</details>\n");
    }
    pl_markup_put(page, "</section>\n");
}
