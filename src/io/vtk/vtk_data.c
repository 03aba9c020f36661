/* vtk_data: the attributes of legacy VTK files: "fixed" holds nodes, arrays of one number per cell
 * may tell regions, all others are passed over.
 *
 * Their extent must be known all the same, to find the keyword behind them.
 */
#include "io/vtk/vtk.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/arrays.h"
#include "io/core/binary.h"

/** One array of attributes. */
typedef struct value_array {
    vtk_reader *reader;
    const vtk_type *type;
    int64_t n;     /* tuples */
    int64_t width; /* numbers of a tuple */
} value_array;

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

static int hold_text(const value_array *array) {
    double value;
    for (int64_t i = 0; i < array->n * array->width; i++) {
        if (io_real(&array->reader->cursor, &value))
            return vtk_fail_here(array->reader, "the array \"fixed\": number expected");
        if (value != 0)
            io_hold_node(array->reader->model, i / array->width, IO_HELD_MARKED);
    }
    return 0;
}

static void hold_binary(const value_array *array) {
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

/** Bytes of a string's length and text, or more than left: the two highest bits say how many bytes
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
        int64_t size = reader->model->is_binary && left > 0 ? string_size(cursor->at, left) : 0;
        if (left == 0 || size > left)
            return vtk_fail_here(reader, "attributes are cut short");
        if (reader->model->is_binary)
            cursor->at += size;
        else
            vtk_end_line(cursor);
    }
    return 0;
}

/** What an array is to planish. */
typedef enum purpose { NOTHING, FIXES, MAY_TELL_REGIONS } purpose;

/** Number i of a binary array as a whole number: 1, or 0 if it is none. */
static int load_whole(const value_array *array, int64_t i, int64_t *value) {
    const vtk_type *type = array->type;
    const int swapped = array->reader->swapped;
    const char *at = array->reader->cursor.at;
    if (type->kind == VTK_BIT) {
        *value = ((unsigned char)at[i / 8] >> (7 - i % 8)) & 1;
        return 1;
    }
    at += i * type->size;
    if (type->kind == VTK_REAL)
        return io_array_whole(load_number(at, type, swapped), value);
    if (type->size < 8)
        *value = (int64_t)load_number(at, type, swapped);
    else
        *value = io_load_i64(at, swapped); /* unsigned ones by their bits */
    return 1;
}

/** The next number of text: 1 whole, 0 another one, -1 none. */
static int take_whole(io_cursor *cursor, int64_t *value) {
    double real;
    if (!io_integer(cursor, value))
        return 1;
    return !io_real(cursor, &real) ? io_array_whole(real, value) : -1;
}

/** Number i of an array: as take_whole. */
static int next_whole(const value_array *array, int64_t i, int64_t *value) {
    vtk_reader *reader = array->reader;
    return reader->model->is_binary ? load_whole(array, i, value)
                                    : take_whole(&reader->cursor, value);
}

/** What of text an array that is no candidate any more leaves. */
static int skip_rest(const value_array *array, int64_t n_done) {
    vtk_reader *reader = array->reader;
    return reader->model->is_binary ? 0 : skip_numbers(reader, array->n - n_done);
}

/** One number for each cell, which may tell regions. name: as text. Binary: the cursor stays. */
static int read_cells_array(const value_array *array, const char *name) {
    vtk_reader *reader = array->reader;
    const int is_known = planish_region_name(name) > 0;
    io_array_filler filler;
    int64_t i = 0;
    int status = io_array_begin(reader->model, name, array->n, &filler, reader->error);
    for (; i < array->n && !status && !filler.is_broken; i++) {
        int64_t value = 0;
        const int whole = next_whole(array, i, &value);
        if (whole < 0 && is_known)
            status =
                vtk_fail_here(reader, "cell data: number expected (the file may be cut short)");
        else if (whole < 0)
            break; /* words, it seems: they are passed over */
        else
            status = io_array_put(&filler, i, whole, value, reader->error);
    }
    filler.is_broken |= i < array->n;
    if (!status)
        status = skip_rest(array, i);
    if (!status)
        return io_array_end(reader->model, &filler, reader->error);
    io_array_drop(&filler);
    return status;
}

/** The bytes of a binary array; more than are left on failure. */
static int64_t bytes_of(const value_array *array) {
    const int64_t values = array->n * array->width;
    return array->type->kind == VTK_BIT ? (values + 7) / 8 : values * array->type->size;
}

/** The numbers of an array at the cursor: the nodes it fixes, regions, or nothing. name: of an
 * array that may tell regions. */
static int read_array(const value_array *array, purpose use, const char *name) {
    vtk_reader *reader = array->reader;
    int status = 0;
    if (array->n < 0 || array->width < 0 ||
        (array->width > 0 && array->n > INT64_MAX / 16 / array->width))
        return vtk_fail_here(reader, "attributes: number of values is out of range");
    if (array->type->kind == VTK_STRING)
        return skip_strings(reader, array->n * array->width);
    if (!reader->model->is_binary)
        return use == FIXES     ? hold_text(array)
               : use == NOTHING ? skip_numbers(reader, array->n * array->width)
                                : read_cells_array(array, name);
    if (bytes_of(array) > io_left(&reader->cursor))
        return vtk_fail_here(reader, "attributes are cut short");
    if (use == FIXES)
        hold_binary(array);
    if (use == MAY_TELL_REGIONS)
        status = read_cells_array(array, name);
    reader->cursor.at += bytes_of(array);
    return status;
}

/** Whether an array of n tuples called name fixes nodes. */
static int is_fixed(const vtk_reader *reader, vtk_word name, int64_t n) {
    return reader->on_points && n == reader->model->n_nodes &&
           io_word_is(name.at, name.length, "fixed", 0);
}

static int hexadecimal(char c) {
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
                                  : -1;
}

/** The text of a name: VTK writes blanks and the like as %20. To be released by pl_free. */
static char *name_of(vtk_word name) {
    char *text = pl_alloc(name.length + 1, 1);
    int64_t n = 0;
    for (int64_t i = 0; text && i < name.length; i++) {
        const int is_coded = name.at[i] == '%' && i + 2 < name.length;
        const int high = is_coded ? hexadecimal(name.at[i + 1]) : -1;
        const int low = is_coded ? hexadecimal(name.at[i + 2]) : -1;
        const int is_code = high >= 0 && low >= 0 && (high || low);
        text[n++] = is_code ? (char)(16 * high + low) : name.at[i];
        i += is_code ? 2 : 0;
    }
    if (text)
        text[n] = '\0';
    return text;
}

/** The same for an array called name: whether it fixes nodes, or may tell regions, is seen. */
static int read_named_array(const value_array *array, vtk_word name) {
    const vtk_reader *reader = array->reader;
    const int of_cells = !reader->on_points && reader->n_tuples >= 0 &&
                         array->n == reader->n_cells && array->width == 1 &&
                         array->type->kind != VTK_STRING;
    if (!of_cells)
        return read_array(array, is_fixed(reader, name, array->n) ? FIXES : NOTHING, NULL);
    char *text = name_of(name);
    if (!text)
        return pl_fail_memory(reader->error, "the name of an array");
    const int status = read_array(array, MAY_TELL_REGIONS, text);
    pl_free(text);
    return status;
}

/** Unknown: what follows cannot be understood, but the mesh is there. */
int vtk_stop(vtk_reader *reader) {
    reader->done = reader->have_types;
    return reader->done ? 0
                        : vtk_fail_here(reader, "this is not understood, and no mesh came before");
}

/** An attribute of POINT_DATA or CELL_DATA whose line has words: name, type at type_word. */
static int read_attribute(vtk_reader *reader, const vtk_word *words, int n_words, int type_word,
                          int64_t width) {
    const vtk_type *type = type_word < n_words ? vtk_find_type(words[type_word]) : NULL;
    if (!type || reader->n_tuples < 0)
        return vtk_stop(reader);
    value_array array = {reader, type, reader->n_tuples, width};
    return read_named_array(&array, words[0]);
}

int vtk_scalars(vtk_reader *reader) {
    vtk_word words[VTK_MAX_WORDS], ignored[VTK_MAX_WORDS];
    int64_t width = 1;
    int n = vtk_take_words(&reader->cursor, words);
    if (n > 2 && vtk_word_number(words[2], &width))
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
    if (n < 3 || vtk_word_number(words[1], &width))
        return vtk_stop(reader);
    return read_attribute(reader, words, n, 2, width);
}

/** Colours have no type: bytes where binary. n tuples of width. */
static int skip_colours(vtk_reader *reader, int64_t n, int64_t width) {
    static const vtk_type byte = {"unsigned_char", VTK_UNSIGNED, 1};
    value_array array = {reader, &byte, n, width};
    return read_array(&array, NOTHING, NULL);
}

int vtk_colours(vtk_reader *reader) {
    vtk_word words[VTK_MAX_WORDS];
    int64_t width;
    int n = vtk_take_words(&reader->cursor, words);
    if (n < 2 || vtk_word_number(words[1], &width) || reader->n_tuples < 0)
        return vtk_stop(reader);
    return skip_colours(reader, reader->n_tuples, width);
}

int vtk_lookup_table(vtk_reader *reader) {
    vtk_word words[VTK_MAX_WORDS];
    int64_t size;
    int n = vtk_take_words(&reader->cursor, words);
    if (n < 2 || vtk_word_number(words[1], &size))
        return vtk_stop(reader);
    return skip_colours(reader, size, 4);
}

/** To the empty line that ends a METADATA block. */
int vtk_metadata(vtk_reader *reader) {
    vtk_word words[VTK_MAX_WORDS];
    vtk_end_line(&reader->cursor);
    while (io_left(&reader->cursor) > 0 && vtk_take_words(&reader->cursor, words) > 0)
        continue;
    return 0;
}

/** FIELD name n, and n arrays: name, width, tuples, type, and the numbers. */
int vtk_field(vtk_reader *reader) {
    vtk_word words[VTK_MAX_WORDS];
    int64_t n, width, tuples;
    if (vtk_take_words(&reader->cursor, words) < 2 || vtk_word_number(words[1], &n))
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
        if (!type || vtk_word_number(words[1], &width) || vtk_word_number(words[2], &tuples))
            return vtk_stop(reader);
        value_array array = {reader, type, tuples, width};
        int status = read_named_array(&array, words[0]);
        if (status)
            return status;
    }
    return 0;
}

static int begin_attributes(vtk_reader *reader, int on_points, int64_t n_expected) {
    int64_t n;
    if (!reader->have_types)
        return vtk_fail_here(reader, "attributes stand before the mesh is complete");
    if (io_integer(&reader->cursor, &n) || n != n_expected)
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
