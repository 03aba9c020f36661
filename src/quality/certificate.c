/* certificate: the exact sign of the measure of a simplex. The plain formula decides where it
 * exceeds the bound of its rounding error, integers as long as needed elsewhere. */
#include "quality/certificate.h"
#include "geometry/simplex.h"
#include "base/exact.h"

#include <float.h>
#include <limits.h>
#include <math.h>

/* Rounding error of D by this multiple of its permanent (Shewchuk 1997, "Adaptive precision
 * floating-point arithmetic and fast robust geometric predicates"), u = 2^-53. */
static const double ERROR_2D = (3 + 16 * 0x1p-53) * 0x1p-53;
static const double ERROR_3D = (7 + 56 * 0x1p-53) * 0x1p-53;

/* With differences below SCALED_HIGH, what underflow adds to the errors of D and of its permanent:
 * each of a dozen products loses less than 2^-1074 and meets factors below 2^100 afterwards. */
static const double UNDERFLOW_ERROR = 0x1p-960;
static const double SCALED_LOW = 0x1p-100, SCALED_HIGH = 0x1p100;

/** Minor a d - b c. */
static void exact_minor(const pl_exact *a, const pl_exact *b, const pl_exact *c, const pl_exact *d,
                        pl_exact *minor) {
    pl_exact ad, bc;
    pl_exact_multiply(a, d, &ad);
    pl_exact_multiply(b, c, &bc);
    pl_exact_add(&ad, &bc, -1, minor);
}

/** Find m and the exponent of pl_certified_determinant by integers as long as needed. */
static double certify_exactly(int dim, const double *const vertex[], int *exponent) {
    int unit = INT_MAX; /* the lowest one of the coordinates */
    *exponent = 0;
    for (int i = 0; i <= dim; i++)
        for (int d = 0; d < dim; d++) {
            const double a = vertex[i][d];
            if (!(fabs(a) <= DBL_MAX))
                return 0;
            const int own = a != 0 ? pl_exact_unit(a) : INT_MAX;
            unit = own < unit ? own : unit;
        }
    if (unit == INT_MAX)
        return 0;
    pl_exact e[3][3], determinant;
    for (int i = 0; i < dim; i++)
        for (int d = 0; d < dim; d++)
            pl_exact_difference(vertex[i + 1][d], vertex[0][d], unit, &e[i][d]);
    if (dim == 2) {
        exact_minor(&e[0][0], &e[0][1], &e[1][0], &e[1][1], &determinant);
    } else { /* by the first row */
        pl_exact minor, term[3], sum;
        for (int d = 0; d < 3; d++) {
            const int next = (d + 1) % 3, last = (d + 2) % 3;
            exact_minor(&e[1][next], &e[1][last], &e[2][next], &e[2][last], &minor);
            pl_exact_multiply(&e[0][d], &minor, &term[d]);
        }
        pl_exact_add(&term[0], &term[1], 1, &sum);
        pl_exact_add(&sum, &term[2], 1, &determinant);
    }
    const double m = pl_exact_round(&determinant, exponent);
    *exponent += dim * unit;
    return m;
}

double pl_certified_determinant(int dim, const double *const vertex[], int *exponent) {
    double edges[3][3], a[3][3], largest = 0; /* a: absolute entries */
    int scale = 0;
    pl_edges(dim, vertex, edges);
    for (int i = 0; i < dim; i++)
        for (int d = 0; d < dim; d++) {
            const double entry = fabs(edges[i][d]);
            if (!(entry <= DBL_MAX))
                return certify_exactly(dim, vertex, exponent);
            largest = entry > largest ? entry : largest;
        }
    if (largest < SCALED_LOW || largest > SCALED_HIGH)
        frexp(largest, &scale);
    for (int i = 0; i < dim; i++)
        for (int d = 0; d < dim; d++) {
            edges[i][d] = scale ? ldexp(edges[i][d], -scale) : edges[i][d];
            a[i][d] = fabs(edges[i][d]);
        }
    const double determinant = pl_determinant_of_edges(dim, edges);
    const double permanent = dim == 2 ? a[0][0] * a[1][1] + a[0][1] * a[1][0]
                                      : a[0][0] * (a[1][1] * a[2][2] + a[1][2] * a[2][1]) +
                                            a[0][1] * (a[1][2] * a[2][0] + a[1][0] * a[2][2]) +
                                            a[0][2] * (a[1][0] * a[2][1] + a[1][1] * a[2][0]);
    const double error = (dim == 3 ? ERROR_3D : ERROR_2D) * permanent + UNDERFLOW_ERROR;
    *exponent = dim * scale;
    return fabs(determinant) > error ? determinant : certify_exactly(dim, vertex, exponent);
}

int pl_measure_sign(int dim, const double *const vertex[]) {
    int exponent;
    double determinant = pl_certified_determinant(dim, vertex, &exponent);
    return (determinant > 0) - (determinant < 0);
}
