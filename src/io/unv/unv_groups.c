/* unv_groups: regions and groups of universal files.
 *
 * A group has a line of numbers (its own first, the number of its entries last), a line with its
 * name, and entries: a code (7: node, 8: element), the number of the node or element, and perhaps two
 * more. An element is of the entity of its property and its groups. Where elements of one entity
 * have different materials these are regions, too.
 */
#include "io/unv/unv_reader.h"

#include "io/core/memberships.h"
#include "io/core/twins.h"

#include "base/memory.h"
#include "base/status.h"

enum { HEADING = 8, MOST_WORDS = 4, NODE = 7, ELEMENT = 8 };

/** Entries of groups, in the file's order. They are kept, as the file may change before a second
 *  look. */
typedef struct entries {
    struct entry {
        int32_t thing, tag; /* an index, and the group: its place from 0, then its tag */
    } * entry;              /* [n] owned */
    int64_t n, capacity;
} entries;

/** Elements of all lists by their numbers, and what groups have. */
typedef struct group_reader {
    unv_reader *r;
    io_numbers *elements;               /* NULL: not asked for so far */
    int64_t first_cell[IO_N_LISTS + 1]; /* of each list among all elements */
    entries of_elements, of_nodes;
    io_twin *group; /* [n_groups] owned */
    int64_t n_groups, group_capacity;
} group_reader;

/* ---- elements by number --------------------------------------------------------------------- */

static void count_cells(group_reader *g) {
    for (int k = IO_FIRST_LIST; k < IO_N_LISTS; k++)
        g->first_cell[k + 1] = g->first_cell[k] + io_model_list(g->r->model, k).n;
}

/** Make the table of the numbers of elements, which fails if one occurs twice. */
static int number_elements(group_reader *g) {
    const int64_t n = g->first_cell[IO_N_LISTS];
    int64_t *number = pl_alloc(n, sizeof *number);
    if (!number)
        return pl_fail_memory(g->r->error, "the numbers of elements");
    for (int k = IO_FIRST_LIST; k < IO_N_LISTS; k++) {
        const io_list list = io_model_list(g->r->model, k);
        for (int64_t i = 0; i < list.n; i++)
            number[g->first_cell[k] + i] = io_list_number(&list, i);
    }
    const int status =
        io_numbers_create(g->r->model->input.path, "element", number, n, &g->elements, g->r->error);
    pl_free(number);
    return status;
}

/* ---- groups --------------------------------------------------------------------------------- */

/** Put a node or element into the group at that place; *dims: the dimensions that it has, bits. Numbers
 *  of what is not kept are passed over. */
static int add_entry(group_reader *g, int64_t code, int64_t number, int32_t group, unsigned *dims) {
    int64_t thing = -1;
    entries *to = code == NODE ? &g->of_nodes : &g->of_elements;
    if (code == NODE) {
        thing = io_node_index(g->r->model, number);
        *dims |= thing >= 0;
    } else if (code == ELEMENT) {
        const int status = g->elements ? PLANISH_OK : number_elements(g);
        if (status)
            return status;
        thing = io_numbers_find(g->elements, number);
        for (int k = IO_FIRST_LIST; k < IO_N_LISTS && thing >= 0; k++)
            if (thing >= g->first_cell[k] && thing < g->first_cell[k + 1])
                *dims |= 1u << io_model_list(g->r->model, k).dim;
    }
    const struct entry entry = {(int32_t)thing, group};
    return thing < 0 || pl_append(&to->entry, &to->n, &to->capacity, &entry, sizeof entry)
               ? PLANISH_OK
               : pl_fail_memory(g->r->error, "the groups of the file");
}

/** Read a group. */
static int read_group(group_reader *g, io_cursor *cursor, int words) {
    const unv_reader *r = g->r;
    int64_t heading[HEADING], entry[MOST_WORDS];
    io_cursor line = io_take_line(cursor);
    for (int i = 0; i < HEADING; i++)
        if (io_integer(&line, &heading[i]))
            return io_fail_at(r->model, line.at, r->error,
                              "a group's line of eight whole numbers expected");
    const int64_t number = heading[0], n = heading[HEADING - 1];
    const io_slice name = io_slice_trim(io_next_line(cursor));
    if (number < 0 || number > INT32_MAX)
        return io_fail_at(r->model, name.begin, r->error, "number %lld of a group is out of range",
                          (long long)number);
    int status = io_check_room(r->model, *cursor, n, 2 * words, "entries of a group", r->error);
    io_twin group = {.number = (int32_t)number, .name = name, .at = g->n_groups};
    for (int64_t i = 0; i < n && !status; i++) {
        for (int k = 0; k < words; k++)
            if (io_integer(cursor, &entry[k]))
                return io_fail_at(r->model, cursor->at, r->error,
                                  "group %lld: %lld entries expected", (long long)number,
                                  (long long)n);
        status = add_entry(g, entry[0], entry[1], (int32_t)group.at, &group.dims);
    }
    if (!status && !pl_append(&g->group, &g->n_groups, &g->group_capacity, &group, sizeof group))
        status = pl_fail_memory(r->error, "the groups of the file");
    return status;
}

static int read_groups(group_reader *g) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < g->r->sections.n; i++) {
        const io_section *s = &g->r->sections.section[i];
        const unv_dataset *d = &unv_datasets[s->keyword];
        io_cursor cursor = {s->data, s->end};
        if (d->kind != UNV_GROUPS)
            continue;
        for (io_skip_space(&cursor); cursor.at < cursor.end && !status; io_skip_space(&cursor))
            status = read_group(g, &cursor, d->words);
    }
    return status;
}

/* ---- tags of groups ------------------------------------------------------------------------- */

/** Return the largest property of an element. */
static int64_t most_property(const io_model *model) {
    int64_t most = 0;
    for (int k = IO_FIRST_LIST; k < IO_N_LISTS; k++) {
        const io_list list = io_model_list(model, k);
        for (int64_t i = 0; i < list.n; i++)
            most = list.entity[i] > most ? list.entity[i] : most;
    }
    return most;
}

/** Name a group for the dimensions that it has. */
static int name_group(const group_reader *g, const io_twin *group, int32_t tag) {
    const int64_t length = io_slice_length(group->name);
    int status = PLANISH_OK;
    for (int dim = 0; dim <= 3 && !status; dim++)
        if (group->dims >> dim & 1 && length > 0)
            status = io_model_group(g->r->model, dim, tag, group->name.begin, length, g->r->error);
    return status;
}

/** Find the tags of groups: tag [n_groups]. Those of number 0 are groups of their own, as tags are more
 *  than 0. */
static int find_tags(group_reader *g, int32_t *tag) {
    io_twin *twin = pl_alloc(g->n_groups, sizeof *twin);
    int64_t n = 0;
    if (!twin)
        return pl_fail_memory(g->r->error, "the groups of the file");
    for (int64_t i = 0; i < g->n_groups; i++) {
        tag[i] = (int32_t)(INT32_MAX - i);
        if (g->group[i].number > 0) {
            twin[n] = g->group[i];
            twin[n++].own = &tag[i];
        }
    }
    const int status =
        io_twins_number(g->r->model, twin, n, most_property(g->r->model), g->r->error);
    pl_free(twin);
    return status;
}

static void tag_entries(entries *of, const int32_t *tag) {
    for (int64_t i = 0; i < of->n; i++)
        of->entry[i].tag = tag[of->entry[i].tag];
}

/** Give all groups their tags and names. */
static int tag_groups(group_reader *g) {
    int32_t *tag = pl_alloc(g->n_groups, sizeof *tag);
    int status = tag ? find_tags(g, tag) : pl_fail_memory(g->r->error, "the groups of the file");
    for (int64_t i = 0; i < g->n_groups && !status; i++)
        status = name_group(g, &g->group[i], tag[i]);
    if (!status) {
        tag_entries(&g->of_elements, tag);
        tag_entries(&g->of_nodes, tag);
    }
    pl_free(tag);
    return status;
}

/* ---- entities ------------------------------------------------------------------------------- */

/** List the groups of n things. To be destroyed in any case. */
static int list_groups(const entries *of, int64_t n, io_memberships *m, planish_error *error) {
    int status = io_memberships_begin(m, n, error);
    for (int pass = 0; pass < 2 && !status; pass++) {
        for (int64_t i = 0; i < of->n; i++)
            io_memberships_add(m, of->entry[i].thing, of->entry[i].tag);
        if (pass == 0)
            status = io_memberships_counted(m, error);
    }
    return status;
}

/** Make entities of the properties and groups of all elements. */
static int make_entities(const group_reader *g, const io_memberships *m) {
    io_model *model = g->r->model;
    int status = PLANISH_OK;
    for (int k = IO_FIRST_LIST; k < IO_N_LISTS && !status; k++) {
        const io_list list = io_model_list(model, k);
        if (list.n == 0)
            continue;
        int32_t *property = pl_alloc(list.n, sizeof *property);
        if (!property)
            return pl_fail_memory(g->r->error, "the properties of elements");
        for (int64_t i = 0; i < list.n; i++)
            property[i] = list.entity[i] - 1; /* the tag of an entity is one more */
        status = io_memberships_entities(m, model, list.dim, g->first_cell[k], list.n, property,
                                         list.entity, g->r->error);
        pl_free(property);
    }
    return status;
}

/** Replace materials by numbers of their pairs with entities, as regions. */
static int make_regions(unv_reader *r) {
    io_model pairs = {.input = {.fd = -1}};
    int status = PLANISH_OK;
    for (int k = IO_FIRST_LIST; k < IO_N_LISTS && !status; k++) {
        const io_list list = io_model_list(r->model, k);
        int32_t *region = *io_model_regions(r->model, k);
        for (int64_t i = 0; region && i < list.n && !status; i++) {
            const int32_t pair =
                io_model_entity(&pairs, list.dim, list.entity[i], 1, &region[i], r->error);
            region[i] = pair;
            status = pair < 0 ? pair : PLANISH_OK;
        }
    }
    io_model_destroy(&pairs);
    return status;
}

/** Read groups, and make entities of them and the properties. */
static int make_groups(group_reader *g) {
    io_memberships of_elements = {0}, of_nodes = {0};
    io_model *model = g->r->model;
    count_cells(g);
    int status = read_groups(g);
    if (!status)
        status = tag_groups(g);
    if (!status)
        status = list_groups(&g->of_elements, g->first_cell[IO_N_LISTS], &of_elements, g->r->error);
    if (!status)
        status = make_entities(g, &of_elements);
    if (!status && g->of_nodes.n > 0)
        status = list_groups(&g->of_nodes, model->n_nodes, &of_nodes, g->r->error);
    if (!status && g->of_nodes.n > 0)
        status = io_memberships_of_nodes(&of_nodes, model, g->r->error);
    io_memberships_destroy(&of_elements);
    io_memberships_destroy(&of_nodes);
    return status;
}

int unv_make_entities(unv_reader *r) {
    group_reader g = {.r = r};
    int has_groups = 0;
    for (int64_t i = 0; i < r->sections.n; i++)
        has_groups |= unv_datasets[r->sections.section[i].keyword].kind == UNV_GROUPS;
    const int status = has_groups ? make_groups(&g) : io_runs_index_tags(r->model, r->error);
    pl_free(g.of_elements.entry);
    pl_free(g.of_nodes.entry);
    pl_free(g.group);
    io_numbers_destroy(g.elements);
    return status || !r->has_materials ? status : make_regions(r);
}
