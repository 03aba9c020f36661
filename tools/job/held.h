/* held: why nodes do not move: the reasons of the plan, the file and the options, put together.
 *
 *     pl_held_name, _text                 a reason in JSON, and in words
 *     pl_held_count, _find                the reasons of a mesh
 *     pl_held_print, _explain, _note      texts on them
 *     pl_held_find_in_run, _name_in_run, _text_in_run    movable nodes that smoothing holds
 */
#ifndef PL_TOOLS_HELD_H
#define PL_TOOLS_HELD_H

#include "job/job.h"

#include <stdio.h>

/** The name of a reason in reports: pl_held.n is in this order. */
const char *pl_held_name(int reason);

/** Text for a number of nodes held for a reason: "on the boundary". */
const char *pl_held_text(int reason);

/** Count the held nodes by reason, if somebody is going to be told: in the log, a report, or
 * because nothing can move. There is a plan. Returns 0, or an exit status after a message. */
int pl_held_count(pl_job *job);

/** All reasons of each node, as bits 1 << pl_hold_cause; bits [n_nodes] is to be freed, and NULL if
 *  they are not known. Returns as pl_held_count. */
int pl_held_find(const pl_job *job, uint16_t **bits);

/** Print how many nodes are held, and why: for -v. */
void pl_held_print(FILE *stream, const pl_job *job);

/** Fill text [size] with the reasons why no node can move, and how to change that. */
void pl_held_explain(const pl_job *job, char *text, size_t size);

/** Find the movable nodes that smoothing holds, if their elements are going to be listed and bounds or a
 *  shape may hold any: job->held_in_run. There is a plan. Returns as pl_held_count. */
int pl_held_find_in_run(pl_job *job);

/** The name of a reason in JSON; NULL for PLANISH_HELD_BY_NONE. */
const char *pl_held_name_in_run(planish_held_by reason);

/** Text on an element whose movable nodes are held for the reason of that name: "held near another
 *  sheet". */
const char *pl_held_text_in_run(const char *name);

/** Note on stream that no node can move, and why; nothing if one can. */
void pl_held_note(FILE *stream, const pl_job *job);

#endif
