/* cell_measure: the quality of elements of every type.
 *
 * pl_measure (measure.h) measures simplices alone, by their radius ratio. This file measures all
 * types, by their common properties: validity everywhere (validity.h) and the corner mean ratio
 * (docs/measures.md). Elements are taken in blocks of one type.
 *
 *   pl_cell_rules_make, _free    rules of the types that a mesh has
 *   pl_measure_cells             sums over all elements, and what each one is
 */
#ifndef PL_QUALITY_CELL_MEASURE_H
#define PL_QUALITY_CELL_MEASURE_H

#include "geometry/target.h"
#include "quality/validity.h"

#include <planish/planish.h>

/** Make the target of corner c of a cell, and its metric where the mesh has those; returns as
 *  pl_target_make. targets: of pl_cell_mesh. */
typedef int pl_cell_target_fn(const void *targets, int64_t cell, int c, pl_target *target,
                              pl_metric *metric);

/** Elements of any types, as planish_mesh has them, and where their nodes are. */
typedef struct pl_cell_mesh {
    int dim; /* of the elements that count; others are passed over */
    const planish_cells *cells;
    const double *coordinates; /* [n_nodes][dim] */
    const int8_t *sign;        /* [n] +1 or -1: det J times that is positive in a valid mesh */
    double rounding;           /* of coordinates: mids that are no farther off are straight */
    pl_cell_target_fn *target; /* of corners, or NULL: they are to be the ideal ones */
    const void *targets;       /* for target */
    int has_metric;            /* 1: target makes metrics, too */
} pl_cell_mesh;

/** Rules of the types of a mesh that count. */
typedef struct pl_cell_rules {
    int n;
    pl_jacobian_rule *rule[PLANISH_N_CELL_TYPES]; /* [n] by ascending numbers of types */
    int8_t index[UINT8_MAX + 1];                  /* of a type's rule, -1: it does not count */
} pl_cell_rules;

/** Make the rules of the types of mesh. Returns PLANISH_OK or PLANISH_ERROR_MEMORY; rules is to be
 *  freed in either case. */
int pl_cell_rules_make(const pl_cell_mesh *mesh, pl_cell_rules *rules);

/** Free the rules. */
void pl_cell_rules_free(pl_cell_rules *rules);

/** Measure mesh; values (may be NULL) are filled. Returns PLANISH_OK, PLANISH_ERROR_MEMORY, or
 *  PLANISH_ERROR_MESH if corners have no target: *flawed is then the lowest such element. */
int pl_measure_cells(const pl_cell_mesh *mesh, const pl_cell_rules *rules, int threads,
                     planish_cell_quality *quality, const planish_cell_values *values,
                     int64_t *flawed);

#endif
