/* netcdf_header: the header of classic netCDF files: CDF-1, CDF-2 (64-bit offsets) and CDF-5 (64-bit
 * data), by the NetCDF Classic Format Specification.
 *
 * A header is the number of records and lists of dimensions, of attributes of the file, and of
 * variables, which say where their values are. All numbers are big-endian. Names and the values of
 * attributes are filled up to 4 bytes.
 */
#include "io/netcdf/netcdf_header.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/binary.h"

#include <stdlib.h>
#include <string.h>

/** A walk over the header, which the model is still of. */
typedef struct header_walk {
    const io_model *model;
    io_cursor at;
    int is_wide;
    planish_error *error; /* NULL: nothing is said of errors */
} header_walk;

/* ---- numbers, names and attributes --------------------------------------------------------- */

/** Take a whole number of 4 or 8 bytes. */
static int take_number(header_walk *w, int size, int64_t *value) {
    const int swapped = io_machine_is_little();
    if (w->at.end - w->at.at < size)
        return io_fail_at(w->model, w->at.at, w->error,
                          "the header of the netCDF file ends here (the file may be cut short)");
    *value = size == 4 ? io_load_i32(w->at.at, swapped) : io_load_i64(w->at.at, swapped);
    w->at.at += size;
    return PLANISH_OK;
}

/** Take the number of things of size bytes each at least, which follow. */
static int take_count(header_walk *w, const char *what, int64_t size, int64_t *n) {
    const int status = take_number(w, w->is_wide ? 8 : 4, n);
    return status ? status : io_check_room(w->model, w->at, *n, size, what, w->error);
}

/** Take the tag and the number of things in a list. */
static int take_list(header_walk *w, int tag, const char *what, int64_t size, int64_t *n) {
    const char *at = w->at.at;
    int64_t found = 0;
    int status = take_number(w, 4, &found);
    if (!status)
        status = take_count(w, what, size, n);
    if (!status && found != tag && !(found == NETCDF_NO_LIST && *n == 0))
        status = io_fail_at(w->model, at, w->error,
                            "the list of %s was expected (the file may be damaged)", what);
    return status;
}

/** Take n bytes, of which the last is filled up to 4; the last ones of the file may lack that. */
static io_slice take_padded(header_walk *w, int64_t n) {
    const io_slice slice = {w->at.at, w->at.at + n};
    const int64_t padding = (4 - n % 4) % 4, left = w->at.end - slice.end;
    w->at.at = slice.end + (padding < left ? padding : left);
    return slice;
}

static int take_name(header_walk *w, io_slice *name) {
    int64_t n = 0;
    const int status = take_count(w, "characters of a name", 1, &n);
    if (!status)
        *name = take_padded(w, n);
    return status;
}

/** Take the number of a type. */
static int take_type(header_walk *w, int *type) {
    const char *at = w->at.at;
    int64_t number = 0;
    const int status = take_number(w, 4, &number);
    if (!status && netcdf_type_size(number) == 0)
        return io_fail_at(w->model, at, w->error,
                          "%lld is not a type of values (the file may be damaged)",
                          (long long)number);
    *type = (int)number;
    return status;
}

typedef struct attribute {
    io_slice name, value;
    int type;
} attribute;

static int take_attribute(header_walk *w, attribute *a) {
    int64_t n = 0;
    int status = take_name(w, &a->name);
    if (!status)
        status = take_type(w, &a->type);
    if (!status)
        status = take_count(w, "values of an attribute", netcdf_type_size(a->type), &n);
    if (!status)
        a->value = take_padded(w, n * netcdf_type_size(a->type));
    return status;
}

/** Skip a list of attributes. */
static int skip_attributes(header_walk *w) {
    enum { LEAST = 12 }; /* bytes of an attribute */
    int64_t n = 0;
    attribute a = {.type = 0};
    int status = take_list(w, NETCDF_ATTRIBUTES, "attributes", LEAST, &n);
    for (int64_t i = 0; i < n && !status; i++)
        status = take_attribute(w, &a);
    return status;
}

io_slice netcdf_header_text_attribute(const netcdf_header *h, const netcdf_variable *v,
                                      const char *name) {
    header_walk w = {h->model, v->attributes, h->is_wide, NULL};
    attribute a = {.type = 0};
    int64_t n = 0;
    int status = take_list(&w, NETCDF_ATTRIBUTES, "attributes", 1, &n);
    for (int64_t i = 0; i < n && !status; i++) {
        status = take_attribute(&w, &a);
        if (!status && a.type == NETCDF_CHAR && io_slice_is(a.name, name, 0))
            return a.value;
    }
    return (io_slice){NULL, NULL};
}

/* ---- dimensions and variables --------------------------------------------------------------- */

static int read_dimensions(netcdf_header *h, header_walk *w) {
    enum { LEAST = 8 };
    int64_t n = 0;
    int status = take_list(w, NETCDF_DIMENSIONS, "dimensions", LEAST, &n);
    for (int64_t i = 0; i < n && !status; i++) {
        netcdf_dim dim = {.length = 0};
        status = take_name(w, &dim.name);
        const char *at = w->at.at;
        if (!status)
            status = take_number(w, w->is_wide ? 8 : 4, &dim.length);
        if (!status && dim.length < 0)
            status = io_fail_at(w->model, at, w->error,
                                "a dimension of length %lld (the file may be damaged)",
                                (long long)dim.length);
        if (!status && !pl_append(&h->dim, &h->n_dims, &h->dim_capacity, &dim, sizeof dim))
            status = pl_fail_memory(w->error, "the dimensions of the file");
    }
    return status;
}

/** Take the dimensions of a variable. Of a damaged file their product may be too large: so many values
 *  are not in the file. */
static int take_dimensions(const netcdf_header *h, header_walk *w, netcdf_variable *v) {
    const int size = w->is_wide ? 8 : 4;
    int64_t n = 0;
    v->n = 1;
    int status = take_count(w, "dimensions of a variable", size, &n);
    for (int64_t i = 0; i < n && !status; i++) {
        const char *at = w->at.at;
        int64_t k = 0;
        status = take_number(w, size, &k);
        if (!status && (k < 0 || k >= h->n_dims))
            return io_fail_at(w->model, at, w->error,
                              "variable '%.*s': there is no dimension %lld (the file may be "
                              "damaged)",
                              IO_QUOTED(v->name), (long long)k);
        const int64_t length = status ? 0 : h->dim[k].length;
        if (length == 0 && i == 0) {
            v->is_record = 1;
            continue;
        }
        if (v->rank < NETCDF_MOST_DIMS)
            v->dims[v->rank] = length;
        v->rank++;
        v->n = length > 0 && v->n > INT64_MAX / 8 / length ? INT64_MAX / 8 : v->n * length;
    }
    return status;
}

static int read_variables(netcdf_header *h, header_walk *w) {
    enum { LEAST = 28 };
    int64_t n = 0, size;
    int status = take_list(w, NETCDF_VARIABLES, "variables", LEAST, &n);
    const int is_long = h->is_wide || w->model->input.data[3] == 2;
    for (int64_t i = 0; i < n && !status; i++) {
        netcdf_variable v = {.n = 0};
        status = take_name(w, &v.name);
        if (!status)
            status = take_dimensions(h, w, &v);
        v.attributes.at = w->at.at;
        if (!status)
            status = skip_attributes(w);
        v.attributes.end = w->at.at;
        if (!status)
            status = take_type(w, &v.type);
        if (!status) /* not needed: it follows from the dimensions, and has 32 bits */
            status = take_number(w, w->is_wide ? 8 : 4, &size);
        if (!status)
            status = take_number(w, is_long ? 8 : 4, &v.begin);
        if (!status && !is_long)
            v.begin = (int64_t)(uint32_t)v.begin;
        if (!status &&
            !pl_append(&h->variable, &h->n_variables, &h->variable_capacity, &v, sizeof v))
            status = pl_fail_memory(w->error, "the variables of the file");
    }
    return status;
}

/* ---- places of values ----------------------------------------------------------------------- */

/** Find the bytes of a record: the values of a step of all variables, each filled up to 4 bytes unless
 *  it is alone. */
static int64_t record_size(const netcdf_header *h) {
    int64_t n = 0, plain = 0, padded = 0;
    for (int64_t i = 0; i < h->n_variables; i++) {
        const netcdf_variable *v = &h->variable[i];
        const int64_t most = h->model->input.size;
        if (!v->is_record)
            continue;
        n++;
        plain = v->n > most ? most + 1 : v->n * netcdf_type_size(v->type);
        padded += plain + (4 - plain % 4) % 4;
        if (padded > most)
            return most + 1;
    }
    return n == 1 ? plain : padded;
}

/** Check that the values of a variable stand in the file from behind on, and find where they end. */
static int check_place(const netcdf_header *h, const netcdf_variable *v, int64_t record,
                       int64_t *behind, planish_error *error) {
    const int64_t size = h->model->input.size;
    const int64_t bytes = v->n > size ? size + 1 : v->n * netcdf_type_size(v->type);
    /* An unfinished file does not say how many records there are. */
    const int64_t more = v->is_record && h->n_records > 1 ? h->n_records - 1 : 0;
    if (v->is_record && h->n_records <= 0)
        return PLANISH_OK;
    if (bytes > size || (more > 0 && record > size / more) || more * record > size - bytes ||
        v->begin > size - bytes - more * record)
        return io_fail_at(h->model, h->model->input.data + size, error,
                          "the values of variable '%.*s' are not all in the file; it is damaged or "
                          "cut short",
                          IO_QUOTED(v->name));
    if (v->begin < *behind)
        return io_fail_at(h->model, v->name.begin, error,
                          "the values of variable '%.*s' begin within those of another one, or the "
                          "header; the file is damaged",
                          IO_QUOTED(v->name));
    *behind = v->begin + bytes;
    return PLANISH_OK;
}

/** Check that all values are in the file, behind the header, and that no two variables share any:
 *  they stand in the order of the variables, those of records behind the others. */
static int check_places(const netcdf_header *h, int64_t header, planish_error *error) {
    const int64_t record = record_size(h);
    int64_t behind = header;
    int status = PLANISH_OK;
    for (int pass = 0; pass < 2; pass++)
        for (int64_t i = 0; i < h->n_variables && !status; i++)
            if (h->variable[i].is_record == pass)
                status = check_place(h, &h->variable[i], record, &behind, error);
    return status;
}

/* ---- the header ----------------------------------------------------------------------------- */

static int compare_names(io_slice a, io_slice b) {
    const int64_t n = io_slice_length(a), m = io_slice_length(b);
    const int order = memcmp(a.begin, b.begin, (size_t)(n < m ? n : m));
    return order ? order : (n > m) - (n < m);
}

static int compare_variables(const void *a, const void *b) {
    const netcdf_variable *x = a, *y = b;
    return compare_names(x->name, y->name);
}

static int compare_dims(const void *a, const void *b) {
    const netcdf_dim *x = a, *y = b;
    return compare_names(x->name, y->name);
}

int netcdf_header_read(const io_model *model, netcdf_header *h, planish_error *error) {
    const io_bytes *input = &model->input;
    *h = (netcdf_header){.model = model, .is_wide = input->data[3] == 5};
    header_walk w = {model, {input->data + 4, input->data + input->size}, h->is_wide, error};
    int status = take_number(&w, h->is_wide ? 8 : 4, &h->n_records);
    if (!status)
        status = read_dimensions(h, &w);
    if (!status)
        status = skip_attributes(&w);
    if (!status)
        status = read_variables(h, &w);
    if (!status)
        status = check_places(h, w.at.at - input->data, error);
    if (!status && h->n_variables > 0)
        qsort(h->variable, (size_t)h->n_variables, sizeof *h->variable, compare_variables);
    if (!status && h->n_dims > 0) /* no variable refers to them by their order any more */
        qsort(h->dim, (size_t)h->n_dims, sizeof *h->dim, compare_dims);
    return status;
}

void netcdf_header_release(netcdf_header *h) {
    pl_free(h->dim);
    pl_free(h->variable);
}

int64_t netcdf_header_dimension(const netcdf_header *h, const char *name) {
    const netcdf_dim key = {.name = {name, name + strlen(name)}};
    const netcdf_dim *dim =
        h->n_dims == 0 ? NULL
                       : bsearch(&key, h->dim, (size_t)h->n_dims, sizeof *h->dim, compare_dims);
    return dim ? dim->length : 0;
}

const netcdf_variable *netcdf_header_find(const netcdf_header *h, const char *name) {
    const netcdf_variable key = {.name = {name, name + strlen(name)}};
    return h->n_variables == 0 ? NULL
                               : bsearch(&key, h->variable, (size_t)h->n_variables,
                                         sizeof *h->variable, compare_variables);
}
