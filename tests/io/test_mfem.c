/* MFEM: what is read, what is held, what is refused, what is written. */
#include "support/cell_meshes.h"
#include "support/file_builder.h"
#include "support/files.h"
#include "support/reading.h"
#include "support/rewriting.h"
#include "support/unit_elements.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define HEAD     "MFEM mesh v1.0\n\ndimension\n3\n\n"
#define TET      "elements\n1\n1 4 0 1 2 3\n"
#define NOTHING  "boundary\n0\n"
#define VERTICES "vertices\n4\n3\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"

/* All solid elements, sets, comments. Vertex 5 and on: a hexahedron, a wedge, a pyramid on it. */
static const char solid[] =
    "MFEM mesh v1.3\n\n#\n# MFEM Geometry Types (see fem/geom.hpp):\n#\n# PYRAMID = 7\n#\n\n"
    "dimension\n3\n\nelements\n5\n3 4 0 1 2 3\n4 4 1 2 3 4\n3 5 5 6 7 8 9 10 11 12\n"
    "-2 6 6 13 7 10 14 11\n4 7 9 10 11 12 15\n\nattribute_sets\n3\n\"two of \\\"them\"\n2\n3 4\n"
    "odd 1\n-2\n\"\" 0\n\n\n# the surface\nboundary\n3\n9 2 0 1 2\n8 3 5 6 10 9\n8 2 9 10 15\n\n"
    "bdr_attribute_sets\n1\n\"outer side\"\n2\n8 9\n\nvertices\n16\n3\n"
    "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 1 1.5\n"
    "5 0 0\n6 0 0\n6 1 0\n5 1 0\n5 0 1\n6.0 0 1\n6 1 1\n5 1 1\n7 0.5 0\n7 0.5 1\n5.5 .5e0 2\n"
    "\nmfem_mesh_end\nanything 1 2 3\n";

static void a_solid_is_read(void **state) {
    (void)state;
    static const int32_t simplices[] = {0, 1, 2, 3, 1, 2, 3, 4};
    static const int32_t others[] = {5, 6,  7,  8,  9, 10, 11, 12, 6, 13,
                                     7, 10, 14, 11, 9, 10, 11, 12, 15};
    static const reading_facts facts = {.dim = 3,
                                        .n_nodes = 16,
                                        .n_elements = 5,
                                        .n_regions = 3,
                                        .n_other = 0,
                                        .n_lower = 3,
                                        .precision = PLANISH_PRECISION_DOUBLE};
    planish_file *file = reading_text(&io_format_mfem, solid);
    reading_gave(file, &io_format_mfem, &facts);
    const io_model *model = &file->model;
    const planish_mesh mesh = planish_file_mesh(file);
    assert_memory_equal(mesh.cells->node, simplices, sizeof simplices);
    assert_memory_equal(mesh.cells->node + 8, others, sizeof others);
    assert_true(mesh.coordinates[14] == 1.5);
    assert_int_equal(planish_file_node_number(file, 4), 4);
    assert_int_equal(planish_file_element_number(file, 1), 1);
    assert_int_equal(planish_file_element_number(file, 4), 4);
    assert_int_equal(reading_tag(file, model->tetrahedron.entity, 1), 4);
    assert_int_equal(reading_tag(file, model->solid.entity, 1), -2);
    assert_int_equal(reading_tag(file, model->triangle.entity, 0), 9);
    assert_int_equal(reading_tag(file, model->flat.entity, 0), 8);
    assert_int_equal(model->n_groups, 5);
    reading_group_is(file, 0, "two of \"them", 3, 3);
    reading_group_is(file, 1, "two of \"them", 3, 4);
    reading_group_is(file, 2, "odd", 3, -2);
    reading_group_is(file, 3, "outer side", 2, 8);
    reading_group_is(file, 4, "outer side", 2, 9);
    planish_file_close(file);
}

static void nodes_are_held(void **state) {
    (void)state;
    planish_file *file = reading_text(&io_format_mfem, solid);
    unit_expect_held(file, NULL, "1110011001100001");
    unit_expect_held(file, "odd", "1110011101110111");
    unit_expect_held(file, "two of \"them", "1111111111111001");
    unit_expect_held(file, "2:9", "1110011001100001");
    planish_file_close(file);
}

/* ---- planes -------------------------------------------------------------------------------------- */

static const char flat[] = "MFEM mesh v1.2\ndimension\n2\nelements\n3\n1 2 0 1 2\n2 3 1 3 4 2\n"
                           "1 2 2 4 5\nboundary\n2\n7 1 0 1\n8 1 1 3\nvertices\n6\n2\n"
                           "0 0\n1 0\n0 1\n2 0\n2 1\n1e0 2\n\nmfem_mesh_end\n";

static void a_plane_is_read(void **state) {
    (void)state;
    planish_file *file = reading_text(&io_format_mfem, flat);
    const planish_mesh mesh = planish_file_mesh(file);
    assert_int_equal(mesh.dim, 2);
    assert_int_equal(mesh.n_elements, 3);
    assert_int_equal(file->model.triangle.n, 2);
    assert_int_equal(planish_file_element_number(file, 1), 2); /* triangles first */
    assert_int_equal(planish_file_element_number(file, 2), 1);
    assert_int_equal(reading_tag(file, file->model.line.entity, 1), 8);
    assert_true(mesh.coordinates[11] == 2);
    unit_expect_held(file, NULL, "110100");
    planish_file_close(file);
    reading_gives_surface(
        &io_format_mfem,
        "MFEM mesh v1.0\ndimension\n2\nelements\n2\n1 2 0 1 2\n1 2 0 1 3\n" NOTHING VERTICES);
}

static void sections_may_have_comments_and_line_ends_of_every_kind(void **state) {
    (void)state;
    char text[sizeof flat + 64];
    size_t used = 0;
    for (size_t i = 0; i < sizeof flat; i++) {
        if (flat[i] == '\n')
            text[used++] = '\r';
        text[used++] = flat[i];
    }
    planish_file *file = reading_text(&io_format_mfem, text);
    assert_int_equal(planish_file_mesh(file).n_elements, 3);
    planish_file_close(file);
    file =
        reading_text(&io_format_mfem,
                     "\xef\xbb\xbfMFEM mesh v1.0\n#a\ndimension # b\n3\n#c 7\nelements\n#d\n1 # e\n"
                     "1 4 0 1 2 3\n#f\nboundary\n0\n#g\nvertices\n4 #h\n# i\n3\n0 0 0 # j\n"
                     "1 0 0\n#k\n0 1 0\n0 0 1\n# more\n");
    assert_int_equal(planish_file_mesh(file).n_elements, 1);
    planish_file_close(file);
}

/* ---- elements ------------------------------------------------------------------------------------ */

enum { STRAIGHT, H1, QUADRATIC, L2, DISCONT };

/** A type in the order of a collection; row.code is MFEM's geometry. */
static const struct {
    unit_element row;
    int space, order, extra; /* further values of an element */
} types[] = {
    {{PLANISH_CELL_TRIANGLE, 2, "0 1 2"}, STRAIGHT, 1, 0},
    {{PLANISH_CELL_QUADRILATERAL, 3, "0 1 2 3"}, STRAIGHT, 1, 0},
    {{PLANISH_CELL_TETRAHEDRON, 4, "0 1 2 3"}, STRAIGHT, 1, 0},
    {{PLANISH_CELL_HEXAHEDRON, 5, "0 1 2 3 4 5 6 7"}, STRAIGHT, 1, 0},
    {{PLANISH_CELL_WEDGE, 6, "0 1 2 3 4 5"}, STRAIGHT, 1, 0},
    {{PLANISH_CELL_PYRAMID, 7, "0 1 2 3 4"}, STRAIGHT, 1, 0},
    {{PLANISH_CELL_TRIANGLE, 2, "0 1 2"}, H1, 1, 0},
    {{PLANISH_CELL_HEXAHEDRON, 5, "0 1 2 3 4 5 6 7"}, H1, 1, 0},
    {{PLANISH_CELL_TRIANGLE6, 2, "0 1 2 01 12 20"}, H1, 2, 0},
    {{PLANISH_CELL_QUADRILATERAL9, 3, "0 1 2 3 01 12 23 30 0123"}, H1, 2, 1},
    {{PLANISH_CELL_TETRAHEDRON10, 4, "0 1 2 3 01 02 03 12 13 23"}, H1, 2, 0},
    {{PLANISH_CELL_HEXAHEDRON27, 5,
      "0 1 2 3 4 5 6 7 01 12 32 03 45 56 76 47 04 15 26 37 3210 0154 1265 2376 3047 4567 01234567"},
     H1,
     2,
     1},
    {{PLANISH_CELL_WEDGE18, 6, "0 1 2 3 4 5 01 12 20 34 45 53 03 14 25 0143 1254 2035"}, H1, 2, 0},
    {{PLANISH_CELL_PYRAMID14, 7, "0 1 2 3 4 01 12 32 03 04 14 24 34 3210"}, H1, 2, 1},
    {{PLANISH_CELL_TRIANGLE6, 2, "0 1 2 01 12 20"}, QUADRATIC, 2, 0},
    {{PLANISH_CELL_TETRAHEDRON10, 4, "0 1 2 3 01 02 03 12 13 23"}, QUADRATIC, 2, 0},
    {{PLANISH_CELL_TRIANGLE, 2, "0 1 2"}, L2, 1, 0},
    {{PLANISH_CELL_QUADRILATERAL, 3, "0 1 3 2"}, L2, 1, 0},
    {{PLANISH_CELL_TETRAHEDRON, 4, "0 1 2 3"}, L2, 1, 0},
    {{PLANISH_CELL_HEXAHEDRON, 5, "0 1 3 2 4 5 7 6"}, L2, 1, 0},
    {{PLANISH_CELL_WEDGE, 6, "0 1 2 3 4 5"}, L2, 1, 0},
    {{PLANISH_CELL_TRIANGLE6, 2, "0 01 1 02 12 2"}, L2, 2, 0},
    {{PLANISH_CELL_QUADRILATERAL9, 3, "0 01 1 03 0123 12 3 23 2"}, L2, 2, 0},
    {{PLANISH_CELL_TETRAHEDRON10, 4, "0 01 1 02 12 2 03 13 23 3"}, L2, 2, 0},
    {{PLANISH_CELL_HEXAHEDRON27, 5,
      "0 01 1 03 0123 12 3 32 2 04 0154 15 0374 01234567 1265 37 3267 26 4 45 5 47 4567 56 7 76 6"},
     L2,
     2,
     0},
    {{PLANISH_CELL_WEDGE18, 6, "0 01 1 02 12 2 03 0143 14 2035 1254 25 3 34 4 35 45 5"}, L2, 2, 0},
    {{PLANISH_CELL_QUADRILATERAL, 3, "0 1 2 3"}, DISCONT, 1, 0},
    {{PLANISH_CELL_PYRAMID, 7, "0 1 2 3 4"}, DISCONT, 1, 0},
    {{PLANISH_CELL_TETRAHEDRON10, 4, "0 1 2 3 01 02 03 12 13 23"}, DISCONT, 2, 0},
};
enum { N_TYPES = sizeof types / sizeof *types };

/** Write the head of `nodes`. */
static void write_space(file_builder *b, int space, int dim, int order, int columns, int ordering) {
    builder_text(b, "nodes\nFiniteElementSpace\nFiniteElementCollection: ");
    if (space == H1)
        builder_text(b, "H1_%dD_P%d", dim, order);
    else if (space == L2)
        builder_text(b, "L2_T%d_%dD_P%d", order == 1 ? 1 : 4, dim, order);
    else if (space == QUADRATIC)
        builder_text(b, "%s", order == 1 ? "Linear" : "Quadratic");
    else
        builder_text(b, "%sDiscont%dD", order == 1 ? "Linear" : "Quadratic", dim);
    builder_text(b, "\nVDim: %d\nOrdering: %d\n\n", columns, ordering);
}

/** Write n values, those of each node or those of each component together. */
static void write_values(file_builder *b, int64_t n, double (*x)[3], int columns, int ordering) {
    for (int64_t i = 0; i < n * columns; i++) {
        const int64_t node = ordering ? i / columns : i % n, d = ordering ? i % columns : i / n;
        builder_text(b, "%.17g%s", x[node][d], !ordering || d == columns - 1 ? "\n" : " ");
    }
}

static int current; /* row of types */

/** Write two elements of the same vertices. Values that each element has of its own come twice. */
static file_builder make_type(int i, int m, double x[UNIT_NODES][3], int variant, int64_t *second) {
    file_builder b = {0};
    (void)i;
    const int space = types[current].space, order = types[current].order;
    const int dim = unit_dim(types[current].row.type), columns = dim == 3 || variant ? 3 : 2;
    static const int corners[] = {[2] = 3, [3] = 4, [4] = 4, [5] = 8, [6] = 6, [7] = 5};
    const int geometry = types[current].row.code, n = corners[geometry];
    double all[2 * UNIT_NODES][3];
    *second = 1;
    builder_text(&b, "MFEM mesh v1.0\ndimension\n%d\nelements\n2\n", dim);
    for (int k = 0; k < 2; k++) {
        builder_text(&b, "1 %d", geometry);
        for (int c = 0; c < n; c++)
            builder_text(&b, " %d", c);
        builder_text(&b, "\n");
    }
    builder_text(&b, "boundary\n0\nvertices\n%d\n", n);
    memcpy(all, x, (size_t)m * sizeof *x);
    if (space == STRAIGHT) {
        builder_text(&b, "%d\n", columns);
        write_values(&b, n, all, columns, 1);
        return b;
    }
    /* Inside nodes of H1 are the last ones; those of pyramids are no nodes of theirs. */
    const int is_own = space == L2 || space == DISCONT;
    const int n_again = is_own ? m : types[current].extra + (geometry == 7);
    for (int k = 0; k < n_again; k++)
        memcpy(all[m + k], is_own ? x[k] : x[m - 1], sizeof *x);
    write_space(&b, space, dim, order, columns, variant);
    write_values(&b, m + n_again, all, columns, variant);
    return b;
}

static void every_type_has_its_nodes_in_order(void **state) {
    (void)state;
    for (current = 0; current < N_TYPES; current++)
        unit_expect_types(&io_format_mfem, &types[current].row, 1, make_type);
}

/* ---- numbers of mids ----------------------------------------------------------------------------- */

/** Edges and quadrilateral faces of MFEM's geometries (fem/geom.cpp), as in unit_element. */
static const char *const edges_of[] = {
    [2] = "01 12 20",
    [3] = "01 12 23 30",
    [4] = "01 02 03 12 13 23",
    [5] = "01 12 32 03 45 56 76 47 04 15 26 37",
    [6] = "01 12 20 34 45 53 03 14 25",
};
static const char *const faces_of[] = {
    [5] = "3210 0154 1265 2376 3047 4567", [6] = "0143 1254 2035"};

/** Nodes that have been numbered, by their places. */
typedef struct numbered {
    int64_t n;
    double x[4096][3];
} numbered;

/** Add the middle of some nodes of a cell; is_own: even if there is one already. */
static void add_middle(numbered *all, int64_t first, const cell_box *box, const int32_t *node,
                       const char *corners, int n, int is_own) {
    double x[3] = {0, 0, 0};
    for (int k = 0; k < n; k++)
        for (int d = 0; d < 3; d++)
            x[d] += box->x[box->mesh.dim * node[corners[k] - '0'] + d] / n;
    for (int64_t i = first; i < all->n && !is_own; i++)
        if (fabs(all->x[i][0] - x[0]) + fabs(all->x[i][1] - x[1]) + fabs(all->x[i][2] - x[2]) <
            1e-9)
            return;
    assert_in_range(all->n, 0, 4095);
    memcpy(all->x[all->n++], x, sizeof x);
}

static int geometry_of(int type) {
    static const int types_of[][2] = {
        {PLANISH_CELL_TETRAHEDRON, 4}, {PLANISH_CELL_HEXAHEDRON, 5}, {PLANISH_CELL_WEDGE, 6}};
    for (int i = 0; i < 3; i++)
        if (types_of[i][0] == type)
            return types_of[i][1];
    return 0;
}

/** Write a box as a mesh of second order, numbered by a search among all that are there already. */
static file_builder write_box(const cell_box *box, int ordering, numbered *all) {
    file_builder b = {0};
    const planish_cells *cells = &box->cells;
    builder_text(&b, HEAD "elements\n%d\n", (int)cells->n);
    for (int64_t i = 0; i < cells->n; i++) {
        builder_text(&b, "%d %d", (int)(i % 3), geometry_of(cells->type[i]));
        for (int64_t k = cells->offset[i]; k < cells->offset[i + 1]; k++)
            builder_text(&b, " %d", cells->node[k]);
        builder_text(&b, "\n");
    }
    builder_text(&b, NOTHING "vertices\n%d\n", (int)box->mesh.n_nodes);
    write_space(&b, H1, 3, 2, 3, ordering);
    all->n = box->mesh.n_nodes;
    memcpy(all->x, box->x, (size_t)all->n * sizeof *all->x);
    for (int part = 0; part < 3; part++) {
        const int64_t first = all->n;
        for (int64_t i = 0; i < cells->n; i++) {
            const int g = geometry_of(cells->type[i]);
            const int32_t *node = cells->node + cells->offset[i];
            const char *list = part == 0 ? edges_of[g] : faces_of[g];
            if (part == 2 && g == 5)
                add_middle(all, first, box, node, "01234567", 8, 1);
            for (const char *at = list; part < 2 && at && *at; at += part == 0 ? 3 : 5) {
                add_middle(all, first, box, node, at, part == 0 ? 2 : 4, 0);
                if (at[part == 0 ? 2 : 4] == '\0')
                    break;
            }
        }
    }
    write_values(&b, all->n, all->x, 3, ordering);
    return b;
}

static void mids_are_between_their_corners(void **state) {
    (void)state;
    static numbered all;
    for (int kind = 0; kind < 4; kind++) {
        cell_box *box = cell_box_create(kind / 2 ? BOX_WEDGES : BOX_HEXAHEDRA, 3);
        file_builder b = write_box(box, kind % 2, &all);
        planish_file *file = builder_file(&b, &io_format_mfem);
        const planish_mesh mesh = planish_file_mesh(file);
        assert_int_equal(mesh.n_nodes, all.n);
        cell_box *raised = cell_box_raise(box, 1);
        assert_int_equal(mesh.cells->n, raised->cells.n);
        for (int64_t i = 0; i < raised->cells.offset[raised->cells.n]; i++)
            for (int d = 0; d < 3; d++) {
                const double x = mesh.coordinates[3 * mesh.cells->node[i] + d];
                const double wanted = raised->x[3 * raised->cells.node[i] + d];
                assert_true(fabs(x - wanted) < 1e-14);
            }
        planish_file_close(file);
        builder_expect_same_on_threads(&b, &io_format_mfem);
        builder_release(&b);
        cell_box_destroy(raised);
        cell_box_destroy(box);
    }
}

/* Two tetrahedra of second order: vertex 5 is in no element, so that it has no value. */
static const char curved[] =
    HEAD "elements\n2\n1 4 0 1 2 3\n2 4 4 1 2 3\nboundary\n2\n5 2 1 2 3\n6 2 0 2 1\n"
         "vertices\n6\nnodes\nFiniteElementSpace\nFiniteElementCollection: H1_3D_P2\nVDim: 3\n"
         "Ordering: 1\n\n0 0 0\n2 0 0\n0 2 0\n0 0 2\n3 3 3\n"
         "1 0 0\n0 1 0\n0 0 1\n1 1 0.1\n1 0 1\n0 1 1\n2.5 1.5 1.5\n1.5 2.5 1.5\n1.5 1.5 2.5\n";

static void facets_of_second_order_have_mids(void **state) {
    (void)state;
    static const int32_t mids[] = {8, 10, 9, 6, 8, 5};
    planish_file *file = reading_text(&io_format_mfem, curved);
    assert_int_equal(planish_file_mesh(file).n_nodes, 5 + 9);
    assert_int_equal(file->model.triangle.n, 2);
    assert_memory_equal(file->model.triangle.mid, mids, sizeof mids);
    unit_expect_held(file, NULL, "11110110111000");
    planish_file_close(file);
}

/* ---- periodic meshes ------------------------------------------------------------------------------ */

/* Three quadrilaterals in a row, periodic along x: the last joins the first. */
static const char ring[] =
    "MFEM mesh v1.0\ndimension\n2\nelements\n6\n1 3 0 1 4 3\n1 3 1 2 5 4\n1 3 2 0 3 5\n"
    "1 3 3 4 7 6\n1 3 4 5 8 7\n1 3 5 3 6 8\n"
    "boundary\n2\n7 1 1 2\n7 1 2 0\nvertices\n9\n\nnodes\nFiniteElementSpace\n"
    "FiniteElementCollection: L2_T1_2D_P1\nVDim: 2\nOrdering: 1\n\n"
    "0 0\n1 0\n0 1\n1 1\n1 0\n2 0\n1 1\n2 1\n2 0\n3 0\n2 1\n3 1\n"
    "0 1\n1 1\n0 2\n1 2\n1 1\n2 1\n1 2\n2 2\n2 1\n3 1\n2 2\n3 2\n";

static void nodes_of_seams_are_held(void **state) {
    (void)state;
    planish_file *file = reading_text(&io_format_mfem, ring);
    const io_model *model = &file->model;
    uint8_t constraint[12];
    planish_error error;
    assert_int_equal(planish_file_mesh(file).n_nodes, 12);
    assert_int_equal(model->n_places, 24);
    assert_int_equal(model->line.n, 1); /* the other one ends at a vertex with two places */
    assert_int_equal(model->n_lower, 2);
    /* 0 0, 1 0, 0 1, 1 1, 2 0, 2 1, 3 0, 3 1, 0 2, 1 2, 2 2, 3 2 */
    unit_expect_held(file, NULL, "111010111001");
    /* Places of a vertex are no pairs of periodic nodes: those of a seam stay where they are. */
    const uint8_t seam = IO_HELD_REQUIRED | IO_HELD_PERIODIC;
    assert_int_equal(model->n_periodic, 0);
    for (int i = 0; i < 12; i++)
        assert_int_equal((model->hold[i] & seam) == seam, "101000111001"[i] == '1');
    const planish_hold slide = {.slide = 1};
    assert_int_equal(planish_file_constraints(file, &slide, constraint, &error), 0);
    for (int i = 0; i < 12; i++)
        assert_int_equal(constraint[i], "101010111001"[i] == '1' ? PLANISH_CONSTRAINT_FIXED
                                                                 : PLANISH_CONSTRAINT_FREE);
    planish_file_close(file);
}

/* Two triangles of second order at the same places, with vertices of their own: a crack. */
static const char crack[] =
    "MFEM mesh v1.0\ndimension\n2\nelements\n2\n1 2 0 1 2\n1 2 4 3 5\nboundary\n0\nvertices\n6\n\n"
    "nodes\nFiniteElementSpace\nFiniteElementCollection: L2_T1_2D_P2\nVDim: 2\nOrdering: 0\n\n"
    "0 1 2 0 1 0\n2 1 0 2 1 2\n0 0 0 1 1 2\n0 0 0 -1 -1 -2\n";

static void nodes_of_several_vertices_are_held(void **state) {
    (void)state;
    planish_file *file = reading_text(&io_format_mfem, crack);
    assert_int_equal(planish_file_mesh(file).n_nodes, 9);
    unit_expect_held(file, NULL, "111000000");
    planish_file_close(file);
}

/* Two triangles of second order, and a boundary element between them. */
static const char divided[] =
    "MFEM mesh v1.0\ndimension\n2\nelements\n2\n1 2 0 1 2\n1 2 1 3 2\nboundary\n1\n7 1 1 2\n"
    "vertices\n4\n\nnodes\nFiniteElementSpace\nFiniteElementCollection: L2_T1_2D_P2\nVDim: 2\n"
    "Ordering: 1\n\n0 0\n1 0\n2 0\n0 1\n1 1\n0 2\n2 0\n2 1\n2 2\n1 1\n1 2\n0 2\n";

static void boundary_elements_have_the_mids_of_elements(void **state) {
    (void)state;
    planish_file *file = reading_text(&io_format_mfem, divided);
    assert_int_equal(planish_file_mesh(file).n_nodes, 9);
    assert_int_equal(file->model.line.n, 1);
    unit_expect_held(file, NULL, "001011000");
    unit_expect_held(file, "1:7", "001011000");
    planish_file_close(file);
}

/* ---- parts of parallel meshes --------------------------------------------------------------------- */

#define PART                                                                                       \
    "MFEM mesh v1.2\ndimension\n3\n" TET NOTHING VERTICES "\nmfem_serial_mesh_end\n\n"             \
    "communication_groups\nnumber_of_groups 2\n\n# ids\n1 0\n2 0 1\n\n"                            \
    "total_shared_vertices %d\ntotal_shared_edges 1\ntotal_shared_faces 0\n\n# group 1\n"          \
    "shared_vertices 2\n1\n3\n\nshared_edges 1\n1 3\n\nshared_faces 0\n\nmfem_mesh_end\n"

static void shared_vertices_are_held(void **state) {
    (void)state;
    char text[1024];
    snprintf(text, sizeof text, PART, 2);
    planish_file *file = reading_text(&io_format_mfem, text);
    unit_expect_held(file, NULL, "0101");
    planish_file_close(file);
    snprintf(text, sizeof text, PART, 3);
    reading_fails(&io_format_mfem, text, "3 shared vertices");
    *strstr(text, "\nmfem_mesh_end") = '\0';
    reading_fails(&io_format_mfem, text, "mfem_mesh_end expected");
}

/* ---- what is wrong -------------------------------------------------------------------------------- */

#define NODES   "nodes\nFiniteElementSpace\nFiniteElementCollection: "
#define PYRAMID HEAD "elements\n1\n1 7 0 1 2 3 4\n" NOTHING "vertices\n5\n"
#define FLAT    "MFEM mesh v1.0\ndimension\n2\nelements\n1\n1 2 0 1 2\n" NOTHING "vertices\n3\n" NODES

static void wrong_files_are_refused(void **state) {
    (void)state;
    static const reading_refusal cases[] = {
        {"mesh\n", "no 'MFEM mesh v1.0'"},
        {"MFEM mesh v2.0\n", "version"},
        {"MFEM mesh v1.01\n", "version"},
        {"MFEM INLINE mesh v1.0\n\ntype = quad\n", "save it (mesh.Save)"},
        {"MFEM NURBS mesh v1.1\n", "SetCurvature(2)"},
        {"MFEM NURBS NC-patch mesh v1.0\n", "SetCurvature(2)"},
        {"MFEM NC mesh v1.1\n", "hanging nodes"},
        {"MFEM mesh v1.0\n", "dimension expected"},
        {"MFEM mesh v1.0\ndimension\n1\n", "dimension 1"},
        {"MFEM mesh v1.0\ndimension\nx\n", "after dimension"},
        {HEAD "boundary\n0\n", "test:6: elements expected"},
        {HEAD "elements\n-1\n", "whole number of 0 or more"},
        {HEAD "elements\n4611686018427387904\n1 4 0 1 2 3\n" NOTHING VERTICES, "cannot be in"},
        {HEAD "elements\n2\n1 4 0 1 2 3\n" NOTHING VERTICES, "element 1: a whole number"},
        {HEAD "elements\n1\n1 4 0 1 2 3\n1 4 0 1 2 3\n" NOTHING VERTICES, "more than 1"},
        {HEAD "elements\n1\n1 4 0 1 2 4\n" NOTHING VERTICES, "test:8: element 0: number 4"},
        {HEAD "elements\n1\n1 4 0 1 2 -1\n" NOTHING VERTICES, "not in 0 .. 3"},
        {HEAD "elements\n1\n1 8 0 1 2 3\n" NOTHING VERTICES, "not in 0 .. 7"},
        {HEAD "elements\n1\n1 2 0 1 2\n" NOTHING VERTICES, "geometry 2 has 2 dimensions"},
        {HEAD "elements\n1\n99999999999 4 0 1 2 3\n" NOTHING VERTICES, "99999999999 is not in"},
        {HEAD TET "boundary\n1\n1 1 0 1\n" VERTICES, "boundary element 0: geometry 1"},
        {HEAD TET VERTICES, "boundary expected"},
        {HEAD TET NOTHING "vertex_parents\n0\n" VERTICES, "hanging nodes"},
        {HEAD TET NOTHING "coarse_elements\n0\n" VERTICES, "hanging nodes"},
        {HEAD TET NOTHING "vertices\n4\n2\n0 0 0 0 0 0 0 0\n", "number of coordinates"},
        {HEAD TET NOTHING "vertices\n4\n4\n0 0 0 0 0 0 0 0\n", "number of coordinates"},
        {HEAD TET NOTHING "vertices\n2000000000\n3\n0 0 0\n", "cannot be in"},
        {HEAD TET NOTHING "vertices\n4\n3\n0 0 0\n1 0 0\n0 1 0\n0 0\n", "vertex 3: a coordinate"},
        {HEAD TET NOTHING "vertices\n4\n3\n0 0 0\n1 0 0\n0 1 0\n0 0 nan\n", "not finite"},
        {HEAD TET NOTHING VERTICES "7\n", "more coordinates follow"},
        {"MFEM mesh v1.2\ndimension\n3\n" TET NOTHING VERTICES, "mfem_mesh_end expected"},
        {"MFEM mesh v1.3\ndimension\n3\n" TET NOTHING VERTICES, "attribute_sets expected"},
        {"MFEM mesh v1.3\ndimension\n3\n" TET "attribute_sets\n1\n\"a", "name 1 of 1"},
        {"MFEM mesh v1.3\ndimension\n3\n" TET "attribute_sets\n1\na 2 1\n", "whole number"},
        {"MFEM mesh v1.3\ndimension\n3\n" TET "attribute_sets\n1\na 99999 1\n", "cannot be in"},
        {FLAT "H1_2D_P1\nVDim: 2\nOrdering: 1\n0 0\n1 0\n0\n", "node 2: a coordinate"},
        {FLAT "H1_2D_P1\nVDim: 2\nOrdering: 0\n0 0 1 0 0 1 5\n", "more coordinates follow"},
        {FLAT "H1_2D_P2\nVDim: 2\nOrdering: 1\n0 0\n1 0\n0 1\n", "cannot be in"},
        {FLAT "H1_2D_P3\nVDim: 2\nOrdering: 1\n0 0\n", "third order or higher"},
        {FLAT "Cubic\nVDim: 2\nOrdering: 1\n0 0\n", "mesh.SetCurvature(2), then Save"},
        {FLAT "H1Pos_2D_P2\nVDim: 2\nOrdering: 1\n0 0\n", "'H1Pos_2D_P2' are not read"},
        {FLAT "H1_3D_P1\nVDim: 2\nOrdering: 1\n0 0\n", "'H1_3D_P1' are not read"},
        {FLAT "L2_2D_P1\nVDim: 2\nOrdering: 1\n0 0\n", "'L2_2D_P1' are not read"},
        {FLAT "L2_T0_2D_P1\nVDim: 2\nOrdering: 1\n0 0\n", "are not read"},
        {FLAT "H1_2D_P0\nVDim: 2\nOrdering: 1\n0 0\n", "are not read"},
        {FLAT "H1_2D_P1x\nVDim: 2\nOrdering: 1\n0 0\n", "are not read"},
        {FLAT "H1_2D_P1\nVDim: 1\nOrdering: 1\n0 0\n", "VDim: 0: number 1 is not in"},
        {FLAT "H1_2D_P1\nVDim: 2\nOrdering: 2\n0 0\n", "not in 0 .. 1"},
        {FLAT "H1_2D_P1\nOrdering: 2\n0 0\n", "VDim: expected"},
        {"MFEM mesh v1.0\ndimension\n2\n"
         "elements\n1\n1 2 0 1 2\n" NOTHING "vertices\n3\nnodes\nx\n",
         "FiniteElementSpace expected"},
        {PYRAMID NODES "L2_T1_3D_P1\nVDim: 3\nOrdering: 1\n0 0 0\n", "element 0 is a pyramid"},
        {PYRAMID NODES "L2_T4_3D_P2\nVDim: 3\nOrdering: 1\n0 0 0\n", "SetCurvature(2)"},
        {PYRAMID NODES "QuadraticDiscont3D\nVDim: 3\nOrdering: 1\n0 0 0\n", "is a pyramid"},
    };
    reading_refuses(&io_format_mfem, cases, sizeof cases / sizeof *cases);
}

static void spaces_of_all_names_are_read(void **state) {
    (void)state;
    static const char *const names[] = {
        "nodes\nFiniteElementSpace\nFiniteElementCollection: H1@G_2D_P1\n",
        "nodes\n\n# c\nFiniteElementSpace\r\nFiniteElementCollection: H1@U_2D_P1_Pyr0 \r\n",
        "nodes\nMFEM FiniteElementSpace v1.0\nFiniteElementCollection: Linear\n"};
    for (int i = 0; i < 3; i++) {
        char text[512];
        snprintf(text, sizeof text,
                 "MFEM mesh v1.1\ndimension\n2\nelements\n1\n1 2 0 1 2\n" NOTHING
                 "vertices\n3\n%sVDim: 2\nOrdering: 0\n%s\n0 0 1 0 1 0\n",
                 names[i], i == 2 ? "End: MFEM FiniteElementSpace v1.0\n" : "");
        planish_file *file = reading_text(&io_format_mfem, text);
        assert_true(planish_file_mesh(file).coordinates[4] == 1);
        planish_file_close(file);
    }
}

static void files_are_cut_anywhere(void **state) {
    (void)state;
    static const char *const texts[] = {solid, flat, curved, ring, crack};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        file_builder b = builder_of(texts[i]);
        builder_try_to_break(&b, &io_format_mfem);
        builder_expect_same_on_threads(&b, &io_format_mfem);
    }
}

static void other_files_are_not_recognised(void **state) {
    (void)state;
    static const char medit[] = "MeshVersionFormatted 2\n", later[] = "\nMFEM mesh v9\n";
    assert_false(io_format_mfem.recognise(medit, sizeof medit - 1));
    assert_true(io_format_mfem.recognise(later, sizeof later - 1));
    assert_true(io_format_mfem.recognise(solid, sizeof solid - 1));
}

/* ---- writing -------------------------------------------------------------------------------------- */

static void nothing_but_coordinates_changes(void **state) {
    static const char *const texts[] = {solid, flat, curved, ring, crack};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        rewriting_keeps_the_rest(&io_format_mfem, texts[i], (int64_t)strlen(texts[i]), *state);
}

static void components_apart_are_written_apart(void **state) {
    rewriting_gives(&io_format_mfem,
                    FLAT "H1_2D_P1\nVDim: 2\nOrdering: 0\n0.0 1. 0e0\n0 #b\n00 1\n", "xy",
                    FLAT "H1_2D_P1\nVDim: 2\nOrdering: 0\n0.125 1. 0e0\n-0.3333333333333333 #b\n"
                         "00 1\n",
                    *state);
    rewriting_gives(&io_format_mfem, FLAT "H1_2D_P1\nVDim: 2\nOrdering: 0\n0.0 1. 0e0\n0 00 1", "y",
                    FLAT "H1_2D_P1\nVDim: 2\nOrdering: 0\n0.0 1. 0e0\n-0.3333333333333333 00 1",
                    *state);
    /* In space the third component of a plane mesh stays. */
    rewriting_gives(
        &io_format_mfem, FLAT "H1_2D_P1\nVDim: 3\nOrdering: 0\n0.0 1. 0e0\n0 00 1\n.5 .5 .50\n",
        "x", FLAT "H1_2D_P1\nVDim: 3\nOrdering: 0\n0.125 1. 0e0\n0 00 1\n.5 .5 .50\n", *state);
    /* All values of one place change. */
    char moved[sizeof ring + 64];
    strcpy(moved, ring);
    char *first = strstr(moved, "\n0 0\n1 0\n0 1\n");
    memmove(first + 7, first + 3, strlen(first + 3) + 1);
    memcpy(first + 1, "0.125", 5);
    rewriting_gives(&io_format_mfem, ring, "x", moved, *state);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_solid_is_read),
        cmocka_unit_test(nodes_are_held),
        cmocka_unit_test(a_plane_is_read),
        cmocka_unit_test(sections_may_have_comments_and_line_ends_of_every_kind),
        cmocka_unit_test(every_type_has_its_nodes_in_order),
        cmocka_unit_test(mids_are_between_their_corners),
        cmocka_unit_test(facets_of_second_order_have_mids),
        cmocka_unit_test(nodes_of_seams_are_held),
        cmocka_unit_test(nodes_of_several_vertices_are_held),
        cmocka_unit_test(boundary_elements_have_the_mids_of_elements),
        cmocka_unit_test(shared_vertices_are_held),
        cmocka_unit_test(wrong_files_are_refused),
        cmocka_unit_test(spaces_of_all_names_are_read),
        cmocka_unit_test(files_are_cut_anywhere),
        cmocka_unit_test(other_files_are_not_recognised),
        cmocka_unit_test(nothing_but_coordinates_changes),
        cmocka_unit_test(components_apart_are_written_apart),
    };
    return cmocka_run_group_tests(tests, test_folder_create, test_folder_remove);
}
