#include "support/surfaces.h"

#include "support/meshes.h"

#include "geometry/cell.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double PI = 3.1415926535897932385;

/** The node at a place; a new one if there is none. */
static int32_t node_at(test_surface *s, const double x[3]) {
    for (int64_t i = 0; i < s->n_nodes; i++)
        if (fabs(s->x[i][0] - x[0]) + fabs(s->x[i][1] - x[1]) + fabs(s->x[i][2] - x[2]) < 1e-9)
            return (int32_t)i;
    memcpy(s->x[s->n_nodes], x, 3 * sizeof *x);
    return (int32_t)s->n_nodes++;
}

static void add_triangle(test_surface *s, int piece, int32_t a, int32_t b, int32_t c) {
    if (a == b || b == c || c == a)
        return;
    const int64_t i = s->n_facets++;
    s->facet[i][0] = a;
    s->facet[i][1] = b;
    s->facet[i][2] = c;
    s->piece[i] = piece;
}

void test_surface_create(test_surface *s, int n_pieces, test_map *map, int nu, int nv,
                         double jitter, unsigned seed) {
    const int64_t most = (int64_t)n_pieces * (nu + 1) * (nv + 1);
    unsigned state = seed;
    *s = (test_surface){0};
    s->x = malloc((size_t)most * sizeof *s->x);
    s->facet = malloc(2 * (size_t)most * sizeof *s->facet);
    s->piece = malloc(2 * (size_t)most * sizeof *s->piece);
    int32_t *grid = malloc((size_t)(nu + 1) * (size_t)(nv + 1) * sizeof *grid);
    for (int p = 0; p < n_pieces; p++) {
        for (int i = 0; i <= nu; i++)
            for (int j = 0; j <= nv; j++) {
                const int inner = i > 0 && i < nu && j > 0 && j < nv;
                const double di = (2 * test_random(&state) - 1) * (inner ? jitter : 0);
                const double dj = (2 * test_random(&state) - 1) * (inner ? jitter : 0);
                double x[3];
                map(p, (i + di) / nu, (j + dj) / nv, x);
                grid[i * (nv + 1) + j] = node_at(s, x);
            }
        for (int i = 0; i < nu; i++)
            for (int j = 0; j < nv; j++) {
                const int32_t *v = grid + i * (nv + 1) + j, *w = v + nv + 1;
                const int other = test_random(&state) < 0.5;
                add_triangle(s, p, v[0], w[0], other ? v[1] : w[1]);
                add_triangle(s, p, other ? w[0] : v[0], w[1], v[1]);
            }
    }
    free(grid);
    s->offset = malloc((size_t)(s->n_facets + 1) * sizeof *s->offset);
    s->type = malloc((size_t)s->n_facets);
    for (int64_t i = 0; i <= s->n_facets; i++)
        s->offset[i] = 3 * i;
    memset(s->type, PLANISH_CELL_TRIANGLE, (size_t)s->n_facets);
    s->cells = (planish_cells){
        .n = s->n_facets, .type = s->type, .offset = s->offset, .node = s->facet[0]};
    s->mesh = (planish_mesh){.dim = 3,
                             .n_nodes = s->n_nodes,
                             .coordinates = s->x[0],
                             .n_elements = s->n_facets,
                             .cells = &s->cells};
}

void test_surface_destroy(test_surface *s) {
    free(s->x);
    free(s->facet);
    free(s->piece);
    free(s->offset);
    free(s->type);
}

/* ---- maps ------------------------------------------------------------------------------------ */

/** A point of side p of the cube from -1 to 1, turned outwards. */
static void on_cube(int p, double a, double b, double x[3]) {
    const int axis = p / 2, sign = p % 2 ? 1 : -1;
    x[axis] = sign;
    x[(axis + 1) % 3] = sign * a;
    x[(axis + 2) % 3] = b;
}

void test_sphere_map(int p, double u, double v, double x[3]) {
    on_cube(p, tan(PI / 4 * (2 * u - 1)), tan(PI / 4 * (2 * v - 1)), x);
    const double length = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
    for (int d = 0; d < 3; d++)
        x[d] /= length;
}

void test_torus_map(int p, double u, double v, double x[3]) {
    const double r = 1 + 0.3 * cos(2 * PI * v);
    (void)p;
    x[0] = r * cos(2 * PI * u);
    x[1] = r * sin(2 * PI * u);
    x[2] = 0.3 * sin(2 * PI * v);
}

/** A point of the side (0), bottom (1) or top of what has a border around. */
static void on_side_or_end(int kind, const double around[2], double v, double height, double x[3]) {
    const double share = kind == 0 ? 1 : kind == 1 ? v : 1 - v;
    x[0] = share * around[0];
    x[1] = share * around[1];
    x[2] = kind == 0 ? v * height : kind == 1 ? 0 : height;
}

void test_cylinder_map(int p, double u, double v, double x[3]) {
    const double around[] = {0.5 * cos(2 * PI * u), 0.5 * sin(2 * PI * u)};
    on_side_or_end(p, around, v, 2, x);
}

int test_prism_sides = 12;

void test_prism_map(int p, double u, double v, double x[3]) {
    double around[2] = {0};
    for (int k = 0; k < 2; k++) {
        const double angle = 2 * PI * (p % test_prism_sides + k) / test_prism_sides;
        around[0] += (k ? u : 1 - u) * cos(angle);
        around[1] += (k ? u : 1 - u) * sin(angle);
    }
    on_side_or_end(p / test_prism_sides, around, v, 0.7, x);
}

void test_tee_map(int p, double u, double v, double x[3]) {
    const double big = 0.5, small = 0.35, angle = 2 * PI * u, c = cos(angle), s = sin(angle);
    const double foot = sqrt(big * big - small * small * s * s);
    if (p == 0) {
        x[0] = small * c;
        x[1] = small * s;
        x[2] = foot + v * (1.2 - foot);
        return;
    }
    /* from the border, a square on the other cylinder, to the foot */
    const double far = 0.6 / fmax(fabs(c), fabs(s));
    const double along = (1 - v) * far * c + v * small * c;
    const double arc = (1 - v) * far * s + v * big * asin(small * s / big);
    x[0] = along;
    x[1] = big * sin(arc / big);
    x[2] = big * cos(arc / big);
}

void test_fillet_map(int p, double u, double v, double x[3]) {
    static const double INNER[3] = {0.8, 0.6, 0.5}, ROUND = 0.3;
    double off[3], length = 0;
    on_cube(p, 2 * u - 1, 2 * v - 1, x);
    for (int d = 0; d < 3; d++) {
        x[d] *= INNER[d] + ROUND;
        const double inside = fmax(-INNER[d], fmin(INNER[d], x[d]));
        off[d] = x[d] - inside;
        x[d] = inside;
        length += off[d] * off[d];
    }
    for (int d = 0; d < 3; d++)
        x[d] += ROUND * off[d] / sqrt(length);
}

const known_surface KNOWN_SURFACES[N_KNOWN_SURFACES] = {
    {"sphere", test_sphere_map, 6, 1, 1, 0, 1},     {"torus", test_torus_map, 1, 6, 3, 0, 1},
    {"cylinder", test_cylinder_map, 3, 4, 3, 2, 3}, {"tee", test_tee_map, 2, 8, 2, 3, 2},
    {"fillet", test_fillet_map, 6, 2, 2, 0, 1},
};

void test_surface_known(test_surface *surface, int k, int size, double jitter, unsigned seed) {
    const known_surface *of = &KNOWN_SURFACES[k];
    test_surface_create(surface, of->n_pieces, of->map, of->nu * size, of->nv * size, jitter, seed);
}

made_shape test_shape_make(const planish_mesh *mesh, const planish_surface *tags, int threads) {
    made_shape m;
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
        double normal[3], kept[3];
        pl_facet_normal(s, f, normal);
        pl_kept_normal(s, f, kept);
        if (!is_zero(kept)) {
            expect_unit(normal);
            assert_true(pl_distance(3, normal, kept) <= PL_KEPT_NORMAL_OFF);
        }
        for (int k = 0; k < 3; k++) {
            const int32_t g = s->across[f][k], a = s->facet[f][k], b = s->facet[f][(k + 1) % 3];
            int is_met = g < 0;
            for (int m = 0; g >= 0 && m < 3; m++)
                is_met |=
                    s->across[g][m] == f && s->facet[g][m] == b && s->facet[g][(m + 1) % 3] == a;
            assert_true(is_met && (g < 0 || s->patch[g] == s->patch[f]));
            if (!is_zero(pl_corner_normal(s, f, k)))
                expect_unit(pl_corner_normal(s, f, k));
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

void test_shape_expect(const made_shape *m) {
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
