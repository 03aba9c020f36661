/* watch: elements that their corners alone do not certify. Sweeps know corners alone.
 *
 * A mid's place follows from those of its two ends: its start, and half of the way of both, stored
 * as coordinates are. So mids have no state, but for the few that have moved by themselves, and are
 * written once, at the end.
 *
 * Curved elements may be invalid with positive corners. They are watched: after each visit that
 * moves a corner of one, its validity is decided (quality/validity.h), unless a bound says that the
 * move was too short to matter. A move that would invert a curved element is halved, or refused.
 * Elements of one colour share no node, so that each is watched by one thread at a time.
 *
 * mids.c
 *   pl_mids_create, _destroy      mids and their ends,
 *   pl_mids_note                  to be noted for each element
 *   pl_mid_place, _coordinate     where a mid is
 *   pl_mids_release, _put_back, pl_mid_has_moved   mids that move by themselves
 *   pl_mids_write                 to the caller's coordinates
 * watch.c
 *   pl_watch_create, _destroy    find curved elements
 *   pl_watch_add                 further ones
 *   pl_watch_measure             decide all of them
 *   pl_watch_has, _admit     of one node, after its move
 *   pl_watch_find_broken         elements that were valid and are not any more
 */
#ifndef PL_SWEEP_WATCH_H
#define PL_SWEEP_WATCH_H

#include "base/round.h"
#include "plan/plan.h"
#include "quality/validity.h"

/** Mids of a plan's elements. Arrays are owned. */
typedef struct pl_mids {
    const planish_plan *plan;
    const double *given; /* [n][dim] where the plan's nodes were when the run began, */
    pl_points start; /* and all nodes of the mesh: the caller's, which change at the end alone */
    pl_storage storage;
    int32_t (
        *end)[2]; /* [nodes of the mesh] both ends of each mid, nodes of the plan; -1: no mid */
    double *own;  /* [nodes of the mesh][dim] by what mids have moved themselves (improve/curve.c);
                     NULL: none has */
} pl_mids;

/** Curved elements of a run. Arrays are owned. */
typedef struct pl_watch {
    const planish_plan *plan;
    pl_mids mids;
    pl_jacobian_rule *rule; /* of the elements of order 2; NULL: the plan has none */
    double stray;           /* how far a mid may be off half of the way, by rounding; infinite: not
                               known */
    double rounding;        /* of coordinates, as options say */
    uint8_t *is_curved;     /* [n_elements of the plan] */
    int64_t n, n_curved;    /* watched elements; curved ones */
    int32_t *element;       /* [n] of the plan's mesh */
    double *bound;          /* [n] at most the least coefficient of det J; 0: not known, */
    double *reach;          /* [n] at least the longest derivative */
    uint8_t *is_valid;      /* [n] decided where the nodes are */
    int64_t *begin;         /* [n_nodes + 1] by inner numbers: where watched of each node begins */
    int32_t *watched;       /* curved elements of each movable node */
    int64_t n_turned;       /* valid ones whose corners are not positive, as measured last */
    int64_t n_refused;      /* moves; shared by threads */
} pl_watch;

/** Whether elements of order 2 are in the plan. */
static inline int pl_has_order_2(const pl_watch *c) {
    return c->rule != NULL;
}

/** Make mids of plan without any. start: the caller's coordinates of all nodes of the mesh; given
 *  [n][dim]: those of the plan's nodes. Errors: _MEMORY. */
int pl_mids_create(const planish_plan *plan, const planish_options *options, const double *given,
                   const double *start, pl_mids *mids, planish_error *error);

/** Note the ends of the mids of an element, which is of order 2 and type. Several threads may do so:
 *  elements that share a mid say the same, or its ends are held (PL_OF_EDGES). */
void pl_mids_note(pl_mids *mids, int64_t element, const pl_cell_type *type);

/** Free the arrays of mids. */
void pl_mids_destroy(pl_mids *mids);

/** Coordinate d of a mid whose ends have moved by way_a and way_b in this direction. */
static inline double pl_mid_coordinate(const pl_mids *mids, int32_t node, int d, double way_a,
                                       double way_b) {
    const double start = mids->start.x[pl_point_at(&mids->start, node, d)];
    const double own = mids->own ? mids->own[(int64_t)node * mids->start.dim + d] : 0;
    const double way = 0.5 * (way_a + way_b) + own;
    return way != 0 ? pl_store(&mids->storage, start + way) : start; /* what stays is not rounded */
}

/** Whether a mid has moved by itself. */
static inline int pl_mid_has_moved(const pl_mids *mids, int32_t node) {
    int any = 0;
    for (int d = 0; mids->own && d < mids->start.dim; d++)
        any |= mids->own[(int64_t)node * mids->start.dim + d] != 0;
    return any;
}

/** Make mids movable by themselves. Errors: _MEMORY. */
int pl_mids_release(pl_mids *mids, planish_error *error);

/** Let the mids of an element, which have been released, move no more by themselves; how many had. */
int64_t pl_mids_put_back(const pl_mids *mids, int64_t element);

/** Set x [dim] to the place of a node of the mesh, a mid, at the plan's present coordinates. */
void pl_mid_place(const pl_mids *mids, int32_t node, double *x);

/** Write mids that have moved to coordinates, the caller's, if writes. Add how many have, and raise
 *  *farthest to how far. */
void pl_mids_write(const pl_mids *mids, int writes, double *coordinates, int64_t *moved,
                   double *farthest);

/** Find the curved elements of plan, if its mesh has elements of order 2; arguments as for
 *  pl_mids_create. *curved is to be destroyed in any case. Errors: _MESH (a mid that is not finite),
 *  _MEMORY. */
int pl_watch_create(const planish_plan *plan, const planish_options *options, const double *given,
                    const double *start, pl_watch *curved, planish_error *error);

/** Watch n more elements of order 2, whose mids move by themselves; they are to be measured. n_curved
 *  stays. Without memory nothing may be done with the watch but to destroy it. Errors: _MEMORY. */
int pl_watch_add(pl_watch *curved, int64_t n, const int32_t *element, planish_error *error);

/** Free the arrays of curved. */
void pl_watch_destroy(pl_watch *curved);

/** Decide all curved elements at the plan's present coordinates; returns how many are invalid with
 *  positive corners. */
int64_t pl_watch_measure(pl_watch *curved);

/** Whether curved elements are at the node of this inner number. */
static inline int pl_watch_has(const pl_watch *c, int32_t node) {
    return c->begin[node + 1] > c->begin[node];
}

/** Whether the curved elements at a node that has moved by way [dim] may be as they are: none of
 *  those that were valid is invalid now. If not, the node is to go back. */
int pl_watch_admit(pl_watch *curved, int32_t node, const double *way);

/** Mark in state [n_elements of the plan] with 1 the elements of order 2 that were valid when the run
 *  began and are not any more, and if of_all all elements whose corners have turned; leave the other
 *  entries. Returns their number. */
int64_t pl_watch_find_broken(const pl_watch *curved, int of_all, uint8_t *state);

#endif
