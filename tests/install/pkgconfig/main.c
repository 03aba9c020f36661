/* A program in C: finds the library by pkg-config, smooths a double pyramid whose inner node is off
 * its centre, and prints where it comes to. */
#include <planish/planish.h>

#include <stdio.h>

int main(void) {
    double xyz[] = {1, 0, 0, 0, 1, 0, -1, 0, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0.3, 0.2, 0.1};
    const int32_t tetrahedra[] = {0, 1, 4, 6, 1, 2, 4, 6, 2, 3, 4, 6, 3, 0, 4, 6,
                                  1, 0, 5, 6, 2, 1, 5, 6, 3, 2, 5, 6, 0, 3, 5, 6};
    const planish_mesh mesh = {
        .dim = 3, .n_nodes = 7, .n_elements = 8, .coordinates = xyz, .elements = tetrahedra};
    planish_plan *plan = NULL;
    planish_result result;
    planish_error error;
    int status = planish_plan_create(&mesh, NULL, &plan, &error);
    if (status == 0)
        status = planish_smooth(plan, xyz, NULL, &result, &error);
    planish_plan_destroy(plan);
    if (status) {
        fprintf(stderr, "%s\n", error.text);
        return 1;
    }
    printf("planish %s: RMS %.4f -> %.4f\n", planish_version(), result.objective_before,
           result.objective);
    return !(result.objective < result.objective_before && result.n_moved_nodes == 1);
}
