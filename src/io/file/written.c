/* written: which files planish_file_write makes, and of what.
 *
 * A mesh may be in several files. Companions (TetGen's .node, .ele, ...) have the name of the mesh and
 * another extension. A file may also name the others itself (XDMF): in another folder these keep their
 * names, beside OUT; in the folder of the input the one with the coordinates gets a new name, in which
 * the name of OUT takes the place of that of the input.
 */
#include "io/file/written.h"

#include "io/core/bytes.h"
#include "io/core/include.h"
#include "io/core/text.h"

#include "base/memory.h"
#include "base/output.h"
#include "base/status.h"
#include "base/system.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

/** Return the path of the file with the coordinates of the mesh at path, which may name a companion
 *  that the format is known by (.ele). Owned; NULL without memory. */
static char *main_path_of(const io_format *format, const char *path) {
    const char *extension = io_extension(path);
    for (const char *const *kind = format->companions; kind && *kind; kind++)
        if (strcasecmp(*kind, extension) == 0 && io_format_has_extension(format, path))
            return io_companion_path(format, path, format->extensions[0]);
    return pl_copy_text(path);
}

/** Add a file; its paths are taken over, and released on failure, too. */
static int add(io_written_list *list, io_written file, planish_error *error) {
    if (file.path && pl_append(&list->file, &list->n, &list->capacity, &file, sizeof file))
        return PLANISH_OK;
    pl_free(file.path);
    pl_free(file.source);
    io_edits_destroy(&file.edits);
    return pl_fail_memory(error, "the files to be written");
}

void io_written_release(io_written_list *list) {
    for (int64_t i = 0; i < list->n; i++) {
        pl_free(list->file[i].path);
        pl_free(list->file[i].source);
        io_edits_destroy(&list->file[i].edits);
    }
    pl_free(list->file);
}

static int is_same_file(const char *a, const char *b) {
    pl_file_status p, q;
    return pl_file_find(a, &p) == 0 && pl_file_find(b, &q) == 0 && pl_file_is_same(&p, &q);
}

/* ---- companions ----------------------------------------------------------------------------- */

/** Add the companions: none into a pipe or device, nor where the input itself is replaced, beside
 *  which they are. */
static int add_companions(const planish_file *file, const char *path, io_written_list *list,
                          planish_error *error) {
    const io_model *model = &file->model;
    int status = PLANISH_OK;
    if (pl_output_is_stream(path) || strcmp(list->file[0].path, model->input.path) == 0)
        return PLANISH_OK;
    for (int i = 0; i < model->n_companions && !status; i++) {
        const io_bytes *from = &model->companion[i];
        char *target = io_companion_path(file->format, path, io_extension(from->path));
        if (target && is_same_file(target, from->path))
            pl_free(target);
        else
            status = add(list, (io_written){.from = from, .path = target}, error);
    }
    return status;
}

/* ---- files that the mesh names --------------------------------------------------------------- */

/** Join the folder of path and a name. Owned; NULL without memory. */
static char *beside(const char *path, const char *name) {
    const size_t folder = (size_t)(pl_path_name(path) - path), size = folder + strlen(name) + 1;
    char *joined = pl_alloc((int64_t)size, 1);
    if (joined)
        snprintf(joined, size, "%.*s%s", (int)folder, path, name);
    return joined;
}

static int is_same_folder(const char *a, const char *b) {
    char *p = beside(a, "."), *q = beside(b, ".");
    const int is_same = p && q && is_same_file(p, q);
    pl_free(p);
    pl_free(q);
    return is_same;
}

/** Return whether a name may begin or end beside c, which stands in a file. */
static int is_beside_name(char c) {
    return c == '>' || c == '<' || c == ':' || c == '/' || io_is_space(c);
}

/** Return whether the file at path has the name in it, not as a piece of another one. */
static int has_name(const char *path, const char *name) {
    const int64_t length = (int64_t)strlen(name);
    planish_error ignored;
    io_bytes bytes;
    int has = 0;
    if (!pl_file_exists(path) || io_bytes_open_beside(path, IO_LARGEST_COPY, &bytes, &ignored))
        return 0;
    const char *at = bytes.data, *end = at + bytes.size;
    while (!has && at && end - at >= length) {
        at = memchr(at, *name, (size_t)(end - at - length + 1));
        has = at && memcmp(at, name, (size_t)length) == 0 &&
              (at == bytes.data || is_beside_name(at[-1])) &&
              (end - at == length || is_beside_name(at[length]));
        at += at != NULL;
    }
    io_bytes_close(&bytes);
    return has;
}

/** Check that what is at target, where name is to be written beside OUT, may go: it is a file that OUT
 *  names already, and none of the input. */
static int check_target(const planish_file *file, const char *out, const char *target,
                        const char *name, planish_error *error) {
    const io_model *model = &file->model;
    const char *opened = io_model_opened(model)->path;
    int is_own = is_same_file(target, opened);
    for (int64_t i = 0; i < model->n_beside && !is_own; i++) {
        char *own = beside(opened, model->beside[i]);
        if (!own)
            return pl_fail_memory(error, target);
        is_own = is_same_file(target, own);
        pl_free(own);
    }
    if (is_own)
        return pl_fail(error, PLANISH_ERROR_FILE,
                       "%s: is a file of the input, and would be overwritten; choose another name "
                       "or folder for %s",
                       target, out);
    return !pl_file_exists(target) || has_name(out, name)
               ? PLANISH_OK
               : pl_fail(error, PLANISH_ERROR_FILE,
                         "%s: exists and would be overwritten, but is not a file of %s; remove it, "
                         "or choose another name or folder",
                         target, out);
}

/** Return whether XML has a name of n bytes as it is: UTF-8 without its marks. XDMF has '|' as a mark, and
 *  drops blanks before a name. */
static int is_plain_name(const char *name, size_t n) {
    const unsigned char *at = (const unsigned char *)name, *end = at + n;
    int n_more = 0;
    for (; at < end; at += 1 + n_more) {
        n_more = *at < 0x80   ? 0
                 : *at < 0xC2 ? -1
                 : *at < 0xE0 ? 1
                 : *at < 0xF0 ? 2
                 : *at < 0xF5 ? 3
                              : -1;
        if (*at < ' ' || strchr("&<>|", *at) || n_more < 0 || n_more >= end - at)
            return 0;
        for (int k = 1; k <= n_more; k++)
            if ((at[k] & 0xC0) != 0x80)
                return 0;
    }
    return n == 0 || *name != ' ';
}

/** Make the name of the file with the coordinates beside OUT, in the folder of the input: the name of
 *  OUT takes the place of that of the input. */
static int make_name(const io_model *model, const char *out, char **name, planish_error *error) {
    const char *opened = pl_path_name(io_model_opened(model)->path), *old = model->beside[0];
    const char *last = pl_path_name(old), *out_name = pl_path_name(out);
    const size_t stem = (size_t)(io_extension(opened) - opened);
    const size_t out_stem = (size_t)(io_extension(out_name) - out_name);
    const size_t size = strlen(old) + out_stem + 1;
    *name = NULL;
    if (stem == 0 || strncmp(last, opened, stem) != 0)
        return pl_fail(error, PLANISH_ERROR_FILE,
                       "%s: the coordinates are in %s, and this name does not begin like %s; give "
                       "an OUT in another folder, or %s itself",
                       out, old, opened, opened);
    if (!is_plain_name(out_name, out_stem))
        return pl_fail(error, PLANISH_ERROR_FILE,
                       "%s: this name cannot stand in the XML of the result; choose a name in "
                       "UTF-8 without & < > | and without leading blanks",
                       out);
    *name = pl_alloc((int64_t)size, 1);
    if (!*name)
        return pl_fail_memory(error, out);
    snprintf(*name, size, "%.*s%.*s%s", (int)(last - old), old, (int)out_stem, out_name,
             last + stem);
    return PLANISH_OK;
}

/** Make the edits that let the document name the input by another name. */
static int rename_input(const io_model *model, const char *name, io_edits *edits,
                        planish_error *error) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < model->input_names.n && !status; i++) {
        io_edit edit = model->input_names.edit[i];
        edit.text = pl_copy_text(name);
        edit.length = (int64_t)strlen(name);
        status = edit.text ? io_edits_add(edits, edit, error) : pl_fail_memory(error, name);
    }
    return status;
}

static int is_same_name(const char *a, const char *b) {
    return io_include_compare((io_slice){a, a + strlen(a)}, (io_slice){b, b + strlen(b)}) == 0;
}

/** Add the file of that name beside OUT: the one with the coordinates, or a copy of the input's. */
static int add_beside(const planish_file *file, const char *out, const char *name, int is_input,
                      io_written_list *list, planish_error *error) {
    const io_model *model = &file->model;
    if (is_same_name(name, pl_path_name(out)))
        return pl_fail(error, PLANISH_ERROR_FILE,
                       "%s: is also the name of a file that %s names; choose another name", out,
                       io_model_opened(model)->path);
    io_written written = {.from = is_input ? &model->input : NULL,
                          .source = is_input ? NULL : beside(io_model_opened(model)->path, name),
                          .path = beside(out, name),
                          .has_coordinates = is_input};
    int status = PLANISH_OK, is_none = 0;
    if (!written.path || (!is_input && !written.source))
        status = pl_fail_memory(error, out);
    else if (!is_input) /* a file that is missing beside the input is missing beside OUT, too */
        is_none = !pl_file_exists(written.source) || is_same_file(written.source, written.path);
    if (!status && !is_none)
        status = check_target(file, out, written.path, name, error);
    if (!is_none && !status)
        return add(list, written, error);
    pl_free(written.source);
    pl_free(written.path);
    return status;
}

/** Add the files of a mesh that names others. */
static int add_named(const planish_file *file, const char *out, io_written_list *list,
                     planish_error *error) {
    const io_model *model = &file->model;
    const io_bytes *opened = io_model_opened(model);
    const int has_document = model->document.data != NULL;
    const int is_near = is_same_folder(out, opened->path);
    char *name = NULL;
    if (pl_output_is_stream(out))
        return pl_fail(error, PLANISH_ERROR_FILE,
                       "%s: names other files, %s for one, so that the result cannot be written to "
                       "a pipe or device; give the name of a file",
                       opened->path, model->beside[0]);
    if (is_same_file(out, opened->path))
        return add(list,
                   (io_written){.from = &model->input,
                                .path = pl_copy_text(has_document ? model->input.path : out),
                                .has_coordinates = 1},
                   error);
    io_written first = {
        .from = opened, .path = pl_copy_text(out), .has_coordinates = !has_document};
    int status = is_near && has_document ? make_name(model, out, &name, error) : PLANISH_OK;
    if (!status && name)
        status = rename_input(model, name, &first.edits, error);
    if (!status) {
        status = add(list, first, error);
    } else {
        pl_free(first.path);
        io_edits_destroy(&first.edits);
    }
    if (!status && has_document)
        status = add_beside(file, out, name ? name : model->beside[0], 1, list, error);
    for (int64_t i = has_document; i < model->n_beside && !is_near && !status; i++)
        status = add_beside(file, out, model->beside[i], 0, list, error);
    pl_free(name);
    return status;
}

/* ---- all ------------------------------------------------------------------------------------ */

int io_written_find(const planish_file *file, const char *path, io_written_list *list,
                    planish_error *error) {
    *list = (io_written_list){.n = 0};
    if (file->model.n_beside > 0)
        return add_named(file, path, list, error);
    const int status =
        add(list,
            (io_written){.from = &file->model.input,
                         .path = pl_output_is_stream(path) ? pl_copy_text(path)
                                                           : main_path_of(file->format, path),
                         .has_coordinates = 1},
            error);
    return status ? status : add_companions(file, path, list, error);
}
