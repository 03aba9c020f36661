/* facet_functions: plain formulas of facets of first and second order. */
#include "support/facet_functions.h"

#include <string.h>

/** Nodes of quadrilaterals, on [-1, 1]^2. */
static const double AT[9][2] = {{-1, -1}, {1, -1}, {1, 1},  {-1, 1}, {0, -1},
                                {1, 0},   {0, 1},  {-1, 0}, {0, 0}};

static double quadratic(double x, double node) {
    return node == 0 ? 1 - x * x : x * (x + node) / 2;
}

static double serendipity(double x, double y, double p, double q) {
    return p == 0   ? (1 - x * x) * (1 + q * y) / 2
           : q == 0 ? (1 + p * x) * (1 - y * y) / 2
                    : (1 + p * x) * (1 + q * y) * (p * x + q * y - 1) / 4;
}

void facet_functions(int n, double u, double v, double by[9]) {
    const double w = 1 - u - v, x = 2 * u - 1, y = 2 * v - 1;
    const double low = u < v ? u : v, high = u < v ? v : u;
    const double triangle3[] = {u, v, w};
    const double square4[] = {1 - high, u > v ? u - v : 0, low, v > u ? v - u : 0};
    const double triangle6[] = {u * (2 * u - 1), v * (2 * v - 1), w * (2 * w - 1),
                                4 * u * v,       4 * v * w,       4 * w * u};
    if (n == 3)
        memcpy(by, triangle3, sizeof triangle3);
    else if (n == 4)
        memcpy(by, square4, sizeof square4);
    else if (n == 6)
        memcpy(by, triangle6, sizeof triangle6);
    for (int i = 0; i < n && n >= 8; i++)
        by[i] = n == 9 ? quadratic(x, AT[i][0]) * quadratic(y, AT[i][1])
                       : serendipity(x, y, AT[i][0], AT[i][1]);
}

void facet_place(int n, int i, double uv[2]) {
    static const double TRIANGLE[6][2] = {{1, 0}, {0, 1}, {0, 0}, {.5, .5}, {0, .5}, {.5, 0}};
    for (int d = 0; d < 2; d++)
        uv[d] = n % 3 == 0 && n < 9 ? TRIANGLE[i][d] : (AT[i][d] + 1) / 2;
}
