/* unv_nodes: nodes of universal files, and coordinate systems.
 *
 * A node has a line of four numbers (its own, that of its coordinate system, two more) and three
 * coordinates: in the next line in fields of 25 columns (2411, 781), or behind them in fields of 13
 * (15). Programs that do not keep to the columns part coordinates by blanks. Where the columns hold,
 * a new number stays in its column, with a blank before it.
 */
#include "io/unv/unv_reader.h"

#include "io/core/bytes.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdlib.h>

enum {
    COLUMN = 25,
    LINE_COLUMN = 13,
    LINE_BEGIN = 40 /* of coordinates behind numbers */,
    N_NUMBERS = 4
};

/* ---- coordinate systems --------------------------------------------------------------------- */

static int compare_systems(const void *a, const void *b) {
    const int64_t p = ((const unv_system *)a)->number, q = ((const unv_system *)b)->number;
    return (p > q) - (p < q);
}

/** Return whether a matrix of four rows is that of the global system. *at: behind it. */
static int is_identity(io_cursor *at, int *is_whole) {
    int is = 1;
    *is_whole = 1;
    for (int i = 0; i < 12 && *is_whole; i++) {
        double value;
        *is_whole = io_real(at, &value) == 0;
        is &= *is_whole && value == (i % 4 == 0 && i < 9);
    }
    return is;
}

/** Read 2420: a number and a name of the part; of each system its number, its type and colour, its
 *  name, and a matrix. 18: numbers, a name, nine coordinates. */
int unv_read_systems(unv_reader *r, const io_section *s) {
    io_cursor cursor = {s->data, s->end};
    const int is_old = r->dataset->kind == UNV_OLD_SYSTEMS;
    if (!is_old) {
        io_skip_line(&cursor);
        io_skip_line(&cursor);
    }
    for (io_skip_space(&cursor); cursor.at < cursor.end; io_skip_space(&cursor)) {
        const char *at = cursor.at;
        int64_t number, type;
        int is_whole = 1, is_global = 0;
        if (io_integer(&cursor, &number) || io_integer(&cursor, &type))
            is_whole = 0;
        io_skip_line(&cursor);
        io_skip_line(&cursor); /* the name */
        if (is_whole && !is_old)
            is_global = is_identity(&cursor, &is_whole);
        for (int i = 0; is_old && is_whole && i < 9; i++) {
            double ignored;
            is_whole = io_real(&cursor, &ignored) == 0;
        }
        if (!is_whole)
            return io_fail_at(
                r->model, at, r->error,
                "dataset %d: a coordinate system expected (number, type, name and %s)",
                r->dataset->number, is_old ? "nine coordinates" : "a matrix");
        const unv_system system = {number, type != 0};
        if ((type != 0 || !is_global) &&
            !pl_append(&r->system, &r->n_systems, &r->system_capacity, &system, sizeof system))
            return pl_fail_memory(r->error, "coordinate systems");
    }
    if (r->n_systems > 1)
        qsort(r->system, (size_t)r->n_systems, sizeof *r->system, compare_systems);
    return PLANISH_OK;
}

/** Find a system that is another than the global one; NULL: it is that, or not defined. */
static const unv_system *find_system(const unv_reader *r, int64_t number) {
    const unv_system key = {number, 0};
    return r->n_systems > 0
               ? bsearch(&key, r->system, (size_t)r->n_systems, sizeof key, compare_systems)
               : NULL;
}

/* ---- places of coordinates ------------------------------------------------------------------ */

/** Places of three coordinates in a line. */
typedef struct places {
    io_slice number[3];
    int is_fixed;          /* each stands in its column: */
    const char *column[4]; /* where these begin and end, at most at the line's end */
} places;

/** Return text without white space around it: any, as between words. */
static io_slice trim(const char *begin, const char *end) {
    while (begin < end && io_is_space(*begin))
        begin++;
    while (begin < end && io_is_space(end[-1]))
        end--;
    return (io_slice){begin, end};
}

static int is_blank(const char *begin, const char *end) {
    return io_slice_length(trim(begin, end)) == 0;
}

/** Find the coordinates in a line, which begins at begin: columns of that width begin at column
 *  first, words in text. Return 0, or -1: there are no three. */
static int find_places(const char *begin, io_slice text, int64_t first, int64_t width,
                       places *found) {
    const int64_t length = text.end - begin;
    io_cursor line = {text.begin, text.end};
    for (int d = 0; d < 4; d++) {
        const int64_t at = first + d * width;
        found->column[d] = begin + (at < length ? at : length);
    }
    const int is_behind = text.begin <= found->column[0]; /* numbers before may be too long */
    found->is_fixed = is_behind;
    for (int d = 0; d < 3; d++) {
        found->number[d] = io_next_word(&line);
        if (found->number[d].begin < found->column[d] ||
            found->number[d].end > found->column[d + 1])
            found->is_fixed = 0;
    }
    const io_slice more = io_next_word(&line);
    if (io_slice_length(found->number[2]) > 0 && io_slice_length(more) == 0)
        return 0;
    /* Numbers that fill their columns have no blanks between. */
    found->is_fixed = 1;
    for (int d = 0; d < 3; d++)
        found->number[d] = trim(found->column[d], found->column[d + 1]);
    return is_behind && is_blank(text.begin, found->column[0]) &&
                   io_slice_length(found->number[2]) > 0 && is_blank(found->column[3], text.end)
               ? 0
               : -1;
}

/** Find the beginning of the line that at is in. */
static const char *line_begin(const io_model *model, const char *at) {
    while (at > model->input.data && at[-1] != '\n' && at[-1] != '\r')
        at--;
    return at;
}

/** Find the places of coordinates in the line that at is in. is_line: behind four numbers. */
static int find_in_line(const io_model *model, io_cursor at, int is_line, places *found) {
    const char *begin = line_begin(model, at.at);
    io_cursor rest = {begin, at.end};
    io_slice text = io_next_line(&rest);
    io_cursor words = {text.begin, text.end};
    for (int i = 0; is_line && i < N_NUMBERS; i++)
        io_next_word(&words);
    text.begin = words.at;
    return find_places(begin, text, is_line ? LINE_BEGIN : 0, is_line ? LINE_COLUMN : COLUMN,
                       found);
}

int unv_field(const io_model *model, io_cursor *cursor, int d, io_field *field) {
    const int is_line = model->precision == PLANISH_PRECISION_ROUNDED;
    const int width = (is_line ? LINE_COLUMN : COLUMN) - 1; /* a blank stands before */
    places found;
    *field = (io_field){.width = 0};
    if (find_in_line(model, *cursor, is_line, &found))
        return -1;
    const io_slice number = found.number[d];
    *field = (io_field){.begin = number.begin,
                        .end = number.end,
                        .width = is_line || found.is_fixed ? width : 0,
                        .is_fixed = found.is_fixed};
    if (found.is_fixed) {
        field->begin = found.column[d];
        field->begin += field->begin < number.begin;
        field->end = found.column[d + 1];
    }
    cursor->at = number.end;
    return io_slice_real(number, 1, &field->value);
}

/* ---- nodes ---------------------------------------------------------------------------------- */

/** Check that a node is in the global system, or that all are in one rectangular one. */
static int check_system(const unv_reader *r, int64_t node, int64_t system, const char *at,
                        planish_error *error) {
    const unv_system *s = find_system(r, system);
    if (s && s->is_curved)
        return io_fail_at(r->model, at, error,
                          "node %lld is in coordinate system %lld, which is cylindrical or "
                          "spherical; write the mesh in a cartesian one",
                          (long long)node, (long long)system);
    if (s != r->common)
        return io_fail_at(r->model, at, error,
                          "node %lld is in coordinate system %lld, others are in another one; "
                          "write all in one",
                          (long long)node, (long long)system);
    return PLANISH_OK;
}

/** Read the coordinates of a node from its line: words first, as they are most often apart. An
 *  exponent of three digits has no letter, as Fortran writes it. */
static int read_coordinates(const unv_reader *r, io_cursor line, int64_t i, planish_error *error) {
    io_model *model = r->model;
    double *xyz = model->xyz + 3 * i;
    io_cursor words = line;
    int d = 0;
    /* Where the first column may begin: the line, or behind the numbers. */
    const int is_line = r->dataset->kind == UNV_NODE_LINES;
    model->text_offset[i] = (is_line ? line.at : line_begin(model, line.at)) - model->input.data;
    while (d < 3 && io_real(&words, &xyz[d]) == 0)
        d++;
    io_skip_space(&words);
    if (d < 3 || words.at < words.end) {
        places found;
        if (find_in_line(model, line, is_line, &found))
            return io_fail_at(model, line.at, error, "node %lld: three coordinates expected",
                              (long long)model->node_number[i]);
        for (d = 0; d < 3; d++)
            if (io_slice_real(found.number[d], 1, &xyz[d]))
                return io_fail_at(model, found.number[d].begin, error,
                                  "node %lld: '%.*s' is not a coordinate",
                                  (long long)model->node_number[i], IO_QUOTED(found.number[d]));
    }
    for (d = 0; d < 3; d++) {
        const int status = io_check_finite(model, xyz[d], i, line.at, error);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

static int read_nodes(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                      planish_error *error) {
    const unv_reader *r = context;
    io_model *model = r->model;
    for (int64_t i = r->first + begin; i < r->first + end; i++) {
        int64_t number, value[N_NUMBERS];
        io_cursor line = io_take_line(cursor);
        const char *at = line.at;
        for (int k = 0; k < N_NUMBERS; k++)
            if (io_integer(&line, &value[k]))
                return io_fail_at(model, at, error,
                                  "a node's line of four whole numbers expected (its own, those of "
                                  "coordinate systems, a colour)");
        number = value[0];
        model->node_number[i] = number;
        int status = r->n_systems > 0 ? check_system(r, number, value[1], at, error) : PLANISH_OK;
        if (!status && r->dataset->kind == UNV_NODES)
            line = io_take_line(cursor);
        if (!status)
            status = read_coordinates(r, line, i, error);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

/** Note the system of the first node: all others must be in the same one. */
static void note_system(unv_reader *r, const io_section *s) {
    io_cursor line = {s->data, s->end};
    int64_t number, system;
    if (io_integer(&line, &number) == 0 && io_integer(&line, &system) == 0)
        r->common = find_system(r, system);
}

static int is_exponent(char c) {
    return c == 'D' || c == 'd' || c == 'E' || c == 'e';
}

/** Note the letter of exponents, if coordinates have one: datasets are written by Fortran's 1PD25.16
 *  or 1PE13.5, and numbers without an exponent mean others there. */
static void note_exponent(io_model *model, const io_section *s) {
    enum { MOST = 10000 }; /* bytes */
    const char *end = s->end - s->data > MOST ? s->data + MOST : s->end;
    const char *at = s->data;
    while (at < end && !is_exponent(*at))
        at++;
    if (at == end)
        return;
    model->exponent = IO_EXPONENT_ALWAYS;
    model->exponent_letter = *at;
}

/** Count the nodes of all datasets, which must have them in the same kind of lines. */
static int count_nodes(unv_reader *r, int64_t *n, unv_kind *kind) {
    *n = 0;
    for (int64_t i = 0; i < r->sections.n; i++) {
        const io_section *s = &r->sections.section[i];
        const unv_kind k = unv_datasets[s->keyword].kind;
        if (k != UNV_NODES && k != UNV_NODE_LINES)
            continue;
        if (*n > 0 && k != *kind)
            return io_fail_at(r->model, s->data, r->error,
                              "nodes of dataset 15 beside those of others are not read");
        if (k == UNV_NODES && s->count % 2)
            return io_fail_at(r->model, s->end, r->error,
                              "nodes of two lines each expected, there are %lld lines",
                              (long long)s->count);
        if (*n == 0 && s->count > 0) {
            note_system(r, s);
            note_exponent(r->model, s);
        }
        *kind = k;
        *n += s->count / (k == UNV_NODES ? 2 : 1);
    }
    return *n > 0 ? PLANISH_OK
                  : io_fail_at(r->model, io_input_end(r->model), r->error,
                               "there are no nodes (datasets 2411, 781, 15)");
}

int unv_read_nodes(unv_reader *r) {
    enum { WORDS = N_NUMBERS + 3 };
    io_model *model = r->model;
    int64_t n;
    unv_kind kind = UNV_NODES;
    int status = count_nodes(r, &n, &kind);
    if (!status)
        status = io_nodes_begin(model, n, (kind == UNV_NODES ? COLUMN : LINE_COLUMN) - 1, r->error);
    if (status)
        return status;
    model->n_nodes = n;
    if (kind == UNV_NODES) /* all digits of a double have room */
        model->precision = PLANISH_PRECISION_DOUBLE;
    for (int64_t i = 0; i < r->sections.n && !status; i++) {
        const io_section *s = &r->sections.section[i];
        io_cursor cursor = {s->data, io_input_end(model)};
        r->dataset = &unv_datasets[s->keyword];
        if (r->dataset->kind != kind)
            continue;
        const int64_t count = s->count / (kind == UNV_NODES ? 2 : 1);
        status = io_text_records(&r->text, &cursor, count, WORDS, read_nodes, r, r->error);
        if (!status && cursor.at != s->end && cursor.at < s->end)
            status = io_bytes_fail_changed(&model->input, r->error);
        r->first += count;
    }
    return status ? status : io_reduce_node_numbers(model, r->error);
}
