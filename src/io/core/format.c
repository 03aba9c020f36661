/* format: extensions of formats; the mark of HDF5, and AVS UCD. */
#include "io/core/format.h"

#include "io/core/text.h"

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

int io_is_ucd(const char *data, int64_t size) {
    enum { N_COUNTS = 5 };
    static const char *const types[] = {"pt", "line", "tri", "quad", "tet", "pyr", "prism", "hex"};
    io_cursor cursor = io_begin_text(data, size);
    int64_t count[N_COUNTS], number, material;
    io_skip_space_comments(&cursor, '#');
    io_slice next = io_next_line(&cursor);
    io_cursor line = {next.begin, next.end}; /* of counts, and of nothing else */
    for (int i = 0; i < N_COUNTS; i++)
        if (io_integer(&line, &count[i]) || count[i] < 0)
            return 0;
    io_skip_space(&line);
    if (line.at < line.end || count[0] == 0 || count[1] == 0)
        return 0;
    for (int64_t i = 0; i < count[0] && cursor.at < cursor.end; i++)
        io_skip_line(&cursor);
    next = io_next_line(&cursor);
    line = (io_cursor){next.begin, next.end}; /* of a cell: number, material, type */
    if (io_integer(&line, &number) || io_integer(&line, &material))
        return 0;
    const io_slice word = io_next_word(&line);
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (io_slice_is(word, types[i], 0))
            return 1;
    return 0;
}
