/* planish_find_slides: the planes and lines of boxes of any cells. */
#include "support/allocations.h"
#include "support/cell_meshes.h"
#include "support/meshes.h"
#include "support/slides.h"

#include "geometry/cell.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/** Make a box of a kind: straight, with mids, with those of faces, too (raise 0 to 2). */
static cell_box *box_of(int kind, int raise) {
    cell_box *box = cell_box_create((cell_box_kind)kind, SLIDES_CELLS);
    if (raise == 0)
        return box;
    cell_box *raised = cell_box_raise(box, raise == 2);
    cell_box_destroy(box);
    return raised;
}

/** Whether a node is a corner: those of the box are at whole places, centres of pyramids inside. */
static int is_corner(const planish_mesh *mesh, int64_t node) {
    int whole = 1, half = 1;
    for (int d = 0; d < mesh->dim; d++) {
        const double x = mesh->coordinates[node * mesh->dim + d];
        whole &= x == floor(x);
        half &= x != floor(x);
    }
    return whole || half;
}

/** Whether a node is in the middle of an edge. */
static int is_edge_mid(const planish_mesh *mesh, int64_t node) {
    int any = 0;
    for (int64_t i = 0; i < mesh->cells->n; i++) {
        const pl_cell_type *type = pl_cell_type_of(mesh->cells->type[i]);
        const int64_t first = mesh->cells->offset[i] + type->shape->n_corners;
        for (int e = 0; type->order > 1 && e < type->shape->n_edges; e++)
            any |= mesh->cells->node[first + e] == node;
    }
    return any;
}

/** As expect_box, of any cells. Mids are free, as they follow, but those of the cut: they have a constraint, so that
 *  they do not move on their own. axis: of the cut. */
static void expect_box_of_cells(const planish_mesh *mesh, const slides_found *f, int axis,
                                double cut) {
    const int dim = mesh->dim;
    int64_t n[3] = {0};
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        const double *x = mesh->coordinates + i * dim;
        int crosses[3] = {0};
        if (!is_corner(mesh, i) && x[axis] == cut && is_edge_mid(mesh, i)) {
            assert_int_not_equal(f->constraint[i], PLANISH_CONSTRAINT_FREE);
            continue;
        }
        for (int d = 0; d < dim && is_corner(mesh, i); d++)
            crosses[d] = slides_is_side(x[d]) || (d == axis && x[d] == cut);
        slides_expect_node(f, i, dim, crosses);
        n[0] += f->constraint[i] == PLANISH_CONSTRAINT_ON_PLANE;
        n[1] += f->constraint[i] == PLANISH_CONSTRAINT_ON_LINE;
    }
    assert_int_equal(f->info.n_on_plane, n[0]);
    assert_int_equal(f->info.n_on_line, n[1]);
    assert_true(n[1] > 0 && (dim == 2 || n[0] > 0));
}

/** The region of a cell: by the last coordinate of the middle of its corners. */
static int32_t half_of(const planish_mesh *mesh, int64_t cell) {
    const int32_t *node = mesh->cells->node + mesh->cells->offset[cell];
    const int last = mesh->dim - 1;
    double middle = 0;
    for (int j = 0; j < 4; j++)
        middle += mesh->coordinates[(int64_t)node[j] * mesh->dim + last] / 4;
    for (int j = 4; j < mesh->cells->offset[cell + 1] - mesh->cells->offset[cell]; j++)
        middle = fmin(middle, mesh->coordinates[(int64_t)node[j] * mesh->dim + last]);
    return middle < 2 ? 7 : -3;
}

static void boxes_of_any_cells_have_sides(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++)
        for (int raise = 0; raise < 3; raise++) {
            cell_box *box = box_of(kind, raise);
            int32_t *region = malloc((size_t)box->cells.n * sizeof *region);
            for (int64_t i = 0; i < box->cells.n; i++)
                region[i] = half_of(&box->mesh, i);
            const planish_surface surface = {.region = region};
            for (int threads = 1; threads <= 3; threads += 2) {
                slides_found f = slides_find_on(&box->mesh, NULL, threads);
                expect_box_of_cells(&box->mesh, &f, 0, -1);
                slides_release(&f);
                f = slides_find_on(&box->mesh, &surface, threads);
                expect_box_of_cells(&box->mesh, &f, box->mesh.dim - 1, 2);
                slides_release(&f);
            }
            free(region);
            cell_box_destroy(box);
        }
}

/** What a plan knows to be inside saves time and changes nothing. */
static void what_is_inside_of_cells_may_be_told(void **state) {
    (void)state;
    for (int kind = 0; kind < N_BOX_KINDS; kind++) {
        cell_box *box = box_of(kind, kind % 3);
        planish_plan *plan;
        uint8_t *inside = malloc((size_t)box->mesh.n_nodes);
        assert_int_equal(planish_plan_create(&box->mesh, NULL, &plan, NULL), 0);
        planish_plan_get_free(plan, inside);
        assert_non_null(memchr(inside, 1, (size_t)box->mesh.n_nodes));
        const planish_surface surface = {.is_inside = inside};
        slides_found f = slides_find(&box->mesh, &surface);
        expect_box_of_cells(&box->mesh, &f, 0, -1);
        slides_release(&f);
        planish_plan_destroy(plan);
        free(inside);
        cell_box_destroy(box);
    }
}

/** Whether a node of the side y = 0 is in a quadrilateral at the middle one of that side. */
static int is_around_middle(const double *x) {
    return fabs(x[0] - 2) <= 1 && x[1] <= 0 && fabs(x[2] - 2) <= 1;
}

/** Quadrilaterals of which one node is off the plane are not planar: their nodes stay, and so do those
 *  of a whole side that is bent. */
static void quadrilaterals_that_are_not_planar_stay(void **state) {
    (void)state;
    static const int kinds[] = {BOX_HEXAHEDRA, BOX_PYRAMIDS, BOX_WEDGES};
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        cell_box *box = box_of(kinds[k], 0);
        const int64_t off =
            slides_node_at(&box->mesh, 2, 0, 2); /* wedges have quadrilaterals there, too */
        box->x[3 * off + 1] = -0.01;
        slides_found f = slides_find(&box->mesh, NULL);
        slides_expect_sides(&box->mesh, &f, is_around_middle);
        slides_release(&f);
        cell_box_destroy(box);
    }
}

/** A quadrilateral that is not convex is in its plane as others are. */
static void darts_are_planar(void **state) {
    (void)state;
    for (int corner = 0; corner < 4; corner++) {
        cell_box *box = box_of(BOX_HEXAHEDRA, 0);
        const double x = 1 + (corner == 1 || corner == 2), z = 1 + corner / 2;
        const int64_t node = slides_node_at(&box->mesh, x, 0, z);
        box->x[3 * node] += x > 1 ? -0.7 : 0.7; /* past the diagonal of a side's quadrilateral */
        box->x[3 * node + 2] += z > 1 ? -0.7 : 0.7;
        slides_found f = slides_find(&box->mesh, NULL);
        slides_expect_sides(&box->mesh, &f, NULL);
        slides_release(&f);
        cell_box_destroy(box);
    }
}

/** Split the hexahedra of a box above z = 2 into tetrahedra, whose triangles meet quadrilaterals at
 *  z = 2. */
static void split_upper_half(cell_box *box) {
    static const uint8_t cut[6][4] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6},
                                      {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
    const int64_t n = box->cells.n;
    int32_t(*corner)[8] = malloc((size_t)n * sizeof *corner);
    memcpy(corner, box->node, (size_t)n * sizeof *corner);
    box->type = realloc(box->type, (size_t)(6 * n));
    box->offset = realloc(box->offset, (size_t)(6 * n + 1) * sizeof *box->offset);
    int64_t cells = 0;
    for (int64_t i = 0; i < n; i++) {
        const int is_upper = box->x[3 * (int64_t)corner[i][0] + 2] >= 2;
        for (int t = 0; t < (is_upper ? 6 : 1); t++, cells++) {
            int32_t *to = box->node + box->offset[cells];
            for (int j = 0; j < (is_upper ? 4 : 8); j++)
                to[j] = corner[i][is_upper ? cut[t][j] : j];
            box->type[cells] = is_upper ? PLANISH_CELL_TETRAHEDRON : PLANISH_CELL_HEXAHEDRON;
            box->offset[cells + 1] = box->offset[cells] + (is_upper ? 4 : 8);
        }
    }
    free(corner);
    box->cells =
        (planish_cells){.n = cells, .type = box->type, .offset = box->offset, .node = box->node};
    box->mesh.n_elements = cells;
}

static int is_half_way_up(const double *x) {
    return x[2] == 2;
}

/** A quadrilateral against two triangles is a boundary of both sides: nodes there stay. */
static void quadrilaterals_against_triangles_stay(void **state) {
    (void)state;
    cell_box *box = box_of(BOX_HEXAHEDRA, 0);
    split_upper_half(box);
    slides_found f = slides_find(&box->mesh, NULL);
    slides_expect_sides(&box->mesh, &f, is_half_way_up);
    slides_release(&f);
    cell_box_destroy(box);
}

/** Tagged quadrilaterals end where the tag changes, by their corners alone; those that the mesh has
 *  not hold their corners. */
static void tagged_quadrilaterals_make_edges(void **state) {
    (void)state;
    for (int raise = 0; raise < 3; raise++) {
        cell_box *box = box_of(BOX_HEXAHEDRA, raise);
        const planish_mesh *mesh = &box->mesh;
        int32_t facets[4 * SLIDES_CELLS * SLIDES_CELLS + 4], tags[SLIDES_CELLS * SLIDES_CELLS + 1];
        int64_t offset[SLIDES_CELLS * SLIDES_CELLS + 2] = {0}, n = 0;
        for (int64_t i = 0; i < box->cells.n; i++) {
            const int32_t *node = box->node + box->offset[i];
            if (box->x[3 * (int64_t)node[0] + 2] != 0)
                continue;
            for (int j = 0; j < 4; j++) /* of the base, the other way round for some */
                facets[4 * n + j] = node[n % 2 ? 3 - j : j];
            tags[n] = box->x[3 * (int64_t)node[0]] < 2 ? 1 : 2;
            n++;
            offset[n] = 4 * n;
        }
        planish_surface surface = {
            .n_facets = n, .facets = facets, .facet_tag = tags, .facet_offset = offset};
        assert_int_equal(n, SLIDES_CELLS * SLIDES_CELLS);
        slides_found f = slides_find(mesh, &surface);
        for (int64_t i = 0; i < mesh->n_nodes; i++) {
            const double *x = mesh->coordinates + 3 * i;
            const int counts = is_corner(mesh, i), on_line = x[2] == 0 && x[0] == 2;
            const int crosses[3] = {counts && (slides_is_side(x[0]) || on_line),
                                    counts && slides_is_side(x[1]), counts && slides_is_side(x[2])};
            slides_expect_node(&f, i, 3, crosses);
        }
        slides_release(&f);
        surface.tagged_only = 1;
        f = slides_find(mesh, &surface);
        const int64_t bottom = slides_node_at(mesh, 1, 1, 0),
                      top = slides_node_at(mesh, 1, 1, SLIDES_CELLS);
        assert_int_equal(f.constraint[bottom], PLANISH_CONSTRAINT_ON_PLANE);
        assert_int_equal(f.constraint[top], PLANISH_CONSTRAINT_FIXED);
        slides_release(&f);
        surface.tagged_only = 0;
        for (int j = 0; j < 4; j++) /* a facet within */
            facets[4 * n + j] =
                (int32_t)slides_node_at(mesh, 1 + (j == 1 || j == 2), 1, 1 + 2 * (j / 2));
        tags[n] = 3;
        offset[n + 1] = 4 * (n + 1);
        surface.n_facets++;
        f = slides_find(mesh, &surface);
        for (int j = 0; j < 4; j++)
            assert_int_equal(f.constraint[facets[4 * n + j]], PLANISH_CONSTRAINT_FIXED);
        slides_release(&f);
        cell_box_destroy(box);
    }
}

/** Expect that a plan holds no node that is said to slide. */
static void expect_no_held(const planish_mesh *mesh, const slides_found *f) {
    planish_plan *plan;
    planish_mesh slid = *mesh;
    slid.constraint = f->constraint;
    slid.direction = f->direction;
    uint8_t *held = malloc((size_t)mesh->n_nodes);
    assert_int_equal(planish_plan_create(&slid, NULL, &plan, NULL), 0);
    assert_int_equal(planish_plan_get_held(plan, NULL, held, NULL), 0);
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        if (f->constraint[i] == PLANISH_CONSTRAINT_ON_PLANE ||
            f->constraint[i] == PLANISH_CONSTRAINT_ON_LINE)
            assert_int_equal(held[i], 0);
    planish_plan_destroy(plan);
    free(held);
}

/** A mid of the surface that is off its edge fixes its ends; the middle of a face only if it is off
 *  the plane of the face, and then all of its corners. A plan holds no others. */
static void curved_cells_stay(void **state) {
    (void)state;
    static const struct {
        double at[3], off[3]; /* the mid, and by how much */
        int n_fixed;          /* nodes beside those that are always */
    } cases[] = {{{1.5, 0, 1}, {0, 0, 0.1}, 2},     {{1.5, 0, 1}, {0, -0.1, 0}, 6},
                 {{1.5, 0, 1.5}, {0.1, 0, 0}, 0},   {{1.5, 0, 1.5}, {0, -0.1, 0}, 4},
                 {{1.5, 1.5, 1.5}, {0, 0.1, 0}, 0}, {{1.5, 1, 1.5}, {0, 0.1, 0}, 0}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        cell_box *box = box_of(BOX_HEXAHEDRA, 2);
        const int64_t mid =
            slides_node_at(&box->mesh, cases[k].at[0], cases[k].at[1], cases[k].at[2]);
        slides_found f = slides_find(&box->mesh, NULL);
        int64_t n = 0;
        for (int64_t i = 0; i < box->mesh.n_nodes; i++)
            n -= f.constraint[i] == PLANISH_CONSTRAINT_FIXED;
        slides_release(&f);
        for (int d = 0; d < 3; d++)
            box->x[3 * mid + d] += cases[k].off[d];
        f = slides_find(&box->mesh, NULL);
        for (int64_t i = 0; i < box->mesh.n_nodes; i++) {
            n += f.constraint[i] == PLANISH_CONSTRAINT_FIXED;
            if (f.constraint[i] == PLANISH_CONSTRAINT_FIXED && cases[k].n_fixed == 4)
                assert_true(fabs(box->x[3 * i] - 1.5) <= 0.5 || slides_is_side(box->x[3 * i]));
        }
        assert_int_equal(n, cases[k].n_fixed);
        expect_no_held(&box->mesh, &f);
        slides_release(&f);
        cell_box_destroy(box);
    }
}

/** Move a corner by way; mids, and nodes of faces and cells, follow. */
static void move_corner(cell_box *box, int64_t corner, const double way[3]) {
    uint8_t *is_moved = calloc((size_t)box->mesh.n_nodes, 1);
    for (int64_t i = 0; i < box->cells.n; i++) {
        const pl_cell_type *type = pl_cell_type_of(box->type[i]);
        const int32_t *node = box->node + box->offset[i];
        int at = 0;
        while (at < type->shape->n_corners && node[at] != corner)
            at++;
        for (int k = 0; at < type->shape->n_corners && k < type->n_nodes; k++) {
            const uint8_t parents = pl_cell_parents(type, k);
            if (!(parents >> at & 1) || is_moved[node[k]])
                continue;
            is_moved[node[k]] = 1;
            for (int d = 0; d < 3; d++)
                box->x[3 * (int64_t)node[k] + d] += way[d] / __builtin_popcount(parents);
        }
    }
    free(is_moved);
}

/** Faces whose corners have moved in their planes, and those inside, are straight where their middles
 *  have followed: nodes slide as before. */
static void middles_that_follow_are_straight(void **state) {
    (void)state;
    for (int raise = 1; raise < 3; raise++) {
        cell_box *box = box_of(BOX_HEXAHEDRA, raise);
        const planish_mesh *mesh = &box->mesh;
        slides_found f = slides_find(mesh, NULL);
        const int64_t corner[] = {slides_node_at(mesh, 1, 0, 1), slides_node_at(mesh, 3, 1, 1),
                                  slides_node_at(mesh, 2, 2, 0)};
        const double way[3][3] = {{0.2, 0, 0.1}, {-0.1, 0.2, 0.2}, {0.3, -0.2, 0}};
        for (int i = 0; i < 3; i++)
            move_corner(box, corner[i], way[i]);
        slides_found g = slides_find(mesh, NULL);
        assert_memory_equal(f.constraint, g.constraint, (size_t)mesh->n_nodes);
        expect_no_held(mesh, &g);
        slides_release(&f);
        slides_release(&g);
        cell_box_destroy(box);
    }
}

static void memory_for_cells_may_run_out(void **state) {
    (void)state;
    cell_box *box = box_of(BOX_MIXED, 0);
    const int32_t facets[] = {0, 1, 6, 5};
    const int64_t offset[] = {0, 4};
    const planish_surface surface = {.n_facets = 1, .facets = facets, .facet_offset = offset};
    uint8_t constraint[512];
    double direction[3 * 512];
    int failures = 0, status = PLANISH_ERROR_MEMORY;
    assert_true(box->mesh.n_nodes <= 512);
    for (; status == PLANISH_ERROR_MEMORY; failures++) {
        allocations_permit(failures);
        status = planish_find_slides(&box->mesh, &surface, 1, constraint, direction, NULL, NULL);
        allocations_permit(-1);
    }
    assert_int_equal(status, 0);
    assert_true(failures > 20);
    cell_box_destroy(box);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes_of_any_cells_have_sides),
        cmocka_unit_test(what_is_inside_of_cells_may_be_told),
        cmocka_unit_test(quadrilaterals_that_are_not_planar_stay),
        cmocka_unit_test(darts_are_planar),
        cmocka_unit_test(quadrilaterals_against_triangles_stay),
        cmocka_unit_test(tagged_quadrilaterals_make_edges),
        cmocka_unit_test(curved_cells_stay),
        cmocka_unit_test(middles_that_follow_are_straight),
        cmocka_unit_test(memory_for_cells_may_run_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
