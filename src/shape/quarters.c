/* quarters: facets of second order, each as four triangles between its corners and mids.
 *
 * The surface is then one of triangles through all of its nodes. How far the curved facets are off
 * these is known by their mids (shape/curved.h: bend).
 */
#include "shape/surface.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/cell.h"
#include "topology/cells.h"
#include "topology/points.h"
#include "topology/topology.h"

#include <stdlib.h>
#include <string.h>

/** An edge of elements with both ends on the surface. */
typedef struct mid_edge {
    int32_t end[2], mid; /* ends: own numbers, ascending; mid: the mesh's number */
    int is_curved;
} mid_edge;

typedef struct mid_edges {
    mid_edge *edge; /* [n] ascending */
    int64_t n, room;
} mid_edges;

static int compare_edges(const void *a, const void *b) {
    const mid_edge *s = a, *t = b;
    if (s->end[0] != t->end[0])
        return s->end[0] < t->end[0] ? -1 : 1;
    if (s->end[1] != t->end[1])
        return s->end[1] < t->end[1] ? -1 : 1;
    return (s->mid > t->mid) - (s->mid < t->mid);
}

/** Add the edges of an element that have both ends on the surface. Returns 0 without memory. */
static int add_edges(const planish_mesh *mesh, int64_t cell, const int32_t *number,
                     mid_edges *all) {
    const pl_cell_type *type = pl_cell_type_of(mesh->cells->type[cell]);
    const int32_t *node = mesh->cells->node + mesh->cells->offset[cell];
    if (!pl_is_smoothed(mesh->cells, cell, 3) || type->order == 1)
        return 1;
    const int first = type->shape->n_corners;
    int n_on = 0;
    for (int j = 0; j < first; j++)
        n_on += number[node[j]] >= 0;
    const int curved = n_on >= 2 ? pl_curved_edges(mesh, cell, 0) : 0;
    for (int j = first; n_on >= 2 && j < first + type->shape->n_edges; j++) {
        const int32_t a = number[node[type->between[j][0]]], b = number[node[type->between[j][1]]];
        const mid_edge edge = {{a < b ? a : b, a < b ? b : a}, node[j], curved >> (j - first) & 1};
        if (a >= 0 && b >= 0 && node[j] >= 0 &&
            !pl_append(&all->edge, &all->n, &all->room, &edge, sizeof edge))
            return 0;
    }
    return 1;
}

/** List the edges with both ends on the surface, each once. Returns 0 without memory. */
static int list_edges(const planish_mesh *mesh, const pl_surface *s, mid_edges *all) {
    for (int64_t i = 0; i < mesh->cells->n; i++)
        if (!add_edges(mesh, i, s->number, all))
            return 0;
    if (all->n > 0)
        qsort(all->edge, (size_t)all->n, sizeof *all->edge, compare_edges);
    int64_t n = 0;
    for (int64_t i = 0; i < all->n; i++)
        if (n == 0 || compare_edges(&all->edge[i], &all->edge[n - 1]) != 0)
            all->edge[n++] = all->edge[i];
    all->n = n;
    return 1;
}

/** Find the edge with two ends; NULL: there is none, or more than one. */
static const mid_edge *find_edge(const mid_edges *all, int32_t a, int32_t b) {
    const mid_edge key = {{a < b ? a : b, a < b ? b : a}, -1, 0};
    int64_t low = 0, high = all->n;
    while (low < high) {
        const int64_t middle = (low + high) / 2;
        const int is_below = compare_edges(&all->edge[middle], &key) < 0;
        *(is_below ? &low : &high) = is_below ? middle + 1 : middle;
    }
    const mid_edge *found = all->edge + low;
    const int is_found = low < all->n && found->end[0] == key.end[0] && found->end[1] == key.end[1];
    const int is_alone =
        low + 1 >= all->n || found[1].end[0] != key.end[0] || found[1].end[1] != key.end[1];
    return is_found && is_alone ? found : NULL;
}

/** Find the corners and mids of all facets: whole, mids by the mesh's numbers. Returns whether all have
 *  mids, and some edge is curved. */
static int find_wholes(const pl_surface *s, const mid_edges *all, int32_t (*whole)[6]) {
    int any = 0;
    for (int64_t f = 0; f < s->n_facets; f++)
        for (int k = 0; k < 3; k++) {
            const int32_t *v = s->facet + 3 * f;
            const mid_edge *edge = find_edge(all, v[k], v[(k + 1) % 3]);
            if (!edge)
                return 0;
            whole[f][k] = v[k];
            whole[f][3 + k] = edge->mid;
            any |= edge->is_curved;
        }
    return any;
}

/** Number the nodes anew, with the mids, in the order of the mesh. */
static int number_nodes(const planish_mesh *mesh, int32_t (*whole)[6], pl_surface *s) {
    const int64_t n_facets = s->n_facets;
    const pl_points points = pl_points_of(mesh, mesh->coordinates);
    int32_t *corner = s->node, n = 0;
    for (int64_t f = 0; f < n_facets; f++)
        for (int k = 0; k < 3; k++) {
            whole[f][k] = corner[whole[f][k]];
            s->number[whole[f][3 + k]] = 0;
        }
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        s->number[i] = s->number[i] < 0 ? -1 : n++;
    int32_t *node = pl_alloc(n, sizeof *node);
    double *x = pl_alloc(3 * (int64_t)n, sizeof *x);
    for (int64_t i = 0; node && x && i < mesh->n_nodes; i++) {
        if (s->number[i] < 0)
            continue;
        node[s->number[i]] = (int32_t)i;
        for (int d = 0; d < 3; d++)
            x[3 * (int64_t)s->number[i] + d] =
                mesh->coordinates[pl_point_at(&points, i, d)] * s->scale;
    }
    for (int64_t f = 0; f < n_facets; f++)
        for (int k = 0; k < 6; k++)
            whole[f][k] = s->number[whole[f][k]];
    pl_free(s->node);
    pl_free(s->x);
    s->node = node;
    s->x = x;
    s->n_nodes = n;
    return node && x;
}

/** List the mids of the facets' edges, whose nodes have their new numbers. */
static int list_mids(pl_surface *s, const int32_t (*whole)[6]) {
    mid_edges all = {.n = 0};
    int done = 1;
    for (int64_t f = 0; done && f < s->n_facets; f++)
        for (int k = 0; done && k < 3; k++) {
            const int32_t a = whole[f][k], b = whole[f][(k + 1) % 3];
            const mid_edge edge = {{a < b ? a : b, a < b ? b : a}, whole[f][3 + k], 0};
            done = pl_append(&all.edge, &all.n, &all.room, &edge, sizeof edge) != NULL;
        }
    if (done && all.n > 0)
        qsort(all.edge, (size_t)all.n, sizeof *all.edge, compare_edges);
    s->mid = done ? pl_alloc(all.n, sizeof *s->mid) : NULL;
    for (int64_t i = 0; s->mid && i < all.n; i++)
        if (i == 0 || compare_edges(&all.edge[i], &all.edge[i - 1]) != 0) {
            int32_t *mid = s->mid[s->n_mids++];
            mid[0] = all.edge[i].end[0];
            mid[1] = all.edge[i].end[1];
            mid[2] = all.edge[i].mid;
        }
    pl_free(all.edge);
    return s->mid != NULL;
}

/** Divide all facets. Returns 0 without memory. */
static int divide(const int32_t (*whole)[6], pl_surface *s) {
    const int64_t n = s->n_facets;
    int32_t *facet = pl_alloc(12 * n, sizeof *facet), *apex = pl_alloc(4 * n, sizeof *apex);
    pl_label *label = pl_alloc(4 * n, sizeof *label);
    for (int64_t f = 0; facet && apex && label && f < n; f++) {
        const int32_t *v = whole[f];
        const int32_t quarter[4][3] = {
            {v[0], v[3], v[5]}, {v[1], v[4], v[3]}, {v[2], v[5], v[4]}, {v[3], v[4], v[5]}};
        memcpy(facet + 12 * f, quarter, sizeof quarter);
        for (int i = 0; i < 4; i++) {
            label[4 * f + i] = s->label[f];
            apex[4 * f + i] = s->apex[f];
        }
    }
    pl_free(s->facet);
    pl_free(s->apex);
    pl_free(s->label);
    s->facet = facet;
    s->apex = apex;
    s->label = label;
    s->n_facets = 4 * n;
    return facet && apex && label;
}

/** List the facets of each node anew. */
static int list_facets(pl_surface *s) {
    pl_free(s->offset);
    pl_free(s->facet_of);
    s->offset = pl_alloc_zero(s->n_nodes + 1, sizeof *s->offset);
    s->facet_of = pl_alloc(3 * s->n_facets, sizeof *s->facet_of);
    if (!s->offset || !s->facet_of)
        return 0;
    for (int64_t i = 0; i < 3 * s->n_facets; i++)
        s->offset[s->facet[i] + 1]++;
    for (int64_t i = 0, sum = 0; i < s->n_nodes; i++) {
        const int64_t count = s->offset[i + 1];
        s->offset[i + 1] = sum; /* where its facets begin, and end once they are listed */
        sum += count;
    }
    for (int64_t i = 0; i < 3 * s->n_facets; i++)
        s->facet_of[s->offset[s->facet[i] + 1]++] = (int32_t)(i / 3);
    return 1;
}

int pl_surface_quarter(const planish_mesh *mesh, pl_surface *s, planish_error *error) {
    mid_edges all = {.n = 0};
    int32_t(*whole)[6] = pl_alloc(s->n_facets, sizeof *whole);
    int done = whole && list_edges(mesh, s, &all);
    const int is_curved =
        done && s->n_facets > 0 && s->n_facets < INT32_MAX / 4 && find_wholes(s, &all, whole);
    pl_free(all.edge);
    if (is_curved)
        done = number_nodes(mesh, whole, s) && list_mids(s, (const int32_t(*)[6])whole) &&
               divide((const int32_t(*)[6])whole, s) && list_facets(s);
    if (is_curved && done)
        s->whole = whole;
    else
        pl_free(whole);
    return done ? PLANISH_OK : pl_fail_memory(error, "the facets of second order");
}

int32_t pl_mid_between(const pl_surface *surface, int32_t a, int32_t b) {
    const int32_t low_end = a < b ? a : b, high_end = a < b ? b : a;
    int64_t low = 0, high = surface->n_mids;
    while (low < high) {
        const int64_t middle = (low + high) / 2;
        const int32_t *mid = surface->mid[middle];
        if (mid[0] == low_end && mid[1] == high_end)
            return mid[2];
        const int is_below = mid[0] < low_end || (mid[0] == low_end && mid[1] < high_end);
        *(is_below ? &low : &high) = is_below ? middle + 1 : middle;
    }
    return -1;
}
