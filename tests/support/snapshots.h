/* snapshots: where nodes were at the end of each sweep, as a progress function asked for it. */
#ifndef TEST_SUPPORT_SNAPSHOTS_H
#define TEST_SUPPORT_SNAPSHOTS_H

#include <planish/planish.h>

/** Snapshots of one call. Arrays are owned, but live. */
typedef struct snapshots {
    const double *live; /* the caller's array, which the call smooths */
    double *given;      /* [length] as it was when the call began */
    size_t length;      /* doubles in it */
    int n, room;
    double **x;                /* [n][length] the whole array at the end of each sweep */
    planish_progress *figures; /* [n] of it */
    unsigned char *is_set;     /* [length] 1: the library sets this number in each snapshot */
    int64_t n_refused;         /* calls that are not the last one of a sweep */
} snapshots;

/** Begin with the array of length doubles that is going to be smoothed. */
snapshots snapshots_begin(const double *live, size_t length);

void snapshots_free(snapshots *s);

/** The progress function; user is a snapshots. The test fails if the library refuses at the end of a sweep,
 *  answers elsewhere, changes the caller's array, or sets other numbers than before. */
int snapshots_take(const planish_progress *progress, void *user);

/** Check that two calls have the same snapshots, bit by bit. */
void snapshots_assert_same(const snapshots *a, const snapshots *b);

#endif
