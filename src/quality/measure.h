/* measure: the quality of a mesh, in one pass over its elements.
 *
 * The sums that RMS values come from are rounded once (base/sum.h). The other sums run over
 * chunks that depend on the mesh alone, with a fixed number of accumulators in each, and are
 * added in the chunks' order: the same bits for any number of threads and instruction set. The
 * validity of elements is decided exactly (certificate.h).
 *
 * Of a mesh with corners cells are measured: Fields of RR then have AR, by the mean ratios of
 * corners, and fields of angles the scaled Jacobian. A cell is positive if all its corners are. All
 * its corners have its state and its ratio.
 *
 *   pl_measure                       all measures
 *   pl_sum_radius_ratio              the radius ratio alone, faster
 *   pl_find_worse, pl_find_ratios    single elements
 *   pl_find_worse_corners            single corners
 *   pl_find_reversed                 elements numbered the other way round than most
 */
#ifndef PL_QUALITY_MEASURE_H
#define PL_QUALITY_MEASURE_H

#include "quality/view.h"

/** Measure the mesh: *quality (planish.h); worst_element of cells is a corner. Each element is
 *  looked at in its own scale, so that any volume that a double holds gives a finite ratio; sums
 *  that overflow are infinite. What has no value for lack of (valid) elements is 0. coordinates
 *  [n][dim]. Errors: _MEMORY; *quality is then untouched. */
int pl_measure(const pl_view *view, const double *coordinates, int threads,
               planish_quality *quality, planish_error *error);

/** Radius ratios over the valid elements (positive measure, decided exactly). */
typedef struct pl_ratio_sums {
    double movable;    /* sum of RR^2 over the elements with a free node */
    double fixed;      /* sum of RR^2 over the others */
    int64_t n_movable; /* valid elements with a free node */
    int64_t n_fixed;   /* other valid elements */
    double max;        /* largest RR^2 of those with a free node, 0 without any */
    double acuteness;  /* of the smallest angle of these (geometry/angle.h), 0 without any */
    int64_t inverted;  /* elements that are not valid */
} pl_ratio_sums;

/** Sum the radius ratios: the part of pl_measure that convergence is judged by, twice as fast; the
 *  same bits. Fastest where edges are between 1e-18 and 1e24 long, and right everywhere. */
void pl_sum_radius_ratio(const pl_view *view, const double *coordinates, int threads,
                         pl_ratio_sums *sums);

/** State of an element. */
enum { PL_FINE = 0, PL_WORSE = 1, PL_INVERTED = 2 };

/** Find the elements whose RR is above ratio, or the acuteness of an angle above acuteness, or that
 *  are not positive: state [m]. */
void pl_find_worse(const pl_view *view, const double *coordinates, double ratio, double acuteness,
                   int threads, uint8_t *state);

/** Find the corners, each by itself, whose mu is above ratio, or 1 / SJ^2 above acuteness, or that are
 *  not positive, or of a positive cell whose AR is above cell_ratio: state [m]. */
void pl_find_worse_corners(const pl_view *view, const double *coordinates, double ratio,
                           double acuteness, double cell_ratio, int threads, uint8_t *state);

/** Find the RR of each element, 0 of those that are not positive: ratio [m]. */
void pl_find_ratios(const pl_view *view, const double *coordinates, int threads, double *ratio);

/** Find the elements whose measure in the listed order of their nodes has, exactly, the other sign
 *  than most elements' of the whole mesh: reversed [m] becomes 0 or 1. In a tie most are positive.
 *  Of cells most are those of the same shape, and one with corners of both signs has no sign.
 *  Return their number in the whole mesh. */
int64_t pl_find_reversed(const pl_view *view, const double *coordinates, int threads,
                         uint8_t *reversed);

#endif
