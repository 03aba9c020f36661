/* format: extensions of formats; the mark of HDF5. */
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

/** Join path, without an extension of the format, and extension in small letters. Owned; *base:
 *  where the latter begins. */
static char *join_extension(const io_format *format, const char *path, const char *extension,
                            size_t *base) {
    *base =
        io_format_has_extension(format, path) ? (size_t)(io_extension(path) - path) : strlen(path);
    char *result = pl_alloc((int64_t)(*base + strlen(extension) + 1), 1);
    if (!result)
        return NULL;
    memcpy(result, path, *base);
    for (size_t i = 0; i <= strlen(extension); i++)
        result[*base + i] = (char)tolower((unsigned char)extension[i]);
    return result;
}

char *io_plain_companion_path(const io_format *format, const char *path, const char *extension) {
    size_t base;
    return join_extension(format, path, extension, &base);
}

char *io_companion_path(const io_format *format, const char *path, const char *extension) {
    size_t base;
    int n_letters = 0, n_small = 0;
    char *result = join_extension(format, path, extension, &base);
    for (const char *c = path + base; result && *c; c++) {
        n_letters += isalpha((unsigned char)*c) != 0;
        n_small += islower((unsigned char)*c) != 0;
    }
    const int is_capital = n_letters > 0 && n_small == 0;
    for (char *at = result ? result + base : ""; *at && is_capital; at++)
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
