/* slides: planish_find_slides, which nodes of a mesh can slide on what. */
#include "shape/slides.h"

#include "shape/shape.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "topology/topology.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

/* Without a tolerance of the caller's: this fraction of the diagonal, for doubles of 8 digits. */
#define TOLERANCE 1e-8

/** The decision about each node of the surface. */
typedef struct decision {
    const planish_mesh *mesh;
    const pl_surface *surface;
    const pl_planes *planes; /* 3-D */
    const pl_lines *lines;
    const int32_t *n_ridges; /* [n_nodes] ridges that end at each node */
    const uint8_t *is_fixed; /* [nodes of the mesh] */
    int tagged_only;
    uint8_t *constraint;
    double *direction;
    planish_slide_info *info;
} decision;

/** Whether all facets of a node are planar, and may be slid on. */
static int has_planes(const decision *d, int32_t node) {
    const pl_surface *s = d->surface;
    for (int64_t i = s->offset[node]; i < s->offset[node + 1]; i++) {
        const int32_t facet = s->facet_of[i];
        if ((d->planes && d->planes->of_facet[facet] < 0) ||
            (d->tagged_only && !s->label[facet].is_tagged) || s->label[facet].n_elements > 2)
            return 0;
    }
    return 1;
}

/** The plane of the i-th facet of a node. */
static int32_t plane_at(const decision *d, int64_t i) {
    return d->planes->of_facet[d->surface->facet_of[i]];
}

/** Whether all facets of a node are of one plane: other sheets may touch at it without sharing an
 *  edge there. */
static int has_one_plane(const decision *d, int32_t node) {
    const pl_surface *s = d->surface;
    for (int64_t i = s->offset[node]; i < s->offset[node + 1]; i++)
        if (plane_at(d, i) != plane_at(d, s->offset[node]))
            return 0;
    return 1;
}

static int has_node(const pl_surface *s, int32_t facet, int32_t node) {
    const int32_t *v = s->facet + (int64_t)facet * 3;
    return v[0] == node || v[1] == node || v[2] == node;
}

/** Whether the planes of all facets of a node hold its line: each has a facet at the line. */
static int planes_hold_line(const decision *d, int32_t node) {
    const pl_surface *s = d->surface;
    const int64_t begin = s->offset[node], end = s->offset[node + 1];
    const int32_t *next = d->lines->next[node];
    for (int64_t i = begin; d->planes && i < end; i++) {
        int holds = 0;
        for (int64_t k = begin; k < end && !holds; k++)
            holds = plane_at(d, k) == plane_at(d, i) &&
                    (has_node(s, s->facet_of[k], next[0]) || has_node(s, s->facet_of[k], next[1]));
        if (!holds)
            return 0;
    }
    return 1;
}

/** How the node can move, and the direction for that. */
static planish_constraint decide(const decision *d, int32_t node, const double **direction) {
    const pl_surface *s = d->surface;
    if (d->is_fixed[s->node[node]] || !has_planes(d, node))
        return PLANISH_FIXED;
    if (d->lines->of_node[node] >= 0) {
        if (!planes_hold_line(d, node))
            return PLANISH_FIXED;
        *direction = d->lines->direction + 3 * (int64_t)d->lines->of_node[node];
        return PLANISH_ON_LINE;
    }
    if (d->planes && d->n_ridges[node] == 0) {
        if (!has_one_plane(d, node))
            return PLANISH_FIXED;
        *direction = d->planes->normal + 3 * (int64_t)plane_at(d, s->offset[node]);
        return PLANISH_ON_PLANE;
    }
    return PLANISH_FIXED;
}

/** Begin the outputs with the mesh's own constraints and directions, once nothing can fail any
 *  more. */
static void begin_outputs(const decision *d) {
    const planish_mesh *mesh = d->mesh;
    const size_t n = (size_t)mesh->n_nodes, size = n * (size_t)mesh->dim * sizeof *d->direction;
    if (!mesh->constraint)
        memset(d->constraint, PLANISH_FREE, n);
    else if (mesh->constraint != d->constraint)
        memcpy(d->constraint, mesh->constraint, n);
    if (!mesh->direction)
        memset(d->direction, 0, size);
    else if (mesh->direction != d->direction)
        memcpy(d->direction, mesh->direction, size);
}

static void decide_all(const decision *d) {
    const pl_surface *s = d->surface;
    const int dim = s->dim;
    for (int32_t node = 0; node < s->n_nodes; node++) {
        const int64_t i = s->node[node];
        const double *direction = NULL;
        if (d->constraint[i] != PLANISH_FREE)
            continue;
        d->constraint[i] = (uint8_t)decide(d, node, &direction);
        d->info->n_on_plane += d->constraint[i] == PLANISH_ON_PLANE;
        d->info->n_on_line += d->constraint[i] == PLANISH_ON_LINE;
        for (int k = 0; direction && k < dim; k++)
            d->direction[i * dim + k] = direction[k];
    }
}

/* ---- the steps ------------------------------------------------------------------------------ */

/** Look at the shape and decide. is_fixed [nodes of the mesh]. */
static int find_shape(decision *d, const planish_surface *tags, const pl_surface *surface,
                      uint8_t *is_fixed, planish_error *error) {
    const double tolerance = (tags && tags->tolerance > 0 ? tags->tolerance : TOLERANCE);
    const double length = tolerance * surface->size;
    pl_planes planes = {0};
    pl_ridges ridges = {0};
    pl_lines lines = {0};
    int32_t *n_ridges = pl_alloc_zero(surface->n_nodes, sizeof *n_ridges);
    int status = n_ridges ? PLANISH_OK : pl_fail_memory(error, "the surface");
    if (!status)
        status = surface->dim == 3
                     ? pl_planes_create(surface, tags, length, &planes, &ridges, is_fixed, error)
                     : pl_ridges_of_plane_mesh(surface, &ridges, error);
    if (!status)
        status = pl_lines_create(surface, &ridges, length, &lines, error);
    for (int64_t i = 0; !status && i < ridges.n; i++)
        for (int j = 0; j < 2; j++)
            n_ridges[ridges.ridge[i].node[j]]++;
    if (!status) {
        d->surface = surface;
        d->planes = surface->dim == 3 ? &planes : NULL;
        d->lines = &lines;
        d->n_ridges = n_ridges;
        begin_outputs(d);
        decide_all(d);
    }
    d->planes = NULL;
    d->lines = NULL;
    d->n_ridges = NULL;
    pl_free(n_ridges);
    pl_free(ridges.ridge);
    pl_planes_destroy(&planes);
    pl_lines_destroy(&lines);
    return status;
}

int pl_find_slides(const planish_mesh *mesh, const planish_surface *tags, int threads,
                   uint8_t *constraint, double *direction, planish_slide_info *info,
                   planish_error *error) {
    pl_surface surface;
    uint8_t *is_fixed = pl_alloc_zero(mesh->n_nodes, 1);
    if (!is_fixed)
        return pl_fail_memory(error, "the surface");
    decision d = {.mesh = mesh,
                  .is_fixed = is_fixed,
                  .tagged_only = tags && tags->tagged_only,
                  .constraint = constraint,
                  .direction = direction,
                  .info = info};
    int status = pl_surface_create(mesh, tags, threads, &surface, is_fixed, error);
    if (!status) {
        info->n_surface = surface.n_nodes;
        status = pl_hold_twins(&surface, is_fixed, error);
        if (!status)
            status = find_shape(&d, tags, &surface, is_fixed, error);
        pl_surface_destroy(&surface);
    }
    for (int64_t i = 0; i < mesh->n_nodes && !status; i++)
        if (is_fixed[i] && constraint[i] == PLANISH_FREE)
            constraint[i] = PLANISH_FIXED;
    pl_free(is_fixed);
    return status;
}
