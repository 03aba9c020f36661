/* clock: wall time. */
#include "base/clock.h"

#include <time.h>

/* Seconds between two questions: unnoticed by those who wait, and nothing to the work. */
static const double EVERY = 0.05;

double pl_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

pl_stop_check pl_limit_of(int (*ask)(void *context), void *context) {
    return (pl_stop_check){.ask = ask, .context = context, .next = pl_seconds() + EVERY};
}

int pl_limit_is_reached(pl_stop_check *limit) {
    if (!limit || limit->answer)
        return limit ? limit->answer : 0;
    const double now = pl_seconds();
    if (now < limit->next)
        return 0;
    limit->next = now + EVERY;
    limit->answer = limit->ask(limit->context);
    return limit->answer;
}
