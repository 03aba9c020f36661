#ifndef PL_IMPROVE_JOINT_H
#define PL_IMPROVE_JOINT_H
#include "sweep/run.h"
int pl_joint_run(pl_run *r, uint8_t *state, double most, int64_t (*find)(void *, double), void *user);
#endif
