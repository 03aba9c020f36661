/* skin_places: the skin of a run: which nodes it moves, their places, and bounds of their facets. */
#include "sweep/skin.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "shape/gaps.h"
#include "shape/overlay.h"
#include "shape/pn.h"
#include "topology/points.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <string.h>

enum { CHUNK_FACETS = 256 };

/* A patch is planar if its nodes are within so much of its tolerance, and of the size of the shape. */
#define PLANAR_TOLERANCE 1e-3
#define PLANAR_SIZE      1e-8
/* Such patches are off by twice as much: their tolerance is lower. */
#define PLANAR_REST (1 - 2 * PLANAR_TOLERANCE)

/* ---- where nodes are ------------------------------------------------------------------------- */

pl_place pl_skin_present_place(const pl_skin *skin, int32_t node) {
    pl_place place = pl_skin_get_place(skin, node);
    double x[3];
    if ((skin->moves[node] != PL_SKIN_FLAT && skin->inner[node] != PL_SKIN_MID) || place.at < 0)
        return place;
    pl_skin_place_of(skin, node, x);
    pl_shape_walk(skin->shape, skin->shape->node_class[node], x, &place);
    return place;
}

/* ---- facets ---------------------------------------------------------------------------------- */

/** Bound how far a facet is off the shape; above limit: not known. */
static double bound_of(const pl_skin *skin, const pl_moved_facet *moved, double limit) {
    const double lateral = pl_overlay_lateral(skin->shape, moved);
    if (!(lateral <= limit))
        return INFINITY;
    /* A facet within its patch may be off its curve: moves that follow must not take that farther. */
    return fmax(lateral, pl_overlay_bound(skin->shape, moved, lateral, limit));
}

double pl_skin_certify(const pl_skin *skin, int32_t facet, int32_t node, const double *x,
                       const pl_place *place) {
    const double limit = skin->tolerance[facet];
    pl_moved_facet moved = {.facet = facet};
    int is_old = 0;
    for (int j = 0; j < 3; j++) {
        const int32_t corner = skin->shape->facet[facet][j];
        /* On a patch a place only says where to begin: the old one does most often. */
        const int may_be_old = skin->shape->node_class[corner] == PL_ON_PATCH;
        if (x && place && corner == node) {
            memcpy(moved.x[j], x, sizeof moved.x[j]);
            moved.place[j] = *place;
        } else {
            pl_skin_place_of(skin, corner, moved.x[j]);
            moved.place[j] =
                may_be_old ? pl_skin_get_place(skin, corner) : pl_skin_present_place(skin, corner);
        }
        is_old |= may_be_old && skin->moves[corner] == PL_SKIN_FLAT;
    }
    const double bound = bound_of(skin, &moved, limit);
    if (!is_old || bound <= limit)
        return bound;
    for (int j = 0; j < 3; j++)
        if (skin->shape->facet[facet][j] != node)
            moved.place[j] = pl_skin_present_place(skin, skin->shape->facet[facet][j]);
    return bound_of(skin, &moved, limit);
}

/** Return how far the unit normal of a facet is from what it was first; infinite where the skin does not
 *  know. */
static double turn_of(const pl_skin *skin, int32_t facet) {
    double x[3][3], a[3], b[3], normal[3];
    for (int j = 0; j < 3; j++) {
        const int32_t corner = skin->shape->facet[facet][j];
        if (skin->moves[corner] == PL_SKIN_LOOSE)
            return INFINITY;
        pl_skin_place_of(skin, corner, x[j]);
    }
    pl_from_to(3, x[0], x[1], a);
    pl_from_to(3, x[0], x[2], b);
    pl_cross(a, b, normal);
    if (!pl_unit(3, normal, a))
        return INFINITY;
    pl_kept_normal(skin->shape, facet, normal);
    pl_from_to(3, a, normal, b);
    return pl_length(b);
}

/** Whether all corners of a facet, of second order also its mids, are where they were first. */
static int is_first(const pl_skin *skin, int32_t facet) {
    const planish_shape *shape = skin->shape;
    int n;
    const int32_t *node = pl_shape_corners(shape, facet, &n);
    for (int j = 0; j < (shape->whole ? pl_whole_of(shape, facet)->n_nodes : n); j++) {
        const int32_t corner = node[j];
        double x[3];
        pl_skin_place_of(skin, corner, x);
        if (!pl_skin_is_at(x, skin->shape->x[corner]))
            return 0;
    }
    return 1;
}

/** Bound how far a facet is off the shape by the fans of its corners; infinite: they do not tell, or an overlay
 *  tells much more. */
static double bound_by_fans(const pl_skin *skin, int32_t facet) {
    pl_moved_facet moved = {.facet = facet};
    for (int j = 0; j < 3; j++)
        pl_skin_place_of(skin, skin->shape->facet[facet][j], moved.x[j]);
    const double bound = pl_fan_bound(skin->shape, skin->fan, &moved);
    return bound <= PLANAR_TOLERANCE * skin->tolerance[facet] ? bound : INFINITY;
}

/** Bound how far a facet that has moved is off the shape, as it is. */
static double bound_moved(const pl_skin *skin, int32_t facet) {
    if (skin->shape->whole)
        return pl_skin_certify_whole(skin, facet);
    const double bound = skin->fan ? bound_by_fans(skin, facet) : INFINITY;
    return bound < INFINITY ? bound : pl_skin_certify(skin, facet, -1, NULL, NULL);
}

static void bound_facets(void *context, int64_t begin, int64_t end, int thread) {
    pl_skin *skin = context;
    (void)thread;
    for (int32_t t = (int32_t)begin; t < end; t++) {
        if (!isnan(skin->bound[t]))
            continue;
        skin->bound[t] = is_first(skin, t) ? 0 : pl_float_above(bound_moved(skin, t));
        skin->turned[t] = pl_skin_turn(turn_of(skin, t));
    }
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

/** Take note of the direction of the shape at the place of a node that moves on it. */
static void find_direction(const pl_skin *skin, int32_t node, const pl_place *place) {
    double at[3], direction[3];
    if (!pl_skin_has(skin, node) || !pl_skin_is_on_shape(skin, node) || place->at < 0)
        return;
    pl_shape_point(skin->shape, skin->shape->node_class[node], place, at, direction);
    pl_skin_set_direction(skin, node, direction);
}

/** Take note of where a node is. */
static void follow(pl_skin *skin, int32_t node) {
    const planish_shape *shape = skin->shape;
    double x[3];
    skin->known[node] = pl_skin_print(pl_skin_at(skin, node));
    pl_skin_place_of(skin, node, x);
    pl_place place = pl_skin_get_place(skin, node);
    if (pl_skin_is_at(x, shape->x[node]))
        place = pl_shape_first_place(shape, node);
    else if (place.at >= 0)
        pl_shape_walk(shape, shape->node_class[node], x, &place);
    pl_skin_set_place(skin, node, &place);
    find_direction(skin, node, &place);
    if (shape->whole)
        pl_skin_place_mids(skin, node);
    int64_t n = 0;
    const int32_t *facet = pl_shape_star(shape, node, &n);
    for (int64_t i = 0; i < n; i++)
        skin->bound[facet[i]] = NAN;
}

int64_t pl_skin_follow(pl_skin *skin) {
    if (!skin->shape)
        return 0;
    for (int32_t node = 0; node < skin->shape->n_nodes; node++)
        if (pl_skin_has(skin, node) && !pl_skin_is_known(skin, node, pl_skin_at(skin, node)))
            follow(skin, node);
    return bound_all(skin);
}

/** Whether a node of a facet, of second order a corner, moves so. */
static int has_corner(const pl_skin *skin, int32_t facet, int moves) {
    int n, any = 0;
    const int32_t *corner = pl_shape_corners(skin->shape, facet, &n);
    for (int k = 0; k < n; k++)
        any |= skin->moves[corner[k]] == moves;
    return any;
}

/** Mark the facets of which the skin knows the bound by where their nodes slide alone: on planes and lines,
 *  but beside a patch that is curved elsewhere. */
static void mark_flat(pl_skin *skin) {
    for (int32_t t = 0; t < skin->shape->n_facets; t++)
        if (!skin->is_planar[t] && !isinf(skin->tolerance[t]) && has_corner(skin, t, PL_SKIN_FLAT))
            skin->bound[t] = NAN;
}

static void fans_of_nodes(void *context, int64_t begin, int64_t end, int thread) {
    const pl_skin *skin = context;
    (void)thread;
    for (int32_t node = (int32_t)begin; node < end; node++)
        pl_fan_find(skin->shape, node, &skin->fan[node]);
}

/** Find the fans of all nodes, if there is memory. */
static void find_fans(pl_skin *skin) {
    const int64_t n = skin->shape->n_nodes;
    skin->fan = skin->shape->whole ? NULL : pl_alloc(n, sizeof *skin->fan);
    if (skin->fan)
        pl_parallel_for(pl_paying_threads(skin->threads, n), n, CHUNK_FACETS, fans_of_nodes, skin);
}

int64_t pl_skin_check(pl_skin *skin) {
    if (!skin->shape)
        return 0;
    mark_flat(skin);
    find_fans(skin);
    const int64_t n_off = pl_skin_follow(skin);
    pl_free(skin->fan);
    skin->fan = NULL;
    return n_off;
}

/* ---- trials ---------------------------------------------------------------------------------- */

/** Copy an array to or from what is saved; returns where the next one is there. */
static char *copy(char *saved, void *array, int64_t n, size_t size, int is_back) {
    const size_t bytes = (size_t)n * size;
    memcpy(is_back ? array : saved, is_back ? saved : array, bytes);
    return saved + bytes;
}

/** Copy what the mids of the shape have moved by themselves to own or (is_back) from there. */
static void copy_own(const pl_skin *skin, double (*own)[3], int is_back) {
    for (int64_t i = 0; i < skin->shape->n_nodes; i++)
        copy((char *)own[i], skin->mids->own + (int64_t)skin->shape->node[i] * 3, 3, sizeof **own,
             is_back);
}

/** Whether mids move by themselves. */
static int has_own(const pl_skin *skin) {
    return skin->shape->whole && skin->mids->own;
}

/** Copy places and bounds to saved or (is_back) from there. */
static void copy_all(const pl_skin *skin, char *saved, int is_back) {
    const int64_t n = skin->shape->n_nodes, n_facets = skin->shape->n_facets;
    if (has_own(skin)) {
        copy_own(skin, (double(*)[3])(void *)saved, is_back);
        saved += (size_t)n * 3 * sizeof(double);
    }
    saved = copy(saved, skin->place, n, sizeof *skin->place, is_back);
    saved = copy(saved, skin->direction, n, sizeof *skin->direction, is_back);
    saved = copy(saved, skin->known, n, sizeof *skin->known, is_back);
    saved = copy(saved, skin->bound, n_facets, sizeof *skin->bound, is_back);
    copy(saved, skin->turned, n_facets, sizeof *skin->turned, is_back);
}

void *pl_skin_save(const pl_skin *skin) {
    if (!skin->shape)
        return NULL;
    const size_t of_node = sizeof *skin->place + sizeof *skin->direction + sizeof *skin->known +
                           (has_own(skin) ? 3 * sizeof(double) : 0),
                 of_facet = sizeof *skin->bound + sizeof *skin->turned;
    char *saved = pl_alloc((int64_t)((size_t)skin->shape->n_nodes * of_node +
                                     (size_t)skin->shape->n_facets * of_facet),
                           1);
    if (saved)
        copy_all(skin, saved, 0);
    return saved;
}

const double *pl_skin_saved_own(const pl_skin *skin, const void *saved, int32_t node) {
    if (!saved || !skin->shape || !has_own(skin) || skin->shape->number[node] < 0)
        return NULL;
    return (const double *)saved + (int64_t)skin->shape->number[node] * 3;
}

void pl_skin_restore(pl_skin *skin, void *saved) {
    if (skin->shape && saved)
        copy_all(skin, saved, 1);
}

/* ---- the beginning --------------------------------------------------------------------------- */

/** A finite float that is not above x, which is not negative. */
static float float_below(double x) {
    const double below = x * (1 - 0x1p-23) - 0x1p-149;
    return below > 0 ? (float)fmin(below, FLT_MAX) : 0;
}

/** Planes of patches being found, at their numbers. */
typedef struct pl_patches {
    int32_t *first; /* [n_facets] facet; -1: there is none */
    double *off;    /* [n_facets] how far nodes are off its plane */
    float *least;   /* [n_facets] tolerance */
} pl_patches;

/** Find how far the corners of facets are off the plane of the first facet of their patch; infinite if one
 *  turns away from it. */
static void find_off(const pl_skin *skin, const pl_patches *of) {
    const planish_shape *shape = skin->shape;
    double normal[3] = {0, 0, 0};
    for (int32_t t = 0, last = -1; t < shape->n_facets; t++) {
        const int32_t p = shape->patch[t];
        if (of->first[p] < 0)
            of->first[p] = t;
        if (p != last)
            pl_facet_normal(shape, of->first[p], normal);
        last = p;
        const double *x = shape->x[shape->facet[of->first[p]][0]];
        double other[3], way[3], most = of->off[p];
        pl_kept_normal(shape, t, other);
        for (int j = 0; j < 3; j++) {
            pl_from_to(3, x, shape->x[shape->facet[t][j]], way);
            const double off = fabs(pl_dot(3, way, normal));
            most = off > most ? off : most;
        }
        of->off[p] = pl_dot(3, normal, other) > 0 ? most : INFINITY;
        of->least[p] = skin->tolerance[t] < of->least[p] ? skin->tolerance[t] : of->least[p];
    }
}

/** Mark the facets of planar patches: normals agree, and nodes are in one plane. Returns 0 without memory. */
static int find_planar(pl_skin *skin) {
    const planish_shape *shape = skin->shape;
    const int64_t n = shape->n_facets;
    pl_patches of = {pl_alloc(n, sizeof *of.first), pl_alloc_zero(n, sizeof *of.off),
                     pl_alloc(n, sizeof *of.least)};
    const int done = of.first && of.off && of.least;
    for (int64_t p = 0; done && p < n; p++) {
        of.first[p] = -1;
        of.least[p] = INFINITY;
    }
    if (done)
        find_off(skin, &of);
    for (int64_t t = 0; done && t < n; t++) {
        const double off = of.off[shape->patch[t]];
        skin->is_planar[t] =
            off <= PLANAR_TOLERANCE * of.least[shape->patch[t]] && off <= PLANAR_SIZE * shape->size;
        if (skin->is_planar[t])
            skin->tolerance[t] = float_below(skin->tolerance[t] * PLANAR_REST);
    }
    pl_free(of.first);
    pl_free(of.off);
    pl_free(of.least);
    return done;
}

/** Find the tolerances of all facets. */
static void find_tolerances(pl_skin *skin, const planish_options *options) {
    const planish_shape *shape = skin->shape;
    const int is_length =
        options->surface_tolerance > 0 && options->surface_tolerance_unit == PLANISH_UNIT_MESH;
    const double factor =
        options->surface_tolerance > 0 ? options->surface_tolerance : PLANISH_SURFACE_TOLERANCE;
    for (int32_t t = 0; t < shape->n_facets; t++)
        skin->tolerance[t] =
            float_below(factor * (is_length ? shape->scale : pl_shape_edge(shape, t)));
}

/** Whether a facet at a node is such as test says. */
static int any_facet(const pl_skin *skin, int32_t node,
                     int (*test)(const pl_skin *skin, int32_t facet)) {
    int64_t n = 0;
    const int32_t *facet = pl_shape_star(skin->shape, node, &n);
    for (int64_t i = 0; i < n; i++)
        if (test(skin, facet[i]))
            return 1;
    return 0;
}

static int is_curved(const pl_skin *skin, int32_t facet) {
    return has_corner(skin, facet, PLANISH_CONSTRAINT_ON_PATCH) ||
           has_corner(skin, facet, PLANISH_CONSTRAINT_ON_CURVE);
}

/** Whether the patch of a facet is not planar. */
static int is_bent(const pl_skin *skin, int32_t facet) {
    return !skin->is_planar[facet];
}

int pl_skin_is_curved(const pl_skin *skin, int32_t node) {
    return any_facet(skin, node, is_curved);
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
            skin->moves[node] = skin->moves[node] == PL_SKIN_PAIRED ? PL_SKIN_STAYS : slides_by[s];
    }
    for (int64_t s = 0; s < skin->n_stars; s++) {
        const int32_t node = skin->node[s];
        const uint8_t by = slides_by[s];
        if (node < 0 || by >= PLANISH_CONSTRAINT_ON_SURFACE)
            continue;
        /* Beside a curved part of the same patch a plan's facets are looked at in the end. */
        const int is_known = skin->plan || !any_facet(skin, node, is_bent);
        if (!pl_skin_is_curved(skin, node) && is_known)
            skin->moves[node] = PL_SKIN_FLAT;
        else if (skin->moves[node] == PL_SKIN_PAIRED || skin->shape->node_class[node] == PL_CORNER)
            skin->moves[node] = PL_SKIN_STAYS;
        else
            skin->moves[node] = by;
    }
}

/** Hold the nodes of the skin with a facet such as test says, as PL_SKIN_OFF, ... Returns how many there are. */
static int64_t hold(pl_skin *skin, int (*test)(const pl_skin *skin, int32_t facet), uint8_t as) {
    int64_t n = 0;
    for (int32_t node = 0; node < skin->shape->n_nodes; node++)
        if (pl_skin_has(skin, node) && any_facet(skin, node, test)) {
            skin->moves[node] = as;
            n++;
        }
    return n;
}

/** Hold the nodes of facets that are too far off at the start: these stay as they are. */
static void hold_far(pl_skin *skin) {
    const int64_t n = hold(skin, is_too_far, PL_SKIN_OFF);
    for (int32_t t = 0; t < skin->shape->n_facets; t++)
        if (is_too_far(skin, t))
            skin->tolerance[t] = INFINITY;
    if (n > 0)
        pl_log(PLANISH_LOG_NOTE,
               "%" PRId64 " nodes do not move: the surface there is farther off options.shape than "
               "surface_tolerance",
               n);
}

int pl_skin_is_off(const pl_skin *skin, int32_t node) {
    return any_facet(skin, node, is_too_far);
}

/** Take where the nodes are that are not of the plan. Returns 0 without memory. */
static int take_outside(pl_skin *skin, const pl_points *points) {
    const planish_shape *shape = skin->shape;
    int32_t n = 0;
    for (int32_t node = 0; node < shape->n_nodes; node++)
        if (skin->inner[node] < 0 && skin->inner[node] != PL_SKIN_MID)
            skin->inner[node] = PL_SKIN_OUTSIDE - n++;
    skin->outside = pl_alloc(n, sizeof *skin->outside);
    if (!skin->outside)
        return 0;
    for (int32_t node = 0; node < shape->n_nodes; node++)
        for (int d = 0; d < 3 && skin->inner[node] <= PL_SKIN_OUTSIDE; d++)
            skin->outside[PL_SKIN_OUTSIDE - skin->inner[node]][d] =
                points->x[pl_point_at(points, shape->node[node], d)];
    return 1;
}

/** Take the places of all nodes. */
static void take_places(pl_skin *skin) {
    const planish_shape *shape = skin->shape;
    for (int32_t node = 0; node < shape->n_nodes; node++) {
        pl_place place = pl_shape_first_place(shape, node);
        pl_skin_set_place(skin, node, &place);
        if (skin->inner[node] >= 0)
            follow(skin, node);
        if (skin->inner[node] == PL_SKIN_MID) {
            place = pl_skin_present_place(skin, node);
            pl_skin_set_place(skin, node, &place);
        }
    }
}

static void find_discs(void *context, int64_t begin, int64_t end, int thread) {
    const pl_skin *skin = context;
    (void)thread;
    for (int32_t node = (int32_t)begin; node < end; node++)
        if (pl_skin_has(skin, node) && skin->shape->node_class[node] == PL_ON_PATCH &&
            !skin->shape->whole)
            pl_disc_find(skin->shape, node, &skin->disc[node]);
        else
            skin->disc[node].radius2 = 0;
}

static int allocate(pl_skin *skin) {
    const int64_t n = skin->shape->n_nodes, n_facets = skin->shape->n_facets;
    skin->max_facets = 0;
    for (int32_t i = 0; i < n; i++) {
        int64_t at = 0;
        pl_shape_star(skin->shape, i, &at);
        skin->max_facets = at > skin->max_facets ? at : skin->max_facets;
    }
    skin->node = pl_alloc(skin->n_stars, sizeof *skin->node);
    skin->star = pl_alloc(n, sizeof *skin->star);
    skin->inner = pl_alloc(n, sizeof *skin->inner);
    skin->moves = pl_alloc_zero(n, sizeof *skin->moves);
    skin->known = pl_alloc(n, sizeof *skin->known);
    skin->place = pl_alloc(n, sizeof *skin->place);
    skin->direction = pl_alloc(n, sizeof *skin->direction);
    skin->bound = pl_alloc_zero(n_facets, sizeof *skin->bound);
    skin->tolerance = pl_alloc(n_facets, sizeof *skin->tolerance);
    skin->turned = pl_alloc(n_facets, sizeof *skin->turned);
    skin->disc = pl_alloc(n, sizeof *skin->disc);
    skin->is_planar = pl_alloc(n_facets, sizeof *skin->is_planar);
    skin->room = pl_alloc(PL_SKIN_ROOM * skin->max_facets * skin->threads, sizeof *skin->room);
    return skin->node && skin->star && skin->inner && skin->moves && skin->known && skin->place &&
           skin->direction && skin->bound && skin->tolerance && skin->turned && skin->disc &&
           skin->is_planar && skin->room && pl_skin_mids_make(skin);
}

int pl_skin_make(const planish_options *options, pl_skin *skin, planish_error *error) {
    const int has_room = allocate(skin);
    skin->unscale = 1 / skin->shape->scale;
    if (has_room)
        find_tolerances(skin, options);
    if (!has_room || !find_planar(skin))
        return pl_fail_memory(error, "the surface of a mesh");
    return PLANISH_OK;
}

static int is_near(const pl_skin *skin, int32_t facet) {
    return skin->is_near[facet];
}

/** Hold the nodes of sheets that could meet across a gap. */
static int hold_near(pl_skin *skin, planish_error *error) {
    const int is_open = skin->plan == NULL;
    uint8_t *may_leave = pl_alloc(skin->shape->n_facets, sizeof *may_leave);
    skin->is_near = pl_alloc(skin->shape->n_facets, sizeof *skin->is_near);
    const int has_room = may_leave && skin->is_near;
    for (int32_t t = 0; has_room && t < skin->shape->n_facets; t++)
        may_leave[t] = (uint8_t)is_curved(skin, t);
    const int status = has_room ? pl_shape_find_gaps(skin->shape, skin->tolerance, may_leave,
                                                     is_open, skin->threads, skin->is_near, error)
                                : pl_fail_memory(error, "the surface of a mesh");
    pl_free(may_leave);
    const int64_t n = status ? 0 : hold(skin, is_near, PL_SKIN_NEAR);
    pl_free(skin->is_near);
    skin->is_near = NULL;
    if (n > 0)
        pl_log(PLANISH_LOG_NOTE,
               "%" PRId64 " nodes do not move: another sheet of the surface is nearer there than "
               "twice surface_tolerance",
               n);
    return status;
}

int pl_skin_begin(pl_skin *skin, const pl_points *points, planish_error *error) {
    const int status = hold_near(skin, error);
    if (status)
        return status;
    if (!take_outside(skin, points))
        return pl_fail_memory(error, "the surface of a mesh");
    hold(skin, is_loose, PL_SKIN_STAYS);
    take_places(skin);
    bound_all(skin);
    hold_far(skin);
    if (!skin->shape->whole)
        pl_parallel_for(pl_paying_threads(skin->threads, skin->shape->n_nodes),
                        skin->shape->n_nodes, CHUNK_FACETS, find_discs, skin);
    return PLANISH_OK;
}

void pl_skin_destroy(pl_skin *skin) {
    pl_skin_mids_destroy(skin);
    pl_free(skin->node);
    pl_free(skin->star);
    pl_free(skin->inner);
    pl_free(skin->moves);
    pl_free(skin->outside);
    pl_free(skin->known);
    pl_free(skin->place);
    pl_free(skin->direction);
    pl_free(skin->bound);
    pl_free(skin->tolerance);
    pl_free(skin->turned);
    pl_free(skin->disc);
    pl_free(skin->is_planar);
    pl_free(skin->room);
    *skin = (pl_skin){0};
}
