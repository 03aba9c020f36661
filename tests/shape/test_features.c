/* planish_shape_create: features and classes, on any threads, of bad surfaces and arguments. */
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

static void smooth_surfaces_have_no_false_creases(void **state) {
    static const int SIZES[] = {6, 9, 14};
    (void)state;
    for (int k = 0; k < N_KNOWN_SURFACES; k++)
        for (int i = 0; i < 3; i++)
            for (unsigned seed = 1; seed < 4; seed++) {
                const known_surface *of = &KNOWN_SURFACES[k];
                test_surface m;
                const int nu = of->nu * SIZES[i], nv = of->nv * SIZES[i];
                test_surface_create(&m, of->n_pieces, of->map, nu, nv, 0.05 * seed, seed);
                made_shape shape = test_shape_make(&m.mesh, NULL, 1);
                test_shape_expect(&shape);
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
            made_shape shape = test_shape_make(&m.mesh, NULL, 1);
            test_shape_expect(&shape);
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
        made_shape shape = test_shape_make(&m.mesh, &tags, 1);
        test_shape_expect(&shape);
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
        made_shape shape = test_shape_make(&m.mesh, &by[k], 1);
        test_shape_expect(&shape);
        assert_int_equal(shape.info.n_edges, N_EDGES[k]);
        assert_int_equal(shape.info.n_creases, 0);
        assert_int_equal(shape.info.n_patches, k < 3 ? 2 : 1);
        assert_int_equal(shape.info.n_corners, N_CORNERS[k]);
        /* normals go on across seams: both sides agree with the sphere's */
        for (int32_t f = 0; f < shape.s->n_facets; f++)
            for (int i = 0; i < 3; i++) {
                const double *x = shape.s->x[shape.s->facet[f][i]];
                const double *n = pl_corner_normal(shape.s, f, i);
                assert_true(fabs(x[0] * n[0] + x[1] * n[1] + x[2] * n[2]) > pl_length(x) * 0.99999);
            }
        planish_shape_destroy(shape.s);
    }
    free(half);
    test_surface_destroy(&m);
}

static void roof(int piece, double u, double v, double x[3]) {
    const double bend = 0.6, ridge = 0.35, share = fmax(u - 0.5, 0), low = fmin(u, 0.5) * bend;
    const double from = 0.5 * bend + ridge, to = from + share * bend;
    (void)piece;
    x[0] = (sin(low) + sin(to) - sin(from)) / bend;
    x[1] = v;
    x[2] = (1 - cos(low) + cos(from) - cos(to)) / bend;
}

static void creases_of_curved_sheets_are_found(void **state) {
    (void)state;
    test_surface m;
    test_surface_create(&m, 1, roof, 12, 7, 0, 3); /* turns by 3 degrees, at the ridge by 20 */
    made_shape shape = test_shape_make(&m.mesh, NULL, 1);
    test_shape_expect(&shape);
    assert_int_equal(shape.info.n_creases, 7);
    assert_int_equal(shape.info.n_edges, 2 * 12 + 3 * 7);
    assert_int_equal(shape.info.n_corners, 6);
    planish_shape_destroy(shape.s);
    test_surface_destroy(&m);
}

static void flat(int piece, double u, double v, double x[3]) {
    (void)piece;
    x[0] = u;
    x[1] = v;
    x[2] = 0;
}

static void curves_end_where_tags_do(void **state) {
    (void)state;
    test_surface m;
    enum { N = 8 };
    test_surface_create(&m, 1, flat, N, N, 0.2, 3);
    int32_t node[5], edges[4][2];
    for (int i = 0; i < 5; i++)
        node[i] = (i + 2) * (N + 1) + 4;
    for (int i = 0; i < 4; i++) {
        edges[i][0] = node[i + 1];
        edges[i][1] = node[i];
    }
    static const int32_t TAGS[][4] = {{1, 1, 2, 2}, {7, 7, 7, 7}};
    for (int k = 0; k < 2; k++) {
        const planish_surface tags = {.n_edges = 4, .edges = edges[0], .edge_tag = TAGS[k]};
        made_shape shape = test_shape_make(&m.mesh, &tags, 1);
        test_shape_expect(&shape);
        assert_int_equal(shape.info.n_edges, 4 * N + 4);
        for (int i = 0; i < 5; i++)
            assert_int_equal(shape.s->node_class[node[i]],
                             i == 0 || i == 4 || (i == 2 && k == 0) ? PL_CORNER : PL_ON_CURVE);
        planish_shape_destroy(shape.s);
    }
    test_surface_destroy(&m);
}

/** The second sheet has a node of the first one's border inside of it. */
static void touching(int piece, double u, double v, double x[3]) {
    x[0] = piece ? 1 : u;
    x[1] = piece ? 0.5 + 0.37 * (u - 0.5) : v;
    x[2] = piece ? v - 0.5 : 0;
}

static void nodes_where_sheets_touch_are_corners(void **state) {
    (void)state;
    test_surface m;
    test_surface_create(&m, 2, touching, 10, 10, 0, 3);
    made_shape shape = test_shape_make(&m.mesh, NULL, 1);
    test_shape_expect(&shape);
    assert_int_equal(shape.info.n_nodes, 2 * 121 - 1);
    assert_int_equal(shape.info.n_corners, 4 + 4 + 1);
    planish_shape_destroy(shape.s);
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
        made_shape shape = test_shape_make(&m.mesh, NULL, 1);
        test_shape_expect(&shape);
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

/** Nine sides, each of two columns: as regular as rounding allows. */
static void nonagon(int piece, double u, double v, double x[3]) {
    const double pi = 3.1415926535897932385, t = 2 * pi * floor(9 * u + 1e-9) / 9;
    (void)piece;
    x[0] = 0.1 * cos(t) + 0.3;
    x[1] = 0.1 * sin(t) + 0.7;
    x[2] = v;
}

static void turns_of_forty_degrees_are_smooth(void **state) {
    (void)state;
    test_surface m;
    test_surface_create(&m, 1, nonagon, 9, 12, 0, 3);
    made_shape shape = test_shape_make(&m.mesh, NULL, 1);
    test_shape_expect(&shape);
    assert_int_equal(shape.info.n_edges, 2 * 9);
    assert_int_equal(shape.info.n_on_curve, 2 * 9);
    planish_shape_destroy(shape.s);
    test_surface_destroy(&m);
}

/** How many creases of at most 60 degrees have an end, within two, where no other feature is. */
static int count_short(const planish_shape *s) {
    int *n_at = calloc((size_t)s->n_nodes, sizeof *n_at), n_short = 0;
    for (int64_t e = 0; e < 2 * s->n_edges; e++)
        n_at[s->edge[e / 2][e % 2]]++;
    for (int64_t e = 0; e < 2 * s->n_edges; e++) {
        const int32_t from = s->edge[e / 2][e % 2], to = s->edge[e / 2][!(e % 2)];
        int32_t end = to, other = (int32_t)(e / 2);
        for (int64_t o = 0; n_at[to] == 2 && o < s->n_edges; o++)
            if (o != e / 2 && (s->edge[o][0] == to || s->edge[o][1] == to)) {
                other = (int32_t)o;
                end = s->edge[o][s->edge[o][0] == to];
            }
        int slight = 1;
        for (int k = 0; k < 2; k++) {
            const int32_t *f = s->edge_facet[k ? other : e / 2];
            double normal[2][3];
            for (int j = 0; j < 2 && f[1] >= 0; j++)
                pl_facet_normal(s, f[j], normal[j]);
            slight &= f[1] >= 0 && pl_dot(3, normal[0], normal[1]) > 0.5;
        }
        n_short += slight && n_at[from] == 1 && n_at[end] != 2;
    }
    free(n_at);
    return n_short;
}

static void short_creases_are_noise(void **state) {
    (void)state;
    int64_t n_creases = 0;
    for (unsigned seed = 1; seed < 30; seed++) {
        unsigned random = seed;
        test_surface m;
        test_surface_create(&m, 6, test_sphere_map, 14, 14, 0.2, seed);
        for (int64_t i = 0; i < m.n_nodes; i++) {
            const double share = 1 + 0.002 * seed * (test_random(&random) - 0.5);
            for (int d = 0; d < 3; d++)
                m.x[i][d] *= share;
        }
        made_shape shape = test_shape_make(&m.mesh, NULL, 1);
        test_shape_expect(&shape);
        assert_int_equal(count_short(shape.s), 0);
        assert_true(seed > 8 || shape.info.n_edges == 0); /* of 20 and less */
        n_creases += shape.info.n_creases;
        planish_shape_destroy(shape.s);
        const planish_surface tags = {.crease_angle = 15};
        made_shape given = test_shape_make(&m.mesh, &tags, 1);
        assert_true(seed != 10 || count_short(given.s) > 5); /* an angle decides alone */
        planish_shape_destroy(given.s);
        test_surface_destroy(&m);
    }
    assert_true(n_creases > 20); /* longer ones stay */
}

static double fold;

/** A fold that fades. */
static void fading(int piece, double u, double v, double x[3]) {
    const double rest = fmax(0.7 - v, 0);
    (void)piece;
    x[0] = u;
    x[1] = v;
    x[2] = fabs(u - 0.5) * rest * rest * fold;
}

static void folds_that_fade_stay(void **state) {
    static const int N_ROWS[] = {4, 5, 16, 32, 4};
    (void)state;
    for (int k = 0; k < 5; k++) {
        test_surface m;
        fold = k == 4 ? 2 : 0.6;
        test_surface_create(&m, 1, fading, 16, N_ROWS[k], 0, 3);
        made_shape shape = test_shape_make(&m.mesh, NULL, 1);
        test_shape_expect(&shape);
        assert_int_equal(count_short(shape.s), 0);
        const int64_t n = shape.info.n_creases;
        if (k < 2) /* it is of two edges, from the border */
            assert_int_equal(n, 0);
        else if (k == 4) /* it is sharp */
            assert_true(n > 0);
        else /* from 33 degrees to 5 */
            assert_in_range(n, N_ROWS[k] * 0.4, N_ROWS[k] * 0.5);
        assert_int_equal(shape.info.n_corners, 4 + 2 * (k >= 2));
        planish_shape_destroy(shape.s);
        test_surface_destroy(&m);
    }
}

/** A disk of one fan, tilted, whose nodes are up to wobble above it, or one of them by -wobble, and a rim that turns
 *  from it by 20 degrees. */
static void fan(test_surface *m, int n, double wobble) {
    moebius_turns = 0;
    test_surface_create(m, 1, strip, n, 2, 0, 3); /* a ring: its inner nodes become the hub */
    const double pi = 3.1415926535897932385;
    int32_t *number = malloc((size_t)m->n_nodes * sizeof *number);
    int64_t n_facets = 0;
    unsigned random = 7;
    for (int64_t i = 0; i < m->n_nodes; i++) {
        const double r = round((hypot(m->x[i][0], m->x[i][1]) - 0.85) / 0.15), h = r > 1 ? 1.2 : r;
        const double t = atan2(m->x[i][1], m->x[i][0]);
        number[i] = r > 0 ? (int32_t)i : 0;
        m->x[i][0] = h * cos(t);
        m->x[i][1] = h * sin(t);
        m->x[i][2] = (r > 1) * 0.2 * tan(pi / 9);
        if (r == 1)
            m->x[i][2] +=
                wobble < 0 ? (i == 3 * (n / 2) + 1) * -wobble : wobble * test_random(&random);
        m->x[i][0] += 0.3 * m->x[i][2];
        m->x[i][2] += 0.3 * (m->x[i][1] - m->x[i][0]);
    }
    for (int64_t f = 0; f < m->n_facets; f++) {
        int32_t v[3];
        for (int k = 0; k < 3; k++)
            v[k] = number[m->facet[f][k]];
        memcpy(m->facet[n_facets], v, sizeof v);
        n_facets += v[0] != v[1] && v[1] != v[2] && v[2] != v[0];
    }
    m->mesh.n_elements = m->cells.n = m->n_facets = n_facets;
    free(number);
}

static void hubs_have_the_same_rule(void **state) {
    (void)state;
    for (int k = 0; k < 9; k++) {
        static const int N[] = {40, 80, 700, 40, 80, 700, 40, 80, 700};
        test_surface m;
        fan(&m, N[k], (k < 3 ? 0 : k < 6 ? 2.5 : -1.7) / N[k]);
        made_shape shape = test_shape_make(&m.mesh, NULL, 1);
        test_shape_expect(&shape);
        if (k < 3) { /* the rim is a crease all around */
            assert_int_equal(shape.info.n_creases, N[k]);
            assert_int_equal(shape.info.n_patches, 2);
        } else
            assert_true(shape.info.n_creases < N[k] / 4);
        planish_shape_destroy(shape.s);
        test_surface_destroy(&m);
    }
}

static void what_a_mesh_has_not_makes_corners(void **state) {
    (void)state;
    test_mesh box;
    test_mesh_box(&box, 3, 4);
    int64_t n_planar = 0;
    for (int k = 0; k < 4; k++) {
        /* inside of sides of the box: no edge or facet has them all */
        const int32_t facet[] = {6, 13, 31}, edge[] = {6, k == 3 ? 31 : 18};
        const planish_surface tags = {
            .n_facets = k == 1, .facets = facet, .n_edges = k >= 2, .edges = edge};
        made_shape shape = test_shape_make(&box.mesh, &tags, 1);
        test_shape_expect(&shape);
        n_planar = k == 0 ? shape.info.n_on_patch : n_planar;
        const int32_t *node = k == 1 ? facet : edge;
        int64_t n_corners = 0;
        for (int i = 0; i < (k == 0 ? 0 : k == 1 ? 3 : 2); i++) {
            const int32_t own = shape.s->number[node[i]];
            n_corners += own >= 0;
            assert_true(own < 0 || shape.s->node_class[own] == PL_CORNER);
        }
        assert_true(k == 0 || n_corners >= 2 - (k == 3));
        assert_int_equal(shape.info.n_on_patch, n_planar - n_corners);
        planish_shape_destroy(shape.s);
    }
    test_mesh_destroy(&box);
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
    made_shape needles = test_shape_make(&m.mesh, NULL, 1);
    test_shape_expect(&needles);
    assert_int_equal(needles.info.n_edges, 48);
    assert_int_equal(needles.info.n_corners, 4);
    planish_shape_destroy(needles.s);
    test_surface_destroy(&m);

    /* a node on the line between two others of a facet */
    test_surface_create(&m, 1, squashed, 12, 12, 0.2, 5);
    const int32_t *line = m.facet[120];
    for (int d = 0; d < 3; d++)
        m.x[line[0]][d] = 0.3 * m.x[line[1]][d] + 0.7 * m.x[line[2]][d];
    made_shape thin = test_shape_make(&m.mesh, NULL, 1);
    test_shape_expect(&thin);
    for (int k = 0; k < 3; k++)
        assert_int_equal(thin.s->node_class[thin.s->number[line[k]]], PL_CORNER);
    planish_shape_destroy(thin.s);
    test_surface_destroy(&m);

    /* the same with nothing else amiss: a node on the diagonal of its square */
    test_surface_create(&m, 1, flat, 8, 8, 0, 5);
    int at = 0; /* corner of the right angle */
    for (int k = 0; k < 3; k++) {
        double to[2][3];
        for (int j = 0; j < 2; j++)
            pl_from_to(3, m.x[m.facet[40][k]], m.x[m.facet[40][(k + 1 + j) % 3]], to[j]);
        if (pl_dot(3, to[0], to[1]) == 0)
            at = k;
    }
    const int32_t b = m.facet[40][at];
    for (int d = 0; d < 3; d++)
        m.x[b][d] = (m.x[m.facet[40][(at + 1) % 3]][d] + m.x[m.facet[40][(at + 2) % 3]][d]) / 2;
    made_shape moved = test_shape_make(&m.mesh, NULL, 1);
    test_shape_expect(&moved);
    assert_int_equal(moved.info.n_edges, 4 * 8 + 3);
    assert_int_equal(moved.info.n_corners, 4 + 3);
    assert_int_equal(moved.s->node_class[b], PL_CORNER);
    planish_shape_destroy(moved.s);
    test_surface_destroy(&m);

    /* a node at the place of another one */
    test_surface_create(&m, 1, squashed, 12, 12, 0.2, 5);
    memcpy(m.x[m.facet[40][0]], m.x[m.facet[40][1]], sizeof *m.x);
    made_shape flat = test_shape_make(&m.mesh, NULL, 1);
    test_shape_expect(&flat);
    for (int k = 0; k < 3; k++)
        assert_int_equal(flat.s->node_class[flat.s->number[m.facet[40][k]]], PL_CORNER);
    planish_shape_destroy(flat.s);
    test_surface_destroy(&m);

    /* a lens whose sides are joined at the border: the angle there is acute */
    test_surface_create(&m, 2, doubled, 10, 10, 0, 5);
    made_shape lens = test_shape_make(&m.mesh, NULL, 1);
    test_shape_expect(&lens);
    assert_true(lens.info.n_corners >= 4 && lens.info.n_on_patch > 100);
    planish_shape_destroy(lens.s);
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
    EXPECT_SAME(normal_at, n + 1);
    EXPECT_SAME(corner_normal, a->normal_at[n]);
    EXPECT_SAME(edge, e);
    EXPECT_SAME(edge_facet, e);
    EXPECT_SAME(tangent, e);
#undef EXPECT_SAME
}

static void threads_make_the_same_shape(void **state) {
    (void)state;
    for (int k = 0; k < N_KNOWN_SURFACES; k++) {
        test_surface m;
        test_surface_create(&m, KNOWN_SURFACES[k].n_pieces, KNOWN_SURFACES[k].map,
                            KNOWN_SURFACES[k].nu * 16, KNOWN_SURFACES[k].nv * 16, 0.3, 5);
        made_shape one = test_shape_make(&m.mesh, NULL, 1);
        assert_true(one.info.n_nodes > 700); /* several chunks */
        for (int threads = 2; threads < 6; threads++) {
            made_shape some = test_shape_make(&m.mesh, NULL, threads);
            expect_same(one.s, some.s);
            assert_memory_equal(&one.info, &some.info, sizeof one.info);
            planish_shape_destroy(some.s);
        }
        planish_shape_destroy(one.s);
        test_surface_destroy(&m);
    }
}

/** Elements of any nodes: facets of any number of elements, with regions and tags of any kind. */
static void any_mesh_has_a_shape(void **state) {
    (void)state;
    unsigned random = 5;
    for (unsigned seed = 0; seed < 100; seed++) {
        test_mesh m;
        const int64_t n = 8 + seed % 30, n_elements = 1 + 3 * seed;
        test_mesh_garbage(&m, 3, n, n_elements, seed);
        int32_t region[300], facets[20][3], edges[20][2];
        for (int64_t i = 0; i < n_elements; i++)
            region[i] = (int32_t)(3 * test_random(&random));
        for (int i = 0; i < 20; i++) {
            const int64_t element = (int64_t)(test_random(&random) * (double)n_elements);
            for (int k = 0; k < 3; k++)
                facets[i][k] = m.elements[4 * element + (k + i) % 4];
            for (int k = 0; k < 2; k++)
                edges[i][k] = (int32_t)(test_random(&random) * (double)n);
        }
        const planish_surface tags = {.region = seed % 2 ? region : NULL,
                                      .n_facets = seed % 3 ? 20 : 0,
                                      .facets = facets[0],
                                      .n_edges = seed % 5 ? 0 : 20,
                                      .edges = edges[0]};
        made_shape one = test_shape_make(&m.mesh, &tags, 1);
        made_shape three = test_shape_make(&m.mesh, &tags, 3);
        test_shape_expect(&one);
        expect_same(one.s, three.s);
        planish_shape_destroy(one.s);
        planish_shape_destroy(three.s);
        test_mesh_destroy(&m);
    }
}

static void scales_make_the_same_shape(void **state) {
    (void)state;
    test_surface m;
    test_surface_create(&m, 3, test_cylinder_map, 24, 12, 0.3, 5);
    made_shape one = test_shape_make(&m.mesh, NULL, 1);
    static const int EXPONENTS[] = {-900, -40, 3, 900};
    for (int k = 0; k < 4; k++) {
        for (int64_t i = 0; i < 3 * m.n_nodes; i++)
            m.x[i / 3][i % 3] = ldexp(m.x[i / 3][i % 3], EXPONENTS[k] - (k ? EXPONENTS[k - 1] : 0));
        made_shape other = test_shape_make(&m.mesh, NULL, 1);
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
    made_shape shape = test_shape_make(&box.mesh, NULL, 1);
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

/** Number of facets of a box of which an element is listed twice, -1: none is; no edge of them is open. */
static int64_t count_facets_with(int64_t element) {
    test_mesh box;
    test_mesh_box(&box, 3, 2);
    planish_mesh mesh = box.mesh;
    const size_t n = (size_t)mesh.n_elements * 4;
    int32_t *node = malloc((n + 4) * sizeof *node);
    memcpy(node, mesh.elements, n * sizeof *node);
    if (element >= 0) {
        memcpy(node + n, node + 4 * element, 4 * sizeof *node);
        mesh.n_elements++;
    }
    mesh.elements = node;
    made_shape shape = test_shape_make(&mesh, NULL, 1);
    assert_int_equal(shape.info.n_open_edges, 0);
    planish_shape_destroy(shape.s);
    free(node);
    test_mesh_destroy(&box);
    return shape.info.n_facets;
}

/** The surface has the boundary's facets of an element that is listed twice, and those inside: three elements
 *  have these. */
static void elements_that_are_listed_twice_leave_no_hole(void **state) {
    (void)state;
    enum { OUTER = 6 * 2 * 2 * 2 };
    assert_int_equal(count_facets_with(-1), OUTER);
    for (int64_t element = 0; element < 6 * 2 * 2 * 2; element++) {
        const int64_t n = count_facets_with(element) - OUTER;
        assert_true(n >= 2 && n <= 4);
    }
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
        cmocka_unit_test(creases_of_curved_sheets_are_found),
        cmocka_unit_test(curves_end_where_tags_do),
        cmocka_unit_test(nodes_where_sheets_touch_are_corners),
        cmocka_unit_test(what_a_mesh_has_not_makes_corners),
        cmocka_unit_test(moebius_strips_have_a_seam),
        cmocka_unit_test(turns_of_forty_degrees_are_smooth),
        cmocka_unit_test(short_creases_are_noise),
        cmocka_unit_test(folds_that_fade_stay),
        cmocka_unit_test(hubs_have_the_same_rule),
        cmocka_unit_test(bad_surfaces_have_corners),
        cmocka_unit_test(threads_make_the_same_shape),
        cmocka_unit_test(any_mesh_has_a_shape),
        cmocka_unit_test(scales_make_the_same_shape),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(elements_that_are_listed_twice_leave_no_hole),
        cmocka_unit_test(memory_may_run_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
