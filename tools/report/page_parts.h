/* page_parts: the parts of a page, each in a file page_*.c.
 *
 *     pl_page_put_*        put a part
 *     pl_page_can_draw     whether there are pictures
 */
#ifndef PL_REPORT_PAGE_PARTS_H
#define PL_REPORT_PAGE_PARTS_H

#include "report/figures.h"
#include "report/markup.h"
#include "report/picture.h"

/** Whether this program has the library that draws pictures. */
int pl_page_can_draw(void);

/** page_summary.c: what was done, and whether the mesh is valid. */
void pl_page_put_summary(pl_markup *page, const pl_figures *figures);

/** page_tables.c: measures before and after. */
void pl_page_put_measures(pl_markup *page, const pl_figures *figures);

/** page_picture.c: the picture, as for pl_page_make; the script that draws it. */
void pl_page_put_picture(pl_markup *page, const pl_figures *figures, const pl_picture *picture,
                         const char *no_picture);
void pl_page_put_viewer(pl_markup *page, const pl_picture *picture);

/** page_worst.c: the worst elements. */
void pl_page_put_worst(pl_markup *page, const pl_figures *figures);

/** page_run.c: heights of layers, the surface, time and machine, and what is certified. */
void pl_page_put_layers(pl_markup *page, const pl_figures *figures);
void pl_page_put_surface(pl_markup *page, const pl_figures *figures);
void pl_page_put_run(pl_markup *page, const pl_figures *figures);
void pl_page_put_certificate(pl_markup *page, const pl_figures *figures);

/** page_charts.c: histograms and how the smoothing converged. */
void pl_page_put_histograms(pl_markup *page, const pl_figures *figures);
void pl_page_put_convergence(pl_markup *page, const pl_figures *figures);

#endif
