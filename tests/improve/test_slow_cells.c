/* Newton's steps on a lattice in meshes of cells (improve/coarse.c): boxes that are drawn out smoothly.
 * Cells are judged by planish_measure_cells, which has code of its own. */
#include "support/cell_meshes.h"
#include "support/effort.h"
#include "support/run.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Sweeps until centring would come, and cells along the edges of boxes. */
enum { PATIENCE = 20, IN_PLANE = 40, IN_SPACE = 11 };
/* Of ratios that planish and the judge compute differently. */
#define NOISE 1e-9

static cell_box_kind hexahedra = BOX_HEXAHEDRA, wedges = BOX_WEDGES, mixed = BOX_MIXED;
static cell_box_kind quadrilaterals = BOX_QUADRILATERALS, mixed_2d = BOX_MIXED_2D;

/** Rows of a table of cmocka: test with boxes of all kinds. */
#define WITH_ALL(test)                                                                             \
    {#test " hexahedra", test, NULL, NULL, &hexahedra},                                            \
        {#test " wedges", test, NULL, NULL, &wedges}, {#test " mixed", test, NULL, NULL, &mixed},  \
        {#test " quadrilaterals", test, NULL, NULL, &quadrilaterals}, {                            \
#test " mixed 2-D", test, NULL, NULL, &mixed_2d                                            \
    }

static int is_flat(cell_box_kind kind) {
    return kind == BOX_QUADRILATERALS || kind == BOX_MIXED_2D;
}

static int cells_along(cell_box_kind kind) {
    return is_flat(kind) ? IN_PLANE : IN_SPACE;
}

/** Draw the nodes inside of a box of n cells along its edges to corner 0. */
static void squeeze(cell_box *box, int n) {
    const int dim = box->mesh.dim;
    for (int64_t i = 0; i < box->mesh.n_nodes; i++) {
        double *x = box->x + i * dim, inside = 1;
        for (int d = 0; d < dim; d++)
            inside *= 4 * x[d] / n * (1 - x[d] / n);
        for (int d = 0; d < dim; d++)
            x[d] = n * pow(x[d] / n, 1 + 0.8 * inside);
    }
}

/** A squeezed box; all its cells are valid. */
static cell_box *squeezed_box(cell_box_kind kind) {
    cell_box *box = cell_box_create(kind, cells_along(kind));
    squeeze(box, cells_along(kind));
    return box;
}

static planish_cell_measures judge(const cell_box *box, const double *coordinates) {
    planish_mesh mesh = box->mesh;
    planish_cell_quality quality;
    mesh.coordinates = coordinates;
    assert_int_equal(planish_measure_cells(&mesh, 0, 1, &quality, NULL, NULL), 0);
    return quality.all;
}

/** What the log and the progress told of a call. */
typedef struct heard {
    int n_steps, n_calls, first; /* calls of the progress function; those before the steps */
    int stop_at;                 /* the call that ends it; 0: none */
    int n_sweeps, has_risen;
    double rms;
} heard;

static void note_log(planish_log_level level, const char *text, void *user) {
    heard *h = user;
    (void)level;
    if (!strstr(text, "Newton's steps"))
        return;
    h->n_steps++;
    h->first = h->n_calls;
}

static int note_progress(const planish_progress *progress, void *user) {
    heard *h = user;
    if (progress->sweep_done) {
        h->has_risen |= h->n_sweeps++ > 0 && progress->rms > h->rms * (1 + 1e-12);
        h->rms = progress->rms;
    }
    return ++h->n_calls == h->stop_at;
}

/** Smooth a copy of the coordinates of box, which is to be freed. */
static double *smooth(const cell_box *box, planish_options options, heard *h,
                      planish_result *result) {
    double *x = test_copy_of(&box->mesh);
    planish_plan *plan;
    options.progress = note_progress;
    options.progress_user = h;
    options.log = note_log;
    options.log_user = h;
    assert_int_equal(planish_plan_create(&box->mesh, &options, &plan, NULL), 0);
    assert_int_equal(planish_smooth(plan, x, &options, result, NULL), 0);
    planish_plan_destroy(plan);
    return x;
}

/** Cells at coordinates x are valid, and none is worse than the worst of box. */
static planish_cell_measures check_cells(const cell_box *box, const double *x) {
    const planish_cell_measures before = judge(box, box->x), after = judge(box, x);
    assert_int_equal(before.n_inverted, 0);
    assert_int_equal(after.n_inverted, 0);
    assert_int_equal(after.n_uncertified, 0);
    assert_true(after.rms_aspect_ratio < before.rms_aspect_ratio);
    assert_true(after.max_aspect_ratio <= before.max_aspect_ratio * (1 + NOISE));
    assert_true(after.min_scaled_jacobian >= before.min_scaled_jacobian * (1 - NOISE));
    return after;
}

/** AR of the box as it is before it is squeezed, and smoothed. */
static double rms_of_regular_box(cell_box_kind kind) {
    cell_box *box = cell_box_create(kind, cells_along(kind));
    heard h = {0};
    planish_result result;
    double *x = smooth(box, test_options(1), &h, &result);
    const double rms = judge(box, x).rms_aspect_ratio;
    free(x);
    cell_box_destroy(box);
    return rms;
}

static void a_lattice_helps_early(void **state) {
    const cell_box_kind kind = *(cell_box_kind *)*state;
    cell_box *box = squeezed_box(kind);
    heard h = {0};
    planish_result result;
    double *x = smooth(box, test_options(1), &h, &result);
    assert_true(h.n_steps >= 1);
    assert_false(h.has_risen);
    assert_int_equal(result.stop, PLANISH_STOP_CONVERGED);
    assert_true(check_cells(box, x).rms_aspect_ratio < 1.001 * rms_of_regular_box(kind));
    assert_true(result.sweeps < 2 * PATIENCE);
    free(x);
    cell_box_destroy(box);
}

/** Threads and instruction sets change no bit. */
static void same_bits(void **state) {
    cell_box *box = squeezed_box(*(cell_box_kind *)*state);
    planish_options options = test_options(1);
    planish_result result;
    heard h = {0};
    options.isa = PLANISH_ISA_PLAIN;
    double *one = smooth(box, options, &h, &result);
    assert_true(h.n_steps >= 1);
    options.isa = PLANISH_ISA_AUTO;
    for (options.threads = 2; options.threads <= 3; options.threads++) {
        double *other = smooth(box, options, &h, &result);
        assert_memory_equal(one, other, test_bytes_of(&box->mesh));
        free(other);
    }
    free(one);
    cell_box_destroy(box);
}

/** A box that is larger by a power of two has the same bits, times that power. */
static void powers_of_two_change_no_bit(void **state) {
    static const int EXPONENTS[] = {-200, -9, 200};
    cell_box *box = squeezed_box(*(cell_box_kind *)*state);
    const int64_t n = box->mesh.n_nodes * box->mesh.dim;
    double *given = test_copy_of(&box->mesh);
    planish_result result;
    heard h = {0};
    double *one = smooth(box, test_options(1), &h, &result);
    for (size_t k = 0; k < sizeof EXPONENTS / sizeof *EXPONENTS; k++) {
        for (int64_t i = 0; i < n; i++)
            box->x[i] = ldexp(given[i], EXPONENTS[k]);
        double *other = smooth(box, test_options(1), &h, &result);
        for (int64_t i = 0; i < n; i++)
            assert_true(other[i] == ldexp(one[i], EXPONENTS[k]));
        free(other);
    }
    assert_true(h.n_steps >= 1 + (int)(sizeof EXPONENTS / sizeof *EXPONENTS));
    free(given);
    free(one);
    cell_box_destroy(box);
}

/** Any answer of the progress function may end the steps: the mesh is valid then. */
static void they_end_at_any_call(void **state) {
    enum { ANSWERS = 40 };
    cell_box *box = squeezed_box(*(cell_box_kind *)*state);
    planish_result result;
    heard h = {0};
    free(smooth(box, test_options(1), &h, &result));
    const int first = h.first;
    assert_true(h.n_steps >= 1 && first > 0);
    for (int k = 1; k < ANSWERS; k += 3 * effort_step(2)) {
        h = (heard){.stop_at = first + k};
        double *x = smooth(box, test_options(1), &h, &result);
        assert_int_equal(result.stop, PLANISH_STOP_INTERRUPTED);
        if (result.n_put_back == 0)
            assert_true(result.rms <= h.rms * (1 + 1e-12));
        check_cells(box, x);
        free(x);
    }
    cell_box_destroy(box);
}

/** Warp a box along its surface. */
static void warp(cell_box *box, int n) {
    const int dim = box->mesh.dim;
    const double PI = acos(-1);
    for (int64_t i = 0; i < box->mesh.n_nodes; i++) {
        double *x = box->x + i * dim, y[3] = {0};
        for (int d = 0; d < dim; d++)
            y[d] = x[d] / n;
        for (int d = 0; d < dim; d++)
            if (y[d] > 0 && y[d] < 1)
                x[d] += 0.2 * n * sin(PI * y[d]) * cos(PI * y[(d + 1) % dim]);
    }
}

/** Where the surface slides, a box that is warped along it becomes even. */
static void nodes_that_slide_make_steps(void **state) {
    const cell_box_kind kind = *(cell_box_kind *)*state;
    const int n = cells_along(kind);
    cell_box *box = cell_box_create(kind, n);
    const int64_t n_values = box->mesh.n_nodes * box->mesh.dim;
    uint8_t *constraint = malloc((size_t)box->mesh.n_nodes);
    double *direction = malloc((size_t)n_values * sizeof *direction);
    planish_options options = test_options(1);
    planish_result result;
    heard h = {0};
    warp(box, n);
    assert_int_equal(planish_find_slides(&box->mesh, NULL, 1, constraint, direction, NULL, NULL),
                     0);
    box->mesh.constraint = constraint;
    box->mesh.direction = direction;
    double *x = smooth(box, options, &h, &result);
    assert_true(h.n_steps >= 1);
    assert_int_equal(result.stop, PLANISH_STOP_CONVERGED);
    assert_true(result.sweeps < 2 * PATIENCE);
    assert_true(check_cells(box, x).rms_aspect_ratio < 1.001 * rms_of_regular_box(kind));
    for (int64_t i = 0; i < n_values; i++)
        if (box->x[i] == 0 || box->x[i] == n)
            assert_true(x[i] == box->x[i]);
    options.isa = PLANISH_ISA_PLAIN;
    options.threads = 3;
    double *other = smooth(box, options, &h, &result);
    assert_memory_equal(x, other, test_bytes_of(&box->mesh));
    free(x);
    free(other);
    free(constraint);
    free(direction);
    cell_box_destroy(box);
}

/** Rough meshes, which converge soon, and cells of order 2 see no lattice. */
static void others_see_no_lattice(void **state) {
    const cell_box_kind kind = *(cell_box_kind *)*state;
    planish_options options = test_options(1);
    planish_result result;
    heard h = {0};
    cell_box *rough = cell_box_create(kind, cells_along(kind));
    cell_box_shake(rough, 0.14, 3);
    free(smooth(rough, options, &h, &result));
    assert_int_equal(h.n_steps, 0);
    cell_box *box = squeezed_box(kind), *raised = cell_box_raise(box, 0);
    options.max_sweeps = PATIENCE;
    free(smooth(raised, options, &h, &result));
    assert_int_equal(h.n_steps, 0);
    cell_box_destroy(rough);
    cell_box_destroy(box);
    cell_box_destroy(raised);
}

/* ---- cells that are inverted inside ------------------------------------------------------------ */

enum { TWISTED = 14, EVERY = 3, N_TWISTS = 2, HEX_CORNERS = 8 };

/* Displacements of the corners of a cube that invert its inside; times NEARLY they do not yet. Its corners and
 * all cubes around stay positive. */
#define NEARLY 0.92
static const double twist[N_TWISTS][HEX_CORNERS][3] = {{{-0.130, -0.032, -0.616},
                                                        {-0.676, 0.572, -0.160},
                                                        {-0.528, -0.144, -0.115},
                                                        {-0.006, 0.348, 0.303},
                                                        {-0.467, -0.009, 0.401},
                                                        {-1.239, 0.061, 0.256},
                                                        {0.068, -0.132, 0.118},
                                                        {-0.004, 0.380, 0.103}},
                                                       {{0.247, -0.557, -0.182},
                                                        {0.058, -0.266, -0.422},
                                                        {0.032, -0.009, -0.895},
                                                        {0.569, -0.249, 0.239},
                                                        {-0.471, -0.171, -0.392},
                                                        {0.058, 0.449, -0.026},
                                                        {0.480, -0.093, -0.154},
                                                        {0.619, -0.078, -0.482}}};

/** Twist every third cell along each direction; hold half of the nodes of those that are nearly inverted. */
static void twist_cells(cell_box *box, int seed, uint8_t *constraint) {
    int turn = seed;
    for (int64_t k = 2; k < TWISTED - 2; k += EVERY)
        for (int64_t j = 2; j < TWISTED - 2; j += EVERY)
            for (int64_t i = 2; i < TWISTED - 2; i += EVERY, turn++) {
                const int32_t *node = box->node + box->offset[i + TWISTED * (j + TWISTED * k)];
                const int is_inverted = turn % 16 == 0;
                for (int c = 0; c < HEX_CORNERS && turn % 4 == 0; c++) {
                    for (int d = 0; d < 3; d++)
                        box->x[3 * (int64_t)node[c] + d] +=
                            (is_inverted ? 1 : NEARLY) * twist[turn / 4 % N_TWISTS][c][d];
                    if (!is_inverted && (c + turn / 8) % 2)
                        constraint[node[c]] = PLANISH_CONSTRAINT_FIXED;
                }
            }
    squeeze(box, TWISTED);
}

/** Find the state [n] of each cell at x. Returns how many are inverted; *n_corners by their corners. */
static int64_t find_states(const cell_box *box, const double *x, uint8_t *state,
                           int64_t *n_corners) {
    planish_mesh mesh = box->mesh;
    planish_cell_quality quality;
    const planish_cell_values values = {.state = state};
    mesh.coordinates = x;
    assert_int_equal(planish_measure_cells(&mesh, 0, 1, &quality, &values, NULL), 0);
    *n_corners = quality.all.n_inverted_corners;
    return quality.all.n_inverted;
}

/** Without untangling no cell is repaired at the cost of a valid one, though sweeps have repaired some before
 *  the steps. */
static void no_valid_cell_is_spent(void **state) {
    planish_options options = test_options(1);
    (void)state;
    options.untangle = 0;
    for (int seed = 0; seed < 4; seed++) {
        cell_box *box = cell_box_create(BOX_HEXAHEDRA, TWISTED);
        const size_t n = (size_t)box->mesh.n_elements;
        uint8_t *constraint = calloc((size_t)box->mesh.n_nodes, 1), *before = malloc(n),
                *after = malloc(n);
        planish_result result;
        int64_t n_corners;
        heard h = {0};
        twist_cells(box, seed, constraint);
        box->mesh.constraint = constraint;
        const int64_t n_before = find_states(box, box->x, before, &n_corners);
        assert_true(n_before > n_corners);
        double *x = smooth(box, options, &h, &result);
        assert_true(h.n_steps >= 1);
        assert_true(find_states(box, x, after, &n_corners) < n_before);
        for (size_t i = 0; i < n; i++)
            if (before[i] == PLANISH_CELL_STATE_VALID && after[i] != PLANISH_CELL_STATE_VALID)
                fail_msg("seed %d: cell %zu", seed, i);
        free(x);
        free(constraint);
        free(before);
        free(after);
        cell_box_destroy(box);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        WITH_ALL(a_lattice_helps_early),
        WITH_ALL(same_bits),
        WITH_ALL(powers_of_two_change_no_bit),
        WITH_ALL(they_end_at_any_call),
        WITH_ALL(nodes_that_slide_make_steps),
        cmocka_unit_test(no_valid_cell_is_spent),
        {"others see no lattice hexahedra", others_see_no_lattice, NULL, NULL, &hexahedra},
        {"others see no lattice quadrilaterals", others_see_no_lattice, NULL, NULL,
         &quadrilaterals},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
