/* bench_cells: millions of elements per second by type, as JSON.
 *
 *   bench_cells [ELEMENTS [REPEAT]]
 *
 * certificate: coefficients of det J and the verdict of a block that is in the cache. measure: all of
 * planish_measure_cells on a block of elements that share their nodes, on one thread. Elements of a
 * type are the cells of a grid, pushed about by 5 per cent, so that those of second order are curved.
 * Each figure is the best of the repeats.
 */
#include "common.h"
#include "quality/validity.h"

#include <planish/planish.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { LANES = PL_JACOBIAN_LANES };

static const int TYPES[] = {
    PLANISH_CELL_TRIANGLE,       PLANISH_CELL_TRIANGLE6,      PLANISH_CELL_QUADRILATERAL,
    PLANISH_CELL_QUADRILATERAL8, PLANISH_CELL_QUADRILATERAL9, PLANISH_CELL_TETRAHEDRON,
    PLANISH_CELL_TETRAHEDRON10,  PLANISH_CELL_HEXAHEDRON,     PLANISH_CELL_HEXAHEDRON20,
    PLANISH_CELL_HEXAHEDRON27,   PLANISH_CELL_WEDGE,          PLANISH_CELL_WEDGE15,
    PLANISH_CELL_WEDGE18,        PLANISH_CELL_PYRAMID,
};
enum { N_TYPES = sizeof TYPES / sizeof *TYPES };

/** CPU time: one thread works, and others may disturb it. */
static double least(double a, double b) {
    return b == 0 || a < b ? a : b;
}

/** Number from -0.05 to 0.05 that depends on i alone. */
static double push(int64_t i) {
    const uint64_t bits = (uint64_t)(i + 1) * UINT64_C(0x9e3779b97f4a7c15);
    return 0.1 * ((double)((bits ^ bits >> 29) >> 11 & 0xfffff) * 0x1p-20 - 0.5);
}

/** Place of node i of a type's reference element, times 2. */
static void place_of(const pl_cell_type *type, int i, int place[3]) {
    const pl_cell_shape *shape = type->shape;
    for (int d = 0; d < 3; d++)
        place[d] = 0;
    for (int end = 0; end < 2; end++) {
        const int c = type->between[i][end];
        if (shape->n_simplices == 0) { /* pyramid; its apex is above a corner */
            place[0] += c == 1 || c == 2;
            place[1] += c == 2 || c == 3;
            place[2] += c == 4;
        }
        for (int s = 0, d = 0; s < shape->n_simplices; d += shape->n_vertices[s++] - 1)
            if (shape->vertex[c][s] > 0)
                place[d + shape->vertex[c][s] - 1]++;
    }
}

/** A mesh of elements of one type, one in each cell of a grid. */
typedef struct grid {
    int dim;
    int64_t n_nodes;
    planish_cells cells;
    double *coordinates;
} grid;

static grid grid_of(const pl_cell_type *type, int64_t wanted) {
    grid g = {.dim = type->shape->dim};
    int64_t side = 1;
    while ((g.dim == 3 ? side * side * side : side * side) < wanted)
        side++;
    const int64_t row = 2 * side + 1, n = g.dim == 3 ? side * side * side : side * side;
    uint8_t *types = bench_room(n, 1);
    int64_t *offset = bench_room(n + 1, sizeof *offset);
    int32_t *node = bench_room(n * type->n_nodes, sizeof *node);
    g.n_nodes = g.dim == 3 ? row * row * row : row * row;
    g.coordinates = bench_room(g.n_nodes * g.dim, sizeof *g.coordinates);
    for (int64_t i = 0; i < g.n_nodes; i++) {
        const int64_t at[3] = {i % row, i / row % row, i / row / row};
        for (int d = 0; d < g.dim; d++)
            g.coordinates[i * g.dim + d] = 0.5 * (double)at[d] + push(i * g.dim + d);
    }
    for (int64_t e = 0; e <= n; e++)
        offset[e] = e * type->n_nodes;
    for (int64_t e = 0; e < n; e++) {
        const int64_t at[3] = {e % side, e / side % side, e / side / side};
        types[e] = type->type;
        for (int i = 0; i < type->n_nodes; i++) {
            int place[3];
            place_of(type, i, place);
            const int64_t above = g.dim == 3 ? 2 * at[2] + place[2] : 0;
            node[offset[e] + i] =
                (int32_t)((above * row + 2 * at[1] + place[1]) * row + 2 * at[0] + place[0]);
        }
    }
    g.cells = (planish_cells){.n = n, .type = types, .offset = offset, .node = node};
    return g;
}

static void free_grid(const grid *g) {
    free((void *)(uintptr_t)g->cells.type);
    free((void *)(uintptr_t)g->cells.offset);
    free((void *)(uintptr_t)g->cells.node);
    free(g->coordinates);
}

/** Seconds of the certificates of n blocks. */
static double time_certificate(const pl_jacobian_rule *rule, const grid *g, int64_t n) {
    static pl_jacobian_block b;
    double sign[LANES];
    volatile int64_t n_valid = 0; /* somebody wants it */
    for (int l = 0; l < LANES; l++) {
        const int32_t *node = g->cells.node + g->cells.offset[l % g->cells.n];
        sign[l] = 1;
        for (int i = 0; i < rule->n_nodes; i++)
            for (int d = 0; d < g->dim; d++)
                b.x[i][d][l] =
                    g->coordinates[(int64_t)node[i] * g->dim + d] -
                    (rule->n_control_terms ? g->coordinates[(int64_t)node[0] * g->dim + d] : 0);
    }
    const double begin = bench_seconds(CLOCK_PROCESS_CPUTIME_ID);
    for (int64_t block = 0; block < n; block++) {
        pl_jacobian_evaluate(rule, sign, &b);
        for (int l = 0; l < LANES; l++) {
            const int32_t *node = g->cells.node + g->cells.offset[l % g->cells.n];
            n_valid += pl_validity_of_lane(rule, &b, l, node, g->coordinates, 1) == PL_VALID;
        }
    }
    return bench_seconds(CLOCK_PROCESS_CPUTIME_ID) - begin;
}

int main(int argc, char **argv) {
    const int64_t wanted = argc > 1 ? atoll(argv[1]) : 100000;
    const int repeat = argc > 2 ? atoi(argv[2]) : 5;
    static pl_jacobian_rule rule;
    if (argc > 3 || wanted < 1 || wanted > 1000000) {
        fprintf(stderr, "usage: bench_cells [ELEMENTS [REPEAT]]; at most 1000000 elements\n");
        return 64;
    }
    printf("{ \"planish\": \"%s\",\n  \"million_elements_per_second\": [", planish_version());
    for (int k = 0; k < N_TYPES; k++) {
        const pl_cell_type *type = pl_cell_type_of(TYPES[k]);
        const grid g = grid_of(type, wanted);
        const int64_t n_blocks = (g.cells.n + LANES - 1) / LANES;
        const planish_mesh mesh = {.dim = g.dim,
                                   .n_nodes = g.n_nodes,
                                   .n_elements = g.cells.n,
                                   .coordinates = g.coordinates,
                                   .cells = &g.cells};
        planish_cell_quality quality;
        planish_error error;
        double certificate = 0, measure = 0;
        pl_jacobian_rule_make(type, &rule);
        for (int r = 0; r < repeat; r++) {
            certificate = least(time_certificate(&rule, &g, n_blocks), certificate);
            const double begin = bench_seconds(CLOCK_PROCESS_CPUTIME_ID);
            if (planish_measure_cells(&mesh, 0, 1, &quality, NULL, &error)) {
                fprintf(stderr, "bench_cells: %s\n", error.text);
                return 2;
            }
            measure = least(bench_seconds(CLOCK_PROCESS_CPUTIME_ID) - begin, measure);
        }
        printf(
            "%s\n    { \"type\": \"%s\", \"elements\": %lld, \"invalid\": %lld, \"curved\": %lld, "
            "\"certificate\": %.2f, \"measure\": %.2f }",
            k ? "," : "", type->name, (long long)g.cells.n, (long long)quality.all.n_inverted,
            (long long)quality.all.n_curved, 1e-6 * LANES * (double)n_blocks / certificate,
            1e-6 * (double)g.cells.n / measure);
        free_grid(&g);
    }
    printf(" ]\n}\n");
    return fflush(stdout) ? 2 : 0;
}
