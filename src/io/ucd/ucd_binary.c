/* ucd_binary: binary files of AVS UCD.
 *
 * A byte 7, six counts (nodes, cells, data of nodes, cells and the model, nodes of all cells), for
 * each cell its number, material, number of nodes and type, then the nodes of all cells, counted from
 * 1. All are whole numbers of 32 bits. The x of all nodes follow, then y and z, as floats. Behind
 * are data, which nobody looks at here. Numbers are in either byte order: that in which the counts
 * fit the file.
 */
#include "io/ucd/ucd.h"

#include "io/core/binary.h"
#include "io/core/format.h"
#include "io/core/records.h"
#include "io/core/runs.h"

#include "base/status.h"

enum { MAGIC = 7, WORD = 4, N_COUNTS = 6, HEAD = 1 + N_COUNTS * WORD, CELL = 4 * WORD };

typedef struct binary_head {
    int swapped;
    int64_t n_nodes, n_cells, n_list;
    int64_t size; /* bytes before the data */
} binary_head;

/** Read the counts in a byte order; return whether they can be those of size bytes. */
static int read_head(const char *data, int64_t size, int swapped, binary_head *head) {
    int64_t count[N_COUNTS];
    if (size < HEAD || data[0] != MAGIC)
        return 0;
    for (int i = 0; i < N_COUNTS; i++) {
        count[i] = io_load_i32(data + 1 + i * WORD, swapped);
        if (count[i] < 0)
            return 0;
    }
    *head = (binary_head){swapped, count[0], count[1], count[N_COUNTS - 1],
                          HEAD + CELL * count[1] + WORD * (count[N_COUNTS - 1] + 3 * count[0])};
    return count[0] > 0 && count[1] > 0 && head->n_list >= count[1];
}

/** Find the byte order in which the counts are smaller, as they begin with zeros. Return whether
 *  either can be. */
static int find_head(const char *data, int64_t size, binary_head *head) {
    binary_head little, big;
    const int is_little = io_machine_is_little();
    const int has_little = read_head(data, size, !is_little, &little);
    const int has_big = read_head(data, size, is_little, &big);
    *head = has_little && (!has_big || little.size <= big.size) ? little : big;
    return has_little || has_big;
}

int ucd_binary_recognise(const char *data, int64_t size) {
    binary_head head;
    if (size < HEAD + CELL || !find_head(data, size, &head))
        return 0;
    const int32_t n = io_load_i32(data + HEAD + 2 * WORD, head.swapped);
    const int32_t type = io_load_i32(data + HEAD + 3 * WORD, head.swapped);
    return type >= 0 && type < UCD_N_BINARY_TYPES && n >= ucd_types[type].nodes &&
           n <= UCD_MOST_NODES;
}

/* ---- nodes --------------------------------------------------------------------------------- */

/** Read nodes from the planes of x, y and z. */
static int read_nodes(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                      planish_error *error) {
    io_model *model = context;
    for (int64_t i = begin; i < end; i++, cursor->at += WORD)
        for (int d = 0; d < 3; d++) {
            const io_span *span = &model->span[d];
            const char *at = model->input.data + span->offset + i * WORD;
            double *x = &model->xyz[3 * i + d];
            *x = io_load_f32(at, span->swapped);
            const int status = io_check_finite(model, *x, i, at, error);
            if (status)
                return status;
        }
    return PLANISH_OK;
}

static int read_all_nodes(io_model *model, const binary_head *head, planish_error *error) {
    const int64_t n = head->n_nodes;
    int64_t offset = head->size - 3 * WORD * n;
    int status = io_model_alloc_nodes(model, n, 0, error);
    model->precision = PLANISH_PRECISION_FLOAT;
    model->first_number = 1;
    for (int d = 0; d < 3 && !status; d++, offset += WORD * n)
        status = io_model_span(model,
                               (io_span){.n_nodes = n,
                                         .encoding = IO_FLOAT32,
                                         .swapped = head->swapped,
                                         .offset = offset,
                                         .stride = WORD,
                                         .component = d,
                                         .n_components = 1},
                               error);
    io_cursor cursor = {model->input.data + head->size - 3 * WORD * n, io_input_end(model)};
    return status ? status
                  : io_binary_records(model->threads, &cursor, n, WORD, read_nodes, model, error);
}

/* ---- cells --------------------------------------------------------------------------------- */

/** A cell: its record, and where its nodes are. */
typedef struct binary_cell {
    int64_t number, material, n, type;
    const char *nodes;
} binary_cell;

/** Hold the nodes of a cell whose mids are in no known order, or which is a point. */
static int hold_cell(io_model *model, const binary_cell *c, const int32_t *nodes) {
    static const io_element_type other = {NULL, IO_ANY_SHAPE, 2, 0};
    const int is_plain = c->n == ucd_types[c->type].nodes;
    const io_element_type *row = is_plain ? &ucd_types[c->type] : &other;
    for (int64_t k = 0; k < c->n; k++)
        io_hold_node(model, nodes[k], io_element_reason(row));
    io_element_count(model, row, 1);
    return PLANISH_OK;
}

static int add_cell(io_model *model, const binary_cell *c, int swapped, planish_error *error) {
    int32_t nodes[UCD_MOST_NODES];
    const io_element_type *row = &ucd_types[c->type];
    for (int64_t k = 0; k < c->n; k++) {
        const char *at = c->nodes + k * WORD;
        const int64_t node = io_load_i32(at, swapped);
        if (node < 1 || node > model->n_nodes)
            return io_fail_no_node(model, at, "cell", c->number, node, error);
        nodes[k] = (int32_t)node - 1;
    }
    if (c->n != row->nodes || row->shape == IO_POINT)
        return hold_cell(model, c, nodes);
    const int type = io_element_other(row);
    if (!type)
        return io_model_add_simplex(model, io_simplex_type(io_element_dim(row), 0), nodes,
                                    (int32_t)c->material, c->number, error);
    io_element_count(model, row, 1);
    return io_model_add_other(model, type, nodes, (int32_t)c->material, c->number, error);
}

static int read_all_cells(io_model *model, const binary_head *head, planish_error *error) {
    const char *cell = model->input.data + HEAD, *list = cell + CELL * head->n_cells;
    const char *end = list + WORD * head->n_list;
    int status = PLANISH_OK;
    for (int64_t i = 0; i < head->n_cells && !status; i++, cell += CELL) {
        const binary_cell c = {.number = io_load_i32(cell, head->swapped),
                               .material = io_load_i32(cell + WORD, head->swapped),
                               .n = io_load_i32(cell + 2 * WORD, head->swapped),
                               .type = io_load_i32(cell + 3 * WORD, head->swapped),
                               .nodes = list};
        if (c.type < 0 || c.type >= UCD_N_BINARY_TYPES)
            return io_fail_at(model, cell + 3 * WORD, error, "cell %lld: type %lld is unknown",
                              (long long)c.number, (long long)c.type);
        if (c.n < ucd_types[c.type].nodes || c.n > UCD_MOST_NODES || c.n > (end - list) / WORD)
            return io_fail_at(model, cell + 2 * WORD, error,
                              "cell %lld: a %s of %lld nodes, or more than the list has",
                              (long long)c.number, ucd_types[c.type].name, (long long)c.n);
        status = add_cell(model, &c, head->swapped, error);
        list += WORD * c.n;
    }
    if (!status && list != end)
        return io_fail_at(model, list, error, "the list has more nodes than the cells");
    return status;
}

int ucd_binary_read(io_model *model, planish_error *error) {
    binary_head head;
    const io_bytes *input = &model->input;
    model->is_binary = 1;
    if (!find_head(input->data, input->size, &head))
        return io_fail_at(model, input->data, error,
                          "six counts expected behind the first byte (the file is damaged)");
    if (head.size > input->size)
        return io_fail_at(model, input->data + 1, error,
                          "%lld nodes and %lld cells cannot be in %lld bytes; a count is wrong or "
                          "the file is cut short",
                          (long long)head.n_nodes, (long long)head.n_cells, (long long)input->size);
    int status = read_all_nodes(model, &head, error);
    if (!status)
        status = read_all_cells(model, &head, error);
    return status ? status : io_runs_index_tags(model, error);
}
