/* vtk_data: the attributes of legacy VTK files: "fixed" holds nodes, some tell the regions of
 * cells, all others are passed over.
 *
 * Their extent must be known all the same, to find the keyword behind them.
 */
#include "io/vtk.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/binary.h"
#include "io/vtk_cells.h"

/* One array of attributes. */
struct array {
    vtk_reader *reader;
    const vtk_type *type;
    int64_t n;     /* tuples */
    int64_t width; /* numbers of a tuple */
};

static double load_number(const char *at, const vtk_type *type, int swapped) {
    int is_signed = type->kind == VTK_SIGNED;
    if (type->kind == VTK_REAL)
        return type->size == 4 ? (double)io_load_f32(at, swapped) : io_load_f64(at, swapped);
    switch (type->size) {
    case 1:
        return is_signed ? (double)(signed char)*at : (double)(unsigned char)*at;
    case 2:
        return is_signed ? (double)(int16_t)io_load_u16(at, swapped)
                         : (double)io_load_u16(at, swapped);
    case 4:
        return is_signed ? (double)io_load_i32(at, swapped) : (double)io_load_u32(at, swapped);
    default:
        return is_signed ? (double)io_load_i64(at, swapped) : (double)io_load_u64(at, swapped);
    }
}

static int hold_text(const struct array *array) {
    double value;
    for (int64_t i = 0; i < array->n * array->width; i++) {
        if (io_real(&array->reader->cursor, &value) != 0)
            return vtk_fail_here(array->reader, "the array \"fixed\": number expected");
        if (value != 0)
            io_hold_node(array->reader->model, i / array->width, IO_HELD_MARKED);
    }
    return 0;
}

static void hold_binary(const struct array *array) {
    const vtk_reader *reader = array->reader;
    const char *data = reader->cursor.at;
    for (int64_t i = 0; i < array->n * array->width; i++) {
        int set = array->type->kind == VTK_BIT ? ((unsigned char)data[i / 8] >> (7 - i % 8)) & 1
                                               : load_number(data + i * array->type->size,
                                                             array->type, reader->swapped) != 0;
        if (set)
            io_hold_node(reader->model, i / array->width, IO_HELD_MARKED);
    }
}

static int skip_numbers(vtk_reader *reader, int64_t n) {
    int64_t length = 1;
    for (int64_t i = 0; i < n && length > 0; i++)
        io_word(&reader->cursor, &length);
    return length > 0 ? 0 : vtk_fail_here(reader, "attributes are cut short");
}

/* Bytes of a string's length and text, or more than left: the two highest bits say how many bytes
 * the length has. */
static int64_t string_size(const char *at, int64_t left) {
    static const int bytes_of_length[4] = {8, 4, 2, 1};
    int bytes = bytes_of_length[(unsigned char)*at >> 6];
    if (bytes > left)
        return INT64_MAX;
    uint64_t length = (unsigned char)*at & 0x3f;
    for (int i = 1; i < bytes; i++)
        length = length << 8 | (unsigned char)at[i];
    return (int64_t)(length < (uint64_t)left ? length : (uint64_t)left) + bytes;
}

static int skip_strings(vtk_reader *reader, int64_t n) {
    io_cursor *cursor = &reader->cursor;
    for (int64_t i = 0; i < n; i++) {
        int64_t left = io_left(cursor);
        int64_t size = reader->binary && left > 0 ? string_size(cursor->at, left) : 0;
        if (left == 0 || size > left)
            return vtk_fail_here(reader, "attributes are cut short");
        if (reader->binary)
            cursor->at += size;
        else
            vtk_end_line(cursor);
    }
    return 0;
}

/* What an array is to planish. */
enum { NOTHING, FIXES, TELLS_REGIONS };

/* Number i of an array, which text has at the cursor; 0 or -1. */
static int take_number(const struct array *array, int64_t i, double *value) {
    vtk_reader *reader = array->reader;
    if (!reader->binary)
        return io_real(&reader->cursor, value);
    *value = load_number(reader->cursor.at + i * array->type->size, array->type, reader->swapped);
    return 0;
}

/* The regions of cells, unless they are no whole numbers. Binary: the cursor stays. */
static int read_regions(const struct array *array, int rank) {
    vtk_reader *reader = array->reader;
    int32_t *region = pl_alloc(array->n, sizeof *region);
    int whole = 1;
    if (region == NULL)
        return pl_fail_memory(reader->error, "the regions of cells");
    for (int64_t i = 0; i < array->n; i++) {
        double value;
        if (take_number(array, i, &value) != 0) {
            pl_free(region);
            return vtk_fail_here(reader, "cell data: number expected (the file may be cut short)");
        }
        whole &= vtk_region_of(value, &region[i]) == 0;
    }
    pl_free(whole ? reader->region : region);
    if (whole) {
        reader->region = region;
        reader->region_rank = rank;
    }
    return 0;
}

/* The numbers of an array at the cursor: the nodes it fixes, regions, or nothing. rank: of an array
 * that tells regions. */
static int read_array(const struct array *array, int use, int rank) {
    vtk_reader *reader = array->reader;
    const vtk_type *type = array->type;
    if (array->n < 0 || array->width < 0 ||
        (array->width > 0 && array->n > INT64_MAX / 16 / array->width))
        return vtk_fail_here(reader, "attributes: number of values is out of range");
    int64_t values = array->n * array->width;
    if (type->kind == VTK_STRING)
        return skip_strings(reader, values);
    if (!reader->binary && use != TELLS_REGIONS)
        return use == FIXES ? hold_text(array) : skip_numbers(reader, values);
    if (!reader->binary)
        return read_regions(array, rank);
    int64_t bytes = type->kind == VTK_BIT ? (values + 7) / 8 : values * type->size;
    if (bytes > io_left(&reader->cursor))
        return vtk_fail_here(reader, "attributes are cut short");
    int status = 0;
    if (use == FIXES)
        hold_binary(array);
    if (use == TELLS_REGIONS)
        status = read_regions(array, rank);
    reader->cursor.at += bytes;
    return status;
}

/* Whether an array of n tuples called name fixes nodes. */
static int is_fixed(const vtk_reader *reader, vtk_word name, int64_t n) {
    return reader->on_points && n == reader->model->n_nodes &&
           io_word_is(name.at, name.length, "fixed", 0);
}

/* The same for an array called name: whether it fixes nodes, or tells regions better than those
 * before it, is seen. */
static int read_named_array(const struct array *array, vtk_word name) {
    const vtk_reader *reader = array->reader;
    const int of_cells = !reader->on_points && reader->n_tuples >= 0 &&
                         array->n == reader->n_cells && array->width == 1 &&
                         array->type->kind != VTK_BIT;
    const int rank = of_cells ? vtk_region_rank(name.at, name.length) : 0;
    if (rank > 0 && (reader->region == NULL || rank < reader->region_rank))
        return read_array(array, TELLS_REGIONS, rank);
    return read_array(array, is_fixed(reader, name, array->n) ? FIXES : NOTHING, 0);
}

/* Unknown: what follows cannot be understood, but the mesh is there. */
int vtk_stop(vtk_reader *reader) {
    reader->done = reader->have_types;
    return reader->done ? 0
                        : vtk_fail_here(reader, "this is not understood, and no mesh came before");
}

/* An attribute of POINT_DATA or CELL_DATA whose line has words: name, type at type_word. */
static int read_attribute(vtk_reader *reader, const vtk_word *words, int n_words, int type_word,
                          int64_t width) {
    const vtk_type *type = type_word < n_words ? vtk_find_type(words[type_word]) : NULL;
    if (type == NULL || reader->n_tuples < 0)
        return vtk_stop(reader);
    struct array array = {reader, type, reader->n_tuples, width};
    return read_named_array(&array, words[0]);
}

int vtk_scalars(vtk_reader *reader) {
    vtk_word words[VTK_MAX_WORDS], ignored[VTK_MAX_WORDS];
    int64_t width = 1;
    int n = vtk_take_words(&reader->cursor, words);
    if (n > 2 && vtk_word_number(words[2], &width) != 0)
        return vtk_stop(reader);
    if (vtk_take_if(reader, "LOOKUP_TABLE"))
        vtk_take_words(&reader->cursor, ignored);
    return read_attribute(reader, words, n, 1, width);
}

int vtk_vectors(vtk_reader *reader) {
    vtk_word words[VTK_MAX_WORDS];
    int n = vtk_take_words(&reader->cursor, words);
    return read_attribute(reader, words, n, 1, 3);
}

int vtk_tensors(vtk_reader *reader) {
    vtk_word words[VTK_MAX_WORDS];
    int n = vtk_take_words(&reader->cursor, words);
    return read_attribute(reader, words, n, 1, 9);
}

int vtk_symmetric_tensors(vtk_reader *reader) {
    vtk_word words[VTK_MAX_WORDS];
    int n = vtk_take_words(&reader->cursor, words);
    return read_attribute(reader, words, n, 1, 6);
}

int vtk_ids(vtk_reader *reader) {
    vtk_word words[VTK_MAX_WORDS];
    int n = vtk_take_words(&reader->cursor, words);
    return read_attribute(reader, words, n, 1, 1);
}

int vtk_texture(vtk_reader *reader) {
    vtk_word words[VTK_MAX_WORDS];
    int64_t width;
    int n = vtk_take_words(&reader->cursor, words);
    if (n < 3 || vtk_word_number(words[1], &width) != 0)
        return vtk_stop(reader);
    return read_attribute(reader, words, n, 2, width);
}

/* Colours have no type: bytes where binary. n tuples of width. */
static int skip_colours(vtk_reader *reader, int64_t n, int64_t width) {
    static const vtk_type byte = {"unsigned_char", VTK_UNSIGNED, 1};
    struct array array = {reader, &byte, n, width};
    return read_array(&array, NOTHING, 0);
}

int vtk_colours(vtk_reader *reader) {
    vtk_word words[VTK_MAX_WORDS];
    int64_t width;
    int n = vtk_take_words(&reader->cursor, words);
    if (n < 2 || vtk_word_number(words[1], &width) != 0 || reader->n_tuples < 0)
        return vtk_stop(reader);
    return skip_colours(reader, reader->n_tuples, width);
}

int vtk_lookup_table(vtk_reader *reader) {
    vtk_word words[VTK_MAX_WORDS];
    int64_t size;
    int n = vtk_take_words(&reader->cursor, words);
    if (n < 2 || vtk_word_number(words[1], &size) != 0)
        return vtk_stop(reader);
    return skip_colours(reader, size, 4);
}

/* To the empty line that ends a METADATA block. */
int vtk_metadata(vtk_reader *reader) {
    vtk_word words[VTK_MAX_WORDS];
    vtk_end_line(&reader->cursor);
    while (io_left(&reader->cursor) > 0 && vtk_take_words(&reader->cursor, words) > 0)
        continue;
    return 0;
}

/* FIELD name n, and n arrays: name, width, tuples, type, and the numbers. */
int vtk_field(vtk_reader *reader) {
    vtk_word words[VTK_MAX_WORDS];
    int64_t n, width, tuples;
    if (vtk_take_words(&reader->cursor, words) < 2 || vtk_word_number(words[1], &n) != 0)
        return vtk_stop(reader);
    for (int64_t i = 0; i < n; i++) {
        io_skip_space(&reader->cursor);
        int n_words = vtk_take_words(&reader->cursor, words);
        if (n_words > 0 && io_word_is(words[0].at, words[0].length, "METADATA", 1)) {
            reader->cursor.at = words[0].at;
            vtk_metadata(reader);
            i--;
            continue;
        }
        const vtk_type *type = n_words < 4 ? NULL : vtk_find_type(words[3]);
        if (type == NULL || vtk_word_number(words[1], &width) != 0 ||
            vtk_word_number(words[2], &tuples) != 0)
            return vtk_stop(reader);
        struct array array = {reader, type, tuples, width};
        int status = read_named_array(&array, words[0]);
        if (status != 0)
            return status;
    }
    return 0;
}

static int begin_attributes(vtk_reader *reader, int on_points, int64_t n_expected) {
    int64_t n;
    if (!reader->have_types)
        return vtk_fail_here(reader, "attributes stand before the mesh is complete");
    if (io_integer(&reader->cursor, &n) != 0 || n != n_expected)
        return vtk_fail_here(reader,
                             "POINT_DATA or CELL_DATA: as many as points or cells expected");
    vtk_end_line(&reader->cursor);
    reader->n_tuples = n;
    reader->on_points = on_points;
    return 0;
}

int vtk_point_data(vtk_reader *reader) {
    return begin_attributes(reader, 1, reader->model->n_nodes);
}

int vtk_cell_data(vtk_reader *reader) {
    return begin_attributes(reader, 0, reader->n_cells);
}
