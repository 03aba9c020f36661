/* wholes: facets of second order against plain formulas. */
#include "shape/wholes.h"
#include "support/effort.h"
#include "support/facet_functions.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { KINDS = 5, SAMPLES = 12 };

/** A facet of 3, 4, 6, 8 or 9 nodes. */
static pl_whole make_whole(int kind) {
    static const uint8_t NODES[KINDS] = {3, 4, 6, 8, 9}, CORNERS[KINDS] = {3, 4, 3, 4, 4},
                         PARTS[KINDS] = {1, 2, 4, 6, 8};
    pl_whole whole = {
        .first = 7, .n_nodes = NODES[kind], .n_corners = CORNERS[kind], .n_parts = PARTS[kind]};
    for (int i = 0; i < whole.n_nodes; i++)
        whole.node[i] = 100 + i;
    return whole;
}

/** Nodes about where they are in a square, as far off as amount says. */
static void place_nodes(const pl_whole *whole, uint64_t *state, double amount, double x[9][3]) {
    for (int i = 0; i < whole->n_nodes; i++) {
        double uv[2];
        facet_place(whole->n_nodes, i, uv);
        for (int d = 0; d < 3; d++)
            x[i][d] = (d < 2 ? uv[d] : 0) + random_between(state, -amount, amount);
    }
}

static void point_at(const pl_whole *whole, const double x[9][3], const double uv[2],
                     double at[3]) {
    double by[9];
    facet_functions(whole->n_nodes, uv[0], uv[1], by);
    for (int d = 0; d < 3; d++) {
        at[d] = 0;
        for (int i = 0; i < whole->n_nodes; i++)
            at[d] += by[i] * x[i][d];
    }
}

/** The point of a part at weights, its u and v, and how far the facet is off the triangle there. */
static void find_off(const pl_whole *whole, const double x[9][3], int part, const double weight[3],
                     double uv[2], double off[3]) {
    const uint8_t *node = pl_whole_parts(whole)[part];
    uv[0] = uv[1] = 0;
    for (int k = 0; k < 3; k++) {
        double corner[2];
        facet_place(whole->n_nodes, node[k], corner);
        for (int d = 0; d < 2; d++)
            uv[d] += weight[k] * corner[d];
    }
    point_at(whole, x, uv, off);
    for (int k = 0; k < 3; k++)
        for (int d = 0; d < 3; d++)
            off[d] -= weight[k] * x[node[k]][d];
}

/** Check all points of a part of a facet. Returns how much of the rest there is. */
static double check_part(const pl_whole *whole, const double x[9][3], const double y[9][3],
                         int part) {
    const uint8_t *node = pl_whole_parts(whole)[part];
    double rise[3][3], most = 0;
    pl_whole_rises(whole, x, node, rise);
    const double rest = pl_whole_rest(whole, x, node), bend = pl_whole_bend(whole, x, node);
    const double way = pl_whole_way(whole, x, y);
    for (int i = 0; i <= SAMPLES; i++)
        for (int j = 0; i + j <= SAMPLES; j++) {
            const double w[3] = {(double)i / SAMPLES, (double)j / SAMPLES,
                                 (double)(SAMPLES - i - j) / SAMPLES};
            double uv[2], off[3], left[3], from[3], to[3], gone[3];
            find_off(whole, x, part, w, uv, off);
            for (int d = 0; d < 3; d++)
                left[d] = off[d] - w[0] * w[1] * rise[0][d] - w[1] * w[2] * rise[1][d] -
                          w[2] * w[0] * rise[2][d];
            assert_true(sqrt(pl_dot(3, off, off)) <= bend + 1e-13);
            assert_true(sqrt(pl_dot(3, left, left)) <= rest + 1e-13);
            most = fmax(most, sqrt(pl_dot(3, left, left)));
            point_at(whole, x, uv, from);
            point_at(whole, y, uv, to);
            pl_subtract(3, to, from, gone);
            assert_true(sqrt(pl_dot(3, gone, gone)) <= way + 1e-13);
        }
    return rest > 0 ? most / rest : 1;
}

static void facets_are_near_their_triangles(void **unused) {
    uint64_t state = effort_seed(1);
    (void)unused;
    for (int kind = 0; kind < KINDS; kind++) {
        const pl_whole whole = make_whole(kind);
        double sharpest = 0;
        for (int64_t n = effort(200, 100000); n > 0; n--) {
            double x[9][3], y[9][3];
            place_nodes(&whole, &state, 0.2, x);
            place_nodes(&whole, &state, 0.2, y);
            for (int part = 0; part < whole.n_parts; part++)
                sharpest = fmax(sharpest, check_part(&whole, (const double(*)[3])x,
                                                     (const double(*)[3])y, part));
        }
        figure("facets of %d nodes: at most %.2f of the bound", whole.n_nodes, sharpest);
        assert_true(sharpest > 0.5);
    }
}

/** Twice the area of a part in the plane of u and v. */
static double area_of(const pl_whole *whole, int part) {
    double uv[3][2];
    for (int k = 0; k < 3; k++)
        facet_place(whole->n_nodes, pl_whole_parts(whole)[part][k], uv[k]);
    return (uv[1][0] - uv[0][0]) * (uv[2][1] - uv[0][1]) -
           (uv[2][0] - uv[0][0]) * (uv[1][1] - uv[0][1]);
}

static int has_node(const pl_whole *whole, int32_t facet, int place) {
    const uint8_t *node = pl_whole_parts(whole)[facet - whole->first];
    return node[0] == place || node[1] == place || node[2] == place;
}

static void triangles_cover_facets(void **unused) {
    (void)unused;
    for (int kind = 0; kind < KINDS; kind++) {
        const pl_whole whole = make_whole(kind);
        const int n = whole.n_corners;
        double area = 0;
        for (int part = 0; part < whole.n_parts; part++) {
            assert_true(area_of(&whole, part) > 0);
            area += area_of(&whole, part);
        }
        assert_true(area == (n == 3 ? 1 : 2));
        for (int k = 0; k < n; k++) {
            const int mid = pl_whole_has_mids(&whole) ? n + k : (k + 1) % n;
            assert_true(has_node(&whole, pl_whole_rim(&whole, k, 0), k));
            assert_true(has_node(&whole, pl_whole_rim(&whole, k, 0), mid));
            assert_true(has_node(&whole, pl_whole_rim(&whole, k, 1), (k + 1) % n));
            if (pl_whole_has_mids(&whole))
                assert_true(has_node(&whole, pl_whole_rim(&whole, k, 1), mid));
        }
    }
}

static void corners_have_followers(void **unused) {
    (void)unused;
    for (int kind = 0; kind < KINDS; kind++) {
        const pl_whole whole = make_whole(kind);
        int n_pairs = 0, n_found = 0;
        for (int k = 0; k < whole.n_corners; k++) {
            int follower[PL_WHOLE_FOLLOWERS];
            const int n = pl_whole_followers(&whole, whole.node[k], follower);
            for (int i = 0; i < n; i++) {
                int parent[4], is_there = 0;
                const int n_parents = pl_whole_parents(&whole, follower[i], parent);
                for (int j = 0; j < n_parents; j++)
                    is_there |= parent[j] == k;
                assert_true(is_there);
                n_found++;
            }
        }
        for (int i = whole.n_corners; i < whole.n_nodes; i++) {
            int parent[4];
            n_pairs += pl_whole_parents(&whole, i, parent);
        }
        assert_int_equal(n_found, n_pairs);
        assert_int_equal(pl_whole_place(&whole, 1), -1);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(facets_are_near_their_triangles),
        cmocka_unit_test(triangles_cover_facets),
        cmocka_unit_test(corners_have_followers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
