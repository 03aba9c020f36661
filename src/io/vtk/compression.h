/* compression: blocks of bytes packed and unpacked by zlib, LZ4 or LZMA, each if planish was built
 * with that library.
 *
 *   io_compression_is_built    which there are
 *   io_unpack                  unpack a block
 *   io_pack, io_pack_bound     pack a block
 */
#ifndef PL_IO_VTK_COMPRESSION_H
#define PL_IO_VTK_COMPRESSION_H

#include <stdint.h>

typedef enum io_compression { IO_PLAIN, IO_ZLIB, IO_LZ4, IO_LZMA } io_compression;

/** Return whether this planish has it. */
int io_compression_is_built(io_compression compression);

/** Unpack size bytes at data to out, which must be exactly out_size bytes. 0, or -1: they are
 *  not, or something is wrong with them. Never writes more. */
int io_unpack(io_compression compression, const char *data, int64_t size, char *out,
              int64_t out_size);

/** Return the bytes that packing size bytes may take at most; 0: too many for the library. */
int64_t io_pack_bound(io_compression compression, int64_t size);

/** Pack size bytes at data to out [io_pack_bound], about as well as the packed bytes at like [at
 *  least one] were; return the size of the result, or -1. */
int64_t io_pack(io_compression compression, const char *data, int64_t size, const char *like,
                char *out);

#endif
