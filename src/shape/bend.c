/* bend: the tangents and normals that a shape has at its nodes. */
#include "shape/bend.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"

#include <string.h>

enum { CHUNK = 512 }; /* nodes that one thread takes at a time */

/* ---- tangents -------------------------------------------------------------------------------- */

/** Compute the unit tangent of a curve where two of its edges meet, towards the end of the second: that of the
 *  parabola through their nodes. */
static void tangent_between(const planish_shape *s, int32_t from, int32_t node, int32_t to,
                            double tangent[3]) {
    double in[3], out[3];
    pl_from_to(3, s->x[from], s->x[node], in);
    pl_from_to(3, s->x[node], s->x[to], out);
    const double l = pl_length(in), m = pl_length(out);
    for (int d = 0; d < 3; d++)
        in[d] = in[d] * (m / l) + out[d] * (l / m);
    pl_unit(3, in, tangent);
}

/** Compute the tangents of an edge at its nodes on curves; the chord at others. */
static void find_tangents(planish_shape *s, int32_t e) {
    for (int j = 0; j < 2; j++) {
        const int32_t node = s->edge[e][j], to = s->edge[e][!j], *at = s->edge_at[node];
        double chord[3];
        pl_from_to(3, s->x[node], s->x[to], chord);
        memset(s->tangent[e][j], 0, sizeof s->tangent[e][j]);
        pl_unit(3, chord, s->tangent[e][j]);
        if (s->node_class[node] != PL_ON_CURVE)
            continue;
        const int32_t before = at[at[0] == e];
        tangent_between(s, s->edge[before][s->edge[before][0] == node], node, to, s->tangent[e][j]);
    }
}

/** Set the tangent at the end of a curve so that its last arc is symmetric. */
static void mirror_tangent(planish_shape *s, int32_t e) {
    for (int j = 0; j < 2; j++) {
        if (s->node_class[s->edge[e][j]] == PL_ON_CURVE ||
            s->node_class[s->edge[e][!j]] != PL_ON_CURVE)
            continue;
        double chord[3];
        memcpy(chord, s->tangent[e][j], sizeof chord);
        const double *there = s->tangent[e][!j];
        const double twice = -2 * pl_dot(3, chord, there);
        for (int d = 0; d < 3; d++)
            s->tangent[e][j][d] = twice * chord[d] + there[d];
    }
}

static void bend_edges(void *context, int64_t begin, int64_t end, int thread) {
    planish_shape *s = ((pl_features *)context)->shape;
    (void)thread;
    for (int64_t e = begin; e < end; e++) {
        find_tangents(s, (int32_t)e);
        mirror_tangent(s, (int32_t)e);
    }
}

/* ---- normals at corners ----------------------------------------------------------------------- */

/** Add what a facet says of the normal at its corner k. Summed over a closed fan it is the normal of
 *  a sphere through the nodes. */
static void add_normal(const planish_shape *s, int32_t f, int k, double sum[3]) {
    const int32_t *v = s->facet[f];
    double a[3], b[3], normal[3];
    pl_from_to(3, s->x[v[k]], s->x[v[(k + 1) % 3]], a);
    pl_from_to(3, s->x[v[k]], s->x[v[(k + 2) % 3]], b);
    const double square = pl_dot(3, a, a) * pl_dot(3, b, b);
    pl_cross(a, b, normal);
    for (int d = 0; d < 3 && square > 0; d++)
        sum[d] += normal[d] / square;
}

/** Remove from a normal, at a node on a curve, what it has along that. */
static void make_square(const planish_shape *s, int32_t node, double normal[3]) {
    const int32_t e = s->edge_at[node][0];
    const double *tangent = s->tangent[e][s->edge[e][1] == node];
    const double along = pl_dot(3, normal, tangent);
    double rest[3];
    for (int d = 0; d < 3; d++)
        rest[d] = normal[d] - along * tangent[d];
    if (along * along < 0.5)
        pl_unit(3, rest, normal);
}

/** Compute the normal of the fan at a node that has facet f, and write it to all of its corners there. */
static void bend_fan(const pl_features *w, int32_t node, int32_t f) {
    planish_shape *s = w->shape;
    int32_t first = f;
    int k = pl_corner_at(s, f, node), is_closed = 0;
    while (!is_closed && pl_fan_next(w, PL_EDGE_APART, 0, &first, &k))
        is_closed = first == f;
    double sum[3] = {0}, normal[3];
    int32_t at = first;
    const int begin = k;
    do
        add_normal(s, at, k, sum);
    while (pl_fan_next(w, PL_EDGE_APART, 1, &at, &k) && at != first);
    if (!pl_unit(3, sum, normal))
        memcpy(normal, w->normal[f], sizeof normal);
    if (!is_closed && s->node_class[node] == PL_ON_CURVE)
        make_square(s, node, normal);
    at = first;
    k = begin;
    do
        memcpy(w->corner_normal[at][k], normal, sizeof normal);
    while (pl_fan_next(w, PL_EDGE_APART, 1, &at, &k) && at != first);
}

static void bend_nodes(void *context, int64_t begin, int64_t end, int thread) {
    const pl_features *w = context;
    const planish_shape *s = w->shape;
    (void)thread;
    for (int64_t node = begin; node < end; node++)
        for (int64_t i = s->offset[node]; i < s->offset[node + 1]; i++) {
            const int32_t f = s->facet_of[i];
            const double *n = w->corner_normal[f][pl_corner_at(s, f, (int32_t)node)];
            if (n[0] == 0 && n[1] == 0 && n[2] == 0)
                bend_fan(w, (int32_t)node, f);
        }
}

void pl_shape_bend(pl_features *w) {
    pl_parallel_for(w->threads, w->shape->n_edges, CHUNK, bend_edges, w);
    pl_parallel_for(w->threads, w->shape->n_nodes, CHUNK, bend_nodes, w);
}

/** Whether all facets of a node have the same normal there. */
static int has_one_normal(const pl_features *w, int32_t node) {
    const planish_shape *s = w->shape;
    const int32_t *at = s->facet_of + s->offset[node];
    const double *first = w->corner_normal[at[0]][pl_corner_at(s, at[0], node)];
    for (int64_t i = 1; i < s->offset[node + 1] - s->offset[node]; i++)
        for (int d = 0; d < 3; d++)
            if (w->corner_normal[at[i]][pl_corner_at(s, at[i], node)][d] != first[d])
                return 0;
    return 1;
}

int pl_shape_pack_normals(pl_features *w, planish_error *error) {
    planish_shape *s = w->shape;
    uint32_t n = 0;
    s->normal_at = pl_alloc(s->n_nodes + 1, sizeof *s->normal_at);
    for (int32_t node = 0; s->normal_at && node < s->n_nodes; node++) {
        s->normal_at[node] = n;
        n += has_one_normal(w, node) ? 1 : (uint32_t)(s->offset[node + 1] - s->offset[node]);
    }
    s->corner_normal = s->normal_at ? pl_alloc(n, sizeof *s->corner_normal) : NULL;
    if (!s->corner_normal)
        return pl_fail_memory(error, "the shape");
    s->normal_at[s->n_nodes] = n;
    for (int32_t node = 0; node < s->n_nodes; node++)
        for (uint32_t i = 0; i < s->normal_at[node + 1] - s->normal_at[node]; i++) {
            const int32_t f = s->facet_of[s->offset[node] + i];
            memcpy(s->corner_normal[s->normal_at[node] + i],
                   w->corner_normal[f][pl_corner_at(s, f, node)], sizeof *s->corner_normal);
        }
    return PLANISH_OK;
}
