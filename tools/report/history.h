/* history: states of a mesh while it is smoothed, for the picture of a page.
 *
 * How many sweeps there are going to be is not known. So a state is taken after every sweep at first, and
 * where there are too many every second one is forgotten, and taken from then on. In the end those that are
 * wanted are chosen evenly.
 *
 *     pl_history_begin, _free   before the sweeps
 *     pl_history_take           after each of them, in the progress function
 *     pl_history_end            hand the states to the picture
 */
#ifndef PL_REPORT_HISTORY_H
#define PL_REPORT_HISTORY_H

#include "report/picture.h"

typedef struct pl_history pl_history;

/** Begin the history that the arguments of job ask for, of the mesh of picture, as it is before the sweeps;
 *  job has a plan. *history is NULL if none is asked for or picture is NULL; to be freed also after a failure.
 *  picture must live as long. Returns 0, or an exit status after a message. */
int pl_history_begin(const pl_job *job, const pl_picture *picture, pl_history **history);

/** Take the mesh after a sweep, where progress is the last call of one. history may be NULL. After a failure,
 *  and a message, nothing more is taken. */
void pl_history_take(pl_history *history, const planish_progress *progress);

/** Hand the states to the picture, which has the mesh before and after. Keep no more than were asked for, those
 *  two included, and than a page has room for. Returns 0, or the exit status of what failed. history may be
 *  NULL. */
int pl_history_end(pl_history *history, pl_picture *picture, const planish_result *result);

void pl_history_free(pl_history *history);

#endif
