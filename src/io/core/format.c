/* format: extensions of formats, and the mark of HDF5. */
#include "io/core/format.h"

#include "base/memory.h"
#include "base/system.h"

#include <ctype.h>
#include <string.h>
#include <strings.h>

/* ---- extensions ------------------------------------------------------------------------------ */

int io_format_has_extension(const io_format *format, const char *path) {
    size_t length = strlen(path);
    for (const char *const *extension = format->extensions; *extension; extension++) {
        size_t size = strlen(*extension);
        if (length > size && strcasecmp(path + length - size, *extension) == 0)
            return 1;
    }
    return 0;
}

const char *io_extension(const char *path) {
    const char *dot = strrchr(pl_path_name(path), '.');
    return dot ? dot : path + strlen(path);
}

/** Length of path without an extension of the format. */
static size_t base_length(const io_format *format, const char *path) {
    return io_format_has_extension(format, path) ? (size_t)(io_extension(path) - path)
                                                 : strlen(path);
}

/** Whether that extension is in capitals. */
static int is_capital(const char *extension) {
    int letters = 0, small = 0;
    for (; *extension; extension++) {
        letters += isalpha((unsigned char)*extension) != 0;
        small += islower((unsigned char)*extension) != 0;
    }
    return letters > 0 && small == 0;
}

/** The first length bytes of path, and extension behind them, in small letters. Owned. */
static char *join(const char *path, size_t length, const char *extension) {
    char *result = pl_alloc((int64_t)(length + strlen(extension) + 1), 1);
    if (!result)
        return NULL;
    memcpy(result, path, length);
    for (size_t i = 0; i <= strlen(extension); i++)
        result[length + i] = (char)tolower((unsigned char)extension[i]);
    return result;
}

char *io_plain_companion_path(const io_format *format, const char *path, const char *extension) {
    return join(path, base_length(format, path), extension);
}

char *io_companion_path(const io_format *format, const char *path, const char *extension) {
    const size_t base = base_length(format, path);
    char *result = join(path, base, extension);
    for (char *at = result ? result + base : ""; *at && is_capital(path + base); at++)
        *at = (char)toupper((unsigned char)*at);
    return result;
}

/* ---- content --------------------------------------------------------------------------------- */

int io_is_hdf5(const char *data, int64_t size) {
    static const char mark[] = "\211HDF\r\n\032\n";
    const int64_t length = (int64_t)sizeof mark - 1;
    for (int64_t at = 0; at <= size - length; at = at ? 2 * at : 512)
        if (memcmp(data + at, mark, (size_t)length) == 0)
            return 1;
    return 0;
}
