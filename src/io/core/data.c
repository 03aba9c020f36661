/* data: arrays of numbers for nodes or elements. */
#include "io/core/data.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

static int compare_arrays(const void *key, const void *list, int64_t index) {
    const io_data *a = key, *b = (const io_data *)list + index;
    return !a->of_elements == !b->of_elements ? strcmp(a->name, b->name)
                                              : !a->of_elements - !b->of_elements;
}

const io_data *io_data_find(const io_model *model, const char *name, int of_elements) {
    const io_data key = {.name = (char *)(uintptr_t)name, .of_elements = of_elements};
    int64_t place;
    const int64_t i = io_order_find(&model->data_order, &key, model->data, compare_arrays, &place);
    return i < 0 ? NULL : &model->data[i];
}

int io_data_note(io_model *model, io_data data, planish_error *error) {
    if (model->n_data == IO_MOST_DATA)
        return PLANISH_OK;
    int64_t place;
    data.is_more =
        io_order_find(&model->data_order, &data, model->data, compare_arrays, &place) >= 0;
    data.name = pl_copy_text(data.name);
    if (!data.name ||
        !pl_append(&model->data, &model->n_data, &model->data_capacity, &data, sizeof data)) {
        pl_free(data.name);
        return pl_fail_memory(error, "the names of arrays");
    }
    return data.is_more || io_order_insert(&model->data_order, place, model->n_data - 1)
               ? PLANISH_OK
               : pl_fail_memory(error, "the names of arrays");
}

int io_data_fail(const io_model *model, const io_data *data, int64_t at, planish_error *error,
                 const char *text) {
    return io_fail_at(model, model->input.data + at, error, "array '%s': %s", data->name, text);
}

void io_data_pick(const io_model *model, const double *cells, int64_t n_cells, int64_t width,
                  double *values) {
    const int dim = io_model_dim(model), lists[] = {dim, io_others_list(dim)};
    for (int k = 0; k < 2; k++) {
        const io_list list = io_model_list(model, lists[k]);
        for (int64_t i = 0; i < list.n; i++, values += width) {
            const int64_t cell = io_list_number(&list, i);
            if (cell < n_cells)
                memcpy(values, cells + cell * width, (size_t)width * sizeof *values);
        }
    }
}

void planish_data_free(planish_data *data) {
    if (!data)
        return;
    pl_free(data->values);
    *data = (planish_data){.n = 0};
}
