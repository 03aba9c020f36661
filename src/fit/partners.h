/* partners: which piece of the other shape is for which of the mesh's surface. */
#ifndef PL_FIT_PARTNERS_H
#define PL_FIT_PARTNERS_H

#include "fit/fit.h"

/** Find the pieces of the mesh's surface, all without partners, and the sides of the other ones, whose turns are known.
 *  Errors: _MEMORY. */
int pl_fit_begin_partners(planish_fit *fit, planish_error *error);

/** Find the partners of the mesh's pieces by the places of nodes: a piece of which one has most. Errors: _MEMORY. */
int pl_fit_find_partners(planish_fit *fit, planish_error *error);

/** Return the piece of a node, plus 1; 0: it has none. */
int32_t pl_fit_piece_of(const planish_fit *fit, int32_t node);

/** Whether a node of a piece, as pl_fit_piece_of says, may have a place on a piece of the other shape: others' partners
 *  are not for it, nor is what is nested with its own partner, nor are hollows for the outside of a body. */
int pl_fit_may_use(const planish_fit *fit, int32_t own, int32_t piece);

/** Whether a node has a place on a piece that is not for it. */
int pl_fit_has_strays(const planish_fit *fit);

/** Hold the nodes of pieces that would cover the same partner, and count the pieces that no node has a place on. */
void pl_fit_hold_doubled(planish_fit *fit);

#endif
