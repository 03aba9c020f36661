/* medit_mesh: the sections of Medit's meshes: vertices, elements, and what holds nodes. */
#include "io/medit/medit_reader.h"

#include "base/memory.h"
#include "base/round.h"
#include "base/status.h"

#include <string.h>

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

/** Store elements of first order. */
static int read_elements(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                         planish_error *error) {
    const medit_reader *r = context;
    const int n_nodes = r->current->type.nodes;
    for (int64_t i = begin; i < end; i++) {
        const int64_t cell = r->first_cell + i;
        int64_t node, reference;
        for (int j = 0; j < n_nodes; j++) {
            const int status =
                io_take_whole(&r->kind, cursor, i + 1, 1, r->model->n_nodes, &node, error);
            if (status)
                return status;
            r->cells->nodes[cell * n_nodes + j] = (int32_t)(node - 1);
        }
        const int status =
            io_take_whole(&r->kind, cursor, i + 1, INT32_MIN, INT32_MAX, &reference, error);
        if (status)
            return status;
        r->cells->entity[cell] = (int32_t)reference;
    }
    return PLANISH_OK;
}

/** Store elements of second order. */
static int read_curved(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                       planish_error *error) {
    const medit_reader *r = context;
    const int n_nodes = r->current->type.nodes, corners = io_element_dim(&r->current->type) + 1;
    for (int64_t i = begin; i < end; i++) {
        const int64_t cell = r->first_cell + i;
        int32_t nodes[IO_CELL_NODES];
        int64_t node, reference;
        for (int j = 0; j < n_nodes; j++) {
            const int status =
                io_take_whole(&r->kind, cursor, i + 1, 1, r->model->n_nodes, &node, error);
            if (status)
                return status;
            nodes[j] = (int32_t)(node - 1);
        }
        const int status =
            io_take_whole(&r->kind, cursor, i + 1, INT32_MIN, INT32_MAX, &reference, error);
        if (status)
            return status;
        memcpy(r->cells->nodes + cell * corners, nodes, (size_t)corners * sizeof *nodes);
        io_cells_set_mids(r->model, corners - 1, cell, nodes);
        r->cells->entity[cell] = (int32_t)reference;
    }
    return PLANISH_OK;
}

/** Read elements of other types; nodes of those without a planish_cell_type are held. */
static int read_others(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                       planish_error *error) {
    const medit_reader *r = context;
    const io_element_type *type = &r->current->type;
    const int cell_type = io_cell_type(type->shape, type->nodes);
    for (int64_t i = begin; i < end; i++) {
        int32_t nodes[IO_CELL_NODES];
        int64_t node, reference;
        for (int j = 0; j < type->nodes; j++) {
            const int status =
                io_take_whole(&r->kind, cursor, i + 1, 1, r->model->n_nodes, &node, error);
            if (status)
                return status;
            if (!cell_type)
                io_hold_node(r->model, node - 1, io_element_reason(type));
            nodes[j] = (int32_t)(node - 1);
        }
        const int status =
            io_take_whole(&r->kind, cursor, i + 1, INT32_MIN, INT32_MAX, &reference, error);
        if (status)
            return status;
        if (!cell_type)
            continue;
        io_others_set(r->model, r->first_cell + i, r->first_node + i * type->nodes, cell_type,
                      nodes, i + 1);
        io_model_others(r->model, io_element_dim(type))->entity[r->first_cell + i] =
            (int32_t)reference;
    }
    return PLANISH_OK;
}

static int read_marked(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                       planish_error *error) {
    const medit_reader *r = context;
    const int dim = io_element_dim(&r->current->type);
    const int is_flat = r->current->type.shape == IO_QUADRILATERAL;
    const io_list list = io_model_list(r->model, is_flat ? IO_FLAT_LIST
                                                 : dim   ? dim
                                                         : IO_FIRST_LIST);
    const int64_t most = dim ? list.n : r->model->n_nodes;
    for (int64_t i = begin; i < end; i++) {
        int64_t number;
        int32_t node[IO_CELL_NODES];
        const int status = io_take_whole(&r->kind, cursor, i + 1, 1, most, &number, error);
        if (status)
            return status;
        node[0] = (int32_t)(number - 1);
        const int n = dim ? io_list_nodes(&list, number - 1, node, NULL) : 1;
        for (int j = 0; j < n; j++)
            io_hold_node(r->model, node[j], IO_HELD_REQUIRED);
    }
    return PLANISH_OK;
}

/* ---- orders of nodes ---------------------------------------------------------------------- */

/** Places of the nodes of elements of second order, in VTK's order. Of edges: a coordinate; of
 *  triangles and tetrahedra: barycentric coordinates; of quadrilaterals and hexahedra: coordinates; of prisms: barycentric
 *  coordinates and the height. */
typedef struct place_list {
    uint8_t shape, type;
    const char *place[IO_CELL_NODES];
} place_list;

static const place_list lists[] = {
    {IO_LINE, PLANISH_CELL_LINE3, {"0", "2", "1"}},
    {IO_TRIANGLE, PLANISH_CELL_TRIANGLE6, {"200", "020", "002", "110", "011", "101"}},
    {IO_QUADRILATERAL,
     PLANISH_CELL_QUADRILATERAL9,
     {"00", "20", "22", "02", "10", "21", "12", "01", "11"}},
    {IO_TETRAHEDRON,
     PLANISH_CELL_TETRAHEDRON10,
     {"2000", "0200", "0020", "0002", "1100", "0110", "1010", "1001", "0101", "0011"}},
    {IO_HEXAHEDRON, PLANISH_CELL_HEXAHEDRON27, {"000", "200", "220", "020", "002", "202", "222",
                                                "022", "100", "210", "120", "010", "102", "212",
                                                "122", "012", "001", "201", "221", "021", "011",
                                                "211", "101", "121", "110", "112", "111"}},
    {IO_PRISM,
     PLANISH_CELL_WEDGE18,
     {"2000", "0200", "0020", "2002", "0202", "0022", "1100", "0110", "1010", "1102", "0112",
      "1012", "2001", "0201", "0021", "1101", "0111", "1011"}},
};

enum { NO_NODE = 255 };

static const place_list *places_of(int shape) {
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++)
        if (lists[i].shape == shape)
            return &lists[i];
    return NULL;
}

static int count_places(const place_list *places) {
    int n = 0;
    while (n < IO_CELL_NODES && places->place[n])
        n++;
    return n;
}

/** Read the places of the nodes of an element, each once. */
static int read_places(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                       planish_error *error) {
    medit_reader *r = context;
    const place_list *places = places_of(r->current->type.shape);
    const int n = count_places(places);
    io_node_order *order = r->order;
    while (order->type != places->type)
        order++;
    for (int64_t i = begin; i < end; i++) {
        const char *at = cursor->at;
        char place[5] = "";
        for (int j = 0; j < r->current->type.nodes; j++) {
            int64_t value;
            const int status = io_take_whole(&r->kind, cursor, i + 1, 0, 2, &value, error);
            if (status)
                return status;
            place[j] = (char)('0' + value);
        }
        int node = 0;
        while (node < n && strcmp(places->place[node], place) != 0)
            node++;
        if (node == n || order->at[node] != NO_NODE)
            return io_fail_at(r->model, at, error, "%s %lld: %s", r->current->type.name,
                              (long long)i + 1,
                              node == n ? "there is no node at that place"
                                        : "there is a node at that place already");
        order->at[node] = (uint8_t)i;
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

/** Count the reals of a record: vertices have dim, solutions one at least. */
static int count_reals(const medit_reader *r, const medit_keyword *k) {
    return k->kind == MEDIT_VERTICES ? r->dim : k->kind == MEDIT_SOLUTION;
}

/** Count the integers of a record: vertices and elements have a reference. */
static int count_integers(const medit_keyword *k) {
    return k->type.nodes +
           (k->kind == MEDIT_VERTICES || k->kind == MEDIT_ELEMENTS || k->kind == MEDIT_CURVED);
}

int64_t medit_record_size(const medit_reader *r, const medit_keyword *k) {
    return count_reals(r, k) * r->real_size + count_integers(k) * r->integer_size;
}

static int read_records(medit_reader *r, const io_section *s, io_records_fn *read) {
    const medit_keyword *k = r->current;
    return io_section_records(&r->text, s, k->type.name, count_reals(r, k) + count_integers(k),
                              medit_record_size(r, k), read, r, r->error);
}

/** Read the records of a section one after the other. */
static int read_in_order(medit_reader *r, const io_section *s, io_records_fn *read) {
    io_cursor cursor = {s->data, s->end};
    return r->model->is_binary
               ? read(r, &cursor, 0, s->count, r->error)
               : io_section_records(&r->text, s, r->current->type.name, 0, 0, read, r, r->error);
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

static int read_order_section(medit_reader *r, const io_section *s) {
    const place_list *places = places_of(r->current->type.shape);
    if (s->count != count_places(places))
        return io_fail_at(r->model, s->data, r->error,
                          "%s: %lld places, but the elements have %d nodes", r->current->type.name,
                          (long long)s->count, count_places(places));
    io_node_order *order = NULL;
    for (int i = 0; i < r->n_orders && !order; i++)
        order = r->order[i].type == places->type ? &r->order[i] : NULL;
    order = order ? order : &r->order[r->n_orders++];
    memset(order->at, NO_NODE, sizeof order->at);
    order->type = places->type;
    return read_in_order(r, s, read_places);
}

static int read_other_section(medit_reader *r, const io_section *s) {
    const io_element_type *type = &r->current->type;
    const int dim = io_element_dim(type);
    io_others *others = io_model_others(r->model, dim);
    if (!io_cell_type(type->shape, type->nodes))
        return read_records(r, s, read_others);
    r->first_cell = others->n;
    r->first_node = others->n_nodes;
    int status = io_others_reserve(r->model, dim, s->count, s->count * type->nodes, 1, r->error);
    if (!status)
        status = read_records(r, s, read_others);
    if (!status)
        status = io_model_index_tags(r->model, dim, others->entity + others->n, s->count, r->error);
    if (status)
        return status;
    others->n += s->count;
    others->n_nodes += s->count * type->nodes;
    return PLANISH_OK;
}

static int read_element_section(medit_reader *r, const io_section *s) {
    const io_element_type *type = &r->current->type;
    const int dim = io_element_dim(type);
    io_cells *cells = r->cells = io_element_cells(r->model, type);
    if (!cells) {
        io_element_count(r->model, type, s->count);
        return read_other_section(r, s);
    }
    cells->first_number = 1;
    r->first_cell = cells->n;
    const int has_mids = io_element_mids(type) > 0;
    int status = io_cells_reserve(r->model, dim, s->count, 1, 0, r->error);
    if (!status && has_mids)
        status = io_cells_reserve_mids(r->model, dim, r->error);
    if (!status)
        status = read_records(r, s, has_mids ? read_curved : read_elements);
    if (!status)
        status = io_model_index_tags(r->model, dim, cells->entity + cells->n, s->count, r->error);
    if (!status)
        cells->n += s->count;
    return status;
}

int medit_read_section(medit_reader *r, const io_section *s) {
    r->current = &r->keywords[s->keyword];
    r->kind = (io_record_kind){r->model, r->current->type.name,
                               r->model->is_binary ? r->integer_size : 0, r->swapped};
    switch (r->current->kind) {
    case MEDIT_VERTICES:
        return read_vertex_section(r, s);
    case MEDIT_ORDERING:
        return read_order_section(r, s);
    case MEDIT_ELEMENTS:
    case MEDIT_CURVED:
        return read_element_section(r, s);
    case MEDIT_MARKED:
        return read_records(r, s, read_marked);
    default:
        return read_pairs(r, s);
    }
}
