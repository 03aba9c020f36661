/* vtu_encode: the points of VTK's XML files, written where they stand.
 *
 * Text and raw bytes are replaced in place by the splice that all formats share. What is base64
 * keeps its characters but for those of bytes that change. Of packed points those blocks are packed
 * again in which something changed, and what follows them in appended data moves: the offsets in
 * the markup say where to.
 */
#include "io/vtk/vtu_parts.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/round.h"
#include "base/status.h"
#include "io/vtk/base64.h"
#include "io/core/binary.h"
#include "io/core/bytes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CHUNK_POINTS = 1 << 14, CHUNK_BLOCKS = 1 };

static int is_encoded(const vtu_document *document, const vtu_array *array) {
    return array->form == VTU_BASE64 ||
           (array->form == VTU_RAW && document->compression != IO_PLAIN);
}

/* ---- writing: bytes ------------------------------------------------------------------------ */

/** The new bytes of one array of points. */
typedef struct rewrite {
    const io_model *model;
    const vtu_document *document;
    vtu_array *array;
    const vtu_piece *piece;
    const double *coordinates; /* [n_nodes][written] of the model */
    char *bytes;               /* those of the file, decoded, then the new ones */
    int64_t size;
    int changed;
    /* Packed: */
    vtu_blocks blocks;
    uint8_t *dirty;             /* [blocks.n] something changed in it */
    char **packed;              /* [blocks.n] owned; NULL: as it was */
    int64_t *packed_size;       /* [blocks.n] */
    int out_of_memory, refused; /* in a block, */
} rewrite;

static void store_real(char *at, double value, int size, int swapped) {
    char bytes[8];
    const float single = (float)value;
    if (size == 4)
        memcpy(bytes, &single, sizeof single);
    else
        memcpy(bytes, &value, sizeof value);
    for (int k = 0; k < size; k++)
        at[k] = bytes[swapped ? size - 1 - k : k];
}

/** Something changed in size bytes at at: in all blocks that they are in. */
static void mark(rewrite *r, int64_t at, int size) {
    const int64_t of_block = r->blocks.size;
    __atomic_store_n(&r->changed, 1, __ATOMIC_RELAXED);
    for (int64_t k = of_block > 0 ? at / of_block : 0;
         r->dirty && of_block > 0 && k <= (at + size - 1) / of_block; k++)
        __atomic_store_n(&r->dirty[k], 1, __ATOMIC_RELAXED);
}

static void replace_chunk(void *context, int64_t begin, int64_t end, int thread) {
    rewrite *r = context;
    const int written = r->model->written, size = r->array->type->size,
              swapped = r->document->swapped;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int d = 0; d < written; d++) {
            const int64_t at = (3 * i + d) * size;
            const double now = size == 4 ? (double)io_load_f32(r->bytes + at, swapped)
                                         : io_load_f64(r->bytes + at, swapped);
            double wanted = r->coordinates[(r->piece->first_point + i) * written + d];
            wanted = size == 4 ? pl_round_to_float(wanted) : wanted;
            if (pl_is_same(now, wanted))
                continue;
            store_real(r->bytes + at, wanted, size, swapped);
            mark(r, at, size);
        }
}

/* ---- writing: base64 ----------------------------------------------------------------------- */

/** The array's text with other characters where bytes changed. */
static int rewrite_base64(rewrite *r, io_edits *edits, planish_error *error) {
    const vtu_array *array = r->array;
    const int64_t length = array->data_end - array->begin;
    char *text = pl_alloc(length, 1);
    if (!text)
        return pl_fail_memory(error, "the points to be written");
    memcpy(text, r->model->input.data + array->begin, (size_t)length);
    io_base64_replace(text, length, r->document->header_size, r->size, r->bytes);
    return io_edits_add(edits, (io_edit){array->begin, array->data_end, text, length}, error);
}

/* ---- writing: packed blocks ---------------------------------------------------------------- */

static void pack_chunk(void *context, int64_t begin, int64_t end, int thread) {
    rewrite *r = context;
    const vtu_blocks *b = &r->blocks;
    const io_compression compression = r->document->compression;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int64_t size = i + 1 < b->n ? b->size : b->last_size;
        r->packed[i] = NULL;
        r->packed_size[i] = b->packed[i + 1] - b->packed[i];
        if (!r->dirty[i])
            continue;
        r->packed[i] = pl_alloc(io_pack_bound(compression, size), 1);
        if (r->packed[i])
            r->packed_size[i] = io_pack(compression, r->bytes + i * b->size, size,
                                        b->data + b->packed[i], r->packed[i]);
        if (!r->packed[i])
            __atomic_store_n(&r->out_of_memory, 1, __ATOMIC_RELAXED);
        else if (r->packed_size[i] < 0)
            __atomic_store_n(&r->refused, 1, __ATOMIC_RELAXED);
    }
}

static void store_header(const vtu_document *document, char *at, int64_t value) {
    for (int k = 0; k < document->header_size; k++) {
        const int place =
            io_machine_is_little() == !document->swapped ? k : document->header_size - 1 - k;
        at[place] = (char)(unsigned char)((uint64_t)value >> 8 * k);
    }
}

/** Header and blocks, one after the other: text [*length]; NULL without memory. */
static char *join_blocks(const rewrite *r, int64_t *header, int64_t *length) {
    const vtu_blocks *b = &r->blocks;
    const int word = r->document->header_size;
    *header = (VTU_HEADER_NUMBERS + b->n) * word;
    *length = *header;
    for (int64_t i = 0; i < b->n; i++)
        *length += r->packed_size[i];
    char *joined = pl_alloc(*length, 1);
    if (!joined)
        return NULL;
    store_header(r->document, joined, b->n);
    store_header(r->document, joined + word, b->size);
    store_header(r->document, joined + 2 * word, b->last_told);
    char *to = joined + *header;
    for (int64_t i = 0; i < b->n; i++) {
        store_header(r->document, joined + (VTU_HEADER_NUMBERS + i) * word, r->packed_size[i]);
        memcpy(to, r->packed[i] ? r->packed[i] : b->data + b->packed[i], (size_t)r->packed_size[i]);
        to += r->packed_size[i];
    }
    return joined;
}

/** As text of two segments. */
static char *blocks_to_base64(char *joined, int64_t header, int64_t *length) {
    const int64_t room = io_base64_length(header) + io_base64_length(*length - header);
    char *text = joined ? pl_alloc(room, 1) : NULL;
    if (text) {
        const int64_t first = io_base64_write(joined, header, text);
        *length = first + io_base64_write(joined + header, *length - header, text + first);
    }
    pl_free(joined);
    return text;
}

static int pack_blocks(rewrite *r, io_edits *edits, int threads, planish_error *error) {
    const vtu_array *array = r->array;
    const char *data = r->model->input.data;
    int64_t header, length, begin = array->begin;
    pl_parallel_for(threads, r->blocks.n, CHUNK_BLOCKS, pack_chunk, r);
    if (r->out_of_memory)
        return pl_fail_memory(error, "the packed points");
    if (r->refused)
        return pl_fail(
            error, PLANISH_ERROR_FORMAT,
            "%s: a block of %lld bytes of points cannot be packed again (it is too large "
            "for its library, or memory was short)",
            r->model->input.path, (long long)r->blocks.size);
    char *text = join_blocks(r, &header, &length);
    if (array->form == VTU_BASE64) {
        text = blocks_to_base64(text, header, &length);
        while (begin < r->blocks.text_end && (unsigned char)data[begin] <= ' ')
            begin++;
    }
    if (!text)
        return pl_fail_memory(error, "the packed points");
    return io_edits_add(edits, (io_edit){begin, r->blocks.text_end, text, length}, error);
}

static void release_packed(rewrite *r) {
    for (int64_t i = 0; r->packed && i < r->blocks.n; i++)
        pl_free(r->packed[i]);
    pl_free(r->packed);
    pl_free(r->packed_size);
    pl_free(r->dirty);
    vtu_blocks_release(&r->blocks);
}

/* ---- writing: the arrays ------------------------------------------------------------------- */

/** Whether a block is too short to have been unpacked: its first bytes tell how to pack again. */
static int has_tiny_block(const vtu_blocks *blocks) {
    enum { LEAST = 2 };
    for (int64_t i = 0; i < blocks->n; i++)
        if (blocks->packed[i + 1] - blocks->packed[i] < LEAST)
            return 1;
    return 0;
}

static int prepare_packed(rewrite *r, vtu_document *document, planish_error *error) {
    int status = vtu_find_blocks(r->model, document, r->array, r->size, &r->blocks, error);
    if (status)
        return status;
    const int64_t n = r->blocks.n;
    if (r->blocks.bytes != r->size || has_tiny_block(&r->blocks))
        return io_bytes_fail_changed(&r->model->input, error);
    r->dirty = pl_alloc_zero(n, 1);
    r->packed = pl_alloc_zero(n, sizeof *r->packed);
    r->packed_size = pl_alloc(n, sizeof *r->packed_size);
    return r->dirty && r->packed && r->packed_size ? PLANISH_OK
                                                   : pl_fail_memory(error, "the packed points");
}

static int rewrite_array(rewrite *r, vtu_document *document, int threads, io_edits *edits,
                         planish_error *error) {
    const int is_packed = document->compression != IO_PLAIN;
    vtu_values values;
    int status = vtu_decode(r->model, document, r->array, 3 * r->piece->n_points, &values, error);
    if (status)
        return status;
    r->bytes = values.owned;
    r->size = values.n_bytes; /* what is behind the points stays */
    if (is_packed)
        status = prepare_packed(r, document, error);
    if (!status) {
        pl_parallel_for(threads, r->piece->n_points, CHUNK_POINTS, replace_chunk, r);
        if (r->changed)
            status =
                is_packed ? pack_blocks(r, edits, threads, error) : rewrite_base64(r, edits, error);
    }
    release_packed(r);
    vtu_values_release(&values);
    return status;
}

/* ---- writing: offsets ---------------------------------------------------------------------- */

static int compare_edits(const void *a, const void *b) {
    const int64_t p = ((const io_edit *)a)->begin, q = ((const io_edit *)b)->begin;
    return (p > q) - (p < q);
}

/** How much later, in appended data, what follows each edit of these stands: shift [edits->n] by
 *  all edits up to there. Offsets count from where appended data begin. */
static int64_t *sum_shifts(const vtu_document *document, const io_edits *edits) {
    int64_t *shift = pl_alloc(edits->n, sizeof *shift), sum = 0;
    for (int64_t i = 0; shift && i < edits->n; i++) {
        const io_edit *edit = &edits->edit[i];
        if (document->appended >= 0 && edit->begin >= document->appended)
            sum += edit->length - (edit->end - edit->begin);
        shift[i] = sum;
    }
    return shift;
}

/** Number of edits, of the first n, that end at byte at or before. */
static int64_t count_before(const io_edits *edits, int64_t n, int64_t at) {
    int64_t low = 0, high = n;
    while (low < high) {
        const int64_t middle = low + (high - low) / 2;
        if (edits->edit[middle].end <= at)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/** The new offset of an array of appended data, in as many characters where blanks follow. */
static int edit_offset(const io_model *model, const vtu_array *array, int64_t shift,
                       io_edits *edits, planish_error *error) {
    if (shift == 0)
        return PLANISH_OK;
    const char *old = model->input.data + array->offset_begin;
    const int64_t room = array->offset_end - array->offset_begin;
    const int has_blanks = room > 0 && old[room - 1] == ' ';
    char digits[24];
    int64_t length = snprintf(digits, sizeof digits, "%lld", (long long)(array->offset + shift));
    char *text = pl_alloc(length > room ? length : room, 1);
    if (!text)
        return pl_fail_memory(error, "the offsets of arrays");
    memcpy(text, digits, (size_t)length);
    while (has_blanks && length < room)
        text[length++] = ' ';
    return io_edits_add(edits, (io_edit){array->offset_begin, array->offset_end, text, length},
                        error);
}

/** The offsets of arrays behind points that became longer or shorter. */
static int edit_offsets(const io_model *model, const vtu_document *document, io_edits *edits,
                        planish_error *error) {
    const int64_t n = edits->n;
    int64_t *shift = sum_shifts(document, edits);
    int status = shift ? PLANISH_OK : pl_fail_memory(error, "the offsets of arrays");
    for (int64_t i = 0; i < document->n_arrays && !status; i++) {
        const vtu_array *array = &document->array[i];
        const int64_t before = array->is_appended ? count_before(edits, n, array->begin) : 0;
        if (before > 0)
            status = edit_offset(model, array, shift[before - 1], edits, error);
    }
    pl_free(shift);
    return status;
}

int vtu_encode_points(const io_model *model, const double *coordinates, int threads,
                      io_edits *edits, planish_error *error) {
    vtu_document document = *(const vtu_document *)model->encoding;
    int status = PLANISH_OK;
    document.unpacked = 0;
    for (int64_t i = 0; i < document.n_arrays && !status; i++) {
        vtu_array *array = &document.array[i];
        if (array->role != VTU_POINTS || array->piece < 0 || !is_encoded(&document, array))
            continue;
        rewrite r = {.model = model,
                     .document = &document,
                     .array = array,
                     .piece = vtu_piece_of(&document, array),
                     .coordinates = coordinates};
        status = rewrite_array(&r, &document, threads, edits, error);
    }
    if (!status && edits->n > 0) {
        qsort(edits->edit, (size_t)edits->n, sizeof *edits->edit, compare_edits);
        status = edit_offsets(model, &document, edits, error);
        qsort(edits->edit, (size_t)edits->n, sizeof *edits->edit, compare_edits);
    }
    return status;
}
