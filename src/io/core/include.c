/* include: files that a mesh file names. */
#include "io/core/include.h"

#include "io/core/bytes.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/system.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_TIMES = 16 }; /* that one file may be included */

#ifndef PATH_MAX
#define PATH_MAX 4096
#endif

/** Make the path of the file: name from the folder of the input. Returns 0 if it is too long, or no
 *  name: a '\0' is in it. */
static int join(const io_model *model, io_slice name, char path[PATH_MAX]) {
    const char *base = model->input.path;
    const int folder = (int)(pl_path_name(base) - base);
    if (io_slice_length(name) >= PATH_MAX ||
        memchr(name.begin, '\0', (size_t)io_slice_length(name)))
        return 0;
    const int length =
        snprintf(path, PATH_MAX, "%.*s%.*s", folder, base, (int)io_slice_length(name), name.begin);
    for (char *c = path + folder; *c; c++)
        *c = *c == '\\' ? '/' : *c; /* as files of Windows have it */
    return length > 0 && length < PATH_MAX;
}

/** Return whether path, without links, is in the folder of the input or below; 1 where there is no
 *  such file; -1 without memory. */
static int is_below(const io_model *model, const char *path) {
    char *own = pl_path_resolve(model->input.path);
    int is_out_of_memory = !own && errno == ENOMEM;
    char *other = pl_path_resolve(path);
    is_out_of_memory |= !other && errno == ENOMEM;
    const size_t folder = own ? (size_t)(pl_path_name(own) - own) : 0;
    const int is = !other || (own && strncmp(own, other, folder) == 0);
    free(own);
    free(other);
    return is_out_of_memory ? -1 : is;
}

/** Make the path of a file; return whether it may be read; -1 without memory. */
static int may_be_read(const io_model *model, io_slice name, char path[PATH_MAX]) {
    return io_slice_length(name) > 0 && join(model, name, path) && !pl_path_is_absolute(name.begin)
               ? is_below(model, path)
               : 0;
}

int io_include_find(const io_model *model, io_slice name, char **path, planish_error *error) {
    char text[PATH_MAX];
    const int may_be = may_be_read(model, name, text);
    *path = may_be > 0 ? pl_copy_text(text) : NULL;
    return may_be < 0 || (may_be > 0 && !*path) ? pl_fail_memory(error, model->input.path)
                                                : PLANISH_OK;
}

/** Return how many times the file at path is included already. */
static int times_included(const io_model *model, const char *path) {
    pl_file_status this, other;
    int n = 0;
    for (int i = 0; i < model->n_included && pl_file_find(path, &this) == 0; i++)
        n += pl_file_find(model->included[i].path, &other) == 0 && pl_file_is_same(&this, &other);
    return n;
}

int io_include_open(io_model *model, const char *at, io_slice name, io_cursor *content,
                    planish_error *error) {
    char path[PATH_MAX];
    int64_t n = model->n_included;
    io_bytes file;
    if (io_slice_length(name) == 0)
        return io_fail_at(model, at, error, "the name of the included file is missing");
    const int may_be = may_be_read(model, name, path);
    if (may_be < 0)
        return pl_fail_memory(error, model->input.path);
    if (!may_be)
        return io_fail_at(model, at, error,
                          "'%.*s' is not beside this file or below its folder; copy it there, or "
                          "put its lines in place of this one",
                          IO_QUOTED(name));
    if (n == IO_MOST_INCLUDED)
        return io_fail_at(model, at, error,
                          "more than %d files are included, or one includes itself",
                          IO_MOST_INCLUDED);
    if (times_included(model, path) == MOST_TIMES) /* each time takes memory */
        return io_fail_at(model, at, error, "'%.*s' is included more than %d times, or by itself",
                          IO_QUOTED(name), MOST_TIMES);
    planish_error missing;
    const int status = io_bytes_open_beside(path, model->largest_copy, &file, &missing);
    if (status) { /* the line that names it is what can be changed */
        io_fail_at(model, at, error, "%s", missing.text);
        if (error)
            error->code = status;
        return status;
    }
    if (!io_names_add(&model->included_name, name.begin, io_slice_length(name))) {
        io_bytes_close(&file);
        return pl_fail_memory(error, path);
    }
    if (!pl_append(&model->included, &n, &model->included_capacity, &file, sizeof file)) {
        io_bytes_close(&file);
        return pl_fail_memory(error, path);
    }
    model->n_included = (int)n;
    *content = io_begin_text(file.data, file.size);
    return PLANISH_OK;
}

/** Take the next part of a path; an empty one is behind the last. A backslash is a slash, and '.' is
 *  no part. */
static io_slice next_part(io_slice *path) {
    io_slice part;
    do {
        while (path->begin < path->end && (*path->begin == '/' || *path->begin == '\\'))
            path->begin++;
        part.begin = path->begin;
        while (path->begin < path->end && *path->begin != '/' && *path->begin != '\\')
            path->begin++;
        part.end = path->begin;
    } while (io_slice_is(part, ".", 0));
    return part;
}

int io_include_compare(io_slice a, io_slice b) {
    for (;;) {
        const io_slice p = next_part(&a), q = next_part(&b);
        const int64_t m = io_slice_length(p), n = io_slice_length(q);
        const int order = m > 0 && n > 0 ? memcmp(p.begin, q.begin, (size_t)(m < n ? m : n)) : 0;
        if (order || m != n)
            return order ? order : m < n ? -1 : 1;
        if (m == 0)
            return 0;
    }
}

int io_include_leads_up(io_slice name) {
    for (io_slice part = next_part(&name); io_slice_length(part) > 0; part = next_part(&name))
        if (io_slice_is(part, "..", 0))
            return 1;
    return 0;
}

int io_include_is_hidden(io_slice name) {
    for (io_slice part = next_part(&name); io_slice_length(part) > 0; part = next_part(&name))
        if (*part.begin == '.')
            return 1;
    return 0;
}

int io_include_has(const io_model *model, const char *at) {
    const uintptr_t place = (uintptr_t)at;
    for (int i = 0; i < model->n_included; i++) {
        const uintptr_t begin = (uintptr_t)model->included[i].data;
        if (place >= begin && place <= begin + (uintptr_t)model->included[i].size)
            return 1;
    }
    return 0;
}

int io_include_fail_node(const io_model *model, const char *at, planish_error *error) {
    return io_fail_at(model, at, error,
                      "this file, which %s includes, has nodes: smooth this file instead, with all "
                      "nodes and elements of the mesh in it",
                      model->input.path);
}

void io_include_close(io_model *model) {
    for (int i = 0; i < model->n_included; i++)
        io_bytes_close(&model->included[i]);
    pl_free(model->included);
    model->included = NULL;
    model->n_included = 0;
    model->included_capacity = 0;
}
