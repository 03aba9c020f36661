/* skin: where nodes on the surface may go, and how far the surface is off its shape meanwhile. */
#include "sweep/skin.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "shape/overlay.h"
#include "topology/points.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

enum { CHUNK_FACETS = 256 };

/* A visit goes no farther than so many edges: beyond that a plane says little of the surface. */
#define FARTHEST 0.7
/* A smooth edge bends by 40 degrees at most: the square of the cosine. */
#define BEND2 0.5868240888334652
/* A facet turns by 60 degrees at most from where it was first: likewise. */
#define TURN2 0.25
/* What is too far off is tried at half of the way, so often. */
enum { HALVINGS = 5 };
/* Tolerance in edges where options have none. */
#define DEFAULT_TOLERANCE 0.05
/* A patch is planar if its nodes are within so much of its tolerance, and of the size of the shape. */
#define PLANAR_TOLERANCE 1e-3
#define PLANAR_SIZE      1e-8
/* Such patches are off by twice as much: their tolerance is lower. */
#define PLANAR_REST (1 - 2 * PLANAR_TOLERANCE)
/* Distances are rounded up by this. */
#define ROUNDED_UP (1 + 0x1p-40)

/* ---- where nodes are ------------------------------------------------------------------------- */

/** Coordinates of a node, the mesh's. */
static const double *stored(const pl_skin *skin, int32_t node) {
    const int32_t inner = skin->inner[node];
    return inner < 0 ? skin->known[node] : skin->coordinates + (int64_t)inner * 3;
}

/** Coordinates of a node in the shape's units. */
static void place_of(const pl_skin *skin, int32_t node, double x[3]) {
    const double *at = stored(skin, node);
    for (int d = 0; d < 3; d++)
        x[d] = at[d] * skin->shape->scale;
}

/** Place of a node on the shape as it was first. */
static pl_place first_place(const planish_shape *shape, int32_t node) {
    pl_place place = {-1, {0}};
    if (shape->node_class[node] == PL_ON_CURVE) {
        place.at = shape->edge_at[node][0];
        place.weight[shape->edge[place.at][1] == node] = 1;
    } else if (shape->node_class[node] == PL_ON_PATCH) {
        place.at = shape->facet_of[shape->offset[node]];
        const int32_t *facet = shape->facet[place.at];
        place.weight[facet[0] == node ? 0 : facet[1] == node ? 1 : 2] = 1;
    }
    return place;
}

/** Place of a node that may have moved, as far as certificates need it. */
static pl_place present_place(const pl_skin *skin, int32_t node) {
    pl_place place = skin->place[node];
    double x[3];
    if (skin->moves[node] != PL_SKIN_FLAT || place.at < 0)
        return place;
    place_of(skin, node, x);
    pl_shape_walk(skin->shape, skin->shape->node_class[node], x, &place);
    return place;
}

/* ---- facets ---------------------------------------------------------------------------------- */

/** Compute a normal of a facet with corners x, twice its area long, and the square of its length in [3].
 */
static void normal_of(double x[3][3], double normal[4]) {
    double a[3], b[3];
    pl_from_to(3, x[0], x[1], a);
    pl_from_to(3, x[0], x[2], b);
    pl_cross(a, b, normal);
    normal[3] = pl_dot(3, normal, normal);
}

/** Fill x with the corners of a facet, where node is at place (NULL: where it is). */
static void corners_of(const pl_skin *skin, int32_t facet, int32_t node, const double *place,
                       double x[3][3]) {
    for (int j = 0; j < 3; j++) {
        const int32_t corner = skin->shape->facet[facet][j];
        if (corner == node && place)
            memcpy(x[j], place, sizeof x[j]);
        else
            place_of(skin, corner, x[j]);
    }
}

/** Bound how far a facet is off the shape if node is at place, in the shape's units, and there in trial; node
 *  -1: as it is. Above limit: not known. */
static double certify(const pl_skin *skin, int32_t facet, int32_t node, const double *place,
                      const pl_place *trial, double limit) {
    pl_moved_facet moved = {.facet = facet};
    corners_of(skin, facet, node, place, moved.x);
    for (int j = 0; j < 3; j++) {
        const int32_t corner = skin->shape->facet[facet][j];
        moved.place[j] = corner == node ? *trial : present_place(skin, corner);
    }
    const double lateral = pl_overlay_lateral(skin->shape, &moved);
    return lateral <= limit ? pl_overlay_bound(skin->shape, &moved, lateral, limit) : INFINITY;
}

/** Whether all corners of a facet are where they were first. */
static int is_first(const pl_skin *skin, int32_t facet) {
    for (int j = 0; j < 3; j++) {
        const int32_t corner = skin->shape->facet[facet][j];
        double x[3];
        place_of(skin, corner, x);
        if (!pl_skin_is_at(x, skin->shape->x[corner]))
            return 0;
    }
    return 1;
}

static void bound_facets(void *context, int64_t begin, int64_t end, int thread) {
    pl_skin *skin = context;
    (void)thread;
    for (int64_t t = begin; t < end; t++)
        if (isnan(skin->bound[t]))
            skin->bound[t] = is_first(skin, (int32_t)t)
                                 ? 0
                                 : certify(skin, (int32_t)t, -1, NULL, NULL, skin->tolerance[t]);
}

/** Bound the facets whose bound is not a number. Returns the number of facets that are too far off. */
static int64_t bound_all(pl_skin *skin) {
    int64_t n = 0;
    const int64_t n_facets = skin->shape->n_facets;
    pl_parallel_for(pl_paying_threads(skin->threads, n_facets), n_facets, CHUNK_FACETS,
                    bound_facets, skin);
    for (int64_t t = 0; t < skin->shape->n_facets; t++)
        n += !(skin->bound[t] <= skin->tolerance[t]);
    return n;
}

/** Take note of where a node is. */
static void follow(pl_skin *skin, int32_t node) {
    const planish_shape *shape = skin->shape;
    double x[3];
    memcpy(skin->known[node], stored(skin, node), sizeof skin->known[node]);
    place_of(skin, node, x);
    if (pl_skin_is_at(x, shape->x[node]))
        skin->place[node] = first_place(shape, node);
    else if (skin->place[node].at >= 0)
        pl_shape_walk(shape, shape->node_class[node], x, &skin->place[node]);
    for (int64_t i = shape->offset[node]; i < shape->offset[node + 1]; i++)
        skin->bound[shape->facet_of[i]] = NAN;
}

int64_t pl_skin_follow(pl_skin *skin) {
    if (!skin->shape)
        return 0;
    for (int32_t node = 0; node < skin->shape->n_nodes; node++)
        if (pl_skin_has(skin, node) && !pl_skin_is_at(skin->known[node], stored(skin, node)))
            follow(skin, node);
    return bound_all(skin);
}

/* ---- visits ---------------------------------------------------------------------------------- */

void pl_skin_prepare(pl_skin *skin, int thread, pl_skin_visit *visit) {
    double *room = skin->room + skin->room_stride * thread;
    *visit = (pl_skin_visit){.skin = skin, .normal = room + PL_SKIN_TRIALS * skin->max_facets};
    for (int i = 0; i < PL_SKIN_TRIALS; i++)
        visit->trial[i].bound = room + i * skin->max_facets;
}

void pl_skin_begin_visit(pl_skin_visit *visit, int64_t star) {
    const pl_skin *skin = visit->skin;
    visit->star = (int32_t)star;
    visit->node = skin->node[star];
    memcpy(visit->start, stored(skin, visit->node), sizeof visit->start);
    visit->has_direction = visit->is_off = visit->newest = 0;
    for (int i = 0; i < PL_SKIN_TRIALS; i++)
        visit->trial[i].is_known = 0;
}

/** Whether the normals of two facets at a smooth edge are near enough; else *cosine is that between them. */
static int bends_little(const double *a, const double *b, double *cosine) {
    const double product = pl_dot(3, a, b), squares = a[3] * b[3];
    if (product > 0 && product * product >= BEND2 * squares)
        return 1;
    *cosine = squares > 0 ? product / sqrt(squares) : -1;
    return 0;
}

/** Whether the smooth edge from corner k of facet at the node, the i-th, may be as the normals of a trial say:
 *  it bends little, or no more than it does. */
static int keeps_edge(const pl_skin_visit *v, int32_t facet, int64_t i, int k) {
    const pl_skin *skin = v->skin;
    const planish_shape *shape = skin->shape;
    const int32_t other = shape->across[facet][k];
    const int64_t first = shape->offset[v->node], n = shape->offset[v->node + 1] - first;
    double x[3][3], there[4], was[4], cosine, before;
    if (other < 0)
        return 1;
    int64_t at = 0;
    while (at < n && shape->facet_of[first + at] != other)
        at++;
    if (at == n) {
        corners_of(skin, other, -1, NULL, x);
        normal_of(x, there);
    }
    if (bends_little(v->normal + 4 * i, at == n ? there : v->normal + 4 * at, &cosine))
        return 1;
    corners_of(skin, facet, -1, NULL, x);
    normal_of(x, was);
    corners_of(skin, other, -1, NULL, x);
    normal_of(x, there);
    return !bends_little(was, there, &before) && cosine >= before;
}

/** Whether the facets at the node keep their normals, about, if it is at place. */
static int keeps_normals(const pl_skin_visit *v, const double *place) {
    const planish_shape *shape = v->skin->shape;
    const int64_t first = shape->offset[v->node], n = shape->offset[v->node + 1] - first;
    for (int64_t i = 0; i < n; i++) {
        double x[3][3], *normal = v->normal + 4 * i;
        const int32_t facet = shape->facet_of[first + i];
        corners_of(v->skin, facet, v->node, place, x);
        normal_of(x, normal);
        const double along = pl_dot(3, normal, shape->normal[facet]);
        if (!(along > 0 && along * along >= TURN2 * normal[3]))
            return 0;
    }
    for (int64_t i = 0; i < n; i++) {
        const int32_t facet = shape->facet_of[first + i], *corner = shape->facet[facet];
        const int k = corner[0] == v->node ? 0 : corner[1] == v->node ? 1 : 2;
        /* The edge of the third corner is the first one of another facet. */
        if (!keeps_edge(v, facet, i, k) || !keeps_edge(v, facet, i, (k + 1) % 3))
            return 0;
    }
    return 1;
}

/** Whether the facets at the node stay within their tolerance if it is at place, in trial->place: their
 *  bounds are in trial. */
static int keeps_near(const pl_skin_visit *v, const double *place, pl_skin_trial *trial) {
    const pl_skin *skin = v->skin;
    const planish_shape *shape = skin->shape;
    const int64_t first = shape->offset[v->node], n = shape->offset[v->node + 1] - first;
    double start[3], way[3];
    place_of(skin, v->node, start);
    pl_from_to(3, start, place, way);
    const double move = pl_length(way) * ROUNDED_UP;
    for (int64_t i = 0; i < n; i++) {
        const int32_t facet = shape->facet_of[first + i];
        const double tolerance = skin->tolerance[facet];
        double bound = skin->bound[facet] + move;
        if (skin->is_planar[facet] && skin->moves[v->node] == PLANISH_CONSTRAINT_ON_PLANE)
            bound = skin->bound[facet];
        if (!(bound <= tolerance))
            bound = certify(skin, facet, v->node, place, &trial->place, tolerance);
        if (!(bound <= tolerance))
            return 0;
        trial->bound[i] = bound;
    }
    return 1;
}

/** Find the place of the node nearest to x, in the mesh's units, and where that is stored: trial. */
static void find_place(const pl_skin_visit *v, const double *x, pl_skin_trial *trial) {
    const pl_skin *skin = v->skin;
    const planish_shape *shape = skin->shape;
    const pl_star_slide *slide = &skin->slide[v->star];
    const int moves = skin->moves[v->node], node_class = shape->node_class[v->node];
    double at[3];
    trial->place = skin->place[v->node];
    if (moves == PLANISH_CONSTRAINT_ON_PLANE || moves == PLANISH_CONSTRAINT_ON_LINE) {
        double way[3];
        pl_from_to(3, slide->point, x, way);
        const double along = pl_dot(3, way, slide->direction);
        for (int d = 0; d < 3; d++) {
            const double part = along * slide->direction[d];
            way[d] = moves == PLANISH_CONSTRAINT_ON_LINE ? part : way[d] - part;
            trial->x[d] = pl_store(&skin->storage, slide->point[d] + way[d]);
            at[d] = trial->x[d] * shape->scale;
        }
        if (trial->place.at >= 0)
            pl_shape_walk(shape, node_class, at, &trial->place);
        memcpy(trial->direction, slide->direction, sizeof trial->direction);
        return;
    }
    for (int d = 0; d < 3; d++)
        at[d] = x[d] * shape->scale;
    pl_shape_walk(shape, node_class, at, &trial->place);
    pl_shape_point(shape, node_class, &trial->place, at, trial->direction);
    for (int d = 0; d < 3; d++)
        trial->x[d] = pl_store(&skin->storage, at[d] / shape->scale);
}

/** Try to bring the node near to x: 0 if it may not be there. */
static int try_place(const pl_skin_visit *v, const double *x, pl_skin_trial *trial) {
    double place[3];
    find_place(v, x, trial);
    for (int d = 0; d < 3; d++)
        place[d] = trial->x[d] * v->skin->shape->scale;
    return keeps_normals(v, place) && keeps_near(v, place, trial);
}

/** How the node of a visit slides. */
static planish_constraint kind_of(const pl_skin *skin, int32_t node) {
    return skin->moves[node] == PLANISH_CONSTRAINT_ON_PLANE ||
                   skin->moves[node] == PLANISH_CONSTRAINT_ON_PATCH
               ? PLANISH_CONSTRAINT_ON_PLANE
               : PLANISH_CONSTRAINT_ON_LINE;
}

/** Find the direction of a node where it is. */
static void find_direction(const pl_skin *skin, int64_t star, int32_t node, double direction[3]) {
    double at[3];
    if (skin->moves[node] == PLANISH_CONSTRAINT_ON_PLANE ||
        skin->moves[node] == PLANISH_CONSTRAINT_ON_LINE)
        memcpy(direction, skin->slide[star].direction, 3 * sizeof *direction);
    else
        pl_shape_point(skin->shape, skin->shape->node_class[node], &skin->place[node], at,
                       direction);
}

/** Find the trial at x, which becomes the accepted one; 0: there is none. */
static int accept(pl_skin_visit *v, const double *x) {
    for (int i = 0; i < PL_SKIN_TRIALS; i++)
        if (v->trial[i].is_known && pl_skin_is_at(v->trial[i].x, x)) {
            const pl_skin_trial found = v->trial[i];
            v->trial[i] = v->trial[0];
            v->trial[0] = found;
            return 1;
        }
    return 0;
}

planish_constraint pl_skin_project(int64_t node, double *point, double *direction, void *user) {
    pl_skin_visit *v = user;
    double way[3], x[3];
    (void)node;
    const planish_constraint kind = kind_of(v->skin, v->node);
    if (accept(v, point)) {
        memcpy(direction, v->trial[0].direction, sizeof v->direction);
        return kind;
    }
    if (!v->has_direction)
        find_direction(v->skin, v->star, v->node, v->direction);
    v->has_direction = 1;
    memcpy(direction, v->direction, sizeof v->direction);
    if (pl_skin_is_at(point, v->start))
        return kind;
    pl_from_to(3, v->start, point, way);
    const double far = pl_length(way),
                 farthest = FARTHEST * v->skin->shape->edge_length[v->node] / v->skin->shape->scale;
    double part = far > farthest ? farthest / far : 1;
    v->newest = 1 + v->newest % (PL_SKIN_TRIALS - 1);
    pl_skin_trial *trial = &v->trial[v->newest];
    trial->is_known = 0;
    for (int i = 0; i < HALVINGS; i++, part *= 0.5) {
        for (int d = 0; d < 3; d++)
            x[d] = part < 1 ? v->start[d] + part * way[d] : point[d];
        if (try_place(v, x, trial)) {
            trial->is_known = 1;
            memcpy(point, trial->x, sizeof trial->x);
            memcpy(direction, trial->direction, sizeof trial->direction);
            return kind;
        }
        v->is_off = 1;
    }
    memcpy(point, v->start, sizeof v->start); /* it stays: the search ends */
    return kind;
}

int pl_skin_end_visit(pl_skin_visit *visit) {
    pl_skin *skin = visit->skin;
    const planish_shape *shape = skin->shape;
    const int32_t node = visit->node;
    double *x = skin->coordinates + (int64_t)skin->inner[node] * 3;
    if (visit->is_off)
        __atomic_fetch_add(&skin->n_off, 1, __ATOMIC_RELAXED);
    if (pl_skin_is_at(x, visit->start))
        return 1;
    if (!accept(visit, x)) {
        memcpy(x, visit->start, sizeof visit->start);
        return 0;
    }
    const pl_skin_trial *trial = &visit->trial[0];
    memcpy(skin->known[node], x, sizeof trial->x);
    skin->place[node] = trial->place;
    for (int64_t i = shape->offset[node]; i < shape->offset[node + 1]; i++)
        skin->bound[shape->facet_of[i]] = trial->bound[i - shape->offset[node]];
    return 1;
}

planish_constraint pl_skin_ask(int64_t node, double *point, double *direction, void *user) {
    const pl_skin *skin = user;
    const int32_t own = skin->shape->number[node];
    if (own >= 0 && pl_skin_has(skin, own)) {
        if (!pl_skin_is_at(point, skin->known[own]))
            return PLANISH_CONSTRAINT_FIXED;
        find_direction(skin, skin->star[own], own, direction);
        return kind_of(skin, own);
    }
    return skin->project && (own < 0 || skin->moves[own] == PL_SKIN_LOOSE)
               ? skin->project(node, point, direction, skin->project_user)
               : PLANISH_CONSTRAINT_FIXED;
}

/* ---- trials ---------------------------------------------------------------------------------- */

void *pl_skin_save(const pl_skin *skin) {
    if (!skin->shape)
        return NULL;
    const int64_t n = skin->shape->n_nodes, n_facets = skin->shape->n_facets;
    const size_t places = (size_t)n * sizeof *skin->place, known = (size_t)n * sizeof *skin->known,
                 bounds = (size_t)n_facets * sizeof *skin->bound;
    char *saved = pl_alloc((int64_t)(places + known + bounds), 1);
    if (!saved)
        return NULL;
    memcpy(saved, skin->place, places);
    memcpy(saved + places, skin->known, known);
    memcpy(saved + places + known, skin->bound, bounds);
    return saved;
}

void pl_skin_restore(pl_skin *skin, const void *saved) {
    if (!skin->shape || !saved)
        return;
    const int64_t n = skin->shape->n_nodes, n_facets = skin->shape->n_facets;
    const size_t places = (size_t)n * sizeof *skin->place, known = (size_t)n * sizeof *skin->known;
    memcpy(skin->place, saved, places);
    memcpy(skin->known, (const char *)saved + places, known);
    memcpy(skin->bound, (const char *)saved + places + known,
           (size_t)n_facets * sizeof *skin->bound);
}

/* ---- the beginning --------------------------------------------------------------------------- */

/** Mark the facets of planar patches: normals agree, and nodes are in one plane. */
static int find_planar(pl_skin *skin) {
    const planish_shape *shape = skin->shape;
    double *off =
        pl_alloc_zero(shape->n_facets, sizeof *off); /* of patches, at their numbers: how far
                                                                   nodes are off the plane of a facet */
    double *least = pl_alloc(shape->n_facets, sizeof *least);  /* tolerance */
    int32_t *first = pl_alloc(shape->n_facets, sizeof *first); /* their first facets */
    const int done = off && least && first;
    for (int64_t p = 0; done && p < shape->n_facets; p++) {
        first[p] = -1;
        least[p] = INFINITY;
    }
    for (int32_t t = 0; done && t < shape->n_facets; t++) {
        const int32_t p = shape->patch[t];
        if (first[p] < 0)
            first[p] = t;
        const double *normal = shape->normal[first[p]], *x = shape->x[shape->facet[first[p]][0]];
        double way[3];
        least[p] = fmin(least[p], skin->tolerance[t]);
        if (!(pl_dot(3, normal, shape->normal[t]) > 0))
            off[p] = INFINITY;
        for (int j = 0; j < 3; j++) {
            pl_from_to(3, x, shape->x[shape->facet[t][j]], way);
            off[p] = fmax(off[p], fabs(pl_dot(3, way, normal)));
        }
    }
    for (int64_t t = 0; done && t < shape->n_facets; t++) {
        const double most = off[shape->patch[t]];
        skin->is_planar[t] =
            most <= PLANAR_TOLERANCE * least[shape->patch[t]] && most <= PLANAR_SIZE * shape->size;
        skin->tolerance[t] *= skin->is_planar[t] ? PLANAR_REST : 1;
    }
    pl_free(off);
    pl_free(least);
    pl_free(first);
    return done;
}

/** Find the tolerances of all facets. */
static void find_tolerances(pl_skin *skin, const planish_options *options) {
    const planish_shape *shape = skin->shape;
    const int is_length =
        options->surface_tolerance > 0 && options->surface_tolerance_unit == PLANISH_UNIT_MESH;
    const double factor =
        options->surface_tolerance > 0 ? options->surface_tolerance : DEFAULT_TOLERANCE;
    for (int64_t t = 0; t < shape->n_facets; t++) {
        const int32_t *corner = shape->facet[t];
        double least = INFINITY, sum = 0;
        for (int j = 0; j < 3; j++) {
            double way[3];
            pl_from_to(3, shape->x[corner[j]], shape->x[corner[(j + 1) % 3]], way);
            sum += pl_length(way);
            least = fmin(least, shape->edge_length[corner[j]]);
        }
        skin->tolerance[t] = factor * (is_length ? shape->scale : fmin(least, sum / 3));
    }
}

/** Whether a facet at a node is such as test says. */
static int any_facet(const pl_skin *skin, int32_t node,
                     int (*test)(const pl_skin *skin, int32_t facet)) {
    const planish_shape *shape = skin->shape;
    for (int64_t i = shape->offset[node]; i < shape->offset[node + 1]; i++)
        if (test(skin, shape->facet_of[i]))
            return 1;
    return 0;
}

static int is_curved(const pl_skin *skin, int32_t facet) {
    return !skin->is_planar[facet];
}

int pl_skin_is_curved(const pl_skin *skin, int32_t node) {
    return any_facet(skin, node, is_curved);
}

static int has_corner(const pl_skin *skin, int32_t facet, int moves) {
    const int32_t *corner = skin->shape->facet[facet];
    return skin->moves[corner[0]] == moves || skin->moves[corner[1]] == moves ||
           skin->moves[corner[2]] == moves;
}

static int ends_at_curve(const pl_skin *skin, int32_t facet) {
    return has_corner(skin, facet, PLANISH_CONSTRAINT_ON_CURVE);
}

static int is_loose(const pl_skin *skin, int32_t facet) {
    return has_corner(skin, facet, PL_SKIN_LOOSE);
}

static int is_too_far(const pl_skin *skin, int32_t facet) {
    return !(skin->bound[facet] <= skin->tolerance[facet]);
}

void pl_skin_find_moves(pl_skin *skin, const uint8_t *slides_by) {
    for (int64_t s = 0; s < skin->n_stars; s++) {
        const int32_t node = skin->node[s];
        if (node >= 0 && slides_by[s] >= PLANISH_CONSTRAINT_ON_PATCH)
            skin->moves[node] =
                skin->moves[node] == PL_SKIN_PAIRED ? PLANISH_CONSTRAINT_FIXED : slides_by[s];
    }
    for (int64_t s = 0; s < skin->n_stars; s++) {
        const int32_t node = skin->node[s];
        const uint8_t by = slides_by[s];
        if (node < 0 || by >= PLANISH_CONSTRAINT_ON_SURFACE)
            continue;
        const int is_line = by == PLANISH_CONSTRAINT_ON_LINE;
        if (!pl_skin_is_curved(skin, node) && !(is_line && any_facet(skin, node, ends_at_curve)))
            skin->moves[node] = PL_SKIN_FLAT;
        else if (skin->moves[node] == PL_SKIN_PAIRED || skin->shape->node_class[node] == PL_CORNER)
            skin->moves[node] = PLANISH_CONSTRAINT_FIXED;
        else
            skin->moves[node] = by;
    }
}

/** Hold the nodes of the skin with a facet such as test says. Returns how many there are. */
static int64_t hold(pl_skin *skin, int (*test)(const pl_skin *skin, int32_t facet)) {
    int64_t n = 0;
    for (int32_t node = 0; node < skin->shape->n_nodes; node++)
        if (pl_skin_has(skin, node) && any_facet(skin, node, test)) {
            skin->moves[node] = PLANISH_CONSTRAINT_FIXED;
            n++;
        }
    return n;
}

/** Hold the nodes of facets that are too far off at the start: these stay as they are. */
static void hold_far(pl_skin *skin) {
    skin->n_held = hold(skin, is_too_far);
    for (int32_t t = 0; t < skin->shape->n_facets; t++)
        if (is_too_far(skin, t))
            skin->tolerance[t] = INFINITY;
    if (skin->n_held > 0)
        pl_log(PLANISH_LOG_NOTE,
               "%" PRId64 " nodes stay: the surface there is farther off options.shape than "
               "surface_tolerance",
               skin->n_held);
}

int pl_skin_is_off(const pl_skin *skin, int32_t node) {
    return any_facet(skin, node, is_too_far);
}

/** Take the places of all nodes, whose coordinates the caller has. */
static void take_places(pl_skin *skin, const pl_points *points) {
    const planish_shape *shape = skin->shape;
    for (int32_t node = 0; node < shape->n_nodes; node++) {
        skin->place[node] = first_place(shape, node);
        for (int d = 0; d < 3 && skin->inner[node] < 0; d++)
            skin->known[node][d] = points->x[pl_point_at(points, shape->node[node], d)];
        if (skin->inner[node] >= 0)
            follow(skin, node);
    }
}

static int allocate(pl_skin *skin) {
    const int64_t n = skin->shape->n_nodes, n_facets = skin->shape->n_facets;
    skin->max_facets = 0;
    for (int64_t i = 0; i < n; i++) {
        const int64_t at = skin->shape->offset[i + 1] - skin->shape->offset[i];
        skin->max_facets = at > skin->max_facets ? at : skin->max_facets;
    }
    skin->room_stride = (PL_SKIN_TRIALS + 4) * skin->max_facets;
    skin->node = pl_alloc(skin->n_stars, sizeof *skin->node);
    skin->star = pl_alloc(n, sizeof *skin->star);
    skin->inner = pl_alloc(n, sizeof *skin->inner);
    skin->moves = pl_alloc_zero(n, sizeof *skin->moves);
    skin->known = pl_alloc(n, sizeof *skin->known);
    skin->place = pl_alloc(n, sizeof *skin->place);
    skin->bound = pl_alloc_zero(n_facets, sizeof *skin->bound);
    skin->tolerance = pl_alloc(n_facets, sizeof *skin->tolerance);
    skin->is_planar = pl_alloc(n_facets, sizeof *skin->is_planar);
    skin->room = pl_alloc(skin->room_stride * skin->threads, sizeof *skin->room);
    return skin->node && skin->star && skin->inner && skin->moves && skin->known && skin->place &&
           skin->bound && skin->tolerance && skin->is_planar && skin->room;
}

int pl_skin_make(const planish_options *options, pl_skin *skin, planish_error *error) {
    const int has_room = allocate(skin);
    if (has_room)
        find_tolerances(skin, options);
    if (!has_room || !find_planar(skin))
        return pl_fail_memory(error, "the surface of a mesh");
    return PLANISH_OK;
}

void pl_skin_begin(pl_skin *skin, const pl_points *points) {
    hold(skin, is_loose);
    take_places(skin, points);
    bound_all(skin);
    hold_far(skin);
}

void pl_skin_destroy(pl_skin *skin) {
    pl_free(skin->node);
    pl_free(skin->star);
    pl_free(skin->inner);
    pl_free(skin->moves);
    pl_free(skin->known);
    pl_free(skin->place);
    pl_free(skin->bound);
    pl_free(skin->tolerance);
    pl_free(skin->is_planar);
    pl_free(skin->room);
    *skin = (pl_skin){0};
}
