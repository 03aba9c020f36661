/* medit_text: Medit's ASCII .mesh: keywords, each with a count and that many records; '#' begins a
 * comment. The walk goes from keyword to keyword, over what is between them. */
#include "io/medit/medit.h"

/** A number that belongs to a keyword. */
static int take_number(medit_reader *r, io_cursor *cursor, const char *name, int64_t *value) {
    io_skip_space_comments(cursor, '#');
    if (io_integer(cursor, value))
        return io_fail_at(r->model, cursor->at, r->error, "a whole number expected after %s", name);
    return PLANISH_OK;
}

/** Least bytes of a record: a digit and a space for each number. */
static int64_t least_bytes(const medit_reader *r, const medit_keyword *k) {
    return 2 * (medit_integers_of(k) + (k->kind == MEDIT_VERTICES ? r->dim : 0));
}

/** Whether as many records can be in what is left of the file from at on. */
static int check_count(const medit_reader *r, const medit_keyword *k, int64_t count,
                       const char *at) {
    const int64_t left = r->model->input.data + r->model->input.size - at;
    /* The last number of a file needs no space behind it. */
    if (count >= 0 && count <= (left + 1) / least_bytes(r, k))
        return PLANISH_OK;
    return io_fail_at(r->model, at, r->error,
                      "%lld %s cannot be in the %lld bytes that are left; the count is wrong or "
                      "the file is cut short",
                      (long long)count, k->name, (long long)left);
}

static int read_section(medit_reader *r, const medit_keyword *k, io_cursor *cursor) {
    int64_t count;
    int status = take_number(r, cursor, k->name, &count);
    if (!status)
        status = check_count(r, k, count, cursor->at);
    if (status)
        return status;
    const char *data = cursor->at;
    io_skip_numbers(cursor);
    return medit_add_section(r, k, count, data, cursor->at);
}

static int read_header(medit_reader *r, const char *word, int64_t length, io_cursor *cursor) {
    int64_t value;
    int is_version = io_word_is(word, length, "MeshVersionFormatted", 0);
    int status = take_number(r, cursor, is_version ? "MeshVersionFormatted" : "Dimension", &value);
    if (!status)
        status = is_version ? medit_set_version(r, cursor->at, value)
                            : medit_set_dimension(r, cursor->at, value);
    io_skip_numbers(cursor);
    return status;
}

/** Read one keyword and pass over what belongs to it; *done after End. */
static int walk_keyword(medit_reader *r, io_cursor *cursor, int *done) {
    int64_t length;
    const char *word = io_word(cursor, &length);
    if (io_word_is(word, length, "End", 0)) {
        *done = 1;
        return PLANISH_OK;
    }
    if (io_word_is(word, length, "MeshVersionFormatted", 0) ||
        io_word_is(word, length, "Dimension", 0))
        return read_header(r, word, length, cursor);
    const medit_keyword *k = medit_find_name(word, length);
    if (!k) {
        io_skip_numbers(cursor);
        return PLANISH_OK;
    }
    int status = medit_check_keyword(r, word, k);
    return status ? status : read_section(r, k, cursor);
}

int medit_text_walk(medit_reader *r) {
    io_cursor cursor = io_begin_text(r->model->input.data, r->model->input.size);
    int status = PLANISH_OK, done = 0;
    io_skip_numbers(&cursor);
    while (!status && !done && cursor.at < cursor.end)
        status = walk_keyword(r, &cursor, &done);
    if (!status && !r->version)
        return io_fail_at(r->model, cursor.end, r->error,
                          "no MeshVersionFormatted: this is no Medit mesh");
    /* Vertices may stand before the dimension, which says how long they are. */
    for (int64_t i = 0; i < r->n_sections && !status; i++)
        status = check_count(r, r->sections[i].keyword, r->sections[i].count, r->sections[i].data);
    return status;
}
