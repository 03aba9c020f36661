/* Discs: what is proved of a patch around a node does not depend on the order of its facets. */
#include "shape/disc.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

enum { O, A, B, C, D, E, P, Q, G, N_NODES, N_FACETS = 11 };

/* A patch around O that is plane, but for a facet that leads down to G. A way to it is found late: by the facet
 * that comes first in one order it seems to be too far away. */
static double places[N_NODES][3] = {{0, 0, 0},      {1.1, -.5, 0}, {2.2, -.6, 0},
                                    {-1.1, -.5, 0}, {0, -.2, 0},   {0, -.35, 0},
                                    {1, 1, 0},      {-1, 1, 0},    {.5, -2, -1}};
static const int32_t facets[N_FACETS][3] = {{O, A, B}, {O, D, A}, {O, B, P}, {O, P, Q},
                                            {O, Q, C}, {O, C, D}, {D, C, E}, {D, E, A},
                                            {E, C, A}, {A, C, B}, {B, C, G}};

/** The facet that has the edge from b to a; -1: none. */
static int32_t across(const int32_t (*facet)[3], int32_t a, int32_t b) {
    for (int32_t i = 0; i < N_FACETS; i++)
        for (int k = 0; k < 3; k++)
            if (facet[i][k] == b && facet[i][(k + 1) % 3] == a)
                return i;
    return -1;
}

/** Bound how far a small triangle of the plane is off the patch, with facets listed from one on. */
static double bound_of(int first) {
    static int32_t facet[N_FACETS][3], beside[N_FACETS][3], facet_of[3 * N_FACETS];
    static uint32_t offset[N_NODES + 1], normal_at[N_NODES + 1];
    static double normal[N_NODES][3];
    const double triangle[3][3] = {{-.05, -.9, 0}, {.05, -.9, 0}, {0, -.85, 0}};
    planish_shape shape = {.n_nodes = N_NODES, .n_facets = N_FACETS};
    pl_disc disc;
    pl_disc_frame frame;
    pl_disc_point p[3];
    uint32_t n = 0;
    for (int i = 0; i < N_FACETS; i++)
        memcpy(facet[i], facets[(first + i) % N_FACETS], sizeof facet[i]);
    for (int i = 0; i < N_FACETS; i++)
        for (int k = 0; k < 3; k++)
            beside[i][k] = across((const int32_t(*)[3])facet, facet[i][k], facet[i][(k + 1) % 3]);
    for (uint32_t v = 0; v < N_NODES; v++) {
        offset[v] = n;
        normal_at[v] = v;
        normal[v][2] = 1;
        for (int i = 0; i < 3 * N_FACETS; i++)
            if (facet[i / 3][i % 3] == (int32_t)v)
                facet_of[n++] = i / 3;
    }
    offset[N_NODES] = n;
    normal_at[N_NODES] = N_NODES;
    shape.x = places;
    shape.facet = facet;
    shape.across = beside;
    shape.offset = offset;
    shape.facet_of = facet_of;
    shape.normal_at = normal_at;
    shape.corner_normal = normal;
    pl_disc_find(&shape, O, &disc);
    pl_disc_set_frame(&shape, O, &disc, &frame);
    for (int k = 0; k < 3; k++)
        if (!pl_disc_see(&frame, triangle[k], &p[k]))
            return INFINITY; /* the disc is smaller: nothing is said of it */
    return pl_disc_bound(&frame, &p[0], &p[1], &p[2]);
}

/** The patch is 0.25 and more below the plane there. */
static void bounds_hold_in_any_order(void **state) {
    (void)state;
    for (int first = 0; first < N_FACETS; first++)
        assert_true(bound_of(first) > 0.25);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(bounds_hold_in_any_order)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
