/* planish_shape: points, normals, walks, slides and distances. */
#include "support/meshes.h"
#include "support/surfaces.h"

#include "shape/pn.h"
#include "shape/walk.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- points ---------------------------------------------------------------------------------------- */

static pl_place random_place(int32_t at, int n, unsigned *state) {
    pl_place p = {at, {0}};
    double a = test_random(state), b = n > 2 ? test_random(state) : 0;
    if (a + b > 1) {
        a = 1 - a;
        b = 1 - b;
    }
    p.weight[0] = 1 - a - b;
    p.weight[1] = a;
    p.weight[2] = b;
    return p;
}

static void tilted(int piece, double u, double v, double x[3]) {
    (void)piece;
    x[0] = 0.7 * u - 0.2 * v;
    x[1] = 0.3 * u + 0.9 * v;
    x[2] = 0.4 * u - 0.6 * v + 0.1;
}

static void planes_stay_planes(void **state) {
    (void)state;
    test_surface m;
    unsigned random = 7;
    test_surface_create(&m, 1, tilted, 15, 15, 0.3, 5);
    made_shape shape = test_shape_make(&m.mesh, NULL, 1);
    const planish_shape *s = shape.s;
    test_shape_expect(&shape);
    for (int32_t f = 0; f < s->n_facets; f++)
        for (int k = 0; k < 5; k++) {
            const pl_place p = random_place(f, 3, &random);
            double x[3], n[3], normal[3], off = 0, turn = 0;
            pl_shape_point(s, PL_ON_PATCH, &p, x, n);
            pl_facet_normal(s, f, normal);
            for (int d = 0; d < 3; d++) {
                off += (x[d] - s->x[s->facet[f][0]][d]) * normal[d];
                turn += (n[d] - normal[d]) * (n[d] - normal[d]);
            }
            assert_true(fabs(off) <= 1e-15 * s->size && turn < 1e-24);
        }
    for (int32_t e = 0; e < s->n_edges; e++) {
        const pl_place p = random_place(e, 2, &random);
        double x[3], t[3], along[3], way[3], off[3];
        pl_shape_point(s, PL_ON_CURVE, &p, x, t);
        pl_from_to(3, s->x[s->edge[e][0]], s->x[s->edge[e][1]], along);
        pl_from_to(3, s->x[s->edge[e][0]], x, way);
        pl_cross(along, way, off);
        assert_true(pl_length(off) <= 1e-15 * pl_length(along) * s->size);
        assert_true(fabs(pl_length(t) - 1) < 1e-14);
    }
    planish_shape_destroy(shape.s);
    test_surface_destroy(&m);
}

/** Compute how far points of patches are off the sphere of radius 1 at most, and their normals; sag: of the
 *  triangles. */
static void measure_sphere(const planish_shape *s, double *off, double *turn, double *sag) {
    unsigned random = 3;
    *off = *turn = *sag = 0;
    for (int32_t f = 0; f < s->n_facets; f++)
        for (int k = 0; k < 10; k++) {
            const pl_place p = random_place(f, 3, &random);
            double x[3], n[3], flat[3];
            pl_shape_point(s, PL_ON_PATCH, &p, x, n);
            for (int d = 0; d < 3; d++) {
                flat[d] = 0;
                for (int i = 0; i < 3; i++)
                    flat[d] += p.weight[i] * s->x[s->facet[f][i]][d] / s->scale;
                x[d] /= s->scale;
            }
            *off = fmax(*off, fabs(pl_length(x) - 1));
            *sag = fmax(*sag, fabs(pl_length(flat) - 1));
            *turn = fmax(*turn, 1 - fabs(pl_dot(3, x, n)) / pl_length(x));
        }
}

/** Directions are square to the surface, by differences. */
static void normals_are_those_of_the_points(void **state) {
    (void)state;
    test_surface m;
    unsigned random = 3;
    const double step = 1e-6;
    test_surface_create(&m, 6, test_sphere_map, 6, 6, 0.3, 5);
    made_shape shape = test_shape_make(&m.mesh, NULL, 1);
    const planish_shape *s = shape.s;
    for (int32_t f = 0; f < s->n_facets; f++)
        for (int k = 0; k < 2; k++) {
            const pl_place p = random_place(f, 3, &random);
            pl_place q = p;
            double x[3], y[3], n[3], other[3], way[3], normal[3];
            q.weight[k] += step;
            q.weight[2] -= step;
            pl_shape_point(s, PL_ON_PATCH, &p, x, n);
            pl_shape_point(s, PL_ON_PATCH, &q, y, other);
            pl_from_to(3, x, y, way);
            assert_true(fabs(pl_dot(3, way, n)) < 1e-5 * pl_length(way));
            pl_facet_normal(s, f, normal);
            assert_true(pl_dot(3, n, normal) > 0.9);
        }
    planish_shape_destroy(shape.s);
    test_surface_destroy(&m);
}

static void points_come_close_to_spheres(void **state) {
    (void)state;
    double last = 1;
    for (int n = 6; n <= 24; n *= 2) {
        test_surface m;
        double off, turn, sag;
        test_surface_create(&m, 6, test_sphere_map, n, n, 0, 5);
        made_shape shape = test_shape_make(&m.mesh, NULL, 1);
        measure_sphere(shape.s, &off, &turn, &sag);
        assert_true(off < last / 10 && off < 0.06 * sag && turn < 0.1 * sag);
        last = off;
        planish_shape_destroy(shape.s);
        test_surface_destroy(&m);
    }
    assert_true(last < 1e-5);
}

static void curves_come_close_to_circles(void **state) {
    (void)state;
    double last = 1;
    for (int n = 12; n <= 48; n *= 2) {
        test_surface m;
        unsigned random = 3;
        double off = 0, turn = 0;
        test_surface_create(&m, 3, test_cylinder_map, n, n / 2, 0.2, 5);
        made_shape shape = test_shape_make(&m.mesh, NULL, 1);
        const planish_shape *s = shape.s;
        for (int32_t e = 0; e < s->n_edges; e++)
            for (int k = 0; k < 10; k++) {
                const pl_place p = random_place(e, 2, &random);
                double x[3], t[3];
                pl_shape_point(s, PL_ON_CURVE, &p, x, t);
                const double r = sqrt(x[0] * x[0] + x[1] * x[1]);
                off = fmax(off, fabs(r / s->scale - 0.5));
                turn = fmax(turn, fabs(x[0] * t[0] + x[1] * t[1]) / r);
            }
        /* normals of the side: at its rims they are exact */
        for (int32_t f = 0; f < s->n_facets; f++)
            for (int k = 0; k < 3 && fabsf(s->normal[f][2]) < 0.5f; k++) {
                const double *x = s->x[s->facet[f][k]], *q = pl_corner_normal(s, f, k);
                const double r = sqrt(x[0] * x[0] + x[1] * x[1]);
                assert_true(fabs(x[0] * q[1] - x[1] * q[0]) < r / n && fabs(q[2]) < 1.0 / n);
                if (s->node_class[s->facet[f][k]] == PL_ON_CURVE)
                    assert_true(fabs(x[0] * q[1] - x[1] * q[0]) < 1e-13 * r);
            }
        assert_true(off < last / 10 && turn < 60 * off);
        last = off;
        planish_shape_destroy(shape.s);
        test_surface_destroy(&m);
    }
    assert_true(last < 1e-5);
}

static void uneven(int piece, double u, double v, double x[3]) {
    const double angle = 2 * u + 0.3 * sin(5 * u);
    (void)piece;
    x[0] = cos(angle);
    x[1] = sin(angle);
    x[2] = v;
}

/** Tangents of circles are exact whatever the lengths of edges, and at corners, too. */
static void tangents_of_circles_are_exact(void **state) {
    (void)state;
    test_surface m;
    test_surface_create(&m, 1, uneven, 16, 8, 0, 5);
    made_shape shape = test_shape_make(&m.mesh, NULL, 1);
    const planish_shape *s = shape.s;
    assert_int_equal(shape.info.n_corners, 4);
    for (int32_t e = 0; e < s->n_edges; e++)
        for (int k = 0; k < 2; k++) {
            const double *x = s->x[s->edge[e][k]], *y = s->x[s->edge[e][!k]];
            const double *t = s->tangent[e][k], up = fabs(y[2] - x[2]);
            double way[3];
            pl_from_to(3, x, y, way);
            assert_true(pl_dot(3, way, t) > 0.9 * pl_length(way));
            assert_true(fabs(x[0] * t[0] + x[1] * t[1]) < 1e-13 * s->scale);
            assert_true(fabs(t[2]) < 1e-14 || fabs(fabs(t[2]) - 1) < 1e-14);
            assert_true((up > 0) == (fabs(t[2]) > 0.5));
        }
    planish_shape_destroy(shape.s);
    test_surface_destroy(&m);
}

/** Points at nodes are the nodes, and edges of patches look the same from both sides. */
static void surfaces_have_no_gaps(void **state) {
    (void)state;
    for (int k = 0; k < N_KNOWN_SURFACES; k++) {
        test_surface m;
        unsigned random = 3;
        test_surface_create(&m, KNOWN_SURFACES[k].n_pieces, KNOWN_SURFACES[k].map,
                            KNOWN_SURFACES[k].nu * 6, KNOWN_SURFACES[k].nv * 6, 0.3, 5);
        made_shape shape = test_shape_make(&m.mesh, NULL, 1);
        const planish_shape *s = shape.s;
        for (int32_t f = 0; f < s->n_facets; f++)
            for (int i = 0; i < 3; i++) {
                pl_place p = {f, {i == 0, i == 1, i == 2}};
                double x[3], y[3], n[3];
                pl_shape_point(s, PL_ON_PATCH, &p, x, n);
                assert_true(pl_distance(3, x, s->x[s->facet[f][i]]) <= 2e-16 * s->size);
                const int32_t g = s->across[f][i];
                const int j = (i + 1) % 3;
                const double t = test_random(&random);
                memset(p.weight, 0, sizeof p.weight);
                p.weight[i] = t;
                p.weight[j] = 1 - t;
                pl_shape_point(s, PL_ON_PATCH, &p, x, n);
                pl_place q = {g, {0}};
                if (g >= 0) {
                    for (int l = 0; l < 3; l++)
                        q.weight[l] = s->facet[g][l] == s->facet[f][i]   ? t
                                      : s->facet[g][l] == s->facet[f][j] ? 1 - t
                                                                         : 0;
                    pl_shape_point(s, PL_ON_PATCH, &q, y, n);
                } else {
                    for (q.at = 0;
                         s->edge[q.at][0] + s->edge[q.at][1] != s->facet[f][i] + s->facet[f][j] ||
                         (s->edge[q.at][0] != s->facet[f][i] &&
                          s->edge[q.at][0] != s->facet[f][j]);)
                        q.at++;
                    const int turned = s->edge[q.at][0] != s->facet[f][i];
                    q.weight[turned] = t;
                    q.weight[!turned] = 1 - t;
                    pl_shape_point(s, PL_ON_CURVE, &q, y, n);
                }
                assert_true(pl_distance(3, x, y) <= 4e-16 * s->size);
            }
        planish_shape_destroy(shape.s);
        test_surface_destroy(&m);
    }
}

/* ---- walks ----------------------------------------------------------------------------------------- */

/** Square of the distance of a point from a triangle: the least over a fine grid and refined ones, from above. */
static double distance_by_grid(const planish_shape *s, int32_t f, const double point[3]) {
    double best = INFINITY, at[2] = {0, 0}, width = 1;
    for (int round = 0; round < 12; round++) {
        const double from[2] = {at[0] - width / 2 * (round > 0), at[1] - width / 2 * (round > 0)};
        for (int i = 0; i <= 8; i++)
            for (int j = 0; j <= 8; j++) {
                const double b = fmax(0, from[0] + width * i / 8),
                             c = fmax(0, from[1] + width * j / 8);
                double off[3];
                if (b + c > 1)
                    continue;
                for (int d = 0; d < 3; d++)
                    off[d] = (1 - b - c) * s->x[s->facet[f][0]][d] + b * s->x[s->facet[f][1]][d] +
                             c * s->x[s->facet[f][2]][d] - point[d];
                const double distance = pl_length(off);
                if (distance < best) {
                    best = distance;
                    at[0] = b;
                    at[1] = c;
                }
            }
        width /= 3;
    }
    return best;
}

/** Walks end at the nearest place of the patch around, never across features. */
static void walks_stay_on_their_patch(void **state) {
    (void)state;
    for (int k = 0; k < N_KNOWN_SURFACES; k++) {
        test_surface m;
        unsigned random = 3;
        test_surface_create(&m, KNOWN_SURFACES[k].n_pieces, KNOWN_SURFACES[k].map,
                            KNOWN_SURFACES[k].nu * 5, KNOWN_SURFACES[k].nv * 5, 0.3, 5);
        made_shape shape = test_shape_make(&m.mesh, NULL, 1);
        const planish_shape *s = shape.s;
        for (int round = 0; round < 300; round++) {
            const int32_t from = (int32_t)(test_random(&random) * (double)s->n_facets);
            pl_place start = random_place(from, 3, &random), end = start;
            double x[3], there[3] = {0};
            for (int d = 0; d < 3; d++)
                x[d] = s->x[s->facet[from][0]][d] +
                       s->edge_length[s->facet[from][0]] * 3 * (test_random(&random) - 0.5);
            const double distance = pl_shape_walk(s, PL_ON_PATCH, x, &end);
            assert_int_equal(s->patch[end.at], s->patch[from]);
            double sum = 0;
            for (int i = 0; i < 3; i++) {
                assert_true(end.weight[i] >= 0);
                sum += end.weight[i];
                for (int d = 0; d < 3; d++)
                    there[d] += end.weight[i] * s->x[s->facet[end.at][i]][d];
            }
            assert_true(fabs(sum - 1) < 1e-15);
            assert_true(fabs(pl_distance(3, there, x) - distance) <= 1e-14 * s->size);
            assert_true(distance <= distance_by_grid(s, from, x) + 1e-14 * s->size);
            for (int i = 0; i < 3; i++) /* none of the facets there is nearer */
                if (end.weight[(i + 2) % 3] == 0 && s->across[end.at][i] >= 0)
                    assert_true(distance <=
                                distance_by_grid(s, s->across[end.at][i], x) + 1e-12 * s->size);
        }
        planish_shape_destroy(shape.s);
        test_surface_destroy(&m);
    }
}

static void walks_find_the_nearest_place_of_a_sphere(void **state) {
    (void)state;
    test_surface m;
    unsigned random = 3;
    test_surface_create(&m, 6, test_sphere_map, 5, 5, 0.3, 5);
    made_shape shape = test_shape_make(&m.mesh, NULL, 1);
    const planish_shape *s = shape.s;
    for (int round = 0; round < 60; round++) {
        const int32_t from = (int32_t)(test_random(&random) * (double)s->n_facets);
        pl_place end = random_place(from, 3, &random);
        const int32_t to = (int32_t)(test_random(&random) * (double)s->n_nodes);
        double x[3], best = INFINITY;
        for (int d = 0; d < 3; d++)
            x[d] = s->x[to][d] * (1.03 + 0.2 * test_random(&random)) +
                   0.02 * s->scale * test_random(&random);
        const double distance = pl_shape_walk(s, PL_ON_PATCH, x, &end);
        for (int32_t f = 0; f < s->n_facets; f++)
            best = fmin(best, distance_by_grid(s, f, x));
        if (pl_distance(3, s->x[s->facet[from][0]], x) < s->scale) /* not from the far side */
            assert_true(distance <= best + 1e-13 * s->size);
    }
    planish_shape_destroy(shape.s);
    test_surface_destroy(&m);
}

static void walks_along_curves_end_at_corners(void **state) {
    (void)state;
    test_surface m;
    unsigned random = 3;
    test_prism_sides = 12;
    test_surface_create(&m, 3 * 12, test_prism_map, 4, 4, 0.2, 5);
    made_shape shape = test_shape_make(&m.mesh, NULL, 1);
    const planish_shape *s = shape.s;
    for (int32_t node = 0; node < s->n_nodes; node++)
        for (int round = 0; round < 4 && s->node_class[node] == PL_ON_CURVE; round++) {
            const int32_t e = s->edge_at[node][round % 2];
            pl_place end = {e, {s->edge[e][0] == node, s->edge[e][1] == node}};
            double x[3], there[3], along[3], way[3], off[3];
            for (int d = 0; d < 3; d++)
                x[d] = s->x[node][d] + s->size * (test_random(&random) - 0.5);
            const double distance = pl_shape_walk(s, PL_ON_CURVE, x, &end);
            for (int d = 0; d < 3; d++)
                there[d] = end.weight[0] * s->x[s->edge[end.at][0]][d] +
                           end.weight[1] * s->x[s->edge[end.at][1]][d];
            assert_true(fabs(pl_distance(3, there, x) - distance) <= 1e-14 * s->size);
            assert_true(distance <= pl_distance(3, x, s->x[node]) + 1e-14 * s->size);
            /* it stays on the straight line that the node is on */
            pl_from_to(3, s->x[s->edge[e][0]], s->x[s->edge[e][1]], along);
            pl_from_to(3, s->x[node], there, way);
            pl_cross(along, way, off);
            assert_true(pl_length(off) <= 1e-13 * pl_length(along) * s->size);
        }
    planish_shape_destroy(shape.s);
    test_surface_destroy(&m);
}

/* ---- meshes of solids -------------------------------------------------------------------------- */

enum { CELLS = 6 };

/** Make a box of elements round: its sides become a sphere of radius CELLS / 2. */
static void make_ball(test_mesh *box) {
    test_mesh_box(box, 3, CELLS);
    for (int64_t i = 0; i < box->mesh.n_nodes; i++) {
        double *x = box->coordinates + 3 * i, largest = 0, square = 0;
        for (int d = 0; d < 3; d++) {
            x[d] -= CELLS / 2.0;
            largest = fmax(largest, fabs(x[d]));
        }
        for (int d = 0; d < 3; d++) {
            x[d] = largest > 0 ? largest * tan(0.785398163397448 * x[d] / largest) : 0;
            square += x[d] * x[d];
        }
        for (int d = 0; d < 3 && largest > 0; d++)
            x[d] *= largest / sqrt(square);
    }
}

/** Elements at both sides of the node layer in the middle. */
static int32_t *two_halves(const planish_mesh *mesh) {
    int32_t *region = malloc((size_t)mesh->n_elements * sizeof *region);
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        double sum = 0;
        for (int j = 0; j < 4; j++)
            sum += mesh->coordinates[(int64_t)mesh->elements[i * 4 + j] * 3 + 2];
        region[i] = sum < 0 ? 3 : -2;
    }
    return region;
}

static void normals_point_outwards(void **state) {
    (void)state;
    for (unsigned k = 0; k < 6; k++) {
        test_mesh ball;
        make_ball(&ball);
        test_mesh_renumber(&ball, k, NULL);
        test_mesh_reverse_some(&ball, 3, 8);
        int32_t *region = two_halves(&ball.mesh);
        const planish_surface tags = {.region = k ? region : NULL};
        made_shape shape = test_shape_make(&ball.mesh, &tags, 1);
        const planish_shape *s = shape.s;
        int64_t n_inside = 0;
        test_shape_expect(&shape);
        for (int32_t f = 0; f < s->n_facets; f++) {
            double normal[3];
            pl_facet_normal(s, f, normal);
            n_inside += s->is_interface[f];
            if (s->is_interface[f]) /* out of the lower region, which is above */
                assert_true(normal[2] < -0.99);
            else
                assert_true(pl_dot(3, normal, s->x[s->facet[f][0]]) > 0);
        }
        assert_int_equal(n_inside, k ? 2 * CELLS * CELLS : 0);
        assert_int_equal(s->n_facets, 12 * CELLS * CELLS + n_inside);
        assert_int_equal(s->n_edges, k ? 4 * CELLS : 0);
        planish_shape_destroy(shape.s);
        free(region);
        test_mesh_destroy(&ball);
    }
}

/** Find the slides of mesh, and expect of each node what its class says; returns how many slide on patches and
 *  curves. */
static int64_t expect_slides(const planish_mesh *mesh, const planish_surface *tags) {
    uint8_t *constraint = malloc((size_t)mesh->n_nodes), *flat = malloc((size_t)mesh->n_nodes);
    uint8_t *class = malloc((size_t)mesh->n_nodes);
    double *direction = malloc((size_t)mesh->n_nodes * 3 * sizeof *direction);
    planish_slide_info info, before;
    planish_surface without = *tags;
    without.shape = NULL;
    assert_int_equal(planish_find_slides(mesh, &without, 1, flat, direction, &before, NULL), 0);
    assert_int_equal(planish_find_slides(mesh, tags, 2, constraint, direction, &info, NULL), 0);
    planish_shape_get_classes(tags->shape, class);
    int64_t n[2] = {0};
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        n[0] += constraint[i] == PLANISH_CONSTRAINT_ON_PATCH;
        n[1] += constraint[i] == PLANISH_CONSTRAINT_ON_CURVE;
        if (flat[i] != PLANISH_CONSTRAINT_FIXED)
            assert_int_equal(constraint[i], flat[i]);
        else if (constraint[i] != PLANISH_CONSTRAINT_FIXED)
            assert_int_equal(constraint[i], class[i] == PLANISH_SHAPE_PATCH
                                                ? PLANISH_CONSTRAINT_ON_PATCH
                                                : PLANISH_CONSTRAINT_ON_CURVE);
    }
    assert_int_equal(info.n_on_patch, n[0]);
    assert_int_equal(info.n_on_curve, n[1]);
    assert_int_equal(info.n_on_plane, before.n_on_plane);
    assert_int_equal(info.n_on_line, before.n_on_line);
    assert_int_equal(before.n_on_patch + before.n_on_curve, 0);
    free(constraint);
    free(flat);
    free(class);
    free(direction);
    return n[0] + n[1];
}

static void curved_boundaries_slide_on_shapes(void **state) {
    (void)state;
    test_mesh ball;
    make_ball(&ball);
    int32_t *region = two_halves(&ball.mesh);
    const int64_t all = 6 * CELLS * CELLS + 2, equator = 4 * CELLS;
    planish_surface tags = {.crease_angle = 0};
    made_shape shape = test_shape_make(&ball.mesh, &tags, 1);
    tags.shape = shape.s;
    const int64_t n_whole = expect_slides(&ball.mesh, &tags);
    assert_true(n_whole >= all - 8); /* bent corners of the box may stay */
    tags.tagged_only = 1;
    assert_int_equal(expect_slides(&ball.mesh, &tags), 0);
    tags.tagged_only = 0;

    /* a shape without the interface is another one there */
    tags.region = region;
    tags.slide_interfaces = 1;
    assert_int_equal(expect_slides(&ball.mesh, &tags), n_whole - equator);
    tags.slide_interfaces = 0;
    planish_shape_destroy(shape.s);
    shape = test_shape_make(&ball.mesh, &tags, 1);
    tags.shape = shape.s;
    const int64_t n_held = expect_slides(&ball.mesh, &tags);
    tags.slide_interfaces = 1;
    const int64_t n_sliding = expect_slides(&ball.mesh, &tags);
    assert_true(n_held <= n_whole - equator && n_sliding >= n_held + equator - 8);
    planish_shape_destroy(shape.s);

    /* a copy that touches nothing, and nodes at the place of another one */
    test_mesh other;
    make_ball(&other);
    test_mesh_append(&ball, &other, 0);
    shape = test_shape_make(&ball.mesh, NULL, 1);
    tags = (planish_surface){.shape = shape.s};
    assert_int_equal(shape.info.n_corners, shape.info.n_nodes);
    assert_int_equal(expect_slides(&ball.mesh, &tags), 0);
    planish_shape_destroy(shape.s);
    test_mesh_destroy(&other);
    free(region);
    test_mesh_destroy(&ball);
}

/** What is measured of a surface that has moved is never below what samples say. */
static void distances_are_measured(void **state) {
    (void)state;
    test_surface m;
    unsigned random = 3;
    test_surface_create(&m, 3, test_cylinder_map, 48, 24, 0.2, 5);
    made_shape shape = test_shape_make(&m.mesh, NULL, 1);
    planish_shape_distance d;
    planish_mesh wide = m.mesh;
    double *padded = malloc((size_t)m.n_nodes * 4 * sizeof *padded);
    wide.coordinates = padded;
    wide.node_stride = 4;
    for (int k = 0; k < 3;
         k++) { /* as it was; then nodes are moved along the cylinder, and off it */
        for (int64_t i = 0; i < m.n_nodes; i++) {
            double *x = m.x[i];
            const int side = fabs(sqrt(x[0] * x[0] + x[1] * x[1]) - 0.5) < 1e-9;
            const double turn = (k == 1) * 0.02 * (test_random(&random) - 0.5);
            const double y[3] = {x[0] * cos(turn) - x[1] * sin(turn),
                                 x[0] * sin(turn) + x[1] * cos(turn), x[2]};
            for (int j = 0; j < 3; j++)
                x[j] = y[j] * (k == 2 && side && j < 2 ? 1.004 : 1);
            memcpy(padded + 4 * i, x, 3 * sizeof *x);
        }
        assert_int_equal(planish_shape_measure(shape.s, &wide, 1, &d, NULL), 0);
        assert_int_equal(d.n_unproved, 0);
        assert_true(d.max_bend_before > 7.49 && d.max_bend_before < 20);
        static const double LEAST[] = {0, 0, 0.002 * 0.999}, MOST[] = {0, 0.0012, 0.008};
        const double least = LEAST[k], most = MOST[k];
        assert_true(d.distance >= least && d.distance <= most);
        assert_true(d.distance_back >= least && d.distance_back <= most);
        assert_true(k == 0 ? d.in_edges == 0 && d.max_bend == d.max_bend_before
                           : d.in_edges > d.distance / 0.1 && d.in_edges < d.distance / 0.01);
        planish_shape_distance again;
        assert_int_equal(planish_shape_measure(shape.s, &m.mesh, 3, &again, NULL), 0);
        assert_memory_equal(&d, &again, sizeof d);
    }
    planish_error error = {.text = ""};
    wide.n_nodes--;
    assert_int_equal(planish_shape_measure(shape.s, &wide, 1, &d, &error), PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "nodes"));
    m.x[5][1] = INFINITY;
    assert_int_equal(planish_shape_measure(shape.s, &m.mesh, 1, &d, &error), PLANISH_ERROR_MESH);
    assert_int_equal(error.node, 5);
    assert_int_equal(planish_shape_measure(shape.s, &m.mesh, -1, &d, NULL), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_shape_measure(NULL, &m.mesh, 1, &d, NULL), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_shape_measure(shape.s, NULL, 1, &d, NULL), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_shape_measure(shape.s, &m.mesh, 1, NULL, NULL),
                     PLANISH_ERROR_ARGUMENT);
    free(padded);
    planish_shape_destroy(shape.s);
    test_surface_destroy(&m);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(planes_stay_planes),
        cmocka_unit_test(normals_are_those_of_the_points),
        cmocka_unit_test(points_come_close_to_spheres),
        cmocka_unit_test(curves_come_close_to_circles),
        cmocka_unit_test(tangents_of_circles_are_exact),
        cmocka_unit_test(surfaces_have_no_gaps),
        cmocka_unit_test(walks_stay_on_their_patch),
        cmocka_unit_test(walks_find_the_nearest_place_of_a_sphere),
        cmocka_unit_test(walks_along_curves_end_at_corners),
        cmocka_unit_test(normals_point_outwards),
        cmocka_unit_test(curved_boundaries_slide_on_shapes),
        cmocka_unit_test(distances_are_measured),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
