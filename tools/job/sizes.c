/* sizes: the sizes that elements are to have. */
#include "job/sizes.h"

#include "terminal/message.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Sizes that differ by more are no sizes of one mesh, but of another unit or wrong. */
#define MOST_RATIO 1e12

/* Largest entry of a metric, so that no sum of metrics overflows. */
#define MOST_ENTRY 1e290

/** Sizes on their way from a file to the nodes of a mesh. */
typedef struct sizing {
    const char *input, *name; /* the mesh's file; the file of the sizes, or the array */
    int is_solution;          /* name is another file's */
    planish_file *file;
    const planish_mesh *mesh;
    planish_cells cells; /* all elements */
    uint8_t *is_used;    /* [n_nodes] whether a node is of an element, owned */
    planish_data data;   /* as read, owned */
    int is_turned;       /* the plane of the mesh is not that of x and y, but: */
    planish_plane plane;
    pl_sizes *found; /* owned by the caller */
} sizing;

/** Complain of sizes: the text is about the file or array of that name. */
static int complain(const sizing *s, const char *text) {
    return pl_complain(PL_EXIT_FAILED, "%s: %s: %s", s->input, s->name, text);
}

static int complain_memory(const sizing *s) {
    return complain(s, "out of memory for the sizes");
}

/** Allocate n doubles, at least one, of 0. */
static double *make_values(int64_t n) {
    return calloc((size_t)n + 1, sizeof(double));
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
    double *size = s->found->size = make_values(s->mesh->n_nodes);
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

/* ---- metrics ---------------------------------------------------------------------------------- */

/* A tensor by rows is symmetric if entries differ by no more than this part of the largest one. */
#define ROUNDING 1e-6

/** Return the places of the entries 11, 12, 22, 13, 23, 33 of a tensor among its values; NULL if the
 *  values are no tensors. */
static const int8_t *places_of(const sizing *s) {
    static const int8_t lower[] = {0, 1, 2, 3, 4, 5}, in_plane[] = {0, 2, 3},
                        by_rows[] = {0, 3, 4, 6, 7, 8};
    const int is_in_plane = s->mesh->dim == 2 && !s->is_turned;
    switch (s->data.n_components) {
    case 3:
        return is_in_plane && s->is_solution ? lower : NULL; /* vectors of a mesh have 3, too */
    case 4:
        return is_in_plane ? in_plane : NULL;
    case 6:
        return lower;
    case 9:
        return by_rows;
    default:
        return NULL;
    }
}

/** Whether tensor value i, if it stands by rows, is symmetric. */
static int is_symmetric(const sizing *s, int64_t i) {
    const int n = s->data.n_components == 9 ? 3 : 2;
    const double *v = s->data.values + i * s->data.n_components;
    double most = 0, off = 0;
    for (int k = 0; k < n * n; k++)
        most = fmax(most, fabs(v[k]));
    for (int r = 0; r < n; r++)
        for (int c = 0; c < r; c++)
            off = fmax(off, fabs(v[n * r + c] - v[n * c + r]));
    return n * n != s->data.n_components || off <= ROUNDING * most;
}

/** Whether the symmetric matrix m is positive definite: its pivots are positive. Quotients keep them in the
 *  range of its entries, however small or large these are. */
static int is_positive(int dim, const double *m) {
    const double left = m[1] / m[0], second = m[2] - left * m[1];
    if (dim == 2)
        return m[0] > 0 && second > 0;
    const double low = m[4] - left * m[3];
    const double third = m[5] - m[3] / m[0] * m[3] - low / second * low;
    return m[0] > 0 && second > 0 && third > 0;
}

/** Largest absolute entry of a metric; infinite where one is not finite. */
static double largest_entry(int n, const double *m) {
    double largest = 0;
    for (int k = 0; k < n; k++)
        largest = isfinite(m[k]) ? fmax(largest, fabs(m[k])) : INFINITY;
    return largest;
}

/** Say what is wrong with the metric of value i. */
static int complain_metric(const sizing *s, int64_t i, const char *what) {
    const int of_elements = s->data.of_elements;
    const int64_t number = of_elements ? planish_file_element_number(s->file, i)
                                       : planish_file_node_number(s->file, i);
    return pl_complain(PL_EXIT_FAILED, "%s: %s: the metric at %s %" PRId64 " %s", s->input, s->name,
                       of_elements ? "element" : "node", number, what);
}

/** Set m, a metric in space, to that in the plane of the mesh. */
static void turn_metric(const planish_plane *plane, double m[6]) {
    const double full[3][3] = {{m[0], m[1], m[3]}, {m[1], m[2], m[4]}, {m[3], m[4], m[5]}};
    const double(*along)[3] = plane->direction;
    double half[2][3];
    for (int a = 0; a < 2; a++)
        for (int c = 0; c < 3; c++)
            half[a][c] =
                along[a][0] * full[0][c] + along[a][1] * full[1][c] + along[a][2] * full[2][c];
    for (int a = 0, k = 0; a < 2; a++)
        for (int b = 0; b <= a; b++, k++)
            m[k] = half[a][0] * along[b][0] + half[a][1] * along[b][1] + half[a][2] * along[b][2];
}

/** Take the metric of value i. */
static int take_metric(const sizing *s, const int8_t *place, int64_t i, double m[6]) {
    const planish_data *data = &s->data;
    const int dim = s->mesh->dim, n = s->is_turned ? 6 : dim * (dim + 1) / 2;
    for (int k = 0; k < n; k++)
        m[k] = data->values[i * data->n_components + place[k]];
    const int is_small = largest_entry(n, m) <= MOST_ENTRY;
    if (s->is_turned)
        turn_metric(&s->plane, m);
    if (!data->of_elements && !s->is_used[i])
        return 0;
    if (!is_small)
        return complain_metric(s, i, "has an entry that is not a number from -1e290 to 1e290");
    if (!is_symmetric(s, i))
        return complain_metric(s, i, "is not symmetric");
    return is_positive(dim, m) ? 0 : complain_metric(s, i, "is not positive definite");
}

/** Add a metric to the sum of a node, behind which the number of those stands. */
static void add_metric(int n, const double *m, double *sum) {
    for (int k = 0; k < n; k++)
        sum[k] += m[k];
    sum[n]++;
}

/** Make the means of sums [n_nodes][n + 1] metrics; nodes without any have that of all. */
static void find_means(int64_t n_nodes, int n, const double *sum, double *metric) {
    double all[7] = {0};
    for (int64_t i = 0; i < n_nodes; i++)
        for (int k = 0; k <= n; k++)
            all[k] += sum[i * (n + 1) + k];
    for (int64_t i = 0; i < n_nodes; i++) {
        const double *of = sum[i * (n + 1) + n] > 0 ? sum + i * (n + 1) : all;
        for (int k = 0; k < n; k++)
            metric[i * n + k] = of[k] / of[n];
    }
}

/** Take metrics of nodes, or of elements; place: of places_of. */
static int take_metrics(sizing *s, const int8_t *place) {
    const int n = s->mesh->dim * (s->mesh->dim + 1) / 2;
    double *metric = s->found->metric = make_values(s->mesh->n_nodes * n);
    double *sum = make_values(s->mesh->n_nodes * (n + 1));
    int status = 0;
    if (!metric || !sum) {
        free(sum);
        return complain_memory(s);
    }
    for (int64_t i = 0; !status && i < s->data.n; i++) {
        double m[6] = {0};
        status = take_metric(s, place, i, m);
        if (!s->data.of_elements && s->is_used[i])
            add_metric(n, m, sum + i * (n + 1));
        if (!s->data.of_elements)
            continue;
        for (int64_t k = s->cells.offset[i]; k < s->cells.offset[i + 1]; k++)
            if (s->cells.node[k] >= 0)
                add_metric(n, m, sum + s->cells.node[k] * (int64_t)(n + 1));
    }
    if (!status)
        find_means(s->mesh->n_nodes, n, sum, metric);
    free(sum);
    return status;
}

/* ---- the input's own sizes --------------------------------------------------------------------- */

/** Take the sizes that the elements have now. */
static int keep_sizes(sizing *s, int threads) {
    planish_error error;
    double *size = s->found->size = make_values(s->mesh->n_nodes);
    if (!size)
        return complain_memory(s);
    return planish_find_sizes(s->mesh, threads, size, &error) ? complain(s, error.text) : 0;
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
static int read_data(sizing *s, const pl_arguments *arguments) {
    planish_error error;
    if (!arguments->size)
        return planish_sol_read(arguments->size_from, s->mesh->dim, s->mesh->n_nodes, &s->data,
                                &error)
                   ? pl_complain(PL_EXIT_FAILED, "--size-from: %s", error.text)
                   : 0;
    const planish_status code = planish_file_data(s->file, arguments->size, &s->data, &error);
    if (code == PLANISH_ERROR_ARGUMENT)
        return pl_complain_usage(pl_command_name(arguments->typed), "--size: %s", error.text);
    return code ? pl_complain(PL_EXIT_FAILED, "--size: %s", error.text) : 0;
}

/** Take the sizes, or the metrics, that the options name. */
static int read_values(sizing *s, const pl_arguments *arguments) {
    const int failed = read_data(s, arguments);
    if (failed)
        return failed;
    const int8_t *place = places_of(s);
    if (place)
        return take_metrics(s, place);
    if (s->is_turned && (s->data.n_components == 3 || s->data.n_components == 4))
        return complain(s, "metrics of two dimensions are for meshes in the plane of x and y: give "
                           "symmetric tensors of three");
    if (s->data.n_components != 1)
        return pl_complain(
            PL_EXIT_FAILED,
            "%s: %s: has %d numbers for each of its values: a size is one number, and a "
            "metric a symmetric tensor",
            s->input, s->name, s->data.n_components);
    return arguments->library.size_weight != 0
               ? take_sizes(s)
               : complain(s, "sizes have no effect with --size-weight 0: give a larger weight");
}

const char *pl_sizes_source(const pl_arguments *arguments) {
    return arguments->size        ? arguments->size
           : arguments->size_from ? arguments->size_from
                                  : arguments->input;
}

int pl_sizes_read(const pl_arguments *arguments, planish_file *file, int threads,
                  const planish_mesh *mesh, pl_sizes *sizes) {
    sizing s = {.input = arguments->input,
                .name = arguments->size        ? arguments->size
                        : arguments->size_from ? arguments->size_from
                                               : "--keep-sizes",
                .is_solution = arguments->size_from != NULL,
                .file = file,
                .mesh = mesh,
                .found = sizes};
    planish_error error;
    *sizes = (pl_sizes){NULL, NULL};
    s.is_turned = planish_file_plane(file, &s.plane);
    if (planish_file_cells(file, &s.cells, &error))
        return pl_complain(PL_EXIT_FAILED, "%s: %s", arguments->input, error.text);
    int status = find_used(&s);
    if (!status)
        status = arguments->keep_sizes ? keep_sizes(&s, threads) : read_values(&s, arguments);
    planish_data_free(&s.data);
    free(s.is_used);
    return status;
}

void pl_sizes_free(pl_sizes *sizes) {
    free(sizes->size);
    free(sizes->metric);
    *sizes = (pl_sizes){NULL, NULL};
}
