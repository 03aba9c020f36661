/* digits: how exact coordinates are, by the digits that a file gives them. */
#include "io/file/digits.h"

#include "io/core/text.h"

/* Single-precision coordinates have 24 bits: of a plane nodes may be off by so much of the size. */
#define FLOAT_TOLERANCE    1e-6
#define SMALLEST_TOLERANCE 1e-8
#define LARGEST_TOLERANCE  1e-5

/** Digits of the number that begins at text, but for leading zeros. */
static int significant_digits(const char *text, const char *end) {
    int digits = 0;
    for (; text < end && (*text == '+' || *text == '-'); text++)
        ;
    for (; text < end && ((*text >= '0' && *text <= '9') || *text == '.'); text++)
        digits += *text != '.' && (digits > 0 || *text != '0');
    return digits;
}

/** Those of coordinate d of a node, at which the cursor stands, as in io_format.field. */
static int digits_of_coordinate(const io_model *model, const io_format *format, io_cursor *cursor,
                                int d) {
    io_field field;
    if (format->field) {
        if (format->field(model, cursor, d, &field))
            return 0;
        while (field.begin < field.end && *field.begin == ' ')
            field.begin++;
        return significant_digits(field.begin, field.end);
    }
    io_skip_space(cursor);
    const int digits = significant_digits(cursor->at, cursor->end);
    while (cursor->at < cursor->end && (unsigned char)*cursor->at > ' ')
        cursor->at++;
    return digits;
}

/** The digits of the longest coordinate of a node that stands as text. */
static int digits_of_node(const io_model *model, const io_format *format, int64_t node) {
    io_cursor cursor = {model->input.data + model->text_offset[node],
                        model->input.data + model->input.size};
    int most = 0;
    for (int d = 0; d < model->columns; d++) {
        const int digits = digits_of_coordinate(model, format, &cursor, d);
        most = digits > most ? digits : most;
    }
    return most;
}

/** How many digits the writer of the file gave numbers. Most tells, but where some nodes have few,
 *  others all that a double has: the latter have been moved since, by a smoother, say. */
static int digits_of_file(const io_model *model, const io_format *format) {
    enum { LOOKED_AT_NODES = 4096, SOME = 100, SHORT = 4, LONG = 12 };
    int most = 0, most_of_few = 0;
    int64_t n = 0, n_few = 0;
    for (int64_t i = 0; i < model->n_spans; i++) {
        const io_span *span = &model->span[i];
        if (span->encoding != IO_TEXT)
            continue;
        for (int64_t k = 0; k < span->n_nodes && n < LOOKED_AT_NODES; k++, n++) {
            const int digits = digits_of_node(model, format, span->first_node + k);
            most = digits > most ? digits : most;
            if (digits > SHORT && digits <= LONG) {
                most_of_few = digits > most_of_few ? digits : most_of_few;
                n_few++;
            }
        }
    }
    return n_few * SOME >= n ? most_of_few : most;
}

/* Whole numbers and the like may be exact with few digits, so that there is a limit. */
double io_tolerance_of_digits(const io_model *model, const io_format *format) {
    if (model->precision == PLANISH_FLOAT)
        return FLOAT_TOLERANCE;
    const int most = digits_of_file(model, format);
    if (most == 0)
        return 0; /* the library's own */
    double tolerance = 10;
    for (int d = 0; d < most; d++)
        tolerance /= 10;
    return tolerance > LARGEST_TOLERANCE    ? LARGEST_TOLERANCE
           : tolerance < SMALLEST_TOLERANCE ? 0
                                            : tolerance;
}
