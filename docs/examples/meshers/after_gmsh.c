/* after_gmsh: mesh a geometry with Gmsh's C API, smooth in memory, put the coordinates back, write.
 *
 *   cc after_gmsh.c -o after_gmsh $(pkg-config --cflags --libs planish) -lgmsh
 *   ./after_gmsh IN.geo OUT.msh [SIZE_FACTOR [ALGORITHM]]     ALGORITHM: Mesh.Algorithm3D, 10 is HXT
 */
#include <gmshc.h>
#include <planish/planish.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static double now(void) {
    struct timespec t;
    timespec_get(&t, TIME_UTC);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void show(const char *when, const planish_quality *q, double seconds) {
    printf("%-7s %ld elements, worst RR %.4g, angles %.4g to %.5g, RMS of RR %.4f, %.3f s\n", when,
           (long)q->n_elements, q->max_radius_ratio, q->min_angle_deg, q->max_angle_deg,
           q->rms_radius_ratio, seconds);
}

int main(int argc, char **argv) {
    size_t *tag, *inner, *cell, *corners, n, n_inner, n_elements, n_corners, k, last = 0;
    double *xyz, *other;
    int error;
    if (argc < 3)
        return fprintf(stderr, "usage: after_gmsh IN.geo OUT.msh [SIZE_FACTOR [ALGORITHM]]\n"), 64;
    gmshInitialize(0, NULL, 0, &error);
    gmshOptionSetNumber("General.Verbosity", 1, &error);
    gmshOptionSetNumber("General.NumThreads", 1, &error);
    gmshOpen(argv[1], &error);
    gmshOptionSetNumber("Mesh.Optimize", 1, &error);
    gmshOptionSetNumber("Mesh.MeshSizeFactor", argc > 3 ? atof(argv[3]) : 1, &error);
    gmshOptionSetNumber("Mesh.Algorithm3D", argc > 4 ? atof(argv[4]) : 1, &error);
    double begin = now();
    gmshModelMeshGenerate(3, &error);
    const double meshing = now() - begin;
    gmshModelMeshGetNodes(&tag, &n, &xyz, &k, &other, &k, -1, -1, 0, 0, &error);
    gmshModelMeshGetNodes(&inner, &n_inner, &other, &k, &other, &k, 3, -1, 0, 0, &error);
    gmshModelMeshGetElementsByType(4, &cell, &n_elements, &corners, &n_corners, -1, 0, 1, &error);
    if (error || n_elements == 0)
        return fprintf(stderr, "%s: Gmsh made no tetrahedra\n", argv[1]), 2;

    /* Gmsh's tags are any numbers, planish's nodes are 0 .. n - 1. Nodes of surfaces stay. */
    for (size_t i = 0; i < n; i++)
        last = tag[i] > last ? tag[i] : last;
    int64_t *index = calloc(last + 1, sizeof *index), *element = calloc(n_corners, sizeof *element);
    uint8_t *constraint = calloc(n, 1);
    for (size_t i = 0; i < n; constraint[i++] = PLANISH_CONSTRAINT_FIXED)
        index[tag[i]] = (int64_t)i;
    for (size_t i = 0; i < n_inner; i++)
        constraint[index[inner[i]]] = PLANISH_CONSTRAINT_FREE;
    for (size_t i = 0; i < n_corners; i++)
        element[i] = index[corners[i]];

    planish_mesh mesh = {.dim = 3, .coordinates = xyz, .elements64 = element};
    mesh.n_nodes = (int64_t)n;
    mesh.n_elements = (int64_t)n_elements;
    mesh.constraint = constraint;
    planish_quality before, after;
    planish_error failure;
    planish_plan *plan = NULL;
    planish_measure_mesh(&mesh, NULL, &before, &failure);
    begin = now();
    if (planish_plan_create(&mesh, NULL, &plan, &failure) ||
        planish_smooth(plan, xyz, NULL, NULL, &failure))
        return fprintf(stderr, "planish: %s\n", failure.text), 2;
    const double smoothing = now() - begin;
    planish_measure(plan, xyz, &after, &failure);
    planish_plan_destroy(plan);
    show("before", &before, meshing);
    show("after", &after, smoothing);
    for (size_t i = 0; i < n_inner; i++)
        gmshModelMeshSetNode(inner[i], xyz + 3 * index[inner[i]], 3, NULL, 0, &error);
    gmshWrite(argv[2], &error);
    return error ? 2 : 0;
}
