/* begin: the caller's surface mesh in and out. */
#include "surface/begin.h"

#include "base/clock.h"
#include "base/memory.h"
#include "base/status.h"
#include "geometry/cell.h"
#include "topology/points.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

/* ---- what is asked for ---------------------------------------------------------------------- */

/** Refuse options that mean nothing on a surface. */
static int check_meaning(const pl_surface_run *r, planish_error *error) {
    const planish_options *o = r->options;
    const int has_quads = r->shape->half != NULL;
    const planish_worst of_corners[] = {PLANISH_WORST_ASPECT_RATIO, PLANISH_WORST_SCALED_JACOBIAN};
    if (o->method != PLANISH_METHOD_PLANISH)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.method %d is not for surfaces in space; give "
                       "PLANISH_METHOD_PLANISH",
                       (int)o->method);
    if (o->objective == PLANISH_OBJECTIVE_EDGE_RATIO)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.objective PLANISH_OBJECTIVE_EDGE_RATIO is not for surfaces in "
                       "space; give _RADIUS_RATIO or _MEAN_RATIO");
    if (o->project)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.project is not for surfaces in space, whose nodes move along "
                       "options.shape; give NULL");
    if (o->min_volume > 0 || o->min_volume_fraction > 0 || o->area_weight > 0)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.min_volume, min_volume_fraction and area_weight are not for "
                       "surfaces in space; give 0");
    if (o->worst != PLANISH_WORST_NONE &&
        has_quads != (o->worst == of_corners[0] || o->worst == of_corners[1]))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.worst %d is not for this surface; give PLANISH_WORST_%s",
                       (int)o->worst,
                       has_quads ? "ASPECT_RATIO or _SCALED_JACOBIAN for quadrilaterals"
                                 : "RADIUS_RATIO or _ANGLE for triangles");
    return PLANISH_OK;
}

/** Whether a node is to slide on a plane or line that mesh->direction does not tell. */
static int lacks_direction(const planish_mesh *mesh, int64_t node) {
    double unit[3];
    return (mesh->constraint[node] == PLANISH_CONSTRAINT_ON_PLANE ||
            mesh->constraint[node] == PLANISH_CONSTRAINT_ON_LINE) &&
           !(mesh->direction && pl_unit(3, mesh->direction + 3 * node, unit));
}

/** Refuse constraints that there are not, and those that lack a direction. */
static int check_constraints(const planish_mesh *mesh, planish_error *error) {
    for (int64_t i = 0; mesh->constraint && i < mesh->n_nodes; i++) {
        if (mesh->constraint[i] > PLANISH_CONSTRAINT_ON_CURVE)
            return pl_fail_at(error, PLANISH_ERROR_ARGUMENT, -1, i,
                              "mesh.constraint of node %" PRId64
                              " is %d; give a planish_constraint, 0 to %d",
                              i, mesh->constraint[i], PLANISH_CONSTRAINT_ON_CURVE);
        if (lacks_direction(mesh, i))
            return pl_fail_at(error, PLANISH_ERROR_ARGUMENT, -1, i,
                              "node %" PRId64
                              " slides, but mesh.direction has none for it; give the normal of its "
                              "plane, or the direction of its line",
                              i);
    }
    return PLANISH_OK;
}

/** Refuse bounds that are no numbers. */
static int check_bounds(const pl_surface_run *r, planish_error *error) {
    const double *bounds[] = {r->options->lower, r->options->upper};
    for (int which = 0; which < 2; which++)
        for (int64_t i = 0; bounds[which] && i < 3 * r->mesh->n_nodes; i++)
            if (isnan(bounds[which][i]))
                return pl_fail_at(error, PLANISH_ERROR_ARGUMENT, -1, i / 3,
                                  "options.%s of node %" PRId64
                                  " is not a number; give a bound, or an infinite one for none",
                                  which ? "upper" : "lower", i / 3);
    return PLANISH_OK;
}

/** Whether node [n] has the three corners of a facet. */
static int has_corners(const planish_shape *s, int64_t facet, const int32_t *node, int n) {
    int has_all = 1;
    for (int k = 0; k < 3; k++) {
        int has_it = 0;
        for (int j = 0; j < n; j++)
            has_it |= node[j] == s->node[s->facet[facet][k]];
        has_all &= has_it;
    }
    return has_all;
}

int pl_surface_check_elements(const planish_mesh *mesh, const planish_shape *shape,
                              planish_error *error) {
    const planish_cells *cells = mesh->cells;
    int64_t facet = 0, i = 0;
    for (; i < cells->n; i++) {
        const pl_cell_type *type = pl_cell_type_of(cells->type[i]);
        if (!type || type->shape->dim != 2)
            continue;
        const int n = type->shape->n_corners, is_quad = n == 4;
        if (facet + is_quad >= shape->n_facets ||
            (shape->half && shape->half[facet] != 0) != is_quad ||
            !has_corners(shape, facet, cells->node + cells->offset[i], n))
            break;
        facet += 1 + is_quad;
    }
    if (i < cells->n)
        return pl_fail_at(error, PLANISH_ERROR_ARGUMENT, i, -1,
                          "shape was not made of these elements: it has other ones from element "
                          "%" PRId64 " on",
                          i);
    return facet == shape->n_facets
               ? PLANISH_OK
               : pl_fail(error, PLANISH_ERROR_ARGUMENT,
                         "shape was not made of these elements alone: it has more of them");
}

static int check_call(pl_surface_run *r, planish_error *error) {
    const planish_mesh *mesh = r->mesh;
    r->shape = r->options->shape;
    if (!r->shape)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.shape is NULL; make it by planish_shape_create");
    if (r->shape->n_mesh != mesh->n_nodes)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.shape was made of a mesh of %" PRId64 " nodes, mesh has %" PRId64
                       "; make it of this mesh",
                       r->shape->n_mesh, mesh->n_nodes);
    int status = pl_surface_check_elements(mesh, r->shape, error);
    if (!status)
        status = check_meaning(r, error);
    if (!status)
        status = check_constraints(mesh, error);
    if (!status)
        status = check_bounds(r, error);
    if (status)
        return status;
    const pl_points points = pl_points_of(mesh, r->coordinates);
    return pl_points_check(&points, r->threads, error);
}

/* ---- which nodes move ----------------------------------------------------------------------- */

/** How a node slides: as the mesh says, or as the shape does. */
static planish_constraint slides_by(const planish_mesh *mesh, const planish_shape *s,
                                    int32_t node) {
    const int constraint =
        mesh->constraint ? mesh->constraint[s->node[node]] : PLANISH_CONSTRAINT_FREE;
    if (constraint != PLANISH_CONSTRAINT_FREE)
        return (planish_constraint)constraint;
    return s->node_class[node] == PL_ON_PATCH   ? PLANISH_CONSTRAINT_ON_PATCH
           : s->node_class[node] == PL_ON_CURVE ? PLANISH_CONSTRAINT_ON_CURVE
                                                : PLANISH_CONSTRAINT_FIXED;
}

/** Whether a node may slide so. */
static int may_slide(const planish_mesh *mesh, const planish_shape *shape, int32_t node) {
    const planish_constraint by = slides_by(mesh, shape, node);
    const int node_class = shape->node_class[node];
    return by == PLANISH_CONSTRAINT_ON_PLANE || by == PLANISH_CONSTRAINT_ON_LINE ||
           (by == PLANISH_CONSTRAINT_ON_PATCH && node_class == PL_ON_PATCH) ||
           (by == PLANISH_CONSTRAINT_ON_CURVE && node_class == PL_ON_CURVE);
}

/** Hold the nodes of elements of order 2: their mids would have to follow along the surface. */
static void hold_mids(const planish_mesh *mesh, const planish_shape *shape, uint8_t *moves) {
    const planish_cells *cells = mesh->cells;
    for (int64_t i = 0; i < cells->n; i++) {
        const pl_cell_type *type = pl_cell_type_of(cells->type[i]);
        for (int64_t k = cells->offset[i]; type && type->order > 1 && k < cells->offset[i + 1]; k++)
            if (cells->node[k] >= 0 && shape->number[cells->node[k]] >= 0)
                moves[shape->number[cells->node[k]]] = 0;
    }
}

void pl_surface_find_moves(const planish_mesh *mesh, const planish_shape *shape, uint8_t *moves) {
    for (int32_t i = 0; i < shape->n_nodes; i++)
        moves[i] = (uint8_t)may_slide(mesh, shape, i);
    hold_mids(mesh, shape, moves);
}

/** Whether an element, a facet or both halves of a quadrilateral from there on, has a chosen node. */
static int has_chosen(const planish_shape *s, int64_t first, const uint8_t *chosen) {
    const int32_t *a = s->facet[first], *b = s->facet[first + (s->half && s->half[first] == 1)];
    return chosen[a[0]] || chosen[a[1]] || chosen[a[2]] || chosen[b[0]] || chosen[b[1]] ||
           chosen[b[2]];
}

/** Let only the nodes of elements above a ratio move, and of rings around these. Errors: _MEMORY. */
static int choose_bad(pl_surface_run *r, planish_error *error) {
    const planish_shape *s = r->shape;
    const double most = r->options->only_worse_than * r->options->only_worse_than;
    uint8_t *chosen = pl_alloc_zero(s->n_nodes, 1), *next = pl_alloc_zero(s->n_nodes, 1);
    int status = chosen && next ? pl_surface_run_measure(r, error)
                                : pl_fail_memory(error, "the surface of a mesh");
    for (int ring = 0; !status && ring <= r->options->rings; ring++) {
        for (int64_t f = 0; f < s->n_facets; f++) {
            const int64_t first = s->half && s->half[f] == 2 ? f - 1 : f;
            const int32_t *v = s->facet[f];
            if (ring > 0 ? has_chosen(s, first, chosen) : r->ratio[first] > most)
                next[v[0]] = next[v[1]] = next[v[2]] = 1;
        }
        memcpy(chosen, next, (size_t)s->n_nodes);
    }
    for (int64_t i = 0; !status && i < s->n_nodes; i++)
        r->moves[i] &= chosen[i];
    pl_free(chosen);
    pl_free(next);
    return status;
}

/* ---- bounds --------------------------------------------------------------------------------- */

/** Whether a node starts outside of its bounds. */
static int is_outside(const pl_surface_run *r, int32_t node) {
    int outside = 0;
    for (int d = 0; d < 3 && r->lower; d++)
        outside |=
            !(r->lower[node][d] <= r->start[node][d] && r->start[node][d] <= r->upper[node][d]);
    return outside;
}

/** Set the bounds of a node; what starts outside of them is held. */
static void bound_node(pl_surface_run *r, int32_t node) {
    const planish_options *o = r->options;
    const int64_t given = r->shape->node[node];
    for (int d = 0; d < 3; d++) {
        const double low = o->lower ? o->lower[3 * given + d] : -INFINITY;
        const double high = o->upper ? o->upper[3 * given + d] : INFINITY;
        r->lower[node][d] = fmax(low, o->box_lower[d]);
        r->upper[node][d] = fmin(high, o->box_upper[d]);
    }
    const int outside = is_outside(r, node);
    r->result->n_held_outside += outside && r->moves[node];
    r->moves[node] &= !outside;
}

/** Make the bounds that options ask for. Errors: _MEMORY. */
static int make_bounds(pl_surface_run *r, planish_error *error) {
    const planish_options *o = r->options;
    const int64_t n = r->shape->n_nodes;
    int bounded = o->lower || o->upper, done = 1;
    for (int d = 0; d < 3; d++)
        bounded |= o->box_lower[d] > -INFINITY || o->box_upper[d] < INFINITY;
    if (bounded) {
        r->lower = pl_alloc(n, sizeof *r->lower);
        r->upper = pl_alloc(n, sizeof *r->upper);
        done = r->lower && r->upper;
    }
    for (int32_t i = 0; bounded && done && i < n; i++)
        bound_node(r, i);
    if (o->max_displacement > 0) {
        r->radius = pl_alloc(n, sizeof *r->radius);
        done = done && r->radius;
    }
    for (int32_t i = 0; r->radius && i < n; i++)
        r->radius[i] = o->max_displacement * (o->displacement_unit == PLANISH_UNIT_EDGE
                                                  ? r->shape->edge_length[i] / r->shape->scale
                                                  : 1);
    return done ? PLANISH_OK : pl_fail_memory(error, "the bounds of the nodes");
}

/* ---- all of it ------------------------------------------------------------------------------ */

/** Allocate what does not depend on which nodes move, and take the coordinates. */
static int take_mesh(pl_surface_run *r, planish_error *error) {
    const int64_t n = r->shape->n_nodes;
    const pl_points points = pl_points_of(r->mesh, r->coordinates);
    r->x = pl_alloc(n, sizeof *r->x);
    r->start = pl_alloc(n, sizeof *r->start);
    r->scaled = pl_alloc(n, sizeof *r->scaled);
    r->before = pl_alloc(n, sizeof *r->before);
    r->is_movable = pl_alloc(n, sizeof *r->is_movable);
    r->moves = pl_alloc(n, sizeof *r->moves);
    r->changed = pl_alloc(n, sizeof *r->changed);
    r->ratio = pl_alloc(r->shape->n_facets, sizeof *r->ratio);
    r->tally = pl_alloc_zero(r->threads, sizeof *r->tally);
    if (!r->x || !r->start || !r->scaled || !r->before || !r->is_movable || !r->moves ||
        !r->changed || !r->ratio || !r->tally)
        return pl_fail_memory(error, "the surface of a mesh");
    for (int32_t i = 0; i < n; i++)
        for (int d = 0; d < 3; d++)
            r->x[i][d] = r->start[i][d] = points.x[pl_point_at(&points, r->shape->node[i], d)];
    pl_surface_find_moves(r->mesh, r->shape, r->is_movable);
    for (int64_t i = 0; i < n; i++)
        r->moves[i] = r->is_movable[i] && !(r->held && r->held[i]);
    return PLANISH_OK;
}

/** Set the plane, line, patch or curve of a star. */
static planish_constraint set_slide(const pl_surface_run *r, int32_t node, pl_star_slide *slide) {
    const planish_constraint by = slides_by(r->mesh, r->shape, node);
    const int64_t given = r->shape->node[node];
    *slide = (pl_star_slide){.kind = by, .node = (int32_t)given};
    memcpy(slide->point, r->x[node], sizeof slide->point);
    if (by == PLANISH_CONSTRAINT_ON_PLANE || by == PLANISH_CONSTRAINT_ON_LINE)
        pl_unit(3, r->mesh->direction + 3 * given, slide->direction);
    return by;
}

/** Make the skin of the stars. */
static int make_skin(pl_surface_run *r, planish_error *error) {
    const int64_t n = r->stars.n_stars;
    const pl_points points = pl_points_of(r->mesh, r->coordinates);
    r->slide = pl_alloc(n, sizeof *r->slide);
    uint8_t *by = pl_alloc(n, sizeof *by);
    r->skin = (pl_skin){.shape = r->shape,
                        .coordinates = r->x[0],
                        .slide = r->slide,
                        .n_stars = n,
                        .threads = r->threads,
                        .storage = pl_storage_of(r->options)};
    int status = r->slide && by ? pl_skin_make(r->options, &r->skin, error)
                                : pl_fail_memory(error, "the surface of a mesh");
    for (int32_t i = 0; !status && i < r->shape->n_nodes; i++) {
        r->skin.inner[i] = i;
        r->skin.star[i] = -1;
        r->skin.moves[i] = PLANISH_CONSTRAINT_FIXED;
    }
    for (int64_t s = 0; !status && s < n; s++) {
        const int32_t node = r->stars.node[s];
        by[s] = (uint8_t)set_slide(r, node, &r->slide[s]);
        r->skin.node[s] = by[s] == PLANISH_CONSTRAINT_FIXED ? -1 : node;
        r->skin.star[node] = (int32_t)s;
    }
    if (!status) {
        pl_skin_find_moves(&r->skin, by);
        status = pl_skin_begin(&r->skin, &points, error);
    }
    for (int64_t s = 0; !status && s < n; s++) {
        const int32_t node = r->stars.node[s];
        r->skin.node[s] = pl_skin_has(&r->skin, node) ? node : -1;
        r->moves[node] = pl_skin_has(&r->skin, node) || r->skin.moves[node] == PL_SKIN_FLAT;
    }
    pl_free(by);
    return status;
}

int pl_surface_run_begin(pl_surface_run *r, planish_error *error) {
    int status = check_call(r, error);
    if (!status)
        status = take_mesh(r, error);
    if (!status)
        status = make_bounds(r, error);
    r->stars = (pl_surface_mesh){.shape = r->shape, .by_radius = r->shape && !r->shape->half};
    if (!status && r->options->only_worse_than > 0)
        status = choose_bad(r, error);
    if (!status)
        status = pl_surface_mesh_create(r->shape, r->moves, r->threads, &r->stars, error);
    if (!status)
        status = make_skin(r, error);
    if (!status)
        status = pl_surface_run_measure(r, error);
    if (status)
        return status;
    r->problem = (pl_surface_problem){.mesh = &r->stars,
                                      .x = r->x,
                                      .start = (const double(*)[3])r->start,
                                      .slide = r->slide,
                                      .skin = &r->skin,
                                      .storage = r->skin.storage,
                                      .lower = (const double(*)[3])r->lower,
                                      .upper = (const double(*)[3])r->upper,
                                      .radius = r->radius,
                                      .changed = r->changed};
    r->result->objective_before = pl_surface_rms(&r->sums);
    return PLANISH_OK;
}

void pl_surface_run_get_held(const pl_surface_run *r, uint8_t *held) {
    memset(held, PLANISH_HELD_BY_NONE, (size_t)r->mesh->n_nodes);
    for (int32_t i = 0; i < r->shape->n_nodes; i++) {
        uint8_t *by = &held[r->shape->node[i]];
        if (!r->is_movable[i])
            continue;
        *by = (uint8_t)(is_outside(r, i) ? PLANISH_HELD_BY_BOUNDS : pl_skin_held_by(&r->skin, i));
        if (*by == PLANISH_HELD_BY_NONE && r->skin.star[i] >= 0 && !r->moves[i])
            *by = PLANISH_HELD_BY_SURFACE;
    }
}

/** Write the nodes that have moved. */
static void write_nodes(pl_surface_run *r) {
    const pl_points points = pl_points_of(r->mesh, r->coordinates);
    for (int64_t i = 0; i < r->shape->n_nodes; i++) {
        const double far = pl_distance(3, r->x[i], r->start[i]);
        if (!(far > 0))
            continue;
        r->result->n_moved_nodes++;
        r->result->max_displacement = fmax(r->result->max_displacement, far);
        for (int d = 0; d < 3; d++)
            r->coordinates[pl_point_at(&points, r->shape->node[i], d)] = r->x[i][d];
    }
}

void pl_surface_run_end(pl_surface_run *r) {
    planish_result *result = r->result;
    write_nodes(r);
    result->stop = r->stop;
    result->sweeps = r->sweep;
    result->n_inverted = r->sums.n_inverted;
    result->rms = pl_surface_rms(&r->sums);
    result->rms_movable = pl_surface_rms_of_movable(&r->sums);
    result->objective = result->rms;
    result->n_off_shape = r->skin.n_off;
    result->seconds = pl_seconds() - r->start_seconds;
}

void pl_surface_run_destroy(pl_surface_run *r) {
    pl_free(r->x);
    pl_free(r->start);
    pl_free(r->scaled);
    pl_free(r->before);
    pl_free(r->lower);
    pl_free(r->upper);
    pl_free(r->radius);
    pl_free(r->is_movable);
    pl_free(r->moves);
    pl_free(r->changed);
    pl_free(r->ratio);
    pl_free(r->slide);
    pl_free(r->tally);
    pl_surface_mesh_destroy(&r->stars);
    pl_skin_destroy(&r->skin);
}
