/* slides: planish_find_slides, which nodes of a mesh can slide on what. */
#include "shape/shape.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/cell.h"
#include "shape/curved.h"
#include "shape/lines.h"
#include "topology/points.h"

#include <string.h>

/* Without a tolerance of the caller's: this fraction of the diagonal, for doubles of 8 digits. */
#define TOLERANCE 1e-8

/** The decision about each node of the surface. */
typedef struct decision {
    const pl_surface *surface;
    const pl_planes *planes; /* 3-D */
    const pl_lines *lines;
    const uint8_t *is_fixed;     /* [nodes of the mesh] PL_FIXED_ALWAYS, PL_FIXED_UNLESS_CURVED */
    const planish_surface *tags; /* or NULL */
    uint8_t *constraint;
    double *direction;
    planish_slide_info *info;
} decision;

/** The plane of the i-th facet of a node. */
static int32_t plane_at(const decision *d, int64_t i) {
    return d->planes->of_facet[d->surface->facet_of[i]];
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

/** Return how the node can move on planes and lines, and the direction for that. */
static planish_constraint decide_flat(const decision *d, int32_t node, const double **direction) {
    const pl_surface *s = d->surface;
    const int64_t begin = s->offset[node], end = s->offset[node + 1];
    /* other sheets may touch at the node without sharing an edge there */
    int is_one_plane = d->planes && d->lines->n_ridges[node] == 0;
    if (d->is_fixed[s->node[node]])
        return PLANISH_CONSTRAINT_FIXED;
    for (int64_t i = begin; i < end; i++) {
        const pl_label *label = &s->label[s->facet_of[i]];
        if ((d->planes && plane_at(d, i) < 0) ||
            (d->tags && d->tags->tagged_only && !label->is_tagged) || label->n_elements > 2)
            return PLANISH_CONSTRAINT_FIXED;
        is_one_plane &= d->planes && plane_at(d, i) == plane_at(d, begin);
    }
    if (d->lines->of_node[node] >= 0) {
        if (!planes_hold_line(d, node))
            return PLANISH_CONSTRAINT_FIXED;
        *direction = d->lines->direction + 3 * (int64_t)d->lines->of_node[node];
        return PLANISH_CONSTRAINT_ON_LINE;
    }
    if (!is_one_plane)
        return PLANISH_CONSTRAINT_FIXED;
    *direction = d->planes->normal + 3 * (int64_t)plane_at(d, begin);
    return PLANISH_CONSTRAINT_ON_PLANE;
}

/** Whether the facets at a node are those of the shape, which was made of the same mesh. */
static int has_shape(const pl_surface *s, const planish_shape *shape, int32_t node) {
    const int32_t own = shape->number[s->node[node]];
    const int64_t begin = s->offset[node], n = s->offset[node + 1] - begin;
    int64_t n_own = 0, at = 0;
    const int32_t *facets = own < 0 ? NULL : pl_shape_star(shape, own, &n_own);
    for (int64_t i = 0; i < n; i++) {
        const int32_t f = s->facet_of[begin + i], *a = s->facet + (int64_t)f * 3;
        const int is_second = shape->whole && s->half && s->half[f] == 2 && i > 0 &&
                              s->facet_of[begin + i - 1] == f - 1; /* half of the same facet */
        if (!facets || (!is_second && at >= n_own))
            return 0;
        if (!is_second)
            at += pl_shape_parts(shape, facets[at]);
        int n_corners = 0;
        const int32_t *b = pl_shape_corners(shape, facets[at - 1], &n_corners);
        for (int j = 0; j < 3; j++) {
            int any = 0;
            for (int k = 0; k < n_corners; k++)
                any |= shape->number[s->node[a[j]]] == b[k];
            if (!any)
                return 0;
        }
    }
    return own >= 0 && at == n_own;
}

/** Whether the nodes that follow a node can move along with it: on its patch, or its curve. */
static int mids_can_move(const planish_shape *shape, int32_t own) {
    int64_t n = 0;
    const int32_t *facets = pl_shape_star(shape, own, &n);
    for (int64_t i = 0; shape->whole && i < n; i += pl_shape_parts(shape, facets[i])) {
        const pl_whole *whole = pl_whole_of(shape, facets[i]);
        int follower[PL_WHOLE_FOLLOWERS];
        const int n_followers = pl_whole_followers(whole, own, follower);
        for (int j = 0; j < n_followers; j++) {
            const int by = shape->node_class[whole->node[follower[j]]];
            if (by != PL_ON_PATCH && (by != PL_ON_CURVE || shape->node_class[own] != PL_ON_CURVE))
                return 0;
        }
    }
    return 1;
}

/** Return how a node that does not slide on a plane or line can move on the shape. */
static planish_constraint decide_curved(const decision *d, int32_t node) {
    const pl_surface *s = d->surface;
    const planish_shape *shape = d->tags->shape;
    if (d->is_fixed[s->node[node]] & PL_FIXED_ALWAYS || !has_shape(s, shape, node) ||
        !mids_can_move(shape, shape->number[s->node[node]]))
        return PLANISH_CONSTRAINT_FIXED;
    for (int64_t i = s->offset[node]; i < s->offset[node + 1]; i++) {
        const pl_label *label = &s->label[s->facet_of[i]];
        if ((d->tags->tagged_only && !label->is_tagged) || label->n_elements > 2 ||
            (label->n_elements == 2 && !d->tags->slide_interfaces))
            return PLANISH_CONSTRAINT_FIXED;
    }
    static const planish_constraint AS[] = {[PL_CORNER] = PLANISH_CONSTRAINT_FIXED,
                                            [PL_ON_PATCH] = PLANISH_CONSTRAINT_ON_PATCH,
                                            [PL_ON_CURVE] = PLANISH_CONSTRAINT_ON_CURVE};
    return AS[shape->node_class[shape->number[s->node[node]]]];
}

/** Whether a facet at a node has edges with other nodes than it can use: what the node's facets share with
 *  their neighbours is not known. */
static int is_torn(const planish_shape *shape, int32_t own) {
    int64_t n = 0;
    const int32_t *facets = own < 0 || !shape->whole ? NULL : pl_shape_star(shape, own, &n);
    int any = 0;
    for (int64_t i = 0; i < n; i++)
        any |= pl_whole_of(shape, facets[i])->is_held;
    return any;
}

/** Return how the node can move, and the direction for that. */
static planish_constraint decide(const decision *d, int32_t node, const double **direction) {
    if (d->tags && d->tags->shape &&
        is_torn(d->tags->shape, d->tags->shape->number[d->surface->node[node]]))
        return PLANISH_CONSTRAINT_FIXED;
    const planish_constraint flat = decide_flat(d, node, direction);
    return flat == PLANISH_CONSTRAINT_FIXED && d->tags && d->tags->shape ? decide_curved(d, node)
                                                                         : flat;
}

/** Write constraints and directions: first the mesh's own, then those of its surface. Nothing can
 *  fail any more. */
static void write_outputs(const decision *d, const planish_mesh *mesh) {
    const pl_surface *s = d->surface;
    const int dim = s->dim;
    const size_t n = (size_t)mesh->n_nodes, size = n * (size_t)dim * sizeof *d->direction;
    if (!mesh->constraint)
        memset(d->constraint, PLANISH_CONSTRAINT_FREE, n);
    else if (mesh->constraint != d->constraint)
        memcpy(d->constraint, mesh->constraint, n);
    if (!mesh->direction)
        memset(d->direction, 0, size);
    else if (mesh->direction != d->direction)
        memcpy(d->direction, mesh->direction, size);
    for (int32_t node = 0; node < s->n_nodes; node++) {
        const int64_t i = s->node[node];
        const double *direction = NULL;
        if (d->constraint[i] != PLANISH_CONSTRAINT_FREE)
            continue;
        d->constraint[i] = (uint8_t)decide(d, node, &direction);
        d->info->n_on_plane += d->constraint[i] == PLANISH_CONSTRAINT_ON_PLANE;
        d->info->n_on_line += d->constraint[i] == PLANISH_CONSTRAINT_ON_LINE;
        d->info->n_on_patch += d->constraint[i] == PLANISH_CONSTRAINT_ON_PATCH;
        d->info->n_on_curve += d->constraint[i] == PLANISH_CONSTRAINT_ON_CURVE;
        for (int k = 0; direction && k < dim; k++)
            d->direction[i * dim + k] = direction[k];
    }
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        if (d->is_fixed[i] && d->constraint[i] == PLANISH_CONSTRAINT_FREE)
            d->constraint[i] = PLANISH_CONSTRAINT_FIXED;
}

/** Fix nodes of the surface at the place of another one. Parts of a mesh that were written side by
 *  side (the pieces of a parallel program, bodies that are tied) have the nodes between them twice,
 *  and so does a crack. Each would slide for its own star, and a gap would open. */
static int hold_twins(const pl_surface *surface, uint8_t *is_fixed, planish_error *error) {
    const pl_points points = {surface->x, surface->n_nodes, surface->dim, surface->dim, 1, NULL};
    uint8_t *is_doubled = pl_alloc(surface->n_nodes, sizeof *is_doubled);
    if (!is_doubled)
        return pl_fail_memory(error, "the surface");
    const int status = pl_points_find_doubled(&points, is_doubled, error);
    for (int64_t i = 0; !status && i < surface->n_nodes; i++)
        if (is_doubled[i])
            is_fixed[surface->node[i]] = PL_FIXED_ALWAYS;
    pl_free(is_doubled);
    return status;
}

/** List the edges of the shape in 2-D: all facets. */
static int list_ridges(const pl_surface *surface, pl_ridges *ridges, planish_error *error) {
    ridges->ridge = pl_alloc(surface->n_facets, sizeof *ridges->ridge);
    if (!ridges->ridge)
        return pl_fail_memory(error, "the edges of the surface");
    for (int64_t i = 0; i < surface->n_facets; i++) {
        const int32_t *node = surface->facet + 2 * i;
        ridges->ridge[i] = (pl_ridge){{node[0], node[1]}, surface->label[i]};
    }
    ridges->n = ridges->capacity = surface->n_facets;
    return PLANISH_OK;
}

/* ---- cells ---------------------------------------------------------------------------------- */

/** A mesh of cells: corners, mids and their surface. */
typedef struct cell_surface {
    const planish_mesh *given; /* the caller's */
    const planish_mesh *dense; /* its corners */
    const pl_surface *surface;
    double tolerance; /* in the surface's units */
    uint8_t how;      /* PL_FIXED_.. the ends of curved edges are */
    uint8_t *is_fixed;
} cell_surface;

/** Compute the vector between two nodes, in the surface's units. */
static void way_between(const cell_surface *c, int32_t from, int32_t to, double way[3]) {
    const int dim = c->dense->dim;
    const double *x = c->dense->coordinates;
    for (int d = 0; d < 3; d++)
        way[d] = d < dim
                     ? (x[(int64_t)to * dim + d] - x[(int64_t)from * dim + d]) * c->surface->scale
                     : 0;
}

/** Whether node is off the plane of a triangle, which is then part of a curved surface. */
static int is_off_plane(const cell_surface *c, const int32_t triangle[3], int32_t node) {
    double side[2][3], normal[3], way[3];
    way_between(c, triangle[0], triangle[1], side[0]);
    way_between(c, triangle[0], triangle[2], side[1]);
    way_between(c, triangle[0], node, way);
    pl_cross(side[0], side[1], normal);
    return !(fabs(pl_dot(3, normal, way)) <= c->tolerance * pl_length(normal));
}

/** Whether a facet, its corners [4], has a and b, and all of its corners are on the surface. */
static int may_be_curved(const cell_surface *c, const int8_t *facet, const int32_t *node, int a,
                         int b) {
    int n = 0, all = 1;
    for (int i = 0; i < 4 && facet[i] >= 0; i++) {
        n += facet[i] == a || facet[i] == b;
        all &= c->surface->number[node[facet[i]]] >= 0;
    }
    return n == 2 && all;
}

static void fix(const cell_surface *c, int32_t a, int32_t b) {
    c->is_fixed[a] |= c->how;
    c->is_fixed[b] |= c->how;
}

/** Fix the ends of a curved edge of a cell if both are on the surface, and the other corners there
 *  of whose facets the edge makes curved ones. The middle of a facet fixes no ends: it may be
 *  anywhere in the plane. node: of the cell; a, b: corners; mid: their mid. */
static void fix_curved(const cell_surface *c, const pl_cell_type *type, const int32_t *node, int a,
                       int b, int mid) {
    const int32_t *number = c->surface->number;
    const int is_edge = mid < type->shape->n_corners + type->shape->n_edges;
    if (number[node[a]] < 0 || number[node[b]] < 0)
        return;
    if (is_edge)
        fix(c, node[a], node[b]);
    for (int k = 0; c->dense->dim == 3 && k < type->shape->n_facets; k++) {
        const int8_t *facet = type->shape->facet[k];
        for (int i = 0; i < 4 && facet[i] >= 0 && may_be_curved(c, facet, node, a, b); i++) {
            const int j = facet[i];
            const int32_t triangle[3] = {node[a], node[b], node[j]};
            if (j == a || j == b || !is_off_plane(c, triangle, node[mid]))
                continue;
            fix(c, node[a], node[b]);
            fix(c, node[j], node[j]);
        }
    }
}

/** Whether a cell has mids, and two of its corners are on the surface. */
static int may_have_edge(const cell_surface *c, int64_t cell) {
    const pl_cell_type *type = pl_cell_type_of(c->given->cells->type[cell]);
    const int dim = c->dense->dim;
    const int32_t *node = c->given->cells->node + c->given->cells->offset[cell];
    int n = 0;
    if (!pl_is_smoothed(c->given->cells, cell, dim) || type->order == 1)
        return 0;
    for (int j = 0; j < type->shape->n_corners; j++)
        n += c->surface->number[node[j]] >= 0;
    return n >= 2;
}

/** Fix the nodes of the surface at its curved edges, and those that cells hold. Mids follow. */
static void fix_by_cells(const cell_surface *c, const uint8_t *role) {
    const planish_cells *cells = c->given->cells;
    const double rounding = c->tolerance / c->surface->scale;
    for (int64_t i = 0; i < cells->n; i++) {
        if (!may_have_edge(c, i))
            continue;
        const int curved = pl_curved_edges(c->given, i, rounding);
        const pl_cell_type *type = pl_cell_type_of(cells->type[i]);
        const int k = type->shape->n_corners;
        for (int e = 0; curved >> e; e++)
            if (curved >> e & 1)
                fix_curved(c, type, cells->node + cells->offset[i], type->between[k + e][0],
                           type->between[k + e][1], k + e);
    }
    for (int64_t i = 0; i < c->dense->n_nodes; i++)
        c->is_fixed[i] = pl_follows(role[i])  ? 0
                         : role[i] & PL_STAYS ? PL_FIXED_ALWAYS
                                              : c->is_fixed[i];
}

/* ---- mids between regions ------------------------------------------------------------------- */

/** Whether two nodes of the surface are of one facet that has elements on both sides. */
static int are_between(const pl_surface *s, int32_t a, int32_t b) {
    for (int64_t i = s->offset[a]; i < s->offset[a + 1]; i++) {
        const int32_t *facet = s->facet + (int64_t)s->facet_of[i] * s->dim;
        if (s->label[s->facet_of[i]].n_elements < 2)
            continue;
        for (int k = 0; k < s->dim; k++)
            if (facet[k] == b)
                return 1;
    }
    return 0;
}

/** Give a mid the constraint of an end that slides on a plane or line, or FIXED if none does. */
static void bind_mid(const decision *d, int32_t mid, const int32_t end[2]) {
    const int dim = d->surface->dim;
    const int32_t by = end[d->constraint[end[0]] == PLANISH_CONSTRAINT_FIXED];
    if (d->constraint[by] == PLANISH_CONSTRAINT_FREE ||
        d->constraint[by] >= PLANISH_CONSTRAINT_ON_SURFACE)
        return;
    d->constraint[mid] = d->constraint[by];
    memcpy(d->direction + (int64_t)mid * dim, d->direction + (int64_t)by * dim,
           (size_t)dim * sizeof *d->direction);
}

/** Bind the mids of edges between regions, which are not to move on their own: nothing else tells the plan
 *  that they are of the surface. */
static void bind_mids(const decision *d, const cell_surface *c, const uint8_t *role) {
    const planish_cells *cells = c->given->cells;
    const int32_t *number = d->surface->number;
    for (int64_t i = 0; i < cells->n; i++) {
        if (!may_have_edge(c, i))
            continue;
        const pl_cell_type *type = pl_cell_type_of(cells->type[i]);
        const int32_t *node = cells->node + cells->offset[i];
        for (int e = 0; e < type->shape->n_edges; e++) {
            const int k = type->shape->n_corners + e;
            const int32_t end[2] = {node[type->between[k][0]], node[type->between[k][1]]};
            if (node[k] >= 0 && pl_follows(role[node[k]]) && number[end[0]] >= 0 &&
                number[end[1]] >= 0 && d->constraint[node[k]] == PLANISH_CONSTRAINT_FREE &&
                are_between(d->surface, number[end[0]], number[end[1]]))
                bind_mid(d, node[k], end);
        }
    }
}

/* ---- all of it ------------------------------------------------------------------------------ */

int pl_find_slides(const pl_dense *dense, const planish_mesh *given, const planish_surface *tags,
                   int threads, uint8_t *constraint, double *direction, planish_slide_info *info,
                   planish_error *error) {
    const planish_mesh *mesh = &dense->mesh;
    double tolerance = tags && tags->tolerance > 0 ? tags->tolerance : TOLERANCE;
    const int has_cells = dense->corner || (given->cells && pl_is_of_faces(given->cells, 3));
    const planish_cells *cells = has_cells ? given->cells : NULL;
    pl_surface surface = {0};
    pl_planes planes = {0};
    pl_ridges ridges = {0};
    pl_lines lines = {0};
    uint8_t *is_fixed = pl_alloc_zero(mesh->n_nodes, 1);
    int status = is_fixed ? pl_surface_create(mesh, cells, tags, threads, &surface, is_fixed, error)
                          : pl_fail_memory(error, "the surface");
    if (!status)
        status = hold_twins(&surface, is_fixed, error);
    tolerance *= surface.size;
    if (!status)
        status = mesh->dim == 3 ? pl_planes_create(&surface, tags, tolerance, &planes, &ridges,
                                                   is_fixed, error)
                                : list_ridges(&surface, &ridges, error);
    if (!status)
        status = pl_lines_create(&surface, &ridges, tolerance, &lines, error);
    const int goes_on = tags && tags->shape && tags->shape->whole;
    const uint8_t how = goes_on ? PL_FIXED_UNLESS_CURVED : PL_FIXED_ALWAYS;
    const cell_surface of_cells = {given, mesh, &surface, tolerance, how, is_fixed};
    if (!status && dense->role)
        fix_by_cells(&of_cells, dense->role);
    if (!status) {
        const decision d = {.surface = &surface,
                            .planes = mesh->dim == 3 ? &planes : NULL,
                            .lines = &lines,
                            .is_fixed = is_fixed,
                            .tags = tags,
                            .constraint = constraint,
                            .direction = direction,
                            .info = info};
        info->n_surface = surface.n_nodes;
        write_outputs(&d, mesh);
        if (dense->role)
            bind_mids(&d, &of_cells, dense->role);
    }
    pl_free(is_fixed);
    pl_free(ridges.ridge);
    pl_planes_destroy(&planes);
    pl_lines_destroy(&lines);
    pl_surface_destroy(&surface);
    return status;
}
