/* page: the reports that a run writes: its JSON, and the HTML page that is made of it and needs
 * nothing else.
 *
 *     pl_report_draw, pl_reports_write, pl_page_write    the files (page.c)
 */
#ifndef PL_REPORT_PAGE_H
#define PL_REPORT_PAGE_H

#include "report/page_parts.h"

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

#endif
