/* picture: what a page draws of a mesh: its surface (in 2-D: its elements) and its worst elements,
 * in one or two states, as data for the viewer.
 *
 * A surface of many triangles is drawn coarsely, so that a page stays small whatever the mesh:
 * nodes that lie in one cell of a grid become one.
 *
 *     pl_picture_begin, _take, _free           a mesh, and its states
 *     pl_picture_fits, _n_states, _count       questions about it
 *     pl_picture_put, _put_still               the data for viewer/; a picture without it
 */
#ifndef PL_REPORT_PICTURE_H
#define PL_REPORT_PICTURE_H

#include "job/job.h"
#include "report/markup.h"

typedef struct pl_picture pl_picture;

/** Begin a picture of the mesh of job (which has a plan, or job->has_types): find what is to be
 *  drawn of it, and its place. To be released by pl_picture_free, also after a failure. Returns 0,
 *  or an exit status after a message. */
int pl_picture_begin(const pl_job *job, pl_picture **picture);

/** Whether the mesh of job has the elements of the first one, by their number. */
int pl_picture_fits(const pl_picture *picture, const pl_job *job);

/** Take the state that the mesh of job, of the same elements as the first one, is in now; but not
 * of a mesh whose size overflows. name: a word for it, kept as it is ("before"). */
int pl_picture_take(pl_picture *picture, const pl_job *job, const char *name);

/** Whether features of the surface are drawn: patches, curves and corners. */
int pl_picture_has_features(const pl_picture *picture);

/** Return of how many solid elements one is drawn inside: 1: all are; 0: there are none. */
int64_t pl_picture_stride(const pl_picture *picture);

/** How many states the picture, which may be NULL, shows, and their names. */
int pl_picture_n_states(const pl_picture *picture);
const char *pl_picture_state_name(const pl_picture *picture, int i);

/** How many states between these the picture shows, of *n_sweeps sweeps (history.h). */
int pl_picture_n_steps(const pl_picture *picture, int *n_sweeps);

/** Add what the viewer draws, as JSON. */
void pl_picture_put(pl_markup *page, const pl_picture *picture);

/** Add state i as a still picture under a title. wraps: elements wrap around the mesh, which is periodic. */
void pl_picture_put_still(pl_markup *page, const pl_picture *picture, int i, int wraps,
                          const char *title);

/** Triangles of the surface, and of these how many are drawn. */
void pl_picture_count(const pl_picture *picture, int64_t *n_all, int64_t *n_drawn);

void pl_picture_free(pl_picture *picture);

#endif
