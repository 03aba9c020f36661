/* return: nodes that were moved for nothing go back to where they were.
 *
 * After the ladder some cells may still be tangled, and what is around them far worse than it was. A
 * patch is such cells, those that were tangled at first, and some rings around: where it
 * has as many tangled elements as before, its nodes return, unless that tangles more with the
 * neighbours as they are now; then more rings are tried. With all rings that cannot be.
 * In: the mesh after the ladder; out: with some nodes where they were. Whole meshes only.
 */
#include "improve/untangle/return.h"

#include "base/context.h"
#include "base/joined.h"
#include "base/memory.h"
#include "base/parts.h"

#include <inttypes.h>
#include <string.h>

/** The mesh at three places: at the start, now, and with some patches put back. */
enum { BEFORE, AFTER, TRIAL, PLACES };

/** Patches whose nodes may return; nodes by inner numbers. Arrays are owned. */
typedef struct patches {
    pl_tangle *t;
    size_t bytes;             /* of coordinates */
    double *start, *now;      /* [n_nodes][dim] */
    uint8_t *tangled[PLACES]; /* [n_cells] 1: is tangled there */
    int32_t *ring;            /* [n_nodes] 0: in no patch, else the ring in which it was marked */
    int32_t *parent;          /* [n_nodes] of a union-find structure over nodes of patches */
    int32_t *n[PLACES];       /* [n_nodes] tangled cells there, at roots */
} patches;

/** Move the nodes to x, and find what is tangled there. */
static void place(patches *w, const double *x, int at) {
    const planish_plan *plan = w->t->run->plan;
    memcpy(plan->scratch.coordinates, x, w->bytes);
    pl_run_measure(w->t->run);
    pl_tangle_find(w->t);
    for (int64_t c = 0; c < pl_view_cells(&plan->work); c++)
        w->tangled[at][c] = (uint8_t)pl_tangle_is_tangled(w->t, c);
}

/** Place of the first node of a cell in the nodes of all elements; a node may be there twice. */
static int64_t first_node(const patches *w, int64_t cell) {
    const planish_plan *plan = w->t->run->plan;
    return pl_first_of_cell(&plan->work, cell) * (plan->dim + 1);
}

/** Inner number of the node at a place. */
static int32_t node_at(const patches *w, int64_t place) {
    const planish_plan *plan = w->t->run->plan;
    return plan->inner[plan->work.elements[place]];
}

static int has_moved(const patches *w, int32_t node) {
    const int dim = w->t->run->plan->dim;
    return memcmp(w->start + (int64_t)node * dim, w->now + (int64_t)node * dim,
                  (size_t)dim * sizeof *w->now) != 0;
}

/** Mark the nodes that have moved of elements that are or were tangled, and of rings around. */
static void mark_patches(patches *w, int32_t rings) {
    const planish_plan *plan = w->t->run->plan;
    memset(w->ring, 0, (size_t)plan->work.n_nodes * sizeof *w->ring);
    for (int32_t i = 0; rings == PL_ALL_RINGS && i < plan->work.n_nodes; i++)
        w->ring[i] = has_moved(w, i);
    for (int32_t ring = 1; rings < PL_ALL_RINGS && ring <= rings + 1; ring++)
        for (int64_t c = 0; c < pl_view_cells(&plan->work); c++) {
            const int64_t begin = first_node(w, c), end = first_node(w, c + 1);
            int is_near = ring == 1 && (w->tangled[BEFORE][c] || w->tangled[AFTER][c]);
            for (int64_t j = begin; ring > 1 && j < end; j++) {
                const int32_t k = w->ring[node_at(w, j)];
                is_near |= k > 0 && k < ring;
            }
            for (int64_t j = begin; is_near && j < end; j++) {
                const int32_t node = node_at(w, j);
                if (w->ring[node] == 0 && has_moved(w, node))
                    w->ring[node] = ring;
            }
        }
}

/** Return the patch of a cell; -1: none. */
static int32_t patch_of(const patches *w, int64_t cell) {
    for (int64_t j = first_node(w, cell); j < first_node(w, cell + 1); j++)
        if (w->ring[node_at(w, j)] > 0)
            return pl_class_of(w->parent, node_at(w, j));
    return -1;
}

static void join_patches(patches *w) {
    const planish_plan *plan = w->t->run->plan;
    for (int32_t i = 0; i < plan->work.n_nodes; i++)
        w->parent[i] = i;
    for (int64_t c = 0; c < pl_view_cells(&plan->work); c++) {
        int32_t root = patch_of(w, c);
        for (int64_t j = first_node(w, c); j < first_node(w, c + 1) && root >= 0; j++)
            if (w->ring[node_at(w, j)] > 0)
                root = pl_join(w->parent, root, node_at(w, j));
    }
}

/** Count the tangled cells of each patch. */
static void count_tangled(const patches *w, int at) {
    const planish_plan *plan = w->t->run->plan;
    memset(w->n[at], 0, (size_t)plan->work.n_nodes * sizeof *w->n[at]);
    for (int64_t c = 0; c < pl_view_cells(&plan->work); c++) {
        const int32_t root = w->tangled[at][c] ? patch_of(w, c) : -1;
        if (root >= 0)
            w->n[at][root]++;
    }
}

/** Set x to the mesh with the patches that return; is_final: what that does is known. Returns the
 *  number of their nodes. */
static int64_t put_back(const patches *w, int is_final, double *x) {
    const planish_plan *plan = w->t->run->plan;
    const int dim = plan->dim;
    int64_t n = 0;
    memcpy(x, w->now, w->bytes);
    for (int32_t i = 0; i < plan->work.n_nodes; i++) {
        const int32_t root = w->ring[i] > 0 ? pl_class_of(w->parent, i) : -1;
        if (root < 0 || w->n[AFTER][root] == 0 || w->n[AFTER][root] < w->n[BEFORE][root] ||
            (is_final && w->n[TRIAL][root] > w->n[AFTER][root]))
            continue;
        memcpy(x + (int64_t)i * dim, w->start + (int64_t)i * dim, (size_t)dim * sizeof *x);
        n++;
    }
    return n;
}

/** Return patches with so many rings; how many nodes return. */
static int64_t return_patches(patches *w, int32_t rings) {
    double *x = w->t->before;
    mark_patches(w, rings);
    join_patches(w);
    count_tangled(w, BEFORE);
    count_tangled(w, AFTER);
    if (put_back(w, 0, x) == 0)
        return 0;
    place(w, w->now, AFTER);
    const double inverted = w->t->run->sums.inverted;
    place(w, x, TRIAL);
    count_tangled(w, TRIAL);
    const int64_t n = put_back(w, 1, x);
    place(w, x, TRIAL);
    if (w->t->run->sums.inverted > inverted)
        return 0;
    memcpy(w->now, x, w->bytes);
    memcpy(w->tangled[AFTER], w->tangled[TRIAL],
           (size_t)pl_view_cells(&w->t->run->plan->work) * sizeof *w->tangled[AFTER]);
    return n;
}

void pl_tangle_return(pl_tangle *t) {
    static const int32_t rings[] = {0, 1, 2, 4, 8, 16, PL_ALL_RINGS};
    const planish_plan *plan = t->run->plan;
    const int64_t n = plan->work.n_nodes, m = pl_view_cells(&plan->work);
    if (pl_part_here())
        return;
    double *x = pl_alloc(2 * n * plan->dim, sizeof *x);
    uint8_t *tangled = pl_alloc(PLACES * m, sizeof *tangled);
    int32_t *of_nodes = pl_alloc((2 + PLACES) * n, sizeof *of_nodes);
    if (x && tangled && of_nodes) {
        patches w = {.t = t,
                     .bytes = (size_t)n * (size_t)plan->dim * sizeof *x,
                     .start = x,
                     .now = x + n * plan->dim,
                     .tangled = {tangled, tangled + m, tangled + 2 * m},
                     .ring = of_nodes,
                     .parent = of_nodes + n,
                     .n = {of_nodes + 2 * n, of_nodes + 3 * n, of_nodes + 4 * n}};
        int64_t n_back = 0;
        memcpy(w.now, plan->scratch.coordinates, w.bytes);
        pl_plan_order(plan, t->run->given, w.start);
        place(&w, w.start, BEFORE);
        place(&w, w.now, AFTER);
        for (size_t i = 0; i < sizeof rings / sizeof *rings; i++)
            n_back += return_patches(&w, rings[i]);
        place(&w, w.now, AFTER);
        if (n_back > 0)
            pl_log(PLANISH_LOG_DETAIL, "%" PRId64 " nodes return, where untangling failed", n_back);
    }
    pl_free(x);
    pl_free(tangled);
    pl_free(of_nodes);
}
