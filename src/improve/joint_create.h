/* joint_create: the input of all patches of a run. */
#ifndef PL_IMPROVE_JOINT_CREATE_H
#define PL_IMPROVE_JOINT_CREATE_H

#include "improve/joint.h"

/** Make the input of a run that is measured: largest_angle, kept and the plan's mesh. limits [2]:
 *  kept[0] and [1]. Errors: _MEMORY. */
int pl_joint_create(pl_run *run, const pl_star_limits limits[2], pl_joint *joint,
                    planish_error *error);

/** Free the arrays of joint, those of the mesh as pl_joint_create made it. */
void pl_joint_destroy(pl_joint *joint);

#endif
