/* Netgen: what is read, what is held, what is refused, what is written. */
#include "support/file_builder.h"
#include "support/files.h"
#include "support/reading.h"
#include "support/rewriting.h"
#include "support/unit_elements.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define HEAD  "mesh3d\ndimension\n3\ngeomtype\n0\n"
#define NODES "points\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
#define TET   "volumeelements\n1\n1 4 1 2 3 4\n"
#define TAIL  "endmesh\n"

/* Everything, with names that are keywords, sections in another order, and what nobody knows. */
static const char solid[] =
    "# written by hand\n\nmesh3d\ndimension\n3\ngeomtype\n0\n"
    "# surfnr domin domout tlosurf bcprop\nfacedescriptors\n2\n0 1 0 -1 5\n1 1 0 -1 6\n"
    "# surfnr    bcnr   domin  domout      np      p1      p2      p3\n"
    "surfaceelementsuv\n2\n 1 5 1 0 3 1 2 3 0 0.5 1 0 0.5 1e-3\n 2 6 1 0 4 6 7 8 9 0 0 0 0 0 0 0 "
    "0\n"
    "volumeelements\n3\n7 4 1 2 3 4\n8 4 2 3 4 5\n9 5 6 7 8 9 10\n"
    "edgesegmentsgi2\n2\n 1 0 1 2 -1839530944 -3 1 5 11 0 0 0.5\n 1 0 2 3 0 0 1 5 12 0 0 0.25\n"
    "# X Y Z\npoints\n14\n  0.00  0.0 0\n 1 0 0\n0 1 0\n0 0 1\n1 1 1.5\n9 0 0\n9 1 0\n9 1 1\n9 0 "
    "1\n"
    "8 0 0\n7 0 0\n6 0 0\n5 0 0\n4 0 0\n"
    "pointelements\n1\n 11 3\n"
    "identifications\n3\n 12 13 2\n 1 2 1\n 4 4 2\nidentificationtypes\n2\n 1 2\n"
    "identificationnames\n2\npoints\ndefault\n"
    "materials\n2\n7 in ner\n8 points\n\n\nbcnames\n3\n5\touter\n6\t\n7 endmesh\n"
    "cd2names\n1\n12 rim\ncd3names\n1\n3 tip\n"
    "singular_points\n1\n14\t1.5\nsingular_edge_left\n1\n1\t1\n"
    "# Surfnr Red\nface_colours\n1\n 1 0.5 0.25 1.0\nendmesh\n\ncsgsurfaces 8\npoints 3 0\n";
enum { N_POINTS = 14 };

static const io_group *group_of(const planish_file *file, const char *name) {
    for (int32_t i = 0; i < file->model.n_groups; i++)
        if (strcmp(file->model.group[i].name, name) == 0)
            return &file->model.group[i];
    fail_msg("no group %s", name);
    return NULL;
}

static void group_is(const planish_file *file, const char *name, int dim, int tag) {
    assert_int_equal(group_of(file, name)->dim, dim);
    assert_int_equal(group_of(file, name)->tag, tag);
}

static void a_solid_is_read(void **state) {
    (void)state;
    static const int32_t elements[] = {0, 1, 2, 3, 1, 2, 3, 4};
    static const reading_facts facts = {.dim = 3,
                                        .n_nodes = N_POINTS,
                                        .n_elements = 3,
                                        .n_regions = 3,
                                        .n_other = 0,
                                        .n_lower = 2 + 2 + 1,
                                        .precision = PLANISH_PRECISION_DOUBLE};
    planish_file *file = reading_text(&io_format_netgen, solid);
    reading_gave(file, &io_format_netgen, &facts);
    const io_model *model = &file->model;
    planish_mesh mesh = planish_file_mesh(file);
    assert_memory_equal(mesh.cells->node, elements, sizeof elements);
    assert_true(mesh.coordinates[14] == 1.5);
    assert_int_equal(planish_file_node_number(file, 4), 5);
    assert_int_equal(planish_file_element_number(file, 1), 2);
    assert_int_equal(reading_tag(file, model->tetrahedron.entity, 0), 7);
    assert_int_equal(reading_tag(file, model->tetrahedron.entity, 1), 8);
    assert_int_equal(reading_tag(file, model->triangle.entity, 0), 5);
    assert_int_equal(reading_tag(file, model->line.entity, 0), 11);
    assert_int_equal(reading_tag(file, model->line.entity, 1), 12);
    group_is(file, "in ner", 3, 7);
    group_is(file, "points", 3, 8);
    group_is(file, "outer", 2, 5);
    group_is(file, "endmesh", 2, 7);
    group_is(file, "rim", 1, 12);
    group_is(file, "tip", 0, 3);
    assert_int_equal(model->n_groups, 6);
    planish_file_close(file);
}

static void nodes_are_held(void **state) {
    (void)state;
    planish_file *file = reading_text(&io_format_netgen, solid);
    /* 1 2 3 4: between regions, on lines, triangles; 5 and 10: free; a quadrilateral holds 6 to 9, a
     * point element 11, identifications 12 and 13, a singular point 14 */
    reading_holds(file, NULL, READING_REGIONS, "11110111101111");
    reading_holds(file, "points", READING_REGIONS, "11111111101111");
    reading_holds(file, "3:9", READING_REGIONS, "11110111111111");
    for (int node = 0; node < N_POINTS; node++) /* the point alone has a group: tip */
        assert_int_equal(file->model.node_entity[node] >= 0, node == 10);
    assert_int_equal(reading_tag(file, file->model.node_entity, 10), 3);
    reading_holds(file, "2:6", READING_REGIONS, "11110111101111");
    /* Sliding leaves those of close surfaces (1 2), of a singular edge (2 3). */
    reading_holds(file, NULL, READING_REGIONS | READING_SLIDE, "11100000001001");
    reading_holds(file, "2:6", READING_REGIONS | READING_SLIDE, "11100111101001");
    assert_int_equal(planish_file_mesh(file).n_periodic, 1);
    assert_int_equal(planish_file_mesh(file).periodic[0], 11);
    assert_int_equal(planish_file_mesh(file).periodic[1], 12);
    planish_file_close(file);
}

static const char flat[] =
    "mesh3d\ndimension\n2\ngeomtype\n0\n\nsurfaceelements\n3\n 2 1 0 0 3 1 2 3\n 2 2 0 0 0 1 3 4\n"
    " 2 2 0 0 4 5 6 7 8\nvolumeelements\n0\n\n\n"
    "edgesegmentsgi2\n1\n 6 0 1 2 305642640 306785616 1 0 9 0 1 0.2\n"
    "points\n8\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 3 0\n4 3 0\n4 4 0\n3 4 0\n"
    "materials\n2\n1 one\n2 two\nbcnames\n1\n6 bottom\ncd2names\n1\n1 corner\ncd3names\n1\n1 no\n"
    "endmesh\n";

static void a_plane_is_read(void **state) {
    (void)state;
    static const int32_t elements[] = {0, 1, 2, 0, 2, 3};
    planish_file *file = reading_text(&io_format_netgen, flat);
    planish_mesh mesh = planish_file_mesh(file);
    assert_int_equal(mesh.dim, 2);
    assert_int_equal(mesh.n_elements, 3);
    assert_memory_equal(mesh.cells->node, elements, sizeof elements);
    assert_int_equal(reading_tag(file, file->model.triangle.entity, 1), 2);
    assert_int_equal(reading_tag(file, file->model.line.entity, 0), 6);
    group_is(file, "two", 2, 2);
    group_is(file, "bottom", 1, 6);
    group_is(file, "corner", 0, 1);
    assert_int_equal(file->model.n_groups, 4);
    reading_holds(file, NULL, READING_REGIONS, "11100000");
    reading_holds(file, "two", READING_REGIONS, "11111111");
    planish_file_close(file);
}

static void segments_of_every_kind(void **state) {
    (void)state;
    static const struct {
        const char *text;
        int tag;
        const char *has_parameters; /* of each node */
    } cases[] = {
        {"edgesegments\n1\n5 0 2 3\n", 5, "0000"},
        {"edgesegmentsgi\n1\n5 0 2 3 9 9\n", 5, "0000"},
        {"edgesegmentsgi2\n1\n5 0 2 3\n9 9 1 2 6 0 0 0\n", 6, "0000"}, /* on two lines */
        {"edgesegmentsgi2\n1\n5 0 2 3\n9 9 1 2 6 0 0 0.5\n", 6, "0010"},
        {"edgesegmentsgi2\n1\n5 0 2 3\n9 9 1 2 6 -2e-9 0 0\n", 6, "0100"},
        {"edgesegmentsgi3\n1\n2 3 9 9 0.5 0 6\n", 7, "0100"},
        {"edgesegmentsgi3\n1\n2 3 9 9 0.5 0.25 6\n", 7, "0110"},
        {"surfaceelementsuv\n1\n1 5 1 0 3 1 2 3 0 0.5 1 0 0.5 1\nedgesegments\n1\n5 0 2 3\n", 5,
         "1110"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[512];
        snprintf(text, sizeof text, HEAD "%s" NODES TET TAIL, cases[i].text);
        planish_file *file = reading_text(&io_format_netgen, text);
        assert_int_equal(reading_tag(file, file->model.line.entity, 0), cases[i].tag);
        reading_holds(file, NULL, READING_REGIONS, i == 7 ? "1110" : "0110");
        uint8_t has[4];
        int64_t n = 0;
        planish_file_get_parametric(file, has);
        for (int k = 0; k < 4; k++) {
            assert_int_equal(has[k], cases[i].has_parameters[k] == '1');
            n += has[k];
        }
        assert_int_equal(planish_file_get_parametric(file, NULL), n);
        planish_file_close(file);
    }
}

static void two_sections_of_elements_are_one_list(void **state) {
    (void)state;
    planish_file *file = reading_text(&io_format_netgen, HEAD NODES TET TET TAIL);
    assert_int_equal(planish_file_mesh(file).n_elements, 2);
    planish_file_close(file);
}

static void pairs_without_types_are_periodic(void **state) {
    (void)state;
    planish_file *file =
        reading_text(&io_format_netgen, HEAD NODES TET "identifications\n1\n1 2 1\n" TAIL);
    assert_int_equal(planish_file_mesh(file).n_periodic, 1);
    planish_file_close(file);
}

static void line_ends_of_every_kind(void **state) {
    (void)state;
    for (int kind = 0; kind < 3; kind++) {
        char text[2 * sizeof solid];
        size_t used = 0;
        for (size_t i = 0; i + 1 < sizeof solid; i++) {
            if (solid[i] == '\n' && kind == 0)
                text[used++] = '\r';
            text[used++] = solid[i] == '\n' && kind == 1 ? '\r' : solid[i];
        }
        if (kind == 2) /* no newline at the end */
            used = (size_t)(strstr(solid, "endmesh\n\n") - solid) + strlen("endmesh");
        text[used] = '\0';
        planish_file *file = reading_text(&io_format_netgen, text);
        assert_int_equal(file->model.n_groups, 6);
        group_is(file, "in ner", 3, 7);
        reading_holds(file, NULL, READING_REGIONS, "11110111101111");
        planish_file_close(file);
    }
}

static void wrong_files_are_refused(void **state) {
    (void)state;
    static const reading_refusal cases[] = {
        {"mesh2d\n", "no mesh3d"},
        {HEAD, "no endmesh"},
        {HEAD NODES TET "face_colours\n1\n1 0.5 0.25 1.0\n", "no endmesh"}, /* whole or not? */
        {HEAD NODES "volumeelements\n1\n1 4 1 2 3 4", "no endmesh"},        /* of node 42? */
        {HEAD NODES "volumeelements\n2\n1 4 1 2 3 4\n", "cannot be in"},
        {HEAD NODES TET "materials\n2\n1 a\n", "line 2 of 2"},
        {HEAD NODES TAIL, "nothing to smooth"},
        {HEAD TET TAIL, "no points"},
        {HEAD NODES NODES TET TAIL, "second time"},
        {"mesh3d\ndimension\n1\n" TAIL, "dimension 1"},
        {"mesh3d\ndimension\nx\n" TAIL, "after dimension"},
        {HEAD NODES "volumeelements\n1\n1 4 1 2 3 5\n" TAIL, "test:14: volumeelements 1: number 5"},
        {HEAD NODES "volumeelements\n1\n1 4 1 2 3 0\n" TAIL, "not in 1 .. 4"},
        {HEAD NODES "volumeelements\n2\n1 4 1 2 3 4\n1 4 1 2 3\n" TAIL, "whole number"},
        {HEAD NODES "volumeelements\n1\n1 4 1 2 3 4\n1 4 1 2 3 4\n" TAIL, "more than 1"},
        {HEAD NODES "volumeelements\n1\n1 4 1 2 3 4 4\n" TAIL, "more than 1"},
        {HEAD NODES "volumeelements\n1\n1 10 1 2 3 4 1 2 3 4 1\n" TAIL, "whole number"},
        {HEAD NODES "volumeelements\n1\n1 10 1 2 3 4 1 2 3 4 1 5\n" TAIL, "not in 1 .. 4"},
        {HEAD NODES TET "curvedelements\n3\n" TAIL, "Curve()"},
        {HEAD NODES "volumeelements\n1\n1 2 1 2\n" TAIL, "2 nodes are unknown"},
        {HEAD NODES "volumeelements\n1\n1 99 1 2 3 4 5 6\n" TAIL, "99 nodes"},
        {HEAD NODES "volumeelements\n1\n1 -4 1 2 3 4 5 6\n" TAIL, "-4 nodes"},
        {HEAD NODES "volumeelements\n1\n99999999999 4 1 2 3 4\n" TAIL,
         "number 99999999999 is not in"},
        {HEAD NODES "volumeelements\n4611686018427387904\n1 4 1 2 3 4\n" TAIL, "cannot be in"},
        {HEAD NODES "volumeelements\n-1\n1 4 1 2 3 4\n" TAIL, "cannot be in"},
        {HEAD "points\n2\n0 0 nan\n0 0 0\n" TET TAIL, "not finite"},
        {HEAD "points\n2\n0 0 1e999\n0 0 0\n" TET TAIL, "not finite"},
        {HEAD "points\n2\n0 0 0\n0 0\n" TET TAIL, "coordinate"},
        {HEAD NODES TET "edgesegments\n1\n1 0 1 5\n" TAIL, "not in 1 .. 4"},
        {HEAD NODES TET
         "edgesegmentsgi2\n1\n1 0 1 2 0 0\nmaterials\n1\n1 a\nbcnames\n1\n5 b\n" TAIL,
         "test:18: the next section begins within"},
        {HEAD NODES TET "pointelements\n1\n5 1\n" TAIL, "not in 1 .. 4"},
        {HEAD NODES TET "identifications\n1\n5 1 1\n" TAIL, "not in 1 .. 4"},
        {HEAD NODES TET "singular_edge_left\n1\n0 1\n" TAIL, "number 0 is not in"},
        {HEAD NODES TET "pointelements\n1\n-9223372036854775808 1\n" TAIL, "not in 1 .. 4"},
        {HEAD NODES TET "materials\n2\n1 a\n" TAIL, "line 2 of 2"},
        {HEAD NODES TET "bcnames\n1\n99999999999 a\n" TAIL, "out of range"},
        {HEAD NODES TET "identificationnames\n2\na\n", "line 2 of 2"},
    };
    reading_refuses(&io_format_netgen, cases, sizeof cases / sizeof *cases);
    reading_gives_surface(&io_format_netgen,
                          HEAD NODES "surfaceelements\n2\n1 1 0 0 3 2 3 4\n1 1 0 0 3 1 2 4\n" TAIL);
}

/** Whether the first size bytes of solid end where the next line is a keyword or nothing. */
static int ends_behind_section(int64_t size) {
    const char *at = solid + size;
    while (*at == '\n' || *at == ' ' || *at == '#')
        at = *at == '#' ? strchr(at, '\n') : at + 1;
    return *at >= 'a' && *at <= 'z';
}

static void files_are_cut_anywhere(void **state) {
    (void)state;
    file_builder solid_file = builder_of(solid);
    file_builder flat_file = builder_of(flat);
    builder_try_to_break(&solid_file, &io_format_netgen);
    builder_try_to_break(&flat_file, &io_format_netgen);
    /* Without endmesh a file is whole only where it ends behind a section. */
    const int64_t whole = strstr(solid, "endmesh\n\n") - solid + (int64_t)strlen("endmesh");
    for (int64_t size = 0; size < whole; size++) {
        planish_file *file = NULL;
        planish_error error;
        const int status =
            io_file_from_memory(&io_format_netgen, "test", solid, size, 1, &file, &error);
        if (status == 0)
            assert_true(solid[size - 1] == '\n' && ends_behind_section(size));
        planish_file_close(status == 0 ? file : NULL);
    }
}

static void files_may_lack_endmesh(void **state) {
    (void)state;
    static const char *const tails[] = {"",
                                        "\n\n",
                                        "# the end\n",
                                        "edgesegments\n0\n",
                                        "edgesegments\n1\n5 0 2 3\n",
                                        "materials\n1\n1 a\n"};
    for (size_t i = 0; i < sizeof tails / sizeof *tails; i++) {
        char text[512];
        snprintf(text, sizeof text, HEAD NODES TET "%s", tails[i]);
        planish_file *file = reading_text(&io_format_netgen, text);
        assert_int_equal(planish_file_mesh(file).n_elements, 1);
        planish_file_close(file);
    }
}

static void nothing_but_coordinates_changes(void **state) {
    rewriting_keeps_the_rest(&io_format_netgen, solid, sizeof solid - 1, *state);
    rewriting_keeps_the_rest(&io_format_netgen, flat, sizeof flat - 1, *state);
}

/* Types and the order of nodes as MakeSecondOrder in Netgen's secondorder.cpp makes them; the corners
 * are mirrored to VTK's, which makes no difference. */
static const unit_element elements[] = {
    {PLANISH_CELL_TRIANGLE, 3, "0 1 2"},
    {PLANISH_CELL_QUADRILATERAL, 4, "0 1 2 3"},
    {PLANISH_CELL_TRIANGLE6, 6, "0 1 2 12 02 01"},
    {PLANISH_CELL_QUADRILATERAL8, 8, "0 1 2 3 01 32 03 12"},
    {PLANISH_CELL_PYRAMID, 5, "0 1 2 3 4"},
    {PLANISH_CELL_TETRAHEDRON, 4, "0 1 2 3"},
    {PLANISH_CELL_WEDGE, 6, "0 1 2 3 4 5"},
    {PLANISH_CELL_HEXAHEDRON, 8, "0 1 2 3 4 5 6 7"},
    {PLANISH_CELL_TETRAHEDRON10, 10, "0 1 2 3 01 02 03 12 13 23"},
    {PLANISH_CELL_WEDGE15, 12, "0 1 2 3 4 5 02 01 12 35 34 45"}, /* upright edges without mids */
    {PLANISH_CELL_PYRAMID13, 13, "0 1 2 3 4 01 32 30 12 04 14 24 34"},
    {PLANISH_CELL_WEDGE15, 15, "0 1 2 3 4 5 01 02 12 03 14 25 34 35 45"},
    {PLANISH_CELL_HEXAHEDRON20, 20, "0 1 2 3 4 5 6 7 01 23 30 12 45 67 74 56 04 15 26 37"},
};
enum { N_ELEMENTS = sizeof elements / sizeof *elements };

/** Write times elements of each type of a dimension, in two sections. */
static file_builder make_elements(int dim, int times) {
    file_builder b = {0};
    double x[UNIT_NODES][3];
    int n_nodes = 0, n_types = 0, at = 0;
    for (int i = 0; i < N_ELEMENTS; i++) {
        n_types += unit_dim(elements[i].type) == dim;
        if (unit_dim(elements[i].type) == dim)
            n_nodes += unit_places(elements[i].type, elements[i].nodes, x);
    }
    builder_text(&b, "mesh3d\ndimension\n%d\ngeomtype\n0\npoints\n%d\n", dim, times * n_nodes);
    for (int i = 0; i < times * N_ELEMENTS; i++) {
        const unit_element *e = &elements[i % N_ELEMENTS];
        const int n = unit_dim(e->type) == dim ? unit_places(e->type, e->nodes, x) : 0;
        for (int k = 0; k < n; k++)
            builder_text(&b, "%.17g %.17g %.17g\n", x[k][0], x[k][1], x[k][2]);
    }
    for (int section = 0; section < 2; section++) {
        const int n_times = section == 0 ? times / 2 : times - times / 2;
        builder_text(&b, "%s\n%d\n", dim == 2 ? "surfaceelements" : "volumeelements",
                     n_types * n_times);
        for (int i = 0; i < n_times * N_ELEMENTS; i++) {
            const unit_element *e = &elements[i % N_ELEMENTS];
            if (unit_dim(e->type) != dim)
                continue;
            builder_text(&b, dim == 2 ? "1 1 1 0 %d" : "1 %d", e->code);
            for (int k = 0; k < e->code; k++)
                builder_text(&b, " %d", ++at);
            builder_text(&b, "\n");
        }
    }
    builder_text(&b, TAIL);
    return b;
}

static void every_type_has_its_nodes_in_order(void **state) {
    enum { TIMES = 3 };
    for (int dim = 2; dim <= 3; dim++) {
        file_builder b = make_elements(dim, TIMES);
        int64_t cell = 0;
        planish_file *file = builder_file(&b, &io_format_netgen);
        for (int pass = 0; pass < 2; pass++) {
            int number = 1;
            for (int i = 0; i < TIMES * N_ELEMENTS; i++) {
                const int type = elements[i % N_ELEMENTS].type;
                if (unit_dim(type) != dim)
                    continue;
                if (unit_is_simplex(type) == (pass == 0)) {
                    unit_expect(file, cell, type);
                    assert_int_equal(planish_file_element_number(file, cell++), number);
                }
                number++;
            }
        }
        unit_expect_valid(file, cell);
        assert_int_equal(file->model.n_other, 0);
        assert_int_equal(planish_file_mesh(file).n_elements, cell);
        planish_file_close(file);
        rewriting_keeps_the_rest(&io_format_netgen, b.data, b.size, *state);
        builder_let_allocations_fail(&b, &io_format_netgen);
        builder_release(&b);
        b = make_elements(dim, 4000);
        builder_expect_same_on_threads(&b, &io_format_netgen);
        builder_release(&b);
    }
}

/** Elements of second order for the parallel path, all of them or with a straight one at the end, which
 *  needs the serial one: it has no mids. */
static void threads_read_mids(void **state) {
    (void)state;
    enum { N = 40000 };
    static const char *const last[] = {"", "1 4 5 6 7 8\n"};
    for (int mixed = 0; mixed < 2; mixed++) {
        file_builder b = {0};
        planish_file *file;
        planish_error error;
        builder_text(&b, HEAD "volumeelements\n%d\n", N + mixed);
        for (int i = 0; i < N; i++)
            builder_text(&b, "1 10 %d %d %d %d %d %d %d %d %d %d\n", i + 1, i + 2, i + 3, i + 4,
                         i + 5, i + 6, i + 7, i + 8, i + 9, i + 10);
        builder_text(&b, "%spoints\n%d\n", last[mixed], N + 10);
        for (int i = 0; i < N + 10; i++)
            builder_text(&b, "%d.5 %d 1e-%d\n", i, i * 7 % 1000, i % 20);
        builder_text(&b, TAIL);
        builder_expect_same_on_threads(&b, &io_format_netgen);
        assert_int_equal(builder_read(&b, &io_format_netgen, 3, &file, &error), 0);
        const planish_mesh mesh = planish_file_mesh(file);
        assert_int_equal(mesh.n_elements, N + mixed);
        for (int i = 0; i < N + mixed; i++)
            assert_int_equal(mesh.cells->type[i],
                             i < N ? PLANISH_CELL_TETRAHEDRON10 : PLANISH_CELL_TETRAHEDRON);
        assert_int_equal(file->model.n_other, 0);
        planish_file_close(file);
        builder_release(&b);
    }
}

/** Large enough for the parallel path; with an element of another kind in the middle, which needs
 *  the serial one. */
static void threads_read_the_same(void **state) {
    (void)state;
    enum { N = 60000 };
    for (int mixed = 0; mixed < 2; mixed++) {
        file_builder b = {0};
        planish_file *file;
        planish_error error;
        builder_text(&b, HEAD "surfaceelementsgi\n%d\n", N);
        for (int i = 0; i < N; i++)
            builder_text(&b, "%d %d 1 0 3 %d %d %d 0 0 0\n", i % 5, i % 7, i + 1, i + 2, i + 3);
        builder_text(&b, "volumeelements\n%d\n", N);
        for (int i = 0; i < N; i++)
            if (mixed && i == N / 2)
                builder_text(&b, "1 5 1 2 3 4 5\n");
            else
                builder_text(&b, "%d 4 %d %d %d %d\n", i % 3, i + 1, i + 2, i + 3, i + 4);
        builder_text(&b, "edgesegmentsgi2\n%d\n", N);
        for (int i = 0; i < N; i++)
            builder_text(&b, "1 0 %d %d 0 0 1 5 %d 0 0 0.5\n", i + 1, i + 2, i % 9);
        builder_text(&b, "points\n%d\n", N + 4);
        for (int i = 0; i < N + 4; i++)
            builder_text(&b, "%d.5 %d 1e-%d\n", i, i * 7 % 1000, i % 20);
        builder_text(&b, TAIL);
        builder_expect_same_on_threads(&b, &io_format_netgen);
        assert_int_equal(builder_read(&b, &io_format_netgen, 3, &file, &error), 0);
        assert_int_equal(planish_file_mesh(file).n_elements, N);
        assert_int_equal(file->model.solid.n, mixed);
        planish_file_close(file);
        builder_release(&b);
    }
}

/** A control character within a word, as no space is: also for threads. */
static void threads_part_words_alike(void **state) {
    (void)state;
    enum { N = 300000 };
    file_builder b = {0};
    planish_file *file;
    planish_error error;
    builder_text(&b,
                 HEAD NODES TET "singular_points\n%d\n1 7\x01"
                                "5\n",
                 N);
    for (int i = 1; i < N; i++)
        builder_text(&b, "1 2\n");
    builder_text(&b, TAIL);
    builder_expect_same_on_threads(&b, &io_format_netgen);
    for (int threads = 1; threads <= 8; threads += 7) {
        assert_int_equal(builder_read(&b, &io_format_netgen, threads, &file, &error), 0);
        reading_holds(file, NULL, READING_REGIONS, "1000");
        planish_file_close(file);
    }
    builder_release(&b);
}

/** Names that are passed over are lines, be they empty. */
static void lines_without_a_name_are_lines(void **state) {
    (void)state;
    static const char *const names[] = {"identificationnames\n2\n\n\n",
                                        "identificationnames\r\n3 \r\n\r\na\r\n\r\n",
                                        "edgedescriptors\n1\n\n", "identificationnames\n0\n"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char text[512];
        snprintf(text, sizeof text, HEAD NODES TET "%ssingular_points\n1\n4 1.0\n" TAIL, names[i]);
        planish_file *file = reading_text(&io_format_netgen, text);
        reading_holds(file, NULL, READING_REGIONS, "0001");
        planish_file_close(file);
    }
}

static void a_mark_of_utf8_is_passed_over(void **state) {
    (void)state;
    static const char text[] = "\xef\xbb\xbf" HEAD NODES TET TAIL;
    assert_true(io_format_netgen.recognise(text, sizeof text - 1));
    planish_file_close(reading_text(&io_format_netgen, text));
    rewriting_keeps_the_rest(&io_format_netgen, text, sizeof text - 1, *state);
    reading_fails(&io_format_netgen, "\xef\xbb", "no mesh3d");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_solid_is_read),
        cmocka_unit_test(nodes_are_held),
        cmocka_unit_test(a_plane_is_read),
        cmocka_unit_test(segments_of_every_kind),
        cmocka_unit_test(two_sections_of_elements_are_one_list),
        cmocka_unit_test(pairs_without_types_are_periodic),
        cmocka_unit_test(line_ends_of_every_kind),
        cmocka_unit_test(wrong_files_are_refused),
        cmocka_unit_test(files_are_cut_anywhere),
        cmocka_unit_test(files_may_lack_endmesh),
        cmocka_unit_test(nothing_but_coordinates_changes),
        cmocka_unit_test(every_type_has_its_nodes_in_order),
        cmocka_unit_test(threads_read_mids),
        cmocka_unit_test(threads_read_the_same),
        cmocka_unit_test(threads_part_words_alike),
        cmocka_unit_test(lines_without_a_name_are_lines),
        cmocka_unit_test(a_mark_of_utf8_is_passed_over),
    };
    return cmocka_run_group_tests(tests, test_folder_create, test_folder_remove);
}
