/* cell_rows: rows of layers, followed to elements that are not thin enough, or lean too much, to be found
 * by themselves.
 *
 * Along its row a layer goes on where nodes are close along the wall, as at corners and edges: elements
 * share uprights. Across it goes on to elements stacked on it: those that lean, and those that a wall has
 * been moved into.
 */
#include "shape/shape.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/layer_shape.h"

#include <string.h>

/* A row is followed along for so many elements from those that are thin: beyond, wide ones are so by
 * chance. */
enum { STEPS_ALONG = 16 };

/** Rows being followed. */
typedef struct row_walk {
    const planish_mesh *mesh;
    const uint8_t *thinness;
    uint8_t *mark;
    int64_t *first;     /* [n_nodes + 2] in candidate */
    int32_t *candidate; /* elements not marked yet, at each node */
    int32_t *queue;     /* [cells->n] */
    uint8_t *steps;     /* [cells->n] along, from a thin one */
    int64_t n;          /* in the queue */
} row_walk;

/** Nodes of an element at both ends of its uprights, by upright. */
typedef struct ends {
    int32_t node[2][PL_UPRIGHTS];
    int n;
} ends;

static const pl_cell_shape *shape_of(const row_walk *w, int64_t cell) {
    return pl_cell_type_of(w->mesh->cells->type[cell])->shape;
}

static const int32_t *nodes_of(const row_walk *w, int64_t cell) {
    return w->mesh->cells->node + w->mesh->cells->offset[cell];
}

static ends ends_of(const row_walk *w, int64_t cell) {
    const pl_cell_shape *shape = shape_of(w, cell);
    const int32_t *node = nodes_of(w, cell);
    const int factor = w->thinness[cell] & PL_SHORTEST_EDGE;
    ends e = {.n = 0};
    for (int k = 0; k < shape->n_edges; k++) {
        const int a = shape->edge[k][0], b = shape->edge[k][1];
        if (pl_factor_of(shape, a, b) != factor)
            continue;
        e.node[shape->vertex[a][factor]][e.n] = node[a];
        e.node[shape->vertex[b][factor]][e.n] = node[b];
        e.n++;
    }
    return e;
}

/** Whether an element may be reached. */
static int is_candidate(const row_walk *w, int64_t cell) {
    return !w->mark[cell] && w->thinness[cell] & (PL_IS_WIDE | PL_BADLY_SHAPED);
}

/** List the candidates at each node. */
static int list_candidates(row_walk *w) {
    const planish_cells *cells = w->mesh->cells;
    int64_t *first = w->first + 1; /* counts end up at the beginning of the next one */
    for (int64_t i = 0; i < cells->n; i++)
        for (int k = 0; is_candidate(w, i) && k < shape_of(w, i)->n_corners; k++)
            first[nodes_of(w, i)[k] + 1]++;
    for (int64_t i = 0; i < w->mesh->n_nodes; i++)
        first[i + 1] += first[i];
    w->candidate = pl_alloc(first[w->mesh->n_nodes], sizeof *w->candidate);
    for (int64_t i = 0; w->candidate && i < cells->n; i++)
        for (int k = 0; is_candidate(w, i) && k < shape_of(w, i)->n_corners; k++)
            w->candidate[first[nodes_of(w, i)[k]]++] = (int32_t)i;
    return w->candidate != NULL;
}

static int shares_upright(const ends *a, const ends *b) {
    for (int i = 0; i < a->n; i++)
        for (int j = 0; j < b->n; j++)
            if ((a->node[0][i] == b->node[0][j] && a->node[1][i] == b->node[1][j]) ||
                (a->node[0][i] == b->node[1][j] && a->node[1][i] == b->node[0][j]))
                return 1;
    return 0;
}

/** Whether all nodes at one end of a are those at one end of b. */
static int are_stacked(const ends *a, const ends *b) {
    int is_same = 0;
    for (int s = 0; s < 4 && !is_same; s++) {
        is_same = a->n == b->n;
        for (int i = 0; i < a->n && is_same; i++) {
            int is_there = 0;
            for (int j = 0; j < b->n; j++)
                is_there |= a->node[s & 1][i] == b->node[s >> 1][j];
            is_same = is_there;
        }
    }
    return is_same;
}

/** Take in a candidate at an element of a row, if the row goes on there. */
static void try_candidate(row_walk *w, int32_t from, const ends *here, int32_t to) {
    const int thinness = w->thinness[to];
    const ends there = ends_of(w, to);
    if (w->mark[to])
        return;
    if (thinness & PL_BADLY_SHAPED && are_stacked(here, &there)) {
        w->steps[to] = w->steps[from];
        w->mark[to] =
            thinness & PL_IS_WIDE && !(thinness & PL_IS_INVALID) ? PL_ROW_MARKED : PL_ROW_STACKED;
    } else if (w->mark[from] == PL_ROW_MARKED && thinness & PL_IS_WIDE &&
               !(thinness & PL_IS_INVALID) && w->steps[from] < STEPS_ALONG &&
               shares_upright(here, &there)) {
        w->steps[to] = (uint8_t)(w->steps[from] + 1);
        w->mark[to] = PL_ROW_MARKED;
    }
    if (w->mark[to])
        w->queue[w->n++] = to;
}

/** Follow rows from all marked elements, the nearest ones first. */
static void walk(row_walk *w) {
    for (int64_t i = 0; i < w->mesh->cells->n; i++)
        if (w->mark[i] && w->thinness[i])
            w->queue[w->n++] = (int32_t)i;
    for (int64_t q = 0; q < w->n; q++) {
        const int32_t cell = w->queue[q];
        const ends here = ends_of(w, cell);
        for (int k = 0; k < shape_of(w, cell)->n_corners; k++) {
            const int32_t node = nodes_of(w, cell)[k];
            for (int64_t c = w->first[node]; c < w->first[node + 1]; c++)
                try_candidate(w, cell, &here, w->candidate[c]);
        }
    }
}

int pl_follow_cell_rows(const planish_mesh *mesh, const uint8_t *thinness, uint8_t *mark,
                        planish_error *error) {
    const int64_t n = mesh->cells->n;
    row_walk w = {.mesh = mesh,
                  .thinness = thinness,
                  .mark = mark,
                  .first = pl_alloc_zero(mesh->n_nodes + 2, sizeof *w.first),
                  .queue = pl_alloc(n, sizeof *w.queue),
                  .steps = pl_alloc_zero(n, sizeof *w.steps)};
    const int is_there = w.first && w.queue && w.steps && list_candidates(&w);
    if (is_there)
        walk(&w);
    pl_free(w.first);
    pl_free(w.candidate);
    pl_free(w.queue);
    pl_free(w.steps);
    return is_there ? PLANISH_OK : pl_fail_memory(error, "thin elements");
}
