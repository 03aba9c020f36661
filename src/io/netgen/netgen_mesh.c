/* netgen_mesh: the sections of Netgen's meshes: points, elements, segments, and what holds nodes.
 */
#include "io/netgen/netgen_reader.h"

#include "base/memory.h"
#include "base/status.h"

enum { PERIODIC = 2 }; /* of Netgen's types of identifications */

/* ---- words of a record -------------------------------------------------------------------- */

static int take_node(const netgen_reader *r, io_cursor *cursor, int64_t record, int32_t *node,
                     planish_error *error) {
    int64_t number = 0;
    const int status =
        io_take_whole(&r->kind, cursor, record + 1, 1, r->model->n_nodes, &number, error);
    *node = (int32_t)number - 1;
    return status;
}

static int take_group(const netgen_reader *r, io_cursor *cursor, int64_t record, int32_t *group,
                      planish_error *error) {
    int64_t number = 0;
    const int status =
        io_take_whole(&r->kind, cursor, record + 1, INT32_MIN, INT32_MAX - 1, &number, error);
    *group = (int32_t)number;
    return status;
}

static int skip_words(const netgen_reader *r, io_cursor *cursor, int64_t record, int64_t n,
                      planish_error *error) {
    for (int64_t i = 0; i < n; i++) {
        const io_slice word = io_next_word(cursor);
        if (io_slice_length(word) == 0)
            return io_fail_at(r->model, word.begin, error, "%s %lld is cut short", r->current->name,
                              (long long)record + 1);
    }
    return PLANISH_OK;
}

/* ---- elements that are no simplices ------------------------------------------------------ */

/* Of MakeSecondOrder in Netgen's secondorder.cpp. */
const io_node_order netgen_node_orders[] = {
    {PLANISH_CELL_TRIANGLE6, {0, 1, 2, 5, 3, 4}},
    {PLANISH_CELL_QUADRILATERAL8, {0, 1, 2, 3, 4, 7, 5, 6}},
    {PLANISH_CELL_TETRAHEDRON10, {0, 1, 2, 3, 4, 7, 5, 6, 8, 9}},
    {PLANISH_CELL_PYRAMID13, {0, 1, 2, 3, 4, 5, 8, 6, 7, 9, 10, 11, 12}},
    {PLANISH_CELL_WEDGE15, {0, 1, 2, 3, 4, 5, 6, 8, 7, 12, 14, 13, 9, 10, 11}},
    {PLANISH_CELL_HEXAHEDRON20,
     {0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 9, 10, 12, 15, 13, 14, 16, 17, 18, 19}},
    {0, {0}}};

/** Add an element of n nodes, of a group, to the others. Prisms of 12 nodes are those of 15 without the mids
 *  of upright edges, but with the first two mids of each triangle the other way round. */
static int add_other(const netgen_reader *r, int64_t n, const int32_t *nodes, int32_t group,
                     int64_t number, planish_error *error) {
    static const io_shape solids[] = {
        [5] = IO_PYRAMID,  [6] = IO_PRISM,  [8] = IO_HEXAHEDRON, [10] = IO_TETRAHEDRON,
        [13] = IO_PYRAMID, [15] = IO_PRISM, [20] = IO_HEXAHEDRON};
    static const uint8_t prism12[15] = {0, 1, 2, 3, 4, 5, 7, 6, 8, 12, 12, 12, 10, 9, 11};
    const int is_solid = r->current->dim == 3;
    int32_t prism15[15];
    if (is_solid && n == 12) {
        for (int i = 0; i < 15; i++)
            prism15[i] = prism12[i] < 12 ? nodes[prism12[i]] : -1;
        nodes = prism15;
        n = 15;
    }
    const io_shape flat = n == 6 ? IO_TRIANGLE : IO_QUADRILATERAL;
    const io_shape solid = n < (int64_t)(sizeof solids / sizeof *solids) ? solids[n] : IO_NO_SHAPE;
    const int type = io_cell_type((int)(is_solid ? solid : flat), (int)n);
    const int status = io_model_add_other(r->model, type, nodes, 0, number, error);
    io_others *others = io_model_others(r->model, r->current->dim);
    if (!status && type)
        others->entity[others->n - 1] = group; /* a tag, which any number can be */
    for (int64_t j = 0; j < n && !type; j++)
        io_hold_node(r->model, nodes[j], IO_HELD_BY_OTHER);
    return status;
}

/* ---- elements and segments ---------------------------------------------------------------- */

/** Take the words before the nodes of an element: the group, and last the number of nodes. */
static int take_lead(const netgen_reader *r, io_cursor *cursor, int64_t record, int32_t *group,
                     int64_t *corners, planish_error *error) {
    const netgen_keyword *k = r->current;
    int status = skip_words(r, cursor, record, k->group, error);
    if (!status)
        status = take_group(r, cursor, record, group, error);
    if (!status)
        status = skip_words(r, cursor, record, k->words - k->group - 2, error);
    if (!status)
        status = io_take_whole(&r->kind, cursor, record + 1, INT64_MIN, INT64_MAX, corners, error);
    if (status)
        return status;
    *corners = *corners == 0 ? NETGEN_LEAST_CORNERS : *corners;
    if (*corners < NETGEN_LEAST_CORNERS || *corners > NETGEN_MOST_CORNERS)
        return io_fail_at(r->model, cursor->at, error, "%s %lld: %lld nodes are unknown", k->name,
                          (long long)record + 1, (long long)*corners);
    return PLANISH_OK;
}

/** Return the number of mids of an element of n nodes that is a simplex of order 1 or 2; -1: it is
 *  none. */
static int mids_of(int dim, int64_t n) {
    return n == dim + 1 ? 0 : n == dim + 1 + io_n_mids(dim) ? io_n_mids(dim) : -1;
}

/** Keep a simplex of nodes [dim + 1 + mids] as that cell. */
static int keep_element(const netgen_reader *r, int64_t cell, const int32_t *nodes, int mids,
                        planish_error *error) {
    const int dim = r->current->dim;
    io_cells *cells = io_model_cells(r->model, dim);
    for (int j = 0; j <= dim; j++)
        cells->nodes[cell * (dim + 1) + j] = nodes[j];
    if (mids > 0 && !cells->mid) { /* elements differ */
        const int status = io_cells_reserve_mids(r->model, dim, error);
        if (status)
            return status;
    }
    if (mids > 0)
        io_cells_set_mids(r->model, dim, cell, nodes);
    for (int j = 0; cells->mid && mids == 0 && j < io_n_mids(dim); j++)
        cells->mid[cell * io_n_mids(dim) + j] = -1; /* threads may have begun to read */
    return PLANISH_OK;
}

/** Read elements: triangles and tetrahedra are kept, others added to the model's. Elements that differ are read in order; r->n_kept of them are kept so far. */
static int read_elements(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                         planish_error *error) {
    netgen_reader *r = context;
    const netgen_keyword *k = r->current;
    io_cells *cells = io_model_cells(r->model, k->dim);
    for (int64_t i = begin; i < end; i++) {
        const int64_t number = r->first_number + i;
        int32_t group, nodes[NETGEN_MOST_CORNERS];
        int64_t corners;
        int status = take_lead(r, cursor, i, &group, &corners, error);
        if (status)
            return status;
        if (r->corners && corners != r->corners)
            return PLANISH_ERROR_FORMAT; /* they differ: read again, in order */
        const int mids = mids_of(k->dim, corners), kept = mids >= 0;
        const int64_t cell = r->first_cell + (r->corners ? i : r->n_kept);
        for (int j = 0; j < corners; j++) {
            status = take_node(r, cursor, i, &nodes[j], error);
            if (status)
                return status;
            if (k->parameter[0])
                io_hold_node(r->model, nodes[j], IO_HAS_PARAMETERS);
        }
        status = skip_words(r, cursor, i, k->extra * corners, error);
        if (!status)
            status = kept ? keep_element(r, cell, nodes, mids, error)
                          : add_other(r, corners, nodes, group, number, error);
        if (status)
            return status;
        if (kept)
            cells->entity[cell] = group;
        if (kept && cells->number)
            cells->number[cell] = number;
        if (!r->corners)
            r->n_kept += kept;
    }
    return PLANISH_OK;
}

static int read_segments(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                         planish_error *error) {
    const netgen_reader *r = context;
    const netgen_keyword *k = r->current;
    const int group = k->words == 12 && r->dim == 2 ? 0 : k->group;
    io_cells *lines = &r->model->line;
    for (int64_t i = begin; i < end; i++) {
        const int64_t cell = r->first_cell + i;
        int32_t *nodes = lines->nodes + 2 * cell;
        int status = PLANISH_OK;
        for (int j = 0; j < k->words && !status; j++) {
            const int is_parameter = j > 0 && (j == k->parameter[0] || j == k->parameter[1]);
            io_cursor word = *cursor;
            double value;
            if (j == k->corner || j == k->corner + 1)
                status = take_node(r, cursor, i, &nodes[j - k->corner], error);
            else if (j == group)
                status = take_group(r, cursor, i, &lines->entity[cell], error);
            else
                status = skip_words(r, cursor, i, 1, error);
            /* Files without a geometry leave parameters of nodes 0. */
            if (is_parameter && !io_real(&word, &value) && value != 0)
                io_hold_node(r->model, nodes[j == k->parameter[1]], IO_HAS_PARAMETERS);
        }
        if (status)
            return status;
        if (k->corner == 0) /* numbered from 0, unlike names */
            lines->entity[cell]++;
    }
    return PLANISH_OK;
}

/* ---- what holds nodes --------------------------------------------------------------------- */

/** Read records of another number behind that of a node, from 1, or of a segment, from 0; its nodes
 *  are held. */
static int read_held(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                     planish_error *error) {
    const netgen_reader *r = context;
    const io_cells *lines = &r->model->line;
    const int of_segment = r->current->kind == NETGEN_SINGULAR_SEGMENTS;
    for (int64_t i = begin; i < end; i++) {
        int64_t number;
        int status = io_take_whole(&r->kind, cursor, i + 1, !of_segment,
                                   of_segment ? lines->n - 1 : r->model->n_nodes, &number, error);
        if (!status)
            status = skip_words(r, cursor, i, 1, error);
        if (status)
            return status;
        for (int j = 0; j <= of_segment; j++)
            io_hold_node(r->model, of_segment ? lines->nodes[2 * number + j] : number - 1,
                         IO_HELD_REQUIRED);
    }
    return PLANISH_OK;
}

/** Put a node into the group of a point; of several the largest number counts, whichever thread is first. */
static void group_point(const io_model *model, int64_t node, int32_t group) {
    int32_t now = __atomic_load_n(&model->node_entity[node], __ATOMIC_RELAXED);
    while (now < group && !__atomic_compare_exchange_n(&model->node_entity[node], &now, group, 0,
                                                       __ATOMIC_RELAXED, __ATOMIC_RELAXED))
        ;
}

/** Read points: a node, from 1, which is held, and the number of its group; from 1, or it is in none. */
static int read_points(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                       planish_error *error) {
    const netgen_reader *r = context;
    for (int64_t i = begin; i < end; i++) {
        int64_t node, group;
        int status = io_take_whole(&r->kind, cursor, i + 1, 1, r->model->n_nodes, &node, error);
        if (!status)
            status = io_take_whole(&r->kind, cursor, i + 1, INT32_MIN, INT32_MAX, &group, error);
        if (status)
            return status;
        io_hold_node(r->model, node - 1, IO_HELD_BY_POINT);
        group_point(r->model, node - 1, (int32_t)group);
    }
    return PLANISH_OK;
}

/** Read the type of each identification, by its number. */
static int read_types(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                      planish_error *error) {
    netgen_reader *r = context;
    for (int64_t i = begin; i < end; i++) {
        int64_t type;
        const int status =
            io_take_whole(&r->kind, cursor, i + 1, INT64_MIN, INT64_MAX, &type, error);
        if (status)
            return status;
        r->is_periodic[i] = type == PERIODIC;
    }
    return PLANISH_OK;
}

/** Read two nodes and the number of their identification. Those that are not periodic (close
 *  surfaces) stay where they are. */
static int read_pairs(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                      planish_error *error) {
    const netgen_reader *r = context;
    for (int64_t i = begin; i < end; i++) {
        int32_t pair[2];
        int64_t number;
        int status = take_node(r, cursor, i, &pair[0], error);
        if (!status)
            status = take_node(r, cursor, i, &pair[1], error);
        if (!status)
            status = io_take_whole(&r->kind, cursor, i + 1, INT64_MIN, INT64_MAX, &number, error);
        if (status)
            return status;
        const int periodic =
            !r->is_periodic || (number >= 1 && number <= r->n_types && r->is_periodic[number - 1]);
        for (int j = 0; j < 2; j++)
            io_hold_node(r->model, pair[j], periodic ? IO_HELD_PERIODIC : IO_HELD_REQUIRED);
        if (periodic && pair[0] != pair[1])
            status = io_model_pair(r->model, pair, error);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

/* ---- sections ----------------------------------------------------------------------------- */

/** Read records of words words, by several threads; 0: in order, as they differ or make a list. */
static int read_records(netgen_reader *r, const io_section *s, int64_t words, io_records_fn *read,
                        planish_error *error) {
    return io_section_records(&r->text, s, r->current->name, words, 0, read, r, error);
}

static int read_point_section(netgen_reader *r, const io_section *s) {
    io_model *model = r->model;
    if (model->xyz)
        return io_fail_at(model, s->data, r->error, "points for the second time");
    const int status = io_model_make_nodes(model, s->count, 8, 0, 0, s->data, r->error);
    if (status)
        return status;
    model->first_number = 1;
    io_node_records points = {.model = model};
    return io_section_records(&r->text, s, r->current->name, r->current->words, 0, io_read_nodes,
                              &points, r->error);
}

/** Give the cells numbers of their own, as others may stand between them. */
static int number_cells(io_cells *cells, planish_error *error) {
    if (cells->number)
        return PLANISH_OK;
    cells->number = pl_alloc(cells->capacity, sizeof *cells->number);
    if (!cells->number)
        return pl_fail_memory(error, "the elements");
    for (int64_t i = 0; i < cells->n; i++)
        cells->number[i] = cells->first_number + i;
    return PLANISH_OK;
}

/** Read elements or segments. */
static int read_element_section(netgen_reader *r, const io_section *s) {
    const netgen_keyword *k = r->current;
    const int dim = k->dim;
    io_cells *cells = io_model_cells(r->model, dim);
    io_cursor first = {s->data, s->end};
    planish_error ignored;
    int32_t group;
    int64_t corners;
    cells->first_number = 1;
    r->first_cell = cells->n;
    r->first_number = 1 + r->n_elements[dim];
    r->n_elements[dim] += s->count;
    r->n_kept = s->count;
    int status = io_cells_reserve(r->model, dim, s->count, 1, cells->number != NULL, r->error);
    if (status)
        return status;
    /* As a rule all elements are like the first, and threads can read them. */
    io_others *others = io_model_others(r->model, dim);
    const int64_t first_other = others->n;
    r->corners = 0;
    if (dim > 1 && s->count > 0 && !take_lead(r, &first, 0, &group, &corners, &ignored) &&
        mids_of(dim, corners) >= 0)
        r->corners = (int)corners;
    if (r->corners > dim + 1)
        status = io_cells_reserve_mids(r->model, dim, r->error);
    if (status)
        return status;
    if (dim == 1) {
        status = read_records(r, s, k->words, read_segments, r->error);
    } else if (!r->corners || read_records(r, s, k->words + (1 + k->extra) * (int64_t)r->corners,
                                           read_elements, &ignored)) {
        r->corners = 0;
        r->n_kept = 0;
        status = number_cells(cells, r->error);
        if (!status)
            status = read_records(r, s, 0, read_elements, r->error);
    }
    if (!status)
        status = io_model_index_tags(r->model, dim, cells->entity + cells->n, r->n_kept, r->error);
    if (!status && others->n > first_other)
        status = io_model_index_tags(r->model, dim, others->entity + first_other,
                                     others->n - first_other, r->error);
    if (status)
        return status;
    cells->n += r->n_kept;
    r->model->n_other += s->count - r->n_kept;
    return PLANISH_OK;
}

/** Read the section of points, whose groups are entities of nodes then. */
static int read_point_elements(netgen_reader *r, const io_section *s) {
    io_model *model = r->model;
    model->n_lower += s->count;
    if (!model->node_entity)
        model->node_entity = pl_alloc_zero(model->n_nodes, sizeof *model->node_entity);
    return model->node_entity ? read_records(r, s, r->current->words, read_points, r->error)
                              : pl_fail_memory(r->error, "the groups of points");
}

int netgen_read_section(netgen_reader *r, const io_section *s) {
    const netgen_keyword *k = r->current = &netgen_keywords[s->keyword];
    r->kind = (io_record_kind){.model = r->model, .what = k->name};
    switch (k->kind) {
    case NETGEN_POINTS:
        return read_point_section(r, s);
    case NETGEN_ELEMENTS:
    case NETGEN_SEGMENTS:
        return read_element_section(r, s);
    case NETGEN_PAIR_TYPES:
        pl_free(r->is_periodic);
        r->is_periodic = pl_alloc(s->count, 1);
        r->n_types = s->count;
        if (!r->is_periodic)
            return pl_fail_memory(r->error, "the periodic nodes");
        return read_records(r, s, 0, read_types, r->error);
    case NETGEN_PAIRS:
        return read_records(r, s, 0, read_pairs, r->error);
    case NETGEN_POINT_ELEMENTS:
        return read_point_elements(r, s);
    default:
        return read_records(r, s, k->words, read_held, r->error);
    }
}
