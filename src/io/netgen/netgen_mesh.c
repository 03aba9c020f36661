/* netgen_mesh: the sections of Netgen's meshes: points, elements, segments, and what holds nodes.
 */
#include "io/netgen/netgen.h"

#include "base/memory.h"
#include "base/status.h"

enum { PERIODIC = 2 }; /* of Netgen's types of identifications */

/* ---- records ------------------------------------------------------------------------------ */

/** A whole number of a record. */
static int take_integer(const netgen_reader *r, io_cursor *cursor, int64_t record,
                        planish_error *error, int64_t *value) {
    if (io_integer(cursor, value))
        return io_fail_at(r->model, cursor->at, error,
                          "%s %lld: a whole number expected (the file may be cut short)",
                          r->current->keyword->name, (long long)record + 1);
    return PLANISH_OK;
}

/** A number from first to last of what there is. */
static int take_index(const netgen_reader *r, io_cursor *cursor, int64_t record, int64_t first,
                      int64_t last, planish_error *error, int64_t *index) {
    int status = take_integer(r, cursor, record, error, index);
    if (!status && (*index < first || *index > last))
        return io_fail_at(r->model, cursor->at, error,
                          "%s %lld: number %lld is not in %lld .. "
                          "%lld",
                          r->current->keyword->name, (long long)record + 1, (long long)*index,
                          (long long)first, (long long)last);
    *index = status ? 0 : *index - first;
    return status;
}

static int take_node(const netgen_reader *r, io_cursor *cursor, int64_t record,
                     planish_error *error, int32_t *node) {
    int64_t index;
    int status = take_index(r, cursor, record, 1, r->model->n_nodes, error, &index);
    *node = status ? 0 : (int32_t)index;
    return status;
}

static int take_group(const netgen_reader *r, io_cursor *cursor, int64_t record,
                      planish_error *error, int32_t *group) {
    int64_t value;
    int status = take_integer(r, cursor, record, error, &value);
    if (!status && (value < INT32_MIN || value > INT32_MAX - 1))
        return io_fail_at(r->model, cursor->at, error, "%s %lld: number %lld is out of range",
                          r->current->keyword->name, (long long)record + 1, (long long)value);
    *group = status ? 0 : (int32_t)value;
    return status;
}

static int skip_words(const netgen_reader *r, io_cursor *cursor, int64_t record, int n,
                      planish_error *error) {
    int64_t length;
    for (int i = 0; i < n; i++) {
        const char *word = io_word(cursor, &length);
        if (length == 0)
            return io_fail_at(r->model, word, error, "%s %lld is cut short",
                              r->current->keyword->name, (long long)record + 1);
    }
    return PLANISH_OK;
}

static int read_points(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                       planish_error *error) {
    const netgen_reader *r = context;
    int status = PLANISH_OK;
    for (int64_t i = begin; i < end && !status; i++)
        status = io_read_point(r->model, cursor, i, error);
    return status;
}

/** The words before the nodes: the group, and last the number of nodes. */
static int take_lead(const netgen_reader *r, io_cursor *cursor, int64_t record,
                     planish_error *error, int32_t *group, int64_t *corners) {
    const netgen_keyword *k = r->current->keyword;
    int status = skip_words(r, cursor, record, k->group, error);
    if (!status)
        status = take_group(r, cursor, record, error, group);
    if (!status)
        status = skip_words(r, cursor, record, k->words - k->group - 2, error);
    if (!status)
        status = take_integer(r, cursor, record, error, corners);
    if (status)
        return status;
    const int64_t of_second_order = k->corner == 2 ? 6 : 10;
    *corners = *corners == 0 ? NETGEN_LEAST_CORNERS : *corners;
    if (*corners == of_second_order)
        return io_fail_at(r->model, cursor->at, error,
                          "%s %lld is of second order (%lld nodes): only linear elements can be "
                          "smoothed; save the mesh before SecondOrder()",
                          k->name, (long long)record + 1, (long long)*corners);
    if (*corners < NETGEN_LEAST_CORNERS || *corners > NETGEN_MOST_CORNERS)
        return io_fail_at(r->model, cursor->at, error, "%s %lld: %lld nodes are unknown", k->name,
                          (long long)record + 1, (long long)*corners);
    return PLANISH_OK;
}

/** Triangles and tetrahedra are kept, others hold their nodes. Elements that differ are read in
 *  order; r->n_kept of them are kept so far. */
static int read_elements(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                         planish_error *error) {
    netgen_reader *r = context;
    const netgen_keyword *k = r->current->keyword;
    io_cells *cells = io_model_cells(r->model, k->corner);
    for (int64_t i = begin; i < end; i++) {
        int32_t group, node;
        int64_t corners;
        int status = take_lead(r, cursor, i, error, &group, &corners);
        if (!status && r->corners && corners != r->corners)
            return PLANISH_ERROR_FORMAT; /* they differ: read again, in order */
        const int kept = corners == k->corner + 1;
        const int64_t cell = r->first_cell + (r->corners ? i : r->n_kept);
        for (int j = 0; j < corners && !status; j++) {
            status = take_node(r, cursor, i, error, &node);
            if (kept)
                cells->nodes[cell * corners + j] = node;
            else if (!status)
                io_hold_node(r->model, node, IO_HELD_BY_OTHER);
            if (k->parameter[0] && !status)
                io_hold_node(r->model, node, IO_HAS_PARAMETERS);
        }
        if (!status)
            status = skip_words(r, cursor, i, k->extra * (int)corners, error);
        if (status)
            return status;
        if (kept)
            cells->entity[cell] = group;
        if (!r->corners)
            r->n_kept += kept;
    }
    return PLANISH_OK;
}

/** The parameter of a node, which files without a geometry leave 0. */
static int take_parameter(const netgen_reader *r, io_cursor *cursor, int64_t record, int32_t node,
                          planish_error *error) {
    io_cursor word = *cursor;
    double value;
    if (!io_real(&word, &value) && value != 0)
        io_hold_node(r->model, node, IO_HAS_PARAMETERS);
    return skip_words(r, cursor, record, 1, error);
}

static int read_segments(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                         planish_error *error) {
    const netgen_reader *r = context;
    const netgen_keyword *k = r->current->keyword;
    const int group = k->words == 12 && r->dim == 2 ? 0 : k->group;
    io_cells *lines = &r->model->line;
    for (int64_t i = begin; i < end; i++) {
        const int64_t cell = r->first_cell + i;
        int status = PLANISH_OK;
        for (int j = 0; j < k->words && !status; j++) {
            if (j == k->corner || j == k->corner + 1)
                status = take_node(r, cursor, i, error, &lines->nodes[2 * cell + j - k->corner]);
            else if (j == group)
                status = take_group(r, cursor, i, error, &lines->entity[cell]);
            else if (k->parameter[0] && (j == k->parameter[0] || j == k->parameter[1]))
                status = take_parameter(r, cursor, i,
                                        lines->nodes[2 * cell + (j == k->parameter[1])], error);
            else
                status = skip_words(r, cursor, i, 1, error);
        }
        if (status)
            return status;
        if (k->corner == 0) /* numbered from 0, unlike names */
            lines->entity[cell]++;
    }
    return PLANISH_OK;
}

/** Records of a node and another number: the node is held. */
static int read_held(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                     planish_error *error) {
    const netgen_reader *r = context;
    const int is_element = r->current->keyword->kind == NETGEN_POINT_ELEMENTS;
    for (int64_t i = begin; i < end; i++) {
        int32_t node;
        int status = take_node(r, cursor, i, error, &node);
        if (!status)
            status = skip_words(r, cursor, i, 1, error);
        if (status)
            return status;
        io_hold_node(r->model, node, is_element ? IO_HELD_BY_POINT : IO_HELD_REQUIRED);
    }
    return PLANISH_OK;
}

/** Numbers of segments, from 0. */
static int read_singular_segments(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                                  planish_error *error) {
    const netgen_reader *r = context;
    const io_cells *lines = &r->model->line;
    for (int64_t i = begin; i < end; i++) {
        int64_t segment;
        int status = take_index(r, cursor, i, 0, lines->n - 1, error, &segment);
        if (!status)
            status = skip_words(r, cursor, i, 1, error);
        for (int j = 0; j < 2 && !status; j++)
            io_hold_node(r->model, lines->nodes[2 * segment + j], IO_HELD_REQUIRED);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

/** Type of each identification, by its number. */
static int read_types(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                      planish_error *error) {
    netgen_reader *r = context;
    for (int64_t i = begin; i < end; i++) {
        int64_t type;
        int status = take_integer(r, cursor, i, error, &type);
        if (status)
            return status;
        r->is_periodic[i] = type == PERIODIC;
    }
    return PLANISH_OK;
}

/** Two nodes and the number of their identification. Those that are not periodic (close surfaces)
 *  stay where they are. */
static int read_pairs(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                      planish_error *error) {
    const netgen_reader *r = context;
    for (int64_t i = begin; i < end; i++) {
        int32_t pair[2];
        int64_t number;
        int status = take_node(r, cursor, i, error, &pair[0]);
        if (!status)
            status = take_node(r, cursor, i, error, &pair[1]);
        if (!status)
            status = take_integer(r, cursor, i, error, &number);
        if (status)
            return status;
        const int periodic =
            !r->is_periodic || (number >= 1 && number <= r->n_types && r->is_periodic[number - 1]);
        for (int j = 0; j < 2; j++)
            io_hold_node(r->model, pair[j], periodic ? IO_HELD_PERIODIC : IO_HELD_REQUIRED);
        if (periodic && pair[0] != pair[1] && io_model_pair(r->model, pair, error))
            return PLANISH_ERROR_MEMORY;
    }
    return PLANISH_OK;
}

/* ---- sections ----------------------------------------------------------------------------- */

/** Nothing but comments is between the last record and the next word; nor is that word, which may
 *  have been passed over, a part of the record. */
static int check_end(const netgen_reader *r, const netgen_section *s, io_cursor *cursor) {
    if (cursor->at > s->end)
        return io_fail_at(r->model, s->end, r->error,
                          "the next section begins within the last of %lld %s (the file may be "
                          "damaged)",
                          (long long)s->count, s->keyword->name);
    io_skip_space_comments(cursor, '#');
    if (cursor->at < s->end)
        return io_fail_at(r->model, cursor->at, r->error, "more than %lld %s follow",
                          (long long)s->count, s->keyword->name);
    return PLANISH_OK;
}

/** Records of words words, by several threads; 0: in order, as they differ or make a list. */
static int read_records(netgen_reader *r, const netgen_section *s, int64_t words,
                        io_records_fn *read, planish_error *error) {
    io_cursor cursor = {s->data, r->model->input.data + r->model->input.size};
    r->current = s;
    int status = words ? io_text_records(&r->text, &cursor, s->count, words, read, r, error)
                       : read(r, &cursor, 0, s->count, error);
    return status ? status : check_end(r, s, &cursor);
}

static int read_point_section(netgen_reader *r, const netgen_section *s) {
    io_model *model = r->model;
    if (model->xyz)
        return io_fail_at(model, s->data, r->error, "points for the second time");
    int status = io_model_nodes(model, s->count, 1, r->error);
    if (status)
        return status;
    model->columns = 3;
    model->first_number = 1;
    model->precision = PLANISH_DOUBLE;
    status = io_model_span(model, (io_span){.n_nodes = s->count, .encoding = IO_TEXT}, r->error);
    return status ? status : read_records(r, s, s->keyword->words, read_points, r->error);
}

/** Nodes of the first element of a section; 0 if it is none. */
static int first_corners(netgen_reader *r, const netgen_section *s) {
    io_cursor cursor = {s->data, s->end};
    planish_error ignored;
    int32_t group;
    int64_t corners = 0;
    r->current = s;
    if (s->count == 0 || take_lead(r, &cursor, 0, &ignored, &group, &corners))
        return 0;
    return (int)corners;
}

static int read_element_section(netgen_reader *r, const netgen_section *s) {
    const netgen_keyword *k = s->keyword;
    io_cells *cells = io_model_cells(r->model, k->corner);
    planish_error ignored;
    cells->first_number = 1;
    r->first_cell = cells->n;
    int status = io_cells_reserve(cells, k->corner, s->count, 1, 0, r->error);
    if (status)
        return status;
    /* As a rule all are alike, which threads can read. Others hold nodes: what a thread would hold
     * that begins in the middle of one could not be taken back. */
    r->corners = first_corners(r, s) == k->corner + 1 ? k->corner + 1 : 0;
    status = r->corners ? read_records(r, s, k->words + (1 + k->extra) * (int64_t)r->corners,
                                       read_elements, &ignored)
                        : PLANISH_ERROR_FORMAT;
    r->n_kept = s->count;
    if (status) {
        r->corners = 0;
        r->n_kept = 0;
        status = read_records(r, s, 0, read_elements, r->error);
    }
    if (!status)
        status = io_model_index_tags(r->model, k->corner, cells->entity + r->first_cell, r->n_kept,
                                     r->error);
    if (status)
        return status;
    cells->n += r->n_kept;
    r->model->n_other += s->count - r->n_kept;
    return PLANISH_OK;
}

static int read_segment_section(netgen_reader *r, const netgen_section *s) {
    io_cells *lines = &r->model->line;
    lines->first_number = 1;
    r->first_cell = lines->n;
    int status = io_cells_reserve(lines, 1, s->count, 1, 0, r->error);
    if (!status)
        status = read_records(r, s, s->keyword->words, read_segments, r->error);
    if (!status)
        status =
            io_model_index_tags(r->model, 1, lines->entity + r->first_cell, s->count, r->error);
    if (!status)
        lines->n += s->count;
    return status;
}

static int read_type_section(netgen_reader *r, const netgen_section *s) {
    pl_free(r->is_periodic);
    r->is_periodic = pl_alloc(s->count, 1);
    r->n_types = s->count;
    if (!r->is_periodic)
        return pl_fail_memory(r->error, "the periodic nodes");
    return read_records(r, s, 0, read_types, r->error);
}

int netgen_read_section(netgen_reader *r, const netgen_section *s) {
    switch (s->keyword->kind) {
    case NETGEN_POINTS:
        return read_point_section(r, s);
    case NETGEN_ELEMENTS:
        return read_element_section(r, s);
    case NETGEN_SEGMENTS:
        return read_segment_section(r, s);
    case NETGEN_PAIR_TYPES:
        return read_type_section(r, s);
    case NETGEN_PAIRS:
        return read_records(r, s, 0, read_pairs, r->error);
    case NETGEN_SINGULAR_SEGMENTS:
        return read_records(r, s, s->keyword->words, read_singular_segments, r->error);
    case NETGEN_POINT_ELEMENTS:
        r->model->n_lower += s->count;
        return read_records(r, s, s->keyword->words, read_held, r->error);
    default:
        return read_records(r, s, s->keyword->words, read_held, r->error);
    }
}
