/* hubs: nodes of very many facets. What looks at pairs of facets of a node would take minutes for them. */
#include "support/effort.h"
#include "support/run.h"

#include "shape/gaps.h"
#include "shape/nearest.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { FAN = 20000, NODES = 1 + 2 * FAN, FACETS = 3 * FAN };

/** A blunt cone of one fan, with a narrow strip around. */
typedef struct cone {
    planish_mesh mesh;
    planish_cells cells;
    double x[NODES][3];
    int32_t facet[FACETS][3];
    int64_t offset[FACETS + 1];
    uint8_t type[FACETS];
} cone;

static void set_place(double x[3], double radius, double turn, double height) {
    const double pi = 3.14159265358979323846;
    x[0] = radius * cos(2 * pi * turn);
    x[1] = radius * sin(2 * pi * turn);
    x[2] = height;
}

/** Make a cone of n facets at its apex. */
static void make_cone(cone *c, int n) {
    set_place(c->x[0], 0.04, 0.1, 0.3);
    for (int i = 0; i < n; i++) {
        const int32_t a = 1 + i, b = 1 + (i + 1) % n, out = 1 + n + i, next = 1 + n + (i + 1) % n;
        const int32_t facet[3][3] = {{0, a, b}, {a, out, b}, {b, out, next}};
        set_place(c->x[a], 1, (i + 0.3 * (i % 3 == 1)) / n, 0);
        set_place(c->x[out], 1.01, (i + 0.5) / n, -0.005);
        memcpy(c->facet[3 * i], facet, sizeof facet);
    }
    for (int i = 0; i < 3 * n; i++) {
        c->type[i] = PLANISH_CELL_TRIANGLE;
        c->offset[i + 1] = 3 * (i + 1);
    }
    c->cells =
        (planish_cells){.n = 3 * n, .type = c->type, .offset = c->offset, .node = c->facet[0]};
    c->mesh = (planish_mesh){.dim = 3,
                             .n_nodes = 1 + 2 * n,
                             .n_elements = 3 * n,
                             .coordinates = c->x[0],
                             .cells = &c->cells};
}

/** Options of two sweeps. */
static planish_options two_sweeps(const planish_shape *shape) {
    planish_options options = test_options(1);
    options.shape = shape;
    options.max_sweeps = 2;
    return options;
}

/** Expect that the nodes of a mesh are near to a shape, for certain. */
static void expect_near(const planish_shape *shape, const planish_mesh *mesh, double most) {
    planish_shape_distance distance;
    assert_int_equal(planish_shape_measure(shape, mesh, 1, &distance, NULL), 0);
    assert_int_equal(distance.n_unproved, 0);
    assert_true(distance.distance > 0 && distance.distance < most);
}

/** Two sweeps and the distances of a fan of 20 000: what grew by the square of it would meet the limit of
 *  all tests. */
static void a_hub_is_smoothed_and_measured(void **unused) {
    static cone c;
    planish_shape *shape = NULL;
    planish_error e;
    (void)unused;
    make_cone(&c, FAN / effort_step(8));
    assert_int_equal(planish_shape_create(&c.mesh, NULL, 1, &shape, NULL, &e), 0);
    const planish_options options = two_sweeps(shape);
    assert_int_equal(planish_smooth_surface(&c.mesh, c.x[0], &options, NULL, &e), 0);
    expect_near(shape, &c.mesh, 0.05);
    planish_shape_destroy(shape);
}

/* ---- facets of order 2 ----------------------------------------------------------------------- */

enum {
    SOLID = 600, /* tetrahedra */
    RING = 2,
    MIDS = RING + SOLID,
    ROUND = MIDS + 2 * SOLID,
    AXIS = ROUND + SOLID,
    SOLID_NODES
};

/** Two blunt cones on one another: tetrahedra of order 2 around the edge between both apices. */
typedef struct double_cone {
    planish_mesh mesh;
    planish_cells cells;
    double x[SOLID_NODES][3];
    int32_t node[SOLID][10];
    int64_t offset[SOLID + 1];
    uint8_t type[SOLID];
} double_cone;

/** Put a mid between two nodes, and out of the solid by a part of the edge. */
static void put_mid(double_cone *c, int32_t mid, int32_t a, int32_t b, double out) {
    for (int d = 0; d < 3; d++)
        c->x[mid][d] = (c->x[a][d] + c->x[b][d]) / 2;
    c->x[mid][2] += c->x[mid][2] > 0 ? out : c->x[mid][2] < 0 ? -out : 0;
}

static void make_double_cone(double_cone *c) {
    const int n = SOLID;
    set_place(c->x[0], 0.04, 0.1, 0.3);
    set_place(c->x[1], 0.03, 0.7, -0.3);
    for (int i = 0; i < n; i++)
        set_place(c->x[RING + i], 1, (i + 0.3 * (i % 3 == 1)) / n, 0);
    put_mid(c, AXIS, 0, 1, 0);
    for (int32_t i = 0; i < n; i++) {
        const int32_t a = RING + i, b = RING + (i + 1) % n;
        const int32_t up = MIDS + 2 * i, up_b = MIDS + 2 * ((i + 1) % n), round = ROUND + i;
        const int32_t node[10] = {1, a, b, 0, up + 1, round, up_b + 1, AXIS, up, up_b};
        memcpy(c->node[i], node, sizeof node);
        put_mid(c, up, 0, a, 0.01);
        put_mid(c, up + 1, 1, a, 0.01);
        put_mid(c, round, a, b, 0);
        c->type[i] = PLANISH_CELL_TETRAHEDRON10;
        c->offset[i + 1] = 10 * ((int64_t)i + 1);
    }
    c->cells = (planish_cells){.n = n, .type = c->type, .offset = c->offset, .node = c->node[0]};
    c->mesh = (planish_mesh){.dim = 3,
                             .n_nodes = SOLID_NODES,
                             .n_elements = n,
                             .coordinates = c->x[0],
                             .cells = &c->cells};
}

/** The mids of all edges at an apex go along with it. */
static void a_hub_of_order_2_is_smoothed(void **unused) {
    static double_cone c;
    planish_shape *shape = NULL;
    planish_slide_info info;
    planish_plan *plan;
    planish_error e;
    (void)unused;
    make_double_cone(&c);
    assert_int_equal(planish_shape_create(&c.mesh, NULL, 1, &shape, NULL, &e), 0);
    const planish_surface surface = {.shape = shape};
    uint8_t *constraint = malloc(SOLID_NODES);
    double(*direction)[3] = malloc(SOLID_NODES * sizeof *direction);
    assert_int_equal(planish_find_slides(&c.mesh, &surface, 1, constraint, direction[0], &info, &e),
                     0);
    assert_int_equal(constraint[0], PLANISH_CONSTRAINT_ON_PATCH);
    const planish_options options = two_sweeps(shape);
    c.mesh.constraint = constraint;
    c.mesh.direction = direction[0];
    const double before[2] = {c.x[0][0], c.x[MIDS][0]};
    assert_int_equal(planish_plan_create(&c.mesh, &options, &plan, &e), 0);
    assert_int_equal(planish_smooth(plan, c.x[0], &options, NULL, &e), 0);
    assert_true(c.x[0][0] != before[0] && c.x[MIDS][0] != before[1]);
    planish_plan_destroy(plan);
    expect_near(shape, &c.mesh, 0.05);
    planish_shape_destroy(shape);
    free(constraint);
    free(direction);
}

/* ---- gaps ------------------------------------------------------------------------------------ */

/** Whether two facets of a shape of a surface alone are within most across a gap, by plain words. */
static int are_near(const planish_shape *s, int a, int b, double most) {
    const double *x[3], *y[3];
    double way[3], normal[2][3], from = 0, to = 0;
    for (int k = 0; k < 9; k++)
        if (s->facet[a][k / 3] == s->facet[b][k % 3])
            return 0;
    for (int k = 0; k < 3; k++) {
        x[k] = s->x[s->facet[a][k]];
        y[k] = s->x[s->facet[b][k]];
    }
    const double square = pl_nearest_triangles(x, y, way);
    pl_facet_normal(s, a, normal[0]);
    pl_facet_normal(s, b, normal[1]);
    for (int d = 0; d < 3; d++) {
        from += normal[0][d] * way[d];
        to += normal[1][d] * way[d];
    }
    return square <= most * most &&
           (square == 0 || (from * from > 0.25 * square && to * to > 0.25 * square));
}

/** Two blunt cones, one in the other, which are near on one side. */
static void gaps_between_fans(void **unused) {
    enum { N = 150, ALL = 2 * 3 * N };
    static cone c[2];
    static double x[2 * NODES][3];
    static int32_t facet[ALL][3];
    int64_t n_near = 0;
    (void)unused;
    for (int k = 0; k < 2; k++) {
        make_cone(&c[k], N);
        c[k].x[0][2] += 0.2 * k;
        for (int i = 0; i < 1 + 2 * N; i++)
            memcpy(x[k * (1 + 2 * N) + i],
                   (double[]){c[k].x[i][0], c[k].x[i][1],
                              c[k].x[i][2] + k * (0.05 + 0.04 * c[k].x[i][0])},
                   sizeof *x);
        for (int i = 0; i < 3 * 3 * N; i++)
            facet[k * 3 * N + i / 3][i % 3] = c[k].facet[i / 3][i % 3] + k * (1 + 2 * N);
    }
    c[0].offset[0] = 0;
    for (int i = 0; i < ALL; i++) {
        c[0].type[i] = PLANISH_CELL_TRIANGLE;
        c[0].offset[i + 1] = 3 * (i + 1);
    }
    c[0].cells =
        (planish_cells){.n = ALL, .type = c[0].type, .offset = c[0].offset, .node = facet[0]};
    c[0].mesh.n_nodes = 2 * (1 + 2 * N);
    c[0].mesh.n_elements = ALL;
    c[0].mesh.coordinates = x[0];
    planish_shape *s = NULL;
    assert_int_equal(planish_shape_create(&c[0].mesh, NULL, 1, &s, NULL, NULL), 0);
    float tolerance[ALL];
    uint8_t is_near[ALL];
    for (int i = 0; i < ALL; i++)
        tolerance[i] = (float)(s->scale * (i % 5 == 0 ? 0.02 : 0.03));
    assert_int_equal(pl_shape_find_gaps(s, tolerance, NULL, 1, 2, is_near, NULL), 0);
    for (int a = 0; a < ALL; a++) {
        int any = 0;
        for (int b = 0; b < ALL; b++)
            any |= are_near(s, a, b, (double)tolerance[a] + tolerance[b]);
        assert_int_equal(is_near[a], any);
        n_near += any;
    }
    assert_true(n_near > N && n_near < ALL);
    planish_shape_destroy(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_hub_is_smoothed_and_measured),
        cmocka_unit_test(a_hub_of_order_2_is_smoothed),
        cmocka_unit_test(gaps_between_fans),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
