/* SU2: what is read, held, refused and written. */
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

/* Sections in another order, comments, with and without numbers, a halo, what nobody knows. */
static const char solid[] =
    "% by hand\n%\nNZONE= 1\nNDIME= 3 % here\nNMARK= 3\nMARKER_TAG= outer wall \nMARKER_ELEMS= 2\n"
    "5 0 1 2\n5 1 2 3 7\nMARKER_TAG= SEND_RECEIVE\nMARKER_ELEMS= 1\nSEND_RECV= 1\n1 4 0\n"
    "MARKER_TAG= SEND_RECEIVE\nMARKER_ELEMS= 1\nSEND_TO= -1\n1 4 0\n"
    "MARKER_TAG= rim\nMARKER_ELEMS= 1\n3 0 1\n"
    "%\n% Points 1 2 3\n%\nNPOIN= 6 5\n\t0.0 0 0 0\n1 0 0 1\n0 1 0 2\n% between 1 2 3\n0 0 1 3\n"
    "1 1 1.50 4\n5 5 5\n% Elements\nNELEM = 2\n10 0 1 2 3 0\n10 1 2 3 4\n"
    "NPERIODIC= 1\nPERIODIC_INDEX= 0\nPERIODIC_CENTER= 0 0 0\nFFD_NBOX=1\nFFD_SURFACE_POINTS= 1\n"
    "outer 1 0.5 0.5 0.5\nNCORNERS= 0\n";

static void a_solid_is_read(void **state) {
    (void)state;
    static const int32_t nodes[] = {0, 1, 2, 3, 1, 2, 3, 4};
    static const reading_facts facts = {.dim = 3,
                                        .n_nodes = 6,
                                        .n_elements = 2,
                                        .n_regions = 1,
                                        .n_other = 0,
                                        .n_lower = 5,
                                        .precision = PLANISH_PRECISION_DOUBLE};
    planish_file *file = reading_text(&io_format_su2, solid);
    reading_gave(file, &io_format_su2, &facts);
    const planish_mesh mesh = planish_file_mesh(file);
    assert_memory_equal(mesh.elements, nodes, sizeof nodes);
    assert_true(mesh.coordinates[14] == 1.5);
    assert_int_equal(planish_file_node_number(file, 5), 5);
    assert_int_equal(planish_file_element_number(file, 1), 1);
    assert_int_equal(file->model.hold[4], IO_HELD_BY_POINT);
    assert_int_equal(file->model.hold[5], 0);
    unit_expect_held(file, NULL, "111110");
    unit_expect_held(file, "outer wall", "111110");
    unit_expect_held(file, "rim", "111110");
    planish_file_close(file);
}

static const char flat[] =
    "NDIME=2\nNELEM=4\n5 0 1 4\n5 1 2 4\n5 2 3 4\n5 3 0 4\nNPOIN=5\n0 0\n1 0\n"
    "1 1\n0 1\n.25 0.50\nNMARK=2\nMARKER_TAG=low\nMARKER_ELEMS=1\n3 0 1\n"
    "MARKER_TAG=high\nMARKER_ELEMS=1\n3 2 3\n";

static void a_plane_is_read(void **state) {
    (void)state;
    static const double xy[] = {0, 0, 1, 0, 1, 1, 0, 1, .25, .5};
    planish_file *file = reading_text(&io_format_su2, flat);
    const planish_mesh mesh = planish_file_mesh(file);
    const char *tag = "high";
    const planish_hold slide = {.slide = 1, .slide_tags = &tag, .n_slide_tags = 1};
    assert_int_equal(mesh.dim, 2);
    assert_memory_equal(mesh.coordinates, xy, sizeof xy);
    const planish_surface surface = planish_file_surface(file, &slide);
    assert_int_equal(surface.n_facets, 2);
    unit_expect_held(file, NULL, "11110");
    unit_expect_held(file, "high", "11110");
    planish_error error;
    uint8_t constraint[5];
    tag = "middle";
    assert_int_equal(planish_file_constraints(file, &slide, constraint, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "low, high"));
    tag = "1"; /* markers have no numbers */
    assert_int_equal(planish_file_constraints(file, &slide, constraint, &error),
                     PLANISH_ERROR_ARGUMENT);
    planish_file_close(file);
}

/* Types and orders of nodes as of VTK, which SU2 has them from. */
static const unit_element elements[] = {
    {PLANISH_CELL_TRIANGLE, 5, "0 1 2"},       {PLANISH_CELL_QUADRILATERAL, 9, "0 1 2 3"},
    {PLANISH_CELL_TETRAHEDRON, 10, "0 1 2 3"}, {PLANISH_CELL_HEXAHEDRON, 12, "0 1 2 3 4 5 6 7"},
    {PLANISH_CELL_WEDGE, 13, "0 1 2 3 4 5"},   {PLANISH_CELL_PYRAMID, 14, "0 1 2 3 4"},
};
enum { N_ELEMENTS = sizeof elements / sizeof *elements };

static file_builder make(int i, int n, double x[UNIT_NODES][3], int variant, int64_t *second) {
    const int dim = unit_dim(elements[i].type);
    file_builder b = {0};
    *second = 1;
    builder_text(&b, "NDIME= %d\nNPOIN= %d\n", dim, n);
    for (int k = 0; k < n; k++) {
        for (int d = 0; d < dim; d++)
            builder_text(&b, "%.17g ", x[k][d]);
        builder_text(&b, variant ? "%d\n" : "\n", k);
    }
    builder_text(&b, "NELEM= 2\n");
    for (int e = 0; e < 2; e++) {
        builder_text(&b, "%d", elements[i].code);
        for (int k = 0; k < n; k++)
            builder_text(&b, " %d", k);
        builder_text(&b, variant ? " %d\n" : "\n", e);
    }
    return b;
}

static void elements_of_every_type_are_read(void **state) {
    (void)state;
    unit_expect_types(&io_format_su2, elements, N_ELEMENTS, make);
}

/** Each zone counts its points and elements from 0. */
static void zones_are_regions(void **state) {
    (void)state;
    static const char text[] =
        "NZONE= 2\nIZONE= 1\nNDIME= 2\nNELEM= 2\n5 0 1 2\n5 1 3 2\nNPOIN= 4\n0 0\n1 0\n0 1\n1 1\n"
        "NMARK= 1\nMARKER_TAG= a\nMARKER_ELEMS= 1\n3 0 1\nIZONE= 2\nNDIME= 2\nNPOIN= 3\n"
        "1 0\n2 0\n1 1\nNELEM= 1\n5 0 1 2 0\nNMARK= 1\nMARKER_TAG= b\nMARKER_ELEMS= 1\n3 2 1\n";
    static const int32_t nodes[] = {0, 1, 2, 1, 3, 2, 4, 5, 6};
    planish_file *file = reading_text(&io_format_su2, text);
    const planish_mesh mesh = planish_file_mesh(file);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(mesh.n_elements, 3);
    assert_memory_equal(mesh.elements, nodes, sizeof nodes);
    assert_int_equal(info.n_regions, 2);
    assert_int_equal(planish_file_element_number(file, 2), 2);
    unit_expect_held(file, "a", "1100011");
    rewriting_keeps_the_rest(&io_format_su2, text, sizeof text - 1, *state);
    planish_file_close(file);
    char cut[sizeof text];
    memcpy(cut, text, sizeof cut);
    memcpy(strstr(cut, "3 2 1"), "3 3 1", 5); /* a point of zone 1 alone */
    reading_fails(&io_format_su2, cut, "no node 3");
}

static void markers_of_quadrilaterals(void **state) {
    (void)state;
    file_builder b = {0};
    builder_text(&b, "NDIME= 3\nNPOIN= 12\n");
    for (int i = 0; i < UNIT_BRICK_NODES; i++)
        builder_text(&b, "%g %g %g %d\n", unit_brick_places[i][0], unit_brick_places[i][1],
                     unit_brick_places[i][2], i);
    builder_text(&b, "NELEM= 2\n12 0 1 4 3 6 7 10 9 0\n12 1 2 5 4 7 8 11 10 1\nNMARK= 1\n"
                     "MARKER_TAG= low\nMARKER_ELEMS= 1\n9 0 1 4 3\n");
    planish_file *file = builder_file(&b, &io_format_su2);
    assert_int_equal(planish_file_mesh(file).n_elements, 2);
    unit_expect_held(file, "low", "110110000000");
    unit_expect_valid(file, 2);
    const planish_surface surface = planish_file_surface(file, NULL);
    assert_int_equal(surface.n_facets, 1);
    planish_file_close(file);
    builder_release(&b);
}

#define HEAD "NDIME= 3\n"
#define FOUR "NPOIN= 4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
#define TET  "NELEM= 1\n10 0 1 2 3\n"

static void wrong_files_are_refused(void **state) {
    (void)state;
    static const reading_refusal cases[] = {
        {"", "no NDIME"},
        {FOUR TET, "no NDIME"},
        {HEAD TET, "no NPOIN"},
        {HEAD FOUR, "nothing to smooth"},
        {"NDIME= 1\n" FOUR TET, "NDIME= 1"},
        {"NDIME= 2\n" HEAD FOUR TET, "NDIME= 3"},
        {"NDIME= x\n" FOUR TET, "NDIME: a count"},
        {"NZONE= 2\n" HEAD FOUR TET, "zone 1 of 2"},
        {"NZONE= 2\nIZONE= 1\n" HEAD FOUR TET, "zone 2 of 2"},
        {"NZONE= 2\nIZONE= 2\n" HEAD FOUR TET, "zone 1 expected"},
        {HEAD FOUR "NELEM= 1\n305 0 1 2 3\n", "high order"},
        {HEAD FOUR FOUR TET, "second time"},
        {HEAD FOUR "NELEM= -1\n", "a count expected"},
        {HEAD FOUR "NELEM= 4611686018427387904\n10 0 1 2 3\n", "cannot be in"},
        {HEAD "NPOIN= 4611686018427387904\n0 0 0\n" TET, "cannot be in"},
        {HEAD FOUR "NELEM= 2\n10 0 1 2 3\n%           \n", "element 2 of 2"},
        {HEAD FOUR "NELEM= 1\n10 0 1 2 3\n10 0 1 2 3\n", "test:9: more than 1 elements"},
        {HEAD FOUR "NELEM= 1\n10 0 1 2 4\n", "test:8: element 0: there is no node 4"},
        {HEAD FOUR "NELEM= 1\n10 0 1 2 -1\n", "no node -1"},
        {HEAD FOUR "NELEM= 1\n10 0 1 2\n", "4 nodes in one line"},
        {HEAD FOUR "NELEM= 1\n10 0 1 2 3 x\n", "whole number expected behind"},
        {HEAD FOUR "NELEM= 1\n10 0 1 2 3 0 0\n", "no more than a number"},
        {HEAD FOUR "NELEM= 1\n24 0 1 2 3\n", "no type 24"},
        {HEAD FOUR "NELEM= 1\n-1 0 1 2 3\n", "no type -1"},
        {HEAD FOUR "NELEM= 1\ntet 0 1 2 3\n", "type expected"},
        {HEAD "NPOIN= 4\n0 0 0\n1 0 0\n0 1 0\n0 0 nan\n" TET, "not finite"},
        {HEAD "NPOIN= 4\n0 0 0\n1 0 0\n0 1 0\n0 0 1e999\n" TET, "not finite"},
        {HEAD "NPOIN= 4\n0 0 0\n1 0 0\n0 1\n0 0 0 1\n" TET, "node 2: coordinate"},
        {HEAD "NPOIN= 4\n0 0 0\n1 0 0\n0 1 0\n0 0 1 1.5\n" TET, "perhaps a number"},
        {HEAD "NPOIN= 4\n0 0 0\n1 0 0\n0 1 0\n" TET, "node 3: coordinate"},
        {HEAD "NPOIN= 3\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n" TET, "more than 3 points"},
        {HEAD FOUR TET "MARKER_ELEMS= 1\n5 0 1 2\n", "without MARKER_TAG"},
        {HEAD FOUR TET "MARKER_TAG= a\n", "no MARKER_ELEMS"},
        {HEAD FOUR TET "MARKER_TAG= a\nMARKER_ELEMS= 1\n5 0 1 4\n", "no node 4"},
        {HEAD FOUR TET "MARKER_TAG= a\nMARKER_ELEMS= 2\n5 0 1 2\n", "element 2 of 2"},
    };
    reading_refuses(&io_format_su2, cases, sizeof cases / sizeof *cases);
}

static void files_are_told(void **state) {
    (void)state;
    static const char *const texts[] = {solid, flat, "%\nNDIME = 2\n", "NZONE=2\n"};
    reading_tells(&io_format_su2, texts, sizeof texts / sizeof *texts, 1);
    static const char *const others[] = {"", "%", "NDIME 2\n", "NAME= 2\n", "NDIMENSION= 2\n"};
    reading_tells(&io_format_su2, others, sizeof others / sizeof *others, 0);
}

static void files_are_cut_anywhere(void **state) {
    (void)state;
    const file_builder a = builder_of(solid);
    const file_builder b = builder_of(flat);
    builder_try_to_break(&a, &io_format_su2);
    builder_try_to_break(&b, &io_format_su2);
}

static void nothing_but_coordinates_changes(void **state) {
    rewriting_keeps_the_rest(&io_format_su2, solid, sizeof solid - 1, *state);
    rewriting_keeps_the_rest(&io_format_su2, flat, sizeof flat - 1, *state);
    rewriting_gives(&io_format_su2, HEAD "NPOIN= 4\n%\n 0\t0.0 0 0\n1 0 0\n0 1 0\n0 0 1\n" TET,
                    "xz", HEAD "NPOIN= 4\n%\n 0.125\t0.0 123456.789 0\n1 0 0\n0 1 0\n0 0 1\n" TET,
                    *state);
}

/** Sections worth threads, of two types, and a comment that is no record. */
static void threads_read_the_same(void **state) {
    (void)state;
    enum { N = 30000 };
    for (int with_comment = 0; with_comment < 2; with_comment++) {
        file_builder b = {0};
        builder_text(&b, "NDIME= 3\nNPOIN= %d\n", N);
        for (int i = 0; i < N; i++)
            builder_text(&b, "%d.0000000000000000 %d %d %d\n%s", i / 2, i % 2, i % 7, i,
                         with_comment && i == N / 2 ? "% 1 2 3\n" : "");
        builder_text(&b, "NELEM= %d\n", 2 * N - 8);
        for (int i = 0; i < N - 4; i++)
            builder_text(&b, "10 %d %d %d %d %d\n%s", i, i + 1, i + 2, i + 3, 1000000 + i,
                         with_comment && i == N / 2 ? "% 10 1 2 3 4 5\n" : "");
        for (int i = 0; i < N - 4; i++)
            builder_text(&b, "14 %d %d %d %d %d\n", i, i + 1, i + 2, i + 3, i + 4);
        builder_expect_same_on_threads(&b, &io_format_su2);
        planish_file *file;
        planish_error error;
        assert_int_equal(builder_read(&b, &io_format_su2, 3, &file, &error), 0);
        assert_int_equal(planish_file_mesh(file).n_elements, 2 * N - 8);
        assert_true(planish_file_mesh(file).coordinates[3 * (N - 1)] == (N - 1) / 2);
        planish_file_close(file);
        builder_release(&b);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_solid_is_read),
        cmocka_unit_test(a_plane_is_read),
        cmocka_unit_test(elements_of_every_type_are_read),
        cmocka_unit_test(zones_are_regions),
        cmocka_unit_test(markers_of_quadrilaterals),
        cmocka_unit_test(wrong_files_are_refused),
        cmocka_unit_test(files_are_told),
        cmocka_unit_test(files_are_cut_anywhere),
        cmocka_unit_test(nothing_but_coordinates_changes),
        cmocka_unit_test(threads_read_the_same),
    };
    return cmocka_run_group_tests(tests, test_folder_create, test_folder_remove);
}
