/* watch_late: watched cells that wait for the end of a sweep to be decided.
 *
 *   pl_watch_begin_sweep, _end_sweep    find and decide them
 *   pl_watch_note_move                  a move that may have to be undone
 */
#ifndef PL_SWEEP_WATCH_LATE_H
#define PL_SWEEP_WATCH_LATE_H

#include "sweep/watch.h"

/** Begin a sweep. If cells may wait, those of order 1 that are valid and never refused a move are
 *  decided at its end: late.is_on then, unless too many are not such. */
void pl_watch_begin_sweep(pl_watch *watch, int may_wait);

/** Note the move of a star's node, of inner number node, by way from before [dim]; 0: it is there. While
 *  cells wait only. */
void pl_watch_note_move(pl_watch *watch, int64_t star, int32_t node, const double *before,
                        double way, const pl_star_gain *gain);

/** Decide the cells that wait. If a cell is no longer valid, the last move of its nodes is undone.
 *  So are all later moves of nodes that share an element with a node that went back. So the mesh is
 *  as if the undone visits had not been, and the function of the sweep has not risen. problem: of
 *  the sweep's stars, which are n_stars. What undone moves brought is taken from *tally. */
void pl_watch_end_sweep(pl_watch *watch, const pl_star_problem *problem, int64_t n_stars,
                        pl_star_tally *tally);

#endif
