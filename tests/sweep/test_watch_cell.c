/* Tests of one cell of a watch, of any type: moves of its corners, and its minimum volume. */
#include "support/meshes.h"
#include "geometry/simplex.h"
#include "quality/certificate.h"
#include "sweep/watch.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const int TYPES[] = {5, 22, 9, 23, 28, 10, 24, 12, 25, 29, 13, 26, 32, 14};
enum { N_TYPES = sizeof TYPES / sizeof *TYPES, TRIALS = 30, MOVES = 60 };

/** A plan of a single cell, which has as much of a plan as the watch reads. */
typedef struct lone_cell {
    const pl_cell_type *type;
    planish_plan plan;
    planish_options options;
    pl_watch watch;
    int64_t offset[2];
    uint8_t of_type, mobility[PL_CELL_NODES], role[PL_CELL_NODES], corner[PL_CELL_CORNERS];
    int8_t sign[PL_CELL_CORNERS];
    int32_t node[PL_CELL_NODES], cell_of[PL_CELL_CORNERS], cell_begin[2];
    int32_t elements[PL_CELL_CORNERS * 4];
    double x[PL_CELL_NODES * 3], start[PL_CELL_NODES * 3];
    pl_jacobian_rule rule;
    int is_mirrored; /* it is numbered the other way round */
} lone_cell;

/** Corners of the ideal cell. */
static void place_corners(lone_cell *c) {
    const pl_cell_shape *shape = c->type->shape;
    const int dim = shape->dim;
    for (int j = 0; j < shape->n_corners; j++)
        for (int s = 0, d = 0; s < shape->n_simplices; s++)
            for (int v = 1; v < shape->n_vertices[s]; v++, d++)
                c->x[j * dim + d] = shape->vertex[j][s] == v;
    static const double pyramid[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.5, 0.5, 0.7};
    if (shape->n_simplices == 0)
        memcpy(c->x, pyramid, sizeof pyramid);
}

/** Put the nodes of order 2 in the middle of their corners, off by up to bend. */
static void place_mids(lone_cell *c, double bend, unsigned *seed) {
    const int dim = c->type->shape->dim;
    for (int i = c->type->shape->n_corners; i < c->type->n_nodes; i++) {
        const unsigned parents = pl_cell_parents(c->type, i);
        for (int d = 0; d < dim; d++) {
            double sum = 0;
            for (int k = 0; k < c->type->shape->n_corners; k++)
                sum += parents >> k & 1 ? c->x[k * dim + d] : 0;
            c->x[i * dim + d] =
                sum / __builtin_popcount(parents) + bend * (2 * test_random(seed) - 1);
        }
    }
}

/** Make the plan and its watch, for nodes where c->x has them. */
static void watch_cell(lone_cell *c, double min_volume) {
    const pl_cell_shape *shape = c->type->shape;
    const int dim = shape->dim, is_simplex = shape->n_simplices == 1;
    const int kind = pl_kind_of_shape(shape), n = is_simplex ? 1 : shape->n_measured;
    planish_plan *plan = &c->plan;
    planish_error error;
    memset(plan, 0, sizeof *plan);
    for (int i = 0; i < c->type->n_nodes * dim; i += dim)
        c->x[i] *= c->is_mirrored ? -1 : 1;
    for (int i = 0; i < c->type->n_nodes; i++) {
        c->node[i] = i;
        c->mobility[i] = i < shape->n_corners;
        c->role[i] = 0;
    }
    for (int e = 0; e < n; e++) {
        c->corner[e] = pl_corner_code(kind, e);
        c->sign[e] = c->is_mirrored ? -1 : 1;
        c->cell_of[e] = 0;
        for (int j = 0; j <= dim; j++)
            c->elements[e * (dim + 1) + j] = is_simplex ? j
                                             : j == 0   ? e
                                                        : shape->neighbour[e][j - 1];
    }
    c->cell_begin[0] = 0;
    c->cell_begin[1] = n;
    c->of_type = c->type->type;
    c->offset[0] = 0;
    c->offset[1] = c->type->n_nodes;
    plan->dim = plan->work.dim = dim;
    plan->work.n_nodes = plan->whole.n_nodes = c->type->n_nodes;
    plan->work.n_elements = n;
    plan->work.elements = c->elements;
    plan->work.corner = c->corner;
    plan->work.n_cells = 1;
    plan->work.cell_begin = c->cell_begin;
    plan->work.sign = c->sign;
    plan->work.mobility = c->mobility;
    plan->all = &plan->work;
    plan->inner = c->node;
    plan->cells =
        (planish_cells){.n = 1, .type = &c->of_type, .offset = c->offset, .node = c->node};
    plan->cell_of = c->cell_of;
    plan->role = c->role;
    plan->node_stride = dim;
    plan->component_stride = 1;
    plan->threads = 1;
    plan->scratch.coordinates = c->x;
    pl_corner_forms_make(dim, plan->form);
    memcpy(c->start, c->x, sizeof c->x);
    planish_options_init(&c->options);
    if (pl_watch_create(plan, &c->options, c->start, c->start, min_volume, &c->watch, &error))
        fail_msg("%s", error.text);
    pl_jacobian_rule_make(c->type, &c->rule);
}

static void init_cell(lone_cell *c, int type) {
    memset(c, 0, sizeof *c);
    c->type = pl_cell_type_of(type);
    place_corners(c);
}

/** Validity of the cell, nodes of order 2 following; *least: its least
 *  coefficient, as a volume. */
static int is_cell_valid(const lone_cell *c, double *least) {
    const int dim = c->type->shape->dim;
    static pl_jacobian_block b;
    double x[PL_CELL_NODES * 3], sign[PL_JACOBIAN_LANES];
    memcpy(x, c->x, sizeof x);
    for (int i = c->type->shape->n_corners; i < c->type->n_nodes; i++)
        pl_mid_place(&c->watch.mids, i, x + i * dim);
    memset(&b, 0, sizeof b);
    for (int i = 0; i < c->type->n_nodes; i++)
        for (int d = 0; d < dim; d++)
            b.x[i][d][0] = x[i * dim + d] - x[d];
    for (int l = 0; l < PL_JACOBIAN_LANES; l++)
        sign[l] = c->sign[0];
    pl_jacobian_evaluate(&c->rule, sign, &b);
    double unit = c->rule.common;
    for (int d = 0; d < dim && c->type->order > 1; d++)
        unit *= 0.5 * c->rule.control_term[0].weight;
    *least = b.least[0] / unit * c->plan.form[pl_form_code(c->corner[0], 0, 0)].volume;
    return pl_validity_of_lane(&c->rule, &b, 0, c->node, x, sign[0]) == PL_VALID;
}

/** Whether the corners' elements are positive, and not below the minimum volume. */
static int has_good_corners(const lone_cell *c, double min_volume) {
    const int dim = c->type->shape->dim;
    const double volume = c->plan.form[pl_form_code(c->corner[0], 0, 0)].volume;
    for (int e = 0; e < c->cell_begin[1]; e++) {
        const double *vertex[4];
        double edges[3][3];
        for (int j = 0; j <= dim; j++)
            vertex[j] = c->x + c->elements[e * (dim + 1) + j] * dim;
        pl_edges(dim, vertex, edges);
        if (pl_measure_sign(dim, vertex) * c->sign[e] <= 0 ||
            pl_determinant_of_edges(dim, edges) * volume * c->sign[e] < min_volume)
            return 0;
    }
    return 1;
}

/** What a walk of a cell's corners has met. */
typedef struct walk {
    int admitted, refused, with_room, of_valid;
} walk;

/** Move a corner by a random way of a random length, and back if it is not admitted. Visits keep
 *  corners of linear cells positive and above the minimum volume: where they would not the corner
 *  goes back. */
static void step(lone_cell *c, double min_volume, unsigned *seed, walk *w) {
    const int dim = c->type->shape->dim, corners = c->type->shape->n_corners;
    const int node = (int)(test_random(seed) * corners) % corners;
    const double length = pow(10, -4 * test_random(seed));
    double *x = c->x + node * dim, before[3], least, least_before;
    const int was = is_cell_valid(c, &least_before);
    for (int d = 0; d < dim; d++) {
        before[d] = x[d];
        x[d] += length * (2 * test_random(seed) - 1);
    }
    const int decides = c->watch.type[0]; /* by what: 0: corners */
    const int is_linear = !decides || pl_cell_type_of(decides)->order == 1;
    const int is_valid = is_cell_valid(c, &least);
    const int keeps = is_valid && (!(min_volume > 0) || !(least_before > min_volume * (1 + 1e-9)) ||
                                   least > min_volume * (1 - 1e-9));
    int goes = !is_linear || has_good_corners(c, min_volume);
    if (goes) {
        const double way = pl_distance(dim, x, before);
        const int has_room = c->watch.room[0] > way;
        goes = pl_watch_admit(&c->watch, node, way);
        w->with_room += has_room && decides;
        if (goes && was && decides)
            assert_true(keeps);
        if (!goes)
            assert_true(was && (!is_valid || (min_volume > 0 && least < min_volume * (1 + 1e-9))));
        w->of_valid += was;
        *(goes ? &w->admitted : &w->refused) += 1;
    }
    for (int d = 0; d < dim && !goes; d++)
        x[d] = before[d];
}

/** Whether a cell that has refused so many moves counts as one that keeps refusing them: if all its
 *  coefficients are positive, which can be constraints then. */
static int64_t check_refuser(const lone_cell *c, int refused) {
    uint8_t mark[PL_CELL_CORNERS] = {0};
    double least;
    is_cell_valid(c, &least);
    const int64_t n = pl_watch_find_refusers(&c->watch, mark);
    assert_int_equal(n, mark[0]);
    assert_int_equal(n, pl_watch_find_refusers(&c->watch, NULL));
    if (n > 0)
        assert_true(refused >= 3 && least > -1e-12);
    else if (c->watch.type[0] == c->type->type)
        assert_true(refused < 3 || least < 1e-12);
    return n;
}

/** Rooms admit no move that the certificate would refuse; what is refused is invalid. */
static void moves_of_valid_cells_are_decided(void **state) {
    (void)state;
    int64_t n_all = 0;
    for (int t = 0; t < N_TYPES; t++) {
        static lone_cell c;
        walk w = {0, 0, 0, 0};
        unsigned seed = 7 + (unsigned)t;
        int64_t n_refusers = 0;
        const int is_linear_one =
            TYPES[t] == PLANISH_CELL_HEXAHEDRON || TYPES[t] == PLANISH_CELL_WEDGE;
        const int trials = is_linear_one ? 10 * TRIALS : TRIALS; /* few are invalid inside alone */
        for (int trial = 0; trial < trials; trial++) {
            init_cell(&c, TYPES[t]);
            const int n = c.type->shape->n_corners * c.type->shape->dim;
            for (int i = 0; i < n; i++)
                c.x[i] += (is_linear_one ? 0.4 : 0.2) * (2 * test_random(&seed) - 1);
            place_mids(&c, trial % 3 ? 0.08 : 0, &seed);
            c.is_mirrored = trial % 2;
            watch_cell(&c, 0);
            pl_watch_measure(&c.watch);
            const int before = w.refused;
            for (int m = 0; m < MOVES; m++)
                step(&c, 0, &seed, &w);
            n_refusers += check_refuser(&c, w.refused - before);
            pl_watch_destroy(&c.watch);
        }
        const int is_watched = TYPES[t] != PLANISH_CELL_TRIANGLE && TYPES[t] != 10 &&
                               TYPES[t] != PLANISH_CELL_QUADRILATERAL &&
                               TYPES[t] != PLANISH_CELL_PYRAMID;
        assert_true(w.admitted > MOVES && w.of_valid > MOVES);
        assert_true(!is_watched == (w.refused == 0));
        assert_true(!is_watched || w.with_room > MOVES);
        assert_true(is_watched || n_refusers == 0);
        n_all += n_refusers;
    }
    assert_true(n_all > 10);
}

/** Cells that are above their minimum volume stay there, by their least coefficient. */
static void minimum_volumes_hold_inside(void **state) {
    (void)state;
    static const double part = 0.4;
    for (int t = 0; t < N_TYPES; t++) {
        static lone_cell c;
        walk w = {0, 0, 0, 0};
        unsigned seed = 70 + (unsigned)t;
        for (int trial = 0; trial < TRIALS; trial++) {
            double least;
            init_cell(&c, TYPES[t]);
            place_mids(&c, 0.04, &seed);
            watch_cell(&c, 0);
            is_cell_valid(&c, &least);
            const double min_volume = (trial % 2 ? 1.2 : part) * least;
            pl_watch_destroy(&c.watch);
            if (!(least > 0))
                continue;
            watch_cell(&c, min_volume);
            pl_watch_measure(&c.watch);
            for (int m = 0; m < MOVES; m++)
                step(&c, min_volume, &seed, &w);
            pl_watch_destroy(&c.watch);
        }
        assert_true(w.admitted > MOVES);
    }
}

/** A corner's own volume may come down to the minimum, which is for visits to heed: no move there is
 *  refused, whether the cell has room for it or is decided. */
static void corners_may_reach_their_minimum(void **state) {
    enum { PARTS = 8 };
    static const int types[] = {PLANISH_CELL_HEXAHEDRON, PLANISH_CELL_WEDGE};
    (void)state;
    for (int i = 0; i < 2; i++)
        for (int has_room = 0; has_room < 2; has_room++) {
            static lone_cell c;
            const double step = 0.02 / PARTS;
            double least;
            int n_with_room = 0;
            init_cell(&c, types[i]);
            for (int d = 0; d < 3; d++)
                c.x[d] = PARTS * step;
            watch_cell(&c, 0);
            is_cell_valid(&c, &least); /* that at corner 0 */
            pl_watch_destroy(&c.watch);
            init_cell(&c, types[i]);
            watch_cell(&c, least);
            pl_watch_measure(&c.watch);
            assert_true(c.watch.room[0] > 0);
            for (int m = 1; m <= PARTS; m++) {
                const double before[3] = {c.x[0], c.x[1], c.x[2]};
                for (int d = 0; d < 3; d++)
                    c.x[d] = m * step;
                if (!has_room)
                    pl_watch_forget(&c.watch, 0);
                n_with_room += c.watch.room[0] > pl_distance(3, c.x, before);
                assert_true(pl_watch_admit(&c.watch, 0, pl_distance(3, c.x, before)));
                assert_true(c.watch.state[0] & PL_WATCH_ABOVE);
            }
            assert_true(has_room == (n_with_room > 0));
            pl_watch_destroy(&c.watch);
        }
}

/** A cell counts where it is worse than asked for, and then all of it. */
static void asks_for_large_corners(const lone_cell *c) {
    const pl_worst_cell all = pl_watch_worst(&c->watch, 0, 0);
    const pl_worst_cell some = pl_watch_worst(&c->watch, 0, all.mu2 * (1 - 1e-6));
    const pl_worst_cell none = pl_watch_worst(&c->watch, 0, all.mu2 * (1 + 1e-6));
    assert_true(all.mu2 > 1 && all.mu2 < INFINITY && all.ar2 > 1);
    assert_true(some.ar2 == all.ar2 && some.mu2 == all.mu2 && some.acuteness == all.acuteness);
    assert_true(none.ar2 == 0 && none.mu2 == 0 && none.acuteness == 0);
}

/** Of what a corner moves by, a mid moves by 1/2, a node of a face by 1/4, of the cell by 1/8. */
static void nodes_follow_corners(void **state) {
    (void)state;
    for (int t = 0; t < N_TYPES; t++) {
        static lone_cell c;
        unsigned seed = 3;
        init_cell(&c, TYPES[t]);
        const int dim = c.type->shape->dim;
        place_mids(&c, 0.05, &seed);
        c.is_mirrored = t % 2;
        watch_cell(&c, 0);
        const pl_worst_cell worst = pl_watch_worst(&c.watch, 0, 0);
        const int is_ideal = c.type->shape->n_corners == (dim == 3 ? 8 : 4);
        assert_true(is_ideal ? fabs(worst.ar2 - 1) < 1e-15 && fabs(worst.acuteness - 1) < 1e-15
                             : worst.ar2 > 1 && worst.ar2 < 4 && worst.acuteness < 4);
        for (int corner = 0; corner < c.type->shape->n_corners; corner++) {
            c.x[corner * dim] += 0.25;
            asks_for_large_corners(&c);
            for (int i = c.type->shape->n_corners; i < c.type->n_nodes; i++) {
                const unsigned parents = pl_cell_parents(c.type, i);
                double x[3];
                assert_int_equal(parents, c.rule.straight[i]);
                pl_mid_place(&c.watch.mids, i, x);
                const double rate = parents >> corner & 1 ? 1.0 / __builtin_popcount(parents) : 0;
                assert_true(fabs(x[0] - c.start[i * dim] - 0.25 * rate) < 1e-15);
                assert_true(x[1] == c.start[i * dim + 1]);
            }
            c.x[corner * dim] = c.start[corner * dim];
        }
        pl_watch_destroy(&c.watch);
    }
}

/** The top of a high cell is turned against its bottom: no corner shows it. */
static void cells_may_be_tangled_inside(void **state) {
    (void)state;
    static const double brick[] = {-0.5, -0.25, 0,     0.5,  -0.25, 0,    0.5,  0.25,
                                   0,    -0.5,  0.25,  0,    0.25,  0.5,  100,  -0.25,
                                   0.5,  100,   -0.25, -0.5, 100,   0.25, -0.5, 100};
    static lone_cell c;
    init_cell(&c, PLANISH_CELL_HEXAHEDRON);
    memcpy(c.x, brick, sizeof brick);
    watch_cell(&c, 0);
    assert_true(has_good_corners(&c, 0));
    assert_int_equal(pl_watch_measure(&c.watch), 1);
    assert_false(pl_watch_is_valid(&c.watch, 0));
    pl_watch_destroy(&c.watch);
    init_cell(&c, PLANISH_CELL_WEDGE);
    for (int j = 0; j < 6; j++) { /* a triangle, and the same turned by 180 degrees */
        const double angle = 2 * acos(-1) * (j % 3) / 3 + (j < 3 ? 0 : acos(-1));
        c.x[j * 3] = cos(angle);
        c.x[j * 3 + 1] = sin(angle);
        c.x[j * 3 + 2] = j < 3 ? 0 : 100;
    }
    watch_cell(&c, 0);
    assert_true(has_good_corners(&c, 0));
    assert_int_equal(pl_watch_measure(&c.watch), 1);
    for (int j = 0; j < 3; j++) { /* and by nothing */
        c.x[j * 3 + 9] = c.x[j * 3];
        c.x[j * 3 + 10] = c.x[j * 3 + 1];
    }
    assert_int_equal(pl_watch_measure(&c.watch), 0);
    assert_true(c.watch.room[0] > 0.01);
    pl_watch_destroy(&c.watch);
}

/** What floats say of coefficients is below what doubles say, and near it. */
static void floats_bound_coefficients(void **unused) {
    (void)unused;
    unsigned seed = 7;
    int n_near = 0, n = 0;
    for (int t = 0; t < N_TYPES; t++)
        for (int trial = 0; trial < TRIALS; trial++) {
            lone_cell c;
            init_cell(&c, TYPES[t]);
            pl_jacobian_rule_make(c.type, &c.rule);
            const int dim = c.type->shape->dim, n_nodes = c.rule.n_nodes;
            const uint8_t none[PL_JACOBIAN_COEFFICIENTS] = {0};
            double sign[PL_JACOBIAN_LANES];
            pl_jacobian_block b = {.error = {0}};
            pl_float_block f = {.all = {0}};
            place_corners(&c);
            place_mids(&c, 0.1, &seed);
            for (int l = 0; l < PL_JACOBIAN_LANES; l++) {
                sign[l] = l % 2 ? -1 : 1;
                f.sign[l] = (float)sign[l];
                for (int i = 0; i < n_nodes; i++)
                    for (int d = 0; d < dim; d++) {
                        b.x[i][d][l] = c.x[i * dim + d] + 0.2 * test_random(&seed);
                        f.x[i][d][l] = (float)b.x[i][d][l];
                    }
            }
            pl_jacobian_evaluate(&c.rule, sign, &b);
            pl_jacobian_bound(&c.rule, none, &f);
            for (int l = 0; l < PL_JACOBIAN_LANES; l++, n++) {
                assert_true(f.all[l] <= b.least[l] + b.error[l]);
                assert_true(f.all[l] == f.inner[l]);
                double largest = 0;
                for (int k = 0; k < c.rule.n_coefficients; k++)
                    largest = fmax(fabs(b.coefficient[k][l]), largest);
                n_near += f.all[l] > b.least[l] - 0.01 * largest;
            }
        }
    assert_true(n_near > n * 9 / 10);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(moves_of_valid_cells_are_decided),
        cmocka_unit_test(minimum_volumes_hold_inside),
        cmocka_unit_test(corners_may_reach_their_minimum),
        cmocka_unit_test(nodes_follow_corners),
        cmocka_unit_test(cells_may_be_tangled_inside),
        cmocka_unit_test(floats_bound_coefficients),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
