/* off: Geomview's OFF, text and binary: plane meshes of triangles.
 *
 * A first word such as OFF or STCNOFF, whose letters say what follows the coordinates of a vertex;
 * numbers of vertices, faces and edges; a line for each vertex and for each face: how many
 * vertices it has, these (from 0), and a colour of some numbers. What is behind coordinates and
 * vertices on a line is not looked at. '#' begins a comment. Faces of two vertices are lines,
 * others hold their nodes. Vertices and faces are numbered from 0.
 *
 * Behind OFF BINARY are integers and floats of 32 bits, big-endian.
 */
#include "io/core/format.h"
#include "io/core/records.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/binary.h"

#include <math.h>
#include <string.h>

enum { WORD_SIZE = 4, N_COUNTS = 3, TRIANGLE = 3, LINE = 2 };

/** What the first word says. */
typedef struct header {
    int extra;         /* numbers of a vertex besides its coordinates */
    int is_homogenous; /* coordinates are four, */
    int is_any;        /* or any number */
} header;

typedef struct reader {
    io_model *model;
    planish_error *error;
    io_text text;
    io_cursor cursor;
    int swapped;
    header header;
    int64_t n_faces;
    int64_t corners;              /* text: of all faces; 0: they differ */
    int64_t n_triangles, n_lines; /* kept so far, where they differ */
} reader;

/* ---- the first line ----------------------------------------------------------------------- */

/** Take the letters prefix from the word, if it begins with them. */
static int take_prefix(const char **word, int64_t *length, const char *prefix) {
    const int64_t n = (int64_t)strlen(prefix);
    if (*length < n || memcmp(*word, prefix, (size_t)n) != 0)
        return 0;
    *word += n;
    *length -= n;
    return 1;
}

/** Whether the word is such as OFF is. */
static int parse_header(const char *word, int64_t length, header *h) {
    *h = (header){0};
    h->extra += take_prefix(&word, &length, "ST") * 2;
    h->extra += take_prefix(&word, &length, "C") * 4;
    h->extra += take_prefix(&word, &length, "N") * 3;
    h->is_homogenous = take_prefix(&word, &length, "4");
    h->is_any = take_prefix(&word, &length, "n");
    return io_word_is(word, length, "OFF", 0);
}

static int read_header(reader *r) {
    int64_t length;
    io_skip_space_comments(&r->cursor, '#');
    const char *word = io_word(&r->cursor, &length);
    if (!parse_header(word, length, &r->header))
        return io_fail_at(r->model, word, r->error,
                          "no OFF in the first line: this is no OFF file");
    if (r->header.is_homogenous || r->header.is_any)
        return io_fail_at(
            r->model, word, r->error,
            "4OFF and nOFF have vertices of other than three coordinates, which are not "
            "read; convert the file to OFF");
    io_cursor ahead = r->cursor;
    word = io_word(&ahead, &length);
    r->model->is_binary = io_word_is(word, length, "BINARY", 0);
    if (!r->model->is_binary)
        return PLANISH_OK;
    r->swapped = io_machine_is_little();
    r->cursor = ahead;
    io_skip_line(&r->cursor);
    return PLANISH_OK;
}

/* ---- counts ------------------------------------------------------------------------------- */

/** count things of size bytes at least fit into what is left. In text the last number needs no
 *  space behind it. */
static int check_count(const reader *r, const char *at, int64_t count, int64_t size,
                       const char *what) {
    const int64_t left = io_left(&r->cursor) + !r->model->is_binary;
    if (count >= 0 && count <= left / size)
        return PLANISH_OK;
    return io_fail_at(r->model, at, r->error,
                      "%lld %s cannot be in the %lld bytes that are left; the count "
                      "is wrong or the file is cut short",
                      (long long)count, what, (long long)io_left(&r->cursor));
}

static int read_counts(reader *r, int64_t counts[2]) {
    io_cursor *cursor = &r->cursor;
    if (r->model->is_binary) {
        if (io_left(cursor) < N_COUNTS * WORD_SIZE)
            return io_fail_at(r->model, cursor->at, r->error,
                              "the numbers of vertices and faces are cut short");
        for (int i = 0; i < 2; i++)
            counts[i] = io_load_i32(cursor->at + i * WORD_SIZE, r->swapped);
        cursor->at += N_COUNTS * WORD_SIZE;
        return PLANISH_OK;
    }
    for (int i = 0; i < N_COUNTS; i++) {
        int64_t count;
        io_skip_space_comments(cursor, '#');
        if (io_integer(cursor, &count))
            return io_fail_at(r->model, cursor->at, r->error,
                              "the numbers of vertices, faces and edges are expected");
        if (i < 2)
            counts[i] = count;
    }
    return PLANISH_OK;
}

/* ---- vertices ----------------------------------------------------------------------------- */

/** Words from the cursor to the end of the line or a comment. */
static int64_t words_of_line(io_cursor cursor) {
    io_cursor line = cursor;
    int64_t n = 0, length;
    io_skip_line(&cursor);
    line.end = cursor.at;
    for (;;) {
        const char *word = io_word(&line, &length);
        if (length == 0 || *word == '#')
            return n;
        n++;
    }
}

static int has_line_end(const char *begin, const char *end) {
    const size_t size = (size_t)(end - begin);
    return memchr(begin, '\n', size) || memchr(begin, '\r', size);
}

static int read_text_vertices(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                              planish_error *error) {
    const reader *r = context;
    for (int64_t i = begin; i < end; i++) {
        io_skip_space_comments(cursor, '#');
        const char *row = cursor->at;
        int status = io_read_point(r->model, cursor, i, error);
        if (status)
            return status;
        if (has_line_end(row, cursor->at))
            return io_fail_at(r->model, row, error,
                              "vertex %lld: three coordinates expected in one line", (long long)i);
        io_skip_line(cursor);
    }
    return PLANISH_OK;
}

static int read_binary_vertices(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                                planish_error *error) {
    const reader *r = context;
    for (int64_t i = begin; i < end; i++) {
        for (int d = 0; d < 3; d++, cursor->at += WORD_SIZE) {
            double *x = &r->model->xyz[3 * i + d];
            *x = (double)io_load_f32(cursor->at, r->swapped);
            if (!isfinite(*x))
                return io_fail_at(r->model, cursor->at, error,
                                  "vertex %lld has a coordinate that is not finite", (long long)i);
        }
        cursor->at += r->header.extra * WORD_SIZE;
    }
    return PLANISH_OK;
}

static int read_vertices(reader *r, int64_t n) {
    io_model *model = r->model;
    const int64_t stride = (3 + r->header.extra) * WORD_SIZE;
    io_span span = {.n_nodes = n, .encoding = IO_TEXT};
    if (r->model->is_binary)
        span = (io_span){.n_nodes = n,
                         .encoding = IO_FLOAT32,
                         .swapped = r->swapped,
                         .offset = r->cursor.at - model->input.data,
                         .stride = stride};
    model->columns = 3;
    model->first_number = 0;
    model->precision = r->model->is_binary ? PLANISH_FLOAT : PLANISH_DOUBLE;
    int status = io_model_nodes(model, n, !r->model->is_binary, r->error);
    if (!status)
        status = io_model_span(model, span, r->error);
    if (status)
        return status;
    if (r->model->is_binary)
        return io_binary_records(model->threads, &r->cursor, n, stride, read_binary_vertices, r,
                                 r->error);
    io_skip_space_comments(&r->cursor, '#');
    const int64_t words = words_of_line(r->cursor);
    return io_text_records(&r->text, &r->cursor, n, words < 3 ? 3 : words, read_text_vertices, r,
                           r->error);
}

/* ---- faces -------------------------------------------------------------------------------- */

/** The next whole number of a face. */
static int take_integer(const reader *r, io_cursor *cursor, int64_t face, planish_error *error,
                        int64_t *value) {
    if (r->model->is_binary && io_left(cursor) >= WORD_SIZE) {
        *value = io_load_i32(cursor->at, r->swapped);
        cursor->at += WORD_SIZE;
        return PLANISH_OK;
    }
    if (r->model->is_binary)
        return io_fail_at(r->model, cursor->at, error, "face %lld is cut short", (long long)face);
    if (io_integer(cursor, value))
        return io_fail_at(r->model, cursor->at, error,
                          "face %lld: a whole number expected (the file may be cut short)",
                          (long long)face);
    return PLANISH_OK;
}

static int take_node(const reader *r, io_cursor *cursor, int64_t face, planish_error *error,
                     int32_t *node) {
    const char *at = cursor->at;
    int64_t value = 0;
    int status = take_integer(r, cursor, face, error, &value);
    *node = (int32_t)value;
    if (status || (value >= 0 && value < r->model->n_nodes))
        return status;
    if (r->model->is_binary)
        return io_fail_at(r->model, at, error, "face %lld has vertex %lld of 0 .. %lld",
                          (long long)face, (long long)value, (long long)r->model->n_nodes - 1);
    return io_fail_at(r->model, cursor->at, error, "face %lld has vertex %lld of 0 .. %lld",
                      (long long)face, (long long)value, (long long)r->model->n_nodes - 1);
}

/** How many vertices the next face has. */
static int take_corners(const reader *r, io_cursor *cursor, int64_t face, planish_error *error,
                        int64_t *corners) {
    const char *at = cursor->at;
    int status = take_integer(r, cursor, face, error, corners);
    if (status || (*corners >= 0 && *corners <= io_left(cursor)))
        return status;
    if (r->model->is_binary)
        return io_fail_at(r->model, at, error, "face %lld cannot have %lld vertices",
                          (long long)face, (long long)*corners);
    return io_fail_at(r->model, cursor->at, error, "face %lld cannot have %lld vertices",
                      (long long)face, (long long)*corners);
}

/** The vertices of a face go where it is kept, or are held. */
static int take_vertices(reader *r, io_cursor *cursor, int64_t face, int64_t corners, int32_t *kept,
                         planish_error *error) {
    const uint8_t reason = corners == 1 ? IO_HELD_BY_POINT : IO_HELD_BY_OTHER;
    for (int64_t j = 0; j < corners; j++) {
        int32_t node;
        int status = take_node(r, cursor, face, error, &node);
        if (status)
            return status;
        if (kept)
            kept[j] = node;
        else
            io_hold_node(r->model, node, reason);
    }
    return PLANISH_OK;
}

/** Pass over the colour of a face. */
static int skip_colour(const reader *r, io_cursor *cursor, int64_t face, planish_error *error) {
    if (!r->model->is_binary) {
        io_skip_line(cursor);
        return PLANISH_OK;
    }
    int64_t n;
    int status = take_integer(r, cursor, face, error, &n);
    if (!status && (n < 0 || n > io_left(cursor) / WORD_SIZE))
        return io_fail_at(r->model, cursor->at - WORD_SIZE, error,
                          "face %lld: a colour of %lld numbers cannot be in the %lld bytes that "
                          "are left",
                          (long long)face, (long long)n, (long long)io_left(cursor));
    cursor->at += status ? 0 : n * WORD_SIZE;
    return status;
}

/** Faces that differ are read in order: r->n_triangles and r->n_lines say how many are kept. */
static int read_faces(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                      planish_error *error) {
    reader *r = context;
    io_cells *triangles = &r->model->triangle, *lines = &r->model->line;
    for (int64_t i = begin; i < end; i++) {
        int64_t corners;
        if (!r->model->is_binary)
            io_skip_space_comments(cursor, '#');
        int status = take_corners(r, cursor, i, error, &corners);
        if (!status && r->corners && corners != r->corners)
            return PLANISH_ERROR_FORMAT; /* they differ: read again, in order */
        const int64_t cell = r->corners ? i : corners == LINE ? r->n_lines : r->n_triangles;
        int32_t *kept = NULL;
        if (!status && corners == TRIANGLE)
            kept = triangles->nodes + TRIANGLE * cell;
        else if (!status && corners == LINE)
            kept = lines->nodes + LINE * cell;
        if (!status)
            status = take_vertices(r, cursor, i, corners, kept, error);
        if (!status)
            status = skip_colour(r, cursor, i, error);
        if (status)
            return status;
        if (!r->corners && corners == TRIANGLE)
            triangles->number[r->n_triangles++] = i;
        if (!r->corners && corners == LINE)
            r->n_lines++;
        if (!r->corners && corners == 1)
            r->model->n_lower++;
        if (!r->corners && corners > TRIANGLE)
            r->model->n_other++;
    }
    return PLANISH_OK;
}

/** As a rule all faces are triangles, which threads can read: 0 if so. */
static int read_triangles(reader *r) {
    io_cursor cursor = r->cursor;
    planish_error ignored;
    io_skip_space_comments(&cursor, '#');
    const int64_t words = words_of_line(cursor);
    r->corners = TRIANGLE;
    int status = io_text_records(&r->text, &cursor, r->n_faces, words < 4 ? 4 : words, read_faces,
                                 r, &ignored);
    r->corners = 0;
    if (status)
        return status;
    r->cursor = cursor;
    r->n_triangles = r->n_faces;
    pl_free(r->model->triangle.number);
    r->model->triangle.number = NULL; /* they are numbered one after the other */
    return PLANISH_OK;
}

static int read_all_faces(reader *r) {
    io_cells *triangles = &r->model->triangle, *lines = &r->model->line;
    int status = io_cells_reserve(triangles, 2, r->n_faces, 0, 1, r->error);
    if (status)
        return status;
    if (r->model->is_binary || read_triangles(r)) {
        status = io_cells_reserve(lines, 1, r->n_faces, 0, 0, r->error);
        if (!status)
            status = read_faces(r, &r->cursor, 0, r->n_faces, r->error);
    }
    triangles->n = r->n_triangles;
    lines->n = r->n_lines;
    if (!status && !r->model->is_binary)
        io_skip_space_comments(&r->cursor, '#');
    if (!status && !r->model->is_binary && io_left(&r->cursor) > 0)
        return io_fail_at(r->model, r->cursor.at, r->error,
                          "more follows than the faces that the count says");
    return status;
}

static int read_all(reader *r) {
    int64_t counts[2];
    int status = read_header(r);
    if (!status)
        status = read_counts(r, counts);
    const char *at = r->cursor.at;
    if (!status)
        status = check_count(r, at, counts[0],
                             r->model->is_binary ? (3 + r->header.extra) * WORD_SIZE : 2 * 3,
                             "vertices");
    if (!status)
        status = read_vertices(r, counts[0]);
    if (status)
        return status;
    r->n_faces = counts[1];
    status =
        check_count(r, r->cursor.at, r->n_faces, r->model->is_binary ? 2 * WORD_SIZE : 2, "faces");
    return status ? status : read_all_faces(r);
}

static int read_off(io_model *model, planish_error *error) {
    reader r = {.model = model,
                .error = error,
                .cursor = io_begin_text(model->input.data, model->input.size)};
    io_text_init(&r.text, model);
    int status = read_all(&r);
    io_text_release(&r.text);
    return status;
}

static int recognise_off(const char *data, int64_t size) {
    io_cursor cursor = io_begin_text(data, size);
    header ignored;
    int64_t length;
    io_skip_space_comments(&cursor, '#');
    const char *word = io_word(&cursor, &length);
    return parse_header(word, length, &ignored);
}

static const char *const extensions[] = {".off", NULL};

const io_format io_format_off = {.name = "off",
                                 .extensions = extensions,
                                 .has_no_end = 1,
                                 .recognise = recognise_off,
                                 .read = read_off};
