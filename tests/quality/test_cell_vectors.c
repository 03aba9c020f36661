/* Measures and certificates of cells have the same bits with wide vectors and without. */
#include "quality/cell_measure.h"
#include "support/effort.h"
#include "support/loose_cells.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* The sources of measure and certificate once more, as on a machine without AVX2. */
#define __builtin_cpu_supports(feature) 0
#define pl_jacobian_evaluate            plain_jacobian_evaluate
#define pl_jacobian_bound               plain_jacobian_bound
#define pl_validity_of_lane             plain_validity_of_lane
#define pl_validity_exactly             plain_validity_exactly
#define pl_bricks_certify               plain_bricks_certify
#define pl_measure_cells                plain_measure_cells
#define pl_cell_reference_edges         plain_reference_edges
#define pl_cell_rules_make              plain_rules_make
#define pl_cell_rules_free              plain_rules_free
void plain_jacobian_evaluate(const pl_jacobian_rule *, const double[], pl_jacobian_block *);
void plain_jacobian_bound(const pl_jacobian_rule *, const uint8_t[], pl_float_block *);
pl_validity plain_validity_of_lane(const pl_jacobian_rule *, const pl_jacobian_block *, int,
                                   const int32_t[], const double *, double);
pl_validity plain_validity_exactly(const pl_jacobian_rule *, const int32_t[], const double *,
                                   double);
void plain_bricks_certify(pl_brick_block *);
int plain_measure_cells(const pl_cell_mesh *, const pl_cell_rules *, int, planish_cell_quality *,
                        const planish_cell_values *, int64_t *);
void plain_reference_edges(const pl_cell_mesh *, int64_t, int, double[3][3]);
int plain_rules_make(const pl_cell_mesh *, pl_cell_rules *);
void plain_rules_free(pl_cell_rules *);
#include "quality/cell_measure.c"
#define LANES    VALIDITY_LANES
#define pack     validity_pack
#define evaluate evaluate_validity
#include "quality/validity.c"
#undef evaluate
#undef pack
#undef LANES
#undef pl_cell_rules_free
#undef pl_cell_rules_make
#undef pl_cell_reference_edges
#undef pl_measure_cells
#undef pl_bricks_certify
#undef pl_validity_exactly
#undef pl_validity_of_lane
#undef pl_jacobian_bound
#undef pl_jacobian_evaluate
#undef __builtin_cpu_supports

/** Measure and certificate have the same bits with AVX2 and without. */
static void wide_and_plain_vectors_give_the_same_bits(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        loose_cells m = loose_cells_mixed(dim, 2000, 17);
        int8_t *sign = malloc((size_t)m.cells.n);
        memset(sign, 1, (size_t)m.cells.n);
        const pl_cell_mesh of = {
            .dim = dim, .cells = &m.cells, .coordinates = m.x, .sign = sign, .rounding = 1e-3};
        pl_cell_rules rules;
        int64_t flawed;
        planish_cell_quality wide, plain;
        cell_values wide_values = cell_values_make(m.cells.n),
                    plain_values = cell_values_make(m.cells.n);
        assert_int_equal(pl_cell_rules_make(&of, &rules), PLANISH_OK);
        assert_int_equal(pl_measure_cells(&of, &rules, 1, &wide, &wide_values.of, &flawed),
                         PLANISH_OK);
        assert_int_equal(plain_measure_cells(&of, &rules, 1, &plain, &plain_values.of, &flawed),
                         PLANISH_OK);
        assert_memory_equal(&wide, &plain, sizeof wide);
        cell_values_expect_same(&wide_values, &plain_values);
        assert_true(wide.all.n_inverted > 0 && wide.all.n_inverted < wide.all.n_elements);
        pl_cell_rules_free(&rules);
        cell_values_destroy(&wide_values);
        cell_values_destroy(&plain_values);
        free(sign);
        loose_cells_destroy(&m);
    }
}

/** So do hexahedra in floats: some have room, others none. */
static void wide_and_plain_floats_give_the_same_bits(void **state) {
    static const float corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                       {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    int n_with_room = 0, n_without = 0;
    uint64_t random = effort_seed(23);
    (void)state;
    for (int trial = 0; trial < 500; trial++) {
        const float noise = (float)(2 * random_unit(&random));
        pl_brick_block wide, plain;
        memset(&wide, 0, sizeof wide);
        for (int l = 0; l < PL_JACOBIAN_LANES; l++)
            for (int i = 0; i < 8; i++)
                for (int d = 0; d < 3; d++)
                    wide.x[i][d][l] = corner[i][d] + noise * (float)(random_unit(&random) - 0.5);
        plain = wide;
        pl_bricks_certify(&wide);
        plain_bricks_certify(&plain);
        assert_memory_equal(wide.room, plain.room, sizeof wide.room);
        for (int l = 0; l < PL_JACOBIAN_LANES; l++)
            *(wide.room[l] > 0 ? &n_with_room : &n_without) += 1;
    }
    assert_true(n_with_room > 500 && n_without > 500);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wide_and_plain_vectors_give_the_same_bits),
        cmocka_unit_test(wide_and_plain_floats_give_the_same_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
