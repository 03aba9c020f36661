/* walk: from a place on a shape to the nearest one to a point, over straight triangles or edges. */
#include "shape/walk.h"

#include "shape/nearest.h"

#include <string.h>

/* A step must shorten the square of the distance by more than rounding does. */
static const double SHORTER = 1 - 1e-13;

/** Compute the weights of the point of a facet that is nearest to p. Returns the square of the
 *  distance. */
static double nearest_on_facet(const planish_shape *s, const double *p, int32_t f,
                               double weight[3]) {
    const double *const x[3] = {s->x[s->facet[f][0]], s->x[s->facet[f][1]], s->x[s->facet[f][2]]};
    return pl_nearest_on_triangle(p, x, weight);
}

/** A facet that may be nearer to the point than where the walk is. */
typedef struct walk {
    const planish_shape *shape;
    const double *point;
    pl_place best;
    double square; /* of the distance */
} walk;

static void try_facet(walk *w, int32_t f) {
    pl_place p = {f, {0}};
    const double square = nearest_on_facet(w->shape, w->point, f, p.weight);
    if (!(square < w->square * SHORTER))
        return;
    w->best = p;
    w->square = square;
}

/** Try the facets around corner k of f, as far as there is no feature, one way or the other. */
static void try_around(walk *w, int32_t f, int k) {
    const planish_shape *s = w->shape;
    const int32_t node = s->facet[f][k];
    for (int forwards = 1; forwards >= 0; forwards--) {
        int32_t g = f;
        int m = k;
        while ((g = s->across[g][forwards ? (m + 2) % 3 : m]) >= 0 && g != f) {
            m = pl_corner_at(s, g, node);
            try_facet(w, g);
        }
        if (g == f)
            return;
    }
}

static double walk_on_patch(const planish_shape *s, const double point[3], pl_place *place) {
    walk w = {s, point, *place, 0};
    w.square = nearest_on_facet(s, point, place->at, w.best.weight);
    int32_t from;
    do {
        const pl_place here = w.best;
        from = here.at;
        int corner = -1;
        for (int k = 0; k < 3; k++)
            if (here.weight[k] == 1)
                corner = k;
        if (corner >= 0)
            try_around(&w, from, corner);
        else
            for (int k = 0; k < 3; k++)
                if (here.weight[(k + 2) % 3] == 0 && s->across[from][k] >= 0)
                    try_facet(&w, s->across[from][k]);
    } while (w.best.at != from);
    *place = w.best;
    return sqrt(w.square);
}

static double walk_on_curve(const planish_shape *s, const double point[3], pl_place *place) {
    double square = INFINITY;
    for (int32_t e = place->at; e >= 0;) {
        pl_place p = {e, {0}};
        const double here =
            pl_nearest_on_edge(point, s->x[s->edge[e][0]], s->x[s->edge[e][1]], p.weight);
        if (!(here < (square < INFINITY ? square * SHORTER : square)))
            break;
        square = here;
        *place = p;
        const int end = p.weight[0] == 1 ? 0 : p.weight[1] == 1 ? 1 : -1;
        if (end < 0)
            break;
        const int32_t *at = s->edge_at[s->edge[e][end]]; /* corners have no other edge */
        e = at[at[0] == e];
    }
    return sqrt(square);
}

double pl_shape_walk(const planish_shape *shape, int node_class, const double point[3],
                     pl_place *place) {
    return node_class == PL_ON_CURVE ? walk_on_curve(shape, point, place)
                                     : walk_on_patch(shape, point, place);
}

pl_place pl_shape_first_place(const planish_shape *s, int32_t node) {
    pl_place place = {-1, {0}};
    if (s->node_class[node] == PL_ON_CURVE) {
        place.at = s->edge_at[node][0];
        place.weight[s->edge[place.at][1] == node] = 1;
    } else if (s->node_class[node] == PL_ON_PATCH) {
        place.at = s->facet_of[s->offset[node]];
        place.weight[pl_corner_at(s, place.at, node)] = 1;
    }
    return place;
}
