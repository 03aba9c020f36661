/* Load the library at argv[1], smooth with four threads, unload it, and do that once more. The threads wait
 * for work longer than that takes. */
#include <planish/planish.h>

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { N = 200 }; /* nodes of a side: enough for threads */

/** Make a square of triangles whose inner nodes are pushed. */
static planish_mesh make_mesh(double *xy, int32_t *triangles) {
    int n = 0;
    for (int i = 0; i < N * N; i++) {
        const int x = i % N, y = i / N, is_inside = x % (N - 1) && y % (N - 1);
        xy[2 * i] = x + (is_inside ? 0.2 * (7 * i % 3 - 1) : 0);
        xy[2 * i + 1] = y;
        const int corner[] = {i, i + 1, i + N + 1, i, i + N + 1, i + N};
        for (int k = 0; k < 6 && x < N - 1 && y < N - 1; k++)
            triangles[n++] = corner[k];
    }
    return (planish_mesh){
        .dim = 2, .n_nodes = N * N, .n_elements = n / 3, .coordinates = xy, .elements = triangles};
}

/** Smooth with the library at path, which is loaded for that. */
static int smooth(const char *path, const planish_mesh *mesh, double *xy) {
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library)
        return fprintf(stderr, "%s\n", dlerror());
    __typeof__(&planish_options_init_sized) init = dlsym(library, "planish_options_init_sized");
    __typeof__(&planish_plan_create) create = dlsym(library, "planish_plan_create");
    __typeof__(&planish_smooth) move = dlsym(library, "planish_smooth");
    __typeof__(&planish_plan_destroy) destroy = dlsym(library, "planish_plan_destroy");
    planish_options options;
    planish_plan *plan = NULL;
    planish_error error;
    init(&options, sizeof options);
    options.threads = 4;
    if (create(mesh, &options, &plan, &error) || move(plan, xy, &options, NULL, &error))
        return fprintf(stderr, "%s\n", error.text);
    destroy(plan);
    return dlclose(library);
}

int main(int argc, char **argv) {
    const struct timespec tenth = {.tv_nsec = 100000000};
    double *xy = malloc(2 * N * N * sizeof *xy);
    int32_t *triangles = malloc(6 * N * N * sizeof *triangles);
    int status = argc != 2 || !xy || !triangles;
    for (int i = 0; i < 2 && !status; i++) {
        const planish_mesh mesh = make_mesh(xy, triangles);
        status = smooth(argv[1], &mesh, xy);
        nanosleep(&tenth, NULL);
    }
    free(xy);
    free(triangles);
    return status != 0;
}
