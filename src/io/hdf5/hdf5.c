/* hdf5: objects of an HDF5 file by their path, their attributes, numbers and text.
 */
#ifdef PL_HDF5
#include "io/core/format.h"
#include "io/hdf5/hdf5_object.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What a filter may make of the bytes of a file. */
enum { LARGEST_EXPANSION = 256, SMALL_DATA = 1 << 20 };

/* ---- errors ------------------------------------------------------------------------------- */

hdf5_voice hdf5_silence(void) {
    hdf5_voice voice = {.is_new = 1};
    H5Eauto_is_v2(H5E_DEFAULT, &voice.is_new);
    if (voice.is_new) {
        H5Eget_auto2(H5E_DEFAULT, &voice.function, &voice.data);
        H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    } else {
        H5Eget_auto1(&voice.old_function, &voice.data);
        H5Eset_auto1(NULL, NULL);
    }
    return voice;
}

void hdf5_restore(hdf5_voice voice) {
    H5Eclear2(H5E_DEFAULT);
    if (voice.is_new)
        H5Eset_auto2(H5E_DEFAULT, voice.function, voice.data);
    else
        H5Eset_auto1(voice.old_function, voice.data);
}

/** Names come from the file and may hold anything. */
static void make_printable(char *text) {
    for (; *text; text++)
        if ((unsigned char)*text < ' ' || *text == 127)
            *text = '?';
}

int io_hdf5_fail(io_hdf5 *file, const char *path, const char *format, ...) {
    char text[384], shown[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    snprintf(shown, sizeof shown, "%s", path);
    make_printable(shown);
    make_printable(text);
    return pl_fail(file->error, PLANISH_ERROR_FORMAT, "%s: %s: %s", file->model->input.path, shown,
                   text);
}

/** The first error that the library met. */
static herr_t take_reason(unsigned n, const H5E_error2_t *entry, void *data) {
    char *text = data;
    if (n == 0 && entry->desc)
        snprintf(text, 128, "%s", entry->desc);
    return 0;
}

static void last_reason(char text[128]) {
    snprintf(text, 128, "no reason given");
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_reason, text);
    make_printable(text);
}

int hdf5_fail_library(io_hdf5 *file, const char *path, const char *text) {
    char reason[128];
    last_reason(reason);
    return io_hdf5_fail(file, path, "%s (HDF5: %s); the file may be damaged", text, reason);
}

int io_hdf5_path(io_hdf5 *file, char *path, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(path, IO_HDF5_PATH_SIZE, format, arguments);
    va_end(arguments);
    if (length < IO_HDF5_PATH_SIZE)
        return PLANISH_OK;
    return io_hdf5_fail(file, path, "this name is too long");
}

/* ---- the file ------------------------------------------------------------------------------ */

/** Links to other files lead nowhere. */
static herr_t refuse_link(const char *parent_file, const char *parent_group, const char *child_file,
                          const char *child_object, unsigned *flags, hid_t access, void *data) {
    (void)parent_file;
    (void)parent_group;
    (void)child_file;
    (void)child_object;
    (void)flags;
    (void)access;
    (void)data;
    return -1;
}

hid_t hdf5_link_access(void) {
    hid_t access = H5Pcreate(H5P_LINK_ACCESS);
    if (access >= 0 && H5Pset_elink_cb(access, refuse_link, NULL) < 0) {
        H5Pclose(access);
        return -1;
    }
    return access;
}

/** *is_open: it could be looked at. */
static io_hdf5_kind kind_in(hid_t file, hid_t access, const char *path, int *is_open) {
    hid_t object = H5Oopen(file, path, access);
    *is_open = object >= 0;
    if (object < 0)
        return IO_HDF5_NONE;
    H5I_type_t type = H5Iget_type(object);
    H5Oclose(object);
    return type == H5I_GROUP ? IO_HDF5_GROUP : type == H5I_DATASET ? IO_HDF5_DATASET : IO_HDF5_NONE;
}

int io_hdf5_recognise(const char *data, int64_t size, const char *path) {
    if (!io_is_hdf5(data, size))
        return 0;
    hdf5_voice voice = hdf5_silence();
    hid_t file = hdf5_open_bytes(data, size, 0), access = hdf5_link_access();
    int is_open;
    int found = file >= 0 && access >= 0 && kind_in(file, access, path, &is_open) != IO_HDF5_NONE;
    if (file >= 0)
        H5Fclose(file);
    if (access >= 0)
        H5Pclose(access);
    hdf5_restore(voice);
    return found;
}

/** Whether there are bytes before HDF5's own; or that cannot be found out. */
static int has_user_block(hid_t id) {
    hsize_t size = 1;
    const hid_t list = H5Fget_create_plist(id);
    if (list >= 0) {
        H5Pget_userblock(list, &size);
        H5Pclose(list);
    }
    return size > 0;
}

int io_hdf5_open(io_model *model, io_hdf5 **out, planish_error *error) {
    *out = NULL;
    model->is_binary = 1;
    if (!io_is_hdf5(model->input.data, model->input.size))
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: this is no HDF5 file (its mark is not there), and the format is one "
                       "in HDF5",
                       model->input.path);
    io_hdf5 *file = pl_alloc_zero(1, sizeof *file);
    if (!file)
        return pl_fail_memory(error, model->input.path);
    *file = (io_hdf5){.model = model, .error = error, .voice = hdf5_silence(), .access = -1};
    file->id = hdf5_open_bytes(model->input.data, model->input.size, 0);
    int status = PLANISH_OK;
    if (file->id < 0)
        status = hdf5_fail_library(file, "/", "cannot be opened");
    else if ((file->access = hdf5_link_access()) < 0)
        status = hdf5_fail_library(file, "/", "cannot be read");
    else
        file->has_user_block = has_user_block(file->id);
    if (status)
        io_hdf5_close(file);
    else
        *out = file;
    return status;
}

void io_hdf5_close(io_hdf5 *file) {
    if (!file)
        return;
    if (file->access >= 0)
        H5Pclose(file->access);
    if (file->id >= 0)
        H5Fclose(file->id);
    hdf5_restore(file->voice);
    pl_free(file->span);
    pl_free(file);
}

/* ---- objects ------------------------------------------------------------------------------ */

/** Whether there is nothing at path for sure: no link of that name in some group above. */
static int is_missing(const io_hdf5 *file, const char *path) {
    char part[IO_HDF5_PATH_SIZE];
    for (const char *end = path; end;) {
        end = strchr(end + 1, '/');
        const size_t length = end ? (size_t)(end - path) : strlen(path);
        if (length >= sizeof part)
            return 0;
        memcpy(part, path, length);
        part[length] = '\0';
        const htri_t exists = H5Lexists(file->id, part, file->access);
        if (exists <= 0)
            return exists == 0;
    }
    return 0;
}

io_hdf5_kind io_hdf5_kind_of(io_hdf5 *file, const char *path) {
    int is_open;
    const io_hdf5_kind kind = kind_in(file->id, file->access, path, &is_open);
    if (!is_open && !file->unknown[0] && !is_missing(file, path))
        snprintf(file->unknown, sizeof file->unknown, "%s", path);
    return kind;
}

int io_hdf5_check(io_hdf5 *file) {
    return file->unknown[0] ? hdf5_fail_library(file, file->unknown, "cannot be looked at")
                            : PLANISH_OK;
}

typedef struct listing {
    io_hdf5 *file;
    const char *path;
    io_hdf5_names *names;
    int status;
} listing;

static int append_name(io_hdf5 *file, io_hdf5_names *names, const char *name) {
    char **grown =
        pl_grow(names->name, names->n, names->n + 1, &names->capacity, sizeof *names->name);
    if (grown)
        names->name = grown;
    size_t size = strlen(name) + 1;
    char *copy = grown ? pl_alloc((int64_t)size, 1) : NULL;
    if (!copy)
        return pl_fail_memory(file->error, "the names of objects");
    memcpy(copy, name, size);
    names->name[names->n++] = copy;
    return PLANISH_OK;
}

static herr_t add_name(hid_t group, const char *name, const H5L_info_t *info, void *data) {
    listing *l = data;
    (void)group;
    if (info->type != H5L_TYPE_HARD && info->type != H5L_TYPE_SOFT)
        l->status = io_hdf5_fail(l->file, l->path,
                                 "'%s' is a link to another file, which is not followed; make one "
                                 "file of them, with h5copy for instance",
                                 name);
    else
        l->status = append_name(l->file, l->names, name);
    return l->status ? -1 : 0;
}

static int compare_names(const void *a, const void *b) {
    char *const *x = a, *const *y = b;
    return strcmp(*x, *y);
}

/* In the order of the file: for any other the library makes a table first, and in a damaged file
 * releases entries of it that it has not filled in (1.10). */
int io_hdf5_list(io_hdf5 *file, const char *path, io_hdf5_names *names) {
    listing l = {file, path, names, PLANISH_OK};
    *names = (io_hdf5_names){0};
    hid_t group = H5Oopen(file->id, path, file->access);
    if (group < 0 || H5Iget_type(group) != H5I_GROUP) {
        l.status = io_hdf5_fail(file, path, "there is no such group");
    } else if (H5Literate(group, H5_INDEX_NAME, H5_ITER_NATIVE, NULL, add_name, &l) < 0 &&
               !l.status) {
        l.status = hdf5_fail_library(file, path, "this group cannot be read");
    }
    if (group >= 0)
        H5Oclose(group);
    if (names->n > 0)
        qsort(names->name, (size_t)names->n, sizeof *names->name, compare_names);
    return l.status;
}

void io_hdf5_names_release(io_hdf5_names *names) {
    for (int64_t i = 0; i < names->n; i++)
        pl_free(names->name[i]);
    pl_free(names->name);
    *names = (io_hdf5_names){0};
}

/* ---- attributes --------------------------------------------------------------------------- */

/** Open the attribute of one value; negative if there is none, or not of one value. */
static hid_t open_attribute(io_hdf5 *file, const char *path, const char *name) {
    hid_t attribute = H5Aopen_by_name(file->id, path, name, H5P_DEFAULT, file->access);
    hid_t space = attribute < 0 ? -1 : H5Aget_space(attribute);
    int is_single = space >= 0 && H5Sget_simple_extent_npoints(space) == 1;
    if (space >= 0)
        H5Sclose(space);
    if (attribute >= 0 && !is_single) {
        H5Aclose(attribute);
        return -1;
    }
    return attribute;
}

int io_hdf5_attribute(io_hdf5 *file, const char *path, const char *name, int64_t *value,
                      int *found) {
    hid_t attribute = open_attribute(file, path, name);
    *found = 0;
    if (attribute < 0)
        return PLANISH_OK;
    hid_t type = H5Aget_type(attribute);
    *found = type >= 0 && H5Tget_class(type) == H5T_INTEGER &&
             H5Aread(attribute, H5T_NATIVE_INT64, value) >= 0;
    if (type >= 0)
        H5Tclose(type);
    H5Aclose(attribute);
    return *found ? PLANISH_OK
                  : io_hdf5_fail(file, path, "its attribute %s is no whole number", name);
}

static int read_fixed_text(hid_t attribute, hid_t type, char *text, size_t size) {
    char copy[IO_HDF5_PATH_SIZE];
    const size_t length = H5Tget_size(type);
    if (length == 0 || length >= sizeof copy || H5Aread(attribute, type, copy) < 0)
        return 0;
    copy[length] = '\0';
    snprintf(text, size, "%s", copy);
    return 1;
}

static int read_variable_text(hid_t attribute, hid_t type, char *text, size_t size) {
    char *copy = NULL;
    if (H5Aread(attribute, type, &copy) < 0 || !copy)
        return 0;
    snprintf(text, size, "%s", copy);
    H5free_memory(copy);
    return 1;
}

int io_hdf5_text_attribute(io_hdf5 *file, const char *path, const char *name, char *text,
                           size_t size, int *found) {
    hid_t attribute = open_attribute(file, path, name);
    *found = 0;
    if (attribute < 0)
        return PLANISH_OK;
    hid_t type = H5Aget_type(attribute);
    if (type >= 0 && H5Tget_class(type) == H5T_STRING)
        *found = H5Tis_variable_str(type) > 0 ? read_variable_text(attribute, type, text, size)
                                              : read_fixed_text(attribute, type, text, size);
    if (type >= 0)
        H5Tclose(type);
    H5Aclose(attribute);
    return *found ? PLANISH_OK : io_hdf5_fail(file, path, "its attribute %s is no text", name);
}

/* ---- datasets ----------------------------------------------------------------------------- */

static int take_shape(io_hdf5 *file, const char *path, hdf5_dataset *d) {
    hid_t space = H5Dget_space(d->id);
    hsize_t dims[2] = {1, 1};
    int rank = space < 0 ? -1 : H5Sget_simple_extent_ndims(space);
    if (rank >= 0 && rank <= 2 && H5Sget_simple_extent_dims(space, dims, NULL) < 0)
        rank = -1;
    H5S_class_t class = space < 0 ? H5S_NO_CLASS : H5Sget_simple_extent_type(space);
    if (space >= 0)
        H5Sclose(space);
    if (rank < 0 || rank > 2)
        return io_hdf5_fail(file, path, "an array of one or two dimensions was expected");
    if (dims[0] > INT64_MAX || dims[1] > INT64_MAX ||
        (dims[1] > 0 && dims[0] > INT64_MAX / dims[1]))
        return io_hdf5_fail(file, path, "its size is too large");
    d->shape = (io_hdf5_shape){.rank = rank, .dims = {(int64_t)dims[0], (int64_t)dims[1]}};
    d->shape.n = class == H5S_NULL ? 0 : d->shape.dims[0] * d->shape.dims[1];
    return PLANISH_OK;
}

/** Only filters that the library has by itself. */
static int check_filters(io_hdf5 *file, const char *path, hid_t list, int *is_plain) {
    int n = H5Pget_nfilters(list);
    *is_plain = n == 0;
    for (int i = 0; i < n; i++) {
        unsigned flags, config;
        size_t n_values = 0;
        char name[64] = "";
        H5Z_filter_t filter =
            H5Pget_filter2(list, (unsigned)i, &flags, &n_values, NULL, sizeof name, name, &config);
        if (filter != H5Z_FILTER_DEFLATE && filter != H5Z_FILTER_SHUFFLE &&
            filter != H5Z_FILTER_FLETCHER32)
            return io_hdf5_fail(file, path,
                                "filter %d (%.40s) is not read; h5repack -f GZIP=4 IN OUT makes a "
                                "file with another",
                                (int)filter, name);
    }
    return n < 0 ? hdf5_fail_library(file, path, "its filters cannot be read") : PLANISH_OK;
}

/** The library takes for granted that the bytes of all values are there, and would read elsewhere.
 */
static int fail_place(io_hdf5 *file, const char *path, const hdf5_dataset *d) {
    return io_hdf5_fail(file, path,
                        "its %lld values are not where they should be; the file is damaged or cut "
                        "short",
                        (long long)d->shape.n);
}

static int check_layout(io_hdf5 *file, const char *path, hid_t list, hdf5_dataset *d) {
    H5D_layout_t layout = H5Pget_layout(list);
    if (layout != H5D_COMPACT && layout != H5D_CONTIGUOUS && layout != H5D_CHUNKED)
        return io_hdf5_fail(file, path,
                            "its data are put together from others (a virtual dataset), which is "
                            "not read; h5repack -l CONTI IN OUT makes them its own");
    if (layout == H5D_CONTIGUOUS && H5Pget_external_count(list) != 0)
        return io_hdf5_fail(file, path,
                            "its data are stored in other files, which is not read; h5repack -l "
                            "CONTI IN OUT puts them into one");
    if (layout == H5D_COMPACT &&
        H5Dget_storage_size(d->id) != (hsize_t)d->shape.n * (hsize_t)d->size)
        return fail_place(file, path, d);
    d->is_chunked = layout == H5D_CHUNKED;
    d->chunk[0] = d->chunk[1] = 1;
    if (d->is_chunked && H5Pget_chunk(list, 2, d->chunk) != d->shape.rank)
        return hdf5_fail_library(file, path, "its chunks cannot be read");
    d->row_block = d->is_chunked ? (int64_t)d->chunk[0] : d->shape.dims[0];
    return check_filters(file, path, list, &d->is_plain);
}

/** What is allocated for it must be in a proportion to the file. */
static int check_size(io_hdf5 *file, const char *path, const hdf5_dataset *d) {
    const int64_t bytes = file->model->input.size;
    const int64_t most =
        d->is_plain ? bytes
                    : (bytes < INT64_MAX / LARGEST_EXPANSION / 2 ? LARGEST_EXPANSION * bytes
                                                                 : INT64_MAX / 2) +
                          SMALL_DATA;
    const int64_t values = most / (d->size > 0 ? d->size : 1);
    if (d->shape.n > values)
        return io_hdf5_fail(file, path,
                            "%lld values of %lld bytes cannot be in a file of %lld bytes; it is "
                            "damaged or cut short",
                            (long long)d->shape.n, (long long)d->size, (long long)bytes);
    /* A chunk may be larger than what there is, but not without limit. */
    const hsize_t largest = (hsize_t)(values < SMALL_DATA ? SMALL_DATA : values);
    if (d->is_chunked && (d->chunk[0] == 0 || d->chunk[1] == 0 || d->chunk[0] > largest ||
                          d->chunk[1] > largest / d->chunk[0]))
        return io_hdf5_fail(file, path, "its chunks of %llu x %llu values are larger than the file",
                            (unsigned long long)d->chunk[0], (unsigned long long)d->chunk[1]);
    return PLANISH_OK;
}

#if H5_VERSION_GE(1, 10, 5)
/** Where the only chunk is, if it has all values and the file has all of it; else HADDR_UNDEF. */
static haddr_t find_only_chunk(const io_hdf5 *file, const hdf5_dataset *d) {
    const haddr_t there = (haddr_t)file->model->input.size;
    const int has_all = !file->has_user_block && d->is_plain &&
                        d->chunk[0] >= (hsize_t)d->shape.dims[0] &&
                        (d->shape.rank == 1 || d->chunk[1] == (hsize_t)d->shape.dims[1]);
    hsize_t at[2] = {0, 0}, size = 0, n = 0;
    unsigned mask = 0;
    haddr_t offset = HADDR_UNDEF;
    const hid_t space = has_all ? H5Dget_space(d->id) : -1;
    const int is_there = space >= 0 && H5Dget_num_chunks(d->id, space, &n) >= 0 && n == 1 &&
                         H5Dget_chunk_info(d->id, space, 0, at, &mask, &offset, &size) >= 0 &&
                         at[0] == 0 && offset <= there && size <= there - offset &&
                         size >= (hsize_t)(d->shape.n * d->size);
    if (space >= 0)
        H5Sclose(space);
    return is_there ? offset : HADDR_UNDEF;
}
#else
static haddr_t find_only_chunk(const io_hdf5 *file, const hdf5_dataset *d) {
    (void)file, (void)d;
    return HADDR_UNDEF;
}
#endif

/** Where its bytes are, if they are in one piece and have been written: all in the file then, and
 * as many as its values need. The library takes both for granted, and reads what is not there. */
static int find_place(io_hdf5 *file, const char *path, hdf5_dataset *d) {
    const haddr_t size = (haddr_t)file->model->input.size;
    const haddr_t needed = (haddr_t)(d->shape.n * d->size);
    const haddr_t offset = d->shape.n == 0 ? HADDR_UNDEF
                           : d->is_chunked ? find_only_chunk(file, d)
                                           : H5Dget_offset(d->id);
    d->offset = -1;
    if (offset == HADDR_UNDEF)
        return PLANISH_OK;
    if (!d->is_chunked &&
        (offset > size || needed > size - offset || H5Dget_storage_size(d->id) != needed))
        return fail_place(file, path, d);
    d->offset = (int64_t)offset;
    return PLANISH_OK;
}

int hdf5_dataset_open(io_hdf5 *file, const char *path, hdf5_dataset *d) {
    *d = (hdf5_dataset){.id = -1, .type = -1};
    if (io_hdf5_kind_of(file, path) != IO_HDF5_DATASET)
        return io_hdf5_fail(file, path, "there is no such array of data");
    d->id = H5Oopen(file->id, path, file->access);
    d->type = d->id < 0 ? -1 : H5Dget_type(d->id);
    hid_t list = d->id < 0 ? -1 : H5Dget_create_plist(d->id);
    int status = PLANISH_OK;
    if (d->type < 0 || list < 0)
        status = hdf5_fail_library(file, path, "cannot be read");
    else
        status = take_shape(file, path, d);
    if (!status) {
        d->size = (int64_t)H5Tget_size(d->type);
        status = check_layout(file, path, list, d);
    }
    if (!status)
        status = check_size(file, path, d);
    if (!status)
        status = find_place(file, path, d);
    if (list >= 0)
        H5Pclose(list);
    return status;
}

void hdf5_dataset_close(hdf5_dataset *d) {
    if (d->type >= 0)
        H5Tclose(d->type);
    if (d->id >= 0)
        H5Oclose(d->id);
    *d = (hdf5_dataset){.id = -1, .type = -1};
}

int io_hdf5_shape_of(io_hdf5 *file, const char *path, io_hdf5_shape *shape) {
    hdf5_dataset d;
    int status = hdf5_dataset_open(file, path, &d);
    *shape = d.shape;
    hdf5_dataset_close(&d);
    return status;
}

/* ---- whole numbers ------------------------------------------------------------------------ */

/** Whether values are signed numbers of 4 or 8 bytes that need no conversion but of byte order. */
static int is_plain_integer(hid_t type, io_hdf5_integers *a) {
    const hid_t little[] = {H5T_STD_I32LE, H5T_STD_I64LE}, big[] = {H5T_STD_I32BE, H5T_STD_I64BE};
    for (int i = 0; i < 2; i++) {
        const int is_little = H5Tequal(type, little[i]) > 0;
        if (!is_little && H5Tequal(type, big[i]) <= 0)
            continue;
        a->size = i ? 8 : 4;
        a->swapped = is_little != io_machine_is_little();
        return 1;
    }
    return 0;
}

static int copy_integers(io_hdf5 *file, const char *path, const hdf5_dataset *d,
                         io_hdf5_integers *a) {
    a->owned = pl_alloc(a->n, sizeof(int64_t));
    a->data = a->owned;
    a->size = sizeof(int64_t);
    a->swapped = 0;
    if (!a->owned)
        return pl_fail_memory(file->error, "the numbers of the file");
    if (H5Dread(d->id, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, a->owned) < 0)
        return hdf5_fail_library(file, path, "its numbers cannot be read");
    return PLANISH_OK;
}

int io_hdf5_integers_read(io_hdf5 *file, const char *path, io_hdf5_integers *a) {
    hdf5_dataset d;
    *a = (io_hdf5_integers){.size = sizeof(int64_t)};
    int status = hdf5_dataset_open(file, path, &d);
    if (!status && H5Tget_class(d.type) != H5T_INTEGER)
        status = io_hdf5_fail(file, path, "whole numbers were expected");
    if (!status) {
        a->n = d.shape.n;
        if (d.offset >= 0 && is_plain_integer(d.type, a))
            a->data = file->model->input.data + d.offset;
        else if (a->n > 0)
            status = copy_integers(file, path, &d, a);
    }
    hdf5_dataset_close(&d);
    return status;
}

void io_hdf5_integers_release(io_hdf5_integers *a) {
    pl_free(a->owned);
    *a = (io_hdf5_integers){.size = sizeof(int64_t)};
}

io_hdf5_numbers io_hdf5_numbers_of(io_hdf5 *file, const char *path, io_hdf5_shape *shape) {
    hdf5_dataset d;
    const int status = hdf5_dataset_open(file, path, &d);
    const H5T_class_t class = status ? H5T_NO_CLASS : H5Tget_class(d.type);
    *shape = d.shape;
    hdf5_dataset_close(&d);
    return class == H5T_INTEGER ? IO_HDF5_WHOLE
           : class == H5T_FLOAT ? IO_HDF5_REAL
                                : IO_HDF5_NEITHER;
}

/* ---- text and other values ---------------------------------------------------------------- */

/** Characters, or numbers of one byte, or a fixed number of these. */
static int is_text(hid_t type) {
    H5T_class_t class = H5Tget_class(type);
    if (class == H5T_STRING)
        return H5Tis_variable_str(type) == 0;
    if (class == H5T_INTEGER)
        return H5Tget_size(type) == 1;
    if (class != H5T_ARRAY)
        return 0;
    hid_t base = H5Tget_super(type);
    int result = base >= 0 && H5Tget_class(base) == H5T_INTEGER && H5Tget_size(base) == 1;
    if (base >= 0)
        H5Tclose(base);
    return result;
}

int io_hdf5_strings_read(io_hdf5 *file, const char *path, char **text, int64_t *n,
                         int64_t *length) {
    hdf5_dataset d;
    *text = NULL;
    int status = hdf5_dataset_open(file, path, &d);
    if (!status && !is_text(d.type))
        status = io_hdf5_fail(file, path, "text was expected");
    if (!status) {
        *n = d.shape.n;
        *length = d.size;
        *text = pl_alloc(d.shape.n, (size_t)d.size);
        if (!*text)
            status = pl_fail_memory(file->error, "the names of groups");
    }
    if (!status && *n > 0 && H5Dread(d.id, d.type, H5S_ALL, H5S_ALL, H5P_DEFAULT, *text) < 0)
        status = hdf5_fail_library(file, path, "its text cannot be read");
    hdf5_dataset_close(&d);
    return status;
}

int io_hdf5_reals_read(io_hdf5 *file, const char *path, double **values, io_hdf5_shape *shape) {
    hdf5_dataset d;
    *values = NULL;
    int status = hdf5_dataset_open(file, path, &d);
    H5T_class_t class = status ? H5T_NO_CLASS : H5Tget_class(d.type);
    *shape = d.shape;
    if (!status && class != H5T_INTEGER && class != H5T_FLOAT)
        status = io_hdf5_fail(file, path, "numbers were expected");
    if (!status) {
        *values = pl_alloc(d.shape.n, sizeof **values);
        if (!*values)
            status = pl_fail_memory(file->error, "the numbers of the file");
    }
    if (!status && d.shape.n > 0 &&
        H5Dread(d.id, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, *values) < 0)
        status = hdf5_fail_library(file, path, "its numbers cannot be read");
    hdf5_dataset_close(&d);
    return status;
}

#endif
