/* Tests of the reader of VTK's XML files: the same small mesh in every encoding, written back, and
 * files that lie. */
#include <inttypes.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/base64.h"
#include "io/vtk/vtk_base64.h"
#include "io/core/binary.h"
#include "io/vtk/compression.h"
#include "support/file_builder.h"
#include "support/files.h"
#include "support/reading.h"
#include "support/vtu_builder.h"

/* ---- the mesh ------------------------------------------------------------------------------ */

static void expect_mesh(const planish_file *file, const variant *v) {
    static const int64_t numbers[4] = {1, 3, 4, 5};
    const io_model *model = &file->model;
    assert_int_equal(model->dim, 3);
    assert_int_equal(model->n_nodes, N_NODES);
    assert_int_equal(model->precision,
                     v->is_float ? PLANISH_PRECISION_FLOAT : PLANISH_PRECISION_DOUBLE);
    assert_int_equal(model->tetrahedron.n, 4);
    assert_int_equal(model->triangle.n, 1);
    assert_int_equal(model->line.n, 1);
    for (int i = 0; i < 4; i++) {
        const int cell = (int)numbers[i];
        assert_memory_equal(&model->tetrahedron.nodes[4 * i], vtu_cells[cell], sizeof vtu_cells[0]);
        assert_int_equal(planish_file_element_number(file, i), cell);
        assert_int_equal(model->entity[model->tetrahedron.entity[i]].tag, vtu_regions[cell]);
    }
    assert_int_equal(model->entity[model->triangle.entity[0]].tag, vtu_regions[2]);
    for (int k = 0; k < N_NODES; k++)
        assert_int_equal((model->hold[k] & IO_HELD_MARKED) != 0, k == 3);
}

static void expect_points(const planish_file *file, const double *expected) {
    for (int i = 0; i < 3 * N_NODES; i++)
        assert_true(file->model.coordinates[i] == expected[i]);
}

static void stored_points(const variant *v, double scale, double out[3 * N_NODES]) {
    for (int i = 0; i < 3 * N_NODES; i++) {
        const double value = vtu_points[i / 3][i % 3] * (i / 3 == 4 ? scale : 1);
        volatile float rounded = (float)value;
        out[i] = v->is_float ? (double)rounded : value;
    }
}

static void read_file(const file_builder *f, planish_file **file) {
    planish_error error = {0};
    if (builder_read(f, &io_format_vtu, 1, file, &error) != 0)
        fail_msg("%s", error.text);
}

/** Call visit for every way to write the file. */
static void each_variant(void (*visit)(const variant *v, void *context), void *context) {
    static const io_compression packers[] = {IO_PLAIN, IO_ZLIB, IO_LZ4, IO_LZMA};
    for (int how = ASCII; how <= APPENDED_BASE64; how++)
        for (int bits = 0; bits < (how == ASCII ? 2 : 8); bits++)
            for (int p = 0; p < (how == ASCII ? 1 : 4); p++)
                for (int keys = 0; keys < (how < APPENDED_RAW ? 3 : 1); keys++) {
                    const variant v = {(form)how, bits & 1,   bits & 2 ? 8 : 4,
                                       bits >> 2, packers[p], bits & 1 ? 20 : 48,
                                       keys,      0,          0};
                    if (io_compression_is_built(v.compression))
                        visit(&v, context);
                }
}

static void read_one(const variant *v, void *context) {
    double expected[3 * N_NODES];
    planish_file *file;
    file_builder f = vtu_make_file(v);
    ++*(int *)context;
    assert_true(io_format_vtu.recognise(f.data, f.size));
    stored_points(v, 1, expected);
    read_file(&f, &file);
    expect_mesh(file, v);
    expect_points(file, expected);
    planish_file_close(file);
    builder_expect_same_on_threads(&f, &io_format_vtu);
    builder_release(&f);
}

static void every_encoding_is_read(void **state) {
    int n = 0;
    (void)state;
    each_variant(read_one, &n);
    assert_true(n > 30);
}

/** The same bytes if nothing moved; else a file that differs in the points alone. */
static void write_one(const variant *v, void *context) {
    char path[TEST_PATH_SIZE];
    double moved[3 * N_NODES];
    size_t size;
    planish_file *file, *again;
    planish_error error = {.text = ""};
    file_builder f = vtu_make_file(v);
    read_file(&f, &file);
    test_path(path, context, "out.vtu");
    assert_int_equal(planish_file_write(file, path, planish_file_coordinates(file),
                                        &(planish_write_options){.threads = 2}, NULL),
                     0);
    char *same = test_read(path, &size);
    assert_int_equal(size, f.size);
    assert_memory_equal(same, f.data, size);
    free(same);
    stored_points(v, 1.0 / 3, moved);
    assert_int_equal(
        planish_file_write(file, path, moved, &(planish_write_options){.threads = 2}, NULL), 0);
    if (planish_file_open(path, NULL, 1, &again, &error))
        fail_msg("%s", error.text);
    expect_mesh(again, v);
    expect_points(again, moved);
    /* And back: the points' blocks are packed as before, so that these are the first bytes. */
    stored_points(v, 1, moved);
    assert_int_equal(
        planish_file_write(again, path, moved, &(planish_write_options){.threads = 1}, NULL), 0);
    char *back = test_read(path, &size);
    if (v->form != ASCII) { /* of numbers there are more texts than one */
        assert_int_equal(size, f.size);
        assert_memory_equal(back, f.data, size);
    }
    free(back);
    planish_file_close(again);
    planish_file_close(file);
    builder_release(&f);
}

static void every_encoding_is_written(void **state) {
    each_variant(write_one, *state);
}

static void break_one(const variant *v, void *context) {
    (void)context;
    if (v->header_size == 8 && !v->is_big && v->is_float && v->keys == 0) {
        file_builder f = vtu_make_file(v);
        builder_try_to_break(&f, &io_format_vtu);
        builder_release(&f);
    }
}

static void cut_short_or_without_memory(void **state) {
    (void)state;
    each_variant(break_one, NULL);
}

static void read_surplus(const variant *v, void *context) {
    variant with = *v;
    with.surplus = 1 + v->is_big;
    read_one(&with, context);
}

static void write_surplus(const variant *v, void *context) {
    variant with = *v;
    with.surplus = 1 + v->is_big;
    write_one(&with, context);
}

static void break_surplus(const variant *v, void *context) {
    variant with = *v;
    with.surplus = 2;
    if (v->compression <= IO_ZLIB)
        break_one(&with, context);
}

/** Of arrays that are longer than they need be VTK reads the beginning; the rest stays. */
static void surplus_stays(void **state) {
    int n = 0;
    each_variant(read_surplus, &n);
    each_variant(write_surplus, *state);
    each_variant(break_surplus, NULL);
}

/* ---- several pieces ------------------------------------------------------------------------ */

#define GRID(attributes)     "<VTKFile type=\"UnstructuredGrid\"" attributes "><UnstructuredGrid>"
#define PIECE(points, cells) "<Piece NumberOfPoints=\"" points "\" NumberOfCells=\"" cells "\">"
#define END                  "</Piece></UnstructuredGrid></VTKFile>"
#define ARRAY(type, name, text)                                                                    \
    "<DataArray type=\"" type "\" Name=\"" name "\" format=\"ascii\">" text "</DataArray>"
#define POINTS(text)                                                                               \
    "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">" text          \
    "</DataArray></Points>"
#define CELLS(connectivity, offsets, types)                                                        \
    "<Cells>" ARRAY("Int32", "connectivity", connectivity) ARRAY("Int32", "offsets", offsets)      \
        ARRAY("UInt8", "types", types) "</Cells>"
#define ARRAY_AT(type, name, offset)                                                               \
    "<DataArray type=\"" type "\" Name=\"" name "\" format=\"appended\" offset=\"" offset "\"/>"
#define TRIANGLE POINTS("0 0 0 1 0 0 0 1 0") CELLS("0 1 2", "3", "5")

static void pieces_are_one_mesh(void **state) {
    static const int32_t expected[] = {0, 1, 2, 5, 3, 4};
    char path[TEST_PATH_SIZE];
    planish_file *file = reading_text(
        &io_format_vtu,
        GRID("") PIECE("3", "1") TRIANGLE "<CellData>" ARRAY("Int32", "region", "4")
            ARRAY("Int32", "material", "1") "</CellData></Piece>" PIECE("0", "0")
                POINTS("") "</Piece>" PIECE("3", "2") POINTS("2 0 0 3 0 0 2 1.5 0")
                    CELLS("0 1 2 0 1", "2 5", "3 5") "<CellData>" ARRAY("Int32", "material", "0 3")
                        ARRAY("Int32", "region", "6 5") "</CellData>" END);
    const io_model *model = &file->model;
    assert_int_equal(model->dim, 2);
    assert_int_equal(model->triangle.n, 2);
    assert_memory_equal(model->triangle.nodes, expected, sizeof expected);
    assert_int_equal(planish_file_element_number(file, 0), 0);
    assert_int_equal(planish_file_element_number(file, 1), 2);
    assert_int_equal(model->entity[model->triangle.entity[0]].tag, 4);
    assert_int_equal(model->entity[model->triangle.entity[1]].tag, 5);
    double *x = planish_file_coordinates(file);
    x[1] = 0.25;
    x[11] = 2.5;
    assert_int_equal(planish_file_write(file, test_path(path, *state, "out.vtu"), x,
                                        &(planish_write_options){.threads = 1}, NULL),
                     0);
    char *content = test_read(path, NULL);
    assert_non_null(strstr(content, ">0 0.25 0 1 0 0 0 1 0<"));
    assert_non_null(strstr(content, ">2 0 0 3 0 0 2 2.5 0<"));
    free(content);
    planish_file_close(file);
}

/** One piece has its points as bytes, one as text: the digits of the latter tell how exact they
 *  are. */
static void pieces_of_bytes_and_of_text(void **state) {
    (void)state;
    planish_file *file = reading_text(
        &io_format_vtu,
        GRID(" byte_order=\"LittleEndian\"") PIECE(
            "3", "1") "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" "
                      "format=\"binary\">SAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAPA/"
                      "AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA8D8AAAAAAAAAAA=="
                      "</DataArray></Points>" CELLS("0 1 2", "3", "5") "</Piece>" PIECE("3", "1")
                          POINTS("2 0 0 3 0 0 2.123456 1.5 0") CELLS("0 1 2", "3", "5") END);
    const double tolerance = planish_file_surface(file, NULL).tolerance;
    assert_true(tolerance > 0.99e-6 && tolerance < 1.01e-6);
    planish_file_close(file);
}

/** Blocks of any size, less than a number's even, and what is not packed beside. */
static void blocks_of_any_size(void **state) {
    for (int block = 1; block <= 30; block += block < 9 ? 1 : 7) {
        variant v = {APPENDED_RAW, 0, 4, 0, IO_ZLIB, block, 0, 0, 0};
        if (io_compression_is_built(IO_ZLIB))
            write_one(&v, *state);
    }
}

/** A last block that is whole may be told by its size, or 0: that stays. */
static void whole_blocks(void **state) {
    const int block = 3 * N_NODES * (int)sizeof(double) / 2;
    for (int tells = 0; tells < 2; tells++) {
        variant v = {APPENDED_RAW, 0, 4, 0, IO_ZLIB, block, 0, tells, 0};
        if (io_compression_is_built(IO_ZLIB))
            write_one(&v, *state);
    }
}

/** Packed points in their element, all else appended: offsets stay. */
static void points_in_the_element(void **state) {
    char path[TEST_PATH_SIZE];
    double moved[3 * N_NODES];
    array a[N_ARRAYS];
    planish_file *file;
    const variant v = {INLINE, 0, 8, 0, IO_ZLIB, 48, 0, 0, 0},
                  raw = {APPENDED_RAW, 0, 8, 0, IO_ZLIB, 48, 0, 0, 0};
    file_builder f = {0}, data = {0};
    if (!io_compression_is_built(IO_ZLIB))
        skip();
    vtu_make_arrays(&v, a);
    builder_text(&f, "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\" "
                     "header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">");
    builder_text(&f, "<UnstructuredGrid><Piece NumberOfPoints=\"%d\" NumberOfCells=\"%d\">",
                 N_NODES, N_CELLS);
    for (int i = 0; i < N_ARRAYS; i++) {
        builder_text(&f, "<%s><DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" ",
                     a[i].section, a[i].type, a[i].name, i == 1 ? 3 : 1);
        file_builder values = vtu_written(i == 1 ? &v : &raw, &a[i]);
        if (i == 1) {
            builder_text(&f, "format=\"binary\">");
            vtu_put_bytes(&f, values.data, values.size);
        } else {
            builder_text(&f, "format=\"appended\" offset=\"%" PRId64 "\">", data.size);
            vtu_put_bytes(&data, values.data, values.size);
        }
        builder_text(&f, "</DataArray></%s>", a[i].section);
        builder_release(&values);
    }
    builder_text(&f, "</Piece></UnstructuredGrid><AppendedData encoding=\"raw\">_");
    vtu_put_bytes(&f, data.data, data.size);
    builder_text(&f, "</AppendedData></VTKFile>");
    read_file(&f, &file);
    stored_points(&v, 1.0 / 7, moved);
    assert_int_equal(planish_file_write(file, test_path(path, *state, "out.vtu"), moved,
                                        &(planish_write_options){.threads = 1}, NULL),
                     0);
    planish_file_close(file);
    assert_int_equal(planish_file_open(path, NULL, 1, &file, NULL), 0);
    expect_mesh(file, &v);
    expect_points(file, moved);
    planish_file_close(file);
    builder_release(&data);
    builder_release(&f);
}

/** Two pieces of three appended points each, at those offsets. */
static file_builder appended_pieces(int64_t first, int64_t second, int size) {
    const int64_t offset[] = {first, second};
    file_builder f = {.swapped = !io_machine_is_little()};
    builder_text(&f, GRID(" header_type=\"UInt32\""));
    for (int i = 0; i < 2; i++) {
        builder_text(&f, PIECE("3", "1") "<Cells>");
        builder_text(&f, ARRAY("Int32", "connectivity", "0 1 2") ARRAY("Int32", "offsets", "3"));
        builder_text(&f, ARRAY("UInt8", "types", "5") "</Cells>");
        builder_text(&f,
                     "<Points><DataArray type=\"Float%d\" NumberOfComponents=\"3\" "
                     "format=\"appended\" offset=\"%" PRId64 "\"/></Points></Piece>",
                     8 * size, offset[i]);
    }
    builder_text(&f, "</UnstructuredGrid><AppendedData encoding=\"raw\">_");
    f.binary = 1;
    for (int i = 0; i < 2; i++) {
        builder_integer(&f, 9 * size, 4);
        for (int k = 0; k < 9; k++)
            builder_real(&f, k == 3 || k == 7 ? 1 + i : 0, size);
    }
    f.binary = 0;
    builder_text(&f, "</AppendedData></VTKFile>");
    return f;
}

/** Whatever order their points have in the file; not, if they share some. */
static void pieces_in_any_order(void **state) {
    for (int size = 4; size <= 8; size += 4) {
        char path[TEST_PATH_SIZE];
        planish_file *file;
        file_builder f = appended_pieces(4 + 9 * size, 0, size);
        read_file(&f, &file);
        double *x = planish_file_coordinates(file);
        assert_true(x[2] == 2 && x[5] == 2 && x[8] == 1);
        x[2] = 2.5;
        x[8] = 1.5;
        assert_int_equal(planish_file_write(file, test_path(path, *state, "out.vtu"), x,
                                            &(planish_write_options){.threads = 1}, NULL),
                         0);
        planish_file_close(file);
        assert_int_equal(planish_file_open(path, NULL, 1, &file, NULL), 0);
        x = planish_file_coordinates(file);
        assert_true(x[2] == 2.5 && x[5] == 2 && x[8] == 1.5);
        planish_file_close(file);
        builder_release(&f);
        f = appended_pieces(0, 0, size);
        builder_expect_error(&f, &io_format_vtu, "share bytes");
        builder_release(&f);
    }
}

static void empty_pieces_may_be_of_any_type(void **state) {
    (void)state;
    static const char empty[] = PIECE("0", "0") "<Points><DataArray type=\"Float32\" "
                                                "NumberOfComponents=\"3\"/></Points></Piece>";
    char text[1024];
    for (int last = 0; last < 2; last++) {
        snprintf(text, sizeof text,
                 GRID("") "%s" PIECE("3", "1") TRIANGLE "</Piece>%s"
                                                        "</UnstructuredGrid></VTKFile>",
                 last ? "" : empty, last ? empty : "");
        planish_file *file = reading_text(&io_format_vtu, text);
        assert_int_equal(file->model.precision, PLANISH_PRECISION_DOUBLE);
        assert_int_equal(file->model.triangle.n, 1);
        planish_file_close(file);
    }
}

/** Many pieces whose cells are the same appended bytes would be more than the file is. */
static void arrays_of_the_same_bytes_are_refused(void **state) {
    (void)state;
    enum { PIECES = 40, CELLS_OF_PIECE = 200 };
    file_builder f = {.swapped = !io_machine_is_little()};
    builder_text(&f, GRID(" header_type=\"UInt32\""));
    for (int i = 0; i < PIECES; i++) {
        builder_text(&f, PIECE("3", "200") POINTS("0 0 0 1 0 0 0 1 0") "<Cells>");
        builder_text(&f, ARRAY_AT("Int32", "connectivity", "0"));
        builder_text(&f, ARRAY_AT("Int32", "offsets", "2404"));
        builder_text(&f, ARRAY_AT("UInt8", "types", "3208") "</Cells></Piece>");
    }
    builder_text(&f, "</UnstructuredGrid><AppendedData encoding=\"raw\">_");
    f.binary = 1;
    builder_integer(&f, 3 * CELLS_OF_PIECE * 4, 4);
    for (int i = 0; i < 3 * CELLS_OF_PIECE; i++)
        builder_integer(&f, i % 3, 4);
    builder_integer(&f, CELLS_OF_PIECE * 4, 4);
    for (int i = 1; i <= CELLS_OF_PIECE; i++)
        builder_integer(&f, 3 * i, 4);
    builder_integer(&f, CELLS_OF_PIECE, 4);
    for (int i = 0; i < CELLS_OF_PIECE; i++)
        builder_integer(&f, 5, 1);
    builder_expect_error(&f, &io_format_vtu, "larger than the file");
    builder_release(&f);
}

/* ---- polyhedra ----------------------------------------------------------------------------- */

/* A triangle, a polyhedron, and a cell of a type that nobody knows. */
#define SOME_CELLS                                                                                 \
    GRID("")                                                                                       \
    PIECE("8", "3")                                                                                \
    POINTS("0 0 0 1 0 0 0 1 0 5 5 0 0 0 9 2 2 0 3 3 0 4 4 0")                                      \
    "<Cells>" ARRAY("Int32", "connectivity", "3 5 6 0 1 6 7") ARRAY("Int64", "offsets", "3 5 7")   \
        ARRAY("UInt8", "types", "7 42 200")
#define POLYHEDRON(faces, ends)                                                                    \
    SOME_CELLS ARRAY("Int64", "faces", faces) ARRAY("Int64", "faceoffsets", ends) "</Cells>"
#define TABLES(polyhedra, faces, ends, nodes)                                                      \
    SOME_CELLS ARRAY("Int64", "polyhedron_offsets", polyhedra)                                     \
        ARRAY("Int64", "polyhedron_to_faces", faces) ARRAY("Int64", "face_offsets", ends)          \
            ARRAY("Int64", "face_connectivity", nodes) "</Cells>"

/** Polyhedra and whatever else hold their nodes; a polygon of three nodes is a triangle. */
static void other_cells_hold_their_nodes(void **state) {
    (void)state;
    static const struct {
        const char *text, *held;
    } cases[] = {
        {SOME_CELLS "</Cells>" END, "11000011"},
        {POLYHEDRON("3 3 0 1 2 3 0 1 4 3 1 2 4", "-1 13 -1") END, "11101011"},
        {POLYHEDRON("0", "-1 1 -1") END, "11000011"},
        {TABLES("0 3 3", "0 1 2", "3 6 9", "0 1 2 0 1 4 1 2 4") END, "11101011"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        planish_file *file = reading_text(&io_format_vtu, cases[i].text);
        static const int32_t triangle[] = {3, 5, 6};
        assert_int_equal(file->model.triangle.n, 1);
        assert_memory_equal(file->model.triangle.nodes, triangle, sizeof triangle);
        assert_int_equal(file->model.n_other, 2);
        for (int k = 0; k < 8; k++)
            assert_int_equal(file->model.hold[k], cases[i].held[k] == '1' ? IO_HELD_BY_OTHER : 0);
        planish_file_close(file);
    }
}

/* ---- bad files ----------------------------------------------------------------------------- */

static void what_is_wrong_is_said(void **state) {
    (void)state;
    static const struct {
        const char *text, *word;
    } bad[] = {
        {"<VTKFile type=\"PolyData\"><PolyData/></VTKFile>", "test:1: type is not Unstruct"},
        {"<!DOCTYPE a [<!ENTITY b \"c\"><!ENTITY d \"&b;&b;\">]><VTKFile/>", "document type"},
        {"<other/>", "VTKFile expected"},
        {"<VTKFile", "test:1: XML: "},
        {GRID(" byte_order=\"Middle\""), "byte_order must be"},
        {GRID(" header_type=\"UInt16\""), "header_type"},
        {GRID(" compressor=\"vtkOther\""), "this compressor is unknown"},
        {"<VTKFile type=\"UnstructuredGrid\"></VTKFile>", "no UnstructuredGrid"},
        {"<VTKFile type=\"UnstructuredGrid\">\n<UnstructuredGrid>\n</VTKFile>",
         "test:3: XML: mismatched tag"},
        {GRID("") "</UnstructuredGrid></VTKFile>", "no Piece"},
        {GRID("") PIECE("-1", "1") TRIANGLE END, "NumberOfPoints"},
        {GRID("") PIECE("3000000000", "1") TRIANGLE END, "below 2^31"},
        {GRID("") PIECE("2000000000", "1") TRIANGLE END, "2000000000 points cannot be"},
        {GRID("") PIECE("3", "x") TRIANGLE END, "NumberOfCells"},
        {GRID("") PIECE("4", "1") TRIANGLE END, "coordinate expected"},
        {GRID("") PIECE("2", "1") TRIANGLE END, "not among the points"},
        {GRID("") PIECE("3", "1") POINTS("0 0 0 1 0 0 0 nan 0") CELLS("0 1 2", "3", "5") END,
         "not finite"},
        {GRID("") PIECE("3", "1") POINTS("0 0 0 1 0 0 0 &#49; 0") CELLS("0 1 2", "3", "5") END,
         "coordinate expected"},
        {GRID("") PIECE("3", "1") TRIANGLE POINTS("1 2 3") END, "second array of points"},
        {GRID("") PIECE("3", "1") CELLS("0 1 2", "3", "5") END, "has no Points"},
        {GRID("") PIECE("3", "1") POINTS("0 0 0 1 0 0 0 1 0") END, "must have connectivity"},
        {GRID("") PIECE("3", "2") TRIANGLE END, "the number of values"},
        {GRID("") PIECE("3", "100") TRIANGLE END, "the number of values"},
        {GRID("") PIECE("3", "1") POINTS("0 0 0 1 0 0 0 1 0") CELLS("0 1", "3", "5") END,
         "the number of values"},
        {GRID("") PIECE("3", "2") POINTS("0 0 0 1 0 0 0 1 0") CELLS("0 1 2", "3 1", "5 5") END,
         "do not rise"},
        {GRID("") PIECE("3", "1") POINTS("0 0 0 1 0 0 0 1 0") CELLS("0 1 3", "3", "5") END,
         "not among the points"},
        {GRID("") PIECE("3", "1") POINTS("0 0 0 1 0 0 0 1 0") CELLS("0 1 2", "3", "22") END,
         "its number of nodes does not fit its type"},
        {GRID("") PIECE("3", "1") POINTS("0 0 0 1 0 0 0 1 0") CELLS("0 1 2", "3", "61") END,
         "type 61 (higher order triangle): elements of third order or higher"},
        {GRID("") PIECE("3", "1") POINTS("0 0 0 1 0 0 0 1 0") CELLS("0 1 2", "3", "300") END,
         "type 300 is not a type of VTK"},
        {POLYHEDRON("", "-1 13") END, "cut short"},
        {POLYHEDRON("3 3 0 1 2 3 0 1 4 3 1 2 4", "-1 13 12") END, "faceoffsets: they do not rise"},
        {POLYHEDRON("3 3 0 1 2 3 0 1 4 3 1 2 4", "-1 14 -1") END,
         "faces: the number of values in the array"},
        {POLYHEDRON("3 3 0 1 2 3 0 1 4 3 1 2 4", "-1 12 -1") END,
         "faces: the faces of a polyhedron must be"},
        {POLYHEDRON("3 3 0 1 2 3 0 1 4 3 1 2 8", "-1 13 -1") END,
         "faces: the faces of a polyhedron must be"},
        {POLYHEDRON("3 3 0 1 2 3 0 1 4 9 1 2 4", "-1 13 -1") END,
         "faces: the faces of a polyhedron must be"},
        {POLYHEDRON("-1", "-1 1 -1") END, "faces: the faces of a polyhedron must be"},
        {TABLES("0 3 2", "0 1 2", "3 6 9", "0 1 2 0 1 4 1 2 4") END, "polyhedron_offsets: they"},
        {TABLES("0 3 3", "0 1 -2", "3 6 9", "0 1 2 0 1 4 1 2 4") END, "polyhedron_to_faces: they"},
        {TABLES("0 3 3", "0 1 3", "3 6 9", "0 1 2 0 1 4 1 2 4") END,
         "face_offsets: the number of values in the array"},
        {TABLES("0 3 3", "0 1 2", "3 6 99", "0 1 2 0 1 4 1 2 4") END,
         "face_connectivity: the number of values"},
        {TABLES("0 3 3", "0 1 2", "3 6 9", "0 1 2 0 1 4 1 2 9") END, "face_connectivity: a node"},
        {GRID("") PIECE("3", "1") POINTS("0 0 0 1 0 0 0 1 0") CELLS("0 1 99999999999", "3", "5")
             END,
         "connectivity: a number is out of range"},
        {GRID("")
             PIECE("3", "1") "<Points><DataArray type=\"Int32\" NumberOfComponents=\"3\">0 0 0 "
                             "1 0 0 0 1 0</DataArray></Points>" END,
         "Float32 or Float64"},
        {GRID("") PIECE("3", "1") "<Points><DataArray type=\"Float32\" "
                                  "NumberOfComponents=\"2\">0</DataArray></Points>" END,
         "NumberOfComponents must be 3"},
        {GRID("") PIECE("3", "1") "<Points><DataArray type=\"Float32\" format=\"odd\"/>",
         "format must be"},
        {GRID("") PIECE("3", "1") "<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" "
                                  "format=\"appended\" offset=\"0\"/></Points>" END,
         "cut short"},
        {GRID("") PIECE("3", "1") "<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" "
                                  "format=\"appended\" offset=\"-4\"/></Points>" END,
         "offset must be"},
        {GRID("") PIECE("3", "1") "<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" "
                                  "format=\"binary\">JAAAAA==</DataArray></Points>" END,
         "cut short"},
        {GRID("") PIECE("3", "1") "<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" "
                                  "format=\"binary\">IwAAAA==</DataArray></Points>" END,
         "the number of values"},
        {GRID("") PIECE("3", "1") "</Piece></UnstructuredGrid><AppendedData>x",
         "must begin with '_'"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        reading_fails(&io_format_vtu, bad[i].text, bad[i].word);
}

/** Headers of packed points that promise what is not there, or a small file that expands without
 *  bound: nothing is made room for. */
static void packed_lies_are_refused(void **state) {
    (void)state;
    static const struct {
        int64_t points, blocks, size, last, packed;
        const char *word;
    } lies[] = {{6, 1, 144, 0, 9, "cannot be unpacked"},
                {6, 1, 100, 0, 9, "the number of values"},
                {6, 2, 144, 0, 9, "cut short"},
                {6, 2, INT64_MAX, 0, 9, "the number of values"},
                {6, 1, 144, 145, 9, "the number of values"},
                {6, 0, 0, 0, 0, "the number of values"},
                {6, 2, 0, 0, 1, "the number of values"},
                {6, 1, 144, 0, 1 << 20, "cut short"},
                {6, INT32_MAX, 144, 0, 9, "cut short"},
                {90000, 1, 2160000, 0, 9, "256 times"},
                {200000000, 1, 4800000000, 0, 9, "cannot be in this file"}};
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        file_builder f = {.swapped = !io_machine_is_little()};
        builder_text(
            &f,
            GRID(" header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"") "<Piece "
                                                                                 "NumberOfPoints="
                                                                                 "\"%lld\" "
                                                                                 "NumberOfCells="
                                                                                 "\"0\">",
            (long long)lies[i].points);
        builder_text(&f, "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" "
                         "format=\"appended\" offset=\"0\"/></Points></Piece></UnstructuredGrid>"
                         "<AppendedData encoding=\"raw\">_");
        f.binary = 1;
        builder_integer(&f, lies[i].blocks, 8);
        builder_integer(&f, lies[i].size, 8);
        builder_integer(&f, lies[i].last, 8);
        builder_integer(&f, lies[i].packed, 8);
        vtu_put_bytes(&f, "x\x9c-7-7-7-7-", 12);
        if (io_compression_is_built(IO_ZLIB))
            builder_expect_error(&f, &io_format_vtu, lies[i].word);
        builder_release(&f);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_encoding_is_read),
        cmocka_unit_test_setup_teardown(every_encoding_is_written, test_folder_create,
                                        test_folder_remove),
        cmocka_unit_test(cut_short_or_without_memory),
        cmocka_unit_test_setup_teardown(surplus_stays, test_folder_create, test_folder_remove),
        cmocka_unit_test(other_cells_hold_their_nodes),
        cmocka_unit_test_setup_teardown(pieces_are_one_mesh, test_folder_create,
                                        test_folder_remove),
        cmocka_unit_test_setup_teardown(blocks_of_any_size, test_folder_create, test_folder_remove),
        cmocka_unit_test_setup_teardown(points_in_the_element, test_folder_create,
                                        test_folder_remove),
        cmocka_unit_test_setup_teardown(whole_blocks, test_folder_create, test_folder_remove),
        cmocka_unit_test(pieces_of_bytes_and_of_text),
        cmocka_unit_test(empty_pieces_may_be_of_any_type),
        cmocka_unit_test(arrays_of_the_same_bytes_are_refused),
        cmocka_unit_test_setup_teardown(pieces_in_any_order, test_folder_create,
                                        test_folder_remove),
        cmocka_unit_test(what_is_wrong_is_said),
        cmocka_unit_test(packed_lies_are_refused),
    };
    return reading_knows_vtu() ? cmocka_run_group_tests(tests, NULL, NULL) : 0;
}
