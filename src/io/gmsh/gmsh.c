/* gmsh: MSH files of Gmsh, versions 1, 2 and 4, ASCII and binary.
 *
 * Recognises the format, reads the header and walks the sections; names of groups are read by
 * gmsh_names.c, nodes, elements and entities by gmsh2.c and gmsh4.c, and values of
 * nodes and elements by gmsh_data.c. Sections that say nothing about the mesh itself
 * ($Comments, $GhostElements, unknown ones) are passed over.
 */
#include "io/core/format.h"
#include "io/gmsh/gmsh_write.h"
#include "io/gmsh/gmsh_sections.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/memory.h"
#include "base/status.h"

/** Keep the numbers of cells only where they say more than the first of them. */
static int check_numbers(gmsh_reader *reader, io_cells *cells) {
    io_numbers *table; /* made only to find a number that occurs twice */
    io_reduce_cell_numbers(cells);
    if (!cells->number)
        return PLANISH_OK;
    const int status = io_numbers_create(reader->model->input.path, "element", cells->number,
                                         cells->n, &table, reader->error);
    if (!status)
        io_numbers_destroy(table);
    return status;
}

/* ---- header ---------------------------------------------------------------------------- */

/** Read $MeshFormat: version, 0 ASCII or 1 binary, size of a number; in binary the integer 1 behind
 *  its line tells the byte order. */
static int read_header(gmsh_reader *reader) {
    static const int known[] = {10, 20, 21, 22, 40, 41};
    io_model *model = reader->model;
    io_cursor *cursor = &reader->cursor;
    double version;
    int64_t type, size, one;
    const char *at = cursor->at;
    if (io_real(cursor, &version) || io_integer(cursor, &type) || io_integer(cursor, &size))
        return gmsh_fail_expected(reader, "$MeshFormat: version, file type and data size");
    reader->version = 0;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (fabs(10 * version - known[i]) < 0.5)
            reader->version = known[i];
    if (reader->version == 0)
        return io_fail_at(model, at, reader->error,
                          "MSH version %g: versions 1, 2.0 to 2.2, 4.0 and 4.1 are read; convert "
                          "the file with gmsh IN.msh -0 -format msh41 -o OUT.msh",
                          version);
    if ((type != 0 && type != 1) || size != 8)
        return io_fail_at(model, at, reader->error,
                          "file type %lld and data size %lld: 0 or 1 and 8 expected",
                          (long long)type, (long long)size);
    model->is_binary = type == 1;
    if (!model->is_binary)
        return PLANISH_OK;
    int status = gmsh_end_line(reader);
    if (!status)
        status = gmsh_take(reader, 4, &one, "byte order mark");
    if (status)
        return status;
    reader->swapped = one != 1;
    if (one != 1 && io_load_i32(cursor->at - 4, 1) != 1)
        return io_fail_at(model, cursor->at - 4, reader->error,
                          "byte order mark is not the integer 1");
    return PLANISH_OK;
}

/* ---- the sections ------------------------------------------------------------------------- */

typedef int section_fn(gmsh_reader *reader);

typedef struct known_section {
    const char *name;
    section_fn *read[2]; /* MSH 1 and 2, MSH 4; NULL: passed over */
    int needs_nodes;
    int is_old; /* of MSH 1: the end mark is in capitals */
} known_section;

static int refuse_parametric(gmsh_reader *reader) {
    return io_fail_at(reader->model, reader->cursor.at, reader->error,
                      "$ParametricNodes are not read; convert the file with gmsh IN.msh -0 "
                      "-format msh41 -o OUT.msh");
}

static const known_section sections[] = {
    {"MeshFormat", {read_header, read_header}, 0, 0},
    {"PhysicalNames", {gmsh_names, gmsh_names}, 0, 0},
    {"Entities", {NULL, gmsh4_entities}, 0, 0},
    {"PartitionedEntities", {NULL, gmsh4_partitioned_entities}, 0, 0},
    {"Nodes", {gmsh2_nodes, gmsh4_nodes}, 0, 0},
    {"ParametricNodes", {refuse_parametric, refuse_parametric}, 0, 0},
    {"Elements", {gmsh2_elements, gmsh4_elements}, 1, 0},
    {"Periodic", {gmsh_periodic, gmsh_periodic}, 1, 0},
    {"NOD", {gmsh2_nodes, NULL}, 0, 1},
    {"NOE", {gmsh2_nodes, NULL}, 0, 1},
    {"ELM", {gmsh2_elements, NULL}, 1, 1},
};

/** Take the word at the cursor. Return whether it is the end mark of a section. */
static int take_end(io_cursor *cursor, const char *end_mark) {
    return io_slice_is(io_next_word(cursor), end_mark, 0);
}

/** Pass over a section that is not read, up to its end mark. In binary, data are passed over by
 *  their count if the end mark is found behind them. Note values of nodes and elements. */
static int pass_over(gmsh_reader *reader, io_slice name, const char *end_mark) {
    io_cursor *cursor = &reader->cursor, ahead;
    const char *begin = cursor->at;
    const int of_element_nodes = io_slice_is(name, "ElementNodeData", 0);
    const int of_elements = io_slice_is(name, "ElementData", 0);
    const int of_nodes = io_slice_is(name, "NodeData", 0);
    int is_found = 0;
    if (reader->model->is_binary && (of_elements || of_element_nodes || of_nodes) &&
        !gmsh_skip_data(reader, of_element_nodes)) {
        ahead = *cursor;
        is_found = take_end(&ahead, end_mark);
    }
    for (const char *at = begin; !is_found; at = ahead.at) {
        cursor->at = io_find_line(at, cursor->end, end_mark);
        if (cursor->at == cursor->end)
            return io_fail_at(reader->model, begin, reader->error,
                              "no %s (the file may be cut short)", end_mark);
        ahead = *cursor;
        is_found = take_end(&ahead, end_mark);
    }
    return of_elements || of_nodes ? gmsh_note_data(reader, of_elements, begin, cursor->at)
                                   : PLANISH_OK;
}

static int fail_foreign(gmsh_reader *reader, const char *at) {
    return io_fail_at(
        reader->model, at, reader->error,
        "no $MeshFormat: this is not a mesh of Gmsh (other programs also write .msh files)");
}

/** Read the section of that name: the header, which must come first but in MSH 1, or another. What
 *  its reader leaves must be its end mark. */
static int read_section(gmsh_reader *reader, io_slice name) {
    const known_section *section = NULL;
    for (size_t i = 0; i < sizeof sections / sizeof *sections && !section; i++)
        if (io_slice_is(name, sections[i].name, 0))
            section = &sections[i];
    const int is_old = section && section->is_old;
    const int64_t length = io_slice_length(name);
    char end_mark[64];
    const int written = snprintf(end_mark, sizeof end_mark, "$%s%.*s", is_old ? "END" : "End",
                                 (int)(length < 64 ? length : 64), name.begin);
    if (reader->version == 0 && is_old)
        reader->version = 10;
    if (reader->version == 0 && section && section->read[0] != read_header)
        return io_fail_at(reader->model, name.begin, reader->error,
                          "no $MeshFormat before this section");
    section_fn *read = section ? section->read[reader->version >= 40] : NULL;
    if (read && section->needs_nodes && !reader->have_nodes)
        return io_fail_at(reader->model, name.begin, reader->error, "$%s stands before $Nodes",
                          section->name);
    int status;
    if (read)
        status = read(reader);
    else if (written > 0 && written < (int)sizeof end_mark)
        status = pass_over(reader, name, end_mark);
    else
        status = io_fail_at(reader->model, name.begin, reader->error, "section name is too long");
    if (status == PLANISH_ERROR_FORMAT && reader->version == 0 && !read)
        return fail_foreign(reader, name.begin);
    if (status)
        return status;
    io_skip_space(&reader->cursor);
    const char *at = reader->cursor.at;
    if (take_end(&reader->cursor, end_mark))
        return PLANISH_OK;
    return io_fail_at(reader->model, at, reader->error,
                      "%s expected: the file is cut short or a count is wrong", end_mark);
}

static int read_sections(gmsh_reader *reader) {
    io_cursor *cursor = &reader->cursor;
    for (;;) {
        cursor->at = io_find_line(cursor->at, cursor->end, "$"); /* other lines are comments */
        io_slice name = io_next_word(cursor);
        if (io_slice_length(name) < 2)
            break;
        name.begin++; /* the $ */
        const int status = read_section(reader, name);
        if (status)
            return status;
    }
    if (reader->version == 0)
        return fail_foreign(reader, cursor->end);
    if (!reader->have_nodes || !reader->have_elements)
        return io_fail_at(reader->model, cursor->end, reader->error,
                          "the file ends without %s (it may be cut short)",
                          reader->have_nodes ? "$Elements" : "$Nodes");
    return PLANISH_OK;
}

static int gmsh_read(io_model *model, planish_error *error) {
    gmsh_reader reader = {.model = model,
                          .error = error,
                          .cursor = io_begin_text(model->input.data, model->input.size)};
    io_text_init(&reader.text, model);
    model->node_order = gmsh_node_orders;
    int status = read_sections(&reader);
    if (!status)
        status = check_numbers(&reader, &model->triangle);
    if (!status)
        status = check_numbers(&reader, &model->tetrahedron);
    if (!status)
        status = gmsh_take_points(&reader);
    if (!status)
        status = gmsh_complete_names(&reader);
    if (!status)
        status = gmsh_read_data(&reader);
    io_text_release(&reader.text);
    pl_free(reader.entity);
    pl_free(reader.point);
    pl_free(reader.data);
    return status;
}

/** Recognise a first line of $ and letters, the first a capital: no other format begins so. */
static int gmsh_recognise(const char *data, int64_t size) {
    io_cursor cursor = io_begin_text(data, size);
    io_skip_space(&cursor);
    if (cursor.end - cursor.at < 2 || *cursor.at++ != '$' || *cursor.at < 'A' || *cursor.at > 'Z')
        return 0;
    while (cursor.at < cursor.end && isalpha((unsigned char)*cursor.at))
        cursor.at++;
    return cursor.at == cursor.end || isspace((unsigned char)*cursor.at);
}

static const char *const gmsh_extensions[] = {".msh", NULL};

const io_format io_format_gmsh = {.name = "gmsh",
                                  .extensions = gmsh_extensions,
                                  .recognise = gmsh_recognise,
                                  .read = gmsh_read,
                                  .read_data = gmsh_read_values,
                                  .targets = gmsh_targets};
