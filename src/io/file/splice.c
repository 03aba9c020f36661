/* splice: what planish_file_write writes, for every format: the input's bytes, with the coordinates
 * that changed replaced where they stand.
 *
 * Nodes are taken in chunks; the text of a chunk is made by one thread, and chunks are written in
 * the file's order, with the bytes between them copied from the input. A component that did not
 * change keeps its bytes, found by reading it again.
 *
 * The input may be mapped, and others may write to it at any moment. So it is compared with what
 * was read before it is read again and when all is written (write.c). Between the two nothing
 * relies on it: every field must be within the stretch that its piece has, behind the fields before
 * it, and every byte that is appended must have room.
 */
#include "io/core/binary.h"
#include "io/core/bytes.h"
#include "io/core/gzip.h"
#include "io/core/number.h"
#include "base/output.h"
#include "io/core/text.h"
#include "io/file/file.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/round.h"
#include "base/status.h"
#include "base/system.h"

#include <string.h>

enum { CHUNK_NODES = 8192, GATHERED = 1 << 15 };

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
    const io_edits *edits;   /* besides the pieces, and */
    int64_t next_edit;       /* the first that has not been written */
    char gathered[GATHERED]; /* [n_gathered] short pieces that are written together */
    int64_t n_gathered;
} splice;

/** Return whether a component keeps its bytes. Of a node with several places some may have -0 where
 *  others have 0: all of these stay. */
static int is_kept(const io_model *model, double before, double wanted) {
    return pl_is_same(before, wanted) || (model->place_node && before == wanted);
}

/* ---- a node in text ------------------------------------------------------------------------- */

/** Room for the text of a piece. */
typedef struct sink {
    char *at, *end;
    const char *from, *from_end; /* what of the piece's stretch has not been copied yet */
    int is_full;                 /* there was no room, or no such stretch: the input has changed */
} sink;

/** Take room for length bytes; NULL: there is none. */
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

/** Copy the input as far as stop, and go on behind at next. */
static void copy_to(sink *to, const char *stop, const char *next) {
    if (stop < to->from || next < stop || next > to->from_end) {
        to->is_full = 1;
        return;
    }
    put(to, to->from, stop - to->from);
    to->from = next;
}

/** Read the field of coordinate d. It was read before, so that it fails only where the input has
 *  changed. 0 or -1. */
static int next_field(const splice *s, io_cursor *cursor, int d, io_field *field) {
    if (s->format->field)
        return s->format->field(s->model, cursor, d, field);
    *field = (io_field){.width = 0};
    io_skip_space_comments(cursor, '#');
    field->begin = cursor->at;
    if (io_parse_real(&cursor->at, cursor->end, &field->value))
        return -1;
    field->end = cursor->at;
    return 0;
}

static void put_blanks(sink *to, int64_t n) {
    char *at = n > 0 ? take_room(to, n) : NULL;
    if (at)
        memset(at, ' ', (size_t)n);
}

/** Put the number in place of what the field has. */
static void put_number(const splice *s, const io_field *field, double value, sink *to) {
    char text[IO_REAL_SIZE];
    if (field->width == 0) {
        put(to, text, io_format_real(text, value, s->model->precision == PLANISH_PRECISION_FLOAT));
        return;
    }
    const io_exponent exponent = s->model->exponent;
    const int64_t length = io_format_field(text, value, field->width, exponent);
    if (length == 0) { /* no such text: what is there stays */
        put(to, field->begin, field->end - field->begin);
        return;
    }
    char *letter = exponent == IO_EXPONENT_ALWAYS ? memchr(text, 'e', (size_t)length) : NULL;
    if (letter)
        *letter = s->model->exponent_letter;
    const int64_t blanks = field->is_fixed ? field->end - field->begin - length : 0;
    put_blanks(to, letter ? blanks : 0); /* blanks behind an exponent may be read as zeros */
    put(to, text, length);
    put_blanks(to, letter ? 0 : blanks);
}

/** Text that has to be written before a number behind fields that the file cuts short or has not.
 */
typedef struct gap {
    char text[3 * (IO_LEAD_SIZE + IO_REAL_SIZE)];
    int64_t length;
} gap;

/** Add a lead and blanks, IO_LEAD_SIZE and IO_REAL_SIZE at most, three times. */
static void gap_add(gap *g, const char *lead, int n_lead, int64_t blanks) {
    if (n_lead > 0)
        memcpy(g->text + g->length, lead, (size_t)n_lead);
    memset(g->text + g->length + n_lead, ' ', (size_t)blanks);
    g->length += n_lead + blanks;
}

static int is_sound(const io_field *field, const sink *to) {
    return field->begin >= to->from && field->end >= field->begin && field->end <= to->from_end &&
           field->n_lead >= 0 && field->n_lead <= IO_LEAD_SIZE && field->width < IO_REAL_SIZE;
}

/** Copy one node's text with changed components replaced. */
static void splice_text_node(const splice *s, int64_t node, sink *to) {
    const io_model *model = s->model;
    const int first = s->span->component, last = first + io_span_written(model, s->span);
    io_cursor cursor = {model->input.data + io_text_place(model, s->span, node),
                        model->input.data + model->input.size};
    gap before;
    before.length = 0;
    const char *line_end = NULL; /* if the field before has not its full width */
    for (int d = first; d < last && !to->is_full; d++) {
        const double wanted = s->coordinates[node * model->written + d];
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
        const int is_float =
            model->precision == PLANISH_PRECISION_FLOAT; /* and was rounded to that */
        if (!is_kept(model, is_float ? pl_round_to_float(field.value) : field.value, wanted)) {
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

/* ---- a piece -------------------------------------------------------------------------------- */

static void make_text(const splice *s, int64_t first, int64_t last, piece *p) {
    const io_model *model = s->model;
    const char *data = model->input.data, *end = data + model->input.size;
    /* The stretch goes up to behind the last coordinate of its last node, before the next one. */
    io_cursor cursor = {data + io_text_place(model, s->span, last - 1), end};
    io_field field = {.end = NULL};
    p->begin = data + io_text_place(model, s->span, first);
    p->state = PIECE_CHANGED;
    if (last < s->span->first_node + s->span->n_nodes)
        end = data + io_text_place(model, s->span, last);
    for (int d = 0; d < io_span_written(model, s->span); d++)
        if (next_field(s, &cursor, s->span->component + d, &field))
            return;
    p->end = field.end;
    if (p->end < p->begin || p->end > end)
        return;
    const int64_t room =
        p->end - p->begin + (last - first) * model->written * (IO_REAL_SIZE + IO_LEAD_SIZE);
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

/** Replace the changed ones of n components of one node in a copy of its bytes. */
static void splice_binary_node(const splice *s, int64_t node, int n, char *bytes) {
    const io_span *span = s->span;
    const int size = span->encoding == IO_FLOAT32 ? (int)sizeof(float) : (int)sizeof(double);
    const double *wanted = s->coordinates + node * s->model->written + span->component;
    for (int c = 0; c < n; c++, bytes += size) {
        const float single = (float)wanted[c];
        if (span->encoding == IO_FLOAT32) {
            if (is_kept(s->model, io_load_f32(bytes, span->swapped), single))
                continue;
            memcpy(bytes, &single, sizeof single);
        } else {
            if (is_kept(s->model, io_load_f64(bytes, span->swapped), wanted[c]))
                continue;
            memcpy(bytes, &wanted[c], sizeof wanted[c]);
        }
        for (int i = 0; span->swapped && i < size / 2; i++) {
            const char byte = bytes[i];
            bytes[i] = bytes[size - 1 - i];
            bytes[size - 1 - i] = byte;
        }
    }
}

static void make_binary(const splice *s, int64_t first, int64_t last, piece *p) {
    const io_span *span = s->span;
    const int size = span->encoding == IO_FLOAT32 ? (int)sizeof(float) : (int)sizeof(double);
    const char *data = s->model->input.data + span->offset;
    const int n = io_span_written(s->model, span);
    p->begin = data + (first - span->first_node) * span->stride;
    p->end = data + (last - 1 - span->first_node) * span->stride + n * size;
    p->length = p->end - p->begin;
    p->text = pl_alloc(p->length, 1);
    if (!p->text) {
        p->state = PIECE_OUT_OF_MEMORY;
        return;
    }
    memcpy(p->text, p->begin, (size_t)p->length);
    for (int64_t node = first; node < last; node++)
        splice_binary_node(s, node, n, p->text + (node - first) * span->stride);
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

/** Write what has been gathered. */
static int flush(splice *s, pl_output *output, planish_error *error) {
    const int64_t n = s->n_gathered;
    s->n_gathered = 0;
    return pl_output_write(output, s->gathered, n, error);
}

/** Write bytes, short ones with others: a file of many spans has little in each. */
static int gather(splice *s, const char *bytes, int64_t n, pl_output *output,
                  planish_error *error) {
    const int is_long = n > GATHERED / 2;
    int status = is_long || n > GATHERED - s->n_gathered ? flush(s, output, error) : PLANISH_OK;
    if (status || is_long)
        return status ? status : pl_output_write(output, bytes, n, error);
    if (n > 0)
        memcpy(s->gathered + s->n_gathered, bytes, (size_t)n);
    s->n_gathered += n;
    return PLANISH_OK;
}

/** Write the input's bytes from at to end, with the edits among them made. */
static int copy_input(splice *s, const char *at, const char *end, pl_output *output,
                      planish_error *error) {
    const char *data = s->model->input.data;
    int status = PLANISH_OK;
    for (; !status && s->next_edit < s->edits->n; s->next_edit++) {
        const io_edit *edit = &s->edits->edit[s->next_edit];
        if (data + edit->begin >= end)
            break;
        if (data + edit->begin < at || edit->end < edit->begin || data + edit->end > end)
            return io_bytes_fail_changed(&s->model->input, error);
        status = gather(s, at, data + edit->begin - at, output, error);
        if (!status)
            status = gather(s, edit->text, edit->length, output, error);
        at = data + edit->end;
    }
    return status ? status : gather(s, at, end - at, output, error);
}

/** Write the input's bytes with all spans spliced: pieces are made in waves, one for each thread.
 */
static int write_spans(splice *s, pl_output *output, planish_error *error) {
    const io_model *model = s->model;
    const char *at = model->input.data; /* how far the input has been written */
    int status = PLANISH_OK;
    for (int64_t i = 0; i < model->n_spans && !status; i++) {
        s->span = &model->span[i];
        if (io_span_written(model, s->span) == 0)
            continue;
        const int64_t n_pieces = (s->span->n_nodes + CHUNK_NODES - 1) / CHUNK_NODES;
        for (int64_t done = 0; done < n_pieces && !status; done += s->threads) {
            const int64_t wave = n_pieces - done < s->threads ? n_pieces - done : s->threads;
            s->first = s->span->first_node + done * CHUNK_NODES;
            pl_parallel_for(s->threads, wave, 1, make_piece, s);
            for (int64_t k = 0; k < wave; k++) {
                piece *p = &s->pieces[k];
                if (!status && p->state == PIECE_OUT_OF_MEMORY)
                    status = pl_fail_memory(error, "the text of coordinates");
                if (!status && (p->state == PIECE_CHANGED || p->begin < at))
                    status = io_bytes_fail_changed(&model->input, error);
                if (!status)
                    status = copy_input(s, at, p->begin, output, error);
                if (!status)
                    status = gather(s, p->text, p->length, output, error);
                at = p->end;
                pl_free(p->text);
            }
        }
    }
    if (!status)
        status = copy_input(s, at, io_input_end(model), output, error);
    return status ? status : flush(s, output, error);
}

/** Write the bytes of the input with other coordinates to output, and finish it. */
static int write_plain(const planish_file *file, const double *coordinates, int threads,
                       pl_output *output, planish_error *error) {
    const io_format *format = file->format;
    const io_model *model = &file->model;
    io_edits edits = {0};
    splice s = {.format = format,
                .model = model,
                .coordinates = coordinates,
                .threads = threads,
                .pieces = pl_alloc(threads, sizeof *s.pieces),
                .edits = &edits};
    int status = s.pieces ? PLANISH_OK : pl_fail_memory(error, "the text of coordinates");
    if (!status && format->amend && !output->temporary)
        status = format->amend(model, coordinates, output, error);
    if (!status && model->of_format && format->encode)
        status = format->encode(model, coordinates, threads, &edits, error);
    if (!status)
        status = write_spans(&s, output, error);
    io_edits_destroy(&edits);
    pl_free(s.pieces);
    if (!status)
        status = pl_output_finish(output, error);
    if (!status && format->amend && model->of_format && output->temporary) {
        /* The finished copy may have the mode of a file that must not be written, or read. */
        const int former = pl_file_make_accessible(output->temporary);
        status = format->amend(model, coordinates, output, error);
        if (former >= 0)
            pl_file_set_mode(output->temporary, former);
    }
    return status;
}

/* ---- packed files --------------------------------------------------------------------------- */

/** Bytes that are left to be compared with those that are written. */
typedef struct comparison {
    const char *at, *end;
    int differs;
} comparison;

/** pl_output.pack: nothing is written. */
static int compare(pl_output *output, const char *data, int64_t size, planish_error *error) {
    comparison *c = output->packer;
    (void)error;
    c->differs |=
        !data ? c->at < c->end : size > c->end - c->at || memcmp(c->at, data, (size_t)size) != 0;
    c->at = c->differs ? c->end : c->at + size;
    return PLANISH_OK;
}

int io_write_coordinates(const planish_file *file, const double *coordinates, int threads,
                         pl_output *output, planish_error *error) {
    const io_bytes *packed = &file->model.packed;
    comparison c = {file->model.input.data, io_input_end(&file->model), 0};
    pl_output none = {.fd = -1, .pack = compare, .packer = &c};
    if (!packed->data)
        return write_plain(file, coordinates, threads, output, error);
    int status = write_plain(file, coordinates, threads, &none, error);
    if (!status && !c.differs) {
        status = pl_output_write(output, packed->data, packed->size, error);
        return status ? status : pl_output_finish(output, error);
    }
    if (!status)
        status = io_gzip_begin(output, packed, error);
    if (!status)
        status = write_plain(file, coordinates, threads, output, error);
    io_gzip_end(output);
    return status;
}

int io_check_inputs_unchanged(const planish_file *file, planish_error *error) {
    int status = io_bytes_check_unchanged(&file->model.input, error);
    if (!status && file->model.packed.data)
        status = io_bytes_check_unchanged(&file->model.packed, error);
    if (!status && file->model.document.data)
        status = io_bytes_check_unchanged(&file->model.document, error);
    for (int i = 0; i < file->model.n_companions && !status; i++)
        status = io_bytes_check_unchanged(&file->model.companion[i], error);
    return status;
}
