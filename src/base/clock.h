/* clock: wall time.
 *
 *   pl_seconds                       the time
 *   pl_limit_of, pl_limit_is_reached    a limit for long work
 */
#ifndef PL_BASE_CLOCK_H
#define PL_BASE_CLOCK_H

#include <stddef.h>

/** Seconds since some fixed moment, monotonic. */
double pl_seconds(void);

/** Ask of long work, now and then, whether it is to end. One thread uses it. */
typedef struct pl_stop_check {
    int (*ask)(void *context); /* not 0: end; it is not asked again */
    void *context;
    double next; /* clock: not asked before */
    int answer;  /* the last one */
} pl_stop_check;

/** Return a limit that is asked when a while has passed: short work never asks. */
pl_stop_check pl_limit_of(int (*ask)(void *context), void *context);

/** Whether the work is to end: the answer. limit may be NULL: it goes on. */
int pl_limit_is_reached(pl_stop_check *limit);

#endif
