/* vtu_array: the numbers of the data arrays of VTK's XML files.
 *
 * Binary arrays begin with a header of whole numbers: their size in bytes, or for packed ones the
 * number of blocks, the bytes of a block, those of the last (0: it is whole), and how many bytes
 * each became. What an array must have at least is known from the numbers of points and cells, so
 * that headers are compared with that before anything is allocated; what it has beyond that VTK
 * does not read, and it stays as it is. All that is unpacked is bounded by the file's size.
 */
#include "io/vtk/vtu_parts.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "io/vtk/base64.h"
#include "io/core/binary.h"
#include "io/core/bytes.h"

#include <stdatomic.h>
#include <string.h>

enum {
    MOST_EXPANSION = 256, /* of a file's bytes by unpacking: of meshes 4 to 20 */
    SLACK_BYTES = 1 << 20,
    CHUNK_VALUES = 1 << 16
};

int vtu_fail(const io_model *model, const vtu_array *array, planish_error *error,
             const char *text) {
    static const char *const names[] = {"a data array",
                                        "Points",
                                        "connectivity",
                                        "offsets",
                                        "types",
                                        "faces",
                                        "faceoffsets",
                                        "polyhedron_offsets",
                                        "polyhedron_to_faces",
                                        "face_offsets",
                                        "face_connectivity",
                                        "fixed",
                                        "cell data"};
    return io_fail_at(model, model->input.data + array->tag, error, "%s: %s", names[array->role],
                      text);
}

static int fail_cut(const io_model *model, const vtu_array *array, planish_error *error) {
    return vtu_fail(model, array, error,
                    "the data end before the array does (the file may be cut short), or are no "
                    "base64");
}

static int fail_size(const io_model *model, const vtu_array *array, planish_error *error) {
    return vtu_fail(model, array, error,
                    "the array has not as many values as NumberOfPoints, NumberOfCells and offsets "
                    "promise");
}

/* ---- bytes --------------------------------------------------------------------------------- */

/** A stream of an array's bytes, in either form. */
typedef struct source {
    vtu_form form;
    io_base64 text; /* raw: its cursor alone */
} source;

static source open_source(const io_model *model, const vtu_array *array) {
    const char *data = model->input.data;
    return (source){array->form, {.cursor = {data + array->begin, data + array->end}}};
}

static int take_bytes(source *s, int64_t n, char *out) {
    io_cursor *cursor = &s->text.cursor;
    if (s->form == VTU_BASE64)
        return io_base64_read(&s->text, n, out);
    if (n > io_left(cursor))
        return -1;
    memcpy(out, cursor->at, (size_t)n);
    cursor->at += n;
    return 0;
}

/** A number of a header. */
static int take_header(const vtu_document *document, source *s, uint64_t *value) {
    char bytes[8];
    if (take_bytes(s, document->header_size, bytes))
        return -1;
    *value = document->header_size == 8 ? io_load_u64(bytes, document->swapped)
                                        : io_load_u32(bytes, document->swapped);
    return 0;
}

/** Bytes that a cursor's text may be at most. */
static int64_t most_bytes(const source *s) {
    const int64_t left = io_left(&s->text.cursor);
    return s->form == VTU_BASE64 ? left / 4 * 3 : left;
}

/* ---- bounds --------------------------------------------------------------------------------- */

int64_t vtu_most_unpacked(const io_model *model, const vtu_document *document) {
    const int64_t size = model->input.size;
    if (document->compression == IO_PLAIN)
        return size;
    return size < (INT64_MAX - SLACK_BYTES) / MOST_EXPANSION ? size * MOST_EXPANSION + SLACK_BYTES
                                                             : INT64_MAX;
}

/** Arrays are not the same bytes, so that all that are not packed are no more than the file is. */
static int check_expansion(const io_model *model, const vtu_document *document,
                           const vtu_array *array, int64_t bytes, planish_error *error) {
    if (bytes <= vtu_most_unpacked(model, document) - document->unpacked)
        return PLANISH_OK;
    if (document->compression == IO_PLAIN)
        return vtu_fail(model, array, error,
                        "the arrays would be larger than the file is (cut short, wrong counts, or "
                        "several arrays in the same bytes)");
    return vtu_fail(model, array, error,
                    "unpacked the arrays would be more than 256 times as large as the file, which "
                    "no mesh is: refused");
}

/* ---- packed arrays ------------------------------------------------------------------------- */

void vtu_blocks_release(vtu_blocks *blocks) {
    pl_free(blocks->packed);
    pl_free(blocks->owned);
    *blocks = (vtu_blocks){0};
}

/** The first three numbers of the header: blocks->n, size, last_size; bytes at least in all. */
static int take_shape(const io_model *model, vtu_document *document, const vtu_array *array,
                      source *s, int64_t bytes, vtu_blocks *blocks, planish_error *error) {
    uint64_t n, size, last;
    if (take_header(document, s, &n) || take_header(document, s, &size) ||
        take_header(document, s, &last))
        return fail_cut(model, array, error);
    if (n > (uint64_t)most_bytes(s) / (uint64_t)document->header_size)
        return fail_cut(model, array, error);
    if (size > INT64_MAX || last > size)
        return fail_size(model, array, error);
    blocks->n = (int64_t)n;
    blocks->size = (int64_t)size;
    blocks->last_size = (int64_t)(last > 0 ? last : size);
    blocks->last_told = (int64_t)last;
    /* So many that their bytes could not be counted are more than any file unpacks to. */
    blocks->bytes = n == 0 ? 0
                    : size == 0 || blocks->n - 1 > (INT64_MAX - blocks->last_size) / blocks->size
                        ? -1
                        : (blocks->n - 1) * blocks->size + blocks->last_size;
    return blocks->bytes < bytes ? fail_size(model, array, error) : PLANISH_OK;
}

static int take_block_sizes(const io_model *model, vtu_document *document, const vtu_array *array,
                            source *s, vtu_blocks *blocks, planish_error *error) {
    const int64_t most = most_bytes(s);
    blocks->packed = pl_alloc(blocks->n + 1, sizeof *blocks->packed);
    if (!blocks->packed)
        return pl_fail_memory(error, "the blocks of an array");
    blocks->packed[0] = 0;
    for (int64_t i = 0; i < blocks->n; i++) {
        uint64_t size;
        if (take_header(document, s, &size) || size > (uint64_t)(most - blocks->packed[i]))
            return fail_cut(model, array, error);
        blocks->packed[i + 1] = blocks->packed[i] + (int64_t)size;
    }
    return PLANISH_OK;
}

int vtu_find_blocks(const io_model *model, vtu_document *document, const vtu_array *array,
                    int64_t bytes, vtu_blocks *blocks, planish_error *error) {
    source s = open_source(model, array);
    *blocks = (vtu_blocks){0};
    int status = take_shape(model, document, array, &s, bytes, blocks, error);
    if (!status)
        status = take_block_sizes(model, document, array, &s, blocks, error);
    if (status)
        return status;
    const int64_t packed = blocks->packed[blocks->n];
    if (packed > io_left(&s.text.cursor) && s.form == VTU_RAW)
        return fail_cut(model, array, error);
    if (s.form == VTU_RAW && !io_bytes_can_change(&model->input)) {
        blocks->data = s.text.cursor.at;
        s.text.cursor.at += packed;
    } else {
        /* Of bytes that can change the libraries get a copy: they look at some twice. */
        /* Header and blocks are segments of their own: nothing of them is in one group. */
        blocks->data = blocks->owned = pl_alloc(packed, 1);
        if (!blocks->owned)
            return pl_fail_memory(error, "the blocks of an array");
        if (take_bytes(&s, packed, blocks->owned))
            return fail_cut(model, array, error);
    }
    blocks->text_end = s.text.cursor.at - model->input.data;
    return PLANISH_OK;
}

/** Unpacking blocks on several threads. */
typedef struct unpacking {
    const vtu_document *document;
    const vtu_blocks *blocks;
    char *out;
    atomic_int failed;
} unpacking;

static void unpack_chunk(void *context, int64_t begin, int64_t end, int thread) {
    unpacking *u = context;
    const vtu_blocks *b = u->blocks;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        if (io_unpack(u->document->compression, b->data + b->packed[i],
                      b->packed[i + 1] - b->packed[i], u->out + i * b->size,
                      i + 1 < b->n ? b->size : b->last_size))
            atomic_store_explicit(&u->failed, 1, memory_order_relaxed);
}

/** bytes: at least; values->n_bytes: all of them. */
static int decode_packed(const io_model *model, vtu_document *document, vtu_array *array,
                         int64_t bytes, vtu_values *values, planish_error *error) {
    vtu_blocks blocks;
    int status = check_expansion(model, document, array, bytes, error);
    if (status)
        return status;
    status = vtu_find_blocks(model, document, array, bytes, &blocks, error);
    values->n_bytes = blocks.bytes;
    if (!status)
        status = check_expansion(model, document, array, blocks.bytes, error);
    if (!status && !(values->owned = pl_alloc(blocks.bytes, 1)))
        status = pl_fail_memory(error, "an array of the file");
    if (!status) {
        unpacking u = {document, &blocks, values->owned, 0};
        pl_parallel_for(model->threads, blocks.n, 1, unpack_chunk, &u);
        if (atomic_load(&u.failed))
            status = vtu_fail(model, array, error,
                              "a packed block cannot be unpacked to what its header says");
    }
    array->data_end = blocks.text_end;
    vtu_blocks_release(&blocks);
    return status;
}

/* ---- arrays -------------------------------------------------------------------------------- */

static int decode_plain(const io_model *model, const vtu_document *document, vtu_array *array,
                        int64_t bytes, vtu_values *values, planish_error *error) {
    source s = open_source(model, array);
    uint64_t size;
    if (take_header(document, &s, &size))
        return fail_cut(model, array, error);
    if (size < (uint64_t)bytes)
        return fail_size(model, array, error);
    /* Pending bytes of the group in which the header ends are in the text already. */
    if (size > (uint64_t)most_bytes(&s) + 3)
        return fail_cut(model, array, error);
    values->n_bytes = bytes = (int64_t)size;
    const char *data = model->input.data;
    if (s.form == VTU_RAW) {
        values->data = s.text.cursor.at;
        array->data_end = values->data + bytes - data;
        return bytes > io_left(&s.text.cursor) ? fail_cut(model, array, error) : PLANISH_OK;
    }
    values->owned = pl_alloc(bytes, 1);
    if (!values->owned)
        return pl_fail_memory(error, "an array of the file");
    if (take_bytes(&s, bytes, values->owned))
        return fail_cut(model, array, error);
    array->data_end = s.text.cursor.at - data;
    return PLANISH_OK;
}

int vtu_decode(const io_model *model, vtu_document *document, vtu_array *array, int64_t n,
               vtu_values *values, planish_error *error) {
    *values = (vtu_values){.n = n, .type = array->type, .swapped = document->swapped};
    if (!array->type)
        return vtu_fail(model, array, error, "numbers of this type are not read");
    const int64_t bytes = n * array->type->size;
    int status = document->compression == IO_PLAIN
                     ? decode_plain(model, document, array, bytes, values, error)
                     : decode_packed(model, document, array, bytes, values, error);
    if (!status)
        document->unpacked += values->n_bytes;
    if (values->owned)
        values->data = values->owned;
    if (status)
        vtu_values_release(values);
    return status;
}

void vtu_values_release(vtu_values *values) {
    pl_free(values->owned);
    values->owned = NULL;
}

int64_t vtu_integer(const vtu_values *values, int64_t i) {
    const char *at = values->data + i * values->type->size;
    const int is_signed = values->type->kind == VTK_SIGNED;
    switch (values->type->size) {
    case 1:
        return is_signed ? (int64_t)(signed char)*at : (int64_t)(unsigned char)*at;
    case 2:
        return is_signed ? (int64_t)(int16_t)io_load_u16(at, values->swapped)
                         : (int64_t)io_load_u16(at, values->swapped);
    case 4:
        return is_signed ? (int64_t)io_load_i32(at, values->swapped)
                         : (int64_t)io_load_u32(at, values->swapped);
    default: /* unsigned ones beyond 2^63 become negative: out of range as well */
        return io_load_i64(at, values->swapped);
    }
}

double vtu_real(const vtu_values *values, int64_t i) {
    const char *at = values->data + i * values->type->size;
    if (values->type->kind != VTK_REAL)
        return (double)vtu_integer(values, i);
    return values->type->size == 4 ? (double)io_load_f32(at, values->swapped)
                                   : io_load_f64(at, values->swapped);
}

/* ---- reading to arrays of ours ------------------------------------------------------------- */

/** Where numbers of text and binary go. */
typedef struct target {
    io_model *model;
    vtu_array *array;
    const vtu_values *values; /* binary */
    int64_t *wide;            /* [n] one of these three is not NULL */
    int32_t *narrow;
    double *real;
    atomic_int failed;
} target;

static int put_integer(const target *t, int64_t i, int64_t value) {
    if (t->wide) {
        t->wide[i] = value;
        return 0;
    }
    t->narrow[i] = (int32_t)value;
    return value >= INT32_MIN && value <= INT32_MAX ? 0 : -1;
}

static int read_text(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                     planish_error *error) {
    const target *t = context;
    for (int64_t i = begin; i < end; i++) {
        int64_t value;
        if (t->real ? io_real(cursor, &t->real[i])
                    : io_integer(cursor, &value) || put_integer(t, i, value))
            return io_fail_at(t->model, cursor->at, error,
                              t->real ? "a number expected (the file may be cut short)"
                                      : "a whole number in range expected (the file may be cut "
                                        "short)");
    }
    return PLANISH_OK;
}

static void copy_chunk(void *context, int64_t begin, int64_t end, int thread) {
    target *t = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        if (t->real)
            t->real[i] = vtu_real(t->values, i);
        else if (put_integer(t, i, vtu_integer(t->values, i)))
            atomic_store_explicit(&t->failed, 1, memory_order_relaxed);
}

static int read_ascii(target *t, int64_t n, planish_error *error) {
    const char *data = t->model->input.data;
    io_cursor cursor = {data + t->array->begin, data + t->array->end};
    io_text text;
    io_text_init(&text, t->model);
    text.begin = cursor.at;
    text.end = cursor.end;
    int status = io_text_records(&text, &cursor, n, 1, read_text, t, error);
    io_text_release(&text);
    return status;
}

static int read_binary(target *t, vtu_document *document, int64_t n, planish_error *error) {
    vtu_values values;
    int status = vtu_decode(t->model, document, t->array, n, &values, error);
    if (status)
        return status;
    t->values = &values;
    pl_parallel_for(t->model->threads, n, CHUNK_VALUES, copy_chunk, t);
    t->values = NULL;
    if (atomic_load(&t->failed))
        status = vtu_fail(t->model, t->array, error, "a number of it is out of range");
    vtu_values_release(&values);
    return status;
}

static int read_target(target *t, vtu_document *document, int64_t n, planish_error *error) {
    if (!t->wide && !t->narrow && !t->real)
        return pl_fail_memory(error, "an array of the file");
    return t->array->form == VTU_ASCII ? read_ascii(t, n, error)
                                       : read_binary(t, document, n, error);
}

/** Refuse what the file cannot hold before room for it is made. */
static int check_count(const io_model *model, const vtu_document *document, const vtu_array *array,
                       int64_t n, planish_error *error) {
    const int64_t left = array->end - array->begin;
    if (array->form == VTU_ASCII)
        return n <= (left + 1) / 2 ? PLANISH_OK : fail_size(model, array, error);
    if (!array->type)
        return vtu_fail(model, array, error, "numbers of this type are not read");
    if (document->compression == IO_PLAIN && n > left / array->type->size)
        return fail_cut(model, array, error);
    /* So many that their bytes could not be counted are as many too many. */
    const int64_t bytes = n < INT64_MAX / 8 ? n * array->type->size : INT64_MAX;
    return check_expansion(model, document, array, bytes, error);
}

int vtu_read_integers(io_model *model, vtu_document *document, vtu_array *array, int64_t n,
                      int64_t **wide, int32_t **narrow, planish_error *error) {
    target t = {.model = model, .array = array};
    if (array->type && array->type->kind == VTK_REAL)
        return vtu_fail(model, array, error, "whole numbers expected, and it is of reals");
    int status = check_count(model, document, array, n, error);
    if (status)
        return status;
    if (wide)
        *wide = t.wide = pl_alloc(n, sizeof **wide);
    else
        *narrow = t.narrow = pl_alloc(n, sizeof **narrow);
    return read_target(&t, document, n, error);
}

int vtu_read_reals(io_model *model, vtu_document *document, vtu_array *array, int64_t n,
                   double **values, planish_error *error) {
    int status = check_count(model, document, array, n, error);
    if (status)
        return status;
    target t = {.model = model, .array = array};
    *values = t.real = pl_alloc(n, sizeof **values);
    return read_target(&t, document, n, error);
}
