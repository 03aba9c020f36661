/* still: a still picture of triangles, for browsers without WebGL, as a drawing (SVG) of a few tens of
 * kilobytes whatever the mesh: pixels, of which each row's runs of one colour are lines.
 *
 *     pl_still_begin, _free         an empty picture
 *     pl_still_draw, _dot, _cover   what is in it
 *     pl_still_put                  as SVG
 */
#ifndef PL_REPORT_STILL_H
#define PL_REPORT_STILL_H

#include "report/markup.h"

/** Colours: 0 .. PL_STILL_CLASSES - 1 of elements from good to bad, then of inverted ones, then shades of
 *  a surface from dark to light. */
enum { PL_STILL_CLASSES = 8, PL_STILL_INVERTED = PL_STILL_CLASSES, PL_STILL_SHADES = 6 };

typedef struct pl_still pl_still;

/** Begin the picture of what lies in a box around 0 with sides extent [3], seen from above if the last one
 *  is 0, else as the viewer shows it at first. NULL without memory. */
pl_still *pl_still_begin(const double extent[3]);

/** Draw a triangle at place [3][3] in a colour; -1: in the shade of a surface. */
void pl_still_draw(pl_still *still, const double place[3][3], int colour);

/** Draw a dot at place, so that a small element shows. */
void pl_still_dot(pl_still *still, const double place[3], int colour);

/** Let what is drawn from here on cover all that was. */
void pl_still_cover(pl_still *still);

/** Add the picture under a title. */
void pl_still_put(pl_markup *page, const pl_still *still, const char *title);

void pl_still_free(pl_still *still);

#endif
