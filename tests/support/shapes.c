/* shapes: elements from regular to nearly degenerate. */
#include "support/shapes.h"

#include "support/effort.h"

#include <math.h>
#include <string.h>

const char *const shape_name[SHAPE_KINDS] = {"regular", "sliver",  "cap",      "spade", "wedge",
                                             "needle",  "spindle", "splinter", "flat"};

static const double REGULAR[2][4][3] = {{{0, 0}, {1, 0}, {0.5, 0.8660254037844386}},
                                        {{0, 0, 0},
                                         {1, 0, 0},
                                         {0.5, 0.8660254037844386, 0},
                                         {0.5, 0.2886751345948129, 0.816496580927726}}};
static const double SQUARE[4][3] = {{-1, 0, 0}, {0, -1, 0}, {1, 0, 0}, {0, 1, 0}};

static double about(uint64_t *random, double amount) {
    return random_between(random, -amount, amount);
}

/** Vertex i to a mean of the first n others, by weights, and thin away from it. */
static void bring_near(int dim, int i, int n, double thin, uint64_t *random, double x[4][3]) {
    double weight[3], sum = 0, mean[3] = {0};
    for (int j = 0; j < n; j++)
        sum += weight[j] = random_between(random, 0.2, 1);
    for (int j = 0; j < n; j++)
        for (int d = 0; d < dim; d++)
            mean[d] += weight[j] / sum * x[(i + 1 + j) % (dim + 1)][d];
    for (int d = 0; d < dim; d++)
        x[i][d] = mean[d] + thin * about(random, 1);
}

static void squeeze(int dim, int d, double thin, double x[4][3]) {
    for (int j = 0; j <= dim; j++)
        x[j][d] *= thin;
}

static void start(shape_kind kind, int dim, double thin, uint64_t *random, double x[4][3]) {
    const int folded = kind == SHAPE_SLIVER && dim == 3;
    for (int j = 0; j <= dim; j++)
        for (int d = 0; d < dim; d++)
            x[j][d] = folded                  ? SQUARE[j][d]
                      : kind == SHAPE_FLAT    ? about(random, 1)
                      : kind == SHAPE_REGULAR ? REGULAR[dim - 2][j][d] + about(random, 0.1)
                                              : REGULAR[dim - 2][j][d] + about(random, 0.2);
    for (int j = 0; folded && j < 4; j++)
        for (int d = 0; d < 3; d++)
            x[j][d] += about(random, thin);
}

static void spoil(shape_kind kind, int dim, double thin, uint64_t *random, double x[4][3]) {
    if (kind == SHAPE_CAP)
        bring_near(dim, 0, dim, thin, random, x);
    if (kind == SHAPE_SPADE)
        bring_near(dim, 0, 2, thin, random, x);
    if (kind == SHAPE_WEDGE || kind == SHAPE_SPINDLE || (kind == SHAPE_SLIVER && dim == 2))
        bring_near(dim, 0, 1, thin, random, x);
    if (kind == SHAPE_SPINDLE && dim == 3)
        bring_near(dim, 2, 1, thin * random_unit(random), random, x);
    for (int j = 0; kind == SHAPE_NEEDLE && j < dim - 1; j++)
        bring_near(dim, dim - 2 - j, 1, thin, random, x);
    if (kind == SHAPE_FLAT)
        squeeze(dim, dim - 1, thin, x);
    for (int d = 1; kind == SHAPE_SPLINTER && d < dim; d++)
        squeeze(dim, d, d == 1 ? thin : thin * random_unit(random), x);
}

/** By Givens rotations. */
static void turn(int dim, uint64_t *random, double x[4][3]) {
    for (int k = 0; k < (dim == 3 ? 3 : 1); k++) {
        const double angle = about(random, 4), c = cos(angle), s = sin(angle);
        const int i = k % dim, l = (k + 1) % dim;
        for (int j = 0; j <= dim; j++) {
            const double xi = x[j][i], xl = x[j][l];
            x[j][i] = c * xi - s * xl;
            x[j][l] = s * xi + c * xl;
        }
    }
}

shape_place shape_place_draw(uint64_t *random, int most_size) {
    const int plain = random_below(random, 2) == 0;
    return (shape_place){.turned = random_below(random, 3) > 0,
                         .size = plain ? 0 : (int)random_below(random, 2 * most_size) - most_size,
                         .far = plain ? 0 : exp2(random_between(random, -1, 20)) - 0.5};
}

void shape_draw(shape_kind kind, int dim, double thin, const shape_place *place, uint64_t *random,
                double x[4][3]) {
    memset(x, 0, 12 * sizeof(double));
    start(kind, dim, thin, random, x);
    spoil(kind, dim, thin, random, x);
    if (place->turned)
        turn(dim, random, x);
    for (int d = 0; d < dim; d++) {
        const double there = about(random, 1) * place->far;
        for (int j = 0; j <= dim; j++)
            x[j][d] = ldexp(x[j][d] + there, place->size);
    }
    for (int j = dim; j > 0; j--) {
        const int64_t other = random_below(random, j + 1);
        double kept[3];
        memcpy(kept, x[j], sizeof kept);
        memcpy(x[j], x[other], sizeof kept);
        memcpy(x[other], kept, sizeof kept);
    }
}
