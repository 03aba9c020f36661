/* planish_mesh.cells: every call gives what it gives for the same simplices as elements, by cells. */
#include "support/cell_pairs.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- the same of cells as of elements --------------------------------------------------------- */

/** Whether values of size bytes are those of elements at their cells, and 0 at other cells. */
static void assert_by_cell(const cell_pair *p, const void *plain, const void *by_cell,
                           size_t size) {
    static const char none[16] = {0};
    char *of_cell = cell_pair_zeroed(p->cells.n, size);
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

static void assert_infos_agree(planish_plan *const plan[2]) {
    planish_plan_info a, b;
    planish_plan_get_info(plan[0], &a);
    planish_plan_get_info(plan[1], &b);
    a.threads = b.threads;
    a.binding = b.binding;
    a.bytes = b.bytes;
    assert_memory_equal(&a, &b, sizeof a);
}

static void assert_nodes_agree(const cell_pair *p, planish_plan *const plan[2], int is_around) {
    const int64_t n = p->plain.n_nodes, n_all = p->mesh.n_nodes;
    uint8_t *plain = cell_pair_zeroed(n, 1), *of_cells = cell_pair_zeroed(n_all, 1);
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
static void assert_measures_agree(const cell_pair *p, planish_plan *const plan[2], const double *x,
                                  const planish_options *options) {
    const int64_t m = p->plain.n_elements;
    planish_quality quality[2];
    double *ratio = cell_pair_zeroed(m, sizeof *ratio),
           *ratio_by_cell = cell_pair_by_cells(p, ratio, sizeof *ratio);
    uint8_t *state = cell_pair_zeroed(m, 1), *state_by_cell = cell_pair_by_cells(p, state, 1);
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
static void assert_places_agree(const cell_pair *p, const double *x) {
    for (int64_t i = 0; i < p->mesh.n_nodes; i++)
        for (int d = 0; d < p->mesh.dim; d++) {
            const double at = *cell_pair_place(p, i, d);
            if (i < p->plain.n_nodes)
                assert_memory_equal(&at, &x[i * p->mesh.dim + d], sizeof at);
            else if (p->end[i][0] >= 0)
                assert_true(fabs(at - (x[p->end[i][0] * p->mesh.dim + d] +
                                       x[p->end[i][1] * p->mesh.dim + d]) /
                                          2) < 1e-14 * 10);
        }
}

/** Smooth both; return the nodes of the simplices that have moved. */
static int64_t assert_smoothed_alike(cell_pair *p, const planish_options *options) {
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
                           PAIR_BY_COMPONENT,
                           PAIR_OTHERS,
                           PAIR_ORDER_2,
                           PAIR_ORDER_2 | PAIR_HALF,
                           PAIR_ORDER_2 | PAIR_OTHERS,
                           PAIR_ORDER_2 | PAIR_HALF | PAIR_OTHERS | PAIR_BY_COMPONENT};
enum { N_HOWS = sizeof HOWS / sizeof *HOWS };

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
                planish_options options = cell_pair_options();
                test_mesh box = cell_pair_box(dim, 4, tangled ? 0.6 : 0.15);
                test_mesh_reverse_some(&box, 9, 1);
                cell_pair p = cell_pair_of(&box, HOWS[h]);
                cell_pair_fasten(&p);
                options.worst = PLANISH_WORST_ANGLE;
                assert_true(assert_smoothed_alike(&p, &options) > 0);
                cell_pair_release(&p);
                test_mesh_destroy(&box);
            }
}

static void subsets_give_the_same_bits(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int h = 0; h < N_HOWS; h++)
            for (int which = 0; which < 3; which++) {
                planish_options options = cell_pair_options();
                test_mesh box = cell_pair_box(dim, 5, which == 1 ? 0.3 : 0.15);
                cell_pair p = cell_pair_of(&box, HOWS[h]);
                const int64_t around[] = {middle_of(&box, 5), 3};
                cell_pair_fasten(&p);
                options.only_worse_than = which < 2 ? (dim == 3 ? 2.2 : 1.6) : 0;
                options.around = which < 2 ? NULL : around;
                options.n_around = which < 2 ? 0 : 2;
                options.rings = 1;
                assert_true(assert_smoothed_alike(&p, &options) > 0);
                cell_pair_release(&p);
                test_mesh_destroy(&box);
            }
}

static void min_volumes_go_by_cells(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int h = 0; h < N_HOWS; h++)
            for (int which = 0; which < 3; which++) {
                planish_options options = cell_pair_options();
                test_mesh box = cell_pair_box(dim, 4, 0.15);
                cell_pair p = cell_pair_of(&box, HOWS[h]);
                const int64_t around[] = {middle_of(&box, 4)};
                double *least = cell_pair_zeroed(p.plain.n_elements, sizeof *least);
                for (int64_t i = 0; i < p.plain.n_elements; i++)
                    least[i] = (1 + 0.1 * (double)(i % 7)) * (dim == 3 ? 0.08 : 0.3);
                cell_pair_fasten(&p);
                p.plain.min_volume = least;
                p.mesh.min_volume = cell_pair_by_cells(&p, least, sizeof *least);
                options.only_worse_than = which == 1 ? 3 : 0;
                options.around = which == 2 ? around : NULL;
                options.n_around = which == 2;
                options.area_weight = 0.2;
                assert_smoothed_alike(&p, &options);
                free((void *)p.mesh.min_volume);
                free(least);
                cell_pair_release(&p);
                test_mesh_destroy(&box);
            }
}

static void layers_go_by_cells(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int h = 0; h < N_HOWS; h++) {
            test_mesh box = cell_pair_box(dim, 4, 0);
            for (int64_t i = 0; i < box.mesh.n_nodes; i++)
                box.coordinates[i * dim] *= 0.05;
            cell_pair p = cell_pair_of(&box, HOWS[h]);
            uint8_t *plain = cell_pair_zeroed(p.plain.n_elements, 1),
                    *of_cells = cell_pair_by_cells(&p, plain, 1);
            int64_t n[2];
            cell_pair_fasten(&p);
            assert_int_equal(planish_find_layers(&p.plain, 1, plain, &n[0], NULL), 0);
            assert_int_equal(planish_find_layers(&p.mesh, 2, of_cells, &n[1], NULL), 0);
            assert_by_cell(&p, plain, of_cells, 1);
            assert_true(n[0] == n[1] && n[0] > 0);
            free(plain);
            free(of_cells);
            cell_pair_release(&p);
            test_mesh_destroy(&box);
        }
}

static void regions_go_by_cells(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int h = 0; h < N_HOWS; h++) {
            test_mesh box = cell_pair_box(dim, 4, 0);
            cell_pair p = cell_pair_of(&box, HOWS[h]);
            int32_t *region = cell_pair_zeroed(p.plain.n_elements, sizeof *region);
            double *number = cell_pair_zeroed(p.plain.n_elements, sizeof *number);
            uint8_t *plain = cell_pair_zeroed(p.plain.n_nodes, 1),
                    *of_cells = cell_pair_zeroed(p.mesh.n_nodes, 1);
            int64_t n[2];
            for (int64_t i = 0; i < p.plain.n_elements; i++) {
                region[i] = box.coordinates[box.elements[i * (dim + 1)] * dim] > 2;
                number[i] = (double)i;
            }
            planish_cell_array arrays[] = {
                {.values = cell_pair_by_cells(&p, region, sizeof *region),
                 .type = PLANISH_NUMBER_INT32},
                {.values = cell_pair_by_cells(&p, number, sizeof *number),
                 .type = PLANISH_NUMBER_FLOAT64}};
            cell_pair_fasten(&p);
            assert_int_equal(planish_find_regions(&p.mesh, arrays, 2, 2, NULL), 0);
            assert_true(arrays[0].is_region == 1 && arrays[1].is_region == 0);
            assert_int_equal(planish_find_interfaces(&p.plain, region, 1, plain, &n[0], NULL), 0);
            assert_int_equal(
                planish_find_interfaces(&p.mesh, arrays[0].values, 2, of_cells, &n[1], NULL), 0);
            assert_memory_equal(plain, of_cells, (size_t)p.plain.n_nodes);
            for (int64_t i = p.plain.n_nodes; i < p.mesh.n_nodes; i++)
                n[0] += of_cells[i]; /* mids */
            assert_true(n[0] == n[1] && n[0] > 0);
            free((void *)arrays[0].values);
            free((void *)arrays[1].values);
            free(region);
            free(number);
            free(plain);
            free(of_cells);
            cell_pair_release(&p);
            test_mesh_destroy(&box);
        }
}

static void straight_edges_let_nodes_slide(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int h = 0; h < N_HOWS; h++)
            for (int subset = 0; subset < 2; subset++) {
                planish_options options = cell_pair_options();
                test_mesh box = cell_pair_box(dim, 4, 0.15);
                cell_pair p = cell_pair_of(&box, HOWS[h]);
                cell_pair_fasten(&p);
                cell_pair_slide(&p, NULL, NULL);
                options.only_worse_than = subset ? (dim == 3 ? 2 : 1.5) : 0;
                assert_true(assert_smoothed_alike(&p, &options) > 0);
                cell_pair_stop_sliding(&p);
                cell_pair_release(&p);
                test_mesh_destroy(&box);
            }
}

static void periodic_pairs_of_mids_are_passed_over(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int h = 0; h < N_HOWS; h++)
            for (int one = 0; one < 2; one++) { /* a translation needs two pairs of corners */
                planish_options options = cell_pair_options();
                test_mesh box = cell_pair_box(dim, 4, 0.15);
                cell_pair p = cell_pair_of(&box, HOWS[h]);
                cell_pair_fasten(&p);
                cell_pair_slide(&p, NULL, NULL);
                cell_pair_make_periodic(&p, 4, one ? 1 : INT32_MAX);
                assert_true(p.plain.n_periodic == 1 ? one : p.plain.n_periodic > 4);
                assert_true((p.mesh.n_periodic > p.plain.n_periodic) ==
                            ((HOWS[h] & PAIR_ORDER_2) != 0));
                assert_true(assert_smoothed_alike(&p, &options) > 0);
                free((void *)p.mesh.periodic);
                cell_pair_stop_sliding(&p);
                cell_pair_release(&p);
                test_mesh_destroy(&box);
            }
}

/* ---- facets ----------------------------------------------------------------------------------- */

/** Facets of the side x = 0 with tags by the second coordinate, with mids where is_quadratic. */
static int64_t list_facets(const cell_pair *p, int is_quadratic, int32_t *facets, int64_t *offset,
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
                test_mesh box = cell_pair_box(dim, 4, 0);
                cell_pair p = cell_pair_of(&box, HOWS[h]);
                const int64_t most = p.plain.n_elements;
                int32_t *facets[2] = {cell_pair_zeroed(6 * most, sizeof(int32_t)),
                                      cell_pair_zeroed(6 * most, sizeof(int32_t))};
                int64_t *offset[2] = {cell_pair_zeroed(most, sizeof(int64_t)),
                                      cell_pair_zeroed(most, sizeof(int64_t))};
                int32_t *tag = cell_pair_zeroed(most, sizeof *tag);
                planish_surface surface[2] = {{.facet_tag = tag, .tagged_only = 1},
                                              {.facet_tag = tag, .tagged_only = 1}};
                for (int i = 0; i < 2; i++) {
                    surface[i].n_facets =
                        list_facets(&p, i && is_quadratic, facets[i], offset[i], tag);
                    surface[i].facets = facets[i];
                }
                surface[1].facet_offset = offset[1];
                assert_true(surface[0].n_facets > 3);
                cell_pair_fasten(&p);
                cell_pair_slide(&p, &surface[0], &surface[1]);
                int64_t n_sliding = 0;
                for (int64_t i = 0; i < p.plain.n_nodes; i++)
                    n_sliding += p.constraint[i] >= PLANISH_CONSTRAINT_ON_PLANE;
                assert_true(n_sliding > 0);
                cell_pair_stop_sliding(&p);
                for (int i = 0; i < 2; i++) {
                    free(facets[i]);
                    free(offset[i]);
                }
                free(tag);
                cell_pair_release(&p);
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

/** Two tetrahedra of second order: the nodes between them are three corners and three mids. */
static void mids_are_between_regions(void **state) {
    (void)state;
    static const double x[14][3] = {{0, 0, 0},   {1, 0, 0},   {0, 1, 0},   {0, 0, 1},  {1, 1, 1},
                                    {.5, 0, 0},  {.5, .5, 0}, {0, .5, 0},  {0, 0, .5}, {.5, 0, .5},
                                    {0, .5, .5}, {1, .5, .5}, {.5, 1, .5}, {.5, .5, 1}};
    static const int32_t node[] = {0, 1, 2, 3, 5, 6, 7, 8, 9, 10, 1, 2, 3, 4, 6, 10, 9, 11, 12, 13};
    static const int64_t offset[] = {0, 10, 20};
    static const uint8_t type[] = {PLANISH_CELL_TETRAHEDRON10, PLANISH_CELL_TETRAHEDRON10};
    static const int32_t region[] = {7, -3};
    static const uint8_t wanted[14] = {0, 1, 1, 1, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0};
    const planish_cells cells = {.n = 2, .type = type, .offset = offset, .node = node};
    const planish_mesh mesh = {
        .dim = 3, .n_nodes = 14, .n_elements = 2, .coordinates = x[0], .cells = &cells};
    uint8_t is_between[14];
    int64_t n = 0;
    assert_int_equal(planish_find_interfaces(&mesh, region, 1, is_between, &n, NULL), 0);
    assert_int_equal(n, 6);
    assert_memory_equal(is_between, wanted, sizeof wanted);
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
        cmocka_unit_test(mids_are_between_regions),
        cmocka_unit_test(facets_have_any_number_of_nodes),
        cmocka_unit_test(quadrilaterals_fix_their_corners),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
