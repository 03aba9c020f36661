/* vtk_base64: bytes from base64 text and back, as a stream. */
#include "io/vtk/vtk_base64.h"

#include "base/base64.h"

#include <string.h>

enum { PADDING = 64, SPACE = 65, INVALID = 66 };

/* The value of each character, by its place in the alphabet. */
#define X INVALID
#define S SPACE
static const uint8_t value_of[256] = {
    X,  X,  X,  X,  X,  X,  X,  X,  X,  S,  S,  S,  S,  S,  X,  X,  X,  X,       X,  X,  X,  X,
    X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  S,  X,  X,  X,  X,  X,  X,  X,       X,  X,  X,  62,
    X,  X,  X,  63, 52, 53, 54, 55, 56, 57, 58, 59, 60, 61, X,  X,  X,  PADDING, X,  X,  X,  0,
    1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13, 14, 15, 16, 17, 18,      19, 20, 21, 22,
    23, 24, 25, X,  X,  X,  X,  X,  X,  26, 27, 28, 29, 30, 31, 32, 33, 34,      35, 36, 37, 38,
    39, 40, 41, 42, 43, 44, 45, 46, 47, 48, 49, 50, 51, X,  X,  X,  X,  X,       X,  X,  X,  X,
    X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,       X,  X,  X,  X,
    X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,       X,  X,  X,  X,
    X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,       X,  X,  X,  X,
    X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,       X,  X,  X,  X,
    X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,       X,  X,  X,  X,
    X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X,  X};
#undef X
#undef S

/** A group of four characters: where they stand, and the bytes that they are. */
typedef struct base64_group {
    const char *place[4];
    unsigned char bytes[3];
    int n; /* of the bytes: 1 to 3 */
} base64_group;

static uint8_t value_at(const char *at) {
    return value_of[(unsigned char)*at];
}

static int next_group(io_cursor *cursor, base64_group *g) {
    uint8_t value[4];
    for (int k = 0; k < 4; k++) {
        while (cursor->at < cursor->end && value_at(cursor->at) == SPACE)
            cursor->at++;
        if (cursor->at == cursor->end || value_at(cursor->at) == INVALID)
            return -1;
        value[k] = value_at(cursor->at);
        g->place[k] = cursor->at++;
    }
    g->n = value[3] != PADDING ? 3 : value[2] != PADDING ? 2 : 1;
    if (value[0] == PADDING || value[1] == PADDING || (value[2] == PADDING && g->n == 3))
        return -1;
    const uint8_t third = value[2] & 63, fourth = value[3] & 63; /* padding is 0 */
    g->bytes[0] = (unsigned char)(value[0] << 2 | value[1] >> 4);
    g->bytes[1] = (unsigned char)(value[1] << 4 | third >> 2);
    g->bytes[2] = (unsigned char)(third << 6 | fourth);
    return 0;
}

int io_base64_read(io_base64 *stream, int64_t n, char *out) {
    io_cursor *cursor = &stream->cursor;
    while (n > 0) {
        /* Most groups stand without a gap: as many whole ones as there are of n bytes. */
        int64_t whole = stream->n_pending == 0 ? n / 3 : 0;
        for (; whole > 0 && cursor->end - cursor->at >= 4; whole--) {
            const uint8_t a = value_at(cursor->at), b = value_at(cursor->at + 1);
            const uint8_t c = value_at(cursor->at + 2), d = value_at(cursor->at + 3);
            if ((a | b | c | d) >= PADDING)
                break;
            out[0] = (char)(a << 2 | b >> 4);
            out[1] = (char)(b << 4 | c >> 2);
            out[2] = (char)(c << 6 | d);
            out += 3;
            n -= 3;
            cursor->at += 4;
        }
        if (n == 0)
            return 0;
        if (stream->n_pending == 0) {
            base64_group g;
            if (next_group(cursor, &g))
                return -1;
            memcpy(stream->pending, g.bytes, sizeof g.bytes);
            stream->n_pending = g.n;
        }
        const int taken = n < stream->n_pending ? (int)n : stream->n_pending;
        memcpy(out, stream->pending, (size_t)taken);
        memmove(stream->pending, stream->pending + taken, (size_t)(stream->n_pending - taken));
        stream->n_pending -= taken;
        out += taken;
        n -= taken;
    }
    return 0;
}

int64_t io_base64_replace(char *text, int64_t length, int64_t first, int64_t n, const char *data) {
    io_cursor cursor = {text, text + length};
    base64_group g;
    for (int64_t at = 0; at < first + n && next_group(&cursor, &g) == 0; at += g.n) {
        unsigned char bytes[3];
        char written[4];
        memcpy(bytes, g.bytes, sizeof bytes);
        for (int k = 0; k < g.n && k < 3; k++)
            if (at + k >= first && at + k < first + n)
                bytes[k] = (unsigned char)data[at + k - first];
        if (memcmp(bytes, g.bytes, (size_t)g.n) == 0)
            continue;
        pl_base64_write((const char *)bytes, g.n, written);
        for (int k = 0; k < 4; k++)
            text[g.place[k] - text] = written[k];
    }
    return cursor.at - text;
}
