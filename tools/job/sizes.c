/* sizes: the sizes that elements are to have. */
#include "job/sizes.h"

#include "terminal/message.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Sizes that differ by more are no sizes of one mesh, but of another unit or wrong. */
#define MOST_RATIO 1e12

/** Sizes on their way from a file to the nodes of a mesh. */
typedef struct sizing {
    const char *input, *name; /* the mesh's file; the file of the sizes, or the array */
    planish_file *file;
    const planish_mesh *mesh;
    planish_cells cells; /* all elements */
    uint8_t *is_used;    /* [n_nodes] whether a node is of an element, owned */
    planish_data data;   /* as read, owned */
    double *size;        /* [n_nodes] what is found, owned by the caller */
} sizing;

/** Complain of sizes: the text is about the file or array of that name. */
static int complain(const sizing *s, const char *text) {
    return pl_complain(PL_EXIT_FAILED, "%s: %s: %s", s->input, s->name, text);
}

static int complain_memory(const sizing *s) {
    return complain(s, "out of memory for the sizes");
}

/** Allocate n doubles, at least one. */
static double *make_values(int64_t n) {
    return malloc((size_t)(n + 1) * sizeof(double));
}

/* ---- sizes ------------------------------------------------------------------------------------ */

/** Complain of the size of a node or element, as the file numbers it. */
static int complain_size(const sizing *s, int of_elements, int64_t i) {
    const int64_t number = of_elements ? planish_file_element_number(s->file, i)
                                       : planish_file_node_number(s->file, i);
    return pl_complain(PL_EXIT_FAILED,
                       "%s: %s: the size at %s %" PRId64 " is %g: it must be above 0", s->input,
                       s->name, of_elements ? "element" : "node", number, s->data.values[i]);
}

/** Give each node the mean logarithm of the values [cells.n] of its elements; values of 0 do not
 *  count. Nodes without any get 0. */
static int spread(const sizing *s, const double *values, double *size) {
    const int64_t n = s->mesh->n_nodes;
    int32_t *count = calloc((size_t)n + 1, sizeof *count);
    if (!count)
        return complain_memory(s);
    memset(size, 0, (size_t)n * sizeof *size);
    for (int64_t i = 0; i < s->cells.n; i++)
        for (int64_t k = s->cells.offset[i]; values[i] > 0 && k < s->cells.offset[i + 1]; k++) {
            const int32_t node = s->cells.node[k];
            if (node < 0) /* a mid that is missing */
                continue;
            size[node] += log(values[i]);
            count[node]++;
        }
    for (int64_t i = 0; i < n; i++)
        size[i] = count[i] > 0 ? exp(size[i] / count[i]) : 0;
    free(count);
    return 0;
}

/** Give nodes without a size the mean of the others, by their logarithms. */
static int fill_gaps(const sizing *s, double *size) {
    double sum = 0;
    int64_t n = 0;
    for (int64_t i = 0; i < s->mesh->n_nodes; i++)
        if (size[i] > 0) {
            sum += log(size[i]);
            n++;
        }
    if (n == 0)
        return complain(s, "no element has a size");
    for (int64_t i = 0; i < s->mesh->n_nodes; i++)
        if (!(size[i] > 0))
            size[i] = exp(sum / (double)n);
    return 0;
}

/** Check that the sizes differ by no more than those of a mesh can. */
static int check_ratio(const sizing *s, const double *size) {
    int64_t least = 0, most = 0;
    for (int64_t i = 1; i < s->mesh->n_nodes; i++) {
        least = size[i] < size[least] ? i : least;
        most = size[i] > size[most] ? i : most;
    }
    if (size[most] / size[least] <= MOST_RATIO)
        return 0;
    return pl_complain(PL_EXIT_FAILED,
                       "%s: %s: sizes reach from %g at node %" PRId64 " to %g at node %" PRId64
                       ": the largest may be %g times the smallest at most",
                       s->input, s->name, size[least], planish_file_node_number(s->file, least),
                       size[most], planish_file_node_number(s->file, most), MOST_RATIO);
}

/** Take sizes of nodes, or of elements: those of nodes in no element do not matter. */
static int take_sizes(sizing *s) {
    const planish_data *data = &s->data;
    double *size = s->size = make_values(s->mesh->n_nodes);
    if (!size)
        return complain_memory(s);
    for (int64_t i = 0; i < data->n; i++)
        if ((data->of_elements || s->is_used[i]) && !(data->values[i] > 0))
            return complain_size(s, data->of_elements, i);
    for (int64_t i = 0; i < data->n && !data->of_elements; i++)
        size[i] = s->is_used[i] ? data->values[i] : 0;
    int status = data->of_elements ? spread(s, data->values, size) : 0;
    if (!status)
        status = fill_gaps(s, size);
    return status ? status : check_ratio(s, size);
}

/* ---- the input's own sizes --------------------------------------------------------------------- */

/** Take the sizes that the elements have now. */
static int keep_sizes(sizing *s, int threads) {
    planish_error error;
    s->size = make_values(s->mesh->n_nodes);
    if (!s->size)
        return complain_memory(s);
    return planish_find_sizes(s->mesh, threads, s->size, &error) ? complain(s, error.text) : 0;
}

/* ---- reading ------------------------------------------------------------------------------------ */

/** Mark the nodes of elements. */
static int find_used(sizing *s) {
    s->is_used = calloc((size_t)s->mesh->n_nodes + 1, 1);
    if (!s->is_used)
        return complain_memory(s);
    for (int64_t k = 0; k < s->cells.offset[s->cells.n]; k++)
        if (s->cells.node[k] >= 0)
            s->is_used[s->cells.node[k]] = 1;
    return 0;
}

/** Read the array or the file that the options name. */
static int read_values(sizing *s, const pl_arguments *arguments) {
    planish_error error;
    const char *option = arguments->size ? "--size" : "--size-from";
    if (arguments->size ? planish_file_data(s->file, arguments->size, &s->data, &error)
                        : planish_sol_read(arguments->size_from, s->mesh->dim, s->mesh->n_nodes,
                                           &s->data, &error))
        return pl_complain(PL_EXIT_FAILED, "%s: %s", option, error.text);
    if (s->data.n_components == 1)
        return take_sizes(s);
    return pl_complain(
        PL_EXIT_FAILED,
        "%s: %s: has %d numbers for each of its values: a size is one; metrics are not "
        "made targets yet",
        s->input, s->name, s->data.n_components);
}

const char *pl_sizes_source(const pl_arguments *arguments) {
    return arguments->size        ? arguments->size
           : arguments->size_from ? arguments->size_from
                                  : arguments->input;
}

int pl_sizes_read(const pl_arguments *arguments, planish_file *file, int threads,
                  const planish_mesh *mesh, double **size) {
    sizing s = {.input = arguments->input,
                .name = arguments->size        ? arguments->size
                        : arguments->size_from ? arguments->size_from
                                               : "--keep-sizes",
                .file = file,
                .mesh = mesh};
    planish_error error;
    *size = NULL;
    if (planish_file_cells(file, &s.cells, &error))
        return pl_complain(PL_EXIT_FAILED, "%s: %s", arguments->input, error.text);
    int status = find_used(&s);
    if (!status)
        status = arguments->keep_sizes ? keep_sizes(&s, threads) : read_values(&s, arguments);
    planish_data_free(&s.data);
    free(s.is_used);
    *size = s.size;
    return status;
}
