/* drawn_values: the measures by which a picture colours elements, a byte for each element.
 *
 * A measure has bins, as its histogram has, and each bin has equally many codes. So a range of bins is a
 * range of codes, and the picture selects the elements that the histogram counts.
 *
 *     pl_drawn_measures              the measures of a mesh
 *     pl_drawn_values_find, _free    codes of elements
 *     pl_drawn_worse                 which of two codes is worse
 *     pl_drawn_class                 the colour of a code
 */
#ifndef PL_REPORT_DRAWN_VALUES_H
#define PL_REPORT_DRAWN_VALUES_H

#include "job/job.h"

enum {
    PL_DRAWN_MEASURES = 4, /* that elements have at most */
    PL_DRAWN_BINS = 15,    /* that a measure has at most */
    PL_DRAWN_CLASSES = 8,  /* colours */
    PL_DRAWN_CODES = 252,  /* codes 1 .. PL_DRAWN_CODES; 0: the element is inverted or flat */
    PL_DRAWN_NOTHING = 255 /* there is no element */
};

/** A measure. */
typedef struct pl_drawn_measure {
    const char *key;  /* that of its histogram, where it has one */
    const char *name; /* as people say */
    const char *unit; /* behind a value, or "" */
    int more_is_better;
    int n_bins;
    double edge[PL_DRAWN_BINS + 1];     /* [n_bins + 1] ascending; the last may be infinite */
    double limit[PL_DRAWN_CLASSES - 1]; /* between the colours, from good to bad */
} pl_drawn_measure;

/** Codes of elements of a mesh. */
typedef struct pl_drawn_values {
    const pl_drawn_measure *measure[PL_DRAWN_MEASURES]; /* [n_measures] */
    int n_measures;
    int64_t n;     /* elements */
    uint8_t *code; /* [n_measures][n] owned */
} pl_drawn_values;

/** Set measure to those of job's mesh, the ratio first; returns how many there are. */
int pl_drawn_measures(const pl_job *job, const pl_drawn_measure *measure[PL_DRAWN_MEASURES]);

/** Measure element [n] of job's mesh as it is now; NULL: all, which are n. values is to be freed also after a
 *  failure. Returns 0, or an exit status after a message. */
int pl_drawn_values_find(const pl_job *job, const int32_t *element, int64_t n,
                         pl_drawn_values *values);

/** Return the class of a code, 0 (good) to PL_DRAWN_CLASSES - 1; PL_DRAWN_CLASSES: inverted. */
int pl_drawn_class(const pl_drawn_measure *measure, uint8_t code);

/** Return 1 if code a is worse than code b. Anything is worse than PL_DRAWN_NOTHING. */
int pl_drawn_worse(const pl_drawn_measure *measure, uint8_t a, uint8_t b);

void pl_drawn_values_free(pl_drawn_values *values);

#endif
