/* Smooths meshes inside of a parallel region of the program's own OpenMP runtime, which may be
 * another than the library's, and outside of it; all results must have the same bits. */
#include <planish/planish.h>

#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CELLS = 60, N = (CELLS + 1) * (CELLS + 1), M = 2 * CELLS * CELLS, RUNS = 6 };

static int32_t triangles[3 * M];

static void make_triangles(void) {
    for (int i = 0, e = 0; i < N - CELLS - 1; i++) {
        const int square[4] = {i, i + CELLS + 1, i + CELLS + 2, i + 1};
        if (i % (CELLS + 1) == CELLS)
            continue;
        for (int k = 0; k < 6; k++)
            triangles[3 * e + k] = square[(int[]){0, 1, 2, 0, 2, 3}[k]];
        e += 2;
    }
}

static void make_nodes(double *xy) {
    unsigned random = 1;
    for (int i = 0; i < N; i++)
        for (int d = 0; d < 2; d++) {
            const int at = d ? i % (CELLS + 1) : i / (CELLS + 1);
            random = random * 1664525u + 1013904223u;
            xy[2 * i + d] = at + (at > 0 && at < CELLS ? 0.4 * (random / 4294967296.0 - 0.5) : 0);
        }
}

static uint64_t smooth(int threads) {
    double *xy = malloc(2 * N * sizeof *xy);
    planish_mesh mesh = {
        .dim = 2, .n_nodes = N, .n_elements = M, .coordinates = xy, .elements = triangles};
    planish_plan *plan = NULL;
    planish_options options;
    uint64_t sum = 0;
    planish_options_init(&options);
    options.threads = threads;
    make_nodes(xy);
    if (planish_plan_create(&mesh, &options, &plan, NULL) == 0 &&
        planish_smooth(plan, xy, &options, NULL, NULL) == 0)
        sum = planish_checksum(&mesh);
    planish_plan_destroy(plan);
    free(xy);
    return sum;
}

int main(void) {
    uint64_t sums[RUNS] = {0}, expected;
    make_triangles();
    expected = smooth(1);
#pragma omp parallel for num_threads(3) schedule(dynamic, 1)
    for (int i = 0; i < RUNS; i++)
        sums[i] = smooth(i % 4);
    int same = expected != 0 && smooth(0) == expected && smooth(3) == expected;
    for (int i = 0; i < RUNS; i++)
        same &= sums[i] == expected;
    printf("%s\n", same ? "same bits" : "other bits");
    return !same;
}
