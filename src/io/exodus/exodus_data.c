/* exodus_data: variables of Exodus files: one number for each node, or each element of some blocks, at
 * each time step, of which the first counts.
 *
 * In io_data begin is the place of a variable, from 0. Of elements there is a part for each block,
 * end, of which n_cells is the first element.
 */
#include "io/exodus/exodus_reader.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/child.h"
#include "io/core/data.h"

enum { NAME_SIZE = 512, MOST_LOOKUPS = 1 << 16 };

/** Name of the values of a variable that is noted. */
static exodus_name values_name(const io_data *data) {
    return exodus_values_name(data->of_elements, data->begin, data->end);
}

/** Note values if they are there. */
static int note_values(exodus_reader *r, const io_data *data) {
    netcdf_shape shape;
    const int status = netcdf_shape_of(r->file, values_name(data).text, &shape);
    if (status) /* the mesh can be read without them */
        return status == PLANISH_ERROR_FORMAT ? PLANISH_OK : status;
    return shape.is_there ? io_data_note(r->model, *data, r->error) : PLANISH_OK;
}

/** Note the values of a variable in all blocks of the elements of the mesh. */
static int note_elements(exodus_reader *r, io_data data) {
    const int dim = io_model_dim(r->model);
    int status = PLANISH_OK;
    for (int64_t k = 0; k < r->n_blocks && !status; k++) {
        const exodus_block *block = &r->block[k];
        const int is_other = block->list == io_others_list(dim);
        if (block->list != dim && !is_other)
            continue;
        data.n = block->n;
        data.n_cells = block->at + (is_other ? io_model_elements(r->model)->n : 0);
        data.end = k;
        status = note_values(r, &data);
    }
    return status;
}

int exodus_note_data(exodus_reader *r) {
    int status = PLANISH_OK;
    for (int of_elements = 0; of_elements < 2 && !status; of_elements++) {
        netcdf_texts names = {0};
        status = netcdf_texts_read(r->file, of_elements ? "name_elem_var" : "name_nod_var", &names);
        const int64_t most = MOST_LOOKUPS / (of_elements ? r->n_blocks + 1 : 1);
        for (int64_t i = 0; i < names.n && i < most && !status; i++) {
            char name[NAME_SIZE];
            const io_data data = {.name = name,
                                  .of_elements = of_elements,
                                  .width = 1,
                                  .n = r->model->n_nodes,
                                  .begin = i};
            /* Of two of a name the first counts. */
            if (netcdf_text(&names, i, name, sizeof name) > 0 &&
                !io_data_find(r->model, name, of_elements))
                status = of_elements ? note_elements(r, data) : note_values(r, &data);
        }
        pl_free(names.data);
    }
    return status;
}

/** An array that is to be read. */
typedef struct data_request {
    io_model *model;
    const io_data *data;
    double *values;
} data_request;

/** Read all parts of an array: io_child_fn. */
static int read_parts(void *context, planish_error *error) {
    const data_request *request = context;
    io_model *model = request->model;
    const io_data *data = request->data;
    const int64_t n = data->of_elements ? io_model_n_elements(model) : model->n_nodes;
    const io_data *const end = model->data + model->n_data;
    int64_t n_read = 0;
    netcdf *file = NULL;
    int status = netcdf_open(model, &file, error);
    for (const io_data *part = data; part < end && !status; part++) {
        if (part->of_elements != data->of_elements || part->begin != data->begin)
            continue;
        status =
            netcdf_values(file, values_name(part).text, part->n, request->values + part->n_cells);
        n_read += part->n;
    }
    if (!status && n_read != n)
        status = netcdf_fail(file, values_name(data).text,
                             "the variable '%.60s' has values for %lld of %lld elements",
                             data->name, (long long)n_read, (long long)n);
    return netcdf_end(file, status);
}

int exodus_read_data(io_model *model, const io_data *data, double *values, planish_error *error) {
    data_request request = {model, data, values};
    /* Whether the HDF5 library crashes is tried out in a child. */
    const int status =
        model->is_isolated ? io_child_run(read_parts, &request, &model->input, error) : PLANISH_OK;
    return status ? status : read_parts(&request, error);
}
