/* wholes: find the facets of second order of a surface, and divide them. */
#include "shape/surface.h"
#include "shape/wholes.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/cell.h"
#include "topology/cells.h"
#include "topology/points.h"
#include "topology/topology.h"

#include <stdlib.h>
#include <string.h>

/** Node of second order of elements, with all that it is between on the surface. */
typedef struct mid_of {
    int32_t end[4]; /* corners: own numbers, ascending; -1 behind those of an edge */
    int32_t mid;    /* the mesh's number */
    int is_curved;
} mid_of;

typedef struct mids {
    mid_of *item; /* [n] ascending */
    int64_t n, room;
} mids;

static int compare_ends(const int32_t *a, const int32_t *b) {
    for (int i = 0; i < 4; i++)
        if (a[i] != b[i])
            return a[i] < b[i] ? -1 : 1;
    return 0;
}

static int compare_mids(const void *a, const void *b) {
    const mid_of *s = a, *t = b;
    const int order = compare_ends(s->end, t->end);
    return order ? order : (s->mid > t->mid) - (s->mid < t->mid);
}

/** Set end to n corners, ascending. */
static void sort_ends(const int32_t *corner, int n, int32_t end[4]) {
    for (int i = 0; i < 4; i++) {
        int at = i;
        end[i] = -1;
        for (; i < n && at > 0 && end[at - 1] > corner[i]; at--)
            end[at] = end[at - 1];
        end[at] = i < n ? corner[i] : -1;
    }
}

/** Set end to the corners that a node of a cell is between; 0: some are not on the surface. */
static int find_ends(const pl_cell_type *type, const int32_t *node, int i, const int32_t *number,
                     int32_t end[4]) {
    const uint8_t parents = pl_cell_parents(type, i);
    int32_t corner[4];
    int n = 0;
    if (__builtin_popcount(parents) > 4)
        return 0;
    for (int j = 0; j < type->shape->n_corners; j++)
        if (parents >> j & 1) {
            corner[n] = number[node[j]];
            if (corner[n++] < 0)
                return 0;
        }
    sort_ends(corner, n, end);
    return 1;
}

/** Add the mids of an element that are between corners on the surface. Returns 0 without memory. */
static int add_mids(const planish_mesh *mesh, int64_t cell, const int32_t *number, mids *all) {
    const pl_cell_type *type = pl_cell_type_of(mesh->cells->type[cell]);
    const int32_t *node = mesh->cells->node + mesh->cells->offset[cell];
    if (!type || type->shape->dim != 3 || type->order == 1)
        return 1;
    const int first = type->shape->n_corners;
    int n_on = 0;
    for (int j = 0; j < first; j++)
        n_on += number[node[j]] >= 0;
    const int curved = n_on >= 2 ? pl_curved_edges(mesh, cell, 0) : 0;
    for (int j = first; n_on >= 2 && j < type->n_nodes; j++) {
        mid_of item = {{0}, node[j], curved >> (j - first) & 1};
        if (node[j] >= 0 && find_ends(type, node, j, number, item.end) &&
            !pl_append(&all->item, &all->n, &all->room, &item, sizeof item))
            return 0;
    }
    return 1;
}

/** List the mids between corners on the surface, each once. Returns 0 without memory. */
static int list_mids(const planish_mesh *mesh, const pl_surface *s, mids *all) {
    for (int64_t i = 0; i < mesh->cells->n; i++)
        if (!add_mids(mesh, i, s->number, all))
            return 0;
    if (all->n > 0)
        qsort(all->item, (size_t)all->n, sizeof *all->item, compare_mids);
    int64_t n = 0;
    for (int64_t i = 0; i < all->n; i++)
        if (n == 0 || compare_mids(&all->item[i], &all->item[n - 1]) != 0)
            all->item[n++] = all->item[i];
    all->n = n;
    return 1;
}

/** Find the first mid between n corners; *count: how many there are. */
static const mid_of *find_mid(const mids *all, const int32_t *corner, int n, int *count) {
    mid_of key = {{0}, -1, 0};
    sort_ends(corner, n, key.end);
    int64_t low = 0, high = all->n;
    while (low < high) {
        const int64_t middle = (low + high) / 2;
        const int is_below = compare_mids(&all->item[middle], &key) < 0;
        *(is_below ? &low : &high) = is_below ? middle + 1 : middle;
    }
    *count = 0;
    for (int64_t i = low; i < all->n && compare_ends(all->item[i].end, key.end) == 0; i++)
        ++*count;
    return *count > 0 ? all->item + low : NULL;
}

/** Find the mids of a facet with corners, by the mesh's numbers. Returns whether it is curved. */
static int find_mids(const mids *all, pl_whole *whole) {
    const int n = whole->n_corners;
    int n_edges = 0, n_found = 0, curved = 0, count;
    for (int k = 0; k < n; k++) {
        const int32_t end[2] = {whole->node[k], whole->node[(k + 1) % n]};
        const mid_of *mid = find_mid(all, end, 2, &count);
        n_edges += count == 1;
        n_found += count;
        curved |= mid && mid->is_curved;
        whole->node[n + k] = mid ? mid->mid : -1;
    }
    const int has_mids = n_edges == n && n_found == n;
    whole->n_nodes = (uint8_t)(has_mids ? 2 * n : n);
    whole->is_held = n_found > 0 && !has_mids;
    const mid_of *centre = has_mids && n == 4 ? find_mid(all, whole->node, 4, &count) : NULL;
    if (centre) {
        whole->node[whole->n_nodes++] = centre->mid;
        curved |= centre->is_curved;
    }
    whole->n_parts = has_mids ? (uint8_t)(n == 3 ? 4 : centre ? 8 : 6) : (uint8_t)(n - 2);
    return has_mids && curved;
}

/** Set the corners of the facet that begins with triangle f, one after the other: a quadrilateral is two
 *  triangles that share two corners, the first and third one. */
static void find_corners(const pl_surface *s, int64_t f, pl_whole *whole) {
    const int32_t *v = s->facet + 3 * f, *w = v + 3;
    *whole = (pl_whole){.node = {v[0], v[1], v[2]}, .n_corners = 3};
    if (!s->half || s->half[f] != 1)
        return;
    int32_t shared[3] = {v[0], v[1], v[2]}, n = 0; /* as many as are found */
    whole->n_corners = 4;
    for (int k = 0; k < 3; k++) {
        if (v[k] == w[0] || v[k] == w[1] || v[k] == w[2])
            shared[n++] = v[k];
        else
            whole->node[1] = v[k];
        if (w[k] != v[0] && w[k] != v[1] && w[k] != v[2])
            whole->node[3] = w[k];
    }
    whole->node[0] = shared[0];
    whole->node[2] = shared[1];
}

/** Find all facets with their mids. Returns whether some are of second order and curved. */
static int find_wholes(pl_surface *s, const mids *all) {
    int any = 0;
    int64_t n_parts = 0;
    for (int64_t f = 0; f < s->n_facets; f++) {
        if (s->half && s->half[f] == 2)
            continue;
        pl_whole *whole = &s->whole[s->n_wholes++];
        find_corners(s, f, whole);
        any |= find_mids(all, whole);
        whole->first = (int32_t)f; /* for the label, until it is divided */
        n_parts += whole->n_parts;
    }
    return any && n_parts < INT32_MAX;
}

/** Number the nodes anew, with the mids, in the order of the mesh. */
static int number_nodes(const planish_mesh *mesh, pl_surface *s) {
    const pl_points points = pl_points_of(mesh, mesh->coordinates);
    int32_t *corner = s->node, n = 0;
    for (int64_t i = 0; i < s->n_wholes; i++) {
        pl_whole *whole = &s->whole[i];
        for (int k = 0; k < whole->n_nodes; k++) {
            if (k < whole->n_corners)
                whole->node[k] = corner[whole->node[k]];
            s->number[whole->node[k]] = 0;
        }
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
    for (int64_t i = 0; i < s->n_wholes; i++)
        for (int k = 0; k < s->whole[i].n_nodes; k++)
            s->whole[i].node[k] = s->number[s->whole[i].node[k]];
    pl_free(s->node);
    pl_free(s->x);
    s->node = node;
    s->x = x;
    s->n_nodes = n;
    return node && x;
}

/** List the mids of the facets' edges, whose nodes have their new numbers. */
static int list_own_mids(pl_surface *s) {
    mids all = {.n = 0};
    int done = 1;
    for (int64_t f = 0; done && f < s->n_wholes; f++) {
        const pl_whole *whole = &s->whole[f];
        const int n = whole->n_corners;
        for (int k = 0; done && k < n && pl_whole_has_mids(whole); k++) {
            const int32_t end[2] = {whole->node[k], whole->node[(k + 1) % n]};
            mid_of item = {{0}, whole->node[n + k], 0};
            sort_ends(end, 2, item.end);
            done = pl_append(&all.item, &all.n, &all.room, &item, sizeof item) != NULL;
        }
    }
    if (done && all.n > 0)
        qsort(all.item, (size_t)all.n, sizeof *all.item, compare_mids);
    s->mid = done ? pl_alloc(all.n, sizeof *s->mid) : NULL;
    for (int64_t i = 0; s->mid && i < all.n; i++)
        if (i == 0 || compare_mids(&all.item[i], &all.item[i - 1]) != 0) {
            int32_t *mid = s->mid[s->n_mids++];
            mid[0] = all.item[i].end[0];
            mid[1] = all.item[i].end[1];
            mid[2] = all.item[i].mid;
        }
    pl_free(all.item);
    return s->mid != NULL;
}

/** Let the line between opposite mids that divides a facet of eight nodes be the shorter one. */
static void turn(const pl_surface *s, pl_whole *whole) {
    const pl_whole was = *whole;
    const int32_t *v = whole->node;
    const double *x = s->x;
    if (whole->n_nodes != 8 || !(pl_distance(3, x + 3 * (int64_t)v[5], x + 3 * (int64_t)v[7]) <
                                 pl_distance(3, x + 3 * (int64_t)v[4], x + 3 * (int64_t)v[6])))
        return;
    for (int k = 0; k < 8; k++)
        whole->node[k] = was.node[k / 4 * 4 + (k + 1) % 4];
}

/** Divide all facets. Returns 0 without memory. */
static int divide(pl_surface *s) {
    int64_t n = 0;
    for (int64_t i = 0; i < s->n_wholes; i++)
        n += s->whole[i].n_parts;
    int32_t *facet = pl_alloc(3 * n, sizeof *facet), *apex = pl_alloc(n, sizeof *apex);
    pl_label *label = pl_alloc(n, sizeof *label);
    s->n_facets = 0;
    for (int64_t i = 0; facet && apex && label && i < s->n_wholes; i++) {
        pl_whole *whole = &s->whole[i];
        const int32_t from = whole->first;
        const uint8_t(*part)[3] = pl_whole_parts(whole);
        turn(s, whole);
        whole->first = (int32_t)s->n_facets;
        for (int k = 0; k < whole->n_parts; k++) {
            const int64_t f = s->n_facets++;
            label[f] = s->label[from];
            apex[f] = s->apex[from];
            for (int j = 0; j < 3; j++)
                facet[3 * f + j] = whole->node[part[k][j]];
        }
    }
    pl_free(s->facet);
    pl_free(s->apex);
    pl_free(s->label);
    pl_free(s->half);
    s->facet = facet;
    s->apex = apex;
    s->label = label;
    s->half = NULL;
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

/** Forget the facets of second order. */
static void forget(pl_surface *s) {
    pl_free(s->whole);
    s->whole = NULL;
    s->n_wholes = 0;
}

int pl_surface_divide(const planish_mesh *mesh, pl_surface *s, planish_error *error) {
    mids all = {.n = 0};
    s->whole = pl_alloc(s->n_facets, sizeof *s->whole);
    int done = s->whole && list_mids(mesh, s, &all);
    const int is_curved = done && find_wholes(s, &all);
    pl_free(all.item);
    if (is_curved)
        done = number_nodes(mesh, s) && list_own_mids(s) && divide(s) && list_facets(s);
    if (!is_curved || !done)
        forget(s);
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
