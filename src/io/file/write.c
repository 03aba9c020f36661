/* write: where files go: the result and its companions.
 *
 * A mesh may be in several files beside one another (TetGen's .node, .ele, ...). The one with the
 * coordinates is written anew (splice.c), the others are copied. All go to temporary files first.
 */
#include "io/core/bytes.h"
#include "base/output.h"
#include "io/file/file.h"
#include "io/file/folder.h"
#include "io/file/plane.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "base/system.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

/* ---- files of a mesh ---------------------------------------------------------------------- */

/** Return the path of the file with the coordinates of the mesh at path, which may name a companion
 *  that the format is known by (.ele). Owned; NULL without memory. */
static char *main_path_of(const io_format *format, const char *path) {
    const char *extension = io_extension(path);
    for (const char *const *kind = format->companions; kind && *kind; kind++)
        if (strcasecmp(*kind, extension) == 0 && io_format_has_extension(format, path))
            return io_companion_path(format, path, format->extensions[0]);
    return pl_copy_text(path);
}

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

/** Count the companions that planish_file_write to path writes: none into a pipe or device, nor
 *  where the input itself is replaced, beside which they are. Folders have theirs in them. */
static int companions_to_write(const planish_file *file, const char *path) {
    if (file->model.folder || file->model.n_companions == 0 || pl_output_is_stream(path))
        return 0;
    char *main_path = main_path_of(file->format, path);
    const int is_input = main_path && strcmp(main_path, file->model.input.path) == 0;
    pl_free(main_path);
    return is_input ? 0 : file->model.n_companions;
}

/** Check what is beside path: nothing of another mesh may be read along with the one that is
 *  written there, and nothing be overwritten that is no companion. */
static int check_strangers(const planish_file *file, const char *path, planish_error *error) {
    const io_model *model = &file->model;
    int status = PLANISH_OK;
    if (companions_to_write(file, path) == 0)
        return PLANISH_OK;
    for (const char *const *kind = file->format->companions; *kind && !status; kind++) {
        int is_written = 0;
        for (int i = 0; i < model->n_companions; i++)
            is_written |= strcasecmp(io_extension(model->companion[i].path), *kind) == 0;
        char *place = io_companion_path(file->format, path, *kind);
        if (!place)
            status = pl_fail_memory(error, path);
        else if (pl_file_exists(place) && is_companion(file, place) != is_written)
            status = pl_fail(
                error, PLANISH_ERROR_FILE,
                is_written ? "%s: is no such file of this mesh and would be overwritten; remove "
                             "it, or choose another name"
                           : "%s: is of another mesh and would be read along with the one to be "
                             "written; remove it, or choose another name",
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
           strcasecmp(io_extension(path), io_extension(file->model.input.path)) == 0;
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
    return check_strangers(file, path, error);
}

/* ---- writing ------------------------------------------------------------------------------ */

static int write_companion(const io_format *format, const io_bytes *companion, const char *path,
                           pl_temporaries temporaries, pl_output *output, planish_error *error) {
    char *target = io_companion_path(format, path, io_extension(companion->path));
    if (!target)
        return pl_fail_memory(error, companion->path);
    pl_file_status a, b;
    int status = PLANISH_OK;
    if (pl_file_find(target, &a) || pl_file_find(companion->path, &b) || !pl_file_is_same(&a, &b)) {
        status = pl_output_open(target, temporaries, output, error);
        if (!status)
            status = pl_output_write(output, companion->data, companion->size, error);
        if (!status)
            status = pl_output_finish(output, error);
    }
    pl_free(target);
    return status;
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

/** Write all temporary files, then rename all. output [1 + n_companions]. */
static int write_all(const planish_file *file, const char *path, const char *main_path,
                     const double *coordinates, int threads, pl_temporaries temporaries,
                     pl_output *output, int n_companions, planish_error *error) {
    const io_bytes *input = &file->model.input;
    int status = io_check_inputs_unchanged(file, error); /* before they are read again */
    if (!status)
        status = pl_output_open(main_path, temporaries, &output[0], error);
    /* What is written as it is, and in the input itself, would be read while it is overwritten. */
    if (!status && !output[0].temporary && io_bytes_are_of(input, output[0].fd))
        status = pl_fail(error, PLANISH_ERROR_FILE,
                         "%s: is the input, which cannot be overwritten while it is read; give the "
                         "input's name to replace it",
                         output[0].target);
    if (!status)
        status = io_write_coordinates(file, coordinates, threads, &output[0], error);
    for (int i = 0; i < n_companions && !status; i++)
        status = write_companion(file->format, &file->model.companion[i], path, temporaries,
                                 &output[i + 1], error);
    /* A failure that comes of an input that changed is better told so. */
    planish_error changed;
    const int is_changed = io_check_inputs_unchanged(file, &changed);
    if (is_changed) {
        status = is_changed;
        if (error)
            *error = changed;
    }
    if (!status)
        status = commit_all(output, 1 + n_companions, temporaries, error);
    for (int i = 0; i <= n_companions; i++)
        pl_output_release(&output[i], temporaries);
    return status;
}

int planish_file_write(const planish_file *file, const char *path, const double *coordinates,
                       int threads, char *temporary, size_t temporary_size, planish_error *error) {
    if (!file || !path || !coordinates)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "file, path and coordinates must not be NULL");
    const pl_outside outside = pl_call_enter(NULL);
    const pl_temporaries temporaries = {temporary, temporary_size};
    const int n_companions = companions_to_write(file, path), dim = file->model.dim;
    const double *places = NULL;
    double *owned = NULL;
    const int is_new_folder = file->model.folder && !io_folder_is_input(file, path);
    char *main_path = file->model.folder          ? pl_copy_text(file->model.input.path)
                      : pl_output_is_stream(path) ? pl_copy_text(path)
                                                  : main_path_of(file->format, path);
    pl_output *output = pl_alloc(n_companions + 1, sizeof *output);
    int status = main_path && output ? PLANISH_OK : pl_fail_memory(error, path);
    for (int i = 0; i <= n_companions && output; i++)
        output[i] = (pl_output){.fd = -1};
    threads = pl_thread_count(threads);
    if (!status)
        status = check_name(file, path, error);
    for (int64_t i = 0; i < dim * file->model.n_nodes && !status; i++)
        if (!(fabs(coordinates[i]) <= DBL_MAX))
            status = pl_fail_at(error, PLANISH_ERROR_ARGUMENT, -1, i / dim,
                                "coordinate %d of node %lld is not finite", (int)(i % dim),
                                (long long)(i / dim));
    if (!status)
        status = io_written_coordinates(&file->model, coordinates, file->model.place_node, threads,
                                        &places, &owned, error);
    if (!status)
        status = check_strangers(file, path, error);
    if (!status && is_new_folder)
        status = io_folder_write(file, path, places, threads, temporaries, error);
    else if (!status)
        status = write_all(file, path, main_path, places, threads, temporaries, output,
                           n_companions, error);
    pl_free(owned);
    pl_free(output);
    pl_free(main_path);
    pl_call_leave(&outside);
    return status;
}
