/* picture_take: the mesh as it is, for a picture of it.
 *
 *     pl_picture_take_whole, _brief     take a state, or less of it
 *     pl_picture_brief_bad              how many bad elements that has
 */
#ifndef PL_REPORT_PICTURE_TAKE_H
#define PL_REPORT_PICTURE_TAKE_H

#include "report/picture_state.h"

/** Take the mesh of job as it is now, for a picture of it that has begun. state, which is to be freed also after
 *  a failure, is all 0 but for its name. Returns 0, or an exit status after a message. */
int pl_picture_take_whole(const pl_picture *picture, const pl_job *job, pl_drawn_state *state);

/** Take less, for one of many states: where all solid elements are drawn inside, they are without bad ones
 *  apart; else there are fewer bad elements, nothing inside, and no cubes. As pl_picture_take_whole. */
int pl_picture_take_brief(const pl_picture *picture, const pl_job *job, pl_drawn_state *state);

/** Return how many bad elements pl_picture_take_brief takes; 0: all elements. */
int64_t pl_picture_brief_bad(const pl_picture *picture);

#endif
