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

enum { LZMA_MOST_MEMORY = 1 << 27 }; /* of a decoder; the hardest preset wants half of it */

int io_compression_is_built(io_compression compression) {
    switch (compression) {
#ifdef PL_ZLIB
    case IO_ZLIB:
#endif
#ifdef PL_LZ4
    case IO_LZ4:
#endif
#ifdef PL_LZMA
    case IO_LZMA:
#endif
    case IO_PLAIN:
        return 1;
    default:
        return 0;
    }
}

int io_unpack(io_compression compression, const char *data, int64_t size, char *out,
              int64_t out_size) {
    int64_t n = -1; /* bytes that came out */
    (void)data;     /* without libraries these are not used */
    (void)size;
    (void)out;
    switch (compression) {
#ifdef PL_ZLIB
    case IO_ZLIB: {
        uLongf got = (uLongf)out_size;
        uLong taken = (uLong)size;
        if (uncompress2((Bytef *)out, &got, (const Bytef *)data, &taken) == Z_OK)
            n = (int64_t)got;
        break;
    }
#endif
#ifdef PL_LZ4
    case IO_LZ4:
        if (size <= INT_MAX && out_size <= INT_MAX)
            n = LZ4_decompress_safe(data, out, (int)size, (int)out_size);
        break;
#endif
#ifdef PL_LZMA
    case IO_LZMA: {
        uint64_t memory = LZMA_MOST_MEMORY;
        size_t taken = 0, got = 0;
        if (lzma_stream_buffer_decode(&memory, 0, NULL, (const uint8_t *)data, &taken, (size_t)size,
                                      (uint8_t *)out, &got, (size_t)out_size) == LZMA_OK)
            n = (int64_t)got;
        break;
    }
#endif
    default:
        break;
    }
    return n == out_size ? 0 : -1;
}

int64_t io_pack_bound(io_compression compression, int64_t size) {
    (void)size;
    switch (compression) {
#ifdef PL_ZLIB
    case IO_ZLIB:
        return (int64_t)compressBound((uLong)size);
#endif
#ifdef PL_LZ4
    case IO_LZ4:
        return size > LZ4_MAX_INPUT_SIZE ? 0 : LZ4_compressBound((int)size);
#endif
#ifdef PL_LZMA
    case IO_LZMA:
        return (int64_t)lzma_stream_buffer_bound((size_t)size);
#endif
    default:
        return 0;
    }
}

int64_t io_pack(io_compression compression, const char *data, int64_t size, const char *like,
                char *out) {
    const int64_t bound = io_pack_bound(compression, size);
    (void)bound;
    (void)data;
    (void)like;
    (void)out;
    switch (compression) {
#ifdef PL_ZLIB
    case IO_ZLIB: {
        /* The second byte of a stream tells how hard its writer tried (RFC 1950). */
        static const int level[] = {1, 5, 6, 9};
        uLongf got = (uLongf)bound;
        return compress2((Bytef *)out, &got, (const Bytef *)data, (uLong)size,
                         level[(unsigned char)like[1] >> 6]) == Z_OK
                   ? (int64_t)got
                   : -1;
    }
#endif
#ifdef PL_LZ4
    case IO_LZ4: {
        const int got = bound > 0 ? LZ4_compress_default(data, out, (int)size, (int)bound) : 0;
        return got > 0 ? got : -1;
    }
#endif
#ifdef PL_LZMA
    case IO_LZMA: {
        size_t got = 0;
        lzma_options_lzma options;
        if (lzma_lzma_preset(&options, LZMA_PRESET_DEFAULT))
            return -1;
        /* More than there are data finds no more in them, and takes tens of megabytes a block. */
        if (size < (int64_t)options.dict_size)
            options.dict_size = size < LZMA_DICT_SIZE_MIN ? LZMA_DICT_SIZE_MIN : (uint32_t)size;
        lzma_filter filters[] = {{LZMA_FILTER_LZMA2, &options}, {LZMA_VLI_UNKNOWN, NULL}};
        return lzma_stream_buffer_encode(filters, LZMA_CHECK_CRC32, NULL, (const uint8_t *)data,
                                         (size_t)size, (uint8_t *)out, &got,
                                         (size_t)bound) == LZMA_OK
                   ? (int64_t)got
                   : -1;
    }
#endif
    default:
        return -1;
    }
}
