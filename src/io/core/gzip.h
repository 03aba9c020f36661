/* gzip: files packed by gzip (RFC 1952), if planish was built with zlib.
 *
 *   io_is_gzip                     whether bytes are packed
 *   io_gunzip                      unpack all of a file
 *   io_gzip_begin, io_gzip_end     pack what is written
 */
#ifndef PL_IO_CORE_GZIP_H
#define PL_IO_CORE_GZIP_H

#include "io/core/model.h"

/** Return whether the bytes begin as a file of gzip's does. */
int io_is_gzip(const char *data, int64_t size);

/** Unpack all parts of a file into private memory under the same path; at most a quarter of the
 *  machine's memory. Errors: _FORMAT (damage; planish was built without zlib), _FILE (too large),
 *  _MEMORY. */
int io_gunzip(const io_bytes *packed, io_bytes *bytes, planish_error *error);

/** Pack the bytes that are written to output, with the header (name and time) and about the
 *  strength of the packed file like. It is one part, whatever like was. Errors: _FORMAT, _MEMORY,
 *  _FILE. */
int io_gzip_begin(pl_output *output, const io_bytes *like, planish_error *error);

/** Release the state of packing; in any case after io_gzip_begin. */
void io_gzip_end(pl_output *output);

#endif
