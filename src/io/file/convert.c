/* convert: what planish understands of a mesh file, written in another format, for viewing. */
#include "io/core/bytes.h"
#include "io/file/file.h"
#include "io/core/output.h"
#include "io/file/plane.h"
#include "io/view/view.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/printf.h"
#include "base/status.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

/** A format that can be converted to. */
static const struct target {
    const io_format *format;
    int (*write)(const io_view *view, io_output *output, const char **lost, planish_error *error);
} targets[] = {{&io_format_vtu, io_view_write_vtu}, {&io_format_vtk, io_view_write_vtk}};

static const struct target *find_target(const planish_file *file, const char *path) {
    for (size_t i = 0; i < sizeof targets / sizeof *targets; i++)
        if (targets[i].format != file->format && io_format_has_extension(targets[i].format, path))
            return &targets[i];
    return NULL;
}

int planish_file_can_convert(const planish_file *file, const char *path) {
    return file && path && find_target(file, path) != NULL;
}

/** A list of what is not written. */
typedef struct losses {
    char *text;
    size_t size, length;
} losses;

static void lose(losses *l, const char *format, ...) PL_PRINTF(2, 3);
static void lose(losses *l, const char *format, ...) {
    va_list arguments;
    if (!l->text || l->length >= l->size)
        return;
    if (l->length > 0)
        l->length += (size_t)snprintf(l->text + l->length, l->size - l->length, ", ");
    va_start(arguments, format);
    if (l->length < l->size)
        l->length += (size_t)vsnprintf(l->text + l->length, l->size - l->length, format, arguments);
    va_end(arguments);
}

static void list_losses(const io_model *model, const char *of_writer, losses *l) {
    const int64_t kept = model->line.n + (model->dim == 3 ? model->triangle.n : 0);
    if (model->n_other > 0)
        lose(l, "%" PRId64 " elements of other types", model->n_other);
    if (model->n_lower > kept)
        lose(l, "%" PRId64 " points, lines or surface elements", model->n_lower - kept);
    if (model->n_periodic > 0)
        lose(l, "%" PRId64 " periodic pairs", model->n_periodic);
    int several = 0;
    for (int32_t i = 0; i < model->n_entities; i++)
        several |= model->entity[i].n_physical > 1;
    if (several)
        lose(l, "all but the first group of elements that are in several");
    if (of_writer)
        lose(l, "%s", of_writer);
    lose(l, "data, parameters and comments of the file");
}

int planish_file_convert(const planish_file *file, const char *path, const double *coordinates,
                         const uint8_t *constraint, const double *radius_ratio, char *temporary,
                         size_t temporary_size, char *lost, size_t lost_size,
                         planish_error *error) {
    const io_temporaries temporaries = {temporary, temporary_size};
    const char *of_writer = NULL;
    io_output output;
    const double *places;
    double *owned;
    if (!file || !path || !coordinates)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "file, path and coordinates must not be NULL");
    const struct target *target = find_target(file, path);
    if (!target)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "%s: meshes are converted to .vtu and .vtk only", path);
    const pl_outside outside = pl_call_enter(NULL);
    output = (io_output){.fd = -1};
    int status =
        io_model_places(&file->model, coordinates, file->model.threads, &places, &owned, error);
    const io_view view = io_view_of(&file->model, places, constraint, radius_ratio);
    if (!status)
        status = io_output_open(path, temporaries, &output, error);
    if (!status)
        status = target->write(&view, &output, &of_writer, error);
    if (!status)
        status = io_output_finish(&output, error);
    if (!status)
        status = io_bytes_check_unchanged(&file->model.input, error);
    if (!status)
        status = io_output_commit(&output, temporaries, error);
    io_output_release(&output, temporaries);
    pl_free(owned);
    pl_call_leave(&outside);
    if (!status && lost && lost_size > 0) {
        losses l = {lost, lost_size, 0};
        lost[0] = '\0';
        list_losses(&file->model, of_writer, &l);
    }
    return status;
}
