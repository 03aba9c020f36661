/* medit_binary: Medit's binary .meshb, in either byte order: a 1 (that tells the byte order), the
 * version, and keywords. Each has its code, the position of the next keyword and, most often, a
 * count before its records.
 *
 * Codes are of 32 bits. Version 1 has floats, the later ones doubles; positions are of 64 bits from
 * version 3 on, counts, indices and references from version 4 on. Positions of 32 bits are signed:
 * libMeshb cannot read versions 1 and 2 above 2 GB either.
 */
#include "io/medit/medit.h"

#include "io/core/binary.h"

enum { WORD_SIZE = 4, CODE_DIMENSION = 3, CODE_END = 54, LAST_VERSION = 4 };

/** Read the first two words and the dimension's code; whether they are what they should be. */
static int begins_well(const char *data, int64_t size, int *swapped, int64_t *version) {
    if (size < 3 * WORD_SIZE)
        return 0;
    for (*swapped = 0; *swapped < 2; ++*swapped) {
        *version = io_load_i32(data + WORD_SIZE, *swapped);
        if (io_load_i32(data, *swapped) == 1)
            return *version >= 1 && *version <= LAST_VERSION &&
                   io_load_i32(data + 2 * WORD_SIZE, *swapped) == CODE_DIMENSION;
    }
    return 0;
}

int medit_binary_recognise(const char *data, int64_t size) {
    int swapped;
    int64_t version;
    return begins_well(data, size, &swapped, &version);
}

static int64_t load_integer(const medit_reader *r, const char *at, int size) {
    return size == WORD_SIZE ? io_load_i32(at, r->swapped) : io_load_i64(at, r->swapped);
}

int64_t medit_binary_size(const medit_reader *r, const medit_keyword *k) {
    return (k->kind == MEDIT_VERTICES ? r->dim * r->real_size : 0) +
           medit_integers_of(k) * r->integer_size;
}

static int fail_cut(const medit_reader *r, const char *at, const char *what) {
    return io_fail_at(r->model, at, r->error, "the file ends where %s should be (it is cut short)",
                      what);
}

/** The dimension stands right behind the version; the cursor goes behind it. */
static int read_header(medit_reader *r, io_cursor *cursor) {
    int64_t version = 0;
    begins_well(cursor->at, io_left(cursor), &r->swapped, &version); /* recognised already */
    int status = medit_set_version(r, cursor->at + WORD_SIZE, version);
    if (status)
        return status;
    r->real_size = version == 1 ? (int)sizeof(float) : (int)sizeof(double);
    r->position_size = version < 3 ? WORD_SIZE : 2 * WORD_SIZE;
    r->integer_size = version < 4 ? WORD_SIZE : 2 * WORD_SIZE;
    cursor->at += 3 * WORD_SIZE;
    if (io_left(cursor) < r->position_size + WORD_SIZE)
        return fail_cut(r, cursor->at, "the dimension");
    cursor->at += r->position_size;
    status = medit_set_dimension(r, cursor->at, io_load_i32(cursor->at, r->swapped));
    cursor->at += WORD_SIZE;
    return status;
}

/** The count of a section and its records, from the cursor to next. */
static int read_section(medit_reader *r, const medit_keyword *k, const char *at, const char *next) {
    if (next - at < r->integer_size)
        return io_fail_at(r->model, at, r->error,
                          "there is no room for the number of %s before the next keyword", k->name);
    int64_t count = load_integer(r, at, r->integer_size), size = medit_binary_size(r, k);
    const char *data = at + r->integer_size;
    if (count < 0 || count > (next - data) / size)
        return io_fail_at(r->model, at, r->error,
                          "%lld %s cannot be in the %lld bytes before the next keyword; the "
                          "count is wrong or the file is cut short",
                          (long long)count, k->name, (long long)(next - data));
    return medit_add_section(r, k, count, data, data + count * size);
}

/** The keyword at the cursor, which goes to the next; *done after the last. */
static int walk_keyword(medit_reader *r, io_cursor *cursor, int *done) {
    const char *begin = r->model->input.data, *at = cursor->at;
    if (io_left(cursor) < WORD_SIZE)
        return fail_cut(r, at, "a keyword");
    int64_t code = io_load_i32(at, r->swapped);
    *done = code == CODE_END;
    if (*done)
        return PLANISH_OK;
    const char *data = at + WORD_SIZE + r->position_size;
    if (data > cursor->end)
        return fail_cut(r, at + WORD_SIZE, "a position");
    int64_t next = load_integer(r, at + WORD_SIZE, r->position_size);
    *done = next == 0; /* the last one, without End */
    if (*done)
        next = r->model->input.size;
    if (next > r->model->input.size)
        return io_fail_at(r->model, at + WORD_SIZE, r->error,
                          "the next keyword should be at byte %lld, behind the end of the file "
                          "(it may be cut short)",
                          (long long)next);
    if (next < data - begin)
        return io_fail_at(r->model, at + WORD_SIZE, r->error,
                          "the next keyword should be at byte %lld, which is not behind this one",
                          (long long)next);
    cursor->at = begin + next;
    const medit_keyword *k = medit_find_code(code);
    int status = k ? medit_check_keyword(r, at, k) : PLANISH_OK;
    return k && !status ? read_section(r, k, data, cursor->at) : status;
}

int medit_binary_walk(medit_reader *r) {
    io_cursor cursor = {r->model->input.data, r->model->input.data + r->model->input.size};
    int done = 0, status = read_header(r, &cursor);
    while (!status && !done && cursor.at < cursor.end)
        status = walk_keyword(r, &cursor, &done);
    return status;
}
