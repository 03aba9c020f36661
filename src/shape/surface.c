/* surface: the facets of a mesh that its shape is made of: those of one element, those between
 * regions, and those that bear a tag. */
#include "shape/surface.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "geometry/cell.h"
#include "geometry/simplex.h"
#include "topology/cells.h"
#include "topology/facets.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/** Facet of the surface as it is found. */
typedef struct found {
    int32_t node[3];
    int32_t apex; /* as in pl_surface */
    pl_label label;
} found;

/** The search for facets. */
typedef struct facet_search {
    const planish_mesh *mesh;
    const planish_cells *cells; /* or NULL */
    const planish_surface *tags;
    pl_tags tagged;      /* facets */
    uint8_t *has_tagged; /* [n] node of a tagged facet */
    uint8_t *elsewhere;  /* [n] 1: not on the surface, as far as known */
    int64_t *place;      /* [n + 1] first in found of those whose smallest node it is; counts at
                            first */
    found *found;        /* [n_found] ascending by nodes; NULL: they are counted */
    int64_t n_found;
    uint8_t *half; /* [n_found] of cells: as in pl_surface */
} facet_search;

/* ---- tagged facets and edges -------------------------------------------------------------- */

static int compare_nodes(int n, const int32_t *a, const int32_t *b) {
    for (int i = 0; i < n; i++)
        if (a[i] != b[i])
            return a[i] < b[i] ? -1 : 1;
    return 0;
}

static int compare_tagged(const void *a, const void *b) {
    const pl_tagged *s = a, *t = b;
    const int order = compare_nodes(4, s->node, t->node);
    return order ? order : (s->tag > t->tag) - (s->tag < t->tag);
}

/** Sort n nodes, of which those behind the last one are -1. Returns how many exchanges that takes. */
static int sort_nodes(int n, int32_t *v) {
    int exchanges = 0;
    for (int i = 1; i < n; i++)
        for (int j = i; j > 0 && v[j] >= 0 && v[j - 1] > v[j]; j--, exchanges++) {
            const int32_t t = v[j];
            v[j] = v[j - 1];
            v[j - 1] = t;
        }
    return exchanges;
}

void pl_tags_sort(pl_tags *tags) {
    const int64_t n = tags->n;
    for (int64_t k = 0; k < n; k++)
        sort_nodes(4, tags->item[k].node);
    if (n > 0)
        qsort(tags->item, (size_t)n, sizeof *tags->item, compare_tagged);
    tags->n = 0;
    for (int64_t i = 0; i < n; i++)
        if (i == 0 || compare_nodes(4, tags->item[i].node, tags->item[i - 1].node) != 0)
            tags->item[tags->n++] = tags->item[i];
}

pl_tagged *pl_tags_find(const pl_tags *tags, const int32_t *node) {
    int64_t low = 0, high = tags->n;
    while (low < high) {
        const int64_t middle = (low + high) / 2;
        const int order = compare_nodes(4, tags->item[middle].node, node);
        if (order == 0)
            return &tags->item[middle];
        *(order < 0 ? &low : &high) = order < 0 ? middle + 1 : middle;
    }
    return NULL;
}

/** Whether a facet of n nodes is a quadrilateral: no facet of a simplex. */
static int is_quadrilateral(int dim, int64_t n) {
    return dim == 3 && n != 3 && n != 6;
}

/** List the facets that the caller has tagged, and their corners. Without cells those of
 *  quadrilaterals are fixed. */
static void list_tagged(facet_search *s, uint8_t *is_fixed) {
    const planish_surface *tags = s->tags;
    const int dim = s->mesh->dim;
    for (int64_t i = 0; tags && i < tags->n_facets; i++) {
        const int64_t first = tags->facet_offset ? tags->facet_offset[i] : i * dim;
        const int64_t n = tags->facet_offset ? tags->facet_offset[i + 1] - first : dim;
        const int32_t *node = tags->facets + first;
        const int corners = is_quadrilateral(dim, n) ? 4 : dim;
        if (corners > dim && !s->cells) {
            for (int j = 0; j < corners; j++)
                is_fixed[node[j]] = PL_FIXED_ALWAYS;
            continue;
        }
        pl_tagged *t = &s->tagged.item[s->tagged.n++];
        *t = (pl_tagged){{-1, -1, -1, -1}, tags->facet_tag ? tags->facet_tag[i] : 0, 0};
        for (int j = 0; j < corners; j++) {
            t->node[j] = node[j];
            s->has_tagged[node[j]] = 1;
        }
    }
    pl_tags_sort(&s->tagged);
}

/* ---- facets ------------------------------------------------------------------------------- */

static int compare_found(const void *a, const void *b) {
    return compare_nodes(3, ((const found *)a)->node, ((const found *)b)->node);
}

/** Sort the n facets of one smallest node: few, as a rule. */
static void sort_found(found *facets, int64_t n) {
    enum { FEW = 16 };
    if (n > FEW) {
        qsort(facets, (size_t)n, sizeof *facets, compare_found);
        return;
    }
    for (int64_t i = 1; i < n; i++) {
        const found f = facets[i];
        int64_t at = i;
        for (; at > 0 && compare_nodes(3, facets[at - 1].node, f.node) > 0; at--)
            facets[at] = facets[at - 1];
        facets[at] = f;
    }
}

/** The label of a facet of so many elements, the first two of those regions, with that tag or NULL. */
static pl_label make_label(int32_t n_elements, int32_t first, int32_t second, const pl_tagged *t) {
    return (pl_label){.n_elements = n_elements,
                      .region = {first < second ? first : second, first < second ? second : first},
                      .is_tagged = t != NULL,
                      .tag = t ? t->tag : 0};
}

/** Note the facets of the surface among those of node; in a first round only how many they are, and
 *  their nodes. */
static void note_facets(void *context, int32_t node, const pl_facet *facets, int32_t n_facets,
                        int thread) {
    facet_search *s = context;
    const int32_t *region = s->tags ? s->tags->region : NULL;
    int64_t n = 0;
    (void)thread;
    for (const pl_facet *facet = facets; facet < facets + n_facets; facet++) {
        found f = {.node = {node, facet->node[0], facet->node[1]}};
        int may_be_tagged = s->tagged.n > 0;
        for (int j = 0; j < s->mesh->dim && may_be_tagged; j++)
            may_be_tagged = s->has_tagged[f.node[j]];
        const int32_t key[] = {f.node[0], f.node[1], f.node[2], -1};
        pl_tagged *t = may_be_tagged ? pl_tags_find(&s->tagged, key) : NULL;
        /* Of an element that is listed twice a facet of the boundary is one of both. */
        const int count = facet->count == 2 && facet->twin ? 1 : facet->count;
        const int32_t first = region ? region[facet->element[0]] : 0;
        const int32_t second = region && count > 1 ? region[facet->element[1]] : first;
        if (count == 2 && first == second && !t)
            continue;
        f.apex = second < first ? ~facet->opposite : facet->opposite;
        f.label = make_label(count, first, second, t);
        if (s->found) {
            s->found[s->place[node] + n] = f;
            if (t)
                pl_set_flag(&t->is_met, 1);
        } else {
            for (int j = 0; j < s->mesh->dim; j++)
                pl_set_flag(&s->elsewhere[f.node[j]], 0);
        }
        n++;
    }
    if (s->found)
        sort_found(s->found + s->place[node], n);
    else
        s->place[node] = n;
}

/** Two rounds: one counts and finds the nodes, the other notes and looks only at these. */
static int find_facets(facet_search *s, int threads, planish_error *error) {
    pl_incidence incidence;
    const uint8_t *is_inside = s->tags ? s->tags->is_inside : NULL;
    int status = pl_incidence_create(s->mesh, is_inside, threads, &incidence, error);
    if (status)
        return status;
    status = pl_facets_match(s->mesh, &incidence, is_inside, threads, note_facets, s, error);
    if (!status) {
        s->n_found = pl_prefix_sum(threads, s->mesh->n_nodes, s->place);
        s->found = pl_alloc(s->n_found, sizeof *s->found);
        if (!s->found)
            status = pl_fail_memory(error, "the surface");
    }
    if (!status)
        status = pl_facets_match(s->mesh, &incidence, s->elsewhere, threads, note_facets, s, error);
    pl_incidence_destroy(&incidence);
    return status;
}

/* ---- facets of cells ----------------------------------------------------------------------- */

/** The tagged facet of n corners, or NULL. */
static pl_tagged *find_tag(const facet_search *s, int n, const int32_t *corner) {
    int32_t key[4] = {-1, -1, -1, -1};
    for (int j = 0; j < n; j++) {
        if (!s->has_tagged[corner[j]])
            return NULL;
        key[j] = corner[j];
    }
    sort_nodes(4, key);
    return s->tagged.n > 0 ? pl_tags_find(&s->tagged, key) : NULL;
}

/** Whether a quadrilateral is cut well by its diagonal from corner first: the others are at both sides.
 */
static int is_cut(const facet_search *s, const int32_t *corner, int first) {
    const double *x = s->mesh->coordinates;
    double to[3][3], over[2][3];
    for (int j = 0; j < 3; j++)
        pl_from_to(3, x + 3 * (int64_t)corner[first], x + 3 * (int64_t)corner[(first + 1 + j) % 4],
                   to[j]);
    pl_cross(to[1], to[0], over[0]);
    pl_cross(to[1], to[2], over[1]);
    return pl_dot(3, over[0], over[1]) < 0;
}

/** Add a triangle or edge of a facet, ascending. */
static void add_found(facet_search *s, const int32_t node[3], int32_t apex, pl_label label,
                      int half) {
    found *f = &s->found[s->n_found];
    *f = (found){{node[0], node[1], node[2]}, apex, label};
    const int exchanges = sort_nodes(3, f->node);
    if (label.n_elements == 0)
        f->apex = exchanges % 2;
    s->half[s->n_found++] = (uint8_t)half;
    for (int j = 0; j < s->mesh->dim; j++)
        s->elsewhere[f->node[j]] = 0;
}

/** Add a facet of n corners; quadrilaterals are cut, as a rule at their lowest corner. */
static void add_facet(facet_search *s, int n, const int32_t *corner, int32_t apex, pl_label label) {
    if (n < 4) {
        add_found(s, (int32_t[]){corner[0], corner[1], n > 2 ? corner[2] : -1}, apex, label, 0);
        return;
    }
    int at = 0;
    for (int j = 1; j < n; j++)
        at = corner[j] < corner[at] ? j : at;
    at = is_cut(s, corner, at) ? at : (at + 1) % n;
    const int32_t v[] = {corner[at], corner[(at + 1) % n], corner[(at + 2) % n],
                         corner[(at + 3) % n]};
    add_found(s, v, apex, label, 1);
    add_found(s, (int32_t[]){v[0], v[2], v[3]}, apex, label, 2);
}

/** A corner of an element that is none of its facet's n, which in 2-D may be any. */
static int32_t apex_of(const facet_search *s, int64_t element, int n, const int32_t *corner) {
    const int32_t *node = s->cells->node + s->cells->offset[element];
    const int n_corners = pl_cell_type_of(s->cells->type[element])->shape->n_corners;
    for (int i = 0; i < n_corners; i++) {
        int is_new = 1;
        for (int j = 0; j < n; j++)
            is_new &= node[i] != corner[j];
        if (is_new)
            return node[i];
    }
    return node[0];
}

/** How the elements share their facets. */
typedef struct sharing {
    int32_t *with;
    uint8_t *n_sharing; /* both as of pl_cell_facets_find */
} sharing;

/** Find whether facet k of an element is of the surface, its corners [4] and its label. Of elements
 *  that share it only one is asked. Returns how many corners it has, 0: it is none of the surface. */
static int facet_of_surface(const facet_search *s, const sharing *by, int64_t element, int k,
                            int32_t *corner, pl_label *label) {
    const int64_t place = element * PL_CELL_FACET_PLACES + k;
    const int32_t *region = s->tags ? s->tags->region : NULL;
    const int32_t with = by->with[place];
    const int count = by->n_sharing[place];
    if (count == 0 || (count == 2) != (with >= 0))
        return 0;
    const int32_t first = region ? region[element] : 0;
    const int32_t second = region && with >= 0 ? region[with] : first;
    const int is_between = count == 2 && first == second;
    if (is_between && s->tagged.n == 0)
        return 0;
    const int n = pl_cell_facet(s->cells, element, k, corner);
    pl_tagged *t = find_tag(s, n, corner);
    *label = make_label(count, first, second, t);
    if (is_between && !t)
        return 0;
    if (t)
        t->is_met = 1;
    return n;
}

/** Look at all facets; if the surface's are not added they are counted: *n_facets. */
static void walk_facets(facet_search *s, const sharing *by, int is_counted, int64_t *n_facets) {
    for (int64_t i = 0; i < s->cells->n; i++) {
        const pl_cell_type *type = pl_cell_type_of(s->cells->type[i]);
        const int n_own = type && type->shape->dim == s->mesh->dim ? type->shape->n_facets : 0;
        for (int k = 0; k < n_own; k++) {
            int32_t corner[4];
            pl_label label;
            const int n = facet_of_surface(s, by, i, k, corner, &label);
            if (n == 0)
                continue;
            *n_facets += n < 4 ? 1 : 2;
            if (is_counted)
                continue;
            const int32_t apex = apex_of(s, i, n, corner), *region = s->tags ? s->tags->region : 0;
            const int is_higher = region && region[i] != label.region[0];
            add_facet(s, n, corner, is_higher ? ~apex : apex, label);
        }
    }
}

/** Find the facets of cells. */
static int find_cell_facets(facet_search *s, int threads, planish_error *error) {
    const int64_t n_places = s->cells->n * PL_CELL_FACET_PLACES;
    sharing by = {pl_alloc(n_places, sizeof *by.with), pl_alloc(n_places, 1)};
    int64_t n = 0, n_added = 0;
    int status = by.with && by.n_sharing
                     ? pl_cell_facets_find(s->cells, s->mesh->dim, s->mesh->n_nodes,
                                           s->tags ? s->tags->is_inside : NULL, threads, by.with,
                                           by.n_sharing, error)
                     : pl_fail_memory(error, "the surface");
    if (!status)
        walk_facets(s, &by, 1, &n);
    s->found = pl_alloc(status ? -1 : n, sizeof *s->found);
    s->half = pl_alloc(status ? -1 : n, sizeof *s->half);
    if (!status && (!s->found || !s->half))
        status = pl_fail_memory(error, "the surface");
    if (!status)
        walk_facets(s, &by, 0, &n_added);
    pl_free(by.with);
    pl_free(by.n_sharing);
    return status;
}

/* ---- elements that are facets themselves ---------------------------------------------------- */

int pl_is_of_faces(const planish_cells *cells, int dim) {
    int any = 0;
    for (int64_t i = 0; i < cells->n; i++) {
        const pl_cell_type *type = pl_cell_type_of(cells->type[i]);
        if (type && type->shape->dim == dim)
            return 0;
        any |= type && type->shape->dim == dim - 1;
    }
    return any;
}

/** Find the facets of a surface mesh in space: its elements. */
static int find_flat_cells(facet_search *s, planish_error *error) {
    const planish_cells *cells = s->cells;
    const int32_t *region = s->tags ? s->tags->region : NULL;
    int any_half = 0;
    s->found = pl_alloc(2 * cells->n, sizeof *s->found);
    s->half = pl_alloc(2 * cells->n, sizeof *s->half);
    if (!s->found || !s->half)
        return pl_fail_memory(error, "the surface");
    for (int64_t i = 0; i < cells->n; i++) {
        const pl_cell_type *type = pl_cell_type_of(cells->type[i]);
        if (!type || type->shape->dim != 2)
            continue;
        const int32_t *corner = cells->node + cells->offset[i], here = region ? region[i] : 0;
        pl_tagged *t = find_tag(s, type->shape->n_corners, corner);
        if (t)
            t->is_met = 1;
        add_facet(s, type->shape->n_corners, corner, 0, make_label(0, here, here, t));
        any_half |= type->shape->n_corners == 4;
    }
    if (!any_half) {
        pl_free(s->half);
        s->half = NULL;
    }
    return PLANISH_OK;
}

/* ---- the surface -------------------------------------------------------------------------- */

/** Note the numbers of the nodes and their coordinates, scaled. */
static void place_nodes(const facet_search *s, pl_surface *surface) {
    const int dim = surface->dim;
    double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    double width = 0, square = 0;
    int exponent;
    for (int64_t i = 0; i < s->mesh->n_nodes; i++) {
        if (surface->number[i] < 0)
            continue;
        surface->node[surface->number[i]] = (int32_t)i;
        for (int d = 0; d < dim; d++) {
            lower[d] = fmin(lower[d], s->mesh->coordinates[i * dim + d]);
            upper[d] = fmax(upper[d], s->mesh->coordinates[i * dim + d]);
        }
    }
    for (int d = 0; d < dim && surface->n_nodes > 0; d++)
        width = fmax(width, 0.5 * upper[d] - 0.5 * lower[d]); /* the whole could overflow */
    frexp(width, &exponent);
    const double scale = surface->scale = ldexp(1, -pl_scale_exponent(exponent));
    for (int64_t i = 0; i < surface->n_nodes; i++)
        for (int d = 0; d < dim; d++)
            surface->x[i * dim + d] =
                s->mesh->coordinates[(int64_t)surface->node[i] * dim + d] * scale;
    for (int d = 0; d < dim && surface->n_nodes > 0; d++) {
        const double half = 0.5 * upper[d] * scale - 0.5 * lower[d] * scale;
        square += 4 * half * half;
    }
    surface->size = sqrt(square);
}

/** Note the facets by own numbers, and those of each node. */
static void place_facets(const facet_search *s, pl_surface *surface) {
    const int dim = surface->dim;
    int64_t *end = surface->offset + 1; /* counts at first */
    for (int64_t i = 0; i < s->n_found; i++) {
        surface->label[i] = s->found[i].label;
        surface->apex[i] = s->found[i].apex;
        for (int j = 0; j < dim; j++) {
            surface->facet[i * dim + j] = surface->number[s->found[i].node[j]];
            end[surface->facet[i * dim + j]]++;
        }
    }
    for (int64_t i = 0, sum = 0; i < surface->n_nodes; i++) {
        const int64_t count = end[i];
        end[i] = sum; /* where its facets begin, and end once they are noted */
        sum += count;
    }
    for (int64_t i = 0; i < s->n_found * dim; i++)
        surface->facet_of[end[surface->facet[i]]++] = (int32_t)(i / dim);
}

/** Number the nodes that were found, and lay out the surface. */
static int lay_out(const facet_search *s, pl_surface *surface, planish_error *error) {
    const int dim = surface->dim = s->mesh->dim;
    surface->number = pl_alloc(s->mesh->n_nodes, sizeof *surface->number);
    if (!surface->number)
        return pl_fail_memory(error, "the surface");
    for (int64_t i = 0; i < s->mesh->n_nodes; i++)
        surface->number[i] = s->elsewhere[i] ? -1 : (int32_t)surface->n_nodes++;
    surface->n_facets = s->n_found;
    surface->node = pl_alloc(surface->n_nodes, sizeof *surface->node);
    surface->x = pl_alloc(surface->n_nodes * dim, sizeof *surface->x);
    surface->facet = pl_alloc(s->n_found * dim, sizeof *surface->facet);
    surface->label = pl_alloc(s->n_found, sizeof *surface->label);
    surface->apex = pl_alloc(s->n_found, sizeof *surface->apex);
    surface->offset = pl_alloc_zero(surface->n_nodes + 1, sizeof *surface->offset);
    surface->facet_of = pl_alloc(s->n_found * dim, sizeof *surface->facet_of);
    if (!surface->node || !surface->x || !surface->facet || !surface->label || !surface->apex ||
        !surface->offset || !surface->facet_of)
        return pl_fail_memory(error, "the surface");
    place_nodes(s, surface);
    place_facets(s, surface);
    return PLANISH_OK;
}

int pl_surface_create(const planish_mesh *mesh, const planish_cells *cells,
                      const planish_surface *tags, int threads, pl_surface *surface,
                      uint8_t *is_fixed, planish_error *error) {
    const int64_t n = mesh->n_nodes;
    facet_search s = {.mesh = mesh, .cells = cells, .tags = tags};
    *surface = (pl_surface){.dim = mesh->dim};
    s.tagged.item = pl_alloc(tags ? tags->n_facets : 0, sizeof *s.tagged.item);
    s.has_tagged = pl_alloc_zero(n, 1);
    s.elsewhere = pl_alloc(n, 1);
    s.place = pl_alloc_zero(n + 1, sizeof *s.place);
    int status = PLANISH_OK;
    if (!s.tagged.item || !s.has_tagged || !s.elsewhere || !s.place) {
        status = pl_fail_memory(error, "the surface");
    } else {
        memset(s.elsewhere, 1, (size_t)n);
        list_tagged(&s, is_fixed);
        status = !cells                             ? find_facets(&s, threads, error)
                 : pl_is_of_faces(cells, mesh->dim) ? find_flat_cells(&s, error)
                                                    : find_cell_facets(&s, threads, error);
    }
    if (!status)
        status = lay_out(&s, surface, error);
    surface->half = s.half;
    for (const pl_tagged *t = s.tagged.item; !status && t < s.tagged.item + s.tagged.n; t++)
        for (int j = 0; j < 4 && t->node[j] >= 0 && !t->is_met; j++)
            is_fixed[t->node[j]] = PL_FIXED_ALWAYS;
    pl_free(s.tagged.item);
    pl_free(s.has_tagged);
    pl_free(s.elsewhere);
    pl_free(s.place);
    pl_free(s.found);
    if (status)
        pl_surface_destroy(surface);
    return status;
}

void pl_surface_destroy(pl_surface *surface) {
    pl_free(surface->node);
    pl_free(surface->x);
    pl_free(surface->facet);
    pl_free(surface->label);
    pl_free(surface->apex);
    pl_free(surface->half);
    pl_free(surface->offset);
    pl_free(surface->facet_of);
    pl_free(surface->number);
    pl_free(surface->whole);
    pl_free(surface->mid);
    *surface = (pl_surface){0};
}
