/* vtk_data: the attributes of legacy VTK files: "fixed" holds nodes, arrays of one number per cell
 * may tell regions; the places of all arrays of numbers are noted (data.h).
 *
 * The extent of any attribute must be known, to find the keyword behind it.
 */
#include "io/vtk/vtk_reader.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/arrays.h"
#include "io/core/data.h"
#include "io/vtk/vtk_numbers.h"

#include <stdio.h>
#include <string.h>

/* ---- words and strings -------------------------------------------------------------------- */

enum { MAX_WORDS = 8 };

int vtk_fail_here(const vtk_reader *reader, const char *text) {
    return io_fail_at(reader->model, reader->cursor.at, reader->error, "%s", text);
}

void vtk_end_line(io_cursor *cursor) {
    const char *newline = memchr(cursor->at, '\n', (size_t)io_left(cursor));
    cursor->at = newline ? newline + 1 : cursor->end;
}

int vtk_take_if(vtk_reader *reader, const char *name) {
    io_cursor ahead = reader->cursor;
    const io_slice word = io_next_word(&ahead);
    if ((reader->model->is_binary && word.begin != reader->cursor.at) ||
        !io_slice_is(word, name, 1))
        return 0;
    reader->cursor = ahead;
    return 1;
}

/** Take the words of the rest of this line, at most MAX_WORDS; the cursor goes to the next line. */
static int take_words(io_cursor *cursor, io_slice *words) {
    io_cursor line = *cursor;
    int n = 0;
    vtk_end_line(cursor);
    line.end = cursor->at;
    while (n < MAX_WORDS && io_slice_length(words[n] = io_next_word(&line)) > 0)
        n++;
    return n;
}

static int skip_words(vtk_reader *reader, int64_t n) {
    for (int64_t i = 0; i < n; i++)
        if (io_slice_length(io_next_word(&reader->cursor)) == 0)
            return vtk_fail_here(reader, "attributes are cut short");
    return PLANISH_OK;
}

/** Skip n strings. The two highest bits of a binary one say how many bytes its length has. */
static int skip_strings(vtk_reader *reader, int64_t n) {
    static const int bytes_of_length[4] = {8, 4, 2, 1};
    io_cursor *cursor = &reader->cursor;
    for (int64_t i = 0; i < n; i++) {
        const unsigned char *at = (const unsigned char *)cursor->at;
        const int64_t left = io_left(cursor);
        const int bytes = reader->model->is_binary && left > 0 ? bytes_of_length[at[0] >> 6] : 0;
        if (left == 0 || bytes > left)
            return vtk_fail_here(reader, "attributes are cut short");
        if (bytes == 0) {
            vtk_end_line(cursor);
            continue;
        }
        uint64_t length = at[0] & 0x3f;
        for (int k = 1; k < bytes; k++)
            length = length << 8 | at[k];
        if (length > (uint64_t)(left - bytes))
            return vtk_fail_here(reader, "attributes are cut short");
        cursor->at += bytes + (int64_t)length;
    }
    return PLANISH_OK;
}

/* ---- arrays ------------------------------------------------------------------------------- */

/** One array of attributes; binary values stand at the cursor of the reader. */
typedef struct value_array {
    vtk_reader *reader;
    const vtk_type *type;
    int64_t n;     /* tuples */
    int64_t width; /* numbers of a tuple */
} value_array;

/** Number i of an array, of text the next one: 1 whole, 0 another one, -1 none. */
static int next_whole(const value_array *array, int64_t i, int64_t *value) {
    io_cursor *cursor = &array->reader->cursor;
    double real;
    if (array->reader->model->is_binary)
        return vtk_whole(cursor->at, i, array->type, array->reader->swapped, value);
    if (!io_integer(cursor, value))
        return 1;
    return !io_real(cursor, &real) ? io_array_whole(real, value) : -1;
}

/** Hold the nodes that the array fixes. */
static int hold_nodes(const value_array *array) {
    for (int64_t i = 0; i < array->n * array->width; i++) {
        int64_t value;
        const int whole = next_whole(array, i, &value);
        if (whole < 0)
            return vtk_fail_here(array->reader, "the array \"fixed\": number expected");
        if (!whole || value != 0)
            io_hold_node(array->reader->model, i / array->width, IO_HELD_MARKED);
    }
    return PLANISH_OK;
}

/** Read one number for each cell, which may tell regions. */
static int read_cells_array(const value_array *array, const char *name) {
    vtk_reader *reader = array->reader;
    const int is_known = planish_rank_region_name(name) > 0;
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
    if (!status && !reader->model->is_binary)
        status = skip_words(reader, array->n - i);
    if (!status)
        return io_array_end(reader->model, &filler, reader->error);
    io_array_drop(&filler);
    return status;
}

static int hexadecimal(char c) {
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
                                  : -1;
}

/** Make the text of a name: VTK writes blanks and the like as %20. To be released by pl_free. */
static char *name_of(io_slice name) {
    const int64_t length = io_slice_length(name);
    char *text = pl_alloc(length + 1, 1);
    int64_t n = 0;
    for (int64_t i = 0; text && i < length; i++) {
        const int is_coded = name.begin[i] == '%' && i + 2 < length;
        const int high = is_coded ? hexadecimal(name.begin[i + 1]) : -1;
        const int low = is_coded ? hexadecimal(name.begin[i + 2]) : -1;
        const int is_code = high >= 0 && low >= 0 && (high || low);
        text[n++] = is_code ? (char)(16 * high + low) : name.begin[i];
        i += is_code ? 2 : 0;
    }
    if (text)
        text[n] = '\0';
    return text;
}

/** Note the place of an array of nodes or cells, bytes long where it is binary. */
static int note_array(const value_array *array, char *name) {
    vtk_reader *reader = array->reader;
    const int64_t at = reader->cursor.at - reader->model->input.data;
    if (reader->n_tuples < 0 || array->type->size == 0)
        return PLANISH_OK;
    return io_data_note(reader->model,
                        (io_data){.name = name,
                                  .of_elements = !reader->on_points,
                                  .width = array->width,
                                  .is_integer = array->type->kind <= VTK_UNSIGNED,
                                  .n = array->n,
                                  .n_cells = reader->grid.n,
                                  .begin = at,
                                  .swapped = reader->swapped,
                                  .type = array->type},
                        reader->error);
}

/** Read or pass over the numbers of an array of that name, in binary without leaving their place. */
static int read_named(const value_array *array, char *name) {
    vtk_reader *reader = array->reader;
    if (reader->on_points && array->n == reader->model->n_nodes && strcmp(name, "fixed") == 0)
        return hold_nodes(array);
    const int status = note_array(array, name);
    if (status)
        return status;
    if (!reader->on_points && reader->n_tuples >= 0 && array->n == reader->grid.n &&
        array->width == 1)
        return read_cells_array(array, name);
    return reader->model->is_binary ? PLANISH_OK : skip_words(reader, array->n * array->width);
}

/** Read the numbers of an array at the cursor: the nodes it fixes, regions, or nothing. An array
 *  without a name (empty) is passed over. */
static int read_array(const value_array *array, io_slice name) {
    vtk_reader *reader = array->reader;
    const int is_binary = reader->model->is_binary;
    if (array->n < 0 || array->width < 0 ||
        (array->width > 0 && array->n > INT64_MAX / 16 / array->width))
        return vtk_fail_here(reader, "attributes: number of values is out of range");
    const int64_t values = array->n * array->width;
    const int64_t bytes =
        array->type->kind == VTK_BIT ? (values + 7) / 8 : values * array->type->size;
    if (array->type->kind == VTK_STRING)
        return skip_strings(reader, values);
    if (is_binary && bytes > io_left(&reader->cursor))
        return vtk_fail_here(reader, "attributes are cut short");
    int status = PLANISH_OK;
    if (io_slice_length(name) > 0) {
        char *text = name_of(name);
        status =
            text ? read_named(array, text) : pl_fail_memory(reader->error, "the name of an array");
        pl_free(text);
    } else if (!is_binary) {
        status = skip_words(reader, values);
    }
    if (is_binary)
        reader->cursor.at += bytes;
    return status;
}

/* ---- keywords ----------------------------------------------------------------------------- */

/** Stop at something unknown: the end if the mesh is there, an error if it is not. */
static int stop_reading(vtk_reader *reader) {
    reader->done = reader->have_types;
    return reader->done ? PLANISH_OK
                        : vtk_fail_here(reader, "this is not understood, and no mesh came before");
}

/** Skip to the empty line that ends a METADATA block. */
static int skip_metadata(vtk_reader *reader) {
    io_slice words[MAX_WORDS];
    vtk_end_line(&reader->cursor);
    while (io_left(&reader->cursor) > 0 && take_words(&reader->cursor, words) > 0)
        continue;
    return PLANISH_OK;
}

/** Read FIELD name n, and n arrays: name, width, tuples, type, and the numbers. */
static int read_field(vtk_reader *reader) {
    io_slice words[MAX_WORDS];
    int64_t n, width, tuples;
    if (take_words(&reader->cursor, words) < 2 || io_slice_integer(words[1], &n))
        return stop_reading(reader);
    while (n > 0) {
        io_skip_space(&reader->cursor);
        const int n_words = take_words(&reader->cursor, words);
        if (n_words > 0 && io_slice_is(words[0], "METADATA", 1)) {
            reader->cursor.at = words[0].begin;
            skip_metadata(reader);
            continue;
        }
        const vtk_type *type = n_words < 4 ? NULL : vtk_find_type(words[3]);
        if (!type || io_slice_integer(words[1], &width) || io_slice_integer(words[2], &tuples))
            return stop_reading(reader);
        const value_array array = {reader, type, tuples, width};
        const int status = read_array(&array, words[0]);
        if (status)
            return status;
        n--;
    }
    return PLANISH_OK;
}

/** A keyword of one array. The words behind it are a name, and by their index: */
typedef struct attribute {
    const char *name;
    int type;     /* its type; 0: bytes where binary, and the array is passed over, */
    int n_tuples; /* the number of tuples; 0: as many as points or cells, */
    int width;    /* the numbers of a tuple; 0: see usual */
    int usual;    /* numbers of a tuple, if no word says them; 0: one must */
} attribute;

static const attribute attributes[] = {
    {"SCALARS", 1, 0, 2, 1},       {"VECTORS", 1, 0, 0, 3},
    {"NORMALS", 1, 0, 0, 3},       {"TENSORS", 1, 0, 0, 9},
    {"TENSORS6", 1, 0, 0, 6},      {"TEXTURE_COORDINATES", 2, 0, 1, 0},
    {"COLOR_SCALARS", 0, 0, 1, 0}, {"LOOKUP_TABLE", 0, 1, 0, 4},
    {"GLOBAL_IDS", 1, 0, 0, 1},    {"PEDIGREE_IDS", 1, 0, 0, 1},
    {"EDGE_FLAGS", 1, 0, 0, 1},
};

static int read_attribute(vtk_reader *reader, const attribute *a) {
    static const vtk_type byte = {"unsigned_char", VTK_UNSIGNED, 1};
    static const io_slice no_name = {NULL, NULL};
    io_slice words[MAX_WORDS], ignored[MAX_WORDS];
    value_array array = {reader, &byte, reader->n_tuples, a->usual};
    const int n = take_words(&reader->cursor, words);
    if (n <= a->type || n <= a->n_tuples || (!a->usual && n <= a->width) ||
        (a->n_tuples && io_slice_integer(words[a->n_tuples], &array.n)) ||
        (a->width && n > a->width && io_slice_integer(words[a->width], &array.width)))
        return stop_reading(reader);
    if (a->width == 2 && vtk_take_if(reader, "LOOKUP_TABLE")) /* the second line of SCALARS */
        take_words(&reader->cursor, ignored);
    array.type = a->type ? vtk_find_type(words[a->type]) : &byte;
    if (!array.type || (!a->n_tuples && reader->n_tuples < 0))
        return stop_reading(reader);
    return read_array(&array, a->type ? words[0] : no_name);
}

int vtk_read_data(vtk_reader *reader, io_slice keyword) {
    const int on_points = io_slice_is(keyword, "POINT_DATA", 1);
    if (on_points || io_slice_is(keyword, "CELL_DATA", 1)) {
        int64_t n;
        if (!reader->have_types)
            return vtk_fail_here(reader, "attributes stand before the mesh is complete");
        if (io_integer(&reader->cursor, &n) ||
            n != (on_points ? reader->model->n_nodes : reader->grid.n))
            return vtk_fail_here(reader,
                                 "POINT_DATA or CELL_DATA: as many as points or cells expected");
        vtk_end_line(&reader->cursor);
        reader->n_tuples = n;
        reader->on_points = on_points;
        return PLANISH_OK;
    }
    if (io_slice_is(keyword, "FIELD", 1))
        return read_field(reader);
    if (io_slice_is(keyword, "METADATA", 1))
        return skip_metadata(reader);
    for (size_t i = 0; i < sizeof attributes / sizeof *attributes; i++)
        if (io_slice_is(keyword, attributes[i].name, 1))
            return read_attribute(reader, &attributes[i]);
    reader->cursor.at = keyword.begin;
    return stop_reading(reader);
}

/* ---- values ------------------------------------------------------------------------------- */

/** Read all values of an array to all [n][width], and check that there are as many as should be. */
static int read_all(const io_model *model, const io_data *data, int64_t n_wanted, double *all,
                    planish_error *error) {
    const vtk_type *type = data->type;
    vtk_list list = {.model = model,
                     .name = data->name,
                     .type = model->is_binary ? type : NULL,
                     .swapped = data->swapped,
                     .real = all};
    io_cursor cursor = {model->input.data + data->begin, io_input_end(model)};
    char text[128];
    snprintf(text, sizeof text, "it has %lld values for %lld %s", (long long)data->n,
             (long long)n_wanted, data->of_elements ? "cells" : "points");
    if (data->n != n_wanted)
        return io_data_fail(model, data, data->begin, error, text);
    io_text words;
    io_text_init(&words, model);
    const int status = io_records(&words, &cursor, data->n * data->width, 1, type->size,
                                  vtk_read_list, &list, error);
    io_text_release(&words);
    return status;
}

int vtk_read_values(io_model *model, const io_data *data, double *values, planish_error *error) {
    const int64_t n = data->of_elements ? data->n_cells : model->n_nodes;
    double *all = data->of_elements ? pl_alloc(n * data->width, sizeof *all) : values;
    int status =
        all ? read_all(model, data, n, all, error) : pl_fail_memory(error, "an array of the file");
    if (!status && data->of_elements)
        io_data_pick(model, all, n, data->width, values);
    if (!status)
        vtk_order_tensors(values, data->of_elements ? io_model_n_elements(model) : n, data->width);
    if (data->of_elements)
        pl_free(all);
    return status;
}
