/* nastran_card: lines, cards and fields of bulk data; where the coordinates of a GRID stand, and
 * what may take their place. */
#include "io/nastran/nastran_card.h"

enum {
    LONG_FIELDS = 4,  /* two such lines are a row */
    LAST_COLUMN = 72, /* behind it stands the mark of the continuation */
    COMMA_BEFORE = 10 /* a line with a comma in its first columns is of free fields */
};

/** Return width bytes of a line from a column on, or those of them that there are. */
static io_slice columns(io_slice s, int64_t from, int64_t width) {
    const int64_t length = io_slice_length(s), to = from + width;
    return (io_slice){s.begin + (from < length ? from : length),
                      s.begin + (to < length ? to : length)};
}

/* ---- lines -------------------------------------------------------------------------------- */

nastran_line nastran_take_line(io_cursor *cursor) {
    nastran_line l = {.text = io_next_line(cursor)};
    l.text.end = io_slice_find(l.text, '$');
    const io_slice start = columns(l.text, 0, COMMA_BEFORE);
    const char *comma = io_slice_find(start, ',');
    l.is_free = comma < start.end;
    l.name = l.is_free ? (io_slice){l.text.begin, comma} : columns(l.text, 0, NASTRAN_NAME_COLUMNS);
    l.is_long = io_slice_find(l.name, '*') < l.name.end;
    l.n_fields = l.is_long ? LONG_FIELDS : NASTRAN_SHORT_FIELDS;
    l.width = l.is_long ? NASTRAN_LONG_FIELD : NASTRAN_SHORT_FIELD;
    if (!l.is_free)
        l.text = columns(l.text, 0, LAST_COLUMN);
    return l;
}

/** Return whether the line goes on with the card before it. */
static int is_continuation(const nastran_line *l) {
    const char first = *l->text.begin;
    return first == '+' || first == '*' || first == ',' || io_is_blank(first);
}

int nastran_line_begins(io_slice text, const char *name) {
    const io_slice s = io_slice_trim(text);
    const int64_t length = (int64_t)strlen(name);
    for (int64_t i = 0; i < length; i++)
        if (s.begin + i >= s.end || io_upper(s.begin[i]) != name[i])
            return 0;
    return s.begin + length == s.end || io_is_blank(s.begin[length]);
}

/* ---- cards -------------------------------------------------------------------------------- */

static void set_wrong(nastran_card *c, const char *at, const char *what) {
    if (c->wrong)
        return;
    c->wrong = what;
    c->wrong_at = at;
}

static void enter_line(nastran_card *c, nastran_line l) {
    if (!l.is_free && io_slice_find(l.text, '\t') < l.text.end)
        set_wrong(
            c, l.text.begin,
            "a tab among fields of fixed columns; write tabs that part fields as commas "
            "(tr '\\t' , <IN >OUT), or those that fill columns as blanks (expand -t 8 IN >OUT)");
    c->line = l;
    c->at = l.is_free ? l.name.end + 1 : NULL;
    c->n_of_line = 0;
}

void nastran_take_name(io_slice s, char name[NASTRAN_NAME_SIZE]) {
    int n = 0;
    for (const char *at = s.begin; at < s.end && n < NASTRAN_NAME_COLUMNS; at++) {
        if (io_is_blank(*at) || *at == '*' || *at == ',')
            break;
        name[n++] = io_upper(*at);
    }
    name[n] = '\0';
}

int nastran_take_card(io_cursor *cursor, nastran_card *c) {
    const nastran_line l = nastran_take_line(cursor);
    if (l.text.begin == l.text.end || is_continuation(&l))
        return 0;
    nastran_take_name(l.name, c->name);
    c->n = 0;
    c->wrong = c->wrong_at = NULL;
    c->rest = *cursor;
    enter_line(c, l);
    return 1;
}

io_slice nastran_line_field(const nastran_card *c) {
    const io_slice text = c->line.text;
    if (c->line.is_free)
        return c->at ? (io_slice){c->at, io_slice_find((io_slice){c->at, text.end}, ',')}
                     : (io_slice){text.end, text.end};
    return columns(text, NASTRAN_NAME_COLUMNS + c->n_of_line * c->line.width, c->line.width);
}

/** Go to the line that the card goes on with; return 0 if there is none. */
static int continue_card(nastran_card *c) {
    /* Behind the last field of a free line stands the mark of the continuation: no number. */
    while (c->line.is_free && c->at) {
        const io_slice text = nastran_line_field(c), field = io_slice_trim(text);
        double value;
        if (field.begin < field.end && *field.begin != '+' && *field.begin != '*' &&
            !io_slice_real(field, 1, &value))
            set_wrong(c, field.begin,
                      c->line.is_long ? "a number behind the four fields of a long line"
                                      : "a number behind the eight fields of a line");
        c->at = text.end < c->line.text.end ? text.end + 1 : NULL;
    }
    io_cursor cursor = c->rest;
    nastran_line l;
    do { /* over lines that say nothing */
        if (cursor.at == cursor.end)
            return 0;
        l = nastran_take_line(&cursor);
    } while (io_slice_length(io_slice_trim(l.text)) == 0);
    if (!is_continuation(&l))
        return 0;
    c->rest = cursor;
    enter_line(c, l);
    return 1;
}

int nastran_take_field(nastran_card *c, io_slice *field) {
    if (c->n_of_line == c->line.n_fields && !continue_card(c))
        return 0;
    const io_slice text = nastran_line_field(c), s = io_slice_trim(text);
    /* = and == stand for the fields of the card before, *(1) for the number that follows there. */
    if (s.begin < s.end &&
        (*s.begin == '=' || (*s.begin == '*' && io_slice_length(s) > 1 && s.begin[1] == '(')))
        set_wrong(c, s.begin, nastran_no_replication);
    if (c->at)
        c->at = text.end < c->line.text.end ? text.end + 1 : NULL;
    c->n_of_line++;
    c->n++;
    *field = s;
    return 1;
}

/* ---- places of coordinates ------------------------------------------------------------------ */

/** Return whether the line has the next field, be it empty. */
static int has_field(const nastran_card *c) {
    const int64_t length = io_slice_length(c->line.text);
    return c->line.is_free ? c->at != NULL
                           : length > NASTRAN_NAME_COLUMNS + c->n_of_line * c->line.width;
}

/** Make the field of the third coordinate of a long GRID, which is in the next line, where there is
 *  none: behind a line end as the file has them, with the mark of the line before. */
static void field_of_next_line(const nastran_card *c, io_field *field) {
    enum { LINE_END = 2 }; /* characters of one, at most */
    io_cursor from = {c->line.text.begin, c->rest.end};
    const io_slice whole = io_next_line(&from);
    /* The mark stands in the last columns, behind a + or * perhaps, which it is kept without. */
    io_slice mark = columns(whole, 0, LAST_COLUMN + NASTRAN_SHORT_FIELD);
    mark.end = io_slice_find(mark, '$');
    mark.begin = io_slice_length(mark) > LAST_COLUMN ? mark.begin + LAST_COLUMN : mark.end;
    mark = io_slice_trim(mark);
    mark.begin += mark.begin < mark.end && (*mark.begin == '+' || *mark.begin == '*');
    mark = io_slice_trim(mark);
    char *to = field->made;
    for (int i = 0; i < LINE_END && whole.end + i < from.at; i++)
        *to++ = whole.end[i];
    *to++ = '*';
    if (c->line.is_free)
        *to++ = ',';
    for (int i = 0; i < NASTRAN_NAME_COLUMNS - 1 && !c->line.is_free; i++)
        *to++ = i < mark.end - mark.begin ? mark.begin[i] : ' ';
    field->begin = field->end = whole.end;
    field->width = NASTRAN_LONG_FIELD;
    field->is_fixed = !c->line.is_free;
    field->lead = field->made;
    field->n_lead = (int)(to - field->made);
}

int nastran_field(const io_model *model, io_cursor *cursor, int d, io_field *field) {
    static const char blanks[IO_LEAD_SIZE + 1] =
        "                                                                ";
    io_cursor from = io_begin_text(model->input.data, model->input.size);
    const char *data = from.at; /* back to where the line begins */
    for (from = *cursor; from.at > data && from.at[-1] != '\n' && from.at[-1] != '\r';)
        from.at--;
    nastran_card c;
    io_slice skipped;
    int absent = 0; /* fields that the line does not have before this one */
    *field = (io_field){.width = 0};
    if (!nastran_take_card(&from, &c))
        return -1;
    for (int i = 0; i < NASTRAN_FIRST_COORDINATE + d; i++) {
        absent += !has_field(&c);
        nastran_take_field(&c, &skipped);
    }
    if (c.n_of_line == c.line.n_fields && !continue_card(&c)) {
        field_of_next_line(&c, field);
        cursor->at = field->end;
        return 0;
    }
    const io_slice text = nastran_line_field(&c), number = io_slice_trim(text);
    if (c.line.is_free) {
        *field = (io_field){.begin = number.begin, .end = number.end, .width = model->field_width};
        if (!has_field(&c)) {
            field->lead = ",,,";
            field->n_lead = d == 0 ? absent + 1 : 1;
        }
    } else {
        *field =
            (io_field){.begin = text.begin, .end = text.end, .width = c.line.width, .is_fixed = 1};
        if (!has_field(&c)) {
            /* Coordinates before it in the line are written in full width. */
            const int64_t column = NASTRAN_NAME_COLUMNS + c.n_of_line * field->width;
            const int follows = d > 0 && c.n_of_line > 0;
            field->lead = blanks;
            field->n_lead = follows ? 0 : (int)(column - io_slice_length(c.line.text));
        }
    }
    cursor->at = field->end;
    return number.begin == number.end ? 0 : io_slice_real(number, 1, &field->value);
}
