/* gmsh: MSH files of Gmsh, versions 1, 2 and 4, ASCII and binary.
 *
 * Recognises the format, reads the header and walks the sections; names of groups are read by
 * gmsh_names.c, nodes, elements, entities and periodic pairs by gmsh2.c and gmsh4.c, and values of
 * elements that may tell regions by gmsh_data.c. Sections that say nothing about the mesh itself
 * ($Comments, $NodeData, $GhostElements, unknown ones) are passed over.
 */
#include "io/core/format.h"
#include "io/gmsh/gmsh.h"

#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/memory.h"
#include "base/status.h"
#include "io/core/binary.h"

/* ---- element types ------------------------------------------------------------------------ */

/* By Gmsh's number of the type: dimension, whether triangle or tetrahedron, nodes. */
static const gmsh_type types[] = {
    [1] = {1, 0, 2},     [2] = {2, 1, 3},     [3] = {2, 0, 4},     [4] = {3, 1, 4},
    [5] = {3, 0, 8},     [6] = {3, 0, 6},     [7] = {3, 0, 5},     [8] = {1, 0, 3},
    [9] = {2, 1, 6},     [10] = {2, 0, 9},    [11] = {3, 1, 10},   [12] = {3, 0, 27},
    [13] = {3, 0, 18},   [14] = {3, 0, 14},   [15] = {0, 0, 1},    [16] = {2, 0, 8},
    [17] = {3, 0, 20},   [18] = {3, 0, 15},   [19] = {3, 0, 13},   [20] = {2, 1, 9},
    [21] = {2, 1, 10},   [22] = {2, 1, 12},   [23] = {2, 1, 15},   [24] = {2, 1, 15},
    [25] = {2, 1, 21},   [26] = {1, 0, 4},    [27] = {1, 0, 5},    [28] = {1, 0, 6},
    [29] = {3, 1, 20},   [30] = {3, 1, 35},   [31] = {3, 1, 56},   [32] = {3, 1, 22},
    [33] = {3, 1, 28},   [36] = {2, 0, 16},   [37] = {2, 0, 25},   [38] = {2, 0, 36},
    [39] = {2, 0, 12},   [40] = {2, 0, 16},   [41] = {2, 0, 20},   [42] = {2, 1, 28},
    [43] = {2, 1, 36},   [44] = {2, 1, 45},   [45] = {2, 1, 55},   [46] = {2, 1, 66},
    [47] = {2, 0, 49},   [48] = {2, 0, 64},   [49] = {2, 0, 81},   [50] = {2, 0, 100},
    [51] = {2, 0, 121},  [52] = {2, 1, 18},   [53] = {2, 1, 21},   [54] = {2, 1, 24},
    [55] = {2, 1, 27},   [56] = {2, 1, 30},   [57] = {2, 0, 24},   [58] = {2, 0, 28},
    [59] = {2, 0, 32},   [60] = {2, 0, 36},   [61] = {2, 0, 40},   [62] = {1, 0, 7},
    [63] = {1, 0, 8},    [64] = {1, 0, 9},    [65] = {1, 0, 10},   [66] = {1, 0, 11},
    [71] = {3, 1, 84},   [72] = {3, 1, 120},  [73] = {3, 1, 165},  [74] = {3, 1, 220},
    [75] = {3, 1, 286},  [79] = {3, 1, 34},   [80] = {3, 1, 40},   [81] = {3, 1, 46},
    [82] = {3, 1, 52},   [83] = {3, 1, 58},   [84] = {1, 0, 1},    [85] = {2, 0, 1},
    [86] = {2, 0, 1},    [87] = {3, 0, 1},    [88] = {3, 0, 1},    [89] = {3, 0, 1},
    [90] = {3, 0, 40},   [91] = {3, 0, 75},   [92] = {3, 0, 64},   [93] = {3, 0, 125},
    [94] = {3, 0, 216},  [95] = {3, 0, 343},  [96] = {3, 0, 512},  [97] = {3, 0, 729},
    [98] = {3, 0, 1000}, [99] = {3, 0, 32},   [100] = {3, 0, 44},  [101] = {3, 0, 56},
    [102] = {3, 0, 68},  [103] = {3, 0, 80},  [104] = {3, 0, 92},  [105] = {3, 0, 104},
    [106] = {3, 0, 126}, [107] = {3, 0, 196}, [108] = {3, 0, 288}, [109] = {3, 0, 405},
    [110] = {3, 0, 550}, [111] = {3, 0, 24},  [112] = {3, 0, 33},  [113] = {3, 0, 42},
    [114] = {3, 0, 51},  [115] = {3, 0, 60},  [116] = {3, 0, 69},  [117] = {3, 0, 78},
    [118] = {3, 0, 30},  [119] = {3, 0, 55},  [120] = {3, 0, 91},  [121] = {3, 0, 140},
    [122] = {3, 0, 204}, [123] = {3, 0, 285}, [124] = {3, 0, 385}, [125] = {3, 0, 21},
    [126] = {3, 0, 29},  [127] = {3, 0, 37},  [128] = {3, 0, 45},  [129] = {3, 0, 53},
    [130] = {3, 0, 61},  [131] = {3, 0, 69},  [132] = {3, 0, 1},   [137] = {3, 1, 16},
};

int gmsh_find_type(const gmsh_reader *reader, int64_t number, const char *at, gmsh_type *type,
                   planish_error *error) {
    const gmsh_type none = {0, 0, 0};
    *type = number > 0 && number < (int64_t)(sizeof types / sizeof types[0]) ? types[number] : none;
    if (type->nodes == 0)
        return gmsh_fail(reader, at, error, "element type %lld is not known", (long long)number);
    if (type->simplex && type->nodes > type->dim + 1)
        return gmsh_fail(reader, at, error,
                         "%s of %d nodes: only straight ones (first order) can be smoothed; mesh "
                         "again with gmsh -order 1",
                         type->dim == 2 ? "triangle" : "tetrahedron", type->nodes);
    return 0;
}

io_cells *gmsh_cells(io_model *model, gmsh_type type) {
    if (type.dim == 1 && type.nodes == 2)
        return &model->line;
    if (!type.simplex)
        return NULL;
    return type.dim == 2 ? &model->triangle : &model->tetrahedron;
}

void gmsh_count_rest(io_model *model, gmsh_type type, int64_t n) {
    if (type.dim < 2)
        model->n_lower += n;
    else
        model->n_other += n;
}

/* ---- errors and single numbers ------------------------------------------------------------ */

int gmsh_fail(const gmsh_reader *reader, const char *at, planish_error *error, const char *format,
              ...) {
    char text[256];
    va_list arguments;
    if (error == NULL)
        return PLANISH_ERROR_FORMAT;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (reader->binary)
        return io_fail_byte(reader->model, at, error, "%s", text);
    return io_fail_text(reader->model, at, error, "%s", text);
}

static int fail_expected(const gmsh_reader *reader, const char *what) {
    return gmsh_fail(reader, reader->cursor.at, reader->error,
                     "%s expected (the file may be cut short)", what);
}

int gmsh_take_text(gmsh_reader *reader, int64_t *value, const char *what) {
    return io_integer(&reader->cursor, value) == 0 ? 0 : fail_expected(reader, what);
}

int gmsh_take_int(gmsh_reader *reader, int32_t *value, const char *what) {
    if (reader->binary) {
        if (io_left(&reader->cursor) < 4)
            return fail_expected(reader, what);
        *value = io_load_i32(reader->cursor.at, reader->swapped);
        reader->cursor.at += 4;
        return 0;
    }
    int64_t wide;
    if (io_integer(&reader->cursor, &wide) != 0 || wide < INT32_MIN || wide > INT32_MAX)
        return fail_expected(reader, what);
    *value = (int32_t)wide;
    return 0;
}

int gmsh_take_size(gmsh_reader *reader, int64_t *value, const char *what) {
    if (!reader->binary)
        return gmsh_take_text(reader, value, what);
    if (io_left(&reader->cursor) < 8)
        return fail_expected(reader, what);
    *value = io_load_i64(reader->cursor.at, reader->swapped);
    reader->cursor.at += 8;
    return 0;
}

int gmsh_skip_reals(gmsh_reader *reader, int64_t n, const char *what) {
    if (n < 0)
        return fail_expected(reader, what);
    if (reader->binary) {
        if (n > io_left(&reader->cursor) / 8)
            return fail_expected(reader, what);
        reader->cursor.at += 8 * n;
        return 0;
    }
    double value;
    for (int64_t i = 0; i < n; i++)
        if (io_real(&reader->cursor, &value) != 0)
            return fail_expected(reader, what);
    return 0;
}

int gmsh_end_line(gmsh_reader *reader) {
    io_cursor *cursor = &reader->cursor;
    const char *newline = memchr(cursor->at, '\n', (size_t)io_left(cursor));
    if (newline == NULL)
        return fail_expected(reader, "end of line");
    cursor->at = newline + 1;
    return 0;
}

int gmsh_check_count(const gmsh_reader *reader, int64_t n, int64_t text_bytes, int64_t binary_bytes,
                     const char *what) {
    int64_t bytes = reader->binary ? binary_bytes : text_bytes;
    const char *at = reader->cursor.at;
    if (n < 0)
        return gmsh_fail(reader, at, reader->error, "number of %s is negative", what);
    /* The last line of a text may lack its end. */
    if (n > (io_left(&reader->cursor) + !reader->binary) / bytes)
        return gmsh_fail(reader, at, reader->error,
                         "%lld %s cannot be in the rest of the file (cut short, or a wrong count)",
                         (long long)n, what);
    if (n > INT32_MAX)
        return gmsh_fail(reader, at, reader->error, "%lld %s: more than planish can number",
                         (long long)n, what);
    return 0;
}

/* ---- nodes and pairs ---------------------------------------------------------------------- */

int gmsh_make_nodes(gmsh_reader *reader, int64_t n, int64_t text_bytes, int64_t binary_bytes) {
    io_model *model = reader->model;
    if (model->xyz != NULL)
        return gmsh_fail(reader, reader->cursor.at, reader->error, "there is a second $Nodes");
    int status = gmsh_check_count(reader, n, text_bytes, binary_bytes, "nodes");
    if (status == 0)
        status = io_model_nodes(model, n, !reader->binary, reader->error);
    if (status != 0)
        return status;
    model->node_number = pl_alloc(n, sizeof *model->node_number);
    if (model->node_number == NULL)
        return pl_fail_memory(reader->error, "the nodes' numbers");
    const io_span text = {.n_nodes = n, .encoding = IO_TEXT};
    return reader->binary ? 0 : io_model_span(model, text, reader->error);
}

int gmsh_load_point(const gmsh_reader *reader, const char *at, int64_t node, planish_error *error) {
    double *xyz = reader->model->xyz + 3 * node;
    for (int i = 0; i < 3; i++) {
        xyz[i] = io_load_f64(at + 8 * i, reader->swapped);
        if (!isfinite(xyz[i]))
            return gmsh_fail(reader, at + 8 * i, error,
                             "node %lld has a coordinate that is not finite", (long long)node + 1);
    }
    return 0;
}

int gmsh_index_nodes(gmsh_reader *reader) {
    reader->have_nodes = 1;
    return io_settle_node_numbers(reader->model, &reader->numbers, reader->error);
}

/* Keep the numbers of cells only where they say more than the first of them. */
static int settle_numbers(gmsh_reader *reader, io_cells *cells) {
    io_numbers *table; /* made only to find a number that occurs twice */
    io_settle_cell_numbers(cells);
    if (cells->number == NULL)
        return 0;
    const int status = io_numbers_create(reader->model->input.path, "element", cells->number,
                                         cells->n, &table, reader->error);
    if (status == 0)
        io_numbers_destroy(table);
    return status;
}

/* size: bytes of its number, 0: text. */
static int take_periodic_node(gmsh_reader *reader, int size, int32_t *node) {
    int64_t number;
    int32_t narrow = 0;
    int status;
    if (size == 0)
        status = gmsh_take_text(reader, &number, "node of a periodic pair");
    else if (size == 8)
        status = gmsh_take_size(reader, &number, "node of a periodic pair");
    else {
        status = gmsh_take_int(reader, &narrow, "node of a periodic pair");
        number = narrow;
    }
    *node = status == 0 ? (int32_t)gmsh_node(reader, number) : -1;
    return status;
}

int gmsh_hold_pairs(gmsh_reader *reader, int64_t n, int size) {
    for (int64_t i = 0; i < n; i++) {
        int32_t pair[2];
        int status = take_periodic_node(reader, size, &pair[0]);
        if (status == 0)
            status = take_periodic_node(reader, size, &pair[1]);
        if (status != 0)
            return status;
        /* Gmsh lists pairs of the whole geometry, also where only some groups were saved: a node
         * whose partner is not there stays. */
        const int is_whole = pair[0] >= 0 && pair[1] >= 0;
        for (int j = 0; j < 2; j++)
            if (pair[j] >= 0)
                io_hold_node(reader->model, pair[j],
                             is_whole ? IO_HELD_PERIODIC : IO_HELD_REQUIRED);
        if (is_whole && io_model_pair(reader->model, pair, reader->error) != 0)
            return PLANISH_ERROR_MEMORY;
    }
    return 0;
}

/* ---- header ---------------------------------------------------------------------------- */

/* The integer 1 behind the header's line tells the byte order. */
static int read_byte_order(gmsh_reader *reader) {
    int32_t one;
    if (gmsh_end_line(reader) != 0 || gmsh_take_int(reader, &one, "byte order mark") != 0)
        return PLANISH_ERROR_FORMAT;
    if (one == 1)
        return 0;
    reader->swapped = 1;
    if (io_load_i32(reader->cursor.at - 4, 1) == 1)
        return 0;
    return gmsh_fail(reader, reader->cursor.at - 4, reader->error,
                     "byte order mark is not the integer 1");
}

/* 10 to 22, 40 or 41; 0 for versions that are not read. */
static int version_of(double value) {
    static const int known[] = {10, 20, 21, 22, 40, 41};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        if (fabs(10 * value - known[i]) < 0.5)
            return known[i];
    return 0;
}

/* $MeshFormat: version, 0 ASCII or 1 binary, size of a number. */
static int read_header(gmsh_reader *reader) {
    io_cursor *cursor = &reader->cursor;
    double version;
    int64_t type, size;
    const char *at = cursor->at;
    if (io_real(cursor, &version) != 0 || io_integer(cursor, &type) != 0 ||
        io_integer(cursor, &size) != 0)
        return fail_expected(reader, "$MeshFormat: version, file type and data size");
    reader->version = version_of(version);
    if (reader->version == 0)
        return gmsh_fail(reader, at, reader->error,
                         "MSH version %g: versions 1, 2.0 to 2.2, 4.0 and 4.1 are read; convert "
                         "the file with gmsh IN.msh -0 -format msh41 -o OUT.msh",
                         version);
    if ((type != 0 && type != 1) || size != 8)
        return gmsh_fail(reader, at, reader->error,
                         "file type %lld and data size %lld: 0 or 1 and 8 expected",
                         (long long)type, (long long)size);
    reader->binary = type == 1;
    return reader->binary ? read_byte_order(reader) : 0;
}

/* ---- the sections ------------------------------------------------------------------------- */

typedef int section_fn(gmsh_reader *reader);

struct section {
    const char *name;
    section_fn *read[2]; /* MSH 1 and 2, MSH 4; NULL: passed over */
    int needs_nodes;
};

static int refuse_parametric(gmsh_reader *reader) {
    return gmsh_fail(reader, reader->cursor.at, reader->error,
                     "$ParametricNodes are not read; convert the file with gmsh IN.msh -0 "
                     "-format msh41 -o OUT.msh");
}

/* The last ones are of MSH 1. */
static const struct section sections[] = {
    {"PhysicalNames", {gmsh_names, gmsh_names}, 0},
    {"Entities", {NULL, gmsh4_entities}, 0},
    {"PartitionedEntities", {NULL, gmsh4_partitioned_entities}, 0},
    {"Nodes", {gmsh2_nodes, gmsh4_nodes}, 0},
    {"ParametricNodes", {refuse_parametric, refuse_parametric}, 0},
    {"Elements", {gmsh2_elements, gmsh4_elements}, 1},
    {"Periodic", {gmsh2_periodic, gmsh4_periodic}, 1},
    {"NOD", {gmsh2_nodes, NULL}, 0},
    {"NOE", {gmsh2_nodes, NULL}, 0},
    {"ELM", {gmsh2_elements, NULL}, 1},
};

static int is_old(const char *name, int64_t length) {
    return io_word_is(name, length, "NOD", 0) || io_word_is(name, length, "NOE", 0) ||
           io_word_is(name, length, "ELM", 0);
}

static const struct section *find_section(const char *name, int64_t length) {
    for (size_t i = 0; i < sizeof sections / sizeof sections[0]; i++)
        if (io_word_is(name, length, sections[i].name, 0))
            return &sections[i];
    return NULL;
}

/* "$EndNAME", in MSH 1 "$ENDNAME"; cut off if it is too long. Returns its length. */
static int make_end_mark(const char *name, int64_t length, char *mark, size_t size) {
    return snprintf(mark, size, "$%s%.*s", is_old(name, length) ? "END" : "End",
                    (int)(length < 64 ? length : 64), name);
}

/* The cursor behind the line $EndNAME, wherever that is. */
static int skip_section(gmsh_reader *reader, const char *name, int64_t length) {
    char end_mark[64];
    io_cursor *cursor = &reader->cursor;
    int written = make_end_mark(name, length, end_mark, sizeof end_mark);
    if (written < 0 || written >= (int)sizeof end_mark)
        return gmsh_fail(reader, name, reader->error, "section name is too long");
    const char *begin = cursor->at;
    for (;;) {
        int64_t found;
        cursor->at = io_find_line(cursor->at, cursor->end, end_mark);
        if (cursor->at == cursor->end)
            return gmsh_fail(reader, begin, reader->error, "no %s (the file may be cut short)",
                             end_mark);
        const char *word = io_word(cursor, &found);
        if (io_word_is(word, found, end_mark, 0))
            return 0;
    }
}

/* What a section's reader leaves must be its end mark. */
static int expect_end(gmsh_reader *reader, const char *name) {
    char end_mark[64];
    int64_t length;
    make_end_mark(name, (int64_t)strlen(name), end_mark, sizeof end_mark);
    const char *word = io_word(&reader->cursor, &length);
    if (io_word_is(word, length, end_mark, 0))
        return 0;
    return gmsh_fail(reader, word, reader->error,
                     "%s expected: the file is cut short or a count is wrong", end_mark);
}

/* Data in a binary file by their count, if the end of the section is found behind them. */
static int skip_data_section(gmsh_reader *reader, const char *name, int64_t length) {
    static const char *const data[] = {"NodeData", "ElementData", "ElementNodeData"};
    const io_cursor before = reader->cursor;
    for (size_t i = 0; reader->binary && i < sizeof data / sizeof data[0]; i++) {
        if (!io_word_is(name, length, data[i], 0))
            continue;
        planish_error *error = reader->error, ignored;
        reader->error = &ignored;
        const int is_whole = gmsh_skip_data(reader, strcmp(data[i], "ElementNodeData") == 0) == 0 &&
                             expect_end(reader, data[i]) == 0;
        reader->error = error;
        if (is_whole)
            return 0;
    }
    reader->cursor = before;
    return skip_section(reader, name, length);
}

/* A section that is not read; values of elements are kept in mind. */
static int pass_over(gmsh_reader *reader, const char *name, int64_t length) {
    static const char data[] = "ElementData", mark[] = "$EndElementData";
    const char *head = reader->cursor.at;
    const int status = skip_data_section(reader, name, length);
    if (status != 0 || !io_word_is(name, length, data, 0))
        return status;
    return gmsh_note_data(reader, head, reader->cursor.at - (sizeof mark - 1));
}

static int read_section(gmsh_reader *reader, const char *name, int64_t length) {
    const struct section *section = find_section(name, length);
    section_fn *read = section == NULL ? NULL : section->read[reader->version >= 40];
    if (read == NULL)
        return pass_over(reader, name, length);
    if (section->needs_nodes && !reader->have_nodes)
        return gmsh_fail(reader, name, reader->error, "$%s stands before $Nodes", section->name);
    int status = read(reader);
    return status != 0 ? status : expect_end(reader, section->name);
}

/* The next section's name, without its $; *length 0 at the end of the file. Lines outside of
 * sections are comments. */
static const char *next_section(io_cursor *cursor, int64_t *length) {
    cursor->at = io_find_line(cursor->at, cursor->end, "$");
    const char *word = io_word(cursor, length);
    if (*length == 0)
        return word;
    *length -= 1;
    return word + 1;
}

static int fail_foreign(gmsh_reader *reader, const char *at) {
    return gmsh_fail(
        reader, at, reader->error,
        "no $MeshFormat: this is no mesh of Gmsh's (others call their files .msh, too)");
}

/* The section of that name, the header or another one; there must be a header before, but in MSH 1.
 */
static int read_any_section(gmsh_reader *reader, const char *name, int64_t length) {
    if (io_word_is(name, length, "MeshFormat", 0)) {
        const int status = read_header(reader);
        return status != 0 ? status : expect_end(reader, "MeshFormat");
    }
    if (reader->version == 0 && is_old(name, length))
        reader->version = 10;
    if (reader->version == 0 && find_section(name, length) != NULL)
        return gmsh_fail(reader, name, reader->error, "no $MeshFormat before this section");
    const int status = read_section(reader, name, length);
    if (status == PLANISH_ERROR_FORMAT && reader->version == 0)
        return fail_foreign(reader, name);
    return status;
}

static int read_sections(gmsh_reader *reader) {
    int64_t length;
    for (;;) {
        const char *name = next_section(&reader->cursor, &length);
        if (name >= reader->cursor.end || length == 0)
            break;
        const int status = read_any_section(reader, name, length);
        if (status != 0)
            return status;
    }
    if (reader->version == 0)
        return fail_foreign(reader, reader->cursor.end);
    if (!reader->have_nodes || !reader->have_elements)
        return gmsh_fail(reader, reader->cursor.end, reader->error,
                         "the file ends without %s (it may be cut short)",
                         reader->have_nodes ? "$Elements" : "$Nodes");
    return 0;
}

static int read_gmsh(io_model *model, planish_error *error) {
    gmsh_reader reader = {.model = model,
                          .error = error,
                          .cursor = io_begin_text(model->input.data, model->input.size)};
    io_text_init(&reader.text, model);
    model->columns = 3;
    int status = read_sections(&reader);
    if (status == 0)
        status = settle_numbers(&reader, &model->triangle);
    if (status == 0)
        status = settle_numbers(&reader, &model->tetrahedron);
    if (status == 0)
        status = gmsh_settle_names(&reader);
    if (status == 0)
        status = gmsh_read_data(&reader);
    io_text_release(&reader.text);
    io_numbers_destroy(reader.numbers);
    pl_free(reader.place);
    pl_free(reader.data);
    return status;
}

/* A first line of $ and letters, the first a capital: no other format begins so. */
static int recognise_gmsh(const char *data, int64_t size) {
    io_cursor cursor = io_begin_text(data, size);
    io_skip_space(&cursor);
    if (cursor.end - cursor.at < 2 || *cursor.at++ != '$' || *cursor.at < 'A' || *cursor.at > 'Z')
        return 0;
    while (cursor.at < cursor.end && isalpha((unsigned char)*cursor.at))
        cursor.at++;
    return cursor.at == cursor.end || isspace((unsigned char)*cursor.at);
}

static const char *const gmsh_extensions[] = {".msh", NULL};

const io_format io_format_gmsh = {
    .name = "gmsh", .extensions = gmsh_extensions, .recognise = recognise_gmsh, .read = read_gmsh};
