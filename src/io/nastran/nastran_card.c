/* nastran_card: lines, cards and fields of bulk data. */
#include "io/nastran/nastran.h"

#include "io/core/number.h"

/* ---- lines -------------------------------------------------------------------------------- */

line nastran_take_line(io_cursor *cursor) {
    line l = {.is_free = 0};
    l.text.begin = io_line(cursor, &l.text.end);
    l.text.end = find_character(l.text, '$');
    const span start = leading_part(l.text, COMMA_BEFORE);
    const char *comma = find_character(start, ',');
    l.is_free = comma < start.end;
    l.name = l.is_free ? (span){l.text.begin, comma} : leading_part(l.text, NAME_COLUMNS);
    l.is_long = find_character(l.name, '*') < l.name.end;
    if (!l.is_free)
        l.text = leading_part(l.text, LAST_COLUMN);
    return l;
}

static int says_nothing(const line *l) {
    const span s = nastran_trim(l->text);
    return s.begin == s.end;
}

/** Whether the line goes on with the card before it. */
static int is_continuation(const line *l) {
    const char first = *l->text.begin;
    return first == '+' || first == '*' || first == ',' || io_is_blank(first);
}

/* ---- cards -------------------------------------------------------------------------------- */

static void set_wrong(card *c, const char *at, const char *what) {
    if (c->wrong)
        return;
    c->wrong = what;
    c->wrong_at = at;
}

static void enter_line(card *c, line l) {
    if (!l.is_free && find_character(l.text, '\t') < l.text.end)
        set_wrong(
            c, l.text.begin,
            "a tab among fields of fixed columns; write tabs that part fields as commas "
            "(tr '\\t' , <IN >OUT), or those that fill columns as blanks (expand -t 8 IN >OUT)");
    c->line = l;
    c->at = l.is_free ? l.name.end + 1 : NULL;
    c->n_of_line = 0;
}

int nastran_take_card(io_cursor *cursor, card *c) {
    const line l = nastran_take_line(cursor);
    if (l.text.begin == l.text.end || is_continuation(&l))
        return 0;
    int n = 0;
    for (const char *at = l.name.begin; at < l.name.end && n < NAME_COLUMNS; at++) {
        if (io_is_blank(*at) || *at == '*')
            break;
        c->name[n++] = io_upper(*at);
    }
    c->name[n] = '\0';
    c->n = 0;
    c->wrong = c->wrong_at = NULL;
    c->rest = *cursor;
    enter_line(c, l);
    return 1;
}

/** Behind the last field of a free line stands the mark of the continuation, which is no number. */
static void check_end_of_line(card *c) {
    while (c->line.is_free && c->at) {
        const span text = nastran_line_field(c), field = nastran_trim(text);
        double value;
        if (!is_empty_field(field) && *field.begin != '+' && *field.begin != '*' &&
            !io_parse_packed_real(field.begin, field.end, &value))
            set_wrong(c, field.begin,
                      c->line.is_long ? "a number behind the four fields of a long line"
                                      : "a number behind the eight fields of a line");
        c->at = text.end < c->line.text.end ? text.end + 1 : NULL;
    }
}

/** To the next line, if it goes on with the card. */
int nastran_continue_card(card *c) {
    check_end_of_line(c);
    io_cursor cursor = c->rest;
    line l;
    do {
        if (cursor.at == cursor.end)
            return 0;
        l = nastran_take_line(&cursor);
    } while (says_nothing(&l));
    if (!is_continuation(&l))
        return 0;
    c->rest = cursor;
    enter_line(c, l);
    return 1;
}

/** The next field of the line with the blanks around it; where the line ends before, the line's
 *  end. */
span nastran_line_field(const card *c) {
    const span text = c->line.text;
    if (c->line.is_free)
        return c->at ? (span){c->at, find_character((span){c->at, text.end}, ',')}
                     : (span){text.end, text.end};
    const int64_t length = text.end - text.begin;
    const int64_t from = NAME_COLUMNS + c->n_of_line * width_of(&c->line);
    const int64_t to = from + width_of(&c->line);
    return (span){text.begin + (from < length ? from : length),
                  text.begin + (to < length ? to : length)};
}

/** Whether the line has the next field, be it empty. */
int nastran_has_field(const card *c) {
    const span text = c->line.text;
    return c->line.is_free
               ? c->at != NULL
               : text.end - text.begin > NAME_COLUMNS + c->n_of_line * width_of(&c->line);
}

static void pass_field(card *c) {
    if (c->at) {
        const char *end = nastran_line_field(c).end;
        c->at = end < c->line.text.end ? end + 1 : NULL;
    }
    c->n_of_line++;
    c->n++;
}

/** = and == stand for the fields of the card before, *(1) for the number that follows there. */
static int is_replication(span field) {
    return *field.begin == '=' ||
           (*field.begin == '*' && field.end - field.begin > 1 && field.begin[1] == '(');
}

/** The card's next field without blanks; 0 where the card ends. */
int nastran_take_field(card *c, span *field) {
    if (c->n_of_line == fields_of(&c->line) && !nastran_continue_card(c))
        return 0;
    *field = nastran_trim(nastran_line_field(c));
    if (!is_empty_field(*field) && is_replication(*field))
        set_wrong(c, field->begin,
                  "replication of the card before (=, *(1)) is not read; have the preprocessor "
                  "write every card in full");
    pass_field(c);
    return 1;
}

/* ---- where bulk data are ------------------------------------------------------------------ */

/** Whether the text begins with that word, in any letter case. */
int nastran_line_begins(span text, const char *name) {
    const span s = nastran_trim(text);
    const int64_t length = (int64_t)strlen(name);
    for (int64_t i = 0; i < length; i++)
        if (s.begin + i >= s.end || io_upper(s.begin[i]) != name[i])
            return 0;
    return s.begin + length == s.end || io_is_blank(s.begin[length]);
}

/** The next line that begins with word, or the end. *after: behind it. */
static const char *find_line(io_cursor cursor, const char *word, const char **after) {
    while (cursor.at < cursor.end) {
        span text;
        text.begin = io_line(&cursor, &text.end);
        *after = cursor.at;
        if (text.begin < text.end && (io_upper(*text.begin) == *word || io_is_blank(*text.begin)) &&
            nastran_line_begins(text, word))
            return text.begin;
    }
    return *after = cursor.end;
}

/** The lines between BEGIN BULK, if there is one, and ENDDATA. */
io_cursor nastran_find_bulk(const char *data, int64_t size) {
    io_cursor bulk = io_begin_text(data, size);
    const char *after, *begin = find_line(bulk, "BEGIN", &after);
    if (begin < bulk.end)
        bulk.at = after;
    bulk.end = find_line(bulk, "ENDDATA", &after);
    return bulk;
}
