/* xdmf_items: the numbers of an XDMF file: in its text, in files of HDF5, and in files of bytes. */
#include "io/xdmf/xdmf_items.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/bytes.h"
#include "io/core/include.h"
#include "io/core/number.h"

#include <string.h>
#include <strings.h>

int xdmf_begin(io_model *model, xdmf_reader *r, planish_error *error) {
    *r = (xdmf_reader){.model = model, .error = error};
    io_model opened = {.input = model->document.data ? model->document : model->input,
                       .threads = io_model_threads(model),
                       .largest_copy = model->largest_copy};
    return xdmf_markup_read(&opened, &r->document, error);
}

int xdmf_close(xdmf_reader *r, int status) {
    for (int64_t i = r->n_files - 1; i >= 0; i--) { /* in turn, as each silences HDF5 */
        status = xdmf_hdf5_end(r->file[i], status);
        pl_free(r->file[i]);
    }
    pl_free(r->file);
    io_include_close(&r->document.view);
    io_names_release(&r->document.view.included_name);
    xdmf_markup_release(&r->document);
    return status;
}

/* ---- DataItem elements ---------------------------------------------------------------------- */

static int find_dimensions(xdmf_reader *r, xdmf_item *item) {
    const char *text = xdmf_attribute(&r->document, item->element, "Dimensions");
    const char *end = text ? text + strlen(text) : NULL;
    int64_t dimension;
    int rank = 0;
    item->n = 1;
    item->width = 1;
    for (; text; rank++) {
        while (text < end && (io_is_space(*text) || *text == ','))
            text++;
        if (text == end)
            break;
        if (io_parse_integer(&text, end, &dimension) || dimension < 0 ||
            (dimension > 0 && item->n > INT64_MAX / 16 / dimension))
            return xdmf_fail(&r->document, item->element, "Dimensions are not whole numbers");
        item->n *= dimension;
        item->width = rank > 0 ? dimension : 1;
    }
    item->n = rank > 0 ? item->n : -1;
    return PLANISH_OK;
}

static int find_type(xdmf_reader *r, xdmf_item *item) {
    static const struct {
        const char *name;
        vtk_kind kind;
        int size;
    } types[] = {{"Float", VTK_REAL, 4},      {"Int", VTK_SIGNED, 4},     {"UInt", VTK_UNSIGNED, 4},
                 {"Char", VTK_SIGNED, 1},     {"UChar", VTK_UNSIGNED, 1}, {"Short", VTK_SIGNED, 2},
                 {"UShort", VTK_UNSIGNED, 2}, {"Double", VTK_REAL, 8}};
    const xdmf_document *d = &r->document;
    const char *name = xdmf_attribute(d, item->element, "NumberType");
    const char *precision = xdmf_attribute(d, item->element, "Precision");
    const char *order = xdmf_attribute(d, item->element, "Endian");
    name = name ? name : xdmf_attribute(d, item->element, "DataType");
    name = name ? name : "Float";
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (strcasecmp(name, types[i].name) == 0)
            item->type = (vtk_type){types[i].name, types[i].kind, types[i].size};
    if (precision)
        item->type.size = strlen(precision) == 1 ? *precision - '0' : 0;
    const int size = item->type.size;
    if (!item->type.name || (size != 1 && size != 2 && size != 4 && size != 8) ||
        (item->type.kind == VTK_REAL && size < 4))
        return xdmf_fail(d, item->element,
                         "numbers of NumberType %.20s and Precision %.20s are "
                         "not read",
                         name, precision ? precision : "4");
    item->swapped = order && strcasecmp(order, "Native") != 0 &&
                    (strcasecmp(order, "Big") == 0 || strcasecmp(order, "BigEndian") == 0) ==
                        io_machine_is_little();
    return PLANISH_OK;
}

enum { MOST_NAME = 8192 }; /* of a file, and of what is in it */

/** Refuse a file that its writer may not have meant to be seen: it is copied beside OUT, where programs
 *  may look for one of that name. */
static int check_file(xdmf_reader *r, const xdmf_item *item) {
    return io_include_is_hidden(item->file)
               ? xdmf_fail(
                     &r->document, item->element,
                     "'%.*s' is a hidden file; give it a name that does not begin with a point",
                     IO_QUOTED(item->file))
               : PLANISH_OK;
}

/** Find where the numbers are: FILE:PATH of HDF5, or the name of a file. */
static int find_place(xdmf_reader *r, xdmf_item *item) {
    const xdmf_document *d = &r->document;
    const char *format = xdmf_attribute(d, item->element, "Format");
    const char *seek = xdmf_attribute(d, item->element, "Seek");
    const char *packing = xdmf_attribute(d, item->element, "Compression");
    const io_slice text = xdmf_text(d, item->element);
    item->form = !format || strcasecmp(format, "XML") == 0 ? XDMF_TEXT
                 : strncasecmp(format, "HDF", 3) == 0      ? XDMF_HDF5
                                                           : XDMF_BYTES;
    if (item->form == XDMF_TEXT)
        return PLANISH_OK;
    if (io_slice_length(text) > MOST_NAME)
        return xdmf_fail(d, item->element, "the name of a file is too long");
    item->file = text;
    while (text.end - item->file.begin > 2 && memcmp(item->file.begin, "./", 2) == 0)
        item->file.begin += 2;
    if (io_include_leads_up(text))
        return xdmf_fail(d, item->element,
                         "'%.*s' has '..' in it; name a file beside this one or below its folder "
                         "without that",
                         IO_QUOTED(text));
    if (item->form == XDMF_HDF5 && memchr(text.begin, '|', (size_t)io_slice_length(text)))
        return xdmf_fail(d, item->element,
                         "a part of an array ('|') is not read; write the mesh to "
                         "a file of its own");
    if (item->form == XDMF_HDF5) {
        /* The colon of a drive of Windows is none. */
        const char *at = text.end;
        while (at > text.begin && *at != ':')
            at--;
        item->file.end = at;
        item->place = (io_slice){at < text.end ? at + 1 : at, text.end};
        return at > text.begin ? check_file(r, item)
                               : xdmf_fail(d, item->element,
                                           "the name of a file and a path in it were expected, as "
                                           "in mesh.h5:/nodes");
    }
    if (strcasecmp(format, "Binary") != 0)
        return xdmf_fail(d, item->element,
                         "Format %.30s is not read; there are XML, HDF and "
                         "Binary",
                         format);
    if (packing && strcasecmp(packing, "Raw") != 0)
        return xdmf_fail(d, item->element,
                         "its bytes are packed (Compression %.30s), which is not "
                         "read",
                         packing);
    if (seek) {
        const char *end = seek + strlen(seek);
        if (io_parse_integer(&seek, end, &item->seek) || seek < end || item->seek < 0)
            return xdmf_fail(d, item->element, "Seek is not a number of bytes");
    }
    return check_file(r, item);
}

int xdmf_item_of(xdmf_reader *r, int64_t element, xdmf_item *item) {
    xdmf_document *d = &r->document;
    *item = (xdmf_item){.n = -1};
    int status = xdmf_resolve(d, element, &item->element);
    if (status)
        return status;
    const char *kind = xdmf_attribute(d, item->element, "ItemType");
    if (kind && strcasecmp(kind, "Uniform") != 0)
        return xdmf_fail(d, item->element,
                         "ItemType %.30s is not read; write the numbers as they "
                         "are",
                         kind);
    if (d->element[item->element].is_broken)
        return xdmf_fail(d, item->element, "markup stands among its text");
    status = find_dimensions(r, item);
    if (!status)
        status = find_type(r, item);
    return status ? status : find_place(r, item);
}

int xdmf_items_in(xdmf_reader *r, int64_t element, xdmf_item *item, int *n) {
    xdmf_list list = {0};
    int status = xdmf_children(&r->document, element, "DataItem", &list);
    if (!status && list.n > XDMF_MOST_ITEMS)
        status = xdmf_fail(&r->document, element, "there are %lld DataItem elements in it",
                           (long long)list.n);
    for (int64_t i = 0; i < list.n && !status; i++)
        status = xdmf_item_of(r, list.element[i], &item[i]);
    *n = status ? 0 : (int)list.n;
    pl_free(list.element);
    return status;
}

/** Compare two numbers. */
static int compare(int64_t a, int64_t b) {
    return (a > b) - (a < b);
}

int xdmf_compare(const xdmf_item *a, const xdmf_item *b) {
    const int form = compare(a->form, b->form);
    if (form || a->element == b->element)
        return form;
    if (a->form == XDMF_TEXT)
        return compare(a->element, b->element);
    const int file = io_include_compare(a->file, b->file);
    const int place = file ? file : io_include_compare(a->place, b->place);
    return place ? place : compare(a->seek, b->seek);
}

/* ---- files ---------------------------------------------------------------------------------- */

/** Add a file of that name, whose bytes are there. */
static int add_file(xdmf_reader *r, const xdmf_item *item, io_bytes bytes, xdmf_file **file) {
    xdmf_file *f = pl_alloc_zero(1, sizeof *f);
    if (!f || !pl_append(&r->file, &r->n_files, &r->file_capacity, &f, sizeof f)) {
        pl_free(f);
        return pl_fail_memory(r->error, "the files of the mesh");
    }
    f->name = item->file;
    f->form = item->form;
    f->own = (io_model){.input = bytes, .is_binary = 1, .threads = io_model_threads(r->model)};
    f->model = &f->own;
    *file = f;
    return PLANISH_OK;
}

/** Open the file of an item, whose bytes are the last that are included then. */
static int include_file(xdmf_reader *r, const xdmf_item *item) {
    xdmf_document *d = &r->document;
    io_cursor ignored;
    const int status = io_include_open(&d->view, item->file.begin, item->file, &ignored, r->error);
    /* The HDF5 library trusts what it has read before. */
    return status || item->form != XDMF_HDF5
               ? status
               : io_bytes_own(&d->view.included[d->view.n_included - 1], r->error);
}

int xdmf_open(xdmf_reader *r, const xdmf_item *item, xdmf_file **file) {
    int status = PLANISH_OK;
    *file = NULL;
    for (int64_t i = 0; i < r->n_files; i++)
        if (r->file[i]->form == item->form && io_include_compare(r->file[i]->name, item->file) == 0)
            *file = r->file[i];
    if (!*file) {
        const io_model *view = &r->document.view;
        status = include_file(r, item);
        if (!status)
            status = add_file(r, item, view->included[view->n_included - 1], file);
    }
    return !status && item->form == XDMF_HDF5 && !(*file)->hdf5 ? xdmf_hdf5_open(r, item, *file)
                                                                : status;
}

int xdmf_take_input(xdmf_reader *r, const xdmf_item *item) {
    io_model *model = r->model, *view = &r->document.view;
    xdmf_file *file = NULL;
    int status = include_file(r, item);
    if (status)
        return status;
    model->document = model->input;
    model->input = view->included[--view->n_included];
    model->is_binary = 1;
    status = add_file(r, item, model->input, &file);
    if (!status)
        file->model = model;
    return status;
}

/* ---- values --------------------------------------------------------------------------------- */

static int fail_count(xdmf_reader *r, const xdmf_item *item, int64_t n) {
    return xdmf_fail(&r->document, item->element,
                     "%lld values cannot be where they should; Dimensions or Seek are wrong, or a "
                     "file is cut short",
                     (long long)n);
}

/** Find the number of values of an item, and check that they can be there. */
static int find_count(xdmf_reader *r, const xdmf_item *item, int64_t *n) {
    const io_slice text = xdmf_text(&r->document, item->element);
    xdmf_file *file = NULL;
    *n = item->n;
    if (item->form == XDMF_HDF5) {
        int status = xdmf_open(r, item, &file);
        if (!status)
            status = xdmf_hdf5_count(file, item, n);
        return !status && item->n >= 0 && *n != item->n
                   ? xdmf_fail(&r->document, item->element,
                               "Dimensions say %lld values, and there are %lld in '%.*s'",
                               (long long)item->n, (long long)*n, IO_QUOTED(item->place))
                   : status;
    }
    if (*n < 0)
        return xdmf_fail(&r->document, item->element, "there are no Dimensions");
    if (item->form == XDMF_TEXT)
        return *n <= (io_slice_length(text) + 1) / 2 ? PLANISH_OK : fail_count(r, item, *n);
    const int status = xdmf_open(r, item, &file);
    if (status)
        return status;
    const int64_t size = file->model->input.size;
    return item->seek <= size && *n <= (size - item->seek) / item->type.size
               ? PLANISH_OK
               : fail_count(r, item, *n);
}

/** Return the bytes of all files that are open. */
static int64_t count_bytes(const xdmf_reader *r) {
    int64_t n = r->document.view.input.size;
    for (int64_t i = 0; i < r->n_files; i++)
        n += r->file[i]->model->input.size;
    return n;
}

int xdmf_check_count(xdmf_reader *r, const xdmf_item *item, int64_t *n) {
    enum { FREE = 1 << 27, PER_BYTE = 64 };
    const int status = find_count(r, item, n);
    if (status)
        return status;
    r->n_counted += *n;
    return r->n_counted / PER_BYTE <= FREE / PER_BYTE + count_bytes(r)
               ? PLANISH_OK
               : xdmf_fail(&r->document, item->element,
                           "its values are referred to over and over; write the mesh as one grid");
}

int xdmf_read_text(xdmf_reader *r, const xdmf_item *item, int64_t n, int64_t tokens,
                   io_records_fn *read, void *context) {
    const io_slice slice = xdmf_text(&r->document, item->element);
    io_cursor cursor = {slice.begin, slice.end};
    io_text text;
    io_text_init(&text, &r->document.view);
    text.begin = cursor.at;
    text.end = cursor.end;
    int status = io_text_records(&text, &cursor, n, tokens, read, context, r->error);
    io_text_release(&text);
    io_skip_space(&cursor);
    if (!status && cursor.at < cursor.end)
        status = io_fail_at(&r->document.view, cursor.at, r->error,
                            "there is more than the %lld numbers that Dimensions say",
                            (long long)(n * tokens));
    return status;
}

/** Read n values to the array of the list that is not NULL. */
static int read_list(xdmf_reader *r, const xdmf_item *item, int64_t n, vtk_list list) {
    xdmf_file *file = NULL;
    list.model = &r->document.view;
    list.name = "DataItem";
    if (item->form == XDMF_TEXT)
        return xdmf_read_text(r, item, n, 1, vtk_read_list, &list);
    const int status = xdmf_open(r, item, &file);
    if (status)
        return status;
    list.model = file->model;
    list.type = &item->type;
    list.swapped = item->swapped;
    const io_bytes *bytes = &file->model->input;
    if (n > (bytes->size - item->seek) / item->type.size) /* it may be another file now */
        return fail_count(r, item, n);
    io_cursor cursor = {bytes->data + item->seek, bytes->data + bytes->size};
    return io_binary_records(io_model_threads(r->model), &cursor, n, item->type.size, vtk_read_list,
                             &list, r->error);
}

int xdmf_integers(xdmf_reader *r, const xdmf_item *item, int64_t n, int32_t *values) {
    xdmf_file *file = NULL;
    if (item->form == XDMF_HDF5) {
        const int status = xdmf_open(r, item, &file);
        return status ? status : xdmf_hdf5_integers(file, item, n, values);
    }
    if (item->form == XDMF_BYTES && item->type.kind == VTK_REAL)
        return xdmf_fail(&r->document, item->element, "whole numbers were expected");
    return read_list(r, item, n, (vtk_list){.narrow = values});
}

int xdmf_reals(xdmf_reader *r, const xdmf_item *item, int64_t n, double *values) {
    xdmf_file *file = NULL;
    if (item->form != XDMF_HDF5)
        return read_list(r, item, n, (vtk_list){.real = values});
    const int status = xdmf_open(r, item, &file);
    return status ? status : xdmf_hdf5_reals(file, item, n, values);
}
