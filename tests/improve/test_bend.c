/* The Hessian of RR^2 by the edges of tetrahedra (improve/bend.h) against differences of the reference
 * formula (geometry/simplex.h). */
#pragma GCC diagnostic ignored "-Wpsabi" /* nothing is passed: all is inlined */

#include "geometry/simplex.h"
#include "improve/bend.h"
#include "support/meshes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { EDGES = 3, LANES = 4 };

/** RR^2 of the tetrahedron with these edges from its first node. */
static double ratio_at(double e[EDGES][3]) {
    static const double ORIGIN[3] = {0, 0, 0};
    const double *vertex[] = {ORIGIN, e[0], e[1], e[2]};
    return pl_radius_ratio_square(3, vertex);
}

/** Second difference for coordinate r of edge i and c of edge j. */
static double difference_at(double e[EDGES][3], int i, int r, int j, int c) {
    const double step = 0x1p-12;
    double sum = 0;
    for (int k = 0; k < 4; k++) {
        const double a = k & 1 ? step : -step, b = k & 2 ? step : -step;
        double moved[EDGES][3];
        for (int q = 0; q < EDGES * 3; q++)
            moved[q / 3][q % 3] = e[q / 3][q % 3];
        moved[i][r] += a;
        moved[j][c] += b;
        sum += (a * b > 0 ? 1 : -1) * ratio_at(moved);
    }
    return sum / (4 * step * step);
}

/** Edges of a tetrahedron that is not flat. */
static void random_edges(unsigned *seed, double e[EDGES][3]) {
    double volume = 0;
    while (volume < 0.05) {
        for (int q = 0; q < EDGES * 3; q++)
            e[q / 3][q % 3] = 2 * test_random(seed) - 1;
        volume = fabs(pl_determinant_of_edges(3, e));
    }
}

static void blocks_are_second_derivatives(void **state) {
    static const int I[] = {0, 0, 0, 1, 1, 2}, J[] = {0, 1, 2, 1, 2, 2};
    unsigned seed = 5;
    (void)state;
    for (int k = 0; k < 100; k++) {
        double e[LANES][EDGES][3];
        bend_vector edges[EDGES];
        bend_block h[BEND_BLOCKS];
        for (int lane = 0; lane < LANES; lane++) {
            random_edges(&seed, e[lane]);
            for (int i = 0; i < EDGES; i++) {
                edges[i].x[lane] = e[lane][i][0];
                edges[i].y[lane] = e[lane][i][1];
                edges[i].z[lane] = e[lane][i][2];
            }
        }
        bend_tetrahedra(edges, h);
        for (int lane = 0; lane < LANES; lane++) {
            double largest = 0;
            for (int q = 0; q < BEND_BLOCKS * 9; q++)
                largest = fmax(largest, fabs(h[q / 9][q % 9][lane]));
            for (int q = 0; q < BEND_BLOCKS * 9; q++) {
                const double expected =
                    difference_at(e[lane], I[q / 9], q % 9 / 3, J[q / 9], q % 3);
                assert_true(fabs(h[q / 9][q % 9][lane] - expected) < 1e-3 * largest);
            }
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_are_second_derivatives),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
