/* elements: the elements at each node of a mesh with curved simplices, and which nodes may move.
 *
 *   pl_mend_create, _destroy      the view of the mesh
 *   pl_mend_nodes, _place ...     nodes of an element, as the caller numbers them
 *   pl_mend_kind_of               what a node may do
 *   pl_mend_watched, _decide ...  which elements are invalid, and how good one is
 */
#ifndef PL_IMPROVE_MEND_ELEMENTS_H
#define PL_IMPROVE_MEND_ELEMENTS_H

#include "sweep/rows.h"
#include "sweep/run.h"

enum { PL_MEND_NODES = 10 /* most nodes of a simplex of order 2 */ };

/** Roles of a node of the mesh: it does not move, slides, or moves freely as a mid or a corner. */
typedef enum pl_mend_kind {
    PL_MEND_UNKNOWN = 0,
    PL_MEND_HELD,
    PL_MEND_SLIDES,
    PL_MEND_MID,
    PL_MEND_CORNER
} pl_mend_kind;

/** Mesh with curved simplices, at the plan's present coordinates. Arrays are owned; the caller sets
 *  the pointers in front of dim and limit. */
typedef struct pl_mend {
    pl_run *run; /* that moves nodes; NULL: none does, proofs alone are wanted */
    const planish_plan *plan;
    const planish_options *options;
    pl_watch *watch;
    const uint8_t *mobility; /* [n of the plan] */
    pl_stop_check *limit;
    int dim;
    int64_t *begin;       /* [nodes of the mesh + 1] where the elements of each begin */
    int32_t *at;          /* elements of the plan */
    uint8_t *kind;        /* [nodes of the mesh] pl_mend_kind, found when it is asked for */
    uint8_t *is_outside;  /* [nodes of the mesh] of an element that the plan lacks; NULL: none is */
    uint8_t *is_given_up; /* [elements of the plan] */
    pl_row_rule *rule[2]; /* of order 1 and 2 */
    int lacks_memory;     /* the work is to end */
} pl_mend;

/** Make c, whose first pointers are set. To be destroyed in any case. Errors: _MEMORY. */
int pl_mend_create(pl_mend *c, planish_error *error);

/** Free the arrays of c. */
void pl_mend_destroy(pl_mend *c);

/** Order of an element: 1 or 2. */
int pl_mend_order(const pl_mend *c, int64_t element);

/** Whether an element is a simplex. */
int pl_mend_is_simplex(const pl_mend *c, int64_t element);

/** The caller's nodes of an element, -1 for a missing mid; *n of them. */
const int32_t *pl_mend_nodes(const pl_mend *c, int64_t element, int *n);

/** Node of the plan that is corner i of an element. */
int32_t pl_mend_corner(const pl_mend *c, int64_t element, int i);

/** Sign of det J in a valid element: +1 or -1. */
double pl_mend_sign(const pl_mend *c, int64_t element);

/** Place of a node in an element. */
int pl_mend_place(const pl_mend *c, int64_t element, int32_t node);

/** Places in the first element of a mid of the two ends of its edge. */
const uint8_t *pl_mend_ends(const pl_mend *c, int32_t mid);

/** Kind of a node; -1 (a missing mid) is held. */
pl_mend_kind pl_mend_kind_of(pl_mend *c, int32_t node);

/** Watched cell i as an element, if it is a simplex of order 2 that is not given up; else -1. */
int64_t pl_mend_watched(const pl_mend *c, int64_t i);

/** Watched cell i as pl_mend_watched, if it was invalid when it was measured last; else -1. */
int64_t pl_mend_watched_invalid(const pl_mend *c, int64_t i);

/** Decide whether an element is valid. */
pl_validity pl_mend_decide(const pl_mend *c, int64_t element);

/** Return the least coefficient of an element over their mean; -INFINITY: the mean is not positive. */
double pl_mend_quality(const pl_mend *c, int64_t element);

#endif
