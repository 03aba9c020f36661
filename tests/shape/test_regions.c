/* planish_find_regions, planish_combine_regions, planish_find_interfaces: which arrays of values
 * per element tell regions, what they make together, and the nodes between. */
#include "support/allocations.h"
#include "support/cell_meshes.h"
#include "support/meshes.h"

#include <limits.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { CELLS = 6, MOST = 6 * CELLS * CELLS * CELLS };

/** Value of an element, by a rule. */
typedef int64_t value_fn(const test_mesh *box, int64_t element);

/** Which cell of the box an element is in, in direction d. */
static int cell_of(const test_mesh *box, int64_t element, int d) {
    const int dim = box->mesh.dim;
    double lowest = CELLS;
    for (int j = 0; j <= dim; j++)
        lowest = fmin(lowest, box->coordinates[box->elements[element * (dim + 1) + j] * dim + d]);
    return (int)lowest;
}

static int64_t halves(const test_mesh *box, int64_t element) {
    return cell_of(box, element, 0) < CELLS / 2 ? 7 : -3;
}

static int64_t quarters(const test_mesh *box, int64_t element) {
    return cell_of(box, element, 1) < CELLS / 2;
}

static int64_t number(const test_mesh *box, int64_t element) {
    (void)box;
    return element + 1;
}

/** Two values that differ at all facets within a cell. */
static int64_t parity(const test_mesh *box, int64_t element) {
    (void)box;
    return element % 2;
}

static int64_t same(const test_mesh *box, int64_t element) {
    (void)box;
    (void)element;
    return 5;
}

static int64_t huge(const test_mesh *box, int64_t element) {
    return halves(box, element) > 0 ? INT64_MAX : INT64_MIN;
}

static double *fill(const test_mesh *box, value_fn *value) {
    double *values = malloc((size_t)box->mesh.n_elements * sizeof *values);
    assert_non_null(values);
    for (int64_t i = 0; i < box->mesh.n_elements; i++)
        values[i] = (double)value(box, i);
    return values;
}

/** Whether one array of that name and these values tells regions. */
static int tells(const test_mesh *box, const char *name, const void *values, planish_number type) {
    planish_cell_array array = {.name = name, .values = values, .type = type, .is_region = 17};
    planish_error error = {.text = ""};
    for (int threads = 1; threads <= 4; threads += 3) {
        if (planish_find_regions(&box->mesh, &array, 1, threads, &error))
            fail_msg("%s", error.text);
        assert_true(array.is_region == 0 || array.is_region == 1);
    }
    return array.is_region;
}

static int rule_tells(const test_mesh *box, const char *name, value_fn *value) {
    double *values = fill(box, value);
    const int is_region = tells(box, name, values, PLANISH_NUMBER_FLOAT64);
    free(values);
    return is_region;
}

/* ---- the rule ------------------------------------------------------------------------------- */

static void values_decide(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        test_mesh_box(&box, dim, CELLS);
        assert_true(rule_tells(&box, "mat_id", halves));
        assert_true(rule_tells(&box, NULL, quarters));
        assert_false(rule_tells(&box, "x", same));
        assert_false(rule_tells(&box, "x", number));
        assert_false(rule_tells(&box, "x", parity));
        test_mesh_destroy(&box);
    }
}

/** Two triangles, then three in a row: at most half of the facets may differ. */
static void half_of_the_facets_is_not_too_many(void **state) {
    (void)state;
    const double x[] = {0, 0, 1, 0, 0, 1, 1, 1, 0, 2};
    const int32_t elements[] = {0, 1, 2, 1, 3, 2, 2, 3, 4};
    const int32_t values[] = {1, 1, 2};
    test_mesh two, three;
    test_mesh_create(&three, 2, 5, x, 3, elements);
    test_mesh_create(&two, 2, 4, x, 2, elements);
    assert_true(tells(&three, "a", values, PLANISH_NUMBER_INT32));
    assert_false(tells(&two, "a", values + 1, PLANISH_NUMBER_INT32));
    test_mesh_destroy(&three);
    test_mesh_destroy(&two);
}

static void names_decide(void **state) {
    (void)state;
    static const char *const no[] = {
        "partition",          "Partition_ID", "mesh:partition", "gmsh:partition", "rank",
        "MPI Rank",           "proc",         "vtkProcessId",   "vtkGhostType",   "vtkGhostLevels",
        "vtkOriginalCellIds", "OWNER",        "GlobalCellIds",  "ProcessorId"};
    static const char *const open[] = {
        "mat_id", "region_id", "GeometryIds", "MeshDomain", "zone_id", "PartId",    "Material Ids",
        "Label",  "domain",    "party",       "procedure",  "frank",   "materials", ""};
    static const char *const yes[] = {"region",    "gmsh:physical", "MATERIALIDS",
                                      "medit:ref", "attribute",     "BlockId"};
    test_mesh box;
    test_mesh_box(&box, 2, CELLS);
    for (size_t i = 0; i < sizeof no / sizeof *no; i++) {
        assert_int_equal(planish_rank_region_name(no[i]), -1);
        assert_false(rule_tells(&box, no[i], halves));
    }
    for (size_t i = 0; i < sizeof open / sizeof *open; i++) {
        if (planish_rank_region_name(open[i]) != 0)
            fail_msg("'%s' decides", open[i]);
        assert_true(rule_tells(&box, open[i], halves));
    }
    for (size_t i = 0; i < sizeof yes / sizeof *yes; i++) {
        assert_true(planish_rank_region_name(yes[i]) > 0);
        assert_true(rule_tells(&box, yes[i], parity));
        assert_false(rule_tells(&box, yes[i], same));
    }
    assert_int_equal(planish_rank_region_name(NULL), 0);
    assert_int_equal(planish_rank_region_name("region"), planish_rank_region_name("Region"));
    test_mesh_destroy(&box);
}

/** Of names that tell regions only the most telling does without a look at the values. */
static void one_name_is_sure(void **state) {
    (void)state;
    test_mesh box;
    planish_error error;
    test_mesh_box(&box, 2, CELLS);
    double *values[] = {fill(&box, halves), fill(&box, parity), fill(&box, parity),
                        fill(&box, quarters)};
    planish_cell_array arrays[] = {
        {.name = "x", .values = values[0], .type = PLANISH_NUMBER_FLOAT64},
        {.name = "attribute", .values = values[1], .type = PLANISH_NUMBER_FLOAT64},
        {.name = "region", .values = values[2], .type = PLANISH_NUMBER_FLOAT64},
        {.name = "BlockId", .values = values[3], .type = PLANISH_NUMBER_FLOAT64}};
    assert_int_equal(planish_find_regions(&box.mesh, arrays, 4, 2, &error), PLANISH_OK);
    const int expected[] = {1, 0, 1, 1};
    for (int i = 0; i < 4; i++)
        assert_int_equal(arrays[i].is_region, expected[i]);
    for (int i = 0; i < 4; i++)
        free(values[i]);
    test_mesh_destroy(&box);
}

/* ---- types ---------------------------------------------------------------------------------- */

#define CHECK_TYPE(type, number, low, high)                                                        \
    do {                                                                                           \
        static type values[MOST];                                                                  \
        for (int64_t i = 0; i < box.mesh.n_elements; i++)                                          \
            values[i] = halves(&box, i) > 0 ? (type)(low) : (type)(high);                          \
        assert_true(tells(&box, "a", values, number));                                             \
    } while (0)

static void all_types_are_read(void **state) {
    (void)state;
    test_mesh box;
    test_mesh_box(&box, 3, CELLS);
    CHECK_TYPE(int8_t, PLANISH_NUMBER_INT8, INT8_MIN, INT8_MAX);
    CHECK_TYPE(int16_t, PLANISH_NUMBER_INT16, INT16_MIN, INT16_MAX);
    CHECK_TYPE(int32_t, PLANISH_NUMBER_INT32, INT32_MIN, INT32_MAX);
    CHECK_TYPE(int64_t, PLANISH_NUMBER_INT64, INT64_MIN, INT64_MAX);
    CHECK_TYPE(uint8_t, PLANISH_NUMBER_UINT8, 0, UINT8_MAX);
    CHECK_TYPE(uint16_t, PLANISH_NUMBER_UINT16, 0, UINT16_MAX);
    CHECK_TYPE(uint32_t, PLANISH_NUMBER_UINT32, 0, UINT32_MAX);
    CHECK_TYPE(uint64_t, PLANISH_NUMBER_UINT64, 0, UINT64_MAX);
    CHECK_TYPE(float, PLANISH_NUMBER_FLOAT32, -3, 1e10f);
    CHECK_TYPE(double, PLANISH_NUMBER_FLOAT64, -9e18, 9e18);
    test_mesh_destroy(&box);
}

static void fractions_and_the_like_are_no_regions(void **state) {
    (void)state;
    const double broken[] = {0.5, NAN, INFINITY, -INFINITY, 9.3e18, 1e300, -9.3e18};
    test_mesh box;
    test_mesh_box(&box, 2, CELLS);
    double *values = fill(&box, halves);
    assert_true(tells(&box, "a", values, PLANISH_NUMBER_FLOAT64));
    for (size_t i = 0; i < sizeof broken / sizeof *broken; i++) {
        for (int first = 0; first <= 1; first++) {
            double *at = first ? values : values + box.mesh.n_elements / 3;
            const double kept = *at;
            *at = broken[i];
            assert_false(tells(&box, "region", values, PLANISH_NUMBER_FLOAT64));
            *at = kept;
        }
    }
    free(values);
    test_mesh_destroy(&box);
}

/* ---- combining ------------------------------------------------------------------------------ */

static void arrays_are_combined(void **state) {
    (void)state;
    test_mesh box;
    planish_error error = {.text = ""};
    test_mesh_box(&box, 2, CELLS);
    double *first = fill(&box, halves), *second = fill(&box, quarters), *other = fill(&box, number);
    int64_t *wide = malloc((size_t)box.mesh.n_elements * sizeof *wide);
    int32_t *region = malloc((size_t)box.mesh.n_elements * sizeof *region);
    assert_non_null(wide);
    assert_non_null(region);
    for (int64_t i = 0; i < box.mesh.n_elements; i++)
        wide[i] = huge(&box, i);
    const planish_cell_array arrays[] = {
        {.values = first, .type = PLANISH_NUMBER_FLOAT64, .is_region = 1},
        {.values = other, .type = PLANISH_NUMBER_FLOAT64, .is_region = 0},
        {.values = second, .type = PLANISH_NUMBER_FLOAT64, .is_region = 1},
        {.values = wide, .type = PLANISH_NUMBER_INT64, .is_region = 1}};
    int64_t n = -1;
    assert_int_equal(planish_combine_regions(box.mesh.n_elements, arrays, 4, region, &n, &error),
                     PLANISH_OK);
    assert_int_equal(n, 4);
    int32_t last = -1;
    for (int64_t i = 0; i < box.mesh.n_elements; i++) {
        assert_true(region[i] >= 0 && region[i] <= last + 1);
        last = region[i] > last ? region[i] : last;
        for (int64_t k = 0; k < i; k++)
            assert_int_equal(region[i] == region[k],
                             first[i] == first[k] && second[i] == second[k]);
    }
    assert_int_equal(
        planish_combine_regions(box.mesh.n_elements, arrays + 1, 1, region, &n, &error),
        PLANISH_OK);
    assert_int_equal(n, 1);
    for (int64_t i = 0; i < box.mesh.n_elements; i++)
        assert_int_equal(region[i], 0);
    free(first);
    free(second);
    free(other);
    free(wide);
    free(region);
    test_mesh_destroy(&box);
}

/** As many regions as elements: the table grows. */
static void many_regions_are_numbered(void **state) {
    (void)state;
    enum { N = 5000 };
    static int64_t values[N];
    static int32_t region[N];
    int64_t n;
    for (int64_t i = 0; i < N; i++)
        values[i] = (i * 7919 % N - N / 2) * ((int64_t)1 << 40);
    const planish_cell_array array = {
        .values = values, .type = PLANISH_NUMBER_INT64, .is_region = 1};
    assert_int_equal(planish_combine_regions(N, &array, 1, region, &n, NULL), PLANISH_OK);
    assert_int_equal(n, N);
    for (int32_t i = 0; i < N; i++)
        assert_int_equal(region[i], i);
}

/* ---- interfaces ----------------------------------------------------------------------------- */

static void nodes_between_are_found(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        test_mesh box;
        planish_error error = {.text = ""};
        test_mesh_box(&box, dim, CELLS);
        int32_t region[MOST];
        uint8_t *is_between = malloc((size_t)box.mesh.n_nodes);
        int64_t n = -1, expected = 0;
        assert_non_null(is_between);
        for (int64_t i = 0; i < box.mesh.n_elements; i++)
            region[i] = (int32_t)halves(&box, i);
        assert_int_equal(planish_find_interfaces(&box.mesh, region, 2, is_between, &n, &error),
                         PLANISH_OK);
        for (int64_t i = 0; i < box.mesh.n_nodes; i++) {
            const int is_middle = box.coordinates[i * dim] == CELLS / 2;
            assert_int_equal(is_between[i], is_middle);
            expected += is_middle;
        }
        assert_int_equal(n, expected);
        free(is_between);
        test_mesh_destroy(&box);
    }
}

/* ---- cells of any types ---------------------------------------------------------------------- */

/** Cells tell regions by their facets, whatever their types, and nodes of cells are between these: mids, too, but for
 *  those of edges that straight pyramids have on the other side. */
static void cells_have_regions(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++)
        for (int is_raised = 0; is_raised < 2; is_raised++) {
            cell_box *plain = cell_box_create((cell_box_kind)kind, CELLS);
            cell_box *box = is_raised ? cell_box_raise(plain, 1) : plain;
            const planish_mesh *mesh = &box->mesh;
            const int64_t n = box->cells.n;
            int32_t *half = malloc((size_t)n * sizeof *half),
                    *odd = malloc((size_t)n * sizeof *odd);
            uint8_t *is_between = malloc((size_t)mesh->n_nodes);
            planish_error error = {.text = ""};
            int64_t n_between = 0, expected = 0;
            for (int64_t i = 0; i < n; i++) {
                double lowest = CELLS;
                int place = 0;
                for (int d = 0; d < mesh->dim; d++) {
                    double low = CELLS;
                    for (int64_t k = box->offset[i]; k < box->offset[i + 1]; k++)
                        low = fmin(low, floor(box->x[(int64_t)box->node[k] * mesh->dim + d]));
                    place += (int)low;
                    lowest = d == 0 ? low : lowest;
                }
                half[i] = lowest < CELLS / 2 ? 7 : -3;
                odd[i] = place % 2; /* a chessboard */
            }
            planish_cell_array arrays[] = {
                {.name = "mat_id", .values = half, .type = PLANISH_NUMBER_INT32},
                {.name = "x", .values = odd, .type = PLANISH_NUMBER_INT32}};
            for (int threads = 1; threads <= 3; threads += 2) {
                if (planish_find_regions(mesh, arrays, 2, threads, &error))
                    fail_msg("%s", error.text);
                assert_true(arrays[0].is_region);
                /* Of cubes and squares all facets differ; six pyramids have more within their cube. */
                if (kind == BOX_QUADRILATERALS || kind == BOX_HEXAHEDRA)
                    assert_false(arrays[1].is_region);
            }
            assert_int_equal(planish_find_interfaces(mesh, half, 2, is_between, &n_between, &error),
                             PLANISH_OK);
            uint8_t *sides = calloc((size_t)mesh->n_nodes, 1);
            for (int64_t i = 0; i < n; i++)
                for (int64_t k = box->offset[i]; k < box->offset[i + 1]; k++)
                    sides[box->node[k]] |= half[i] == 7 ? 1 : 2;
            for (int64_t i = 0; i < mesh->n_nodes; i++) {
                const int is_middle = box->x[i * mesh->dim] == CELLS / 2;
                assert_int_equal(is_between[i], sides[i] == 3);
                assert_true(is_between[i] == is_middle ||
                            (!is_between[i] && i >= plain->mesh.n_nodes));
                expected += sides[i] == 3;
            }
            free(sides);
            assert_int_equal(n_between, expected);
            free(half);
            free(odd);
            free(is_between);
            if (is_raised)
                cell_box_destroy(box);
            cell_box_destroy(plain);
        }
}

/** Halves and a chessboard of squares, and what the library says of them. */
typedef struct answers {
    int is_region[2];
    int64_t n_between;
    uint8_t is_between[(CELLS + 1) * (CELLS + 1)];
} answers;

static answers ask(const planish_mesh *mesh, const double *flat) {
    int32_t half[2 * CELLS * CELLS], odd[2 * CELLS * CELLS];
    answers a = {.n_between = -1};
    planish_error error = {.text = ""};
    for (int64_t i = 0; i < mesh->cells->n; i++) {
        const int32_t *node = mesh->cells->node + mesh->cells->offset[i];
        double low[2] = {CELLS, CELLS};
        for (int64_t k = 0; k < mesh->cells->offset[i + 1] - mesh->cells->offset[i]; k++)
            for (int d = 0; d < 2; d++)
                low[d] = fmin(low[d], flat[2 * node[k] + d]);
        half[i] = low[0] < CELLS / 2;
        odd[i] = (int)(low[0] + low[1]) % 2;
    }
    planish_cell_array arrays[] = {{.name = "x", .values = odd, .type = PLANISH_NUMBER_INT32},
                                   {.name = "y", .values = half, .type = PLANISH_NUMBER_INT32}};
    if (planish_find_regions(mesh, arrays, 2, 2, &error) ||
        planish_find_interfaces(mesh, half, 2, a.is_between, &a.n_between, &error))
        fail_msg("%s", error.text);
    a.is_region[0] = arrays[0].is_region;
    a.is_region[1] = arrays[1].is_region;
    return a;
}

static void expect_same(answers a, answers b) {
    assert_memory_equal(a.is_region, b.is_region, sizeof a.is_region);
    assert_memory_equal(a.is_between, b.is_between, sizeof a.is_between);
    assert_int_equal(a.n_between, b.n_between);
}

/** A surface in space has the regions of the same elements in a plane. */
static void surfaces_in_space_have_regions(void **state) {
    enum { N = (CELLS + 1) * (CELLS + 1), PADDED = 5 };
    (void)state;
    for (int kind = BOX_QUADRILATERALS; kind <= BOX_MIXED_2D; kind++) {
        cell_box *box = cell_box_create((cell_box_kind)kind, CELLS);
        double x[PADDED * N] = {0}, dense[3 * N];
        planish_mesh mesh = box->mesh;
        planish_error error;
        assert_int_equal(mesh.n_nodes, N);
        for (int i = 0; i < N; i++) {
            const double place[] = {0, box->x[2 * i], box->x[2 * i] * box->x[2 * i + 1]};
            memcpy(x + PADDED * i, place, sizeof place);
            memcpy(dense + 3 * i, place, sizeof place);
        }
        const answers flat = ask(&mesh, box->x);
        assert_true(flat.is_region[1] && !flat.is_region[0]);
        assert_int_equal(flat.n_between, CELLS + 1);
        mesh.dim = 3;
        mesh.coordinates = dense;
        expect_same(ask(&mesh, box->x), flat);
        mesh.coordinates = x;
        mesh.node_stride = PADDED;
        expect_same(ask(&mesh, box->x), flat);
        x[PADDED * 7 + 2] = NAN;
        assert_int_equal(planish_find_regions(&mesh, NULL, 0, 1, &error), PLANISH_ERROR_MESH);
        assert_int_equal(error.node, 7);
        cell_box_destroy(box);
    }
}

/** Facets of few cells decide: of four hexahedra in a row two facets are the same, one differs. */
static void facets_of_cells_are_counted(void **state) {
    (void)state;
    static const int32_t values[][4] = {{1, 1, 1, 2}, {1, 1, 2, 3}, {1, 2, 3, 4}};
    static const int tell[] = {1, 0, 0};
    cell_box *box = cell_box_create(BOX_HEXAHEDRA, 4);
    const planish_cells row = {.n = 4, .type = box->type, .offset = box->offset, .node = box->node};
    planish_mesh mesh = box->mesh;
    mesh.cells = &row;
    mesh.n_elements = 4;
    for (int i = 0; i < 3; i++) {
        planish_cell_array array = {.name = "x", .values = values[i], .type = PLANISH_NUMBER_INT32};
        assert_int_equal(planish_find_regions(&mesh, &array, 1, 1, NULL), 0);
        assert_int_equal(array.is_region, tell[i]);
    }
    cell_box_destroy(box);
}

/* ---- errors --------------------------------------------------------------------------------- */

static void nonsense_is_refused(void **state) {
    (void)state;
    test_mesh box;
    planish_error error;
    test_mesh_box(&box, 2, 2);
    const int64_t m = box.mesh.n_elements;
    double values[8] = {1, 1, 1, 1, 2, 2, 2, 2.5};
    int32_t region[8];
    uint8_t is_between[9];
    planish_cell_array array = {.name = "a", .values = values, .type = PLANISH_NUMBER_FLOAT64};
    planish_mesh broken = box.mesh;
    const planish_part part = {.node_number = NULL};
    assert_int_equal(planish_find_regions(&box.mesh, &array, 1, -1, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_find_regions(&box.mesh, NULL, 1, 1, &error), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_find_regions(&box.mesh, &array, -1, 1, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_find_regions(&box.mesh, NULL, 0, 1, &error), PLANISH_OK);
    broken.part = &part;
    assert_int_equal(planish_find_regions(&broken, &array, 1, 1, &error), PLANISH_ERROR_PARTS);
    broken = box.mesh;
    broken.n_nodes = 3;
    assert_int_equal(planish_find_regions(&broken, &array, 1, 1, &error), PLANISH_ERROR_MESH);
    array.is_region = 1;
    memset(region, 7, sizeof region);
    assert_int_equal(planish_combine_regions(m, &array, 1, region, NULL, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(error.element, 7);
    assert_int_equal(region[0], 0x07070707);
    assert_int_equal(planish_combine_regions(m, &array, 1, NULL, NULL, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_combine_regions(-1, &array, 1, region, NULL, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_find_interfaces(&box.mesh, NULL, 1, is_between, NULL, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_find_interfaces(&box.mesh, region, 1, NULL, NULL, &error),
                     PLANISH_ERROR_ARGUMENT);
    array.type = (planish_number)10;
    assert_int_equal(planish_find_regions(&box.mesh, &array, 1, 1, &error), PLANISH_ERROR_ARGUMENT);
    array = (planish_cell_array){.name = "a"};
    assert_int_equal(planish_find_regions(&box.mesh, &array, 1, 1, &error), PLANISH_ERROR_ARGUMENT);
    test_mesh_destroy(&box);
}

static int find_all(const test_mesh *box, planish_error *error) {
    int32_t region[MOST];
    uint8_t is_between[(CELLS + 1) * (CELLS + 1)];
    double *values = fill(box, halves);
    planish_cell_array array = {.name = "a", .values = values, .type = PLANISH_NUMBER_FLOAT64};
    int status = planish_find_regions(&box->mesh, &array, 1, 2, error);
    if (!status)
        status = planish_combine_regions(box->mesh.n_elements, &array, 1, region, NULL, error);
    if (!status)
        status = planish_find_interfaces(&box->mesh, region, 1, is_between, NULL, error);
    free(values);
    return status;
}

/** Every allocation fails once: nothing but an error comes of it. */
static void memory_may_be_short(void **state) {
    (void)state;
    test_mesh box;
    planish_error error;
    int status = PLANISH_ERROR_MEMORY;
    test_mesh_box(&box, 2, CELLS);
    for (int permitted = 0; status == PLANISH_ERROR_MEMORY; permitted++) {
        allocations_permit(permitted);
        status = find_all(&box, &error);
        allocations_permit(-1);
    }
    assert_int_equal(status, PLANISH_OK);
    test_mesh_destroy(&box);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_decide),
        cmocka_unit_test(half_of_the_facets_is_not_too_many),
        cmocka_unit_test(names_decide),
        cmocka_unit_test(one_name_is_sure),
        cmocka_unit_test(all_types_are_read),
        cmocka_unit_test(fractions_and_the_like_are_no_regions),
        cmocka_unit_test(arrays_are_combined),
        cmocka_unit_test(many_regions_are_numbered),
        cmocka_unit_test(nodes_between_are_found),
        cmocka_unit_test(cells_have_regions),
        cmocka_unit_test(surfaces_in_space_have_regions),
        cmocka_unit_test(facets_of_cells_are_counted),
        cmocka_unit_test(nonsense_is_refused),
        cmocka_unit_test(memory_may_be_short),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
