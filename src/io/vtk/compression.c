/* compression: blocks of bytes packed and unpacked by zlib, LZ4 or LZMA.
 *
 * Of each library the functions for whole blocks are used: the size of what comes out is bounded
 * by the caller, whatever the packed bytes say.
 */
#include "io/vtk/compression.h"

#include <limits.h>
#include <stddef.h>

#ifdef PL_ZLIB
#include <zlib.h>
#endif
#ifdef PL_LZ4
#include <lz4.h>
#endif
#ifdef PL_LZMA
#include <lzma.h>
#endif

/** One of the libraries. */
typedef struct packer {
    int (*unpack)(const char *data, int64_t size, char *out, int64_t out_size);
    int64_t (*bound)(int64_t size);
    int64_t (*pack)(const char *data, int64_t size, const char *like, char *out, int64_t bound);
} packer;

#ifdef PL_ZLIB
static int zlib_unpack(const char *data, int64_t size, char *out, int64_t out_size) {
    uLongf got = (uLongf)out_size;
    uLong taken = (uLong)size;
    return uncompress2((Bytef *)out, &got, (const Bytef *)data, &taken) == Z_OK &&
                   got == (uLongf)out_size
               ? 0
               : -1;
}

static int64_t zlib_bound(int64_t size) {
    return (int64_t)compressBound((uLong)size);
}

/** The second byte of a stream tells how hard its writer tried (RFC 1950). */
static int zlib_level(const char *like) {
    static const int level[] = {1, 5, 6, 9};
    return level[(unsigned char)like[1] >> 6];
}

static int64_t zlib_pack(const char *data, int64_t size, const char *like, char *out,
                         int64_t bound) {
    uLongf got = (uLongf)bound;
    const int status =
        compress2((Bytef *)out, &got, (const Bytef *)data, (uLong)size, zlib_level(like));
    return status == Z_OK ? (int64_t)got : -1;
}

static const packer zlib_packer = {zlib_unpack, zlib_bound, zlib_pack};
#endif

#ifdef PL_LZ4
static int lz4_unpack(const char *data, int64_t size, char *out, int64_t out_size) {
    if (size > INT_MAX || out_size > INT_MAX)
        return -1;
    return LZ4_decompress_safe(data, out, (int)size, (int)out_size) == out_size ? 0 : -1;
}

static int64_t lz4_bound(int64_t size) {
    return size > LZ4_MAX_INPUT_SIZE ? 0 : LZ4_compressBound((int)size);
}

static int64_t lz4_pack(const char *data, int64_t size, const char *like, char *out,
                        int64_t bound) {
    (void)like;
    const int got = bound > 0 ? LZ4_compress_default(data, out, (int)size, (int)bound) : 0;
    return got > 0 ? got : -1;
}

static const packer lz4_packer = {lz4_unpack, lz4_bound, lz4_pack};
#endif

#ifdef PL_LZMA
enum { MOST_MEMORY = 1 << 27 }; /* of a decoder; the hardest preset wants half of it */

static int lzma_unpack(const char *data, int64_t size, char *out, int64_t out_size) {
    uint64_t memory = MOST_MEMORY;
    size_t taken = 0, got = 0;
    const lzma_ret status =
        lzma_stream_buffer_decode(&memory, 0, NULL, (const uint8_t *)data, &taken, (size_t)size,
                                  (uint8_t *)out, &got, (size_t)out_size);
    return status == LZMA_OK && got == (size_t)out_size ? 0 : -1;
}

static int64_t lzma_bound(int64_t size) {
    return (int64_t)lzma_stream_buffer_bound((size_t)size);
}

static int64_t lzma_pack(const char *data, int64_t size, const char *like, char *out,
                         int64_t bound) {
    size_t got = 0;
    lzma_options_lzma options;
    (void)like;
    if (lzma_lzma_preset(&options, LZMA_PRESET_DEFAULT))
        return -1;
    /* More than there are data finds no more in them, and takes tens of megabytes a block. */
    if (size < (int64_t)options.dict_size)
        options.dict_size = size < LZMA_DICT_SIZE_MIN ? LZMA_DICT_SIZE_MIN : (uint32_t)size;
    lzma_filter filters[] = {{LZMA_FILTER_LZMA2, &options}, {LZMA_VLI_UNKNOWN, NULL}};
    const lzma_ret status =
        lzma_stream_buffer_encode(filters, LZMA_CHECK_CRC32, NULL, (const uint8_t *)data,
                                  (size_t)size, (uint8_t *)out, &got, (size_t)bound);
    return status == LZMA_OK ? (int64_t)got : -1;
}

static const packer lzma_packer = {lzma_unpack, lzma_bound, lzma_pack};
#endif

/** NULL: not built. */
static const packer *packer_of(io_compression compression) {
    switch (compression) {
#ifdef PL_ZLIB
    case IO_ZLIB:
        return &zlib_packer;
#endif
#ifdef PL_LZ4
    case IO_LZ4:
        return &lz4_packer;
#endif
#ifdef PL_LZMA
    case IO_LZMA:
        return &lzma_packer;
#endif
    default:
        return NULL;
    }
}

int io_compression_is_built(io_compression compression) {
    return compression == IO_PLAIN || packer_of(compression) != NULL;
}

int io_unpack(io_compression compression, const char *data, int64_t size, char *out,
              int64_t out_size) {
    const packer *p = packer_of(compression);
    return p ? p->unpack(data, size, out, out_size) : -1;
}

int64_t io_pack_bound(io_compression compression, int64_t size) {
    const packer *p = packer_of(compression);
    return p ? p->bound(size) : 0;
}

int64_t io_pack(io_compression compression, const char *data, int64_t size, const char *like,
                char *out) {
    const packer *p = packer_of(compression);
    return p ? p->pack(data, size, like, out, p->bound(size)) : -1;
}
