/* A lattice (improve/lattice.h) against plain references: affine displacements, differences of the
 * sum of RR^2, and the equations that conjugate gradients solve. */
#include "geometry/simplex.h"
#include "improve/lattice.h"
#include "support/allocations.h"
#include "support/effort.h"
#include "support/meshes.h"
#include "support/run.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { CELLS = 12, CORNERS = 4, ROW = PL_LATTICE_BLOCKS * PL_LATTICE_BLOCK };
#define SPACING 2.5

/** A mesh, its plan and a lattice over it. */
typedef struct setting {
    test_mesh mesh;
    planish_plan *plan;
    pl_lattice lattice;
} setting;

static void plan_mesh(setting *s, planish_isa isa, int threads) {
    planish_options options = test_options(threads);
    options.isa = isa;
    assert_int_equal(planish_plan_create(&s->mesh.mesh, &options, &s->plan, NULL), 0);
    pl_plan_order(s->plan, s->mesh.coordinates, s->plan->scratch.coordinates);
}

static void begin(setting *s, planish_isa isa, int threads) {
    plan_mesh(s, isa, threads);
    assert_int_equal(pl_lattice_create(s->plan, SPACING, &s->lattice), 1);
    pl_lattice_sort(&s->lattice);
    pl_lattice_assemble(&s->lattice);
}

/** Free all but the mesh. */
static void end(setting *s) {
    pl_lattice_destroy(&s->lattice);
    planish_plan_destroy(s->plan);
}

/** A rough box: its elements belong to the finest grid. */
static void rough_box(setting *s) {
    test_mesh_box(&s->mesh, 3, CELLS);
    test_mesh_perturb(&s->mesh, 0.1, 7);
}

/** A box whose elements grow from a corner, up to 100 times in volume: several grids have some. */
static void graded_box(setting *s) {
    test_mesh_box(&s->mesh, 3, CELLS);
    for (int64_t i = 0; i < s->mesh.mesh.n_nodes * 3; i++)
        s->mesh.coordinates[i] = CELLS * pow(s->mesh.coordinates[i] / CELLS, 5);
}

static int64_t stars_of(const setting *s) {
    return s->plan->interior.stars.n_stars;
}

static void set_random(double *values, int64_t n, unsigned seed) {
    for (int64_t i = 0; i < n; i++)
        values[i] = 2 * test_random(&seed) - 1;
}

/** Place of a vertex in units of the lattice. */
static void find_vertex(const pl_grid *g, int64_t vertex, double x[3]) {
    x[0] = (double)(vertex % g->n[0]) / g->per_spacing;
    x[1] = (double)(vertex / g->n[0] % g->n[1]) / g->per_spacing;
    x[2] = (double)(vertex / g->n[0] / g->n[1]) / g->per_spacing;
}

/* ---- displacements --------------------------------------------------------------------------- */

/** Displacement of an affine field. */
static void affine_at(const double x[3], double to[3]) {
    static const double A[3][4] = {{0.3, -0.1, 0.2, 1}, {0.05, 0.4, -0.3, 2}, {-0.2, 0.1, 0.6, -1}};
    for (int r = 0; r < 3; r++)
        to[r] = A[r][3] + A[r][0] * x[0] + A[r][1] * x[1] + A[r][2] * x[2];
}

/** An affine field by the vertices of all grids is that field at all nodes. */
static void nodes_follow_affine_fields(void **state) {
    (void)state;
    setting s;
    graded_box(&s);
    begin(&s, PLANISH_ISA_AUTO, 2);
    const pl_lattice *l = &s.lattice;
    int n_owners = 0;
    for (int i = 0; i < l->n_levels; i++) {
        n_owners += l->grid[i].has_own;
        for (int64_t v = 0; v < l->grid[i].n_vertices; v++) {
            double x[3];
            find_vertex(&l->grid[i], v, x);
            affine_at(x, l->grid[i].total + v * 3);
        }
    }
    assert_true(n_owners >= 2);
    double *move = malloc((size_t)stars_of(&s) * 3 * sizeof *move);
    pl_lattice_prolong(l, move);
    for (int64_t k = 0; k < stars_of(&s); k++) {
        const double *x = s.plan->scratch.coordinates + s.plan->interior.centre[k] * (int64_t)3;
        double unit[3], expected[3];
        for (int d = 0; d < 3; d++)
            unit[d] = (x[d] - l->origin[d]) / l->spacing;
        affine_at(unit, expected);
        for (int d = 0; d < 3; d++)
            assert_true(fabs(move[k * 3 + d] / l->spacing - expected[d]) < 1e-9);
    }
    free(move);
    end(&s);
    test_mesh_destroy(&s.mesh);
}

/** Forces do the same work on the vertices as on the nodes. */
static void forces_do_the_same_work(void **state) {
    (void)state;
    setting s;
    graded_box(&s);
    begin(&s, PLANISH_ISA_AUTO, 2);
    const int64_t n = stars_of(&s) * 3;
    double *force = malloc((size_t)n * sizeof *force), *move = malloc((size_t)n * sizeof *move);
    double of_nodes = 0, of_vertices = 0, size = 0;
    set_random(force, n, 3);
    assert_int_equal(pl_lattice_restrict(&s.lattice, force), 1);
    for (int i = 0; i < s.lattice.n_levels; i++) {
        const pl_grid *g = &s.lattice.grid[i];
        set_random(g->total, g->n_vertices * 3, 4 + (unsigned)i);
        for (int64_t k = 0; k < g->n_vertices * 3; k++)
            of_vertices += g->force[k] * g->total[k];
    }
    pl_lattice_prolong(&s.lattice, move);
    for (int64_t k = 0; k < n; k++) {
        of_nodes += force[k] * move[k];
        size += fabs(force[k] * move[k]);
    }
    assert_true(fabs(of_nodes - of_vertices) < 1e-9 * size);
    free(force);
    free(move);
    end(&s);
    test_mesh_destroy(&s.mesh);
}

/** No forces, and forces beyond what sums of doubles hold, are refused. */
static void no_forces_are_refused(void **state) {
    static const double refused[] = {0, 1e-300, 1e300, INFINITY};
    (void)state;
    setting s;
    rough_box(&s);
    begin(&s, PLANISH_ISA_AUTO, 1);
    double *force = calloc((size_t)stars_of(&s) * 3, sizeof *force);
    for (size_t k = 0; k < sizeof refused / sizeof *refused; k++) {
        force[5] = refused[k];
        assert_int_equal(pl_lattice_restrict(&s.lattice, force), 0);
    }
    force[5] = 1;
    assert_int_equal(pl_lattice_restrict(&s.lattice, force), 1);
    free(force);
    end(&s);
    test_mesh_destroy(&s.mesh);
}

/* ---- the Hessian ------------------------------------------------------------------------------ */

/** Set y to K x for the stiffness of a grid, block by block. */
static void multiply(const pl_grid *g, const double *x, double *y) {
    memset(y, 0, (size_t)g->n_vertices * 3 * sizeof *y);
    for (int64_t v = 0; v < g->n_vertices; v++)
        for (int bits = 0; bits < PL_LATTICE_BLOCKS; bits++) {
            const int64_t to =
                v + (bits & 1) + (bits >> 1 & 1) * g->n[0] + (bits >> 2 & 1) * g->n[0] * g->n[1];
            const double *k = g->stiffness + v * ROW + bits * PL_LATTICE_BLOCK;
            if (to >= g->n_vertices)
                continue;
            for (int r = 0; r < 3; r++)
                for (int c = 0; c < 3; c++) {
                    y[v * 3 + r] += k[r * 3 + c] * x[to * 3 + c];
                    if (bits > 0)
                        y[to * 3 + c] += k[r * 3 + c] * x[v * 3 + r];
                }
        }
}

/** Displacement at x, in units, of the simplex of the finest grid that middle is in. */
static void displacement_at(const pl_grid *g, const double middle[3], const double x[3],
                            double to[3]) {
    int order[3] = {0, 1, 2};
    int64_t stride[3] = {1, g->n[0], g->n[0] * g->n[1]}, vertex = 0;
    double corner[3];
    for (int d = 0; d < 3; d++) {
        corner[d] = floor(middle[d]);
        vertex += (int64_t)corner[d] * stride[d];
    }
    for (int i = 0; i < 3; i++) /* the direction in which it is furthest along comes first */
        for (int k = i + 1; k < 3; k++)
            if (middle[order[k]] - corner[order[k]] > middle[order[i]] - corner[order[i]]) {
                const int first = order[i];
                order[i] = order[k];
                order[k] = first;
            }
    memcpy(to, g->total + vertex * 3, 3 * sizeof *to);
    for (int i = 0; i < 3; i++) {
        const int64_t next = vertex + stride[order[i]];
        for (int d = 0; d < 3; d++)
            to[d] += (x[order[i]] - corner[order[i]]) *
                     (g->total[next * 3 + d] - g->total[vertex * 3 + d]);
        vertex = next;
    }
}

/** Sum of RR^2 over the elements when each has gone the part t as its simplex goes. */
static double sum_at(const setting *s, double t) {
    const pl_lattice *l = &s->lattice;
    double sum = 0;
    for (int64_t i = 0; i < s->mesh.mesh.n_elements; i++) {
        double unit[CORNERS][3], middle[3] = {0};
        const double *vertex[CORNERS];
        for (int j = 0; j < CORNERS; j++) {
            const double *x = s->mesh.coordinates + s->mesh.elements[i * CORNERS + j] * (int64_t)3;
            vertex[j] = unit[j];
            for (int d = 0; d < 3; d++) {
                unit[j][d] = (x[d] - l->origin[d]) / l->spacing;
                middle[d] += unit[j][d] / CORNERS;
            }
        }
        for (int j = 0; j < CORNERS; j++) {
            double move[3];
            displacement_at(&l->grid[0], middle, unit[j], move);
            const int is_free = l->is_free[s->plan->inner[s->mesh.elements[i * CORNERS + j]]];
            for (int d = 0; is_free && d < 3; d++)
                unit[j][d] += t * move[d];
        }
        sum += pl_radius_ratio_square(3, vertex);
    }
    return sum;
}

/** Set random moves of the vertices that are far enough from the surface for whole rows of elements. */
static void set_inner_moves(const setting *s, double *move) {
    const pl_lattice *l = &s->lattice;
    const pl_grid *g = &l->grid[0];
    set_random(move, g->n_vertices * 3, 9);
    for (int64_t v = 0; v < g->n_vertices; v++) {
        double x[3];
        int inside = 1;
        find_vertex(g, v, x);
        for (int d = 0; d < 3; d++) {
            const double at = l->origin[d] + x[d] * l->spacing;
            inside &= at > 1 && at < CELLS - 1;
        }
        for (int d = 0; !inside && d < 3; d++)
            move[v * 3 + d] = 0;
    }
}

/** The stiffness is the second derivative of the sum of RR^2. */
static void stiffness_is_the_bend_of_the_sum(void **state) {
    (void)state;
    setting s;
    rough_box(&s);
    begin(&s, PLANISH_ISA_AUTO, 1);
    const pl_grid *g = &s.lattice.grid[0];
    double expected = 0;
    for (int i = 1; i < s.lattice.n_levels; i++)
        assert_false(s.lattice.grid[i].has_own);
    set_inner_moves(&s, g->total);
    multiply(g, g->total, g->change);
    for (int64_t k = 0; k < g->n_vertices * 3; k++)
        expected += g->total[k] * g->change[k];
    const double t = 0x1p-12;
    const double bend = (sum_at(&s, t) - 2 * sum_at(&s, 0) + sum_at(&s, -t)) / (t * t);
    assert_true(expected > 1);
    assert_true(fabs(bend - expected) < 1e-4 * expected);
    end(&s);
    test_mesh_destroy(&s.mesh);
}

/** Instruction sets and threads change no bit of it, and flat elements leave it finite. */
static void stiffness_has_the_same_bits(void **state) {
    (void)state;
    setting one, other;
    graded_box(&one);
    const int64_t inside = (CELLS / 2 * (CELLS + 1) + CELLS / 2) * (CELLS + 1) + CELLS / 2;
    memcpy(one.mesh.coordinates + inside * 3, one.mesh.coordinates + (inside + 1) * 3,
           3 * sizeof(double));
    other.mesh = one.mesh;
    begin(&one, PLANISH_ISA_PLAIN, 1);
    begin(&other, PLANISH_ISA_AUTO, 3);
    assert_int_equal(one.lattice.n_levels, other.lattice.n_levels);
    for (int i = 0; i < one.lattice.n_levels; i++) {
        const pl_grid *g = &one.lattice.grid[i];
        assert_memory_equal(g->stiffness, other.lattice.grid[i].stiffness,
                            (size_t)g->n_vertices * ROW * sizeof(double));
        for (int64_t k = 0; k < g->n_vertices * ROW; k++)
            assert_true(isfinite(g->stiffness[k]));
    }
    end(&one);
    end(&other);
    test_mesh_destroy(&one.mesh);
}

/* ---- the solution ----------------------------------------------------------------------------- */

static int never(void *context) {
    int *n_asked = context;
    ++*n_asked;
    return 0;
}

static int at_once(void *context) {
    (void)context;
    return PLANISH_STOP_INTERRUPTED;
}

/** What conjugate gradients find solves the equations of the active vertices. */
static void moves_balance_the_forces(void **state) {
    (void)state;
    setting s;
    rough_box(&s);
    begin(&s, PLANISH_ISA_AUTO, 2);
    const pl_grid *g = &s.lattice.grid[0];
    const size_t size = (size_t)g->n_vertices * 3 * sizeof(double);
    double *force = malloc((size_t)stars_of(&s) * 3 * sizeof *force), *given = malloc(size);
    double *product = malloc(size), rest2 = 0, given2 = 0;
    int n_asked = 0, n_active = 0;
    set_random(force, stars_of(&s) * 3, 11);
    assert_int_equal(pl_lattice_restrict(&s.lattice, force), 1);
    memcpy(given, g->force, size);
    assert_int_equal(pl_lattice_solve(&s.lattice, 1e-7, 60, never, &n_asked), 0);
    multiply(g, g->total, product);
    for (int64_t k = 0; k < g->n_vertices * 3; k++)
        if (g->is_active[k / 3]) {
            n_active++;
            given2 += given[k] * given[k];
            rest2 += (given[k] - product[k]) * (given[k] - product[k]);
        }
    assert_true(n_active > 3 * 64);
    assert_true(n_asked > 1 && n_asked < 40);
    assert_true(rest2 < 1e-10 * given2);
    free(force);
    free(given);
    free(product);
    end(&s);
    test_mesh_destroy(&s.mesh);
}

static void a_solution_is_cut_short(void **state) {
    (void)state;
    setting s;
    rough_box(&s);
    begin(&s, PLANISH_ISA_AUTO, 1);
    double *force = malloc((size_t)stars_of(&s) * 3 * sizeof *force);
    set_random(force, stars_of(&s) * 3, 11);
    assert_int_equal(pl_lattice_restrict(&s.lattice, force), 1);
    assert_int_equal(pl_lattice_solve(&s.lattice, 1e-7, 60, at_once, NULL),
                     PLANISH_STOP_INTERRUPTED);
    free(force);
    end(&s);
    test_mesh_destroy(&s.mesh);
}

/* ---- memory ----------------------------------------------------------------------------------- */

/** Whichever allocation fails, the lattice is none, and is freed. */
static void without_memory_there_is_no_lattice(void **state) {
    (void)state;
    setting s;
    int n_failed = 0, ready = 0;
    rough_box(&s);
    plan_mesh(&s, PLANISH_ISA_AUTO, 1);
    while (!ready) {
        allocations_fail_one(n_failed);
        ready = pl_lattice_create(s.plan, SPACING, &s.lattice);
        assert_int_equal(!ready, allocations_failed());
        n_failed += !ready;
        pl_lattice_destroy(&s.lattice);
    }
    assert_true(n_failed > 20);
    planish_plan_destroy(s.plan);
    test_mesh_destroy(&s.mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nodes_follow_affine_fields),
        cmocka_unit_test(forces_do_the_same_work),
        cmocka_unit_test(no_forces_are_refused),
        cmocka_unit_test(stiffness_is_the_bend_of_the_sum),
        cmocka_unit_test(stiffness_has_the_same_bits),
        cmocka_unit_test(moves_balance_the_forces),
        cmocka_unit_test(a_solution_is_cut_short),
        cmocka_unit_test(without_memory_there_is_no_lattice),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
