/* medit: Medit's ASCII .mesh, versions 1 to 3.
 *
 * Keywords, each with a count and that many records; '#' begins a comment. Read are vertices,
 * edges, triangles and tetrahedra with their references, and which nodes anything else names: nodes
 * of edges, of other elements and of Corners, Ridges and Required... are held. All other keywords
 * are passed over. Coordinates of version 1 are single precision by definition (and read so by
 * Mmg).
 */
#include "io/records.h"

#include "base/memory.h"
#include "base/round.h"

#include <math.h>
#include <string.h>

/* ---- keywords ----------------------------------------------------------------------------- */

typedef enum kind {
    VERTICES,
    CELLS,    /* edges, triangles, tetrahedra: kept */
    ELEMENTS, /* others: nodes are held */
    MARKED,   /* indices of vertices, edges, triangles, tetrahedra: their nodes are held */
    REFUSED,
} kind;

typedef struct keyword {
    const char *name;
    kind kind;
    int nodes; /* of one record */
    int dim;   /* of what is meant */
} keyword;

static const keyword keywords[] = {
    {"Vertices", VERTICES, 0, 0},
    {"Triangles", CELLS, 3, 2},
    {"Tetrahedra", CELLS, 4, 3},
    {"Edges", CELLS, 2, 1},
    {"Quadrilaterals", ELEMENTS, 4, 2},
    {"Hexahedra", ELEMENTS, 8, 3},
    {"Prisms", ELEMENTS, 6, 3},
    {"Pyramids", ELEMENTS, 5, 3},
    {"Corners", MARKED, 1, 0},
    {"RequiredVertices", MARKED, 1, 0},
    {"RequiredEdges", MARKED, 1, 1},
    {"RequiredTriangles", MARKED, 1, 2},
    {"RequiredTetrahedra", MARKED, 1, 3},
    /* Ridges number edges, RequiredQuadrilaterals quadrilaterals: all held. */
    {"EdgesP2", REFUSED, 0, 0},
    {"TrianglesP2", REFUSED, 0, 0},
    {"TetrahedraP2", REFUSED, 0, 0},
};

/** Where a section's data begin. */
typedef struct section {
    const keyword *keyword;
    int64_t count;
    const char *data, *end; /* end: of the data, where the next keyword is */
} section;

typedef struct reader {
    io_model *model;
    planish_error *error;
    io_text text;
    int version, dim;
    section *sections; /* [n_sections] owned */
    int64_t n_sections, capacity;
    const section *current;
    int64_t first_cell; /* of the current section in its io_cells */
} reader;

static const keyword *find_keyword(const char *word, int64_t length) {
    for (size_t i = 0; i < sizeof keywords / sizeof *keywords; i++)
        if (io_word_is(word, length, keywords[i].name, 0))
            return &keywords[i];
    return NULL;
}

static int is_letter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

/** Skip blocks of bytes that hold nothing but numbers and white space. */
static void skip_numbers(io_cursor *cursor) {
    enum { BLOCK = 64 };
    while (cursor->end - cursor->at >= BLOCK) {
        int other = 0;
        for (int i = 0; i < BLOCK; i++)
            other |= (cursor->at[i] >= 'A') | (cursor->at[i] == '#') | (cursor->at[i] < 0);
        if (other)
            return;
        cursor->at += BLOCK;
    }
}

/** Skip to the next word that begins with a letter; nan and inf are no keywords. The cursor stands
 *  behind a word. */
static void skip_to_keyword(io_cursor *cursor) {
    while (cursor->at < cursor->end) {
        int64_t length;
        const char *block = cursor->at;
        skip_numbers(cursor);
        while (cursor->at > block && cursor->at < cursor->end && (unsigned char)*cursor->at > ' ' &&
               (unsigned char)cursor->at[-1] > ' ')
            cursor->at++; /* the rest of a number */
        io_skip_space_comments(cursor, '#');
        io_cursor before = *cursor;
        const char *word = io_word(cursor, &length);
        if (length && is_letter(*word) && !io_word_is(word, length, "nan", 1) &&
            !io_word_is(word, length, "inf", 1)) {
            *cursor = before;
            return;
        }
    }
}

/* ---- the sections of a file --------------------------------------------------------------- */

/** A number that belongs to a keyword. */
static int take_number(reader *r, io_cursor *cursor, const char *name, int64_t *value) {
    io_skip_space_comments(cursor, '#');
    if (io_integer(cursor, value))
        return io_fail_text(r->model, cursor->at, r->error, "a whole number expected after %s",
                            name);
    return PLANISH_OK;
}

/** Least bytes of a record: a digit and a space for each number. */
static int64_t least_bytes(const reader *r, const keyword *k) {
    if (k->kind == VERTICES)
        return 2 * (r->dim + 1);
    return k->kind == MARKED ? 2 : 2 * (k->nodes + 1);
}

static int add_section(reader *r, const keyword *k, io_cursor *cursor) {
    int64_t count;
    int status = take_number(r, cursor, k->name, &count);
    if (status)
        return status;
    int64_t left = cursor->end - cursor->at;
    /* The last number of a file needs no space behind it. */
    if (count < 0 || count > (left + 1) / least_bytes(r, k))
        return io_fail_text(r->model, cursor->at, r->error,
                            "%lld %s cannot be in the %lld bytes that are left; the count is wrong "
                            "or the file is cut short",
                            (long long)count, k->name, (long long)left);
    section *grown =
        pl_grow(r->sections, r->n_sections, r->n_sections + 1, &r->capacity, sizeof *grown);
    if (!grown)
        return io_fail_text(r->model, cursor->at, r->error, "out of memory for the sections");
    r->sections = grown;
    r->sections[r->n_sections++] = (section){k, count, cursor->at, cursor->end};
    return PLANISH_OK;
}

/** Known by content, a version and a dimension come first. */
static int read_header(reader *r, const char *word, int64_t length, io_cursor *cursor) {
    int64_t value;
    int is_version = io_word_is(word, length, "MeshVersionFormatted", 0);
    int status = take_number(r, cursor, is_version ? "MeshVersionFormatted" : "Dimension", &value);
    if (status)
        return status;
    if (is_version) {
        if (value < 1 || value > 4)
            return io_fail_text(r->model, cursor->at, r->error,
                                "MeshVersionFormatted %lld is unknown; 1 to 4 can be read",
                                (long long)value);
        r->version = (int)value;
    } else {
        if (value != 2 && value != 3)
            return io_fail_text(r->model, cursor->at, r->error,
                                "Dimension %lld is unknown; 2 and 3 can be read", (long long)value);
        r->dim = (int)value;
    }
    return PLANISH_OK;
}

/** Read one keyword and pass over what belongs to it; *done after End. */
static int walk_keyword(reader *r, io_cursor *cursor, int *done) {
    int64_t length;
    const char *word = io_word(cursor, &length);
    int status = PLANISH_OK;
    if (io_word_is(word, length, "End", 0)) {
        *done = 1;
        return PLANISH_OK;
    }
    if (io_word_is(word, length, "MeshVersionFormatted", 0) ||
        io_word_is(word, length, "Dimension", 0)) {
        status = read_header(r, word, length, cursor);
        skip_to_keyword(cursor);
        return status;
    }
    const keyword *k = find_keyword(word, length);
    if (k && k->kind == REFUSED)
        return io_fail_text(r->model, word, r->error,
                            "%s: elements of second order cannot be smoothed; export the mesh with "
                            "straight elements of first order",
                            k->name);
    if (k && k->kind != VERTICES && !r->dim)
        return io_fail_text(r->model, word, r->error, "%s before Dimension", k->name);
    if (k)
        status = add_section(r, k, cursor);
    if (status)
        return status;
    skip_to_keyword(cursor);
    if (k)
        r->sections[r->n_sections - 1].end = cursor->at;
    return PLANISH_OK;
}

static int walk_file(reader *r) {
    io_cursor cursor = {r->model->input.data, r->model->input.data + r->model->input.size};
    int status = PLANISH_OK, done = 0;
    skip_to_keyword(&cursor);
    while (!status && !done && cursor.at < cursor.end)
        status = walk_keyword(r, &cursor, &done);
    if (!status && !r->version)
        return io_fail_text(r->model, cursor.end, r->error,
                            "no MeshVersionFormatted: this is no Medit mesh");
    return status;
}

/* ---- records ------------------------------------------------------------------------------ */

/** Index from 1 .. limit, to 0 .. limit-1. */
static int take_index(const io_model *model, io_cursor *cursor, int64_t limit, const char *what,
                      int64_t record, planish_error *error, int64_t *index) {
    io_skip_space_comments(cursor, '#');
    if (io_integer(cursor, index))
        return io_fail_text(model, cursor->at, error,
                            "%s %lld: a whole number expected (the file may be cut short)", what,
                            (long long)record + 1);
    if (*index < 1 || *index > limit)
        return io_fail_text(model, cursor->at, error, "%s %lld: number %lld is not in 1 .. %lld",
                            what, (long long)record + 1, (long long)*index, (long long)limit);
    --*index;
    return PLANISH_OK;
}

static int take_reference(const io_model *model, io_cursor *cursor, const char *what,
                          int64_t record, planish_error *error, int32_t *reference) {
    int64_t value;
    io_skip_space_comments(cursor, '#');
    if (io_integer(cursor, &value) || value < INT32_MIN || value > INT32_MAX)
        return io_fail_text(model, cursor->at, error,
                            "%s %lld: a reference of 32 bits expected (the file may be cut short)",
                            what, (long long)record + 1);
    *reference = (int32_t)value;
    return PLANISH_OK;
}

static int read_vertices(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                         planish_error *error) {
    const reader *r = context;
    io_model *model = r->model;
    for (int64_t i = begin; i < end; i++) {
        double *xyz = model->xyz + 3 * i;
        io_skip_space_comments(cursor, '#');
        model->text_offset[i] = cursor->at - model->input.data;
        xyz[2] = 0;
        for (int d = 0; d < r->dim; d++) {
            double value;
            io_skip_space_comments(cursor, '#');
            if (io_real(cursor, &value))
                return io_fail_text(model, cursor->at, error,
                                    "vertex %lld: a coordinate expected (the file may be cut "
                                    "short)",
                                    (long long)i + 1);
            xyz[d] = model->precision == PLANISH_FLOAT ? pl_round_to_float(value) : value;
            if (!isfinite(xyz[d]))
                return io_fail_text(model, cursor->at, error,
                                    "vertex %lld has a coordinate that is not finite",
                                    (long long)i + 1);
        }
        int status = take_reference(model, cursor, "vertex", i, error, &model->node_entity[i]);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

static io_cells *cells_of(io_model *model, int dim) {
    return dim == 3 ? &model->tetrahedron : dim == 2 ? &model->triangle : &model->line;
}

static int read_cells(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                      planish_error *error) {
    const reader *r = context;
    const keyword *k = r->current->keyword;
    io_cells *cells = cells_of(r->model, k->dim);
    for (int64_t i = begin; i < end; i++) {
        int64_t cell = r->first_cell + i, node;
        for (int j = 0; j < k->nodes; j++) {
            int status = take_index(r->model, cursor, r->model->n_nodes, k->name, i, error, &node);
            if (status)
                return status;
            cells->nodes[cell * k->nodes + j] = (int32_t)node;
        }
        int status = take_reference(r->model, cursor, k->name, i, error, &cells->entity[cell]);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

static int read_elements(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                         planish_error *error) {
    const reader *r = context;
    const keyword *k = r->current->keyword;
    int32_t reference;
    for (int64_t i = begin; i < end; i++) {
        int64_t node;
        for (int j = 0; j < k->nodes; j++) {
            int status = take_index(r->model, cursor, r->model->n_nodes, k->name, i, error, &node);
            if (status)
                return status;
            io_hold_node(r->model, node, IO_HELD_BY_OTHER);
        }
        int status = take_reference(r->model, cursor, k->name, i, error, &reference);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

static int read_marked(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                       planish_error *error) {
    const reader *r = context;
    const keyword *k = r->current->keyword;
    const io_cells *cells = k->dim ? cells_of(r->model, k->dim) : NULL;
    for (int64_t i = begin; i < end; i++) {
        int64_t index;
        int status = take_index(r->model, cursor, cells ? cells->n : r->model->n_nodes, k->name, i,
                                error, &index);
        if (status)
            return status;
        for (int j = 0; cells && j <= k->dim; j++)
            io_hold_node(r->model, cells->nodes[index * (k->dim + 1) + j], IO_HELD_REQUIRED);
        if (!cells)
            io_hold_node(r->model, index, IO_HELD_REQUIRED);
    }
    return PLANISH_OK;
}

/* ---- sections ----------------------------------------------------------------------------- */

/** References to entities, in place: most often one number for long stretches. */
static int index_references(reader *r, int dim, int32_t *reference, int64_t n) {
    int32_t last = 0, entity = -1;
    for (int64_t i = 0; i < n; i++) {
        if (entity < 0 || reference[i] != last) {
            last = reference[i];
            entity = io_model_entity(r->model, dim, last, 0, NULL, r->error);
            if (entity < 0)
                return entity;
        }
        reference[i] = entity;
    }
    return PLANISH_OK;
}

static int read_records(reader *r, const section *s, int64_t tokens, io_records_fn *read) {
    io_cursor cursor = {s->data, r->model->input.data + r->model->input.size};
    r->current = s;
    int status = io_text_records(&r->text, &cursor, s->count, tokens, read, r, r->error);
    if (status)
        return status;
    io_skip_space_comments(&cursor, '#');
    if (cursor.at < s->end)
        return io_fail_text(r->model, cursor.at, r->error, "more than %lld %s follow",
                            (long long)s->count, s->keyword->name);
    return PLANISH_OK;
}

static int read_vertex_section(reader *r, const section *s) {
    io_model *model = r->model;
    if (model->xyz)
        return io_fail_text(model, s->data, r->error, "Vertices for the second time");
    int status = io_model_nodes(model, s->count, 1, r->error);
    if (status)
        return status;
    model->first_number = 1;
    model->columns = r->dim;
    model->precision = r->version == 1 ? PLANISH_FLOAT : PLANISH_DOUBLE;
    model->node_entity = pl_alloc(s->count, sizeof *model->node_entity);
    if (!model->node_entity)
        return io_fail_text(model, s->data, r->error, "out of memory for the vertices");
    status = io_model_span(model, (io_span){.n_nodes = s->count, .encoding = IO_TEXT}, r->error);
    if (!status)
        status = read_records(r, s, r->dim + 1, read_vertices);
    return status ? status : index_references(r, 0, model->node_entity, s->count);
}

static int read_cell_section(reader *r, const section *s) {
    const keyword *k = s->keyword;
    io_cells *cells = cells_of(r->model, k->dim);
    cells->first_number = 1;
    r->first_cell = cells->n;
    int status = io_cells_reserve(cells, k->dim, s->count, 1, 0, r->error);
    if (!status)
        status = read_records(r, s, k->nodes + 1, read_cells);
    if (!status)
        status = index_references(r, k->dim, cells->entity + r->first_cell, s->count);
    if (!status)
        cells->n += s->count;
    return status;
}

static int read_section(reader *r, const section *s) {
    const keyword *k = s->keyword;
    switch (k->kind) {
    case VERTICES:
        return read_vertex_section(r, s);
    case CELLS:
        return read_cell_section(r, s);
    case ELEMENTS:
        r->model->n_other += s->count;
        return read_records(r, s, k->nodes + 1, read_elements);
    default:
        return read_records(r, s, 1, read_marked);
    }
}

/** The sections of one kind, which may be anywhere in the file. */
static int read_sections(reader *r, kind wanted) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < r->n_sections && !status; i++)
        if (r->sections[i].keyword->kind == wanted)
            status = read_section(r, &r->sections[i]);
    return status;
}

static int read_all(reader *r) {
    int status = walk_file(r);
    if (!status)
        status = read_sections(r, VERTICES);
    if (!status && !r->model->xyz)
        return io_fail_text(r->model, r->model->input.data + r->model->input.size, r->error,
                            "there are no Vertices (the file may be cut short)");
    if (!status)
        status = read_sections(r, CELLS);
    if (!status)
        status = read_sections(r, ELEMENTS);
    return status ? status : read_sections(r, MARKED);
}

static int medit_read(io_model *model, planish_error *error) {
    reader r = {.model = model, .error = error};
    io_text_init(&r.text, model);
    int status = read_all(&r);
    io_text_release(&r.text);
    pl_free(r.sections);
    return status;
}

static int medit_recognise(const char *data, int64_t size) {
    io_cursor cursor = {data, data + size};
    int64_t length;
    io_skip_space_comments(&cursor, '#');
    const char *word = io_word(&cursor, &length);
    return io_word_is(word, length, "MeshVersionFormatted", 0);
}

static const char *const extensions[] = {".mesh", NULL};

const io_format io_format_medit = {
    .name = "medit", .extensions = extensions, .recognise = medit_recognise, .read = medit_read};
