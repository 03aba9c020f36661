/* gmsh_reader: what the readers of MSH 1, 2 and 4 share: the tables of element types and node orders, single
 * numbers, nodes, elements and periodic pairs. */
#include "io/gmsh/gmsh_reader.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/status.h"

/* ---- element types ------------------------------------------------------------------------ */

/** Element types by Gmsh's numbers. */
static const io_element_type types[] = {
    [1] = {NULL, IO_LINE, 1, 2},
    [2] = {NULL, IO_TRIANGLE, 1, 3},
    [3] = {NULL, IO_QUADRILATERAL, 1, 4},
    [4] = {NULL, IO_TETRAHEDRON, 1, 4},
    [5] = {NULL, IO_HEXAHEDRON, 1, 8},
    [6] = {NULL, IO_PRISM, 1, 6},
    [7] = {NULL, IO_PYRAMID, 1, 5},
    [8] = {NULL, IO_LINE, 2, 3},
    [9] = {NULL, IO_TRIANGLE, 2, 6},
    [10] = {NULL, IO_QUADRILATERAL, 2, 9},
    [11] = {NULL, IO_TETRAHEDRON, 2, 10},
    [12] = {NULL, IO_HEXAHEDRON, 2, 27},
    [13] = {NULL, IO_PRISM, 2, 18},
    [14] = {NULL, IO_PYRAMID, 2, 14},
    [15] = {NULL, IO_POINT, 1, 1},
    [16] = {NULL, IO_QUADRILATERAL, 2, 8},
    [17] = {NULL, IO_HEXAHEDRON, 2, 20},
    [18] = {NULL, IO_PRISM, 2, 15},
    [19] = {NULL, IO_PYRAMID, 2, 13},
    [20] = {NULL, IO_TRIANGLE, 3, 9},
    [21] = {NULL, IO_TRIANGLE, 3, 10},
    [22] = {NULL, IO_TRIANGLE, 4, 12},
    [23] = {NULL, IO_TRIANGLE, 4, 15},
    [24] = {NULL, IO_TRIANGLE, 5, 15},
    [25] = {NULL, IO_TRIANGLE, 5, 21},
    [26] = {NULL, IO_LINE, 3, 4},
    [27] = {NULL, IO_LINE, 4, 5},
    [28] = {NULL, IO_LINE, 5, 6},
    [29] = {NULL, IO_TETRAHEDRON, 3, 20},
    [30] = {NULL, IO_TETRAHEDRON, 4, 35},
    [31] = {NULL, IO_TETRAHEDRON, 5, 56},
    [32] = {NULL, IO_TETRAHEDRON, 4, 22},
    [33] = {NULL, IO_TETRAHEDRON, 5, 28},
    [36] = {NULL, IO_QUADRILATERAL, 3, 16},
    [37] = {NULL, IO_QUADRILATERAL, 4, 25},
    [38] = {NULL, IO_QUADRILATERAL, 5, 36},
    [39] = {NULL, IO_QUADRILATERAL, 3, 12},
    [40] = {NULL, IO_QUADRILATERAL, 4, 16},
    [41] = {NULL, IO_QUADRILATERAL, 5, 20},
    [42] = {NULL, IO_TRIANGLE, 6, 28},
    [43] = {NULL, IO_TRIANGLE, 7, 36},
    [44] = {NULL, IO_TRIANGLE, 8, 45},
    [45] = {NULL, IO_TRIANGLE, 9, 55},
    [46] = {NULL, IO_TRIANGLE, 10, 66},
    [47] = {NULL, IO_QUADRILATERAL, 6, 49},
    [48] = {NULL, IO_QUADRILATERAL, 7, 64},
    [49] = {NULL, IO_QUADRILATERAL, 8, 81},
    [50] = {NULL, IO_QUADRILATERAL, 9, 100},
    [51] = {NULL, IO_QUADRILATERAL, 10, 121},
    [52] = {NULL, IO_TRIANGLE, 6, 18},
    [53] = {NULL, IO_TRIANGLE, 7, 21},
    [54] = {NULL, IO_TRIANGLE, 8, 24},
    [55] = {NULL, IO_TRIANGLE, 9, 27},
    [56] = {NULL, IO_TRIANGLE, 10, 30},
    [57] = {NULL, IO_QUADRILATERAL, 6, 24},
    [58] = {NULL, IO_QUADRILATERAL, 7, 28},
    [59] = {NULL, IO_QUADRILATERAL, 8, 32},
    [60] = {NULL, IO_QUADRILATERAL, 9, 36},
    [61] = {NULL, IO_QUADRILATERAL, 10, 40},
    [62] = {NULL, IO_LINE, 6, 7},
    [63] = {NULL, IO_LINE, 7, 8},
    [64] = {NULL, IO_LINE, 8, 9},
    [65] = {NULL, IO_LINE, 9, 10},
    [66] = {NULL, IO_LINE, 10, 11},
    [71] = {NULL, IO_TETRAHEDRON, 6, 84},
    [72] = {NULL, IO_TETRAHEDRON, 7, 120},
    [73] = {NULL, IO_TETRAHEDRON, 8, 165},
    [74] = {NULL, IO_TETRAHEDRON, 9, 220},
    [75] = {NULL, IO_TETRAHEDRON, 10, 286},
    [79] = {NULL, IO_TETRAHEDRON, 6, 34},
    [80] = {NULL, IO_TETRAHEDRON, 7, 40},
    [81] = {NULL, IO_TETRAHEDRON, 8, 46},
    [82] = {NULL, IO_TETRAHEDRON, 9, 52},
    [83] = {NULL, IO_TETRAHEDRON, 10, 58},
    [84] = {NULL, IO_LINE, 0, 1},
    [85] = {NULL, IO_TRIANGLE, 0, 1},
    [86] = {NULL, IO_QUADRILATERAL, 0, 1},
    [87] = {NULL, IO_TETRAHEDRON, 0, 1},
    [88] = {NULL, IO_HEXAHEDRON, 0, 1},
    [89] = {NULL, IO_PRISM, 0, 1},
    [90] = {NULL, IO_PRISM, 3, 40},
    [91] = {NULL, IO_PRISM, 4, 75},
    [92] = {NULL, IO_HEXAHEDRON, 3, 64},
    [93] = {NULL, IO_HEXAHEDRON, 4, 125},
    [94] = {NULL, IO_HEXAHEDRON, 5, 216},
    [95] = {NULL, IO_HEXAHEDRON, 6, 343},
    [96] = {NULL, IO_HEXAHEDRON, 7, 512},
    [97] = {NULL, IO_HEXAHEDRON, 8, 729},
    [98] = {NULL, IO_HEXAHEDRON, 9, 1000},
    [99] = {NULL, IO_HEXAHEDRON, 3, 32},
    [100] = {NULL, IO_HEXAHEDRON, 4, 44},
    [101] = {NULL, IO_HEXAHEDRON, 5, 56},
    [102] = {NULL, IO_HEXAHEDRON, 6, 68},
    [103] = {NULL, IO_HEXAHEDRON, 7, 80},
    [104] = {NULL, IO_HEXAHEDRON, 8, 92},
    [105] = {NULL, IO_HEXAHEDRON, 9, 104},
    [106] = {NULL, IO_PRISM, 5, 126},
    [107] = {NULL, IO_PRISM, 6, 196},
    [108] = {NULL, IO_PRISM, 7, 288},
    [109] = {NULL, IO_PRISM, 8, 405},
    [110] = {NULL, IO_PRISM, 9, 550},
    [111] = {NULL, IO_PRISM, 3, 24},
    [112] = {NULL, IO_PRISM, 4, 33},
    [113] = {NULL, IO_PRISM, 5, 42},
    [114] = {NULL, IO_PRISM, 6, 51},
    [115] = {NULL, IO_PRISM, 7, 60},
    [116] = {NULL, IO_PRISM, 8, 69},
    [117] = {NULL, IO_PRISM, 9, 78},
    [118] = {NULL, IO_PYRAMID, 3, 30},
    [119] = {NULL, IO_PYRAMID, 4, 55},
    [120] = {NULL, IO_PYRAMID, 5, 91},
    [121] = {NULL, IO_PYRAMID, 6, 140},
    [122] = {NULL, IO_PYRAMID, 7, 204},
    [123] = {NULL, IO_PYRAMID, 8, 285},
    [124] = {NULL, IO_PYRAMID, 9, 385},
    [125] = {NULL, IO_PYRAMID, 3, 21},
    [126] = {NULL, IO_PYRAMID, 4, 29},
    [127] = {NULL, IO_PYRAMID, 5, 37},
    [128] = {NULL, IO_PYRAMID, 6, 45},
    [129] = {NULL, IO_PYRAMID, 7, 53},
    [130] = {NULL, IO_PYRAMID, 8, 61},
    [131] = {NULL, IO_PYRAMID, 9, 69},
    [132] = {NULL, IO_PYRAMID, 0, 1},
    [137] = {NULL, IO_TETRAHEDRON, 3, 16},
};

int gmsh_compare_entities(const void *left, const void *right) {
    const gmsh_entity *a = left, *b = right;
    if (a->dim != b->dim)
        return a->dim < b->dim ? -1 : 1;
    return (a->tag > b->tag) - (a->tag < b->tag);
}

int gmsh_find_type(const gmsh_reader *reader, int64_t number, const char *at,
                   const io_element_type **type, planish_error *error) {
    const int is_known = number > 0 && number < (int64_t)(sizeof types / sizeof *types) &&
                         types[number].shape != IO_NO_SHAPE;
    if (!is_known)
        return io_fail_at(reader->model, at, error, "element type %lld is not known",
                          (long long)number);
    *type = &types[number];
    if (io_element_use(*type) == IO_REFUSE)
        return io_fail_order(reader->model, at,
                             (*type)->shape == IO_TRIANGLE ? "triangles" : "tetrahedra",
                             " (mesh again with gmsh -order 1 or 2)", error);
    return PLANISH_OK;
}

/* Gmsh lists the edges of a corner before those of the next one, and then faces. */
const io_node_order gmsh_node_orders[] = {
    {PLANISH_CELL_TETRAHEDRON10, {0, 1, 2, 3, 4, 5, 6, 7, 9, 8}},
    {PLANISH_CELL_HEXAHEDRON20,
     {0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15}},
    {PLANISH_CELL_HEXAHEDRON27, {0,  1,  2,  3,  4,  5,  6,  7,  8,  11, 13, 9,  16, 18,
                                 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26}},
    {PLANISH_CELL_WEDGE15, {0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11}},
    {PLANISH_CELL_WEDGE18, {0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11, 15, 17, 16}},
    {PLANISH_CELL_PYRAMID13, {0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12}},
    {PLANISH_CELL_PYRAMID14, {0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12, 13}},
    {0, {0}}};

/* ---- single numbers and counts ------------------------------------------------------------ */

int gmsh_fail_expected(const gmsh_reader *reader, const char *what) {
    return io_fail_at(reader->model, reader->cursor.at, reader->error,
                      "%s expected (the file may be cut short)", what);
}

int gmsh_take(gmsh_reader *reader, int bytes, int64_t *value, const char *what) {
    if (io_number(&reader->cursor, reader->model->is_binary ? bytes : 0, reader->swapped, value) ||
        (bytes == 4 && (*value < INT32_MIN || *value > INT32_MAX)))
        return gmsh_fail_expected(reader, what);
    return PLANISH_OK;
}

int gmsh_skip_integers(gmsh_reader *reader, int bytes, int64_t n, const char *what) {
    int64_t ignored;
    int status = PLANISH_OK;
    for (int64_t i = 0; i < n && !status; i++)
        status = gmsh_take(reader, bytes, &ignored, what);
    return status;
}

int gmsh_skip_reals(gmsh_reader *reader, int64_t n, const char *what) {
    const int is_binary = reader->model->is_binary;
    double value;
    if (n < 0 || (is_binary && n > io_left(&reader->cursor) / 8))
        return gmsh_fail_expected(reader, what);
    if (is_binary)
        reader->cursor.at += 8 * n;
    for (int64_t i = 0; !is_binary && i < n; i++)
        if (io_real(&reader->cursor, &value))
            return gmsh_fail_expected(reader, what);
    return PLANISH_OK;
}

int gmsh_end_line(gmsh_reader *reader) {
    io_cursor *cursor = &reader->cursor;
    if (!reader->model->is_binary)
        return PLANISH_OK;
    const char *newline = memchr(cursor->at, '\n', (size_t)io_left(cursor));
    if (!newline)
        return gmsh_fail_expected(reader, "end of line");
    cursor->at = newline + 1;
    return PLANISH_OK;
}

int gmsh_check_count(const gmsh_reader *reader, int64_t n, int64_t text_bytes, int64_t binary_bytes,
                     const char *what) {
    return io_check_count(reader->model, reader->cursor, n,
                          reader->model->is_binary ? binary_bytes : text_bytes, what,
                          reader->error);
}

/* ---- nodes -------------------------------------------------------------------------------- */

typedef struct node_block {
    const gmsh_reader *reader;
    int64_t first; /* index of the block's first node */
    int extra;     /* parametric coordinates of a node */
    int is_apart;  /* the numbers of all nodes stand before the coordinates: MSH 4.1 */
    int bytes;     /* of a number; 0: text */
} node_block;

static int read_numbers(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                        planish_error *error) {
    const node_block *block = context;
    const io_model *model = block->reader->model;
    for (int64_t node = block->first + begin; node < block->first + end; node++)
        if (io_number(cursor, block->bytes, block->reader->swapped, &model->node_number[node]))
            return io_fail_at(model, cursor->at, error,
                              "number of node %lld of %lld expected (the file may be cut short)",
                              (long long)node + 1, (long long)model->n_nodes);
    return PLANISH_OK;
}

static int read_points(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                       planish_error *error) {
    const node_block *block = context;
    io_model *model = block->reader->model;
    double ignored;
    for (int64_t i = begin; i < end; i++) {
        const int64_t node = block->first + i;
        int status = block->is_apart ? PLANISH_OK : read_numbers(context, cursor, i, i + 1, error);
        if (!status)
            status = model->is_binary
                         ? io_load_node(model, cursor->at, 8, block->reader->swapped, node, error)
                         : io_read_node(model, cursor, node, error);
        if (status)
            return status;
        if (model->is_binary)
            cursor->at += 8 * (3 + block->extra);
        for (int k = 0; !model->is_binary && k < block->extra; k++)
            if (io_real(cursor, &ignored))
                return io_fail_at(model, cursor->at, error,
                                  "parametric coordinate expected (the file may be cut short)");
    }
    return PLANISH_OK;
}

int gmsh_make_nodes(gmsh_reader *reader, int64_t n) {
    enum { TEXT_SIZE = 7 }; /* the shortest node: a number and three coordinates */
    io_model *model = reader->model;
    if (model->xyz)
        return io_fail_at(model, reader->cursor.at, reader->error, "there is a second $Nodes");
    int status =
        gmsh_check_count(reader, n, TEXT_SIZE, (reader->version == 41 ? 8 : 4) + 3 * 8, "nodes");
    if (!status)
        status = model->is_binary ? io_model_alloc_nodes(model, n, 0, reader->error)
                                  : io_model_make_nodes(model, n, 8, 0, 0, NULL, reader->error);
    if (status)
        return status;
    model->node_number = pl_alloc(n, sizeof *model->node_number);
    return model->node_number ? PLANISH_OK : pl_fail_memory(reader->error, "the nodes' numbers");
}

int gmsh_read_nodes(gmsh_reader *reader, int64_t first, int64_t n, int extra) {
    io_model *model = reader->model;
    const int is_apart = reader->version == 41, number_bytes = is_apart ? 8 : 4;
    const int64_t stride = (is_apart ? 0 : number_bytes) + 8 * (3 + extra);
    node_block block = {reader, first, extra, is_apart, model->is_binary ? number_bytes : 0};
    if (n == 0)
        return PLANISH_OK;
    int status = PLANISH_OK;
    if (model->is_binary)
        status = io_check_room(model, reader->cursor, n, number_bytes + 8 * (3 + extra), "nodes",
                               reader->error);
    if (!status && is_apart)
        status = io_records(&reader->text, &reader->cursor, n, 1, number_bytes, read_numbers,
                            &block, reader->error);
    if (!status && model->is_binary) {
        const io_span span = {.first_node = first,
                              .n_nodes = n,
                              .encoding = IO_FLOAT64,
                              .swapped = reader->swapped,
                              .offset = reader->cursor.at - model->input.data +
                                        (is_apart ? 0 : number_bytes),
                              .stride = stride};
        status = io_model_span(model, span, reader->error);
    }
    return status ? status
                  : io_records(&reader->text, &reader->cursor, n, !is_apart + 3 + extra, stride,
                               read_points, &block, reader->error);
}

int gmsh_end_nodes(gmsh_reader *reader) {
    reader->have_nodes = 1;
    return io_reduce_node_numbers(reader->model, reader->error);
}

/* ---- elements and pairs ------------------------------------------------------------------- */

/** Return whether elements of a block may be points in groups. */
static int may_have_groups(const io_model *model, const gmsh_block *block) {
    return block->type->shape == IO_POINT &&
           (block->entity < 0 || model->entity[block->entity].n_physical > 0);
}

int gmsh_begin_block(gmsh_reader *reader, gmsh_block *block, int64_t n) {
    io_model *model = reader->model;
    const int dim = io_element_dim(block->type);
    const io_others *others = io_model_others(model, dim);
    int status = PLANISH_OK;
    block->cells = io_element_cells(model, block->type);
    block->mids = io_element_mids(block->type);
    block->other = io_element_other(block->type);
    block->reason = io_element_reason(block->type);
    block->first = block->cells ? block->cells->n : block->other ? others->n : 0;
    block->first_node = others->n_nodes;
    if (!block->cells)
        io_element_count(model, block->type, n);
    block->point = NULL;
    if (may_have_groups(model, block) && !(block->point = gmsh_add_points(reader, n)))
        return pl_fail_memory(reader->error, "points");
    if (block->cells)
        status = io_cells_reserve(model, dim, n, 1, 1, reader->error);
    else if (block->other)
        status = io_others_reserve(model, dim, n, n * io_cell_type_nodes(block->other), 1,
                                   reader->error);
    return !status && block->mids > 0 ? io_cells_reserve_mids(model, dim, reader->error) : status;
}

void gmsh_end_block(gmsh_reader *reader, const gmsh_block *block, int64_t n) {
    io_others *others = io_model_others(reader->model, io_element_dim(block->type));
    if (block->cells)
        block->cells->n += n;
    if (block->other) {
        others->n += n;
        others->n_nodes += n * io_cell_type_nodes(block->other);
    }
}

int gmsh_read_element(const gmsh_block *block, io_cursor *cursor, const char *at, int64_t number,
                      int64_t index, planish_error *error) {
    const gmsh_reader *reader = block->reader;
    const int n = block->type->nodes;
    io_cells *cells = block->cells;
    int32_t all[IO_CELL_NODES];
    int32_t *to = cells && block->mids == 0     ? cells->nodes + index * n
                  : block->mids || block->other ? all
                                                : NULL;
    int64_t node_number;
    for (int i = 0; i < n; i++) {
        if (io_number(cursor, block->bytes, reader->swapped, &node_number))
            return io_fail_at(reader->model, at, error,
                              "element %lld: node expected (the file may be cut short, or the "
                              "number of elements is wrong)",
                              (long long)number);
        const int64_t node = io_node_index(reader->model, node_number);
        if (node < 0)
            return io_fail_no_node(reader->model, at, "element", number, node_number, error);
        if (to)
            to[i] = (int32_t)node;
        if (!cells && !block->other && block->reason != 0)
            io_hold_node(reader->model, node, block->reason);
        if (block->point)
            block->point[index - block->first] = (gmsh_point){(int32_t)node, block->entity};
    }
    if (cells) {
        cells->number[index] = number;
        cells->entity[index] = block->entity;
    }
    if (block->mids > 0) {
        const int corners = n - block->mids;
        memcpy(cells->nodes + index * corners, all, (size_t)corners * sizeof *all);
        io_cells_set_mids(reader->model, corners - 1, index, all);
    }
    if (block->other) {
        io_others_set(reader->model, index, block->first_node + (index - block->first) * n,
                      block->other, all, number);
        io_model_others(reader->model, io_element_dim(block->type))->entity[index] = block->entity;
    }
    return PLANISH_OK;
}

/* ---- points ------------------------------------------------------------------------------- */

gmsh_point *gmsh_add_points(gmsh_reader *reader, int64_t n) {
    gmsh_point *point = pl_grow(reader->point, reader->n_points, reader->n_points + n,
                                &reader->point_capacity, sizeof *point);
    if (!point)
        return NULL;
    reader->point = point;
    point += reader->n_points;
    reader->n_points += n;
    return point;
}

static int compare_points(const void *left, const void *right) {
    const gmsh_point *a = left, *b = right;
    if (a->node != b->node)
        return a->node < b->node ? -1 : 1;
    return (a->entity > b->entity) - (a->entity < b->entity);
}

static int compare_groups(const void *left, const void *right) {
    const int32_t a = *(const int32_t *)left, b = *(const int32_t *)right;
    return (a > b) - (a < b);
}

/** Find the entity of a node with n points, one or more: in all groups that these are in. */
static int32_t join_points(io_model *model, const gmsh_point *point, int64_t n,
                           planish_error *error) {
    const int32_t first = point[0].entity;
    int64_t n_all = 0, n_kept = 0;
    if (first == point[n - 1].entity)
        return first;
    for (int64_t i = 0; i < n; i++)
        n_all += model->entity[point[i].entity].n_physical;
    int32_t *group = n_all <= INT32_MAX ? pl_alloc(n_all, sizeof *group) : NULL;
    if (!group)
        return pl_fail_memory(error, "groups of points");
    for (int64_t i = 0, at = 0; i < n; i++) {
        const io_entity *e = &model->entity[point[i].entity];
        memcpy(group + at, e->physical, (size_t)e->n_physical * sizeof *group);
        at += e->n_physical;
    }
    qsort(group, (size_t)n_all, sizeof *group, compare_groups);
    for (int64_t i = 0; i < n_all; i++)
        if (i == 0 || group[i] != group[n_kept - 1])
            group[n_kept++] = group[i];
    const int32_t entity =
        io_model_entity(model, 0, model->entity[first].tag, (int)n_kept, group, error);
    pl_free(group);
    return entity;
}

/** Leave out points that are in no group. */
static void keep_grouped(gmsh_reader *reader) {
    int64_t n = 0;
    for (int64_t i = 0; i < reader->n_points; i++)
        if (reader->model->entity[reader->point[i].entity].n_physical > 0)
            reader->point[n++] = reader->point[i];
    reader->n_points = n;
}

int gmsh_take_points(gmsh_reader *reader) {
    io_model *model = reader->model;
    keep_grouped(reader);
    const gmsh_point *point = reader->point;
    const int64_t n = reader->n_points;
    if (n == 0)
        return PLANISH_OK;
    model->node_entity = pl_alloc(model->n_nodes, sizeof *model->node_entity);
    if (!model->node_entity)
        return pl_fail_memory(reader->error, "groups of points");
    for (int64_t i = 0; i < model->n_nodes; i++)
        model->node_entity[i] = -1;
    qsort(reader->point, (size_t)n, sizeof *point, compare_points);
    for (int64_t begin = 0, end; begin < n; begin = end) {
        for (end = begin + 1; end < n && point[end].node == point[begin].node;)
            end++;
        const int32_t entity = join_points(model, point + begin, end - begin, reader->error);
        if (entity < 0)
            return entity;
        model->node_entity[point[begin].node] = entity;
    }
    return PLANISH_OK;
}

/* ---- periodic pairs ----------------------------------------------------------------------- */

/** Hold both nodes of n pairs, numbers of so many bytes. */
static int hold_pairs(gmsh_reader *reader, int64_t n, int bytes) {
    for (int64_t i = 0; i < n; i++) {
        int32_t pair[2];
        int status = PLANISH_OK;
        for (int j = 0; j < 2; j++) {
            int64_t number;
            status = gmsh_take(reader, bytes, &number, "node of a periodic pair");
            if (status)
                return status;
            pair[j] = (int32_t)io_node_index(reader->model, number);
        }
        /* Gmsh lists pairs of the whole geometry, also where only some groups were saved: a node
         * whose partner is not there stays. */
        const int is_whole = pair[0] >= 0 && pair[1] >= 0;
        for (int j = 0; j < 2; j++)
            if (pair[j] >= 0)
                io_hold_node(reader->model, pair[j],
                             is_whole ? IO_HELD_PERIODIC : IO_HELD_REQUIRED);
        if (is_whole)
            status = io_model_pair(reader->model, pair, reader->error);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

int gmsh_periodic(gmsh_reader *reader) {
    enum { TRANSFORM_40 = 16 };
    const int is_old = reader->version < 40, is_40 = reader->version == 40;
    const int is_binary = reader->model->is_binary && !is_old;
    const int tag = is_old ? 0 : 4, count = is_old ? 0 : 8, bytes = is_40 ? tag : count;
    int64_t links = 0, n = 0, size = TRANSFORM_40;
    int status = is_binary ? gmsh_end_line(reader) : PLANISH_OK;
    if (!status)
        status = gmsh_take(reader, bytes, &links, "number of periodic entities");
    for (int64_t i = 0; i < links && !status; i++) {
        status = gmsh_skip_integers(reader, tag, 3, "dimension and tags of a periodic entity");
        /* The transform. MSH 4.1: its size and that many numbers; before: in text a line that
         * begins with a word, in binary a count below 0 and 16 numbers; or none. */
        io_cursor line = reader->cursor;
        const int is_41 = !is_old && !is_40;
        if (!is_41 && io_slice_is(io_next_word(&line), "Affine", 0)) {
            io_skip_line(&line);
            reader->cursor = line;
        }
        if (!status && is_41)
            status = gmsh_take(reader, 8, &size, "size of a periodic transform");
        if (!status && is_41)
            status = gmsh_skip_reals(reader, size, "periodic transform");
        if (!status)
            status = gmsh_take(reader, count, &n, "number of periodic nodes");
        if (!status && is_40 && is_binary && n < 0) {
            status = gmsh_skip_reals(reader, size, "periodic transform");
            if (!status)
                status = gmsh_take(reader, count, &n, "number of periodic nodes");
        }
        if (!status)
            status = gmsh_check_count(reader, n, 4, is_old ? 4 : 2 * bytes, "periodic nodes");
        if (!status)
            status = hold_pairs(reader, n, is_binary ? bytes : 0);
    }
    return status;
}
