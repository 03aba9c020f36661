/* swing: a cylinder swings across a channel, and the mesh of the channel follows. One plan, one call for each step.
 *
 *   cc -O2 swing.c -o swing $(pkg-config --cflags --libs planish) -lm
 *   ./swing [STEPS] [RAYS] >swing.csv
 *
 * A step moves the nodes of the cylinder by up to several elements. All other nodes stay, so that elements
 * turn over. planish_smooth untangles and smooths in place. Each line of the table is a step: time in swings,
 * inverted elements before and after the call, worst radius ratio and RMS after the call, RMS of the first
 * mesh smoothed for this position, sweeps, and seconds. */
#include <planish/planish.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define LENGTH 4.0 /* of the channel */
#define HEIGHT 2.0
#define RADIUS 0.25 /* of the cylinder, which starts in the middle at x = 1 */
#define REACH  0.6  /* amplitude of the swing, to each side */

enum { STEPS_OF_A_SWING = 50 };

/** The mesh: rings of nodes from the cylinder to the walls, [rings][rays]. */
typedef struct channel {
    int rays, rings; /* rays: a multiple of 12, so that corners of the channel have nodes */
    double *xy;
    int32_t *triangles;
} channel;

/** Find the end of a ray on the walls. Ends are equally spaced around the channel, beginning at a corner. */
static void find_wall(int ray, int rays, double xy[2]) {
    double s = 2 * (LENGTH + HEIGHT) * ray / rays;
    const int side = s < LENGTH ? 0 : s < LENGTH + HEIGHT ? 1 : s < 2 * LENGTH + HEIGHT ? 2 : 3;
    s -= side > 0 ? LENGTH : 0;
    s -= side > 1 ? HEIGHT : 0;
    s -= side > 2 ? LENGTH : 0;
    xy[0] = side == 0 ? s : side == 1 ? LENGTH : side == 2 ? LENGTH - s : 0;
    xy[1] = side == 0 ? 0 : side == 1 ? s : side == 2 ? HEIGHT : HEIGHT - s;
}

/** Put the nodes on their rays, closer together at the cylinder. */
static void place_nodes(const channel *c) {
    for (int ray = 0; ray < c->rays; ray++) {
        double wall[2];
        find_wall(ray, c->rays, wall);
        const double x = wall[0] - 1, y = wall[1] - HEIGHT / 2, length = hypot(x, y);
        for (int ring = 0; ring < c->rings; ring++) {
            const double t = (double)ring / (c->rings - 1), part = t * (0.3 + 0.7 * t);
            const double r = RADIUS + (length - RADIUS) * part;
            double *xy = c->xy + 2 * ((int64_t)ring * c->rays + ray);
            xy[0] = ring + 1 < c->rings ? 1 + x / length * r : wall[0];
            xy[1] = ring + 1 < c->rings ? HEIGHT / 2 + y / length * r : wall[1];
        }
    }
}

/** Cut the quadrilateral between two rays and two rings into two triangles. */
static void list_triangles(const channel *c) {
    int32_t *to = c->triangles;
    for (int ring = 0; ring + 1 < c->rings; ring++)
        for (int ray = 0; ray < c->rays; ray++) {
            const int32_t next = (ray + 1) % c->rays;
            const int32_t a = ring * c->rays + ray, b = ring * c->rays + next;
            const int32_t corners[6] = {a, a + c->rays, b + c->rays, a, b + c->rays, b};
            for (int i = 0; i < 6; i++)
                *to++ = corners[i];
        }
}

/** Move the cylinder to where it is after some steps. */
static void move_cylinder(const channel *c, int step, double *height) {
    const double to = REACH * sin(2 * 3.14159265358979 * step / STEPS_OF_A_SWING);
    for (int ray = 0; ray < c->rays; ray++)
        c->xy[2 * ray + 1] += to - *height;
    *height = to;
}

static int quit(const planish_error *error) {
    fprintf(stderr, "swing: %s\n", error->text);
    return 1;
}

static int swing(const channel *c, planish_plan *plan, int steps) {
    planish_quality moved;
    planish_result result;
    planish_error error;
    planish_options options;
    double height = 0;
    planish_options_init(&options);
    options.max_sweeps = 30; /* the next step moves everything again */
    printf("swings,turned_over,left,worst,rms,sweeps,seconds\n");
    for (int step = 0; step <= steps; step++) {
        move_cylinder(c, step, &height);
        if (planish_measure(plan, c->xy, &moved, &error) ||
            planish_smooth(plan, c->xy, &options, &result, &error))
            return quit(&error);
        planish_quality now;
        if (planish_measure(plan, c->xy, &now, &error))
            return quit(&error);
        printf("%.2f,%ld,%ld,%.3f,%.4f,%d,%.5f\n", (double)step / STEPS_OF_A_SWING,
               (long)moved.n_inverted, (long)now.n_inverted, now.max_radius_ratio,
               now.rms_radius_ratio, result.sweeps, result.seconds);
    }
    return 0;
}

int main(int argc, char **argv) {
    const int steps = argc > 1 ? atoi(argv[1]) : 2 * STEPS_OF_A_SWING;
    channel c = {.rays = argc > 2 ? atoi(argv[2]) / 12 * 12 : 120};
    if (steps < 1 || c.rays < 12 || c.rays > 12000) {
        fprintf(stderr, "usage: swing [STEPS] [RAYS: 12 to 12000]\n");
        return 64;
    }
    c.rings = c.rays / 4;
    const int64_t n_nodes = (int64_t)c.rays * c.rings, n = 2 * (n_nodes - c.rays);
    c.xy = malloc((size_t)(2 * n_nodes) * sizeof *c.xy);
    c.triangles = malloc((size_t)(3 * n) * sizeof *c.triangles);
    planish_plan *plan = NULL;
    planish_error error = {.text = "out of memory"};
    int status = 1;
    if (c.xy && c.triangles) {
        place_nodes(&c);
        list_triangles(&c);
        const planish_mesh mesh = {.dim = 2,
                                   .n_nodes = n_nodes,
                                   .n_elements = n,
                                   .coordinates = c.xy,
                                   .elements = c.triangles};
        status = planish_plan_create(&mesh, NULL, &plan, &error);
    }
    status = status ? quit(&error) : swing(&c, plan, steps);
    planish_plan_destroy(plan);
    free(c.xy);
    free(c.triangles);
    return status;
}
