/* ucd: AVS UCD (unstructured cell data), text and binary.
 *
 * Comments ('#'), then a line of five counts: nodes, cells, numbers of data for each node, for each
 * cell and for the model. A line for each node: its number and three coordinates. A line for each
 * cell: its number, its material, its type and its nodes. Data follow, which nobody looks at here.
 *
 * The material is the region of a cell, and the number of its group. Pyramids begin with their tip,
 * prisms and hexahedra with their upper side. MicroAVS adds cells of second order (tet2): the order
 * of their mids is not known here, so that they hold their nodes.
 */
#include "io/ucd/ucd_reader.h"

#include "io/core/format.h"
#include "io/core/runs.h"

#include "base/memory.h"
#include "base/status.h"

enum { NODE_WORDS = 4, CELL_WORDS = 3 /* before the nodes */ };

const io_element_type ucd_types[UCD_N_TYPES] = {
    {"pt", IO_POINT, 1, 1},
    {"line", IO_LINE, 1, 2},
    {"tri", IO_TRIANGLE, 1, 3},
    {"quad", IO_QUADRILATERAL, 1, 4},
    {"tet", IO_TETRAHEDRON, 1, 4},
    {"pyr", IO_PYRAMID, 1, 5},
    {"prism", IO_PRISM, 1, 6},
    {"hex", IO_HEXAHEDRON, 1, 8},
    /* IO_ANY_SHAPE: mids in no known order */
    {"line2", IO_ANY_SHAPE, 2, 3},
    {"tri2", IO_ANY_SHAPE, 2, 6},
    {"quad2", IO_ANY_SHAPE, 2, 8},
    {"tet2", IO_ANY_SHAPE, 2, 10},
    {"pyr2", IO_ANY_SHAPE, 2, 13},
    {"prism2", IO_ANY_SHAPE, 2, 15},
    {"hex2", IO_ANY_SHAPE, 2, 20},
};

static const io_node_order node_orders[] = {{PLANISH_CELL_PYRAMID, {1, 2, 3, 4, 0}},
                                            {PLANISH_CELL_WEDGE, {3, 4, 5, 0, 1, 2}},
                                            {PLANISH_CELL_HEXAHEDRON, {4, 5, 6, 7, 0, 1, 2, 3}},
                                            {0, {0}}};

typedef struct ucd_reader {
    io_model *model;
    planish_error *error;
    io_text text;
    io_cursor cursor;
    int64_t count[UCD_N_COUNTS];
    io_run run; /* of cells, that is read */
} ucd_reader;

/* ---- counts -------------------------------------------------------------------------------- */

/** Take the line of counts behind comments; the last may be left out. Return how many there are, or
 *  -1: it is none. */
static int take_counts(io_cursor *cursor, int64_t count[UCD_N_COUNTS]) {
    io_skip_space_comments(cursor, '#');
    io_cursor line = io_take_line(cursor);
    int64_t value;
    int n = 0;
    count[UCD_N_COUNTS - 1] = 0;
    while (n < UCD_N_COUNTS && io_integer(&line, &value) == 0) {
        if (value < 0)
            return -1;
        count[n++] = value;
    }
    io_skip_space(&line);
    return line.at == line.end && n >= UCD_N_COUNTS - 1 ? n : -1;
}

/** Note the data that the counts say. */
static int note_data(io_model *model, const int64_t count[UCD_N_COUNTS], planish_error *error) {
    static const char *const texts[] = {"data of nodes", "data of elements", "data of the model"};
    int status = PLANISH_OK;
    for (int i = 2; i < UCD_N_COUNTS && !status; i++)
        status = io_model_note_lost(model, count[i] > 0, texts[i - 2], error);
    return status;
}

/* ---- nodes --------------------------------------------------------------------------------- */

/** Read nodes, each in a line of its own. */
static int read_nodes(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                      planish_error *error) {
    const ucd_reader *r = context;
    io_model *model = r->model;
    for (int64_t i = begin; i < end; i++) {
        io_cursor line = io_take_line(cursor);
        const char *row = line.at;
        if (io_integer(&line, &model->node_number[i]))
            return io_fail_at(model, row, error,
                              "node %lld of %lld: its number expected (the file may be cut short)",
                              (long long)i + 1, (long long)r->count[0]);
        const int status = io_read_node(model, &line, i, error);
        if (status)
            return status;
        io_skip_space(&line);
        if (line.at < line.end)
            return io_fail_at(model, line.at, error,
                              "node %lld: a line of a number and three coordinates expected",
                              (long long)model->node_number[i]);
    }
    return PLANISH_OK;
}

static int read_all_nodes(ucd_reader *r) {
    io_model *model = r->model;
    const int64_t n = r->count[0];
    int status = io_check_count(model, r->cursor, n, 2 * NODE_WORDS, "nodes", r->error);
    if (!status)
        status = io_model_make_nodes(model, n, 8, 0, 0, NULL, r->error);
    if (status)
        return status;
    model->node_number = pl_alloc(n, sizeof *model->node_number);
    if (!model->node_number)
        return pl_fail_memory(r->error, "the numbers of nodes");
    status = io_text_records(&r->text, &r->cursor, n, NODE_WORDS, read_nodes, r, r->error);
    return status ? status : io_reduce_node_numbers(model, r->error);
}

/* ---- cells --------------------------------------------------------------------------------- */

/** Find the row of a type; -1: there is none. */
static int find_type(io_slice word) {
    for (int i = 0; i < UCD_N_TYPES; i++)
        if (io_slice_is(word, ucd_types[i].name, 0))
            return i;
    return -1;
}

/** Find the runs of cells of one type, and move the cursor behind the last cell. */
static int find_runs(ucd_reader *r, io_sections *runs) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < r->count[1] && !status; i++) {
        io_cursor line = io_take_line(&r->cursor);
        const char *row = line.at;
        io_next_word(&line);
        io_next_word(&line);
        const io_slice word = io_next_word(&line);
        const int type = find_type(word);
        if (type < 0 && io_slice_length(word) == 0)
            return io_fail_at(r->model, row, r->error,
                              "cell %lld of %lld: number, material and type expected (the file may "
                              "be cut short)",
                              (long long)i + 1, (long long)r->count[1]);
        if (type < 0)
            return io_fail_at(r->model, word.begin, r->error,
                              "cell %lld of %lld: '%.*s' is not a type of AVS UCD (pt, line, tri, "
                              "quad, tet, pyr, prism, hex)",
                              (long long)i + 1, (long long)r->count[1], IO_QUOTED(word));
        status = io_runs_add(runs, type, CELL_WORDS + ucd_types[type].nodes, row, r->cursor.at,
                             r->error);
    }
    return status;
}

/** Read the cells of a run, each in a line of its own. */
static int read_cells(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                      planish_error *error) {
    const ucd_reader *r = context;
    const io_element_type *type = r->run.row;
    for (int64_t i = begin; i < end; i++) {
        int64_t number, material, node;
        int32_t nodes[UCD_MOST_NODES];
        io_cursor line = io_take_line(cursor);
        const char *row = line.at;
        if (io_integer(&line, &number) || io_integer(&line, &material) || material < INT32_MIN ||
            material > INT32_MAX || !io_slice_is(io_next_word(&line), type->name, 0))
            return io_fail_at(r->model, row, error,
                              "a cell's number, its material (a whole number of 32 bits) and its "
                              "type expected");
        for (int k = 0; k < type->nodes; k++) {
            if (io_integer(&line, &node))
                return io_fail_at(r->model, line.at, error,
                                  "cell %lld: %s has %d nodes in one line (the file may be cut "
                                  "short)",
                                  (long long)number, type->name, (int)type->nodes);
            nodes[k] = (int32_t)io_node_index(r->model, node);
            if (nodes[k] < 0)
                return io_fail_no_node(r->model, row, "cell", number, node, error);
        }
        io_skip_space(&line);
        if (line.at < line.end)
            return io_fail_at(r->model, line.at, error, "cell %lld: %s has at most %d nodes",
                              (long long)number, type->name, (int)type->nodes);
        io_run_set(&r->run, i, nodes, (int32_t)material, number);
    }
    return PLANISH_OK;
}

static int read_all_cells(ucd_reader *r) {
    io_sections runs = {0};
    int status =
        io_check_count(r->model, r->cursor, r->count[1], 2 * (CELL_WORDS + 1), "cells", r->error);
    if (!status)
        status = find_runs(r, &runs);
    for (int64_t i = 0; i < runs.n && !status; i++) {
        const io_section *s = &runs.section[i];
        status = io_run_read(r->model, &r->text, s, &ucd_types[s->keyword], read_cells, r, &r->run,
                             r->error);
    }
    io_sections_release(&runs);
    return status ? status : io_runs_index_tags(r->model, r->error);
}

/* ---- the format ---------------------------------------------------------------------------- */

static int read_text(ucd_reader *r) {
    if (take_counts(&r->cursor, r->count) < 0)
        return io_fail_at(r->model, r->cursor.at, r->error,
                          "a line of five counts expected (nodes, cells, data of nodes, cells and "
                          "the model)");
    int status = read_all_nodes(r);
    if (!status)
        status = read_all_cells(r);
    if (status)
        return status;
    io_skip_space_comments(&r->cursor, '#');
    const int has_data = r->count[2] > 0 || r->count[3] > 0 || r->count[4] > 0;
    if (!has_data && io_left(&r->cursor) > 0)
        return io_fail_at(r->model, r->cursor.at, r->error,
                          "more follows than the nodes and cells that the counts say");
    return PLANISH_OK;
}

static int ucd_read(io_model *model, planish_error *error) {
    model->node_order = node_orders;
    int64_t count[UCD_N_COUNTS];
    if (model->input.size > 0 && model->input.data[0] == 7) {
        const int status = ucd_binary_read(model, count, error);
        return status ? status : note_data(model, count, error);
    }
    ucd_reader r = {.model = model,
                    .error = error,
                    .cursor = io_begin_text(model->input.data, model->input.size)};
    io_text_init(&r.text, model);
    const int status = read_text(&r);
    io_text_release(&r.text);
    return status ? status : note_data(model, r.count, error);
}

/** Recognise the counts, the first node, and the first cell where it is among the bytes. Files that
 *  begin with four counts (TetGen's) need a cell. */
static int ucd_recognise(const char *data, int64_t size) {
    io_cursor cursor = io_begin_text(data, size);
    int64_t count[UCD_N_COUNTS], number;
    double value;
    if (ucd_binary_recognise(data, size))
        return 1;
    const int n_counts = take_counts(&cursor, count);
    if (n_counts < 0 || count[0] == 0)
        return 0;
    io_cursor line = io_take_line(&cursor);
    if (io_integer(&line, &number) || io_real(&line, &value) || io_real(&line, &value) ||
        io_real(&line, &value))
        return 0;
    io_skip_space(&line);
    if (line.at < line.end)
        return 0;
    for (int64_t i = 1; i < count[0] && cursor.at < cursor.end; i++)
        io_skip_line(&cursor);
    io_skip_space(&cursor);
    if (count[1] == 0 || cursor.at == cursor.end) /* only the beginning was looked at */
        return n_counts == UCD_N_COUNTS;
    line = io_take_line(&cursor);
    io_next_word(&line);
    io_next_word(&line);
    return find_type(io_next_word(&line)) >= 0;
}

static const char *const extensions[] = {".avs", ".ucd", ".inp", NULL};

const io_format io_format_ucd = {.name = "ucd",
                                 .extensions = extensions,
                                 .has_no_end = 1,
                                 .recognise = ucd_recognise,
                                 .read = ucd_read};
