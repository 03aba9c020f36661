/* Tests of the elements of MSH files: every type in every encoding, on any number of threads; and
 * what a mesh of second order is. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/file_builder.h"
#include "support/files.h"
#include "support/gmsh_builder.h"
#include "support/reading.h"
#include "support/rewriting.h"
#include "support/unit_elements.h"

/* Types and the order of nodes as the figures of Gmsh's manual have them ("Node ordering"). */
#define HEXAHEDRON   "0 1 2 3 4 5 6 7"
#define HEXAHEDRON20 HEXAHEDRON " 01 03 04 12 15 23 26 37 45 47 56 67"
#define WEDGE15      "0 1 2 3 4 5 01 02 03 12 14 25 34 35 45"
#define PYRAMID13    "0 1 2 3 4 01 03 04 12 14 23 24 34"
static const unit_element elements[] = {
    {PLANISH_CELL_TRIANGLE, 2, "0 1 2"},
    {PLANISH_CELL_QUADRILATERAL, 3, "0 1 2 3"},
    {PLANISH_CELL_TRIANGLE6, 9, "0 1 2 01 12 20"},
    {PLANISH_CELL_QUADRILATERAL9, 10, "0 1 2 3 01 12 23 30 0123"},
    {PLANISH_CELL_QUADRILATERAL8, 16, "0 1 2 3 01 12 23 30"},
    {PLANISH_CELL_TETRAHEDRON, 4, "0 1 2 3"},
    {PLANISH_CELL_HEXAHEDRON, 5, HEXAHEDRON},
    {PLANISH_CELL_WEDGE, 6, "0 1 2 3 4 5"},
    {PLANISH_CELL_PYRAMID, 7, "0 1 2 3 4"},
    {PLANISH_CELL_TETRAHEDRON10, 11, "0 1 2 3 01 12 02 03 23 13"},
    {PLANISH_CELL_HEXAHEDRON27, 12, HEXAHEDRON20 " 0321 0154 0473 1265 2376 4567 01234567"},
    {PLANISH_CELL_WEDGE18, 13, WEDGE15 " 0143 0352 1254"},
    {PLANISH_CELL_PYRAMID14, 14, PYRAMID13 " 0123"},
    {PLANISH_CELL_HEXAHEDRON20, 17, HEXAHEDRON20},
    {PLANISH_CELL_WEDGE15, 18, WEDGE15},
    {PLANISH_CELL_PYRAMID13, 19, PYRAMID13},
};
enum { N_ELEMENTS = sizeof elements / sizeof *elements };

enum { MSH1 = 10, MSH2 = 22, MSH40 = 40, MSH41 = 41 };

/** How a file is written; what is in it: times elements of each type of a dimension. */
typedef struct encoding {
    int version, binary, swapped;
    int dim, times;
} encoding;

/** Put the nodes of an element, numbered from first on. Returns their number. */
static int put_nodes(file_builder *file, const encoding *e, const unit_element *element,
                     int first) {
    double x[UNIT_NODES][3];
    const int n = unit_places(element->type, element->nodes, x);
    for (int i = 0; i < n && e->version == MSH41; i++) {
        builder_integer(file, first + i, 8);
        builder_line(file);
    }
    for (int i = 0; i < n; i++) {
        if (e->version != MSH41)
            builder_integer(file, first + i, 4);
        for (int d = 0; d < 3; d++)
            builder_real(file, x[i][d], 8);
        builder_line(file);
    }
    return n;
}

static int put_element(file_builder *file, const encoding *e, const unit_element *element,
                       int number, int first) {
    double x[UNIT_NODES][3];
    const int n = unit_places(element->type, element->nodes, x);
    const int old[] = {number, element->code, 1, 1, n};
    const int text[] = {number, element->code, 2, 1, 1};
    const int binary[] = {element->code, 1, 2, number, 1, 1};
    const int bytes = e->version == MSH41 ? 8 : 4;
    if (e->version >= MSH40)
        builder_integer(file, number, bytes);
    for (int i = 0; i < (e->version >= MSH40 ? 0 : e->binary ? 6 : 5); i++)
        builder_integer(file, e->version == MSH1 ? old[i] : e->binary ? binary[i] : text[i], 4);
    for (int i = 0; i < n; i++)
        builder_integer(file, first + i, bytes);
    builder_line(file);
    return n;
}

/** Write the section of nodes, or that of elements, which are numbered from 100 on. */
static void put_section(file_builder *file, const encoding *e, int of_elements) {
    const struct variant variant = {.is_40 = e->version == MSH40};
    const char *const names[2][2] = {{"Nodes", "Elements"}, {"NOD", "ELM"}};
    const char *name = names[e->version == MSH1][of_elements];
    int total = 0, blocks = 0, at = 1, number = 100;
    for (int i = 0; i < N_ELEMENTS; i++) {
        double x[UNIT_NODES][3];
        if (unit_dim(elements[i].type) != e->dim)
            continue;
        total +=
            of_elements ? e->times : e->times * unit_places(elements[i].type, elements[i].nodes, x);
        blocks += e->times;
    }
    builder_text(file, "\n$%s\n", name);
    if (e->version >= MSH40)
        gmsh_put_section(file, &variant, blocks, total);
    else
        builder_text(file, "%d\n", total);
    for (int time = 0; time < e->times; time++) {
        for (int i = 0; i < N_ELEMENTS; i++) {
            const unit_element *element = &elements[i];
            double x[UNIT_NODES][3];
            const int n = unit_places(element->type, element->nodes, x);
            if (unit_dim(element->type) != e->dim)
                continue;
            if (e->version >= MSH40)
                gmsh_put_head(file, &variant, e->dim, 1, of_elements ? element->code : 0,
                              of_elements ? 1 : n);
            at += of_elements ? put_element(file, e, element, number++, at)
                              : put_nodes(file, e, element, at);
        }
    }
    builder_text(file, "\n$%s%s\n", e->version == MSH1 ? "END" : "End", name);
}

static file_builder make_file(const encoding *e) {
    file_builder file = {.binary = e->binary, .swapped = e->swapped};
    if (e->version != MSH1)
        builder_text(&file, "$MeshFormat\n%d.%d %d 8\n", e->version / 10, e->version % 10,
                     e->binary);
    if (e->binary) {
        builder_integer(&file, 1, 4);
        builder_text(&file, "\n");
    }
    if (e->version != MSH1)
        builder_text(&file, "$EndMeshFormat\n");
    put_section(&file, e, 0);
    put_section(&file, e, 1);
    return file;
}

/** Check what was read: triangles or tetrahedra of order 1 and 2 first, then the others, both in the
 *  file's order, each with its number. */
static void expect_elements(planish_file *file, const encoding *e) {
    int64_t cell = 0, n_held = 0;
    for (int pass = 0; pass < 2; pass++) {
        int number = 100;
        for (int i = 0; i < e->times * N_ELEMENTS; i++) {
            const int type = elements[i % N_ELEMENTS].type;
            if (unit_dim(type) != e->dim)
                continue;
            n_held += pass == 0 && !unit_is_smoothed(type);
            if (unit_is_simplex(type) == (pass == 0)) {
                unit_expect(file, cell, type);
                assert_int_equal(planish_file_element_number(file, cell++), number);
            }
            number++;
        }
    }
    unit_expect_valid(file, cell);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(info.n_other_elements, n_held);
    const planish_mesh mesh = planish_file_mesh(file);
    assert_int_equal(mesh.n_elements, cell);
    assert_null(mesh.elements);
    assert_int_equal(mesh.cells->n, mesh.n_elements);
}

static const encoding encodings[] = {
    {.version = MSH1},
    {.version = MSH2},
    {.version = MSH2, .binary = 1},
    {.version = MSH2, .binary = 1, .swapped = 1},
    {.version = MSH40},
    {.version = MSH40, .binary = 1},
    {.version = MSH40, .binary = 1, .swapped = 1},
    {.version = MSH41},
    {.version = MSH41, .binary = 1},
    {.version = MSH41, .binary = 1, .swapped = 1},
};
enum { N_ENCODINGS = sizeof encodings / sizeof *encodings };

static void every_type_has_its_nodes_in_order(void **state) {
    (void)state;
    for (int i = 0; i < 2 * N_ENCODINGS; i++) {
        encoding e = encodings[i / 2];
        e.dim = 2 + i % 2;
        e.times = 2;
        planish_file *file;
        planish_error error = {0};
        file_builder builder = make_file(&e);
        if (builder_read(&builder, &io_format_gmsh, 1, &file, &error) != 0)
            fail_msg("MSH %d, binary %d: %s", e.version, e.binary, error.text);
        expect_elements(file, &e);
        planish_file_close(file);
        builder_let_allocations_fail(&builder, &io_format_gmsh);
        builder_release(&builder);
    }
}

/** So many lines that threads read them. */
static void threads_read_the_same(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        encoding e = encodings[i];
        e.dim = 3;
        e.times = 1500;
        file_builder builder = make_file(&e);
        builder_expect_same_on_threads(&builder, &io_format_gmsh);
        builder_release(&builder);
    }
}

/** A block of MSH 4 that is long enough for several threads. */
static void threads_read_a_block(void **state) {
    (void)state;
    enum { N = 40000 };
    const struct variant variants[] = {{.is_40 = 0}, {.binary = 1}};
    for (int k = 0; k < 2; k++) {
        file_builder file = {.binary = variants[k].binary};
        builder_text(&file, "$MeshFormat\n4.1 %d 8\n", variants[k].binary);
        if (file.binary) {
            builder_integer(&file, 1, 4);
            builder_text(&file, "\n");
        }
        builder_text(&file, "$EndMeshFormat\n$Nodes\n");
        gmsh_put_section(&file, &variants[k], 1, N + 10);
        gmsh_put_head(&file, &variants[k], 3, 1, 0, N + 10);
        for (int i = 0; i < N + 10; i++) {
            builder_integer(&file, i + 1, 8);
            builder_line(&file);
        }
        for (int i = 0; i < 3 * (N + 10); i++) {
            builder_real(&file, i % 71 + i / 3, 8);
            builder_line(&file);
        }
        builder_text(&file, "\n$EndNodes\n$Elements\n");
        gmsh_put_section(&file, &variants[k], 1, N);
        gmsh_put_head(&file, &variants[k], 3, 1, 11, N);
        for (int i = 0; i < N; i++) {
            builder_integer(&file, 3 * i + 1, 8);
            for (int j = 0; j < 10; j++)
                builder_integer(&file, i + j + 1, 8);
            builder_line(&file);
        }
        builder_text(&file, "\n$EndElements\n");
        builder_expect_same_on_threads(&file, &io_format_gmsh);
        planish_file *read;
        planish_error error;
        assert_int_equal(builder_read(&file, &io_format_gmsh, 3, &read, &error), 0);
        assert_int_equal(read->model.tetrahedron.n, N);
        assert_int_equal(read->model.tetrahedron.nodes[4 * (N - 1) + 3], N + 2);
        assert_int_equal(read->model.tetrahedron.mid[6 * (N - 1) + 5],
                         N + 7); /* the last two swap */
        planish_file_close(read);
        builder_release(&file);
    }
}

/* ---- points in groups --------------------------------------------------------------------- */

/** Points of a tetrahedron: node, number of the group or 0, and entity. The second entity is in groups 5
 *  and 6, the first in 5, the third in none, the fourth in 6. */
static const int points[][3] = {{1, 5, 1}, {4, 5, 1}, {2, 5, 2}, {2, 6, 2}, {3, 0, 3}, {4, 6, 4}};
enum { N_POINTS = sizeof points / sizeof *points };

static void put_entities(file_builder *file, const encoding *e) {
    static const int groups[4][3] = {{1, 5}, {2, 5, 6}, {0}, {1, 6}};
    const int counts[] = {4, 0, 0, 1};
    builder_text(file, "$Entities\n");
    for (int i = 0; i < 4; i++)
        builder_integer(file, counts[i], 8);
    builder_line(file);
    for (int i = 0; i < 5; i++) {
        builder_integer(file, i < 4 ? i + 1 : 1, 4);
        for (int k = 0; k < (i < 4 && e->version == MSH41 ? 3 : 6); k++)
            builder_real(file, 0, 8);
        builder_integer(file, i < 4 ? groups[i][0] : 0, 8);
        for (int k = 0; i < 4 && k < groups[i][0]; k++)
            builder_integer(file, groups[i][1 + k], 4);
        if (i == 4)
            builder_integer(file, 0, 8);
        builder_line(file);
    }
    builder_text(file, "\n$EndEntities\n");
}

/** Put the points and the tetrahedron of MSH 4: a block for each point, once for its groups. */
static void put_blocks(file_builder *file, const encoding *e) {
    const struct variant variant = {.is_40 = e->version == MSH40};
    const int bytes = e->version == MSH41 ? 8 : 4;
    gmsh_put_section(file, &variant, N_POINTS, N_POINTS); /* five points and a tetrahedron */
    for (int i = 0; i < N_POINTS; i++) {
        if (i == 3) /* the second entity has both groups */
            continue;
        gmsh_put_head(file, &variant, 0, points[i][2], 15, 1);
        builder_integer(file, i + 1, bytes);
        builder_integer(file, points[i][0], bytes);
        builder_line(file);
    }
    gmsh_put_head(file, &variant, 3, 1, 4, 1);
    for (int i = 0; i < 5; i++)
        builder_integer(file, i == 0 ? N_POINTS + 1 : i, bytes);
    builder_line(file);
}

/** Put those of MSH 2: all points are one block of a binary file. */
static void put_lines(file_builder *file, const encoding *e) {
    const int heads[2][3] = {{15, N_POINTS, 2}, {4, 1, 2}};
    builder_text(file, "%d\n", N_POINTS + 1);
    for (int i = 0; i <= N_POINTS; i++) {
        const int is_point = i < N_POINTS;
        for (int k = 0; k < 3 && e->binary && (i == 0 || !is_point); k++)
            builder_integer(file, heads[!is_point][k], 4);
        builder_integer(file, i + 1, 4);
        for (int k = e->binary ? 2 : 0; k < 2; k++)
            builder_integer(file, heads[!is_point][2 * k], 4);
        builder_integer(file, is_point ? points[i][1] : 0, 4);
        builder_integer(file, is_point ? points[i][2] : 1, 4);
        for (int k = 1; k <= (is_point ? 1 : 4); k++)
            builder_integer(file, is_point ? points[i][0] : k, 4);
        builder_line(file);
    }
}

static file_builder make_points(const encoding *e) {
    static const unit_element tetrahedron = {PLANISH_CELL_TETRAHEDRON, 4, "0 1 2 3"};
    const struct variant variant = {.is_40 = e->version == MSH40};
    file_builder file = {.binary = e->binary, .swapped = e->swapped};
    builder_text(&file, "$MeshFormat\n%d.%d %d 8\n", e->version / 10, e->version % 10, e->binary);
    if (e->binary) {
        builder_integer(&file, 1, 4);
        builder_text(&file, "\n");
    }
    builder_text(&file, "$EndMeshFormat\n");
    if (e->version >= MSH40)
        put_entities(&file, e);
    builder_text(&file, "$Nodes\n");
    if (e->version >= MSH40) {
        gmsh_put_section(&file, &variant, 1, 4);
        gmsh_put_head(&file, &variant, 3, 1, 0, 4);
    } else {
        builder_text(&file, "4\n");
    }
    put_nodes(&file, e, &tetrahedron, 1);
    builder_text(&file, "\n$EndNodes\n$Elements\n");
    (e->version >= MSH40 ? put_blocks : put_lines)(&file, e);
    builder_text(&file, "\n$EndElements\n");
    return file;
}

static void expect_point_groups(planish_file *file) {
    const planish_group *group;
    planish_error error;
    int64_t n;
    assert_int_equal(planish_file_groups(file, &group, &n, &error), 0);
    assert_int_equal(n, 3);
    assert_string_equal(group[0].tag, "0:5");
    assert_int_equal(group[0].n, 3);
    assert_string_equal(group[1].tag, "0:6");
    assert_int_equal(group[1].n, 2);
    assert_string_equal(group[2].tag, "3:1");
    reading_holds(file, NULL, 0, "0000"); /* points name every node */
    reading_holds(file, "0:5", 0, "1101");
    reading_holds(file, "0:6", 0, "0101");
    assert_int_equal(file->model.node_entity[2], -1);
}

/** A node is in the groups of all its points, in every encoding. */
static void points_put_nodes_into_groups(void **state) {
    (void)state;
    for (int i = 1; i < N_ENCODINGS; i++) {
        const encoding *e = &encodings[i];
        planish_file *file;
        planish_error error = {0};
        file_builder builder = make_points(e);
        if (builder_read(&builder, &io_format_gmsh, 1, &file, &error) != 0)
            fail_msg("MSH %d, binary %d: %s", e->version, e->binary, error.text);
        expect_point_groups(file);
        planish_file_close(file);
        builder_let_allocations_fail(&builder, &io_format_gmsh);
        builder_release(&builder);
    }
}

/** So many points that threads read them. */
static void threads_read_the_same_points(void **state) {
    (void)state;
    enum { N = 70000 };
    planish_file *file[2];
    planish_error error;
    file_builder builder = {.binary = 0};
    builder_text(&builder, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d\n", N);
    for (int i = 1; i <= N; i++)
        builder_text(&builder, "%d %d %d %d\n", i, i, i % 7, i * 3 % 11);
    builder_text(&builder, "$EndNodes\n$Elements\n%d\n", N + 1);
    for (int i = 1; i <= N; i++)
        builder_text(&builder, "%d 15 2 %d %d %d\n", i, i % 3, i, i * 9 % N + 1);
    builder_text(&builder, "%d 4 2 1 1 1 2 3 6\n$EndElements\n", N + 1);
    for (int k = 0; k < 2; k++)
        assert_int_equal(builder_read(&builder, &io_format_gmsh, 1 + 2 * k, &file[k], &error), 0);
    for (int i = 1; i <= N; i++) {
        const io_model *model = &file[1]->model;
        const int32_t entity = model->node_entity[i * 9 % N];
        assert_int_equal(entity, file[0]->model.node_entity[i * 9 % N]);
        assert_int_equal(entity < 0 ? 0 : model->entity[entity].physical[0], i % 3);
    }
    planish_file_close(file[0]);
    planish_file_close(file[1]);
    builder_release(&builder);
}

/** Corners of the geometry that are in no group are nothing but held. */
static void points_without_groups_are_none(void **state) {
    (void)state;
    planish_file *file = reading_text(
        &io_format_gmsh,
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
        "$EndNodes\n$Elements\n2\n1 15 2 0 1 1\n2 4 2 0 1 1 2 3 4\n$EndElements\n");
    assert_null(file->model.node_entity);
    reading_holds(file, NULL, 0, "1000");
    planish_file_close(file);
}

/** Gmsh writes an element of several groups once for each of them: it is one element. */
static void copies_are_one_element(void **state) {
    (void)state;
    planish_file *file = reading_text(
        &io_format_gmsh,
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n9\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n"
        "5 0 0 1\n6 1 0 1\n7 1 1 1\n8 0 1 1\n9 2 2 2\n$EndNodes\n$Elements\n5\n"
        "1 5 2 7 1 1 2 3 4 5 6 7 8\n2 7 2 7 1 5 6 7 8 9\n3 5 2 8 1 1 2 3 4 5 6 7 8\n"
        "4 7 2 8 1 5 6 7 8 9\n5 7 2 8 2 5 6 7 8 1\n$EndElements\n");
    assert_int_equal(file->model.solid.n, 3);
    assert_int_equal(file->model.n_other, 0);
    static const int numbers[] = {1, 2, 5};
    for (int i = 0; i < 3; i++)
        assert_int_equal(planish_file_element_number(file, i), numbers[i]);
    assert_int_equal(file->model.solid.offset[3], 18);
    assert_int_equal(file->model.solid.node[17], 0);
    const io_entity *entity = &file->model.entity[file->model.solid.entity[0]];
    assert_int_equal(entity->n_physical, 2);
    assert_int_equal(entity->physical[0] + entity->physical[1], 7 + 8);
    planish_file_close(file);
}

/* Two tetrahedra of second order in regions 1 and 2, a triangle in group 5, and a line in group 6.
 */
#define HEAD                                                                                       \
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n14\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"       \
    "5 1.5 1.5 1.5\n6 .5 0 0\n7 .5 .5 0\n8 0 .5 0\n9 0 0 .5\n10 .5 0 .5\n11 0 .5 .5\n"             \
    "12 1.25 .75 .75\n13 .75 1.25 .75\n14 .75 .75 1.25\n$EndNodes\n$Elements\n"
#define TWO                                                                                        \
    HEAD "4\n1 8 2 6 6 4 5 14\n2 9 2 5 5 1 2 3 6 7 8\n3 11 2 1 1 1 2 3 4 6 7 8 9 11 10\n"          \
         "4 11 2 2 2 2 3 4 5 7 11 10 12 14 13\n$EndElements\n"

/** Check that constraint is 1 of the nodes that text names, "1 2 14", and 0 of all others. */
static void expect_fixed(const uint8_t *constraint, int n, const char *text) {
    char named[64], number[16];
    snprintf(named, sizeof named, " %s ", text);
    for (int i = 0; i < n; i++) {
        snprintf(number, sizeof number, " %d ", i + 1);
        if (constraint[i] != (strstr(named, number) ? PLANISH_CONSTRAINT_FIXED : 0))
            fail_msg("node %d with '%s' fixed: %d", i + 1, text, constraint[i]);
    }
}

/** Lines and triangles hold their mids, and so do groups and regions: mids may move on their own elsewhere. Facets
 *  are given by their corners. */
static void mids_are_held_with_their_ends(void **state) {
    (void)state;
    static const char *const six[] = {"6"}, *const five[] = {"2:5"}, *const two[] = {"3:2"};
    static const struct {
        planish_hold hold;
        const char *fixed;
    } cases[] = {
        {{.tags = NULL}, "1 2 3 4 5 6 7 8 10 11 14"},
        {{.ignore_regions = 1}, "1 2 3 4 5 6 7 8 14"},
        {{.slide = 1}, ""},
        {{.slide = 1, .tags = six, .n_tags = 1}, "4 5 14"},
        {{.slide = 1, .tags = five, .n_tags = 1}, "1 2 3 6 7 8"},
        {{.slide = 1, .tags = two, .n_tags = 1}, "2 3 4 5 7 11 10 12 13 14"},
        {{.slide = 1, .slide_tags = five, .n_slide_tags = 1}, ""},
    };
    planish_file *file = reading_text(&io_format_gmsh, TWO);
    uint8_t constraint[14];
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_int_equal(planish_file_constraints(file, &cases[i].hold, constraint, NULL), 0);
        expect_fixed(constraint, 14, cases[i].fixed);
    }
    static const int32_t facet[] = {0, 1, 2}, edge[] = {3, 4};
    const planish_surface surface = planish_file_surface(file, NULL);
    assert_int_equal(surface.n_facets, 1);
    assert_memory_equal(surface.facets, facet, sizeof facet);
    assert_null(surface.facet_offset);
    assert_int_equal(surface.n_edges, 1);
    assert_memory_equal(surface.edges, edge, sizeof edge);
    assert_true(surface.region[0] != surface.region[1]);
    planish_file_close(file);
    /* Where the line is missing, region 2 has no node that is held but those of the interface. */
    file =
        reading_text(&io_format_gmsh, HEAD "2\n3 11 2 1 1 1 2 3 4 6 7 8 9 11 10\n"
                                           "4 11 2 2 2 2 3 4 5 7 11 10 12 14 13\n$EndElements\n");
    assert_int_equal(planish_file_constraints(file, NULL, constraint, NULL), 0);
    expect_fixed(constraint, 14, "2 3 4 7 10 11");
    planish_file_close(file);
}

/** Straight and quadratic elements are in one mesh, in the file's order; mids that no element has
 *  are missing. */
static void orders_are_mixed(void **state) {
    (void)state;
    static const int32_t first[] = {0, 1, 2, 3}, second[] = {1, 2, 3, 4, 6, 10, 9, 11, 12, 13};
    planish_file *file =
        reading_text(&io_format_gmsh, HEAD "2\n3 4 2 1 1 1 2 3 4\n"
                                           "4 11 2 1 1 2 3 4 5 7 11 10 12 14 13\n$EndElements\n");
    const planish_mesh mesh = planish_file_mesh(file);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(info.n_other_elements, 0);
    assert_int_equal(mesh.n_elements, 2);
    assert_null(mesh.elements);
    assert_int_equal(mesh.cells->n, 2);
    assert_int_equal(mesh.cells->type[0], PLANISH_CELL_TETRAHEDRON);
    assert_int_equal(mesh.cells->type[1], PLANISH_CELL_TETRAHEDRON10);
    assert_memory_equal(mesh.cells->node, first, sizeof first);
    assert_memory_equal(mesh.cells->node + mesh.cells->offset[1], second, sizeof second);
    assert_int_equal(mesh.cells->offset[2], 14);
    assert_int_equal(planish_file_element_number(file, 1), 4);
    planish_file_close(file);
    file = reading_text(&io_format_gmsh, HEAD "1\n3 4 2 1 1 1 2 3 4\n$EndElements\n");
    assert_null(planish_file_mesh(file).cells);
    assert_null(file->cells.offset);
    planish_file_close(file);
}

/** An element that is there in two groups keeps its mids, and so does the one behind it. */
static void copies_keep_their_mids(void **state) {
    (void)state;
    static const int32_t mids[] = {5, 6, 7, 8, 9, 10, 6, 10, 9, 11, 12, 13};
    planish_file *file =
        reading_text(&io_format_gmsh, HEAD "3\n3 11 2 1 1 1 2 3 4 6 7 8 9 11 10\n"
                                           "4 11 2 2 1 1 2 3 4 6 7 8 9 11 10\n"
                                           "5 11 2 1 1 2 3 4 5 7 11 10 12 14 13\n$EndElements\n");
    assert_int_equal(planish_file_mesh(file).n_elements, 2);
    assert_memory_equal(file->model.tetrahedron.mid, mids, sizeof mids);
    planish_file_close(file);
}

/** Where all facets are listed, the one inside holds nothing; it goes behind the others with its
 *  mids. */
static void listed_facets_keep_their_mids(void **state) {
    (void)state;
    static const int32_t mids[] = {5,  6,  7,  5,  9, 8,  7,  10, 8,  6, 12,
                                   11, 10, 13, 12, 9, 13, 11, 6,  10, 9};
    planish_file *file =
        reading_text(&io_format_gmsh, HEAD
                     "9\n1 9 2 5 5 1 2 3 6 7 8\n2 9 2 5 5 1 2 4 6 10 9\n3 9 2 5 5 2 3 4 7 11 10\n"
                     "4 9 2 5 5 1 3 4 8 11 9\n5 9 2 5 5 2 3 5 7 13 12\n6 9 2 5 5 3 4 5 11 14 13\n"
                     "7 9 2 5 5 2 4 5 10 14 12\n8 11 2 1 1 1 2 3 4 6 7 8 9 11 10\n"
                     "9 11 2 2 2 2 3 4 5 7 11 10 12 14 13\n$EndElements\n");
    const io_cells *triangles = &file->model.triangle;
    assert_int_equal(triangles->n, 7);
    assert_int_equal(triangles->n_plain, 1);
    assert_int_equal(triangles->number[6], 3);
    assert_memory_equal(triangles->mid, mids, sizeof mids);
    planish_file_close(file);
}

static void mids_are_written_as_other_nodes(void **state) {
    rewriting_keeps_the_rest(&io_format_gmsh, TWO, (int64_t)sizeof TWO - 1, *state);
    for (int i = 0; i < N_ENCODINGS; i++) {
        encoding e = encodings[i];
        e.dim = 3;
        e.times = 1;
        file_builder builder = make_file(&e);
        rewriting_keeps_the_rest(&io_format_gmsh, builder.data, builder.size, *state);
        builder_release(&builder);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_has_its_nodes_in_order),
        cmocka_unit_test(threads_read_the_same),
        cmocka_unit_test(threads_read_a_block),
        cmocka_unit_test(points_put_nodes_into_groups),
        cmocka_unit_test(threads_read_the_same_points),
        cmocka_unit_test(points_without_groups_are_none),
        cmocka_unit_test(copies_are_one_element),
        cmocka_unit_test(mids_are_held_with_their_ends),
        cmocka_unit_test(orders_are_mixed),
        cmocka_unit_test(copies_keep_their_mids),
        cmocka_unit_test(listed_facets_keep_their_mids),
        cmocka_unit_test(mids_are_written_as_other_nodes),
    };
    return cmocka_run_group_tests(tests, test_folder_create, test_folder_remove);
}
