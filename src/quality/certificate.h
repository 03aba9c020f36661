/* certificate: the exact sign of the measure of a simplex.
 *
 * Orientation convention: positive where det[v1 - v0, v2 - v0, v3 - v0] > 0, or in the plane (v1
 * - v0) x (v2 - v0) > 0.
 *
 *   pl_measure_sign             the sign
 *   pl_certified_determinant    the measure, with the exact sign
 */
#ifndef PL_QUALITY_CERTIFICATE_H
#define PL_QUALITY_CERTIFICATE_H

/** Sign, +1, 0 or -1, of the measure of the simplex with vertices vertex [dim + 1], pointers to
 *  coordinates [dim]. Right for any finite coordinates: neither rounding nor overflow nor underflow
 *  matter. 0 if a coordinate is not finite. */
int pl_measure_sign(int dim, const double *const vertex[]);

/** Measure of a simplex with the exact sign: m with m 2^*exponent = D up to rounding, D = dim!
 * times the measure, and the exact sign of D. The error of m is at most that of the plain formula.
 * Where the plain formula does not decide the sign, it is a few units in the last place of m. 0 if
 * a coordinate is not finite. */
double pl_certified_determinant(int dim, const double *const vertex[], int *exponent);

#endif
