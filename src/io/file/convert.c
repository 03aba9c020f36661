/* convert: what planish understands of a mesh file, as a file of another format. */
#include "io/core/bytes.h"
#include "io/file/file.h"
#include "io/file/plane.h"
#include "io/view/view.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/output.h"
#include "base/status.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- targets ------------------------------------------------------------------------------- */

/** Find target i, 0 and up, of all formats, and its format; NULL behind the last. */
static const io_target *target_at(int i, const io_format **format) {
    for (int k = 0; (*format = io_format_at(k)); k++)
        for (const io_target *t = (*format)->targets; t && t->name; t++)
            if (i-- == 0)
                return t;
    return NULL;
}

const char *planish_file_target(int i) {
    const io_format *format;
    const io_target *target = i >= 0 ? target_at(i, &format) : NULL;
    return target ? target->name : NULL;
}

/** Return whether a converted file, which Medit has as text, may be called path. */
static int may_be_called(const io_format *format, const char *path) {
    static const io_model text = {.is_binary = 0};
    return !format->may_be_called || !io_format_has_extension(format, path) ||
           format->may_be_called(&text, path);
}

/** Find the target called name, or (name NULL) that of the extension of path. */
static const io_target *find_target(const char *path, const char *name, const io_format **format) {
    const io_target *target;
    for (int i = 0; (target = target_at(i, format)); i++)
        if (name ? strcmp(target->name, name) == 0
                 : io_format_has_extension(*format, path) && may_be_called(*format, path))
            return target;
    return NULL;
}

const char *planish_file_target_of(const char *path) {
    const io_format *format;
    const io_target *target = path ? find_target(path, NULL, &format) : NULL;
    return target ? target->name : NULL;
}

int planish_file_can_convert(const planish_file *file, const char *path) {
    const io_format *format;
    return file && path && find_target(path, NULL, &format) && format != file->format;
}

static int fail_target(const char *path, const char *name, planish_error *error) {
    char list[256] = "";
    size_t used = 0;
    const char *target;
    for (int i = 0; (target = planish_file_target(i)) && used < sizeof list; i++)
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%s", i ? ", " : "", target);
    return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                   name ? "%s: planish cannot convert to the format '%s'; it converts to %s"
                        : "%s: the extension %sis of no format that meshes are converted to; these "
                          "are %s",
                   path, name ? name : "", list);
}

/* ---- the file's arrays --------------------------------------------------------------------- */

static int load(void *file, const io_view_field *field, planish_data *data, planish_error *error) {
    return io_file_read_data(file, field->name, field->of_elements, data, error);
}

/** Set the integers that hold the values of a field, if any do: the file's may be larger. */
static void find_integers(io_view_field *field, const planish_data *data, io_losses *losses) {
    const double exact = 0x1p53; /* doubles have larger ones only in steps */
    double largest = 0;
    for (int64_t i = 0; i < data->n * data->n_components; i++)
        largest = fmax(largest, fabs(data->values[i]));
    field->is_narrow = largest <= INT32_MAX;
    field->is_integer = largest <= exact;
    if (!field->is_integer)
        io_losses_add(losses, "the last digits of the array '%.64s'", field->name);
}

/** Find the arrays that can be read: field [n_fields], owned; others are lost. */
static int find_fields(planish_file *file, io_view_field **field, int *n_fields, io_losses *losses,
                       planish_error *error) {
    planish_data_info info;
    int64_t n = 0;
    while (planish_file_data_info(file, n, &info))
        n++;
    *n_fields = 0;
    *field = pl_alloc(n, sizeof **field);
    if (!*field)
        return pl_fail_memory(error, "arrays of the file");
    for (int64_t i = 0; i < n && planish_file_data_info(file, i, &info); i++) {
        io_view_field found = {.name = info.name,
                               .of_elements = info.of_elements,
                               .width = info.n_components,
                               .is_integer = io_file_has_integers(file, i)};
        planish_data data;
        planish_error ignored;
        const int status = load(file, &found, &data, &ignored);
        if (!status && found.is_integer)
            find_integers(&found, &data, losses);
        planish_data_free(&data);
        if (status == PLANISH_ERROR_FILE || status == PLANISH_ERROR_MEMORY) {
            if (error)
                *error = ignored;
            return status;
        }
        if (status)
            io_losses_add(losses, "the array '%.64s'", info.name);
        else
            (*field)[(*n_fields)++] = found;
    }
    return PLANISH_OK;
}

/* ---- losses -------------------------------------------------------------------------------- */

/** List keywords, but not too many: "*MATERIAL, *STEP and 3 more keywords". */
static void list_keywords(const io_names *names, io_losses *losses) {
    enum { MOST = 10 };
    char text[IO_VIEW_LOST_SIZE];
    size_t used = 0;
    const int64_t n = names->n > MOST + 1 ? MOST : names->n;
    for (int64_t i = 0; i < n && used < sizeof text; i++)
        used += (size_t)snprintf(text + used, sizeof text - used, "%s%s", i > 0 ? ", " : "",
                                 names->name[i]);
    if (n == 0)
        return;
    if (n < names->n)
        io_losses_add(losses, "%s and %" PRId64 " more keywords", text, names->n - n);
    else
        io_losses_add(losses, "%s", text);
}

/** Return how many elements lose mids, as another one is missing. */
static int64_t count_cut(const io_view *view) {
    int64_t n = 0;
    io_view_cell cell;
    for (int64_t i = 0; i < view->n_cells; i++) {
        io_view_cell_at(view, i, &cell);
        n += cell.loses_mids;
    }
    return n;
}

/** List what no writer writes. */
static void list_losses(const io_view *view, io_losses *losses) {
    const io_model *model = view->model;
    list_keywords(&model->not_carried, losses);
    const int64_t kept =
        model->line.n + (io_model_dim(model) == 3 ? model->triangle.n + model->flat.n : 0);
    const int64_t n_cut = count_cut(view);
    int has_cell_fields = 0;
    for (int i = 0; i < view->n_fields; i++)
        has_cell_fields |= view->field[i].of_elements;
    if (model->n_other > 0)
        io_losses_add(losses, "%" PRId64 " elements of other types", model->n_other);
    if (model->n_lower > kept)
        io_losses_add(losses, "%" PRId64 " points, lines or surface elements",
                      model->n_lower - kept);
    if (n_cut > 0)
        io_losses_add(losses, "mids of %" PRId64 " elements that have not all of them", n_cut);
    if (model->n_periodic > 0)
        io_losses_add(losses, "%" PRId64 " periodic pairs", model->n_periodic);
    if (has_cell_fields && kept > 0)
        io_losses_add(losses, "data of elements of lower dimensions");
    io_losses_add(losses, "parameters and comments");
}

/* ---- conversion ---------------------------------------------------------------------------- */

/** Write a view that has been begun. */
static int write_view(const io_view *view, const io_target *target, const char *path,
                      pl_temporaries temporaries, io_losses *losses, planish_error *error) {
    pl_output output = {.fd = -1};
    int status = pl_output_open(path, temporaries, &output, error);
    if (!status)
        status = target->write(view, &output, losses, error);
    if (!status)
        status = pl_output_finish(&output, error);
    if (!status)
        status = io_bytes_check_unchanged(&view->model->input, error);
    if (!status)
        status = pl_output_commit(&output, temporaries, error);
    pl_output_release(&output, temporaries);
    return status;
}

static int convert(planish_file *file, const io_target *target, const char *path,
                   const double *coordinates, const planish_convert_options *options,
                   io_losses *losses, planish_error *error) {
    const pl_temporaries temporaries = {options->temporary, options->temporary_size};
    const double *places = NULL;
    double *owned = NULL;
    io_view_field *field = NULL;
    io_view view = {.model = NULL};
    int n_fields;
    int status = io_written_coordinates(&file->model, coordinates, NULL,
                                        io_model_threads(&file->model), &places, &owned, error);
    if (!status)
        status = io_view_begin(&file->model, places, options, &view, error);
    if (!status)
        status = find_fields(file, &field, &n_fields, losses, error);
    if (!status) {
        view.field = field;
        view.n_fields = n_fields;
        view.load = load;
        view.file = file;
        status = write_view(&view, target, path, temporaries, losses, error);
    }
    if (!status)
        list_losses(&view, losses);
    io_view_end(&view);
    pl_free(field);
    pl_free(owned);
    return status;
}

int planish_file_check_conversion(const planish_file *file, const char *path, const char *name,
                                  planish_error *error) {
    const io_format *format;
    if (!file || !path)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "file and path must not be NULL");
    const io_target *target = find_target(path, name, &format);
    if (!target)
        return fail_target(path, name, error);
    if (!may_be_called(format, path))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "%s: planish converts to text, which has the extension %s", path,
                       format->extensions[0]);
    return format->check_target ? format->check_target(&file->model, error) : PLANISH_OK;
}

int planish_file_convert(planish_file *file, const char *path, const double *coordinates,
                         const planish_convert_options *options, planish_error *error) {
    static const planish_convert_options usual = {.format = NULL};
    io_losses losses = {.length = 0};
    const io_format *format;
    if (!file || !path || !coordinates)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "file, path and coordinates must not be NULL");
    options = options ? options : &usual;
    int status = pl_check_reserved("planish_convert_options", options->reserved,
                                   sizeof options->reserved, error);
    if (!status)
        status = pl_check_reserved("planish_cell_values", options->cells.reserved,
                                   sizeof options->cells.reserved, error);
    if (!status)
        status = planish_file_check_conversion(file, path, options->format, error);
    if (!status)
        status = io_check_coordinates(&file->model, coordinates, error);
    if (status)
        return status;
    const io_target *target = find_target(path, options->format, &format);
    const pl_outside outside = pl_call_enter(NULL);
    status = convert(file, target, path, coordinates, options, &losses, error);
    pl_call_leave(&outside);
    if (!status && options->lost && options->lost_size > 0)
        snprintf(options->lost, options->lost_size, "%s", losses.text);
    return status;
}
