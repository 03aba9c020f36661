/* medit: Medit's meshes, ASCII (.mesh) and binary (.meshb), versions 1 to 4.
 *
 * Read are vertices, edges, triangles and tetrahedra with their references, and which nodes
 * anything else names: nodes of edges, of other elements and of Corners, Ridges and Required...
 * are held. All other keywords are passed over. Coordinates of version 1 are single precision by
 * definition (and read so by Mmg).
 *
 * Here is what sections mean; medit_text.c and medit_binary.c find them.
 */
#include "io/core/format.h"
#include "io/medit/medit.h"

#include "base/memory.h"
#include "base/round.h"
#include "base/status.h"
#include "io/core/binary.h"

#include <math.h>
#include <strings.h>

/* ---- keywords ----------------------------------------------------------------------------- */

/* Codes are libMeshb's (GmfKwdCod), that of RequiredTetrahedra is Mmg's. */
static const medit_keyword keywords[] = {
    {"Vertices", 4, MEDIT_VERTICES, 0, 0},
    {"Triangles", 6, MEDIT_CELLS, 3, 2},
    {"Tetrahedra", 8, MEDIT_CELLS, 4, 3},
    {"Edges", 5, MEDIT_CELLS, 2, 1},
    {"Quadrilaterals", 7, MEDIT_ELEMENTS, 4, 2},
    {"Hexahedra", 10, MEDIT_ELEMENTS, 8, 3},
    {"Prisms", 9, MEDIT_ELEMENTS, 6, 3},
    {"Pyramids", 49, MEDIT_ELEMENTS, 5, 3},
    {"QuadrilateralsQ2", 27, MEDIT_ELEMENTS, 9, 2},
    {"HexahedraQ2", 33, MEDIT_ELEMENTS, 27, 3},
    {"PrismsP2", 86, MEDIT_ELEMENTS, 18, 3},
    {"PyramidsP2", 87, MEDIT_ELEMENTS, 14, 3},
    {"Corners", 13, MEDIT_MARKED, 1, 0},
    {"RequiredVertices", 15, MEDIT_MARKED, 1, 0},
    {"RequiredEdges", 16, MEDIT_MARKED, 1, 1},
    {"RequiredTriangles", 17, MEDIT_MARKED, 1, 2},
    {"RequiredTetrahedra", 12, MEDIT_MARKED, 1, 3},
    /* Ridges number edges, RequiredQuadrilaterals quadrilaterals: all held. */
    {"PeriodicVertices", 82, MEDIT_PAIRS, 2, 0},
    {"EdgesP2", 25, MEDIT_REFUSED, 0, 1},
    {"TrianglesP2", 24, MEDIT_REFUSED, 0, 2},
    {"TetrahedraP2", 30, MEDIT_REFUSED, 0, 3},
    {"EdgesP3", 92, MEDIT_REFUSED, 0, 1},
    {"TrianglesP3", 90, MEDIT_REFUSED, 0, 2},
    {"TetrahedraP3", 96, MEDIT_REFUSED, 0, 3},
    {"EdgesP4", 93, MEDIT_REFUSED, 0, 1},
    {"TrianglesP4", 91, MEDIT_REFUSED, 0, 2},
    {"TetrahedraP4", 97, MEDIT_REFUSED, 0, 3},
};
enum { N_KEYWORDS = sizeof keywords / sizeof *keywords };

const medit_keyword *medit_find_name(const char *word, int64_t length) {
    for (int i = 0; i < N_KEYWORDS; i++)
        if (io_word_is(word, length, keywords[i].name, 0))
            return &keywords[i];
    return NULL;
}

const medit_keyword *medit_find_code(int64_t code) {
    for (int i = 0; i < N_KEYWORDS; i++)
        if (keywords[i].code == code)
            return &keywords[i];
    return NULL;
}

int medit_integers_of(const medit_keyword *k) {
    /* Vertices and elements have a reference. */
    return k->kind == MEDIT_MARKED || k->kind == MEDIT_PAIRS ? k->nodes : k->nodes + 1;
}

/* ---- what the walks note ------------------------------------------------------------------ */

int medit_set_version(medit_reader *r, const char *at, int64_t version) {
    if (version < 0 || version > 4)
        return io_fail_at(r->model, at, r->error,
                          "MeshVersionFormatted %lld is unknown; 0 to 4 can be read",
                          (long long)version);
    /* Only texts have version 0: of programs that do not heed versions, and write doubles. */
    r->version = version == 0 ? 2 : (int)version;
    return PLANISH_OK;
}

int medit_set_dimension(medit_reader *r, const char *at, int64_t dim) {
    if (dim != 2 && dim != 3)
        return io_fail_at(r->model, at, r->error, "Dimension %lld is unknown; 2 and 3 can be read",
                          (long long)dim);
    r->dim = (int)dim;
    return PLANISH_OK;
}

int medit_check_keyword(const medit_reader *r, const char *at, const medit_keyword *k) {
    if (k->kind == MEDIT_REFUSED)
        return io_fail_at(r->model, at, r->error,
                          "%s: elements of second or higher order cannot be smoothed; export the "
                          "mesh with straight elements of first order",
                          k->name);
    if (k->kind != MEDIT_VERTICES && !r->dim)
        return io_fail_at(r->model, at, r->error, "%s before Dimension", k->name);
    return PLANISH_OK;
}

int medit_add_section(medit_reader *r, const medit_keyword *k, int64_t count, const char *data,
                      const char *end) {
    medit_section *grown =
        pl_grow(r->sections, r->n_sections, r->n_sections + 1, &r->capacity, sizeof *grown);
    if (!grown)
        return pl_fail_memory(r->error, "the sections of the file");
    r->sections = grown;
    r->sections[r->n_sections++] = (medit_section){k, count, data, end};
    return PLANISH_OK;
}

/* ---- numbers ------------------------------------------------------------------------------ */

/** The next whole number; -1 if there is none. */
static inline int take_integer(const medit_reader *r, io_cursor *cursor, int64_t *value) {
    if (r->model->is_binary) {
        *value = r->integer_size == 4 ? io_load_i32(cursor->at, r->swapped)
                                      : io_load_i64(cursor->at, r->swapped);
        cursor->at += r->integer_size;
        return 0;
    }
    io_skip_space_comments(cursor, '#');
    return io_integer(cursor, value);
}

static inline int take_real(const medit_reader *r, io_cursor *cursor, double *value) {
    if (r->model->is_binary) {
        *value = r->real_size == 4 ? (double)io_load_f32(cursor->at, r->swapped)
                                   : io_load_f64(cursor->at, r->swapped);
        cursor->at += r->real_size;
        return 0;
    }
    io_skip_space_comments(cursor, '#');
    return io_real(cursor, value);
}

/** Index from 1 .. limit, to 0 .. limit-1. */
static int take_index(const medit_reader *r, io_cursor *cursor, int64_t limit, const char *what,
                      int64_t record, planish_error *error, int64_t *index) {
    const char *at = cursor->at;
    if (take_integer(r, cursor, index))
        return io_fail_at(r->model, cursor->at, error,
                          "%s %lld: a whole number expected (the file may be cut short)", what,
                          (long long)record + 1);
    if (*index < 1 || *index > limit)
        return io_fail_at(r->model, r->model->is_binary ? at : cursor->at, error,
                          "%s %lld: number %lld is not in 1 .. %lld", what, (long long)record + 1,
                          (long long)*index, (long long)limit);
    --*index;
    return PLANISH_OK;
}

static int take_reference(const medit_reader *r, io_cursor *cursor, const char *what,
                          int64_t record, planish_error *error, int32_t *reference) {
    int64_t value;
    if (take_integer(r, cursor, &value) || value < INT32_MIN || value > INT32_MAX)
        return io_fail_at(r->model, cursor->at, error,
                          "%s %lld: a reference of 32 bits expected (the file may be cut short)",
                          what, (long long)record + 1);
    *reference = (int32_t)value;
    return PLANISH_OK;
}

/* ---- records ------------------------------------------------------------------------------ */

static int read_vertices(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                         planish_error *error) {
    const medit_reader *r = context;
    io_model *model = r->model;
    for (int64_t i = begin; i < end; i++) {
        double *xyz = model->xyz + 3 * i;
        if (!r->model->is_binary) {
            io_skip_space_comments(cursor, '#');
            model->text_offset[i] = cursor->at - model->input.data;
        }
        xyz[2] = 0;
        for (int d = 0; d < r->dim; d++) {
            const char *at = cursor->at;
            double value;
            if (take_real(r, cursor, &value))
                return io_fail_at(r->model, cursor->at, error,
                                  "vertex %lld: a coordinate expected (the file may be cut short)",
                                  (long long)i + 1);
            xyz[d] = model->precision == PLANISH_FLOAT ? pl_round_to_float(value) : value;
            if (!isfinite(xyz[d]))
                return io_fail_at(r->model, r->model->is_binary ? at : cursor->at, error,
                                  "vertex %lld has a coordinate that is not finite",
                                  (long long)i + 1);
        }
        int status = take_reference(r, cursor, "vertex", i, error, &model->node_entity[i]);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

static int read_cells(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                      planish_error *error) {
    const medit_reader *r = context;
    const medit_keyword *k = r->current->keyword;
    io_cells *cells = io_model_cells(r->model, k->dim);
    for (int64_t i = begin; i < end; i++) {
        int64_t cell = r->first_cell + i, node;
        for (int j = 0; j < k->nodes; j++) {
            int status = take_index(r, cursor, r->model->n_nodes, k->name, i, error, &node);
            if (status)
                return status;
            cells->nodes[cell * k->nodes + j] = (int32_t)node;
        }
        int status = take_reference(r, cursor, k->name, i, error, &cells->entity[cell]);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

static int read_elements(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                         planish_error *error) {
    const medit_reader *r = context;
    const medit_keyword *k = r->current->keyword;
    int32_t reference;
    for (int64_t i = begin; i < end; i++) {
        int64_t node;
        for (int j = 0; j < k->nodes; j++) {
            int status = take_index(r, cursor, r->model->n_nodes, k->name, i, error, &node);
            if (status)
                return status;
            io_hold_node(r->model, node, IO_HELD_BY_OTHER);
        }
        int status = take_reference(r, cursor, k->name, i, error, &reference);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

static int read_marked(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                       planish_error *error) {
    const medit_reader *r = context;
    const medit_keyword *k = r->current->keyword;
    const io_cells *cells = k->dim ? io_model_cells(r->model, k->dim) : NULL;
    for (int64_t i = begin; i < end; i++) {
        int64_t index;
        int status =
            take_index(r, cursor, cells ? cells->n : r->model->n_nodes, k->name, i, error, &index);
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

static int read_text_records(medit_reader *r, const medit_section *s, io_records_fn *read) {
    const int tokens =
        medit_integers_of(s->keyword) + (s->keyword->kind == MEDIT_VERTICES ? r->dim : 0);
    io_cursor cursor = {s->data, r->model->input.data + r->model->input.size};
    int status = io_text_records(&r->text, &cursor, s->count, tokens, read, r, r->error);
    if (status)
        return status;
    io_skip_space_comments(&cursor, '#');
    if (cursor.at < s->end)
        return io_fail_at(r->model, cursor.at, r->error, "more than %lld %s follow",
                          (long long)s->count, s->keyword->name);
    return PLANISH_OK;
}

static int read_records(medit_reader *r, const medit_section *s, io_records_fn *read) {
    r->current = s;
    if (!r->model->is_binary)
        return read_text_records(r, s, read);
    io_cursor cursor = {s->data, s->end};
    return io_binary_records(r->model->threads, &cursor, s->count, medit_binary_size(r, s->keyword),
                             read, r, r->error);
}

static io_span span_of(const medit_reader *r, const medit_section *s) {
    io_span span = {.n_nodes = s->count, .encoding = IO_TEXT};
    if (r->model->is_binary)
        span = (io_span){.n_nodes = s->count,
                         .encoding = r->real_size == 4 ? IO_FLOAT32 : IO_FLOAT64,
                         .swapped = r->swapped,
                         .offset = s->data - r->model->input.data,
                         .stride = medit_binary_size(r, s->keyword)};
    return span;
}

static int read_vertex_section(medit_reader *r, const medit_section *s) {
    io_model *model = r->model;
    if (model->xyz)
        return io_fail_at(r->model, s->data, r->error, "Vertices for the second time");
    int status = io_model_nodes(model, s->count, !r->model->is_binary, r->error);
    if (status)
        return status;
    model->first_number = 1;
    model->columns = r->dim;
    model->precision = r->version == 1 ? PLANISH_FLOAT : PLANISH_DOUBLE;
    model->node_entity = pl_alloc(s->count, sizeof *model->node_entity);
    if (!model->node_entity)
        return pl_fail_memory(r->error, "the vertices of the file");
    status = io_model_span(model, span_of(r, s), r->error);
    if (!status)
        status = read_records(r, s, read_vertices);
    return status ? status
                  : io_model_index_tags(r->model, 0, model->node_entity, s->count, r->error);
}

static int read_cell_section(medit_reader *r, const medit_section *s) {
    const medit_keyword *k = s->keyword;
    io_cells *cells = io_model_cells(r->model, k->dim);
    cells->first_number = 1;
    r->first_cell = cells->n;
    int status = io_cells_reserve(cells, k->dim, s->count, 1, 0, r->error);
    if (!status)
        status = read_records(r, s, read_cells);
    if (!status)
        status = io_model_index_tags(r->model, k->dim, cells->entity + r->first_cell, s->count,
                                     r->error);
    if (!status)
        cells->n += s->count;
    return status;
}

static int read_pairs(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                      planish_error *error) {
    const medit_reader *r = context;
    for (int64_t i = begin; i < end; i++) {
        int32_t pair[2];
        for (int j = 0; j < 2; j++) {
            int64_t node;
            int status = take_index(r, cursor, r->model->n_nodes, r->current->keyword->name, i,
                                    error, &node);
            if (status)
                return status;
            io_hold_node(r->model, node, IO_HELD_PERIODIC);
            pair[j] = (int32_t)node;
        }
        int status = pair[0] == pair[1] ? PLANISH_OK : io_model_pair(r->model, pair, error);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

/** In order, as the list of pairs grows. */
static int read_pair_section(medit_reader *r, const medit_section *s) {
    io_cursor cursor = {s->data, r->model->input.data + r->model->input.size};
    r->current = s;
    return read_pairs(r, &cursor, 0, s->count, r->error);
}

static int read_section(medit_reader *r, const medit_section *s) {
    const medit_keyword *k = s->keyword;
    switch (k->kind) {
    case MEDIT_VERTICES:
        return read_vertex_section(r, s);
    case MEDIT_CELLS:
        return read_cell_section(r, s);
    case MEDIT_ELEMENTS:
        r->model->n_other += s->count;
        return read_records(r, s, read_elements);
    case MEDIT_MARKED:
        return read_records(r, s, read_marked);
    default:
        return read_pair_section(r, s);
    }
}

/** The sections of one kind, which may be anywhere in the file. */
static int read_sections(medit_reader *r, medit_kind wanted) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < r->n_sections && !status; i++)
        if (r->sections[i].keyword->kind == wanted)
            status = read_section(r, &r->sections[i]);
    return status;
}

static int read_all(medit_reader *r) {
    int status = r->model->is_binary ? medit_binary_walk(r) : medit_text_walk(r);
    if (!status)
        status = read_sections(r, MEDIT_VERTICES);
    if (!status && !r->model->xyz)
        return io_fail_at(r->model, r->model->input.data + r->model->input.size, r->error,
                          "there are no Vertices (the file may be cut short)");
    if (!status)
        status = read_sections(r, MEDIT_CELLS);
    if (!status)
        status = read_sections(r, MEDIT_ELEMENTS);
    if (!status)
        status = read_sections(r, MEDIT_MARKED);
    if (!status)
        status = read_sections(r, MEDIT_PAIRS);
    return status;
}

static int medit_read(io_model *model, planish_error *error) {
    medit_reader r = {.model = model, .error = error};
    model->is_binary = medit_binary_recognise(model->input.data, model->input.size);
    io_text_init(&r.text, model);
    int status = read_all(&r);
    io_text_release(&r.text);
    pl_free(r.sections);
    return status;
}

static int medit_recognise(const char *data, int64_t size) {
    io_cursor cursor = io_begin_text(data, size);
    int64_t length;
    io_skip_space_comments(&cursor, '#');
    const char *word = io_word(&cursor, &length);
    return io_word_is(word, length, "MeshVersionFormatted", 0) ||
           medit_binary_recognise(data, size);
}

/** Other programs tell text from binary by the name. */
static int medit_may_be_called(const io_model *model, const char *path) {
    const int is_text = model->text_offset != NULL;
    return (strcasecmp(io_extension(path), ".mesh") == 0) == is_text;
}

static const char *const extensions[] = {".mesh", ".meshb", NULL};

const io_format io_format_medit = {.name = "medit",
                                   .extensions = extensions,
                                   .recognise = medit_recognise,
                                   .read = medit_read,
                                   .may_be_called = medit_may_be_called};
