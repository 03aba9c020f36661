/* planish_mesh.reference: elements that are to have the shapes of another mesh. Elements are judged by
 * plain loops in long double. */
#include "geometry/cell.h"
#include "support/cell_meshes.h"
#include "support/meshes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- plain formulas -------------------------------------------------------------------------- */

typedef long double real;

static real determinant(int dim, real a[3][3]) {
    if (dim == 2)
        return a[0][0] * a[1][1] - a[0][1] * a[1][0];
    return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
           a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
           a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
}

/** Solve a x = b, of dimension dim, by Cramer's rule. */
static void solve(int dim, real a[3][3], const real *b, real *x) {
    const real whole = determinant(dim, a);
    for (int k = 0; k < dim; k++) {
        real with[3][3];
        memcpy(with, a, sizeof with);
        for (int i = 0; i < dim; i++)
            with[i][k] = b[i];
        x[k] = determinant(dim, with) / whole;
    }
}

/** Edges [edge][component] of corner c of an element whose nodes are at x. */
static void edges_of(const pl_cell_shape *shape, int c, const double *x, const int32_t *node,
                     real edge[3][3]) {
    const int dim = shape->dim;
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            edge[j][d] =
                (real)x[node[shape->neighbour[c][j]] * dim + d] - (real)x[node[c] * dim + d];
}

/** mu^2 of T = A W^-1: rows of T^T solve W^T t = a, with edges as rows. */
static real mean_square(int dim, real a[3][3], real w[3][3]) {
    const real det = determinant(dim, a) / determinant(dim, w);
    real norm = 0;
    for (int d = 0; d < dim; d++) {
        real t[3], column[3];
        for (int j = 0; j < dim; j++)
            column[j] = a[j][d];
        solve(dim, w, column, t);
        for (int k = 0; k < dim; k++)
            norm += t[k] * t[k];
    }
    const real mu = dim == 3 ? norm / (3 * powl(det, 2.0L / 3)) : norm / (2 * det);
    return mu * mu;
}

/** RMS of AR of the box, at x, against the reference. */
static double rms_of(const cell_box *box, const double *x, const double *reference) {
    real sum = 0;
    for (int64_t i = 0; i < box->cells.n; i++) {
        const pl_cell_shape *shape = pl_cell_type_of(box->cells.type[i])->shape;
        const int32_t *node = box->cells.node + box->cells.offset[i];
        real of_cell = 0;
        for (int c = 0; c < shape->n_measured; c++) {
            real a[3][3], w[3][3];
            edges_of(shape, c, x, node, a);
            edges_of(shape, c, reference, node, w);
            of_cell += mean_square(shape->dim, a, w);
        }
        sum += of_cell / shape->n_measured;
    }
    return (double)sqrtl(sum / box->cells.n);
}

/* ---- meshes ---------------------------------------------------------------------------------- */

static double *copy_of(const cell_box *box) {
    const size_t size = (size_t)(box->mesh.n_nodes * box->mesh.dim) * sizeof *box->x;
    double *x = malloc(size);
    assert_non_null(x);
    memcpy(x, box->x, size);
    return x;
}

static planish_options defaults(void) {
    planish_options options;
    planish_options_init(&options);
    options.threads = 1;
    return options;
}

static planish_result smooth_as(const planish_mesh *mesh, double *x,
                                const planish_options *options) {
    planish_plan *plan;
    planish_result result;
    planish_error error;
    if (planish_plan_create(mesh, options, &plan, &error))
        fail_msg("%s", error.text);
    if (planish_smooth(plan, x, options, &result, &error))
        fail_msg("%s", error.text);
    planish_plan_destroy(plan);
    return result;
}

/** Largest distance of nodes of two places. */
static double farthest(const cell_box *box, const double *x, const double *y) {
    double most = 0;
    for (int64_t i = 0; i < box->mesh.n_nodes * box->mesh.dim; i++)
        most = fmax(most, fabs(x[i] - y[i]));
    return most;
}

/* A box whose elements are to be what they are stays. */
static void a_copy_of_itself_stays(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++) {
        cell_box *box = cell_box_create((cell_box_kind)kind, 5);
        cell_box_shake(box, 0.1, 3);
        double *reference = copy_of(box);
        const planish_options options = defaults();
        planish_mesh mesh = box->mesh;
        mesh.reference = reference;
        const planish_result result = smooth_as(&mesh, box->x, &options);
        assert_true(fabs(result.rms - 1) < 1e-12);
        assert_true(farthest(box, box->x, reference) < 1e-9);
        free(reference);
        cell_box_destroy(box);
    }
}

/* A box whose inner nodes were moved becomes the reference again. */
static void a_shaken_box_comes_back(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++) {
        cell_box *box = cell_box_create((cell_box_kind)kind, 6);
        cell_box_shake(box, 0.1, 3);
        double *reference = copy_of(box);
        cell_box_shake(box, 0.08, 5);
        planish_options options = defaults();
        planish_mesh mesh = box->mesh;
        mesh.reference = reference;
        options.tolerance = 1e-13;
        options.max_sweeps = 2000;
        const double before = rms_of(box, box->x, reference);
        const planish_result result = smooth_as(&mesh, box->x, &options);
        const double after = rms_of(box, box->x, reference);
        print_message("%d: %g to %g, %g; %d sweeps, %g off\n", kind, before, after, result.rms,
                      (int)result.sweeps, farthest(box, box->x, reference));
        assert_true(fabs(result.objective_before - before) < 1e-9 * before);
        assert_true(fabs(result.rms - after) < 1e-9 * after);
        assert_true(farthest(box, box->x, reference) < 1e-4);
        free(reference);
        cell_box_destroy(box);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_copy_of_itself_stays),
        cmocka_unit_test(a_shaken_box_comes_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
