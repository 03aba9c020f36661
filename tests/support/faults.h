/* faults: every allocation that some calls of the library make fails once.
 *
 * A scenario is a function that makes the calls, each again after it was refused memory, and adds
 * to a digest whatever they give. It is run once in peace, which counts its allocations, and then
 * again and again, each time with others that fail: one; or two in a row, since the library asks
 * again after it has given back what it kept; or all from one on, until a call is refused. Its
 * digest must always be the same.
 */
#ifndef TEST_SUPPORT_FAULTS_H
#define TEST_SUPPORT_FAULTS_H

#include <planish/planish.h>

#include <stddef.h>

typedef struct faults {
    uint64_t digest;
    int64_t refused; /* calls, in all runs */
    int64_t live;    /* blocks that the caller's allocator has given and not got back */
    planish_allocator allocator;
} faults;

typedef void fault_scenario(const void *world, faults *f);

/** Run the scenario; returns how many runs had a fault. In the short form that many allocations,
 *  some, are made to fail, in the long form all of them. At least one call must have been refused.
 */
int64_t faults_try(const char *name, fault_scenario *scenario, const void *world, int64_t some);

/** Whether a call was refused memory: its error is looked at, and no more allocations fail. The
 *  test fails if status is another error. */
int faults_refused(faults *f, int status, const planish_error *error);

/** The n bytes are part of what the scenario gives. */
void faults_add(faults *f, const void *data, size_t n);

/** Fill with what no call leaves, and whether it is still so. */
void faults_mark(void *data, size_t n);
int faults_is_marked(const void *data, size_t n);

#endif
