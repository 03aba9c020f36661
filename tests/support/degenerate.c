/* degenerate: elements that are flat, or nearly so. */
#include "support/degenerate.h"

#include "support/effort.h"

#include <float.h>
#include <math.h>
#include <string.h>

const char *const degenerate_name[DEGENERATE_KINDS] = {
    "exactly flat",  "one unit off",  "rounded",   "far from the origin", "vertices together",
    "thin, sheared", "all exponents", "subnormal", "underflowing",        "overflowing"};

/** A whole number, -most .. most. */
static double integer(uint64_t *random, int64_t most) {
    return (double)(random_below(random, 2 * most + 1) - most);
}

/** Any bits in the mantissa, or few of them, in [-1, 1]. */
static double mantissa(uint64_t *random) {
    return random_below(random, 2) ? integer(random, 8) / 8 : random_between(random, -1, 1);
}

static int exponent_between(uint64_t *random, int low, int high) {
    return low + (int)random_below(random, high - low + 1);
}

/** The last vertex x_0 + s (x_1 - x_0) + t (x_2 - x_0). */
static void close_up(int dim, double s, double t, double x[4][3]) {
    for (int d = 0; d < dim; d++)
        x[dim][d] = x[0][d] + s * (x[1][d] - x[0][d]) + (dim == 3 ? t * (x[2][d] - x[0][d]) : 0);
}

static void flat(int dim, uint64_t *random, double x[4][3]) {
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            x[j][d] = integer(random, 1 << 20);
    const double t = integer(random, 16), s = integer(random, 16);
    close_up(dim, s, t, x);
    for (int d = 0; d < dim; d++) {
        const int exponent = random_below(random, 2) ? exponent_between(random, -900, 900) : 0;
        for (int j = 0; j <= dim; j++)
            x[j][d] = ldexp(x[j][d], exponent);
    }
}

/** Of one vertex to one of its neighbours among the doubles. */
static void change_one(int dim, uint64_t *random, double x[4][3]) {
    double *a = &x[random_below(random, dim + 1)][random_below(random, dim)];
    const double next = nextafter(*a, random_below(random, 2) ? INFINITY : -INFINITY);
    *a = isfinite(next) ? next : *a;
}

static void rounded(int dim, uint64_t *random, double x[4][3]) {
    const int exponent = exponent_between(random, -900, 900);
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            x[j][d] = ldexp(random_between(random, -1, 1), exponent);
    const double t = random_between(random, -3, 3), s = random_between(random, -3, 3);
    close_up(dim, s, t, x);
}

static void far(int dim, uint64_t *random, double x[4][3]) {
    const int64_t most = 1 + random_below(random, 30);
    for (int d = 0; d < dim; d++) {
        const int exponent = exponent_between(random, -900, 900);
        for (int j = 0; j <= dim; j++)
            x[j][d] = ldexp(0x1p52 + integer(random, most), exponent);
    }
}

static void together(int dim, uint64_t *random, double x[4][3]) {
    const int exponent = exponent_between(random, -1000, 1000);
    for (int j = 0; j <= dim; j++) {
        const int64_t like = random_below(random, j + 1);
        for (int d = 0; d < dim; d++)
            x[j][d] = like < j && random_below(random, 4) > 0 ? x[like][d]
                                                              : ldexp(mantissa(random), exponent);
    }
    for (int i = exponent_between(random, 0, 3); i > 0; i--)
        change_one(dim, random, x);
}

static void thin(int dim, uint64_t *random, double x[4][3]) {
    const int size = exponent_between(random, -300, 300), most = random_below(random, 2) ? 50 : 300;
    for (int d = 0; d < dim; d++) {
        const int squeeze = d > 0 ? exponent_between(random, -most, 0) : 0;
        for (int j = 0; j <= dim; j++)
            x[j][d] = ldexp(random_between(random, -1, 1), size + squeeze);
    }
    for (int d = 1; d < dim; d++) {
        const double shear = mantissa(random);
        for (int j = 0; j <= dim; j++)
            x[j][d] += shear * x[j][d - 1];
    }
}

static void range(int dim, uint64_t *random, double x[4][3]) {
    static const int limits[][2] = {{-1074, 1023}, {-60, 60},    {-400, 400},
                                    {-1074, -960}, {1000, 1023}, {-1074, 0}};
    const int64_t which = random_below(random, 6);
    for (int j = 0; j <= dim; j++)
        for (int d = 0; d < dim; d++) {
            const int exponent = exponent_between(random, limits[which][0], limits[which][1]);
            const int repeats = j > 0 && random_below(random, 3) == 0;
            x[j][d] = repeats ? x[j - 1][d] : ldexp(mantissa(random), exponent);
        }
}

static void subnormal(int dim, uint64_t *random, double x[4][3]) {
    const int64_t most = INT64_C(1) << exponent_between(random, 0, 50);
    for (int j = 0; j <= dim; j++)
        for (int d = 0; d < dim; d++)
            x[j][d] = ldexp(integer(random, most), -1074);
    if (random_below(random, 2)) {
        const double t = integer(random, 3), s = integer(random, 3);
        close_up(dim, s, t, x);
    }
}

/** Edges from vertex 0 of sizes whose product is about 2^-1074 of the largest's power. */
static void underflow(int dim, uint64_t *random, double x[4][3]) {
    const int lost = exponent_between(random, -1090, -1060);
    const int part = dim == 3 ? exponent_between(random, lost, 0) : 0;
    const int size[3] = {0, part, lost - part};
    const int up = exponent_between(random, 0, 900);
    for (int j = 1; j <= dim; j++) {
        const int exponent = dim == 3 ? size[j - 1] : j == 2 ? lost : 0;
        for (int d = 0; d < dim; d++)
            x[j][d] = ldexp(integer(random, 12) / 10, exponent + up);
    }
}

static void overflow(int dim, uint64_t *random, double x[4][3]) {
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            x[j][d] = random_below(random, 2) ? copysign(DBL_MAX, integer(random, 1) - 0.5)
                                              : ldexp(mantissa(random), 1023);
    const int64_t like = random_below(random, dim);
    for (int d = 0; d < dim; d++)
        x[dim][d] = random_below(random, 3) ? x[like][d] : -x[like][d];
    change_one(dim, random, x);
}

static void shuffle(int dim, uint64_t *random, double x[4][3]) {
    for (int j = dim; j > 0; j--) {
        const int64_t other = random_below(random, j + 1);
        double kept[3];
        memcpy(kept, x[j], sizeof kept);
        memcpy(x[j], x[other], sizeof kept);
        memcpy(x[other], kept, sizeof kept);
    }
}

void degenerate_draw(degenerate_kind kind, int dim, uint64_t *random, double x[4][3]) {
    static void (*const draw[DEGENERATE_KINDS])(int, uint64_t *, double[4][3]) = {
        flat, flat, rounded, far, together, thin, range, subnormal, underflow, overflow};
    memset(x, 0, 12 * sizeof(double));
    draw[kind](dim, random, x);
    if (kind == DEGENERATE_ONE_UNIT)
        change_one(dim, random, x);
    if (random_below(random, 2))
        shuffle(dim, random, x);
}
