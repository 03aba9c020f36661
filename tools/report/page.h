/* page: the reports that a run writes: its JSON, and the HTML page that is made of it and needs
 * nothing else.
 *
 *     pl_report_draw, pl_reports_write, pl_page_write    the files (page.c)
 *     pl_page_put_*                                      the parts of a page (page_*.c)
 */
#ifndef PL_REPORT_PAGE_H
#define PL_REPORT_PAGE_H

#include "report/figures.h"
#include "report/markup.h"
#include "report/picture.h"

/** Take the mesh of job as it is now into the picture for the page, which is begun if *picture is
 *  NULL; nothing is done where no page is asked for, or this program draws none. name: as for
 *  pl_picture_take. */
int pl_report_draw(const pl_job *job, const char *name, pl_picture **picture);

/** Write the reports that arguments ask for: json, the text of a result (NULL: there was no memory
 *  for it), and the page that is made of it. picture: for the page, or NULL. Returns 0, or failed
 *  after a message. */
int pl_reports_write(const pl_arguments *arguments, const char *json, const pl_picture *picture,
                     int failed);

/** Write the HTML page of figures to path ("-": standard output). picture and no_picture as for
 *  pl_page_make. Returns 0, or failed after a message. */
int pl_page_write(const char *path, const pl_figures *figures, const pl_picture *picture,
                  const char *no_picture, int failed);

/** Make the page. picture: what is drawn of the mesh, or NULL; no_picture: why something is not, or
 *  NULL. page->failed: out of memory. */
void pl_page_make(pl_markup *page, const pl_figures *figures, const pl_picture *picture,
                  const char *no_picture);

/** Whether this program has the library that draws pictures. */
int pl_page_can_draw(void);

/* ---- its parts ------------------------------------------------------------------------------ */

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
