/* report: a page for people, of a run that has just ended or of its JSON. */
#ifndef PL_TOOLS_REPORT_H
#define PL_TOOLS_REPORT_H

#include "report/picture.h"

/** Write the page of the result that json tells of to path. picture: what to draw, or NULL;
 *  no_picture: why something is not drawn, or NULL. Returns 0, or failed after a message. */
int pl_report_write(const char *path, const char *json, const pl_picture *picture,
                    const char *no_picture, int failed);

/** Whether this program has the library that draws pictures. */
int pl_report_can_draw(void);

#endif
