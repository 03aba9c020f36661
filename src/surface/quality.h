/* quality: all measures of a surface mesh.
 *
 *   pl_surface_quality the figures of planish_measure_surface
 */
#ifndef PL_SURFACE_QUALITY_H
#define PL_SURFACE_QUALITY_H

#include "shape/curved.h"
#include "topology/points.h"

/** A surface that is measured, and where to; ratio, cells and values may be NULL
 *  (planish_measure_surface). */
typedef struct pl_surface_measuring {
    const planish_shape *shape;
    const planish_mesh *mesh;
    const pl_points *points; /* its nodes */
    planish_quality *quality;
    double *ratio;
    planish_cell_quality *cells;
    const planish_cell_values *values;
} pl_surface_measuring;

/** Measure. Errors: _ARGUMENT (the shape is that of other elements), _MEMORY. */
int pl_surface_quality(const pl_surface_measuring *measuring, int threads, planish_error *error);

#endif
