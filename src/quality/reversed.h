/* reversed: elements whose numbering is opposite to that of most elements, by exact signs.
 *
 *   pl_count_reversed     how many there are
 *   pl_find_reversed      which they are
 */
#ifndef PL_QUALITY_REVERSED_H
#define PL_QUALITY_REVERSED_H

#include "quality/view.h"

/** Number of elements that do not have the sign of most; in a tie most are positive. */
static inline int64_t pl_count_reversed(int64_t n_positive, int64_t n_negative) {
    return n_positive >= n_negative ? n_negative : n_positive;
}

/** Find the elements whose measure in the listed order of their nodes has the other sign than most
 *  elements' of the whole mesh: reversed [m] becomes 0 or 1. Return their number in the whole mesh.
 *  coordinates [n][dim]. */
int64_t pl_find_reversed(const pl_view *view, const double *coordinates, int threads,
                         uint8_t *reversed);

#endif
