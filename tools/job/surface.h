/* surface: texts on a mesh that is a surface in space; curved.h and engine.h have the work.
 *
 *     pl_surface_print     whether it is closed, and its features
 *     pl_surface_note      what is odd about it
 */
#ifndef PL_TOOLS_SURFACE_H
#define PL_TOOLS_SURFACE_H

#include "job/job.h"

#include <stdio.h>

/** Print whether the surface is closed, and its features; the shape is there. */
void pl_surface_print(FILE *stream, const pl_job *job);

/** Note what is odd about it. */
void pl_surface_note(FILE *stream, const pl_job *job);

#endif
