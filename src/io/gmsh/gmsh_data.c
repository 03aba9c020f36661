/* gmsh_data: values of $ElementData that may tell regions, and of $NodeData and $ElementData for
 * whoever asks; and how to skip the values of these and of $ElementNodeData in binary files.
 *
 * Binary values may have any bytes, the section's end mark among them, and not every program begins
 * a line for that mark. So the reader skips values by their count, as Gmsh does.
 *
 * A section has the number of texts and these, a line each, the first is the name; the number of
 * reals and these; the number of whole numbers and these: step, width of a value, number of values,
 * ...; and the values. A value is the number of its node or element (int32), for $ElementNodeData
 * the number of nodes (int32), and doubles.
 *
 * gmsh_note_data keeps the places of sections; gmsh_read_data makes arrays (arrays.h) of those with
 * one value per element, gmsh_read_values reads any. Of each name only the first time step is read.
 * Sections of the same name and step fill one array: programs write the parts of a partition so.
 * Values of other nodes and elements are ignored.
 */
#include "io/gmsh/gmsh_sections.h"

#include <string.h>

#include "base/memory.h"
#include "base/status.h"
#include "io/core/arrays.h"
#include "io/core/data.h"

enum {
    LARGEST_HEAD = 1 << 16, /* bytes that are looked at for what stands before the values */
    TEXT_SIZE = 4,          /* bytes of the shortest value with its number: "1 0" and a line end */
    BINARY_SIZE = 4 + 8,
    BLOCK = 1 << 20,     /* values that are read at once, */
    REAL_BLOCK = 1 << 16 /* and of up to nine reals */
};

/** Read all before the values: texts, reals and whole numbers. data->values: behind the last of
 *  these, or in binary behind its line. Return 0 or -1. */
static int read_head(io_cursor cursor, int is_binary, gmsh_data *data) {
    enum { STEP, WIDTH, COUNT, N_WANTED };
    int64_t n, number[N_WANTED] = {0}, ignored;
    double real;
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
    gmsh_data data = {.n = 0};
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

/** Whether sections are of one array, whatever their times. */
static int is_same_array(const gmsh_data *a, const gmsh_data *b) {
    const int64_t length = io_slice_length(a->name);
    return a->of_elements == b->of_elements && a->width == b->width &&
           length == io_slice_length(b->name) &&
           memcmp(a->name.begin, b->name.begin, (size_t)length) == 0;
}

/** Whether the values of a section may tell regions. */
static int may_be_regions(const gmsh_data *data) {
    return data->of_elements && data->width == 1;
}

int gmsh_note_data(gmsh_reader *reader, int of_elements, const char *begin, const char *end) {
    static const char of_element[] = "ElementData", of_node[] = "NodeData";
    const io_slice no_name = of_elements
                                 ? (io_slice){of_element, of_element + sizeof of_element - 1}
                                 : (io_slice){of_node, of_node + sizeof of_node - 1};
    const io_cursor cursor = {begin, end};
    gmsh_data data = {.of_elements = of_elements, .name = no_name};
    int n_regions = 0, is_known = 0;
    if (read_head(cursor, reader->model->is_binary, &data) || reader->n_data == IO_MOST_DATA)
        return PLANISH_OK;
    for (int64_t i = 0; i < reader->n_data; i++) {
        n_regions += may_be_regions(&reader->data[i]);
        if (is_known || !is_same_array(&reader->data[i], &data))
            continue;
        if (reader->data[i].step != data.step) /* a later time */
            return PLANISH_OK;
        is_known = 1;
    }
    data.end = end;
    data.is_read = !may_be_regions(&data) || n_regions >= IO_MOST_ARRAYS;
    return pl_append(&reader->data, &reader->n_data, &reader->data_capacity, &data, sizeof data)
               ? PLANISH_OK
               : pl_fail_memory(reader->error, "the arrays of the file");
}

/** Make the text of a name, to be released by pl_free; NULL without memory. */
static char *text_of(io_slice name) {
    const int64_t length = io_slice_length(name);
    char *text = pl_alloc(length + 1, 1);
    if (!text)
        return NULL;
    memcpy(text, name.begin, (size_t)length);
    text[length] = '\0';
    return text;
}

/* ---- owners of values --------------------------------------------------------------------- */

/** The nodes or elements that values are of, by their numbers. */
typedef struct owners {
    const io_model *model;
    int of_elements;
    io_list list[2];     /* the elements: simplices, others */
    int64_t n;           /* all of them */
    io_numbers *numbers; /* made when it is needed, owned */
    int64_t next;        /* the one behind the owner of the last value */
} owners;

static owners owners_of(const io_model *model, int of_elements) {
    const int dim = io_model_dim(model);
    owners o = {.model = model,
                .of_elements = of_elements,
                .list = {io_model_list(model, dim), io_model_list(model, io_others_list(dim))}};
    o.n = of_elements ? o.list[0].n + o.list[1].n : model->n_nodes;
    return o;
}

static int64_t number_of(const owners *o, int64_t i) {
    if (!o->of_elements)
        return io_node_number(o->model, i);
    const int64_t n = o->list[0].n;
    return i < n ? io_list_number(&o->list[0], i) : io_list_number(&o->list[1], i - n);
}

/** Whether numbers are consecutive. */
static int are_in_order(const owners *o) {
    return o->of_elements ? !o->list[0].cells->number && o->list[1].n == 0 : !o->model->node_number;
}

/** Make the table of their numbers. */
static int make_numbers(owners *o, planish_error *error) {
    int64_t *number = pl_alloc(o->n, sizeof *number);
    if (!number)
        return pl_fail_memory(error, "the numbers of nodes or elements");
    for (int64_t i = 0; i < o->n; i++)
        number[i] = number_of(o, i);
    const int status = io_numbers_create(o->model->input.path, o->of_elements ? "element" : "node",
                                         number, o->n, &o->numbers, error);
    pl_free(number);
    return status;
}

/** Find the owner of that number: its index or -1. Mostly values are in the order of the owners. */
static int find_owner(owners *o, int64_t number, int64_t *index, planish_error *error) {
    if (are_in_order(o)) {
        const uint64_t i = o->n > 0 ? (uint64_t)number - (uint64_t)number_of(o, 0) : 0;
        *index = i < (uint64_t)o->n ? (int64_t)i : -1;
        return PLANISH_OK;
    }
    *index = o->next;
    if (o->next >= o->n || number_of(o, o->next) != number) {
        const int status = o->numbers ? PLANISH_OK : make_numbers(o, error);
        if (status)
            return status;
        *index = io_numbers_find(o->numbers, number);
    }
    o->next = *index >= 0 ? *index + 1 : o->next;
    return PLANISH_OK;
}

/* ---- whole numbers ------------------------------------------------------------------------------- */

/** A block of values, and what finds the elements that they are of. */
typedef struct data_values {
    gmsh_reader *reader;
    owners elements;
    int64_t *number;   /* [BLOCK], owned, of the element as the file has it, */
    int64_t *value;    /* [BLOCK], owned, */
    uint8_t *is_whole; /* [BLOCK], owned */
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

/** Put the values of a section, up to a block with one that is not whole. Return _FORMAT if the
 *  section is malformed. */
static int put_section(data_values *v, const gmsh_data *data, io_array_filler *filler) {
    gmsh_reader *reader = v->reader;
    io_model *model = reader->model;
    /* Text may be read by threads, which need all of the file before them; it ends at the mark. */
    io_cursor cursor = {data->values, model->is_binary ? data->end : reader->text.end};
    if (data->n > (data->end - data->values) / (model->is_binary ? BINARY_SIZE : TEXT_SIZE))
        return PLANISH_ERROR_FORMAT;
    v->elements.next = 0;
    for (int64_t done = 0; done < data->n && !filler->is_broken;) {
        const int64_t n = data->n - done < BLOCK ? data->n - done : BLOCK;
        int status = model->is_binary
                         ? io_binary_records(io_model_threads(model), &cursor, n, BINARY_SIZE,
                                             read_values, v, NULL)
                         : io_text_records(&reader->text, &cursor, n, 2, read_values, v, NULL);
        for (int64_t i = 0; i < n && !status; i++) {
            int64_t element;
            status = find_owner(&v->elements, v->number[i], &element, reader->error);
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
    char *name = text_of(data->name);
    if (!name)
        return pl_fail_memory(reader->error, "the arrays of cells");
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
        if (!is_same_array(data, &reader->data[first]))
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

/** Give the places of the sections to the model. */
static int note_places(const gmsh_reader *reader) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < reader->n_data && !status; i++) {
        const gmsh_data *data = &reader->data[i];
        const char *first = reader->model->input.data;
        char *name = text_of(data->name);
        if (!name)
            return pl_fail_memory(reader->error, "the names of arrays");
        status = io_data_note(reader->model,
                              (io_data){.name = name,
                                        .of_elements = data->of_elements,
                                        .width = data->width,
                                        .n = data->n,
                                        .begin = data->values - first,
                                        .end = data->end - first,
                                        .swapped = reader->swapped},
                              reader->error);
        pl_free(name);
    }
    return status;
}

/** Make arrays of the sections that may tell regions. */
static int make_arrays(gmsh_reader *reader) {
    data_values v = {.reader = reader, .elements = owners_of(reader->model, 1)};
    int64_t most = -1;
    for (int64_t i = 0; i < reader->n_data; i++)
        if (!reader->data[i].is_read && reader->data[i].n > most)
            most = reader->data[i].n;
    if (most < 0)
        return PLANISH_OK;
    most = most < BLOCK ? most : BLOCK;
    v.number = pl_alloc(most, sizeof *v.number);
    v.value = pl_alloc(most, sizeof *v.value);
    v.is_whole = pl_alloc(most, sizeof *v.is_whole);
    int status = v.number && v.value && v.is_whole
                     ? PLANISH_OK
                     : pl_fail_memory(reader->error, "the arrays of cells");
    for (int64_t i = 0; i < reader->n_data && !status; i++)
        if (!reader->data[i].is_read)
            status = read_name(&v, i);
    io_numbers_destroy(v.elements.numbers);
    pl_free(v.number);
    pl_free(v.value);
    pl_free(v.is_whole);
    return status;
}

int gmsh_read_data(gmsh_reader *reader) {
    const int status = note_places(reader);
    return status ? status : make_arrays(reader);
}

/* ---- reals -------------------------------------------------------------------------------- */

/** A block of values of a section. */
typedef struct real_values {
    const io_model *model;
    const io_data *data;
    int64_t *number; /* [REAL_BLOCK], owned, of the owner as the file has it, */
    double *value;   /* [REAL_BLOCK][width], owned */
} real_values;

static int read_reals(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                      planish_error *error) {
    const real_values *v = context;
    const int64_t width = v->data->width;
    const int is_binary = v->model->is_binary, swapped = v->data->swapped;
    for (int64_t i = begin; i < end; i++) {
        int is_wrong = io_number(cursor, is_binary ? 4 : 0, swapped, &v->number[i]);
        for (int64_t k = 0; k < width && !is_wrong; k++) {
            double *value = &v->value[i * width + k];
            if (is_binary) {
                *value = io_load_f64(cursor->at, swapped);
                cursor->at += 8;
            } else {
                is_wrong = io_real(cursor, value);
            }
        }
        if (is_wrong)
            return io_data_fail(v->model, v->data, cursor->at - v->model->input.data, error,
                                "a number expected: the file is cut short or a count is wrong");
    }
    return PLANISH_OK;
}

/** Values by nodes or elements, being filled in. */
typedef struct real_array {
    owners owners;
    double *values; /* [owners.n][width] */
    uint8_t *has;   /* [owners.n] whether it has a value, */
    int64_t n_has;  /* and how many have */
} real_array;

/** Put a block of n values where they belong. */
static int put_reals(const real_values *v, int64_t n, real_array *array, planish_error *error) {
    const int64_t width = v->data->width;
    for (int64_t i = 0; i < n; i++) {
        int64_t at;
        const int status = find_owner(&array->owners, v->number[i], &at, error);
        if (status)
            return status;
        if (at < 0)
            continue;
        memcpy(array->values + at * width, v->value + i * width, (size_t)width * sizeof *v->value);
        array->n_has += !array->has[at];
        array->has[at] = 1;
    }
    return PLANISH_OK;
}

/** Read the values of a section. */
static int read_section(io_text *text, real_values *v, real_array *array, planish_error *error) {
    const io_model *model = v->model;
    const io_data *data = v->data;
    const char *first = model->input.data;
    const int64_t size = model->is_binary ? 4 + 8 * data->width : 2 * (1 + data->width);
    /* Text may be read by threads, which need all of the file before them; it ends at the mark. */
    io_cursor cursor = {first + data->begin, model->is_binary ? first + data->end : text->end};
    int status = io_check_room(model, (io_cursor){cursor.at, first + data->end}, data->n, size,
                               data->name, error);
    array->owners.next = 0;
    for (int64_t done = 0; done < data->n && !status;) {
        const int64_t n = data->n - done < REAL_BLOCK ? data->n - done : REAL_BLOCK;
        status = io_records(text, &cursor, n, 1 + data->width, size, read_reals, v, error);
        if (!status)
            status = put_reals(v, n, array, error);
        done += n;
    }
    io_skip_space(&cursor);
    if (!status && !model->is_binary && cursor.at < first + data->end)
        status = io_data_fail(model, data, cursor.at - first, error,
                              "there are more values than their count says");
    return status;
}

/** Check that each owner has a value: the error names the first that has none. */
static int check_all(const io_data *data, const real_array *array, planish_error *error) {
    const owners *o = &array->owners;
    int64_t i = 0;
    if (array->n_has == o->n)
        return PLANISH_OK;
    while (array->has[i])
        i++;
    return pl_fail_at(error, PLANISH_ERROR_FORMAT, o->of_elements ? i : -1, o->of_elements ? -1 : i,
                      "%s: the array '%s' has no value for %lld of the %lld %ss, the first is %s "
                      "%lld; each must have one",
                      o->model->input.path, data->name, (long long)(o->n - array->n_has),
                      (long long)o->n, o->of_elements ? "element" : "node",
                      o->of_elements ? "element" : "node", (long long)number_of(o, i));
}

/** Read the sections of an array, the first of which is data. */
static int read_sections(io_model *model, const io_data *data, real_values *v, real_array *array,
                         planish_error *error) {
    io_text text;
    int status = PLANISH_OK;
    io_text_init(&text, model);
    for (const io_data *d = data; d < model->data + model->n_data && !status; d++) {
        if (d->of_elements != data->of_elements || d->width != data->width ||
            strcmp(d->name, data->name) != 0)
            continue;
        v->data = d;
        status = read_section(&text, v, array, error);
    }
    io_text_release(&text);
    return status ? status : check_all(data, array, error);
}

int gmsh_read_values(io_model *model, const io_data *data, double *values, planish_error *error) {
    real_array array = {.owners = owners_of(model, data->of_elements), .values = values};
    real_values v = {.model = model, .data = data};
    array.has = pl_alloc_zero(array.owners.n, sizeof *array.has);
    v.number = pl_alloc(REAL_BLOCK, sizeof *v.number);
    v.value = pl_alloc(REAL_BLOCK * data->width, sizeof *v.value);
    const int status = array.has && v.number && v.value
                           ? read_sections(model, data, &v, &array, error)
                           : pl_fail_memory(error, "an array of the file");
    io_numbers_destroy(array.owners.numbers);
    pl_free(array.has);
    pl_free(v.number);
    pl_free(v.value);
    return status;
}
