/* write: where files go: the result and its companions.
 *
 * A mesh may be in several files (written.h). The one with the coordinates is written anew (splice.c),
 * the others are copied. All go to temporary files first.
 */
#include "io/core/bytes.h"
#include "base/output.h"
#include "io/file/file.h"
#include "io/file/folder.h"
#include "io/file/plane.h"
#include "io/file/written.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "base/system.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

/* ---- files of a mesh ---------------------------------------------------------------------- */

char *io_mesh_file(const char *path, const char *format, int i) {
    const io_format *of = format ? io_format_by_name(format) : io_format_by_extension(path);
    if (io_folder_is(path))
        return io_folder_mesh_file(path, i);
    if (!of || !of->companions)
        return NULL;
    const char *extension = of->extensions[0];
    for (int k = 0; k < i / 2; k++)
        if (!(extension = of->companions[k]))
            return NULL;
    return i % 2 ? io_plain_companion_path(of, path, extension)
                 : io_companion_path(of, path, extension);
}

/** Return whether the file at path would be read as a companion; unreadable files would. */
static int is_companion(const planish_file *file, const char *path) {
    io_bytes bytes;
    planish_error ignored;
    if (!file->format->is_companion)
        return 1;
    if (io_bytes_open_beside(path, file->model.largest_copy, &bytes, &ignored))
        return ignored.code != PLANISH_ERROR_FORMAT; /* empty: neither */
    const int is = file->format->is_companion(&file->model, &bytes);
    io_bytes_close(&bytes);
    return is;
}

/** Check that the other one of the two files that every mesh of the format has is not there without the one at
 *  path: nobody named it to be replaced. */
static int check_pair(const io_format *format, const char *path, planish_error *error) {
    const char *const extension[] = {format->extensions[0], format->companions[0]};
    int status = PLANISH_OK;
    for (int i = 0; i < 2 && !status && !pl_file_exists(path); i++) {
        char *place = io_companion_path(format, path, extension[i]);
        if (!place)
            status = pl_fail_memory(error, path);
        else if (pl_file_exists(place))
            status = pl_fail(error, PLANISH_ERROR_FILE,
                             "%s: is there without %s, and would be overwritten; remove it, or "
                             "choose another name",
                             place, path);
        pl_free(place);
    }
    return status;
}

/** Check what is beside path: nothing of another mesh may be read along with the one that is
 *  written there, and nothing be overwritten that is no companion. */
static int check_strangers(const planish_file *file, const char *path, const io_written_list *list,
                           planish_error *error) {
    const io_model *model = &file->model;
    if (model->folder || list->n < 2 || !file->format->companions)
        return PLANISH_OK;
    int status = check_pair(file->format, path, error);
    for (const char *const *kind = file->format->companions; *kind && !status; kind++) {
        int is_written = 0;
        for (int i = 0; i < model->n_companions; i++)
            is_written |= strcasecmp(io_extension(model->companion[i].path), *kind) == 0;
        char *place = io_companion_path(file->format, path, *kind);
        if (!place)
            status = pl_fail_memory(error, path);
        else if (pl_file_exists(place) && is_companion(file, place) != is_written)
            status = pl_fail(error, PLANISH_ERROR_FILE,
                             is_written ? "%s: is not a file of this mesh, but would be "
                                          "overwritten; remove it, or choose another name"
                                        : "%s: belongs to another mesh, but would be read together "
                                          "with the new mesh; remove it, or choose another name",
                             place);
        pl_free(place);
    }
    return status;
}

/* ---- checks before and after ---------------------------------------------------------------- */

int planish_file_can_write(const planish_file *file, const char *path) {
    if (!file || !path)
        return 0;
    if (file->model.folder)
        return io_folder_can_write(file, path);
    const io_format *format = file->format;
    const int is_name = io_format_has_extension(format, path) &&
                        (!format->may_be_called || format->may_be_called(&file->model, path));
    return pl_output_is_stream(path) || is_name ||
           strcasecmp(io_extension(path), io_extension(io_model_opened(&file->model)->path)) == 0;
}

static int check_name(const planish_file *file, const char *path, planish_error *error) {
    char list[64] = "";
    if (file->model.folder)
        return io_folder_check(file, path, error);
    if (planish_file_can_write(file, path))
        return PLANISH_OK;
    for (const char *const *e = file->format->extensions; *e; e++) {
        const size_t used = strlen(list);
        char name[32];
        snprintf(name, sizeof name, "x%s", *e);
        if (planish_file_can_write(file, name))
            snprintf(list + used, sizeof list - used, "%s%s", used > 0 ? ", " : "", *e);
    }
    return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                   "%s: does not have an extension of the input's format, %s (%s)", path,
                   file->format->name, list);
}

int planish_file_check_output(const planish_file *file, const char *path, planish_error *error) {
    if (!file || !path)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "file and path must not be NULL");
    const int status = check_name(file, path, error);
    if (status)
        return status;
    if (file->format->amend && file->model.of_format && pl_output_is_stream(path))
        return pl_fail(error, PLANISH_ERROR_FILE,
                       "%s: its coordinates are compressed or packed, so that the result cannot be "
                       "written to a pipe or device; give the name of a file",
                       file->model.input.path);
    io_written_list list = {.n = 0};
    int found = file->model.folder ? PLANISH_OK : io_written_find(file, path, &list, error);
    if (!found)
        found = check_strangers(file, path, &list, error);
    io_written_release(&list);
    return found;
}

/* ---- writing ------------------------------------------------------------------------------ */

/** Write bytes with edits made. */
static int write_edited(const io_bytes *bytes, const io_edits *edits, pl_output *output,
                        planish_error *error) {
    int64_t at = 0;
    int status = PLANISH_OK;
    for (int64_t i = 0; i < edits->n && !status; i++) {
        const io_edit *edit = &edits->edit[i];
        status = pl_output_write(output, bytes->data + at, edit->begin - at, error);
        if (!status)
            status = pl_output_write(output, edit->text, edit->length, error);
        at = edit->end;
    }
    return status ? status : pl_output_write(output, bytes->data + at, bytes->size - at, error);
}

/** Write a file that has no coordinates. */
static int write_copy(const planish_file *file, const io_written *written, pl_output *output,
                      planish_error *error) {
    io_bytes bytes;
    int status;
    if (written->from) {
        status = write_edited(written->from, &written->edits, output, error);
    } else {
        status = io_bytes_open_beside(written->source, file->model.largest_copy, &bytes, error);
        if (status)
            return status;
        status = write_edited(&bytes, &written->edits, output, error);
        io_bytes_close(&bytes);
    }
    return status ? status : pl_output_finish(output, error);
}

/** Rename all temporary files: the one with the coordinates, the first, in the end, so that no file
 *  is new if that one is not. */
static int commit_all(pl_output *output, int n, pl_temporaries temporaries, planish_error *error) {
    int status = PLANISH_OK, replaced = 0;
    for (int i = n - 1; i >= 0 && !status; i--) {
        status = pl_output_commit(&output[i], temporaries, error);
        replaced += !status && output[i].is_committed && output[i].replaces;
    }
    for (int i = 0; i < n && status; i++)
        pl_output_undo(&output[i]);
    if (status && replaced > 0 && error) {
        const size_t used = strlen(error->text);
        snprintf(error->text + used, sizeof error->text - used,
                 "; %d other file%s of the new mesh %s in place already", replaced,
                 replaced == 1 ? "" : "s", replaced == 1 ? "is" : "are");
    }
    return status;
}

/** Write all temporary files, then rename all. output [list->n]. */
static int write_all(const planish_file *file, const io_written_list *list,
                     const double *coordinates, int threads, pl_temporaries temporaries,
                     pl_output *output, planish_error *error) {
    const io_bytes *input = &file->model.input;
    int status = io_check_inputs_unchanged(file, error); /* before they are read again */
    for (int64_t i = 0; i < list->n && !status; i++) {
        const io_written *written = &list->file[i];
        status = pl_output_open(written->path, temporaries, &output[i], error);
        /* What is written as it is, and in the input itself, would be read while it is overwritten. */
        if (!status && !output[i].temporary && io_bytes_are_of(input, output[i].fd))
            status = pl_fail(error, PLANISH_ERROR_FILE,
                             "%s: is the input, which cannot be overwritten while it is read; give "
                             "the input's name to replace it",
                             output[i].target);
        if (!status)
            status = written->has_coordinates
                         ? io_write_coordinates(file, coordinates, threads, &output[i], error)
                         : write_copy(file, written, &output[i], error);
    }
    /* A failure that comes of an input that changed is better told so. */
    planish_error changed;
    const int is_changed = io_check_inputs_unchanged(file, &changed);
    if (is_changed) {
        status = is_changed;
        if (error)
            *error = changed;
    }
    if (!status)
        status = commit_all(output, (int)list->n, temporaries, error);
    for (int64_t i = 0; i < list->n; i++)
        pl_output_release(&output[i], temporaries);
    return status;
}

/** Write the files of a mesh that is no folder, with coordinates of places. */
static int write_files(const planish_file *file, const char *path, const double *coordinates,
                       int threads, pl_temporaries temporaries, planish_error *error) {
    io_written_list list = {.n = 0};
    pl_output *output = NULL;
    int status = io_written_find(file, path, &list, error);
    if (!status)
        status = check_strangers(file, path, &list, error);
    if (!status && !(output = pl_alloc(list.n, sizeof *output)))
        status = pl_fail_memory(error, path);
    for (int64_t i = 0; i < list.n && output; i++)
        output[i] = (pl_output){.fd = -1};
    if (!status)
        status = write_all(file, &list, coordinates, threads, temporaries, output, error);
    pl_free(output);
    io_written_release(&list);
    return status;
}

/** Write a folder: a new one, or the file with the coordinates of the input. */
static int write_folder(const planish_file *file, const char *path, const double *coordinates,
                        int threads, pl_temporaries temporaries, planish_error *error) {
    if (!io_folder_is_input(file, path))
        return io_folder_write(file, path, coordinates, threads, temporaries, error);
    io_written input = {
        .from = &file->model.input, .path = file->model.input.path, .has_coordinates = 1};
    const io_written_list list = {.file = &input, .n = 1};
    pl_output output = {.fd = -1};
    return write_all(file, &list, coordinates, threads, temporaries, &output, error);
}

int planish_file_write(const planish_file *file, const char *path, const double *coordinates,
                       const planish_write_options *options, planish_error *error) {
    static const planish_write_options usual = {.threads = 0};
    if (!file || !path || !coordinates)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "file, path and coordinates must not be NULL");
    options = options ? options : &usual;
    int status = pl_check_reserved("planish_write_options", options->reserved,
                                   sizeof options->reserved, error);
    if (status)
        return status;
    const pl_outside outside = pl_call_enter(NULL);
    const pl_temporaries temporaries = {options->temporary, options->temporary_size};
    const int usual_threads = io_model_is_inherited(&file->model) ? 1 : 0;
    const int threads = pl_thread_count(options->threads ? options->threads : usual_threads);
    const double *places = NULL;
    double *owned = NULL;
    status = check_name(file, path, error);
    if (!status)
        status = io_check_coordinates(&file->model, coordinates, error);
    if (!status)
        status = io_written_coordinates(&file->model, coordinates, file->model.place_node, threads,
                                        &places, &owned, error);
    if (!status)
        status = (file->model.folder ? write_folder : write_files)(file, path, places, threads,
                                                                   temporaries, error);
    pl_free(owned);
    pl_call_leave(&outside);
    return status;
}
