/* gmsh_data: values of $ElementData that may tell regions; and how to skip the values of $NodeData,
 * $ElementData and $ElementNodeData in binary files.
 *
 * Binary values may have any bytes, the section's end mark among them, and not every program begins
 * a line for that mark. So the reader skips values by their count, as Gmsh does.
 *
 * A section has the number of texts and these, a line each, the first is the name; the number of
 * reals and these; the number of whole numbers and these: step, width of a value, number of values,
 * ...; and the values. A value is the number of its node or element (int32), for $ElementNodeData
 * the number of nodes (int32), and doubles.
 *
 * gmsh_note_data keeps the places of sections with one value per element; gmsh_read_data makes
 * arrays of them (arrays.h). Of each name only the first time step is read. Sections of the same
 * name and step fill one array until each element has a value: programs write the parts of
 * a partition so. Values of other elements are ignored.
 */
#include "io/gmsh/gmsh_sections.h"

#include <string.h>

#include "base/memory.h"
#include "base/status.h"
#include "io/core/arrays.h"

enum {
    LARGEST_HEAD = 1 << 16, /* bytes that are looked at for what stands before the values */
    TEXT_SIZE = 4,          /* bytes of the shortest value with its number: "1 0" and a line end */
    BINARY_SIZE = 4 + 8,
    BLOCK = 1 << 20 /* values that are read at once */
};

/** Read all before the values: texts, reals and whole numbers. data->values: behind the last of
 *  these, or in binary behind its line. Return 0 or -1. */
static int read_head(io_cursor cursor, int is_binary, gmsh_data *data) {
    enum { STEP, WIDTH, COUNT, N_WANTED };
    static const char no_name[] = "ElementData";
    int64_t n, number[N_WANTED] = {0}, ignored;
    double real;
    *data = (gmsh_data){.name = {no_name, no_name + sizeof no_name - 1}};
    if (io_left(&cursor) > LARGEST_HEAD)
        cursor.end = cursor.at + LARGEST_HEAD;
    if (io_integer(&cursor, &n) || n < 0 || n > io_left(&cursor))
        return -1;
    io_skip_line(&cursor);
    if (n > 0) { /* in quotes, or the line without blanks around it */
        io_slice line = io_next_line(&cursor);
        const char *quote = memchr(line.begin, '"', (size_t)io_slice_length(line));
        if (quote) {
            line.begin = quote + 1;
            quote = memchr(line.begin, '"', (size_t)io_slice_length(line));
            line.end = quote ? quote : line.end;
        }
        data->name = io_slice_trim(line);
    }
    for (int64_t i = 1; i < n; i++)
        io_skip_line(&cursor);
    if (io_integer(&cursor, &n))
        return -1;
    for (int64_t i = 0; i < n; i++)
        if (io_real(&cursor, &real))
            return -1;
    if (io_integer(&cursor, &n) || n < N_WANTED)
        return -1;
    for (int64_t i = 0; i < n; i++)
        if (io_integer(&cursor, i < N_WANTED ? &number[i] : &ignored))
            return -1;
    if (is_binary)
        io_skip_line(&cursor);
    data->step = number[STEP];
    data->width = number[WIDTH];
    data->n = number[COUNT];
    data->values = cursor.at;
    return data->width >= 0 && data->width <= INT32_MAX && data->n >= 0 ? 0 : -1;
}

int gmsh_skip_data(gmsh_reader *reader, int with_nodes) {
    const int64_t head = with_nodes ? 8 : 4; /* bytes before the numbers of a value */
    gmsh_data data;
    if (read_head(reader->cursor, 1, &data))
        return -1;
    io_cursor cursor = {data.values, reader->cursor.end};
    for (int64_t i = 0; i < data.n; i++) {
        if (io_left(&cursor) < head)
            return -1;
        const int64_t nodes = with_nodes ? io_load_i32(cursor.at + 4, reader->swapped) : 1;
        cursor.at += head;
        if (nodes < 0 || (data.width > 0 && nodes > io_left(&cursor) / (8 * data.width)))
            return -1;
        cursor.at += 8 * data.width * nodes;
    }
    reader->cursor = cursor;
    return 0;
}

static int is_same_name(const gmsh_data *a, const gmsh_data *b) {
    const int64_t length = io_slice_length(a->name);
    return length == io_slice_length(b->name) &&
           memcmp(a->name.begin, b->name.begin, (size_t)length) == 0;
}

int gmsh_note_data(gmsh_reader *reader, const char *begin, const char *end) {
    const io_cursor cursor = {begin, end};
    gmsh_data data;
    if (read_head(cursor, reader->model->is_binary, &data) || data.width != 1 ||
        reader->n_data == IO_MOST_ARRAYS)
        return PLANISH_OK;
    data.end = end;
    for (int64_t i = 0; i < reader->n_data; i++) {
        if (!is_same_name(&reader->data[i], &data))
            continue;
        if (reader->data[i].step != data.step) /* a later time */
            return PLANISH_OK;
        break;
    }
    return pl_append(&reader->data, &reader->n_data, &reader->data_capacity, &data, sizeof data)
               ? PLANISH_OK
               : pl_fail_memory(reader->error, "the arrays of cells");
}

/* ---- values ------------------------------------------------------------------------------- */

/** A block of values, and what finds the elements that they are of. */
typedef struct data_values {
    gmsh_reader *reader;
    io_list list[2];     /* the elements: simplices, others */
    io_numbers *numbers; /* made when it is needed, owned */
    int64_t next;        /* the element behind that of the last value */
    int64_t *number;     /* [BLOCK], owned, of the element as the file has it, */
    int64_t *value;      /* [BLOCK], owned, */
    uint8_t *is_whole;   /* [BLOCK], owned */
} data_values;

static int read_values(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                       planish_error *error) {
    const data_values *v = context;
    const int is_binary = v->reader->model->is_binary;
    double real;
    (void)error;
    for (int64_t i = begin; i < end; i++) {
        v->value[i] = 0;
        v->is_whole[i] = 1;
        if (io_number(cursor, is_binary ? 4 : 0, v->reader->swapped, &v->number[i]))
            return PLANISH_ERROR_FORMAT;
        if (is_binary) {
            real = io_load_f64(cursor->at, v->reader->swapped);
            cursor->at += 8;
        } else if (!io_integer(cursor, &v->value[i])) {
            continue;
        } else if (io_real(cursor, &real)) {
            return PLANISH_ERROR_FORMAT;
        }
        v->is_whole[i] = (uint8_t)io_array_whole(real, &v->value[i]);
    }
    return PLANISH_OK;
}

static int64_t number_of(const data_values *v, int64_t element) {
    const int64_t n = v->list[0].n;
    return element < n ? io_list_number(&v->list[0], element)
                       : io_list_number(&v->list[1], element - n);
}

/** Make the table of the numbers of elements. */
static int make_numbers(data_values *v, int64_t n) {
    int64_t *number = pl_alloc(n, sizeof *number);
    if (!number)
        return pl_fail_memory(v->reader->error, "the numbers of elements");
    for (int64_t i = 0; i < n; i++)
        number[i] = number_of(v, i);
    const int status = io_numbers_create(v->reader->model->input.path, "element", number, n,
                                         &v->numbers, v->reader->error);
    pl_free(number);
    return status;
}

/** Find the element of that number: its index or -1. Mostly values are in the order of the
 *  elements. */
static int find_element(data_values *v, int64_t number, int64_t *element) {
    const io_cells *cells = v->list[0].cells;
    const int64_t n = v->list[0].n + v->list[1].n;
    if (!cells->number && v->list[1].n == 0) {
        const uint64_t index = (uint64_t)number - (uint64_t)cells->first_number;
        *element = index < (uint64_t)cells->n ? (int64_t)index : -1;
        return PLANISH_OK;
    }
    *element = v->next;
    if (v->next >= n || number_of(v, v->next) != number) {
        const int status = v->numbers ? PLANISH_OK : make_numbers(v, n);
        if (status)
            return status;
        *element = io_numbers_find(v->numbers, number);
    }
    v->next = *element >= 0 ? *element + 1 : v->next;
    return PLANISH_OK;
}

/** Put the values of a section, up to a block with one that is not whole. Return _FORMAT if the
 *  section is malformed. */
static int put_section(data_values *v, const gmsh_data *data, io_array_filler *filler) {
    gmsh_reader *reader = v->reader;
    io_model *model = reader->model;
    /* Text may be read by threads, which need all of the file before them; it ends at the mark. */
    io_cursor cursor = {data->values, model->is_binary ? data->end : reader->text.end};
    if (data->n > (data->end - data->values) / (model->is_binary ? BINARY_SIZE : TEXT_SIZE))
        return PLANISH_ERROR_FORMAT;
    v->next = 0;
    for (int64_t done = 0; done < data->n && !filler->is_broken;) {
        const int64_t n = data->n - done < BLOCK ? data->n - done : BLOCK;
        int status =
            model->is_binary
                ? io_binary_records(model->threads, &cursor, n, BINARY_SIZE, read_values, v, NULL)
                : io_text_records(&reader->text, &cursor, n, 2, read_values, v, NULL);
        for (int64_t i = 0; i < n && !status; i++) {
            int64_t element;
            status = find_element(v, v->number[i], &element);
            if (!status && element >= 0)
                status = io_array_put_element(filler, element, v->is_whole[i], v->value[i],
                                              reader->error);
        }
        if (status)
            return status;
        done += n;
    }
    return PLANISH_OK;
}

/* ---- arrays ------------------------------------------------------------------------------- */

static int begin_array(const gmsh_reader *reader, const gmsh_data *data, io_array_filler *filler) {
    const int64_t length = io_slice_length(data->name);
    char *name = pl_alloc(length + 1, 1);
    if (!name)
        return pl_fail_memory(reader->error, "the arrays of cells");
    memcpy(name, data->name.begin, (size_t)length);
    name[length] = '\0';
    const int status = io_array_begin_elements(reader->model, name, filler, reader->error);
    pl_free(name);
    return status;
}

/** Make the arrays of all sections that have the name of section first, which is the first such. A
 *  section goes into the array that the ones before it have begun, until that is full. */
static int read_name(data_values *v, int64_t first) {
    gmsh_reader *reader = v->reader;
    io_array_filler filler = {.array = {.name = NULL}};
    int status = PLANISH_OK;
    for (int64_t i = first; i < reader->n_data && !status; i++) {
        gmsh_data *data = &reader->data[i];
        if (!is_same_name(data, &reader->data[first]))
            continue;
        data->is_read = 1;
        if (filler.array.name && (filler.is_broken || io_array_is_full(&filler)))
            status = io_array_end(reader->model, &filler, reader->error);
        if (!status && !filler.array.name)
            status = begin_array(reader, data, &filler);
        if (!status)
            status = put_section(v, data, &filler);
        if (status == PLANISH_ERROR_FORMAT) {
            io_array_drop(&filler);
            status = PLANISH_OK;
        }
    }
    if (!status && filler.array.name)
        return io_array_end(reader->model, &filler, reader->error);
    io_array_drop(&filler);
    return status;
}

int gmsh_read_data(gmsh_reader *reader) {
    const int dim = io_model_dim(reader->model);
    data_values v = {.reader = reader,
                     .list = {io_model_list(reader->model, dim),
                              io_model_list(reader->model, io_others_list(dim))}};
    int64_t most = 0;
    for (int64_t i = 0; i < reader->n_data; i++)
        most = reader->data[i].n > most ? reader->data[i].n : most;
    most = most < BLOCK ? most : BLOCK;
    if (reader->n_data == 0)
        return PLANISH_OK;
    v.number = pl_alloc(most, sizeof *v.number);
    v.value = pl_alloc(most, sizeof *v.value);
    v.is_whole = pl_alloc(most, sizeof *v.is_whole);
    int status = v.number && v.value && v.is_whole
                     ? PLANISH_OK
                     : pl_fail_memory(reader->error, "the arrays of cells");
    for (int64_t i = 0; i < reader->n_data && !status; i++)
        if (!reader->data[i].is_read)
            status = read_name(&v, i);
    io_numbers_destroy(v.numbers);
    pl_free(v.number);
    pl_free(v.value);
    pl_free(v.is_whole);
    return status;
}
