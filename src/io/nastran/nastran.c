/* nastran: bulk data of Nastran and its like (OptiStruct's .fem), in fixed fields of 8 and of 16
 * columns and in free fields, mixed as they may be.
 *
 * The file is walked card by card: once to count the GRIDs and to meet what cannot be read, once
 * for the GRIDs, once for the elements (which may stand before their GRIDs). Cards that are none of
 * these are passed over; their names are kept, as conversions tell them.
 *
 * A number takes 8 or 16 characters, so that coordinates are rounded to the narrowest field that a
 * GRID of the file has before they are judged.
 */
#include "io/core/format.h"
#include "io/nastran/nastran_card.h"
#include "io/nastran/nastran_write.h"

#include "io/core/elements.h"
#include "io/core/include.h"
#include "io/core/records.h"

#include "base/memory.h"
#include "base/status.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

typedef struct number_range {
    int64_t first, last;
} number_range;

typedef struct reader {
    io_model *model;
    planish_error *error;
    io_cursor bulk;   /* from behind BEGIN BULK to the end or ENDDATA */
    io_cursor *piece; /* [n_pieces] owned: of that, and of included files, in their order */
    int64_t n_pieces, piece_capacity;
    int64_t n_grids;
    int has_short, has_free;        /* GRIDs in fields of 8; in free fields, */
    int has_wide;                   /* some of which have more than 8 characters */
    int64_t default_system, system; /* that of GRDSET, and of the GRIDs */
    int system_is_rectangular;
    number_range *range; /* [n_ranges] owned: numbers of nodes that rigid elements hold */
    int64_t n_ranges, range_capacity;
} reader;

typedef int visit_fn(reader *r, nastran_card *c);

/* ---- kinds of cards ------------------------------------------------------------------------ */

typedef enum kind {
    CELL,    /* kept: lines, triangles by the number of nodes */
    SHAPE,   /* corners, and mids that may be missing */
    RING,    /* the same, as one goes round a triangle: each mid behind a corner */
    NODES,   /* its nodes are held: those from field first on, */
    LISTED,  /* that and all behind it, whole numbers as far as they go */
    PAIRS,   /* fields first and first + 2, each with a component behind it */
    RIGID,   /* LISTED, with components of nodes among them */
    SYSTEM,  /* systems of four fields each: its number and three nodes */
    EQUATION /* MPC: nodes are fields 1 and 4 of each row */
} kind;

typedef struct card_kind {
    const char *name;
    kind kind;
    int first;   /* field of the first node; for cells all nodes are side by side */
    int nodes;   /* how many; 0: as many as there are. Of a shape at most: mids may be missing */
    int corners; /* of a shape */
    io_shape shape;
} card_kind;

static const card_kind kinds[] = {
    {"CTRIA3", CELL, 2, 3, 0, 0},
    {"CTRIAR", CELL, 2, 3, 0, 0},
    {"CTRAX3", CELL, 2, 3, 0, 0},
    {"CPLSTN3", CELL, 2, 3, 0, 0},
    {"CPLSTS3", CELL, 2, 3, 0, 0},
    {"CBAR", CELL, 2, 2, 0, 0},
    {"CBEAM", CELL, 2, 2, 0, 0},
    {"CROD", CELL, 2, 2, 0, 0},
    {"CTUBE", CELL, 2, 2, 0, 0},
    {"CBEND", CELL, 2, 2, 0, 0},
    {"CVISC", CELL, 2, 2, 0, 0},
    {"CONROD", CELL, 1, 2, 0, 0},
    {"PLOTEL", CELL, 1, 2, 0, 0},
    {"CTETRA", SHAPE, 2, 10, 4, IO_TETRAHEDRON},
    {"CHEXA", SHAPE, 2, 20, 8, IO_HEXAHEDRON},
    {"CPENTA", SHAPE, 2, 15, 6, IO_PRISM},
    {"CPYRAM", SHAPE, 2, 13, 5, IO_PYRAMID},
    {"CPYRA", SHAPE, 2, 13, 5, IO_PYRAMID},
    {"CTRIA6", SHAPE, 2, 6, 3, IO_TRIANGLE},
    {"CPLSTN6", SHAPE, 2, 6, 3, IO_TRIANGLE},
    {"CPLSTS6", SHAPE, 2, 6, 3, IO_TRIANGLE},
    {"CTRIAX", SHAPE, 2, 6, 3, IO_TRIANGLE},
    {"CTRIAX6", RING, 2, 6, 3, IO_TRIANGLE},
    {"CTRAX6", RING, 2, 6, 3, IO_TRIANGLE},
    {"CQUAD4", SHAPE, 2, 4, 4, IO_QUADRILATERAL},
    {"CQUADR", SHAPE, 2, 4, 4, IO_QUADRILATERAL},
    {"CSHEAR", SHAPE, 2, 4, 4, IO_QUADRILATERAL},
    {"CPLSTN4", SHAPE, 2, 4, 4, IO_QUADRILATERAL},
    {"CPLSTS4", SHAPE, 2, 4, 4, IO_QUADRILATERAL},
    {"CQUAD8", SHAPE, 2, 8, 4, IO_QUADRILATERAL},
    {"CPLSTN8", SHAPE, 2, 8, 4, IO_QUADRILATERAL},
    {"CPLSTS8", SHAPE, 2, 8, 4, IO_QUADRILATERAL},
    {"CQUAD", SHAPE, 2, 9, 4, IO_QUADRILATERAL},
    {"CQUADX", SHAPE, 2, 9, 4, IO_QUADRILATERAL},
    {"CGAP", NODES, 2, 3, 0, 0},
    {"CBUSH", NODES, 2, 3, 0, 0},
    {"CBEAM3", NODES, 2, 4, 0, 0},
    {"CONM1", NODES, 1, 1, 0, 0},
    {"CONM2", NODES, 1, 1, 0, 0},
    {"CELAS1", PAIRS, 2, 0, 0, 0},
    {"CELAS2", PAIRS, 2, 0, 0, 0},
    {"CDAMP1", PAIRS, 2, 0, 0, 0},
    {"CDAMP2", PAIRS, 2, 0, 0, 0},
    {"CMASS1", PAIRS, 2, 0, 0, 0},
    {"CMASS2", PAIRS, 2, 0, 0, 0},
    {"RROD", NODES, 1, 2, 0, 0},
    {"RBAR", NODES, 1, 2, 0, 0},
    {"RBE1", LISTED, 1, 0, 0, 0},
    {"RBE2", RIGID, 1, 0, 0, 0},
    {"RBE3", RIGID, 2, 0, 0, 0},
    {"RSPLINE", LISTED, 1, 0, 0, 0},
    {"RTRPLT", LISTED, 1, 0, 0, 0},
    {"MPC", EQUATION, 1, 0, 0, 0},
    {"RBAR1", NODES, 1, 2, 0, 0},
    {"RJOINT", NODES, 1, 2, 0, 0},
    {"CORD1R", SYSTEM, 0, 8, 0, 0},
    {"CORD1C", SYSTEM, 0, 8, 0, 0},
    {"CORD1S", SYSTEM, 0, 8, 0, 0},
    {"CORD3R", SYSTEM, 0, 8, 0, 0},
};

/** Beginnings of names of cards that are no elements. */
static const char *const no_elements[] = {"CORD",  "CAERO",  "CSET",   "CREEP", "CY",    "CSUP",
                                          "CLOAD", "CBARAO", "CSSCHD", "CONV",  "CONTR", "CLUSTER",
                                          "RAD",   "RAND",   "RCROSS", "RELEA", "RESV",  "RFORCE",
                                          "RGYRO", "RING",   "RLOAD",  "ROTOR", "RSPIN", "RVDOF"};

/** Find the row of a card in the table, or NULL. */
static const card_kind *find_kind(const char *name) {
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (strcmp(name, kinds[i].name) == 0)
            return &kinds[i];
    return NULL;
}

static int is_named(const nastran_card *c, const char *name) {
    return strcmp(c->name, name) == 0;
}

/* ---- numbers and errors -------------------------------------------------------------------- */

static int fail_card(const reader *r, const nastran_card *c, const char *what) {
    return io_fail_at(r->model, c->line.text.begin, r->error, "%s: %s", c->name, what);
}

/** Note a card that no conversion carries over. */
static int note_not_carried(reader *r, nastran_card *c) {
    return io_names_add(&r->model->not_carried, c->name, (int64_t)strlen(c->name))
               ? PLANISH_OK
               : pl_fail_memory(r->error, "the cards of the file");
}

/** Read a whole number, 0 if the field is empty. Return 0, or -1 if it is none. */
static int parse_number(io_slice field, int64_t *value) {
    *value = 0;
    return field.begin == field.end ? 0 : io_slice_integer(field, value);
}

/** Take a field that must be a whole number of 32 bits, not negative. */
static int take_number(const reader *r, nastran_card *c, const char *what, int64_t *value) {
    io_slice field = {NULL, NULL};
    *value = 0;
    if (!nastran_take_field(c, &field) || field.begin == field.end)
        return io_fail_at(r->model, c->line.text.begin, r->error,
                          "%s: %s is missing (the file may be cut short)", c->name, what);
    if (parse_number(field, value) || *value < 0 || *value > INT32_MAX)
        return io_fail_at(r->model, field.begin, r->error,
                          "%s: %s is '%.*s', not a whole number from 0 to %d", c->name, what,
                          IO_QUOTED(field), INT32_MAX);
    return PLANISH_OK;
}

/* ---- walks --------------------------------------------------------------------------------- */

/** Visit the cards of a piece whose names begin with one of the letters; a blank among these: check
 *  lines that begin with one. */
static int walk_piece(reader *r, io_cursor cursor, const char *letters, visit_fn *visit) {
    int status = PLANISH_OK;
    nastran_card c;
    while (!status && cursor.at < cursor.end) {
        if (!*cursor.at || !strchr(letters, io_upper(*cursor.at))) {
            io_next_line(&cursor);
        } else if (io_is_blank(*cursor.at)) {
            /* The line goes on with the card before it. The name of a card that is read, in the
             * columns of names, means something else. */
            const nastran_line l = nastran_take_line(&cursor);
            const io_slice text = io_slice_trim(l.text);
            char name[NASTRAN_NAME_SIZE];
            nastran_take_name(text, name);
            const int is_read =
                find_kind(name) || strcmp(name, "GRID") == 0 || strcmp(name, "GRDSET") == 0;
            if (is_read && text.begin - l.text.begin < NASTRAN_NAME_COLUMNS)
                status = io_fail_at(r->model, text.begin, r->error,
                                    "%s behind blanks: a card begins in the first column of its "
                                    "line (take the blanks away)",
                                    name);
        } else if (nastran_take_card(&cursor, &c)) {
            status = visit(r, &c);
            /* What a reader made of such fields, an error perhaps, says nothing. */
            if (c.n > 0 && c.wrong)
                status = io_fail_at(r->model, c.wrong_at, r->error, "%s: %s", c.name, c.wrong);
        }
    }
    return status;
}

/** Visit the cards of all pieces. */
static int walk(reader *r, const char *letters, visit_fn *visit) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < r->n_pieces && !status; i++)
        status = walk_piece(r, r->piece[i], letters, visit);
    return status;
}

/* ---- included files ------------------------------------------------------------------------ */

/** Find the next line that begins with word, or the end. *after: behind it. */
static const char *find_line(io_cursor cursor, const char *word, const char **after) {
    while (cursor.at < cursor.end) {
        const io_slice text = io_next_line(&cursor);
        *after = cursor.at;
        if (text.begin < text.end && (io_upper(*text.begin) == *word || io_is_blank(*text.begin)) &&
            nastran_line_begins(text, word))
            return text.begin;
    }
    return *after = cursor.end;
}

/** Find the name between quotes in INCLUDE 'NAME'; without quotes the word behind. */
static io_slice name_of(io_slice line) {
    static const char word[] = "INCLUDE";
    io_slice name = io_slice_trim(line);
    name = io_slice_trim((io_slice){name.begin + sizeof word - 1, name.end});
    const char quote = name.begin < name.end ? *name.begin : '\0';
    if (quote != '\'' && quote != '"')
        return name;
    name.begin++;
    name.end = io_slice_find(name, quote);
    return name;
}

static int add_piece(reader *r, const char *begin, const char *end) {
    const io_cursor piece = {begin, end};
    return pl_append(&r->piece, &r->n_pieces, &r->piece_capacity, &piece, sizeof piece)
               ? PLANISH_OK
               : pl_fail_memory(r->error, "the pieces of the file");
}

/** Part content at its INCLUDE lines, with the pieces of the included files between. */
static int find_pieces(reader *r, io_cursor content, int depth) {
    enum { MOST_DEPTH = 8 };
    int status = PLANISH_OK;
    const char *after, *begin = content.at;
    while (!status) {
        const char *at = find_line((io_cursor){begin, content.end}, "INCLUDE", &after);
        status = add_piece(r, begin, at);
        if (at == content.end || status)
            return status;
        io_cursor line = {at, content.end}, included;
        if (depth == MOST_DEPTH)
            return io_fail_at(r->model, at, r->error, "files include one another too deeply");
        status = io_include_open(r->model, at, name_of(io_next_line(&line)), &included, r->error);
        if (status)
            return status;
        included.end = find_line(included, "ENDDATA", &begin);
        status = find_pieces(r, included, depth + 1);
        begin = after;
    }
    return status;
}

/* ---- first walk: counting ----------------------------------------------------------------- */

static int count_card(reader *r, nastran_card *c) {
    io_slice field;
    if (is_named(c, "BEGIN"))
        return fail_card(r, c, "superelements are not read; smooth each in a file of its own");
    if (c->name[0] == '=')
        return fail_card(r, c, nastran_no_replication);
    if (is_named(c, "GRID") && io_include_has(r->model, c->line.text.begin))
        return io_include_fail_node(r->model, c->line.text.begin, r->error);
    if (is_named(c, "GRID")) {
        r->n_grids++;
        if (!c->line.is_long)
            *(c->line.is_free ? &r->has_free : &r->has_short) = 1;
        while (c->line.is_free && c->n < NASTRAN_FIRST_COORDINATE + 3 &&
               nastran_take_field(c, &field))
            if (c->n > NASTRAN_FIRST_COORDINATE && io_slice_length(field) > NASTRAN_SHORT_FIELD)
                r->has_wide = 1;
    }
    if (is_named(c, "GRDSET"))
        while (c->n < NASTRAN_FIRST_COORDINATE && nastran_take_field(c, &field))
            if (c->n == NASTRAN_FIRST_COORDINATE && parse_number(field, &r->default_system))
                return fail_card(r, c, "the coordinate system is not a whole number");
    return is_named(c, "GRID") ? PLANISH_OK : note_not_carried(r, c);
}

/* ---- second walk: grids ------------------------------------------------------------------- */

static int read_grid(reader *r, nastran_card *c) {
    io_model *model = r->model;
    io_slice field = {NULL, NULL};
    int64_t number, system = 0;
    if (!is_named(c, "GRID"))
        return PLANISH_OK;
    int status = take_number(r, c, "its number", &number);
    if (status)
        return status;
    if (nastran_take_field(c, &field) && parse_number(field, &system))
        return fail_card(r, c, "the coordinate system is not a whole number");
    system = field.begin == field.end ? r->default_system : system;
    if (model->n_nodes == 0)
        r->system = system;
    if (system != r->system)
        return io_fail_at(model, c->line.text.begin, r->error,
                          "GRIDs are in coordinate systems %lld and %lld; write all of them in "
                          "one, the basic system (0), as preprocessors can",
                          (long long)r->system, (long long)system);
    status = io_nodes_next(model, number, nastran_line_field(c).begin, r->error);
    for (int d = 0; d < 3 && !status && nastran_take_field(c, &field); d++)
        status = io_nodes_coordinate(model, d, field, r->error);
    return status;
}

/** Note whether a card makes a rectangular system with the number of that of the GRIDs. */
static int read_system(reader *r, nastran_card *c) {
    const int by_grids = is_named(c, "CORD1R");
    if (!by_grids && !is_named(c, "CORD2R"))
        return PLANISH_OK;
    io_slice field;
    int64_t number;
    while (c->n < (by_grids ? NASTRAN_SHORT_FIELDS : 1) && nastran_take_field(c, &field))
        if ((c->n - 1) % 4 == 0 && field.begin < field.end && !parse_number(field, &number))
            r->system_is_rectangular |= number == r->system;
    return PLANISH_OK;
}

static int read_grids(reader *r) {
    io_model *model = r->model;
    /* Free fields are as wide as the narrowest field of the file, or as those that the file has. */
    const int is_short = r->has_short || (r->has_free && !r->has_wide);
    model->exponent = IO_EXPONENT_IMPLIED;
    int status = io_nodes_begin(model, r->n_grids,
                                is_short ? NASTRAN_SHORT_FIELD : NASTRAN_LONG_FIELD, r->error);
    if (!status)
        status = walk(r, "G", read_grid);
    /* Lengths and angles are in a rectangular system what they are in any other. */
    if (!status && r->system != 0) {
        status = walk(r, "C", read_system);
        if (!status && !r->system_is_rectangular)
            status = pl_fail(r->error, PLANISH_ERROR_FORMAT,
                             "%s: the GRIDs are in coordinate system %lld, and no CORD1R or CORD2R "
                             "says that it is rectangular; write them in the basic system (0), as "
                             "preprocessors can",
                             model->input.path, (long long)r->system);
    }
    return status ? status : io_nodes_end(model, r->error);
}

/* ---- third walk: elements ----------------------------------------------------------------- */

/** Hold the node that the field names, if it does: other fields are there, too. Return the field's
 *  number, 0 if it is none. */
static int64_t hold_field(reader *r, io_slice field, uint8_t reason) {
    int64_t number;
    if (field.begin == field.end || parse_number(field, &number))
        return 0;
    const int64_t index = io_node_index(r->model, number);
    if (index >= 0)
        io_hold_node(r->model, index, reason);
    return number;
}

/** Take the number of an element and its property, 0 if it is left out: Nastran takes one of the
 *  element's number then, but who leaves it out means one region. */
static int take_numbers(const reader *r, const card_kind *k, nastran_card *c, int64_t *number,
                        int64_t *property) {
    io_slice field;
    *property = 0;
    const int status = take_number(r, c, "its number", number);
    if (status || k->first != 2)
        return status;
    nastran_card ahead = *c;
    if (nastran_take_field(&ahead, &field) && field.begin == field.end) {
        *c = ahead;
        return PLANISH_OK;
    }
    return take_number(r, c, "its property", property);
}

/** Take a field that must name a node of element number. */
static int take_node(const reader *r, nastran_card *c, int64_t number, int32_t *index) {
    int64_t node;
    const int status = take_number(r, c, "a node", &node);
    if (status)
        return status;
    *index = (int32_t)io_node_index(r->model, node);
    return *index < 0
               ? io_fail_no_node(r->model, c->line.text.begin, c->name, number, node, r->error)
               : PLANISH_OK;
}

/** Take a field that may name a mid of element number; -1: it is empty or 0. *is_over: the card
 *  ends, or goes on with a word (CORDM behind the nodes of solids). */
static int take_mid(const reader *r, nastran_card *c, int64_t number, int32_t *index,
                    int *is_over) {
    io_slice field;
    int64_t node;
    *index = -1;
    *is_over = !nastran_take_field(c, &field) ||
               (field.begin < field.end && isalpha((unsigned char)*field.begin));
    if (*is_over)
        return PLANISH_OK;
    if (parse_number(field, &node) || node < 0)
        return io_fail_at(r->model, field.begin, r->error,
                          "%s %lld: '%.*s' is not the number of a mid-side node", c->name,
                          (long long)number, IO_QUOTED(field));
    *index = node ? (int32_t)io_node_index(r->model, node) : -1;
    return node && *index < 0
               ? io_fail_no_node(r->model, c->line.text.begin, c->name, number, node, r->error)
               : PLANISH_OK;
}

/** Find the entity of a property for the next element of a list: those of one property stand together
 *  most often. Negative on failure. */
static int32_t entity_of(const reader *r, int number, int64_t property) {
    const io_list list = io_model_list(r->model, number);
    const int32_t entity = list.n > 0 ? list.entity[list.n - 1] : -1;
    return entity >= 0 && r->model->entity[entity].tag == property
               ? entity
               : io_model_entity(r->model, list.dim, (int32_t)property, 0, NULL, r->error);
}

/** Add a line, triangle or tetrahedron: its corners, and its mids if it has any. */
static int add_cell(const reader *r, int dim, int has_mids, const int32_t *nodes, int64_t number,
                    int64_t property) {
    const int32_t entity = entity_of(r, dim, property);
    return entity < 0 ? entity
                      : io_model_add_simplex(r->model, io_simplex_type(dim, has_mids), nodes,
                                             entity, number, r->error);
}

static int read_cell(reader *r, const card_kind *k, nastran_card *c) {
    int32_t nodes[3];
    int64_t number, property;
    io_slice field;
    int status = take_numbers(r, k, c, &number, &property);
    for (int j = 0; j < k->nodes && !status; j++)
        status = take_node(r, c, number, &nodes[j]);
    if (!status)
        status = add_cell(r, k->nodes - 1, 0, nodes, number, property);
    /* The field behind the nodes of CBAR, CBEAM, CBEND names a node that the cross section points
     * to, if it is no component of a vector (a real number). */
    if (!status && c->name[1] == 'B' && nastran_take_field(c, &field))
        hold_field(r, field, IO_HELD_REQUIRED);
    return status;
}

/** Read an element of which mids may be missing. */
static int read_shape(reader *r, const card_kind *k, nastran_card *c) {
    int32_t nodes[IO_CELL_NODES];
    int64_t number, property;
    int has_mids = 0, is_over = 0;
    int status = take_numbers(r, k, c, &number, &property);
    for (int j = 0; j < IO_CELL_NODES; j++)
        nodes[j] = -1;
    for (int j = 0; j < k->nodes && !status; j++) {
        const int place = k->kind == SHAPE ? j : j / 2 + (j % 2) * k->corners;
        if (place < k->corners)
            status = take_node(r, c, number, &nodes[place]);
        else if (!is_over)
            status = take_mid(r, c, number, &nodes[place], &is_over);
        has_mids |= place >= k->corners && nodes[place] >= 0;
    }
    if (status)
        return status;
    if (k->shape == IO_TRIANGLE || k->shape == IO_TETRAHEDRON)
        return add_cell(r, k->corners - 1, has_mids, nodes, number, property);
    const int n = has_mids ? k->nodes : k->corners;
    int type = io_cell_type((int)k->shape, n);
    if (nodes[n - 1] < 0) /* CQUAD without a node inside */
        type = io_cell_type_without_faces(type);
    const int32_t entity =
        entity_of(r, io_others_list(k->shape == IO_QUADRILATERAL ? 2 : 3), property);
    r->model->n_other++;
    return entity < 0 ? entity
                      : io_model_add_other(r->model, type, nodes, entity, number, r->error);
}

/** Return whether the field at place names a node; follows_real: the one before it is a real
 *  number (RBE3: a weight, behind which components stand). */
static int names_node(const card_kind *k, int64_t place, int follows_real) {
    switch (k->kind) {
    case EQUATION:
        return place % NASTRAN_SHORT_FIELDS == 1 || place % NASTRAN_SHORT_FIELDS == 4;
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

static int hold_fields(reader *r, const card_kind *k, nastran_card *c) {
    const int is_element = c->name[0] == 'C' && k->kind != SYSTEM;
    const uint8_t reason = is_element ? IO_HELD_BY_OTHER : IO_HELD_REQUIRED;
    int follows_real = 0, is_thru = 0;
    int64_t number = 0, last; /* of the last node that was named */
    io_slice field;
    while ((k->nodes == 0 || c->n < k->first + k->nodes) && nastran_take_field(c, &field)) {
        const int is_node = names_node(k, c->n - 1, follows_real);
        /* first THRU last: the nodes between these, too; see hold_ranges. */
        if (is_thru && !parse_number(field, &last) && last > number) {
            const number_range range = {number, last};
            if (!pl_append(&r->range, &r->n_ranges, &r->range_capacity, &range, sizeof range))
                return pl_fail_memory(r->error, "the nodes of rigid elements");
        }
        is_thru = is_node && nastran_line_begins(field, "THRU");
        if (is_node && !is_thru)
            number = hold_field(r, field, reason);
        follows_real = io_slice_find(field, '.') < field.end;
    }
    r->model->n_other += is_element;
    return PLANISH_OK;
}

static int read_element(reader *r, nastran_card *c) {
    /* Elements that are not in the table: number, property, nodes; and rigid ones: number, nodes. */
    static const card_kind other_element = {"C...", LISTED, 2, 0, 0, 0},
                           other_rigid = {"R...", LISTED, 1, 0, 0, 0};
    const card_kind *k = find_kind(c->name);
    if (k && (k->kind == SHAPE || k->kind == RING))
        return read_shape(r, k, c);
    if (k && k->kind == CELL)
        return read_cell(r, k, c);
    if (note_not_carried(r, c))
        return PLANISH_ERROR_MEMORY;
    if (!k && c->name[0] != 'C' && c->name[0] != 'R')
        return PLANISH_OK;
    for (size_t i = 0; !k && i < sizeof no_elements / sizeof *no_elements; i++)
        if (strncmp(c->name, no_elements[i], strlen(no_elements[i])) == 0)
            return PLANISH_OK;
    if (!k)
        k = c->name[0] == 'C' ? &other_element : &other_rigid;
    return hold_fields(r, k, c);
}

static int compare_ranges(const void *a, const void *b) {
    const number_range *p = a, *q = b;
    return (p->first > q->first) - (p->first < q->first);
}

/** Compare a number to a range that it may be in. */
static int compare_to_range(const void *number, const void *range) {
    const int64_t n = *(const int64_t *)number;
    const number_range *r = range;
    return (n > r->last) - (n < r->first);
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
        const int64_t number = io_node_number(r->model, node);
        if (bsearch(&number, r->range, (size_t)n, sizeof *r->range, compare_to_range))
            io_hold_node(r->model, node, IO_HELD_REQUIRED);
    }
}

/* ---- names -------------------------------------------------------------------------------- */

/** Read $HMNAME PROP 5"steel" (HyperMesh), the name of property 5. */
static int read_names(reader *r, io_cursor cursor) {
    static const char mark[] = "$HMNAME PROP";
    const int64_t length = sizeof mark - 1;
    while (cursor.at < cursor.end) {
        const io_slice text = io_next_line(&cursor);
        if (io_slice_length(text) < length || memcmp(text.begin, mark, (size_t)length) != 0)
            continue;
        const char *open = io_slice_find(text, '"');
        const io_slice name = {open < text.end ? open + 1 : open,
                               io_slice_find((io_slice){open + (open < text.end), text.end}, '"')};
        int64_t number;
        if (name.end == text.end ||
            parse_number(io_slice_trim((io_slice){text.begin + length, open}), &number) ||
            number < 1 || number > INT32_MAX)
            continue;
        for (int dim = 1; dim <= 3; dim++) {
            const int status = io_model_has_entity(r->model, dim, (int32_t)number)
                                   ? io_model_group(r->model, dim, (int32_t)number, name.begin,
                                                    io_slice_length(name), r->error)
                                   : PLANISH_OK;
            if (status)
                return status;
        }
    }
    return PLANISH_OK;
}

/* ---- the file ----------------------------------------------------------------------------- */

/** Read what the pieces say. */
static int read_pieces(reader *r) {
    const io_model *model = r->model;
    const char *end = io_input_end(model);
    int status = walk(r, "GB= \t", count_card);
    if (status)
        return status;
    if (r->n_grids == 0)
        return io_fail_at(model, r->bulk.end, r->error,
                          "there is no GRID: this is not a Nastran mesh, or it is cut short");
    /* Programs end their files with ENDDATA, or the last line at least. Without either a card may
     * be incomplete that looks whole. */
    if (r->bulk.end == end && end[-1] != '\n' && end[-1] != '\r')
        return io_fail_at(model, end, r->error,
                          "there is no ENDDATA, and the last line has no line end: the file is "
                          "probably cut short (if it is complete, add ENDDATA or a line end)");
    status = read_grids(r);
    if (!status)
        status = walk(r, "CRMP", read_element);
    if (!status)
        hold_ranges(r);
    if (!status) /* all letters that no walk before had */
        status = walk(r, "ADEFHIJKLNOQSTUVWXYZ", note_not_carried);
    for (int64_t i = 0; i < r->n_pieces && !status; i++)
        status = read_names(r, r->piece[i]);
    return status;
}

static int nastran_read(io_model *model, planish_error *error) {
    reader r = {.model = model, .error = error};
    model->node_order = nastran_node_orders;
    const char *end = io_input_end(model), *after;
    r.bulk = io_begin_text(model->input.data, model->input.size);
    if (find_line(r.bulk, "BEGIN", &after) < end)
        r.bulk.at = after;
    r.bulk.end = find_line(r.bulk, "ENDDATA", &after);
    int status = find_pieces(&r, r.bulk, 0);
    if (!status)
        status = read_pieces(&r);
    for (int dim = 1; dim <= 3; dim++)
        io_reduce_cell_numbers(io_model_cells(model, dim));
    pl_free(r.range);
    pl_free(r.piece);
    io_include_close(model);
    return status;
}

/** Find a GRID or BEGIN BULK at the beginning of a line. */
static int nastran_recognise(const char *data, int64_t size) {
    io_cursor cursor = io_begin_text(data, size);
    const char *looked_at = data; /* no '\0' is before it */
    while (cursor.at < cursor.end) {
        const nastran_line l = nastran_take_line(&cursor);
        const io_slice name = io_slice_trim(l.name), text = io_slice_trim(l.text);
        const char first = name.begin < name.end ? io_upper(*name.begin) : '\0';
        if (first != 'G' && first != 'B')
            continue;
        if (memchr(looked_at, '\0', (size_t)(name.begin - looked_at)))
            return 0; /* not text, but bytes that spell a word */
        looked_at = name.begin;
        if (nastran_line_begins(l.text, "BEGIN") && io_slice_length(text) > 5 &&
            nastran_line_begins((io_slice){text.begin + 5, text.end}, "BULK"))
            return 1;
        if (!nastran_line_begins(name, "GRID") && !nastran_line_begins(name, "GRID*"))
            continue;
        /* The first field must be a whole number: a title may begin with the name of a card. */
        io_slice fields = io_slice_trim((io_slice){l.name.end, l.text.end});
        fields.begin += fields.begin < fields.end && *fields.begin == ',';
        fields = io_slice_trim(fields);
        const char *at = fields.begin;
        while (at < fields.end && *at >= '0' && *at <= '9')
            at++;
        if (at > fields.begin && (at == fields.end || !isalpha((unsigned char)*at)))
            return 1;
    }
    return 0;
}

static const char *const extensions[] = {".bdf", ".nas", ".fem", NULL};

const io_format io_format_nastran = {.name = "nastran",
                                     .extensions = extensions,
                                     .recognise = nastran_recognise,
                                     .read = nastran_read,
                                     .field = nastran_field,
                                     .targets = nastran_targets};
