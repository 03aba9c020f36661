/* mfem: MFEM's meshes, v1.0 to v1.3, of two and three dimensions.
 *
 * Sections in a fixed order: dimension, elements, boundary, vertices, and, of curved meshes, nodes
 * in place of coordinates; v1.3 has named sets of attributes behind elements and behind boundary. A
 * first walk finds where the elements are, as the number of vertices stands behind them. '#' begins
 * a comment. All numbers are counted from 0.
 *
 * A group is an attribute of elements, or of boundary elements, or a named set of attributes. In a
 * part of a parallel mesh (mfem_serial_mesh_end) the vertices shared with others hold their nodes.
 */
#include "io/core/format.h"
#include "io/mfem/mfem_reader.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

/* ---- the first line ------------------------------------------------------------------------- */

/** Kinds of MFEM's files by their first line; remedy: why they are refused, or NULL. */
static const struct {
    const char *name;
    int version;
    const char *remedy;
} kinds[] = {
    {"MFEM mesh v1.0", 10, NULL},
    {"MFEM mesh v1.1", 11, NULL}, /* unless it has hanging nodes */
    {"MFEM mesh v1.2", 12, NULL},
    {"MFEM mesh v1.3", 13, NULL},
    {"MFEM INLINE", 0,
     "says how MFEM makes a mesh, and has no nodes; open it in MFEM and save it (mesh.Save)"},
    {"MFEM NURBS", 0,
     "has NURBS in place of nodes; in MFEM call mesh.SetCurvature(2) and save the mesh"},
    {"MFEM NC", 0,
     "may have hanging nodes, which cannot be smoothed; smooth the mesh before it is refined "
     "locally, saved as 'MFEM mesh v1.0'"},
    {"MFEM mesh", 0, "is of a version that is not read; save it as 'MFEM mesh v1.0'"},
};

enum { N_KINDS = sizeof kinds / sizeof *kinds };

/** Return the kind of a first line; N_KINDS: none. */
static size_t find_kind(io_slice line) {
    size_t i = 0;
    for (; i < N_KINDS; i++) {
        const size_t n = strlen(kinds[i].name);
        const int is_longer = (size_t)io_slice_length(line) > n;
        if ((size_t)io_slice_length(line) >= n && memcmp(line.begin, kinds[i].name, n) == 0 &&
            (kinds[i].remedy || !is_longer))
            break;
    }
    return i;
}

static int read_first_line(mfem_reader *r) {
    io_skip_space(&r->cursor);
    const io_slice line = io_slice_trim(io_next_line(&r->cursor));
    const size_t kind = find_kind(line);
    if (kind == N_KINDS)
        return io_fail_at(r->model, line.begin, r->error,
                          "no 'MFEM mesh v1.0' in the first line: this is not a mesh of MFEM");
    if (kinds[kind].remedy)
        return io_fail_at(r->model, line.begin, r->error, "'%.*s' %s", IO_QUOTED(line),
                          kinds[kind].remedy);
    r->version = kinds[kind].version;
    return PLANISH_OK;
}

/* ---- sections ------------------------------------------------------------------------------- */

/** Take the next word if it is name. */
static int take_keyword(mfem_reader *r, const char *name) {
    io_cursor ahead = r->cursor;
    io_skip_space_comments(&ahead, '#');
    const int is_there = io_slice_is(io_next_word(&ahead), name, 0);
    if (is_there)
        r->cursor = ahead;
    return is_there;
}

/** Read the keyword name and the number behind it, first at least. */
static int read_number(mfem_reader *r, const char *name, int64_t first, int64_t *number) {
    io_skip_space_comments(&r->cursor, '#');
    const char *at = r->cursor.at;
    if (!take_keyword(r, name))
        return io_fail_at(r->model, at, r->error, "%s expected (the file may be cut short)", name);
    io_skip_space_comments(&r->cursor, '#');
    if (io_integer(&r->cursor, number) || *number < first)
        return io_fail_at(r->model, r->cursor.at, r->error,
                          "a whole number of %lld or more expected after %s", (long long)first,
                          name);
    return PLANISH_OK;
}

/** Read the number of a list of elements, and note where they are. */
static int find_list(mfem_reader *r, const char *name, io_section *section) {
    enum { LEAST = 2 * 3 }; /* bytes of attribute, geometry, vertex */
    int status = read_number(r, name, 0, &section->count);
    if (!status)
        status = io_check_count(r->model, r->cursor, section->count, LEAST, name, r->error);
    section->data = r->cursor.at;
    io_skip_numbers(&r->cursor);
    section->end = r->cursor.at;
    return status;
}

/** Take a name: a word, or what is in quotes, where \ stands before a quote or itself. Empty (begin
 *  NULL): there is none. */
static io_slice take_name(io_cursor *cursor) {
    const int is_quoted = cursor->at < cursor->end && *cursor->at == '"';
    if (!is_quoted) {
        const io_slice word = io_next_word(cursor);
        return io_slice_length(word) > 0 ? word : (io_slice){NULL, NULL};
    }
    const char *at = cursor->at + 1, *begin = at;
    for (; at < cursor->end && *at != '"'; at++)
        at += *at == '\\' && cursor->end - at > 1;
    if (at == cursor->end)
        return (io_slice){NULL, NULL};
    cursor->at = at + 1;
    return (io_slice){begin, at};
}

/** Copy a name without the backslashes of quoted ones. Owned; NULL without memory. */
static char *copy_name(io_slice name, int64_t *length) {
    const int is_quoted = name.begin[-1] == '"';
    char *text = pl_alloc(io_slice_length(name) + 1, 1);
    *length = 0;
    for (const char *c = name.begin; text && c < name.end; c++) {
        c += is_quoted && *c == '\\' && name.end - c > 1;
        text[(*length)++] = *c;
    }
    return text;
}

/** Note that n groups are to have a name of length bytes. Each keeps it, and a file could give one long
 *  name to all of many attributes. */
static int check_names(mfem_reader *r, const char *at, int64_t length, int64_t n) {
    enum { PER_BYTE = 64, FREE = 1 << 20 };
    const int64_t left = FREE + PER_BYTE * r->model->input.size - r->named;
    if (length > 0 && n > left / length)
        return io_fail_at(
            r->model, at, r->error,
            "a set with a name of %lld bytes has %lld attributes: too much for a file "
            "of this size; give it a shorter name",
            (long long)length, (long long)n);
    r->named += length * n;
    return PLANISH_OK;
}

/** Read named sets of attributes, which become groups of dimension dim. */
static int read_sets(mfem_reader *r, const char *name, int dim) {
    int64_t n_sets = 0, n = 0, attribute = 0, length;
    const io_record_kind kind = {.model = r->model, .what = name};
    int status = read_number(r, name, 0, &n_sets);
    for (int64_t i = 0; i < n_sets && !status; i++) {
        io_skip_space_comments(&r->cursor, '#');
        const char *at = r->cursor.at;
        const io_slice set = take_name(&r->cursor);
        if (!set.begin)
            return io_fail_at(r->model, at, r->error, "%s: name %lld of %lld expected", name,
                              (long long)i + 1, (long long)n_sets);
        char *text = copy_name(set, &length);
        if (!text)
            return pl_fail_memory(r->error, "the names of sets");
        status = io_take_whole(&kind, &r->cursor, i, 0, INT32_MAX, &n, r->error);
        if (!status)
            status = io_check_room(r->model, r->cursor, n, 2, "attributes", r->error);
        if (!status)
            status = check_names(r, at, length, n);
        for (int64_t k = 0; k < n && !status; k++) {
            status =
                io_take_whole(&kind, &r->cursor, i, INT32_MIN, INT32_MAX, &attribute, r->error);
            if (!status)
                status = io_model_group(r->model, dim, (int32_t)attribute, text, length, r->error);
        }
        pl_free(text);
    }
    return status;
}

/* ---- the end -------------------------------------------------------------------------------- */

/** Hold the nodes of vertices that a part of a parallel mesh shares with other parts. */
static int hold_shared(mfem_reader *r) {
    const io_record_kind kind = {.model = r->model, .what = "shared_vertices"};
    int64_t n_all = 0, n_read = 0, n = 0, vertex = 0;
    io_cursor *cursor = &r->cursor;
    int status = PLANISH_OK;
    while (!status && !take_keyword(r, "mfem_mesh_end")) {
        io_skip_space_comments(cursor, '#');
        const io_slice word = io_next_word(cursor);
        if (io_slice_length(word) == 0)
            return io_fail_at(r->model, cursor->at, r->error,
                              "mfem_mesh_end expected (the file may be cut short)");
        const int is_list = io_slice_is(word, "shared_vertices", 0);
        if (!is_list && !io_slice_is(word, "total_shared_vertices", 0))
            continue;
        status = io_take_whole(&kind, cursor, 0, 0, INT32_MAX, is_list ? &n : &n_all, r->error);
        for (int64_t i = 0; is_list && i < n && !status; i++, n_read++) {
            status = io_take_whole(&kind, cursor, i, 0, r->n_vertices - 1, &vertex, r->error);
            const int64_t node = status           ? MFEM_NO_NODE
                                 : r->vertex_node ? r->vertex_node[vertex]
                                                  : vertex;
            if (node >= 0)
                io_hold_node(r->model, node, IO_HELD_REQUIRED);
        }
    }
    if (!status && n_read != n_all)
        status = io_fail_at(r->model, cursor->at, r->error,
                            "%lld shared vertices of a part of a mesh expected; there are %lld",
                            (long long)n_all, (long long)n_read);
    return status;
}

/** Look at what is behind the last coordinate: an end where there must be one, and no number. */
static int read_end(mfem_reader *r) {
    io_skip_space_comments(&r->cursor, '#');
    const char *at = r->cursor.at;
    int64_t ignored;
    double number;
    io_cursor ahead = r->cursor;
    if (io_integer(&ahead, &ignored) == 0 || io_real(&ahead, &number) == 0)
        return io_fail_at(r->model, at, r->error,
                          "more coordinates follow than the vertices and elements have nodes");
    if (r->version < 12 || take_keyword(r, "mfem_mesh_end"))
        return PLANISH_OK;
    if (take_keyword(r, "mfem_serial_mesh_end"))
        return hold_shared(r);
    return io_fail_at(r->model, at, r->error, "mfem_mesh_end expected (the file may be cut short)");
}

/* ---- the format ----------------------------------------------------------------------------- */

/** Read all up to the vertices, and note where the elements are. */
static int walk_file(mfem_reader *r, io_section *elements, io_section *boundary) {
    int64_t dim = 0;
    int status = read_first_line(r);
    if (!status)
        status = read_number(r, "dimension", 0, &dim);
    if (!status && dim != 2 && dim != 3)
        status = io_fail_at(r->model, r->cursor.at, r->error,
                            "dimension %lld: only meshes of 2 or 3 dimensions can be smoothed",
                            (long long)dim);
    if (status)
        return status;
    r->dim = (int)dim;
    status = find_list(r, "elements", elements);
    if (!status && r->version == 13)
        status = read_sets(r, "attribute_sets", r->dim);
    if (!status)
        status = find_list(r, "boundary", boundary);
    if (!status && r->version == 13)
        status = read_sets(r, "bdr_attribute_sets", r->dim - 1);
    if (!status && (take_keyword(r, "vertex_parents") || take_keyword(r, "coarse_elements")))
        status = io_fail_at(r->model, r->cursor.at, r->error,
                            "hanging nodes cannot be smoothed; smooth the mesh before it is "
                            "refined locally");
    if (!status)
        status = read_number(r, "vertices", 0, &r->n_vertices);
    const io_cursor all = io_begin_text(r->model->input.data, r->model->input.size);
    return status ? status : io_check_count(r->model, all, r->n_vertices, 2, "vertices", r->error);
}

/** Read the number of coordinates of a vertex, and these; or nodes. */
static int read_points(mfem_reader *r) {
    int64_t columns;
    if (take_keyword(r, "nodes")) {
        const int status = mfem_read_space(r);
        return status ? status : mfem_read_nodes(r);
    }
    io_skip_space_comments(&r->cursor, '#');
    if (io_integer(&r->cursor, &columns) || columns < r->dim || columns > 3)
        return io_fail_at(r->model, r->cursor.at, r->error,
                          "the number of coordinates of a vertex expected, %d to 3, or nodes",
                          r->dim);
    r->columns = (int)columns;
    return mfem_read_coordinates(r, r->n_vertices, "vertex");
}

static int mfem_read(io_model *model, planish_error *error) {
    mfem_reader r = {.model = model,
                     .error = error,
                     .cursor = io_begin_text(model->input.data, model->input.size),
                     .order = 1,
                     .edges = {.width = 2},
                     .quadrilaterals = {.width = 4}};
    io_section elements = {0}, boundary = {0};
    io_text_init(&r.text, model);
    model->node_order = mfem_node_orders;
    int status = walk_file(&r, &elements, &boundary);
    r.elements.dim = r.dim;
    r.boundary.dim = r.dim - 1;
    if (!status)
        status = mfem_read_list(&r, &elements, "element", &r.elements);
    if (!status)
        status = mfem_read_list(&r, &boundary, "boundary element", &r.boundary);
    if (!status)
        status = read_points(&r);
    if (!status)
        status = mfem_add_elements(&r, &r.elements, 0);
    if (!status)
        status = mfem_add_elements(&r, &r.boundary, 1);
    if (!status)
        status = read_end(&r);
    if (!status)
        mfem_hold_mids(&r);
    io_text_release(&r.text);
    mfem_list_release(&r.elements);
    mfem_list_release(&r.boundary);
    io_part_numbers_release(&r.edges);
    io_part_numbers_release(&r.quadrilaterals);
    pl_free(r.part);
    pl_free(r.vertex_node);
    return status;
}

static int mfem_recognise(const char *data, int64_t size) {
    io_cursor cursor = io_begin_text(data, size);
    io_skip_space(&cursor);
    return find_kind(io_slice_trim(io_next_line(&cursor))) < N_KINDS;
}

static const char *const extensions[] = {".mesh", ".mfem", NULL};

const io_format io_format_mfem = {.name = "mfem",
                                  .extensions = extensions,
                                  .has_no_end = 1,
                                  .recognise = mfem_recognise,
                                  .read = mfem_read};
