/* STL: what is read, welded, held and refused; which normals are written anew. */
#include "io/core/binary.h"
#include "support/file_builder.h"
#include "support/files.h"
#include "support/reading.h"
#include "support/rewriting.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define FACET(normal, a, b, c)                                                                     \
    " facet normal " normal "\n  outer loop\n   vertex " a "\n   vertex " b "\n   vertex " c       \
    "\n  endloop\n endfacet\n"
#define SQUARE(normal)                                                                             \
    FACET(normal, "0 0 0", "1 0 0", "1 1.50 0")                                                    \
    FACET(normal, "0 0 -0", "1.0 1.5 0", "0 1 0")

static const char square[] = "solid a square\n" SQUARE("0 0 0") "endsolid a square\n";

static void a_file_is_read(void **state) {
    (void)state;
    static const int32_t elements[] = {0, 1, 2, 0, 2, 3};
    static const double places[] = {0, 0, 1, 0, 1, 1.5, 0, 1};
    static const reading_facts facts = {.dim = 2,
                                        .n_nodes = 4,
                                        .n_elements = 2,
                                        .n_regions = 1,
                                        .precision = PLANISH_PRECISION_DOUBLE};
    planish_file *file = reading_text(&io_format_stl, square);
    reading_gave(file, &io_format_stl, &facts);
    planish_mesh mesh = planish_file_mesh(file);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_memory_equal(mesh.elements, elements, sizeof elements);
    assert_memory_equal(mesh.coordinates, places, sizeof places);
    assert_int_equal(info.has_normals, 0); /* those of facets do not go stale */
    assert_int_equal(planish_file_element_number(file, 1), 2);
    planish_file_close(file);
    rewriting_keeps_the_rest(&io_format_stl, square, sizeof square - 1, *state);
}

static void solids_are_regions(void **state) {
    static const char text[] =
        "SOLID a b\n" FACET("0 0 0", "0 0 0", "1 0 0",
                            "1 1 0") "ENDSOLID a b\n"
                                     "solid\n" FACET("0 0 0", "0 0 0", "1 1 0", "0 1 0")
                                         FACET("0 0 0", "5 5 0", "5 5 0", "6 6 0") "endsolid";
    uint8_t held[6];
    planish_error error;
    const char *const tags[] = {"a b"};
    const planish_hold hold = {.tags = tags, .n_tags = 1};
    planish_file *file = reading_text(&io_format_stl, text);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(info.n_regions, 2);
    assert_int_equal(info.n_other_elements, 1); /* the facet of two equal points */
    assert_int_equal(planish_file_mesh(file).n_elements, 2);
    assert_int_equal(planish_file_mesh(file).n_nodes, 6);
    assert_int_equal(planish_file_get_held(file, &hold, held, &error), 0);
    assert_int_equal(held[1], PLANISH_FILE_FIX);
    assert_int_equal(held[2], PLANISH_FILE_FIX | PLANISH_FILE_INTERFACE);
    assert_int_equal(held[3], 0);
    assert_int_equal(held[4], PLANISH_FILE_OTHER_ELEMENT);
    planish_file_close(file);
    rewriting_keeps_the_rest(&io_format_stl, text, sizeof text - 1, *state);
}

/** Facets of a tilted plane; the first three have normals of different kinds, the last does not move. */
static void normals_of_moved_facets_are_renewed(void **state) {
    static const char text[] = "solid\n" FACET("5 0 0", "0 0 0", "1 0 0", "0 1 0")
        FACET("nan nan nan", "0 0 0", "0 1 0", "-1 0 0")
            FACET("0 0 -2", "0 0 0", "-1 0 0", "0 -1 0") FACET("0 0 0", "0 0 0", "0 -1 0", "1 0 0")
                FACET("7 7 7", "1 0 0", "2 0 0", "0 1 0")
                    FACET("0.0 0.0 1.0", "0 0 0", "0 -1 0", "1 0 0") "endsolid\n";
    static const char expected[] = "solid\n" FACET("0 0 1", "0.125 0 0", "1 0 0", "0 1 0")
        FACET("0 0 1", "0.125 0 0", "0 1 0", "-1 0 0")
            FACET("0 0 -1", "0.125 0 0", "-1 0 0", "0 -1 0")
                FACET("0 0 0", "0.125 0 0", "0 -1 0", "1 0 0")
                    FACET("7 7 7", "1 0 0", "2 0 0", "0 1 0")
                        FACET("0.0 0.0 1.0", "0.125 0 0", "0 -1 0", "1 0 0") "endsolid\n";
    rewriting_gives(&io_format_stl, text, "x", expected, *state);
}

/** Facets without normals stay so, and "end solid" ends a solid. */
static void files_of_other_programs_are_read(void **state) {
#define BARE(a, b, c)                                                                              \
    "facet\nouter loop\nvertex " a "\nvertex " b "\nvertex " c "\nendloop\nendfacet\n"
    static const char text[] = "solid x\n" BARE("0 0 0", "1 0 0", "0 1 0")
        FACET("0 0 2", "0 0 0", "0 1 0", "-1 0 0") "end solid\nsolid y\n" BARE(
            "0 0 0", "-1 0 0", "0 -1 0") BARE("0 0 0", "0 -1 0", "1 0 0") "endsolid\n";
    static const char expected[] = "solid x\n" BARE("0.125 0 0", "1 0 0", "0 1 0")
        FACET("0 0 1", "0.125 0 0", "0 1 0", "-1 0 0") "end solid\nsolid y\n" BARE(
            "0.125 0 0", "-1 0 0", "0 -1 0") BARE("0.125 0 0", "0 -1 0", "1 0 0") "endsolid\n";
    rewriting_gives(&io_format_stl, text, "x", expected, *state);
#undef BARE
}

static void wrong_files_are_refused(void **state) {
    (void)state;
    const io_format *f = &io_format_stl;
    reading_fails(
        f,
        "solid\nfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 endloop endfacet\n"
        "endsolid\n",
        "test:2: facet 1: 'vertex' expected, not 'endloop'");
    reading_fails(f, "solid\nfacet 0 0 1\n", "facet 1: 'outer' expected, not '0'");
    reading_fails(f, "solid\nend facet\n", "'facet' or 'endsolid' expected, not 'end'");
    reading_fails(f, "solid\nvertex 0 0 1\n", "'facet' or 'endsolid' expected, not 'vertex'");
    reading_fails(f, "solid\n" SQUARE("0 0 1"), "cut short");
    reading_fails(f, "solid\n" SQUARE("0 0 1") "endsolid\nx\n", "test:17: 'solid' or the end");
    reading_fails(f, "solid\n" FACET("0 0 1", "0 0 0", "1 x 0", "1 1 0") "endsolid", "test:5");
    reading_fails(f, "solid\n" FACET("0 0 1", "0 0 0", "1 nan 0", "1 1 0") "endsolid",
                  "not finite");
    reading_fails(f, "solid\n" FACET("0 0 1", "0 0 0", "1 1e999 0", "1 1 0") "endsolid",
                  "not finite");
    reading_fails(f, "solid\n" FACET("0 0 1", "0 0 0", "1 0 0", "1 0 0") "endsolid",
                  "nothing to smooth");
    reading_fails(f, "solid\nendsolid\n", "nothing to smooth");
    reading_gives_surface(f, "solid\n" SQUARE("0 0 0")
                                 FACET("0 0 0", "0 0 1", "1 0 0", "0 1 2") "endsolid");
    reading_fails(f, "OFF\n", "neither 'solid'");
    assert_true(f->recognise(square, sizeof square - 1));
    assert_true(f->recognise("solid\nendsolid", 14));
    assert_false(f->recognise("solid\nvertex", 12));
    assert_false(f->recognise("solids\nfacet", 12));
}

/** Two facets with colours behind a header that looks like text. */
static void build_binary(file_builder *b, int64_t count, const char *header) {
    static const float facets[][12] = {{0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 1, 0},
                                       {0, 0, 1, 0, 0, 0, 1, 1, 0, 0, 0.1f, 0}};
    *b = (file_builder){.binary = 1, .swapped = !io_machine_is_little()};
    builder_text(b, "%-80s", header);
    builder_integer(b, count, 4);
    for (int i = 0; i < 2; i++) {
        for (int k = 0; k < 12; k++)
            builder_real(b, facets[i][k], 4);
        builder_integer(b, 0x1234 + i, 2);
    }
}

static void binary_files_are_read_and_written(void **state) {
    static const int32_t elements[] = {0, 1, 2, 0, 2, 3};
    static const char *const headers[] = {"solid of bytes", "COLOR=abcd", ""};
    for (size_t i = 0; i < sizeof headers / sizeof *headers; i++) {
        file_builder b;
        planish_error error;
        build_binary(&b, 2, headers[i]);
        assert_true(io_format_stl.recognise(b.data, b.size));
        planish_file *file = builder_file(&b, &io_format_stl);
        const planish_mesh mesh = planish_file_mesh(file);
        planish_file_info info;
        planish_file_get_info(file, &info);
        assert_int_equal(info.precision, PLANISH_PRECISION_FLOAT);
        assert_int_equal(mesh.n_nodes, 4);
        assert_memory_equal(mesh.elements, elements, sizeof elements);
        assert_true(mesh.coordinates[7] == (double)0.1f);
        planish_file_close(file);
        builder_try_to_break(&b, &io_format_stl);
        for (int k = 0; k < 2; k++) /* normals that stay */
            memset(b.data + 84 + 50 * k, 0, 12);
        rewriting_keeps_the_rest(&io_format_stl, b.data, b.size, *state);
        for (b.size--; b.size > 0; b.size--) {
            assert_true(builder_read(&b, &io_format_stl, 1, &file, &error) < 0);
            assert_false(io_format_stl.recognise(b.data, b.size));
        }
        builder_release(&b);
    }
}

static void counts_of_binary_files_must_be_true(void **state) {
    (void)state;
    static const struct {
        int64_t count;
        const char *word;
    } cases[] = {{3, "3 facets cannot be in the 100 bytes"},
                 {1, "has room for 2; the count is wrong"},
                 {0, "has room for 2"},
                 {-1, "4294967295 facets cannot"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        file_builder b;
        build_binary(&b, cases[i].count, "binary");
        builder_expect_error(&b, &io_format_stl, cases[i].word);
        builder_release(&b);
    }
    file_builder b;
    build_binary(&b, 2, "binary");
    memset(b.data + 84 + 12, 0xff, 4);
    builder_expect_error(&b, &io_format_stl, "byte 96: node 1 has a coordinate that is not finite");
    builder_release(&b);
}

/** Both facets of a square in a tilted plane turn about its diagonal's end. */
static void normals_are_unit_vectors_in_space(void **state) {
    file_builder b = {.binary = 1, .swapped = !io_machine_is_little()};
    static const float square_in_space[2][9] = {{0, 0, 0, 4, 0, 3, 4, 5, 3},
                                                {0, 0, 0, 4, 5, 3, 0, 5, 0}};
    planish_error error;
    planish_file *file, *again;
    char path[TEST_PATH_SIZE];
    builder_text(&b, "%-80s", "binary");
    builder_integer(&b, 2, 4);
    for (int i = 0; i < 2; i++) {
        for (int d = 0; d < 3; d++)
            builder_real(&b, d, 4);
        for (int k = 0; k < 9; k++)
            builder_real(&b, square_in_space[i][k], 4);
        builder_integer(&b, 7, 2);
    }
    test_write(*state, "tilted.stl", b.data, (size_t)b.size);
    assert_int_equal(
        planish_file_open(test_path(path, *state, "tilted.stl"), NULL, 1, &file, &error), 0);
    double *x = planish_file_coordinates(file);
    x[2 * 3] += 0.5; /* the last point: of the second facet alone */
    assert_int_equal(
        planish_file_write(file, path, x, &(planish_write_options){.threads = 1}, &error), 0);
    size_t size;
    char *written = test_read(path, &size);
    assert_int_equal(size, b.size);
    assert_memory_equal(written, b.data, 84 + 50);
    assert_memory_equal(written + 84 + 50 + 48, b.data + 84 + 50 + 48, 2);
    float normal[3];
    memcpy(normal, written + 84 + 50, sizeof normal);
    assert_true(fabsf(normal[0] + 0.6f) < 1e-6f && fabsf(normal[1]) < 1e-6f &&
                fabsf(normal[2] - 0.8f) < 1e-6f);
    assert_int_equal(planish_file_open(path, NULL, 1, &again, &error), 0);
    assert_int_equal(planish_file_mesh(again).n_nodes, 4);
    free(written);
    planish_file_close(again);
    planish_file_close(file);
    builder_release(&b);
}

static void files_are_cut_anywhere(void **state) {
    (void)state;
    file_builder b = builder_of(square);
    builder_try_to_break(&b, &io_format_stl);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_is_read),
        cmocka_unit_test(solids_are_regions),
        cmocka_unit_test(normals_of_moved_facets_are_renewed),
        cmocka_unit_test(normals_are_unit_vectors_in_space),
        cmocka_unit_test(files_of_other_programs_are_read),
        cmocka_unit_test(wrong_files_are_refused),
        cmocka_unit_test(binary_files_are_read_and_written),
        cmocka_unit_test(counts_of_binary_files_must_be_true),
        cmocka_unit_test(files_are_cut_anywhere),
    };
    return cmocka_run_group_tests(tests, test_folder_create, test_folder_remove);
}
