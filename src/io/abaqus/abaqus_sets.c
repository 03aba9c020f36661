/* abaqus_sets: sets of elements and nodes in an Abaqus input file.
 *
 * An element or node may be in any number of sets, so that what it is of is an entity with one
 * physical group for each of them. Regions are told by less: by the ELSET= of *ELEMENT and by the
 * section that has the element, as sets are also made for loads and for output. Names are those of
 * a part or of the assembly: a set of the same name there is another.
 */
#include "io/abaqus/abaqus_reader.h"

#include "io/core/cell_types.h"
#include "io/core/number.h"
#include "io/core/parts.h"
#include "io/core/records.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

/* ---- names -------------------------------------------------------------------------------- */

/** Return a letter of a name: in quotes as it is, else as a capital. fold: all are capitals. */
static char letter(const char *at, int is_quoted, int fold) {
    return is_quoted && !fold ? *at : io_upper(*at);
}

static int same_name(io_slice a, io_slice b, int fold) {
    const int a_quoted = abaqus_is_quoted(a), b_quoted = abaqus_is_quoted(b);
    a = abaqus_unquoted(a);
    b = abaqus_unquoted(b);
    if (io_slice_length(a) != io_slice_length(b))
        return 0;
    for (int64_t i = 0; i < io_slice_length(a); i++)
        if (letter(a.begin + i, a_quoted, fold) != letter(b.begin + i, b_quoted, fold))
            return 0;
    return 1;
}

/** Return the slot of the set, or the free one where it belongs. */
static int32_t *find_slot(const abaqus_reader *r, abaqus_things things, int32_t scope,
                          io_slice name, int fold) {
    const uint64_t mask = (uint64_t)r->n_slots - 1;
    const int is_quoted = abaqus_is_quoted(name);
    const io_slice letters = abaqus_unquoted(name);
    pl_hash hash = r->hash;
    pl_hash_add(&hash, 2 * (uint64_t)(uint32_t)scope + (uint64_t)things);
    for (const char *c = letters.begin; c < letters.end; c++)
        pl_hash_add(&hash, (unsigned char)letter(c, is_quoted, fold));
    for (uint64_t at = pl_hash_end(hash) & mask;; at = (at + 1) & mask) {
        int32_t *slot = &r->slot[fold][at];
        const abaqus_set *set = *slot < 0 ? NULL : &r->set[*slot];
        if (!set ||
            (set->things == things && set->scope == scope && same_name(set->name, name, fold)))
            return slot;
    }
}

static void put_into_slots(abaqus_reader *r, int32_t index) {
    const abaqus_set *set = &r->set[index];
    for (int fold = 0; fold < 2; fold++) {
        int32_t *slot = find_slot(r, set->things, set->scope, set->name, fold);
        *slot = *slot < 0 ? index : *slot;
    }
}

int32_t abaqus_find_set(const abaqus_reader *r, abaqus_things things, int32_t scope,
                        io_slice name) {
    if (r->n_slots == 0)
        return -1;
    const int32_t set = *find_slot(r, things, scope, name, 0);
    return set >= 0 ? set : *find_slot(r, things, scope, name, 1);
}

/** Return the index of the set of just that name, made if new; negative on failure. */
static int32_t make_set(abaqus_reader *r, abaqus_things things, int32_t scope, io_slice name) {
    enum { FIRST_SLOTS = 64 };
    if (2 * r->n_sets >= r->n_slots) { /* the tables are half full at most */
        const int64_t n_slots = r->n_slots ? 2 * r->n_slots : FIRST_SLOTS;
        for (int fold = 0; fold < 2; fold++) {
            pl_free(r->slot[fold]);
            r->slot[fold] = pl_alloc(n_slots, sizeof *r->slot[fold]);
            if (!r->slot[fold])
                return pl_fail_memory(r->error, "the sets of the file");
            memset(r->slot[fold], -1, (size_t)n_slots * sizeof *r->slot[fold]);
        }
        r->n_slots = n_slots;
        r->hash = pl_hash_draw(r->slot[0]);
        for (int64_t i = 0; i < r->n_sets; i++)
            put_into_slots(r, (int32_t)i);
    }
    const int32_t found = *find_slot(r, things, scope, name, 0);
    if (found >= 0)
        return found;
    const abaqus_set set = {.things = things, .scope = scope, .name = name};
    if (!pl_append(&r->set, &r->n_sets, &r->set_capacity, &set, sizeof set))
        return pl_fail_memory(r->error, "the sets of the file");
    put_into_slots(r, (int32_t)r->n_sets - 1);
    return (int32_t)r->n_sets - 1;
}

/* ---- members ------------------------------------------------------------------------------ */

static int add_member(abaqus_reader *r, int32_t set, int32_t member) {
    abaqus_set *to = &r->set[set];
    int32_t *stamp = &r->stamp[to->things][member];
    if (*stamp == set + 1)
        return PLANISH_OK;
    if (!pl_append(&to->member, &to->n, &to->capacity, &member, sizeof member))
        return pl_fail_memory(r->error, "the members of sets");
    *stamp = set + 1;
    return PLANISH_OK;
}

io_list abaqus_list_of(const abaqus_reader *r, int64_t cell, int64_t *local) {
    int list = IO_N_LISTS - 1;
    while (list > IO_FIRST_LIST && cell < r->first_cell[list])
        list--;
    *local = cell - r->first_cell[list];
    return io_model_list(r->model, list);
}

/** Return the number in the file of a thing. */
static int64_t number_of(const abaqus_reader *r, abaqus_things things, int64_t thing) {
    int64_t local;
    if (things == ABAQUS_NODES)
        return io_node_number(r->model, thing);
    const io_list list = abaqus_list_of(r, thing, &local);
    return io_list_number(&list, local);
}

/** Return the index of the thing of a number, or -1: there is none, or its cell is not kept. */
static int64_t find_thing(const abaqus_reader *r, abaqus_things things, int64_t number) {
    return things == ABAQUS_NODES ? io_node_index(r->model, number)
                                  : io_numbers_find(r->elements, number);
}

/** Count n members that a line at that place asks for. A few bytes can ask for all things that
 *  there are, and a file that does so again and again for the square of its size. */
static int ask_for(abaqus_reader *r, const char *at, int64_t n) {
    enum { PER_BYTE = 8, SMALLEST = 1000000 };
    const int64_t most = SMALLEST + PER_BYTE * r->model->input.size;
    r->n_asked += n;
    if (r->n_asked <= most)
        return PLANISH_OK;
    return io_fail_at(r->model, at, r->error,
                      "the sets have more than %lld members, too many for a file of this size: "
                      "sets or sequences contain one another over and over",
                      (long long)most);
}

/** Read a whole number, also one that is written as a real one, as meshio does it. Return 0, or -1
 *  if it is none. */
static int whole_number(io_slice item, int64_t *number) {
    double value;
    if (io_slice_integer(item, number) == 0)
        return 0;
    if (io_slice_real(item, 0, &value) || !(value >= 0) || value > INT32_MAX ||
        value != (double)(int64_t)value)
        return -1;
    *number = (int64_t)value;
    return 0;
}

/** Return the index of the set that an item of a block names, or -1. INSTANCE.NAME, and any name
 *  behind INSTANCE=, is the mesh's own; other names are of where the block is, or else, as some
 *  programs write them, the mesh's or the assembly's. */
static int32_t find_named(const abaqus_reader *r, const abaqus_block *b, abaqus_things things,
                          io_slice item) {
    io_slice local = item;
    const int is_of_mesh = abaqus_local(r, b, &local);
    int32_t set = is_of_mesh ? abaqus_find_set(r, things, r->scope, local) : -1;
    set = set < 0 ? abaqus_find_set(r, things, b->scope, item) : set;
    set = set < 0 ? abaqus_find_set(r, things, r->scope, local) : set;
    return set < 0 ? abaqus_find_set(r, things, ABAQUS_IN_ASSEMBLY, local) : set;
}

/** Find what an item of a block names: a set, or else (*set: -1) a thing, -1 if the mesh has none
 * of that number. Return 0, or -1 if the item is neither a number nor the name of a set so far. */
static int find_item(const abaqus_reader *r, const abaqus_block *b, abaqus_things things,
                     io_slice item, int32_t *set, int64_t *thing) {
    int64_t number;
    io_slice local = item;
    const int is_here = abaqus_local(r, b, &local);
    const int is_integer = io_slice_integer(local, &number) == 0;
    *set = is_integer ? -1 : find_named(r, b, things, item);
    *thing = -1;
    if (*set >= 0)
        return 0;
    if (!is_integer && whole_number(local, &number))
        return -1;
    *thing = is_here ? find_thing(r, things, number) : -1;
    return 0;
}

/** Add a number, or the members of a set that is there already. */
static int add_item(abaqus_reader *r, const abaqus_block *b, int32_t set, io_slice item) {
    int64_t thing;
    int32_t from;
    if (find_item(r, b, r->set[set].things, item, &from, &thing))
        return abaqus_fail_item(r, item,
                                "is neither a number nor the name of a set that is defined before "
                                "(sets must stand before those that they are part of)");
    if (from < 0)
        return thing < 0 ? PLANISH_OK : add_member(r, set, (int32_t)thing);
    abaqus_set *f = &r->set[from];
    if (from == set || (f->last_into == set + 1 && f->last_n == f->n))
        return PLANISH_OK;
    int status = ask_for(r, item.begin, f->n);
    for (int64_t i = 0; i < f->n && !status; i++)
        status = add_member(r, set, f->member[i]);
    f->last_into = set + 1;
    f->last_n = f->n;
    return status;
}

/** Add the numbers of a line behind GENERATE: first, last, step. */
static int add_sequence(abaqus_reader *r, const abaqus_block *b, int32_t set, io_slice line) {
    int64_t number[3] = {0, 0, 1};
    io_slice item = line, rest = line;
    const abaqus_things things = r->set[set].things;
    int is_here = 1;
    for (int i = 0; i < 3 && abaqus_item(&rest, &item); i++) {
        if (i > 0 && item.begin == item.end)
            continue;
        is_here = abaqus_local(r, b, &item);
        if (whole_number(item, &number[i]) || number[i] < 0 || number[i] > INT32_MAX)
            return abaqus_fail_item(r, item,
                                    "where a number was expected (GENERATE: first, last, step)");
    }
    const int64_t first = number[0], last = number[1], step = number[2] > 0 ? number[2] : 1;
    if (!is_here || last < first)
        return PLANISH_OK;
    const int64_t n_numbers = (last - first) / step + 1, n = r->n[things];
    const int is_short = n_numbers <= n; /* else things are asked, not numbers */
    int status = ask_for(r, line.begin, is_short ? n_numbers : n);
    for (int64_t i = first; is_short && i <= last && !status; i += step) {
        const int64_t thing = find_thing(r, things, i);
        status = thing < 0 ? PLANISH_OK : add_member(r, set, (int32_t)thing);
    }
    for (int64_t i = 0; !is_short && i < n && !status; i++) {
        const int64_t here = number_of(r, things, i);
        if (here >= first && here <= last && (here - first) % step == 0)
            status = add_member(r, set, (int32_t)i);
    }
    return status;
}

/** Add the nodes of the cells in a set: *NSET, ELSET=. */
static int add_nodes_of(abaqus_reader *r, const abaqus_block *b, int32_t set, io_slice name) {
    const int32_t from = find_named(r, b, ABAQUS_ELEMENTS, name);
    if (from < 0)
        return PLANISH_OK;
    int status = ask_for(r, name.begin, r->set[from].n);
    for (int64_t i = 0; i < r->set[from].n && !status; i++) {
        int64_t local;
        const io_list list = abaqus_list_of(r, r->set[from].member[i], &local);
        int32_t node[IO_CELL_NODES];
        const int n = io_list_nodes(&list, local, node, NULL);
        for (int j = 0; j < n && !status; j++)
            status = add_member(r, set, node[j]);
    }
    return status;
}

/* ---- blocks of sets ------------------------------------------------------------------------- */

/** Make the table of the numbers of cells, which fails if one occurs twice. */
static int number_elements(abaqus_reader *r) {
    int64_t *number = pl_alloc(r->n[ABAQUS_ELEMENTS], sizeof *number);
    if (!number)
        return pl_fail_memory(r->error, "the numbers of elements");
    for (int64_t i = 0; i < r->n[ABAQUS_ELEMENTS]; i++)
        number[i] = number_of(r, ABAQUS_ELEMENTS, i);
    const int status = io_numbers_create(r->model->input.path, "element", number,
                                         r->n[ABAQUS_ELEMENTS], &r->elements, r->error);
    pl_free(number);
    return status;
}

/** Read *NSET or *ELSET. */
static int read_set(abaqus_reader *r, const abaqus_block *b) {
    const abaqus_things things = b->keyword == ABAQUS_NSET ? ABAQUS_NODES : ABAQUS_ELEMENTS;
    io_slice name = {NULL, NULL}, other, line, item;
    if (!abaqus_parameter(b, things == ABAQUS_NODES ? "NSET" : "ELSET", &name))
        return abaqus_fail(r, b,
                           things == ABAQUS_NODES ? "a set without a name: NSET= was expected"
                                                  : "a set without a name: ELSET= was expected");
    int status = things == ABAQUS_ELEMENTS && !r->elements ? number_elements(r) : PLANISH_OK;
    const int32_t set = status ? status : make_set(r, things, b->scope, name);
    if (set < 0)
        return set;
    if (things == ABAQUS_NODES && abaqus_parameter(b, "ELSET", &other))
        return add_nodes_of(r, b, set, other);
    const int is_sequence = abaqus_parameter(b, "GENERATE", &other);
    io_cursor cursor = b->data;
    while (!status && abaqus_line(&cursor, &line)) {
        if (is_sequence)
            status = add_sequence(r, b, set, line);
        while (!is_sequence && !status && abaqus_item(&line, &item))
            if (item.begin < item.end)
                status = add_item(r, b, set, item);
    }
    return status;
}

/** Read *NODE, NSET=. Nodes stand in the file in their order, so that the place of the first tells
 *  which they are. */
static int read_node_sets(abaqus_reader *r) {
    const io_model *model = r->model;
    const int64_t n_places = model->place_node ? model->n_places : model->n_nodes;
    int64_t place = 0;
    for (int64_t i = 0; i < r->n_blocks; i++) {
        const abaqus_block *b = &r->block[i];
        io_slice name;
        if (b->keyword != ABAQUS_NODE || b->scope != r->scope)
            continue;
        const int64_t end = b->data.end - model->input.data;
        const int is_set = abaqus_parameter(b, "NSET", &name);
        const int32_t set = is_set ? make_set(r, ABAQUS_NODES, b->scope, name) : -1;
        if (is_set && set < 0)
            return set;
        for (; place < n_places && model->text_offset[place] <= end; place++) {
            const int32_t node = model->place_node ? model->place_node[place] : (int32_t)place;
            const int status = is_set ? add_member(r, set, node) : PLANISH_OK;
            if (status)
                return status;
        }
    }
    return PLANISH_OK;
}

/** Hold the nodes of *EQUATION (the number of terms, then node or set, component and factor of
 *  each) and of *MPC (a type, then nodes or sets). */
static void hold_equations(abaqus_reader *r) {
    for (int64_t k = 0; k < r->n_blocks; k++) {
        const abaqus_block *b = &r->block[k];
        const int step = b->keyword == ABAQUS_EQUATION ? 3 : 1;
        if (b->keyword != ABAQUS_EQUATION && b->keyword != ABAQUS_MPC)
            continue;
        io_cursor cursor = b->data;
        io_slice line, item;
        int64_t left = b->keyword == ABAQUS_EQUATION ? 0 : INT64_MAX;
        while (abaqus_line(&cursor, &line)) {
            if (left <= 0) {
                abaqus_item(&line, &item);
                if (io_slice_integer(item, &left))
                    break;
                continue;
            }
            for (int i = 0; left > 0 && abaqus_item(&line, &item); i++) {
                int64_t node = -1;
                int32_t index = -1;
                if (i % step == 0 && item.begin < item.end)
                    find_item(r, b, ABAQUS_NODES, item, &index, &node);
                if (node >= 0)
                    io_hold_node(r->model, node, IO_HELD_REQUIRED);
                abaqus_set *set = index >= 0 ? &r->set[index] : NULL;
                for (int64_t m = 0; set && !set->is_held && m < set->n; m++)
                    io_hold_node(r->model, set->member[m], IO_HELD_REQUIRED);
                if (set)
                    set->is_held = 1;
                left -= i % 3 == 2;
            }
        }
    }
}

/** Mark the nodes of *BOUNDARY (a node or set, then degrees of freedom), and note its sets. */
static int mark_supported(abaqus_reader *r, const abaqus_block *b) {
    io_model *model = r->model;
    io_cursor cursor = b->data;
    io_slice line, item;
    int64_t node;
    int32_t index;
    if (!model->supported)
        model->supported = pl_alloc_zero(model->n_nodes, 1);
    if (!model->supported)
        return pl_fail_memory(r->error, "the boundary conditions of the file");
    while (abaqus_line(&cursor, &line)) {
        abaqus_item(&line, &item);
        if (find_item(r, b, ABAQUS_NODES, item, &index, &node))
            continue;
        if (node >= 0)
            model->supported[node] = 1;
        abaqus_set *set = index >= 0 ? &r->set[index] : NULL;
        if (!set || set->is_supported)
            continue;
        const io_slice name = abaqus_unquoted(set->name);
        set->is_supported = 1;
        if (!io_names_add(&model->supported_group, name.begin, io_slice_length(name)))
            return pl_fail_memory(r->error, "the boundary conditions of the file");
        for (int64_t m = 0; m < set->n; m++)
            model->supported[set->member[m]] = 1;
    }
    return PLANISH_OK;
}

/* ---- surfaces ------------------------------------------------------------------------------- */

/** Facets of the types of elements, by the numbers of their corners, as S1, S2, ... */
static const struct {
    int dim, corners;
    const char *facets[6]; /* digits: corners from 1 */
} facets[] = {
    {2, 3, {"12", "23", "31"}},
    {2, 4, {"12", "23", "34", "41"}},
    {3, 4, {"123", "142", "243", "341"}},
    {3, 5, {"1234", "152", "253", "354", "451"}},
    {3, 6, {"123", "465", "1452", "2563", "3641"}},
    {3, 8, {"1234", "5876", "1562", "2673", "3784", "4851"}},
};

/** Return the corners of the facet called name of an element with so many corners: digits, from 1; NULL: planish
 *  does not know it. */
static const char *find_facet(const char *name, int dim, int corners) {
    if (dim == 2 && (strcmp(name, "SPOS") == 0 || strcmp(name, "SNEG") == 0))
        return corners == 3 ? "123" : "1234";
    if (name[0] != 'S' || name[1] < '1' || name[1] > '6' || name[2])
        return NULL;
    for (size_t i = 0; i < sizeof facets / sizeof *facets; i++)
        if (facets[i].dim == dim && facets[i].corners == corners)
            return facets[i].facets[name[1] - '1'];
    return NULL;
}

/** Add the nodes of a facet of an element, its mids among them, to a set (-1: to none). *is_known becomes
 *  0 if planish does not know the facet. */
static int add_facet(abaqus_reader *r, int32_t set, int64_t cell, const char *name, int *is_known) {
    int64_t local;
    const io_list list = abaqus_list_of(r, cell, &local);
    int32_t node[IO_CELL_NODES];
    int corners, status = PLANISH_OK;
    const int n = io_list_all_nodes(&list, local, node, &corners);
    const char *facet = find_facet(name, list.dim, corners);
    *is_known &= facet != NULL;
    uint32_t has = 0;
    for (; facet && *facet && set >= 0; facet++)
        has |= UINT32_C(1) << (*facet - '1');
    has = has ? io_part_nodes(io_parts_of(list.dim, corners), corners, has) : 0;
    for (int i = 0; i < n && !status; i++)
        if (node[i] >= 0 && (has >> i & 1))
            status = add_member(r, set, node[i]);
    return status;
}

/** Add a line of *SURFACE to a set of nodes (-1: to none): a node, or an element and its facet, or a set of
 *  these. *is_known becomes 0 if planish does not know what that is. */
static int add_surface_line(abaqus_reader *r, const abaqus_block *b, abaqus_things things,
                            int32_t set, io_slice line, int *is_known) {
    io_slice item, second = {line.end, line.end};
    char name[ABAQUS_NAME_SIZE];
    int64_t thing;
    int32_t from;
    abaqus_item(&line, &item);
    abaqus_item(&line, &second);
    abaqus_squeeze(second, name);
    *is_known &= find_item(r, b, things, item, &from, &thing) == 0;
    const int64_t n = !*is_known ? 0 : from >= 0 ? r->set[from].n : thing >= 0;
    int status = ask_for(r, item.begin, n);
    for (int64_t i = 0; i < n && !status; i++) {
        const int64_t member = from >= 0 ? r->set[from].member[i] : thing;
        if (things == ABAQUS_ELEMENTS)
            status = add_facet(r, set, member, name, is_known);
        else if (set >= 0)
            status = add_member(r, set, (int32_t)member);
    }
    return status;
}

/** Whether a block has more data of the keyword line of another one, or is that one. */
static int continues(const abaqus_block *block, const abaqus_block *first) {
    return block->parameters.begin == first->parameters.begin;
}

/** Read *SURFACE: its nodes are a set, unless a set has its name, or planish does not know all that it is
 *  made of. Its lines may go on in the blocks behind it, as files are included. */
static int read_surface(abaqus_reader *r, const abaqus_block *b) {
    const abaqus_block *const end = r->block + r->n_blocks;
    io_slice name = {NULL, NULL}, type = {NULL, NULL}, line;
    const int has_type = abaqus_parameter(b, "TYPE", &type);
    const int is_of_nodes = has_type && io_slice_is(type, "NODE", 1);
    const abaqus_things things = is_of_nodes ? ABAQUS_NODES : ABAQUS_ELEMENTS;
    int is_known = !has_type || is_of_nodes || io_slice_is(type, "ELEMENT", 1);
    int status = PLANISH_OK;
    if (!abaqus_parameter(b, "NAME", &name) ||
        abaqus_find_set(r, ABAQUS_NODES, b->scope, name) >= 0 ||
        abaqus_find_set(r, ABAQUS_ELEMENTS, b->scope, name) >= 0)
        return PLANISH_OK;
    if (is_known && !is_of_nodes && !r->elements && !r->has_doubled)
        r->has_doubled = number_elements(r) != PLANISH_OK;
    is_known &= is_of_nodes || r->elements != NULL; /* numbers that occur twice tell no element */
    for (int pass = 0; pass < 2 && is_known && !status; pass++) { /* look, then add */
        const int32_t set = pass ? make_set(r, ABAQUS_NODES, b->scope, name) : -1;
        status = pass && set < 0 ? set : PLANISH_OK;
        for (const abaqus_block *more = b; more < end && continues(more, b); more++) {
            io_cursor cursor = more->data;
            while (!status && is_known && abaqus_line(&cursor, &line))
                status = add_surface_line(r, b, things, set, line, &is_known);
        }
    }
    name = abaqus_unquoted(name);
    if (is_known || status ||
        io_names_add(&r->model->strange_groups, name.begin, io_slice_length(name)))
        return status;
    return pl_fail_memory(r->error, "the surfaces of the file");
}

/* ---- all ---------------------------------------------------------------------------------- */

int abaqus_read_sets(abaqus_reader *r) {
    io_model *model = r->model;
    model->groups_by_name = 1;
    r->n[ABAQUS_NODES] = model->n_nodes;
    for (int k = IO_FIRST_LIST; k < IO_N_LISTS; k++) {
        r->first_cell[k] = r->n[ABAQUS_ELEMENTS];
        r->n[ABAQUS_ELEMENTS] += io_model_list(model, k).n;
    }
    if (r->n[ABAQUS_ELEMENTS] > INT32_MAX)
        return pl_fail(r->error, PLANISH_ERROR_FORMAT, "%s: too many elements", model->input.path);
    for (int i = 0; i < 2; i++)
        if (!(r->stamp[i] = pl_alloc_zero(r->n[i], sizeof *r->stamp[i])))
            return pl_fail_memory(r->error, "the sets of the file");
    int status = read_node_sets(r);
    for (int64_t i = 0; i < r->n_ranges && !status; i++) { /* *ELEMENT, ELSET= */
        const abaqus_range *range = &r->range[i];
        if (!range->set.begin)
            continue;
        const int32_t set = make_set(r, ABAQUS_ELEMENTS, r->scope, range->set);
        if (set < 0)
            return set;
        for (int64_t k = range->begin; k < range->end && !status; k++)
            status = add_member(r, set, (int32_t)(r->first_cell[range->list] + k));
    }
    for (int64_t i = 0; i < r->n_blocks && !status; i++)
        if (r->block[i].keyword == ABAQUS_NSET || r->block[i].keyword == ABAQUS_ELSET)
            status = read_set(r, &r->block[i]);
    if (!status)
        hold_equations(r);
    for (int64_t i = 0; i < r->n_blocks && !status; i++)
        if (r->block[i].keyword == ABAQUS_BOUNDARY)
            status = mark_supported(r, &r->block[i]);
    for (int64_t i = 0; i < r->n_blocks && !status; i++)
        if (r->block[i].keyword == ABAQUS_SURFACE &&
            (i == 0 || !continues(&r->block[i], &r->block[i - 1])))
            status = read_surface(r, &r->block[i]);
    return status;
}
