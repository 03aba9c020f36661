/* medit: Medit's meshes, ASCII (.mesh) and binary (.meshb), versions 1 to 4.
 *
 * Read are vertices, edges, triangles and tetrahedra with their references, elements of other types,
 * and which nodes anything else names: nodes of edges, of other elements and of Corners, Ridges and
 * Required... are held. All other keywords are passed over, which a
 * conversion tells. Coordinates of version 1 are single
 * precision by definition (and read so by Mmg).
 *
 * Text: keywords, each with a count and that many records; '#' begins a comment.
 *
 * Binary, in either byte order: a 1 (that tells the byte order), the version, and keywords. Each
 * has its code, the position of the next keyword and, most often, a count before its records. Codes
 * are of 32 bits. Version 1 has floats, the later ones doubles; positions are of 64 bits from
 * version 3 on, counts, indices and references from version 4 on. Positions of 32 bits are signed:
 * libMeshb cannot read versions 1 and 2 above 2 GB either.
 *
 * Here a walk over the file finds the sections; medit_mesh.c reads their records.
 */
#include "io/core/binary.h"
#include "io/core/format.h"
#include "io/medit/medit_reader.h"
#include "io/medit/medit_write.h"

#include "base/status.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

enum {
    WORD_SIZE = 4,
    CODE_DIMENSION = 3,
    CODE_REQUIRED_VERTICES = 15,
    CODE_END = 54,
    LAST_VERSION = 4
};

/* ---- keywords ----------------------------------------------------------------------------- */

/* Codes are libMeshb's (GmfKwdCod), that of RequiredTetrahedra is Mmg's. */
static const medit_keyword mesh_keywords[] = {
    {{"Vertices", IO_POINT, 1, 0}, 4, MEDIT_VERTICES},
    {{"Triangles", IO_TRIANGLE, 1, 3}, 6, MEDIT_ELEMENTS},
    {{"Tetrahedra", IO_TETRAHEDRON, 1, 4}, 8, MEDIT_ELEMENTS},
    {{"Edges", IO_LINE, 1, 2}, 5, MEDIT_ELEMENTS},
    {{"Quadrilaterals", IO_QUADRILATERAL, 1, 4}, 7, MEDIT_ELEMENTS},
    {{"Hexahedra", IO_HEXAHEDRON, 1, 8}, 10, MEDIT_ELEMENTS},
    {{"Prisms", IO_PRISM, 1, 6}, 9, MEDIT_ELEMENTS},
    {{"Pyramids", IO_PYRAMID, 1, 5}, 49, MEDIT_ELEMENTS},
    {{"QuadrilateralsQ2", IO_QUADRILATERAL, 2, 9}, 27, MEDIT_ELEMENTS},
    {{"HexahedraQ2", IO_HEXAHEDRON, 2, 27}, 33, MEDIT_ELEMENTS},
    {{"PrismsP2", IO_PRISM, 2, 18}, 86, MEDIT_ELEMENTS},
    {{"PyramidsP2", IO_PYRAMID, 2, 14}, 87, MEDIT_ELEMENTS},
    {{"EdgesP2", IO_LINE, 2, 3}, 25, MEDIT_CURVED},
    {{"TrianglesP2", IO_TRIANGLE, 2, 6}, 24, MEDIT_CURVED},
    {{"TetrahedraP2", IO_TETRAHEDRON, 2, 10}, 30, MEDIT_CURVED},
    {{"EdgesP3", IO_LINE, 3, 4}, 92, MEDIT_ELEMENTS},
    {{"TrianglesP3", IO_TRIANGLE, 3, 10}, 90, MEDIT_ELEMENTS},
    {{"TetrahedraP3", IO_TETRAHEDRON, 3, 20}, 96, MEDIT_ELEMENTS},
    {{"EdgesP4", IO_LINE, 4, 5}, 93, MEDIT_ELEMENTS},
    {{"TrianglesP4", IO_TRIANGLE, 4, 15}, 91, MEDIT_ELEMENTS},
    {{"TetrahedraP4", IO_TETRAHEDRON, 4, 35}, 97, MEDIT_ELEMENTS},
    {{"Corners", IO_POINT, 1, 1}, 13, MEDIT_MARKED},
    {{"RequiredVertices", IO_POINT, 1, 1}, CODE_REQUIRED_VERTICES, MEDIT_MARKED},
    {{"RequiredEdges", IO_LINE, 1, 1}, 16, MEDIT_MARKED},
    {{"RequiredTriangles", IO_TRIANGLE, 1, 1}, 17, MEDIT_MARKED},
    {{"RequiredTetrahedra", IO_TETRAHEDRON, 1, 1}, 12, MEDIT_MARKED},
    {{"RequiredQuadrilaterals", IO_QUADRILATERAL, 1, 1}, 18, MEDIT_MARKED},
    /* Ridges number edges: all held. */
    {{"QuadrilateralsQ2Ordering", IO_QUADRILATERAL, 2, 2}, 131, MEDIT_ORDERING},
    {{"HexahedraQ2Ordering", IO_HEXAHEDRON, 2, 3}, 139, MEDIT_ORDERING},
    {{"PrismsP2Ordering", IO_PRISM, 2, 4}, 137, MEDIT_ORDERING},
    {{"EdgesP2Ordering", IO_LINE, 2, 1}, 127, MEDIT_ORDERING},
    {{"TrianglesP2Ordering", IO_TRIANGLE, 2, 3}, 129, MEDIT_ORDERING},
    {{"TetrahedraP2Ordering", IO_TETRAHEDRON, 2, 4}, 133, MEDIT_ORDERING},
    {{"PeriodicVertices", IO_POINT, 1, 2}, 82, MEDIT_PAIRS},
};

/* Keywords that are passed over, by their codes in binary. */
static const struct {
    int code;
    const char *name;
} passed_over[] = {{14, "Ridges"},
                   {20, "NormalAtVertices"},
                   {59, "Tangents"},
                   {60, "Normals"},
                   {61, "TangentAtVertices"}};

/** Note a keyword that no conversion carries over. */
static int note_name(const medit_reader *r, const char *name, int64_t length) {
    enum { MOST_NAMES = 100, MOST_NAME = 64 }; /* a damaged file has any words */
    io_names *names = &r->model->not_carried;
    if (names->n >= MOST_NAMES ||
        io_names_add(names, name, length < MOST_NAME ? length : MOST_NAME))
        return PLANISH_OK;
    return pl_fail_memory(r->error, "the keywords of the file");
}

/** Note a keyword that is passed over: by its name in text, by its code in binary. */
static int note_passed_over(const medit_reader *r, io_slice name, int64_t code) {
    char text[32];
    if (!r->model->is_binary)
        return note_name(r, name.begin, io_slice_length(name));
    snprintf(text, sizeof text, "keyword %d", (int)code);
    for (size_t i = 0; i < sizeof passed_over / sizeof *passed_over; i++)
        if (passed_over[i].code == code)
            snprintf(text, sizeof text, "%s", passed_over[i].name);
    return note_name(r, text, (int64_t)strlen(text));
}

/** Note a section, and its keyword if no conversion carries that over: nodes alone stay held. */
static int add_section(medit_reader *r, io_section section) {
    const medit_keyword *k = &r->keywords[section.keyword];
    const int is_lost = k->kind == MEDIT_MARKED && k->code != CODE_REQUIRED_VERTICES;
    const int status = is_lost && section.count > 0
                           ? note_name(r, k->type.name, (int64_t)strlen(k->type.name))
                           : PLANISH_OK;
    return status ? status : io_sections_add(&r->sections, section, r->error);
}

/** Find the keyword of that name in text, or of that code in binary, and check that it may stand
 *  at that place. *keyword is -1 if it means nothing to planish. */
static int find_keyword(const medit_reader *r, io_slice name, int64_t code, int *keyword) {
    *keyword = -1;
    for (int i = 0; i < r->n_keywords && *keyword < 0; i++)
        if (r->model->is_binary ? r->keywords[i].code == code
                                : io_slice_is(name, r->keywords[i].type.name, 0))
            *keyword = i;
    if (*keyword < 0)
        return PLANISH_OK;
    const medit_keyword *k = &r->keywords[*keyword];
    const io_element_type *type = &k->type;
    if (io_element_use(type) == IO_REFUSE)
        return io_fail_order(r->model, name.begin, type->name, "", r->error);
    if (k->kind != MEDIT_VERTICES && !r->dim)
        return io_fail_at(r->model, name.begin, r->error, "%s before Dimension", type->name);
    return PLANISH_OK;
}

static int set_version(medit_reader *r, const char *at, int64_t version) {
    if (version < 0 || version > LAST_VERSION)
        return io_fail_at(r->model, at, r->error,
                          "MeshVersionFormatted %lld is unknown; 0 to 4 can be read",
                          (long long)version);
    /* Only texts have version 0: of programs that do not heed versions, and write doubles. */
    r->version = version == 0 ? 2 : (int)version;
    return PLANISH_OK;
}

static int set_dimension(medit_reader *r, const char *at, int64_t dim) {
    if (dim != 2 && dim != 3)
        return io_fail_at(r->model, at, r->error, "Dimension %lld is unknown; 2 and 3 can be read",
                          (long long)dim);
    r->dim = (int)dim;
    return PLANISH_OK;
}

/** Check the count of a section, whose records begin at the cursor. */
static int check_count(const medit_reader *r, io_cursor rest, int keyword, int64_t count) {
    const medit_keyword *k = &r->keywords[keyword];
    return io_check_count(r->model, rest, count, medit_record_size(r, k), k->type.name, r->error);
}

/* ---- text --------------------------------------------------------------------------------- */

/** Check the counts of all sections again: vertices may stand before the dimension, which says how long
 *  they are. end: of the text. */
static int check_counts(const medit_reader *r, const char *end) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < r->sections.n && !status; i++) {
        const io_section *s = &r->sections.section[i];
        status = check_count(r, (io_cursor){s->data, end}, s->keyword, s->count);
    }
    return status;
}

/** Return whether the count of a section is 0. */
static int begins_with_0(io_cursor cursor) {
    int64_t count;
    return io_integer(&cursor, &count) == 0 && count == 0;
}

/** Go from keyword to keyword, over what is between them. */
static int walk_text(medit_reader *r) {
    const io_model *model = r->model;
    io_cursor cursor = io_begin_text(model->input.data, model->input.size);
    r->real_size = r->integer_size = 2; /* a digit and a space */
    io_skip_numbers(&cursor);
    while (cursor.at < cursor.end) {
        const io_slice word = io_next_word(&cursor);
        const int is_version = io_slice_is(word, "MeshVersionFormatted", 0);
        const int is_dimension = io_slice_is(word, "Dimension", 0);
        int64_t number = 0;
        int keyword;
        if (io_slice_is(word, "End", 0))
            break;
        int status = find_keyword(r, word, 0, &keyword);
        if (status)
            return status;
        io_skip_space_comments(&cursor, '#');
        if ((is_version || is_dimension || keyword >= 0) && io_integer(&cursor, &number))
            return io_fail_at(model, cursor.at, r->error, "a whole number expected after %.*s",
                              (int)io_slice_length(word), word.begin);
        if (is_version)
            status = set_version(r, cursor.at, number);
        else if (is_dimension)
            status = set_dimension(r, cursor.at, number);
        else if (keyword >= 0)
            status = check_count(r, cursor, keyword, number);
        else if (!begins_with_0(cursor))
            status = note_passed_over(r, word, 0);
        if (status)
            return status;
        const char *data = cursor.at;
        io_skip_numbers(&cursor);
        if (keyword >= 0)
            status = add_section(r, (io_section){keyword, number, data, cursor.at, 0});
        if (status)
            return status;
    }
    if (!r->version)
        return io_fail_at(model, cursor.end, r->error,
                          "no MeshVersionFormatted: this is not a Medit mesh");
    return check_counts(r, cursor.end);
}

/* ---- binary ------------------------------------------------------------------------------- */

/** Read the first two words and the dimension's code. Return whether they are those of a mesh. */
static int begins_well(const char *data, int64_t size, int *swapped, int64_t *version) {
    if (size < 3 * WORD_SIZE)
        return 0;
    for (*swapped = 0; *swapped < 2; ++*swapped) {
        *version = io_load_i32(data + WORD_SIZE, *swapped);
        if (io_load_i32(data, *swapped) == 1)
            return *version >= 1 && *version <= LAST_VERSION &&
                   io_load_i32(data + 2 * WORD_SIZE, *swapped) == CODE_DIMENSION;
    }
    return 0;
}

static int64_t load_integer(const medit_reader *r, const char *at, int size) {
    return size == WORD_SIZE ? io_load_i32(at, r->swapped) : io_load_i64(at, r->swapped);
}

static int fail_cut(const medit_reader *r, const char *at, const char *what) {
    return io_fail_at(r->model, at, r->error, "the file ends where %s should be (it is cut short)",
                      what);
}

/** Find the next keyword, whose position is at at; position 0: there is none, and *next is the end
 *  of the file. The next keyword must be behind data. */
static int find_next(const medit_reader *r, const char *at, const char *data, int position_size,
                     const char **next) {
    const io_bytes *input = &r->model->input;
    if (data > io_input_end(r->model))
        return fail_cut(r, at, "a position");
    int64_t position = load_integer(r, at, position_size);
    position = position == 0 ? input->size : position;
    if (position > input->size)
        return io_fail_at(r->model, at, r->error,
                          "the next keyword should be at byte %lld, behind the end of the file "
                          "(it may be cut short)",
                          (long long)position);
    if (position < data - input->data)
        return io_fail_at(r->model, at, r->error,
                          "the next keyword should be at byte %lld, which is not behind this one",
                          (long long)position);
    *next = input->data + position;
    return PLANISH_OK;
}

/** Go from keyword to keyword by their positions. The dimension stands right behind the version. */
static int walk_binary(medit_reader *r) {
    io_model *model = r->model;
    const char *at = model->input.data, *end = io_input_end(model);
    int64_t version = 0;
    begins_well(at, model->input.size, &r->swapped, &version); /* recognised already */
    int status = set_version(r, at + WORD_SIZE, version);
    if (status)
        return status;
    const int position_size = version < 3 ? WORD_SIZE : 2 * WORD_SIZE;
    r->real_size = version == 1 ? (int)sizeof(float) : (int)sizeof(double);
    r->integer_size = version < 4 ? WORD_SIZE : 2 * WORD_SIZE;
    at += 3 * WORD_SIZE;
    if (end - at < position_size + WORD_SIZE)
        return fail_cut(r, at, "the dimension");
    at += position_size;
    status = set_dimension(r, at, io_load_i32(at, r->swapped));
    at += WORD_SIZE;
    while (!status && at < end) {
        const char *data = at + WORD_SIZE + position_size, *next = end;
        int keyword;
        if (end - at < WORD_SIZE)
            return fail_cut(r, at, "a keyword");
        const int64_t code = io_load_i32(at, r->swapped);
        if (code == CODE_END)
            break;
        status = find_next(r, at + WORD_SIZE, data, position_size, &next);
        if (!status)
            status = find_keyword(r, (io_slice){at, data}, code, &keyword);
        if (status)
            return status;
        at = next;
        if (keyword < 0) {
            const int is_empty =
                next - data == r->integer_size && load_integer(r, data, r->integer_size) == 0;
            status = is_empty ? PLANISH_OK : note_passed_over(r, (io_slice){NULL, NULL}, code);
            continue;
        }
        if (next - data < r->integer_size)
            return io_fail_at(model, data, r->error,
                              "there is no room for the number of %s before the next keyword",
                              r->keywords[keyword].type.name);
        const int64_t count = load_integer(r, data, r->integer_size);
        data += r->integer_size;
        status = check_count(r, (io_cursor){data, next}, keyword, count);
        if (!status)
            status = add_section(r, (io_section){keyword, count, data, next, 0});
    }
    return status;
}

/* ---- the format --------------------------------------------------------------------------- */

/** Return whether the bytes begin as those of a binary file do. */
static int begins_binary(const char *data, int64_t size) {
    int swapped;
    int64_t version;
    return begins_well(data, size, &swapped, &version);
}

int medit_find_sections(medit_reader *r) {
    io_model *model = r->model;
    model->is_binary = begins_binary(model->input.data, model->input.size);
    return model->is_binary ? walk_binary(r) : walk_text(r);
}

static int medit_read(io_model *model, planish_error *error) {
    medit_reader r = {.model = model,
                      .error = error,
                      .keywords = mesh_keywords,
                      .n_keywords = sizeof mesh_keywords / sizeof *mesh_keywords,
                      .n_orders = 1};
    r.order[0] = medit_usual_order[0];
    model->node_order = r.order;
    io_text_init(&r.text, model);
    int status = medit_find_sections(&r);
    for (int kind = 0; kind < MEDIT_N_KINDS && !status; kind++) {
        for (int64_t i = 0; i < r.sections.n && !status; i++)
            if (mesh_keywords[r.sections.section[i].keyword].kind == (medit_kind)kind)
                status = medit_read_section(&r, &r.sections.section[i]);
        if (!status && !model->xyz)
            status = io_fail_at(model, io_input_end(model), error,
                                "there are no Vertices (the file may be cut short)");
    }
    model->node_order = NULL; /* it is the reader's */
    io_text_release(&r.text);
    io_sections_release(&r.sections);
    return status;
}

static int medit_recognise(const char *data, int64_t size) {
    return io_slice_is(io_first_word(data, size), "MeshVersionFormatted", 0) ||
           begins_binary(data, size);
}

/** Return whether path may be the name of the output: other programs tell text from binary by it.
 */
static int may_be_called(const io_model *model, const char *path) {
    return (strcasecmp(io_extension(path), ".mesh") == 0) != model->is_binary;
}

static const char *const extensions[] = {".mesh", ".meshb", NULL};

const io_format io_format_medit = {.name = "medit",
                                   .extensions = extensions,
                                   .recognise = medit_recognise,
                                   .read = medit_read,
                                   .may_be_called = may_be_called,
                                   .targets = medit_targets};
