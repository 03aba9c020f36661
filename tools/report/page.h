/* page: the report as one HTML page that needs nothing else, from the JSON of a run. */
#ifndef PL_REPORT_PAGE_H
#define PL_REPORT_PAGE_H

#include "report/figures.h"
#include "report/markup.h"
#include "report/picture.h"

/** Make the page. picture: what is drawn of the mesh, or NULL; no_picture: why something is not, or
 *  NULL. page->failed: out of memory. */
void pl_page_make(pl_markup *page, const pl_figures *figures, const pl_picture *picture,
                  const char *no_picture);

/** Whether this program has the library that draws pictures. */
int pl_page_can_draw(void);

/* ---- its parts ------------------------------------------------------------------------------ */

/** page_tables.c: measures before and after, and the worst elements. */
void pl_page_put_measures(pl_markup *page, const pl_figures *figures);
void pl_page_put_worst(pl_markup *page, const pl_figures *figures);

/** page_run.c: time and machine, and what is certified. */
void pl_page_put_run(pl_markup *page, const pl_figures *figures);
void pl_page_put_certificate(pl_markup *page, const pl_figures *figures);

/** page_charts.c: histograms and how the smoothing converged. */
void pl_page_put_histograms(pl_markup *page, const pl_figures *figures);
void pl_page_put_convergence(pl_markup *page, const pl_figures *figures);

#endif
