/* surface_write: the triangles and quadrilaterals of a mesh as a file of a format of surfaces. */
#ifndef PL_IO_VIEW_SURFACE_WRITE_H
#define PL_IO_VIEW_SURFACE_WRITE_H

#include "io/core/format.h"

/** STL, text, in which each set of a group or region is a solid; Wavefront OBJ; PLY, binary. */
extern const io_target stl_targets[], obj_targets[], ply_targets[];

/** Fail if the mesh has no facets, which alone these formats hold. */
int io_surface_check(const io_model *model, planish_error *error);

#endif
