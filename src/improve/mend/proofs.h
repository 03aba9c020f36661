/* proofs: which invalid curved simplices stay so wherever their free nodes go.
 *
 * Values of det J at points, which are affine in the way of one node, are rows of a linear program.
 * Where rows contradict each other (Farkas' lemma), no place of the node makes their elements valid.
 * Coefficients prove nothing: one may be negative in a valid element.
 */
#ifndef PL_IMPROVE_MEND_PROOFS_H
#define PL_IMPROVE_MEND_PROOFS_H

#include "improve/mend/elements.h"

/** Give up the elements that are proved to be invalid wherever free nodes go. *n: how many; *first (if
 *  there are any): the first of them. Errors: _MEMORY. */
int pl_mend_prove(pl_mend *c, int64_t *n, int64_t *first, planish_error *error);

#endif
