/* Tests of planish_measure_cells against plain loops in long double, and of what its comments say:
 * elements that count, handedness, sizes, threads, errors, memory. */
#include "geometry/cell.h"
#include "geometry/simplex.h"
#include "support/effort.h"
#include "support/faults.h"
#include "support/loose_cells.h"

#include <planish/planish.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/** Call planish_measure_cells with a mesh of these cells. */
static int measure_cells(const planish_cells *cells, int dim, int64_t n_nodes, const double *x,
                         double rounding, int threads, planish_cell_quality *quality,
                         double *aspect_ratio, planish_error *error) {
    const planish_mesh of = {.dim = dim,
                             .n_nodes = n_nodes,
                             .n_elements = cells ? cells->n : 0,
                             .coordinates = x,
                             .cells = cells};
    const planish_cell_values values = {.aspect_ratio = aspect_ratio};
    return planish_measure_cells(&of, rounding, threads, quality, &values, error);
}

static planish_cell_quality measure(const loose_cells *m, int threads, double *aspect_ratio) {
    planish_cell_quality quality;
    planish_error error;
    memset(&quality, 0xff, sizeof quality);
    if (measure_cells(&m->cells, m->dim, m->n_nodes, m->x, 0, threads, &quality, aspect_ratio,
                      &error))
        fail_msg("%s", error.text);
    return quality;
}

/* ---- Plain formulas -------------------------------------------------------------------------- */

typedef long double real;

static real determinant3(real a[3][3]) {
    return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
           a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
           a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
}

/** |A B^-1|^2, with rows that are edges; in the plane both have the third unit vector, and 1 is
 *  taken off. */
static real norm_square(real a[3][3], real b[3][3], int dim) {
    real sum = 0;
    const real d = determinant3(b);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            real t = 0; /* of B^-1 A, of the same norm up to rotations of the ideal corner */
            for (int k = 0; k < 3; k++) {
                const int r = (k + 1) % 3, s = (k + 2) % 3, p = (i + 1) % 3, q = (i + 2) % 3;
                t += (b[r][p] * b[s][q] - b[r][q] * b[s][p]) / d * a[k][j];
            }
            sum += t * t;
        }
    return dim == 2 ? sum - 1 : sum;
}

/** Edges of corner c as rows; returns the product of their lengths. */
static real edges_of(const pl_cell_shape *shape, int c, const double *x, int stride, real a[3][3]) {
    real product = 1;
    memset(a, 0, 9 * sizeof a[0][0]);
    a[2][2] = 1;
    for (int j = 0; j < shape->dim; j++) {
        real square = 0;
        for (int d = 0; d < shape->dim; d++) {
            a[j][d] = (real)x[shape->neighbour[c][j] * stride + d] - (real)x[c * stride + d];
            square += a[j][d] * a[j][d];
        }
        product *= sqrtl(square);
    }
    return product;
}

/** AR of the element whose corners come first at x; *least: its least scaled Jacobian. */
static real plain_ratio(int type, const double *x, int dim, real *least) {
    const pl_cell_shape *shape = pl_cell_type_of(type)->shape;
    real sum = 0;
    *least = INFINITY;
    for (int c = 0; c < shape->n_measured; c++) {
        real a[3][3], w[3][3];
        const real lengths = edges_of(shape, c, x, dim, a);
        const real ideal_lengths = edges_of(shape, c, loose_ideal_corners(type)[0], 3, w);
        const real d = determinant3(a) / determinant3(w), e = norm_square(a, w, dim);
        const real mu = e / (dim * powl(fabsl(d), 2.0L / dim));
        sum += mu * mu;
        *least = fminl(*least, d * ideal_lengths / lengths);
    }
    return sqrtl(sum / shape->n_measured);
}

/* ---- Tests ----------------------------------------------------------------------------------- */

static void ideal_elements_have_an_aspect_ratio_of_1(void **state) {
    (void)state;
    uint64_t random = 1;
    for (int k = 0; k < 2 * LOOSE_TYPES; k++) {
        const int type = loose_types[k / 2];
        loose_cells m = loose_cells_create(pl_cell_type_of(type)->shape->dim);
        double ratio;
        loose_cells_add(&m, type, 0, 0, k % 2 ? -1 : 1, &random);
        const planish_cell_quality q = measure(&m, 1, &ratio);
        assert_int_equal(q.n_types, 1);
        assert_int_equal(q.type[0], type);
        assert_memory_equal(&q.by_type[0], &q.all, sizeof q.all);
        assert_int_equal(q.all.n_elements, 1);
        assert_int_equal(q.all.n_inverted, 0);
        assert_int_equal(q.all.n_uncertified, 0);
        assert_int_equal(q.all.n_inverted_corners, 0);
        assert_int_equal(q.all.n_curved, 0);
        assert_int_equal(q.all.worst_element, 0);
        assert_true(ratio == q.all.max_aspect_ratio && ratio == q.all.mean_aspect_ratio);
        assert_true(fabs(ratio - 1) < 1e-14 && fabs(q.all.rms_aspect_ratio - 1) < 1e-14);
        assert_true(fabs(q.all.min_scaled_jacobian - 1) < 1e-14);
        assert_true(fabs(q.all.max_edge_ratio - 1) < 1e-14 && q.all.min_jacobian_ratio == 1);
        loose_cells_destroy(&m);
    }
}

static void simplices_have_their_mean_ratio(void **state) {
    (void)state;
    uint64_t random = effort_seed(11);
    for (int dim = 2; dim <= 3; dim++)
        for (int64_t repeat = effort(100, 10000); repeat > 0; repeat--) {
            loose_cells m = loose_cells_create(dim);
            double ratio;
            loose_cells_add(&m, dim == 3 ? 10 : 5, 0.3, 0, 1, &random);
            measure(&m, 1, &ratio);
            const double *vertex[4];
            for (int j = 0; j <= dim; j++)
                vertex[j] = m.x + j * dim;
            if (ratio > 0)
                assert_true(fabs(ratio * fabs(pl_mean_ratio(dim, vertex)) - 1) < 1e-12);
            loose_cells_destroy(&m);
        }
}

static void measures_agree_with_plain_loops(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        loose_cells m = loose_cells_mixed(dim, effort(3000, LOOSE_MOST), 12);
        double *ratio = malloc((size_t)m.cells.n * sizeof *ratio);
        const planish_cell_quality q = measure(&m, 2, ratio);
        planish_cell_measures sums = {.n_elements = 0};
        int64_t n_all[5] = {0}, n_ratios = 0;
        for (int r = 0; r < q.n_types; r++) {
            const planish_cell_measures *of = &q.by_type[r];
            assert_true(r == 0 || q.type[r] > q.type[r - 1]);
            real square = 0, sum = 0, least = INFINITY;
            double largest = 0;
            int64_t n = 0, n_type = 0, worst = -1;
            for (int64_t i = 0; i < m.cells.n; i++) {
                real scaled;
                if (m.type[i] != q.type[r])
                    continue;
                double *x = m.x + m.node[m.offset[i]] * dim;
                real plain = plain_ratio(m.type[i], x, dim, &scaled);
                /* A simplex that nothing joins is right in either handedness. */
                if (scaled < 0 && pl_cell_type_of(m.type[i])->shape->n_simplices == 1) {
                    double mirrored[4 * 3];
                    for (int k = 0; k < (dim + 1) * dim; k++)
                        mirrored[k] = k % dim == 0 ? -x[k] : x[k];
                    plain = plain_ratio(m.type[i], mirrored, dim, &scaled);
                }
                n_type++;
                least = fminl(least, scaled);
                if (ratio[i] == 0)
                    continue;
                assert_true(scaled > 0 && fabsl(plain - ratio[i]) < 1e-10L * plain);
                worst = ratio[i] > largest ? i : worst;
                largest = fmax(ratio[i], largest);
                square += plain * plain;
                sum += plain;
                n++;
            }
            assert_int_equal(n_type, of->n_elements);
            assert_true(n <= n_type - of->n_inverted);
            if (pl_cell_type_of((int)q.type[r])->order == 1)
                assert_int_equal(n, n_type - of->n_inverted);
            assert_true(of->max_aspect_ratio == largest);
            assert_int_equal(of->worst_element, worst);
            assert_true(fabsl(of->min_scaled_jacobian - least) < 1e-12L);
            assert_true(fabsl(of->rms_aspect_ratio - sqrtl(square / n)) <
                        1e-10L * sqrtl(square / n));
            assert_true(fabsl(of->mean_aspect_ratio - sum / n) < 1e-10L * sum / n);
            n_all[0] += of->n_elements;
            n_all[1] += of->n_inverted;
            n_all[2] += of->n_inverted_corners;
            n_all[3] += of->n_curved;
            n_all[4] += of->n_uncertified;
            n_ratios += n;
            sums.mean_aspect_ratio += of->mean_aspect_ratio * (double)n;
            sums.max_aspect_ratio = fmax(sums.max_aspect_ratio, of->max_aspect_ratio);
            sums.max_edge_ratio = fmax(sums.max_edge_ratio, of->max_edge_ratio);
        }
        assert_true(q.n_types > 4);
        assert_int_equal(q.all.n_elements, n_all[0]);
        assert_int_equal(q.all.n_inverted, n_all[1]);
        assert_int_equal(q.all.n_inverted_corners, n_all[2]);
        assert_int_equal(q.all.n_curved, n_all[3]);
        assert_int_equal(q.all.n_uncertified, 0);
        assert_int_equal(n_all[4], 0);
        assert_true(n_all[1] > 0 && n_all[2] > 0 && n_all[3] > 0);
        assert_true(q.all.max_aspect_ratio == sums.max_aspect_ratio);
        assert_true(q.all.max_edge_ratio == sums.max_edge_ratio);
        assert_true(ratio[q.all.worst_element] == q.all.max_aspect_ratio);
        assert_true(fabs(q.all.mean_aspect_ratio - sums.mean_aspect_ratio / (double)n_ratios) <
                    1e-10);
        free(ratio);
        loose_cells_destroy(&m);
    }
}

static void any_number_of_threads_gives_the_same_bits(void **state) {
    (void)state;
    static const int THREADS[] = {2, 3, 5, 8, 0};
    for (int dim = 2; dim <= 3; dim++) {
        loose_cells m = loose_cells_mixed(dim, 9000, 13);
        const size_t bytes = (size_t)m.cells.n * sizeof(double);
        double *ratio = malloc(bytes), *other = malloc(bytes);
        const planish_cell_quality q = measure(&m, 1, ratio);
        for (int i = 0; i < 5; i++) {
            const planish_cell_quality more = measure(&m, THREADS[i], other);
            assert_memory_equal(&more, &q, sizeof q);
            assert_memory_equal(other, ratio, bytes);
        }
        const planish_cell_quality without = measure(&m, 2, NULL);
        assert_memory_equal(&without, &q, sizeof q);
        free(ratio);
        free(other);
        loose_cells_destroy(&m);
    }
}

/** Element i alone, with the values of all; 0 if it is of no measured type. */
static int has_values_of_one(const loose_cells *m, int64_t i, const planish_cell_values *v) {
    const int64_t offset[] = {0, m->offset[i + 1] - m->offset[i]};
    const planish_cells one = {
        .n = 1, .type = m->type + i, .offset = offset, .node = m->node + m->offset[i]};
    planish_mesh alone = loose_cells_mesh(m);
    planish_cell_quality q;
    alone.cells = &one;
    alone.n_elements = 1;
    assert_int_equal(planish_measure_cells(&alone, 0, 1, &q, NULL, NULL), PLANISH_OK);
    if (q.all.n_elements == 0) {
        assert_true(v->state[i] == PLANISH_CELL_STATE_NONE && v->is_curved[i] == 0);
        assert_true(v->aspect_ratio[i] == 0 && v->scaled_jacobian[i] == 0);
        assert_true(v->jacobian_ratio[i] == 0 && v->edge_ratio[i] == 0);
        return 0;
    }
    const planish_cell_state state = q.all.n_inverted      ? PLANISH_CELL_STATE_INVERTED
                                     : q.all.n_uncertified ? PLANISH_CELL_STATE_UNCERTIFIED
                                                           : PLANISH_CELL_STATE_VALID;
    assert_int_equal(v->is_curved[i], q.all.n_curved);
    assert_true(v->edge_ratio[i] == q.all.max_edge_ratio);
    if (v->scaled_jacobian[i] <= 0) { /* alone its sign could be another one */
        assert_true(v->is_curved[i] || v->state[i] == PLANISH_CELL_STATE_INVERTED);
        assert_true(v->aspect_ratio[i] == 0);
        assert_true(v->is_curved[i] ? v->jacobian_ratio[i] < 1 : v->jacobian_ratio[i] == 1);
        return 1;
    }
    assert_int_equal(v->state[i], state);
    assert_true(v->aspect_ratio[i] == q.all.max_aspect_ratio);
    assert_true(v->scaled_jacobian[i] == q.all.min_scaled_jacobian);
    assert_true(v->jacobian_ratio[i] == q.all.min_jacobian_ratio);
    return 1;
}

static void values_are_those_of_each_element(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        loose_cells m = loose_cells_mixed(dim, effort(2000, LOOSE_MOST), 18);
        const planish_mesh of = loose_cells_mesh(&m);
        cell_values v = cell_values_make(m.cells.n);
        planish_cell_quality q;
        int64_t n[4] = {0}, n_curved = 0, n_measured = 0;
        assert_int_equal(planish_measure_cells(&of, 0, 2, &q, &v.of, NULL), PLANISH_OK);
        for (int64_t i = 0; i < m.cells.n; i++) {
            n_measured += has_values_of_one(&m, i, &v.of);
            n[v.of.state[i]]++;
            n_curved += v.of.is_curved[i];
        }
        assert_int_equal(n_measured, q.all.n_elements);
        assert_int_equal(n[PLANISH_CELL_STATE_NONE], m.cells.n - n_measured);
        assert_int_equal(n[PLANISH_CELL_STATE_INVERTED], q.all.n_inverted);
        assert_int_equal(n[PLANISH_CELL_STATE_UNCERTIFIED], q.all.n_uncertified);
        assert_int_equal(n_curved, q.all.n_curved);
        assert_true(n[0] > 0 && n[1] > 0 && n[2] > 0 && n_curved > 0);
        for (int k = 0; k < 6; k++) { /* each array alone */
            cell_values some = cell_values_make(m.cells.n);
            const planish_cell_values given = {
                .state = k == 0 ? some.of.state : NULL,
                .is_curved = k == 1 ? some.of.is_curved : NULL,
                .aspect_ratio = k == 2 ? some.of.aspect_ratio : NULL,
                .scaled_jacobian = k == 3 ? some.of.scaled_jacobian : NULL,
                .jacobian_ratio = k == 4 ? some.of.jacobian_ratio : NULL,
                .edge_ratio = k == 5 ? some.of.edge_ratio : NULL};
            const size_t bytes = (size_t)m.cells.n;
            assert_int_equal(planish_measure_cells(&of, 0, 3, &q, &given, NULL), PLANISH_OK);
            for (size_t j = 0; j < 2; j++)
                assert_true((int)j == k
                                ? !memcmp(some.bytes + j * bytes, v.bytes + j * bytes, bytes)
                                : faults_is_marked(some.bytes + j * bytes, bytes));
            for (size_t j = 0; j < 4; j++)
                assert_true((int)j + 2 == k ? !memcmp(some.doubles + j * bytes,
                                                      v.doubles + j * bytes, bytes * sizeof(double))
                                            : faults_is_marked(some.doubles + j * bytes,
                                                               bytes * sizeof(double)));
            cell_values_destroy(&some);
        }
        cell_values_destroy(&v);
        loose_cells_destroy(&m);
    }
}

static void strides_change_nothing(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        loose_cells m = loose_cells_mixed(dim, 500, 19);
        planish_mesh of = loose_cells_mesh(&m);
        planish_cell_quality q[2];
        cell_values v = cell_values_make(m.cells.n), other = cell_values_make(m.cells.n);
        double *x = malloc((size_t)(5 * m.n_nodes) * sizeof *x);
        assert_int_equal(planish_measure_cells(&of, 0, 2, &q[0], &v.of, NULL), PLANISH_OK);
        for (int padded = 0; padded < 2; padded++) {
            of.node_stride = padded ? 5 : 1;
            of.component_stride = padded ? 1 : m.n_nodes;
            of.coordinates = x;
            for (int64_t i = 0; i < m.n_nodes; i++)
                for (int d = 0; d < dim; d++)
                    x[i * of.node_stride + d * of.component_stride] = m.x[i * dim + d];
            assert_int_equal(planish_measure_cells(&of, 0, 2, &q[1], &other.of, NULL), PLANISH_OK);
            assert_memory_equal(&q[0], &q[1], sizeof q[0]);
            cell_values_expect_same(&v, &other);
        }
        free(x);
        cell_values_destroy(&v);
        cell_values_destroy(&other);
        loose_cells_destroy(&m);
    }
}

/** A mesh of simplices: as cells, as elements of either width; and what is refused of these. */
static void simplices_need_no_cells(void **state) {
    (void)state;
    enum { N = 200 };
    uint64_t random = effort_seed(20);
    for (int dim = 2; dim <= 3; dim++) {
        loose_cells m = loose_cells_create(dim);
        for (int i = 0; i < N; i++)
            loose_cells_add(&m, dim == 3 ? 10 : 5, 0.5, 0, 1, &random);
        const int64_t n = m.offset[N];
        int64_t *wide = malloc((size_t)n * sizeof *wide);
        for (int64_t i = 0; i < n; i++)
            wide[i] = m.node[i];
        planish_mesh of = loose_cells_mesh(&m);
        planish_cell_quality q[2];
        planish_error error;
        cell_values v = cell_values_make(N), other = cell_values_make(N);
        assert_int_equal(planish_measure_cells(&of, 0, 2, &q[0], &v.of, NULL), PLANISH_OK);
        of.cells = NULL;
        for (int is_wide = 0; is_wide < 2; is_wide++) {
            of.elements = is_wide ? NULL : m.node;
            of.elements64 = is_wide ? wide : NULL;
            assert_int_equal(planish_measure_cells(&of, 0, 2, &q[1], &other.of, NULL), PLANISH_OK);
            assert_memory_equal(&q[0], &q[1], sizeof q[0]);
            cell_values_expect_same(&v, &other);
        }
        wide[5] = (int64_t)1 << 40;
        assert_int_equal(planish_measure_cells(&of, 0, 2, &q[1], NULL, &error), PLANISH_ERROR_MESH);
        assert_true(error.element == 1 && error.node == wide[5]);
        of.cells = &m.cells; /* beside elements */
        assert_int_equal(planish_measure_cells(&of, 0, 2, &q[1], NULL, &error),
                         PLANISH_ERROR_ARGUMENT);
        of.elements64 = NULL;
        of.n_elements = N - 1; /* the caller's arrays would be too short */
        assert_int_equal(planish_measure_cells(&of, 0, 2, &q[1], NULL, &error),
                         PLANISH_ERROR_ARGUMENT);
        const planish_part part = {.node_number = NULL};
        of.part = &part;
        assert_int_equal(planish_measure_cells(&of, 0, 2, &q[1], NULL, &error),
                         PLANISH_ERROR_PARTS);
        free(wide);
        cell_values_destroy(&v);
        cell_values_destroy(&other);
        loose_cells_destroy(&m);
    }
}

/** Also where the first elements are the ones that are mirrored. */
static void most_elements_of_a_type_have_the_right_handedness(void **state) {
    (void)state;
    enum { N = 12001, MIRRORED = 6000 };
    uint64_t random = effort_seed(14);
    for (int part = 0; part < 2; part++) { /* positive: the majority, or the minority */
        loose_cells m = loose_cells_create(2);
        double *ratio = malloc(2 * N * sizeof *ratio);
        for (int i = 0; i < N; i++)
            loose_cells_add(&m, 9, 0.1, 0, (part == 0) == (i < MIRRORED) ? -1 : 1, &random);
        const planish_cell_quality q = measure(&m, 2, ratio);
        assert_int_equal(q.all.n_inverted, MIRRORED);
        for (int i = 0; i < N; i++)
            assert_true((ratio[i] > 0) == (i >= MIRRORED));
        for (int i = 0; i < 100; i++) /* another type has a handedness of its own */
            loose_cells_add(&m, 5, 0.1, 0, part == 0 ? -1 : 1, &random);
        assert_int_equal(measure(&m, 2, NULL).all.n_inverted, MIRRORED);
        free(ratio);
        loose_cells_destroy(&m);
    }
}

static void other_dimensions_do_not_count(void **state) {
    (void)state;
    uint64_t random = effort_seed(15);
    loose_cells m = loose_cells_create(3);
    double ratio[4];
    loose_cells_add(&m, 12, 0.1, 0, 1, &random);
    loose_cells_add_line(&m);
    m.type[m.cells.n++] = PLANISH_CELL_TRIANGLE;
    for (int i = 0; i < 3; i++)
        m.node[m.offset[m.cells.n - 1] + i] = i;
    m.offset[m.cells.n] = m.offset[m.cells.n - 1] + 3;
    m.type[m.cells.n++] = PLANISH_CELL_VERTEX;
    m.node[m.offset[m.cells.n - 1]] = 7;
    m.offset[m.cells.n] = m.offset[m.cells.n - 1] + 1;
    planish_cell_quality q = measure(&m, 1, ratio);
    assert_int_equal(q.all.n_elements, 1);
    assert_int_equal(q.n_types, 1);
    assert_true(ratio[0] > 1 && ratio[1] == 0 && ratio[2] == 0 && ratio[3] == 0);
    m.cells.n = 0;
    q = measure(&m, 1, ratio);
    assert_int_equal(q.all.n_elements, 0);
    assert_int_equal(q.all.worst_element, -1);
    assert_true(q.all.rms_aspect_ratio == 0 && q.all.min_scaled_jacobian == 0);
    loose_cells_destroy(&m);
}

/** Sizes that are powers of two change no bit, whatever they are; offsets change little. */
static void size_and_place_do_not_matter(void **state) {
    (void)state;
    static const int EXPONENTS[] = {-600, -100, -61, -41, -40, -39, 39, 40, 41, 61, 300, 664, 1015};
    uint64_t random = effort_seed(16);
    for (int k = 0; k < LOOSE_TYPES; k++) {
        loose_cells m = loose_cells_create(pl_cell_type_of(loose_types[k])->shape->dim);
        const int64_t n = m.dim * PL_CELL_NODES;
        double x[3 * PL_CELL_NODES], ratio, other;
        loose_cells_add(&m, loose_types[k], 0.1, 0.02, 1, &random);
        memcpy(x, m.x, (size_t)n * sizeof *x);
        const planish_cell_quality q = measure(&m, 1, &ratio);
        for (size_t i = 0; i < sizeof EXPONENTS / sizeof *EXPONENTS; i++) {
            for (int64_t j = 0; j < n; j++)
                m.x[j] = ldexp(x[j], EXPONENTS[i]);
            const planish_cell_quality scaled = measure(&m, 1, &other);
            assert_true(ratio == other);
            assert_memory_equal(&scaled, &q, sizeof q);
        }
        for (int64_t j = 0; j < n; j++) /* of 1.5 2^1023 or more, so that differences overflow */
            m.x[j] =
                ldexp(x[j] - 0.5, 1023) *
                (pl_cell_type_of(loose_types[k])->shape->n_corners == 4 && m.dim == 3 ? 1 : 1.5);
        const planish_cell_quality huge = measure(&m, 1, &other);
        assert_int_equal(huge.all.n_inverted, q.all.n_inverted);
        assert_true(fabs(ratio - other) < 1e-12);
        for (int64_t j = 0; j < n; j++)
            m.x[j] = x[j] + 1e8;
        assert_int_equal(measure(&m, 1, &other).all.n_inverted, q.all.n_inverted);
        assert_true(fabs(ratio - other) < 1e-6);
        loose_cells_destroy(&m);
    }
}

static void nodes_off_the_middle_make_an_element_curved(void **state) {
    (void)state;
    uint64_t random = 1;
    for (int k = 0; k < LOOSE_TYPES; k++) {
        const pl_cell_type *of = pl_cell_type_of(loose_types[k]);
        if (of->order == 1 || of->shape->n_simplices == 0)
            continue;
        planish_cell_quality q;
        planish_error error;
        loose_cells m = loose_cells_create(of->shape->dim);
        double *off;
        loose_cells_add(&m, loose_types[k], 0, 0, 1, &random);
        off = &m.x[(of->n_nodes - 1) * m.dim];
        *off += 1e-7;
        assert_int_equal(measure(&m, 1, NULL).all.n_curved, 0);
        *off += 1e-3;
        q = measure(&m, 1, NULL);
        assert_int_equal(q.all.n_curved, 1);
        assert_true(q.all.min_jacobian_ratio < 1 && q.all.min_jacobian_ratio > 0.9);
        assert_int_equal(measure_cells(&m.cells, m.dim, m.n_nodes, m.x, 2e-3, 1, &q, NULL, &error),
                         PLANISH_OK);
        assert_int_equal(q.all.n_curved, 0);
        assert_true(q.all.min_jacobian_ratio == 1);
        m.node[of->shape->n_corners] = -1; /* a missing mid is in the middle */
        m.x[of->shape->n_corners * m.dim] += 100;
        assert_int_equal(measure(&m, 1, NULL).all.n_inverted, 0);
        loose_cells_destroy(&m);
    }
}

/** Where nodes that are off by less than rounding invert an element, it is curved all the same. */
static void rounding_hides_no_inverted_element(void **state) {
    (void)state;
    uint64_t random = 1;
    for (int k = 0; k < LOOSE_TYPES; k++) {
        const pl_cell_type *of = pl_cell_type_of(loose_types[k]);
        if (of->order == 1 || of->shape->n_simplices != 1)
            continue;
        loose_cells m = loose_cells_create(of->shape->dim);
        loose_cells_add(&m, loose_types[k], 0, 0, 1, &random);
        const planish_mesh mesh = loose_cells_mesh(&m);
        for (int is_far = 0; is_far < 2; is_far++) {
            double ratio, *mid = &m.x[of->shape->n_corners * m.dim];
            uint8_t is_curved;
            const planish_cell_values values = {.is_curved = &is_curved, .jacobian_ratio = &ratio};
            planish_cell_quality q;
            for (int d = 0; d < m.dim; d++) /* along its edge */
                mid[d] = 0.5 * (m.x[d] + m.x[m.dim + d]) +
                         (is_far ? 0.4 : 0.02) * (m.x[m.dim + d] - m.x[d]);
            assert_int_equal(planish_measure_cells(&mesh, 10, 1, &q, &values, NULL), PLANISH_OK);
            assert_int_equal(q.all.n_inverted, is_far);
            assert_int_equal(q.all.n_inverted_corners, 0);
            assert_int_equal(q.all.n_curved, is_far);
            assert_int_equal(is_curved, is_far);
            assert_true(is_far ? ratio < 0 : ratio == 1);
            assert_true(q.all.min_jacobian_ratio == ratio);
        }
        loose_cells_destroy(&m);
    }
}

/** The straight edges at a corner turn the wrong way, the curved ones do not. */
static void curved_edges_can_make_an_inverted_corner_valid(void **state) {
    (void)state;
    static const int MIDS[][2] = {{5, 1}, {6, 0}}; /* node, its smaller coordinate */
    uint64_t random = 1;
    loose_cells m = loose_cells_create(2);
    double ratio;
    loose_cells_add(&m, PLANISH_CELL_QUADRILATERAL8, 0, 0, 1, &random);
    m.x[2 * 2] = m.x[2 * 2 + 1] = 0.48;
    for (int i = 0; i < 2; i++) {
        m.x[2 * MIDS[i][0] + MIDS[i][1]] = 0.24;
        m.x[2 * MIDS[i][0] + !MIDS[i][1]] = 0.74;
    }
    planish_cell_quality q = measure(&m, 1, &ratio);
    assert_int_equal(q.all.n_inverted_corners, 1);
    assert_int_equal(q.all.n_curved, 0);
    assert_int_equal(q.all.n_inverted, 1);
    for (int i = 0; i < 2; i++) {
        m.x[2 * MIDS[i][0] + MIDS[i][1]] = 0.2;
        m.x[2 * MIDS[i][0] + !MIDS[i][1]] = 0.7;
    }
    q = measure(&m, 1, &ratio);
    assert_int_equal(q.all.n_inverted_corners, 1);
    assert_int_equal(q.all.n_curved, 1);
    assert_int_equal(q.all.n_inverted + q.all.n_uncertified, 0);
    assert_true(q.all.min_jacobian_ratio > 0 && q.all.min_scaled_jacobian < 0);
    assert_true(ratio == 0 && q.all.rms_aspect_ratio == 0); /* no corner ratio exists */
    loose_cells_destroy(&m);
}

/** A hexahedron of which det J touches 0 inside, and a valid one. */
static void touching_zero_is_not_valid(void **state) {
    (void)state;
    uint64_t random = 1;
    loose_cells m = loose_cells_create(3);
    double ratio[2];
    loose_cells_add(&m, 12, 0, 0, 1, &random);
    loose_cells_add(&m, 12, 0, 0, 1, &random);
    for (int i = 4; i < 8; i++) /* the top is turned by 180 degrees */
        for (int d = 0; d < 2; d++)
            m.x[3 * i + d] = 1 - m.x[3 * i + d];
    const planish_cell_quality q = measure(&m, 1, ratio);
    assert_int_equal(q.all.n_inverted + q.all.n_uncertified, 1);
    assert_true(ratio[0] == 0 && ratio[1] > 0);
    loose_cells_destroy(&m);
}

static void wrong_arguments_are_refused(void **state) {
    (void)state;
    enum { ARGUMENT = PLANISH_ERROR_ARGUMENT, MESH = PLANISH_ERROR_MESH };
    uint64_t random = 1;
    loose_cells m = loose_cells_create(2);
    planish_cell_quality q, before;
    planish_error error;
    loose_cells_add(&m, 9, 0, 0, 1, &random);
    const struct {
        const char *name;
        const planish_cells *cells;
        int dim;
        int64_t n_nodes;
        const double *x;
        double rounding;
        int threads;
        planish_cell_quality *quality;
        int code;
    } CASES[] = {
        {"no cells", NULL, 2, 4, m.x, 0, 1, &q, MESH},
        {"no coordinates", &m.cells, 2, 4, NULL, 0, 1, &q, ARGUMENT},
        {"no quality", &m.cells, 2, 4, m.x, 0, 1, NULL, ARGUMENT},
        {"dim 1", &m.cells, 1, 4, m.x, 0, 1, &q, ARGUMENT},
        {"dim 4", &m.cells, 4, 4, m.x, 0, 1, &q, ARGUMENT},
        {"negative nodes", &m.cells, 2, -1, m.x, 0, 1, &q, ARGUMENT},
        {"too many nodes", &m.cells, 2, (int64_t)INT32_MAX + 1, m.x, 0, 1, &q, ARGUMENT},
        {"negative rounding", &m.cells, 2, 4, m.x, -1, 1, &q, ARGUMENT},
        {"rounding is no number", &m.cells, 2, 4, m.x, NAN, 1, &q, ARGUMENT},
        {"negative threads", &m.cells, 2, 4, m.x, 0, -1, &q, ARGUMENT},
        {"too many threads", &m.cells, 2, 4, m.x, 0, 1 << 20, &q, ARGUMENT},
        {"too few nodes", &m.cells, 2, 3, m.x, 0, 1, &q, MESH},
        {"no nodes", &m.cells, 2, 0, NULL, 0, 1, &q, MESH},
    };
    memset(&q, 0x5a, sizeof q);
    before = q;
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        const int status =
            measure_cells(CASES[i].cells, CASES[i].dim, CASES[i].n_nodes, CASES[i].x,
                          CASES[i].rounding, CASES[i].threads, CASES[i].quality, NULL, &error);
        if (status != CASES[i].code || error.code != status || strlen(error.text) < 10)
            fail_msg("%s: %d, %s", CASES[i].name, status, error.text);
        assert_memory_equal(&q, &before, sizeof q);
        assert_int_equal(measure_cells(CASES[i].cells, CASES[i].dim, CASES[i].n_nodes, CASES[i].x,
                                       CASES[i].rounding, CASES[i].threads, CASES[i].quality, NULL,
                                       NULL),
                         status);
    }
    static const double WRONG[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 3; i++) {
        m.x[5] = WRONG[i];
        assert_int_equal(measure_cells(&m.cells, 2, 4, m.x, 0, 1, &q, NULL, &error), MESH);
        assert_int_equal(error.node, 2);
        assert_int_equal(error.element, -1);
    }
    loose_cells_destroy(&m);
}

/** Elements of several types; one is decided by integers, which need memory of their own. */
static void measure_with_faults(const void *world, faults *f) {
    const loose_cells *m = world;
    planish_cell_quality q;
    planish_error error;
    double *ratio = malloc((size_t)m->cells.n * sizeof *ratio);
    int status;
    do {
        faults_mark(&q, sizeof q);
        status = measure_cells(&m->cells, m->dim, m->n_nodes, m->x, 0, 2, &q, ratio, &error);
        assert_true(!status || faults_is_marked(&q, sizeof q));
    } while (faults_refused(f, status, &error));
    faults_add(f, &q, sizeof q);
    faults_add(f, ratio, (size_t)m->cells.n * sizeof *ratio);
    free(ratio);
}

static void failed_allocations_are_refused(void **state) {
    (void)state;
    loose_cells m = loose_cells_mixed(3, 60, 17);
    uint64_t random = 1;
    const int32_t first = loose_cells_add(&m, 12, 0, 0, 1, &random);
    for (int i = 4; i < 8; i++)
        for (int d = 0; d < 2; d++)
            m.x[3 * (first + i) + d] = 1 - m.x[3 * (first + i) + d];
    assert_true(faults_try("planish_measure_cells", measure_with_faults, &m, 30) > 3 * 10);
    loose_cells_destroy(&m);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ideal_elements_have_an_aspect_ratio_of_1),
        cmocka_unit_test(simplices_have_their_mean_ratio),
        cmocka_unit_test(measures_agree_with_plain_loops),
        cmocka_unit_test(values_are_those_of_each_element),
        cmocka_unit_test(strides_change_nothing),
        cmocka_unit_test(simplices_need_no_cells),
        cmocka_unit_test(any_number_of_threads_gives_the_same_bits),
        cmocka_unit_test(most_elements_of_a_type_have_the_right_handedness),
        cmocka_unit_test(other_dimensions_do_not_count),
        cmocka_unit_test(size_and_place_do_not_matter),
        cmocka_unit_test(nodes_off_the_middle_make_an_element_curved),
        cmocka_unit_test(rounding_hides_no_inverted_element),
        cmocka_unit_test(curved_edges_can_make_an_inverted_corner_valid),
        cmocka_unit_test(touching_zero_is_not_valid),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(failed_allocations_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
