/* planish_mesh.cells: what is refused, whatever the cells are, and without memory. */
#include "support/cell_pairs.h"
#include "support/effort.h"
#include "support/faults.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

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
    test_mesh box = cell_pair_box(3, 4, 0);
    cell_pair p = cell_pair_of(&box, PAIR_ORDER_2 | PAIR_OTHERS);
    double *least = cell_pair_zeroed(p.cells.n, sizeof *least),
           *x = malloc(3 * (size_t)p.mesh.n_nodes * 8);
    planish_options options = cell_pair_options();
    planish_plan *plan;
    planish_error error;
    cell_pair_fasten(&p);
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
    cell_pair_release(&p);
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
        test_mesh box = cell_pair_box(CASES[i].dim, 2, 0);
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
    planish_options options = cell_pair_options();
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

static void look_at_shape(const cell_pair *p, faults *f) {
    const size_t n = (size_t)p->mesh.n_nodes, m = (size_t)p->cells.n;
    uint8_t *bytes = malloc(n + m);
    int32_t *region = cell_pair_zeroed((int64_t)m, sizeof *region);
    double *direction = cell_pair_zeroed((int64_t)(3 * n), sizeof *direction);
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
static void use_plan(const cell_pair *p, int is_around, faults *f) {
    const int64_t around[] = {p->plain.n_nodes / 2};
    planish_options options = cell_pair_options();
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
    const cell_pair *p = context;
    look_at_shape(p, f);
    use_plan(p, 0, f);
    use_plan(p, 1, f);
}

static void failed_allocations_are_refused(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box = cell_pair_box(dim, 4, 0.15);
        cell_pair p = cell_pair_of(&box, PAIR_ORDER_2 | PAIR_OTHERS | PAIR_BY_COMPONENT);
        double *least = cell_pair_zeroed(p.plain.n_elements, sizeof *least);
        cell_pair_fasten(&p);
        cell_pair_slide(&p, NULL, NULL);
        cell_pair_make_periodic(&p, 4, INT32_MAX);
        for (int64_t i = 0; i < p.plain.n_elements; i++)
            least[i] = 0.01;
        p.mesh.min_volume = cell_pair_by_cells(&p, least, sizeof *least);
        faults_try("planish_mesh.cells", call_all, &p, 40);
        free((void *)p.mesh.min_volume);
        free(least);
        free((void *)p.mesh.periodic);
        cell_pair_stop_sliding(&p);
        cell_pair_release(&p);
        test_mesh_destroy(&box);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_meshes_are_refused),
        cmocka_unit_test(errors_name_cells),
        cmocka_unit_test(wrong_linear_cells_are_refused),
        cmocka_unit_test(wrong_facets_are_refused),
        cmocka_unit_test(any_cells_are_taken_or_refused),
        cmocka_unit_test(failed_allocations_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
