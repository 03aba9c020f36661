/* report: a page for people, of a run that has just ended or of its JSON. */
#ifndef PL_TOOLS_REPORT_H
#define PL_TOOLS_REPORT_H

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

#endif
