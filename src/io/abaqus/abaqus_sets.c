/* abaqus_sets: sets of elements and nodes in an Abaqus input file.
 *
 * An element or node may be in any number of sets, so that what it is of is an entity with one
 * physical group for each of them. Regions are told by less: by the ELSET= of *ELEMENT and by the
 * section that has the element, as sets are also made for loads and for output. Names are those of
 * a part or of the assembly: a set of the same name there is another.
 */
#include "io/abaqus/abaqus_sets.h"

#include "io/core/number.h"
#include "io/core/records.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdlib.h>
#include <string.h>

/* ---- names -------------------------------------------------------------------------------- */

/** Letters in quotes are what they are; other names are read as if in capitals. fold: all are. */
static char letter(const char *at, int is_quoted, int fold) {
    return is_quoted && !fold ? *at : io_upper(*at);
}

static int same_name(abaqus_span a, abaqus_span b, int fold) {
    const int a_quoted = abaqus_is_quoted(a), b_quoted = abaqus_is_quoted(b);
    a = abaqus_unquoted(a);
    b = abaqus_unquoted(b);
    if (a.end - a.begin != b.end - b.begin)
        return 0;
    for (int64_t i = 0; i < a.end - a.begin; i++)
        if (letter(a.begin + i, a_quoted, fold) != letter(b.begin + i, b_quoted, fold))
            return 0;
    return 1;
}

static uint64_t hash_name(set_kind things, int32_t scope, abaqus_span name, int fold) {
    uint64_t hash = 14695981039346656037u + 2 * (uint64_t)(uint32_t)scope + (uint64_t)things;
    const int is_quoted = abaqus_is_quoted(name);
    name = abaqus_unquoted(name);
    for (const char *c = name.begin; c < name.end; c++)
        hash = (hash ^ (uint64_t)(unsigned char)letter(c, is_quoted, fold)) * 1099511628211u;
    return hash ^ hash >> 29;
}

/** The slot of the set, or the free one where it belongs. */
static int32_t *find_slot(const sets *s, set_kind things, int32_t scope, abaqus_span name,
                          int fold) {
    const uint64_t mask = (uint64_t)s->n_slots - 1;
    uint64_t at = hash_name(things, scope, name, fold) & mask;
    for (;; at = (at + 1) & mask) {
        int32_t *slot = &s->slot[fold][at];
        const named_set *set = *slot < 0 ? NULL : &s->set[*slot];
        if (!set ||
            (set->things == things && set->scope == scope && same_name(set->name, name, fold)))
            return slot;
    }
}

static void put_into_slots(sets *s, int32_t index) {
    const named_set *set = &s->set[index];
    for (int fold = 0; fold < 2; fold++) {
        int32_t *slot = find_slot(s, set->things, set->scope, set->name, fold);
        *slot = *slot < 0 ? index : *slot;
    }
}

static int grow_slots(sets *s) {
    enum { FIRST_SLOTS = 64 };
    if (2 * s->n_sets < s->n_slots)
        return PLANISH_OK;
    const int64_t n_slots = s->n_slots ? 2 * s->n_slots : FIRST_SLOTS;
    for (int fold = 0; fold < 2; fold++) {
        pl_free(s->slot[fold]);
        s->slot[fold] = pl_alloc(n_slots, sizeof *s->slot[fold]);
        if (!s->slot[fold])
            return pl_fail_memory(s->reader->error, "the sets of the file");
        memset(s->slot[fold], -1, (size_t)n_slots * sizeof *s->slot[fold]);
    }
    s->n_slots = n_slots;
    for (int64_t i = 0; i < s->n_sets; i++)
        put_into_slots(s, (int32_t)i);
    return PLANISH_OK;
}

int32_t abaqus_find_set(const sets *s, set_kind things, int32_t scope, abaqus_span name) {
    if (s->n_slots == 0)
        return -1;
    const int32_t set = *find_slot(s, things, scope, name, 0);
    return set >= 0 ? set : *find_slot(s, things, scope, name, 1);
}

/** Index of the set that an item of a block names, or -1. INSTANCE.NAME, and any name behind
 *  INSTANCE=, is the mesh's own; other names are of where the block is, or else, as some programs
 *  write them, the mesh's or the assembly's. */
static int32_t find_named(const sets *s, const abaqus_block *b, set_kind things, abaqus_span item) {
    const int32_t mesh = s->reader->scope;
    abaqus_span local = item;
    const int is_of_mesh = abaqus_local(s->reader, b, &local);
    int32_t set = is_of_mesh ? abaqus_find_set(s, things, mesh, local) : -1;
    set = set < 0 ? abaqus_find_set(s, things, b->scope, item) : set;
    set = set < 0 ? abaqus_find_set(s, things, mesh, local) : set;
    return set < 0 ? abaqus_find_set(s, things, ABAQUS_IN_ASSEMBLY, local) : set;
}

/** Index of the set of just that name, made if new; negative on failure. */
static int32_t make_set(sets *s, set_kind things, int32_t scope, abaqus_span name) {
    int status = grow_slots(s);
    if (status)
        return status;
    const int32_t found = *find_slot(s, things, scope, name, 0);
    if (found >= 0)
        return found;
    named_set *grown = pl_grow(s->set, s->n_sets, s->n_sets + 1, &s->capacity, sizeof *grown);
    if (!grown)
        return pl_fail_memory(s->reader->error, "the sets of the file");
    s->set = grown;
    s->set[s->n_sets] = (named_set){.things = things, .scope = scope, .name = name};
    put_into_slots(s, (int32_t)s->n_sets);
    return (int32_t)s->n_sets++;
}

/* ---- members ------------------------------------------------------------------------------ */

static int add_member(sets *s, int32_t set, int32_t member) {
    named_set *to = &s->set[set];
    int32_t *stamp = &s->stamp[to->things][member];
    if (*stamp == set + 1)
        return PLANISH_OK;
    int32_t *grown = pl_grow(to->member, to->n, to->n + 1, &to->capacity, sizeof *grown);
    if (!grown)
        return pl_fail_memory(s->reader->error, "the members of sets");
    to->member = grown;
    to->member[to->n++] = member;
    *stamp = set + 1;
    return PLANISH_OK;
}

static int64_t cell_number(const io_cells *cells, int64_t cell) {
    return cells->number ? cells->number[cell] : cells->first_number + cell;
}

int abaqus_dim_of(const sets *s, int64_t cell, int64_t *local) {
    int dim = 3;
    while (dim > 1 && cell < s->first_cell[dim])
        dim--;
    *local = cell - s->first_cell[dim];
    return dim;
}

static int64_t number_of(const sets *s, set_kind things, int64_t thing) {
    io_model *model = s->reader->model;
    int64_t local;
    if (things == NODES)
        return model->node_number ? model->node_number[thing] : model->first_number + thing;
    const int dim = abaqus_dim_of(s, thing, &local);
    return cell_number(io_model_cells(model, dim), local);
}

static int number_elements(sets *s) {
    int64_t *number = pl_alloc(s->n[ELEMENTS], sizeof *number);
    if (!number)
        return pl_fail_memory(s->reader->error, "the numbers of elements");
    for (int64_t i = 0; i < s->n[ELEMENTS]; i++)
        number[i] = number_of(s, ELEMENTS, i);
    int status = io_numbers_create(s->reader->model->input.path, "element", number, s->n[ELEMENTS],
                                   &s->elements, s->reader->error);
    pl_free(number);
    return status;
}

/** Index of the thing of that number, or -1: there is none, or it is no cell that is kept. */
static int64_t find_thing(const sets *s, set_kind things, int64_t number) {
    return things == NODES ? io_node_index(s->reader->model, s->reader->numbers, number)
                           : io_numbers_find(s->elements, number);
}

/** A line at that place asks for n members. A few bytes can ask for all things that there are, and
 *  a file that does so again and again for the square of its size. */
static int ask_for(sets *s, const char *at, int64_t n) {
    enum { PER_BYTE = 8, SMALLEST = 1000000 };
    const int64_t most = SMALLEST + PER_BYTE * s->reader->model->input.size;
    s->n_asked += n;
    if (s->n_asked <= most)
        return PLANISH_OK;
    return io_fail_at(s->reader->model, at, s->reader->error,
                      "the sets have more than %lld members, too many for a file of this size: "
                      "sets or sequences stand in others over and over",
                      (long long)most);
}

static int add_number(sets *s, int32_t set, int64_t number) {
    const int64_t thing = find_thing(s, s->set[set].things, number);
    return thing < 0 ? PLANISH_OK : add_member(s, set, (int32_t)thing);
}

/** at: where the file says so. */
static int add_set(sets *s, int32_t set, int32_t from, const char *at) {
    named_set *f = &s->set[from];
    if (from == set || (f->last_into == set + 1 && f->last_n == f->n))
        return PLANISH_OK;
    int status = ask_for(s, at, f->n);
    for (int64_t i = 0; i < f->n && !status; i++)
        status = add_member(s, set, f->member[i]);
    f->last_into = set + 1;
    f->last_n = f->n;
    return status;
}

static int fail_item(const sets *s, abaqus_span item, const char *text) {
    const int64_t length = item.end - item.begin;
    return io_fail_at(s->reader->model, item.begin, s->reader->error, "'%.*s': %s",
                      (int)(length < 32 ? length : 32), item.begin, text);
}

/** A whole number, also one that is written as a real one, as meshio does it. 0 or -1. */
static int whole_number(abaqus_span item, int64_t *number) {
    const char *at = item.begin;
    double value;
    if (abaqus_integer(item, number) == 0)
        return 0;
    if (io_parse_real(&at, item.end, &value) || at != item.end || !(value >= 0) ||
        value > INT32_MAX || value != (double)(int64_t)value)
        return -1;
    *number = (int64_t)value;
    return 0;
}

/** A number, or the name of a set that is there already. */
static int add_item(sets *s, const abaqus_block *b, int32_t set, abaqus_span item) {
    int64_t number;
    abaqus_span local = item;
    const int is_here = abaqus_local(s->reader, b, &local);
    const int is_integer = abaqus_integer(local, &number) == 0;
    const int32_t from = is_integer ? -1 : find_named(s, b, s->set[set].things, item);
    if (is_integer || (from < 0 && whole_number(local, &number) == 0))
        return is_here ? add_number(s, set, number) : PLANISH_OK;
    if (from < 0)
        return fail_item(s, item,
                         "neither a number nor the name of a set that is defined before (sets "
                         "must stand before those that they are part of)");
    return add_set(s, set, from, item.begin);
}

/** GENERATE: first, last, step. */
static int add_sequence(sets *s, const abaqus_block *b, int32_t set, abaqus_span line) {
    int64_t number[3] = {0, 0, 1};
    abaqus_span item = line, rest = line;
    const set_kind things = s->set[set].things;
    int is_here = 1, status = PLANISH_OK;
    for (int i = 0; i < 3 && abaqus_item(&rest, &item); i++) {
        if (i > 0 && item.begin == item.end)
            continue;
        is_here = abaqus_local(s->reader, b, &item);
        if (whole_number(item, &number[i]) || number[i] < 0 || number[i] > INT32_MAX)
            return fail_item(s, item, "a number was expected (GENERATE: first, last, step)");
    }
    const int64_t first = number[0], last = number[1], step = number[2] > 0 ? number[2] : 1;
    if (!is_here || last < first)
        return PLANISH_OK;
    const int64_t n_numbers = (last - first) / step + 1;
    status = ask_for(s, line.begin, n_numbers < s->n[things] ? n_numbers : s->n[things]);
    if (n_numbers <= s->n[things]) {
        for (int64_t i = first; i <= last && !status; i += step)
            status = add_number(s, set, i);
        return status;
    }
    for (int64_t i = 0; i < s->n[things] && !status; i++) {
        const int64_t here = number_of(s, things, i);
        if (here >= first && here <= last && (here - first) % step == 0)
            status = add_member(s, set, (int32_t)i);
    }
    return status;
}

/** *NSET, ELSET=: the nodes of these cells. */
static int add_nodes_of(sets *s, const abaqus_block *b, int32_t set, abaqus_span name) {
    const int32_t from = find_named(s, b, ELEMENTS, name);
    if (from < 0)
        return PLANISH_OK;
    int status = ask_for(s, name.begin, s->set[from].n);
    for (int64_t i = 0; i < s->set[from].n && !status; i++) {
        int64_t local;
        const int dim = abaqus_dim_of(s, s->set[from].member[i], &local);
        const int32_t *nodes = io_model_cells(s->reader->model, dim)->nodes + local * (dim + 1);
        for (int j = 0; j <= dim && !status; j++)
            status = add_member(s, set, nodes[j]);
    }
    return status;
}

static int read_set(sets *s, const abaqus_block *b, set_kind things) {
    abaqus_span name = {NULL, NULL}, other, line, item;
    if (!abaqus_parameter(b, things == NODES ? "NSET" : "ELSET", &name))
        return io_fail_at(s->reader->model, b->parameters.begin, s->reader->error,
                          "a set without a name: %s= was expected",
                          things == NODES ? "NSET" : "ELSET");
    int status = things == ELEMENTS && !s->elements ? number_elements(s) : PLANISH_OK;
    const int32_t set = status ? status : make_set(s, things, b->scope, name);
    if (set < 0)
        return set;
    if (things == NODES && abaqus_parameter(b, "ELSET", &other))
        return add_nodes_of(s, b, set, other);
    const int is_sequence = abaqus_parameter(b, "GENERATE", &other);
    io_cursor cursor = {b->data.begin, b->data.end};
    while (!status && abaqus_line(&cursor, &line)) {
        if (is_sequence)
            status = add_sequence(s, b, set, line);
        while (!is_sequence && !status && abaqus_item(&line, &item))
            if (item.begin < item.end)
                status = add_item(s, b, set, item);
    }
    return status;
}

/** *NODE, NSET=: nodes stand in the file in their order, so that the place of the first tells which
 *  they are. */
static int read_node_sets(sets *s) {
    const io_model *model = s->reader->model;
    const int64_t n_places = model->place_node ? model->n_places : model->n_nodes;
    int64_t place = 0;
    int status = PLANISH_OK;
    for (int64_t i = 0; i < s->reader->n_blocks && !status; i++) {
        const abaqus_block *b = &s->reader->block[i];
        abaqus_span name;
        if (b->keyword != ABAQUS_NODE || b->scope != s->reader->scope)
            continue;
        const int64_t end = b->data.end - model->input.data;
        const int32_t set =
            abaqus_parameter(b, "NSET", &name) ? make_set(s, NODES, b->scope, name) : -1;
        if (set < -1)
            return set;
        for (; place < n_places && model->text_offset[place] <= end && !status; place++) {
            const int32_t node = model->place_node ? model->place_node[place] : (int32_t)place;
            status = set < 0 ? PLANISH_OK : add_member(s, set, node);
        }
    }
    return status;
}

/** *ELEMENT, ELSET=. */
static int read_element_sets(sets *s) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < s->reader->n_ranges && !status; i++) {
        const abaqus_range *range = &s->reader->range[i];
        if (!range->set.begin)
            continue;
        const int32_t set = make_set(s, ELEMENTS, s->reader->scope, range->set);
        if (set < 0)
            return set;
        for (int64_t k = range->begin; k < range->end && !status; k++)
            status = add_member(s, set, (int32_t)(s->first_cell[range->dim] + k));
    }
    return status;
}

static int read_set_blocks(sets *s) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < s->reader->n_blocks && !status; i++) {
        const abaqus_block *b = &s->reader->block[i];
        if (b->keyword == ABAQUS_NSET || b->keyword == ABAQUS_ELSET)
            status = read_set(s, b, b->keyword == ABAQUS_NSET ? NODES : ELEMENTS);
    }
    return status;
}

/* ---- nodes of equations ------------------------------------------------------------------- */

static void hold_set(const sets *s, named_set *set) {
    for (int64_t i = 0; i < set->n; i++)
        io_hold_node(s->reader->model, set->member[i], IO_HELD_REQUIRED);
    set->is_held = 1;
}

static void hold_item(sets *s, const abaqus_block *b, abaqus_span item) {
    io_model *model = s->reader->model;
    abaqus_span local = item;
    int64_t number;
    const int is_here = abaqus_local(s->reader, b, &local);
    const int is_integer = abaqus_integer(local, &number) == 0;
    const int32_t set = is_integer ? -1 : find_named(s, b, NODES, item);
    if (is_integer || (set < 0 && whole_number(local, &number) == 0)) {
        const int64_t node =
            is_here ? io_node_index(s->reader->model, s->reader->numbers, number) : -1;
        if (node >= 0)
            io_hold_node(model, node, IO_HELD_REQUIRED);
        return;
    }
    if (set >= 0 && !s->set[set].is_held)
        hold_set(s, &s->set[set]);
}

/** *EQUATION: the number of terms, then node (or set), component and factor of each. */
static void hold_equation(sets *s, const abaqus_block *b) {
    io_cursor cursor = {b->data.begin, b->data.end};
    abaqus_span line, item;
    int64_t left = 0;
    while (abaqus_line(&cursor, &line)) {
        if (left <= 0) {
            abaqus_item(&line, &item);
            if (abaqus_integer(item, &left))
                return;
            continue;
        }
        for (int i = 0; left > 0 && abaqus_item(&line, &item); i++) {
            if (i % 3 == 0 && item.begin < item.end)
                hold_item(s, b, item);
            left -= i % 3 == 2;
        }
    }
}

/** *MPC: a type, then nodes (or sets). */
static void hold_mpc(sets *s, const abaqus_block *b) {
    io_cursor cursor = {b->data.begin, b->data.end};
    abaqus_span line, item;
    while (abaqus_line(&cursor, &line))
        for (int i = 0; abaqus_item(&line, &item); i++)
            if (item.begin < item.end)
                hold_item(s, b, item);
}

static void hold_equations(sets *s) {
    for (int64_t i = 0; i < s->reader->n_blocks; i++) {
        const abaqus_block *b = &s->reader->block[i];
        if (b->keyword == ABAQUS_EQUATION)
            hold_equation(s, b);
        else if (b->keyword == ABAQUS_MPC)
            hold_mpc(s, b);
    }
}

/* ---- all ---------------------------------------------------------------------------------- */

static int prepare(sets *s) {
    io_model *model = s->reader->model;
    model->groups_by_name = 1;
    s->n[NODES] = model->n_nodes;
    for (int dim = 1; dim <= 3; dim++) {
        s->first_cell[dim] = s->n[ELEMENTS];
        s->n[ELEMENTS] += io_model_cells(model, dim)->n;
    }
    if (s->n[ELEMENTS] > INT32_MAX)
        return pl_fail(s->reader->error, PLANISH_ERROR_FORMAT, "%s: too many elements",
                       model->input.path);
    for (int i = 0; i < 2; i++)
        if (!(s->stamp[i] = pl_alloc_zero(s->n[i], sizeof *s->stamp[i])))
            return pl_fail_memory(s->reader->error, "the sets of the file");
    return PLANISH_OK;
}

static int has_set_of(const sets *s, set_kind things) {
    for (int64_t i = 0; i < s->n_sets; i++)
        if (s->set[i].things == things)
            return 1;
    return 0;
}

static int read_all(sets *s) {
    int status = prepare(s);
    if (!status)
        status = read_node_sets(s);
    if (!status)
        status = read_element_sets(s);
    if (!status)
        status = read_set_blocks(s);
    if (!status)
        hold_equations(s);
    if (!status)
        status = abaqus_make_entities(s, ELEMENTS);
    if (!status && has_set_of(s, NODES))
        status = abaqus_make_entities(s, NODES);
    return status ? status : abaqus_make_groups(s);
}

int abaqus_read_sets(abaqus_reader *reader) {
    sets s = {.reader = reader};
    const int status = read_all(&s);
    for (int64_t i = 0; i < s.n_sets; i++)
        pl_free(s.set[i].member);
    pl_free(s.set);
    pl_free(s.slot[0]);
    pl_free(s.slot[1]);
    pl_free(s.stamp[NODES]);
    pl_free(s.stamp[ELEMENTS]);
    io_numbers_destroy(s.elements);
    return status;
}
