/* picture_start: which bad elements of a picture are seen at first. */
#ifndef PL_REPORT_PICTURE_START_H
#define PL_REPORT_PICTURE_START_H

#include "report/picture_state.h"

/** Return the ratio beyond which elements inside are drawn at first: a usual one, or less so that a few of
 *  the worst are seen. */
double pl_picture_start(const pl_picture *picture);

#endif
