/* splice: planish_file_write, for every format: the input's bytes, with the coordinates that
 * changed replaced where they stand.
 *
 * Nodes are taken in chunks; the text of a chunk is made by one thread, and chunks are written in
 * the file's order, with the bytes between them copied from the input. A component that did not
 * change keeps its bytes, found by reading it again.
 *
 * The input may be mapped, and others may write to it at any moment. So it is compared with what
 * was read before it is read again and when all is written. Between the two nothing relies on it:
 * every field must be within the stretch that its piece has, behind the fields before it, and every
 * byte that is appended must have room.
 */
#include "io/core/bytes.h"
#include "io/file/companions.h"
#include "io/core/copies.h"
#include "io/core/number.h"
#include "io/core/output.h"
#include "io/file/plane.h"
#include "io/core/text.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/round.h"
#include "base/status.h"
#include "base/system.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { CHUNK_NODES = 8192 };

typedef enum piece_state {
    PIECE_MADE,
    PIECE_OUT_OF_MEMORY,
    PIECE_CHANGED /* the input is not what was read */
} piece_state;

/** A run of nodes of one span and the bytes that replace its stretch of the file. */
typedef struct piece {
    const char *begin, *end; /* the stretch: from the first coordinate to behind the last */
    char *text;              /* [length] owned */
    int64_t length;
    piece_state state;
} piece;

typedef struct splice {
    const io_format *format;
    const io_model *model;
    const double *coordinates; /* [n_nodes][written] */
    const io_span *span;
    int64_t first; /* node of the span where the wave of pieces begins */
    piece *pieces; /* [threads] */
    int threads;
    const io_edits *edits; /* besides the pieces, and */
    int64_t next_edit;     /* the first that has not been written */
} splice;

/* ---- one node ----------------------------------------------------------------------------- */

/** A component as the reader would read it. */
static double as_read(const io_model *model, double value) {
    return model->precision == PLANISH_FLOAT ? pl_round_to_float(value) : value;
}

/** Whether a component keeps its bytes. Of a node with several places some may have -0 where others
 *  have 0: all of these stay. */
static int is_kept(const io_model *model, double before, double wanted) {
    return pl_is_same(before, wanted) || (model->place_node && before == wanted);
}

static char *append(char *to, const char *from, const char *end) {
    memcpy(to, from, (size_t)(end - from));
    return to + (end - from);
}

/** Where the text of a piece goes. */
typedef struct sink {
    char *at, *end;
    const char *from, *from_end; /* what of the piece's stretch has not been copied yet */
    int is_full;                 /* there was no room, or no such stretch: the input has changed */
} sink;

/** Room for length bytes, or NULL. */
static char *take_room(sink *to, int64_t length) {
    if (length < 0 || length > to->end - to->at) {
        to->is_full = 1;
        return NULL;
    }
    char *at = to->at;
    to->at += length;
    return at;
}

static void put(sink *to, const char *from, int64_t length) {
    char *at = take_room(to, length);
    if (at)
        memcpy(at, from, (size_t)length);
}

static void put_blanks(sink *to, int64_t n) {
    char *at = take_room(to, n > 0 ? n : 0);
    if (at)
        memset(at, ' ', (size_t)(n > 0 ? n : 0));
}

/** Copy the input as far as stop, and go on behind at next. */
static void copy_to(sink *to, const char *stop, const char *next) {
    if (stop < to->from || next < stop || next > to->from_end) {
        to->is_full = 1;
        return;
    }
    put(to, to->from, stop - to->from);
    to->from = next;
}

static int plain_field(io_cursor *cursor, io_field *field) {
    *field = (io_field){.width = 0};
    io_skip_space_comments(cursor, '#');
    field->begin = cursor->at;
    if (io_parse_real(&cursor->at, cursor->end, &field->value))
        return -1;
    field->end = cursor->at;
    return 0;
}

/** The field of coordinate d; it was read before, so that it cannot fail. */
static int next_field(const splice *s, io_cursor *cursor, int d, io_field *field) {
    return s->format->field ? s->format->field(s->model, cursor, d, field)
                            : plain_field(cursor, field);
}

/** The number in place of what the field has. */
static void put_number(const splice *s, const io_field *field, double value, sink *to) {
    char text[IO_REAL_SIZE];
    if (field->width == 0) {
        put(to, text, io_format_real(text, value, s->model->precision == PLANISH_FLOAT));
        return;
    }
    const int64_t length = io_format_field(text, value, field->width, s->model->implied_exponent);
    if (length == 0) { /* no such text: what is there stays */
        put(to, field->begin, field->end - field->begin);
        return;
    }
    put(to, text, length);
    put_blanks(to, field->is_fixed ? field->end - field->begin - length : 0);
}

/** What has to be written before a number behind fields that the file cuts short or has not. */
typedef struct gap {
    char text[3 * (IO_LEAD_SIZE + IO_REAL_SIZE)];
    int64_t length;
} gap;

/** n_lead and blanks are IO_LEAD_SIZE and IO_REAL_SIZE at most, three times. */
static void gap_add(gap *g, const char *lead, int n_lead, int64_t blanks) {
    char *to = g->text + g->length;
    if (n_lead > 0)
        to = append(to, lead, lead + n_lead);
    memset(to, ' ', (size_t)blanks);
    g->length = to + blanks - g->text;
}

static int is_sound(const io_field *field, const sink *to) {
    return field->begin >= to->from && field->end >= field->begin && field->end <= to->from_end &&
           field->n_lead >= 0 && field->n_lead <= IO_LEAD_SIZE && field->width < IO_REAL_SIZE;
}

/** Copy one node's text with changed components replaced. */
static void splice_text_node(const splice *s, int64_t node, sink *to) {
    const io_model *model = s->model;
    io_cursor cursor = {model->input.data + model->text_offset[node],
                        model->input.data + model->input.size};
    gap before;
    before.length = 0;
    const char *line_end = NULL; /* if the field before has not its full width */
    for (int d = 0; d < model->written && !to->is_full; d++) {
        double wanted = s->coordinates[node * model->written + d];
        io_field field;
        if (next_field(s, &cursor, d, &field) || !is_sound(&field, to)) {
            to->is_full = 1;
            return;
        }
        int64_t filled = field.end - field.begin;
        if (!field.lead || field.begin != line_end)
            before.length = 0;
        line_end = field.end;
        gap_add(&before, field.lead, field.n_lead, 0);
        if (!is_kept(model, as_read(model, field.value), wanted)) {
            copy_to(to, field.begin, field.end);
            put(to, before.text, before.length);
            before.length = 0;
            const char *number = to->at;
            put_number(s, &field, wanted, to);
            filled = to->at - number;
        }
        if (field.is_fixed && filled < field.width)
            gap_add(&before, NULL, 0, field.width - filled);
    }
}

static void swap_bytes(char *bytes, int size) {
    for (int i = 0; i < size / 2; i++) {
        char t = bytes[i];
        bytes[i] = bytes[size - 1 - i];
        bytes[size - 1 - i] = t;
    }
}

/** Coordinates of a node that stand side by side and are wanted. */
static int components_of(const splice *s) {
    const int written = s->model->written, of_span = s->span->n_components;
    const int left = written > s->span->component ? written - s->span->component : 0;
    return of_span > 0 && of_span < left ? of_span : left;
}

/** Replace the changed components of one node in a copy of its bytes. */
static void splice_binary_node(const splice *s, int64_t node, char *bytes) {
    const int is_float = s->span->encoding == IO_FLOAT32;
    const int size = is_float ? (int)sizeof(float) : (int)sizeof(double);
    const int last = s->span->component + components_of(s);
    for (int d = s->span->component; d < last; d++, bytes += size) {
        double wanted = s->coordinates[node * s->model->written + d], value = wanted;
        float single = (float)wanted;
        char now[sizeof(double)];
        memcpy(now, bytes, (size_t)size);
        if (s->span->swapped)
            swap_bytes(now, size);
        if (is_float) {
            float before;
            memcpy(&before, now, sizeof before);
            if (is_kept(s->model, before, single))
                continue;
            memcpy(now, &single, sizeof single);
        } else {
            double before;
            memcpy(&before, now, sizeof before);
            if (is_kept(s->model, before, wanted))
                continue;
            memcpy(now, &value, sizeof value);
        }
        if (s->span->swapped)
            swap_bytes(now, size);
        memcpy(bytes, now, (size_t)size);
    }
}

/* ---- one piece ---------------------------------------------------------------------------- */

/** The stretch of a piece: up to behind the last coordinate of its last node, before the next one.
 *  0, or -1: it is not as it was read. */
static int find_stretch(const splice *s, int64_t first, int64_t last, piece *p) {
    const io_model *model = s->model;
    const char *data = model->input.data, *end = data + model->input.size;
    io_cursor cursor = {data + model->text_offset[last - 1], end};
    io_field field = {.end = NULL};
    p->begin = data + model->text_offset[first];
    if (last < s->span->first_node + s->span->n_nodes)
        end = data + model->text_offset[last];
    for (int d = 0; d < model->written; d++)
        if (next_field(s, &cursor, d, &field))
            return -1;
    p->end = field.end;
    return p->begin <= p->end && p->end <= end ? 0 : -1;
}

static void make_text(const splice *s, int64_t first, int64_t last, piece *p) {
    if (find_stretch(s, first, last, p)) {
        p->state = PIECE_CHANGED;
        return;
    }
    const int64_t room =
        p->end - p->begin + (last - first) * s->model->written * (IO_REAL_SIZE + IO_LEAD_SIZE);
    p->text = pl_alloc(room, 1);
    if (!p->text) {
        p->state = PIECE_OUT_OF_MEMORY;
        return;
    }
    sink to = {.at = p->text, .end = p->text + room, .from = p->begin, .from_end = p->end};
    for (int64_t node = first; node < last && !to.is_full; node++)
        splice_text_node(s, node, &to);
    if (!to.is_full)
        copy_to(&to, p->end, p->end);
    p->length = to.at - p->text;
    p->state = to.is_full ? PIECE_CHANGED : PIECE_MADE;
}

static void make_binary(const splice *s, int64_t first, int64_t last, piece *p) {
    const io_span *span = s->span;
    int size = span->encoding == IO_FLOAT32 ? (int)sizeof(float) : (int)sizeof(double);
    const char *data = s->model->input.data + span->offset;
    p->begin = data + (first - span->first_node) * span->stride;
    p->end = data + (last - 1 - span->first_node) * span->stride + components_of(s) * size;
    p->length = p->end - p->begin;
    p->text = pl_alloc(p->length, 1);
    if (!p->text) {
        p->state = PIECE_OUT_OF_MEMORY;
        return;
    }
    append(p->text, p->begin, p->end);
    for (int64_t node = first; node < last; node++)
        splice_binary_node(s, node, p->text + (node - first) * span->stride);
}

static void make_piece(void *context, int64_t begin, int64_t end, int thread) {
    const splice *s = context;
    (void)end;
    (void)thread;
    int64_t last_of_span = s->span->first_node + s->span->n_nodes;
    int64_t first = s->first + begin * CHUNK_NODES;
    int64_t last = last_of_span - first < CHUNK_NODES ? last_of_span : first + CHUNK_NODES;
    piece *p = &s->pieces[begin];
    *p = (piece){.state = PIECE_MADE};
    if (s->span->encoding == IO_TEXT)
        make_text(s, first, last, p);
    else
        make_binary(s, first, last, p);
}

/* ---- the file ----------------------------------------------------------------------------- */

/** Write the input's bytes from at to end, with the edits among them made. */
static int copy_input(splice *s, const char *at, const char *end, io_output *output,
                      planish_error *error) {
    const char *data = s->model->input.data;
    int status = PLANISH_OK;
    for (; !status && s->next_edit < s->edits->n; s->next_edit++) {
        const io_edit *edit = &s->edits->edit[s->next_edit];
        if (data + edit->begin >= end)
            break;
        if (data + edit->begin < at || edit->end < edit->begin || data + edit->end > end)
            return io_bytes_fail_changed(&s->model->input, error);
        status = io_output_write(output, at, data + edit->begin - at, error);
        if (!status)
            status = io_output_write(output, edit->text, edit->length, error);
        at = data + edit->end;
    }
    return status ? status : io_output_write(output, at, end - at, error);
}

/** Make and write the pieces of one wave; *at: how far the input has been written. */
static int write_wave(splice *s, int64_t n_pieces, const char **at, io_output *output,
                      planish_error *error) {
    int status = PLANISH_OK;
    pl_parallel_for(s->threads, n_pieces, 1, make_piece, s);
    for (int64_t i = 0; i < n_pieces; i++) {
        piece *p = &s->pieces[i];
        if (!status && p->state == PIECE_OUT_OF_MEMORY)
            status = pl_fail_memory(error, "the text of coordinates");
        if (!status && (p->state == PIECE_CHANGED || p->begin < *at))
            status = io_bytes_fail_changed(&s->model->input, error);
        if (!status)
            status = copy_input(s, *at, p->begin, output, error);
        if (!status)
            status = io_output_write(output, p->text, p->length, error);
        *at = p->end;
        pl_free(p->text);
    }
    return status;
}

static int write_spans(splice *s, io_output *output, planish_error *error) {
    const io_model *model = s->model;
    const int64_t wave = s->threads;
    const char *at = model->input.data, *end = at + model->input.size;
    int status = PLANISH_OK;
    for (int64_t i = 0; i < model->n_spans && !status; i++) {
        s->span = &model->span[i];
        int64_t n_pieces = (s->span->n_nodes + CHUNK_NODES - 1) / CHUNK_NODES;
        for (int64_t done = 0; done < n_pieces && !status; done += wave) {
            s->first = s->span->first_node + done * CHUNK_NODES;
            status =
                write_wave(s, n_pieces - done < wave ? n_pieces - done : wave, &at, output, error);
        }
    }
    return status ? status : copy_input(s, at, end, output, error);
}

static int write_main(const planish_file *file, const double *coordinates, int threads,
                      io_output *output, planish_error *error) {
    io_edits edits = {0};
    splice s = {.format = file->format,
                .model = &file->model,
                .coordinates = coordinates,
                .threads = threads,
                .pieces = pl_alloc(threads, sizeof *s.pieces),
                .edits = &edits};
    int status = s.pieces ? PLANISH_OK : pl_fail_memory(error, "the text of coordinates");
    if (!status && file->format->amend && !output->temporary)
        status = file->format->amend(&file->model, coordinates, output, error);
    if (!status && file->model.encoding && file->format->encode)
        status = file->format->encode(&file->model, coordinates, threads, &edits, error);
    if (!status)
        status = write_spans(&s, output, error);
    io_edits_destroy(&edits);
    pl_free(s.pieces);
    return status ? status : io_output_finish(output, error);
}

/** What the format changes in the finished copy itself. */
static int amend_main(const planish_file *file, const double *coordinates, io_output *output,
                      planish_error *error) {
    if (!file->format->amend || !file->model.encoding || !output->temporary)
        return PLANISH_OK;
    /* It may have the mode of a file that must not be written, or read. */
    const int former = pl_file_make_accessible(output->temporary);
    const int status = file->format->amend(&file->model, coordinates, output, error);
    if (former >= 0)
        pl_file_set_mode(output->temporary, former);
    return status;
}

/* ---- the file and its companions ----------------------------------------------------------- */

static int same_file(const char *a, const char *b) {
    pl_file_status x, y;
    return pl_file_find(a, &x) == 0 && pl_file_find(b, &y) == 0 && pl_file_is_same(&x, &y);
}

static int write_companion(const io_format *format, const io_bytes *companion, const char *path,
                           io_temporaries temporaries, io_output *output, planish_error *error) {
    char *target = io_companion_path(format, path, io_extension(companion->path));
    if (!target)
        return pl_fail_memory(error, companion->path);
    int status = PLANISH_OK;
    if (!same_file(target, companion->path)) {
        status = io_output_open(target, temporaries, output, error);
        if (!status)
            status = io_output_write(output, companion->data, companion->size, error);
        if (!status)
            status = io_output_finish(output, error);
    }
    pl_free(target);
    return status;
}

/** What is written as it is, and in the input itself, would be read while it is overwritten. */
static int check_not_input(const io_bytes *input, const io_output *output, planish_error *error) {
    if (output->temporary || !io_bytes_are_of(input, output->fd))
        return PLANISH_OK;
    return pl_fail(error, PLANISH_ERROR_FILE,
                   "%s: is the input, which cannot be overwritten while it is read; give the "
                   "input's name to replace it",
                   output->target);
}

/** Whether the files are still what was read; where the input is replaced, those beside it stay. */
static int check_inputs_unchanged(const planish_file *file, planish_error *error) {
    int status = io_bytes_check_unchanged(&file->model.input, error);
    for (int i = 0; i < file->model.n_companions && !status; i++)
        status = io_bytes_check_unchanged(&file->model.companion[i], error);
    return status;
}

/** A failure that comes of an input that changed is better told so. */
static int explain(const planish_file *file, int status, planish_error *error) {
    planish_error changed;
    if (status != PLANISH_OK && check_inputs_unchanged(file, &changed)) {
        if (error)
            *error = changed;
        return changed.code;
    }
    return status;
}

static void tell_replaced(planish_error *error, int n) {
    const size_t used = error ? strlen(error->text) : 0;
    if (error)
        snprintf(error->text + used, sizeof error->text - used,
                 "; %d other file%s of the new mesh %s in place already", n, n == 1 ? "" : "s",
                 n == 1 ? "is" : "are");
}

/** Rename all temporary files: the one with the coordinates, the first, in the end, so that no file
 *  is new if that one is not. */
static int commit_all(io_output *output, int n, io_temporaries temporaries, planish_error *error) {
    int status = PLANISH_OK, replaced = 0;
    for (int i = n - 1; i >= 0 && !status; i--) {
        status = io_output_commit(&output[i], temporaries, error);
        replaced += !status && output[i].is_committed && output[i].replaces;
    }
    for (int i = 0; i < n && status; i++)
        io_output_undo(&output[i]);
    if (status && replaced > 0)
        tell_replaced(error, replaced);
    return status;
}

/** Write all temporary files, then rename all. output [1 + n_companions]. */
static int write_all(const planish_file *file, const char *path, const char *main_path,
                     const double *coordinates, int threads, io_temporaries temporaries,
                     io_output *output, int n_companions, planish_error *error) {
    int status = check_inputs_unchanged(file, error); /* before they are read again */
    if (!status)
        status = io_output_open(main_path, temporaries, &output[0], error);
    if (!status)
        status = check_not_input(&file->model.input, &output[0], error);
    if (!status)
        status = write_main(file, coordinates, threads, &output[0], error);
    if (!status)
        status = amend_main(file, coordinates, &output[0], error);
    for (int i = 0; i < n_companions && !status; i++)
        status = write_companion(file->format, &file->model.companion[i], path, temporaries,
                                 &output[i + 1], error);
    status = status ? explain(file, status, error) : check_inputs_unchanged(file, error);
    if (!status)
        status = commit_all(output, 1 + n_companions, temporaries, error);
    for (int i = 0; i <= n_companions; i++)
        io_output_release(&output[i], temporaries);
    return status;
}

static int check_name(const planish_file *file, const char *path, planish_error *error) {
    char list[64] = "";
    if (planish_file_can_write(file, path))
        return PLANISH_OK;
    for (const char *const *e = file->format->extensions; *e; e++) {
        const size_t used = strlen(list);
        char name[32];
        snprintf(name, sizeof name, "x%s", *e);
        if (planish_file_can_write(file, name))
            snprintf(list + used, sizeof list - used, "%s%s", used > 0 ? ", " : "", *e);
    }
    return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                   "%s: does not have an extension of the input's format, %s (%s)", path,
                   file->format->name, list);
}

static int check_finite(const planish_file *file, const double *coordinates, planish_error *error) {
    const int dim = file->model.dim;
    for (int64_t i = 0; i < dim * file->model.n_nodes; i++)
        if (!(fabs(coordinates[i]) <= DBL_MAX))
            return pl_fail_at(error, PLANISH_ERROR_ARGUMENT, -1, i / dim,
                              "coordinate %d of node %lld is not finite", (int)(i % dim),
                              (long long)(i / dim));
    return PLANISH_OK;
}

int planish_file_check_output(const planish_file *file, const char *path, planish_error *error) {
    if (!file || !path)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "file and path must not be NULL");
    const int status = check_name(file, path, error);
    if (status)
        return status;
    if (file->format->amend && file->model.encoding && io_output_is_stream(path))
        return pl_fail(error, PLANISH_ERROR_FILE,
                       "%s: its coordinates are compressed or packed, so that the result cannot be "
                       "written to a pipe or device; give the name of a file",
                       file->model.input.path);
    return io_check_strangers(file, path, error);
}

int planish_file_write(const planish_file *file, const char *path, const double *coordinates,
                       int threads, char *temporary, size_t temporary_size, planish_error *error) {
    if (!file || !path || !coordinates)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "file, path and coordinates must not be NULL");
    const pl_outside outside = pl_call_enter(NULL);
    const int n_companions = io_companions_to_write(file, path);
    const double *places = NULL;
    double *owned = NULL, *owned_places = NULL;
    char *main_path =
        io_output_is_stream(path) ? pl_copy_text(path) : io_main_path(file->format, path);
    io_output *output = pl_alloc(n_companions + 1, sizeof *output);
    int status = main_path && output ? PLANISH_OK : pl_fail_memory(error, path);
    if (!status)
        status = check_name(file, path, error);
    if (!status)
        status = check_finite(file, coordinates, error);
    if (!status)
        status = io_model_places(&file->model, coordinates, pl_thread_count(threads), &places,
                                 &owned, error);
    if (!status)
        status = io_copies_places(&file->model, places, pl_thread_count(threads), &places,
                                  &owned_places, error);
    for (int i = 0; i <= n_companions && output; i++)
        output[i] = (io_output){.fd = -1};
    if (!status)
        status = io_check_strangers(file, path, error);
    if (!status)
        status =
            write_all(file, path, main_path, places, pl_thread_count(threads),
                      (io_temporaries){temporary, temporary_size}, output, n_companions, error);
    pl_free(owned_places);
    pl_free(owned);
    pl_free(output);
    pl_free(main_path);
    pl_call_leave(&outside);
    return status;
}
