/* medit_mesh: the sections of Medit's meshes: vertices, elements, and what holds nodes. */
#include "io/medit/medit.h"

#include "base/memory.h"
#include "base/round.h"
#include "base/status.h"

/* ---- records ------------------------------------------------------------------------------ */

static inline int take_real(const medit_reader *r, io_cursor *cursor, double *value) {
    if (r->model->is_binary) {
        *value = r->real_size == 4 ? (double)io_load_f32(cursor->at, r->swapped)
                                   : io_load_f64(cursor->at, r->swapped);
        cursor->at += r->real_size;
        return 0;
    }
    io_skip_space_comments(cursor, '#');
    return io_real(cursor, value);
}

static int read_vertices(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                         planish_error *error) {
    const medit_reader *r = context;
    io_model *model = r->model;
    for (int64_t i = begin; i < end; i++) {
        double *xyz = model->xyz + 3 * i;
        int64_t reference;
        int status = PLANISH_OK;
        if (!model->is_binary) {
            io_skip_space_comments(cursor, '#');
            model->text_offset[i] = cursor->at - model->input.data;
        }
        xyz[2] = 0;
        for (int d = 0; d < r->dim && !status; d++) {
            const char *at = cursor->at;
            double value;
            if (take_real(r, cursor, &value))
                return io_fail_at(model, cursor->at, error,
                                  "vertex %lld: a coordinate expected (the file may be cut short)",
                                  (long long)i + 1);
            xyz[d] = model->precision == PLANISH_PRECISION_FLOAT ? pl_round_to_float(value) : value;
            status = io_check_finite(model, xyz[d], i, model->is_binary ? at : cursor->at, error);
        }
        if (!status)
            status =
                io_take_whole(&r->kind, cursor, i + 1, INT32_MIN, INT32_MAX, &reference, error);
        if (status)
            return status;
        model->node_entity[i] = (int32_t)reference;
    }
    return PLANISH_OK;
}

/** Store elements, or hold their nodes. */
static int read_elements(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                         planish_error *error) {
    const medit_reader *r = context;
    const io_element_type *type = &r->current->type;
    io_cells *cells = r->cells;
    for (int64_t i = begin; i < end; i++) {
        const int64_t cell = r->first_cell + i;
        int64_t node, reference;
        for (int j = 0; j < type->nodes; j++) {
            const int status =
                io_take_whole(&r->kind, cursor, i + 1, 1, r->model->n_nodes, &node, error);
            if (status)
                return status;
            if (cells)
                cells->nodes[cell * type->nodes + j] = (int32_t)(node - 1);
            else
                io_hold_node(r->model, node - 1, io_element_reason(type));
        }
        const int status =
            io_take_whole(&r->kind, cursor, i + 1, INT32_MIN, INT32_MAX, &reference, error);
        if (status)
            return status;
        if (cells)
            cells->entity[cell] = (int32_t)reference;
    }
    return PLANISH_OK;
}

static int read_marked(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                       planish_error *error) {
    const medit_reader *r = context;
    const int dim = io_element_dim(&r->current->type);
    const io_cells *cells = dim ? io_model_cells(r->model, dim) : NULL;
    const int64_t n = cells ? cells->n : r->model->n_nodes;
    for (int64_t i = begin; i < end; i++) {
        int64_t number;
        const int status = io_take_whole(&r->kind, cursor, i + 1, 1, n, &number, error);
        if (status)
            return status;
        for (int j = 0; j <= dim; j++)
            io_hold_node(r->model, cells ? cells->nodes[(number - 1) * (dim + 1) + j] : number - 1,
                         IO_HELD_REQUIRED);
    }
    return PLANISH_OK;
}

static int read_pairs(const medit_reader *r, const io_section *s) {
    io_cursor cursor = {s->data, io_input_end(r->model)};
    for (int64_t i = 0; i < s->count; i++) {
        int32_t pair[2];
        int status = PLANISH_OK;
        for (int j = 0; j < 2; j++) {
            int64_t node;
            status = io_take_whole(&r->kind, &cursor, i + 1, 1, r->model->n_nodes, &node, r->error);
            if (status)
                return status;
            pair[j] = (int32_t)(node - 1);
            io_hold_node(r->model, pair[j], IO_HELD_PERIODIC);
        }
        if (pair[0] != pair[1])
            status = io_model_pair(r->model, pair, r->error);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

/* ---- sections ----------------------------------------------------------------------------- */

static int read_records(medit_reader *r, const io_section *s, io_records_fn *read) {
    const medit_keyword *k = r->current;
    return io_section_records(&r->text, s, k->type.name, medit_reals(r, k) + medit_integers(k),
                              medit_record_size(r, k), read, r, r->error);
}

static int read_vertex_section(medit_reader *r, const io_section *s) {
    io_model *model = r->model;
    if (model->xyz)
        return io_fail_at(model, s->data, r->error, "Vertices for the second time");
    int status =
        io_model_make_nodes(model, s->count, r->version == 1 ? 4 : 8,
                            medit_record_size(r, r->current), r->swapped, s->data, r->error);
    if (status)
        return status;
    model->first_number = 1;
    model->columns = r->dim;
    model->node_entity = pl_alloc(s->count, sizeof *model->node_entity);
    if (!model->node_entity)
        return pl_fail_memory(r->error, "the vertices of the file");
    status = read_records(r, s, read_vertices);
    return status ? status : io_model_index_tags(model, 0, model->node_entity, s->count, r->error);
}

static int read_element_section(medit_reader *r, const io_section *s) {
    const io_element_type *type = &r->current->type;
    const int dim = io_element_dim(type);
    io_cells *cells = r->cells = io_element_cells(r->model, type);
    if (!cells) {
        io_element_count(r->model, type, s->count);
        return read_records(r, s, read_elements);
    }
    cells->first_number = 1;
    r->first_cell = cells->n;
    int status = io_cells_reserve(r->model, dim, s->count, 1, 0, r->error);
    if (!status)
        status = read_records(r, s, read_elements);
    if (!status)
        status = io_model_index_tags(r->model, dim, cells->entity + cells->n, s->count, r->error);
    if (!status)
        cells->n += s->count;
    return status;
}

int medit_read_section(medit_reader *r, const io_section *s) {
    r->current = &medit_keywords[s->keyword];
    r->kind = (io_record_kind){r->model, r->current->type.name,
                               r->model->is_binary ? r->integer_size : 0, r->swapped};
    switch (r->current->kind) {
    case MEDIT_VERTICES:
        return read_vertex_section(r, s);
    case MEDIT_ELEMENTS:
        return read_element_section(r, s);
    case MEDIT_MARKED:
        return read_records(r, s, read_marked);
    default:
        return read_pairs(r, s);
    }
}
