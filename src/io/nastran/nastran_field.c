/* nastran_field: where the coordinates of a GRID stand, and what may take their place. */
#include "io/nastran/nastran.h"

#include "io/core/number.h"

/** Where the line that holds at begins. */
static const char *line_of(const io_model *model, const char *at) {
    const char *data = io_begin_text(model->input.data, model->input.size).at;
    while (at > data && at[-1] != '\n' && at[-1] != '\r')
        at--;
    return at;
}

static void field_of_columns(const card *c, int d, io_field *field) {
    static const char blanks[IO_LEAD_SIZE + 1] =
        "                                                                ";
    field->width = width_of(&c->line);
    field->is_fixed = 1;
    if (nastran_has_field(c))
        return;
    /* Coordinates before it in the line are written in full width. */
    const int64_t from = NAME_COLUMNS + c->n_of_line * field->width;
    const int follows = d > 0 && c->n_of_line > 0;
    field->lead = blanks;
    field->n_lead = follows ? 0 : (int)(from - (c->line.text.end - c->line.text.begin));
}

/** absent: fields of the line that are not there before this one. */
static void field_of_commas(const io_model *model, const card *c, int d, int absent,
                            io_field *field) {
    const span text = nastran_trim((span){field->begin, field->end});
    field->begin = text.begin;
    field->end = text.end;
    field->width = model->field_width;
    if (nastran_has_field(c))
        return;
    field->lead = ",,,";
    field->n_lead = d == 0 ? absent + 1 : 1;
}

/** The mark in the last columns of a line, without the + or * that it may begin with. */
static span mark_of(span whole) {
    const span text = {whole.begin,
                       find_character(leading_part(whole, LAST_COLUMN + SHORT_FIELD), '$')};
    if (text.end - text.begin <= LAST_COLUMN)
        return (span){text.end, text.end};
    const span mark = nastran_trim((span){text.begin + LAST_COLUMN, text.end});
    const int is_signed = !is_empty_field(mark) && (*mark.begin == '+' || *mark.begin == '*');
    return leading_part(nastran_trim((span){mark.begin + is_signed, mark.end}), NAME_COLUMNS - 1);
}

/** The third coordinate of a long GRID is in the next line; where there is none, it is made: behind
 *  a line end as the file has them, with the mark of the line before. */
static void field_of_next_line(const card *c, io_field *field) {
    enum { LINE_END = 2 }; /* characters of one, at most */
    io_cursor from = {c->line.text.begin, c->rest.end};
    span whole = {c->line.text.begin, NULL};
    io_line(&from, &whole.end);
    const span mark = mark_of(whole);
    char *to = field->made;
    for (int i = 0; i < LINE_END && whole.end + i < from.at; i++)
        *to++ = whole.end[i];
    *to++ = '*';
    if (c->line.is_free)
        *to++ = ',';
    for (int i = 0; i < NAME_COLUMNS - 1 && !c->line.is_free; i++)
        *to++ = i < mark.end - mark.begin ? mark.begin[i] : ' ';
    field->begin = field->end = whole.end;
    field->width = LONG_FIELD;
    field->is_fixed = !c->line.is_free;
    field->lead = field->made;
    field->n_lead = (int)(to - field->made);
}

int nastran_field(const io_model *model, io_cursor *cursor, int d, io_field *field) {
    io_cursor from = {line_of(model, cursor->at), cursor->end};
    card c;
    span skipped;
    int absent = 0;
    *field = (io_field){.width = 0};
    if (!nastran_take_card(&from, &c))
        return -1;
    for (int i = 0; i < FIRST_COORDINATE + d; i++) {
        absent += !nastran_has_field(&c);
        nastran_take_field(&c, &skipped);
    }
    if (c.n_of_line == fields_of(&c.line) && !nastran_continue_card(&c)) {
        field_of_next_line(&c, field);
        cursor->at = field->end;
        return 0;
    }
    const span text = nastran_line_field(&c), number = nastran_trim(text);
    field->begin = text.begin;
    field->end = text.end;
    if (c.line.is_free)
        field_of_commas(model, &c, d, absent, field);
    else
        field_of_columns(&c, d, field);
    cursor->at = field->end;
    return is_empty_field(number) ? 0
                                  : io_parse_packed_real(number.begin, number.end, &field->value);
}
