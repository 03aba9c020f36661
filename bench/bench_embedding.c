/* bench_embedding: cost of a call for a mesher that makes many small calls.
 *
 *   bench_embedding MESH [REPEAT]
 *
 * Print two tables. First small boxes, each with its own plan and again with the same plan. Then
 * patches of MESH (tetrahedra) around one node, found from neighbour to neighbour, and by passes.
 */
#include "common.h"

#include <planish/planish_io.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void quit(const char *what) {
    fprintf(stderr, "bench_embedding: %s\n", what);
    exit(1);
}

static double least(double a, double b) {
    return b < a ? b : a;
}

/** Best times of a plan, of the plan and its first call, and of a second one. */
typedef struct times {
    double plan, all, again;
    int64_t n_elements; /* of the plan */
} times;

static times measure(const planish_mesh *mesh, const planish_options *options, int repeat) {
    const size_t bytes = (size_t)(mesh->n_nodes * mesh->dim) * sizeof(double);
    double *x = bench_room(mesh->n_nodes * mesh->dim, sizeof *x);
    times best = {1e9, 1e9, 1e9, 0};
    for (int i = 0; i < repeat; i++) {
        planish_plan *plan;
        planish_error error;
        planish_quality quality;
        memcpy(x, mesh->coordinates, bytes);
        const double begin = bench_seconds(CLOCK_MONOTONIC);
        if (planish_plan_create(mesh, options, &plan, &error))
            quit(error.text);
        const double planned = bench_seconds(CLOCK_MONOTONIC);
        if (planish_smooth(plan, x, options, NULL, &error))
            quit(error.text);
        const double smoothed = bench_seconds(CLOCK_MONOTONIC);
        memcpy(x, mesh->coordinates, bytes);
        const double once_more = bench_seconds(CLOCK_MONOTONIC);
        if (planish_smooth(plan, x, options, NULL, &error))
            quit(error.text);
        best.again = least(best.again, bench_seconds(CLOCK_MONOTONIC) - once_more);
        best.plan = least(best.plan, planned - begin);
        best.all = least(best.all, smoothed - begin);
        if (planish_measure(plan, x, &quality, &error))
            quit(error.text);
        best.n_elements = quality.n_elements;
        planish_plan_destroy(plan);
    }
    free(x);
    return best;
}

/* ---- small boxes ----------------------------------------------------------------------------- */

/** Nodes and elements of a box of cells[0] x cells[1] x cells[2] cubes of 6 tetrahedra each, inner
 *  nodes off their places. */
static planish_mesh make_box(const int *cells) {
    static const int order[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                    {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    const int64_t step[3] = {(int64_t)(cells[1] + 1) * (cells[2] + 1), cells[2] + 1, 1};
    const int64_t n = step[0] * (cells[0] + 1), m = (int64_t)6 * cells[0] * cells[1] * cells[2];
    double *x = bench_room(3 * n, sizeof *x);
    int32_t *elements = bench_room(4 * m, sizeof *elements);
    unsigned random = 1;
    for (int64_t i = 0; i < n; i++) {
        const int64_t at[3] = {i / step[0], i / step[1] % (cells[1] + 1), i % (cells[2] + 1)};
        int inside = 1;
        for (int d = 0; d < 3; d++)
            inside &= at[d] > 0 && at[d] < cells[d];
        for (int d = 0; d < 3; d++) {
            random = random * 1664525u + 1013904223u;
            x[3 * i + d] = (double)at[d] + (inside ? 0.28 * (random / 4294967296.0 - 0.5) : 0);
        }
    }
    int64_t e = 0;
    for (int64_t c = 0; c < n; c++) {
        if (c / step[0] == cells[0] || c / step[1] % (cells[1] + 1) == cells[1] ||
            c % (cells[2] + 1) == cells[2])
            continue;
        for (int k = 0; k < 6; k++, e++) {
            int64_t node = c;
            elements[4 * e] = (int32_t)node;
            for (int j = 0; j < 3; j++)
                elements[4 * e + j + 1] = (int32_t)(node += step[order[k][j]]);
        }
    }
    return (planish_mesh){
        .dim = 3, .n_nodes = n, .n_elements = m, .coordinates = x, .elements = elements};
}

static void small_boxes(int repeat) {
    static const int boxes[][3] = {{3, 3, 3}, {4, 5, 5}, {7, 7, 7}, {12, 12, 12}};
    planish_options options;
    planish_options_init(&options);
    printf("| tetrahedra | plan ms | plan and first call ms | second call ms |\n"
           "| --: | --: | --: | --: |\n");
    for (size_t i = 0; i < sizeof boxes / sizeof boxes[0]; i++) {
        const planish_mesh mesh = make_box(boxes[i]);
        const times t = measure(&mesh, &options, repeat);
        printf("| %lld | %.3f | %.3f | %.3f |\n", (long long)mesh.n_elements, 1e3 * t.plan,
               1e3 * t.all, 1e3 * t.again);
        free((void *)mesh.coordinates);
        free((void *)mesh.elements);
    }
}

/* ---- patches --------------------------------------------------------------------------------- */

typedef struct side {
    int32_t node[3], at; /* ascending nodes of the facet; 4 * element + corner */
} side;

static int compare_sides(const void *a, const void *b) {
    const int32_t *p = ((const side *)a)->node, *q = ((const side *)b)->node;
    for (int i = 0; i < 3; i++)
        if (p[i] != q[i])
            return p[i] < q[i] ? -1 : 1;
    return 0;
}

static void exchange(int32_t *a, int32_t *b) {
    const int32_t least_one = *a < *b ? *a : *b, other = *a < *b ? *b : *a;
    *a = least_one;
    *b = other;
}

static int32_t *find_neighbours(const planish_mesh *mesh) {
    const int64_t n = 4 * mesh->n_elements;
    side *sides = bench_room(n, sizeof *sides);
    int32_t *neighbours = bench_room(n, sizeof *neighbours);
    for (int64_t i = 0; i < n; i++) {
        int32_t *v = sides[i].node;
        for (int j = 0, k = 0; j < 4; j++)
            if (j != i % 4)
                v[k++] = mesh->elements[i / 4 * 4 + j];
        exchange(&v[0], &v[1]);
        exchange(&v[1], &v[2]);
        exchange(&v[0], &v[1]);
        sides[i].at = (int32_t)i;
        neighbours[i] = -1;
    }
    qsort(sides, (size_t)n, sizeof *sides, compare_sides);
    for (int64_t i = 1; i < n; i++)
        if (compare_sides(&sides[i - 1], &sides[i]) == 0) {
            neighbours[sides[i - 1].at] = sides[i].at / 4;
            neighbours[sides[i].at] = sides[i - 1].at / 4;
        }
    free(sides);
    return neighbours;
}

/** A node inside, and an element of it: the first free one behind the middle of the mesh. */
static void choose(const planish_mesh *mesh, int64_t *node, int64_t *element) {
    planish_plan *plan;
    planish_error error;
    uint8_t *is_free = bench_room(mesh->n_nodes, 1);
    if (planish_plan_create(mesh, NULL, &plan, &error))
        quit(error.text);
    planish_plan_get_free(plan, is_free);
    planish_plan_destroy(plan);
    int64_t i = 2 * mesh->n_elements;
    while (i < 4 * mesh->n_elements && !is_free[mesh->elements[i]])
        i++;
    if (i == 4 * mesh->n_elements)
        quit("no node inside of the mesh");
    *node = mesh->elements[i];
    *element = i / 4;
    free(is_free);
}

static void patches(const char *path, int repeat) {
    planish_file *file;
    planish_error error;
    if (planish_file_open(path, NULL, 0, &file, &error))
        quit(error.text);
    planish_mesh mesh = planish_file_mesh(file);
    if (mesh.dim != 3 || mesh.cells)
        quit("a mesh of straight tetrahedra is wanted");
    int32_t *neighbours = find_neighbours(&mesh);
    int64_t node, element;
    choose(&mesh, &node, &element);
    planish_options options;
    planish_options_init(&options);
    options.around = &node;
    options.n_around = 1;
    printf("\nA node of a mesh of %lld tetrahedra, and rings around it:\n\n"
           "| rings | tetrahedra looked at | with neighbours ms | without ms |\n"
           "| --: | --: | --: | --: |\n",
           (long long)mesh.n_elements);
    for (int rings = 0; rings < 4; rings++) {
        options.rings = rings;
        options.around_elements = &element;
        mesh.neighbours = neighbours;
        const times walk = measure(&mesh, &options, repeat);
        options.around_elements = NULL;
        mesh.neighbours = NULL;
        const times passes = measure(&mesh, &options, repeat / 10 + 1);
        printf("| %d | %lld | %.3f | %.3f |\n", rings, (long long)walk.n_elements, 1e3 * walk.all,
               1e3 * passes.all);
    }
    free(neighbours);
    planish_file_close(file);
}

int main(int argc, char **argv) {
    const int repeat = argc > 2 ? atoi(argv[2]) : 100;
    if (argc < 2 || repeat < 1) {
        fprintf(stderr, "usage: bench_embedding MESH [REPEAT]\n");
        return 64;
    }
    small_boxes(repeat);
    patches(argv[1], repeat);
    return 0;
}
