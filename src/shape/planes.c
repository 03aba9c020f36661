/* planes: which facets of a surface lie in one plane, and the edges where planes end.
 *
 * Two facets that share an edge, and no third one does, are coplanar if the far node of each lies
 * in the plane of the other. Classes of facets joined so are then looked at as a whole: three of
 * their nodes, as far apart as can be, say where the plane is, and if a node lies off it the class
 * is not planar (facets of a finely meshed cylinder join one by one, too).
 */
#include "shape/shape.h"

#include "base/memory.h"
#include "base/status.h"
#include "shape/vectors.h"

#include <stdlib.h>
#include <string.h>

/** An edge that the caller has tagged, by the surface's numbers. */
typedef struct tagged_edge {
    int32_t node[2], tag;
    int is_met;
} tagged_edge;

/** A facet at an edge that begins at the node under work. */
typedef struct spoke {
    int32_t end, facet;
} spoke;

typedef struct work {
    const pl_surface *surface;
    double tolerance;
    tagged_edge *tagged; /* [n_tagged] ascending by nodes */
    int64_t n_tagged;
    int32_t *parent; /* [n_facets] classes of coplanar facets */
    spoke *spoke;    /* [capacity] */
    int64_t capacity;
    pl_ridges *ridges;
} work;

/* ---- tagged edges ------------------------------------------------------------------------- */

static int compare_edges(const void *a, const void *b) {
    const tagged_edge *s = a, *t = b;
    for (int i = 0; i < 2; i++)
        if (s->node[i] != t->node[i])
            return s->node[i] < t->node[i] ? -1 : 1;
    return (s->tag > t->tag) - (s->tag < t->tag);
}

/** Sort those with both nodes on the surface; nodes of the others are fixed. An edge with two tags
 *  keeps the lower one. */
static int sort_tagged(work *w, const planish_surface *tags, uint8_t *is_fixed) {
    const int64_t n = tags ? tags->n_edges : 0;
    w->tagged = pl_alloc(n, sizeof *w->tagged);
    if (!w->tagged)
        return -1;
    int64_t kept = 0;
    for (int64_t i = 0; i < n; i++) {
        const int32_t *node = tags->edges + 2 * i;
        const int32_t a = w->surface->number[node[0]], b = w->surface->number[node[1]];
        if (a < 0 || b < 0)
            is_fixed[node[0]] = is_fixed[node[1]] = 1;
        else
            w->tagged[kept++] = (tagged_edge){.node = {a < b ? a : b, a < b ? b : a},
                                              .tag = tags->edge_tag ? tags->edge_tag[i] : 0};
    }
    if (kept > 0)
        qsort(w->tagged, (size_t)kept, sizeof *w->tagged, compare_edges);
    for (int64_t i = 0; i < kept; i++)
        if (i == 0 || memcmp(w->tagged[i].node, w->tagged[i - 1].node, sizeof w->tagged->node) != 0)
            w->tagged[w->n_tagged++] = w->tagged[i];
    return 0;
}

static tagged_edge *find_tagged(const work *w, int32_t a, int32_t b) {
    int64_t low = 0, high = w->n_tagged;
    while (low < high) {
        const int64_t middle = (low + high) / 2;
        tagged_edge *t = &w->tagged[middle];
        if (t->node[0] == a && t->node[1] == b)
            return t;
        if (t->node[0] < a || (t->node[0] == a && t->node[1] < b))
            low = middle + 1;
        else
            high = middle;
    }
    return NULL;
}

static void fix_strangers(const work *w, uint8_t *is_fixed) {
    for (int64_t i = 0; i < w->n_tagged; i++)
        for (int j = 0; j < 2 && !w->tagged[i].is_met; j++)
            is_fixed[w->surface->node[w->tagged[i].node[j]]] = 1;
}

/* ---- edges -------------------------------------------------------------------------------- */

/** The node of a facet that is not on its edge (a, b). */
static int32_t far_node(const pl_surface *surface, int32_t facet, int32_t a, int32_t b) {
    const int32_t *node = surface->facet + (int64_t)facet * 3;
    for (int j = 0; j < 2; j++)
        if (node[j] != a && node[j] != b)
            return node[j];
    return node[2];
}

/** Whether the far nodes c and d of two facets at the edge (a, b) lie in each other's planes, on
 *  different sides of the edge. Where a facet is low its plane is uncertain by as much more. */
static int are_coplanar(const work *w, int32_t a, int32_t b, int32_t c, int32_t d) {
    const double *x = w->surface->x, *from = x + 3 * (int64_t)a;
    double edge[3], to_c[3], to_d[3], over_c[3], over_d[3];
    pl_from_to(3, from, x + 3 * (int64_t)b, edge);
    pl_from_to(3, from, x + 3 * (int64_t)c, to_c);
    pl_from_to(3, from, x + 3 * (int64_t)d, to_d);
    pl_cross(edge, to_c, over_c);
    pl_cross(edge, to_d, over_d);
    const double length = pl_length(edge), area_c = pl_length(over_c), area_d = pl_length(over_d);
    if (!(length > 0 && area_c > 0 && area_d > 0) || !(pl_dot(3, over_c, over_d) < 0))
        return 0;
    const double off_d = fabs(pl_dot(3, over_c, to_d)) / area_c;
    const double off_c = fabs(pl_dot(3, over_d, to_c)) / area_d;
    return off_d <= w->tolerance * (1 + area_d / area_c) &&
           off_c <= w->tolerance * (1 + area_c / area_d);
}

static int add_ridge(pl_ridges *ridges, const pl_ridge *ridge) {
    void *grown =
        pl_grow(ridges->ridge, ridges->n, ridges->n + 1, &ridges->capacity, sizeof *ridge);
    if (!grown)
        return -1;
    ridges->ridge = grown;
    ridges->ridge[ridges->n++] = *ridge;
    return 0;
}

/** Look at the edge (a, b) of n facets: it joins two, or it is a ridge. */
static int look_at_edge(work *w, int32_t a, int32_t b, const spoke *spokes, int64_t n) {
    const pl_surface *s = w->surface;
    tagged_edge *t = find_tagged(w, a, b);
    if (t)
        t->is_met = 1;
    if (!t && n == 2 && pl_same_label(&s->label[spokes[0].facet], &s->label[spokes[1].facet]) &&
        are_coplanar(w, a, b, far_node(s, spokes[0].facet, a, b),
                     far_node(s, spokes[1].facet, a, b))) {
        pl_join(w->parent, spokes[0].facet, spokes[1].facet);
        return 0;
    }
    const pl_ridge ridge = {{a, b}, {.is_tagged = t != NULL, .tag = t ? t->tag : 0}};
    return add_ridge(w->ridges, &ridge);
}

static void sort_spokes(spoke *spokes, int64_t n) {
    for (int64_t i = 1; i < n; i++) {
        const spoke s = spokes[i];
        int64_t j = i;
        for (; j > 0 && spokes[j - 1].end > s.end; j--)
            spokes[j] = spokes[j - 1];
        spokes[j] = s;
    }
}

/** The edges from node a to higher ones. */
static int look_at_node(work *w, int32_t a) {
    const pl_surface *s = w->surface;
    const int64_t begin = s->offset[a], end = s->offset[a + 1];
    int64_t n = 0;
    spoke *grown = pl_grow(w->spoke, 0, 2 * (end - begin), &w->capacity, sizeof *grown);
    if (!grown)
        return -1;
    w->spoke = grown;
    for (int64_t i = begin; i < end; i++)
        for (int j = 0; j < 3; j++) {
            const int32_t other = s->facet[(int64_t)s->facet_of[i] * 3 + j];
            if (other > a)
                w->spoke[n++] = (spoke){other, s->facet_of[i]};
        }
    sort_spokes(w->spoke, n);
    for (int64_t i = 0, next; i < n; i = next) {
        for (next = i + 1; next < n && w->spoke[next].end == w->spoke[i].end;)
            next++;
        if (look_at_edge(w, a, w->spoke[i].end, w->spoke + i, next - i) != 0)
            return -1;
    }
    return 0;
}

/* ---- planes ------------------------------------------------------------------------------- */

/** Nodes of a class, as far apart as can be: its first one, the farthest from that, the farthest
 *  from this, and the farthest from the line of the last two, which spans the plane with them. */
typedef struct spread {
    int32_t node[4];
    double most; /* how far the last one found is */
} spread;

/** How far node is from what it is to be the k-th for. */
static double farness(const pl_surface *s, const spread *p, int k, int32_t node) {
    double v[3], line[3], across[3];
    pl_from_to(3, s->x + 3 * (int64_t)p->node[k - 1], s->x + 3 * (int64_t)node, v);
    if (k < 3)
        return pl_dot(3, v, v);
    pl_from_to(3, s->x + 3 * (int64_t)p->node[1], s->x + 3 * (int64_t)p->node[2], line);
    pl_cross(line, v, across);
    return pl_dot(3, across, across);
}

/** Number the classes in the order of their first facets. */
static void number_classes(work *w, pl_planes *planes, spread *spreads) {
    const pl_surface *s = w->surface;
    for (int64_t i = 0; i < s->n_facets; i++) {
        const int32_t first = pl_class_of(w->parent, (int32_t)i);
        if (first == i) {
            spreads[planes->n].node[0] = s->facet[i * 3];
            planes->of_facet[i] = (int32_t)planes->n++;
        } else {
            planes->of_facet[i] = planes->of_facet[first];
        }
    }
}

static void spread_nodes(const pl_surface *s, const pl_planes *planes, spread *spreads) {
    for (int k = 1; k < 4; k++) {
        for (int64_t p = 0; p < planes->n; p++)
            spreads[p].most = -1;
        for (int64_t i = 0; i < s->n_facets * 3; i++) {
            spread *p = &spreads[planes->of_facet[i / 3]];
            const double far = farness(s, p, k, s->facet[i]);
            if (far > p->most) {
                p->most = far;
                p->node[k] = s->facet[i];
            }
        }
    }
}

/** The normals by the nodes spread; planes whose nodes do not lie in them are none. */
static void find_normals(const work *w, pl_planes *planes, const spread *spreads) {
    const pl_surface *s = w->surface;
    uint8_t *is_plane = (uint8_t *)w->parent; /* classes are no longer needed */
    for (int64_t p = 0; p < planes->n; p++) {
        double u[3], v[3], *normal = planes->normal + 3 * p;
        const double *from = s->x + 3 * (int64_t)spreads[p].node[1];
        pl_from_to(3, from, s->x + 3 * (int64_t)spreads[p].node[2], u);
        pl_from_to(3, from, s->x + 3 * (int64_t)spreads[p].node[3], v);
        pl_cross(u, v, normal);
        const double length = pl_length(normal);
        is_plane[p] = length > 0;
        for (int d = 0; d < 3; d++)
            normal[d] = length > 0 ? normal[d] / length : 0;
    }
    for (int64_t i = 0; i < s->n_facets * 3; i++) {
        const int32_t p = planes->of_facet[i / 3];
        double v[3];
        pl_from_to(3, s->x + 3 * (int64_t)spreads[p].node[1], s->x + 3 * (int64_t)s->facet[i], v);
        if (!(fabs(pl_dot(3, planes->normal + 3 * (int64_t)p, v)) <= w->tolerance))
            is_plane[p] = 0;
    }
    for (int64_t i = 0; i < s->n_facets; i++)
        if (!is_plane[planes->of_facet[i]])
            planes->of_facet[i] = -1;
}

static int make_planes(work *w, pl_planes *planes) {
    const pl_surface *s = w->surface;
    for (int64_t i = 0; i < s->n_facets; i++)
        w->parent[i] = (int32_t)i;
    for (int32_t a = 0; a < s->n_nodes; a++)
        if (look_at_node(w, a) != 0)
            return -1;
    spread *spreads = pl_alloc(s->n_facets, sizeof *spreads);
    if (!spreads)
        return -1;
    number_classes(w, planes, spreads);
    planes->normal = pl_alloc(planes->n * 3, sizeof *planes->normal);
    if (planes->normal) {
        spread_nodes(s, planes, spreads);
        find_normals(w, planes, spreads);
    }
    pl_free(spreads);
    return planes->normal ? 0 : -1;
}

int pl_planes_create(const pl_surface *surface, const planish_surface *tags, double tolerance,
                     pl_planes *planes, pl_ridges *ridges, uint8_t *is_fixed,
                     planish_error *error) {
    work w = {.surface = surface, .tolerance = tolerance, .ridges = ridges};
    *planes = (pl_planes){0};
    planes->of_facet = pl_alloc(surface->n_facets, sizeof *planes->of_facet);
    w.parent = pl_alloc(surface->n_facets, sizeof *w.parent);
    const int done = planes->of_facet && w.parent && sort_tagged(&w, tags, is_fixed) == 0 &&
                     make_planes(&w, planes) == 0;
    if (done)
        fix_strangers(&w, is_fixed);
    pl_free(w.tagged);
    pl_free(w.parent);
    pl_free(w.spoke);
    if (done)
        return PLANISH_OK;
    pl_planes_destroy(planes);
    return pl_fail_memory(error, "the planes of the surface");
}

void pl_planes_destroy(pl_planes *planes) {
    pl_free(planes->of_facet);
    pl_free(planes->normal);
    *planes = (pl_planes){0};
}
