/* rounds: the sweeps, which begin again with nodes of layers held where heights have changed by much. */
#ifndef PL_TOOLS_ROUNDS_H
#define PL_TOOLS_ROUNDS_H

#include "report/history.h"
#include "report/result.h"

/** Listeners to the sweeps. */
typedef struct pl_listeners {
    pl_progress *progress;
    pl_history *history; /* or NULL */
} pl_listeners;

/** Smooth. Where kept layers change their heights by much, their nodes are held, and it begins again; in the
 *  end all nodes of layers. Nodes that inverted elements need are let go again: no more of these are left than
 *  by the first round. The time limit or a signal may end the rounds; rounds.c says which result stands then.
 *  Returns 0, or an exit status after a message. */
int pl_rounds_smooth(pl_job *job, pl_result *result, pl_listeners *to);

#endif
