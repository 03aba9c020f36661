/* gaps: facets that come near to others across a gap.
 *
 * Elements between two sheets of a surface keep them apart: they stay positive. Across a gap nothing
 * does. Where two sheets are nearer than both may move they are to be held.
 *
 * If all tolerances are the same this is proved: a point where a moved facet meets another one is within
 * a tolerance of a place on the first surface for either, so that these two places are nearer than both
 * together, and the facets there are held. Left are facets that slide to where tolerances are smaller, and
 * borders that pass one another in one plane: a surface alone looks for these in the end
 * (surface/crossings.c).
 */
#include "shape/gaps.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "shape/nearest.h"
#include "shape/tree.h"

enum { CHUNK = 256 };

/* Sheets face one another if the way between them makes less than 60 degrees with both normals. In
 * one sheet, or at a crease, it runs along the facets. */
#define FACING 0.5

/* Above the length of a normal that is kept in floats, and the rounding of what is along it. */
#define MORE 1.001

typedef struct gap_search {
    const planish_shape *shape;
    const float *tolerance;   /* [n_facets] */
    const uint8_t *may_leave; /* [n_facets]; NULL: all may */
    int is_open;
    int64_t n_leaving;
    int32_t *leaving; /* [n_leaving] those that may leave */
    pl_box3 *box;     /* [n_leaving] of each with its tolerance */
    pl_tree tree;     /* of these */
    int32_t *shared;  /* by boxes of tree, from the branches on: node of all facets below, or -1 */
    uint8_t *is_near;
} gap_search;

/** A search from one facet. */
typedef struct look {
    const gap_search *search;
    int32_t facet;
} look;

static void corners_of(const planish_shape *s, int32_t facet, const double *x[3]) {
    for (int k = 0; k < 3; k++)
        x[k] = s->x[s->facet[facet][k]];
}

/** How far a facet may come off its triangle: by its tolerance, and where it is curved. */
static double reach_of(const gap_search *g, int64_t facet) {
    return g->tolerance[facet] + (g->shape->whole ? g->shape->bend[facet] : 0);
}

/** The box of a facet with its tolerance. */
static pl_box3 box_of(const gap_search *g, int32_t facet) {
    const double reach = reach_of(g, facet), *x[3];
    pl_box3 box;
    corners_of(g->shape, facet, x);
    for (int d = 0; d < 3; d++) {
        box.lower[d] = fmin(x[0][d], fmin(x[1][d], x[2][d])) - reach;
        box.upper[d] = fmax(x[0][d], fmax(x[1][d], x[2][d])) + reach;
    }
    return box;
}

static void find_boxes(void *context, int64_t begin, int64_t end, int thread) {
    const gap_search *g = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        g->box[i] = box_of(g, g->leaving[i]);
}

static int share_node(const planish_shape *s, int32_t a, int32_t b) {
    int any = 0;
    for (int i = 0; i < 9; i++)
        any |= s->facet[a][i / 3] == s->facet[b][i % 3];
    return any;
}

/** Whether way, of a square, from facet a to facet b leads across a gap. */
static int is_across(const gap_search *g, int32_t a, int32_t b, const double way[3],
                     double square) {
    double of_a[3], of_b[3];
    pl_kept_normal(g->shape, a, of_a);
    pl_kept_normal(g->shape, b, of_b);
    const double from = pl_dot(3, of_a, way), to = -pl_dot(3, of_b, way);
    const double least = FACING * FACING * square;
    if (square == 0) /* they touch */
        return 1;
    if (g->is_open) /* both sides of a sheet are outside */
        return from * from > least && to * to > least;
    return from > 0 && to > 0 && from * from > least && to * to > least;
}

static int may_leave(const gap_search *g, int32_t facet) {
    return !g->may_leave || g->may_leave[facet];
}

/** Find a node that all facets of a list share; -1: there is none. */
static int32_t shared_by(const planish_shape *s, const int32_t *facet, int n) {
    for (int k = 0; k < 3; k++) {
        const int32_t node = s->facet[facet[0]][k];
        int is_shared = 1;
        for (int i = 1; i < n; i++)
            is_shared &= s->facet[facet[i]][pl_corner_at(s, facet[i], node)] == node;
        if (is_shared)
            return node;
    }
    return -1;
}

/** Find a node that all facets below a branch share, as far as branches below it share the same; or -1. */
static int32_t shared_below(const gap_search *g, int level, int64_t branch) {
    const pl_tree *t = &g->tree;
    const int64_t from = branch * PL_BRANCHES, left = t->begin[level] - t->begin[level - 1] - from;
    const int n = left < PL_BRANCHES ? (int)left : PL_BRANCHES;
    int32_t list[PL_BRANCHES] = {0};
    if (level == 1) {
        for (int k = 0; k < n; k++)
            list[k] = g->leaving[t->item[from + k]];
        return shared_by(g->shape, list, n);
    }
    const int32_t *below = g->shared + t->begin[level - 1] + from - t->n;
    for (int k = 1; k < n; k++)
        if (below[k] != below[0])
            return -1;
    return below[0];
}

/** Find the nodes that the facets below branches share. Without them each facet of a fan would look at all
 *  the others. */
static void find_shared(const gap_search *g) {
    const pl_tree *t = &g->tree;
    for (int level = 1; level < t->n_levels; level++)
        for (int64_t i = 0; i < t->begin[level + 1] - t->begin[level]; i++)
            g->shared[t->begin[level] + i - t->n] = shared_below(g, level, i);
}

/** Whether the facets below a branch all share a node with that of a search. */
static int is_around(void *context, int64_t index) {
    const look *l = context;
    const int32_t node = l->search->shared[index - l->search->tree.n];
    const int32_t *v = l->search->shape->facet[l->facet];
    return node >= 0 && (node == v[0] || node == v[1] || node == v[2]);
}

/** Find where the corners of a triangle x are along an axis through a point. */
static void find_span(const double axis[3], const double *point, const double *const x[3],
                      double span[2]) {
    span[0] = INFINITY;
    span[1] = -INFINITY;
    for (int k = 0; k < 3; k++) {
        double way[3];
        pl_from_to(3, point, x[k], way);
        const double at = pl_dot(3, axis, way);
        span[0] = fmin(span[0], at);
        span[1] = fmax(span[1], at);
    }
}

/** Whether triangles a and b are farther apart than most along the normal of a facet. This is all that
 *  most pairs of facets of two fans take. */
static int are_apart(const gap_search *g, int32_t facet, const double *const a[3],
                     const double *const b[3], double most) {
    double axis[3], of_a[2], of_b[2];
    pl_kept_normal(g->shape, facet, axis);
    find_span(axis, a[0], a, of_a);
    find_span(axis, a[0], b, of_b);
    return fmax(of_a[0] - of_b[1], of_b[0] - of_a[1]) > most * MORE;
}

static int look_at_facet(void *context, int32_t item) {
    const look *l = context;
    const gap_search *g = l->search;
    const int32_t other = g->leaving[item];
    const planish_shape *s = g->shape;
    const double most = reach_of(g, l->facet) + reach_of(g, other);
    const double *a[3], *b[3];
    double way[3];
    const int is_seen = other == l->facet || (other < l->facet && may_leave(g, l->facet));
    if (is_seen || share_node(s, l->facet, other))
        return 0;
    corners_of(s, l->facet, a);
    corners_of(s, other, b);
    if (are_apart(g, l->facet, a, b, most) || are_apart(g, other, a, b, most))
        return 0;
    const double square = pl_nearest_triangles(a, b, way);
    if (!(square <= most * most) || !is_across(g, l->facet, other, way, square))
        return 0;
    pl_set_flag(&g->is_near[l->facet], 1);
    pl_set_flag(&g->is_near[other], 1);
    return 0;
}

static void search_chunk(void *context, int64_t begin, int64_t end, int thread) {
    gap_search *g = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        look l = {g, (int32_t)i};
        if (g->shape->is_interface[i])
            continue;
        const pl_box3 box = box_of(g, l.facet);
        pl_tree_find(&g->tree, &box, is_around, look_at_facet, &l);
    }
}

/** List the facets that may leave; 0 without memory. */
static int list_leaving(gap_search *g) {
    const int64_t n = g->shape->n_facets;
    g->leaving = pl_alloc(n, sizeof *g->leaving);
    for (int32_t i = 0; g->leaving && i < n; i++)
        if (may_leave(g, i) && !g->shape->is_interface[i])
            g->leaving[g->n_leaving++] = i;
    g->box = pl_alloc(g->n_leaving, sizeof *g->box);
    return g->leaving && g->box;
}

int pl_shape_find_gaps(const planish_shape *shape, const float *tolerance, const uint8_t *may_leave,
                       int is_open, int threads, uint8_t *is_near, planish_error *error) {
    const int64_t n = shape->n_facets;
    gap_search g = {.shape = shape,
                    .tolerance = tolerance,
                    .may_leave = may_leave,
                    .is_open = is_open,
                    .is_near = is_near};
    int status = list_leaving(&g) ? 0 : pl_fail_memory(error, "the gaps of a surface");
    if (!status) {
        pl_parallel_for(threads, g.n_leaving, CHUNK, find_boxes, &g);
        status = pl_tree_create(g.n_leaving, g.box, threads, &g.tree, error);
    }
    if (!status) {
        g.shared = pl_alloc(g.tree.begin[g.tree.n_levels] - g.tree.n, sizeof *g.shared);
        status = g.shared ? 0 : pl_fail_memory(error, "the gaps of a surface");
    }
    if (!status)
        find_shared(&g);
    for (int64_t i = 0; !status && i < n; i++)
        is_near[i] = 0;
    if (!status)
        pl_parallel_for(threads, n, CHUNK, search_chunk, &g);
    pl_tree_destroy(&g.tree);
    pl_free(g.shared);
    pl_free(g.leaving);
    pl_free(g.box);
    return status;
}
