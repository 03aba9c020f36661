/* worst: the worst elements of a mesh, for lists and pictures. */
#ifndef PL_TOOLS_WORST_H
#define PL_TOOLS_WORST_H

#include "job.h"

/** An element and what it is worth. */
typedef struct pl_bad_element {
    int64_t element;     /* index in job->mesh */
    double radius_ratio; /* 0: inverted, or flat */
} pl_bad_element;

typedef struct pl_worst {
    pl_bad_element *bad; /* [n] owned; inverted ones first (in the file's order), then the largest
                            radius ratios; equals in the file's order */
    int64_t n;
} pl_worst;

/** Find the n worst elements of the mesh as it is now, or all if there are fewer. Returns 0, or an
 *  exit status after a message. */
int pl_worst_find(const pl_job *job, int64_t n, pl_worst *worst);

void pl_worst_free(pl_worst *worst);

#endif
