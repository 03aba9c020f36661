/* ply: PLY, text and binary in either byte order: vertices and faces with any properties.
 *
 *     ply
 *     format ascii 1.0                     or binary_little_endian, binary_big_endian
 *     element vertex 8                     elements in any order, of any names
 *     property float x                     properties in any order; x, y, z one after the other
 *     element face 12
 *     property list uchar int vertex_indices
 *     end_header
 *
 * Vertices have x, y and z as float or double, faces a list vertex_indices or vertex_index. Faces of
 * two vertices are lines, triangles and quadrilaterals elements, others hold their nodes, and edges
 * (vertex1, vertex2) are lines. All else is passed over by its types. Vertices and faces are
 * numbered from 0.
 */
#include "io/view/surface_write.h"
#include "io/core/binary.h"
#include "io/core/format.h"
#include "io/core/number.h"
#include "io/core/records.h"

#include "base/memory.h"
#include "base/round.h"
#include "base/status.h"

#include <stdio.h>
#include <string.h>

enum { TRIANGLE = 3, QUADRILATERAL = 4, LINE = 2 };

/** Type of a number. */
typedef struct ply_type {
    const char *name, *other; /* of old and of new files */
    int size, is_real, is_unsigned;
} ply_type;

static const ply_type types[] = {{"char", "int8", 1, 0, 0},     {"uchar", "uint8", 1, 0, 1},
                                 {"short", "int16", 2, 0, 0},   {"ushort", "uint16", 2, 0, 1},
                                 {"int", "int32", 4, 0, 0},     {"uint", "uint32", 4, 0, 1},
                                 {"float", "float32", 4, 1, 0}, {"double", "float64", 8, 1, 0}};

/** Use of a property. */
typedef enum ply_role { NO_ROLE, X, Y, Z, CORNERS, FIRST_END, SECOND_END } ply_role;

typedef struct ply_property {
    const ply_type *type;
    const ply_type *count; /* of a list: of its length; else NULL */
    ply_role role;
} ply_property;

typedef enum ply_kind { OTHER, VERTEX, FACE, EDGE } ply_kind;

typedef struct ply_element {
    ply_kind kind;
    int64_t count, first, n; /* of them; properties first .. first + n - 1 */
    int64_t size;            /* binary: bytes of one, or of its shortest; text: numbers */
    int has_list;
    io_slice name;
} ply_element;

/** The header, which model->of_format keeps for ply_field. */
typedef struct ply_header {
    ply_property *property; /* [n_properties] owned */
    int64_t n_properties, property_capacity;
    ply_element *element; /* [n_elements] owned */
    int64_t n_elements, element_capacity;
    ply_element vertex;
} ply_header;

typedef struct ply_reader {
    io_model *model;
    planish_error *error;
    io_cursor cursor;
    ply_header *header;
    int swapped;
} ply_reader;

/* ---- the header ------------------------------------------------------------------------------- */

static const ply_type *find_type(io_slice name) {
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (io_slice_is(name, types[i].name, 0) || io_slice_is(name, types[i].other, 0))
            return &types[i];
    return NULL;
}

static int fail_line(const ply_reader *r, io_slice line, const char *what) {
    return io_fail_at(r->model, line.begin, r->error, "%s: '%.*s'", what, IO_QUOTED(line));
}

/** Take the format of numbers from the second line. */
static int take_format(ply_reader *r, io_slice line) {
    io_cursor words = {line.begin, line.end};
    const int is_format = io_slice_is(io_next_word(&words), "format", 0);
    const io_slice format = io_next_word(&words), version = io_next_word(&words);
    const int is_little = io_slice_is(format, "binary_little_endian", 0);
    const int is_binary = is_little || io_slice_is(format, "binary_big_endian", 0);
    if (!is_format || !(is_binary || io_slice_is(format, "ascii", 0)) ||
        !io_slice_is(version, "1.0", 0))
        return fail_line(r, line, "'format ascii 1.0' or a binary format expected");
    r->model->is_binary = is_binary;
    r->swapped = is_binary && is_little != io_machine_is_little();
    return PLANISH_OK;
}

static int take_element(ply_reader *r, io_cursor *words, io_slice line) {
    ply_header *h = r->header;
    ply_element e = {.first = h->n_properties, .name = io_next_word(words)};
    if (io_integer(words, &e.count) || e.count < 0)
        return fail_line(r, line, "a name and a number of elements expected");
    e.kind = io_slice_is(e.name, "vertex", 0) ? VERTEX
             : io_slice_is(e.name, "face", 0) ? FACE
             : io_slice_is(e.name, "edge", 0) ? EDGE
                                              : OTHER;
    for (int64_t i = 0; i < h->n_elements; i++)
        if (e.kind != OTHER && h->element[i].kind == e.kind)
            return fail_line(r, line, "these elements occur twice");
    if (io_slice_is(e.name, "tristrips", 0))
        return fail_line(r, line, "strips of triangles are not read; export the mesh as faces");
    return pl_append(&h->element, &h->n_elements, &h->element_capacity, &e, sizeof e)
               ? PLANISH_OK
               : pl_fail_memory(r->error, "the header of the file");
}

static ply_role find_role(ply_kind kind, io_slice name, int is_list) {
    static const struct {
        ply_kind kind;
        int is_list;
        const char *name;
        ply_role role;
    } roles[] = {{VERTEX, 0, "x", X},
                 {VERTEX, 0, "y", Y},
                 {VERTEX, 0, "z", Z},
                 {FACE, 1, "vertex_indices", CORNERS},
                 {FACE, 1, "vertex_index", CORNERS},
                 {EDGE, 0, "vertex1", FIRST_END},
                 {EDGE, 0, "vertex2", SECOND_END}};
    for (size_t i = 0; i < sizeof roles / sizeof *roles; i++)
        if (roles[i].kind == kind && roles[i].is_list == is_list &&
            io_slice_is(name, roles[i].name, 0))
            return roles[i].role;
    return NO_ROLE;
}

static int take_property(ply_reader *r, io_cursor *words, io_slice line) {
    ply_header *h = r->header;
    ply_property p = {.count = NULL};
    io_slice word = io_next_word(words);
    if (h->n_elements == 0)
        return fail_line(r, line, "a property of no element");
    ply_element *e = &h->element[h->n_elements - 1];
    const int is_list = io_slice_is(word, "list", 0);
    if (is_list) {
        p.count = find_type(io_next_word(words));
        word = io_next_word(words);
    }
    p.type = find_type(word);
    const io_slice name = io_next_word(words);
    if (!p.type || (is_list && (!p.count || p.count->is_real)) || io_slice_length(name) == 0)
        return fail_line(r, line, "a property of a known type expected");
    p.role = find_role(e->kind, name, is_list);
    for (int64_t i = 0; p.role != NO_ROLE && i < e->n; i++)
        if (h->property[e->first + i].role == p.role)
            return fail_line(r, line, "this property occurs twice");
    if (p.role > Z && p.type->is_real)
        return fail_line(r, line, "numbers of vertices as an integer type expected");
    r->model->has_normals |= e->kind == VERTEX && io_slice_is(name, "nx", 0);
    e->has_list |= is_list;
    e->size += !r->model->is_binary ? 1 : is_list ? p.count->size : p.type->size;
    e->n++;
    return pl_append(&h->property, &h->n_properties, &h->property_capacity, &p, sizeof p)
               ? PLANISH_OK
               : pl_fail_memory(r->error, "the header of the file");
}

/** Check that an element has the properties of the roles first .. last, in that order. */
static int has_roles(const ply_header *h, const ply_element *e, ply_role first, ply_role last) {
    int next = (int)first;
    for (int64_t i = 0; i < e->n; i++) {
        const int role = (int)h->property[e->first + i].role;
        if (role == next)
            next++;
        else if (role != (int)NO_ROLE)
            return 0;
    }
    return next == (int)last + 1;
}

/** Check that coordinates can be moved: floats or doubles, all of one type. */
static int check_vertices(const ply_reader *r, const ply_element *e) {
    const ply_header *h = r->header;
    const ply_type *type = NULL;
    if (!has_roles(h, e, X, Z))
        return fail_line(r, e->name, "properties x, y and z, in this order, expected of vertices");
    for (int64_t i = 0; i < e->n; i++) {
        const ply_property *p = &h->property[e->first + i];
        if (p->role == NO_ROLE)
            continue;
        if (!p->type->is_real || (type && p->type != type))
            return fail_line(r, e->name,
                             "coordinates of one type, float or double, expected of vertices");
        type = p->type;
    }
    return PLANISH_OK;
}

/** Find the vertices among the elements of the header, and check what they and the faces have. */
static int check_elements(ply_reader *r) {
    ply_header *h = r->header;
    const ply_element *vertex = NULL;
    for (int64_t i = 0; i < h->n_elements; i++) {
        const ply_element *e = &h->element[i];
        vertex = e->kind == VERTEX ? e : vertex;
        if (e->kind == FACE && !has_roles(h, e, CORNERS, CORNERS))
            return fail_line(r, e->name, "a list vertex_indices expected of faces");
    }
    if (!vertex)
        return io_fail_at(r->model, r->cursor.at, r->error, "no 'element vertex' in the header");
    h->vertex = *vertex;
    return check_vertices(r, vertex);
}

static int read_header(ply_reader *r) {
    int status = PLANISH_OK, is_first = 1;
    const io_slice mark = io_next_line(&r->cursor);
    if (!io_slice_is(io_slice_trim(mark), "ply", 0))
        return fail_line(r, mark, "no 'ply' in the first line: this is not a PLY file");
    for (;;) {
        if (r->cursor.at == r->cursor.end)
            return io_fail_at(r->model, r->cursor.at, r->error,
                              "no end_header (the file may be cut short)");
        const io_slice line = io_next_line(&r->cursor);
        io_cursor words = {line.begin, line.end};
        const io_slice word = io_next_word(&words);
        if (io_slice_is(word, "comment", 0) || io_slice_is(word, "obj_info", 0) ||
            io_slice_length(word) == 0)
            continue;
        if (is_first)
            status = take_format(r, line);
        else if (io_slice_is(word, "end_header", 0))
            break;
        else if (io_slice_is(word, "element", 0))
            status = take_element(r, &words, line);
        else if (io_slice_is(word, "property", 0))
            status = take_property(r, &words, line);
        else
            status = fail_line(r, line, "'element', 'property' or 'end_header' expected");
        if (status)
            return status;
        is_first = 0;
    }
    return check_elements(r);
}

/* ---- properties --------------------------------------------------------------------------------- */

/** Load a whole number of a type in a binary file. */
static int64_t load_whole(const char *at, const ply_type *type, int swapped) {
    const unsigned char byte = (unsigned char)*at;
    switch (type->size) {
    case 1:
        return type->is_unsigned || byte < 128 ? byte : (int64_t)byte - 256;
    case 2: {
        const int64_t value = io_load_u16(at, swapped);
        return type->is_unsigned || value < 32768 ? value : value - 65536;
    }
    default:
        return type->is_unsigned ? (int64_t)io_load_u32(at, swapped) : io_load_i32(at, swapped);
    }
}

/** Take a number as whole: 0 or -1. */
static int take_whole(const ply_reader *r, io_cursor *cursor, const ply_type *type,
                      int64_t *value) {
    if (!r->model->is_binary)
        return io_integer(cursor, value);
    if (io_left(cursor) < type->size)
        return -1;
    *value = load_whole(cursor->at, type, r->swapped);
    cursor->at += type->size;
    return 0;
}

/** Skip n numbers of a type: 0 or -1. */
static int skip_numbers(int is_binary, io_cursor *cursor, const ply_type *type, int64_t n) {
    if (is_binary) {
        if (n > io_left(cursor) / type->size)
            return -1;
        cursor->at += n * type->size;
        return 0;
    }
    for (; n > 0; n--)
        if (io_slice_length(io_next_word(cursor)) == 0)
            return -1;
    return 0;
}

static int fail_record(const ply_reader *r, const ply_element *e, int64_t i, const char *at,
                       planish_error *error) {
    return io_fail_at(
        r->model, at, error,
        "%.*s %lld: its numbers are missing or not whole numbers (the file may be cut short)",
        IO_QUOTED(e->name), (long long)i);
}

/** Take the length of a list of record i. */
static int take_length(const ply_reader *r, io_cursor *cursor, const ply_element *e,
                       const ply_property *p, int64_t i, int64_t *n) {
    if (!r->model->is_binary)
        io_skip_space(cursor);
    const char *at = cursor->at;
    if (take_whole(r, cursor, p->count, n))
        return fail_record(r, e, i, at, r->error);
    const int64_t room = io_left(cursor) / (r->model->is_binary ? p->type->size : 1);
    return *n >= 0 && *n <= room ? PLANISH_OK
                                 : io_fail_at(r->model, at, r->error,
                                              "%.*s %lld: a list of %lld numbers cannot be in "
                                              "the %lld bytes that are left",
                                              IO_QUOTED(e->name), (long long)i, (long long)*n,
                                              (long long)io_left(cursor));
}

/** Skip a property of record i. */
static int skip_property(const ply_reader *r, io_cursor *cursor, const ply_element *e,
                         const ply_property *p, int64_t i) {
    const char *at = cursor->at;
    int64_t n = 1;
    const int status = p->count ? take_length(r, cursor, e, p, i, &n) : PLANISH_OK;
    if (!status && skip_numbers(r->model->is_binary, cursor, p->type, n))
        return fail_record(r, e, i, at, r->error);
    return status;
}

/* ---- vertices ----------------------------------------------------------------------------------- */

/** Skip the properties in text between those of two roles: 0 or -1. */
static int skip_between(const ply_header *h, io_cursor *cursor, ply_role before, ply_role behind) {
    const ply_property *p = h->property + h->vertex.first;
    while (p->role != before)
        p++;
    for (p++; p->role != behind; p++) {
        int64_t n = 1;
        if ((p->count && io_integer(cursor, &n)) || n > io_left(cursor) ||
            skip_numbers(0, cursor, p->type, n))
            return -1;
    }
    return 0;
}

/** Find the field of coordinate d in text: io_format.field. */
static int ply_field(const io_model *model, io_cursor *cursor, int d, io_field *field) {
    static const ply_role roles[] = {X, Y, Z};
    if (d > 0 && skip_between(model->of_format, cursor, roles[d - 1], roles[d]))
        return -1;
    io_skip_space(cursor);
    *field = (io_field){.begin = cursor->at};
    if (io_parse_real(&cursor->at, cursor->end, &field->value))
        return -1;
    field->end = cursor->at;
    return 0;
}

/** Read coordinate d of node i in text; x notes the place. */
static int read_coordinate(const ply_reader *r, io_cursor *cursor, int64_t i, int d) {
    io_model *model = r->model;
    double value;
    io_skip_space(cursor);
    const char *at = cursor->at;
    if (d == 0)
        model->text_offset[i] = at - model->input.data;
    if (io_real(cursor, &value))
        return io_fail_at(model, at, r->error,
                          "vertex %lld: coordinate expected (the file may be cut short)",
                          (long long)i);
    value = model->precision == PLANISH_PRECISION_FLOAT ? pl_round_to_float(value) : value;
    model->xyz[3 * i + d] = value;
    return io_check_finite(model, value, i, at, r->error);
}

/** Load coordinate d of node i, and note its place: in a span of one or more coordinates. */
static int load_coordinate(const ply_reader *r, io_cursor *cursor, const ply_type *type, int64_t i,
                           int d) {
    io_model *model = r->model;
    const int64_t offset = cursor->at - model->input.data;
    io_span *last = model->n_spans > 0 ? &model->span[model->n_spans - 1] : NULL;
    if (io_left(cursor) < type->size)
        return fail_record(r, &r->header->vertex, i, cursor->at, r->error);
    const double value = type->size == 4 ? (double)io_load_f32(cursor->at, r->swapped)
                                         : io_load_f64(cursor->at, r->swapped);
    model->xyz[3 * i + d] = value;
    int status = io_check_finite(model, value, i, cursor->at, r->error);
    cursor->at += type->size;
    if (status)
        return status;
    if (d > 0 && last && last->offset + last->n_components * type->size == offset) {
        last->n_components++;
        return PLANISH_OK;
    }
    const io_span span = {.first_node = i,
                          .n_nodes = 1,
                          .encoding = type->size == 4 ? IO_FLOAT32 : IO_FLOAT64,
                          .swapped = r->swapped,
                          .offset = offset,
                          .component = d,
                          .n_components = 1};
    return io_model_span(model, span, r->error);
}

/** Read vertices one property after the other; each has its own place. */
static int read_records(const ply_reader *r, io_cursor *cursor, const ply_element *e) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < e->count && !status; i++)
        for (int64_t k = 0; k < e->n && !status; k++) {
            const ply_property *p = &r->header->property[e->first + k];
            if (p->role == NO_ROLE)
                status = skip_property(r, cursor, e, p, i);
            else if (r->model->is_binary)
                status = load_coordinate(r, cursor, p->type, i, (int)(p->role - X));
            else
                status = read_coordinate(r, cursor, i, (int)(p->role - X));
        }
    return status;
}

/** Find the byte of x in a vertex of constant size whose coordinates are side by side; or -1. */
static int64_t offset_of_x(const ply_header *h, const ply_element *e) {
    int64_t at = 0;
    int64_t i = 0;
    for (; h->property[e->first + i].role != X; i++)
        at += h->property[e->first + i].type->size;
    return !e->has_list && h->property[e->first + i + 1].role == Y &&
                   h->property[e->first + i + 2].role == Z
               ? at
               : -1;
}

static int read_vertices(ply_reader *r, const ply_element *e) {
    io_model *model = r->model;
    const ply_header *h = r->header;
    int64_t k = 0;
    while (h->property[e->first + k].role != X)
        k++;
    const int size = h->property[e->first + k].type->size;
    int status = io_check_count(model, r->cursor, e->count,
                                model->is_binary ? e->size : 2 * e->size, "vertices", r->error);
    if (status)
        return status;
    model->precision = size == 4 ? PLANISH_PRECISION_FLOAT : PLANISH_PRECISION_DOUBLE;
    const int64_t x = model->is_binary ? offset_of_x(h, e) : -1;
    if (x < 0 && model->is_binary) {
        status = io_model_alloc_nodes(model, e->count, 0, r->error);
        return status ? status : read_records(r, &r->cursor, e);
    }
    status =
        io_model_make_nodes(model, e->count, size, e->size, r->swapped, r->cursor.at + x, r->error);
    if (status || !model->is_binary)
        return status ? status : read_records(r, &r->cursor, e);
    for (int64_t i = 0; i < e->count && !status; i++)
        status = io_load_node(model, r->cursor.at + i * e->size + x, size, r->swapped, i, r->error);
    r->cursor.at += status ? 0 : e->count * e->size;
    return status;
}

/* ---- faces and edges ---------------------------------------------------------------------------- */

/** Take the index of a vertex. */
static int take_node(const ply_reader *r, io_cursor *cursor, const ply_element *e,
                     const ply_property *p, int64_t i, int64_t *node) {
    if (!r->model->is_binary)
        io_skip_space(cursor);
    const char *at = cursor->at;
    if (take_whole(r, cursor, p->type, node))
        return fail_record(r, e, i, at, r->error);
    return *node >= 0 && *node < r->header->vertex.count
               ? PLANISH_OK
               : io_fail_no_node(r->model, at, e->kind == FACE ? "face" : "edge", i, *node,
                                 r->error);
}

static int add_line(const ply_reader *r, const int32_t *end, int64_t number) {
    io_cells *lines = &r->model->line;
    const int status = io_cells_reserve(r->model, 1, 1, 0, 1, r->error);
    if (status)
        return status;
    memcpy(lines->nodes + LINE * lines->n, end, LINE * sizeof *end);
    lines->number[lines->n++] = number;
    return PLANISH_OK;
}

/** Read the corners of face i: an element, or nodes that are held. */
static int read_corners(const ply_reader *r, io_cursor *cursor, const ply_element *e,
                        const ply_property *p, int64_t i) {
    io_model *model = r->model;
    int32_t corner[QUADRILATERAL];
    int64_t n, node;
    int status = take_length(r, cursor, e, p, i, &n);
    const int is_element = n >= LINE && n <= QUADRILATERAL;
    for (int64_t k = 0; !status && k < n; k++) {
        status = take_node(r, cursor, e, p, i, &node);
        if (status)
            break;
        if (is_element)
            corner[k] = (int32_t)node;
        else
            io_hold_node(model, node, n == 1 ? IO_HELD_BY_POINT : IO_HELD_BY_OTHER);
    }
    if (status || n == 0)
        return status;
    if (n == TRIANGLE) {
        io_cells *triangles = &model->triangle;
        memcpy(triangles->nodes + TRIANGLE * triangles->n, corner, TRIANGLE * sizeof *corner);
        triangles->number[triangles->n++] = i;
        return PLANISH_OK;
    }
    if (n == LINE)
        return add_line(r, corner, i);
    *(n == 1 ? &model->n_lower : &model->n_other) += 1;
    return n == QUADRILATERAL ? io_model_add_other(model, PLANISH_CELL_QUADRILATERAL, corner,
                                                   IO_NO_ENTITY, i, r->error)
                              : PLANISH_OK;
}

/** Read one face or edge, or pass over another record. */
static int read_record(const ply_reader *r, const ply_element *e, io_cursor *cursor, int64_t i) {
    int32_t end[LINE];
    int n_ends = 0, status = PLANISH_OK;
    for (int64_t k = 0; k < e->n && !status; k++) {
        const ply_property *p = &r->header->property[e->first + k];
        int64_t node = -1;
        if (p->role == CORNERS) {
            status = read_corners(r, cursor, e, p, i);
        } else if (p->role != NO_ROLE) {
            status = take_node(r, cursor, e, p, i, &node);
            end[n_ends++] = (int32_t)node;
        } else {
            status = skip_property(r, cursor, e, p, i);
        }
    }
    return !status && n_ends == LINE ? add_line(r, end, i) : status;
}

/** Read faces or edges. */
static int read_cells(ply_reader *r, const ply_element *e) {
    io_model *model = r->model;
    const int is_face = e->kind == FACE;
    int status =
        io_check_count(model, r->cursor, e->count, model->is_binary ? e->size : 2 * e->size,
                       is_face ? "faces" : "edges", r->error);
    if (!status && is_face)
        status = io_cells_reserve(model, 2, e->count, 0, 1, r->error);
    for (int64_t i = 0; i < e->count && !status; i++)
        status = read_record(r, e, &r->cursor, i);
    return status;
}

/** Pass over elements, whatever they are. */
static int pass_over(ply_reader *r, const ply_element *e) {
    const int is_binary = r->model->is_binary;
    int status = io_check_room(r->model, r->cursor, e->count, is_binary ? e->size : 2 * e->size,
                               "elements", r->error);
    if (!status && is_binary && !e->has_list) {
        r->cursor.at += e->count * e->size;
        return PLANISH_OK;
    }
    for (int64_t i = 0; i < e->count && !status; i++)
        for (int64_t k = 0; k < e->n && !status; k++)
            status = skip_property(r, &r->cursor, e, &r->header->property[e->first + k], i);
    return status;
}

/** Note properties and elements that are passed over. */
static int note_lost(const ply_reader *r) {
    static const char *const texts[] = {"", "properties of vertices", "properties of faces",
                                        "properties of edges"};
    const ply_header *h = r->header;
    int status = PLANISH_OK;
    for (int64_t i = 0; i < h->n_elements && !status; i++) {
        const ply_element *e = &h->element[i];
        char text[64];
        int n_unused = 0;
        for (int64_t k = 0; k < e->n; k++)
            n_unused += h->property[e->first + k].role == NO_ROLE;
        snprintf(text, sizeof text, "elements '%.*s'", IO_QUOTED(e->name));
        status = io_model_note_lost(r->model, n_unused > 0 && e->count > 0,
                                    e->kind == OTHER ? text : texts[e->kind], r->error);
    }
    return status;
}

/* ---- the format ----------------------------------------------------------------------------------- */

/** Read elements in the file's order, but faces and edges that stand before vertices last. */
static int read_elements(ply_reader *r) {
    io_model *model = r->model;
    const ply_header *h = r->header;
    io_cursor early[2];
    const ply_element *early_element[2];
    int n_early = 0, status = PLANISH_OK;
    for (int64_t i = 0; i < h->n_elements && !status; i++) {
        const ply_element *e = &h->element[i];
        const int has_nodes = e->kind == FACE || e->kind == EDGE;
        if (e->n == 0)
            continue;
        if (has_nodes && !model->hold) {
            early[n_early] = r->cursor;
            early_element[n_early++] = e;
        }
        status = e->kind == VERTEX          ? read_vertices(r, e)
                 : has_nodes && model->hold ? read_cells(r, e)
                                            : pass_over(r, e);
    }
    while (!status && r->cursor.at < r->cursor.end &&
           (io_is_space(*r->cursor.at) || (model->is_binary && *r->cursor.at == '\0')))
        r->cursor.at++;
    if (!status && io_left(&r->cursor) > 0)
        return io_fail_at(model, r->cursor.at, r->error,
                          "more follows than the elements that the header counts");
    for (int i = 0; i < n_early && !status; i++) {
        r->cursor = early[i];
        status = read_cells(r, early_element[i]);
    }
    io_reduce_cell_numbers(&model->triangle);
    return status;
}

static int ply_read(io_model *model, planish_error *error) {
    ply_reader r = {.model = model,
                    .error = error,
                    .cursor = io_begin_text(model->input.data, model->input.size),
                    .header = pl_alloc_zero(1, sizeof(ply_header))};
    model->of_format = r.header;
    if (!r.header)
        return pl_fail_memory(error, "the header of the file");
    int status = read_header(&r);
    if (!status)
        status = read_elements(&r);
    return status ? status : note_lost(&r);
}

static int ply_recognise(const char *data, int64_t size) {
    io_cursor cursor = io_begin_text(data, size);
    const io_slice line = io_slice_trim(io_next_line(&cursor));
    return io_slice_is(line, "ply", 0);
}

static void ply_release(io_model *model) {
    ply_header *h = model->of_format;
    if (h) {
        pl_free(h->property);
        pl_free(h->element);
    }
    pl_free(h);
}

static const char *const extensions[] = {".ply", NULL};

const io_format io_format_ply = {.name = "ply",
                                 .extensions = extensions,
                                 .has_no_end = 1,
                                 .recognise = ply_recognise,
                                 .read = ply_read,
                                 .field = ply_field,
                                 .release = ply_release,
                                 .targets = ply_targets,
                                 .check_target = io_surface_check};
