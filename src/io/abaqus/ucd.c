/* ucd: tells files of AVS UCD, which are not read, by their content.
 *
 * In: the bytes of a file. Out: whether they are UCD's text: comments ('#'), a line of five counts
 * (nodes, cells, data of each kind), a line for each node, and cells that name their type.
 */
#include "io/abaqus/ucd.h"

#include "io/core/text.h"

#include <stddef.h>

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
