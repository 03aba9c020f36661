/* clock: wall time. */
#ifndef PL_BASE_CLOCK_H
#define PL_BASE_CLOCK_H

/** Seconds since some fixed moment, monotonic. */
double pl_seconds(void);

#endif
