/* PLY: what is read, what is held, what is refused, what is written. */
#include "io/core/binary.h"
#include "support/file_builder.h"
#include "support/files.h"
#include "support/reading.h"
#include "support/rewriting.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

/** A file of ten vertices with all kinds of properties. */
typedef struct kind {
    const char *format;
    int is_apart;     /* other properties stand between coordinates, */
    int has_list;     /* a list among them */
    int faces_first;  /* faces stand before vertices */
    const char *real; /* type of coordinates */
} kind;

static void build_vertices(file_builder *b, const kind *k) {
    static const double xy[] = {0, 0, 1, 0, 1, 1.5, 0, 1, 3, 3, 4, 3, 4, 4, 0.1, 4, 5, 5, 0.5, 0.5};
    const int size = strcmp(k->real, "float") == 0 ? 4 : 8;
    for (int i = 0; i < 10; i++) {
        builder_integer(b, i, 1);
        builder_real(b, xy[2 * i], size);
        if (k->is_apart)
            builder_integer(b, 300 + i, 2);
        builder_real(b, xy[2 * i + 1], size);
        if (k->has_list) {
            builder_integer(b, i % 3, 1);
            for (int j = 0; j < i % 3; j++)
                builder_integer(b, -j, 4);
        }
        builder_real(b, 0, size);
        builder_real(b, 1, 4);
        builder_line(b);
    }
}

/** Two triangles, a line, a quadrilateral, a pentagon and a point, each with a colour. */
static void build_faces(file_builder *b) {
    static const int faces[] = {3, 0, 1, 9, 2, 0, 1, 4, 4, 5, 6, 7,
                                3, 1, 2, 9, 5, 4, 5, 6, 7, 8, 1, 8};
    for (size_t i = 0; i < sizeof faces / sizeof *faces; i += (size_t)faces[i] + 1) {
        builder_integer(b, 255, 1);
        builder_integer(b, faces[i], 1);
        for (int k = 1; k <= faces[i]; k++)
            builder_integer(b, faces[i + (size_t)k], 2);
        builder_line(b);
    }
}

static void build(file_builder *b, const kind *k) {
    const int is_binary = strcmp(k->format, "ascii") != 0;
    const int is_little = strcmp(k->format, "binary_little_endian") == 0;
    *b = (file_builder){.binary = is_binary, .swapped = is_little != io_machine_is_little()};
    builder_text(b, "ply\nformat %s 1.0\ncomment element face 7\nobj_info none\n", k->format);
    for (int pass = 0; pass < 2; pass++) {
        if (pass == k->faces_first) {
            builder_text(b, "element vertex 10\nproperty uint8 flag\nproperty %s x\n", k->real);
            builder_text(b, "%s", k->is_apart ? "property ushort label\n" : "");
            builder_text(b, "property %s y\n%s", k->real,
                         k->has_list ? "property list uchar int data\n" : "");
            builder_text(b, "property %s z\nproperty float nx\n", k->real);
        } else {
            builder_text(
                b, "element face 6\nproperty uchar red\nproperty list char int16 vertex_indices\n");
        }
    }
    builder_text(
        b,
        "element extra 2\nproperty float64 a\nproperty list uint uint8 b\n"
        "element edge 1\nproperty int vertex1\nproperty int vertex2\nelement none 5\nend_header\n");
    for (int pass = 0; pass < 2; pass++)
        if (pass == k->faces_first)
            build_vertices(b, k);
        else
            build_faces(b);
    for (int i = 0; i < 2; i++) {
        builder_real(b, 0.5, 8);
        builder_integer(b, 2, 4);
        builder_integer(b, 1, 1);
        builder_integer(b, 2, 1);
        builder_line(b);
    }
    builder_integer(b, 2, 4);
    builder_integer(b, 3, 4);
    builder_line(b);
}

static void files_of_every_kind(void **state) {
    static const char *const formats[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    static const int32_t nodes[] = {0, 1, 9, 1, 2, 9, 4, 5, 6, 7};
    static const uint8_t hold[] = {IO_HELD_BY_LINE,
                                   IO_HELD_BY_LINE,
                                   IO_HELD_BY_LINE,
                                   IO_HELD_BY_LINE,
                                   IO_HELD_BY_OTHER,
                                   IO_HELD_BY_OTHER,
                                   IO_HELD_BY_OTHER,
                                   IO_HELD_BY_OTHER,
                                   IO_HELD_BY_OTHER | IO_HELD_BY_POINT,
                                   0};
    for (int i = 0; i < 3 * 16; i++) {
        const kind k = {formats[i % 3], i / 3 & 1, i / 6 & 1, i / 12 & 1,
                        i / 24 & 1 ? "float" : "double"};
        const int is_float = i / 24 & 1;
        file_builder b;
        planish_error error = {.text = ""};
        build(&b, &k);
        assert_true(io_format_ply.recognise(b.data, b.size));
        planish_file *file = builder_file(&b, &io_format_ply);
        const planish_mesh mesh = planish_file_mesh(file);
        planish_file_info info;
        planish_file_get_info(file, &info);
        assert_int_equal(info.precision,
                         is_float ? PLANISH_PRECISION_FLOAT : PLANISH_PRECISION_DOUBLE);
        assert_int_equal(info.has_normals, 1);
        assert_int_equal(info.n_other_elements, 1);
        assert_int_equal(info.n_lower_elements, 3);
        assert_int_equal(mesh.n_nodes, 10);
        assert_int_equal(mesh.n_elements, 3);
        assert_memory_equal(mesh.cells->node, nodes, sizeof nodes);
        assert_memory_equal(file->model.hold, hold, sizeof hold);
        assert_int_equal(planish_file_element_number(file, 1), 3);
        assert_true(mesh.coordinates[14] == (is_float ? (double)0.1f : 0.1));
        planish_file_close(file);
        builder_try_to_break(&b, &io_format_ply);
        rewriting_keeps_the_rest(&io_format_ply, b.data, b.size, *state);
        for (b.size -= k.format[0] == 'a' ? 3 : 1; b.size > 0; b.size--)
            assert_true(builder_read(&b, &io_format_ply, 1, &file, &error) < 0);
        builder_release(&b);
    }
}

#define HEAD(n, m)                                                                                 \
    "ply\nformat ascii 1.0\nelement vertex " n "\nproperty double x\nproperty double y\n"          \
    "property double z\nelement face " m "\nproperty list uchar int vertex_index\nend_header\n"
#define SQUARE "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"
#define VERTICES(x, y, z)                                                                          \
    "ply\nformat ascii 1.0\nelement vertex 1\nproperty " x "\nproperty " y "\nproperty " z         \
    "\nend_header\n0 0 0\n"

static void coordinates_alone_are_written(void **state) {
    rewriting_gives(&io_format_ply,
                    HEAD("4", "2") "0  0 0.0\r\n"
                                   "1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n",
                    "y",
                    HEAD("4", "2") "0  -0.3333333333333333 0.0\r\n"
                                   "1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n",
                    *state);
}

static void wrong_files_are_refused(void **state) {
    (void)state;
    static const reading_refusal cases[] = {
        {"OFF\n", "no 'ply'"},
        {"ply\nelement vertex 1\n", "test:2: 'format ascii 1.0'"},
        {"ply\nformat ascii 2.0\n", "'format ascii 1.0'"},
        {"ply\nformat binary 1.0\n", "binary format expected"},
        {"ply\nformat ascii 1.0\nproperty int x\n", "of no element"},
        {"ply\nformat ascii 1.0\nelement vertex -1\n", "a number of elements"},
        {"ply\nformat ascii 1.0\nelement vertex 99999999999999999999\n", "a number of elements"},
        {"ply\nformat ascii 1.0\nelement vertex\n", "a number of elements"},
        {"ply\nformat ascii 1.0\nelement vertex 1\nelement vertex 1\n", "twice"},
        {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float x\n", "twice"},
        {"ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\n", "a known type"},
        {"ply\nformat ascii 1.0\nelement face 1\nproperty list float int vertex_indices\n",
         "a known type"},
        {"ply\nformat ascii 1.0\nelement face 1\nproperty list int float vertex_indices\n",
         "an integer type"},
        {"ply\nformat ascii 1.0\nelement tristrips 1\n", "strips"},
        {"ply\nformat ascii 1.0\nvertex 3\n", "test:3: 'element', 'property' or 'end_header'"},
        {"ply\nformat ascii 1.0\nelement vertex 1\n", "no end_header"},
        {"ply\nformat ascii 1.0\nend_header\n", "no 'element vertex'"},
        {"ply\nformat ascii 1.0\nelement vertex 1\nelement face 1\nproperty int a\nend_header\n",
         "a list vertex_indices"},
        {VERTICES("float y", "float x", "float z"), "in this order"},
        {VERTICES("float x", "float y", "float w"), "x, y and z"},
        {VERTICES("int x", "int y", "int z"), "one type, float or double"},
        {VERTICES("float x", "float y", "double z"), "one type"},
        {VERTICES("float x", "float y", "float z"), "nothing to smooth"},
        {HEAD("4", "1") SQUARE "3 0 1 4\n", "test:14: face 0: there is no node 4"},
        {HEAD("4", "1") SQUARE "3 0 1 -1\n", "there is no node -1"},
        {HEAD("4", "1") SQUARE "3 0 1\n", "test:15: face 0: its numbers are missing"},
        {HEAD("4", "1") SQUARE "-3 0 1 2\n", "a list of -3 numbers"},
        {HEAD("4", "1") SQUARE "999 0 1 2\n", "a list of 999 numbers"},
        {HEAD("4", "1") SQUARE "3 0 1 2\n3 0 2 3\n", "test:15: more follows"},
        {HEAD("4", "9") SQUARE "3 0 1 2\n", "cannot be in"},
        {HEAD("9", "1") SQUARE "3 0 1 2\n", "cannot be in"},
        {HEAD("4000000000000000000", "1") SQUARE, "cannot be in"},
        {HEAD("4", "1") "0 0 0\n1 nan 0\n1 1 0\n0 1 0\n3 0 1 2\n", "test:11: node 1 has"},
        {HEAD("4", "1") "0 0 0\n1 1e999 0\n1 1 0\n0 1 0\n3 0 1 2\n", "not finite"},
        {HEAD("4", "1") "0 0 0\n1 x 0\n1 1 0\n0 1 0\n3 0 1 2\n", "vertex 1: coordinate expected"},
    };
    reading_refuses(&io_format_ply, cases, sizeof cases / sizeof *cases);
    reading_gives_surface(&io_format_ply, HEAD("4", "2") "0 0 0\n1 1 1\n1 1 0\n0 1 0\n"
                                                         "3 0 1 2\n3 0 2 3\n");
    assert_true(io_format_ply.recognise("ply\r\nformat", 11));
    assert_false(io_format_ply.recognise("plywood\n", 8));
}

/** Numbers of a binary file that cannot be. */
static void binary_values_that_cannot_be(void **state) {
    (void)state;
    const kind k = {"binary_little_endian", 0, 0, 0, "float"};
    static const struct {
        int from_end; /* of the file */
        unsigned char byte;
        const char *word;
    } cases[] = {{1, 0x7f, "edge 0: there is no node 2130706435"}, /* of the second end */
                 {8, 0xff, "edge 0"},
                 {8 + 6, 0x7f, "extra 1: a list of"}, /* length of the last list */
                 {8 + 28 + 2, 0xff, "face 5: there is no node 255"},
                 {8 + 28 + 4 + 11, 0x80, "face 4: a list of -128 numbers"},
                 {8 + 28 + 4 + 11, 0x7f, "face 4: a list of 127 numbers"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        file_builder b;
        build(&b, &k);
        b.data[b.size - cases[i].from_end] = (char)cases[i].byte;
        builder_expect_error(&b, &io_format_ply, cases[i].word);
        builder_release(&b);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_of_every_kind),
        cmocka_unit_test(coordinates_alone_are_written),
        cmocka_unit_test(wrong_files_are_refused),
        cmocka_unit_test(binary_values_that_cannot_be),
    };
    return cmocka_run_group_tests(tests, test_folder_create, test_folder_remove);
}
