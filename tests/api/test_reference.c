/* planish_mesh.reference: elements that are to have the shapes of another mesh. Elements are judged by
 * plain loops in long double. */
#include "support/cell_meshes.h"
#include "support/meshes.h"
#include "support/run.h"
#include "support/target_ratio.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- what is promised ------------------------------------------------------------------------- */

typedef long double real;

/** RMS of what counts over all elements of a box, at x against the reference, and the largest. */
static double rms_of(const cell_box *box, const double *x, const double *reference, double weight,
                     double *most) {
    real sum = 0, largest = 0;
    for (int64_t i = 0; i < box->cells.n; i++) {
        const real square = target_square_of(
            box->cells.type[i], box->cells.node + box->cells.offset[i], x, reference, weight);
        sum += square;
        largest = square > largest ? square : largest;
    }
    *most = (double)sqrtl(largest);
    return (double)sqrtl(sum / box->cells.n);
}

/* ---- meshes ---------------------------------------------------------------------------------- */

/** Largest distance of nodes of two places. */
static double farthest(const cell_box *box, const double *x, const double *y) {
    double most = 0;
    for (int64_t i = 0; i < box->mesh.n_nodes * box->mesh.dim; i++)
        most = fmax(most, fabs(x[i] - y[i]));
    return most;
}

/* Kinds of boxes, and behind them those of simplices: of triangles and of tetrahedra. */
enum { TRIANGLES = N_BOX_KINDS, TETRAHEDRA, N_KINDS };

/** A box of a kind; its simplices are cells, too, but of mesh.elements. */
static cell_box *box_of(int kind, int n) {
    if (kind < N_BOX_KINDS)
        return cell_box_create((cell_box_kind)kind, n);
    test_mesh simplices;
    const int dim = kind == TETRAHEDRA ? 3 : 2;
    test_mesh_box(&simplices, dim, n);
    cell_box *box = calloc(1, sizeof *box);
    const int64_t m = simplices.mesh.n_elements;
    assert_non_null(box);
    *box =
        (cell_box){.mesh = simplices.mesh, .x = simplices.coordinates, .node = simplices.elements};
    box->offset = malloc((size_t)(m + 1) * sizeof *box->offset);
    box->type = malloc((size_t)m);
    assert_true(box->offset && box->type);
    for (int64_t i = 0; i <= m; i++)
        box->offset[i] = i * (dim + 1);
    memset(box->type, dim == 3 ? PLANISH_CELL_TETRAHEDRON : PLANISH_CELL_TRIANGLE, (size_t)m);
    box->cells =
        (planish_cells){.n = m, .type = box->type, .offset = box->offset, .node = box->node};
    return box;
}

/** A shaken box, its places then (owned), and shaken more. */
typedef struct shaken {
    cell_box *box;
    double *reference;
    planish_mesh mesh; /* with it */
} shaken;

static shaken shaken_box(int kind, int n, double first, double then) {
    shaken s = {.box = box_of(kind, n)};
    cell_box_shake(s.box, first, 3);
    s.reference = test_copy_of(&s.box->mesh);
    cell_box_shake(s.box, then, 5);
    s.mesh = s.box->mesh;
    s.mesh.reference = s.reference;
    return s;
}

static void forget(shaken *s) {
    free(s->reference);
    cell_box_destroy(s->box);
}

/* ---- what comes out -------------------------------------------------------------------------- */

/* A box whose elements are to be what they are stays. */
static void a_copy_of_itself_stays(void **state) {
    (void)state;
    for (int kind = 0; kind < N_KINDS; kind++)
        for (int sized = 0; sized < 2; sized++) {
            shaken s = shaken_box(kind, 5, 0.1, 0);
            planish_options options = test_options(1);
            options.size_weight = sized ? 0.5 : 0;
            const planish_result result = test_smooth_in_place(&s.mesh, s.box->x, &options);
            assert_true(fabs(result.rms - 1) < 1e-12);
            assert_true(farthest(s.box, s.box->x, s.reference) < 1e-7);
            forget(&s);
        }
}

/* A box whose inner nodes were moved becomes the reference again, and what is said of it is so. */
static void a_shaken_box_comes_back(void **state) {
    (void)state;
    for (int kind = 0; kind < N_KINDS; kind++)
        for (int sized = 0; sized < 2; sized++) {
            shaken s = shaken_box(kind, 6, 0.1, 0.08);
            planish_options options = test_options(1);
            double worst, worst_after;
            options.size_weight = sized ? 0.3 : 0;
            options.tolerance = 1e-12;
            const double before = rms_of(s.box, s.box->x, s.reference, options.size_weight, &worst);
            const planish_result result = test_smooth_in_place(&s.mesh, s.box->x, &options);
            const double after =
                rms_of(s.box, s.box->x, s.reference, options.size_weight, &worst_after);
            assert_true(fabs(result.objective_before - before) < 1e-12 * before);
            assert_true(fabs(result.objective - after) < 1e-12 * after);
            assert_true(worst_after <= worst * (1 + 1e-12));
            assert_true(farthest(s.box, s.box->x, s.reference) < 1e-4);
            forget(&s);
        }
}

/* A reference that lies elsewhere, turned and of another size, is the same. */
static void a_moved_reference_is_the_same(void **state) {
    (void)state;
    for (int kind = 0; kind < N_KINDS; kind++) {
        shaken s = shaken_box(kind, 4, 0.1, 0.1);
        const int dim = s.mesh.dim;
        const planish_options options = test_options(1);
        double *x = test_copy_of(&s.box->mesh);
        test_smooth_in_place(&s.mesh, s.box->x, &options);
        for (int64_t i = 0; i < s.mesh.n_nodes; i++) {
            double *p = s.reference + i * dim;
            const double turned[2] = {0.6 * p[0] - 0.8 * p[1], 0.8 * p[0] + 0.6 * p[1]};
            for (int d = 0; d < dim; d++)
                p[d] = 7 + 1e-6 * (d < 2 ? turned[d] : p[d]);
        }
        test_smooth_in_place(&s.mesh, x, &options);
        assert_true(farthest(s.box, s.box->x, x) < 1e-3);
        free(x);
        forget(&s);
    }
}

/** Smooth a copy of the box's coordinates; returns it. */
static double *smoothed(const shaken *s, const planish_options *options) {
    double *x = test_copy_of(&s->box->mesh);
    test_smooth_in_place(&s->mesh, x, options);
    return x;
}

/* The bits are the same on any number of threads and with any instruction set. */
static void bits_are_the_same(void **state) {
    (void)state;
    for (int kind = 0; kind < N_KINDS; kind++)
        for (int sized = 0; sized < 2; sized++) {
            shaken s = shaken_box(kind, 9, 0.12, 0.12);
            planish_options options = test_options(1);
            options.size_weight = sized ? 0.5 : 0;
            double *wanted = smoothed(&s, &options);
            const size_t size = (size_t)(s.mesh.n_nodes * s.mesh.dim) * sizeof *wanted;
            for (int way = 0; way < 4; way++) {
                static const planish_isa isa[] = {PLANISH_ISA_AUTO, PLANISH_ISA_PLAIN,
                                                  PLANISH_ISA_VECTOR, PLANISH_ISA_AVX2};
                planish_plan *plan;
                options.threads = way == 0 ? 3 : 1;
                options.isa = isa[way];
                if (planish_plan_create(&s.mesh, &options, &plan, NULL) != 0)
                    continue; /* not on this machine */
                planish_plan_destroy(plan);
                double *x = smoothed(&s, &options);
                assert_memory_equal(x, wanted, size);
                free(x);
            }
            free(wanted);
            forget(&s);
        }
}

/* A tangled box of thin elements is untangled towards them. */
static void thin_elements_are_untangled(void **state) {
    (void)state;
    for (int kind = 0; kind < N_KINDS; kind++) {
        shaken s = shaken_box(kind, 5, 0, 0.7);
        const int dim = s.mesh.dim;
        const planish_options options = test_options(1);
        double worst;
        for (int64_t i = 0; i < s.mesh.n_nodes; i++) {
            s.reference[i * dim + dim - 1] *= 0.02;
            s.box->x[i * dim + dim - 1] *= 0.02;
        }
        const planish_result result = test_smooth_in_place(&s.mesh, s.box->x, &options);
        assert_true(result.untangling_sweeps > 0);
        assert_int_equal(result.n_inverted, 0);
        assert_true(rms_of(s.box, s.box->x, s.reference, 0, &worst) < 1.01);
        forget(&s);
    }
}

/* Layers that thicken survive where their wall is moved. */
static void layers_survive(void **state) {
    (void)state;
    for (int kind = 0; kind < N_KINDS; kind++) {
        enum { N = 8 };
        shaken s = shaken_box(kind, N, 0, 0);
        const int dim = s.mesh.dim;
        const planish_options options = test_options(1);
        double most = 0;
        for (int64_t i = 0; i < s.mesh.n_nodes; i++) {
            const double *p = s.box->x + i * dim;
            const double height = pow(1.8, p[dim - 1]) - 1;
            s.reference[i * dim + dim - 1] = height;
            s.box->x[i * dim + dim - 1] = height;
            if (height < 0.1) /* the wall */
                s.box->x[i * dim + dim - 1] +=
                    0.4 * sin(p[0] * 3.14159265 / N) * (dim == 3 ? sin(p[1] * 3.14159265 / N) : 1);
        }
        test_smooth_in_place(&s.mesh, s.box->x, &options);
        for (int64_t i = 0; i < s.mesh.n_nodes; i++)
            for (int64_t j = 0; j < s.mesh.n_nodes; j++) {
                const double *p = s.reference + i * dim, *q = s.reference + j * dim;
                if (p[dim - 1] < 0.1 && q[dim - 1] > 0.1 && q[dim - 1] < 1 && p[0] == q[0] &&
                    (dim == 2 || p[1] == q[1])) {
                    const double height = s.box->x[j * dim + dim - 1] - s.box->x[i * dim + dim - 1];
                    most = fmax(most, fabs(height / q[dim - 1] - 1));
                }
            }
        assert_true(most < 0.1);
        forget(&s);
    }
}

/* ---- errors ---------------------------------------------------------------------------------- */

/* What cannot be a target is refused, and what is not made for targets. */
static void wrong_references_are_refused(void **state) {
    (void)state;
    for (int kind = 0; kind < N_KINDS; kind++) {
        shaken s = shaken_box(kind, 3, 0, 0.1);
        planish_options options = test_options(1);
        double *last = &s.reference[s.mesh.n_nodes * s.mesh.dim - 1];
        const double place = *last;
        *last = -5;
        test_expect_refusal(&s.mesh, &options, PLANISH_ERROR_MESH, "is inverted in mesh.reference");
        *last = NAN;
        test_expect_refusal(&s.mesh, &options, PLANISH_ERROR_MESH, "not finite");
        *last = place;
        for (int64_t i = 0; i < s.mesh.n_nodes; i++)
            s.reference[(i + 1) * s.mesh.dim - 1] = 0;
        test_expect_refusal(&s.mesh, &options, PLANISH_ERROR_MESH, "is flat");
        forget(&s);
    }
}

static void other_objectives_are_refused(void **state) {
    (void)state;
    shaken s = shaken_box(BOX_HEXAHEDRA, 3, 0, 0.1);
    planish_options options = test_options(1);
    planish_result result;
    planish_error error;
    planish_plan *plan;
    options.size_weight = 1.5;
    test_expect_refusal(&s.mesh, &options, PLANISH_ERROR_ARGUMENT, "size_weight");
    options.size_weight = 0;
    assert_int_equal(planish_plan_create(&s.mesh, &options, &plan, &error), 0);
    options.worst = PLANISH_WORST_ASPECT_RATIO;
    assert_int_equal(planish_smooth(plan, s.box->x, &options, &result, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "mesh.reference"));
    options.worst = PLANISH_WORST_NONE;
    options.objective = PLANISH_OBJECTIVE_EDGE_RATIO;
    assert_int_equal(planish_smooth(plan, s.box->x, &options, &result, &error),
                     PLANISH_ERROR_ARGUMENT);
    planish_plan_destroy(plan);
    const int32_t pair[2] = {0, 3};
    s.mesh.n_periodic = 1;
    s.mesh.periodic = pair;
    test_expect_refusal(&s.mesh, &options, PLANISH_ERROR_ARGUMENT, "mesh.periodic");
    forget(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_copy_of_itself_stays),
        cmocka_unit_test(a_shaken_box_comes_back),
        cmocka_unit_test(a_moved_reference_is_the_same),
        cmocka_unit_test(bits_are_the_same),
        cmocka_unit_test(thin_elements_are_untangled),
        cmocka_unit_test(layers_survive),
        cmocka_unit_test(wrong_references_are_refused),
        cmocka_unit_test(other_objectives_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
