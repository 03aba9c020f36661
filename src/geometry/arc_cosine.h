/* arc_cosine: the angle of a cosine, made of + - * and sqrt only.
 *
 * The C library's acos is neither the same on every system nor is it taken into vectors; this one
 * is both. The error is below 1e-15 of the angle.
 *
 *   pl_arc_cosine, pl_arc_sine_of_half
 */
#ifndef PL_GEOMETRY_ARC_COSINE_H
#define PL_GEOMETRY_ARC_COSINE_H

#include "geometry/inline.h"

#include <math.h>

/** Return asin(s) of 0 <= s <= 1/2: s times the polynomial in u = s^2 that is asin(s) / s at the 12
 *  Chebyshev points of 0 <= u <= 1/4. It is elsewhere, too, within 2.5e-16. */
PL_INLINE double pl_arc_sine_of_half(double s) {
    const double u = s * s, u2 = u * u, u4 = u2 * u2;
    const double first = (0.9999999999999997998 + 0.1666666666668970641 * u) +
                         (0.07499999995624414475 + 0.04464286038603155812 * u) * u2;
    const double then = (0.03038182075222176908 + 0.02237492882360569119 * u) +
                        (0.01731370094590989548 + 0.01432423514994457052 * u) * u2;
    const double last = (0.009376473481056653812 + 0.01825637024213352896 * u) +
                        (-0.01169355967953131774 + 0.03150477675162431179 * u) * u2;
    return s * (first + u4 * (then + u4 * last));
}

/** Return acos in radians; a cosine that rounding has put beyond 1 or -1 counts as 1 or -1. */
PL_INLINE double pl_arc_cosine(double cosine) {
    static const double PI = 3.1415926535897932385;
    double c = fabs(cosine);
    c = c < 1 ? c : 1;
    const int steep = c > 0.5; /* there acos(c) = 2 asin(sqrt((1 - c) / 2)) */
    const double sine = pl_arc_sine_of_half(steep ? sqrt((1 - c) / 2) : c);
    const double angle = steep ? 2 * sine : PI / 2 - sine;
    return cosine < 0 ? PI - angle : angle;
}

#endif
