/* return: nodes that were moved for nothing go back to where they were.
 *
 * After the ladder some elements may still be tangled, and what is around them far worse than it
 * was. A patch is such elements, those that were tangled at first, and some rings around: where it
 * has as many tangled elements as before, its nodes return, unless that tangles more with the
 * neighbours as they are now; then more rings are tried. With all rings that cannot be.
 * In: the mesh after the ladder; out: with some nodes where they were. Whole meshes only.
 */
#include "improve/untangle/tangle.h"

#include "base/context.h"
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
    uint8_t *tangled[PLACES]; /* [n_elements] 1: is tangled there */
    int32_t *ring;            /* [n_nodes] 0: in no patch, else the ring in which it was marked */
    int32_t *parent;          /* [n_nodes] of a union-find structure over nodes of patches */
    int32_t *n[PLACES];       /* [n_nodes] tangled elements there, at roots */
} patches;

/** Move the nodes to x, and find what is tangled there. */
static void place(patches *w, const double *x, int at) {
    const planish_plan *plan = w->t->run->plan;
    memcpy(plan->scratch.coordinates, x, w->bytes);
    pl_run_measure(w->t->run);
    pl_tangle_find(w->t);
    for (int64_t i = 0; i < plan->work.n_elements; i++)
        w->tangled[at][i] = w->t->state[i] == PL_TANGLED;
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
        for (int64_t i = 0; i < plan->work.n_elements; i++) {
            int is_near = ring == 1 && (w->tangled[BEFORE][i] || w->tangled[AFTER][i]);
            for (int j = 0; ring > 1 && j <= plan->dim; j++) {
                const int32_t k = w->ring[pl_plan_inner(plan, i, j)];
                is_near |= k > 0 && k < ring;
            }
            for (int j = 0; is_near && j <= plan->dim; j++) {
                const int32_t node = pl_plan_inner(plan, i, j);
                if (w->ring[node] == 0 && has_moved(w, node))
                    w->ring[node] = ring;
            }
        }
}

/** Return the patch of an element; -1: none. */
static int32_t patch_of(const patches *w, int64_t element) {
    const planish_plan *plan = w->t->run->plan;
    for (int j = 0; j <= plan->dim; j++)
        if (w->ring[pl_plan_inner(plan, element, j)] > 0)
            return pl_root_of(w->parent, pl_plan_inner(plan, element, j));
    return -1;
}

static void join_patches(patches *w) {
    const planish_plan *plan = w->t->run->plan;
    for (int32_t i = 0; i < plan->work.n_nodes; i++)
        w->parent[i] = i;
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        int32_t root = patch_of(w, i);
        for (int j = 0; j <= plan->dim && root >= 0; j++)
            if (w->ring[pl_plan_inner(plan, i, j)] > 0)
                root = pl_join(w->parent, root, pl_plan_inner(plan, i, j));
    }
}

/** Count the tangled elements of each patch. */
static void count_tangled(const patches *w, int at) {
    const planish_plan *plan = w->t->run->plan;
    memset(w->n[at], 0, (size_t)plan->work.n_nodes * sizeof *w->n[at]);
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        const int32_t root = w->tangled[at][i] ? patch_of(w, i) : -1;
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
        const int32_t root = w->ring[i] > 0 ? pl_root_of(w->parent, i) : -1;
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
    memcpy(w->tangled[AFTER], w->tangled[TRIAL], (size_t)w->t->run->plan->work.n_elements);
    return n;
}

void pl_tangle_return(pl_tangle *t) {
    static const int32_t rings[] = {0, 1, 2, 4, 8, 16, PL_ALL_RINGS};
    const planish_plan *plan = t->run->plan;
    const int64_t n = plan->work.n_nodes, m = plan->work.n_elements;
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
