/* twins: numbers of groups that share one in the file. */
#include "io/core/twins.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdlib.h>
#include <string.h>

enum { N_DIMS = 4 };

static int compare_names(const io_twin *x, const io_twin *y) {
    const int64_t p = io_slice_length(x->name), q = io_slice_length(y->name);
    return p != q ? (p < q ? -1 : 1) : p > 0 ? memcmp(x->name.begin, y->name.begin, (size_t)p) : 0;
}

static int compare_twins(const void *a, const void *b) {
    const io_twin *x = a, *y = b;
    if (x->number != y->number)
        return x->number < y->number ? -1 : 1;
    const int order = compare_names(x, y);
    return order ? order : (x->at > y->at) - (x->at < y->at);
}

/** Find where the first of groups [n] is in the file that has members of each dimension: INT64_MAX if none
 *  has. */
static void find_first(const io_twin *twin, int64_t n, int64_t first[N_DIMS]) {
    for (int dim = 0; dim < N_DIMS; dim++) {
        first[dim] = INT64_MAX;
        for (int64_t i = 0; i < n; i++)
            if (twin[i].dims >> dim & 1 && twin[i].at < first[dim])
                first[dim] = twin[i].at;
    }
}

/** Return whether groups [n] of one name are the first of their number in each dimension that they have. */
static int are_first(const io_twin *twin, int64_t n, const int64_t first[N_DIMS]) {
    int64_t own[N_DIMS];
    int are = 1;
    find_first(twin, n, own);
    for (int dim = 0; dim < N_DIMS; dim++)
        are &= own[dim] == INT64_MAX || own[dim] == first[dim];
    return are;
}

/** Give groups [n] of one number and name a number of planish's own. */
static int add_number(io_model *model, io_twin *twin, int64_t n, planish_error *error) {
    const int32_t own = (int32_t)(model->first_twin + model->n_twins);
    if (!pl_append(&model->twin, &model->n_twins, &model->twin_capacity, &twin->number,
                   sizeof twin->number))
        return pl_fail_memory(error, "the numbers of groups");
    for (int64_t i = 0; i < n; i++)
        if (twin[i].own)
            *twin[i].own = own;
    return PLANISH_OK;
}

/** Number groups [n] of one number, sorted by their names. */
static int tell_apart(io_model *model, io_twin *twin, int64_t n, planish_error *error) {
    int64_t first[N_DIMS];
    int status = PLANISH_OK;
    find_first(twin, n, first);
    for (int64_t i = 0, end; i < n && !status; i = end) {
        for (end = i + 1; end < n && compare_names(&twin[i], &twin[end]) == 0;)
            end++;
        if (!are_first(&twin[i], end - i, first))
            status = add_number(model, &twin[i], end - i, error);
    }
    return status;
}

int io_twins_number(io_model *model, io_twin *twin, int64_t n, int64_t most, planish_error *error) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < n; i++) {
        most = twin[i].number > most ? twin[i].number : most;
        if (twin[i].own)
            *twin[i].own = twin[i].number;
    }
    if (n == 0 || most >= INT32_MAX - n)
        return PLANISH_OK;
    model->first_twin = most + 1;
    qsort(twin, (size_t)n, sizeof *twin, compare_twins);
    for (int64_t i = 0, end; i < n && !status; i = end) {
        for (end = i + 1; end < n && twin[end].number == twin[i].number;)
            end++;
        status = tell_apart(model, &twin[i], end - i, error);
    }
    return status;
}
