/* joint_measures: measures that joint steps raise, and limits that they keep: measures of elements,
 * larger the better they are. */
#ifndef PL_IMPROVE_JOINT_MEASURES_H
#define PL_IMPROVE_JOINT_MEASURES_H

#include "geometry/slope.h"
#include "improve/joint.h"

/** Kinds of measures, as geometry/slope.h has them. */
typedef enum pl_joint_measure {
    PL_JOINT_ANGLE,
    PL_JOINT_RATIO,
    PL_JOINT_MEAN,
    PL_JOINT_JACOBIAN
} pl_joint_measure;

/** Return the measure that is raised (other 0), or kept (1). */
pl_joint_measure pl_joint_measure_of(const pl_run *r, int other);

/** Return the value of a measure whose limit is square: 1 / sin^2 of an acute angle, or 1 / measure^2. */
double pl_joint_value_of_square(pl_joint_measure kind, double square);

/** Return the value of the measure that is raised where the run's limit of it is square. */
double pl_joint_value_of(const pl_run *run, double square);

/** Return the least measure of an element, of the kind that is raised. */
double pl_joint_value(const pl_joint *joint, const pl_joint_element *element);

/** Find the vertices x of an element, in the scale of measuring. */
void pl_joint_find_vertices(const pl_joint *joint, const pl_joint_element *e, double x[4][3]);

/** Compute the measures of a kind, and (derive) their slopes; return how many. */
int pl_joint_measures_of(const pl_run *r, pl_joint_measure kind, uint8_t form, const double x[4][3],
                         int derive, pl_slope slope[]);

/** Return the least measure of a kind. */
double pl_joint_least_measure(const pl_run *r, pl_joint_measure kind, uint8_t form,
                              const double x[4][3]);

/** Return D of vertices, and in *certain whether it is positive beyond doubt of rounding. */
double pl_joint_determinant_of(int dim, const double x[4][3], int *certain);

/** Return the largest angle of an element with a movable node, at the start of the run and now. */
double pl_joint_find_largest_angle(const pl_run *r);

#endif
