/* fan: why the bound holds. Let T be the facet as it was first, U the fans of its corners, which are closed.
 * Over the plane across T's normal no facet of U has a slope above s. A facet whose corners have moved by
 * no more than m has p + d, |d| <= m, where T has p. Go from p straight on along d over the plane, on U. The
 * function that is linear on facets, 1 at T's corners and 0 at all other nodes, is 1 at p, and changes by
 * 1 / h a length at most, h the least height of a facet of U seen from above. So the way does not leave U
 * while m < h, and it ends over p + d, at a height that differs from p's by no more than s m.
 */
#include "shape/fan.h"

#include <math.h>

/* Normals of a fan are no farther from the first one. */
#define MOST_TURN 0.4
/* Margins for roundings of floats. */
#define LESS (1 - 0x1p-20)
#define MORE (1 + 0x1p-20)

/** The least height of a facet. */
static double height_of(const planish_shape *s, int32_t facet) {
    const int32_t *v = s->facet[facet];
    double side[3][3], across[3], longest2 = 0;
    for (int k = 0; k < 3; k++) {
        pl_from_to(3, s->x[v[k]], s->x[v[(k + 1) % 3]], side[k]);
        longest2 = fmax(longest2, pl_dot(3, side[k], side[k]));
    }
    pl_cross(side[0], side[1], across);
    return longest2 > 0 ? sqrt(pl_dot(3, across, across) / longest2) : 0;
}

void pl_fan_find(const planish_shape *shape, int32_t node, pl_fan *fan) {
    const int32_t *facet = shape->facet_of + shape->offset[node];
    const uint32_t n = shape->offset[node + 1] - shape->offset[node];
    double height = INFINITY, turn2 = 0, first[3], other[3], way[3];
    *fan = (pl_fan){0, 0};
    if (shape->node_class[node] != PL_ON_PATCH)
        return;
    pl_kept_normal(shape, facet[0], first);
    for (uint32_t i = 0; i < n && turn2 <= MOST_TURN * MOST_TURN; i++) {
        pl_kept_normal(shape, facet[i], other);
        pl_from_to(3, first, other, way);
        turn2 = fmax(turn2, pl_dot(3, way, way));
        height = fmin(height, height_of(shape, facet[i]));
    }
    if (turn2 <= MOST_TURN * MOST_TURN)
        *fan = (pl_fan){(float)(height * LESS), (float)(sqrt(turn2) * MORE)};
}

/* T is in all of its fans, so that normals of U are no farther from its own than two turns. */
double pl_fan_bound(const planish_shape *shape, const pl_fan *fan, const pl_moved_facet *t) {
    double normal[3], move2 = 0, off = 0, height = INFINITY, turn = 0;
    pl_kept_normal(shape, t->facet, normal);
    for (int k = 0; k < 3; k++) {
        const int32_t node = shape->facet[t->facet][k];
        double way[3];
        pl_from_to(3, shape->x[node], t->x[k], way);
        move2 = fmax(move2, pl_dot(3, way, way));
        off = fmax(off, fabs(pl_dot(3, way, normal)));
        height = fmin(height, (double)fan[node].height);
        turn = fmax(turn, (double)fan[node].turn);
    }
    const double chord = 2 * turn + 4 * PL_KEPT_NORMAL_OFF, move = sqrt(move2);
    const double cosine = 1 - chord * chord / 2, sine = chord * sqrt(1 - chord * chord / 4);
    return move < height * cosine * LESS ? (off + move * sine / cosine) * MORE : INFINITY;
}
