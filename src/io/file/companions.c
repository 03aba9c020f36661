/* companions: the files of a mesh that is in several files beside one another. */
#include "io/core/format.h"
#include "io/file/companions.h"

#include "io/core/bytes.h"
#include "io/core/output.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/system.h"

#include <ctype.h>
#include <string.h>
#include <strings.h>

/* ---- what they are called ----------------------------------------------------------------- */

static int is_listed(const char *const *list, const char *extension) {
    for (; list && *list; list++)
        if (strcasecmp(*list, extension) == 0)
            return 1;
    return 0;
}

char *io_main_path(const io_format *format, const char *path) {
    if (is_listed(format->companions, io_extension(path)) && io_format_has_extension(format, path))
        return io_companion_path(format, path, format->extensions[0]);
    return pl_copy_text(path);
}

char *io_mesh_file(const char *path, const char *format, int i) {
    const io_format *of = format ? io_format_by_name(format) : io_format_by_extension(path);
    if (!of || !of->companions)
        return NULL;
    const char *extension = of->extensions[0];
    for (int k = 0; k < i / 2; k++)
        if (!(extension = of->companions[k]))
            return NULL;
    return i % 2 ? io_plain_companion_path(of, path, extension)
                 : io_companion_path(of, path, extension);
}

/* ---- those that are there ----------------------------------------------------------------- */

/** Whether the file at path is such that it would be read as a companion; unreadable ones are. */
static int is_companion(const planish_file *file, const char *path) {
    io_bytes bytes;
    planish_error ignored;
    if (!file->format->is_companion)
        return 1;
    if (io_bytes_open(path, file->model.largest_copy, &bytes, &ignored))
        return ignored.code != PLANISH_ERROR_FORMAT; /* empty: neither */
    const int is = file->format->is_companion(&file->model, &bytes);
    io_bytes_close(&bytes);
    return is;
}

/** A file at the place of a companion: one that would be read along with what is written, or one of
 *  another kind that a companion would take the place of. */
static int check_stranger(const planish_file *file, const char *path, int is_written,
                          planish_error *error) {
    if (!pl_file_exists(path) || is_companion(file, path) == is_written)
        return PLANISH_OK;
    return pl_fail(error, PLANISH_ERROR_FILE,
                   is_written ? "%s: is no such file of this mesh and would be overwritten; remove "
                                "it, or choose another name"
                              : "%s: is of another mesh and would be read along with the one to be "
                                "written; remove it, or choose another name",
                   path);
}

int io_companions_to_write(const planish_file *file, const char *path) {
    if (file->model.n_companions == 0 || io_output_is_stream(path))
        return 0;
    char *main_path = io_main_path(file->format, path);
    const int is_input = main_path && strcmp(main_path, file->model.input.path) == 0;
    pl_free(main_path);
    return is_input ? 0 : file->model.n_companions;
}

int io_check_strangers(const planish_file *file, const char *path, planish_error *error) {
    const io_model *model = &file->model;
    int status = PLANISH_OK;
    if (io_companions_to_write(file, path) == 0)
        return PLANISH_OK;
    for (const char *const *kind = file->format->companions; *kind && !status; kind++) {
        int known = 0;
        for (int i = 0; i < model->n_companions; i++)
            known |= strcasecmp(io_extension(model->companion[i].path), *kind) == 0;
        char *place = io_companion_path(file->format, path, *kind);
        status = place ? check_stranger(file, place, known, error) : pl_fail_memory(error, path);
        pl_free(place);
    }
    return status;
}
