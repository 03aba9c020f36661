/* held: why nodes do not move: the reasons of the plan, the file and the options, put together.
 *
 *     pl_held_name, _text                 a reason in JSON, and in words
 *     pl_held_count, _find                the reasons of a mesh
 *     pl_held_print, _explain, _note      texts on them
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

/** All reasons of each node, as bits 1 << pl_held_by; bits [n_nodes] is to be freed, and NULL if
 *  they are not known. Returns as pl_held_count. */
int pl_held_find(const pl_job *job, uint16_t **bits);

/** Print how many nodes are held, and why: for -v. */
void pl_held_print(FILE *stream, const pl_job *job);

/** Fill text [size] with the reasons why no node can move, and how to change that. */
void pl_held_explain(const pl_job *job, char *text, size_t size);

/** Note on stream that no node can move, and why; nothing if one can. */
void pl_held_note(FILE *stream, const pl_job *job);

#endif
