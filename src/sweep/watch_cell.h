/* watch_cell: cells of a watch, decided in blocks of one type; internal to the watch.
 *
 *   pl_watch_rule_make                    the rule of a type
 *   pl_watch_take, _evaluate, _is_lane_valid    a block of cells
 *   pl_watch_keep_state                   what a block tells of a cell: its state, and its room
 *   pl_watch_find_places, _room, _longest, _sign    of one cell
 *   pl_plan_given_cell, _cell_type, pl_linear_type    cells of a plan and their types
 */
#ifndef PL_SWEEP_WATCH_CELL_H
#define PL_SWEEP_WATCH_CELL_H

#include "quality/bends.h"
#include "sweep/watch.h"

/** Cells of one type whose validity is asked for, one per lane. */
typedef struct pl_watch_block {
    const pl_watch_rule *rule; /* with n above 0 */
    int n;
    int32_t of[PL_JACOBIAN_LANES];                  /* watched cells; or what the caller likes */
    double x[PL_JACOBIAN_LANES][PL_CELL_NODES * 3]; /* [n_nodes][dim] */
    int32_t node[PL_JACOBIAN_LANES][PL_CELL_NODES]; /* places in x; -1: a missing mid */
    double sign[PL_JACOBIAN_LANES];
    int exponent[PL_JACOBIAN_LANES]; /* of the scale */
    pl_jacobian_block jacobian;
} pl_watch_block;

/** Return the caller's number of a cell of a plan. */
int64_t pl_plan_given_cell(const planish_plan *plan, int64_t cell);

/** Return the type of a cell of a plan. */
const pl_cell_type *pl_plan_cell_type(const planish_plan *plan, int64_t cell);

/** Return the linear type of a shape. */
const pl_cell_type *pl_linear_type(const pl_cell_shape *shape);

/** Return the sign of a cell, by which its det J is multiplied. */
double pl_watch_sign(const pl_watch *w, int64_t cell);

/** Make the rule of a type, to be freed by pl_free; NULL: there is no memory. */
pl_watch_rule *pl_watch_rule_make(const pl_cell_type *type);

/** Add a cell of the plan to the block, which has a free lane and no cells of other rules, as it is or
 *  (at_start) was when the run began; at_start 1: but for what mids have moved by themselves, 2: as it
 *  was given. */
void pl_watch_take(const pl_watch *w, const pl_watch_rule *rule, int64_t cell, int at_start,
                   pl_watch_block *b);

/** Evaluate the block. Lanes past the last cell repeat the first. */
void pl_watch_evaluate(const pl_watch *w, pl_watch_block *b);

/** Whether the cell in lane l of a block that has been evaluated is valid. */
int pl_watch_is_lane_valid(const pl_watch_block *b, int l);

/** Find the places of the nodes of a cell that a rule looks at, as they are or (at_start, as of
 *  pl_watch_take) were when the run began: x [n_nodes][dim]. node: see pl_watch_block. */
void pl_watch_find_places(const pl_watch *w, const pl_jacobian_rule *rule, int64_t cell,
                          int at_start, double *x, int32_t *node);

/** Return how far nodes of a cell may go. least: smallest excess of its coefficients over their
 *  limits; longest: largest derivative; 0: nowhere. */
double pl_watch_room(const pl_watch *w, const pl_watch_rule *rule, double least, double longest);

/** Return the longest derivative of lane l along any edge. */
double pl_watch_longest(const pl_jacobian_rule *rule, const pl_watch_block *b, int l, int dim);

/** Keep the state and the room of the watched cell b->of[l], which is in lane l and valid or not.
 *  Bounds decide nothing for a cell that was scaled, or that bisections have decided: it has no room. */
void pl_watch_keep_state(pl_watch *w, const pl_watch_block *b, int l, int valid);

#endif
