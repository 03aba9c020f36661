/* gmsh_data: the values of $ElementData that may tell regions; and over the values of $NodeData,
 * $ElementData and $ElementNodeData in binary files.
 *
 * Bytes of binary values could be anything, the mark of the section's end among them; and not every
 * program begins a line for that mark. So they are passed over by their count, as Gmsh does.
 *
 * A section: number of texts and these, a line each, the first is the name; number of reals and
 * these; number of whole numbers and these: step, values of a node or element, nodes or elements,
 * ...; and the values: a number (int32), for $ElementNodeData how many nodes follow (int32), and
 * doubles.
 *
 * In go sections of one value per element, where they stand; out come arrays (arrays.h). Of each
 * name the first time step is read. Sections of the same name and step fill one array until each
 * element that is smoothed has a value: parts of a partition write so. Numbers of other elements do
 * not matter.
 */
#include "io/gmsh/gmsh_reader.h"

#include <string.h>

#include "base/memory.h"
#include "base/status.h"
#include "io/core/arrays.h"
#include "io/core/binary.h"

enum { STEP, WIDTH, COUNT, N_WANTED };

enum {
    LARGEST_HEAD = 1 << 16, /* bytes that are looked at for what stands before the values */
    TEXT_SIZE = 4,          /* bytes of the shortest value with its number: "1 0" and a line end */
    BINARY_SIZE = 4 + 8,
    BLOCK = 1 << 20 /* values that are read at once */
};

/* ---- what stands before the values ------------------------------------------------------------
 */

/** What stands there. */
typedef struct data_head {
    const char *name; /* [length] */
    int64_t length;
    int64_t step, width, count;
} data_head;

/** The name in a line: what is in its quotes, or the line without blanks around it. */
static void take_name(io_cursor *cursor, data_head *head) {
    const char *end, *begin = io_line(cursor, &end);
    const char *quote = memchr(begin, '"', (size_t)(end - begin));
    if (quote) {
        begin = quote + 1;
        quote = memchr(begin, '"', (size_t)(end - begin));
        end = quote ? quote : end;
    }
    while (begin < end && (unsigned char)*begin <= ' ')
        begin++;
    while (begin < end && (unsigned char)end[-1] <= ' ')
        end--;
    head->name = begin;
    head->length = end - begin;
}

/** Over the texts and reals before the whole numbers; 0 or -1. */
static int take_tags(io_cursor *cursor, data_head *head) {
    int64_t n;
    double real;
    if (io_integer(cursor, &n) || n < 0 || n > io_left(cursor))
        return -1;
    io_skip_line(cursor);
    if (n > 0)
        take_name(cursor, head);
    for (int64_t i = 1; i < n; i++)
        io_skip_line(cursor);
    if (io_integer(cursor, &n))
        return -1;
    for (int64_t i = 0; i < n; i++)
        if (io_real(cursor, &real))
            return -1;
    return 0;
}

/** The cursor ends behind the last whole number, if the values are binary behind its line. 0 or -1.
 */
static int take_head(io_cursor *cursor, int binary, data_head *head) {
    int64_t n, number[N_WANTED] = {0}, value;
    io_cursor at = *cursor;
    if (io_left(&at) > LARGEST_HEAD)
        at.end = at.at + LARGEST_HEAD;
    *head = (data_head){.name = "ElementData", .length = (int64_t)strlen("ElementData")};
    if (take_tags(&at, head) || io_integer(&at, &n) || n < N_WANTED)
        return -1;
    for (int64_t i = 0; i < n; i++) {
        if (io_integer(&at, &value))
            return -1;
        if (i < N_WANTED)
            number[i] = value;
    }
    if (binary)
        io_skip_line(&at);
    cursor->at = at.at;
    head->step = number[STEP];
    head->width = number[WIDTH];
    head->count = number[COUNT];
    return head->width >= 0 && head->width <= INT32_MAX && head->count >= 0 ? 0 : -1;
}

/* ---- over binary values -----------------------------------------------------------------------
 */

/** Over as many bytes; 0 or -1. */
static int skip_bytes(io_cursor *cursor, int64_t n) {
    if (n > io_left(cursor))
        return -1;
    cursor->at += n;
    return 0;
}

static int skip_values(io_cursor *cursor, int64_t width, int64_t count) {
    const int64_t size = 4 + 8 * width;
    return count > io_left(cursor) / size ? -1 : skip_bytes(cursor, count * size);
}

static int skip_values_of_nodes(io_cursor *cursor, int64_t width, int64_t count, int swapped) {
    for (int64_t i = 0; i < count; i++) {
        if (io_left(cursor) < 8)
            return -1;
        const int64_t nodes = io_load_i32(cursor->at + 4, swapped);
        cursor->at += 8;
        if (nodes < 0 || (width > 0 && nodes > io_left(cursor) / (8 * width)))
            return -1;
        cursor->at += 8 * width * nodes;
    }
    return 0;
}

int gmsh_skip_data(gmsh_reader *reader, int with_nodes) {
    io_cursor cursor = reader->cursor;
    data_head head;
    int status = take_head(&cursor, 1, &head);
    if (!status)
        status = with_nodes ? skip_values_of_nodes(&cursor, head.width, head.count, reader->swapped)
                            : skip_values(&cursor, head.width, head.count);
    if (!status)
        reader->cursor = cursor;
    return status;
}

/* ---- sections that may tell regions -----------------------------------------------------------
 */

static int is_same_name(const gmsh_data *a, const gmsh_data *b) {
    return a->length == b->length && memcmp(a->name, b->name, (size_t)a->length) == 0;
}

/** Whether a section of the same name, but of another time step, came before. */
static int is_later_step(const gmsh_reader *reader, const gmsh_data *data) {
    for (int64_t i = 0; i < reader->n_data; i++)
        if (is_same_name(&reader->data[i], data))
            return reader->data[i].step != data->step;
    return 0;
}

int gmsh_note_data(gmsh_reader *reader, const char *begin, const char *end) {
    io_cursor cursor = {begin, end};
    data_head head;
    if (take_head(&cursor, reader->model->is_binary, &head) || head.width != 1)
        return 0;
    const gmsh_data data = {.name = head.name,
                            .length = head.length,
                            .step = head.step,
                            .n = head.count,
                            .values = cursor.at,
                            .end = end};
    if (reader->n_data == IO_MOST_ARRAYS || is_later_step(reader, &data))
        return 0;
    gmsh_data *grown = pl_grow(reader->data, reader->n_data, reader->n_data + 1,
                               &reader->data_capacity, sizeof *grown);
    if (!grown)
        return pl_fail_memory(reader->error, "the arrays of cells");
    reader->data = grown;
    reader->data[reader->n_data++] = data;
    return 0;
}

/* ---- their values -----------------------------------------------------------------------------
 */

/** A block of values, and what finds the elements that they are of. */
typedef struct data_values {
    gmsh_reader *reader;
    const io_cells *elements;
    io_numbers *numbers; /* made when it is needed, owned */
    int64_t next;        /* the element behind that of the last value */
    int64_t *number;     /* [BLOCK], owned, of the element as the file has it, */
    int64_t *value;      /* [BLOCK], owned, */
    uint8_t *is_whole;   /* [BLOCK], owned */
} data_values;

static int read_text(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                     planish_error *error) {
    const data_values *v = context;
    double real;
    (void)error;
    for (int64_t i = begin; i < end; i++) {
        v->value[i] = 0;
        v->is_whole[i] = 1;
        if (io_integer(cursor, &v->number[i]))
            return PLANISH_ERROR_FORMAT;
        if (!io_integer(cursor, &v->value[i]))
            continue;
        if (io_real(cursor, &real))
            return PLANISH_ERROR_FORMAT;
        v->is_whole[i] = (uint8_t)io_array_whole(real, &v->value[i]);
    }
    return 0;
}

static int read_binary(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                       planish_error *error) {
    const data_values *v = context;
    const int swapped = v->reader->swapped;
    (void)error;
    for (int64_t i = begin; i < end; i++, cursor->at += BINARY_SIZE) {
        v->value[i] = 0;
        v->number[i] = io_load_i32(cursor->at, swapped);
        v->is_whole[i] =
            (uint8_t)io_array_whole(io_load_f64(cursor->at + 4, swapped), &v->value[i]);
    }
    return 0;
}

static int read_block(const data_values *v, io_cursor *cursor, int64_t n) {
    gmsh_reader *reader = v->reader;
    void *context = (void *)(uintptr_t)v;
    return reader->model->is_binary
               ? io_binary_records(reader->model->threads, cursor, n, BINARY_SIZE, read_binary,
                                   context, NULL)
               : io_text_records(&reader->text, cursor, n, 2, read_text, context, NULL);
}

/** The smoothed element of that number, or -1. Mostly values are in the order of the elements. */
static int find_element(data_values *v, int64_t number, int64_t *element) {
    const io_cells *cells = v->elements;
    if (!cells->number) {
        const uint64_t index = (uint64_t)number - (uint64_t)cells->first_number;
        *element = index < (uint64_t)cells->n ? (int64_t)index : -1;
        return 0;
    }
    if (v->next >= cells->n || cells->number[v->next] != number) {
        int status = 0;
        if (!v->numbers)
            status = io_numbers_create(v->reader->model->input.path, "element", cells->number,
                                       cells->n, &v->numbers, v->reader->error);
        if (status)
            return status;
        *element = io_numbers_find(v->numbers, number);
    } else {
        *element = v->next;
    }
    v->next = *element >= 0 ? *element + 1 : v->next;
    return 0;
}

static int put_block(data_values *v, int64_t n, io_array_filler *filler) {
    int status = 0;
    for (int64_t i = 0; i < n && !status; i++) {
        int64_t element;
        status = find_element(v, v->number[i], &element);
        if (!status && element >= 0)
            status = io_array_put_element(filler, element, v->is_whole[i], v->value[i],
                                          v->reader->error);
    }
    return status;
}

/** Put the values of a section, up to a block with one that is not whole. _FORMAT: it is malformed.
 */
static int put_section(data_values *v, const gmsh_data *data, io_array_filler *filler) {
    /* Text may be read by threads, which need all of the file before them; it ends at the mark. */
    io_cursor cursor = {data->values,
                        v->reader->model->is_binary ? data->end : v->reader->text.end};
    const int64_t size = v->reader->model->is_binary ? BINARY_SIZE : TEXT_SIZE;
    if (data->n > (data->end - data->values) / size)
        return PLANISH_ERROR_FORMAT;
    v->next = 0;
    for (int64_t done = 0; done < data->n && !filler->is_broken;) {
        const int64_t n = data->n - done < BLOCK ? data->n - done : BLOCK;
        int status = read_block(v, &cursor, n);
        if (!status)
            status = put_block(v, n, filler);
        if (status)
            return status;
        done += n;
    }
    return 0;
}

/* ---- arrays of them ---------------------------------------------------------------------------
 */

static int begin_array(const gmsh_reader *reader, const gmsh_data *data, io_array_filler *filler) {
    char *name = pl_alloc(data->length + 1, 1);
    if (!name)
        return pl_fail_memory(reader->error, "the arrays of cells");
    memcpy(name, data->name, (size_t)data->length);
    name[data->length] = '\0';
    const int status = io_array_begin_elements(reader->model, name, filler, reader->error);
    pl_free(name);
    return status;
}

/** Put a section into the array that sections before it have begun, or into a new one. */
static int add_section(data_values *v, const gmsh_data *data, io_array_filler *filler) {
    gmsh_reader *reader = v->reader;
    int status = 0;
    if (filler->array.name && (filler->is_broken || io_array_is_full(filler)))
        status = io_array_end(reader->model, filler, reader->error);
    if (!status && !filler->array.name)
        status = begin_array(reader, data, filler);
    v->elements = filler->elements;
    if (!status)
        status = put_section(v, data, filler);
    if (status != PLANISH_ERROR_FORMAT)
        return status;
    io_array_drop(filler);
    return 0;
}

/** The arrays of all sections that have the name of section first, which is the first such. */
static int read_name(data_values *v, int64_t first) {
    gmsh_reader *reader = v->reader;
    io_array_filler filler = {.array = {.name = NULL}};
    int status = 0;
    for (int64_t i = first; i < reader->n_data && !status; i++) {
        if (!is_same_name(&reader->data[i], &reader->data[first]))
            continue;
        status = add_section(v, &reader->data[i], &filler);
    }
    if (!status && filler.array.name)
        return io_array_end(reader->model, &filler, reader->error);
    io_array_drop(&filler);
    return status;
}

static int is_first(const gmsh_reader *reader, int64_t i) {
    for (int64_t k = 0; k < i; k++)
        if (is_same_name(&reader->data[k], &reader->data[i]))
            return 0;
    return 1;
}

static int make_room(data_values *v) {
    int64_t most = 0;
    for (int64_t i = 0; i < v->reader->n_data; i++)
        most = v->reader->data[i].n > most ? v->reader->data[i].n : most;
    most = most < BLOCK ? most : BLOCK;
    v->number = pl_alloc(most, sizeof *v->number);
    v->value = pl_alloc(most, sizeof *v->value);
    v->is_whole = pl_alloc(most, sizeof *v->is_whole);
    return v->number && v->value && v->is_whole
               ? 0
               : pl_fail_memory(v->reader->error, "the arrays of cells");
}

int gmsh_read_data(gmsh_reader *reader) {
    data_values v = {.reader = reader};
    if (reader->n_data == 0)
        return 0;
    int status = make_room(&v);
    for (int64_t i = 0; i < reader->n_data && !status; i++)
        if (is_first(reader, i))
            status = read_name(&v, i);
    io_numbers_destroy(v.numbers);
    pl_free(v.number);
    pl_free(v.value);
    pl_free(v.is_whole);
    return status;
}
