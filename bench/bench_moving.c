/* bench_moving: cost of a step of a moving mesh, with one plan for all steps.
 *
 *   bench_moving MESH [STEPS]
 *
 * A step bends the boundary like a swinging string. All other nodes stay. The table on standard output has
 * steps of a tenth of a mean edge, of a mean edge and of a hundredth of the domain, by threads: means over
 * the steps. The mesh is smoothed before the first step.
 */
#include "common.h"

#include <planish/planish_io.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void quit(const char *what) {
    fprintf(stderr, "bench_moving: %s\n", what);
    exit(1);
}

/** A mesh in motion. */
typedef struct motion {
    planish_mesh mesh;
    planish_plan *plan;
    uint8_t *is_free;   /* [n_nodes] */
    double *first, *x;  /* [n_nodes][dim] smoothed; now */
    double low, length; /* of the domain along x */
    double edge;        /* mean edge of the elements */
} motion;

/** Mean of all edges of all elements. */
static double mean_edge(const planish_mesh *mesh, const double *x) {
    const int n = mesh->dim + 1, dim = mesh->dim;
    double sum = 0;
    for (int64_t i = 0; i < mesh->n_elements; i++)
        for (int j = 0; j < n; j++)
            for (int k = 0; k < j; k++) {
                const double *a = x + (int64_t)dim * mesh->elements[n * i + j];
                const double *b = x + (int64_t)dim * mesh->elements[n * i + k];
                double square = 0;
                for (int d = 0; d < dim; d++)
                    square += (a[d] - b[d]) * (a[d] - b[d]);
                sum += sqrt(square);
            }
    return sum / (double)(mesh->n_elements * n * dim / 2);
}

static motion begin(const char *path, planish_file **file) {
    planish_error error;
    if (planish_file_open(path, NULL, 0, file, &error))
        quit(error.text);
    motion m = {.mesh = planish_file_mesh(*file)};
    const int64_t n = m.mesh.n_nodes, dim = m.mesh.dim;
    if (m.mesh.cells || !m.mesh.elements)
        quit("only for meshes of triangles or tetrahedra");
    m.is_free = bench_room(n, 1);
    m.first = bench_room(n * dim, sizeof *m.first);
    m.x = bench_room(n * dim, sizeof *m.x);
    memcpy(m.first, m.mesh.coordinates, (size_t)(n * dim) * sizeof *m.first);
    if (planish_plan_create(&m.mesh, NULL, &m.plan, &error) ||
        planish_smooth(m.plan, m.first, NULL, NULL, &error))
        quit(error.text);
    planish_plan_get_free(m.plan, m.is_free);
    m.low = INFINITY;
    double high = -INFINITY;
    for (int64_t i = 0; i < n; i++) {
        m.low = fmin(m.low, m.first[dim * i]);
        high = fmax(high, m.first[dim * i]);
    }
    m.length = high - m.low;
    m.edge = mean_edge(&m.mesh, m.first);
    return m;
}

/** Bend the boundary by one step; no node goes farther than most in it. */
static void bend(motion *m, int step, double most) {
    const double pi = 3.14159265358979;
    const double a = most * (sin(0.2 * pi * step) - sin(0.2 * pi * (step - 1))) / (0.2 * pi);
    const int dim = m->mesh.dim;
    for (int64_t i = 0; i < m->mesh.n_nodes; i++)
        if (!m->is_free[i])
            m->x[dim * i + dim - 1] += a * sin(2 * pi * (m->first[dim * i] - m->low) / m->length);
}

static void measure(motion *m, const char *name, double most, int steps, int threads) {
    planish_options options;
    planish_quality moved, now = {0};
    planish_result result;
    planish_error error;
    double seconds = 0, worst = 0;
    int64_t n_turned_over = 0, n_left = 0, n_sweeps = 0;
    planish_options_init(&options);
    options.threads = threads; /* the plan's */
    planish_plan_destroy(m->plan);
    m->plan = NULL;
    if (planish_plan_create(&m->mesh, &options, &m->plan, &error))
        quit(error.text);
    memcpy(m->x, m->first, (size_t)(m->mesh.n_nodes * m->mesh.dim) * sizeof *m->x);
    for (int step = 1; step <= steps; step++) {
        bend(m, step, most);
        if (planish_measure(m->plan, m->x, &moved, &error) ||
            planish_smooth(m->plan, m->x, &options, &result, &error) ||
            planish_measure(m->plan, m->x, &now, &error))
            quit(error.text);
        seconds += result.seconds;
        n_sweeps += result.sweeps;
        n_turned_over += moved.n_inverted;
        n_left += now.n_inverted;
        worst = fmax(worst, now.max_radius_ratio);
    }
    printf("| %s | %d | %lld | %lld | %.1f | %.2f | %.3f |\n", name, threads,
           (long long)(n_turned_over / steps), (long long)n_left, (double)n_sweeps / steps, worst,
           seconds / steps);
    fflush(stdout);
}

int main(int argc, char **argv) {
    const int steps = argc > 2 ? atoi(argv[2]) : 10;
    if (argc < 2 || steps < 1)
        quit("usage: bench_moving MESH [STEPS]");
    planish_file *file;
    planish_plan_info info;
    motion m = begin(argv[1], &file);
    planish_plan_get_info(m.plan, &info);
    printf(
        "%lld elements, mean edge %.3g of a length of %.3g.\n\n"
        "| a step moves the boundary by | threads | turned over | left in all | sweeps | worst RR "
        "| s a step |\n| --- | --: | --: | --: | --: | --: | --: |\n",
        (long long)m.mesh.n_elements, m.edge, m.length);
    for (int threads = 1; threads <= info.threads; threads *= 2) {
        measure(&m, "a tenth of a mean edge", 0.1 * m.edge, steps, threads);
        measure(&m, "a mean edge", m.edge, steps, threads);
        measure(&m, "a hundredth of the domain", 0.01 * m.length, steps, threads);
    }
    planish_plan_destroy(m.plan);
    planish_file_close(file);
    free(m.is_free);
    free(m.first);
    free(m.x);
    return 0;
}
