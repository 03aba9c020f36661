/* divide: the parts of a triangle that may be far off. */
#include "shape/divide.h"

#include "shape/nearest.h"
#include "shape/overlay.h"
#include "shape/walk.h"

#include <string.h>

/* Facets of second order are off their triangles by bends: what is below this part of one is sharp enough. */
#define OF_BEND 0.1

static double bend_of(const planish_shape *s, int32_t facet) {
    return s->whole ? s->bend[facet] : 0;
}

/** Squared distance of a facet from a point; infinite: the facet is not asked for. */
static double square_off(const void *context, int32_t facet, const double point[3]) {
    const pl_division *q = context;
    const planish_shape *s = q->shape;
    const int32_t *node = s->facet[facet];
    const double *const corner[3] = {s->x[node[0]], s->x[node[1]], s->x[node[2]]};
    double weight[3] = {1, 0, 0};
    const int is_asked_for = q->patch < 0 ? !s->is_interface[facet] : s->patch[facet] == q->patch;
    return is_asked_for ? pl_nearest_on_triangle(point, corner, weight) : INFINITY;
}

int32_t pl_division_find(const pl_division *division, const double point[3], double *square) {
    *square = INFINITY;
    return pl_tree_nearest(division->tree, point, square_off, division, square);
}

/** Return the facet nearest to a point, and let known rise to its distance. A walk may end at another facet: that
 *  is enough if it is no farther off than is known. */
static int32_t find_near(pl_division *q, const double point[3], int32_t from) {
    pl_place place = {from, {1. / 3, 1. / 3, 1. / 3}};
    const double off = pl_shape_walk(q->shape, PL_ON_PATCH, point, &place);
    if (q->close * off + bend_of(q->shape, place.at) <= q->known)
        return place.at;
    double square = square_off(q, place.at, point);
    const int32_t nearer = q->tree ? pl_tree_nearest(q->tree, point, square_off, q, &square) : -1;
    const int32_t near = nearer >= 0 ? nearer : place.at;
    q->known = fmax(q->known, q->close * sqrt(square) + bend_of(q->shape, near));
    return near;
}

/** Let known rise to the distance of the corner of a part that is farthest from a facet. */
static void see_farthest(pl_division *q, int32_t facet, const double x[3][3]) {
    int farthest = 0;
    double most = 0;
    for (int k = 0; k < 3; k++) {
        const double square = square_off(q, facet, x[k]);
        farthest = square > most ? k : farthest;
        most = fmax(most, square);
    }
    find_near(q, x[farthest], facet);
}

/** Bound the distance of a part by the farthest of its corners from a facet. */
static double bound_by_facet(const pl_division *q, int32_t facet, const double x[3][3]) {
    double most = 0;
    for (int k = 0; k < 3; k++)
        most = fmax(most, square_off(q, facet, x[k]));
    return sqrt(most) + bend_of(q->shape, facet);
}

double pl_division_overlay(const pl_division *division, const double x[3][3], int32_t near) {
    const int8_t *turn = division->turn;
    const int turns = division->turns * (turn ? turn[division->shape->patch[near]] : 1);
    double turned[3][3];
    for (int k = 0; k < 3; k++)
        memcpy(turned[k], x[turns < 0 ? 2 - k : k], sizeof turned[k]);
    return pl_overlay_bound_any(division->shape, (const double(*)[3])turned, near);
}

/** Bound the distance of a part, as sharply as it can be without dividing it if that is asked for. */
static double bound_of(const pl_division *q, const double x[3][3], int32_t near) {
    const double enough = fmax(q->known, q->fine);
    double bound = bound_by_facet(q, near, x);
    for (int k = 0; k < 3 && bound > enough; k++)
        if (q->shape->across[near][k] >= 0)
            bound = fmin(bound, bound_by_facet(q, q->shape->across[near][k], x));
    return bound > enough ? fmin(bound, pl_division_overlay(q, x, near)) : bound;
}

/** Return the largest bound of the parts of a triangle that is above known; or less than known. */
static double divide(pl_division *q, const double x[3][3], int32_t from, int depth) {
    double middle[3], part[4][3][3], most = 0;
    for (int d = 0; d < 3; d++)
        middle[d] = (x[0][d] + x[1][d] + x[2][d]) / 3;
    const int32_t near = find_near(q, middle, from);
    const double bound = bound_of(q, x, near);
    const double enough = fmax(q->fine, (1 + OF_BEND) * bend_of(q->shape, near));
    q->n_pieces++;
    if (bound <= fmax(q->known, enough) || depth == 0 || q->n_pieces >= q->most_pieces)
        return bound;
    if (q->tree)
        see_farthest(q, near, x);
    pl_quarter_triangle(x, part);
    for (int i = 0; i < 4; i++)
        most = fmax(most, divide(q, (const double(*)[3])part[i], near, depth - 1));
    return most;
}

double pl_divide(pl_division *division, const double x[3][3], int32_t near, int depth) {
    for (int k = 0; k < 3 && division->tree; k++) /* else a walk to a corner is long */
        near = find_near(division, x[k], near);
    const double most = divide(division, x, near, depth);
    return fmax(most, division->known);
}
