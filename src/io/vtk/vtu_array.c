/* vtu_array: the numbers of the data arrays of VTK's XML files.
 *
 * Binary arrays begin with a header of whole numbers: their size in bytes, or for packed ones the
 * number of blocks, the bytes of a block, those of the last (0: it is whole), and how many bytes
 * each became. What an array must have at least is known from the numbers of points and cells, so
 * that headers are compared with that before anything is allocated; what it has beyond that VTK
 * does not read, and it stays as it is. All that is unpacked is bounded by the file's size.
 */
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "io/core/binary.h"
#include "io/core/bytes.h"
#include "io/vtk/vtk_base64.h"
#include "io/vtk/vtu_parts.h"

#include <stdatomic.h>
#include <string.h>

enum {
    MOST_EXPANSION = 256, /* of a file's bytes by unpacking: of meshes 4 to 20 */
    SLACK_BYTES = 1 << 20
};

const char *const vtu_role_names[] = {"a data array",
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
                                      "point data",
                                      "cell data"};

/** Return how messages call an array. */
static const char *name_of(const vtu_array *array) {
    return array->name ? array->name : vtu_role_names[array->role];
}

int vtu_fail(const vtu_document *document, const vtu_array *array, const char *text) {
    return io_fail_at(document->model, document->model->input.data + array->tag, document->error,
                      "%s: %s", name_of(array), text);
}

static int fail_cut(const vtu_document *document, const vtu_array *array) {
    return vtu_fail(
        document, array,
        "the data end before the array does (the file may be cut short), or are not base64");
}

static int fail_size(const vtu_document *document, const vtu_array *array) {
    return vtu_fail(document, array,
                    "the number of values in the array differs from NumberOfPoints, NumberOfCells "
                    "or the offsets");
}

/* ---- bytes --------------------------------------------------------------------------------- */

/** A stream of an array's bytes, in either form. */
typedef struct byte_stream {
    const vtu_document *document;
    vtu_form form;
    io_base64 text; /* raw: its cursor alone */
} byte_stream;

static byte_stream open_array(const vtu_document *document, const vtu_array *array) {
    const char *data = document->model->input.data;
    return (byte_stream){
        document, array->form, {.cursor = {data + array->begin, data + array->end}}};
}

static int take_bytes(byte_stream *s, int64_t n, char *out) {
    io_cursor *cursor = &s->text.cursor;
    if (s->form == VTU_BASE64)
        return io_base64_read(&s->text, n, out);
    if (n > io_left(cursor))
        return -1;
    memcpy(out, cursor->at, (size_t)n);
    cursor->at += n;
    return 0;
}

/** Take a number of a header. */
static int take_header(byte_stream *s, uint64_t *value) {
    char bytes[8];
    if (take_bytes(s, s->document->header_size, bytes))
        return -1;
    *value = s->document->header_size == 8 ? io_load_u64(bytes, s->document->swapped)
                                           : io_load_u32(bytes, s->document->swapped);
    return 0;
}

/** Return the bytes that the rest of a stream may be at most. */
static int64_t most_bytes(const byte_stream *s) {
    const int64_t left = io_left(&s->text.cursor);
    return s->form == VTU_BASE64 ? left / 4 * 3 : left;
}

/* ---- bounds --------------------------------------------------------------------------------- */

int64_t vtu_most_unpacked(const vtu_document *document) {
    const int64_t size = document->model->input.size;
    if (document->compression == IO_PLAIN)
        return size;
    return size < (INT64_MAX - SLACK_BYTES) / MOST_EXPANSION ? size * MOST_EXPANSION + SLACK_BYTES
                                                             : INT64_MAX;
}

/** Arrays are not the same bytes, so that all that are not packed are no more than the file is. */
static int check_expansion(const vtu_document *document, const vtu_array *array, int64_t bytes) {
    if (bytes <= vtu_most_unpacked(document) - document->unpacked)
        return PLANISH_OK;
    return vtu_fail(document, array,
                    document->compression == IO_PLAIN
                        ? "the arrays would be larger than the file is (cut short, wrong counts, "
                          "or several arrays in the same bytes)"
                        : "the unpacked arrays would be more than 256 times as large as the file: "
                          "planish refuses it as damaged");
}

/** Refuse n numbers that the file cannot hold before room for them is made. */
static int check_count(const vtu_document *document, const vtu_array *array, int64_t n) {
    const int64_t left = array->end - array->begin;
    if (array->form == VTU_ASCII)
        return n <= (left + 1) / 2 ? PLANISH_OK : fail_size(document, array);
    if (!array->type)
        return vtu_fail(document, array, "numbers of this type are not read");
    if (document->compression == IO_PLAIN && n > left / array->type->size)
        return fail_cut(document, array);
    /* So many that their bytes could not be counted are as many too many. */
    return check_expansion(document, array, n < INT64_MAX / 8 ? n * array->type->size : INT64_MAX);
}

/* ---- packed arrays ------------------------------------------------------------------------- */

void vtu_blocks_release(vtu_blocks *blocks) {
    pl_free(blocks->packed);
    pl_free(blocks->owned);
    *blocks = (vtu_blocks){0};
}

/** Take the header of a packed array of at least bytes bytes: all of blocks but the data. */
static int take_block_sizes(byte_stream *s, const vtu_array *array, int64_t bytes,
                            vtu_blocks *blocks) {
    const vtu_document *document = s->document;
    uint64_t n, size, last;
    if (take_header(s, &n) || take_header(s, &size) || take_header(s, &last) ||
        n > (uint64_t)most_bytes(s) / (uint64_t)document->header_size)
        return fail_cut(document, array);
    if (size > INT64_MAX || last > size)
        return fail_size(document, array);
    blocks->n = (int64_t)n;
    blocks->size = (int64_t)size;
    blocks->last_size = (int64_t)(last > 0 ? last : size);
    blocks->last_told = (int64_t)last;
    /* So many that their bytes could not be counted are more than any file unpacks to. */
    blocks->bytes = n == 0 ? 0
                    : size == 0 || blocks->n - 1 > (INT64_MAX - blocks->last_size) / blocks->size
                        ? -1
                        : (blocks->n - 1) * blocks->size + blocks->last_size;
    if (blocks->bytes < bytes)
        return fail_size(document, array);
    const int64_t most = most_bytes(s);
    blocks->packed = pl_alloc(blocks->n + 1, sizeof *blocks->packed);
    if (!blocks->packed)
        return pl_fail_memory(document->error, "the blocks of an array");
    blocks->packed[0] = 0;
    for (int64_t i = 0; i < blocks->n; i++) {
        if (take_header(s, &size) || size > (uint64_t)(most - blocks->packed[i]))
            return fail_cut(document, array);
        blocks->packed[i + 1] = blocks->packed[i] + (int64_t)size;
    }
    return PLANISH_OK;
}

int vtu_find_blocks(const vtu_document *document, const vtu_array *array, int64_t bytes,
                    vtu_blocks *blocks) {
    byte_stream s = open_array(document, array);
    *blocks = (vtu_blocks){0};
    const int status = take_block_sizes(&s, array, bytes, blocks);
    if (status)
        return status;
    const int64_t packed = blocks->packed[blocks->n];
    if (packed > io_left(&s.text.cursor) && s.form == VTU_RAW)
        return fail_cut(document, array);
    if (s.form == VTU_RAW && !io_bytes_can_change(&document->model->input)) {
        blocks->data = s.text.cursor.at;
        s.text.cursor.at += packed;
    } else {
        /* Of bytes that can change the libraries get a copy: they look at some twice. */
        /* Header and blocks are segments of their own: nothing of them is in one group. */
        blocks->data = blocks->owned = pl_alloc(packed, 1);
        if (!blocks->owned)
            return pl_fail_memory(document->error, "the blocks of an array");
        if (take_bytes(&s, packed, blocks->owned))
            return fail_cut(document, array);
    }
    blocks->text_end = s.text.cursor.at - document->model->input.data;
    return PLANISH_OK;
}

/** Unpacking blocks on several threads. */
typedef struct unpacking {
    io_compression compression;
    const vtu_blocks *blocks;
    char *out;
    atomic_int failed;
} unpacking;

static void unpack_chunk(void *context, int64_t begin, int64_t end, int thread) {
    unpacking *u = context;
    const vtu_blocks *b = u->blocks;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        if (io_unpack(u->compression, b->data + b->packed[i], b->packed[i + 1] - b->packed[i],
                      u->out + i * b->size, i + 1 < b->n ? b->size : b->last_size))
            atomic_store_explicit(&u->failed, 1, memory_order_relaxed);
}

/** bytes: at least; values->n_bytes: all of them. */
static int decode_packed(const vtu_document *document, vtu_array *array, int64_t bytes,
                         vtu_values *values) {
    vtu_blocks blocks = {0};
    int status = check_expansion(document, array, bytes);
    if (!status)
        status = vtu_find_blocks(document, array, bytes, &blocks);
    if (!status)
        status = check_expansion(document, array, blocks.bytes);
    if (!status && !(values->owned = pl_alloc(blocks.bytes, 1)))
        status = pl_fail_memory(document->error, "an array of the file");
    if (!status) {
        unpacking u = {document->compression, &blocks, values->owned, 0};
        pl_parallel_for(io_model_threads(document->model), blocks.n, 1, unpack_chunk, &u);
        if (atomic_load(&u.failed))
            status = vtu_fail(document, array,
                              "a packed block cannot be unpacked to what its header says");
    }
    values->n_bytes = blocks.bytes;
    array->data_end = blocks.text_end;
    vtu_blocks_release(&blocks);
    return status;
}

/* ---- arrays -------------------------------------------------------------------------------- */

static int decode_plain(const vtu_document *document, vtu_array *array, int64_t bytes,
                        vtu_values *values) {
    byte_stream s = open_array(document, array);
    uint64_t size;
    if (take_header(&s, &size))
        return fail_cut(document, array);
    if (size < (uint64_t)bytes)
        return fail_size(document, array);
    /* Pending bytes of the group in which the header ends are in the text already. */
    if (size > (uint64_t)most_bytes(&s) + 3)
        return fail_cut(document, array);
    values->n_bytes = (int64_t)size;
    if (s.form == VTU_RAW) {
        if (values->n_bytes > io_left(&s.text.cursor))
            return fail_cut(document, array);
        values->data = s.text.cursor.at;
        s.text.cursor.at += values->n_bytes;
    } else {
        values->owned = pl_alloc(values->n_bytes, 1);
        if (!values->owned)
            return pl_fail_memory(document->error, "an array of the file");
        if (take_bytes(&s, values->n_bytes, values->owned))
            return fail_cut(document, array);
    }
    array->data_end = s.text.cursor.at - document->model->input.data;
    return PLANISH_OK;
}

int vtu_decode(vtu_document *document, vtu_array *array, int64_t n, vtu_values *values) {
    *values = (vtu_values){.data = NULL};
    if (!array->type)
        return vtu_fail(document, array, "numbers of this type are not read");
    const int64_t bytes = n * array->type->size;
    const int status = document->compression == IO_PLAIN
                           ? decode_plain(document, array, bytes, values)
                           : decode_packed(document, array, bytes, values);
    if (!status)
        document->unpacked += values->n_bytes;
    if (values->owned)
        values->data = values->owned;
    return status;
}

void vtu_values_release(vtu_values *values) {
    pl_free(values->owned);
    values->owned = NULL;
}

int vtu_read_text(const vtu_document *document, const vtu_array *array, int64_t n, int64_t tokens,
                  io_records_fn *read, void *context) {
    const char *data = document->model->input.data;
    io_cursor cursor = {data + array->begin, data + array->end};
    io_text text;
    io_text_init(&text, document->model);
    text.begin = cursor.at;
    text.end = cursor.end;
    const int status = io_text_records(&text, &cursor, n, tokens, read, context, document->error);
    io_text_release(&text);
    return status;
}

int vtu_read_numbers(vtu_document *document, vtu_array *array, int64_t n, int64_t **wide,
                     int32_t **narrow, double **real) {
    vtk_list list = {.model = document->model,
                     .name = name_of(array),
                     .type = array->form == VTU_ASCII ? NULL : array->type,
                     .swapped = document->swapped};
    if (!real && array->type && array->type->kind == VTK_REAL)
        return vtu_fail(document, array, "whole numbers expected, and it is of reals");
    int status = check_count(document, array, n);
    if (status)
        return status;
    if (wide)
        *wide = list.wide = pl_alloc(n, sizeof **wide);
    else if (narrow)
        *narrow = list.narrow = pl_alloc(n, sizeof **narrow);
    else
        *real = list.real = pl_alloc(n, sizeof **real);
    if (!list.wide && !list.narrow && !list.real)
        return pl_fail_memory(document->error, "an array of the file");
    if (array->form == VTU_ASCII)
        return vtu_read_text(document, array, n, 1, vtk_read_list, &list);
    vtu_values values;
    status = vtu_decode(document, array, n, &values);
    if (!status) {
        io_cursor cursor = {values.data, values.data + values.n_bytes};
        if (io_binary_records(io_model_threads(document->model), &cursor, n, array->type->size,
                              vtk_read_list, &list, NULL))
            status = vtu_fail(document, array, "a number is out of range");
    }
    vtu_values_release(&values);
    return status;
}
