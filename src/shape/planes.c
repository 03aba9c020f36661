/* planes: which facets of a surface lie in one plane, and the edges where planes end.
 *
 * Two facets that share an edge, and no third one does, are coplanar if the far node of each lies
 * in the plane of the other. Classes of facets joined so are then looked at as a whole: three of
 * their nodes, as far apart as can be, say where the plane is, and if a node lies off it the class
 * is not planar (facets of a finely meshed cylinder join one by one, too).
 */
#include "shape/planes.h"

#include "base/joined.h"
#include "base/memory.h"
#include "base/status.h"

/** Facet at an edge that begins at the node under work. */
typedef struct spoke {
    int32_t end, facet;
} spoke;

typedef struct plane_search {
    const pl_surface *surface;
    double tolerance;
    pl_tags tagged;  /* edges, by the surface's numbers */
    int32_t *parent; /* [n_facets] classes of coplanar facets */
    spoke *spoke;    /* [capacity] */
    int64_t capacity;
    pl_ridges *ridges;
    uint8_t *is_fixed; /* [nodes of the mesh] */
} plane_search;

/** List the tagged edges with both nodes on the surface; nodes of the others are fixed. */
static void list_tagged(plane_search *w, const planish_surface *tags) {
    for (int64_t i = 0; tags && i < tags->n_edges; i++) {
        const int32_t *node = tags->edges + 2 * i;
        const int32_t a = w->surface->number[node[0]], b = w->surface->number[node[1]];
        if (a < 0 || b < 0)
            w->is_fixed[node[0]] = w->is_fixed[node[1]] = PL_FIXED_ALWAYS;
        else
            w->tagged.item[w->tagged.n++] =
                (pl_tagged){{a, b, -1, -1}, tags->edge_tag ? tags->edge_tag[i] : 0, 0};
    }
    pl_tags_sort(&w->tagged);
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
static int are_coplanar(const plane_search *w, int32_t a, int32_t b, int32_t c, int32_t d) {
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

/** Fix the nodes of a quadrilateral whose diagonal, an edge of n facets, joins nothing. */
static void fix_quadrilateral(const plane_search *w, const spoke *spokes, int64_t n) {
    const pl_surface *s = w->surface;
    for (int64_t i = 0; s->half && i < n; i++)
        for (int64_t k = 0; s->half[spokes[i].facet] == 1 && k < n; k++)
            for (int j = 0; spokes[k].facet == spokes[i].facet + 1 && j < 6; j++)
                w->is_fixed[s->node[s->facet[(int64_t)spokes[i].facet * 3 + j]]] |=
                    PL_FIXED_UNLESS_CURVED;
}

/** Look at the edge (a, b) of n facets: it joins two, or it is a ridge. Returns -1 without memory.
 */
static int look_at_edge(plane_search *w, int32_t a, int32_t b, const spoke *spokes, int64_t n) {
    const pl_surface *s = w->surface;
    pl_tagged *t = pl_tags_find(&w->tagged, (const int32_t[]){a, b, -1, -1});
    if (t)
        t->is_met = 1;
    if (!t && n == 2 && pl_same_label(&s->label[spokes[0].facet], &s->label[spokes[1].facet]) &&
        are_coplanar(w, a, b, far_node(s, spokes[0].facet, a, b),
                     far_node(s, spokes[1].facet, a, b))) {
        pl_join(w->parent, spokes[0].facet, spokes[1].facet);
        return 0;
    }
    fix_quadrilateral(w, spokes, n);
    pl_ridges *ridges = w->ridges;
    const pl_ridge ridge = {{a, b}, {.is_tagged = t != NULL, .tag = t ? t->tag : 0}};
    return pl_append(&ridges->ridge, &ridges->n, &ridges->capacity, &ridge, sizeof ridge) ? 0 : -1;
}

/** Look at the edges from node a to higher ones. Returns -1 without memory. */
static int look_at_node(plane_search *w, int32_t a) {
    const pl_surface *s = w->surface;
    const int64_t begin = s->offset[a], end = s->offset[a + 1];
    int64_t n = 0;
    spoke *spokes = pl_grow(w->spoke, 0, 2 * (end - begin), &w->capacity, sizeof *spokes);
    if (!spokes)
        return -1;
    w->spoke = spokes;
    /* sorted by their ends, and facets of one end in their order */
    for (int64_t i = begin; i < end; i++)
        for (int j = 0; j < 3; j++) {
            const spoke new = {s->facet[(int64_t)s->facet_of[i] * 3 + j], s->facet_of[i]};
            if (new.end <= a)
                continue;
            int64_t at = n++;
            for (; at > 0 && spokes[at - 1].end > new.end; at--)
                spokes[at] = spokes[at - 1];
            spokes[at] = new;
        }
    for (int64_t i = 0, next; i < n; i = next) {
        for (next = i + 1; next < n && spokes[next].end == spokes[i].end;)
            next++;
        if (look_at_edge(w, a, spokes[i].end, spokes + i, next - i) != 0)
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

/** Return how far node, as the k-th, is from those before it. */
static double farness(const pl_surface *s, const spread *p, int k, int32_t node) {
    double v[3], line[3], across[3];
    pl_from_to(3, s->x + 3 * (int64_t)p->node[k - 1], s->x + 3 * (int64_t)node, v);
    if (k < 3)
        return pl_dot(3, v, v);
    pl_from_to(3, s->x + 3 * (int64_t)p->node[1], s->x + 3 * (int64_t)p->node[2], line);
    pl_cross(line, v, across);
    return pl_dot(3, across, across);
}

/** Number the classes in the order of their first facets, and find their nodes that are far apart.
 */
static void spread_nodes(plane_search *w, pl_planes *planes, spread *spreads) {
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

/** Find the normals by the nodes that are spread. A plane whose nodes do not lie in it is none. */
static void find_normals(const plane_search *w, pl_planes *planes, const spread *spreads) {
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

/** Find classes of coplanar facets, and their planes. Returns -1 without memory. */
static int make_planes(plane_search *w, pl_planes *planes) {
    const pl_surface *s = w->surface;
    for (int64_t i = 0; i < s->n_facets; i++)
        w->parent[i] = (int32_t)i;
    for (int32_t a = 0; a < s->n_nodes; a++)
        if (look_at_node(w, a) != 0)
            return -1;
    spread *spreads = pl_alloc(s->n_facets, sizeof *spreads);
    if (!spreads)
        return -1;
    spread_nodes(w, planes, spreads);
    planes->normal = pl_alloc(planes->n * 3, sizeof *planes->normal);
    if (planes->normal)
        find_normals(w, planes, spreads);
    pl_free(spreads);
    return planes->normal ? 0 : -1;
}

int pl_planes_create(const pl_surface *surface, const planish_surface *tags, double tolerance,
                     pl_planes *planes, pl_ridges *ridges, uint8_t *is_fixed,
                     planish_error *error) {
    plane_search w = {
        .surface = surface, .tolerance = tolerance, .ridges = ridges, .is_fixed = is_fixed};
    *planes = (pl_planes){0};
    planes->of_facet = pl_alloc(surface->n_facets, sizeof *planes->of_facet);
    w.parent = pl_alloc(surface->n_facets, sizeof *w.parent);
    w.tagged.item = pl_alloc(tags ? tags->n_edges : 0, sizeof *w.tagged.item);
    int done = planes->of_facet && w.parent && w.tagged.item;
    if (done) {
        list_tagged(&w, tags);
        done = make_planes(&w, planes) == 0;
    }
    for (const pl_tagged *t = w.tagged.item; done && t < w.tagged.item + w.tagged.n; t++)
        for (int j = 0; j < 2 && !t->is_met; j++)
            is_fixed[surface->node[t->node[j]]] = PL_FIXED_ALWAYS;
    pl_free(w.tagged.item);
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
