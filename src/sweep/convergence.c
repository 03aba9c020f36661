/* convergence: when further sweeps are not worth their time. */
#include "sweep/sweep.h"

#include <math.h>

/* What is still to come, by extrapolation, must be below this fraction of the RMS. */
#define REMAINDER 0.01

double pl_remainder(const pl_convergence *convergence) {
    double first = convergence->fall[0], last = convergence->fall[PL_CALM_SWEEPS - 1];
    if (!(last > 0))
        return 0;
    if (!(first > last))
        return INFINITY;
    double ratio = sqrt(last / first);
    return last * ratio / (1 - ratio);
}

int pl_converged(pl_convergence *convergence, double before, double after, double tolerance) {
    for (int i = 1; i < PL_CALM_SWEEPS; i++)
        convergence->fall[i - 1] = convergence->fall[i];
    convergence->fall[PL_CALM_SWEEPS - 1] = before > 0 ? (before - after) / before : 0;
    if (++convergence->n_falls < PL_CALM_SWEEPS)
        return 0;
    for (int i = 0; i < PL_CALM_SWEEPS; i++)
        if (convergence->fall[i] > tolerance)
            return 0;
    return pl_remainder(convergence) < REMAINDER;
}
