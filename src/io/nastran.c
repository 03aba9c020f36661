/* nastran: bulk data of Nastran and its like (OptiStruct's .fem), in fixed fields of 8 and of 16
 * columns and in free fields, mixed as they may be.
 *
 * The file is walked card by card: once to count the GRIDs and to meet what cannot be read, once
 * for the GRIDs, once for the elements (which may stand before their GRIDs). Cards that are none of
 * these are passed over.
 *
 * A number takes 8 or 16 characters, so that coordinates are rounded to the narrowest field that a
 * GRID of the file has before they are judged.
 */
#include "io/number.h"
#include "io/records.h"

#include "base/memory.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

enum {
    NAME_COLUMNS = 8,
    NAME_SIZE = NAME_COLUMNS + 1,
    SHORT_FIELD = 8,
    LONG_FIELD = 16,
    SHORT_FIELDS = 8,    /* of a line; it is a row, to which fields belong by their place */
    LONG_FIELDS = 4,     /* two such lines are a row */
    LAST_COLUMN = 72,    /* behind it stands the mark of the continuation */
    COMMA_BEFORE = 10,   /* a line with a comma in its first columns is of free fields */
    FIRST_COORDINATE = 2 /* field of a GRID, from 0: number, system, coordinates */
};

/* ---- lines -------------------------------------------------------------------------------- */

typedef struct span {
    const char *begin, *end;
} span;

/** A line of bulk data. */
typedef struct line {
    span text; /* before a comment and the continuation's mark */
    span name; /* its first field, with the star */
    int is_free, is_long;
} line;

static int is_blank(char c) {
    return c == ' ' || c == '\t';
}

static char upper(char c) {
    return c >= 'a' && c <= 'z' ? (char)(c - 'a' + 'A') : c;
}

static span trim(span s) {
    while (s.begin < s.end && is_blank(*s.begin))
        s.begin++;
    while (s.begin < s.end && is_blank(s.end[-1]))
        s.end--;
    return s;
}

/** The first place of what, or the end. */
static const char *find(span s, char what) {
    const char *found = s.begin < s.end ? memchr(s.begin, what, (size_t)(s.end - s.begin)) : NULL;
    return found ? found : s.end;
}

/** At most the first n bytes. */
static span head(span s, int64_t n) {
    return s.end - s.begin > n ? (span){s.begin, s.begin + n} : s;
}

static line take_line(io_cursor *cursor) {
    line l = {.is_free = 0};
    l.text.begin = io_line(cursor, &l.text.end);
    l.text.end = find(l.text, '$');
    const span start = head(l.text, COMMA_BEFORE);
    const char *comma = find(start, ',');
    l.is_free = comma < start.end;
    l.name = l.is_free ? (span){l.text.begin, comma} : head(l.text, NAME_COLUMNS);
    l.is_long = find(l.name, '*') < l.name.end;
    if (!l.is_free)
        l.text = head(l.text, LAST_COLUMN);
    return l;
}

static int says_nothing(const line *l) {
    const span s = trim(l->text);
    return s.begin == s.end;
}

/** Whether the line goes on with the card before it. */
static int is_continuation(const line *l) {
    const char first = *l->text.begin;
    return first == '+' || first == '*' || first == ',' || is_blank(first);
}

/* ---- cards -------------------------------------------------------------------------------- */

/** A card while its fields are taken one after the other. They are numbered from 0, the one behind
 *  the name. */
typedef struct card {
    io_cursor rest; /* the lines behind the current one */
    line line;
    const char *at;       /* free: where the next field begins, or NULL: the line has no more */
    int n_of_line;        /* fields taken from the line */
    int64_t n;            /* fields taken */
    char name[NAME_SIZE]; /* in capitals, without the star */
} card;

static int fields_of(const line *l) {
    return l->is_long ? LONG_FIELDS : SHORT_FIELDS;
}

static int width_of(const line *l) {
    return l->is_long ? LONG_FIELD : SHORT_FIELD;
}

static void enter_line(card *c, line l) {
    c->line = l;
    c->at = l.is_free ? l.name.end + 1 : NULL;
    c->n_of_line = 0;
}

/** The card at the cursor, which goes behind its first line. 0: a comment, an empty line, or one
 *  that goes on with a card that is passed over. */
static int take_card(io_cursor *cursor, card *c) {
    const line l = take_line(cursor);
    if (l.text.begin == l.text.end || is_continuation(&l))
        return 0;
    int n = 0;
    for (const char *at = l.name.begin; at < l.name.end && n < NAME_COLUMNS; at++) {
        if (is_blank(*at) || *at == '*')
            break;
        c->name[n++] = upper(*at);
    }
    c->name[n] = '\0';
    c->n = 0;
    c->rest = *cursor;
    enter_line(c, l);
    return 1;
}

/** To the next line, if it goes on with the card. */
static int continue_card(card *c) {
    io_cursor cursor = c->rest;
    line l;
    do {
        if (cursor.at == cursor.end)
            return 0;
        l = take_line(&cursor);
    } while (says_nothing(&l));
    if (!is_continuation(&l))
        return 0;
    c->rest = cursor;
    enter_line(c, l);
    return 1;
}

/** The next field of the line with the blanks around it; where the line ends before, the line's
 *  end. */
static span line_field(const card *c) {
    const span text = c->line.text;
    if (c->line.is_free)
        return c->at ? (span){c->at, find((span){c->at, text.end}, ',')}
                     : (span){text.end, text.end};
    const int64_t length = text.end - text.begin;
    const int64_t from = NAME_COLUMNS + c->n_of_line * width_of(&c->line);
    const int64_t to = from + width_of(&c->line);
    return (span){text.begin + (from < length ? from : length),
                  text.begin + (to < length ? to : length)};
}

/** Whether the line has the next field, be it empty. */
static int has_field(const card *c) {
    const span text = c->line.text;
    return c->line.is_free
               ? c->at != NULL
               : text.end - text.begin > NAME_COLUMNS + c->n_of_line * width_of(&c->line);
}

static void pass_field(card *c) {
    if (c->at) {
        const char *end = line_field(c).end;
        c->at = end < c->line.text.end ? end + 1 : NULL;
    }
    c->n_of_line++;
    c->n++;
}

/** The card's next field without blanks; 0 where the card ends. */
static int take_field(card *c, span *field) {
    if (c->n_of_line == fields_of(&c->line) && !continue_card(c))
        return 0;
    *field = trim(line_field(c));
    pass_field(c);
    return 1;
}

static int is_empty(span s) {
    return s.begin == s.end;
}

/* ---- reading ------------------------------------------------------------------------------ */

typedef struct reader {
    io_model *model;
    planish_error *error;
    io_cursor bulk; /* from behind BEGIN BULK to the end or ENDDATA */
    int64_t n_grids;
    int has_short, has_free;        /* GRIDs in fields of 8; in free fields, */
    int has_wide;                   /* some of which have more than 8 characters */
    int64_t default_system, system; /* that of GRDSET, and of the GRIDs */
    int system_is_rectangular;
    io_numbers *numbers; /* NULL: consecutive */
} reader;

typedef int visit_fn(reader *r, card *c);

static int fail_card(const reader *r, const card *c, const char *what) {
    return io_fail_text(r->model, c->line.text.begin, r->error, "%s: %s", c->name, what);
}

/** A card's fields cannot be found where tabs are among its columns. */
static int check_tabs(const reader *r, const card *c) {
    if (c->line.is_free || find(c->line.text, '\t') == c->line.text.end)
        return PLANISH_OK;
    return fail_card(r, c,
                     "a tab among fields of fixed columns; write it as blanks (expand -t 8 IN "
                     ">OUT)");
}

/** A whole number, 0 if the field is empty. */
static int parse_number(span field, int64_t *value) {
    const char *at = field.begin;
    *value = 0;
    if (is_empty(field))
        return 0;
    return io_parse_integer(&at, field.end, value) || at != field.end ? -1 : 0;
}

/** A field that must be a whole number of 32 bits, not negative. */
static int take_number(const reader *r, card *c, const char *what, int64_t *value) {
    span field = {NULL, NULL};
    *value = 0;
    if (!take_field(c, &field) || is_empty(field))
        return io_fail_text(r->model, c->line.text.begin, r->error,
                            "%s: %s is missing (the file may be cut short)", c->name, what);
    if (parse_number(field, value) || *value < 0 || *value > INT32_MAX)
        return io_fail_text(r->model, field.begin, r->error,
                            "%s: %s is '%.*s', not a whole number from 0 to %d", c->name, what,
                            (int)(field.end - field.begin < 24 ? field.end - field.begin : 24),
                            field.begin, INT32_MAX);
    return PLANISH_OK;
}

/** Visit the cards whose names begin with one of the letters. */
static int walk(reader *r, const char *letters, visit_fn *visit) {
    io_cursor cursor = r->bulk;
    int status = PLANISH_OK;
    card c;
    while (!status && cursor.at < cursor.end) {
        const char *end;
        if (!*cursor.at || !strchr(letters, upper(*cursor.at)))
            io_line(&cursor, &end);
        else if (take_card(&cursor, &c))
            status = visit(r, &c);
    }
    return status;
}

/* ---- where bulk data are ------------------------------------------------------------------ */

/** Whether the text begins with that word, in any letter case. */
static int line_begins(span text, const char *name) {
    const span s = trim(text);
    const int64_t length = (int64_t)strlen(name);
    for (int64_t i = 0; i < length; i++)
        if (s.begin + i >= s.end || upper(s.begin[i]) != name[i])
            return 0;
    return s.begin + length == s.end || is_blank(s.begin[length]);
}

/** The next line that begins with word, or the end. *after: behind it. */
static const char *find_line(io_cursor cursor, const char *word, const char **after) {
    while (cursor.at < cursor.end) {
        span text;
        text.begin = io_line(&cursor, &text.end);
        *after = cursor.at;
        if (text.begin < text.end && (upper(*text.begin) == *word || is_blank(*text.begin)) &&
            line_begins(text, word))
            return text.begin;
    }
    return *after = cursor.end;
}

/** The lines between BEGIN BULK, if there is one, and ENDDATA. */
static io_cursor find_bulk(const char *data, int64_t size) {
    io_cursor bulk = {data, data + size};
    const char *after, *begin = find_line(bulk, "BEGIN", &after);
    if (begin < bulk.end)
        bulk.at = after;
    bulk.end = find_line(bulk, "ENDDATA", &after);
    return bulk;
}

/* ---- first walk: counting ----------------------------------------------------------------- */

static int is_named(const card *c, const char *name) {
    return strcmp(c->name, name) == 0;
}

static int count_grid(reader *r, card *c) {
    span field;
    int status = check_tabs(r, c);
    r->n_grids++;
    if (!c->line.is_long)
        *(c->line.is_free ? &r->has_free : &r->has_short) = 1;
    while (!status && c->line.is_free && c->n < FIRST_COORDINATE + 3 && take_field(c, &field))
        if (c->n > FIRST_COORDINATE && field.end - field.begin > SHORT_FIELD)
            r->has_wide = 1;
    return status;
}

static int count_card(reader *r, card *c) {
    if (is_named(c, "GRID"))
        return count_grid(r, c);
    if (is_named(c, "INCLUDE"))
        return fail_card(r, c,
                         "what it brings in may be part of the mesh; put that file's lines in its "
                         "place, or smooth the file that has the mesh");
    if (is_named(c, "BEGIN"))
        return fail_card(r, c, "superelements are not read; smooth each in a file of its own");
    if (!is_named(c, "GRDSET"))
        return PLANISH_OK;
    span field;
    int status = check_tabs(r, c);
    for (int i = 0; !status && i < FIRST_COORDINATE && take_field(c, &field); i++)
        if (i == 1 && parse_number(field, &r->default_system))
            status = fail_card(r, c, "the coordinate system is no whole number");
    return status;
}

/** Free fields are as wide as the narrowest field of the file, or as those that the file has. */
static void decide_width(reader *r) {
    const int is_short = r->has_short || (r->has_free && !r->has_wide);
    r->model->field_width = is_short ? SHORT_FIELD : LONG_FIELD;
    r->model->precision = PLANISH_ROUNDED;
    r->model->implied_exponent = 1;
}

/* ---- second walk: grids ------------------------------------------------------------------- */

static int read_system(reader *r, card *c) {
    span field = {NULL, NULL};
    int64_t system = 0;
    if (take_field(c, &field) && parse_number(field, &system))
        return fail_card(r, c, "the coordinate system is no whole number");
    system = is_empty(field) ? r->default_system : system;
    if (r->model->n_nodes == 0)
        r->system = system;
    if (system == r->system)
        return PLANISH_OK;
    return io_fail_text(r->model, c->line.text.begin, r->error,
                        "GRIDs are in coordinate systems %lld and %lld; write all of them in one, "
                        "the basic system (0), as preprocessors can",
                        (long long)r->system, (long long)system);
}

static int read_grid(reader *r, card *c) {
    io_model *model = r->model;
    const int64_t node = model->n_nodes;
    int status = take_number(r, c, "its number", &model->node_number[node]);
    if (!status)
        status = read_system(r, c);
    if (status)
        return status;
    model->text_offset[node] = line_field(c).begin - model->input.data;
    for (int d = 0; d < 3; d++) {
        span field = {NULL, NULL};
        double *value = &model->xyz[3 * node + d];
        *value = 0;
        if (!take_field(c, &field) || is_empty(field))
            continue;
        if (io_parse_packed_real(field.begin, field.end, value) || !isfinite(*value))
            return io_fail_text(model, field.begin, r->error,
                                "GRID %lld: '%.*s' is no coordinate (a finite real number)",
                                (long long)model->node_number[node],
                                (int)(field.end - field.begin < 24 ? field.end - field.begin : 24),
                                field.begin);
    }
    model->n_nodes++;
    return PLANISH_OK;
}

static int read_grid_card(reader *r, card *c) {
    return is_named(c, "GRID") ? read_grid(r, c) : PLANISH_OK;
}

/** Whether it is a rectangular system with the number of that of the GRIDs. */
static int look_at_system(reader *r, card *c) {
    const int by_grids = is_named(c, "CORD1R");
    if (!by_grids && !is_named(c, "CORD2R"))
        return PLANISH_OK;
    span field;
    int64_t number;
    while (c->n < (by_grids ? SHORT_FIELDS : 1) && take_field(c, &field))
        if ((c->n - 1) % 4 == 0 && !is_empty(field) && !parse_number(field, &number))
            r->system_is_rectangular |= number == r->system;
    return PLANISH_OK;
}

/** Lengths and angles are in a rectangular system what they are in any other. */
static int check_system(reader *r) {
    if (r->system == 0)
        return PLANISH_OK;
    int status = walk(r, "C", look_at_system);
    if (status || r->system_is_rectangular)
        return status;
    return pl_fail(r->error, PLANISH_ERROR_FORMAT,
                   "%s: the GRIDs are in coordinate system %lld, and no CORD1R or CORD2R says that "
                   "it is rectangular; write them in the basic system (0), as preprocessors can",
                   r->model->input.path, (long long)r->system);
}

static int numbers_are_consecutive(const int64_t *number, int64_t n) {
    for (int64_t i = 1; i < n; i++)
        if (number[i] != number[0] + i)
            return 0;
    return 1;
}

static int settle_node_numbers(reader *r) {
    io_model *model = r->model;
    if (model->n_nodes > 0 && numbers_are_consecutive(model->node_number, model->n_nodes)) {
        model->first_number = model->node_number[0];
        pl_free(model->node_number);
        model->node_number = NULL;
        return PLANISH_OK;
    }
    return io_numbers_create(model->node_number, model->n_nodes, &r->numbers, r->error);
}

static int read_grids(reader *r) {
    io_model *model = r->model;
    int status = io_model_nodes(model, r->n_grids, 1, r->error);
    if (status)
        return status;
    model->columns = 3;
    model->node_number = pl_alloc(r->n_grids, sizeof *model->node_number);
    if (!model->node_number)
        return pl_fail_memory(r->error, "the numbers of the GRIDs");
    status = io_model_span(model, (io_span){.n_nodes = r->n_grids, .encoding = IO_TEXT}, r->error);
    model->n_nodes = 0;
    if (!status)
        status = walk(r, "G", read_grid_card);
    if (!status)
        status = check_system(r);
    return status ? status : settle_node_numbers(r);
}

/* ---- third walk: elements ----------------------------------------------------------------- */

typedef enum kind {
    CELL,     /* kept: lines, triangles, tetrahedra */
    NODES,    /* its nodes are held: those from field first on, */
    LISTED,   /* that and all behind it, whole numbers as far as they go */
    PAIRS,    /* fields first and first + 2, each with a component behind it */
    RIGID,    /* LISTED, with components of nodes among them */
    EQUATION, /* MPC: nodes are fields 1 and 4 of each row */
    REFUSED
} kind;

typedef struct card_kind {
    const char *name;
    kind kind;
    int first; /* field of the first node; for cells all nodes are side by side */
    int nodes; /* how many; 0: as many as there are */
    int dim;   /* of cells */
    int most;  /* nodes of a cell of second order; 0: there is none */
} card_kind;

static const card_kind kinds[] = {
    {"CTETRA", CELL, 2, 4, 3, 10},    {"CTRIA3", CELL, 2, 3, 2, 0},
    {"CTRIAR", CELL, 2, 3, 2, 0},     {"CTRAX3", CELL, 2, 3, 2, 0},
    {"CPLSTN3", CELL, 2, 3, 2, 0},    {"CPLSTS3", CELL, 2, 3, 2, 0},
    {"CBAR", CELL, 2, 2, 1, 0},       {"CBEAM", CELL, 2, 2, 1, 0},
    {"CROD", CELL, 2, 2, 1, 0},       {"CTUBE", CELL, 2, 2, 1, 0},
    {"CBEND", CELL, 2, 2, 1, 0},      {"CVISC", CELL, 2, 2, 1, 0},
    {"CONROD", CELL, 1, 2, 1, 0},     {"PLOTEL", CELL, 1, 2, 1, 0},
    {"CTRIA6", REFUSED, 0, 0, 0, 0},  {"CTRAX6", REFUSED, 0, 0, 0, 0},
    {"CTRIAX6", REFUSED, 0, 0, 0, 0}, {"CPLSTN6", REFUSED, 0, 0, 0, 0},
    {"CPLSTS6", REFUSED, 0, 0, 0, 0}, {"CQUAD4", NODES, 2, 4, 0, 0},
    {"CQUADR", NODES, 2, 4, 0, 0},    {"CSHEAR", NODES, 2, 4, 0, 0},
    {"CPLSTN4", NODES, 2, 4, 0, 0},   {"CPLSTS4", NODES, 2, 4, 0, 0},
    {"CQUAD8", NODES, 2, 8, 0, 0},    {"CPLSTN8", NODES, 2, 8, 0, 0},
    {"CPLSTS8", NODES, 2, 8, 0, 0},   {"CQUAD", NODES, 2, 9, 0, 0},
    {"CTRIAX", NODES, 2, 6, 0, 0},    {"CGAP", NODES, 2, 2, 0, 0},
    {"CBUSH", NODES, 2, 2, 0, 0},     {"CBEAM3", NODES, 2, 3, 0, 0},
    {"CONM1", NODES, 1, 1, 0, 0},     {"CONM2", NODES, 1, 1, 0, 0},
    {"CELAS1", PAIRS, 2, 0, 0, 0},    {"CELAS2", PAIRS, 2, 0, 0, 0},
    {"CDAMP1", PAIRS, 2, 0, 0, 0},    {"CDAMP2", PAIRS, 2, 0, 0, 0},
    {"CMASS1", PAIRS, 2, 0, 0, 0},    {"CMASS2", PAIRS, 2, 0, 0, 0},
    {"RROD", NODES, 1, 2, 0, 0},      {"RBAR", NODES, 1, 2, 0, 0},
    {"RBE1", LISTED, 1, 0, 0, 0},     {"RBE2", RIGID, 1, 0, 0, 0},
    {"RBE3", RIGID, 2, 0, 0, 0},      {"RSPLINE", LISTED, 1, 0, 0, 0},
    {"RTRPLT", LISTED, 1, 0, 0, 0},   {"MPC", EQUATION, 1, 0, 0, 0},
};

/** Beginnings of names of cards that are no elements. */
static const char *const no_elements[] = {"CORD",  "CAERO",  "CSET",   "CREEP", "CY",    "CSUP",
                                          "CLOAD", "CBARAO", "CSSCHD", "CONV",  "CONTR", "CLUSTER"};

/** An element that is not in the table, solids among them: number, property, nodes. */
static const card_kind other_element = {"C...", LISTED, 2, 0, 0, 0};

/** What is done with a card; NULL: nothing. */
static const card_kind *find_kind(const card *c) {
    const char *name = c->name;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (strcmp(name, kinds[i].name) == 0)
            return &kinds[i];
    if (name[0] != 'C')
        return NULL;
    for (size_t i = 0; i < sizeof no_elements / sizeof *no_elements; i++)
        if (strncmp(name, no_elements[i], strlen(no_elements[i])) == 0)
            return NULL;
    return &other_element;
}

/** Index of a GRID, or -1. */
static int64_t find_grid(const reader *r, int64_t number) {
    if (r->numbers)
        return io_numbers_find(r->numbers, number);
    const int64_t index = number - r->model->first_number;
    return index >= 0 && index < r->model->n_nodes ? index : -1;
}

static io_cells *cells_of(io_model *model, int dim) {
    return dim == 3 ? &model->tetrahedron : dim == 2 ? &model->triangle : &model->line;
}

/** Nodes behind the corners. */
static int check_first_order(const reader *r, const card_kind *k, card *c) {
    span field;
    while (c->n < k->first + k->most && take_field(c, &field))
        if (!is_empty(field))
            return fail_card(r, c,
                             "elements of second order cannot be smoothed; export the mesh with "
                             "straight elements of first order");
    return PLANISH_OK;
}

/** Number and property of a cell; 0 if it has none. Nastran takes a property of the element's
 * number then, but who leaves it out means one region. */
static int take_property(reader *r, const card_kind *k, card *c, int64_t *number,
                         int64_t *property) {
    int status = take_number(r, c, "its number", number);
    *property = 0;
    if (status || k->first < 2)
        return status;
    card peek = *c;
    span field;
    if (take_field(&peek, &field) && is_empty(field)) {
        *c = peek;
        return PLANISH_OK;
    }
    return take_number(r, c, "its property", property);
}

static int take_node(const reader *r, card *c, int64_t element, int32_t *node) {
    int64_t number;
    int status = take_number(r, c, "a node", &number);
    if (status)
        return status;
    const int64_t index = find_grid(r, number);
    if (index < 0)
        return io_fail_text(r->model, c->line.text.begin, r->error,
                            "%s %lld: there is no GRID %lld", c->name, (long long)element,
                            (long long)number);
    *node = (int32_t)index;
    return PLANISH_OK;
}

static int read_cell(reader *r, const card_kind *k, card *c) {
    io_cells *cells = cells_of(r->model, k->dim);
    int64_t number, property;
    int status = take_property(r, k, c, &number, &property);
    if (!status)
        status = io_cells_reserve(cells, k->dim, 1, 1, 1, r->error);
    for (int j = 0; j < k->nodes && !status; j++)
        status = take_node(r, c, number, &cells->nodes[cells->n * k->nodes + j]);
    if (!status)
        status = check_first_order(r, k, c);
    if (status)
        return status;
    /* Cells of one property stand together most often. */
    const io_entity *last = cells->n > 0 ? &r->model->entity[cells->entity[cells->n - 1]] : NULL;
    const int32_t entity =
        last && last->tag == property
            ? cells->entity[cells->n - 1]
            : io_model_entity(r->model, k->dim, (int32_t)property, 0, NULL, r->error);
    if (entity < 0)
        return entity;
    cells->entity[cells->n] = entity;
    cells->number[cells->n++] = number;
    return PLANISH_OK;
}

/** Hold the node that the field names, if it does: other fields are there, too. */
static void hold_field(reader *r, span field, uint8_t reason) {
    int64_t number;
    const int64_t index =
        is_empty(field) || parse_number(field, &number) ? -1 : find_grid(r, number);
    if (index >= 0)
        io_hold_node(r->model, index, reason);
}

/** Whether the field at place is one that names a node; follows_real: the one before it is a real
 *  number (RBE3: a weight, behind which components stand). */
static int names_node(const card_kind *k, int64_t place, int follows_real) {
    switch (k->kind) {
    case EQUATION:
        return place % SHORT_FIELDS == 1 || place % SHORT_FIELDS == 4;
    case PAIRS:
        return place == k->first || place == k->first + 2;
    case RIGID: /* the components of the first node behind it */
        return place >= k->first && !follows_real && place != k->first + 1;
    default:
        return place >= k->first;
    }
}

static void hold_fields(reader *r, const card_kind *k, card *c) {
    const int is_element = c->name[0] == 'C';
    int follows_real = 0;
    span field;
    while ((k->nodes == 0 || c->n < k->first + k->nodes) && take_field(c, &field)) {
        if (names_node(k, c->n - 1, follows_real))
            hold_field(r, field, is_element ? IO_HELD_BY_OTHER : IO_HELD_REQUIRED);
        follows_real = find(field, '.') < field.end;
    }
    r->model->n_other += is_element;
}

static int read_element(reader *r, card *c) {
    const card_kind *k = find_kind(c);
    if (!k)
        return PLANISH_OK;
    int status = check_tabs(r, c);
    if (status)
        return status;
    if (k->kind == REFUSED)
        return fail_card(r, c,
                         "elements of second order cannot be smoothed; export the mesh with "
                         "straight elements of first order");
    if (k->kind == CELL)
        return read_cell(r, k, c);
    hold_fields(r, k, c);
    return PLANISH_OK;
}

static void settle_cell_numbers(io_cells *cells) {
    if (cells->n == 0 || !numbers_are_consecutive(cells->number, cells->n))
        return;
    cells->first_number = cells->number[0];
    pl_free(cells->number);
    cells->number = NULL;
}

/* ---- names -------------------------------------------------------------------------------- */

/** $HMNAME PROP 5"steel" (HyperMesh): the name of property 5. */
static int read_name(reader *r, span text) {
    static const char mark[] = "$HMNAME PROP";
    const int64_t length = sizeof mark - 1;
    if (text.end - text.begin < length || memcmp(text.begin, mark, (size_t)length) != 0)
        return PLANISH_OK;
    const char *open = find(text, '"');
    const span name = {open < text.end ? open + 1 : open,
                       find((span){open + (open < text.end), text.end}, '"')};
    int64_t number;
    if (name.end == text.end || parse_number(trim((span){text.begin + length, open}), &number) ||
        number < 1 || number > INT32_MAX)
        return PLANISH_OK;
    int status = PLANISH_OK;
    for (int dim = 1; dim <= 3 && !status; dim++) {
        int there = 0;
        for (int32_t i = 0; i < r->model->n_entities; i++)
            there |= r->model->entity[i].dim == dim && r->model->entity[i].tag == number;
        if (there)
            status = io_model_group(r->model, dim, (int32_t)number, name.begin,
                                    name.end - name.begin, r->error);
    }
    return status;
}

static int read_names(reader *r) {
    io_cursor cursor = r->bulk;
    int status = PLANISH_OK;
    while (!status && cursor.at < cursor.end) {
        span text;
        text.begin = io_line(&cursor, &text.end);
        if (text.begin < text.end && *text.begin == '$')
            status = read_name(r, text);
    }
    return status;
}

/* ---- the file ----------------------------------------------------------------------------- */

static int read_all(reader *r) {
    io_model *model = r->model;
    int status = walk(r, "GIB", count_card);
    if (status)
        return status;
    if (r->n_grids == 0)
        return io_fail_text(model, r->bulk.end, r->error,
                            "there is no GRID: this is no Nastran mesh, or it is cut short");
    decide_width(r);
    status = read_grids(r);
    if (!status)
        status = walk(r, "CRMP", read_element);
    if (!status)
        status = read_names(r);
    settle_cell_numbers(&model->line);
    settle_cell_numbers(&model->triangle);
    settle_cell_numbers(&model->tetrahedron);
    return status;
}

static int nastran_read(io_model *model, planish_error *error) {
    reader r = {
        .model = model, .error = error, .bulk = find_bulk(model->input.data, model->input.size)};
    const int status = read_all(&r);
    io_numbers_destroy(r.numbers);
    return status;
}

/** A GRID or BEGIN BULK at the beginning of a line, not too far into the file. */
static int nastran_recognise(const char *data, int64_t size) {
    enum { LOOKED_AT = 1 << 18 };
    io_cursor cursor = {data, data + (size < LOOKED_AT ? size : LOOKED_AT)};
    while (cursor.at < cursor.end) {
        const line l = take_line(&cursor);
        const span name = trim(l.name);
        if (name.begin == name.end)
            continue;
        const char first = upper(*name.begin);
        if (first != 'G' && first != 'B')
            continue;
        span rest = trim((span){l.name.end, l.text.end});
        if (line_begins(name, "GRID") || line_begins(name, "GRID*"))
            return rest.begin < rest.end;
        if (line_begins(l.text, "BEGIN") && l.text.end - trim(l.text).begin > 5 &&
            line_begins((span){trim(l.text).begin + 5, l.text.end}, "BULK"))
            return 1;
    }
    return 0;
}

/* ---- writing ------------------------------------------------------------------------------ */

/** Where the line that holds at begins. */
static const char *line_of(const char *data, const char *at) {
    while (at > data && at[-1] != '\n' && at[-1] != '\r')
        at--;
    return at;
}

static void field_of_columns(const card *c, int d, io_field *field) {
    static const char blanks[IO_LEAD_SIZE + 1] =
        "                                                                ";
    field->width = width_of(&c->line);
    field->is_fixed = 1;
    if (has_field(c))
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
    const span text = trim((span){field->begin, field->end});
    field->begin = text.begin;
    field->end = text.end;
    field->width = model->field_width;
    if (has_field(c))
        return;
    field->lead = ",,,";
    field->n_lead = d == 0 ? absent + 1 : 1;
}

/** The third coordinate of a long GRID is in the next line; where there is none, it is made. */
static void field_of_next_line(const card *c, io_field *field) {
    io_cursor from = {c->line.text.begin, c->rest.at};
    io_line(&from, &field->end);
    field->begin = field->end;
    field->width = LONG_FIELD;
    field->is_fixed = !c->line.is_free;
    field->lead = c->line.is_free ? "\n*," : "\n*       ";
    field->n_lead = (int)strlen(field->lead);
}

static int nastran_field(const io_model *model, io_cursor *cursor, int d, io_field *field) {
    io_cursor from = {line_of(model->input.data, cursor->at), cursor->end};
    card c;
    span skipped;
    int absent = 0;
    *field = (io_field){.width = 0};
    if (!take_card(&from, &c))
        return -1;
    for (int i = 0; i < FIRST_COORDINATE + d; i++) {
        absent += !has_field(&c);
        take_field(&c, &skipped);
    }
    if (c.n_of_line == fields_of(&c.line) && !continue_card(&c)) {
        field_of_next_line(&c, field);
        cursor->at = field->end;
        return 0;
    }
    const span text = line_field(&c), number = trim(text);
    field->begin = text.begin;
    field->end = text.end;
    if (c.line.is_free)
        field_of_commas(model, &c, d, absent, field);
    else
        field_of_columns(&c, d, field);
    cursor->at = field->end;
    return is_empty(number) ? 0 : io_parse_packed_real(number.begin, number.end, &field->value);
}

static const char *const extensions[] = {".bdf", ".nas", ".fem", NULL};

const io_format io_format_nastran = {.name = "nastran",
                                     .extensions = extensions,
                                     .recognise = nastran_recognise,
                                     .read = nastran_read,
                                     .field = nastran_field};
