/* gmsh_data: over the values of $NodeData, $ElementData and $ElementNodeData in binary files.
 *
 * Their bytes could be anything, the mark of the section's end among them; and not every program
 * begins a line for that mark. So the values are passed over by their count, as Gmsh does.
 *
 * A section: number of texts and these, a line each; number of reals and these; number of whole
 * numbers and these: step, values of a node or element, nodes or elements, ...; and the values: a
 * number (int32), for $ElementNodeData how many nodes follow (int32), and doubles.
 */
#include "io/gmsh.h"

#include "io/binary.h"

enum { STEP, WIDTH, COUNT, N_WANTED };

/* Over the texts and reals before the whole numbers; 0 or -1. */
static int skip_tags(io_cursor *cursor) {
    int64_t n;
    double real;
    if (io_integer(cursor, &n) != 0 || n < 0 || n > io_left(cursor))
        return -1;
    io_skip_line(cursor);
    for (int64_t i = 0; i < n; i++)
        io_skip_line(cursor);
    if (io_integer(cursor, &n) != 0)
        return -1;
    for (int64_t i = 0; i < n; i++)
        if (io_real(cursor, &real) != 0)
            return -1;
    return 0;
}

/* Width and count of the values; the cursor ends behind the line of the last whole number. 0 or -1.
 */
static int take_head(io_cursor *cursor, int64_t *width, int64_t *count) {
    int64_t n, number[N_WANTED] = {0}, value;
    if (skip_tags(cursor) != 0 || io_integer(cursor, &n) != 0 || n < N_WANTED)
        return -1;
    for (int64_t i = 0; i < n; i++) {
        if (io_integer(cursor, &value) != 0)
            return -1;
        if (i < N_WANTED)
            number[i] = value;
    }
    io_skip_line(cursor);
    *width = number[WIDTH];
    *count = number[COUNT];
    return *width >= 0 && *width <= INT32_MAX && *count >= 0 ? 0 : -1;
}

/* Over as many bytes; 0 or -1. */
static int skip_bytes(io_cursor *cursor, int64_t n) {
    if (n > io_left(cursor))
        return -1;
    cursor->at += n;
    return 0;
}

static int skip_values(io_cursor *cursor, int64_t width, int64_t count) {
    const int64_t size = 4 + 8 * width;
    return count > io_left(cursor) / size ? -1 : skip_bytes(cursor, count * size);
}

static int skip_values_of_nodes(io_cursor *cursor, int64_t width, int64_t count, int swapped) {
    for (int64_t i = 0; i < count; i++) {
        if (io_left(cursor) < 8)
            return -1;
        const int64_t nodes = io_load_i32(cursor->at + 4, swapped);
        cursor->at += 8;
        if (nodes < 0 || (width > 0 && nodes > io_left(cursor) / (8 * width)))
            return -1;
        cursor->at += 8 * width * nodes;
    }
    return 0;
}

int gmsh_skip_data(gmsh_reader *reader, int with_nodes) {
    io_cursor cursor = reader->cursor;
    int64_t width, count;
    int status = take_head(&cursor, &width, &count);
    if (status == 0)
        status = with_nodes ? skip_values_of_nodes(&cursor, width, count, reader->swapped)
                            : skip_values(&cursor, width, count);
    if (status == 0)
        reader->cursor = cursor;
    return status;
}
