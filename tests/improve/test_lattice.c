/* A lattice (improve/lattice.h) against plain references: affine displacements, differences of the
 * sum of RR^2, or AR^2 of cells, and the equations that conjugate gradients solve; in the plane and in space. */
#include "geometry/corner.h"
#include "geometry/simplex.h"
#include "improve/lattice.h"
#include "improve/lattice_stiffness.h"
#include "support/allocations.h"
#include "support/both.h"
#include "support/cell_meshes.h"
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

enum {
    CELLS = 12, /* along each edge of a box in space */
    SOME = 2    /* elements that one in the Hessian stands for, where not all are in it */
};
#define SPACING 2.5

/** A mesh, its plan and a lattice over it. */
typedef struct setting {
    test_mesh mesh;
    cell_box *box;       /* NULL, or in the place of mesh */
    uint8_t *constraint; /* [n_nodes] and */
    double *direction;   /* [n_nodes][dim] how nodes slide; NULL: none does */
    planish_plan *plan;
    pl_lattice lattice;
} setting;

static const planish_mesh *mesh_of(const setting *s) {
    return s->box ? &s->box->mesh : &s->mesh.mesh;
}

static void plan_mesh(setting *s, planish_isa isa, int threads) {
    planish_mesh mesh = *mesh_of(s);
    planish_options options = test_options(threads);
    options.isa = isa;
    mesh.constraint = s->constraint;
    mesh.direction = s->direction;
    assert_int_equal(planish_plan_create(&mesh, &options, &s->plan, NULL), 0);
    pl_plan_order(s->plan, mesh.coordinates, s->plan->scratch.coordinates);
}

/** Let nodes slide on the planes and lines of the surface. */
static void let_slide(setting *s) {
    const planish_mesh *mesh = mesh_of(s);
    s->constraint = malloc((size_t)mesh->n_nodes);
    s->direction = malloc((size_t)(mesh->n_nodes * mesh->dim) * sizeof *s->direction);
    assert_int_equal(planish_find_slides(mesh, NULL, 1, s->constraint, s->direction, NULL, NULL),
                     0);
}

static void free_slides(setting *s) {
    free(s->constraint);
    free(s->direction);
}

static void begin(setting *s, planish_isa isa, int threads, int one_in) {
    plan_mesh(s, isa, threads);
    assert_int_equal(
        pl_lattice_create(s->plan, SPACING, one_in, s->constraint != NULL, NULL, &s->lattice), 1);
    pl_lattice_sort(&s->lattice);
    pl_lattice_assemble(&s->lattice);
}

/** Free all but the mesh. */
static void end(setting *s) {
    pl_lattice_destroy(&s->lattice);
    planish_plan_destroy(s->plan);
}

static int cells_along(int dim) {
    return dim == 2 ? 3 * CELLS : CELLS;
}

/** A rough box: its elements belong to the finest grid. */
static void rough_box(setting *s, int dim) {
    *s = (setting){.box = NULL};
    test_mesh_box(&s->mesh, dim, cells_along(dim));
    test_mesh_perturb(&s->mesh, 0.1, 7);
}

/** A box whose elements grow from a corner, up to 100 times in measure: several grids have some. */
static void graded_box(setting *s, int dim) {
    const int cells = cells_along(dim);
    *s = (setting){.box = NULL};
    test_mesh_box(&s->mesh, dim, cells);
    for (int64_t i = 0; i < s->mesh.mesh.n_nodes * dim; i++)
        s->mesh.coordinates[i] = cells * pow(s->mesh.coordinates[i] / cells, 5);
}

/** Square of triangles, sheared so that all their edges are 1 long. */
static void equal_triangles(setting *s) {
    *s = (setting){.box = NULL};
    test_mesh_box(&s->mesh, 2, cells_along(2));
    for (int64_t i = 0; i < s->mesh.mesh.n_nodes; i++) {
        double *x = s->mesh.coordinates + i * 2;
        x[0] -= 0.5 * x[1];
        x[1] *= sqrt(0.75);
    }
}

static int64_t stars_of(const setting *s) {
    return s->lattice.n_stars;
}

/** Coordinates of all stars' nodes. */
static int64_t values_of(const setting *s) {
    return stars_of(s) * s->plan->dim;
}

/** Values in the stiffness of a grid. */
static int64_t size_of_stiffness(const pl_grid *g, int dim) {
    return g->n_vertices * (1 << dim) * dim * dim;
}

static void set_random(double *values, int64_t n, unsigned seed) {
    for (int64_t i = 0; i < n; i++)
        values[i] = 2 * test_random(&seed) - 1;
}

/** Place of a vertex in units of the lattice. */
static void find_vertex(const pl_grid *g, int64_t vertex, double x[3]) {
    x[0] = (double)(vertex % g->n[0]) / g->per_spacing[0];
    x[1] = (double)(vertex / g->n[0] % g->n[1]) / g->per_spacing[1];
    x[2] = (double)(vertex / g->n[0] / g->n[1]) / g->per_spacing[2];
}

/* ---- displacements --------------------------------------------------------------------------- */

/** Displacement of an affine field. */
static void affine_at(const double x[3], double to[3]) {
    static const double A[3][4] = {{0.3, -0.1, 0.2, 1}, {0.05, 0.4, -0.3, 2}, {-0.2, 0.1, 0.6, -1}};
    for (int r = 0; r < 3; r++)
        to[r] = A[r][3] + A[r][0] * x[0] + A[r][1] * x[1] + A[r][2] * x[2];
}

/** An affine field by the vertices of all grids is that field at all nodes. Return how many grids have
 *  nodes or elements. */
static int check_affine_field(const setting *s) {
    const pl_lattice *l = &s->lattice;
    const int dim = s->plan->dim;
    int n_owners = 0;
    for (int i = 0; i < l->n_levels; i++) {
        n_owners += l->grid[i].has_own;
        for (int64_t v = 0; v < l->grid[i].n_vertices; v++) {
            double x[3], to[3];
            find_vertex(&l->grid[i], v, x);
            affine_at(x, to);
            memcpy(l->grid[i].total + v * dim, to, (size_t)dim * sizeof *to);
        }
    }
    double *move = malloc((size_t)values_of(s) * sizeof *move);
    pl_lattice_prolong(l, move);
    for (int64_t k = 0; k < stars_of(s); k++) {
        const double *x = s->plan->scratch.coordinates + pl_lattice_node(l, k) * (int64_t)dim;
        double unit[3] = {0}, expected[3];
        for (int d = 0; d < dim; d++)
            unit[d] = (x[d] - l->origin[d]) / l->spacing;
        affine_at(unit, expected);
        for (int d = 0; d < dim; d++)
            assert_true(fabs(move[k * dim + d] / l->spacing - expected[d]) < 1e-9);
    }
    free(move);
    return n_owners;
}

static void nodes_follow_affine_fields(void **state) {
    setting s;
    graded_box(&s, *(int *)*state);
    begin(&s, PLANISH_ISA_AUTO, 2, 1);
    assert_true(check_affine_field(&s) >= 2);
    end(&s);
    test_mesh_destroy(&s.mesh);
}

/** In the plane the spacing is smaller where edges are narrow: six times narrower, a quarter. */
static void the_spacing_follows_narrow_edges(void **state) {
    (void)state;
    setting s = {.box = NULL};
    test_mesh_box(&s.mesh, 2, cells_along(2));
    for (int64_t i = 0; i < s.mesh.mesh.n_nodes; i++)
        s.mesh.coordinates[i * 2] /= 6;
    begin(&s, PLANISH_ISA_AUTO, 2, 1);
    assert_true(s.lattice.grid[0].per_spacing[0] == 4);
    assert_true(s.lattice.grid[0].per_spacing[1] == 1);
    check_affine_field(&s);
    end(&s);
    test_mesh_destroy(&s.mesh);
}

/** Forces do the same work on the vertices as on the nodes. */
static void forces_do_the_same_work(void **state) {
    const int dim = *(int *)*state;
    setting s;
    graded_box(&s, dim);
    begin(&s, PLANISH_ISA_AUTO, 2, 1);
    const int64_t n = values_of(&s);
    double *force = malloc((size_t)n * sizeof *force), *move = malloc((size_t)n * sizeof *move);
    double of_nodes = 0, of_vertices = 0, size = 0;
    set_random(force, n, 3);
    assert_int_equal(pl_lattice_restrict(&s.lattice, force), 1);
    for (int i = 0; i < s.lattice.n_levels; i++) {
        const pl_grid *g = &s.lattice.grid[i];
        set_random(g->total, g->n_vertices * dim, 4 + (unsigned)i);
        for (int64_t k = 0; k < g->n_vertices * dim; k++)
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
    setting s;
    rough_box(&s, *(int *)*state);
    begin(&s, PLANISH_ISA_AUTO, 1, 1);
    double *force = calloc((size_t)values_of(&s), sizeof *force);
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
static void multiply(const pl_grid *g, int dim, const double *x, double *y) {
    const int n_blocks = 1 << dim;
    memset(y, 0, (size_t)(g->n_vertices * dim) * sizeof *y);
    for (int64_t v = 0; v < g->n_vertices; v++)
        for (int bits = 0; bits < n_blocks; bits++) {
            const int64_t to =
                v + (bits & 1) + (bits >> 1 & 1) * g->n[0] + (bits >> 2 & 1) * g->n[0] * g->n[1];
            const double *k = g->stiffness + (v * n_blocks + bits) * dim * dim;
            if (to >= g->n_vertices)
                continue;
            for (int r = 0; r < dim; r++)
                for (int c = 0; c < dim; c++) {
                    y[v * dim + r] += k[r * dim + c] * x[to * dim + c];
                    if (bits > 0)
                        y[to * dim + c] += k[r * dim + c] * x[v * dim + r];
                }
        }
}

/** Displacement at x, in units, of the simplex of the finest grid that middle is in. */
static void displacement_at(const pl_grid *g, int dim, const double middle[3], const double x[3],
                            double to[3]) {
    int order[3] = {0, 1, 2};
    int64_t stride[3] = {1, g->n[0], g->n[0] * g->n[1]}, vertex = 0;
    double corner[3];
    for (int d = 0; d < dim; d++) {
        corner[d] = floor(middle[d]);
        vertex += (int64_t)corner[d] * stride[d];
    }
    for (int i = 0; i < dim; i++) /* the direction in which it is furthest along comes first */
        for (int k = i + 1; k < dim; k++)
            if (middle[order[k]] - corner[order[k]] > middle[order[i]] - corner[order[i]]) {
                const int first = order[i];
                order[i] = order[k];
                order[k] = first;
            }
    memcpy(to, g->total + vertex * dim, (size_t)dim * sizeof *to);
    for (int i = 0; i < dim; i++) {
        const int64_t next = vertex + stride[order[i]];
        for (int d = 0; d < dim; d++)
            to[d] += (x[order[i]] - corner[order[i]]) *
                     (g->total[next * dim + d] - g->total[vertex * dim + d]);
        vertex = next;
    }
}

/** What a corner of the plan adds to the AR^2 of its cell: mu^2 by the number of corners. */
static double share_of(const setting *s, int64_t element, const double *const vertex[]) {
    const int dim = s->plan->dim;
    const int kind = pl_corner_kind(s->plan->work.corner[element]);
    const pl_cell_shape *shape = pl_shape_of_kind(dim, kind);
    double e[3][3] = {{0}}, E = 0;
    for (int j = 0; j < dim; j++) {
        pl_subtract(dim, vertex[j + 1], vertex[0], e[j]);
        E += shape->to_corner[j] * pl_dot(dim, e[j], e[j]);
    }
    for (int i = 0, pair = 0; i < dim; i++)
        for (int j = i + 1; j < dim; j++) {
            double apart[3];
            pl_subtract(dim, e[j], e[i], apart);
            E += shape->between[pair++] * pl_dot(dim, apart, apart);
        }
    return pl_mean_square(dim, E, fabs(pl_determinant_of_edges(dim, e)) / shape->determinant) /
           (kind == PL_KIND_SIMPLEX ? 1 : shape->n_measured);
}

/** An element in units of the lattice: places of its nodes, and how far they go. */
typedef struct element_move {
    double unit[4][3], move[4][3];
    double aside[4]; /* square of the way that nodes do not go: off their planes and lines */
} element_move;

/** Split a displacement into the part that a node goes and the rest; return the square of that. */
static double project(const setting *s, int64_t node, double move[3]) {
    const planish_mesh *mesh = mesh_of(s);
    const int dim = mesh->dim;
    const int kind = s->constraint ? s->constraint[node] : PLANISH_CONSTRAINT_FREE;
    double along = 0, rest = 0;
    if (kind == PLANISH_CONSTRAINT_FREE)
        return 0;
    const double *direction = s->direction + node * dim;
    for (int d = 0; d < dim; d++)
        along += direction[d] * move[d];
    for (int d = 0; d < dim; d++) {
        const double part = along * direction[d];
        const double to = kind == PLANISH_CONSTRAINT_ON_LINE ? part : move[d] - part;
        rest += (move[d] - to) * (move[d] - to);
        move[d] = to;
    }
    return rest;
}

/** Find how an element goes. */
static element_move move_of(const setting *s, int64_t element) {
    const pl_lattice *l = &s->lattice;
    const planish_plan *plan = s->plan;
    const int dim = plan->dim, corners = dim + 1;
    element_move m = {.aside = {0}};
    double middle[3] = {0};
    for (int j = 0; j < corners; j++) {
        const double *x =
            plan->scratch.coordinates + (int64_t)pl_plan_inner(plan, element, j) * dim;
        for (int d = 0; d < dim; d++) {
            m.unit[j][d] = (x[d] - l->origin[d]) / l->spacing;
            middle[d] += m.unit[j][d] / corners;
        }
    }
    for (int j = 0; j < corners; j++) {
        if (l->freedom[pl_plan_inner(plan, element, j)] == PL_LATTICE_HELD)
            continue;
        displacement_at(&l->grid[0], dim, middle, m.unit[j], m.move[j]);
        m.aside[j] =
            project(s, pl_plan_node(plan, plan->work.elements[element * corners + j]), m.move[j]);
    }
    return m;
}

/** RR^2 of an element, or what a corner adds to AR^2. */
static double value_of(const setting *s, int64_t element, double unit[4][3]) {
    const double *const vertex[] = {unit[0], unit[1], unit[2], unit[3]};
    return s->plan->work.corner ? share_of(s, element, vertex)
                                : pl_radius_ratio_square(s->plan->dim, vertex);
}

/** Sum of RR^2 over the elements, or of AR^2 over cells, when each element or corner has gone the part t
 *  as its simplex goes. */
static double sum_at(const setting *s, double t) {
    double sum = 0;
    for (int64_t i = 0; i < s->plan->work.n_elements; i++) {
        element_move m = move_of(s, i);
        for (int j = 0; j <= s->plan->dim; j++)
            for (int d = 0; d < s->plan->dim; d++)
                m.unit[j][d] += t * m.move[j][d];
        sum += value_of(s, i, m.unit);
    }
    return sum;
}

/** Norm of an element's second derivatives by node j, from differences. */
static double norm_by_node(const setting *s, int64_t element, double unit[4][3], int j) {
    const double h = 0x1p-12;
    const int dim = s->plan->dim;
    double square = 0;
    for (int r = 0; r < dim; r++)
        for (int c = 0; c < dim; c++) {
            double sum = 0;
            for (int way = 0; way < 4; way++) {
                double moved[4][3];
                memcpy(moved, unit, sizeof moved);
                moved[j][r] += way & 1 ? -h : h;
                moved[j][c] += way & 2 ? -h : h;
                sum += (way == 1 || way == 2 ? -1 : 1) * value_of(s, element, moved);
            }
            square += pow(sum / (4 * h * h), 2);
        }
    return sqrt(square);
}

/** What the ways that nodes do not go add to the second derivative of the sum: a quarter of these
 *  norms. */
static double bend_aside(const setting *s) {
    double sum = 0;
    for (int64_t i = 0; i < s->plan->work.n_elements; i++) {
        element_move m = move_of(s, i);
        for (int j = 0; j <= s->plan->dim; j++)
            if (m.aside[j] > 0)
                sum += 0.25 * norm_by_node(s, i, m.unit, j) * m.aside[j];
    }
    return sum;
}

/** Set random moves of the vertices that are far enough from the surface for whole rows of elements. */
static void set_inner_moves(const setting *s, double *move) {
    const pl_lattice *l = &s->lattice;
    const pl_grid *g = &l->grid[0];
    const int dim = s->plan->dim;
    set_random(move, g->n_vertices * dim, 9);
    for (int64_t v = 0; v < g->n_vertices; v++) {
        double x[3];
        int inside = 1;
        find_vertex(g, v, x);
        for (int d = 0; d < dim; d++)
            x[d] = l->origin[d] + x[d] * l->spacing;
        if (dim == 2 && !s->box) { /* as in a square */
            x[1] /= sqrt(0.75);
            x[0] += 0.5 * x[1];
        }
        for (int d = 0; d < dim; d++)
            inside &= x[d] > 1 && x[d] < cells_along(dim) - 1;
        for (int d = 0; !inside && d < dim; d++)
            move[v * dim + d] = 0;
    }
}

/** The stiffness of the finest grid, to which all belongs, is the second derivative of the sum; where
 *  nodes slide, up to the surface. */
static void check_stiffness(const setting *s) {
    const pl_grid *g = &s->lattice.grid[0];
    const int dim = s->plan->dim;
    double expected = 0;
    for (int i = 1; i < s->lattice.n_levels; i++)
        assert_false(s->lattice.grid[i].has_own);
    if (s->constraint)
        set_random(g->total, g->n_vertices * dim, 9);
    else
        set_inner_moves(s, g->total);
    multiply(g, dim, g->total, g->change);
    for (int64_t k = 0; k < g->n_vertices * dim; k++)
        expected += g->total[k] * g->change[k];
    const double t = 0x1p-12;
    const double bend = (sum_at(s, t) - 2 * sum_at(s, 0) + sum_at(s, -t)) / (t * t);
    const double aside = bend_aside(s);
    assert_true(expected > 1);
    assert_int_equal(aside > 0.01 * expected, s->constraint != NULL);
    assert_true(fabs(bend + aside - expected) < 1e-4 * expected);
}

/** Turn a box, so that its planes and lines lie across the lattice. */
static void turn(setting *s) {
    static const double ANGLE = 0.4;
    const int dim = mesh_of(s)->dim;
    double *x = s->box ? s->box->x : s->mesh.coordinates;
    for (int64_t i = 0; i < mesh_of(s)->n_nodes; i++, x += dim)
        for (int d = 0; d < dim - 1; d++) {
            const double a = x[d], b = x[d + 1];
            x[d] = a * cos(ANGLE) - b * sin(ANGLE);
            x[d + 1] = a * sin(ANGLE) + b * cos(ANGLE);
        }
}

/** The stiffness is the second derivative of the sum of RR^2. In the plane only its positive part
 *  counts, which is all of it for triangles with equal edges. */
static void stiffness_is_the_bend_of_the_sum(void **state) {
    const int dim = *(int *)*state;
    setting s;
    if (dim == 3)
        rough_box(&s, dim);
    else
        equal_triangles(&s);
    begin(&s, PLANISH_ISA_AUTO, 1, 1);
    check_stiffness(&s);
    end(&s);
    test_mesh_destroy(&s.mesh);
}

/** So it is where nodes slide. */
static void stiffness_where_nodes_slide_is_the_bend_of_the_sum(void **state) {
    const int dim = *(int *)*state;
    setting s;
    if (dim == 3)
        rough_box(&s, dim);
    else
        equal_triangles(&s);
    turn(&s);
    let_slide(&s);
    begin(&s, PLANISH_ISA_AUTO, 1, 1);
    check_stiffness(&s);
    end(&s);
    free_slides(&s);
    test_mesh_destroy(&s.mesh);
}

/** So it is with AR^2 of cells of all kinds; in the plane of squares, whose positive part is all of it. */
static void stiffness_of_cells_is_the_bend_of_the_sum(void **state) {
    static const cell_box_kind KINDS[] = {BOX_QUADRILATERALS, BOX_HEXAHEDRA, BOX_WEDGES,
                                          BOX_PYRAMIDS, BOX_MIXED};
    (void)state;
    for (size_t k = 0; k < sizeof KINDS / sizeof *KINDS; k++) {
        const int dim = KINDS[k] == BOX_QUADRILATERALS ? 2 : 3;
        setting s = {.box = cell_box_create(KINDS[k], cells_along(dim))};
        if (dim == 3)
            cell_box_shake(s.box, 0.08, 7);
        begin(&s, PLANISH_ISA_AUTO, 1, 1);
        check_stiffness(&s);
        end(&s);
        turn(&s);
        let_slide(&s);
        begin(&s, PLANISH_ISA_AUTO, 1, 1);
        check_stiffness(&s);
        end(&s);
        free_slides(&s);
        cell_box_destroy(s.box);
    }
}

/** Elements that are chosen stand for all: on the whole the stiffness is the same. */
static void some_elements_stand_for_all(void **state) {
    const int dim = *(int *)*state;
    double work[2] = {0};
    for (int i = 0; i < 2; i++) {
        setting s;
        rough_box(&s, dim);
        let_slide(&s); /* all elements there stand for themselves */
        begin(&s, PLANISH_ISA_AUTO, 1, i == 0 ? 1 : SOME);
        const pl_grid *g = &s.lattice.grid[0];
        set_inner_moves(&s, g->total);
        multiply(g, dim, g->total, g->change);
        for (int64_t k = 0; k < g->n_vertices * dim; k++)
            work[i] += g->total[k] * g->change[k];
        end(&s);
        free_slides(&s);
        test_mesh_destroy(&s.mesh);
    }
    assert_true(work[1] != work[0]);
    assert_true(fabs(work[1] - work[0]) < 0.2 * work[0]);
}

/** Lattices over one mesh for two instruction sets and numbers of threads have the same bits, all of them
 *  finite. */
static void check_same_bits(setting *one) {
    setting other = *one;
    begin(one, PLANISH_ISA_PLAIN, 1, SOME);
    begin(&other, PLANISH_ISA_AUTO, 3, SOME);
    assert_int_equal(one->lattice.n_levels, other.lattice.n_levels);
    for (int i = 0; i < one->lattice.n_levels; i++) {
        const pl_grid *g = &one->lattice.grid[i];
        const int64_t n = size_of_stiffness(g, one->plan->dim);
        assert_memory_equal(g->stiffness, other.lattice.grid[i].stiffness,
                            (size_t)n * sizeof(double));
        for (int64_t k = 0; k < n; k++)
            assert_true(isfinite(g->stiffness[k]));
    }
    end(one);
    end(&other);
}

/** Number of the node in the middle of a box. */
static int64_t middle_node(int dim) {
    const int cells = cells_along(dim);
    int64_t inside = 0;
    for (int d = 0; d < dim; d++)
        inside = inside * (cells + 1) + cells / 2;
    return inside;
}

/** Instruction sets and threads change no bit of it, and flat elements leave it finite. */
static void stiffness_has_the_same_bits(void **state) {
    const int dim = *(int *)*state;
    const int64_t inside = middle_node(dim);
    setting s;
    graded_box(&s, dim);
    memcpy(s.mesh.coordinates + inside * dim, s.mesh.coordinates + (inside + 1) * dim,
           (size_t)dim * sizeof(double));
    check_same_bits(&s);
    let_slide(&s);
    check_same_bits(&s);
    free_slides(&s);
    test_mesh_destroy(&s.mesh);
}

static void stiffness_of_cells_has_the_same_bits(void **state) {
    const int dim = *(int *)*state, cells = cells_along(dim);
    const int64_t inside = middle_node(dim);
    setting s = {.box = cell_box_create(dim == 2 ? BOX_MIXED_2D : BOX_MIXED, cells)};
    for (int64_t i = 0; i < s.box->mesh.n_nodes * dim; i++)
        s.box->x[i] = cells * pow(s.box->x[i] / cells, 3);
    memcpy(s.box->x + inside * dim, s.box->x + (inside + 1) * dim, (size_t)dim * sizeof(double));
    check_same_bits(&s);
    let_slide(&s);
    check_same_bits(&s);
    free_slides(&s);
    cell_box_destroy(s.box);
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
    const int dim = *(int *)*state;
    setting s;
    rough_box(&s, dim);
    begin(&s, PLANISH_ISA_AUTO, 2, 1);
    const pl_grid *g = &s.lattice.grid[0];
    const size_t size = (size_t)(g->n_vertices * dim) * sizeof(double);
    double *force = malloc((size_t)values_of(&s) * sizeof *force), *given = malloc(size);
    double *product = malloc(size), rest2 = 0, given2 = 0;
    int n_asked = 0, n_active = 0;
    set_random(force, values_of(&s), 11);
    assert_int_equal(pl_lattice_restrict(&s.lattice, force), 1);
    memcpy(given, g->force, size);
    assert_int_equal(pl_lattice_solve(&s.lattice, 1e-7, 60, never, &n_asked), 0);
    multiply(g, dim, g->total, product);
    for (int64_t k = 0; k < g->n_vertices * dim; k++)
        if (g->is_active[k / dim]) {
            n_active++;
            given2 += given[k] * given[k];
            rest2 += (given[k] - product[k]) * (given[k] - product[k]);
        }
    assert_true(n_active > dim * 64);
    assert_true(n_asked > 1 && n_asked < 40);
    assert_true(rest2 < 1e-10 * given2);
    free(force);
    free(given);
    free(product);
    end(&s);
    test_mesh_destroy(&s.mesh);
}

static void a_solution_is_cut_short(void **state) {
    setting s;
    rough_box(&s, *(int *)*state);
    begin(&s, PLANISH_ISA_AUTO, 1, 1);
    double *force = malloc((size_t)values_of(&s) * sizeof *force);
    set_random(force, values_of(&s), 11);
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
    setting s;
    int n_failed = 0, ready = 0;
    rough_box(&s, *(int *)*state);
    let_slide(&s);
    plan_mesh(&s, PLANISH_ISA_AUTO, 1);
    while (!ready) {
        allocations_fail_one(n_failed);
        ready = pl_lattice_create(s.plan, SPACING, 1, 1, NULL, &s.lattice);
        assert_int_equal(!ready, allocations_failed());
        n_failed += !ready;
        pl_lattice_destroy(&s.lattice);
    }
    assert_true(n_failed > 20);
    planish_plan_destroy(s.plan);
    free_slides(&s);
    test_mesh_destroy(&s.mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        BOTH(nodes_follow_affine_fields),
        cmocka_unit_test(the_spacing_follows_narrow_edges),
        BOTH(forces_do_the_same_work),
        BOTH(no_forces_are_refused),
        BOTH(stiffness_is_the_bend_of_the_sum),
        BOTH(stiffness_where_nodes_slide_is_the_bend_of_the_sum),
        cmocka_unit_test(stiffness_of_cells_is_the_bend_of_the_sum),
        BOTH(some_elements_stand_for_all),
        BOTH(stiffness_has_the_same_bits),
        BOTH(stiffness_of_cells_has_the_same_bits),
        BOTH(moves_balance_the_forces),
        BOTH(a_solution_is_cut_short),
        BOTH(without_memory_there_is_no_lattice),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
