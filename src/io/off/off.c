/* off: Geomview's OFF, text and binary: plane meshes of triangles and quadrilaterals.
 *
 * A first word such as OFF or STCNOFF, whose letters say what follows the coordinates of a vertex;
 * numbers of vertices, faces and edges; a line for each vertex and for each face: how many
 * vertices it has, these (from 0), and a colour of some numbers. What is behind coordinates and
 * vertices on a line is not looked at. '#' begins a comment. Faces of two vertices are lines,
 * those of more than four hold their nodes. Vertices and faces are numbered from 0.
 *
 * Behind OFF BINARY are integers and floats of 32 bits, big-endian.
 */
#include "io/core/format.h"
#include "io/core/records.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdatomic.h>
#include <string.h>

enum { WORD_SIZE = 4, N_COUNTS = 3, TRIANGLE = 3, QUADRILATERAL = 4, LINE = 2 };

typedef struct off_reader {
    io_model *model;
    planish_error *error;
    io_text text;
    io_cursor cursor;
    int swapped, word_size; /* binary: bytes of a number; text: 0 */
    int extra;              /* numbers of a vertex besides its coordinates */
    int64_t corners;        /* text: of all faces; 0: they differ */
    io_record_kind face;
    atomic_int has_more[2]; /* numbers behind coordinates, and behind vertices of a face */
} off_reader;

/* ---- the first lines ---------------------------------------------------------------------- */

/** Take the letters prefix from the word, if it begins with them. */
static int take_prefix(io_slice *word, const char *prefix) {
    const int64_t n = (int64_t)strlen(prefix);
    if (io_slice_length(*word) < n || memcmp(word->begin, prefix, (size_t)n) != 0)
        return 0;
    word->begin += n;
    return 1;
}

/** Return whether the word is OFF or a variant. *extra: numbers of a vertex besides its three
 * coordinates, or -1: there are four of these, or any number. *has_normals: a normal is among these.
 */
static int parse_header(io_slice word, int *extra, int *has_normals) {
    *extra = 2 * take_prefix(&word, "ST") + 4 * take_prefix(&word, "C");
    *has_normals = take_prefix(&word, "N");
    *extra += 3 * *has_normals;
    if (take_prefix(&word, "4") | take_prefix(&word, "n"))
        *extra = -1;
    return io_slice_is(word, "OFF", 0);
}

static int read_header(off_reader *r) {
    io_skip_space_comments(&r->cursor, '#');
    const io_slice word = io_next_word(&r->cursor);
    if (!parse_header(word, &r->extra, &r->model->has_normals))
        return io_fail_at(r->model, word.begin, r->error,
                          "no OFF in the first line: this is not an OFF file");
    if (r->extra < 0)
        return io_fail_at(
            r->model, word.begin, r->error,
            "4OFF and nOFF have vertices of other than three coordinates, which are not "
            "read; convert the file to OFF");
    io_cursor ahead = r->cursor;
    r->model->is_binary = io_slice_is(io_next_word(&ahead), "BINARY", 0);
    if (r->model->is_binary) {
        r->swapped = io_machine_is_little();
        r->word_size = WORD_SIZE;
        io_skip_line(&ahead);
        r->cursor = ahead;
    }
    r->face = (io_record_kind){r->model, "face", r->word_size, r->swapped};
    return PLANISH_OK;
}

/* ---- vertices ----------------------------------------------------------------------------- */

/** Count the words from the cursor to the end of the line or a comment. */
static int64_t words_of_line(io_cursor cursor) {
    const io_slice line = io_next_line(&cursor);
    io_cursor rest = {line.begin, line.end};
    for (int64_t n = 0;; n++) {
        const io_slice word = io_next_word(&rest);
        if (io_slice_length(word) == 0 || *word.begin == '#')
            return n;
    }
}

/** Note that a line, of a vertex or a face, goes on at the cursor. */
static void look_behind(off_reader *r, int is_face, io_cursor cursor) {
    if (!atomic_load_explicit(&r->has_more[is_face], memory_order_relaxed) &&
        words_of_line(cursor) > 0)
        atomic_store_explicit(&r->has_more[is_face], 1, memory_order_relaxed);
}

static int read_vertices(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                         planish_error *error) {
    off_reader *r = context;
    if (error) /* what threads saw, which will not be read as they did, says nothing */
        atomic_store_explicit(&r->has_more[0], 0, memory_order_relaxed);
    for (int64_t i = begin; i < end; i++) {
        if (r->model->is_binary) {
            const int status = io_load_node(r->model, cursor->at, WORD_SIZE, r->swapped, i, error);
            if (status)
                return status;
            cursor->at += (3 + r->extra) * WORD_SIZE;
            continue;
        }
        io_skip_space_comments(cursor, '#');
        const char *row = cursor->at;
        io_cursor line = *cursor;
        io_skip_line(&line);
        const int status = io_read_node(r->model, cursor, i, error);
        if (status)
            return status;
        if (cursor->at > line.at)
            return io_fail_at(r->model, row, error,
                              "vertex %lld: three coordinates expected in one line", (long long)i);
        look_behind(r, 0, (io_cursor){cursor->at, line.at});
        cursor->at = line.at;
    }
    return PLANISH_OK;
}

/* ---- faces -------------------------------------------------------------------------------- */

/** Skip the colour of a face. */
static int skip_colour(off_reader *r, io_cursor *cursor, int64_t face, planish_error *error) {
    if (!r->model->is_binary) {
        look_behind(r, 1, *cursor);
        io_skip_line(cursor);
        return PLANISH_OK;
    }
    int64_t n;
    const int status = io_take_whole(&r->face, cursor, face, INT64_MIN, INT64_MAX, &n, error);
    if (status)
        return status;
    if (n < 0 || n > io_left(cursor) / WORD_SIZE)
        return io_fail_at(r->model, cursor->at - WORD_SIZE, error,
                          "face %lld: a colour of %lld numbers cannot be in the %lld bytes that "
                          "are left",
                          (long long)face, (long long)n, (long long)io_left(cursor));
    cursor->at += n * WORD_SIZE;
    if (n > 0)
        atomic_store_explicit(&r->has_more[1], 1, memory_order_relaxed);
    return PLANISH_OK;
}

/** Read faces: how many vertices each has, these, which are stored or held, and its colour. Faces
 *  that differ are read in order. */
static int read_faces(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                      planish_error *error) {
    off_reader *r = context;
    io_model *model = r->model;
    io_cells *triangles = &model->triangle, *lines = &model->line;
    if (error)
        atomic_store_explicit(&r->has_more[1], 0, memory_order_relaxed);
    for (int64_t i = begin; i < end; i++) {
        int64_t corners, node;
        if (!model->is_binary)
            io_skip_space_comments(cursor, '#');
        const char *at = cursor->at;
        int status = io_take_whole(&r->face, cursor, i, INT64_MIN, INT64_MAX, &corners, error);
        if (status)
            return status;
        if (corners < 0 || corners > io_left(cursor))
            return io_fail_at(model, at, error, "face %lld cannot have %lld vertices", (long long)i,
                              (long long)corners);
        if (r->corners && corners != r->corners)
            return PLANISH_ERROR_FORMAT; /* they differ: read again, in order */
        int32_t *kept = NULL, quadrilateral[QUADRILATERAL];
        if (corners == TRIANGLE)
            kept = triangles->nodes + TRIANGLE * (r->corners ? i : triangles->n);
        else if (corners == LINE)
            kept = lines->nodes + LINE * lines->n;
        for (int64_t j = 0; j < corners; j++) {
            status = io_take_whole(&r->face, cursor, i, 0, model->n_nodes - 1, &node, error);
            if (status)
                return status;
            if (kept)
                kept[j] = (int32_t)node;
            else if (corners != QUADRILATERAL)
                io_hold_node(model, node, corners == 1 ? IO_HELD_BY_POINT : IO_HELD_BY_OTHER);
            if (corners == QUADRILATERAL)
                quadrilateral[j] = (int32_t)node;
        }
        if (corners == QUADRILATERAL)
            status = io_model_add_other(model, PLANISH_CELL_QUADRILATERAL, quadrilateral,
                                        IO_NO_ENTITY, i, error);
        if (status)
            return status;
        status = skip_colour(r, cursor, i, error);
        if (status)
            return status;
        if (!r->corners && corners == TRIANGLE)
            triangles->number[triangles->n++] = i;
        else if (!r->corners && corners > 0)
            *(corners == LINE ? &lines->n : corners == 1 ? &model->n_lower : &model->n_other) += 1;
    }
    return PLANISH_OK;
}

static int read_all_faces(off_reader *r, int64_t n) {
    io_model *model = r->model;
    io_cells *triangles = &model->triangle;
    io_cursor cursor = r->cursor;
    planish_error ignored;
    int status = io_cells_reserve(model, 2, n, 0, 1, r->error);
    if (status)
        return status;
    /* As a rule all faces of a text are triangles, which threads can read. */
    if (!model->is_binary) {
        io_skip_space_comments(&cursor, '#');
        const int64_t words = words_of_line(cursor);
        r->corners = TRIANGLE;
        status =
            io_text_records(&r->text, &cursor, n, words < 4 ? 4 : words, read_faces, r, &ignored);
        r->corners = 0;
    }
    if (model->is_binary || status) {
        cursor = r->cursor;
        status = io_cells_reserve(model, 1, n, 0, 0, r->error);
        if (!status)
            status = read_faces(r, &cursor, 0, n, r->error);
    } else {
        triangles->n = n;
        pl_free(triangles->number);
        triangles->number = NULL; /* they are numbered one after the other */
    }
    if (status || model->is_binary)
        return status;
    io_skip_space_comments(&cursor, '#');
    if (io_left(&cursor) > 0)
        return io_fail_at(model, cursor.at, r->error,
                          "more follows than the faces that the count says");
    return PLANISH_OK;
}

/* ---- the format --------------------------------------------------------------------------- */

/** Note normals, colours and the like. */
static int note_lost(off_reader *r) {
    const int of_vertices = r->extra > 0 || atomic_load(&r->has_more[0]);
    const int status =
        io_model_note_lost(r->model, of_vertices, "normals or colours of vertices", r->error);
    return status ? status
                  : io_model_note_lost(r->model, atomic_load(&r->has_more[1]), "colours of faces",
                                       r->error);
}

static int read_parts(off_reader *r) {
    io_model *model = r->model;
    int64_t counts[N_COUNTS];
    int status = read_header(r);
    if (status)
        return status;
    const int64_t stride = (3 + r->extra) * WORD_SIZE;
    for (int i = 0; i < N_COUNTS; i++) { /* of vertices, faces and edges */
        if (!model->is_binary)
            io_skip_space_comments(&r->cursor, '#');
        if (io_number(&r->cursor, r->word_size, r->swapped, &counts[i]))
            return io_fail_at(model, r->cursor.at, r->error,
                              "the numbers of vertices, faces and edges are expected (the file may "
                              "be cut short)");
    }
    status = io_check_count(model, r->cursor, counts[0], model->is_binary ? stride : 2 * 3,
                            "vertices", r->error);
    if (!status)
        status = io_model_make_nodes(model, counts[0], model->is_binary ? WORD_SIZE : 8, stride,
                                     r->swapped, r->cursor.at, r->error);
    if (status)
        return status;
    if (!model->is_binary)
        io_skip_space_comments(&r->cursor, '#');
    const int64_t words = model->is_binary ? 3 : words_of_line(r->cursor);
    status = io_records(&r->text, &r->cursor, counts[0], words < 3 ? 3 : words, stride,
                        read_vertices, r, r->error);
    if (!status)
        status = io_check_count(model, r->cursor, counts[1], model->is_binary ? 2 * WORD_SIZE : 2,
                                "faces", r->error);
    if (!status)
        status = read_all_faces(r, counts[1]);
    return status ? status : note_lost(r);
}

static int off_read(io_model *model, planish_error *error) {
    off_reader r = {.model = model,
                    .error = error,
                    .cursor = io_begin_text(model->input.data, model->input.size)};
    io_text_init(&r.text, model);
    const int status = read_parts(&r);
    io_text_release(&r.text);
    return status;
}

static int off_recognise(const char *data, int64_t size) {
    int extra, has_normals;
    return parse_header(io_first_word(data, size), &extra, &has_normals);
}

static const char *const extensions[] = {".off", NULL};

const io_format io_format_off = {.name = "off",
                                 .extensions = extensions,
                                 .has_no_end = 1,
                                 .recognise = off_recognise,
                                 .read = off_read};
