/* Plans for a few nodes, from passes or from neighbour to neighbour; and the forms that the
 * caller's arrays may have. */
#include "support/allocations.h"
#include "support/meshes.h"
#include "support/run.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { CELLS = 7 };

static void bad_box(test_mesh *mesh, int dim) {
    test_mesh_box(mesh, dim, CELLS);
    test_mesh_perturb(mesh, 0.14, 12345);
}

/* ---- neighbours ---------------------------------------------------------------------------- */

typedef struct side {
    int32_t node[3]; /* ascending, -1 at the end in 2-D */
    int32_t element, corner;
} side;

static int compare_sides(const void *a, const void *b) {
    return memcmp(((const side *)a)->node, ((const side *)b)->node, sizeof((side){0}).node);
}

static int32_t *neighbours_of(const planish_mesh *mesh) {
    const int corners = mesh->dim + 1;
    const int64_t n = mesh->n_elements * corners;
    side *sides = malloc((size_t)n * sizeof *sides);
    int32_t *neighbours = malloc((size_t)n * sizeof *neighbours);
    for (int64_t i = 0; i < n; i++) {
        const int32_t *node = mesh->elements + i / corners * corners;
        sides[i] = (side){{-1, -1, -1}, (int32_t)(i / corners), (int32_t)(i % corners)};
        for (int j = 0, k = 0; j < corners; j++) {
            if (j == i % corners)
                continue;
            int at = k++;
            for (; at > 0 && sides[i].node[at - 1] > node[j]; at--)
                sides[i].node[at] = sides[i].node[at - 1];
            sides[i].node[at] = node[j];
        }
        neighbours[i] = -1;
    }
    qsort(sides, (size_t)n, sizeof *sides, compare_sides);
    for (int64_t i = 1; i < n; i++) {
        const side *a = &sides[i - 1], *b = &sides[i];
        if (compare_sides(a, b) != 0)
            continue;
        neighbours[a->element * corners + a->corner] = b->element;
        neighbours[b->element * corners + b->corner] = a->element;
    }
    free(sides);
    return neighbours;
}

static int64_t *widened(const int32_t *values, int64_t n) {
    int64_t *wide = malloc((size_t)n * sizeof *wide);
    for (int64_t i = 0; i < n; i++)
        wide[i] = values[i];
    return wide;
}

/* ---- parts of a mesh ------------------------------------------------------------------------ */

static int moved(const planish_mesh *mesh, const test_run *r, int64_t node) {
    const size_t bytes = (size_t)mesh->dim * sizeof(double);
    return memcmp(r->coordinates + node * mesh->dim, mesh->coordinates + node * mesh->dim, bytes) !=
           0;
}

static int is_inside(const planish_mesh *mesh, int64_t node) {
    int inside = 1;
    for (int d = 0; d < mesh->dim; d++) {
        const double x = mesh->coordinates[node * mesh->dim + d];
        inside &= x != 0 && x != CELLS;
    }
    return inside;
}

/** chosen [n]: around, and those of so many rings of elements around. */
static void choose(const planish_mesh *mesh, const int64_t *around, int64_t n, int rings,
                   uint8_t *chosen) {
    const int corners = mesh->dim + 1;
    memset(chosen, 0, (size_t)mesh->n_nodes);
    for (int64_t i = 0; i < n; i++)
        chosen[around[i]] = 1;
    for (int ring = 1; ring <= rings; ring++)
        for (int64_t i = 0; i < mesh->n_elements; i++) {
            const int32_t *node = mesh->elements + i * corners;
            int any = 0;
            for (int j = 0; j < corners; j++)
                any |= chosen[node[j]] > 0 && chosen[node[j]] <= ring;
            for (int j = 0; any && j < corners; j++)
                chosen[node[j]] = chosen[node[j]] ? chosen[node[j]] : (uint8_t)(ring + 1);
        }
}

static int64_t element_of(const planish_mesh *mesh, int64_t node) {
    int64_t i = 0;
    while (mesh->elements[i] != node)
        i++;
    return i / (mesh->dim + 1);
}

/** Three nodes inside, one of them twice, and one of the boundary. */
static const int64_t *some_nodes(const planish_mesh *mesh, int64_t *n) {
    static int64_t around[5];
    int64_t node = 0, k = 0;
    for (*n = 0; *n < 3; node++)
        if (is_inside(mesh, node) && k++ % 5 == 0)
            around[(*n)++] = node;
    around[3] = around[0];
    around[4] = 0;
    *n = 5;
    return around;
}

/** The same bits as with a plan for all of the mesh where the other nodes are fixed. */
static void expect_same_as_fixed(const planish_mesh *mesh, const uint8_t *chosen,
                                 const test_run *r) {
    planish_mesh other = *mesh;
    planish_options options = test_options(2);
    uint8_t *constraint = malloc((size_t)mesh->n_nodes);
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        constraint[i] = chosen[i] ? PLANISH_CONSTRAINT_FREE : PLANISH_CONSTRAINT_FIXED;
    other.constraint = constraint;
    test_run all = test_smooth(&other, &options);
    assert_int_equal(all.info.n_free, r->info.n_free);
    assert_int_equal(all.info.n_fixed_elements,
                     r->info.n_fixed_elements + mesh->n_elements - r->before.n_elements);
    assert_memory_equal(all.coordinates, r->coordinates,
                        (size_t)(mesh->n_nodes * mesh->dim) * sizeof(double));
    free(all.coordinates);
    free(constraint);
}

static void only_nodes_around_move(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int rings = 0; rings < 3; rings++) {
            test_mesh box;
            planish_options options = test_options(2);
            bad_box(&box, dim);
            const planish_mesh *mesh = &box.mesh;
            uint8_t *chosen = malloc((size_t)mesh->n_nodes);
            int64_t n_free = 0, n_moved = 0, n_in = 0;
            options.around = some_nodes(mesh, &options.n_around);
            options.rings = rings;
            choose(mesh, options.around, options.n_around, rings, chosen);
            test_run r = test_smooth(mesh, &options);
            for (int64_t i = 0; i < mesh->n_nodes; i++) {
                n_free += chosen[i] && is_inside(mesh, i);
                n_moved += moved(mesh, &r, i);
                assert_true(!moved(mesh, &r, i) || (chosen[i] && is_inside(mesh, i)));
            }
            for (int64_t i = 0; i < mesh->n_elements; i++) {
                int any = 0;
                for (int j = 0; j <= dim; j++)
                    any |= chosen[mesh->elements[i * (dim + 1) + j]];
                n_in += any != 0;
            }
            assert_int_equal(r.info.n_free, n_free);
            assert_int_equal(r.result.n_moved_nodes, n_moved);
            assert_true(n_moved > 1);
            assert_int_equal(r.before.n_elements, n_in);
            assert_true(r.after.rms_radius_ratio < r.before.rms_radius_ratio);
            assert_true(r.after.max_radius_ratio_movable <= r.before.max_radius_ratio_movable);
            assert_true(fabs(r.result.rms - r.after.rms_radius_ratio) < 1e-12);
            expect_same_as_fixed(mesh, chosen, &r);
            free(r.coordinates);
            free(chosen);
            test_mesh_destroy(&box);
        }
}

/** The same bits from passes over the mesh and from neighbour to neighbour, of either width. */
static void neighbours_save_passes_alone(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int rings = 0; rings < 3; rings++) {
            test_mesh box;
            planish_options options = test_options(2);
            int64_t elements[8];
            bad_box(&box, dim);
            const int64_t corners = box.mesh.n_elements * (dim + 1);
            options.around = some_nodes(&box.mesh, &options.n_around);
            options.rings = rings;
            for (int64_t i = 0; i < options.n_around; i++)
                elements[i] = element_of(&box.mesh, options.around[i]);
            test_run expected = test_smooth(&box.mesh, &options);
            int32_t *neighbours = neighbours_of(&box.mesh);
            int64_t *wide = widened(neighbours, corners);
            int64_t *wide_elements = widened(box.mesh.elements, corners);
            options.around_elements = elements;
            for (int which = 0; which < 3; which++) {
                planish_mesh mesh = box.mesh;
                mesh.neighbours = which == 0 ? neighbours : NULL;
                mesh.neighbours64 = which == 0 ? NULL : wide;
                mesh.elements64 = which == 2 ? wide_elements : NULL;
                mesh.elements = which == 2 ? NULL : mesh.elements;
                test_run r = test_smooth(&mesh, &options);
                assert_memory_equal(r.coordinates, expected.coordinates,
                                    (size_t)(mesh.n_nodes * dim) * sizeof(double));
                assert_int_equal(r.info.n_free, expected.info.n_free);
                assert_int_equal(r.info.n_fixed_elements, expected.info.n_fixed_elements);
                assert_int_equal(r.before.n_elements, expected.before.n_elements);
                free(r.coordinates);
            }
            free(expected.coordinates);
            free(neighbours);
            free(wide);
            free(wide_elements);
            test_mesh_destroy(&box);
        }
}

/** Bad elements that are few are found so, too: a large mesh with one bad node. */
static void neighbours_of_bad_elements(void **state) {
    (void)state;
    enum { MANY = 24 };
    test_mesh box;
    planish_options options = test_options(2);
    test_mesh_box(&box, 3, MANY);
    const int64_t node = (int64_t)(MANY / 2) * ((MANY + 1) * (MANY + 1) + (MANY + 1) + 1);
    box.coordinates[3 * node] += 0.4;
    options.only_worse_than = 1.9;
    options.rings = 0;
    test_run expected = test_smooth(&box.mesh, &options);
    int32_t *neighbours = neighbours_of(&box.mesh);
    planish_mesh mesh = box.mesh;
    mesh.neighbours = neighbours;
    test_run r = test_smooth(&mesh, &options);
    assert_true(expected.info.n_free > 0 && expected.info.n_free < 30);
    assert_true(r.result.n_moved_nodes > 0);
    assert_memory_equal(r.coordinates, expected.coordinates,
                        (size_t)(mesh.n_nodes * 3) * sizeof(double));
    assert_true(memcmp(&r.after, &expected.after, sizeof r.after) == 0);
    assert_true(fabs(r.result.rms - r.after.rms_radius_ratio) < 1e-12);

    /* They were looked at: wrong ones would be found. */
    planish_plan *plan = NULL;
    planish_error error;
    for (int64_t i = 0; i < mesh.n_elements * 4; i++)
        neighbours[i] = 0;
    assert_int_equal(planish_plan_create(&mesh, &options, &plan, &error), PLANISH_ERROR_MESH);
    assert_null(plan);
    assert_non_null(strstr(error.text, "neighbours"));
    free(r.coordinates);
    free(expected.coordinates);
    free(neighbours);
    test_mesh_destroy(&box);
}

/** What results say of all of the mesh is so where nothing is bad, where a node that is worked on
 *  joins two fans, which neighbours do not tell, and at any scale. */
static void results_are_of_all(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int which = 0; which < 4; which++) {
            test_mesh box, other;
            planish_options options = test_options(2);
            test_mesh_box(&box, dim, 16);
            test_mesh_perturb(&box, 0.08, 7);
            test_mesh_box(&other, dim, 1);
            test_mesh_append(&box, &other, 40);
            const int32_t node = box.elements[5 * (dim + 1)];
            if (which == 1) { /* a second fan at a node that has a bad element */
                for (int d = 0; d < dim; d++)
                    box.coordinates[node * dim + d] += 0.02;
                test_mesh_join(&box, node, (int32_t)box.mesh.n_nodes - 1);
            }
            if (which == 3)
                test_mesh_transform(&box, 0x1p-180, 0);
            planish_mesh mesh = box.mesh;
            int32_t *neighbours = neighbours_of(&mesh);
            planish_quality all;
            assert_int_equal(planish_measure_mesh(&mesh, NULL, &all, NULL), 0);
            options.only_worse_than = which == 0 ? 1e6 : all.max_radius_ratio * 0.999;
            test_run r = test_smooth(&mesh, &options);
            mesh.neighbours = neighbours;
            test_run s = test_smooth(&mesh, &options);
            assert_memory_equal(r.coordinates, s.coordinates,
                                (size_t)(mesh.n_nodes * dim) * sizeof(double));
            assert_true(r.info.n_free < 60);
            assert_true(fabs(r.result.objective_before / all.rms_radius_ratio - 1) < 1e-13);
            assert_true(fabs(s.result.objective_before / all.rms_radius_ratio - 1) < 1e-13);
            assert_true(fabs(r.result.rms / r.after.rms_radius_ratio - 1) < 1e-13);
            assert_true(fabs(s.result.rms / s.after.rms_radius_ratio - 1) < 1e-13);
            free(r.coordinates);
            free(s.coordinates);
            free(neighbours);
            test_mesh_destroy(&box);
            test_mesh_destroy(&other);
        }
}

/* ---- forms of arrays ------------------------------------------------------------------------ */

/** Ratios of the elements that the plan knows are those that it measures, by the caller's numbers.
 */
static void check_ratios(const planish_plan *plan, const double *x, int64_t n_elements,
                         const planish_quality *quality) {
    double *ratio = malloc((size_t)n_elements * sizeof *ratio), squares = 0, largest = 0;
    int64_t known = 0, inverted = 0;
    assert_int_equal(planish_measure_elements(plan, x, ratio, NULL), 0);
    for (int64_t i = 0; i < n_elements; i++) {
        if (isnan(ratio[i]))
            continue;
        known++;
        inverted += ratio[i] == 0;
        squares += ratio[i] * ratio[i];
        largest = fmax(largest, ratio[i]);
        assert_true(ratio[i] == 0 || ratio[i] >= 1);
    }
    assert_int_equal(inverted, quality->n_inverted);
    assert_true(fabs(largest / quality->max_radius_ratio - 1) < 1e-14);
    assert_true(ratio[quality->worst_element] == largest);
    const double rms = sqrt(squares / (double)(known - inverted));
    assert_true(fabs(rms / quality->rms_radius_ratio - 1) < 1e-12);
    free(ratio);
}

/** The same bits for padded coordinates, for one array per component, and for elements of 64 bits;
 *  what is between them is not touched. */
static void forms_do_not_matter(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int which = 0; which < 3; which++) {
            test_mesh box;
            planish_options options = test_options(2);
            bad_box(&box, dim);
            planish_mesh mesh = box.mesh;
            const int64_t n = mesh.n_nodes;
            if (which == 1)
                options.only_worse_than = dim == 3 ? 2 : 1.6;
            if (which == 2)
                options.around = some_nodes(&mesh, &options.n_around);
            test_run expected = test_smooth(&mesh, &options);
            int64_t *wide = widened(mesh.elements, mesh.n_elements * (dim + 1));
            for (int form = 0; form < 2; form++) {
                const int64_t step = form ? 1 : 5, apart = form ? n + 3 : 1;
                double *x = malloc((size_t)(5 * (n + 3)) * sizeof *x);
                for (int64_t i = 0; i < 5 * (n + 3); i++)
                    x[i] = -77;
                for (int64_t i = 0; i < n * dim; i++)
                    x[i / dim * step + i % dim * apart] = mesh.coordinates[i];
                planish_mesh other = mesh;
                other.coordinates = x;
                other.elements = NULL;
                other.elements64 = wide;
                other.node_stride = step;
                other.component_stride = form ? apart : 0;
                planish_plan *plan;
                planish_error error;
                planish_quality quality;
                planish_result result;
                uint8_t *state_of = malloc((size_t)mesh.n_elements);
                int64_t n_below, n_unfixable;
                assert_int_equal(planish_plan_create(&other, &options, &plan, &error), 0);
                assert_int_equal(planish_measure(plan, x, &quality, &error), 0);
                assert_memory_equal(&quality, &expected.before, sizeof quality);
                assert_int_equal(planish_smooth(plan, x, &options, &result, &error), 0);
                assert_int_equal(planish_measure(plan, x, &quality, &error), 0);
                assert_memory_equal(&quality, &expected.after, sizeof quality);
                check_ratios(plan, x, mesh.n_elements, &quality);
                assert_int_equal(
                    planish_check_volumes(plan, x, &options, state_of, &n_below, NULL, &error), 0);
                assert_int_equal(
                    planish_find_infeasible(plan, x, NULL, state_of, &n_unfixable, NULL, &error),
                    0);
                assert_int_equal(n_below + n_unfixable, 0);
                int64_t others = 0;
                for (int64_t i = 0; i < n * dim; i++)
                    assert_true(x[i / dim * step + i % dim * apart] == expected.coordinates[i]);
                for (int64_t i = 0; i < 5 * (n + 3); i++)
                    others += x[i] == -77;
                assert_int_equal(others, 5 * (n + 3) - n * dim);
                planish_plan_destroy(plan);
                free(state_of);
                free(x);
            }
            free(wide);
            free(expected.coordinates);
            test_mesh_destroy(&box);
        }
}

/** Minimum volumes, bounds and states are by the caller's numbers, whatever part is worked on. */
static void numbers_are_the_callers(void **state) {
    (void)state;
    for (int which = 0; which < 2; which++) {
        test_mesh box;
        planish_options options = test_options(2);
        bad_box(&box, 3);
        const planish_mesh *mesh = &box.mesh;
        const int64_t n = mesh->n_nodes, m = mesh->n_elements;
        double *lower = malloc((size_t)(3 * n) * sizeof *lower);
        uint8_t *states = malloc((size_t)m), *is_free = malloc((size_t)n);
        if (which == 0)
            options.around = some_nodes(mesh, &options.n_around);
        else
            options.only_worse_than = 2;
        options.rings = 1;
        for (int64_t i = 0; i < 3 * n; i++)
            lower[i] = i % 3 == 1 ? mesh->coordinates[i] : -INFINITY;
        options.lower = lower;
        test_run r = test_smooth(mesh, &options);
        int64_t n_moved = 0, n_free = 0, n_below, n_found = 0;
        for (int64_t i = 0; i < n; i++) {
            n_moved += moved(mesh, &r, i);
            assert_true(r.coordinates[3 * i + 1] >= mesh->coordinates[3 * i + 1]);
        }
        assert_true(n_moved > 0);

        planish_plan *plan;
        planish_error error;
        options.min_volume = 0.1;
        options.around = which == 0 ? options.around : NULL;
        assert_int_equal(planish_plan_create(mesh, &options, &plan, &error), 0);
        planish_plan_get_free(plan, is_free);
        for (int64_t i = 0; i < n; i++) {
            n_free += is_free[i];
            assert_true(is_free[i] == 0 || is_inside(mesh, i));
        }
        planish_plan_info info;
        planish_plan_get_info(plan, &info);
        assert_int_equal(n_free, info.n_free);
        assert_int_equal(planish_check_volumes(plan, mesh->coordinates, &options, states, &n_below,
                                               NULL, &error),
                         0);
        for (int64_t i = 0; i < m; i++) {
            const int32_t *v = mesh->elements + 4 * i;
            const double *x = mesh->coordinates;
            double e[3][3];
            int any = 0;
            for (int j = 0; j < 3; j++)
                for (int d = 0; d < 3; d++)
                    e[j][d] = x[3 * v[j + 1] + d] - x[3 * v[0] + d];
            for (int j = 0; j < 4; j++)
                any |= is_free[v[j]];
            const double volume = fabs(e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
                                       e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
                                       e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) /
                                  6;
            const int below = volume < 0.997 * 0.1;
            if (any)
                assert_int_equal(states[i] != PLANISH_VOLUME_MET, below);
            else if (which == 1)
                assert_int_equal(states[i], below ? PLANISH_VOLUME_INFEASIBLE : PLANISH_VOLUME_MET);
            n_found += states[i] != PLANISH_VOLUME_MET;
        }
        assert_int_equal(n_found, n_below);
        assert_true(n_below > 0);
        planish_plan_destroy(plan);
        free(lower);
        free(states);
        free(is_free);
        free(r.coordinates);
        test_mesh_destroy(&box);
    }
}

/** What is outside of the part and below its minimum volume stays so, and smoothing says it. */
static void what_is_outside_is_infeasible(void **state) {
    (void)state;
    test_mesh box;
    planish_plan *plan;
    planish_result result;
    planish_options options = test_options(2);
    test_mesh_box(&box, 3, 5);
    options.only_worse_than = 50;
    assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
    options.min_volume = 1;
    assert_int_equal(planish_smooth(plan, box.coordinates, &options, &result, NULL), 0);
    assert_int_equal(result.n_below_min_volume, box.mesh.n_elements);
    assert_int_equal(result.stop, PLANISH_STOP_INFEASIBLE);
    planish_plan_destroy(plan);
    test_mesh_destroy(&box);
}

/* ---- wrong arguments ------------------------------------------------------------------------ */

static void expect_refusal(const planish_mesh *mesh, const planish_options *options, int code,
                           const char *text) {
    planish_plan *plan = NULL;
    planish_error error = {.text = ""};
    assert_int_equal(planish_plan_create(mesh, options, &plan, &error), code);
    assert_null(plan);
    if (!strstr(error.text, text))
        fail_msg("no '%s' in: %s", text, error.text);
}

static void wrong_arguments_are_named(void **state) {
    (void)state;
    test_mesh box;
    bad_box(&box, 3);
    const int64_t corners = box.mesh.n_elements * 4;
    int32_t *neighbours = neighbours_of(&box.mesh);
    int64_t *wide = widened(box.mesh.elements, corners);
    int64_t n, elements[8];
    const int64_t *nodes = some_nodes(&box.mesh, &n);
    for (int64_t i = 0; i < n; i++)
        elements[i] = element_of(&box.mesh, nodes[i]);
    planish_options around = test_options(2), options;
    around.around = nodes;
    around.n_around = n;
    planish_mesh walk = box.mesh, mesh;
    walk.neighbours = neighbours;

    options = around;
    options.n_around = 0;
    expect_refusal(&walk, &options, PLANISH_ERROR_ARGUMENT, "n_around is 0");
    options.around = NULL;
    options.n_around = 2;
    expect_refusal(&walk, &options, PLANISH_ERROR_ARGUMENT, "options.around is NULL");
    options = around;
    options.only_worse_than = 2;
    expect_refusal(&walk, &options, PLANISH_ERROR_ARGUMENT, "only_worse_than");
    options = around;
    options.min_volume_fraction = 1e-9;
    expect_refusal(&walk, &options, PLANISH_ERROR_ARGUMENT, "min_volume_fraction");
    const int64_t outside[] = {3, box.mesh.n_nodes}, negative[] = {-1, INT64_MIN};
    options = around;
    options.n_around = 2;
    options.around = outside;
    expect_refusal(&walk, &options, PLANISH_ERROR_ARGUMENT, "around[1]");
    options.around = negative;
    expect_refusal(&walk, &options, PLANISH_ERROR_ARGUMENT, "around[0]");

    options = around;
    options.around_elements = elements;
    for (int which = 0; which < 3; which++) {
        const int64_t was = elements[1];
        elements[1] = which == 0 ? -1 : which == 1 ? box.mesh.n_elements : elements[0];
        expect_refusal(&walk, &options, PLANISH_ERROR_ARGUMENT, "around_elements");
        elements[1] = was;
    }
    const int64_t at = 4 * elements[0] + (box.mesh.elements[4 * elements[0]] == nodes[0]);
    for (int which = 0; which < 4; which++) {
        const int32_t was = neighbours[at];
        neighbours[at] = which == 0   ? -2
                         : which == 1 ? INT32_MAX
                         : which == 2 ? (int32_t)elements[0]
                                      : (int32_t)(box.mesh.n_elements - 1);
        expect_refusal(&walk, &options, PLANISH_ERROR_MESH, "neighbours");
        neighbours[at] = was;
    }
    mesh = walk;
    mesh.elements = NULL;
    mesh.elements64 = wide;
    for (int which = 0; which < 2; which++) {
        const int64_t k = 4 * elements[0] + (wide[4 * elements[0]] == nodes[0]), was = wide[k];
        wide[k] = which ? INT64_C(1) << 40 : -3;
        expect_refusal(&mesh, &options, PLANISH_ERROR_MESH, which ? "1099511627776" : "-3");
        planish_options of_all = test_options(2);
        expect_refusal(&mesh, &of_all, PLANISH_ERROR_MESH, which ? "1099511627776" : "-3");
        wide[k] = was;
    }

    options = test_options(2);
    mesh = box.mesh;
    mesh.elements64 = wide;
    expect_refusal(&mesh, &options, PLANISH_ERROR_ARGUMENT, "both set");
    mesh = box.mesh;
    mesh.node_stride = 2;
    expect_refusal(&mesh, &options, PLANISH_ERROR_ARGUMENT, "node_stride is 2");
    mesh.node_stride = -3;
    expect_refusal(&mesh, &options, PLANISH_ERROR_ARGUMENT, "overlap");
    mesh.node_stride = 1;
    mesh.component_stride = mesh.n_nodes - 1;
    expect_refusal(&mesh, &options, PLANISH_ERROR_ARGUMENT, "overlap");
    mesh.node_stride = INT64_MAX;
    mesh.component_stride = INT64_MAX;
    expect_refusal(&mesh, &options, PLANISH_ERROR_ARGUMENT, "overlap");

    /* The rest of the mesh is not looked at. */
    planish_plan *plan;
    planish_error error;
    options = around;
    options.n_around = 1;
    options.around_elements = elements;
    double *far = &box.coordinates[3 * box.mesh.n_nodes - 3], was = *far;
    *far = NAN;
    assert_int_equal(planish_plan_create(&walk, &options, &plan, &error), 0);
    assert_int_equal(planish_smooth(plan, box.coordinates, NULL, NULL, &error), 0);
    box.coordinates[3 * nodes[0] + 1] = NAN;
    assert_int_equal(planish_smooth(plan, box.coordinates, NULL, NULL, &error), PLANISH_ERROR_MESH);
    assert_int_equal(error.node, nodes[0]);
    planish_plan_destroy(plan);
    expect_refusal(&walk, &options, PLANISH_ERROR_MESH, "y = nan");
    *far = was;
    free(neighbours);
    free(wide);
    test_mesh_destroy(&box);
}

/** What is looked at from neighbour to neighbour is not worth more than one thread. */
static void a_few_nodes_are_for_one_thread(void **state) {
    (void)state;
    enum { NODES = 2 };
    test_mesh box;
    planish_options options = test_options(2);
    int64_t nodes[NODES], elements[NODES];
    test_mesh_box(&box, 3, 12);
    for (int i = 0; i < NODES; i++) {
        nodes[i] = 6 * 13 * 13 + 6 * 13 + 5 + i;
        elements[i] = element_of(&box.mesh, nodes[i]);
    }
    int32_t *neighbours = neighbours_of(&box.mesh);
    box.mesh.neighbours = neighbours;
    options.threads = 0;
    options.around = nodes;
    options.around_elements = elements;
    for (options.n_around = 1; options.n_around <= NODES; options.n_around++) {
        planish_plan *plan;
        planish_plan_info info;
        assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
        planish_plan_get_info(plan, &info);
        assert_int_equal(info.threads, 1);
        planish_plan_destroy(plan);
    }
    free(neighbours);
    test_mesh_destroy(&box);
}

static void memory_may_run_out(void **state) {
    (void)state;
    test_mesh box;
    bad_box(&box, 3);
    int32_t *neighbours = neighbours_of(&box.mesh);
    int64_t *wide = widened(box.mesh.elements, box.mesh.n_elements * 4);
    planish_mesh mesh = box.mesh;
    planish_options options = test_options(2);
    int64_t elements[8];
    mesh.neighbours = neighbours;
    options.around = some_nodes(&mesh, &options.n_around);
    options.rings = 4;
    for (int64_t i = 0; i < options.n_around; i++)
        elements[i] = element_of(&mesh, options.around[i]);
    for (int which = 0; which < 3; which++) {
        int failures = 0, status = PLANISH_ERROR_MEMORY;
        options.around_elements = which ? NULL : elements;
        options = which == 2 ? test_options(2) : options;
        mesh.elements = which ? NULL : box.mesh.elements;
        mesh.elements64 = which ? wide : NULL;
        mesh.node_stride = which == 2 ? 1 : 0;
        mesh.component_stride = which == 2 ? mesh.n_nodes : 0;
        for (; status == PLANISH_ERROR_MEMORY; failures++) {
            planish_plan *plan = NULL;
            allocations_permit(failures);
            status = planish_plan_create(&mesh, &options, &plan, NULL);
            allocations_permit(-1);
            planish_plan_destroy(plan);
        }
        assert_int_equal(status, 0);
        assert_true(failures > 20);
    }
    free(neighbours);
    free(wide);
    test_mesh_destroy(&box);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_nodes_around_move),
        cmocka_unit_test(neighbours_save_passes_alone),
        cmocka_unit_test(neighbours_of_bad_elements),
        cmocka_unit_test(results_are_of_all),
        cmocka_unit_test(forms_do_not_matter),
        cmocka_unit_test(numbers_are_the_callers),
        cmocka_unit_test(what_is_outside_is_infeasible),
        cmocka_unit_test(wrong_arguments_are_named),
        cmocka_unit_test(a_few_nodes_are_for_one_thread),
        cmocka_unit_test(memory_may_run_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
