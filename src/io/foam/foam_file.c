/* foam_file: files of OpenFOAM's: their header, and the tokens of dictionaries. */
#include "io/foam/foam_file.h"

#include "io/core/number.h"

#include "base/status.h"

#include <string.h>

/* ---- tokens --------------------------------------------------------------------------------- */

void foam_skip(io_cursor *cursor) {
    for (;;) {
        io_skip_space(cursor);
        if (cursor->end - cursor->at < 2 || *cursor->at != '/')
            return;
        if (cursor->at[1] == '/') {
            io_skip_line(cursor);
        } else if (cursor->at[1] == '*') {
            cursor->at += 2;
            while (cursor->end - cursor->at >= 2 && !(cursor->at[0] == '*' && cursor->at[1] == '/'))
                cursor->at++;
            cursor->at = cursor->end - cursor->at >= 2 ? cursor->at + 2 : cursor->end;
        } else {
            return;
        }
    }
}

static int is_mark(char c) {
    return c == ';' || c == '{' || c == '}' || c == '(' || c == ')';
}

io_slice foam_word(io_cursor *cursor) {
    foam_skip(cursor);
    io_slice word = {cursor->at, cursor->at};
    if (cursor->at == cursor->end)
        return word;
    if (*cursor->at == '"') {
        word.begin = ++cursor->at;
        while (cursor->at < cursor->end && *cursor->at != '"')
            cursor->at += *cursor->at == '\\' && cursor->end - cursor->at > 1 ? 2 : 1;
        word.end = cursor->at;
        cursor->at += cursor->at < cursor->end;
        return word;
    }
    if (is_mark(*cursor->at)) {
        word.end = ++cursor->at;
        return word;
    }
    /* A name may have parentheses in it, as of a function: div(phi,U). */
    int depth = 0;
    for (; cursor->at < cursor->end && !io_is_space(*cursor->at); cursor->at++) {
        const char c = *cursor->at;
        const int is_name = word.begin < cursor->at && (*word.begin < '0' || *word.begin > '9');
        if ((c == '(' && !is_name) || (c == ')' && depth == 0) ||
            (is_mark(c) && c != '(' && c != ')') || c == '"')
            break;
        depth += c == '(';
        depth -= c == ')';
    }
    word.end = cursor->at;
    return word;
}

int foam_expect(foam_file *f, const char *text, planish_error *error) {
    const io_slice word = foam_word(&f->cursor);
    if (io_slice_is(word, text, 0))
        return PLANISH_OK;
    return io_fail_at(&f->of.view, word.begin, error,
                      "'%s' expected, not '%.*s' (the file may be cut short)", text,
                      IO_QUOTED(word));
}

int foam_check_word(const foam_file *f, io_slice word, planish_error *error) {
    const char first = io_slice_length(word) > 0 ? *word.begin : '\0';
    if (first != '#' && first != '$')
        return PLANISH_OK;
    return io_fail_at(&f->of.view, word.begin, error,
                      "'%.*s': directives and macros are not read; write what they stand for",
                      IO_QUOTED(word));
}

int foam_skip_value(foam_file *f, planish_error *error) {
    int depth = 0, is_block = 0;
    for (int n = 0;; n++) {
        const io_slice word = foam_word(&f->cursor);
        const int status = foam_check_word(f, word, error);
        if (status)
            return status;
        if (word.begin == f->of.view.input.data + f->of.view.input.size)
            return io_fail_at(&f->of.view, word.begin, error,
                              "';' expected: the file is cut short");
        const char c = io_slice_length(word) == 1 ? *word.begin : ' ';
        is_block |= n == 0 && c == '{';
        depth += c == '(' || c == '{';
        depth -= c == ')' || c == '}';
        if (depth < 0)
            return io_fail_at(&f->of.view, word.begin, error, "';' expected before '%c'", c);
        if (depth == 0 && (c == ';' || (is_block && c == '}')))
            return PLANISH_OK;
    }
}

/* ---- the header ----------------------------------------------------------------------------- */

/** Find the number behind name= in what arch says; 0: it says nothing. */
static int64_t arch_number(io_slice arch, const char *name) {
    const int64_t length = (int64_t)strlen(name);
    for (const char *at = arch.begin; at + length < arch.end; at++)
        if (memcmp(at, name, (size_t)length) == 0) {
            int64_t bits;
            at += length;
            return io_parse_integer(&at, arch.end, &bits) ? -1 : bits;
        }
    return 0;
}

/** Take what the entry arch says: LSB;label=32;scalar=64. */
static int take_arch(foam_file *f, io_slice arch, planish_error *error) {
    const int64_t label = arch_number(arch, "label="), scalar = arch_number(arch, "scalar=");
    const int is_big = io_slice_length(arch) >= 3 && memcmp(arch.begin, "MSB", 3) == 0;
    f->swapped = is_big == io_machine_is_little();
    if ((label && label != 32 && label != 64) || (scalar && scalar != 32 && scalar != 64))
        return io_fail_at(&f->of.view, arch.begin, error,
                          "arch '%.*s': labels and scalars of 32 or 64 bits expected",
                          IO_QUOTED(arch));
    f->is_label_known |= label != 0;
    f->is_scalar_known |= scalar != 0;
    f->label_size = label ? (int)label / 8 : f->label_size;
    f->scalar_size = scalar ? (int)scalar / 8 : f->scalar_size;
    return PLANISH_OK;
}

/** Read an entry of the header, whose name is word. */
static int read_entry(foam_file *f, io_slice word, planish_error *error) {
    io_cursor value = f->cursor;
    const io_slice text = foam_word(&value);
    int status = foam_check_word(f, word, error);
    if (!status)
        status = foam_skip_value(f, error);
    if (status)
        return status;
    if (io_slice_is(word, "class", 0))
        f->class = text;
    if (io_slice_is(word, "arch", 0))
        return take_arch(f, text, error);
    if (!io_slice_is(word, "format", 0))
        return PLANISH_OK;
    f->of.view.is_binary = io_slice_is(text, "binary", 0);
    if (f->of.view.is_binary || io_slice_is(text, "ascii", 0))
        return PLANISH_OK;
    return io_fail_at(&f->of.view, text.begin, error, "format '%.*s': ascii or binary expected",
                      IO_QUOTED(text));
}

int foam_read_header(foam_file *f, planish_error *error) {
    io_model *view = &f->of.view;
    f->cursor = io_begin_text(view->input.data, view->input.size);
    f->swapped = !io_machine_is_little();
    f->label_size = 4;
    f->scalar_size = 8;
    io_slice word = foam_word(&f->cursor);
    if (!io_slice_is(word, "FoamFile", 0))
        return io_fail_at(view, word.begin, error,
                          "no FoamFile at its beginning: this is not a file of OpenFOAM");
    int status = foam_expect(f, "{", error);
    while (!status) {
        word = foam_word(&f->cursor);
        if (io_slice_is(word, "}", 0))
            return PLANISH_OK;
        if (io_slice_length(word) == 0)
            return io_fail_at(view, word.begin, error, "the header FoamFile is cut short");
        status = read_entry(f, word, error);
    }
    return status;
}

int foam_open(io_model *model, const char *name, int needed, foam_file *f, planish_error *error) {
    *f = (foam_file){.swapped = 0};
    const int status = io_folder_open(model, name, 1, needed, &f->of, error);
    return status || !f->of.view.input.data ? status : foam_read_header(f, error);
}

void foam_close(foam_file *f) {
    io_folder_close(&f->of);
}
