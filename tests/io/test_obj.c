/* OBJ: what is read, what is held, what is refused, what is written. */
#include "support/file_builder.h"
#include "support/files.h"
#include "support/reading.h"
#include "support/rewriting.h"
#include "support/unit_elements.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define SQUARE "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"

/* Triangles, a quadrilateral, a pentagon, lines and points, in all notations. */
static const char mixed[] =
    "# a comment\nmtllib a.mtl\no thing of two words\nv 0 0 0 # here\nv 1 0 0 1.0\n  v 1 1.50 0 "
    "0.5 0.5 0.5\n"
    "v 0 \\\n 1\t0\r\nvt 0 0\nvn 0 0 1\ng left  right\nf 1/1/1 2/1/1 3/1/1\nf 1//1 3//1 -1//-1\n"
    "v 3 3 0\nv 4 3 0\nv 4 4 0\nv 3 4 0\nusemtl a material\nf -4 -3 -2 -1\n"
    "g\nv 6 6 0\nv 7 6 0\nv 7 7 0\nv 6.5 8 0\nv 6 7 0\nf 9 10 11 12 13\n"
    "v 9 9 0\nv 9 8 0\nl 1 5/1 14\np 15\ns off\n# the end";

static void a_file_is_read(void **state) {
    static const int32_t nodes[] = {0, 1, 2, 0, 2, 3, 4, 5, 6, 7};
    static const uint8_t hold[] = {IO_HELD_BY_LINE,
                                   0,
                                   0,
                                   0,
                                   IO_HELD_BY_LINE,
                                   0,
                                   0,
                                   0,
                                   IO_HELD_BY_OTHER,
                                   IO_HELD_BY_OTHER,
                                   IO_HELD_BY_OTHER,
                                   IO_HELD_BY_OTHER,
                                   IO_HELD_BY_OTHER,
                                   IO_HELD_BY_LINE,
                                   IO_HELD_BY_POINT};
    static const reading_facts facts = {.dim = 2,
                                        .n_nodes = 15,
                                        .n_elements = 3,
                                        .n_regions = 2,
                                        .n_other = 1,
                                        .n_lower = 3,
                                        .precision = PLANISH_PRECISION_DOUBLE};
    planish_file *file = reading_text(&io_format_obj, mixed);
    reading_gave(file, &io_format_obj, &facts);
    const planish_mesh mesh = planish_file_mesh(file);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_memory_equal(mesh.cells->node, nodes, sizeof nodes);
    assert_memory_equal(file->model.hold, hold, sizeof hold);
    assert_true(mesh.coordinates[5] == 1.5 && mesh.coordinates[7] == 1);
    assert_int_equal(info.has_normals, 1);
    assert_int_equal(planish_file_node_number(file, 4), 5);
    assert_int_equal(planish_file_element_number(file, 2), 3);
    unit_expect_held(file, "a material", "100011111111111");
    unit_expect_held(file, "right", "111111111111111");
    unit_expect_held(file, "thing of two words", "111111111111111");
    planish_file_close(file);
    rewriting_keeps_the_rest(&io_format_obj, mixed, sizeof mixed - 1, *state);
}

static void coordinates_alone_are_written(void **state) {
    rewriting_gives(&io_format_obj, "v  0\t0 0.0 1 0.5 0 0\r\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "xy",
                    "v  0.125\t-0.3333333333333333 0.0 1 0.5 0 0\r\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
                    *state);
}

static void many_groups_are_told_apart(void **state) {
    (void)state;
    enum { N = 300 };
    file_builder b = {0};
    planish_error error;
    builder_text(&b, SQUARE);
    for (int i = 0; i < N; i++)
        builder_text(&b, "v %d 2 0\nv %d.5 2 0\nv %d 3 0\ng group%d all\nf -3 -2 -1\n", i, i, i,
                     i % 150);
    planish_file *file = builder_file(&b, &io_format_obj);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(info.n_regions, 150);
    uint8_t held[4 + 3 * N];
    const char *const tags[] = {"group149"};
    const planish_hold hold = {.tags = tags, .n_tags = 1};
    assert_int_equal(planish_file_get_held(file, &hold, held, &error), 0);
    for (int i = 4; i < 4 + 3 * N; i++)
        assert_int_equal(held[i] == PLANISH_FILE_FIX, (i - 4) / 3 % 150 == 149);
    planish_file_close(file);
    builder_release(&b);
}

static void wrong_files_are_refused(void **state) {
    (void)state;
    const io_format *f = &io_format_obj;
    reading_fails(f, SQUARE, "nothing to smooth");
    reading_fails(f, SQUARE "f 1 2 3 4 1\n", "nothing to smooth");
    reading_fails(f, SQUARE "f 1 2\n", "test:5: face 1: three vertices or more");
    reading_fails(f, SQUARE "f\n", "vertices expected");
    reading_fails(f, SQUARE "f 1 2 5\n", "test:5: there is no vertex 5: the file has 4");
    reading_fails(f, SQUARE "f 1 2 0\n", "no vertex 0");
    reading_fails(f,
                  "v 0 0 0\nv 1 0 0\nf -1 -2 -3\n"
                  "v 1 1 0\n",
                  "no vertex -3: the file has 3, 2 of them");
    reading_fails(f, SQUARE "f 1 2 99999999999999999999\n", "is not a vertex");
    reading_fails(f, SQUARE "f 1 2 x\n", "'x' is not a vertex");
    reading_fails(f, SQUARE "f 1 2 3/x\n", "'3/x' is not a vertex");
    reading_fails(f, "v 0 0\nv 1 0 0\n", "test:1: vertex 1: three coordinates");
    reading_fails(f, "v 0 0 0\nv 1 0 0x\n", "test:2: vertex 2");
    reading_fails(f, "v 0 0 0\nv 1 nan 0\n", "test:2: node 2 has a coordinate that is not finite");
    reading_fails(f, "v 0 0 0\nv 1 1e999 0\n", "not finite");
    reading_fails(f, SQUARE "surf 0 1 0 1 1 2 3\n",
                  "test:5: planish does not read curves and surfaces");
    reading_gives_surface(f, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n");
}

static void files_are_told(void **state) {
    (void)state;
    static const char *const yes[] = {mixed, "g a\nf 1 2 3\n"};
    static const char *const no[] = {"v 0 0\n", "# 1\n4 3 0 0\n", "x\nv 0 0 0\n"};
    reading_tells(&io_format_obj, yes, sizeof yes / sizeof *yes, 1);
    reading_tells(&io_format_obj, no, sizeof no / sizeof *no, 0);
}

static void files_are_cut_anywhere(void **state) {
    (void)state;
    file_builder b = builder_of(mixed);
    builder_try_to_break(&b, &io_format_obj);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_is_read),
        cmocka_unit_test(coordinates_alone_are_written),
        cmocka_unit_test(many_groups_are_told_apart),
        cmocka_unit_test(wrong_files_are_refused),
        cmocka_unit_test(files_are_told),
        cmocka_unit_test(files_are_cut_anywhere),
    };
    return cmocka_run_group_tests(tests, test_folder_create, test_folder_remove);
}
