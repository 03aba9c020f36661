/* gmsh_names: $PhysicalNames, the names of groups; text in binary files, too.
 *
 * A name stands in a line of its own: dimension, number, name in quotes. MSH 2.0 has no dimension,
 * and Gmsh writes -1 for one that it does not know: such a name is that of the groups of that
 * number in all dimensions, which are known when all is read. What stands behind a name says
 * nothing.
 */
#include "io/gmsh/gmsh_sections.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/status.h"

enum { N_DIMS = 4, ANY = -1 };

/** Read the line of a name. */
static int read_name(gmsh_reader *reader) {
    int64_t number[2];
    io_skip_space(&reader->cursor);
    const io_slice line = io_next_line(&reader->cursor);
    const char *open = memchr(line.begin, '"', (size_t)io_slice_length(line));
    /* Before the name: dimension and number, or the number alone. */
    io_cursor cursor = {line.begin, open ? open : line.end};
    int n = 0;
    while (n < 2 && !io_integer(&cursor, &number[n]))
        n++;
    if (n == 0)
        return io_fail_at(reader->model, line.begin, reader->error,
                          "dimension, number and name of a group expected (the file may be cut "
                          "short, or the number of names is wrong)");
    const int64_t dim = n == 2 ? number[0] : ANY, tag = number[n - 1];
    if (dim < ANY || dim >= N_DIMS || tag < INT32_MIN || tag > INT32_MAX)
        return io_fail_at(reader->model, line.begin, reader->error,
                          "group %lld of dimension %lld: out of range", (long long)tag,
                          (long long)dim);
    if (!open) /* nothing in quotes: no name */
        return PLANISH_OK;
    const char *name = open + 1, *close = memchr(name, '"', (size_t)(line.end - name));
    if (!close)
        return io_fail_at(reader->model, line.begin, reader->error,
                          "closing quote of a name expected (the file may be cut short)");
    return io_model_group(reader->model, (int)dim, (int32_t)tag, name, close - name, reader->error);
}

int gmsh_names(gmsh_reader *reader) {
    int64_t n;
    int status = gmsh_take(reader, 0, &n, "number of names");
    for (int64_t i = 0; !status && i < n; i++)
        status = read_name(reader);
    return status;
}

/* ---- names without a dimension ------------------------------------------------------------ */

/** List the physical groups of all entities, *n of them, by dimension and number; owned. */
static gmsh_entity *list_used(const io_model *model, int64_t *n) {
    int64_t n_all = 0;
    for (int32_t i = 0; i < model->n_entities; i++)
        n_all += model->entity[i].n_physical;
    gmsh_entity *used = pl_alloc(n_all, sizeof *used);
    if (!used)
        return NULL;
    *n = 0;
    for (int32_t i = 0; i < model->n_entities; i++)
        for (int k = 0; k < model->entity[i].n_physical; k++)
            used[(*n)++] =
                (gmsh_entity){.dim = model->entity[i].dim, .tag = model->entity[i].physical[k]};
    if (n_all > 0)
        qsort(used, (size_t)n_all, sizeof *used, gmsh_compare_entities);
    return used;
}

/** Give the name of group index the dimensions in which its number is used; where there is none,
 * that of the elements. */
static int complete_name(io_model *model, int32_t index, const gmsh_entity *used, int64_t n,
                         planish_error *error) {
    const int32_t tag = model->group[index].tag;
    for (int dim = 0; dim < N_DIMS; dim++) {
        const gmsh_entity key = {.dim = dim, .tag = tag};
        if (n == 0 || !bsearch(&key, used, (size_t)n, sizeof key, gmsh_compare_entities))
            continue;
        const char *name = model->group[index].name;
        int status = PLANISH_OK;
        if (model->group[index].dim == ANY)
            model->group[index].dim = dim;
        else
            status = io_model_group(model, dim, tag, name, (int64_t)strlen(name), error);
        if (status)
            return status;
    }
    if (model->group[index].dim == ANY)
        model->group[index].dim = io_model_dim(model);
    return PLANISH_OK;
}

int gmsh_complete_names(gmsh_reader *reader) {
    io_model *model = reader->model;
    gmsh_entity *used = NULL;
    int64_t n_used = 0;
    int status = PLANISH_OK;
    const int64_t n = model->n_groups;
    for (int32_t i = 0; !status && i < n; i++) {
        if (model->group[i].dim != ANY)
            continue;
        if (!used && !(used = list_used(model, &n_used)))
            return pl_fail_memory(reader->error, "the names of groups");
        status = complete_name(model, i, used, n_used, reader->error);
    }
    pl_free(used);
    return status;
}
