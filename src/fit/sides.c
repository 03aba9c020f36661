/* sides: features of two shapes are alike if what they bound is. */
#include "fit/sides.h"

#include <string.h>

/* Normals within this are the same: cosine. */
#define SAME 0.95
/* What bends by more than this stands out or lies in: sine. */
#define BENT 0.3

/** Set normal to that of a facet, out of the body; 0: it has no area, or is not of the outside. */
static int normal_of(const planish_shape *s, const int8_t *turn, int32_t facet, double normal[3]) {
    const int sign = turn ? turn[s->patch[facet]] : 1;
    pl_kept_normal(s, facet, normal);
    for (int d = 0; d < 3; d++)
        normal[d] *= sign;
    return pl_fit_is_outer(s, facet) && pl_dot(3, normal, normal) > 0;
}

/** Add a normal, if there is none like it. */
static void add_normal(pl_fit_sides *sides, const double normal[3]) {
    for (int i = 0; i < sides->n; i++)
        if (pl_dot(3, normal, sides->normal[i]) > SAME)
            return;
    sides->is_open |= sides->n == PL_FIT_MOST_NORMALS;
    if (sides->n < PL_FIT_MOST_NORMALS)
        memcpy(sides->normal[sides->n++], normal, sizeof sides->normal[0]);
}

/** Return how far the apex of a facet over an edge is before another facet there, in lengths of its way. */
static double rise_of(const planish_shape *s, int32_t facet, const int32_t *edge,
                      const double normal[3]) {
    const int k = (pl_edge_of(s->facet[facet], edge[0], edge[1]) + 2) % 3;
    double way[3], unit[3];
    pl_from_to(3, s->x[edge[0]], s->x[s->facet[facet][k]], way);
    return pl_unit(3, way, unit) ? pl_dot(3, unit, normal) : 0;
}

static int bend_of(double rise) {
    return rise < -BENT ? 1 : rise > BENT ? -1 : 0;
}

void pl_fit_look_at_edge(const planish_shape *s, const int8_t *turn, int32_t edge,
                         pl_fit_sides *sides) {
    const int32_t *end = s->edge[edge];
    const int32_t few =
        s->offset[end[0] + 1] - s->offset[end[0]] > s->offset[end[1] + 1] - s->offset[end[1]];
    int n = 0;
    double normal[2][3];
    int32_t facet[2];
    *sides = (pl_fit_sides){.n = 0};
    for (uint32_t i = s->offset[end[few]]; i < s->offset[end[few] + 1]; i++) {
        const int32_t f = s->facet_of[i], *v = s->facet[f], other = end[!few];
        double of[3];
        if ((v[0] != other && v[1] != other && v[2] != other) || !normal_of(s, turn, f, of))
            continue;
        add_normal(sides, of);
        if (n < 2) {
            memcpy(normal[n], of, sizeof of);
            facet[n] = f;
        }
        n++;
    }
    sides->is_open |= n != 2;
    if (n == 2)
        sides->bend =
            bend_of(rise_of(s, facet[0], end, normal[1]) + rise_of(s, facet[1], end, normal[0]));
}

/** Whether a facet ends at a node, without another one of the outside that goes on there. */
static int ends_at(const planish_shape *s, int32_t facet, int32_t node) {
    const int corner = pl_corner_at(s, facet, node);
    int is_end = 0;
    for (int k = 0; k < 2; k++) {
        const int edge = k ? corner : (corner + 2) % 3;
        const int32_t end = s->facet[facet][k ? (corner + 1) % 3 : edge];
        int n = s->across[facet][edge] >= 0 ? 2 : 0;
        for (uint32_t i = s->offset[node]; i < s->offset[node + 1] && n < 2; i++) {
            const int32_t *v = s->facet[s->facet_of[i]];
            n += pl_fit_is_outer(s, s->facet_of[i]) && (v[0] == end || v[1] == end || v[2] == end);
        }
        is_end |= n < 2;
    }
    return is_end;
}

void pl_fit_look_at_node(const planish_shape *s, const int8_t *turn, int32_t node,
                         pl_fit_sides *sides) {
    double out[3] = {0, 0, 0}, on[3] = {0, 0, 0};
    *sides = (pl_fit_sides){.n = 0};
    for (uint32_t i = s->offset[node]; i < s->offset[node + 1]; i++) {
        const int32_t f = s->facet_of[i];
        double normal[3], way[3], unit[3];
        if (!normal_of(s, turn, f, normal))
            continue;
        add_normal(sides, normal);
        sides->is_open = sides->is_open || pl_is_hub(s, node) || ends_at(s, f, node);
        for (int k = 0; k < 3; k++) {
            pl_from_to(3, s->x[node], s->x[s->facet[f][k]], way);
            for (int d = 0; d < 3 && pl_unit(3, way, unit); d++)
                on[d] += unit[d];
        }
    }
    for (int i = 0; i < sides->n; i++)
        for (int d = 0; d < 3; d++)
            out[d] += sides->normal[i][d];
    double unit_on[3], unit_out[3];
    if (pl_unit(3, on, unit_on) && pl_unit(3, out, unit_out))
        sides->bend = bend_of(pl_dot(3, unit_on, unit_out));
}

/** Whether each normal of one has one of the other that is like it. */
static int are_in(const pl_fit_sides *these, const pl_fit_sides *those, double cosine) {
    for (int i = 0; i < these->n; i++) {
        double most = -1;
        for (int k = 0; k < those->n; k++)
            most = fmax(most, pl_dot(3, these->normal[i], those->normal[k]));
        if (most < cosine)
            return 0;
    }
    return 1;
}

int pl_fit_are_alike(const pl_fit_sides *own, const pl_fit_sides *other, double cosine) {
    return own->bend * other->bend >= 0 && other->n > 0 &&
           (other->is_open || are_in(own, other, cosine)) &&
           (own->is_open || are_in(other, own, cosine));
}
