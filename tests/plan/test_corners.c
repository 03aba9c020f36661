/* Tests of plans whose elements are corners of cells: src/topology/corners.c, cell_orientation.c,
 * rings.c, stars.c and src/plan. */
#include "geometry/corner.h"
#include "plan/plan.h"
#include "topology/cell_star.h"

#include "support/cell_meshes.h"

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

static planish_plan *plan_of(const planish_mesh *mesh, const planish_options *options) {
    planish_error error;
    planish_plan *plan = NULL;
    assert_int_equal(planish_plan_create(mesh, options, &plan, &error), PLANISH_OK);
    return plan;
}

/** Star of the node, the caller's number. */
static int64_t star_of(const planish_plan *plan, int32_t node) {
    for (int64_t s = 0; s < plan->interior.stars.n_stars; s++)
        if (plan->interior.centre[s] == plan->inner[node])
            return s;
    return -1;
}

/** Whether node is used by cells alone whose every facet there has two of them: by its place. */
static int is_inside(const cell_box *b, int n, int32_t node) {
    int inside = 1;
    for (int d = 0; d < b->mesh.dim; d++) {
        const double x = b->x[(int64_t)node * b->mesh.dim + d];
        inside &= x > 0 && x < n;
    }
    return inside;
}

static int node_of_facet(const planish_plan *plan, int64_t s, int64_t facet, int j) {
    const pl_stars *stars = &plan->interior.stars;
    const pl_link link = pl_link_at(&stars->link, pl_link_positions(plan->dim, stars->form != NULL),
                                    stars->link_offset[s]);
    return stars->ring[stars->ring_offset[s] + pl_link_get(&link, facet * plan->dim + j)];
}

/** Determinant of the facet's corner as kernels see it: (x - p0) . (p1 - p0) x (p2 - p0). */
static double determinant(const planish_plan *plan, const double *inside, int64_t s,
                          int64_t facet) {
    const int dim = plan->dim;
    const double *p[4] = {inside + (int64_t)plan->interior.centre[s] * dim};
    double e[3][3] = {{0}};
    for (int j = 0; j < dim; j++)
        p[j + 1] = inside + (int64_t)node_of_facet(plan, s, facet, j) * dim;
    for (int d = 0; d < dim; d++) {
        e[0][d] = p[0][d] - p[1][d];
        e[1][d] = p[2][d] - p[1][d];
        e[2][d] = dim == 3 ? p[3][d] - p[1][d] : 0;
    }
    if (dim == 2) /* (p0 - x) x (p1 - x) */
        return e[1][0] * e[0][1] - e[1][1] * e[0][0];
    return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
           e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
           e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
}

/** Check the star of a node against the cells: its ring is all their other nodes, and its facets are
 *  their corners with the node. n_balls: the cells at the node make so many balls around it. */
static void check_star(const planish_plan *plan, const cell_box *b, const double *inside,
                       int32_t node, int n_balls) {
    const int64_t s = star_of(plan, node);
    const pl_stars *stars = &plan->interior.stars;
    assert_true(s >= 0);
    uint8_t *is_near = calloc((size_t)b->mesh.n_nodes, 1);
    int64_t n_corners = 0, n_ring = 0, twice = b->mesh.dim == 3 ? 4 : 0;
    double share = 0;
    int n_cells = 0;
    pl_cell_kind kinds[PL_CELL_KINDS];
    pl_cell_kinds_make(b->mesh.dim, kinds);
    for (int64_t c = 0; c < b->cells.n; c++) {
        const int32_t *v = b->node + b->offset[c];
        const pl_cell_shape *shape = pl_cell_type_of(b->type[c])->shape;
        int place = -1;
        for (int j = 0; j < shape->n_corners; j++)
            place = v[j] == node ? j : place;
        if (place < 0)
            continue;
        n_cells++;
        twice += kinds[pl_kind_of_shape(shape)].twice;
        for (int j = 0; j < shape->n_corners; j++)
            is_near[v[j]] = v[j] != node;
        if (shape->n_simplices == 1) {
            n_corners++;
            continue;
        }
        for (int j = 0; j < shape->n_measured; j++) {
            int has = j == place;
            for (int k = 0; k < b->mesh.dim; k++)
                has |= shape->neighbour[j][k] == place;
            n_corners += has;
        }
    }
    for (int64_t i = 0; i < b->mesh.n_nodes; i++)
        n_ring += is_near[i];
    const int64_t first = stars->link_offset[s], n = stars->link_offset[s + 1] - first;
    assert_int_equal(n, n_corners);
    assert_int_equal(stars->ring_offset[s + 1] - stars->ring_offset[s], n_ring);
    assert_int_equal(twice, 2 * n_ring - 4 * (n_balls - 1)); /* as rings.c foretells it */
    for (int64_t i = 0; i < n; i++) {
        const pl_corner_form *form = &plan->form[stars->form[first + i]];
        assert_true(determinant(plan, inside, s, i) > 0);
        share += form->share * (form->corner < 0);
    }
    assert_true(n_cells > 0 && share <= n_cells + 1e-12);
    free(is_near);
}

/** Every cell's corners are consecutive, and say which they are. */
static void check_corners(const planish_plan *plan, const cell_box *b) {
    const pl_view *v = &plan->work;
    assert_int_equal(v->n_cells, b->cells.n);
    assert_int_equal(v->cell_begin[v->n_cells], v->n_elements);
    for (int64_t c = 0; c < v->n_cells; c++) {
        const pl_cell_shape *shape = pl_cell_type_of(b->type[c])->shape;
        const int n = shape->n_simplices == 1 ? 1 : shape->n_measured;
        assert_int_equal(v->cell_begin[c + 1] - v->cell_begin[c], n);
        for (int j = 0; j < n; j++) {
            const int64_t e = v->cell_begin[c] + j;
            assert_int_equal(plan->cell_of[e], c);
            assert_int_equal(v->corner[e], pl_corner_code(pl_kind_of_shape(shape), j));
            assert_int_equal(v->elements[e * (plan->dim + 1)], b->node[b->offset[c] + j]);
        }
    }
}

/** Nodes of one colour share no cell. */
static void check_colours(const planish_plan *plan, const cell_box *b) {
    int *colour = malloc((size_t)b->mesh.n_nodes * sizeof *colour);
    for (int64_t i = 0; i < b->mesh.n_nodes; i++)
        colour[i] = -1;
    for (int c = 0; c < plan->interior.n_colours; c++)
        for (int64_t s = plan->interior.colour_begin[c]; s < plan->interior.colour_begin[c + 1];
             s++)
            colour[plan->interior.centre[s]] = c;
    for (int64_t c = 0; c < b->cells.n; c++)
        for (int64_t i = b->offset[c]; i < b->offset[c + 1]; i++)
            for (int64_t j = b->offset[c]; j < i; j++) {
                const int one = colour[plan->inner[b->node[i]]];
                assert_true(one < 0 || one != colour[plan->inner[b->node[j]]]);
            }
    free(colour);
}

/** Turn every other cell over: the same cell in its mirrored order. */
static void turn_over(cell_box *b) {
    static const uint8_t mirrored[9][8] = {[4] = {0, 3, 2, 1},
                                           [5] = {0, 3, 2, 1, 4},
                                           [6] = {3, 4, 5, 0, 1, 2},
                                           [8] = {4, 5, 6, 7, 0, 1, 2, 3}};
    for (int64_t c = 0; c < b->cells.n; c += 2) {
        int32_t *v = b->node + b->offset[c], kept[8];
        const int64_t n = b->offset[c + 1] - b->offset[c];
        if (n == 3)
            continue;
        memcpy(kept, v, (size_t)n * sizeof *v);
        for (int j = 0; j < n; j++)
            v[j] = kept[mirrored[n][j]];
    }
}

static void test_plans(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++)
        for (int is_turned = 0; is_turned < 2; is_turned++) {
            enum { SIDE = 4 };
            cell_box *b = cell_box_create((cell_box_kind)kind, SIDE);
            if (is_turned)
                turn_over(b);
            planish_plan *plan = plan_of(&b->mesh, NULL);
            planish_plan_info info;
            double *inside = malloc((size_t)(b->mesh.n_nodes * 3) * sizeof *inside);
            int64_t n_inside = 0;
            planish_plan_get_info(plan, &info);
            pl_plan_order(plan, b->x, inside);
            check_corners(plan, b);
            for (int32_t i = 0; i < b->mesh.n_nodes; i++) {
                assert_int_equal(star_of(plan, i) >= 0, is_inside(b, SIDE, i));
                n_inside += is_inside(b, SIDE, i);
                if (is_inside(b, SIDE, i))
                    check_star(plan, b, inside, i, 1);
            }
            check_colours(plan, b);
            assert_int_equal(info.n_free, n_inside);
            assert_int_equal(info.n_nonmanifold_facets, 0);
            assert_int_equal(info.n_duplicate_elements, 0);
            if (kind == BOX_HEXAHEDRA) {
                assert_int_equal(info.n_boundary_facets, 6 * SIDE * SIDE);
                assert_int_equal(info.n_colours, 8);
                assert_int_equal(plan->interior.stars.max_ring, 26);
                assert_int_equal(plan->interior.stars.max_link, 32);
            }
            free(inside);
            planish_plan_destroy(plan);
            cell_box_destroy(b);
        }
}

/** Make a mesh in 3-D of n_cells cells of one type, whose nodes [n_cells][n_each] and coordinates are
 *  left to be filled. To be released by release_own. */
static cell_box make_own(int64_t n_nodes, int64_t n_cells, planish_cell_type type, int n_each) {
    cell_box b = {.x = calloc((size_t)(3 * n_nodes), sizeof *b.x),
                  .node = calloc((size_t)(n_cells * n_each), sizeof *b.node),
                  .offset = calloc((size_t)n_cells + 1, sizeof *b.offset),
                  .type = calloc((size_t)n_cells, 1)};
    assert_true(b.x && b.node && b.offset && b.type);
    memset(b.type, (int)type, (size_t)n_cells);
    for (int64_t i = 0; i <= n_cells; i++)
        b.offset[i] = n_each * i;
    b.cells = (planish_cells){.n = n_cells, .type = b.type, .offset = b.offset, .node = b.node};
    b.mesh = (planish_mesh){
        .dim = 3, .n_nodes = n_nodes, .n_elements = n_cells, .coordinates = b.x, .cells = &b.cells};
    return b;
}

static void release_own(cell_box *b) {
    free(b->x);
    free(b->node);
    free(b->offset);
    free(b->type);
}

/** Check the plan of a mesh whose only free node is centre, with a ring of n_ring nodes. */
static void check_only_star(cell_box *b, int32_t centre, int n_balls, int64_t n_ring) {
    b->mesh.cells = &b->cells;
    planish_plan *plan = plan_of(&b->mesh, NULL);
    double *inside = malloc((size_t)(b->mesh.n_nodes * 3) * sizeof *inside);
    pl_plan_order(plan, b->x, inside);
    assert_int_equal(plan->interior.stars.n_stars, 1);
    assert_int_equal(plan->interior.stars.max_ring, n_ring);
    check_star(plan, b, inside, centre, n_balls);
    planish_plan_destroy(plan);
    free(inside);
}

/** Two boxes around one node, which have nothing else in common: its ring is longer than that of one
 *  closed link. */
static void test_two_balls(void **state) {
    (void)state;
    enum { CENTRE = 13, NODES = 27, CELLS = 8, EACH = 8 };
    cell_box *one = cell_box_create(BOX_HEXAHEDRA, 2);
    cell_box two = make_own(2 * NODES - 1, 2 * CELLS, PLANISH_CELL_HEXAHEDRON, EACH);
    for (int64_t i = 0; i < 3 * two.mesh.n_nodes; i++)
        two.x[i] = one->x[i < 3 * NODES ? i : i - 3 * NODES + 3 * (i >= 3 * (NODES + CENTRE))];
    for (int64_t i = 0; i < 2 * CELLS * EACH; i++) {
        const int32_t node = one->node[i % (CELLS * EACH)];
        const int is_second = i >= CELLS * EACH && node != CENTRE;
        two.node[i] = is_second ? NODES + node - (node > CENTRE) : node;
    }
    check_only_star(&two, CENTRE, 2, 2 * 26);
    release_own(&two);
    cell_box_destroy(one);
}

/** Many wedges around an axis: too many nodes for a small ring, and for links of bytes. */
static void test_large_star(void **state) {
    (void)state;
    enum { LAYERS = 2 };
    for (int side = 15; side <= 120; side *= 2) {
        cell_box b = make_own((LAYERS + 1) * (side + 1), LAYERS * side, PLANISH_CELL_WEDGE, 6);
        for (int32_t i = 0; i < b.mesh.n_nodes; i++) { /* of each layer the axis comes last */
            const double turn = 2 * acos(-1) * (i % (side + 1)) / side;
            const int is_axis = i % (side + 1) == side;
            b.x[3 * i] = is_axis ? 0 : cos(turn);
            b.x[3 * i + 1] = is_axis ? 0 : sin(turn);
            b.x[3 * i + 2] = i / (side + 1);
        }
        for (int32_t c = 0; c < LAYERS * side; c++)
            for (int level = 0; level < 2; level++) {
                const int32_t first = (c / side + level) * (side + 1);
                b.node[6 * c + 3 * level] = first + side;
                b.node[6 * c + 3 * level + 1] = first + c % side;
                b.node[6 * c + 3 * level + 2] = first + (c + 1) % side;
            }
        check_only_star(&b, 2 * side + 1, 1, 3 * side + 2);
        release_own(&b);
    }
}

/** Mids and nodes in the middle of faces and cells follow, and hold no corner. */
static void test_order_2(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++)
        for (int is_full = 0; is_full < 2; is_full++) {
            cell_box *low = cell_box_create((cell_box_kind)kind, 3),
                     *b = cell_box_raise(low, is_full);
            planish_plan *plan = plan_of(&b->mesh, NULL), *of_low = plan_of(&low->mesh, NULL);
            assert_int_equal(plan->interior.stars.n_stars, of_low->interior.stars.n_stars);
            assert_int_equal(plan->info.n_colours, of_low->info.n_colours);
            for (int64_t i = low->mesh.n_nodes; i < b->mesh.n_nodes; i++)
                assert_true(pl_follows(plan->role[i]) && !(plan->role[i] & PL_OF_EDGES));
            planish_plan_destroy(plan);
            planish_plan_destroy(of_low);
            cell_box_destroy(b);
            cell_box_destroy(low);
        }
}

/** A fixed node in the middle of a face holds the face's corners, and a fixed mid both ends. */
static void test_fixed_mids(void **state) {
    (void)state;
    cell_box *low = cell_box_create(BOX_HEXAHEDRA, 4), *b = cell_box_raise(low, 1);
    uint8_t *constraint = calloc((size_t)b->mesh.n_nodes, 1);
    const double face[] = {1.5, 1.5, 2}, edge[] = {2, 2.5, 2};
    for (int64_t i = low->mesh.n_nodes; i < b->mesh.n_nodes; i++)
        if (memcmp(b->x + 3 * i, face, sizeof face) == 0 ||
            memcmp(b->x + 3 * i, edge, sizeof edge) == 0)
            constraint[i] = PLANISH_CONSTRAINT_FIXED;
    b->mesh.constraint = constraint;
    planish_plan *plan = plan_of(&b->mesh, NULL);
    for (int32_t i = 0; i < low->mesh.n_nodes; i++) {
        const double *x = b->x + 3 * (int64_t)i;
        const int at_face = x[2] == 2 && x[0] >= 1 && x[0] <= 2 && x[1] >= 1 && x[1] <= 2;
        const int at_edge = x[2] == 2 && x[0] == 2 && x[1] >= 2 && x[1] <= 3;
        assert_int_equal(star_of(plan, i) >= 0, is_inside(low, 4, i) && !at_face && !at_edge);
    }
    planish_plan_destroy(plan);
    free(constraint);
    cell_box_destroy(b);
    cell_box_destroy(low);
}

/** Two triangles against a quadrilateral are a boundary, and a hexahedron with a node twice holds its
 *  nodes. */
static void test_held(void **state) {
    (void)state;
    cell_box *b = cell_box_create(BOX_MIXED, 4);
    planish_plan *plan = plan_of(&b->mesh, NULL);
    const int64_t n_free = plan->info.n_free;
    planish_plan_destroy(plan);
    /* The pyramid's base becomes a tetrahedron's face: two facets that have no partner. */
    for (int64_t c = 0; c < b->cells.n; c++)
        if (b->type[c] == PLANISH_CELL_HEXAHEDRON && b->node[b->offset[c]] == 0)
            b->node[b->offset[c] + 1] = b->node[b->offset[c]];
    plan = plan_of(&b->mesh, NULL);
    assert_int_equal(plan->work.n_cells, b->cells.n - 1);
    assert_true(plan->info.n_free < n_free);
    planish_plan_destroy(plan);
    cell_box_destroy(b);
}

/** Only nodes around those that are asked for are free. */
static void test_around(void **state) {
    (void)state;
    cell_box *b = cell_box_create(BOX_HEXAHEDRA, 6);
    planish_options options;
    planish_options_init(&options);
    const int64_t node = 3 + 7 * (3 + 7 * 3);
    options.around = &node;
    options.n_around = 1;
    planish_plan *plan = plan_of(&b->mesh, &options);
    assert_int_equal(plan->interior.stars.n_stars, 1);
    assert_true(star_of(plan, (int32_t)node) == 0);
    planish_plan_destroy(plan);
    options.rings = 1;
    plan = plan_of(&b->mesh, &options);
    assert_int_equal(plan->interior.stars.n_stars, 27);
    planish_plan_destroy(plan);
    cell_box_destroy(b);
}

/** The plan is the same for any number of threads. */
static void test_threads(void **state) {
    (void)state;
    cell_box *b = cell_box_create(BOX_MIXED, 9);
    planish_plan *of[3];
    for (int t = 0; t < 3; t++) {
        planish_options options;
        planish_options_init(&options);
        options.threads = t + 1;
        of[t] = plan_of(&b->mesh, &options);
        const pl_stars *one = &of[0]->interior.stars, *own = &of[t]->interior.stars;
        assert_int_equal(own->n_stars, one->n_stars);
        const size_t n = (size_t)one->n_stars, n_link = (size_t)one->link_offset[n];
        assert_memory_equal(own->link_offset, one->link_offset, n * sizeof *one->link_offset);
        assert_memory_equal(own->ring, one->ring, (size_t)one->ring_offset[n] * sizeof *one->ring);
        assert_memory_equal(own->form, one->form, n_link);
        assert_memory_equal(own->link.low, one->link.low, 3 * n_link);
    }
    for (int t = 0; t < 3; t++)
        planish_plan_destroy(of[t]);
    cell_box_destroy(b);
}

/** Pairs of the box's nodes at x = 0 and x = n. */
static int64_t find_pairs(const cell_box *b, int n, int32_t *pair) {
    int64_t n_pairs = 0;
    for (int32_t i = 0; i < b->mesh.n_nodes; i++)
        for (int32_t j = 0; b->x[3 * (int64_t)i] == 0 && j < b->mesh.n_nodes; j++)
            if (b->x[3 * (int64_t)j] == n && b->x[3 * (int64_t)j + 1] == b->x[3 * (int64_t)i + 1] &&
                b->x[3 * (int64_t)j + 2] == b->x[3 * (int64_t)i + 2]) {
                pair[2 * n_pairs] = i;
                pair[2 * n_pairs++ + 1] = j;
            }
    return n_pairs;
}

/** Nodes of two sides that are one another's images move together: across the box, as if it were
 *  one of many. The cells around an image are whole, so that the regular grid comes back. */
static void test_periodic(void **state) {
    (void)state;
    static const cell_box_kind kinds[] = {BOX_HEXAHEDRA, BOX_PYRAMIDS, BOX_MIXED};
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        enum { SIDE = 3 };
        cell_box *b = cell_box_create(kinds[k], SIDE);
        const int64_t n = b->mesh.n_nodes;
        double *regular = malloc((size_t)(3 * n) * sizeof *regular);
        double *direction = calloc((size_t)(3 * n), sizeof *direction);
        int32_t *pair = malloc((size_t)(2 * n) * sizeof *pair);
        uint8_t *constraint = calloc((size_t)n, 1);
        const int64_t n_pairs = find_pairs(b, SIDE, pair);
        assert_int_equal(n_pairs, (SIDE + 1) * (SIDE + 1));
        memcpy(regular, b->x, (size_t)(3 * n) * sizeof *regular);
        for (int64_t i = 0; i < n; i++) {
            const double *x = regular + 3 * i;
            const int at_end = x[0] == 0 || x[0] == SIDE;
            const int at_side = x[1] == 0 || x[1] == SIDE || x[2] == 0 || x[2] == SIDE;
            constraint[i] = at_side  ? PLANISH_CONSTRAINT_FIXED
                            : at_end ? PLANISH_CONSTRAINT_ON_PLANE
                                     : PLANISH_CONSTRAINT_FREE;
            direction[3 * i] = 1;
        }
        cell_box_shake(b, 0.2, 7);
        for (int64_t i = 0; i < n_pairs; i++) /* both alike, in their planes */
            for (int d = 1; d < 3 && constraint[pair[2 * i]] != PLANISH_CONSTRAINT_FIXED; d++)
                for (int end = 0; end < 2; end++)
                    b->x[3 * (int64_t)pair[2 * i + end] + d] += d == 1 ? 0.25 : -0.2;
        b->mesh.constraint = constraint;
        b->mesh.direction = direction;
        b->mesh.periodic = pair;
        b->mesh.n_periodic = n_pairs;
        planish_plan *plan = plan_of(&b->mesh, NULL);
        planish_result result;
        planish_error error;
        planish_options options;
        planish_options_init(&options);
        options.tolerance = 1e-14;
        assert_int_equal(plan->info.n_sliding, 2 * (SIDE - 1) * (SIDE - 1));
        assert_int_equal(planish_smooth(plan, b->x, &options, &result, &error), PLANISH_OK);
        assert_int_equal(result.n_inverted, 0);
        for (int64_t i = 0; i < n_pairs; i++)
            for (int d = 0; d < 3; d++) {
                const double *from = b->x + 3 * (int64_t)pair[2 * i],
                             *to = b->x + 3 * (int64_t)pair[2 * i + 1];
                assert_true(fabs(to[d] - from[d] - (d == 0 ? SIDE : 0)) < 1e-14);
            }
        for (int64_t i = 0; i < 3 * n && kinds[k] == BOX_HEXAHEDRA; i++)
            assert_true(fabs(b->x[i] - regular[i]) < 1e-3);
        planish_plan_destroy(plan);
        cell_box_destroy(b);
        free(regular);
        free(direction);
        free(pair);
        free(constraint);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_plans),      cmocka_unit_test(test_order_2),
        cmocka_unit_test(test_fixed_mids), cmocka_unit_test(test_held),
        cmocka_unit_test(test_around),     cmocka_unit_test(test_threads),
        cmocka_unit_test(test_periodic),   cmocka_unit_test(test_two_balls),
        cmocka_unit_test(test_large_star),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
