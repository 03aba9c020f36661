/* surface: the facets of a mesh that its shape is made of: those of one element, those between
 * regions, and those that bear a tag. */
#include "shape/surface.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "geometry/simplex.h"
#include "topology/facets.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/** Facet of the surface as it is found. */
typedef struct found {
    int32_t node[3];
    pl_label label;
} found;

/** The search for facets. */
typedef struct facet_search {
    const planish_mesh *mesh;
    const planish_surface *tags;
    pl_tags tagged;      /* facets */
    uint8_t *has_tagged; /* [n] node of a tagged facet */
    uint8_t *elsewhere;  /* [n] 1: not on the surface, as far as known */
    int64_t *place;      /* [n + 1] first in found of those whose smallest node it is; counts at
                            first */
    found *found;        /* [n_found] ascending by nodes; NULL: they are counted */
    int64_t n_found;
} facet_search;

/* ---- tagged facets and edges -------------------------------------------------------------- */

static int compare_nodes(const int32_t *a, const int32_t *b) {
    for (int i = 0; i < 3; i++)
        if (a[i] != b[i])
            return a[i] < b[i] ? -1 : 1;
    return 0;
}

static int compare_tagged(const void *a, const void *b) {
    const pl_tagged *s = a, *t = b;
    const int order = compare_nodes(s->node, t->node);
    return order ? order : (s->tag > t->tag) - (s->tag < t->tag);
}

void pl_tags_sort(pl_tags *tags) {
    const int64_t n = tags->n;
    for (int64_t k = 0; k < n; k++) {
        int32_t *v = tags->item[k].node;
        for (int i = 1; i < 3; i++)
            for (int j = i; j > 0 && v[j] >= 0 && v[j - 1] > v[j]; j--) {
                const int32_t t = v[j];
                v[j] = v[j - 1];
                v[j - 1] = t;
            }
    }
    if (n > 0)
        qsort(tags->item, (size_t)n, sizeof *tags->item, compare_tagged);
    tags->n = 0;
    for (int64_t i = 0; i < n; i++)
        if (i == 0 || compare_nodes(tags->item[i].node, tags->item[i - 1].node) != 0)
            tags->item[tags->n++] = tags->item[i];
}

pl_tagged *pl_tags_find(const pl_tags *tags, const int32_t *node) {
    int64_t low = 0, high = tags->n;
    while (low < high) {
        const int64_t middle = (low + high) / 2;
        const int order = compare_nodes(tags->item[middle].node, node);
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

/** List the facets that the caller has tagged, and their corners. Those of quadrilaterals are fixed.
 */
static void list_tagged(facet_search *s, uint8_t *is_fixed) {
    const planish_surface *tags = s->tags;
    const int dim = s->mesh->dim;
    for (int64_t i = 0; tags && i < tags->n_facets; i++) {
        const int64_t first = tags->facet_offset ? tags->facet_offset[i] : i * dim;
        const int64_t n = tags->facet_offset ? tags->facet_offset[i + 1] - first : dim;
        const int32_t *node = tags->facets + first;
        if (is_quadrilateral(dim, n)) {
            for (int j = 0; j < 4; j++)
                is_fixed[node[j]] = 1;
            continue;
        }
        pl_tagged *t = &s->tagged.item[s->tagged.n++];
        *t = (pl_tagged){{-1, -1, -1}, tags->facet_tag ? tags->facet_tag[i] : 0, 0};
        for (int j = 0; j < dim; j++) {
            t->node[j] = node[j];
            s->has_tagged[node[j]] = 1;
        }
    }
    pl_tags_sort(&s->tagged);
}

/* ---- facets ------------------------------------------------------------------------------- */

static int compare_found(const void *a, const void *b) {
    return compare_nodes(((const found *)a)->node, ((const found *)b)->node);
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
        for (; at > 0 && compare_nodes(facets[at - 1].node, f.node) > 0; at--)
            facets[at] = facets[at - 1];
        facets[at] = f;
    }
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
        pl_tagged *t = may_be_tagged ? pl_tags_find(&s->tagged, f.node) : NULL;
        const int32_t first = region ? region[facet->element[0]] : 0;
        const int32_t second = region && facet->count > 1 ? region[facet->element[1]] : first;
        if (facet->count == 2 && first == second && !t)
            continue;
        f.label =
            (pl_label){.n_elements = facet->count,
                       .region = {first < second ? first : second, first < second ? second : first},
                       .is_tagged = t != NULL,
                       .tag = t ? t->tag : 0};
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
    surface->offset = pl_alloc_zero(surface->n_nodes + 1, sizeof *surface->offset);
    surface->facet_of = pl_alloc(s->n_found * dim, sizeof *surface->facet_of);
    if (!surface->node || !surface->x || !surface->facet || !surface->label || !surface->offset ||
        !surface->facet_of)
        return pl_fail_memory(error, "the surface");
    place_nodes(s, surface);
    place_facets(s, surface);
    return PLANISH_OK;
}

int pl_surface_create(const planish_mesh *mesh, const planish_surface *tags, int threads,
                      pl_surface *surface, uint8_t *is_fixed, planish_error *error) {
    const int64_t n = mesh->n_nodes;
    facet_search s = {.mesh = mesh, .tags = tags};
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
        status = find_facets(&s, threads, error);
    }
    if (!status)
        status = lay_out(&s, surface, error);
    for (const pl_tagged *t = s.tagged.item; !status && t < s.tagged.item + s.tagged.n; t++)
        for (int j = 0; j < mesh->dim && !t->is_met; j++)
            is_fixed[t->node[j]] = 1;
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
    pl_free(surface->offset);
    pl_free(surface->facet_of);
    pl_free(surface->number);
    *surface = (pl_surface){0};
}
