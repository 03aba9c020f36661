/* page_tables: what a page says of the mesh: its measures before and after. */
#include "report/page_parts.h"

#include "job/held.h"

#include <math.h>
#include <string.h>

/* Relative changes below this are not called better or worse: the tables show fewer digits. */
static const double NOTABLE = 1e-4;

/** Which way a measure is better. */
typedef enum sense { NEITHER, LESS_IS_BETTER, MORE_IS_BETTER } sense;

typedef struct measure {
    const char *key;
    const char *solid, *plane; /* what it is called in 3-D and 2-D */
    const char *unit;
    sense sense;
    const char *style;
    int is_count;
} measure;

static const measure measures[] = {
    {"inverted", "inverted elements", "inverted elements", "", LESS_IS_BETTER, "main", 1},
    {"inverted_inside", "though their corners are right", "though their corners are right", "",
     LESS_IS_BETTER, "part", 1},
    {"reversed_elements", "reversed in the file's order", "reversed in the file's order", "",
     LESS_IS_BETTER, "", 1},
    {"uncertified", "uncertified elements", "uncertified elements", "", LESS_IS_BETTER, "", 1},
    {"curved", "curved elements", "curved elements", "", NEITHER, "", 1},
    {"below_min_volume", "elements below their minimum volume", "elements below their minimum area",
     "", LESS_IS_BETTER, "", 1},
    {"max_radius_ratio", "worst radius ratio", "worst radius ratio", "", LESS_IS_BETTER, "main", 0},
    {"max_radius_ratio_movable", "of elements with a movable node",
     "of elements with a movable node", "", LESS_IS_BETTER, "part", 0},
    {"min_dihedral_deg", "smallest dihedral angle", "smallest angle", "°", MORE_IS_BETTER, "main",
     0},
    {"min_dihedral_movable_deg", "of elements with a movable node",
     "of elements with a movable node", "°", MORE_IS_BETTER, "part", 0},
    {"max_dihedral_deg", "largest dihedral angle", "largest angle", "°", LESS_IS_BETTER, "", 0},
    {"rms_radius_ratio", "RMS radius ratio", "RMS radius ratio", "", LESS_IS_BETTER, "main", 0},
    {"rms_radius_ratio_movable", "of elements with a movable node",
     "of elements with a movable node", "", LESS_IS_BETTER, "part", 0},
    {"mean_radius_ratio", "mean radius ratio", "mean radius ratio", "", LESS_IS_BETTER, "", 0},
    {"min_jacobian_ratio", "least Jacobian coefficient / mean, curved elements",
     "least Jacobian coefficient / mean, curved elements", "", MORE_IS_BETTER, "", 0},
    {"min_volume", "smallest volume", "smallest area", "", MORE_IS_BETTER, "", 0},
    {"max_volume", "largest volume", "largest area", "", NEITHER, "", 0},
    {"total_volume", "volume of the mesh", "area of the mesh", "", NEITHER, "", 0},
};

enum { N_MEASURES = sizeof measures / sizeof *measures };

/** Measures of elements of every type. */
static const measure cell_measures[] = {
    {"inverted", "inverted elements", "inverted elements", "", LESS_IS_BETTER, "main", 1},
    {"inverted_inside", "though their corners are right", "though their corners are right", "",
     LESS_IS_BETTER, "part", 1},
    {"corner_inverted", "inverted corners", "inverted corners", "", LESS_IS_BETTER, "", 1},
    {"uncertified", "uncertified elements", "uncertified elements", "", LESS_IS_BETTER, "", 1},
    {"curved", "curved elements", "curved elements", "", NEITHER, "", 1},
    {"reversed_elements", "reversed in the file's order", "reversed in the file's order", "",
     LESS_IS_BETTER, "", 1},
    {"below_min_volume", "elements below their minimum volume", "elements below their minimum area",
     "", LESS_IS_BETTER, "", 1},
    {"max_aspect_ratio", "worst aspect ratio", "worst aspect ratio", "", LESS_IS_BETTER, "main", 0},
    {"max_aspect_ratio_movable", "of elements with a movable node",
     "of elements with a movable node", "", LESS_IS_BETTER, "part", 0},
    {"rms_aspect_ratio", "RMS aspect ratio", "RMS aspect ratio", "", LESS_IS_BETTER, "main", 0},
    {"rms_aspect_ratio_movable", "of elements with a movable node",
     "of elements with a movable node", "", LESS_IS_BETTER, "part", 0},
    {"mean_aspect_ratio", "mean aspect ratio", "mean aspect ratio", "", LESS_IS_BETTER, "", 0},
    {"min_scaled_jacobian", "least scaled Jacobian", "least scaled Jacobian", "", MORE_IS_BETTER,
     "main", 0},
    {"min_jacobian_ratio", "least Jacobian coefficient / mean, curved elements",
     "least Jacobian coefficient / mean, curved elements", "", MORE_IS_BETTER, "", 0},
    {"max_edge_ratio", "largest edge ratio", "largest edge ratio", "", LESS_IS_BETTER, "", 0},
};

enum { N_CELL_MEASURES = sizeof cell_measures / sizeof *cell_measures };

static void put_value(pl_markup *page, const measure *m, const cJSON *state) {
    const double value = pl_figure(state, m->key);
    pl_markup_put(page, "<td>");
    if (m->is_count && isfinite(value))
        pl_markup_put_count(page, pl_figure_count(state, m->key));
    else if (m->unit[0])
        pl_markup_put_angle(page, value);
    else
        pl_markup_put_real(page, value);
    pl_markup_put(page, "%s</td>", isfinite(value) ? m->unit : "");
}

/** Count what leaves elements of state s without ratios and angles: of simplices inverted corners, where they
 *  are told. */
static int64_t count_of_inverted(const pl_figures *figures, int s) {
    const cJSON *state = figures->state[s];
    const int by_corners = !figures->has_types && isfinite(pl_figure(state, "corner_inverted"));
    return pl_figure_count(state, by_corners ? "corner_inverted" : "inverted");
}

static void put_factor(pl_markup *page, const char *sign, double factor) {
    pl_markup_put(page, "%s&#8239;", sign);
    pl_markup_put_real(page, factor);
}

/** Put by how much a measure changed, as a percentage or where that says little as a factor, and in
 *  words whether for the better. */
static void put_change(pl_markup *page, const measure *m, const pl_figures *figures) {
    const double before = pl_figure(figures->state[0], m->key);
    const double after = pl_figure(figures->state[1], m->key);
    const double change = after - before, large = 10;
    const double factor = before > 0 ? after / before : NAN; /* negative values have none */
    const int differs = m->is_count ? change != 0 : fabs(change / fabs(before)) >= NOTABLE;
    /* Ratios and angles are those of the valid elements, others before than after. */
    const int is_of_same = m->is_count || strstr(m->key, "volume") ||
                           count_of_inverted(figures, 0) == count_of_inverted(figures, 1);
    const int better = (change < 0) == (m->sense == LESS_IS_BETTER);
    /* Elements that have targets need not be more regular. */
    const int is_beside = figures->has_targets && (strcmp(m->key, "min_scaled_jacobian") == 0 ||
                                                   strcmp(m->key, "max_edge_ratio") == 0);
    if (!isfinite(change) || !differs || m->sense == NEITHER || !is_of_same || is_beside) {
        pl_markup_put(page, "<td class=\"change\"></td><td class=\"word\"></td>");
        return;
    }
    pl_markup_put(page, "<td class=\"change\">");
    if (m->is_count)
        pl_markup_put(page, "%+.0f", change);
    else if (factor >= 2 && isfinite(factor)) /* no percentages above 100 */
        put_factor(page, "\xC3\x97", factor);
    else if (factor > 0 && 1 / factor >= large && isfinite(1 / factor))
        put_factor(page, "\xC3\xB7", 1 / factor);
    else if (factor > 0 && isfinite(factor))
        pl_markup_put_percent(page, 100 * (factor - 1));
    pl_markup_put(page, "</td><td class=\"word %s\">%s</td>", better ? "good" : "bad",
                  better ? "better" : "worse");
}

/** Whether each type has the measure by itself. */
static int is_of_types(const measure *m) {
    return m->style[0] != 'p' && strcmp(m->key, "reversed_elements") != 0 &&
           strcmp(m->key, "below_min_volume") != 0;
}

/** Minimum volumes have a row only where some were asked for, reversed elements, and what elements
 *  of second order alone have, where there are any. */
static int is_asked(const pl_figures *figures, const measure *m) {
    static const char *const where_any[] = {"reversed_elements", "inverted_inside", "uncertified",
                                            "curved"};
    const int is_volume = strcmp(m->key, "below_min_volume") == 0;
    int is_where_any = is_volume;
    /* Elements that wrap around count as negative. */
    if (strcmp(m->key, "total_volume") == 0 &&
        pl_figure(cJSON_GetObjectItemCaseSensitive(figures->result, "mesh"), "wrapped_elements") >
            0)
        return 0;
    if (figures->has_types && figures->n_states == 1)
        return is_of_types(m);
    if (figures->has_types && !isfinite(pl_figure(pl_figures_last(figures), m->key)) && !is_volume)
        return 0;
    for (size_t i = 0; i < sizeof where_any / sizeof *where_any; i++)
        is_where_any |= strcmp(m->key, where_any[i]) == 0;
    if (strcmp(m->key, "min_jacobian_ratio") == 0)
        return pl_figure(pl_figures_last(figures), "curved") > 0;
    if (!is_where_any)
        return 1;
    for (int s = 0; s < figures->n_states; s++)
        if (pl_figure(figures->state[s], m->key) > 0)
            return 1;
    return is_volume && isfinite(pl_figure(figures->result, "min_volume"));
}

/** Put the floor of what can be reached: the elements that nothing can change. */
static void put_floor(pl_markup *page, const pl_figures *figures) {
    const cJSON *fixed = cJSON_GetObjectItemCaseSensitive(figures->result, "fixed");
    const int64_t n = pl_figure_count(fixed, "count");
    const double worst =
        pl_figure(fixed, figures->has_types ? "max_aspect_ratio" : "max_radius_ratio");
    if (n <= 0)
        return;
    pl_markup_put(page, "<p class=\"quiet\">");
    pl_markup_put_number_of(page, n, "element has no movable node and stays as it is.",
                            "elements have no movable node and stay as they are.");
    if (isfinite(worst)) {
        pl_markup_put(
            page,
            " Smoothing cannot bring the worst %s ratio of the mesh below the worst of these, ",
            figures->has_types ? "aspect" : "radius");
        pl_markup_put_real(page, worst);
        pl_markup_put(page, ".");
    }
    pl_markup_put(page, "</p>\n");
}

/** Put why nodes are held: the reasons that any has. */
static void put_held(pl_markup *page, const pl_figures *figures) {
    const cJSON *mesh = cJSON_GetObjectItemCaseSensitive(figures->result, "mesh");
    const cJSON *held = cJSON_GetObjectItemCaseSensitive(mesh, "held");
    const int64_t n_doubled = pl_figure_count(mesh, "doubled_nodes");
    if (!cJSON_IsObject(held))
        return;
    pl_markup_put(page, "<details id=\"held\"><summary>Held nodes</summary><div "
                        "class=\"scroll\"><table><tbody>\n");
    for (int i = 0; i < PL_N_CAUSES; i++) {
        const int64_t n = pl_figure_count(held, pl_held_name(i));
        if (n <= 0)
            continue;
        pl_markup_put(page, "<tr><th scope=\"row\">%s</th><td>", pl_held_text(i));
        pl_markup_put_count(page, n);
        pl_markup_put(page, "</td></tr>\n");
    }
    pl_markup_put(
        page,
        "</tbody></table></div>\n"
        "<p class=\"quiet\">Each node counts once, under the first of its reasons in this order.");
    if (n_doubled > 0) {
        pl_markup_put(page, " ");
        pl_markup_put_number_of(page, n_doubled, "of them is at the place of another node.",
                                "of them are at the place of other nodes.");
    }
    pl_markup_put(page, "</p></details>\n");
}

/** The further measures of docs/measures.md: smallest, mean and largest over the elements. */
static void put_spreads(pl_markup *page, const pl_figures *figures) {
    static const char *const spreads[][2] = {
        {"radius_ratio", "radius ratio"},
        {"circumradius_to_edge", "circumradius / longest edge"},
        {"edge_to_inradius", "longest edge / inradius"},
        {"edge_ratio", "longest / shortest edge"},
        {"mean_ratio", "mean ratio"},
        {"scaled_jacobian", "scaled Jacobian"},
        {"smallest_angle_deg", "smallest angle of each element, degrees"},
        {"largest_angle_deg", "largest angle of each element, degrees"}};
    static const char *const parts[] = {"min", "mean", "max"};
    pl_markup_put(
        page, "<details><summary>All measures</summary><div class=\"scroll\"><table class=\"many\">"
              "<thead><tr><th scope=\"col\">over the elements</th>");
    for (int s = 0; s < figures->n_states; s++)
        for (int p = 0; p < 3; p++)
            pl_markup_put(page, "<th scope=\"col\">%s, %s</th>", figures->name[s], parts[p]);
    pl_markup_put(page, "</tr></thead><tbody>\n");
    for (size_t i = 0; i < sizeof spreads / sizeof *spreads; i++) {
        pl_markup_put(page, "<tr><th scope=\"row\">%s</th>", spreads[i][1]);
        for (int s = 0; s < figures->n_states; s++)
            for (int p = 0; p < 3; p++) {
                pl_markup_put(page, "<td>");
                pl_markup_put_real(page, pl_figure(cJSON_GetObjectItemCaseSensitive(
                                                       figures->state[s], spreads[i][0]),
                                                   parts[p]));
                pl_markup_put(page, "</td>");
            }
        pl_markup_put(page, "</tr>\n");
    }
    pl_markup_put(page, "</tbody></table></div></details>\n");
}

/** What a measure is called. */
static const char *name_of(const pl_figures *figures, const measure *m) {
    if (figures->has_sizes && strstr(m->key, "aspect_ratio_movable"))
        return "with sizes, of elements with a movable node";
    return figures->is_solid ? m->solid : m->plane;
}

/** Put a table of the measures [n]. */
static void put_table(pl_markup *page, const pl_figures *figures, const measure *of, int n) {
    pl_markup_put(page, "<div class=\"scroll\"><table>\n<thead><tr><th scope=\"col\">measure</th>");
    for (int s = 0; s < figures->n_states; s++)
        pl_markup_put(page, "<th scope=\"col\">%s</th>", figures->name[s]);
    if (figures->n_states == 2)
        pl_markup_put(page, "<th scope=\"col\" class=\"change\">change</th><th scope=\"col\" "
                            "class=\"word\">verdict</th>");
    pl_markup_put(page, "</tr></thead>\n<tbody>\n");
    for (int i = 0; i < n; i++) {
        const measure *m = &of[i];
        if (!is_asked(figures, m))
            continue;
        pl_markup_put(page, "<tr%s%s%s><th scope=\"row\">%s</th>", m->style[0] ? " class=\"" : "",
                      m->style, m->style[0] ? "\"" : "", name_of(figures, m));
        for (int s = 0; s < figures->n_states; s++)
            put_value(page, m, figures->state[s]);
        if (figures->n_states == 2)
            put_change(page, m, figures);
        pl_markup_put(page, "</tr>\n");
    }
    pl_markup_put(page, "</tbody></table></div>\n");
}

enum { MOST_TYPES = 64 }; /* columns */

/** Put a row: a measure of each type. */
static void put_measure_of_types(pl_markup *page, const measure *m, const cJSON *by_type) {
    const cJSON *of;
    int n = 0;
    pl_markup_put(page, "<tr><th scope=\"row\">%s</th>", m->solid);
    cJSON_ArrayForEach(of, by_type) {
        if (n++ < MOST_TYPES)
            put_value(page, m, of);
    }
    pl_markup_put(page, "</tr>\n");
}

/** Put the measures of elements of every type, and of each type in a column. */
static void put_types(pl_markup *page, const pl_figures *figures) {
    const cJSON *state = pl_figures_last(figures), *of;
    const cJSON *by_type = cJSON_GetObjectItemCaseSensitive(state, "by_type");
    const cJSON *counts = cJSON_GetObjectItemCaseSensitive(state, "counts");
    int n = 0;
    put_table(page, figures, cell_measures, N_CELL_MEASURES);
    pl_markup_put(page,
                  "<div class=\"scroll\"><table>\n<thead><tr><th scope=\"col\">by type%s</th>",
                  figures->n_states == 2 ? ", after" : "");
    cJSON_ArrayForEach(of, by_type) {
        if (n++ == MOST_TYPES)
            break;
        pl_markup_put(page, "<th scope=\"col\">");
        pl_markup_put_text(page, of->string ? of->string : "");
        pl_markup_put(page, "</th>");
    }
    pl_markup_put(page, "</tr></thead>\n<tbody>\n<tr><th scope=\"row\">elements</th>");
    n = 0;
    cJSON_ArrayForEach(of, by_type) {
        if (n++ == MOST_TYPES)
            break;
        pl_markup_put(page, "<td>");
        pl_markup_put_count(page, pl_figure_count(counts, of->string ? of->string : ""));
        pl_markup_put(page, "</td>");
    }
    pl_markup_put(page, "</tr>\n");
    for (int i = 0; i < N_CELL_MEASURES; i++)
        if (is_of_types(&cell_measures[i]))
            put_measure_of_types(page, &cell_measures[i], by_type);
    pl_markup_put(page, "</tbody></table></div>\n");
}

void pl_page_put_measures(pl_markup *page, const pl_figures *figures) {
    const pl_figures alone = pl_figures_simplices(figures);
    const int has_mids = pl_figures_have_simplex_mids(figures);
    pl_markup_put(page, "<section id=\"measures\" class=\"whole\"><h2>%s</h2>\n",
                  figures->n_states == 2 ? "Before and after" : "Quality");
    if (figures->has_types)
        put_types(page, figures);
    if (figures->has_types && !figures->has_targets && figures->n_states == 2)
        pl_markup_put(page,
                      "<p class=\"quiet\">The measure of every element, also of %s, is AR, the "
                      "mean ratio of its corners. Do not compare AR with radius ratios.</p>\n",
                      figures->is_solid ? "tetrahedra" : "triangles");
    if (figures->has_types && alone.n_states > 0)
        pl_markup_put(page, "<h3>%s %s alone%s</h3>\n", has_mids ? "All" : "Straight",
                      figures->is_solid ? "tetrahedra" : "triangles",
                      has_mids ? ", by their corners" : "");
    if (alone.n_states > 0)
        put_table(page, &alone, measures, N_MEASURES);
    put_floor(page, figures);
    put_held(page, figures);
    if (alone.n_states > 0)
        put_spreads(page, &alone);
    pl_markup_put(page, "</section>\n");
}
