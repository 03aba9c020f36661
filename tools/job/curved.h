/* curved: curved surfaces: the shape that nodes slide on, how far the surface is off it, and volumes.
 *
 *     pl_curved_is_surface, _begin_surface  a mesh that is a surface in space
 *     pl_curved_hold                        nodes of it that --slide leaves alone
 *     pl_curved_is_asked                    whether nodes slide on curved surfaces
 *     pl_curved_create, _try, _destroy            the shape
 *     pl_curved_count                       nodes that slide, by kinds
 *     pl_curved_measure                     distances, both ways
 *     pl_volumes_of_regions                 volume of each region
 *     pl_curved_note_held, _note_result     what stays, and what is odd about the result
 *
 * Functions that return an int return 0, or an exit status after a message.
 */
#ifndef PL_TOOLS_CURVED_H
#define PL_TOOLS_CURVED_H

#include "job/job_state.h"

#include <stdio.h>

/** Volumes of the regions of a mesh in space, before and after. */
typedef struct pl_region_volume {
    int64_t element; /* one of the region */
    double before, after;
} pl_region_volume;

/** State of the surface beside its shape. */
typedef struct pl_surface_state {
    int is_known;                         /* 0: no shape was asked for, and nothing else is set */
    planish_shape_distance before, after; /* before: of the input, which may be another one than the
                                                shape's mesh */
    pl_region_volume *region;             /* [n_regions] owned */
    int64_t n_regions;
} pl_surface_state;

/** Whether mesh, as planish_file_mesh says, is a surface in space: triangles and quadrilaterals that lie
 *  in no plane. */
int pl_curved_is_surface(const planish_mesh *mesh);

/** Begin the job of one: its arguments are from now on what they mean there, its engine is that of
 *  surfaces. Returns 0, or an exit status after a message: an option is not for surfaces. */
int pl_curved_begin_surface(pl_job *job);

/** Fix the nodes of a surface in space that are on lines and curves if --slide none was given, and those of
 *  elements of order 2, once constraint says what slides. */
void pl_curved_hold(pl_job *job);

/** Whether nodes slide on curved surfaces. */
int pl_curved_is_asked(const pl_job *job);

/** Make job->curved.shape of the mesh, or of the one of --surface-of, if it is not there. */
int pl_curved_create(pl_job *job);

/** Make it of the mesh if that is possible: for a picture. */
void pl_curved_try(pl_job *job);

/** Free it. */
void pl_curved_destroy(pl_job *job);

/** Count the nodes that slide by kinds, once constraint [n_nodes] says which do. */
void pl_curved_count(pl_job *job);

/** Measure how far the surface of the mesh, as it is now, is off the shape. */
int pl_curved_measure(const pl_job *job, planish_shape_distance *distance);

/** Add up the volumes of regions as the mesh is now: before, and in a second call, with has_before, after.
 *  state->region is made by the first. */
int pl_volumes_of_regions(const pl_job *job, int has_before, pl_surface_state *state);

/** Release what state owns. */
void pl_surface_state_free(pl_surface_state *state);

/** Note what stays although it is curved, and why: a line for each reason that the mesh has. */
void pl_curved_note_held(FILE *stream, const pl_job *job, int64_t n_curved, int64_t n_inverted);

/** Note what is odd about the surface of the result. */
void pl_curved_note_result(FILE *stream, const pl_job *job, const pl_surface_state *state);

#endif
