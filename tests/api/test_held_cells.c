/* planish_mesh.cells: which nodes cells hold. */
#include "support/cell_pairs.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/** A mid, the ends of its edge, and a cell and place that has it. */
typedef struct edge {
    int32_t mid, a, b;
    int64_t at; /* in node */
} edge;

/** Find an edge with a mid whose ends is_wanted [n] has, and whose middle is at least far from the
 *  sides of the box other than x = 0. */
static edge find_edge(const cell_pair *p, const uint8_t *is_wanted, double far) {
    for (int64_t at = 0; at < p->offset[p->cells.n]; at++) {
        const int32_t mid = p->node[at], *end = p->end[mid];
        int fits = end[0] >= 0 && is_wanted[end[0]] && is_wanted[end[1]];
        for (int d = 1; fits && d < p->mesh.dim; d++)
            fits = *cell_pair_place(p, mid, d) > far && *cell_pair_place(p, mid, d) < 6 - far;
        if (fits)
            return (edge){mid, end[0], end[1], at};
    }
    fail_msg("no such edge");
    return (edge){0, 0, 0, 0};
}

/** Ways in which cells hold the ends of an edge of free nodes, and perhaps those of another one. */
enum {
    MID_FIXED,
    MID_OF_VERTEX,
    MID_OF_LINE3,
    END_OF_VERTEX,
    MID_IS_CORNER,
    MID_OF_TWO_EDGES,
    MID_MISSING,
    MID_TWICE,
    N_WAYS
};

/** Change p so; is_held [n] becomes 1 for nodes that are held because of that. */
static void hold(cell_pair *p, int way, const edge *e, const edge *other, uint8_t *constraint,
                 uint8_t *is_held) {
    const int32_t line[3] = {p->plain.n_nodes > 0 ? other->mid : 0, e->b, e->mid};
    is_held[e->a] = is_held[e->b] = way != MID_MISSING && way != MID_TWICE;
    switch (way) {
    case MID_FIXED:
        constraint[e->mid] = PLANISH_CONSTRAINT_FIXED;
        p->mesh.constraint = constraint;
        break;
    case MID_OF_VERTEX:
        cell_pair_append(p, PLANISH_CELL_VERTEX, &e->mid, 1);
        break;
    case MID_OF_LINE3: /* with a mid at its end, too */
        cell_pair_append(p, PLANISH_CELL_LINE3, line, 3);
        is_held[other->a] = is_held[other->b] = 1;
        break;
    case END_OF_VERTEX:
        cell_pair_append(p, PLANISH_CELL_VERTEX, &e->a, 1);
        is_held[e->b] = 0;
        break;
    case MID_IS_CORNER:
        p->node[e->at] = other->a;
        break;
    case MID_OF_TWO_EDGES:
        p->node[other->at] = e->mid;
        is_held[other->a] = is_held[other->b] = 1;
        break;
    case MID_MISSING:
        p->node[e->at] = -1;
        break;
    default: /* another mid in one of the elements */
        p->node[e->at] = (int32_t)p->mesh.n_nodes++;
        break;
    }
}

/** Set is_wanted [n_nodes] to 0 for the nodes of all cells that node is of. */
static void leave_out_cells(const cell_pair *p, int32_t node, uint8_t *is_wanted) {
    for (int64_t i = 0; i < p->cells.n; i++) {
        int has_node = 0;
        for (int64_t at = p->offset[i]; at < p->offset[i + 1]; at++)
            has_node |= p->node[at] == node;
        for (int64_t at = p->offset[i]; has_node && at < p->offset[i + 1]; at++)
            is_wanted[p->node[at]] = 0;
    }
}

static void cells_hold_nodes(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int way = 0; way < N_WAYS; way++) {
            const planish_options options = cell_pair_options();
            test_mesh box = cell_pair_box(dim, 6, 0);
            cell_pair p = cell_pair_of(&box, PAIR_ORDER_2 | PAIR_OTHERS);
            planish_plan *plan;
            const size_t n = (size_t)p.mesh.n_nodes; /* arrays have room for one more */
            uint8_t *before = cell_pair_zeroed(p.mesh.n_nodes, 1),
                    *after = cell_pair_zeroed(p.mesh.n_nodes, 1);
            uint8_t *is_held = cell_pair_zeroed(p.mesh.n_nodes, 1),
                    *rest = cell_pair_zeroed(p.mesh.n_nodes, 1);
            uint8_t *constraint = cell_pair_zeroed(p.mesh.n_nodes, 1);
            cell_pair_fasten(&p);
            assert_int_equal(planish_plan_create(&p.mesh, &options, &plan, NULL), 0);
            planish_plan_get_free(plan, before);
            planish_plan_destroy(plan);
            const edge e = find_edge(&p, before, 0);
            memcpy(rest, before, n);
            leave_out_cells(&p, e.mid, rest);
            const edge other = find_edge(&p, rest, 0);
            hold(&p, way, &e, &other, constraint, is_held);
            p.mesh.n_elements = p.cells.n;
            assert_int_equal(planish_plan_create(&p.mesh, &options, &plan, NULL), 0);
            planish_plan_get_free(plan, after);
            for (size_t i = 0; i < n; i++)
                assert_int_equal(after[i], before[i] && !is_held[i]);
            assert_int_equal(planish_plan_get_held(plan, NULL, after, NULL), 0);
            for (size_t i = 0; i < n; i++)
                assert_true(!is_held[i] || after[i] == PLANISH_HELD_FIXED);
            assert_int_equal(after[e.mid], way == MID_MISSING || way == MID_TWICE ||
                                                   way == END_OF_VERTEX || way == MID_IS_CORNER
                                               ? after[e.mid]
                                               : PLANISH_HELD_FIXED);
            planish_plan_destroy(plan);
            free(before);
            free(after);
            free(is_held);
            free(rest);
            free(constraint);
            cell_pair_release(&p);
            test_mesh_destroy(&box);
        }
}

/** Fill slides [n_nodes] with 1 for nodes that slide in a plan of p, and moves for those that move
 *  otherwise. Others on the boundary, but those that constraints fix, are told to be held by cells. */
static void find_moving(const cell_pair *p, const planish_options *options, uint8_t *slides,
                        uint8_t *moves) {
    planish_plan *plan;
    assert_int_equal(planish_plan_create(&p->mesh, options, &plan, NULL), 0);
    assert_int_equal(planish_plan_get_held(plan, NULL, slides, NULL), 0);
    planish_plan_get_free(plan, moves);
    for (int64_t i = 0; i < p->mesh.n_nodes; i++) {
        assert_true(i >= p->plain.n_nodes || !(slides[i] & PLANISH_HELD_BOUNDARY) ||
                    (slides[i] & PLANISH_HELD_FIXED));
        slides[i] = !slides[i] && !moves[i] && i < p->plain.n_nodes;
    }
    planish_plan_destroy(plan);
}

/** Curved edges of the boundary hold their ends in a plan; those that go inside do not. */
static void curved_edges_hold_nodes_that_slide(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int inside = 0; inside < 2; inside++) {
            planish_options options = cell_pair_options();
            test_mesh box = cell_pair_box(dim, 6, 0);
            cell_pair p = cell_pair_of(&box, PAIR_ORDER_2);
            const size_t n = (size_t)p.mesh.n_nodes;
            uint8_t *before = cell_pair_zeroed(p.mesh.n_nodes, 1),
                    *after = cell_pair_zeroed(p.mesh.n_nodes, 1);
            uint8_t *moves = cell_pair_zeroed(p.mesh.n_nodes, 1);
            cell_pair_fasten(&p);
            cell_pair_slide(&p, NULL, NULL);
            find_moving(&p, &options, before, moves);
            /* from one that slides to a free one: not both slide, but both are of either kind */
            edge e = {0, 0, 0, 0};
            if (inside)
                for (int64_t i = 0; i < p.mesh.n_nodes; i++) {
                    const int32_t *end = p.end[i];
                    if (end[0] >= 0 && before[end[0]] && moves[end[1]])
                        e = (edge){(int32_t)i, end[0], end[1], 0};
                }
            else
                e = find_edge(&p, before, 0);
            assert_true(e.mid > 0);
            for (int d = 0; d < dim; d++)
                *cell_pair_place(&p, e.mid, d) += 0.05;
            find_moving(&p, &options, after, moves);
            for (size_t i = 0; i < n; i++)
                assert_int_equal(after[i],
                                 before[i] && (inside || ((int32_t)i != e.a && (int32_t)i != e.b)));
            options.rounding = 0.1;
            find_moving(&p, &options, after, moves);
            assert_memory_equal(before, after, n);
            options.rounding = 0;
            options.only_worse_than = 1.1; /* all, as a subset */
            find_moving(&p, &options, after, moves);
            assert_int_equal(after[e.a], inside && before[e.a]);
            cell_pair_stop_sliding(&p);
            free(before);
            free(after);
            free(moves);
            cell_pair_release(&p);
            test_mesh_destroy(&box);
        }
}

/** A call on a plan has the plan's rounding: without options by itself. */
static void calls_have_the_rounding_of_the_plan(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        planish_options options = cell_pair_options();
        test_mesh box = cell_pair_box(dim, 3, 0);
        cell_pair p = cell_pair_of(&box, PAIR_ORDER_2);
        planish_plan *plan;
        planish_error error;
        int64_t n = -1;
        options.rounding = 0.1;
        cell_pair_fasten(&p);
        assert_int_equal(planish_plan_create(&p.mesh, &options, &plan, NULL), 0);
        options.rounding = 0.2;
        assert_int_equal(planish_smooth(plan, p.x, &options, NULL, &error), PLANISH_ERROR_ARGUMENT);
        assert_non_null(
            strstr(error.text, "options.rounding is 0.2, but the plan was made with 0.1"));
        assert_int_equal(planish_find_infeasible(plan, p.x, &options, NULL, &n, NULL, &error),
                         PLANISH_ERROR_ARGUMENT);
        assert_int_equal(n, -1);
        options.rounding = 0.1;
        assert_int_equal(planish_smooth(plan, p.x, &options, NULL, NULL), 0);
        assert_int_equal(planish_smooth(plan, p.x, NULL, NULL, NULL), 0);
        assert_int_equal(planish_find_infeasible(plan, p.x, NULL, NULL, &n, NULL, NULL), 0);
        assert_int_equal(n, 0);
        planish_plan_destroy(plan);
        cell_pair_release(&p);
        test_mesh_destroy(&box);
    }
}

/** The constraints of planish_find_slides, in out [n_nodes]. */
static void find_constraints(const cell_pair *p, double tolerance, uint8_t *out) {
    const planish_surface surface = {.tolerance = tolerance};
    double *direction = cell_pair_zeroed(p->mesh.n_nodes * p->mesh.dim, sizeof *direction);
    assert_int_equal(planish_find_slides(&p->mesh, &surface, 1, out, direction, NULL, NULL), 0);
    free(direction);
}

static int is_on_box(const cell_pair *p, int32_t node) {
    int is_on = 0;
    for (int d = 0; d < p->mesh.dim; d++)
        is_on |= *cell_pair_place(p, node, d) == 0 || *cell_pair_place(p, node, d) == 6;
    return is_on;
}

/** Ends of a curved edge of the surface do not slide, nor do corners of triangles that it curves. */
static void curved_surfaces_are_no_planes(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int off = 0; off < 2; off++) { /* the plane, along the first axis */
            test_mesh box = cell_pair_box(dim, 6, 0);
            cell_pair p = cell_pair_of(&box, PAIR_ORDER_2);
            const size_t n = (size_t)p.mesh.n_nodes;
            uint8_t *before = cell_pair_zeroed(p.mesh.n_nodes, 1),
                    *after = cell_pair_zeroed(p.mesh.n_nodes, 1);
            uint8_t *on_side = cell_pair_zeroed(p.mesh.n_nodes, 1);
            int64_t n_fixed = 0;
            cell_pair_fasten(&p);
            find_constraints(&p, 0, before);
            for (int64_t i = 0; i < p.plain.n_nodes; i++)
                on_side[i] =
                    *cell_pair_place(&p, i, 0) == 0 && before[i] != PLANISH_CONSTRAINT_FIXED;
            const edge e = find_edge(&p, on_side, 1.1);
            for (int d = off ? 0 : 1; d < (off ? 1 : dim); d++)
                *cell_pair_place(&p, e.mid, d) += d == 2 ? 0.004 : 0.005;
            find_constraints(&p, 0, after);
            assert_true(before[e.a] != PLANISH_CONSTRAINT_FIXED &&
                        after[e.a] == PLANISH_CONSTRAINT_FIXED &&
                        after[e.b] == PLANISH_CONSTRAINT_FIXED);
            for (size_t i = 0; i < n; i++) {
                n_fixed += after[i] != before[i];
                assert_true(after[i] == before[i] ||
                            (on_side[i] && after[i] == PLANISH_CONSTRAINT_FIXED));
            }
            assert_int_equal(n_fixed, dim == 3 && off ? 4 : 2);
            find_constraints(&p, 1e-3, after);
            assert_memory_equal(before, after, n);
            /* curved edges that go inside */
            for (int64_t i = p.plain.n_nodes; i < p.mesh.n_nodes; i++)
                for (int d = 0; d < dim; d++)
                    *cell_pair_place(&p, i, d) +=
                        is_on_box(&p, p.end[i][0]) && is_on_box(&p, p.end[i][1]) ? 0 : 0.01;
            for (int d = 0; d < dim; d++)
                *cell_pair_place(&p, e.mid, d) =
                    (*cell_pair_place(&p, e.a, d) + *cell_pair_place(&p, e.b, d)) / 2;
            find_constraints(&p, 0, after);
            assert_memory_equal(before, after, n);
            free(before);
            free(after);
            free(on_side);
            cell_pair_release(&p);
            test_mesh_destroy(&box);
        }
}

/** Constraints of the caller's stay, and mids are never fixed, by an edge with a tag neither. */
static void given_constraints_stay(void **state) {
    (void)state;
    test_mesh box = cell_pair_box(3, 4, 0);
    cell_pair p = cell_pair_of(&box, PAIR_ORDER_2 | PAIR_OTHERS);
    uint8_t *constraint = cell_pair_zeroed(p.mesh.n_nodes, 1),
            *out = cell_pair_zeroed(p.mesh.n_nodes, 1);
    double *direction = cell_pair_zeroed(p.mesh.n_nodes * 3, sizeof *direction);
    int32_t edge_of[2] = {0, 0};
    int64_t n_held = 0;
    cell_pair_fasten(&p);
    for (int64_t i = 0; i < p.plain.n_nodes; i++)
        constraint[i] = p.constraint[i] ? PLANISH_CONSTRAINT_ON_SURFACE : 0;
    for (int32_t i = (int32_t)p.plain.n_nodes; i < p.mesh.n_nodes; i++)
        if (p.end[i][0] >= 0) {
            edge_of[0] = p.end[i][0];
            edge_of[1] = i;
            constraint[i] = i % 2 ? PLANISH_CONSTRAINT_FREE : PLANISH_CONSTRAINT_FIXED;
        }
    constraint[edge_of[1]] = PLANISH_CONSTRAINT_FREE;
    const planish_surface surface = {.n_edges = 1, .edges = edge_of};
    p.mesh.constraint = constraint;
    assert_int_equal(planish_find_slides(&p.mesh, &surface, 1, out, direction, NULL, NULL), 0);
    for (int64_t i = 0; i < p.mesh.n_nodes; i++) {
        if (constraint[i] != PLANISH_CONSTRAINT_FREE || p.end[i][0] >= 0)
            assert_int_equal(out[i], constraint[i]);
        n_held += constraint[i] == PLANISH_CONSTRAINT_ON_SURFACE;
    }
    assert_true(n_held > 0);
    free(constraint);
    free(out);
    free(direction);
    cell_pair_release(&p);
    test_mesh_destroy(&box);
}

/** Elements of another type with as many nodes are no simplices. */
static void nodes_alone_make_no_simplex(void **state) {
    (void)state;
    static const double X[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
    static const int64_t OFFSET[] = {0, 4, 8};
    static const uint8_t TYPE[] = {10, 9};
    static const int32_t NODE[] = {0, 1, 2, 3, 4, 1, 2, 3};
    const planish_cells cells = {.n = 2, .type = TYPE, .offset = OFFSET, .node = NODE};
    const planish_mesh mesh = {
        .dim = 3, .n_nodes = 5, .n_elements = 2, .coordinates = X, .cells = &cells};
    planish_quality quality;
    assert_int_equal(planish_measure_mesh(&mesh, NULL, &quality, NULL), 0);
    assert_int_equal(quality.n_elements, 1);
    assert_int_equal(quality.worst_element, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cells_hold_nodes),
        cmocka_unit_test(curved_edges_hold_nodes_that_slide),
        cmocka_unit_test(calls_have_the_rounding_of_the_plan),
        cmocka_unit_test(curved_surfaces_are_no_planes),
        cmocka_unit_test(given_constraints_stay),
        cmocka_unit_test(nodes_alone_make_no_simplex),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
