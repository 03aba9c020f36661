/* measured: what the command quality finds of a mesh. */
#ifndef PL_REPORT_MEASURED_H
#define PL_REPORT_MEASURED_H

#include "job/cells.h"
#include "job/curved.h"
#include "job/heights.h"
#include "job/job.h"
#include "job/states.h"
#include "job/worst.h"

/** Findings of the command quality on a mesh. */
typedef struct pl_measured {
    planish_quality quality; /* of the straight simplices */
    pl_cells cells;          /* where there are others: of all elements */
    pl_volumes volumes;
    uint8_t *reversed; /* [mesh.n_elements] as of pl_reversed_find, owned, or NULL */
    pl_worst worst;
    pl_surface_state surface;
    pl_heights heights; /* of layers */
} pl_measured;

#endif
