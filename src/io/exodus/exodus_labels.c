/* exodus_labels: numbers of nodes, and numbers and names of blocks and sets. */
#include "io/exodus/exodus_reader.h"

#include "base/memory.h"
#include "base/status.h"

int exodus_fail_node(exodus_reader *r, const char *name, int64_t i, int64_t place,
                     planish_error *error) {
    return error ? netcdf_fail(r->file, name,
                               "number %lld of the list: node %lld is not in 1 .. %lld",
                               (long long)i + 1, (long long)place, (long long)r->model->n_nodes)
                 : PLANISH_ERROR_FORMAT;
}

/* ---- numbers and names ---------------------------------------------------------------------- */

int exodus_labels_read(exodus_reader *r, const char *numbers, const char *names,
                       exodus_labels *labels) {
    io_hdf5_integers list = {0};
    *labels = (exodus_labels){0};
    int status = netcdf_integers_read(r->file, numbers, &list);
    if (!status) {
        labels->n = list.n;
        labels->number = pl_alloc(list.n, sizeof *labels->number);
        if (!labels->number)
            status = pl_fail_memory(r->error, "the numbers of blocks and sets");
    }
    for (int64_t i = 0; i < labels->n && !status; i++) {
        const int64_t number = io_hdf5_integer(&list, i);
        if (number < INT32_MIN || number > INT32_MAX)
            status = netcdf_fail(r->file, numbers, "number %lld has more than 32 bits",
                                 (long long)number);
        else
            labels->number[i] = (int32_t)number;
    }
    netcdf_integers_release(&list);
    return status ? status : netcdf_texts_read(r->file, names, &labels->names);
}

void exodus_labels_release(exodus_labels *labels) {
    pl_free(labels->number);
    pl_free(labels->names.data);
    *labels = (exodus_labels){0};
}

int exodus_labels_name(exodus_reader *r, const exodus_labels *labels, int64_t i, int dim) {
    char name[512];
    const int64_t length = netcdf_text(&labels->names, i, name, sizeof name);
    return length > 0 ? io_model_group(r->model, dim, labels->number[i], name, length, r->error)
                      : PLANISH_OK;
}
