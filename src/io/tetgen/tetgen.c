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
 * A .face or .edge file may list every face or edge of the mesh: only those
 * with a marker that is not zero hold their nodes. The first attribute of
 * elements tells regions apart if all its values are integers; other attributes
 * may be any quantity.
 */
#include "io/core/bytes.h"
#include "io/core/format.h"
#include "io/core/records.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/system.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>
#include <strings.h>

/** One of the files. */
typedef struct part {
    io_model view; /* only what messages and records need: input (borrowed) and
                      threads */
    io_cursor cursor;
    int64_t n;        /* lines after the first */
    int64_t count[3]; /* what follows n in the first line; 0 where it ends before */
    int64_t first;    /* number of the first of the n */
} part;

/** What the rows of a file are read with. */
typedef struct rows {
    io_model *model;
    const part *part;
    const char *what;      /* of a row, for messages */
    int dim;               /* nodes: number of coordinates; else nodes of an element less one */
    int64_t skipped;       /* words between coordinates or corners and the tag */
    int32_t *nodes;        /* [n][dim + 1] elements only, owned by the model */
    int32_t *tag;          /* [n] marker or attribute, or NULL: rows have none */
    int real_tag;          /* attributes are written as reals */
    atomic_int fractional; /* not 0: a real tag is no integer */
} rows;

/* ---- words of a line --------------------------------------------------------------------- */

/** Whether the line goes on at the cursor, with blanks skipped. */
static int line_goes_on(io_cursor *cursor) {
    while (cursor->at < cursor->end && (*cursor->at == ' ' || *cursor->at == '\t'))
        cursor->at++;
    return cursor->at < cursor->end && *cursor->at != '\n' && *cursor->at != '\r' &&
           *cursor->at != '#';
}

static int line_integer(io_cursor *cursor, int64_t *value) {
    return line_goes_on(cursor) ? io_integer(cursor, value) : -1;
}

static int line_real(io_cursor *cursor, double *value) {
    return line_goes_on(cursor) ? io_real(cursor, value) : -1;
}

/* ---- the first line ---------------------------------------------------------------------- */

static int part_begin(part *p, const io_bytes *file, int threads, int64_t words,
                      planish_error *error) {
    *p = (part){.view = {.input = *file, .threads = threads},
                .cursor = io_begin_text(file->data, file->size)};
    io_skip_space_comments(&p->cursor, '#');
    if (line_integer(&p->cursor, &p->n) || p->n < 0)
        return io_fail_at(&p->view, p->cursor.at, error, "a first line of counts was expected");
    for (int i = 0; i < 3 && line_goes_on(&p->cursor); i++)
        if (io_integer(&p->cursor, &p->count[i]) || p->count[i] < 0)
            return io_fail_at(&p->view, p->cursor.at, error, "a count was expected");
    const char *counts = p->cursor.at;
    io_skip_line(&p->cursor);
    /* Every word takes two bytes at least, with what parts it from the next. */
    if (p->n > (io_left(&p->cursor) + 1) / (2 * words))
        return io_fail_at(&p->view, counts, error,
                          "%lld lines were promised, the file is too short for that",
                          (long long)p->n);
    io_cursor peek = p->cursor;
    io_skip_space_comments(&peek, '#');
    if (p->n > 0 && line_integer(&peek, &p->first))
        return io_fail_at(&p->view, peek.at, error, "a number was expected");
    if (p->first > INT64_MAX - p->n)
        return io_fail_at(&p->view, peek.at, error, "number %lld is out of range",
                          (long long)p->first);
    return PLANISH_OK;
}

/** Lines may have fewer attributes than were promised, so that the size of the file is no bound:
 * with shorter coordinates what was read could not be read again. */
static int check_attributes(const part *p, int64_t promised, planish_error *error) {
    if (promised <= INT32_MAX)
        return PLANISH_OK;
    return io_fail_at(&p->view, p->view.input.data, error,
                      "%lld attributes were promised, no line has so many", (long long)promised);
}

/* ---- rows -------------------------------------------------------------------------------- */

/** The number that each row begins with: in sequence. */
static int read_number(const rows *r, io_cursor *cursor, int64_t row, planish_error *error) {
    const part *p = r->part;
    int64_t number;
    io_skip_space_comments(cursor, '#');
    if (cursor->at == cursor->end)
        return io_fail_at(&p->view, cursor->at, error,
                          "the file ends after %lld of %lld %ss (it may be cut short)",
                          (long long)row, (long long)p->n, r->what);
    const char *at = cursor->at;
    if (io_integer(cursor, &number) || (uint64_t)number - (uint64_t)p->first != (uint64_t)row)
        return io_fail_at(&p->view, at, error, "%s number %lld was expected", r->what,
                          (long long)((uint64_t)p->first + (uint64_t)row));
    return PLANISH_OK;
}

/** The marker or attribute at the end of a row; 0 where the line ends before. */
static int read_tag(rows *r, io_cursor *cursor, int64_t row, planish_error *error) {
    double real = 0;
    int64_t length, tag = 0;
    int failed = 0;
    for (int64_t i = 0; i < r->skipped && line_goes_on(cursor); i++)
        io_word(cursor, &length);
    io_cursor found = *cursor;
    if (line_goes_on(cursor) && (r->real_tag || io_integer(cursor, &tag))) {
        failed = io_real(cursor, &real);
        if (!failed && !r->real_tag) { /* some programs write markers as 1.0 */
            failed = !(fabs(real) <= INT32_MAX) || floor(real) != real;
            tag = failed ? 0 : (int64_t)real;
        }
    }
    if (failed) {
        const char *word = io_word(&found, &length);
        return io_fail_at(&r->part->view, word, error, "a %s was expected, not '%.*s'",
                          r->real_tag ? "region attribute (a number)"
                                      : "boundary marker (a whole number)",
                          (int)(length < 24 ? length : 24), word);
    }
    if (r->real_tag && !(real >= INT32_MIN && real <= INT32_MAX && floor(real) == real))
        atomic_store_explicit(&r->fractional, 1, memory_order_relaxed);
    else if (r->real_tag)
        tag = (int64_t)real;
    if (tag < INT32_MIN || tag > INT32_MAX)
        return io_fail_at(&r->part->view, cursor->at, error, "boundary marker %lld is out of range",
                          (long long)tag);
    r->tag[row] = (int32_t)tag;
    return PLANISH_OK;
}

static int read_nodes(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                      planish_error *error) {
    rows *r = context;
    for (int64_t node = begin; node < end; node++) {
        double *xyz = r->model->xyz + 3 * node;
        int status = read_number(r, cursor, node, error);
        if (status)
            return status;
        line_goes_on(cursor);
        r->model->text_offset[node] = cursor->at - r->model->input.data;
        xyz[2] = 0;
        for (int i = 0; i < r->dim; i++)
            if (line_real(cursor, &xyz[i]) || !isfinite(xyz[i]))
                return io_fail_at(&r->part->view, cursor->at, error,
                                  "node %lld: a finite coordinate was expected",
                                  (long long)(r->part->first + node));
        if (r->tag && (status = read_tag(r, cursor, node, error)))
            return status;
        io_skip_line(cursor);
    }
    return PLANISH_OK;
}

/** The corners of one element, face or edge as indices of nodes. */
static int read_corners(const rows *r, io_cursor *cursor, int64_t row, int32_t *corner,
                        planish_error *error) {
    int64_t number;
    for (int i = 0; i <= r->dim; i++) {
        if (line_integer(cursor, &number))
            return io_fail_at(&r->part->view, cursor->at, error, "a node of %s %lld was expected",
                              r->what, (long long)(r->part->first + row));
        uint64_t index = (uint64_t)number - (uint64_t)r->model->first_number;
        if (index >= (uint64_t)r->model->n_nodes)
            return io_fail_at(&r->part->view, cursor->at, error,
                              "%s %lld has node %lld, but there are nodes %lld to %lld only",
                              r->what, (long long)(r->part->first + row), (long long)number,
                              (long long)r->model->first_number,
                              (long long)(r->model->first_number + r->model->n_nodes - 1));
        corner[i] = (int32_t)index;
    }
    return PLANISH_OK;
}

static int read_elements(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                         planish_error *error) {
    rows *r = context;
    if (error) /* what threads saw, which will not be read as they did, says nothing */
        atomic_store_explicit(&r->fractional, 0, memory_order_relaxed);
    for (int64_t i = begin; i < end; i++) {
        int status = read_number(r, cursor, i, error);
        if (!status)
            status = read_corners(r, cursor, i, r->nodes + i * (r->dim + 1), error);
        if (!status && r->tag)
            status = read_tag(r, cursor, i, error);
        if (status)
            return status;
        io_skip_line(cursor);
    }
    return PLANISH_OK;
}

static int read_rows(rows *r, io_records_fn *read, int64_t words, planish_error *error) {
    io_text text;
    io_cursor cursor = r->part->cursor;
    io_text_init(&text, &r->part->view);
    int status = io_text_records(&text, &cursor, r->part->n, words, read, r, error);
    io_text_release(&text);
    return status;
}

/* ---- the files --------------------------------------------------------------------------- */

static int read_node_file(io_model *model, int *dim, planish_error *error) {
    part p;
    int status = part_begin(&p, &model->input, model->threads, 3, error);
    if (status)
        return status;
    if (p.count[0] != 2 && p.count[0] != 3)
        return io_fail_at(&p.view, model->input.data, error, "dimension %lld: 2 or 3 was expected",
                          (long long)p.count[0]);
    *dim = (int)p.count[0];
    model->columns = *dim;
    model->first_number = p.first;
    status = check_attributes(&p, p.count[1], error);
    if (status)
        return status;
    const int64_t words = 1 + *dim + p.count[1] + (p.count[2] > 0);
    status = io_model_nodes(model, p.n, 1, error);
    if (!status)
        status = io_model_span(model, (io_span){.n_nodes = p.n, .encoding = IO_TEXT}, error);
    if (!status && p.count[2] > 0 &&
        !(model->node_entity = pl_alloc(p.n, sizeof *model->node_entity)))
        status = pl_fail_memory(error, "boundary markers");
    if (status)
        return status;
    rows r = {.model = model,
              .part = &p,
              .what = "node",
              .dim = *dim,
              .skipped = p.count[1],
              .tag = model->node_entity};
    status = read_rows(&r, read_nodes, words, error);
    if (!status && model->node_entity)
        status = io_model_index_tags(model, 0, model->node_entity, p.n, error);
    return status;
}

static int read_ele_file(io_model *model, const io_bytes *file, int dim, planish_error *error) {
    part p;
    io_cells *cells = dim == 3 ? &model->tetrahedron : &model->triangle;
    int status = part_begin(&p, file, model->threads, dim + 2, error);
    if (status)
        return status;
    if (p.count[0] == (dim == 3 ? 10 : 6))
        return io_fail_at(&p.view, file->data, error,
                          "elements of second order (%lld nodes): only linear ones can be "
                          "smoothed, write the mesh without -o2",
                          (long long)p.count[0]);
    if (p.count[0] != dim + 1)
        return io_fail_at(&p.view, file->data, error,
                          "elements of %lld nodes: %d were expected in %d dimensions",
                          (long long)p.count[0], dim + 1, dim);
    status = check_attributes(&p, p.count[1], error);
    if (!status)
        status = io_cells_reserve(cells, dim, p.n, p.count[1] > 0, 0, error);
    if (status)
        return status;
    rows r = {.model = model,
              .part = &p,
              .what = "element",
              .dim = dim,
              .nodes = cells->nodes,
              .tag = cells->entity,
              .real_tag = 1};
    status = read_rows(&r, read_elements, dim + 2 + p.count[1], error);
    if (status)
        return status;
    cells->n = p.n;
    cells->first_number = p.first;
    if (atomic_load(&r.fractional)) {
        pl_free(cells->entity);
        cells->entity = NULL;
    }
    return cells->entity ? io_model_index_tags(model, dim, cells->entity, p.n, error) : PLANISH_OK;
}

/** Leave of the cells those that are marked; marker [n]. */
static void keep_marked(io_cells *cells, int dim, const int32_t *marker, int64_t n) {
    for (int64_t i = 0; i < n; i++) {
        if (marker[i] == 0)
            continue;
        memmove(cells->nodes + cells->n * (dim + 1), cells->nodes + i * (dim + 1),
                (size_t)(dim + 1) * sizeof *cells->nodes);
        cells->entity[cells->n++] = marker[i];
    }
}

/** .face (dim 2) or .edge (dim 1): those with a marker are kept, and hold their nodes. */
static int read_face_file(io_model *model, const io_bytes *file, int dim, planish_error *error) {
    part p;
    io_cells *cells = dim == 2 ? &model->triangle : &model->line;
    int status = part_begin(&p, file, model->threads, dim + 2, error);
    if (status)
        return status;
    if (p.count[0] == 0) {
        model->n_lower += p.n;
        return PLANISH_OK;
    }
    int32_t *marker = pl_alloc(p.n, sizeof *marker);
    status = marker ? io_cells_reserve(cells, dim, p.n, 1, 0, error)
                    : pl_fail_memory(error, "boundary markers");
    rows r = {.model = model,
              .part = &p,
              .what = dim == 2 ? "face" : "edge",
              .dim = dim,
              .nodes = cells->nodes,
              .tag = marker};
    if (!status)
        status = read_rows(&r, read_elements, dim + 3, error);
    if (!status) {
        keep_marked(cells, dim, marker, p.n);
        model->n_lower += p.n - cells->n; /* those that are kept are counted with the others */
        status = io_model_index_tags(model, dim, cells->entity, cells->n, error);
    }
    pl_free(marker);
    return status;
}

/* ---- which files ------------------------------------------------------------------------- */

/** The file of that extension beside path: as path is written, or else in small letters. Owned;
 *  NULL without memory. */
static char *find_beside(const char *path, const char *extension) {
    char *beside = io_companion_path(&io_format_tetgen, path, extension);
    if (!beside || pl_file_exists(beside))
        return beside;
    strcpy(beside + strlen(beside) - strlen(extension), extension);
    return beside;
}

/** Open the file of that extension beside path as *bytes; absent (data NULL) is no error where it
 *  is not needed; nor then is an empty one, which is as good as none. */
static int open_beside(const io_model *model, const char *path, const char *extension, int needed,
                       io_bytes *bytes, planish_error *error) {
    char *beside = find_beside(path, extension);
    if (!beside)
        return pl_fail_memory(error, path);
    int status = PLANISH_OK;
    memset(bytes, 0, sizeof *bytes);
    if (pl_file_exists(beside))
        status = io_bytes_open(beside, model->largest_copy, bytes, error);
    else if (needed)
        status = pl_fail(error, PLANISH_ERROR_FILE,
                         "%s: there is no %s beside it; TetGen's meshes are a "
                         ".node and an .ele file",
                         path, beside);
    if (status == PLANISH_ERROR_FORMAT && !needed)
        status = PLANISH_OK;
    pl_free(beside);
    return status;
}

/* .ele, .face and .edge are read; */
static const char *const read_extensions[] = {".ele", ".face", ".edge"};
enum { N_READ = sizeof read_extensions / sizeof *read_extensions };

/* these are written along only. Of .poly, .smesh and .vol, see is_companion. */
static const char *const other_extensions[] = {".neigh", ".t2f", ".t2e", ".f2t",  ".f2e",  ".e2t",
                                               ".mtr",   ".var", ".vol", ".poly", ".smesh"};
enum { N_OTHER = sizeof other_extensions / sizeof *other_extensions };

/** model->input: .node; model->companion: .ele and, if they are there, .face
 * and .edge. dim_of [n_companions] of their elements, -1 for .ele. */
static int gather_files(io_model *model, int *dim_of, planish_error *error) {
    static const int dims[N_READ] = {-1, 2, 1};
    io_bytes named = model->input, other;
    const int is_ele = io_format_has_extension(&io_format_tetgen, named.path) &&
                       strcasecmp(io_extension(named.path), ".ele") == 0;
    model->companion = pl_alloc(N_READ + N_OTHER, sizeof *model->companion);
    if (!model->companion)
        return pl_fail_memory(error, named.path);
    int status = open_beside(model, named.path, is_ele ? ".node" : ".ele", 1, &other, error);
    if (status)
        return status;
    model->input = is_ele ? other : named;
    model->companion[0] = is_ele ? named : other;
    dim_of[0] = dims[0];
    model->n_companions = 1;
    for (int i = 1; i < N_READ && !status; i++) {
        status = open_beside(model, model->input.path, read_extensions[i], 0, &other, error);
        if (!status && other.data) {
            dim_of[model->n_companions] = dims[i];
            model->companion[model->n_companions++] = other;
        }
    }
    return status;
}

/** Whether a file of such a name beside .node belongs to it: a .poly or .smesh that has nodes of
 *  its own is a mesh's source, and a .vol may be Netgen's mesh: volume constraints begin with the
 *  number of elements. */
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
    const io_cells *elements = model->tetrahedron.n > 0 ? &model->tetrahedron : &model->triangle;
    return count == (is_boundary ? 0 : elements->n);
}

/** Companions that are not read; number of elements is known. */
static int gather_others(io_model *model, planish_error *error) {
    int status = PLANISH_OK;
    for (int i = 0; i < N_OTHER && !status; i++) {
        io_bytes other;
        status = open_beside(model, model->input.path, other_extensions[i], 0, &other, error);
        if (status || !other.data)
            continue;
        if (is_companion(model, &other))
            model->companion[model->n_companions++] = other;
        else
            io_bytes_close(&other);
    }
    return status;
}

static int read_tetgen(io_model *model, planish_error *error) {
    int dim_of[N_READ], dim = 0;
    int status = gather_files(model, dim_of, error);
    if (!status)
        status = read_node_file(model, &dim, error);
    if (!status)
        status = read_ele_file(model, &model->companion[0], dim, error);
    model->n_read = model->n_companions;
    for (int i = 1; i < model->n_companions && !status; i++)
        if (dim_of[i] < dim)
            status = read_face_file(model, &model->companion[i], dim_of[i], error);
    return status ? status : gather_others(model, error);
}

/* Nothing but numbers: any table looks like that. */
static int recognise_tetgen(const char *data, int64_t size) {
    (void)data;
    (void)size;
    return 0;
}

static const char *const tetgen_extensions[] = {".node", ".ele", NULL};
static const char *const tetgen_companions[] = {".ele", ".face", ".edge", ".neigh", ".t2f",
                                                ".t2e", ".f2t",  ".f2e",  ".e2t",   ".mtr",
                                                ".var", ".vol",  ".poly", ".smesh", NULL};

const io_format io_format_tetgen = {.name = "tetgen",
                                    .extensions = tetgen_extensions,
                                    .has_no_end = 1,
                                    .recognise = recognise_tetgen,
                                    .read = read_tetgen,
                                    .companions = tetgen_companions,
                                    .is_companion = is_companion};
