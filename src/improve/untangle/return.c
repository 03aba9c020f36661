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

/** The work; nodes by inner numbers. Arrays are owned. */
typedef struct work {
    pl_tangle *t;
    double *start, *now; /* [n_nodes][dim] */
    uint8_t *before;     /* [n_elements] 1: was tangled, */
    uint8_t *after;      /* is, */
    uint8_t *trial;      /* or would be */
    int32_t *ring;       /* [n_nodes] 0: in no patch, else the ring in which it was marked */
    int32_t *parent;     /* [n_nodes] of a union-find structure over nodes of patches */
    int32_t *n_before, *n_after, *n_trial; /* [n_nodes] tangled elements, at roots */
} work;

static size_t bytes_of(const work *w) {
    const planish_plan *plan = w->t->run->plan;
    return (size_t)plan->work.n_nodes * (size_t)plan->dim * sizeof(double);
}

static void look_at(work *w, const double *x, uint8_t *tangled) {
    const planish_plan *plan = w->t->run->plan;
    memcpy(plan->coordinates, x, bytes_of(w));
    pl_run_measure(w->t->run);
    pl_tangle_find(w->t);
    for (int64_t i = 0; i < plan->work.n_elements; i++)
        tangled[i] = w->t->state[i] == PL_TANGLED;
}

static int32_t inner(const planish_plan *plan, int64_t element, int j) {
    return plan->inner[plan->work.elements[element * (plan->dim + 1) + j]];
}

static int has_moved(const work *w, int32_t node) {
    const int dim = w->t->run->plan->dim;
    return memcmp(w->start + (int64_t)node * dim, w->now + (int64_t)node * dim,
                  (size_t)dim * sizeof *w->now) != 0;
}

/** Whether an element is in the patches, as far as their rings below ring go. */
static int is_near(const work *w, int64_t element, int32_t ring) {
    const planish_plan *plan = w->t->run->plan;
    int any = 0;
    for (int j = 0; j <= plan->dim && !any; j++) {
        const int32_t k = w->ring[inner(plan, element, j)];
        any = k > 0 && k < ring;
    }
    return any;
}

/** Mark the nodes that have moved of elements that are or were tangled, and of rings around. */
static void mark_patches(work *w, int32_t rings) {
    const planish_plan *plan = w->t->run->plan;
    memset(w->ring, 0, (size_t)plan->work.n_nodes * sizeof *w->ring);
    for (int32_t i = 0; rings == PL_ALL_RINGS && i < plan->work.n_nodes; i++)
        w->ring[i] = has_moved(w, i);
    for (int32_t ring = 1; rings < PL_ALL_RINGS && ring <= rings + 1; ring++)
        for (int64_t i = 0; i < plan->work.n_elements; i++) {
            if (ring == 1 ? !(w->before[i] || w->after[i]) : !is_near(w, i, ring))
                continue;
            for (int j = 0; j <= plan->dim; j++) {
                const int32_t node = inner(plan, i, j);
                if (w->ring[node] == 0 && has_moved(w, node))
                    w->ring[node] = ring;
            }
        }
}

static int32_t root_of(const work *w, int32_t node) {
    while (w->parent[node] != node) {
        w->parent[node] = w->parent[w->parent[node]];
        node = w->parent[node];
    }
    return node;
}

/** The patch of an element; -1: none. */
static int32_t patch_of(const work *w, int64_t element) {
    const planish_plan *plan = w->t->run->plan;
    for (int j = 0; j <= plan->dim; j++)
        if (w->ring[inner(plan, element, j)] > 0)
            return root_of(w, inner(plan, element, j));
    return -1;
}

static void join_patches(work *w) {
    const planish_plan *plan = w->t->run->plan;
    for (int32_t i = 0; i < plan->work.n_nodes; i++)
        w->parent[i] = i;
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        int32_t root = patch_of(w, i);
        for (int j = 0; j <= plan->dim && root >= 0; j++) {
            if (w->ring[inner(plan, i, j)] == 0)
                continue;
            const int32_t other = root_of(w, inner(plan, i, j));
            const int32_t low = root < other ? root : other;
            w->parent[root] = w->parent[other] = low;
            root = low;
        }
    }
}

static void count(const work *w, const uint8_t *tangled, int32_t *n) {
    const planish_plan *plan = w->t->run->plan;
    memset(n, 0, (size_t)plan->work.n_nodes * sizeof *n);
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        const int32_t root = tangled[i] ? patch_of(w, i) : -1;
        if (root >= 0)
            n[root]++;
    }
}

/** Whether the nodes of a patch are to return; is_final: and it is known what that does. */
static int returns(const work *w, int32_t root, int is_final) {
    return w->n_after[root] > 0 && w->n_after[root] >= w->n_before[root] &&
           (!is_final || w->n_trial[root] <= w->n_after[root]);
}

/** The mesh with the patches that return, in x; how many nodes these have. */
static int64_t put_back(const work *w, int is_final, double *x) {
    const planish_plan *plan = w->t->run->plan;
    const int dim = plan->dim;
    int64_t n = 0;
    for (int32_t i = 0; i < plan->work.n_nodes; i++) {
        if (w->ring[i] == 0 || !returns(w, root_of(w, i), is_final))
            continue;
        memcpy(x + (int64_t)i * dim, w->start + (int64_t)i * dim, (size_t)dim * sizeof *x);
        n++;
    }
    return n;
}

/** Patches with so many rings; how many nodes return. */
static int64_t return_patches(work *w, int32_t rings) {
    double *x = w->t->best;
    mark_patches(w, rings);
    join_patches(w);
    count(w, w->before, w->n_before);
    count(w, w->after, w->n_after);
    memcpy(x, w->now, bytes_of(w));
    if (put_back(w, 0, x) == 0)
        return 0;
    look_at(w, w->now, w->after);
    const int64_t inverted = pl_run_inverted(w->t->run);
    look_at(w, x, w->trial);
    count(w, w->trial, w->n_trial);
    memcpy(x, w->now, bytes_of(w));
    const int64_t n = put_back(w, 1, x);
    look_at(w, x, w->trial);
    if (pl_run_inverted(w->t->run) > inverted)
        return 0;
    memcpy(w->now, x, bytes_of(w));
    memcpy(w->after, w->trial, (size_t)w->t->run->plan->work.n_elements);
    return n;
}

static void return_all(work *w) {
    static const int32_t rings[] = {0, 1, 2, 4, 8, 16, PL_ALL_RINGS};
    pl_run *r = w->t->run;
    int64_t n = 0;
    memcpy(w->now, r->plan->coordinates, bytes_of(w));
    pl_plan_order(r->plan, r->outside, w->start);
    look_at(w, w->start, w->before);
    look_at(w, w->now, w->after);
    for (size_t i = 0; i < sizeof rings / sizeof *rings; i++)
        n += return_patches(w, rings[i]);
    look_at(w, w->now, w->after);
    memcpy(w->t->best, w->now, bytes_of(w));
    if (n > 0)
        pl_log(PLANISH_LOG_DETAIL, "%" PRId64 " nodes return, where untangling was in vain", n);
}

void pl_tangle_return(pl_tangle *t) {
    const planish_plan *plan = t->run->plan;
    const int64_t n = plan->work.n_nodes, m = plan->work.n_elements;
    work w = {.t = t};
    if (pl_part_here())
        return;
    w.start = pl_alloc(n * plan->dim, sizeof *w.start);
    w.now = pl_alloc(n * plan->dim, sizeof *w.now);
    w.before = pl_alloc(m, 1);
    w.after = pl_alloc(m, 1);
    w.trial = pl_alloc(m, 1);
    w.ring = pl_alloc(n, sizeof *w.ring);
    w.parent = pl_alloc(n, sizeof *w.parent);
    w.n_before = pl_alloc(n, sizeof *w.n_before);
    w.n_after = pl_alloc(n, sizeof *w.n_after);
    w.n_trial = pl_alloc(n, sizeof *w.n_trial);
    if (w.start && w.now && w.before && w.after && w.trial && w.ring && w.parent && w.n_before &&
        w.n_after && w.n_trial)
        return_all(&w);
    pl_free(w.start);
    pl_free(w.now);
    pl_free(w.before);
    pl_free(w.after);
    pl_free(w.trial);
    pl_free(w.ring);
    pl_free(w.parent);
    pl_free(w.n_before);
    pl_free(w.n_after);
    pl_free(w.n_trial);
}
