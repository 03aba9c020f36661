/* sizes: the sizes that elements are to have. */
#include "job/sizes.h"

#include "terminal/message.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Sizes that differ by more are no sizes of one mesh, but of another unit or wrong. */
#define MOST_RATIO 1e12

/* Tensors whose numbers off the diagonal differ by more, of their largest one, are no metrics. */
#define SYMMETRY_TOLERANCE 1e-6

/** Sizes on their way from a file to the nodes of a mesh. */
typedef struct sizing {
    const char *input, *name; /* the mesh's file; the file of the sizes, or the array */
    planish_file *file;
    const planish_mesh *mesh;
    planish_cells cells; /* all elements */
    uint8_t *is_used;    /* [n_nodes] whether a node is of an element, owned */
    planish_data data;   /* as read, owned */
    pl_sizes *sizes;
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
    double *size = s->sizes->size = make_values(s->mesh->n_nodes);
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

/* ---- metrics ----------------------------------------------------------------------------------- */

/** Unfold a tensor of n numbers to m, by rows: returns its rows, or 0 where a full one is not
 *  symmetric. */
static int unfold(const double *from, int n, double m[3][3]) {
    const int rows = n == 9 || n == 6 ? 3 : 2, is_full = n == rows * rows;
    double largest = 0;
    for (int k = 0; k < n; k++)
        largest = fmax(largest, fabs(from[k]));
    for (int i = 0; i < rows; i++)
        for (int j = 0; j <= i; j++) {
            const double a = is_full ? from[i * rows + j] : from[i * (i + 1) / 2 + j];
            const double b = is_full ? from[j * rows + i] : a;
            if (fabs(a - b) > SYMMETRY_TOLERANCE * largest)
                return 0;
            m[i][j] = m[j][i] = a == b ? a : a / 2 + b / 2;
        }
    return rows;
}

/** Fold m to the lower triangle of dim rows. In a plane a tensor in space becomes the one along the
 *  plane's directions. */
static void fold(double m[3][3], int rows, int dim, const planish_plane *plane, double *to) {
    for (int i = 0; i < dim; i++)
        for (int j = 0; j <= i; j++) {
            double sum = 0;
            for (int a = 0; a < 3 && rows > dim; a++)
                for (int b = 0; b < 3; b++)
                    sum += plane->direction[i][a] * m[a][b] * plane->direction[j][b];
            *to++ = rows > dim ? sum : m[i][j];
        }
}

/** Check that the array's tensors can be metrics of the mesh. */
static int check_tensors(const sizing *s) {
    const int n = s->data.n_components, dim = s->mesh->dim;
    const int is_full = n == dim * dim || n == 9, is_half = n == dim * (dim + 1) / 2 || n == 6;
    if (!is_full && !is_half)
        return pl_complain(PL_EXIT_FAILED,
                           "%s: %s: has %d numbers for each of its values: a size is one, a metric "
                           "in %d dimensions %d or %d",
                           s->input, s->name, n, dim, dim * (dim + 1) / 2, dim * dim);
    if (s->data.of_elements)
        return complain(s, "metrics of elements are not read: give them for nodes");
    return 0;
}

static int take_metrics(sizing *s) {
    const planish_data *data = &s->data;
    const int dim = s->mesh->dim, n = data->n_components, n_kept = dim * (dim + 1) / 2;
    planish_plane plane;
    int status = check_tensors(s);
    if (status)
        return status;
    planish_file_plane(s->file, &plane);
    double *metric = s->sizes->metric = make_values(data->n * n_kept);
    if (!metric)
        return complain_memory(s);
    if (plane.is_tilted && dim == 2 && n < 6)
        return complain(s,
                        "the mesh is in a tilted plane: give metrics of 6 or 9 numbers, in space");
    for (int64_t i = 0; i < data->n; i++) {
        double m[3][3];
        const int rows = unfold(data->values + i * n, n, m);
        if (rows == 0)
            return pl_complain(PL_EXIT_FAILED,
                               "%s: %s: the tensor at node %" PRId64 " is not symmetric", s->input,
                               s->name, planish_file_node_number(s->file, i));
        fold(m, rows, dim, &plane, metric + i * n_kept);
    }
    return 0;
}

/* ---- the input's own sizes --------------------------------------------------------------------- */

/** Tetrahedra that a solid is between its corners, or triangles of a flat element. */
typedef struct element_parts {
    int dim, n;        /* of the element; parts */
    double unit;       /* volume (area) of the regular element with edges of 1 */
    int8_t part[5][4]; /* corners of each; of a triangle the first three */
} element_parts;

/** Find the parts of a type of elements, of whatever order. */
static const element_parts *parts_of(uint8_t type) {
    static const element_parts triangle = {2, 1, 0.43301270189221932, {{0, 1, 2, 0}}};
    static const element_parts quadrilateral = {2, 2, 1, {{0, 1, 2, 0}, {0, 2, 3, 0}}};
    static const element_parts tetrahedron = {3, 1, 0.11785113019775792, {{0, 1, 2, 3}}};
    static const element_parts pyramid = {3, 2, 0.23570226039551584, {{0, 1, 2, 4}, {0, 2, 3, 4}}};
    static const element_parts wedge = {
        3, 3, 0.43301270189221932, {{0, 2, 1, 5}, {0, 1, 4, 5}, {0, 4, 3, 5}}};
    static const element_parts hexahedron = {
        3, 5, 1, {{0, 1, 3, 4}, {1, 2, 3, 6}, {1, 6, 4, 5}, {3, 4, 6, 7}, {1, 3, 4, 6}}};
    switch ((planish_cell_type)type) {
    case PLANISH_CELL_TRIANGLE:
    case PLANISH_CELL_TRIANGLE6:
        return &triangle;
    case PLANISH_CELL_TETRAHEDRON:
    case PLANISH_CELL_TETRAHEDRON10:
        return &tetrahedron;
    case PLANISH_CELL_WEDGE:
    case PLANISH_CELL_WEDGE15:
    case PLANISH_CELL_WEDGE18:
        return &wedge;
    case PLANISH_CELL_PYRAMID:
    case PLANISH_CELL_PYRAMID13:
    case PLANISH_CELL_PYRAMID14:
        return &pyramid;
    case PLANISH_CELL_HEXAHEDRON:
    case PLANISH_CELL_HEXAHEDRON20:
    case PLANISH_CELL_HEXAHEDRON27:
        return &hexahedron;
    default:
        return &quadrilateral;
    }
}

/** Find twice the area vector of a triangle, from its first corner's sides. */
static void cross(double u[3], double v[3], double to[3]) {
    for (int d = 0; d < 3; d++)
        to[d] = u[(d + 1) % 3] * v[(d + 2) % 3] - u[(d + 2) % 3] * v[(d + 1) % 3];
}

/** Find the size of an element: the length of the edges of the regular one of its volume. */
static double size_of(const sizing *s, int64_t element) {
    const element_parts *parts = parts_of(s->cells.type[element]);
    const int32_t *node = s->cells.node + s->cells.offset[element];
    const int dim = s->mesh->dim;
    double sum = 0;
    for (int k = 0; k < parts->n; k++) {
        double side[3][3] = {{0}}, area[3];
        const double *from = s->mesh->coordinates + (int64_t)node[parts->part[k][0]] * dim;
        for (int c = 0; c < parts->dim; c++)
            for (int d = 0; d < dim; d++)
                side[c][d] =
                    s->mesh->coordinates[(int64_t)node[parts->part[k][c + 1]] * dim + d] - from[d];
        cross(side[0], side[1], area);
        if (parts->dim == 3)
            sum += (area[0] * side[2][0] + area[1] * side[2][1] + area[2] * side[2][2]) / 6;
        else
            sum += sqrt(area[0] * area[0] + area[1] * area[1] + area[2] * area[2]) / 2;
    }
    return pow(fabs(sum) / parts->unit, 1.0 / parts->dim);
}

/** Take the sizes that the elements have now. */
static int keep_sizes(sizing *s) {
    double *of_elements = make_values(s->cells.n);
    double *size = s->sizes->size = make_values(s->mesh->n_nodes);
    int status = of_elements && size ? 0 : complain_memory(s);
    for (int64_t i = 0; i < s->cells.n && !status; i++)
        of_elements[i] = size_of(s, i);
    if (!status)
        status = spread(s, of_elements, size);
    free(of_elements);
    if (!status)
        status = fill_gaps(s, size);
    return status ? status : check_ratio(s, size);
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
    return s->data.n_components == 1 ? take_sizes(s) : take_metrics(s);
}

int pl_sizes_are_asked(const pl_arguments *arguments) {
    return arguments->size || arguments->size_from || arguments->keep_sizes;
}

int pl_sizes_read(const pl_arguments *arguments, planish_file *file, const planish_mesh *mesh,
                  pl_sizes *sizes) {
    sizing s = {.input = arguments->input,
                .name = arguments->size        ? arguments->size
                        : arguments->size_from ? arguments->size_from
                                               : "--keep-sizes",
                .file = file,
                .mesh = mesh,
                .sizes = sizes};
    planish_error error;
    *sizes = (pl_sizes){.size = NULL};
    if (planish_file_cells(file, &s.cells, &error))
        return pl_complain(PL_EXIT_FAILED, "%s: %s", arguments->input, error.text);
    int status = find_used(&s);
    if (!status)
        status = arguments->keep_sizes ? keep_sizes(&s) : read_values(&s, arguments);
    planish_data_free(&s.data);
    free(s.is_used);
    return status;
}

void pl_sizes_free(pl_sizes *sizes) {
    free(sizes->size);
    free(sizes->metric);
    *sizes = (pl_sizes){.size = NULL};
}
