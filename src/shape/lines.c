/* lines: chains of ridges that are straight. As with planes, a chain is put together from pairs of
 * neighbours and then looked at as a whole: its two ends say where the line is. */
#include "shape/shape.h"

#include "base/memory.h"
#include "base/status.h"
#include "shape/vectors.h"

typedef struct work {
    const pl_surface *surface;
    const pl_ridges *ridges;
    double tolerance;
    int32_t (*at)[2];  /* [n_nodes] the first two ridges of each node */
    int32_t *degree;   /* [n_nodes] how many it has */
    int32_t *parent;   /* [n_ridges] classes of ridges that make a line */
    int32_t (*end)[3]; /* [n_ridges] of a class: its first node, the farthest from that, the
                          farthest from this; by the class's first ridge */
    double *most;      /* [n_ridges] how far the last one found is */
    uint8_t *is_bent;  /* [n_ridges] of a class */
} work;

static const double *place(const pl_surface *s, int32_t node) {
    return s->x + (int64_t)node * s->dim;
}

static int32_t other_end(const pl_ridge *ridge, int32_t node) {
    return ridge->node[ridge->node[0] == node];
}

/** How far node is off the line from a to b, not divided by its length, which is returned. */
static double off_line(const pl_surface *s, int32_t a, int32_t b, int32_t node, double *off) {
    double line[3], v[3], across[3];
    pl_from_to(s->dim, place(s, a), place(s, b), line);
    pl_from_to(s->dim, place(s, a), place(s, node), v);
    pl_cross(line, v, across);
    *off = pl_length(across);
    return pl_length(line);
}

/** Whether exactly two ridges of one label meet at node, straight on. */
static int is_passed(const work *w, int32_t node) {
    const pl_surface *s = w->surface;
    if (w->degree[node] != 2)
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

static void count_ridges(work *w) {
    for (int64_t i = 0; i < w->ridges->n; i++)
        for (int j = 0; j < 2; j++) {
            const int32_t node = w->ridges->ridge[i].node[j];
            if (w->degree[node] < 2)
                w->at[node][w->degree[node]] = (int32_t)i;
            w->degree[node]++;
        }
}

/** The farthest nodes of each class. */
static void find_ends(work *w) {
    const pl_surface *s = w->surface;
    for (int64_t i = 0; i < w->ridges->n; i++)
        w->end[i][0] = w->ridges->ridge[i].node[0];
    for (int k = 1; k < 3; k++) {
        for (int64_t i = 0; i < w->ridges->n; i++)
            w->most[i] = -1;
        for (int64_t i = 0; i < w->ridges->n; i++)
            for (int j = 0; j < 2; j++) {
                const int32_t c = pl_class_of(w->parent, (int32_t)i);
                const int32_t node = w->ridges->ridge[i].node[j];
                double v[3];
                pl_from_to(s->dim, place(s, w->end[c][k - 1]), place(s, node), v);
                const double far = pl_dot(3, v, v);
                if (far > w->most[c]) {
                    w->most[c] = far;
                    w->end[c][k] = node;
                }
            }
    }
}

static void find_bent(work *w) {
    for (int64_t i = 0; i < w->ridges->n; i++)
        for (int j = 0; j < 2; j++) {
            const int32_t c = pl_class_of(w->parent, (int32_t)i);
            double off;
            const double length =
                off_line(w->surface, w->end[c][1], w->end[c][2], w->ridges->ridge[i].node[j], &off);
            if (!(length > 0 && off <= w->tolerance * length))
                w->is_bent[c] = 1;
        }
}

/** The lines that nodes are inside of, numbered in the order of these. line_of [n_ridges] of
 *  classes is scratch. */
static void number_lines(work *w, pl_lines *lines, int32_t *line_of) {
    const pl_surface *s = w->surface;
    for (int64_t i = 0; i < w->ridges->n; i++)
        line_of[i] = -1;
    for (int32_t node = 0; node < s->n_nodes; node++) {
        lines->of_node[node] = -1;
        if (!is_passed(w, node))
            continue;
        const int32_t c = pl_class_of(w->parent, w->at[node][0]);
        if (w->is_bent[c])
            continue;
        if (line_of[c] < 0) {
            double *direction = lines->direction + 3 * lines->n;
            pl_from_to(s->dim, place(s, w->end[c][1]), place(s, w->end[c][2]), direction);
            const double length = pl_length(direction);
            for (int d = 0; d < 3; d++)
                direction[d] /= length;
            line_of[c] = (int32_t)lines->n++;
        }
        lines->of_node[node] = line_of[c];
        for (int j = 0; j < 2; j++)
            lines->next[node][j] = other_end(&w->ridges->ridge[w->at[node][j]], node);
    }
}

static int make_lines(work *w, pl_lines *lines) {
    const int64_t n = w->ridges->n;
    int32_t *line_of = pl_alloc(n, sizeof *line_of);
    if (!line_of)
        return -1;
    count_ridges(w);
    for (int64_t i = 0; i < n; i++)
        w->parent[i] = (int32_t)i;
    for (int32_t node = 0; node < w->surface->n_nodes; node++)
        if (is_passed(w, node))
            pl_join(w->parent, w->at[node][0], w->at[node][1]);
    find_ends(w);
    find_bent(w);
    number_lines(w, lines, line_of);
    pl_free(line_of);
    return 0;
}

int pl_lines_create(const pl_surface *surface, const pl_ridges *ridges, double tolerance,
                    pl_lines *lines, planish_error *error) {
    const int64_t n = ridges->n;
    work w = {.surface = surface, .ridges = ridges, .tolerance = tolerance};
    *lines = (pl_lines){0};
    lines->of_node = pl_alloc(surface->n_nodes, sizeof *lines->of_node);
    lines->next = pl_alloc(surface->n_nodes, sizeof *lines->next);
    lines->direction = pl_alloc(n * 3, sizeof *lines->direction);
    w.at = pl_alloc(surface->n_nodes, sizeof *w.at);
    w.degree = pl_alloc_zero(surface->n_nodes, sizeof *w.degree);
    w.parent = pl_alloc(n, sizeof *w.parent);
    w.end = pl_alloc(n, sizeof *w.end);
    w.most = pl_alloc(n, sizeof *w.most);
    w.is_bent = pl_alloc_zero(n, sizeof *w.is_bent);
    const int done = lines->of_node && lines->next && lines->direction && w.at && w.degree &&
                     w.parent && w.end && w.most && w.is_bent && make_lines(&w, lines) == 0;
    pl_free(w.at);
    pl_free(w.degree);
    pl_free(w.parent);
    pl_free(w.end);
    pl_free(w.most);
    pl_free(w.is_bent);
    if (done)
        return PLANISH_OK;
    pl_lines_destroy(lines);
    return pl_fail_memory(error, "the lines of the surface");
}

void pl_lines_destroy(pl_lines *lines) {
    pl_free(lines->of_node);
    pl_free(lines->next);
    pl_free(lines->direction);
    *lines = (pl_lines){0};
}

int pl_ridges_of_plane_mesh(const pl_surface *surface, pl_ridges *ridges, planish_error *error) {
    ridges->ridge = pl_alloc(surface->n_facets, sizeof *ridges->ridge);
    if (!ridges->ridge)
        return pl_fail_memory(error, "the edges of the surface");
    for (int64_t i = 0; i < surface->n_facets; i++) {
        const int32_t *node = surface->facet + 2 * i;
        ridges->ridge[i] = (pl_ridge){{node[0], node[1]}, surface->label[i]};
    }
    ridges->n = ridges->capacity = surface->n_facets;
    return PLANISH_OK;
}
