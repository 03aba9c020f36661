/* objective: the paper's F of a mesh and its terms: aspect ratios of the kind asked for, and
 * volumes against their minimum values. The guarded sweeps are judged by F; measure.h has the
 * radius ratio alone, faster. Sums are rounded once (base/sum.h): the same bits for any number of
 * threads and order of the elements.
 *
 *   pl_objective_problem_of                          what to sum over
 *   pl_sum_objective                                 the sums
 *   pl_is_mean, pl_tangled                           mean ratios; elements with inverted corners
 *   pl_rms, pl_rms_of_all, _of_movable               the RMS of sums
 *   pl_objective_of_all, _of_movable                 F of sums
 *   pl_minimum_volume_of                             options.min_volume as a volume
 *   pl_find_below, pl_find_inverted, _tangled        elements that miss their minimum volume
 */
#ifndef PL_QUALITY_OBJECTIVE_H
#define PL_QUALITY_OBJECTIVE_H

#include "quality/view.h"

#include <math.h>

/** A mesh, and the objective and limits asked of it. */
typedef struct pl_objective_problem {
    pl_view mesh;              /* is_movable without PL_ELSEWHERE: is_counted says that */
    const double *coordinates; /* [n][dim] */
    planish_objective objective;
    double min_volume; /* of elements without their own; 0: none */
    int threads;
} pl_objective_problem;

/** Sums over the valid elements (positive measure, decided exactly), by [movable]: 1 for those with
 * a movable node, 0 for the others. Of a mesh with corners they are over cells, valid ones with
 * positive corners; RR^2 then stands for the AR^2 of mean ratios, the mean of the corners' mu^2, and
 * the volume of a corner for that of a cell with such corners (pl_corner_form.volume). */
typedef struct pl_objective_sums {
    double ratio[2];   /* of AR^2 */
    double radius[2];  /* of RR^2 */
    double volume[2];  /* of g^2, of elements with a minimum volume; of a cell the mean of its
                          corners' g^2 */
    double n[2];       /* how many there are */
    double radius_max; /* largest RR^2 of those with a movable node */
    double corner_max; /* with corners: largest mu^2 of a corner of these */
    double acuteness;  /* of the smallest angle of these, see geometry/angle.h; with corners the
                          largest 1 / SJ^2, SJ the scaled Jacobian */
    double inverted;   /* elements that are not valid */
    double inside;     /* those of them that are curved and have positive corners; pl_sum_objective
                          knows none */
    double below; /* elements with a minimum volume and g above PLANISH_VOLUME_TOLERANCE, valid or
                     not; cells with such a corner */
    double shortfall; /* sum of max(0, g)^2, valid or not; of a cell the mean */
    double domain;    /* sum of the signed measures of all; of a cell the mean of its corners, which
                         is exact but for hexahedra and wedges that are no parallelepipeds or prisms */
} pl_objective_sums;

/** Return the problem that options define for mesh at coordinates [n][dim]; min_volume as in
 *  pl_objective_problem. */
pl_objective_problem pl_objective_problem_of(const pl_view *mesh, const double *coordinates,
                                             const planish_options *options, double min_volume,
                                             int threads);

/** Sum over all elements of the problem's mesh, and over all processes that have parts of it. */
void pl_sum_objective(const pl_objective_problem *problem, pl_objective_sums *sums);

/** Whether corners of cells are measured by mean ratios: else by edges. */
static inline int pl_is_mean(planish_objective objective) {
    return objective != PLANISH_OBJECTIVE_EDGE_RATIO;
}

/** Number of elements whose corners are not positive. */
static inline double pl_tangled(const pl_objective_sums *sums) {
    return sums->inverted - sums->inside;
}

/** Root mean square of n numbers from the sum of their squares; 0 without any. */
static inline double pl_rms(double sum, double n) {
    return n > 0 ? sqrt(sum / n) : 0;
}

/** RMS of the ratio over all elements. */
static inline double pl_rms_of_all(const pl_objective_sums *sums) {
    return pl_rms(sums->ratio[0] + sums->ratio[1], sums->n[0] + sums->n[1]);
}

/** RMS of the ratio over the elements with a movable node. */
static inline double pl_rms_of_movable(const pl_objective_sums *sums) {
    return pl_rms(sums->ratio[1], sums->n[1]);
}

/** F = mu1 f1 + mu2 f2 of sums, over all valid elements. */
double pl_objective_of_all(const planish_options *options, const pl_objective_sums *sums);

/** F of the valid elements with a movable node. */
double pl_objective_of_movable(const planish_options *options, const pl_objective_sums *sums);

/** Return delta of options: min_volume, or the fraction of the volume of problem's mesh. */
double pl_minimum_volume_of(const planish_options *options, const pl_objective_problem *problem);

/** Fill state [m] with PLANISH_VOLUME_MET or _BELOW, of corners each by its own volume. Return how
 *  many are below. */
int64_t pl_find_below(const pl_objective_problem *problem, uint8_t *state);

/** Fill state [m] as pl_find_below does, with minimum volumes if the problem has any; elements that
 *  are not positive are below, too. Return how many are below, for whichever reason. */
int64_t pl_find_inverted(const pl_objective_problem *problem, uint8_t *state);

/** Fill state [m] as pl_find_below does; elements that are not positive, or positive only within
 *  rounding, are below, too. Return how many are below. */
int64_t pl_find_tangled(const pl_objective_problem *problem, uint8_t *state);

#endif
