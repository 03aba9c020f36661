/* gzip: files packed by gzip. */
#include "io/core/gzip.h"

#include "io/core/bytes.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/system.h"

#include <string.h>

int io_is_gzip(const char *data, int64_t size) {
    return size > 2 && memcmp(data, "\x1f\x8b", 2) == 0;
}

#ifdef PL_ZLIB
#include <zlib.h>

enum {
    RAW = -15,         /* bits of the window of zlib; without a header of its own */
    WITH_HEADER = 31,  /* with gzip's */
    CHUNK = 1 << 18,   /* bytes handed to zlib at once */
    AT_ONCE = 1 << 30, /* zlib counts by 32 bits */
    FREE = 32 << 20,   /* bytes that any file may have unpacked; larger ones */
    MOST_RATIO = 50,   /* as many times their size: meshes shrink to a fifteenth at most */
    HEADER = 10,       /* bytes of the header that all files have */
    MEMORY_LEVEL = 8   /* zlib's default */
};

/* ---- unpacking ------------------------------------------------------------------------------ */

static int fail_damaged(const io_bytes *packed, planish_error *error) {
    return pl_fail(error, PLANISH_ERROR_FORMAT,
                   "%s: cannot be unpacked: it is damaged or cut short", packed->path);
}

/** Unpack the parts of a file, one behind the other; behind the last may be zeros. */
static int unpack(z_stream *z, const io_bytes *packed, io_bytes *bytes, planish_error *error) {
    const int64_t largest = pl_system_memory() / 4, by_ratio = packed->size * MOST_RATIO;
    const int64_t most = by_ratio < FREE ? FREE : by_ratio < largest ? by_ratio : largest;
    const char *at = packed->data, *end = at + packed->size;
    int64_t capacity = 0;
    int code = Z_OK;
    while (at < end || code == Z_OK) {
        if (bytes->size == capacity) {
            char *grown = pl_grow((char *)(uintptr_t)bytes->data, bytes->size, bytes->size + CHUNK,
                                  &capacity, 1);
            if (!grown)
                return pl_fail_memory(error, packed->path);
            bytes->data = grown;
        }
        if (bytes->size > most)
            return pl_fail(error, PLANISH_ERROR_FILE,
                           "%s: holds more than %lld MB; unpack it first", packed->path,
                           (long long)(most >> 20));
        const int64_t room = capacity - bytes->size, left = end - at;
        z->next_in = (Bytef *)(uintptr_t)at;
        z->avail_in = (uInt)(left < AT_ONCE ? left : AT_ONCE);
        z->next_out = (Bytef *)(uintptr_t)(bytes->data + bytes->size);
        z->avail_out = (uInt)(room < AT_ONCE ? room : AT_ONCE);
        const uInt in = z->avail_in, out = z->avail_out;
        code = inflate(z, Z_NO_FLUSH);
        at += in - z->avail_in;
        bytes->size += out - z->avail_out;
        if (code == Z_STREAM_END) {
            while (at < end && *at == '\0')
                at++;
            if (at < end && inflateReset(z) != Z_OK)
                return fail_damaged(packed, error);
        } else if (code != Z_OK || (in == z->avail_in && out == z->avail_out)) {
            return fail_damaged(packed, error);
        }
    }
    return PLANISH_OK;
}

int io_gunzip(const io_bytes *packed, io_bytes *bytes, planish_error *error) {
    z_stream z = {.next_in = NULL};
    *bytes = (io_bytes){.path = pl_copy_text(packed->path), .fd = -1};
    int status = bytes->path && inflateInit2(&z, WITH_HEADER) == Z_OK
                     ? PLANISH_OK
                     : pl_fail_memory(error, packed->path);
    if (!status)
        status = unpack(&z, packed, bytes, error);
    inflateEnd(&z);
    if (!status && bytes->size == 0)
        status = pl_fail(error, PLANISH_ERROR_FORMAT, "%s: the file is empty", packed->path);
    if (status)
        io_bytes_close(bytes);
    return status;
}

/* ---- packing -------------------------------------------------------------------------------- */

typedef struct packer {
    z_stream z;
    uLong crc;
    uint32_t size; /* modulo 2^32, as the end of the file has it */
    char out[CHUNK];
} packer;

/** Return the length of the header of a packed file, or 0: it is damaged. */
static int64_t header_length(const io_bytes *like) {
    enum { FLAGS = 3, CRC = 2, EXTRA = 4, NAME = 8, COMMENT = 16 };
    const unsigned char *data = (const unsigned char *)like->data;
    int64_t at = HEADER;
    if (like->size < HEADER)
        return 0;
    const int flags = data[FLAGS];
    if (flags & EXTRA)
        at += at + 2 <= like->size ? 2 + (data[at] | data[at + 1] << 8) : like->size;
    for (int flag = NAME; flag <= COMMENT; flag *= 2) { /* texts that end with 0 */
        while ((flags & flag) && at < like->size && data[at])
            at++;
        at += (flags & flag) != 0;
    }
    at += flags & CRC ? 2 : 0;
    return at < like->size ? at : 0;
}

/** Hand bytes to zlib (flush: Z_FINISH with the last), and write what comes of them. */
static int deflate_bytes(packer *p, pl_output *output, const char *data, int64_t size, int flush,
                         planish_error *error) {
    int status = PLANISH_OK, code = Z_OK;
    p->z.next_in = (Bytef *)(uintptr_t)data;
    p->z.avail_in = (uInt)size;
    do {
        p->z.next_out = (Bytef *)p->out;
        p->z.avail_out = CHUNK;
        code = deflate(&p->z, flush);
        if (code == Z_STREAM_ERROR)
            return pl_fail_memory(error, output->target);
        status = pl_output_write_as_it_is(output, p->out, CHUNK - (int64_t)p->z.avail_out, error);
    } while (!status && (flush == Z_FINISH ? code != Z_STREAM_END : p->z.avail_out == 0));
    return status;
}

/** pl_output.pack */
static int pack(pl_output *output, const char *data, int64_t size, planish_error *error) {
    packer *p = output->packer;
    int status = PLANISH_OK;
    for (int64_t done = 0; data && done < size && !status;) {
        const int64_t n = size - done < AT_ONCE ? size - done : AT_ONCE;
        p->crc = crc32(p->crc, (const Bytef *)data + done, (uInt)n);
        p->size += (uint32_t)n;
        status = deflate_bytes(p, output, data + done, n, Z_NO_FLUSH, error);
        done += n;
    }
    if (data || status)
        return status;
    unsigned char tail[8];
    for (int i = 0; i < 4; i++) {
        tail[i] = (unsigned char)(p->crc >> (8 * i));
        tail[4 + i] = (unsigned char)(p->size >> (8 * i));
    }
    status = deflate_bytes(p, output, NULL, 0, Z_FINISH, error);
    return status ? status
                  : pl_output_write_as_it_is(output, (const char *)tail, sizeof tail, error);
}

int io_gzip_begin(pl_output *output, const io_bytes *like, planish_error *error) {
    enum { EXTRA_FLAGS = 8, BEST = 2, FASTEST = 4 };
    const int64_t header = header_length(like);
    if (header == 0)
        return io_bytes_fail_changed(like, error);
    packer *p = pl_alloc_zero(1, sizeof *p);
    const int tried = (unsigned char)like->data[EXTRA_FLAGS];
    const int level = tried == BEST      ? Z_BEST_COMPRESSION
                      : tried == FASTEST ? Z_BEST_SPEED
                                         : Z_DEFAULT_COMPRESSION;
    if (!p ||
        deflateInit2(&p->z, level, Z_DEFLATED, RAW, MEMORY_LEVEL, Z_DEFAULT_STRATEGY) != Z_OK) {
        pl_free(p);
        return pl_fail_memory(error, like->path);
    }
    p->crc = crc32(0, NULL, 0);
    output->packer = p;
    output->pack = pack;
    return pl_output_write_as_it_is(output, like->data, header, error);
}

void io_gzip_end(pl_output *output) {
    packer *p = output->packer;
    if (p)
        deflateEnd(&p->z);
    pl_free(p);
    output->packer = NULL;
    output->pack = NULL;
}

#else

static int fail_without(const io_bytes *packed, planish_error *error) {
    return pl_fail(error, PLANISH_ERROR_FORMAT,
                   "%s: this planish was built without zlib, which packed files need: unpack it "
                   "(gunzip), or install zlib1g-dev and build again",
                   packed->path);
}

int io_gunzip(const io_bytes *packed, io_bytes *bytes, planish_error *error) {
    *bytes = (io_bytes){.fd = -1};
    return fail_without(packed, error);
}

int io_gzip_begin(pl_output *output, const io_bytes *like, planish_error *error) {
    (void)output;
    return fail_without(like, error);
}

void io_gzip_end(pl_output *output) {
    (void)output;
}

#endif
