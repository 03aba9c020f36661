/* cgns_groups: which elements and nodes of a CGNS file are called what.
 *
 * A cell belongs to its section, and to each boundary condition that lists it. Cells of one section
 * and the same conditions are a class, which becomes an entity of the model; its names are those of
 * the section, of the conditions and of their families. Nodes in conditions have classes, too.
 */
#ifdef PL_HDF5
#include "io/cgns/cgns_reader.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

enum { NAME_SIZE = 128, NONE = -1 };

/* Conditions that list all elements so many times over are no mesh's. */
enum { MOST_LISTINGS = 64 };

/** Cells or nodes with the same names: those of class before, and condition. */
typedef struct cell_class {
    int32_t before;    /* class, or NONE */
    int32_t condition; /* or NONE: a section's class, or that of all other nodes */
    int32_t moved;     /* class that this one's members in the present condition go to, or NONE */
    int32_t moved_by;  /* the condition that this is for */
} cell_class;

typedef struct condition {
    const char *name;
    char family[NAME_SIZE]; /* or "" */
} condition;

typedef struct groups {
    cgns_reader *r;
    cell_class *class; /* [n_classes] those of the sections first */
    int64_t n_classes, class_capacity;
    condition *condition; /* [n_conditions] */
    int64_t n_conditions, condition_capacity;
    int32_t other_nodes; /* class of nodes in no condition */
    int64_t listed;      /* elements and nodes in all conditions */
} groups;

/* ---- classes ------------------------------------------------------------------------------ */

static int add_class(groups *g, int32_t before, int32_t in_condition, int32_t *index) {
    const cell_class class = {before, in_condition, NONE, NONE};
    *index = (int32_t)g->n_classes;
    return g->n_classes < INT32_MAX - 1 &&
                   pl_append(&g->class, &g->n_classes, &g->class_capacity, &class, sizeof class)
               ? PLANISH_OK
               : pl_fail_memory(g->r->error, "the groups of the file");
}

/** Move a member of *class to the one whose members are in the condition, too. */
static int move_member(groups *g, int32_t in_condition, int32_t *class) {
    int32_t index = g->class[*class].moved;
    if (g->class[*class].condition == in_condition) /* listed twice */
        return PLANISH_OK;
    if (g->class[*class].moved_by != in_condition) {
        const int status = add_class(g, *class, in_condition, &index);
        if (status)
            return status;
        g->class[*class].moved = index;
        g->class[*class].moved_by = in_condition;
    }
    *class = index;
    return PLANISH_OK;
}

/* ---- elements by their number -------------------------------------------------------------- */

/** Find the element of that number: its list and *index, or 0 if it is in none. */
static int find_cell(const cgns_reader *r, int64_t number, int64_t *index) {
    int64_t low = 0, high = r->n_sections; /* the first that begins behind number is in there */
    while (low < high) {
        const int64_t middle = low + (high - low) / 2;
        if (r->section[middle].start <= number)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == 0 || number > r->section[low - 1].end)
        return 0;
    const cgns_section *s = &r->section[low - 1];
    for (int k = IO_FIRST_LIST; k < IO_N_LISTS; k++) {
        const io_list list = io_model_list(r->model, k);
        low = s->first[k];
        high = s->behind[k];
        while (low < high) {
            const int64_t middle = low + (high - low) / 2;
            if (io_list_number(&list, middle) < number)
                low = middle + 1;
            else
                high = middle;
        }
        *index = low;
        if (low < s->behind[k] && io_list_number(&list, low) == number)
            return k;
    }
    return 0;
}

/* ---- lists of elements or nodes ------------------------------------------------------------ */

/** Put an element or node that a list names in a condition; without one (NONE), its nodes are
 *  joined with others of the zone, and stay. */
static int take_member(groups *g, const char *path, int is_nodes, int64_t number,
                       int32_t in_condition) {
    io_model *model = g->r->model;
    int64_t index = number - 1;
    const int list = is_nodes ? 0 : find_cell(g->r, number, &index);
    if (is_nodes && (number < 1 || number > model->n_nodes))
        return io_hdf5_fail(g->r->file, path, "node %lld is not in 1 .. %lld", (long long)number,
                            (long long)model->n_nodes);
    /* Conditions may list faces of structured or polyhedral parts that are not there. */
    if (!is_nodes && list == 0)
        return PLANISH_OK;
    const io_list elements = io_model_list(model, is_nodes ? IO_FIRST_LIST : list);
    if (in_condition != NONE)
        return move_member(g, in_condition,
                           is_nodes ? &model->node_entity[index] : &elements.entity[index]);
    int32_t node[IO_CELL_NODES] = {(int32_t)index};
    const int n = is_nodes ? 1 : io_list_nodes(&elements, index, node, NULL);
    for (int j = 0; j < n; j++)
        io_hold_node(model, node[j], IO_HELD_REQUIRED);
    return PLANISH_OK;
}

/** Take all members of a list of numbers, or of the range that two numbers are. */
static int take_list(groups *g, const char *path, int is_nodes, int is_range,
                     const io_hdf5_integers *list, int32_t in_condition) {
    const io_model *model = g->r->model;
    const int64_t all = model->n_nodes + model->line.n + model->triangle.n + model->tetrahedron.n +
                        model->n_other + model->n_lower;
    int64_t first = 0, n = list->n;
    if (is_range) {
        if (list->n != 2)
            return io_hdf5_fail(g->r->file, path, "two numbers were expected");
        first = io_hdf5_integer(list, 0);
        const int64_t last = io_hdf5_integer(list, 1);
        if (first < 1 || last < first - 1 || last == INT64_MAX)
            return io_hdf5_fail(g->r->file, path, "%lld to %lld is not a range", (long long)first,
                                (long long)last);
        n = last - first + 1;
    }
    if (n > MOST_LISTINGS * all - g->listed)
        return io_hdf5_fail(g->r->file, path,
                            "conditions up to this one list elements and nodes more than %d times "
                            "over; the file is damaged",
                            MOST_LISTINGS);
    g->listed += n;
    int status = PLANISH_OK;
    for (int64_t i = 0; i < n && !status; i++)
        status = take_member(g, path, is_nodes, is_range ? first + i : io_hdf5_integer(list, i),
                             in_condition);
    return status;
}

/** Take all that a node of CGNS lists: points, which are nodes or elements by its GridLocation, and
 *  elements. */
static int take_members(groups *g, const io_hdf5_path *path, int32_t in_condition) {
    static const struct {
        const char *name;
        int is_points, is_range;
    } lists[] = {{"PointList", 1, 0},
                 {"PointRange", 1, 1},
                 {"PointListDonor", 1, 0},
                 {"ElementList", 0, 0},
                 {"ElementRange", 0, 1}};
    io_model *model = g->r->model;
    char location[NAME_SIZE] = "";
    int status = cgns_text(g->r, path, "GridLocation", location, sizeof location);
    const int is_vertex = !location[0] || strcmp(location, "Vertex") == 0;
    for (size_t i = 0; i < sizeof lists / sizeof *lists && !status; i++) {
        io_hdf5_integers numbers = {0};
        const io_hdf5_path child = cgns_child(g->r, path, lists[i].name);
        if (io_hdf5_kind_of(g->r->file, child.text) != IO_HDF5_GROUP)
            continue;
        const int is_nodes = lists[i].is_points && is_vertex;
        status = cgns_integers(g->r, &child, &numbers);
        if (!status && is_nodes && !model->node_entity) { /* classes of nodes begin */
            model->node_entity = pl_alloc(model->n_nodes, sizeof *model->node_entity);
            status = model->node_entity ? add_class(g, NONE, NONE, &g->other_nodes)
                                        : pl_fail_memory(g->r->error, "the groups of nodes");
            for (int64_t k = 0; k < model->n_nodes && !status; k++)
                model->node_entity[k] = g->other_nodes;
        }
        if (!status)
            status = take_list(g, child.text, is_nodes, lists[i].is_range, &numbers, in_condition);
        io_hdf5_integers_release(&numbers);
    }
    return status;
}

/* ---- conditions and connections ------------------------------------------------------------ */

/** Take the members of all children with a label, of children of the zone with another; these are
 *  conditions or connections. */
static int read_lists(groups *g, const char *label, const char *of, int are_conditions) {
    io_hdf5_names outer, inner;
    int status = cgns_children(g->r, &g->r->zone, of, &outer);
    for (int64_t i = 0; i < outer.n && !status; i++) {
        const io_hdf5_path group = cgns_child(g->r, &g->r->zone, outer.name[i]);
        status = cgns_children(g->r, &group, label, &inner);
        for (int64_t j = 0; j < inner.n && !status; j++) {
            const io_hdf5_path path = cgns_child(g->r, &group, inner.name[j]);
            const condition named = {.name = inner.name[j]};
            condition *c = are_conditions ? pl_append(&g->condition, &g->n_conditions,
                                                      &g->condition_capacity, &named, sizeof named)
                                          : NULL;
            if (are_conditions && !c)
                return pl_fail_memory(g->r->error, "the groups of the file");
            if (c)
                status = cgns_text(g->r, &path, "FamilyName", c->family, sizeof c->family);
            if (!status)
                status = take_members(g, &path, c ? (int32_t)g->n_conditions - 1 : NONE);
        }
    }
    return status;
}

/* ---- entities and names -------------------------------------------------------------------- */

/** Replace each class in a dimension by its entity, of tag class + 1; members of the class none
 * have no entity. */
static int index_entities(groups *g, int dim, int32_t *class, int64_t n, int32_t none) {
    for (int64_t i = 0; i < n; i++)
        class[i]++;
    return io_model_index_tags_but(g->r->model, dim, none + 1, class, n, g->r->error);
}

/** Give the entities of a class a name. */
static int add_name(groups *g, int32_t class, const char *name) {
    int status = PLANISH_OK;
    for (int dim = 0; dim <= 3 && !status && name[0]; dim++)
        if (io_model_has_entity(g->r->model, dim, class + 1))
            status = io_model_group(g->r->model, dim, class + 1, name, (int64_t)strlen(name),
                                    g->r->error);
    return status;
}

/** Make entities of classes, in place, and give them names: of their conditions, the families of
 *  these and their section. */
static int make_entities(groups *g) {
    io_model *model = g->r->model;
    int status = PLANISH_OK;
    for (int dim = 3; dim >= 1 && !status; dim--) {
        const io_list cells = io_model_list(model, dim);
        const io_list others = io_model_list(model, io_others_list(dim));
        status = index_entities(g, dim, cells.entity, cells.n, NONE);
        if (!status && dim > 1)
            status = index_entities(g, dim, others.entity, others.n, NONE);
    }
    if (!status && model->node_entity)
        status = index_entities(g, 0, model->node_entity, model->n_nodes, g->other_nodes);
    for (int32_t k = 0; k < g->n_classes && !status; k++) {
        int32_t at = k;
        for (; g->class[at].condition != NONE && !status; at = g->class[at].before) {
            const condition *c = &g->condition[g->class[at].condition];
            status = add_name(g, k, c->name);
            if (!status && strcmp(c->family, c->name) != 0)
                status = add_name(g, k, c->family);
        }
        if (!status && at < g->r->n_sections)
            status = add_name(g, k, g->r->section[at].name);
    }
    return status;
}

int cgns_read_groups(cgns_reader *r) {
    groups g = {.r = r, .other_nodes = NONE};
    int32_t index;
    int status = PLANISH_OK;
    for (int64_t i = 0; i < r->n_sections && !status; i++)
        status = add_class(&g, NONE, NONE, &index);
    if (!status)
        status = read_lists(&g, "BC_t", "ZoneBC_t", 1);
    if (!status)
        status = read_lists(&g, "GridConnectivity_t", "ZoneGridConnectivity_t", 0);
    if (!status)
        status = make_entities(&g);
    pl_free(g.condition);
    pl_free(g.class);
    return status;
}

#endif
