/* records: many records of numbers read by several threads, in text and in binary. */
#include "io/core/records.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "base/memory.h"
#include "base/parallel.h"
#include "base/round.h"
#include "base/status.h"
#include "io/core/bytes.h"

enum {
    PIECE = 1 << 14,     /* bytes: what a thread scans to find a token */
    PIECES_AT_ONCE = 64, /* of the counting loop */
    BLOCK = 64,          /* bytes counted in one vectorised loop */
    RECORDS_AT_ONCE = 1 << 13,
    WORTH_THREADS = 1 << 20 /* bytes; below, starting threads costs more than it brings */
};

void io_text_init(io_text *text, const io_model *model) {
    text->model = model;
    text->begin = model->input.data;
    text->end = io_input_end(model);
    text->threads = pl_thread_count(io_model_threads(model));
    text->comment = '#';
    text->before = NULL;
}

void io_text_release(io_text *text) {
    pl_free(text->before);
    text->before = NULL;
}

/* ---- the index of tokens ------------------------------------------------------------------ */

/** Tokens that start in [at, end); at > begin or at is the beginning. */
static int64_t count_tokens(const char *begin, const char *at, const char *end) {
    int64_t count = 0;
    if (at == begin && at < end)
        count += !io_is_space(*at++);
    for (; end - at >= BLOCK; at += BLOCK) {
        uint8_t starts = 0;
        for (int i = 0; i < BLOCK; i++)
            starts = (uint8_t)(starts + (io_is_space(at[i - 1]) & !io_is_space(at[i])));
        count += starts;
    }
    for (; at < end; at++)
        count += io_is_space(at[-1]) & !io_is_space(*at);
    return count;
}

static int64_t piece_count(const io_text *text) {
    return (text->end - text->begin + PIECE - 1) / PIECE;
}

static const char *piece_begin(const io_text *text, int64_t piece) {
    int64_t size = text->end - text->begin;
    return piece * PIECE < size ? text->begin + piece * PIECE : text->end;
}

static void count_pieces(void *context, int64_t begin, int64_t end, int thread) {
    const io_text *text = context;
    (void)thread;
    for (int64_t piece = begin; piece < end; piece++)
        text->before[piece] =
            count_tokens(text->begin, piece_begin(text, piece), piece_begin(text, piece + 1));
}

/** First byte of token number rank (from 0), or the end if there are not so many. */
static const char *token_begin(const io_text *text, int64_t rank) {
    int64_t low = 0, high = piece_count(text); /* before[low] <= rank < before[high] */
    if (rank >= text->before[high])
        return text->end;
    while (high - low > 1) {
        int64_t middle = low + (high - low) / 2;
        if (text->before[middle] <= rank)
            low = middle;
        else
            high = middle;
    }
    int64_t still = rank - text->before[low];
    const char *at = piece_begin(text, low);
    while (text->end - at > BLOCK) { /* whole blocks first: the last steps are byte by byte */
        int64_t starts = count_tokens(text->begin, at, at + BLOCK);
        if (starts > still)
            break;
        still -= starts;
        at += BLOCK;
    }
    for (; at < text->end; at++) {
        int starts = !io_is_space(*at) && (at == text->begin || io_is_space(at[-1]));
        if (starts && still-- == 0)
            return at;
    }
    return text->end; /* a mapped file changed since its tokens were counted */
}

/* ---- chunks of records -------------------------------------------------------------------- */

typedef struct record_job {
    const io_text *text; /* NULL: binary */
    io_cursor from;
    int64_t size; /* tokens or bytes of a record */
    int64_t rank; /* text: number of the first record's first token */
    io_records_fn *read;
    void *context;
    atomic_int failed;
} record_job;

static void read_text_chunk(void *context, int64_t begin, int64_t end, int thread) {
    record_job *job = context;
    (void)thread;
    if (atomic_load_explicit(&job->failed, memory_order_relaxed))
        return;
    io_cursor cursor = {token_begin(job->text, job->rank + begin * job->size), job->from.end};
    int status = job->read(job->context, &cursor, begin, end, NULL);
    /* Chunk after chunk must join without a gap, or reading in order would find something else. */
    io_skip_space(&cursor);
    if (status || cursor.at != token_begin(job->text, job->rank + end * job->size))
        atomic_store_explicit(&job->failed, 1, memory_order_relaxed);
}

/** Read n records by several threads: 0 if they could not, and nothing has been read for certain.
 */
static int read_text_chunks(io_text *text, io_cursor *cursor, record_job *job, int64_t n) {
    if (cursor->end != text->end)
        return 0;
    if (!text->before) {
        const int64_t pieces = piece_count(text);
        text->before = pl_alloc(pieces + 1, sizeof *text->before);
        if (!text->before)
            return 0;
        pl_parallel_for(text->threads, pieces, PIECES_AT_ONCE, count_pieces, text);
        pl_prefix_sum(text->threads, pieces, text->before);
    }
    const int64_t piece = (cursor->at - text->begin) / PIECE;
    job->rank =
        text->before[piece] + count_tokens(text->begin, piece_begin(text, piece), cursor->at);
    if (cursor->at != token_begin(text, job->rank))
        return 0;
    const char *end = token_begin(text, job->rank + n * job->size);
    if (end < cursor->at || memchr(cursor->at, text->comment, (size_t)(end - cursor->at)))
        return 0;
    pl_parallel_for(text->threads, n, RECORDS_AT_ONCE, read_text_chunk, job);
    if (atomic_load(&job->failed))
        return 0;
    cursor->at = end;
    return 1;
}

int io_text_records(io_text *text, io_cursor *cursor, int64_t n, int64_t tokens,
                    io_records_fn *read, void *context, planish_error *error) {
    record_job job = {text, *cursor, tokens, 0, read, context, 0};
    /* A token is two bytes at least: with this n * tokens cannot overflow. */
    int many = text->threads > 1 && n <= io_left(cursor) / tokens &&
               n * tokens * 2 > WORTH_THREADS && n > RECORDS_AT_ONCE;
    io_skip_space(cursor);
    if (many && read_text_chunks(text, cursor, &job, n))
        return 0;
    int status = read(context, cursor, 0, n, error);
    if (!status)
        io_skip_space(cursor);
    return status;
}

static void read_binary_chunk(void *context, int64_t begin, int64_t end, int thread) {
    record_job *job = context;
    (void)thread;
    io_cursor cursor = {job->from.at + begin * job->size, job->from.end};
    if (job->read(job->context, &cursor, begin, end, NULL) != 0)
        atomic_store_explicit(&job->failed, 1, memory_order_relaxed);
}

int io_binary_records(int threads, io_cursor *cursor, int64_t n, int64_t size, io_records_fn *read,
                      void *context, planish_error *error) {
    if (threads > 1 && n * size > WORTH_THREADS) {
        record_job job = {NULL, *cursor, size, 0, read, context, 0};
        pl_parallel_for(threads, n, RECORDS_AT_ONCE, read_binary_chunk, &job);
        if (!atomic_load(&job.failed)) {
            cursor->at += n * size;
            return 0;
        }
    }
    return read(context, cursor, 0, n, error);
}

int io_records(io_text *text, io_cursor *cursor, int64_t n, int64_t tokens, int64_t size,
               io_records_fn *read, void *context, planish_error *error) {
    return text->model->is_binary
               ? io_binary_records(text->threads, cursor, n, size, read, context, error)
               : io_text_records(text, cursor, n, tokens, read, context, error);
}

/* ---- sections ----------------------------------------------------------------------------- */

int io_sections_add(io_sections *sections, io_section section, planish_error *error) {
    return pl_append(&sections->section, &sections->n, &sections->capacity, &section,
                     sizeof section)
               ? PLANISH_OK
               : pl_fail_memory(error, "the sections of the file");
}

void io_sections_release(io_sections *sections) {
    pl_free(sections->section);
    *sections = (io_sections){.n = 0};
}

int io_section_records(io_text *text, const io_section *section, const char *name, int64_t tokens,
                       int64_t size, io_records_fn *read, void *context, planish_error *error) {
    const io_model *model = text->model;
    io_cursor cursor = {section->data, model->is_binary ? section->end : io_input_end(model)};
    const int status =
        tokens || model->is_binary
            ? io_records(text, &cursor, section->count, tokens, size, read, context, error)
            : read(context, &cursor, 0, section->count, error);
    if (status || model->is_binary)
        return status;
    if (cursor.at > section->end)
        return io_fail_at(model, section->end, error,
                          "the next section begins within the last of %lld %s (the file may be "
                          "damaged)",
                          (long long)section->count, name);
    io_skip_space_comments(&cursor, text->comment);
    if (cursor.at < section->end)
        return io_fail_at(model, cursor.at, error, "more than %lld %s follow",
                          (long long)section->count, name);
    return PLANISH_OK;
}

int io_fail_whole(const io_record_kind *kind, const char *at, const io_cursor *cursor,
                  int64_t record, int64_t first, int64_t last, const int64_t *value,
                  planish_error *error) {
    if (cursor->at == at)
        return io_fail_at(kind->model, at, error,
                          "%s %lld: a whole number expected (the file may be cut short)",
                          kind->what, (long long)record);
    return io_fail_at(kind->model, at, error, "%s %lld: number %lld is not in %lld .. %lld",
                      kind->what, (long long)record, (long long)*value, (long long)first,
                      (long long)last);
}

/* ---- points ------------------------------------------------------------------------------- */

int io_load_node(const io_model *model, const char *at, int size, int swapped, int64_t node,
                 planish_error *error) {
    for (int d = 0; d < 3; d++, at += size) {
        double *x = &model->xyz[3 * node + d];
        *x = size == 4 ? (double)io_load_f32(at, swapped) : io_load_f64(at, swapped);
        const int status = io_check_finite(model, *x, node, at, error);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

int io_read_node(io_model *model, io_cursor *cursor, int64_t node, planish_error *error) {
    double *xyz = model->xyz + 3 * node;
    io_skip_space(cursor);
    model->text_offset[node] = cursor->at - model->input.data;
    xyz[2] = 0;
    for (int d = 0; d < model->columns; d++) {
        double value;
        if (io_real(cursor, &value))
            return io_fail_at(model, cursor->at, error,
                              "node %lld: coordinate expected (the file may be cut short)",
                              (long long)io_node_number(model, node));
        xyz[d] = model->precision == PLANISH_PRECISION_FLOAT ? pl_round_to_float(value) : value;
        const int status = io_check_finite(model, xyz[d], node, cursor->at, error);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

int io_read_nodes(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                  planish_error *error) {
    const io_node_records *points = context;
    io_model *model = points->model;
    for (int64_t node = points->first + begin; node < points->first + end; node++) {
        const int status = model->is_binary ? io_load_node(model, cursor->at, points->size,
                                                           points->swapped, node, error)
                                            : io_read_node(model, cursor, node, error);
        if (status)
            return status;
        if (model->is_binary)
            cursor->at += 3 * points->size;
    }
    return PLANISH_OK;
}

/* ---- nodes with numbers ------------------------------------------------------------------- */

int io_nodes_begin(io_model *model, int64_t n, int field_width, planish_error *error) {
    const int status = io_model_make_nodes(model, n, 8, 0, 0, NULL, error);
    if (status)
        return status;
    model->precision = PLANISH_PRECISION_ROUNDED;
    model->field_width = field_width;
    model->n_nodes = 0; /* so far; the span has all */
    model->node_number = pl_alloc(n, sizeof *model->node_number);
    return model->node_number ? PLANISH_OK : pl_fail_memory(error, "the numbers of nodes");
}

int io_nodes_next(io_model *model, int64_t number, const char *at, planish_error *error) {
    if (model->n_nodes == model->span->n_nodes)
        return io_bytes_fail_changed(&model->input, error);
    model->node_number[model->n_nodes] = number;
    model->text_offset[model->n_nodes] = at - model->input.data;
    memset(model->xyz + 3 * model->n_nodes++, 0, 3 * sizeof *model->xyz);
    return PLANISH_OK;
}

int io_nodes_coordinate(io_model *model, int d, io_slice field, planish_error *error) {
    const int64_t node = model->n_nodes - 1;
    double *value = &model->xyz[3 * node + d];
    if (field.begin == field.end ||
        (!io_slice_real(field, model->exponent == IO_EXPONENT_IMPLIED, value) && isfinite(*value)))
        return PLANISH_OK;
    return io_fail_at(model, field.begin, error,
                      "node %lld: '%.*s' is not a coordinate (a finite real number)",
                      (long long)model->node_number[node], IO_QUOTED(field));
}

int io_nodes_end(io_model *model, planish_error *error) {
    return model->n_nodes == model->span->n_nodes ? io_reduce_node_numbers(model, error)
                                                  : io_bytes_fail_changed(&model->input, error);
}
