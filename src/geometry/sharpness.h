/* sharpness: how sharply the smoothed edge ratio follows longest edge / shortest. */
#ifndef PL_GEOMETRY_SHARPNESS_H
#define PL_GEOMETRY_SHARPNESS_H

/* Extremes of the squared edges are means of the power 2^this: the smoothed ratio is at most the
 * ratio, and at least 6^(-1/32) = 0.946 of it (triangles: 3^(-1/32) = 0.966). */
enum { PL_EDGE_SHARPNESS = 5 };

#endif
