/* creases: the edges that are features by their bend alone. docs/surfaces.md has the rules. */
#include "shape/creases.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/arc_cosine.h"

#include <stdlib.h>
#include <string.h>

static const double PI = 3.1415926535897932385;
/* Facets that turn by more have a feature between them: the cosine of 40 degrees, but for rounding: a
 * cylinder of nine sides turns by so much. */
static const double COS_BEND = 0.76604444311897803520 - 0x1p-30;
/* An isolated crease turns by more: 5 degrees, */
static const double COS_LEAST_CREASE = 0.99619469809174553230;
/* and around it the surface turns by less than this fraction of that. */
static const double CALM = 0.4;
/* Creases that turn by less than 60 degrees may be noise. */
static const double COS_SLIGHT = 0.5;
/* At hubs one facet stands for all whose normals agree to 0.4 degrees. */
enum { NORMALS_APART = 256 };

/* ---- nodes of very many facets ---------------------------------------------------------------- */

/** Normal of a facet, rounded. */
typedef struct rounded {
    int32_t normal[3], facet;
} rounded;

static int compare_normals(const void *a, const void *b) {
    const rounded *s = a, *t = b;
    for (int d = 0; d < 3; d++)
        if (s->normal[d] != t->normal[d])
            return s->normal[d] > t->normal[d] ? 1 : -1;
    return (s->facet > t->facet) - (s->facet < t->facet);
}

/** Write facets of a node to list, one for each rounded normal. Returns how many. */
static int64_t list_apart(const pl_features *w, int64_t node, rounded *work, int32_t *list) {
    const planish_shape *s = w->shape;
    const int32_t *facet = s->facet_of + s->offset[node];
    const int64_t n = s->offset[node + 1] - s->offset[node];
    int64_t n_apart = 0;
    for (int64_t i = 0; i < n; i++) {
        work[i].facet = facet[i];
        for (int d = 0; d < 3; d++)
            work[i].normal[d] = (int32_t)floor(NORMALS_APART * w->normal[facet[i]][d]);
    }
    qsort(work, (size_t)n, sizeof *work, compare_normals);
    for (int64_t i = 0; i < n; i++)
        if (i == 0 || memcmp(work[i].normal, work[i - 1].normal, sizeof work->normal) != 0)
            list[n_apart++] = work[i].facet;
    return n_apart;
}

int pl_creases_begin(pl_features *w, planish_error *error) {
    const planish_shape *s = w->shape;
    int64_t most = 0, all = 0, n = 0;
    for (int64_t i = 0; i < s->n_nodes; i++)
        if (pl_is_hub(s, i)) {
            const int64_t n_facets = s->offset[i + 1] - s->offset[i];
            most = n_facets > most ? n_facets : most;
            all += n_facets;
            n++;
        }
    rounded *work = pl_alloc(most, sizeof *work);
    w->hub = pl_alloc_zero(n + 1, sizeof *w->hub);
    w->hub_facet = pl_alloc(all, sizeof *w->hub_facet);
    const int failed = !work || !w->hub || !w->hub_facet;
    for (int64_t i = 0; !failed && i < s->n_nodes; i++)
        if (pl_is_hub(s, i)) {
            pl_hub *h = w->hub + w->n_hubs++;
            h->node = (int32_t)i;
            h[1].first = h->first + list_apart(w, i, work, w->hub_facet + h->first);
        }
    pl_free(work);
    return failed ? pl_fail_memory(error, "the surface") : PLANISH_OK;
}

static int compare_hubs(const void *node, const void *hub) {
    const int32_t a = *(const int32_t *)node, b = ((const pl_hub *)hub)->node;
    return (a > b) - (a < b);
}

/** Return facets that have all normals at a node. */
static const int32_t *facets_at(const pl_features *w, int32_t node, int64_t *n) {
    const planish_shape *s = w->shape;
    *n = s->offset[node + 1] - s->offset[node];
    if (!pl_is_hub(s, node))
        return s->facet_of + s->offset[node];
    const pl_hub *h = bsearch(&node, w->hub, (size_t)w->n_hubs, sizeof *h, compare_hubs);
    *n = h[1].first - h->first;
    return w->hub_facet + h->first;
}

/* ---- one edge --------------------------------------------------------------------------------- */

/** Whether the surface at the node opposite an edge of f turns by less than angle from f. Facets beyond
 *  a feature do not count. */
static int is_calm(const pl_features *w, int32_t f, int k, double angle) {
    const planish_shape *s = w->shape;
    int64_t n;
    const int32_t *facet = facets_at(w, s->facet[f][(k + 2) % 3], &n);
    for (int64_t i = 0; i < n; i++) {
        const double cosine = pl_dot(3, w->normal[f], w->normal[facet[i]]);
        if (cosine > COS_BEND && !(pl_arc_cosine(cosine) < angle))
            return 0;
    }
    return 1;
}

int pl_is_crease(const pl_features *w, int32_t f, int k, double cosine) {
    const double given = w->tags ? w->tags->crease_angle : 0;
    if (given > 0)
        return pl_arc_cosine(cosine) > given * (PI / 180);
    if (!(cosine > COS_BEND))
        return 1;
    if (cosine > COS_LEAST_CREASE || w->kind[f][k] & PL_EDGE_DIAGONAL)
        return 0;
    const double angle = CALM * pl_arc_cosine(cosine);
    return is_calm(w, f, k, angle) && is_calm(w, w->beside[f][k], pl_edge_beside(w, f, k), angle);
}

/* ---- short chains ----------------------------------------------------------------------------- */

/* What ends at a node: one slight crease, two, or more, or another feature, too. */
enum { ENDS = 1, GOES_ON = 2, BRANCHES = 3 };

/** Edge k of a facet. */
typedef struct facet_edge {
    int32_t facet;
    int k, is_short;
} facet_edge;

/** Whether an edge is a feature by a bend of at most 60 degrees alone. */
static int is_slight(const pl_features *w, int32_t f, int k) {
    return w->kind[f][k] & PL_EDGE_CREASE &&
           pl_dot(3, w->normal[f], w->normal[w->beside[f][k]]) > COS_SLIGHT;
}

/** Count what ends at each node, and list the slight creases, each once; edge NULL: count these. Returns
 *  how many. */
static int64_t list_slight(const pl_features *w, uint8_t *at, facet_edge *edge) {
    const planish_shape *s = w->shape;
    int64_t n = 0;
    for (int64_t i = 0; i < s->n_facets; i++)
        for (int k = 0; k < 3; k++) {
            const int32_t f = (int32_t)i, *ends[] = {&s->facet[f][k], &s->facet[f][(k + 1) % 3]};
            const int slight = is_slight(w, f, k);
            if (!(w->kind[f][k] & PL_EDGE_FEATURE) || (slight && w->beside[f][k] < f))
                continue;
            for (int j = 0; at && j < 2; j++) {
                uint8_t *count = &at[*ends[j]];
                *count = (uint8_t)(!slight ? BRANCHES : *count < BRANCHES ? *count + 1 : *count);
            }
            if (slight && edge)
                edge[n] = (facet_edge){f, k, 0};
            n += slight;
        }
    return n;
}

/** Return the other end of the second slight crease at a node. */
static int32_t beyond(const pl_features *w, int32_t node, int32_t from) {
    const planish_shape *s = w->shape;
    for (int64_t i = s->offset[node]; i < s->offset[node + 1]; i++) {
        const int32_t f = s->facet_of[i];
        const int k = pl_corner_at(s, f, node), before = (k + 2) % 3;
        if (s->facet[f][(k + 1) % 3] != from && w->kind[f][k] & PL_EDGE_FEATURE)
            return s->facet[f][(k + 1) % 3];
        if (s->facet[f][before] != from && w->kind[f][before] & PL_EDGE_FEATURE)
            return s->facet[f][before];
    }
    return from;
}

/** Whether an edge is of a chain of one or two slight creases that ends in the smooth surface. */
static int is_short(const pl_features *w, const uint8_t *at, const facet_edge *edge) {
    const int32_t *v = w->shape->facet[edge->facet];
    int32_t a = v[edge->k], b = v[(edge->k + 1) % 3];
    if (at[a] == GOES_ON)
        a = beyond(w, a, b);
    else if (at[b] == GOES_ON)
        b = beyond(w, b, a);
    return at[a] != GOES_ON && at[b] != GOES_ON && (at[a] == ENDS || at[b] == ENDS);
}

/** Make smooth edges of the short ones of n slight creases. Returns how many creases stay. */
static int64_t prune_once(pl_features *w, const uint8_t *at, facet_edge *edge, int64_t n) {
    int64_t n_stay = 0;
    for (int64_t i = 0; i < n; i++)
        edge[i].is_short = is_short(w, at, &edge[i]);
    for (int64_t i = 0; i < n; i++) {
        const int32_t f = edge[i].facet, g = w->beside[f][edge[i].k];
        const int m = pl_edge_beside(w, f, edge[i].k);
        if (edge[i].is_short)
            w->kind[f][edge[i].k] = w->kind[g][m] = 0;
        else
            edge[n_stay++] = edge[i];
    }
    return n_stay;
}

int pl_creases_prune(pl_features *w, planish_error *error) {
    const int64_t n_nodes = w->shape->n_nodes;
    int64_t n = list_slight(w, NULL, NULL), before = n + 1;
    if (n == 0 || (w->tags && w->tags->crease_angle > 0))
        return PLANISH_OK;
    facet_edge *edge = pl_alloc(n, sizeof *edge);
    uint8_t *at = pl_alloc(n_nodes, 1);
    const int failed = !edge || !at;
    while (!failed && n < before) {
        memcpy(at, w->stays, (size_t)n_nodes);
        for (int64_t i = 0; i < n_nodes; i++)
            at[i] = at[i] ? BRANCHES : 0;
        before = list_slight(w, at, edge);
        n = prune_once(w, at, edge, before);
    }
    pl_free(edge);
    pl_free(at);
    return failed ? pl_fail_memory(error, "the surface") : PLANISH_OK;
}
