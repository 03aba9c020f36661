/* halfspaces: whether half-spaces have a point in common. */
#include "support/halfspaces.h"

#include <math.h>
#include <string.h>

/* Vertices of planes that are more parallel than this are none. */
#define PARALLEL 1e-12L
/* Rounding of a vertex. */
#define ROUNDING 1e-12L

void halfspaces_add(halfspaces *h, const long double *normal, long double offset) {
    long double length = 0;
    for (int d = 0; d < h->dim; d++)
        length += normal[d] * normal[d];
    length = sqrtl(length);
    for (int d = 0; d < 3; d++)
        h->normal[h->n][d] = d < h->dim ? normal[d] / length : 0;
    h->offset[h->n++] = offset / length;
}

void halfspaces_start(halfspaces *h, int dim, long double size) {
    memset(h, 0, sizeof *h);
    h->dim = dim;
    for (int d = 0; d < dim; d++)
        for (int sign = -1; sign <= 1; sign += 2) {
            long double normal[3] = {0, 0, 0};
            normal[d] = sign;
            halfspaces_add(h, normal, -size);
        }
}

static long double determinant(long double m[3][3]) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/** The point at depth below the planes of set (Cramer); 0 if there is none. */
static int vertex(const halfspaces *h, const int *set, long double depth, long double *x) {
    long double m[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, right[3] = {0, 0, 0};
    for (int i = 0; i < h->dim; i++) {
        memcpy(m[i], h->normal[set[i]], sizeof m[i]);
        right[i] = h->offset[set[i]] + depth;
    }
    long double whole = determinant(m);
    for (int d = 0; d < 3; d++) {
        long double replaced[3][3];
        memcpy(replaced, m, sizeof m);
        for (int i = 0; i < 3; i++)
            replaced[i][d] = right[i];
        x[d] = determinant(replaced) / whole;
    }
    return fabsl(whole) > PARALLEL;
}

static int is_inside(const halfspaces *h, const long double *x, long double depth) {
    int inside = 1;
    for (int i = 0; inside && i < h->n; i++) {
        long double height = -h->offset[i] - depth;
        for (int d = 0; d < h->dim; d++)
            height += h->normal[i][d] * x[d];
        inside = height >= -ROUNDING * (1 + fabsl(h->offset[i]));
    }
    return inside;
}

int halfspaces_meet(const halfspaces *h, long double depth, long double *point) {
    int set[3];
    long double x[3];
    for (set[0] = 0; set[0] < h->n; set[0]++)
        for (set[1] = set[0] + 1; set[1] < h->n; set[1]++)
            for (set[2] = set[1] + 1; set[2] < (h->dim == 3 ? h->n : set[1] + 2); set[2]++) {
                if (!vertex(h, set, depth, x) || !is_inside(h, x, depth))
                    continue;
                if (point)
                    memcpy(point, x, sizeof x);
                return 1;
            }
    return 0;
}
