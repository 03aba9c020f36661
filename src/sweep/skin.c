/* skin: visits of nodes on the shape: where they may go. */
#include "sweep/skin.h"

#include "geometry/fetch.h"

#include <math.h>
#include <string.h>

/* A visit goes no farther than so many edges: beyond that a plane says little of the surface. */
#define FARTHEST 0.7
/* PL_SKIN_BEND as the distance of the ends of the unit normals, less roundings. */
#define BEND_CHORD 0.684040
/* What is too far off is tried at half of the way, so often. */
enum { HALVINGS = 7 };
/* Facets of a node that are looked through one by one. */
enum { FEW = 16 };
/* A fan is a graph over a plane if the cosines between its normals and that of the plane are above this. */
#define GRAPH 0.5
/* Bounds are rounded up by this. */
#define ROUNDED_UP (1 + 0x1p-40)

/** Whether a node moves in a plane, as on patches, or else along a line. */
static int is_in_plane(const pl_skin *skin, int32_t node) {
    return skin->moves[node] == PLANISH_CONSTRAINT_ON_PLANE ||
           skin->moves[node] == PLANISH_CONSTRAINT_ON_PATCH;
}

/** Find the direction of the star's node where it is. */
static void find_direction(const pl_skin *skin, int64_t star, int32_t node, double direction[3]) {
    double kept[3];
    if (!pl_skin_is_on_shape(skin, node)) {
        memcpy(direction, skin->slide[star].direction, 3 * sizeof *direction);
        return;
    }
    for (int d = 0; d < 3; d++)
        kept[d] = (double)skin->direction[node][d];
    if (!pl_unit(3, kept, direction)) /* the shape has none there */
        direction[0] = direction[1] = direction[2] = 0;
}

/* ---- the facets around a node ----------------------------------------------------------------- */

int32_t pl_skin_number_of(const pl_skin_visit *v, int32_t facet) {
    const int64_t first = v->n > FEW ? pl_find_ascending(v->facet, v->n, facet) : 0;
    for (int64_t j = first; j < v->n && (v->n <= FEW || j == first); j++)
        if (v->facet[j] == facet)
            return (int32_t)j;
    return -1;
}

/** Learn where the facets around the node are. */
static void gather(pl_skin_visit *v) {
    const pl_skin *skin = v->skin;
    const planish_shape *shape = skin->shape;
    v->has_rim = 1;
    for (int i = 0; i < v->n; i++) {
        const int32_t facet = v->facet[i], *corner = shape->facet[facet];
        const int k = corner[0] == v->node ? 0 : corner[1] == v->node ? 1 : 2;
        const int32_t other = shape->across[facet][k];
        pl_skin_place_of(skin, corner[(k + 1) % 3], v->rim[i][0]);
        pl_skin_place_of(skin, corner[(k + 2) % 3], v->rim[i][1]);
        v->opposite[i] = shape->across[facet][(k + 1) % 3];
        v->next[i] = other < 0 ? -1 : pl_skin_number_of(v, other);
    }
}

/** Compute the unit normals of the facets if the node is at x; 0 if one has no area. */
static int find_normals(const pl_skin_visit *v, const double x[3], double (*normal)[3]) {
    int have = 1;
    for (int i = 0; i < v->n; i++) {
        double a[3], b[3], n[3];
        pl_from_to(3, x, v->rim[i][0], a);
        pl_from_to(3, x, v->rim[i][1], b);
        pl_cross(a, b, n);
        const double length = pl_length(n), inverse = 1 / length;
        have &= length > 0;
        for (int d = 0; d < 3; d++)
            normal[i][d] = n[d] * inverse;
    }
    return have;
}

/** Compute the unit normals of the facets where the node was when the visit began. */
static void find_normals_before(pl_skin_visit *v) {
    double x[3];
    if (v->has_normals)
        return;
    v->has_normals = 1;
    pl_skin_place_of(v->skin, v->node, x);
    find_normals(v, x, v->normal);
}

/** Compute the unit normal of a facet. */
static void normal_of(const pl_skin *skin, int32_t facet, double normal[3]) {
    double x[3][3], a[3], b[3];
    for (int j = 0; j < 3; j++)
        pl_skin_place_of(skin, skin->shape->facet[facet][j], x[j]);
    pl_from_to(3, x[0], x[1], a);
    pl_from_to(3, x[0], x[2], b);
    pl_cross(a, b, normal);
    const double inverse = 1 / pl_length(normal);
    for (int d = 0; d < 3; d++)
        normal[d] *= inverse;
}

/** Square of the distance between the ends of two unit normals. */
static double chord2_of(const double *a, const double *b) {
    double way[3];
    pl_from_to(3, a, b, way);
    return pl_dot(3, way, way);
}

/** Whether the smooth edge between the i-th facet of a trial and the next one around the node bends little,
 *  or no more than it did. */
static int keeps_spoke(pl_skin_visit *v, const pl_skin_trial *trial, int i) {
    const int next = v->next[i];
    if (next < 0)
        return 1;
    const double now = pl_dot(3, trial->normal[i], trial->normal[next]);
    if (now >= PL_SKIN_BEND)
        return 1;
    find_normals_before(v);
    return now >= pl_dot(3, v->normal[i], v->normal[next]);
}

/** Whether the smooth edge opposite to the node bends little, too. The facet beyond is no farther from how it was first
 *  than is known. */
static int keeps_opposite(pl_skin_visit *v, const pl_skin_trial *trial, int i) {
    const pl_skin *skin = v->skin;
    const int32_t other = v->opposite[i];
    double there[3];
    if (other < 0)
        return 1;
    const double rest = BEND_CHORD - skin->turned[other] * PL_SKIN_TURN;
    pl_kept_normal(skin->shape, other, there);
    if (rest > 0 && chord2_of(trial->normal[i], there) <= rest * rest)
        return 1;
    normal_of(skin, other, there);
    const double now = pl_dot(3, trial->normal[i], there);
    if (now >= PL_SKIN_BEND)
        return 1;
    find_normals_before(v);
    return now >= pl_dot(3, v->normal[i], there);
}

/** Whether the facets at the node keep their normals, about, if it is at place. */
static int keeps_normals(pl_skin_visit *v, const double *place, pl_skin_trial *trial) {
    if (!v->has_rim)
        gather(v);
    if (!find_normals(v, place, trial->normal))
        return 0;
    for (int i = 0; i < v->n; i++)
        if (!pl_skin_keeps_turn(v, trial, i) || !keeps_spoke(v, trial, i) ||
            !keeps_opposite(v, trial, i))
            return 0;
    return 1;
}

/* ---- distances ------------------------------------------------------------------------------- */

/** Bound how far the facets of a closed fan are off the shape after their node has gone way, by how far
 *  they were; infinite: this does not tell.
 *
 *  Over the plane through the node with this normal let the fan have slopes up to s. Move the node within
 *  the plane: a point of a facet goes along, by no more than the node, and at the same height; the old fan
 *  is no more than s times that higher or lower there. Then move the node along the normal. */
static double bound_of_fan(pl_skin_visit *v, const double way[3], const pl_skin_trial *trial) {
    const pl_skin *skin = v->skin;
    double least = 1, farthest = 0;
    if (skin->shape->node_class[v->node] != PL_ON_PATCH || !is_in_plane(skin, v->node))
        return INFINITY;
    find_normals_before(v);
    const double *normal = pl_skin_is_on_shape(skin, v->node) ? v->direction : v->normal[0];
    for (int i = 0; i < v->n; i++) {
        const double before = pl_dot(3, v->normal[i], normal);
        const double after = pl_dot(3, trial->normal[i], normal);
        least = before < least ? before : least;
        least = after < GRAPH ? -1 : least;
        const double bound = skin->bound[v->facet[i]];
        farthest = bound > farthest ? bound : farthest;
    }
    if (!(least >= GRAPH))
        return INFINITY;
    const double slope = sqrt(1 - least * least) / least, move = pl_length(way);
    return farthest + (fabs(pl_dot(3, way, normal)) + (slope + 0x1p-40) * move) * ROUNDED_UP;
}

/** The node whose disc tells of the facets at the node of a trial: that of the shape nearest to its place;
 *  -1: there is none. */
static int32_t disc_near(const pl_skin_visit *v, const pl_skin_trial *trial) {
    const planish_shape *shape = v->skin->shape;
    const pl_place *place = &trial->place;
    if (shape->node_class[v->node] != PL_ON_PATCH || place->at < 0)
        return -1;
    int most = 0;
    for (int k = 1; k < 3; k++)
        most = place->weight[k] > place->weight[most] ? k : most;
    const int32_t node = shape->facet[place->at][most];
    return v->skin->disc[node].radius2 > 0 ? node : -1;
}

/** Bound facet i of a trial by the disc of centre, whose frame is set (is_set) at the first of the facets;
 *  infinite: it does not tell. */
static double bound_by_disc(const pl_skin_visit *v, int32_t centre, const double *place, int i,
                            pl_disc_frame *frame, pl_disc_point *own, int *is_set) {
    const planish_shape *shape = v->skin->shape;
    const int32_t *corner = shape->facet[v->facet[i]];
    pl_disc_point other[2];
    for (int k = 0; k < 3; k++)
        if (shape->node_class[corner[k]] != PL_ON_PATCH)
            return INFINITY;
    if (!*is_set)
        pl_disc_set_frame(shape, centre, &v->skin->disc[centre], frame);
    if (!*is_set && !pl_disc_see(frame, place, own))
        return INFINITY;
    *is_set = 1;
    return pl_disc_see(frame, v->rim[i][0], &other[0]) &&
                   pl_disc_see(frame, v->rim[i][1], &other[1])
               ? pl_disc_bound(frame, own, &other[0], &other[1])
               : INFINITY;
}

/** Whether a corner of a facet slides on a curve: of a planar patch, too, it may stick out there, by as much
 *  as its other corners say. */
static int is_at_curve(const pl_skin *skin, int32_t facet) {
    const int32_t *corner = skin->shape->facet[facet];
    return skin->moves[corner[0]] == PLANISH_CONSTRAINT_ON_CURVE ||
           skin->moves[corner[1]] == PLANISH_CONSTRAINT_ON_CURVE ||
           skin->moves[corner[2]] == PLANISH_CONSTRAINT_ON_CURVE;
}

/** Whether the facets at the node stay within their tolerance if it is at place, in trial->place: their
 *  bounds are in trial. */
static int keeps_near(pl_skin_visit *v, const double *place, pl_skin_trial *trial) {
    const pl_skin *skin = v->skin;
    const int32_t centre = disc_near(v, trial);
    pl_disc_frame frame;
    pl_disc_point own;
    double start[3], way[3], of_fan = NAN;
    int is_set = 0;
    pl_skin_place_of(skin, v->node, start);
    pl_from_to(3, start, place, way);
    const double move = pl_length(way) * ROUNDED_UP;
    const int is_exact = skin->moves[v->node] == PLANISH_CONSTRAINT_ON_PLANE;
    for (int i = 0; i < v->n; i++) {
        const int32_t facet = v->facet[i];
        const double tolerance = skin->tolerance[facet];
        double bound = skin->bound[facet];
        if (!is_exact || !skin->is_planar[facet] || is_at_curve(skin, facet))
            bound += move;
        if (!(bound <= tolerance) && centre >= 0)
            bound = bound_by_disc(v, centre, place, i, &frame, &own, &is_set);
        if (!(bound <= tolerance)) {
            if (isnan(of_fan))
                of_fan = bound_of_fan(v, way, trial);
            bound = of_fan;
        }
        if (!(bound <= tolerance))
            bound = pl_skin_certify(skin, facet, v->node, place, &trial->place);
        if (!(bound <= tolerance))
            return 0;
        trial->bound[i] = bound;
    }
    return 1;
}

/* ---- places ---------------------------------------------------------------------------------- */

/** Find the place of the node nearest to x on its plane or line, and where that is stored: trial. */
static void find_flat_place(const pl_skin_visit *v, const double *x, pl_skin_trial *trial) {
    const pl_skin *skin = v->skin;
    const pl_star_slide *slide = &skin->slide[v->star];
    const int is_plane = is_in_plane(skin, v->node);
    double way[3], at[3];
    pl_from_to(3, slide->point, x, way);
    const double along = pl_dot(3, way, slide->direction);
    for (int d = 0; d < 3; d++) {
        const double part = along * slide->direction[d];
        way[d] = is_plane ? way[d] - part : part;
        trial->x[d] = pl_store(&skin->storage, slide->point[d] + way[d]);
        at[d] = trial->x[d] * skin->shape->scale;
    }
    if (trial->place.at >= 0)
        pl_shape_walk(skin->shape, skin->shape->node_class[v->node], at, &trial->place);
    memcpy(trial->direction, slide->direction, sizeof trial->direction);
}

/** Find the place of the node on the shape nearest to x, in the mesh's units. */
static void find_place(const pl_skin_visit *v, const double *x, pl_skin_trial *trial) {
    const pl_skin *skin = v->skin;
    const planish_shape *shape = skin->shape;
    const int node_class = shape->node_class[v->node];
    double at[3];
    trial->place = pl_skin_get_place(skin, v->node);
    if (!pl_skin_is_on_shape(skin, v->node)) {
        find_flat_place(v, x, trial);
        return;
    }
    for (int d = 0; d < 3; d++)
        at[d] = x[d] * shape->scale;
    pl_shape_walk(shape, node_class, at, &trial->place);
    pl_shape_point(shape, node_class, &trial->place, at, trial->direction);
    for (int d = 0; d < 3; d++)
        trial->x[d] = pl_store(&skin->storage, at[d] * skin->unscale);
}

/** Try to bring the node near to x: 0 if it may not be there. */
static int try_place(pl_skin_visit *v, const double *x, pl_skin_trial *trial) {
    double place[3];
    find_place(v, x, trial);
    if (v->skin->shape->whole)
        return pl_skin_mids_try(v, trial);
    for (int d = 0; d < 3; d++)
        place[d] = trial->x[d] * v->skin->shape->scale;
    return keeps_normals(v, place, trial) && keeps_near(v, place, trial);
}

/* ---- visits ---------------------------------------------------------------------------------- */

void pl_skin_prepare(pl_skin *skin, int thread, pl_skin_visit *visit) {
    visit->wholes = NULL;
    const int64_t n = skin->max_facets;
    double *room = skin->room + PL_SKIN_ROOM * n * thread;
    visit->skin = skin;
    for (int i = 0; i < PL_SKIN_TRIALS; i++) {
        visit->trial[i].bound = room;
        visit->trial[i].normal = (double(*)[3])(void *)(room + n);
        room += 4 * n;
    }
    visit->normal = (double(*)[3])(void *)room;
    visit->rim = (double(*)[2][3])(void *)(room + 3 * n);
    visit->opposite = (int32_t *)(void *)(room + 9 * n);
    visit->next = visit->opposite + n;
    pl_skin_mids_prepare(skin, thread, visit);
}

void pl_skin_begin_visit(pl_skin_visit *visit, int64_t star) {
    const pl_skin *skin = visit->skin;
    const int32_t node = skin->node[star];
    int64_t n = 0;
    visit->star = star;
    visit->node = node;
    visit->facet = pl_shape_star(skin->shape, node, &n);
    visit->n = (int)n;
    memcpy(visit->start, pl_skin_at(skin, node), sizeof visit->start);
    visit->has_direction = visit->has_rim = visit->has_normals = visit->is_off = 0;
    visit->newest = 0;
    for (int i = 0; i < PL_SKIN_TRIALS; i++)
        visit->trial[i].is_known = 0;
    if (skin->shape->whole)
        pl_skin_mids_begin(visit);
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

/** Try to bring the node to point, which becomes where it may be; 0: nowhere on the way. */
static int go_to(pl_skin_visit *v, double *point, double *direction) {
    const pl_skin *skin = v->skin;
    double way[3], x[3];
    for (int d = 0; d < 3; d++)
        way[d] = (point[d] - v->start[d]) * skin->shape->scale;
    const double far = pl_length(way), farthest = FARTHEST * skin->shape->edge_length[v->node];
    double part = far > farthest ? farthest / far : 1;
    v->newest = 1 + v->newest % (PL_SKIN_TRIALS - 1);
    pl_skin_trial *trial = &v->trial[v->newest];
    trial->is_known = 0;
    for (int i = 0; i < HALVINGS && !trial->is_known; i++, part *= 0.5) {
        for (int d = 0; d < 3; d++)
            x[d] = part < 1 ? v->start[d] + part * way[d] * skin->unscale : point[d];
        trial->is_known = try_place(v, x, trial);
        v->is_off |= !trial->is_known;
    }
    if (!trial->is_known)
        return 0;
    memcpy(point, trial->x, sizeof trial->x);
    memcpy(direction, trial->direction, sizeof trial->direction);
    return 1;
}

planish_constraint pl_skin_project(int64_t node, double *point, double *direction, void *user) {
    pl_skin_visit *v = user;
    (void)node;
    const planish_constraint kind =
        is_in_plane(v->skin, v->node) ? PLANISH_CONSTRAINT_ON_PLANE : PLANISH_CONSTRAINT_ON_LINE;
    if (!v->has_direction)
        find_direction(v->skin, v->star, v->node, v->direction);
    v->has_direction = 1;
    if (pl_skin_is_at(point, v->start)) {
        memcpy(direction, v->direction, sizeof v->direction);
    } else if (accept(v, point)) {
        memcpy(direction, v->trial[0].direction, sizeof v->direction);
    } else if (!go_to(v, point, direction)) { /* it stays: the search ends */
        memcpy(point, v->start, sizeof v->start);
        memcpy(direction, v->direction, sizeof v->direction);
    }
    return kind;
}

int pl_skin_end_visit(pl_skin_visit *visit) {
    pl_skin *skin = visit->skin;
    double *x = skin->coordinates + (int64_t)skin->inner[visit->node] * 3;
    if (visit->is_off)
        __atomic_fetch_add(&skin->n_off, 1, __ATOMIC_RELAXED);
    if (pl_skin_is_at(x, visit->start))
        return 1;
    if (!accept(visit, x)) {
        memcpy(x, visit->start, sizeof visit->start);
        pl_skin_move_mids(visit);
        return 0;
    }
    if (skin->shape->whole)
        pl_skin_mids_take(visit);
    const pl_skin_trial *trial = &visit->trial[0];
    skin->known[visit->node] = pl_skin_print(x);
    pl_skin_set_place(skin, visit->node, &trial->place);
    pl_skin_set_direction(skin, visit->node, trial->direction);
    for (int i = 0; i < visit->n; i++) {
        const int32_t facet = visit->facet[i];
        double first[3];
        skin->bound[facet] = pl_float_above(trial->bound[i]);
        pl_kept_normal(skin->shape, facet, first);
        skin->turned[facet] = pl_skin_turn(sqrt(chord2_of(trial->normal[i], first)));
    }
    return 1;
}

planish_constraint pl_skin_ask(int64_t node, double *point, double *direction, void *user) {
    const pl_skin *skin = user;
    const int32_t own = skin->shape->number[node];
    if (own >= 0 && pl_skin_has(skin, own)) {
        if (!pl_skin_is_known(skin, own, point))
            return PLANISH_CONSTRAINT_FIXED;
        find_direction(skin, skin->star[own], own, direction);
        return is_in_plane(skin, own) ? PLANISH_CONSTRAINT_ON_PLANE : PLANISH_CONSTRAINT_ON_LINE;
    }
    return skin->project && (own < 0 || skin->moves[own] == PL_SKIN_LOOSE)
               ? skin->project(node, point, direction, skin->project_user)
               : PLANISH_CONSTRAINT_FIXED;
}

/* ---- memory ahead ----------------------------------------------------------------------------- */

void pl_skin_fetch_node(const pl_skin *skin, int64_t star) {
    const int32_t node = skin->node[star];
    if (node < 0)
        return;
    __builtin_prefetch(&skin->shape->offset[node]);
    __builtin_prefetch(&skin->place[node], 1);
    __builtin_prefetch(&skin->known[node], 1);
    __builtin_prefetch(&skin->disc[node]);
}

void pl_skin_fetch_list(const pl_skin *skin, int64_t star) {
    const int32_t node = skin->node[star];
    if (node < 0)
        return;
    const int32_t at = skin->place[node].at;
    __builtin_prefetch(skin->shape->facet_of + skin->shape->offset[node]);
    __builtin_prefetch(&skin->shape->edge_length[node]);
    if (at >= 0 && skin->shape->node_class[node] == PL_ON_PATCH)
        __builtin_prefetch(&skin->shape->facet[at]);
}

void pl_skin_fetch_facets(const pl_skin *skin, int64_t star) {
    const planish_shape *shape = skin->shape;
    const int32_t node = skin->node[star];
    if (node < 0)
        return;
    for (int64_t i = shape->offset[node]; i < shape->offset[node + 1]; i++) {
        const int32_t facet = shape->facet_of[i];
        __builtin_prefetch(&shape->facet[facet]);
        __builtin_prefetch(&shape->across[facet]);
        __builtin_prefetch(&shape->normal[facet]);
        __builtin_prefetch(&skin->bound[facet], 1);
        __builtin_prefetch(&skin->tolerance[facet]);
        __builtin_prefetch(&skin->turned[facet], 1);
        __builtin_prefetch(&skin->is_planar[facet]);
    }
}

void pl_skin_fetch_corners(const pl_skin *skin, int64_t star) {
    const planish_shape *shape = skin->shape;
    const int32_t node = skin->node[star];
    if (node < 0)
        return;
    for (int64_t i = shape->offset[node]; i < shape->offset[node + 1]; i++) {
        const int32_t facet = shape->facet_of[i], k = pl_corner_at(shape, facet, node);
        const int32_t corner = shape->facet[facet][(k + 1) % 3];
        const int32_t other = shape->across[facet][(k + 1) % 3];
        __builtin_prefetch(&skin->inner[corner]);
        __builtin_prefetch(&shape->x[corner]);
        __builtin_prefetch(&shape->node_class[corner]);
        __builtin_prefetch(&shape->normal_at[corner]);
        if (other < 0)
            continue;
        __builtin_prefetch(&shape->normal[other]);
        __builtin_prefetch(&skin->turned[other]);
    }
}
