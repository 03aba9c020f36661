/* Tests of the reader of MSH files: the same small mesh in every encoding, and files that lie. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/file_builder.h"
#include "support/gmsh_builder.h"
#include "support/reading.h"

/* ---- what must have been read ------------------------------------------------------------- */

static void expect_places(const io_model *model, const struct variant *variant,
                          const int64_t *place) {
    for (int i = 0; i < N_NODES; i++) {
        if (!variant->binary) {
            assert_int_equal(model->text_offset[i], place[i]);
            continue;
        }
        const io_span *span = model->span;
        while (i >= span->first_node + span->n_nodes)
            span++;
        assert_int_equal(span->encoding, IO_FLOAT64);
        assert_int_equal(span->swapped, variant->swapped);
        assert_int_equal(span->offset + (i - span->first_node) * span->stride, place[i]);
    }
    assert_int_equal(model->text_offset == NULL, variant->binary);
}

static void expect_mesh(const planish_file *file, const struct variant *variant) {
    const io_model *model = &file->model;
    const io_cells *cells = &model->tetrahedron;
    assert_int_equal(model->dim, 3);
    assert_int_equal(model->columns, 3);
    assert_int_equal(model->n_nodes, N_NODES);
    assert_memory_equal(model->coordinates, gmsh_points, sizeof gmsh_points);
    assert_int_equal(cells->n, 4);
    assert_memory_equal(cells->nodes, gmsh_tets, sizeof gmsh_tets);
    assert_int_equal(model->triangle.n, 1);
    assert_int_equal(model->n_lower, 3);
    assert_int_equal(model->n_other, 0);
    for (int i = 0; i < 4; i++)
        assert_int_equal(planish_file_element_number(file, i), 10 + i * i);
    assert_null(model->triangle.number);
    assert_int_equal(model->triangle.first_number, 3);
    assert_int_equal(model->node_number == NULL, !variant->sparse);
    for (int i = 0; i < N_NODES; i++)
        assert_int_equal(planish_file_node_number(file, i), gmsh_node_tag(variant, i));
    static const uint8_t held[] = {IO_HELD_BY_FACE | IO_HELD_BY_LINE | IO_HELD_BY_POINT,
                                   IO_HELD_BY_FACE | IO_HELD_BY_LINE, IO_HELD_BY_FACE};
    const int with = variant->parametric ? IO_HAS_PARAMETERS : 0;
    for (int i = 0; i < N_NODES; i++)
        assert_int_equal(model->hold[i], with | (i < 3         ? held[i]
                                                 : i == INSIDE ? 0
                                                               : IO_HELD_PERIODIC));
    const planish_hold whole = {.ignore_regions = 1};
    uint8_t constraint[N_NODES];
    assert_int_equal(planish_file_constraints(file, &whole, constraint, NULL), PLANISH_OK);
    assert_int_equal(constraint[INSIDE], PLANISH_CONSTRAINT_FREE);
    assert_int_equal(planish_file_get_parametric(file, NULL), with ? N_NODES : 0);
}

static void expect_entities(const io_model *model) {
    const io_cells *cells = &model->tetrahedron;
    assert_int_equal(model->n_groups, 2);
    assert_string_equal(model->group[0].name, "the part");
    assert_int_equal(model->group[0].dim, 3);
    assert_int_equal(model->group[0].tag, 7);
    for (int i = 0; i < 4; i++) {
        const io_entity *entity = &model->entity[cells->entity[i]];
        assert_int_equal(entity->dim, 3);
        assert_int_equal(entity->tag, i < 3 ? 4 : 5);
        assert_int_equal(entity->n_physical, 1);
        assert_int_equal(entity->physical[0], 7);
    }
    const io_entity *skin = &model->entity[model->triangle.entity[0]];
    assert_int_equal(skin->dim, 2);
    assert_int_equal(skin->tag, 3);
    assert_int_equal(skin->physical[0], 8);
}

typedef file_builder make_fn(const struct variant *variant, int64_t *place);

static void check_variants(make_fn *make, int n, const struct variant *variants) {
    for (int i = 0; i < n; i++) {
        int64_t place[N_NODES];
        planish_file *file;
        planish_error error = {0};
        file_builder builder = make(&variants[i], place);
        if (builder_read(&builder, &io_format_gmsh, 1, &file, &error) != 0)
            fail_msg("variant %d: %s", i, error.text);
        assert_true(io_format_gmsh.recognise(builder.data, builder.size));
        expect_mesh(file, &variants[i]);
        expect_entities(&file->model);
        expect_places(&file->model, &variants[i], place);
        planish_file_close(file);
        builder_try_to_break(&builder, &io_format_gmsh);
        builder_release(&builder);
    }
}

static void test_msh2(void **state) {
    (void)state;
    const struct variant variants[] = {{.binary = 0},
                                       {.sparse = 1},
                                       {.binary = 1},
                                       {.binary = 1, .swapped = 1, .sparse = 1},
                                       {.sparse = 1, .wrap = 5}};
    check_variants(gmsh_make_msh2, 5, variants);
}

static void test_msh1(void **state) {
    (void)state;
    const struct variant variants[] = {{.sparse = 0}, {.sparse = 1}, {.sparse = 1, .wrap = 5}};
    check_variants(gmsh_make_msh1, 3, variants);
}

static void test_msh40(void **state) {
    (void)state;
    const struct variant variants[] = {{.is_40 = 1},
                                       {.is_40 = 1, .sparse = 1, .wrap = 7},
                                       {.is_40 = 1, .binary = 1},
                                       {.is_40 = 1, .binary = 1, .swapped = 1, .sparse = 1},
                                       {.is_40 = 1, .parametric = 1},
                                       {.is_40 = 1, .parametric = 1, .binary = 1}};
    check_variants(gmsh_make_msh4, 6, variants);
}

static void test_msh4(void **state) {
    (void)state;
    const struct variant variants[] = {{.binary = 0},
                                       {.sparse = 1},
                                       {.binary = 1},
                                       {.binary = 1, .swapped = 1, .sparse = 1},
                                       {.parametric = 1},
                                       {.binary = 1, .sparse = 1, .parametric = 1},
                                       {.sparse = 1, .parametric = 1, .wrap = 7}};
    check_variants(gmsh_make_msh4, 7, variants);
}

/* ---- other kinds of mesh ------------------------------------------------------------------ */

static void read_text(const char *text, planish_file **file) {
    planish_error error = {0};
    file_builder builder = builder_of(text);
    if (builder_read(&builder, &io_format_gmsh, 1, file, &error) != 0)
        fail_msg("%s", error.text);
}

static void test_plane_mesh(void **state) {
    (void)state;
    planish_file *file;
    read_text("$MeshFormat\r\n2.2 0 8\r\n$EndMeshFormat\r\n$Nodes\r\n4\r\n1 0 0 2\r\n2 1 0 2\r\n"
              "3 1 1 2\r\n4 0 1 2\r\n$EndNodes\r\n$Elements\r\n3\r\n1 1 2 0 1 1 2\r\n"
              "2 2 0 1 2 3\r\n3 2 3 0 1 9 1 3 4\r\n$EndElements\r\n",
              &file);
    assert_int_equal(file->model.dim, 2);
    assert_int_equal(file->model.triangle.n, 2);
    assert_int_equal(file->model.columns, 3);
    assert_true(file->model.coordinates[2 * 2 + 1] == 1);
    assert_int_equal(file->model.hold[0], IO_HELD_BY_LINE);
    assert_int_equal(file->model.hold[2], 0);
    planish_file_close(file);
}

/** What geometry kernels leave of roundings in z is no surface. */
static void test_noise_of_a_plane(void **state) {
    (void)state;
    static const char head[] = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n",
                      tail[] = "4 0 1 2\n$EndNodes\n$Elements\n2\n1 2 0 1 2 3\n2 2 0 1 3 4\n"
                               "$EndElements\n";
    char huge[512];
    snprintf(huge, sizeof huge, "%s1 -1e308 0 -1e308\n2 1e308 0 1e308\n3 0 1e308 0\n%s", head,
             tail);
    reading_gives_surface(&io_format_gmsh, huge);
    static const struct {
        const char *z;
        int is_plane;
    } cases[] = {{"2", 1}, {"2.00000001e0", 1}, {"1.99999999", 1}, {"2.01", 0}, {"1.9", 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[512];
        snprintf(text, sizeof text, "%s1 0 0 2\n2 3 0 2\n3 3 1 %s\n%s", head, cases[i].z, tail);
        if (cases[i].is_plane) {
            planish_file *file;
            read_text(text, &file);
            assert_int_equal(file->model.dim, 2);
            planish_file_close(file);
        } else {
            reading_gives_surface(&io_format_gmsh, text);
        }
    }
}

static void test_other_elements_are_read(void **state) {
    (void)state;
    planish_file *file;
    read_text("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n6\n1 0 0 0\n2 1 0 0\n3 0 1 0\n"
              "4 0 0 1\n5 1 1 1\n6 2 2 2\n$EndNodes\n$Elements\n2\n1 4 2 0 1 1 2 3 4\n"
              "2 7 2 0 1 1 2 3 5 6\n$EndElements\n",
              &file);
    static const int32_t nodes[] = {0, 1, 2, 3, 0, 1, 2, 4, 5};
    const planish_mesh mesh = planish_file_mesh(file);
    const uint8_t expected[6] = {0};
    assert_int_equal(file->model.n_other, 0);
    assert_int_equal(mesh.n_elements, 2);
    assert_int_equal(mesh.cells->type[1], PLANISH_CELL_PYRAMID);
    assert_memory_equal(mesh.cells->node, nodes, sizeof nodes);
    assert_memory_equal(file->model.hold, expected, 6);
    planish_file_close(file);
}

/* A square cut in two parts: the line between them is of the partition and holds nothing, the
 * parts are one region. */
static void test_partition(void **state) {
    (void)state;
    planish_file *file;
    read_text("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 1 0\n"
              "1 0 0 0 1 1 0 1 5 0\n$EndEntities\n$PartitionedEntities\n2\n0\n0 1 2 0\n"
              "9 2 1 2 1 2 0 0 0 1 1 0 1 5 0\n2 2 1 1 1 0 0 0 1 1 0 1 5 0\n"
              "3 2 1 1 2 0 0 0 1 1 0 1 5 0\n$EndPartitionedEntities\n$Nodes\n1 4 1 4\n2 2 0 4\n"
              "1\n2\n3\n4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n$EndNodes\n$Elements\n3 3 1 3\n1 9 1 1\n"
              "1 1 3\n2 2 2 1\n2 1 2 3\n2 3 2 1\n3 1 3 4\n$EndElements\n",
              &file);
    const io_model *model = &file->model;
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(info.n_regions, 1);
    assert_int_equal(model->entity[model->triangle.entity[1]].tag, 1);
    assert_int_equal(model->entity[model->triangle.entity[1]].physical[0], 5);
    assert_int_equal(model->hold[0], 0);
    assert_int_equal(model->n_lower, 1);
    planish_file_close(file);
}

/* Gmsh writes an element once for each of its groups: it is one element, in both of them. An
 * element that is there twice in one group stays. */
static void test_copies(void **state) {
    (void)state;
    planish_file *file;
    planish_file_info info;
    read_text("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n"
              "4 0 0 1\n5 1 1 1\n$EndNodes\n$Elements\n6\n1 4 2 9 1 1 2 3 4\n"
              "2 4 2 5 1 4 3 2 1\n3 4 2 0 2 2 3 4 5\n4 4 2 9 1 5 1 3 2\n5 4 2 5 1 1 2 3 5\n"
              "6 4 2 0 2 2 3 4 5\n$EndElements\n",
              &file);
    const io_cells *cells = &file->model.tetrahedron;
    planish_file_get_info(file, &info);
    assert_int_equal(info.n_regions, 2);
    assert_int_equal(cells->n, 4);
    const int64_t numbers[4] = {1, 3, 4, 6};
    assert_memory_equal(cells->number, numbers, sizeof numbers);
    assert_int_equal(cells->entity[0], cells->entity[2]);
    assert_int_equal(cells->entity[1], cells->entity[3]);
    const io_entity *entity = &file->model.entity[cells->entity[0]];
    const int32_t groups[2] = {5, 9};
    assert_int_equal(entity->tag, 1);
    assert_int_equal(entity->n_physical, 2);
    assert_memory_equal(entity->physical, groups, sizeof groups);
    const int32_t nodes[4] = {4, 0, 2, 1};
    assert_memory_equal(&cells->nodes[8], nodes, sizeof nodes);
    planish_file_close(file);
}

/* ---- large files on several threads ------------------------------------------------------- */

enum { SIDE = 180 }; /* nodes along the side of a plane grid: files of over 2 MB */

static void put_grid_point(file_builder *file, int i) {
    builder_real(file, i % SIDE + 1.0 / (3 + i), 8);
    builder_real(file, i / SIDE + 1.0 / (5 + i), 8);
    builder_real(file, 0, 8);
    builder_line(file);
}

/* Triangle t of the grid; numbers that make tags sparse. */
static void put_grid_triangle(file_builder *file, int t) {
    int cell = t / 2, corner = cell / (SIDE - 1) * SIDE + cell % (SIDE - 1) + 1;
    int nodes[2][3] = {{corner, corner + 1, corner + SIDE + 1},
                       {corner, corner + SIDE + 1, corner + SIDE}};
    for (int i = 0; i < 3; i++)
        builder_integer(file, 3 * nodes[t % 2][i], 8);
    builder_line(file);
}

static void test_large_msh2(void **state) {
    (void)state;
    for (int wrap = 0; wrap <= 11; wrap += 11) { /* 11: lines that are no records */
        file_builder file = {.wrap = wrap};
        int n = 2 * (SIDE - 1) * (SIDE - 1);
        builder_text(&file, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d\n", SIDE * SIDE);
        for (int i = 0; i < SIDE * SIDE; i++) {
            builder_integer(&file, 3 * (i + 1), 8);
            put_grid_point(&file, i);
        }
        builder_text(&file, "\n$EndNodes\n$Elements\n%d\n", n);
        for (int i = 0; i < n; i++) {
            builder_integer(&file, 7 * i, 8);
            builder_integer(&file, 2, 8);
            builder_integer(&file, 2, 8);
            builder_integer(&file, i / 1000 % 3, 8);
            builder_integer(&file, i / 1000, 8);
            put_grid_triangle(&file, i);
        }
        builder_text(&file, "\n$EndElements\n");
        builder_expect_same_on_threads(&file, &io_format_gmsh);
        builder_release(&file);
    }
}

static void check_large_msh4(const struct variant *variant) {
    for (int wrap = 0; wrap <= 11; wrap += 11) {
        file_builder file = {.wrap = wrap};
        int n = 2 * (SIDE - 1) * (SIDE - 1);
        builder_text(&file, "$MeshFormat\n4.%d 0 8\n$EndMeshFormat\n$Nodes\n", !variant->is_40);
        gmsh_put_section(&file, variant, 1, SIDE * SIDE);
        gmsh_put_head(&file, variant, 2, 1, 0, SIDE * SIDE);
        for (int i = 0; i < SIDE * SIDE && !variant->is_40; i++) {
            builder_integer(&file, 3 * (i + 1), 8);
            builder_line(&file);
        }
        for (int i = 0; i < SIDE * SIDE; i++) {
            if (variant->is_40)
                builder_integer(&file, 3 * (i + 1), 8);
            put_grid_point(&file, i);
        }
        builder_text(&file, "\n$EndNodes\n$Elements\n");
        gmsh_put_section(&file, variant, 1, n);
        gmsh_put_head(&file, variant, 2, 1, 2, n);
        for (int i = 0; i < n; i++) {
            builder_integer(&file, 7 * i, 8);
            put_grid_triangle(&file, i);
        }
        builder_text(&file, "\n$EndElements\n");
        builder_expect_same_on_threads(&file, &io_format_gmsh);
        /* An error far down is found, and is the same error, on any number of threads. */
        char *last = file.data + file.size - 30;
        *last = 'x';
        planish_error one = {0}, three = {0};
        planish_file *none;
        assert_int_equal(builder_read(&file, &io_format_gmsh, 1, &none, &one),
                         PLANISH_ERROR_FORMAT);
        assert_int_equal(builder_read(&file, &io_format_gmsh, 3, &none, &three),
                         PLANISH_ERROR_FORMAT);
        assert_string_equal(one.text, three.text);
        builder_release(&file);
    }
}

static void test_large_msh4(void **state) {
    (void)state;
    const struct variant variants[] = {{.is_40 = 0}, {.is_40 = 1}};
    for (int i = 0; i < 2; i++)
        check_large_msh4(&variants[i]);
}

/* ---- names and data ----------------------------------------------------------------------- */

#define SQUARE                                                                                     \
    "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n$Elements\n3\n1 1 2 7 1 1 2\n"      \
    "2 2 2 7 1 1 2 3\n3 2 2 8 1 1 3 4\n$EndElements\n"

/* MSH 2.0 names have no dimension: they are of all dimensions that have the number. */
static void test_names_without_dimension(void **state) {
    (void)state;
    static const char *const texts[] = {
        "$MeshFormat\n2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n7 \"a b\"\n 8 \"c\" of 2.0\n"
        "9 \"no such\"\n$EndPhysicalNames\n" SQUARE,
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n-1 7 \"a b\" 5 6\n-1 8\"c\"\r\n"
        "-1 9 \"no such\"\n$EndPhysicalNames\n" SQUARE};
    for (int i = 0; i < 2; i++) {
        planish_file *file;
        read_text(texts[i], &file);
        assert_int_equal(file->model.n_groups, 4);
        reading_group_is(file, 0, "a b", 1, 7);
        reading_group_is(file, 1, "c", 2, 8);
        reading_group_is(file, 2, "no such", 2, 9);
        reading_group_is(file, 3, "a b", 2, 7);
        planish_file_close(file);
        file_builder builder = builder_of(texts[i]);
        builder_try_to_break(&builder, &io_format_gmsh);
    }
}

/* A line without quotes has no name, as for Gmsh. */
static void test_lines_without_names(void **state) {
    (void)state;
    planish_file *file;
    read_text("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n2 7\n\n2 8 word\n"
              "2 9 \"$EndPhysicalNames\" \"more\"\n$EndPhysicalNames\n" SQUARE,
              &file);
    assert_int_equal(file->model.n_groups, 1);
    reading_group_is(file, 0, "$EndPhysicalNames", 2, 9);
    planish_file_close(file);
}

/* Values whose bytes are the mark of the section's end; tail: what stands before the true one. */
static void put_data(file_builder *file, const char *name, int with_nodes, const char *tail) {
    static const char lie[] = "\n$EndElementData\n$Nodes\n\n";
    builder_text(file, "$%s\n1\n\"some values\"\n1\n0.0\n4\n0\n3\n2\n0\n", name);
    for (int i = 0; i < 2; i++) {
        builder_integer(file, i + 1, 4);
        if (with_nodes)
            builder_integer(file, 1, 4);
        builder_text(file, "%.24s", lie);
    }
    builder_text(file, "%s$End%s\n", tail, name);
}

static file_builder make_with_data(const struct variant *variant, const char *tail,
                                   int64_t *place) {
    file_builder file = gmsh_make_msh2(variant, place);
    put_data(&file, "ElementData", 0, tail);
    put_data(&file, "NodeData", 0, tail);
    put_data(&file, "ElementNodeData", 1, tail);
    builder_text(&file, "$Periodic\n0\n$EndPeriodic\n");
    return file;
}

/* Binary data are passed over by their count: others than Gmsh end no line behind them. */
static void test_binary_data(void **state) {
    (void)state;
    for (int swapped = 0; swapped < 2; swapped++)
        for (int i = 0; i < 2; i++) {
            int64_t place[N_NODES];
            const struct variant variant = {.binary = 1, .swapped = swapped};
            file_builder builder = make_with_data(&variant, i == 0 ? "" : "\n", place);
            planish_file *file = builder_file(&builder, &io_format_gmsh);
            expect_mesh(file, &variant);
            expect_places(&file->model, &variant, place);
            planish_file_close(file);
            builder_try_to_break(&builder, &io_format_gmsh);
            builder_release(&builder);
        }
}

/* Counts that lie: the end of the section is looked for instead. */
static void test_binary_data_that_lie(void **state) {
    (void)state;
    static const char *const heads[] = {"1\n\"x\"\n1\n0\n3\n0\n1\n4611686018427387904\n",
                                        "1\n\"x\"\n1\n0\n3\n0\n-1\n1\n",
                                        "1\n\"x\"\n1\n0\n2\n0\n1\n",
                                        "99999999\n",
                                        "-3\n",
                                        "1\n\"x\"\n1\n0\n3\n0\n2147483647\n1\n"};
    for (size_t i = 0; i < sizeof heads / sizeof heads[0]; i++) {
        int64_t place[N_NODES];
        const struct variant variant = {.binary = 1};
        file_builder builder = gmsh_make_msh2(&variant, place);
        builder_text(&builder, "$ElementNodeData\n%sabcdefgh", heads[i]);
        builder_integer(&builder, -1, 4);
        builder_text(&builder, "\n$EndElementNodeData\n");
        planish_file *file = builder_file(&builder, &io_format_gmsh);
        planish_file_close(file);
        builder_try_to_break(&builder, &io_format_gmsh);
        builder_release(&builder);
    }
}

/* ---- bad files ---------------------------------------------------------------------------- */

#define HEAD      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
#define HEAD4     "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
#define OLD_NODES "$NOD\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$ENDNOD\n"
#define NODES     "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n"
#define NODES4    "$Nodes\n1 3 1 3\n2 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 0\n$EndNodes\n"

static void test_errors(void **state) {
    (void)state;
    static const reading_refusal cases[] = {
        {"$NOD\n1\n", "1 nodes cannot be"},
        {"$NOD\n1\n1 0 0 0\n$EndNodes\n", "$ENDNOD expected"},
        {"$ELM\n1\n", "$ELM stands before $Nodes"},
        {OLD_NODES "$ELM\n1\n1 4 7 1 3 1 2 3 4\n$ENDELM\n", "element"},
        {OLD_NODES "$ELM\n1\n1 4 7 1 4 1 2 3\n$ENDELM\n", "element"},
        {OLD_NODES "$ELM\n2\n1 4 7 1 4 1 2 3 4\n$ENDELM\n", "element"},
        {OLD_NODES, "without $Elements"},
        {"$MeshFormat\n3.0 0 8\n", "gmsh IN.msh -0 -format msh41"},
        {"$MeshFormat\n4.2 0 8\n", "version 4.2"},
        {HEAD "$PhysicalNames\n2\n2 1 \"a\"\n$EndPhysicalNames\n", "number of names is wrong"},
        {HEAD "$PhysicalNames\n1\n2 1 \"a\n$EndPhysicalNames\n", "test:6: closing quote"},
        {HEAD "$PhysicalNames\n1\n-2 1 \"a\"\n", "dimension -2"},
        {HEAD "$PhysicalNames\n1\nsteel\n", "test:6: dimension, number and name"},
        {"$MeshFormat\n2.2 0 4\n", "data size 4"},
        {"$MeshFormat\n2.2 0 8\n", "test:3: $EndMeshFormat expected"},
        {HEAD, "without $Nodes"},
        {HEAD NODES, "without $Elements"},
        {HEAD "$Elements\n", "before $Nodes"},
        {NODES, "no $MeshFormat"},
        {HEAD NODES NODES, "second $Nodes"},
        {HEAD "$Nodes\n4611686018427387904\n1 0 0 0\n", "4611686018427387904 nodes cannot be"},
        {HEAD "$Nodes\n-1\n", "-1 nodes cannot be in the"},
        {HEAD "$Nodes\n2\n1 0 0 0\n1 1 0 0\n$EndNodes\n", "node number 1 occurs twice"},
        {HEAD "$Nodes\n2\n1 0 0 0\n2 nan 0 0\n$EndNodes\n", "test:7: node 2 has a coordinate"},
        {HEAD "$Nodes\n2\n1 0 0 0\n2 1 1e999 0\n$EndNodes\n", "not finite"},
        {HEAD "$Nodes\n2\n1 0 0 0\n2 1 0\n$EndNodes\n", "coordinate expected"},
        {HEAD "$Nodes\n1\n1 0 0 0\n2 1 0 0\n$EndNodes\n", "$EndNodes expected"},
        {HEAD NODES "$Elements\n1\n1 4 2 0 1 1 2 3 5\n$EndElements\n", "there is no node 5"},
        {HEAD NODES "$Elements\n1\n1 4 2 0 1 1 2 3\n$EndElements\n", "test:13: element"},
        {HEAD NODES "$Elements\n1\n1 99999 0 1\n$EndElements\n", "element type 99999 is not known"},
        {HEAD NODES "$Elements\n1\n1 29 0 1 2 3 4 1 2 3 4 1 2 3 4 1 2 3 4 1 2 3 4\n",
         "tetrahedra: elements of"},
        {HEAD NODES "$Elements\n1\n1 11 0 1 2 3 4 1 2 3 4 1 5\n", "there is no node 5"},
        {HEAD NODES "$Elements\n1\n1 11 0 1 2 3 4 1 2 3 4\n$EndElements\n", "element"},
        {HEAD NODES "$Elements\n2\n1 4 0 1 2 3 4\n$EndElements\n", "element"},
        {HEAD NODES "$Elements\n1\n1 4 -3 1 2 3 4\n$EndElements\n", "element"},
        {HEAD NODES "$Elements\n4611686018427387904\n", "cannot be in the"},
        {HEAD NODES "$Elements\n3\n1 4 0 1 2 3 4\n2 15 0 1\n1 4 0 1 2 4 3\n$EndElements\n",
         "element number 1 occurs twice"},
        {HEAD NODES "$Elements\n1\n1 15 0 1\n$EndElements\n", "nothing to smooth"},
        {HEAD "$NodeData\n1\n", "no $EndNodeData"},
        {HEAD "$ParametricNodes\n", "msh41"},
        {HEAD4 "$Entities\n0 0 0 1\n1 0 0 0 1 1 1 4611686018427387904\n", "cannot be in the"},
        {HEAD4 "$Nodes\n1 4611686018427387904 1 2\n", "cannot be in the"},
        {HEAD4 "$Nodes\n1 1 1 1\n2 1 0 2\n1\n2\n0 0 0\n0 0 1\n$EndNodes\n", "more than the 1"},
        {HEAD4 "$Nodes\n1 2 1 2\n2 1 0 1\n1\n0 0 0\n$EndNodes\n", "1 of the 2"},
        {HEAD4 "$Nodes\n1 1 1 1\n7 1 0 1\n1\n0 0 0\n$EndNodes\n", "block of dimension 7"},
        {HEAD4 NODES4 "$Elements\n1 1 1 1\n2 1 2 1\n1 1 2 4\n$EndElements\n", "no node 4"},
        {HEAD4 NODES4 "$Elements\n1 1 1 1\n2 1 21 1\n1 1 2 3\n$EndElements\n",
         "triangles: elements of"},
        {HEAD4 NODES4 "$Periodic\n1\n1 1 2\n-4\n", "periodic transform expected"},
    };
    reading_refuses(&io_format_gmsh, cases, sizeof cases / sizeof *cases);
}

/* A block header whose size would be 0 or less must not divide by it. */
static void test_binary_tags_that_lie(void **state) {
    (void)state;
    file_builder file = {.binary = 1};
    builder_text(&file, "$MeshFormat\n2.2 1 8\n");
    builder_integer(&file, 1, 4);
    builder_text(&file, "\n$EndMeshFormat\n$Nodes\n1\n");
    builder_integer(&file, 1, 4);
    for (int i = 0; i < 3; i++)
        builder_real(&file, 0, 8);
    builder_text(&file, "\n$EndNodes\n$Elements\n1\n");
    builder_integer(&file, 4, 4);
    builder_integer(&file, 1, 4);
    builder_integer(&file, -5, 4);
    builder_expect_error(&file, &io_format_gmsh, "byte");
    builder_release(&file);
}

static void test_recognise(void **state) {
    (void)state;
    assert_true(io_format_gmsh.recognise("\n$MeshFormat", 12));
    assert_false(io_format_gmsh.recognise("$", 1));
    assert_false(io_format_gmsh.recognise("", 0));
    assert_false(io_format_gmsh.recognise("MeshVersionFormatted 2", 22));
}

/* ---- files made by others ----------------------------------------------------------------- */

static void test_real_files(void **state) {
    (void)state;
    const struct {
        const char *name;
        int nodes, elements, groups, regions;
    } cases[] = {
        {"part_10k.msh", 2689, 10350, 0, 1},       {"mmg_cube.msh", 152, 373, 0, 1},
        {"msq2d_shashkov.msh", 4225, 8192, 0, 1},  {"part_msh41.msh", 8565, 40356, 2, 1},
        {"part_msh41_bin.msh", 8565, 40356, 2, 1}, {"two_materials.msh", 2360, 10752, 2, 2}};
    const char *folder = getenv("PLANISH_MESHES");
    if (folder == NULL)
        skip();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char path[1024];
        planish_file *file;
        planish_error error;
        planish_file_info info;
        snprintf(path, sizeof path, "%s/%s", folder, cases[i].name);
        if (planish_file_open(path, NULL, 2, &file, &error) != 0)
            fail_msg("%s", error.text);
        planish_file_get_info(file, &info);
        assert_int_equal(planish_file_mesh(file).n_nodes, cases[i].nodes);
        assert_int_equal(planish_file_mesh(file).n_elements, cases[i].elements);
        assert_int_equal(file->model.n_groups, cases[i].groups);
        assert_int_equal(info.n_regions, cases[i].regions);
        planish_file_close(file);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_msh2),
        cmocka_unit_test(test_msh1),
        cmocka_unit_test(test_msh40),
        cmocka_unit_test(test_msh4),
        cmocka_unit_test(test_names_without_dimension),
        cmocka_unit_test(test_lines_without_names),
        cmocka_unit_test(test_binary_data),
        cmocka_unit_test(test_binary_data_that_lie),
        cmocka_unit_test(test_plane_mesh),
        cmocka_unit_test(test_noise_of_a_plane),
        cmocka_unit_test(test_other_elements_are_read),
        cmocka_unit_test(test_partition),
        cmocka_unit_test(test_copies),
        cmocka_unit_test(test_large_msh2),
        cmocka_unit_test(test_large_msh4),
        cmocka_unit_test(test_errors),
        cmocka_unit_test(test_binary_tags_that_lie),
        cmocka_unit_test(test_recognise),
        cmocka_unit_test(test_real_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
