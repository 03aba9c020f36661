/* stl: STL, text and binary: facets of three points each, with a normal.
 *
 * Text: words in any letter case,
 *
 *     solid NAME
 *     facet normal NX NY NZ  outer loop  vertex X Y Z  vertex X Y Z  vertex X Y Z  endloop endfacet
 *     endsolid NAME
 *
 * and maybe more solids, which are groups. Some programs leave normals out, or write "end solid". Binary, little-endian: 80 bytes of any kind, the number
 * of facets (32 bits), and 50 bytes for each: normal and points as floats, and 2 bytes for colours.
 * The size of a file tells the two apart, as 80 bytes may begin with the word solid.
 *
 * Equal points are one node, which is written back to all its places. Each facet is a span of three
 * places, so that its normal, which is rewritten when the facet has moved, stands between spans.
 * Facets with two equal points are no elements; they hold their nodes.
 */
#include "io/view/surface_write.h"
#include "io/core/binary.h"
#include "io/core/bytes.h"
#include "io/core/format.h"
#include "io/core/number.h"
#include "io/core/records.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

enum {
    HEADER_SIZE = 84, /* bytes before the first facet, the last four of them its count */
    COUNT_AT = 80,
    FACET_SIZE = 50,
    POINTS_AT = 12, /* in a facet */
    POINT_SIZE = 12,
    COLOUR_AT = 48,
    FLOAT_SIZE = 4,
    NO_NORMAL = -1
};

/** Places of normals in the file, for the writer: model->of_format. */
typedef struct stl_normals {
    int64_t n;   /* facets */
    int64_t *at; /* [n] byte of each normal in text, or NO_NORMAL; NULL: binary */
} stl_normals;

typedef struct stl_reader {
    io_model *model;
    planish_error *error;
    io_cursor cursor;
    stl_normals *normals;
    int64_t room; /* facets that there is room for */
    int swapped;
} stl_reader;

/* ---- nodes and facets ----------------------------------------------------------------------- */

/** Make room for n facets: places, spans and cells. */
static int make_facets(stl_reader *r, int64_t n) {
    io_model *model = r->model;
    r->room = n;
    model->precision = model->is_binary ? PLANISH_PRECISION_FLOAT : PLANISH_PRECISION_DOUBLE;
    model->first_number = model->triangle.first_number = 1;
    int status = io_model_alloc_nodes(model, 3 * n, !model->is_binary, r->error);
    if (!status)
        status = io_cells_reserve(model, 2, n, 1, 1, r->error);
    if (status)
        return status;
    model->n_nodes = 0; /* so far */
    r->normals = model->of_format = pl_alloc_zero(1, sizeof *r->normals);
    if (!r->normals)
        return pl_fail_memory(r->error, "the facets of the file");
    r->normals->at = model->is_binary ? NULL : pl_alloc(n, sizeof *r->normals->at);
    model->span = pl_alloc(n, sizeof *model->span);
    model->span_capacity = n;
    return model->span && (r->normals->at || model->is_binary)
               ? PLANISH_OK
               : pl_fail_memory(r->error, "the facets of the file");
}

/** Note the next facet, whose three places have been read, of an entity. */
static int add_facet(stl_reader *r, int32_t entity, int64_t normal_at) {
    io_model *model = r->model;
    const int64_t facet = r->normals->n++;
    const io_span span = {.first_node = 3 * facet,
                          .n_nodes = 3,
                          .encoding = model->is_binary ? IO_FLOAT32 : IO_TEXT,
                          .swapped = r->swapped,
                          .offset = normal_at + POINTS_AT,
                          .stride = POINT_SIZE};
    if (r->normals->at)
        r->normals->at[facet] = normal_at;
    model->n_nodes += 3;
    model->triangle.entity[facet] = entity;
    return io_model_span(model, span, r->error);
}

/** Make triangles of all facets, once equal points are one node. */
static void make_triangles(stl_reader *r) {
    io_model *model = r->model;
    io_cells *triangles = &model->triangle;
    for (int64_t i = 0; i < r->normals->n; i++) {
        int32_t node[3];
        for (int k = 0; k < 3; k++)
            node[k] = model->place_node ? model->place_node[3 * i + k] : (int32_t)(3 * i + k);
        if (node[0] == node[1] || node[1] == node[2] || node[2] == node[0]) {
            for (int k = 0; k < 3; k++)
                io_hold_node(model, node[k], IO_HELD_BY_OTHER);
            model->n_other++;
            continue;
        }
        memcpy(triangles->nodes + 3 * triangles->n, node, sizeof node);
        triangles->entity[triangles->n] = triangles->entity[i];
        triangles->number[triangles->n++] = i + 1;
    }
    io_reduce_cell_numbers(triangles);
}

/* ---- binary --------------------------------------------------------------------------------- */

static int read_binary(stl_reader *r) {
    io_model *model = r->model;
    const char *data = model->input.data;
    const int64_t size = model->input.size;
    model->is_binary = 1;
    r->swapped = !io_machine_is_little();
    if (size < HEADER_SIZE)
        return io_fail_at(
            model, data, r->error,
            "neither 'solid' nor the %d bytes that a binary STL begins with (the file "
            "may be cut short)",
            HEADER_SIZE);
    const int64_t n = io_load_u32(data + COUNT_AT, r->swapped);
    const io_cursor facets = {data + HEADER_SIZE, data + size};
    int status = io_check_count(model, facets, n, FACET_SIZE, "facets", r->error);
    if (status)
        return status;
    if (size - HEADER_SIZE - n * FACET_SIZE >= FACET_SIZE)
        return io_fail_at(model, data + COUNT_AT, r->error,
                          "%lld facets are counted, but the file has room for %lld; the count is "
                          "wrong",
                          (long long)n, (long long)((size - HEADER_SIZE) / FACET_SIZE));
    int has_colours = 0;
    status = make_facets(r, n);
    for (int64_t i = 0; i < n && !status; i++) {
        const char *at = data + HEADER_SIZE + i * FACET_SIZE;
        for (int k = 0; k < 3 && !status; k++)
            status = io_load_node(model, at + POINTS_AT + k * POINT_SIZE, FLOAT_SIZE, r->swapped,
                                  3 * i + k, r->error);
        if (!status)
            status = add_facet(r, 0, at - data);
        has_colours |= at[COLOUR_AT] != 0 || at[COLOUR_AT + 1] != 0;
    }
    if (!status)
        status = io_model_note_lost(model, has_colours, "colours of facets", r->error);
    return status ? status : io_model_index_tags(model, 2, model->triangle.entity, n, r->error);
}

/* ---- text ----------------------------------------------------------------------------------- */

/** Count the words "facet" from the cursor on: no fewer than facets. */
static int64_t count_facets(io_cursor cursor) {
    int64_t n = 0;
    while (cursor.at < cursor.end)
        n += io_slice_is(io_next_word(&cursor), "facet", 1);
    return n;
}

/** Take the words of a phrase, in any letter case. */
static int take_words(stl_reader *r, const char *first, const char *second) {
    for (const char *word = first; word; word = word == first ? second : NULL) {
        io_skip_space(&r->cursor);
        const char *at = r->cursor.at;
        const io_slice found = io_next_word(&r->cursor);
        if (!io_slice_is(found, word, 1))
            return io_fail_at(r->model, at, r->error,
                              "facet %lld: '%s' expected, not '%.*s' (the file may be cut short)",
                              (long long)r->normals->n + 1, word, IO_QUOTED(found));
    }
    return PLANISH_OK;
}

/** Take a word in any letter case, if it is the next one. */
static int take_word_if(stl_reader *r, const char *word) {
    io_cursor cursor = r->cursor;
    io_skip_space(&cursor);
    const int is_there = io_slice_is(io_next_word(&cursor), word, 1);
    if (is_there)
        r->cursor = cursor;
    return is_there;
}

/** Pass over the normal of a facet, which may be anything, nan for instance. Return where it is. */
static int64_t pass_over_normal(stl_reader *r) {
    if (!take_word_if(r, "normal"))
        return NO_NORMAL;
    io_skip_space(&r->cursor);
    const int64_t at = r->cursor.at - r->model->input.data;
    for (int d = 0; d < 3; d++)
        io_next_word(&r->cursor);
    return at;
}

/** Read a facet from behind its first word. */
static int read_facet(stl_reader *r, int32_t entity) {
    io_model *model = r->model;
    const int64_t place = model->n_nodes;
    if (r->normals->n == r->room)
        return io_bytes_fail_changed(&model->input, r->error);
    const int64_t normal = pass_over_normal(r);
    int status = take_words(r, "outer", "loop");
    for (int k = 0; k < 3 && !status; k++) {
        status = take_words(r, "vertex", NULL);
        if (!status)
            status = io_read_node(model, &r->cursor, place + k, r->error);
    }
    if (!status)
        status = take_words(r, "endloop", "endfacet");
    return status ? status : add_facet(r, entity, normal);
}

/** Read the solid whose name stands at the cursor: a group of that name, or of none. */
static int read_solid(stl_reader *r, int32_t tag) {
    io_model *model = r->model;
    const io_slice name = io_slice_trim(io_next_line(&r->cursor));
    const int has_name = io_slice_length(name) > 0;
    const int32_t entity = io_model_entity(model, 2, tag, has_name, &tag, r->error);
    if (entity < 0)
        return entity;
    int status = has_name
                     ? io_model_group(model, 2, tag, name.begin, io_slice_length(name), r->error)
                     : PLANISH_OK;
    while (!status) {
        io_skip_space(&r->cursor);
        const char *at = r->cursor.at;
        const io_slice word = io_next_word(&r->cursor);
        if (io_slice_is(word, "endsolid", 1) ||
            (io_slice_is(word, "end", 1) && take_word_if(r, "solid")))
            return PLANISH_OK;
        if (!io_slice_is(word, "facet", 1))
            return io_fail_at(model, at, r->error,
                              "behind facet %lld: 'facet' or 'endsolid' expected, not '%.*s' (the "
                              "file may be cut short)",
                              (long long)r->normals->n, IO_QUOTED(word));
        status = read_facet(r, entity);
    }
    return status;
}

static int read_text(stl_reader *r) {
    io_model *model = r->model;
    int status = make_facets(r, count_facets(r->cursor));
    for (int32_t tag = 1; !status; tag++) {
        io_skip_space(&r->cursor);
        const char *at = r->cursor.at;
        if (at == r->cursor.end)
            return PLANISH_OK;
        if (!io_slice_is(io_next_word(&r->cursor), "solid", 1))
            return io_fail_at(model, at, r->error, "'solid' or the end of the file expected");
        status = read_solid(r, tag);
        if (status || r->cursor.at == r->cursor.end)
            return status;
        io_skip_line(&r->cursor); /* the name again */
    }
    return status;
}

/* ---- writing: normals ------------------------------------------------------------------------- */

/** The corners of a facet before and after, and its normal in the file. */
typedef struct stl_facet {
    double old[3][3], moved[3][3], normal[3];
    const char *begin[3], *end[3]; /* text: the numbers of the normal */
} stl_facet;

/** Find three numbers in text at a byte; what is no number is 0. */
static void find_numbers(const io_model *model, int64_t at, double *value, const char **begin,
                         const char **end) {
    io_cursor cursor = {model->input.data + at, io_input_end(model)};
    for (int d = 0; d < 3; d++) {
        const io_slice word = io_next_word(&cursor);
        if (io_slice_real(word, 0, &value[d]))
            value[d] = 0;
        if (begin) {
            begin[d] = word.begin;
            end[d] = word.end;
        }
    }
}

/** Load a facet and move its corners to coordinates [n_places][written]. Return whether it moves. */
static int load_facet(const io_model *model, int64_t facet, const double *coordinates,
                      stl_facet *f) {
    const stl_normals *normals = model->of_format;
    const int swapped = !io_machine_is_little();
    const char *at = model->input.data + HEADER_SIZE + facet * FACET_SIZE;
    int is_moved = 0;
    memset(f->normal, 0, sizeof f->normal);
    if (normals->at && normals->at[facet] != NO_NORMAL)
        find_numbers(model, normals->at[facet], f->normal, f->begin, f->end);
    for (int d = 0; !normals->at && d < 3; d++)
        f->normal[d] = (double)io_load_f32(at + d * FLOAT_SIZE, swapped);
    for (int k = 0; k < 3; k++) {
        const int64_t place = 3 * facet + k;
        if (normals->at)
            find_numbers(model, model->text_offset[place], f->old[k], NULL, NULL);
        for (int d = 0; !normals->at && d < 3; d++)
            f->old[k][d] =
                (double)io_load_f32(at + POINTS_AT + k * POINT_SIZE + d * FLOAT_SIZE, swapped);
        memcpy(f->moved[k], f->old[k], sizeof f->old[k]);
        for (int d = 0; d < model->written; d++) {
            const double value = coordinates[place * model->written + d];
            f->moved[k][d] = model->is_binary ? (double)(float)value : value;
        }
        for (int d = 0; d < 3; d++)
            is_moved |= f->moved[k][d] != f->old[k][d];
    }
    return is_moved;
}

/** Find the unit normal of a triangle; 0 where it has none. */
static int find_normal(const double x[3][3], double normal[3]) {
    double a[3], b[3], size = 0;
    for (int d = 0; d < 3; d++) {
        a[d] = x[1][d] - x[0][d];
        b[d] = x[2][d] - x[0][d];
        size = fmax(size, fmax(fabs(a[d]), fabs(b[d])));
    }
    for (int d = 0; d < 3; d++) {
        a[d] /= size;
        b[d] /= size;
    }
    for (int d = 0; d < 3; d++)
        normal[d] = a[(d + 1) % 3] * b[(d + 2) % 3] - a[(d + 2) % 3] * b[(d + 1) % 3];
    const double length =
        sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    for (int d = 0; d < 3; d++)
        normal[d] /= length;
    return length > 0 && isfinite(length);
}

/** Find the normal that a moved facet gets, on the side where that of the file is. One of length 0
 *  says that readers find it themselves, and stays. Return whether it changes. */
static int renew_normal(const stl_facet *f, double normal[3]) {
    const double *n = f->normal;
    double old[3];
    if ((n[0] == 0 && n[1] == 0 && n[2] == 0) || !find_normal(f->moved, normal))
        return 0;
    const int had = find_normal(f->old, old);
    const int is_turned = had && n[0] * old[0] + n[1] * old[1] + n[2] * old[2] < 0;
    int differs = 0;
    for (int d = 0; d < 3; d++) {
        normal[d] = (double)(float)(is_turned ? -normal[d] : normal[d]) + 0.0;
        differs |= normal[d] != n[d];
    }
    return differs;
}

/** Make the bytes [3 * IO_REAL_SIZE + between] that replace a normal: in text what is between the
 *  numbers stays, and so do numbers of the same value. Return their number. */
static int64_t put_normal(const io_model *model, const stl_facet *f, const double normal[3],
                          char *text) {
    int64_t length = 0;
    for (int d = 0; d < 3; d++) {
        if (model->is_binary) {
            const float single = (float)normal[d];
            uint32_t bits;
            memcpy(&bits, &single, sizeof bits);
            bits = io_machine_is_little() ? bits : io_swap_u32(bits);
            memcpy(text + length, &bits, sizeof bits);
            length += FLOAT_SIZE;
            continue;
        }
        if (d > 0) {
            const int64_t between = f->begin[d] - f->end[d - 1];
            memcpy(text + length, f->end[d - 1], (size_t)between);
            length += between;
        }
        const int64_t same = normal[d] == f->normal[d] ? f->end[d] - f->begin[d] : 0;
        memcpy(text + length, f->begin[d], (size_t)same);
        length += same > 0 ? same : io_format_real(text + length, normal[d], 1);
    }
    return length;
}

/** Add edits of the normals of facets that move. */
static int stl_encode(const io_model *model, const double *coordinates, int threads,
                      io_edits *edits, planish_error *error) {
    const stl_normals *normals = model->of_format;
    int status = PLANISH_OK;
    (void)threads;
    for (int64_t i = 0; i < normals->n && !status; i++) {
        stl_facet f;
        double normal[3];
        if (!load_facet(model, i, coordinates, &f) || !renew_normal(&f, normal))
            continue;
        io_edit edit = {.begin = HEADER_SIZE + i * FACET_SIZE};
        edit.end = edit.begin + POINTS_AT;
        if (normals->at) {
            edit.begin = f.begin[0] - model->input.data;
            edit.end = f.end[2] - model->input.data;
        }
        edit.text = pl_alloc(edit.end - edit.begin + 3 * IO_REAL_SIZE, 1);
        if (!edit.text)
            return pl_fail_memory(error, "the normals of facets");
        edit.length = put_normal(model, &f, normal, edit.text);
        status = io_edits_add(edits, edit, error);
    }
    return status;
}

/* ---- the format ----------------------------------------------------------------------------- */

/** Return whether size bytes are those of a binary file with as many facets as it says. */
static int is_binary(const char *data, int64_t size) {
    return size > HEADER_SIZE &&
           HEADER_SIZE +
                   FACET_SIZE * (int64_t)io_load_u32(data + COUNT_AT, !io_machine_is_little()) ==
               size;
}

/** Return whether the bytes begin as text: solid, a name, and a facet or the end. */
static int is_text(const char *data, int64_t size) {
    io_cursor cursor = io_begin_text(data, size);
    if (!io_slice_is(io_next_word(&cursor), "solid", 1))
        return 0;
    io_skip_line(&cursor);
    const io_slice word = io_next_word(&cursor);
    return io_slice_is(word, "facet", 1) || io_slice_is(word, "endsolid", 1);
}

static int stl_read(io_model *model, planish_error *error) {
    enum { LOOKED_AT = 512 }; /* bytes of which a binary file has one that no text has */
    const io_bytes *input = &model->input;
    stl_reader r = {
        .model = model, .error = error, .cursor = io_begin_text(input->data, input->size)};
    io_cursor first = r.cursor;
    model->groups_by_name = 1;
    const int64_t looked_at = input->size < LOOKED_AT ? input->size : LOOKED_AT;
    const int begins = io_slice_is(io_next_word(&first), "solid", 1) &&
                       !memchr(input->data, '\0', (size_t)looked_at);
    int status = begins && !is_binary(input->data, input->size) ? read_text(&r) : read_binary(&r);
    if (!status)
        status = io_weld_nodes(model, error);
    if (!status)
        make_triangles(&r);
    return status;
}

static int stl_recognise(const char *data, int64_t size) {
    return is_text(data, size) || is_binary(data, size);
}

static void stl_release(io_model *model) {
    stl_normals *normals = model->of_format;
    if (normals)
        pl_free(normals->at);
    pl_free(normals);
}

static const char *const extensions[] = {".stl", NULL};

const io_format io_format_stl = {.name = "stl",
                                 .extensions = extensions,
                                 .recognise = stl_recognise,
                                 .read = stl_read,
                                 .encode = stl_encode,
                                 .release = stl_release,
                                 .targets = stl_targets,
                                 .check_target = io_surface_check};
