/* tree: boxes in boxes. */
#include "shape/tree.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "topology/topology.h"

#include <math.h>

enum { CHUNK = 1024 };

/** Tree that is being made. */
typedef struct growth {
    pl_tree *tree;
    const pl_box3 *given;
    double (*middle)[3];
    int level;
} growth;

static void find_middles(void *context, int64_t begin, int64_t end, int thread) {
    const growth *g = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int d = 0; d < 3; d++)
            g->middle[i][d] = g->given[i].lower[d] / 2 + g->given[i].upper[d] / 2;
}

static void copy_boxes(void *context, int64_t begin, int64_t end, int thread) {
    const growth *g = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        g->tree->box[i] = g->given[g->tree->item[i]];
}

static void join_boxes(void *context, int64_t begin, int64_t end, int thread) {
    const growth *g = context;
    const pl_tree *t = g->tree;
    const int64_t first = t->begin[g->level - 1], n = t->begin[g->level] - first;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const pl_box3 *below = t->box + first + i * PL_BRANCHES;
        pl_box3 *b = t->box + t->begin[g->level] + i;
        *b = below[0];
        for (int64_t k = 1; k < PL_BRANCHES && i * PL_BRANCHES + k < n; k++)
            for (int d = 0; d < 3; d++) {
                b->lower[d] = fmin(b->lower[d], below[k].lower[d]);
                b->upper[d] = fmax(b->upper[d], below[k].upper[d]);
            }
    }
}

/** Find where the levels begin; returns how many boxes there are in all. */
static int64_t find_levels(pl_tree *t) {
    int64_t all = 0, n = t->n;
    for (;;) {
        t->begin[t->n_levels++] = all;
        all += n;
        if (n <= 1)
            break;
        n = (n + PL_BRANCHES - 1) / PL_BRANCHES;
    }
    t->begin[t->n_levels] = all;
    return all;
}

int pl_tree_create(int64_t n, const pl_box3 *box, int threads, pl_tree *tree,
                   planish_error *error) {
    growth g = {.tree = tree, .given = box};
    *tree = (pl_tree){.n = n};
    tree->item = pl_alloc(n, sizeof *tree->item);
    tree->box = pl_alloc(find_levels(tree), sizeof *tree->box);
    g.middle = pl_alloc(n, sizeof *g.middle);
    int status = tree->item && tree->box && g.middle
                     ? PLANISH_OK
                     : pl_fail_memory(error, "a tree of the surface");
    if (!status) {
        pl_parallel_for(threads, n, CHUNK, find_middles, &g);
        const planish_mesh middles = {.dim = 3, .n_nodes = n, .coordinates = g.middle[0]};
        status = pl_curve_order(&middles, threads, tree->item, error);
    }
    if (!status) {
        pl_parallel_for(threads, n, CHUNK, copy_boxes, &g);
        for (g.level = 1; g.level < tree->n_levels; g.level++)
            pl_parallel_for(threads, tree->begin[g.level + 1] - tree->begin[g.level], CHUNK,
                            join_boxes, &g);
    }
    pl_free(g.middle);
    if (status)
        pl_tree_destroy(tree);
    return status;
}

void pl_tree_destroy(pl_tree *tree) {
    pl_free(tree->item);
    pl_free(tree->box);
    *tree = (pl_tree){0};
}

/* ---- searches ------------------------------------------------------------------------------- */

/** Branch that is still to be looked at. */
typedef struct branch {
    int level;
    int64_t index; /* in its level */
} branch;

enum { MOST_BRANCHES = PL_TREE_LEVELS * PL_BRANCHES };

/** Push what is below a branch, the last one first. Returns how many branches there are then. */
static int push_below(const pl_tree *t, branch b, branch *stack, int n) {
    const int64_t of_level = t->begin[b.level] - t->begin[b.level - 1];
    const int64_t first = b.index * PL_BRANCHES;
    int64_t last = first + PL_BRANCHES - 1;
    last = last < of_level ? last : of_level - 1;
    for (int64_t i = last; i >= first; i--)
        stack[n++] = (branch){b.level - 1, i};
    return n;
}

static int boxes_meet(const pl_box3 *a, const pl_box3 *b) {
    int meet = 1;
    for (int d = 0; d < 3; d++)
        meet &= a->lower[d] <= b->upper[d] && b->lower[d] <= a->upper[d];
    return meet;
}

/** Push the branches below b that meet box, the last one first. Returns how many branches there are then. */
static int push_meeting(const pl_tree *t, branch b, const pl_box3 *box, branch *stack, int n) {
    branch below[PL_BRANCHES];
    const int count = push_below(t, b, below, 0);
    for (int i = 0; i < count; i++)
        if (boxes_meet(t->box + t->begin[below[i].level] + below[i].index, box))
            stack[n++] = below[i];
    return n;
}

void pl_tree_find(const pl_tree *tree, const pl_box3 *box, pl_tree_skips_fn *skips,
                  pl_tree_found_fn *found, void *context) {
    branch stack[MOST_BRANCHES];
    int n = 0;
    if (tree->n > 0 && boxes_meet(tree->box + tree->begin[tree->n_levels - 1], box))
        stack[n++] = (branch){tree->n_levels - 1, 0};
    while (n > 0) {
        const branch b = stack[--n];
        if (b.level == 0) {
            if (found(context, tree->item[b.index]))
                return;
        } else if (!skips || !skips(context, tree->begin[b.level] + b.index)) {
            n = push_meeting(tree, b, box, stack, n);
        }
    }
}

/** Squared distance of a point from a box. */
static double distance_of_box(const pl_box3 *b, const double *x) {
    double square = 0;
    for (int d = 0; d < 3; d++) {
        const double off = fmax(0, fmax(b->lower[d] - x[d], x[d] - b->upper[d]));
        square += off * off;
    }
    return square;
}

/** Push the branches below b that may have something within square, the nearest last. */
static int push_nearest(const pl_tree *t, branch b, const double *x, double square, branch *stack,
                        int n) {
    double far[PL_BRANCHES];
    branch below[PL_BRANCHES];
    const int count = push_below(t, b, below, 0);
    const int first = n;
    for (int i = 0; i < count; i++) {
        const double off = distance_of_box(t->box + t->begin[below[i].level] + below[i].index, x);
        int at = n;
        if (off > square)
            continue;
        for (; at > first && far[at - first - 1] < off; at--) {
            far[at - first] = far[at - first - 1];
            stack[at] = stack[at - 1];
        }
        far[at - first] = off;
        stack[at] = below[i];
        n++;
    }
    return n;
}

int32_t pl_tree_nearest(const pl_tree *tree, const double point[3], pl_tree_distance_fn *distance,
                        const void *context, double *square) {
    branch stack[MOST_BRANCHES];
    int32_t best = -1;
    int n = 0;
    if (tree->n > 0)
        stack[n++] = (branch){tree->n_levels - 1, 0};
    while (n > 0) {
        const branch b = stack[--n];
        if (distance_of_box(tree->box + tree->begin[b.level] + b.index, point) > *square)
            continue;
        if (b.level > 0) {
            n = push_nearest(tree, b, point, *square, stack, n);
            continue;
        }
        const int32_t item = tree->item[b.index];
        const double off = distance(context, item, point);
        if (off < *square || (off == *square && (best < 0 || item < best))) {
            *square = off;
            best = item;
        }
    }
    return best;
}
