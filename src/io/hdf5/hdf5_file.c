/* hdf5_file: an HDF5 file, its objects by their path, and their attributes. */
#ifdef PL_HDF5
#include "io/core/format.h"
#include "io/hdf5/hdf5_image.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- paths -------------------------------------------------------------------------------- */

io_hdf5_path io_hdf5_path_of(io_hdf5 *file, const char *format, ...) {
    io_hdf5_path path;
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(path.text, sizeof path.text, format, arguments);
    va_end(arguments);
    if (length >= IO_HDF5_PATH_SIZE && !file->is_too_long) {
        file->is_too_long = 1;
        memcpy(file->unknown, path.text, sizeof path.text);
    }
    return path;
}

/** Text of the error about a link to another file. */
static const char outside[] = "is a link to another file, which is not followed; make one file of "
                              "them, with h5copy for instance";

/* ---- the file ------------------------------------------------------------------------------ */

/** Find the kind of an object; *is_open: it could be looked at. */
static io_hdf5_kind kind_in(hid_t file, hid_t access, const char *path, int *is_open) {
    hid_t object = H5Oopen(file, path, access);
    *is_open = object >= 0;
    if (object < 0)
        return IO_HDF5_NONE;
    const H5I_type_t type = H5Iget_type(object);
    hdf5_release(object);
    return type == H5I_GROUP ? IO_HDF5_GROUP : type == H5I_DATASET ? IO_HDF5_DATASET : IO_HDF5_NONE;
}

int io_hdf5_recognise(const char *data, int64_t size, const char *path) {
    if (!io_is_hdf5(data, size))
        return 0;
    hdf5_voice voice = hdf5_silence();
    hid_t file = hdf5_open_bytes(data, size), access = hdf5_link_access();
    int is_open;
    int found = file >= 0 && access >= 0 && kind_in(file, access, path, &is_open) != IO_HDF5_NONE;
    if (file >= 0)
        H5Fclose(file);
    hdf5_release(access);
    hdf5_restore(voice);
    return found;
}

int io_hdf5_open(io_model *model, io_hdf5 **out, planish_error *error) {
    *out = NULL;
    model->is_binary = 1;
    if (!io_is_hdf5(model->input.data, model->input.size))
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: this is not an HDF5 file (it does not begin with the mark of HDF5), "
                       "but the format needs one",
                       model->input.path);
    io_hdf5 *file = pl_alloc_zero(1, sizeof *file);
    if (!file)
        return pl_fail_memory(error, model->input.path);
    *file = (io_hdf5){.model = model, .error = error, .voice = hdf5_silence(), .access = -1};
    file->id = hdf5_open_bytes(model->input.data, model->input.size);
    int status = PLANISH_OK;
    if (file->id < 0)
        status = hdf5_fail_library(file, "/", "cannot be opened");
    else if ((file->access = hdf5_link_access()) < 0)
        status = hdf5_fail_library(file, "/", "cannot be read");
    else
        file->has_user_block = hdf5_user_block(file->id) != 0;
    if (status)
        return io_hdf5_end(file, status);
    *out = file;
    return PLANISH_OK;
}

int io_hdf5_end(io_hdf5 *file, int status) {
    if (!file)
        return status;
    /* What is in another file is missing here, whatever the reader said of that. */
    if (file->unknown[0] && (!status || (status == PLANISH_ERROR_FORMAT && file->is_outside)))
        status = io_hdf5_fail(file, file->unknown, "%s",
                              file->is_outside ? outside
                                               : "cannot be looked at; the file may be damaged");
    hdf5_release(file->access);
    if (file->id >= 0)
        H5Fclose(file->id);
    hdf5_restore(file->voice);
    for (int64_t i = 0; i < file->n_kept; i++)
        pl_free(file->kept[i]);
    pl_free(file->kept);
    pl_free(file);
    return status;
}

/* ---- objects ------------------------------------------------------------------------------ */

/** Return whether there is nothing at path for sure: no link of that name in some group above. */
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
    if (!is_open && !file->unknown[0] && !is_missing(file, path)) {
        H5L_info_t about;
        file->is_outside = H5Lget_info(file->id, path, &about, file->access) >= 0 &&
                           about.type != H5L_TYPE_HARD && about.type != H5L_TYPE_SOFT;
        snprintf(file->unknown, sizeof file->unknown, "%s", path);
    }
    return kind;
}

/** Let the file own memory until it is closed; NULL: there is none. */
static void *keep_memory(io_hdf5 *file, void *memory) {
    if (memory &&
        pl_append(&file->kept, &file->n_kept, &file->kept_capacity, &memory, sizeof memory))
        return memory;
    pl_free(memory);
    return NULL;
}

int io_hdf5_names_add(io_hdf5 *file, io_hdf5_names *names, const char *name) {
    enum { FIRST_CAPACITY = 16 };
    char *const text = keep_memory(file, pl_copy_text(name));
    if (names->n == names->capacity) {
        names->capacity = names->n > 0 ? 2 * names->n : FIRST_CAPACITY;
        const char **larger = keep_memory(file, pl_alloc(names->capacity, sizeof *larger));
        if (!larger)
            return pl_fail_memory(file->error, "the names of objects");
        if (names->n > 0)
            memcpy(larger, names->name, (size_t)names->n * sizeof *larger);
        names->name = larger;
    }
    if (!text)
        return pl_fail_memory(file->error, "the names of objects");
    names->name[names->n++] = text;
    return PLANISH_OK;
}

/** A group whose names are listed. */
typedef struct listed_group {
    io_hdf5 *file;
    const char *path;
    io_hdf5_names *names;
    int status;
} listed_group;

static herr_t add_name(hid_t group, const char *name, const H5L_info_t *info, void *data) {
    listed_group *l = data;
    (void)group;
    if (info->type != H5L_TYPE_HARD && info->type != H5L_TYPE_SOFT)
        l->status = io_hdf5_fail(l->file, l->path, "'%s' %s", name, outside);
    else
        l->status = io_hdf5_names_add(l->file, l->names, name);
    return l->status ? -1 : 0;
}

static int compare_names(const void *a, const void *b) {
    const char *const *x = a, *const *y = b;
    return strcmp(*x, *y);
}

/* In the order of the file: for any other the library makes a table first, and in a damaged file
 * releases entries of it that it has not filled in (1.10). */
int io_hdf5_list(io_hdf5 *file, const char *path, io_hdf5_names *names) {
    listed_group l = {file, path, names, PLANISH_OK};
    *names = (io_hdf5_names){0};
    const hid_t group = H5Oopen(file->id, path, file->access);
    if (group < 0 || H5Iget_type(group) != H5I_GROUP)
        l.status = io_hdf5_fail(file, path, "there is no such group");
    else if (H5Literate(group, H5_INDEX_NAME, H5_ITER_NATIVE, NULL, add_name, &l) < 0 && !l.status)
        l.status = hdf5_fail_library(file, path, "this group cannot be read");
    hdf5_release(group);
    if (names->n > 0)
        qsort(names->name, (size_t)names->n, sizeof *names->name, compare_names);
    return l.status;
}

int io_hdf5_check_only(io_hdf5 *file, const char *path, const char *what,
                       const io_hdf5_names *names) {
    if (names->n == 1)
        return PLANISH_OK;
    if (names->n == 0)
        return io_hdf5_fail(file, path, "there is no %s", what);
    return io_hdf5_fail(file, path,
                        "there is more than one %s: %lld (%.60s, %.60s, ...); planish reads files "
                        "with one: write each to a file of its own",
                        what, (long long)names->n, names->name[0], names->name[1]);
}

/* ---- attributes --------------------------------------------------------------------------- */

/** Open the attribute of one value, and its type; negative if there is none, or not of one value. */
static hid_t open_attribute(io_hdf5 *file, const char *path, const char *name, hid_t *type) {
    const hid_t attribute = H5Aopen_by_name(file->id, path, name, H5P_DEFAULT, file->access);
    const hid_t space = attribute < 0 ? -1 : H5Aget_space(attribute);
    const int is_single = space >= 0 && H5Sget_simple_extent_npoints(space) == 1;
    hdf5_release(space);
    *type = is_single ? H5Aget_type(attribute) : -1;
    if (is_single)
        return attribute;
    hdf5_release(attribute);
    return -1;
}

int io_hdf5_attribute(io_hdf5 *file, const char *path, const char *name, int64_t *value,
                      int *found) {
    hid_t type, attribute = open_attribute(file, path, name, &type);
    const int is_read = type >= 0 && H5Tget_class(type) == H5T_INTEGER &&
                        H5Aread(attribute, H5T_NATIVE_INT64, value) >= 0;
    hdf5_release(type);
    hdf5_release(attribute);
    if (found)
        *found = is_read;
    if (attribute >= 0 && !is_read)
        return io_hdf5_fail(file, path, "its attribute %s is not a whole number", name);
    return PLANISH_OK;
}

int io_hdf5_text_attribute(io_hdf5 *file, const char *path, const char *name, char *text,
                           size_t size, int *found) {
    char fixed[IO_HDF5_PATH_SIZE], *variable = NULL;
    hid_t type, attribute = open_attribute(file, path, name, &type);
    const int is_text = type >= 0 && H5Tget_class(type) == H5T_STRING;
    const size_t length = is_text ? H5Tget_size(type) : 0;
    int is_read = 0;
    if (is_text && H5Tis_variable_str(type) > 0) {
        is_read = H5Aread(attribute, type, &variable) >= 0 && variable;
        if (is_read)
            snprintf(text, size, "%s", variable);
        H5free_memory(variable);
    } else if (length > 0 && length < sizeof fixed && H5Aread(attribute, type, fixed) >= 0) {
        fixed[length] = '\0';
        snprintf(text, size, "%s", fixed);
        is_read = 1;
    }
    hdf5_release(type);
    hdf5_release(attribute);
    if (found)
        *found = is_read;
    if (attribute >= 0 && !is_read)
        return io_hdf5_fail(file, path, "its attribute %s is not text", name);
    return PLANISH_OK;
}

#endif
