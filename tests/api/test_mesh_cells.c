/* planish_mesh.cells: every call gives what it gives for the same simplices as elements, by cells;
 * which nodes cells hold; what is refused. */
#include "support/effort.h"
#include "support/faults.h"
#include "support/meshes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- meshes ---------------------------------------------------------------------------------- */

/** How cells are made of simplices, as bits. */
enum {
    ORDER_2 = 1,     /* simplices have mids, in the middle */
    HALF = 2,        /* every other one of them */
    OTHERS = 4,      /* other elements stand between them: some hold nodes of simplices */
    BY_COMPONENT = 8 /* coordinates are x x .. y y .. */
};

enum { MOST_MIDS = 6, MOST_NODES = 8 };

/** A mesh of cells and the same one of elements. */
typedef struct pair {
    planish_mesh plain; /* constraint is FIXED where cells hold nodes */
    planish_mesh mesh;
    planish_cells cells;
    uint8_t *type;
    int64_t *offset;
    int32_t *node;
    double *x;           /* of mesh */
    uint8_t *constraint; /* of plain [n] */
    int64_t *cell_of;    /* [elements of plain] */
    int32_t (*end)[2];   /* [n_nodes] both ends of a mid, else -1 */
} pair;

static const uint8_t EDGES[MOST_MIDS][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};

static void *zeroed(int64_t n, size_t size) {
    void *array = calloc((size_t)n + 1, size);
    assert_non_null(array);
    return array;
}

static double *place(const pair *p, int64_t node, int d) {
    const int64_t step = p->mesh.node_stride ? p->mesh.node_stride : p->mesh.dim;
    const int64_t apart = p->mesh.component_stride ? p->mesh.component_stride : 1;
    return p->x + node * step + d * apart;
}

static void append(pair *p, int type, const int32_t *node, int n) {
    const int64_t i = p->cells.n++;
    p->type[i] = (uint8_t)type;
    memcpy(p->node + p->offset[i], node, (size_t)n * sizeof *node);
    p->offset[i + 1] = p->offset[i] + n;
}

/** The mid of an edge: a new node, unless mid_of [n][n] has it. */
static int32_t mid_of_edge(pair *p, int32_t *mid_of, int32_t a, int32_t b) {
    const int64_t n = p->plain.n_nodes;
    int32_t *mid = &mid_of[a < b ? a * n + b : b * n + a];
    if (!*mid) {
        *mid = (int32_t)p->mesh.n_nodes++;
        p->end[*mid][0] = a;
        p->end[*mid][1] = b;
    }
    return *mid;
}

static void append_simplex(pair *p, int64_t element, int is_quadratic, int32_t *mid_of) {
    const int k = p->plain.dim + 1, n_mids = is_quadratic ? 3 * (k - 2) : 0;
    int32_t node[10];
    memcpy(node, p->plain.elements + element * k, (size_t)k * sizeof *node);
    for (int e = 0; e < n_mids; e++)
        node[k + e] = mid_of_edge(p, mid_of, node[EDGES[e][0]], node[EDGES[e][1]]);
    p->cell_of[element] = p->cells.n;
    append(p, is_quadratic ? (k == 4 ? 24 : 22) : (k == 4 ? 10 : 5), node, k + n_mids);
}

/** Append elements that are not smoothed: apart, with a node twice or of another dimension, and at the
 *  corners of an element. */
static void append_others(pair *p, int64_t element) {
    const int k = p->plain.dim + 1, n = k == 4 ? 8 : 4;
    int32_t apart[MOST_NODES], collapsed[MOST_NODES];
    const int32_t *corner = p->plain.elements + element * k;
    for (int j = 0; j < n; j++)
        apart[j] = (int32_t)p->mesh.n_nodes++;
    memcpy(collapsed, apart, sizeof collapsed);
    collapsed[n - 1] = collapsed[n - 2];
    append(p, k == 4 ? 12 : 9, collapsed, n);
    append(p, k == 4 ? 5 : 10, k == 4 ? apart + 5 : apart, k == 4 ? 3 : 4);
    if (element % 3 == 0)
        append(p, 3, corner, 2);
    if (element % 5 == 0)
        append(p, 1, corner + 2, 1);
    for (int j = 0; j < 3; j++)
        if ((element % 3 == 0 && j < 2) || (element % 5 == 0 && j == 2))
            p->constraint[corner[j]] = PLANISH_CONSTRAINT_FIXED;
}

/** Place the nodes: those apart are at corners of the box. */
static void place_nodes(pair *p, int how) {
    const int dim = p->plain.dim;
    const double *x = p->plain.coordinates;
    p->x = zeroed((p->mesh.n_nodes + 1) * dim, sizeof *p->x);
    if (how & BY_COMPONENT) {
        p->mesh.node_stride = 1;
        p->mesh.component_stride = p->mesh.n_nodes;
    }
    for (int64_t i = 0; i < p->mesh.n_nodes; i++)
        for (int d = 0; d < dim; d++)
            *place(p, i, d) = i < p->plain.n_nodes ? x[i * dim + d]
                              : p->end[i][0] < 0
                                  ? x[d]
                                  : (x[p->end[i][0] * dim + d] + x[p->end[i][1] * dim + d]) / 2;
    p->mesh.coordinates = p->x;
}

/** Make cells of simplices. */
static pair pair_of(const test_mesh *simplices, int how) {
    const planish_mesh *plain = &simplices->mesh;
    const int64_t n = plain->n_nodes, m = plain->n_elements;
    pair p = {.plain = *plain, .mesh = *plain};
    int32_t *mid_of = zeroed(n * n, sizeof *mid_of);
    const int64_t most = n + m * (MOST_MIDS + MOST_NODES);
    p.type = zeroed(5 * m, 1);
    p.offset = zeroed(5 * m, sizeof *p.offset);
    p.node = zeroed(30 * m, sizeof *p.node);
    p.cell_of = zeroed(m, sizeof *p.cell_of);
    p.constraint = zeroed(n, 1);
    p.end = zeroed(most, sizeof *p.end);
    memset(p.end, -1, (size_t)most * sizeof *p.end);
    for (int64_t i = 0; i < m; i++) {
        if ((how & OTHERS) && i % (m / 7) == 1)
            append_others(&p, i);
        append_simplex(&p, i, (how & ORDER_2) && !(how & HALF && i % 2), mid_of);
    }
    free(mid_of);
    place_nodes(&p, how);
    p.cells.type = p.type;
    p.cells.offset = p.offset;
    p.cells.node = p.node;
    p.mesh.elements = NULL;
    p.mesh.n_elements = p.cells.n;
    p.plain.constraint = p.constraint;
    return p;
}

/** Tell mesh where its cells are: p has been returned, so that they stay. */
static void fasten(pair *p) {
    p->mesh.cells = &p->cells;
}

static void release(pair *p) {
    free(p->type);
    free(p->offset);
    free(p->node);
    free(p->x);
    free(p->cell_of);
    free(p->constraint);
    free(p->end);
}

/* ---- the same of cells as of elements --------------------------------------------------------- */

/** Whether values of size bytes are those of elements at their cells, and 0 at other cells. */
static void assert_by_cell(const pair *p, const void *plain, const void *by_cell, size_t size) {
    static const char none[16] = {0};
    char *of_cell = zeroed(p->cells.n, size);
    for (int64_t i = 0; i < p->plain.n_elements; i++)
        memcpy(of_cell + (size_t)p->cell_of[i] * size, (const char *)plain + (size_t)i * size,
               size);
    for (int64_t i = 0; i < p->cells.n; i++)
        if (memcmp(of_cell + (size_t)i * size, (const char *)by_cell + (size_t)i * size, size) != 0)
            fail_msg("cell %d of type %d differs", (int)i, p->type[i]);
    for (int64_t i = 0, k = 0; i < p->cells.n; i++)
        if (k < p->plain.n_elements && p->cell_of[k] == i)
            k++;
        else
            assert_memory_equal((const char *)by_cell + (size_t)i * size, none, size);
    free(of_cell);
}

/** Values by element as an array by cells, with garbage at other cells; to be freed. */
static void *by_cells(const pair *p, const void *plain, size_t size) {
    char *of_cell = zeroed(p->cells.n, size);
    memset(of_cell, 0x7f, (size_t)p->cells.n * size); /* NaN as double */
    memset(of_cell, 0xff, size);
    for (int64_t i = 0; i < p->plain.n_elements; i++)
        memcpy(of_cell + (size_t)p->cell_of[i] * size, (const char *)plain + (size_t)i * size,
               size);
    return of_cell;
}

static void assert_infos_agree(planish_plan *const plan[2]) {
    planish_plan_info a, b;
    planish_plan_get_info(plan[0], &a);
    planish_plan_get_info(plan[1], &b);
    a.threads = b.threads;
    a.binding = b.binding;
    a.bytes = b.bytes;
    assert_memory_equal(&a, &b, sizeof a);
}

static void assert_nodes_agree(const pair *p, planish_plan *const plan[2], int is_around) {
    const int64_t n = p->plain.n_nodes, n_all = p->mesh.n_nodes;
    uint8_t *plain = zeroed(n, 1), *of_cells = zeroed(n_all, 1);
    planish_plan_get_free(plan[0], plain);
    planish_plan_get_free(plan[1], of_cells);
    assert_memory_equal(plain, of_cells, (size_t)n);
    for (int64_t i = n; i < n_all; i++)
        assert_int_equal(of_cells[i], 0);
    assert_int_equal(planish_plan_get_held(plan[0], p->plain.coordinates, plain, NULL), 0);
    assert_int_equal(planish_plan_get_held(plan[1], p->x, of_cells, NULL), 0);
    assert_memory_equal(plain, of_cells, (size_t)n);
    for (int64_t i = n; i < n_all; i++) {
        const int32_t *end = p->end[i];
        if (end[0] < 0)
            assert_true(of_cells[i] == PLANISH_HELD_FIXED || of_cells[i] == PLANISH_HELD_UNUSED ||
                        (is_around && of_cells[i] == PLANISH_HELD_NOT_CHOSEN));
        else
            assert_int_equal(of_cells[i],
                             plain[end[0]] && plain[end[1]] ? plain[end[0]] | plain[end[1]] : 0);
    }
    free(plain);
    free(of_cells);
}

/** All measures of plain coordinates x and those of p->x. */
static void assert_measures_agree(const pair *p, planish_plan *const plan[2], const double *x,
                                  const planish_options *options) {
    const int64_t m = p->plain.n_elements;
    planish_quality quality[2];
    double *ratio = zeroed(m, sizeof *ratio), *ratio_by_cell = by_cells(p, ratio, sizeof *ratio);
    uint8_t *state = zeroed(m, 1), *state_by_cell = by_cells(p, state, 1);
    int64_t n[2], n_left[2];
    assert_int_equal(planish_measure(plan[0], x, &quality[0], NULL), 0);
    assert_int_equal(planish_measure(plan[1], p->x, &quality[1], NULL), 0);
    if (quality[0].worst_element >= 0)
        quality[0].worst_element = p->cell_of[quality[0].worst_element];
    assert_memory_equal(&quality[0], &quality[1], sizeof quality[0]);
    assert_int_equal(planish_measure_elements(plan[0], x, ratio, NULL), 0);
    assert_int_equal(planish_measure_elements(plan[1], p->x, ratio_by_cell, NULL), 0);
    assert_by_cell(p, ratio, ratio_by_cell, sizeof *ratio);
    memset(state_by_cell, 0x7f, (size_t)p->cells.n);
    assert_int_equal(planish_find_reversed(plan[0], x, state, &n[0], NULL), 0);
    assert_int_equal(planish_find_reversed(plan[1], p->x, state_by_cell, &n[1], NULL), 0);
    assert_by_cell(p, state, state_by_cell, 1);
    assert_int_equal(n[0], n[1]);
    memset(state_by_cell, 0x7f, (size_t)p->cells.n);
    planish_find_wrapped(plan[0], state, &n[0]);
    planish_find_wrapped(plan[1], state_by_cell, &n[1]);
    assert_by_cell(p, state, state_by_cell, 1);
    assert_int_equal(n[0], n[1]);
    memset(state_by_cell, 0x7f, (size_t)p->cells.n);
    for (int i = 0; i < 2; i++)
        assert_int_equal(planish_check_volumes(plan[i], i ? p->x : x, options,
                                               i ? state_by_cell : state, &n[i], &n_left[i], NULL),
                         0);
    assert_by_cell(p, state, state_by_cell, 1);
    assert_true(n[0] == n[1] && n_left[0] == n_left[1]);
    memset(state_by_cell, 0x7f, (size_t)p->cells.n);
    for (int i = 0; i < 2; i++)
        assert_int_equal(planish_find_infeasible(plan[i], i ? p->x : x, options,
                                                 i ? state_by_cell : state, &n[i], &n_left[i],
                                                 NULL),
                         0);
    assert_by_cell(p, state, state_by_cell, 1);
    assert_true(n[0] == n[1] && n_left[0] == n_left[1]);
    free(ratio);
    free(ratio_by_cell);
    free(state);
    free(state_by_cell);
}

/** Whether corners are where x has them, and mids half way between their ends. */
static void assert_places_agree(const pair *p, const double *x) {
    for (int64_t i = 0; i < p->mesh.n_nodes; i++)
        for (int d = 0; d < p->mesh.dim; d++) {
            const double at = *place(p, i, d);
            if (i < p->plain.n_nodes)
                assert_memory_equal(&at, &x[i * p->mesh.dim + d], sizeof at);
            else if (p->end[i][0] >= 0)
                assert_true(fabs(at - (x[p->end[i][0] * p->mesh.dim + d] +
                                       x[p->end[i][1] * p->mesh.dim + d]) /
                                          2) < 1e-14 * 10);
        }
}

/** Smooth both; return the nodes of the simplices that have moved. */
static int64_t assert_smoothed_alike(pair *p, const planish_options *options) {
    const size_t bytes = (size_t)(p->plain.n_nodes * p->plain.dim) * sizeof(double);
    double *x = malloc(bytes);
    planish_plan *plan[2];
    planish_result result[2];
    planish_error error;
    planish_options of[2] = {*options, *options};
    of[0].threads = 1;
    of[1].threads = 3;
    memcpy(x, p->plain.coordinates, bytes);
    for (int i = 0; i < 2; i++)
        if (planish_plan_create(i ? &p->mesh : &p->plain, &of[i], &plan[i], &error))
            fail_msg("%s", error.text);
    assert_infos_agree(plan);
    assert_nodes_agree(p, plan, options->around != NULL);
    assert_measures_agree(p, plan, x, options);
    for (int i = 0; i < 2; i++)
        if (planish_smooth(plan[i], i ? p->x : x, &of[i], &result[i], &error))
            fail_msg("%s", error.text);
    assert_int_equal(result[1].n_curved, 0);
    assert_true(result[1].n_moved_nodes >= result[0].n_moved_nodes);
    for (int i = 0; i < 2; i++)
        result[i].seconds = 0;
    const int64_t n_moved = result[0].n_moved_nodes;
    result[1].n_moved_nodes = n_moved;
    assert_memory_equal(&result[0], &result[1], sizeof result[0]);
    assert_places_agree(p, x);
    assert_measures_agree(p, plan, x, options);
    planish_plan_destroy(plan[0]);
    planish_plan_destroy(plan[1]);
    free(x);
    return n_moved;
}

static const int HOWS[] = {0,
                           BY_COMPONENT,
                           OTHERS,
                           ORDER_2,
                           ORDER_2 | HALF,
                           ORDER_2 | OTHERS,
                           ORDER_2 | HALF | OTHERS | BY_COMPONENT};
enum { N_HOWS = sizeof HOWS / sizeof *HOWS };

static planish_options defaults(void) {
    planish_options options;
    planish_options_init(&options);
    options.threads = 2;
    options.max_sweeps = 6;
    return options;
}

static test_mesh box_of(int dim, int cells, double shake) {
    test_mesh box;
    test_mesh_box(&box, dim, cells);
    test_mesh_perturb(&box, shake, 5);
    test_mesh_renumber(&box, 7, NULL);
    return box;
}

/** A node near the middle of a box of cells. */
static int64_t middle_of(const test_mesh *box, double cells) {
    int64_t nearest = 0;
    double least = INFINITY;
    for (int64_t i = 0; i < box->mesh.n_nodes; i++) {
        double off = 0;
        for (int d = 0; d < box->mesh.dim; d++)
            off += fabs(box->coordinates[i * box->mesh.dim + d] - cells / 2);
        nearest = off < least ? i : nearest;
        least = fmin(off, least);
    }
    return nearest;
}

static void smoothing_gives_the_same_bits(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int h = 0; h < N_HOWS; h++)
            for (int tangled = 0; tangled < 2; tangled++) {
                planish_options options = defaults();
                test_mesh box = box_of(dim, 4, tangled ? 0.6 : 0.15);
                test_mesh_reverse_some(&box, 9, 1);
                pair p = pair_of(&box, HOWS[h]);
                fasten(&p);
                options.worst = PLANISH_WORST_ANGLE;
                assert_true(assert_smoothed_alike(&p, &options) > 0);
                release(&p);
                test_mesh_destroy(&box);
            }
}

static void subsets_give_the_same_bits(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int h = 0; h < N_HOWS; h++)
            for (int which = 0; which < 3; which++) {
                planish_options options = defaults();
                test_mesh box = box_of(dim, 5, which == 1 ? 0.3 : 0.15);
                pair p = pair_of(&box, HOWS[h]);
                const int64_t around[] = {middle_of(&box, 5), 3};
                fasten(&p);
                options.only_worse_than = which < 2 ? (dim == 3 ? 2.2 : 1.6) : 0;
                options.around = which < 2 ? NULL : around;
                options.n_around = which < 2 ? 0 : 2;
                options.rings = 1;
                assert_true(assert_smoothed_alike(&p, &options) > 0);
                release(&p);
                test_mesh_destroy(&box);
            }
}

static void min_volumes_go_by_cells(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int h = 0; h < N_HOWS; h++)
            for (int which = 0; which < 3; which++) {
                planish_options options = defaults();
                test_mesh box = box_of(dim, 4, 0.15);
                pair p = pair_of(&box, HOWS[h]);
                const int64_t around[] = {middle_of(&box, 4)};
                double *least = zeroed(p.plain.n_elements, sizeof *least);
                for (int64_t i = 0; i < p.plain.n_elements; i++)
                    least[i] = (1 + 0.1 * (double)(i % 7)) * (dim == 3 ? 0.08 : 0.3);
                fasten(&p);
                p.plain.min_volume = least;
                p.mesh.min_volume = by_cells(&p, least, sizeof *least);
                options.only_worse_than = which == 1 ? 3 : 0;
                options.around = which == 2 ? around : NULL;
                options.n_around = which == 2;
                options.area_weight = 0.2;
                assert_smoothed_alike(&p, &options);
                free((void *)p.mesh.min_volume);
                free(least);
                release(&p);
                test_mesh_destroy(&box);
            }
}

static void layers_go_by_cells(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int h = 0; h < N_HOWS; h++) {
            test_mesh box = box_of(dim, 4, 0);
            for (int64_t i = 0; i < box.mesh.n_nodes; i++)
                box.coordinates[i * dim] *= 0.05;
            pair p = pair_of(&box, HOWS[h]);
            uint8_t *plain = zeroed(p.plain.n_elements, 1), *of_cells = by_cells(&p, plain, 1);
            int64_t n[2];
            fasten(&p);
            assert_int_equal(planish_find_layers(&p.plain, 1, plain, &n[0], NULL), 0);
            assert_int_equal(planish_find_layers(&p.mesh, 2, of_cells, &n[1], NULL), 0);
            assert_by_cell(&p, plain, of_cells, 1);
            assert_true(n[0] == n[1] && n[0] > 0);
            free(plain);
            free(of_cells);
            release(&p);
            test_mesh_destroy(&box);
        }
}

static void regions_go_by_cells(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int h = 0; h < N_HOWS; h++) {
            test_mesh box = box_of(dim, 4, 0);
            pair p = pair_of(&box, HOWS[h]);
            int32_t *region = zeroed(p.plain.n_elements, sizeof *region);
            double *number = zeroed(p.plain.n_elements, sizeof *number);
            uint8_t *plain = zeroed(p.plain.n_nodes, 1), *of_cells = zeroed(p.mesh.n_nodes, 1);
            int64_t n[2];
            for (int64_t i = 0; i < p.plain.n_elements; i++) {
                region[i] = box.coordinates[box.elements[i * (dim + 1)] * dim] > 2;
                number[i] = (double)i;
            }
            planish_cell_array arrays[] = {
                {.values = by_cells(&p, region, sizeof *region), .type = PLANISH_NUMBER_INT32},
                {.values = by_cells(&p, number, sizeof *number), .type = PLANISH_NUMBER_FLOAT64}};
            fasten(&p);
            assert_int_equal(planish_find_regions(&p.mesh, arrays, 2, 2, NULL), 0);
            assert_true(arrays[0].is_region == 1 && arrays[1].is_region == 0);
            assert_int_equal(planish_find_interfaces(&p.plain, region, 1, plain, &n[0], NULL), 0);
            assert_int_equal(
                planish_find_interfaces(&p.mesh, arrays[0].values, 2, of_cells, &n[1], NULL), 0);
            assert_memory_equal(plain, of_cells, (size_t)p.plain.n_nodes);
            assert_true(n[0] == n[1] && n[0] > 0);
            free((void *)arrays[0].values);
            free((void *)arrays[1].values);
            free(region);
            free(number);
            free(plain);
            free(of_cells);
            release(&p);
            test_mesh_destroy(&box);
        }
}

/** Let nodes of both meshes slide, by planish_find_slides with each one's surface. */
static void let_slide(pair *p, const planish_surface *surface, const planish_surface *of_cells) {
    const int64_t n = p->plain.n_nodes, n_all = p->mesh.n_nodes, dim = p->plain.dim;
    uint8_t *constraint = zeroed(n, 1), *by_cells = zeroed(n_all, 1);
    double *direction = zeroed(n * dim, sizeof *direction);
    double *direction_by_cells = zeroed(n_all * dim, sizeof *direction);
    planish_slide_info info[2];
    assert_int_equal(
        planish_find_slides(&p->plain, surface, 1, constraint, direction, &info[0], NULL), 0);
    assert_int_equal(
        planish_find_slides(&p->mesh, of_cells, 2, by_cells, direction_by_cells, &info[1], NULL),
        0);
    assert_memory_equal(constraint, by_cells, (size_t)n);
    for (int64_t i = n; i < n_all; i++)
        assert_true(by_cells[i] == PLANISH_CONSTRAINT_FREE ||
                    (p->end[i][0] < 0 && by_cells[i] == PLANISH_CONSTRAINT_FIXED));
    assert_memory_equal(&info[0], &info[1], sizeof info[0]);
    memcpy(p->constraint, constraint, (size_t)n);
    free(constraint);
    p->plain.direction = direction;
    p->mesh.constraint = by_cells;
    p->mesh.direction = direction_by_cells;
}

static void stop_sliding(pair *p) {
    free((void *)p->plain.direction);
    free((void *)p->mesh.constraint);
    free((void *)p->mesh.direction);
}

static void straight_edges_let_nodes_slide(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int h = 0; h < N_HOWS; h++)
            for (int subset = 0; subset < 2; subset++) {
                planish_options options = defaults();
                test_mesh box = box_of(dim, 4, 0.15);
                pair p = pair_of(&box, HOWS[h]);
                fasten(&p);
                let_slide(&p, NULL, NULL);
                options.only_worse_than = subset ? (dim == 3 ? 2 : 1.5) : 0;
                assert_true(assert_smoothed_alike(&p, &options) > 0);
                stop_sliding(&p);
                release(&p);
                test_mesh_destroy(&box);
            }
}

/** The sides x = 0 and x = size of both meshes in pairs; mids in the pairs of mesh, too. At most most
 *  pairs of corners. */
static void add_pairs(pair *p, double size, int64_t most) {
    const int64_t n = p->mesh.n_nodes;
    int32_t *list = zeroed(2 * n, sizeof *list);
    int64_t n_plain = 0, n_all = 0;
    for (int64_t i = 0; i < n; i++)
        for (int64_t k = 0; k < n && *place(p, i, 0) == 0; k++) {
            double off = fabs(*place(p, k, 0) - size);
            for (int d = 1; d < p->mesh.dim; d++)
                off += fabs(*place(p, k, d) - *place(p, i, d));
            if (off > 0 || (i < p->plain.n_nodes) != (k < p->plain.n_nodes) ||
                (i < p->plain.n_nodes && n_plain == most))
                continue;
            list[2 * n_all] = (int32_t)i;
            list[2 * n_all++ + 1] = (int32_t)k;
            n_plain += i < p->plain.n_nodes;
        }
    p->plain.periodic = p->mesh.periodic = list; /* corners come first */
    p->plain.n_periodic = n_plain;
    p->mesh.n_periodic = n_all;
}

static void periodic_pairs_of_mids_are_passed_over(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int h = 0; h < N_HOWS; h++)
            for (int one = 0; one < 2; one++) { /* a translation needs two pairs of corners */
                planish_options options = defaults();
                test_mesh box = box_of(dim, 4, 0.15);
                pair p = pair_of(&box, HOWS[h]);
                fasten(&p);
                let_slide(&p, NULL, NULL);
                add_pairs(&p, 4, one ? 1 : INT32_MAX);
                assert_true(p.plain.n_periodic == 1 ? one : p.plain.n_periodic > 4);
                assert_true((p.mesh.n_periodic > p.plain.n_periodic) == ((HOWS[h] & ORDER_2) != 0));
                assert_true(assert_smoothed_alike(&p, &options) > 0);
                free((void *)p.mesh.periodic);
                stop_sliding(&p);
                release(&p);
                test_mesh_destroy(&box);
            }
}

/* ---- facets ----------------------------------------------------------------------------------- */

/** Facets of the side x = 0 with tags by the second coordinate, with mids where is_quadratic. */
static int64_t list_facets(const pair *p, int is_quadratic, int32_t *facets, int64_t *offset,
                           int32_t *tag) {
    const int dim = p->plain.dim, k = dim + 1;
    int64_t n = 0;
    for (int64_t i = 0; i < p->plain.n_elements; i++)
        for (int without = 0; without < k; without++) {
            const int32_t *node = p->plain.elements + i * k;
            int at = 0, is_on = 1;
            int32_t corner[3] = {0};
            for (int j = 0; j < k; j++)
                if (j != without)
                    corner[at++] = node[j];
            for (int j = 0; j < dim; j++)
                is_on &= p->plain.coordinates[corner[j] * dim] == 0;
            if (!is_on)
                continue;
            memcpy(facets + offset[n], corner, (size_t)dim * sizeof *corner);
            for (int j = dim; is_quadratic && j < 3 * (dim - 1); j++)
                facets[offset[n] + j] = j % 2 ? -7 : INT32_MAX; /* mids are not looked at */
            tag[n] = p->plain.coordinates[corner[0] * dim + 1] > 2;
            offset[n + 1] = offset[n] + (is_quadratic ? 3 * (dim - 1) : dim);
            n++;
        }
    return n;
}

static void facets_have_any_number_of_nodes(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int h = 0; h < N_HOWS; h++)
            for (int is_quadratic = 0; is_quadratic < 2; is_quadratic++) {
                test_mesh box = box_of(dim, 4, 0);
                pair p = pair_of(&box, HOWS[h]);
                const int64_t most = p.plain.n_elements;
                int32_t *facets[2] = {zeroed(6 * most, sizeof(int32_t)),
                                      zeroed(6 * most, sizeof(int32_t))};
                int64_t *offset[2] = {zeroed(most, sizeof(int64_t)), zeroed(most, sizeof(int64_t))};
                int32_t *tag = zeroed(most, sizeof *tag);
                planish_surface surface[2] = {{.facet_tag = tag, .tagged_only = 1},
                                              {.facet_tag = tag, .tagged_only = 1}};
                for (int i = 0; i < 2; i++) {
                    surface[i].n_facets =
                        list_facets(&p, i && is_quadratic, facets[i], offset[i], tag);
                    surface[i].facets = facets[i];
                }
                surface[1].facet_offset = offset[1];
                assert_true(surface[0].n_facets > 3);
                fasten(&p);
                let_slide(&p, &surface[0], &surface[1]);
                int64_t n_sliding = 0;
                for (int64_t i = 0; i < p.plain.n_nodes; i++)
                    n_sliding += p.constraint[i] >= PLANISH_CONSTRAINT_ON_PLANE;
                assert_true(n_sliding > 0);
                stop_sliding(&p);
                for (int i = 0; i < 2; i++) {
                    free(facets[i]);
                    free(offset[i]);
                }
                free(tag);
                release(&p);
                test_mesh_destroy(&box);
            }
}

/** The nodes of a quadrilateral on a side become fixed, and nothing else changes. */
static void quadrilaterals_fix_their_corners(void **state) {
    (void)state;
    enum { CELLS = 4, SIDE = CELLS + 1 };
    test_mesh box;
    test_mesh_box(&box, 3, CELLS);
    const size_t n = (size_t)box.mesh.n_nodes;
    const int32_t at = SIDE + 1; /* x = 1, y = 1, z = 0 */
    const int32_t facets[] = {at, at + 1, at + 1 + SIDE, at + SIDE, -1, -1, -1, -1};
    const int64_t offset[] = {0, 8};
    const planish_surface surface = {.n_facets = 1, .facets = facets, .facet_offset = offset};
    uint8_t *constraint[2] = {malloc(n), malloc(n)};
    double *direction = malloc(3 * n * sizeof *direction);
    for (int i = 0; i < 2; i++)
        assert_int_equal(planish_find_slides(&box.mesh, i ? &surface : NULL, 1, constraint[i],
                                             direction, NULL, NULL),
                         0);
    for (int j = 0; j < 4; j++) {
        assert_int_equal(constraint[0][facets[j]], PLANISH_CONSTRAINT_ON_PLANE);
        constraint[0][facets[j]] = PLANISH_CONSTRAINT_FIXED;
    }
    assert_memory_equal(constraint[0], constraint[1], n);
    free(constraint[0]);
    free(constraint[1]);
    free(direction);
    test_mesh_destroy(&box);
}

/* ---- nodes that cells hold -------------------------------------------------------------------- */

/** A mid, the ends of its edge, and a cell and place that has it. */
typedef struct edge {
    int32_t mid, a, b;
    int64_t at; /* in node */
} edge;

/** Find an edge with a mid whose ends is_wanted [n] has, and whose middle is at least far from the
 *  sides of the box other than x = 0. */
static edge find_edge(const pair *p, const uint8_t *is_wanted, double far) {
    for (int64_t at = 0; at < p->offset[p->cells.n]; at++) {
        const int32_t mid = p->node[at], *end = p->end[mid];
        int fits = end[0] >= 0 && is_wanted[end[0]] && is_wanted[end[1]];
        for (int d = 1; fits && d < p->mesh.dim; d++)
            fits = *place(p, mid, d) > far && *place(p, mid, d) < 6 - far;
        if (fits)
            return (edge){mid, end[0], end[1], at};
    }
    fail_msg("no such edge");
    return (edge){0, 0, 0, 0};
}

/** Ways in which cells hold the ends of an edge of free nodes, and perhaps those of another one. */
enum {
    MID_FIXED,
    MID_OF_VERTEX,
    MID_OF_LINE3,
    END_OF_VERTEX,
    MID_IS_CORNER,
    MID_OF_TWO_EDGES,
    MID_MISSING,
    MID_TWICE,
    N_WAYS
};

/** Change p so; is_held [n] becomes 1 for nodes that are held because of that. */
static void hold(pair *p, int way, const edge *e, const edge *other, uint8_t *constraint,
                 uint8_t *is_held) {
    const int32_t line[3] = {p->plain.n_nodes > 0 ? other->mid : 0, e->b, e->mid};
    is_held[e->a] = is_held[e->b] = way != MID_MISSING && way != MID_TWICE;
    switch (way) {
    case MID_FIXED:
        constraint[e->mid] = PLANISH_CONSTRAINT_FIXED;
        p->mesh.constraint = constraint;
        break;
    case MID_OF_VERTEX:
        append(p, PLANISH_CELL_VERTEX, &e->mid, 1);
        break;
    case MID_OF_LINE3: /* with a mid at its end, too */
        append(p, PLANISH_CELL_LINE3, line, 3);
        is_held[other->a] = is_held[other->b] = 1;
        break;
    case END_OF_VERTEX:
        append(p, PLANISH_CELL_VERTEX, &e->a, 1);
        is_held[e->b] = 0;
        break;
    case MID_IS_CORNER:
        p->node[e->at] = other->a;
        break;
    case MID_OF_TWO_EDGES:
        p->node[other->at] = e->mid;
        is_held[other->a] = is_held[other->b] = 1;
        break;
    case MID_MISSING:
        p->node[e->at] = -1;
        break;
    default: /* another mid in one of the elements */
        p->node[e->at] = (int32_t)p->mesh.n_nodes++;
        break;
    }
}

/** Set is_wanted [n_nodes] to 0 for the nodes of all cells that node is of. */
static void leave_out_cells(const pair *p, int32_t node, uint8_t *is_wanted) {
    for (int64_t i = 0; i < p->cells.n; i++) {
        int has_node = 0;
        for (int64_t at = p->offset[i]; at < p->offset[i + 1]; at++)
            has_node |= p->node[at] == node;
        for (int64_t at = p->offset[i]; has_node && at < p->offset[i + 1]; at++)
            is_wanted[p->node[at]] = 0;
    }
}

static void cells_hold_nodes(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int way = 0; way < N_WAYS; way++) {
            const planish_options options = defaults();
            test_mesh box = box_of(dim, 6, 0);
            pair p = pair_of(&box, ORDER_2 | OTHERS);
            planish_plan *plan;
            const size_t n = (size_t)p.mesh.n_nodes; /* arrays have room for one more */
            uint8_t *before = zeroed(p.mesh.n_nodes, 1), *after = zeroed(p.mesh.n_nodes, 1);
            uint8_t *is_held = zeroed(p.mesh.n_nodes, 1), *rest = zeroed(p.mesh.n_nodes, 1);
            uint8_t *constraint = zeroed(p.mesh.n_nodes, 1);
            fasten(&p);
            assert_int_equal(planish_plan_create(&p.mesh, &options, &plan, NULL), 0);
            planish_plan_get_free(plan, before);
            planish_plan_destroy(plan);
            const edge e = find_edge(&p, before, 0);
            memcpy(rest, before, n);
            leave_out_cells(&p, e.mid, rest);
            const edge other = find_edge(&p, rest, 0);
            hold(&p, way, &e, &other, constraint, is_held);
            p.mesh.n_elements = p.cells.n;
            assert_int_equal(planish_plan_create(&p.mesh, &options, &plan, NULL), 0);
            planish_plan_get_free(plan, after);
            for (size_t i = 0; i < n; i++)
                assert_int_equal(after[i], before[i] && !is_held[i]);
            assert_int_equal(planish_plan_get_held(plan, NULL, after, NULL), 0);
            for (size_t i = 0; i < n; i++)
                assert_true(!is_held[i] || after[i] == PLANISH_HELD_FIXED);
            assert_int_equal(after[e.mid], way == MID_MISSING || way == MID_TWICE ||
                                                   way == END_OF_VERTEX || way == MID_IS_CORNER
                                               ? after[e.mid]
                                               : PLANISH_HELD_FIXED);
            planish_plan_destroy(plan);
            free(before);
            free(after);
            free(is_held);
            free(rest);
            free(constraint);
            release(&p);
            test_mesh_destroy(&box);
        }
}

/** Fill slides [n_nodes] with 1 for nodes that slide in a plan of p, and moves for those that move
 *  otherwise. Others on the boundary, but those that constraints fix, are told to be held by cells. */
static void find_moving(const pair *p, const planish_options *options, uint8_t *slides,
                        uint8_t *moves) {
    planish_plan *plan;
    assert_int_equal(planish_plan_create(&p->mesh, options, &plan, NULL), 0);
    assert_int_equal(planish_plan_get_held(plan, NULL, slides, NULL), 0);
    planish_plan_get_free(plan, moves);
    for (int64_t i = 0; i < p->mesh.n_nodes; i++) {
        assert_true(i >= p->plain.n_nodes || !(slides[i] & PLANISH_HELD_BOUNDARY) ||
                    (slides[i] & PLANISH_HELD_FIXED));
        slides[i] = !slides[i] && !moves[i] && i < p->plain.n_nodes;
    }
    planish_plan_destroy(plan);
}

/** Curved edges of the boundary hold their ends in a plan; those that go inside do not. */
static void curved_edges_hold_nodes_that_slide(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int inside = 0; inside < 2; inside++) {
            planish_options options = defaults();
            test_mesh box = box_of(dim, 6, 0);
            pair p = pair_of(&box, ORDER_2);
            const size_t n = (size_t)p.mesh.n_nodes;
            uint8_t *before = zeroed(p.mesh.n_nodes, 1), *after = zeroed(p.mesh.n_nodes, 1);
            uint8_t *moves = zeroed(p.mesh.n_nodes, 1);
            fasten(&p);
            let_slide(&p, NULL, NULL);
            find_moving(&p, &options, before, moves);
            /* from one that slides to a free one: not both slide, but both are of either kind */
            edge e = {0, 0, 0, 0};
            if (inside)
                for (int64_t i = 0; i < p.mesh.n_nodes; i++) {
                    const int32_t *end = p.end[i];
                    if (end[0] >= 0 && before[end[0]] && moves[end[1]])
                        e = (edge){(int32_t)i, end[0], end[1], 0};
                }
            else
                e = find_edge(&p, before, 0);
            assert_true(e.mid > 0);
            for (int d = 0; d < dim; d++)
                *place(&p, e.mid, d) += 0.05;
            find_moving(&p, &options, after, moves);
            for (size_t i = 0; i < n; i++)
                assert_int_equal(after[i],
                                 before[i] && (inside || ((int32_t)i != e.a && (int32_t)i != e.b)));
            options.rounding = 0.1;
            find_moving(&p, &options, after, moves);
            assert_memory_equal(before, after, n);
            options.rounding = 0;
            options.only_worse_than = 1.1; /* all, as a subset */
            find_moving(&p, &options, after, moves);
            assert_int_equal(after[e.a], inside && before[e.a]);
            stop_sliding(&p);
            free(before);
            free(after);
            free(moves);
            release(&p);
            test_mesh_destroy(&box);
        }
}

/** The constraints of planish_find_slides, in out [n_nodes]. */
static void find_constraints(const pair *p, double tolerance, uint8_t *out) {
    const planish_surface surface = {.tolerance = tolerance};
    double *direction = zeroed(p->mesh.n_nodes * p->mesh.dim, sizeof *direction);
    assert_int_equal(planish_find_slides(&p->mesh, &surface, 1, out, direction, NULL, NULL), 0);
    free(direction);
}

static int is_on_box(const pair *p, int32_t node) {
    int is_on = 0;
    for (int d = 0; d < p->mesh.dim; d++)
        is_on |= *place(p, node, d) == 0 || *place(p, node, d) == 6;
    return is_on;
}

/** Ends of a curved edge of the surface do not slide, nor do corners of triangles that it curves. */
static void curved_surfaces_are_no_planes(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int off = 0; off < 2; off++) { /* the plane, along the first axis */
            test_mesh box = box_of(dim, 6, 0);
            pair p = pair_of(&box, ORDER_2);
            const size_t n = (size_t)p.mesh.n_nodes;
            uint8_t *before = zeroed(p.mesh.n_nodes, 1), *after = zeroed(p.mesh.n_nodes, 1);
            uint8_t *on_side = zeroed(p.mesh.n_nodes, 1);
            int64_t n_fixed = 0;
            fasten(&p);
            find_constraints(&p, 0, before);
            for (int64_t i = 0; i < p.plain.n_nodes; i++)
                on_side[i] = *place(&p, i, 0) == 0 && before[i] != PLANISH_CONSTRAINT_FIXED;
            const edge e = find_edge(&p, on_side, 1.1);
            for (int d = off ? 0 : 1; d < (off ? 1 : dim); d++)
                *place(&p, e.mid, d) += d == 2 ? 0.004 : 0.005;
            find_constraints(&p, 0, after);
            assert_true(before[e.a] != PLANISH_CONSTRAINT_FIXED &&
                        after[e.a] == PLANISH_CONSTRAINT_FIXED &&
                        after[e.b] == PLANISH_CONSTRAINT_FIXED);
            for (size_t i = 0; i < n; i++) {
                n_fixed += after[i] != before[i];
                assert_true(after[i] == before[i] ||
                            (on_side[i] && after[i] == PLANISH_CONSTRAINT_FIXED));
            }
            assert_int_equal(n_fixed, dim == 3 && off ? 4 : 2);
            find_constraints(&p, 1e-3, after);
            assert_memory_equal(before, after, n);
            /* curved edges that go inside */
            for (int64_t i = p.plain.n_nodes; i < p.mesh.n_nodes; i++)
                for (int d = 0; d < dim; d++)
                    *place(&p, i, d) +=
                        is_on_box(&p, p.end[i][0]) && is_on_box(&p, p.end[i][1]) ? 0 : 0.01;
            for (int d = 0; d < dim; d++)
                *place(&p, e.mid, d) = (*place(&p, e.a, d) + *place(&p, e.b, d)) / 2;
            find_constraints(&p, 0, after);
            assert_memory_equal(before, after, n);
            free(before);
            free(after);
            free(on_side);
            release(&p);
            test_mesh_destroy(&box);
        }
}

/** Constraints of the caller's stay, and mids are never fixed, by an edge with a tag neither. */
static void given_constraints_stay(void **state) {
    (void)state;
    test_mesh box = box_of(3, 4, 0);
    pair p = pair_of(&box, ORDER_2 | OTHERS);
    uint8_t *constraint = zeroed(p.mesh.n_nodes, 1), *out = zeroed(p.mesh.n_nodes, 1);
    double *direction = zeroed(p.mesh.n_nodes * 3, sizeof *direction);
    int32_t edge_of[2] = {0, 0};
    int64_t n_held = 0;
    fasten(&p);
    for (int64_t i = 0; i < p.plain.n_nodes; i++)
        constraint[i] = p.constraint[i] ? PLANISH_CONSTRAINT_ON_SURFACE : 0;
    for (int32_t i = (int32_t)p.plain.n_nodes; i < p.mesh.n_nodes; i++)
        if (p.end[i][0] >= 0) {
            edge_of[0] = p.end[i][0];
            edge_of[1] = i;
            constraint[i] = i % 2 ? PLANISH_CONSTRAINT_FREE : PLANISH_CONSTRAINT_FIXED;
        }
    constraint[edge_of[1]] = PLANISH_CONSTRAINT_FREE;
    const planish_surface surface = {.n_edges = 1, .edges = edge_of};
    p.mesh.constraint = constraint;
    assert_int_equal(planish_find_slides(&p.mesh, &surface, 1, out, direction, NULL, NULL), 0);
    for (int64_t i = 0; i < p.mesh.n_nodes; i++) {
        if (constraint[i] != PLANISH_CONSTRAINT_FREE || p.end[i][0] >= 0)
            assert_int_equal(out[i], constraint[i]);
        n_held += constraint[i] == PLANISH_CONSTRAINT_ON_SURFACE;
    }
    assert_true(n_held > 0);
    free(constraint);
    free(out);
    free(direction);
    release(&p);
    test_mesh_destroy(&box);
}

/** Elements of another type with as many nodes are no simplices. */
static void nodes_alone_make_no_simplex(void **state) {
    (void)state;
    static const double X[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
    static const int64_t OFFSET[] = {0, 4, 8};
    static const uint8_t TYPE[] = {10, 9};
    static const int32_t NODE[] = {0, 1, 2, 3, 4, 1, 2, 3};
    const planish_cells cells = {.n = 2, .type = TYPE, .offset = OFFSET, .node = NODE};
    const planish_mesh mesh = {
        .dim = 3, .n_nodes = 5, .n_elements = 2, .coordinates = X, .cells = &cells};
    planish_quality quality;
    assert_int_equal(planish_measure_mesh(&mesh, NULL, &quality, NULL), 0);
    assert_int_equal(quality.n_elements, 1);
    assert_int_equal(quality.worst_element, 0);
}

/* ---- refusals --------------------------------------------------------------------------------- */

/** Fields of a mesh of the cells below that are changed. */
typedef struct change {
    const char *name;
    int n;       /* of n_elements, 0: 3 */
    int type;    /* of element 1, */
    int n_nodes; /* its number of nodes by offsets, */
    int32_t node[10];
    int field; /* other things */
    int status;
    int64_t element, node_told;
    const char *word;
} change;

enum {
    NO_FIELD,
    WITH_ELEMENTS,
    WITH_ELEMENTS64,
    WITH_NEIGHBOURS,
    WITH_NEIGHBOURS64,
    WITH_PART,
    WITHOUT_TYPES,
    NONE_SMOOTHED,
    NOT_FINITE
};

static const change CHANGES[] = {
    {"elements", 0, 24, 10, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}, WITH_ELEMENTS, -1, -1, -1, "both"},
    {"elements64", 0, 24, 10, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}, WITH_ELEMENTS64, -1, -1, -1, "both"},
    {"neighbours",
     0,
     24,
     10,
     {1, 2, 3, 4, 5, 6, 7, 8, 9, 10},
     WITH_NEIGHBOURS,
     -1,
     -1,
     -1,
     "neighbours"},
    {"neighbours64",
     0,
     24,
     10,
     {1, 2, 3, 4, 5, 6, 7, 8, 9, 10},
     WITH_NEIGHBOURS64,
     -1,
     -1,
     -1,
     "neighbours64"},
    {"part", 0, 24, 10, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}, WITH_PART, -7, -1, -1, "parts"},
    {"types", 0, 24, 10, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}, WITHOUT_TYPES, -1, -1, -1, "types"},
    {"n_elements", 2, 24, 10, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}, NO_FIELD, -1, -1, -1, "n_elements"},
    {"no smoothed one", 0, 14, 5, {1, 2, 3, 3, 5}, NONE_SMOOTHED, -2, -1, -1, "no tetrahedron"},
    {"unknown type", 0, 7, 5, {1, 2, 3, 4, 5}, NO_FIELD, -2, 1, -1, "type 7"},
    {"number of nodes", 0, 10, 5, {1, 2, 3, 4, 5}, NO_FIELD, -2, 1, -1, "5 nodes"},
    {"offsets", 0, 10, -1, {1, 2, 3, 4}, NO_FIELD, -2, 1, -1, "offsets"},
    {"node twice", 0, 10, 4, {1, 2, 3, 1}, NO_FIELD, -2, 1, 1, "twice"},
    {"mid twice", 0, 24, 10, {1, 2, 3, 4, 5, 6, 7, 8, 9, 5}, NO_FIELD, -2, 1, 5, "twice"},
    {"mid at a corner", 0, 24, 10, {1, 2, 3, 4, 5, 6, 7, 8, 9, 2}, NO_FIELD, -2, 1, 2, "twice"},
    {"node out of range", 0, 24, 10, {1, 2, 3, 4, 5, 6, 7, 8, 9, 99}, NO_FIELD, -2, 1, 99, "99"},
    {"corner missing", 0, 24, 10, {1, -1, 3, 4, 5, 6, 7, 8, 9, 0}, NO_FIELD, -2, 1, -1, "node -1"},
    {"mid not finite", 0, 24, 10, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}, NOT_FINITE, -2, -1, 10, "10"},
    {"mids missing", 0, 24, 10, {0, 1, 2, 4, -1, 6, 7, -1, 9, -1}, NO_FIELD, 0, 0, 0, ""},
    {"another dimension", 0, 5, 3, {1, 2, 3}, NO_FIELD, 0, 0, 0, ""},
};

/** Call all functions that take a mesh; each has to say the same, but layers may be of elements that
 *  are not smoothed. */
static void assert_refused(const change *c, const planish_mesh *mesh) {
    planish_error error[4];
    planish_quality quality;
    planish_plan *plan = NULL;
    uint8_t bytes[16];
    double direction[48];
    const int status[] = {
        planish_plan_create(mesh, NULL, &plan, &error[0]),
        planish_measure_mesh(mesh, NULL, &quality, &error[1]),
        planish_find_layers(mesh, 1, bytes, NULL, &error[2]),
        planish_find_slides(mesh, NULL, 1, bytes, direction, NULL, &error[3]),
    };
    for (int i = 0; i < 4; i++) {
        const int expected = i == 2 && c->field == NONE_SMOOTHED ? 0 : c->status;
        if (status[i] != expected ||
            (expected && (error[i].element != c->element || error[i].node != c->node_told ||
                          error[i].code != c->status || !strstr(error[i].text, c->word))))
            fail_msg("%s, call %d: %d, element %d, node %d, %s", c->name, i, status[i],
                     (int)error[i].element, (int)error[i].node, error[i].text);
    }
    planish_plan_destroy(plan);
}

static void wrong_meshes_are_refused(void **state) {
    (void)state;
    for (size_t k = 0; k < sizeof CHANGES / sizeof *CHANGES; k++) {
        const change *c = &CHANGES[k];
        const int32_t elements[12] = {0, 1, 2, 3};
        const int64_t elements64[12] = {0, 1, 2, 3};
        const planish_part part = {.node_number = NULL};
        uint8_t type[] = {10, (uint8_t)c->type, 3};
        int32_t node[16] = {0, 1, 2, 3};
        const int64_t n = 4 + c->n_nodes, offset[] = {0, 4, n, n + 2};
        double x[3 * 11];
        for (int i = 0; i < 33; i++) /* in general position, on a moment curve */
            x[i] = pow(i / 3, i % 3 + 1);
        memcpy(node + 4, c->node, sizeof c->node);
        if (n >= 4)
            node[n] = 5, node[n + 1] = 6;
        if (c->field == NONE_SMOOTHED)
            type[0] = 9;
        if (c->field == NOT_FINITE)
            x[30] = NAN;
        const planish_cells cells = {.n = 3,
                                     .type = c->field == WITHOUT_TYPES ? NULL : type,
                                     .offset = offset,
                                     .node = node};
        const planish_mesh mesh = {.dim = 3,
                                   .n_nodes = 11,
                                   .n_elements = c->n ? c->n : 3,
                                   .coordinates = x,
                                   .cells = &cells,
                                   .elements = c->field == WITH_ELEMENTS ? elements : NULL,
                                   .elements64 = c->field == WITH_ELEMENTS64 ? elements64 : NULL,
                                   .neighbours = c->field == WITH_NEIGHBOURS ? elements : NULL,
                                   .neighbours64 =
                                       c->field == WITH_NEIGHBOURS64 ? elements64 : NULL,
                                   .part = c->field == WITH_PART ? &part : NULL};
        assert_refused(c, &mesh);
    }
}

/** Errors name the cell of an element. */
static void errors_name_cells(void **state) {
    (void)state;
    const int64_t wrong = 20;
    test_mesh box = box_of(3, 4, 0);
    pair p = pair_of(&box, ORDER_2 | OTHERS);
    double *least = zeroed(p.cells.n, sizeof *least), *x = malloc(3 * (size_t)p.mesh.n_nodes * 8);
    planish_options options = defaults();
    planish_plan *plan;
    planish_error error;
    fasten(&p);
    memcpy(x, p.x, 3 * (size_t)p.mesh.n_nodes * 8);
    assert_true(p.cell_of[wrong] != wrong);
    for (int64_t i = 0; i < p.cells.n; i++)
        least[i] = 0.01;
    p.mesh.min_volume = least;
    least[p.cell_of[wrong]] = -1;
    assert_int_equal(planish_plan_create(&p.mesh, &options, &plan, &error), PLANISH_ERROR_MESH);
    assert_int_equal(error.element, p.cell_of[wrong]);
    least[p.cell_of[wrong]] = 0;
    options.area_weight = 0.5;
    assert_int_equal(planish_plan_create(&p.mesh, &options, &plan, &error), 0);
    assert_int_equal(planish_smooth(plan, x, &options, NULL, &error), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(error.element, p.cell_of[wrong]);
    planish_plan_destroy(plan);
    free(least);
    free(x);
    release(&p);
    test_mesh_destroy(&box);
}

/** Cells that are elements as they stand are refused with the same words as elements. */
static void wrong_linear_cells_are_refused(void **state) {
    (void)state;
    static const uint8_t TYPE[] = {5, 5};
    static const int64_t OFFSET[] = {0, 3, 6};
    static const int32_t NODE[][6] = {{0, 1, 2, 1, 2, 2}, {0, 1, 2, 1, 2, 9}, {0, 1, 2, 1, 2, -1}};
    static const double X[] = {0, 0, 1, 0, 0, 1, 1, 1};
    for (int i = 0; i < 3; i++) {
        const planish_cells cells = {.n = 2, .type = TYPE, .offset = OFFSET, .node = NODE[i]};
        const planish_mesh elements = {
            .dim = 2, .n_nodes = 4, .n_elements = 2, .coordinates = X, .elements = NODE[i]};
        planish_mesh of_cells = elements;
        planish_error error[2];
        planish_plan *plan;
        memset(error, 0, sizeof error);
        of_cells.elements = NULL;
        of_cells.cells = &cells;
        assert_int_equal(planish_plan_create(&elements, NULL, &plan, &error[0]), -2);
        assert_int_equal(planish_plan_create(&of_cells, NULL, &plan, &error[1]), -2);
        assert_memory_equal(&error[0], &error[1], sizeof error[0]);
        assert_int_equal(error[0].element, 1);
    }
}

/** Facets whose offsets lie, or whose corners are no nodes. */
static void wrong_facets_are_refused(void **state) {
    (void)state;
    static const struct {
        int dim;
        int64_t offset[3];
        int32_t node;
        const char *word;
    } CASES[] = {{3, {0, 3, 8}, 0, "facet 1 "},  {3, {1, 4, 7}, 0, "facet 0 "},
                 {3, {0, 3, 2}, 0, "facet 1 "},  {2, {0, 2, 6}, 0, "facet 1 "},
                 {3, {0, 3, 6}, 99, "node 99"},  {3, {0, 4, 8}, -1, "node -1"},
                 {3, {0, 6, 12}, 99, "node 99"}, {2, {0, 3, 6}, 99, "node 99"}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        test_mesh box = box_of(CASES[i].dim, 2, 0);
        int32_t facets[12] = {0};
        uint8_t constraint[64];
        double direction[192];
        planish_error error;
        const planish_surface surface = {
            .n_facets = 2, .facets = facets, .facet_offset = CASES[i].offset};
        facets[CASES[i].offset[1]] = CASES[i].node;
        assert_int_equal(
            planish_find_slides(&box.mesh, &surface, 1, constraint, direction, NULL, &error),
            PLANISH_ERROR_ARGUMENT);
        if (!strstr(error.text, CASES[i].word))
            fail_msg("%d: %s", (int)i, error.text);
        test_mesh_destroy(&box);
    }
}

/* ---- anything --------------------------------------------------------------------------------- */

enum { MOST_RANDOM = 40, RANDOM_NODES = 24 };

/** A copy of exactly n bytes, so that sanitizers see what is read beyond. */
static void *exactly(const void *bytes, size_t n) {
    void *copy = malloc(n > 0 ? n : 1);
    assert_non_null(copy);
    memcpy(copy, bytes, n);
    return copy;
}

/** Draw elements, most of which are right: of any types, nodes anywhere. */
static planish_cells random_cells(uint64_t *random, int is_damaged) {
    static const int TYPES[][2] = {{1, 1},   {3, 2},   {5, 3},   {9, 4},  {10, 4},  {12, 8},
                                   {13, 6},  {14, 5},  {21, 3},  {22, 6}, {23, 8},  {24, 10},
                                   {25, 20}, {26, 15}, {27, 13}, {28, 9}, {29, 27}, {32, 18},
                                   {10, 4},  {24, 10}, {5, 3},   {22, 6}, {24, 10}, {22, 6}};
    enum { N_TYPES = sizeof TYPES / sizeof *TYPES, SIMPLICES = 18 };
    uint8_t type[MOST_RANDOM];
    int64_t offset[MOST_RANDOM + 1] = {0};
    int32_t node[27 * MOST_RANDOM];
    const int64_t n = random_below(random, MOST_RANDOM + 1);
    for (int64_t i = 0; i < n; i++) {
        const int64_t t = random_below(random, 3) ? SIMPLICES + random_below(random, 6)
                                                  : random_below(random, N_TYPES);
        type[i] = (uint8_t)TYPES[t][0];
        offset[i + 1] = offset[i] + TYPES[t][1];
        const int64_t first = random_below(random, RANDOM_NODES);
        for (int j = 0; j < TYPES[t][1]; j++) /* 5 and 24 have no common divisor: none twice */
            node[offset[i] + j] = (int32_t)((first + 5 * j) % RANDOM_NODES);
        if (TYPES[t][1] == 10 && random_below(random, 4) == 0)
            node[offset[i] + 4 + random_below(random, 6)] = -1;
    }
    if (is_damaged && n > 0) {
        const int64_t i = random_below(random, n), k = random_below(random, 4);
        type[i] = k == 0 ? (uint8_t)random_below(random, 256) : type[i];
        offset[i] += k == 1 ? random_below(random, 5) - 2 : 0;
        node[random_below(random, offset[n])] =
            (int32_t)random_below(random, RANDOM_NODES + 6) - (k == 2 ? 3 : 0);
    }
    const int64_t last = offset[n] > 27 * MOST_RANDOM ? 0 : offset[n];
    return (planish_cells){.n = n,
                           .type = exactly(type, (size_t)n),
                           .offset = exactly(offset, (size_t)(n + 1) * sizeof *offset),
                           .node = exactly(node, (size_t)last * sizeof *node)};
}

/** Whether a call said yes, or what is wrong with the mesh. */
static int is_answer(int status, const planish_error *error) {
    assert_true(status == PLANISH_OK || status == PLANISH_ERROR_MESH ||
                status == PLANISH_ERROR_ARGUMENT);
    assert_true(!status || error->text[0]);
    return status == PLANISH_OK;
}

/** All calls on a mesh, x its coordinates. */
static int call_everything(planish_mesh *mesh, double *x) {
    const size_t n = (size_t)mesh->n_nodes, m = (size_t)mesh->n_elements;
    uint8_t *of_nodes = malloc(n + 1), *of_cells = malloc(m + 1), *slides = malloc(n + 1);
    double *direction = malloc((3 * n + 1) * sizeof *direction);
    double *ratio = malloc((m + 1) * sizeof *ratio);
    int32_t *region = calloc(m + 1, sizeof *region);
    planish_options options = defaults();
    planish_plan *plan = NULL;
    planish_cell_quality quality;
    planish_error error;
    int64_t count;
    for (size_t i = 0; i < m; i++)
        region[i] = (int32_t)(i % 3);
    options.max_sweeps = 2;
    const planish_surface surface = {.region = region};
    is_answer(planish_measure_cells(mesh, 0, 1, &quality, NULL, &error), &error);
    is_answer(planish_find_layers(mesh, 1, of_cells, &count, &error), &error);
    is_answer(planish_find_interfaces(mesh, region, 1, of_nodes, &count, &error), &error);
    if (is_answer(planish_find_slides(mesh, &surface, 1, slides, direction, NULL, &error),
                  &error)) {
        mesh->constraint = slides;
        mesh->direction = direction;
    }
    const int is_made = is_answer(planish_plan_create(mesh, &options, &plan, &error), &error);
    if (is_made) {
        assert_int_equal(planish_plan_get_held(plan, x, of_nodes, &error), 0);
        assert_int_equal(planish_measure_elements(plan, x, ratio, &error), 0);
        double *y = exactly(x, n * (size_t)mesh->dim * sizeof *x);
        assert_int_equal(planish_smooth(plan, y, &options, NULL, &error), 0);
        free(y);
        options.curve_quality = 0; /* mids follow */
        assert_int_equal(planish_smooth(plan, x, &options, NULL, &error), 0);
        assert_int_equal(planish_check_volumes(plan, x, &options, of_cells, &count, NULL, &error),
                         0);
        for (size_t i = 0; i < n; i++) /* what has a reason is where it was */
            for (int d = 0; d < mesh->dim && of_nodes[i]; d++)
                assert_true(x[i * (size_t)mesh->dim + (size_t)d] ==
                            mesh->coordinates[i * (size_t)mesh->dim + (size_t)d]);
    }
    planish_plan_destroy(plan);
    free(of_nodes);
    free(of_cells);
    free(slides);
    free(direction);
    free(ratio);
    free(region);
    return is_made;
}

static void any_cells_are_taken_or_refused(void **state) {
    (void)state;
    uint64_t random = effort_seed(31);
    int64_t n_made = 0, n = effort(600, 60000);
    for (int64_t i = 0; i < n; i++) {
        const int dim = 2 + (int)(i % 2);
        planish_cells cells = random_cells(&random, i % 3 == 0);
        double x[3 * RANDOM_NODES];
        for (int k = 0; k < dim * RANDOM_NODES; k++)
            x[k] = i % 5 == 0 ? (double)random_below(&random, 3) : random_unit(&random);
        double *start = exactly(x, (size_t)(dim * RANDOM_NODES) * sizeof *x);
        planish_mesh mesh = {.dim = dim,
                             .n_nodes = RANDOM_NODES,
                             .n_elements = cells.n,
                             .coordinates = start,
                             .cells = &cells};
        n_made += call_everything(&mesh, x);
        free(start);
        free((void *)cells.type);
        free((void *)cells.offset);
        free((void *)cells.node);
    }
    assert_true(n_made > n / 4 && n_made < n);
    figure("%d random meshes of cells, plans of %d", (int)n, (int)n_made);
}

/* ---- memory ----------------------------------------------------------------------------------- */

static void look_at_shape(const pair *p, faults *f) {
    const size_t n = (size_t)p->mesh.n_nodes, m = (size_t)p->cells.n;
    uint8_t *bytes = malloc(n + m);
    int32_t *region = zeroed((int64_t)m, sizeof *region);
    double *direction = zeroed((int64_t)(3 * n), sizeof *direction);
    planish_cell_array array = {.values = region, .type = PLANISH_NUMBER_INT32};
    const planish_surface surface = {.region = region};
    planish_error error;
    int64_t count;
    region[p->cell_of[0]] = 1;
    while (faults_refused(f, planish_find_layers(&p->mesh, 2, bytes, &count, &error), &error)) {
    }
    faults_add(f, bytes, m);
    while (faults_refused(f, planish_find_regions(&p->mesh, &array, 1, 2, &error), &error)) {
    }
    faults_add(f, &array.is_region, sizeof array.is_region);
    while (faults_refused(f, planish_find_interfaces(&p->mesh, region, 2, bytes, &count, &error),
                          &error)) {
    }
    faults_add(f, bytes, n);
    while (faults_refused(
        f, planish_find_slides(&p->mesh, &surface, 2, bytes, direction, NULL, &error), &error)) {
    }
    faults_add(f, bytes, n);
    free(bytes);
    free(region);
    free(direction);
}

/** A plan, of all or around a node, and what gives values by cells. */
static void use_plan(const pair *p, int is_around, faults *f) {
    const int64_t around[] = {p->plain.n_nodes / 2};
    planish_options options = defaults();
    planish_plan *plan = NULL;
    planish_error error;
    const size_t n = (size_t)p->mesh.n_nodes, m = (size_t)p->cells.n;
    uint8_t *bytes = malloc(n + m);
    double *ratio = malloc(m * sizeof *ratio);
    int64_t count;
    int status;
    options.around = is_around ? around : NULL;
    options.n_around = is_around;
    do {
        status = planish_plan_create(&p->mesh, &options, &plan, &error);
        assert_true(!status || !plan);
    } while (faults_refused(f, status, &error));
    while (faults_refused(f, planish_plan_get_held(plan, p->x, bytes, &error), &error)) {
    }
    faults_add(f, bytes, n);
    while (faults_refused(f, planish_measure_elements(plan, p->x, ratio, &error), &error)) {
    }
    faults_add(f, ratio, m * sizeof *ratio);
    while (faults_refused(f, planish_check_volumes(plan, p->x, NULL, bytes, &count, NULL, &error),
                          &error)) {
    }
    faults_add(f, bytes, m);
    planish_plan_destroy(plan);
    free(bytes);
    free(ratio);
}

static void call_all(const void *context, faults *f) {
    const pair *p = context;
    look_at_shape(p, f);
    use_plan(p, 0, f);
    use_plan(p, 1, f);
}

static void failed_allocations_are_refused(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box = box_of(dim, 4, 0.15);
        pair p = pair_of(&box, ORDER_2 | OTHERS | BY_COMPONENT);
        double *least = zeroed(p.plain.n_elements, sizeof *least);
        fasten(&p);
        let_slide(&p, NULL, NULL);
        add_pairs(&p, 4, INT32_MAX);
        for (int64_t i = 0; i < p.plain.n_elements; i++)
            least[i] = 0.01;
        p.mesh.min_volume = by_cells(&p, least, sizeof *least);
        faults_try("planish_mesh.cells", call_all, &p, 40);
        free((void *)p.mesh.min_volume);
        free(least);
        free((void *)p.mesh.periodic);
        stop_sliding(&p);
        release(&p);
        test_mesh_destroy(&box);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(smoothing_gives_the_same_bits),
        cmocka_unit_test(subsets_give_the_same_bits),
        cmocka_unit_test(min_volumes_go_by_cells),
        cmocka_unit_test(layers_go_by_cells),
        cmocka_unit_test(regions_go_by_cells),
        cmocka_unit_test(straight_edges_let_nodes_slide),
        cmocka_unit_test(periodic_pairs_of_mids_are_passed_over),
        cmocka_unit_test(facets_have_any_number_of_nodes),
        cmocka_unit_test(quadrilaterals_fix_their_corners),
        cmocka_unit_test(cells_hold_nodes),
        cmocka_unit_test(curved_edges_hold_nodes_that_slide),
        cmocka_unit_test(curved_surfaces_are_no_planes),
        cmocka_unit_test(given_constraints_stay),
        cmocka_unit_test(nodes_alone_make_no_simplex),
        cmocka_unit_test(errors_name_cells),
        cmocka_unit_test(wrong_meshes_are_refused),
        cmocka_unit_test(wrong_linear_cells_are_refused),
        cmocka_unit_test(wrong_facets_are_refused),
        cmocka_unit_test(any_cells_are_taken_or_refused),
        cmocka_unit_test(failed_allocations_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
