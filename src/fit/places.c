/* places: where the nodes of a mesh belong on another shape.
 *
 * A node of a patch belongs where the other shape is nearest and turns the same way as the surface at the
 * node: not on the other side of a thin sheet. A node of a curve belongs on a curve of about its direction
 * with such sides, a corner at a corner of such facets; where the other shape has none in reach they belong on a patch, too, and stay
 * there: what they bound is not to be lost.
 *
 * The facets of a file may turn any way. Closed pieces of the other shape that are in one another have bodies and hollows
 * inside by turns, so all turn into the mesh or none; so do those by themselves, and other pieces each by itself: as
 * nodes near them then have the shorter ways. */
#include "fit/places.h"

#include "base/joined.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "fit/hollows.h"
#include "fit/partners.h"
#include "fit/pieces.h"
#include "fit/sides.h"
#include "shape/nearest.h"
#include "shape/pn.h"
#include "shape/walk.h"

#include <string.h>

enum { CHUNK = 64, TRIALS = 32 };

/* Facets of a place turn as the surface at the node: cosine of the angle at most between them. */
#define ALIKE 0.2
/* A feature of the mesh that is none on the other shape lies on a patch that turns as the mean of its sides. */
#define SAME 0.95
/* A curve is right within so many edges, and so many times as far as such a patch. */
#define CURVE_EDGES   0.1
#define CURVE_PATCHES 1.5
/* Curves go as an edge of the node does, either way: cosine. */
#define ALONG 0.5
/* A corner is for nodes within so many of their mean edges, and so many times as far as curves along their own. */
#define CORNER_EDGES  0.25
#define CORNER_CURVES 2
/* If ways are shorter by this factor that decides which way a group turns, by itself. */
#define CLEAR 3
/* Ways that decide it are sought so many times as far as places. */
#define WIDER 3
/* What is off a place by no more than this is there, in edges of the node. */
#define NEAR 0x1p-30
/* Steps of a storage are sought from here on, in sizes of the other shape. */
#define LEAST_STEP 0x1p-44

/** A search for a place on the other shape. */
typedef struct search {
    const planish_fit *fit;
    const double *normal; /* of unit length; NULL: any */
    double alike;         /* cosine of the angle at most between that and a facet's */
    int32_t patch;        /* -1: any */
    int sign;             /* if not 0: pieces of a group turn so */
    int32_t group;
    int32_t own; /* as pl_fit_may_use; 0: any piece */
    int n_ways;  /* unit directions of edges at a node on a curve or corner */
    const double (*way)[3];
    const pl_fit_sides *sides; /* of these edges; or of a corner */
} search;

/** Return the group of a facet of the outside, of pieces that turn together. Closed pieces by themselves are group 0;
 *  those in one another are a group, and others are groups by themselves. */
static int32_t group_of(const planish_fit *fit, int32_t facet) {
    const pl_fit_pieces *pieces = &fit->pieces;
    const int32_t piece = pieces->of[facet];
    return (pieces->is_closed[piece] ? pieces->nest[piece] : piece) + 1;
}

/** Return which way a facet of the outside turns in a search. */
static int turn_of(const search *s, int32_t facet) {
    const planish_fit *fit = s->fit;
    return s->sign ? s->sign * fit->pieces.turn[fit->pieces.of[facet]]
                   : fit->turn[fit->onto->patch[facet]];
}

static double square_of_facet(const void *context, int32_t facet, const double point[3]) {
    const search *s = context;
    const planish_shape *onto = s->fit->onto;
    const int32_t *node = onto->facet[facet], patch = onto->patch[facet];
    const double *const x[3] = {onto->x[node[0]], onto->x[node[1]], onto->x[node[2]]};
    double weight[3] = {1, 0, 0}, normal[3];
    pl_kept_normal(onto, facet, normal);
    if (onto->is_interface[facet] || (s->patch >= 0 && patch != s->patch) ||
        !pl_fit_may_use(s->fit, s->own, s->fit->pieces.of[facet]) ||
        (s->sign && group_of(s->fit, facet) != s->group) ||
        (s->normal && !(turn_of(s, facet) * pl_dot(3, s->normal, normal) >= s->alike)))
        return INFINITY;
    return pl_nearest_on_triangle(point, x, weight);
}

/** Whether a search is for the piece of one of some facets. */
static int is_for(const search *s, const int32_t *facet, int64_t n) {
    int any = s->own == 0;
    for (int64_t i = 0; i < n && !any; i++)
        any = facet[i] >= 0 && s->fit->pieces.of[facet[i]] >= 0 &&
              pl_fit_may_use(s->fit, s->own, s->fit->pieces.of[facet[i]]);
    return any;
}

static double square_of_edge(const void *context, int32_t edge, const double point[3]) {
    const search *s = context;
    const planish_shape *onto = s->fit->onto;
    const double *a = onto->x[onto->edge[edge][0]], *b = onto->x[onto->edge[edge][1]];
    double along[3], weight[2] = {1, 0};
    pl_fit_sides sides;
    int is_known = 0, is_alike = 0;
    pl_from_to(3, a, b, along);
    const double length = pl_length(along);
    for (int i = 0; i < s->n_ways && !is_alike; i++) {
        if (!(fabs(pl_dot(3, along, s->way[i])) >= ALONG * length))
            continue;
        if (!is_known)
            pl_fit_look_at_edge(onto, s->fit->turn, edge, &sides);
        is_known = 1;
        is_alike = pl_fit_are_alike(&s->sides[i], &sides, ALIKE);
    }
    return is_alike && is_for(s, onto->edge_facet[edge], 2)
               ? pl_nearest_on_edge(point, a, b, weight)
               : INFINITY;
}

static double square_of_corner(const void *context, int32_t node, const double point[3]) {
    const search *s = context;
    const planish_shape *onto = s->fit->onto;
    pl_fit_sides sides;
    double way[3];
    if (onto->node_class[node] != PL_CORNER ||
        !is_for(s, onto->facet_of + onto->offset[node],
                (int64_t)onto->offset[node + 1] - onto->offset[node]))
        return INFINITY;
    if (s->sides) {
        pl_fit_look_at_node(onto, s->fit->turn, node, &sides);
        if (!pl_fit_are_alike(s->sides, &sides, ALIKE))
            return INFINITY;
    }
    pl_from_to(3, onto->x[node], point, way);
    return pl_dot(3, way, way);
}

/* ---- trees ----------------------------------------------------------------------------------- */

/** Widen a box to hold x. */
static void widen(pl_box3 *box, const double x[3]) {
    for (int d = 0; d < 3; d++) {
        box->lower[d] = fmin(box->lower[d], x[d]);
        box->upper[d] = fmax(box->upper[d], x[d]);
    }
}

/** Plant the tree of n items of n_nodes nodes each. Errors: _MEMORY. */
static int plant(const planish_fit *fit, const int32_t *node, int64_t n, int n_nodes, pl_tree *tree,
                 planish_error *error) {
    pl_box3 *box = pl_alloc(n, sizeof *box);
    if (!box)
        return pl_fail_memory(error, "the places of a fit");
    for (int64_t i = 0; i < n; i++) {
        box[i] = (pl_box3){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
        for (int k = 0; k < n_nodes; k++)
            widen(&box[i], fit->onto->x[node ? node[i * n_nodes + k] : i]);
    }
    const int status = pl_tree_create(n, box, fit->threads, tree, error);
    pl_free(box);
    return status;
}

/** Return the item of a tree nearest to x within *square; -1: there is none. An empty tree has no root. */
static int32_t nearest(const pl_tree *tree, const double x[3], pl_tree_distance_fn *distance,
                       const search *s, double *square) {
    return tree->n > 0 ? pl_tree_nearest(tree, x, distance, s, square) : -1;
}

/* ---- the surface at a node ------------------------------------------------------------------- */

/** Compute the unit normal of the boundary at a node; 0: it has none. */
static int normal_at(const planish_shape *own, int32_t node, double normal[3]) {
    double sum[3] = {0, 0, 0}, of_facet[3];
    for (int64_t i = own->offset[node]; i < own->offset[node + 1]; i++) {
        pl_kept_normal(own, own->facet_of[i], of_facet);
        for (int d = 0; d < 3 && pl_fit_is_outer(own, own->facet_of[i]); d++)
            sum[d] += of_facet[d];
    }
    return pl_unit(3, sum, normal);
}

/** Features of the mesh's own surface by node. */
typedef struct features {
    int64_t *offset; /* [n_nodes + 1] */
    int32_t *edge;
    int32_t *chain;  /* [n_edges] the first one of its curve */
    int32_t *length; /* [n_edges] edges of that curve, at its first one */
} features;

/** Find how many edges each curve has. */
static void find_chains(const planish_shape *own, features *f) {
    for (int32_t e = 0; e < own->n_edges; e++) {
        f->chain[e] = e;
        f->length[e] = 0;
    }
    for (int64_t i = 0; i < own->n_nodes; i++)
        if (own->node_class[i] == PL_ON_CURVE)
            pl_join(f->chain, own->edge_at[i][0], own->edge_at[i][1]);
    for (int32_t e = 0; e < own->n_edges; e++)
        f->length[f->chain[e] = pl_class_of(f->chain, e)]++;
}

static int list_features(const planish_shape *own, features *f) {
    f->offset = pl_alloc_zero(own->n_nodes + 2, sizeof *f->offset);
    f->edge = pl_alloc(2 * own->n_edges, sizeof *f->edge);
    f->chain = pl_alloc(own->n_edges, sizeof *f->chain);
    f->length = pl_alloc(own->n_edges, sizeof *f->length);
    if (!f->offset || !f->edge || !f->chain || !f->length)
        return 0;
    for (int64_t e = 0; e < own->n_edges; e++)
        for (int k = 0; k < 2; k++)
            f->offset[own->edge[e][k] + 2]++;
    for (int64_t i = 2; i < own->n_nodes + 2; i++)
        f->offset[i] += f->offset[i - 1];
    for (int64_t e = 0; e < own->n_edges; e++)
        for (int k = 0; k < 2; k++)
            f->edge[f->offset[own->edge[e][k] + 1]++] = (int32_t)e;
    find_chains(own, f);
    return 1;
}

static void free_features(features *f) {
    pl_free(f->offset);
    pl_free(f->edge);
    pl_free(f->chain);
    pl_free(f->length);
}

enum { MOST_WAYS = 8 };

/** Some features at a node. */
typedef struct features_at {
    int n;
    double way[MOST_WAYS][3]; /* of unit length */
    pl_fit_sides sides[MOST_WAYS];
} features_at;

/** Look at the features at a node. */
static void look_at_features(const planish_shape *own, const features *f, int32_t node,
                             features_at *at) {
    at->n = 0;
    for (int64_t i = f->offset[node]; i < f->offset[node + 1] && at->n < MOST_WAYS; i++) {
        const int32_t *end = own->edge[f->edge[i]];
        double along[3];
        pl_from_to(3, own->x[end[0]], own->x[end[1]], along);
        if (!pl_unit(3, along, at->way[at->n]))
            continue;
        pl_fit_look_at_edge(own, NULL, f->edge[i], &at->sides[at->n]);
        at->n++;
    }
}

/* ---- places ---------------------------------------------------------------------------------- */

typedef struct finding {
    planish_fit *fit;
    const pl_points *points;
    features features;
    int32_t *near;     /* [n_nodes] facet, or -1; then the corner that a node asks for */
    double *square;    /* [n_nodes] of the distance of that corner */
    double (*ways)[2]; /* [n_nodes] squares: if facets turn as they are to, or against that */
} finding;

/** Set x to a node, in onto's unit, and return the square of its reach. */
static double reach_of(const finding *g, int32_t node, double x[3]) {
    const planish_fit *fit = g->fit;
    const double reach = fit->reach * fit->own->edge_length[node] / fit->to_own;
    pl_fit_at(g->points, fit->own->node[node], fit->onto->scale, x);
    return reach * reach;
}

/** Return the square of how far a curve or corner may be from a node: curves of few edges, which may be none, reach
 *  for near ones alone. */
static double reach_of_features(const finding *g, int32_t node, double x[3]) {
    const planish_fit *fit = g->fit;
    double longest = 0;
    const double square = reach_of(g, node, x);
    for (int64_t i = g->features.offset[node]; i < g->features.offset[node + 1]; i++)
        longest = fmax(longest, g->features.length[g->features.chain[g->features.edge[i]]]);
    const double part = fmin(1, longest / 2 / fit->reach);
    return square * part * part;
}

/** Find the facet that is nearest to each node, whichever way it turns, and the squares of the ways of the node if the
 *  facet's group turns as its pieces are to, or against that. */
static void look_for_turns(void *context, int64_t begin, int64_t end, int thread) {
    finding *g = context;
    const planish_fit *fit = g->fit;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        search s = {.fit = fit, .patch = -1};
        double x[3], normal[3], square = reach_of(g, (int32_t)i, x);
        const double most = WIDER * WIDER * square;
        const int is_asked =
            fit->state[i] != PL_FIT_INSIDE && normal_at(fit->own, (int32_t)i, normal);
        g->near[i] = is_asked ? nearest(&fit->facets, x, square_of_facet, &s, &square) : -1;
        if (g->near[i] < 0)
            continue;
        s = (search){.fit = fit,
                     .patch = -1,
                     .normal = normal,
                     .alike = ALIKE,
                     .group = group_of(fit, g->near[i])};
        for (int against = 0; against < 2; against++) {
            g->ways[i][against] = most;
            s.sign = against ? -1 : 1;
            nearest(&fit->facets, x, square_of_facet, &s, &g->ways[i][against]);
        }
    }
}

/** Decide which way the patches turn. sum [groups][2]: room of zeros. */
static void find_turns(const finding *g, double (*sum)[2]) {
    planish_fit *fit = g->fit;
    const pl_fit_pieces *pieces = &fit->pieces;
    double all[2][2] = {{0}}; /* of open pieces, and of closed ones */
    for (int32_t i = 0; i < fit->n_nodes; i++) {
        const int32_t near = g->near[i];
        const double edge = fit->own->edge_length[i] / fit->to_own;
        for (int k = 0; k < 2 && near >= 0; k++) {
            sum[group_of(fit, near)][k] += edge * edge * g->ways[i][k];
            all[pieces->is_closed[pieces->of[near]]][k] += edge * edge * g->ways[i][k];
        }
    }
    for (int32_t f = 0; f < fit->onto->n_facets; f++) {
        const int32_t piece = pieces->of[f];
        if (piece < 0)
            continue;
        const int32_t group = group_of(fit, f);
        const double *of = sum[group], *other = all[pieces->is_closed[piece]];
        const int is_clear = group == 0 || fmax(of[0], of[1]) > CLEAR * fmin(of[0], of[1]);
        const int is_against = is_clear ? of[1] < of[0] : other[1] < other[0];
        fit->turn[fit->onto->patch[f]] = (int8_t)(pieces->turn[piece] * (is_against ? -1 : 1));
    }
}

/** Return the largest distance of a node from the nearest curve along an edge of its own: each of these is to move on
 *  to the corner. Edges along which no curve is in reach do not count; infinite: none is along any. */
static double off_curves(const finding *g, int32_t node) {
    const planish_fit *fit = g->fit;
    double x[3], most = -1;
    features_at own;
    look_at_features(fit->own, &g->features, node, &own);
    for (int i = 0; i < own.n; i++) {
        const search s = {.fit = fit,
                          .patch = -1,
                          .way = (const double(*)[3])own.way + i,
                          .n_ways = 1,
                          .sides = own.sides + i,
                          .own = pl_fit_piece_of(fit, node)};
        double square = reach_of_features(g, node, x);
        if (nearest(&fit->edges, x, square_of_edge, &s, &square) >= 0)
            most = fmax(most, sqrt(square));
    }
    return most < 0 ? INFINITY : most;
}

/** Count the features at a node where the outside bends or ends: not those where regions meet on a plane side. */
static int count_bends(const finding *g, int32_t node) {
    int n = 0;
    for (int64_t i = g->features.offset[node]; i < g->features.offset[node + 1]; i++) {
        pl_fit_sides sides;
        pl_fit_look_at_edge(g->fit->own, NULL, g->features.edge[i], &sides);
        n += sides.n > 1 || sides.is_open;
    }
    return n;
}

/** Return the corner that a corner of the mesh's surface would go to; -1: there is none. Where a coarse curve turns
 *  it has one of its own, which is on the other curve and far from its corners. */
static int32_t find_corner(const finding *g, int32_t node, double *square) {
    const planish_fit *fit = g->fit;
    const search any = {.fit = fit};
    pl_fit_sides sides;
    const search alike = {.fit = fit, .sides = &sides, .own = pl_fit_piece_of(fit, node)};
    const double near = CORNER_EDGES * fit->own->edge_length[node] / fit->to_own;
    double x[3];
    *square = reach_of_features(g, node, x);
    if (nearest(&fit->corners, x, square_of_corner, &any, square) < 0)
        return -1;
    fit->is_cut[node] = count_bends(g, node) > 2;
    *square = reach_of_features(g, node, x);
    pl_fit_look_at_node(fit->own, NULL, node, &sides);
    const int32_t at = nearest(&fit->corners, x, square_of_corner, &alike, square);
    return at < 0 || sqrt(*square) > near + CORNER_CURVES * off_curves(g, node) ? -1 : at;
}

static void look_for_corners(void *context, int64_t begin, int64_t end, int thread) {
    finding *g = context;
    const planish_fit *fit = g->fit;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        g->near[i] = fit->state[i] == PL_FIT_PLACED && fit->own->node_class[i] == PL_CORNER &&
                             g->features.offset[i + 1] > g->features.offset[i]
                         ? find_corner(g, (int32_t)i, &g->square[i])
                         : -1;
}

/** Give each corner to the nearest node that asks for it, the lowest of several. winner [nodes of onto]. */
static void give_corners(const finding *g, int32_t *winner) {
    planish_fit *fit = g->fit;
    memset(winner, -1, (size_t)fit->onto->n_nodes * sizeof *winner);
    for (int32_t i = 0; i < fit->n_nodes; i++) {
        int32_t *of = g->near[i] >= 0 ? &winner[g->near[i]] : NULL;
        if (of && (*of < 0 || g->square[i] < g->square[*of]))
            *of = i;
    }
    for (int32_t c = 0; c < fit->onto->n_nodes; c++) {
        if (winner[c] < 0)
            continue;
        fit->kind[winner[c]] = PL_CORNER;
        fit->place[winner[c]].at = c;
        fit->is_cut[winner[c]] = 0;
    }
}

/** Set the place of a node on an edge or facet, near x. */
static void set_place(planish_fit *fit, int32_t node, int kind, int32_t at, const double x[3]) {
    const planish_shape *onto = fit->onto;
    pl_place *place = &fit->place[node];
    *place = (pl_place){at, {0}};
    fit->kind[node] = (uint8_t)kind;
    if (kind == PL_ON_CURVE) {
        pl_nearest_on_edge(x, onto->x[onto->edge[at][0]], onto->x[onto->edge[at][1]],
                           place->weight);
        return;
    }
    const int32_t *v = onto->facet[at];
    const double *const corner[3] = {onto->x[v[0]], onto->x[v[1]], onto->x[v[2]]};
    pl_nearest_on_triangle(x, corner, place->weight);
}

/** Find the edge of a curve where a node, which is set to x, belongs; -1: there is none. *n_ways: edges of
 *  its own curves. */
static int32_t find_edge(const finding *g, int32_t node, int *n_ways, double x[3]) {
    const planish_fit *fit = g->fit;
    double normal[3];
    features_at own = {.n = 0};
    double square = reach_of_features(g, node, x);
    if (fit->own->node_class[node] != PL_ON_PATCH)
        look_at_features(fit->own, &g->features, node, &own);
    *n_ways = own.n;
    const search s = {.fit = fit,
                      .way = (const double(*)[3])own.way,
                      .n_ways = own.n,
                      .sides = own.sides,
                      .own = pl_fit_piece_of(fit, node)};
    const int32_t at = *n_ways > 0 ? nearest(&fit->edges, x, square_of_edge, &s, &square) : -1;
    if (at < 0 || !normal_at(fit->own, node, normal))
        return at;
    const double off = sqrt(square) - CURVE_EDGES * fit->own->edge_length[node] / fit->to_own;
    const search same = {.fit = fit,
                         .patch = -1,
                         .normal = normal,
                         .alike = SAME,
                         .own = pl_fit_piece_of(fit, node)};
    square = off * off / (CURVE_PATCHES * CURVE_PATCHES);
    return off > 0 && nearest(&fit->facets, x, square_of_facet, &same, &square) >= 0 ? -1 : at;
}

/** Find the place of a node that has no corner. */
static void find_place(const finding *g, int32_t node) {
    planish_fit *fit = g->fit;
    double x[3], normal[3];
    int n_ways;
    int32_t at = find_edge(g, node, &n_ways, x);
    if (at >= 0) {
        set_place(fit, node, PL_ON_CURVE, at, x);
        fit->slides[node] = fit->own->node_class[node] == PL_ON_CURVE;
        return;
    }
    double square = reach_of(g, node, x);
    const search s = {.fit = fit,
                      .patch = -1,
                      .normal = normal_at(fit->own, node, normal) ? normal : NULL,
                      .alike = ALIKE,
                      .own = pl_fit_piece_of(fit, node)};
    at = nearest(&fit->facets, x, square_of_facet, &s, &square);
    if (at >= 0)
        set_place(fit, node, PL_ON_PATCH, at, x);
    else
        fit->state[node] = PL_FIT_FAR;
    fit->slides[node] = at >= 0 && n_ways == 0;
}

static void set_goal(planish_fit *fit, int32_t node) {
    const planish_shape *onto = fit->onto;
    double x[3];
    if (fit->kind[node] == PL_CORNER) {
        memcpy(x, onto->x[fit->place[node].at], sizeof x);
    } else {
        pl_shape_point(onto, fit->kind[node], &fit->place[node], x, fit->direction[node]);
        const int turn =
            fit->kind[node] == PL_ON_PATCH ? fit->turn[onto->patch[fit->place[node].at]] : 1;
        for (int d = 0; d < 3; d++)
            fit->direction[node][d] *= turn;
    }
    for (int d = 0; d < 3; d++)
        fit->goal[node][d] = pl_store(&fit->storage, x[d] / onto->scale);
}

static void find_places(void *context, int64_t begin, int64_t end, int thread) {
    const finding *g = context;
    planish_fit *fit = g->fit;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        if (fit->state[i] != PL_FIT_PLACED)
            continue;
        if (fit->place[i].at < 0)
            find_place(g, (int32_t)i);
        if (fit->state[i] == PL_FIT_PLACED)
            set_goal(fit, (int32_t)i);
    }
}

/** Make the trees. Errors: _MEMORY. */
static int plant_all(planish_fit *fit, planish_error *error) {
    const planish_shape *onto = fit->onto;
    int status = plant(fit, onto->facet[0], onto->n_facets, 3, &fit->facets, error);
    if (!status && onto->n_edges > 0)
        status = plant(fit, onto->edge[0], onto->n_edges, 2, &fit->edges, error);
    if (!status && onto->n_edges > 0)
        status = plant(fit, NULL, onto->n_nodes, 1, &fit->corners, error);
    return status;
}

/** Find the places of all nodes; winner [nodes of onto]: room. */
static void find_all(finding *g, int32_t *winner) {
    planish_fit *fit = g->fit;
    for (int64_t i = 0; i < fit->n_nodes; i++) {
        fit->place[i].at = -1;
        fit->is_cut[i] = fit->slides[i] = 0;
        if (fit->state[i] == PL_FIT_FAR)
            fit->state[i] = PL_FIT_PLACED;
    }
    pl_parallel_for(fit->threads, fit->n_nodes, CHUNK, look_for_corners, g);
    give_corners(g, winner);
    pl_parallel_for(fit->threads, fit->n_nodes, CHUNK, find_places, g);
}

int pl_fit_find_places(planish_fit *fit, const pl_points *points, planish_error *error) {
    const planish_shape *onto = fit->onto;
    finding g = {.fit = fit, .points = points};
    for (int64_t f = 0; f < onto->n_facets; f++)
        fit->n_turns = onto->patch[f] >= fit->n_turns ? onto->patch[f] + 1 : fit->n_turns;
    fit->turn = pl_alloc(fit->n_turns, sizeof *fit->turn);
    fit->is_corner = pl_alloc_zero(onto->n_nodes, sizeof *fit->is_corner);
    g.near = pl_alloc(fit->n_nodes, sizeof *g.near);
    g.square = pl_alloc(fit->n_nodes, sizeof *g.square);
    g.ways = pl_alloc(fit->n_nodes, sizeof *g.ways);
    int32_t *winner = pl_alloc(onto->n_nodes, sizeof *winner);
    double(*sum)[2] = NULL;
    int status = fit->turn && fit->is_corner && g.near && g.square && g.ways && winner &&
                         list_features(fit->own, &g.features)
                     ? plant_all(fit, error)
                     : pl_fail_memory(error, "the places of a fit");
    if (!status)
        status = pl_fit_find_pieces(onto, &fit->pieces, error);
    if (!status)
        status = pl_fit_turn_hollows(onto, &fit->facets, fit->threads, &fit->pieces, error);
    if (!status && !(sum = pl_alloc_zero(fit->pieces.n + 1, sizeof *sum)))
        status = pl_fail_memory(error, "the places of a fit");
    if (!status) {
        for (int64_t e = 0; e < 2 * onto->n_edges; e++)
            fit->is_corner[onto->edge[e / 2][e % 2]] =
                onto->node_class[onto->edge[e / 2][e % 2]] == PL_CORNER;
        memset(fit->turn, 1, (size_t)fit->n_turns);
        pl_parallel_for(fit->threads, fit->n_nodes, CHUNK, look_for_turns, &g);
        find_turns(&g, sum);
        status = pl_fit_begin_partners(fit, error);
    }
    if (!status) {
        find_all(&g, winner);
        status = pl_fit_find_partners(fit, error);
    }
    if (!status && pl_fit_has_strays(fit)) {
        find_all(&g, winner);
        status = pl_fit_find_partners(fit, error);
    }
    if (!status)
        pl_fit_hold_doubled(fit);
    pl_free(g.near);
    pl_free(g.square);
    free_features(&g.features);
    pl_free(g.ways);
    pl_free(sum);
    pl_free(winner);
    return status;
}

/* ---- on the way ------------------------------------------------------------------------------ */

/** Find the place on the patch of a node that is nearest to x, in onto's unit: a walk from its first place says
 *  how far it is at most. */
static pl_place place_on_patch(const planish_fit *fit, int32_t node, const double x[3]) {
    const planish_shape *onto = fit->onto;
    const search s = {.fit = fit,
                      .normal = fit->direction[node],
                      .alike = ALIKE,
                      .patch = onto->patch[fit->place[node].at]};
    pl_place place = fit->place[node];
    const double off = pl_shape_walk(onto, PL_ON_PATCH, x, &place);
    double square = off * off;
    const int32_t nearer = nearest(&fit->facets, x, square_of_facet, &s, &square);
    if (nearer < 0 || nearer == place.at)
        return place;
    place.at = nearer;
    const int32_t *v = onto->facet[nearer];
    const double *const corner[3] = {onto->x[v[0]], onto->x[v[1]], onto->x[v[2]]};
    double weight[3] = {1, 0, 0};
    pl_nearest_on_triangle(x, corner, weight);
    memcpy(place.weight, weight, sizeof place.weight);
    return place;
}

/** Bring at, in onto's unit, to the place of a node near it, and set direction there. */
static void project(const planish_fit *fit, int32_t node, double at[3], double direction[3]) {
    pl_place place = fit->place[node];
    if (fit->kind[node] == PL_ON_CURVE)
        pl_shape_walk(fit->onto, PL_ON_CURVE, at, &place);
    else
        place = place_on_patch(fit, node, at);
    pl_shape_point(fit->onto, fit->kind[node], &place, at, direction);
}

/** Return how far storing moves a coordinate, up to a factor of 2, in the mesh's units. */
static double step_of_storage(const planish_fit *fit, double x) {
    const double size = fit->onto->size / fit->onto->scale;
    double step = LEAST_STEP * size;
    if (fit->storage.precision == PLANISH_PRECISION_DOUBLE)
        return 0;
    while (step < size && pl_store(&fit->storage, x + step) == pl_store(&fit->storage, x))
        step *= 2;
    return step;
}

/* A place on a curved patch is projected to another one beside it. So points are sought that are projected to
 * the place itself: what is missing there is added, until little is missing. */
int pl_fit_is_place(const planish_fit *fit, int32_t node, const double x[3]) {
    const double scale = fit->onto->scale;
    double from[3], most = NEAR * fit->own->edge_length[node] / fit->to_own;
    for (int d = 0; d < 3; d++) {
        from[d] = x[d] * scale;
        most += step_of_storage(fit, x[d]) * scale;
    }
    for (int i = 0; i < TRIALS; i++) {
        double at[3], missing[3], direction[3];
        memcpy(at, from, sizeof at);
        project(fit, node, at, direction);
        for (int d = 0; d < 3; d++) {
            missing[d] = x[d] * scale - at[d];
            from[d] += missing[d];
        }
        if (pl_length(missing) <= most)
            return 1;
    }
    return 0;
}

planish_constraint pl_fit_project(const planish_fit *fit, int32_t node, double x[3],
                                  double direction[3]) {
    const planish_shape *onto = fit->onto;
    double at[3];
    if (node < 0 || !fit->is_there[node] || !fit->slides[node])
        return PLANISH_CONSTRAINT_FIXED;
    for (int d = 0; d < 3; d++)
        at[d] = x[d] * onto->scale;
    project(fit, node, at, direction);
    for (int d = 0; d < 3; d++)
        x[d] = pl_store(&fit->storage, at[d] / onto->scale);
    return fit->kind[node] == PL_ON_CURVE ? PLANISH_CONSTRAINT_ON_LINE
                                          : PLANISH_CONSTRAINT_ON_PLANE;
}
