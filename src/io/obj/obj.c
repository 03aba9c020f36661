/* obj: Wavefront OBJ: vertices, polygons and polylines as text.
 *
 *     v X Y Z ...        a vertex; weights and colours behind its coordinates stay
 *     f A B C ...        a face: vertices as V, V/VT, V//VN or V/VT/VN, from 1, or from the last
 *                        vertex before the line backwards, from -1
 *     l A B ...          a polyline; p A ... points
 *     o, g, usemtl       object, groups and material of what follows
 *
 * '#' begins a comment, and '\' at its end continues a line. Triangles and quadrilaterals are
 * elements, larger polygons hold their nodes, as lines and points do. Objects, groups and materials
 * are groups by name; elements that differ in one of these are of different regions. Curves and
 * surfaces given by formulas, and calls of other files, are refused; all else is not looked at.
 */
#include "io/view/surface_write.h"
#include "io/core/bytes.h"
#include "io/core/format.h"
#include "io/core/number.h"
#include "io/core/records.h"

#include "base/hash.h"
#include "base/memory.h"
#include "base/status.h"

#include <stdlib.h>
#include <string.h>

enum { TRIANGLE = 3, QUADRILATERAL = 4, FIRST_SLOTS = 64 };

typedef enum obj_kind {
    OTHER,
    VERTEX,
    FACE,
    LINE,
    POINT,
    OBJECT,
    GROUP,
    MATERIAL,
    NORMAL,
    TEXTURE,
    REFUSED
} obj_kind;

/** Names of one kind that are in force, by their numbers. */
typedef struct obj_names {
    int32_t *number; /* [n] owned */
    int64_t n, capacity;
} obj_names;

typedef struct obj_reader {
    io_model *model;
    planish_error *error;
    int64_t n_seen, n_faces; /* vertices and faces before the cursor */
    obj_names names[3];      /* of the object, the groups, the material, */
    int64_t n_in_force;      /* and how many there were of all entities */
    int32_t entity[3];       /* of lines and faces by their dimension; -1: not made yet */
    int32_t *slot;           /* [n_slots] hash table of names: their numbers, or -1 */
    int64_t n_slots;
    pl_hash hash;
    int32_t n_names;
    int64_t *name_group; /* [n_names] one of model->group with that name */
    int64_t name_capacity;
} obj_reader;

/* ---- lines and words -------------------------------------------------------------------------- */

/** Return the bytes of the end of line that '\' at the cursor takes away; 0: there is none. */
static int continuation(const io_cursor *cursor) {
    const char *at = cursor->at;
    const int64_t left = cursor->end - at;
    if (left < 2 || *at != '\\')
        return 0;
    if (at[1] == '\r')
        return left > 2 && at[2] == '\n' ? 3 : 2;
    return at[1] == '\n' ? 2 : 0;
}

static void skip_blanks(io_cursor *cursor) {
    for (int n = 1; n > 0; cursor->at += n)
        n = cursor->at < cursor->end && io_is_blank(*cursor->at) ? 1 : continuation(cursor);
}

/** Take the line at the cursor, and those that it is continued by. */
static io_cursor next_line(io_cursor *cursor) {
    io_slice line = io_next_line(cursor);
    const char *begin = line.begin;
    while (line.end > line.begin && line.end[-1] == '\\' && cursor->at < cursor->end)
        line = io_next_line(cursor);
    return (io_cursor){begin, line.end};
}

/** Take the next word of a line; empty at its end and before a comment. */
static io_slice next_word(io_cursor *line) {
    skip_blanks(line);
    io_slice word = {line->at, line->at};
    if (line->at < line->end && *line->at == '#')
        return word;
    while (line->at < line->end && !io_is_space(*line->at) && continuation(line) == 0)
        line->at++;
    word.end = line->at;
    return word;
}

/** Take the first word of a line: what it is. */
static obj_kind take_kind(io_cursor *line) {
    static const struct {
        const char *word;
        obj_kind kind;
    } kinds[] = {{"v", VERTEX},        {"f", FACE},       {"vn", NORMAL},    {"l", LINE},
                 {"vt", TEXTURE},      {"p", POINT},      {"o", OBJECT},     {"g", GROUP},
                 {"usemtl", MATERIAL}, {"curv", REFUSED}, {"surf", REFUSED}, {"call", REFUSED},
                 {"bzp", REFUSED},     {"bsp", REFUSED},  {"cdc", REFUSED},  {"cdp", REFUSED},
                 {"res", REFUSED}};
    const io_slice word = next_word(line);
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (io_slice_is(word, kinds[i].word, 0))
            return kinds[i].kind;
    return OTHER;
}

/* ---- names ------------------------------------------------------------------------------------ */

/** Find the slot of a name, or the free one where it belongs. */
static int32_t *find_slot(const obj_reader *r, io_slice name) {
    pl_hash hash = r->hash;
    for (const char *c = name.begin; c < name.end; c++)
        pl_hash_add(&hash, (unsigned char)*c);
    for (uint64_t at = pl_hash_end(hash);; at++) {
        int32_t *slot = &r->slot[at & (uint64_t)(r->n_slots - 1)];
        if (*slot < 0 || io_slice_is(name, r->model->group[r->name_group[*slot]].name, 0))
            return slot;
    }
}

static io_slice name_of(const obj_reader *r, int32_t number) {
    const char *name = r->model->group[r->name_group[number]].name;
    return (io_slice){name, name + strlen(name)};
}

/** Keep the table at most half full. */
static int grow_slots(obj_reader *r) {
    if (2 * (int64_t)r->n_names < r->n_slots)
        return PLANISH_OK;
    const int64_t n = r->n_slots ? 2 * r->n_slots : FIRST_SLOTS;
    int32_t *slot = pl_alloc(n, sizeof *slot);
    if (!slot)
        return pl_fail_memory(r->error, "the groups of the file");
    memset(slot, -1, (size_t)n * sizeof *slot);
    pl_free(r->slot);
    r->slot = slot;
    r->hash = pl_hash_draw(slot);
    r->n_slots = n;
    for (int32_t i = 0; i < r->n_names; i++)
        *find_slot(r, name_of(r, i)) = i;
    return PLANISH_OK;
}

/** Find the number of a name, which becomes a group of faces and one of lines if it is new. */
static int find_name(obj_reader *r, io_slice name, int32_t *number) {
    io_model *model = r->model;
    int64_t n = r->n_names;
    int status = grow_slots(r);
    if (status)
        return status;
    int32_t *slot = find_slot(r, name);
    if (*slot < 0) {
        const int64_t group = model->n_groups;
        for (int dim = 1; dim <= 2 && !status; dim++)
            status =
                io_model_group(model, dim, r->n_names, name.begin, io_slice_length(name), r->error);
        if (status)
            return status;
        if (!pl_append(&r->name_group, &n, &r->name_capacity, &group, sizeof group))
            return pl_fail_memory(r->error, "the groups of the file");
        *slot = r->n_names++;
    }
    *number = *slot;
    return PLANISH_OK;
}

/** Let the names of a line be in force: those of groups are words, of which there may be several; of
 *  objects and materials the rest of the line. */
static int take_names(obj_reader *r, obj_kind kind, io_cursor *line) {
    obj_names *names = &r->names[kind - OBJECT];
    names->n = 0;
    r->entity[1] = r->entity[2] = -1;
    for (;;) {
        skip_blanks(line);
        const io_slice name =
            kind == GROUP ? next_word(line) : io_slice_trim((io_slice){line->at, line->end});
        int32_t number;
        if (io_slice_length(name) == 0)
            return PLANISH_OK;
        const int status = find_name(r, name, &number);
        if (status)
            return status;
        if (!pl_append(&names->number, &names->n, &names->capacity, &number, sizeof number))
            return pl_fail_memory(r->error, "the groups of the file");
        if (kind != GROUP)
            return PLANISH_OK;
    }
}

static int compare_numbers(const void *a, const void *b) {
    const int32_t p = *(const int32_t *)a, q = *(const int32_t *)b;
    return (p > q) - (p < q);
}

/** Count n names that are in force. Each entity keeps its own, and a file could change one of many over
 *  and over. */
static int count_names(obj_reader *r, int64_t n) {
    enum { PER_BYTE = 8, FREE = 1000000 };
    r->n_in_force += n;
    return r->n_in_force <= FREE + PER_BYTE * r->model->input.size
               ? PLANISH_OK
               : pl_fail(r->error, PLANISH_ERROR_FORMAT,
                         "%s: face %lld: there are too many groups in force, over and over",
                         r->model->input.path, (long long)r->n_faces);
}

/** Find the entity of elements of a dimension at the cursor: that of the names in force. */
static int find_entity(obj_reader *r, int dim, int32_t *entity) {
    int64_t n = 0, n_kept = 0;
    for (int k = 0; k < 3; k++)
        n += r->names[k].n;
    if (r->entity[dim] < 0) {
        const int status = count_names(r, n);
        if (status)
            return status;
        int32_t *all = pl_alloc(n, sizeof *all);
        if (!all)
            return pl_fail_memory(r->error, "the groups of the file");
        for (int k = 0, at = 0; k < 3; at += (int)r->names[k++].n)
            if (r->names[k].n > 0)
                memcpy(all + at, r->names[k].number, (size_t)r->names[k].n * sizeof *all);
        if (n > 0)
            qsort(all, (size_t)n, sizeof *all, compare_numbers);
        for (int64_t i = 0; i < n; i++)
            if (i == 0 || all[i] != all[i - 1])
                all[n_kept++] = all[i];
        r->entity[dim] = io_model_entity(r->model, dim, -1, (int)n_kept, all, r->error);
        pl_free(all);
    }
    *entity = r->entity[dim];
    return *entity < 0 ? *entity : PLANISH_OK;
}

/* ---- vertices and elements ---------------------------------------------------------------------- */

/** Find the field of a coordinate: io_format.field. */
static int obj_field(const io_model *model, io_cursor *cursor, int d, io_field *field) {
    (void)model;
    (void)d;
    skip_blanks(cursor);
    *field = (io_field){.begin = cursor->at};
    if (io_parse_real(&cursor->at, cursor->end, &field->value))
        return -1;
    field->end = cursor->at;
    return 0;
}

static int read_vertex(obj_reader *r, io_cursor *line) {
    io_model *model = r->model;
    const int64_t node = r->n_seen++;
    if (node >= model->n_nodes)
        return io_bytes_fail_changed(&model->input, r->error);
    skip_blanks(line);
    model->text_offset[node] = line->at - model->input.data;
    for (int d = 0; d < 3; d++) {
        io_field field;
        skip_blanks(line);
        const char *at = line->at;
        if (obj_field(model, line, d, &field) ||
            (line->at < line->end && !io_is_space(*line->at) && continuation(line) == 0))
            return io_fail_at(model, at, r->error,
                              "vertex %lld: three coordinates expected (the file may be cut short)",
                              (long long)node + 1);
        model->xyz[3 * node + d] = field.value;
        const int status = io_check_finite(model, field.value, node, at, r->error);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

/** Read the vertex of a face, line or point: the number before the first '/', as an index. */
static int read_index(const obj_reader *r, io_slice word, int64_t *node) {
    const io_model *model = r->model;
    const char *at = word.begin;
    int64_t number;
    int is_good = io_parse_integer(&at, word.end, &number) == 0;
    for (; at < word.end && is_good; at++)
        is_good = *at == '/' || *at == '-' || (*at >= '0' && *at <= '9');
    if (!is_good)
        return io_fail_at(model, word.begin, r->error,
                          "'%.*s' is not a vertex: numbers as in 1, 1/2, 1//3 or 1/2/3 expected",
                          IO_QUOTED(word));
    *node = number > 0 ? number - 1 : number < 0 && number >= -r->n_seen ? r->n_seen + number : -1;
    if (*node < 0 || *node >= model->n_nodes)
        return io_fail_at(
            model, word.begin, r->error,
            "there is no vertex %lld: the file has %lld, %lld of them before this line",
            (long long)number, (long long)model->n_nodes, (long long)r->n_seen);
    return PLANISH_OK;
}

/** Add the line from one node to the next of a polyline or a face of two corners. */
static int add_line(obj_reader *r, const int32_t *node) {
    int32_t entity;
    const int status = find_entity(r, 1, &entity);
    return status ? status
                  : io_cells_add(r->model, 1, node, entity, r->model->line.n + 1, r->error);
}

/** Read the vertices of a line of the file: its first ones make an element, where there are not too
 *  many, and hold their nodes else. */
static int read_element(obj_reader *r, obj_kind kind, io_cursor *line) {
    io_model *model = r->model;
    const int64_t number = kind == FACE ? ++r->n_faces : 0;
    const char *begin = line->at;
    int32_t node[QUADRILATERAL], entity = -1;
    int64_t n = 0, k = 0;
    int status = PLANISH_OK;
    for (io_slice word; !status && io_slice_length(word = next_word(line)) > 0; n++) {
        status = read_index(r, word, &k);
        if (status)
            break;
        if (kind == LINE && n > 0) {
            const int32_t ends[2] = {node[0], (int32_t)k};
            status = add_line(r, ends);
        }
        if (n < QUADRILATERAL)
            node[kind == LINE ? 0 : n] = (int32_t)k;
        if (kind == POINT)
            io_hold_node(model, k, IO_HELD_BY_POINT);
        for (int64_t i = 0; kind == FACE && n == QUADRILATERAL && i < n; i++)
            io_hold_node(model, node[i], IO_HELD_BY_OTHER);
        if (kind == FACE && n >= QUADRILATERAL)
            io_hold_node(model, k, IO_HELD_BY_OTHER);
    }
    if (status)
        return status;
    if (n == 0)
        return io_fail_at(model, begin, r->error,
                          "vertices expected in this line (the file may be cut short)");
    model->n_lower += kind == POINT;
    if (kind != FACE)
        return PLANISH_OK;
    if (n < TRIANGLE)
        return io_fail_at(model, begin, r->error,
                          "face %lld: three vertices or more expected (the file may be cut short)",
                          (long long)number);
    model->n_other += n >= QUADRILATERAL;
    if (n > QUADRILATERAL)
        return PLANISH_OK;
    status = find_entity(r, 2, &entity);
    if (!status && n == TRIANGLE)
        status = io_cells_add(model, 2, node, entity, number, r->error);
    else if (!status)
        status =
            io_model_add_other(model, PLANISH_CELL_QUADRILATERAL, node, entity, number, r->error);
    return status;
}

/* ---- the file ----------------------------------------------------------------------------------- */

static int read_line(obj_reader *r, io_cursor line) {
    const char *begin = line.at;
    const obj_kind kind = take_kind(&line);
    switch (kind) {
    case VERTEX:
        return read_vertex(r, &line);
    case FACE:
    case LINE:
    case POINT:
        return read_element(r, kind, &line);
    case OBJECT:
    case GROUP:
    case MATERIAL:
        return take_names(r, kind, &line);
    case REFUSED:
        return io_fail_at(r->model, begin, r->error,
                          "planish does not read curves and surfaces by formulas, nor calls of "
                          "other files; export the model as polygons");
    case NORMAL:
        r->model->has_normals = 1;
        return io_model_note_lost(r->model, 1, "normals of vertices", r->error);
    case TEXTURE:
        return io_model_note_lost(r->model, 1, "texture coordinates", r->error);
    case OTHER:
        break;
    }
    return PLANISH_OK;
}

static int read_lines(obj_reader *r) {
    io_model *model = r->model;
    io_cursor cursor = io_begin_text(model->input.data, model->input.size), ahead = cursor;
    int64_t n = 0;
    int status = PLANISH_OK;
    while (ahead.at < ahead.end) {
        io_cursor line = next_line(&ahead);
        n += take_kind(&line) == VERTEX;
    }
    model->groups_by_name = 1;
    status = io_model_make_nodes(model, n, (int)sizeof(double), 0, 0, NULL, r->error);
    model->first_number = 1;
    while (!status && cursor.at < cursor.end)
        status = read_line(r, next_line(&cursor));
    if (!status && r->n_seen < n)
        status = io_bytes_fail_changed(&model->input, r->error);
    io_reduce_cell_numbers(&model->triangle);
    return status;
}

static int obj_read(io_model *model, planish_error *error) {
    obj_reader r = {.model = model, .error = error, .entity = {-1, -1, -1}};
    const int status = read_lines(&r);
    for (int k = 0; k < 3; k++)
        pl_free(r.names[k].number);
    pl_free(r.slot);
    pl_free(r.name_group);
    return status;
}

/** Return whether the first line that is no comment begins with a word of the format, and a vertex or
 *  face follows. */
static int obj_recognise(const char *data, int64_t size) {
    static const char *const words[] = {"mtllib", "vp", "s", "usemap", "cstype", "deg"};
    io_cursor cursor = io_begin_text(data, size);
    while (cursor.at < cursor.end) {
        io_cursor line = next_line(&cursor), rest = line;
        const io_slice word = next_word(&line);
        const obj_kind kind = take_kind(&rest);
        int is_known = kind != OTHER || io_slice_length(word) == 0;
        for (size_t i = 0; i < sizeof words / sizeof *words; i++)
            is_known |= io_slice_is(word, words[i], 0);
        if (!is_known)
            return 0;
        int64_t ignored;
        double x[3];
        if (kind == VERTEX)
            return !io_real(&line, &x[0]) && !io_real(&line, &x[1]) && !io_real(&line, &x[2]);
        if (kind == FACE)
            return !io_integer(&line, &ignored);
    }
    return 0;
}

static const char *const extensions[] = {".obj", NULL};

const io_format io_format_obj = {.name = "obj",
                                 .extensions = extensions,
                                 .has_no_end = 1,
                                 .recognise = obj_recognise,
                                 .read = obj_read,
                                 .field = obj_field,
                                 .targets = obj_targets,
                                 .check_target = io_surface_check};
