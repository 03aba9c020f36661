/* vtu_encode: the points of VTK's XML files, written where they stand.
 *
 * Text and raw bytes are replaced in place by the splice that all formats share. What is base64
 * keeps its characters but for those of bytes that change. Of packed points those blocks are packed
 * again in which something changed, and what follows them in appended data moves: the offsets in
 * the markup say where to.
 */
#include "base/memory.h"
#include "base/parallel.h"
#include "base/round.h"
#include "base/status.h"
#include "io/core/binary.h"
#include "io/core/bytes.h"
#include "base/base64.h"
#include "io/vtk/vtk_base64.h"
#include "io/vtk/vtu_parts.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CHUNK_POINTS = 1 << 14, CHUNK_BLOCKS = 1 };

/* ---- bytes --------------------------------------------------------------------------------- */

/** The new bytes of one array of points. */
typedef struct point_rewrite {
    vtu_document *document;
    vtu_array *array;
    const double *coordinates; /* [n_nodes][written] of the model */
    char *bytes;               /* [size] those of the file, decoded, then the new ones */
    int64_t size;
    int is_changed;
    /* Packed: */
    vtu_blocks blocks;
    uint8_t *is_dirty;                /* [blocks.n] something changed in it */
    char **packed;                    /* [blocks.n] owned; NULL: as it was */
    int64_t *packed_size;             /* [blocks.n] */
    int is_out_of_memory, is_refused; /* in a block */
} point_rewrite;

static void replace_chunk(void *context, int64_t begin, int64_t end, int thread) {
    point_rewrite *r = context;
    const int written = r->document->model->written, size = r->array->type->size;
    const int swapped = r->document->swapped;
    const int64_t first = r->document->piece[r->array->piece].first_point;
    const int64_t of_block = r->blocks.size;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int d = 0; d < written; d++) {
            const int64_t at = (3 * i + d) * size;
            const double now = vtk_real(r->bytes + at, r->array->type, swapped);
            double wanted = r->coordinates[(first + i) * written + d];
            wanted = size == 4 ? pl_round_to_float(wanted) : wanted;
            if (pl_is_same(now, wanted))
                continue;
            const float single = (float)wanted;
            char bytes[8];
            memcpy(bytes, size == 4 ? (const void *)&single : &wanted, (size_t)size);
            for (int k = 0; k < size; k++)
                r->bytes[at + k] = bytes[swapped ? size - 1 - k : k];
            __atomic_store_n(&r->is_changed, 1, __ATOMIC_RELAXED);
            if (!r->is_dirty || of_block <= 0)
                continue;
            for (int64_t k = at / of_block; k <= (at + size - 1) / of_block; k++)
                __atomic_store_n(&r->is_dirty[k], 1, __ATOMIC_RELAXED);
        }
}

/* ---- packed blocks ------------------------------------------------------------------------- */

static void pack_chunk(void *context, int64_t begin, int64_t end, int thread) {
    point_rewrite *r = context;
    const vtu_blocks *b = &r->blocks;
    const io_compression compression = r->document->compression;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int64_t size = i + 1 < b->n ? b->size : b->last_size;
        r->packed_size[i] = b->packed[i + 1] - b->packed[i];
        if (!r->is_dirty[i])
            continue;
        r->packed[i] = pl_alloc(io_pack_bound(compression, size), 1);
        if (r->packed[i])
            r->packed_size[i] = io_pack(compression, r->bytes + i * b->size, size,
                                        b->data + b->packed[i], r->packed[i]);
        if (!r->packed[i])
            __atomic_store_n(&r->is_out_of_memory, 1, __ATOMIC_RELAXED);
        else if (r->packed_size[i] < 0)
            __atomic_store_n(&r->is_refused, 1, __ATOMIC_RELAXED);
    }
}

static void store_header(const vtu_document *document, char *at, int64_t value) {
    for (int k = 0; k < document->header_size; k++) {
        const int place =
            io_machine_is_little() == !document->swapped ? k : document->header_size - 1 - k;
        at[place] = (char)(unsigned char)((uint64_t)value >> 8 * k);
    }
}

/** Join header and blocks; base64: two segments of text. Return them, owned, [*length], or NULL
 *  without memory. */
static char *join_blocks(const point_rewrite *r, int64_t *length) {
    const vtu_blocks *b = &r->blocks;
    const int word = r->document->header_size;
    const int64_t header = (VTU_HEADER_NUMBERS + b->n) * word;
    *length = header;
    for (int64_t i = 0; i < b->n; i++)
        *length += r->packed_size[i];
    char *joined = pl_alloc(*length, 1);
    if (!joined)
        return NULL;
    store_header(r->document, joined, b->n);
    store_header(r->document, joined + word, b->size);
    store_header(r->document, joined + 2 * word, b->last_told);
    char *to = joined + header;
    for (int64_t i = 0; i < b->n; i++) {
        store_header(r->document, joined + (VTU_HEADER_NUMBERS + i) * word, r->packed_size[i]);
        memcpy(to, r->packed[i] ? r->packed[i] : b->data + b->packed[i], (size_t)r->packed_size[i]);
        to += r->packed_size[i];
    }
    if (r->array->form != VTU_BASE64)
        return joined;
    const int64_t data = *length - header;
    char *text = pl_alloc(pl_base64_length(header) + pl_base64_length(data), 1);
    if (text) {
        *length = pl_base64_write(joined, header, text);
        *length += pl_base64_write(joined + header, data, text + *length);
    }
    pl_free(joined);
    return text;
}

/** Pack the blocks in which something changed, and edit the array. */
static int edit_packed(point_rewrite *r, int threads, io_edits *edits) {
    const io_model *model = r->document->model;
    planish_error *error = r->document->error;
    pl_parallel_for(threads, r->blocks.n, CHUNK_BLOCKS, pack_chunk, r);
    if (r->is_out_of_memory)
        return pl_fail_memory(error, "the packed points");
    if (r->is_refused)
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: a block of %lld bytes of points cannot be packed again (it is too "
                       "large for its library, or memory was short)",
                       model->input.path, (long long)r->blocks.size);
    int64_t length, begin = r->array->begin;
    char *text = join_blocks(r, &length);
    if (!text)
        return pl_fail_memory(error, "the packed points");
    while (r->array->form == VTU_BASE64 && begin < r->blocks.text_end &&
           (unsigned char)model->input.data[begin] <= ' ')
        begin++;
    return io_edits_add(edits, (io_edit){begin, r->blocks.text_end, text, length}, error);
}

static int find_packed(point_rewrite *r) {
    enum { LEAST = 2 }; /* the first bytes of a block tell how to pack it again */
    vtu_blocks *b = &r->blocks;
    const int status = vtu_find_blocks(r->document, r->array, r->size, b);
    if (status)
        return status;
    int is_same = b->bytes == r->size;
    for (int64_t i = 0; i < b->n; i++)
        is_same &= b->packed[i + 1] - b->packed[i] >= LEAST;
    if (!is_same)
        return io_bytes_fail_changed(&r->document->model->input, r->document->error);
    r->is_dirty = pl_alloc_zero(b->n, 1);
    r->packed = pl_alloc_zero(b->n, sizeof *r->packed);
    r->packed_size = pl_alloc(b->n, sizeof *r->packed_size);
    return r->is_dirty && r->packed && r->packed_size
               ? PLANISH_OK
               : pl_fail_memory(r->document->error, "the packed points");
}

/* ---- arrays -------------------------------------------------------------------------------- */

/** Edit an array of points: packed ones block by block; of base64 only characters of bytes that
 *  changed. */
static int edit_points(vtu_document *document, vtu_array *array, const double *coordinates,
                       int threads, io_edits *edits) {
    const int64_t n = document->piece[array->piece].n_points;
    const int is_packed = document->compression != IO_PLAIN;
    vtu_values values;
    int status = vtu_decode(document, array, 3 * n, &values);
    /* What is behind the points stays. */
    point_rewrite r = {.document = document,
                       .array = array,
                       .coordinates = coordinates,
                       .bytes = values.owned,
                       .size = values.n_bytes};
    if (!status && is_packed)
        status = find_packed(&r);
    if (!status)
        pl_parallel_for(threads, n, CHUNK_POINTS, replace_chunk, &r);
    if (!status && r.is_changed && is_packed) {
        status = edit_packed(&r, threads, edits);
    } else if (!status && r.is_changed) {
        const int64_t length = array->data_end - array->begin;
        char *text = pl_alloc(length, 1);
        if (text) {
            memcpy(text, document->model->input.data + array->begin, (size_t)length);
            io_base64_replace(text, length, document->header_size, r.size, r.bytes);
        }
        status = text ? io_edits_add(edits, (io_edit){array->begin, array->data_end, text, length},
                                     document->error)
                      : pl_fail_memory(document->error, "the points to be written");
    }
    for (int64_t i = 0; r.packed && i < r.blocks.n; i++)
        pl_free(r.packed[i]);
    pl_free(r.packed);
    pl_free(r.packed_size);
    pl_free(r.is_dirty);
    vtu_blocks_release(&r.blocks);
    vtu_values_release(&values);
    return status;
}

/* ---- offsets ------------------------------------------------------------------------------- */

static int compare_edits(const void *a, const void *b) {
    const int64_t p = ((const io_edit *)a)->begin, q = ((const io_edit *)b)->begin;
    return (p > q) - (p < q);
}

/** Edit the offsets of arrays behind points that became longer or shorter; where blanks follow an
 *  offset, in as many characters. */
static int edit_offsets(const vtu_document *document, io_edits *edits) {
    const int64_t n = edits->n;
    int64_t *shift = pl_alloc(n, sizeof *shift), sum = 0; /* by all edits up to each */
    int status = shift ? PLANISH_OK : pl_fail_memory(document->error, "the offsets of arrays");
    for (int64_t i = 0; i < n && !status; i++) {
        const io_edit *edit = &edits->edit[i];
        if (document->appended >= 0 && edit->begin >= document->appended)
            sum += edit->length - (edit->end - edit->begin);
        shift[i] = sum;
    }
    for (int64_t i = 0; i < document->n_arrays && !status; i++) {
        const vtu_array *array = &document->array[i];
        int64_t low = 0, high = array->is_appended ? n : 0; /* edits that end before the array */
        while (low < high) {
            const int64_t middle = low + (high - low) / 2;
            if (edits->edit[middle].end <= array->begin)
                low = middle + 1;
            else
                high = middle;
        }
        if (low == 0 || shift[low - 1] == 0)
            continue;
        const char *old = document->model->input.data + array->offset_begin;
        const int64_t room = array->offset_end - array->offset_begin;
        const int has_blanks = room > 0 && old[room - 1] == ' ';
        char digits[24];
        int64_t length =
            snprintf(digits, sizeof digits, "%lld", (long long)(array->offset + shift[low - 1]));
        char *text = pl_alloc(length > room ? length : room, 1);
        if (text) {
            memcpy(text, digits, (size_t)length);
            while (has_blanks && length < room)
                text[length++] = ' ';
        }
        status = text
                     ? io_edits_add(edits,
                                    (io_edit){array->offset_begin, array->offset_end, text, length},
                                    document->error)
                     : pl_fail_memory(document->error, "the offsets of arrays");
    }
    pl_free(shift);
    return status;
}

int vtu_encode_points(const io_model *model, const double *coordinates, int threads,
                      io_edits *edits, planish_error *error) {
    vtu_document document = *(const vtu_document *)model->of_format;
    int status = PLANISH_OK;
    document.model = model;
    document.error = error;
    document.unpacked = 0;
    for (int64_t i = 0; i < document.n_arrays && !status; i++) {
        vtu_array *array = &document.array[i];
        const int is_encoded = array->form == VTU_BASE64 ||
                               (array->form == VTU_RAW && document.compression != IO_PLAIN);
        if (array->role == VTU_POINTS && array->piece >= 0 && is_encoded)
            status = edit_points(&document, array, coordinates, threads, edits);
    }
    if (!status && edits->n > 0) {
        qsort(edits->edit, (size_t)edits->n, sizeof *edits->edit, compare_edits);
        status = edit_offsets(&document, edits);
        qsort(edits->edit, (size_t)edits->n, sizeof *edits->edit, compare_edits);
    }
    return status;
}
