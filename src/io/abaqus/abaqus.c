/* abaqus: input files (.inp) of Abaqus, which CalculiX reads, too.
 *
 * One walk finds the blocks, that is keyword lines with their data lines; those of nodes are read
 * first, then those of elements, then sets (abaqus_sets.c). Keywords that say nothing of the mesh
 * are passed over; those that would make or move nodes, or bring in other files, are refused.
 *
 * A number has 20 characters at most, so that coordinates are rounded to that before they are
 * judged (hardly any is changed by it).
 */
#include "io/core/include.h"
#include "io/core/format.h"
#include "io/abaqus/abaqus_reader.h"
#include "io/abaqus/abaqus_write.h"

#include "io/core/bytes.h"
#include "io/core/elements.h"
#include "io/core/number.h"
#include "io/core/records.h"

#include "base/memory.h"
#include "base/status.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { FIELD_WIDTH = 20 };

/* ---- nodes -------------------------------------------------------------------------------- */

/** Find where the mesh is: outside of parts, or in the one part that has nodes. */
static int find_scope(abaqus_reader *r) {
    const abaqus_block *first = NULL;
    for (int64_t i = 0; i < r->n_blocks; i++) {
        const abaqus_block *b = &r->block[i];
        io_cursor cursor = b->data;
        io_slice found;
        if (b->keyword == ABAQUS_NODE && abaqus_parameter(b, "INPUT", &found))
            return abaqus_fail(r, b,
                               "INPUT=: the nodes are in another file; put that file's lines in "
                               "place of the parameter");
        const int has_data = abaqus_line(&cursor, &found);
        if (b->keyword != ABAQUS_NODE || b->scope == ABAQUS_IN_ASSEMBLY || !has_data)
            continue;
        if (first && first->scope != b->scope)
            return abaqus_fail(
                r, b,
                "several parts or instances have nodes; write each to a file of its own, or all "
                "of them without parts (Abaqus/CAE: Edit Attributes of the model, "
                "Do not use parts and assemblies in input files)");
        first = first ? first : b;
    }
    r->scope = first ? first->scope : 0;
    return PLANISH_OK;
}

static int take_number(const abaqus_reader *r, io_slice *line, const char *what, int64_t *number) {
    io_slice item = {line->end, line->end};
    abaqus_item(line, &item);
    if (io_slice_integer(item, number) || *number < 0 || *number > INT32_MAX)
        return abaqus_fail_item(r, item, what);
    return PLANISH_OK;
}

static int read_node_block(abaqus_reader *r, const abaqus_block *b) {
    io_model *model = r->model;
    io_cursor cursor = b->data;
    io_slice line, item, system = {NULL, NULL};
    if (abaqus_parameter(b, "SYSTEM", &system))
        system = abaqus_unquoted(system);
    if (io_slice_length(system) > 0 && io_upper(*system.begin) != 'R')
        return abaqus_fail(r, b,
                           "*NODE, SYSTEM=: cylindrical and spherical coordinates are not read; "
                           "write all nodes in rectangular ones");
    while (abaqus_line(&cursor, &line)) {
        int64_t number;
        int status = take_number(r, &line, "where the number of a node was expected", &number);
        if (!status)
            status = io_nodes_next(model, number, line.begin ? line.begin : line.end, r->error);
        for (int d = 0; d < 3 && !status && abaqus_item(&line, &item); d++)
            status = io_nodes_coordinate(model, d, item, r->error);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

/** Check that all nodes are in the input, which is the file that is written. */
static int check_files(const abaqus_reader *r) {
    const io_model *model = r->model;
    for (int64_t i = 0; i < r->n_blocks; i++) {
        const abaqus_block *b = &r->block[i];
        io_cursor cursor = b->data;
        io_slice line;
        if (b->keyword == ABAQUS_NODE && io_include_has(model, b->data.at) &&
            abaqus_line(&cursor, &line))
            return io_include_fail_node(model, line.begin, r->error);
    }
    return PLANISH_OK;
}

static int read_nodes(abaqus_reader *r) {
    io_model *model = r->model;
    io_slice line;
    int64_t n = 0;
    int status = check_files(r);
    if (status)
        return status;
    for (int64_t i = 0; i < r->n_blocks; i++) {
        io_cursor cursor = r->block[i].data;
        if (r->block[i].keyword == ABAQUS_NODE && r->block[i].scope == r->scope)
            while (abaqus_line(&cursor, &line))
                n++;
    }
    if (n == 0)
        return io_fail_at(model, io_input_end(model), r->error,
                          "there is no *NODE with nodes: this is not a mesh, or it is cut short");
    status = io_nodes_begin(model, n, FIELD_WIDTH, r->error);
    for (int64_t i = 0; i < r->n_blocks && !status; i++)
        if (r->block[i].keyword == ABAQUS_NODE && r->block[i].scope == r->scope)
            status = read_node_block(r, &r->block[i]);
    return status ? status : io_nodes_end(model, r->error);
}

/* ---- types of elements -------------------------------------------------------------------- */

/** Names of types begin with the prefix; the number of nodes follows. COH..., which most often have
 *  no thickness, are not among them: their nodes are held, but they are not measured. */
typedef struct family {
    const char *prefix;
    int dim;
} family;

enum { BEAM = -1, FACET = -2, FLUID = -3 }; /* the digits behind the prefix say something else */

static const family families[] = {
    {"C3D", 3},      {"AC3D", 3},      {"DC3D", 3},     {"DCC3D", 3},   {"EMC3D", 3},
    {"FC3D", 3},     {"Q3D", 3},       {"SC", 3},       {"CPS", 2},     {"CPE", 2},
    {"CPEG", 2},     {"CAX", 2},       {"CGAX", 2},     {"DCAX", 2},    {"ACAX", 2},
    {"DC2D", 2},     {"AC2D", 2},      {"EMC2D", 2},    {"M3D", 2},     {"SFM3D", 2},
    {"R3D", 2},      {"US", 2},        {"WARP2D", 2},   {"S", 2},       {"DS", 2},
    {"T2D", 1},      {"T3D", 1},       {"R2D", 1},      {"DC1D", 1},    {"AC1D", 1},
    {"RB2D", 1},     {"RB3D", 1},      {"B2", BEAM},    {"B3", BEAM},   {"PIPE2", BEAM},
    {"PIPE3", BEAM}, {"ELBOW3", BEAM}, {"STRI", FACET}, {"F3D", FLUID},
};

/** Shapes by dimension and number of nodes. */
static const struct {
    int dim;
    io_element_type type;
} shapes[] = {
    {1, {NULL, IO_LINE, 1, 2}},          {1, {NULL, IO_LINE, 2, 3}},
    {2, {NULL, IO_TRIANGLE, 1, 3}},      {2, {NULL, IO_QUADRILATERAL, 1, 4}},
    {2, {NULL, IO_TRIANGLE, 2, 6}},      {2, {NULL, IO_QUADRILATERAL, 2, 8}},
    {2, {NULL, IO_QUADRILATERAL, 2, 9}}, {3, {NULL, IO_TETRAHEDRON, 1, 4}},
    {3, {NULL, IO_PYRAMID, 1, 5}},       {3, {NULL, IO_PRISM, 1, 6}},
    {3, {NULL, IO_HEXAHEDRON, 1, 8}},    {3, {NULL, IO_TETRAHEDRON, 2, 10}},
    {3, {NULL, IO_PYRAMID, 2, 13}},      {3, {NULL, IO_PRISM, 2, 15}},
    {3, {NULL, IO_PRISM, 2, 18}},        {3, {NULL, IO_HEXAHEDRON, 2, 20}},
    {3, {NULL, IO_HEXAHEDRON, 2, 27}},
};

static int is_digit(char c) {
    return c >= '0' && c <= '9';
}

/** Find the type of a name in capitals; nodes is 0 where an element has as many as there are. */
static io_element_type find_type(const char *name, int has_cavities) {
    const char *digits = NULL;
    int dim = 0;
    for (size_t i = 0; i < sizeof families / sizeof *families && !digits; i++) {
        const size_t length = strlen(families[i].prefix);
        if (strncmp(name, families[i].prefix, length) != 0 || !is_digit(name[length]))
            continue;
        digits = name + length;
        dim = families[i].dim;
    }
    if (!digits)
        return (io_element_type){.shape = IO_ANY_SHAPE, .nodes = 0};
    int nodes = digits[0] - '0';
    switch (dim) {
    case BEAM: /* B31 and the like are lines of two nodes; B32 has three */
        dim = 1;
        nodes = nodes == 2 ? 3 : 2;
        break;
    case FACET: /* STRI3 and STRI35 have three nodes, STRI65 has six: then degrees of freedom */
        dim = 2;
        nodes = nodes == 6 ? 6 : 3;
        break;
    case FLUID: /* CalculiX' F3D4, F3D6, F3D8 are solids; Abaqus' F3D3, F3D4 facets of a cavity */
        dim = nodes == 3 || (nodes == 4 && has_cavities) ? 2 : 3;
        break;
    default:
        nodes = is_digit(digits[1]) ? 10 * nodes + digits[1] - '0' : nodes;
    }
    if (nodes == 15 && digits[2] == 'V') /* C3D15V: with nodes of faces */
        nodes = 18;
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++)
        if (shapes[i].dim == dim && shapes[i].type.nodes == nodes)
            return shapes[i].type;
    return (io_element_type){.shape = IO_ANY_SHAPE, .nodes = (uint16_t)nodes};
}

/* ---- elements ----------------------------------------------------------------------------- */

/** Take the next item of an element, from the next line if this one ends. */
static int element_item(io_cursor *cursor, io_slice *line, io_slice *item) {
    while (!abaqus_item(line, item) || (io_slice_length(*item) == 0 && !line->begin))
        if (!abaqus_line(cursor, line))
            return 0;
    return 1;
}

/** Return the squared distance of node m from the middle between nodes a and b. */
static double off_middle(const io_model *model, int32_t m, int32_t a, int32_t b) {
    double sum = 0;
    for (int64_t d = 0; d < 3; d++) {
        const double *x = model->xyz + d;
        const double off = x[3 * (int64_t)m] - (x[3 * (int64_t)a] + x[3 * (int64_t)b]) / 2;
        sum += off * off;
    }
    return sum;
}

/** Put the mid of a line, which programs write second or third, behind its ends. */
static void order_line(const io_model *model, int32_t nodes[3]) {
    const int32_t second = nodes[1];
    if (off_middle(model, second, nodes[0], nodes[2]) <
        off_middle(model, nodes[2], nodes[0], second)) {
        nodes[1] = nodes[2];
        nodes[2] = second;
    }
}

/** Read a simplex of a type that is kept. */
static int read_cell(abaqus_reader *r, io_cursor *cursor, io_slice line,
                     const io_element_type *type) {
    enum { LINE_NODES = 3, MOST_NODES = 10 };
    int32_t nodes[MOST_NODES];
    int64_t number, label;
    const int dim = io_element_dim(type), n = type->nodes;
    const int status = take_number(r, &line, "where the number of an element was expected", &label);
    if (status)
        return status;
    for (int i = 0; i < n; i++) {
        io_slice item = {line.end, line.end};
        if (!element_item(cursor, &line, &item) || io_slice_integer(item, &number))
            return abaqus_fail_item(r, item, "where the number of a node was expected");
        nodes[i] = (int32_t)io_node_index(r->model, number);
        if (nodes[i] < 0)
            return io_fail_no_node(r->model, item.begin, "element", label, number, r->error);
    }
    io_slice more;
    while (dim > 1 && abaqus_item(&line, &more))
        if (io_slice_length(more) > 0)
            return io_fail_at(r->model, more.begin, r->error,
                              "element %lld has more than the %d nodes of its type",
                              (long long)label, n);
    if (dim == 1 && n == LINE_NODES)
        order_line(r->model, nodes);
    return io_model_add_simplex(r->model, io_simplex_type(dim, n > dim + 1), nodes, 0, label,
                                r->error);
}

/** Read an element that is not kept: add it to the others where it has a planish_cell_type, cell_type,
 *  else hold its nodes. An element of type->nodes 0 has as many as there are; it goes on in
 *  the next line where one ends in a comma. So do nodes of faces, which may be left out. */
static int read_other(abaqus_reader *r, const abaqus_block *b, io_cursor *cursor, io_slice line,
                      const io_element_type *type, int cell_type) {
    const int n_given = io_cell_type_nodes(io_cell_type_without_faces(cell_type));
    int32_t nodes[IO_CELL_NODES] = {0};
    io_slice item = {line.end, line.end};
    int64_t number, label = 0;
    if (cell_type) {
        const int status =
            take_number(r, &line, "where the number of an element was expected", &label);
        if (status)
            return status;
    } else {
        abaqus_item(&line, &item); /* its own number */
    }
    for (int i = 0; type->nodes == 0 || i < type->nodes; i++) {
        const int is_last = !line.begin && (type->nodes == 0 || (cell_type && i >= n_given));
        const int is_there = !is_last && element_item(cursor, &line, &item);
        int64_t index = -1;
        number = 0;
        if (!is_there && !cell_type)
            break;
        if (!is_there)
            item = (io_slice){line.end, line.end};
        const int is_number =
            is_there && abaqus_local(r, b, &item) && !io_slice_integer(item, &number);
        const int is_missing = (is_number && number == 0) || io_slice_length(item) == 0;
        if (is_number)
            index = io_node_index(r->model, number);
        if (cell_type && index < 0 && !(is_missing && i >= n_given)) {
            if (is_number)
                return io_fail_no_node(r->model, item.begin, "element", label, number, r->error);
            return abaqus_fail_item(r, item, "where the number of a node was expected");
        }
        if (index >= 0 && !cell_type)
            io_hold_node(r->model, index, IO_HELD_BY_OTHER);
        if (cell_type)
            nodes[i] = (int32_t)index;
    }
    while (cell_type && abaqus_item(&line, &item))
        if (io_slice_length(item) > 0)
            return io_fail_at(r->model, item.begin, r->error,
                              "element %lld has more than the %d nodes of its type",
                              (long long)label, type->nodes);
    r->model->n_other++;
    for (int i = n_given; cell_type && i < type->nodes; i++)
        if (nodes[i] < 0)
            cell_type = io_cell_type_without_faces(cell_type);
    return io_model_add_other(r->model, cell_type, nodes, 0, label, r->error);
}

/** Note the name of a type that is read. */
static int note_type(const abaqus_reader *r, const char *name, const io_element_type *type) {
    io_model *model = r->model;
    io_type_name made = {.type = type->shape == IO_LINE ? io_simplex_type(1, type->nodes > 2)
                                                        : io_cell_type(type->shape, type->nodes)};
    int is_there =
        made.type == 0 || model->n_type_names == IO_MOST_NAMES; /* the search is linear */
    for (int64_t i = 0; i < model->n_type_names && !is_there; i++)
        is_there = strcmp(model->type_name[i].name, name) == 0;
    snprintf(made.name, sizeof made.name, "%s", name);
    return is_there || pl_append(&model->type_name, &model->n_type_names,
                                 &model->type_name_capacity, &made, sizeof made)
               ? PLANISH_OK
               : pl_fail_memory(r->error, "the types of elements");
}

static int read_element_block(abaqus_reader *r, const abaqus_block *b) {
    io_cursor cursor = b->data;
    io_slice line, item = {NULL, NULL};
    char name[ABAQUS_NAME_SIZE];
    if (!abaqus_parameter(b, "TYPE", &item) || io_slice_length(item) == 0)
        return abaqus_fail(r, b, "*ELEMENT without TYPE=");
    abaqus_squeeze(abaqus_unquoted(item), name);
    const io_element_type type = find_type(name, r->has_cavities);
    const int is_here = b->scope == r->scope;
    if (note_type(r, name, &type))
        return PLANISH_ERROR_MEMORY;
    const io_cells *cells = is_here ? io_element_cells(r->model, &type) : NULL;
    const int cell_type = is_here ? io_cell_type(type.shape, type.nodes) : 0;
    const int dim = io_element_dim(&type);
    abaqus_range range = {.list = cells ? dim : cell_type ? io_others_list(dim) : 0};
    range.begin = range.list ? io_model_list(r->model, range.list).n : 0;
    while (abaqus_line(&cursor, &line)) {
        const int status = cells ? read_cell(r, &cursor, line, &type)
                                 : read_other(r, b, &cursor, line, &type, cell_type);
        if (status)
            return status;
    }
    if (!is_here)
        return PLANISH_OK;
    range.end = range.list ? io_model_list(r->model, range.list).n : 0;
    abaqus_parameter(b, "ELSET", &range.set); /* which has a name, even if no cell is kept */
    return pl_append(&r->range, &r->n_ranges, &r->range_capacity, &range, sizeof range)
               ? PLANISH_OK
               : pl_fail_memory(r->error, "the blocks of elements");
}

/* ---- the file ----------------------------------------------------------------------------- */

static int abaqus_read(io_model *model, planish_error *error) {
    abaqus_reader r = {.model = model, .error = error};
    model->node_order = abaqus_node_orders;
    int status = abaqus_find_blocks(&r);
    if (!status)
        status = find_scope(&r);
    if (!status)
        status = read_nodes(&r);
    for (int64_t i = 0; i < r.n_blocks && !status; i++)
        if (r.block[i].keyword == ABAQUS_ELEMENT &&
            (r.block[i].scope == r.scope || r.block[i].scope == ABAQUS_IN_ASSEMBLY))
            status = read_element_block(&r, &r.block[i]);
    if (!status)
        status = abaqus_read_sets(&r);
    if (!status)
        status = abaqus_make_groups(&r);
    for (int dim = 1; dim <= 3; dim++)
        io_reduce_cell_numbers(io_model_cells(model, dim));
    for (int64_t i = 0; i < r.n_sets; i++)
        pl_free(r.set[i].member);
    for (int i = 0; i < 2; i++) {
        pl_free(r.slot[i]);
        pl_free(r.stamp[i]);
    }
    pl_free(r.set);
    pl_free(r.block);
    pl_free(r.range);
    io_numbers_destroy(r.elements);
    io_include_close(model);
    return status;
}

/** Recognise a file by its first keyword: few other files begin with one of these. */
static int abaqus_recognise(const char *data, int64_t size) {
    static const char *const first[] = {"HEADING", "PREPRINT", "PART",
                                        "NODE",    "ELEMENT",  "INCLUDE"};
    io_cursor cursor = io_begin_text(data, size);
    io_slice line, item;
    char name[ABAQUS_NAME_SIZE];
    if (!abaqus_line(&cursor, &line) || *line.begin != '*')
        return 0;
    line.begin++;
    abaqus_item(&line, &item);
    abaqus_squeeze(item, name);
    for (size_t i = 0; i < sizeof first / sizeof *first; i++)
        if (strcmp(name, first[i]) == 0)
            return 1;
    return 0;
}

/* ---- writing ------------------------------------------------------------------------------ */

static int abaqus_field(const io_model *model, io_cursor *cursor, int d, io_field *field) {
    io_cursor from = *cursor;
    io_slice rest = io_next_line(&from);
    /* The comma before the coordinate; behind the one before the first there may be blanks. */
    const char *comma = d == 0 ? rest.begin - 1 : rest.begin;
    while (d == 0 && comma > model->input.data && io_is_blank(*comma))
        comma--;
    *field = (io_field){.width = FIELD_WIDTH};
    if (comma == rest.end || *comma != ',') { /* the line ends before */
        field->begin = field->end = cursor->at = rest.end;
        field->lead = ", ";
        field->n_lead = 2;
        return 0;
    }
    rest.begin += d > 0;
    comma = memchr(rest.begin, ',', (size_t)io_slice_length(rest));
    const io_slice item = io_slice_trim((io_slice){rest.begin, comma ? comma : rest.end});
    field->begin = item.begin;
    field->end = item.end;
    cursor->at = comma ? comma : rest.end;
    return io_slice_length(item) == 0 ? 0 : io_slice_real(item, 0, &field->value);
}

static const char *const extensions[] = {".inp", NULL};

const io_format io_format_abaqus = {.name = "abaqus",
                                    .extensions = extensions,
                                    .has_no_end = 1,
                                    .recognise = abaqus_recognise,
                                    .read = abaqus_read,
                                    .field = abaqus_field,
                                    .targets = abaqus_targets};
