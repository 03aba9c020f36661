/* skin: the surface of a mesh on its way along a shape (options.shape).
 *
 * A node of the skin goes from place to place on the shape, whose patches and curves its visits see
 * as a surface (star.h). Where it may go is decided here: no smooth edge may bend too much, and no
 * facet turn too far. Every facet stays within the tolerance of the shape, by its bound or a new
 * certificate (shape/overlay.h). Nodes that slide on planes and lines belong to the skin if one of
 * their facets has a node that moves on a patch or curve. The facets of the others stay in their
 * planes, and are looked at in the end: beyond the seam to a curved part of the patch the plane
 * does not belong to the shape.
 *
 * The facets of a node are in its elements, and the nodes across edges have other colours
 * (plan/across.c): so each facet has one writer at a time.
 *
 * skin_plan.c
 *   pl_skin_create                               of a run on a plan's mesh
 *   pl_skin_put_back, _check_bends               nodes whose facets are too far off, or bent
 * skin_places.c
 *   pl_skin_make, _find_moves, _begin, _destroy  places and bounds
 *   pl_skin_certify                              bound of a facet
 *   pl_skin_has, _is_curved, _is_off, _is_at     of a node; of places
 *   pl_skin_held_by                              why a movable node stays
 *   pl_skin_follow, _check                       nodes have moved otherwise; look at all facets
 *   pl_skin_save, _restore                       for trials
 * skin_mids.c   where facets are of second order
 *   pl_skin_mids_make, _destroy                  room for visits
 *   pl_skin_mids_prepare, _begin, _try, _take    mids in visits
 *   pl_skin_move_mids                            for the watch to see them
 *   pl_skin_place_mids, pl_skin_is_placed        otherwise
 *   pl_skin_certify_whole                        bound of a facet
 * skin.c
 *   pl_skin_prepare, _begin_visit, _end_visit    frame of the visits of nodes
 *   pl_skin_project                              where the node of a visit may be
 *   pl_skin_ask                                  how nodes slide where they are
 *   pl_skin_fetch_node, _list, _facets, _corners ask for memory ahead
 */
#ifndef PL_SWEEP_SKIN_H
#define PL_SWEEP_SKIN_H

#include "plan/plan.h"
#include "shape/disc.h"
#include "shape/fan.h"
#include "shape/pn.h"
#include "shape/walk.h"
#include "sweep/watch.h"

#include <string.h>

/** A smooth edge bends by 40 degrees at most: the cosine. */
#define PL_SKIN_BEND 0.7660444431189781

/** How a node of the shape moves: as the planish_constraint of its visits, _FREE or _FIXED: not at all;
 *  or as one of these. */
enum {
    PL_SKIN_OFF =
        8, /* not at all, though it is movable: its facets are too far off at the start, */
    PL_SKIN_NEAR = 9,   /* or another sheet is near, */
    PL_SKIN_STAYS = 10, /* or the skin cannot follow it along the shape */
    PL_SKIN_FLAT = 16,  /* on a plane or line, and changes nothing of the surface */
    PL_SKIN_LOOSE = 17, /* the skin knows nothing of its moves: its facets stay otherwise */
    PL_SKIN_PAIRED = 18 /* in a periodic pair, while the skin is made */
};

/** A place on the shape, as it is kept between visits: near enough to walk on from. */
typedef struct pl_skin_place {
    int32_t at; /* as pl_place.at */
    float weight[3];
} pl_skin_place;

/** The skin of a run. Nodes and facets have the shape's numbers, lengths its units but where said
 *  otherwise. Arrays are owned. */
typedef struct pl_skin {
    const planish_plan *plan;   /* NULL: the mesh is a surface itself */
    const planish_shape *shape; /* NULL: there is none, and the rest is not used */
    double *coordinates;        /* by inner numbers, in the mesh's units; not owned */
    const pl_star_slide *slide; /* [n_stars] planes and lines of stars; not owned */
    int64_t n_stars;            /* that slide */
    int threads;
    planish_project_fn *project; /* the caller's, of other nodes */
    void *project_user;
    pl_storage storage;
    int32_t *node;  /* [n_stars] of the skin; -1: the star's is not */
    int32_t *star;  /* [n_nodes] sliding star of each; -1: it has none */
    int32_t *inner; /* [n_nodes] inner number; PL_SKIN_MID; from PL_SKIN_OUTSIDE downwards of those
                           not of the plan: place in outside */
    uint8_t *moves; /* [n_nodes] how */
    double (*outside)
        [3];         /* [n_outside] in the mesh's units: where nodes are that are not of the plan */
    uint64_t *known; /* [n_nodes] pl_skin_print of where place is that of the node */
    pl_skin_place *place;  /* [n_nodes] at -1: none is known */
    float (*direction)[3]; /* [n_nodes] unit normal or tangent of the shape at the place of those
                              that the skin moves on patches and curves */
    float *bound;          /* [n_facets] none of its points is farther off the shape */
    float *tolerance;      /* [n_facets] */
    uint8_t
        *turned;   /* [n_facets] its unit normal is no farther from the one that the shape keeps: in
                           units of PL_SKIN_TURN, PL_SKIN_UNKNOWN: this is not known */
    pl_disc *disc; /* [n_nodes] around nodes on patches that the skin moves */
    uint8_t *is_planar; /* [n_facets] of a patch that is planar */
    pl_fan *fan;        /* [n_nodes] while all facets are looked at, of linear ones; or NULL */
    uint8_t *is_near;   /* [n_facets] while the skin is made: another sheet is near */
    double unscale;     /* 1 / shape->scale */
    int64_t max_facets; /* of a node */
    double *room;       /* [threads][PL_SKIN_ROOM * max_facets] for visits */
    int64_t n_off;      /* visits that were shortened or refused */
    pl_mids *mids;      /* of a shape of second order: mids follow by it, and go to the shape by
                           mids->own; a mid has its place, its inner number is PL_SKIN_MID */
    struct pl_skin_wholes *wholes; /* [threads] room for visits of their corners */
    int32_t *mid_number; /* [n_nodes] with wholes: of a mid in the last visit of a parent */
} pl_skin;

/** Inner numbers of a mid, and of the first node that is not of the plan. */
enum { PL_SKIN_MID = -2, PL_SKIN_OUTSIDE = -3 };

/* Unit of distances between unit vectors, which are 2 at most: as coarse as a byte asks for. */
#define PL_SKIN_TURN 0x1p-7
enum { PL_SKIN_UNKNOWN = 255 };

/** A place for the mid of an edge at the node of a visit. */
typedef struct pl_mid_trial {
    double x[3];   /* in the shape's units, as stored */
    double own[3]; /* as in pl_mids */
    pl_place place;
} pl_mid_trial;

/* The node ends where it was accepted last, or at one of the last trials: a line search ends as soon as
 * one is accepted, or with the one before. */
enum { PL_SKIN_TRIALS = 4, PL_SKIN_ROOM = 4 * PL_SKIN_TRIALS + 10 };

/** A place where a node of the skin may be. Arrays are over the facets of the node. */
typedef struct pl_skin_trial {
    int is_known;
    double x[3]; /* in the mesh's units, as stored */
    pl_place place;
    double direction[3];
    double *bound, (*normal)[3]; /* of its facets then; unit normals */
    pl_mid_trial *mid;           /* of the visit's mids */
} pl_skin_trial;

/** A visit of a node of the skin. Arrays are over its facets. */
typedef struct pl_skin_visit {
    pl_skin *skin;
    int64_t star;
    int32_t node;
    int n;
    const int32_t *facet;          /* [n] */
    double start[3], direction[3]; /* where it began */
    int has_direction, has_rim, has_normals, is_off;
    int newest;                          /* of trial */
    pl_skin_trial trial[PL_SKIN_TRIALS]; /* [0]: accepted last */
    double (*rim)[2][3];                 /* [n] their other corners, as they turn */
    double (*normal)[3];                 /* [n] where it began, of unit length */
    int32_t *opposite;                   /* [n] facet across the edge opposite to the node, or -1 */
    int32_t *next; /* [n] number here of the facet across the edge to the first of the rim, or -1 */
    struct pl_skin_wholes *wholes; /* where facets are of second order */
} pl_skin_visit;

/** Return the coordinates of a node that is no mid, in the mesh's units. */
static inline const double *pl_skin_at(const pl_skin *skin, int32_t node) {
    const int32_t inner = skin->inner[node];
    return inner < 0 ? skin->outside[PL_SKIN_OUTSIDE - inner]
                     : skin->coordinates + (int64_t)inner * 3;
}

/** Return a number that tells the place x apart from others: of two places it is the same by one
 *  chance in 2^64, and never if they differ in one coordinate alone. A third of the memory of
 *  coordinates. */
static inline uint64_t pl_skin_print(const double x[3]) {
    uint64_t print = 1;
    for (int d = 0; d < 3; d++) {
        const double value = x[d] + 0.0; /* -0 becomes 0 */
        uint64_t bits;
        memcpy(&bits, &value, sizeof bits);
        print = (print ^ bits) * 0x9e3779b97f4a7c15u;
        print ^= print >> 29;
    }
    return print;
}

/** Whether a node is where its place is known. */
static inline int pl_skin_is_known(const pl_skin *skin, int32_t node, const double x[3]) {
    return skin->known[node] == pl_skin_print(x);
}

/** Return how far a unit normal is from another one, in units, rounded up. distance: NAN or
 *  infinite: unknown.
 */
static inline uint8_t pl_skin_turn(double distance) {
    const double units = distance / PL_SKIN_TURN;
    return units < PL_SKIN_UNKNOWN - 1 ? (uint8_t)(units + 1) : PL_SKIN_UNKNOWN;
}

/** Set x to where a node is, in the shape's units. */
static inline void pl_skin_place_of(const pl_skin *skin, int32_t node, double x[3]) {
    double mid[3];
    const int is_mid = skin->inner[node] == PL_SKIN_MID;
    if (is_mid)
        pl_mid_place(skin->mids, skin->shape->node[node], mid);
    const double *at = is_mid ? mid : pl_skin_at(skin, node);
    for (int d = 0; d < 3; d++)
        x[d] = at[d] * skin->shape->scale;
}

/** Return where a node is on the shape, about. */
static inline pl_place pl_skin_get_place(const pl_skin *skin, int32_t node) {
    const pl_skin_place *kept = &skin->place[node];
    return (pl_place){kept->at, {kept->weight[0], kept->weight[1], kept->weight[2]}};
}

static inline void pl_skin_set_place(const pl_skin *skin, int32_t node, const pl_place *place) {
    pl_skin_place *kept = &skin->place[node];
    kept->at = place->at;
    for (int k = 0; k < 3; k++)
        kept->weight[k] = (float)place->weight[k];
}

/** Whether a node of the skin moves on a patch or curve. */
static inline int pl_skin_is_on_shape(const pl_skin *skin, int32_t node) {
    return skin->moves[node] >= PLANISH_CONSTRAINT_ON_PATCH;
}

/** Keep the direction of the shape at the place of a node. */
static inline void pl_skin_set_direction(const pl_skin *skin, int32_t node,
                                         const double direction[3]) {
    for (int d = 0; d < 3; d++)
        skin->direction[node][d] = (float)direction[d];
}

/** Return a float that is not below x, which is not negative; the same if x is infinite or no number. */
static inline float pl_float_above(double x) {
    return x > 0 ? (float)(x * (1 + 0x1p-23) + 0x1p-149) : (float)x;
}

/** Whether facet i of a visit turns by 60 degrees at most from where it was first, if its normal is
 *  that of trial. */
static inline int pl_skin_keeps_turn(const pl_skin_visit *v, const pl_skin_trial *trial, int i) {
    double first[3];
    pl_kept_normal(v->skin->shape, v->facet[i], first);
    return pl_dot(3, trial->normal[i], first) >= 0.5 + 2 * PL_KEPT_NORMAL_OFF;
}

/** Whether the skin moves a node. */
static inline int pl_skin_has(const pl_skin *skin, int32_t node) {
    return skin->moves[node] >= PLANISH_CONSTRAINT_ON_PLANE && skin->moves[node] < PL_SKIN_OFF;
}

/** Return why the skin holds a node that is movable. */
static inline planish_held_by pl_skin_held_by(const pl_skin *skin, int32_t node) {
    const uint8_t moves = skin->moves[node];
    return moves == PL_SKIN_OFF     ? PLANISH_HELD_BY_TOLERANCE
           : moves == PL_SKIN_NEAR  ? PLANISH_HELD_BY_SHEET
           : moves == PL_SKIN_STAYS ? PLANISH_HELD_BY_SURFACE
                                    : PLANISH_HELD_BY_NONE;
}

/** Make the skin of a run whose coordinates are in the plan, and set how the plan's nodes slide.
 *  Where facets are of second order let watch see their mids, and watch all cells that have one
 *  which moves by itself; they are to be measured. coordinates: the caller's. Errors: _MEMORY,
 *  _ARGUMENT (the mesh has no mids, and the shape has). */
int pl_skin_create(planish_plan *plan, const planish_options *options, const double *coordinates,
                   pl_watch *watch, pl_skin *skin, planish_error *error);

/** Make the arrays of a skin that has coordinates, slide, n_stars, threads and shape, with tolerances.
 *  Errors: _MEMORY. */
int pl_skin_make(const planish_options *options, pl_skin *skin, planish_error *error);

/** Let the skin, whose node and moves are set, move the nodes on patches and curves; then find how those
 *  on planes and lines move. slides_by [n_stars]: planish_constraint of each. */
void pl_skin_find_moves(pl_skin *skin, const uint8_t *slides_by);

/** Take the places of all nodes, which are at points, and the bounds of facets; hold what is loose,
 *  too far off, or near another sheet. Errors: _MEMORY. */
int pl_skin_begin(pl_skin *skin, const pl_points *points, planish_error *error);

/** Whether two places [3] are the same. */
static inline int pl_skin_is_at(const double *x, const double *y) {
    return x[0] == y[0] && x[1] == y[1] && x[2] == y[2];
}

/** Whether a facet at a node has a corner that the skin moves on a patch or curve. */
int pl_skin_is_curved(const pl_skin *skin, int32_t node);

/** Whether a facet at a node is too far off. */
int pl_skin_is_off(const pl_skin *skin, int32_t node);

/** Free the arrays of skin. */
void pl_skin_destroy(pl_skin *skin);

/** Bound how far a facet is off the shape if node is at x, in the shape's units, and there in
 *  place; node -1: as it is. Above the facet's tolerance: not known. */
double pl_skin_certify(const pl_skin *skin, int32_t facet, int32_t node, const double *x,
                       const pl_place *place);

/** Make room for the visits of corners of facets of second order; _destroy: free it. Returns 0 without
 *  memory. */
int pl_skin_mids_make(pl_skin *skin);
void pl_skin_mids_destroy(pl_skin *skin);

/** Prepare a visit's room, begin a visit, and after it take the places of mids from the trial
 *  accepted. */
void pl_skin_mids_prepare(const pl_skin *skin, int thread, pl_skin_visit *visit);
void pl_skin_mids_begin(pl_skin_visit *visit);
void pl_skin_mids_take(const pl_skin_visit *visit);

/** Whether the node of a visit, and with it the mids of its edges, may be where trial has the node: their
 *  places are then in trial, with bounds and normals of facets. */
int pl_skin_mids_try(pl_skin_visit *visit, pl_skin_trial *trial);

/** Let the mids of the visit's node be where they are to be if the node is where it is. Returns whether
 *  any has moved by itself. */
int pl_skin_move_mids(pl_skin_visit *visit);

/** Bring the mids of the edges at a node, which has moved otherwise, to the shape. */
void pl_skin_place_mids(pl_skin *skin, int32_t node);

/** Whether the mid of an edge, or the centre of a facet, goes to the shape when its n corners,
 *  parent, move. */
int pl_skin_is_placed(const pl_skin *skin, int32_t mid, const int32_t *parent, int n);

/** Bound how far a facet of second order is off the shape, as it is; above its tolerance: not
 *  known. facet: one of its triangles. */
double pl_skin_certify_whole(const pl_skin *skin, int32_t facet);

/** The place of a node that may have moved, as far as certificates need it. */
pl_place pl_skin_present_place(const pl_skin *skin, int32_t node);

/** Take note of nodes that have moved otherwise than by visits. Returns the number of facets that are
 *  farther off than they may be. */
int64_t pl_skin_follow(pl_skin *skin);

/** Do so, and bound the facets that have only nodes on planes and lines, which visits do not look
 *  at. A mesh that is a surface itself has such facets only in planar patches, where they stay
 *  exactly. */
int64_t pl_skin_check(pl_skin *skin);

/** After nodes were put back to given [n][dim], where the plan's nodes were at the start: find
 *  smooth edges that bend above 40 degrees, and further than at given; their facets count as too
 *  far off until their nodes move. Returns how many there are; 1 without memory. */
int64_t pl_skin_check_bends(pl_skin *skin, const double *given);

/** Put the nodes of facets that are too far off, or at smooth edges that bend too much, to given;
 *  returns how many had moved. */
int64_t pl_skin_put_back(pl_skin *skin, const double *given);

/** Prepare visit for a thread's visits. */
void pl_skin_prepare(pl_skin *skin, int thread, pl_skin_visit *visit);

/** Begin the visit of a sliding star whose node is of the skin. */
void pl_skin_begin_visit(pl_skin_visit *visit, int64_t star);

/** Return the number in a visit of a facet; -1: it is not at the node. */
int32_t pl_skin_number_of(const pl_skin_visit *visit, int32_t facet);

/** End a visit: places and bounds become those of where the node is. Returns 0 if it is not known
 *  that it may be there: then it is back where it was. */
int pl_skin_end_visit(pl_skin_visit *visit);

/** Say where the node of a visit, user, may be near point: a planish_project_fn. */
planish_constraint pl_skin_project(int64_t node, double *point, double *direction, void *user);

/** Say how nodes slide where they are, user being a pl_skin; of nodes that are not of it ask the
 *  caller: a planish_project_fn. */
planish_constraint pl_skin_ask(int64_t node, double *point, double *direction, void *user);

/** Return a copy of places and bounds, to be released by pl_free; NULL: there are none, or there is no
 *  memory. */
void *pl_skin_save(const pl_skin *skin);

/** Return by what a node of the mesh, a mid of the shape, had moved by itself [3] when saved was saved; NULL:
 *  saved does not tell. */
const double *pl_skin_saved_own(const pl_skin *skin, const void *saved, int32_t node);

/** Bring back saved places and bounds, if any, of nodes that are back where they were then. */
void pl_skin_restore(pl_skin *skin, void *saved);

/** Ask ahead for the memory that the visit of a star reads if its node is of the skin, and for that
 *  of the next such visit. */
void pl_skin_fetch_node(const pl_skin *skin, int64_t star);
void pl_skin_fetch_list(const pl_skin *skin, int64_t star);
void pl_skin_fetch_facets(const pl_skin *skin, int64_t star);
void pl_skin_fetch_corners(const pl_skin *skin, int64_t star);

#endif
