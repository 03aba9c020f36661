/* abaqus_write: a mesh as an Abaqus input file (also for CalculiX): nodes, elements and sets; no
 * materials, sections and steps.
 *
 * Elements of one entity of the model are an ELSET. A named group is an ELSET of these, or an NSET.
 */
#include "io/abaqus/abaqus_write.h"

#include "io/view/view_blocks.h"
#include "io/view/writer.h"

#include "base/memory.h"
#include "base/status.h"

#include <inttypes.h>
#include <string.h>
#include <strings.h>

/** C3D27 has the node of its inside before those of its faces, which begin with that of the first
 *  four corners. */
const io_node_order abaqus_node_orders[] = {
    {PLANISH_CELL_HEXAHEDRON27, {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13,
                                 14, 15, 16, 17, 18, 19, 26, 24, 23, 25, 21, 22, 20}},
    {0, {0}},
};

/* Elements of solids and what lies on them; of a plane mesh; of a surface in space. */
static const io_view_type solid_types[] = {{PLANISH_CELL_TETRAHEDRON, "C3D4", 0},
                                           {PLANISH_CELL_TETRAHEDRON10, "C3D10", 0},
                                           {PLANISH_CELL_HEXAHEDRON, "C3D8", 0},
                                           {PLANISH_CELL_HEXAHEDRON20, "C3D20", 0},
                                           {PLANISH_CELL_HEXAHEDRON27, "C3D27", 0},
                                           {PLANISH_CELL_WEDGE, "C3D6", 0},
                                           {PLANISH_CELL_WEDGE15, "C3D15", 0},
                                           {PLANISH_CELL_WEDGE18, "C3D15V", 0},
                                           {PLANISH_CELL_PYRAMID, "C3D5", 0},
                                           {PLANISH_CELL_TRIANGLE, "S3", 0},
                                           {PLANISH_CELL_TRIANGLE6, "STRI65", 0},
                                           {PLANISH_CELL_QUADRILATERAL, "S4", 0},
                                           {PLANISH_CELL_QUADRILATERAL8, "S8R", 0},
                                           {PLANISH_CELL_QUADRILATERAL9, "S9R5", 0},
                                           {PLANISH_CELL_LINE, "T3D2", 0},
                                           {PLANISH_CELL_LINE3, "T3D3", 0},
                                           {0, NULL, 0}};
static const io_view_type plane_types[] = {{PLANISH_CELL_TRIANGLE, "CPS3", 0},
                                           {PLANISH_CELL_TRIANGLE6, "CPS6", 0},
                                           {PLANISH_CELL_QUADRILATERAL, "CPS4", 0},
                                           {PLANISH_CELL_QUADRILATERAL8, "CPS8", 0},
                                           {PLANISH_CELL_LINE, "T2D2", 0},
                                           {PLANISH_CELL_LINE3, "T2D3", 0},
                                           {0, NULL, 0}};

/** Whether a name has '_' in place of a character. */
static int is_replaced(char c) {
    return c == '"' || (unsigned char)c < ' ';
}

/** Put the name of a group between quotes, as it has to be where there are blanks. */
static void put_name(io_writer *writer, const char *name) {
    const int length = io_view_name_length(name, IO_VIEW_MOST_NAME);
    io_put_text(writer, "\"");
    for (int i = 0; i < length; i++)
        io_put_bytes(writer, is_replaced(name[i]) ? "_" : name + i, 1);
    io_put_text(writer, "\"\n");
}

/* Names of sets that are none of the mesh: a word, some '_' and a number. */
enum { GROUP = 4, N_WORDS }; /* before it those of blocks, by their dimension */

static const char *const words[N_WORDS] = {"POINTS", "LINES", "SURFACE", "VOLUME", "GROUP"};

/** How many '_' the names with each word need, so that no group has them, and numbers of blocks. */
typedef struct set_marks {
    int n[N_WORDS];
    int has_references; /* sets of blocks have these where they are positive, others are numbered */
    int64_t largest;    /* behind this one */
} set_marks;

/** Return how many '_' names need behind a word so that no group has them, as far as names are written. */
static int count_marks(const io_model *model, const char *word) {
    const size_t length = strlen(word);
    int n_marks = 0;
    for (int32_t g = 0; g < model->n_groups; g++) {
        const char *name = model->group[g].name;
        if (strncasecmp(name, word, length) != 0)
            continue;
        int n = 0;
        for (name += length; *name == '_' || (*name && is_replaced(*name)); name++)
            n++;
        if (*name >= '0' && *name <= '9' && n >= n_marks && n < IO_VIEW_MOST_NAME)
            n_marks = n + 1;
    }
    return n_marks;
}

static set_marks find_marks(const io_model *model, const io_view_blocks *blocks) {
    set_marks marks = {.has_references = !model->groups_by_name};
    for (int i = 0; i < N_WORDS; i++)
        marks.n[i] = count_marks(model, words[i]);
    for (int64_t b = 0; b < blocks->n && marks.has_references; b++)
        if (blocks->block[b].reference > marks.largest)
            marks.largest = blocks->block[b].reference;
    return marks;
}

/** Put the name of a set that is none of the mesh. */
static void put_own_name(io_writer *writer, const set_marks *marks, int word, int64_t number) {
    io_put_text(writer, words[word]);
    for (int i = 0; i < marks->n[word]; i++)
        io_put_text(writer, "_");
    io_put_integer(writer, 0, number);
    io_put_text(writer, "\n");
}

/** Note that numbers that are not positive are not in the names of sets. */
static void lose_negative(const io_view *view, const io_view_blocks *blocks, io_losses *losses) {
    int is_lost = 0;
    for (int64_t b = 0; b < blocks->n; b++)
        is_lost |=
            blocks->block[b].reference <= 0 && io_view_loses_region(view, &blocks->block[b], 0);
    if (is_lost)
        io_losses_add(losses, "numbers of regions");
}

/** Put the name of the set that a block is of. */
static void put_set(io_writer *writer, const set_marks *marks, const io_view_block *block) {
    const int has_reference = marks->has_references && block->reference > 0;
    put_own_name(writer, marks, block->dim,
                 has_reference ? block->reference : marks->largest + block->set);
}

static void put_nodes(io_writer *writer, const io_view *view) {
    const io_model *model = view->model;
    const int is_float = model->precision == PLANISH_PRECISION_FLOAT;
    double place[3];
    io_put_text(writer, "*NODE\n");
    for (int64_t i = 0; i < model->n_nodes; i++) {
        io_view_place(view, i, place);
        io_put_integer(writer, 0, io_view_node_number(view, i));
        for (int d = 0; d < 3; d++) {
            io_put_text(writer, ",");
            io_put_real(writer, ' ', place[d], is_float);
        }
        io_put_text(writer, "\n");
    }
}

/** Put elements; lines end with a comma where an element goes on in the next one. */
static void put_block(io_writer *writer, const io_view *view, const set_marks *marks,
                      const io_view_block *block, const io_view_type *type) {
    enum { ITEMS = 16 };
    io_view_cell cell;
    io_put_format(writer, "*ELEMENT, TYPE=%s, ELSET=", type->name);
    put_set(writer, marks, block);
    for (int64_t i = 0; i < block->n; i++) {
        io_view_cell_at(view, block->cell[i], &cell);
        io_view_fit_cell(view, type, abaqus_node_orders, &cell);
        io_put_integer(writer, 0, io_view_cell_number(view, block->cell[i], &cell));
        for (int k = 0; k < cell.n_nodes; k++) {
            io_put_text(writer, (k + 1) % ITEMS == 0 ? ",\n" : ", ");
            io_put_integer(writer, 0, io_view_node_number(view, cell.node[k]));
        }
        io_put_text(writer, "\n");
    }
}

/* ---- groups --------------------------------------------------------------------------------- */

/* No group can be what others of its number are written by: there are no others; names are shared. */
enum { ONLY_GROUP = -1, NO_LISTED = -2 };

/** Members of groups: of the first group of each number blocks that begin a set, or nodes. */
typedef struct group_members {
    int64_t *start, *end; /* [n_groups + 1] of each group in member; end: so far */
    int64_t *member;
    int32_t *listed; /* [n_groups] of the first group of each number: the group of this number whose
                        name no other group has, or ONLY_GROUP, or NO_LISTED */
} group_members;

/** Put a thing into the groups of an entity that have its dimension: count it, or list it. */
static void add_member(const io_view *view, int32_t entity, int64_t thing, group_members *m) {
    for (int k = 0; k < io_view_n_numbers(view, entity); k++) {
        const int32_t group = io_view_group_at(view, entity, k);
        if (group < 0 || (m->member && m->end[group] > m->start[group] &&
                          m->member[m->end[group] - 1] == thing)) /* a number that it has twice */
            continue;
        if (m->member)
            m->member[m->end[group]] = thing;
        m->end[group]++;
    }
}

/** Put all blocks and nodes into their groups. */
static void add_members(const io_view *view, const io_view_blocks *blocks, group_members *m) {
    const io_model *model = view->model;
    for (int64_t b = 0; b < blocks->n; b++)
        if (blocks->block[b].begins_set)
            add_member(view, blocks->block[b].entity, b, m);
    for (int64_t i = 0; i < model->n_nodes && model->node_entity; i++)
        add_member(view, model->node_entity[i], i, m);
}

/** Return whether '_' stands in a name in place of other characters. */
static int has_replaced(const char *name) {
    while (*name && !is_replaced(*name))
        name++;
    return *name != '\0';
}

/** Find the groups whose names others have, too, as cut ones may, and those with '_' if it stands for
 *  other characters: *is_shared [n_groups], owned in any case. */
static int find_shared(const io_view *view, uint8_t **is_shared, planish_error *error) {
    const int64_t n = view->model->n_groups;
    int32_t *first;
    int status = io_view_find_names(view, &first, error);
    int any_replaced = 0;
    *is_shared = pl_alloc_zero(n, 1);
    if (!status && !*is_shared)
        status = pl_fail_memory(error, "groups");
    for (int64_t g = 0; g < n && !any_replaced; g++)
        any_replaced = has_replaced(view->model->group[g].name);
    for (int64_t g = 0; g < n && !status; g++) {
        const char *name = view->model->group[g].name;
        if (first[g] < g)
            (*is_shared)[g] = (*is_shared)[first[g]] = 1;
        (*is_shared)[g] |= strlen(name) > IO_VIEW_MOST_NAME || has_replaced(name) ||
                           (any_replaced && strchr(name, '_'));
    }
    pl_free(first);
    return status;
}

/** Find the groups that others of their number can be written by. */
static int find_listed(const io_view *view, group_members *m, planish_error *error) {
    const io_group *group = view->model->group;
    const int64_t n = view->model->n_groups;
    uint8_t *is_shared;
    int status = find_shared(view, &is_shared, error);
    m->listed = pl_alloc(n, sizeof *m->listed);
    if (!status && !m->listed)
        status = pl_fail_memory(error, "groups");
    for (int32_t g = 0; g < n && !status; g++) {
        const int32_t first = io_view_first_group(view, group[g].dim, group[g].tag);
        int32_t *listed = &m->listed[first]; /* which is not behind g */
        if (first == g)
            *listed = ONLY_GROUP;
        else if (*listed == ONLY_GROUP)
            *listed = is_shared[first] ? NO_LISTED : first;
        if (first < g && *listed == NO_LISTED && !is_shared[g])
            *listed = g;
    }
    pl_free(is_shared);
    return status;
}

/** Find the members of all groups. To be released in any case. */
static int find_members(const io_view *view, const io_view_blocks *blocks, group_members *m,
                        planish_error *error) {
    const int64_t n = view->model->n_groups;
    *m = (group_members){.start = pl_alloc_zero(n + 1, sizeof *m->start),
                         .end = pl_alloc_zero(n + 1, sizeof *m->end)};
    if (!m->start || !m->end)
        return pl_fail_memory(error, "groups");
    add_members(view, blocks, m);
    for (int64_t g = 0; g < n; g++) {
        m->start[g + 1] = m->start[g] + m->end[g];
        m->end[g] = m->start[g];
    }
    m->member = pl_alloc(m->start[n], sizeof *m->member);
    if (!m->member)
        return pl_fail_memory(error, "groups");
    add_members(view, blocks, m);
    return find_listed(view, m, error);
}

static void release_members(group_members *m) {
    pl_free(m->listed);
    pl_free(m->start);
    pl_free(m->end);
    pl_free(m->member);
}

static void put_keyword(io_writer *writer, const io_group *group) {
    io_put_text(writer, group->dim > 0 ? "*ELSET, ELSET=" : "*NSET, NSET=");
}

/** Put the members of a number, of which first is the first group: sets of entities, or nodes. */
static void put_members(io_writer *writer, const io_view *view, const io_view_blocks *blocks,
                        const set_marks *marks, const group_members *m, int32_t first) {
    for (int64_t i = m->start[first]; i < m->end[first]; i++) {
        if (view->model->group[first].dim > 0) {
            put_set(writer, marks, &blocks->block[m->member[i]]);
            continue;
        }
        io_put_integer(writer, 0, io_view_node_number(view, m->member[i]));
        io_put_text(writer, "\n");
    }
}

/** Put the name of the set that groups of one number are written by. */
static void put_listed(io_writer *writer, const io_view *view, const set_marks *marks,
                       const group_members *m, int32_t first) {
    if (m->listed[first] >= 0)
        put_name(writer, view->model->group[m->listed[first]].name);
    else
        put_own_name(writer, marks, GROUP, first + 1);
}

/** Put a group: its members, or the set that it and the others of its number are written by, so that no
 *  members are written twice. The first group puts that set. */
static void put_group(io_writer *writer, const io_view *view, const io_view_blocks *blocks,
                      const set_marks *marks, const group_members *m, int32_t g) {
    const io_group *group = &view->model->group[g];
    const int32_t first = io_view_first_group(view, group->dim, group->tag);
    const int is_only = m->listed[first] == ONLY_GROUP;
    if (m->end[first] == m->start[first])
        return;
    if (g == first && !is_only) {
        put_keyword(writer, group);
        put_listed(writer, view, marks, m, first);
        put_members(writer, view, blocks, marks, m, first);
    }
    if (g == m->listed[first])
        return;
    put_keyword(writer, group);
    put_name(writer, group->name);
    if (is_only)
        put_members(writer, view, blocks, marks, m, first);
    else
        put_listed(writer, view, marks, m, first);
}

static int put_groups(io_writer *writer, const io_view *view, const io_view_blocks *blocks,
                      const set_marks *marks, planish_error *error) {
    group_members m;
    const int status = find_members(view, blocks, &m, error);
    for (int32_t g = 0; g < view->model->n_groups && !status; g++)
        put_group(writer, view, blocks, marks, &m, g);
    release_members(&m);
    return status;
}

/* ---- the file ------------------------------------------------------------------------------- */

static void put_mesh(io_writer *writer, const io_view *view, const io_view_blocks *blocks,
                     const set_marks *marks, const io_view_type *types) {
    io_put_text(writer, "*HEADING\nwritten by planish\n");
    put_nodes(writer, view);
    for (int64_t b = 0; b < blocks->n; b++) {
        const io_view_type *type = io_view_find_type(types, blocks->block[b].type);
        if (type)
            put_block(writer, view, marks, &blocks->block[b], type);
    }
}

/** Note the types of an Abaqus file that have another name now: C3D8R is C3D8. */
static void lose_type_names(const io_view *view, const io_view_type *types, io_losses *losses) {
    const io_model *model = view->model;
    for (int64_t i = 0; i < model->n_type_names; i++) {
        const io_type_name *old = &model->type_name[i];
        const io_view_type *now = io_view_find_type(types, old->type);
        if (now && strcmp(now->name, old->name) != 0)
            io_losses_add(losses, "the type %s (now %s)", old->name, now->name);
    }
}

/** Note names that are longer than Abaqus takes them, those that are cut, and those with other characters. */
static void lose_names(const io_model *model, io_losses *losses) {
    enum { MOST_NAME = 80 };
    int64_t n_long = 0;
    for (int32_t i = 0; i < model->n_groups; i++)
        n_long += strlen(model->group[i].name) > MOST_NAME;
    io_view_lose_quotes(model, 0, losses);
    if (n_long > 0)
        io_losses_add(losses,
                      "names that Abaqus takes (of at most %d characters) for %" PRId64 " group%s",
                      MOST_NAME, n_long, n_long > 1 ? "s" : "");
    io_view_lose_ends(model, losses);
}

static int abaqus_write(const io_view *view, pl_output *output, io_losses *losses,
                        planish_error *error) {
    const io_view_type *types = view->model->dim == 2 ? plane_types : solid_types;
    io_writer writer;
    io_view_blocks blocks;
    int status = io_view_blocks_make(view, &blocks, error);
    io_writer_begin(&writer, output, error);
    if (!status) {
        const set_marks marks = find_marks(view->model, &blocks);
        put_mesh(&writer, view, &blocks, &marks, types);
        status = put_groups(&writer, view, &blocks, &marks, error);
        io_view_lose_types(types, &blocks, losses);
        lose_type_names(view, types, losses);
        lose_names(view->model, losses);
        io_view_lose_references(view, losses);
        io_view_lose_tags(view, &blocks, 0, 1, losses);
        lose_negative(view, &blocks, losses);
        io_view_lose_fields(view, losses);
    }
    io_view_blocks_release(&blocks);
    return io_writer_end(&writer) ? writer.status : status;
}

const io_target abaqus_targets[] = {{"abaqus", abaqus_write}, {NULL, NULL}};
