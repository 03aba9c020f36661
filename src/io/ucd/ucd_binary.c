/* ucd_binary: binary files of AVS UCD.
 *
 * A byte 7, six counts (nodes, cells, data of nodes, cells and the model, nodes of all cells), for
 * each cell its number, material, number of nodes and type, then the nodes of all cells, counted from
 * 1. All are whole numbers of 32 bits. The x of all nodes follow, then y and z, as floats. Behind
 * are data, which nobody looks at here. Numbers are in either byte order: that in which the counts
 * fit the file.
 */
#include "io/ucd/ucd_reader.h"

#include "io/core/binary.h"
#include "io/core/bytes.h"
#include "io/core/format.h"
#include "io/core/records.h"
#include "io/core/runs.h"

#include "base/status.h"

#include <string.h>

enum { MAGIC = 7, WORD = 4, N_COUNTS = 6, HEAD = 1 + N_COUNTS * WORD, CELL = 4 * WORD };

typedef struct binary_head {
    int swapped;
    int64_t n_nodes, n_cells, n_list;
    int64_t size; /* bytes before the data */
    int64_t count[N_COUNTS];
} binary_head;

/** Read the counts in a byte order; return whether they can be those of size bytes. */
static int read_head(const char *data, int64_t size, int swapped, binary_head *head) {
    int64_t *count = head->count;
    if (size < HEAD || data[0] != MAGIC)
        return 0;
    for (int i = 0; i < N_COUNTS; i++) {
        count[i] = io_load_i32(data + 1 + i * WORD, swapped);
        if (count[i] < 0)
            return 0;
    }
    head->swapped = swapped;
    head->n_nodes = count[0];
    head->n_cells = count[1];
    head->n_list = count[N_COUNTS - 1];
    head->size = HEAD + CELL * count[1] + WORD * (count[N_COUNTS - 1] + 3 * count[0]);
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
                  : io_binary_records(io_model_threads(model), &cursor, n, WORD, read_nodes, model,
                                      error);
}

/* ---- cells --------------------------------------------------------------------------------- */

/** Cells of one type and number of nodes that stand together, read by threads. */
typedef struct binary_run {
    io_run run;
    const char *cell, *list; /* of the first */
    int swapped, n;          /* nodes of each */
} binary_run;

static int read_run(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                    planish_error *error) {
    const binary_run *r = context;
    const io_model *model = r->run.model;
    for (int64_t i = begin; i < end; i++, cursor->at += CELL) {
        int32_t nodes[UCD_MOST_NODES];
        const char *cell = r->cell + i * CELL, *list = r->list + i * r->n * WORD;
        const int32_t number = io_load_i32(cell, r->swapped);
        for (int k = 0; k < r->n; k++) {
            const int32_t node = io_load_i32(list + k * WORD, r->swapped);
            if (node < 1 || node > model->n_nodes)
                return io_fail_no_node(model, list + k * WORD, "cell", number, node, error);
            nodes[k] = node - 1;
        }
        io_run_set(&r->run, i, nodes, io_load_i32(cell + WORD, r->swapped), number);
    }
    return PLANISH_OK;
}

/** Read n cells of one type and number of nodes. Mids are in no known order. */
static int read_cells(binary_run *r, io_model *model, int type, int64_t n, planish_error *error) {
    const io_element_type other = {NULL, IO_ANY_SHAPE, 2, (uint16_t)r->n};
    const int is_plain = r->n == ucd_types[type].nodes;
    io_cursor cursor = {r->cell, io_input_end(model)};
    int status = io_run_begin(model, is_plain ? &ucd_types[type] : &other, n, &r->run, error);
    if (!status)
        status = io_binary_records(io_model_threads(model), &cursor, n, CELL, read_run, r, error);
    if (!status)
        io_run_end(&r->run, n);
    return status;
}

static int read_all_cells(io_model *model, const binary_head *head, planish_error *error) {
    binary_run r = {.cell = model->input.data + HEAD, .swapped = head->swapped};
    const char *const last = r.cell + CELL * head->n_cells, *const end = last + WORD * head->n_list;
    int status = PLANISH_OK;
    r.list = last;
    while (r.cell < last && !status) {
        const int64_t n = io_load_i32(r.cell + 2 * WORD, r.swapped);
        const int32_t type = io_load_i32(r.cell + 3 * WORD, r.swapped);
        if (type < 0 || type >= UCD_N_BINARY_TYPES)
            return io_fail_at(model, r.cell + 3 * WORD, error,
                              "a cell of type %d, which is unknown", (int)type);
        if (n < ucd_types[type].nodes || n > UCD_MOST_NODES)
            return io_fail_at(model, r.cell + 2 * WORD, error, "a %s cannot have %lld nodes",
                              ucd_types[type].name, (long long)n);
        int64_t count = 0;
        while (r.cell + count * CELL < last &&
               io_load_i32(r.cell + count * CELL + 2 * WORD, r.swapped) == n &&
               io_load_i32(r.cell + count * CELL + 3 * WORD, r.swapped) == type)
            count++;
        if (count == 0) /* another program writes to the file */
            return io_bytes_fail_changed(&model->input, error);
        if (count > (end - r.list) / (WORD * n))
            return io_fail_at(model, r.cell, error,
                              "the cells have more nodes than the %lld of the list",
                              (long long)head->n_list);
        r.n = (int)n;
        status = read_cells(&r, model, type, count, error);
        r.cell += count * CELL;
        r.list += count * n * WORD;
    }
    if (!status && r.list != end)
        return io_fail_at(model, r.list, error, "the list has more nodes than the cells");
    return status;
}

int ucd_binary_read(io_model *model, int64_t count[UCD_N_COUNTS], planish_error *error) {
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
    memcpy(count, head.count, UCD_N_COUNTS * sizeof *count);
    return status ? status : io_runs_index_tags(model, error);
}
