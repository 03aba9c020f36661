/* Arguments of the public functions: those that are missing or wrong are refused, defaults are as
 * documented. */
#include "support/meshes.h"
#include "support/run.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/** Without what it needs every function says so. */
static void nothing_is_an_argument(void **state) {
    (void)state;
    test_mesh box;
    planish_plan *plan, *none = NULL;
    planish_plan_info info;
    int32_t edge = 0;
    planish_quality quality;
    int64_t n;
    test_bad_box(&box, 2, 4, 1);
    double *x = box.coordinates;
    assert_int_equal(planish_plan_create(&box.mesh, NULL, &plan, NULL), 0);
    const int refusals[] = {planish_plan_create(NULL, NULL, &none, NULL),
                            planish_plan_create(&box.mesh, NULL, NULL, NULL),
                            planish_smooth(NULL, x, NULL, NULL, NULL),
                            planish_smooth(plan, NULL, NULL, NULL, NULL),
                            planish_measure(NULL, x, &quality, NULL),
                            planish_measure(plan, NULL, &quality, NULL),
                            planish_measure(plan, x, NULL, NULL),
                            planish_measure_mesh(NULL, NULL, &quality, NULL),
                            planish_measure_mesh(&box.mesh, NULL, NULL, NULL),
                            planish_check_volumes(NULL, x, NULL, NULL, &n, NULL, NULL),
                            planish_check_volumes(plan, x, NULL, NULL, NULL, NULL, NULL),
                            planish_find_infeasible(NULL, x, NULL, NULL, &n, NULL, NULL),
                            planish_find_infeasible(plan, NULL, NULL, NULL, &n, NULL, NULL),
                            planish_find_held(NULL, x, NULL, (uint8_t *)x, NULL),
                            planish_find_held(plan, x, NULL, NULL, NULL),
                            planish_find_held_on_surface(NULL, NULL, (uint8_t *)x, NULL),
                            planish_find_held_on_surface(&box.mesh, NULL, (uint8_t *)x, NULL),
                            planish_find_slides(NULL, NULL, 1, NULL, NULL, NULL, NULL),
                            planish_find_slides(&box.mesh, NULL, 1, NULL, x, NULL, NULL)};
    for (size_t i = 0; i < sizeof refusals / sizeof refusals[0]; i++)
        assert_int_equal(refusals[i], PLANISH_ERROR_ARGUMENT);
    planish_plan_get_info(NULL, &info);
    assert_int_equal(info.n_free, 0);
    planish_plan_get_info(plan, NULL);
    planish_plan_get_free(plan, NULL);
    planish_plan_get_free(NULL, (uint8_t *)x);
    planish_shape_get_classes(NULL, (uint8_t *)x);
    planish_shape_get_edges(NULL, &edge);
    planish_options_init_sized(NULL, sizeof(planish_options));
    planish_plan_destroy(NULL);
    planish_plan_destroy(plan);
    test_mesh_destroy(&box);
}

/** Calls that refuse wrong options; flags. */
enum { BY_PLAN = 1, BY_SMOOTH = 2 };

/** What is wrong, the calls that refuse it, and a word of the message. */
typedef struct wrong {
    const char *word;
    int refused;
    void (*spoil)(planish_options *options);
} wrong;

static void *allocate(size_t bytes, void *user) {
    (void)user;
    return malloc(bytes);
}

static const planish_allocator HALF = {allocate, NULL, NULL};

#define SPOIL(name, statement)                                                                     \
    static void name(planish_options *options) {                                                   \
        options->statement;                                                                        \
    }
SPOIL(method_large, method = (planish_method)4)
SPOIL(method_small, method = (planish_method)-1)
SPOIL(objective_large, objective = (planish_objective)3)
SPOIL(objective_small, objective = (planish_objective)-1)
SPOIL(search_large, search = (planish_search)2)
SPOIL(precision_large, precision = (planish_precision)3)
SPOIL(precision_without_round, precision = PLANISH_PRECISION_ROUNDED)
SPOIL(unit_large, displacement_unit = (planish_length_unit)2)
SPOIL(volume_negative, min_volume = -1)
SPOIL(volume_nan, min_volume = NAN)
SPOIL(volume_infinite, min_volume = INFINITY)
SPOIL(fraction_negative, min_volume_fraction = -0.1)
SPOIL(fraction_nan, min_volume_fraction = NAN)
SPOIL(fraction_one, min_volume_fraction = 1)
SPOIL(weight_negative, area_weight = -0.1)
SPOIL(weight_large, area_weight = 1.1)
SPOIL(weight_nan, area_weight = NAN)
SPOIL(weight_without_volume, area_weight = 0.5)
SPOIL(box_nan, box_lower[1] = NAN)
SPOIL(box_empty, box_upper[0] = -INFINITY; options->box_lower[0] = 0)
SPOIL(distance_negative, max_displacement = -1)
SPOIL(distance_nan, max_displacement = NAN)
SPOIL(distance_infinite, max_displacement = INFINITY)
SPOIL(both_volumes, min_volume = 0.1; options->min_volume_fraction = 0.1)
SPOIL(size_wrong, struct_size -= 1)
SPOIL(size_small, struct_size = 3)
SPOIL(sweeps_negative, max_sweeps = -1)
SPOIL(tolerance_nan, tolerance = NAN)
SPOIL(time_negative, time_limit = -1)
SPOIL(worse_than_nan, only_worse_than = NAN)
SPOIL(isa_unknown, isa = (planish_isa)77)
SPOIL(threads_negative, threads = -1)
SPOIL(threads_many, threads = 1025)
SPOIL(allocator_half, allocator = &HALF)

static void expect_refusal(int status, const planish_error *error, const char *word) {
    assert_int_equal(status, PLANISH_ERROR_ARGUMENT);
    assert_int_equal(error->code, PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error->text, word));
}

static void wrong_options_are_refused(void **state) {
    int dim = *(int *)*state;
    static const wrong all[] = {
        {"method", BY_SMOOTH, method_large},
        {"method", BY_SMOOTH, method_small},
        {"objective", BY_SMOOTH, objective_large},
        {"objective", BY_SMOOTH, objective_small},
        {"search", BY_SMOOTH, search_large},
        {"precision", BY_SMOOTH, precision_large},
        {"round", BY_SMOOTH, precision_without_round},
        {"unit", BY_SMOOTH, unit_large},
        {"min_volume", BY_SMOOTH, volume_negative},
        {"min_volume", BY_SMOOTH, volume_nan},
        {"min_volume", BY_SMOOTH, volume_infinite},
        {"fraction", BY_SMOOTH, fraction_negative},
        {"fraction", BY_SMOOTH, fraction_nan},
        {"fraction", BY_SMOOTH, fraction_one},
        {"area_weight", BY_SMOOTH, weight_negative},
        {"area_weight", BY_SMOOTH, weight_large},
        {"area_weight", BY_SMOOTH, weight_nan},
        {"minimum volume", BY_SMOOTH, weight_without_volume},
        {"box_lower", BY_SMOOTH, box_nan},
        {"box", BY_SMOOTH, box_empty},
        {"max_displacement", BY_SMOOTH, distance_negative},
        {"max_displacement", BY_SMOOTH, distance_nan},
        {"max_displacement", BY_SMOOTH, distance_infinite},
        {"both", BY_SMOOTH, both_volumes},
        {"struct_size", BY_SMOOTH, size_wrong},
        {"struct_size", BY_SMOOTH, size_small},
        {"max_sweeps", BY_SMOOTH, sweeps_negative},
        {"tolerance", BY_SMOOTH, tolerance_nan},
        {"time_limit", BY_SMOOTH, time_negative},
        {"only_worse_than", BY_SMOOTH, worse_than_nan},
        {"isa", BY_PLAN, isa_unknown},
        {"threads", BY_PLAN, threads_negative},
        {"threads", BY_PLAN, threads_many},
        {"allocator", BY_PLAN, allocator_half},
    };
    test_mesh mesh;
    planish_plan *plan;
    test_bad_box(&mesh, dim, 3, 1);
    double *copy = malloc(test_bytes_of(&mesh.mesh));
    memcpy(copy, mesh.coordinates, test_bytes_of(&mesh.mesh));
    assert_int_equal(planish_plan_create(&mesh.mesh, NULL, &plan, NULL), 0);
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        planish_options options = test_options(1);
        planish_error error = {.text = ""};
        all[i].spoil(&options);
        if (all[i].refused & BY_PLAN) {
            planish_plan *none = plan; /* what fails leaves no plan */
            expect_refusal(planish_plan_create(&mesh.mesh, &options, &none, &error), &error,
                           all[i].word);
            assert_null(none);
        }
        if (all[i].refused & BY_SMOOTH)
            expect_refusal(planish_smooth(plan, copy, &options, NULL, &error), &error, all[i].word);
        assert_memory_equal(copy, mesh.coordinates, test_bytes_of(&mesh.mesh));
    }
    planish_plan_destroy(plan);
    free(copy);
    test_mesh_destroy(&mesh);
}

/** Minimum volumes of elements are finite, 0 or more. */
static void negative_volumes_are_refused(void **state) {
    static const double refused[] = {-1, NAN, INFINITY};
    test_mesh box;
    planish_plan *plan;
    (void)state;
    test_mesh_box(&box, 2, 2);
    for (int i = 0; i < 3; i++) {
        double volume[8] = {0, 0, 0, refused[i]};
        planish_error error;
        box.mesh.min_volume = volume;
        assert_int_equal(planish_plan_create(&box.mesh, NULL, &plan, &error), PLANISH_ERROR_MESH);
        assert_int_equal(error.element, 3);
        assert_non_null(strstr(error.text, "give a finite number, 0 or more"));
    }
    test_mesh_destroy(&box);
}

/* ---- reserved fields ------------------------------------------------------------------------- */

/** Set the last reserved field of a structure. */
#define SPOIL_RESERVED(s) memset((unsigned char *)(s)->reserved + sizeof(s)->reserved - 1, 1, 1)

/** A mesh, and room for what calls find in it. */
typedef struct finding {
    test_mesh box;
    planish_cells cells; /* the same elements */
    uint8_t *type, *flag;
    int64_t *offset;
    double *direction;
    int32_t *region;
} finding;

static void finding_create(finding *f) {
    *f = (finding){.type = NULL};
    test_mesh_box(&f->box, 3, 2);
    const int64_t n = f->box.mesh.n_elements, n_nodes = f->box.mesh.n_nodes;
    f->type = malloc((size_t)n);
    f->offset = malloc((size_t)(n + 1) * sizeof *f->offset);
    f->region = calloc((size_t)n, sizeof *f->region);
    f->flag = malloc((size_t)(n + n_nodes));
    f->direction = malloc((size_t)n_nodes * 3 * sizeof *f->direction);
    memset(f->type, PLANISH_CELL_TETRAHEDRON, (size_t)n);
    for (int64_t i = 0; i <= n; i++)
        f->offset[i] = 4 * i;
    f->cells =
        (planish_cells){.n = n, .type = f->type, .offset = f->offset, .node = f->box.mesh.elements};
}

static void finding_destroy(finding *f) {
    test_mesh_destroy(&f->box);
    free(f->type);
    free(f->offset);
    free(f->region);
    free(f->flag);
    free(f->direction);
}

static void refuse_mesh(const finding *f) {
    planish_mesh mesh = f->box.mesh;
    planish_plan *plan;
    planish_quality quality;
    planish_shape *shape;
    planish_error error;
    const char *word = "planish_mesh.reserved";
    SPOIL_RESERVED(&mesh);
    expect_refusal(planish_plan_create(&mesh, NULL, &plan, &error), &error, word);
    expect_refusal(planish_measure_mesh(&mesh, NULL, &quality, &error), &error, word);
    expect_refusal(planish_find_layers(&mesh, 1, f->flag, NULL, &error), &error, word);
    expect_refusal(planish_shape_create(&mesh, NULL, 1, &shape, NULL, &error), &error, word);
}

static void refuse_parts_of_mesh(const finding *f) {
    planish_mesh mesh = f->box.mesh;
    planish_cells cells = f->cells;
    planish_part part = {.user = NULL};
    planish_plan *plan;
    planish_error error;
    SPOIL_RESERVED(&part);
    mesh.part = &part;
    expect_refusal(planish_plan_create(&mesh, NULL, &plan, &error), &error, "planish_part");
    mesh = f->box.mesh;
    mesh.elements = NULL;
    mesh.cells = &cells;
    assert_int_equal(planish_plan_create(&mesh, NULL, &plan, NULL), 0);
    planish_plan_destroy(plan);
    SPOIL_RESERVED(&cells);
    expect_refusal(planish_plan_create(&mesh, NULL, &plan, &error), &error, "planish_cells");
}

static void refuse_values(const finding *f) {
    const planish_mesh *mesh = &f->box.mesh;
    planish_cell_values values = {.state = f->flag};
    planish_cell_array array = {.values = f->region};
    planish_cell_quality quality;
    planish_error error;
    SPOIL_RESERVED(&values);
    SPOIL_RESERVED(&array);
    expect_refusal(planish_measure_cells(mesh, 0, 1, &quality, &values, &error), &error,
                   "planish_cell_values");
    expect_refusal(planish_find_regions(mesh, &array, 1, 1, &error), &error, "planish_cell_array");
    expect_refusal(planish_combine_regions(mesh->n_elements, &array, 1, f->region, NULL, &error),
                   &error, "planish_cell_array");
}

/** What is not 0 in a reserved field is refused: a later version may give it a meaning. */
static void reserved_fields_are_refused(void **state) {
    (void)state;
    finding f;
    planish_surface surface = {.n_facets = 0};
    planish_options options = test_options(1);
    planish_plan *plan;
    planish_shape *shape;
    planish_error error;
    finding_create(&f);
    const planish_mesh *mesh = &f.box.mesh;
    SPOIL_RESERVED(&surface);
    SPOIL_RESERVED(&options);
    refuse_mesh(&f);
    refuse_parts_of_mesh(&f);
    refuse_values(&f);
    expect_refusal(planish_find_slides(mesh, &surface, 1, f.flag, f.direction, NULL, &error),
                   &error, "planish_surface");
    expect_refusal(planish_shape_create(mesh, &surface, 1, &shape, NULL, &error), &error,
                   "planish_surface");
    expect_refusal(planish_plan_create(mesh, &options, &plan, &error), &error, "planish_options");
    assert_int_equal(planish_plan_create(mesh, NULL, &plan, NULL), 0);
    expect_refusal(planish_smooth(plan, f.box.coordinates, &options, NULL, &error), &error,
                   "planish_options");
    planish_plan_destroy(plan);
    finding_destroy(&f);
}

/* ---- all of them ----------------------------------------------------------------------------- */

/** A coordinate that is no number is named by its node. */
static void coordinates_are_numbers(void **state) {
    const int dim = *(int *)*state;
    test_mesh mesh;
    planish_plan *plan;
    planish_error error;
    test_bad_box(&mesh, dim, 3, 1);
    assert_int_equal(planish_plan_create(&mesh.mesh, NULL, &plan, NULL), 0);
    mesh.coordinates[7] = NAN;
    assert_int_equal(planish_smooth(plan, mesh.coordinates, NULL, NULL, &error),
                     PLANISH_ERROR_MESH);
    assert_int_equal(error.node, 7 / dim);
    planish_plan_destroy(plan);
    test_mesh_destroy(&mesh);
}

/** What planish.h says of planish_options_init. */
static void defaults_are_as_documented(void **state) {
    (void)state;
    planish_options o;
    planish_options_init(&o);
    assert_int_equal(o.struct_size, sizeof o);
    assert_true(o.threads == 0 && o.bind == 0 && o.isa == PLANISH_ISA_AUTO);
    assert_true(o.method == PLANISH_METHOD_PLANISH &&
                o.objective == PLANISH_OBJECTIVE_RADIUS_RATIO && o.search == PLANISH_SEARCH_NEWTON);
    assert_true(o.min_volume == 0 && o.min_volume_fraction == 0 && o.area_weight == 0);
    assert_true(!o.lower && !o.upper && o.max_displacement == 0);
    for (int d = 0; d < 3; d++)
        assert_true(o.box_lower[d] == -INFINITY && o.box_upper[d] == INFINITY);
    assert_true(o.precision == PLANISH_PRECISION_DOUBLE && o.untangle);
    assert_true(o.worst == PLANISH_WORST_NONE && o.worst_rise == 0.01);
    assert_true(o.max_sweeps == 200 && o.tolerance == 1e-5 && o.time_limit == 0);
    assert_true(o.only_worse_than == 0 && o.rings == 0 && o.n_around == 0 && !o.around);
    assert_true(!o.progress && !o.project && !o.allocator && !o.parallel && !o.log && !o.round);
}

/** A program whose header has fewer fields is not overrun, and its options are refused. */
static void smaller_options_are_not_overrun(void **state) {
    (void)state;
    enum { GUARD = 0x5a };
    planish_options o;
    test_mesh box;
    planish_plan *plan = NULL;
    test_mesh_box(&box, 2, 3);
    for (size_t size = 0; size <= sizeof o; size += 4) {
        planish_error error = {0};
        unsigned char bytes[sizeof o];
        memset(bytes, GUARD, sizeof bytes);
        memcpy(&o, bytes, sizeof o);
        planish_options_init_sized(&o, size);
        memcpy(bytes, &o, sizeof o);
        for (size_t i = size; i < sizeof o; i++)
            assert_int_equal(bytes[i], GUARD);
        if (size < sizeof o.struct_size)
            continue;
        assert_int_equal(o.struct_size, size);
        const int status = planish_plan_create(&box.mesh, &o, &plan, &error);
        assert_int_equal(status, size == sizeof o ? PLANISH_OK : PLANISH_ERROR_ARGUMENT);
        assert_true(!status || strstr(error.text, "planish_options_init"));
    }
    planish_plan_destroy(plan);
    test_mesh_destroy(&box);
}

int main(void) {
    static int dims[] = {2, 3};
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_is_an_argument),
        cmocka_unit_test_prestate(wrong_options_are_refused, &dims[0]),
        cmocka_unit_test_prestate(wrong_options_are_refused, &dims[1]),
        cmocka_unit_test_prestate(coordinates_are_numbers, &dims[0]),
        cmocka_unit_test_prestate(coordinates_are_numbers, &dims[1]),
        cmocka_unit_test(defaults_are_as_documented),
        cmocka_unit_test(smaller_options_are_not_overrun),
        cmocka_unit_test(negative_volumes_are_refused),
        cmocka_unit_test(reserved_fields_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
