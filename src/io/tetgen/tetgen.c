/* tetgen: .node with .ele beside it, of TetGen (tetrahedra) and of Triangle
 * (triangles).
 *
 * Either file may be named; the other is found beside it. The .node file
 * becomes the model's input, as it holds the coordinates; .ele, and .face and
 * .edge if they are there, become its companions, as do files that are not read
 * here and stay right when nodes move (neighbours, volume constraints, a .poly
 * without nodes of its own). All that are read are read by lines: a first line of counts, then one
 * line for each node, element, face or edge, which begins with its number; '#' begins a comment.
 * Numbers run in sequence from that of the first line (0 or 1, as a rule).
 *
 * A .face or .edge file may list every face or edge of the mesh: then only those
 * with a marker that is not zero hold their nodes. If it lists fewer, they are those of
 * boundaries and constraints, and so are the segments in a .poly of Triangle. The first attribute of
 * elements tells regions apart if all its values are integers; other attributes
 * may be any quantity. Of elements of second order (-o2) mids are read; those of faces and edges are
 * not, as io_complete_mids finds them.
 */
#include "io/core/bytes.h"
#include "io/core/cell_types.h"
#include "io/core/format.h"
#include "io/core/records.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/system.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>
#include <strings.h>

static const char *const extensions[] = {".node", ".ele", NULL};

/* The first ones are read, the others written along only. Of .poly, .smesh and .vol, see
 * is_companion. */
static const char *const companions[] = {".ele", ".face", ".poly", ".edge",  ".neigh",
                                         ".t2f", ".t2e",  ".f2t",  ".f2e",   ".e2t",
                                         ".mtr", ".var",  ".vol",  ".smesh", NULL};
enum { SEGMENTS = 2, N_READ = 4, N_COMPANIONS = sizeof companions / sizeof *companions - 1 };

enum { MOST_NODES = 10 }; /* of an element */

/* Elements of second order (-o2): TetGen's mids are of the edges 23, 03, 01, 12, 13, 02; Triangle's
 * are opposite their corners. */
static const io_node_order node_orders[] = {
    {PLANISH_CELL_TRIANGLE6, {0, 1, 2, 5, 3, 4}},
    {PLANISH_CELL_TETRAHEDRON10, {0, 1, 2, 3, 6, 7, 9, 5, 8, 4}},
    {0, {0}}};

/** One of the files, and where its rows go. */
typedef struct table {
    io_model *model;
    io_model view;  /* only what messages and records need: input (borrowed) and threads */
    io_cursor rows; /* behind the first line */
    int64_t n;
    int64_t count[3];      /* what follows n in the first line; 0 where it ends before */
    int64_t first;         /* number of the first row */
    const char *what;      /* of a row, for messages */
    int dim;               /* nodes: number of coordinates; else corners of an element less one */
    int64_t skipped;       /* words between coordinates or nodes and the tag */
    int32_t *nodes;        /* [n][dim + 1] elements only, owned by the model; and */
    int mids;              /* how many mids of each go into the model, behind the corners */
    int32_t *tag;          /* [n] marker or attribute, or NULL: rows have none */
    int real_tag;          /* attributes are written as reals */
    atomic_int fractional; /* not 0: a real tag is no integer */
} table;

/* ---- words of a line --------------------------------------------------------------------- */

/** Skip blanks. Return whether the line goes on at the cursor. */
static int line_goes_on(io_cursor *cursor) {
    while (cursor->at < cursor->end && io_is_blank(*cursor->at))
        cursor->at++;
    return cursor->at < cursor->end && *cursor->at != '\n' && *cursor->at != '\r' &&
           *cursor->at != '#';
}

static int line_integer(io_cursor *cursor, int64_t *value) {
    return line_goes_on(cursor) ? io_integer(cursor, value) : -1;
}

/* ---- the first line ---------------------------------------------------------------------- */

/** Begin a table, t, of rows of so many words at least with the line of counts at t->rows. */
static int begin_rows(table *t, int64_t words, planish_error *error) {
    io_cursor *cursor = &t->rows;
    io_skip_space_comments(cursor, '#');
    if (line_integer(cursor, &t->n) || t->n < 0)
        return io_fail_at(&t->view, cursor->at, error, "a first line of counts was expected");
    for (int i = 0; i < 3 && line_goes_on(cursor); i++)
        if (io_integer(cursor, &t->count[i]) || t->count[i] < 0)
            return io_fail_at(&t->view, cursor->at, error, "a count was expected");
    const char *counts = cursor->at;
    io_skip_line(cursor);
    /* Every word takes two bytes at least, with what parts it from the next. */
    if (t->n > (io_left(cursor) + 1) / (2 * words))
        return io_fail_at(&t->view, counts, error,
                          "the first line promises %lld lines, but the file is too short for them",
                          (long long)t->n);
    io_cursor peek = *cursor;
    io_skip_space_comments(&peek, '#');
    if (t->n > 0 && line_integer(&peek, &t->first))
        return io_fail_at(&t->view, peek.at, error, "a number was expected");
    if (t->first > INT64_MAX - t->n)
        return io_fail_at(&t->view, peek.at, error, "number %lld is out of range",
                          (long long)t->first);
    return PLANISH_OK;
}

/** Begin a table of rows of so many words at least with the first line of a file. */
static int begin_table(table *t, io_model *model, const io_bytes *file, const char *what,
                       int64_t words, planish_error *error) {
    *t = (table){.model = model,
                 .view = {.input = *file, .threads = io_model_threads(model)},
                 .rows = io_begin_text(file->data, file->size),
                 .what = what};
    return begin_rows(t, words, error);
}

/** Check the number of attributes. Lines may have fewer than were promised, so that the size of the
 *  file is no bound: with shorter coordinates what was read could not be read again. */
static int check_attributes(const table *t, planish_error *error) {
    if (t->count[1] <= INT32_MAX)
        return PLANISH_OK;
    return io_fail_at(&t->view, t->view.input.data, error,
                      "the first line promises %lld attributes, more than a line can have",
                      (long long)t->count[1]);
}

/* ---- rows -------------------------------------------------------------------------------- */

static int read_coordinates(const table *t, io_cursor *cursor, int64_t node, planish_error *error) {
    double *xyz = t->model->xyz + 3 * node;
    line_goes_on(cursor);
    t->model->text_offset[node] = cursor->at - t->model->input.data;
    xyz[2] = 0;
    for (int i = 0; i < t->dim; i++)
        if (!line_goes_on(cursor) || io_real(cursor, &xyz[i]) || !isfinite(xyz[i]))
            return io_fail_at(&t->view, cursor->at, error,
                              "node %lld: a finite coordinate was expected",
                              (long long)(t->first + node));
    return PLANISH_OK;
}

/** Read the corners and mids of an element, face or edge as indices of nodes. */
static int read_corners(const table *t, io_cursor *cursor, int64_t row, planish_error *error) {
    io_model *model = t->model;
    int32_t nodes[MOST_NODES] = {0};
    int64_t number;
    for (int i = 0; i <= t->dim + t->mids; i++) {
        if (line_integer(cursor, &number))
            return io_fail_at(&t->view, cursor->at, error, "a node of %s %lld was expected",
                              t->what, (long long)(t->first + row));
        const int64_t node = io_node_index(model, number);
        if (node < 0)
            return io_fail_at(&t->view, cursor->at, error,
                              "%s %lld has node %lld, but there are nodes %lld to %lld only",
                              t->what, (long long)(t->first + row), (long long)number,
                              (long long)model->first_number,
                              (long long)(model->first_number + model->n_nodes - 1));
        nodes[i] = (int32_t)node;
    }
    for (int i = 0; i <= t->dim; i++)
        t->nodes[row * (t->dim + 1) + i] = nodes[i];
    if (t->mids > 0)
        io_cells_set_mids(model, t->dim, row, nodes);
    return PLANISH_OK;
}

/** Read the marker or attribute at the end of a row; 0 where the line ends before. */
static int read_tag(table *t, io_cursor *cursor, int64_t row, planish_error *error) {
    double real = 0;
    int64_t tag = 0;
    int failed = 0;
    for (int64_t i = 0; i < t->skipped && line_goes_on(cursor); i++)
        io_next_word(cursor);
    io_cursor found = *cursor;
    if (line_goes_on(cursor) && (t->real_tag || io_integer(cursor, &tag))) {
        failed = io_real(cursor, &real);
        if (!failed && !t->real_tag) { /* some programs write markers as 1.0 */
            failed = !(fabs(real) <= INT32_MAX) || floor(real) != real;
            tag = failed ? 0 : (int64_t)real;
        }
    }
    if (failed) {
        const io_slice word = io_next_word(&found);
        return io_fail_at(&t->view, word.begin, error, "a %s was expected, not '%.*s'",
                          t->real_tag ? "region attribute (a number)"
                                      : "boundary marker (a whole number)",
                          IO_QUOTED(word));
    }
    if (t->real_tag && !(real >= INT32_MIN && real <= INT32_MAX && floor(real) == real))
        atomic_store_explicit(&t->fractional, 1, memory_order_relaxed);
    else if (t->real_tag)
        tag = (int64_t)real;
    if (tag < INT32_MIN || tag > INT32_MAX)
        return io_fail_at(&t->view, cursor->at, error, "boundary marker %lld is out of range",
                          (long long)tag);
    t->tag[row] = (int32_t)tag;
    return PLANISH_OK;
}

/** Read rows, each a line that begins with its number, in sequence. */
static int read_rows(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                     planish_error *error) {
    table *t = context;
    int64_t number;
    if (error) /* what threads saw, which will not be read as they did, says nothing */
        atomic_store_explicit(&t->fractional, 0, memory_order_relaxed);
    for (int64_t row = begin; row < end; row++) {
        io_skip_space_comments(cursor, '#');
        if (cursor->at == cursor->end)
            return io_fail_at(&t->view, cursor->at, error,
                              "the file ends after %lld of %lld %ss (it may be cut short)",
                              (long long)row, (long long)t->n, t->what);
        const char *at = cursor->at;
        if (io_integer(cursor, &number) || (uint64_t)number - (uint64_t)t->first != (uint64_t)row)
            return io_fail_at(&t->view, at, error, "%s number %lld was expected", t->what,
                              (long long)((uint64_t)t->first + (uint64_t)row));
        int status = t->nodes ? read_corners(t, cursor, row, error)
                              : read_coordinates(t, cursor, row, error);
        if (!status && t->tag)
            status = read_tag(t, cursor, row, error);
        if (status)
            return status;
        io_skip_line(cursor);
    }
    return PLANISH_OK;
}

/** Read all rows, as a rule of so many words. */
static int read_table(table *t, int64_t words, planish_error *error) {
    io_text text;
    io_text_init(&text, &t->view);
    const int status = io_text_records(&text, &t->rows, t->n, words, read_rows, t, error);
    io_text_release(&text);
    return status;
}

/* ---- the files --------------------------------------------------------------------------- */

static int read_node_file(io_model *model, int *dim, planish_error *error) {
    table t;
    int status = begin_table(&t, model, &model->input, "node", 3, error);
    if (status)
        return status;
    if (t.count[0] != 2 && t.count[0] != 3)
        return io_fail_at(&t.view, model->input.data, error, "dimension %lld: 2 or 3 was expected",
                          (long long)t.count[0]);
    const int has_marker = t.count[2] > 0;
    *dim = model->columns = t.dim = (int)t.count[0];
    model->first_number = t.first;
    t.skipped = t.count[1];
    status = check_attributes(&t, error);
    if (!status)
        status = io_model_make_nodes(model, t.n, 8, 0, 0, NULL, error);
    if (!status && has_marker) {
        t.tag = model->node_entity = pl_alloc(t.n, sizeof *model->node_entity);
        status = t.tag ? PLANISH_OK : pl_fail_memory(error, "boundary markers");
    }
    if (!status)
        status = read_table(&t, 1 + *dim + t.skipped + has_marker, error);
    if (!status)
        status = io_model_note_lost(model, t.skipped > 0, "attributes of nodes", error);
    if (!status && has_marker)
        status = io_model_index_tags(model, 0, model->node_entity, t.n, error);
    return status;
}

static int read_ele_file(io_model *model, const io_bytes *file, int dim, planish_error *error) {
    table t;
    io_cells *cells = io_model_cells(model, dim);
    int status = begin_table(&t, model, file, "element", dim + 2, error);
    if (status)
        return status;
    const int of_second_order = dim + 1 + io_n_mids(dim);
    if (t.count[0] != dim + 1 && t.count[0] != of_second_order)
        return io_fail_at(&t.view, file->data, error,
                          "elements of %lld nodes: %d or %d were expected in %d dimensions",
                          (long long)t.count[0], dim + 1, of_second_order, dim);
    status = check_attributes(&t, error);
    if (!status)
        status = io_cells_reserve(model, dim, t.n, t.count[1] > 0, 0, error);
    t.mids = t.count[0] == of_second_order ? io_n_mids(dim) : 0;
    if (!status && t.mids > 0)
        status = io_cells_reserve_mids(model, dim, error);
    if (status)
        return status;
    t.dim = dim;
    t.nodes = cells->nodes;
    t.tag = cells->entity;
    t.real_tag = 1;
    status = read_table(&t, dim + 2 + t.mids + t.count[1], error);
    if (status)
        return status;
    cells->n = t.n;
    cells->first_number = t.first;
    status = io_model_note_lost(model, t.count[1] > 1 || atomic_load(&t.fractional),
                                "attributes of elements", error);
    if (status)
        return status;
    if (atomic_load(&t.fractional)) {
        pl_free(cells->entity);
        cells->entity = NULL;
    }
    return cells->entity ? io_model_index_tags(model, dim, cells->entity, t.n, error) : PLANISH_OK;
}

/** Return the number of mids that stand behind the corners of a face or edge: in meshes of second
 *  order TetGen writes them with all edges, but not with all faces. Behind them stands the marker,
 *  and perhaps elements around. */
static int64_t count_mids(const table *t, int dim) {
    const int least = dim == 2 ? 8 : 5; /* words of a row with mids and a marker */
    io_cursor cursor = t->rows;
    int n = 0;
    io_skip_space_comments(&cursor, '#');
    for (; line_goes_on(&cursor); n++)
        io_next_word(&cursor);
    return !io_model_elements(t->model)->mid || n < least ? 0 : io_n_mids(dim);
}

/** Whether n faces (dim 2) or edges (dim 1) are too many for those of boundaries and constraints alone:
 *  all are more than these, by Euler's formula. */
static int may_be_all(const io_model *model, int dim, int64_t n) {
    const int64_t n_triangles = model->triangle.n, n_tetrahedra = model->tetrahedron.n;
    if (n_tetrahedra == 0)
        return n > n_triangles + n_triangles / 2;
    return n > (dim == 2 ? 2 : 1) * n_tetrahedra;
}

/** Read the rows of faces (dim 2) or edges (dim 1), which hold their nodes; with_marker: those of marker 0
 *  are left out. */
static int read_faces(table *t, int dim, int with_marker, planish_error *error) {
    io_model *model = t->model;
    io_cells *cells = io_model_cells(model, dim);
    const size_t size = (size_t)(dim + 1) * sizeof *cells->nodes;
    int32_t *tag = pl_alloc_zero(t->n, sizeof *tag);
    int status = tag ? io_cells_reserve(model, dim, t->n, 1, 0, error)
                     : pl_fail_memory(error, "boundary markers");
    t->dim = dim;
    t->nodes = cells->nodes;
    t->tag = t->count[0] > 0 ? tag : NULL;
    t->skipped = count_mids(t, dim);
    if (!status)
        status = read_table(t, dim + 3 + t->skipped, error);
    for (int64_t i = 0; i < t->n && !status; i++) {
        if (with_marker && tag[i] == 0)
            continue;
        memmove(cells->nodes + cells->n * (dim + 1), cells->nodes + i * (dim + 1), size);
        cells->entity[cells->n++] = tag[i];
    }
    pl_free(tag);
    if (status)
        return status;
    model->n_lower += t->n - cells->n; /* those that are kept are counted with the others */
    return io_model_index_tags(model, dim, cells->entity, cells->n, error);
}

/** Read .face (dim 2) or .edge (dim 1). */
static int read_face_file(io_model *model, const io_bytes *file, int dim, planish_error *error) {
    table t;
    const int status = begin_table(&t, model, file, dim == 2 ? "face" : "edge", dim + 2, error);
    return status ? status : read_faces(&t, dim, may_be_all(model, dim, t.n), error);
}

/** Read the segments of Triangle's .poly, which stand behind the line of no nodes. */
static int read_segments(io_model *model, const io_bytes *file, planish_error *error) {
    table t = {.model = model,
               .view = {.input = *file, .threads = io_model_threads(model)},
               .rows = io_begin_text(file->data, file->size),
               .what = "segment"};
    io_skip_space_comments(&t.rows, '#');
    io_skip_line(&t.rows);
    const int status = begin_rows(&t, 3, error);
    return status ? status : read_faces(&t, 1, 0, error);
}

/* ---- which files ------------------------------------------------------------------------- */

/** Open the file of that extension beside path as *bytes: as path is written, or else in small
 *  letters. Absent (data NULL) is no error where it is not needed; nor then is an empty one, which
 *  is as good as none. */
static int open_beside(const io_model *model, const char *path, const char *extension, int needed,
                       io_bytes *bytes, planish_error *error) {
    char *beside = io_companion_path(&io_format_tetgen, path, extension);
    if (!beside)
        return pl_fail_memory(error, path);
    if (!pl_file_exists(beside))
        strcpy(beside + strlen(beside) - strlen(extension), extension);
    int status = PLANISH_OK;
    memset(bytes, 0, sizeof *bytes);
    if (pl_file_exists(beside))
        status = io_bytes_open_beside(beside, model->largest_copy, bytes, error);
    else if (needed)
        status = pl_fail(error, PLANISH_ERROR_FILE,
                         "%s: there is no %s beside it; TetGen's meshes are a .node and an .ele "
                         "file",
                         path, beside);
    if (status == PLANISH_ERROR_FORMAT && !needed)
        status = PLANISH_OK;
    pl_free(beside);
    return status;
}

/** Return whether a file of such a name beside .node belongs to it: a .poly or .smesh that has
 * nodes of its own is a mesh's source, and a .vol may be Netgen's mesh: volume constraints begin
 * with the number of elements. */
static int is_companion(const io_model *model, const io_bytes *file) {
    const char *extension = io_extension(file->path);
    const int is_boundary =
        strcasecmp(extension, ".poly") == 0 || strcasecmp(extension, ".smesh") == 0;
    int64_t count;
    if (!is_boundary && strcasecmp(extension, ".vol") != 0)
        return 1;
    io_cursor cursor = {file->data, file->data + file->size};
    io_skip_space_comments(&cursor, '#');
    if (io_integer(&cursor, &count))
        return 0;
    const int64_t n_elements = model->tetrahedron.n > 0 ? model->tetrahedron.n : model->triangle.n;
    return count == (is_boundary ? 0 : n_elements);
}

/** Read .node, which becomes model->input, and the files beside it: model->companion. */
static int tetgen_read(io_model *model, planish_error *error) {
    static const int dims[N_READ] = {0, 2, 1, 1}; /* of .face, .poly and .edge */
    const io_bytes named = model->input;
    model->node_order = node_orders;
    const int is_ele = io_format_has_extension(&io_format_tetgen, named.path) &&
                       strcasecmp(io_extension(named.path), ".ele") == 0;
    io_bytes other;
    int dim = 0;
    model->companion = pl_alloc(N_COMPANIONS, sizeof *model->companion);
    if (!model->companion)
        return pl_fail_memory(error, named.path);
    int status = open_beside(model, named.path, is_ele ? ".node" : ".ele", 1, &other, error);
    if (status)
        return status;
    model->input = is_ele ? other : named;
    model->companion[0] = is_ele ? named : other;
    model->n_companions = model->n_read = 1;
    status = read_node_file(model, &dim, error);
    if (!status)
        status = read_ele_file(model, &model->companion[0], dim, error);
    for (int i = 1; i < N_COMPANIONS && !status; i++) {
        status = open_beside(model, model->input.path, companions[i], 0, &other, error);
        if (status || !other.data)
            continue;
        if (!is_companion(model, &other)) {
            io_bytes_close(&other);
            continue;
        }
        model->companion[model->n_companions++] = other;
        model->n_read += i < N_READ;
        if (i == SEGMENTS && dim == 2)
            status = read_segments(model, &other, error);
        else if (i != SEGMENTS && i < N_READ && dims[i] < dim && model->line.n == 0)
            status = read_face_file(model, &other, dims[i], error);
    }
    return status;
}

/* Nothing but numbers: any table looks like that. */
static int tetgen_recognise(const char *data, int64_t size) {
    (void)data;
    (void)size;
    return 0;
}

const io_format io_format_tetgen = {.name = "tetgen",
                                    .extensions = extensions,
                                    .has_no_end = 1,
                                    .recognise = tetgen_recognise,
                                    .read = tetgen_read,
                                    .companions = companions,
                                    .is_companion = is_companion};
