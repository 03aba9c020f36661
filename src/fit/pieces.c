/* pieces: what the outside of a shape consists of.
 *
 * A piece is closed if each of its edges is passed as often one way as the other. It has a body inside, unless it is a
 * hollow (hollows.h). */
#include "fit/pieces.h"

#include "base/joined.h"
#include "base/memory.h"
#include "base/status.h"

#include <string.h>

/** Facets of the outside at an edge. */
typedef struct around {
    int n;
    int32_t facet[2]; /* the first ones */
} around;

static int is_forwards(const planish_shape *s, int32_t facet, int32_t a, int32_t b) {
    return s->facet[facet][(pl_corner_at(s, facet, a) + 1) % 3] == b;
}

static int has_node(const planish_shape *s, int32_t facet, int32_t node) {
    const int32_t *v = s->facet[facet];
    return v[0] == node || v[1] == node || v[2] == node;
}

/** Of both ends of an edge, set *a to that with fewer facets. */
static void sort_ends(const planish_shape *s, int32_t *a, int32_t *b) {
    const int32_t t = *a;
    if (s->offset[*a + 1] - s->offset[*a] <= s->offset[*b + 1] - s->offset[*b])
        return;
    *a = *b;
    *b = t;
}

/** Join the two outer facets at each feature, if they turn alike; other edges join theirs anyway. */
static void join_facets(const planish_shape *s, int32_t *parent) {
    for (int32_t f = 0; f < s->n_facets; f++)
        for (int k = 0; k < 3; k++)
            if (s->across[f][k] > f)
                pl_join(parent, f, s->across[f][k]);
    for (int64_t e = 0; e < s->n_edges; e++) {
        int32_t a = s->edge[e][0], b = s->edge[e][1];
        around at = {.n = 0};
        sort_ends(s, &a, &b);
        for (uint32_t i = s->offset[a]; i < s->offset[a + 1]; i++) {
            const int32_t f = s->facet_of[i];
            if (!pl_fit_is_outer(s, f) || !has_node(s, f, b))
                continue;
            if (at.n < 2)
                at.facet[at.n] = f;
            at.n++;
        }
        if (at.n == 2 && is_forwards(s, at.facet[0], a, b) != is_forwards(s, at.facet[1], a, b))
            pl_join(parent, at.facet[0], at.facet[1]);
    }
}

/** Number the pieces by their lowest facets. */
static void number_pieces(const planish_shape *s, int32_t *parent, pl_fit_pieces *pieces) {
    for (int32_t f = 0; f < s->n_facets; f++) {
        const int32_t first = pl_class_of(parent, f);
        if (!pl_fit_is_outer(s, f))
            pieces->of[f] = -1;
        else
            pieces->of[f] = first == f ? pieces->n++ : pieces->of[first];
    }
}

/** Return how much oftener the facets of a piece pass an edge of facet f forwards than backwards. */
static int excess_at(const planish_shape *s, const pl_fit_pieces *pieces, int32_t f, int k) {
    int32_t a = s->facet[f][k], b = s->facet[f][(k + 1) % 3];
    int sum = 0;
    sort_ends(s, &a, &b);
    for (uint32_t i = s->offset[a]; i < s->offset[a + 1]; i++) {
        const int32_t g = s->facet_of[i];
        if (pieces->of[g] == pieces->of[f] && has_node(s, g, b))
            sum += is_forwards(s, g, a, b) ? 1 : -1;
    }
    return sum;
}

/** Add six times the volume of the pyramid from a piece's first node to a facet, and its area. */
static void measure_facet(const planish_shape *s, pl_fit_pieces *pieces, int32_t f,
                          double *volume) {
    const int32_t piece = pieces->of[f];
    const double *from = s->x[s->facet[pieces->first[piece]][0]];
    double a[3], b[3], to[3], across[3];
    pl_from_to(3, s->x[s->facet[f][0]], s->x[s->facet[f][1]], a);
    pl_from_to(3, s->x[s->facet[f][0]], s->x[s->facet[f][2]], b);
    pl_from_to(3, from, s->x[s->facet[f][0]], to);
    pl_cross(a, b, across);
    volume[piece] += pl_dot(3, to, across);
    pieces->area[piece] += pl_length(across) / 2;
    for (int k = 0; k < 3; k++)
        for (int d = 0; d < 3; d++) {
            pl_box3 *box = &pieces->box[piece];
            const double x = s->x[s->facet[f][k]][d];
            box->lower[d] = fmin(box->lower[d], x);
            box->upper[d] = fmax(box->upper[d], x);
        }
}

/** Measure the pieces, find which are closed, and turn these to have a body inside. volume [n]. */
static void measure_pieces(const planish_shape *s, pl_fit_pieces *pieces, double *volume) {
    for (int32_t i = 0; i < pieces->n; i++) {
        volume[i] = 0;
        pieces->first[i] = -1;
        pieces->is_closed[i] = 1;
        pieces->box[i] =
            (pl_box3){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    }
    for (int32_t f = 0; f < s->n_facets; f++) {
        const int32_t piece = pieces->of[f];
        if (piece < 0)
            continue;
        if (pieces->first[piece] < 0)
            pieces->first[piece] = f;
        measure_facet(s, pieces, f, volume);
        for (int k = 0; k < 3 && pieces->is_closed[piece]; k++)
            pieces->is_closed[piece] = s->across[f][k] >= 0 || excess_at(s, pieces, f, k) == 0;
    }
    for (int32_t i = 0; i < pieces->n; i++) {
        pieces->is_closed[i] = pieces->is_closed[i] && volume[i] != 0;
        pieces->turn[i] = pieces->outward[i] = pieces->is_closed[i] && volume[i] < 0 ? -1 : 1;
    }
}

int pl_fit_find_pieces(const planish_shape *s, pl_fit_pieces *pieces, planish_error *error) {
    int32_t *parent = pl_alloc(s->n_facets, sizeof *parent);
    double *volume = NULL;
    *pieces = (pl_fit_pieces){.of = pl_alloc(s->n_facets, sizeof *pieces->of)};
    int have = parent && pieces->of;
    for (int32_t f = 0; have && f < s->n_facets; f++)
        parent[f] = f;
    if (have) {
        join_facets(s, parent);
        number_pieces(s, parent, pieces);
        volume = pl_alloc(pieces->n, sizeof *volume);
        pieces->first = pl_alloc(pieces->n, sizeof *pieces->first);
        pieces->is_closed = pl_alloc(pieces->n, 1);
        pieces->outward = pl_alloc(pieces->n, 1);
        pieces->turn = pl_alloc(pieces->n, 1);
        pieces->area = pl_alloc_zero(pieces->n, sizeof *pieces->area);
        pieces->box = pl_alloc(pieces->n, sizeof *pieces->box);
        have = volume && pieces->first && pieces->is_closed && pieces->outward && pieces->turn &&
               pieces->area && pieces->box;
    }
    if (have)
        measure_pieces(s, pieces, volume);
    pl_free(parent);
    pl_free(volume);
    return have ? PLANISH_OK : pl_fail_memory(error, "the pieces of a surface");
}

void pl_fit_free_pieces(pl_fit_pieces *pieces) {
    pl_free(pieces->of);
    pl_free(pieces->first);
    pl_free(pieces->is_closed);
    pl_free(pieces->outward);
    pl_free(pieces->turn);
    pl_free(pieces->nest);
    pl_free(pieces->area);
    pl_free(pieces->box);
    *pieces = (pl_fit_pieces){.n = 0};
}
