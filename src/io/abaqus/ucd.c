/* ucd: tells files of AVS UCD, which are not read, by their content.
 *
 * In: the bytes of a file. Out: whether they are UCD's text: comments ('#'), a line of five counts
 * (nodes, cells, data of each kind), a line for each node, and cells that name their type.
 */
#include "io/abaqus/ucd.h"

#include "io/core/text.h"

#include <stddef.h>

enum { N_COUNTS = 5 };

/** Whether the line has n whole numbers that are not negative, and nothing else; counts [n]. */
static int take_counts(io_cursor line, int n, int64_t *counts) {
    for (int i = 0; i < n; i++)
        if (io_integer(&line, &counts[i]) || counts[i] < 0)
            return 0;
    io_skip_space(&line);
    return line.at == line.end;
}

/** The next line; an empty one at the end. */
static io_cursor take_line(io_cursor *cursor) {
    io_cursor line = {NULL, NULL};
    line.at = io_line(cursor, &line.end);
    return line;
}

/** Whether the line is "number material type ...". */
static int is_cell(io_cursor line) {
    static const char *const types[] = {"pt", "line", "tri", "quad", "tet", "pyr", "prism", "hex"};
    int64_t number, material, length;
    if (io_integer(&line, &number) || io_integer(&line, &material))
        return 0;
    const char *word = io_word(&line, &length);
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (io_word_is(word, length, types[i], 0))
            return 1;
    return 0;
}

int io_is_ucd(const char *data, int64_t size) {
    io_cursor cursor = io_begin_text(data, size);
    int64_t counts[N_COUNTS];
    io_skip_space_comments(&cursor, '#');
    if (!take_counts(take_line(&cursor), N_COUNTS, counts) || counts[0] == 0 || counts[1] == 0)
        return 0;
    for (int64_t i = 0; i < counts[0] && cursor.at < cursor.end; i++)
        io_skip_line(&cursor);
    return is_cell(take_line(&cursor));
}
