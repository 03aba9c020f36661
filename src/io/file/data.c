/* data: arrays of numbers that a file has for its nodes or elements. */
#include "io/file/file.h"

#include "io/core/bytes.h"
#include "io/core/data.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/status.h"

#include <stdio.h>

/** Find array i, 0 and up; NULL behind the last. */
static const io_data *data_at(const io_model *model, int64_t i) {
    for (int64_t k = 0; i >= 0 && k < model->n_data; k++)
        if (!model->data[k].is_more && i-- == 0)
            return &model->data[k];
    return NULL;
}

int planish_file_data_info(const planish_file *file, int64_t i, planish_data_info *info) {
    const io_data *data = file && info ? data_at(&file->model, i) : NULL;
    if (!data)
        return 0;
    const int is_known = data->width >= 0 && data->width <= INT32_MAX;
    *info = (planish_data_info){.name = data->name,
                                .of_elements = data->of_elements,
                                .n_components = is_known ? (int)data->width : 0};
    return 1;
}

int io_file_has_integers(const planish_file *file, int64_t i) {
    const io_data *data = data_at(&file->model, i);
    return data && data->is_integer;
}

/** Fail for the name of no array: list those that there are. */
static int fail_name(const planish_file *file, const char *name, planish_error *error) {
    enum { LISTED = 10 };
    char list[256] = "none";
    size_t used = 0;
    planish_data_info info;
    int64_t n = 0;
    for (; n < LISTED && used < sizeof list && planish_file_data_info(file, n, &info); n++)
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%s (%s)", n ? ", " : "",
                                 info.name, info.of_elements ? "elements" : "nodes");
    const int has_more = used < sizeof list && planish_file_data_info(file, n, &info);
    return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                   "%s: there is no array '%s' of numbers for nodes or elements; the file has: "
                   "%s%s",
                   file->model.input.path, name, list, has_more ? ", ..." : "");
}

/** Find the array of that name. */
static int find(const planish_file *file, const char *name, const io_data **data,
                planish_error *error) {
    const io_model *model = &file->model;
    if (!file->format->read_data)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "%s: planish reads arrays of numbers only from files of VTK, "
                       "Gmsh, Exodus and XDMF, not from %s%s",
                       model->input.path, file->format->name,
                       file->format == &io_format_medit ? "; Medit keeps sizes in NAME.sol" : "");
    *data = io_data_find(model, name, 0);
    if (!*data)
        *data = io_data_find(model, name, 1);
    return *data ? PLANISH_OK : fail_name(file, name, error);
}

/** Read the values of an array to data, which is released by the caller on failure. */
static int read_values(planish_file *file, const io_data *array, planish_data *data,
                       planish_error *error) {
    io_model *model = &file->model;
    if (array->width < 1 || array->width > IO_MOST_WIDTH)
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: the array '%s' has %lld numbers for each of its values; arrays of 1 to "
                       "%d are read",
                       model->input.path, array->name, (long long)array->width, IO_MOST_WIDTH);
    const int status = io_bytes_check_unchanged(&model->input, error);
    if (status)
        return status;
    data->of_elements = array->of_elements;
    data->n_components = (int)array->width;
    data->n = array->of_elements ? io_model_n_elements(model) : model->n_nodes;
    data->values = pl_alloc_zero(data->n * array->width, sizeof *data->values);
    return data->values ? file->format->read_data(model, array, data->values, error)
                        : pl_fail_memory(error, "an array of the file");
}

/** Check that all values are finite: the error names the first node or element that has another one. */
static int check_finite(const planish_file *file, const char *name, const planish_data *data,
                        planish_error *error) {
    const int64_t n = data->n * data->n_components;
    int64_t i = 0;
    while (i < n && isfinite(data->values[i]))
        i++;
    if (i == n)
        return PLANISH_OK;
    const int64_t at = i / data->n_components;
    const int is_of_elements = data->of_elements;
    return pl_fail_at(
        error, PLANISH_ERROR_FORMAT, is_of_elements ? at : -1, is_of_elements ? -1 : at,
        "%s: the array '%s' has the value %g, which is not finite, for %s %lld",
        file->model.input.path, name, data->values[i], is_of_elements ? "element" : "node",
        (long long)(is_of_elements ? io_element_number(&file->model, at)
                                   : io_node_number(&file->model, at)));
}

int io_file_read_data(planish_file *file, const char *name, int of_elements, planish_data *data,
                      planish_error *error) {
    const io_data *array = io_data_find(&file->model, name, of_elements);
    *data = (planish_data){.n = 0};
    const int status = array ? read_values(file, array, data, error) : fail_name(file, name, error);
    io_bytes_rest(&file->model.input);
    if (status)
        planish_data_free(data);
    return status;
}

int planish_file_data(planish_file *file, const char *name, planish_data *data,
                      planish_error *error) {
    if (data)
        *data = (planish_data){.n = 0};
    if (!file || !name || !data)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "file, name and data must not be NULL");
    const pl_outside outside = pl_call_enter(NULL);
    const io_data *array = NULL;
    int status = find(file, name, &array, error);
    if (!status)
        status = io_file_read_data(file, name, array->of_elements, data, error);
    if (!status)
        status = check_finite(file, name, data, error);
    if (status)
        planish_data_free(data);
    pl_call_leave(&outside);
    return status;
}
