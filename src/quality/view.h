/* view: a mesh as all measures, and the sweeps, see it.
 *
 * pl_view has pointers alone and owns nothing; coordinates are given beside it. Where a field is
 * NULL the comment says what holds then.
 *
 *   pl_any_moves                 whether an element is movable
 *   pl_view_of_all_elements      a view of what other processes count, too
 */
#ifndef PL_QUALITY_VIEW_H
#define PL_QUALITY_VIEW_H

#include "geometry/target.h"

#include <planish/planish.h>

/** Value of is_movable: another process counts the element. */
enum { PL_ELSEWHERE = 2 };

/** A mesh of n nodes and m elements. */
typedef struct pl_view {
    int dim;
    int64_t n_nodes, n_elements;
    const int32_t *elements; /* [m][dim + 1] nodes */
    const uint8_t *corner; /* [m] the elements are corners (geometry/corner.h), those of a cell one
                                 after the other; NULL: they are simplices, one of each cell */
    int64_t n_cells;       /* with corner: number of cells, */
    const int32_t *cell_begin; /* [n_cells + 1] and the first corner of each */
    const pl_target *target;   /* [m] with corner: their targets (geometry/target.h); NULL: they are
                                  the ideal ones of their shapes */
    const pl_metric *metric;   /* [m] then: in which they are to be that (geometry/metric.h); NULL:
                                  lengths are the usual ones */
    double size_weight;        /* then: of sizes against shapes, 0 .. 1 */
    const int8_t *sign;       /* [m] +1 or -1: sign * measure is positive in a valid mesh; NULL: all
                                 +1 */
    const double *min_volume; /* [m] minimum volumes, 0: none; NULL: all 0 */
    const uint8_t *mobility;  /* [n] not 0: the node may move */
    const uint8_t
        *is_movable; /* [m] 1: the element has a movable node; 0: it has none; PL_ELSEWHERE;
                                  NULL: mobility says it */
    const uint8_t *is_counted; /* [m] 0: another process counts the element; NULL: all 1 */
} pl_view;

/** Whether one of the nodes node [corners] of an element may move; mobility: as in pl_view. */
PL_INLINE int pl_any_moves(const uint8_t *mobility, const int32_t *node, const int corners) {
    int any = 0;
    for (int j = 0; j < corners; j++)
        any |= mobility[node[j]];
    return any != 0;
}

/** Number of cells: of the elements, or if elements are corners, of the cells that have these corners. */
static inline int64_t pl_view_cells(const pl_view *view) {
    return view->corner ? view->n_cells : view->n_elements;
}

/** First element of a cell; its last one is before that of the next cell. */
static inline int64_t pl_first_of_cell(const pl_view *view, int64_t cell) {
    return view->corner ? view->cell_begin[cell] : cell;
}

/** Return the view without is_movable: all elements are looked at, also those that other processes
 *  count. */
static inline pl_view pl_view_of_all_elements(const pl_view *view) {
    pl_view v = *view;
    v.is_movable = NULL;
    return v;
}

#endif
