/* onto: the surface of the mesh is fitted to that of another file, --onto FILE.
 *
 *     pl_onto_fit                      read FILE, find places, move nodes
 *     pl_onto_measure                  distances, proved
 *     pl_onto_note                     what is odd about it
 *
 * Functions that return an int return 0, or an exit status after a message.
 */
#ifndef PL_TOOLS_ONTO_H
#define PL_TOOLS_ONTO_H

#include "job/job.h"

#include <stdio.h>

/** Move the nodes of the boundary, in the file's coordinates, if that is asked for. From then on the mesh is
 *  the one that is smoothed, and constraint says how. A signal that asks to stop ends the moves. */
int pl_onto_fit(pl_job *job);

/** Measure how far the surfaces are apart in the end, and take the time. */
int pl_onto_measure(pl_job *job);

/** Note which nodes have no place or are held, and whether the fit made elements worse: worst is the worst
 *  ratio since. */
void pl_onto_note(FILE *stream, const pl_job *job, double worst);

#endif
