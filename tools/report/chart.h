/* chart: histograms and curves as SVG within a page.
 *
 * Drawings have no size of their own (they fill what holds them) and no colours: classes of the
 * page's style sheet (page.css) give them, in light, dark and print. What a drawing shows is said
 * in words by its title, and in figures by a table that the page puts beside it.
 *
 *     pl_chart_histogram, pl_chart_curves
 *     pl_chart_frame_of_bins
 */
#ifndef PL_REPORT_CHART_H
#define PL_REPORT_CHART_H

#include "report/markup.h"

enum { PL_CHART_MOST_SERIES = 2 };

/** Elements by the value of something: bars over bins, side by side for each series. */
typedef struct pl_histogram {
    const char *title;
    const char *axis;
    const double *edges; /* [n_bins + 1], the last may be infinite */
    int n_bins;
    int n_series;                              /* 1 or 2 */
    const double *count[PL_CHART_MOST_SERIES]; /* [n_bins] each */
    const char *name[PL_CHART_MOST_SERIES];
} pl_histogram;

/** Places of the bins in the drawing: from and to, in units of its view box. */
typedef struct pl_chart_frame {
    int from, to;
} pl_chart_frame;

pl_chart_frame pl_chart_frame_of_bins(void);

/** Draw it; heights are logarithms of the counts, so that the few bad ones show beside the many. */
void pl_chart_histogram(pl_markup *page, const pl_histogram *histogram);

/** Values over something. Points that are not finite, or not positive, are left out. */
typedef struct pl_curves {
    const char *title;
    const char *x_axis;
    int64_t n;       /* points */
    const double *x; /* [n] ascending */
    int n_series;
    const double *y[PL_CHART_MOST_SERIES]; /* [n] each */
    const char *name[PL_CHART_MOST_SERIES];
    const char *const *phase; /* [n] name of the phase that led to the point, or NULL */
    double floor;             /* where the axis of the values begins; 0: below the smallest */
    double x_step, y_step;    /* between ticks of the axes at least; 1: of whole numbers */
} pl_curves;

/** Draw them with a logarithmic axis for the values. */
void pl_chart_curves(pl_markup *page, const pl_curves *curves);

#endif
