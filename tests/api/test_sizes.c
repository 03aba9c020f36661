/* planish_mesh.size: elements that are to have sizes, which depend on where they are. Sizes are judged by
 * plain loops over the field's formula. */
#include "support/blocks.h"
#include "support/effort.h"
#include "support/meshes.h"
#include "support/run.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- meshes ----------------------------------------------------------------------------------- */

/** A box whose sides' nodes slide on these, and a field of sizes. */
typedef struct sized_box {
    cell_box *box;
    int side;
    planish_mesh mesh;
    double *start; /* [n_nodes][dim] */
    double *size;  /* [n_nodes] */
    uint8_t *constraint;
    double *direction;
} sized_box;

/** The size wanted at x in a box of that side: a tenth on a circle, 1 far from it. */
static double size_at(const double *x, int side) {
    const double r = hypot(x[0] / side - 0.5, x[1] / side - 0.5);
    return fmin(1, 0.1 + 2 * fabs(r - 0.25));
}

static void slide_on_sides(sized_box *s) {
    const int dim = s->mesh.dim;
    for (int64_t i = 0; i < s->mesh.n_nodes; i++) {
        int n = 0;
        for (int d = 0; d < dim; d++) {
            const double x = s->box->x[i * dim + d];
            s->direction[i * dim + d] = x == 0 || x == s->side;
            n += x == 0 || x == s->side;
        }
        s->constraint[i] = n == 0               ? PLANISH_CONSTRAINT_FREE
                           : n == dim           ? PLANISH_CONSTRAINT_FIXED
                           : n == 1 && dim == 3 ? PLANISH_CONSTRAINT_ON_PLANE
                                                : PLANISH_CONSTRAINT_ON_LINE;
        for (int d = 0; s->constraint[i] == PLANISH_CONSTRAINT_ON_LINE && d < dim; d++)
            s->direction[i * dim + d] = 1 - s->direction[i * dim + d];
    }
}

static sized_box sized_box_of(cell_box *box, int side) {
    sized_box s = {.box = box, .side = side, .mesh = box->mesh};
    const int64_t n = s.mesh.n_nodes, dim = s.mesh.dim;
    s.start = malloc((size_t)(n * dim) * sizeof *s.start);
    s.size = malloc((size_t)n * sizeof *s.size);
    s.constraint = calloc((size_t)n, 1);
    s.direction = calloc((size_t)(n * dim), sizeof *s.direction);
    assert_true(s.start && s.size && s.constraint && s.direction);
    memcpy(s.start, box->x, (size_t)(n * dim) * sizeof *s.start);
    for (int64_t i = 0; i < n; i++)
        s.size[i] = size_at(box->x + i * dim, side);
    slide_on_sides(&s);
    s.mesh.size = s.size;
    s.mesh.constraint = s.constraint;
    s.mesh.direction = s.direction;
    return s;
}

static void forget(sized_box *s) {
    cell_box_destroy(s->box);
    free(s->start);
    free(s->size);
    free(s->constraint);
    free(s->direction);
}

static planish_options defaults(void) {
    planish_options options = test_options(1);
    options.size_weight = 0.9;
    return options;
}

/** RMS of the logarithm of size / (factor * wanted), the factor that by which the box would hold as many
 *  elements: of an element's measure in the plane, or in space, by the mean of the field's formula at its
 *  corners. For boxes of one kind of cells. */
static double spread_of(const sized_box *s, const double *x) {
    const int dim = s->mesh.dim, n_corners = dim == 2 ? 4 : 8;
    double held = 0, sum = 0, squares = 0;
    const int64_t n = s->box->cells.n;
    for (int64_t i = 0; i < n; i++) {
        const int32_t *node = s->box->node + s->box->offset[i];
        static const int8_t next[8][3] = {{1, 3, 4}, {2, 0, 5}, {3, 1, 6}, {0, 2, 7},
                                          {7, 5, 0}, {4, 6, 1}, {5, 7, 2}, {6, 4, 3}};
        double measure = 0, wanted = 0;
        for (int c = 0; c < n_corners; c++) {
            double e[3][3] = {{0}, {0}, {0, 0, 1}};
            const double *at = x + (int64_t)node[c] * dim;
            for (int j = 0; j < dim; j++)
                for (int d = 0; d < dim; d++)
                    e[j][d] = x[(int64_t)node[next[c][j]] * dim + d] - at[d];
            const double D = e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
                             e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
                             e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
            assert_true(D > 0);
            measure += D / n_corners;
            wanted += size_at(at, s->side) / n_corners;
        }
        const double log_ratio = log(measure) / dim - log(wanted);
        held += measure / pow(wanted, dim) / (double)n;
        sum += log_ratio / (double)n;
        squares += log_ratio * log_ratio / (double)n;
    }
    const double factor = log(held) / dim;
    return sqrt(squares - 2 * factor * sum + factor * factor);
}

/* ---- tests ------------------------------------------------------------------------------------ */

/** Sizes come within half of what they were off. */
static void sizes_are_met(void **state) {
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        const int side = kind ? 12 : 20;
        sized_box s =
            sized_box_of(cell_box_create(kind ? BOX_HEXAHEDRA : BOX_QUADRILATERALS, side), side);
        const planish_options options = defaults();
        planish_size_quality before, after;
        planish_error error;
        const double spread = spread_of(&s, s.start);
        assert_int_equal(planish_measure_sizes(&s.mesh, 1, &before, NULL, &error), 0);
        const planish_result result = test_smooth_in_place(&s.mesh, s.box->x, &options);
        assert_int_equal(result.stop, PLANISH_STOP_CONVERGED);
        assert_true(result.objective < result.objective_before);
        assert_true(spread_of(&s, s.box->x) < 0.5 * spread);
        s.mesh.reference = s.start;
        assert_int_equal(planish_measure_sizes(&s.mesh, 1, &after, NULL, &error), 0);
        assert_true(fabs(before.rms_log - spread) < 0.2 * spread);
        assert_true(after.rms_log < 0.5 * before.rms_log);
        assert_int_equal(after.n_elements, s.box->cells.n);
        forget(&s);
    }
}

/** Elements of all kinds stay valid, F and the worst ratio do not rise, at whatever sweep it ends, and the
 *  bits are those of one thread and any kernel. */
static void what_is_promised_holds(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind += effort_step(2))
        for (int sweeps = 1; sweeps <= 64; sweeps *= 4) {
            cell_box *box = cell_box_create((cell_box_kind)kind, 5);
            cell_box_shake(box, 0.1, 3);
            sized_box s = sized_box_of(box, 5);
            planish_options options = defaults();
            planish_cell_quality q;
            planish_error error;
            const size_t bytes = (size_t)(s.mesh.n_nodes * s.mesh.dim) * sizeof *s.start;
            options.max_sweeps = sweeps;
            const planish_result result = test_smooth_in_place(&s.mesh, s.box->x, &options);
            assert_true(result.objective <= result.objective_before * (1 + 1e-12));
            double *x = malloc(bytes);
            assert_non_null(x);
            assert_int_equal(planish_measure_cells(&s.mesh, 0, 1, &q, NULL, &error), 0);
            assert_int_equal(q.all.n_inverted, 0);
            for (int way = 0; way < 3; way++) {
                planish_mesh mesh = s.mesh;
                mesh.coordinates = x;
                memcpy(x, s.start, bytes);
                options.threads = way == 0 ? 3 : 1;
                options.isa = way == 1 ? PLANISH_ISA_PLAIN : PLANISH_ISA_VECTOR;
                test_smooth_in_place(&mesh, x, &options);
                assert_memory_equal(x, s.box->x, bytes);
            }
            free(x);
            forget(&s);
        }
}

/** A plan that has smoothed before does what a new one does. */
static void a_plan_remembers_nothing(void **state) {
    (void)state;
    sized_box s = sized_box_of(cell_box_create(BOX_QUADRILATERALS, 12), 12);
    const planish_options options = defaults();
    const size_t bytes = test_bytes_of(&s.mesh);
    planish_plan *plan;
    double *x = test_copy_of(&s.mesh);
    assert_int_equal(planish_plan_create(&s.mesh, &options, &plan, NULL), 0);
    assert_int_equal(planish_smooth(plan, s.box->x, &options, NULL, NULL), 0);
    assert_int_equal(planish_smooth(plan, x, &options, NULL, NULL), 0);
    assert_memory_equal(x, s.box->x, bytes);
    assert_memory_not_equal(x, s.start, bytes);
    planish_plan_destroy(plan);
    free(x);
    forget(&s);
}

/** A mesh whose sizes are to stay, at any scale of sizes, stays the better the more they count. */
static void own_sizes_stay(void **state) {
    (void)state;
    double off[2];
    for (int way = 0; way < 2; way++) {
        sized_box s = sized_box_of(cell_box_create(BOX_QUADRILATERALS, 10), 10);
        planish_options options = defaults();
        planish_error error;
        planish_size_quality q;
        for (int64_t i = 0; i < 2 * s.mesh.n_nodes; i += 2) /* graded */
            s.box->x[i] = s.start[i] = 10 * pow(s.start[i] / 10, 1.7);
        assert_int_equal(planish_find_sizes(&s.mesh, 1, s.size, &error), 0);
        for (int64_t i = 0; i < s.mesh.n_nodes; i++)
            s.size[i] *= 1000;
        options.size_weight = way ? 0.99 : 0.1;
        test_smooth_in_place(&s.mesh, s.box->x, &options);
        s.mesh.reference = s.start;
        assert_int_equal(planish_measure_sizes(&s.mesh, 1, &q, NULL, &error), 0);
        assert_true(q.factor > 0.5e-3 && q.factor < 2e-3);
        off[way] = q.rms_log;
        forget(&s);
    }
    assert_true(off[1] < 0.05 && off[1] < 0.5 * off[0]);
}

/** A uniform field does what no sizes do: a regular mesh is the end of both. */
static void one_size_makes_a_regular_mesh(void **state) {
    (void)state;
    sized_box s = sized_box_of(cell_box_create(BOX_HEXAHEDRA, 4), 4);
    planish_options options = defaults();
    for (int64_t i = 0; i < s.mesh.n_nodes; i++)
        s.size[i] = 3;
    options.tolerance = 1e-9;
    cell_box_shake(s.box, 0.2, 3);
    test_smooth_in_place(&s.mesh, s.box->x, &options);
    for (int64_t i = 0; i < 3 * s.mesh.n_nodes; i++)
        assert_true(fabs(s.box->x[i] - s.start[i]) < 1e-3);
    forget(&s);
}

/** planish_measure_mesh measures as a plan does; sizes that do not count are no error, but ignored. */
static void a_mesh_is_measured_as_by_a_plan(void **state) {
    (void)state;
    sized_box s = sized_box_of(cell_box_create(BOX_QUADRILATERALS, 6), 6);
    planish_options options = defaults();
    planish_quality of_plan, of_mesh, plain;
    planish_error error = {.text = ""};
    planish_plan *plan;
    cell_box_shake(s.box, 0.2, 3);
    s.mesh.reference = s.start;
    assert_int_equal(planish_plan_create(&s.mesh, &options, &plan, &error), 0);
    assert_int_equal(planish_measure(plan, s.box->x, &of_plan, &error), 0);
    planish_plan_destroy(plan);
    assert_int_equal(planish_measure_mesh(&s.mesh, &options, &of_mesh, &error), 0);
    assert_memory_equal(&of_mesh, &of_plan, sizeof of_plan);
    if (planish_measure_mesh(&s.mesh, NULL, &of_mesh, &error))
        fail_msg("%s", error.text);
    s.mesh.size = NULL;
    s.mesh.reference = NULL;
    assert_int_equal(planish_measure_mesh(&s.mesh, NULL, &plain, &error), 0);
    assert_memory_equal(&of_mesh, &plain, sizeof plain);
    assert_true(plain.rms_radius_ratio > 1 && plain.rms_radius_ratio < of_plan.rms_radius_ratio);
    forget(&s);
}

/** Triangles, given as such or as cells, in either order of their nodes. */
static void simplices_are_as_cells(void **state) {
    (void)state;
    test_mesh t;
    test_mesh_box(&t, 2, 8);
    planish_mesh mesh = t.mesh;
    const planish_options options = defaults();
    const size_t bytes = (size_t)(mesh.n_nodes * 2) * sizeof(double);
    double *size = malloc((size_t)mesh.n_nodes * sizeof *size), *x = malloc(bytes),
           *y = malloc(bytes);
    assert_true(size && x && y);
    for (int64_t i = 0; i < mesh.n_nodes; i++)
        size[i] = 0.2 + t.coordinates[2 * i];
    mesh.size = size;
    memcpy(x, t.coordinates, bytes);
    memcpy(y, t.coordinates, bytes);
    const planish_result a = test_smooth_in_place(&mesh, x, &options);
    for (int64_t i = 0; i < mesh.n_elements; i++) {
        const int32_t node = t.elements[3 * i];
        t.elements[3 * i] = t.elements[3 * i + 1];
        t.elements[3 * i + 1] = node;
    }
    const planish_result b = test_smooth_in_place(&mesh, y, &options);
    assert_true(a.objective < a.objective_before && fabs(a.objective - b.objective) < 1e-6);
    free(size);
    free(x);
    free(y);
    test_mesh_destroy(&t);
}

/** Sizes that ask for small elements where none may be smaller: none falls below its minimum volume, however early
 *  the run ends. */
static void minimum_volumes_are_kept(void **state) {
    (void)state;
    enum { CELLS = 16, FIRST_SEED = 155, LAST_SEED = 160, MOST_SWEEPS = 8 };
    for (unsigned seed = FIRST_SEED; seed <= LAST_SEED; seed++) {
        test_mesh t;
        test_mesh_box(&t, 2, CELLS);
        planish_mesh mesh = t.mesh;
        unsigned random = seed;
        for (int64_t i = 0; i < mesh.n_nodes; i++)
            for (int d = 0; d < 2 && test_is_inside_box(mesh.coordinates + 2 * i, 2, CELLS); d++)
                t.coordinates[2 * i + d] += 0.5 * (test_random(&random) - 0.5);
        const size_t bytes = (size_t)(mesh.n_nodes * 2) * sizeof(double);
        double *size = malloc((size_t)mesh.n_nodes * sizeof *size), *x = malloc(bytes);
        double *least = malloc((size_t)mesh.n_elements * sizeof *least);
        assert_true(size && least && x);
        for (int64_t i = 0; i < mesh.n_nodes; i++)
            size[i] =
                0.3 + 3 * fabs(t.coordinates[2 * i] / CELLS - 0.5 + 0.1 * test_random(&random));
        for (int64_t i = 0; i < mesh.n_elements; i++)
            least[i] = 0.99 * test_measure_of(&mesh, t.coordinates, i);
        mesh.size = size;
        mesh.min_volume = least;
        for (int sweeps = 3; sweeps <= MOST_SWEEPS; sweeps++) {
            planish_options options = defaults();
            options.max_sweeps = sweeps;
            options.size_weight = 0.7;
            memcpy(x, t.coordinates, bytes);
            assert_int_equal(test_smooth_in_place(&mesh, x, &options).n_below_min_volume, 0);
        }
        free(size);
        free(least);
        free(x);
        test_mesh_destroy(&t);
    }
}

/** A flat element has no size: its nodes have that of others. */
static void flat_elements_have_no_size(void **state) {
    (void)state;
    double x[] = {0, 0, 1, 0, 2, 0, 0, 1, 1, 1}, size[5];
    static const int32_t elements[] = {0, 1, 2, 0, 1, 3, 1, 4, 3};
    planish_mesh mesh = {
        .dim = 2, .n_nodes = 5, .n_elements = 3, .elements = elements, .coordinates = x};
    planish_error error;
    assert_int_equal(planish_find_sizes(&mesh, 1, size, &error), 0);
    const double length = sqrt(2 / sqrt(3));
    for (int i = 0; i < 5; i++)
        assert_true(fabs(size[i] - length) < 1e-12);
    mesh.size = size;
    planish_size_quality q;
    assert_int_equal(planish_measure_sizes(&mesh, 1, &q, NULL, &error), 0);
    assert_int_equal(q.n_elements, 2);
    assert_true(q.rms_log < 1e-12);
}

/** A node has the mean size of its elements, whether it is a corner or a mid. */
static void mids_have_sizes(void **state) {
    (void)state;
    /* Two triangles of side 1, and two that are 4 times as wide, each pair a rectangle. */
    double x[] = {0,  0,  1,  0,  1, 1, 0,  1, 5, 0, 5,  1, .5, 0, 1,
                  .5, .5, .5, .5, 1, 0, .5, 3, 0, 5, .5, 3, .5, 3, 1},
           size[15];
    static const int32_t node[] = {0, 1, 2, 6,  7,  8,  0, 2, 3, 8,  9,  -1,
                                   1, 4, 5, 11, 12, 13, 1, 5, 2, 13, 14, 7};
    static const int64_t offset[] = {0, 6, 12, 18, 24};
    static const uint8_t type[] = {22, 22, 22, 22};
    const planish_cells cells = {.n = 4, .type = type, .offset = offset, .node = node};
    const planish_mesh mesh = {
        .dim = 2, .n_nodes = 15, .n_elements = 4, .coordinates = x, .cells = &cells};
    const double small = sqrt(2 / sqrt(3)), large = 2 * small;
    const double wanted[] = {small,
                             (small + 2 * large) / 3,
                             (2 * small + large) / 3,
                             small,
                             large,
                             large,
                             small,
                             (small + large) / 2,
                             small,
                             small,
                             (small + large) / 2,
                             large,
                             large,
                             large,
                             large};
    planish_error error;
    assert_int_equal(planish_find_sizes(&mesh, 1, size, &error), 0);
    for (int i = 0; i < 15; i++) /* no element has node 10 */
        assert_true(fabs(size[i] - wanted[i]) < 1e-12);
}

/** What planish_find_slides finds for a mesh on a shape. */
typedef struct found_slides {
    uint8_t *constraint;
    double *direction;
    planish_slide_info info;
} found_slides;

static found_slides find_slides(const planish_mesh *mesh, const planish_shape *shape) {
    found_slides found = {.constraint = calloc((size_t)mesh->n_nodes, 1),
                          .direction = calloc((size_t)mesh->n_nodes, 3 * sizeof(double))};
    const planish_surface surface = {.shape = shape};
    assert_int_equal(planish_find_slides(mesh, &surface, 1, found.constraint, found.direction,
                                         &found.info, NULL),
                     0);
    return found;
}

static void forget_slides(found_slides *found) {
    free(found->constraint);
    free(found->direction);
}

/** Nodes slide on curved surfaces where they do without targets of any kind. */
static void targets_do_not_hold_nodes(void **state) {
    (void)state;
    enum { N = 6, TARGETS = 4 };
    uint64_t random = effort_seed(5);
    block b;
    block_create(1, BOX_HEXAHEDRA, BLOCK_BALL, N, 1, 0, &random, &b);
    const int64_t n = b.mesh.n_elements, n_nodes = b.mesh.n_nodes;
    uint8_t *type = malloc((size_t)n), *is_layer = malloc((size_t)n);
    int64_t *offset = malloc((size_t)(n + 1) * sizeof *offset);
    double *metric = malloc((size_t)n_nodes * 6 * sizeof *metric);
    double *size = malloc((size_t)n_nodes * sizeof *size);
    for (int64_t i = 0; i <= n; i++)
        offset[i] = 4 * i;
    for (int64_t i = 0; i < 6 * n_nodes; i++)
        metric[i] = i % 6 == 0 || i % 6 == 2 || i % 6 == 5;
    for (int64_t i = 0; i < n_nodes; i++)
        size[i] = 1 + (double)(i % 2);
    memset(type, PLANISH_CELL_TETRAHEDRON, (size_t)n);
    memset(is_layer, 1, (size_t)n);
    const planish_cells cells = {.n = n, .type = type, .offset = offset, .node = b.tetrahedron};
    planish_mesh mesh = b.mesh;
    mesh.elements = NULL;
    mesh.cells = &cells;
    found_slides without = find_slides(&mesh, b.shape);
    assert_true(without.info.n_on_patch > 0);
    for (int k = 0; k < TARGETS; k++) {
        planish_mesh with = mesh;
        with.reference = k == 0 ? b.given : NULL;
        with.is_layer = k == 1 ? is_layer : NULL;
        with.metric = k == 2 ? metric : NULL;
        with.size = k == 3 ? size : NULL;
        found_slides found = find_slides(&with, b.shape);
        assert_memory_equal(found.constraint, without.constraint, (size_t)n_nodes);
        assert_memory_equal(found.direction, without.direction,
                            (size_t)n_nodes * 3 * sizeof(double));
        forget_slides(&found);
    }
    forget_slides(&without);
    free(type);
    free(is_layer);
    free(offset);
    free(metric);
    free(size);
    block_destroy(&b);
}

static void wrong_sizes_are_refused(void **state) {
    (void)state;
    static const struct {
        double size;
        const char *text;
    } cases[] = {{0, "node 5 has the size 0"},  {-1, "node 5 has the size -1"},
                 {NAN, "node 5 has the size "}, {INFINITY, "node 5 has the size inf"},
                 {1e-13, "vary by more than"},  {1e13, "vary by more than"}};
    sized_box s = sized_box_of(cell_box_create(BOX_QUADRILATERALS, 4), 4);
    planish_options options = defaults();
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        planish_error error;
        planish_size_quality q;
        s.size[5] = cases[k].size;
        test_expect_refusal(&s.mesh, &options, PLANISH_ERROR_MESH, cases[k].text);
        assert_int_equal(planish_measure_sizes(&s.mesh, 1, &q, NULL, &error), PLANISH_ERROR_MESH);
    }
    s.size[5] = 1;
    options.size_weight = 0;
    test_expect_refusal(&s.mesh, &options, PLANISH_ERROR_ARGUMENT, "options.size_weight is 0");
    options = defaults();
    s.start[7] = NAN;
    s.mesh.reference = s.start;
    test_expect_refusal(&s.mesh, &options, PLANISH_ERROR_MESH, "finite");
    s.mesh.reference = NULL;
    uint8_t is_layer[16] = {1};
    s.mesh.is_layer = is_layer;
    test_expect_refusal(&s.mesh, &options, PLANISH_ERROR_ARGUMENT,
                        "mesh.size is not possible with mesh.is_layer");
    s.mesh.is_layer = NULL;
    options.around = (const int64_t[]){6};
    options.n_around = 1;
    planish_plan *plan;
    assert_int_equal(planish_plan_create(&s.mesh, &options, &plan, NULL), 0);
    planish_plan_destroy(plan);
    forget(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sizes_are_met),
        cmocka_unit_test(what_is_promised_holds),
        cmocka_unit_test(a_plan_remembers_nothing),
        cmocka_unit_test(own_sizes_stay),
        cmocka_unit_test(one_size_makes_a_regular_mesh),
        cmocka_unit_test(a_mesh_is_measured_as_by_a_plan),
        cmocka_unit_test(minimum_volumes_are_kept),
        cmocka_unit_test(flat_elements_have_no_size),
        cmocka_unit_test(mids_have_sizes),
        cmocka_unit_test(simplices_are_as_cells),
        cmocka_unit_test(targets_do_not_hold_nodes),
        cmocka_unit_test(wrong_sizes_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
