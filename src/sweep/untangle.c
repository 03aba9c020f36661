/* untangle: the ladder from gentle to strong that makes tangled meshes valid (docs/algorithm.md).
 */
#include "sweep/tangle.h"

#include "base/memory.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/** One rung: what is done about the elements that are still tangled. */
typedef struct measures {
    int layers; /* of elements around the tangled ones, whose nodes may move too */
    int centre; /* first to the mean of the neighbours */
    int sweeps; /* of the regularised energy, at most */
    int solve;  /* the patch as one problem */
} measures;

static const measures LADDER[] = {
    {1, 1, 2, 0}, {2, 0, 20, 0}, {4, 1, 10, 1}, {16, 1, 10, 1}, {100000, 1, 10, 1}};
enum { N_RUNGS = sizeof LADDER / sizeof *LADDER };

#define EPSILON_LEAST 1e-9

double pl_first_epsilon(double least) {
    return fmax(0.02, fmin(1, -0.4 * least));
}

double pl_next_epsilon(double epsilon, double before, double after, double least) {
    double fall = fmax(1 - after / before, 0.1);
    if (least >= 0)
        epsilon *= 1 - fall;
    else {
        double s = sqrt(least * least + epsilon * epsilon);
        epsilon *= 1 - fall * s / (fabs(least) + s);
    }
    return fmax(epsilon, EPSILON_LEAST);
}

static int sweep(pl_tangle *t) {
    pl_run *r = t->run;
    pl_run_begin_sweep(r);
    const pl_sweep_tally tally =
        pl_sweep(r->plan, &t->problem, PLANISH_METHOD_PLANISH, pl_run_after_colour, r);
    pl_run_measure(r);
    return pl_run_end_sweep(r, &tally);
}

static int sweeps(pl_tangle *t, int most) {
    t->asked.epsilon = 1;
    pl_tangle_measure(t);
    t->asked.epsilon = pl_first_epsilon(t->energy.least);
    pl_tangle_measure(t);
    for (int i = 0; i < most && t->energy.tangled > 0; i++) {
        double before = t->energy.sum;
        if (sweep(t))
            return 1;
        pl_tangle_measure(t);
        if (getenv("PL_DEBUG"))
            fprintf(stderr, "  sweep %d eps %g E %g -> %g least %g tangled %g\n", i,
                    t->asked.epsilon, before, t->energy.sum, t->energy.least,
                    (double)t->energy.tangled / PL_SHARES);
        t->asked.epsilon =
            pl_next_epsilon(t->asked.epsilon, before, t->energy.sum, t->energy.least);
        pl_tangle_measure(t);
    }
    return 0;
}

static int climb(pl_tangle *t, const measures *rung) {
    t->asked = (pl_star_untangling){t->in_patch, t->size, t->link_skip, 1, 0};
    t->problem.untangling = &t->asked;
    t->run->restoring = 1;
    pl_tangle_mark(t, rung->layers);
    if (rung->centre && pl_patch_centre(t))
        return 0;
    if (rung->centre)
        pl_tangle_find_sizes(t);
    if (sweeps(t, rung->sweeps))
        return 0;
    if (t->energy.tangled > 0 && rung->solve)
        return !pl_patch_solve(t);
    return 1;
}

static int ladder(pl_tangle *t, double *best) {
    const planish_plan *plan = t->run->plan;
    const size_t size = (size_t)plan->n_nodes * (size_t)plan->dim * sizeof *best;
    int64_t n_best = t->n_tangled, inverted = pl_run_inverted(t->run);
    int whole = 1;
    memcpy(best, plan->coordinates, size);
    for (int i = 0; i < N_RUNGS && t->n_tangled > 0 && whole; i++) {
        whole = climb(t, &LADDER[i]);
        pl_tangle_find(t);
        if (getenv("PL_DEBUG"))
            fprintf(stderr, "rung %d: patch %g tangled %g (best %g) inverted %g\n", i,
                    (double)t->n_patch, (double)t->n_tangled, (double)n_best,
                    (double)pl_run_inverted(t->run));
        if (t->n_tangled < n_best && pl_run_inverted(t->run) <= inverted) {
            n_best = t->n_tangled;
            inverted = pl_run_inverted(t->run);
            memcpy(best, plan->coordinates, size);
        } else {
            memcpy(plan->coordinates, best, size);
            pl_tangle_find(t);
        }
    }
    return whole;
}

int pl_run_untangle(pl_run *r, planish_error *error) {
    pl_tangle t;
    int status = pl_tangle_create(r, &t, error);
    if (!status && t.n_tangled > 0) {
        double *best = pl_alloc(r->plan->n_nodes * r->plan->dim, sizeof *best);
        if (best)
            ladder(&t, best);
        pl_free(best);
    }
    pl_tangle_destroy(&t);
    return status;
}
