/* bar: one line on the terminal: what is done, how much of the whole, and how long it will take. */
#ifndef PL_TOOLS_BAR_H
#define PL_TOOLS_BAR_H

#include "job/progress.h"

/** Show that phase begins. */
void pl_bar_phase(pl_progress *progress, pl_phase phase);

/** Show how far the sweeps are; now and then, as more often is not seen. */
void pl_bar_step(pl_progress *progress, const planish_progress *step);

#endif
