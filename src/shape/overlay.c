/* overlay: a proved bound of the distance from a moved facet T to its patch.
 *
 * Why it holds. Project the patch along T's normal. Flood the patch from a facet that meets T across
 * every edge that may meet T. All facets that are met turn the same way round, so the number of them
 * over a point of T changes at features alone. Where no feature runs inside of T, a facet that meets
 * T says that facets cover all of T, and the height of the patch over T is linear on every piece:
 * largest at a corner of one.
 *
 * Features may run in strips along T's own edges on curves, and around its corners on them. What
 * remains of T is convex and covered. A point at depth s in a strip of depth d may be uncovered. It is
 * within k (d - s) of the covered rest, and within c s + lateral of the curve, which is of the patch
 * as well: the smaller of both counts. k and c come from T's angles. Where the chain of the curve's
 * edges runs between T's side and the rest, as on the hollow side of a curve, it is no farther from
 * a point between them than it is deep. So lengths count, not areas: an area a that is missing
 * anywhere would only say sqrt(a / |T|) L.
 *
 * Why it holds in floating point. Coordinates in T's frame are off by some 5 roundings of the
 * distances in it, depths by 12. margin is more than 3 times that. Facets and edges are left out if
 * all of them is less than a margin deep under one side of T; so they miss what is two margins deep,
 * and all that was said holds there, for coordinates without rounding. The rest of T is no farther
 * from there than 2 margins L / r, r the radius of the circle in T.
 */
#include "shape/nearest.h"
#include "shape/overlay.h"
#include "shape/walk.h"

#include <string.h>

enum {
    MOST_FACETS = 128,           /* that a triangle may meet */
    MOST_SEEN = MOST_FACETS + 2, /* nodes of these: across an edge there is one more */
    MOST_POINTS = 12,            /* of a triangle cut by three lines, with roundings of all signs */
    MOST_EDGES = 64,             /* of a curve under one edge */
};

/* Cosine of the steepest facet under T. */
#define STEEPEST 0.2
/* Roundings of a depth, in units of the coordinates that it is made from. */
#define ROUNDING 0x1p-47
/* Most area of pieces over T, in units of T. Beyond, two sheets are over T. */
#define MOST_AREA 1.5
/* A strip may take this much of T's height, a cut this much of the edges at a corner. */
#define DEEPEST_STRIP 0.25
#define LARGEST_CUT   0.5

/** The frame of T: it lies in the plane of the first two coordinates; the third is the height. Side
 *  k goes from corner k to the next one. */
typedef struct overlay_frame {
    double origin[3], axis[3][3];
    double corner[3][3]; /* the heights are roundings */
    double inward[3][2]; /* unit normal of side k */
    double side[3];      /* its length, */
    double height[3];    /* and of the corner opposite to it */
    double area;         /* twice that of T */
    double longest;      /* side */
} overlay_frame;

/** A point in T's frame. */
typedef struct pl_flat_point {
    double x[3];
    double depth[3]; /* under each side */
} pl_flat_point;

/** A facet in T's frame. */
typedef struct pl_flat_facet {
    pl_flat_point corner[3];
    double margin;
} pl_flat_facet;

/** A flood of the facets over T. */
typedef struct pl_overlay {
    const planish_shape *shape;
    const pl_moved_facet *t;
    double limit;
    int is_any; /* 1: T never was a facet, so that its sides are none of the features */
    overlay_frame frame;
    double margin;  /* largest one of a facet */
    double highest; /* corner of a piece, of either sign */
    double
        apart2; /* of second order: square of the largest distance between points over one another, */
    double rest;     /* but for this of the facets over T */
    double area;     /* of the pieces that were cut, twice */
    double strip[3]; /* features run up to so deep under side k, 0: none do */
    double cut[3];   /* and this far from corner k, in units of the sides at it */
    int n;
    int32_t facet[MOST_FACETS];
    double middle[MOST_FACETS]
                 [2]; /* a point of the piece; NAN: there is none; infinite: it was not cut */
    int n_seen;       /* nodes of facets, each is one of several */
    int32_t seen[MOST_SEEN];
    pl_flat_point at[MOST_SEEN];
} pl_overlay;

enum { OUTSIDE, MET, FAILED };

/** The larger of two numbers; fmax would be a call. */
static inline double larger(double a, double b) {
    return a > b ? a : b;
}

static void to_frame(const overlay_frame *f, const double x[3], double local[3]) {
    double v[3];
    pl_subtract(3, x, f->origin, v);
    for (int d = 0; d < 3; d++)
        local[d] = pl_dot(3, f->axis[d], v);
}

/** Depth of a point under side k of T. */
static double depth_of(const overlay_frame *f, int k, const double *p) {
    return f->inward[k][0] * (p[0] - f->corner[k][0]) + f->inward[k][1] * (p[1] - f->corner[k][1]);
}

/** Set axis to unit vectors across one another: along the first side, and the normal. Returns whether
 *  T has an area. */
static int set_axes(overlay_frame *f, const double x[3][3]) {
    double u[3], v[3], normal[3], across[3];
    pl_subtract(3, x[1], x[0], u);
    pl_subtract(3, x[2], x[0], v);
    pl_cross(u, v, normal);
    if (!pl_unit(3, u, f->axis[0]) || !pl_unit(3, normal, across))
        return 0;
    /* The normal of a needle is off by many roundings; across its long side the needle is thin enough
     * that its corners are not. */
    const double along = pl_dot(3, across, f->axis[0]);
    for (int d = 0; d < 3; d++)
        across[d] -= along * f->axis[0][d];
    if (!pl_unit(3, across, f->axis[2]))
        return 0;
    pl_cross(f->axis[2], f->axis[0], f->axis[1]);
    return 1;
}

/** Set the frame of a triangle. Returns whether it has an area. */
static int set_frame(overlay_frame *f, const double x[3][3]) {
    if (!set_axes(f, x))
        return 0;
    memcpy(f->origin, x[0], sizeof f->origin);
    f->longest = 0;
    for (int k = 0; k < 3; k++)
        to_frame(f, x[k], f->corner[k]);
    const double(*c)[3] = (const double(*)[3])f->corner;
    f->area = (c[1][0] - c[0][0]) * (c[2][1] - c[0][1]) - (c[2][0] - c[0][0]) * (c[1][1] - c[0][1]);
    for (int k = 0; k < 3; k++) {
        const double along[2] = {c[(k + 1) % 3][0] - c[k][0], c[(k + 1) % 3][1] - c[k][1]};
        f->side[k] = sqrt(pl_dot(2, along, along));
        f->inward[k][0] = -along[1] / f->side[k];
        f->inward[k][1] = along[0] / f->side[k];
        f->height[k] = f->area / f->side[k];
        f->longest = larger(f->longest, f->side[k]);
    }
    return f->area > 0;
}

/* ---- one facet ---------------------------------------------------------------------------- */

/** Compute a node of the shape in T's frame, or find it where that was done. */
static const pl_flat_point *see_node(pl_overlay *o, int32_t node) {
    const overlay_frame *f = &o->frame;
    for (int i = 0; i < o->n_seen; i++)
        if (o->seen[i] == node)
            return &o->at[i];
    pl_flat_point *p = &o->at[o->n_seen];
    o->seen[o->n_seen++] = node;
    to_frame(f, o->shape->x[node], p->x);
    for (int j = 0; j < 3; j++)
        p->depth[j] = depth_of(f, j, p->x);
    return p;
}

/** Compute a facet in T's frame. */
static void flatten(pl_overlay *o, int32_t facet, pl_flat_facet *flat) {
    double reach = o->frame.longest;
    for (int k = 0; k < 3; k++) {
        const pl_flat_point *p = see_node(o, o->shape->facet[facet][k]);
        flat->corner[k] = *p;
        reach = larger(fabs(p->x[0]) + fabs(p->x[1]) + fabs(p->x[2]), reach);
    }
    flat->margin = ROUNDING * (reach + o->frame.longest);
    o->margin = larger(o->margin, flat->margin);
}

/** Whether the edge from corner k to l (k itself: the corner) is outside of one side. */
static int is_outside(const pl_flat_facet *flat, int k, int l) {
    const double *from = flat->corner[k].depth, *to = flat->corner[l].depth;
    for (int j = 0; j < 3; j++)
        if (from[j] <= flat->margin && to[j] <= flat->margin)
            return 1;
    return 0;
}

static int is_facet_outside(const pl_flat_facet *flat) {
    const pl_flat_point *c = flat->corner;
    for (int j = 0; j < 3; j++)
        if (c[0].depth[j] <= flat->margin && c[1].depth[j] <= flat->margin &&
            c[2].depth[j] <= flat->margin)
            return 1;
    return 0;
}

/** Compute the point at t on the way from a to b. */
static void between(const pl_flat_point *a, const pl_flat_point *b, double t, pl_flat_point *p) {
    for (int d = 0; d < 3; d++) {
        p->x[d] = a->x[d] + t * (b->x[d] - a->x[d]);
        p->depth[d] = a->depth[d] + t * (b->depth[d] - a->depth[d]);
    }
}

/** Cut the polygon p of n corners off at side j; q: the rest. Returns its number of corners. */
static int cut_at(int j, const pl_flat_point *p, int n, pl_flat_point *q) {
    int m = 0;
    for (int i = 0; i < n; i++) {
        const pl_flat_point *next = &p[i + 1 < n ? i + 1 : 0];
        const double here = p[i].depth[j], there = next->depth[j];
        if (here >= 0)
            q[m++] = p[i];
        if ((here > 0 && there < 0) || (here < 0 && there > 0))
            between(&p[i], next, here / (here - there), &q[m++]);
    }
    return m;
}

/** Find the piece of a facet over T, in room [2] or the facet's corners. Returns its number of corners. */
static int piece_of(const pl_flat_facet *flat, pl_flat_point (*room)[MOST_POINTS],
                    const pl_flat_point **piece) {
    int n = 3;
    *piece = flat->corner;
    for (int j = 0; j < 3 && n > 0; j++) {
        if (flat->corner[0].depth[j] >= 0 && flat->corner[1].depth[j] >= 0 &&
            flat->corner[2].depth[j] >= 0)
            continue;
        pl_flat_point *rest = *piece == room[0] ? room[1] : room[0];
        n = cut_at(j, *piece, n, rest);
        *piece = rest;
    }
    return n;
}

/** Whether a piece lies along one side of T within a margin: it is not met. */
static int is_thin(const pl_flat_point *piece, int n, double margin) {
    for (int j = 0; j < 3; j++) {
        double deepest = 0;
        for (int i = 0; i < n; i++)
            deepest = larger(piece[i].depth[j], deepest);
        if (deepest <= margin)
            return 1;
    }
    return 0;
}

/** Whether a facet turns as T does, for certain, and is not too steep over it. */
static int is_upright(const pl_flat_facet *flat) {
    const double *x = flat->corner[0].x, *y = flat->corner[1].x, *z = flat->corner[2].x;
    double u[3], v[3], normal[3];
    pl_subtract(3, y, x, u);
    pl_subtract(3, z, x, v);
    pl_cross(u, v, normal);
    const double rounding = 4 * flat->margin * (fabs(u[0]) + fabs(u[1]) + fabs(v[0]) + fabs(v[1]));
    return normal[2] > rounding &&
           normal[2] * normal[2] >= STEEPEST * STEEPEST * pl_dot(3, normal, normal);
}

/** Compute the weights of a point in a triangle, both in the plane. */
static void weights_in(const double *x, const double *y, const double *z, const double *p,
                       double weight[3]) {
    const double *corner[3] = {x, y, z};
    double part[3], sum = 0;
    for (int k = 0; k < 3; k++) {
        const double *a = corner[(k + 1) % 3], *b = corner[(k + 2) % 3];
        part[k] = (a[0] - p[0]) * (b[1] - p[1]) - (b[0] - p[0]) * (a[1] - p[1]);
        sum += part[k];
    }
    for (int k = 0; k < 3; k++)
        weight[k] = part[k] / sum;
}

/** Add times the way of a point off a triangle of second order. */
static void add_rise(const double rise[3][3], const double weight[3], double times, double way[3]) {
    for (int k = 0; k < 3; k++)
        for (int d = 0; d < 3; d++)
            way[d] += times * weight[k] * weight[(k + 1) % 3] * rise[k][d];
}

/** Compute the way from the point of T, of second order, over p, which is on a facet's triangle, to that of
 *  the facet there. */
static void find_gap(const pl_overlay *o, const pl_flat_facet *flat, const double rise[3][3],
                     const double p[3], double gap[3]) {
    double weight[3];
    for (int d = 0; d < 3; d++)
        gap[d] = p[2] * o->frame.axis[2][d];
    weights_in(flat->corner[0].x, flat->corner[1].x, flat->corner[2].x, p, weight);
    add_rise(rise, weight, 1, gap);
    weights_in(o->frame.corner[0], o->frame.corner[1], o->frame.corner[2], p, weight);
    add_rise(o->t->rise, weight, -1, gap);
}

/** Take the gap between two corners of a piece into the largest one. The gap is a quadratic function: in a
 *  triangle none is larger than its Bezier coefficients, at the corners and between two of them. */
static void add_gap(pl_overlay *o, const pl_flat_facet *flat, const double rise[3][3],
                    const double *a, const double *b) {
    double at_a[3], at_b[3], gap[3], middle[3];
    for (int d = 0; d < 3; d++)
        middle[d] = 0.5 * (a[d] + b[d]);
    find_gap(o, flat, rise, a, at_a);
    find_gap(o, flat, rise, b, at_b);
    find_gap(o, flat, rise, middle, gap);
    for (int d = 0; d < 3; d++)
        gap[d] = 2 * gap[d] - 0.5 * (at_a[d] + at_b[d]);
    o->apart2 = fmax(o->apart2, fmax(pl_dot(3, at_a, at_a), pl_dot(3, gap, gap)));
}

/** Take the gaps over a piece, divided into triangles at its first corner. */
static void add_gaps(pl_overlay *o, int32_t facet, const pl_flat_facet *flat,
                     const pl_flat_point *piece, int n) {
    const planish_shape *s = o->shape;
    double x[PL_WHOLE_NODES][3];
    pl_moved_facet first = {.facet = facet};
    pl_whole_nodes(s, pl_whole_of(s, facet), x);
    pl_set_rises(s, (const double(*)[3])x, &first);
    const double(*rise)[3] = (const double(*)[3])first.rise;
    o->rest = larger(first.rest, o->rest);
    for (int k = 0; k < n; k++)
        add_gap(o, flat, rise, piece[k].x, piece[(k + 1) % n].x);
    for (int k = 2; k + 1 < n; k++)
        add_gap(o, flat, rise, piece[0].x, piece[k].x);
}

/** Take a piece into the sums. */
static void add_piece(pl_overlay *o, int i, const pl_flat_point *piece, int n) {
    const double *first = piece[0].x;
    double area = 0, middle[2] = {0, 0};
    for (int k = 0; k < n; k++) {
        const double *x = piece[k].x;
        o->highest = larger(fabs(x[2]), o->highest);
        middle[0] += x[0];
        middle[1] += x[1];
        if (k >= 2)
            area += (piece[k - 1].x[0] - first[0]) * (x[1] - first[1]) -
                    (x[0] - first[0]) * (piece[k - 1].x[1] - first[1]);
    }
    o->area += area;
    o->middle[i][0] = middle[0] / n;
    o->middle[i][1] = middle[1] / n;
}

/* ---- features over T ---------------------------------------------------------------------- */

/** Whether corner k of T is on a feature. */
static int is_on_feature(const pl_overlay *o, int k) {
    return o->shape->node_class[o->shape->facet[o->t->facet][k]] != PL_ON_PATCH;
}

/** Widen the strip or cut that widens least to hold what is as deep as depth [side] at both ends. A
 *  strip is the better one: it takes all the features along it. Returns whether there is one. */
static int widen(pl_overlay *o, const double depth[3][2], double margin) {
    const overlay_frame *f = &o->frame;
    double least = INFINITY, *at = NULL, to = 0;
    for (int k = 0; k < 3; k++) {
        const double deep = fmax(depth[k][0], depth[k][1]);
        if (o->shape->across[o->t->facet][k] < 0 && deep < least) {
            least = deep;
            at = &o->strip[k];
            to = fmax(deep, 0) + 4 * margin;
        }
    }
    for (int k = 0; k < 3; k++) {
        const double opposite = fmin(depth[(k + 1) % 3][0], depth[(k + 1) % 3][1]);
        const double share = 1 - (opposite - 4 * margin) / f->height[(k + 1) % 3];
        const double far = share * fmax(f->side[k], f->side[(k + 2) % 3]);
        if (is_on_feature(o, k) && 2 * far < least) {
            least = 2 * far;
            at = &o->cut[k];
            to = share;
        }
    }
    if (at)
        *at = fmax(*at, to);
    return at != NULL;
}

/** Take the edge of a facet from corner k, which is a feature. Returns whether T has a strip or a cut
 *  for as much of it as is over T. */
static int take_feature(pl_overlay *o, const pl_flat_facet *flat, int k) {
    const int l = (k + 1) % 3;
    double from = 0, to = 1, depth[3][2];
    for (int j = 0; j < 3; j++) {
        const double a = flat->corner[k].depth[j] + flat->margin;
        const double b = flat->corner[l].depth[j] + flat->margin;
        if (a < 0 && b < 0)
            return 1;
        if (a < 0)
            from = fmax(from, a / (a - b));
        else if (b < 0)
            to = fmin(to, a / (a - b));
    }
    if (from > to)
        return 1;
    if (o->is_any)
        return 0;
    for (int j = 0; j < 3; j++) {
        const double a = flat->corner[k].depth[j], b = flat->corner[l].depth[j];
        depth[j][0] = a + from * (b - a);
        depth[j][1] = a + to * (b - a);
    }
    return widen(o, (const double(*)[2])depth, flat->margin);
}

/* ---- the flood ---------------------------------------------------------------------------- */

/** Add a facet to the flood if it is not in it. Returns whether there was room. */
static int reach(pl_overlay *o, int32_t facet) {
    for (int i = 0; i < o->n; i++)
        if (o->facet[i] == facet)
            return 1;
    if (o->n == MOST_FACETS)
        return 0;
    o->facet[o->n++] = facet;
    return 1;
}

/** Take a facet no point of which is higher over T than pieces are, or than roundings: its piece need not
 *  be cut. Returns whether it is one. */
static int take_low(pl_overlay *o, const pl_flat_facet *flat) {
    const pl_flat_point *c = flat->corner;
    const double z = larger(larger(fabs(c[0].x[2]), fabs(c[1].x[2])), fabs(c[2].x[2]));
    const int is_low = z <= o->highest || z <= ROUNDING * o->frame.longest;
    if (is_low)
        o->highest = larger(z, o->highest);
    return is_low;
}

/** Take the piece of facet i over T. OUTSIDE: there is none. A low facet is taken without being cut; it may be
 *  beside T. */
static int take_piece(pl_overlay *o, int i, const pl_flat_facet *flat) {
    pl_flat_point room[2][MOST_POINTS];
    const pl_flat_point *piece;
    const int is_up = is_upright(flat);
    if (i > 0 && is_up && !o->shape->whole && take_low(o, flat)) {
        o->middle[i][0] = INFINITY;
        o->middle[i][1] = 0;
        return MET;
    }
    const int n = piece_of(flat, room, &piece);
    if (n < 3)
        return OUTSIDE;
    if (!is_up)
        return is_thin(piece, n, flat->margin) ? OUTSIDE : FAILED;
    add_piece(o, i, piece, n);
    if (o->shape->whole && o->t)
        add_gaps(o, o->facet[i], flat, piece, n);
    return MET;
}

/** Take facet i of the flood, and reach those across its edges that may meet T. */
static int take_facet(pl_overlay *o, int i) {
    const int32_t facet = o->facet[i];
    pl_flat_facet flat;
    o->middle[i][0] = NAN;
    flatten(o, facet, &flat);
    if (is_facet_outside(&flat))
        return OUTSIDE;
    const int outcome = take_piece(o, i, &flat);
    if (outcome != MET)
        return outcome;
    for (int k = 0; k < 3; k++) {
        const int32_t across = o->shape->across[facet][k];
        if (is_outside(&flat, k, (k + 1) % 3))
            continue;
        if (!(across >= 0 ? reach(o, across) : take_feature(o, &flat, k)))
            return FAILED;
    }
    return MET;
}

/** Flood from a facet. OUTSIDE: it does not meet T. FAILED: nothing is known, or more than the limit. */
static int flood(pl_overlay *o, int32_t facet) {
    o->margin = o->highest = o->apart2 = o->rest = o->area = 0;
    for (int k = 0; k < 3; k++)
        o->strip[k] = o->cut[k] = 0;
    o->n = o->n_seen = 0;
    reach(o, facet);
    int is_met = OUTSIDE;
    for (int i = 0; i < o->n; i++) {
        const int outcome = take_facet(o, i);
        const double far2 = o->shape->whole ? o->apart2 : o->highest * o->highest;
        if (outcome == FAILED || !(far2 <= o->limit * o->limit))
            return FAILED;
        if (outcome == MET)
            is_met = MET;
    }
    return is_met;
}

/* ---- chains of edges on curves -------------------------------------------------------------- */

/** Extent, in T's frame, of the chain that was there, seen from the side of T that is its chord. */
typedef struct pl_extent {
    double lowest, deepest; /* depth of its points under the side */
    double height;          /* largest, of either sign */
    double gap;             /* how far along the side it begins, or ends before the side does */
} pl_extent;

/** A chain of edges under a side of T. */
typedef struct pl_chain {
    const planish_shape *shape;
    const double *chord[2];
    double ends[2][3];
    double off;  /* how far it is off the chord at most */
    double bend; /* largest of the facets at its edges */
    int n;       /* nodes between the ends */
    int32_t node[MOST_EDGES];
} pl_chain;

/** Distance of x from the segment from a to b. */
static double off_segment(const double a[3], const double b[3], const double x[3]) {
    double weight[2];
    return sqrt(pl_nearest_on_edge(x, a, b, weight));
}

/** Set edge to the curve's edge where corner k is, or -1 if the corner is on no curve; at to the place
 *  there. Returns how far the corner is off it; 0: it is on no feature. */
static double find_on_curve(const planish_shape *s, const pl_moved_facet *t, int k, int32_t *edge,
                            double at[3]) {
    const int32_t node = s->facet[t->facet][k];
    double weight[2];
    *edge = -1;
    memcpy(at, s->x[node], 3 * sizeof *at);
    if (s->node_class[node] == PL_ON_PATCH)
        return 0;
    if (s->node_class[node] == PL_CORNER)
        return pl_distance(3, t->x[k], s->x[node]);
    pl_place place = t->place[k];
    if (place.at < 0) {
        place.at = s->edge_at[node][0];
        pl_shape_walk(s, PL_ON_CURVE, t->x[k], &place);
    }
    *edge = place.at;
    const double *a = s->x[s->edge[*edge][0]], *b = s->x[s->edge[*edge][1]];
    const double off = sqrt(pl_nearest_on_edge(t->x[k], a, b, weight));
    for (int d = 0; d < 3; d++)
        at[d] = weight[0] * a[d] + weight[1] * b[d];
    return off;
}

/** The largest bend of the facets at an edge of a curve; 0: facets are straight. */
static double bend_at(const planish_shape *s, int32_t edge) {
    double most = 0;
    for (int i = 0; i < 2 && s->whole && edge >= 0; i++)
        if (s->edge_facet[edge][i] >= 0)
            most = fmax(most, s->bend[s->edge_facet[edge][i]]);
    return most;
}

/** Follow a curve from the edge from towards its end, up to the edge to, or to the corner if to is -1, and
 *  no farther than most off the chord. Returns whether the way leads there. */
static int follow(pl_chain *c, int32_t from, int end, int32_t to, int32_t corner, double most) {
    const planish_shape *s = c->shape;
    c->off = 0;
    c->bend = bend_at(s, from);
    for (c->n = 0; c->n < MOST_EDGES && c->off <= most;) {
        const int32_t node = s->edge[from][end];
        if (to < 0 && node == corner)
            return 1;
        c->node[c->n++] = node;
        c->off = larger(off_segment(c->chord[0], c->chord[1], s->x[node]), c->off);
        if (s->node_class[node] != PL_ON_CURVE)
            return 0;
        from = s->edge_at[node][s->edge_at[node][0] == from];
        c->bend = fmax(c->bend, bend_at(s, from));
        if (from == to)
            return 1;
        end = s->edge[from][0] == node;
    }
    return 0;
}

/** Find the chain under side k, a feature: of two ways along a closed curve the nearer one. Returns how
 *  far its nodes are off the side; infinite: there is none. */
static double find_chain(const planish_shape *s, const pl_moved_facet *t, int k, pl_chain *chain) {
    const int l = (k + 1) % 3;
    int32_t edge[2];
    pl_chain other;
    chain->shape = s;
    chain->chord[0] = t->x[k];
    chain->chord[1] = t->x[l];
    find_on_curve(s, t, k, &edge[0], chain->ends[0]);
    find_on_curve(s, t, l, &edge[1], chain->ends[1]);
    chain->n = 0;
    chain->off = 0;
    chain->bend = fmax(bend_at(s, edge[0]), bend_at(s, edge[1]));
    if (edge[0] == edge[1]) /* or both are corners: the edge is where it was */
        return 0;
    const int32_t corner = s->facet[t->facet][edge[0] < 0 ? k : l];
    const int32_t from = edge[0] < 0 ? edge[1] : edge[0], to = edge[0] < 0 ? -1 : edge[1];
    other = *chain;
    /* Most often the way by the nearer end is the short one; the other one soon is farther off. */
    const double *target = chain->chord[edge[0] >= 0];
    const int32_t *end = s->edge[from];
    const int first = pl_distance(3, s->x[end[1]], target) < pl_distance(3, s->x[end[0]], target);
    const int is_there = follow(chain, from, first, to, corner, INFINITY);
    const double most = is_there ? chain->off : INFINITY;
    if (follow(&other, from, !first, to, corner, most) && !(is_there && chain->off <= other.off))
        *chain = other;
    else if (!is_there)
        return INFINITY;
    return chain->off;
}

/** Take a point of a chain into its extent. */
static void add_point(const overlay_frame *f, int k, const double x[3], pl_extent *extent) {
    double local[3];
    to_frame(f, x, local);
    const double depth = depth_of(f, k, local);
    extent->lowest = fmin(extent->lowest, depth);
    extent->deepest = fmax(extent->deepest, depth);
    extent->height = fmax(extent->height, fabs(local[2]));
}

/** How far along side k a point is. */
static double along_of(const overlay_frame *f, int k, const double x[3]) {
    double local[3];
    to_frame(f, x, local);
    return f->inward[k][1] * (local[0] - f->corner[k][0]) -
           f->inward[k][0] * (local[1] - f->corner[k][1]);
}

/** Find the extent of the chain under side k; of infinite height if there is none. */
static void find_extent(const pl_overlay *o, int k, pl_extent *extent) {
    const overlay_frame *f = &o->frame;
    pl_chain chain;
    *extent = (pl_extent){INFINITY, -INFINITY, 0, 0};
    if (!(find_chain(o->shape, o->t, k, &chain) < INFINITY)) {
        *extent = (pl_extent){0, 0, INFINITY, 0};
        return;
    }
    for (int end = 0; end < 2; end++)
        add_point(f, k, chain.ends[end], extent);
    for (int i = 0; i < chain.n; i++)
        add_point(f, k, o->shape->x[chain.node[i]], extent);
    extent->gap = fmax(extent->gap, along_of(f, k, chain.ends[0]));
    extent->gap = fmax(extent->gap, f->side[k] - along_of(f, k, chain.ends[1]));
}

/* Distance from a segment is convex, so that no point of the chain is farther off the chord than one
 * of its nodes or ends. And the point of the chord that is nearest to one going along the chain goes
 * along the chord from end to end: so no point of the chord is farther off either, or than its
 * corners are from their places. */
double pl_overlay_lateral(const planish_shape *shape, const pl_moved_facet *t) {
    double most = 0, at[3];
    int32_t edge[3];
    pl_chain chain;
    for (int k = 0; k < 3; k++)
        most = larger(find_on_curve(shape, t, k, &edge[k], at), most);
    for (int k = 0; k < 3; k++)
        if (shape->across[t->facet][k] < 0 && edge[k] != edge[(k + 1) % 3])
            most = fmax(most, find_chain(shape, t, k, &chain));
    return most;
}

/* ---- what the flood says ------------------------------------------------------------------ */

/** Whether a point is in what is left of T without strips and cuts, by more than a few margins. */
static int is_in_rest(const pl_overlay *o, const double *p) {
    const overlay_frame *f = &o->frame;
    for (int k = 0; k < 3; k++) {
        const double depth = depth_of(f, k, p);
        if (!(depth >= o->strip[k] + 4 * o->margin &&
              depth <= (1 - o->cut[(k + 2) % 3]) * f->height[k] - 4 * o->margin))
            return 0;
    }
    return 1;
}

/** Whether the flood covers the rest of T, once. */
static int is_covered(const pl_overlay *o) {
    const overlay_frame *f = &o->frame;
    for (int k = 0; k < 3; k++)
        if (!(o->strip[k] <= DEEPEST_STRIP * f->height[k] && o->cut[k] <= LARGEST_CUT &&
              16 * o->margin <= DEEPEST_STRIP * f->height[k]))
            return 0;
    if (!(o->area <= MOST_AREA * f->area))
        return 0;
    for (int i = 0; i < o->n; i++)
        if (is_in_rest(o, o->middle[i]))
            return 1;
    return 0;
}

/** Two bounds of the distance of a point that may be uncovered, at depth s of a strip or cut. */
typedef struct pl_doubt {
    double w, deep, to_rest; /* sqrt(w^2 + (to_rest (deep - s))^2): by the covered rest of T */
    double to_side, lateral; /* to_side s + lateral: by the side or corner of T */
    pl_extent extent;        /* by the chain over the side */
} pl_doubt;

/** Square of the largest distance by the rest of what is as deep as s or deeper. */
static double by_rest(const pl_doubt *d, double s) {
    const double way = d->to_rest * (d->deep - s);
    return d->w * d->w + way * way;
}

/** Square of the distance by the chain at depth s. The chain has a point over each point of the side, or
 *  one no farther along it than its ends leave out. */
static double by_chain(const pl_doubt *d, double s) {
    const pl_extent *e = &d->extent;
    const double across = fmax(s - e->lowest, e->deepest - s);
    const double along = e->gap + s * sqrt(fmax(d->to_side * d->to_side - 1, 0));
    return across * across + e->height * e->height + along * along;
}

/** Square of the largest distance by the curve of what is as deep as s or less deep. */
static double by_curve(const pl_doubt *d, double s) {
    const double by_side = d->to_side * s + d->lateral;
    return fmin(by_side * by_side, fmax(by_chain(d, 0), by_chain(d, s)));
}

/** Bound the distance in a strip or cut. At any s the rest bounds what is deeper, the curve what is less
 *  deep: take the s where both are about the same. */
static double bound_of(const pl_doubt *d) {
    double low = 0, high = d->deep;
    for (int i = 0; i < 10; i++) {
        const double s = (low + high) / 2;
        if (by_curve(d, s) < by_rest(d, s))
            low = s;
        else
            high = s;
    }
    return sqrt(by_rest(d, low));
}

/** The way to the rest of T by its middle, where that of one strip or cut may end in another one: in
 *  units of the depth of what is deep of reach. */
static double by_middle(const overlay_frame *f, double reach, double deep) {
    return 2. / 3 * f->longest / (reach - deep);
}

/** The way to the rest of T from a point of the strip along side k, in units of how deep that lies over the
 *  point: towards the opposite corner. */
static double to_rest_of_strip(const pl_overlay *o, int k) {
    const overlay_frame *f = &o->frame;
    const int l = (k + 1) % 3, m = (k + 2) % 3;
    const int is_alone = !(o->strip[l] > 0 || o->strip[m] > 0 || o->cut[k] > 0 || o->cut[l] > 0);
    return is_alone ? fmax(f->side[l], f->side[m]) / f->height[k]
                    : by_middle(f, f->height[k] / 3, o->strip[k]);
}

/** Return the same of the cut around corner k, *deep in all: the shortest one to the opposite side. */
static double to_rest_of_cut(const pl_overlay *o, int k, double *deep) {
    const overlay_frame *f = &o->frame;
    const int l = (k + 1) % 3, m = (k + 2) % 3;
    const double a = f->side[l], b = f->side[m], c = f->side[k], side = fmax(b, c);
    const int is_alone = !(o->strip[k] > 0 || o->strip[m] > 0);
    const int is_acute = b * b <= a * a + c * c && c * c <= a * a + b * b;
    *deep = o->cut[k] * side;
    return is_alone ? (is_acute ? f->height[l] : fmin(b, c)) / side
                    : by_middle(f, side * 2 / 3, *deep);
}

/** Bound the distance in the strip along side k. */
static double bound_strip(const pl_overlay *o, int k, double w, double lateral) {
    const overlay_frame *f = &o->frame;
    const int l = (k + 1) % 3, m = (k + 2) % 3;
    const double a = f->side[k], b = f->side[l], c = f->side[m];
    pl_doubt d = {.w = w, .deep = o->strip[k], .to_side = 1, .lateral = lateral};
    d.to_rest = to_rest_of_strip(o, k);
    if (b * b > a * a + c * c) /* beyond an obtuse angle the nearest point is the corner */
        d.to_side = c / f->height[k];
    if (c * c > a * a + b * b)
        d.to_side = b / f->height[k];
    find_extent(o, k, &d.extent);
    return bound_of(&d);
}

/** Bound the distance in the cut around corner k. */
static double bound_cut(const pl_overlay *o, int k, double w, double lateral) {
    pl_doubt d = {.w = w, .to_side = 1, .lateral = lateral};
    d.to_rest = to_rest_of_cut(o, k, &d.deep);
    d.extent.height = INFINITY;
    return bound_of(&d);
}

/** Bound the distance of all of T when its rest is covered. */
static double bound_all(const pl_overlay *o, double lateral) {
    const overlay_frame *f = &o->frame;
    const double w = o->highest;
    double bound = w;
    for (int k = 0; k < 3; k++) {
        if (o->strip[k] > 0)
            bound = fmax(bound, bound_strip(o, k, w, lateral));
        if (o->cut[k] > 0)
            bound = fmax(bound, bound_cut(o, k, w, lateral));
    }
    const double radius = f->area / (f->side[0] + f->side[1] + f->side[2]);
    return bound * (1 + ROUNDING) + o->margin * (2 * f->longest / radius + 1);
}

/** How far the points of facets of second order are off those of their triangles that may be near to T:
 *  of the facets over it, and of those at curves under its sides and corners. */
static double bend_near(const pl_overlay *o) {
    const planish_shape *s = o->shape;
    const pl_moved_facet *t = o->t;
    double most = 0, at[3];
    int32_t edge;
    pl_chain chain;
    for (int i = 0; i < o->n; i++)
        if (o->middle[i][0] == o->middle[i][0]) /* it is over T */
            most = fmax(most, s->bend[o->facet[i]]);
    for (int k = 0; k < 3; k++) {
        find_on_curve(s, t, k, &edge, at);
        most = fmax(most, bend_at(s, edge));
        if (s->across[t->facet][k] < 0 && find_chain(s, t, k, &chain) < INFINITY)
            most = fmax(most, chain.bend);
    }
    return most;
}

/** Facet i of those to flood from, until one meets T: its own, those where its corners are, and what
 *  is nearest to its middle. -1: there is no such one. */
static int32_t seed(const pl_overlay *o, int i) {
    const planish_shape *s = o->shape;
    const pl_moved_facet *t = o->t;
    if (i == 0)
        return t->facet;
    if (i <= 3) {
        const int32_t at = t->place[i - 1].at;
        const int node_class = s->node_class[s->facet[t->facet][i - 1]];
        return node_class == PL_ON_PATCH ? at : -1;
    }
    double middle[3];
    for (int d = 0; d < 3; d++)
        middle[d] = (t->x[0][d] + t->x[1][d] + t->x[2][d]) / 3;
    pl_place place = {t->facet, {1. / 3, 1. / 3, 1. / 3}};
    pl_shape_walk(s, PL_ON_PATCH, middle, &place);
    return place.at;
}

/** The largest rise of T. */
static double highest_rise(const pl_moved_facet *t) {
    double most = 0;
    for (int k = 0; k < 3; k++)
        most = fmax(most, pl_dot(3, t->rise[k], t->rise[k]));
    return sqrt(most);
}

/** How far a point of the facet of second order on T is from one over the rest of T, which is covered: by
 *  the way on T, and what the facet rises on it. A weight changes by no more than 1 / height, and so a rise
 *  by no more than 2 / height, and what is bounded by rest by no more than 40 times that, for the functions
 *  of wholes.h. */
static double way_to_rest(const pl_overlay *o, double rise) {
    const double *h = o->frame.height, least = fmin(h[0], fmin(h[1], h[2]));
    double most = 0, deep;
    for (int k = 0; k < 3; k++) {
        if (o->strip[k] > 0)
            most = fmax(most, o->strip[k] * to_rest_of_strip(o, k));
        if (o->cut[k] > 0) {
            const double to_rest = to_rest_of_cut(o, k, &deep);
            most = fmax(most, deep * to_rest);
        }
    }
    return most * (1 + (2 * rise + 40 * o->t->rest) / least);
}

/** Bound the distance of a facet of second order when the rest of its triangle T is covered: there by the
 *  gaps; beside features by the way to there, or what is known of T and the triangles there but for the
 *  bends of both. */
static double bound_curved(const pl_overlay *o, double lateral) {
    const overlay_frame *f = &o->frame;
    const double rise = highest_rise(o->t);
    const double radius = f->area / (f->side[0] + f->side[1] + f->side[2]);
    double bound = sqrt(o->apart2) * (1 + ROUNDING) + 16 * ROUNDING * rise +
                   o->margin * (2 * f->longest / radius + 1) + o->t->rest + o->rest;
    const double way = way_to_rest(o, rise), bend = rise / 3 + o->t->rest;
    return way > 0 ? fmax(bound, fmin(bound + way, bound_all(o, lateral) + bend_near(o) + bend))
                   : bound;
}

/** Bound the distance of a facet of second order whose triangle has not moved. */
static double bound_still(const planish_shape *s, const pl_moved_facet *t) {
    double x[PL_WHOLE_NODES][3], most = 0;
    pl_moved_facet first = {.facet = t->facet};
    pl_whole_nodes(s, pl_whole_of(s, t->facet), x);
    pl_set_rises(s, (const double(*)[3])x, &first);
    for (int k = 0; k < 3; k++) {
        double off[3];
        pl_subtract(3, t->rise[k], first.rise[k], off);
        most = fmax(most, pl_dot(3, off, off));
    }
    return 0.5 * sqrt(most) * (1 + ROUNDING) + t->rest + first.rest;
}

static int is_unmoved(const planish_shape *s, const pl_moved_facet *t) {
    for (int k = 0; k < 3; k++)
        for (int d = 0; d < 3; d++)
            if (t->x[k][d] != s->x[s->facet[t->facet][k]][d])
                return 0;
    return 1;
}

/** Flood the facets over a triangle within a limit. Returns whether they cover it. */
static int cover(pl_overlay *o, const planish_shape *shape, const pl_moved_facet *t, double limit) {
    enum { SEEDS = 5 };
    o->shape = shape;
    o->t = t;
    o->limit = limit;
    if (!set_frame(&o->frame, t->x))
        return 0;
    o->is_any = 0;
    for (int i = 0; i < SEEDS; i++) {
        const int32_t facet = seed(o, i);
        if (facet < 0 || shape->patch[facet] != shape->patch[t->facet])
            continue;
        const int outcome = flood(o, facet);
        if (outcome == FAILED)
            return 0;
        if (outcome == MET && is_covered(o))
            return 1;
    }
    return 0;
}

double pl_overlay_bound(const planish_shape *shape, const pl_moved_facet *t, double lateral,
                        double limit) {
    if (is_unmoved(shape, t))
        return shape->whole ? bound_still(shape, t) : 0;
    pl_overlay o;
    if (!cover(&o, shape, t, limit))
        return INFINITY;
    return shape->whole ? bound_curved(&o, lateral) : bound_all(&o, lateral);
}

double pl_overlay_most(const planish_shape *shape, const pl_moved_facet *t, const double *number) {
    pl_overlay o;
    double most = 0;
    if (!cover(&o, shape, t, INFINITY))
        return INFINITY;
    for (int i = 0; i < o.n; i++)
        if (o.middle[i][0] == o.middle[i][0]) /* it is over T */
            most = fmax(most, number[o.facet[i]]);
    return most;
}

double pl_overlay_bound_any(const planish_shape *shape, const double x[3][3], int32_t facet) {
    pl_overlay o;
    o.shape = shape;
    o.t = NULL;
    o.limit = INFINITY;
    o.is_any = 1;
    if (!set_frame(&o.frame, x) || flood(&o, facet) != MET || !is_covered(&o))
        return INFINITY;
    double bend = 0;
    for (int i = 0; shape->whole && i < o.n; i++)
        bend = fmax(bend, shape->bend[o.facet[i]]);
    return bound_all(&o, 0) + bend;
}
