/* lines: chains of ridges that are straight. As with planes, a chain is put together from pairs of
 * neighbours and then looked at as a whole: its two ends say where the line is. */
#include "shape/lines.h"

#include "base/joined.h"
#include "base/memory.h"
#include "base/status.h"

typedef struct line_search {
    const pl_surface *surface;
    const pl_ridges *ridges;
    double tolerance;
    const int32_t *n_ridges; /* [n_nodes] ridges that end at each node */
    int32_t (*at)[2];        /* [n_nodes] the first two of them */
    int32_t *parent;         /* [n_ridges] classes of ridges that make a line */
    int32_t (*end)[3];       /* [n_ridges] of a class: its first node, the farthest from that, the
                                farthest from this; by the class's first ridge */
    double *most;            /* [n_ridges] how far the last one found is */
    uint8_t *is_bent;        /* [n_ridges] of a class */
    int32_t *line_of;        /* [n_ridges] of a class, or -1 */
} line_search;

static const double *place(const pl_surface *s, int32_t node) {
    return s->x + (int64_t)node * s->dim;
}

static int32_t other_end(const pl_ridge *ridge, int32_t node) {
    return ridge->node[ridge->node[0] == node];
}

/** Find how far node is off the line from a to b, times its length; return that length. */
static double off_line(const pl_surface *s, int32_t a, int32_t b, int32_t node, double *off) {
    double line[3], v[3], across[3];
    pl_from_to(s->dim, place(s, a), place(s, b), line);
    pl_from_to(s->dim, place(s, a), place(s, node), v);
    pl_cross(line, v, across);
    *off = pl_length(across);
    return pl_length(line);
}

/** Whether exactly two ridges of one label meet at node, straight on. */
static int is_passed(const line_search *w, int32_t node) {
    const pl_surface *s = w->surface;
    if (w->n_ridges[node] != 2)
        return 0;
    const pl_ridge *r[2] = {&w->ridges->ridge[w->at[node][0]], &w->ridges->ridge[w->at[node][1]]};
    const int32_t a = other_end(r[0], node), b = other_end(r[1], node);
    double to_a[3], to_b[3], off;
    pl_from_to(s->dim, place(s, node), place(s, a), to_a);
    pl_from_to(s->dim, place(s, node), place(s, b), to_b);
    const double length = off_line(s, a, b, node, &off);
    return pl_same_label(&r[0]->label, &r[1]->label) && pl_dot(3, to_a, to_b) < 0 &&
           off <= w->tolerance * length;
}

/** Join ridges to chains, find the farthest nodes of each, and which are bent. */
static void find_chains(line_search *w) {
    const pl_surface *s = w->surface;
    const int64_t n = w->ridges->n;
    for (int64_t i = 0; i < n; i++) {
        w->parent[i] = (int32_t)i;
        w->end[i][0] = w->ridges->ridge[i].node[0];
    }
    for (int32_t node = 0; node < s->n_nodes; node++)
        if (is_passed(w, node))
            pl_join(w->parent, w->at[node][0], w->at[node][1]);
    for (int k = 1; k < 3; k++) {
        for (int64_t i = 0; i < n; i++)
            w->most[i] = -1;
        for (int64_t i = 0; i < 2 * n; i++) {
            const int32_t c = pl_class_of(w->parent, (int32_t)(i / 2));
            const int32_t node = w->ridges->ridge[i / 2].node[i % 2];
            double v[3];
            pl_from_to(s->dim, place(s, w->end[c][k - 1]), place(s, node), v);
            const double far = pl_dot(3, v, v);
            if (far > w->most[c]) {
                w->most[c] = far;
                w->end[c][k] = node;
            }
        }
    }
    for (int64_t i = 0; i < 2 * n; i++) {
        const int32_t c = pl_class_of(w->parent, (int32_t)(i / 2));
        const int32_t node = w->ridges->ridge[i / 2].node[i % 2];
        double off;
        const double length = off_line(s, w->end[c][1], w->end[c][2], node, &off);
        if (!(length > 0 && off <= w->tolerance * length))
            w->is_bent[c] = 1;
    }
}

/** Number the lines that nodes are inside of, in the order of these nodes. */
static void number_lines(line_search *w, pl_lines *lines) {
    const pl_surface *s = w->surface;
    for (int64_t i = 0; i < w->ridges->n; i++)
        w->line_of[i] = -1;
    for (int32_t node = 0; node < s->n_nodes; node++) {
        lines->of_node[node] = -1;
        if (!is_passed(w, node))
            continue;
        const int32_t c = pl_class_of(w->parent, w->at[node][0]);
        if (w->is_bent[c])
            continue;
        if (w->line_of[c] < 0) {
            double *direction = lines->direction + 3 * lines->n;
            pl_from_to(s->dim, place(s, w->end[c][1]), place(s, w->end[c][2]), direction);
            const double length = pl_length(direction);
            for (int d = 0; d < 3; d++)
                direction[d] /= length;
            w->line_of[c] = (int32_t)lines->n++;
        }
        lines->of_node[node] = w->line_of[c];
        for (int j = 0; j < 2; j++)
            lines->next[node][j] = other_end(&w->ridges->ridge[w->at[node][j]], node);
    }
}

int pl_lines_create(const pl_surface *surface, const pl_ridges *ridges, double tolerance,
                    pl_lines *lines, planish_error *error) {
    const int64_t n = ridges->n;
    line_search w = {.surface = surface, .ridges = ridges, .tolerance = tolerance};
    *lines = (pl_lines){0};
    w.n_ridges = lines->n_ridges = pl_alloc_zero(surface->n_nodes, sizeof *lines->n_ridges);
    lines->of_node = pl_alloc(surface->n_nodes, sizeof *lines->of_node);
    lines->next = pl_alloc(surface->n_nodes, sizeof *lines->next);
    lines->direction = pl_alloc(n * 3, sizeof *lines->direction);
    w.at = pl_alloc(surface->n_nodes, sizeof *w.at);
    w.parent = pl_alloc(n, sizeof *w.parent);
    w.end = pl_alloc(n, sizeof *w.end);
    w.most = pl_alloc(n, sizeof *w.most);
    w.is_bent = pl_alloc_zero(n, sizeof *w.is_bent);
    w.line_of = pl_alloc(n, sizeof *w.line_of);
    const int has_memory = lines->n_ridges && lines->of_node && lines->next && lines->direction &&
                           w.at && w.parent && w.end && w.most && w.is_bent && w.line_of;
    for (int64_t i = 0; has_memory && i < 2 * n; i++) {
        const int32_t node = ridges->ridge[i / 2].node[i % 2];
        if (lines->n_ridges[node] < 2)
            w.at[node][lines->n_ridges[node]] = (int32_t)(i / 2);
        lines->n_ridges[node]++;
    }
    if (has_memory) {
        find_chains(&w);
        number_lines(&w, lines);
    }
    pl_free(w.at);
    pl_free(w.parent);
    pl_free(w.end);
    pl_free(w.most);
    pl_free(w.is_bent);
    pl_free(w.line_of);
    if (has_memory)
        return PLANISH_OK;
    pl_lines_destroy(lines);
    return pl_fail_memory(error, "the lines of the surface");
}

void pl_lines_destroy(pl_lines *lines) {
    pl_free(lines->n_ridges);
    pl_free(lines->of_node);
    pl_free(lines->next);
    pl_free(lines->direction);
    *lines = (pl_lines){0};
}
