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
#include "io/core/format.h"
#include "io/nastran/nastran.h"

#include "io/core/bytes.h"
#include "io/core/number.h"
#include "io/core/records.h"

#include "base/memory.h"
#include "base/status.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- reading ------------------------------------------------------------------------------ */

typedef struct number_range {
    int64_t first, last;
} number_range;

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
    number_range *range; /* [n_ranges] owned: numbers of nodes that rigid elements hold */
    int64_t n_ranges, range_capacity;
} reader;

typedef int visit_fn(reader *r, card *c);

static int fail_card(const reader *r, const card *c, const char *what) {
    return io_fail_at(r->model, c->line.text.begin, r->error, "%s: %s", c->name, what);
}

/** A whole number, 0 if the field is empty. */
static int parse_number(span field, int64_t *value) {
    const char *at = field.begin;
    *value = 0;
    if (is_empty_field(field))
        return 0;
    return io_parse_integer(&at, field.end, value) || at != field.end ? -1 : 0;
}

/** A field that must be a whole number of 32 bits, not negative. */
static int take_number(const reader *r, card *c, const char *what, int64_t *value) {
    span field = {NULL, NULL};
    *value = 0;
    if (!nastran_take_field(c, &field) || is_empty_field(field))
        return io_fail_at(r->model, c->line.text.begin, r->error,
                          "%s: %s is missing (the file may be cut short)", c->name, what);
    if (parse_number(field, value) || *value < 0 || *value > INT32_MAX)
        return io_fail_at(r->model, field.begin, r->error,
                          "%s: %s is '%.*s', not a whole number from 0 to %d", c->name, what,
                          (int)(field.end - field.begin < 24 ? field.end - field.begin : 24),
                          field.begin, INT32_MAX);
    return PLANISH_OK;
}

/** Whether it is a card that is read. */
static int is_read(const char *name);

/** A line that begins with a blank goes on with the card before it; one that begins with the name
 *  of a card behind the blanks means something else. */
static int check_indented(reader *r, io_cursor *cursor) {
    const line l = nastran_take_line(cursor);
    const span text = nastran_trim(l.text);
    char name[NAME_SIZE];
    int n = 0;
    if (text.begin - l.text.begin >= NAME_COLUMNS)
        return PLANISH_OK;
    for (const char *at = text.begin; at < text.end && n < NAME_COLUMNS; at++) {
        if (io_is_blank(*at) || *at == '*' || *at == ',')
            break;
        name[n++] = io_upper(*at);
    }
    name[n] = '\0';
    if (!is_read(name))
        return PLANISH_OK;
    return io_fail_at(r->model, text.begin, r->error,
                      "%s behind blanks: a card begins in the first column of its line (take the "
                      "blanks away)",
                      name);
}

/** Visit the cards whose names begin with one of the letters; a blank among these: check lines that
 *  begin with one. */
static int walk(reader *r, const char *letters, visit_fn *visit) {
    io_cursor cursor = r->bulk;
    int status = PLANISH_OK;
    card c;
    while (!status && cursor.at < cursor.end) {
        const char *end;
        if (!*cursor.at || !strchr(letters, io_upper(*cursor.at)))
            io_line(&cursor, &end);
        else if (io_is_blank(*cursor.at))
            status = check_indented(r, &cursor);
        else if (nastran_take_card(&cursor, &c)) {
            status = visit(r, &c);
            /* What a reader made of such fields, an error perhaps, says nothing. */
            if (c.n > 0 && c.wrong)
                status = io_fail_at(r->model, c.wrong_at, r->error, "%s: %s", c.name, c.wrong);
        }
    }
    return status;
}

/* ---- first walk: counting ----------------------------------------------------------------- */

static int is_named(const card *c, const char *name) {
    return strcmp(c->name, name) == 0;
}

static void count_grid(reader *r, card *c) {
    span field;
    r->n_grids++;
    if (!c->line.is_long)
        *(c->line.is_free ? &r->has_free : &r->has_short) = 1;
    while (c->line.is_free && c->n < FIRST_COORDINATE + 3 && nastran_take_field(c, &field))
        if (c->n > FIRST_COORDINATE && field.end - field.begin > SHORT_FIELD)
            r->has_wide = 1;
}

static int count_card(reader *r, card *c) {
    if (is_named(c, "INCLUDE"))
        return fail_card(r, c,
                         "what it brings in may be part of the mesh; put that file's lines in its "
                         "place, or smooth the file that has the mesh");
    if (is_named(c, "BEGIN"))
        return fail_card(r, c, "superelements are not read; smooth each in a file of its own");
    if (c->name[0] == '=')
        return fail_card(r, c,
                         "replication of the card before (=, *(1)) is not read; have the "
                         "preprocessor write every card in full");
    if (is_named(c, "GRID"))
        count_grid(r, c);
    if (!is_named(c, "GRDSET"))
        return PLANISH_OK;
    span field;
    int status = PLANISH_OK;
    for (int i = 0; !status && i < FIRST_COORDINATE && nastran_take_field(c, &field); i++)
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
    if (nastran_take_field(c, &field) && parse_number(field, &system))
        return fail_card(r, c, "the coordinate system is no whole number");
    system = is_empty_field(field) ? r->default_system : system;
    if (r->model->n_nodes == 0)
        r->system = system;
    if (system == r->system)
        return PLANISH_OK;
    return io_fail_at(r->model, c->line.text.begin, r->error,
                      "GRIDs are in coordinate systems %lld and %lld; write all of them in one, "
                      "the basic system (0), as preprocessors can",
                      (long long)r->system, (long long)system);
}

static int read_grid(reader *r, card *c) {
    io_model *model = r->model;
    const int64_t node = model->n_nodes;
    if (node == r->n_grids)
        return io_bytes_fail_changed(&model->input, r->error);
    int status = take_number(r, c, "its number", &model->node_number[node]);
    if (!status)
        status = read_system(r, c);
    if (status)
        return status;
    model->text_offset[node] = nastran_line_field(c).begin - model->input.data;
    for (int d = 0; d < 3; d++) {
        span field = {NULL, NULL};
        double *value = &model->xyz[3 * node + d];
        *value = 0;
        if (!nastran_take_field(c, &field) || is_empty_field(field))
            continue;
        if (io_parse_packed_real(field.begin, field.end, value) || !isfinite(*value))
            return io_fail_at(model, field.begin, r->error,
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
    while (c->n < (by_grids ? SHORT_FIELDS : 1) && nastran_take_field(c, &field))
        if ((c->n - 1) % 4 == 0 && !is_empty_field(field) && !parse_number(field, &number))
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
    if (!status && model->n_nodes != r->n_grids)
        status = io_bytes_fail_changed(&model->input, r->error);
    if (!status)
        status = check_system(r);
    return status ? status : io_settle_node_numbers(r->model, &r->numbers, r->error);
}

/* ---- third walk: elements ----------------------------------------------------------------- */

typedef enum kind {
    CELL,     /* kept: lines, triangles, tetrahedra */
    NODES,    /* its nodes are held: those from field first on, */
    LISTED,   /* that and all behind it, whole numbers as far as they go */
    PAIRS,    /* fields first and first + 2, each with a component behind it */
    RIGID,    /* LISTED, with components of nodes among them */
    SYSTEM,   /* systems of four fields each: its number and three nodes */
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
    {"CTRIAX", NODES, 2, 6, 0, 0},    {"CGAP", NODES, 2, 3, 0, 0},
    {"CBUSH", NODES, 2, 3, 0, 0},     {"CBEAM3", NODES, 2, 4, 0, 0},
    {"CONM1", NODES, 1, 1, 0, 0},     {"CONM2", NODES, 1, 1, 0, 0},
    {"CELAS1", PAIRS, 2, 0, 0, 0},    {"CELAS2", PAIRS, 2, 0, 0, 0},
    {"CDAMP1", PAIRS, 2, 0, 0, 0},    {"CDAMP2", PAIRS, 2, 0, 0, 0},
    {"CMASS1", PAIRS, 2, 0, 0, 0},    {"CMASS2", PAIRS, 2, 0, 0, 0},
    {"RROD", NODES, 1, 2, 0, 0},      {"RBAR", NODES, 1, 2, 0, 0},
    {"RBE1", LISTED, 1, 0, 0, 0},     {"RBE2", RIGID, 1, 0, 0, 0},
    {"RBE3", RIGID, 2, 0, 0, 0},      {"RSPLINE", LISTED, 1, 0, 0, 0},
    {"RTRPLT", LISTED, 1, 0, 0, 0},   {"MPC", EQUATION, 1, 0, 0, 0},
    {"RBAR1", NODES, 1, 2, 0, 0},     {"RJOINT", NODES, 1, 2, 0, 0},
    {"CORD1R", SYSTEM, 0, 8, 0, 0},   {"CORD1C", SYSTEM, 0, 8, 0, 0},
    {"CORD1S", SYSTEM, 0, 8, 0, 0},   {"CORD3R", SYSTEM, 0, 8, 0, 0},
};

/** Beginnings of names of cards that are no elements. */
static const char *const no_elements[] = {"CORD",  "CAERO",  "CSET",   "CREEP", "CY",    "CSUP",
                                          "CLOAD", "CBARAO", "CSSCHD", "CONV",  "CONTR", "CLUSTER",
                                          "RAD",   "RAND",   "RCROSS", "RELEA", "RESV",  "RFORCE",
                                          "RGYRO", "RING",   "RLOAD",  "ROTOR", "RSPIN", "RVDOF"};

/** Elements that are not in the table, solids among them: number, property, nodes; and rigid ones:
 *  number, nodes. */
static const card_kind other_element = {"C...", LISTED, 2, 0, 0, 0};
static const card_kind other_rigid = {"R...", LISTED, 1, 0, 0, 0};

static int is_read(const char *name) {
    static const char *const others[] = {"GRID", "GRDSET", "INCLUDE"};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        if (strcmp(name, others[i]) == 0)
            return 1;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (strcmp(name, kinds[i].name) == 0)
            return 1;
    return 0;
}

/** What is done with a card; NULL: nothing. */
static const card_kind *find_kind(const card *c) {
    const char *name = c->name;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (strcmp(name, kinds[i].name) == 0)
            return &kinds[i];
    if (name[0] != 'C' && name[0] != 'R')
        return NULL;
    for (size_t i = 0; i < sizeof no_elements / sizeof *no_elements; i++)
        if (strncmp(name, no_elements[i], strlen(no_elements[i])) == 0)
            return NULL;
    return name[0] == 'C' ? &other_element : &other_rigid;
}

/** Nodes behind the corners. */
static int check_first_order(const reader *r, const card_kind *k, card *c) {
    span field;
    while (c->n < k->first + k->most && nastran_take_field(c, &field))
        if (!is_empty_field(field))
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
    if (nastran_take_field(&peek, &field) && is_empty_field(field)) {
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
    const int64_t index = io_node_index(r->model, r->numbers, number);
    if (index < 0)
        return io_fail_at(r->model, c->line.text.begin, r->error, "%s %lld: there is no GRID %lld",
                          c->name, (long long)element, (long long)number);
    *node = (int32_t)index;
    return PLANISH_OK;
}

/** Hold the node that the field names, if it does: other fields are there, too. Returns the field's
 *  number, 0 if it is none. */
static int64_t hold_field(reader *r, span field, uint8_t reason) {
    int64_t number;
    if (is_empty_field(field) || parse_number(field, &number))
        return 0;
    const int64_t index = io_node_index(r->model, r->numbers, number);
    if (index >= 0)
        io_hold_node(r->model, index, reason);
    return number;
}

/** The field behind the nodes of a bar names a node that its cross section points to, if it is no
 *  component of a vector (a real number). */
static void hold_orientation(reader *r, card *c) {
    span field;
    if (nastran_take_field(c, &field))
        hold_field(r, field, IO_HELD_REQUIRED);
}

static int read_cell(reader *r, const card_kind *k, card *c) {
    io_cells *cells = io_model_cells(r->model, k->dim);
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
    if (c->name[1] == 'B') /* CBAR, CBEAM, CBEND */
        hold_orientation(r, c);
    return PLANISH_OK;
}

/** first THRU last: the nodes between these, too; see hold_ranges. */
static int add_range(reader *r, span field, int64_t first) {
    int64_t last;
    if (parse_number(field, &last) || last <= first)
        return PLANISH_OK;
    number_range *grown =
        pl_grow(r->range, r->n_ranges, r->n_ranges + 1, &r->range_capacity, sizeof *grown);
    if (!grown)
        return pl_fail_memory(r->error, "the nodes of rigid elements");
    r->range = grown;
    r->range[r->n_ranges++] = (number_range){first, last};
    return PLANISH_OK;
}

static int compare_ranges(const void *a, const void *b) {
    const number_range *p = a, *q = b;
    return (p->first > q->first) - (p->first < q->first);
}

/** Hold the nodes in any of the ranges. Many cards may name the same wide one: they are united, and
 *  each node looks for the one that it may be in. */
static void hold_ranges(reader *r) {
    int64_t n = 0;
    if (r->n_ranges > 0)
        qsort(r->range, (size_t)r->n_ranges, sizeof *r->range, compare_ranges);
    for (int64_t i = 0; i < r->n_ranges; i++) {
        if (n == 0 || r->range[i].first > r->range[n - 1].last)
            r->range[n++] = r->range[i];
        else if (r->range[i].last > r->range[n - 1].last)
            r->range[n - 1].last = r->range[i].last;
    }
    for (int64_t node = 0; n > 0 && node < r->model->n_nodes; node++) {
        const int64_t number =
            r->model->node_number ? r->model->node_number[node] : r->model->first_number + node;
        int64_t low = 0,
                high = n; /* ranges before low begin at number or before, from high on not */
        while (low < high) {
            const int64_t middle = low + (high - low) / 2;
            if (r->range[middle].first <= number)
                low = middle + 1;
            else
                high = middle;
        }
        if (low > 0 && number <= r->range[low - 1].last)
            io_hold_node(r->model, node, IO_HELD_REQUIRED);
    }
}

/** Whether the field at place is one that names a node; follows_real: the one before it is a real
 *  number (RBE3: a weight, behind which components stand). */
static int names_node(const card_kind *k, int64_t place, int follows_real) {
    switch (k->kind) {
    case EQUATION:
        return place % SHORT_FIELDS == 1 || place % SHORT_FIELDS == 4;
    case SYSTEM:
        return place % 4 != 0;
    case PAIRS:
        return place == k->first || place == k->first + 2;
    case RIGID: /* the components of the first node behind it */
        return place >= k->first && !follows_real && place != k->first + 1;
    default:
        return place >= k->first;
    }
}

static int hold_fields(reader *r, const card_kind *k, card *c) {
    const int is_element = c->name[0] == 'C' && k->kind != SYSTEM;
    const uint8_t reason = is_element ? IO_HELD_BY_OTHER : IO_HELD_REQUIRED;
    int follows_real = 0, is_thru = 0, status = PLANISH_OK;
    int64_t number = 0; /* of the last node that was named */
    span field;
    while (!status && (k->nodes == 0 || c->n < k->first + k->nodes) &&
           nastran_take_field(c, &field)) {
        const int is_node = names_node(k, c->n - 1, follows_real);
        if (is_thru)
            status = add_range(r, field, number);
        is_thru = is_node && nastran_line_begins(field, "THRU");
        if (is_node && !is_thru)
            number = hold_field(r, field, reason);
        follows_real = find_character(field, '.') < field.end;
    }
    r->model->n_other += is_element;
    return status;
}

static int read_element(reader *r, card *c) {
    const card_kind *k = find_kind(c);
    if (!k)
        return PLANISH_OK;
    if (k->kind == REFUSED)
        return fail_card(r, c,
                         "elements of second order cannot be smoothed; export the mesh with "
                         "straight elements of first order");
    if (k->kind == CELL)
        return read_cell(r, k, c);
    return hold_fields(r, k, c);
}

/* ---- names -------------------------------------------------------------------------------- */

/** $HMNAME PROP 5"steel" (HyperMesh): the name of property 5. */
static int read_name(reader *r, span text) {
    static const char mark[] = "$HMNAME PROP";
    const int64_t length = sizeof mark - 1;
    if (text.end - text.begin < length || memcmp(text.begin, mark, (size_t)length) != 0)
        return PLANISH_OK;
    const char *open = find_character(text, '"');
    const span name = {open < text.end ? open + 1 : open,
                       find_character((span){open + (open < text.end), text.end}, '"')};
    int64_t number;
    if (name.end == text.end ||
        parse_number(nastran_trim((span){text.begin + length, open}), &number) || number < 1 ||
        number > INT32_MAX)
        return PLANISH_OK;
    int status = PLANISH_OK;
    for (int dim = 1; dim <= 3 && !status; dim++)
        if (io_model_has_entity(r->model, dim, (int32_t)number))
            status = io_model_group(r->model, dim, (int32_t)number, name.begin,
                                    name.end - name.begin, r->error);
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

/** Programs end their files with ENDDATA, or the last line at least. Without either a card may be
 *  incomplete that looks whole. */
static int check_file_end(const reader *r) {
    const io_bytes *file = &r->model->input;
    const char *end = file->data + file->size;
    if (r->bulk.end < end || end[-1] == '\n' || end[-1] == '\r')
        return PLANISH_OK;
    return io_fail_at(r->model, end, r->error,
                      "no ENDDATA, and the last line has no end: the file is cut short most "
                      "likely (if it is whole, add ENDDATA or a line end)");
}

static int read_all(reader *r) {
    io_model *model = r->model;
    int status = walk(r, "GIB= \t", count_card);
    if (status)
        return status;
    if (r->n_grids == 0)
        return io_fail_at(model, r->bulk.end, r->error,
                          "there is no GRID: this is no Nastran mesh, or it is cut short");
    status = check_file_end(r);
    if (status)
        return status;
    decide_width(r);
    status = read_grids(r);
    if (!status)
        status = walk(r, "CRMP", read_element);
    hold_ranges(r);
    if (!status)
        status = read_names(r);
    io_settle_cell_numbers(&model->line);
    io_settle_cell_numbers(&model->triangle);
    io_settle_cell_numbers(&model->tetrahedron);
    return status;
}

static int nastran_read(io_model *model, planish_error *error) {
    reader r = {.model = model,
                .error = error,
                .bulk = nastran_find_bulk(model->input.data, model->input.size)};
    const int status = read_all(&r);
    io_numbers_destroy(r.numbers);
    pl_free(r.range);
    return status;
}

/** Whether the first field of a card is a whole number; a title may begin with the name of one. */
static int begins_with_number(span fields) {
    const char *at = fields.begin;
    if (at < fields.end && *at == ',')
        at++;
    while (at < fields.end && (*at == ' ' || *at == '\t'))
        at++;
    const char *digits = at;
    while (at < fields.end && *at >= '0' && *at <= '9')
        at++;
    return at > digits && (at == fields.end || !isalpha((unsigned char)*at));
}

/** A GRID or BEGIN BULK at the beginning of a line. */
static int nastran_recognise(const char *data, int64_t size) {
    io_cursor cursor = io_begin_text(data, size);
    while (cursor.at < cursor.end) {
        const line l = nastran_take_line(&cursor);
        const span name = nastran_trim(l.name);
        if (name.begin == name.end)
            continue;
        const char first = io_upper(*name.begin);
        if (first != 'G' && first != 'B')
            continue;
        if (memchr(data, '\0', (size_t)(name.begin - data)))
            return 0; /* not text, but bytes that spell a word */
        span rest = nastran_trim((span){l.name.end, l.text.end});
        if ((nastran_line_begins(name, "GRID") || nastran_line_begins(name, "GRID*")) &&
            begins_with_number(rest))
            return 1;
        if (nastran_line_begins(l.text, "BEGIN") && l.text.end - nastran_trim(l.text).begin > 5 &&
            nastran_line_begins((span){nastran_trim(l.text).begin + 5, l.text.end}, "BULK"))
            return 1;
    }
    return 0;
}

static const char *const extensions[] = {".bdf", ".nas", ".fem", NULL};

const io_format io_format_nastran = {.name = "nastran",
                                     .extensions = extensions,
                                     .recognise = nastran_recognise,
                                     .read = nastran_read,
                                     .field = nastran_field};
