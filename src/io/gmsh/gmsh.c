/* gmsh: MSH files of Gmsh, versions 1, 2 and 4, ASCII and binary.
 *
 * Recognises the format, reads the header and walks the sections; names of groups are read by
 * gmsh_names.c, nodes, elements, entities and periodic pairs by gmsh2.c and gmsh4.c, and values of
 * elements that may tell regions by gmsh_data.c. Sections that say nothing about the mesh itself
 * ($Comments, $NodeData, $GhostElements, unknown ones) are passed over.
 */
#include "io/core/format.h"
#include "io/gmsh/gmsh_reader.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/memory.h"
#include "base/status.h"
#include "io/core/binary.h"

/** Keep the numbers of cells only where they say more than the first of them. */
static int settle_numbers(gmsh_reader *reader, io_cells *cells) {
    io_numbers *table; /* made only to find a number that occurs twice */
    io_settle_cell_numbers(cells);
    if (!cells->number)
        return 0;
    const int status = io_numbers_create(reader->model->input.path, "element", cells->number,
                                         cells->n, &table, reader->error);
    if (!status)
        io_numbers_destroy(table);
    return status;
}

/* ---- header ---------------------------------------------------------------------------- */

/** The integer 1 behind the header's line tells the byte order. */
static int read_byte_order(gmsh_reader *reader) {
    int32_t one;
    if (gmsh_end_line(reader) || gmsh_take_int(reader, &one, "byte order mark"))
        return PLANISH_ERROR_FORMAT;
    if (one == 1)
        return 0;
    reader->swapped = 1;
    if (io_load_i32(reader->cursor.at - 4, 1) == 1)
        return 0;
    return io_fail_at(reader->model, reader->cursor.at - 4, reader->error,
                      "byte order mark is not the integer 1");
}

/** 10 to 22, 40 or 41; 0 for versions that are not read. */
static int version_of(double value) {
    static const int known[] = {10, 20, 21, 22, 40, 41};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        if (fabs(10 * value - known[i]) < 0.5)
            return known[i];
    return 0;
}

/** $MeshFormat: version, 0 ASCII or 1 binary, size of a number. */
static int read_header(gmsh_reader *reader) {
    io_cursor *cursor = &reader->cursor;
    double version;
    int64_t type, size;
    const char *at = cursor->at;
    if (io_real(cursor, &version) || io_integer(cursor, &type) || io_integer(cursor, &size))
        return gmsh_fail_expected(reader, "$MeshFormat: version, file type and data size");
    reader->version = version_of(version);
    if (reader->version == 0)
        return io_fail_at(reader->model, at, reader->error,
                          "MSH version %g: versions 1, 2.0 to 2.2, 4.0 and 4.1 are read; convert "
                          "the file with gmsh IN.msh -0 -format msh41 -o OUT.msh",
                          version);
    if ((type != 0 && type != 1) || size != 8)
        return io_fail_at(reader->model, at, reader->error,
                          "file type %lld and data size %lld: 0 or 1 and 8 expected",
                          (long long)type, (long long)size);
    reader->model->is_binary = type == 1;
    return reader->model->is_binary ? read_byte_order(reader) : 0;
}

/* ---- the sections ------------------------------------------------------------------------- */

typedef int section_fn(gmsh_reader *reader);

typedef struct known_section {
    const char *name;
    section_fn *read[2]; /* MSH 1 and 2, MSH 4; NULL: passed over */
    int needs_nodes;
} known_section;

static int refuse_parametric(gmsh_reader *reader) {
    return io_fail_at(reader->model, reader->cursor.at, reader->error,
                      "$ParametricNodes are not read; convert the file with gmsh IN.msh -0 "
                      "-format msh41 -o OUT.msh");
}

/* The last ones are of MSH 1. */
static const known_section sections[] = {
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

static const known_section *find_section(const char *name, int64_t length) {
    for (size_t i = 0; i < sizeof sections / sizeof sections[0]; i++)
        if (io_word_is(name, length, sections[i].name, 0))
            return &sections[i];
    return NULL;
}

/** "$EndNAME", in MSH 1 "$ENDNAME"; cut off if it is too long. Returns its length. */
static int make_end_mark(const char *name, int64_t length, char *mark, size_t size) {
    return snprintf(mark, size, "$%s%.*s", is_old(name, length) ? "END" : "End",
                    (int)(length < 64 ? length : 64), name);
}

/** The cursor behind the line $EndNAME, wherever that is. */
static int skip_section(gmsh_reader *reader, const char *name, int64_t length) {
    char end_mark[64];
    io_cursor *cursor = &reader->cursor;
    int written = make_end_mark(name, length, end_mark, sizeof end_mark);
    if (written < 0 || written >= (int)sizeof end_mark)
        return io_fail_at(reader->model, name, reader->error, "section name is too long");
    const char *begin = cursor->at;
    for (;;) {
        int64_t found;
        cursor->at = io_find_line(cursor->at, cursor->end, end_mark);
        if (cursor->at == cursor->end)
            return io_fail_at(reader->model, begin, reader->error,
                              "no %s (the file may be cut short)", end_mark);
        const char *word = io_word(cursor, &found);
        if (io_word_is(word, found, end_mark, 0))
            return 0;
    }
}

/** What a section's reader leaves must be its end mark. */
static int expect_end(gmsh_reader *reader, const char *name) {
    char end_mark[64];
    int64_t length;
    make_end_mark(name, (int64_t)strlen(name), end_mark, sizeof end_mark);
    const char *word = io_word(&reader->cursor, &length);
    if (io_word_is(word, length, end_mark, 0))
        return 0;
    return io_fail_at(reader->model, word, reader->error,
                      "%s expected: the file is cut short or a count is wrong", end_mark);
}

/** Data in a binary file by their count, if the end of the section is found behind them. */
static int skip_data_section(gmsh_reader *reader, const char *name, int64_t length) {
    static const char *const data[] = {"NodeData", "ElementData", "ElementNodeData"};
    const io_cursor before = reader->cursor;
    for (size_t i = 0; reader->model->is_binary && i < sizeof data / sizeof data[0]; i++) {
        if (!io_word_is(name, length, data[i], 0))
            continue;
        planish_error *error = reader->error, ignored;
        reader->error = &ignored;
        const int is_whole = !gmsh_skip_data(reader, strcmp(data[i], "ElementNodeData") == 0) &&
                             !expect_end(reader, data[i]);
        reader->error = error;
        if (is_whole)
            return 0;
    }
    reader->cursor = before;
    return skip_section(reader, name, length);
}

/** A section that is not read; values of elements are kept in mind. */
static int pass_over(gmsh_reader *reader, const char *name, int64_t length) {
    static const char data[] = "ElementData", mark[] = "$EndElementData";
    const char *head = reader->cursor.at;
    const int status = skip_data_section(reader, name, length);
    if (status || !io_word_is(name, length, data, 0))
        return status;
    return gmsh_note_data(reader, head, reader->cursor.at - (sizeof mark - 1));
}

static int read_section(gmsh_reader *reader, const char *name, int64_t length) {
    const known_section *section = find_section(name, length);
    section_fn *read = !section ? NULL : section->read[reader->version >= 40];
    if (!read)
        return pass_over(reader, name, length);
    if (section->needs_nodes && !reader->have_nodes)
        return io_fail_at(reader->model, name, reader->error, "$%s stands before $Nodes",
                          section->name);
    int status = read(reader);
    return status ? status : expect_end(reader, section->name);
}

/** The next section's name, without its $; *length 0 at the end of the file. Lines outside of
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
    return io_fail_at(
        reader->model, at, reader->error,
        "no $MeshFormat: this is no mesh of Gmsh's (others call their files .msh, too)");
}

/** The section of that name, the header or another one; there must be a header before, but in
 * MSH 1.
 */
static int read_any_section(gmsh_reader *reader, const char *name, int64_t length) {
    if (io_word_is(name, length, "MeshFormat", 0)) {
        const int status = read_header(reader);
        return status ? status : expect_end(reader, "MeshFormat");
    }
    if (reader->version == 0 && is_old(name, length))
        reader->version = 10;
    if (reader->version == 0 && find_section(name, length))
        return io_fail_at(reader->model, name, reader->error, "no $MeshFormat before this section");
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
        if (status)
            return status;
    }
    if (reader->version == 0)
        return fail_foreign(reader, reader->cursor.end);
    if (!reader->have_nodes || !reader->have_elements)
        return io_fail_at(reader->model, reader->cursor.end, reader->error,
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
    if (!status)
        status = settle_numbers(&reader, &model->triangle);
    if (!status)
        status = settle_numbers(&reader, &model->tetrahedron);
    if (!status)
        status = gmsh_settle_names(&reader);
    if (!status)
        status = gmsh_read_data(&reader);
    io_text_release(&reader.text);
    io_numbers_destroy(reader.numbers);
    pl_free(reader.place);
    pl_free(reader.data);
    return status;
}

/** A first line of $ and letters, the first a capital: no other format begins so. */
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
