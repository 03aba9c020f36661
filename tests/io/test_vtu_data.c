/* Arrays of numbers of VTK's XML files, in every encoding. */
#include "support/data_reading.h"
#include "support/reading.h"
#include "support/vtu_builder.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static double size_of_node(int64_t number, int k) {
    (void)k;
    return 0.5 + 0.5 * (double)number;
}

static double number_of_cell(int64_t number, int k) {
    (void)k;
    return (double)number;
}

static double region_of_cell(int64_t number, int k) {
    (void)k;
    return vtu_regions[number];
}

static void read_one(const variant *v) {
    planish_error error = {.text = ""};
    planish_file *file;
    file_builder f = vtu_make_file(v);
    if (builder_read(&f, &io_format_vtu, 2, &file, &error))
        fail_msg("%s", error.text);
    expect_data_list(file, "*material:1 *region:1 size:1");
    for (int i = 0; i < 3; i++) { /* again and again */
        expect_data(file, "size", 0, 1, size_of_node);
        expect_data(file, "material", 1, 1, number_of_cell);
        expect_data(file, "region", 1, 1, region_of_cell);
    }
    planish_file_close(file);
    if (v->header_size == 8 && !v->is_big && v->is_float && !v->surplus &&
        v->compression == (v->form == APPENDED_RAW ? IO_ZLIB : IO_PLAIN))
        builder_try_to_break(&f, &io_format_vtu);
    builder_release(&f);
}

static void every_encoding_is_read(void **state) {
    static const io_compression packers[] = {IO_PLAIN, IO_ZLIB, IO_LZ4, IO_LZMA};
    (void)state;
    for (int how = ASCII; how <= APPENDED_BASE64; how++)
        for (int bits = 0; bits < (how == ASCII ? 2 : 8); bits++)
            for (int p = 0; p < (how == ASCII ? 1 : 4); p++)
                for (int surplus = 0; surplus < 2; surplus++) {
                    const variant v = {
                        .form = (form)how,
                        .is_float = bits & 1,
                        .header_size = bits & 2 ? 8 : 4,
                        .is_big = bits >> 2,
                        .compression = packers[p],
                        .block = 20,
                        .surplus = how == ASCII ? 0 : surplus,
                    };
                    if (io_compression_is_built(v.compression))
                        read_one(&v);
                }
}

/* ---- text ---------------------------------------------------------------------------------- */

#define GRID                 "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>"
#define PIECE(points, cells) "<Piece NumberOfPoints=\"" points "\" NumberOfCells=\"" cells "\">"
#define END                  "</Piece></UnstructuredGrid></VTKFile>"
#define ARRAY(type, name, components, text)                                                        \
    "<DataArray type=\"" type "\" Name=\"" name "\" NumberOfComponents=\"" components              \
    "\" format=\"ascii\">" text "</DataArray>"
#define POINTS(text) "<Points>" ARRAY("Float64", "Points", "3", text) "</Points>"
#define CELLS(connectivity, offsets, types)                                                        \
    "<Cells>" ARRAY("Int32", "connectivity", "1", connectivity)                                    \
        ARRAY("Int32", "offsets", "1", offsets) ARRAY("UInt8", "types", "1", types) "</Cells>"
#define TRIANGLE           POINTS("0 0 0 1 0 0 0 1 0") CELLS("0 1 2", "3", "5")
#define POINT_DATA(arrays) "<PointData>" arrays "</PointData>"
#define CELL_DATA(arrays)  "<CellData>" arrays "</CellData>"

static double rising(int64_t number, int k) {
    return (double)(1 + number + 10 * k);
}

static void pieces_are_one_array(void **state) {
    (void)state;
    planish_file *file = reading_text(
        &io_format_vtu,
        GRID PIECE("3", "1") TRIANGLE POINT_DATA(ARRAY("Float64", "h", "2", "1 11 2 12 3 13"))
            CELL_DATA(ARRAY("Float64", "c", "1", "1")) "</Piece>" PIECE("0", "0")
                POINTS("") "</Piece>" PIECE("3", "2") POINTS("2 0 0 3 0 0 2 1.5 0")
                    CELLS("0 1 0 1 2", "2 5", "3 5") POINT_DATA(ARRAY(
                        "Int32", "more", "1", "0 0 0") ARRAY("Int32", "h", "2", "4 14 5 15 6 16"))
                        CELL_DATA(ARRAY("Float32", "c", "1", "2 3")) END);
    expect_data_list(file, "h:2 *c:1 more:1");
    expect_data(file, "h", 0, 2, rising);
    expect_data(file, "c", 1, 1, rising);
    expect_no_data(file, "more", PLANISH_ERROR_FORMAT, "piece 0 has no array 'more'");
    planish_file_close(file);
}

static void tensors_are_put_in_order(void **state) {
    (void)state;
    planish_file *file = reading_text(
        &io_format_vtu,
        GRID PIECE("3", "1") TRIANGLE POINT_DATA(
            ARRAY("Float64", "m", "6", "1 21 51 11 41 31 2 22 52 12 42 32 3 23 53 13 43 33")) END);
    expect_data(file, "m", 0, 6, rising);
    planish_file_close(file);
}

static void expect_wrong(const char *text, const char *part) {
    planish_file *file = reading_text(&io_format_vtu, text);
    expect_no_data(file, "h", PLANISH_ERROR_FORMAT, part);
    planish_file_close(file);
}

static void wrong_arrays(void **state) {
    (void)state;
    expect_wrong(GRID PIECE("3", "1") TRIANGLE POINT_DATA(ARRAY("Float64", "h", "1", "1 2")) END,
                 "test:1: h: ");
    expect_wrong(GRID PIECE("3", "1") TRIANGLE POINT_DATA(ARRAY("Float64", "h", "1", "1 two 3"))
                     END,
                 "h: a number expected");
    expect_wrong(GRID PIECE("3", "1") TRIANGLE POINT_DATA(ARRAY("Float64", "h", "1", "1 2 nan"))
                     END,
                 "not finite, for node 2");
    expect_wrong(GRID PIECE("3", "1") TRIANGLE POINT_DATA(ARRAY("Float64", "h", "x", "1 2 3")) END,
                 "has -1 numbers for each of its values");
    expect_wrong(GRID PIECE("3", "1")
                     TRIANGLE POINT_DATA(ARRAY("Float64", "h", "2147483648", "1 2 3")) END,
                 "has 2147483648 numbers for each of its values");
    expect_wrong(GRID PIECE("3", "1") TRIANGLE POINT_DATA(
                     ARRAY("Float64", "h", "1", "1 2 3")) "</Piece>" PIECE("3", "1")
                     TRIANGLE POINT_DATA(ARRAY("Float64", "h", "2", "1 2 3 4 5 6")) END,
                 "h: NumberOfComponents is another one than in other pieces");
    expect_wrong(GRID PIECE("3", "1") TRIANGLE POINT_DATA(
                     "<DataArray type=\"Float64\" Name=\"h\" format=\"appended\" offset=\"9\"/>")
                     END,
                 "h: the number of values in the array");
    expect_wrong(GRID PIECE("3", "1") TRIANGLE POINT_DATA(
                     "<DataArray type=\"Float64\" Name=\"h\" format=\"binary\">AAAA</DataArray>")
                     END,
                 "h: ");
    expect_wrong(GRID PIECE("3", "1") TRIANGLE POINT_DATA(
                     "<DataArray type=\"String\" Name=\"h\" format=\"binary\">AAAA</DataArray>")
                     END,
                 "numbers of this type are not read");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_encoding_is_read),
        cmocka_unit_test(pieces_are_one_array),
        cmocka_unit_test(tensors_are_put_in_order),
        cmocka_unit_test(wrong_arrays),
    };
    return reading_knows_vtu() ? cmocka_run_group_tests(tests, NULL, NULL) : 0;
}
