/* joint_steps: steps of a patch. */
#ifndef PL_IMPROVE_JOINT_STEPS_H
#define PL_IMPROVE_JOINT_STEPS_H

#include "improve/joint.h"

/** Try to bring the patch's element to the wanted measure, and let the patch grow. */
void pl_joint_improve(const pl_joint *joint, int thread, pl_joint_patch *patch);

#endif
