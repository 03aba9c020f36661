/* abaqus: input files (.inp) of Abaqus, which CalculiX reads, too.
 *
 * One walk finds the blocks, that is keyword lines with their data lines; those of nodes are read
 * first, then those of elements, then sets (abaqus_sets.c). Keywords that say nothing of the mesh
 * are passed over; those that would make or move nodes, or bring in other files, are refused.
 *
 * A number has 20 characters at most, so that coordinates are rounded to that before they are
 * judged (hardly any is changed by it).
 */
#include "io/core/format.h"
#include "io/abaqus/abaqus.h"

#include "io/core/bytes.h"
#include "io/core/number.h"
#include "io/core/records.h"

#include "base/memory.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

enum { FIELD_WIDTH = 20 };

/* ---- nodes -------------------------------------------------------------------------------- */

static int has_data(const abaqus_block *b) {
    io_cursor cursor = {b->data.begin, b->data.end};
    abaqus_span line;
    return abaqus_line(&cursor, &line);
}

/** Where the mesh is: outside of parts, or in the one part that has nodes. */
static int find_scope(abaqus_reader *r) {
    const abaqus_block *first = NULL;
    for (int64_t i = 0; i < r->n_blocks; i++) {
        const abaqus_block *b = &r->block[i];
        int status = abaqus_check_input(r, b);
        if (status)
            return status;
        if (b->keyword != ABAQUS_NODE || b->scope == ABAQUS_IN_ASSEMBLY || !has_data(b))
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

static int check_system(const abaqus_reader *r, const abaqus_block *b) {
    abaqus_span system;
    if (!abaqus_parameter(b, "SYSTEM", &system))
        return PLANISH_OK;
    system = abaqus_unquoted(system);
    if (abaqus_length(system) == 0 || io_upper(*system.begin) == 'R')
        return PLANISH_OK;
    return abaqus_fail(r, b,
                       "*NODE, SYSTEM=: cylindrical and spherical coordinates are not read; write "
                       "all nodes in rectangular ones");
}

static int is_node_block(const abaqus_reader *r, const abaqus_block *b) {
    return b->keyword == ABAQUS_NODE && b->scope == r->scope;
}

static int64_t count_lines(const abaqus_block *b) {
    io_cursor cursor = {b->data.begin, b->data.end};
    abaqus_span line;
    int64_t n = 0;
    while (abaqus_line(&cursor, &line))
        n++;
    return n;
}

static int fail_item(const abaqus_reader *r, abaqus_span item, const char *expected) {
    const int64_t length = abaqus_length(item);
    return io_fail_at(r->model, item.begin, r->error, "'%.*s' where %s was expected",
                      (int)(length < 24 ? length : 24), item.begin, expected);
}

static int take_number(const abaqus_reader *r, abaqus_span *line, const char *what,
                       int64_t *number) {
    abaqus_span item = {line->end, line->end};
    abaqus_item(line, &item);
    if (abaqus_integer(item, number) || *number < 0 || *number > INT32_MAX)
        return fail_item(r, item, what);
    return PLANISH_OK;
}

static int read_node(abaqus_reader *r, abaqus_span line) {
    io_model *model = r->model;
    const int64_t node = model->n_nodes;
    if (node == r->n_counted)
        return io_bytes_fail_changed(&model->input, r->error);
    int status = take_number(r, &line, "the number of a node", &model->node_number[node]);
    if (status)
        return status;
    model->text_offset[node] = (line.begin ? line.begin : line.end) - model->input.data;
    for (int d = 0; d < 3; d++) {
        abaqus_span item = {NULL, NULL};
        double *value = &model->xyz[3 * node + d];
        *value = 0;
        if (!abaqus_item(&line, &item) || abaqus_length(item) == 0)
            continue;
        const char *at = item.begin;
        if (io_parse_real(&at, item.end, value) || at != item.end || !isfinite(*value))
            return fail_item(r, item, "a coordinate (a finite real number)");
    }
    model->n_nodes++;
    return PLANISH_OK;
}

static int read_node_block(abaqus_reader *r, const abaqus_block *b) {
    io_cursor cursor = {b->data.begin, b->data.end};
    abaqus_span line;
    int status = check_system(r, b);
    while (!status && abaqus_line(&cursor, &line))
        status = read_node(r, line);
    return status;
}

static int read_nodes(abaqus_reader *r) {
    io_model *model = r->model;
    int64_t n = 0;
    for (int64_t i = 0; i < r->n_blocks; i++)
        n += is_node_block(r, &r->block[i]) ? count_lines(&r->block[i]) : 0;
    if (n == 0)
        return io_fail_at(model, model->input.data + model->input.size, r->error,
                          "there is no *NODE with nodes: this is no mesh, or it is cut short");
    int status = io_model_nodes(model, n, 1, r->error);
    if (status)
        return status;
    model->columns = 3;
    model->precision = PLANISH_ROUNDED;
    model->field_width = FIELD_WIDTH;
    model->node_number = pl_alloc(n, sizeof *model->node_number);
    if (!model->node_number)
        return pl_fail_memory(r->error, "the numbers of nodes");
    status = io_model_span(model, (io_span){.n_nodes = n, .encoding = IO_TEXT}, r->error);
    model->n_nodes = 0;
    r->n_counted = n;
    for (int64_t i = 0; i < r->n_blocks && !status; i++)
        if (is_node_block(r, &r->block[i]))
            status = read_node_block(r, &r->block[i]);
    if (!status && model->n_nodes != n)
        status = io_bytes_fail_changed(&model->input, r->error);
    return status ? status : io_settle_node_numbers(r->model, &r->numbers, r->error);
}

/* ---- types of elements -------------------------------------------------------------------- */

/** Names of types begin so, and go on with the number of nodes. */
typedef struct family {
    const char *prefix;
    int dim;
} family;

static const family families[] = {
    {"C3D", 3},   {"AC3D", 3}, {"DC3D", 3},   {"DCC3D", 3}, {"EMC3D", 3}, {"FC3D", 3}, {"Q3D", 3},
    {"COH3D", 3}, {"SC", 3},   {"CPS", 2},    {"CPE", 2},   {"CPEG", 2},  {"CAX", 2},  {"CGAX", 2},
    {"DCAX", 2},  {"ACAX", 2}, {"DC2D", 2},   {"AC2D", 2},  {"EMC2D", 2}, {"M3D", 2},  {"SFM3D", 2},
    {"R3D", 2},   {"US", 2},   {"WARP2D", 2}, {"S", 2},     {"DS", 2},    {"T2D", 1},  {"T3D", 1},
    {"R2D", 1},   {"DC1D", 1}, {"AC1D", 1},   {"RB2D", 1},  {"RB3D", 1},
};

/** B31 and the like: lines of two nodes; B32 has three. */
static const char *const beams[] = {"B2", "B3", "PIPE2", "PIPE3", "ELBOW3"};

typedef struct shape {
    int nodes; /* 0: as many as there are */
    int dim;   /* of a cell that is kept, or 0 */
    int is_second_order;
} shape;

static int is_digit(char c) {
    return c >= '0' && c <= '9';
}

/** Whether a digit follows the prefix. */
static int begins_with_digit(const char *type, const char *prefix) {
    const size_t length = strlen(prefix);
    return strncmp(type, prefix, length) == 0 && is_digit(type[length]);
}

static shape shape_of_beam(const char *type) {
    for (size_t i = 0; i < sizeof beams / sizeof *beams; i++) {
        const size_t length = strlen(beams[i]);
        if (begins_with_digit(type, beams[i]))
            return type[length] == '2' ? (shape){3, 0, 0} : (shape){2, 1, 0};
    }
    return (shape){0, 0, 0};
}

/** STRI3 and STRI35 have three nodes, STRI65 has six: what follows is degrees of freedom. */
static shape shape_of_facet(const char *type) {
    return type[4] == '6' ? (shape){6, 2, 1} : (shape){3, 2, 0};
}

/** CalculiX' F3D4, F3D6 and F3D8 are a tetrahedron, a prism and a hexahedron of fluid. Abaqus' F3D3
 *  and F3D4 are facets of a cavity. */
static shape shape_of_fluid(const char *type, int has_cavities) {
    const int nodes = type[3] - '0';
    if (nodes == 3)
        return (shape){3, 2, 0};
    return (shape){nodes, nodes == 4 && !has_cavities ? 3 : 0, 0};
}

static shape shape_of(const char *type, int has_cavities) {
    if (begins_with_digit(type, "STRI"))
        return shape_of_facet(type);
    if (begins_with_digit(type, "F3D"))
        return shape_of_fluid(type, has_cavities);
    for (size_t i = 0; i < sizeof families / sizeof *families; i++) {
        const size_t length = strlen(families[i].prefix);
        const int dim = families[i].dim;
        if (!begins_with_digit(type, families[i].prefix))
            continue;
        int nodes = type[length] - '0';
        if (is_digit(type[length + 1]))
            nodes = 10 * nodes + type[length + 1] - '0';
        const int is_simplex = nodes == dim + 1;
        const int is_second_order = dim == 3 ? nodes == 10 : dim == 2 && nodes == 6;
        return (shape){nodes, is_simplex ? dim : 0, is_second_order};
    }
    return shape_of_beam(type);
}

/* ---- elements ----------------------------------------------------------------------------- */

/** The last point between INSTANCE and NAME, or NULL: none that is in quotes or behind nothing but
 *  digits, as in a real number. */
static const char *find_point(abaqus_span item) {
    const char *point = NULL;
    int is_quoted = 0, is_number = 0;
    for (const char *c = item.begin; c < item.end; c++) {
        is_quoted ^= *c == '"';
        if (*c == '.' && !is_quoted && !is_number)
            point = c;
        const int begins = c == item.begin || c[-1] == '.';
        is_number = is_digit(*c) && (is_number || begins);
    }
    return point;
}

int abaqus_local(const abaqus_reader *r, const abaqus_block *b, abaqus_span *item) {
    if (b->scope == r->scope)
        return 1;
    const char *dot = find_point(*item);
    if (dot)
        item->begin = dot + 1;
    return dot != NULL || b->has_instance;
}

/** The next item of an element, from the next line if this one ends. */
static int element_item(io_cursor *cursor, abaqus_span *line, abaqus_span *item) {
    while (!abaqus_item(line, item) || (abaqus_length(*item) == 0 && !line->begin))
        if (!abaqus_line(cursor, line))
            return 0;
    return 1;
}

/** An element of n nodes; cells: where it is kept. */
static int read_cell(abaqus_reader *r, io_cursor *cursor, abaqus_span line, int dim) {
    io_cells *cells = io_model_cells(r->model, dim);
    int status = io_cells_reserve(cells, dim, 1, 1, 1, r->error);
    if (status)
        return status;
    int32_t *nodes = cells->nodes + cells->n * (dim + 1);
    int64_t number, label;
    status = take_number(r, &line, "the number of an element", &label);
    if (status)
        return status;
    for (int i = 0; i <= dim; i++) {
        abaqus_span item = {line.end, line.end};
        if (!element_item(cursor, &line, &item) || abaqus_integer(item, &number))
            return fail_item(r, item, "the number of a node");
        const int64_t index = io_node_index(r->model, r->numbers, number);
        if (index < 0)
            return io_fail_at(r->model, item.begin, r->error, "element %lld: there is no node %lld",
                              (long long)label, (long long)number);
        nodes[i] = (int32_t)index;
    }
    abaqus_span more;
    while (dim > 1 && abaqus_item(&line, &more))
        if (abaqus_length(more) > 0)
            return io_fail_at(r->model, more.begin, r->error,
                              "element %lld has more than the %d nodes of its type",
                              (long long)label, dim + 1);
    cells->number[cells->n] = label;
    cells->entity[cells->n++] = 0;
    return PLANISH_OK;
}

/** An element that is not kept holds its nodes. nodes: 0, as many as there are: the element goes on
 *  in the next line where one ends in a comma. */
static void hold_element(abaqus_reader *r, const abaqus_block *b, io_cursor *cursor,
                         abaqus_span line, int nodes) {
    abaqus_span item;
    int64_t number;
    abaqus_item(&line, &item); /* its own number */
    for (int i = 0; nodes == 0 || i < nodes; i++) {
        if ((nodes == 0 && !line.begin) || !element_item(cursor, &line, &item))
            break;
        if (!abaqus_local(r, b, &item) || abaqus_integer(item, &number))
            continue;
        const int64_t index = io_node_index(r->model, r->numbers, number);
        if (index >= 0)
            io_hold_node(r->model, index, IO_HELD_BY_OTHER);
    }
    r->model->n_other++;
}

/** dim: 0, the block has no cells that are kept, but its set has a name. */
static int add_range(abaqus_reader *r, const abaqus_block *b, int dim, int64_t begin) {
    const int64_t end = dim ? io_model_cells(r->model, dim)->n : begin;
    abaqus_range range = {dim, begin, end, {NULL, NULL}};
    abaqus_parameter(b, "ELSET", &range.set);
    abaqus_range *grown =
        pl_grow(r->range, r->n_ranges, r->n_ranges + 1, &r->range_capacity, sizeof *grown);
    if (!grown)
        return pl_fail_memory(r->error, "the blocks of elements");
    r->range = grown;
    r->range[r->n_ranges++] = range;
    return PLANISH_OK;
}

static int read_element_block(abaqus_reader *r, const abaqus_block *b) {
    io_cursor cursor = {b->data.begin, b->data.end};
    abaqus_span line, type_item = {NULL, NULL};
    char type[ABAQUS_NAME_SIZE];
    int status = PLANISH_OK;
    if (!abaqus_parameter(b, "TYPE", &type_item) || abaqus_length(type_item) == 0)
        return abaqus_fail(r, b, "*ELEMENT without TYPE=");
    abaqus_squeeze(abaqus_unquoted(type_item), type);
    const shape kind = shape_of(type, r->has_cavities);
    const int is_here = b->scope == r->scope;
    if (kind.is_second_order)
        return io_fail_at(r->model, b->parameters.begin, r->error,
                          "elements of second order (%s) cannot be smoothed; export the mesh "
                          "with straight elements of first order",
                          type);
    const int64_t first = kind.dim ? io_model_cells(r->model, kind.dim)->n : 0;
    while (!status && abaqus_line(&cursor, &line)) {
        if (kind.dim && is_here)
            status = read_cell(r, &cursor, line, kind.dim);
        else
            hold_element(r, b, &cursor, line, kind.nodes);
    }
    return status || !is_here ? status : add_range(r, b, kind.dim, first);
}

static int read_elements(abaqus_reader *r) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < r->n_blocks && !status; i++)
        if (r->block[i].keyword == ABAQUS_ELEMENT &&
            (r->block[i].scope == r->scope || r->block[i].scope == ABAQUS_IN_ASSEMBLY))
            status = read_element_block(r, &r->block[i]);
    return status;
}

/* ---- the file ----------------------------------------------------------------------------- */

static int read_all(abaqus_reader *r) {
    int status = abaqus_find_blocks(r);
    if (!status)
        status = find_scope(r);
    if (!status)
        status = read_nodes(r);
    if (!status)
        status = read_elements(r);
    if (!status)
        status = abaqus_read_sets(r);
    for (int dim = 1; dim <= 3; dim++)
        io_settle_cell_numbers(io_model_cells(r->model, dim));
    return status;
}

static int read_abaqus(io_model *model, planish_error *error) {
    abaqus_reader r = {.model = model, .error = error};
    const int status = read_all(&r);
    io_numbers_destroy(r.numbers);
    pl_free(r.block);
    pl_free(r.range);
    return status;
}

/** The first keyword is one that such files begin with, and few others do. */
static int recognise(const char *data, int64_t size) {
    static const char *const first[] = {"HEADING", "PREPRINT", "PART", "NODE", "ELEMENT"};
    io_cursor cursor = io_begin_text(data, size);
    abaqus_span line, item;
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

/** Whether a comma is before at, with nothing but blanks between. */
static int follows_comma(const char *data, const char *at) {
    while (at > data && (at[-1] == ' ' || at[-1] == '\t'))
        at--;
    return at > data && at[-1] == ',';
}

static int abaqus_field(const io_model *model, io_cursor *cursor, int d, io_field *field) {
    io_cursor from = *cursor;
    abaqus_span rest, item;
    rest.begin = io_line(&from, &rest.end);
    *field = (io_field){.width = FIELD_WIDTH};
    const int is_there = d == 0 ? follows_comma(model->input.data, rest.begin)
                                : rest.begin < rest.end && *rest.begin == ',';
    if (!is_there) { /* the line ends before */
        field->begin = field->end = cursor->at = rest.end;
        field->lead = ", ";
        field->n_lead = 2;
        return 0;
    }
    rest.begin += d > 0;
    const char *comma = memchr(rest.begin, ',', (size_t)abaqus_length(rest));
    item = abaqus_trim((abaqus_span){rest.begin, comma ? comma : rest.end});
    field->begin = item.begin;
    field->end = item.end;
    cursor->at = comma ? comma : rest.end;
    const char *at = item.begin;
    return abaqus_length(item) == 0 ? 0 : io_parse_real(&at, item.end, &field->value);
}

static const char *const extensions[] = {".inp", NULL};

const io_format io_format_abaqus = {.name = "abaqus",
                                    .extensions = extensions,
                                    .has_no_end = 1,
                                    .recognise = recognise,
                                    .read = read_abaqus,
                                    .field = abaqus_field};
