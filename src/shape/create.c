/* create: make a shape of the facets of a mesh, and free it. */
#include "shape/create.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "shape/bend.h"
#include "shape/features.h"
#include "topology/points.h"

#include <string.h>

/** Nodes at the place of another one are corners: a gap would open between them. */
static int hold_twins(pl_features *w, planish_error *error) {
    const planish_shape *s = w->shape;
    const pl_points points = {s->x[0], s->n_nodes, 3, 3, 1, NULL};
    uint8_t *is_doubled = pl_alloc(s->n_nodes, sizeof *is_doubled);
    if (!is_doubled)
        return pl_fail_memory(error, "the surface");
    const int status = pl_points_find_doubled(&points, is_doubled, error);
    for (int64_t i = 0; !status && i < s->n_nodes; i++)
        w->stays[i] |= is_doubled[i];
    pl_free(is_doubled);
    return status;
}

/** Keep where the facets of nodes begin, in 4 bytes each. Errors: _MEMORY. */
static int narrow_offsets(const pl_surface *surface, planish_shape *s, planish_error *error) {
    const int64_t *offset = surface->offset;
    s->offset = offset[surface->n_nodes] <= UINT32_MAX
                    ? pl_alloc(surface->n_nodes + 1, sizeof *s->offset)
                    : NULL;
    for (int64_t i = 0; s->offset && i <= surface->n_nodes; i++)
        s->offset[i] = (uint32_t)offset[i];
    return s->offset ? PLANISH_OK : pl_fail_memory(error, "the surface");
}

/** Take the surface's arrays, but for labels, apices and offsets. */
static void take_surface(pl_surface *surface, int64_t n_mesh, planish_shape *s) {
    s->n_mesh = n_mesh;
    s->n_nodes = surface->n_nodes;
    s->n_facets = surface->n_facets;
    s->scale = surface->scale;
    s->size = surface->size;
    s->number = surface->number;
    s->node = surface->node;
    s->x = (double(*)[3])surface->x;
    s->facet = (int32_t(*)[3])surface->facet;
    s->half = surface->half;
    s->facet_of = surface->facet_of;
    s->whole = surface->whole;
    s->n_wholes = surface->n_wholes;
    surface->number = surface->node = surface->facet = surface->facet_of = NULL;
    surface->x = NULL;
    surface->half = NULL;
    surface->whole = NULL;
}

/** List the triangles of all facets of second order at each corner. */
static void list_stars(planish_shape *s) {
    for (int64_t i = 0; i < s->n_wholes; i++)
        for (int k = 0; k < s->whole[i].n_corners; k++)
            s->star_offset[s->whole[i].node[k] + 1] += s->whole[i].n_parts;
    for (int64_t i = 0, sum = 0; i < s->n_nodes; i++) {
        const int64_t count = s->star_offset[i + 1];
        s->star_offset[i + 1] = sum; /* where its facets begin, and end once they are listed */
        sum += count;
    }
    for (int64_t i = 0; i < s->n_wholes; i++) {
        const pl_whole *whole = &s->whole[i];
        for (int k = 0; k < whole->n_corners * whole->n_parts; k++) {
            const int32_t corner = whole->node[k / whole->n_parts];
            s->star[s->star_offset[corner + 1]++] = whole->first + k % whole->n_parts;
        }
    }
}

/** Find how far facets of second order are off their triangles, and all that change with each corner. */
static int find_wholes(planish_shape *s, planish_error *error) {
    if (!s->whole)
        return PLANISH_OK;
    s->whole_of = pl_alloc(s->n_facets, sizeof *s->whole_of);
    s->bend = pl_alloc(s->n_facets, sizeof *s->bend);
    s->star_offset = pl_alloc_zero(s->n_nodes + 1, sizeof *s->star_offset);
    s->star = pl_alloc(4 * s->n_facets, sizeof *s->star);
    if (!s->whole_of || !s->bend || !s->star_offset || !s->star)
        return pl_fail_memory(error, "the facets of second order");
    list_stars(s);
    for (int64_t i = 0; i < s->n_wholes; i++) {
        const pl_whole *whole = &s->whole[i];
        double x[PL_WHOLE_NODES][3];
        pl_whole_nodes(s, whole, x);
        for (int k = 0; k < whole->n_parts; k++) {
            s->whole_of[whole->first + k] = (int32_t)i;
            s->bend[whole->first + k] =
                pl_whole_bend(whole, (const double(*)[3])x, pl_whole_parts(whole)[k]);
        }
    }
    return PLANISH_OK;
}

static int allocate(planish_shape *s, pl_features *w, planish_error *error) {
    const int64_t n = s->n_nodes, m = s->n_facets;
    s->edge_length = pl_alloc(n, sizeof *s->edge_length);
    s->node_class = pl_alloc_zero(n, sizeof *s->node_class);
    s->normal = pl_alloc(m, sizeof *s->normal);
    s->across = pl_alloc(m, sizeof *s->across);
    s->patch = pl_alloc(m, sizeof *s->patch);
    s->is_interface = pl_alloc(m, sizeof *s->is_interface);
    s->edge_at = pl_alloc(n, sizeof *s->edge_at);
    w->normal = pl_alloc(m, sizeof *w->normal);
    w->corner_normal = pl_alloc_zero(m, sizeof *w->corner_normal);
    w->beside = pl_alloc(m, sizeof *w->beside);
    w->kind = pl_alloc(m, sizeof *w->kind);
    w->stays = pl_alloc_zero(n, sizeof *w->stays);
    w->n_ends = pl_alloc(n, sizeof *w->n_ends);
    w->n_features = pl_alloc(n, sizeof *w->n_features);
    if (!s->edge_length || !s->node_class || !s->normal || !s->across || !s->patch ||
        !s->is_interface || !s->edge_at || !w->normal || !w->corner_normal || !w->beside ||
        !w->kind || !w->stays || !w->n_ends || !w->n_features)
        return pl_fail_memory(error, "the shape");
    return PLANISH_OK;
}

/** Count what was found. */
static void describe(const pl_features *w, planish_shape_info *info) {
    const planish_shape *s = w->shape;
    double sum = 0;
    int64_t n = 0, n_halves = 0;
    *info = (planish_shape_info){.n_nodes = s->n_nodes,
                                 .n_facets = s->whole ? s->n_wholes : s->n_facets,
                                 .n_edges = s->n_edges};
    for (int64_t i = 0; i < s->n_nodes; i++) {
        if (s->whole && s->star_offset[i + 1] == s->star_offset[i]) {
            info->n_mids++;
            continue;
        }
        info->n_on_patch += s->node_class[i] == PL_ON_PATCH;
        info->n_on_curve += s->node_class[i] == PL_ON_CURVE;
        info->n_corners += s->node_class[i] == PL_CORNER;
        sum += (double)pl_edges_at(s, (int32_t)i) * s->edge_length[i] * w->n_ends[i];
        n += w->n_ends[i];
    }
    for (int64_t f = 0; f < s->n_facets; f++) {
        if (s->patch[f] >= info->n_patches)
            info->n_patches = s->patch[f] + 1;
        for (int k = 0; k < 3; k++)
            n_halves += (w->kind[f][k] & PL_EDGE_CREASE) != 0;
    }
    info->n_creases = n_halves / 2;
    pl_features_count(w, info);
    info->edge_length = n > 0 ? sum / (double)n / s->scale : 0;
}

/** Find everything of a shape that has taken the surface's arrays. */
static int find_shape(pl_features *w, const planish_mesh *mesh, const uint8_t *is_fixed,
                      planish_error *error) {
    planish_shape *s = w->shape;
    int status = allocate(s, w, error);
    for (int64_t i = 0; !status && i < s->n_nodes; i++)
        w->stays[i] = is_fixed[s->node[i]];
    for (int64_t f = 0; !status && f < s->n_facets; f++)
        s->is_interface[f] = w->surface->label[f].n_elements == 2;
    if (!status && s->n_nodes > 0)
        status = hold_twins(w, error);
    if (!status)
        status = pl_features_match(w, error);
    if (!status)
        status = pl_features_orient(w, mesh->coordinates, error);
    if (!status)
        status = pl_features_find(w, error);
    if (!status) {
        pl_shape_bend(w);
        pl_features_settle(w);
        status = pl_shape_pack_normals(w, error);
    }
    return status;
}

int pl_shape_create(const planish_mesh *mesh, const planish_mesh *given, const planish_cells *cells,
                    const planish_surface *tags, int threads, planish_shape **shape,
                    planish_shape_info *info, planish_error *error) {
    pl_surface surface = {0};
    planish_shape *s = pl_alloc_zero(1, sizeof *s);
    uint8_t *is_fixed = pl_alloc_zero(mesh->n_nodes, 1);
    pl_features w = {.shape = s, .surface = &surface, .tags = tags, .threads = threads};
    int status = s && is_fixed
                     ? pl_surface_create(mesh, cells, tags, threads, &surface, is_fixed, error)
                     : pl_fail_memory(error, "the shape");
    if (!status && given->cells)
        status = pl_surface_divide(given, &surface, error);
    if (!status) {
        take_surface(&surface, mesh->n_nodes, s);
        status = narrow_offsets(&surface, s, error);
    }
    if (!status) {
        status = find_wholes(s, error);
    }
    if (!status)
        status = find_shape(&w, mesh, is_fixed, error);
    if (!status)
        describe(&w, info);
    pl_free(is_fixed);
    pl_free(w.beside);
    pl_free(w.kind);
    pl_free(w.stays);
    pl_free(w.n_ends);
    pl_free(w.n_features);
    pl_free(w.hub);
    pl_free(w.hub_facet);
    pl_free(w.likeness);
    pl_free(w.normal);
    pl_free(w.corner_normal);
    pl_surface_destroy(&surface);
    if (status)
        pl_shape_destroy(s);
    else
        *shape = s;
    return status;
}

void pl_shape_destroy(planish_shape *shape) {
    if (!shape)
        return;
    pl_free(shape->number);
    pl_free(shape->node);
    pl_free(shape->x);
    pl_free(shape->edge_length);
    pl_free(shape->node_class);
    pl_free(shape->facet);
    pl_free(shape->normal);
    pl_free(shape->across);
    pl_free(shape->patch);
    pl_free(shape->is_interface);
    pl_free(shape->half);
    pl_free(shape->offset);
    pl_free(shape->facet_of);
    pl_free(shape->edge);
    pl_free(shape->edge_facet);
    pl_free(shape->edge_at);
    pl_free(shape->normal_at);
    pl_free(shape->corner_normal);
    pl_free(shape->tangent);
    pl_free(shape->whole);
    pl_free(shape->whole_of);
    pl_free(shape->bend);
    pl_free(shape->star_offset);
    pl_free(shape->star);
    pl_free(shape);
}
