/* runs: elements of one type that stand together in a file, set by several threads. */
#include "io/core/runs.h"

#include <string.h>

int io_run_begin(io_model *model, const io_element_type *row, int64_t n, io_run *run,
                 planish_error *error) {
    *run = (io_run){.model = model, .row = row, .type = io_element_other(row)};
    if (io_element_use(row) == IO_KEEP) {
        run->dim = io_element_dim(row);
        run->first = io_model_cells(model, run->dim)->n;
        const int status = io_cells_reserve(model, run->dim, n, 1, 1, error);
        return status || row->order < 2 ? status : io_cells_reserve_mids(model, run->dim, error);
    }
    if (!run->type)
        return PLANISH_OK;
    const io_others *others = io_model_others(model, io_element_dim(row));
    run->first = others->n;
    run->first_node = others->n_nodes;
    return io_others_reserve(model, io_element_dim(row), n, n * row->nodes, 1, error);
}

void io_run_set(const io_run *run, int64_t i, const int32_t *nodes, int32_t tag, int64_t number) {
    const int64_t at = run->first + i;
    if (run->dim) {
        io_cells *cells = io_model_cells(run->model, run->dim);
        const int corners = run->dim + 1;
        memcpy(cells->nodes + at * corners, nodes, (size_t)corners * sizeof *nodes);
        if (run->row->order == 2)
            io_cells_set_mids(run->model, run->dim, at, nodes);
        cells->entity[at] = tag;
        cells->number[at] = number;
    } else if (run->type) {
        io_others_set(run->model, at, run->first_node + i * run->row->nodes, run->type, nodes,
                      number);
        io_model_others(run->model, io_element_dim(run->row))->entity[at] = tag;
    } else {
        for (int k = 0; k < run->row->nodes; k++)
            io_hold_node(run->model, nodes[k], io_element_reason(run->row));
    }
}

void io_run_end(const io_run *run, int64_t n) {
    if (run->dim) {
        io_model_cells(run->model, run->dim)->n += n;
        return;
    }
    io_element_count(run->model, run->row, n);
    if (!run->type)
        return;
    io_others *others = io_model_others(run->model, io_element_dim(run->row));
    others->n += n;
    others->n_nodes += n * run->row->nodes;
}

int io_run_read(io_model *model, io_text *text, const io_section *noted, const io_element_type *row,
                io_records_fn *read, void *context, io_run *run, planish_error *error) {
    io_cursor cursor = {noted->data, io_input_end(model)};
    int status = io_run_begin(model, row, noted->count, run, error);
    if (!status)
        status = io_text_records(text, &cursor, noted->count, noted->tokens, read, context, error);
    if (!status)
        io_run_end(run, noted->count);
    return status;
}

int io_runs_add(io_sections *runs, int row, int64_t tokens, const char *at, const char *end,
                planish_error *error) {
    io_section *last = runs->n > 0 ? &runs->section[runs->n - 1] : NULL;
    if (last && last->keyword == row && last->tokens == tokens) {
        last->count++;
        last->end = end;
        return PLANISH_OK;
    }
    return io_sections_add(
        runs, (io_section){.keyword = row, .count = 1, .data = at, .end = end, .tokens = tokens},
        error);
}

int io_runs_index_tags(io_model *model, planish_error *error) {
    int status = PLANISH_OK;
    for (int k = IO_FIRST_LIST; k < IO_N_LISTS && !status; k++) {
        const io_list list = io_model_list(model, k);
        if (list.entity)
            status = io_model_index_tags(model, list.dim, list.entity, list.n, error);
        if (k < IO_FLAT_LIST)
            io_reduce_cell_numbers(io_model_cells(model, k));
    }
    return status;
}
