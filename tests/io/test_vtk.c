/* Tests of the reader of legacy VTK files: the same small mesh in every encoding and version, the
 * attributes around "fixed", and files that lie. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "io/core/binary.h"
#include "support/file_builder.h"
#include "support/reading.h"

enum { N_NODES = 5, N_CELLS = 6 };
static const double points[N_NODES][3] = {
    {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.1, 0.125, 0.2}};
/* A line, a tetrahedron, a triangle, and the other tetrahedra: nodes, and VTK's types. */
static const int cells[N_CELLS][4] = {{0, 1, -1, -1}, {0, 1, 2, 4}, {0, 1, 2, -1},
                                      {0, 1, 3, 4},   {0, 2, 3, 4}, {1, 2, 3, 4}};
static const int types[N_CELLS] = {3, 10, 5, 10, 10, 10};

static int cell_size(int cell) {
    return types[cell] == 10 ? 4 : types[cell] == 5 ? 3 : 2;
}

/* How a test file is written. */
struct variant {
    int binary;
    int is_float;
    int version; /* 3 or 5 */
    int narrow;  /* version 5: 32-bit lists */
    int wrap;    /* as in file_builder */
};

static void put_header(file_builder *file, const struct variant *variant) {
    const char *line = variant->wrap == 3 ? "\r\n" : "\n";
    file->binary = variant->binary;
    file->swapped = io_machine_is_little();
    file->wrap = variant->wrap;
    builder_text(file, "# vtk DataFile Version %s%sa title%s%s%sDATASET unstructured_grid%s",
                 variant->version == 5 ? "5.1" : "3.0", line, line,
                 variant->binary ? "BINARY" : "ascii", line, line);
    builder_text(file, "FIELD FieldData 1\nTIME 1 1 double\n");
    builder_real(file, 0.5, 8);
    builder_text(file, "\n");
}

static void put_counted_cells(file_builder *file) {
    builder_text(file, "\nCELLS %d 27\n", N_CELLS);
    for (int i = 0; i < N_CELLS; i++) {
        builder_integer(file, cell_size(i), 4);
        for (int k = 0; k < cell_size(i); k++)
            builder_integer(file, cells[i][k], 4);
        builder_line(file);
    }
}

static void put_offset_cells(file_builder *file, int size) {
    int offset = 0;
    builder_text(file, "\nCELLS %d 21\nOFFSETS vtktypeint%d\n", N_CELLS + 1, 8 * size);
    for (int i = 0; i <= N_CELLS; i++) {
        builder_integer(file, offset, size);
        offset += i < N_CELLS ? cell_size(i) : 0;
    }
    builder_text(file, "\nCONNECTIVITY vtktypeint%d\n", 8 * size);
    for (int i = 0; i < N_CELLS; i++)
        for (int k = 0; k < cell_size(i); k++)
            builder_integer(file, cells[i][k], size);
}

/* The mesh; place: of the coordinates of each node. */
static file_builder make_mesh(const struct variant *variant, int64_t *place) {
    file_builder file = {0};
    put_header(&file, variant);
    builder_text(&file, "POINTS %d %s\n", N_NODES, variant->is_float ? "float" : "double");
    for (int i = 0; i < N_NODES; i++) {
        place[i] = builder_place(&file);
        for (int d = 0; d < 3; d++)
            builder_real(&file, points[i][d], variant->is_float ? 4 : 8);
        builder_line(&file);
    }
    builder_text(&file, "\nMETADATA\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\n"
                        "DATA 2 0 1\n\n");
    if (variant->version == 5)
        put_offset_cells(&file, variant->narrow ? 4 : 8);
    else
        put_counted_cells(&file);
    builder_text(&file, "\nCELL_TYPES %d\n", N_CELLS);
    for (int i = 0; i < N_CELLS; i++) {
        builder_integer(&file, types[i], 4);
        builder_line(&file);
    }
    builder_text(&file, "\n");
    return file;
}

static void put_reals(file_builder *file, int n, int size) {
    for (int i = 0; i < n; i++)
        builder_real(file, 1, size);
    builder_text(file, "\n");
}

/* One of each kind of attribute, to be passed over. */
static void put_attributes(file_builder *file, int n) {
    builder_text(file, "SCALARS pressure float 2\nLOOKUP_TABLE mine\n");
    put_reals(file, 2 * n, 4);
    builder_text(file, "LOOKUP_TABLE mine 3\n");
    for (int i = 0; i < 12; i++)
        builder_integer(file, i, 1);
    builder_text(file, "\nVECTORS v double\n");
    put_reals(file, 3 * n, 8);
    builder_text(file, "NORMALS w float\n");
    put_reals(file, 3 * n, 4);
    builder_text(file, "TENSORS t float\n");
    put_reals(file, 9 * n, 4);
    builder_text(file, "TENSORS6 s float\n");
    put_reals(file, 6 * n, 4);
    builder_text(file, "GLOBAL_IDS g vtktypeint64\n");
    for (int i = 0; i < n; i++)
        builder_integer(file, i, 8);
    builder_text(file, "\nTEXTURE_COORDINATES c 2 float\n");
    put_reals(file, 2 * n, 4);
    builder_text(file, "COLOR_SCALARS colour 3\n");
    for (int i = 0; i < 3 * n; i++)
        builder_integer(file, 1, 1);
    builder_text(file, "\nFIELD f 3\nlabel 1 1 string\n%s\nids 1 %d vtktypeint64\n",
                 file->binary ? "\xc3"
                                "abc"
                              : "abc def",
                 n);
    for (int i = 0; i < n; i++)
        builder_integer(file, 1, 8);
    builder_text(file, "\nMETADATA\nCOMPONENT_NAMES\nx\n\nsmall 1 %d short\n", n);
    for (int i = 0; i < n; i++)
        builder_integer(file, 1, 2);
    builder_text(file, "\n");
}

/* ---- what must have been read ------------------------------------------------------------- */

static void expect_places(const io_model *model, const struct variant *variant,
                          const int64_t *place) {
    const io_span *span = model->span;
    int size = variant->is_float ? 4 : 8;
    assert_int_equal(model->n_spans, 1);
    assert_int_equal(span->n_nodes, N_NODES);
    assert_int_equal(model->text_offset == NULL, variant->binary);
    if (!variant->binary) {
        assert_int_equal(span->encoding, IO_TEXT);
        for (int i = 0; i < N_NODES; i++)
            assert_int_equal(model->text_offset[i], place[i]);
        return;
    }
    assert_int_equal(span->encoding, variant->is_float ? IO_FLOAT32 : IO_FLOAT64);
    assert_int_equal(span->swapped, io_machine_is_little());
    assert_int_equal(span->offset, place[0]);
    assert_int_equal(span->stride, 3 * size);
}

static void expect_mesh(const planish_file *file, const struct variant *variant) {
    static const int64_t numbers[4] = {1, 3, 4, 5};
    const io_model *model = &file->model;
    assert_int_equal(model->dim, 3);
    assert_int_equal(model->n_nodes, N_NODES);
    assert_int_equal(model->precision,
                     variant->is_float ? PLANISH_PRECISION_FLOAT : PLANISH_PRECISION_DOUBLE);
    for (int i = 0; i < 3 * N_NODES; i++) {
        volatile float rounded = (float)points[i / 3][i % 3];
        double expected = variant->is_float ? (double)rounded : points[i / 3][i % 3];
        assert_true(model->coordinates[i] == expected);
    }
    assert_int_equal(model->tetrahedron.n, 4);
    for (int i = 0; i < 4; i++) {
        assert_memory_equal(&model->tetrahedron.nodes[4 * i], cells[numbers[i]], sizeof cells[0]);
        assert_int_equal(planish_file_element_number(file, i), numbers[i]);
    }
    assert_int_equal(model->triangle.n, 1);
    assert_int_equal(model->n_lower, 2);
    assert_int_equal(planish_file_node_number(file, 3), 3);
}

static const struct variant variants[] = {
    {0, 0, 3, 0, 0}, {0, 1, 3, 0, 3}, {0, 0, 3, 0, 9}, {1, 0, 3, 0, 0}, {1, 1, 3, 0, 0},
    {0, 0, 5, 0, 0}, {0, 1, 5, 1, 7}, {1, 0, 5, 0, 0}, {1, 1, 5, 1, 0},
};
enum { N_VARIANTS = sizeof variants / sizeof variants[0] };

static void read_file(const file_builder *builder, planish_file **file) {
    planish_error error = {0};
    if (builder_read(builder, &io_format_vtk, 1, file, &error) != 0)
        fail_msg("%s", error.text);
}

static void test_mesh(void **state) {
    (void)state;
    for (int i = 0; i < N_VARIANTS; i++) {
        int64_t place[N_NODES];
        planish_file *file;
        file_builder builder = make_mesh(&variants[i], place);
        assert_true(io_format_vtk.recognise(builder.data, builder.size));
        read_file(&builder, &file);
        expect_mesh(file, &variants[i]);
        expect_places(&file->model, &variants[i], place);
        for (int k = 0; k < N_NODES; k++)
            assert_int_equal(file->model.hold[k], k < 2    ? IO_HELD_BY_FACE | IO_HELD_BY_LINE
                                                  : k == 2 ? IO_HELD_BY_FACE
                                                           : 0);
        planish_file_close(file);
        builder_try_to_break(&builder, &io_format_vtk);
        builder_release(&builder);
    }
}

static void expect_required(const file_builder *builder, int node) {
    planish_file *file;
    read_file(builder, &file);
    for (int k = 0; k < N_NODES; k++)
        assert_int_equal((file->model.hold[k] & IO_HELD_MARKED) != 0, k == node);
    planish_file_close(file);
}

/* "fixed" of every type, behind other attributes, on points and not on cells. */
static void test_fixed_scalars(void **state) {
    (void)state;
    static const struct {
        const char *name;
        int size, is_real;
    } kinds[] = {{"int", 4, 0},   {"float", 4, 1},        {"double", 8, 1},
                 {"short", 2, 0}, {"char", 1, 0},         {"unsigned_char", 1, 0},
                 {"long", 8, 0},  {"unsigned_int", 4, 0}, {"vtktypeint64", 8, 0}};
    for (int i = 0; i < N_VARIANTS; i++) {
        for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; k++) {
            int64_t place[N_NODES];
            file_builder builder = make_mesh(&variants[i], place);
            builder_text(&builder, "CELL_DATA %d\nSCALARS fixed int 1\n", N_CELLS);
            for (int c = 0; c < N_CELLS; c++)
                builder_integer(&builder, 1, 4);
            builder_text(&builder, "\n");
            put_attributes(&builder, N_CELLS);
            builder_text(&builder, "POINT_DATA %d\n", N_NODES);
            put_attributes(&builder, N_NODES);
            builder_text(&builder, "scalars fixed %s\nlookup_table default\n", kinds[k].name);
            for (int n = 0; n < N_NODES; n++)
                if (kinds[k].is_real)
                    builder_real(&builder, n == 3 ? 0.5 : 0, kinds[k].size);
                else
                    builder_integer(&builder, n == 3 ? -1 : 0, kinds[k].size);
            expect_required(&builder, 3);
            builder_release(&builder);
        }
    }
}

static void test_fixed_field(void **state) {
    (void)state;
    for (int i = 0; i < N_VARIANTS; i++) {
        int64_t place[N_NODES];
        file_builder builder = make_mesh(&variants[i], place);
        builder_text(&builder, "POINT_DATA %d\nFIELD FieldData 2\nother 2 %d int\n", N_NODES,
                     N_NODES);
        for (int n = 0; n < 2 * N_NODES; n++)
            builder_integer(&builder, 1, 4);
        builder_text(&builder, "\nfixed 1 %d unsigned_char\n", N_NODES);
        for (int n = 0; n < N_NODES; n++)
            builder_integer(&builder, n == 4, 1);
        builder_text(&builder, "\nUNHEARD_OF 12\nwith its lines\n");
        expect_required(&builder, 4);
        builder_try_to_break(&builder, &io_format_vtk);
        builder_release(&builder);
    }
}

static void test_fixed_bits(void **state) {
    (void)state;
    for (int i = 0; i < N_VARIANTS; i++) {
        int64_t place[N_NODES];
        file_builder builder = make_mesh(&variants[i], place);
        builder_text(&builder, "POINT_DATA %d\nSCALARS fixed bit\n", N_NODES);
        if (builder.binary)
            builder_integer(&builder, 0x40, 1); /* the first node's is the highest bit */
        for (int n = 0; !builder.binary && n < N_NODES; n++)
            builder_integer(&builder, n == 1, 1);
        expect_required(&builder, 1);
        builder_release(&builder);
    }
}

/* ---- a large file on several threads ------------------------------------------------------ */

enum { SIDE = 180 };

static void test_large(void **state) {
    (void)state;
    for (int wrap = 0; wrap <= 9; wrap += 9) {
        file_builder file = {.wrap = wrap};
        int n = 2 * (SIDE - 1) * (SIDE - 1);
        builder_text(&file, "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\n");
        builder_text(&file, "POINTS %d double\n", SIDE * SIDE);
        for (int i = 0; i < SIDE * SIDE; i++) {
            builder_real(&file, i % SIDE + 1.0 / (3 + i), 8);
            builder_real(&file, i / SIDE + 1.0 / (5 + i), 8);
            builder_real(&file, 0, 8);
            builder_line(&file);
        }
        builder_text(&file, "\nCELLS %d %d\n", n, 4 * n);
        for (int t = 0; t < n; t++) {
            int corner = t / 2 / (SIDE - 1) * SIDE + t / 2 % (SIDE - 1);
            builder_integer(&file, 3, 4);
            builder_integer(&file, corner, 4);
            builder_integer(&file, corner + SIDE + 1, 4);
            builder_integer(&file, t % 2 ? corner + 1 : corner + SIDE, 4);
            builder_line(&file);
        }
        builder_text(&file, "\nCELL_TYPES %d\n", n);
        for (int t = 0; t < n; t++)
            builder_integer(&file, 5, 4);
        builder_expect_same_on_threads(&file, &io_format_vtk);
        builder_release(&file);
    }
}

/* ---- bad files ---------------------------------------------------------------------------- */

#define HEAD   "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET UNSTRUCTURED_GRID\n"
#define POINTS "POINTS 3 double\n0 0 0 1 0 0 0 1 0\n"
#define CELLS  "CELLS 1 4\n3 0 1 2\n"
#define TYPES  "CELL_TYPES 1\n5\n"

static void test_errors(void **state) {
    (void)state;
    static const reading_refusal cases[] = {
        {"# vtk DataFile Version 3.0\ntitle\nDATASET UNSTRUCTURED_GRID\n", "test:3: ASCII"},
        {"# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET POLYDATA\n", "UNSTRUCTURED_GRID"},
        {HEAD, "ends before CELL_TYPES"},
        {HEAD "POINTS 3 int\n0 0 0 1 0 0 0 1 0\n", "float or double"},
        {HEAD "POINTS 4611686018427387904 float\n0 0 0\n",
         "test:5: 4611686018427387904 points cannot be"},
        {HEAD "POINTS -1 float\n0 0 0\n", "cannot be in the"},
        {HEAD "POINTS 2 double\n0 0 0 1 0\n" CELLS, "coordinate expected"},
        {HEAD "POINTS 2 double\n0 0 0 1\nnan 0\n", "test:7: node 1 has a coordinate"},
        {HEAD "POINTS 2 float\n0 0 0 1 1e39 0\n", "not finite"},
        {HEAD POINTS POINTS, "second POINTS"},
        {HEAD POINTS "CELLS 1 4611686018427387904\n3 0 1 2\n", "cannot be in the"},
        {HEAD POINTS "CELLS 5 4\n3 0 1 2\n", "more cells than numbers"},
        {HEAD POINTS "CELLS 1 4\n3 0 1 2147483648\n", "out of range"},
        {HEAD POINTS "CELLS 1 4\n3 0 1 x\n", "test:8: CELLS or CELL_TYPES: a whole number"},
        {HEAD POINTS CELLS CELLS, "second CELLS"},
        {HEAD CELLS TYPES, "behind POINTS"},
        {HEAD POINTS CELLS "CELL_TYPES 2\n5 5\n", "as many types as cells"},
        {HEAD POINTS CELLS "CELL_TYPES 1\n10\n", "cell 0 (from 0): its number of nodes"},
        {HEAD POINTS CELLS "CELL_TYPES 1\n22\n", "cell 0 (from 0): its number of nodes"},
        {HEAD POINTS CELLS "CELL_TYPES 1\n12\n", "cell 0 (from 0): its number of nodes"},
        {HEAD POINTS CELLS "CELL_TYPES 1\n-1\n", "cell 0 (from 0): type -1 is not a type of VTK"},
        {HEAD POINTS CELLS "CELL_TYPES 1\n256\n", "type 256 is not a type of VTK"},
        {HEAD POINTS CELLS "CELL_TYPES 1\n99\n", "nothing to smooth"},
        {HEAD POINTS CELLS "CELL_TYPES 1\n42\n", "its faces must be"},
        {HEAD POINTS "CELLS 1 6\n5 1 3 0 1 3\nCELL_TYPES 1\n42\n", "its faces must be"},
        {HEAD POINTS "CELLS 1 6\n5 1 2 0 1 2\nCELL_TYPES 1\n42\n", "its faces must be"},
        {HEAD POINTS "CELLS 1 1\n0\nCELL_TYPES 1\n42\n", "its faces must be"},
        {HEAD POINTS "CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n71\n", "nothing to smooth"},
        {HEAD POINTS "CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n64\n",
         "type 64 (higher order tetrahedron): elements of"},
        {HEAD POINTS CELLS "CELL_TYPES 1\n3\n", "nothing to smooth"},
        {HEAD POINTS "CELLS 1 4\n3 0 1 3\n" TYPES, "not among the points"},
        {HEAD POINTS "CELLS 1 4\n3 0 1 -1\n" TYPES, "not among the points"},
        {HEAD POINTS "CELLS 1 4\n4 0 1 2\n" TYPES, "not in the list"},
        {HEAD POINTS "CELLS 1 4\n-1 0 1 2\n" TYPES, "not in the list"},
        {HEAD POINTS
         "CELLS 2 3\nOFFSETS vtktypeint64\n0 4\nCONNECTIVITY vtktypeint64\n0 1 2\n" TYPES,
         "offsets do not rise"},
        {HEAD POINTS
         "CELLS 2 3\nOFFSETS vtktypeint64\n-1 3\nCONNECTIVITY vtktypeint64\n0 1 2\n" TYPES,
         "offsets do not rise"},
        {HEAD POINTS "CELLS 0 3\nOFFSETS vtktypeint64\n", "at least one offset"},
        {HEAD POINTS "CELLS 2 3\nOFFSETS float\n0 3\n", "of this type"},
        {HEAD "WHATEVER\n", "not understood"},
        {HEAD "POINT_DATA 3\n", "before the mesh"},
        {HEAD POINTS CELLS TYPES "POINT_DATA 4\n", "as many as points"},
        {HEAD POINTS CELLS TYPES "POINT_DATA 3\nSCALARS fixed int\n1 0\n", "number expected"},
        {HEAD POINTS CELLS TYPES "POINT_DATA 3\nVECTORS v int\n1 0\n", "cut short"},
        {HEAD POINTS CELLS TYPES "FIELD f 1\na 4611686018427387904 4611686018427387904 int\n1\n",
         "out of range"},
    };
    reading_refuses(&io_format_vtk, cases, sizeof cases / sizeof *cases);
}

/** Numbers of 8 bytes that 4 bytes do not hold are refused, not cut off. */
static void test_wide_numbers(void **state) {
    (void)state;
    static const int64_t wide[] = {(int64_t)1 << 32, -((int64_t)1 << 40), INT64_MAX, 2};
    for (size_t k = 0; k < sizeof wide / sizeof *wide; k++) {
        file_builder file = {.binary = 1, .swapped = 1};
        planish_file *read = NULL;
        planish_error error;
        builder_text(&file, "# vtk DataFile Version 5.1\nt\nBINARY\nDATASET UNSTRUCTURED_GRID\n"
                            "POINTS 3 double\n");
        for (int i = 0; i < 9; i++)
            builder_real(&file, i == 3 || i == 7 ? 1 : 0, 8);
        builder_text(&file, "\nCELLS 2 3\nOFFSETS vtktypeint64\n");
        builder_integer(&file, 0, 8);
        builder_integer(&file, 3, 8);
        builder_text(&file, "\nCONNECTIVITY vtktypeint64\n");
        builder_integer(&file, 0, 8);
        builder_integer(&file, 1, 8);
        builder_integer(&file, wide[k], 8);
        builder_text(&file, "\nCELL_TYPES 1\n");
        builder_integer(&file, 5, 4);
        if (wide[k] != 2) {
            builder_expect_error(&file, &io_format_vtk, "out of range");
        } else {
            assert_int_equal(builder_read(&file, &io_format_vtk, 1, &read, &error), PLANISH_OK);
            planish_file_close(read);
        }
        builder_release(&file);
    }
}

static void test_other_cells_are_elements(void **state) {
    (void)state;
    static const char text[] = HEAD "POINTS 7 double\n0 0 0 1 0 0 0 1 0 0 0 1 1 1 1 2 1 1 2 2 2\n"
                                    "CELLS 2 11\n4 0 1 2 3\n5 0 1 2 4 5\nCELL_TYPES 2\n10 14\n";
    const uint8_t expected[7] = {0};
    file_builder builder = builder_of(text);
    planish_file *file;
    read_file(&builder, &file);
    assert_int_equal(file->model.solid.n, 1);
    assert_int_equal(planish_file_mesh(file).n_elements, 2);
    assert_memory_equal(file->model.hold, expected, 7);
    planish_file_close(file);
}

/** What is a line, triangle or tetrahedron by its nodes is one, whatever VTK calls it. */
static void test_simplices_by_other_names(void **state) {
    (void)state;
    static const struct {
        const char *cells, *types;
        int lines, triangles, tetrahedra, lower, other;
    } cases[] = {{"CELLS 3 12\n3 0 1 2\n3 1 2 3\n3 0 2 3\n", "7 6 69", 0, 3, 0, 0, 0},
                 {"CELLS 3 13\n3 0 1 2\n4 0 1 2 3\n3 0 2 3\n", "7 7 76", 0, 2, 0, 0, 1},
                 {"CELLS 3 15\n4 0 1 2 3\n4 1 2 3 4\n4 0 1 2 3\n", "10 71 6", 0, 0, 2, 0, 1},
                 {"CELLS 3 10\n3 0 1 2\n2 0 1\n2 1 2\n", "5 3 4", 2, 1, 0, 2, 0},
                 {"CELLS 3 12\n3 0 1 2\n3 0 1 2\n3 0 1 2\n", "5 4 0", 0, 1, 0, 1, 1}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[512];
        snprintf(text, sizeof text,
                 HEAD "POINTS 5 double\n0 0 0 1 0 0 0 1 0 0 0 %d 2 2 0\n%sCELL_TYPES 3\n%s\n",
                 cases[i].tetrahedra > 0, cases[i].cells, cases[i].types);
        planish_file *file = reading_text(&io_format_vtk, text);
        assert_int_equal(file->model.line.n, cases[i].lines);
        assert_int_equal(file->model.triangle.n, cases[i].triangles);
        assert_int_equal(file->model.tetrahedron.n, cases[i].tetrahedra);
        assert_int_equal(file->model.n_lower, cases[i].lower);
        assert_int_equal(file->model.n_other, cases[i].other);
        planish_file_close(file);
    }
}

/** A polyhedron is a stream of faces in both forms of CELLS: the counts in it are no nodes. */
static void test_polyhedra_hold(void **state) {
    (void)state;
    static const char *const lists[] = {
        "CELLS 2 19\n3 0 1 2\n14 3 3 3 4 5 3 3 4 6 4 3 4 5 6\n",
        "CELLS 3 17\nOFFSETS vtktypeint64\n0 3 17\nCONNECTIVITY vtktypeint64\n"
        "0 1 2 3 3 3 4 5 3 3 4 6 4 3 4 5 6\n"};
    for (int i = 0; i < 2; i++) {
        char text[512];
        const uint8_t other = IO_HELD_BY_OTHER;
        const uint8_t expected[7] = {0, 0, 0, other, other, other, other};
        snprintf(text, sizeof text,
                 HEAD "POINTS 7 double\n0 0 0 1 0 0 0 1 0 5 5 5 6 5 5 5 6 5 5 5 6\n"
                      "%sCELL_TYPES 2\n5 42\n",
                 lists[i]);
        planish_file *file = reading_text(&io_format_vtk, text);
        assert_int_equal(file->model.n_other, 1);
        assert_memory_equal(file->model.hold, expected, sizeof expected);
        planish_file_close(file);
        file_builder builder = {.data = text, .size = (int64_t)strlen(text)};
        builder_try_to_break(&builder, &io_format_vtk);
    }
}

/* ---- files made by others ----------------------------------------------------------------- */

/** Points hold their nodes, unless they are all there are; polylines always do. */
static void test_points_of_all_nodes(void **state) {
    (void)state;
    static const struct {
        const char *cells, *types, *held;
    } cases[] = {{"CELLS 3 10\n3 0 1 2\n3 0 2 3\n1 0\n", "5 5 1", "1000"},
                 {"CELLS 4 14\n3 0 1 2\n3 0 2 3\n1 0\n3 1 2 3\n", "5 5 1 2", "0000"},
                 {"CELLS 3 13\n3 0 1 2\n3 0 2 3\n4 0 1 2 3\n", "5 5 4", "1111"},
                 {"CELLS 4 15\n3 0 1 2\n3 0 2 3\n4 0 1 2 3\n1 2\n", "5 5 4 1", "1111"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[512];
        snprintf(text, sizeof text,
                 "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                 "POINTS 4 double\n0 0 0 1 0 0 1 1 0 0 1 0\n%sCELL_TYPES %d\n%s\n",
                 cases[i].cells, (int)(strlen(cases[i].types) + 1) / 2, cases[i].types);
        planish_file *file = reading_text(&io_format_vtk, text);
        for (int k = 0; k < 4; k++)
            assert_int_equal(file->model.hold[k] != 0, cases[i].held[k] == '1');
        planish_file_close(file);
    }
}

static void test_real_files(void **state) {
    (void)state;
    const struct {
        const char *name;
        int nodes, elements, required;
    } cases[] = {
        {"msq_tire.vtk", 2570, 11098, 1248},        {"msq_flat_tet_sphere.vtk", 4793, 23636, 1548},
        {"msq_tet4_tangled.vtk", 129, 408, 98},     {"msq2d_bad_circle.vtk", 33, 48, 16},
        {"msq2d_tri_20258.vtk", 10300, 20258, 340}, {"part_1M.vtk", 160573, 896923, 0}};
    const char *folder = getenv("PLANISH_MESHES");
    if (folder == NULL)
        skip();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char path[1024];
        planish_file *file;
        planish_error error;
        int required = 0;
        snprintf(path, sizeof path, "%s/%s", folder, cases[i].name);
        if (planish_file_open(path, NULL, 2, &file, &error) != 0)
            fail_msg("%s", error.text);
        for (int64_t k = 0; k < file->model.n_nodes; k++)
            required += (file->model.hold[k] & IO_HELD_MARKED) != 0;
        assert_int_equal(planish_file_mesh(file).n_nodes, cases[i].nodes);
        assert_int_equal(planish_file_mesh(file).n_elements, cases[i].elements);
        assert_int_equal(required, cases[i].required);
        planish_file_close(file);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_mesh),
        cmocka_unit_test(test_fixed_scalars),
        cmocka_unit_test(test_fixed_field),
        cmocka_unit_test(test_fixed_bits),
        cmocka_unit_test(test_large),
        cmocka_unit_test(test_errors),
        cmocka_unit_test(test_wide_numbers),
        cmocka_unit_test(test_other_cells_are_elements),
        cmocka_unit_test(test_simplices_by_other_names),
        cmocka_unit_test(test_polyhedra_hold),
        cmocka_unit_test(test_points_of_all_nodes),
        cmocka_unit_test(test_real_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
