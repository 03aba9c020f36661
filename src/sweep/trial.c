/* trial: change the mesh, and take the change or undo it. */
#include "sweep/trial.h"

#include <string.h>

static size_t size_of_coordinates(const pl_run *r) {
    return (size_t)r->plan->work.n_nodes * (size_t)r->plan->dim * sizeof *r->plan->coordinates;
}

void pl_trial_begin(pl_run *r, double *before, pl_trial *trial) {
    *trial = (pl_trial){.run = r, .standing = r->worth, .before = before};
    memcpy(before, r->plan->coordinates, size_of_coordinates(r));
    r->shown = &trial->standing;
}

void pl_trial_end(const pl_trial *trial, int is_taken) {
    pl_run *r = trial->run;
    r->shown = NULL;
    if (is_taken)
        return;
    memcpy(r->plan->coordinates, trial->before, size_of_coordinates(r));
    pl_run_measure(r);
}
