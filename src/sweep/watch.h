/* watch: cells that their corners alone do not certify. Sweeps know corners alone.
 *
 * A cell of a plan is a simplex, or has several corners (quality/view.h). With positive corners
 * hexahedra and wedges may be invalid, and so may curved cells of order 2. These are watched: after
 * each visit that moves a corner of a cell, its validity is decided (quality/validity.h), unless
 * the node stayed within the room that the cell has. A move that would make a cell invalid is
 * halved, or refused. So is one that takes it below its minimum volume, or makes its aspect ratio
 * worse than any was. Cells at nodes of one colour are different ones, so that each is watched by
 * one thread at a time.
 *
 * Nodes of order 2 follow corners: from their start they go 1/2 of the way of both ends of an edge,
 * 1/4 of that of the corners of a face, 1/8 of those of a cell, stored as coordinates are. So they
 * have no state, and are written once, at the end.
 *
 * mids.c
 *   pl_plan_cell_corners          a cell of a plan
 *   pl_mids_create, _destroy      nodes that follow, and their parents,
 *   pl_mids_note, _number         to be noted for each cell
 *   pl_mid_place, _place_by, _coordinate, _own    where a node is
 *   pl_mid_parents                what it is between
 *   pl_mids_release, _put_back, pl_mid_has_moved    nodes that move by themselves
 *   pl_mids_write                 to the caller's coordinates
 * watch_create.c
 *   pl_watch_create, _destroy     find the cells
 *   pl_watch_add                  further ones
 *   pl_cell_with                  the cell of a corner
 * watch.c; watch_cell.c has the decision of one cell, and the proof of its room
 *   pl_watch_measure, _decide     decide all of them, or one
 *   pl_watch_has_poor             whether a curved one is poor
 *   pl_watch_judge, _has, _admit   of nodes, after their moves
 *   pl_watch_forget               a node moved otherwise
 *   pl_watch_limit, _worst        what cells may not exceed; measures of a node's cells
 *   pl_watch_fetch_begin, _list, _rooms   ask for memory ahead
 *   pl_watch_find_broken          cells that were valid and are not any more
 *   pl_watch_find_refusers        cells that keep refusing moves
 *   pl_watch_decide_all, _look_again    some cells; those of a node that were not valid
 * watch_late.h: cells that wait for the end of a sweep
 */
#ifndef PL_SWEEP_WATCH_H
#define PL_SWEEP_WATCH_H

#include "base/round.h"
#include "geometry/fetch.h"
#include "geometry/simplex.h"
#include "plan/plan.h"
#include "quality/validity.h"

/** Nodes of a plan's cells that follow corners. Arrays are owned. */
typedef struct pl_mids {
    const planish_plan *plan;
    const double *given; /* [n][dim] where the plan's nodes were when the run began, */
    pl_points start; /* and all nodes of the mesh: the caller's, which change at the end alone */
    pl_storage storage;
    int32_t (
        *end)[2]; /* [nodes of the mesh] both ends of each mid, nodes of the plan; PL_NO_MID; or
                     PL_OF_MORE and a place in more */
    double *own;  /* [nodes of the mesh][dim] by what they have moved themselves (improve/mend);
                    NULL: none has */
    int64_t n_more;
    int32_t (*more)[PL_CELL_CORNERS]; /* [n_more] nodes of the plan, ascending, -1 after the last */
} pl_mids;

enum { PL_NO_MID = -1, PL_OF_MORE = -2 };

enum { PL_WATCH_TYPES = PLANISH_CELL_WEDGE18 + 1 };

/** Rule of a type of cells, and the change of such a cell if a corner moves by d, with the nodes
 *  that follow it. */
typedef struct pl_watch_rule {
    pl_jacobian_rule jacobian;
    double weight; /* a coefficient changes by at most weight |d| L^(dim - 1), L the longest
                      derivative before; of linear cells: one that is not at a corner */
    double change; /* a derivative changes by at most change |d| */
    uint8_t is_at_corner[PL_JACOBIAN_COEFFICIENTS]; /* coefficients at corners of linear cells */
} pl_watch_rule;

/** Bits of pl_watch.state. */
enum { PL_WATCH_VALID = 1, PL_WATCH_ABOVE = 2 /* its floor */ };

/** When a cell is decided while cells wait. */
enum {
    PL_WATCH_WAITS = 0,       /* at the end of the sweep */
    PL_WATCH_AT_ONCE = 1,     /* after each visit: it is curved or has refused moves, */
    PL_WATCH_AT_ONCE_BAD = 2, /* or was not valid when the sweep began */
    PL_WATCH_BROKEN = 4       /* further bit: it was valid then, and is not where the nodes are */
};

/** Move of a node in a sweep whose cells wait. */
typedef struct pl_watch_way {
    float length; /* a little more than it; 0: none; negative: it is to be undone */
    int32_t star; /* of the node */
} pl_watch_way;

/** Move of a star as it was counted. */
typedef struct pl_watch_record {
    double before[3]; /* where the node was */
    double fall;      /* as in pl_star_gain */
    uint8_t improved, restored;
} pl_watch_record;

/** Cells that wait for the end of a sweep to be decided. Arrays are owned. */
typedef struct pl_watch_late {
    int is_on;               /* in the sweep under way; it may be with way alone */
    pl_watch_way *way;       /* [1 + n_nodes] by inner numbers + 1; of no node first */
    pl_watch_record *record; /* [most stars of visits] of those that have moved */
    uint8_t *has_at_once;    /* [n_nodes] by inner numbers: any cell of the node does not wait */
    uint8_t *when;           /* [n] PL_WATCH_WAITS, ... */
} pl_watch_late;

/** Watched cells of a run. With corners these are all cells of the plan; what the corners of one say
 *  is all there is to say of it if it has no type. Arrays are owned. */
typedef struct pl_watch {
    const planish_plan *plan;
    pl_mids mids;     /* end NULL: all cells are linear */
    double worst_ar2; /* no cell's AR^2 shall become larger; infinite: nothing is promised */
    uint8_t *
        has_large; /* [n_nodes + n_images] by inner numbers 1: a cell of the node may have a corner whose mu^2 is
                           above worst_ar2; NULL: nothing is promised */
    pl_watch_rule *rule[PL_WATCH_TYPES]; /* by types; NULL: no cell needs it */
    double min_volume;                   /* of cells without their own; 0: none */
    double stray;        /* how far a node may be off where it follows, by rounding; infinite: not
                          known */
    double rounding;     /* of coordinates, as options say */
    uint8_t *is_curved;  /* [cells of the plan]; NULL: none is */
    int64_t n, n_curved; /* watched cells; curved ones */
    int32_t *cell;       /* [n] of the plan; all of them with corners, along its curve */
    uint8_t *type;       /* [n] whose rule decides the cell, 0: none */
    int32_t (*node)[PL_CELL_CORNERS]; /* [n] corners by inner numbers, of hexahedra and wedges
                                         so that det J is to be positive; NULL: no corners */
    float *room;           /* [n] how far nodes of the cell may go, added up, without a decision */
    double *floor;         /* [n] what coefficients that are not at corners (of order 2: all) shall
                              not fall below; NULL: 0 */
    uint8_t *state;        /* [n] decided where the nodes are */
    uint8_t *n_refused_of; /* [n] moves, also halved ones, that it refused; 255 at most */
    float *quality;        /* [n] of curved simplices their least coefficient over the mean, as
                              measured last; of others infinite; NULL: no cell is curved */
    int64_t *begin;        /* [n_nodes + 1] by inner numbers: where watched of each node begins */
    int32_t
        *watched; /* cells of each movable node, and of those that follow it, by types; last those
                              without one */
    pl_incidence
        follower; /* places in plan->sliding.follower by the nodes that these follow; NULL: none
                              does */
    pl_watch_late late;
    uint8_t decides;   /* any cell has a type */
    int64_t n_turned;  /* valid ones whose corners are not positive, as measured last */
    int64_t n_refused; /* moves; shared by threads */
} pl_watch;

/** Whether some cells need more than their corners. */
static inline int pl_watch_is_on(const pl_watch *w) {
    int on = 0;
    for (int t = 0; t < PL_WATCH_TYPES; t++)
        on |= w->rule[t] != NULL;
    return on;
}

/** Whether nodes follow corners. */
static inline int pl_watch_has_mids(const pl_watch *w) {
    return w->mids.end != NULL;
}

/** Cell of the plan that is the i-th watched one. */
static inline int64_t pl_watch_cell(const pl_watch *w, int64_t i) {
    return w->cell[i];
}

/** Whether the i-th watched cell was valid when it was decided last. */
static inline int pl_watch_is_valid(const pl_watch *w, int64_t i) {
    return w->state[i] & PL_WATCH_VALID;
}

/** Whether a cell of a node, by inner number, was not valid when it was decided last. Of cells that corners
 *  alone decide nothing is said. */
static inline int pl_watch_has_invalid(const pl_watch *w, int32_t node) {
    int any = 0;
    for (int64_t k = w->begin ? w->begin[node] : 0; w->begin && k < w->begin[node + 1]; k++)
        any |= w->type[w->watched[k]] && !pl_watch_is_valid(w, w->watched[k]);
    return any;
}

/** Return the cell that has an element of a plan. */
int64_t pl_cell_with(const planish_plan *plan, int64_t element);

/** Find the corners of a cell, nodes of the plan, in the order of its type; returns how many. */
int pl_plan_cell_corners(const planish_plan *plan, int64_t cell, int32_t corner[PL_CELL_CORNERS]);

/** Make mids of plan without any. start: the caller's coordinates of all nodes of the mesh; given
 *  [n][dim]: those of the plan's nodes. Errors: _MEMORY. */
int pl_mids_create(const planish_plan *plan, const planish_options *options, const double *given,
                   const double *start, pl_mids *mids, planish_error *error);

/** Note the ends of the mids of a cell, which is of order 2 and type, and after pl_mids_number again
 *  (numbered) the parents of other nodes. Several threads may do so: cells that share a node say
 *  the same, or its parents are held (PL_OF_EDGES). */
void pl_mids_note(pl_mids *mids, int64_t cell, const pl_cell_type *type, int numbered);

/** Make room for the parents of nodes that are in no edge. Errors: _MEMORY. */
int pl_mids_number(pl_mids *mids, planish_error *error);

/** Free the arrays of mids. */
void pl_mids_destroy(pl_mids *mids);

/** Coordinate d of a node that follows by way in this direction, and by own goes itself. */
static inline double pl_mid_coordinate_by(const pl_mids *mids, int32_t node, int d, double follows,
                                          double own) {
    const double start = mids->start.x[pl_point_at(&mids->start, node, d)];
    const double way = follows + own;
    return way != 0 ? pl_store(&mids->storage, start + way) : start; /* what stays is not rounded */
}

/** By what a node has moved by itself [dim]; NULL: by nothing. */
static inline const double *pl_mid_own(const pl_mids *mids, int32_t node) {
    return mids->own ? mids->own + (int64_t)node * mids->start.dim : NULL;
}

/** Coordinate d of a node that follows by way in this direction. */
static inline double pl_mid_coordinate(const pl_mids *mids, int32_t node, int d, double follows) {
    const double *own = pl_mid_own(mids, node);
    return pl_mid_coordinate_by(mids, node, d, follows, own ? own[d] : 0);
}

/** Whether a node of order 2 has moved by itself. */
static inline int pl_mid_has_moved(const pl_mids *mids, int32_t node) {
    int any = 0;
    for (int d = 0; mids->own && d < mids->start.dim; d++)
        any |= mids->own[(int64_t)node * mids->start.dim + d] != 0;
    return any;
}

/** Set parent to the nodes of the plan that a node of order 2 is between; returns how many, 0: it follows
 *  none. */
int pl_mid_parents(const pl_mids *mids, int32_t node, const int32_t **parent);

/** Make mids movable by themselves. Errors: _MEMORY. */
int pl_mids_release(pl_mids *mids, planish_error *error);

/** Let the mids of an element (of corners: its first one), which have been released, move no more by
 *  themselves; how many had. */
int64_t pl_mids_put_back(const pl_mids *mids, int64_t element);

/** Set x [dim] to the place of a node of the mesh that follows, at the plan's present coordinates. */
void pl_mid_place(const pl_mids *mids, int32_t node, double *x);

/** Set x [dim] to the place of a node of the mesh that follows, where the plan's nodes are at now, by inner
 *  numbers, and it has moved by own [dim] itself (NULL: by nothing). */
void pl_mid_place_by(const pl_mids *mids, int32_t node, const double *now, const double *own,
                     double *x);

/** Write mids that have moved to coordinates, the caller's, if writes. Add how many have, and raise
 *  *farthest to how far. */
void pl_mids_write(const pl_mids *mids, int writes, double *coordinates, int64_t *moved,
                   double *farthest);

/** Find the cells of plan to be watched; arguments as for pl_mids_create. min_volume: of cells
 *  without their own, 0: none. *watch is to be destroyed in any case. Errors: _MESH (a mid that is
 *  not finite), _MEMORY. */
int pl_watch_create(const planish_plan *plan, const planish_options *options, const double *given,
                    const double *start, double min_volume, pl_watch *watch, planish_error *error);

/** Watch n more cells of order 2, whose mids move by themselves; they are to be measured. element: of
 *  each its first corner. n_curved stays. Without memory nothing may be done with the watch but to
 *  destroy it. Errors: _MEMORY. */
int pl_watch_add(pl_watch *watch, int64_t n, const int32_t *element, planish_error *error);

/** Free the arrays of watch. */
void pl_watch_destroy(pl_watch *watch);

/** Let no cell's AR^2 become larger than worst_ar2, infinite for no limit. The mesh was measured before
 *  (scratch.to_measure). */
void pl_watch_limit(pl_watch *watch, double worst_ar2);

/** Decide all watched cells at the plan's present coordinates; returns how many are invalid with
 *  positive corners. */
int64_t pl_watch_measure(pl_watch *watch);

/** Decide a cell at the plan's present coordinates: by the rule of its type; by its corners where these
 *  say all. */
pl_validity pl_watch_decide(const pl_watch *watch, int64_t cell);

/** Whether a curved simplex has a quality, as measured last, below quality. */
int pl_watch_has_poor(const pl_watch *watch, double quality);

/** Whether watched cells are at the node of this inner number. */
static inline int pl_watch_has(const pl_watch *w, int32_t node) {
    return w->begin[node + 1] > w->begin[node];
}

/** Distance of two places, of which rooms are made; rounding is in their margins. */
PL_INLINE double pl_watch_distance(int dim, const double *x, const double *y) {
    double square = 0;
    for (int d = 0; d < dim; d++)
        square += (y[d] - x[d]) * (y[d] - x[d]);
    return square > 1e-280 && square < 1e280 ? sqrt(square) : pl_distance(dim, x, y);
}

/** Move of a node of inner number node, which has been made. */
typedef struct pl_watch_move {
    int32_t node;
    int32_t refuser;    /* cell; -1: none */
    uint8_t is_refused; /* the node is to go back */
    uint8_t has_others; /* cells that were not valid, or below their floor */
    double way;         /* its length */
} pl_watch_move;

/** Judge n moves of nodes of one colour: refused are those by which a watched cell that was valid is so
 *  no more, or that was above its floor. Moves that are refused before are passed over. */
void pl_watch_judge(pl_watch *watch, int n, pl_watch_move move[]);

/** Return 0 if the move of a node, of this length, is refused. */
int pl_watch_admit(pl_watch *watch, int32_t node, double way);

/** Let the cells at the node of this inner number, which has moved otherwise than by a visit, have no
 *  room. */
void pl_watch_forget(pl_watch *watch, int32_t node);

/** Most cells of pl_watch_decide_all. */
enum { PL_WATCH_CELLS = 256 };

/** Decide n cells, PL_WATCH_CELLS at most, of a plan with corners, which were valid and have no floor.
 *  is_valid [n]. */
void pl_watch_decide_all(pl_watch *watch, int n, const int32_t cell[], uint8_t is_valid[]);

/** Look again at the cells at the node of this inner number that were not valid, or below their floor. */
void pl_watch_look_again(pl_watch *watch, int32_t node);

/** The worst of some cells. */
typedef struct pl_worst_cell {
    double ar2;       /* largest AR^2; infinite: not all corners are positive */
    double acuteness; /* largest 1 / SJ^2, SJ the scaled Jacobian of a corner */
    double mu2;       /* largest of a corner */
} pl_worst_cell;

/** Return the worst of the cells at the node of this inner number, of a plan with corners, that have a
 *  corner whose mu^2 is above mu2 (0: all cells); 0: there are none. */
pl_worst_cell pl_watch_worst(const pl_watch *watch, int32_t node, double mu2);

/** The largest room that is stored for one of 0 or more: a little less. */
static inline float pl_watch_room_below(double room) {
    return room > 0x1p-100 ? (float)(room * (1 - 0x1p-23)) : 0;
}

/** Ask for where the list of a node's cells is; for the list; for the rooms of these. */
PL_AT_ONCE void pl_watch_fetch_begin(const pl_watch *w, int32_t node) {
    __builtin_prefetch(&w->begin[node]);
}

PL_AT_ONCE void pl_watch_fetch_list(const pl_watch *w, int32_t node) {
    const int32_t *list = w->watched + w->begin[node];
    __builtin_prefetch(list);
    __builtin_prefetch(list + 7);
}

PL_AT_ONCE void pl_watch_fetch_rooms(const pl_watch *w, int32_t node) {
    for (int64_t k = w->begin[node]; k < w->begin[node + 1]; k++)
        pl_fetch_to_write(&w->room[w->watched[k]]);
}

/** Mark in state [n_elements of the plan] with 1 the corners of cells that were valid when the run
 *  began and are invalid now. With of_all mark also those of all cells with corners that have
 *  turned; leave the other entries. Returns the number of cells. */
int64_t pl_watch_find_broken(const pl_watch *watch, int of_all, uint8_t *state);

/** Mark in state [n_elements of the plan] with 1 the first corners of cells with several corners
 *  that have refused several moves, though all their coefficients are positive; state NULL: only
 *  count them. Returns their number. */
int64_t pl_watch_find_refusers(const pl_watch *watch, uint8_t *state);

#endif
