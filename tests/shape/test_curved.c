/* planish_shape: features, classes, normals, places and points of surfaces. */
#include "support/allocations.h"
#include "support/meshes.h"
#include "support/surfaces.h"

#include "shape/curved.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/** A shape, and what is said of it. */
typedef struct made {
    planish_shape *s;
    planish_shape_info info;
} made;

static made make(const planish_mesh *mesh, const planish_surface *tags, int threads) {
    made m;
    planish_error error = {.text = ""};
    if (planish_shape_create(mesh, tags, threads, &m.s, &m.info, &error) != 0)
        fail_msg("%s", error.text);
    return m;
}

/* ---- what every shape promises ----------------------------------------------------------------- */

static double length_of(const double v[3]) {
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static void expect_unit(const double v[3]) {
    assert_true(fabs(length_of(v) - 1) < 1e-14);
}

static int is_zero(const double v[3]) {
    return v[0] == 0 && v[1] == 0 && v[2] == 0;
}

/** Neighbours within a patch know one another, and turn the same way round. */
static void expect_facets(const planish_shape *s) {
    int32_t n_patches = 0;
    for (int32_t f = 0; f < s->n_facets; f++) {
        assert_true(s->patch[f] <= n_patches);
        n_patches = s->patch[f] == n_patches ? n_patches + 1 : n_patches;
        if (!is_zero(s->normal[f]))
            expect_unit(s->normal[f]);
        for (int k = 0; k < 3; k++) {
            const int32_t g = s->across[f][k], a = s->facet[f][k], b = s->facet[f][(k + 1) % 3];
            int is_met = g < 0;
            for (int m = 0; g >= 0 && m < 3; m++)
                is_met |=
                    s->across[g][m] == f && s->facet[g][m] == b && s->facet[g][(m + 1) % 3] == a;
            assert_true(is_met && (g < 0 || s->patch[g] == s->patch[f]));
            if (!is_zero(s->corner_normal[f][k]))
                expect_unit(s->corner_normal[f][k]);
        }
    }
}

/** Edges of features are those of facets without a facet across, and curves go on through nodes. */
static void expect_edges(const planish_shape *s) {
    int64_t n_sides = 0, n_known = 0;
    for (int32_t f = 0; f < s->n_facets; f++)
        for (int k = 0; k < 3; k++)
            n_sides += s->across[f][k] < 0;
    for (int32_t e = 0; e < s->n_edges; e++) {
        const int32_t *v = s->edge[e];
        assert_true(v[0] < v[1]);
        assert_true(e == 0 || s->edge[e - 1][0] < v[0] ||
                    (s->edge[e - 1][0] == v[0] && s->edge[e - 1][1] < v[1]));
        for (int j = 0; j < 2; j++) {
            const int32_t f = s->edge_facet[e][j];
            n_known += f >= 0;
            if (!is_zero(s->tangent[e][j]))
                expect_unit(s->tangent[e][j]);
            for (int i = 0; f >= 0 && i < 2; i++)
                assert_true(s->facet[f][0] == v[i] || s->facet[f][1] == v[i] ||
                            s->facet[f][2] == v[i]);
            if (s->node_class[v[j]] == PL_ON_CURVE)
                assert_true(s->edge_at[v[j]][0] == e || s->edge_at[v[j]][1] == e);
        }
    }
    assert_true(n_known <= n_sides);
}

/** Expect what every shape promises, and the numbers of classes. */
static void expect_shape(const made *m) {
    const planish_shape *s = m->s;
    int64_t n[3] = {0};
    for (int64_t i = 0; i < s->n_nodes; i++) {
        n[s->node_class[i]]++;
        assert_int_equal(s->number[s->node[i]], i);
        assert_true(s->edge_length[i] > 0);
        if (s->node_class[i] == PL_ON_CURVE)
            assert_true(s->edge_at[i][0] >= 0 && s->edge_at[i][1] > s->edge_at[i][0]);
    }
    assert_int_equal(n[PL_ON_PATCH], m->info.n_on_patch);
    assert_int_equal(n[PL_ON_CURVE], m->info.n_on_curve);
    assert_int_equal(n[PL_CORNER], m->info.n_corners);
    assert_int_equal(s->n_nodes, m->info.n_nodes);
    expect_facets(s);
    expect_edges(s);
}

/* ---- features ------------------------------------------------------------------------------------ */

/** A known surface at a size, and its features. */
typedef struct known {
    const char *name;
    test_map *map;
    int n_pieces, nu, nv;
    int n_rims; /* times nu: feature edges */
    int n_patches;
} known;

static const known KNOWN[] = {
    {"sphere", test_sphere_map, 6, 1, 1, 0, 1},     {"torus", test_torus_map, 1, 6, 3, 0, 1},
    {"cylinder", test_cylinder_map, 3, 4, 3, 2, 3}, {"tee", test_tee_map, 2, 8, 2, 3, 2},
    {"fillet", test_fillet_map, 6, 2, 2, 0, 1},
};
enum { N_KNOWN = sizeof KNOWN / sizeof *KNOWN };

static void smooth_surfaces_have_no_false_creases(void **state) {
    static const int SIZES[] = {6, 9, 14};
    (void)state;
    for (int k = 0; k < N_KNOWN; k++)
        for (int i = 0; i < 3; i++)
            for (unsigned seed = 1; seed < 4; seed++) {
                const known *of = &KNOWN[k];
                test_surface m;
                const int nu = of->nu * SIZES[i], nv = of->nv * SIZES[i];
                test_surface_create(&m, of->n_pieces, of->map, nu, nv, 0.05 * seed, seed);
                made shape = make(&m.mesh, NULL, 1);
                expect_shape(&shape);
                if (shape.info.n_edges != of->n_rims * nu || shape.info.n_patches != of->n_patches)
                    fail_msg("%s %d: %d feature edges, %d patches", of->name, nu,
                             (int)shape.info.n_edges, (int)shape.info.n_patches);
                assert_int_equal(shape.info.n_on_curve, of->n_rims * nu - 4 * (k == 3));
                assert_int_equal(shape.info.n_corners, 4 * (k == 3)); /* of the tee's square */
                planish_shape_destroy(shape.s);
                test_surface_destroy(&m);
            }
}

static void prisms_keep_their_creases(void **state) {
    (void)state;
    for (int sides = 12; sides <= 36; sides += 12)
        for (int cut = 3; cut <= 5; cut++) {
            test_surface m;
            const int nv = 4;
            test_prism_sides = sides;
            test_surface_create(&m, 3 * sides, test_prism_map, cut, nv, 0.2, (unsigned)cut);
            made shape = make(&m.mesh, NULL, 1);
            expect_shape(&shape);
            assert_int_equal(shape.info.n_patches, sides + 2);
            assert_int_equal(shape.info.n_edges, sides * (2 * cut + nv));
            assert_int_equal(shape.info.n_creases, shape.info.n_edges);
            assert_int_equal(shape.info.n_corners, 2 * sides);
            planish_shape_destroy(shape.s);
            test_surface_destroy(&m);
        }
}

static void a_crease_angle_decides_alone(void **state) {
    (void)state;
    test_surface m;
    test_prism_sides = 24; /* turns by 15 degrees */
    test_surface_create(&m, 3 * 24, test_prism_map, 3, 4, 0.2, 1);
    for (int k = 0; k < 3; k++) {
        static const int64_t N_EDGES[] = {2 * 72 + 24 * 4, 2 * 72, 0};
        const planish_surface tags = {.crease_angle = (const double[]){14.999, 15.001, 100}[k]};
        made shape = make(&m.mesh, &tags, 1);
        expect_shape(&shape);
        assert_int_equal(shape.info.n_edges, N_EDGES[k]);
        planish_shape_destroy(shape.s);
    }
    test_surface_destroy(&m);
}

static void tags_and_regions_make_seams(void **state) {
    (void)state;
    test_surface m;
    test_surface_create(&m, 6, test_sphere_map, 8, 8, 0.2, 3);
    int32_t *half = malloc((size_t)m.n_facets * sizeof *half);
    int64_t n_tagged = 0, n_third = 0;
    for (int64_t f = 0; f < m.n_facets; f++) {
        half[f] = m.piece[f] == 5;
        n_tagged += m.piece[f] != 5;
        n_third += m.piece[f] == 0;
    }
    const int32_t edges[] = {m.facet[0][0], m.facet[0][1], 0, (int32_t)m.n_nodes - 1};
    const planish_surface by[] = {
        {.region = half},
        {.n_facets = n_tagged, .facets = m.facet[0], .facet_tag = NULL},
        {.n_facets = n_third, .facets = m.facet[0]},
        {.n_edges = 1, .edges = edges},
        {.n_edges = 1, .edges = edges + 2},
    };
    static const int N_EDGES[] = {32, 32, 32, 1, 0}, N_CORNERS[] = {4, 4, 4, 2, 2};
    for (int k = 0; k < 5; k++) {
        made shape = make(&m.mesh, &by[k], 1);
        expect_shape(&shape);
        assert_int_equal(shape.info.n_edges, N_EDGES[k]);
        assert_int_equal(shape.info.n_creases, 0);
        assert_int_equal(shape.info.n_patches, k < 3 ? 2 : 1);
        assert_true(shape.info.n_corners <= N_CORNERS[k]);
        /* normals go on across seams: both sides agree with the sphere's */
        for (int64_t f = 0; f < shape.s->n_facets; f++)
            for (int i = 0; i < 3; i++) {
                const double *x = shape.s->x[shape.s->facet[f][i]];
                const double *n = shape.s->corner_normal[f][i];
                assert_true(fabs(x[0] * n[0] + x[1] * n[1] + x[2] * n[2]) > length_of(x) * 0.99999);
            }
        planish_shape_destroy(shape.s);
    }
    free(half);
    test_surface_destroy(&m);
}

static int moebius_turns;

static void strip(int piece, double u, double v, double x[3]) {
    const double pi = 3.1415926535897932385, t = 2 * pi * u, w = 0.15 * (2 * v - 1);
    const double h = moebius_turns * t / 2;
    (void)piece;
    x[0] = (1 + w * cos(h)) * cos(t);
    x[1] = (1 + w * cos(h)) * sin(t);
    x[2] = w * sin(h);
}

static void moebius_strips_have_a_seam(void **state) {
    (void)state;
    for (moebius_turns = 0; moebius_turns < 2; moebius_turns++) {
        test_surface m;
        test_surface_create(&m, 1, strip, 60, 6, 0.2, 5);
        made shape = make(&m.mesh, NULL, 1);
        expect_shape(&shape);
        assert_int_equal(shape.info.n_patches, 1);
        const int64_t seam = shape.info.n_edges - 120;
        if (moebius_turns == 1)
            assert_in_range(seam, 6, 30);
        else
            assert_int_equal(seam, 0);
        assert_int_equal(shape.info.n_creases, 0);
        assert_true(shape.info.n_on_patch > 250);
        planish_shape_destroy(shape.s);
        test_surface_destroy(&m);
    }
}

static void squashed(int piece, double u, double v, double x[3]) {
    (void)piece;
    x[0] = u * 1e4;
    x[1] = v;
    x[2] = 0.01 * sin(9 * v);
}

static void doubled(int piece, double u, double v, double x[3]) {
    x[0] = u;
    x[1] = v;
    x[2] = piece ? 0 : 4 * u * (1 - u) * v * (1 - v);
    if (piece && u > 0 && u < 1 && v > 0 && v < 1)
        x[2] = u == 0.5 && v == 0.5 ? 1e-10 : 1e-7;
}

static void bad_surfaces_have_corners(void **state) {
    (void)state;
    test_surface m;
    test_surface_create(&m, 1, squashed, 12, 12, 0.2, 5);
    made needles = make(&m.mesh, NULL, 1);
    expect_shape(&needles);
    assert_int_equal(needles.info.n_edges, 48);
    assert_int_equal(needles.info.n_corners, 4);
    planish_shape_destroy(needles.s);

    /* a node on the line between two others of a facet, and one at the place of another one */
    memcpy(m.x[m.facet[40][0]], m.x[m.facet[40][1]], sizeof *m.x);
    made flat = make(&m.mesh, NULL, 1);
    expect_shape(&flat);
    for (int k = 0; k < 3; k++)
        assert_int_equal(flat.s->node_class[flat.s->number[m.facet[40][k]]], PL_CORNER);
    planish_shape_destroy(flat.s);
    test_surface_destroy(&m);

    /* a lens whose sides are joined at the border: the angle there is acute */
    test_surface_create(&m, 2, doubled, 10, 10, 0, 5);
    made lens = make(&m.mesh, NULL, 1);
    expect_shape(&lens);
    assert_true(lens.info.n_corners >= 4 && lens.info.n_on_patch > 100);
    planish_shape_destroy(lens.s);
    test_surface_destroy(&m);
}

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
    made shape = make(&m.mesh, NULL, 1);
    const planish_shape *s = shape.s;
    expect_shape(&shape);
    for (int32_t f = 0; f < s->n_facets; f++)
        for (int k = 0; k < 5; k++) {
            const pl_place p = random_place(f, 3, &random);
            double x[3], n[3], off = 0, turn = 0;
            pl_shape_point(s, PL_ON_PATCH, &p, x, n);
            for (int d = 0; d < 3; d++) {
                off += (x[d] - s->x[s->facet[f][0]][d]) * s->normal[f][d];
                turn += (n[d] - s->normal[f][d]) * (n[d] - s->normal[f][d]);
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
        assert_true(length_of(off) <= 1e-15 * length_of(along) * s->size);
        expect_unit(t);
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
            *off = fmax(*off, fabs(length_of(x) - 1));
            *sag = fmax(*sag, fabs(length_of(flat) - 1));
            *turn = fmax(*turn, 1 - fabs(pl_dot(3, x, n)) / length_of(x));
        }
}

static void points_come_close_to_spheres(void **state) {
    (void)state;
    double last = 1;
    for (int n = 6; n <= 24; n *= 2) {
        test_surface m;
        double off, turn, sag;
        test_surface_create(&m, 6, test_sphere_map, n, n, 0, 5);
        made shape = make(&m.mesh, NULL, 1);
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
        made shape = make(&m.mesh, NULL, 1);
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
            for (int k = 0; k < 3 && fabs(s->normal[f][2]) < 0.5; k++) {
                const double *x = s->x[s->facet[f][k]], *q = s->corner_normal[f][k];
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

/** Points at nodes are the nodes, and edges of patches look the same from both sides. */
static void surfaces_have_no_gaps(void **state) {
    (void)state;
    for (int k = 0; k < N_KNOWN; k++) {
        test_surface m;
        unsigned random = 3;
        test_surface_create(&m, KNOWN[k].n_pieces, KNOWN[k].map, KNOWN[k].nu * 6, KNOWN[k].nv * 6,
                            0.3, 5);
        made shape = make(&m.mesh, NULL, 1);
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
                const double distance = length_of(off);
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
    for (int k = 0; k < N_KNOWN; k++) {
        test_surface m;
        unsigned random = 3;
        test_surface_create(&m, KNOWN[k].n_pieces, KNOWN[k].map, KNOWN[k].nu * 5, KNOWN[k].nv * 5,
                            0.3, 5);
        made shape = make(&m.mesh, NULL, 1);
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
    made shape = make(&m.mesh, NULL, 1);
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
    made shape = make(&m.mesh, NULL, 1);
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
            assert_true(length_of(off) <= 1e-13 * length_of(along) * s->size);
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
    test_mesh ball;
    make_ball(&ball);
    test_mesh_renumber(&ball, 3, NULL);
    test_mesh_reverse_some(&ball, 3, 8);
    int32_t *region = two_halves(&ball.mesh);
    for (int k = 0; k < 2; k++) {
        const planish_surface tags = {.region = k ? region : NULL};
        made shape = make(&ball.mesh, &tags, 1);
        const planish_shape *s = shape.s;
        int64_t n_inside = 0;
        expect_shape(&shape);
        for (int32_t f = 0; f < s->n_facets; f++) {
            n_inside += s->is_interface[f];
            if (s->is_interface[f]) /* out of the lower region, which is above */
                assert_true(s->normal[f][2] < -0.99);
            else
                assert_true(pl_dot(3, s->normal[f], s->x[s->facet[f][0]]) > 0);
        }
        assert_int_equal(n_inside, k ? 2 * CELLS * CELLS : 0);
        assert_int_equal(s->n_facets, 12 * CELLS * CELLS + n_inside);
        assert_int_equal(s->n_edges, k ? 4 * CELLS : 0);
        planish_shape_destroy(shape.s);
    }
    free(region);
    test_mesh_destroy(&ball);
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
    made shape = make(&ball.mesh, &tags, 1);
    tags.shape = shape.s;
    const int64_t n_whole = expect_slides(&ball.mesh, &tags);
    assert_true(n_whole >= all - 8); /* bent corners of the box may stay */
    tags.tagged_only = 1;
    assert_int_equal(expect_slides(&ball.mesh, &tags), 0);
    tags.tagged_only = 0;

    /* a shape without the interface is another one there */
    tags.region = region;
    assert_int_equal(expect_slides(&ball.mesh, &tags), n_whole - equator);
    planish_shape_destroy(shape.s);
    shape = make(&ball.mesh, &tags, 1);
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
    shape = make(&ball.mesh, NULL, 1);
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
    made shape = make(&m.mesh, NULL, 1);
    planish_shape_distance d;
    planish_mesh wide = m.mesh;
    double *padded = malloc((size_t)m.n_nodes * 4 * sizeof *padded);
    wide.coordinates = padded;
    wide.node_stride = 4;
    for (int k = 0; k < 3;
         k++) { /* as it was; then nodes are moved along the cylinder, and off it */
        for (int64_t i = 0; i < m.n_nodes; i++) {
            double *x = m.x[i];
            const double r = sqrt(x[0] * x[0] + x[1] * x[1]), side = fabs(r - 0.5) < 1e-9;
            const double turn = (k == 1) * 0.02 * (test_random(&random) - 0.5);
            const double y[3] = {x[0] * cos(turn) - x[1] * sin(turn),
                                 x[0] * sin(turn) + x[1] * cos(turn), x[2]};
            for (int j = 0; j < 3; j++)
                x[j] = y[j] * (k == 2 && side && j < 2 ? 1.004 : 1);
            memcpy(padded + 4 * i, x, 3 * sizeof *x);
        }
        assert_int_equal(planish_measure_shape(shape.s, &wide, 1, &d, NULL), 0);
        assert_int_equal(d.n_unproved, 0);
        assert_true(d.max_bend_before > 7.49 && d.max_bend_before < 20);
        static const double LEAST[] = {0, 0, 0.002 * 0.999}, MOST[] = {0, 0.0012, 0.008};
        const double least = LEAST[k], most = MOST[k];
        assert_true(d.distance >= least && d.distance <= most);
        assert_true(d.distance_back >= least && d.distance_back <= most);
        assert_true(k == 0 ? d.in_edges == 0 && d.max_bend == d.max_bend_before
                           : d.in_edges > d.distance / 0.1 && d.in_edges < d.distance / 0.01);
        planish_shape_distance again;
        assert_int_equal(planish_measure_shape(shape.s, &m.mesh, 3, &again, NULL), 0);
        assert_memory_equal(&d, &again, sizeof d);
    }
    planish_error error = {.text = ""};
    wide.n_nodes--;
    assert_int_equal(planish_measure_shape(shape.s, &wide, 1, &d, &error), PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "nodes"));
    m.x[5][1] = INFINITY;
    assert_int_equal(planish_measure_shape(shape.s, &m.mesh, 1, &d, &error), PLANISH_ERROR_MESH);
    assert_int_equal(error.node, 5);
    assert_int_equal(planish_measure_shape(shape.s, &m.mesh, -1, &d, NULL), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_measure_shape(NULL, &m.mesh, 1, &d, NULL), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_measure_shape(shape.s, NULL, 1, &d, NULL), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_measure_shape(shape.s, &m.mesh, 1, NULL, NULL),
                     PLANISH_ERROR_ARGUMENT);
    free(padded);
    planish_shape_destroy(shape.s);
    test_surface_destroy(&m);
}

/* ---- threads, arguments, memory ------------------------------------------------------------------ */

static void expect_same(const planish_shape *a, const planish_shape *b) {
    const size_t n = (size_t)a->n_nodes, m = (size_t)a->n_facets, e = (size_t)a->n_edges;
    assert_true(a->n_nodes == b->n_nodes && a->n_facets == b->n_facets && a->n_edges == b->n_edges);
#define EXPECT_SAME(field, count)                                                                  \
    assert_memory_equal(a->field, b->field, (count) * sizeof *a->field)
    EXPECT_SAME(x, n);
    EXPECT_SAME(edge_length, n);
    EXPECT_SAME(node_class, n);
    EXPECT_SAME(edge_at, n);
    EXPECT_SAME(facet, m);
    EXPECT_SAME(normal, m);
    EXPECT_SAME(across, m);
    EXPECT_SAME(patch, m);
    EXPECT_SAME(corner_normal, m);
    EXPECT_SAME(edge, e);
    EXPECT_SAME(edge_facet, e);
    EXPECT_SAME(tangent, e);
#undef EXPECT_SAME
}

static void threads_make_the_same_shape(void **state) {
    (void)state;
    for (int k = 0; k < N_KNOWN; k++) {
        test_surface m;
        test_surface_create(&m, KNOWN[k].n_pieces, KNOWN[k].map, KNOWN[k].nu * 16, KNOWN[k].nv * 16,
                            0.3, 5);
        made one = make(&m.mesh, NULL, 1);
        assert_true(one.info.n_nodes > 700); /* several chunks */
        for (int threads = 2; threads < 6; threads++) {
            made some = make(&m.mesh, NULL, threads);
            expect_same(one.s, some.s);
            assert_memory_equal(&one.info, &some.info, sizeof one.info);
            planish_shape_destroy(some.s);
        }
        planish_shape_destroy(one.s);
        test_surface_destroy(&m);
    }
}

static void scales_make_the_same_shape(void **state) {
    (void)state;
    test_surface m;
    test_surface_create(&m, 3, test_cylinder_map, 24, 12, 0.3, 5);
    made one = make(&m.mesh, NULL, 1);
    static const int EXPONENTS[] = {-900, -40, 3, 900};
    for (int k = 0; k < 4; k++) {
        for (int64_t i = 0; i < 3 * m.n_nodes; i++)
            m.x[0][i] = ldexp(m.x[0][i], EXPONENTS[k] - (k ? EXPONENTS[k - 1] : 0));
        made other = make(&m.mesh, NULL, 1);
        expect_same(one.s, other.s);
        assert_true(other.info.edge_length == ldexp(one.info.edge_length, EXPONENTS[k]));
        planish_shape_destroy(other.s);
    }
    planish_shape_destroy(one.s);
    test_surface_destroy(&m);
}

static void wrong_arguments_are_refused(void **state) {
    (void)state;
    test_mesh box, flat;
    test_mesh_box(&box, 3, 2);
    test_mesh_box(&flat, 2, 2);
    planish_part part = {0};
    planish_mesh in_parts = box.mesh, nan = box.mesh;
    in_parts.part = &part;
    double *x = malloc(27 * 3 * sizeof *x);
    memcpy(x, box.coordinates, 27 * 3 * sizeof *x);
    x[31] = NAN;
    nan.coordinates = x;
    const int32_t bad[] = {0, 27};
    const planish_surface angles[] = {
        {.crease_angle = -1}, {.crease_angle = 180.5}, {.crease_angle = NAN}, {.tolerance = 1}};
    const planish_surface edges = {.n_edges = 1, .edges = bad};
    const struct {
        const planish_mesh *mesh;
        const planish_surface *surface;
        int threads, status;
    } refused[] = {
        {NULL, NULL, 1, PLANISH_ERROR_ARGUMENT},
        {&flat.mesh, NULL, 1, PLANISH_ERROR_ARGUMENT},
        {&in_parts, NULL, 1, PLANISH_ERROR_PARTS},
        {&nan, NULL, 1, PLANISH_ERROR_MESH},
        {&box.mesh, NULL, -1, PLANISH_ERROR_ARGUMENT},
        {&box.mesh, NULL, 1025, PLANISH_ERROR_ARGUMENT},
        {&box.mesh, &angles[0], 1, PLANISH_ERROR_ARGUMENT},
        {&box.mesh, &angles[1], 1, PLANISH_ERROR_ARGUMENT},
        {&box.mesh, &angles[2], 1, PLANISH_ERROR_ARGUMENT},
        {&box.mesh, &angles[3], 1, PLANISH_ERROR_ARGUMENT},
        {&box.mesh, &edges, 1, PLANISH_ERROR_ARGUMENT},
    };
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        planish_shape *shape = (planish_shape *)&box;
        planish_error error = {.text = ""};
        assert_int_equal(planish_shape_create(refused[i].mesh, refused[i].surface,
                                              refused[i].threads, &shape, NULL, &error),
                         refused[i].status);
        assert_null(shape);
        assert_true(strlen(error.text) > 10 && !strchr(error.text, '\n'));
    }
    assert_int_equal(planish_shape_create(&box.mesh, NULL, 1, NULL, NULL, NULL),
                     PLANISH_ERROR_ARGUMENT);
    planish_shape_destroy(NULL);

    /* a shape of another mesh, or in the plane */
    made shape = make(&box.mesh, NULL, 1);
    const planish_surface with = {.shape = shape.s};
    uint8_t constraint[64];
    double direction[192];
    test_mesh larger;
    test_mesh_box(&larger, 3, 3);
    assert_int_equal(planish_find_slides(&larger.mesh, &with, 1, constraint, direction, NULL, NULL),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_find_slides(&flat.mesh, &with, 1, constraint, direction, NULL, NULL),
                     PLANISH_ERROR_ARGUMENT);
    planish_shape_destroy(shape.s);
    free(x);
    test_mesh_destroy(&larger);
    test_mesh_destroy(&box);
    test_mesh_destroy(&flat);
}

static void memory_may_run_out(void **state) {
    (void)state;
    test_mesh box;
    test_mesh_box(&box, 3, 3);
    const int32_t edge[] = {0, 1};
    const planish_surface surface = {.n_edges = 1, .edges = edge};
    planish_shape *shape = NULL;
    int failures = 0, status = PLANISH_ERROR_MEMORY;
    for (; status == PLANISH_ERROR_MEMORY; failures++) {
        allocations_permit(failures);
        status = planish_shape_create(&box.mesh, &surface, 1, &shape, NULL, NULL);
        allocations_permit(-1);
        assert_true(!status == (shape != NULL));
    }
    assert_int_equal(status, 0);
    assert_true(failures > 40);
    planish_shape_destroy(shape);
    test_mesh_destroy(&box);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(smooth_surfaces_have_no_false_creases),
        cmocka_unit_test(prisms_keep_their_creases),
        cmocka_unit_test(a_crease_angle_decides_alone),
        cmocka_unit_test(tags_and_regions_make_seams),
        cmocka_unit_test(moebius_strips_have_a_seam),
        cmocka_unit_test(bad_surfaces_have_corners),
        cmocka_unit_test(planes_stay_planes),
        cmocka_unit_test(points_come_close_to_spheres),
        cmocka_unit_test(curves_come_close_to_circles),
        cmocka_unit_test(surfaces_have_no_gaps),
        cmocka_unit_test(walks_stay_on_their_patch),
        cmocka_unit_test(walks_find_the_nearest_place_of_a_sphere),
        cmocka_unit_test(walks_along_curves_end_at_corners),
        cmocka_unit_test(normals_point_outwards),
        cmocka_unit_test(curved_boundaries_slide_on_shapes),
        cmocka_unit_test(distances_are_measured),
        cmocka_unit_test(threads_make_the_same_shape),
        cmocka_unit_test(scales_make_the_same_shape),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(memory_may_run_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
