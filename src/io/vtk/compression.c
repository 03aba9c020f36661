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

static int64_t zlib_unpack(const char *data, int64_t size, char *out, int64_t out_size) {
    uLongf got = (uLongf)out_size;
    uLong taken = (uLong)size;
    return uncompress2((Bytef *)out, &got, (const Bytef *)data, &taken) == Z_OK ? (int64_t)got : -1;
}

static int64_t zlib_bound(int64_t size) {
    return (int64_t)compressBound((uLong)size);
}

static int64_t zlib_pack(const char *data, int64_t size, const char *like, char *out) {
    /* The second byte of a stream tells how hard its writer tried (RFC 1950). */
    static const int levels[] = {1, 5, 6, 9};
    uLongf got = compressBound((uLong)size);
    const int level = levels[(unsigned char)like[1] >> 6];
    return compress2((Bytef *)out, &got, (const Bytef *)data, (uLong)size, level) == Z_OK
               ? (int64_t)got
               : -1;
}
#endif

#ifdef PL_LZ4
#include <lz4.h>

static int64_t lz4_unpack(const char *data, int64_t size, char *out, int64_t out_size) {
    return size <= INT_MAX && out_size <= INT_MAX
               ? LZ4_decompress_safe(data, out, (int)size, (int)out_size)
               : -1;
}

static int64_t lz4_bound(int64_t size) {
    return size > LZ4_MAX_INPUT_SIZE ? 0 : LZ4_compressBound((int)size);
}

static int64_t lz4_pack(const char *data, int64_t size, const char *like, char *out) {
    const int bound = (int)lz4_bound(size);
    const int got = bound > 0 ? LZ4_compress_default(data, out, (int)size, bound) : 0;
    (void)like;
    return got > 0 ? got : -1;
}
#endif

#ifdef PL_LZMA
#include <lzma.h>

enum { LZMA_MOST_MEMORY = 1 << 27 }; /* of a decoder; the hardest preset wants half of it */

static int64_t xz_unpack(const char *data, int64_t size, char *out, int64_t out_size) {
    uint64_t memory = LZMA_MOST_MEMORY;
    size_t taken = 0, got = 0;
    return lzma_stream_buffer_decode(&memory, 0, NULL, (const uint8_t *)data, &taken, (size_t)size,
                                     (uint8_t *)out, &got, (size_t)out_size) == LZMA_OK
               ? (int64_t)got
               : -1;
}

static int64_t xz_bound(int64_t size) {
    return (int64_t)lzma_stream_buffer_bound((size_t)size);
}

static int64_t xz_pack(const char *data, int64_t size, const char *like, char *out) {
    size_t got = 0;
    lzma_options_lzma options;
    (void)like;
    if (lzma_lzma_preset(&options, LZMA_PRESET_DEFAULT))
        return -1;
    /* More than there are data finds no more in them, and takes tens of megabytes a block. */
    if (size < (int64_t)options.dict_size)
        options.dict_size = size < LZMA_DICT_SIZE_MIN ? LZMA_DICT_SIZE_MIN : (uint32_t)size;
    lzma_filter filters[] = {{LZMA_FILTER_LZMA2, &options}, {LZMA_VLI_UNKNOWN, NULL}};
    return lzma_stream_buffer_encode(filters, LZMA_CHECK_CRC32, NULL, (const uint8_t *)data,
                                     (size_t)size, (uint8_t *)out, &got,
                                     (size_t)xz_bound(size)) == LZMA_OK
               ? (int64_t)got
               : -1;
}
#endif

/** Functions of a library, all NULL without it: bytes that come out, or -1; a bound of these. */
static const struct {
    int64_t (*unpack)(const char *data, int64_t size, char *out, int64_t out_size);
    int64_t (*bound)(int64_t size);
    int64_t (*pack)(const char *data, int64_t size, const char *like, char *out);
} libraries[IO_LZMA + 1] = {
#ifdef PL_ZLIB
    [IO_ZLIB] = {zlib_unpack, zlib_bound, zlib_pack},
#endif
#ifdef PL_LZ4
    [IO_LZ4] = {lz4_unpack, lz4_bound, lz4_pack},
#endif
#ifdef PL_LZMA
    [IO_LZMA] = {xz_unpack, xz_bound, xz_pack},
#endif
    [IO_PLAIN] = {NULL, NULL, NULL}};

int io_compression_is_built(io_compression compression) {
    return compression == IO_PLAIN || libraries[compression].unpack;
}

int io_unpack(io_compression compression, const char *data, int64_t size, char *out,
              int64_t out_size) {
    return libraries[compression].unpack &&
                   libraries[compression].unpack(data, size, out, out_size) == out_size
               ? 0
               : -1;
}

int64_t io_pack_bound(io_compression compression, int64_t size) {
    return libraries[compression].bound ? libraries[compression].bound(size) : 0;
}

int64_t io_pack(io_compression compression, const char *data, int64_t size, const char *like,
                char *out) {
    return libraries[compression].pack ? libraries[compression].pack(data, size, like, out) : -1;
}
