/* laplacian: methods that move a node to an average of its surroundings. */
#ifndef PL_STAR_LAPLACIAN_H
#define PL_STAR_LAPLACIAN_H

#include "star/star.h"

/** Move the nodes of the changed ones of stars begin .. end-1 by a method of averages
 * (laplacian.c): to the mean that it says, whatever becomes of the elements. Adds to *tally. */
void pl_star_average(const pl_star_problem *problem, planish_method method, int dim, int64_t begin,
                     int64_t end, double *scratch, pl_star_tally *tally);

#endif
