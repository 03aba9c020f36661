/* foam_list: lists of numbers: text, or binary in a row. */
#include "io/foam/foam_list.h"

#include "base/memory.h"
#include "base/round.h"
#include "base/status.h"

#include <string.h>

/* ---- begin and end -------------------------------------------------------------------------- */

static int64_t smaller(int64_t a, int64_t b) {
    return a < b ? a : b;
}

/** Take the number of things; words such as List<label> before it do not matter. */
static int take_count(foam_file *f, const char *what, int64_t *n, planish_error *error) {
    const io_model *view = &f->of.view;
    io_cursor before = f->cursor;
    if (io_slice_is(foam_word(&before), "List<label>", 0))
        f->cursor = before;
    foam_skip(&f->cursor);
    const char *at = f->cursor.at;
    if (io_parse_integer(&f->cursor.at, f->cursor.end, n) || *n < 0) {
        const io_slice word = foam_word(&f->cursor);
        const int status = foam_check_word(f, word, error);
        return status ? status
                      : io_fail_at(view, at, error,
                                   "the number of %s expected (the file may be cut short)", what);
    }
    return PLANISH_OK;
}

int foam_begin_list(foam_file *f, const char *what, int64_t size, int64_t *n,
                    planish_error *error) {
    io_model *view = &f->of.view;
    int status = take_count(f, what, n, error);
    if (!status)
        status = io_check_count(view, f->cursor, *n, size, what, error);
    if (status)
        return status;
    io_cursor before = f->cursor;
    if (*n == 0) { /* binary lists may end with the number */
        if (io_slice_is(foam_word(&before), "(", 0)) {
            f->cursor = before;
            return foam_expect(f, ")", error);
        }
        return PLANISH_OK;
    }
    return foam_expect(f, "(", error);
}

int foam_end_list(foam_file *f, const char *what, planish_error *error) {
    foam_skip(&f->cursor);
    if (f->cursor.at < f->cursor.end && *f->cursor.at == ')') {
        f->cursor.at++;
        return PLANISH_OK;
    }
    return io_fail_at(
        &f->of.view, f->cursor.at, error,
        "')' expected behind the last of the %s: the number of these, or (binary) arch in "
        "the header, is wrong",
        what);
}

/** Return whether a binary list may end behind so many bytes. */
static int may_end(const foam_file *f, int64_t bytes) {
    const char *at = f->cursor.at, *end = f->cursor.end;
    return bytes < end - at && at[bytes] == ')' &&
           (bytes + 1 == end - at || io_is_space(at[bytes + 1]) || at[bytes + 1] == ';' ||
            at[bytes + 1] == ')');
}

/** Choose the size of n numbers of a binary list where the header does not say it: the usual one, unless
 *  the list can only end by the other one. Check that all are there. */
static int choose_size(const foam_file *f, const char *what, int64_t n, int is_known, int other,
                       int *size, planish_error *error) {
    if (!is_known && !may_end(f, n * *size) && may_end(f, n * other))
        *size = other;
    return io_check_room(&f->of.view, f->cursor, n, *size, what, error);
}

/* ---- labels --------------------------------------------------------------------------------- */

typedef struct label_records {
    const foam_file *f;
    const char *what;
    int64_t first, last;
    int32_t *label;
} label_records;

/** Return whether a number ends at the cursor. */
static int ends_here(const io_cursor *cursor) {
    return cursor->at == cursor->end || io_is_space(*cursor->at) || *cursor->at == ')' ||
           *cursor->at == '}' || *cursor->at == '/';
}

/** Take a label in text or binary. */
static inline int take_label(const label_records *r, io_cursor *cursor, int64_t i, int64_t *value,
                             planish_error *error) {
    const foam_file *f = r->f;
    if (!f->of.view.is_binary)
        foam_skip_few(cursor);
    const char *at = cursor->at;
    const int failed = f->of.view.is_binary ? io_number(cursor, f->label_size, f->swapped, value)
                                            : foam_integer(cursor, value) || !ends_here(cursor);
    if (!failed && *value >= r->first && *value <= r->last)
        return PLANISH_OK;
    if (failed)
        return io_fail_at(&f->of.view, at, error, "%s: whole number %lld expected (from 0)",
                          r->what, (long long)i);
    return io_fail_at(&f->of.view, at, error,
                      "%s: number %lld (from 0) is %lld, not in %lld .. %lld", r->what,
                      (long long)i, (long long)*value, (long long)r->first, (long long)r->last);
}

/** Read labels as they lie in memory, in whole blocks, up to the first block with a label that is out of
 *  range. Return where. */
static int64_t copy_labels(const label_records *r, io_cursor *cursor, int64_t begin, int64_t end) {
    enum { BLOCK = 256 }; /* compilers vectorise a loop over a known number */
    const int32_t first = (int32_t)r->first, last = (int32_t)r->last;
    for (; end - begin >= BLOCK; begin += BLOCK) {
        int32_t *label = r->label + begin;
        int is_outside = 0;
        memcpy(label, cursor->at, BLOCK * sizeof *label);
        for (int i = 0; i < BLOCK; i++)
            is_outside |= (label[i] < first) | (label[i] > last);
        if (is_outside)
            return begin;
        cursor->at += BLOCK * sizeof *label;
    }
    return begin;
}

static int read_labels(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                       planish_error *error) {
    const label_records *r = context;
    const foam_file *f = r->f;
    if (f->of.view.is_binary && f->label_size == sizeof(int32_t) && !f->swapped)
        begin = copy_labels(r, cursor, begin, end);
    for (int64_t i = begin; i < end; i++) {
        int64_t value;
        const int status = take_label(r, cursor, i, &value, error);
        if (status)
            return status;
        r->label[i] = (int32_t)value;
    }
    return PLANISH_OK;
}

/** Read labels behind the number of a list that says one for all: {v}. */
static int read_equal_labels(label_records *r, foam_file *f, int64_t n, planish_error *error) {
    int64_t value = 0;
    const int is_binary = f->of.view.is_binary;
    int status = foam_expect(f, "{", error);
    if (!status)
        status = take_label(r, &f->cursor, 0, &value, error);
    if (!status)
        status = foam_expect(f, "}", error);
    f->of.view.is_binary = is_binary;
    for (int64_t i = 0; i < n && !status; i++)
        r->label[i] = (int32_t)value;
    return status;
}

/** Read a list of labels; is_set: of equal ones, one is enough. */
static int read_list(foam_file *f, const char *what, int64_t first, int64_t last, int is_set,
                     int32_t **labels, int64_t *n, planish_error *error) {
    enum { MOST_EQUAL = 1 << 16 }; /* of one number for all, which no byte of the file bounds */
    io_model *view = &f->of.view;
    label_records r = {f, what, first, smaller(last, INT32_MAX), NULL};
    foam_file ahead = *f;
    int64_t count = 0;
    *labels = NULL;
    int is_equal = !take_count(&ahead, what, &count, NULL);
    const io_cursor behind = ahead.cursor;
    is_equal = is_equal && io_slice_is(foam_word(&ahead.cursor), "{", 0);
    if (is_equal && count > MOST_EQUAL)
        return io_fail_at(view, f->cursor.at, error, "%s: %lld equal numbers are too many", what,
                          (long long)count);
    int status = PLANISH_OK;
    if (is_equal) {
        f->cursor = behind;
        *n = is_set && count > 1 ? 1 : count;
    } else {
        status = foam_begin_list(f, what, view->is_binary ? f->label_size : 2, n, error);
        if (!status && view->is_binary && *n > 0)
            status = choose_size(f, what, *n, f->is_label_known, 8, &f->label_size, error);
    }
    if (status)
        return status;
    r.label = *labels = pl_alloc(*n, sizeof *r.label);
    if (!r.label)
        return pl_fail_memory(error, what);
    if (is_equal)
        return read_equal_labels(&r, f, *n, error);
    if (*n == 0)
        return PLANISH_OK;
    io_text text;
    io_text_init(&text, view);
    if (!view->is_binary)
        foam_skip(&f->cursor);
    status = io_records(&text, &f->cursor, *n, 1, f->label_size, read_labels, &r, error);
    io_text_release(&text);
    return status ? status : foam_end_list(f, what, error);
}

int foam_labels(foam_file *f, const char *what, int64_t first, int64_t last, int32_t **labels,
                int64_t *n, planish_error *error) {
    return read_list(f, what, first, last, 0, labels, n, error);
}

int foam_label_set(foam_file *f, const char *what, int64_t first, int64_t last, int32_t **labels,
                   int64_t *n, planish_error *error) {
    return read_list(f, what, first, last, 1, labels, n, error);
}

/* ---- points --------------------------------------------------------------------------------- */

int foam_field(const io_model *model, io_cursor *cursor, int d, io_field *field) {
    (void)model;
    (void)d;
    *field = (io_field){.width = 0};
    foam_skip_few(cursor);
    field->begin = cursor->at;
    if (io_parse_real(&cursor->at, cursor->end, &field->value) || !ends_here(cursor))
        return -1;
    field->end = cursor->at;
    return 0;
}

static int fail_point(const io_model *model, const char *at, int64_t node, planish_error *error) {
    return io_fail_at(model, at, error, "point %lld: (x y z) expected (the file may be cut short)",
                      (long long)node);
}

/** Read points of text. */
static int read_points(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                       planish_error *error) {
    io_model *model = context;
    const int is_float = model->precision == PLANISH_PRECISION_FLOAT;
    for (int64_t node = begin; node < end; node++) {
        foam_skip_few(cursor);
        if (cursor->at == cursor->end || *cursor->at != '(')
            return fail_point(model, cursor->at, node, error);
        cursor->at++;
        foam_skip_few(cursor);
        model->text_offset[node] = cursor->at - model->input.data;
        for (int d = 0; d < 3; d++) {
            io_field field;
            if (foam_field(model, cursor, d, &field))
                return fail_point(model, cursor->at, node, error);
            const double value = is_float ? pl_round_to_float(field.value) : field.value;
            const int status = io_check_finite(model, value, node, field.begin, error);
            if (status)
                return status;
            model->xyz[3 * node + d] = value;
        }
        foam_skip_few(cursor);
        if (cursor->at == cursor->end || *cursor->at != ')')
            return fail_point(model, cursor->at, node, error);
        cursor->at++;
    }
    return PLANISH_OK;
}

int foam_read_points(io_model *model, planish_error *error) {
    enum { SHORTEST = 7 }; /* (0 0 0) */
    foam_file f = {.of.view = {.input = model->input, .threads = io_model_threads(model)}};
    int64_t n = 0;
    int status = foam_read_header(&f, error);
    model->is_binary = f.of.view.is_binary;
    const int least = f.is_scalar_known ? 3 * f.scalar_size : 3 * (int)sizeof(float);
    int size = 3 * f.scalar_size;
    if (!status)
        status = foam_begin_list(&f, "points", model->is_binary ? least : SHORTEST, &n, error);
    if (!status && model->is_binary && n > 0) {
        status = choose_size(&f, "points", n, f.is_scalar_known, least, &size, error);
        f.scalar_size = size / 3;
    }
    if (!status && n == 0)
        status = io_fail_at(model, f.cursor.at, error, "there are no points");
    if (!status)
        status = io_model_make_nodes(model, n, f.scalar_size, size, f.swapped, f.cursor.at, error);
    if (status)
        return status;
    io_text text;
    io_text_init(&text, model);
    io_node_records points = {.model = model, .size = f.scalar_size, .swapped = f.swapped};
    if (!model->is_binary)
        foam_skip(&f.cursor);
    status = model->is_binary ? io_binary_records(io_model_threads(model), &f.cursor, n, size,
                                                  io_read_nodes, &points, error)
                              : io_text_records(&text, &f.cursor, n, 3, read_points, model, error);
    io_text_release(&text);
    return status ? status : foam_end_list(&f, "points", error);
}

/* ---- entries ------------------------------------------------------------------------------- */

int foam_begin_entries(foam_file *f, const char *what, int64_t *n, planish_error *error) {
    io_cursor ahead = f->cursor;
    *n = -1;
    if (!io_slice_is(foam_word(&ahead), "(", 0))
        return foam_begin_list(f, what, 1, n, error);
    f->cursor = ahead;
    return PLANISH_OK;
}

int foam_next_entry(foam_file *f, const char *what, int64_t n, int64_t i, io_slice *name,
                    planish_error *error) {
    if (n == 0) /* its parentheses have been taken, if it has any */
        return 0;
    *name = foam_word(&f->cursor);
    if (io_slice_is(*name, ")", 0) && (n < 0 || i == n))
        return 0;
    if (i == n || io_slice_length(*name) == 0 || io_slice_is(*name, ")", 0))
        return io_fail_at(&f->of.view, name->begin, error,
                          i == n ? "')' expected behind the last of the %s"
                                 : "one more of the %s expected (the file may be cut short)",
                          what);
    const int status = foam_check_word(f, *name, error);
    return status ? status : 1;
}
